//! Bounds of the valid values of a NetCDF variable: `valid_range`, or `valid_min` and `valid_max`.
//!
//! After the NetCDF User's Guide a bound of a packed variable (with `scale_factor` or `add_offset`) is one of the packed numbers, but
//! one of the unpacked values where its type is wider than that of the packed numbers. Marks of no data: [`cf_heights`](super::cf_heights).

use netcdf::AttributeValue;
use netcdf::types::{FloatType, NcVariableType};

/// Bounds, in the numbers that the file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// The least number that is data.
    pub least: f64,
    /// The greatest one.
    pub most: f64,
    /// The attributes, as the user finds them in the file, such as `valid_max = 9000`.
    pub said: String,
}

/// How wide a type is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Width {
    Whole,
    Single,
    Double,
}

/// The numbers of an attribute and their type; none where it is missing or no number.
fn numbers(variable: &netcdf::Variable, name: &str) -> Option<(Vec<f64>, Width)> {
    fn all<T: Copy + Into<f64>>(values: &[T], width: Width) -> Option<(Vec<f64>, Width)> {
        Some((values.iter().map(|value| (*value).into()).collect(), width))
    }
    let attribute = variable.attributes().find(|attribute| attribute.name() == name)?;
    match attribute.value().ok()? {
        AttributeValue::Uchar(value) => all(&[value], Width::Whole),
        AttributeValue::Uchars(values) => all(&values, Width::Whole),
        AttributeValue::Schar(value) => all(&[value], Width::Whole),
        AttributeValue::Schars(values) => all(&values, Width::Whole),
        AttributeValue::Ushort(value) => all(&[value], Width::Whole),
        AttributeValue::Ushorts(values) => all(&values, Width::Whole),
        AttributeValue::Short(value) => all(&[value], Width::Whole),
        AttributeValue::Shorts(values) => all(&values, Width::Whole),
        AttributeValue::Uint(value) => all(&[value], Width::Whole),
        AttributeValue::Uints(values) => all(&values, Width::Whole),
        AttributeValue::Int(value) => all(&[value], Width::Whole),
        AttributeValue::Ints(values) => all(&values, Width::Whole),
        AttributeValue::Ulonglong(value) => all(&[value as f64], Width::Whole),
        AttributeValue::Ulonglongs(values) => Some((values.iter().map(|v| *v as f64).collect(), Width::Whole)),
        AttributeValue::Longlong(value) => all(&[value as f64], Width::Whole),
        AttributeValue::Longlongs(values) => Some((values.iter().map(|v| *v as f64).collect(), Width::Whole)),
        AttributeValue::Float(value) => all(&[value], Width::Single),
        AttributeValue::Floats(values) => all(&values, Width::Single),
        AttributeValue::Double(value) => all(&[value], Width::Double),
        AttributeValue::Doubles(values) => all(&values, Width::Double),
        AttributeValue::Str(_) | AttributeValue::Strs(_) => None,
    }
}

/// How the numbers of a variable become values.
struct Packing {
    scale: f64,
    offset: f64,
    /// Of the values.
    width: Width,
}

fn packing_of(variable: &netcdf::Variable) -> Option<Packing> {
    let number = |name| numbers(variable, name).and_then(|(values, width)| Some((*values.first()?, width)));
    let (scale, offset) = (number("scale_factor"), number("add_offset"));
    let width = scale.iter().chain(&offset).map(|(_, width)| *width).max()?;
    let (scale, offset) = (scale.map_or(1.0, |(scale, _)| scale), offset.map_or(0.0, |(offset, _)| offset));
    (scale != 0.0).then_some(Packing { scale, offset, width })
}

/// The numbers of an attribute that marks cells, in the numbers that the file holds.
pub(super) fn marks_in(variable: &netcdf::Variable, name: &str) -> Vec<f64> {
    let (external, packing) = (external_of(variable), packing_of(variable));
    numbers(variable, name).map_or_else(Vec::new, |(values, width)| {
        let packing = packing.as_ref().filter(|packing| width > external && packing.width == width);
        values.into_iter().map(|value| as_stored(value, packing, external)).collect()
    })
}

/// All values of a variable, unpacked; none where they are no numbers.
pub(super) fn numbers_of(variable: &netcdf::Variable) -> Option<Vec<f64>> {
    let values = variable.get_values::<f64, _>(..).ok()?;
    let Packing { scale, offset, .. } =
        packing_of(variable).unwrap_or(Packing { scale: 1.0, offset: 0.0, width: Width::Whole });
    Some(values.into_iter().map(|value| value * scale + offset).collect())
}

/// How wide the numbers of a variable are.
fn external_of(variable: &netcdf::Variable) -> Width {
    match variable.vartype() {
        NcVariableType::Float(FloatType::F32) => Width::Single,
        NcVariableType::Float(FloatType::F64) => Width::Double,
        _ => Width::Whole,
    }
}

/// The bounds of a variable; none where it has none. `is_unsigned`: its numbers are read as whole ones from 0.
pub fn bounds_of(variable: &netcdf::Variable, is_unsigned: bool) -> Option<Bounds> {
    let external = external_of(variable);
    let packing = packing_of(variable);
    let unpacked = |width: Width| {
        packing.as_ref().filter(|packing| width > external && (external == Width::Whole || packing.width == width))
    };
    let mut bounds = Bounds { least: f64::NEG_INFINITY, most: f64::INFINITY, said: String::new() };
    let mut said = Vec::new();
    // Some programs write a bound of unpacked values as a packed number.
    let is_packed = |width: Width| packing.is_some() && unpacked(width).is_none();
    let kind = |width: Width| if is_packed(width) { " as a packed number" } else { "" };
    let mut take = |values: &[f64], width: Width, least: Option<usize>, most: Option<usize>| {
        let packing = unpacked(width);
        // A bound of bytes that count from 0 may be written as a signed number, which bounds nothing then.
        let is_bound = |value: &f64| !value.is_nan() && (packing.is_some() || !(is_unsigned && *value < 0.0));
        let number = |value: f64| as_stored(value, packing, external);
        let [low, high] = [least, most].map(|index| index.map(|index| values[index]).filter(is_bound).map(number));
        let (low, high) = if packing.is_some_and(|packing| packing.scale < 0.0) { (high, low) } else { (low, high) };
        bounds.least = low.unwrap_or(bounds.least);
        bounds.most = high.unwrap_or(bounds.most);
    };
    match numbers(variable, "valid_range") {
        Some((values, width)) if values.len() == 2 => {
            take(&values, width, Some(0), Some(1));
            said.push(format!("valid_range = {}, {}{}", values[0], values[1], kind(width)));
        }
        _ => {
            for (name, is_least) in [("valid_min", true), ("valid_max", false)] {
                if let Some((values, width)) = numbers(variable, name).filter(|(values, _)| !values.is_empty()) {
                    take(&values, width, is_least.then_some(0), (!is_least).then_some(0));
                    said.push(format!("{name} = {}{}", values[0], kind(width)));
                }
            }
        }
    }
    bounds.said = said.join(", ");
    (!said.is_empty()).then_some(bounds)
}

/// A bound in the numbers of the file.
fn as_stored(bound: f64, packing: Option<&Packing>, external: Width) -> f64 {
    // What the rounding of a scale of single precision may shift a bound by, in whole numbers.
    let rounding = |stored: f64| 1e-3 + f64::from(f32::EPSILON) * stored.abs();
    let stored = packing.map_or(bound, |packing| (bound - packing.offset) / packing.scale);
    match external {
        Width::Whole if (stored - stored.round()).abs() < rounding(stored) => stored.round(),
        Width::Single => f64::from(stored as f32),
        Width::Whole | Width::Double => stored,
    }
}
