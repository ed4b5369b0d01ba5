//! Channels of one dimension: their tables and conditions, and where they join the terrain.

mod ends;
mod joint;
mod places;
mod section;
mod table;
mod water;

use crate::bed::BedParticles;
use crate::boundary::{Channel, ChannelEnd, ChannelSection, Condition, Strip};
use crate::error::{Problem, ProblemKind};
use crate::geodata::Crs;
use crate::math::Vec2;
use crate::output::ChannelProfile;
use crate::prepare::findings::Findings;
use crate::prepare::forcing;
use crate::scenario::Scenario;
use crate::scenario::{Channel as Described, ChannelShape};
pub use joint::check_boundaries;
use section::{Row, Table, rows_at, strips};

/// A channel of fewer particles is no channel.
const LEAST_PARTICLES: f64 = 3.0;

/// A channel whose files could be read.
#[derive(Debug)]
pub struct Opened {
    sections: Vec<Table>,
    ends: [Option<Condition>; 2],
    axis: Option<Vec<Vec2>>,
}

/// Opens every table, series and line of the channels; none for a channel with a fault.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Vec<Option<Opened>> {
    let mut names: Vec<&str> = Vec::new();
    let opened = scenario.channels.iter().map(|channel| {
        if names.contains(&channel.id.value.as_str()) {
            let message = format!("there is more than one channel `{}`", channel.id.value);
            let problem = Problem::error(ProblemKind::Scenario, "duplicate-channel", "", message);
            findings.add(&channel.id, problem.with_remedy("give each channel its own id"));
        }
        names.push(&channel.id.value);
        let is_rough = channel.manning.map_or(!scenario.roughness.is_none(), |n| n > 0.0);
        let ends = [&channel.upstream, &channel.downstream].map(|end| match end {
            None => Some(None),
            Some(condition) => forcing::condition(condition, is_rough, scenario, findings).map(Some),
        });
        let length = channel.length.value;
        let sections = match &channel.shape {
            ChannelShape::Rectangle { width, bed, slope } => Some(vec![
                Table { distance: 0.0, rows: vec![Row { elevation: bed + slope * length, width: *width }] },
                Table { distance: length, rows: vec![Row { elevation: *bed, width: *width }] },
            ]),
            ChannelShape::Sections(file) => table::sections(file, length, scenario.resolution.value, findings),
        };
        let axis = places::axis(channel, crs, findings);
        let [far, near] = ends;
        Some(Opened { sections: sections?, ends: [far?, near?], axis })
    });
    opened.collect()
}

/// Puts the channels on the lattice and checks where they join it.
pub fn on_lattice(
    opened: Vec<Option<Opened>>,
    scenario: &Scenario,
    ground: &BedParticles,
    findings: &mut Findings,
) -> (Vec<Channel>, Vec<ChannelProfile>) {
    let lattice = &ground.lattice;
    let (mut channels, mut profiles) = (Vec::new(), Vec::new());
    let (mut taken, mut names): (Vec<Vec2>, Vec<String>) = (Vec::new(), Vec::new());
    let mut particles = 0.0;
    for (described, opened) in scenario.channels.iter().zip(opened) {
        let Some(opened) = opened else { continue };
        let Some(manning) = roughness(described, scenario, lattice.spacing, findings) else { continue };
        let strips =
            1 + opened.sections[0].rows.len().saturating_sub(1) * section::pieces(opened.sections[0].rows.len());
        particles += (described.length.value / lattice.spacing).round() * strips as f64;
        if particles > scenario.limits.particles {
            let message = format!(
                "the channels take {particles:.0} particles as far as this one ({strips} strips of a section, every {} m); the limit is {:.0}",
                lattice.spacing, scenario.limits.particles
            );
            let problem = Problem::error(ProblemKind::Limit, "particle-limit", "", message);
            let remedy = "correct `length` or its unit, take a coarser `resolution`, or raise `limits.particles`";
            findings.add(&described.length, problem.with_remedy(remedy));
            break;
        }
        let (mut channel, mut profile) = build(described, &opened, manning, lattice.spacing);
        profile.gauges = places::gauges(described, &mut names, findings);
        water::check_water(described, &profile, findings);
        ends::check_ends(described, &opened, &channel, scenario, findings);
        if let Some(joint) = &described.joins {
            let faces = joint::opening(joint.value, ground);
            joint::check_joint(joint, &faces, (&channel, &taken), ground, findings);
            if let (Some(line), Some(axis)) = (&described.line, &opened.axis) {
                let middles: Vec<Vec2> = faces.iter().map(|face| lattice.to_map(face.middle)).collect();
                places::check_axis((line, axis), &middles, (described.length.value, lattice.spacing), findings);
            }
            taken.extend(faces.iter().map(|face| face.middle));
            if let Some(widths) = channel.face_widths.last_mut() {
                let factor = faces.len() as f64 * lattice.spacing / widths.iter().sum::<f64>();
                widths.iter_mut().for_each(|width| *width *= factor);
            }
            channel.near = ChannelEnd::Joined(faces);
        }
        channels.push(channel);
        profiles.push(profile);
    }
    (channels, profiles)
}

/// Manning's n of a channel; refuses one without roughness, and one shorter than some particles of this spacing (m).
fn roughness(described: &Described, scenario: &Scenario, spacing: f64, findings: &mut Findings) -> Option<f64> {
    let factor = scenario.roughness.factor;
    let Some(manning) = described.manning.map(|n| factor * n).or(scenario.roughness.elsewhere()) else {
        let message = format!("the channel `{}` has no roughness", described.id.value);
        let problem = Problem::error(ProblemKind::Scenario, "no-roughness", "", message);
        findings.add(&described.id, problem.with_remedy("give it the key `manning`"));
        return None;
    };
    if described.length.value < LEAST_PARTICLES * spacing {
        let message = format!("a channel of {} m is shorter than {LEAST_PARTICLES} particles", described.length.value);
        let problem = Problem::error(ProblemKind::Scenario, "channel-short", "", message);
        findings.add(&described.length, problem.with_remedy("make it longer, or leave it to the terrain"));
        return None;
    }
    Some(manning)
}

/// The particles of a channel.
fn build(described: &Described, opened: &Opened, manning: f64, spacing: f64) -> (Channel, ChannelProfile) {
    let length = described.length.value;
    let count = (length / spacing).round();
    // The near end stands fast; the far end may miss its place by half a spacing.
    let distance = |faces: f64| length - (count - faces) * spacing;
    let faces: Vec<Vec<Strip>> =
        (0..=count as usize).map(|f| strips(&rows_at(&opened.sections, distance(f as f64)))).collect();
    let places: Vec<f64> = (0..count as usize).map(|i| distance(i as f64 + 0.5)).collect();
    let section = |(i, place): (usize, &f64)| {
        let rows = rows_at(&opened.sections, *place);
        let between = |(k, strip): (usize, Strip)| {
            // The mean over the particle, so that its volume is right where the width changes.
            Strip { width: 0.5 * (faces[i][k].width + faces[i + 1][k].width), ..strip }
        };
        let strips: Vec<Strip> = strips(&rows).into_iter().enumerate().map(between).collect();
        let lowest = rows[0].elevation;
        let water = described.water.iter().map(|water| &water.value).rfind(|water| water::reaches(water, *place));
        let level = water.map_or(lowest, |water| water.level.unwrap_or(lowest + water.depth.unwrap_or(0.0)));
        ChannelSection { strips, perimeter: section::perimeter(&rows, described.walls), manning, level }
    };
    let sections: Vec<ChannelSection> = places.iter().enumerate().map(section).collect();
    let end = |condition: &Option<Condition>| condition.clone().map_or(ChannelEnd::Wall, ChannelEnd::Open);
    let profile = ChannelProfile {
        id: described.id.value.clone(),
        bed: sections.iter().map(|section| section.strips[0].bed).collect(),
        banks: places.iter().map(|place| section::bank(&rows_at(&opened.sections, *place))).collect(),
        places: opened
            .axis
            .as_ref()
            .map(|line| places.iter().map(|place| places::along(line, place / length)).collect()),
        distance: places,
        gauges: Vec::new(),
    };
    let channel = Channel {
        spacing,
        sections,
        face_widths: faces.iter().map(|strips| strips.iter().map(|strip| strip.width).collect()).collect(),
        far: end(&opened.ends[0]),
        near: end(&opened.ends[1]),
    };
    (channel, profile)
}
