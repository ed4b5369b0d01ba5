//! Where a channel joins the terrain: the faces of its opening, and whether the channel fits them.

use crate::bed::BedParticles;
use crate::boundary::{Channel, ChannelEnd, EdgeFace, edge_faces};
use crate::error::{Problem, ProblemKind, input_error};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::prepare::findings::Findings;
use crate::prepare::forcing::plausible::Placed;
use crate::scenario::{Joint, Scenario, Side, Sourced};

/// A step of the bed from the channel to the terrain of more than this share of the spacing is worth a warning.
const STEP: f64 = 0.25;

/// The outermost edge faces of a side between the ends of an opening; none where a building stands.
pub fn opening(joint: Joint, ground: &BedParticles) -> Vec<EdgeFace> {
    let lattice = &ground.lattice;
    let outwards = match joint.side {
        Side::West => Vec2::new(-1.0, 0.0),
        Side::East => Vec2::new(1.0, 0.0),
        Side::South => Vec2::new(0.0, -1.0),
        Side::North | Side::All => Vec2::new(0.0, 1.0),
    };
    let along = |place: Vec2| if outwards.x.abs() > 0.5 { place.y } else { place.x };
    let is_inside = |place: Vec2| {
        let at = along(lattice.to_map(place));
        joint.span.is_none_or(|(from, to)| (from..=to).contains(&at))
    };
    let faces = edge_faces(lattice, &ground.elevation).into_iter().filter(|face| {
        (face.middle - lattice.centre(face.cell)).dot(outwards) > 0.25 * lattice.spacing && is_inside(face.middle)
    });
    let mut found: Vec<EdgeFace> = Vec::new();
    for face in faces {
        let same_line = |other: &EdgeFace| (along(other.middle) - along(face.middle)).abs() < 0.5 * lattice.spacing;
        match found.iter_mut().find(|other| same_line(other)) {
            Some(other) if face.middle.dot(outwards) > other.middle.dot(outwards) => *other = face,
            Some(_) => {}
            None => found.push(face),
        }
    }
    // Not before: the ground behind a building is no edge of the side.
    found.retain(|face| !ground.is_sealed(face.middle));
    found
}

/// Refuses an opening that is none, or that the channel does not fit; warns of a step of the bed.
pub fn check_joint(
    joint: &Sourced<Joint>,
    faces: &[EdgeFace],
    (channel, taken): (&Channel, &[Vec2]),
    bed: &BedParticles,
    findings: &mut Findings,
) {
    let lattice = &bed.lattice;
    let Some(first) = faces.first() else {
        let (low, high) = (lattice.to_map(Vec2::ZERO), lattice.to_map(lattice.size()));
        let problem =
            input_error("opens-nothing", "the opening of this channel holds no edge of the terrain".to_owned())
                .with_cause(format!(
                    "the terrain reaches from {}, {} to {}, {}; nothing comes in through a building",
                    low.x, low.y, high.x, high.y
                ))
                .with_remedy(
                    "give `from` and `to` along the side in the coordinates of the terrain, at least a cell apart",
                );
        findings.add(joint, problem);
        return;
    };
    let at = lattice.to_map(first.middle);
    if faces.iter().any(|face| taken.iter().any(|other| (*other - face.middle).norm() < 0.5 * lattice.spacing)) {
        let problem = input_error("channels-overlap", "another channel joins the terrain here already".to_owned());
        findings.add(joint, problem.with_remedy("give each channel its own part of the edge").with_at(at));
    }
    let widths = channel.face_widths.last().map_or(0.0, |widths| widths.iter().sum());
    let open = faces.len() as f64 * lattice.spacing;
    // A width that is a whole number of cells misses it by rounding alone.
    let slack = (1.0 + 1e-9) * lattice.spacing;
    if widths > open + slack || widths < open - slack {
        let is = if widths > open { "wider" } else { "narrower" };
        let message = format!("the channel is {widths:.3} m wide at its end, {is} than its opening of {open:.3} m");
        let problem = input_error("channel-width", message)
            .with_cause(format!(
                "the opening is {} cells of {} m along the edge, those behind buildings left out",
                faces.len(),
                lattice.spacing
            ))
            .with_remedy("let `from` and `to` be as far apart as the channel is wide at its banks, within one cell")
            .with_at(at);
        findings.add(joint, problem);
    }
    let lowest = faces.iter().map(|face| bed.elevation[face.cell]).fold(f64::INFINITY, f64::min);
    let end = channel.sections.last().map_or(lowest, |section| section.strips[0].bed);
    let step = end - lowest;
    if step.abs() > STEP * lattice.spacing {
        let is = if step > 0.0 { "above" } else { "below" };
        let message = format!("the bed of the channel ends {:.2} m {is} the lowest ground of its opening", step.abs());
        let problem = Problem::warning(ProblemKind::Input, "channel-step", "", message)
            .with_cause("the water falls over this step, or stands before it")
            .with_remedy(format!("let the channel end at about {lowest:.2} m, if there is no step"))
            .with_at(at);
        findings.add(joint, problem);
    }
}

/// Refuses boundaries with a condition at whose faces channels join, all of them: nothing would pass there.
pub fn check_boundaries(
    placed: &[Placed],
    channels: &[Channel],
    scenario: &Scenario,
    lattice: &Lattice,
    findings: &mut Findings,
) {
    let ends = channels.iter().filter_map(|channel| match &channel.near {
        ChannelEnd::Joined(faces) => Some(faces),
        _ => None,
    });
    let taken: Vec<Vec2> = ends.flatten().map(|face| face.middle).collect();
    let is_taken = |face: &EdgeFace| taken.iter().any(|other| (*other - face.middle).norm() < 0.5 * lattice.spacing);
    for boundary in placed.iter().filter(|boundary| boundary.faces.iter().all(is_taken)) {
        let Some(first) = boundary.faces.first() else { continue };
        let message = "channels join the terrain at all faces of this boundary: nothing passes it".to_owned();
        let problem = input_error("overlapping-boundaries", message)
            .with_remedy("take the boundary out, or let each part of the edge have one condition")
            .with_at(lattice.to_map(first.middle));
        findings.add(&scenario.boundaries[boundary.index], problem);
    }
}
