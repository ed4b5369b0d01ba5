//! The sections of a reach: what a mean depth is as a level, and as a hydraulic radius; their strips as rows of the plane.

use super::super::state::{FaceRow, GradientRow, GroundRow, PrimitiveRow};
use crate::boundary::{Channel, ChannelSection, wetted_perimeter};

/// The strips of all particles and faces; those of particle i stand from i·`strips` on.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Ground {
    /// Strips of a section.
    pub strips: usize,
    /// Bed (m), counted as in the solver, and width (m) of each strip of each particle.
    pub bed: Vec<f64>,
    pub width: Vec<f64>,
    /// Width (m) of each strip of each face.
    pub face_width: Vec<f64>,
    /// Width of the whole section of each particle (m).
    pub whole: Vec<f64>,
    /// How much wider the widest face of each particle is than the particle, at least 1.
    pub widening: Vec<f64>,
    /// g n² (m^(1/3)) of each particle.
    pub friction: Vec<f64>,
    perimeter: Vec<Vec<(f64, f64)>>,
    banks: Vec<Vec<Bank>>,
}

/// Where a section parts into the channel below and plains beside it.
#[derive(serde::Serialize, serde::Deserialize)]
struct Bank {
    /// Depth above the lowest strip (m), and wetted perimeter of what lies below (m).
    depth: f64,
    perimeter: f64,
    /// The first strip of the plains.
    strip: usize,
}

impl Ground {
    pub fn new(channel: &Channel, datum: f64, gravity: f64) -> Self {
        let (particles, strips) = (channel.sections.len(), channel.sections[0].strips.len());
        let each = |of: fn(&crate::boundary::Strip) -> f64| -> Vec<f64> {
            channel.sections.iter().flat_map(|section| section.strips.iter().map(of)).collect()
        };
        let bed: Vec<f64> = each(|strip| strip.bed).into_iter().map(|bed| bed - datum).collect();
        let of_face = |f: usize| channel.face_widths[f].iter().sum::<f64>();
        let of_strips = |i: usize| channel.sections[i].strips.iter().map(|strip| strip.width).sum::<f64>();
        Ground {
            strips,
            bed,
            width: each(|strip| strip.width),
            face_width: channel.face_widths.iter().flatten().copied().collect(),
            widening: (0..particles).map(|i| (of_face(i).max(of_face(i + 1)) / of_strips(i)).max(1.0)).collect(),
            whole: (0..particles).map(of_strips).collect(),
            friction: channel.sections.iter().map(|section| gravity * section.manning * section.manning).collect(),
            perimeter: channel.sections.iter().map(|section| section.perimeter.clone()).collect(),
            banks: channel.sections.iter().map(banks).collect(),
        }
    }

    /// The bed of a strip as that of a row of the plane, with its greatest steps to the neighbours.
    pub fn row(&self, strip: usize) -> GroundRow {
        let bed: Vec<f64> = self.bed.iter().skip(strip).step_by(self.strips).copied().collect();
        let step = |i: usize| {
            let neighbours = [i.checked_sub(1), Some(i + 1)].into_iter().flatten().filter_map(|j| bed.get(j));
            neighbours.map(|neighbour| (neighbour - bed[i]).abs()).fold(0.0, f64::max)
        };
        GroundRow {
            step: (0..bed.len()).map(step).collect(),
            friction: vec![0.0; bed.len()],
            per_area: vec![1.0; bed.len()],
            bed,
        }
    }

    /// Number of particles.
    pub fn particles(&self) -> usize {
        self.whole.len()
    }

    /// Elevation of the lowest strip of a particle (m).
    pub fn lowest(&self, particle: usize) -> f64 {
        self.bed[particle * self.strips]
    }

    /// The level (m) at which the water of a particle has a mean depth (m), that is area by width of the whole section.
    pub fn level(&self, particle: usize, mean_depth: f64) -> f64 {
        let at = particle * self.strips;
        let (bed, width) = (&self.bed[at..at + self.strips], &self.width[at..at + self.strips]);
        if self.strips == 1 {
            return bed[0] + mean_depth;
        }
        let (mut left, mut wide) = (mean_depth * self.whole[particle], width[0]);
        let mut filled = 0;
        while filled + 1 < self.strips {
            let room = wide * (bed[filled + 1] - bed[filled]);
            if left <= room {
                break;
            }
            left -= room;
            filled += 1;
            wide += width[filled];
        }
        // The bottom of a section may be an edge without width.
        if wide > 0.0 { bed[filled] + left / wide } else { bed[filled] }
    }

    /// The mean depth (m) of a particle at a level (m).
    pub fn mean_depth(&self, particle: usize, level: f64) -> f64 {
        let at = particle * self.strips;
        let strips = self.bed[at..at + self.strips].iter().zip(&self.width[at..at + self.strips]);
        if self.strips == 1 {
            return (level - self.bed[at]).max(0.0);
        }
        strips.map(|(bed, width)| width * (level - bed).max(0.0)).sum::<f64>() / self.whole[particle]
    }

    /// Depth (m) of a strip of a particle whose water has a mean depth and a level (m).
    pub fn strip_depth(&self, particle: usize, strip: usize, mean_depth: f64, level: f64) -> f64 {
        if self.strips == 1 { mean_depth } else { (level - self.bed[particle * self.strips + strip]).max(0.0) }
    }

    /// Hydraulic radius (m): area by wetted perimeter, and over banks that which carries what the parts carry (M53).
    pub fn radius(&self, particle: usize, mean_depth: f64, level: f64) -> f64 {
        let depth = level - self.lowest(particle);
        let perimeter = wetted_perimeter(&self.perimeter[particle], depth);
        let banks = &self.banks[particle];
        let covered = &banks[..banks.partition_point(|bank| bank.depth < depth)];
        if covered.is_empty() {
            return mean_depth * (self.whole[particle] / perimeter);
        }
        let at = particle * self.strips;
        let area_of = |from: usize, to: usize| -> f64 {
            let strips = self.bed[at + from..at + to].iter().zip(&self.width[at + from..at + to]);
            strips.map(|(bed, width)| width * (level - bed).max(0.0)).sum()
        };
        let ends = covered.iter().map(|bank| (bank.strip, bank.perimeter)).chain([(self.strips, perimeter)]);
        let (mut begin, mut carried) = ((0, 0.0), 0.0);
        for end in ends {
            let (area, wetted) = (area_of(begin.0, end.0), end.1 - begin.1);
            if wetted > 0.0 {
                carried += area * (area / wetted).powf(2.0 / 3.0);
            }
            begin = end;
        }
        (carried / (mean_depth * self.whole[particle])).powf(1.5)
    }
}

/// The rows of a section above which it would carry less the higher the water stands, by the radius of all of it:
/// d(A R^(2/3))/dη < 0, that is 5 T P < 2 A dP/dη, with A, P and the width T of what lies between the bank before and the row.
fn banks(section: &ChannelSection) -> Vec<Bank> {
    /// Far above the rounding of elevations, far below the height of a strip (m).
    const TOUCH: f64 = 1e-6;
    let lowest = section.strips[0].bed;
    let mut banks: Vec<Bank> = Vec::new();
    for rows in section.perimeter.windows(2) {
        let ((depth, perimeter), (next, longer)) = (rows[0], rows[1]);
        let (first, below) = banks.last().map_or((0, 0.0), |bank| (bank.strip, bank.perimeter));
        let strip = section.strips.partition_point(|strip| strip.bed - lowest < depth - TOUCH);
        let part = &section.strips[first.min(strip)..strip];
        let width: f64 = part.iter().map(|strip| strip.width).sum();
        let area: f64 = part.iter().map(|strip| strip.width * (depth + lowest - strip.bed)).sum();
        if 5.0 * width * (perimeter - below) * (next - depth) < 2.0 * area * (longer - perimeter) {
            banks.push(Bank { depth, perimeter, strip });
        }
    }
    banks
}

/// One strip of all particles, as a row of the plane: what the pairs see, and what passes between the particles.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct StripRow {
    pub ground: GroundRow,
    pub water: PrimitiveRow,
    pub slope: GradientRow,
    pub flux: FaceRow,
}

impl StripRow {
    /// A row without water on a bed.
    pub fn new(ground: GroundRow) -> Self {
        let len = ground.bed.len();
        StripRow {
            water: PrimitiveRow::dry(len),
            slope: GradientRow::level(len),
            flux: FaceRow::without_flow(len),
            ground,
        }
    }
}
