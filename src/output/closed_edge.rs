//! Water at the closed edge of the terrain: no flood ends there, it stands too high.

use serde::Serialize;

use super::maxima::Maxima;
use crate::math::Vec2;

/// Depth (m) below which water there is not worth a word.
const TOLD_DEPTH: f64 = 0.1;

/// A face between terrain and none that no water passes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ClosedFace {
    /// Its cell.
    pub cell: usize,
    /// Its length (m).
    pub length: f64,
    /// Its middle (map coordinates, m).
    pub middle: Vec2,
}

/// Where the water came to closed edges of the terrain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClosedEdge {
    /// Length of these edges (m).
    pub length_m: f64,
    /// When it first did (s), and where (map coordinates, m).
    pub first_s: f64,
    /// The same.
    pub x: f64,
    /// The same.
    pub y: f64,
    /// Its greatest depth there (m).
    pub deepest_m: f64,
}

impl ClosedEdge {
    /// What a run saw up to a time (s) at its closed faces, by the lowest threshold; nothing where the water came to none of them.
    pub(super) fn seen(faces: &[ClosedFace], maxima: &Maxima, time: f64) -> Option<ClosedEdge> {
        let mut seen: Option<ClosedEdge> = None;
        for &ClosedFace { cell, length, middle } in faces {
            let (depth, arrival) = (maxima.seen(cell).max_depth, maxima.seen_of_threshold(cell, 0, time).arrival);
            if arrival.is_nan() || depth < TOLD_DEPTH {
                continue;
            }
            let here = ClosedEdge { length_m: 0.0, first_s: arrival, x: middle.x, y: middle.y, deepest_m: depth };
            let before = seen.unwrap_or(here);
            let first = if arrival < before.first_s { here } else { before };
            let (length_m, deepest_m) = (before.length_m + length, before.deepest_m.max(depth));
            seen = Some(ClosedEdge { length_m, deepest_m, ..first });
        }
        seen
    }
}
