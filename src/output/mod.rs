//! From water on the lattice to the run folder: maxima, arrival, frames, gauges, and the writers of every file.
//!
//! Order of use: [`RunFolder::create`], [`Recorder::new`], [`FieldsWriter::start`], [`Recorder::start`],
//! [`Recorder::step`] after every compute step, [`Recorder::finish`], then [`write_maps`], [`write_cogs`], [`write_geopackage`],
//! [`write_gauges`], [`write_mass_balance`], [`FieldsWriter::finish`] and [`RunManifest::write`].
//!
//! Maps follow the compute steps and never the stored frames; frames are interpolated between compute steps and never
//! shorten one. Channels of one dimension have a recorder and a writer of their own, [`ChannelRecorder`] and [`ChannelsWriter`]; a run
//! of channels alone has nothing of the rest but its balance. The writers know map coordinates and files; they do not know the solver.

use crate::math::Vec2;

mod cell_records;
mod channel_gauges;
mod channel_profile;
mod channels;
mod checkpoint;
mod closed_edge;
mod file_records;
mod folder;
mod frames;
mod gauges;
mod grid;
mod ground_source;
mod growth;
mod hazard;
mod hold;
mod manifest;
mod maxima;
mod on_terrain;
mod outline;
mod recorder;
mod recording;
mod ridges;
mod sections;
mod tracers;
mod verify;
mod volume_records;
mod write;

pub use cell_records::{ChoiceRecord, ErrorRecord, LevelRecord, PartRecord};
pub use channel_gauges::{ChannelGaugeResult, ChannelGaugeSample};
pub use channel_profile::{ChannelFrame, ChannelGauge, ChannelProfile, ChannelWater};
pub use channels::{ChannelPlan, ChannelRecorder, ChannelRecording};
pub use checkpoint::{Checkpoint, has_checkpoint, is_cut_off, write_checkpoint};
pub use closed_edge::{ClosedEdge, ClosedFace};
pub use file_records::{CheckpointRecord, InputFile, OutputFile, mark_ended};
pub use folder::RunFolder;
pub use frames::{Frame, MassBalanceRow, Volumes};
pub use gauges::{GaugeResult, GaugeSample};
pub use grid::{FILL, GridMaps, OutputGrid, ThresholdGrids};
pub use ground_source::{GroundSource, SetBy, SourceClass, SourceGrid};
pub use growth::Growth;
pub use hazard::{HAZARD_CLASSES, HazardClass, hazard_class};
pub use hold::is_held as is_in_use;
pub use manifest::{
    BanksRecord, BreachRecord, CellsInPartRecord, DischargeRecord, HotStart, MovingBedRecord, ParticleCounts,
    RunManifest, StepLengths, StillWaterRecord, WarningRecord, WorstDischarge,
};
pub use recorder::{Recorder, RecorderPlan};
pub use recording::Recording;
pub use ridges::Ridge;
pub use sections::{Section, SectionRecorder, SectionRecording, SectionResult, SectionSample};
pub use tracers::{TracerBalance, TracerGrids, TracerPlan};
pub use verify::{Verified, output_files, verify};
pub use volume_records::{HeldBack, PassageRecord, VolumeBooks};
pub use write::{
    ChannelsWriter, FieldsWriter, FileHead, Findings, LevelArea, MapClass, MapKind, MapVariable, Provenance,
    hazard_classes, map_variables, threshold_name, write_channels, write_cogs, write_difference_table, write_gauges,
    write_geopackage, write_level_layer, write_map_file, write_maps, write_mass_balance, write_passages,
    write_quantile_table, write_section_file, write_section_tables, write_sections, write_tracers,
};

/// Depth (m) below which a film counts as dry ground in the maps: it has no velocity and no hazard class.
///
/// A film of a millimetre threatens nobody, and its velocity, the quotient of two numbers that are both near the
/// rounding of the drying rule, would be the greatest speed on the map.
pub const WET_DEPTH: f64 = 1e-3;

/// A place at which the run reports water over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    /// Name.
    pub id: String,
    /// Map coordinates (m).
    pub position: Vec2,
    /// Further columns of the gauge file, kept as they were: name and value.
    pub attributes: Vec<(String, String)>,
}

/// The terrain as it is in the run by the pixels of its finest raster, under the whole lattice; row 0 in the north.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TerrainPixels {
    /// Map coordinate of the western edge (m).
    pub west: f64,
    /// Map coordinate of the northern edge (m).
    pub north: f64,
    /// Edge of a pixel (m).
    pub cell: f64,
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// Elevation (m) of each pixel; NaN where there is no terrain.
    pub elevation: Vec<f32>,
}

/// The coordinate reference system of the results, as writers need it.
#[derive(Clone, Debug, PartialEq)]
pub enum OutputCrs {
    /// Plain metres.
    Local,
    /// A projected system.
    Projected {
        /// WKT2:2019 text, the truth.
        wkt2: String,
        /// `EPSG:n` where the system has a code.
        authority: Option<String>,
    },
}
