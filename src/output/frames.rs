//! When frames are due, and the water between two compute steps.
//!
//! Output never shortens a time step: a frame at time t between two steps is the linear interpolation of depth and
//! discharge, u(t) = u₀ + (u₁ − u₀)(t − t₀)/(t₁ − t₀), which keeps the volume linear as well.

/// The grids of one moment on the output grid, `[rows * columns]`, row 0 in the north; [`FILL`](super::FILL) where there is
/// no value.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Time (s).
    pub time: f64,
    /// Water depth (m); 0 where dry.
    pub depth: Vec<f32>,
    /// Water level (m); no value where dry.
    pub water_level: Vec<f32>,
    /// Velocity to the east (m/s); 0 where dry.
    pub velocity_x: Vec<f32>,
    /// Velocity to the north (m/s); 0 where dry.
    pub velocity_y: Vec<f32>,
    /// Of each tracer its depth-averaged concentration; no value where dry.
    pub concentrations: Vec<Vec<f32>>,
}

/// The volume balance of the core at one moment (m³).
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Volumes {
    /// Water there.
    pub stored: f64,
    /// What of it is in channels, not on the grid.
    pub in_channels: f64,
    /// Water that came in since the start.
    pub inflow: f64,
    /// Water that left since the start.
    pub outflow: f64,
    /// Relative error of the ledger (dimensionless).
    pub error_relative: f64,
}

impl Volumes {
    /// The volume balance between two moments, `share` of the way from `self` to `later`.
    pub(super) fn between(&self, later: &Volumes, share: f64) -> Volumes {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Volumes {
            stored: mix(self.stored, later.stored),
            in_channels: mix(self.in_channels, later.in_channels),
            inflow: mix(self.inflow, later.inflow),
            outflow: mix(self.outflow, later.outflow),
            error_relative: mix(self.error_relative, later.error_relative),
        }
    }
}

/// One row of `mass_balance.csv`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MassBalanceRow {
    /// Time (s).
    pub time: f64,
    /// The volume balance of the core.
    pub volumes: Volumes,
    /// Sum of depth times area over the output grid (m³), from the values as they are written.
    pub grid_volume: f64,
}

/// The moments at which something is due: the multiples of an interval, and the end of the run.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Schedule {
    interval: f64,
    end: f64,
    next: u64,
    done: bool,
}

impl Schedule {
    /// A schedule from 0 to `end` (s) in steps of `interval` (s, positive).
    pub(super) fn new(interval: f64, end: f64) -> Self {
        Schedule { interval, end, next: 0, done: false }
    }

    /// The next moment that is not later than `time`, if any; asks for each moment once.
    pub(super) fn due(&mut self, time: f64) -> Option<f64> {
        let moment = self.next_until(time)?;
        self.done = moment >= self.end;
        self.next += 1;
        Some(moment)
    }

    /// The same without asking for it: it stays due.
    pub(super) fn next_until(&self, time: f64) -> Option<f64> {
        if self.done {
            return None;
        }
        // The last step is cut to the end of the run and may miss it by rounding.
        let slack = 1e-9 * self.interval;
        let multiple = self.next as f64 * self.interval;
        let moment = if multiple >= self.end - slack { self.end } else { multiple };
        (moment <= time + slack).then_some(moment)
    }
}

/// The share of the way from `before` to `after` at which `time` lies, within 0 to 1; 1 for a step without length.
pub(super) fn share_of_step(time: f64, before: f64, after: f64) -> f64 {
    if after > before { ((time - before) / (after - before)).clamp(0.0, 1.0) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedule_names_each_multiple_and_the_end_once() {
        let mut schedule = Schedule::new(10.0, 35.0);
        let mut moments = Vec::new();
        for time in [0.0, 4.0, 21.0, 34.999_999_999_99] {
            while let Some(next) = schedule.next_until(time) {
                moments.push(schedule.due(time).unwrap());
                assert_eq!(moments.last(), Some(&next));
            }
        }
        assert_eq!(moments, [0.0, 10.0, 20.0, 30.0, 35.0]);
        assert_eq!((schedule.next_until(1e9), schedule.due(1e9)), (None, None));
    }

    #[test]
    fn end_at_a_multiple_is_not_named_twice() {
        let mut schedule = Schedule::new(10.0, 20.0);
        assert_eq!(
            [schedule.due(20.0), schedule.due(20.0), schedule.due(20.0), schedule.due(20.0)],
            [Some(0.0), Some(10.0), Some(20.0), None]
        );
    }
}
