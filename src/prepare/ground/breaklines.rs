//! Breaklines: their files, and what they make of the ground.
//!
//! A breakline takes the cells of a strip along it ([`super::burn`]) and raises or carves their ground to its level there,
//! z = max(z, z_line) or min(z, z_line). A wall with a crest is one that raises.

use std::collections::BTreeMap;

use super::burn::{strip, value_at};
use super::change::{Change, Made};
use super::crests::{Buried, Doubt, Height};
use super::{CHECK_PLACES, Ground};
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::geodata::Crs;
use crate::math::Vec2;
use crate::output::SetBy;
use crate::prepare::findings::Findings;
use crate::prepare::outside::{Outside, all_outside, partly_outside};
use crate::prepare::places;
use crate::scenario::{Breakline, BreaklineMode, LineLevel, Scenario};
use crate::terrain::PLAUSIBLE_ELEVATION;
use crate::vector::Feature;

/// The particles of the variational formulation carry water over a ridge that is narrower than so many spacings: their kernels reach over it from both sides.
/// Behind a levee of 1, 2, 3 and 4 spacings that held a wave of 3 m, up to 0.15 m, 0.02 m, 1 mm and 1 µm were found, behind 5 nothing.
const RIDGE_OF_PARTICLES: f64 = 5.0;

/// A line with the level (m) at each of its vertices; map coordinates.
#[derive(Debug)]
pub struct Line {
    /// Number of its feature in the file, from 1.
    number: usize,
    places: Vec<Vec2>,
    levels: Vec<f64>,
}

/// The lines of each breakline of the scenario.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Vec<Vec<Line>> {
    scenario.ground.breaklines.iter().map(|breakline| lines(breakline, crs, scenario, findings)).collect()
}

/// Takes over what the breaklines change, one after the other.
pub fn shape(opened: &[Vec<Line>], scenario: &Scenario, ground: &mut Ground<'_>, findings: &mut Findings) {
    for (number, (breakline, lines)) in scenario.ground.breaklines.iter().zip(opened).enumerate() {
        let narrowest = RIDGE_OF_PARTICLES * ground.bed().lattice.spacing;
        if !scenario.numerics.has_cells()
            && breakline.mode == BreaklineMode::Raise
            && breakline.width.is_none_or(|width| width < narrowest)
        {
            findings.add(&breakline.lines, too_narrow(breakline, narrowest));
        }
        let mut seen = Seen::default();
        for line in lines {
            ground.take(seen.look_at(line, breakline, SetBy::Breakline(number), ground.bed()));
        }
        seen.report(breakline, lines.len(), ground.bed(), findings);
    }
}

/// The problem of a ridge that does not hold particles.
fn too_narrow(breakline: &Breakline, narrowest: f64) -> Problem {
    let message =
        format!("the particles of the variational formulation pass a raised line that is narrower than {narrowest} m");
    let width =
        if is_wall(breakline) { "take `crest` out, so that nothing passes the wall" } else { "give it that `width`" };
    Problem::error(ProblemKind::Scenario, "method-combination", "", message)
        .with_cause(format!(
            "their kernels reach over a ridge of less than {RIDGE_OF_PARTICLES} spacings from both sides"
        ))
        .with_remedy(format!("leave `numerics.formulation` out (or write `formulation: balanced`), or {width}"))
}

/// Whether a breakline is a wall with a crest.
fn is_wall(breakline: &Breakline) -> bool {
    breakline.lines.key.starts_with("structures.")
}

/// The lines of a file with their levels.
fn lines(breakline: &Breakline, crs: Option<&Crs>, scenario: &Scenario, findings: &mut Findings) -> Vec<Line> {
    let source = &breakline.lines;
    let name = source.value.path.display();
    let Some(features) = places::features_near(source, crs, scenario, findings) else { return Vec::new() };
    let has_line = |feature: &Feature| feature.lines.iter().any(places::has_length) || !feature.polygons.is_empty();
    findings.add_all(source, places::left_out(source, &features, "line", has_line));
    if let LineLevel::Field(field) = &breakline.level {
        findings.add_all(source, places::unit_of_attribute(source, &[field], &features, scenario));
    }
    let mut lines = Vec::new();
    let mut without_level: Vec<&Feature> = Vec::new();
    let mut count = 0;
    for feature in &features {
        let attribute = match &breakline.level {
            LineLevel::Constant(level) => Some(level.value),
            LineLevel::Field(field) => feature.number(field).filter(|level| level.is_finite()),
            LineLevel::Vertices => None,
        };
        let own = feature.lines.iter().zip(feature.heights.iter().map(Vec::as_slice));
        let outlines = feature.polygons.iter().map(|polygon| (polygon.exterior(), &[][..]));
        for (line, heights) in own.chain(outlines).filter(|(line, _)| line.0.len() >= 2) {
            count += 1;
            let level = |vertex: usize| match breakline.level {
                LineLevel::Vertices => heights.get(vertex).copied().filter(|z| z.is_finite()),
                _ => attribute,
            };
            let mut vertices: Vec<(Vec2, Option<f64>)> =
                line.0.iter().enumerate().map(|(i, c)| (Vec2::new(c.x, c.y), level(i))).collect();
            vertices.dedup_by_key(|vertex| vertex.0);
            let (places, levels): (Vec<Vec2>, Vec<Option<f64>>) = vertices.into_iter().unzip();
            match levels.into_iter().collect() {
                Some(levels) => lines.push(Line { number: feature.number, places, levels }),
                None => without_level.push(feature),
            }
        }
    }
    if count == 0 {
        let problem = input_error("no-lines", format!("{name} holds no line"));
        findings.add(source, problem.with_remedy("draw lines, or polygons whose outlines count as lines"));
    }
    let is_odd = |line: &&Line| line.levels.iter().any(|level| !PLAUSIBLE_ELEVATION.contains(level));
    if let Some(odd) = lines.iter().find(is_odd) {
        let odd_level = odd.levels.iter().copied().find(|level| !PLAUSIBLE_ELEVATION.contains(level));
        let message = format!(
            "feature {} of {name} has a level of {} m, as none on Earth",
            odd.number,
            odd_level.unwrap_or(f64::NAN)
        );
        let problem = input_error("implausible-level", message)
            .with_cause("a code for a missing value, perhaps, or another unit")
            .with_remedy("correct the level, its unit or its datum")
            .with_at(odd.places[0]);
        add_of_level(breakline, problem, findings);
        return Vec::new();
    }
    if let Some(first) = without_level.first() {
        findings.add(source, no_level(breakline, first, without_level.len(), count));
    }
    lines
}

/// The problem of lines without a level.
fn no_level(breakline: &Breakline, first: &Feature, missing: usize, count: usize) -> Problem {
    let name = breakline.lines.value.path.display();
    let message = match (missing, count) {
        (_, 1) => format!("the line of {name} has no level"),
        (1, _) => format!("one of the {count} lines of {name} has no level: feature {}", first.number),
        _ => format!("{missing} of {count} lines of {name} have no level, the first is feature {}", first.number),
    };
    let names = first.attribute_names();
    let (constant, field) = if is_wall(breakline) { ("crest", "crest_field") } else { ("z", "z_field") };
    match &breakline.level {
        LineLevel::Vertices => input_error("no-level", message)
            .with_cause(format!(
                "its vertices have no z coordinate, and the scenario names no level; its attributes: {names}"
            ))
            .with_remedy("add `z: 105 m`, or name the attribute with `z_field`"),
        _ => input_error("no-level", message)
            .with_cause(format!(
                "looked for a number in the attribute {}; its attributes: {names}",
                if let LineLevel::Field(field) = &breakline.level { field.as_str() } else { "z" }
            ))
            .with_remedy(format!("name another attribute with `{field}`, fill it in, or write `{constant}: 105 m`")),
    }
}

/// Adds a problem of the level of a breakline, where the scenario or the file says it.
fn add_of_level(breakline: &Breakline, problem: Problem, findings: &mut Findings) {
    match &breakline.level {
        LineLevel::Constant(level) => findings.add(level, problem),
        _ => findings.add(&breakline.lines, problem),
    }
}

/// What was seen of the lines of a file, when they were put on the ground.
#[derive(Default)]
struct Seen<'a> {
    outside: Vec<&'a Line>,
    /// The first that is higher or deeper than dams and cuts are.
    doubtful: Option<(&'a Line, Doubt)>,
    /// Those of which a good part lies below the ground.
    buried: Vec<(&'a Line, Buried)>,
    /// The straight pieces of those on the terrain.
    pieces: Vec<[Vec2; 2]>,
    /// Lines that change nothing, each with the place and the ground where it comes nearest to it.
    idle: Vec<(&'a Line, usize, f64)>,
}

impl<'a> Seen<'a> {
    /// What a line changes.
    fn look_at(&mut self, line: &'a Line, breakline: &Breakline, by: SetBy, bed: &BedParticles) -> Vec<Change> {
        let lattice = &bed.lattice;
        let is_raised = breakline.mode == BreaklineMode::Raise;
        let local: Vec<Vec2> = line.places.iter().map(|place| lattice.to_local(*place)).collect();
        let cells = strip(&local, breakline.width.unwrap_or(0.0), lattice);
        let levels: BTreeMap<usize, f64> = cells
            .into_iter()
            .filter(|&cell| bed.has_terrain(cell))
            .map(|cell| (cell, value_at(lattice.centre(cell), &local, &line.levels)))
            .collect();
        // How far the line lies above the ground that it raises, or below that which it carves.
        let height = |(cell, level): (&usize, &f64)| {
            let above = level - bed.elevation[*cell];
            (*cell, if is_raised { above } else { -above })
        };
        let heights = || levels.iter().map(height);
        let by_height = |a: &Height, b: &Height| a.1.total_cmp(&b.1);
        let Some((least, most)) = heights().min_by(by_height).zip(heights().max_by(by_height)) else {
            self.outside.push(line);
            return Vec::new();
        };
        if most.1 <= 0.0 {
            self.idle.push((line, most.0, -most.1));
        } else if is_raised {
            self.buried.extend(Buried::of(&local, &line.levels, bed).map(|part| (line, part)));
        }
        self.doubtful = self.doubtful.or_else(|| Some((line, Doubt::of([least, most])?)));
        self.pieces.extend(local.windows(2).map(|pair| [pair[0], pair[1]]));
        let made = |level| if is_raised { Made::Raise(level) } else { Made::Carve(level) };
        levels.into_iter().map(|(cell, level)| Change { cell, made: made(level), by }).collect()
    }

    /// Reports what is doubtful of `count` lines.
    fn report(self, breakline: &Breakline, count: usize, bed: &BedParticles, findings: &mut Findings) {
        let (source, lattice) = (&breakline.lines, &bed.lattice);
        let name = source.value.path.display();
        let is_raised = breakline.mode == BreaklineMode::Raise;
        if let Some(first) = self.outside.first() {
            let at = first.places[0];
            if self.outside.len() == count {
                all_outside(source, at, findings);
            } else {
                let message = format!(
                    "{} of {count} lines of {name} lie outside the terrain, the first is feature {}",
                    self.outside.len(),
                    first.number
                );
                let problem = input_warning("outside-terrain", message).with_cause("they change no ground");
                findings.add(source, problem.with_remedy(CHECK_PLACES).with_at(at));
            }
        }
        let feature = |line: &Line| format!("feature {} of {name}", line.number);
        if let Some((line, doubt)) = &self.doubtful {
            let problem = doubt.problem(&feature(line), if is_raised { "above" } else { "below" });
            add_of_level(breakline, problem.with_at(lattice.to_map(lattice.centre(doubt.cell))), findings);
        }
        if let Some((line, part)) = self.buried.first() {
            let buried = self.buried.len();
            let others = if buried > 1 { format!(" (one of {buried} such lines)") } else { String::new() };
            let problem = part.problem(&format!("{}{others}", feature(line)));
            add_of_level(breakline, problem.with_at(lattice.to_map(part.place)), findings);
        }
        let idle = self.changes_nothing(breakline, count, bed);
        let off = Outside::beyond_reach(self.pieces, bed);
        findings.add_all(source, partly_outside(source, off, lattice.spacing, "it changes no ground there"));
        if let Some(problem) = idle {
            add_of_level(breakline, problem, findings);
        }
    }

    /// The problem of lines, of so many, that lie below the terrain that they raise, or above that which they carve, all along.
    fn changes_nothing(&self, breakline: &Breakline, count: usize, bed: &BedParticles) -> Option<Problem> {
        let name = breakline.lines.value.path.display();
        let &(first, cell, least) = self.idle.iter().min_by(|a, b| a.2.total_cmp(&b.2))?;
        let is_raised = breakline.mode == BreaklineMode::Raise;
        let (code, side) = if is_raised { ("crest-below-terrain", "below") } else { ("invert-above-terrain", "above") };
        let message = format!(
            "{} of {count} lines of {name} lie {side} the terrain all along and change nothing; feature {} comes nearest to it, {least:.2} m {side}",
            self.idle.len(),
            first.number
        );
        let is_all = self.idle.len() + self.outside.len() == count;
        let problem = if is_all { input_error(code, message) } else { input_warning(code, message) };
        let at = bed.lattice.to_map(bed.lattice.centre(cell));
        Some(problem.with_remedy("correct the level, its unit or its datum, or the place of the line").with_at(at))
    }
}
