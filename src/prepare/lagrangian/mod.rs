//! What Lagrangian particles of the balanced formulation are known to do wrong: a warning for each, with its place.
//!
//! The figures were measured on cases with a known answer (`docs/validation/README.md`, `ritter_plane`), at the places where the method
//! fails: a front over dry ground in the plane, a film of rain, a wall askew to the lattice, a strong jump, a level held over dry ground.

mod askew;

use crate::bed::BedParticles;
use crate::boundary::{Condition, Forcing};
use crate::error::{Place, Problem, input_warning};
use crate::math::{Vec2, readable, segments_cross};
use crate::prepare::findings::Findings;
use crate::prepare::forcing::levels::Inflow;
use crate::prepare::forcing::plausible::{Placed, peak_until};
use crate::scenario::methods::{Formulation, Motion};
use crate::scenario::{Scenario, Sourced, VectorSource};
use crate::seeding::StillWater;

/// A drop (m) from water to dry ground that makes a front; less is within the error of any terrain.
const LEAST_DROP: f64 = 0.01;
/// Slope of dry ground from which rain runs off too fast: at 80 mm/h and cells of 5 m the greatest speed was 1.3, 4.7, 6.4, 6.6 and 22 times
/// that of Eulerian particles on slopes of 0.003, 0.01, 0.03, 0.1 and 0.3.
const RAIN_SLOPE: f64 = 0.005;
/// Froude number from which on a flow can jump strongly.
const FAST: f64 = 1.5;
/// Ratio of depths side by side from which on a dam break makes a strong bore: after 50 s the mean depths of one of 10 m differed from those of
/// Eulerian particles by 0.025, 0.027, 0.043, 0.059, 0.076 and 0.086 m over 4, 2.5, 1.5, 1, 0.5 and 0.1 m of water.
const STEEP_BORE: f64 = 5.0;

/// What to do about each of them.
const REMEDY: &str = "leave `numerics.motion` out: Eulerian particles (the default) have no such fault";

/// The scene on the lattice.
pub(super) struct Scene<'a> {
    pub bed: &'a BedParticles,
    pub still: &'a StillWater,
    /// Of each body of still water the entry of the scenario that it comes from.
    pub bodies: Vec<&'a Sourced<VectorSource>>,
    /// Velocity (m/s) of the water of each cell at the start; empty where it rests.
    pub velocity: &'a [Vec2],
    /// Of each wall of the scenario its straight pieces (local coordinates, m).
    pub walls: Vec<Vec<[Vec2; 2]>>,
    /// Whether a face of the edge, by its midpoint and normal, is open.
    pub is_open: &'a dyn Fn(Vec2, Vec2) -> bool,
    /// The boundaries with a condition, and what else brings water.
    pub placed: &'a [Placed],
    pub forcing: &'a Forcing,
}

/// Warns of everything in a scenario with Lagrangian particles that they get wrong.
pub(super) fn check(scene: &Scene<'_>, scenario: &Scenario, findings: &mut Findings) {
    let numerics = &scenario.numerics;
    if (numerics.formulation, numerics.motion) != (Formulation::Balanced, Motion::Lagrangian) {
        return;
    }
    for (key, place, problem) in
        [scene.dry_front(scenario), scene.rain(scenario), scene.jump(scenario), scene.held_level(scenario)]
            .into_iter()
            .flatten()
            .chain(scene.askew_walls(scenario))
    {
        findings.add_at(&key, place, problem.with_remedy(REMEDY));
    }
}

/// A warning with the key and the place of what it belongs to.
type Warned = (String, Option<Place>, Problem);

fn of<T>(source: &Sourced<T>, problem: Problem) -> Warned {
    (source.key.clone(), source.place.clone(), problem)
}

/// Two cells side by side without a wall between them.
#[derive(Clone, Copy, Debug)]
struct Face {
    cells: [usize; 2],
    /// Its midpoint (local coordinates, m).
    middle: Vec2,
}

impl Scene<'_> {
    /// Still or flowing water above dry ground beside it, a breach, an inflow or a source on dry ground: a front will run over dry ground.
    fn dry_front(&self, scenario: &Scenario) -> Option<Warned> {
        let (bed, still) = (self.bed, self.still);
        let drop = |face: &Face| {
            let of = |wet: usize, dry: usize| {
                let level = bed.elevation[wet] + still.depth[wet];
                let drop = level - bed.elevation[wet].max(bed.elevation[dry]);
                (still.depth[wet] > 0.0 && still.depth[dry] <= 0.0 && drop > LEAST_DROP).then_some((wet, drop))
            };
            of(face.cells[0], face.cells[1]).or_else(|| of(face.cells[1], face.cells[0]))
        };
        let fronts = self.faces().filter_map(|face| drop(&face).map(|found| (face, found)));
        let fronts = fronts.filter(|(face, _)| !self.is_shut(face));
        let highest = fronts.max_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let problem = |place: Vec2| {
            input_warning("lagrangian-dry-front", "the front over dry ground comes late with Lagrangian particles".to_owned())
                .with_cause("after a dam break of 10 m it stood at 565 m after 50 s, exact 943 m (`floodsim validate ritter`): arrival is late, the flooded area too small")
                .with_at(bed.lattice.to_map(place))
        };
        if let Some((face, (wet, _))) = highest {
            let body = still.body[wet].and_then(|body| self.bodies.get(body as usize));
            let (key, place) = match body {
                Some(source) => (source.key.clone(), source.place.clone()),
                None => (self.start_key(scenario), None),
            };
            return Some((key, place, problem(face.middle)));
        }
        if let (Some(dam), Some(breach)) = (&self.forcing.breach, &scenario.breach)
            && let Some(cell) = dam.cells.get(dam.cells.len() / 2)
        {
            return Some(of(&breach.dam, problem(bed.lattice.centre(cell.cell))));
        }
        for (boundary, source) in self.conditions(scenario) {
            // A stage has its own warning.
            let highest = match boundary.1 {
                Condition::Discharge { .. } => f64::INFINITY,
                Condition::Level(level) | Condition::Wave { level, .. } => {
                    peak_until(level, scenario.end_time).map_or(f64::NEG_INFINITY, |peak| peak.value)
                }
                _ => continue,
            };
            let is_dry = |cell: usize| still.depth[cell] <= 0.0 && bed.elevation[cell] < highest;
            if let Some(face) = boundary.0.faces.iter().find(|face| is_dry(face.cell)) {
                return Some(of(source, problem(face.middle)));
            }
        }
        let point = self.forcing.sources.iter().map(|source| bed.lattice.cell_at(source.place));
        let line = self.forcing.line_sources.iter().map(|source| source.cells.first().map(|cell| cell.0));
        let dry = point.chain(line).flatten().find(|&cell| still.depth[cell] <= 0.0)?;
        Some(of(scenario.sources.first()?, problem(bed.lattice.centre(dry))))
    }

    /// Rain on dry ground that slopes.
    fn rain(&self, scenario: &Scenario) -> Option<Warned> {
        let source = scenario.rain.as_ref().filter(|_| self.forcing.rain.is_some())?;
        let (bed, spacing) = (self.bed, self.bed.lattice.spacing);
        let slope = |face: &Face| {
            let [a, b] = face.cells;
            let is_dry = self.still.depth[a] <= 0.0 && self.still.depth[b] <= 0.0;
            is_dry.then_some((face.middle, (bed.elevation[a] - bed.elevation[b]).abs() / spacing))
        };
        let (place, slope) = self.faces().filter_map(|face| slope(&face)).max_by(|a, b| a.1.total_cmp(&b.1))?;
        let message = format!(
            "rain runs off too fast with Lagrangian particles, here on a slope of {}",
            readable(rounded(slope))
        );
        let cause = "80 mm/h on a smooth slope of 0.3 ran at up to 30 m/s, exact 0.87 m/s; a third of the water was missing from the slope";
        let problem = input_warning("lagrangian-rain", message).with_cause(cause);
        (slope > RAIN_SLOPE).then(|| of(source, problem.with_at(bed.lattice.to_map(place))))
    }

    /// Flow that is supercritical at the start or where it comes in, and deep water beside shallow.
    fn jump(&self, scenario: &Scenario) -> Option<Warned> {
        let (bed, still) = (self.bed, self.still);
        let problem = |message: String, place: Vec2| {
            input_warning("lagrangian-jump", message)
                .with_cause("behind a standing jump the depth was 5 to 18 % wrong, and the jump wandered 10 to 20 cells upstream; behind a bore of 10 m over 0.5 m it was 2.4 m, exact 3.1 m")
                .with_at(bed.lattice.to_map(place))
        };
        let froude = |cell: usize| {
            let depth = still.depth[cell];
            let speed = self.velocity.get(cell).map_or(0.0, |velocity| velocity.norm());
            let is_deep = depth > scenario.numerics.dry_depth.max(LEAST_DROP);
            if is_deep { speed / (scenario.numerics.gravity * depth).sqrt() } else { 0.0 }
        };
        let fastest = (0..self.velocity.len()).map(|cell| (cell, froude(cell))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((cell, froude)) = fastest.filter(|found| found.1 > FAST) {
            let message = format!(
                "Lagrangian particles get strong jumps wrong, and the water of the start has a Froude number of {froude:.1}"
            );
            return Some((self.start_key(scenario), None, problem(message, bed.lattice.centre(cell))));
        }
        for ((placed, condition), source) in self.conditions(scenario) {
            let Condition::Discharge { discharge, level: Some(level) } = condition else { continue };
            let froude = froude_of_inflow(placed, Inflow { discharge, level }, bed, scenario);
            if let (Some(froude), Some(face)) = (froude.filter(|froude| *froude > FAST), placed.faces.first()) {
                let message = format!(
                    "Lagrangian particles get strong jumps wrong, and the water comes in with a Froude number of {froude:.1}"
                );
                return Some(of(source, problem(message, face.middle)));
            }
        }
        let ratio = |face: &Face| {
            let ground = bed.elevation[face.cells[0]].max(bed.elevation[face.cells[1]]);
            let above = |cell: usize| bed.elevation[cell] + still.depth[cell] - ground;
            let (one, other) = (above(face.cells[0]), above(face.cells[1]));
            let is_wet = face.cells.iter().all(|&cell| still.depth[cell] > 0.0) && one.min(other) > 0.0;
            (is_wet && (one - other).abs() > LEAST_DROP).then(|| one.max(other) / one.min(other))
        };
        let bores = self.faces().filter_map(|face| ratio(&face).map(|ratio| (face, ratio)));
        let strong = bores.filter(|(face, ratio)| *ratio > STEEP_BORE && !self.is_shut(face));
        let (face, ratio) = strong.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let message = format!(
            "Lagrangian particles get strong bores wrong, and the water of the start stands {ratio:.0} times as deep as that beside it"
        );
        let [a, b] = face.cells;
        let wet = if bed.elevation[a] + still.depth[a] > bed.elevation[b] + still.depth[b] { a } else { b };
        let warned = problem(message, face.middle);
        match still.body[wet].and_then(|body| self.bodies.get(body as usize)) {
            Some(source) => Some(of(source, warned)),
            None => Some((self.start_key(scenario), None, warned)),
        }
    }

    /// Still water beyond an edge, whose level is held at the edge itself; worst above ground that is dry at the start.
    fn held_level(&self, scenario: &Scenario) -> Option<Warned> {
        for ((placed, condition), source) in self.conditions(scenario) {
            let Condition::Stage(level) = condition else { continue };
            let peak = peak_until(level, scenario.end_time).map_or(f64::NEG_INFINITY, |peak| peak.value);
            let dry = placed
                .faces
                .iter()
                .filter(|face| self.still.depth[face.cell] <= 0.0 && self.bed.elevation[face.cell] < peak);
            let lowest = dry.min_by(|a, b| self.bed.elevation[a.cell].total_cmp(&self.bed.elevation[b.cell]));
            if let Some(face) = lowest {
                let message = format!(
                    "a level held {:.2} m above dry ground lets in too much with Lagrangian particles",
                    peak - self.bed.elevation[face.cell]
                );
                let cause = "on a dry valley 34 698 m3 came in, for 18 797 m3 with Eulerian particles";
                let problem = input_warning("lagrangian-held-level", message).with_cause(cause);
                return Some(of(source, problem.with_at(self.bed.lattice.to_map(face.middle))));
            }
        }
        let is_stage = |condition: &Condition| matches!(condition, Condition::Stage(_));
        let ((placed, _), source) = self.conditions(scenario).find(|((_, condition), _)| is_stage(condition))?;
        let message = "a `stage` is held at the boundary itself with Lagrangian particles, as `level` is".to_owned();
        let cause = "what comes in is not lowered by the head of its velocity: 5 cm at 1 m/s, 20 cm at 2 m/s";
        let problem = input_warning("lagrangian-stage", message).with_cause(cause);
        Some(of(source, problem.with_at(self.bed.lattice.to_map(placed.faces.first()?.middle))))
    }

    /// The boundaries with a condition that open a face.
    fn conditions<'b>(
        &'b self,
        scenario: &'b Scenario,
    ) -> impl Iterator<Item = ((&'b Placed, &'b Condition), &'b Sourced<crate::scenario::Boundary>)> {
        let boundaries = self.placed.iter().zip(&self.forcing.boundaries);
        boundaries
            .filter(|(placed, _)| !placed.faces.is_empty())
            .map(|(placed, boundary)| ((placed, &boundary.condition), &scenario.boundaries[placed.index]))
    }

    /// Faces between cells with terrain.
    fn faces(&self) -> impl Iterator<Item = Face> {
        let (bed, lattice) = (self.bed, &self.bed.lattice);
        (0..lattice.len()).filter(|&cell| bed.has_terrain(cell)).flat_map(move |cell| {
            let (column, row) = lattice.column_row(cell);
            let east = (column + 1 < lattice.columns).then_some(cell + 1);
            let north = (row + 1 < lattice.rows).then_some(cell + lattice.columns);
            let others = [east, north].into_iter().flatten().filter(|&other| bed.has_terrain(other));
            others.map(move |other| Face {
                cells: [cell, other],
                middle: (lattice.centre(cell) + lattice.centre(other)) * 0.5,
            })
        })
    }

    /// Whether a wall shuts a face.
    fn is_shut(&self, face: &Face) -> bool {
        let way = face.cells.map(|cell| self.bed.lattice.centre(cell));
        self.walls.iter().flatten().any(|wall| segments_cross(way, *wall))
    }

    /// The highest level (m) that water has at the start; without bounds where more of it comes in.
    fn highest_water(&self) -> f64 {
        if !self.forcing.is_still() {
            return f64::INFINITY;
        }
        let level = |cell: usize| self.bed.elevation[cell] + self.still.depth[cell];
        let wet = (0..self.still.depth.len()).filter(|&cell| self.still.depth[cell] > 0.0);
        wet.map(level).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The key of the water at the start that belongs to no body.
    fn start_key(&self, scenario: &Scenario) -> String {
        let earlier = scenario.start.earlier.as_ref().map(|run| run.fields.key.clone());
        let depth = || scenario.start.depths.first().map(|water| water.place.key.clone());
        earlier.or_else(depth).unwrap_or_else(|| "initial".to_owned())
    }
}

/// The greatest Froude number of what comes in at the level that is given with it, before the run ends.
fn froude_of_inflow(
    placed: &Placed,
    Inflow { discharge, level }: Inflow<'_>,
    bed: &BedParticles,
    scenario: &Scenario,
) -> Option<f64> {
    let end = scenario.end_time;
    let times = discharge.points().chain(level.points()).map(|point| point.0).filter(|time| (0.0..end).contains(time));
    let froude = |time: f64| {
        let depths =
            placed.faces.iter().map(|face| level.at(time) - bed.elevation[face.cell]).filter(|depth| *depth > 0.0);
        let (width, area) = depths
            .fold((0.0, 0.0), |(width, area), depth| (width + bed.lattice.spacing, area + depth * bed.lattice.spacing));
        (area > 0.0).then(|| discharge.at(time) / area / (scenario.numerics.gravity * area / width).sqrt())
    };
    times.chain([0.0, end]).filter_map(froude).max_by(f64::total_cmp)
}

/// Two digits that count.
fn rounded(value: f64) -> f64 {
    let unit = 10f64.powf(value.abs().max(f64::MIN_POSITIVE).log10().floor() - 1.0);
    (value / unit).round() * unit
}
