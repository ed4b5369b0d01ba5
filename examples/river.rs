use floodsim::solver::*;
use floodsim::bed::BedParticles;
use floodsim::lattice::Lattice;
use floodsim::math::Vec2;
use floodsim::solver::lagrangian::LagrangianSolver;
use floodsim::scenario::methods::Integrator;
use std::io::Write;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let kind = a[1].as_str();
    let spacing: f64 = a[2].parse().unwrap();
    let ends: Vec<f64> = a[3].split(',').map(|x| x.parse().unwrap()).collect();
    let out = &a[4];
    let (lx, ly) = (400.0, if kind == "valley" { 80.0 } else { 40.0 });
    let slope: f64 = match kind { "fast" => 0.02, "valley" => 0.005, _ => 0.001 };
    let n: f64 = 0.03;
    let bed = |p: Vec2| -slope * p.x + if kind == "valley" { 0.004 * (p.y - 40.0 - 8.0 * (p.x / 60.0).sin()).powi(2) } else { 0.0 };
    let (columns, rows) = ((lx / spacing) as usize, (ly / spacing) as usize);
    let lattice = Lattice { origin: Vec2::ZERO, columns, rows, spacing };
    let elevation: Vec<f64> = (0..lattice.len()).map(|i| bed(lattice.centre(i))).collect();
    let velocity = slope.sqrt() / n;
    let fast = kind == "fast";
    let mut problem = FlowProblem {
        bed: BedParticles::from_elevation(lattice.clone(), elevation, n), walls: vec![], open_edges: OpenEdges::default(),
        forcing: Forcing { reach: 0.3 * spacing, ..Forcing::default() }, initial_depth: vec![0.0; columns * rows], gravity: 9.81, courant: 0.4, dry_depth: 1e-3 };
    floodsim::bed::derive_shape(&mut problem.bed);
    let size = problem.bed.lattice.size();
    let q = if kind == "valley" { 60.0 } else { velocity * ly };
    for (x, c) in [(0.0, Condition::Discharge { discharge: Series::constant(q), level: fast.then(|| Series::constant(1.0)) }), (size.x, Condition::NormalDepth { slope })] {
        problem.forcing.boundaries.push(Boundary { segments: vec![[Vec2::new(x, 0.0), Vec2::new(x, size.y)]], condition: c });
    }
    if a.len() > 5 {
        let mut problem = problem.clone();
        problem.courant = 0.5;
        let mut s = EulerianSolver::new(problem);
        for (k, end) in ends.iter().enumerate() {
            while s.time() < end - 1e-9 { let c = s.choose_step(); s.advance(c.time_step.min(end - s.time())).unwrap(); }
            println!("resting {end} {:?}", s.ledger());
            let w = s.water();
            let mut f = std::fs::File::create(format!("{out}_{k}_rest.csv")).unwrap();
            for i in 0..lattice.len() { writeln!(f, "{},{},{},{}", lattice.centre(i).x, lattice.centre(i).y, w.depth[i], w.discharge_x[i]).unwrap(); }
        }
    }
    let mut s = LagrangianSolver::new(problem, vec![], Integrator::Leapfrog);
    let start = std::time::Instant::now();
    for (k, end) in ends.iter().enumerate() {
        let mut fastest = 0.0f64;
        while s.time() < end - 1e-9 {
            let c = s.choose_step();
            fastest = fastest.max(c.max_speed);
            s.advance(c.time_step.min(end - s.time())).unwrap();
        }
        let p = s.state().particles.clone();
        let mut f = std::fs::File::create(format!("{out}_{k}.csv")).unwrap();
        for i in 0..p.len() { writeln!(f, "{},{},{},{},{},{},{}", p.position[i].x, p.position[i].y, p.depth[i], p.velocity[i].x, p.velocity[i].y, p.volume[i], s.state().bed_at(p.position[i]).elevation).unwrap(); }
        let (mut a, mut b, mut e) = ((0.0f64, 0.0f64), (0.0f64, 0.0f64), (0.0f64, 0.0f64));
        for i in 0..p.len() {
            let x = p.position[i].x;
            let dev = ((p.depth[i] - 1.0).abs(), (p.velocity[i].x / velocity - 1.0).abs());
            let t = if x < 30.0 { &mut a } else if x < 370.0 { &mut b } else { &mut e };
            *t = (t.0.max(dev.0), t.1.max(dev.1));
        }
        let count = p.len();
        let l = s.ledger();
        let on_grid = s.water().depth.iter().sum::<f64>() * spacing * spacing;
        print!("grid off {:.1e} ", on_grid / s.ledger().stored - 1.0);
        println!("t {end} n {count} steps {} max speed {fastest:.2} in {:.6} of {:.6} out {:.2} err {:.1e}; dev inlet {:.2e} {:.2e} middle {:.2e} {:.2e} outlet {:.2e} {:.2e}; wall {:.1}", s.steps(), l.inflow, q * end, l.outflow, l.relative_error(), a.0, a.1, b.0, b.1, e.0, e.1, start.elapsed().as_secs_f64());
        let w = s.water();
        let mut f = std::fs::File::create(format!("{out}_{k}_grid.csv")).unwrap();
        for i in 0..lattice.len() { writeln!(f, "{},{},{},{}", lattice.centre(i).x, lattice.centre(i).y, w.depth[i], w.discharge_x[i]).unwrap(); }
    }
}
