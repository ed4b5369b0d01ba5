//! Cells that follow the scenario's lines and the outlines of its blocked buildings: which squares they replace, their ground and their water at
//! the start.
//!
//! The ground of a cell is that of a plane at its centre, through the terrain points about it that no line parts from it. A bank beside a channel
//! does not reach into it, though their squares overlap.

mod kept;
mod small;
mod water;

use rayon::prelude::*;

use super::banks;
use super::findings::Findings;
use super::ground::{self, wall_gaps};
use super::places::{self, Drawn};
use super::water::SourcedBody;
use crate::bed::{BedParticles, Surface, least_step, plane_at_middle};
use crate::boundary::Pieces;
use crate::constants::SeedingConstants;
use crate::error::{Problem, ProblemKind};
use crate::geodata::Crs;
use crate::lattice::{Conforming, Face, Lattice};
use crate::math::Vec2;
use crate::partition::{Line, LineKind, Partition};
use crate::scenario::Scenario;
use crate::seeding::StillWater;
use crate::solver::{Forcing, OpenEdges};
use crate::terrain::Piece;
use water::Cells;

/// Terrain points that a plane takes at least, where there are so many.
const POINTS: usize = 6;
/// By how much the circle about the centre grows until it holds them.
const WIDER: f64 = 1.25;
/// Farther away (spacings) they are left for what the terrain has at the centre.
const NEAR: f64 = 2.5;
/// How far (spacings) they are looked for at most.
const FARTHEST: f64 = 4.0;

/// Squares beside a ridge at which no bank is followed.
const BESIDE_RIDGE: isize = 2;

/// The cells that follow lines, and what is on each of them.
#[derive(Clone, Debug)]
pub struct Following {
    /// The cells and their faces.
    pub conforming: Conforming,
    /// Bed (m) of each cell.
    pub elevation: Vec<f64>,
    /// Their water at the start.
    pub start: WaterAtStart,
    /// Pieces of the scenario's lines (local coordinates, m), without walls.
    pub lines: Vec<[Vec2; 2]>,
    /// The banks that the terrain shows (map coordinates, m).
    pub banks: Vec<Vec<Vec2>>,
    /// Level (m) of the lowest ground along each face on a line; minus infinity of others.
    pub sills: Vec<f64>,
}

/// The water of the start in cells that follow lines.
#[derive(Clone, Debug)]
pub struct WaterAtStart {
    /// The square whose water each cell has, and its velocity; none beside squares without terrain.
    pub squares: Vec<Option<usize>>,
    /// Depth (m) of each cell.
    pub depth: Vec<f64>,
    /// The body of water that fills each cell.
    pub body: Vec<Option<u32>>,
    /// Volume (m³) that each body of still water has in these cells beyond that in the squares that they replace, at its mean depth there.
    pub beyond_squares: Vec<f64>,
}

impl Following {
    /// Whether a cell holds a place (local coordinates, m), or a building; none where squares decide.
    pub fn holds(&self, lattice: &Lattice, place: Vec2) -> Option<bool> {
        let square = lattice.cell_of(place)?;
        self.conforming.instead_of(square).map(|_| self.conforming.cell_at(square, place).is_some())
    }
}

/// The lines of the files that cells follow.
pub(super) fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Vec<Drawn> {
    let lines = scenario.ground.followed.iter();
    lines.filter_map(|source| places::pieces(source, crs, scenario, findings)).collect()
}

/// Refuses lines of the scenario that no cells can follow.
fn check(scenario: &Scenario, findings: &mut Findings) {
    let ground = &scenario.ground;
    let banks = ground.follows_banks.then_some(("terrain.follow_banks", None));
    let lines = ground.followed.first().map(|lines| (lines.key.as_str(), lines.place.clone()));
    if let (false, Some((key, place))) = (scenario.numerics.has_cells(), lines.or(banks)) {
        let message = "the particles of the variational formulation follow no lines";
        let problem = Problem::error(ProblemKind::Scenario, "method-combination", "", message)
            .with_cause("lines are followed by the sides of cells, and these particles have none")
            .with_remedy("leave `numerics.formulation` out, or take the line out");
        findings.add_at(key, place, problem);
    }
}

/// The steep banks that the terrain shows (local coordinates, m), where cells are to follow them: those with none of the `given` lines within a cell
/// of them, and not on the ground of a lake. Beside raised or carved ground and ridges narrower than a cell squares stay, for such ground holds on
/// them alone.
fn banks(scenario: &Scenario, ground: &ground::Ground<'_>, (given, still): (&Pieces, &StillWater)) -> Vec<Vec<Vec2>> {
    if !scenario.ground.follows_banks {
        return Vec::new();
    }
    let bed = ground.bed();
    let lattice = &bed.lattice;
    let least = least_step(lattice.spacing, &bed.constants);
    let ridges = bed.passes.iter().map(|sill| (sill.level, [sill.cell, sill.other(lattice)]));
    let is_ridge = |&(level, cells): &(f64, [usize; 2])| cells.iter().all(|&cell| level >= bed.elevation[cell] + least);
    let shaped = (0..lattice.len()).filter(|&cell| ground.changes().moves(cell));
    let mut holds = vec![false; lattice.len()];
    for cell in shaped.chain(ridges.filter(is_ridge).flat_map(|(_, cells)| cells)) {
        kept::around(lattice, cell, BESIDE_RIDGE).for_each(|near| holds[near] = true);
    }
    let is_in_lake = |place: Vec2| lattice.cell_at(place).is_some_and(|cell| still.body[cell].is_some());
    let is_held = |way: [Vec2; 2]| way.iter().any(|&place| lattice.cell_at(place).is_some_and(|cell| holds[cell]));
    let is_given = |[higher, lower]: [Vec2; 2]| {
        let beyond = (lower - higher) * (lattice.spacing / (lower - higher).norm());
        given.cross([higher - beyond, lower + beyond])
    };
    banks::find(ground.terrain(), lattice, &bed.constants, |way| !is_in_lake(way[0]) && !is_held(way) && !is_given(way))
}

/// What the run has beside lines: forcing, open edges, walls, bodies of still water as drawn and as filled.
type Beside<'a> = (&'a Forcing, &'a OpenEdges, &'a [[Vec2; 2]], (&'a [SourcedBody<'a>], &'a StillWater));

/// The cells that follow the scenario's lines and the outlines of blocked buildings; none without such lines, and on coarser levels, which have no
/// `drawn` ones. Warns of gaps between walls where squares stay.
pub(super) fn find(
    scenario: &Scenario,
    drawn: Option<(&[Drawn], &ground::Opened)>,
    ground: &ground::Ground<'_>,
    beside: Beside<'_>,
    findings: &mut Findings,
) -> Option<Following> {
    let found = along(scenario, drawn?, ground, beside, findings);
    let is_square = |cell: usize| found.as_ref().is_none_or(|found| found.conforming.instead_of(cell).is_none());
    wall_gaps::check(scenario, beside.2, (ground.bed(), is_square), findings);
    found
}

/// The cells along these lines.
fn along(
    scenario: &Scenario,
    (drawn, built): (&[Drawn], &ground::Opened),
    ground: &ground::Ground<'_>,
    (forcing, open_edges, walls, (bodies, still)): Beside<'_>,
    findings: &mut Findings,
) -> Option<Following> {
    let (bed, surface) = (ground.bed(), &ground.surface_beside_buildings());
    let lattice = &bed.lattice;
    check(scenario, findings);
    // Cells beside a line need two columns of places.
    if !scenario.numerics.has_cells() || lattice.columns < 2 {
        return None;
    }
    let line = |kind: LineKind| move |points: Vec<Vec2>| Line { points, is_closed: false, kind };
    let (mut lines, mut followed) = (Vec::new(), Vec::new());
    for (source, drawn) in scenario.ground.followed.iter().zip(drawn) {
        let pieces = places::on_lattice(source, drawn, bed, "no cell has a side on it", findings);
        followed.extend_from_slice(&pieces);
        lines.extend(joined(&pieces).map(line(LineKind::Follow)));
    }
    let outlines = ground::outlines(built, scenario, lattice);
    let of_outlines = outlines.iter().flatten().flat_map(Line::pieces);
    let given: Pieces = followed.iter().chain(walls).copied().chain(of_outlines).collect();
    let banks = banks(scenario, ground, (&given, still));
    followed.extend(banks.iter().flat_map(|bank| bank.windows(2).map(|ends| [ends[0], ends[1]])));
    lines.extend(banks.iter().cloned().map(line(LineKind::Follow)));
    lines.extend(joined(walls).map(line(LineKind::Wall)));
    if lines.is_empty() && outlines.is_empty() {
        return None;
    }
    let are_walls = !(walls.is_empty() && outlines.is_empty());
    let kept = kept::kept(bed, (ground.changes(), are_walls), forcing, open_edges);
    small::report(scenario, &outlines, (bed, &kept), findings);
    let around = outlines.iter().flatten().flat_map(Line::pieces);
    wall_gaps::check_narrow(scenario, (walls, around), (bed, &kept), findings);
    lines.extend(outlines.into_iter().flatten());
    let is_cell = |cell: usize| (bed.has_terrain(cell) || kept::is_built(bed, cell)) && !kept[cell];
    let is_kept = |cell: usize| bed.has_terrain(cell) && kept[cell];
    let conforming = Partition::new(lattice, is_cell, &lines).beside(lattice, is_kept).on(lattice);
    let parting: Pieces = lines.iter().flat_map(Line::pieces).collect();
    let seeding = ground.seeding();
    let ground = Ground { bed, surface, parting: &parting };
    let elevation: Vec<f64> = conforming.cells().par_iter().map(|cell| ground.at(cell.centre, cell.area)).collect();
    let sills: Vec<f64> = conforming.faces().par_iter().map(|face| ground.crest(face)).collect();
    let walls: Pieces = walls.iter().copied().collect();
    let cells =
        Cells { conforming: &conforming, elevation: &elevation, sills: &sills, parting: &parting, walls: &walls };
    let goes_on = scenario.start.earlier.is_some();
    Some(Following {
        start: water_at_start(&cells, (bed, still), (bodies, goes_on), seeding),
        sills,
        lines: followed,
        banks: banks.into_iter().map(|bank| bank.into_iter().map(|place| lattice.to_map(place)).collect()).collect(),
        elevation,
        conforming,
    })
}

/// The water of the start in some cells; `goes_on` where it is that of an earlier run.
fn water_at_start(
    cells: &Cells<'_>,
    (bed, still): (&BedParticles, &StillWater),
    (bodies, goes_on): (&[SourcedBody], bool),
    seeding: &SeedingConstants,
) -> WaterAtStart {
    let squares = cells.squares(bed);
    let (mut depth, mut body) = cells.water_of_squares(&squares, (bed, still), goes_on);
    let beyond_squares = beyond_squares(cells.conforming, &body, bed, still);
    cells.go_on((bed, still), (bodies, seeding), (&mut depth, &mut body));
    WaterAtStart { squares, depth, body, beyond_squares }
}

/// Of each body of still water its mean depth (m) in the squares that cells replace, times what these have of area beyond those: without buildings
/// nothing.
fn beyond_squares(conforming: &Conforming, body: &[Option<u32>], bed: &BedParticles, still: &StillWater) -> Vec<f64> {
    let replaced = |square: &usize| conforming.instead_of(*square).is_some();
    let squares: Vec<usize> = (0..bed.lattice.len()).filter(replaced).collect();
    let of_body = |number: usize| {
        let is_its = |body: Option<u32>| body.is_some_and(|body| body as usize == number);
        let area: f64 =
            conforming.cells().iter().zip(body).filter(|(_, b)| is_its(**b)).map(|(cell, _)| cell.area).sum();
        let own = || squares.iter().filter(|&&square| is_its(still.body[square]));
        let (of_squares, volume) = own().fold((0.0, 0.0), |(area, volume), &square| {
            (area + bed.area(square), volume + bed.area(square) * still.depth[square])
        });
        if of_squares > 0.0 { volume / of_squares * (area - of_squares) } else { 0.0 }
    };
    (0..still.volumes.len()).map(of_body).collect()
}

/// Lines through pieces that follow each other.
fn joined(pieces: &[[Vec2; 2]]) -> impl Iterator<Item = Vec<Vec2>> + '_ {
    pieces.chunk_by(|a, b| a[1] == b[0]).map(|pieces| {
        let ends = pieces.iter().map(|piece| piece[1]);
        std::iter::once(pieces[0][0]).chain(ends).collect()
    })
}

/// The ground, with what parts it.
struct Ground<'a, Terrain> {
    bed: &'a BedParticles,
    surface: &'a Terrain,
    parting: &'a Pieces,
}

impl<Terrain: Surface> Ground<'_, Terrain> {
    /// The bed (m) of a cell, by its centre (local) and its area (m²).
    fn at(&self, centre: Vec2, area: f64) -> f64 {
        let lattice = &self.bed.lattice;
        let mut radius = (area / std::f64::consts::PI).sqrt();
        let mut seen: Vec<Piece> = Vec::new();
        while seen.len() < POINTS && radius <= FARTHEST * lattice.spacing {
            let mut points = Vec::new();
            self.surface.samples(lattice.to_map(centre), radius, &mut points);
            let piece = |(place, elevation)| Piece { offset: lattice.to_local(place) - centre, elevation, share: 1.0 };
            let is_seen = |piece: &Piece| !self.parting.cross([centre, centre + piece.offset]);
            seen = points.into_iter().map(piece).filter(is_seen).collect();
            radius *= WIDER;
        }
        // Points so far away that the terrain is coarser than the cells say less than what lies between them.
        let is_near = seen.len() >= POINTS && radius <= WIDER * NEAR * lattice.spacing;
        let plane = || (!seen.is_empty()).then(|| plane_at_middle(&seen));
        let of_square = || lattice.cell_at(centre).map_or(f64::NAN, |cell| self.bed.elevation[cell]);
        let at_centre = || self.surface.elevation(lattice.to_map(centre));
        let found = if is_near { plane() } else { at_centre().or_else(plane) };
        found.unwrap_or_else(of_square)
    }

    /// The lowest ground (m) along a face on a line: that of a dike's crest. Elsewhere a bank beside the face would count as a ridge in it.
    fn crest(&self, &Face { from, to, line, .. }: &Face) -> f64 {
        if line.is_none() {
            return f64::NEG_INFINITY;
        }
        let lattice = &self.bed.lattice;
        let count = (8.0 * (to - from).norm() / lattice.spacing).ceil().max(1.0) as usize;
        let place = |k: usize| from + (to - from) * ((k as f64 + 0.5) / count as f64);
        let heights = (0..count).filter_map(|k| self.surface.elevation(lattice.to_map(place(k))));
        let lowest = heights.fold(f64::INFINITY, f64::min);
        if lowest.is_finite() { lowest } else { f64::NEG_INFINITY }
    }
}
