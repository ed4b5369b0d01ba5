//! Whether the levels of open boundaries and of the ends of channels fit the bed over which the water comes in.

use crate::boundary::{Series, Strip};
use crate::error::{Problem, ProblemKind, input_error};
use crate::math::readable;
use crate::scenario::Timed;

/// An inflow of a greater Froude number is worth a warning: below gates and on chutes it is less as a rule.
const FAST: f64 = 5.0;
/// A share of the time between two points that is as good as none.
const JUST: f64 = 1e-9;

/// Where water comes in: its name in a message, the strips across the flow, the acceleration of gravity (m/s²) and the end of the run (s).
#[derive(Clone, Copy, Debug)]
pub struct Inlet<'a> {
    pub name: &'a str,
    pub strips: &'a [Strip],
    pub gravity: f64,
    pub end: f64,
}

/// Area (m²) and width (m) of the water in a section.
#[derive(Default)]
struct Water {
    area: f64,
    width: f64,
}

impl Inlet<'_> {
    /// Elevation of the lowest strip (m).
    pub fn lowest(&self) -> f64 {
        self.strips.iter().filter(|strip| strip.width > 0.0).map(|strip| strip.bed).fold(f64::INFINITY, f64::min)
    }

    /// The water at a level (m).
    fn water(&self, level: f64) -> Water {
        let wet = self.strips.iter().filter(|strip| strip.bed < level);
        wet.fold(Water::default(), |sum, strip| Water {
            area: sum.area + strip.width * (level - strip.bed),
            width: sum.width + strip.width,
        })
    }

    /// The times of the points of two series within the run, each with the one after it (s).
    fn spans(&self, series: [&Series; 2]) -> Vec<[f64; 2]> {
        let mut times: Vec<f64> = series.iter().flat_map(|series| series.points()).map(|point| point.0).collect();
        times.retain(|time| (0.0..=self.end).contains(time));
        times.extend([0.0, self.end]);
        times.sort_by(f64::total_cmp);
        times.dedup();
        times.windows(2).map(|pair| [pair[0], pair[1]]).collect()
    }
}

/// The words for a moment of a run, empty where nothing changes over time.
fn at_moment(level: &Timed, time: f64) -> String {
    match level {
        Timed::Constant(_) => String::new(),
        Timed::Series(_) => format!(" at {} s", readable(time)),
    }
}

/// What comes in by an inlet over time.
#[derive(Clone, Copy)]
pub struct Inflow<'a> {
    /// Discharge (m³/s).
    pub discharge: &'a Series,
    /// Level (m) that counts where it is supercritical.
    pub level: &'a Series,
}

/// Refuses a level that is not above the bed while a discharge comes in, and warns of one so low that the inflow is a jet.
pub fn check_inflow(level: &Timed, inflow: Inflow<'_>, inlet: Inlet<'_>) -> Option<Problem> {
    let Inflow { discharge: discharges, level: levels } = inflow;
    let spans = inlet.spans([discharges, levels]);
    let comes_in = |time: &f64| discharges.at(*time) > 0.0;
    // Just beside a point at which it begins or ends to come in the level may be below the bed, too.
    let beside = |[from, to]: &[f64; 2]| [*from, from + JUST * (to - from), to - JUST * (to - from), *to];
    let dry = spans.iter().flat_map(beside).filter(comes_in).find(|time| levels.at(*time) <= inlet.lowest());
    if let Some(time) = dry {
        let message = format!(
            "the level of {} m{} is not above the lowest bed of {}, {} m, while water comes in",
            readable(levels.at(time)),
            at_moment(level, time),
            inlet.name,
            readable(inlet.lowest())
        );
        let remedy =
            "correct the level, its unit or its datum; it may be left out where the inflow is not supercritical";
        return Some(
            input_error("level-below-bed", message).with_cause("nothing comes in at such a level").with_remedy(remedy),
        );
    }
    let between = |[from, to]: &[f64; 2]| [*from, 0.5 * (from + to), *to];
    let jet = |time: f64| {
        let Water { area, width } = inlet.water(levels.at(time));
        let (depth, velocity) = (area / width, discharges.at(time) / area);
        (velocity / (inlet.gravity * depth).sqrt(), time, depth, velocity)
    };
    let jets = spans.iter().flat_map(between).filter(comes_in).map(jet);
    let (froude, time, depth, velocity) = jets.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|jet| jet.0 > FAST)?;
    let message = format!(
        "at the level of {} m{} {} m3/s come in {} m deep and at {velocity:.1} m/s, with a Froude number of {froude:.1}",
        readable(levels.at(time)),
        at_moment(level, time),
        readable(discharges.at(time)),
        readable(depth)
    );
    let problem = Problem::warning(ProblemKind::Input, "fast-inflow", "", message)
        .with_cause(format!("the lowest bed of {} is at {} m", inlet.name, readable(inlet.lowest())))
        .with_remedy("correct the level or the discharge and their units, if the water is not to shoot in like this");
    Some(problem)
}

/// Refuses a level that is held and never above the bed, and warns of one that is below it for a time.
pub fn check_stage(level: &Timed, levels: &Series, inlet: Inlet<'_>) -> Option<Problem> {
    let lowest = inlet.lowest();
    let moments: Vec<f64> = inlet.spans([levels, levels]).into_iter().flatten().collect();
    let highest = moments.iter().map(|time| levels.at(*time)).fold(f64::NEG_INFINITY, f64::max);
    let remedy =
        "correct the level, its unit or its datum; where the water falls freely over the end, write `type: free`";
    if highest <= lowest {
        let held = readable(highest);
        let message = format!(
            "the level of {held} m that is held is not above the lowest bed of {}, {} m",
            inlet.name,
            readable(lowest)
        );
        return Some(input_error("level-below-bed", message).with_cause("no water comes in there").with_remedy(remedy));
    }
    let deepest = moments.into_iter().min_by(|a, b| levels.at(*a).total_cmp(&levels.at(*b)))?;
    (levels.at(deepest) < lowest).then(|| {
        let message = format!(
            "the level that is held falls to {} m{}, below the lowest bed of {}, {} m",
            readable(levels.at(deepest)),
            at_moment(level, deepest),
            inlet.name,
            readable(lowest)
        );
        Problem::warning(ProblemKind::Input, "level-below-bed", "", message)
            .with_cause("as long as it is below the bed no water comes in, and what is there falls over the end")
            .with_remedy(remedy)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Severity;
    use crate::scenario::Sourced;

    /// A step: 2 m wide at 10 m, 3 m wide at 11 m.
    const STRIPS: [Strip; 2] = [Strip { width: 2.0, bed: 10.0 }, Strip { width: 3.0, bed: 11.0 }];

    fn inlet() -> Inlet<'static> {
        Inlet { name: "the end", strips: &STRIPS, gravity: 9.81, end: 100.0 }
    }

    fn constant() -> Timed {
        Timed::Constant(Sourced { value: 0.0, key: "level".to_owned(), place: None })
    }

    fn found(problem: Option<Problem>) -> Option<(&'static str, Severity)> {
        problem.map(|problem| (problem.code, problem.severity))
    }

    #[test]
    fn a_level_is_measured_against_the_bed_while_water_comes_in() {
        let rising = Series::new(&[(0.0, 0.0), (50.0, 8.0), (100.0, 8.0)]).unwrap();
        let refused = Some(("level-below-bed", Severity::Error));
        let fast = Some(("fast-inflow", Severity::Warning));
        for (levels, expected) in [
            (vec![(0.0, 10.0), (50.0, 12.0)], None),
            (vec![(0.0, 9.9), (50.0, 12.0)], refused),
            (vec![(0.0, 8.0), (1.0, 10.0), (50.0, 12.0)], refused),
            (vec![(0.0, 12.0), (100.0, 10.0)], refused),
            // What lies beyond the run does not matter.
            (vec![(0.0, 12.0), (100.0, 12.0), (101.0, 0.0)], None),
            (vec![(0.0, 10.01), (100.0, 10.01)], fast),
        ] {
            let levels = Series::new(&levels).unwrap();
            assert_eq!(
                found(check_inflow(&constant(), Inflow { discharge: &rising, level: &levels }, inlet())),
                expected,
                "{levels:?}"
            );
        }
    }

    #[test]
    fn the_froude_number_is_that_of_the_whole_section() {
        // At 12 m: 2·2 + 3·1 = 7 m² on 5 m. Froude 5 is 5·√(9.81·7/5)·7 = 129.7 m³/s.
        let level = Series::constant(12.0);
        for (discharge, is_fast) in [(129.0, false), (130.0, true)] {
            let problem =
                check_inflow(&constant(), Inflow { discharge: &Series::constant(discharge), level: &level }, inlet());
            assert_eq!(problem.is_some(), is_fast, "{discharge}: {problem:?}");
        }
        let (discharge, level) = (Series::constant(8.0), Series::constant(10.01));
        let jet = check_inflow(&constant(), Inflow { discharge: &discharge, level: &level }, inlet()).unwrap();
        assert!(jet.message.contains("8 m3/s come in 0.01 m deep and at 400.0 m/s"), "{jet}");
    }

    #[test]
    fn a_held_level_may_fall_below_the_bed_for_a_time() {
        for (levels, expected) in [
            (vec![(0.0, 10.0), (100.0, 9.0)], Some(("level-below-bed", Severity::Error))),
            (vec![(0.0, 11.0), (60.0, 9.0), (100.0, 11.0)], Some(("level-below-bed", Severity::Warning))),
            (vec![(0.0, 11.0), (100.0, 10.0)], None),
            (vec![(-9.0, 1.0), (0.0, 11.0), (100.0, 11.0), (200.0, 1.0)], None),
        ] {
            let series = Series::new(&levels).unwrap();
            assert_eq!(found(check_stage(&constant(), &series, inlet())), expected, "{levels:?}");
        }
    }
}
