//! Where still water would run out of its polygon: pockets that it fills and stays in, and gaps through which it leaves.
//!
//! Water passes from a cell to any of its eight neighbours whose bed lies below the level, unless a wall lies between the
//! two centres. Moving particles reach all eight; resting ones fewer, and what is at rest for eight is at rest for them.

use crate::bed::BedParticles;
use crate::math::Vec2;

/// A gap in the rim of a body of still water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leak {
    /// Its lowest place, in map coordinates (m).
    pub position: Vec2,
    /// Bed elevation there (m).
    pub bed_elevation: f64,
    /// How far the level stands above it (m).
    pub depth: f64,
    /// Number of cells outside the body that the water reaches first; times the spacing about the width of the gap.
    pub cells: usize,
}

/// The cells of the lattice while bodies of still water are filled.
pub(super) struct Filling<'a> {
    pub bed: &'a BedParticles,
    walls: &'a [[Vec2; 2]],
    /// The body that fills a cell.
    pub body: Vec<Option<u32>>,
    /// Number of the search that saw a cell last.
    seen: Vec<u32>,
    searches: u32,
}

impl<'a> Filling<'a> {
    pub fn new(bed: &'a BedParticles, walls: &'a [[Vec2; 2]]) -> Self {
        let cells = bed.lattice.len();
        Filling { bed, walls, body: vec![None; cells], seen: vec![0; cells], searches: 0 }
    }

    /// Whether there is terrain at a cell, and the level stands above it.
    pub fn is_below(&self, cell: usize, level: f64) -> bool {
        // False for not-a-number.
        self.bed.elevation[cell] < level
    }

    /// The neighbours to which water of a cell can pass, as far as walls go.
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        let lattice = &self.bed.lattice;
        let (column, row) = lattice.column_row(cell);
        let columns = column.saturating_sub(1)..(column + 2).min(lattice.columns);
        let rows = row.saturating_sub(1)..(row + 2).min(lattice.rows);
        rows.flat_map(move |row| columns.clone().map(move |column| lattice.index(column, row))).filter(move |&other| {
            let path = [lattice.centre(cell), lattice.centre(other)];
            other != cell && !self.walls.iter().any(|wall| is_crossing(path, *wall))
        })
    }

    /// The neighbours into which a filled cell would run out.
    pub fn gaps(&self, cell: usize, level: f64) -> impl Iterator<Item = usize> + '_ {
        self.neighbours(cell).filter(move |&other| self.body[other].is_none() && self.is_below(other, level))
    }

    /// Fills, for a body with the given filled cells, the pockets that its water reaches and does not leave again. Returns
    /// their cells.
    ///
    /// They are what a rim drawn with other points than those of the lattice leaves out: cells beside the body, and beyond
    /// those no more than `largest_volume` (m³) for all pockets together.
    pub fn fill_pockets(&mut self, number: u32, level: f64, cells: &[usize], largest_volume: f64) -> Vec<usize> {
        let first_search = self.searches + 1;
        let mut left = largest_volume;
        let mut filled = Vec::new();
        for &cell in cells {
            let gaps: Vec<usize> = self.gaps(cell, level).collect();
            for start in gaps {
                if self.body[start].is_some() || self.seen[start] >= first_search {
                    continue;
                }
                if let Some((pocket, volume)) = self.pocket((number, start), level, first_search, left) {
                    left -= volume;
                    pocket.iter().for_each(|&cell| self.body[cell] = Some(number));
                    filled.extend(pocket);
                }
            }
        }
        filled
    }

    /// The cells that water of a body entering at `start` fills at its level, and the volume (m³) of those that are not
    /// beside the body; `None` when that is more than `largest_volume`, or the water joins a place for which a search since
    /// `first_search` has found so.
    fn pocket(
        &mut self,
        (number, start): (u32, usize),
        level: f64,
        first_search: u32,
        largest_volume: f64,
    ) -> Option<(Vec<usize>, f64)> {
        self.searches += 1;
        self.seen[start] = self.searches;
        let mut pocket = vec![start];
        let (mut next, mut volume) = (0, 0.0);
        while let Some(&cell) = pocket.get(next) {
            next += 1;
            if !self.neighbours(cell).any(|other| self.body[other] == Some(number)) {
                volume += (level - self.bed.elevation[cell]) * self.bed.lattice.cell_area();
            }
            if volume > largest_volume {
                return None;
            }
            let around: Vec<usize> = self.gaps(cell, level).collect();
            for other in around {
                if self.seen[other] < first_search {
                    self.seen[other] = self.searches;
                    pocket.push(other);
                } else if self.seen[other] != self.searches {
                    return None;
                }
            }
        }
        Some((pocket, volume))
    }

    /// The gaps of a body with the given filled cells, deepest first.
    pub fn leaks(&self, level: f64, cells: &[usize]) -> Vec<Leak> {
        let mut outside: Vec<usize> = cells.iter().flat_map(|&cell| self.gaps(cell, level)).collect();
        outside.sort_unstable();
        outside.dedup();
        let mut is_taken = vec![false; outside.len()];
        let mut leaks = Vec::new();
        for start in 0..outside.len() {
            if std::mem::replace(&mut is_taken[start], true) {
                continue;
            }
            let mut gap = vec![outside[start]];
            let mut next = 0;
            while let Some(&cell) = gap.get(next) {
                next += 1;
                for other in self.neighbours(cell) {
                    if let Ok(place) = outside.binary_search(&other)
                        && !std::mem::replace(&mut is_taken[place], true)
                    {
                        gap.push(other);
                    }
                }
            }
            let z_b = &self.bed.elevation;
            let lowest = gap.iter().copied().fold(gap[0], |a, b| if z_b[b] < z_b[a] { b } else { a });
            leaks.push(Leak {
                position: self.bed.lattice.to_map(self.bed.lattice.centre(lowest)),
                bed_elevation: z_b[lowest],
                depth: level - z_b[lowest],
                cells: gap.len(),
            });
        }
        leaks.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        leaks
    }
}

/// Whether two straight pieces have a point in common.
fn is_crossing([a, b]: [Vec2; 2], [c, d]: [Vec2; 2]) -> bool {
    let are_apart = |p: f64, q: f64, r: f64, s: f64| p.max(q) < r.min(s) || r.max(s) < p.min(q);
    if are_apart(a.x, b.x, c.x, d.x) || are_apart(a.y, b.y, c.y, d.y) {
        return false;
    }
    let side = |from: Vec2, to: Vec2, point: Vec2| (to - from).cross(point - from);
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossing_includes_touching_and_excludes_the_rest() {
        let path = [Vec2::new(0.0, 0.0), Vec2::new(2.0, 0.0)];
        let wall = |x1, y1, x2, y2| [Vec2::new(x1, y1), Vec2::new(x2, y2)];
        assert!(is_crossing(path, wall(1.0, -1.0, 1.0, 1.0)));
        assert!(is_crossing(path, wall(1.0, 0.0, 1.0, 1.0)));
        assert!(is_crossing(path, wall(1.0, 0.0, 5.0, 0.0)));
        assert!(!is_crossing(path, wall(3.0, 0.0, 5.0, 0.0)));
        assert!(!is_crossing(path, wall(1.0, 0.1, 1.0, 1.0)));
        assert!(!is_crossing(path, wall(3.0, -1.0, 3.0, 1.0)));
        assert!(!is_crossing(path, wall(1.9, 1.0, 4.0, -1.0)));
    }
}
