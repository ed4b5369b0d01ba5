//! Ends, corners and crossings of lines, and the stretches of line between them.

use std::f64::consts::PI;

use super::TOLERANCE;
use super::lines::{Network, Trace};
use super::weld::Weld;
use crate::math::Vec2;

/// A turn (radians) from which a bend of a line is a corner: 32 degrees. Below, the pairs of seeds on either side of the bend still fit
/// each other.
const CORNER: f64 = 32.0 * PI / 180.0;

/// Lines that leave a node in directions nearer than this (radians) count as one: 3 degrees.
const SAME_DIRECTION: f64 = 3.0 * PI / 180.0;

/// A place where lines end, bend or meet.
pub struct Node {
    /// The place.
    pub place: Vec2,
    /// The directions (radians) in which lines leave it, ascending.
    pub arms: Vec<f64>,
}

/// A stretch of a line between two nodes.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// The line.
    pub line: usize,
    /// Length along the line where it begins.
    pub from: f64,
    /// Length along the line where it ends; beyond the length of a ring where it goes on around.
    pub to: f64,
}

/// The nodes of a network, and the stretches between them.
pub fn nodes(network: &Network) -> (Vec<Node>, Vec<Stretch>) {
    let mut cuts: Vec<Vec<f64>> = network.traces.iter().map(own_nodes).collect();
    for [a, b] in neighbours(network) {
        for place in network.segments[a].meetings(&network.segments[b], TOLERANCE) {
            for number in [a, b] {
                cuts[network.segments[number].line].push(length_at(network, number, place));
            }
        }
    }
    let mut weld = Weld::default();
    for (trace, cuts) in network.traces.iter().zip(&cuts) {
        cuts.iter().for_each(|cut| _ = weld.number(trace.at(*cut)));
    }
    let node = |place: &Vec2| Node { place: *place, arms: arms(network, *place) };
    let nodes = weld.places.iter().map(node).collect();
    let stretches = cuts.into_iter().enumerate().flat_map(|(line, cuts)| stretches(line, &network.traces[line], cuts));
    (nodes, stretches.collect())
}

/// Ends and corners of a line, as lengths along it.
fn own_nodes(trace: &Trace) -> Vec<f64> {
    let count = trace.points.len();
    if count < 2 {
        return Vec::new();
    }
    let turn = |before: Vec2, at: Vec2, after: Vec2| {
        let (a, b) = (at - before, after - at);
        a.cross(b).atan2(a.dot(b)).abs()
    };
    let is_corner = |i: &usize| turn(trace.points[i - 1], trace.points[*i], trace.points[i + 1]) > CORNER;
    let mut found: Vec<f64> = (1..count - 1).filter(is_corner).map(|i| trace.lengths[i]).collect();
    if !trace.is_closed {
        found.extend([0.0, trace.length()]);
    } else if turn(trace.points[count - 2], trace.points[0], trace.points[1]) > CORNER {
        found.push(0.0);
    }
    found
}

/// Pairs of segments that may meet, but for those that follow each other on a line.
fn neighbours(network: &Network) -> Vec<[usize; 2]> {
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    for square in network.touched_squares() {
        let segments = network.of_square(square);
        for (i, a) in segments.iter().enumerate() {
            pairs.extend(segments[i + 1..].iter().filter(|b| !follow(network, *a, **b)).map(|b| (*a, *b)));
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs.into_iter().map(|(a, b)| [a as usize, b as usize]).collect()
}

/// Whether two segments, the earlier one first, follow each other on a line.
fn follow(network: &Network, a: u32, b: u32) -> bool {
    let (line, other) = (network.segments[a as usize].line, network.segments[b as usize].line);
    let trace = &network.traces[line];
    let steps = (b - a) as usize;
    line == other && (steps == 1 || (trace.is_closed && steps == trace.segment_count() - 1))
}

/// Length along its line of a place on a segment.
fn length_at(network: &Network, number: usize, place: Vec2) -> f64 {
    let segment = &network.segments[number];
    let trace = &network.traces[segment.line];
    trace.lengths[number - trace.first_segment] + (place - segment.ends[0]).norm()
}

/// The directions in which lines leave a place.
fn arms(network: &Network, place: Vec2) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    for number in network.at(place) {
        let segment = &network.segments[*number as usize];
        if segment.distance(place) > 2.0 * TOLERANCE {
            continue;
        }
        let ways = segment.ends.map(|end| end - place).into_iter().filter(|way| way.norm() > 2.0 * TOLERANCE);
        found.extend(ways.map(|way| way.y.atan2(way.x)));
    }
    found.sort_by(f64::total_cmp);
    // Directions that belong together across the turn from π to −π are moved to one end.
    let tail = (1..found.len()).find(|i| found[*i] - found[i - 1] >= SAME_DIRECTION);
    if let (Some(tail), Some(last)) = (tail, found.last())
        && found[0] + 2.0 * PI - last < SAME_DIRECTION
    {
        found.rotate_left(tail);
        let count = found.len();
        found[count - tail..].iter_mut().for_each(|angle| *angle += 2.0 * PI);
    }
    let bundles = found.chunk_by(|a, b| b - a < SAME_DIRECTION);
    bundles.map(|bundle| 0.5 * (bundle[0] + bundle[bundle.len() - 1])).collect()
}

fn stretches(line: usize, trace: &Trace, mut cuts: Vec<f64>) -> Vec<Stretch> {
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|later, earlier| *later - *earlier <= 2.0 * TOLERANCE);
    if trace.is_closed {
        let first = cuts.first().copied().unwrap_or(0.0);
        cuts.push(first + trace.length());
        if cuts.len() == 1 {
            cuts.insert(0, 0.0);
        }
    }
    cuts.windows(2).map(|ends| Stretch { line, from: ends[0], to: ends[1] }).collect()
}
