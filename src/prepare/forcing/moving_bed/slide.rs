//! Slides: their thickness on the lattice, the cells on their way, and whether line, volume and terrain fit.

use std::collections::BTreeSet;

use super::{NO_CHANGE, OTHER_VOLUME, changes_nothing};
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::lattice::Lattice;
use crate::math::{Vec2, readable};
use crate::prepare::findings::Findings;
use crate::prepare::outside::{Outside, all_outside};
use crate::scenario::{BedMovement, MovingBed, Scenario, Timed};
use crate::solver::{BedLaw, BedMotion, Patch, Series, Slide};
use crate::terrain::Raster;

/// Share of its mean thickness by which a slide may come to rest above where it began: the bed of the particles is smooth, and
/// under a steep edge it lies as far off.
const CLIMB: f64 = 0.5;

/// A slide: its thickness as a patch, and the cells over which it may come until the end of the run.
pub fn slide(
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
    if !check_volume(&slide, distance, (&all, &thickness_at), (written, ground), findings) {
        return None;
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

/// Whether a slide lies on terrain at its start and where it comes to rest; warns where only a part of its volume does.
fn check_volume(
    slide: &Slide,
    distance: f64,
    (cells, thickness): (&BTreeSet<usize>, &impl Fn(usize, Vec2) -> f64),
    (written, ground): (&MovingBed, &BedParticles),
    findings: &mut Findings,
) -> bool {
    let BedMovement::Slide { path: line, .. } = &written.law else { return false };
    let (lattice, name) = (&ground.lattice, written.raster.value.display());
    let whole = slide.thickness.values.iter().sum::<f64>() * slide.thickness.cell.x * slide.thickness.cell.y;
    for (moment, offset) in [("at its start", Vec2::ZERO), ("where it comes to rest", slide.offset(distance))] {
        let on_terrain = cells.iter().filter(|cell| ground.has_terrain(**cell));
        let lies = on_terrain.map(|&cell| thickness(cell, offset)).sum::<f64>() * lattice.cell_area();
        let middle = slide.thickness.extent();
        let place = lattice.to_map((middle[0] + middle[1]) * 0.5 + offset);
        if lies <= 0.0 {
            let message = format!("{moment} the slide of {name} lies outside the terrain");
            let remedy = "check its line, and that raster and line have the CRS of the terrain";
            findings.add(line, input_error("slide-outside", message).with_remedy(remedy).with_at(place));
            return false;
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
    true
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
