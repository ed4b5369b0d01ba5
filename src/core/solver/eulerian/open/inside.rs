//! The water at a face of a boundary, and what passes there into a state beyond.

use crate::math::{clamp, smaller};
use crate::physics::limiter::van_leer;
use crate::physics::open_boundary::{EdgeState, at_depth, overfall, wave_enters};
use crate::solver::eulerian::Scale;
use crate::solver::eulerian::faces::through_face;
use crate::solver::eulerian::gradient::surface_difference;

/// A particle near a face: its depth (m), bed (m) and velocity outwards and along the face (m/s).
#[derive(Clone, Copy, Debug)]
pub(in crate::solver::eulerian) struct Near {
    pub depth: f64,
    pub bed: f64,
    pub outwards: f64,
    pub along: f64,
}

/// What is known at a face.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(in crate::solver::eulerian) struct Inside {
    /// Depth of the particle (m) and at the face; level at the face less that of the particle.
    pub(super) depth: f64,
    pub(super) face: EdgeState,
    pub(super) rise: f64,
    /// Elevation of the bed at the face and at the particle (m), counted as in the solver.
    pub(super) sill: f64,
    pub(super) bed: f64,
    /// g n² (m^(1/3)).
    pub(super) friction: f64,
    pub(super) invariant: f64,
    pub(super) is_wet: bool,
    /// Level (m) of the water at the start, counted as in the solver; none where it was dry.
    pub(super) rest: Option<f64>,
    /// Width of the face in spacings.
    pub(super) width: f64,
    /// The way that the edge faces: its part across the face, cos θ, and along it.
    pub(super) facing: (f64, f64),
    /// Velocity along the face (m/s).
    pub(super) along: f64,
}

/// What passes a face, outwards, the signal speed there, and the state beyond; none where the face is as a wall.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(in crate::solver::eulerian) struct Passing {
    pub mass: f64,
    pub momentum: f64,
    pub speed: f64,
    pub beyond: Option<EdgeState>,
}

impl Inside {
    /// The water at a face of one spacing, which lies at a `reach` (spacings) before a particle, and behind it are up to two others.
    pub(in crate::solver::eulerian) fn before(
        here: Near,
        behind: [Option<Near>; 2],
        reach: f64,
        scale: &Scale,
    ) -> Self {
        let Near { depth, bed, outwards, along } = here;
        let is_wet = depth > scale.dry_depth;
        let dry = Inside {
            depth,
            face: EdgeState { depth: 0.0, outwards: 0.0 },
            rise: 0.0,
            sill: bed,
            bed,
            friction: 0.0,
            invariant: 0.0,
            is_wet,
            rest: None,
            width: 1.0,
            facing: (1.0, 0.0),
            along,
        };
        if !is_wet {
            return dry;
        }
        let [behind, further] = behind.map(|near| near.filter(|near| near.depth > scale.dry_depth));
        let (rise, rise_d, rise_u) = match (behind, further) {
            (None, _) => (0.0, 0.0, 0.0),
            (Some(b), further) => {
                let jump_of = |from: Near, to: Near| {
                    let levels = surface_difference((from.depth, from.bed), (to.depth, to.bed), scale.dry_depth);
                    (levels, to.depth - from.depth, to.outwards - from.outwards)
                };
                let jump = jump_of(b, here);
                let before = further.map_or(jump, |f| jump_of(f, b));
                let over = |a: f64, b: f64| reach * van_leer(a, b);
                (over(jump.0, before.0), over(jump.1, before.1), over(jump.2, before.2))
            }
        };
        let at_face = (depth + rise_d).clamp(0.0, 2.0 * depth);
        let face = EdgeState { depth: at_face, outwards: outwards + rise_u };
        let sill = bed + (depth - at_face) + rise;
        Inside { face, rise, sill, invariant: face.invariant(scale.gravity), ..dry }
    }

    /// The same face with another width (spacings), roughness g n² (m^(1/3)) and level at rest (m).
    pub(in crate::solver::eulerian) fn with(self, width: f64, friction: f64, rest: Option<f64>) -> Self {
        Inside { width, friction, rest, ..self }
    }

    /// Normal momentum (m³/s²) that the particle before the face loses, beyond the pressure of still water.
    pub(in crate::solver::eulerian) fn momentum_lost(&self, passing: &Passing, g: f64) -> f64 {
        let at_face = self.face.depth;
        passing.momentum - 0.5 * g * at_face * at_face + 0.5 * g * (self.depth + at_face) * self.rise
    }

    /// What passes between the water before the face and a state beyond it.
    pub(super) fn between(&self, beyond: EdgeState, g: f64) -> Passing {
        let face = self.face;
        let (mass, momentum) = through_face(face.depth, face.outwards, beyond.depth, beyond.outwards, g);
        Passing { mass, momentum, ..Passing::of(beyond, g) }
    }

    /// The same where nothing may come in.
    pub(super) fn leaving(&self, beyond: impl FnOnce() -> EdgeState, g: f64) -> Passing {
        if !self.is_wet || self.invariant <= 0.0 {
            return self.closed(g);
        }
        let passing = self.between(beyond(), g);
        if passing.mass > 0.0 { passing } else { self.closed(g) }
    }

    /// What passes where the flow goes on as it arrives, outwards only.
    pub(super) fn going_on(&self, g: f64) -> Passing {
        if self.is_wet && self.face.outwards > 0.0 { Passing::of(self.face, g) } else { self.closed(g) }
    }

    /// Depth (m) at the face under a level (m).
    pub(super) fn depth_at(&self, level: f64) -> f64 {
        (level - self.sill).max(0.0)
    }

    /// What passes where a level (m) is held; water that comes in pays for a share of the head of its velocity.
    pub(super) fn held(&self, level: f64, paid: f64, scale: &Scale) -> Passing {
        let (held, how, g) = (self.depth_at(level), (self.facing.0, paid), scale.gravity);
        if self.is_wet {
            self.between(at_depth(held, how, self.invariant, g), g)
        } else if held > scale.dry_depth {
            Passing::of(at_depth(held, how, 0.0, g), g)
        } else {
            self.closed(g)
        }
    }

    /// What passes where a wave of a level (m) comes in over still water of another one, that of the start where none is given.
    pub(super) fn with_wave(&self, wave: f64, still: Option<f64>, scale: &Scale) -> Passing {
        let g = scale.gravity;
        let depths = (self.depth_at(wave), still.or(self.rest).map_or(0.0, |level| self.depth_at(level)));
        let state = || wave_enters(depths, self.facing, (self.face, if self.is_wet { self.along } else { 0.0 }), g);
        if depths.0.max(depths.1) <= scale.dry_depth {
            self.going_on(g)
        } else if self.is_wet {
            self.between(state(), g)
        } else if depths.0 > scale.dry_depth {
            Passing::of(state(), g)
        } else {
            self.closed(g)
        }
    }

    /// The face as a wall.
    pub(super) fn closed(&self, g: f64) -> Passing {
        let face = self.face;
        let momentum = through_face(face.depth, face.outwards, face.depth, -face.outwards, g).1;
        Passing { momentum, ..Passing::default() }
    }

    /// The state beyond at a level (m), between critical outflow and rest.
    pub(super) fn below(&self, level: f64, g: f64) -> EdgeState {
        let fall = overfall(self.invariant, g);
        let still = 0.25 * self.invariant * self.invariant / g;
        at_depth(clamp(level - self.sill, smaller(fall.depth, still), still), (1.0, 1.0), self.invariant, g)
    }
}

impl Passing {
    /// The flux of a state alone.
    pub(super) fn of(state: EdgeState, g: f64) -> Self {
        let EdgeState { depth, outwards } = state;
        Passing {
            mass: depth * outwards,
            momentum: depth * outwards * outwards + 0.5 * g * depth * depth,
            speed: outwards.abs() + (g * depth).sqrt(),
            beyond: Some(state),
        }
    }
}
