//! A channel of one dimension as the run reports it, and its water.

use crate::math::Vec2;

/// A channel as the run reports it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ChannelProfile {
    /// Name.
    pub id: String,
    /// Distance of each particle from the far end (m).
    pub distance: Vec<f64>,
    /// Lowest bed of each section (m).
    pub bed: Vec<f64>,
    /// Level of the last row of each section (m); none where the sections have walls without end.
    pub banks: Option<Vec<f64>>,
    /// Map coordinates of each particle (m); none where the channel has no line on the map.
    pub places: Option<Vec<Vec2>>,
    /// Its gauges.
    pub gauges: Vec<ChannelGauge>,
}

/// A place of a channel at which the run reports water over time.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ChannelGauge {
    /// Name.
    pub id: String,
    /// Distance from the far end (m).
    pub distance: f64,
}

/// The water of one particle of a channel: depth above the lowest bed (m), level (m), velocity (m/s) and discharge (m³/s) towards the
/// near end.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
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

impl ChannelWater {
    /// The water `share` of the way to another moment or place.
    pub(super) fn between(&self, later: &ChannelWater, share: f64) -> ChannelWater {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        ChannelWater {
            depth: mix(self.depth, later.depth),
            level: mix(self.level, later.level),
            velocity: mix(self.velocity, later.velocity),
            discharge: mix(self.discharge, later.discharge),
        }
    }
}

/// All channels at one moment.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ChannelFrame {
    /// Time (s).
    pub time: f64,
    /// The particles of each channel, from its far end.
    pub water: Vec<Vec<ChannelWater>>,
}
