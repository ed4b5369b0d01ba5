//! Walls, blocked buildings and edges of the terrain oblique to the lattice.

use std::cmp::Ordering;

use super::{Scene, Warned, of};
use crate::boundary::{Edge, outline};
use crate::error::input_warning;
use crate::math::Vec2;
use crate::scenario::Scenario;

/// A wall is askew from this angle to the lattice on (tangent; one degree), where it is longer than so many spacings.
const ASKEW: (f64, f64) = (0.0175, 3.0);
/// Edges of an outline join where they meet within this share of their length.
const JOINED: f64 = 1e-6;
/// So many turns to one side and the other make stairs.
const LEAST_TURNS: usize = 3;

impl Scene<'_> {
    /// Walls, blocked buildings and edges of the terrain that lie askew to the lattice: the longest piece of each kind.
    pub(super) fn askew_walls(&self, scenario: &Scenario) -> Vec<Warned> {
        let (bed, lattice) = (self.bed, &self.bed.lattice);
        let warned = |what: &str, [start, end]: [Vec2; 2]| {
            let along = end - start;
            let angle = f64::atan2(along.x.abs().min(along.y.abs()), along.x.abs().max(along.y.abs())).to_degrees();
            let message = format!(
                "{what} {angle:.0} degrees askew to the lattice slows the water along it with Lagrangian particles"
            );
            let cause = "along such walls the speed was 0.82 of the exact one in uniform flow, and 3.8 m/s for 7.96 m/s behind an oblique jump";
            input_warning("lagrangian-askew-wall", message)
                .with_cause(cause)
                .with_at(lattice.to_map((start + end) * 0.5))
        };
        let mut found = Vec::new();
        for (source, pieces) in scenario.walls.iter().zip(&self.walls) {
            found.extend(
                longest(pieces.iter().copied().filter(|piece| self.is_askew(*piece)))
                    .map(|piece| of(source, warned("a wall", piece))),
            );
        }
        let top = self.highest_water();
        let edges: Vec<Edge> = outline(bed, self.is_open).into_iter().filter(|edge| !edge.is_open).collect();
        let straight = edges.iter().map(|edge| [edge.start, edge.end]).chain(stairs(&edges));
        let edges: Vec<[Vec2; 2]> =
            straight.filter(|&edge| self.is_askew(edge) && self.ground_beside(edge) < top).collect();
        let (blocked, without_data): (Vec<_>, Vec<_>) = edges.into_iter().partition(|&edge| self.is_of_building(edge));
        if let (Some(buildings), Some(edge)) = (&scenario.ground.buildings, longest(blocked.into_iter())) {
            found.push(of(&buildings.polygons, warned("a blocked building", edge)));
        }
        if let (Some(layer), Some(edge)) = (scenario.layers.first(), longest(without_data.into_iter())) {
            found.push(of(layer, warned("the edge of the terrain (or of an area without data)", edge)));
        }
        found
    }

    /// Whether a piece is long enough and lies askew to the lattice.
    fn is_askew(&self, [start, end]: [Vec2; 2]) -> bool {
        let along = end - start;
        let (least, most) = (along.x.abs().min(along.y.abs()), along.x.abs().max(along.y.abs()));
        least > ASKEW.0 * most && along.norm() > ASKEW.1 * self.bed.lattice.spacing
    }

    /// The lowest ground (m) in the cells beside an edge.
    fn ground_beside(&self, edge: [Vec2; 2]) -> f64 {
        let cells = self.cells_beside(edge).filter(|&cell| self.bed.has_terrain(cell));
        cells.map(|cell| self.bed.elevation[cell]).fold(f64::INFINITY, f64::min)
    }

    /// Whether an edge is that of a blocked building.
    fn is_of_building(&self, edge: [Vec2; 2]) -> bool {
        self.cells_beside(edge).any(|cell| self.bed.sealed.binary_search(&cell).is_ok())
    }

    /// The cells along an edge and around them.
    fn cells_beside(&self, [start, end]: [Vec2; 2]) -> impl Iterator<Item = usize> + '_ {
        let lattice = &self.bed.lattice;
        let pieces = ((end - start).norm() / lattice.spacing).ceil().max(1.0) as usize;
        let places = (0..=pieces).map(move |k| start + (end - start) * (k as f64 / pieces as f64));
        places.flat_map(move |place| {
            let steps = [-1.0, 0.0, 1.0].map(|step| step * lattice.spacing);
            let around = steps.into_iter().flat_map(move |x| steps.map(|y| Vec2::new(x, y)));
            around.filter_map(move |step| lattice.cell_at(place + step))
        })
    }
}

/// Stairs of an outline as straight pieces from their first to their last corner: edges that turn to one side and the other in turn, which
/// a wall askew to the lattice makes of itself. One step alone is a step of the wall.
fn stairs(edges: &[Edge]) -> Vec<[Vec2; 2]> {
    let mut found = Vec::new();
    let turn = |a: &Edge, b: &Edge| {
        let joins = (a.end - b.start).norm() <= JOINED * (a.end - a.start).norm();
        let turn = (a.end - a.start).cross(b.end - b.start);
        turn.partial_cmp(&0.0).filter(|_| joins).unwrap_or(Ordering::Equal)
    };
    let mut first = 0;
    while first < edges.len() {
        let mut last = first;
        let mut before = Ordering::Equal;
        while let Some(next) = edges.get(last + 1) {
            let turn = turn(&edges[last], next);
            if turn == Ordering::Equal || turn == before {
                break;
            }
            (before, last) = (turn, last + 1);
        }
        if last - first >= LEAST_TURNS {
            found.push([edges[first].start, edges[last].end]);
        }
        first = last.max(first + 1);
    }
    found
}

/// The longest of some pieces.
fn longest(pieces: impl Iterator<Item = [Vec2; 2]>) -> Option<[Vec2; 2]> {
    pieces.max_by(|a, b| (a[1] - a[0]).norm().total_cmp(&(b[1] - b[0]).norm()))
}
