//! The measurements behind docs/performance.md, one table each as CSV on stdout; `docs/performance/build.py` calls them.
//!
//! ```text
//! cargo bench --bench measure -- phases [PARTICLES]      processor time of each phase, one thread
//! cargo bench --bench measure -- sizes                   processor time against particles, one thread
//! cargo bench --bench measure -- threads [PARTICLES]     wall-clock and processor time on one thread and on two
//! cargo bench --bench measure -- memory MOTION PARTICLES [CELLS] peak memory of this process after some steps, with so many cells for each particle (2)
//! cargo bench --bench measure -- machine                 bytes a second by a triad, operations a second by chains of products
//! cargo bench --bench measure -- steps MOTION PARTICLES STEPS  nothing but steps, for `scripts/instructions.sh`
//! ```
//!
//! Every measurement is repeated and the best one is reported: other programs only ever make one slower.

mod scene;

use std::hint::black_box;
use std::time::Instant;

use scene::{Cost, Motion};

/// How often a measurement is repeated.
const REPEATS: usize = 5;
/// Steps before a measurement.
const FIRST_STEPS: usize = 10;
/// Evaluations that a measurement of phases and sizes takes at least, so that the small sizes are no shorter than the large ones.
const EVALUATIONS: usize = 1_000_000;
/// Sizes of the chart of cost against particles; the last one takes 6 GB.
const SIZES: [usize; 6] = [10_000, 31_623, 100_000, 316_228, 1_000_000, 10_000_000];

/// The best of several measurements of so many steps, by processor time.
fn best(motion: Motion, particles: usize, steps: usize) -> Cost {
    let mut solver = scene::solver(motion, particles);
    scene::steps(solver.as_mut(), FIRST_STEPS);
    let costs = (0..REPEATS).map(|_| scene::cost(solver.as_mut(), steps));
    costs
        .min_by(|a, b| (a.sum().cpu / a.evaluations as f64).total_cmp(&(b.sum().cpu / b.evaluations as f64)))
        .unwrap_or(Cost { evaluations: 0, phases: Vec::new() })
}

/// Steps of about so many evaluations, whole rounds of the sorting of Lagrangian particles.
fn steps_of(particles: usize) -> usize {
    EVALUATIONS.div_ceil(particles).next_multiple_of(8)
}

fn phases(particles: usize) {
    println!("motion,particles,phase,cpu_s,particle_evaluations");
    for motion in Motion::ALL {
        let cost = best(motion, particles, steps_of(particles));
        for (name, time) in &cost.phases {
            println!("{},{particles},{name},{:.6},{}", motion.name(), time.cpu, cost.evaluations);
        }
    }
}

fn sizes() {
    println!("motion,particles,cpu_s,particle_evaluations");
    for motion in Motion::ALL {
        for particles in SIZES {
            let cost = best(motion, particles, if particles > 500_000 { 2 } else { steps_of(particles) });
            println!("{},{particles},{:.6},{}", motion.name(), cost.sum().cpu, cost.evaluations);
        }
    }
}

/// Threads take turns, so that a machine that gets busier does not favour one of them.
fn threads(particles: usize) {
    println!("motion,particles,threads,repeat,wall_s,cpu_s,particle_evaluations");
    for motion in Motion::ALL {
        let mut solvers = [1, 2].map(|threads| {
            scene::on_threads(threads, || {
                let mut solver = scene::solver(motion, particles);
                scene::steps(solver.as_mut(), FIRST_STEPS);
                (threads, solver)
            })
        });
        for repeat in 0..2 * REPEATS {
            for (threads, solver) in &mut solvers {
                let cost = scene::on_threads(*threads, || scene::cost(solver.as_mut(), 8));
                let (wall, cpu) = (cost.sum().wall, cost.sum().cpu);
                println!("{},{particles},{threads},{repeat},{wall:.6},{cpu:.6},{}", motion.name(), cost.evaluations);
            }
        }
    }
}

fn memory(motion: Motion, particles: usize, cells_for_each: usize) {
    let mut solver = scene::solver_for(motion, scene::dam_break_in(particles, cells_for_each));
    // Some more than there are between two sortings of Lagrangian particles.
    scene::steps(solver.as_mut(), FIRST_STEPS);
    println!("{},{particles},{},{}", motion.name(), solver.water().lattice.len(), peak_bytes());
}

/// Greatest resident memory of this process (bytes).
fn peak_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kib =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().trim_end_matches("kB").trim().parse().ok());
    kib.map_or(0, |kib: u64| 1024 * kib)
}

/// a = b + s c over arrays far larger than any cache, and independent chains of a x + b: what memory and arithmetic give here,
/// to code that is compiled like ours.
fn machine() {
    println!("what,value,unit");
    let count = 16_000_000;
    let (mut a, b, c) = (vec![0.0_f64; count], vec![1.0_f64; count], vec![2.0_f64; count]);
    let triad = best_seconds(|| {
        for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
            *a = b + 3.0 * c;
        }
        black_box(&a);
    });
    // Three arrays pass, and a line that is written is read before.
    println!("triad,{:.4e},B/s", 32.0 * count as f64 / triad);
    let rounds = 4_000_000;
    let mut chains = [1.0_f64; CHAINS];
    let chain = best_seconds(|| {
        multiply_and_add(&mut chains, (black_box(0.999_999), black_box(1e-6)), rounds);
        black_box(&chains);
    });
    println!("chains,{:.4e},flop/s", 2.0 * CHAINS as f64 * f64::from(rounds) / chain);
}

/// Independent chains of products and sums: enough to hide how long one takes.
const CHAINS: usize = 64;

#[multiversion::multiversion(targets("x86_64+avx2", "x86_64+avx512f+avx512vl"))]
fn multiply_and_add(chains: &mut [f64; CHAINS], (factor, term): (f64, f64), rounds: u32) {
    let mut x = *chains;
    for _ in 0..rounds {
        for x in &mut x {
            *x = *x * factor + term;
        }
    }
    *chains = x;
}

fn best_seconds(mut work: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..3 * REPEATS).map(time).fold(f64::INFINITY, f64::min)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let number = |word: &str| word.parse().unwrap_or_else(|_| panic!("`{word}` is not a number"));
    let motion = |word: &str| {
        let named = Motion::ALL.into_iter().find(|motion| motion.name() == word);
        named.unwrap_or_else(|| panic!("`{word}` is not a motion"))
    };
    match words.as_slice() {
        // `cargo bench` alone runs every bench; the tables are asked for by name.
        [] => {}
        ["phases"] => scene::on_threads(1, || phases(100_000)),
        ["phases", particles] => scene::on_threads(1, || phases(number(particles))),
        ["sizes"] => scene::on_threads(1, sizes),
        ["threads"] => threads(100_000),
        ["threads", particles] => threads(number(particles)),
        ["memory", name, particles] => scene::on_threads(1, || memory(motion(name), number(particles), 2)),
        ["memory", name, particles, cells] => {
            scene::on_threads(1, || memory(motion(name), number(particles), number(cells)))
        }
        ["machine"] => machine(),
        ["steps", name, particles, count] => scene::on_threads(1, || {
            let mut solver = scene::solver(motion(name), number(particles));
            let before = solver.particle_evaluations();
            scene::steps(solver.as_mut(), number(count));
            println!("{}", solver.particle_evaluations() - before);
        }),
        other => panic!("no such measurement: {other:?}; the head of tests/performance/measure.rs lists them"),
    }
}
