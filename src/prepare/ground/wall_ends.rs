//! Ends of walls, and what closes them to the edge of the terrain.
//!
//! The edge of a raster is known to half of a pixel, and that of the cells to half of a cell. A wall that ends so near to it is meant to reach it:
//! no water passes between its end and where nothing is known.

use std::collections::BTreeMap;

use crate::bed::BedParticles;
use crate::boundary::{distance_to_segment, nearest_on_segment};
use crate::lattice::NEIGHBOURS;
use crate::math::Vec2;

/// Share of the spacing within which walls touch.
const TOUCH: f64 = 1e-6;

/// How far beyond the edge a wall is drawn (spacings).
const BEYOND: f64 = 0.1;

/// The ends of walls that no other piece touches, by the spacing (m) of the lattice.
pub fn free_ends(walls: &[[Vec2; 2]], spacing: f64) -> Vec<Vec2> {
    let touch = TOUCH * spacing;
    let is_free = |piece: usize, end: Vec2| {
        let mut others = walls.iter().enumerate().filter(|(other, _)| *other != piece);
        !others.any(|(_, other)| distance_to_segment(end, other[0], other[1]) <= touch)
    };
    let key = |end: Vec2| (end.x.to_bits(), end.y.to_bits());
    // Pieces of one line share their ends to the last bit: few are left to be held against all pieces.
    let mut pieces_at: BTreeMap<(u64, u64), usize> = BTreeMap::new();
    walls.iter().flatten().for_each(|&end| *pieces_at.entry(key(end)).or_default() += 1);
    let ends = walls.iter().enumerate().flat_map(|(piece, wall)| wall.iter().map(move |&end| (piece, end)));
    let single = ends.filter(|&(_, end)| pieces_at[&key(end)] == 1);
    single.filter(|&(piece, end)| is_free(piece, end)).map(|(_, end)| end).collect()
}

/// Pieces that lead ends of walls to where the terrain ends, no farther than half a cell or half of the `pixel` (m) that the terrain has at a place.
pub fn to_edge(walls: &[[Vec2; 2]], bed: &BedParticles, pixel: impl Fn(Vec2) -> f64) -> Vec<[Vec2; 2]> {
    let spacing = bed.lattice.spacing;
    let closing = |end: Vec2| {
        let reach = 0.5 * spacing.max(pixel(end));
        let edge = nearest_edge(end, reach, bed)?;
        let way = edge - end;
        Some([end, edge + way * (BEYOND * spacing / way.norm())])
    };
    free_ends(walls, spacing).into_iter().filter_map(closing).collect()
}

/// The nearest place, within a reach (m) of a place on terrain, where cells without terrain begin, or the lattice ends; buildings are none.
fn nearest_edge(place: Vec2, reach: f64, bed: &BedParticles) -> Option<Vec2> {
    let lattice = &bed.lattice;
    let spacing = lattice.spacing;
    let own = lattice.cell_at(place).filter(|&cell| bed.has_terrain(cell))?;
    let (across, up) = lattice.column_row(own);
    let cells = (reach / spacing).ceil() as usize;
    let mut nearest: Option<Vec2> = None;
    for row in up.saturating_sub(cells)..(up + cells + 1).min(lattice.rows) {
        for column in across.saturating_sub(cells)..(across + cells + 1).min(lattice.columns) {
            let cell = lattice.index(column, row);
            for offset in NEIGHBOURS.into_iter().filter(|_| bed.has_terrain(cell)) {
                let is_ground = |other: usize| bed.has_terrain(other) || bed.sealed.binary_search(&other).is_ok();
                if lattice.neighbour(cell, offset).is_some_and(is_ground) {
                    continue;
                }
                let out = Vec2::new(offset.0 as f64, offset.1 as f64) * (0.5 * spacing);
                let (middle, along) = (lattice.centre(cell) + out, Vec2::new(-out.y, out.x));
                let at = nearest_on_segment(place, middle - along, middle + along);
                let is_nearer = |before: Vec2| (at - place).norm() < (before - place).norm();
                if (at - place).norm() <= reach && nearest.is_none_or(is_nearer) {
                    nearest = Some(at);
                }
            }
        }
    }
    nearest.filter(|&at| (at - place).norm() > TOUCH * spacing)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;

    #[test]
    fn ends_near_the_edge_of_the_terrain_reach_it_and_others_stay() {
        // 20 by 20 cells of 10 m; no terrain in the east beyond 170 m, a blocked building in a corner.
        let lattice = Lattice::new(Vec2::ZERO, 20, 20, 10.0);
        let elevation = (0..400).map(|cell| if cell % 20 >= 17 || cell < 3 { f64::NAN } else { 0.0 }).collect();
        let mut bed = BedParticles::from_elevation(lattice, elevation, 0.0);
        bed.sealed = vec![0, 1, 2];
        let ends = |from: Vec2, to: Vec2, pixel: f64| to_edge(&[[from, to]], &bed, |_| pixel);
        let inside = Vec2::new(100.0, 104.0);
        for (end, pixel, edge) in [
            (Vec2::new(100.0, 196.0), 1.0, Some(Vec2::new(100.0, 200.0))),
            (Vec2::new(100.0, 194.0), 1.0, None),
            (Vec2::new(100.0, 188.0), 30.0, Some(Vec2::new(100.0, 200.0))),
            (Vec2::new(167.0, 83.0), 1.0, Some(Vec2::new(170.0, 83.0))),
            (Vec2::new(184.0, 83.0), 1.0, None),
            (Vec2::new(15.0, 12.0), 1.0, None),
        ] {
            let found = ends(inside, end, pixel);
            let beyond = edge.map(|edge| vec![[end, edge + (edge - end) * (1.0 / (edge - end).norm())]]);
            assert_eq!(found, beyond.unwrap_or_default(), "{end:?}");
        }
        // Ends that touch are none.
        let near = Vec2::new(100.0, 196.0);
        assert!(to_edge(&[[inside, near], [near, inside]], &bed, |_| 1.0).is_empty());
    }
}
