//! Helpers of the tests: made problems, exact solutions, error norms.

#![allow(dead_code, reason = "every test binary uses its own part")]
#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use floodsim::bed::BedParticles;
use floodsim::lattice::Lattice;
use floodsim::math::Vec2;
use floodsim::particles::FluidSeed;
use floodsim::solver::moving::{Formulation, MovingSolver};
use floodsim::solver::{FlowProblem, FlowSolver, OpenEdges};

/// Gravity (m/s²).
pub const GRAVITY: f64 = 9.81;

/// A dry problem on a lattice whose bed follows a function of the place.
pub fn problem(columns: usize, rows: usize, spacing: f64, bed: impl Fn(Vec2) -> f64) -> FlowProblem {
    let lattice = Lattice { origin: Vec2::new(1000.0, 2000.0), columns, rows, spacing };
    let elevation = (0..lattice.len()).map(|index| bed(lattice.centre(index))).collect();
    FlowProblem {
        initial_depth: vec![0.0; lattice.len()],
        bed: BedParticles::from_elevation(lattice, elevation, 0.0),
        walls: Vec::new(),
        open_edges: OpenEdges::default(),
        gravity: GRAVITY,
        courant: 0.4,
        dry_depth: 1e-6,
    }
}

/// Seeds at the given places where `level` is above the bed, each holding `area` (m²) times its depth.
pub fn seeds_at(problem: &FlowProblem, places: &[Vec2], area: f64, level: impl Fn(Vec2) -> f64) -> Vec<FluidSeed> {
    places
        .iter()
        .filter_map(|&position| {
            let depth = level(position) - problem.bed.at(position)?.elevation;
            (depth > 1e-4).then_some(FluidSeed { position, volume: area * depth, depth })
        })
        .collect()
}

/// Places on a square lattice over a rectangle from the origin, each moved by up to `jitter` spacings in each direction.
pub fn places(width: f64, height: f64, spacing: f64, jitter: f64) -> Vec<Vec2> {
    let mut state = 7_u64;
    let mut next = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let (columns, rows) = ((width / spacing).round() as usize, (height / spacing).round() as usize);
    (0..columns * rows)
        .map(|index| {
            let centre = Vec2::new((index % columns) as f64 + 0.5, (index / columns) as f64 + 0.5);
            (centre + Vec2::new(next(), next()) * (2.0 * jitter)) * spacing
        })
        .collect()
}

/// Runs to a time with the solver's own steps.
pub fn run_until<F: Formulation>(solver: &mut MovingSolver<F>, end: f64) {
    while solver.time() < end - 1e-9 {
        let step = solver.choose_step().time_step.min(end - solver.time());
        solver.advance(step).unwrap();
    }
}

/// Runs a number of steps.
pub fn run_steps<F: Formulation>(solver: &mut MovingSolver<F>, steps: usize) {
    for _ in 0..steps {
        let step = solver.choose_step().time_step;
        solver.advance(step).unwrap();
    }
}

/// Greatest speed of any particle (m/s).
pub fn max_speed<F: Formulation>(solver: &MovingSolver<F>) -> f64 {
    solver.state().particles.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

/// Mean absolute errors of depth (m) and velocity (m/s) over all particles; `exact` gives both at a place.
pub fn mean_errors<F: Formulation>(solver: &MovingSolver<F>, exact: impl Fn(Vec2) -> (f64, Vec2)) -> (f64, f64) {
    let particles = &solver.state().particles;
    let (mut depth, mut velocity) = (0.0, 0.0);
    for i in 0..particles.len() {
        let (d, v) = exact(particles.position[i]);
        depth += (particles.depth[i] - d).abs();
        velocity += (particles.velocity[i] - v).norm();
    }
    (depth / particles.len() as f64, velocity / particles.len() as f64)
}

/// Checks a pair of errors (depth, velocity) against a pair of bounds.
pub fn assert_below(errors: (f64, f64), bounds: (f64, f64)) {
    assert!(errors.0 < bounds.0 && errors.1 < bounds.1, "errors {errors:?} against bounds {bounds:?}");
}

/// Ritter's dam break on dry bed: depth (m) and velocity (m/s) at `x` (m) from the dam after `t` (s).
pub fn ritter(depth: f64, x: f64, t: f64) -> (f64, f64) {
    let c = (GRAVITY * depth).sqrt();
    if x <= -c * t {
        (depth, 0.0)
    } else if x < 2.0 * c * t {
        ((2.0 * c - x / t).powi(2) / (9.0 * GRAVITY), 2.0 / 3.0 * (c + x / t))
    } else {
        (0.0, 0.0)
    }
}

/// Stoker's dam break on wet bed: the middle state found by bisection of the jump conditions.
pub fn stoker(d_l: f64, d_r: f64, x: f64, t: f64) -> (f64, f64) {
    let c_l = (GRAVITY * d_l).sqrt();
    let speed_behind_shock = |d: f64| (d - d_r) * (0.5 * GRAVITY * (d + d_r) / (d * d_r)).sqrt();
    let (mut low, mut high) = (d_r, d_l);
    for _ in 0..200 {
        let d = 0.5 * (low + high);
        if 2.0 * (c_l - (GRAVITY * d).sqrt()) > speed_behind_shock(d) { low = d } else { high = d }
    }
    let (d_m, u_m) = (low, speed_behind_shock(low));
    let shock = d_m * u_m / (d_m - d_r);
    let xi = x / t;
    if xi < -c_l {
        (d_l, 0.0)
    } else if xi < u_m - (GRAVITY * d_m).sqrt() {
        ((2.0 * c_l - xi).powi(2) / (9.0 * GRAVITY), 2.0 / 3.0 * (c_l + xi))
    } else if xi < shock {
        (d_m, u_m)
    } else {
        (d_r, 0.0)
    }
}

/// Radial dam break by finite volumes (HLL, first order, `cells` cells to `radius`): depth and radial velocity at time `end`.
pub fn radial_reference(
    inside: f64,
    outside: f64,
    dam: f64,
    radius: f64,
    end: f64,
    cells: usize,
) -> impl Fn(f64) -> (f64, f64) {
    let dr = radius / cells as f64;
    let centre = |k: usize| (k as f64 + 0.5) * dr;
    let mut d: Vec<f64> = (0..cells).map(|k| if centre(k) < dam { inside } else { outside }).collect();
    let mut q = vec![0.0; cells];
    let flux = |(d_l, q_l): (f64, f64), (d_r, q_r): (f64, f64)| {
        let (u_l, u_r) = (q_l / d_l.max(1e-9), q_r / d_r.max(1e-9));
        let (c_l, c_r) = ((GRAVITY * d_l).sqrt(), (GRAVITY * d_r).sqrt());
        let (s_l, s_r) = ((u_l - c_l).min(u_r - c_r).min(0.0), (u_l + c_l).max(u_r + c_r).max(0.0));
        let (m_l, m_r) = (q_l * u_l + 0.5 * GRAVITY * d_l * d_l, q_r * u_r + 0.5 * GRAVITY * d_r * d_r);
        let span = (s_r - s_l).max(1e-12);
        (
            (s_r * q_l - s_l * q_r + s_l * s_r * (d_r - d_l)) / span,
            (s_r * m_l - s_l * m_r + s_l * s_r * (q_r - q_l)) / span,
        )
    };
    let mut t = 0.0;
    while t < end {
        let speed = (0..cells).map(|k| (q[k] / d[k].max(1e-9)).abs() + (GRAVITY * d[k]).sqrt()).fold(1e-9, f64::max);
        let dt = (0.9 * dr / speed).min(end - t);
        let faces: Vec<(f64, f64)> = (0..=cells)
            .map(|f| match f {
                0 => (0.0, 0.5 * GRAVITY * d[0] * d[0]),
                f if f == cells => (0.0, 0.5 * GRAVITY * d[cells - 1] * d[cells - 1]),
                f => flux((d[f - 1], q[f - 1]), (d[f], q[f])),
            })
            .collect();
        for k in 0..cells {
            let u = q[k] / d[k].max(1e-9);
            let (f_d, f_q) = (faces[k + 1].0 - faces[k].0, faces[k + 1].1 - faces[k].1);
            let spread = dt / centre(k);
            d[k] -= dt / dr * f_d + spread * q[k];
            q[k] -= dt / dr * f_q + spread * q[k] * u;
        }
        t += dt;
    }
    move |r: f64| {
        let k = ((r / dr) as usize).min(cells - 1);
        (d[k], q[k] / d[k].max(1e-9))
    }
}
