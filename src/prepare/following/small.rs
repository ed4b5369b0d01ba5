//! Blocked buildings that get lost where squares stay as they are.

use crate::bed::BedParticles;
use crate::error::input_warning;
use crate::math::{Rectangle, Vec2};
use crate::partition::Line;
use crate::prepare::findings::Findings;
use crate::scenario::Scenario;

/// Warns of buildings that hold the centre of no square among those that stay: there water passes where they stand.
pub fn report(
    scenario: &Scenario,
    outlines: &[Vec<Line>],
    (bed, kept): (&BedParticles, &[bool]),
    findings: &mut Findings,
) {
    let Some(buildings) = &scenario.ground.buildings else { return };
    let lattice = &bed.lattice;
    let is_lost = |outline: &&Vec<Line>| {
        let Some(ring) = outline.first() else { return false };
        let Some(Rectangle { low, high }) = Rectangle::about(ring.points.iter().copied()) else { return false };
        let square = |place: f64, count: usize| ((place / lattice.spacing).max(0.0) as usize).min(count);
        let rows = square(low.y, lattice.rows)..(square(high.y, lattice.rows) + 1).min(lattice.rows);
        let columns = square(low.x, lattice.columns)..(square(high.x, lattice.columns) + 1).min(lattice.columns);
        let near = rows.flat_map(|row| columns.clone().map(move |column| lattice.index(column, row)));
        let about: Vec<usize> = near.filter(|&square| is_touched(ring, square, bed)).collect();
        !about.is_empty() && about.iter().all(|&square| kept[square] && bed.has_terrain(square))
    };
    let lost: Vec<&Vec<Line>> = outlines.iter().filter(is_lost).collect();
    if let Some(place) = lost.first().and_then(|outline| outline.first()?.points.first()) {
        let message = format!(
            "{} of {} buildings of {} lie where cells stay squares, hold the centre of none and are left out",
            lost.len(),
            outlines.len(),
            buildings.polygons.value.path.display()
        );
        let problem = input_warning("building-too-small", message)
            .with_cause("cells follow no outline at open edges, dams, levees, channel mouths and moving beds")
            .with_remedy("choose a finer `resolution`, or merge the buildings of a block, if they matter")
            .with_at(lattice.to_map(*place));
        findings.add(&buildings.polygons, problem);
    }
}

/// Whether a ring reaches into a square that has terrain or had it before the building.
fn is_touched(ring: &Line, square: usize, bed: &BedParticles) -> bool {
    let lattice = &bed.lattice;
    let (centre, half) = (lattice.centre(square), 0.5 * lattice.spacing);
    let is_inside = |place: Vec2| (place.x - centre.x).abs() < half && (place.y - centre.y).abs() < half;
    let reaches = |ends: &[Vec2]| {
        let count = ((ends[1] - ends[0]).norm() / (0.1 * lattice.spacing)).ceil().max(1.0) as usize;
        (0..=count).any(|k| is_inside(ends[0] + (ends[1] - ends[0]) * (k as f64 / count as f64)))
    };
    ring.points.windows(2).any(reaches) && (bed.has_terrain(square) || super::kept::is_built(bed, square))
}
