//! Still water at the start: polygons and levels, and what can be wrong with them.

mod check;
pub mod earlier;
pub mod earlier_cells;
pub mod earlier_fields;
pub mod earlier_maps;
pub mod earlier_state;
pub mod earlier_structures;
pub mod start;

use crate::error::{Problem, ProblemKind, Severity, input_error};
use crate::geodata::Crs;
use crate::output::SetBy;
use crate::prepare::StillBody;
use crate::prepare::findings::Findings;
use crate::prepare::ground::Ground;
use crate::prepare::places::{features, left_out, unit_of_attribute};
use crate::prepare::polygons::{self, PolygonFault};
use crate::scenario::{InitialWater, Scenario, Sourced, VectorSource};
use crate::seeding::{self, Barriers, Leak, SeededVolume, StillWater, fill_still_water};
use crate::terrain::PLAUSIBLE_ELEVATION;
use crate::vector::Feature;
pub use check::check;

/// Names of the attribute that holds the level, when the scenario names none.
const LEVEL_NAMES: [&str; 2] = ["level_m", "level"];
/// Leaks less deep than this (m) lie within the error of any terrain.
const NEGLIGIBLE_LEAK: f64 = 0.01;
/// Share of a body by which the cells at upright banks may hold another volume: as of a moving bed that is finer than the lattice.
const OTHER_VOLUME: f64 = 0.02;
/// Number of leaks that are listed.
const LISTED_LEAKS: usize = 5;

/// The bodies of one entry of the scenario: one for the whole file when the scenario gives the level, else one for each feature.
pub fn bodies(water: &InitialWater, crs: Option<&Crs>, scenario: &Scenario, findings: &mut Findings) -> Vec<StillBody> {
    let source = &water.polygons;
    let name = source.value.path.display();
    let Some(features) = features(source, crs, findings) else {
        return Vec::new();
    };
    let has_area = |feature: &Feature| !feature.polygons.is_empty();
    findings.add_all(source, left_out(source, &features, "polygon", has_area));
    let features: Vec<Feature> = features.into_iter().filter(has_area).collect();
    if features.is_empty() {
        findings.add(
            source,
            input_error("empty-polygon", format!("{name} holds no polygon"))
                .with_remedy("draw the outline of the water as a polygon"),
        );
        return Vec::new();
    }
    let mut sound = true;
    for feature in &features {
        for polygon in &feature.polygons {
            sound &= check_polygon(source, feature.number, polygon, findings);
        }
    }
    if !sound {
        return Vec::new();
    }
    let body = |polygons, level| StillBody { polygon: polygons::union(polygons), level, key: source.key.clone() };
    if let Some(level) = &water.level {
        if let Some(problem) = implausible(level.value, &name.to_string()) {
            findings.add(level, problem);
            return Vec::new();
        }
        warn_of_other_levels(water, level, &features, findings);
        return vec![body(features.into_iter().flat_map(|feature| feature.polygons).collect(), level.value)];
    }
    findings.add_all(source, unit_of_attribute(source, &level_names(water), &features, scenario));
    let mut bodies = Vec::new();
    for feature in features {
        match level_of(water, &feature) {
            Some(level) => match implausible(level, &format!("feature {} of {name}", feature.number)) {
                None => bodies.push(body(feature.polygons, level)),
                Some(problem) => findings.add(source, problem),
            },
            None => findings.add(source, no_level(water, &feature)),
        }
    }
    bodies
}

/// The problem of a level (m) of something that no water on Earth has.
fn implausible(level: f64, what: &str) -> Option<Problem> {
    (!PLAUSIBLE_ELEVATION.contains(&level)).then(|| {
        input_error("implausible-level", format!("the water of {what} has a level of {level} m, as none on Earth"))
            .with_cause("a code for a missing value, perhaps, or another unit")
            .with_remedy("correct the level, its unit or its datum")
    })
}

fn level_names(water: &InitialWater) -> Vec<&str> {
    water.level_field.as_deref().map_or(LEVEL_NAMES.to_vec(), |field| vec![field])
}

fn level_of(water: &InitialWater, feature: &Feature) -> Option<f64> {
    level_names(water).iter().find_map(|name| feature.number(name)).filter(|level| level.is_finite())
}

fn no_level(water: &InitialWater, feature: &Feature) -> Problem {
    let message = format!(
        "neither the scenario nor feature {} of {} gives a level",
        feature.number,
        water.polygons.value.path.display()
    );
    input_error("no-level", message)
        .with_cause(format!(
            "looked for {}; its attributes: {}",
            level_names(water).join(", "),
            feature.attribute_names()
        ))
        .with_remedy("add `level: 100 m` to the entry, or name the attribute with `level_field`")
}

fn warn_of_other_levels(water: &InitialWater, level: &Sourced<f64>, features: &[Feature], findings: &mut Findings) {
    let other =
        features.iter().filter_map(|feature| level_of(water, feature)).find(|own| (own - level.value).abs() > 1e-6);
    if let Some(own) = other {
        let message = format!(
            "the scenario's level of {} m is used, although {} says {own} m",
            level.value,
            water.polygons.value.path.display()
        );
        findings.add(level, Problem::warning(ProblemKind::Input, "two-levels", "", message));
    }
}

/// All polygons of a file as one area.
pub fn area(
    source: &Sourced<VectorSource>,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<geo::MultiPolygon<f64>> {
    let features = features(source, crs, findings)?;
    let mut polygons = Vec::new();
    let mut is_sound = true;
    findings.add_all(source, left_out(source, &features, "polygon", |feature| !feature.polygons.is_empty()));
    for feature in features {
        for polygon in feature.polygons {
            is_sound &= check_polygon(source, feature.number, &polygon, findings);
            polygons.push(polygon);
        }
    }
    if polygons.is_empty() {
        let problem = input_error("empty-polygon", format!("{} holds no polygon", source.value.path.display()));
        findings.add(source, problem.with_remedy("draw the area as a polygon"));
        return None;
    }
    is_sound.then(|| polygons::union(polygons))
}

/// Reports the fault of a polygon; says whether it can be used.
pub fn check_polygon(
    source: &Sourced<VectorSource>,
    number: usize,
    polygon: &geo::Polygon<f64>,
    findings: &mut Findings,
) -> bool {
    let name = source.value.path.display();
    let problem = match polygons::fault(polygon) {
        None => return true,
        Some(PolygonFault::Empty) => input_error("empty-polygon", format!("polygon {number} of {name} has no area"))
            .with_remedy("draw at least three corners that do not lie on one line"),
        Some(PolygonFault::NotFinite) => input_error(
            "not-a-number",
            format!("polygon {number} of {name} has a coordinate that is not a finite number"),
        )
        .with_remedy("export the file again, or draw this polygon anew"),
        Some(PolygonFault::Crossing(place)) => {
            input_error("self-crossing", format!("the outline of polygon {number} of {name} crosses itself"))
                .with_remedy("mend it, for example with `Fix geometries` in QGIS or `ogr2ogr -makevalid`")
                .with_at(place)
        }
        Some(PolygonFault::Untidy(cause)) => {
            let message = format!("polygon {number} of {name} is not a simple polygon, but its area is clear");
            Problem::warning(ProblemKind::Input, "untidy-polygon", "", message).with_cause(cause)
        }
    };
    let usable = problem.severity == Severity::Warning;
    findings.add(source, problem);
    usable
}

/// A body with the scenario value that it comes from.
pub struct SourcedBody<'a> {
    pub source: &'a Sourced<VectorSource>,
    pub body: StillBody,
}

/// Fills the bodies and fits the ground to their shores. If the ground is complete, warns where their water would run out of them, and
/// where upright banks make their volume another one. Beside a dam that was refused there is no need of a report.
pub fn fill(
    bodies: &[SourcedBody],
    ground: &mut Ground<'_>,
    barriers: Barriers<'_>,
    is_complete: bool,
    findings: &mut Findings,
) -> StillWater {
    let plain = |body: &StillBody| seeding::StillBody { polygon: body.polygon.clone(), level: body.level };
    let plain: Vec<seeding::StillBody> = bodies.iter().map(|body| plain(&body.body)).collect();
    let (water, shore) = fill_still_water(&plain, ground.bed(), &ground.surface(), barriers, ground.seeding());
    ground.take_beds(&shore, SetBy::Shore);
    let spacing = ground.bed().lattice.spacing;
    for (body, volume) in bodies.iter().zip(&water.volumes) {
        let leaks: Vec<&Leak> = volume.leaks.iter().filter(|leak| leak.depth > NEGLIGIBLE_LEAK).collect();
        if let Some(deepest) = leaks.first().filter(|_| is_complete) {
            findings.add(body.source, leak_warning(&body.body, deepest, &leaks, spacing));
        }
        if is_complete && volume.share_at_banks().abs() > OTHER_VOLUME {
            findings.add(body.source, bank_warning(&body.body, volume));
        }
    }
    water
}

fn leak_warning(body: &StillBody, deepest: &Leak, leaks: &[&Leak], spacing: f64) -> Problem {
    let place = |leak: &&Leak| format!("{:.2} m at {:.0}, {:.0}", leak.bed_elevation, leak.position.x, leak.position.y);
    let places: Vec<String> = leaks.iter().take(LISTED_LEAKS).map(place).collect();
    let more = leaks.len().saturating_sub(LISTED_LEAKS);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    let width = leaks.iter().map(|leak| leak.cells).sum::<usize>() as f64 * spacing;
    let width = if width < spacing { "less than a cell".to_owned() } else { format!("about {width:.0} m") };
    let message = format!("at {} m the water runs out over {width} of the polygon's rim", body.level);
    Problem::warning(ProblemKind::Input, "leaking-rim", "", message)
        .with_cause(format!("lowest places of the rim: {}{more}", places.join("; ")))
        .with_remedy(
            "expected along the dam; elsewhere, enlarge the polygon, lower the level, or draw a wall along the rim",
        )
        .with_at(deepest.position)
}

fn bank_warning(body: &StillBody, volume: &SeededVolume) -> Problem {
    let message = format!(
        "at {} m the water holds {:+.1} % of its volume ({:+.3e} m³) at upright banks",
        body.level,
        100.0 * volume.share_at_banks(),
        volume.at_banks_m3
    );
    Problem::warning(ProblemKind::Scenario, "volume-at-banks", "", message)
        .with_cause(
            "cells that a quay or a wall of the terrain divides keep their ground, and are filled whole or not at all",
        )
        .with_remedy("choose a finer `resolution` if this matters")
}
