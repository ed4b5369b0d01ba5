//! Cells in part: what of its cell a riverbed particle stands for, where the terrain ends inside the cell.
//!
//! A lattice need not divide the terrain, and rasters of unlike origin end anywhere. A cell belongs to the terrain by its centre. It
//! stands for the part of it that the terrain covers, and for what the terrain covers of cells beyond its edge:
//!
//! ```text
//! (M13)  φ_i = (1/Δ²) (area of terrain in cell i and in its share of the cells beyond),   ¼ ≤ φ_i ≤ 9/4
//! (M14)  w_ik = (1/Δ) (length of that area across the way to side k),   ψ_ij = (1/Δ) (length that i and j have in common)
//! ```
//!
//! so that the area of all cells is that of the terrain, whatever the spacing. The bounds hold for rasters at least two cells wide. What is
//! covered follows from the rectangles of the rasters; a piece beyond the edge counts where there are data in its middle. Data that are
//! missing inside of a raster take whole cells, as blocked buildings do, and two cells with terrain have what both span in common: a
//! narrow gap between rasters is no wall.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use rayon::prelude::*;

use super::{BedParticles, Surface};
use crate::lattice::{Lattice, Level, NEIGHBOURS};
use crate::math::{Rectangle, Vec2};
use crate::terrain::Terrain;

/// Edges that lie so near to a line of the lattice or to the middles of its cells (in cells) lie on it: the round-off of map coordinates.
const ON_A_LINE: f64 = 1e-6;
/// How far from its south-western corner (in cells) rectangles count for a cell: as far as the cells beside it.
const ABOUT: f64 = 2.5;
/// Parts that differ from a whole by less are whole.
const ROUNDING: f64 = 1e-9;

/// A cell that is not just itself.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CellInPart {
    /// Its index.
    pub cell: usize,
    /// Its area over that of a cell, φ.
    pub area: f64,
    /// Lengths of its sides to the east, west, north and south, over the spacing: w.
    pub sides: [f64; 4],
    /// From the middle of the cell to that of what is covered of it, over the spacing.
    pub middle: Vec2,
}

impl CellInPart {
    /// From the middle of the cell to where the terrain ends beyond a side, over the spacing: φ/w − ½.
    pub fn reach(&self, way: usize) -> f64 {
        let side = self.sides[way];
        if side > ROUNDING { (self.area / side - 0.5).clamp(0.0, 1.5) } else { 0.5 }
    }
}

/// A face of a cell in part.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FaceInPart {
    /// Row and column, from 1, of the cell to the west or south of it; 0 is beyond the lattice.
    pub place: (usize, usize),
    /// Whether the other cell lies to the north; to the east otherwise.
    pub is_north: bool,
    /// The length through which water passes, over the spacing: ψ; where the other cell has no terrain the length of the side.
    pub open: f64,
    /// The lengths of the sides of the two cells that it parts.
    pub sides: [f64; 2],
}

/// All cells and faces in part; all others are whole.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Cover {
    /// In ascending order.
    cells: Vec<CellInPart>,
    faces: Vec<FaceInPart>,
    /// Cells without terrain of which a part belongs to cells beside them; ascending.
    given: Vec<usize>,
}

impl Cover {
    /// Those of all levels of a nested lattice, each of which was found on a lattice of its own; the finest first.
    pub(crate) fn stacked<'a>(
        levels: impl Iterator<Item = (&'a Cover, Level)>,
        cell_of: impl Fn(Level, usize) -> usize,
    ) -> Cover {
        let mut all = Cover::default();
        for (cover, level) in levels {
            let cells = cover.cells.iter().map(|part| CellInPart { cell: cell_of(level, part.cell), ..*part });
            all.cells.extend(cells);
            let place = |(row, column): (usize, usize)| (row + level.first_row, column);
            all.faces.extend(cover.faces.iter().map(|face| FaceInPart { place: place(face.place), ..*face }));
            all.given.extend(cover.given.iter().map(|&cell| cell_of(level, cell)));
        }
        all
    }

    /// Finds the cells in part of a bed.
    ///
    /// - `terrain`: its rasters end along straight lines, its survey points along none
    /// - `surface`: the terrain with what is built on it
    pub fn find(terrain: &Terrain, surface: &impl Surface, bed: &BedParticles) -> Cover {
        let lattice = &bed.lattice;
        let rasters = terrain.extents_of_rasters();
        let ends: Vec<Rectangle> = rasters.map(|extent| in_cells(extent, lattice)).collect();
        let near = near_ends(&ends, lattice);
        if near.is_empty() {
            return Cover::default();
        }
        let all = Extent { ends, terrain, surface, bed };
        let gifts = all.gifts(&near);
        let mut taken_by: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (&given, gift) in &gifts {
            gift.takers.iter().for_each(|&taker| taken_by.entry(taker).or_default().push(given));
        }
        let part = |&cell: &usize| {
            let extent = all.about(cell);
            let taken = taken_by.get(&cell).map_or(&[][..], Vec::as_slice);
            let shares = taken.iter().map(|given| gifts[given].area / gifts[given].takers.len() as f64);
            let (covered, middle) = extent.covered(cell);
            let own = |other: usize| taken.contains(&other) && gifts[&other].takers.len() == 1;
            let sides = [0, 1, 2, 3].map(|way| extent.side(cell, way, &own));
            let part = CellInPart { cell, area: covered + shares.sum::<f64>(), sides, middle };
            (covered > 0.0 && !part.is_whole()).then_some(part)
        };
        let with_terrain: Vec<usize> = near.into_iter().filter(|&cell| bed.has_terrain(cell)).collect();
        let cells = with_terrain.par_iter().filter_map(part).collect();
        let given = gifts.keys().copied().collect();
        let mut cover = Cover { cells, faces: Vec::new(), given };
        cover.faces = all.faces(&cover, &gifts);
        cover
    }

    /// The cells.
    pub fn cells(&self) -> &[CellInPart] {
        &self.cells
    }

    /// Those of a range of cells.
    pub fn cells_of(&self, cells: Range<usize>) -> &[CellInPart] {
        let place = |cell: usize| self.cells.partition_point(|part| part.cell < cell);
        &self.cells[place(cells.start)..place(cells.end)]
    }

    /// Their faces.
    pub fn faces(&self) -> &[FaceInPart] {
        &self.faces
    }

    /// What a cell stands for.
    pub fn cell(&self, cell: usize) -> CellInPart {
        let found = self.cells.binary_search_by_key(&cell, |part| part.cell);
        found.map_or(CellInPart { cell, area: 1.0, sides: [1.0; 4], middle: Vec2::ZERO }, |place| self.cells[place])
    }

    /// From the middle of a padded cell (row, column) to where the terrain ends beyond a side (spacings): φ/w − ½.
    pub(crate) fn reach(&self, (row, column): (usize, usize), way: usize, lattice: &Lattice) -> f64 {
        self.cell(lattice.index(column - 1, row - 1)).reach(way)
    }

    /// Whether a cell is not just itself, or gives itself to those beside it.
    pub fn holds(&self, cell: usize) -> bool {
        self.cells.binary_search_by_key(&cell, |part| part.cell).is_ok() || self.given.binary_search(&cell).is_ok()
    }
}

impl CellInPart {
    fn is_whole(&self) -> bool {
        self.sides.iter().chain([&self.area]).all(|share| (share - 1.0).abs() < ROUNDING)
    }
}

/// A cell beyond the edge of which a part is covered.
struct Gift {
    /// The covered area.
    area: f64,
    /// The cells that share it.
    takers: Vec<usize>,
}

/// A rectangle (map) in cells of a lattice, with edges that nearly lie on its lines or on the middles of its cells on them.
fn in_cells(extent: Rectangle, lattice: &Lattice) -> Rectangle {
    let snapped = |at: f64| {
        let near = 0.5 * (2.0 * at).round();
        if (at - near).abs() < ON_A_LINE { near } else { at }
    };
    let corner = |corner: Vec2| {
        let corner = lattice.to_local(corner) / lattice.spacing;
        Vec2::new(snapped(corner.x), snapped(corner.y))
    };
    Rectangle { low: corner(extent.low), high: corner(extent.high) }
}

/// The cells in which an edge of a rectangle lies, and those about them.
fn near_ends(ends: &[Rectangle], lattice: &Lattice) -> BTreeSet<usize> {
    let about = |low: f64, high: f64, count: usize| {
        // Casts of negative numbers give 0.
        ((low.floor() - 1.0).max(0.0) as usize)..((high.ceil() + 1.0).max(0.0) as usize).min(count)
    };
    let is_cut = |at: f64| at.fract().abs() > 0.0;
    let mut near = BTreeSet::new();
    for &Rectangle { low, high } in ends {
        let mut add = |x: (f64, f64), y: (f64, f64)| {
            for row in about(y.0, y.1, lattice.rows) {
                near.extend(about(x.0, x.1, lattice.columns).map(|column| lattice.index(column, row)));
            }
        };
        for x in [low.x, high.x].into_iter().filter(|&x| is_cut(x)) {
            add((x, x), (low.y, high.y));
        }
        for y in [low.y, high.y].into_iter().filter(|&y| is_cut(y)) {
            add((low.x, high.x), (y, y));
        }
    }
    near
}

/// What is covered; places and lengths in cells.
struct Extent<'a, S> {
    ends: Vec<Rectangle>,
    terrain: &'a Terrain,
    surface: &'a S,
    bed: &'a BedParticles,
}

impl<S: Surface> Extent<'_, S> {
    /// The same of the rectangles about a cell alone: mosaics have many.
    fn about(&self, cell: usize) -> Self {
        let (column, row) = self.place(cell);
        let is_near = |&&Rectangle { low, high }: &&Rectangle| {
            let meets = |low: f64, high: f64, at: f64| low <= at + ABOUT && high >= at + 1.0 - ABOUT;
            meets(low.x, high.x, column) && meets(low.y, high.y, row)
        };
        Extent { ends: self.ends.iter().filter(is_near).copied().collect(), ..*self }
    }

    /// Whether a place in a cell belongs to the terrain; beyond the last cell that has terrain by the data there, too.
    fn is_covered(&self, place: Vec2, cell: usize) -> bool {
        let lattice = &self.bed.lattice;
        let map = lattice.to_map(place * lattice.spacing);
        let in_raster = |place: Vec2| self.ends.iter().any(|&Rectangle { low, high }| is_within(place, low, high));
        // Ground that fills a hole has no rectangle.
        let has_terrain = self.bed.has_terrain(cell);
        let is_filled = || has_terrain && !in_raster(lattice.centre(cell) / lattice.spacing);
        (in_raster(place) || self.terrain.is_surveyed(map) || is_filled())
            && (has_terrain || self.surface.elevation(map).is_some())
    }

    /// The lines of the rectangles between two places along an axis, with those places.
    fn cuts(&self, from: f64, to: f64, along: impl Fn(Vec2) -> f64) -> Vec<f64> {
        let edges = self.ends.iter().flat_map(|&Rectangle { low, high }| [along(low), along(high)]);
        let mut cuts: Vec<f64> = edges.filter(|&edge| from < edge && edge < to).chain([from, to]).collect();
        cuts.sort_by(f64::total_cmp);
        cuts
    }

    /// The covered area of a cell, and the way from its middle to that of the area.
    fn covered(&self, cell: usize) -> (f64, Vec2) {
        let (column, row) = self.place(cell);
        let (x, y) = (self.cuts(column, column + 1.0, |p| p.x), self.cuts(row, row + 1.0, |p| p.y));
        let centre = Vec2::new(column + 0.5, row + 0.5);
        let (mut area, mut moment) = (0.0, Vec2::ZERO);
        for (x, y) in x.windows(2).flat_map(|x| y.windows(2).map(move |y| (x, y))) {
            let middle = Vec2::new(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
            if self.is_covered(middle, cell) {
                let piece = (x[1] - x[0]) * (y[1] - y[0]);
                area += piece;
                moment += (middle - centre) * piece;
            }
        }
        (area, if area > 0.0 { moment / area } else { Vec2::ZERO })
    }

    fn place(&self, cell: usize) -> (f64, f64) {
        let (column, row) = self.bed.lattice.column_row(cell);
        (column as f64, row as f64)
    }

    /// What the covered part of a cell spans across a way: where it ends inside the cell its wall stands there.
    fn spans(&self, cell: usize, way: usize) -> Vec<[f64; 2]> {
        let (column, row) = self.place(cell);
        let (x, y) = (self.cuts(column, column + 1.0, |p| p.x), self.cuts(row, row + 1.0, |p| p.y));
        let is_across = NEIGHBOURS[way].0 != 0;
        let (along, out) = if is_across { (y, x) } else { (x, y) };
        let covered = along.windows(2).filter(|piece| {
            out.windows(2).any(|other| {
                let (a, b) = (0.5 * (piece[0] + piece[1]), 0.5 * (other[0] + other[1]));
                self.is_covered(if is_across { Vec2::new(b, a) } else { Vec2::new(a, b) }, cell)
            })
        });
        covered.map(|piece| [piece[0], piece[1]]).collect()
    }

    /// The length of these.
    fn across(&self, cell: usize, way: usize) -> f64 {
        self.spans(cell, way).iter().map(|[from, to]| to - from).sum()
    }

    /// The length that two cells beside each other have in common: a hair of nothing between two rasters is no wall.
    fn common(&self, cells: (usize, usize), way: usize) -> f64 {
        let others = self.spans(cells.1, way);
        let overlap = |[from, to]: [f64; 2]| -> f64 {
            others.iter().map(|other| (to.min(other[1]) - from.max(other[0])).max(0.0)).sum()
        };
        self.spans(cells.0, way).into_iter().map(overlap).sum()
    }

    /// The length of a side of a cell, with those of the cells that are its own beside it.
    fn side(&self, cell: usize, way: usize, is_own: &impl Fn(usize) -> bool) -> f64 {
        let beside = ends_of(way).filter_map(|end| self.bed.lattice.neighbour(cell, end));
        let beside = beside.filter(|&other| is_own(other));
        self.across(cell, way) + beside.map(|other| self.across(other, way)).sum::<f64>()
    }

    /// The cells beyond the edge of which a part is covered, each with those to which it belongs: the cells beside it that have terrain
    /// or, where there are none, those at its corners.
    fn gifts(&self, near: &BTreeSet<usize>) -> BTreeMap<usize, Gift> {
        let lattice = &self.bed.lattice;
        let area_beyond = |cell: usize| {
            let extent = self.about(cell);
            let centre = lattice.centre(cell) / lattice.spacing;
            // A centre on the edge lies in the terrain or not, as the round-off of map coordinates has it.
            let inwards = Vec2::new(ON_A_LINE, ON_A_LINE);
            let is_hole =
                extent.ends.iter().any(|&Rectangle { low, high }| is_within(centre, low + inwards, high - inwards));
            Some(extent.covered(cell).0).filter(|&area| !is_hole && area > ROUNDING)
        };
        let takers = |cell: usize| {
            let with_terrain = |ways: &[(isize, isize)]| -> Vec<usize> {
                let others = ways.iter().filter_map(|&way| lattice.neighbour(cell, way));
                others.filter(|&other| self.bed.has_terrain(other)).collect()
            };
            let beside = with_terrain(&NEIGHBOURS);
            if beside.is_empty() { with_terrain(&[(1, 1), (-1, 1), (1, -1), (-1, -1)]) } else { beside }
        };
        let beyond = near.iter().copied().filter(|&cell| !self.bed.has_terrain(cell));
        let gifts = beyond.filter_map(|cell| Some((cell, Gift { area: area_beyond(cell)?, takers: takers(cell) })));
        gifts.filter(|(_, gift)| !gift.takers.is_empty()).collect()
    }

    /// The faces of the cells in part.
    fn faces(&self, cover: &Cover, gifts: &BTreeMap<usize, Gift>) -> Vec<FaceInPart> {
        let lattice = &self.bed.lattice;
        let is_of = |given: usize, taker: usize| gifts.get(&given).is_some_and(|gift| gift.takers[..] == [taker]);
        let mut faces = BTreeMap::new();
        for part in &cover.cells {
            let ((column, row), extent) = (lattice.column_row(part.cell), self.about(part.cell));
            for (way, own) in part.sides.into_iter().enumerate() {
                let other = lattice.neighbour(part.cell, NEIGHBOURS[way]).filter(|&other| self.bed.has_terrain(other));
                let open = other.map_or(own, |other| {
                    let beyond = ends_of(way).filter_map(|end| {
                        let pair = (lattice.neighbour(part.cell, end)?, lattice.neighbour(other, end)?);
                        let is_theirs = is_of(pair.0, part.cell) && is_of(pair.1, other);
                        is_theirs.then(|| extent.common(pair, way))
                    });
                    extent.common((part.cell, other), way) + beyond.sum::<f64>()
                });
                // The side across a face is the one after or before.
                let others = other.map_or(own, |other| cover.cell(other).sides[way ^ 1]);
                let (place, sides) = match way {
                    0 | 2 => ((row + 1, column + 1), [own, others]),
                    1 => ((row + 1, column), [others, own]),
                    _ => ((row, column + 1), [others, own]),
                };
                if [open, own, others].iter().any(|share| (share - 1.0).abs() > ROUNDING) {
                    let is_north = way > 1;
                    faces.entry((place, is_north)).or_insert(FaceInPart { place, is_north, open, sides });
                }
            }
        }
        faces.into_values().collect()
    }
}

/// The ways along a side to its two ends.
fn ends_of(way: usize) -> impl Iterator<Item = (isize, isize)> {
    let ends = if NEIGHBOURS[way].0 != 0 { [NEIGHBOURS[2], NEIGHBOURS[3]] } else { [NEIGHBOURS[0], NEIGHBOURS[1]] };
    ends.into_iter()
}

/// Whether a place lies in a rectangle or on its edge.
fn is_within(place: Vec2, low: Vec2, high: Vec2) -> bool {
    (low.x..=high.x).contains(&place.x) && (low.y..=high.y).contains(&place.y)
}

#[cfg(test)]
mod tests;
