//! The resolved scenario: SI units, every default filled in, paths as given relative to the scenario file.
//!
//! Stops at `pipeline` and `prepare`, which hand each stage a small plain struct.

pub use floodsim_core::terrain::PointInterpolation;
use std::path::PathBuf;

use super::Constants;
use super::channel::Channel;
use super::ground::{Ground, LayerMode};
use super::methods::{
    BedMethod, BedSlope, Core, Formulation, Integrator, Kernel, Motion, Reconstruction, Seeding, Stabilisation,
    Turbulence, WallMethod,
};
use super::moving_bed::MovingBed;
use super::start::Start;
use super::units::{INTENSITY, LENGTH};
use crate::calendar::UtcTime;
use crate::error::Place;

/// A value with its key path and place in the scenario file, for messages.
#[derive(Clone, Debug, PartialEq)]
pub struct Sourced<T> {
    /// The value.
    pub value: T,
    /// Key path, such as `initial[0].level`.
    pub key: String,
    /// Place in the file, where known.
    pub place: Option<Place>,
}

/// A vector file, with the layer when the scenario says `file.gpkg:layer`.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorSource {
    /// Absolute or working-directory-relative path (already joined with the folder of the scenario).
    pub path: PathBuf,
    /// Layer name; the first layer when absent.
    pub layer: Option<String>,
}

/// One terrain layer; later layers win.
#[derive(Clone, Debug, PartialEq)]
pub enum TerrainLayer {
    /// A raster file that GDAL reads.
    Raster {
        /// The file.
        path: PathBuf,
        /// Added to every elevation (m).
        offset: f64,
        /// Factor from the file's unit to metres.
        unit: f64,
        /// Polygons inside of which the layer counts; everywhere when absent.
        clip: Option<Sourced<VectorSource>>,
        /// How it meets the layers under it.
        mode: LayerMode,
    },
    /// Bare survey points.
    Points {
        /// Text file with columns x y z (comma, semicolon or blank separated, optional header, optionally gzipped), or a vector file.
        path: PathBuf,
        /// How elevations between the points are found.
        interpolation: PointInterpolation,
        /// Distance (m) to the nearest point beyond which there is no terrain.
        max_gap: f64,
        /// Added to every elevation (m).
        offset: f64,
        /// Polygons inside of which the layer counts; everywhere when absent.
        clip: Option<Sourced<VectorSource>>,
        /// How it meets the layers under it.
        mode: LayerMode,
    },
}

impl TerrainLayer {
    /// The polygons inside of which the layer counts, if not everywhere.
    pub fn clip(&self) -> Option<&Sourced<VectorSource>> {
        let (TerrainLayer::Raster { clip, .. } | TerrainLayer::Points { clip, .. }) = self;
        clip.as_ref()
    }
}

/// The coordinate reference system of the run.
#[derive(Clone, Debug, PartialEq)]
pub enum CrsChoice {
    /// That of the first terrain layer.
    FromTerrain,
    /// Plain metres without a place on Earth (`crs: local`).
    Local,
    /// As named, such as `EPSG:27572`.
    Named(String),
}

/// Roughness of the ground after Manning (s·m^(−1/3)); nothing where there are channels alone, each with its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Roughness {
    /// n where no file says it: everywhere without a raster, the default beside one.
    pub manning: Option<f64>,
    /// A raster of classes, with their table, or of n itself.
    pub raster: Option<Sourced<PathBuf>>,
    /// The n of each class.
    pub table: Option<Sourced<PathBuf>>,
    /// Areas with an n of their own, on top.
    pub polygons: Option<Sourced<VectorSource>>,
}

impl Roughness {
    /// The same n everywhere.
    pub fn uniform(manning: f64) -> Self {
        Roughness { manning: Some(manning), raster: None, table: None, polygons: None }
    }

    /// Whether there is no friction anywhere.
    pub fn is_none(&self) -> bool {
        self.raster.is_none() && self.polygons.is_none() && self.manning.is_none_or(|n| n <= 0.0)
    }
}

/// A body of still water at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct InitialWater {
    /// The polygon file.
    pub polygons: Sourced<VectorSource>,
    /// The level (m); from the attribute `level_field` of the file when absent.
    pub level: Option<Sourced<f64>>,
    /// Attribute that holds the level; `level_m`, `level` or their first ten letters when absent.
    pub level_field: Option<String>,
}

/// Which part of the outline of the terrain is open.
#[derive(Clone, Debug, PartialEq)]
pub enum OpenBoundary {
    /// A side of the raster rectangle.
    Side(Side),
    /// Edge faces near these lines.
    Lines(Sourced<VectorSource>),
}

/// A quantity that may change over time, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Timed {
    /// One value at all times.
    Constant(Sourced<f64>),
    /// Times and values in a table.
    Series(TableFile),
}

impl Timed {
    /// The key path and the place in the scenario.
    pub fn source(&self) -> (&str, Option<&Place>) {
        match self {
            Timed::Constant(value) => (&value.key, value.place.as_ref()),
            Timed::Series(table) => (&table.file.key, table.file.place.as_ref()),
        }
    }
}

/// Two columns of a CSV file.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    /// The file.
    pub file: Sourced<PathBuf>,
    /// The columns, the one that rises first.
    pub columns: [ColumnUnit; 2],
    /// What holds after the last row of a series; it must reach the end of the run when absent.
    pub after_end: Option<AfterEnd>,
}

/// How a series goes on after its last row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterEnd {
    /// With its last value.
    Hold,
}

/// A column and its unit, as far as the scenario says them.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnUnit {
    /// Its name; by its place in the table when absent.
    pub name: Option<String>,
    /// Its unit and the factor to SI; from the end of its name when absent.
    pub unit: Option<(String, f64)>,
}

/// An open part of the edge of the terrain at which something is known of the water beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// Where.
    pub place: OpenBoundary,
    /// What is known.
    pub condition: BoundaryCondition,
}

/// What is known of the water beyond a boundary.
#[derive(Clone, Debug, PartialEq)]
pub enum BoundaryCondition {
    /// Waves leave.
    Free,
    /// A discharge comes in (m³/s), at a level (m) where it comes in faster than waves run.
    Discharge {
        /// Discharge (m³/s).
        discharge: Timed,
        /// Level (m).
        level: Option<Timed>,
    },
    /// The level of still water beyond is held (m).
    Stage(Timed),
    /// The level of the water at the boundary is held (m).
    Level(Timed),
    /// A wave comes in, and waves leave.
    Wave {
        /// Level of the wave (m).
        level: Timed,
        /// Level without it (m); that of the water at the start when absent.
        still: Option<Timed>,
    },
    /// Uniform flow on a slope (dimensionless).
    NormalDepth(Sourced<f64>),
    /// The discharge that leaves follows from the level.
    Rating(TableFile),
}

/// Water that comes out of the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Where.
    pub place: SourcePlace,
    /// The discharge at each place, or of each line (m³/s).
    pub discharge: Timed,
}

/// The places of a source.
#[derive(Clone, Debug, PartialEq)]
pub enum SourcePlace {
    /// One place in the coordinates of the run (m).
    At(Sourced<[f64; 2]>),
    /// The points of a file.
    Points(Sourced<VectorSource>),
    /// The lines of a file.
    Lines(Sourced<VectorSource>),
}

/// Rain on the whole terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Rain {
    /// How much.
    pub amount: RainAmount,
    /// Its end (s); that of the run when absent.
    pub duration: Option<f64>,
    /// The first rain that runs off nowhere (m).
    pub initial_loss: f64,
    /// What of the rain runs off nowhere from then on (m/s).
    pub constant_loss: f64,
}

/// How much rain falls.
#[derive(Clone, Debug, PartialEq)]
pub enum RainAmount {
    /// The same everywhere (m/s).
    Rate(Timed),
    /// A raster of constant intensities.
    Raster {
        /// The file.
        file: Sourced<PathBuf>,
        /// Unit of its values and the factor to m/s.
        unit: (String, f64),
    },
    /// Rasters, each of which holds for an interval of time.
    Series {
        /// NetCDF file, with its variable where the scenario names one, or a list of files.
        file: Sourced<VectorSource>,
        /// Unit of their values, as written; that of the NetCDF variable when absent.
        unit: Option<(String, RainUnit)>,
        /// Which end of its interval the time of a raster is, where the scenario says it.
        stamp: Option<Stamp>,
        /// Date and time of the file at which the run begins; the reference time of the run when absent.
        start: Option<UtcTime>,
    },
}

/// What the numbers of a raster of rain are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RainUnit {
    /// Intensities; the factor to m/s.
    Intensity(f64),
    /// What falls within the interval of the raster; the factor to metres.
    Depth(f64),
}

impl RainUnit {
    /// The unit of a name, such as `mm/h` or `mm`.
    pub fn named(name: &str) -> Option<Self> {
        let intensity = INTENSITY.factor_of(name).map(RainUnit::Intensity);
        intensity.or_else(|| LENGTH.factor_of(name).map(RainUnit::Depth))
    }
}

/// Which end of its interval the time of a raster is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stamp {
    /// It holds from its time to that of the next one.
    #[default]
    Begin,
    /// It holds from the time of the one before to its own.
    End,
}

/// A dam that breaks.
#[derive(Clone, Debug, PartialEq)]
pub struct Breach {
    /// The file with its line.
    pub dam: Sourced<VectorSource>,
    /// Level of its crest (m); from the attribute `crest_field` of the line when absent.
    pub crest: Option<Sourced<f64>>,
    /// Attribute that holds the crest; `crest_m` or `crest` when absent.
    pub crest_field: Option<String>,
    /// When it begins.
    pub trigger: BreachTrigger,
    /// The final opening; the whole dam when absent.
    pub shape: Option<BreachShape>,
    /// How it grows.
    pub law: GrowthLaw,
    /// How long it grows (s); none where it opens at once.
    pub duration: Option<Sourced<f64>>,
    /// Share of the final opening against the time since the trigger, where the law is a series.
    pub share: Option<TableFile>,
    /// The formula that gives shape and duration in place of the scenario.
    pub method: Option<BreachMethod>,
}

/// A breach by a formula for embankment dams.
#[derive(Clone, Debug, PartialEq)]
pub struct BreachMethod {
    /// The formula.
    pub formula: BreachFormula,
    /// How the dam fails.
    pub mode: BreachMode,
    /// Water above the bottom of the breach when it begins (m³).
    pub volume: Sourced<f64>,
    /// Level of the bottom (m).
    pub invert: Sourced<f64>,
    /// A place in its middle in the coordinates of the run (m); the middle of the dam when absent.
    pub position: Option<Sourced<[f64; 2]>>,
}

/// A formula that gives both width and time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BreachFormula {
    /// `Froehlich2008`.
    Froehlich2008,
    /// `Froehlich1995`.
    Froehlich1995,
}

/// How a dam fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BreachMode {
    /// Water runs over the crest.
    Overtopping,
    /// Water runs through the dam.
    Piping,
}

/// When a breach begins.
#[derive(Clone, Debug, PartialEq)]
pub enum BreachTrigger {
    /// At a time (s).
    At(Sourced<f64>),
    /// When the water at a place reaches a level.
    Level {
        /// The level (m).
        level: Sourced<f64>,
        /// The place in the coordinates of the run (m).
        place: Sourced<[f64; 2]>,
    },
}

/// A trapezoid in the long profile of a dam.
#[derive(Clone, Debug, PartialEq)]
pub struct BreachShape {
    /// Width of its bottom (m).
    pub bottom_width: Sourced<f64>,
    /// Slope of its sides, horizontal to vertical.
    pub side_slope: f64,
    /// Level of its bottom (m).
    pub invert: Sourced<f64>,
    /// A place in its middle in the coordinates of the run (m); the middle of the dam when absent.
    pub position: Option<Sourced<[f64; 2]>>,
}

/// How a breach grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GrowthLaw {
    /// All at once.
    Instantaneous,
    /// In proportion to the time.
    Linear,
    /// Slow at the beginning and at the end.
    Sine,
    /// By a series of shares.
    Series,
}

/// A side of the rectangle of the terrain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Greatest y.
    North,
    /// Greatest x.
    East,
    /// Least y.
    South,
    /// Least x.
    West,
    /// The whole outline of the terrain, no-data edges included.
    All,
}

/// A part of the run folder that can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum OutputPart {
    /// `fields.nc`.
    Fields,
    /// `maps.nc`.
    Maps,
    /// `cog/`.
    Cog,
    /// `results.gpkg`.
    Gpkg,
    /// `tables/`.
    Tables,
    /// `sections.nc`.
    Sections,
    /// `channels.nc`.
    Channels,
}

impl OutputPart {
    /// All parts.
    pub const ALL: [OutputPart; 7] = [
        OutputPart::Fields,
        OutputPart::Maps,
        OutputPart::Cog,
        OutputPart::Gpkg,
        OutputPart::Tables,
        OutputPart::Sections,
        OutputPart::Channels,
    ];

    /// The name in `outputs.write`.
    pub fn name(self) -> &'static str {
        match self {
            OutputPart::Fields => "fields",
            OutputPart::Maps => "maps",
            OutputPart::Cog => "cog",
            OutputPart::Gpkg => "gpkg",
            OutputPart::Tables => "tables",
            OutputPart::Sections => "sections",
            OutputPart::Channels => "channels",
        }
    }
}

/// What to write.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs {
    /// Run folder, unless `--out` says otherwise; its key is empty where the scenario names none.
    pub folder: Sourced<PathBuf>,
    /// The parts to write, ascending; the others are not computed.
    pub write: Vec<OutputPart>,
    /// Edge of a cell of the output grids (m); of the frames alone where the maps are on the terrain's own raster.
    pub cell: f64,
    /// Where the scenario asks for maps on the terrain's own raster.
    pub maps_on_terrain: Option<Sourced<()>>,
    /// Interval of the frames of `fields.nc` (s).
    pub every: f64,
    /// Interval of the gauge series (s).
    pub gauges_every: f64,
    /// File of cross-sections.
    pub sections: Option<Sourced<VectorSource>>,
    /// Gauge file.
    pub gauges: Option<Sourced<VectorSource>>,
    /// Depths (m) for which arrival and duration are mapped; the first one gives `arrival_time` and the isochrones.
    pub thresholds: Vec<f64>,
    /// Rise above the initial level (m) that counts as arrival where there was water at the start.
    pub rise_on_wet: f64,
    /// Times of the isochrones (s).
    pub isochrones: Vec<f64>,
}

impl Outputs {
    /// Whether a part is to be written.
    pub fn writes(&self, part: OutputPart) -> bool {
        self.write.contains(&part)
    }

    /// The parts that are left out.
    pub fn left_out(&self) -> impl Iterator<Item = OutputPart> + '_ {
        OutputPart::ALL.into_iter().filter(|&part| !self.writes(part))
    }

    /// Whether anything is to be written for which each cell keeps its maxima.
    pub fn needs_maxima(&self) -> bool {
        [OutputPart::Maps, OutputPart::Cog, OutputPart::Gpkg].into_iter().any(|part| self.writes(part))
    }
}

/// Chosen methods and their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Numerics {
    /// Formulation.
    pub formulation: Formulation,
    /// Motion.
    pub motion: Motion,
    /// Stabilisation.
    pub stabilisation: Stabilisation,
    /// Reconstruction.
    pub reconstruction: Reconstruction,
    /// Seeding of Lagrangian particles.
    pub seeding: Seeding,
    /// Kernel.
    pub kernel: Kernel,
    /// Integrator.
    pub integrator: Integrator,
    /// Bed.
    pub bed: BedMethod,
    /// Effect of the bed's slope.
    pub bed_slope: BedSlope,
    /// Turbulence in the plane.
    pub turbulence: Turbulence,
    /// Walls beside Lagrangian particles.
    pub wall: WallMethod,
    /// Courant number.
    pub cfl: f64,
    /// Gravity (m/s²).
    pub gravity: f64,
    /// Depth (m) below which water does not move.
    pub dry_depth: f64,
    /// Constants of the methods; no scenario sets them.
    pub constants: Constants,
}

impl Numerics {
    /// The core that they ask for.
    pub fn core(&self) -> Core {
        Core::of(self.formulation, self.motion)
    }

    /// Every method that acts, as family and name, and the Courant number.
    pub fn acting(&self) -> Vec<(&'static str, String)> {
        const ALL: &[Core] = Core::ALL;
        const MOVING: &[Core] = &[Core::Lagrangian, Core::Variational];
        let families: [(&str, &str, &[Core]); 11] = [
            ("formulation", self.formulation.name(), ALL),
            ("motion", self.motion.name(), ALL),
            ("stabilisation", self.stabilisation.name(), ALL),
            ("reconstruction", self.reconstruction.name(), ALL),
            ("integrator", self.integrator.name(), ALL),
            ("bed", self.bed.name(), ALL),
            ("seeding", self.seeding.name(), MOVING),
            ("kernel", self.kernel.name(), MOVING),
            ("wall", self.wall.name(), MOVING),
            ("bed_slope", self.bed_slope.name(), &[Core::Variational]),
            ("turbulence", self.turbulence.name(), &[Core::Eulerian]),
        ];
        let acting = families.into_iter().filter(|(.., cores)| cores.contains(&self.core()));
        acting.map(|(family, name, _)| (family, name.to_owned())).chain([("cfl", self.cfl.to_string())]).collect()
    }
}

/// Limits that are checked before anything is allocated.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Memory (bytes).
    pub memory: f64,
    /// Particles, riverbed and fluid together.
    pub particles: f64,
}

/// A scenario as the program runs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// The scenario file.
    pub file: PathBuf,
    /// Title.
    pub title: String,
    /// Coordinate reference system.
    pub crs: Sourced<CrsChoice>,
    /// Terrain layers, later ones win; none where there are channels alone.
    pub layers: Vec<Sourced<TerrainLayer>>,
    /// Whether terrain in another or a geographic CRS is warped to the CRS of the run.
    pub reproject: bool,
    /// Holes, breaklines and buildings.
    pub ground: Ground,
    /// Roughness of the ground.
    pub roughness: Roughness,
    /// Water at the start.
    pub initial: Vec<InitialWater>,
    /// Water at the start that has no level.
    pub start: Start,
    /// Polylines that no water crosses.
    pub walls: Vec<Sourced<VectorSource>>,
    /// Open parts of the outline through which water leaves.
    pub open: Vec<OpenBoundary>,
    /// Open parts of the outline at which more is known.
    pub boundaries: Vec<Sourced<Boundary>>,
    /// Sources of water.
    pub sources: Vec<Sourced<Source>>,
    /// Rain.
    pub rain: Option<Sourced<Rain>>,
    /// A dam that breaks.
    pub breach: Option<Breach>,
    /// Parts of the bed that move.
    pub moving_bed: Vec<MovingBed>,
    /// Channels of one dimension.
    pub channels: Vec<Channel>,
    /// Distance of two particles (m).
    pub resolution: Sourced<f64>,
    /// End time (s).
    pub end_time: f64,
    /// Date and time of t = 0, if given.
    pub reference_time: Option<UtcTime>,
    /// Outputs.
    pub outputs: Outputs,
    /// Methods.
    pub numerics: Numerics,
    /// Limits.
    pub limits: Limits,
}

impl Scenario {
    /// Whether all of its water is in channels of one dimension, without any terrain.
    pub fn is_channels_alone(&self) -> bool {
        self.layers.is_empty() && !self.channels.is_empty()
    }
}
