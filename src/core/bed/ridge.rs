//! Ridges of one cell: a dam across which particles on both sides could see each other, because their kernels are wider than it.
//!
//! The crest of a ridge runs from the centre of each of its cells to those of its neighbours in the same row and column, linear
//! between their elevations; beside the end of a ridge it goes on to ground that is higher, or to the rim of the terrain. The sill of
//! a way is the highest crest that it crosses. Ridges that lie no higher than the ground are none.

use super::BedParticles;
use crate::math::Vec2;

/// Ways that pass a centre by less than this share of the spacing go through it.
const ROUND_OFF: f64 = 1e-9;

/// The cells of the ridges of a lattice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ridges {
    /// Whether each cell of the lattice is one of a ridge; empty where there is no ridge.
    is_ridge: Vec<bool>,
    /// For each cell, how many cells away (in the greater of both directions) the nearest one of a ridge was at the start.
    clearance: Vec<u32>,
    count: usize,
}

impl Ridges {
    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether a cell is one of a ridge.
    #[inline]
    pub fn contains(&self, cell: usize) -> bool {
        self.is_ridge.get(cell).copied().unwrap_or(false)
    }
}

impl BedParticles {
    /// Makes ridges of some cells, and of those alone.
    pub fn set_ridges(&mut self, cells: impl Iterator<Item = usize>) {
        let len = self.lattice.len();
        let mut ridges = Ridges { is_ridge: vec![false; len], clearance: vec![u32::MAX / 2; len], count: 0 };
        for cell in cells.filter(|&cell| self.has_terrain(cell)) {
            ridges.count += usize::from(!ridges.is_ridge[cell]);
            (ridges.is_ridge[cell], ridges.clearance[cell]) = (true, 0);
        }
        let (columns, rows) = (self.lattice.columns, self.lattice.rows);
        // Two sweeps of the chessboard distance.
        for backwards in [false, true] {
            for k in 0..len {
                let cell = if backwards { len - 1 - k } else { k };
                let (column, row) = self.lattice.column_row(cell);
                let mut least = ridges.clearance[cell];
                for other_row in row.saturating_sub(1)..(row + 2).min(rows) {
                    for other_column in column.saturating_sub(1)..(column + 2).min(columns) {
                        least = least.min(ridges.clearance[other_row * columns + other_column].saturating_add(1));
                    }
                }
                ridges.clearance[cell] = least.min(ridges.clearance[cell]);
            }
        }
        self.ridges = if ridges.count > 0 { ridges } else { Ridges::default() };
    }

    /// Takes a cell out of the ridges, or back in.
    pub fn mark_ridge(&mut self, cell: usize, is_ridge: bool) {
        let ridges = &mut self.ridges;
        if let Some(mark) = ridges.is_ridge.get_mut(cell)
            && *mark != is_ridge
        {
            *mark = is_ridge;
            ridges.count = if is_ridge { ridges.count + 1 } else { ridges.count - 1 };
        }
    }

    /// Whether a ridge may lie within a distance (m) of a place.
    #[inline]
    pub fn has_ridge_within(&self, place: Vec2, distance: f64) -> bool {
        let ridges = &self.ridges;
        let near = |cell: usize| f64::from(ridges.clearance[cell].saturating_sub(1)) * self.lattice.spacing <= distance;
        !ridges.is_empty() && self.lattice.cell_at(place).is_none_or(near)
    }

    /// The highest crest (m) of a ridge on the straight way between two places; minus infinity where there is none on it.
    pub fn sill(&self, a: Vec2, b: Vec2) -> f64 {
        let way = b - a;
        if !self.has_ridge_within(a, way.norm()) {
            return f64::NEG_INFINITY;
        }
        let spacing = self.lattice.spacing;
        // In spacings from the centre of the first cell.
        let [a, b] = [a, b].map(|p| Vec2::new(p.x / spacing - 0.5, p.y / spacing - 0.5));
        let mut sill = f64::NEG_INFINITY;
        for (from, to, other_from, other_to, is_column) in [(a.x, b.x, a.y, b.y, true), (a.y, b.y, a.x, b.x, false)] {
            let (low, high) = (from.min(to).ceil() as i64, from.max(to).floor() as i64);
            for line in low..=high {
                let share = (line as f64 - from) / (to - from);
                // A way along the line of the crest, or one that ends on it, does not cross it.
                if share > 0.0 && share < 1.0 {
                    let across = other_from + (other_to - other_from) * share;
                    sill = sill.max(self.crest(line, across, is_column));
                }
            }
        }
        sill
    }

    /// The crest (m) on a line of centres, that of a column or of a row, at a place along it in spacings.
    fn crest(&self, line: i64, along: f64, is_column: bool) -> f64 {
        let near = along.round();
        let cell = |along: i64| {
            let (column, row) = if is_column { (line, along) } else { (along, line) };
            let (column, row) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
            let is_on = column < self.lattice.columns && row < self.lattice.rows;
            is_on.then(|| self.lattice.index(column, row)).filter(|&cell| self.has_terrain(cell))
        };
        let is_ridge = |cell: Option<usize>| cell.is_some_and(|cell| self.ridges.is_ridge[cell]);
        let elevation = |cell: Option<usize>| cell.map(|cell| self.elevation[cell]);
        if (along - near).abs() < ROUND_OFF {
            let at = cell(near as i64);
            return if is_ridge(at) { elevation(at).unwrap_or(f64::NEG_INFINITY) } else { f64::NEG_INFINITY };
        }
        let first = along.floor();
        let pair = [cell(first as i64), cell(first as i64 + 1)];
        match (pair.map(is_ridge), pair.map(elevation)) {
            ([true, _], [Some(z), None]) | ([_, true], [None, Some(z)]) => z,
            ([true, true], [Some(z_0), Some(z_1)]) => z_0 + (z_1 - z_0) * (along - first),
            ([true, false], [Some(z_0), Some(z_1)]) if z_1 >= z_0 => z_0 + (z_1 - z_0) * (along - first),
            ([false, true], [Some(z_0), Some(z_1)]) if z_0 >= z_1 => z_0 + (z_1 - z_0) * (along - first),
            _ => f64::NEG_INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;

    /// A level valley of 8 by 6 cells of 2 m, with higher ground in the northernmost row and a ridge in column 3 up to it.
    fn bed() -> BedParticles {
        let lattice = Lattice::new(Vec2::ZERO, 8, 6, 2.0);
        let elevation = (0..48).map(|cell| if cell >= 40 { 9.0 } else { 0.0 }).collect();
        let mut bed = BedParticles::from_elevation(lattice, elevation, 0.0);
        for row in 0..5 {
            bed.elevation[row * 8 + 3] = 5.0 + row as f64;
        }
        bed.set_ridges((0..5).map(|row| row * 8 + 3));
        bed
    }

    #[test]
    fn the_sill_is_the_crest_where_the_way_crosses_it() {
        let bed = bed();
        let sill = |x0: f64, y0: f64, x1: f64, y1: f64| bed.sill(Vec2::new(x0, y0), Vec2::new(x1, y1));
        // Centres of the ridge are at x = 7 m, and at y = 1, 3, 5, 7 and 9 m.
        for (x0, y0, x1, y1, crest) in [
            (5.0, 3.0, 9.0, 3.0, 6.0),
            (9.0, 4.0, 5.0, 4.0, 6.5),
            (5.0, 2.0, 9.0, 4.0, 6.0),
            // Beyond its end in the south to the rim of the terrain, in the north up to higher ground.
            (6.0, 0.2, 8.0, 0.2, 5.0),
            (5.0, 10.0, 9.0, 10.0, 9.0),
        ] {
            assert!((sill(x0, y0, x1, y1) - crest).abs() < 1e-12, "{x0} {y0} {x1} {y1}: {}", sill(x0, y0, x1, y1));
        }
        for (x0, y0, x1, y1) in
            [(1.0, 1.0, 6.9, 5.0), (7.0, 3.0, 9.0, 3.0), (7.1, 0.5, 7.1, 6.0), (5.0, 11.5, 9.0, 11.5)]
        {
            assert!(sill(x0, y0, x1, y1) == f64::NEG_INFINITY, "{x0} {y0} {x1} {y1}: {}", sill(x0, y0, x1, y1));
        }
        assert!(bed.has_ridge_within(Vec2::new(4.9, 3.0), 0.1) && !bed.has_ridge_within(Vec2::new(13.0, 3.0), 1.0));
    }

    #[test]
    fn a_ridge_that_is_gone_hides_nothing() {
        let mut bed = bed();
        let way = |bed: &BedParticles, y: f64| bed.sill(Vec2::new(5.0, y), Vec2::new(9.0, y));
        bed.mark_ridge(2 * 8 + 3, false);
        assert!(way(&bed, 5.0) == f64::NEG_INFINITY && way(&bed, 3.0) > 5.9);
        (0..5).for_each(|row| bed.mark_ridge(row * 8 + 3, false));
        assert!(bed.ridges.is_empty() && way(&bed, 3.0) == f64::NEG_INFINITY);
        bed.mark_ridge(3, true);
        assert!((way(&bed, 1.0) - 5.0).abs() < 1e-12);
    }
}
