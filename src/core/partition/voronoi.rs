//! The Voronoi cell of a seed: what is nearer to it than to any other, cut out of a box by the bisectors of its neighbours.
//!
//! ```text
//! cell_i = { x : |x − s_i| <= |x − s_j| for all j }
//! ```
//!
//! Reference: `DuFaberGunzburger1999`, section 1.

use super::seeds::Seeds;
use super::window::square_of;
use crate::math::Vec2;

/// Half the edge of the box from which a cell is cut; no cell is larger.
const BOX: f64 = 4.0;

/// Most rings of squares around a seed that are looked through.
const MOST_RINGS: i64 = 9;

/// What lies nearer than this beyond a bisector is not cut off.
const LEAST_CUT: f64 = 1e-12;

/// The Voronoi cell of a place among seeds, counter-clockwise.
pub fn cell(place: Vec2, seeds: &Seeds) -> Vec<Vec2> {
    let at = |x: f64, y: f64| place + Vec2::new(x, y) * BOX;
    let mut corners = vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)];
    let mut scratch = Vec::new();
    let (column, row) = square_of(place);
    let within = Vec2::new(place.x - column as f64, place.y - row as f64);
    let to_side = within.x.min(1.0 - within.x).min(within.y.min(1.0 - within.y));
    for ring in 0..=MOST_RINGS {
        let farthest = corners.iter().map(|corner| (*corner - place).norm()).fold(0.0, f64::max);
        if ring as f64 - 1.0 + to_side > 2.0 * farthest {
            break;
        }
        for up in -ring..=ring {
            let step = if up.abs() == ring { 1 } else { 2 * ring };
            let mut across = -ring;
            while across <= ring {
                seeds.visit((column + across, row + up), |other| {
                    let way = other - place;
                    if way.norm_squared() > 1e-18 {
                        keep_left(&mut corners, &mut scratch, |corner| {
                            ((corner - place) - way * 0.5).dot(way) / way.norm()
                        });
                    }
                });
                across += step.max(1);
            }
        }
    }
    corners
}

/// Keeps what has a `beyond` below 0 of a convex polygon.
pub fn keep_left(corners: &mut Vec<Vec2>, scratch: &mut Vec<Vec2>, beyond: impl Fn(Vec2) -> f64) {
    if corners.iter().all(|corner| beyond(*corner) <= LEAST_CUT) {
        return;
    }
    scratch.clear();
    for (i, from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        let (a, b) = (beyond(*from), beyond(to));
        if a <= 0.0 {
            scratch.push(*from);
        }
        if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
            scratch.push(between(*from, to, a, b));
        }
    }
    std::mem::swap(corners, scratch);
}

/// Where a quantity that is `a` at one place and `b`, of the other sign, at another is 0.
pub fn between(from: Vec2, to: Vec2, a: f64, b: f64) -> Vec2 {
    // From the end with the smaller value, so that both directions give the same place.
    if a.abs() <= b.abs() { from + (to - from) * (a / (a - b)) } else { to + (from - to) * (b / (b - a)) }
}
