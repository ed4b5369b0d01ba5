//! Axes of NetCDF variables after the CF conventions: which dimension runs to the north and which to the east.
//!
//! Not here: the values of the axes, from which the reader of rasters takes the place on the map.

use crate::error::{Problem, ProblemKind};

/// The direction of an axis on the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    X,
    Y,
}

/// The text of an attribute.
pub(super) fn text_of(variable: &netcdf::Variable, name: &str) -> Option<String> {
    // By way of all attributes: HDF5 tells the user of every one that is asked for and missing.
    let attribute = variable.attributes().find(|attribute| attribute.name() == name)?;
    match attribute.value() {
        Ok(netcdf::AttributeValue::Str(text)) => Some(text),
        _ => None,
    }
}

/// Refuses a variable of three dimensions whose last two are not y and x: a raster would be read transposed.
pub(super) fn check_order(file: &netcdf::File, variable: &netcdf::Variable, name: &str) -> Result<(), Problem> {
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
    fn an_axis_is_known_by_its_attributes_before_its_name() {
        assert_eq!(axis_of("Y", "", "m", "x"), Some(Axis::Y));
        assert_eq!(axis_of("", "projection_x_coordinate", "m", "columns"), Some(Axis::X));
        assert_eq!(axis_of("", "", "degrees_north", "n"), Some(Axis::Y));
        for (name, axis) in [("Lon", Some(Axis::X)), ("northing", Some(Axis::Y)), ("time", None), ("cell", None)] {
            assert_eq!(axis_of("", "", "", name), axis, "{name}");
        }
    }
}
