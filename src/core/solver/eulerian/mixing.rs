//! Mixing by turbulence: the stress of an eddy viscosity at the faces between wet particles.
//!
//! ```text
//! (M36)  F_n ← F_n − 2 ν d_f ∂v_n/∂n,   F_d v_t ← F_d v_t − ν d_f (∂v_t/∂n + ∂v_n/∂t),   d_f = 2 d_i d_j/(d_i + d_j)
//! ```
//!
//! One stress for both particles of a face, so that momentum is kept to rounding. The derivative across a face is the difference of its particles, that along
//! it the mean of their gradients; ν is that of [`turbulence`]. With the harmonic mean of the depths thin water is not torn along by deep water beside it.
//! Faces at walls, edges and between levels, which are made after this pass, have no such stress: water slips along them.
//!
//! A step bears ν up to Δ²/(12 Δt), and more than that is left out. Only inside a jump, whose shear grows as 1/Δ, is there more. A velocity
//! gives 2 · 2 ν to the two neighbours along it and 2 ν to the others, each over at most twice its own depth (d_f ≤ 2 d_i): 12 ν Δt/Δ² of it, no more than it has.

use rayon::prelude::*;

use super::Scale;
use super::faces::{EAST, NORTH, Side};
use super::spans::ActiveSet;
use super::state::{FaceRow, State};
use crate::constants::EulerianConstants;
use crate::math::{inverse_cube_root, smaller};
use crate::physics::turbulence;

/// Adds the stress of the eddy viscosity to the fluxes of all ordinary faces.
pub(crate) fn add(state: &mut State, active: &ActiveSet, scale: &Scale, constants: &EulerianConstants, time_step: f64) {
    let (primitive, gradient, ground, spacing) = (&state.primitive, &state.gradient, &state.ground, &state.spacing);
    let numbers = |dx: f64| Numbers {
        dx,
        dry_depth: scale.dry_depth,
        greatest: dx * dx / (12.0 * time_step),
        square_of_length: turbulence::square_of_length(constants.mixing_length, constants.plane_mixing),
    };
    active.rows_of(&mut state.flux).for_each(|(row, flux)| {
        let numbers = numbers(spacing[row]);
        for run in &active.work[row] {
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
    Numbers { dx, dry_depth, greatest, square_of_length }: Numbers,
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
        let across = |(left, right): (&[f64], &[f64])| (right[k] - left[k]) / dx;
        let gradients = if DIRECTION == EAST {
            [across(u), mean(u_y), across(v), mean(v_y)]
        } else {
            [mean(u_x), across(u), mean(v_x), across(v)]
        };
        let [u_x, u_y, v_x, v_y] = gradients;
        let (d_i, d_j) = (depth.0[k], depth.1[k]);
        let d_f = 2.0 * d_i * d_j / (d_i + d_j);
        let (u_f, v_f) = (mean(u), mean(v));
        // √(g n²) |v| d^(−1/6).
        let shear_velocity = (mean(friction) * (u_f * u_f + v_f * v_f) * inverse_cube_root(d_f)).sqrt();
        let viscosity =
            turbulence::eddy_viscosity(d_f, shear_velocity, turbulence::strain(gradients), square_of_length);
        // Where there is no terrain there is no water.
        let is_wet = smaller(d_i, d_j) > dry_depth;
        let carried = if is_wet { smaller(viscosity, greatest) * d_f } else { 0.0 };
        let normal = 2.0 * carried * if DIRECTION == EAST { u_x } else { v_y };
        normal_left[k] -= normal;
        normal_right[k] -= normal;
        tangential[k] -= carried * (u_y + v_x);
    }
}

#[cfg(test)]
mod tests {
    use super::{EAST, NORTH};
    use crate::bed::BedParticles;
    use crate::constants::EulerianConstants;
    use crate::lattice::Lattice;
    use crate::math::Vec2;
    use crate::methods::Turbulence;
    use crate::physics::turbulence::{eddy_viscosity, square_of_length};
    use crate::solver::eulerian::{EulerianMethods, EulerianSolver, tests};
    use crate::solver::{FlowProblem, FlowSolver};

    fn problem(grid: &Lattice, initial_depth: Vec<f64>) -> FlowProblem {
        tests::problem(grid.clone(), vec![0.0; grid.len()], initial_depth)
    }

    fn solver(grid: &Lattice, initial_depth: Vec<f64>, turbulence: Turbulence) -> EulerianSolver {
        mixed(problem(grid, initial_depth), turbulence)
    }

    fn mixed(problem: FlowProblem, turbulence: Turbulence) -> EulerianSolver {
        EulerianSolver::with_methods(problem, EulerianMethods { turbulence, ..EulerianMethods::default() })
    }

    fn run(solver: &mut EulerianSolver, end: f64) {
        while solver.time() < end {
            let step = solver.choose_step().time_step.min(end - solver.time());
            solver.advance(step).expect("a stable run");
        }
    }

    #[test]
    fn faces_have_a_stress_where_both_sides_have_terrain_and_water() {
        let grid = Lattice::new(Vec2::ZERO, 19, 12, 0.5);
        // Rows of faces with holes of both kinds, longer than any lanes, and a rest of fewer.
        let elevation = (0..grid.len()).map(|index| if index % 7 == 3 { f64::NAN } else { 0.0 }).collect();
        let depth = (0..grid.len()).map(|index| if index % 5 == 2 { 0.0 } else { 1.0 }).collect();
        let mut solver = mixed(tests::problem(grid.clone(), elevation, depth), Turbulence::MixingLength);
        solver.set_velocity(|place| Vec2::new(place.x * place.y, place.x + 2.0 * place.y));
        super::add(&mut solver.state, &solver.active, &solver.scale, &EulerianConstants::DEFAULT, 0.01);
        let has_water = |row: usize, column: usize| {
            solver.state.has_terrain(row, column) && solver.state.primitive[row].depth[column] > 0.0
        };
        for (row, column) in (1..=grid.rows).flat_map(|row| (1..=grid.columns).map(move |column| (row, column))) {
            let beyond = [(EAST, row, column + 1), (NORTH, row + 1, column)];
            for (direction, to_row, to_column) in beyond {
                let face = &solver.state.flux[row][direction];
                let stress = [face.normal_left[column], face.normal_right[column], face.tangential[column]];
                let is_wet = has_water(row, column) && has_water(to_row, to_column);
                assert!(stress.iter().all(|part| if is_wet { *part < 0.0 } else { part.abs() <= 0.0 }), "{stress:?}");
            }
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
                .map(|shear| eddy_viscosity(1.0, 0.0, shear.abs(), square_of_length(0.09, 6.0)) * shear)
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
        let grid = Lattice::new(Vec2::ZERO, 240, 48, CHANNEL / 48.0);
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
        let grid = Lattice::new(Vec2::ZERO, 40, 40, 0.5);
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
            let grid = Lattice::new(Vec2::ZERO, 40, 24, 0.05 * scale);
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
