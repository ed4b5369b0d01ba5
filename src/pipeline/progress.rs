//! Progress on stderr, and statistics of the steps.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use crate::lattice::Lattice;
use crate::output::{RunManifest, StepLengths};
use crate::solver::{StepChoice, StepLimit};

/// A line of progress now and then: one that is written over on a terminal, plain lines elsewhere.
pub struct Progress {
    end_time: f64,
    lattice: Lattice,
    is_shown: bool,
    is_terminal: bool,
    start: Instant,
    last: Option<Instant>,
}

impl Progress {
    /// Progress towards `end_time` (s).
    pub fn new(end_time: f64, lattice: &Lattice, is_shown: bool) -> Self {
        let is_terminal = std::io::stderr().is_terminal();
        Progress { end_time, lattice: lattice.clone(), is_shown, is_terminal, start: Instant::now(), last: None }
    }

    /// Shows where the run is, if it is time to: its time (s), its particles, and the error of its water balance.
    pub fn show(&mut self, (time, particles): (f64, usize), choice: &StepChoice, volume_error: impl FnOnce() -> f64) {
        let interval = Duration::from_millis(if self.is_terminal { 500 } else { 10_000 });
        if !self.is_shown || self.last.is_some_and(|last| last.elapsed() < interval) {
            return;
        }
        self.last = Some(Instant::now());
        let share = time / self.end_time;
        let to_go = if share > 0.0 { self.start.elapsed().as_secs_f64() * (1.0 - share) / share } else { 0.0 };
        let place = self.lattice.to_map(choice.position);
        // A run of channels alone has no places on a plane.
        let at = if self.lattice.is_empty() { String::new() } else { format!(" @ {:.0}, {:.0}", place.x, place.y) };
        let line = format!(
            "{} / {}  {:5.1} %  {particles} particles  dt {:.3} s ({}, {:.1} m/s{at})  volume error {:.0e}  to go {}",
            clock_time(time),
            clock_time(self.end_time),
            100.0 * share,
            choice.time_step,
            choice.limit.name(),
            choice.max_speed,
            volume_error().abs(),
            clock_time(to_go),
        );
        // Progress that cannot be shown is no reason to stop a run.
        let _ = if self.is_terminal {
            write!(std::io::stderr(), "\r{line}\x1b[K")
        } else {
            writeln!(std::io::stderr(), "{line}")
        };
    }

    /// Ends the line that was written over.
    pub fn end(&self) {
        if self.is_terminal && self.last.is_some() {
            let _ = writeln!(std::io::stderr());
        }
    }
}

/// Seconds as hours, minutes and seconds.
pub fn clock_time(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    format!("{:02}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
}

/// Lengths and limits of the steps of a run.
#[derive(Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct StepStatistics {
    lengths: Vec<f32>,
    limiters: BTreeMap<StepLimit, u64>,
    max_speed: f64,
    peak_particles: usize,
}

impl StepStatistics {
    /// Counts one step.
    pub fn count(&mut self, choice: &StepChoice, particles: usize) {
        self.lengths.push(choice.time_step as f32);
        *self.limiters.entry(choice.limit).or_default() += 1;
        self.max_speed = self.max_speed.max(choice.max_speed);
        self.peak_particles = self.peak_particles.max(particles);
    }

    /// Writes the statistics into the manifest.
    pub fn note(mut self, manifest: &mut RunManifest) {
        self.lengths.sort_by(f32::total_cmp);
        let length = |index: usize| self.lengths.get(index).map_or(0.0, |length| f64::from(*length));
        let steps = self.lengths.len();
        manifest.dt_s = StepLengths { min: length(0), median: length(steps / 2), max: length(steps.saturating_sub(1)) };
        manifest.limiters = self.limiters.iter().map(|(name, count)| (name.name().to_owned(), *count)).collect();
        manifest.max_speed_m_s = self.max_speed;
        manifest.particles.peak = self.peak_particles;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clock_times() {
        assert_eq!(clock_time(0.0), "00:00:00");
        assert_eq!(clock_time(3725.4), "01:02:05");
    }
}
