//! The water of channels of one dimension over time: profiles at the times of the frames, and what gauges see.

use serde::{Deserialize, Serialize};

use super::channel_gauges::{ChannelGaugeRecorder, ChannelGaugeResult, ChannelGaugeSample};
use super::channel_profile::{ChannelFrame, ChannelProfile, ChannelWater};
use super::frames::{Schedule, share_of_step};
use super::gauges::ArrivalRule;
use crate::error::Error;

/// Where the water of a channel stood highest above the last row of its sections: over the banks of the real one.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct AboveBanks {
    /// Name of the channel.
    pub channel: String,
    /// Height above the last row (m).
    pub height_m: f64,
    /// Distance from the far end (m).
    pub distance_m: f64,
    /// Time (s).
    pub time_s: f64,
}

impl AboveBanks {
    /// The highest place of a channel at a time (s), where the water is over its banks.
    fn of(profile: &ChannelProfile, water: &[ChannelWater], time: f64) -> Option<AboveBanks> {
        let heights = water.iter().zip(profile.banks.as_ref()?).map(|(water, bank)| water.level - bank);
        let (highest, height_m) = heights.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let place = || AboveBanks {
            channel: profile.id.clone(),
            height_m,
            distance_m: profile.distance[highest],
            time_s: time,
        };
        (height_m > 0.0).then(place)
    }
}

/// What to record of the channels.
#[derive(Clone, Copy, Debug)]
pub struct ChannelPlan {
    /// Interval of the profiles (s).
    pub every: f64,
    /// Interval of the gauge series (s).
    pub gauges_every: f64,
    /// End of the run (s).
    pub end_time: f64,
    /// Depth (m) that counts as arrival at a gauge.
    pub threshold: f64,
    /// Rise (m) that counts as arrival where there was water at the start.
    pub rise_on_wet: f64,
}

/// Where profiles go: usually [`ChannelsWriter::push`](super::ChannelsWriter::push).
pub type ProfileSink<'a> = dyn FnMut(&ChannelFrame) -> Result<(), Error> + 'a;

/// Follows the channels of a run.
#[derive(Debug, Deserialize, Serialize)]
pub struct ChannelRecorder {
    profiles: Vec<ChannelProfile>,
    schedule: Schedule,
    before: ChannelFrame,
    frames: Vec<ChannelFrame>,
    above_banks: Vec<Option<AboveBanks>>,
    gauges: ChannelGaugeRecorder,
}

/// Everything that the channels of a run left behind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelRecording {
    /// The profiles.
    pub frames: Vec<ChannelFrame>,
    /// The highest water of the channels that were over their banks.
    pub above_banks: Vec<AboveBanks>,
    /// What each gauge saw.
    pub gauge_results: Vec<ChannelGaugeResult>,
    /// The gauge series, by time and then by gauge.
    pub gauge_samples: Vec<ChannelGaugeSample>,
}

impl ChannelRecorder {
    /// A recorder that has seen the water at the start.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn start(
        profiles: &[ChannelProfile],
        plan: ChannelPlan,
        start: Vec<Vec<ChannelWater>>,
        sink: &mut ProfileSink<'_>,
    ) -> Result<Self, Error> {
        let rule = ArrivalRule { threshold: plan.threshold, rise_on_wet: plan.rise_on_wet };
        let mut recorder = ChannelRecorder {
            profiles: profiles.to_vec(),
            schedule: Schedule::new(plan.every, plan.end_time),
            before: ChannelFrame { time: 0.0, water: start },
            frames: Vec::new(),
            above_banks: vec![None; profiles.len()],
            gauges: ChannelGaugeRecorder::new(profiles, rule, Schedule::new(plan.gauges_every, plan.end_time)),
        };
        let start = recorder.before.water.clone();
        recorder.step(0.0, start, sink)?;
        Ok(recorder)
    }

    /// How many profiles were handed out.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// Keeps the highest water over the banks of each channel.
    fn follow_banks(&mut self) {
        let ChannelFrame { time, water } = &self.before;
        for ((profile, water), kept) in self.profiles.iter().zip(water).zip(&mut self.above_banks) {
            let now = AboveBanks::of(profile, water, *time);
            if now.as_ref().map(|now| now.height_m) > kept.as_ref().map(|kept| kept.height_m) {
                *kept = now;
            }
        }
    }

    /// Takes the water at the end of a step (s), and hands out the profiles that fell due.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn step(&mut self, time: f64, water: Vec<Vec<ChannelWater>>, sink: &mut ProfileSink<'_>) -> Result<(), Error> {
        let before = std::mem::replace(&mut self.before, ChannelFrame { time, water });
        self.gauges.step(&before, &self.before);
        while let Some(due) = self.schedule.due(time) {
            let share = share_of_step(due, before.time, time);
            let channel = |(earlier, later): (&Vec<ChannelWater>, &Vec<ChannelWater>)| {
                earlier.iter().zip(later).map(|(a, b)| a.between(b, share)).collect()
            };
            let water = before.water.iter().zip(&self.before.water).map(channel).collect();
            let frame = ChannelFrame { time: due, water };
            sink(&frame)?;
            self.frames.push(frame);
        }
        self.follow_banks();
        Ok(())
    }

    /// What the channels left behind, up to the last step taken.
    pub fn finish(self) -> ChannelRecording {
        let (gauge_results, gauge_samples) = self.gauges.finish();
        ChannelRecording {
            frames: self.frames,
            above_banks: self.above_banks.into_iter().flatten().collect(),
            gauge_results,
            gauge_samples,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(every: f64, end_time: f64) -> ChannelPlan {
        ChannelPlan { every, gauges_every: every, end_time, threshold: 0.01, rise_on_wet: 0.1 }
    }

    #[test]
    fn profiles_lie_between_the_steps() {
        let water = |depth: f64| vec![vec![ChannelWater { depth, ..ChannelWater::default() }]];
        let mut handed_out = Vec::new();
        let mut sink = |frame: &ChannelFrame| {
            handed_out.push(frame.clone());
            Ok(())
        };
        let mut recorder = ChannelRecorder::start(&[], plan(1.0, 2.0), water(4.0), &mut sink).unwrap();
        for (time, depth) in [(0.5, 4.0), (1.5, 2.0), (2.0, 1.0)] {
            recorder.step(time, water(depth), &mut sink).unwrap();
        }
        let frames = recorder.finish().frames;
        let found: Vec<(f64, f64)> = frames.iter().map(|f| (f.time, f.water[0][0].depth)).collect();
        assert_eq!(found, [(0.0, 4.0), (1.0, 3.0), (2.0, 1.0)]);
        assert_eq!(handed_out, frames);
    }

    #[test]
    fn the_highest_water_over_the_banks_is_kept_from_every_step() {
        let profile = |id: &str, banks| ChannelProfile {
            id: id.into(),
            distance: vec![5.0, 15.0],
            bed: vec![0.0, 0.0],
            banks,
            ..ChannelProfile::default()
        };
        let profiles =
            [profile("a", Some(vec![2.0, 1.5])), profile("walled", None), profile("low", Some(vec![9.0, 9.0]))];
        let water =
            |levels: [f64; 2]| vec![levels.map(|level| ChannelWater { level, ..ChannelWater::default() }).to_vec(); 3];
        let mut sink = |_: &ChannelFrame| Ok(());
        let mut recorder = ChannelRecorder::start(&profiles, plan(10.0, 10.0), water([1.0, 1.0]), &mut sink).unwrap();
        for (time, levels) in [(1.0, [2.25, 1.5]), (2.0, [2.0, 2.0]), (3.0, [2.25, 1.0])] {
            recorder.step(time, water(levels), &mut sink).unwrap();
        }
        let expected = AboveBanks { channel: "a".into(), height_m: 0.5, distance_m: 15.0, time_s: 2.0 };
        assert_eq!(recorder.finish().above_banks, [expected]);
    }
}
