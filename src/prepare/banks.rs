//! Steep banks that the terrain shows: lines through the steps between its pixels.
//!
//! Between two neighbouring pixels stands a bank where the ground rises by what counts as a step in a cell, and by much more than it does before and
//! behind. A raster shows a bank askew as stairs. The line is the one that parts the centres of the higher pixels from those of the lower ones
//! with the widest margin, piece by piece.

use std::collections::BTreeMap;

use crate::bed::least_step;
use crate::constants::BedConstants;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::terrain::{PixelGrid, Terrain};

/// A bank rises by so many times what the ground does before and behind it.
const STEEPER: f64 = 3.0;
/// Pixels by which the stairs of one straight bank lie off its line.
const STAIRS: f64 = 0.75;
/// A bank is so many cells long at least: a shorter one is a rock or a kerb.
const LEAST_LENGTH: f64 = 4.0;
/// Directions that are tried to either side for the widest margin.
const TURNS: i32 = 20;
/// Lines that differ by less than this (sine of the angle) have no corner.
const CORNER: f64 = 0.1;
/// A corner lies so many pixels from the stairs at most.
const NEAR: f64 = 3.0;
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
    fn nearest(&self, place: Vec2) -> Vec2 {
        self.place + self.direction * self.direction.dot(place - self.place)
    }
}

/// A chain as a line of straight pieces; `pixel` is the longer side of a pixel (m).
fn straightened(chain: &[Step], pixel: f64) -> Vec<Vec2> {
    let mut parts = Vec::new();
    part(chain, 0, pixel, &mut parts);
    let lines: Vec<(Straight, usize)> =
        parts.iter().map(|&(from, to)| (parting(&chain[from..to], pixel), to)).collect();
    let Some((first, _)) = lines.first() else { return Vec::new() };
    let mut points = vec![first.nearest(chain[0].middle())];
    for pair in lines.windows(2) {
        let [(one, end), (other, _)] = [pair[0], pair[1]];
        let stairs = (chain[end - 1].middle() + chain[end].middle()) * 0.5;
        points.push(corner(&one, &other, stairs, pixel));
    }
    if let (Some((last, _)), Some(step)) = (lines.last(), chain.last()) {
        points.push(last.nearest(step.middle()));
        // A ring closes.
        if lines.len() > 1 && step.ends[1] == chain[0].ends[0] {
            let stairs = (step.middle() + chain[0].middle()) * 0.5;
            let closing = corner(last, first, stairs, pixel);
            let end = points.len() - 1;
            (points[0], points[end]) = (closing, closing);
        }
    }
    points
}

/// Divides steps where they leave the line from the first to the last one; `first` is the number of the first of them.
fn part(steps: &[Step], first: usize, pixel: f64, parts: &mut Vec<(usize, usize)>) {
    let [from, .., to] = steps else {
        parts.push((first, first + steps.len()));
        return;
    };
    let way = to.middle() - from.middle();
    let off = |step: &Step| {
        let offset = step.middle() - from.middle();
        if way.norm() > 0.0 { (way.x * offset.y - way.y * offset.x).abs() / way.norm() } else { offset.norm() }
    };
    let farthest = (1..steps.len()).max_by(|&a, &b| off(&steps[a]).total_cmp(&off(&steps[b])));
    match farthest.filter(|&at| off(&steps[at]) > 2.0 * STAIRS * pixel) {
        Some(at) => {
            part(&steps[..at], first, pixel, parts);
            part(&steps[at..], first + at, pixel, parts);
        }
        None => parts.push((first, first + steps.len())),
    }
}

/// The line that parts the higher pixels of some steps from the lower ones with the widest margin.
fn parting(steps: &[Step], pixel: f64) -> Straight {
    let count = steps.len() as f64;
    let mean = steps.iter().fold(Vec2::ZERO, |sum, step| sum + step.middle()) * (1.0 / count);
    let way = steps[steps.len() - 1].middle() - steps[0].middle();
    let along = if way.norm() > 0.5 * pixel {
        way * (1.0 / way.norm())
    } else {
        // Of one step alone: square to the way from the lower to the higher pixel, which lies on the left.
        let up = steps[0].higher - steps[0].lower;
        Vec2::new(up.y, -up.x) * (1.0 / up.norm())
    };
    let reach = (pixel / way.norm().max(pixel)).min(0.5);
    let margin = |turn: i32| {
        let tilt = reach * f64::from(turn) / f64::from(TURNS);
        let direction = along + Vec2::new(-along.y, along.x) * tilt;
        let direction = direction * (1.0 / direction.norm());
        let left = Vec2::new(-direction.y, direction.x);
        let height = |place: Vec2| left.dot(place - mean);
        let higher = steps.iter().map(|step| height(step.higher)).fold(f64::INFINITY, f64::min);
        let lower = steps.iter().map(|step| height(step.lower)).fold(f64::NEG_INFINITY, f64::max);
        (higher - lower, Straight { place: mean + left * (0.5 * (higher + lower)), direction })
    };
    // Of equal margins the one that turns least.
    let turns = (0..=TURNS).flat_map(|turn| [turn, -turn]).map(margin);
    let mut widest = margin(0);
    for tried in turns {
        if tried.0 > widest.0 {
            widest = tried;
        }
    }
    widest.1
}

/// Where two straight lines meet near the stairs; between them where they have no corner there.
fn corner(one: &Straight, other: &Straight, stairs: Vec2, pixel: f64) -> Vec2 {
    let sine = one.direction.x * other.direction.y - one.direction.y * other.direction.x;
    let between = (one.nearest(stairs) + other.nearest(stairs)) * 0.5;
    if sine.abs() < CORNER {
        return between;
    }
    let offset = other.place - one.place;
    let share = (offset.x * other.direction.y - offset.y * other.direction.x) / sine;
    let meeting = one.place + one.direction * share;
    if (meeting - stairs).norm() <= NEAR * pixel { meeting } else { between }
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
    fn slopes_and_rocks_have_no_banks() {
        assert_eq!(banks(&terrain(10.0, |_| true)), Vec::<Vec<Vec2>>::new());
        let rock = |place: Vec2| (place - Vec2::new(205.0, 205.0)).norm() > 5.0;
        assert_eq!(banks(&terrain(10.0, rock)), Vec::<Vec<Vec2>>::new());
    }
}
