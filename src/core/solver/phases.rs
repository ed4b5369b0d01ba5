//! Where the time of a core goes: wall-clock and processor time of each phase of its steps.
//!
//! Laps follow each other without a gap, so that the phases add up to the whole; reading the clocks takes some 0.5 µs a lap.
//! No result depends on what is measured here.

use std::time::Instant;

/// Time of one phase so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhaseTime {
    /// Wall-clock time (s).
    pub wall: f64,
    /// Processor time of all threads (s).
    pub cpu: f64,
}

/// A watch with one sum for each phase, in the order in which the phases first ended.
#[derive(Debug)]
pub struct Phases {
    times: Vec<(&'static str, PhaseTime)>,
    lap: (Instant, f64),
}

impl Default for Phases {
    fn default() -> Self {
        Phases { times: Vec::new(), lap: (Instant::now(), processor_seconds()) }
    }
}

impl Phases {
    /// Starts a lap; what passed since the latest one belongs to no phase.
    pub fn start(&mut self) {
        self.lap = (Instant::now(), processor_seconds());
    }

    /// Ends the lap: its time is that of `phase`, and the next one starts.
    pub fn end(&mut self, phase: &'static str) {
        let (wall, cpu) = self.lap;
        self.start();
        let place = self.times.iter().position(|(name, _)| *name == phase).unwrap_or_else(|| {
            self.times.push((phase, PhaseTime::default()));
            self.times.len() - 1
        });
        let time = &mut self.times[place].1;
        time.wall += (self.lap.0 - wall).as_secs_f64();
        time.cpu += self.lap.1 - cpu;
    }

    /// The phases and their times.
    pub fn times(&self) -> &[(&'static str, PhaseTime)] {
        &self.times
    }
}

/// Processor time of all threads so far (s), to the nanosecond where the system counts so finely; only differences mean anything.
pub fn processor_seconds() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laps_add_up_and_pauses_count_for_nothing() {
        let wait = || std::thread::sleep(std::time::Duration::from_millis(2));
        let begin = Instant::now();
        let mut phases = Phases::default();
        for _ in 0..3 {
            wait();
            phases.end("one");
            wait();
            phases.end("two");
        }
        let whole = begin.elapsed().as_secs_f64();
        wait();
        phases.start();
        phases.end("two");
        let times = phases.times();
        assert_eq!(times.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["one", "two"]);
        let sum: f64 = times.iter().map(|(_, time)| time.wall).sum();
        assert!(times.iter().all(|(_, time)| time.wall >= 6e-3 && time.cpu >= 0.0));
        assert!(sum < whole + 1e-3, "{sum} of {whole}");
    }
}
