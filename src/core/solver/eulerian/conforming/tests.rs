use super::super::EulerianSolver;
use crate::lattice::{Lattice, NEIGHBOURS, Nest, Side};
use crate::math::Vec2;
use crate::partition::{Line, LineKind, Partition};
use crate::solver::testing::{run_steps, still_water};
use crate::solver::threads::in_pool;
use crate::solver::{FlowProblem, FlowSolver};

/// A line of a kind through some places.
fn line(kind: LineKind, points: &[Vec2]) -> Line {
    Line { points: points.to_vec(), is_closed: kind == LineKind::Outline, kind }
}

/// A lattice with cells that follow lines.
fn following((columns, rows): (usize, usize), spacing: f64, lines: &[Line]) -> Lattice {
    let lattice = Lattice::new(Vec2::ZERO, columns, rows, spacing);
    let made = Partition::new(&lattice, |_| true, lines);
    assert_eq!(made.faults, 0);
    let nest = Nest::of_one_level((columns, rows), spacing).with(made.on(&lattice));
    lattice.nested(nest)
}

/// Still water of a level (m) over a bed (m), both by place, within walls.
fn still(lattice: Lattice, bed: impl Fn(Vec2) -> f64, level: impl Fn(Vec2) -> f64) -> FlowProblem {
    let own = |value: &dyn Fn(Vec2) -> f64, none: f64| -> Vec<f64> {
        (0..lattice.len()).map(|i| if lattice.is_leaf(i) { value(lattice.centre(i)) } else { none }).collect()
    };
    let elevation = own(&bed, f64::NAN);
    let initial_depth = own(&|place| (level(place) - bed(place)).max(0.0), 0.0);
    let whole = still_water((lattice.columns, lattice.rows), lattice.spacing, &bed, &level);
    let bed = crate::bed::BedParticles { manning: vec![0.0; lattice.len()], elevation, lattice, ..whole.bed };
    FlowProblem { bed, initial_depth, ..whole }
}

/// A number from 0 to 1 that hangs on a place alone.
fn random(place: Vec2) -> f64 {
    let value = (place.x * 12.9898 + place.y * 78.233).sin() * 43758.5453;
    value - value.floor()
}

/// Places on a line at an angle (degrees) through a place.
fn ray(through: Vec2, degrees: f64, along: &[f64]) -> Vec<Vec2> {
    let way = Vec2::new(degrees.to_radians().cos(), degrees.to_radians().sin());
    along.iter().map(|share| through + way * *share).collect()
}

fn relative_volume_error(solver: &EulerianSolver) -> f64 {
    let ledger = solver.ledger();
    (ledger.stored - ledger.initial - ledger.inflow + ledger.outflow).abs() / ledger.initial
}

/// A wall, a bank and a house in a square of 200 m.
fn scene() -> Vec<Line> {
    let house = [(130.0, 40.0), (155.0, 50.0), (148.0, 70.0), (123.0, 60.0)].map(|(x, y)| Vec2::new(x, y));
    vec![
        line(LineKind::Wall, &ray(Vec2::new(60.0, 60.0), 23.0, &[-50.0, 60.0])),
        line(LineKind::Follow, &ray(Vec2::new(100.0, 140.0), -31.0, &[-120.0, 130.0])),
        line(LineKind::Outline, &house),
    ]
}

/// The cells beside each cell.
fn neighbours(lattice: &Lattice) -> Vec<Vec<usize>> {
    let mut beside = vec![Vec::new(); lattice.len()];
    for cell in (0..lattice.len()).filter(|&cell| lattice.is_leaf(cell)) {
        beside[cell].extend(
            NEIGHBOURS.iter().filter_map(|&step| lattice.neighbour(cell, step)).filter(|&other| lattice.is_leaf(other)),
        );
    }
    let Some(made) = lattice.conforming() else { return beside };
    let index = |side: Side| match side {
        Side::Cell(cell) => Some(made.place(cell)),
        Side::Lattice(square) => Some(square),
        Side::Wall | Side::Nothing => None,
    };
    for face in made.faces() {
        if let [Some(a), Some(b)] = face.sides.map(index) {
            beside[a].push(b);
            beside[b].push(a);
        }
    }
    beside
}

#[test]
fn water_rests_over_rough_ground_with_walls_houses_and_banks() {
    let middle = Vec2::new(100.0, 100.0);
    let bed = |place: Vec2| {
        let hill = (4.0 - (place - middle).norm() / 15.0).max(0.0);
        random(place) * 1.6 + hill + if place.y > 100.0 { 3.0 } else { 0.0 }
    };
    let mut problem = still(following((40, 40), 5.0, &scene()), bed, |_| 1.5);
    // Pits of the upper ground hold water, each to its own level.
    let lattice = problem.bed.lattice.clone();
    let mut pits = 0;
    for (cell, beside) in neighbours(&lattice).iter().enumerate() {
        let z = &problem.bed.elevation;
        let rim = beside.iter().map(|&other| z[other]).fold(f64::INFINITY, f64::min);
        if lattice.is_leaf(cell) && z[cell] > 1.5 && rim.is_finite() && rim > z[cell] {
            problem.initial_depth[cell] = 0.9 * (rim - z[cell]);
            pits += 1;
        }
    }
    assert!(pits > 100, "{pits}");
    let mut solver = EulerianSolver::new(problem);
    let fastest = run_steps(&mut solver, 1000);
    assert!(fastest < 1e-12, "{fastest:e} m/s");
    assert!(relative_volume_error(&solver) < 1e-13);
}

#[test]
fn a_dam_break_over_rough_ground_keeps_its_volume_and_its_head() {
    let bed = |place: Vec2| random(place) * 1.6;
    let level = |place: Vec2| if place.x < 90.0 { 4.0 } else { 0.0 };
    let mut solver = EulerianSolver::new(still(following((40, 40), 5.0, &scene()), bed, level));
    let fastest = run_steps(&mut solver, 300);
    println!("greatest speed {fastest} m/s after {} s", solver.time());
    // 2 √(g d) is that of the tip of a dry dam break.
    assert!(fastest < 2.0 * (9.81_f64 * 4.0).sqrt(), "{fastest} m/s");
    assert!(relative_volume_error(&solver) < 1e-12);
}

/// A stream between two lines at an angle, 10 cells wide; the greatest difference of depth (m) and velocity (m/s) after some steps from
/// what it was, in the middle of the lattice.
fn uniform_stream(kind: LineKind, degrees: f64, slope: f64, steps: usize) -> [f64; 2] {
    let (spacing, count) = (2.0, 60);
    let middle = Vec2::new(0.5 * spacing * count as f64, 0.5 * spacing * count as f64);
    let way = Vec2::new(degrees.to_radians().cos(), degrees.to_radians().sin());
    let beside = |side: f64| middle + way.perpendicular() * side;
    let lines = [-9.7, 9.7].map(|side| line(kind, &ray(beside(side), degrees, &[-120.0, 120.0])));
    let across = |place: Vec2| (place - middle).dot(way.perpendicular()).abs();
    let (depth, manning) = (0.8_f64, 0.03);
    let on_plane = |place: Vec2| 1.0 - slope * (place - middle).dot(way);
    let bed = |place: Vec2| on_plane(place) + if across(place) > 9.7 { 5.0 } else { 0.0 };
    let mut problem = still(following((count, count), spacing, &lines), bed, |place| on_plane(place) + depth);
    let speed = if slope > 0.0 { depth.powf(2.0 / 3.0) * slope.sqrt() / manning } else { 2.0 };
    if slope > 0.0 {
        problem.bed.manning.fill(manning);
    }
    let lattice = problem.bed.lattice.clone();
    let mut solver = EulerianSolver::new(problem);
    solver.set_velocity(|_| way * speed);
    in_pool(|| {
        for _ in 0..steps {
            let choice = solver.choose_step();
            solver.advance(choice.time_step).unwrap();
        }
    });
    let water = solver.water();
    let mut worst = [0.0_f64; 2];
    for cell in (0..lattice.len()).filter(|&cell| lattice.is_leaf(cell)) {
        let centre = lattice.centre(cell);
        // Nothing comes there from the ends: two cells a step.
        if (centre - middle).norm() > 25.0 || across(centre) > 9.7 {
            continue;
        }
        let here = water.at(cell);
        let velocity = Vec2::new(here.discharge_x, here.discharge_y) * (1.0 / here.depth);
        worst[0] = worst[0].max((here.depth - depth).abs());
        worst[1] = worst[1].max((velocity - way * speed).norm());
    }
    worst
}

#[test]
fn a_uniform_stream_along_lines_stays_as_it_is() {
    for kind in [LineKind::Wall, LineKind::Follow] {
        for degrees in [0.0, 5.0, 30.0, 45.0, 71.0] {
            for slope in [0.0, 0.002] {
                let [depth, speed] = uniform_stream(kind, degrees, slope, 4);
                println!("{kind:?} {degrees} {slope}: {depth:e} m, {speed:e} m/s");
                assert!(
                    depth < 1e-11 && speed < 1e-11,
                    "{kind:?} at {degrees}, slope {slope}: {depth:e} m, {speed:e} m/s"
                );
            }
        }
    }
}

/// MacDonald's channel of `MacDonald1997` between two walls 50 m apart at an angle (degrees) to the lattice: mean errors of depth and velocity, over
/// their means, in its middle 40 s after the exact state. 2 m²/s, n = 0.033, subcritical; nothing comes from the ends in that time.
fn channel_with_a_crest(degrees: f64, spacing: f64) -> [f64; 2] {
    const G: f64 = 9.81;
    let (q, n, length) = (2.0_f64, 0.033, 1000.0);
    let critical = (4.0 / G).cbrt();
    let depth_at = |s: f64| critical * (1.0 + 0.5 * (-16.0 * (s / length - 0.5_f64).powi(2)).exp());
    let slope = |s: f64| {
        let d = depth_at(s);
        let change = -16.0 * (s / length - 0.5) / length * (d - critical) * 2.0;
        (q * q / (G * d.powi(3)) - 1.0) * change - n * n * q * q / d.powf(10.0 / 3.0)
    };
    // The bed along the channel by the trapezoidal rule, in steps of 5 cm.
    let mut bed_along = vec![0.0];
    for k in 0..30_000 {
        let s = 0.05 * f64::from(k) - 250.0;
        bed_along.push(bed_along[k as usize] + 0.025 * (slope(s) + slope(s + 0.05)));
    }
    let bed_at = |s: f64| {
        let place = (s + 250.0) / 0.05;
        let k = (place.floor() as usize).min(29_999);
        bed_along[k] + (place - k as f64) * (bed_along[k + 1] - bed_along[k])
    };
    let way = Vec2::new(degrees.to_radians().cos(), degrees.to_radians().sin());
    let size = [way.x, way.y].map(|along| ((700.0 * along + 120.0) / spacing).ceil() as usize);
    let middle = Vec2::new(size[0] as f64, size[1] as f64) * (0.5 * spacing) + Vec2::new(0.31, 0.17) * spacing;
    let lines = [-25.0, 25.0]
        .map(|side| line(LineKind::Wall, &ray(middle + way.perpendicular() * side, degrees, &[-1000.0, 1000.0])));
    let along = |place: Vec2| 500.0 + (place - middle).dot(way);
    let mut problem = still(
        following((size[0], size[1]), spacing, &lines),
        |place| bed_at(along(place)),
        |place| bed_at(along(place)) + depth_at(along(place)),
    );
    problem.bed.manning.fill(n);
    let lattice = problem.bed.lattice.clone();
    let mut solver = EulerianSolver::new(problem);
    solver.set_velocity(|place| way * (q / depth_at(along(place))));
    in_pool(|| {
        while solver.time() < 40.0 {
            let step = solver.choose_step().time_step.min(40.0 - solver.time());
            solver.advance(step).unwrap();
        }
    });
    let water = solver.water();
    let (mut sums, mut area) = ([0.0; 4], 0.0);
    for cell in (0..lattice.len()).filter(|&cell| lattice.is_leaf(cell)) {
        let from = lattice.centre(cell) - middle;
        if from.dot(way).abs() > 60.0 || from.dot(way.perpendicular()).abs() > 25.0 {
            continue;
        }
        let (here, own) = (water.at(cell), lattice.area_of(cell));
        let (depth, speed) = (depth_at(500.0 + from.dot(way)), q / depth_at(500.0 + from.dot(way)));
        let velocity = Vec2::new(here.discharge_x, here.discharge_y) * (1.0 / here.depth);
        let found = [(here.depth - depth).abs(), (velocity - way * speed).norm(), depth, speed];
        sums.iter_mut().zip(found).for_each(|(sum, one)| *sum += own * one);
        area += own;
    }
    assert!((area / 6000.0 - 1.0).abs() < 0.1, "{area} m²");
    [sums[0] / sums[2], sums[1] / sums[3]]
}

#[test]
fn a_channel_with_a_crest_converges_at_any_angle() {
    for degrees in [0.0, 13.0, 30.0, 45.0] {
        let errors = [10.0, 5.0, 2.5].map(|spacing| channel_with_a_crest(degrees, spacing));
        let order = |q: usize| (errors[0][q] / errors[2][q]).log2() / 2.0;
        println!("{degrees}: {errors:?}, orders {:.2} {:.2}", order(0), order(1));
        assert!(order(0) >= 1.5 && order(1) >= 1.5, "{degrees}: {errors:?}");
    }
}

#[test]
#[expect(clippy::float_cmp, reason = "a uniform concentration stays what it is to the last bit")]
fn tracers_pass_cells_that_follow_lines() {
    let lattice = following((40, 40), 5.0, &scene());
    let bed = |place: Vec2| 0.01 * (200.0 - place.x) + 0.3 * random(place);
    let mut problem = still(lattice, bed, |place: Vec2| if place.x < 90.0 { 4.0 } else { 1.2 });
    let initial = (0..1600).map(|i| if (i / 40 + i / 3) % 2 == 0 { 4.0 } else { 1.0 }).collect();
    let third = crate::solver::Tracer { initial: vec![1.0 / 3.0; 1600], ..Default::default() };
    problem.forcing.tracers = vec![crate::solver::Tracer { initial, ..Default::default() }, third];
    let count = problem.bed.lattice.conforming().map_or(0, |made| made.cells().len());
    let mut solver = EulerianSolver::new(problem);
    run_steps(&mut solver, 150);
    assert!(count > 30, "{count} cells");
    for ledger in solver.tracers() {
        assert!(ledger.relative_error().abs() < 1e-12, "{ledger:?}");
    }
    let water = solver.water();
    for row in 0..water.lattice.all_rows() {
        let (depth, checked, uniform) =
            (water.rows.row(row).depth, water.rows.concentration(0, row), water.rows.concentration(1, row));
        for column in (0..depth.len()).filter(|&column| depth[column] > 0.0) {
            assert!((1.0..=4.0).contains(&checked[column]), "{row} {column}: {}", checked[column]);
            assert!(uniform[column] == 1.0 / 3.0, "{row} {column}: {}", uniform[column]);
        }
    }
}
