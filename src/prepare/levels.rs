//! The levels of a nested lattice: the same scene prepared on each of them, and the level that each place asks for.
//!
//! Every level is prepared as a lattice of its own, by the same rules as one lattice alone. What a place asks for is known before the run: the
//! scenario's own areas and lines, and what stands in the scene. Where the water is thin against what a coarse cell does not see of its
//! terrain is found by a run on the coarsest level (`pipeline/levels.rs`).

use geo::CoordsIter;
use rayon::prelude::*;

use super::findings::Findings;
use super::on_lattice::{Files, place_on};
use super::{Scene, Setup, places, polygons};
use crate::bed::BedParticles;
use crate::boundary::ChannelEnd;
use crate::error::Problem;
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::scenario::{
    Boundary as WrittenBoundary, BoundaryCondition, Levels, OpenBoundary, Refine, RefineShape, Scenario, Sourced,
    VectorSource,
};
use crate::solver::{Boundary, Condition};
use crate::terrain::Terrain;

/// Cells along the side of a block of one level.
pub const BLOCK: usize = 16;
/// Cells of the finest level that are kept fine around what asks for it.
const AROUND: f64 = 4.0;

/// Why a place has cells as fine as it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Because {
    /// The dam that breaks.
    Breach,
    /// Walls.
    Walls,
    /// Lines that cells follow.
    Lines,
    /// Buildings, and ground that dams and levees raise.
    Raised,
    /// Gauges.
    Gauges,
    /// Cross-sections.
    Sections,
    /// Sources.
    Sources,
    /// The moving bed.
    MovingBed,
    /// Channels of one dimension that join there.
    Channels,
    /// Boundaries with a discharge or a rating curve.
    Boundaries,
    /// An entry of `refine`.
    Refine,
    /// Terrain that coarser cells do not see under the depth of water there (M94).
    Terrain,
    /// Velocity head that coarser cells do not see (M101).
    FastWater,
    /// Finer cells beside it: levels change by one at a time.
    Transition,
    /// Nothing asks for finer cells.
    Nothing,
}

impl Because {
    /// The reason in words.
    pub fn words(self) -> &'static str {
        match self {
            Because::Breach => "breach",
            Because::Walls => "walls",
            Because::Lines => "lines that cells follow",
            Because::Raised => "buildings and raised ground",
            Because::Gauges => "gauges",
            Because::Sections => "cross-sections",
            Because::Sources => "sources",
            Because::MovingBed => "moving bed",
            Because::Channels => "channels",
            Because::Boundaries => "boundaries",
            Because::Refine => "refine",
            Because::Terrain => "terrain under the water",
            Because::FastWater => "fast water",
            Because::Transition => "beside finer cells",
            Because::Nothing => "nothing finer needed",
        }
    }
}

/// The level that each block of the finest lattice asks for, the coarsest that does.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// Blocks from west to east.
    pub columns: usize,
    /// The levels, row by row from the south.
    pub levels: Vec<u8>,
    /// Why each block asks for its level.
    pub because: Vec<Because>,
}

impl Wanted {
    /// Every block asks for a level.
    fn all(lattice: &Lattice, level: usize) -> Self {
        let (columns, rows) = (lattice.columns.div_ceil(BLOCK), lattice.rows.div_ceil(BLOCK));
        let levels = vec![u8::try_from(level).unwrap_or(u8::MAX); columns * rows];
        Wanted { columns, because: vec![Because::Nothing; levels.len()], levels }
    }

    /// Asks for a level, or a finer one, at all blocks within a distance (m) of a place.
    fn ask(&mut self, lattice: &Lattice, (place, within): (Vec2, f64), (level, because): (usize, Because)) {
        let side = BLOCK as f64 * lattice.spacing;
        let rows = self.levels.len() / self.columns;
        let range = |at: f64, count: usize| {
            let first = ((at - within) / side).floor().max(0.0) as usize;
            first..(((at + within) / side).floor().max(-1.0) + 1.0).min(count as f64).max(0.0) as usize
        };
        for row in range(place.y, rows) {
            for column in range(place.x, self.columns) {
                self.set((column, row), level, because);
            }
        }
    }

    /// Asks for a level, or a finer one, at a block; of two reasons for the same level the earlier one stays.
    pub fn set(&mut self, (column, row): (usize, usize), level: usize, because: Because) {
        let (block, level) = (row * self.columns + column, u8::try_from(level).unwrap_or(u8::MAX));
        if level < self.levels[block] {
            self.levels[block] = level;
            self.because[block] = because;
        }
    }
}

/// Adds the coarser levels to what was prepared on the finest one.
pub(super) fn with_coarser(
    (scenario, levels): (&Scenario, &Levels),
    (terrain, crs): (&Terrain, Option<&Crs>),
    finest: Setup,
    findings: &mut Findings,
) -> Option<Setup> {
    let count = levels.count(scenario.resolution.value);
    if count == 1 {
        return Some(finest);
    }
    let wanted = wanted((scenario, levels), crs, &finest, findings);
    let mut coarser = Vec::new();
    for level in 1..count {
        let lattice = &finest.scene.lattice;
        let times = 1_usize << level;
        let spacing = lattice.spacing * times as f64;
        let own = Lattice::new(lattice.origin, lattice.columns.div_ceil(times), lattice.rows.div_ceil(times), spacing);
        let mut scenario = Scenario { levels: None, ..scenario.clone() };
        scenario.resolution.value = spacing;

        let mut of_level = Findings::default();
        // Lines are followed on the finest level.
        let files = Files::open(&scenario, crs, &mut of_level).of_squares();
        let setup = place_on(&scenario, terrain, files, own, &mut of_level);
        // What is wrong with the input was told on the finest level, and what is doubtful on a coarse one has finer cells where it counts.
        let errors = of_level.errors_beyond(findings);
        let on_level = |problem: Problem| {
            let message = format!("on the level of {spacing} m: {}", problem.message);
            Problem { message, ..problem }.with_remedy("take a smaller `resolution.coarsest`, or refine this place")
        };
        findings.extend(errors.into_iter().map(on_level));
        coarser.push(setup?);
    }
    Some(Setup { coarser, wanted: Some(wanted), ..finest })
}

/// The level that each block asks for by the scenario and by what stands in the scene.
fn wanted(
    (scenario, levels): (&Scenario, &Levels),
    crs: Option<&Crs>,
    setup: &Setup,
    findings: &mut Findings,
) -> Wanted {
    let (scene, lattice) = (&setup.scene, &setup.scene.lattice);
    let count = levels.count(scenario.resolution.value);
    let mut wanted = Wanted::all(lattice, count - 1);
    let around = AROUND * lattice.spacing;
    let followed = setup.following.iter().flat_map(|following| following.conforming.cells());
    let followed = followed.map(|cell| (Because::Lines, cell.centre));
    for (because, place) in fine_places(scene, &setup.bed).into_iter().chain(followed) {
        // A gauge reads the water of its own cell.
        let around = if because == Because::Gauges { 0.0 } else { around };
        wanted.ask(lattice, (place, around), (0, because));
    }
    for refine in &levels.refine {
        let level = levels.level_of(lattice.spacing, refine.value.to);
        refined(refine, (scenario, crs), (lattice, level), &mut wanted, findings);
    }
    wanted
}

/// Places (local coordinates) that are to be on the finest level, and why.
fn fine_places(scene: &Scene, bed: &BedParticles) -> Vec<(Because, Vec2)> {
    let lattice = &scene.lattice;
    let forcing = &scene.forcing;
    let mut cells: Vec<(Because, usize)> = Vec::new();
    let mut add =
        |because: Because, more: &mut dyn Iterator<Item = usize>| cells.extend(more.map(|cell| (because, cell)));
    if let Some(breach) = &forcing.breach {
        add(Because::Breach, &mut breach.cells_and_rim());
    }
    add(Because::Raised, &mut bed.sealed.iter().chain(&scene.raised).copied());
    add(Because::Sections, &mut scene.crossed.iter().flatten().copied());
    let motions = forcing.moving_bed.iter();
    add(Because::MovingBed, &mut motions.flat_map(|motion| motion.cells.iter().map(|(cell, _)| *cell)));
    let lines = forcing.line_sources.iter();
    add(Because::Sources, &mut lines.flat_map(|source| source.cells.iter().map(|(cell, _)| *cell)));
    let ends = forcing.channels.iter().flat_map(|channel| [&channel.far, &channel.near]);
    add(Because::Channels, &mut ends.flat_map(ChannelEnd::joined_cells));
    let mut places: Vec<(Because, Vec2)> =
        cells.into_iter().map(|(because, cell)| (because, lattice.centre(cell))).collect();
    places.extend(scene.gauges.iter().map(|gauge| (Because::Gauges, lattice.to_local(gauge.position))));
    places.extend(forcing.sources.iter().map(|source| (Because::Sources, source.place)));
    // What is shared among the faces of a boundary is shared on one level.
    let is_shared =
        |boundary: &&Boundary| matches!(boundary.condition, Condition::Discharge { .. } | Condition::Rating(_));
    let shared = forcing.boundaries.iter().filter(is_shared).flat_map(|boundary| boundary.pieces.iter());
    let walls = scene.walls.iter().map(|piece| (Because::Walls, *piece));
    for (because, piece) in walls.chain(shared.map(|piece| (Because::Boundaries, piece))) {
        places.extend(along(piece, lattice.spacing).map(|place| (because, place)));
    }
    places
}

/// Places (local coordinates) that a run must hold: where water is brought in or taken out, and where it is looked at.
///
/// Sides of the terrain through which water may only leave are not among them: it may never come there.
pub fn places_of_water(scenario: &Scenario, setup: &Setup) -> Vec<Vec2> {
    let scene = &setup.scene;
    let stands = [Because::Walls, Because::Raised, Because::Lines];
    let fine = fine_places(scene, &setup.bed).into_iter().filter(|(because, _)| !stands.contains(because));
    let is_way_out = |written: &Sourced<WrittenBoundary>| {
        let condition = &written.value.condition;
        matches!(written.value.place, OpenBoundary::Side(_))
            && matches!(condition, BoundaryCondition::Free | BoundaryCondition::NormalDepth(_))
    };
    let boundaries = scene.forcing.boundaries.iter().zip(&scenario.boundaries);
    let boundaries = boundaries.filter(|(_, written)| !is_way_out(written)).flat_map(|(open, _)| open.pieces.iter());
    let wet = (0..setup.bed.lattice.len()).filter(|&cell| setup.still_water.depth[cell] > 0.0);
    let wet = wet.map(|cell| setup.bed.lattice.centre(cell));
    let bodies = scene.waters.iter().flat_map(|water| water.polygon.coords_iter());
    let corners = bodies.map(|corner| setup.bed.lattice.to_local(Vec2::new(corner.x, corner.y)));
    fine.map(|(_, place)| place).chain(boundaries.flatten()).chain(wet).chain(corners).collect()
}

/// Places along a piece, no farther apart than a distance (m).
fn along([from, to]: [Vec2; 2], distance: f64) -> impl Iterator<Item = Vec2> {
    let count = ((to - from).norm() / distance).ceil().max(1.0) as usize;
    (0..=count).map(move |k| from + (to - from) * (k as f64 / count as f64))
}

/// Takes an entry of `refine` over.
fn refined(
    refine: &Sourced<Refine>,
    (scenario, crs): (&Scenario, Option<&Crs>),
    (lattice, level): (&Lattice, usize),
    wanted: &mut Wanted,
    findings: &mut Findings,
) {
    match &refine.value.shape {
        RefineShape::Lines { source, within } => {
            let source = of_entry(refine, source);
            let Some(drawn) = places::pieces(&source, crs, scenario, findings) else { return };
            for piece in &drawn.pieces {
                for place in along(piece.map(|place| lattice.to_local(place)), lattice.spacing) {
                    wanted.ask(lattice, (place, *within), (level, Because::Refine));
                }
            }
        }
        RefineShape::Polygons(source) => {
            let source = of_entry(refine, source);
            let Some(features) = places::features_near(&source, crs, scenario, findings) else { return };
            let area = polygons::union(features.into_iter().flat_map(|feature| feature.polygons).collect());
            let inside = polygons::cells_inside(&area, lattice).into_iter().map(|cell| lattice.centre(cell));
            // A polygon may lie between all centres.
            let corners = area.coords_iter().map(|corner| lattice.to_local(Vec2::new(corner.x, corner.y)));
            for place in inside.chain(corners) {
                wanted.ask(lattice, (place, 0.0), (level, Because::Refine));
            }
        }
    }
}

/// The file of an entry of `refine`.
fn of_entry(refine: &Sourced<Refine>, source: &VectorSource) -> Sourced<VectorSource> {
    Sourced { value: source.clone(), key: refine.key.clone(), place: refine.place.clone() }
}

/// How much (m) the ground in a cell of a level scatters about the plane through it, root mean square; by cells of the level.
///
/// ```text
/// (M93)  σ_i² = ⟨(z_b − z_i − s_i·(x − x_i))²⟩ over the finest cells in i,   s_i the plane's slope
/// ```
///
/// Not a number where there is no terrain.
pub fn scatter(finest: &BedParticles, level: usize) -> (usize, Vec<f64>) {
    let (lattice, times) = (&finest.lattice, 1_usize << level);
    let (columns, rows) = (lattice.columns.div_ceil(times), lattice.rows.div_ceil(times));
    let of_cell = |cell: usize| {
        let (column, row) = (cell % columns * times, cell / columns * times);
        let within = |from: usize, count: usize| from..(from + times).min(count);
        let middle = 0.5 * (times as f64 - 1.0);
        // Sums of 1, x, y, z, their squares and products, x and y from the middle of the cell.
        let (mut count, mut z_sum, mut x_sum, mut y_sum) = (0.0, 0.0, 0.0, 0.0);
        let (mut xx, mut yy, mut xy, mut xz, mut yz, mut zz) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let within_cell =
            || within(row, lattice.rows).flat_map(|r| within(column, lattice.columns).map(move |c| (c, r)));
        let elevation = |(c, r): (usize, usize)| finest.elevation[lattice.index(c, r)];
        let Some(first) = within_cell().map(elevation).find(|z| !z.is_nan()) else { return f64::NAN };
        for r in within(row, lattice.rows) {
            for c in within(column, lattice.columns) {
                let z = finest.elevation[lattice.index(c, r)] - first;
                if z.is_nan() {
                    continue;
                }
                let (x, y) = ((c - column) as f64 - middle, (r - row) as f64 - middle);
                count += 1.0;
                (x_sum, y_sum, z_sum) = (x_sum + x, y_sum + y, z_sum + z);
                (xx, yy, xy) = (xx + x * x, yy + y * y, xy + x * y);
                (xz, yz, zz) = (xz + x * z, yz + y * z, zz + z * z);
            }
        }
        let about = |product: f64, a: f64, b: f64| product / count - a / count * (b / count);
        let (xx, yy, xy) = (about(xx, x_sum, x_sum), about(yy, y_sum, y_sum), about(xy, x_sum, y_sum));
        let (xz, yz, zz) = (about(xz, x_sum, z_sum), about(yz, y_sum, z_sum), about(zz, z_sum, z_sum));
        let determinant = xx * yy - xy * xy;
        let explained = if determinant > 1e-9 {
            let (a, b) = ((xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant);
            a * xz + b * yz
        } else {
            0.0
        };
        (zz - explained).max(0.0).sqrt()
    };
    (columns, (0..columns * rows).into_par_iter().map(of_cell).collect())
}
