//! Boundaries with a condition on the lattice: the faces that each opens, and whether its levels fit the ground there.

use super::levels::{self, Inflow, Inlet};
use super::plausible::Placed;
use crate::bed::BedParticles;
use crate::boundary::{Boundary, Condition, EdgeFace, Forcing, OpenEdges, Pieces, Strip, edge_faces};
use crate::error::{Problem, ProblemKind, input_error};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::prepare::findings::Findings;
use crate::prepare::grid::{REACH, faces_opened, open_side};
use crate::prepare::places;
use crate::scenario::{Boundary as Written, BoundaryCondition, OpenBoundary, Scenario, Side, Sourced};

/// A side may stay a wall along this share of its edge without a word.
const STEPPED: f64 = 0.1;
/// Two boundaries that share more than this of the faces of one of them overlap.
const SHARED: f64 = 0.5;

/// A boundary before it is put on the lattice: its lines (map coordinates), where it has any, and its condition.
pub type OpenedBoundary = (Option<places::Drawn>, Option<Condition>);

/// The boundaries, and what is wrong with their places. Hands on those that have a condition.
pub fn on_lattice(
    opened: &[OpenedBoundary],
    scenario: &Scenario,
    ground: &BedParticles,
    forcing: &mut Forcing,
    findings: &mut Findings,
) -> Vec<Placed> {
    let (lattice, bed) = (&ground.lattice, &ground.elevation[..]);
    let mut with_condition = Vec::new();
    let mut edges = edge_faces(lattice, bed);
    // The solver keeps the walls of buildings shut: what lies before them alone would open nothing.
    edges.retain(|edge| !ground.is_sealed(edge.middle));
    // Of each boundary that has a line and a condition: its place in the scenario, and what it would open alone.
    let mut placed: Vec<(&Sourced<Written>, Vec<usize>)> = Vec::new();
    for (index, (source, (lines, condition))) in scenario.boundaries.iter().zip(opened).enumerate() {
        // Where the terrain goes on beyond the part that is read, its side is elsewhere: the boundary keeps its number, and opens nothing.
        if let (OpenBoundary::Side(side), Some(part)) = (&source.value.place, scenario.reading.part)
            && part.is_cut(*side)
        {
            let nothing = |condition: &Condition| Boundary { pieces: Pieces::default(), condition: condition.clone() };
            forcing.boundaries.extend(condition.as_ref().map(nothing));
            continue;
        }
        let Some(mut pieces) = pieces_of(source, lines.as_ref(), &edges, ground, findings) else { continue };
        if pieces.is_empty() && !edges.is_empty() {
            continue;
        }
        let near = faces_opened(&mut pieces, &edges, lattice);
        if near.is_empty() {
            let problem = opens_nothing(forcing.reach);
            findings.add(source, Problem { at: pieces.place().map(|place| lattice.to_map(place)), ..problem });
            continue;
        }
        for (other, faces) in &placed {
            findings.add_all(source, overlap(&near, &other.key, faces, &edges, lattice));
        }
        if let Some(condition) = condition {
            check_ground(source, condition, (&near, &edges), ground, findings);
            check_inflow(source, condition, (&near, &edges), scenario, ground, findings);
            forcing.boundaries.push(Boundary { pieces, condition: condition.clone() });
            let faces = near.iter().map(|face| edges[*face]).collect();
            with_condition.push(Placed { index, faces });
        }
        placed.push((source, near));
    }
    with_condition
}

/// The pieces of a boundary: those of its side, or of its lines; none where these could not be read.
fn pieces_of(
    source: &Sourced<Written>,
    lines: Option<&places::Drawn>,
    edges: &[EdgeFace],
    ground: &BedParticles,
    findings: &mut Findings,
) -> Option<Pieces> {
    let (lattice, bed) = (&ground.lattice, &ground.elevation[..]);
    match (&source.value.place, lines) {
        (OpenBoundary::Side(Side::All), _) => {
            let mut open = OpenEdges::default();
            open_side(&mut open, Side::All, lattice, bed);
            let is_open = |edge: &&EdgeFace| open.is_open(edge.middle, edge.middle - lattice.centre(edge.cell));
            Some(edges.iter().filter(is_open).map(|edge| [edge.middle; 2]).collect())
        }
        (OpenBoundary::Side(side), _) => {
            let mut open = OpenEdges::default();
            let passed_over = open_side(&mut open, *side, lattice, bed);
            warn_of_steps(source, passed_over, lattice, findings);
            Some(open.pieces)
        }
        (OpenBoundary::Lines(lines_source), Some(lines)) => {
            Some(places::on_lattice(lines_source, lines, ground, places::NOT_OPEN, findings).into())
        }
        (OpenBoundary::Lines(_), None) => None,
    }
}

/// The refusal of a boundary without an edge face within its reach (m).
fn opens_nothing(reach: f64) -> Problem {
    input_error("opens-nothing", "this boundary touches no edge of the terrain".to_owned())
        .with_cause(format!(
            "no edge face along it lies within {reach} m; those square to it and the walls of buildings are none"
        ))
        .with_remedy("draw it along the edge of the terrain data; water that comes in elsewhere is a source")
}

/// The refusal of a boundary that has many of its faces in common with another.
fn overlap(near: &[usize], other: &str, faces: &[usize], edges: &[EdgeFace], lattice: &Lattice) -> Option<Problem> {
    let shared: Vec<usize> = near.iter().copied().filter(|face| faces.binary_search(face).is_ok()).collect();
    (shared.len() as f64 > SHARED * near.len().min(faces.len()) as f64).then(|| {
        let message = format!("this boundary overlaps `{other}` along {} faces of the edge", shared.len());
        input_error("overlapping-boundaries", message)
            .with_remedy("let each part of the edge have one condition")
            .with_at(lattice.to_map(edges[shared[0]].middle))
    })
}

/// Warns of a side that stays a wall in part because its edge steps back there by more than a cell.
fn warn_of_steps(
    source: &Sourced<Written>,
    (passed_over, opened): (Vec<Vec2>, usize),
    lattice: &Lattice,
    findings: &mut Findings,
) {
    let count = passed_over.len();
    if count as f64 > STEPPED * (count + opened) as f64 {
        let message = format!("{:.0} m of this side stay a wall", count as f64 * lattice.spacing);
        let problem = Problem::warning(ProblemKind::Input, "side-in-part", "", message)
            .with_cause("the edge of the terrain steps back by more than a cell there")
            .with_remedy("right where the ground stays dry; elsewhere draw a `line` along the edge, or fill the terrain up to it")
            .with_at(lattice.to_map(passed_over[0]));
        findings.add(source, problem);
    }
}

/// Whether the ground under a boundary fits its levels.
fn check_ground(
    source: &Sourced<Written>,
    condition: &Condition,
    (near, edges): (&[usize], &[EdgeFace]),
    ground: &BedParticles,
    findings: &mut Findings,
) {
    let (lattice, bed) = (&ground.lattice, &ground.elevation);
    let lowest_of = |faces: &mut dyn Iterator<Item = usize>| {
        faces.map(|face| (bed[edges[face].cell], edges[face].middle)).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let Some((lowest, place)) = lowest_of(&mut near.iter().copied()) else { return };
    let highest = match condition {
        Condition::Stage(level)
        | Condition::Level(level)
        | Condition::Wave { level, .. }
        | Condition::Discharge { level: Some(level), .. } => Some(level.peak()),
        Condition::Rating(rating) => rating.rows().last().map(|row| row.0),
        _ => None,
    };
    if let Some(highest) = highest.filter(|highest| *highest <= lowest) {
        let message = format!(
            "the highest level of this boundary, {highest} m, is not above the lowest ground along it, {lowest:.2} m"
        );
        let problem = input_error("boundary-dry", message)
            .with_remedy("correct the level, its unit or its datum, or draw the boundary through the river bed")
            .with_at(lattice.to_map(place));
        findings.add(source, problem);
    }
    if let Condition::Discharge { .. } = condition {
        let beside = |&face: &usize| {
            let reach = 2.0 * REACH * lattice.spacing;
            let looks = |face: usize| edges[face].middle - lattice.centre(edges[face].cell);
            // A side that begins around the corner is no bank of this one.
            let is_own = |own: usize| {
                (edges[own].middle - edges[face].middle).norm() <= reach && looks(own).dot(looks(face)) > 0.0
            };
            !near.contains(&face) && near.iter().any(|&own| is_own(own))
        };
        let outside = lowest_of(&mut (0..edges.len()).filter(beside));
        if let Some((ground, at)) = outside.filter(|(ground, _)| *ground < lowest) {
            let message = format!(
                "the edge beside this boundary is lower ({ground:.2} m) than all ground along it ({lowest:.2} m at least)"
            );
            let problem = Problem::warning(ProblemKind::Input, "lower-ground-beside", "", message)
                .with_cause("the line may miss the river bed: the water would come in over a bank")
                .with_remedy("draw the line across the whole river bed")
                .with_at(lattice.to_map(at));
            findings.add(source, problem);
        }
    }
}

/// Whether the level beside a discharge fits the ground at all times; one that is nowhere above it is refused by [`check_ground`].
fn check_inflow(
    source: &Sourced<Written>,
    condition: &Condition,
    (near, edges): (&[usize], &[EdgeFace]),
    scenario: &Scenario,
    ground: &BedParticles,
    findings: &mut Findings,
) {
    let (
        Condition::Discharge { discharge, level: Some(levels) },
        BoundaryCondition::Discharge { level: Some(timed), .. },
    ) = (condition, &source.value.condition)
    else {
        return;
    };
    let strip = |face: &usize| Strip { width: ground.lattice.spacing, bed: ground.elevation[edges[*face].cell] };
    let strips: Vec<Strip> = near.iter().map(strip).collect();
    if strips.iter().all(|strip| strip.bed >= levels.peak()) {
        return;
    }
    let gravity = scenario.numerics.gravity;
    let inlet = Inlet { name: "this boundary", strips: &strips, gravity, end: scenario.end_time };
    if let Some(problem) = levels::check_inflow(timed, Inflow { discharge, level: levels }, inlet) {
        let (key, place) = timed.source();
        findings.add_at(key, place.cloned(), problem);
    }
}
