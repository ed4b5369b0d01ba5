//! The values of a scenario: quantities with their range, names of files, dates. Each knows its unit, its
//! range, an example, and its JSON Schema.

mod files;

use std::borrow::Cow;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::model::Sourced;
use super::read::{FromNode, Reader};
use super::tree::Node;
use super::units::{self, Dimension};
use crate::calendar::{DateFault, UtcTime};
use crate::error::{Problem, ProblemKind, plain_name};

pub(super) use files::split_layer;
pub use files::{CsvFile, InputFile, RasterSeriesFile, VectorFile};

/// What a quantity is for: its dimension and the range of its values.
pub trait Kind {
    /// Name in the schema.
    const NAME: &'static str;
    /// The dimension.
    const DIMENSION: &'static Dimension;
    /// An example.
    const EXAMPLE: &'static str;
    /// The range in words.
    const RANGE: &'static str;
    /// Whether a value in SI units lies within the range.
    fn is_allowed(value: f64) -> bool;
}

/// A quantity in SI units with its place.
#[derive(Clone, Debug)]
pub struct Quantity<K> {
    /// Value in SI units, key path and place.
    pub sourced: Sourced<f64>,
    kind: PhantomData<K>,
}

impl<K> Quantity<K> {
    /// The value in SI units.
    pub fn value(&self) -> f64 {
        self.sourced.value
    }
}

impl<K: Kind> FromNode for Quantity<K> {
    fn example() -> String {
        K::EXAMPLE.to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let text = reader.text(node, K::DIMENSION.name, K::EXAMPLE)?;
        match K::DIMENSION.parse(text) {
            Ok(value) if K::is_allowed(value) => {
                Some(Quantity { sourced: reader.sourced(node, value), kind: PhantomData })
            }
            Ok(_) => {
                reader.error(node, "range", format!("`{text}` is out of range"), format!("it must be {}", K::RANGE));
                None
            }
            Err(error) => {
                reader.error(node, error.code, error.message, error.remedy);
                None
            }
        }
    }
}

impl<K: Kind> JsonSchema for Quantity<K> {
    fn schema_name() -> Cow<'static, str> {
        K::NAME.into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let units = K::DIMENSION.unit_list();
        let name = K::DIMENSION.name;
        let unit_text = if units.is_empty() { String::new() } else { format!(" with one of the units {units}") };
        json_schema!({
            "type": ["string", "number"],
            "description": format!("{name}{unit_text}; {}", K::RANGE),
            "x-kind": format!("{}, {}", name.split_once(' ').map_or(name, |(_, name)| name), K::RANGE).replace(", any finite value", ""),
            "examples": [K::EXAMPLE],
        })
    }
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident: $dimension:ident, $example:literal, $range:literal, $allowed:expr;)+) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Debug)]
            pub struct $kind;

            impl Kind for $kind {
                const NAME: &'static str = stringify!($kind);
                const DIMENSION: &'static Dimension = &units::$dimension;
                const EXAMPLE: &'static str = $example;
                const RANGE: &'static str = $range;

                fn is_allowed(value: f64) -> bool {
                    let allowed: fn(f64) -> bool = $allowed;
                    allowed(value)
                }
            }
        )+
    };
}

kinds! {
    /// A level above the vertical datum (m).
    Level: LENGTH, "100 m", "between -20 km and 20 km", |value| value.abs() <= 20e3;
    /// A correction of elevations (m).
    Offset: LENGTH, "0.12 m", "between -20 km and 20 km", |value| value.abs() <= 20e3;
    /// A length or depth (m).
    Length: LENGTH, "20 m", "greater than 0 and at most 10,000 km", |value| value > 0.0 && value <= units::LENGTH.most;
    /// A distance that may be 0 (m).
    Distance: LENGTH, "50 m", "0 or more and at most 10,000 km", |value| (0.0..=units::LENGTH.most).contains(&value);
    /// A span of time (s).
    Duration: TIME, "100 s", "greater than 0 and at most 10,000 d", |value| value > 0.0 && value <= 1e4 * 86_400.0;
    /// A time of the run (s).
    Moment: TIME, "0 s", "0 or more and at most 10,000 d", |value| (0.0..=1e4 * 86_400.0).contains(&value);
    /// A slope of the sides of a breach (dimensionless, horizontal to vertical).
    SideSlope: NUMBER, "1.0", "between 0 (vertical) and 10, horizontal to vertical", |value| (0.0..=10.0).contains(&value);
    /// The end of a run (s).
    EndTime: TIME, "1 h 30 min", "from 0.001 s to 366 d", |value| (1e-3..=366.0 * 86_400.0).contains(&value);
    /// A volume of water (m³).
    Volume: VOLUME, "9.8 Mm3", "greater than 0 and at most 1e15 m3", |value| value > 0.0 && value <= units::VOLUME.most;
    /// A discharge (m³/s).
    Discharge: DISCHARGE, "30 m3/s", "0 or more and at most 1e9 m3/s", |value| (0.0..=units::DISCHARGE.most).contains(&value);
    /// The velocity of a slide (m/s).
    Velocity: VELOCITY, "20 m/s", "0 or more and at most 1000 m/s", |value| (0.0..=units::VELOCITY.most).contains(&value);
    /// An intensity of rain or of its loss (m/s).
    Intensity: INTENSITY, "20 mm/h", "0 or more and at most 1 m/s", |value| (0.0..=units::INTENSITY.most).contains(&value);
    /// A depth of water that may be 0 (m).
    Height: LENGTH, "5 mm", "0 or more and at most 20 km", |value| (0.0..=20e3).contains(&value);
    /// A slope (dimensionless).
    Slope: SLOPE, "0.002", "greater than 0 and at most 1", |value| value > 0.0 && value <= 1.0;
    /// A slope that may be 0, or rise (dimensionless).
    Fall: SLOPE, "0.002", "between -1 and 1", |value| (-1.0..=1.0).contains(&value);
    /// A coordinate of the reference system of the run (m).
    Coordinate: NUMBER, "712345.0", "between -1e8 and 1e8", |value| value.abs() <= 1e8;
    /// Manning roughness (s·m^(−1/3)).
    Manning: NUMBER, "0.033", "between 0 and 0.5, in s/m^(1/3)", |value| (0.0..=0.5).contains(&value);
    /// A factor of Manning roughnesses.
    RoughnessFactor: NUMBER, "1.2", "between 0.1 and 10", |value| (0.1..=10.0).contains(&value);
    /// A factor of what a formula gives.
    SpreadFactor: NUMBER, "1.2", "between 0.01 and 100", |value| (0.01..=100.0).contains(&value);
    /// Courant number.
    Courant: NUMBER, "0.5", "between 0.01 and 1", |value| (0.01..=1.0).contains(&value);
    /// Gravity (m/s²).
    Gravity: ACCELERATION, "9.81", "greater than 0", |value| value > 0.0;
    /// Memory (bytes).
    Memory: MEMORY, "8 GB", "greater than 0", |value| value > 0.0;
    /// A share of the concentration of a source (dimensionless).
    ShareOfSource: SHARE, "0.01", "greater than 0 and at most 1", |value| value > 0.0 && value <= 1.0;
    /// The number of an entry of a list.
    EntryNumber: NUMBER, "1", "a whole number of 1 or more", |value| value >= 1.0 && value.fract() <= 0.0;
    /// A number of cells.
    CellCount: NUMBER, "50", "1 or more", |value| value >= 1.0;
    /// How many samples are drawn.
    SampleCount: NUMBER, "100", "a whole number from 1 to 10000", |value| (1.0..=1e4).contains(&value) && value.fract() <= 0.0;
    /// From which number samples are drawn.
    Seed: NUMBER, "1", "a whole number from 0 to 4294967295", |value| (0.0..=4_294_967_295.0).contains(&value) && value.fract() <= 0.0;
    /// A number of particles.
    Count: NUMBER, "50000000", "1 or more", |value| value >= 1.0;
}

/// A text.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(transparent)]
pub struct Text(pub Sourced<String>);

impl FromNode for Text {
    fn example() -> String {
        "a text".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let text = plain_name(reader.text(node, "a text", &Self::example())?);
        Some(Text(reader.sourced(node, text)))
    }
}

impl JsonSchema for Sourced<String> {
    fn schema_name() -> Cow<'static, str> {
        "Text".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        String::json_schema(generator)
    }
}

impl FromNode for bool {
    fn example() -> String {
        "true".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        match reader.text(node, "true or false", &Self::example())? {
            "true" => Some(true),
            "false" => Some(false),
            _ => {
                reader.wrong_type(node, "true or false", "write `true` or `false`");
                None
            }
        }
    }
}

/// The version of the scenario format; this program reads version 1.
#[derive(Clone, Debug)]
pub struct FormatVersion;

impl FromNode for FormatVersion {
    fn example() -> String {
        "1".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let text = reader.text(node, "the version of the scenario format", &Self::example())?;
        if text == "1" {
            return Some(FormatVersion);
        }
        let message = format!("version `{text}` of the scenario format is not known to this program");
        reader.error(node, "version", message, "write `floodsim: 1`, or use a newer program");
        None
    }
}

impl JsonSchema for FormatVersion {
    fn schema_name() -> Cow<'static, str> {
        "FormatVersion".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"const": 1, "description": "Version of the scenario format."})
    }
}

/// A date and time, in UTC or with an offset from it.
#[derive(Clone, Copy, Debug)]
pub struct DateTime(pub UtcTime);

impl FromNode for DateTime {
    fn example() -> String {
        format!("\"{}\"", UtcTime::EXAMPLE)
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let text = reader.text(node, "a date and time", &Self::example())?;
        match UtcTime::read(text) {
            Ok(moment) => Some(DateTime(moment)),
            Err(fault) => {
                let remedy = match fault {
                    DateFault::TooEarly | DateFault::YearZero => {
                        "write all dates of the run 400 years later: its days, and its leap years, are the same"
                            .to_owned()
                    }
                    _ => {
                        format!("write it as {}, in UTC or with an offset such as `+02:00` behind it", Self::example())
                    }
                };
                let message = format!("`{text}` is not a date and time");
                let problem = Problem::error(ProblemKind::Scenario, "date", node.key.clone(), message);
                reader.report(node, problem.with_cause(fault.to_string()).with_remedy(remedy));
                None
            }
        }
    }
}

impl JsonSchema for DateTime {
    fn schema_name() -> Cow<'static, str> {
        "DateTime".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "x-kind": "date and time",
            "description": "A date and time as YYYY-MM-DD HH:MM:SS or in another form of ISO 8601: UTC, or with an offset such as +02:00.",
            "examples": [UtcTime::EXAMPLE, "2026-06-01T08:00+02:00"],
        })
    }
}

#[cfg(test)]
mod tests;
