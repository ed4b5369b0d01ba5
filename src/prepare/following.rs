//! Cells that follow the scenario's lines: which squares they replace, their ground and their water at the start.
//!
//! The ground of a cell is that of a plane at its centre, through the terrain points about it that no line parts from it. A bank beside a channel
//! does not reach into it, though their squares overlap.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::banks;
use super::findings::Findings;
use super::ground::Changes;
use super::places::{self, Drawn};
use crate::bed::{BedParticles, SHUT, Surface, plane_at_middle};
use crate::boundary::Pieces;
use crate::error::{Problem, ProblemKind, input_warning};
use crate::geodata::Crs;
use crate::lattice::{Cell, Conforming, Face, Lattice, NEIGHBOURS};
use crate::math::Vec2;
use crate::partition::{Line, LineKind, Partition};
use crate::scenario::Scenario;
use crate::scenario::methods::Motion;
use crate::seeding::StillWater;
use crate::solver::{ChannelEnd, Forcing, OpenEdges};
use crate::terrain::Piece;

/// Squares that stay as they are around what needs the lattice: boundaries, dams, cells in part.
const KEPT_AROUND: isize = 1;
/// Terrain points that a plane takes at least, where there are so many.
const POINTS: usize = 6;
/// By how much the circle about the centre grows until it holds them.
const WIDER: f64 = 1.25;
/// Farther away (spacings) they are left for what the terrain has at the centre.
const NEAR: f64 = 2.5;
/// How far (spacings) they are looked for at most.
const FARTHEST: f64 = 4.0;

/// Share of a way by which it is made longer to see whether its end lies on a line.
const ON_LINE: f64 = 1e-6;

/// The cells that follow lines, and what is on each of them.
#[derive(Clone, Debug)]
pub struct Following {
    /// The cells and their faces.
    pub conforming: Conforming,
    /// Bed (m) of each cell.
    pub elevation: Vec<f64>,
    /// Depth (m) of each cell at the start.
    pub depth: Vec<f64>,
    /// The body of water that fills each cell.
    pub body: Vec<Option<u32>>,
    /// Pieces of the scenario's lines (local coordinates, m), without walls.
    pub lines: Vec<[Vec2; 2]>,
    /// The banks that the terrain shows (map coordinates, m).
    pub banks: Vec<Vec<Vec2>>,
    /// Level (m) of the lowest ground along each face on a line; minus infinity of others.
    pub sills: Vec<f64>,
}

/// The lines of the files that cells follow.
pub(super) fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Vec<Drawn> {
    let lines = scenario.ground.followed.iter();
    lines.filter_map(|source| places::pieces(source, crs, scenario, findings)).collect()
}

/// Whether cells of a run follow lines; refuses lines of the scenario that none can follow.
fn is_followed(scenario: &Scenario, walls: &[[Vec2; 2]], findings: &mut Findings) -> bool {
    let ground = &scenario.ground;
    if scenario.numerics.motion != Motion::Lagrangian {
        return ground.follows_banks || !(ground.followed.is_empty() && walls.is_empty());
    }
    let banks = ground.follows_banks.then_some(("terrain.follow_banks", None));
    let lines = ground.followed.first().map(|lines| (lines.key.as_str(), lines.place.clone()));
    if let Some((key, place)) = lines.or(banks) {
        let message = "Lagrangian particles follow no lines";
        let problem = Problem::error(ProblemKind::Scenario, "method-combination", "", message)
            .with_cause("lines are followed by the sides of cells, and Lagrangian particles have none")
            .with_remedy("leave `numerics.motion` and `numerics.formulation` out, or take the line out");
        findings.add_at(key, place, problem);
    }
    false
}

/// The warning of a terrain that shows no bank.
fn no_banks() -> Problem {
    input_warning("no-banks", "the terrain shows no steep bank, so that no cell follows one".to_owned())
        .with_cause("no raster is as fine as the cells, or its ground rises evenly")
        .with_remedy("draw the banks as lines (`terrain.breaklines` with `mode: follow`), or take `follow_banks` out")
}

/// The cells that follow the scenario's lines; none without such lines, and on coarser levels, which have no `drawn` ones.
pub(super) fn find(
    scenario: &Scenario,
    drawn: Option<&[Drawn]>,
    ground: &super::ground::Ground<'_>,
    (forcing, open_edges, walls, still): (&Forcing, &OpenEdges, &[[Vec2; 2]], &StillWater),
    findings: &mut Findings,
) -> Option<Following> {
    let drawn = drawn?;
    let (bed, surface) = (ground.bed(), &ground.surface());
    let lattice = &bed.lattice;
    // Cells beside a line need two columns of places.
    if !is_followed(scenario, walls, findings) || lattice.columns < 2 {
        return None;
    }
    let (mut lines, mut followed) = (Vec::new(), Vec::new());
    for (source, drawn) in scenario.ground.followed.iter().zip(drawn) {
        let effect = "no cell has a side on it";
        let pieces = places::on_lattice(source, drawn, bed, effect, findings);
        followed.extend_from_slice(&pieces);
        lines.extend(joined(&pieces).map(|points| Line { points, is_closed: false, kind: LineKind::Follow }));
    }
    let banks =
        if scenario.ground.follows_banks { banks::find(ground.terrain(), lattice, &bed.constants) } else { Vec::new() };
    if scenario.ground.follows_banks && banks.is_empty() {
        findings.add_at("terrain.follow_banks", None, no_banks());
    }
    followed.extend(banks.iter().flat_map(|bank| bank.windows(2).map(|ends| [ends[0], ends[1]])));
    let as_line = |points: &Vec<Vec2>| Line { points: points.clone(), is_closed: false, kind: LineKind::Follow };
    lines.extend(banks.iter().map(as_line));
    lines.extend(joined(walls).map(|points| Line { points, is_closed: false, kind: LineKind::Wall }));
    let kept = kept(bed, (ground.changes(), walls), forcing, open_edges);
    let is_cell = |cell: usize| bed.has_terrain(cell) && !kept[cell];
    let is_kept = |cell: usize| bed.has_terrain(cell) && kept[cell];
    let conforming = Partition::new(lattice, is_cell, &lines).beside(lattice, is_kept).on(lattice);
    let parting: Pieces = lines.iter().flat_map(|line| line.points.windows(2).map(|ends| [ends[0], ends[1]])).collect();
    let ground = Ground { bed, surface, parting: &parting };
    let elevation: Vec<f64> = conforming.cells().par_iter().map(|cell| ground.at(cell.centre, cell.area)).collect();
    let water = |(cell, &z): (&Cell, &f64)| ground.water(cell, z, still).unwrap_or_default();
    let (depth, body) = conforming.cells().par_iter().zip(&elevation).map(water).unzip();
    Some(Following {
        depth,
        body,
        sills: conforming.faces().par_iter().map(|face| ground.crest(face)).collect(),
        lines: followed,
        banks: banks.into_iter().map(|bank| bank.into_iter().map(|place| lattice.to_map(place)).collect()).collect(),
        elevation,
        conforming,
    })
}

/// Lines through pieces that follow each other.
fn joined(pieces: &[[Vec2; 2]]) -> impl Iterator<Item = Vec<Vec2>> + '_ {
    pieces.chunk_by(|a, b| a[1] == b[0]).map(|pieces| {
        let ends = pieces.iter().map(|piece| piece[1]);
        std::iter::once(pieces[0][0]).chain(ends).collect()
    })
}

/// The squares that stay as they are: those at open edges, and what is on the lattice in another way. Levees and other ridges that a wall meets
/// hold on squares alone.
fn kept(
    bed: &BedParticles,
    (changes, walls): (&Changes, &[[Vec2; 2]]),
    forcing: &Forcing,
    open_edges: &OpenEdges,
) -> Vec<bool> {
    let lattice = &bed.lattice;
    let is_open = |cell: usize, step: (isize, isize)| {
        let normal = Vec2::new(step.0 as f64, step.1 as f64);
        let middle = lattice.centre(cell) + normal * (0.5 * lattice.spacing);
        let is_edge = lattice.neighbour(cell, step).is_none_or(|other| !bed.has_terrain(other));
        is_edge && (open_edges.is_open(middle, normal) || forcing.boundary_at(middle, normal).is_some())
    };
    let is_at_open_edge = |&cell: &usize| NEIGHBOURS.iter().any(|&step| is_open(cell, step));
    let mut cells: BTreeSet<usize> =
        (0..lattice.len()).filter(|&cell| bed.has_terrain(cell)).filter(is_at_open_edge).collect();
    cells.extend(bed.cover.cells().iter().map(|part| part.cell));
    if !walls.is_empty() {
        cells.extend(changes.raised().filter(|&cell| bed.has_terrain(cell)));
        let ridges = bed.passes.iter().filter(|sill| sill.level < SHUT);
        cells.extend(ridges.flat_map(|sill| [sill.cell, sill.other(lattice)]));
    }
    if let Some(breach) = &forcing.breach {
        cells.extend(breach.cells_and_rim());
    }
    cells.extend(forcing.moving_bed.iter().flat_map(|motion| motion.cells.iter().map(|(cell, _)| *cell)));
    let ends = forcing.channels.iter().flat_map(|channel| [&channel.far, &channel.near]);
    cells.extend(ends.flat_map(ChannelEnd::joined_cells));
    let mut kept = vec![false; lattice.len()];
    for cell in cells {
        around(lattice, cell, KEPT_AROUND).for_each(|near| kept[near] = true);
    }
    kept
}

/// The squares at most so many columns and rows from one.
fn around(lattice: &Lattice, cell: usize, reach: isize) -> impl Iterator<Item = usize> {
    let steps = (-reach..=reach).flat_map(move |up| (-reach..=reach).map(move |across| (across, up)));
    steps.filter_map(move |step| lattice.neighbour(cell, step))
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

    /// Depth (m) and body of the water at a cell, over its bed `z` (m): the level of a body, or the depth of other water, in the square about its
    /// centre, or in the first one that it shares and whose centre it sees.
    fn water(&self, cell: &Cell, z: f64, still: &StillWater) -> Option<(f64, Option<u32>)> {
        let lattice = &self.bed.lattice;
        let own = lattice.cell_at(cell.centre);
        let corners = cell.parts.iter().flatten().map(|&corner| cell.centre + (corner - cell.centre) * 0.99);
        let shared = corners.filter_map(|corner| lattice.cell_at(corner));
        let mut squares = own.into_iter().chain(shared).filter(|&square| self.bed.has_terrain(square));
        // The centre of a square that lies on a line is on neither side of it.
        let beyond = |place: Vec2| cell.centre + (place - cell.centre) * (1.0 + ON_LINE);
        let is_seen = |square: &usize| !self.parting.cross([cell.centre, beyond(lattice.centre(*square))]);
        let square = squares.find(is_seen).or(own).filter(|&square| still.depth[square] > 0.0)?;
        let (depth, body) = (still.depth[square], still.body[square]);
        let over_bed = |_| (self.bed.elevation[square] + depth - z).max(0.0);
        Some((body.map_or(depth, over_bed), body))
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
