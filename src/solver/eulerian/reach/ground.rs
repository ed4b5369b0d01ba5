//! The sections of a reach: what a mean depth is as a level, and as a hydraulic radius.

use crate::boundary::{Channel, wetted_perimeter};

/// The strips of all particles and faces; those of particle i stand from i·`strips` on.
pub(super) struct Ground {
    /// Strips of a section.
    pub strips: usize,
    /// Bed (m), counted as in the solver, and width (m) of each strip of each particle.
    pub bed: Vec<f64>,
    pub width: Vec<f64>,
    /// Greatest step of the bed of a strip to the same one of a neighbour (m).
    pub step: Vec<f64>,
    /// Width (m) of each strip of each face.
    pub face_width: Vec<f64>,
    /// Width of the whole section of each particle (m).
    pub whole: Vec<f64>,
    /// g n² (m^(1/3)) of each particle.
    pub friction: Vec<f64>,
    perimeter: Vec<Vec<(f64, f64)>>,
}

impl Ground {
    pub fn new(channel: &Channel, datum: f64, gravity: f64) -> Self {
        let (particles, strips) = (channel.sections.len(), channel.sections[0].strips.len());
        let each = |of: fn(&crate::boundary::Strip) -> f64| -> Vec<f64> {
            channel.sections.iter().flat_map(|section| section.strips.iter().map(of)).collect()
        };
        let bed: Vec<f64> = each(|strip| strip.bed).into_iter().map(|bed| bed - datum).collect();
        let step = (0..bed.len()).map(|at| {
            let (before, after) = (at.checked_sub(strips), Some(at + strips).filter(|&at| at < bed.len()));
            let neighbours = [before, after].into_iter().flatten();
            neighbours.map(|neighbour| (bed[neighbour] - bed[at]).abs()).fold(0.0, f64::max)
        });
        let of_strips = |i: usize| channel.sections[i].strips.iter().map(|strip| strip.width).sum();
        Ground {
            strips,
            step: step.collect(),
            bed,
            width: each(|strip| strip.width),
            face_width: channel.face_widths.iter().flatten().copied().collect(),
            whole: (0..particles).map(of_strips).collect(),
            friction: channel.sections.iter().map(|section| gravity * section.manning * section.manning).collect(),
            perimeter: channel.sections.iter().map(|section| section.perimeter.clone()).collect(),
        }
    }

    /// Takes the cells beyond the near end for neighbours: strips, and the beds (m) that they meet.
    pub fn meet(&mut self, cells: impl Iterator<Item = (usize, f64)>) {
        let last = self.bed.len() - self.strips;
        for (strip, bed) in cells {
            let step = &mut self.step[last + strip];
            *step = step.max((bed - self.bed[last + strip]).abs());
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

    /// Hydraulic radius (m): area by wetted perimeter.
    pub fn radius(&self, particle: usize, mean_depth: f64, level: f64) -> f64 {
        let perimeter = wetted_perimeter(&self.perimeter[particle], level - self.lowest(particle));
        mean_depth * (self.whole[particle] / perimeter)
    }
}
