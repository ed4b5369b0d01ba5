//! The water of a channel at the start.

use crate::error::{Problem, ProblemKind, input_error};
use crate::math::readable;
use crate::output::ChannelProfile;
use crate::prepare::findings::Findings;
use crate::scenario::{Channel as Described, ChannelWater};

/// Share of a length that is its rounding.
const SAME: f64 = 1e-9;

/// Whether water at the start lies at a distance from the far end (m).
pub fn reaches(water: &ChannelWater, place: f64) -> bool {
    place >= water.from && water.to.is_none_or(|to| place <= to)
}

/// Refuses water at the start that wets no particle, and is not there to dry some; warns of water beyond the channel.
pub fn check_water(described: &Described, profile: &ChannelProfile, findings: &mut Findings) {
    for source in &described.water {
        let water = &source.value;
        let particles = || profile.distance.iter().zip(&profile.bed).filter(|(place, _)| reaches(water, **place));
        let lowest = particles().map(|(_, bed)| *bed).fold(f64::INFINITY, f64::min);
        if particles().next().is_none() {
            let to = water.to.unwrap_or(described.length.value);
            let (from, to) = (readable(water.from), readable(to));
            let message = format!("between {from} m and {to} m from its far end the channel has no particle");
            let problem = input_error("water-outside", message)
                .with_cause(format!(
                    "its particles lie from {} m to {} m",
                    readable(profile.distance[0]),
                    readable(profile.distance[profile.distance.len() - 1])
                ))
                .with_remedy("let `from` and `to` lie within `length`, `to` beyond `from` by the resolution at least");
            findings.add(source, problem);
        } else if let Some(level) = water.level.filter(|level| *level <= lowest) {
            let message = format!(
                "the level of {level} m is not above the lowest bed of the channel there, {} m",
                readable(lowest)
            );
            let problem =
                input_error("level-below-bed", message).with_cause("the part of the channel would be dry").with_remedy(
                    "correct the level, its unit or its datum, or give a `depth`; `depth: 0 m` leaves a part dry",
                );
            findings.add(source, problem);
        }
        let length = described.length.value;
        if let Some(to) = water.to.filter(|to| *to > length * (1.0 + SAME)) {
            let message = format!("the water reaches to {} m, the channel to {length} m", readable(to));
            let problem = Problem::warning(ProblemKind::Input, "water-beyond", "", message)
                .with_cause("what would lie beyond the channel is left out")
                .with_remedy("correct `to` or `length`, or leave `to` out for all the rest of the channel");
            findings.add(source, problem);
        }
    }
}
