//! `cargo perf`: kernels, search, gridding, the phases of both motions, and a made dam break from end to end.
//!
//! One thread, processor time; phases are timed by the watch of the core itself, so that a bench sees what a run sees. On a shared
//! machine figures scatter by a tenth and more: compare ratios within one run, and instruction counts (`scripts/instructions.sh`)
//! between commits. Throughput counts evaluations of the rates of one particle, but for the kernels, where it counts calls.

mod scene;

use std::cell::{LazyCell, RefCell};
use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::{Measurement, ValueFormatter, WallTime};
use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput};
use floodsim::boundary::Walls;
use floodsim::gridding::Gridder;
use floodsim::math::Vec2;
use floodsim::neighbours::{CellGrid, Found};
use floodsim::particles::FluidParticles;
use floodsim::physics::dimension::Dimension;
use floodsim::physics::flux::{FaceSolver, LaxFriedrichs, Side, TwoShocks, TwoWaves};
use floodsim::scenario::methods::Kernel;
use floodsim::solver::FlowSolver;
use floodsim::solver::phases::processor_seconds;
use floodsim::solver::variational::ChosenKernel;
use scene::Motion;

/// Particles of the benches of single phases.
const PARTICLES: usize = 100_000;
/// Numbers of particles of the benches from end to end.
const SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];
/// Steps before a measurement: the dam has broken and the particles have been brought into order once.
const FIRST_STEPS: usize = 10;
/// Calls of a kernel or a flux in one go.
const CALLS: usize = 1024;

/// Processor time of the whole program in place of the time on the wall.
struct ProcessorTime;

impl Measurement for ProcessorTime {
    type Intermediate = f64;
    type Value = Duration;

    fn start(&self) -> f64 {
        processor_seconds()
    }

    fn end(&self, start: f64) -> Duration {
        Duration::from_secs_f64((processor_seconds() - start).max(0.0))
    }

    fn add(&self, one: &Duration, other: &Duration) -> Duration {
        *one + *other
    }

    fn zero(&self) -> Duration {
        Duration::ZERO
    }

    fn to_f64(&self, value: &Duration) -> f64 {
        WallTime.to_f64(value)
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        WallTime.formatter()
    }
}

/// Solves the faces between neighbours in a row.
type Solve = fn(&[Side]) -> f64;

/// Kernels and Riemann solvers, call by call.
fn physics(criterion: &mut Criterion<ProcessorTime>) {
    let mut group = criterion.benchmark_group("physics");
    group.throughput(Throughput::Elements(CALLS as u64));
    let radii: Vec<f64> = (0..CALLS).map(|k| 2.0 * k as f64 / CALLS as f64).collect();
    for kernel in Kernel::ALL {
        let chosen = ChosenKernel::new(*kernel, Dimension::Two);
        group.bench_function(BenchmarkId::new("kernel", kernel.name()), |bencher| {
            bencher.iter(|| black_box(&radii).iter().map(|&r| chosen.value(r, 1.0)).sum::<f64>());
        });
    }
    let side = |k: usize| {
        let d = 1.0 + 0.5 * (k as f64).sin();
        Side { d, c: (9.81 * d).sqrt(), u: (1.7 * k as f64).cos() }
    };
    let sides: Vec<Side> = (0..=CALLS).map(side).collect();
    fn solve<F: FaceSolver>(sides: &[Side]) -> f64 {
        sides.windows(2).map(|pair| F::star(pair[0], pair[1], 9.81).0).sum()
    }
    let fluxes: [(&str, Solve); 3] = [
        ("two_waves", solve::<TwoWaves>),
        ("two_shocks", solve::<TwoShocks>),
        ("lax_friedrichs", solve::<LaxFriedrichs>),
    ];
    for (name, solve) in fluxes {
        group.bench_function(BenchmarkId::new("face", name), |bencher| bencher.iter(|| solve(black_box(&sides))));
    }
    group.finish();
}

/// The search for neighbours on a disordered lattice, and the gridding of particles.
fn search_and_gridding(criterion: &mut Criterion<ProcessorTime>) {
    let mut group = criterion.benchmark_group("particles");
    group.sampling_mode(SamplingMode::Flat).throughput(Throughput::Elements(PARTICLES as u64));
    let positions = scene::disordered(PARTICLES);
    let supports = vec![2.8; positions.len()];
    let mut grid = CellGrid::default();
    group.bench_function("cell_grid_build", |bencher| bencher.iter(|| grid.build(&positions, &supports)));
    let mut found = Found::default();
    group.bench_function("cell_grid_within", |bencher| {
        let mut seen = |place: &Vec2| grid.within(*place, 2.8, &mut found).len();
        bencher.iter(|| positions.iter().map(&mut seen).sum::<usize>());
    });
    let problem = scene::dam_break(PARTICLES);
    let particles = FluidParticles::from_seeds(&scene::seeds(&problem));
    let mut gridder = Gridder::new(&problem.bed.lattice, Dimension::Two);
    group.bench_function("gridding", |bencher| {
        bencher.iter(|| gridder.grid(&problem.bed, &Walls::new(Vec::new(), 1.0), &particles).spans.len());
    });
    group.finish();
}

/// Each phase of both motions.
fn phases(criterion: &mut Criterion<ProcessorTime>) {
    for motion in Motion::ALL {
        let mut solver = scene::solver(motion, PARTICLES);
        scene::steps(solver.as_mut(), FIRST_STEPS);
        let names: Vec<&'static str> = solver.phases().times().iter().map(|(name, _)| *name).collect();
        let solver = RefCell::new(solver);
        let mut group = criterion.benchmark_group(format!("phases_{}", motion.name()));
        group.sampling_mode(SamplingMode::Flat).throughput(Throughput::Elements(PARTICLES as u64));
        for name in names {
            group.bench_function(name, |bencher| {
                bencher.iter_custom(|count| per_evaluation(solver.borrow_mut().as_mut(), count, Some(name)));
            });
        }
        group.finish();
    }
}

/// The whole dam break at several sizes, gridding included.
fn end_to_end(criterion: &mut Criterion<ProcessorTime>) {
    for motion in Motion::ALL {
        let mut group = criterion.benchmark_group(format!("dam_break_{}", motion.name()));
        group.sampling_mode(SamplingMode::Flat);
        for particles in SIZES {
            // Built when it is first stepped: a bench that is filtered out costs nothing.
            let solver = LazyCell::new(|| {
                let mut solver = scene::solver(motion, particles);
                scene::steps(solver.as_mut(), FIRST_STEPS.min(10 * PARTICLES / particles));
                RefCell::new(solver)
            });
            group.throughput(Throughput::Elements(PARTICLES as u64)).bench_function(particles.to_string(), |bencher| {
                bencher.iter_custom(|count| per_evaluation(solver.borrow_mut().as_mut(), count, None));
            });
        }
        group.finish();
    }
}

/// Takes `count` steps; processor time of a phase, or of all, for `PARTICLES` evaluations a step.
fn per_evaluation(solver: &mut dyn FlowSolver, count: u64, phase: Option<&str>) -> Duration {
    let cost = scene::cost(solver, count as usize);
    let time = phase.map_or_else(|| cost.sum(), |name| cost.phase(name));
    let evaluations = PARTICLES as f64 * count as f64;
    // A phase that was not called, such as the sorting of every eighth step, takes no time; Criterion asks for more than none.
    Duration::from_secs_f64((time.cpu * evaluations / cost.evaluations as f64).max(1e-9))
}

fn main() {
    if let Err(cause) = rayon::ThreadPoolBuilder::new().num_threads(1).build_global() {
        panic!("the thread of the benches could not be started: {cause}");
    }
    let mut criterion = Criterion::default()
        .with_measurement(ProcessorTime)
        .without_plots()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800))
        .configure_from_args();
    physics(&mut criterion);
    search_and_gridding(&mut criterion);
    phases(&mut criterion);
    end_to_end(&mut criterion);
    criterion.final_summary();
}
