//! Steep banks that the terrain shows: lines through the steps between its pixels.
//!
//! Between two neighbouring pixels stands a bank where the ground rises by what counts as a step in a cell, and by much more than it does before and
//! behind. A raster shows a bank askew as stairs. The line is the one that parts the centres of the higher pixels from those of the lower ones
//! with the widest margin, in as many straight pieces as that takes. So no pixel of the bank counts as ground of the channel.

use std::collections::BTreeMap;

use crate::bed::least_step;
use crate::constants::BedConstants;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::terrain::{PixelGrid, Terrain};

/// A bank rises by so many times what the ground does before and behind it.
const STEEPER: f64 = 3.0;
/// A bank is so many cells long at least: a shorter one is a rock or a kerb.
const LEAST_LENGTH: f64 = 4.0;
/// Thirds by which the search for the widest margin is narrowed: to a millionth of a pixel.
const THIRDS: usize = 40;
/// Lines that differ by less than this (sine of the angle) have no corner.
const CORNER: f64 = 0.01;
/// A corner lies so many pixels from the stairs at most.
const NEAR: f64 = 1.0;
/// Pixels as wide as cells count, too.
const AS_WIDE: f64 = 1.01;

/// A side of a pixel with a step, the higher pixel on its left.
#[derive(Clone, Copy, Debug)]
struct Step {
    /// Corner (column, row) of the pixels at its beginning and at its end.
    ends: [(i64, i64); 2],
    /// Centres of the pixels on both sides (local, m).
    higher: Vec2,
    lower: Vec2,
}

impl Step {
    fn middle(&self) -> Vec2 {
        (self.higher + self.lower) * 0.5
    }
}

/// The banks of a terrain as lines in local coordinates (m); none where no raster is as fine as the cells.
pub(super) fn find(terrain: &Terrain, lattice: &Lattice, constants: &BedConstants) -> Vec<Vec<Vec2>> {
    let low = lattice.to_map(Vec2::ZERO);
    let high = lattice.to_map(lattice.size());
    let Some(grid) = terrain.pixel_grid(low, high, AS_WIDE * lattice.spacing) else { return Vec::new() };
    let pixels = Pixels::read(terrain, &grid, (low, high), lattice);
    let steps = pixels.steps(least_step(lattice.spacing, constants));
    let pixel = grid.cell().x.max(grid.cell().y);
    let is_long = |line: &Vec<Vec2>| {
        let length: f64 = line.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        length >= LEAST_LENGTH * lattice.spacing
    };
    chains(&steps).iter().map(|chain| straightened(chain, pixel)).filter(is_long).collect()
}

/// The pixels about a lattice.
struct Pixels {
    first: (i64, i64),
    columns: usize,
    rows: usize,
    /// Elevations (m), row 0 in the north.
    values: Vec<f64>,
    /// Centre of the first pixel (local, m), and width and height of each.
    centre: Vec2,
    cell: Vec2,
}

impl Pixels {
    fn read(terrain: &Terrain, grid: &PixelGrid, (low, high): (Vec2, Vec2), lattice: &Lattice) -> Pixels {
        let block = grid.block(low, high);
        let (columns, rows) = (block.columns.clone().count(), block.rows.clone().count());
        let row = |row: i64| block.columns.clone().map(move |column| terrain.pixel(grid, column, row));
        let values = block.rows.clone().flat_map(row).collect();
        let first = (block.columns.start, block.rows.start);
        let centre = lattice.to_local(grid.centre(first.0, first.1));
        Pixels { first, columns, rows, values, centre, cell: grid.cell() }
    }

    /// Elevation (m) of a pixel; none without one.
    fn at(&self, column: i64, row: i64) -> Option<f64> {
        let (column, row) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
        let value = (column < self.columns && row < self.rows).then(|| self.values[row * self.columns + column])?;
        Some(value).filter(|value| !value.is_nan())
    }

    fn centre_of(&self, (column, row): (i64, i64)) -> Vec2 {
        self.centre + Vec2::new(column as f64 * self.cell.x, -(row as f64) * self.cell.y)
    }

    /// The rise (m) from a pixel to the next in a direction (columns, rows), where a bank stands between them.
    fn rise(&self, (column, row): (i64, i64), (across, down): (i64, i64), least: f64) -> Option<f64> {
        let at = |steps: i64| self.at(column + steps * across, row + steps * down);
        let (own, next) = (at(0)?, at(1)?);
        let rise = next - own;
        let before = at(-1).map_or(0.0, |before| (own - before).abs());
        let behind = at(2).map_or(0.0, |behind| (behind - next).abs());
        (rise.abs() >= least && rise.abs() >= STEEPER * before.max(behind)).then_some(rise)
    }

    /// All steps, row by row.
    fn steps(&self, least: f64) -> Vec<Step> {
        let mut steps = Vec::new();
        for row in 0..self.rows as i64 {
            for column in 0..self.columns as i64 {
                let corner = |across: i64, down: i64| (self.first.0 + column + across, self.first.1 + row + down);
                let own = (column, row);
                // Corners of the common side from right to left of who looks towards the next pixel.
                let sides = [((1, 0), [corner(1, 1), corner(1, 0)]), ((0, 1), [corner(0, 1), corner(1, 1)])];
                for (direction, [right, left]) in sides {
                    let Some(rise) = self.rise(own, direction, least) else { continue };
                    let [own, next] = [own, (column + direction.0, row + direction.1)].map(|at| self.centre_of(at));
                    steps.push(if rise > 0.0 {
                        Step { ends: [left, right], higher: next, lower: own }
                    } else {
                        Step { ends: [right, left], higher: own, lower: next }
                    });
                }
            }
        }
        steps
    }
}

/// Steps that follow each other, as far as each has one that follows it.
fn chains(steps: &[Step]) -> Vec<Vec<Step>> {
    let mut from: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
    let mut to: BTreeMap<(i64, i64), usize> = BTreeMap::new();
    for (number, step) in steps.iter().enumerate() {
        from.entry(step.ends[0]).or_default().push(number);
        *to.entry(step.ends[1]).or_default() += 1;
    }
    let next = |step: usize| {
        let corner = steps[step].ends[1];
        match from.get(&corner).map(Vec::as_slice) {
            Some([only]) if to[&corner] == 1 => Some(*only),
            _ => None,
        }
    };
    let mut is_taken = vec![false; steps.len()];
    let follow = |first: usize, is_taken: &mut Vec<bool>| {
        let mut chain = Vec::new();
        let mut at = Some(first);
        while let Some(step) = at.filter(|&step| !is_taken[step]) {
            is_taken[step] = true;
            chain.push(steps[step]);
            at = next(step);
        }
        chain
    };
    let begins = |step: &usize| {
        let corner = steps[*step].ends[0];
        to.get(&corner) != Some(&1) || from[&corner].len() != 1
    };
    let mut found: Vec<Vec<Step>> = (0..steps.len()).filter(begins).map(|step| follow(step, &mut is_taken)).collect();
    // What is left closes.
    for step in 0..steps.len() {
        if !is_taken[step] {
            found.push(follow(step, &mut is_taken));
        }
    }
    found
}

/// A straight line: a place on it, and its direction (unit length).
#[derive(Clone, Copy, Debug)]
struct Straight {
    place: Vec2,
    direction: Vec2,
}

impl Straight {
    /// Where the line passes between the two pixels of a step.
    fn between(&self, step: &Step) -> Vec2 {
        let [higher, lower] = [step.higher, step.lower].map(|centre| self.direction.cross(centre - self.place));
        step.lower + (step.higher - step.lower) * (lower / (lower - higher))
    }

    /// Where two lines meet; none where they have no corner.
    fn meeting(&self, other: &Straight) -> Option<Vec2> {
        let sine = self.direction.cross(other.direction);
        let share = (other.place - self.place).cross(other.direction) / sine;
        (sine.abs() >= CORNER).then(|| self.place + self.direction * share)
    }
}

/// A chain as a line of straight pieces that passes between the two pixels of each step; `pixel` is the longer side of a pixel (m).
fn straightened(chain: &[Step], pixel: f64) -> Vec<Vec2> {
    let lines = lines(chain, pixel);
    let joined = lines.windows(2).flat_map(|pair| {
        let [(one, end), (other, _)] = [pair[0], pair[1]];
        joint((&one, &chain[end - 1]), (&other, &chain[end]), pixel)
    });
    let mut points: Vec<Vec2> = joined.collect();
    let (Some((first, _)), Some((last, _))) = (lines.first(), lines.last()) else { return points };
    let (begin, end) = (&chain[0], &chain[chain.len() - 1]);
    if lines.len() > 1 && end.ends[1] == begin.ends[0] {
        points.extend(joint((last, end), (first, begin), pixel));
        points.insert(0, points[points.len() - 1]);
    } else {
        points.insert(0, first.between(begin));
        points.push(last.between(end));
    }
    points
}

/// The corner of two lines whose steps follow each other: where they meet, if that is near the stairs; else from one to the other between them.
fn joint((one, behind): (&Straight, &Step), (other, ahead): (&Straight, &Step), pixel: f64) -> Vec<Vec2> {
    let stairs = (behind.middle() + ahead.middle()) * 0.5;
    match one.meeting(other).filter(|meeting| (*meeting - stairs).norm() <= NEAR * pixel) {
        Some(meeting) => vec![meeting],
        None => vec![one.between(behind), other.between(ahead)],
    }
}

/// The longest parts of a chain, one after the other, whose higher pixels a straight line parts from the lower ones: their lines, each with the
/// number of the step behind its last one.
fn lines(chain: &[Step], pixel: f64) -> Vec<(Straight, usize)> {
    let mut lines = Vec::new();
    let mut first = 0;
    while first < chain.len() {
        let is_straight = |count: usize| parting(&chain[first..first + count], pixel).0 > 0.0;
        let rest = chain.len() - first;
        // A part of what is straight is straight: so many steps are, and so many are not.
        let (mut straight, mut bent) = (1, 2);
        while bent <= rest && is_straight(bent) {
            (straight, bent) = (bent, 2 * bent);
        }
        bent = bent.min(rest + 1);
        while bent - straight > 1 {
            let middle = (straight + bent) / 2;
            if is_straight(middle) {
                straight = middle;
            } else {
                bent = middle;
            }
        }
        lines.push((parting(&chain[first..first + straight], pixel).1, first + straight));
        first += straight;
    }
    lines
}

/// The line that parts the higher pixels of some steps from the lower ones with the widest margin (m), which is negative where none parts them.
///
/// For small turns the margin is that of a least over one set of straight functions less a greatest over another: it has one maximum.
fn parting(steps: &[Step], pixel: f64) -> (f64, Straight) {
    let count = steps.len() as f64;
    let mean = steps.iter().fold(Vec2::ZERO, |sum, step| sum + step.middle()) * (1.0 / count);
    let way = steps[steps.len() - 1].middle() - steps[0].middle();
    let along = if way.norm() > 0.5 * pixel {
        way * (1.0 / way.norm())
    } else {
        // Of one step alone: square to the way from the lower to the higher pixel, which lies on the left.
        let up = steps[0].higher - steps[0].lower;
        up.perpendicular() * (-1.0 / up.norm())
    };
    let margin = |turn: f64| {
        let direction = along + along.perpendicular() * turn;
        let direction = direction * (1.0 / direction.norm());
        let left = direction.perpendicular();
        let height = |place: Vec2| left.dot(place - mean);
        let higher = steps.iter().map(|step| height(step.higher)).fold(f64::INFINITY, f64::min);
        let lower = steps.iter().map(|step| height(step.lower)).fold(f64::NEG_INFINITY, f64::max);
        (higher - lower, Straight { place: mean + left * (0.5 * (higher + lower)), direction })
    };
    let reach = (pixel / way.norm().max(pixel)).min(0.5);
    let (mut low, mut high) = (-reach, reach);
    for _ in 0..THIRDS {
        let third = (high - low) / 3.0;
        if margin(low + third).0 < margin(high - third).0 {
            low += third;
        } else {
            high -= third;
        }
    }
    margin(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::{Layer, Raster};

    /// Pixels of `pixel` (m) over 400 m by 400 m, 0 where `is_low` and 3 m elsewhere, on ground that falls.
    fn terrain(pixel: f64, is_low: impl Fn(Vec2) -> bool) -> Terrain {
        let count = (400.0 / pixel) as usize;
        let place = |cell: usize| {
            let (column, row) = ((cell % count) as f64, (cell / count) as f64);
            Vec2::new((column + 0.5) * pixel, 400.0 - (row + 0.5) * pixel)
        };
        let height = |place: Vec2| if is_low(place) { 0.0 } else { 3.0 } - 0.002 * place.x;
        let values = (0..count * count).map(place).map(height).collect();
        let raster =
            Raster { columns: count, rows: count, west: 0.0, north: 400.0, cell_x: pixel, cell_y: pixel, values };
        Terrain::new(vec![Layer::Raster(raster)]).unwrap()
    }

    fn banks(terrain: &Terrain) -> Vec<Vec<Vec2>> {
        find(terrain, &Lattice::new(Vec2::ZERO, 40, 40, 10.0), &BedConstants::DEFAULT)
    }

    #[test]
    fn the_banks_of_a_channel_askew_are_straight_lines_on_them() {
        for degrees in [5.0_f64, 17.0, 30.0, 45.0, 63.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let off = |place: Vec2| (place.y - 200.0) * cosine - (place.x - 200.0) * sine;
            for (pixel, tolerance) in [(10.0, 3.0), (2.0, 0.6)] {
                let lines = banks(&terrain(pixel, |place| off(place).abs() < 25.0));
                assert_eq!(lines.len(), 2, "{degrees} degrees, pixels of {pixel} m: {lines:?}");
                for point in lines.iter().flatten() {
                    let error = (off(*point).abs() - 25.0).abs();
                    assert!(error < tolerance, "{degrees} degrees, pixels of {pixel} m: {point:?} is {error} m off");
                }
            }
        }
    }

    #[test]
    fn a_corner_stays_a_corner_and_a_pond_is_a_ring() {
        let is_low = |place: Vec2| place.x > 100.0 && place.x < 300.0 && place.y > 120.0 && place.y < 260.0;
        let lines = banks(&terrain(10.0, is_low));
        assert_eq!(lines.len(), 1);
        for corner in [(100.0, 120.0), (300.0, 120.0), (300.0, 260.0), (100.0, 260.0)] {
            let corner = Vec2::new(corner.0, corner.1);
            let nearest = lines[0].iter().map(|point| (*point - corner).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 8.0, "{corner:?}: {nearest}, {lines:?}");
        }
    }

    #[test]
    fn a_winding_bank_has_every_pixel_on_its_own_side() {
        for pixel in [10.0, 4.0, 2.0] {
            let middle = |x: f64| 200.0 + 60.0 * (x / 60.0).sin();
            let is_low = |place: Vec2| (place.y - middle(place.x)).abs() < 25.0;
            let lines = banks(&terrain(pixel, is_low));
            let (mut wrong, mut near) = (0, 0);
            let count = (400.0 / pixel) as usize;
            for cell in 0..count * count {
                let at = |k: usize| (k as f64 + 0.5) * pixel;
                let place = Vec2::new(at(cell % count), at(cell / count));
                if !(20.0..380.0).contains(&place.x) || ((place.y - middle(place.x)).abs() - 25.0).abs() > 2.0 * pixel {
                    continue;
                }
                // From the middle of the channel a way to a pixel of the bank crosses one of the lines, and to its own pixels none;
                // a little askew, for lines turn between pixels of one column.
                let from = Vec2::new(place.x + 0.01, middle(place.x));
                let crossed = lines.iter().flat_map(|line| line.windows(2));
                let crossed = crossed.filter(|ends| crate::math::segments_cross([from, place], [ends[0], ends[1]]));
                near += 1;
                wrong += usize::from((crossed.count() % 2 == 1) == is_low(place));
            }
            assert!(wrong == 0 && near > 200, "pixels of {pixel} m: {wrong} of {near} on the wrong side");
        }
    }

    #[test]
    fn slopes_and_rocks_have_no_banks() {
        assert_eq!(banks(&terrain(10.0, |_| true)), Vec::<Vec<Vec2>>::new());
        let rock = |place: Vec2| (place - Vec2::new(205.0, 205.0)).norm() > 5.0;
        assert_eq!(banks(&terrain(10.0, rock)), Vec::<Vec<Vec2>>::new());
    }
}
