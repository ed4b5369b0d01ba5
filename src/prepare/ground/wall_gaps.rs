//! Gaps between the ends of walls that the lattice makes wider or narrower than they are drawn, or shuts.
//!
//! Water passes from cell to cell where no wall crosses the line between their centres, and the ends of a wall belong to it: a gap
//! is a whole number of cells wide, and one whose ends lie on centres of cells is a cell narrower than drawn.

use std::collections::BTreeMap;

use crate::bed::BedParticles;
use crate::boundary::distance_to_segment;
use crate::error::input_warning;
use crate::math::{Vec2, readable, segments_cross};
use crate::prepare::findings::Findings;
use crate::scenario::Scenario;

/// Cells up to which the distance of two ends counts as a gap; a wider one is off by less than `DIFFERENCE`.
const WIDEST: f64 = 4.0;
/// Share of its width by which a gap may differ on the lattice without a word.
const DIFFERENCE: f64 = 0.25;
/// Share of the spacing within which walls touch.
const TOUCH: f64 = 1e-6;
/// Gaps that are listed with their place.
const LISTED: usize = 3;

/// Tells of gaps that are another width on the lattice.
pub fn check(scenario: &Scenario, walls: &[[Vec2; 2]], bed: &BedParticles, findings: &mut Findings) {
    let Some(source) = scenario.walls.first() else { return };
    let lattice = &bed.lattice;
    let ends = free_ends(walls, TOUCH * lattice.spacing);
    let pairs = ends.iter().enumerate().flat_map(|(i, &one)| ends[i + 1..].iter().map(move |&other| [one, other]));
    let differing: Vec<([Vec2; 2], f64, f64)> = pairs
        .filter_map(|gap| {
            let drawn = (gap[1] - gap[0]).norm();
            let is_gap = drawn <= WIDEST * lattice.spacing && gap.iter().all(|&end| has_terrain(end, bed));
            let open = is_gap.then(|| open_width(gap, walls, bed))?;
            ((open - drawn).abs() > DIFFERENCE * drawn).then_some((gap, drawn, open))
        })
        .collect();
    let Some((first, ..)) = differing.first() else { return };
    let middle = |gap: &[Vec2; 2]| lattice.to_map((gap[0] + gap[1]) * 0.5);
    let described = differing.iter().take(LISTED).map(|(gap, drawn, open)| {
        let (place, open) = (middle(gap), if *open > 0.0 { format!("{open:.1} m") } else { "shut".to_owned() });
        format!("{} m at {:.1}, {:.1}: {open}", readable(*drawn), place.x, place.y)
    });
    let described = described.collect::<Vec<_>>().join("; ");
    let more = differing.len().saturating_sub(LISTED);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    let message = format!("gaps between ends of walls have another width on the lattice: {described}{more}");
    let problem = input_warning("gap-on-lattice", message)
        .with_cause("water passes between cells whose centres no wall parts, and the ends of a wall belong to it")
        .with_remedy(
            "take a finer `resolution`, move the ends onto edges of cells, or join the walls where no gap is meant",
        )
        .with_at(middle(first));
    findings.add(source, problem);
}

/// The ends of walls that no other piece touches.
fn free_ends(walls: &[[Vec2; 2]], touch: f64) -> Vec<Vec2> {
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

fn has_terrain(place: Vec2, bed: &BedParticles) -> bool {
    bed.lattice.cell_at(place).is_some_and(|cell| bed.has_terrain(cell))
}

/// Width (m) in which water passes through the straight line between two ends.
fn open_width(gap: [Vec2; 2], walls: &[[Vec2; 2]], bed: &BedParticles) -> f64 {
    let lattice = &bed.lattice;
    let spacing = lattice.spacing;
    let beside = |a: f64, b: f64, count: usize| {
        let index = |value: f64| (value / spacing).max(0.0) as usize;
        index(a.min(b) - spacing)..(index(a.max(b)) + 2).min(count)
    };
    let mut faces = [0.0, 0.0];
    for row in beside(gap[0].y, gap[1].y, lattice.rows) {
        for column in beside(gap[0].x, gap[1].x, lattice.columns) {
            let cell = lattice.index(column, row);
            for (faces, (c, r)) in faces.iter_mut().zip([(column + 1, row), (column, row + 1)]) {
                if c >= lattice.columns || r >= lattice.rows {
                    continue;
                }
                let other = lattice.index(c, r);
                let way = [lattice.centre(cell), lattice.centre(other)];
                let is_open = bed.has_terrain(cell)
                    && bed.has_terrain(other)
                    && segments_cross(way, gap)
                    && !walls.iter().any(|&wall| segments_cross(way, wall));
                *faces += f64::from(u8::from(is_open));
            }
        }
    }
    spacing * f64::hypot(faces[0], faces[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;

    #[test]
    fn gaps_are_as_wide_as_the_ways_through_them() {
        // Cells of 10 m with centres at 5 m, 15 m, ...; a wall from the south to the north with a gap.
        let lattice = Lattice::new(Vec2::ZERO, 20, 20, 10.0);
        let bed = BedParticles::from_elevation(lattice, vec![0.0; 400], 0.0);
        for (from, to, open) in
            [(95.0, 105.0, 0.0), (96.0, 104.0, 0.0), (94.0, 104.0, 10.0), (90.0, 110.0, 20.0), (95.0, 115.0, 10.0)]
        {
            let place = |y: f64| Vec2::new(100.0, y);
            let walls = [[place(0.0), place(50.0)], [place(from), place(50.0)], [place(to), place(200.0)]];
            let ends = free_ends(&walls, 1e-5);
            assert_eq!(ends, [place(0.0), place(from), place(to), place(200.0)]);
            assert!((open_width([ends[1], ends[2]], &walls, &bed) - open).abs() < 1e-12, "{from} to {to}");
        }
    }
}
