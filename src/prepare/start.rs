//! Water of the start without a level: areas and rivers of one depth, and the state of an earlier run.
//!
//! Water of a depth lies on cells that no body of still water holds. A river takes the cells of a strip along its axis
//! ([`super::burn`]). The state of an earlier run is taken cell by cell from its `fields.nc`, which must have the same
//! lattice: depth, velocity and, where the bed was another one there, the bed, z = η − d. Single precision is what the file
//! has: a depth of d comes back within 6e-8 d.

use std::path::Path;

use geo::MultiPolygon;

use super::burn::strip;
use super::findings::Findings;
use super::polygons::cells_inside;
use super::shaped::Changes;
use super::{places, water};
use crate::bed::{BedParticles, derive_shape};
use crate::error::{Problem, ProblemKind};
use crate::geodata::{Crs, readable_file, same_horizontal, spatial_ref};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::output::OutputCrs;
use crate::scenario::methods::{Motion, Seeding};
use crate::scenario::{BoundaryCondition, EarlierRun, RiverWidth, Scenario, WaterOfDepth};
use crate::seeding::StillWater;
use crate::solver::Breach;

/// Share of a level or a depth that single precision and one sum may cost.
const SINGLE_PRECISION: f64 = 2.5e-7;
/// A change of the bed by the earlier run that is told (m).
const TOLD_CHANGE: f64 = 1e-3;
/// A difference between the beds of two runs (m) that makes them runs on different terrain.
const OTHER_BED: f64 = 0.05;
/// From here on a value is the one that NetCDF itself puts where nothing was written.
const UNWRITTEN: f64 = 9e36;
/// Share of a cell by which its coordinates may miss those of the file.
const SAME_PLACE: f64 = 1e-6;

fn input_error(code: &'static str, message: String) -> Problem {
    Problem::error(ProblemKind::Input, code, "", message)
}

/// The place of water with a depth; map coordinates.
#[derive(Debug)]
enum Place {
    Area(MultiPolygon<f64>),
    /// Lines with the width (m) of each.
    River(Vec<(Vec<Vec2>, f64)>),
}

/// What could be opened, for each entry.
#[derive(Debug, Default)]
pub(super) struct Opened(Vec<Option<Place>>);

/// Opens the files of water with a depth, and refuses what moving particles do not have. (Two halves of a flood with 300 of them differed
/// from the whole by 0.2 m of depth, when they were laid anew on the cells in between; with resting ones by 2e-5 m.)
pub(super) fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Opened {
    let start = &scenario.start;
    if scenario.numerics.motion == Motion::Lagrangian {
        let refused = |message: &str, cause: &str, remedy: &str| {
            Problem::error(ProblemKind::Scenario, "method-combination", "", message)
                .with_cause(cause)
                .with_remedy(remedy)
        };
        if let Some(earlier) = &start.earlier {
            let problem = refused(
                "moving particles do not go on where another run was",
                "its file has the water on the lattice, and particles laid anew on that are not where they were",
                "leave `numerics.motion` and `numerics.formulation` out (or write `motion: eulerian`)",
            );
            findings.add(&earlier.fields, problem);
        }
        for water in start.depths.iter().filter(|_| scenario.numerics.seeding == Seeding::EqualVolume) {
            let problem = refused(
                "equal-volume filling knows no water of a depth",
                "it fills bodies of still water to their level",
                "write `seeding: lattice`, or give a `level`",
            );
            findings.add(&water.place, problem);
        }
    }
    if let Some(earlier) = &start.earlier {
        let table = earlier.fields.value.with_file_name("tables").join("channels.csv");
        let message = match (scenario.channels.is_empty(), table.is_file()) {
            (false, _) => Some("a run with `channels` does not go on where another run was".to_owned()),
            (true, true) => Some(format!("{} is of a run with channels", earlier.fields.value.display())),
            (true, false) => None,
        };
        if let Some(message) = message {
            let problem = Problem::error(ProblemKind::Scenario, "channels-of-earlier-run", "", message)
                .with_cause("`fields.nc` has the water of the plane only, and that in the channels would be lost")
                .with_remedy(
                    "run it whole, from its start: give water with a level or a depth, and a later `time.end`",
                );
            findings.add(&earlier.fields, problem);
        }
        for boundary in scenario.boundaries.iter().filter(|b| matches!(b.value.condition, BoundaryCondition::Free)) {
            let message =
                "this boundary takes the water before it at the start as that of a sea or lake at rest beyond";
            let problem = Problem::warning(ProblemKind::Scenario, "free-after-earlier-run", "", message)
                .with_cause("the start is the last moment of the earlier run, whose own start may have been dry here")
                .with_remedy("give a `stage`, or `normal_depth` for water that only leaves");
            findings.add(boundary, problem);
        }
    }
    Opened(start.depths.iter().map(|water| place(water, crs, scenario, findings)).collect())
}

fn place(water: &WaterOfDepth, crs: Option<&Crs>, scenario: &Scenario, findings: &mut Findings) -> Option<Place> {
    let Some(width) = &water.river else {
        return water::area(&water.place, crs, scenario, findings).map(Place::Area);
    };
    let source = &water.place;
    let name = source.value.path.display();
    let features = places::features(source, crs, scenario.reproject, findings)?;
    let (mut lines, mut without) = (Vec::new(), Vec::new());
    for feature in &features {
        let width = match width {
            RiverWidth::Cell => Some(0.0),
            RiverWidth::Constant(width) => Some(*width),
            RiverWidth::Field(field) => feature.number(field).filter(|width| width.is_finite() && *width > 0.0),
        };
        for line in feature.lines.iter().filter(|line| line.0.len() >= 2) {
            let mut places: Vec<Vec2> = line.0.iter().map(|c| Vec2::new(c.x, c.y)).collect();
            places.dedup();
            match width {
                Some(width) => lines.push((places, width)),
                None => without.push(feature),
            }
        }
    }
    if let (Some(first), RiverWidth::Field(field)) = (without.first(), width) {
        let names: Vec<&str> = first.attributes.iter().map(|(name, _)| name.as_str()).collect();
        let message = format!("{} lines of {name} have no width, the first is feature {}", without.len(), first.number);
        let problem = input_error("no-width", message)
            .with_cause(format!("looked for a length above 0 in {field}; the attributes are: {}", names.join(", ")))
            .with_remedy("name another attribute with `width_field`, fill it in, or write `width: 12 m`");
        findings.add(source, problem);
        return None;
    }
    if lines.is_empty() {
        let problem = input_error("no-lines", format!("{name} holds no line"));
        findings.add(source, problem.with_remedy("draw the axis of the river as lines"));
        return None;
    }
    Some(Place::River(lines))
}

/// Puts water with a depth on the cells that have none yet.
pub(super) fn wet(
    opened: &Opened,
    scenario: &Scenario,
    (bed, changes): (&BedParticles, &Changes),
    still: &mut StillWater,
    findings: &mut Findings,
) {
    let lattice = &bed.lattice;
    for (water, place) in scenario.start.depths.iter().zip(&opened.0) {
        let Some(place) = place else { continue };
        let (cells, corner) = match place {
            Place::Area(area) => {
                use geo::CoordsIter;
                (cells_inside(area, lattice), area.coords_iter().next().map(|c| Vec2::new(c.x, c.y)))
            }
            Place::River(lines) => {
                let local = |line: &[Vec2]| line.iter().map(|place| lattice.to_local(*place)).collect::<Vec<_>>();
                let cells = lines.iter().flat_map(|(line, width)| strip(&local(line), *width, lattice)).collect();
                (cells, lines.first().map(|(line, _)| line[0]))
            }
        };
        let on_terrain: Vec<usize> = cells.into_iter().filter(|&cell| bed.has_terrain(cell)).collect();
        if on_terrain.is_empty() {
            let name = water.place.value.path.display();
            let problem = input_error("outside-terrain", format!("no cell of the terrain lies in what {name} draws"))
                .with_remedy("check that the file and the terrain have the same CRS, or take a finer `resolution`");
            findings.add(&water.place, Problem { at: corner, ..problem });
        }
        for cell in on_terrain {
            // No depth lies on the crest of a dam or of a levee.
            if still.body[cell].is_none() && !changes.raises(cell) {
                still.depth[cell] = water.depth.value;
            }
        }
    }
}

/// The state of a run at one of its moments, on the cells of the lattice.
struct State {
    /// Depth (m), NaN where the earlier run had no terrain.
    depth: Vec<f64>,
    /// Level (m), NaN where there was no water.
    level: Vec<f64>,
    /// Velocity (m/s).
    velocity: Vec<Vec2>,
}

/// Takes over the state of an earlier run; hands out the velocity (m/s) of each cell.
pub(super) fn take_over(
    scenario: &Scenario,
    crs: &OutputCrs,
    (breach, changes): (Option<&Breach>, &Changes),
    bed: &mut BedParticles,
    still: &mut StillWater,
    findings: &mut Findings,
) -> Vec<Vec2> {
    let Some(earlier) = &scenario.start.earlier else { return Vec::new() };
    let path = &earlier.fields.value;
    let Some(file) = findings.take(&earlier.fields, open_fields(path)) else { return Vec::new() };
    let fits = same_lattice(&file, path, &bed.lattice).and_then(|()| same_crs(&file, path, crs));
    if findings.take(&earlier.fields, fits).is_none() {
        return Vec::new();
    }
    let state = record(&file, path, earlier)
        .and_then(|record| read(&file, path, record, bed).map_err(|problem| (false, problem)));
    let state = match (state, &earlier.time) {
        (Ok(state), _) => state,
        (Err((true, problem)), Some(time)) => {
            findings.add(time, problem);
            return Vec::new();
        }
        (Err((_, problem)), _) => {
            findings.add(&earlier.fields, problem);
            return Vec::new();
        }
    };
    findings.add_all(&earlier.fields, other_dry_ground(&state, path, bed));
    let fits = lay(&state, path, (breach, changes), bed, still);
    match fits {
        Ok(warning) => {
            findings.add_all(&earlier.fields, warning);
            state.velocity
        }
        Err(problem) => {
            findings.add(&earlier.fields, *problem);
            Vec::new()
        }
    }
}

/// Puts the depths on the lattice, and the bed of the earlier run under them where it was another one.
fn lay(
    state: &State,
    path: &Path,
    (breach, changes): (Option<&Breach>, &Changes),
    bed: &mut BedParticles,
    still: &mut StillWater,
) -> Result<Option<Problem>, Box<Problem>> {
    let name = path.display();
    let place = |cell: usize, bed: &BedParticles| bed.lattice.to_map(bed.lattice.centre(cell));
    let lost: Vec<usize> =
        (0..state.depth.len()).filter(|&cell| state.depth[cell] > 0.0 && !bed.has_terrain(cell)).collect();
    if let Some(&first) = lost.first() {
        let volume = lost.iter().map(|&cell| state.depth[cell]).sum::<f64>() * bed.lattice.cell_area();
        let message = format!("{name} has {volume:.3e} m³ of water on {} cells without terrain", lost.len());
        let problem = input_error("water-without-terrain", message)
            .with_remedy("take the terrain and the buildings of that run")
            .with_at(place(first, bed));
        return Err(Box::new(problem));
    }
    let mut rises = Vec::new();
    for cell in (0..state.depth.len()).filter(|&cell| state.depth[cell] > 0.0) {
        let (depth, level) = (state.depth[cell], state.level[cell]);
        still.depth[cell] = depth;
        let rise = level - depth - bed.elevation[cell];
        // Where the level is not known the bed is that of this scenario.
        if rise.is_nan() {
            continue;
        }
        if rise.abs() <= SINGLE_PRECISION * (level.abs() + depth) {
            rises.push((cell, 0.0));
            continue;
        }
        if breach.is_some_and(|breach| breach.cells.iter().any(|dam| dam.cell == cell)) {
            let message = format!("{name} has water where the dam of `breach` stands, on a bed that is not its crest");
            let problem = input_error("water-in-dam", message)
                .with_cause("the dam was not there in the earlier run, or it had broken")
                .with_remedy(
                    "take a moment before the dam broke, run it whole from its start, or put what still stands of the dam under \
                     `terrain.breaklines` with `mode: raise` in place of `breach` (without either there is no dam)",
                )
                .with_at(place(cell, bed));
            return Err(Box::new(problem));
        }
        rises.push((cell, rise));
    }
    if let Some(problem) = other_bed(&rises, path, changes, bed) {
        return Err(Box::new(problem));
    }
    let (mut changed, mut largest) = (0, (0.0_f64, 0));
    for (cell, rise) in rises {
        bed.elevation[cell] += rise;
        if rise.abs() > TOLD_CHANGE {
            changed += 1;
            if rise.abs() > largest.0.abs() {
                largest = (rise, cell);
            }
        }
    }
    derive_shape(bed);
    Ok((changed > 0).then(|| {
        let message = format!("the bed of {changed} wet cells is that of {name}, by {:+.3} m at most", largest.0);
        Problem::warning(ProblemKind::Input, "bed-of-earlier-run", "", message)
            .with_cause(
                "the shore of still water was fitted in that run, its bed had changed, or its terrain was another one",
            )
            .with_remedy("nothing, if a shore was fitted or a dam broke there; otherwise take the terrain of that run, or run from the start")
            .with_at(place(largest.1, bed))
    }))
}

/// What speaks against the bed under the water of the earlier run, given by how much it lies above that of this one (m): a
/// change that this scenario makes and that run did not have, or another terrain throughout.
fn other_bed(rises: &[(usize, f64)], path: &Path, changes: &Changes, bed: &BedParticles) -> Option<Problem> {
    let name = path.display();
    let place = |cell: usize| bed.lattice.to_map(bed.lattice.centre(cell));
    let (built, natural): (Vec<_>, Vec<_>) = rises.iter().copied().partition(|(cell, _)| changes.moves(*cell));
    let mut sorted = natural;
    sorted.sort_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    if let Some(&(cell, rise)) = sorted.get(sorted.len() / 2).filter(|(_, rise)| rise.abs() > OTHER_BED) {
        let message = format!(
            "under water the bed of {name} differs from that of this run by {:.3} m (median of {} cells)",
            rise.abs(),
            sorted.len()
        );
        return Some(
            input_error("other-terrain", message)
                .with_cause("it ran on another terrain, or with heights above another datum")
                .with_remedy(
                    "take the terrain layers of that run, with their `offset` and `unit`, or run from the start",
                )
                .with_at(place(cell)),
        );
    }
    let off: Vec<_> = built.into_iter().filter(|(_, rise)| rise.abs() > OTHER_BED).collect();
    let (cell, rise) = off.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let message = format!(
        "{name} has water on {} cells that this scenario raises or carves, on another bed, by {rise:+.3} m at most",
        off.len()
    );
    Some(
        input_error("change-under-water", message)
            .with_cause("the earlier run was without the breakline or the building there, had it at another level, or fitted a shore to it")
            .with_remedy("run from the start with it, or take it out and go on")
            .with_at(place(cell)),
    )
}

/// What the maps beside `fields.nc` say of ground that is dry and had another height in the earlier run; nothing where there are none.
///
/// Such a change may be meant (a levee that is built for this half). A breakline that was left out is seen by nothing else.
fn other_dry_ground(state: &State, path: &Path, bed: &BedParticles) -> Option<Problem> {
    let maps = path.with_file_name("maps.nc");
    let elevation = on_lattice(&netcdf::open(&maps).ok()?, "bed_elevation", (.., ..), &maps, &bed.lattice).ok()?;
    let change = |cell: usize| bed.elevation[cell] - elevation[cell];
    let is_other = |cell: &usize| state.depth[*cell] <= 0.0 && change(*cell).abs() > OTHER_BED;
    let other: Vec<usize> = (0..bed.lattice.len()).filter(is_other).collect();
    let &largest = other.iter().max_by(|a, b| change(**a).abs().total_cmp(&change(**b).abs()))?;
    let message = format!(
        "dry ground differs from that of {} on {} cells, by {:+.2} m at most",
        maps.display(),
        other.len(),
        change(largest)
    );
    Some(
        Problem::warning(ProblemKind::Input, "other-dry-ground", "", message)
            .with_cause("a breakline, a building or a layer of the terrain is here and was not there, or the other way round, or a dam broke")
            .with_remedy("nothing, if it is meant; otherwise take the terrain and the structures of that run")
            .with_at(bed.lattice.to_map(bed.lattice.centre(largest))),
    )
}

fn not_fields(path: &Path, cause: String) -> Problem {
    input_error("not-a-fields-file", format!("{} is no `fields.nc` of a run", path.display()))
        .with_cause(cause)
        .with_remedy("name the file `fields.nc` of a finished run")
}

fn open_fields(path: &Path) -> Result<netcdf::File, Problem> {
    readable_file(path)?;
    if path.to_string_lossy().ends_with(".partial.nc") {
        let message = format!("{} is of a run that did not end", path.display());
        return Err(input_error("unfinished-run", message)
            .with_cause("it is written while a run goes on, and its last frame may be cut")
            .with_remedy("name the `fields.nc` of a run that ended"));
    }
    netcdf::open(path).map_err(|cause| not_fields(path, cause.to_string()))
}

/// All values of a variable of one dimension.
fn axis(file: &netcdf::File, name: &str, path: &Path) -> Result<Vec<f64>, Problem> {
    let variable = file.variable(name).ok_or_else(|| not_fields(path, format!("it has no variable `{name}`")))?;
    variable.get_values::<f64, _>(..).map_err(|cause| not_fields(path, format!("variable `{name}`: {cause}")))
}

fn same_lattice(file: &netcdf::File, path: &Path, lattice: &Lattice) -> Result<(), Problem> {
    let (x, y) = (axis(file, "x", path)?, axis(file, "y", path)?);
    let s = lattice.spacing;
    let first = lattice.to_map(lattice.centre(0));
    let is_same = |found: f64, expected: f64| (found - expected).abs() <= SAME_PLACE * s;
    let fits = x.len() == lattice.columns
        && y.len() == lattice.rows
        && x.iter().enumerate().all(|(i, &x)| is_same(x, first.x + i as f64 * s))
        && y.iter().rev().enumerate().all(|(i, &y)| is_same(y, first.y + i as f64 * s));
    if fits {
        return Ok(());
    }
    let cell = |values: &[f64]| if let [a, b, ..] = values { (b - a).abs() } else { f64::NAN };
    let corner = |x: Option<&f64>, y: Option<&f64>| {
        format!("{:.3}, {:.3}", x.copied().unwrap_or(f64::NAN), y.copied().unwrap_or(f64::NAN))
    };
    let message = format!("{} lies on another lattice than this run", path.display());
    Err(input_error("other-lattice", message)
        .with_cause(format!(
            "it has {} by {} cells of {} m from {}; the run has {} by {} of {s} m from {}",
            x.len(),
            y.len(),
            (1e9 * cell(&x)).round() / 1e9,
            corner(x.first(), y.last()),
            lattice.columns,
            lattice.rows,
            corner(Some(&first.x), Some(&first.y))
        ))
        .with_remedy(
            "take the terrain and the `resolution` of the earlier run, in which `outputs.cell` was the resolution",
        ))
}

fn same_crs(file: &netcdf::File, path: &Path, run: &OutputCrs) -> Result<(), Problem> {
    let own = file.variable("crs").map(|crs| match crs.attribute_value("crs_wkt") {
        Some(Ok(netcdf::AttributeValue::Str(wkt))) => wkt,
        _ => String::new(),
    });
    let is_same = match (&own, run) {
        (None, OutputCrs::Local) => true,
        (Some(own), OutputCrs::Projected { wkt2, .. }) => {
            matches!((spatial_ref(own), spatial_ref(wkt2)), (Ok(own), Ok(run)) if same_horizontal(&own, &run))
        }
        _ => false,
    };
    let name = |wkt: Option<&str>| {
        wkt.map_or("local metres".to_owned(), |wkt| wkt.split('"').nth(1).unwrap_or("an unnamed system").to_owned())
    };
    let run_wkt = if let OutputCrs::Projected { wkt2, .. } = run { Some(wkt2.as_str()) } else { None };
    if is_same {
        return Ok(());
    }
    let message = format!("{} has the CRS {}, the run has {}", path.display(), name(own.as_deref()), name(run_wkt));
    Err(input_error("different-crs", message).with_remedy("take the `crs` of the earlier run"))
}

/// The number of the frame that is asked for; whether the time is at fault, and the problem otherwise.
fn record(file: &netcdf::File, path: &Path, earlier: &EarlierRun) -> Result<usize, (bool, Problem)> {
    let times = axis(file, "time", path).map_err(|problem| (false, problem))?;
    let Some((first, last)) = times.first().zip(times.last()) else {
        return Err((false, not_fields(path, "it has no frame".to_owned())));
    };
    let Some(wanted) = earlier.time.as_ref().map(|time| time.value) else {
        if last.is_nan() || *last > UNWRITTEN {
            let message = format!("the last frame of {} has no time", path.display());
            let problem = input_error("incomplete-frame", message)
                .with_cause("the file was cut or changed")
                .with_remedy("take a frame that is whole with `time`");
            return Err((false, problem));
        }
        return Ok(times.len() - 1);
    };
    let distance = |record: &usize| (times[*record] - wanted).abs();
    let nearest = (0..times.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
    if distance(&nearest) <= 1e-6 * (1.0 + wanted) {
        return Ok(nearest);
    }
    let message = format!("{} has no frame at {wanted} s", path.display());
    let problem = input_error("no-such-frame", message)
        .with_cause(format!("its {} frames go from {first} s to {last} s", times.len()))
        .with_remedy(format!("take the nearest one, `time: {} s`, or `time: last`", times[nearest]));
    Err((true, problem))
}

/// A part of a variable on the cells of the lattice, NaN where it has no value; the rows of the file count from the north.
fn on_lattice<E: TryInto<netcdf::Extents, Error: Into<netcdf::Error>>>(
    file: &netcdf::File,
    name: &str,
    part: E,
    path: &Path,
    lattice: &Lattice,
) -> Result<Vec<f64>, Problem> {
    let variable = file.variable(name).ok_or_else(|| not_fields(path, format!("it has no variable `{name}`")))?;
    let part = part.try_into().map_err(Into::into);
    let values = part
        .and_then(|part: netcdf::Extents| variable.get_values::<f64, _>(part))
        .map_err(|cause| not_fields(path, format!("variable `{name}`: {cause}")))?;
    if values.len() != lattice.len() {
        return Err(not_fields(path, format!("variable `{name}` does not fill the grid")));
    }
    let fill = f64::from(crate::output::FILL);
    let from_north = |cell: usize| {
        let (column, row) = lattice.column_row(cell);
        let value = values[(lattice.rows - 1 - row) * lattice.columns + column];
        if value.to_bits() == fill.to_bits() || value.abs() > UNWRITTEN { f64::NAN } else { value }
    };
    Ok((0..lattice.len()).map(from_north).collect())
}

/// The state of one frame, which must have a value in each cell with terrain.
fn read(file: &netcdf::File, path: &Path, record: usize, bed: &BedParticles) -> Result<State, Problem> {
    let lattice = &bed.lattice;
    let frame = |name: &str| on_lattice(file, name, (record, .., ..), path, lattice);
    let (depth, level) = (frame("depth")?, frame("water_level")?);
    let (u, v) = (frame("velocity_x")?, frame("velocity_y")?);
    let unsound = |cell: &usize| {
        depth[*cell].is_infinite()
            || depth[*cell] < 0.0
            || (depth[*cell] > 0.0 && !(u[*cell].is_finite() && v[*cell].is_finite()))
    };
    if let Some(cell) = (0..lattice.len()).find(unsound) {
        let cause = format!("depth {} m, velocity {}, {} m/s in one cell", depth[cell], u[cell], v[cell]);
        return Err(not_fields(path, cause).with_at(lattice.to_map(lattice.centre(cell))));
    }
    let is_missing = |cell: &usize| bed.has_terrain(*cell) && (depth[*cell] + u[*cell] + v[*cell]).is_nan();
    let missing: Vec<usize> = (0..lattice.len()).filter(is_missing).collect();
    if let Some(&first) = missing.first() {
        let message = format!(
            "frame {} of {} has no depth or no velocity on {} cells with terrain",
            record + 1,
            path.display(),
            missing.len()
        );
        return Err(input_error("incomplete-frame", message)
            .with_cause("the file was cut or changed, or the earlier run had a building or no terrain there")
            .with_remedy("take a frame that is whole with `time`, and the terrain and the buildings of that run")
            .with_at(lattice.to_map(lattice.centre(first))));
    }
    if !depth.iter().any(|depth| *depth > 0.0) {
        let message = format!("frame {} of {} has no water", record + 1, path.display());
        return Err(input_error("no-water", message)
            .with_cause("the depth is 0 in all its cells")
            .with_remedy("take another moment with `time`, or leave `fields` out for a dry start"));
    }
    let velocity = u.iter().zip(&v).map(|(&u, &v)| if u.is_finite() { Vec2::new(u, v) } else { Vec2::ZERO }).collect();
    Ok(State { depth, level, velocity })
}
