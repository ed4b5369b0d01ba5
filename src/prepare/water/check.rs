//! Bodies of still water against the terrain and against each other.

use geo::Area;

use super::SourcedBody;
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::prepare::StillBody;
use crate::prepare::findings::Findings;
use crate::prepare::polygons::{self, cells_inside, distance_to_outline};

/// A body of fewer cells than this is not resolved.
const RESOLVED_CELLS: usize = 16;
/// Cells without terrain at most this far from the outline (in cells) are a polygon that pokes out of the data, not a hole.
const RIM_OF_DATA: f64 = 2.0;
/// Share of a body's cells that may lie beyond the data in this way.
const TOLERATED_NODATA: f64 = 0.01;

/// Checks the bodies against the terrain and against each other, and cuts shared area out of the later of two of equal level.
pub fn check(bodies: &mut [SourcedBody], bed: &BedParticles, findings: &mut Findings) {
    let lattice = &bed.lattice;
    let mut owner = vec![usize::MAX; lattice.len()];
    for i in 0..bodies.len() {
        let cells = cells_inside(&bodies[i].body.polygon, lattice);
        if let Err(problem) = check_body(&bodies[i], &cells, bed, findings) {
            findings.add(bodies[i].source, problem);
        }
        let shared: Vec<usize> = cells.iter().copied().filter(|&cell| owner[cell] != usize::MAX).collect();
        if let Some(&cell) = shared.first() {
            let place = lattice.to_map(lattice.centre(cell));
            settle_overlap(bodies, owner[cell], i, place, shared.len(), findings);
        }
        for cell in cells {
            if owner[cell] == usize::MAX {
                owner[cell] = i;
            }
        }
    }
}

/// A body against the terrain below it.
fn check_body(body: &SourcedBody, cells: &[usize], bed: &BedParticles, findings: &mut Findings) -> Result<(), Problem> {
    let name = body.source.value.path.display();
    let (level, lattice) = (body.body.level, &bed.lattice);
    let map = |cell: usize| lattice.to_map(lattice.centre(cell));
    if lies_outside(&body.body, lattice) {
        return Err(input_error("outside-terrain", format!("the polygon of {name} lies outside the terrain"))
            .with_remedy("check that the file and the terrain have the same CRS")
            .with_at(first_place(&body.body)));
    }
    if cells.is_empty() {
        let message = format!(
            "the polygon of {name} ({:.0} m²) holds no cell of {} m",
            body.body.polygon.unsigned_area(),
            lattice.spacing
        );
        return Err(input_error("resolution-too-coarse", message).with_remedy("take a finer resolution"));
    }
    check_nodata(body, cells, bed, findings)?;
    let lowest = cells
        .iter()
        .copied()
        .filter(|&cell| !bed.elevation[cell].is_nan())
        .min_by(|&a, &b| bed.elevation[a].total_cmp(&bed.elevation[b]));
    let Some(lowest) = lowest else {
        return Err(input_error(
            "nodata-in-water",
            format!("the terrain has no data anywhere in the polygon of {name}"),
        )
        .with_remedy("check that the file and the terrain have the same CRS, or add a terrain layer below")
        .with_at(map(cells[0])));
    };
    if bed.elevation[lowest] >= level {
        let message = format!("the level of {level} m lies below the bed everywhere in the polygon of {name}");
        return Err(input_error("level-below-bed", message)
            .with_cause(format!("its lowest bed is {:.2} m", bed.elevation[lowest]))
            .with_remedy("check the level, its unit, and the vertical datum of the terrain")
            .with_at(map(lowest)));
    }
    let wet = cells.iter().filter(|&&cell| bed.elevation[cell] < level).count();
    if wet < RESOLVED_CELLS {
        let message = format!("only {wet} cells of {} m hold the water of {name}", lattice.spacing);
        let problem = Problem::warning(ProblemKind::Scenario, "resolution-too-coarse", "", message);
        findings.add(body.source, problem.with_remedy("take a finer resolution"));
    }
    Ok(())
}

/// An error for holes in the terrain under the water; a warning for a polygon that pokes out of the data a little.
fn check_nodata(
    body: &SourcedBody,
    cells: &[usize],
    bed: &BedParticles,
    findings: &mut Findings,
) -> Result<(), Problem> {
    let lattice = &bed.lattice;
    let map = |cell: usize| lattice.to_map(lattice.centre(cell));
    let is_missing = |cell: usize| bed.elevation[cell].is_nan() && bed.sealed.binary_search(&cell).is_err();
    let missing: Vec<usize> = cells.iter().copied().filter(|&cell| is_missing(cell)).collect();
    // Cells beyond the lattice are missing, too; the polygon's area tells of them.
    let beyond = body.body.polygon.unsigned_area() - (cells.len() - missing.len()) as f64 * lattice.cell_area();
    let area = beyond.max(missing.len() as f64 * lattice.cell_area());
    let deep = |cell: usize| distance_to_outline(&body.body.polygon, map(cell)) > RIM_OF_DATA * lattice.spacing;
    let hole = missing.iter().copied().find(|&cell| deep(cell));
    let tolerated = TOLERATED_NODATA * body.body.polygon.unsigned_area() + rim_allowance(&body.body, lattice);
    let name = body.source.value.path.display();
    let lies = match missing.len() {
        0 => "beyond its edge".to_owned(),
        count => format!("{count} cells of the lattice"),
    };
    let message = format!("the terrain has no data on {area:.0} m² inside the polygon of {name} ({lies})");
    if hole.is_some() || area > tolerated {
        let place = hole.or(missing.first().copied()).map_or(first_place(&body.body), map);
        return Err(input_error("nodata-in-water", message)
            .with_remedy(
                "fill the holes with `gdal_fillnodata.py`, add a layer below, or cut the polygon to the terrain",
            )
            .with_at(place));
    }
    if let Some(&first) = missing.first() {
        let problem = Problem::warning(ProblemKind::Input, "polygon-beyond-data", "", message);
        findings.add(
            body.source,
            problem.with_cause("its outline pokes out of the data by less than two cells").with_at(map(first)),
        );
    }
    Ok(())
}

/// Area (m²) by which counting cells may miss the area of a polygon: half a cell along its outline.
fn rim_allowance(body: &StillBody, lattice: &Lattice) -> f64 {
    use geo::{Euclidean, Length};
    let outline: f64 = body.polygon.iter().map(|p| Euclidean.length(p.exterior())).sum();
    0.5 * lattice.spacing * outline
}

fn lies_outside(body: &StillBody, lattice: &Lattice) -> bool {
    use geo::BoundingRect;
    let size = lattice.size();
    body.polygon.bounding_rect().is_none_or(|rectangle| {
        let min = lattice.to_local(Vec2::new(rectangle.min().x, rectangle.min().y));
        let max = lattice.to_local(Vec2::new(rectangle.max().x, rectangle.max().y));
        max.x < 0.0 || max.y < 0.0 || min.x > size.x || min.y > size.y
    })
}

fn first_place(body: &StillBody) -> Vec2 {
    use geo::CoordsIter;
    body.polygon.coords_iter().next().map_or(Vec2::ZERO, |c| Vec2::new(c.x, c.y))
}

/// Two bodies that share cells: refused at different levels; at equal levels the later one loses what they share.
fn settle_overlap(
    bodies: &mut [SourcedBody],
    first: usize,
    second: usize,
    place: Vec2,
    cells: usize,
    findings: &mut Findings,
) {
    let (one, other) = (&bodies[first], &bodies[second]);
    if (one.body.level - other.body.level).abs() > 0.0 {
        let message = format!(
            "the water of {} (level {} m) and that of {} (level {} m) overlap in {cells} cells",
            one.source.value.path.display(),
            one.body.level,
            other.source.value.path.display(),
            other.body.level
        );
        findings.add(
            other.source,
            input_error("overlapping-water", message).with_remedy("cut one polygon to the other").with_at(place),
        );
        return;
    }
    for earlier in 0..second {
        if (bodies[earlier].body.level - bodies[second].body.level).abs() > 0.0 {
            continue;
        }
        bodies[second].body.polygon = polygons::without(&bodies[second].body.polygon, &bodies[earlier].body.polygon);
    }
}
