//! Water through cross-sections over time, and what each has seen in the end.
//!
//! Volumes are those that the core exchanged between its cells, or that its particles carried across, added up step by step; the
//! discharge is that of a whole step, volume over time. Neither depends on the interval of the series.

use super::frames::{Schedule, share_of_step};
use crate::math::Vec2;

/// A line through which the run measures the discharge.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Name.
    pub id: String,
    /// Its corners from the left to the right bank, in map coordinates (m).
    pub line: Vec<Vec2>,
}

/// What a section has seen; discharges are positive where the water crosses the line towards its left side, that is downstream.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SectionResult {
    /// When the water came to the first of the cells that the line crosses, by the rule of the maps for the first threshold (s).
    pub arrival: Option<f64>,
    /// The discharge that was greatest in size (m³/s); 0 where no water came.
    pub peak_discharge: f64,
    /// Its time (s).
    pub time_of_peak: Option<f64>,
    /// Volume that passed, that of the other direction taken off (m³).
    pub volume: f64,
}

/// One section at one moment.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SectionSample {
    /// Index of the section.
    pub section: usize,
    /// Time (s).
    pub time: f64,
    /// Discharge (m³/s) of the compute step that holds the time; at 0 that of the first one.
    pub discharge: f64,
    /// Volume since the start (m³).
    pub volume: f64,
}

/// What was recorded at all cross-sections.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SectionRecording {
    /// What each section has seen.
    pub results: Vec<SectionResult>,
    /// The samples, by time and then by section.
    pub samples: Vec<SectionSample>,
}

/// A discharge below this (m³/s) is rounding or a drop, and no peak.
const NOTHING: f64 = 1e-6;

/// Follows the sections of a run.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub struct SectionRecorder {
    schedule: Schedule,
    time: f64,
    results: Vec<SectionResult>,
    samples: Vec<SectionSample>,
}

impl SectionRecorder {
    /// A recorder of so many sections that samples at an interval up to the end (s).
    pub fn new(sections: usize, every: f64, end: f64) -> Self {
        // The sample at 0 waits for the first step, which holds that time: what flows at the start of a run that goes on from
        // another one is known by then.
        SectionRecorder {
            schedule: Schedule::new(every, end),
            time: 0.0,
            results: vec![SectionResult::default(); sections],
            samples: Vec::new(),
        }
    }

    /// Takes the step that ended at a time (s): of each section its mean discharge (m³/s) and the volume since the start (m³).
    pub fn step(&mut self, after: f64, flows: impl Iterator<Item = (f64, f64)> + Clone) {
        let before = self.time;
        let earlier: Vec<f64> = self.results.iter().map(|result| result.volume).collect();
        for (result, (discharge, volume)) in self.results.iter_mut().zip(flows.clone()) {
            result.volume = volume;
            if discharge.abs() > result.peak_discharge.abs().max(NOTHING) {
                result.peak_discharge = discharge;
                result.time_of_peak = Some(after);
            }
        }
        let now: Vec<(f64, f64)> = flows.collect();
        self.time = after;
        self.sample(after, |(section, share)| {
            let (discharge, volume) = now[section];
            (discharge, earlier[section] + share_of_step(share, before, after) * (volume - earlier[section]))
        });
    }

    /// Adds a sample of every section for each moment that is due; `at` gives discharge and volume of a section at a time.
    fn sample(&mut self, until: f64, at: impl Fn((usize, f64)) -> (f64, f64)) {
        while let Some(time) = self.schedule.due(until) {
            for section in 0..self.results.len() {
                let (discharge, volume) = at((section, time));
                self.samples.push(SectionSample { section, time, discharge, volume });
            }
        }
    }

    /// What was recorded, with the arrival (s) at each section.
    pub fn finish(mut self, arrivals: &[Option<f64>]) -> SectionRecording {
        // A run that ended within its first step; nothing is due otherwise.
        if self.samples.is_empty() {
            self.sample(0.0, |_| (0.0, 0.0));
        }
        for (result, arrival) in self.results.iter_mut().zip(arrivals) {
            result.arrival = *arrival;
        }
        SectionRecording { results: self.results, samples: self.samples }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_at_0_has_the_discharge_of_the_first_step_and_no_volume() {
        let mut recorder = SectionRecorder::new(1, 5.0, 10.0);
        recorder.step(0.5, std::iter::once((170.0, 85.0)));
        recorder.step(10.0, std::iter::once((180.0, 1795.0)));
        let found: Vec<(f64, f64, f64)> =
            recorder.finish(&[None]).samples.iter().map(|s| (s.time, s.discharge, s.volume)).collect();
        assert_eq!(found, [(0.0, 170.0, 0.0), (5.0, 180.0, 895.0), (10.0, 180.0, 1795.0)]);
        let unbegun = SectionRecorder::new(2, 5.0, 10.0).finish(&[None; 2]).samples;
        assert_eq!(unbegun.len(), 2);
    }

    #[test]
    fn volumes_and_peaks_follow_the_steps_and_samples_lie_between() {
        let mut recorder = SectionRecorder::new(1, 5.0, 10.0);
        let steps = [(2.0, 0.0, 0.0), (4.0, 3.0, 6.0), (8.0, 1.0, 10.0), (10.0, -4.0, 2.0)];
        for (time, discharge, volume) in steps {
            recorder.step(time, std::iter::once((discharge, volume)));
        }
        let SectionRecording { results, samples } = recorder.finish(&[Some(2.5)]);
        let expected =
            SectionResult { arrival: Some(2.5), peak_discharge: -4.0, time_of_peak: Some(10.0), volume: 2.0 };
        assert_eq!(results, [expected]);
        let found: Vec<(f64, f64, f64)> = samples.iter().map(|s| (s.time, s.discharge, s.volume)).collect();
        assert_eq!(found, [(0.0, 0.0, 0.0), (5.0, 1.0, 7.0), (10.0, -4.0, 2.0)]);
    }
}
