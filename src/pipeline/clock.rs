//! Time, processor time and memory of the run, for its record.

use std::time::Instant;

use crate::output::RunManifest;
pub use crate::solver::phases::processor_seconds;

/// Measures a run, its phases, and the parts of a phase. Phases follow each other without a gap, and so do the parts of one.
pub struct Clock {
    start: Instant,
    lap: Instant,
    part_lap: Instant,
    /// The parts of the phase that goes on.
    parts: Vec<(&'static str, f64)>,
    phases: Vec<(String, f64)>,
}

impl Clock {
    /// Starts measuring.
    pub fn start() -> Self {
        let now = Instant::now();
        Clock { start: now, lap: now, part_lap: now, parts: Vec::new(), phases: Vec::new() }
    }

    /// Ends a phase. Its parts are written as `phase: part`.
    pub fn lap(&mut self, phase: &'static str) {
        let now = Instant::now();
        self.phases.push((phase.to_owned(), (now - self.lap).as_secs_f64()));
        self.phases.extend(self.parts.drain(..).map(|(part, seconds)| (format!("{phase}: {part}"), seconds)));
        (self.lap, self.part_lap) = (now, now);
    }

    /// Ends a part of the phase that goes on.
    pub fn part(&mut self, part: &'static str) {
        let seconds = self.part_lap.elapsed().as_secs_f64();
        self.skip();
        self.add(part, seconds);
    }

    /// The next part begins now: what passed since the latest one is measured elsewhere.
    pub fn skip(&mut self) {
        self.part_lap = Instant::now();
    }

    /// Adds to a part of the phase that goes on what was measured elsewhere (s).
    pub fn add(&mut self, part: &'static str, seconds: f64) {
        match self.parts.iter_mut().find(|(known, _)| *known == part) {
            Some((_, sum)) => *sum += seconds,
            None => self.parts.push((part, seconds)),
        }
    }

    /// Makes one phase of all that was measured so far.
    pub fn join_phases(&mut self, name: &'static str) {
        self.lap("the phase that goes on");
        self.phases = vec![(name.to_owned(), self.start.elapsed().as_secs_f64())];
    }

    /// Wall-clock and CPU time (s) so far, with those of a run before it went on.
    pub fn so_far(&self, (wall, cpu): (f64, f64)) -> (f64, f64) {
        (wall + self.start.elapsed().as_secs_f64(), cpu + processor_seconds())
    }

    /// Writes what was measured into the manifest; the phases are those since the run went on.
    pub fn note(&self, manifest: &mut RunManifest, before: (f64, f64)) {
        (manifest.wall_s, manifest.cpu_s) = self.so_far(before);
        manifest.peak_rss_mb = memory_mib();
        manifest.phase_s = self.phases.iter().cloned().collect();
    }
}

/// Greatest resident memory so far (MiB), 0 where the system does not tell.
pub fn memory_mib() -> f64 {
    peak_memory_mib().unwrap_or(0.0)
}

/// Greatest resident memory so far (MiB), where the system tells it in `/proc`.
fn peak_memory_mib() -> Option<f64> {
    Some(in_kib("VmHWM:")? / 1024.0)
}

/// Resident memory now (bytes), where the system tells it.
pub(super) fn resident_bytes() -> Option<f64> {
    Some(in_kib("VmRSS:")? * 1024.0)
}

fn in_kib(name: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().trim_end_matches("kB").trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_to_their_phase_and_phases_to_the_run() {
        let wait = || std::thread::sleep(std::time::Duration::from_millis(3));
        let mut clock = Clock::start();
        wait();
        clock.lap("first");
        for _ in 0..3 {
            wait();
            clock.part("one");
            wait();
            clock.skip();
            clock.add("two", 3e-3);
        }
        clock.lap("second");
        let mut manifest = RunManifest::default();
        clock.note(&mut manifest, (0.0, 0.0));
        let time = |name: &str| manifest.phase_s[name];
        assert_eq!(manifest.phase_s.len(), 4);
        assert!((time("first") + time("second")) / manifest.wall_s > 0.9);
        assert!(time("second: one") >= 9e-3 && (time("second: two") - 9e-3).abs() < 1e-12);
        assert!(time("second: one") + time("second: two") <= time("second"));
    }
}
