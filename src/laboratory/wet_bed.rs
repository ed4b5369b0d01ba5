//! A round column of water that collapses over a wet bed, against a computation on a grid eight times as fine.

use super::Finding;
use super::gauges::{Run, Series, listed, panel, value_at};
use crate::maps::{GaugePanel, PanelAxis};

/// Mean relative errors that a good model keeps at 1 m (those of SWALS, from which the reference comes): of levels, of speeds and fluxes.
const BARS: (f64, f64) = (0.03, 0.10);
/// A level above this (m) is that of the wave: the water before it stands at 1 m.
const WAVE: f64 = 1.01;
/// The reference, over x.
const REFERENCE: &str = "reference_t2s.csv";

/// Levels, speeds and fluxes along the line through the middle at the end, and the greatest until then.
pub(super) fn judge(run: &Run) -> Result<Finding, String> {
    let places = places(run)?;
    let at_end = |column: &str| -> Result<Series, String> {
        let last = |(gauge, x): &(String, f64)| {
            let value = run.series(gauge, column)?.last().map_or(f64::NAN, |point| point.1);
            Ok((*x, value))
        };
        places.iter().map(last).collect()
    };
    let greatest = |column: &str| -> Result<Series, String> {
        places.iter().map(|(gauge, x)| Ok((*x, run.result(gauge, column)?.unwrap_or(0.0)))).collect()
    };
    let levels = at_end("level_m")?;
    let velocities = at_end("velocity_x_m_s")?;
    let depths = at_end("depth_m")?;
    let fluxes: Series = velocities.iter().zip(&depths).map(|(u, d)| (u.0, u.1 * d.1)).collect();
    let speeds = velocities.iter().map(|(x, u)| (*x, u.abs())).collect();
    let compared = [
        ("level at 2 s (m)", "level_m", levels.clone()),
        ("speed at 2 s (m/s)", "velocity_ms", speeds),
        ("flux at 2 s (m²/s)", "qx_m2s", fluxes),
        ("greatest level (m)", "max_level_m", greatest("max_level_m")?),
        ("greatest speed (m/s)", "max_speed_ms", greatest("max_speed_m_s")?),
    ];
    let (mut notes, mut panels, mut is_met, mut level_error) = (Vec::new(), Vec::new(), true, None);
    for (title, column, computed) in compared {
        let reference = run.measured(REFERENCE, "x", column)?;
        let error = mean_relative(&computed, &reference)?;
        let is_level = column.contains("level");
        is_met &= error <= if is_level { BARS.0 } else { BARS.1 };
        level_error = level_error.or(Some(error));
        notes.push(format!("{title} {:.2} %", 100.0 * error));
        let (from, to) = (computed.first().map_or(0.0, |point| point.0), computed.last().map_or(0.0, |point| point.0));
        let reference = reference.into_iter().filter(|(x, _)| (from..=to).contains(x)).collect();
        panels.push(GaugePanel { axis: PanelAxis::Place, ..panel(run, title, reference, computed) });
    }
    let seen = front(&run.measured(REFERENCE, "x", "level_m")?);
    let found = front(&levels);
    let note = format!(
        "mean error by the mean of the reference: {}; front at x in m (reference): {:.1} ({:.1}) and {:.1} ({:.1})",
        listed(&notes),
        found.0,
        seen.0,
        found.1,
        seen.1
    );
    Ok(Finding { norm: "mean_relative", error: level_error, is_met: Some(is_met), note, panels })
}

/// The gauges and their places along the line, from west to east.
fn places(run: &Run) -> Result<Vec<(String, f64)>, String> {
    let mut places = run.places()?;
    places.sort_by(|a, b| a.1.total_cmp(&b.1));
    if places.is_empty() { Err("the run has no gauges".to_owned()) } else { Ok(places) }
}

/// Σ |computed − reference| / Σ |reference| at the places of the computed values.
fn mean_relative(computed: &Series, reference: &Series) -> Result<f64, String> {
    let (mut off, mut all) = (0.0, 0.0);
    for (x, value) in computed {
        let expected = value_at(reference, *x).ok_or("the reference is empty")?;
        off += (value - expected).abs();
        all += expected.abs();
    }
    Ok(off / all)
}

/// The first and the last place (m) of the wave, between two places by the straight line through their levels.
fn front(levels: &Series) -> (f64, f64) {
    let crossing = |a: &(f64, f64), b: &(f64, f64)| {
        ((a.1 > WAVE) != (b.1 > WAVE)).then(|| a.0 + (WAVE - a.1) / (b.1 - a.1) * (b.0 - a.0))
    };
    let mut crossings = levels.windows(2).filter_map(|pair| crossing(&pair[0], &pair[1]));
    let first = crossings.next().unwrap_or(f64::NAN);
    (first, crossings.next_back().unwrap_or(first))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_relative_to_the_mean_of_the_reference() {
        let reference = vec![(0.0, 1.0), (10.0, 3.0)];
        assert!((mean_relative(&vec![(0.0, 1.5), (5.0, 2.0), (10.0, 2.0)], &reference).unwrap() - 0.25).abs() < 1e-15);
        assert!(mean_relative(&vec![(0.0, 1.0)], &Vec::new()).is_err());
    }

    #[test]
    fn the_front_is_where_the_level_leaves_that_of_the_water_before_it() {
        let levels = vec![(0.0, 1.0), (10.0, 1.02), (20.0, 3.0), (30.0, 1.03), (40.0, 1.0), (50.0, 1.0)];
        let (west, east) = front(&levels);
        assert!((west - 5.0).abs() < 1e-9 && (east - 110.0 / 3.0).abs() < 1e-9, "{west} {east}");
        assert!(front(&vec![(0.0, 1.0)]).0.is_nan());
    }
}
