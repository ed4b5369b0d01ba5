//! Boundaries, sources and rain that can be computed and are hardly meant so: each of them gets a warning; a wave over no still
//! water alone is refused.

use std::collections::BTreeSet;

use crate::bed::BedParticles;
use crate::boundary::{Condition, EdgeFace, Forcing, Rain, Rating, Series};
use crate::error::{Problem, input_warning};
use crate::math::{Vec2, readable, segments_cross};
use crate::prepare::findings::Findings;
use crate::prepare::forcing::waves;
use crate::scenario::Scenario;
use crate::seeding::StillWater;

/// Depth (m) of critical flow that no flood on Earth has had.
const TORRENT: f64 = 100.0;
/// Share of the depth by which two levels that are held side by side may differ: the water runs from one to the other at √(2 g Δ),
/// a Froude number of √(2 · 0.01) = 0.14.
const STEP: f64 = 0.01;
/// Height (m) of a weir above ground that is dry at the start: less is a sill or a bank, more is rather another unit or datum.
const HIGH_WEIR: f64 = 10.0;
/// So many cells before an edge tell whether the ground rises towards it: fewer are a sill.
const BEFORE_EDGE: usize = 10;

/// A boundary with a condition on the lattice.
#[derive(Debug)]
pub struct Placed {
    /// Its place in the list of the scenario.
    pub index: usize,
    /// The faces of the edge that it would open alone.
    pub faces: Vec<EdgeFace>,
}

/// Warns of boundaries and rain that are hardly meant so.
pub fn check(
    placed: &mut [Placed],
    forcing: &Forcing,
    scenario: &Scenario,
    (bed, still, walls): (&BedParticles, &StillWater, &[[Vec2; 2]]),
    findings: &mut Findings,
) {
    // The boundaries of the solver, in their order: each face belongs to one of them.
    debug_assert_eq!(placed.len(), forcing.boundaries.len());
    if placed.len() > 1 {
        for (index, boundary) in placed.iter_mut().enumerate() {
            let normal = |face: &EdgeFace| face.middle - bed.lattice.centre(face.cell);
            boundary.faces.retain(|face| forcing.boundary_at(face.middle, normal(face)) == Some(index));
        }
    }
    let open: Vec<(&Placed, &Condition)> =
        placed.iter().zip(&forcing.boundaries).map(|(one, boundary)| (one, &boundary.condition)).collect();
    for &(boundary, condition) in open.iter().filter(|(boundary, _)| !boundary.faces.is_empty()) {
        let problem = doubt(boundary, condition, scenario, bed, still);
        let first = boundary.faces.first().map(|face| bed.lattice.to_map(face.middle));
        let problem = problem.map(|problem| Problem { at: problem.at.or(first), ..problem });
        findings.add_all(&scenario.boundaries[boundary.index], problem);
    }
    check_junctions(&open, scenario, (bed, walls), findings);
    check_rain(forcing, scenario, bed, findings);
}

/// What is doubtful of a boundary that opens something.
fn doubt(
    boundary: &Placed,
    condition: &Condition,
    scenario: &Scenario,
    bed: &BedParticles,
    still: &StillWater,
) -> Option<Problem> {
    match condition {
        Condition::Discharge { discharge, .. } => {
            let width = boundary.faces.len() as f64 * bed.lattice.spacing;
            torrent("this boundary", discharge, width, scenario)
        }
        Condition::Rating(rating) => high_weir(rating, &boundary.faces, bed, still),
        Condition::Stage(level) | Condition::Level(level) => drowned(level, bed, still, scenario.end_time),
        Condition::Wave { level, still: given } => {
            let inlet = inlet_of_wave(&boundary.faces, (bed, still), scenario.end_time);
            let wave = inlet.and_then(|inlet| waves::check(level, given.as_ref(), inlet));
            wave.or_else(|| drowned(level, bed, still, scenario.end_time))
        }
        Condition::NormalDepth { slope } => rising_ground(*slope, &boundary.faces, bed),
        Condition::Free => None,
    }
}

/// Warns of two held levels that differ where their boundaries meet.
fn check_junctions(
    open: &[(&Placed, &Condition)],
    scenario: &Scenario,
    (bed, walls): (&BedParticles, &[[Vec2; 2]]),
    findings: &mut Findings,
) {
    for (index, (one, condition)) in open.iter().enumerate() {
        for (other, other_condition) in &open[..index] {
            let (Some(own), Some(levels)) = (held(condition), held(other_condition)) else { continue };
            if let Some(junction) = deepest_junction(&one.faces, &other.faces, bed, walls) {
                let other_key = &scenario.boundaries[other.index].key;
                let problem = step_of_level((own, levels), other_key, junction, scenario.end_time);
                let at = bed.lattice.to_map(junction.place);
                findings.add_all(&scenario.boundaries[one.index], problem.map(|problem| problem.with_at(at)));
            }
        }
    }
}

/// Warns of rain of which nothing runs off.
fn check_rain(forcing: &Forcing, scenario: &Scenario, bed: &BedParticles, findings: &mut Findings) {
    if let (Some(rain), Some(source)) = (&forcing.rain, &scenario.rain)
        && !runs_off(rain, bed, scenario.end_time)
    {
        let losses = source.value.initial_loss + source.value.constant_loss;
        let (message, cause) = if losses > 0.0 {
            (
                "nothing of the rain runs off before the run ends",
                "`losses` takes all of it, everywhere and at all times",
            )
        } else {
            ("no rain falls before the run ends", "its intensity is 0 everywhere and at all times")
        };
        let problem = input_warning("rain-without-water", message.to_owned()).with_cause(cause).with_remedy(
            "correct the rain, its losses and their units, or take `rain` out: it costs work on every cell",
        );
        findings.add(source, problem);
    }
}

/// The level that a condition holds.
fn held(condition: &Condition) -> Option<&Series> {
    match condition {
        Condition::Stage(level) | Condition::Level(level) => Some(level),
        Condition::Discharge { .. }
        | Condition::Wave { .. }
        | Condition::NormalDepth { .. }
        | Condition::Rating(_)
        | Condition::Free => None,
    }
}

/// The lowest ground along a boundary by which a wave comes in, and the level of the water over its lowest wet ground at the start.
fn inlet_of_wave(faces: &[EdgeFace], (bed, still): (&BedParticles, &StillWater), end: f64) -> Option<waves::Inlet> {
    let lowest_of =
        |cells: &mut dyn Iterator<Item = usize>| cells.min_by(|a, b| bed.elevation[*a].total_cmp(&bed.elevation[*b]));
    let lowest = bed.elevation[lowest_of(&mut faces.iter().map(|face| face.cell))?];
    let wet = lowest_of(&mut faces.iter().map(|face| face.cell).filter(|cell| still.depth[*cell] > 0.0));
    Some(waves::Inlet { lowest, start: wet.map(|cell| bed.elevation[cell] + still.depth[cell]), end })
}

/// Warns of a discharge so great for the width (m) over which it comes that critical flow would be deeper than any flood.
pub fn torrent(name: &str, discharge: &Series, width: f64, scenario: &Scenario) -> Option<Problem> {
    let Peak { time, value: peak } = peak_until(discharge, scenario.end_time)?;
    let critical = ((peak / width).powi(2) / scenario.numerics.gravity).cbrt();
    (critical > TORRENT).then(|| {
        let moment = if discharge.points().count() > 1 { format!(" at {} s", readable(time)) } else { String::new() };
        let message = format!(
            "{} m3/s{moment} come in over {} m of {name}: critical flow would be {critical:.0} m deep",
            readable(peak),
            readable(width)
        );
        input_warning("huge-discharge", message)
            .with_cause(format!("no flood has more than {TORRENT} m; another unit, perhaps, or too short a line"))
            .with_remedy("correct the discharge and its unit, or the place over which it comes in")
    })
}

/// Warns of a rating curve that begins far above ground that is dry at the start.
fn high_weir(rating: &Rating, faces: &[EdgeFace], bed: &BedParticles, still: &StillWater) -> Option<Problem> {
    let begins = rating.rows().first()?.0;
    if rating.rows().last()?.1 <= 0.0 {
        let problem = input_warning("rating-without-discharge", "the rating curve has no discharge above 0".to_owned())
            .with_cause("nothing leaves at any level: the boundary is a wall");
        return Some(problem.with_remedy("give the discharges of its levels, or take the boundary out"));
    }
    let lowest = faces.iter().min_by(|a, b| bed.elevation[a.cell].total_cmp(&bed.elevation[b.cell]))?;
    let height = begins - bed.elevation[lowest.cell];
    let is_dry = faces.iter().all(|face| still.depth[face.cell] <= 0.0);
    (height > HIGH_WEIR && is_dry).then(|| {
        let message = format!(
            "the rating curve begins at {} m, {height:.2} m above the lowest ground along this boundary, which is dry at the start",
            readable(begins)
        );
        input_warning("high-weir", message)
            .with_cause("until the water stands that high nothing leaves")
            .with_remedy("nothing, if a reservoir is to fill there; otherwise correct the levels of the table, their unit or their datum")
            .with_at(bed.lattice.to_map(lowest.middle))
    })
}

/// Warns of uniform flow down a slope where the lowest ground before the edge rises towards it from cell to cell.
fn rising_ground(slope: f64, faces: &[EdgeFace], bed: &BedParticles) -> Option<Problem> {
    let lattice = &bed.lattice;
    let behind = |face: &EdgeFace, cells: usize| {
        let centre = lattice.centre(face.cell);
        let place = centre + (centre - face.middle) * (2.0 * cells as f64);
        lattice.cell_at(place).filter(|cell| bed.has_terrain(*cell)).map(|cell| bed.elevation[cell])
    };
    let lowest = |cells: usize| faces.iter().filter_map(|face| behind(face, cells)).min_by(f64::total_cmp);
    let grounds = (0..=BEFORE_EDGE).map(lowest).collect::<Option<Vec<f64>>>()?;
    let (rise, length) = (grounds[0] - grounds[BEFORE_EDGE], BEFORE_EDGE as f64 * lattice.spacing);
    grounds.windows(2).all(|pair| pair[1] < pair[0]).then(|| {
        let message = format!(
            "uniform flow is to leave down a slope of {}, and the ground rises towards the edge: {rise:.2} m over the last {} m",
            readable(slope),
            readable(length)
        );
        input_warning("rising-ground", message)
            .with_cause("on ground that rises no flow is uniform: its depth at the edge is that of another slope than the terrain's")
            .with_remedy("take `type: open`, over which water falls, or a rating curve or `stage` of what holds it; or move the edge to where the ground falls")
    })
}

/// Warns of a level that is held far above all terrain, and above all water of the start.
fn drowned(level: &Series, bed: &BedParticles, still: &StillWater, end: f64) -> Option<Problem> {
    let peak = peak_until(level, end)?.value;
    let tops = bed.elevation.iter().zip(&still.depth).map(|(ground, depth)| ground + depth);
    let highest = tops.filter(|top| !top.is_nan()).fold(f64::NEG_INFINITY, f64::max);
    (highest.is_finite() && peak > highest + TORRENT).then(|| {
        let message = format!(
            "this boundary holds {} m, {:.0} m above all terrain and all water of the start",
            readable(peak),
            peak - highest
        );
        input_warning("drowned-terrain", message)
            .with_cause("all of the terrain goes under so deep; another unit or datum, perhaps")
            .with_remedy("correct the level, its unit or its datum")
    })
}

/// The greatest value of a series, and its time (s).
#[derive(Clone, Copy)]
pub struct Peak {
    pub time: f64,
    pub value: f64,
}

/// The greatest value of a series before the end of the run (s).
pub fn peak_until(series: &Series, end: f64) -> Option<Peak> {
    let points = series.points().filter(|point| point.0 < end).chain([(end, series.at(end))]);
    points.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(time, value)| Peak { time, value })
}

/// Where two boundaries meet.
#[derive(Clone, Copy, Debug)]
struct Junction {
    /// Local coordinates (m).
    place: Vec2,
    /// The higher of the two grounds (m).
    ground: f64,
}

/// The lowest place at which faces of two boundaries lie side by side, without a wall between them.
fn deepest_junction(
    faces: &[EdgeFace],
    others: &[EdgeFace],
    bed: &BedParticles,
    walls: &[[Vec2; 2]],
) -> Option<Junction> {
    let lattice = &bed.lattice;
    let others: BTreeSet<usize> = others.iter().map(|face| face.cell).collect();
    let mut deepest: Option<Junction> = None;
    for &EdgeFace { cell, middle } in faces {
        let (column, row) = lattice.column_row(cell);
        for near_row in row.saturating_sub(1)..=(row + 1).min(lattice.rows - 1) {
            for near_column in column.saturating_sub(1)..=(column + 1).min(lattice.columns - 1) {
                let near = lattice.index(near_column, near_row);
                if !others.contains(&near) {
                    continue;
                }
                let ground = bed.elevation[cell].max(bed.elevation[near]);
                let way = [lattice.centre(cell), lattice.centre(near)];
                if deepest.is_none_or(|junction| ground < junction.ground)
                    && !walls.iter().any(|wall| segments_cross(way, *wall))
                {
                    deepest = Some(Junction { place: middle, ground });
                }
            }
        }
    }
    deepest
}

/// Warns of two levels that are held side by side and differ.
fn step_of_level((own, other): (&Series, &Series), other_key: &str, junction: Junction, end: f64) -> Option<Problem> {
    let times = own.points().chain(other.points()).map(|point| point.0).filter(|time| (0.0..end).contains(time));
    let levels = times.chain([0.0, end]).map(|time| (time, own.at(time), other.at(time)));
    let wet = levels.filter(|(_, own, other)| own.min(*other) > junction.ground);
    let (time, own, other) = wet.max_by(|a, b| (a.1 - a.2).abs().total_cmp(&(b.1 - b.2).abs()))?;
    let depth = own.max(other) - junction.ground;
    ((own - other).abs() > STEP * depth).then(|| {
        let message = format!(
            "this boundary holds {} m and `{other_key}`, beside it, {} m at {} s",
            readable(own),
            readable(other),
            readable(time)
        );
        input_warning("step-of-level", message)
            .with_cause("water runs along the edge from one to the other, where nothing parts them")
            .with_remedy("correct the levels, their units or their datums; or leave a part of the edge shut, or a wall, between them")
    })
}

/// Whether any rain comes on any terrain before the end of the run (s).
fn runs_off(rain: &Rain, bed: &BedParticles, end: f64) -> bool {
    match rain {
        Rain::Uniform(series) => series.integral(0.0, end) > 0.0,
        Rain::Map { .. } => {
            (0..bed.lattice.len()).any(|cell| bed.has_terrain(cell) && rain.depth(cell, 0.0, end) > 0.0)
        }
        Rain::Frames(frames) => (0..frames.from.len()).any(|place| frames.depth(place, 0.0, end) > 0.0),
    }
}
