//! Holes of the terrain: cells without data that terrain encloses. Refused, filled from their rim, or left as walls.
//!
//! Cells that meet at a corner belong to one hole, and one that reaches the edge of the lattice is none: the ragged outline of
//! a survey is no hole. A cell c is filled with the mean of the rim cells k, those with terrain around the hole,
//!
//! ```text
//! (M16)  z_c = Σ_k z_k / r_ck² / Σ_k 1 / r_ck²
//! ```

use super::change::{Change, Made};
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind};
use crate::lattice::Lattice;
use crate::output::SetBy;
use crate::prepare::findings::Findings;
use crate::scenario::{Gaps, Scenario};

/// Holes that are listed with their place.
const LISTED: usize = 5;
/// Share of the terrain below which a part of it belongs to a ragged outline.
const LEAST_PART: f64 = 0.01;
/// A seam is so many cells wide at most on either side of a cell.
const SEAM: isize = 5;

/// What the scenario makes of the holes of the bed; where it says nothing they are walls, which is reported.
pub fn fill(scenario: &Scenario, bed: &BedParticles, findings: &mut Findings) -> Vec<Change> {
    let gaps = scenario.ground.gaps.as_ref();
    if gaps.is_some_and(|gaps| gaps.value == Gaps::Wall) {
        return Vec::new();
    }
    let mut holes = holes(&bed.lattice, |cell| !bed.has_terrain(cell));
    holes.sort_by_key(|hole| std::cmp::Reverse(hole.len()));
    let (Some(largest), Some(last)) = (holes.first(), scenario.layers.last()) else { return Vec::new() };
    let error = |code, message: String| Problem::error(ProblemKind::Input, code, "", message);
    let at = bed.lattice.to_map(bed.lattice.centre(largest[largest.len() / 2]));
    let remedy = format!(
        "add a layer below, write `terrain.gaps: {{fill: idw, max_cells: {}}}` to fill them, or `terrain.gaps: wall` to keep them as walls",
        largest.len()
    );
    let Some(source) = gaps else {
        let message = format!("water goes around {}", described(&holes, &bed.lattice));
        let problem = Problem::warning(ProblemKind::Input, "terrain-gaps", "", message)
            .with_cause("cells without data are walls where `terrain.gaps` says nothing");
        findings.add(last, problem.with_remedy(remedy).with_at(at));
        return Vec::new();
    };
    match source.value {
        Gaps::Wall => {}
        Gaps::Refuse => {
            let problem = error("terrain-gaps", format!("the terrain has {}", described(&holes, &bed.lattice)));
            findings.add(source, problem.with_remedy(remedy).with_at(at));
        }
        Gaps::Fill { max_cells } => {
            let too_large: Vec<Vec<usize>> = holes.iter().filter(|hole| hole.len() > max_cells).cloned().collect();
            if !too_large.is_empty() {
                let message = format!(
                    "{} of more than {max_cells} cells, too large to be filled",
                    described(&too_large, &bed.lattice)
                );
                let problem = error("gap-too-large", message)
                    .with_remedy(format!("add a layer below, or raise `max_cells` to {}", largest.len()))
                    .with_at(at);
                findings.add(source, problem);
                return Vec::new();
            }
            let message = format!("filled from their rim: {}", described(&holes, &bed.lattice));
            let problem = Problem::warning(ProblemKind::Input, "gaps-filled", "", message)
                .with_cause("the terrain in them is made up from what surrounds it")
                .with_at(at);
            findings.add(source, problem);
            let levels = holes.iter().flat_map(|hole| filled(hole, bed));
            let change = |(cell, level)| Change { cell, made: Made::Fill(level), by: SetBy::FilledGap };
            return levels.map(change).collect();
        }
    }
    Vec::new()
}

/// Tells of cells without data between two parts of the terrain: they would stand as a wall in the flood. Where no layer is cut only
/// those between parts that hang together nowhere, because the outline of a survey is ragged.
pub fn check_seams(scenario: &Scenario, bed: &BedParticles, findings: &mut Findings) {
    let gaps = scenario.ground.gaps.as_ref().map(|gaps| &gaps.value);
    let clip = scenario.layers.iter().find_map(|layer| layer.value.clip());
    let (Some(last), false) = (scenario.layers.last(), clip.is_none() && gaps == Some(&Gaps::Wall)) else { return };
    let lattice = &bed.lattice;
    // What a layer that is cut leaves may be small.
    let parts = parts(bed, if clip.is_some() { 0.0 } else { LEAST_PART });
    let part = |column: isize, row: isize| {
        let inside = (0..lattice.columns as isize).contains(&column) && (0..lattice.rows as isize).contains(&row);
        inside.then(|| parts[lattice.index(column as usize, row as usize)]).flatten()
    };
    let is_seam = |cell: &usize| {
        let (column, row) = lattice.column_row(*cell);
        let (column, row) = (column as isize, row as isize);
        let nearest = |dc: isize, dr: isize| (1..=SEAM).find_map(|k| part(column + k * dc, row + k * dr));
        let divides = |dc: isize, dr: isize| match (nearest(dc, dr), nearest(-dc, -dr)) {
            (Some(one), Some(other)) => clip.is_some() || one != other,
            _ => false,
        };
        !bed.has_terrain(*cell) && (divides(1, 0) || divides(0, 1))
    };
    let seam: Vec<usize> = (0..lattice.len()).filter(is_seam).collect();
    let Some(&middle) = seam.get(seam.len() / 2) else { return };
    let kind = if gaps == Some(&Gaps::Refuse) { Problem::error } else { Problem::warning };
    let message = format!("{} cells between parts of the terrain have no data, and are walls", seam.len());
    let problem =
        kind(ProblemKind::Input, "seam-without-data", "", message).with_at(lattice.to_map(lattice.centre(middle)));
    match clip {
        Some(clip) => findings.add(
            clip,
            problem.with_cause("a layer that is cut ends at the outline of its polygon, a raster half a cell before it").with_remedy(
                "let the layers overlap: draw the polygon of `clip` two cells of the layer wider, or put a layer below",
            ),
        ),
        None => findings.add(
            last,
            problem.with_cause("layers, or the tiles of a mosaic, that do not meet").with_remedy(
                "give layers that meet or overlap, put one below that covers the seam, or write `terrain.gaps: wall` where it is meant so",
            ),
        ),
    }
}

/// Of each cell the part of the terrain that it belongs to, by its first cell, within which water gets everywhere over faces; none without terrain, and in
/// a part of less than this share of it.
fn parts(bed: &BedParticles, least_share: f64) -> Vec<Option<usize>> {
    let lattice = &bed.lattice;
    let is_terrain = |cell: usize| bed.has_terrain(cell);
    let share_a_face = |cell: usize, other: usize| {
        let ((column, row), (other_column, other_row)) = (lattice.column_row(cell), lattice.column_row(other));
        column == other_column || row == other_row
    };
    let regions = regions(lattice, is_terrain, share_a_face);
    let least = least_share * regions.iter().map(Vec::len).sum::<usize>() as f64;
    let mut parts = vec![None; lattice.len()];
    for region in regions.iter().filter(|region| region.len() as f64 >= least) {
        region.iter().for_each(|&cell| parts[cell] = Some(region[0]));
    }
    parts
}

/// Number and sizes of holes in words, the largest first.
fn described(holes: &[Vec<usize>], lattice: &Lattice) -> String {
    let place = |hole: &Vec<usize>| {
        let centre = lattice.to_map(lattice.centre(hole[hole.len() / 2]));
        let cells = if hole.len() == 1 { "cell" } else { "cells" };
        format!(
            "{} {cells} ({:.0} m²) at {:.1}, {:.1}",
            hole.len(),
            hole.len() as f64 * lattice.cell_area(),
            centre.x,
            centre.y
        )
    };
    let mut list = holes.iter().take(LISTED).map(place).collect::<Vec<_>>().join("; ");
    if holes.len() > LISTED {
        list += &format!("; and {} more", holes.len() - LISTED);
    }
    format!("{} {} without data: {list}", holes.len(), if holes.len() == 1 { "hole" } else { "holes" })
}

/// The holes among the cells without terrain, each with its cells in ascending order.
pub fn holes(lattice: &Lattice, is_without: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    let is_at_edge = |cell: &usize| {
        let (column, row) = lattice.column_row(*cell);
        column == 0 || row == 0 || column + 1 == lattice.columns || row + 1 == lattice.rows
    };
    let mut holes = regions(lattice, is_without, |_, _| true);
    holes.retain(|hole| !hole.iter().any(is_at_edge));
    holes.iter_mut().for_each(|hole| hole.sort_unstable());
    holes
}

/// The regions of cells of a kind that hang together, by their first cells: of neighbours, corners included, those that `meet`.
fn regions(
    lattice: &Lattice,
    is_of_kind: impl Fn(usize) -> bool,
    meet: impl Fn(usize, usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut seen: Vec<bool> = (0..lattice.len()).map(|cell| !is_of_kind(cell)).collect();
    let mut regions = Vec::new();
    for start in 0..lattice.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let mut region = vec![start];
        let mut next = 0;
        while let Some(&cell) = region.get(next) {
            next += 1;
            for other in around(cell, lattice) {
                if !seen[other] && meet(cell, other) {
                    seen[other] = true;
                    region.push(other);
                }
            }
        }
        regions.push(region);
    }
    regions
}

/// The up to eight neighbours of a cell.
pub fn around(cell: usize, lattice: &Lattice) -> impl Iterator<Item = usize> + '_ {
    let (column, row) = lattice.column_row(cell);
    let columns = column.saturating_sub(1)..(column + 2).min(lattice.columns);
    let rows = row.saturating_sub(1)..(row + 2).min(lattice.rows);
    rows.flat_map(move |row| columns.clone().map(move |column| lattice.index(column, row)))
        .filter(move |&other| other != cell)
}

/// The elevation (m) of each cell of a hole by (M16).
fn filled(hole: &[usize], bed: &BedParticles) -> Vec<(usize, f64)> {
    let lattice = &bed.lattice;
    let mut rim: Vec<usize> =
        hole.iter().flat_map(|&cell| around(cell, lattice)).filter(|&cell| bed.has_terrain(cell)).collect();
    rim.sort_unstable();
    rim.dedup();
    let level = |cell: usize| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for &other in &rim {
            let weight = 1.0 / (lattice.centre(cell) - lattice.centre(other)).norm_squared();
            sum += weight * bed.elevation[other];
            weights += weight;
        }
        sum / weights
    };
    hole.iter().map(|&cell| (cell, level(cell))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;

    /// Seven by six cells on a plane that rises by 1 m a cell to the east, without terrain where asked for.
    fn bed(without: &[(usize, usize)]) -> BedParticles {
        let lattice = Lattice::new(Vec2::ZERO, 7, 6, 2.0);
        let elevation =
            (0..42).map(|cell| if without.contains(&lattice.column_row(cell)) { f64::NAN } else { (cell % 7) as f64 });
        let elevation = elevation.collect();
        BedParticles::from_elevation(lattice, elevation, 0.0)
    }

    #[test]
    fn holes_are_what_terrain_encloses() {
        let holes = |without: &[(usize, usize)]| {
            let bed = bed(without);
            holes(&bed.lattice, |cell| !bed.has_terrain(cell))
        };
        let found = holes(&[(2, 2), (3, 3), (5, 2), (0, 4), (1, 5), (6, 0)]);
        assert_eq!(found, [vec![2 * 7 + 2, 3 * 7 + 3], vec![2 * 7 + 5]]);
        assert!(holes(&[]).is_empty());
        // By a corner it goes on to the edge.
        assert!(holes(&[(1, 1), (0, 0)]).is_empty());
    }

    #[test]
    fn parts_hang_together_over_faces() {
        let cut: Vec<(usize, usize)> = (0..6).map(|row| (if row < 3 { 2 } else { 3 }, row)).collect();
        let found = parts(&bed(&cut), 0.0);
        // By the corner between (2, 2) and (3, 3) no water gets through.
        assert_eq!((found[0], found[6], found[5 * 7 + 2], found[2]), (Some(0), Some(3), Some(0), None));
        assert!(parts(&bed(&cut[1..]), 0.0).iter().flatten().all(|part| *part == 0));
        // Fifteen cells of 36 are less than half.
        assert_eq!(parts(&bed(&cut), 0.5)[..7], [None, None, None, Some(3), Some(3), Some(3), Some(3)]);
    }

    #[test]
    fn a_filled_cell_is_the_mean_of_its_rim() {
        let bed = bed(&[(2, 2), (4, 4), (5, 4)]);
        // Eight cells around it, symmetric about it on a plane.
        assert!((filled(&[2 * 7 + 2], &bed)[0].1 - 2.0).abs() < 1e-12);
        let two = filled(&[4 * 7 + 4, 4 * 7 + 5], &bed);
        assert!((two[0].1 + two[1].1 - 9.0).abs() < 1e-12 && two[0].1 > 3.0 && two[0].1 < 4.5, "{two:?}");
    }
}
