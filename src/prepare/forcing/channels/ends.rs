//! Whether the conditions at the ends of a channel that join nothing fit the bed there.

use super::Opened;
use super::section::{rows_at, strips};
use crate::boundary::{Channel, Condition};
use crate::prepare::findings::Findings;
use crate::prepare::forcing::levels::{self, Inflow, Inlet};
use crate::prepare::forcing::plausible::torrent;
use crate::prepare::forcing::waves;
use crate::scenario::Channel as Described;
use crate::scenario::{BoundaryCondition, Scenario};

/// Whether the levels at the ends that join nothing fit the bed there.
pub fn check_ends(
    described: &Described,
    opened: &Opened,
    channel: &Channel,
    scenario: &Scenario,
    findings: &mut Findings,
) {
    let (length, spacing) = (described.length.value, channel.spacing);
    let places = [[0.0, 0.5 * spacing], [length, length - 0.5 * spacing]];
    let names = ["the far end of this channel", "the near end of this channel"];
    for (end, condition) in [&described.upstream, &described.downstream].into_iter().enumerate() {
        // The water of the solver comes in over the bed of its last particle or over that of the end, by which one is higher.
        let rows = places[end].map(|place| rows_at(&opened.sections, place));
        let rows = if rows[0][0].elevation >= rows[1][0].elevation { &rows[0] } else { &rows[1] };
        let strips = strips(rows);
        let inlet =
            Inlet { name: names[end], strips: &strips, gravity: scenario.numerics.gravity, end: scenario.end_time };
        if let (
            Some(BoundaryCondition::Discharge { discharge: timed, .. }),
            Some(Condition::Discharge { discharge, .. }),
        ) = (condition, &opened.ends[end])
            && let Some(problem) =
                torrent(names[end], discharge, strips.iter().map(|strip| strip.width).sum(), scenario)
        {
            let (key, place) = timed.source();
            findings.add_at(key, place.cloned(), problem);
        }
        let found = match (condition, &opened.ends[end]) {
            (
                Some(BoundaryCondition::Discharge { level: Some(timed), .. }),
                Some(Condition::Discharge { discharge, level: Some(levels) }),
            ) => {
                levels::check_inflow(timed, Inflow { discharge, level: levels }, inlet).map(|problem| (timed, problem))
            }
            (Some(BoundaryCondition::Stage(timed)), Some(Condition::Stage(levels)))
            | (Some(BoundaryCondition::Level(timed)), Some(Condition::Level(levels)))
            | (Some(BoundaryCondition::Wave { level: timed, .. }), Some(Condition::Wave { level: levels, .. })) => {
                levels::check_stage(timed, levels, inlet).map(|problem| (timed, problem))
            }
            _ => None,
        };
        if let (Some(BoundaryCondition::Wave { level: timed, .. }), Some(Condition::Wave { level, still })) =
            (condition, &opened.ends[end])
        {
            let section = if end == 0 { channel.sections.first() } else { channel.sections.last() };
            let lowest = inlet.lowest();
            let start = section.map(|section| section.level).filter(|level| *level > lowest);
            let (key, place) = timed.source();
            let inlet = waves::Inlet { lowest, start, end: scenario.end_time };
            if let Some(problem) = waves::check(level, still.as_ref(), inlet) {
                findings.add_at(key, place.cloned(), problem);
            }
        }
        if let Some((timed, problem)) = found {
            let (key, place) = timed.source();
            findings.add_at(key, place.cloned(), problem);
        }
    }
}
