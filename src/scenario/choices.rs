//! The values of a scenario that are one name out of a list: methods, sides, units of a raster.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::methods::{
    BedMethod, BedSlope, Formulation, Integrator, Kernel, Motion, Preset, Reconstruction, Seeding, Stabilisation,
    Turbulence, WallMethod,
};
use super::model::{
    AfterEnd, BreachFormula, BreachMode, GrowthLaw, OutputPart, PointInterpolation, Side, Sourced, Stamp,
};
use super::read::{FromNode, Reader, nearest};
use super::tree::Node;

/// One name of a fixed list.
pub trait Choice: Sized + Copy + 'static {
    /// What is chosen, for messages.
    const WHAT: &'static str;
    /// The names and what they stand for.
    fn choices() -> Vec<(&'static str, Self)>;
    /// What to write in place of a name of earlier versions.
    fn renamed(_earlier: &str) -> Option<&'static str> {
        None
    }
}

/// A chosen name with its place.
#[derive(Clone, Debug)]
pub struct Chosen<T>(pub Sourced<T>);

impl<T: Choice> FromNode for Chosen<T> {
    fn example() -> String {
        "a name".to_owned()
    }

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
        let remedy = T::renamed(text).map_or(remedy, str::to_owned);
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
    ($($family:ident: $what:literal $(, $earlier:literal => $now:literal)?;)+) => {
        $(impl Choice for $family {
            const WHAT: &'static str = $what;

            fn choices() -> Vec<(&'static str, Self)> {
                $family::ALL.iter().map(|member| (member.name(), *member)).collect()
            }

            $(fn renamed(earlier: &str) -> Option<&'static str> {
                (earlier == $earlier).then_some($now)
            })?
        })+
    };
}

method_choices! {
    Preset: "a preset";
    Formulation: "a formulation";
    Motion: "a motion";
    Stabilisation: "a stabilisation",
        "hllc" => "write `two_rarefactions`, or `two_waves` with `formulation: variational`: `hllc` was the name of both, and neither is that solver";
    Reconstruction: "a reconstruction";
    Seeding: "a way of seeding";
    Kernel: "a kernel";
    Integrator: "an integrator";
    BedMethod: "a method for the bed";
    BedSlope: "an effect of the bed's slope";
    Turbulence: "a model of turbulence";
    WallMethod: "a kind of wall";
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

impl Choice for Stamp {
    const WHAT: &'static str = "an end of an interval";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("begin", Stamp::Begin), ("end", Stamp::End)]
    }
}

impl Choice for AfterEnd {
    const WHAT: &'static str = "a way on after the end of a series";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("hold", AfterEnd::Hold)]
    }
}

impl Choice for GrowthLaw {
    const WHAT: &'static str = "a law of growth";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![
            ("instantaneous", GrowthLaw::Instantaneous),
            ("linear", GrowthLaw::Linear),
            ("sine", GrowthLaw::Sine),
            ("series", GrowthLaw::Series),
        ]
    }
}

impl Choice for BreachFormula {
    const WHAT: &'static str = "a formula of breaches";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("froehlich2008", BreachFormula::Froehlich2008), ("froehlich1995", BreachFormula::Froehlich1995)]
    }
}

impl Choice for BreachMode {
    const WHAT: &'static str = "a mode of failure";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("overtopping", BreachMode::Overtopping), ("piping", BreachMode::Piping)]
    }
}

/// What happens at a boundary of which nothing else is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpenType {
    /// Water leaves, over an edge where the bed does not fall.
    Open,
    /// Waves leave.
    Free,
    /// A wall.
    Closed,
}

impl Choice for OpenType {
    const WHAT: &'static str = "a type of boundary";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("open", OpenType::Open), ("free", OpenType::Free), ("closed", OpenType::Closed)]
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

impl Choice for OutputPart {
    const WHAT: &'static str = "a part of the run folder";

    fn choices() -> Vec<(&'static str, Self)> {
        Self::ALL.iter().map(|part| (part.name(), *part)).collect()
    }
}

impl Choice for PointInterpolation {
    const WHAT: &'static str = "an interpolation between points";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("inverse_distance", Self::InverseDistance), ("natural_neighbour", Self::NaturalNeighbour)]
    }
}
