//! Variables of NetCDF files after the CF conventions: their names, which dimension runs to the north and which to the east, and in
//! what these count.
//!
//! Not here: the values of the axes, from which the reader of rasters takes the place on the map.

use std::path::{Path, PathBuf};

use gdal::spatial_ref::SpatialRef;

use super::describe;
use crate::error::{Problem, input_error};
use crate::plain_file;

/// The direction of an axis on the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    X,
    Y,
}

/// The text of an attribute.
pub fn text_of(variable: &netcdf::Variable, name: &str) -> Option<String> {
    // By way of all attributes: HDF5 tells the user of every one that is asked for and missing.
    let attribute = variable.attributes().find(|attribute| attribute.name() == name)?;
    match attribute.value() {
        Ok(netcdf::AttributeValue::Str(text)) => Some(text),
        _ => None,
    }
}

/// Whether a file begins as one of the NetCDF formats does.
pub fn is_netcdf(path: &Path) -> bool {
    let mut start = [0; 4];
    let read = plain_file::open(path).and_then(|mut file| std::io::Read::read_exact(&mut file, &mut start));
    read.is_ok() && (start.starts_with(b"CDF") || start == *b"\x89HDF")
}

/// The name by which GDAL knows a variable of a NetCDF file.
pub fn gdal_name(path: &Path, variable: &str) -> PathBuf {
    PathBuf::from(format!("NETCDF:\"{}\":{variable}", path.display()))
}

/// Splits `file.nc:variable`, where there is such a NetCDF file and none of the whole name.
pub fn split_variable(path: &Path) -> (PathBuf, Option<String>) {
    let whole = || (path.to_path_buf(), None);
    if path.exists() {
        return whole();
    }
    match path.to_str().and_then(|text| text.rsplit_once(':')) {
        Some((file, variable)) if !variable.is_empty() && is_netcdf(Path::new(file)) => {
            (PathBuf::from(file), Some(variable.to_owned()))
        }
        _ => whole(),
    }
}

/// The variables of a file that may be rasters: those of two dimensions or more, but bounds of an axis.
pub fn raster_variables(path: &Path) -> Vec<String> {
    let Ok(file) = crate::geodata::netcdf_file::open(path) else { return Vec::new() };
    let bounds: Vec<String> = file.variables().filter_map(|variable| text_of(&variable, "bounds")).collect();
    let names = file.variables().filter(|variable| variable.dimensions().len() >= 2).map(|variable| variable.name());
    names.filter(|name| !bounds.contains(name)).collect()
}

/// The dimensions of a variable and their directions.
fn axes_of(file: &netcdf::File, variable: &netcdf::Variable) -> Vec<(String, Option<Axis>)> {
    let names = variable.dimensions().iter().map(netcdf::Dimension::name);
    names.map(|name| (name.clone(), axis_of_dimension(file, &name))).collect()
}

/// Refuses a variable whose last two dimensions are known not to be y and x, in this order: it would be read transposed.
///
/// # Errors
/// The problem, without key and place.
pub fn check_order(file: &netcdf::File, variable: &netcdf::Variable, name: &str) -> Result<(), Problem> {
    let axes = axes_of(file, variable);
    let [.., (before, first), (last, second)] = &axes[..] else { return Ok(()) };
    let place = |axis| axes.iter().position(|(_, found)| *found == Some(axis)).map(|place| axes[place].0.as_str());
    let (y, x) = match (place(Axis::Y), place(Axis::X)) {
        (Some(y), Some(x)) if (first, second) != (&Some(Axis::Y), &Some(Axis::X)) => (y, x),
        // Of the other one no more is known than that it must be the second of the two.
        (None, Some(x)) if *first == Some(Axis::X) => (last.as_str(), x),
        (Some(y), None) if *second == Some(Axis::Y) => (y, before.as_str()),
        _ => return Ok(()),
    };
    let others = axes.iter().map(|(name, _)| name.as_str()).filter(|name| ![y, x].contains(name));
    let order: Vec<&str> = others.chain([y, x]).collect();
    let found: Vec<&str> = axes.iter().map(|(name, _)| name.as_str()).collect();
    let message = format!(
        "the dimensions of `{}` in {name} are {} and not {}",
        variable.name(),
        found.join(", "),
        order.join(", ")
    );
    Err(input_error("axes-swapped", message)
        .with_cause("its rasters would be read transposed")
        .with_remedy(format!("bring them into order: `ncpdq -a {} IN OUT`", order.join(","))))
}

/// Refuses a variable of which it is not known which of its last two dimensions is y and which x.
///
/// # Errors
/// The problem, without key and place.
pub fn check_axes_are_known(file: &netcdf::File, variable: &netcdf::Variable, name: &str) -> Result<(), Problem> {
    let axes = axes_of(file, variable);
    let is_known = |axis| axes.iter().any(|(_, found)| *found == Some(axis));
    let missing = match (is_known(Axis::Y), is_known(Axis::X)) {
        (true, true) => return Ok(()),
        (false, _) => "y",
        (true, false) => "x",
    };
    let found: Vec<&str> = axes.iter().map(|(name, _)| name.as_str()).collect();
    let message = format!("which of the dimensions of `{}` in {name} is {missing} is not known", variable.name());
    Err(input_error("axes-unknown", message)
        .with_cause(format!("they are {}, and no name or attribute of them says `{missing}`", found.join(", ")))
        .with_remedy("give the variables of the last two dimensions the attributes `axis = \"Y\"` and `axis = \"X\"`: `ncatted -a axis,NAME,c,c,Y FILE`"))
}

/// What an axis counts in.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Counts {
    Degrees,
    /// A length of so many metres.
    Length(f64),
    /// A unit that is none of these.
    Unknown,
}

/// Metres of a unit of length in the spellings of UDUNITS, of GDAL and of the scenario; none where it is not known.
pub fn metres_of(unit: &str) -> Option<f64> {
    let unit = unit.trim();
    let lower = unit.to_lowercase();
    // `Mm` is not `mm`.
    let is_of_one_case = unit == lower || unit == unit.to_uppercase();
    match lower.as_str() {
        "m" | "metre" | "metres" | "meter" | "meters" => Some(1.0),
        "kilometre" | "kilometres" | "kilometer" | "kilometers" => Some(1000.0),
        "centimetre" | "centimetres" | "centimeter" | "centimeters" => Some(0.01),
        "millimetre" | "millimetres" | "millimeter" | "millimeters" => Some(0.001),
        "foot" | "feet" | "international_foot" | "international_feet" => Some(0.3048),
        "us_survey_foot" | "us_survey_feet" | "us survey foot" | "us-ft" | "sftus" | "ftus" => Some(1200.0 / 3937.0),
        "yard" | "yards" | "yd" => Some(0.9144),
        "mile" | "miles" | "mi" => Some(1609.344),
        "nautical_mile" | "nautical_miles" | "nmi" => Some(1852.0),
        "km" if is_of_one_case => Some(1000.0),
        "hm" if is_of_one_case => Some(100.0),
        "dm" if is_of_one_case => Some(0.1),
        "cm" if is_of_one_case => Some(0.01),
        "mm" if is_of_one_case => Some(0.001),
        "ft" if is_of_one_case => Some(0.3048),
        "in" if is_of_one_case => Some(0.0254),
        _ => None,
    }
}

/// Whether a unit is a degree of an angle in one of the spellings of CF.
fn is_degree(unit: &str) -> bool {
    let lower = unit.trim().to_lowercase();
    let Some(rest) = lower.strip_prefix("degree") else { return false };
    let way = rest.strip_prefix('s').unwrap_or(rest);
    matches!(way, "" | "_east" | "_north" | "_e" | "_n" | "e" | "n" | "_true")
}

/// What an axis counts in by its attributes and its name; none where nothing says so.
fn counts_of(standard_name: &str, units: &str, name: &str) -> Option<Counts> {
    let is_angle = ["longitude", "latitude"].contains(&standard_name)
        || ["lon", "long", "longitude", "lat", "latitude"].contains(&name.to_lowercase().as_str());
    match units.trim() {
        "" => is_angle.then_some(Counts::Degrees),
        units if is_degree(units) => Some(Counts::Degrees),
        units => Some(metres_of(units).map_or(Counts::Unknown, Counts::Length)),
    }
}

/// An axis whose unit is not that of the reference system, or not metres where there is none.
struct Foreign {
    name: String,
    counts: Counts,
    units: String,
}

impl Foreign {
    fn said(&self) -> String {
        if self.units.is_empty() { "by its name".to_owned() } else { format!("`{}`", self.units) }
    }
}

/// Whether an axis counts in the unit of the reference system, or in metres where there is none.
fn is_of_system(counts: Counts, units: &str, system: Option<&SpatialRef>) -> bool {
    /// Two units of length that differ by less are the same; the two feet differ by 2e-6.
    const SAME: f64 = 1e-7;
    match (system, counts) {
        (Some(system), Counts::Degrees) => system.is_geographic(),
        (Some(system), Counts::Length(metres)) => {
            !system.is_geographic() && (metres / system.linear_units() - 1.0).abs() < SAME
        }
        // The angles at which a satellite looks down, which GDAL turns to metres.
        (Some(system), Counts::Unknown) => {
            ["rad", "radian", "radians"].contains(&units)
                && system.to_wkt().is_ok_and(|text| text.to_lowercase().contains("geostationary"))
        }
        (None, counts) => counts == Counts::Length(1.0),
    }
}

/// Refuses a variable whose axes count in another unit than the reference system of the file, or than metres where it states none:
/// its coordinates would be taken for those.
///
/// # Errors
/// The problem, without key and place.
pub fn check_axis_units(
    file: &netcdf::File,
    variable: &netcdf::Variable,
    name: &str,
    system: Option<&SpatialRef>,
) -> Result<(), Problem> {
    let foreign = |dimension: &netcdf::Dimension| {
        let name = dimension.name();
        let axis = file.variable(&name).filter(|axis| axis.dimensions().len() == 1)?;
        let text = |attribute| text_of(&axis, attribute).unwrap_or_default();
        let units = text("units");
        let counts = counts_of(&text("standard_name"), &units, &name)?;
        (!is_of_system(counts, units.trim(), system)).then_some(Foreign { name, counts, units })
    };
    let dimensions = variable.dimensions();
    let of_raster = &dimensions[dimensions.len().saturating_sub(2)..];
    let axes: Vec<Foreign> = of_raster.iter().filter_map(foreign).collect();
    let Some(first) = axes.first() else { return Ok(()) };
    Err(match system {
        Some(system) => not_of_system(first, name, system),
        None => not_metres(&axes, first, name),
    })
}

fn not_of_system(axis: &Foreign, file: &str, system: &SpatialRef) -> Problem {
    let of_system =
        if system.is_geographic() { "degrees".to_owned() } else { system.linear_units_name().unwrap_or_default() };
    let message = format!(
        "the axis `{}` of {file} counts in {}, and its reference system {} in {of_system}",
        axis.name,
        axis.said(),
        describe(system)
    );
    input_error("axis-unit", message).with_cause("its coordinates would be taken for those of the system").with_remedy(
        "bring the axes to the unit of the system (`ncap2`), or correct their attribute `units` (`ncatted`)",
    )
}

fn not_metres(axes: &[Foreign], first: &Foreign, file: &str) -> Problem {
    let (name, said) = (&first.name, first.said());
    let no_system = "the file states no reference system: its variable has no `grid_mapping`";
    let taken = format!("{no_system}, so that its coordinates would be taken for metres");
    match first.counts {
        Counts::Degrees => {
            input_error("geographic-crs", format!("the axis `{name}` of {file} counts in degrees ({said}), and a run needs metres"))
                .with_cause(format!("{no_system}, so that it cannot be warped either"))
                .with_remedy(
                    "state the system, for WGS 84 by `ncap2 -s 'crs=0;crs@grid_mapping_name=\"latitude_longitude\";NAME@grid_mapping=\"crs\"' IN OUT` \
                     with the name of the variable; then set `terrain.reproject: true` and `crs:` to a metric system",
                )
        }
        Counts::Length(_) => {
            let each = |axis: &Foreign| match axis.counts {
                Counts::Length(metres) => Some(format!("{0}={0}*{metres};{0}@units=\"m\"", axis.name)),
                Counts::Degrees | Counts::Unknown => None,
            };
            let steps: Vec<String> = axes.iter().filter_map(each).collect();
            input_error("not-metric-crs", format!("the axis `{name}` of {file} counts in {said}, and a run needs metres"))
                .with_cause(taken)
                .with_remedy(format!("bring it to metres: `ncap2 -s '{}' IN OUT`", steps.join(";")))
        }
        Counts::Unknown => {
            let each = |axis: &Foreign| format!("-a units,{},o,c,m", axis.name);
            let corrected: Vec<String> = axes.iter().map(each).collect();
            input_error("not-metric-crs", format!("the axis `{name}` of {file} counts in {said}, which is no known unit of a map"))
                .with_cause(taken)
                .with_remedy(format!(
                    "bring the axes to metres (`ncap2`); where they are in metres, say so: `ncatted {} IN OUT`",
                    corrected.join(" ")
                ))
        }
    }
}

fn axis_of_dimension(file: &netcdf::File, dimension: &str) -> Option<Axis> {
    let variable = file.variable(dimension);
    let text = |attribute| variable.as_ref().and_then(|variable| text_of(variable, attribute)).unwrap_or_default();
    axis_of(&text("axis"), &text("standard_name"), &text("units"), dimension)
}

/// The direction that the attributes of an axis give, the surest of them first, or else its name.
fn axis_of(axis: &str, standard_name: &str, units: &str, name: &str) -> Option<Axis> {
    let by_axis = match axis.to_uppercase().as_str() {
        "X" => Some(Axis::X),
        "Y" => Some(Axis::Y),
        _ => None,
    };
    let by_standard_name = match standard_name {
        "projection_x_coordinate" | "longitude" | "grid_longitude" => Some(Axis::X),
        "projection_y_coordinate" | "latitude" | "grid_latitude" => Some(Axis::Y),
        _ => None,
    };
    let by_units = match units {
        "degrees_east" | "degree_east" | "degrees_E" | "degree_E" | "degreesE" | "degreeE" => Some(Axis::X),
        "degrees_north" | "degree_north" | "degrees_N" | "degree_N" | "degreesN" | "degreeN" => Some(Axis::Y),
        _ => None,
    };
    let by_name = match name.to_lowercase().as_str() {
        "x" | "lon" | "long" | "longitude" | "rlon" | "easting" | "xc" | "west_east" => Some(Axis::X),
        "y" | "lat" | "latitude" | "rlat" | "northing" | "yc" | "south_north" => Some(Axis::Y),
        _ => None,
    };
    by_axis.or(by_standard_name).or(by_units).or(by_name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_axis_counts_in_is_known_by_its_units_and_else_by_its_name() {
        for (standard_name, units, name, counts) in [
            ("", "degrees_east", "x", Some(Counts::Degrees)),
            ("", "degree", "rlon", Some(Counts::Degrees)),
            ("longitude", "", "x", Some(Counts::Degrees)),
            ("", "", "Lat", Some(Counts::Degrees)),
            ("projection_x_coordinate", "km", "x", Some(Counts::Length(1000.0))),
            ("projection_x_coordinate", "Meters", "x", Some(Counts::Length(1.0))),
            ("", "m", "lon", Some(Counts::Length(1.0))),
            ("projection_x_coordinate", "", "x", None),
            ("", "1", "x", Some(Counts::Unknown)),
            ("", "yd", "x", Some(Counts::Length(0.9144))),
            ("", "mm", "x", Some(Counts::Length(0.001))),
            ("", "Mm", "x", Some(Counts::Unknown)),
            ("", "degN", "x", Some(Counts::Unknown)),
            ("", "degree_Celsius", "x", Some(Counts::Unknown)),
            ("", "1000 m", "x", Some(Counts::Unknown)),
            ("", "m2", "x", Some(Counts::Unknown)),
        ] {
            assert_eq!(counts_of(standard_name, units, name), counts, "{standard_name}, {units}, {name}");
        }
    }

    #[test]
    fn an_axis_is_known_by_its_attributes_before_its_name() {
        assert_eq!(axis_of("Y", "", "m", "x"), Some(Axis::Y));
        assert_eq!(axis_of("", "projection_x_coordinate", "m", "columns"), Some(Axis::X));
        assert_eq!(axis_of("", "", "degrees_north", "n"), Some(Axis::Y));
        for (name, axis) in [("Lon", Some(Axis::X)), ("northing", Some(Axis::Y)), ("time", None), ("cell", None)] {
            assert_eq!(axis_of("", "", "", name), axis, "{name}");
        }
    }
}
