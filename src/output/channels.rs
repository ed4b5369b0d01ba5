//! The water of channels of one dimension over time: profiles at the times of the frames.

use serde::Serialize;

use super::frames::{Schedule, share_of_step};

/// A channel as the run reports it.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelProfile {
    /// Name.
    pub id: String,
    /// Distance of each particle from the far end (m).
    pub distance: Vec<f64>,
    /// Lowest bed of each section (m).
    pub bed: Vec<f64>,
    /// Level of the last row of each section (m); none where the sections have walls without end.
    pub banks: Option<Vec<f64>>,
}

/// Where the water of a channel stood highest above the last row of its sections: over the banks of the real one.
#[derive(Clone, Debug, PartialEq, Serialize)]
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

/// The water of one particle of a channel: depth above the lowest bed (m), level (m), velocity (m/s) and discharge (m³/s) towards the
/// near end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelWater {
    /// Depth (m).
    pub depth: f64,
    /// Level (m).
    pub level: f64,
    /// Velocity (m/s).
    pub velocity: f64,
    /// Discharge (m³/s).
    pub discharge: f64,
}

/// All channels at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelFrame {
    /// Time (s).
    pub time: f64,
    /// The particles of each channel, from its far end.
    pub water: Vec<Vec<ChannelWater>>,
}

impl ChannelWater {
    fn between(&self, later: &ChannelWater, share: f64) -> ChannelWater {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        ChannelWater {
            depth: mix(self.depth, later.depth),
            level: mix(self.level, later.level),
            velocity: mix(self.velocity, later.velocity),
            discharge: mix(self.discharge, later.discharge),
        }
    }
}

/// Follows the channels of a run.
#[derive(Debug)]
pub struct ChannelRecorder<'a> {
    profiles: &'a [ChannelProfile],
    schedule: Schedule,
    before: ChannelFrame,
    frames: Vec<ChannelFrame>,
    above_banks: Vec<Option<AboveBanks>>,
}

impl<'a> ChannelRecorder<'a> {
    /// A recorder that takes a profile of each channel at an interval up to the end (s), and the water at the start.
    pub fn new(profiles: &'a [ChannelProfile], (every, end): (f64, f64), start: Vec<Vec<ChannelWater>>) -> Self {
        let mut schedule = Schedule::new(every, end);
        let before = ChannelFrame { time: 0.0, water: start };
        let frames = schedule.due(0.0).map(|_| before.clone()).into_iter().collect();
        let above_banks = vec![None; profiles.len()];
        let mut recorder = ChannelRecorder { profiles, schedule, before, frames, above_banks };
        recorder.follow_banks();
        recorder
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

    /// Takes the water at the end of a step (s).
    pub fn step(&mut self, time: f64, water: Vec<Vec<ChannelWater>>) {
        let before = std::mem::replace(&mut self.before, ChannelFrame { time, water });
        while let Some(due) = self.schedule.due(time) {
            let share = share_of_step(due, before.time, time);
            let channel = |(earlier, later): (&Vec<ChannelWater>, &Vec<ChannelWater>)| {
                earlier.iter().zip(later).map(|(a, b)| a.between(b, share)).collect()
            };
            let water = before.water.iter().zip(&self.before.water).map(channel).collect();
            self.frames.push(ChannelFrame { time: due, water });
        }
        self.follow_banks();
    }

    /// The profiles, and the highest water of the channels that were over their banks.
    pub fn finish(self) -> (Vec<ChannelFrame>, Vec<AboveBanks>) {
        (self.frames, self.above_banks.into_iter().flatten().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_lie_between_the_steps() {
        let water = |depth: f64| vec![vec![ChannelWater { depth, ..ChannelWater::default() }]];
        let mut recorder = ChannelRecorder::new(&[], (1.0, 2.0), water(4.0));
        recorder.step(0.5, water(4.0));
        recorder.step(1.5, water(2.0));
        recorder.step(2.0, water(1.0));
        let found: Vec<(f64, f64)> = recorder.finish().0.iter().map(|f| (f.time, f.water[0][0].depth)).collect();
        assert_eq!(found, [(0.0, 4.0), (1.0, 3.0), (2.0, 1.0)]);
    }

    #[test]
    fn the_highest_water_over_the_banks_is_kept_from_every_step() {
        let profile =
            |id: &str, banks| ChannelProfile { id: id.into(), distance: vec![5.0, 15.0], bed: vec![0.0, 0.0], banks };
        let profiles =
            [profile("a", Some(vec![2.0, 1.5])), profile("walled", None), profile("low", Some(vec![9.0, 9.0]))];
        let water =
            |levels: [f64; 2]| vec![levels.map(|level| ChannelWater { level, ..ChannelWater::default() }).to_vec(); 3];
        let mut recorder = ChannelRecorder::new(&profiles, (10.0, 10.0), water([1.0, 1.0]));
        for (time, levels) in [(1.0, [2.25, 1.5]), (2.0, [2.0, 2.0]), (3.0, [2.25, 1.0])] {
            recorder.step(time, water(levels));
        }
        let expected = AboveBanks { channel: "a".into(), height_m: 0.5, distance_m: 15.0, time_s: 2.0 };
        assert_eq!(recorder.finish().1, [expected]);
    }
}
