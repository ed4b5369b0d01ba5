//! Particles and memory of a run, before anything large is allocated for it.

use super::findings::Findings;
use super::grid::{BYTES_OF_PROGRAM, BYTES_PER_MOVING_CELL, BYTES_PER_SAMPLE};
use super::{BYTES_PER_CELL, BYTES_PER_FLUID_PARTICLE, Needs, grid, ground};
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind};
use crate::math::in_bytes;
use crate::scenario::methods::Core;
use crate::scenario::{Limits, Scenario};
use crate::seeding::StillWater;
use crate::solver::Channel;

/// Particles and memory of a run; refuses more of them than their limits.
pub(super) fn needs(
    scenario: &Scenario,
    (bed, still_water): (&BedParticles, &StillWater),
    (channels, pixels, gauges): (&[Channel], usize, usize),
    findings: &mut Findings,
) -> Needs {
    let wet_cells = still_water.depth.iter().filter(|&&depth| depth > 0.0).count();
    let bed_particles = bed.elevation.iter().filter(|z| !z.is_nan()).count();
    let fluid = if !scenario.numerics.has_cells() { wet_cells } else { 0 };
    let channel_particles = channels.iter().map(|channel| channel.sections.len()).sum();
    let strips = |channel: &Channel| channel.sections.len() * channel.face_widths.first().map_or(0, Vec::len);
    let channel_strips = channels.iter().map(strips).sum();
    // A strip takes no more than a cell.
    // The rows of all levels are as long as those of the finest one.
    let stack = if scenario.levels.is_some() { 2 } else { 1 };
    let moves = scenario.numerics.core() == Core::Lagrangian;
    let samples = gauges as f64 * (scenario.end_time / scenario.outputs.gauges_every).ceil();
    let memory = BYTES_OF_PROGRAM
        + samples * BYTES_PER_SAMPLE
        + (stack * bed.lattice.len() + channel_strips) as f64 * BYTES_PER_CELL
        + if moves { bed_particles as f64 * BYTES_PER_MOVING_CELL } else { 0.0 }
        + fluid as f64 * BYTES_PER_FLUID_PARTICLE
        + pixels as f64 * ground::BYTES_PER_PIXEL;
    let counts = [bed_particles, fluid, channel_strips];
    let (spacing, limits) = (bed.lattice.spacing, &scenario.limits);
    let beyond = grid::check_particles(counts, spacing, limits).or_else(|| check_memory(memory, spacing, limits));
    if let Some(problem) = beyond {
        findings.add(&scenario.resolution, problem);
    }
    Needs { bed_particles, channel_particles, channel_strips, wet_cells, memory }
}

/// The problem of a run that needs more memory (bytes) than its limit.
fn check_memory(memory: f64, spacing: f64, limits: &Limits) -> Option<Problem> {
    (memory > limits.memory).then(|| {
        let message =
            format!("the run needs about {} of memory; the limit is {}", in_bytes(memory), in_bytes(limits.memory));
        Problem::error(ProblemKind::Limit, "memory-limit", "", message)
            .with_remedy(grid::for_memory(memory, spacing, limits))
    })
}
