//! The size of a run folder.

use std::ops::Range;

use super::Cells;
use crate::prepare::Scene;
use crate::scenario::{OutputPart, Outputs, Scenario};

/// Bytes of the maps per cell of the output grid (NetCDF and COG together, compressed): the demonstration 11, Malpasset at 40 m 19.
const MAP_BYTES: Range<f64> = 8.0..24.0;
/// Bytes of one frame per cell with water (compressed): the demonstration 21, Malpasset at 40 m 17.
const FRAME_BYTES: Range<f64> = 12.0..26.0;
/// Bytes of a sample of a gauge series.
const SAMPLE_BYTES: f64 = 60.0;
/// Bytes of a particle of a channel at a moment: a row of `channels.csv`, and four numbers of `channels.nc` (compressed ones take less).
const PROFILE_BYTES: Range<f64> = 50.0..110.0;
/// Bytes that `channels.nc` takes besides: names and places of few or many stations.
const CHANNELS_FILE: Range<f64> = 2e4..6e4;

/// Size of the run folder (MB), without a report, between the bounds of the number of wet cells.
pub fn disk(scenario: &Scenario, scene: &Scene, cells: Cells, wet: Range<f64>) -> Range<f64> {
    let frames = (scenario.end_time / scenario.outputs.every).ceil() + 1.0;
    let gauges = scene.gauges.len() + scene.channels.iter().map(|channel| channel.gauges.len()).sum::<usize>();
    let has_tables = scenario.outputs.writes(OutputPart::Tables);
    let samples =
        if has_tables { gauges as f64 * (scenario.end_time / scenario.outputs.gauges_every).ceil() } else { 0.0 };
    let profiles = scene.needs.channel_particles as f64 * frames;
    let share = cells.of_frames as f64 / scene.lattice.len().max(1) as f64;
    let has_channels = if scene.channels.is_empty() { 0.0 } else { 1.0 };
    let disk = |[map, frame, profile, file]: [f64; 4], wet: f64| {
        let of_channels = profile * profiles + file * has_channels;
        (map * cells.of_maps as f64 + frame * frames * wet * share + SAMPLE_BYTES * samples + of_channels) / 1e6
    };
    let ranges = [MAP_BYTES, FRAME_BYTES, PROFILE_BYTES, CHANNELS_FILE];
    let shares = written_shares(&scenario.outputs);
    let least = [0, 1, 2, 3].map(|k: usize| shares[k] * ranges[k].start);
    let most = [0, 1, 2, 3].map(|k: usize| shares[k] * ranges[k].end);
    disk(least, wet.start)..disk(most, wet.end)
}

/// The shares of maps, frames, profiles of channels and `channels.nc` that are written: NetCDF and COG take half of the maps each, and the
/// profiles are in `channels.nc` and in a table.
fn written_shares(outputs: &Outputs) -> [f64; 4] {
    let share =
        |parts: &[OutputPart]| parts.iter().filter(|part| outputs.writes(**part)).count() as f64 / parts.len() as f64;
    [
        share(&[OutputPart::Maps, OutputPart::Cog]),
        share(&[OutputPart::Fields]),
        share(&[OutputPart::Channels, OutputPart::Tables]),
        share(&[OutputPart::Channels]),
    ]
}
