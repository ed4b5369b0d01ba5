//! Where a channel of one dimension lies on the map, and its gauges.

use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::Crs;
use crate::math::{Vec2, readable};
use crate::output::ChannelGauge;
use crate::prepare::findings::Findings;
use crate::prepare::places::features;
use crate::scenario::Channel;
use crate::scenario::{Sourced, VectorSource};

/// A line whose length differs from that of its channel by more than this share is worth a warning.
const STRETCH: f64 = 0.05;
/// One that is so many times as long, or the channel as the line, is no axis of it.
const TIMES: f64 = 10.0;
/// No coordinate of a map is greater (m).
const MAP: f64 = 1e9;

/// The axis of a channel from its far to its near end (map coordinates): the line of its file that has the name of the channel, or the
/// only one. It says where results are shown and nothing of the flow.
pub fn axis(channel: &Channel, crs: Option<&Crs>, findings: &mut Findings) -> Option<Vec<Vec2>> {
    let source = channel.line.as_ref()?;
    let features = features(source, crs, findings)?;
    let is_named = |feature: &&crate::vector::Feature| {
        let name = feature.attribute("id").or_else(|| feature.attribute("name"));
        name.is_some_and(|name| name.to_string() == channel.id.value)
    };
    let all = || features.iter().flat_map(|feature| &feature.lines);
    let named: Vec<_> = features.iter().filter(is_named).flat_map(|feature| &feature.lines).collect();
    let line = match (&named[..], all().count()) {
        ([line], _) => *line,
        ([], 1) => all().next()?,
        _ => {
            findings.add(source, not_one_line(source, &channel.id.value, named.len(), all().count()));
            return None;
        }
    };
    let mut places: Vec<Vec2> = line.0.iter().map(|c| Vec2::new(c.x, c.y)).collect();
    places.dedup();
    let (drawn, length) = (length_of(&places), channel.length.value);
    let is_on_map = places.iter().all(|place| place.x.abs().max(place.y.abs()) < MAP);
    if !is_on_map || drawn * TIMES < length || drawn > TIMES * length {
        let message = if is_on_map {
            format!("the line of this channel is {} m long, the channel {length} m", readable(drawn))
        } else {
            "the line of this channel has coordinates that are on no map".to_owned()
        };
        let problem = input_error("line-length", message)
            .with_remedy("draw the line from the far to the near end of the channel, and check its CRS and `length`");
        findings.add(source, problem);
        return None;
    }
    if (drawn / length - 1.0).abs() > STRETCH {
        let message = format!("the line of this channel is {drawn:.1} m long, the channel {length} m");
        let problem = Problem::warning(ProblemKind::Input, "line-length", "", message)
            .with_cause("the stations are shown along the line in proportion; the flow goes by `length` alone")
            .with_remedy("correct `length`, or draw the line from the far to the near end of the channel");
        findings.add(source, places.first().map_or(problem.clone(), |first| problem.with_at(*first)));
    }
    (places.len() > 1).then_some(places)
}

fn not_one_line(source: &Sourced<VectorSource>, id: &str, named: usize, all: usize) -> Problem {
    let path = source.value.path.display();
    let message = match (named, all) {
        (_, 0) => format!("{path} holds no line"),
        (0, _) => format!("{path} holds {all} lines, none of which has the name `{id}`"),
        _ => format!("{path} holds {named} lines with the name `{id}`"),
    };
    input_error("no-lines", message)
        .with_remedy("draw one line along the channel, or give each line the `id` of its channel as an attribute")
}

fn length_of(line: &[Vec2]) -> f64 {
    line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Refuses an axis (map coordinates) that runs from the opening of its channel away, or lies elsewhere; warns of one that ends beside it.
/// `faces` are the middles of the faces of the opening (map coordinates), `length` and `spacing` those of the channel (m).
pub fn check_axis(
    (source, axis): (&Sourced<VectorSource>, &[Vec2]),
    faces: &[Vec2],
    (length, spacing): (f64, f64),
    findings: &mut Findings,
) {
    let (Some(first), Some(last)) = (axis.first(), axis.last()) else { return };
    let distance = |place: Vec2| faces.iter().map(|face| (*face - place).norm()).fold(f64::INFINITY, f64::min);
    let [from_far, from_near] = [*first, *last].map(distance);
    // The bend of the last particles and a map of another scale do not matter.
    let near = spacing + STRETCH * length;
    if faces.is_empty() || from_near <= near {
        return;
    }
    let message = format!("the line of this channel ends {from_near:.1} m beside the opening that the channel joins");
    let problem = if from_far <= near {
        input_error("line-reversed", format!("{message}, and begins there"))
            .with_cause("results would be shown at the wrong end")
            .with_remedy("turn the line round: it goes from the far to the near end of the channel")
    } else if from_near > length {
        input_error("line-beside-opening", message)
            .with_cause("that is more than the length of the channel")
            .with_remedy("check the CRS and the coordinates of the line, and `joins`")
    } else {
        Problem::warning(ProblemKind::Input, "line-beside-opening", "", message)
            .with_cause("results are shown along the line, wherever the water flows")
            .with_remedy("let the line end at the opening")
    };
    findings.add(source, problem.with_at(*last));
}

/// The place at a share of the length of a line of two corners or more.
pub fn along(line: &[Vec2], share: f64) -> Vec2 {
    let mut left = share.clamp(0.0, 1.0) * length_of(line);
    for pair in line.windows(2) {
        let length = (pair[1] - pair[0]).norm();
        if left <= length {
            return pair[0] + (pair[1] - pair[0]) * (left / length);
        }
        left -= length;
    }
    line[line.len() - 1]
}

/// The gauges of a channel; `names` are those of the channels before, to which they are added.
pub fn gauges(channel: &Channel, names: &mut Vec<String>, findings: &mut Findings) -> Vec<ChannelGauge> {
    let length = channel.length.value;
    for gauge in &channel.gauges {
        if names.contains(&gauge.id.value) {
            let message = format!("there is more than one gauge `{}` in channels", gauge.id.value);
            let problem = Problem::error(ProblemKind::Scenario, "duplicate-gauge", "", message);
            findings.add(&gauge.id, problem.with_remedy("give each gauge its own id, through all channels"));
        }
        names.push(gauge.id.value.clone());
        if gauge.distance.value > length {
            let message = format!(
                "the gauge `{}` lies {} m from the far end of a channel of {length} m",
                gauge.id.value, gauge.distance.value
            );
            let problem = Problem::error(ProblemKind::Scenario, "gauge-outside", "", message);
            findings.add(&gauge.distance, problem.with_remedy("give a distance from the far end, within `length`"));
        }
    }
    let of_run = |gauge: &crate::scenario::ChannelGauge| ChannelGauge {
        id: gauge.id.value.clone(),
        distance: gauge.distance.value,
    };
    channel.gauges.iter().map(of_run).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_along_a_line_is_found_by_its_length() {
        let line = [Vec2::new(1.0, 1.0), Vec2::new(4.0, 1.0), Vec2::new(4.0, 2.0)];
        for (share, x, y) in [(-1.0, 1.0, 1.0), (0.0, 1.0, 1.0), (0.5, 3.0, 1.0), (0.875, 4.0, 1.5), (2.0, 4.0, 2.0)] {
            let place = along(&line, share);
            assert!((place - Vec2::new(x, y)).norm() < 1e-12, "{share}: {place:?}");
        }
    }
}
