//! Mixing by turbulence: the stress of an eddy viscosity at the faces between wet particles.
//!
//! ```text
//! (M36)  F_n ← F_n − 2 ν d_f ∂v_n/∂n,   F_d v_t ← F_d v_t − ν d_f (∂v_t/∂n + ∂v_n/∂t),   d_f = 2 d_i d_j/(d_i + d_j)
//! ```
//!
//! One stress for both particles of a face, so that momentum is kept to rounding. The derivative across a face is the difference of its particles, that along
//! it the mean of their gradients; ν is that of [`turbulence`]. With the harmonic mean of the depths thin water is not torn along by deep water beside it.
//! Faces at walls and edges have no such stress: water slips along them. Nor have those over sills.
//!
//! At a face of length l over a way s, of a cell with N faces and the area A, a step bears ν up to s A/(3 N l Δt). More is left out. On
//! a lattice that is Δ²/(12 Δt). Only inside a jump, whose shear grows as 1/Δ, is there more. A velocity at the angle θ to the way over a face gives
//! 2 (1 + cos² θ) ν l/s of it there, since d_f ≤ 2 d_i. The mean of cos² θ over the faces is a half: together that is no more than it has.

use rayon::prelude::*;

use super::faces::{EAST, Half, NORTH, Side};
use super::spans::ActiveSet;
use super::state::{FaceRow, State};
use super::{EulerianMethods, Scale};
use crate::constants::EulerianConstants;
use crate::math::{inverse_cube_root, smaller};
use crate::methods::Turbulence;
use crate::physics::turbulence;

/// What general faces need for the stress in a step: dry depth (m), the square of the mixing length over that of the depth, and the step (s).
#[derive(Clone, Copy)]
pub(super) struct Mixing {
    dry_depth: f64,
    square_of_length: f64,
    time_step: f64,
}

/// What the stress on a general face takes from its surroundings: the mean of g n² (m^(1/3)·m/s²) on both sides, and s A/(3 N l) (m²), the
/// lesser of both.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Surroundings {
    pub friction: f64,
    pub bears: f64,
}

impl Surroundings {
    /// Of a face of a length (m) over a way (m) between two cells with so many faces each.
    pub fn new(state: &State, places: [(usize, usize); 2], faces: [usize; 2], (way, length): (f64, f64)) -> Self {
        let friction = places.map(|(row, column)| state.ground[row].friction[column]);
        let [a, b] = [0, 1].map(|side| bears(way, (state.area(places[side]), faces[side]), length));
        Surroundings { friction: 0.5 * (friction[0] + friction[1]), bears: a.min(b) }
    }
}

/// s A/(3 N l) (m²): the greatest viscosity times the step, at a face over a way (m), of a cell with an area (m²) and so many faces, for a length (m).
fn bears(way: f64, (area, faces): (f64, usize), length: f64) -> f64 {
    way * area / (3.0 * faces as f64 * length)
}

impl Mixing {
    /// Of a step (s); none without turbulence.
    pub fn new(scale: &Scale, methods: EulerianMethods, time_step: f64) -> Option<Self> {
        (methods.turbulence != Turbulence::None).then(|| Mixing {
            dry_depth: scale.dry_depth,
            square_of_length: square_of_length(&methods.constants),
            time_step,
        })
    }

    /// What is added to F_n and to F_d v_t at a general face between two particles at a distance (m) along the normal, whose normal velocities change
    /// along the face by so much (1/s).
    pub fn stress(&self, [i, j]: &[Half; 2], way: f64, changes: [f64; 2], around: Surroundings) -> [f64; 2] {
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        let (n, t) = ((j.u - i.u) / way, (j.v_t - i.v_t) / way);
        let gradients = [n, mean(changes[0], changes[1]), t, mean(i.stretch_t, j.stretch_t) / way];
        let (u, v) = (mean(i.u, j.u), mean(i.v_t, j.v_t));
        let numbers = Numbers {
            dx: way,
            dry_depth: self.dry_depth,
            greatest: around.bears / self.time_step,
            square_of_length: self.square_of_length,
        };
        let carried = carried((i.d, j.d), around.friction * (u * u + v * v), gradients, numbers);
        [-2.0 * carried * n, -carried * (t + gradients[1])]
    }
}

/// The square of the mixing length of the plane over that of the depth.
fn square_of_length(constants: &EulerianConstants) -> f64 {
    turbulence::square_of_length(constants.mixing_length, constants.plane_mixing)
}

/// ν d_f (m³/s) between two depths (m), by g n² |v|² and the gradients of both velocities (1/s); 0 where there is no water or no terrain.
#[inline(always)]
fn carried((d_i, d_j): (f64, f64), friction: f64, gradients: [f64; 4], numbers: Numbers) -> f64 {
    let d_f = 2.0 * d_i * d_j / (d_i + d_j);
    // √(g n²) |v| d^(−1/6).
    let shear_velocity = (friction * inverse_cube_root(d_f)).sqrt();
    let strain = turbulence::strain(gradients);
    let viscosity = turbulence::eddy_viscosity(d_f, shear_velocity, strain, numbers.square_of_length);
    if smaller(d_i, d_j) > numbers.dry_depth { smaller(viscosity, numbers.greatest) * d_f } else { 0.0 }
}

/// Adds the stress of the eddy viscosity to the fluxes of all ordinary faces.
pub(crate) fn add(state: &mut State, active: &ActiveSet, scale: &Scale, constants: &EulerianConstants, time_step: f64) {
    let (primitive, gradient, ground, spacing) = (&state.primitive, &state.gradient, &state.ground, &state.spacing);
    let numbers = |dx: f64| Numbers {
        dx,
        dry_depth: scale.dry_depth,
        greatest: bears(dx, (dx * dx, 4), dx) / time_step,
        square_of_length: square_of_length(constants),
    };
    active.rows_of(&mut state.flux).for_each(|(row, flux)| {
        let numbers = numbers(spacing[row]);
        for run in active.pieces_of_squares(row) {
            let side = |row: usize| Side { water: &primitive[row], slope: &gradient[row], ground: &ground[row] };
            let (here, north) = (side(row), side(row + 1));
            let (from, len) = (run.start, run.len());
            add_to_row::<EAST>((here, from), (here, from + 1), len, numbers, &mut flux[EAST]);
            add_to_row::<NORTH>((here, from), (north, from), len, numbers, &mut flux[NORTH]);
        }
    });
}

/// Spacing (m), dry depth (m), the greatest eddy viscosity that the step bears (m²/s), and the square of the mixing length over that of the depth.
#[derive(Clone, Copy)]
struct Numbers {
    dx: f64,
    dry_depth: f64,
    greatest: f64,
    square_of_length: f64,
}

/// Adds it to so many faces of a row.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn add_to_row<const DIRECTION: usize>(
    (left, left_from): (Side<'_>, usize),
    (right, right_from): (Side<'_>, usize),
    len: usize,
    numbers: Numbers,
    out: &mut FaceRow,
) {
    macro_rules! pairs {
        ($row:ident, $($field:ident)+) => {
            ($((&left.$row.$field[left_from..][..len], &right.$row.$field[right_from..][..len]),)+)
        };
    }
    let (depth, u, v) = pairs!(water, depth velocity_x velocity_y);
    let (u_x, u_y, v_x, v_y) = pairs!(slope, u_x u_y v_x v_y);
    let (friction,) = pairs!(ground, friction);
    let normal_left = &mut out.normal_left[left_from..][..len];
    let normal_right = &mut out.normal_right[left_from..][..len];
    let tangential = &mut out.tangential[left_from..][..len];
    for k in 0..len {
        let mean = |(left, right): (&[f64], &[f64])| 0.5 * (left[k] + right[k]);
        let across = |(left, right): (&[f64], &[f64])| (right[k] - left[k]) / numbers.dx;
        let gradients = if DIRECTION == EAST {
            [across(u), mean(u_y), across(v), mean(v_y)]
        } else {
            [mean(u_x), across(u), mean(v_x), across(v)]
        };
        let [u_x, u_y, v_x, v_y] = gradients;
        let (u_f, v_f) = (mean(u), mean(v));
        let friction = mean(friction) * (u_f * u_f + v_f * v_f);
        let carried = carried((depth.0[k], depth.1[k]), friction, gradients, numbers);
        let normal = 2.0 * carried * if DIRECTION == EAST { u_x } else { v_y };
        normal_left[k] -= normal;
        normal_right[k] -= normal;
        tangential[k] -= carried * (u_y + v_x);
    }
}

#[cfg(test)]
mod tests;
