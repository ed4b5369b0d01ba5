//! Where the cells of an earlier run lie on those of this one.
//!
//! Both consist of the same square parts: mostly a cell of the one is a part of the other, or the same. Cells of an earlier run on levels are
//! larger than those of its file where a coarser level stood.

use crate::bed::BedParticles;
use crate::boundary::Pieces;
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Share of a part by which places may differ that are meant to be the same.
pub const SAME_PLACE: f64 = 1e-6;
/// Parts along the smaller of the two cells at most.
const MOST_PARTS: usize = 8;

/// Where the cells of a file lie on the lattice: all over it, or on another rectangle where one of the runs has a part of the terrain.
#[derive(Clone, Copy, Debug)]
pub struct Laid {
    /// The edge (m) of its cells.
    pub cell: f64,
    columns: usize,
    rows: usize,
    /// Its south-western corner (local coordinates, m).
    corner: Vec2,
    /// The edge (m) of the parts.
    pub part: f64,
}

/// The cells of a file, those of the run, and what stands between them.
pub struct Between<'a> {
    pub laid: Laid,
    pub bed: &'a BedParticles,
    /// Walls of this run.
    pub walls: &'a Pieces,
    /// Whether this run raises or carves a cell, or a dam stands there.
    pub is_built: &'a dyn Fn(usize) -> bool,
    /// The edges (m) of the cells of an earlier run on levels, in the order of the file; not a number beside its terrain.
    pub edges: Option<Vec<f64>>,
}

impl Laid {
    /// Lays cells whose middles are given, in rows from the north, on the lattice; none where they do not fit.
    ///
    /// - `is_part`: whether the lattice is a part of the terrain, so that it need not reach as far as the file
    pub fn on(lattice: &Lattice, (x, y): (&[f64], &[f64]), is_part: bool) -> Option<Laid> {
        let s = lattice.spacing;
        let cell = spacing_of(x).or(spacing_of(y)).unwrap_or(s);
        let (&west, &south) = x.first().zip(y.last())?;
        let corner = lattice.to_local(Vec2::new(west - 0.5 * cell, south - 0.5 * cell));
        let smaller = s.min(cell);
        let is_same = |found: f64, expected: f64, of: f64| (found - expected).abs() <= SAME_PLACE * of;
        let is_even = x.iter().enumerate().all(|(i, &x)| is_same(x, west + i as f64 * cell, smaller))
            && y.iter().rev().enumerate().all(|(i, &y)| is_same(y, south + i as f64 * cell, smaller));
        let divides = |part: &f64| {
            [s, cell, corner.x, corner.y].iter().all(|length| is_same(*length, (length / part).round() * part, *part))
        };
        let part = (1..=MOST_PARTS).map(|parts| smaller / parts as f64).find(divides).filter(|_| is_even)?;
        // Cells may reach beyond the others at the ends of a row.
        let beyond = s.max(cell) - part + SAME_PLACE * part;
        let fits_along = |from: f64, cells: usize, own: f64| {
            let to = from + cells as f64 * cell;
            if is_part { from < own && to > 0.0 } else { from.abs() <= beyond && (own - to).abs() <= beyond }
        };
        let own = lattice.size();
        let fits = fits_along(corner.x, x.len(), own.x) && fits_along(corner.y, y.len(), own.y);
        fits.then_some(Laid { cell, columns: x.len(), rows: y.len(), corner, part })
    }

    /// How many values a variable of the file has.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether the cells of the file are those of the lattice.
    pub fn is_lattice(&self, lattice: &Lattice) -> bool {
        self.along(lattice) == 1 && (self.cell - lattice.spacing).abs() <= SAME_PLACE * lattice.spacing
    }

    /// The number among the values of the file of the cell about a place (local coordinates, m); rows count from the north.
    pub fn index_at(&self, place: Vec2) -> Option<usize> {
        let from = (place - self.corner) * (1.0 / self.cell);
        let is_in = from.x >= 0.0 && from.y >= 0.0 && from.x < self.columns as f64 && from.y < self.rows as f64;
        is_in.then(|| (self.rows - 1 - from.y as usize) * self.columns + from.x as usize)
    }

    /// The middle (local coordinates, m) of a cell of the file.
    pub fn centre(&self, index: usize) -> Vec2 {
        let (column, row) = (index % self.columns, self.rows - 1 - index / self.columns);
        self.corner + Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * self.cell
    }

    /// Parts along the edge of a cell of the lattice.
    pub fn along(&self, lattice: &Lattice) -> usize {
        (lattice.spacing / self.part).round() as usize
    }

    /// The numbers of the cells of the file about the parts of a cell of the lattice.
    pub fn of_cell<'a>(&'a self, lattice: &'a Lattice, cell: usize) -> impl Iterator<Item = usize> + Clone + 'a {
        self.parts_of_cell(lattice, cell).map(|(index, _)| index)
    }

    /// The same, each with the middle (local coordinates, m) of its part.
    pub fn parts_of_cell<'a>(
        &'a self,
        lattice: &'a Lattice,
        cell: usize,
    ) -> impl Iterator<Item = (usize, Vec2)> + Clone + 'a {
        let along = self.along(lattice);
        let middle = lattice.centre(cell);
        let at = move |k: usize| (k as f64 - 0.5 * (along as f64 - 1.0)) * self.part;
        let places = (0..along * along).map(move |k| middle + Vec2::new(at(k % along), at(k / along)));
        places.filter_map(|place| self.index_at(place).map(|index| (index, place)))
    }
}

/// The distance between values; none of fewer than two.
fn spacing_of(values: &[f64]) -> Option<f64> {
    let [first, .., last] = values else { return None };
    Some((last - first).abs() / (values.len() - 1) as f64)
}

impl Between<'_> {
    /// The edge (m) of the cell of the earlier run about one of the file.
    pub fn edge(&self, index: usize) -> f64 {
        let cells = self.edges.as_ref().map_or(1.0, |edges| (edges[index] / self.laid.cell).round());
        // The maps have it in single precision.
        if cells > 1.0 { cells * self.laid.cell } else { self.laid.cell }
    }

    /// Whether the cell of the earlier run about one of the file is larger than those of this run, or may be: beside the terrain it is not known.
    pub fn is_larger(&self, index: usize) -> bool {
        let is_unknown = self.edges.as_ref().is_some_and(|edges| edges[index].is_nan());
        is_unknown || self.edge(index) > (1.0 + SAME_PLACE) * self.bed.lattice.spacing
    }

    /// Whether a cell of this run holds all of the cell of the earlier run about one of the file.
    pub fn holds(&self, cell: usize, index: usize) -> bool {
        let lattice = &self.bed.lattice;
        let (off, room) = (self.middle(index) - lattice.centre(cell), 0.5 * (lattice.spacing - self.edge(index)));
        !self.is_larger(index) && off.x.abs().max(off.y.abs()) <= room + SAME_PLACE * self.laid.part
    }

    /// The middle of the cell of the earlier run about one of the file.
    pub fn middle(&self, index: usize) -> Vec2 {
        let (edge, corner) = (self.edge(index), self.laid.corner);
        let from = (self.laid.centre(index) - corner) * (1.0 / edge);
        corner + Vec2::new(from.x.floor() + 0.5, from.y.floor() + 0.5) * edge
    }

    /// What tells that cell from others: twice the row and column of its middle, counted in cells of the file.
    pub fn key(&self, index: usize) -> [usize; 2] {
        let middle = (self.middle(index) - self.laid.corner) * (2.0 / self.laid.cell);
        [middle.y.round() as usize, middle.x.round() as usize]
    }

    /// Whether no wall parts a place from the middle of the cell of the earlier run about one of the file.
    pub fn sees(&self, place: Vec2, index: usize) -> bool {
        self.walls.is_empty() || !self.walls.cross([place, self.middle(index)])
    }

    /// The cell of the file about a cell of the run, where a larger cell of the earlier run holds all of it.
    pub fn larger_about(&self, cell: usize) -> Option<usize> {
        let mut of_cell = self.laid.of_cell(&self.bed.lattice, cell);
        let first = of_cell.next().filter(|&first| self.is_larger(first))?;
        let is_same = |index: usize| (self.middle(index) - self.middle(first)).norm() <= SAME_PLACE * self.laid.part;
        of_cell.all(is_same).then_some(first)
    }
}
