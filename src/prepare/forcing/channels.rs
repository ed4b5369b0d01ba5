//! Channels of one dimension: their tables and conditions, and where they join the terrain.

use crate::bed::BedParticles;
use crate::boundary::{Channel, ChannelEnd, ChannelSection, Condition, Strip, edge_faces};
use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::{Vec2, readable};
use crate::output::ChannelProfile;
use crate::prepare::findings::Findings;
use crate::prepare::forcing;
use crate::prepare::forcing::channel_places::{along, axis, check_axis, gauges};
use crate::prepare::forcing::levels::{self, Inlet};
use crate::prepare::forcing::plausible::torrent;
use crate::prepare::forcing::waves;
use crate::prepare::tables::dates::Origin;
use crate::prepare::tables::series;
use crate::scenario::units::LENGTH;
use crate::scenario::{BoundaryCondition, ColumnUnit, Scenario, Side, Sourced};
use crate::scenario::{Channel as Described, ChannelShape, ChannelWalls, ChannelWater, Joint};

/// A channel of fewer particles is no channel.
const LEAST_PARTICLES: f64 = 3.0;
/// Share of a length that is its rounding.
const SAME: f64 = 1e-9;
/// Sections that reach beyond their channel by more than so many particles are worth a warning.
const BEYOND: f64 = 1.0;
/// Strips between the lowest and the highest row of a table of sections, at least.
const STRIPS: usize = 16;
/// A step of the bed from the channel to the terrain of more than this share of the spacing is worth a warning.
const STEP: f64 = 0.25;

/// A cross-section of a table: its distance from the far end (m), and elevation (m) and width (m) of its rows.
#[derive(Clone, Debug, PartialEq)]
struct Table {
    distance: f64,
    rows: Vec<(f64, f64)>,
}

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
                Table { distance: 0.0, rows: vec![(bed + slope * length, *width)] },
                Table { distance: length, rows: vec![(*bed, *width)] },
            ]),
            ChannelShape::Sections(file) => sections(file, (length, scenario.resolution.value), findings),
        };
        let axis = axis(channel, crs, findings);
        let [far, near] = ends;
        Some(Opened { sections: sections?, ends: [far?, near?], axis })
    });
    opened.collect()
}

/// The sections of a file, checked against the length (m) of the channel and the spacing (m) of its particles.
fn sections(
    file: &Sourced<std::path::PathBuf>,
    (length, spacing): (f64, f64),
    findings: &mut Findings,
) -> Option<Vec<Table>> {
    let columns = ["distance", "elevation", "width"].map(|_| ColumnUnit { name: None, unit: None });
    let example = "distance_m,elevation_m,width_m";
    let rows = findings.take_all(file, series::rows_of(&file.value, &columns, [&LENGTH; 3], (example, Origin::Own)))?;
    let name = file.value.display();
    let mut tables: Vec<Table> = Vec::new();
    let mut faults: Vec<Problem> = series::implausible(&rows, 1, &name.to_string()).into_iter().collect();
    for row in &rows {
        let [distance, elevation, width] = row.numbers;
        let at = format!("line {} of {name}", row.line);
        match tables.last_mut() {
            Some(last) if (distance - last.distance).abs() <= 1e-9 => {
                let below = last.rows[last.rows.len() - 1];
                if elevation < below.0 || width < below.1 {
                    faults.push(
                        input_error("section-not-rising", format!("{at} is lower or narrower than the row before"))
                            .with_cause(
                                "the rows of a section go from its bed upwards, and a channel does not close above",
                            )
                            .with_remedy(
                                "sort the rows of each section by elevation; give an overhang the width below it",
                            ),
                    );
                }
                last.rows.push((elevation, width));
            }
            Some(last) if distance < last.distance => faults.push(
                input_error("not-rising", format!("{at} goes back to {distance} m"))
                    .with_remedy("sort the sections by their distance from the far end"),
            ),
            _ => tables.push(Table { distance, rows: vec![(elevation, width)] }),
        }
        if width < 0.0 {
            let problem = input_error("negative-value", format!("{at} has a width below 0"));
            faults.push(problem.with_remedy("give widths of 0 or more"));
        }
    }
    if let Some(odd) = tables.iter().find(|table| table.rows.len() != tables[0].rows.len()) {
        let message = format!(
            "the section at {} m of {name} has {} rows, the first one {}",
            odd.distance,
            odd.rows.len(),
            tables[0].rows.len()
        );
        faults.push(
            input_error("section-rows", message)
                .with_cause("row for row, a section goes on as the next one")
                .with_remedy("give every section as many rows"),
        );
    }
    if let Some(closed) = tables.iter().find(|table| table.rows[table.rows.len() - 1].1 <= 0.0) {
        let message = format!("the section at {} m of {name} has no width", closed.distance);
        faults.push(input_error("section-closed", message).with_remedy("give its last row a width above 0"));
    }
    let (first, last) = (tables[0].distance, tables[tables.len() - 1].distance);
    let slack = 1e-6 * length;
    if first > slack || last < length - slack {
        let message =
            format!("the sections of {name} reach from {first} m to {last} m, the channel from 0 to {length} m");
        let remedy = "add a section at either end, or correct `length`; distances count from the far end";
        faults.push(input_error("sections-short", message).with_remedy(remedy));
    }
    let is_sound = faults.is_empty();
    if is_sound && (first < -BEYOND * spacing || last > length + BEYOND * spacing) {
        let message =
            format!("the sections of {name} reach from {first} m to {last} m, beyond the channel from 0 to {length} m");
        faults.push(
            Problem::warning(ProblemKind::Input, "sections-beyond", "", message)
                .with_cause("what lies before 0 or beyond `length` is left out")
                .with_remedy(
                    "correct `length` or the distances, which count from the far end; or take those sections out",
                ),
        );
    }
    findings.add_all(file, faults);
    is_sound.then_some(tables)
}

/// Elevation and width of each row at a distance from the far end (m).
fn rows_at(sections: &[Table], distance: f64) -> Vec<(f64, f64)> {
    let upper = sections.partition_point(|table| table.distance <= distance).clamp(1, sections.len() - 1);
    let (low, high) = (&sections[upper - 1], &sections[upper]);
    let share = ((distance - low.distance) / (high.distance - low.distance)).clamp(0.0, 1.0);
    let between = |(a, b): (&(f64, f64), &(f64, f64))| (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1));
    low.rows.iter().zip(&high.rows).map(between).collect()
}

/// Level of the last row of a section (m); none where its only row is the bed.
fn bank(rows: &[(f64, f64)]) -> Option<f64> {
    rows[1..].last().map(|row| row.0)
}

/// Strips between each two of so many rows of a section.
fn pieces(rows: usize) -> usize {
    if rows > 1 { STRIPS.div_ceil(rows - 1) } else { 0 }
}

/// The strips of a section: one at its bed, and between each two rows equal pieces of what the width grows, at the heights at which
/// the area is right at every row.
fn strips(rows: &[(f64, f64)]) -> Vec<Strip> {
    let pieces = pieces(rows.len());
    let mut strips = vec![Strip { width: rows[0].1, bed: rows[0].0 }];
    for pair in rows.windows(2) {
        let ((low, narrow), (high, wide)) = (pair[0], pair[1]);
        let share = |k: usize| (k as f64 + 0.5) / pieces as f64;
        let width = (wide - narrow) / pieces as f64;
        strips.extend((0..pieces).map(|k| Strip { width, bed: low + share(k) * (high - low) }));
    }
    strips
}

/// Depth and wetted perimeter at each row, and a metre above the last one.
fn perimeter(rows: &[(f64, f64)], walls: ChannelWalls) -> Vec<(f64, f64)> {
    let mut wetted = rows[0].1;
    let mut found = vec![(0.0, wetted)];
    for pair in rows.windows(2) {
        let (rise, growth) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        wetted += match walls {
            ChannelWalls::Rough => 2.0 * rise.hypot(0.5 * growth),
            ChannelWalls::Smooth => growth,
        };
        found.push((pair[1].0 - rows[0].0, wetted));
    }
    let (top, last) = found[found.len() - 1];
    let above = match walls {
        ChannelWalls::Rough => 2.0,
        ChannelWalls::Smooth => 0.0,
    };
    found.push((top + 1.0, last + above));
    found
}

/// Puts the channels on the lattice and checks where they join it.
pub fn on_lattice(
    opened: Vec<Option<Opened>>,
    scenario: &Scenario,
    ground: &BedParticles,
    findings: &mut Findings,
) -> (Vec<Channel>, Vec<ChannelProfile>) {
    let (lattice, bed) = (&ground.lattice, &ground.elevation[..]);
    let (mut channels, mut profiles) = (Vec::new(), Vec::new());
    let (mut taken, mut names): (Vec<Vec2>, Vec<String>) = (Vec::new(), Vec::new());
    let mut particles = 0.0;
    for (described, opened) in scenario.channels.iter().zip(opened) {
        let Some(opened) = opened else { continue };
        let Some(manning) = described.manning.or(scenario.roughness.manning) else {
            let message = format!("the channel `{}` has no roughness", described.id.value);
            let problem = Problem::error(ProblemKind::Scenario, "no-roughness", "", message);
            findings.add(&described.id, problem.with_remedy("give it the key `manning`"));
            continue;
        };
        if described.length.value < LEAST_PARTICLES * lattice.spacing {
            let message =
                format!("a channel of {} m is shorter than {LEAST_PARTICLES} particles", described.length.value);
            let problem = Problem::error(ProblemKind::Scenario, "channel-short", "", message);
            findings.add(&described.length, problem.with_remedy("make it longer, or leave it to the terrain"));
            continue;
        }
        let strips = 1 + opened.sections[0].rows.len().saturating_sub(1) * pieces(opened.sections[0].rows.len());
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
        profile.gauges = gauges(described, &mut names, findings);
        check_water(described, &profile, findings);
        check_ends(described, &opened, &channel, scenario, findings);
        if let Some(joint) = &described.joins {
            let faces = opening(joint.value, ground);
            check_joint(joint, &faces, (&channel, &taken), (lattice, bed), findings);
            if let (Some(line), Some(axis)) = (&described.line, &opened.axis) {
                let middles: Vec<Vec2> = faces.iter().map(|face| lattice.to_map(face.1)).collect();
                check_axis((line, axis), &middles, (described.length.value, lattice.spacing), findings);
            }
            taken.extend(faces.iter().map(|face| face.1));
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

/// Whether the levels at the ends that join nothing fit the bed there.
fn check_ends(described: &Described, opened: &Opened, channel: &Channel, scenario: &Scenario, findings: &mut Findings) {
    let (length, spacing) = (described.length.value, channel.spacing);
    let places = [[0.0, 0.5 * spacing], [length, length - 0.5 * spacing]];
    let names = ["the far end of this channel", "the near end of this channel"];
    for (end, condition) in [&described.upstream, &described.downstream].into_iter().enumerate() {
        // The water of the solver comes in over the bed of its last particle or over that of the end, by which one is higher.
        let rows = places[end].map(|place| rows_at(&opened.sections, place));
        let rows = if rows[0][0].0 >= rows[1][0].0 { &rows[0] } else { &rows[1] };
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
            ) => levels::check_inflow(timed, (discharge, levels), inlet).map(|problem| (timed, problem)),
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

/// Whether water at the start lies at a distance from the far end (m).
fn reaches(water: &ChannelWater, place: f64) -> bool {
    place >= water.from && water.to.is_none_or(|to| place <= to)
}

/// Refuses water at the start that wets no particle, and is not there to dry some; warns of water beyond the channel.
fn check_water(described: &Described, profile: &ChannelProfile, findings: &mut Findings) {
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
        let lowest = rows[0].0;
        let water = described.water.iter().map(|water| &water.value).rfind(|water| reaches(water, *place));
        let level = water.map_or(lowest, |water| water.level.unwrap_or(lowest + water.depth.unwrap_or(0.0)));
        ChannelSection { strips, perimeter: perimeter(&rows, described.walls), manning, level }
    };
    let sections: Vec<ChannelSection> = places.iter().enumerate().map(section).collect();
    let end = |condition: &Option<Condition>| condition.clone().map_or(ChannelEnd::Wall, ChannelEnd::Open);
    let profile = ChannelProfile {
        id: described.id.value.clone(),
        bed: sections.iter().map(|section| section.strips[0].bed).collect(),
        banks: places.iter().map(|place| bank(&rows_at(&opened.sections, *place))).collect(),
        places: opened.axis.as_ref().map(|line| places.iter().map(|place| along(line, place / length)).collect()),
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

/// The outermost edge faces of a side between the ends of an opening, each with its cell; none where a building stands.
fn opening(joint: Joint, ground: &BedParticles) -> Vec<(usize, Vec2)> {
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
    let faces = edge_faces(lattice, &ground.elevation).into_iter().filter(|(cell, middle)| {
        (*middle - lattice.centre(*cell)).dot(outwards) > 0.25 * lattice.spacing && is_inside(*middle)
    });
    let mut found: Vec<(usize, Vec2)> = Vec::new();
    for face in faces {
        let same_line = |other: &(usize, Vec2)| (along(other.1) - along(face.1)).abs() < 0.5 * lattice.spacing;
        match found.iter_mut().find(|other| same_line(other)) {
            Some(other) if face.1.dot(outwards) > other.1.dot(outwards) => *other = face,
            Some(_) => {}
            None => found.push(face),
        }
    }
    // Not before: the ground behind a building is no edge of the side.
    found.retain(|(_, middle)| !ground.is_sealed(*middle));
    found
}

/// Refuses an opening that is none, or that the channel does not fit; warns of a step of the bed.
fn check_joint(
    joint: &Sourced<Joint>,
    faces: &[(usize, Vec2)],
    (channel, taken): (&Channel, &[Vec2]),
    (lattice, bed): (&Lattice, &[f64]),
    findings: &mut Findings,
) {
    let Some(&(_, first)) = faces.first() else {
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
    let at = lattice.to_map(first);
    if faces.iter().any(|face| taken.iter().any(|other| (*other - face.1).norm() < 0.5 * lattice.spacing)) {
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
    let lowest = faces.iter().map(|face| bed[face.0]).fold(f64::INFINITY, f64::min);
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

#[cfg(test)]
mod tests;
