//! What a step takes from the allocator, on one thread, once the buffers have their sizes.
//!
//! Resting particles must take nothing. With moving particles buffers grow as the water spreads: thin particles are wide, and the room
//! for what they say about the grid grows in small pieces, so that memory stays small. Nothing else may allocate with the number of
//! particles, and what every step takes must not either.

#[path = "../performance/scene/mod.rs"]
mod scene;

use std::alloc::System;

use scene::Motion;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Steps before what is counted, and of it: three rounds of the sorting of moving particles each.
const STEPS: usize = 24;
/// What every step may take: the results of its passes, one list each.
const OF_A_STEP: usize = 10;
/// Particles for each of which a growing buffer may be enlarged once in a step.
const PARTICLES_FOR_EACH: usize = 1000;

/// How often a dam break of so many particles asks the allocator for room in a step.
fn allocations_a_step(motion: Motion, particles: usize) -> f64 {
    scene::on_threads(1, || {
        let mut solver = scene::solver(motion, particles);
        scene::steps(solver.as_mut(), STEPS);
        let region = Region::new(ALLOCATOR);
        scene::steps(solver.as_mut(), STEPS);
        let change = region.change();
        (change.allocations + change.reallocations) as f64 / STEPS as f64
    })
}

/// One test for both motions: the counter does not tell threads apart.
#[test]
fn steps_leave_the_allocator_alone() {
    for particles in [2_000, 20_000, 80_000] {
        let resting = allocations_a_step(Motion::Eulerian, particles);
        assert!(resting == 0.0, "{resting} allocations a step with {particles} resting particles");
        let moving = allocations_a_step(Motion::Lagrangian, particles);
        let allowed = (OF_A_STEP + particles / PARTICLES_FOR_EACH) as f64;
        println!("{particles} moving particles: {moving:.1} allocations a step");
        assert!(moving <= allowed, "{moving} allocations a step with {particles} moving particles");
    }
}
