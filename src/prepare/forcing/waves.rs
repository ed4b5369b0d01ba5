//! Whether a wave that comes in at a boundary or at the end of a channel fits the still water over which it runs.

use crate::boundary::Series;
use crate::error::{Problem, input_error, input_warning};
use crate::math::readable;

/// Share of the depth by which a wave may differ from the still water at the start: a step of the level sends in a bore.
const STEP: f64 = 0.01;
/// A simple wave of more than this many times the depth of the still water would come in faster than waves run, c_w > 2 c_0.
const HIGH: f64 = 4.0;

/// Where a wave comes in: the lowest ground (m), the level of the water there at the start (m), if there is any, and the end of the run (s).
#[derive(Clone, Copy, Debug)]
pub struct Inlet {
    pub lowest: f64,
    pub start: Option<f64>,
    pub end: f64,
}

/// Refuses a wave over no still water, and warns of one that begins with a step or is no simple wave.
pub fn check(wave: &Series, still: Option<&Series>, inlet: Inlet) -> Option<Problem> {
    let Inlet { lowest, start, end } = inlet;
    let level_at = |time: f64| still.map(|still| still.at(time)).or(start);
    let Some(begin) = level_at(0.0) else {
        let problem =
            input_error("wave-without-still", "a wave comes in over ground that is dry at the start".to_owned());
        return Some(problem.with_cause("without the level of the still water its velocity is not known").with_remedy(
            "give that level: `still: 0 m`, or a series such as a tide; or put water there at the start",
        ));
    };
    let times = wave.points().map(|point| point.0).filter(|time| (0.0..end).contains(time)).chain([0.0, end]);
    let depths = times.filter_map(|time| Some((time, wave.at(time) - lowest, level_at(time)? - lowest)));
    let (time, crest, depth) = depths.max_by(|a, b| (a.1 - a.2).total_cmp(&(b.1 - b.2)))?;
    if crest > HIGH * depth.max(0.0) {
        let message = format!(
            "at {} s the wave stands {} m above the lowest ground of this boundary, and the still water {} m",
            readable(time),
            readable(crest),
            readable(depth.max(0.0))
        );
        let problem = input_warning("high-wave", message).with_cause(format!(
            "a wave of more than {HIGH} times the depth would outrun itself; it comes in as critical flow"
        ));
        return Some(problem.with_remedy(
            "correct `wave`, `still`, their units or datums; or write `level` for what is held at the boundary",
        ));
    }
    let first = wave.at(0.0);
    ((first - begin).abs() > STEP * (begin - lowest).max(0.0)).then(|| {
        let message =
            format!("the wave begins at {} m, and the still water is at {} m", readable(first), readable(begin));
        input_warning("wave-begins-with-step", message)
            .with_cause("the difference comes in as a bore at the start")
            .with_remedy(
                "let the series begin at the level of the still water, or correct `still`, its unit or its datum",
            )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_needs_still_water_begins_at_its_level_and_is_a_wave() {
        let wave = |first: f64, crest: f64| Series::new(&[(0.0, first), (5.0, crest), (10.0, 0.0)]).unwrap();
        let inlet = |start: Option<f64>| Inlet { lowest: -1.0, start, end: 10.0 };
        let tide = Series::constant(0.0);
        for (wave, still, start, expected) in [
            (wave(0.0, 0.4), None, Some(0.0), None),
            (wave(0.0, 0.4), Some(&tide), None, None),
            (wave(0.0, 0.4), None, None, Some("wave-without-still")),
            (wave(0.2, 0.4), None, Some(0.0), Some("wave-begins-with-step")),
            (wave(0.2, 0.4), Some(&tide), Some(0.2), Some("wave-begins-with-step")),
            (wave(0.0, 3.1), None, Some(0.0), Some("high-wave")),
            (wave(0.0, 0.1), Some(&Series::constant(-2.0)), None, Some("high-wave")),
        ] {
            let found = check(&wave, still, inlet(start));
            assert_eq!(found.as_ref().map(|problem| problem.code), expected, "{found:?}");
        }
    }
}
