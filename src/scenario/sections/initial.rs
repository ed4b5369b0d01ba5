//! `initial`: water at the start.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::scenario::fields::{InputFile, Length, Level, Moment, Quantity, Text, VectorFile};
use crate::scenario::model::{EarlierRun, InitialWater, RiverWidth, Scenario, Start, WaterOfDepth};
use crate::scenario::read::{FromNode, Reader, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, Yaml, file, quantity, quoted, vector};

section! {
    /// Water at the start: polygons with a level or a depth, a river with a depth, or the state of an earlier run.
    InitialEntry, example "{reservoir: reservoir.geojson, level: 100 m}", check check_initial {
        /// File with the polygons of a reservoir; one of `reservoir`, `sea`, `water`, `river`, `fields` is required when absent.
        /// Codes: leaking-rim, nodata-in-water, overlapping-water, polygon-beyond-data, seeded-volume, volume-at-banks.
        reservoir: Option<VectorFile>,
        /// The same as `reservoir`, for the sea; see `reservoir` when absent. Codes: leaking-rim, nodata-in-water,
        /// overlapping-water, polygon-beyond-data, seeded-volume, volume-at-banks.
        sea: Option<VectorFile>,
        /// The same as `reservoir`, for any other water; see `reservoir` when absent. Codes: leaking-rim, nodata-in-water,
        /// overlapping-water, polygon-beyond-data, resolution-too-coarse.
        water: Option<VectorFile>,
        /// Level of still water; that of `level_field` when absent. Codes: level-below-bed, two-levels, implausible-level, leaking-rim.
        level: Option<Quantity<Level>>,
        /// Attribute of each polygon that holds the level (m); `level_m`, else `level` when absent. Codes: no-level,
        /// unit-of-attribute, implausible-level, level-below-bed.
        level_field: Option<Text>,
        /// In place of a level: the same depth on every cell inside, but for those that a dam, a levee or a building raises;
        /// required with `river` when absent. Codes: deep-water, method-combination.
        depth: Option<Quantity<Length>>,
        /// File with the axis of a river as lines; see `reservoir` when absent. Codes: river-size, outside-terrain, no-lines,
        /// left-out, method-combination.
        river: Option<VectorFile>,
        /// Width of the river; that of `width_field` when absent. Codes: river-size.
        width: Option<Quantity<Length>>,
        /// Attribute of each line that holds the width of the river (m); one cell, without `width`, when absent. Codes: no-width,
        /// unit-of-attribute, river-size.
        width_field: Option<Text>,
        /// `fields.nc` of an earlier run on the same terrain, alone in the list; see `reservoir` when absent. Codes:
        /// other-lattice, other-terrain, change-under-water, other-structures, other-dry-ground, volume-of-earlier-run,
        /// levels-of-earlier-run, not-a-fields-file.
        fields: Option<InputFile>,
        /// Beside `fields`: the time of a frame of that run, such as `600 s`, or `last`; last when absent. Codes: no-such-frame,
        /// incomplete-frame, no-water, unfinished-earlier-run, failed-run, gate-of-earlier-run.
        time: Option<FrameTime>,
    }
}

/// The keys of the polygon of a body of water.
pub const WATER_KINDS: [&str; 3] = ["reservoir", "sea", "water"];

pub(super) fn resolved(entry: InitialEntry) -> Option<InitialWater> {
    Some(InitialWater {
        polygons: entry.reservoir.or(entry.sea).or(entry.water)?.0,
        level: entry.level.map(|level| level.sourced),
        level_field: entry.level_field.map(|field| field.0.value),
    })
}

/// A time of an earlier run, or `last`.
#[derive(Clone, Debug)]
pub struct FrameTime(pub Option<Quantity<Moment>>);

impl FromNode for FrameTime {
    fn example() -> String {
        "last".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        match &node.value {
            Value::Text(text) if text == "last" => return Some(FrameTime(None)),
            Value::Text(text) if !text.contains(|c: char| c.is_ascii_digit()) => {
                let remedy = "write `last`, or a time such as `10 min`";
                reader.error(node, "unknown-name", format!("`{text}` is no moment of a run"), remedy);
                return None;
            }
            _ => {}
        }
        Quantity::from_node(node, reader).map(|time| FrameTime(Some(time)))
    }
}

impl JsonSchema for FrameTime {
    fn schema_name() -> Cow<'static, str> {
        "FrameTime".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let time = generator.subschema_for::<Quantity<Moment>>();
        json_schema!({"anyOf": [{"const": "last"}, time]})
    }
}

/// Refuses keys of an entry that do not go together.
pub fn check_initial(node: &Node, reader: &mut Reader) -> Option<()> {
    let kind = reader.exactly_one(node, &[&WATER_KINDS[..], &["river", "fields"]].concat())?;
    let amounts = ["level", "level_field", "depth"];
    let (allowed, needed): (&[&str], Option<&str>) = match kind {
        "river" => (&["depth", "width", "width_field"], Some("depth")),
        "fields" => (&["time"], None),
        _ => (&amounts, None),
    };
    let mut is_fit = true;
    for name in ["level", "level_field", "depth", "width", "width_field", "time"] {
        if let Some(value) = node.get(name).filter(|_| !allowed.contains(&name)) {
            reader.error(value, "conflict", format!("`{name}` does not go with `{kind}`"), "take it out");
            is_fit = false;
        }
    }
    for pair in [&amounts[..], &["width", "width_field"]] {
        let found: Vec<&str> = pair.iter().copied().filter(|name| node.has(name)).collect();
        if found.len() > 1 && found.iter().all(|name| allowed.contains(name)) {
            let list: Vec<String> = found.iter().map(|name| format!("`{name}`")).collect();
            reader.error(node, "conflict", format!("{} exclude each other", list.join(" and ")), "keep one of the two");
            is_fit = false;
        }
    }
    if let Some(key) = needed.filter(|key| !node.has(key)) {
        let message = format!("a {kind} needs the key `{key}`");
        reader.error(node, "missing-key", message, format!("add for example `{key}: 0.8 m`"));
        is_fit = false;
    }
    is_fit.then_some(())
}

/// Refuses other water beside the state of an earlier run.
pub fn check_alone(root: &Node, reader: &mut Reader) -> Option<()> {
    let Some(Value::List(entries)) = root.get("initial").map(|list| &list.value) else { return Some(()) };
    let Some(fields) = entries.iter().find_map(|entry| entry.get("fields")).filter(|_| entries.len() > 1) else {
        return Some(());
    };
    let message = "the state of an earlier run is all the water of the start";
    reader.error(fields, "conflict", message, "take the other entries of `initial` out, or this one");
    None
}

/// The bodies with a level stay; everything else goes into the start.
pub(super) fn split(entries: Vec<InitialEntry>) -> (Vec<InitialEntry>, Start) {
    let (mut bodies, mut start) = (Vec::new(), Start::default());
    for entry in entries {
        if let Some(fields) = entry.fields {
            let time = entry.time.and_then(|time| time.0).map(|time| time.sourced);
            start.earlier = Some(EarlierRun { fields: fields.0, time });
        } else if let Some(depth) = entry.depth {
            let river = entry.river.is_some().then(|| match (entry.width, entry.width_field) {
                (Some(width), _) => RiverWidth::Constant(width.value()),
                (None, Some(field)) => RiverWidth::Field(field.0.value),
                (None, None) => RiverWidth::Cell,
            });
            let place = entry.river.or(entry.reservoir).or(entry.sea).or(entry.water);
            start.depths.extend(place.map(|place| WaterOfDepth { place: place.0, depth: depth.sourced, river }));
        } else {
            bodies.push(entry);
        }
    }
    (bodies, start)
}

pub(super) fn written(scenario: &Scenario) -> Vec<Yaml> {
    let levels = scenario.initial.iter().map(|water| {
        Section::default()
            .with(water_kind(&water.polygons.key), vector(&water.polygons))
            .with_some("level", water.level.as_ref().map(|level| quantity(level.value, "m")))
            .with_some("level_field", water.level_field.as_deref().map(quoted))
    });
    let depths = scenario.start.depths.iter().map(|water| {
        let kind = if water.river.is_some() { "river" } else { water_kind(&water.place.key) };
        let of_depth =
            Section::default().with(kind, vector(&water.place)).with("depth", quantity(water.depth.value, "m"));
        match &water.river {
            Some(RiverWidth::Constant(width)) => of_depth.with("width", quantity(*width, "m")),
            Some(RiverWidth::Field(field)) => of_depth.with("width_field", quoted(field)),
            Some(RiverWidth::Cell) | None => of_depth,
        }
    });
    let earlier = scenario.start.earlier.iter().map(|earlier| {
        let time = earlier.time.as_ref().map_or("last".into(), |time| quantity(time.value, "s"));
        Section::default().with("fields", file(&earlier.fields.value)).with("time", time)
    });
    levels.chain(depths).chain(earlier).map(Yaml::Entry).collect()
}

/// The kind of water that the key path names, such as `initial[0].sea`.
fn water_kind(key: &str) -> &'static str {
    let kind = key.rsplit('.').next().unwrap_or_default();
    WATER_KINDS.into_iter().find(|known| *known == kind).unwrap_or("water")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::RiverWidth;
    use crate::error::{Error, ProblemKind};
    use crate::scenario::resolve;

    fn text(initial: &str) -> String {
        format!(
            "floodsim: 1\nterrain: dem.tif\nroughness: {{manning: 0.03}}\ninitial: {initial}\nresolution: 5 m\ntime: {{end: 1 h}}\n"
        )
    }

    #[test]
    fn every_kind_of_water_is_read() {
        let written = "[{water: a.gpkg:pond, depth: 50 cm}, {reservoir: b.gpkg, level: 3 m}, {river: r.gpkg, depth: 0.8 m, width: 12 m}, \
            {river: s.gpkg, depth: 1 m, width_field: w}, {river: t.gpkg, depth: 1 m}]";
        let scenario = resolve(&text(written), Path::new("s.yaml"), &[]).unwrap().scenario;
        assert_eq!(scenario.initial.len(), 1);
        let rivers: Vec<_> = scenario.start.depths.iter().map(|water| water.river.clone()).collect();
        let field = RiverWidth::Field("w".to_owned());
        assert_eq!(rivers, [None, Some(RiverWidth::Constant(12.0)), Some(field), Some(RiverWidth::Cell)]);
        assert_eq!(scenario.start.depths[0].place.key, "initial[0].water");
        assert!((scenario.start.depths[0].depth.value - 0.5).abs() < 1e-15);
        for (time, expected) in [("", None), (", time: last", None), (", time: 10 min", Some(600.0))] {
            let written = format!("[{{fields: before/fields.nc{time}}}]");
            let earlier = resolve(&text(&written), Path::new("s.yaml"), &[]).unwrap().scenario.start.earlier.unwrap();
            assert_eq!(
                (earlier.fields.key.as_str(), earlier.time.map(|time| time.value)),
                ("initial[0].fields", expected)
            );
        }
    }

    #[test]
    fn what_does_not_go_together_is_refused_where_it_stands() {
        for (written, code, key) in [
            ("[{water: a.gpkg, depth: 1 m, level: 2 m}]", "conflict", "initial[0]"),
            ("[{river: a.gpkg}]", "missing-key", "initial[0]"),
            ("[{river: a.gpkg, depth: 1}]", "missing-unit", "initial[0].depth"),
            ("[{river: a.gpkg, depth: 1 m, width: 3 m, width_field: w}]", "conflict", "initial[0]"),
            ("[{river: a.gpkg, level: 1 m, depth: 1 m}]", "conflict", "initial[0].level"),
            ("[{water: a.gpkg, level: 1 m, width: 3 m}]", "conflict", "initial[0].width"),
            ("[{fields: a.nc, depth: 1 m}]", "conflict", "initial[0].depth"),
            ("[{fields: a.nc, time: first}]", "unknown-name", "initial[0].time"),
            ("[{fields: a.nc}, {water: a.gpkg, depth: 1 m}]", "conflict", "initial[0].fields"),
            ("[{fields: a.nc, water: a.gpkg}]", "conflict", "initial[0]"),
        ] {
            let Err(Error::Problems(found)) = resolve(&text(written), Path::new("s.yaml"), &[]) else {
                panic!("not refused: {written}")
            };
            let found = found.into_iter().find(|problem| problem.kind == ProblemKind::Scenario).unwrap();
            assert_eq!((found.code, found.key.as_str()), (code, key), "{written}: {found}");
            assert!(found.remedy.is_some());
        }
    }
}
