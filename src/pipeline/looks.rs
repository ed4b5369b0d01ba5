//! Two runs on coarse lattices that show, before a run, what its cells must be: where water is, and what coarse cells lose.

use super::levels::{UNSEEN, greatest};
use super::scout::Scout;
use crate::prepare::{Grain, Runnable, Setup, prepare, scatter};
use crate::scenario::Scenario;
use crate::solver::phases::processor_seconds;
use crate::solver::{Boundary, Condition, Opening};

/// The finer of the two lattices has cells of so many pixels, more where that is many cells, fewer where the terrain is narrow.
const PIXELS: f64 = 4.0;
/// The most cells of the finer lattice: a run on them takes seconds.
const MOST_CELLS: f64 = 50_000.0;
/// Depth (m) from which a cell counts as flooded, or this share of the greatest depth where that is less: flumes have centimetres.
const FLOODED: f64 = 0.05;
/// See [`FLOODED`].
const FLOODED_SHARE: f64 = 0.01;

/// A run on one coarse lattice.
#[derive(Debug)]
pub(super) struct Look {
    /// What it began with.
    pub setup: Setup,
    /// Its record.
    pub scout: Scout,
    /// CPU time of its steps (s).
    pub cpu: f64,
    /// Greatest depth (m) of each cell.
    depths: Vec<f64>,
}

impl Look {
    /// Edge of its cells (m).
    pub fn spacing(&self) -> f64 {
        self.scout.lattice.spacing
    }

    /// A run on cells of an edge (m); none where the scene cannot be put on them.
    fn at(scenario: &Scenario, spacing: f64) -> Option<Look> {
        let scenario = on_cells(scenario, spacing);
        let Runnable { setup, .. } = prepare(&scenario).into_runnable().ok()?;
        let mut scout = Scout::new(&scenario, &setup.bed);
        let before = processor_seconds();
        let depths = greatest(&scenario, &setup, &mut scout).depth;
        Some(Look { setup, scout, cpu: processor_seconds() - before, depths })
    }
}

/// A scenario on coarse cells of an edge (m), without what is only looked at and may not fit them.
pub(super) fn on_cells(scenario: &Scenario, spacing: f64) -> Scenario {
    let mut scenario = scenario.with_lengths(spacing, spacing);
    scenario.ground.follows_banks = false;
    (scenario.outputs.sections, scenario.outputs.gauges) = (None, None);
    scenario
}

/// Both runs, and what they differ by.
#[derive(Debug)]
pub(super) struct Looks {
    /// The run on finer cells.
    pub fine: Look,
    /// Edge of the cells of the other one (m).
    pub coarse_spacing: f64,
    /// Mean maximum depth (m) of the flooded cells.
    pub mean_depth: f64,
    /// Expected mean error (m) of the maximum depth in the finer run (M95).
    pub error: f64,
    /// The same over the places where terrain hides little from the coarse cells (M94).
    pub error_of_flow: f64,
}

/// Runs a scenario on two coarse lattices; none where it cannot be put on them. `across` cells lie across the shorter side of the terrain.
pub(super) fn look_twice(scenario: &Scenario, grain: &Grain, across: f64) -> Option<Looks> {
    let mut spacing = PIXELS * grain.pixel;
    while grain.area / (spacing * spacing) > MOST_CELLS {
        spacing *= 2.0;
    }
    while spacing > 2.0 * grain.pixel && 2.0 * spacing * across > grain.shorter_side {
        spacing /= 2.0;
    }
    while spacing >= 2.0 * grain.pixel {
        if let Some(fine) = Look::at(scenario, spacing)
            && let Some(coarse) = Look::at(scenario, 2.0 * spacing)
        {
            return Some(compare(fine, &coarse));
        }
        spacing /= 2.0;
    }
    None
}

/// What two runs differ by. The water of the coarse one is taken to the ground of the finer one.
fn compare(fine: Look, coarse: &Look) -> Looks {
    let lattice = &fine.scout.lattice;
    let deepest = fine.depths.iter().copied().fold(0.0, f64::max);
    let flooded = FLOODED.min(FLOODED_SHARE * deepest);
    let (columns, scatter) = scatter(&fine.setup.bed, 1);
    let (mut all, mut of_flow, mut depths) = (Mean::default(), Mean::default(), Mean::default());
    for cell in 0..lattice.columns * lattice.rows {
        let (bed, depth) = (fine.setup.bed.elevation[cell], fine.depths[cell]);
        let place = coarse.scout.lattice.to_local(lattice.to_map(lattice.centre(cell)));
        let Some(of_coarse) = coarse.scout.lattice.cell_at(place) else { continue };
        let level = coarse.setup.bed.elevation[of_coarse] + coarse.depths[of_coarse];
        let other = if coarse.depths[of_coarse] > 0.0 { (level - bed).max(0.0) } else { 0.0 };
        if bed.is_nan() || level.is_nan() || depth.max(other) < flooded {
            continue;
        }
        all.add((depth - other).abs());
        depths.add(depth);
        let (column, row) = lattice.column_row(cell);
        if scatter[row / 2 * columns + column / 2] <= UNSEEN * depth {
            of_flow.add((depth - other).abs());
        }
    }
    let (error, error_of_flow) = (all.value(), of_flow.value());
    Looks { coarse_spacing: coarse.spacing(), mean_depth: depths.value(), error, error_of_flow, fine }
}

/// A mean; 0 of nothing.
#[derive(Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1.0;
    }

    fn value(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }
}

/// The narrowest opening that water goes through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Narrowest {
    /// Its width (m).
    pub width: f64,
    /// What it is.
    pub what: &'static str,
}

/// The narrowest opening of a scene: its breach, or a boundary with a discharge.
pub(super) fn narrowest(setup: &Setup) -> Option<Narrowest> {
    let forcing = &setup.scene.forcing;
    let breach = forcing.breach.as_ref().and_then(|breach| match breach.opening {
        Opening::Whole => None,
        Opening::Trapezoid { bottom_width, .. } => Some(Narrowest { width: bottom_width, what: "the breach" }),
    });
    let inflow = |boundary: &Boundary| {
        let width: f64 = boundary.pieces.iter().map(|[from, to]| (to - from).norm()).sum();
        let is_inflow = matches!(boundary.condition, Condition::Discharge { .. });
        is_inflow.then_some(Narrowest { width, what: "an inflow" })
    };
    let all = forcing.boundaries.iter().filter_map(inflow).chain(breach);
    all.filter(|opening| opening.width > 0.0).min_by(|a, b| a.width.total_cmp(&b.width))
}
