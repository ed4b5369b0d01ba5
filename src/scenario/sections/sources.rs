//! `sources`: water that comes out of the ground.

use crate::scenario::fields::{Coordinate, Discharge, Quantity, VectorFile};
use crate::scenario::model::{Scenario, Source, SourcePlace, Sourced};
use crate::scenario::read::{Reader, section};
use crate::scenario::timed::{self, Changing};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, Yaml, point, vector};

section! {
    /// Water that comes out of the ground at a place or along a line.
    SourceEntry, example "{at: [712345.0, 5312345.0], discharge: 2 m3/s}", check check_source {
        /// The place: its two coordinates in the reference system of the run; `points` or `lines` is required when absent. Codes:
        /// source-outside.
        at: Option<Vec<Quantity<Coordinate>>>,
        /// File of points; `at` or `lines` is required when absent. Codes: source-outside, not-a-point, no-points.
        points: Option<VectorFile>,
        /// The same as `lines`; `at`, `points` or `lines` is required when absent. Codes: source-outside, several-lines,
        /// not-a-line, no-lines.
        line: Option<VectorFile>,
        /// File of lines, such as a seam of springs or the outfalls along a road; `at` or `points` is required when absent.
        /// Codes: source-outside, several-lines, not-a-line, no-lines.
        lines: Option<VectorFile>,
        /// Discharge at each place, or of each line (feature), constant or a series. Codes: huge-discharge, several-lines.
        discharge: Changing<Discharge>,
    }
}

fn check_source(node: &Node, reader: &mut Reader) -> Option<()> {
    reader.exactly_one(node, &["at", "points", "line", "lines"])?;
    if let Some(at) = node.get("at")
        && let Value::List(items) = &at.value
        && items.len() != 2
    {
        let message = format!("a place has two coordinates, not {}", items.len());
        reader.error(at, "wrong-type", message, "write for example `at: [712345.0, 5312345.0]`");
        return None;
    }
    Some(())
}

pub(super) fn resolved(entries: Vec<SourceEntry>) -> Vec<Sourced<Source>> {
    let place = |entry: &mut SourceEntry| match (entry.at.take(), entry.points.take()) {
        (Some(at), _) => {
            let [x, y] = &at[..] else { return None };
            let (key, place) = (x.sourced.key.trim_end_matches("[0]").to_owned(), x.sourced.place.clone());
            Some(SourcePlace::At(Sourced { value: [x.value(), y.value()], key, place }))
        }
        (None, Some(points)) => Some(SourcePlace::Points(points.0)),
        (None, None) => entry.line.take().or(entry.lines.take()).map(|lines| SourcePlace::Lines(lines.0)),
    };
    let source = |(index, mut entry): (usize, SourceEntry)| {
        let found = place(&mut entry)?;
        let at = match &found {
            SourcePlace::At(at) => at.place.clone(),
            SourcePlace::Points(file) | SourcePlace::Lines(file) => file.place.clone(),
        };
        let value = Source { place: found, discharge: entry.discharge.timed };
        Some(Sourced { value, key: format!("sources[{index}]"), place: at })
    };
    entries.into_iter().enumerate().filter_map(source).collect()
}

/// Sources in the resolved scenario.
pub(super) fn written(scenario: &Scenario) -> Vec<Yaml> {
    let source = |source: &Sourced<Source>| {
        let place = match &source.value.place {
            SourcePlace::At(at) => Section::default().with("at", point(at.value)),
            SourcePlace::Points(points) => Section::default().with("points", vector(points)),
            SourcePlace::Lines(lines) => Section::default().with("lines", vector(lines)),
        };
        Yaml::Entry(place.with("discharge", timed::written(&source.value.discharge, "m3/s")))
    };
    scenario.sources.iter().map(source).collect()
}
