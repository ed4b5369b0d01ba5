//! What a step takes from the allocator, on one thread, once the buffers have their sizes, and what a solver holds.
//!
//! Cells at rest must take nothing. Where cells move each chunk of them makes lists of its own in a step, which is to be mended: here is how
//! many there are.

#[path = "../performance/scene/mod.rs"]
mod scene;

use std::alloc::System;

use scene::Motion;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Steps before what is counted, and of it: eight records of cells that move each.
const STEPS: usize = 24;
/// What every step with cells that move may take.
const OF_A_STEP: usize = 400;
/// Cells for each of which it may take one more.
const CELLS_FOR_EACH: usize = 15;

/// Bytes that a cell at rest may ask for, and a cell that moves with two cells of the lattice. Room that a vector has in reserve counts here, and takes
/// no memory until it is written.
const BYTES: [f64; 2] = [430.0, 2100.0];

/// What a dam break asks of the allocator.
struct Asked {
    /// Allocations of a step.
    a_step: f64,
    /// What the solver holds after all steps (bytes).
    held: f64,
}

/// What a dam break of so many particles asks of the allocator.
fn asked(motion: Motion, particles: usize) -> Asked {
    scene::on_threads(1, || {
        let whole = Region::new(ALLOCATOR);
        let mut solver = scene::solver(motion, particles);
        scene::steps(solver.as_mut(), STEPS);
        let region = Region::new(ALLOCATOR);
        scene::steps(solver.as_mut(), STEPS);
        let (change, all) = (region.change(), whole.change());
        Asked {
            a_step: (change.allocations + change.reallocations) as f64 / STEPS as f64,
            held: all.bytes_allocated as f64 - all.bytes_deallocated as f64,
        }
    })
}

/// One test for both motions: the counter does not tell threads apart.
#[test]
fn steps_leave_the_allocator_alone() {
    let sizes = [2_000, 20_000, 80_000];
    let resting = sizes.map(|particles| asked(Motion::Eulerian, particles));
    let moving = sizes.map(|particles| asked(Motion::Lagrangian, particles));
    for ((particles, resting), moving) in sizes.into_iter().zip(&resting).zip(&moving) {
        assert!(resting.a_step == 0.0, "{} allocations a step with {particles} Eulerian particles", resting.a_step);
        let allowed = (OF_A_STEP + particles / CELLS_FOR_EACH) as f64;
        println!("{particles} cells that move: {:.1} allocations a step", moving.a_step);
        assert!(moving.a_step <= allowed, "{} allocations a step with {particles} cells that move", moving.a_step);
    }
    let of_each = |[_, small, large]: &[Asked; 3]| (large.held - small.held) / (sizes[2] - sizes[1]) as f64;
    // Twice as many particles rest as are wet.
    for (name, bytes, allowed) in
        [("resting", 0.5 * of_each(&resting), BYTES[0]), ("moving", of_each(&moving), BYTES[1])]
    {
        println!("{bytes:.0} bytes a {name} cell");
        assert!(bytes <= allowed, "{bytes} bytes a {name} cell");
    }
}
