//! The size of a run folder, by which `check`, `plan` and the run know whether there is room for it.
//!
//! While a run goes on, its frames stand in `fields.partial.nc`, uncompressed, and its state in two checkpoints. Before they are deleted the
//! results stand beside them: then the folder is at its largest.

use std::ops::Range;

use crate::prepare::{Scene, Setup};
use crate::scenario::methods::Core;
use crate::scenario::{OutputPart, Outputs, Scenario};

/// Bytes of the maps per cell of the output grid (NetCDF and COG together, compressed): scenarios that ship have 4 (all alike) to 19.
const MAP_BYTES: Range<f64> = 4.0..22.0;
/// Bytes of one frame per cell with water (compressed): scenarios that ship have 2 (at rest) to 22.
const FRAME_BYTES: Range<f64> = 4.0..24.0;
/// Bytes of a sample of a gauge series.
const SAMPLE_BYTES: f64 = 60.0;
/// Bytes of a particle of a channel at a moment: a row of `channels.csv`, and four numbers of `channels.nc` (compressed ones take less).
const PROFILE_BYTES: Range<f64> = 40.0..110.0;
/// Bytes that `channels.nc` takes besides: names and places of few or many stations.
const CHANNELS_FILE: Range<f64> = 2e4..6e4;
/// Bytes of `results.gpkg`, which holds its tables and styles without a feature, too.
const GEOPACKAGE: Range<f64> = 1.2e5..6e5;
/// Bytes of records and heads.
const OTHER_BYTES: Range<f64> = 2e4..1e5;
/// Bytes of a cell of the output grid in a frame of `fields.partial.nc`: depth, level and velocity. A tracer adds one number.
const GRIDS_OF_A_FRAME: f64 = 4.0;
const NUMBER_BYTES: f64 = 4.0;
/// Bytes of a checkpoint per cell of the lattice at most, two of which stand while a third is written; moving cells take this more
/// (the demonstration at 10 m: 300; at 20 m with moving cells 700).
const CHECKPOINT_BYTES: f64 = 350.0;
const MOVING_CHECKPOINT_BYTES: f64 = 500.0;
const CHECKPOINTS: f64 = 3.0;

/// Cells of the output grids.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    pub of_frames: f64,
    pub of_maps: f64,
}

impl Cells {
    /// Those of a setup.
    pub fn of(scenario: &Scenario, setup: &Setup) -> Self {
        let (lattice, cell) = (&setup.bed.lattice, scenario.outputs.cell);
        let across = |cells: usize| (cells as f64 * lattice.spacing / cell - 1e-6).ceil().max(1.0);
        let of_frames = across(lattice.columns) * across(lattice.rows);
        let of_maps = setup.pixels.as_ref().map_or(of_frames, |pixels| (pixels.columns * pixels.rows) as f64);
        Cells { of_frames, of_maps }
    }
}

/// What a run takes of the disk (bytes).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Disk {
    /// The folder of the whole run, without a report.
    pub at_end: Range<f64>,
    /// The folder when it is largest.
    pub on_the_way: Range<f64>,
    /// The results without frames, at most: what is to be written when a run ends early.
    pub without_frames: f64,
}

/// What a run takes, between the bounds of the mean number of wet cells of its lattice, with checkpoints or without.
pub(super) fn disk(
    scenario: &Scenario,
    scene: &Scene,
    cells: Cells,
    (wet, has_checkpoints): (Range<f64>, bool),
) -> Disk {
    let outputs = &scenario.outputs;
    let frames = (scenario.end_time / outputs.every).ceil() + 1.0;
    let gauges = scene.gauges.len() + scene.channels.iter().map(|channel| channel.gauges.len()).sum::<usize>();
    let samples = if outputs.writes(OutputPart::Tables) {
        gauges as f64 * (scenario.end_time / outputs.gauges_every).ceil()
    } else {
        0.0
    };
    let profiles = scene.needs.channel_particles as f64 * frames;
    let share = cells.of_frames / scene.lattice.len().max(1) as f64;
    let has_channels = if scene.channels.is_empty() { 0.0 } else { 1.0 };
    let folder = |[map, frame, profile, file, package, other]: [f64; 6], wet: f64| {
        let of_channels = profile * profiles + file * has_channels;
        map * cells.of_maps + frame * frames * wet * share + SAMPLE_BYTES * samples + of_channels + package + other
    };
    let ranges = [MAP_BYTES, FRAME_BYTES, PROFILE_BYTES, CHANNELS_FILE, GEOPACKAGE, OTHER_BYTES];
    let shares = written_shares(outputs);
    let least = [0, 1, 2, 3, 4, 5].map(|k: usize| shares[k] * ranges[k].start);
    let most = [0, 1, 2, 3, 4, 5].map(|k: usize| shares[k] * ranges[k].end);
    let at_end = folder(least, wet.start)..folder(most, wet.end);
    let grids = GRIDS_OF_A_FRAME + scenario.tracers.len() as f64;
    let has_frames = if outputs.writes(OutputPart::Fields) && !scenario.is_channels_alone() { 1.0 } else { 0.0 };
    let partial = has_frames * NUMBER_BYTES * grids * cells.of_frames * frames;
    let of_checkpoints = if has_checkpoints { checkpoints(scenario, scene) } else { 0.0 };
    Disk {
        on_the_way: partial.max(at_end.start)..partial + at_end.end + of_checkpoints,
        without_frames: folder([most[0], 0.0, most[2], most[3], most[4], most[5]], 0.0),
        at_end,
    }
}

/// Bytes of the checkpoints of a run.
fn checkpoints(scenario: &Scenario, scene: &Scene) -> f64 {
    let moving = if scenario.numerics.core() == Core::Lagrangian { MOVING_CHECKPOINT_BYTES } else { 0.0 };
    CHECKPOINTS * (CHECKPOINT_BYTES + moving) * scene.lattice.len() as f64
}

/// The shares of maps, frames, profiles of channels, `channels.nc`, GeoPackage and other files that are written: NetCDF and COG take half of the maps
/// each, and the profiles are in `channels.nc` and in a table.
fn written_shares(outputs: &Outputs) -> [f64; 6] {
    let share =
        |parts: &[OutputPart]| parts.iter().filter(|part| outputs.writes(**part)).count() as f64 / parts.len() as f64;
    [
        share(&[OutputPart::Maps, OutputPart::Cog]),
        share(&[OutputPart::Fields]),
        share(&[OutputPart::Channels, OutputPart::Tables]),
        share(&[OutputPart::Channels]),
        share(&[OutputPart::Gpkg]),
        1.0,
    ]
}
