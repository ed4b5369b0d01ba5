//! Channels of one dimension: their sections, and what becomes of them.

use super::boundaries::{NormalDepth, check_still, condition};
use crate::scenario::choices::{Choice, Chosen, OpenType};
use crate::scenario::fields::{
    Coordinate, Discharge, Fall, Height, InputFile, Length, Level, Manning, Quantity, Text, VectorFile,
};
use crate::scenario::model::{
    BoundaryCondition, Channel, ChannelGauge, ChannelShape, ChannelWalls, ChannelWater, Joint, Side, Sourced,
};
use crate::scenario::read::{NonEmpty, Reader, section};
use crate::scenario::timed::Changing;
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, Yaml, file, name_of, quantity, quoted, vector};

impl Choice for ChannelWalls {
    const WHAT: &'static str = "a kind of channel walls";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("rough", ChannelWalls::Rough), ("smooth", ChannelWalls::Smooth)]
    }
}

section! {
    /// A channel that is computed in one dimension. Distances count from its far end, which is upstream as a rule.
    ChannelEntry, example "{id: upper_reach, length: 800 m, width: 12 m, bed: 101.5 m, slope: 0.002, joins: {side: west}}", check check_channel {
        /// Name, for the tables. Codes: duplicate-channel.
        id: Text,
        /// Length from the far to the near end. Codes: channel-short, particle-limit, line-length.
        length: Quantity<Length>,
        /// Width of a rectangular channel; `sections` is required when absent. Codes: channel-width.
        width: Option<Quantity<Length>>,
        /// Elevation of the bed of a rectangular channel at its near end; required with `width` when absent. Codes: channel-step.
        bed: Option<Quantity<Level>>,
        /// Fall of that bed towards the near end, such as `0.002` or `2 %`, negative where it rises; 0 when absent.
        slope: Option<Quantity<Fall>>,
        /// CSV with the columns distance, elevation and width, units at the end of their names; `width` is required when absent.
        /// Codes: sections-short, sections-beyond, section-rows, section-not-rising, section-closed, implausible-level.
        sections: Option<InputFile>,
        /// Manning's n; that of `roughness.manning` when absent. Codes: no-roughness.
        manning: Option<Quantity<Manning>>,
        /// `rough`: bed and walls resist, by the hydraulic radius; `smooth`: the bed alone, as in the plane; rough when absent.
        walls: Option<Chosen<ChannelWalls>>,
        /// Still water at the start; where two entries overlap the later one counts; dry when absent.
        water: Option<NonEmpty<ChannelWaterEntry>>,
        /// The opening in the edge of the terrain that its near end joins; it joins nothing when absent.
        joins: Option<JoinsSection>,
        /// What is known beyond the far end; a wall when absent.
        upstream: Option<ChannelEndSection>,
        /// What is known beyond the near end of a channel that joins nothing; a wall when absent.
        downstream: Option<ChannelEndSection>,
        /// File with the axis from the far to the near end; of several lines that whose `id` or `name` is that of the channel.
        /// For the map alone; no place on the map when absent. Codes: no-lines, line-length, line-reversed, line-beside-opening.
        line: Option<VectorFile>,
        /// Places at which the water is recorded over time; none when absent.
        gauges: Option<Vec<ChannelGaugeEntry>>,
    }
}

fn check_channel(node: &Node, reader: &mut Reader) -> Option<()> {
    let kind = reader.exactly_one(node, &["width", "sections"])?;
    let mut is_fit = true;
    if kind == "width" && !node.has("bed") {
        let remedy = "add `bed: 101.5 m`, the elevation of its bed where it joins the terrain";
        reader.error(node, "missing-key", "a rectangular channel needs the key `bed`", remedy);
        is_fit = false;
    }
    for name in ["bed", "slope"].into_iter().filter(|_| kind == "sections") {
        if let Some(value) = node.get(name) {
            let message = format!("`{name}` goes with `width`, not with `sections`");
            reader.error(value, "conflict", message, "take it out: the table of sections has elevations");
            is_fit = false;
        }
    }
    if let (Some(_), Some(downstream)) = (node.get("joins"), node.get("downstream")) {
        let remedy = "keep `joins` for a channel that runs into the terrain, `downstream` for one that does not";
        reader.error(downstream, "conflict", "`joins` and `downstream` exclude each other", remedy);
        is_fit = false;
    }
    is_fit.then_some(())
}

section! {
    /// A gauge in a channel.
    ChannelGaugeEntry, example "{id: bridge, distance: 320 m}" {
        /// Name, for the tables, unique through all channels. Codes: duplicate-gauge.
        id: Text,
        /// Distance from the far end. Codes: gauge-outside.
        distance: Quantity<Height>,
    }
}

section! {
    /// Still water in a part of a channel, by a level or a depth.
    ChannelWaterEntry, example "{level: 103 m, from: 0 m, to: 300 m}", check check_water {
        /// Level of the water; `depth` is required when absent. Codes: level-below-bed.
        level: Option<Quantity<Level>>,
        /// Depth above the lowest bed of each section; 0 m leaves the part dry; `level` is required when absent.
        depth: Option<Quantity<Height>>,
        /// Beginning of the part, from the far end; 0 m when absent. Codes: water-outside.
        from: Option<Quantity<Height>>,
        /// End of the part, from the far end; the near end when absent. Codes: water-outside, water-beyond.
        to: Option<Quantity<Length>>,
    }
}

fn check_water(node: &Node, reader: &mut Reader) -> Option<()> {
    reader.exactly_one(node, &["level", "depth"]).map(|_| ())
}

section! {
    /// The opening through which a channel joins the terrain, as wide as its banks within one cell.
    JoinsSection, example "{side: west, from: 5312340, to: 5312352}", check check_joint {
        /// Side of the terrain: north, east, south or west. Codes: opens-nothing, channels-overlap, channel-width, channel-step.
        side: Chosen<Side>,
        /// One end of the opening: x on a northern or southern side, y on a western or eastern one; the whole side when absent.
        /// Codes: channel-width, opens-nothing.
        from: Option<Quantity<Coordinate>>,
        /// The other end; the whole side when absent. Codes: channel-width, opens-nothing.
        to: Option<Quantity<Coordinate>>,
    }
}

fn check_joint(node: &Node, reader: &mut Reader) -> Option<()> {
    if let Some(side) = node.get("side")
        && side.value == Value::Text("all".to_owned())
    {
        reader.error(side, "range", "a channel joins one side", "write north, east, south or west");
        return None;
    }
    if node.has("from") != node.has("to") {
        reader.error(node, "missing-key", "an opening has two ends", "give both `from` and `to`, or neither");
        return None;
    }
    Some(())
}

section! {
    /// What is known beyond an end of a channel: one condition, as in `boundaries`.
    ChannelEndSection, example "{discharge: 30 m3/s}", check check_end {
        /// Discharge that comes in by the section as a whole; another condition is required when absent. Codes: huge-discharge,
        /// fast-inflow.
        discharge: Option<Changing<Discharge>>,
        /// Level of the water at the end itself, alone or beside `discharge` for supercritical inflow; another condition is
        /// required when absent. Codes: level-below-bed, fast-inflow, implausible-level.
        level: Option<Changing<Level>>,
        /// Level of the still water beyond, such as that of a lake or a tide; another condition is required when absent. Codes:
        /// level-below-bed, implausible-level.
        stage: Option<Changing<Level>>,
        /// Level of a wave that comes in, while waves from inside leave; another condition is required when absent. Codes:
        /// wave-without-still, wave-begins-with-step, high-wave, level-below-bed.
        wave: Option<Changing<Level>>,
        /// Level without the `wave`, constant or a series; that of the water at the start when absent. Codes: wave-without-still,
        /// wave-begins-with-step, high-wave.
        still: Option<Changing<Level>>,
        /// Uniform flow goes on beyond; water leaves only; another condition is required when absent. Codes: no-roughness.
        normal_depth: Option<NormalDepth>,
        /// `free`: waves leave; `closed`: a wall, as without a condition; `open` is refused; another condition is required when absent.
        r#type: Option<Chosen<OpenType>>,
    }
}

fn check_end(node: &Node, reader: &mut Reader) -> Option<()> {
    let others = ["discharge", "stage", "wave", "normal_depth", "type"];
    if let Some(level) = node.get("level") {
        let kinds: Vec<&str> = others.into_iter().filter(|name| node.has(name)).collect();
        if !matches!(kinds[..], [] | ["discharge"]) {
            let message = format!("level and {} exclude each other at one end", kinds.join(" and "));
            let remedy = "keep one of them; only `discharge` and `level` go together, for supercritical inflow";
            reader.error(level, "conflict", message, remedy);
            return None;
        }
    } else {
        reader.exactly_one(node, &others)?;
    }
    check_still(node, reader)?;
    if let Some(kind) = node.get("type")
        && kind.value == Value::Text("open".to_owned())
    {
        reader.error(kind, "range", "a channel has no overfall", "write `type: free`, or `normal_depth: {slope: ...}`");
        return None;
    }
    Some(())
}

/// The channels of their entries.
pub(super) fn resolved(entries: Vec<ChannelEntry>) -> Vec<Channel> {
    entries.into_iter().filter_map(channel).collect()
}

fn channel(entry: ChannelEntry) -> Option<Channel> {
    let shape = match (entry.width, entry.bed, entry.sections) {
        (Some(width), Some(bed), _) => ChannelShape::Rectangle {
            width: width.value(),
            bed: bed.value(),
            slope: entry.slope.map_or(0.0, |slope| slope.value()),
        },
        (_, _, Some(sections)) => ChannelShape::Sections(sections.0),
        _ => return None,
    };
    let water = |entry: ChannelWaterEntry| {
        let water = ChannelWater {
            level: entry.level.as_ref().map(|level| level.value()),
            depth: entry.depth.as_ref().map(|depth| depth.value()),
            from: entry.from.map_or(0.0, |from| from.value()),
            to: entry.to.map(|to| to.value()),
        };
        let Sourced { key, place, .. } = entry.level.map(|l| l.sourced).or(entry.depth.map(|d| d.sourced))?;
        Some(Sourced { value: water, key, place })
    };
    let gauge = |entry: ChannelGaugeEntry| ChannelGauge { id: entry.id.0, distance: entry.distance.sourced };
    let joint = |section: JoinsSection| {
        let span = section.from.zip(section.to).map(|(a, b)| (a.value().min(b.value()), a.value().max(b.value())));
        let Sourced { value: side, key, place } = section.side.0;
        Sourced { value: Joint { side, span }, key, place }
    };
    Some(Channel {
        id: entry.id.0,
        length: entry.length.sourced,
        shape,
        manning: entry.manning.map(|n| n.value()),
        walls: entry.walls.map_or(ChannelWalls::default(), |walls| walls.0.value),
        water: entry.water.map_or_else(Vec::new, |entries| entries.0.into_iter().filter_map(water).collect()),
        joins: entry.joins.map(joint),
        upstream: entry.upstream.and_then(end),
        downstream: entry.downstream.and_then(end),
        line: entry.line.map(|line| line.0),
        gauges: entry.gauges.unwrap_or_default().into_iter().map(gauge).collect(),
    })
}

fn end(section: ChannelEndSection) -> Option<BoundaryCondition> {
    Some(if let Some(discharge) = section.discharge {
        BoundaryCondition::Discharge { discharge: discharge.timed, level: section.level.map(|level| level.timed) }
    } else if let Some(stage) = section.stage {
        BoundaryCondition::Stage(stage.timed)
    } else if let Some(level) = section.level {
        BoundaryCondition::Level(level.timed)
    } else if let Some(wave) = section.wave {
        BoundaryCondition::Wave { level: wave.timed, still: section.still.map(|still| still.timed) }
    } else if let Some(uniform) = section.normal_depth {
        BoundaryCondition::NormalDepth(uniform.slope.sourced)
    } else {
        section.r#type.filter(|kind| kind.0.value != OpenType::Closed).map(|_| BoundaryCondition::Free)?
    })
}

/// A channel in the resolved scenario.
pub(super) fn written(channel: &Channel) -> Yaml {
    let section =
        Section::default().with("id", quoted(&channel.id.value)).with("length", quantity(channel.length.value, "m"));
    let shape = match &channel.shape {
        ChannelShape::Rectangle { width, bed, slope } => {
            section.with("width", quantity(*width, "m")).with("bed", quantity(*bed, "m")).with("slope", *slope)
        }
        ChannelShape::Sections(path) => section.with("sections", file(&path.value)),
    };
    let end = |end: &Option<BoundaryCondition>| end.as_ref().map(|end| Yaml::Entry(condition(end)));
    let gauge = |gauge: &ChannelGauge| {
        let id = Section::default().with("id", quoted(&gauge.id.value));
        Yaml::Entry(id.with("distance", quantity(gauge.distance.value, "m")))
    };
    Yaml::Entry(
        shape
            .with_some("manning", channel.manning)
            .with("walls", name_of(|walls: &ChannelWalls| *walls == channel.walls))
            .with_row("water", channel.water.iter().map(|water| water_as_yaml(&water.value)).collect())
            .with_some("joins", channel.joins.as_ref().map(|joint| joint_as_yaml(&joint.value)))
            .with_some("upstream", end(&channel.upstream))
            .with_some("downstream", end(&channel.downstream))
            .with_some("line", channel.line.as_ref().map(vector))
            .with_row("gauges", channel.gauges.iter().map(gauge).collect()),
    )
}
fn water_as_yaml(water: &ChannelWater) -> Yaml {
    let length = |value: f64| quantity(value, "m");
    Yaml::Entry(
        Section::default()
            .with_some("level", water.level.map(length))
            .with_some("depth", water.depth.filter(|_| water.level.is_none()).map(length))
            .with("from", length(water.from))
            .with_some("to", water.to.map(length)),
    )
}
fn joint_as_yaml(joint: &Joint) -> Yaml {
    Yaml::Entry(
        Section::default()
            .with("side", name_of(|side: &Side| *side == joint.side))
            .with_some("from", joint.span.map(|(from, _)| from))
            .with_some("to", joint.span.map(|(_, to)| to)),
    )
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::error::{Error, Problem, ProblemKind};
    use crate::scenario::{Scenario, resolve};

    const START: &str =
        "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.03}\nresolution: 5 m\ntime: {end: 1 h}\nchannels:\n  - ";

    fn scenario(text: &str) -> Scenario {
        resolve(&format!("{START}{text}\n"), Path::new("scenario.yaml"), &[]).unwrap().scenario
    }

    fn problem(text: &str) -> Problem {
        let Err(Error::Problems(found)) = resolve(&format!("{START}{text}\n"), Path::new("scenario.yaml"), &[]) else {
            panic!("not refused: {text}")
        };
        found.into_iter().find(|problem| problem.kind == ProblemKind::Scenario).unwrap()
    }

    #[test]
    fn a_channel_reads_back_as_itself() {
        for text in [
            "{id: a, length: 80 m, width: 4 m, bed: 10 m, slope: 0.2 %, water: [{depth: 0.5 m}], joins: {side: west}}",
            "{id: b-1, length: 1 km, sections: x.csv, manning: 0.04, walls: smooth, upstream: {discharge: {series: q.csv, unit: l/s}, level: 3 m}, \
             water: [{level: 12 m, from: 0 m, to: 30 m}, {depth: 0 m, from: 30 m}], joins: {side: north, from: 12, to: 4.5}}",
            "{id: c, length: 80 m, width: 4 m, bed: 10 m, upstream: {stage: 11 m}, downstream: {normal_depth: {slope: 0.01}}}",
            "{id: d, length: 80 m, width: 4 m, bed: 10 m, slope: -0.01, downstream: {type: free}}",
            "{id: f, length: 80 m, width: 4 m, bed: 10 m, upstream: {level: 11 m}, downstream: {wave: {series: w.csv}, still: 10.5 m}}",
            "{id: e, length: 80 m, width: 4 m, bed: 10 m, line: axes.gpkg:e, gauges: [{id: 'p, 1', distance: 0 m}, {id: p2, distance: 7.5 m}]}",
        ] {
            let first = scenario(text);
            let written = first.to_yaml();
            let second = resolve(&written, Path::new("elsewhere.yaml"), &[]).unwrap().scenario;
            assert_eq!(written, second.to_yaml());
            let (a, b) = (&first.channels[0], &second.channels[0]);
            let water = |channel: &Channel| {
                channel.water.iter().map(|water| water.value.clone()).collect::<Vec<ChannelWater>>()
            };
            assert_eq!(
                (water(a), a.manning, a.walls, a.length.value.to_bits()),
                (water(b), b.manning, b.walls, b.length.value.to_bits())
            );
            let joint = |channel: &Channel| channel.joins.as_ref().map(|joint| joint.value);
            assert_eq!(joint(a), joint(b));
            let line = |channel: &Channel| channel.line.as_ref().map(|line| line.value.layer.clone());
            let gauges = |channel: &Channel| {
                channel.gauges.iter().map(|gauge| (gauge.id.value.clone(), gauge.distance.value)).collect::<Vec<_>>()
            };
            assert_eq!((line(a), gauges(a)), (line(b), gauges(b)));
        }
    }

    #[test]
    fn what_does_not_go_together_is_refused_where_it_stands() {
        for (text, code, key) in [
            ("{id: a, length: 80 m, width: 4 m}", "missing-key", "channels[0]"),
            ("{id: a, length: 80 m, width: 4 m, sections: x.csv, bed: 0 m}", "conflict", "channels[0]"),
            ("{id: a, length: 80 m, sections: x.csv, slope: 0.1}", "conflict", "channels[0].slope"),
            ("{id: a, length: 80 m, width: 4 m, bed: 0 m, joins: {side: all}}", "range", "channels[0].joins.side"),
            (
                "{id: a, length: 80 m, width: 4 m, bed: 0 m, joins: {side: west, from: 3}}",
                "missing-key",
                "channels[0].joins",
            ),
            (
                "{id: a, length: 80 m, width: 4 m, bed: 0 m, joins: {side: west}, downstream: {type: free}}",
                "conflict",
                "channels[0].downstream",
            ),
            (
                "{id: a, length: 80 m, width: 4 m, bed: 0 m, upstream: {stage: 3 m, level: 2 m}}",
                "conflict",
                "channels[0].upstream.level",
            ),
            (
                "{id: a, length: 80 m, width: 4 m, bed: 0 m, upstream: {stage: 3 m, still: 2 m}}",
                "conflict",
                "channels[0].upstream.still",
            ),
            (
                "{id: a, length: 80 m, width: 4 m, bed: 0 m, upstream: {type: open}}",
                "range",
                "channels[0].upstream.type",
            ),
            (
                "{id: a, length: 80 m, width: 4 m, bed: 0 m, water: [{from: 3 m}]}",
                "missing-key",
                "channels[0].water[0]",
            ),
            (
                "{id: a, length: 80 m, width: 4 m, bed: 0 m}\nnumerics: {formulation: variational}",
                "method-combination",
                "channels",
            ),
        ] {
            let found = problem(text);
            assert_eq!((found.code, found.key.as_str()), (code, key), "{text}: {found}");
        }
    }
}
