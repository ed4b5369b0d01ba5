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
    let height: f64 = a[1].parse().unwrap();
    let spacing: f64 = a[2].parse().unwrap();
    let length: f64 = a[3].parse().unwrap();
    let (middle, wavelength) = (70.0, 20.0);
    let surface = move |x: f64| {
        let along = (x - middle) / wavelength;
        let envelope = if f64::abs(along) < 1.5 { (std::f64::consts::PI * along / 3.0).cos().powi(2) } else { 0.0 };
        1.0 + height * envelope * (std::f64::consts::TAU * along).cos()
    };
    let columns = (length / spacing) as usize;
    let lattice = Lattice { origin: Vec2::ZERO, columns, rows: 1, spacing };
    let mut problem = FlowProblem {
        bed: BedParticles::from_elevation(lattice.clone(), vec![0.0; columns], 0.0), walls: vec![], open_edges: OpenEdges::default(),
        forcing: Forcing { reach: 0.3 * spacing, ..Forcing::default() }, initial_depth: (0..columns).map(|i| surface(lattice.centre(i).x)).collect(), gravity: 9.81, courant: 0.4, dry_depth: 1e-6 };
    let size = problem.bed.lattice.size();
    problem.forcing.boundaries.push(Boundary { segments: vec![[Vec2::new(size.x, 0.0), Vec2::new(size.x, size.y)]], condition: Condition::Free });
    let seeds: Vec<FluidSeed> = (0..columns).map(|i| { let d = problem.initial_depth[i]; FluidSeed { position: lattice.centre(i), volume: d * spacing, depth: d } }).collect();
    let mut s = LagrangianSolver::with_methods(problem, &seeds, MovingMethods::new(if a.len() > 4 { Integrator::Heun } else { Integrator::Leapfrog }, Stabilisation::TwoShocks), Dimension::One);
    let c = |d: f64| (9.81 * d).sqrt();
    {
        let p = &mut s.state_mut().particles;
        for i in 0..p.len() { p.velocity[i] = Vec2::new(2.0 * (c(surface(p.position[i].x)) - c(1.0)), 0.0); }
    }
    s.restart();
    let slowest = 3.0 * c(1.0 - 0.8 * height) - 2.0 * c(1.0);
    let end = 1.1 * (160.0 - middle + 1.5 * wavelength) / slowest;
    while s.time() < end - 1e-9 {
        let ch = s.choose_step();
        s.advance(ch.time_step.min(end - s.time())).unwrap();
    }
    let p = &s.state().particles;
    let mut k: Vec<usize> = (0..p.len()).filter(|&i| p.position[i].x < 160.0).collect();
    k.sort_by(|&i, &j| p.position[i].x.total_cmp(&p.position[j].x));
    // Outgoing and incoming parts
    let (mut w, mut wr, mut wl) = (0.0f64, 0.0f64, 0.0f64);
    for &i in &k {
        let dd = p.depth[i] - 1.0;
        w = w.max(dd.abs() / height);
        let u = p.velocity[i].x;
        wr = wr.max((0.5 * (dd + u / c(1.0))).abs() / height);
        wl = wl.max((0.5 * (dd - u / c(1.0))).abs() / height);
    }
    println!("end {end:.2} worst {:.2} % going east {:.2} west {:.2}", 100.0 * w, 100.0 * wr, 100.0 * wl);
    for (n, &i) in k.iter().enumerate() { if n % (k.len() / 16) == 0 { println!("{:.1} d {:.5} u {:.5}", p.position[i].x, p.depth[i] - 1.0, p.velocity[i].x); } }
}
