//! Buildings: their footprints, and what they make of the ground. A building takes the cells whose centres lie in it;
//! of one that is blocked the cells about it follow the outline ([`super::outlines`]).

use std::collections::{BTreeMap, BTreeSet};

use geo::MultiPolygon;

use super::change::{Change, Made};
use super::{CHECK_PLACES, Ground};
use crate::bed::BedParticles;
use crate::error::{Problem, input_error, input_warning};
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::output::SetBy;
use crate::prepare::findings::Findings;
use crate::prepare::polygons::{ValuedArea, cells_inside};
use crate::prepare::{places, water};
use crate::scenario::{BuildingMode, Buildings, Scenario, Sourced, VectorSource};
use crate::vector::Feature;

/// Names of the attribute that holds the height of a building, and of that which holds its roughness.
const HEIGHT_NAMES: [&str; 2] = ["height_m", "height"];
const ROUGHNESS_NAMES: [&str; 3] = ["n", "manning", "manning_n"];
/// Greatest n (s·m^(−1/3)): beyond it a value is something else.
const GREATEST_ROUGHNESS: f64 = 0.5;

/// Greatest height (m) of a building: what is more has another unit.
const TALLEST_BUILDING: f64 = 1000.0;
/// Height (m) of a building that is worth a question: few are higher.
const TALL_BUILDING: f64 = 200.0;

/// Footprints (map coordinates) with the height (m) or the roughness (s·m^(−1/3)) of each.
pub type Footprints = Vec<ValuedArea>;

/// The footprints of the buildings of the scenario.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Footprints {
    let buildings = scenario.ground.buildings.as_ref();
    buildings.map_or_else(Vec::new, |buildings| footprints(buildings, crs, scenario, findings))
}

/// Those of the buildings that are blocked.
pub fn blocked<'a>(footprints: &'a Footprints, scenario: &Scenario) -> impl Iterator<Item = &'a MultiPolygon<f64>> {
    let buildings = scenario.ground.buildings.as_ref();
    let are_blocked = buildings.is_some_and(|buildings| matches!(buildings.mode, BuildingMode::Block));
    footprints.iter().filter(move |_| are_blocked).map(|footprint| &footprint.area)
}

/// Takes over what the buildings change.
pub fn shape(footprints: &Footprints, scenario: &Scenario, ground: &mut Ground<'_>, findings: &mut Findings) {
    if let Some(buildings) = &scenario.ground.buildings {
        let are_followed = buildings.mode == BuildingMode::Block && scenario.numerics.has_cells();
        ground.take(changes((buildings, are_followed), footprints, ground.bed(), findings));
    }
}

/// The footprints of a file, each with its height or roughness.
fn footprints(buildings: &Buildings, crs: Option<&Crs>, scenario: &Scenario, findings: &mut Findings) -> Footprints {
    let source = &buildings.polygons;
    let Some(features) = places::features_near(source, crs, scenario, findings) else { return Vec::new() };
    findings.add_all(source, places::left_out(source, &features, "polygon", |feature| !feature.polygons.is_empty()));
    if let BuildingMode::Raise { height: None, field } = &buildings.mode {
        let names = field.as_deref().map_or(HEIGHT_NAMES.to_vec(), |field| vec![field]);
        findings.add_all(source, places::unit_of_attribute(source, &names, &features, scenario));
    }
    let mut found = Vec::new();
    let mut seen = Seen::default();
    for feature in features.iter().filter(|feature| !feature.polygons.is_empty()) {
        seen.count += 1;
        let is_usable = sound(source, feature, findings);
        let attribute = |names: &[&str]| names.iter().find_map(|name| feature.number(name));
        let value = match &buildings.mode {
            BuildingMode::Block => Some(0.0),
            BuildingMode::Raise { height, field } => height
                .or_else(|| field.as_deref().map_or_else(|| attribute(&HEIGHT_NAMES), |field| attribute(&[field]))),
            BuildingMode::Roughness(n) => n.or_else(|| attribute(&ROUGHNESS_NAMES)),
        };
        // A roughness of 0 is what an empty field of a table says.
        let (least, greatest) = match buildings.mode {
            BuildingMode::Roughness(_) => (f64::MIN_POSITIVE, GREATEST_ROUGHNESS),
            _ => (0.0, TALLEST_BUILDING),
        };
        match value {
            None => seen.without.push(feature),
            Some(value) if !(least..=greatest).contains(&value) => seen.beyond.push((feature, value)),
            Some(value) => {
                // A roughness is less.
                seen.tall.extend((value > TALL_BUILDING).then_some((feature, value)));
                found
                    .extend(is_usable.then(|| ValuedArea { area: MultiPolygon::new(feature.polygons.clone()), value }));
            }
        }
    }
    seen.report(buildings, findings);
    found
}

/// The polygons of a file, and those whose value is missing or doubtful.
#[derive(Default)]
struct Seen<'a> {
    count: usize,
    without: Vec<&'a Feature>,
    /// With a value that no building has.
    beyond: Vec<(&'a Feature, f64)>,
    /// With a height that hardly any building has.
    tall: Vec<(&'a Feature, f64)>,
}

impl Seen<'_> {
    fn report(&self, buildings: &Buildings, findings: &mut Findings) {
        let source = &buildings.polygons;
        let name = source.value.path.display();
        if self.count == 0 {
            let problem = input_error("empty-polygon", format!("{name} holds no polygon"));
            findings.add(source, problem.with_remedy("draw the footprints of the buildings as polygons"));
        }
        if let Some(first) = self.without.first() {
            findings.add(source, no_value(buildings, first, self.without.len(), self.count));
        }
        if let Some((first, value)) = self.beyond.first() {
            let message = format!(
                "{} of {} polygons of {name} have a value that no building has, the first is feature {} with {value}",
                self.beyond.len(),
                self.count,
                first.number
            );
            let remedy = match buildings.mode {
                BuildingMode::Roughness(_) => "give a Manning roughness above 0 and at most 0.5",
                _ => "give a height of 0 to 1000 m, in metres",
            };
            findings.add(source, input_error("building-range", message).with_remedy(remedy));
        }
        if let Some((first, value)) = self.tall.first() {
            let message = format!(
                "{} of {} polygons of {name} are higher than {TALL_BUILDING} m, the first is feature {} with {value} m",
                self.tall.len(),
                self.count,
                first.number
            );
            let problem =
                input_warning("doubtful-height", message).with_cause("hardly any building is; another unit, perhaps");
            findings.add(source, problem.with_remedy("correct the heights, which count in metres above the ground"));
        }
    }
}

/// The problem of footprints without a height or a roughness.
fn no_value(buildings: &Buildings, first: &Feature, missing: usize, count: usize) -> Problem {
    let name = buildings.polygons.value.path.display();
    let names = first.attribute_names();
    let (what, wanted, remedy) = match &buildings.mode {
        BuildingMode::Roughness(_) => {
            ("roughness", ROUGHNESS_NAMES.join(", "), "add `n: 0.3`, or give each polygon an attribute `n`")
        }
        BuildingMode::Raise { field: Some(field), .. } => {
            ("height", field.clone(), "name another attribute with `height_field`, fill it in, or write `height: 3 m`")
        }
        _ => ("height", HEIGHT_NAMES.join(", "), "add `height: 3 m`, or name the attribute with `height_field`"),
    };
    let message =
        format!("{missing} of {count} polygons of {name} have no {what}, the first is feature {}", first.number);
    input_error("building-value", message)
        .with_cause(format!("looked for a number in {wanted}; its attributes: {names}"))
        .with_remedy(remedy)
}

/// Whether every polygon of a feature can be used; reports those that cannot.
fn sound(source: &Sourced<VectorSource>, feature: &Feature, findings: &mut Findings) -> bool {
    // All are looked at, so that every fault is found.
    let faults =
        feature.polygons.iter().filter(|polygon| !water::check_polygon(source, feature.number, polygon, findings));
    faults.count() == 0
}

/// What buildings change.
///
/// - `are_followed`: whether cells follow their outlines, so that none is too small or too narrow for its squares
fn changes(
    (buildings, are_followed): (&Buildings, bool),
    footprints: &Footprints,
    bed: &BedParticles,
    findings: &mut Findings,
) -> Vec<Change> {
    let lattice = &bed.lattice;
    // A cell that two share gets the higher value.
    let mut cells: BTreeMap<usize, f64> = BTreeMap::new();
    let (mut outside, mut small, mut broken) = (Vec::new(), Vec::new(), Vec::new());
    for ValuedArea { area, value } in footprints {
        let inside = cells_inside(area, lattice);
        if !matches!(buildings.mode, BuildingMode::Roughness(_))
            && area.0.iter().any(|part| are_apart(&cells_inside(&MultiPolygon(vec![part.clone()]), lattice), lattice))
        {
            broken.push(area);
        }
        if inside.iter().any(|&cell| bed.has_terrain(cell)) {
            for cell in inside {
                cells.entry(cell).and_modify(|own| *own = own.max(*value)).or_insert(*value);
            }
        } else if is_off(area, bed) {
            outside.push(area);
        } else {
            small.push(area);
        }
    }
    if are_followed {
        small.clear();
        broken.clear();
    }
    report_left_out(buildings, [&outside, &small, &broken], footprints.len(), findings);
    let on_terrain = cells.into_iter().filter(|(cell, _)| bed.elevation[*cell].is_finite());
    let change = |(cell, value): (usize, f64)| {
        let (made, by) = match buildings.mode {
            BuildingMode::Block => (Made::Block, SetBy::BlockedBuilding),
            BuildingMode::Raise { .. } => (Made::Lift(value), SetBy::RaisedBuilding),
            BuildingMode::Roughness(_) => (Made::Roughness(value), SetBy::RaisedBuilding),
        };
        Change { cell, made, by }
    };
    on_terrain.map(change).collect()
}

/// Warns of buildings, of so many, that are left out or let water through: those outside the terrain, those that hold the centre of no
/// cell, those whose cells do not hang together.
fn report_left_out(
    buildings: &Buildings,
    [outside, small, broken]: [&[&MultiPolygon<f64>]; 3],
    count: usize,
    findings: &mut Findings,
) {
    let source = &buildings.polygons;
    let name = source.value.path.display();
    let first = |areas: &[&MultiPolygon<f64>]| areas.first().and_then(|area| corner(area));
    if let Some(at) = first(outside) {
        let message = format!("{} of {} buildings of {name} lie outside the terrain", outside.len(), count);
        let problem = if outside.len() == count {
            input_error("outside-terrain", message).with_remedy("check that the file and the terrain have the same CRS")
        } else {
            input_warning("outside-terrain", message).with_remedy(CHECK_PLACES)
        };
        findings.add(source, problem.with_at(at));
    }
    if let Some(at) = first(small) {
        let message =
            format!("{} of {} buildings of {name} hold the centre of no cell and are left out", small.len(), count);
        let problem = input_warning("building-too-small", message)
            .with_remedy("choose a finer `resolution`, or merge the buildings of a block, if they matter")
            .with_at(at);
        findings.add(source, problem);
    }
    if let Some(at) = first(broken) {
        let message = format!(
            "{} of {} buildings of {name} are so narrow that their cells do not hang together: water passes between them",
            broken.len(),
            count
        );
        let remedy = "choose a finer `resolution`, or draw such a building as a wall (`structures.walls`)";
        findings.add(source, input_warning("building-too-narrow", message).with_remedy(remedy).with_at(at));
    }
}

/// Whether some of these cells do not hang together with the others, not even by a corner.
fn are_apart(cells: &[usize], lattice: &Lattice) -> bool {
    let Some(&first) = cells.first() else { return false };
    let mut left: BTreeSet<usize> = cells.iter().copied().collect();
    left.remove(&first);
    let mut reached = vec![first];
    while let Some(cell) = reached.pop() {
        let (column, row) = lattice.column_row(cell);
        for near_row in row.saturating_sub(1)..=(row + 1).min(lattice.rows - 1) {
            for near_column in column.saturating_sub(1)..=(column + 1).min(lattice.columns - 1) {
                let near = lattice.index(near_column, near_row);
                if left.remove(&near) {
                    reached.push(near);
                }
            }
        }
    }
    !left.is_empty()
}

/// A corner of an area.
fn corner(area: &MultiPolygon<f64>) -> Option<Vec2> {
    use geo::CoordsIter;
    area.coords_iter().next().map(|c| Vec2::new(c.x, c.y))
}

/// Whether the first corner of an area lies on no terrain.
fn is_off(area: &MultiPolygon<f64>, bed: &BedParticles) -> bool {
    let cell = corner(area).and_then(|place| bed.lattice.cell_at(bed.lattice.to_local(place)));
    cell.is_none_or(|cell| !bed.has_terrain(cell))
}
