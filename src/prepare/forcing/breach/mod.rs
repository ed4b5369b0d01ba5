//! A dam that breaks: its file, its ridge on the lattice, and whether its opening fits it.

mod dam;
mod lake;
mod levels;
mod opening;
mod way;

use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::Crs;
use crate::math::{Vec2, readable};
use crate::physics::breach::{BreachEstimate, FailureMode, breach_estimates};
use crate::prepare::findings::Findings;
use crate::prepare::ground::Ground;
use crate::prepare::places;
use crate::prepare::tables::series;
use crate::scenario::{
    Breach as Written, BreachFormula, BreachMode, BreachShape, BreachTrigger, GrowthLaw as Law, Scenario, Sourced,
};
use crate::solver::{Breach, GrowthLaw, Opening};
use crate::vector::Feature;
use dam::Dam;
pub use lake::{fill_behind, section, settle};
pub use levels::check_level;
pub use way::check_way;

/// Attributes that may hold the crest where the scenario names none.
const CREST_NAMES: [&str; 2] = ["crest_m", "crest"];
/// How far (in cells) beside the dam the water must find its way.
const BESIDE_DAM: f64 = 3.0;
/// An end of a dam whose ground lies further below the crest than this (m) is open.
const OPEN_END: f64 = 0.05;

/// A dam before it is put on the lattice.
pub struct Opened {
    /// Its line in map coordinates (m).
    line: Vec<Vec2>,
    /// Level of its crest (m).
    crest: f64,
}

/// Opens the file of the dam.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Option<Opened> {
    let breach = scenario.breach.as_ref()?;
    let name = breach.dam.value.path.display();
    let features = places::features(&breach.dam, crs, findings)?;
    let has_line = |feature: &Feature| feature.lines.iter().any(places::has_length);
    findings.add_all(&breach.dam, places::left_out(&breach.dam, &features, "line", has_line));
    let lines: Vec<_> = features
        .iter()
        .flat_map(|feature| feature.lines.iter().map(move |line| (feature, line)))
        .filter(|(_, line)| line.0.len() >= 2)
        .collect();
    let [(feature, line)] = lines[..] else {
        let message = format!("{name} holds {} lines; a dam that breaks is one", lines.len());
        let remedy = "draw one line along the crest, from one abutment to the other";
        findings.add(&breach.dam, input_error("dam-lines", message).with_remedy(remedy));
        return None;
    };
    let names = breach.crest_field.as_deref().map_or(CREST_NAMES.to_vec(), |field| vec![field]);
    if breach.crest.is_none() {
        findings.add_all(&breach.dam, places::unit_of_attribute(&breach.dam, &names, &features, scenario));
    }
    let attribute = || names.iter().find_map(|name| feature.number(name)).filter(|level| level.is_finite());
    let Some(crest) = breach.crest.as_ref().map(|crest| crest.value).or_else(attribute) else {
        let problem = input_error("no-crest", format!("neither the scenario nor {name} gives the crest of the dam"))
            .with_cause(format!(
                "looked for the attribute {}; its attributes: {}",
                names.join(", "),
                feature.attribute_names()
            ))
            .with_remedy("add `crest: 105 m`, or name the attribute with `crest_field`");
        findings.add(&breach.dam, problem);
        return None;
    };
    let mut places: Vec<Vec2> = line.0.iter().map(|c| Vec2::new(c.x, c.y)).collect();
    places.dedup();
    Some(Opened { line: places, crest })
}

/// Raises the dam on the ground and checks what of it goes.
pub fn on_lattice(
    opened: Option<&Opened>,
    scenario: &Scenario,
    ground: &mut Ground<'_>,
    findings: &mut Findings,
) -> Option<Breach> {
    let breach = planned(opened, scenario, ground.bed(), findings)?;
    ground.take(lake::beds(&breach, breach.share_at_start()));
    Some(breach)
}

/// The dam and its breach; reports what of it does not go.
fn planned(
    opened: Option<&Opened>,
    scenario: &Scenario,
    bed: &BedParticles,
    findings: &mut Findings,
) -> Option<Breach> {
    let (written, opened) = (scenario.breach.as_ref()?, opened?);
    let written = &by_formula(written, opened.crest, scenario.numerics.gravity);
    let dam = Dam::of(opened, written, bed, findings)?;
    let opening = match &written.shape {
        None => Some(Opening::Whole),
        Some(shape) => opening::trapezoid(shape, &dam, bed, findings),
    };
    let trigger = levels::trigger(scenario, &written.trigger, bed, findings);
    let share = written.share.as_ref().map(|table| (table, series::growth(table, findings)));
    let lasts = share.as_ref().and_then(|(table, share)| {
        let value = share.as_ref()?.points().last()?.0;
        Some(Sourced { value, key: table.file.key.clone(), place: table.file.place.clone() })
    });
    let duration = written.duration.clone().or(lasts);
    if let Some(duration) = &duration {
        warn_of_growth(scenario, &written.trigger, duration, findings);
    }
    Some(Breach {
        cells: dam.cells,
        rim: Vec::new(),
        crest: opened.crest,
        trigger: trigger?,
        opening: opening?,
        law: match written.law {
            Law::Instantaneous => GrowthLaw::Instantaneous,
            Law::Linear => GrowthLaw::Linear,
            Law::Sine => GrowthLaw::Sine,
            Law::Series => GrowthLaw::Series(share?.1?),
        },
        duration: duration.as_ref().map_or(1.0, |duration| duration.value),
    })
}

/// Warns of a breach that still grows when the run ends.
fn warn_of_growth(scenario: &Scenario, trigger: &BreachTrigger, duration: &Sourced<f64>, findings: &mut Findings) {
    if let BreachTrigger::At(at) = trigger
        && at.value + duration.value > scenario.end_time
        && at.value < scenario.end_time
    {
        let message = format!(
            "the breach still grows when the run ends at {} s: it ends at {} s",
            readable(scenario.end_time),
            readable(at.value + duration.value)
        );
        let problem = Problem::warning(ProblemKind::Scenario, "breach-unfinished", "", message);
        findings.add(duration, problem.with_remedy("let the run last longer, if the final opening matters"));
    }
}

/// The breach with the shape, growth and duration of its formula, where it has one.
fn by_formula(written: &Written, crest: f64, gravity: f64) -> Written {
    let Some(method) = &written.method else { return written.clone() };
    // An invert above the crest is refused with the shape.
    let height = (crest - method.invert.value).max(f64::MIN_POSITIVE);
    let mode = match method.mode {
        BreachMode::Overtopping => FailureMode::Overtopping,
        BreachMode::Piping => FailureMode::Piping,
    };
    let [froehlich_2008, froehlich_1995, ..] = breach_estimates(method.volume.value, height, mode, gravity);
    let estimate = match method.formula {
        BreachFormula::Froehlich2008 => froehlich_2008,
        BreachFormula::Froehlich1995 => froehlich_1995,
    };
    let mean_width = estimate.mean_width.map(|width| method.width_factor * width);
    let estimate = BreachEstimate { mean_width, ..estimate };
    let by_volume = |value: f64| Sourced { value, ..method.volume.clone() };
    Written {
        shape: Some(BreachShape {
            bottom_width: by_volume(estimate.bottom_width(height).unwrap_or(0.0)),
            side_slope: estimate.side_slope,
            invert: method.invert.clone(),
            position: method.position.clone(),
        }),
        law: Law::Sine,
        duration: Some(by_volume(method.time_factor * estimate.time[1])),
        ..written.clone()
    }
}
