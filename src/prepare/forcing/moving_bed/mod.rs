//! A bed that moves: its rasters and lines, the cells that it may change, and whether it fits what else stands there.

mod in_place;
mod slide;

use crate::bed::BedParticles;
use crate::boundary::{EdgeFace, edge_faces};
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::prepare::findings::Findings;
use crate::prepare::forcing::sources::lines_of;
use crate::prepare::places;
use crate::prepare::raster;
use crate::prepare::tables::dates::Origin;
use crate::prepare::tables::{rows, series};
use crate::scenario::units::VELOCITY;
use crate::scenario::{BedMovement, MovingBed, Scenario};
use crate::solver::{BedLaw, BedMotion, Forcing, Series};
use crate::terrain::Raster;
use in_place::in_place;
use slide::slide;

/// Change of the bed (m) that counts as none: what rasters of single precision leave of a difference.
const NO_CHANGE: f64 = 1e-6;
/// Change of the bed (m) beyond which it is rather a fill value or another unit: no ground moves so far.
const DOUBTFUL_CHANGE: f64 = 1000.0;
/// No correction of elevations that a scenario may ask for is greater (m).
const GREATEST_CHANGE: f64 = 20e3;
/// Share of a volume that the lattice may add or lose.
const OTHER_VOLUME: f64 = 0.02;

/// The files of a part of the bed that moves, opened; map coordinates.
pub struct Opened {
    /// Change or thickness (m), 0 where the file has no data.
    raster: Raster,
    law: OpenedLaw,
}

enum OpenedLaw {
    AtOnce,
    Share(Series),
    Slide { path: Vec<Vec2>, velocity: Series },
}

/// Opens the files of each; none where one failed.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Vec<Option<Opened>> {
    scenario.moving_bed.iter().map(|bed| open_one(bed, scenario, crs, findings)).collect()
}

fn open_one(bed: &MovingBed, scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Option<Opened> {
    let read = raster::read_heights(&bed.raster, bed.unit, scenario, crs, findings);
    // Every file is opened, so that one check reports all.
    let law = match &bed.law {
        BedMovement::InPlace(None) => Some(OpenedLaw::AtOnce),
        BedMovement::InPlace(Some(share)) => series::growth(share, findings).map(OpenedLaw::Share),
        BedMovement::Slide { path, velocity } => {
            // Behind its last row the velocity stays as it is; the line ends the slide.
            let negative = Some("give a velocity of 0 or more: the slide goes along its line, and not back");
            let meaning = rows::Meaning { dimension: &VELOCITY, negative };
            let velocity = series::series(velocity, meaning, (0.0, Origin::Own), findings);
            let features = places::features(path, crs, findings)?;
            let lines: Vec<Vec<Vec2>> = features.iter().flat_map(lines_of).collect();
            let [line] = &lines[..] else {
                let message =
                    format!("{} holds {} lines; a slide runs along one", path.value.path.display(), lines.len());
                let remedy = "draw one line from the middle of the slide to where its middle comes to rest";
                findings.add(path, input_error("slide-lines", message).with_remedy(remedy));
                return None;
            };
            velocity.map(|velocity| OpenedLaw::Slide { path: line.clone(), velocity })
        }
    };
    if bed.at.value >= scenario.end_time {
        let message =
            format!("the bed begins to move at {} s, when the run has ended at {} s", bed.at.value, scenario.end_time);
        let problem = Problem::error(ProblemKind::Scenario, "moves-after-end", "", message);
        findings.add(&bed.at, problem.with_remedy("let it begin earlier, or the run last longer (`time.end`)"));
        return None;
    }
    let mut raster = read?;
    raster.values.iter_mut().for_each(|value| *value = if value.is_nan() { 0.0 } else { *value * bed.unit });
    findings.add_all(&bed.raster, doubtful_change(bed, &raster));
    let negative = raster.values.iter().position(|value| *value < 0.0);
    if let (Some(index), BedMovement::Slide { .. }) = (negative, &bed.law) {
        let message = format!("{} has a thickness below 0", bed.raster.value.display());
        let problem = input_error("negative-value", message)
            .with_remedy("give the thickness of the slide, 0 or no data beside it; a change of both signs is `change`")
            .with_at(raster.centre(index % raster.columns, index / raster.columns));
        findings.add(&bed.raster, problem);
        return None;
    }
    Some(Opened { raster, law: law? })
}

/// The problem of a change of the bed (m) as none is.
fn doubtful_change(bed: &MovingBed, raster: &Raster) -> Option<Problem> {
    let index = raster.values.iter().position(|value| value.abs() > DOUBTFUL_CHANGE)?;
    let message = format!(
        "{} moves the bed by {:.1} m, more than any ground does",
        bed.raster.value.display(),
        raster.values[index]
    );
    let is_implausible = raster.values.iter().any(|value| value.abs() > GREATEST_CHANGE);
    let problem = if is_implausible {
        input_error("implausible-value", message)
    } else {
        input_warning("doubtful-change", message)
    };
    let problem = problem
        .with_cause("a fill value that the file does not declare as nodata, or another `unit`")
        .with_remedy("declare the fill value with `gdal_edit.py -a_nodata`, or give the `unit` of the raster")
        .with_at(raster.centre(index % raster.columns, index / raster.columns));
    Some(problem)
}

/// The motions on the lattice, as far as they fit.
pub fn on_lattice(
    opened: Vec<Option<Opened>>,
    scenario: &Scenario,
    (ground, forcing): (&BedParticles, &Forcing),
    findings: &mut Findings,
) -> Vec<BedMotion> {
    let mut motions = Vec::new();
    for (opened, written) in opened.into_iter().zip(&scenario.moving_bed) {
        let Some(Opened { raster, law }) = opened else { continue };
        let found = match law {
            OpenedLaw::Slide { path, velocity } => slide(&raster, path, velocity, written, scenario, ground, findings),
            law => in_place(&raster, law, written, scenario, ground, findings),
        };
        if let Some(motion) = found
            && fits(&motion, written, ground, forcing, findings)
        {
            motions.push(motion);
        }
    }
    motions
}

fn at(lattice: &Lattice, cell: usize) -> Vec2 {
    lattice.to_map(lattice.centre(cell))
}

fn changes_nothing(message: &str, raster: &Raster) -> Problem {
    let cause = format!(
        "it reaches from {:.0}, {:.0} to {:.0}, {:.0}",
        raster.west,
        raster.south(),
        raster.east(),
        raster.north
    );
    let problem = input_error("moves-nothing", message.to_owned()).with_cause(cause);
    problem.with_remedy("check its unit, its no-data value, and that it has the CRS of the terrain")
}

/// Whether nothing else needs the bed of its cells as it is: a dam that breaks, a boundary with a condition, a channel.
fn fits(
    motion: &BedMotion,
    written: &MovingBed,
    ground: &BedParticles,
    forcing: &Forcing,
    findings: &mut Findings,
) -> bool {
    let lattice = &ground.lattice;
    let moves = |cell: usize| {
        let k = motion.cells.binary_search_by_key(&cell, |cell| cell.0).ok()?;
        let centre = lattice.centre(cell);
        let ever = match &motion.law {
            BedLaw::Slide(slide) => {
                let steps = (4.0 * slide.length() / lattice.spacing).ceil().max(1.0);
                let offsets = (0..=steps as usize).map(|step| slide.offset(slide.length() * step as f64 / steps));
                offsets.map(|offset| slide.thickness.at(centre - offset)).fold(0.0, f64::max)
            }
            BedLaw::AtOnce | BedLaw::Share(_) => motion.cells[k].1.abs(),
        };
        (ever > NO_CHANGE).then_some(cell)
    };
    let mut refuse = |cell: usize, code: &'static str, what: &str, remedy: &str| {
        let problem = input_error(code, format!("the bed moves {what}")).with_remedy(remedy);
        findings.add(&written.raster, problem.with_at(at(lattice, cell)));
    };
    let dam = forcing.breach.iter().flat_map(|breach| breach.beds(0.0)).find_map(|(cell, _)| moves(cell));
    if let Some(cell) = dam {
        refuse(cell, "moves-dam", "under the dam of `breach`, whose own bed falls", "keep it off the dam");
        return false;
    }
    let opens = |face: &&EdgeFace| {
        let is_open = forcing.boundary_at(face.middle, face.middle - lattice.centre(face.cell)).is_some()
            && !ground.is_sealed(face.middle);
        is_open || forcing.channel_joins_at(face.middle)
    };
    let faces = edge_faces(lattice, &ground.elevation);
    if let Some(cell) = faces.iter().filter(opens).find_map(|face| moves(face.cell)) {
        let what = "at a boundary with a condition, or where a channel joins";
        refuse(cell, "moves-boundary", what, "keep it off that part of the edge, or move the boundary further away");
        return false;
    }
    true
}
