//! What sets off a breach, and whether the water of the run goes with it: levels of trigger, crest and opening.

use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::math::{Vec2, readable};
use crate::prepare::findings::Findings;
use crate::scenario::{BoundaryCondition, Breach as Written, BreachTrigger, Scenario};
use crate::seeding::StillWater;
use crate::solver::{Breach, DamCell, Trigger};

/// Water higher than the crest by this (m) runs over it.
const OVER_CREST: f64 = 1e-3;

/// A trigger higher than the crest by this (m) is hardly meant so: a dam that is overtopped breaks at a depth of some decimetres.
const TRIGGER_OVER_CREST: f64 = 1.0;

/// The trigger on the lattice; refuses one after the end of the run, or at a place without terrain.
pub fn trigger(
    scenario: &Scenario,
    trigger: &BreachTrigger,
    bed: &BedParticles,
    findings: &mut Findings,
) -> Option<Trigger> {
    match trigger {
        BreachTrigger::At(at) if at.value >= scenario.end_time => {
            let message =
                format!("the breach begins at {} s, when the run has ended at {} s", at.value, scenario.end_time);
            let problem = Problem::error(ProblemKind::Scenario, "trigger-after-end", "", message);
            findings.add(at, problem.with_remedy("let it begin earlier, or the run last longer (`time.end`)"));
            None
        }
        BreachTrigger::At(at) => Some(Trigger::At(at.value)),
        BreachTrigger::Level { level, place } => {
            let map = Vec2::new(place.value[0], place.value[1]);
            let local = bed.lattice.to_local(map);
            if bed.lattice.cell_at(local).is_none_or(|cell| !bed.has_terrain(cell)) {
                let problem = input_error("outside-terrain", "this place lies on no terrain".to_owned())
                    .with_remedy("check its coordinates, their order and their CRS")
                    .with_at(map);
                findings.add(place, problem);
                return None;
            }
            Some(Trigger::Level { level: level.value, place: local })
        }
    }
}

/// Refuses an opening that ends above all water, and warns of a volume that is not that of the lake.
fn check_water(
    written: &Written,
    breach: &Breach,
    (highest, is_fed): (f64, bool),
    above: impl Fn(f64) -> f64,
    findings: &mut Findings,
) {
    let lowest = breach.cells.iter().map(|cell| breach.bed(cell, 1.0)).fold(f64::INFINITY, f64::min);
    if lowest >= highest && !is_fed {
        let stands = if highest.is_finite() {
            format!("the water stands at {highest:.2} m at most")
        } else {
            "there is no water".to_owned()
        };
        let message = format!("the opening ends at {lowest:.2} m, and {stands}: none would pass");
        let problem = Problem::error(ProblemKind::Scenario, "opening-above-water", "", message)
            .with_cause("the terrain along the line holds the dam already, or a level is wrong")
            .with_remedy("carve the dam out of the terrain (`terrain.breaklines`, `mode: carve`), or correct the invert or the level of the lake");
        findings.add(&written.dam, problem);
    }
    let Some(method) = &written.method else { return };
    let volume = above(method.invert.value);
    let ratio = method.volume.value / volume;
    if !is_fed && !(0.5..=2.0).contains(&ratio) {
        let message = format!(
            "the formula is given {:.4e} m³, and the water of the run above the invert is {volume:.4e} m³",
            method.volume.value
        );
        let problem = Problem::warning(ProblemKind::Scenario, "breach-volume", "", message);
        findings.add(&method.volume, problem.with_remedy("check the unit (m3, Mm3, hm3) and the lake that is meant"));
    }
}

/// Warns of water beside the dam that stands above its crest.
fn warn_of_water_above(
    written: &Written,
    breach: &Breach,
    bed: &BedParticles,
    water: &StillWater,
    findings: &mut Findings,
) {
    let level_of = |cell: usize| bed.elevation[cell] + water.depth[cell];
    let lattice = &bed.lattice;
    let beside = |cell: &DamCell| {
        let centre = lattice.centre(cell.cell);
        let places = [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
        places.map(|(x, y)| lattice.cell_at(centre + Vec2::new(x, y) * lattice.spacing))
    };
    let raised = breach.cells.iter().filter(|cell| cell.ground < breach.crest);
    let wet = raised.flat_map(beside).flatten().filter(|&cell| water.depth[cell] > 0.0);
    if let Some(cell) = wet.max_by(|a, b| level_of(*a).total_cmp(&level_of(*b)))
        && level_of(cell) > breach.crest + OVER_CREST
    {
        let message = format!(
            "the water stands at {:.2} m beside the dam, above its crest of {} m",
            level_of(cell),
            breach.crest
        );
        let problem = Problem::warning(ProblemKind::Scenario, "water-above-crest", "", message)
            .with_cause("it runs over the dam from the start on, whether the dam breaks or not")
            .with_remedy("correct the level of the lake or the crest, their units or their datum")
            .with_at(lattice.to_map(lattice.centre(cell)));
        findings.add(&written.dam, problem);
    }
}

/// Refuses a level that no water of the run can reach, and an opening above all water; warns of water and of a level above the crest.
pub fn check_level(
    scenario: &Scenario,
    breach: &Breach,
    bed: &BedParticles,
    water: &StillWater,
    findings: &mut Findings,
) {
    let brings_water = |condition: &BoundaryCondition| {
        matches!(
            condition,
            BoundaryCondition::Discharge { .. }
                | BoundaryCondition::Stage(_)
                | BoundaryCondition::Level(_)
                | BoundaryCondition::Wave { .. }
        )
    };
    let is_fed = scenario.boundaries.iter().any(|boundary| brings_water(&boundary.value.condition))
        || !scenario.sources.is_empty()
        || scenario.rain.is_some()
        || !scenario.channels.is_empty();
    let wet = || (0..water.depth.len()).filter(|&cell| water.depth[cell] > 0.0);
    let level_of = |cell: usize| bed.elevation[cell] + water.depth[cell];
    let highest = wet().map(level_of).fold(f64::NEG_INFINITY, f64::max);
    let above = |invert: f64| {
        wet().map(|cell| bed.area(cell) * (level_of(cell) - bed.elevation[cell].max(invert)).max(0.0)).sum::<f64>()
    };
    if let Some(written) = &scenario.breach {
        check_water(written, breach, (highest, is_fed), above, findings);
        warn_of_water_above(written, breach, bed, water, findings);
    }
    let (Some(written), Trigger::Level { level, place }) = (&scenario.breach, breach.trigger) else { return };
    let BreachTrigger::Level { level: source, .. } = &written.trigger else { return };
    if level > highest && !is_fed {
        let message = if highest.is_finite() {
            format!("the water never reaches {level} m: it stands at {highest:.2} m at most, and none comes in")
        } else {
            format!("the water never reaches {level} m: there is none at the start, and none comes in")
        };
        let problem = Problem::error(ProblemKind::Scenario, "level-never-reached", "", message)
            .with_remedy("lower it, add a boundary, a source or rain, or let the breach begin at a time")
            .with_at(bed.lattice.to_map(place));
        findings.add(source, problem);
    } else if level > breach.crest + TRIGGER_OVER_CREST {
        let message = format!(
            "the dam is to break at {level} m, {} m above its crest of {} m",
            readable(level - breach.crest),
            breach.crest
        );
        let problem = input_warning("trigger-above-crest", message)
            .with_cause("the water would have to run over the dam so deep first, if it ever stands so high")
            .with_remedy(
                "correct the level or the crest, their units or their datum; or let the breach begin at a time",
            )
            .with_at(bed.lattice.to_map(place));
        findings.add(source, problem);
    }
}
