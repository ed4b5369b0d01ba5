//! A bed that moves: its rasters and lines, the cells that it may change, and whether it fits what else stands there.

use std::collections::BTreeSet;

use crate::bed::BedParticles;
use crate::boundary::edge_faces;
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::{Vec2, readable};
use crate::prepare::findings::Findings;
use crate::prepare::forcing::sources::lines_of;
use crate::prepare::outside::{Outside, all_outside};
use crate::prepare::places;
use crate::prepare::raster;
use crate::prepare::tables::dates::Origin;
use crate::prepare::tables::{rows, series};
use crate::scenario::units::VELOCITY;
use crate::scenario::{BedMovement, MovingBed, Scenario, Timed};
use crate::solver::{BedLaw, BedMotion, Forcing, Patch, Series, Slide};
use crate::terrain::Raster;

/// Change of the bed (m) that counts as none: what rasters of single precision leave of a difference.
const NO_CHANGE: f64 = 1e-6;
/// Change of the bed (m) beyond which it is rather a fill value or another unit: no ground moves so far.
const DOUBTFUL_CHANGE: f64 = 1000.0;
/// Share of a volume that the lattice may add or lose.
const OTHER_VOLUME: f64 = 0.02;
/// Share of its mean thickness by which a slide may come to rest above where it began: the bed of the particles is smooth, and
/// under a steep edge it lies as far off.
const CLIMB: f64 = 0.5;

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
            let features = places::features(path, crs, scenario.reproject, findings)?;
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
    if let Some(index) = raster.values.iter().position(|value| value.abs() > DOUBTFUL_CHANGE) {
        let message = format!(
            "{} moves the bed by {:.1} m, more than any ground does",
            bed.raster.value.display(),
            raster.values[index]
        );
        let problem = Problem::warning(ProblemKind::Input, "doubtful-change", "", message)
            .with_cause("a fill value that the file does not declare as nodata, or another `unit`")
            .with_remedy("declare the fill value with `gdal_edit.py -a_nodata`, or give the `unit` of the raster")
            .with_at(raster.centre(index % raster.columns, index / raster.columns));
        findings.add(&bed.raster, problem);
    }
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

/// Ground that rises or sinks where it is.
fn in_place(
    raster: &Raster,
    law: OpenedLaw,
    written: &MovingBed,
    scenario: &Scenario,
    ground: &BedParticles,
    findings: &mut Findings,
) -> Option<BedMotion> {
    let lattice = &ground.lattice;
    let change = |cell: usize| Some((cell, raster.elevation(at(lattice, cell))?)).filter(|c| c.1.abs() > NO_CHANGE);
    let (cells, bare): (Vec<_>, Vec<_>) =
        (0..lattice.len()).filter_map(change).partition(|(cell, _)| ground.has_terrain(*cell));
    let name = written.raster.value.display();
    if cells.is_empty() {
        findings.add(&written.raster, changes_nothing(&format!("{name} changes no cell of the terrain"), raster));
        return None;
    }
    if let Some(&(first, _)) = bare.first() {
        let area = bare.len() as f64 * lattice.cell_area();
        let message = format!("{name} changes {} cells ({area} m²) where there is no terrain", bare.len());
        let problem = Problem::warning(ProblemKind::Input, "moves-without-terrain", "", message)
            .with_remedy("nothing, if no water comes there; otherwise give the terrain there")
            .with_at(at(lattice, first));
        findings.add(&written.raster, problem);
    }
    findings.add_all(&written.raster, change_outside(raster, &name.to_string(), lattice));
    findings.add_all(&written.raster, change_volume(raster, &name.to_string(), cells.iter().chain(&bare), lattice));
    let law = match law {
        OpenedLaw::Share(series) => {
            let lasts = series.points().last().map_or(0.0, |point| point.0);
            let end = written.at.value + lasts;
            if let (true, BedMovement::InPlace(Some(share))) = (end > scenario.end_time, &written.law) {
                let message =
                    format!("the bed still moves when the run ends at {} s: it ends at {end} s", scenario.end_time);
                let problem = Problem::warning(ProblemKind::Scenario, "moves-at-end", "", message);
                findings.add(&share.file, problem.with_remedy("let the run last longer, if the final bed matters"));
            }
            BedLaw::Share(series)
        }
        _ => BedLaw::AtOnce,
    };
    Some(BedMotion { begin: written.at.value, cells, law })
}

/// What of the change of a raster lies beside the model, where it is a part worth a word.
fn change_outside(raster: &Raster, name: &str, lattice: &Lattice) -> Option<Problem> {
    let place = |index: usize| raster.centre(index % raster.columns, index / raster.columns);
    let changed = (0..raster.values.len()).filter(|&index| raster.values[index].abs() > NO_CHANGE);
    let is_beside = |index: &usize| lattice.cell_at(lattice.to_local(place(*index))).is_none();
    let volume = |index: &usize| raster.values[*index].abs() * raster.cell_x * raster.cell_y;
    let (beside, within): (Vec<usize>, Vec<usize>) = changed.partition(is_beside);
    let [lost, kept] = [&beside, &within].map(|cells| cells.iter().map(volume).sum::<f64>());
    let largest = beside.iter().copied().max_by(|a, b| volume(a).total_cmp(&volume(b)))?;
    (lost > OTHER_VOLUME * (lost + kept)).then(|| {
        let area = beside.len() as f64 * raster.cell_x * raster.cell_y;
        let message = format!(
            "{:.0} % of the volume that {name} moves, on {area} m², lie outside the terrain",
            100.0 * lost / (lost + kept)
        );
        Problem::warning(ProblemKind::Input, "moves-without-terrain", "", message)
            .with_cause("the model ends before the bed stops to move, and the waves from beyond do not come in")
            .with_remedy("nothing, if they do not matter; otherwise give a terrain that holds all of it")
            .with_at(place(largest))
    })
}

/// What the lattice makes of the volumes that a raster raises and lowers, where that is another volume.
fn change_volume<'a>(
    raster: &Raster,
    name: &str,
    cells: impl Iterator<Item = &'a (usize, f64)>,
    lattice: &Lattice,
) -> Option<Problem> {
    // Coarser cells the lattice knows by several places each.
    if raster.cell_x.min(raster.cell_y) >= 2.0 * lattice.spacing {
        return None;
    }
    let add = |sums: [f64; 2], volume: f64| [sums[0] + volume.max(0.0), sums[1] - volume.min(0.0)];
    let on_lattice = cells.map(|(_, change)| change * lattice.cell_area()).fold([0.0; 2], add);
    let (width, height) = (lattice.columns as f64 * lattice.spacing, lattice.rows as f64 * lattice.spacing);
    // What lies beside the lattice changes nothing there, and is not missed.
    let volume = |index: usize| {
        let centre = lattice.to_local(raster.centre(index % raster.columns, index / raster.columns));
        let within = |middle: f64, cell: f64, size: f64| {
            ((middle + 0.5 * cell).min(size) - (middle - 0.5 * cell).max(0.0)).max(0.0)
        };
        let area = within(centre.x, raster.cell_x, width) * within(centre.y, raster.cell_y, height);
        raster.values[index] * area
    };
    let changed = (0..raster.values.len()).filter(|&index| raster.values[index].abs() > NO_CHANGE);
    let wanted = changed.map(volume).fold([0.0; 2], add);
    let misfit = (on_lattice[0] - wanted[0]).abs() + (on_lattice[1] - wanted[1]).abs();
    (misfit > OTHER_VOLUME * (wanted[0] + wanted[1])).then(|| {
        let message = format!(
            "on the lattice {name} raises {:.4e} m³ and lowers {:.4e} m³; in the file it is {:.4e} m³ and {:.4e} m³",
            on_lattice[0], on_lattice[1], wanted[0], wanted[1]
        );
        let largest =
            (0..raster.values.len()).max_by(|a, b| raster.values[*a].abs().total_cmp(&raster.values[*b].abs()));
        let problem = Problem::warning(ProblemKind::Input, "change-volume", "", message)
            .with_cause("it is finer than the resolution: each cell takes the change at its centre")
            .with_remedy("take a finer `resolution`, or a raster of the means over its cells");
        match largest {
            Some(index) => problem.with_at(raster.centre(index % raster.columns, index / raster.columns)),
            None => problem,
        }
    })
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

/// A slide: its thickness as a patch, and the cells over which it may come until the end of the run.
fn slide(
    raster: &Raster,
    path: Vec<Vec2>,
    velocity: Series,
    written: &MovingBed,
    scenario: &Scenario,
    ground: &BedParticles,
    findings: &mut Findings,
) -> Option<BedMotion> {
    let lattice = &ground.lattice;
    let name = written.raster.value.display();
    let Some(thickness) = patch(raster, lattice) else {
        findings.add(&written.raster, changes_nothing(&format!("{name} has no thickness anywhere"), raster));
        return None;
    };
    let path: Vec<Vec2> = path.into_iter().map(|place| lattice.to_local(place)).collect();
    let slide = Slide { thickness, path, velocity };
    let lasts = scenario.end_time - written.at.value;
    let distance = slide.distance(lasts);
    let BedMovement::Slide { path: line, velocity: of_time } = &written.law else { return None };
    if distance <= 0.0 {
        let message = "the slide does not move before the run ends".to_owned();
        let problem = input_error("slide-rests", message);
        findings.add(line, problem.with_remedy("give it a velocity above 0, and a line of some length"));
        return None;
    }
    if Outside::beyond_reach(slide.path.windows(2).map(|pair| [pair[0], pair[1]]), ground).is_all() {
        all_outside(line, lattice.to_map(slide.path[0]), findings);
        return None;
    }
    if let Timed::Series(table) = of_time {
        findings.add_all(&table.file, held(&slide, lasts, &table.file.value.display().to_string()));
    }
    let all = swept(&slide, distance, lattice);
    let thickness_at = |cell: usize, offset: Vec2| slide.thickness.at(lattice.centre(cell) - offset);
    check_path(&slide, distance, (&all, &thickness_at), (written, ground), findings);
    // What of the slide lies on terrain, at its beginning and at its end, against all of it.
    let whole = slide.thickness.values.iter().sum::<f64>() * slide.thickness.cell.x * slide.thickness.cell.y;
    for (moment, offset) in [("at its start", Vec2::ZERO), ("where it comes to rest", slide.offset(distance))] {
        let on_terrain = all.iter().filter(|cell| ground.has_terrain(**cell));
        let lies = on_terrain.map(|&cell| thickness_at(cell, offset)).sum::<f64>() * lattice.cell_area();
        let middle = slide.thickness.extent();
        let place = lattice.to_map((middle[0] + middle[1]) * 0.5 + offset);
        if lies <= 0.0 {
            let message = format!("{moment} the slide of {name} lies outside the terrain");
            let remedy = "check its line, and that raster and line have the CRS of the terrain";
            findings.add(line, input_error("slide-outside", message).with_remedy(remedy).with_at(place));
            return None;
        }
        if (lies - whole).abs() > OTHER_VOLUME * whole {
            let message =
                format!("{moment} {lies:.4e} m³ of the slide lie on the lattice, of {whole:.4e} m³ in {name}");
            let problem = Problem::warning(ProblemKind::Input, "slide-volume", "", message)
                .with_cause("it reaches beyond the terrain, or is finer than the resolution")
                .with_remedy("take a longer terrain, another line, or a finer `resolution`")
                .with_at(place);
            findings.add(&written.raster, problem);
        }
    }
    let cells = all.into_iter().filter(|&cell| ground.has_terrain(cell));
    let cells = cells.map(|cell| (cell, thickness_at(cell, Vec2::ZERO))).collect();
    Some(BedMotion { begin: written.at.value, cells, law: BedLaw::Slide(slide) })
}

/// The warning of a series that ends while its slide still moves, before that comes to the end of its line and the run to its own
/// (s since the beginning of the slide).
fn held(slide: &Slide, end: f64, name: &str) -> Option<Problem> {
    let (last, velocity) = slide.velocity.points().last()?;
    let left = slide.length() - slide.distance(last);
    let time = (left / velocity).min(end - last.max(0.0));
    (velocity > 0.0 && left > 0.0 && time > 0.0).then(|| {
        let message = format!(
            "{name} ends at {} s, before the slide rests; its last value of {} m/s holds on for {} s",
            readable(last),
            readable(velocity),
            readable(time)
        );
        let remedy = "add rows up to where it rests, the last of them with a velocity of 0";
        input_warning("series-held", message).with_remedy(remedy)
    })
}

/// Warns of a line that does not begin on its slide, and of one up which the slide would run.
fn check_path(
    slide: &Slide,
    distance: f64,
    (cells, thickness): (&BTreeSet<usize>, &impl Fn(usize, Vec2) -> f64),
    (written, ground): (&MovingBed, &BedParticles),
    findings: &mut Findings,
) {
    let BedMovement::Slide { path: line, .. } = &written.law else { return };
    let lattice = &ground.lattice;
    let Some((&begin, &end)) = slide.path.first().zip(slide.path.last()) else { return };
    let warning = |code, message: String| Problem::warning(ProblemKind::Input, code, "", message);
    if slide.thickness.at(begin) <= 0.0 {
        let problem =
            warning("path-beside-slide", "the line does not begin on the slide: it has no thickness there".to_owned())
                .with_cause("the slide goes the way of the line from where the raster has it, wherever the line lies")
                .with_remedy(
                    "draw the line from the middle of the slide to where its middle comes to rest, in this order",
                )
                .with_at(lattice.to_map(begin));
        findings.add(line, problem);
    }
    // Mean height (m) of the ground that the slide has under it; where it lies at the start the terrain holds the slide, too.
    let under = |offset: Vec2| {
        let bearing = cells.iter().filter(|cell| ground.has_terrain(**cell));
        let of = |&cell: &usize| (thickness(cell, offset), ground.elevation[cell] - thickness(cell, Vec2::ZERO));
        let (weight, sum) = bearing.map(of).fold((0.0, 0.0), |sums, (t, z)| (sums.0 + t, sums.1 + t * z));
        (weight > 0.0).then(|| sum / weight)
    };
    let filled: Vec<f64> = slide.thickness.values.iter().copied().filter(|t| *t > NO_CHANGE).collect();
    let mean = filled.iter().sum::<f64>() / filled.len().max(1) as f64;
    if let Some((from, to)) = under(Vec2::ZERO).zip(under(slide.offset(distance)))
        && to - from > CLIMB * mean
    {
        let message = format!(
            "the slide runs uphill: the ground under it is at {from:.2} m at its start and at {to:.2} m where it comes to rest"
        );
        let problem = warning("slide-uphill", message)
            .with_cause("the line is drawn backwards, perhaps, or the terrain does not hold the slide where it lies at the start")
            .with_remedy("draw the line from where the slide breaks off to where it comes to rest")
            .with_at(lattice.to_map(end));
        findings.add(line, problem);
    }
}

/// The part of a raster that is not 0, in local coordinates; none where there is none.
fn patch(raster: &Raster, lattice: &Lattice) -> Option<Patch> {
    let filled = (0..raster.values.len()).filter(|&i| raster.values[i] > NO_CHANGE);
    let (columns, rows): (BTreeSet<usize>, BTreeSet<usize>) =
        filled.map(|i| (i % raster.columns, i / raster.columns)).unzip();
    let (west, east) = (*columns.first()?, *columns.last()?);
    let (north, south) = (*rows.first()?, *rows.last()?);
    let values = (north..=south).rev().flat_map(|row| (west..=east).map(move |column| raster.value(column, row)));
    Some(Patch {
        first: lattice.to_local(raster.centre(west, south)),
        cell: Vec2::new(raster.cell_x, raster.cell_y),
        columns: east + 1 - west,
        values: values.collect(),
    })
}

/// The cells whose centres the rectangle around a slide passes on its way, and those around them.
fn swept(slide: &Slide, distance: f64, lattice: &Lattice) -> BTreeSet<usize> {
    let [low, high] = slide.thickness.extent();
    let s = lattice.spacing;
    let index = |x: f64, count: usize| ((x / s).floor().max(0.0) as usize).min(count - 1);
    let mut found = BTreeSet::new();
    let steps = (distance / s).ceil() as usize;
    for step in 0..=steps {
        let offset = slide.offset((step as f64 * s).min(distance));
        let (low, high) = (low + offset - Vec2::new(s, s), high + offset + Vec2::new(s, s));
        if high.x < 0.0 || high.y < 0.0 || low.x > s * lattice.columns as f64 || low.y > s * lattice.rows as f64 {
            continue;
        }
        for row in index(low.y, lattice.rows)..=index(high.y, lattice.rows) {
            found.extend(
                (index(low.x, lattice.columns)..=index(high.x, lattice.columns)).map(|c| lattice.index(c, row)),
            );
        }
    }
    found
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
    let opens = |face: &&(usize, Vec2)| {
        let is_open =
            forcing.boundary_at(face.1, face.1 - lattice.centre(face.0)).is_some() && !ground.is_sealed(face.1);
        is_open || forcing.channel_joins_at(face.1)
    };
    let faces = edge_faces(lattice, &ground.elevation);
    if let Some(cell) = faces.iter().filter(opens).find_map(|face| moves(face.0)) {
        let what = "at a boundary with a condition, or where a channel joins";
        refuse(cell, "moves-boundary", what, "keep it off that part of the edge, or move the boundary further away");
        return false;
    }
    true
}
