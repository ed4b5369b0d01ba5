//! The unit of a raster of rain: an intensity or a depth.

use crate::error::{Problem, input_error};
use crate::scenario::RainUnit;
use crate::scenario::units::{INTENSITY, LENGTH, TIME};

/// Refuses a file whose own unit, where it is one of rain, is another than that of the scenario.
pub fn check_unit(asked: RainUnit, written: &str, name: &str) -> Result<(), Problem> {
    match unit_of_file(written) {
        Some(own) if !is_same(asked, own) => {
            let message = format!("{name} says `{written}`, and the scenario another unit");
            let remedy =
                "let the scenario say the `unit` of the file, or correct that of the file (`ncatted` for NetCDF)";
            Err(input_error("other-unit", message).with_remedy(remedy))
        }
        _ => Ok(()),
    }
}

pub fn unit_remedy() -> String {
    format!(
        "add `unit: mm/h` or another one of {}; or `unit: mm` or another one of {} for what falls within each interval",
        INTENSITY.unit_list(),
        LENGTH.unit_list()
    )
}

pub fn is_same(a: RainUnit, b: RainUnit) -> bool {
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
    match (a, b) {
        (RainUnit::Intensity(a), RainUnit::Intensity(b)) | (RainUnit::Depth(a), RainUnit::Depth(b)) => near(a, b),
        _ => false,
    }
}

/// The unit of rain in the spellings of UDUNITS; a kilogram of water on a square metre is a millimetre.
pub fn unit_of_file(text: &str) -> Option<RainUnit> {
    if let Some(unit) = RainUnit::named(text.trim()) {
        return Some(unit);
    }
    let factors = factors_of(text)?;
    let (amount, rest) = match &factors[..] {
        [("kg", 1), ("m", -2), rest @ ..] => (1e-3, rest),
        [(length, 1), rest @ ..] => (LENGTH.factor_of(length)?, rest),
        _ => return None,
    };
    match rest {
        [] => Some(RainUnit::Depth(amount)),
        [(time, -1)] => seconds_of_unit(time).map(|seconds| RainUnit::Intensity(amount / seconds)),
        _ => None,
    }
}

/// The factors of a unit with their powers: `mm h-1`, `mm.h^-1`, `mm h**-1`, `mm / h`, `mm*h-1`.
fn factors_of(text: &str) -> Option<Vec<(&str, i32)>> {
    let mut factors = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let (is_divided, begin) = match rest.find(|c: char| c.is_alphanumeric()) {
            Some(begin) if rest[..begin].chars().all(|c| " ./*".contains(c)) => (rest[..begin].contains('/'), begin),
            _ => return None,
        };
        rest = &rest[begin..];
        let (name, after) = rest.split_at(rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len()));
        let power = after.strip_prefix("**").or(after.strip_prefix('^')).unwrap_or(after);
        let sign = power.len() - power.trim_start_matches(['-', '+']).len();
        let end = power[sign..].find(|c: char| !c.is_ascii_digit()).map_or(power.len(), |digits| sign + digits);
        let written = &power[..end];
        let power_of_name = if end > 0 { written.parse::<i32>().ok()? } else { 1 };
        // What stands behind the name without a power is the next factor's.
        rest = if end > 0 { &power[end..] } else { after };
        factors.push((name, if is_divided { -power_of_name } else { power_of_name }));
    }
    Some(factors).filter(|factors| factors.iter().all(|(name, _)| !name.is_empty()))
}

/// Seconds of a unit of time in the spellings of UDUNITS.
fn seconds_of_unit(name: &str) -> Option<f64> {
    match name {
        "hr" | "hour" => Some(3600.0),
        "sec" | "second" => Some(1.0),
        "minute" => Some(60.0),
        "day" => Some(86_400.0),
        "ms" => None,
        _ => TIME.factor_of(name),
    }
}

/// What is wrong with a unit that is an amount of rain times a time, where one per time is meant.
pub fn times_time(text: &str) -> Option<String> {
    let factors = factors_of(text)?;
    let (time, _) = factors.last().filter(|(name, power)| *power == 1 && seconds_of_unit(name).is_some())?;
    let amount = text.trim().strip_suffix(time)?.trim_end_matches([' ', '.', '*']);
    unit_of_file(amount).filter(|unit| matches!(unit, RainUnit::Depth(_)))?;
    Some(format!(
        "it is `{amount}` times `{time}`, a depth times a time; an intensity is written `{amount} {time}-1` or `{amount}/{time}`"
    ))
}
