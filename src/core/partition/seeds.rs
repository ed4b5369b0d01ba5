//! Where the seeds of the cells stand: around nodes, in pairs along lines, and at the centres of the lattice's squares elsewhere.

use std::f64::consts::PI;

use super::inside::Outlines;
use super::lines::Network;
use super::nodes::{Node, Stretch, nodes};
use super::window::{Square, Window, centre_of, square_of};
use crate::math::Vec2;

/// Distance of a seed from its line, as in the study of moving particles (F11).
const OFFSET: f64 = 0.4;

/// Streets narrower than this have one row of seeds in their middle, wider ones a row along each side.
const ONE_ROW: f64 = 1.31;

/// Up to which distance another line counts as the other side of a street: its rows then stand a quarter of the width from the walls.
const STREET: f64 = 4.0 * OFFSET;

/// Least width between two lines that gets seeds at all.
const LEAST_WIDTH: f64 = 1e-3;

/// The same around a node: an end that just misses a wall gets no seeds in between.
const LEAST_WIDTH_AT_NODE: f64 = 0.2;

/// Seeds of lines on the same side of all lines are at least so far apart.
const LEAST_DISTANCE: f64 = 0.603;

/// Squares whose centre is nearer to a line lose their seed. Not a number that squares of a plan hit exactly: a tie would fall to
/// rounding, differently in a mirror.
const CLEARANCE: f64 = 0.7937;

/// A square keeps its seed nevertheless where it is this far from lines and other seeds: no hole is left beside corners and ends.
const HOLE_CLEARANCE: f64 = 0.317;
const HOLE: f64 = 0.797;

/// Squares farther (in squares) from all lines have their own seed and no other.
const REACH: i64 = 4;

const NONE: u32 = u32::MAX;

/// The seeds.
pub struct Seeds {
    window: Window,
    /// Where they are.
    pub places: Vec<Vec2>,
    /// The square whose centre each one is.
    pub square: Vec<Option<Square>>,
    is_near: Vec<bool>,
    first: Vec<u32>,
    next: Vec<u32>,
}

impl Seeds {
    /// The seeds of a network.
    pub fn new(network: &Network, outlines: &Outlines) -> Self {
        let window = network.window;
        let mut seeds = Seeds {
            window,
            places: Vec::new(),
            square: Vec::new(),
            is_near: near_lines(network),
            first: vec![NONE; window.len()],
            next: Vec::new(),
        };
        let (nodes, stretches) = nodes(network);
        let of_nodes = nodes.iter().flat_map(|node| around(node, network));
        let of_lines = stretches.iter().flat_map(|stretch| along(stretch, network));
        for place in of_nodes.chain(of_lines) {
            if seeds.is_free(place, LEAST_DISTANCE, network) && !outlines.hold(place) {
                seeds.add(place, None);
            }
        }
        seeds.add_squares(network, outlines);
        seeds
    }

    /// The squares near lines. All others have a seed in their centre and no other.
    pub fn near_squares(&self) -> impl Iterator<Item = Square> + '_ {
        (0..self.is_near.len()).filter(|index| self.is_near[*index]).map(|index| self.window.square(index))
    }

    /// Calls for each seed in a square.
    #[inline]
    pub fn visit(&self, square: Square, mut call: impl FnMut(Vec2)) {
        match self.window.index(square).filter(|index| self.is_near[*index]) {
            Some(index) => {
                let mut seed = self.first[index];
                while seed != NONE {
                    call(self.places[seed as usize]);
                    seed = self.next[seed as usize];
                }
            }
            None => call(centre_of(square)),
        }
    }

    /// Whether the Voronoi cell of a seed is the square of which it is the centre.
    ///
    /// It is where the four squares beside it have their seeds, and no other seed is nearer to one of its corners than its centre.
    pub fn is_square(&self, seed: usize) -> bool {
        let Some(square) = self.square[seed] else { return false };
        let centre = centre_of(square);
        let beside = [(1, 0), (-1, 0), (0, 1), (0, -1)].map(|(across, up)| (square.0 + across, square.1 + up));
        let has_own = |square: Square| {
            let mut found = false;
            self.visit(square, |place| found |= (place - centre_of(square)).norm_squared() < 1e-18);
            found
        };
        if !beside.into_iter().all(has_own) {
            return false;
        }
        let mut is_cut = false;
        for (across, up) in around_squares(2) {
            self.visit((square.0 + across, square.1 + up), |place| {
                let away = place - centre;
                // The nearest corner: half a square towards the seed in both directions.
                let corner = Vec2::new(away.x.abs() - 0.5, away.y.abs() - 0.5);
                is_cut |= away.norm_squared() > 1e-18 && corner.norm_squared() < 0.5 - 1e-9;
            });
        }
        !is_cut
    }

    fn add(&mut self, place: Vec2, square: Option<Square>) {
        let Some(index) = self.window.index(square_of(place)) else { return };
        self.places.push(place);
        self.square.push(square);
        self.next.push(self.first[index]);
        self.first[index] = self.places.len() as u32 - 1;
    }

    /// Whether no seed on the same side of all lines is nearer than a distance, 1 at most.
    fn is_free(&self, place: Vec2, distance: f64, network: &Network) -> bool {
        let (column, row) = square_of(place);
        for (across, up) in around_squares(1) {
            let Some(index) = self.window.index((column + across, row + up)) else { continue };
            let mut seed = self.first[index];
            while seed != NONE {
                let other = self.places[seed as usize];
                if (other - place).norm_squared() < distance * distance && !network.is_parted(place, other) {
                    return false;
                }
                seed = self.next[seed as usize];
            }
        }
        true
    }

    /// Adds the centres of the squares near lines.
    fn add_squares(&mut self, network: &Network, outlines: &Outlines) {
        let mut held_back = Vec::new();
        let near: Vec<Square> = self.near_squares().collect();
        for square in near {
            let centre = centre_of(square);
            let distance = network.distance(centre);
            if distance > CLEARANCE && self.is_free(centre, LEAST_DISTANCE, network) {
                self.add(centre, Some(square));
            } else if distance > HOLE_CLEARANCE {
                held_back.push(square);
            }
        }
        for square in held_back {
            let centre = centre_of(square);
            if self.is_free(centre, HOLE, network) && !outlines.hold(centre) {
                self.add(centre, Some(square));
            }
        }
    }
}

fn around_squares(reach: i64) -> impl Iterator<Item = Square> {
    (-reach..=reach).flat_map(move |up| (-reach..=reach).map(move |across| (across, up)))
}

fn near_lines(network: &Network) -> Vec<bool> {
    let mut near = vec![false; network.window.len()];
    for (column, row) in network.touched_squares() {
        for (across, up) in around_squares(REACH) {
            if let Some(index) = network.window.index((column + across, row + up)) {
                near[index] = true;
            }
        }
    }
    near
}

/// Distance from a line at which a seed stands that sees the next line at a distance.
fn offset(width: f64, usual: f64) -> Option<f64> {
    match width {
        _ if width < LEAST_WIDTH => None,
        _ if width < ONE_ROW => Some(0.5 * width),
        _ => Some(usual * (width / STREET).min(1.0)),
    }
}

/// The seeds around a node: on a circle through the first pairs of seeds of its lines, so that the node is a corner of their cells.
fn around(node: &Node, network: &Network) -> Vec<Vec2> {
    let radius = 0.5_f64.hypot(OFFSET);
    let first_pair = OFFSET.atan2(0.5);
    let after = node.arms.iter().skip(1).copied().chain(node.arms.first().map(|first| first + 2.0 * PI));
    let mut sectors: Vec<(f64, f64)> =
        node.arms.iter().zip(after).map(|(from, to)| (to - from, 0.5 * (from + to))).collect();
    // The widest first: an order that a mirror does not change.
    sectors.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut found = Vec::new();
    for (width, middle) in sectors {
        // Between the first seeds of both lines; where these stand too near to each other, one in the middle replaces them.
        let span = width - 2.0 * first_pair;
        let directions: Vec<f64> = if 2.0 * radius * (0.5 * span).sin() < LEAST_DISTANCE || span < 0.0 {
            vec![middle]
        } else {
            let gaps = (span / (0.5 * PI)).round().max(1.0);
            (1..gaps as usize).map(|k| middle + span * (k as f64 / gaps - 0.5)).collect()
        };
        let seed = |angle: &f64| {
            let direction = Vec2::new(angle.cos(), angle.sin());
            let width = network.sight(node.place, direction, 2.0);
            offset(width, radius).filter(|_| width > LEAST_WIDTH_AT_NODE).map(|offset| node.place + direction * offset)
        };
        let seeds: Vec<Vec2> = directions.iter().filter_map(seed).collect();
        let are_apart = seeds.windows(2).all(|pair| (pair[1] - pair[0]).norm() >= LEAST_DISTANCE);
        found.extend(if are_apart { seeds } else { seed(&middle).into_iter().collect() });
    }
    found
}

/// The pairs of seeds along a stretch of line: as many as spacings fit, spread evenly from its middle.
fn along(stretch: &Stretch, network: &Network) -> Vec<Vec2> {
    let trace = &network.traces[stretch.line];
    let length = stretch.to - stretch.from;
    let count = length.round();
    let middle = 0.5 * (stretch.from + stretch.to);
    let reach = 0.5 * (length / count.max(1.0)).min(1.0);
    let mut found = Vec::new();
    for k in 0..count as usize {
        let place = middle + length * ((k as f64 + 0.5) / count - 0.5);
        let foot = trace.at(place);
        let chord = trace.at(place + reach) - trace.at(place - reach);
        if network.window.index(square_of(foot)).is_none() || chord.norm() < LEAST_WIDTH {
            continue;
        }
        let normal = chord.perpendicular() / chord.norm();
        for direction in [normal, -normal] {
            let width = network.sight(foot, direction, 2.0);
            found.extend(offset(width, OFFSET).map(|offset| foot + direction * offset));
        }
    }
    found
}
