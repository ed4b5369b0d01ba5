//! The ends of a reach: walls, and open ones beyond which something is known, by the conditions of [`super::super::open`].

use super::super::faces::HALF_WAY;
use super::super::open::{Exchange, Faces, Inside, Near, Of, Passing, pass};
use super::super::walls::mirrored;
use super::super::{EulerianMethods, Scale};
use super::junction::Junction;
use super::{Face, Reach, larger_or_nan};
use crate::boundary::Condition;
use crate::methods::Reconstruction;

/// An end beyond which something is known.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct OpenEnd {
    condition: Condition,
    /// Level at rest (m), counted as in the solver, where there was water at the start.
    rest: Option<f64>,
    inside: Vec<Inside>,
    passing: Vec<Passing>,
}

/// What lies beyond an end.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) enum End {
    Wall,
    Open(OpenEnd),
    Joined(Junction),
}

impl End {
    /// What is known beyond it.
    pub fn condition(&self) -> Option<&Condition> {
        match self {
            End::Open(open) => Some(&open.condition),
            End::Wall | End::Joined(_) => None,
        }
    }
}

impl OpenEnd {
    /// An end with room for so many strips; `rest` is the level at rest (m), where there is water.
    pub fn new(condition: Condition, rest: Option<f64>, strips: usize) -> Self {
        OpenEnd { condition, rest, inside: Vec::with_capacity(strips), passing: Vec::with_capacity(strips) }
    }
}

impl Reach {
    /// Fluxes of the ends that join nothing, in a step from one time to another (s).
    pub(super) fn pass_ends(&mut self, scale: &Scale, methods: EulerianMethods, step: (f64, f64)) {
        let (strips, last) = (self.ground.strips, self.water.len() - 1);
        for (end, sign) in [(0, -1.0), (1, 1.0)] {
            self.look(end, scale, methods);
            let face = match &mut self.ends[end] {
                End::Open(open) => {
                    let how = (step, Of::Mean);
                    pass(
                        &open.condition,
                        (Faces::OfASection, &open.inside),
                        (scale, self.datum),
                        how,
                        &mut open.passing,
                    );
                    let mut face = Face::default();
                    let at = if end == 0 { 0 } else { (last + 1) * strips };
                    let widths = &self.ground.face_width[at..at + strips];
                    for ((inside, passing), wide) in open.inside.iter().zip(&open.passing).zip(widths) {
                        let momentum = wide * inside.momentum_lost(passing, scale.gravity);
                        face.volume += sign * wide * passing.mass;
                        (face.lost, face.gained) = (face.lost + momentum, face.gained + momentum);
                    }
                    face
                }
                End::Wall => self.wall(end, sign, scale.gravity),
                End::Joined(_) => Face::default(),
            };
            self.faces[end * (last + 1)] = face;
        }
    }

    /// The mirror problem of a particle at an end.
    fn wall(&self, end: usize, sign: f64, gravity: f64) -> Face {
        let strips = self.ground.strips;
        let particle = if end == 0 { 0 } else { self.water.len() - 1 };
        let at = end * self.water.len() * strips;
        let momentum: f64 = (0..strips)
            .map(|k| {
                let (depth, _, velocity) = self.strip(particle, k);
                self.ground.face_width[at + k] * mirrored(depth, sign * velocity, gravity)
            })
            .sum();
        Face { volume: 0.0, lost: momentum, gained: momentum }
    }

    /// Reads the water before an open end.
    fn look(&mut self, end: usize, scale: &Scale, methods: EulerianMethods) {
        let End::Open(OpenEnd { rest, inside: found, .. }) = &mut self.ends[end] else { return };
        let (rest, mut found) = (*rest, std::mem::take(found));
        let is_carried = methods.reconstruction != Reconstruction::None;
        let (strips, count) = (self.ground.strips, self.water.len());
        let sign = if end == 0 { -1.0 } else { 1.0 };
        let inwards =
            |steps: usize| if end == 0 { Some(steps).filter(|&i| i < count) } else { (count - 1).checked_sub(steps) };
        let here = if end == 0 { 0 } else { count - 1 };
        let water = self.primitive[here];
        let radius = self.ground.radius(here, water.depth, water.level);
        // The conditions know depths alone: a strip gets the roughness that slows its depth as the whole section is slowed.
        let by_shape = |depth: f64| if radius > 0.0 { (depth / radius).powf(4.0 / 3.0) } else { 1.0 };
        let near = |particle: usize, k: usize| {
            let (depth, bed, velocity) = self.strip(particle, k);
            Near { depth, bed, outwards: sign * velocity, along: 0.0 }
        };
        let inside = |k: usize| {
            let behind = [inwards(1), inwards(2)].map(|place| place.filter(|_| is_carried).map(|i| near(i, k)));
            let width = self.ground.face_width[end * count * strips + k] / scale.spacing;
            let before = near(here, k);
            let friction = by_shape(before.depth) * self.ground.friction[here];
            Inside::before(before, behind, HALF_WAY, scale).with(width, friction, rest)
        };
        found.clear();
        found.extend((0..strips).map(inside));
        if let End::Open(open) = &mut self.ends[end] {
            open.inside = found;
        }
    }

    /// The greatest signal speed (m/s) of what comes in by the ends in a step from one time to another (s).
    pub(super) fn fastest_inflow(&mut self, scale: &Scale, methods: EulerianMethods, step: (f64, f64)) -> f64 {
        let mut fastest = 0.0;
        for end in [0, 1] {
            self.look(end, scale, methods);
            if let End::Open(open) = &mut self.ends[end] {
                pass(
                    &open.condition,
                    (Faces::OfASection, &open.inside),
                    (scale, self.datum),
                    (step, Of::Largest),
                    &mut open.passing,
                );
                fastest = open.passing.iter().map(|passing| passing.speed).fold(fastest, larger_or_nan);
            }
        }
        fastest
    }

    /// Rates at which water comes in and leaves by the open ends (m³/s); each end counts its own over so many seconds.
    pub(super) fn book(&mut self, seconds: f64) -> Exchange {
        let outwards = |end: usize| match (&self.ends[end], end) {
            (End::Open(_), 0) => -self.faces[0].volume,
            (End::Open(_), _) => self.faces[self.water.len()].volume,
            (End::Wall | End::Joined(_), _) => 0.0,
        };
        let both = [outwards(0), outwards(1)];
        for (booked, outwards) in self.booked.iter_mut().zip(both) {
            booked.inflow += seconds * (-outwards).max(0.0);
            booked.outflow += seconds * outwards.max(0.0);
        }
        Exchange {
            inflow: both.iter().map(|rate| (-rate).max(0.0)).sum(),
            outflow: both.iter().map(|rate| rate.max(0.0)).sum(),
        }
    }
}
