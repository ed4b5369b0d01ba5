//! Water over time at gauges in channels of one dimension, and what each has seen in the end.
//!
//! A gauge lies between the middles of two particles and reads their water linearly between them; within half a particle of an end
//! it reads the last one. Samples are interpolated in time between compute steps; maxima and arrival follow every compute step, by
//! the rules of the gauges of the plane.

use super::WET_DEPTH;
use super::channel_profile::{ChannelFrame, ChannelGauge, ChannelProfile, ChannelWater};
use super::frames::{Schedule, share_of_step};
use super::gauges::ArrivalRule;
use super::maxima::arrival_depth;

/// What a gauge has seen.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ChannelGaugeResult {
    /// Name.
    pub id: String,
    /// Name of its channel.
    pub channel: String,
    /// Distance from the far end (m).
    pub distance: f64,
    /// Lowest bed there (m).
    pub bed: f64,
    /// Arrival for the first threshold (s).
    pub arrival: Option<f64>,
    /// Greatest depth (m); 0 where the water never came.
    pub max_depth: f64,
    /// Time of the greatest depth (s); none where the water never came.
    pub time_of_max: Option<f64>,
    /// Greatest water level (m); none where the water never came.
    pub max_level: Option<f64>,
    /// Greatest speed (m/s).
    pub max_speed: f64,
    /// The discharge that was greatest in size (m³/s), positive towards the near end.
    pub peak_discharge: f64,
    /// Its time (s); none where nothing flowed.
    pub time_of_peak: Option<f64>,
}

/// The water at one gauge at one moment.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ChannelGaugeSample {
    /// Index of the gauge, counted through all channels.
    pub gauge: usize,
    /// Time (s).
    pub time: f64,
    /// The water.
    pub water: ChannelWater,
}

impl ChannelGaugeSample {
    /// Level (m); none on dry ground.
    pub fn level(&self) -> Option<f64> {
        is_wet(&self.water).then_some(self.water.level)
    }
}

fn is_wet(water: &ChannelWater) -> bool {
    water.depth > WET_DEPTH
}

/// Where a gauge reads, and what it has seen so far.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Reading {
    channel: usize,
    /// The particles on both sides, and the share of the second one.
    between: ([usize; 2], f64),
    initial_depth: f64,
    last_depth: f64,
    result: ChannelGaugeResult,
}

/// Samples the gauges of all channels.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct ChannelGaugeRecorder {
    readings: Vec<Reading>,
    rule: ArrivalRule,
    schedule: Schedule,
    samples: Vec<ChannelGaugeSample>,
}

impl ChannelGaugeRecorder {
    pub(super) fn new(profiles: &[ChannelProfile], rule: ArrivalRule, schedule: Schedule) -> Self {
        let of_channel = |(channel, profile): (usize, &ChannelProfile)| {
            profile.gauges.iter().map(|gauge| Reading::new(channel, profile, gauge)).collect::<Vec<Reading>>()
        };
        let readings = profiles.iter().enumerate().flat_map(of_channel).collect();
        ChannelGaugeRecorder { readings, rule, schedule, samples: Vec::new() }
    }

    /// Takes the water of all channels before and after a compute step. The first call, at time 0, has no length.
    pub(super) fn step(&mut self, before: &ChannelFrame, after: &ChannelFrame) {
        while let Some(time) = self.schedule.due(after.time) {
            let share = share_of_step(time, before.time, after.time);
            for (gauge, reading) in self.readings.iter().enumerate() {
                let water = reading.read(&before.water).between(&reading.read(&after.water), share);
                self.samples.push(ChannelGaugeSample { gauge, time, water });
            }
        }
        for reading in &mut self.readings {
            let water = reading.read(&after.water);
            reading.follow(before.time, after.time, water, self.rule);
        }
    }

    /// What each gauge has seen, and the samples by time and then by gauge.
    pub(super) fn finish(self) -> (Vec<ChannelGaugeResult>, Vec<ChannelGaugeSample>) {
        (self.readings.into_iter().map(|reading| reading.result).collect(), self.samples)
    }
}

impl Reading {
    fn new(channel: usize, profile: &ChannelProfile, gauge: &ChannelGauge) -> Self {
        let (places, last) = (&profile.distance, profile.distance.len() - 1);
        let after = places.partition_point(|place| *place < gauge.distance);
        let pair = [after.saturating_sub(1), after.min(last)];
        let [low, high] = pair.map(|particle| places[particle]);
        let share = share_of_step(gauge.distance, low, high);
        let [below, above] = pair.map(|particle| profile.bed[particle]);
        let result = ChannelGaugeResult {
            id: gauge.id.clone(),
            channel: profile.id.clone(),
            distance: gauge.distance,
            bed: below + share * (above - below),
            ..ChannelGaugeResult::default()
        };
        Reading { channel, between: (pair, share), initial_depth: 0.0, last_depth: 0.0, result }
    }

    fn read(&self, channels: &[Vec<ChannelWater>]) -> ChannelWater {
        let ([low, high], share) = self.between;
        let water = &channels[self.channel];
        water[low].between(&water[high], share)
    }

    /// Keeps maxima and arrival.
    fn follow(&mut self, before: f64, after: f64, now: ChannelWater, rule: ArrivalRule) {
        if after <= before {
            (self.initial_depth, self.last_depth) = (now.depth, now.depth);
        }
        let result = &mut self.result;
        let wanted = arrival_depth(rule.threshold, self.initial_depth, rule.rise_on_wet);
        if result.arrival.is_none() && now.depth >= wanted {
            let share = share_of_step(wanted, self.last_depth, now.depth);
            result.arrival = Some(before + share * (after - before));
        }
        if is_wet(&now) {
            if now.depth > result.max_depth {
                (result.max_depth, result.time_of_max) = (now.depth, Some(after));
            }
            result.max_level = Some(result.max_level.map_or(now.level, |greatest| greatest.max(now.level)));
            result.max_speed = result.max_speed.max(now.velocity.abs());
        }
        if now.discharge.abs() > result.peak_discharge.abs() {
            (result.peak_discharge, result.time_of_peak) = (now.discharge, Some(after));
        }
        self.last_depth = now.depth;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recorder(distances: &[f64]) -> ChannelGaugeRecorder {
        let gauges = distances.iter().map(|distance| ChannelGauge { id: format!("g{distance}"), distance: *distance });
        let profile = ChannelProfile {
            id: "a".into(),
            distance: vec![5.0, 15.0, 25.0],
            bed: vec![3.0, 2.0, 1.0],
            gauges: gauges.collect(),
            ..ChannelProfile::default()
        };
        let rule = ArrivalRule { threshold: 0.01, rise_on_wet: 0.1 };
        ChannelGaugeRecorder::new(&[profile], rule, Schedule::new(1.0, 4.0))
    }

    fn frame(time: f64, depths: [f64; 3]) -> ChannelFrame {
        let beds = [3.0, 2.0, 1.0];
        let of = |(depth, bed): (f64, f64)| ChannelWater {
            depth,
            level: bed + depth,
            velocity: -2.0 * depth,
            discharge: -10.0 * depth,
        };
        ChannelFrame { time, water: vec![depths.into_iter().zip(beds).map(of).collect()] }
    }

    #[test]
    fn a_gauge_reads_between_the_particles_beside_it() {
        let mut recorder = recorder(&[0.0, 5.0, 7.5, 25.0, 30.0]);
        let start = frame(0.0, [1.0, 0.2, 0.0]);
        recorder.step(&start, &start);
        let (results, samples) = recorder.finish();
        let found: Vec<f64> = samples.iter().map(|sample| sample.water.depth).collect();
        for (found, expected) in found.iter().zip([1.0, 1.0, 0.8, 0.0, 0.0]) {
            assert!((found - expected).abs() < 1e-15, "{samples:?}");
        }
        assert_eq!(results.iter().map(|result| result.bed).collect::<Vec<_>>(), [3.0, 3.0, 2.75, 1.0, 1.0]);
        let levels: Vec<Option<f64>> = samples.iter().map(ChannelGaugeSample::level).collect();
        assert_eq!((levels[0], levels[3], levels[4]), (Some(4.0), None, None));
        assert!((levels[2].unwrap() - 3.55).abs() < 1e-15);
    }

    #[test]
    fn maxima_follow_the_steps_and_samples_lie_between() {
        let mut recorder = recorder(&[25.0]);
        let states = [(0.0, 0.0), (0.5, 0.0), (1.5, 1.0), (2.5, 0.5), (4.0, 0.25)];
        let all = states.map(|(time, depth)| frame(time, [0.0, 0.0, depth]));
        recorder.step(&all[0], &all[0]);
        for pair in all.windows(2) {
            recorder.step(&pair[0], &pair[1]);
        }
        let (results, samples) = recorder.finish();
        let series: Vec<(f64, f64)> = samples.iter().map(|sample| (sample.time, sample.water.depth)).collect();
        for (found, expected) in
            series.iter().zip([(0.0, 0.0), (1.0, 0.5), (2.0, 0.75), (3.0, 5.0 / 12.0), (4.0, 0.25)])
        {
            assert!((found.0 - expected.0).abs() + (found.1 - expected.1).abs() < 1e-15, "{series:?}");
        }
        let seen = &results[0];
        // The threshold of 0.01 m is passed a hundredth into the step that ends with 1 m.
        assert!((seen.arrival.unwrap() - 0.51).abs() < 1e-12);
        assert_eq!((seen.max_depth, seen.time_of_max, seen.max_level), (1.0, Some(1.5), Some(2.0)));
        assert_eq!((seen.max_speed, seen.peak_discharge, seen.time_of_peak), (2.0, -10.0, Some(1.5)));
        assert_eq!((seen.id.as_str(), seen.channel.as_str()), ("g25", "a"));
    }
}
