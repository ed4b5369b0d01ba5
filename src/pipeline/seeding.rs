//! Warnings about still water whose cells hold another volume than its polygon.

use crate::error::{Problem, ProblemKind};
use crate::math::readable;
use crate::prepare::{Setup, StillBody};
use crate::scenario::Scenario;
use crate::seeding::SeededVolume;

/// The seeding may miss the integral of level minus terrain by this much, relative, before the planner is warned.
const SEEDING_TOLERANCE: f64 = crate::seeding::VOLUME_TOLERANCE;

/// Warnings about bodies whose cells hold another volume at their level than the integral of level minus terrain: cells keep the
/// level, particles of the variational formulation the volume.
pub(super) fn seeding_warnings(scenario: &Scenario, setup: &Setup) -> Vec<Problem> {
    let bodies = setup.scene.waters.iter().zip(&setup.still_water.volumes);
    let missed = bodies.filter(|(_, volume)| volume.relative_error().abs() > SEEDING_TOLERANCE);
    missed.map(|(water, volume)| warning(scenario, water, volume)).collect()
}

fn warning(scenario: &Scenario, water: &StillBody, volume: &SeededVolume) -> Problem {
    let area = scenario.resolution.value * scenario.resolution.value;
    let message = if !scenario.numerics.has_cells() {
        let rise = (volume.integral_m3 - volume.seeded_m3) / (volume.cells as f64 * area);
        format!(
            "the level of {} m is not held: the particles get the {:.5e} m³ of the integral of level minus terrain, which stand {:.3} m {} it on the mean",
            readable(water.level),
            volume.integral_m3,
            rise.abs(),
            if rise < 0.0 { "below" } else { "above" }
        )
    } else {
        format!(
            "the seeded volume is {:.5e} m³, {:+.2} % off the integral of level minus terrain; the level of {} m is held",
            volume.seeded_m3,
            100.0 * volume.relative_error(),
            readable(water.level)
        )
    };
    let is_narrow = volume.pocket_cells > 0 && volume.seeded_m3 > volume.integral_m3;
    let (cause, remedy) = if is_narrow {
        let cause = format!(
            "the polygon ends within the water: {} cells beside it lie below the level, too, and are filled",
            volume.pocket_cells
        );
        (cause, "draw the polygon up to the shore or the wall that holds the water")
    } else {
        let cause = "the shore or the rim of this body is finer than the spacing of the particles";
        (cause.to_owned(), "choose a finer `resolution` if this matters")
    };
    Problem::warning(ProblemKind::Scenario, "seeded-volume", water.key.clone(), message)
        .with_cause(cause)
        .with_remedy(remedy)
}
