//! Gaps between the ends of walls that squares make wider or narrower than they are drawn, or shut.
//!
//! Water passes from square to square where no wall crosses the line between their centres, and the ends of a wall belong to it: a gap
//! is a whole number of cells wide, and one whose ends lie on centres of cells is a cell narrower than drawn. Among cells that follow walls it is
//! as wide as drawn.

use super::wall_ends::free_ends;
use crate::bed::BedParticles;
use crate::boundary::nearest_on_segment;
use crate::error::input_warning;
use crate::math::{Vec2, readable, segments_cross};
use crate::prepare::findings::Findings;
use crate::scenario::Scenario;

/// Cells up to which the distance of two ends counts as a gap; a wider one is off by less than `DIFFERENCE`.
const WIDEST: f64 = 4.0;
/// Share of its width by which a gap may differ on the lattice without a word.
const DIFFERENCE: f64 = 0.25;
/// Gaps that are listed with their place.
const LISTED: usize = 3;
/// Cells below which a gap beside the end of a wall may be a slip of the pen.
const NARROW: f64 = 0.5;
/// How much of a wall from its end on is no other line, in widths of such a gap.
const OWN: f64 = 2.0;
/// Share of such a gap below which lines touch.
const TOUCH: f64 = 1e-5;

/// Warns of gaps that are another width on the lattice, where `is_square` has it that a square of the lattice stays one.
pub fn check(
    scenario: &Scenario,
    walls: &[[Vec2; 2]],
    (bed, is_square): (&BedParticles, impl Fn(usize) -> bool),
    findings: &mut Findings,
) {
    let Some(source) = scenario.walls.first() else { return };
    let lattice = &bed.lattice;
    let mut ends = free_ends(walls, lattice.spacing);
    ends.retain(|&end| lattice.cell_at(end).is_some_and(|cell| bed.has_terrain(cell) && is_square(cell)));
    let pairs = ends.iter().enumerate().flat_map(|(i, &one)| ends[i + 1..].iter().map(move |&other| [one, other]));
    let differing: Vec<([Vec2; 2], f64, f64)> = pairs
        .filter_map(|gap| {
            let drawn = (gap[1] - gap[0]).norm();
            let open = (drawn <= WIDEST * lattice.spacing).then(|| open_width(gap, walls, bed))?;
            ((open - drawn).abs() > DIFFERENCE * drawn).then_some((gap, drawn, open))
        })
        .collect();
    let Some((first, ..)) = differing.first() else { return };
    let middle = |gap: &[Vec2; 2]| lattice.to_map((gap[0] + gap[1]) * 0.5);
    let listed = listed(differing.iter().map(|(gap, drawn, open)| {
        let (place, open) = (middle(gap), if *open > 0.0 { format!("{open:.1} m") } else { "shut".to_owned() });
        format!("{} m at {:.1}, {:.1}: {open}", readable(*drawn), place.x, place.y)
    }));
    let message = format!("gaps between ends of walls have another width on the lattice: {listed}");
    let problem = input_warning("gap-on-lattice", message)
        .with_cause("water passes between squares whose centres no wall parts, and the ends of a wall belong to it")
        .with_remedy(
            "take a finer `resolution`, move the ends onto edges of cells, or join the walls where no gap is meant",
        )
        .with_at(middle(first));
    findings.add(source, problem);
}

/// Warns of narrow gaps between the end of a wall and another wall or a building (`outlines`), where cells follow them: water passes as drawn.
pub fn check_narrow(
    scenario: &Scenario,
    (walls, outlines): (&[[Vec2; 2]], impl Iterator<Item = [Vec2; 2]>),
    (bed, kept): (&BedParticles, &[bool]),
    findings: &mut Findings,
) {
    let Some(source) = scenario.walls.first() else { return };
    let lattice = &bed.lattice;
    let outlines: Vec<[Vec2; 2]> = outlines.collect();
    let mut gaps: Vec<[Vec2; 2]> = Vec::new();
    for end in free_ends(walls, lattice.spacing) {
        let is_followed = lattice.cell_at(end).is_some_and(|cell| bed.has_terrain(cell) && !kept[cell]);
        let nearest = || gap_beside(end, (walls, &outlines), NARROW * lattice.spacing);
        let Some(other) = is_followed.then(nearest).flatten() else { continue };
        // Two ends have one gap.
        if !gaps.contains(&[other, end]) {
            gaps.push([end, other]);
        }
    }
    let Some(first) = gaps.first() else { return };
    let middle = |gap: &[Vec2; 2]| lattice.to_map((gap[0] + gap[1]) * 0.5);
    let listed = listed(gaps.iter().map(|gap| {
        let place = middle(gap);
        format!("{} m at {:.1}, {:.1}", readable((gap[1] - gap[0]).norm()), place.x, place.y)
    }));
    let message = format!("water passes gaps of less than half a cell beside ends of walls: {listed}");
    let problem = input_warning("narrow-gap", message)
        .with_cause("lines that nearly meet are not joined")
        .with_remedy("expected at openings; elsewhere, let the lines meet, in QGIS by snapping")
        .with_at(middle(first));
    findings.add(source, problem);
}

/// The first few of some descriptions, and how many there are besides.
fn listed(all: impl ExactSizeIterator<Item = String>) -> String {
    let more = all.len().saturating_sub(LISTED);
    let first = all.take(LISTED).collect::<Vec<_>>().join("; ");
    if more > 0 { format!("{first}; and {more} more") } else { first }
}

/// The place nearest to the end of a wall, within a reach (m), on outlines and on other walls, or on its own line farther on.
///
/// None where the wall touches or crosses one of them so near to its end.
fn gap_beside(end: Vec2, (walls, outlines): (&[[Vec2; 2]], &[[Vec2; 2]]), reach: f64) -> Option<Vec2> {
    let own = tail(end, walls, OWN * reach);
    let is_own = |number: usize| own.iter().any(|(own, _)| *own == number);
    let others = || {
        let walls = walls.iter().enumerate().filter(|(number, _)| !is_own(*number)).map(|(_, piece)| piece);
        walls.chain(outlines)
    };
    let is_near = |[from, _]: &[Vec2; 2]| (*from - end).norm() < reach;
    let mut near = own.iter().map(|(_, piece)| *piece).filter(is_near);
    // The line farther on begins where its own part ends.
    let goes_on = |piece: &[Vec2; 2]| own.iter().any(|(_, own)| piece.contains(&own[1]));
    if near.any(|own| others().filter(|piece| !goes_on(piece)).any(|&piece| segments_cross(own, piece))) {
        return None;
    }
    let places = others().filter(|piece| !goes_on(piece)).map(|piece| nearest_on_segment(end, piece[0], piece[1]));
    let nearest = places.min_by(|a, b| (*a - end).norm().total_cmp(&(*b - end).norm()))?;
    let width = (nearest - end).norm();
    (width > TOUCH * reach && width < reach).then_some(nearest)
}

/// The pieces of a line from its end on, as far as a length (m), with their numbers, each from the side of the end.
fn tail(end: Vec2, walls: &[[Vec2; 2]], length: f64) -> Vec<(usize, [Vec2; 2])> {
    let mut tail: Vec<(usize, [Vec2; 2])> = Vec::new();
    let (mut at, mut left) = (end, length);
    while left > 0.0 {
        let next = walls
            .iter()
            .enumerate()
            .find(|(number, piece)| piece.contains(&at) && !tail.iter().any(|(known, _)| known == number));
        let Some((number, piece)) = next else { break };
        let on = if piece[0] == at { piece[1] } else { piece[0] };
        left -= (on - at).norm();
        tail.push((number, [at, on]));
        at = on;
    }
    tail
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
            let ends = free_ends(&walls, 10.0);
            assert_eq!(ends, [place(0.0), place(from), place(to), place(200.0)]);
            assert!((open_width([ends[1], ends[2]], &walls, &bed) - open).abs() < 1e-12, "{from} to {to}");
        }
    }

    #[test]
    fn narrow_gaps_are_between_an_end_and_what_the_wall_does_not_cross() {
        let place = |x: f64, y: f64| Vec2::new(x, y);
        // Two pieces of one wall that end at (0, 0).
        let own = [[place(-20.0, 5.0), place(-10.0, 0.0)], [place(-10.0, 0.0), place(0.0, 0.0)]];
        let upright = |x: f64| [place(x, -50.0), place(x, 50.0)];
        for (other, gap) in [
            (upright(2.0), Some(place(2.0, 0.0))),
            (upright(6.0), None),
            (upright(0.0), None),
            (upright(-1.0), None),
            ([place(0.0, 3.0), place(9.0, 3.0)], Some(place(0.0, 3.0))),
        ] {
            let walls: Vec<[Vec2; 2]> = own.into_iter().chain([other]).collect();
            assert_eq!(gap_beside(place(0.0, 0.0), (&walls, &[]), 5.0), gap, "{other:?}");
            assert_eq!(gap_beside(place(0.0, 0.0), (&own, &[other]), 5.0), gap, "{other:?}");
        }
        // A line with points nearer than a gap is no gap of its own; a ring that does not close has one.
        let arc = |points: usize| {
            let angle = |k: usize| 6.2 * k as f64 / points as f64;
            let at = |k: usize| Vec2::new(angle(k).cos(), angle(k).sin()) * 20.0;
            (0..points).map(|k| [at(k), at(k + 1)]).collect::<Vec<_>>()
        };
        for points in [9, 300] {
            let ring = arc(points);
            let (from, to) = (ring[0][0], ring[points - 1][1]);
            let found = gap_beside(from, (&ring, &[]), 5.0).unwrap();
            assert!((found - to).norm() < 1e-9);
            assert_eq!(gap_beside(from, (&ring[..points / 2], &[]), 5.0), None);
        }
        // An end on the side of a house, to rounding.
        let house = [place(1e-9, -5.0), place(1e-9, 5.0)];
        assert_eq!(gap_beside(place(0.0, 0.0), (&own, &[house]), 5.0), None);
    }
}
