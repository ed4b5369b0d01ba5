//! The lines in units of the spacing, and which of their segments are near a place.

use super::segment::Segment;
use super::window::{Square, Window, square_of};
use super::{Line, LineKind, TOLERANCE};
use crate::math::{Rectangle, Vec2};

/// How much (spacings) a square is widened where segments are sorted into squares.
const SLACK: f64 = 1e-6;

/// Length of the pieces (spacings) in which a segment is sorted into squares.
const STRIDE: f64 = 0.5;

/// A line without repeated points.
pub struct Trace {
    /// The points; of a ring the first one once more at the end.
    pub points: Vec<Vec2>,
    /// Length of the line up to each point.
    pub lengths: Vec<f64>,
    /// Whether it is a ring.
    pub is_closed: bool,
    /// The number of its first segment; the others follow.
    pub first_segment: usize,
}

impl Trace {
    fn new(line: &Line, spacing: f64, first_segment: usize) -> Self {
        let mut points: Vec<Vec2> = Vec::new();
        for point in line.points.iter().map(|point| *point / spacing) {
            if points.last().is_none_or(|last| (*last - point).norm() > TOLERANCE) {
                points.push(point);
            }
        }
        while points.len() > 1 && (points[0] - points[points.len() - 1]).norm() <= TOLERANCE {
            points.pop();
        }
        let is_drawn_shut = points.len() > 2 && line.points.first() == line.points.last();
        let is_closed = points.len() > 2 && (line.is_closed || is_drawn_shut || line.kind == LineKind::Outline);
        if is_closed {
            points.push(points[0]);
        }
        let mut lengths = vec![0.0; points.len()];
        for i in 1..points.len() {
            lengths[i] = lengths[i - 1] + (points[i] - points[i - 1]).norm();
        }
        Trace { points, lengths, is_closed, first_segment }
    }

    /// Number of segments.
    pub fn segment_count(&self) -> usize {
        self.points.len().saturating_sub(1)
    }

    /// Length of the line.
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// The place at a length along the line; of a ring lengths go on around.
    pub fn at(&self, length: f64) -> Vec2 {
        let length = if self.is_closed { length.rem_euclid(self.length()) } else { length };
        let after = self.lengths.partition_point(|end| *end <= length).clamp(1, self.points.len() - 1);
        let (from, to) = (self.points[after - 1], self.points[after]);
        let share = ((length - self.lengths[after - 1]) / (self.lengths[after] - self.lengths[after - 1])).min(1.0);
        from + (to - from) * share
    }
}

/// All lines.
pub struct Network {
    /// The squares that have lists.
    pub window: Window,
    /// The lines, in the order of the input.
    pub traces: Vec<Trace>,
    /// The kind of each line.
    pub kinds: Vec<LineKind>,
    /// Their segments.
    pub segments: Vec<Segment>,
    starts: Vec<u32>,
    touching: Vec<u32>,
}

impl Network {
    /// The network of some lines on a lattice.
    pub fn new(window: Window, lines: &[Line], spacing: f64) -> Self {
        let (mut traces, mut segments) = (Vec::new(), Vec::new());
        for (line, drawn) in lines.iter().enumerate() {
            let trace = Trace::new(drawn, spacing, segments.len());
            segments.extend(trace.points.windows(2).map(|ends| Segment { ends: [ends[0], ends[1]], line }));
            traces.push(trace);
        }
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (number, segment) in segments.iter().enumerate() {
            squares_along(segment, &window, |index| pairs.push((index as u32, number as u32)));
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut starts = vec![0; window.len() + 1];
        for (square, _) in &pairs {
            starts[*square as usize + 1] += 1;
        }
        for square in 0..window.len() {
            starts[square + 1] += starts[square];
        }
        let touching = pairs.into_iter().map(|(_, segment)| segment).collect();
        let kinds = lines.iter().map(|line| line.kind).collect();
        Network { window, traces, kinds, segments, starts, touching }
    }

    /// The segments that touch a square (and some that nearly do).
    #[inline]
    pub fn of_square(&self, square: Square) -> &[u32] {
        let Some(index) = self.window.index(square) else { return &[] };
        &self.touching[self.starts[index] as usize..self.starts[index + 1] as usize]
    }

    /// The squares that segments touch, in ascending order.
    pub fn touched_squares(&self) -> impl Iterator<Item = Square> + '_ {
        (0..self.window.len()).filter(|i| self.starts[*i] < self.starts[i + 1]).map(|i| self.window.square(i))
    }

    /// The segments that touch a box, in ascending order.
    pub fn near(&self, low: Vec2, high: Vec2, found: &mut Vec<u32>) {
        found.clear();
        for square in self.window.squares(low, high) {
            found.extend(self.of_square(square));
        }
        found.sort_unstable();
        found.dedup();
    }

    /// The segments that touch a place or nearly so: half a tolerance of sorting is far more than rounding.
    pub fn at(&self, place: Vec2) -> &[u32] {
        self.of_square(square_of(place))
    }

    /// Distance of a place from the nearest line; at least 1 where none is nearer than 1.
    pub fn distance(&self, place: Vec2) -> f64 {
        let reach = Vec2::new(1.0, 1.0);
        let squares = self.window.squares(place - reach, place + reach);
        let segments = squares.flat_map(|square| self.of_square(square));
        segments.map(|s| self.segments[*s as usize].distance(place)).fold(f64::INFINITY, f64::min)
    }

    /// Whether a line passes between two places, up to about two spacings apart.
    pub fn is_parted(&self, a: Vec2, b: Vec2) -> bool {
        let way = Segment { ends: [a, b], line: 0 };
        let (low, high) = bounds(&[a, b]);
        let mut squares = self.window.squares(low, high).flat_map(|square| self.of_square(square));
        squares.any(|segment| way.touches(&self.segments[*segment as usize], TOLERANCE))
    }

    /// How far one sees from a place on a line: the distance to the first line in a direction, `reach` at most.
    pub fn sight(&self, from: Vec2, direction: Vec2, reach: f64) -> f64 {
        let way = Segment { ends: [from, from + direction * reach], line: 0 };
        let (low, high) = bounds(&way.ends);
        let mut nearest = reach;
        for segment in self.window.squares(low, high).flat_map(|square| self.of_square(square)) {
            let segment = &self.segments[*segment as usize];
            let slack = TOLERANCE / segment.along().norm();
            match way.crossing(segment) {
                Some((t, u)) if (-slack..=1.0 + slack).contains(&u) && t * reach > SLACK => {
                    nearest = nearest.min(t * reach);
                }
                None if segment.distance(from) > SLACK => {
                    let meetings = way.meetings(segment, TOLERANCE);
                    nearest = meetings.into_iter().map(|place| (place - from).norm()).fold(nearest, f64::min);
                }
                _ => {}
            }
        }
        nearest
    }
}

/// South-western and north-eastern corner of the box around some places.
pub fn bounds(places: &[Vec2]) -> (Vec2, Vec2) {
    let Rectangle { low, high } = Rectangle::about(places.iter().copied()).unwrap_or(Rectangle::NOWHERE);
    (low, high)
}

/// Calls for the index of each square that a segment touches, and of some beside it.
fn squares_along(segment: &Segment, window: &Window, mut call: impl FnMut(usize)) {
    let [low, high] = window.corners();
    let Some((from, to)) = (Rectangle { low, high }).share_of(segment.ends) else { return };
    let (start, along) = (segment.ends[0], segment.along());
    let pieces = ((to - from) * along.norm() / STRIDE).ceil().max(1.0);
    let slack = Vec2::new(SLACK, SLACK);
    for piece in 0..pieces as usize {
        let at = |piece: usize| start + along * (from + (to - from) * piece as f64 / pieces);
        let (low, high) = bounds(&[at(piece), at(piece + 1)]);
        window.squares(low - slack, high + slack).filter_map(|square| window.index(square)).for_each(&mut call);
    }
}
