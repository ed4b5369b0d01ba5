//! Which places lie inside outlines: where all of them together wind around it. A ring that runs the other way inside of one is a courtyard.

use super::LineKind;
use super::lines::{Network, bounds};
use crate::math::Vec2;

/// The segments of outlines, row by row.
pub struct Outlines<'a> {
    network: &'a Network,
    rows: Vec<Vec<u32>>,
    /// The box around each line.
    boxes: Vec<(Vec2, Vec2)>,
}

impl<'a> Outlines<'a> {
    /// The outlines among the lines.
    pub fn new(network: &'a Network) -> Self {
        let mut rows = vec![Vec::new(); network.window.row_count()];
        for (number, segment) in network.segments.iter().enumerate() {
            let is_ring = network.kinds[segment.line] == LineKind::Outline && network.traces[segment.line].is_closed;
            if is_ring {
                let [a, b] = segment.ends.map(|end| network.window.row_of(end.y));
                rows[a.min(b)..=a.max(b)].iter_mut().for_each(|row| row.push(number as u32));
            }
        }
        let boxes = network.traces.iter().map(|trace| bounds(&trace.points)).collect();
        Outlines { network, rows, boxes }
    }

    /// Whether a place lies inside outlines.
    pub fn hold(&self, place: Vec2) -> bool {
        let row = &self.rows[self.network.window.row_of(place.y)];
        let is_east = |number: &&u32| self.boxes[self.network.segments[**number as usize].line].1.x > place.x;
        let turns = |number: &u32| self.crossing(*number, place.y).filter(|(x, _)| *x > place.x).map(|(_, turn)| turn);
        row.iter().filter(is_east).filter_map(turns).sum::<i32>() != 0
    }

    /// Calls for each stretch of a line due east at a height that lies inside outlines: from and to.
    pub fn stretches(&self, y: f64, mut call: impl FnMut(f64, f64)) {
        let mut crossings = self.crossings(y);
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut winding, mut since) = (0, None);
        for (x, turn) in crossings {
            winding += turn;
            match since {
                None => since = Some(x),
                Some(from) if winding == 0 => {
                    call(from, x);
                    since = None;
                }
                Some(_) => {}
            }
        }
    }

    /// Where rings cross a height.
    fn crossings(&self, y: f64) -> Vec<(f64, i32)> {
        self.rows[self.network.window.row_of(y)].iter().filter_map(|number| self.crossing(*number, y)).collect()
    }

    /// Where a segment crosses a height, and 1 where it does so northward, -1 southward.
    fn crossing(&self, number: u32, y: f64) -> Option<(f64, i32)> {
        let segment = &self.network.segments[number as usize];
        let [a, b] = segment.ends;
        if (a.y > y) == (b.y > y) {
            return None;
        }
        let x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
        Some((x, if b.y > y { 1 } else { -1 }))
    }
}
