//! What brings water in or takes it out, and where it is measured on its way: open boundaries, sources, rain, cross-sections.

use std::ops::Range;
use std::sync::Arc;

use super::{BedMotion, Breach, Channel, Pieces, Series, Tracer};
use crate::lattice::Lattice;
use crate::math::Vec2;

/// What is known of the water beyond an open boundary.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Condition {
    /// The discharge that comes in (m³/s, not negative), and the level (m) that counts where it comes in faster than waves run.
    Discharge {
        /// All over the boundary (m³/s).
        discharge: Series,
        /// Level above the datum of the terrain (m).
        level: Option<Series>,
    },
    /// The level (m) of still water beyond is held: what comes in stands lower by the head of its velocity.
    Stage(Series),
    /// The level (m) of the water at the boundary itself is held, whether it comes or goes.
    Level(Series),
    /// A wave comes in, and waves leave.
    Wave {
        /// Level of the wave as it would be if it alone were there (m).
        level: Series,
        /// Level without it (m); that of the water at the start where none is given.
        still: Option<Series>,
    },
    /// Uniform flow on a bed of this slope goes on beyond; water leaves only.
    NormalDepth {
        /// Slope (dimensionless, positive).
        slope: f64,
    },
    /// The discharge that leaves is a function of the level at the boundary.
    Rating(Rating),
    /// Waves leave. Where there was water at the start, it goes on beyond at its level and at rest; where the ground was dry, the
    /// flow goes on as it arrives, and nothing comes back.
    Free,
}

impl Condition {
    /// The volume (m³) that comes in until a time (s), where a discharge says it.
    pub fn asked(&self, until: f64) -> Option<f64> {
        match self {
            Condition::Discharge { discharge, .. } => Some(discharge.integral(0.0, until)),
            Condition::Stage(_)
            | Condition::Level(_)
            | Condition::Wave { .. }
            | Condition::NormalDepth { .. }
            | Condition::Rating(_)
            | Condition::Free => None,
        }
    }

    /// Whether water may come in by it onto ground that is dry from the start on.
    pub fn feeds(&self) -> bool {
        match self {
            Condition::Discharge { .. } | Condition::Stage(_) | Condition::Level(_) | Condition::Wave { .. } => true,
            Condition::NormalDepth { .. } | Condition::Rating(_) | Condition::Free => false,
        }
    }
}

/// Discharge as a function of the level: linear between rows, 0 below the first, and beyond the last on as between the last two.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rating {
    rows: Vec<(f64, f64)>,
}

impl Rating {
    /// A table of levels (m, rising) and discharges (m³/s, rising or equal, not negative); none where it is not so, or has less than
    /// two rows.
    pub fn new(rows: &[(f64, f64)]) -> Option<Self> {
        let rises = rows.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 <= pair[1].1);
        let is_sound = rows.len() >= 2 && rises && rows.iter().all(|row| row.0.is_finite() && row.1.is_finite());
        (is_sound && rows[0].1 >= 0.0).then(|| Rating { rows: rows.to_vec() })
    }

    /// The rows: level (m), discharge (m³/s).
    pub fn rows(&self) -> &[(f64, f64)] {
        &self.rows
    }

    /// The discharge (m³/s) at a level (m).
    pub fn discharge(&self, level: f64) -> f64 {
        if level <= self.rows[0].0 {
            return 0.0;
        }
        let upper = self.rows.partition_point(|row| row.0 <= level).clamp(1, self.rows.len() - 1);
        let (low, high) = (self.rows[upper - 1], self.rows[upper]);
        low.1 + (level - low.0) / (high.0 - low.0) * (high.1 - low.1)
    }
}

/// An open part of the edge of the terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// Those of its lines.
    pub pieces: Pieces,
    /// What is known there.
    pub condition: Condition,
}

/// Water that comes out of the ground at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSource {
    /// Local coordinates (m).
    pub place: Vec2,
    /// Discharge (m³/s, not negative).
    pub discharge: Series,
}

/// Water that comes out of the ground along a line.
#[derive(Clone, Debug, PartialEq)]
pub struct LineSource {
    /// Its name in the tables.
    pub name: String,
    /// Cells of the lattice that it crosses, each with its share of the discharge; the shares add up to 1.
    pub cells: Vec<(usize, f64)>,
    /// Discharge of all of it (m³/s, not negative).
    pub discharge: Series,
}

/// Rain that reaches the ground and runs off: losses are taken off already.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Rain {
    /// The same everywhere (m/s).
    Uniform(Series),
    /// Constant at each cell from its own time to a common one.
    Map {
        /// Rate (m/s) at each cell of the lattice.
        rate: Vec<f64>,
        /// Time (s) at each cell from which the rain runs off.
        from: Vec<f64>,
        /// End (s).
        until: f64,
    },
    /// Constant at each place for an interval of time after the other; shared, because it may be large.
    Frames(Arc<RainFrames>),
}

/// Rates that hold for intervals of time, at places that many cells share; see [`Rain`].
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RainFrames {
    /// Place of each cell of the lattice.
    pub place: Vec<u32>,
    /// Time (s) at each place from which the rain runs off.
    pub from: Vec<f64>,
    /// The intervals (s), one after the other without overlap.
    pub intervals: Vec<Range<f64>>,
    /// Rate (m/s) at each place in each interval `[interval][place]`.
    pub rates: Vec<Vec<f64>>,
}

impl RainFrames {
    /// Depth (m) that falls on a place between two times (s).
    pub fn depth(&self, place: usize, from: f64, to: f64) -> f64 {
        let from = from.max(self.from[place]);
        let first = self.intervals.partition_point(|interval| interval.end <= from);
        let pieces =
            self.intervals[first..].iter().zip(&self.rates[first..]).take_while(|(interval, _)| interval.start < to);
        pieces.map(|(one, rates)| rates[place] * (to.min(one.end) - from.max(one.start)).max(0.0)).sum()
    }
}

impl Rain {
    /// Depth (m) that falls on a cell between two times (s).
    pub fn depth(&self, cell: usize, from: f64, to: f64) -> f64 {
        match self {
            Rain::Uniform(series) => series.integral(from, to),
            Rain::Map { rate, from: start, until } => rate[cell] * (to.min(*until) - from.max(start[cell])).max(0.0),
            Rain::Frames(frames) => frames.depth(frames.place[cell] as usize, from, to),
        }
    }
}

/// All of it; nothing by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forcing {
    /// Open boundaries with a condition.
    pub boundaries: Vec<Boundary>,
    /// Distance (m) up to which a line opens a face of the edge.
    pub reach: f64,
    /// Point sources.
    pub sources: Vec<PointSource>,
    /// Line sources.
    pub line_sources: Vec<LineSource>,
    /// Rain.
    pub rain: Option<Rain>,
    /// A dam that breaks.
    pub breach: Option<Breach>,
    /// Parts of the bed that move.
    pub moving_bed: Vec<BedMotion>,
    /// Channels of one dimension.
    pub channels: Vec<Channel>,
    /// Cross-sections: the straight pieces of each in local coordinates (m), from the left to the right bank.
    pub sections: Vec<Vec<[Vec2; 2]>>,
    /// What is carried with the water.
    pub tracers: Vec<Tracer>,
}

impl Forcing {
    /// Whether there is no water that comes or goes by it.
    pub fn is_still(&self) -> bool {
        let has_sources = !self.sources.is_empty() || !self.line_sources.is_empty();
        self.boundaries.is_empty() && !has_sources && self.rain.is_none() && self.channels.is_empty()
    }

    /// The boundary that opens an edge face with this midpoint and normal (local coordinates, m): the nearest one within reach, the earlier
    /// one of two that are equally near. None where a channel joins.
    pub fn boundary_at(&self, midpoint: Vec2, normal: Vec2) -> Option<usize> {
        self.boundary_within(1.0, midpoint, normal)
    }

    /// The same for a face so many times as long as those of the finest level.
    pub fn boundary_within(&self, times: f64, midpoint: Vec2, normal: Vec2) -> Option<usize> {
        if self.channel_joins_at(midpoint) {
            return None;
        }
        let face = (midpoint, normal);
        let distance = |boundary: &Boundary| boundary.pieces.distance_to_face(times * self.reach, face);
        let near = self.boundaries.iter().enumerate().filter_map(|(index, one)| Some((index, distance(one)?)));
        near.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))).map(|(index, _)| index)
    }

    /// Whether an edge face with this midpoint (local coordinates, m) opens into a channel.
    pub fn channel_joins_at(&self, midpoint: Vec2) -> bool {
        self.channels.iter().any(|channel| channel.joins_at(midpoint))
    }
}

/// A face at which terrain meets none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeFace {
    /// The cell with terrain.
    pub cell: usize,
    /// Its midpoint (local coordinates, m).
    pub middle: Vec2,
}

/// The edge faces of a bed (m, NaN without terrain).
pub fn edge_faces(lattice: &Lattice, bed: &[f64]) -> Vec<EdgeFace> {
    let half = 0.5 * lattice.spacing;
    let steps = [Vec2::new(half, 0.0), Vec2::new(-half, 0.0), Vec2::new(0.0, half), Vec2::new(0.0, -half)];
    let cells = (0..lattice.len()).filter(|&cell| !bed[cell].is_nan());
    cells
        .flat_map(|cell| {
            let centre = lattice.centre(cell);
            let is_edge = move |step: &Vec2| lattice.cell_at(centre + *step * 2.0).is_none_or(|n| bed[n].is_nan());
            steps.into_iter().filter(is_edge).map(move |step| EdgeFace { cell, middle: centre + step })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rating_is_linear_between_its_rows() {
        let rating = Rating::new(&[(10.0, 0.0), (11.0, 4.0), (12.0, 10.0)]).unwrap();
        for (level, discharge) in [(9.0, 0.0), (10.5, 2.0), (11.5, 7.0), (13.0, 16.0)] {
            assert!((rating.discharge(level) - discharge).abs() < 1e-12, "{level}");
        }
        assert_eq!(Rating::new(&[(10.0, 0.0), (10.0, 4.0)]), None);
        assert_eq!(Rating::new(&[(10.0, 3.0), (11.0, 2.0)]), None);
    }

    #[test]
    fn rain_from_a_map_falls_between_its_times() {
        let rain = Rain::Map { rate: vec![2.0, 1.0], from: vec![0.0, 5.0], until: 8.0 };
        assert!((rain.depth(0, 1.0, 3.0) - 4.0).abs() < 1e-15 && rain.depth(1, 1.0, 3.0).abs() <= 0.0);
        assert!((rain.depth(1, 4.0, 10.0) - 3.0).abs() < 1e-15);
    }

    #[test]
    fn rain_of_frames_adds_up_over_any_steps() {
        let frames = RainFrames {
            place: vec![0, 1, 1],
            from: vec![0.0, 7.0],
            intervals: vec![-5.0..5.0, 5.0..10.0, 12.0..20.0],
            rates: vec![vec![1.0, 4.0], vec![2.0, 3.0], vec![0.5, 0.25]],
        };
        let rain = Rain::Frames(Arc::new(frames));
        let whole = [5.0 + 10.0 + 4.0, 9.0 + 2.0, 9.0 + 2.0];
        for (cell, expected) in whole.into_iter().enumerate() {
            let steps = [0.0, 0.3, 4.9, 6.1, 6.9, 11.0, 11.5, 19.0, 30.0];
            let sum: f64 = steps.windows(2).map(|pair| rain.depth(cell, pair[0], pair[1])).sum();
            assert!((sum - expected).abs() < 1e-14 && (rain.depth(cell, 0.0, 99.0) - expected).abs() < 1e-14, "{sum}");
        }
    }

    #[test]
    fn a_face_belongs_to_the_nearest_boundary() {
        let line = |x: f64| Boundary {
            pieces: vec![[Vec2::new(x, 0.0), Vec2::new(x, 10.0)]].into(),
            condition: Condition::NormalDepth { slope: 0.1 },
        };
        let east = Vec2::new(1.0, 0.0);
        let forcing = Forcing { boundaries: vec![line(0.0), line(3.0)], reach: 2.0, ..Forcing::default() };
        assert_eq!(forcing.boundary_at(Vec2::new(1.4, 5.0), east), Some(0));
        assert_eq!(forcing.boundary_at(Vec2::new(1.6, 5.0), east), Some(1));
        assert_eq!(forcing.boundary_at(Vec2::new(5.5, 5.0), east), None);
        // A face around the corner at the end of a line.
        let north = Vec2::new(0.0, 1.0);
        assert_eq!(forcing.boundary_at(Vec2::new(0.5, 10.0), north), None);
        assert_eq!(forcing.boundary_at(Vec2::new(0.5, 10.0), Vec2::new(0.2, 1.0)), Some(0));
    }

    #[test]
    fn a_line_opens_the_faces_beside_it_and_none_beyond_its_ends() {
        // Two pieces that meet at an angle, from 20 to 50 m; faces of 10 m, whose midpoints lie at 5 m, 15 m, ...
        let corner = Vec2::new(1.0, 33.0);
        let pieces = vec![[Vec2::new(0.0, 20.0), corner], [corner, Vec2::new(0.0, 50.0)]];
        let boundary = Boundary { pieces: pieces.into(), condition: Condition::Free };
        let forcing = Forcing { boundaries: vec![boundary], reach: 15.0, ..Forcing::default() };
        let is_open = |y: f64| forcing.boundary_at(Vec2::new(0.0, y), Vec2::new(1.0, 0.0)).is_some();
        assert_eq!(
            [5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0].map(is_open),
            [false, false, true, true, true, false, false]
        );
    }

    #[test]
    fn edges_are_faces_between_terrain_and_none() {
        let lattice = Lattice::new(Vec2::ZERO, 3, 3, 2.0);
        let mut bed = vec![0.0; 9];
        bed[4] = f64::NAN;
        let faces = edge_faces(&lattice, &bed);
        assert_eq!(faces.len(), 12 + 4);
        assert!(faces.contains(&EdgeFace { cell: 3, middle: Vec2::new(2.0, 3.0) }));
    }
}
