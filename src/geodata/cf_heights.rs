//! What the attributes of a NetCDF variable say of its heights besides their unit: whether they count downwards, and which numbers stand for no
//! data; and whether the places of its axes are evenly spaced.

use netcdf::types::{FloatType, NcVariableType};

use super::cf_axes::text_of;
use super::cf_valid::{Bounds, bounds_of, marks_in, numbers_of};
use crate::error::{Problem, input_error};

/// What a file says of the values of a variable.
#[derive(Debug, Default)]
pub struct Said {
    /// The bounds of valid ones.
    pub bounds: Option<Bounds>,
    /// The numbers that stand for no data.
    pub marks: Vec<f64>,
    /// What says that they count downwards.
    pub downward: Option<String>,
}

/// All of that; `is_unsigned`: its numbers are read as whole ones from 0.
pub fn said_of(variable: &netcdf::Variable, is_unsigned: bool) -> Said {
    Said { bounds: bounds_of(variable, is_unsigned), marks: marks_of(variable), downward: downward(variable) }
}

/// The attribute that says that a variable counts downwards, as the user finds it in the file; none where it does not.
fn downward(variable: &netcdf::Variable) -> Option<String> {
    let text = |name| text_of(variable, name).unwrap_or_default().trim().to_lowercase();
    match (text("positive").as_str(), text("standard_name")) {
        ("down", _) => Some("positive = down".to_owned()),
        // `sea_floor_depth_below_geoid` and its like.
        ("", name) if name == "depth" || name.contains("depth_below") => Some(format!("standard_name = {name}")),
        _ => None,
    }
}

/// The numbers, as the file stores them, that stand for no data: all of `_FillValue` and `missing_value`, written as numbers or as text.
fn marks_of(variable: &netcdf::Variable) -> Vec<f64> {
    let of_text = |name| text_of(variable, name).and_then(|text| text.trim().parse().ok());
    let of = |name| marks_in(variable, name).into_iter().chain(of_text(name));
    let is_single = matches!(variable.vartype(), NcVariableType::Float(FloatType::F32));
    let as_stored = |mark: f64| if is_single { f64::from(mark as f32) } else { mark };
    ["_FillValue", "missing_value"].into_iter().flat_map(of).map(as_stored).collect()
}

/// Share of the spacing by which places may be off: rounding of single precision and of degrees in text.
const EVEN: f64 = 0.05;

/// Refuses a variable of which the places along one of its last two dimensions are not evenly spaced: a raster has even ones, and its cells would
/// come to lie elsewhere.
///
/// # Errors
/// The problem, without key and place.
pub fn check_spacing(file: &netcdf::File, variable: &netcdf::Variable, name: &str) -> Result<(), Problem> {
    let dimensions = variable.dimensions();
    for dimension in &dimensions[dimensions.len().saturating_sub(2)..] {
        let axis = dimension.name();
        let Some(places) =
            file.variable(&axis).filter(|axis| axis.dimensions().len() == 1).and_then(|axis| numbers_of(&axis))
        else {
            continue;
        };
        let last = places.len().saturating_sub(1);
        if last < 2 {
            continue;
        }
        let spacing = (places[last] - places[0]) / last as f64;
        let even = |k: usize| places[0] + spacing * k as f64;
        let off = |k: usize| (places[k] - even(k)).abs();
        let is_off = |&k: &usize| off(k).is_nan() || off(k) > EVEN * spacing.abs();
        let Some(first) = (0..=last).find(is_off) else { continue };
        // Where the step changes is what the user looks for.
        let usual = places[1] - places[0];
        let at = (1..=last).find(|&k| ((places[k] - places[k - 1]) / usual - 1.0).abs() > EVEN).unwrap_or(first.max(1));
        let message = format!(
            "the axis `{axis}` of {name} is not evenly spaced: its places {at} and {} are {} and {}, the first two {} apart",
            at + 1,
            places[at - 1],
            places[at],
            usual.abs()
        );
        return Err(input_error("axis-uneven", message)
            .with_cause("a raster has cells of one size: the terrain beyond that place would come to lie elsewhere")
            .with_remedy("fill the missing rows or columns with no data, or resample it to even places, for example with `cdo remapbil`"));
    }
    Ok(())
}
