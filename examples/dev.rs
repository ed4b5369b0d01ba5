use floodsim::solver::*;
use floodsim::bed::BedParticles;
use floodsim::lattice::Lattice;
use floodsim::math::Vec2;
use floodsim::solver::lagrangian::LagrangianSolver;
use floodsim::solver::moving::MovingMethods;
use floodsim::physics::dimension::Dimension;
use floodsim::scenario::methods::{Integrator, Stabilisation};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let slope: f64 = a[1].parse().unwrap();
    let spacing: f64 = a[2].parse().unwrap();
    let end: f64 = a[3].parse().unwrap();
    let n: f64 = 0.03;
    let depth: f64 = 1.0;
    let velocity = slope.sqrt() / n;
    let fast = velocity > 9.81f64.sqrt();
    let columns = (400.0 / spacing) as usize;
    let lattice = Lattice { origin: Vec2::ZERO, columns, rows: 1, spacing };
    let elevation: Vec<f64> = (0..lattice.len()).map(|i| -slope * lattice.centre(i).x).collect();
    let mut problem = FlowProblem {
        bed: BedParticles::from_elevation(lattice, elevation, n), walls: vec![], open_edges: OpenEdges::default(),
        forcing: Forcing { reach: 0.3 * spacing, ..Forcing::default() }, initial_depth: vec![0.0; columns], gravity: 9.81, courant: 0.4, dry_depth: 1e-3 };
    floodsim::bed::derive_shape(&mut problem.bed);
    let size = problem.bed.lattice.size();
    for (x, c) in [(0.0, Condition::Discharge { discharge: Series::constant(velocity * depth * spacing), level: fast.then(|| Series::constant(depth)) }), (size.x, Condition::NormalDepth { slope })] {
        problem.forcing.boundaries.push(Boundary { segments: vec![[Vec2::new(x, 0.0), Vec2::new(x, size.y)]], condition: c });
    }
    let mut s = LagrangianSolver::with_methods(problem, &[], MovingMethods::new(Integrator::Leapfrog, Stabilisation::TwoShocks), Dimension::One);
    while s.time() < end {
        let c = s.choose_step();
        s.advance(c.time_step.min(end - s.time())).unwrap();
        if s.steps() % 100 == 0 {
            let p = &s.state().particles;
            let (mut a, mut b, mut e) = (0.0f64, 0.0f64, 0.0f64);
            for i in 0..p.len() {
                let x = p.position[i].x;
                let dev = (p.depth[i] / depth - 1.0).abs();
                if x < 30.0 { a = a.max(dev) } else if x < 370.0 { b = b.max(dev) } else { e = e.max(dev) }
            }
            println!("t {:.1} inlet {a:.2e} middle {b:.2e} outlet {e:.2e}", s.time());
        }
    }
    let w = s.state();
    let mut k: Vec<usize> = (0..w.particles.len()).collect();
    k.sort_by(|&i, &j| w.particles.position[i].x.total_cmp(&w.particles.position[j].x));
    let mut last = 0.0;
    for i in k {
        let p = &w.particles;
        println!("{:8.3} {:7.3} d {:.5} u {:.5} V {:.4} A {:.4}", p.position[i].x, p.position[i].x - last, p.depth[i] / depth, p.velocity[i].x / velocity, p.volume[i], p.volume[i] / p.depth[i]);
        last = p.position[i].x;
    }
    println!("{:?} {:e}", s.ledger(), s.ledger().relative_error());
}
