//! Mixing by turbulence: the stress of an eddy viscosity at the faces between wet particles.
//!
//! ```text
//! (M72)  F_n ← F_n − 2 ν d_f ∂v_n/∂n,   F_d v_t ← F_d v_t − ν d_f (∂v_t/∂n + ∂v_n/∂t),   d_f = 2 d_i d_j/(d_i + d_j)
//! ```
//!
//! One stress for both particles of a face, so that momentum is kept to rounding. The derivative across a face is the difference of its particles, that along
//! it the mean of their gradients; ν is that of [`turbulence`]. With the harmonic mean of the depths thin water is not torn along by deep water beside it.
//! Faces at walls and edges, which are made after this pass, have no such stress: water slips along them.
//!
//! A step bears ν up to Δ²/(12 Δt), and more than that is left out. Only inside a jump, whose shear grows as 1/Δ, is there more.

use rayon::prelude::*;

use super::Scale;
use super::faces::{EAST, NORTH};
use super::spans::ActiveSet;
use super::state::{FluxRow, GradientRow, GroundRow, NO_TERRAIN, PrimitiveRow, State};
use crate::math::{inverse_cube_root, smaller};
use crate::physics::turbulence;

/// What one row has.
#[derive(Clone, Copy)]
struct Row<'a> {
    water: &'a PrimitiveRow,
    slope: &'a GradientRow,
    ground: &'a GroundRow,
}

/// Adds the stress of the eddy viscosity to the fluxes of all ordinary faces.
pub(crate) fn add(state: &mut State, active: &ActiveSet, scale: &Scale, time_step: f64) {
    let (primitive, gradient, ground) = (&state.primitive, &state.gradient, &state.ground);
    let numbers = Numbers {
        dx: scale.spacing,
        dry_depth: scale.dry_depth,
        greatest: scale.spacing * scale.spacing / (12.0 * time_step),
    };
    state.flux.par_iter_mut().enumerate().with_min_len(4).for_each(|(row, flux)| {
        let side = |row: usize| Row { water: &primitive[row], slope: &gradient[row], ground: &ground[row] };
        for i in active.work[row].iter().cloned().flatten() {
            add_to_face::<EAST>((side(row), i), (side(row), i + 1), numbers, flux);
            add_to_face::<NORTH>((side(row), i), (side(row + 1), i), numbers, flux);
        }
    });
}

/// Spacing (m), dry depth (m) and the greatest eddy viscosity that the step bears (m²/s).
#[derive(Clone, Copy)]
struct Numbers {
    dx: f64,
    dry_depth: f64,
    greatest: f64,
}

#[inline(always)]
fn add_to_face<const DIRECTION: usize>(
    (left, i): (Row<'_>, usize),
    (right, j): (Row<'_>, usize),
    numbers: Numbers,
    flux: &mut FluxRow,
) {
    let (d_i, d_j) = (left.water.depth[i], right.water.depth[j]);
    let is_wet = smaller(d_i, d_j) > numbers.dry_depth;
    if !is_wet || left.ground.bed[i] >= NO_TERRAIN || right.ground.bed[j] >= NO_TERRAIN {
        return;
    }
    let depth = 2.0 * d_i * d_j / (d_i + d_j);
    let (u_i, v_i) = (left.water.velocity_x[i], left.water.velocity_y[i]);
    let (u_j, v_j) = (right.water.velocity_x[j], right.water.velocity_y[j]);
    let across = [(u_j - u_i) / numbers.dx, (v_j - v_i) / numbers.dx];
    let along = |of_left: &[f64], of_right: &[f64]| 0.5 * (of_left[i] + of_right[j]);
    let gradients = if DIRECTION == EAST {
        let [u_x, v_x] = across;
        [u_x, along(&left.slope.u_y, &right.slope.u_y), v_x, along(&left.slope.v_y, &right.slope.v_y)]
    } else {
        let [u_y, v_y] = across;
        [along(&left.slope.u_x, &right.slope.u_x), u_y, along(&left.slope.v_x, &right.slope.v_x), v_y]
    };
    let [u_x, u_y, v_x, v_y] = gradients;
    let (u, v) = (0.5 * (u_i + u_j), 0.5 * (v_i + v_j));
    // √(g n²) |v| d^(−1/6).
    let friction = 0.5 * (left.ground.friction[i] + right.ground.friction[j]);
    let shear_velocity = (friction * (u * u + v * v) * inverse_cube_root(depth)).sqrt();
    let viscosity = turbulence::eddy_viscosity(depth, shear_velocity, turbulence::strain(gradients));
    let carried = smaller(viscosity, numbers.greatest) * depth;
    let normal = 2.0 * carried * if DIRECTION == EAST { u_x } else { v_y };
    let face = &mut flux[DIRECTION];
    face.normal_left[i] -= normal;
    face.normal_right[i] -= normal;
    face.tangential[i] -= carried * (u_y + v_x);
}

#[cfg(test)]
mod tests {
    use crate::bed::BedParticles;
    use crate::lattice::Lattice;
    use crate::math::Vec2;
    use crate::physics::turbulence::eddy_viscosity;
    use crate::scenario::methods::{Reconstruction, Stabilisation, Turbulence};
    use crate::solver::eulerian::{EulerianSolver, tests};
    use crate::solver::{FlowProblem, FlowSolver};

    fn problem(grid: &Lattice, initial_depth: Vec<f64>) -> FlowProblem {
        tests::problem(grid.clone(), vec![0.0; grid.len()], initial_depth)
    }

    fn solver(grid: &Lattice, initial_depth: Vec<f64>, turbulence: Turbulence) -> EulerianSolver {
        mixed(problem(grid, initial_depth), turbulence)
    }

    fn mixed(problem: FlowProblem, turbulence: Turbulence) -> EulerianSolver {
        EulerianSolver::with_methods(problem, Stabilisation::Hllc, Reconstruction::Limited, turbulence)
    }

    fn run(solver: &mut EulerianSolver, end: f64) {
        while solver.time() < end {
            let step = solver.choose_step().time_step.min(end - solver.time());
            solver.advance(step).expect("a stable run");
        }
    }

    /// Speed (m/s), width (m) and middle (m) of a shear layer, its time (s) and the width of the channel (m).
    const SPEED: f64 = 0.5;
    const WIDTH: f64 = 1.0;
    const MIDDLE: f64 = 6.0;
    const END: f64 = 4.0;
    const CHANNEL: f64 = 12.0;

    fn layer(y: f64) -> f64 {
        SPEED * ((y - MIDDLE) / WIDTH).tanh()
    }

    /// The layer at the end by ∂u/∂t = ∂(ν ∂u/∂y)/∂y alone, on cells of 5 cm, as a function of the place.
    fn widened() -> impl Fn(f64) -> f64 {
        let (dy, dt) = (0.05, 0.002);
        let mut u: Vec<f64> = (0..(CHANNEL / dy) as usize).map(|k| layer((k as f64 + 0.5) * dy)).collect();
        for _ in 0..(END / dt).round() as usize {
            let stress: Vec<f64> = u
                .windows(2)
                .map(|pair| (pair[1] - pair[0]) / dy)
                .map(|shear| eddy_viscosity(1.0, 0.0, shear.abs()) * shear)
                .collect();
            for (k, here) in u.iter_mut().enumerate() {
                let north = stress.get(k).copied().unwrap_or(0.0);
                let south = k.checked_sub(1).map_or(0.0, |k| stress[k]);
                *here += dt / dy * (north - south);
            }
        }
        move |y: f64| {
            let k = (y / dy - 0.5).floor();
            let share = y / dy - 0.5 - k;
            u[k as usize] * (1.0 - share) + u[k as usize + 1] * share
        }
    }

    #[test]
    fn a_shear_layer_widens_as_its_diffusion_in_one_dimension_and_keeps_its_momentum() {
        // So long that nothing from its ends comes to the middle.
        let grid = Lattice { origin: Vec2::ZERO, columns: 240, rows: 48, spacing: CHANNEL / 48.0 };
        let exact = widened();
        let (mut errors, mut sums) = (Vec::new(), Vec::new());
        for turbulence in Turbulence::ALL {
            let mut solver = solver(&grid, vec![1.0; grid.len()], *turbulence);
            solver.set_velocity(|place| Vec2::new(layer(place.y), 0.0));
            run(&mut solver, END);
            let column: Vec<(f64, f64)> = (0..grid.rows)
                .map(|row| (grid.centre(row * grid.columns + 120).y, row + 1))
                .map(|(y, row)| (y, solver.state.water[row].discharge_x[121] / solver.state.water[row].depth[121]))
                .collect();
            let off = column.iter().map(|(y, u)| (u - exact(*y)).abs()).sum::<f64>() / column.len() as f64;
            errors.push(off / SPEED);
            sums.push(column.iter().map(|(_, u)| u).sum::<f64>());
        }
        assert!(errors[0] > 0.02, "without mixing the layer stays as it was: {errors:?}");
        assert!(errors[1] < 0.002, "{errors:?}");
        assert!(sums.iter().all(|sum| sum.abs() < 1e-12), "{sums:?}");
    }

    #[test]
    fn both_directions_of_the_lattice_are_alike() {
        let grid = Lattice { origin: Vec2::ZERO, columns: 40, rows: 40, spacing: 0.5 };
        // A column of water off the middle, symmetric about the diagonal.
        let is_high = |index: usize| (grid.centre(index) - Vec2::new(7.0, 7.0)).norm() < 3.0;
        let depth = (0..grid.len()).map(|index| if is_high(index) { 2.0 } else { 0.5 }).collect();
        let mut solver = solver(&grid, depth, Turbulence::MixingLength);
        run(&mut solver, 4.0);
        let depth = |row: usize, column: usize| solver.state.water[row].depth[column];
        let mut worst = 0.0_f64;
        for row in 1..=40 {
            for column in 1..=40 {
                worst = worst.max((depth(row, column) - depth(column, row)).abs());
            }
        }
        assert!(worst < 1e-12, "{worst:e}");
        assert!(solver.ledger().relative_error().abs() < 1e-13);
    }

    #[test]
    fn a_scene_as_large_as_you_like_is_the_same_by_the_law_of_froude() {
        // 64 times as large: times by 8, n by 2, all of them powers of two, so that nothing is rounded otherwise.
        let flow = |scale: f64, time: f64, roughness: f64| {
            let grid = Lattice { origin: Vec2::ZERO, columns: 40, rows: 24, spacing: 0.05 * scale };
            let place = |index: usize| grid.centre(index) * (1.0 / scale);
            let elevation: Vec<f64> = (0..grid.len())
                .map(|index| if (place(index) - Vec2::new(1.3, 0.5)).norm() < 0.2 { f64::NAN } else { 0.0 })
                .collect();
            let depth = (0..grid.len()).map(|index| scale * if place(index).x < 0.7 { 0.4 } else { 0.02 }).collect();
            let bed = BedParticles::from_elevation(grid.clone(), elevation, 0.01 * roughness);
            let dry_depth = 1e-3 * scale;
            let mut solver = mixed(FlowProblem { bed, dry_depth, ..problem(&grid, depth) }, Turbulence::MixingLength);
            run(&mut solver, 2.0 * time);
            (0..24).flat_map(|row| solver.state.water[row + 1].depth[1..=40].to_vec()).collect::<Vec<f64>>()
        };
        let (small, large) = (flow(1.0, 1.0, 1.0), flow(64.0, 8.0, 2.0));
        let apart = small.iter().zip(&large).map(|(d, scaled)| (scaled / 64.0 - d).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-9, "{apart:e} m of 0.4 m");
        assert!(small.iter().any(|d| *d > 0.1) && small.iter().any(|d| *d < 0.05), "the water moves");
    }
}
