//! Axes of NetCDF variables after the CF conventions: which dimension runs to the north and which to the east, and in what they count.
//!
//! Not here: the values of the axes, from which the reader of rasters takes the place on the map.

use std::path::Path;

use crate::error::{Problem, ProblemKind, input_error};

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
    let read = std::fs::File::open(path).and_then(|mut file| std::io::Read::read_exact(&mut file, &mut start));
    read.is_ok() && (start.starts_with(b"CDF") || start == *b"\x89HDF")
}

/// Refuses a variable of three dimensions whose last two are not y and x: a raster would be read transposed.
///
/// # Errors
/// The problem, without key and place.
pub fn check_order(file: &netcdf::File, variable: &netcdf::Variable, name: &str) -> Result<(), Problem> {
    let dimensions: Vec<String> = variable.dimensions().iter().map(netcdf::Dimension::name).collect();
    let axes: Vec<Option<Axis>> = dimensions.iter().map(|dimension| axis_of_dimension(file, dimension)).collect();
    if axes[1..] == [Some(Axis::Y), Some(Axis::X)] {
        return Ok(());
    }
    let found = dimensions.join(", ");
    let problem = |code, message| Problem::error(ProblemKind::Input, code, "", message);
    let named = |axis| axes.iter().position(|found| *found == Some(axis)).map(|place| dimensions[place].as_str());
    Err(match (named(Axis::Y), named(Axis::X)) {
        (Some(y), Some(x)) => {
            let time = dimensions.iter().find(|dimension| ![y, x].contains(&dimension.as_str()));
            let time = time.map_or("time", String::as_str);
            let message =
                format!("the dimensions of `{}` in {name} are {found} and not {time}, {y}, {x}", variable.name());
            problem("axes-swapped", message)
                .with_cause("its rasters would be read transposed")
                .with_remedy(format!("bring them into order: `ncpdq -a {time},{y},{x} IN OUT`"))
        }
        (y, _) => {
            let missing = if y.is_none() { "y" } else { "x" };
            let message =
                format!("which of the dimensions of `{}` in {name} is {missing} is not known", variable.name());
            problem("axes-unknown", message)
                .with_cause(format!("they are {found}, and no name or attribute of them says `{missing}`"))
                .with_remedy("give the variables of the last two dimensions the attributes `axis = \"Y\"` and `axis = \"X\"`: `ncatted -a axis,NAME,c,c,Y FILE`")
        }
    })
}

/// What an axis counts in.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Counts {
    Degrees,
    /// A length of so many metres.
    Length(f64),
}

/// What an axis counts in by its attributes and its name; none where nothing says so.
fn counts_of(standard_name: &str, units: &str, name: &str) -> Option<Counts> {
    let units = units.trim().to_lowercase();
    let is_angle = ["longitude", "latitude"].contains(&standard_name)
        || ["lon", "long", "longitude", "lat", "latitude"].contains(&name.to_lowercase().as_str());
    match units.as_str() {
        "" => is_angle.then_some(Counts::Degrees),
        "m" | "metre" | "metres" | "meter" | "meters" => Some(Counts::Length(1.0)),
        "km" | "kilometre" | "kilometres" | "kilometer" | "kilometers" => Some(Counts::Length(1000.0)),
        "cm" | "centimetre" | "centimetres" | "centimeter" | "centimeters" => Some(Counts::Length(0.01)),
        "ft" | "foot" | "feet" => Some(Counts::Length(0.3048)),
        _ => units.starts_with("degree").then_some(Counts::Degrees),
    }
}

/// Refuses a file without a reference system whose axes do not count in metres: its coordinates would be taken for metres.
///
/// # Errors
/// The problem, without key and place.
pub fn check_axes_are_metric(path: &Path) -> Result<(), Problem> {
    let Ok(file) = netcdf::open(path) else { return Ok(()) };
    let foreign = |variable: netcdf::Variable| {
        let name = variable.name();
        let is_axis = variable.dimensions().len() == 1 && variable.dimensions()[0].name() == name;
        if !is_axis || axis_of_dimension(&file, &name).is_none() {
            return None;
        }
        let text = |attribute| text_of(&variable, attribute).unwrap_or_default();
        let counts = counts_of(&text("standard_name"), &text("units"), &name)?;
        (counts != Counts::Length(1.0)).then(|| (name, counts, text("units")))
    };
    let axes: Vec<(String, Counts, String)> = file.variables().filter_map(foreign).collect();
    let Some((first, counts, units)) = axes.first() else { return Ok(()) };
    let file = path.display();
    let said = if units.is_empty() { "by its name".to_owned() } else { format!("`{units}`") };
    let no_system = "the file states no reference system: its variable has no `grid_mapping`";
    Err(match counts {
        Counts::Degrees => {
            input_error("geographic-crs", format!("the axis `{first}` of {file} counts in degrees ({said}), and a run needs metres"))
                .with_cause(format!("{no_system}, so that it cannot be warped either"))
                .with_remedy(
                    "state the system, for WGS 84 by `ncap2 -s 'crs=0;crs@grid_mapping_name=\"latitude_longitude\";NAME@grid_mapping=\"crs\"' IN OUT` \
                     with the name of the variable; then set `terrain.reproject: true` and `crs:` to a metric system",
                )
        }
        Counts::Length(metres) => {
            let each = |(name, ..): &(String, Counts, String)| format!("{name}={name}*{metres};{name}@units=\"m\"");
            let steps: Vec<String> = axes.iter().map(each).collect();
            input_error("not-metric-crs", format!("the axis `{first}` of {file} counts in {said}, and a run needs metres"))
                .with_cause(format!("{no_system}, so that its coordinates would be taken for metres"))
                .with_remedy(format!("bring it to metres: `ncap2 -s '{}' IN OUT`", steps.join(";")))
        }
    })
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
            ("", "1", "x", None),
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
