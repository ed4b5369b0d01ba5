//! `outputs`.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::resolution;
use crate::scenario::choices::Chosen;
use crate::scenario::defaults::{FRAMES, RISE_ON_WET, THRESHOLDS, default_isochrones, sensible_interval};
use crate::scenario::fields::{Duration, Length, Quantity, Text, VectorFile};
use crate::scenario::model::{OutputPart, Outputs, Scenario, Sourced};
use crate::scenario::read::{FromNode, NonEmpty, Reader, folder_of, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::units::{Dimension, LENGTH, TIME};
use crate::scenario::yaml::{Section, Yaml, file, quantity, vector};

section! {
    /// What is written, where and how often.
    OutputsSection, example "{every: 100 s}", check check_isochrones {
        /// Run folder, relative to the scenario; `--out` overrides it; `runs/NAME` in the current folder when absent. Codes:
        /// output-folder-not-empty, output-folder-in-use, output-folder-unwritable, input-in-output-folder.
        folder: Option<Text>,
        /// What is written beside `run.json` and `scenario.resolved.yaml`; what is left out is not computed; all when absent.
        /// Codes: not-written.
        write: Option<Vec<Chosen<OutputPart>>>,
        /// Edge of a cell of the maps, or `terrain` for maps on the raster of the terrain itself; the resolution,
        /// the finest one of levels, when absent. Codes: finer-than-resolution, no-finer-raster.
        cell: Option<MapCell>,
        /// Interval of the frames in `fields.nc` and of the profiles of channels; a fortieth of the run, rounded, when absent.
        /// Codes: longer-than-run, too-many-outputs.
        every: Option<Quantity<Duration>>,
        /// CSV with the columns `id,x,y` (further ones are kept), or a file of points; none when absent. Codes:
        /// gauges-outside-terrain, gauge-outside-terrain, gauge-on-nodata, duplicate-gauge, bad-gauge-line, no-gauges.
        gauges: Option<VectorFile>,
        /// File of lines through which the discharge is measured, drawn from the left to the right bank; none when absent. Codes:
        /// section-outside, section-on-edge, section-short, duplicate-section, no-lines, method-combination.
        sections: Option<VectorFile>,
        /// Interval of the series of gauges and cross-sections; a tenth of `every`, but at least 1 s (`every` where that is
        /// shorter), when absent. Codes: longer-than-run, too-many-outputs.
        gauges_every: Option<Quantity<Duration>>,
        /// What counts as arrival; the depths 0.01, 0.10 and 0.30 m, and a rise of 0.10 m on water, when absent.
        arrival: Option<ArrivalSection>,
        /// Whether a second run on cells twice as wide estimates the error of the maps, at about an eighth of the cost; `false` when
        /// absent. Codes: no-error-estimate, not-written.
        error_estimate: Option<bool>,
        /// Times of the isochrones, the earliest first; 5, 10, 15, 30, 45, 60, 90, 120 min, then every hour when absent. Codes:
        /// not-written.
        isochrones: Option<Vec<Quantity<Duration>>>,
    }
}

/// The cells of the maps.
#[derive(Clone, Debug)]
pub enum MapCell {
    /// `cell: terrain`
    Terrain(Sourced<()>),
    /// `cell: 20 m`
    Length(Quantity<Length>),
}

impl FromNode for MapCell {
    fn example() -> String {
        "terrain".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        match &node.value {
            Value::Text(text) if text == "terrain" => Some(MapCell::Terrain(reader.sourced(node, ()))),
            Value::Text(text) if !text.contains(|c: char| c.is_ascii_digit()) => {
                let remedy = "write `terrain` for the raster of the terrain itself, or a length such as `20 m`";
                reader.error(node, "unknown-name", format!("`{text}` is no cell of a map"), remedy);
                None
            }
            _ => Quantity::from_node(node, reader).map(MapCell::Length),
        }
    }
}

impl JsonSchema for MapCell {
    fn schema_name() -> Cow<'static, str> {
        "MapCell".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let length = generator.subschema_for::<Quantity<Length>>();
        json_schema!({"anyOf": [{"const": "terrain"}, length]})
    }
}

section! {
    /// What counts as arrival of the water.
    ArrivalSection, example "{thresholds: [0.01 m, 0.10 m, 0.30 m]}", check check_thresholds {
        /// Depths for which arrival and duration are mapped; the first gives `arrival_time` and the isochrones; 0.01, 0.10 and
        /// 0.30 m when absent.
        thresholds: Option<NonEmpty<Quantity<Length>>>,
        /// Rise of the level that counts as arrival where there was water at the start; 0.10 m when absent.
        rise_on_wet: Option<Quantity<Length>>,
    }
}

/// Frames of a run at most: every 5 min for a year.
const MOST_FRAMES: f64 = 1.1e5;
/// Times of the series of a run at most: every 30 s for a year.
const MOST_SAMPLES: f64 = 1.1e6;

/// Warns of intervals of the outputs longer than the run, refuses too short ones, and warns of cells finer than what was computed.
pub(super) fn tell_of_outputs(node: &Node, reader: &mut Reader) {
    let Some(outputs) = node.get("outputs") else { return };
    let quantity = |node: Option<&Node>, dimension: &Dimension| match &node?.value {
        Value::Text(text) => dimension.parse(text).ok(),
        _ => None,
    };
    let end = quantity(node.get("time").and_then(|time| time.get("end")), &TIME);
    for (key, what) in [("every", "frames"), ("gauges_every", "rows of the series")] {
        if let Some(interval) = outputs.get(key)
            && quantity(Some(interval), &TIME).zip(end).is_some_and(|(interval, end)| interval > end)
        {
            let message =
                format!("this interval is longer than the run: the only {what} are those of its start and its end");
            reader.warning(interval, "longer-than-run", message, "give a shorter interval, or leave it out");
        }
        let most = if key == "every" { MOST_FRAMES } else { MOST_SAMPLES };
        if let Some(interval) = outputs.get(key)
            && let Some((seconds, end)) = quantity(Some(interval), &TIME).zip(end)
            && end / seconds > most
        {
            let message = format!("{:.3e} {what} are more than {most:.0}, the most there can be", end / seconds);
            let remedy = format!("give an interval of {:.3} s or more", (end / most * 1e3).ceil() / 1e3);
            reader.error(interval, "too-many-outputs", message, remedy);
        }
    }
    let is_written = |part: &str| match outputs.get("write").map(|list| &list.value) {
        Some(Value::List(parts)) => parts.iter().any(|item| item.value == Value::Text(part.to_owned())),
        _ => true,
    };
    if let Some(isochrones) = outputs.get("isochrones").filter(|_| !is_written("gpkg")) {
        let message = "isochrones stand in results.gpkg, which `outputs.write` leaves out";
        reader.warning(isochrones, "not-written", message, "add `gpkg` to `outputs.write`, or leave `isochrones` out");
    }
    let has_maps = is_written("maps") || is_written("cog");
    if let Some(estimate) = outputs.get("error_estimate").filter(|_| !has_maps) {
        let message = "estimated errors stand in the maps, which `outputs.write` leaves out";
        reader.warning(
            estimate,
            "not-written",
            message,
            "add `maps` to `outputs.write`, or leave `error_estimate` out",
        );
    }
    if let Some(cell) = outputs.get("cell")
        && quantity(Some(cell), &LENGTH).zip(quantity(resolution::finest(node), &LENGTH)).is_some_and(|(c, r)| c < r)
    {
        let message = "the cells of the maps are finer than the resolution, and show nothing that was not computed";
        reader.warning(cell, "finer-than-resolution", message, "leave `cell` out, or take a finer `resolution`");
    }
}

/// An isochrone bounds what was reached since the one before it.
fn check_isochrones(node: &Node, reader: &mut Reader) -> Option<()> {
    let Some(Node { value: Value::List(items), .. }) = node.get("isochrones") else { return Some(()) };
    let time = |item: &Node| if let Value::Text(text) = &item.value { TIME.parse(text).ok() } else { None };
    for pair in items.windows(2) {
        if let (Some(before), Some(after)) = (time(&pair[0]), time(&pair[1]))
            && after <= before
        {
            let message = "the times of the isochrones must rise, and this one does not lie after the one before it";
            reader.error(&pair[1], "conflict", message, "write each time once, the earliest first");
            return None;
        }
    }
    Some(())
}

fn check_thresholds(node: &Node, reader: &mut Reader) -> Option<()> {
    let Some(Node { value: Value::List(items), .. }) = node.get("thresholds") else { return Some(()) };
    let depth = |item: &Node| if let Value::Text(text) = &item.value { LENGTH.parse(text).ok() } else { None };
    for (index, item) in items.iter().enumerate() {
        if depth(item).is_some() && items[..index].iter().any(|earlier| depth(earlier) == depth(item)) {
            reader.error(item, "conflict", "this threshold stands twice in the list", "keep one of the two");
            return None;
        }
    }
    Some(())
}

pub(super) fn resolved(
    section: Option<OutputsSection>,
    name: &str,
    file: &Path,
    resolution: f64,
    end_time: f64,
) -> Outputs {
    let section = section.unwrap_or(OutputsSection {
        folder: None,
        write: None,
        cell: None,
        every: None,
        sections: None,
        gauges: None,
        gauges_every: None,
        arrival: None,
        error_estimate: None,
        isochrones: None,
    });
    let every = section.every.map_or_else(|| sensible_interval(end_time / FRAMES), |every| every.value());
    let (thresholds, rise_on_wet) =
        section.arrival.map_or((None, None), |arrival| (arrival.thresholds, arrival.rise_on_wet));
    let isochrones = match section.isochrones {
        Some(times) => times.iter().map(|time| time.value()).collect(),
        None => default_isochrones(end_time),
    };
    Outputs {
        folder: match section.folder {
            Some(Text(Sourced { value, key, place })) => Sourced { value: folder_of(file).join(value), key, place },
            None => Sourced { value: Path::new("runs").join(name), key: String::new(), place: None },
        },
        write: match section.write {
            Some(parts) => {
                let parts: BTreeSet<OutputPart> = parts.iter().map(|part| part.0.value).collect();
                parts.into_iter().collect()
            }
            None => OutputPart::ALL.to_vec(),
        },
        cell: match &section.cell {
            Some(MapCell::Length(cell)) => cell.value(),
            Some(MapCell::Terrain(_)) | None => resolution,
        },
        maps_on_terrain: match section.cell {
            Some(MapCell::Terrain(place)) => Some(place),
            _ => None,
        },
        every,
        gauges_every: section.gauges_every.map_or_else(|| (every / 10.0).max(1.0).min(every), |every| every.value()),
        sections: section.sections.map(|sections| sections.0),
        gauges: section.gauges.map(|gauges| gauges.0),
        thresholds: match thresholds {
            Some(thresholds) => thresholds.0.iter().map(|threshold| threshold.value()).collect(),
            None => THRESHOLDS.to_vec(),
        },
        rise_on_wet: rise_on_wet.map_or(RISE_ON_WET, |rise| rise.value()),
        isochrones,
        error_estimate: section.error_estimate.unwrap_or(false),
    }
}

pub(super) fn written(scenario: &Scenario) -> Section {
    let outputs = &scenario.outputs;
    let has_maps = !scenario.is_channels_alone();
    let cell = if outputs.maps_on_terrain.is_some() { "terrain".into() } else { quantity(outputs.cell, "m") };
    let list = |values: &[f64], unit| Yaml::Row(values.iter().map(|value| quantity(*value, unit)).collect());
    let arrival = Section::default()
        .with("thresholds", list(&outputs.thresholds, "m"))
        .with("rise_on_wet", quantity(outputs.rise_on_wet, "m"));
    Section::default()
        .with("folder", file(&outputs.folder.value))
        .with("write", Yaml::Row(outputs.write.iter().copied().map(OutputPart::name).map(Yaml::from).collect()))
        .with_some("cell", has_maps.then_some(cell))
        .with("every", quantity(outputs.every, "s"))
        .with("gauges_every", quantity(outputs.gauges_every, "s"))
        .with_some("gauges", outputs.gauges.as_ref().map(vector))
        .with_some("sections", outputs.sections.as_ref().map(vector))
        .with("arrival", arrival)
        .with_some("error_estimate", outputs.error_estimate.then_some(true))
        .with_some("isochrones", has_maps.then(|| list(&outputs.isochrones, "s")))
}
