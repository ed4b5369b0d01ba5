//! The section of a dam that breaks, and what it becomes in the resolved scenario.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::error::{Problem, ProblemKind};
use crate::scenario::choices::Chosen;
use crate::scenario::fields::{
    Coordinate, Duration, Height, Level, Moment, Quantity, SideSlope, SpreadFactor, Text, VectorFile, Volume,
};
use crate::scenario::model::{
    Breach, BreachFormula, BreachMethod, BreachMode, BreachShape, BreachTrigger, GrowthLaw, Sourced,
};
use crate::scenario::read::{FromNode, Reader, section};
use crate::scenario::timed::{self, ShareSeries};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, Yaml, name_of, point, quantity, quoted, vector};

section! {
    /// A dam that stands at the start and breaks: all of it, by `shape` and `growth`, or by a formula (`method`).
    BreachSection, example "{dam: dam.geojson, crest: 105 m}", check check_breach {
        /// File with one line along the crest, from abutment to abutment. Codes: dam-lines, dam-end-open, water-above-crest,
        /// opening-above-water, opening-blocked, water-in-dam.
        dam: VectorFile,
        /// Level of the crest; that of `crest_field` when absent. Codes: crest-below-terrain, water-above-crest.
        crest: Option<Quantity<Level>>,
        /// Attribute of the line that holds the crest (m); `crest_m` or `crest` when absent. Codes: no-crest, unit-of-attribute,
        /// crest-below-terrain.
        crest_field: Option<Text>,
        /// When the breach begins to form; at the start of the run when absent.
        trigger: Option<TriggerSection>,
        /// The final opening; the whole dam goes, down to the terrain, when absent. Codes: wall-in-breach, opening-above-water,
        /// opening-blocked.
        shape: Option<ShapeSection>,
        /// How it grows; instantaneous when absent.
        growth: Option<Growth>,
        /// In place of `shape` and `growth`: a formula for embankment dams, with growth by the sine law; none when absent.
        method: Option<MethodSection>,
    }
}

/// The one dam that breaks: several are a list in other places, and are refused here in words of their own.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(transparent)]
pub struct OneBreach(pub BreachSection);

impl FromNode for OneBreach {
    fn example() -> String {
        BreachSection::example()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let Value::List(dams) = &node.value else { return BreachSection::from_node(node, reader).map(OneBreach) };
        let problem = Problem::error(
            ProblemKind::Scenario,
            "one-breach",
            node.key.clone(),
            format!("`breach` is a list of {}, and one dam breaks in a run", dams.len()),
        );
        let remedy = if dams.len() == 1 {
            "write its keys without the dash or the brackets, for example `breach: {dam: dam.geojson, crest: 105 m}`"
        } else {
            "keep the dam that breaks first, and raise the others with `terrain.breaklines` (`mode: raise`); where one breaks after it, go on \
             from a moment before that (`initial: [{fields: runs/first/fields.nc}]`) with that one under `breach`"
        };
        reader.report(node, problem.with_remedy(remedy));
        None
    }
}

fn check_breach(node: &Node, reader: &mut Reader) -> Option<()> {
    if node.has("crest") && node.has("crest_field") {
        reader.error(node, "conflict", "`crest` and `crest_field` exclude each other", "keep one of the two");
        return None;
    }
    if let Some(method) = node.get("method")
        && (node.has("shape") || node.has("growth"))
    {
        let remedy = "keep `method`, or `shape` and `growth` with the dimensions that you want";
        reader.error(method, "conflict", "`method` gives shape and growth itself", remedy);
        return None;
    }
    Some(())
}

section! {
    /// A formula that gives width, side slope and formation time of the breach of an embankment dam.
    MethodSection, example "{name: froehlich2008, mode: overtopping, volume: 9.8 Mm3, invert: 780 m}", check check_method {
        /// The formula.
        name: Chosen<BreachFormula>,
        /// How the dam fails.
        mode: Chosen<BreachMode>,
        /// Water above the final breach invert when the breach begins, in `m3`, `Mm3`, `hm3`, `km3` or `acre-ft`. Codes: breach-volume.
        volume: Quantity<Volume>,
        /// Final breach invert; the height of the breach is that of the crest above it. Codes: invert-above-crest,
        /// invert-below-terrain, terrain-in-breach.
        invert: Quantity<Level>,
        /// Place on the dam (two coordinates) in the middle of the breach; the middle of the line when absent. Codes:
        /// position-off-dam, breach-beyond-dam.
        position: Option<Vec<Quantity<Coordinate>>>,
        /// Factor of the mean width, as studies vary it: the formula is a fit to failures that scatter about it; 1 when absent.
        width_factor: Option<Quantity<SpreadFactor>>,
        /// Factor of the formation time; 1 when absent.
        time_factor: Option<Quantity<SpreadFactor>>,
    }
}

fn check_method(node: &Node, reader: &mut Reader) -> Option<()> {
    two_coordinates(node, "position", reader)
}

section! {
    /// When a breach begins to form: at a time, or when the water at a place reaches a level.
    TriggerSection, example "{at: 0 s}", check check_trigger {
        /// Time at which the breach begins; `level` is required when absent. Codes: trigger-after-end.
        at: Option<Quantity<Moment>>,
        /// Level of the water at `at_point` at which it begins; `at` is required when absent. Codes: level-never-reached,
        /// trigger-above-crest.
        level: Option<Quantity<Level>>,
        /// Place of the level: its two coordinates in the reference system of the run; required with `level` when absent. Codes:
        /// outside-terrain.
        at_point: Option<Vec<Quantity<Coordinate>>>,
    }
}

fn check_trigger(node: &Node, reader: &mut Reader) -> Option<()> {
    let kind = reader.exactly_one(node, &["at", "level"])?;
    match (kind, node.get("at_point")) {
        ("level", None) => {
            let remedy = "add for example `at_point: [712345.0, 5312345.0]`, a place in the reservoir before the dam";
            reader.error(node, "missing-key", "a level needs the place at which it counts", remedy);
            None
        }
        ("at", Some(place)) => {
            reader.error(place, "conflict", "`at_point` goes with `level`, not with `at`", "take it out");
            None
        }
        _ => two_coordinates(node, "at_point", reader),
    }
}

section! {
    /// The final opening: a trapezoid in the long profile of the dam.
    ShapeSection, example "{bottom_width: 40 m, side_slope: 1.0, invert: 780 m}", check check_shape {
        /// Final width of its bottom. Codes: breach-without-area, breach-wider-than-dam, breach-beyond-dam, breach-coarse.
        bottom_width: Quantity<Height>,
        /// Slope of its sides, horizontal to vertical; 0 is vertical; 1 when absent. Codes: breach-wider-than-dam.
        side_slope: Option<Quantity<SideSlope>>,
        /// Final breach invert: the level of its bottom. Codes: invert-above-crest, invert-below-terrain, terrain-in-breach.
        invert: Quantity<Level>,
        /// Place on the dam (two coordinates) in its middle; the middle of the line when absent. Codes: position-off-dam,
        /// breach-beyond-dam.
        position: Option<Vec<Quantity<Coordinate>>>,
    }
}

fn check_shape(node: &Node, reader: &mut Reader) -> Option<()> {
    two_coordinates(node, "position", reader)
}

fn two_coordinates(node: &Node, key: &str, reader: &mut Reader) -> Option<()> {
    if let Some(place) = node.get(key)
        && let Value::List(items) = &place.value
        && items.len() != 2
    {
        let message = format!("a place has two coordinates, not {}", items.len());
        reader.error(place, "wrong-type", message, format!("write for example `{key}: [712345.0, 5312345.0]`"));
        return None;
    }
    Some(())
}

section! {
    /// How a breach grows; `growth: instantaneous` stands for `{law: instantaneous}`.
    GrowthSection, example "{law: sine, duration: 35 min}", check check_growth {
        /// How the bottom sinks and widens with time: at once, linearly, by a sine (slow at the beginning and at the end), or by
        /// the series of `share`.
        law: Chosen<GrowthLaw>,
        /// Formation time, from the trigger to the final breach; required with `linear` and `sine` when absent. Codes:
        /// breach-unfinished.
        duration: Option<Quantity<Duration>>,
        /// Series of the share of the final opening, from 0 to 1 (or in `%`), against the time since the trigger; required with
        /// `series` when absent. Codes: growth-start, growth-end, falling-share, short-table, series-gap, breach-unfinished.
        share: Option<ShareSeries>,
    }
}

fn check_growth(node: &Node, reader: &mut Reader) -> Option<()> {
    let by_series = node.get("law").is_some_and(|law| law.value == Value::Text("series".to_owned()));
    match (by_series, node.get("share"), node.get("duration")) {
        (true, None, _) => {
            let remedy = "add for example `share: {series: growth.csv}`, columns time_min,share";
            reader.error(node, "missing-key", "growth by a series needs the key `share`", remedy);
            return None;
        }
        (true, _, Some(duration)) => {
            let remedy = "take it out, or take another law, such as `law: sine`";
            reader.error(duration, "conflict", "the series of `share` says how long the breach grows", remedy);
            return None;
        }
        (true, ..) => return Some(()),
        (false, Some(share), _) => {
            let remedy = "write `law: series`, or take it out";
            reader.error(share, "conflict", "`share` goes with `law: series`", remedy);
            return None;
        }
        (false, None, _) => {}
    }
    let is_at_once = node.get("law").is_some_and(|law| law.value == Value::Text("instantaneous".to_owned()));
    match (is_at_once, node.get("duration")) {
        (true, Some(duration)) => {
            let remedy = "take it out, or take another law, such as `law: sine`";
            reader.error(duration, "conflict", "an instantaneous breach has no duration", remedy);
            None
        }
        (false, None) => {
            let remedy = "add for example `duration: 35 min`; `floodsim breach` prints what common formulas say";
            reader.error(node, "missing-key", "a breach that grows needs the key `duration`", remedy);
            None
        }
        _ => Some(()),
    }
}

/// The growth: `growth: instantaneous`, or a section.
#[derive(Clone, Debug)]
pub enum Growth {
    /// By name alone.
    Name(Chosen<GrowthLaw>),
    /// With a duration or a series.
    Section(Box<GrowthSection>),
}

impl FromNode for Growth {
    fn example() -> String {
        GrowthSection::example()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let Value::Text(text) = &node.value else {
            return GrowthSection::from_node(node, reader).map(Box::new).map(Growth::Section);
        };
        if ["linear", "sine"].contains(&text.as_str()) {
            let remedy = format!("write for example `growth: {{law: {text}, duration: 35 min}}`");
            reader.error(node, "missing-key", "a breach that grows needs a duration", remedy);
            return None;
        }
        if text == "series" {
            let remedy = "write for example `growth: {law: series, share: {series: growth.csv}}`";
            reader.error(node, "missing-key", "growth by a series needs the key `share`", remedy);
            return None;
        }
        Chosen::from_node(node, reader).map(Growth::Name)
    }
}

impl JsonSchema for Growth {
    fn schema_name() -> Cow<'static, str> {
        "Growth".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let section = generator.subschema_for::<GrowthSection>();
        json_schema!({"anyOf": [{"const": "instantaneous"}, section]})
    }
}

/// The breach of a section, with its defaults.
pub(super) fn resolved(section: BreachSection) -> Option<Breach> {
    let place = |place: Vec<Quantity<Coordinate>>| {
        let [x, y] = &place[..] else { return None };
        let (key, at) = (x.sourced.key.trim_end_matches("[0]").to_owned(), x.sourced.place.clone());
        Some(Sourced { value: [x.value(), y.value()], key, place: at })
    };
    let trigger = match section.trigger {
        None => BreachTrigger::At(Sourced { value: 0.0, key: "breach.trigger".to_owned(), place: None }),
        Some(TriggerSection { at: Some(at), .. }) => BreachTrigger::At(at.sourced),
        Some(TriggerSection { level, at_point, .. }) => {
            BreachTrigger::Level { level: level?.sourced, place: place(at_point?)? }
        }
    };
    let shape = section.shape.map(|shape| BreachShape {
        bottom_width: shape.bottom_width.sourced,
        side_slope: shape.side_slope.map_or(1.0, |slope| slope.value()),
        invert: shape.invert.sourced,
        position: shape.position.and_then(place),
    });
    let (law, duration, share) = match section.growth {
        None => (GrowthLaw::Instantaneous, None, None),
        Some(Growth::Name(law)) => (law.0.value, None, None),
        Some(Growth::Section(growth)) => {
            let GrowthSection { law, duration, share } = *growth;
            (law.0.value, duration.map(|duration| duration.sourced), share.map(|share| share.0))
        }
    };
    Some(Breach {
        dam: section.dam.0,
        crest: section.crest.map(|crest| crest.sourced),
        crest_field: section.crest_field.map(|field| field.0.value),
        trigger,
        shape,
        law,
        duration,
        share,
        method: section.method.map(|method| BreachMethod {
            formula: method.name.0.value,
            mode: method.mode.0.value,
            volume: method.volume.sourced,
            invert: method.invert.sourced,
            position: method.position.and_then(place),
            width_factor: method.width_factor.map_or(1.0, |factor| factor.value()),
            time_factor: method.time_factor.map_or(1.0, |factor| factor.value()),
        }),
    })
}

/// The breach of a dam.
pub(super) fn written(breach: &Breach) -> Section {
    let trigger = match &breach.trigger {
        BreachTrigger::At(at) => Section::default().with("at", quantity(at.value, "s")),
        BreachTrigger::Level { level, place } => {
            Section::default().with("level", quantity(level.value, "m")).with("at_point", point(place.value))
        }
    };
    let shape = breach.shape.as_ref().map(|shape| {
        Section::default()
            .with("bottom_width", quantity(shape.bottom_width.value, "m"))
            .with("side_slope", shape.side_slope)
            .with("invert", quantity(shape.invert.value, "m"))
            .with_some("position", shape.position.as_ref().map(|place| point(place.value)))
    });
    let method = breach.method.as_ref().map(|method| {
        Section::default()
            .with("name", name_of(|candidate: &BreachFormula| *candidate == method.formula))
            .with("mode", name_of(|candidate: &BreachMode| *candidate == method.mode))
            .with("volume", quantity(method.volume.value, "m3"))
            .with("invert", quantity(method.invert.value, "m"))
            .with_some("position", method.position.as_ref().map(|place| point(place.value)))
            .with("width_factor", method.width_factor)
            .with("time_factor", method.time_factor)
    });
    let growth = method.is_none().then(|| growth(breach));
    Section::default()
        .with("dam", vector(&breach.dam))
        .with_some("crest", breach.crest.as_ref().map(|crest| quantity(crest.value, "m")))
        .with_some("crest_field", breach.crest_field.as_deref().map(quoted))
        .with("trigger", Yaml::Entry(trigger))
        .with_some("shape", shape.map(Yaml::Entry))
        .with_some("method", method.map(Yaml::Entry))
        .with_some("growth", growth)
}
fn growth(breach: &Breach) -> Yaml {
    let law = name_of(|candidate: &GrowthLaw| *candidate == breach.law);
    let of_law = Section::default().with("law", law);
    match (&breach.duration, &breach.share) {
        (_, Some(share)) => Yaml::Entry(of_law.with("share", timed::series_written(share))),
        (Some(duration), None) => Yaml::Entry(of_law.with("duration", quantity(duration.value, "s"))),
        (None, None) => law.into(),
    }
}

#[cfg(test)]
mod tests;
