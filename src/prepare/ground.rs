//! Breaklines and buildings: their files, and what they make of the bed.
//!
//! A breakline takes the cells of a strip along it ([`super::burn`]) and raises or carves their bed to its level there,
//! z = max(z, z_line) or min(z, z_line). A building takes the cells whose centres lie in it.

use std::collections::{BTreeMap, BTreeSet};

use geo::MultiPolygon;

use super::burn::{strip, value_at};
use super::crests::{Buried, Doubt, Height};
use super::findings::Findings;
use super::outside::{Outside, all_outside, partly_outside};
use super::polygons::cells_inside;
use super::shaped::{Change, Changes};
use super::{places, water};
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::scenario::methods::Motion;
use crate::scenario::{Breakline, BreaklineMode, BuildingMode, Buildings, LineLevel, Scenario, Sourced, VectorSource};
use crate::terrain::PLAUSIBLE_ELEVATION;
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

/// Lagrangian particles carry water over a ridge that is narrower than so many spacings: their kernels reach over it from both sides.
/// Behind a levee of 1, 2, 3 and 4 spacings that held a wave of 3 m, up to 0.15 m, 0.02 m, 1 mm and 1 µm were found, behind 5 nothing.
const RIDGE_OF_MOVING: f64 = 5.0;

/// What to do about some lines or buildings beside the terrain, among others on it.
const CHECK_PLACES: &str =
    "nothing, if the file is meant to reach further than the terrain; otherwise correct their coordinates";

/// What could be opened; map coordinates.
#[derive(Debug, Default)]
pub(super) struct Opened {
    /// The lines of each breakline of the scenario.
    breaklines: Vec<Vec<Line>>,
    /// Footprints with the height (m) or the roughness (s·m^(−1/3)) of each.
    buildings: Vec<(MultiPolygon<f64>, f64)>,
}

/// A line with the level (m) at each of its vertices.
#[derive(Debug)]
struct Line {
    /// Number of its feature in the file, from 1.
    number: usize,
    places: Vec<Vec2>,
    levels: Vec<f64>,
}

/// Opens every file of breaklines and buildings.
pub(super) fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Opened {
    let ground = &scenario.ground;
    let breaklines = ground.breaklines.iter().map(|breakline| lines(breakline, crs, scenario, findings)).collect();
    let buildings =
        ground.buildings.as_ref().map_or_else(Vec::new, |buildings| footprints(buildings, crs, scenario, findings));
    Opened { breaklines, buildings }
}

impl Opened {
    /// Footprints of the buildings that are blocked (map coordinates).
    pub fn blocked(&self, scenario: &Scenario) -> impl Iterator<Item = &MultiPolygon<f64>> {
        let are_blocked =
            scenario.ground.buildings.as_ref().is_some_and(|buildings| matches!(buildings.mode, BuildingMode::Block));
        self.buildings.iter().filter(move |_| are_blocked).map(|(footprint, _)| footprint)
    }
}

/// Changes the bed, and its roughness.
pub(super) fn on_lattice(
    opened: &Opened,
    scenario: &Scenario,
    bed: &mut BedParticles,
    changes: &mut Changes,
    findings: &mut Findings,
) {
    for (breakline, lines) in scenario.ground.breaklines.iter().zip(&opened.breaklines) {
        let narrowest = RIDGE_OF_MOVING * bed.lattice.spacing;
        if scenario.numerics.motion == Motion::Lagrangian
            && breakline.mode == BreaklineMode::Raise
            && breakline.width.is_none_or(|width| width < narrowest)
        {
            findings.add(&breakline.lines, too_narrow(breakline, narrowest));
        }
        burn(breakline, lines, bed, changes, findings);
    }
    if let Some(buildings) = &scenario.ground.buildings {
        build(buildings, &opened.buildings, bed, changes, findings);
    }
}

/// The problem of a ridge that does not hold Lagrangian particles.
fn too_narrow(breakline: &Breakline, narrowest: f64) -> Problem {
    let message = format!("Lagrangian particles pass a raised line that is narrower than {narrowest} m");
    let width =
        if is_wall(breakline) { "take `crest` out, so that nothing passes the wall" } else { "give it that `width`" };
    Problem::error(ProblemKind::Scenario, "method-combination", "", message)
        .with_cause(format!("their kernels reach over a ridge of less than {RIDGE_OF_MOVING} spacings from both sides"))
        .with_remedy(format!(
            "leave `numerics.motion` and `numerics.formulation` out (or write `motion: eulerian`), or {width}"
        ))
}

/// Whether a breakline is a wall with a crest.
fn is_wall(breakline: &Breakline) -> bool {
    breakline.lines.key.starts_with("structures.")
}

/// The lines of a file with their levels.
fn lines(breakline: &Breakline, crs: Option<&Crs>, scenario: &Scenario, findings: &mut Findings) -> Vec<Line> {
    let source = &breakline.lines;
    let name = source.value.path.display();
    let Some(features) = places::features(source, crs, scenario.reproject, findings) else { return Vec::new() };
    let has_line = |feature: &Feature| feature.lines.iter().any(places::has_length) || !feature.polygons.is_empty();
    findings.add_all(source, places::left_out(source, &features, "line", has_line));
    if let LineLevel::Field(field) = &breakline.level {
        findings.add_all(source, places::unit_of_attribute(source, &[field], &features, scenario));
    }
    let mut lines = Vec::new();
    let mut without_level: Vec<&Feature> = Vec::new();
    let mut count = 0;
    for feature in &features {
        let attribute = match &breakline.level {
            LineLevel::Constant(level) => Some(level.value),
            LineLevel::Field(field) => feature.number(field).filter(|level| level.is_finite()),
            LineLevel::Vertices => None,
        };
        let own = feature.lines.iter().zip(feature.heights.iter().map(Vec::as_slice));
        let outlines = feature.polygons.iter().map(|polygon| (polygon.exterior(), &[][..]));
        for (line, heights) in own.chain(outlines).filter(|(line, _)| line.0.len() >= 2) {
            count += 1;
            let level = |vertex: usize| match breakline.level {
                LineLevel::Vertices => heights.get(vertex).copied().filter(|z| z.is_finite()),
                _ => attribute,
            };
            let mut vertices: Vec<(Vec2, Option<f64>)> =
                line.0.iter().enumerate().map(|(i, c)| (Vec2::new(c.x, c.y), level(i))).collect();
            vertices.dedup_by_key(|vertex| vertex.0);
            let (places, levels): (Vec<Vec2>, Vec<Option<f64>>) = vertices.into_iter().unzip();
            match levels.into_iter().collect() {
                Some(levels) => lines.push(Line { number: feature.number, places, levels }),
                None => without_level.push(feature),
            }
        }
    }
    if count == 0 {
        let problem = input_error("no-lines", format!("{name} holds no line"));
        findings.add(source, problem.with_remedy("draw lines, or polygons whose outlines count as lines"));
    }
    let is_odd = |line: &&Line| line.levels.iter().any(|level| !PLAUSIBLE_ELEVATION.contains(level));
    if let Some(odd) = lines.iter().find(is_odd) {
        let odd_level = odd.levels.iter().copied().find(|level| !PLAUSIBLE_ELEVATION.contains(level));
        let message = format!(
            "feature {} of {name} has a level of {} m, as none on Earth",
            odd.number,
            odd_level.unwrap_or(f64::NAN)
        );
        let problem = input_error("implausible-level", message)
            .with_cause("a code for a missing value, perhaps, or another unit")
            .with_remedy("correct the level, its unit or its datum")
            .with_at(odd.places[0]);
        add_of_level(breakline, problem, findings);
        return Vec::new();
    }
    if let Some(first) = without_level.first() {
        findings.add(source, no_level(breakline, first, without_level.len(), count));
    }
    lines
}

/// The problem of lines without a level.
fn no_level(breakline: &Breakline, first: &Feature, missing: usize, count: usize) -> Problem {
    let name = breakline.lines.value.path.display();
    let message = match (missing, count) {
        (_, 1) => format!("the line of {name} has no level"),
        (1, _) => format!("one of the {count} lines of {name} has no level: feature {}", first.number),
        _ => format!("{missing} of {count} lines of {name} have no level, the first is feature {}", first.number),
    };
    let names = first.attribute_names();
    let (constant, field) = if is_wall(breakline) { ("crest", "crest_field") } else { ("z", "z_field") };
    match &breakline.level {
        LineLevel::Vertices => input_error("no-level", message)
            .with_cause(format!(
                "its vertices have no z coordinate, and the scenario names no level; its attributes: {names}"
            ))
            .with_remedy("add `z: 105 m`, or name the attribute with `z_field`"),
        _ => input_error("no-level", message)
            .with_cause(format!(
                "looked for a number in the attribute {}; its attributes: {names}",
                if let LineLevel::Field(field) = &breakline.level { field.as_str() } else { "z" }
            ))
            .with_remedy(format!("name another attribute with `{field}`, fill it in, or write `{constant}: 105 m`")),
    }
}

/// Adds a problem of the level of a breakline, where the scenario or the file says it.
fn add_of_level(breakline: &Breakline, problem: Problem, findings: &mut Findings) {
    match &breakline.level {
        LineLevel::Constant(level) => findings.add(level, problem),
        _ => findings.add(&breakline.lines, problem),
    }
}

/// Raises or carves the bed along the lines of a file.
fn burn(breakline: &Breakline, lines: &[Line], bed: &mut BedParticles, changes: &mut Changes, findings: &mut Findings) {
    let source = &breakline.lines;
    let name = source.value.path.display();
    let lattice = bed.lattice.clone();
    let is_raised = breakline.mode == BreaklineMode::Raise;
    let mut outside: Vec<&Line> = Vec::new();
    // The first that is higher or deeper than dams and cuts are, and those of which a good part lies below the ground.
    let mut doubtful: Option<(&Line, Doubt)> = None;
    let mut buried: Vec<(&Line, Buried)> = Vec::new();
    // The straight pieces of the others.
    let mut pieces: Vec<[Vec2; 2]> = Vec::new();
    // Lines that change nothing, each with the place and the ground where it comes nearest to it.
    let mut idle: Vec<(&Line, usize, f64)> = Vec::new();
    for line in lines {
        let local: Vec<Vec2> = line.places.iter().map(|place| lattice.to_local(*place)).collect();
        let cells = strip(&local, breakline.width.unwrap_or(0.0), &lattice);
        let levels: BTreeMap<usize, f64> = cells
            .into_iter()
            .filter(|&cell| bed.has_terrain(cell))
            .map(|cell| (cell, value_at(lattice.centre(cell), &local, &line.levels)))
            .collect();
        // How far the line lies above the ground that it raises, or below that which it carves.
        let height = |(cell, level): (&usize, &f64)| {
            let above = level - bed.elevation[*cell];
            (*cell, if is_raised { above } else { -above })
        };
        let heights = || levels.iter().map(height);
        let by_height = |a: &Height, b: &Height| a.1.total_cmp(&b.1);
        let Some((least, most)) = heights().min_by(by_height).zip(heights().max_by(by_height)) else {
            outside.push(line);
            continue;
        };
        if most.1 <= 0.0 {
            idle.push((line, most.0, -most.1));
        } else if is_raised {
            buried.extend(Buried::of(&local, &line.levels, bed).map(|part| (line, part)));
        }
        doubtful = doubtful.or_else(|| Some((line, Doubt::of([least, most])?)));
        pieces.extend(local.windows(2).map(|pair| [pair[0], pair[1]]));
        for (cell, level) in levels {
            let change = if is_raised { Change::Raise(level) } else { Change::Carve(level) };
            changes.make(cell, change, bed);
        }
    }
    if let Some(first) = outside.first() {
        let at = first.places[0];
        if outside.len() == lines.len() {
            all_outside(source, at, findings);
        } else {
            let message = format!(
                "{} of {} lines of {name} lie outside the terrain, the first is feature {}",
                outside.len(),
                lines.len(),
                first.number
            );
            let problem = input_warning("outside-terrain", message).with_cause("they change no ground");
            findings.add(source, problem.with_remedy(CHECK_PLACES).with_at(at));
        }
    }
    let feature = |line: &Line| format!("feature {} of {name}", line.number);
    if let Some((line, doubt)) = doubtful {
        let problem = doubt.problem(&feature(line), if is_raised { "above" } else { "below" });
        add_of_level(breakline, problem.with_at(lattice.to_map(lattice.centre(doubt.cell))), findings);
    }
    if let Some((line, part)) = buried.first() {
        let others = if buried.len() > 1 { format!(" (one of {} such lines)", buried.len()) } else { String::new() };
        let problem = part.problem(&format!("{}{others}", feature(line)));
        add_of_level(breakline, problem.with_at(lattice.to_map(part.place)), findings);
    }
    let off = Outside::beyond_reach(pieces, bed);
    findings.add_all(source, partly_outside(source, off, lattice.spacing, "it changes no ground there"));
    if let Some(&(first, cell, least)) = idle.iter().min_by(|a, b| a.2.total_cmp(&b.2)) {
        let (code, side) = if is_raised { ("crest-below-terrain", "below") } else { ("invert-above-terrain", "above") };
        let message = format!(
            "{} of {} lines of {name} lie {side} the terrain all along and change nothing; feature {} comes nearest to it, {least:.2} m {side}",
            idle.len(),
            lines.len(),
            first.number
        );
        let at = lattice.to_map(lattice.centre(cell));
        let is_all = idle.len() + outside.len() == lines.len();
        let problem = if is_all { input_error(code, message) } else { input_warning(code, message) };
        let problem =
            problem.with_remedy("correct the level, its unit or its datum, or the place of the line").with_at(at);
        add_of_level(breakline, problem, findings);
    }
}

/// The footprints of a file, each with its height or roughness.
fn footprints(
    buildings: &Buildings,
    crs: Option<&Crs>,
    scenario: &Scenario,
    findings: &mut Findings,
) -> Vec<(MultiPolygon<f64>, f64)> {
    let source = &buildings.polygons;
    let name = source.value.path.display();
    let Some(features) = places::features(source, crs, scenario.reproject, findings) else { return Vec::new() };
    findings.add_all(source, places::left_out(source, &features, "polygon", |feature| !feature.polygons.is_empty()));
    if let BuildingMode::Raise { height: None, field } = &buildings.mode {
        let names = field.as_deref().map_or(HEIGHT_NAMES.to_vec(), |field| vec![field]);
        findings.add_all(source, places::unit_of_attribute(source, &names, &features, scenario));
    }
    let mut found = Vec::new();
    let (mut count, mut without, mut beyond, mut tall) = (0, Vec::new(), Vec::new(), Vec::new());
    for feature in features.iter().filter(|feature| !feature.polygons.is_empty()) {
        count += 1;
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
            None => without.push(feature),
            Some(value) if !(least..=greatest).contains(&value) => beyond.push((feature, value)),
            Some(value) => {
                // A roughness is less.
                tall.extend((value > TALL_BUILDING).then_some((feature, value)));
                found.extend(is_usable.then(|| (MultiPolygon::new(feature.polygons.clone()), value)));
            }
        }
    }
    if count == 0 {
        let problem = input_error("empty-polygon", format!("{name} holds no polygon"));
        findings.add(source, problem.with_remedy("draw the footprints of the buildings as polygons"));
    }
    if let Some(first) = without.first() {
        findings.add(source, no_value(buildings, first, without.len(), count));
    }
    if let Some((first, value)) = beyond.first() {
        let message = format!(
            "{} of {count} polygons of {name} have a value that no building has, the first is feature {} with {value}",
            beyond.len(),
            first.number
        );
        let remedy = match buildings.mode {
            BuildingMode::Roughness(_) => "give a Manning roughness above 0 and at most 0.5",
            _ => "give a height of 0 to 1000 m, in metres",
        };
        findings.add(source, input_error("building-range", message).with_remedy(remedy));
    }
    if let Some((first, value)) = tall.first() {
        let message = format!(
            "{} of {count} polygons of {name} are higher than {TALL_BUILDING} m, the first is feature {} with {value} m",
            tall.len(),
            first.number
        );
        let problem =
            input_warning("doubtful-height", message).with_cause("hardly any building is; another unit, perhaps");
        findings.add(source, problem.with_remedy("correct the heights, which count in metres above the ground"));
    }
    found
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

/// Puts buildings on the lattice.
fn build(
    buildings: &Buildings,
    footprints: &[(MultiPolygon<f64>, f64)],
    bed: &mut BedParticles,
    changes: &mut Changes,
    findings: &mut Findings,
) {
    let source = &buildings.polygons;
    let name = source.value.path.display();
    let lattice = bed.lattice.clone();
    // A cell that two share gets the higher value.
    let mut cells: BTreeMap<usize, f64> = BTreeMap::new();
    let (mut outside, mut small, mut broken) = (Vec::new(), Vec::new(), Vec::new());
    for (area, value) in footprints {
        let inside = cells_inside(area, &lattice);
        if !matches!(buildings.mode, BuildingMode::Roughness(_))
            && area.0.iter().any(|part| are_apart(&cells_inside(&MultiPolygon(vec![part.clone()]), &lattice), &lattice))
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
    let first = |areas: &[&MultiPolygon<f64>]| areas.first().and_then(|area| corner(area));
    if let Some(at) = first(&outside) {
        let message = format!("{} of {} buildings of {name} lie outside the terrain", outside.len(), footprints.len());
        let problem = if outside.len() == footprints.len() {
            input_error("outside-terrain", message).with_remedy("check that the file and the terrain have the same CRS")
        } else {
            input_warning("outside-terrain", message).with_remedy(CHECK_PLACES)
        };
        findings.add(source, problem.with_at(at));
    }
    if let Some(at) = first(&small) {
        let message = format!(
            "{} of {} buildings of {name} hold the centre of no cell and are left out",
            small.len(),
            footprints.len()
        );
        let problem = input_warning("building-too-small", message)
            .with_remedy("choose a finer `resolution`, or merge the buildings of a block, if they matter")
            .with_at(at);
        findings.add(source, problem);
    }
    if let Some(at) = first(&broken) {
        let message = format!(
            "{} of {} buildings of {name} are so narrow that their cells do not hang together: water passes between them",
            broken.len(),
            footprints.len()
        );
        let remedy = "choose a finer `resolution`, or draw such a building as a wall (`structures.walls`)";
        findings.add(source, input_warning("building-too-narrow", message).with_remedy(remedy).with_at(at));
    }
    for (cell, value) in cells.into_iter().filter(|(cell, _)| bed.elevation[*cell].is_finite()).collect::<Vec<_>>() {
        match buildings.mode {
            BuildingMode::Block => {
                changes.make(cell, Change::Block, bed);
                bed.sealed.push(cell);
            }
            BuildingMode::Raise { .. } => changes.make(cell, Change::Lift(value), bed),
            BuildingMode::Roughness(_) => bed.manning[cell] = value,
        }
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
