//! The defaults of a scenario that are more than a name: constants, intervals, times of isochrones.

/// Depths (m) for which arrival is mapped unless the scenario says otherwise: first water, ankle, knee.
pub const THRESHOLDS: [f64; 3] = [0.01, 0.10, 0.30];
/// Rise (m) that counts as arrival where there was water at the start.
pub const RISE_ON_WET: f64 = 0.10;
/// Standard gravity as hydraulics rounds it (m/s²).
pub const GRAVITY: f64 = 9.81;
/// Depth (m) below which water does not move.
pub const DRY_DEPTH: f64 = 1e-3;
/// The coarsest spacing of levels over the finest one: three doublings.
pub const COARSEST_TO_FINEST: f64 = 8.0;
/// How far cells are fine on both sides of a line, in lengths of `to`: a strip of some eight cells.
pub const REACH_OF_LINES: f64 = 4.0;
/// Most particles unless the scenario says otherwise.
pub const MAX_PARTICLES: f64 = 50e6;
/// Share of the machine's memory that a run may take.
pub const MEMORY_SHARE: f64 = 0.8;
/// Time between two checkpoints (s) unless the scenario says otherwise.
pub const CHECKPOINT: f64 = 600.0;
/// Times (min) of the isochrones of the first two hours, as planners ask for them.
const EARLY_ISOCHRONES: [f64; 8] = [5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 120.0];
/// Number of frames that a run gets unless the scenario says otherwise.
pub const FRAMES: f64 = 40.0;

/// The interval nearest to the given one (s) that a clock or a ruler shows.
pub fn sensible_interval(interval: f64) -> f64 {
    const CLOCK: [f64; 16] = [
        10.0, 15.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0, 3600.0, 7200.0, 10_800.0, 21_600.0,
        43_200.0,
    ];
    let decade = 10f64.powi((interval.log10().floor() as i32).min(0));
    let below = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * decade);
    let distance = |candidate: f64| (candidate / interval).ln().abs();
    below.into_iter().chain(CLOCK).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or(interval)
}

/// The usual times up to the end of the run (s), then every hour.
pub fn default_isochrones(end_time: f64) -> Vec<f64> {
    let early = EARLY_ISOCHRONES.iter().map(|minutes| minutes * 60.0);
    let hourly = (3..).map(|hours| f64::from(hours) * 3600.0);
    early.chain(hourly).take_while(|time| *time <= end_time).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_those_of_a_clock() {
        let pairs: [(f64, f64); 6] =
            [(100.0, 120.0), (540.0, 600.0), (7.0, 5.0), (0.026, 0.02), (0.8, 1.0), (9e3, 10_800.0)];
        for (interval, expected) in pairs {
            let found = sensible_interval(interval);
            assert_eq!(found.to_bits(), expected.to_bits(), "{interval}: {found}");
        }
        assert_eq!(default_isochrones(4.0 * 3600.0)[6..], [5400.0, 7200.0, 10_800.0, 14_400.0]);
    }
}
