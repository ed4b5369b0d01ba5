//! The water of the start in cells that follow lines.
//!
//! A cell has the water of a square whose centre it sees: up to the level of a body of still water, or as deep as other water. Its ground is its
//! own, though, and may lie below a level above which that of the square does. So a body goes on from cell to cell:
//!
//! 1. into all those of its polygon that lie below its level and that it reaches over no wall and no sill as high as the level, but for those whose
//!    square it does not get to, beyond a wall;
//! 2. beyond its polygon into pockets, which end within some cells ([`SeedingConstants`]); other ground below the level is open.
//!
//! [`SeedingConstants`]: crate::constants::SeedingConstants

use std::collections::BTreeSet;

use geo::Contains;
use rayon::prelude::*;

use crate::bed::BedParticles;
use crate::boundary::Pieces;
use crate::constants::SeedingConstants;
use crate::lattice::{Cell, Conforming, Face, Side};
use crate::math::Vec2;
use crate::prepare::water::SourcedBody;
use crate::seeding::StillWater;

/// Share of a way by which it is made longer to see whether its end lies on a line.
const ON_LINE: f64 = 1e-6;

/// Cells that follow lines, and their ground.
pub(super) struct Cells<'a> {
    pub conforming: &'a Conforming,
    /// Bed (m) of each cell.
    pub elevation: &'a [f64],
    /// Level (m) of the lowest ground along each face on a line; minus infinity of others.
    pub sills: &'a [f64],
    /// Lines that no cell sees over.
    pub parting: &'a Pieces,
    /// Those of them that are walls.
    pub walls: &'a Pieces,
}

impl Cells<'_> {
    /// Depth (m) of the water at each cell by the square whose water it has, and the body of still water that fills it.
    ///
    /// - `goes_on`: whether this is water of an earlier run, which has a level, too; it is at most twice as deep as in the square (M98)
    pub fn water_of_squares(
        &self,
        squares: &[Option<usize>],
        (bed, still): (&BedParticles, &StillWater),
        goes_on: bool,
    ) -> (Vec<f64>, Vec<Option<u32>>) {
        let water = |(&square, &z): (&Option<usize>, &f64)| {
            let Some(square) = square.filter(|&square| still.depth[square] > 0.0) else { return (0.0, None) };
            let (depth, body) = (still.depth[square], still.body[square]);
            let above = bed.elevation[square] + depth - z;
            let own = match body {
                Some(_) => above.max(0.0),
                None if goes_on => above.max(0.0).min(2.0 * depth),
                None => depth,
            };
            (own, body)
        };
        squares.par_iter().zip(self.elevation).map(water).unzip()
    }

    /// Lets bodies of still water go on into the cells that they reach.
    ///
    /// - `bed`, `still`: the squares and their water
    /// - `bodies`: polygons and levels of still water
    /// - `depth`, `body`: of the cells
    pub fn go_on(
        &self,
        (bed, still): (&BedParticles, &StillWater),
        (bodies, constants): (&[SourcedBody], &SeedingConstants),
        (depth, body): (&mut [f64], &mut [Option<u32>]),
    ) {
        if bodies.is_empty() {
            return;
        }
        let reach = Reach { cells: self, ways: self.ways(bed), bed, still };
        for (number, SourcedBody { body: drawn, .. }) in (0..).zip(bodies) {
            let lake = Lake { number, level: drawn.level, depth, body };
            let is_inside = |cell: usize| {
                let centre = self.conforming.cells()[cell].centre;
                let place = bed.lattice.to_map(centre);
                // A square that lies below the level and has no water is one that the lake does not get to, beyond a wall.
                let is_left_dry = |square: usize| still.depth[square] <= 0.0 && bed.elevation[square] < lake.level;
                drawn.polygon.contains(&geo::Coord { x: place.x, y: place.y })
                    && !bed.lattice.cell_at(centre).is_some_and(is_left_dry)
            };
            for cell in reach.filled(&lake, is_inside, constants) {
                depth[cell] = drawn.level - self.elevation[cell];
                body[cell] = Some(number);
            }
        }
    }

    /// Of each cell what lies beyond its faces that no wall crosses, as in the core, and their sills (m).
    fn ways(&self, bed: &BedParticles) -> Vec<Vec<(Side, f64)>> {
        let centre = |side: Side| match side {
            Side::Cell(cell) => Some(self.conforming.cells()[cell].centre),
            Side::Lattice(square) => Some(bed.lattice.centre(square)),
            Side::Wall | Side::Nothing => None,
        };
        let mut ways = vec![Vec::new(); self.elevation.len()];
        for (face, &sill) in self.conforming.faces().iter().zip(self.sills) {
            let is_walled = |side| centre(side).is_none_or(|place| self.walls.cross([place, face.middle()]));
            if face.sides.into_iter().any(is_walled) {
                continue;
            }
            for [own, other] in [face.sides, [face.sides[1], face.sides[0]]] {
                if let Side::Cell(cell) = own {
                    ways[cell].push((other, sill));
                }
            }
        }
        ways
    }

    /// Of each cell the square whose water it has: that about its centre, or the first one that it shares and whose centre it sees; where there is
    /// none, that of a cell beside it.
    pub fn squares(&self, bed: &BedParticles) -> Vec<Option<usize>> {
        let mut squares: Vec<Option<usize>> =
            self.conforming.cells().par_iter().map(|cell| self.square_seen(cell, bed)).collect();
        loop {
            let mut found: Vec<(usize, usize)> = Vec::new();
            for Face { sides, .. } in self.conforming.faces() {
                let of = |side: Side| match side {
                    Side::Cell(cell) => squares[cell],
                    Side::Lattice(square) => Some(square),
                    Side::Wall | Side::Nothing => None,
                };
                for (own, other) in [(sides[0], sides[1]), (sides[1], sides[0])] {
                    if let (Side::Cell(cell), None, Some(square)) = (own, of(own), of(other)) {
                        found.push((cell, square));
                    }
                }
            }
            if found.is_empty() {
                return squares;
            }
            found.iter().rev().for_each(|&(cell, square)| squares[cell] = Some(square));
        }
    }

    fn square_seen(&self, cell: &Cell, bed: &BedParticles) -> Option<usize> {
        let lattice = &bed.lattice;
        let own = lattice.cell_at(cell.centre);
        let corners = cell.parts.iter().flatten().map(|&corner| cell.centre + (corner - cell.centre) * 0.99);
        let shared = corners.filter_map(|corner| lattice.cell_at(corner));
        let mut squares = own.into_iter().chain(shared).filter(|&square| bed.has_terrain(square));
        // The centre of a square that lies on a line is on neither side of it.
        let beyond = |place: Vec2| cell.centre + (place - cell.centre) * (1.0 + ON_LINE);
        squares.find(|&square| !self.parting.cross([cell.centre, beyond(lattice.centre(square))]))
    }
}

/// How water goes on from cell to cell.
struct Reach<'a> {
    cells: &'a Cells<'a>,
    /// Of each cell what lies beyond its faces, and their sills (m).
    ways: Vec<Vec<(Side, f64)>>,
    bed: &'a BedParticles,
    still: &'a StillWater,
}

/// A body of still water in the cells that it has filled so far.
struct Lake<'a> {
    number: u32,
    level: f64,
    depth: &'a [f64],
    body: &'a [Option<u32>],
}

impl Reach<'_> {
    /// Whether a cell has no water, and ground below the level of a lake.
    fn is_gap(&self, cell: usize, lake: &Lake<'_>) -> bool {
        lake.depth[cell] <= 0.0 && self.cells.elevation[cell] < lake.level
    }

    /// What lies beyond the faces of a cell that the water of a lake passes.
    fn beyond(&self, cell: usize, level: f64) -> impl Iterator<Item = Side> + '_ {
        self.ways[cell].iter().filter(move |(_, sill)| *sill < level).map(|(side, _)| *side)
    }

    /// The gaps beside some cells.
    fn gaps<'b>(&'b self, cells: impl IntoIterator<Item = &'b usize>, lake: &'b Lake<'_>) -> BTreeSet<usize> {
        let sides = cells.into_iter().flat_map(|&cell| self.beyond(cell, lake.level));
        let cell = |side: Side| match side {
            Side::Cell(cell) => Some(cell),
            Side::Lattice(_) | Side::Wall | Side::Nothing => None,
        };
        sides.filter_map(cell).filter(|&cell| self.is_gap(cell, lake)).collect()
    }

    /// Whether a cell has the water of a lake beside it.
    fn is_beside_water(&self, cell: usize, lake: &Lake<'_>) -> bool {
        let is_its = |depth: f64, body: Option<u32>| depth > 0.0 && body == Some(lake.number);
        self.beyond(cell, lake.level).any(|side| match side {
            Side::Cell(other) => is_its(lake.depth[other], lake.body[other]),
            Side::Lattice(square) => is_its(self.still.depth[square], self.still.body[square]),
            Side::Wall | Side::Nothing => false,
        })
    }

    /// Whether a cell has a square beside it into which a lake would run: ground or other water below its level.
    fn is_beside_lower_square(&self, cell: usize, lake: &Lake<'_>) -> bool {
        let surface = |square: usize| self.bed.elevation[square] + self.still.depth[square];
        self.beyond(cell, lake.level).any(|side| match side {
            Side::Lattice(square) => self.still.body[square] != Some(lake.number) && surface(square) < lake.level,
            Side::Cell(_) | Side::Wall | Side::Nothing => false,
        })
    }

    /// The gaps that a lake fills: all that it reaches inside its polygon, and pockets beyond.
    fn filled(
        &self,
        lake: &Lake<'_>,
        is_inside: impl Fn(usize) -> bool,
        constants: &SeedingConstants,
    ) -> BTreeSet<usize> {
        let cells = 0..lake.depth.len();
        let mut newest: BTreeSet<usize> =
            cells.filter(|&cell| self.is_gap(cell, lake) && self.is_beside_water(cell, lake)).collect();
        let (mut filled, mut near) = (BTreeSet::new(), BTreeSet::new());
        while !newest.is_empty() {
            let (inside, outside): (Vec<usize>, Vec<usize>) = newest.into_iter().partition(|&cell| is_inside(cell));
            near.extend(outside);
            filled.extend(&inside);
            newest = self.gaps(&inside, lake);
            newest.retain(|cell| !filled.contains(cell) && !near.contains(cell));
        }
        newest.clone_from(&near);
        for _ in 0..constants.pocket_reach {
            near.extend(&newest);
            newest = self.gaps(&newest, lake);
            newest.retain(|cell| !filled.contains(cell) && !near.contains(cell));
        }
        near.extend(&newest);
        let mut open = newest;
        open.extend(near.iter().filter(|&&cell| self.is_beside_lower_square(cell, lake)));
        let mut newest = open.clone();
        for _ in 0..constants.pocket_reach + constants.pocket_steps {
            newest = self.gaps(&newest, lake);
            newest.retain(|cell| near.contains(cell) && !open.contains(cell));
            open.extend(&newest);
        }
        filled.extend(near.difference(&open));
        filled
    }
}
