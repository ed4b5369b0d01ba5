//! Flow of Eulerian particles: errors against exact solutions, on coarse lattices.

use floodsim::constants::Constants;
use floodsim::math::Vec2;
use floodsim::scenario::methods::Core;
use floodsim::solver::threads::in_pool;
use floodsim::solver::{Boundary, Condition, EulerianMethods, EulerianSolver, FlowProblem, FlowSolver, Series};
use floodsim::validation::{cases, problem, run};

use super::Case;
use crate::support::methods;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "stoker",
        about: "dam break of 10 m over 5 m, spacing 20 m: mean error of the depth (m)",
        feels: &["eulerian.pressed_kappa"],
        run: |constants| of_suite("stoker", &[], constants),
    },
    Case {
        name: "circular dam",
        about: "circular dam break of 2.5 m over 0.5 m, spacing 0.2 m: mean error of the depth (m)",
        feels: &["eulerian.pressed_kappa", "eulerian.shear_mixing"],
        run: |constants| of_suite("circular_dam", &[], constants),
    },
    Case {
        name: "axisymmetric bowl",
        about: "Thacker's axisymmetric oscillation, spacing a/10: mean error of the depth (m)",
        feels: &["eulerian.fall_fade", "eulerian.fall_height"],
        run: |constants| of_suite("thacker_axisymmetric", &[], constants),
    },
    Case {
        name: "levee",
        about: "3 m²/s over a levee of 3 m, one cell of 2.5 m wide: head against that of a broad-crested weir (share)",
        feels: &["eulerian.fall_fade", "eulerian.fall_height"],
        run: levee,
    },
    Case {
        name: "drop",
        about: "0.5 m²/s down a slope of 0.1 with drops of 0.5 to 1.5 spacings: mean depth against uniform flow on the slope (share)",
        feels: &["eulerian.fall_fade", "eulerian.fall_height"],
        run: drops,
    },
    Case {
        name: "round basin",
        about: "first seiche of a round basin of 20 cells between walls, one period: error of the level (share of its height)",
        feels: &["eulerian.stair_reach", "eulerian.aperture_"],
        run: round_basin,
    },
    Case {
        name: "channel at 30°",
        about: "uniform flow in a channel turned by 30° between walls, by discharge and normal depth, 12 cells wide: error of the depth (share)",
        feels: &["eulerian.stair_reach", "eulerian.aperture_", "eulerian.edge_about"],
        run: |constants| channel(30.0, constants),
    },
    Case {
        name: "channel at 10°",
        about: "the same at 10°",
        feels: &["eulerian.stair_reach", "eulerian.aperture_", "eulerian.edge_about"],
        run: |constants| channel(10.0, constants),
    },
    Case {
        name: "mixing",
        about: "deep circular dam break of 10 m over 1 m with mixing, spacing 1 m: mean distance from the solution without it (m)",
        feels: &["eulerian.mixing_length", "eulerian.plane_mixing"],
        run: |constants| of_suite("circular_dam_deep", &[("turbulence", "mixing_length")], constants),
    },
];

/// Mean error of the depth (m) of a case of the suites at its coarsest spacing.
fn of_suite(name: &str, given: &[(&str, &str)], constants: &Constants) -> f64 {
    let case = cases::named(name).unwrap();
    let setup = (case.setup)(case.spacings[0], Core::Eulerian).unwrap();
    let mut choice = methods(&[&[("motion", "eulerian")], given].concat());
    choice.numerics.constants = *constants;
    run(&setup, &choice).1.unwrap().errors.depth
}

/// The depths (m) of a problem at a time (s).
fn depths_at(problem: FlowProblem, constants: &Constants, end: f64) -> Vec<f64> {
    let methods = EulerianMethods { constants: constants.eulerian, ..EulerianMethods::default() };
    in_pool(|| {
        let mut solver = EulerianSolver::with_methods(problem, methods);
        while solver.time() < end - 1e-9 {
            let step = solver.choose_step().time_step;
            solver.advance(step.min(end - solver.time())).unwrap();
        }
        solver.water().depths()
    })
}

/// Opens a channel of one row at both ends: a discharge (m²/s) comes in at the west, and water leaves freely or by uniform flow.
fn open(problem: &mut FlowProblem, discharge: f64, east: Condition) {
    let lattice = &problem.bed.lattice;
    let (size, spacing) = (lattice.size(), lattice.spacing);
    let end = |x: f64| vec![[Vec2::new(x, 0.0), Vec2::new(x, size.y)]];
    let west = Condition::Discharge { discharge: Series::constant(discharge * spacing), level: None };
    problem.forcing.reach = 0.3 * spacing;
    problem.forcing.boundaries.push(Boundary { pieces: end(0.0).into(), condition: west });
    problem.forcing.boundaries.push(Boundary { pieces: end(size.x).into(), condition: east });
    problem.dry_depth = 1e-4;
    problem.courant = 0.5;
}

/// (H/H_weir − 1) before a levee of one cell, H_weir = 3/2 (q²/g)^(1/3).
fn levee(constants: &Constants) -> f64 {
    const CREST: f64 = 3.0;
    const Q: f64 = 3.0;
    let spacing = 2.5;
    let mut problem = problem(40, 1, spacing, |place| if (place.x - 51.25).abs() < 1.0 { CREST } else { 0.0 });
    open(&mut problem, Q, Condition::Free);
    let head = 1.5 * (Q * Q / problem.gravity).cbrt();
    for cell in 0..20 {
        problem.initial_depth[cell] = CREST + head;
    }
    let depth = depths_at(problem, constants, 120.0)[10];
    let found = depth + 0.5 * (Q / depth).powi(2) / 9.81 - CREST;
    (found / head - 1.0).abs()
}

/// Mean of |d/d_n − 1| on a slope with a drop of 0.5, 0.75 ... 1.5 spacings at each tenth cell, off the drops.
fn drops(constants: &Constants) -> f64 {
    const SLOPE: f64 = 0.1;
    const Q: f64 = 0.5;
    const N: f64 = 0.03;
    let drop = |k: usize| (0..=k / 10).map(|k| 0.25 * ((k % 5) + 2) as f64).sum::<f64>();
    let mut problem = problem(60, 1, 1.0, |place| -SLOPE * place.x - drop(place.x as usize));
    problem.bed.manning.fill(N);
    open(&mut problem, Q, Condition::NormalDepth { slope: SLOPE });
    let normal = (Q * N / SLOPE.sqrt()).powf(0.6);
    let depths = depths_at(problem, constants, 60.0);
    depths[5..55].iter().map(|depth| (depth / normal - 1.0).abs()).sum::<f64>() / 50.0
}

/// J_1 by its integral.
fn bessel(x: f64) -> f64 {
    let steps = 200;
    let value = |k: usize| {
        let angle = std::f64::consts::PI * (k as f64 + 0.5) / steps as f64;
        (angle - x * angle.sin()).cos()
    };
    (0..steps).map(value).sum::<f64>() / steps as f64
}

fn round_basin(constants: &Constants) -> f64 {
    /// The first zero of J_1′.
    const ROOT: f64 = 1.841_183_781;
    const HEIGHT: f64 = 0.01;
    let (cells, radius, depth) = (22, 10.0, 1.0);
    let middle = Vec2::new(11.05, 10.9);
    let mode = |place: Vec2| {
        let offset = place - middle;
        if offset.norm() > 0.0 { bessel(ROOT / radius * offset.norm()) * offset.x / offset.norm() } else { 0.0 }
    };
    let is_inside = |place: Vec2| (place - middle).norm() < radius;
    let mut problem = problem(cells, cells, 1.0, |place| if is_inside(place) { 0.0 } else { f64::NAN });
    problem.courant = 0.5;
    let lattice = problem.bed.lattice.clone();
    let inside: Vec<usize> = (0..lattice.len()).filter(|&cell| is_inside(lattice.centre(cell))).collect();
    for &cell in &inside {
        problem.initial_depth[cell] = depth + HEIGHT * mode(lattice.centre(cell));
    }
    let period = 2.0 * std::f64::consts::PI * radius / (ROOT * (problem.gravity * depth).sqrt());
    let found = depths_at(problem, constants, period);
    let error = |&cell: &usize| (found[cell] - depth - HEIGHT * mode(lattice.centre(cell))).abs();
    inside.iter().map(error).sum::<f64>() / inside.len() as f64 / HEIGHT
}

/// Mean of |d/d_n − 1| along a channel of 120 m by 60 m, turned by an angle (degrees) on cells of 5 m, from its inlet to its outlet.
fn channel(degrees: f64, constants: &Constants) -> f64 {
    const SLOPE: f64 = 0.005;
    const SPACING: f64 = 5.0;
    let middle = Vec2::new(80.0, 80.0);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let own = |place: Vec2| {
        let offset = place - middle;
        Vec2::new(cos * offset.x + sin * offset.y, cos * offset.y - sin * offset.x)
    };
    let bed = |place: Vec2| {
        let own = own(place);
        if own.x.abs() < 60.0 && own.y.abs() < 30.0 { -SLOPE * own.x } else { f64::NAN }
    };
    let mut problem = problem(32, 32, SPACING, bed);
    problem.bed.is_sloped = true;
    problem.bed.manning.fill(0.03);
    (problem.dry_depth, problem.courant) = (1e-3, 0.5);
    problem.forcing.reach = 1.5 * SPACING;
    let end = |x: f64| vec![[28.0, -28.0].map(|y| middle + Vec2::new(cos * x - sin * y, sin * x + cos * y))];
    let discharge = Condition::Discharge { discharge: Series::constant(60.0), level: None };
    problem.forcing.boundaries.push(Boundary { pieces: end(-60.0).into(), condition: discharge });
    let slope = Condition::NormalDepth { slope: SLOPE };
    problem.forcing.boundaries.push(Boundary { pieces: end(60.0).into(), condition: slope });
    let uniform = (0.03 / SLOPE.sqrt()).powf(0.6);
    let lattice = problem.bed.lattice.clone();
    let inside: Vec<usize> = (0..lattice.len()).filter(|&cell| problem.bed.has_terrain(cell)).collect();
    inside.iter().for_each(|&cell| problem.initial_depth[cell] = uniform);
    let found = depths_at(problem, constants, 200.0);
    inside.iter().map(|&cell| (found[cell] / uniform - 1.0).abs()).sum::<f64>() / inside.len() as f64
}
