//! Edges and banks oblique to the lattice.

use super::*;

/// Half a hump at a wall, which mirrors it, 60 m before the eastern edge of a basin, or of one that is longer by so many cells of 1 m: the level above rest (m) 2 m before the place of
/// that edge, in each step of 0.1 s for 45 s, at the angles (degrees) at which the wave comes to it.
fn hump_before_an_edge(height: f64, longer: usize, condition: Condition, angles: &[f64]) -> Vec<Vec<f64>> {
    let (before, rows) = (90.0, 140);
    let hump = |place: Vec2| 1.0 + height * (-(place - Vec2::new(before, 0.0)).norm_squared() / 25.0).exp();
    let columns = 150 + longer;
    let mut problem = problem((columns, rows), 1.0, |_| 0.0, hump);
    let side = |x: f64| vec![[Vec2::new(x, 0.0), Vec2::new(x, rows as f64)]];
    let edges = [(0.0, Condition::Free), (columns as f64, condition)];
    let boundary = |(x, condition)| Boundary { pieces: side(x).into(), condition };
    problem.forcing.boundaries.extend(edges.map(boundary));
    let cells: Vec<usize> =
        angles.iter().map(|angle| (60.0 * angle.to_radians().tan()) as usize * columns + 147).collect();
    let mut solver = EulerianSolver::new(problem);
    (1..=450)
        .map(|moment| {
            run_until(&mut solver, 0.1 * f64::from(moment));
            let water = solver.water();
            cells.iter().map(|&cell| water.at(cell).depth - 1.0).collect()
        })
        .collect()
}

#[test]
fn waves_leave_at_all_angles() {
    let angles = [0.0, 20.0, 36.0, 47.0, 61.0];
    let heights = [0.01, 0.3];
    let edges = [(60, Condition::Free), (0, Condition::Free), (0, Condition::Stage(Series::constant(1.0)))];
    let runs: Vec<_> = heights.into_iter().flat_map(|height| edges.iter().map(move |edge| (height, edge))).collect();
    let levels: Vec<_> = runs
        .into_par_iter()
        .map(|(height, (longer, condition))| hump_before_an_edge(height, *longer, condition.clone(), &angles))
        .collect();
    for (height, levels) in heights.into_iter().zip(levels.chunks_exact(edges.len())) {
        let endless = &levels[0];
        // Of the wave as it arrives.
        let share = |with_edge: &[Vec<f64>]| {
            let greatest = |of: &dyn Fn(usize) -> f64| (0..endless.len()).map(of).fold(0.0, f64::max);
            let back =
                |k: usize| greatest(&|i| (with_edge[i][k] - endless[i][k]).abs()) / greatest(&|i| endless[i][k].abs());
            std::array::from_fn::<f64, 5, _>(back)
        };
        let (free, held) = (share(&levels[1]), share(&levels[2]));
        for ((angle, free), held) in angles.iter().zip(free).zip(held) {
            println!(
                "hump of {height} m at {angle} degrees: {:.1} % comes back, {:.0} % from held levels",
                100.0 * free,
                100.0 * held
            );
            assert!(free < 0.065 && held > 10.0 * free, "hump of {height} m at {angle} degrees: {free}, {held}");
        }
    }
}

#[test]
fn a_hydrograph_over_a_ragged_edge_is_booked_and_both_directions_are_alike() {
    // A plane that falls to the north-east, without terrain in its south-western corner; the water comes in along that.
    let corner = |place: Vec2| place.x < 30.0 && place.y < 30.0;
    let bed = |place: Vec2| if corner(place) { f64::NAN } else { 10.0 - 0.01 * (place.x + place.y) };
    let mut problem = problem((24, 24), 5.0, bed, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    let at = |x: f64, y: f64| Vec2::new(x, y);
    let notch = vec![[at(30.0, 0.0), at(30.0, 30.0)], [at(30.0, 30.0), at(0.0, 30.0)]];
    let far = vec![[at(120.0, 0.0), at(120.0, 120.0)], [at(120.0, 120.0), at(0.0, 120.0)]];
    let discharge = Condition::Discharge { discharge: Series::constant(5.0), level: None };
    problem.forcing.boundaries.push(Boundary { pieces: notch.into(), condition: discharge });
    problem.forcing.boundaries.push(Boundary { pieces: far.into(), condition: Condition::NormalDepth { slope: 0.01 } });
    problem.forcing.rain = Some(Rain::Uniform(Series::constant(1e-5)));
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 600.0);
    let ledger = solver.ledger();
    let supplied = 600.0 * (5.0 + 1e-5 * 25.0 * (24.0 * 24.0 - 36.0));
    assert!((ledger.inflow / supplied - 1.0).abs() < 1e-12, "{} of {supplied} m³", ledger.inflow);
    assert!(ledger.relative_error().abs() < 1e-12 && ledger.outflow > 0.1 * supplied, "{ledger:?}");
    let depths = solver.water().depths();
    for row in 0..24 {
        for column in 0..row {
            let (here, mirrored) = (depths[24 * row + column], depths[24 * column + row]);
            assert!((here - mirrored).abs() < 1e-9, "({column}, {row}): {here} and {mirrored} m");
        }
    }
}

/// A channel of 200 m by 60 m, turned by an angle (degrees) on the lattice, in which uniform flow of 1 m²/s would be 0.6 m deep: depth and
/// unit discharge along it, in six strips from bank to bank, at a distance (m) from its middle.
fn askew(degrees: f64, spacing: f64, distance: f64) -> [(f64, f64); 6] {
    const SLOPE: f64 = 0.005;
    let (size, middle) = ((240.0 / spacing) as usize, Vec2::new(120.0, 120.0));
    let (sin, cos) = degrees.to_radians().sin_cos();
    let own = |place: Vec2| {
        let offset = place - middle;
        Vec2::new(cos * offset.x + sin * offset.y, cos * offset.y - sin * offset.x)
    };
    let bed = |place: Vec2| {
        let own = own(place);
        if own.x.abs() < 100.0 && own.y.abs() < 30.0 { -SLOPE * own.x } else { f64::NAN }
    };
    let mut problem = problem((size, size), spacing, bed, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    problem.forcing.reach = 1.5 * spacing;
    let end = |x: f64| vec![[28.0, -28.0].map(|y| middle + Vec2::new(cos * x - sin * y, sin * x + cos * y))];
    let discharge = Condition::Discharge { discharge: Series::constant(60.0), level: None };
    problem.forcing.boundaries.push(Boundary { pieces: end(-100.0).into(), condition: discharge });
    problem
        .forcing
        .boundaries
        .push(Boundary { pieces: end(100.0).into(), condition: Condition::NormalDepth { slope: SLOPE } });
    let lattice = problem.bed.lattice.clone();
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 900.0);
    let water = solver.water();
    [-25.0, -15.0, -5.0, 5.0, 15.0, 25.0].map(|across| {
        let is_there = |&cell: &usize| {
            let own = own(lattice.centre(cell));
            (own.x - distance).abs() <= 5.0 && (own.y - across).abs() <= 5.0
        };
        let cells: Vec<_> = (0..lattice.len()).filter(is_there).map(|cell| water.at(cell)).collect();
        let mean = |value: &dyn Fn(&crate::lattice::WaterInCell) -> f64| {
            cells.iter().map(value).sum::<f64>() / cells.len() as f64
        };
        (mean(&|water| water.depth), mean(&|water| cos * water.discharge_x + sin * water.discharge_y))
    })
}

#[test]
fn water_enters_and_leaves_an_edge_askew_to_the_lattice_over_its_whole_width() {
    let uniform = (0.03 / 0.005_f64.sqrt()).powf(0.6);
    for degrees in [0.0, 10.0, 30.0] {
        let (inlet, outlet) = (askew(degrees, 5.0, -80.0), askew(degrees, 5.0, 90.0));
        println!("{degrees} degrees: {inlet:.2?}, {outlet:.2?}");
        let tolerance = if degrees > 0.0 { 0.06 } else { 1e-3 };
        for (_, discharge) in &inlet[1..5] {
            assert!((discharge - 1.0).abs() < 1.5 * tolerance, "{degrees} degrees: {discharge} m²/s");
        }
        for (depth, _) in &outlet[1..5] {
            assert!((depth / uniform - 1.0).abs() < tolerance, "{degrees} degrees: {depth} m");
        }
    }
}

/// Mean depth (m) over the middle 60 % of the width, 150 to 250 m from the inlet, of 1 m deep uniform flow on a slope between banks that rise by
/// `bank` (m) for each metre, or where there is none between walls, in a channel of a width (m) at the bottom, turned by an angle (degrees) on cells of 2 m.
fn between_banks(degrees: f64, slope: f64, bank: Option<f64>, width: f64) -> f64 {
    const SPACING: f64 = 2.0;
    let (sin, cos) = degrees.to_radians().sin_cos();
    let own = |place: Vec2| {
        let offset = place - Vec2::new(0.0, 40.0);
        Vec2::new(cos * offset.x + sin * offset.y, cos * offset.y - sin * offset.x)
    };
    let bed = |place: Vec2| {
        let own = own(place);
        let beside = (own.y.abs() - 0.5 * width).max(0.0);
        let above = if beside > 0.0 { bank.map_or(f64::NAN, |bank| (bank * beside).min(6.0)) } else { 0.0 };
        -slope * own.x + above
    };
    let rows = (80.0 + 300.0 * sin / cos) / SPACING;
    let mut problem = problem((150, rows as usize), SPACING, bed, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    // What the bottom and both banks carry.
    let discharge = Series::constant((width + bank.map_or(0.0, |bank| 2.0 * 0.375 / bank)) * slope.sqrt() / 0.03);
    open(&mut problem, true, Condition::Discharge { discharge, level: None });
    open(&mut problem, false, Condition::NormalDepth { slope });
    let lattice = problem.bed.lattice.clone();
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 300.0 * (0.02 / slope).sqrt());
    let water = solver.water();
    let is_there = |&cell: &usize| {
        let own = own(lattice.centre(cell));
        own.y.abs() < 0.3 * width && (150.0..250.0).contains(&own.x)
    };
    let depths: Vec<f64> = (0..lattice.len()).filter(is_there).map(|cell| water.at(cell).depth).collect();
    depths.iter().sum::<f64>() / depths.len() as f64
}

#[test]
fn banks_askew_to_the_lattice_hold_water_up_as_told() {
    // Angle, slope, rise of the banks, and by how much the water is too deep: what docs/theory.md tells.
    let upright = Some(f64::INFINITY);
    let channels = [
        (0.0, 0.02, upright, 0.0),
        (0.0, 0.02, Some(0.5), 0.0),
        (10.0, 0.02, Some(0.5), 0.012),
        (30.0, 0.02, Some(0.5), 0.022),
        (10.0, 0.02, upright, 0.092),
        (30.0, 0.02, upright, 0.106),
    ];
    let depths = channels.par_iter().map(|&(degrees, slope, bank, _)| between_banks(degrees, slope, bank, 40.0));
    for ((degrees, slope, bank, documented), depth) in channels.into_iter().zip(depths.collect::<Vec<_>>()) {
        println!("{degrees} degrees, slope {slope}, banks {bank:?}: {depth} m");
        assert!(
            (depth - 1.0 - documented).abs() < 0.005,
            "{degrees} degrees, slope {slope}, banks {bank:?}: {depth} m"
        );
    }
}

#[test]
fn walls_askew_to_the_lattice_do_not_hold_water_up() {
    // Angle, width and slope; at 45° the cells between the walls are 41.0 and 12.7 m wide.
    let channels = [
        (0.0, 40.0, 0.005, 0.0),
        (5.0, 40.0, 0.005, 0.0),
        (10.0, 40.0, 0.005, 0.0),
        (20.0, 40.0, 0.005, 0.0),
        (30.0, 40.0, 0.005, 0.0),
        (30.0, 40.0, 0.02, 0.0),
        (45.0, 40.0, 0.005, (40.0_f64 / 41.0).powf(0.6) - 1.0),
        (10.0, 12.0, 0.005, 0.0),
        (20.0, 12.0, 0.005, 0.0),
        (30.0, 12.0, 0.005, 0.0),
        (40.0, 12.0, 0.005, 0.0),
        (45.0, 12.0, 0.005, (12.0_f64 / 12.7).powf(0.6) - 1.0),
    ];
    let depths = channels.par_iter().map(|&(degrees, width, slope, _)| between_banks(degrees, slope, None, width));
    for ((degrees, width, slope, documented), depth) in channels.into_iter().zip(depths.collect::<Vec<_>>()) {
        println!("{degrees} degrees, {width} m wide, slope {slope}: {depth:.4} m");
        assert!(
            (depth - 1.0 - documented).abs() < 0.012,
            "{degrees} degrees, {width} m wide, slope {slope}: {depth} m"
        );
    }
}

#[test]
fn what_leaves_over_an_edge_inside_the_lattice_has_left() {
    let conditions = [Some(Condition::NormalDepth { slope: 0.02 }), Some(Condition::Free), None];
    for condition in conditions {
        let mut problem = problem((40, 9), 2.5, |p| 0.02 * (100.0 - p.x), |p| if p.x < 40.0 { 3.0 } else { -1.0 });
        problem.bed.manning.fill(0.04);
        problem.dry_depth = 1e-3;
        // The terrain ends before the last two columns.
        for cell in (0..360).filter(|cell| cell % 40 > 37) {
            problem.bed.elevation[cell] = f64::NAN;
            problem.initial_depth[cell] = 0.0;
        }
        let edge = vec![[Vec2::new(95.0, 0.0), Vec2::new(95.0, 22.5)]];
        match condition {
            Some(condition) => problem.forcing.boundaries.push(Boundary { pieces: edge.into(), condition }),
            None => problem.open_edges = OpenEdges { pieces: edge.into(), reach: 0.5, outline: None },
        }
        let mut solver = EulerianSolver::new(problem);
        run_until(&mut solver, 60.0);
        let ledger = solver.ledger();
        assert!(ledger.outflow > 0.1 * ledger.initial, "{ledger:?}");
        assert!(ledger.relative_error().abs() < 1e-12, "{ledger:?}");
        assert!((0..360).filter(|cell| cell % 40 > 37).all(|cell| solver.water().at(cell).depth <= 0.0));
    }
}
