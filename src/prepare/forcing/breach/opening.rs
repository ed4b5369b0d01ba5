//! The opening of a dam with a shape, and whether it fits the dam and the terrain below it.

use super::OPEN_END;
use super::dam::Dam;
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error};
use crate::lattice::Lattice;
use crate::math::{Vec2, readable};
use crate::prepare::findings::Findings;
use crate::prepare::grid::REACH;
use crate::prepare::ground::burn::{Foot, foot_of};
use crate::scenario::BreachShape;
use crate::solver::{DamCell, Opening};

/// An opening narrower than so many cells is a coarse one.
const FINE_OPENING: f64 = 5.0;

/// The terrain may stand in the opening over this share of its bottom without a word: the valley has slopes.
const GROUND_IN_OPENING: f64 = 0.1;

/// A trapezoid in a dam.
struct Trapezoid {
    /// Its middle along the line of the dam (m).
    middle: f64,
    /// Width of its bottom (m).
    width: f64,
    /// Slope of its sides, horizontal to vertical.
    slope: f64,
    /// Level of its bottom (m).
    invert: f64,
    /// Its width at the crest (m).
    top: f64,
}

/// The opening of a shape, if it fits the dam.
pub fn trapezoid(shape: &BreachShape, dam: &Dam, bed: &BedParticles, findings: &mut Findings) -> Option<Opening> {
    let lattice = &bed.lattice;
    let middle = middle(shape, dam, lattice, findings)?;
    let (width, slope, invert) = (shape.bottom_width.value, shape.side_slope, shape.invert.value);
    if invert >= dam.crest {
        findings.add(&shape.invert, invert_above_crest(invert, dam.crest));
        return None;
    }
    let opening = Trapezoid { middle, width, slope, invert, top: width + 2.0 * slope * (dam.crest - invert) };
    if opening.top <= 0.0 {
        findings.add(&shape.bottom_width, without_area());
        return None;
    }
    if let Some(problem) = opening.wider_than(dam, bed).or_else(|| opening.beyond(dam, lattice.spacing)) {
        findings.add(&shape.bottom_width, problem);
        return None;
    }
    let is_under = |cell: &&DamCell| (cell.station - middle).abs() <= 0.5 * width + cell.reach;
    let under: Vec<&DamCell> = dam.cells.iter().filter(is_under).collect();
    if let Some(problem) = opening.below_terrain(&under, lattice) {
        findings.add(&shape.invert, problem);
        return None;
    }
    findings.add_all(&shape.invert, opening.terrain_within(&under, lattice));
    findings.add_all(&shape.bottom_width, opening.coarse(lattice.spacing));
    Some(Opening::Trapezoid { middle, bottom_width: width, side_slope: slope, invert })
}

/// The middle of the opening along the line of the dam (m): that of the line where the shape has no position.
fn middle(shape: &BreachShape, dam: &Dam, lattice: &Lattice, findings: &mut Findings) -> Option<f64> {
    let Some(position) = &shape.position else { return Some(0.5 * dam.length()) };
    let place = Vec2::new(position.value[0], position.value[1]);
    let Foot { station, distance, .. } = foot_of(lattice.to_local(place), &dam.line);
    if distance > REACH * lattice.spacing {
        let problem = input_error("position-off-dam", format!("this place lies {distance:.1} m off the dam"))
            .with_remedy("give a place on its line, or leave the key out for the middle of the line")
            .with_at(place);
        findings.add(position, problem);
        return None;
    }
    Some(station)
}

fn invert_above_crest(invert: f64, crest: f64) -> Problem {
    let message = format!("the invert of {} m is not below the crest of {} m", readable(invert), readable(crest));
    Problem::error(ProblemKind::Scenario, "invert-above-crest", "", message)
        .with_remedy("correct the level, its unit or its datum")
}

fn without_area() -> Problem {
    let message = "the breach has no area: its bottom has no width, and its sides are upright";
    Problem::error(ProblemKind::Scenario, "breach-without-area", "", message)
        .with_remedy("give the bottom a width or the sides a slope")
}

impl Trapezoid {
    /// The refusal where it is wider than the dam, or than the part of it that stands above the ground.
    fn wider_than(&self, dam: &Dam, bed: &BedParticles) -> Option<Problem> {
        let (top, length, free) = (self.top, dam.length(), dam.length_above_ground(bed));
        let spacing = bed.lattice.spacing;
        // The ground meets the crest within a cell.
        if top <= length && top <= free + spacing {
            return None;
        }
        let stands = if free + spacing < length {
            format!(", and stands above the ground over {free:.1} m of it")
        } else {
            String::new()
        };
        let message = format!("the breach is {top:.1} m wide at the crest, and the dam is {length:.1} m long{stands}");
        let problem = Problem::error(ProblemKind::Scenario, "breach-wider-than-dam", "", message)
            .with_cause(format!(
                "bottom width {} m, sides {} to 1 over {:.2} m of height",
                readable(self.width),
                readable(self.slope),
                dam.crest - self.invert
            ))
            .with_remedy("take a narrower one, or correct the crest; without `shape` the whole dam goes");
        Some(problem)
    }

    /// The refusal where it reaches beyond an end of the dam on the terrain.
    fn beyond(&self, dam: &Dam, spacing: f64) -> Option<Problem> {
        let (top, middle) = (self.top, self.middle);
        let stations = || dam.cells.iter().map(|cell| cell.station);
        let (first, last) = (stations().fold(f64::INFINITY, f64::min), stations().fold(f64::NEG_INFINITY, f64::max));
        if middle - 0.5 * top >= first - 0.5 * spacing && middle + 0.5 * top <= last + 0.5 * spacing {
            return None;
        }
        let message = format!(
            "the breach, {top:.1} m wide at the crest around {middle:.1} m along the dam, reaches beyond its end on the terrain"
        );
        let problem = Problem::error(ProblemKind::Scenario, "breach-beyond-dam", "", message)
            .with_cause(format!("the dam stands on the terrain from {first:.1} m to {last:.1} m of its line"))
            .with_remedy("take a `position` further from the end, a narrower breach, or a longer line");
        Some(problem)
    }

    /// The refusal where its bottom lies below all terrain under it.
    fn below_terrain(&self, under: &[&DamCell], lattice: &Lattice) -> Option<Problem> {
        let lowest = under.iter().min_by(|a, b| a.ground.total_cmp(&b.ground))?;
        if self.invert >= lowest.ground {
            return None;
        }
        let message = format!(
            "the invert of {} m lies below the terrain under the breach, {:.2} m",
            readable(self.invert),
            lowest.ground
        );
        let problem = input_error("invert-below-terrain", message)
            .with_remedy(format!(
                "take at least {:.2} m, or put the breach elsewhere with `position`",
                (100.0 * lowest.ground).ceil() / 100.0
            ))
            .with_at(lattice.to_map(lattice.centre(lowest.cell)));
        Some(problem)
    }

    /// The warning where much of its bottom ends on the terrain.
    fn terrain_within(&self, under: &[&DamCell], lattice: &Lattice) -> Option<Problem> {
        let above: Vec<_> = under.iter().filter(|cell| cell.ground > self.invert + OPEN_END).collect();
        let highest = above.iter().max_by(|a, b| a.ground.total_cmp(&b.ground))?;
        if above.len() as f64 <= GROUND_IN_OPENING * under.len() as f64 {
            return None;
        }
        let message = format!(
            "{} of {} cells of the bottom of the breach end on the terrain above the invert of {} m, the highest at {:.2} m",
            above.len(),
            under.len(),
            readable(self.invert),
            highest.ground
        );
        let problem = Problem::warning(ProblemKind::Input, "terrain-in-breach", "", message)
            .with_cause("a valley narrower than the breach, or a terrain that holds the dam already")
            .with_remedy(
                "look at the terrain along the dam; where it holds the dam, carve it out with `terrain.breaklines`",
            )
            .with_at(lattice.to_map(lattice.centre(highest.cell)));
        Some(problem)
    }

    /// The warning where it is only a few cells wide.
    fn coarse(&self, spacing: f64) -> Option<Problem> {
        (self.top < FINE_OPENING * spacing).then(|| {
            let message = format!("the breach is {:.1} cells wide at the crest", self.top / spacing);
            Problem::warning(ProblemKind::Scenario, "breach-coarse", "", message).with_remedy(format!(
                "choose a `resolution` of {:.3} m or finer for its shape to count",
                self.top / FINE_OPENING
            ))
        })
    }
}
