//! Steep banks that the terrain shows: lines through the steps between its pixels.
//!
//! Between two neighbouring pixels stands a bank where the ground rises by what counts as a step in a cell, and by much more than it does before and
//! behind. A raster shows a bank askew as stairs. The line is the one that parts the centres of the higher pixels from those of the lower ones
//! with the widest margin, in as many straight pieces as that takes. So no pixel of the bank counts as ground of the channel.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use crate::bed::least_step;
use crate::constants::BedConstants;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::terrain::{PixelGrid, Terrain};

/// A bank rises by so many times what the ground does before and behind it.
const STEEPER: f64 = 3.0;
/// A bank is so many cells long at least: along a shorter one, as of a rock or a kerb, runs no channel.
const LEAST_LENGTH: f64 = 10.0;
/// Thirds by which the search for the widest margin is narrowed: to a millionth of a pixel.
const THIRDS: usize = 40;
/// Lines that differ by less than this (sine of the angle) have no corner.
const CORNER: f64 = 0.01;
/// A corner lies so many pixels from the stairs at most.
const NEAR: f64 = 1.0;
/// So far (spacings) from the sides of squares a line lies on them.
const ON_SIDE: f64 = 1e-3;
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
///
/// - `counts`: whether a step does, given the way (local) from the centre of its higher pixel to that of the other
pub(super) fn find(
    terrain: &Terrain,
    lattice: &Lattice,
    constants: &BedConstants,
    counts: impl Fn([Vec2; 2]) -> bool + Sync,
) -> Vec<Vec<Vec2>> {
    let low = lattice.to_map(Vec2::ZERO);
    let high = lattice.to_map(lattice.size());
    let grids = terrain.pixel_grids(low, high, AS_WIDE * lattice.spacing);
    let of_grid = |(number, grid): (usize, &PixelGrid)| {
        let found = on_grid(terrain, grid, (lattice, low, high), constants, &counts);
        found.into_iter().map(move |points| Bank { points, grids: [number; 2] }).collect::<Vec<_>>()
    };
    let sides: Vec<f64> = grids.iter().map(longer_side).collect();
    joined_at_seams(grids.iter().enumerate().flat_map(of_grid).collect(), &sides)
}

/// A bank, and the grids of the pixels that show its beginning and its end.
struct Bank {
    points: Vec<Vec2>,
    grids: [usize; 2],
}

/// The longer side of a pixel (m).
fn longer_side(grid: &PixelGrid) -> f64 {
    grid.cell().x.max(grid.cell().y)
}

/// Banks as lines that go on where one grid of pixels ends and another begins: from the end of a bank to the nearest beginning of another, no
/// farther than a pixel of each; `sides` are those of the pixels of each grid (m).
fn joined_at_seams(mut banks: Vec<Bank>, sides: &[f64]) -> Vec<Vec<Vec2>> {
    let mut first = 0;
    while first < banks.len() {
        let Bank { points, grids: [_, grid] } = &banks[first];
        let end = points[points.len() - 1];
        let way = |other: &Bank| (other.points[0] - end).norm();
        let is_next = |other: &Bank| other.grids[0] != *grid && way(other) <= sides[*grid] + sides[other.grids[0]];
        let next = (0..banks.len()).filter(|&k| k != first && is_next(&banks[k]));
        match next.min_by(|&a, &b| way(&banks[a]).total_cmp(&way(&banks[b]))) {
            // The line may go on from its new end.
            Some(next) => {
                let other = banks.remove(next);
                first -= usize::from(next < first);
                banks[first].points.extend(other.points);
                banks[first].grids[1] = other.grids[1];
            }
            None => first += 1,
        }
    }
    banks.into_iter().map(|bank| bank.points).collect()
}

/// The banks between the pixels of a grid.
fn on_grid(
    terrain: &Terrain,
    grid: &PixelGrid,
    (lattice, low, high): (&Lattice, Vec2, Vec2),
    constants: &BedConstants,
    counts: &(impl Fn([Vec2; 2]) -> bool + Sync),
) -> Vec<Vec<Vec2>> {
    let block = grid.block(low, high);
    let first = lattice.to_local(grid.centre(block.columns.start, block.rows.start));
    let pixels = Pixels { terrain, grid, begin: (block.columns.start, block.rows.start), first };
    let least = least_step(lattice.spacing, constants);
    let rows: Vec<i64> = block.rows.collect();
    let of_row = |&row: &i64| pixels.steps(row, block.columns.clone(), least, counts);
    let steps: Vec<Step> = rows.par_iter().flat_map_iter(of_row).collect();
    let pixel = longer_side(grid);
    let least_length = LEAST_LENGTH * lattice.spacing;
    let is_needed = |line: &Vec<Vec2>| {
        let length: f64 = line.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        length >= least_length && !lies_on_sides(line, lattice)
    };
    let chains = chains(&steps);
    // No line is longer than the sides of pixels that it goes along.
    let long = chains.par_iter().filter(|chain| chain.len() as f64 * pixel >= least_length);
    long.map(|chain| straightened(chain, pixel)).filter(is_needed).collect()
}

/// Whether a line lies on the sides of squares as they are.
fn lies_on_sides(line: &[Vec2], lattice: &Lattice) -> bool {
    let is_side = |a: f64, b: f64| {
        let (a, b) = (a / lattice.spacing, b / lattice.spacing);
        (a - b).abs() < ON_SIDE && (a - a.round()).abs() < ON_SIDE
    };
    line.windows(2).all(|ends| is_side(ends[0].x, ends[1].x) || is_side(ends[0].y, ends[1].y))
}

/// The pixels about a lattice.
struct Pixels<'a> {
    terrain: &'a Terrain,
    grid: &'a PixelGrid,
    /// Column and row of the first pixel, and its centre (local, m).
    begin: (i64, i64),
    first: Vec2,
}

impl Pixels<'_> {
    /// Elevation (m) of a pixel; not a number without one, and where a layer with other pixels counts.
    fn at(&self, column: i64, row: i64) -> f64 {
        self.terrain.pixel_of_size(self.grid, column, row)
    }

    fn centre_of(&self, (column, row): (i64, i64)) -> Vec2 {
        let (cell, begin) = (self.grid.cell(), self.begin);
        self.first + Vec2::new((column - begin.0) as f64 * cell.x, -((row - begin.1) as f64) * cell.y)
    }

    /// The rise (m) from a pixel to the next in a direction (columns, rows), where a bank stands between them.
    fn rise(&self, (column, row): (i64, i64), own: f64, (across, down): (i64, i64), least: f64) -> Option<f64> {
        let at = |steps: i64| self.at(column + steps * across, row + steps * down);
        let next = at(1);
        let rise = next - own;
        if rise.is_nan() || rise.abs() < least {
            return None;
        }
        let change = |change: f64| if change.is_nan() { 0.0 } else { change.abs() };
        (rise.abs() >= STEEPER * change(own - at(-1)).max(change(at(2) - next))).then_some(rise)
    }

    /// The steps between the pixels of a row and those to the east and south of them.
    fn steps(&self, row: i64, columns: Range<i64>, least: f64, counts: &impl Fn([Vec2; 2]) -> bool) -> Vec<Step> {
        let mut steps = Vec::new();
        for column in columns {
            let (place, own) = ((column, row), self.at(column, row));
            let corner = |across: i64, down: i64| (column + across, row + down);
            // Corners of the common side from right to left of who looks towards the next pixel.
            let sides = [((1, 0), [corner(1, 1), corner(1, 0)]), ((0, 1), [corner(0, 1), corner(1, 1)])];
            for (direction, [right, left]) in sides {
                let Some(rise) = self.rise(place, own, direction, least) else { continue };
                let [here, next] = [place, (column + direction.0, row + direction.1)].map(|at| self.centre_of(at));
                let step = if rise > 0.0 {
                    Step { ends: [left, right], higher: next, lower: here }
                } else {
                    Step { ends: [right, left], higher: here, lower: next }
                };
                if counts([step.higher, step.lower]) {
                    steps.push(step);
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

/// The parts of a chain, one after the other, whose higher pixels a straight line parts from the lower ones: their lines, each with the number of
/// the step behind its last one. Each is first as long as it can be; then the ends move back, the last one first, to where the narrower of two
/// margins is widest.
fn lines(chain: &[Step], pixel: f64) -> Vec<(Straight, usize)> {
    let (mut ends, mut first) = (Vec::new(), 0);
    while first < chain.len() {
        first += straight_steps(&chain[first..], pixel);
        ends.push(first);
    }
    let begins = |ends: &[usize], number: usize| if number > 0 { ends[number - 1] } else { 0 };
    for number in (1..ends.len()).rev() {
        let (first, behind) = (begins(&ends, number - 1), ends[number]);
        let margins = |end: usize| [first..end, end..behind].map(|part| parting(&chain[part], pixel).0);
        // The longer the first part, the narrower its margin and the wider that of the second.
        let (mut low, mut high) = (first + 1, ends[number - 1]);
        while high - low > 1 {
            let middle = (low + high) / 2;
            let [before, after] = margins(middle);
            if before >= after {
                low = middle;
            } else {
                high = middle;
            }
        }
        let narrower = |end: usize| margins(end).into_iter().fold(f64::INFINITY, f64::min);
        ends[number - 1] = if narrower(low) > narrower(high) { low } else { high };
    }
    let line = |number: usize| (parting(&chain[begins(&ends, number)..ends[number]], pixel).1, ends[number]);
    (0..ends.len()).map(line).collect()
}

/// How many of the first steps of a chain one straight line has between their pixels. A part of what is straight is straight.
fn straight_steps(chain: &[Step], pixel: f64) -> usize {
    let is_straight = |count: usize| parting(&chain[..count], pixel).0 > 0.0;
    // So many steps are, and so many are not.
    let (mut straight, mut bent) = (1, 2);
    while bent <= chain.len() && is_straight(bent) {
        (straight, bent) = (bent, 2 * bent);
    }
    bent = bent.min(chain.len() + 1);
    while bent - straight > 1 {
        let middle = (straight + bent) / 2;
        if is_straight(middle) {
            straight = middle;
        } else {
            bent = middle;
        }
    }
    straight
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
mod tests;
