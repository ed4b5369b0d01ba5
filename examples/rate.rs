use floodsim::solver::*;
use floodsim::bed::BedParticles;
use floodsim::lattice::Lattice;
use floodsim::math::Vec2;
use floodsim::particles::FluidSeed;
use floodsim::solver::lagrangian::LagrangianSolver;
use floodsim::solver::moving::MovingMethods;
use floodsim::physics::dimension::Dimension;
use floodsim::scenario::methods::{Integrator, Stabilisation};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let end: f64 = a[1].parse().unwrap();
    let rows: usize = a[2].parse().unwrap();
    let d0: f64 = a[3].parse().unwrap();
    let kind = a[4].as_str();
    let lattice = Lattice { origin: Vec2::ZERO, columns: 30, rows, spacing: 5.0 };
    let mut problem = FlowProblem {
        bed: BedParticles::from_elevation(lattice.clone(), vec![0.0; lattice.len()], 0.03), walls: vec![], open_edges: OpenEdges::default(),
        forcing: Forcing { reach: 1.5, ..Forcing::default() }, initial_depth: vec![d0; lattice.len()], gravity: 9.81, courant: 0.4, dry_depth: 1e-6 };
    floodsim::bed::derive_shape(&mut problem.bed);
    let size = problem.bed.lattice.size();
    let q = 0.15 * size.y;
    let k = size.y / 40.0;
    let c = match kind { "rating" => Condition::Rating(Rating::new(&[(0.5, 0.0), (1.0, 2.0 * k), (2.0, 10.0 * k)]).unwrap()), "normal" => Condition::NormalDepth { slope: 1e-5 }, _ => Condition::Stage(Series::constant(1.5)) };
    for (x, c) in [(0.0, Condition::Discharge { discharge: Series::constant(q), level: None }), (size.x, c)] {
        problem.forcing.boundaries.push(Boundary { segments: vec![[Vec2::new(x, 0.0), Vec2::new(x, size.y)]], condition: c });
    }
    let dimension = if rows == 1 { Dimension::One } else { Dimension::Two };
    let area = if rows == 1 { 5.0 } else { 25.0 };
    let seeds: Vec<FluidSeed> = (0..lattice.len()).map(|i| FluidSeed { position: lattice.centre(i), volume: d0 * area, depth: d0 }).collect();
    let mut s = LagrangianSolver::with_methods(problem, &seeds, MovingMethods::new(Integrator::Leapfrog, Stabilisation::TwoShocks), dimension);
    let mut last = s.ledger();
    for part in 1..=6 {
        let until = end * part as f64 / 6.0;
        while s.time() < until - 1e-9 { let c = s.choose_step(); s.advance(c.time_step.min(until - s.time())).unwrap(); }
        let l = s.ledger();
        println!("t {:.0} in {:.4} out {:.4} stored {:.2} particles {}", s.time(), (l.inflow - last.inflow) / (end / 6.0), (l.outflow - last.outflow) / (end / 6.0), l.stored, s.particles());
        last = l;
    }
    let p = &s.state().particles;
    // column means
    for col in (0..30).step_by(2) {
        let ix: Vec<usize> = (0..p.len()).filter(|&i| (p.position[i].x / 5.0) as usize / 2 == col / 2).collect();
        if ix.is_empty() { println!("{col} none"); continue; }
        let m = |f: &dyn Fn(usize) -> f64| ix.iter().map(|&i| f(i)).sum::<f64>() / ix.len() as f64;
        println!("x {:5.1} n {} carried {:.4} geometric {:.4} u {:.4} V {:.3}", (col as f64 + 1.0) * 5.0, ix.len(), m(&|i| p.depth[i]), ix.iter().map(|&i| p.volume[i]).sum::<f64>() / (2.0 * area * rows as f64), m(&|i| p.velocity[i].x), m(&|i| p.volume[i]));
    }
}
