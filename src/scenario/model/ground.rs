//! The ground: terrain layers, gaps, breaklines, buildings, roughness.

use std::path::PathBuf;

use super::{PointInterpolation, Sourced, VectorSource};

/// One terrain layer; later layers win.
#[derive(Clone, Debug, PartialEq)]
pub enum TerrainLayer {
    /// A raster file that GDAL reads.
    Raster {
        /// The file.
        path: PathBuf,
        /// Added to every elevation (m).
        offset: f64,
        /// Factor from the file's unit to metres; none where the scenario does not say.
        unit: Option<f64>,
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

/// Roughness of the ground after Manning (s·m^(−1/3)); nothing where there are channels alone, each with its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Roughness {
    /// n where no file says it: everywhere without a raster, the default beside one.
    pub manning: Option<f64>,
    /// A raster of classes, with their table, or of n itself.
    pub raster: Option<Sourced<PathBuf>>,
    /// The n of each class.
    pub table: Option<Sourced<PathBuf>>,
    /// Areas with an n of their own, on top.
    pub polygons: Option<Sourced<VectorSource>>,
    /// By which every n is multiplied.
    pub factor: f64,
}

impl Default for Roughness {
    fn default() -> Self {
        Roughness { manning: None, raster: None, table: None, polygons: None, factor: 1.0 }
    }
}

impl Roughness {
    /// The same n everywhere.
    pub fn uniform(manning: f64) -> Self {
        Roughness { manning: Some(manning), ..Roughness::default() }
    }

    /// n where no file says it, with the factor.
    pub fn elsewhere(&self) -> Option<f64> {
        self.manning.map(|n| self.factor * n)
    }

    /// Whether there is no friction anywhere.
    pub fn is_none(&self) -> bool {
        self.raster.is_none() && self.polygons.is_none() && self.manning.is_none_or(|n| n <= 0.0)
    }
}

/// What the terrain holds beside its layers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    /// What becomes of holes; the edge of a hole is a wall when absent.
    pub gaps: Option<Sourced<Gaps>>,
    /// Lines along which the bed is raised or lowered, in their order; walls with a crest come last.
    pub breaklines: Vec<Breakline>,
    /// Files of lines that the sides of cells follow.
    pub followed: Vec<Sourced<VectorSource>>,
    /// Whether the sides of cells follow the steep banks that the terrain shows.
    pub follows_banks: bool,
    /// Buildings.
    pub buildings: Option<Buildings>,
}

/// How a terrain layer meets those under it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LayerMode {
    /// It counts alone.
    #[default]
    Replace,
    /// The lower one of the two counts, as for a river bed under a water surface.
    Min,
    /// The higher one of the two counts.
    Max,
}

/// What becomes of cells without terrain that terrain encloses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gaps {
    /// Their edge is a wall.
    Wall,
    /// The run is refused.
    Refuse,
    /// They are filled from their rim, if they have no more cells than this.
    Fill {
        /// Cells of the lattice.
        max_cells: usize,
    },
}

/// What a breakline does to the bed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BreaklineMode {
    /// Nothing under it lies lower.
    Raise,
    /// Nothing under it lies higher.
    Carve,
}

/// Lines along which the bed is raised or lowered.
#[derive(Clone, Debug, PartialEq)]
pub struct Breakline {
    /// The file with the lines.
    pub lines: Sourced<VectorSource>,
    /// Up or down.
    pub mode: BreaklineMode,
    /// Where its levels come from.
    pub level: LineLevel,
    /// Its width (m); a cell when absent.
    pub width: Option<f64>,
}

/// Where the levels of a breakline come from.
#[derive(Clone, Debug, PartialEq)]
pub enum LineLevel {
    /// The same for all its lines (m).
    Constant(Sourced<f64>),
    /// An attribute of each line.
    Field(String),
    /// The third coordinate of its vertices.
    Vertices,
}

/// Footprints of buildings.
#[derive(Clone, Debug, PartialEq)]
pub struct Buildings {
    /// The file with their polygons.
    pub polygons: Sourced<VectorSource>,
    /// What they do.
    pub mode: BuildingMode,
}

/// What a building does.
#[derive(Clone, Debug, PartialEq)]
pub enum BuildingMode {
    /// No water gets in.
    Block,
    /// The bed is higher.
    Raise {
        /// By this height (m); by an attribute of each when absent.
        height: Option<f64>,
        /// The attribute; `height_m` or `height` when absent.
        field: Option<String>,
    },
    /// The bed has this Manning roughness; the attribute `n` of each when absent.
    Roughness(Option<f64>),
}
