//! Reads the `fields.nc` of an earlier run: a lattice that fits, the same reference system, one frame.

use std::path::Path;

use crate::error::{Problem, input_error};
use crate::geodata::{netcdf_file, readable_file, same_horizontal, spatial_ref};
use crate::lattice::Lattice;
use crate::math::{Rectangle, Vec2};
use crate::output::OutputCrs;
use crate::plain_file;
use crate::prepare::water::earlier_cells::{Between, Laid};
use crate::prepare::water::earlier_state::{Frame, State};
use crate::scenario::EarlierRun;

/// From here on a value is the one that NetCDF itself puts where nothing was written.
const UNWRITTEN: f64 = 9e36;
/// Deeper (m) is no sea, and faster (m/s) no water: a file with such values is damaged.
const DEEPEST: f64 = 11_000.0;
const FASTEST: f64 = 1000.0;

fn not_fields(path: &Path, cause: String) -> Problem {
    input_error("not-a-fields-file", format!("{} is no `fields.nc` of a run", path.display()))
        .with_cause(cause)
        .with_remedy("name the file `fields.nc` of a finished run; where it is that, it is damaged: copy it again")
}

/// Whether the run beside which a file is to stand left the frames out.
fn is_left_out(path: &Path) -> bool {
    let summary = plain_file::read_to_string(path.with_file_name("run.json")).ok();
    let summary: Option<serde_json::Value> = summary.and_then(|text| serde_json::from_str(&text).ok());
    let parts = summary.as_ref().and_then(|summary| summary["not_written"].as_array());
    !path.exists() && parts.is_some_and(|parts| parts.iter().any(|part| part == "fields"))
}

pub fn open_fields(path: &Path) -> Result<netcdf::File, Problem> {
    if is_left_out(path) {
        let message = format!("{} was not written", path.display());
        return Err(input_error("not-written", message)
            .with_cause("`outputs.write` of that run leaves `fields` out")
            .with_remedy("add `fields` to its `outputs.write`, or take the key out, and run it again"));
    }
    readable_file(path)?;
    if path.to_string_lossy().ends_with(".partial.nc") {
        let message = format!("{} is of a run that did not end", path.display());
        return Err(input_error("unfinished-run", message)
            .with_cause("it is written while a run goes on, and its last frame may be cut")
            .with_remedy("name the `fields.nc` of a run that ended"));
    }
    netcdf_file::open(path).map_err(|cause| not_fields(path, cause.to_string()))
}

/// All values of a variable of one dimension.
fn axis(file: &netcdf::File, name: &str, path: &Path) -> Result<Vec<f64>, Problem> {
    let variable = file.variable(name).ok_or_else(|| not_fields(path, format!("it has no variable `{name}`")))?;
    variable.get_values::<f64, _>(..).map_err(|cause| not_fields(path, format!("variable `{name}`: {cause}")))
}

/// The rectangle (map coordinates, m) about the wet cells of the frame from which a run goes on; none where it has none.
pub fn rectangle(earlier: &EarlierRun) -> Option<Rectangle> {
    let path = &earlier.fields.value;
    let file = open_fields(path).ok()?;
    let (x, y) = (axis(&file, "x", path).ok()?, axis(&file, "y", path).ok()?);
    let (record, _) = record(&file, path, earlier).ok()?;
    let depth: Vec<f64> = file.variable("depth")?.get_values((record, .., ..)).ok()?;
    let half = 0.5 * (x.get(1)? - x[0]);
    let wet = depth.iter().enumerate().filter(|(_, depth)| (0.0..UNWRITTEN).contains(*depth) && **depth > 0.0);
    let corners = wet.flat_map(|(index, _)| {
        let centre = Vec2::new(x[index % x.len()], y[index / x.len()]);
        [centre - Vec2::new(half, half), centre + Vec2::new(half, half)]
    });
    Rectangle::about(corners)
}

/// Lays the cells of a file on the lattice.
///
/// - `is_part`: whether the lattice is a part of the terrain, so that it need not reach as far as the file
pub fn laid(file: &netcdf::File, path: &Path, lattice: &Lattice, is_part: bool) -> Result<Laid, Problem> {
    let (x, y) = (axis(file, "x", path)?, axis(file, "y", path)?);
    if let Some(laid) = Laid::on(lattice, (&x, &y), is_part) {
        return Ok(laid);
    }
    let (s, first) = (lattice.spacing, lattice.to_map(lattice.centre(0)));
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
            "take the terrain of the earlier run, and its `resolution` or one that has a common part with it, such as half, twice or one and a \
             half times as much",
        ))
}

pub fn same_crs(file: &netcdf::File, path: &Path, run: &OutputCrs) -> Result<(), Problem> {
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
pub fn record(file: &netcdf::File, path: &Path, earlier: &EarlierRun) -> Result<(usize, f64), (bool, Problem)> {
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
        return Ok((times.len() - 1, *last));
    };
    let distance = |record: &usize| (times[*record] - wanted).abs();
    let nearest = (0..times.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
    if distance(&nearest) <= 1e-6 * (1.0 + wanted) {
        return Ok((nearest, times[nearest]));
    }
    let message = format!("{} has no frame at {wanted} s", path.display());
    let problem = input_error("no-such-frame", message)
        .with_cause(format!("its {} frames go from {first} s to {last} s", times.len()))
        .with_remedy(format!("take the nearest one, `time: {} s`, or `time: last`", times[nearest]));
    Err((true, problem))
}

/// A part of a variable in the order of the file, NaN where it has no value.
pub fn values<E: TryInto<netcdf::Extents, Error: Into<netcdf::Error>>>(
    file: &netcdf::File,
    name: &str,
    part: E,
    path: &Path,
    laid: &Laid,
) -> Result<Vec<f64>, Problem> {
    let variable = file.variable(name).ok_or_else(|| not_fields(path, format!("it has no variable `{name}`")))?;
    let part = part.try_into().map_err(Into::into);
    let mut values = part
        .and_then(|part: netcdf::Extents| variable.get_values::<f64, _>(part))
        .map_err(|cause| not_fields(path, format!("variable `{name}`: {cause}")))?;
    if values.len() != laid.len() {
        return Err(not_fields(path, format!("variable `{name}` does not fill the grid")));
    }
    let fill = f64::from(crate::output::FILL);
    let is_missing = |value: &f64| value.to_bits() == fill.to_bits() || value.abs() > UNWRITTEN;
    values.iter_mut().filter(|value| is_missing(value)).for_each(|value| *value = f64::NAN);
    Ok(values)
}

/// The state of one frame, which must have a value in each cell with terrain.
pub fn read(
    file: &netcdf::File,
    path: &Path,
    (record, time): (usize, f64),
    between: &Between<'_>,
) -> Result<State, Problem> {
    let (laid, lattice) = (&between.laid, &between.bed.lattice);
    let values = |name: &str| values(file, name, (record, .., ..), path, laid);
    let frame = Frame {
        time,
        depth: values("depth")?,
        level: values("water_level")?,
        velocity_x: values("velocity_x")?,
        velocity_y: values("velocity_y")?,
    };
    let Frame { depth, velocity_x: u, velocity_y: v, .. } = &frame;
    let is_unsound = |&index: &usize| {
        depth[index] > DEEPEST
            || depth[index] < 0.0
            || (depth[index] > 0.0 && !(u[index].abs() <= FASTEST && v[index].abs() <= FASTEST))
    };
    let unsound = |cell: usize| laid.of_cell(lattice, cell).find(is_unsound).map(|index| (cell, index));
    if let Some((cell, index)) = (0..lattice.len()).find_map(unsound) {
        let cause = format!("depth {} m, velocity {}, {} m/s in one cell", depth[index], u[index], v[index]);
        return Err(not_fields(path, cause).with_at(lattice.to_map(lattice.centre(cell))));
    }
    let missing = frame.missing(between);
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
    let state = frame.on_cells(between);
    if !state.depth.iter().any(|depth| *depth > 0.0) {
        let message = format!("frame {} of {} has no water", record + 1, path.display());
        return Err(input_error("no-water", message)
            .with_cause("the depth is 0 in all its cells")
            .with_remedy("take another moment with `time`, or leave `fields` out for a dry start"));
    }
    Ok(state)
}
