//! The water of channels of one dimension over time: profiles at the times of the frames.

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
pub struct ChannelRecorder {
    schedule: Schedule,
    before: ChannelFrame,
    frames: Vec<ChannelFrame>,
}

impl ChannelRecorder {
    /// A recorder that takes a profile at an interval up to the end (s), and the water at the start.
    pub fn new(every: f64, end: f64, start: Vec<Vec<ChannelWater>>) -> Self {
        let mut schedule = Schedule::new(every, end);
        let before = ChannelFrame { time: 0.0, water: start };
        let frames = schedule.due(0.0).map(|_| before.clone()).into_iter().collect();
        ChannelRecorder { schedule, before, frames }
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
    }

    /// The profiles.
    pub fn finish(self) -> Vec<ChannelFrame> {
        self.frames
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_lie_between_the_steps() {
        let water = |depth: f64| vec![vec![ChannelWater { depth, ..ChannelWater::default() }]];
        let mut recorder = ChannelRecorder::new(1.0, 2.0, water(4.0));
        recorder.step(0.5, water(4.0));
        recorder.step(1.5, water(2.0));
        recorder.step(2.0, water(1.0));
        let found: Vec<(f64, f64)> = recorder.finish().iter().map(|f| (f.time, f.water[0][0].depth)).collect();
        assert_eq!(found, [(0.0, 4.0), (1.0, 3.0), (2.0, 1.0)]);
    }
}
