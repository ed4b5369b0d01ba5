//! What a step takes from the allocator, on one thread, once the buffers have their sizes, and what a solver holds.
//!
//! Eulerian particles must take nothing. With Lagrangian particles buffers grow as the water spreads: thin particles are wide, and the room
//! for what they say about the grid grows in small pieces, so that memory stays small. Nothing else may allocate with the number of
//! particles, and what every step takes must not either.

#[path = "../performance/scene/mod.rs"]
mod scene;

use std::alloc::System;

use scene::Motion;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Steps before what is counted, and of it: three rounds of the sorting of Lagrangian particles each.
const STEPS: usize = 24;
/// What every step may take: the results of its passes, one list each.
const OF_A_STEP: usize = 10;
/// Particles for each of which a growing buffer may be enlarged once in a step.
const PARTICLES_FOR_EACH: usize = 1000;

/// Bytes that a particle may ask for, with its two cells where it moves, alone where it rests. Room that a vector has in reserve counts
/// here, and takes no memory until it is written: of the resident memory 400 bytes are the bar (docs/performance.md).
const BYTES: f64 = 430.0;

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
        let allowed = (OF_A_STEP + particles / PARTICLES_FOR_EACH) as f64;
        println!("{particles} Lagrangian particles: {:.1} allocations a step", moving.a_step);
        assert!(moving.a_step <= allowed, "{} allocations a step with {particles} Lagrangian particles", moving.a_step);
    }
    let of_each = |[_, small, large]: &[Asked; 3]| (large.held - small.held) / (sizes[2] - sizes[1]) as f64;
    // Twice as many particles rest as are wet.
    for (name, bytes) in [("resting", 0.5 * of_each(&resting)), ("moving", of_each(&moving))] {
        println!("{bytes:.0} bytes a {name} particle");
        assert!(bytes <= BYTES, "{bytes} bytes a {name} particle");
    }
}
