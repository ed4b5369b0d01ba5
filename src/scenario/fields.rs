//! The values of a scenario: quantities with their range, names of files and methods, dates. Each knows its unit, its
//! range, an example, and its JSON Schema.

use std::borrow::Cow;
use std::marker::PhantomData;
use std::path::PathBuf;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::methods::{BedMethod, Formulation, Integrator, Kernel, Motion, Stabilisation};
use super::model::{Side, Sourced, VectorSource};
use super::read::{FromNode, Reader, nearest};
use super::tree::Node;
use super::units::{self, Dimension};

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
    const EXAMPLE: &'static str = K::EXAMPLE;

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
    Level: LENGTH, "100 m", "any finite value", f64::is_finite;
    /// A correction of elevations (m).
    Offset: LENGTH, "0.12 m", "any finite value", f64::is_finite;
    /// A length or depth (m).
    Length: LENGTH, "20 m", "greater than 0", |value| value > 0.0;
    /// A span of time (s).
    Duration: TIME, "100 s", "greater than 0", |value| value > 0.0;
    /// The end of a run (s).
    EndTime: TIME, "1 h 30 min", "greater than 0 and at most 366 d", |value| value > 0.0 && value <= 366.0 * 86_400.0;
    /// Manning roughness (s·m^(−1/3)).
    Manning: NUMBER, "0.033", "between 0 and 0.5, in s/m^(1/3)", |value| (0.0..=0.5).contains(&value);
    /// Courant number.
    Courant: NUMBER, "0.5", "greater than 0 and at most 1", |value| value > 0.0 && value <= 1.0;
    /// Gravity (m/s²).
    Gravity: ACCELERATION, "9.81", "greater than 0", |value| value > 0.0;
    /// Memory (bytes).
    Memory: MEMORY, "8 GB", "greater than 0", |value| value > 0.0;
    /// A number of particles.
    Count: NUMBER, "50000000", "1 or more", |value| value >= 1.0;
}

/// A text.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(transparent)]
pub struct Text(pub Sourced<String>);

impl FromNode for Text {
    const EXAMPLE: &'static str = "a text";

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let text = reader.text(node, "a text", Self::EXAMPLE)?.to_owned();
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
    const EXAMPLE: &'static str = "true";

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        match reader.text(node, "true or false", Self::EXAMPLE)? {
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
    const EXAMPLE: &'static str = "1";

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let text = reader.text(node, "the version of the scenario format", Self::EXAMPLE)?;
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

/// A file with a path relative to the folder of the scenario.
#[derive(Clone, Debug)]
pub struct InputFile(pub Sourced<PathBuf>);

impl FromNode for InputFile {
    const EXAMPLE: &'static str = "dem.tif";

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let name = file_name(node, reader, Self::EXAMPLE)?;
        let path = reader.folder.join(name);
        let file = reader.sourced(node, path);
        reader.files.push(file.clone());
        Some(InputFile(file))
    }
}

impl JsonSchema for InputFile {
    fn schema_name() -> Cow<'static, str> {
        "InputFile".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string", "description": "A file; its path is relative to the folder of the scenario."})
    }
}

/// A vector file, or `file.gpkg:layer` for one of its layers.
#[derive(Clone, Debug)]
pub struct VectorFile(pub Sourced<VectorSource>);

impl FromNode for VectorFile {
    const EXAMPLE: &'static str = "reservoir.geojson";

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let (path, layer) = split_layer(file_name(node, reader, Self::EXAMPLE)?);
        let source = VectorSource { path: reader.folder.join(path), layer: layer.map(str::to_owned) };
        let file = reader.sourced(node, source.path.clone());
        reader.files.push(file);
        Some(VectorFile(reader.sourced(node, source)))
    }
}

impl JsonSchema for VectorFile {
    fn schema_name() -> Cow<'static, str> {
        "VectorFile".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "description": "A vector file, or `file.gpkg:layer` for one of its layers; \
                its path is relative to the folder of the scenario.",
        })
    }
}

fn file_name<'a>(node: &'a Node, reader: &mut Reader, example: &str) -> Option<&'a str> {
    let name = reader.text(node, "the name of a file", example)?;
    if name.trim().is_empty() || name.contains('\0') {
        reader.wrong_type(node, "the name of a file", &format!("write for example `{example}`"));
        return None;
    }
    Some(name)
}

/// Splits `file.gpkg:layer` at the last colon that follows a file extension.
fn split_layer(text: &str) -> (&str, Option<&str>) {
    match text.rsplit_once(':') {
        Some((path, layer)) if !layer.is_empty() && !layer.contains('/') && has_extension(path) => (path, Some(layer)),
        _ => (text, None),
    }
}

fn has_extension(path: &str) -> bool {
    std::path::Path::new(path).extension().is_some_and(|extension| !extension.is_empty())
}

/// One name of a fixed list.
pub trait Choice: Sized + Copy + 'static {
    /// What is chosen, for messages.
    const WHAT: &'static str;
    /// The names and what they stand for.
    fn choices() -> Vec<(&'static str, Self)>;
}

/// A chosen name with its place.
#[derive(Clone, Debug)]
pub struct Chosen<T>(pub Sourced<T>);

impl<T: Choice> FromNode for Chosen<T> {
    const EXAMPLE: &'static str = "a name";

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let choices = T::choices();
        let names = || choices.iter().map(|(name, _)| *name);
        let list = names().collect::<Vec<_>>().join(", ");
        let text = reader.text(node, T::WHAT, choices[0].0)?;
        if let Some((_, value)) = choices.iter().find(|(name, _)| *name == text) {
            return Some(Chosen(reader.sourced(node, *value)));
        }
        let remedy = match nearest(text, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("use one of {list}"),
        };
        reader.error(node, "unknown-name", format!("`{text}` is not {}", T::WHAT), remedy);
        None
    }
}

impl<T: Choice> JsonSchema for Chosen<T> {
    fn schema_name() -> Cow<'static, str> {
        T::WHAT.into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"enum": T::choices().iter().map(|(name, _)| *name).collect::<Vec<_>>()})
    }
}

macro_rules! method_choices {
    ($($family:ident: $what:literal,)+) => {
        $(impl Choice for $family {
            const WHAT: &'static str = $what;

            fn choices() -> Vec<(&'static str, Self)> {
                $family::ALL.iter().map(|member| (member.name(), *member)).collect()
            }
        })+
    };
}

method_choices! {
    Formulation: "a formulation",
    Motion: "a motion",
    Stabilisation: "a stabilisation",
    Kernel: "a kernel",
    Integrator: "an integrator",
    BedMethod: "a method for the bed",
}

impl Choice for Side {
    const WHAT: &'static str = "a side of the terrain";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![
            ("north", Side::North),
            ("east", Side::East),
            ("south", Side::South),
            ("west", Side::West),
            ("all", Side::All),
        ]
    }
}

/// What happens at a boundary.
#[derive(Clone, Copy, Debug)]
pub struct OpenType;

impl Choice for OpenType {
    const WHAT: &'static str = "a type of boundary";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("open", OpenType)]
    }
}

/// The unit of the elevations of a raster, as its factor to metres.
#[derive(Clone, Copy, Debug)]
pub struct ElevationUnit(pub f64);

impl Choice for ElevationUnit {
    const WHAT: &'static str = "a unit of elevation";

    fn choices() -> Vec<(&'static str, Self)> {
        [("m", 1.0), ("dm", 0.1), ("cm", 0.01), ("mm", 0.001), ("ft", 0.3048), ("us_ft", 1200.0 / 3937.0)]
            .map(|(name, factor)| (name, ElevationUnit(factor)))
            .to_vec()
    }
}

impl Choice for super::model::PointInterpolation {
    const WHAT: &'static str = "an interpolation between points";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("inverse_distance", Self::InverseDistance), ("natural_neighbour", Self::NaturalNeighbour)]
    }
}

/// A date and time as `YYYY-MM-DD HH:MM:SS` (UTC).
#[derive(Clone, Debug)]
pub struct DateTime(pub String);

impl FromNode for DateTime {
    const EXAMPLE: &'static str = "\"2026-06-01 06:00:00\"";

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let text = reader.text(node, "a date and time", Self::EXAMPLE)?;
        let date = normalised_date(text);
        if date.is_none() {
            let remedy = format!("write it as {} (UTC, in quotes)", Self::EXAMPLE);
            reader.error(node, "date", format!("`{text}` is not a date and time"), remedy);
        }
        date.map(DateTime)
    }
}

impl JsonSchema for DateTime {
    fn schema_name() -> Cow<'static, str> {
        "DateTime".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "description": "A date and time (UTC) as YYYY-MM-DD HH:MM:SS.",
            "examples": ["2026-06-01 06:00:00"],
        })
    }
}

/// Accepts `YYYY-MM-DD`, with `HH:MM` or `HH:MM:SS` after a blank or a T, and a closing Z.
fn normalised_date(text: &str) -> Option<String> {
    let text = text.trim().trim_end_matches('Z');
    let (date, time) = text.split_once([' ', 'T']).unwrap_or((text, "00:00:00"));
    let numbers = |text: &str, separator: char, lengths: &[usize]| -> Option<Vec<u32>> {
        let parts: Vec<&str> = text.split(separator).collect();
        let fits = |(part, length): (&&str, &usize)| part.len() == *length && part.bytes().all(|b| b.is_ascii_digit());
        if parts.len() > lengths.len() || !parts.iter().zip(lengths).all(fits) {
            return None;
        }
        parts.iter().map(|part| part.parse().ok()).collect()
    };
    let [year, month, day] = numbers(date, '-', &[4, 2, 2])?[..] else { return None };
    let (hour, minute, second) = match numbers(time, ':', &[2, 2, 2])?[..] {
        [hour, minute] => (hour, minute, 0),
        [hour, minute, second] => (hour, minute, second),
        _ => return None,
    };
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days = match month {
        2 => 28 + u32::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return None,
    };
    let is_valid = year > 0 && (1..=days).contains(&day) && hour < 24 && minute < 60 && second < 60;
    is_valid.then(|| format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_follows_the_extension() {
        for (text, expected) in [
            ("a.gpkg:lake", ("a.gpkg", Some("lake"))),
            ("gis/a b.gpkg:lake one", ("gis/a b.gpkg", Some("lake one"))),
            ("a.geojson", ("a.geojson", None)),
            ("a:b/c.shp", ("a:b/c.shp", None)),
            ("odd:name", ("odd:name", None)),
            ("a.gpkg:", ("a.gpkg:", None)),
        ] {
            assert_eq!(split_layer(text), expected, "{text}");
        }
    }

    #[test]
    fn dates_are_normalised_and_checked() {
        assert_eq!(normalised_date("1959-12-02 21:14").as_deref(), Some("1959-12-02 21:14:00"));
        assert_eq!(normalised_date("1959-12-02T21:14:05Z").as_deref(), Some("1959-12-02 21:14:05"));
        assert_eq!(normalised_date("2024-02-29").as_deref(), Some("2024-02-29 00:00:00"));
        for text in ["2023-02-29", "2024-13-01", "2024-1-1", "02.12.1959", "2024-01-01 24:00", "", "2024-01-01 1:00:00"]
        {
            assert_eq!(normalised_date(text), None, "{text}");
        }
    }
}
