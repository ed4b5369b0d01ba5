//! Filling polygons to their level: the depth of still water at every cell of the lattice, and its volume.
//!
//! A cell is filled exactly to the level or not at all, because a lake at rest must be level to the last digit:
//!
//! ```text
//! d = max(level − z_b, 0)  where the centre of the cell lies in the polygon
//! ```
//!
//! The volume to be met is the integral of max(level − terrain, 0) over the polygon, taken on scan lines at least eightfold
//! denser than the lattice, with pieces cut to the polygon. To meet it within 0.1 %, cells that the rim of the polygon cuts are taken in
//! (those covered most come first) or left out (those covered least), but only where the rim lies in open water, as along a
//! dam: leaving out a cell at the shore would make the lake run into the gap, and the terrain ends the lake there anyhow.
//! Before that, pockets below the level that the rim leaves out by less than the lattice can see are filled (`leaks.rs`).
//! Where neither is possible (a dam that stands between two rows of cells, a shore finer than the lattice), the level wins over
//! the volume, and the difference is in the books.
//! Where bodies overlap the later one wins.

use rayon::prelude::*;

use super::StillBody;
use super::leaks::{Filling, Leak};
use super::scan_line::{Interval, ScanLines, subtract};
use crate::bed::{BedParticles, Surface};
use crate::math::Vec2;

/// Fewest scan lines, and pieces of a scan line, for each cell.
const SUBDIVISION: usize = 8;
/// Most corners in a row of cells for which further scan lines are drawn.
const MOST_CORNERS: usize = 64;
/// What the seeded volume may differ from the integral, relative.
pub const VOLUME_TOLERANCE: f64 = 1e-3;
/// Cells of which the polygon covers all but this fraction count as covered wholly: rounding, not a rim.
const COVERAGE_ROUNDING: f64 = 1e-9;

/// The books of one body of still water.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeededVolume {
    /// Integral of level minus terrain over the polygon, where positive (m³); parts that later bodies cover are left out.
    pub integral_m3: f64,
    /// Volume on the lattice (m³).
    pub seeded_m3: f64,
    /// Number of cells with water.
    pub cells: usize,
    /// Cells at the rim taken in or left out against the rule of the centre.
    pub toggled: usize,
    /// Cells outside the rule of the centre that were filled because the lake reaches them at its level and stops there.
    pub pocket_cells: usize,
    /// Area of the polygon (m²), as far as it lies on the lattice.
    pub area_m2: f64,
    /// Area of that where there is no terrain within a cell (m²).
    pub area_without_terrain_m2: f64,
    /// Where the water would leave the polygon at its level, the lowest place of each gap, deepest first.
    pub leaks: Vec<Leak>,
}

impl SeededVolume {
    /// (seeded − integral) / integral; 0 for a body without water.
    pub fn relative_error(&self) -> f64 {
        if self.integral_m3 > 0.0 { (self.seeded_m3 - self.integral_m3) / self.integral_m3 } else { 0.0 }
    }

    /// Whether the seeded volume is as near to the integral as promised. A body of a few cells may not be: its shore is
    /// finer than the lattice.
    pub fn is_within_tolerance(&self) -> bool {
        self.relative_error().abs() <= VOLUME_TOLERANCE
    }
}

/// Still water on the lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct StillWater {
    /// Depth d (m) of every cell.
    pub depth: Vec<f64>,
    /// Number of the body that fills a cell.
    pub body: Vec<Option<u32>>,
    /// The books of each body, in the order given.
    pub volumes: Vec<SeededVolume>,
}

/// Fills bodies of still water.
///
/// - `surface`: the terrain itself, for the integral
/// - `walls`: straight pieces (m, local) through which no water passes, such as a dam that stands
pub fn fill_still_water(
    bodies: &[StillBody],
    bed: &BedParticles,
    surface: &impl Surface,
    walls: &[[Vec2; 2]],
) -> StillWater {
    let lines: Vec<ScanLines> = bodies.iter().map(|body| ScanLines::new(&body.polygon, &bed.lattice)).collect();
    let scans: Vec<BodyScan> =
        (0..bodies.len()).map(|number| scan_body(bodies[number].level, &lines[number..], bed, surface)).collect();

    let mut filling = Filling::new(bed, walls);
    for (number, (body, scan)) in bodies.iter().zip(&scans).enumerate() {
        for &(cell, _) in scan.cells.iter().filter(|(_, part)| part.holds_centre) {
            if filling.is_below(cell, body.level) {
                filling.body[cell] = Some(number as u32);
            }
        }
    }
    let mut volumes = Vec::with_capacity(bodies.len());
    for (number, (body, scan)) in bodies.iter().zip(scans).enumerate() {
        volumes.push(adjust(number as u32, body.level, scan, &mut filling));
    }
    let body = filling.body;
    let depth = body
        .par_iter()
        .zip(&bed.elevation)
        .map(|(body, &z_b)| body.map_or(0.0, |number| bodies[number as usize].level - z_b))
        .collect();
    StillWater { depth, body, volumes }
}

/// What a polygon covers of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct CellPart {
    /// Covered fraction of the cell.
    coverage: f64,
    /// Whether the centre is covered.
    holds_centre: bool,
}

/// What a polygon covers, and the water in it.
#[derive(Default)]
struct BodyScan {
    cells: Vec<(usize, CellPart)>,
    integral: f64,
    area: f64,
    area_without_terrain: f64,
}

/// Scans the polygon of `lines[0]` without what the polygons after it cover.
fn scan_body(level: f64, lines: &[ScanLines], bed: &BedParticles, surface: &impl Surface) -> BodyScan {
    let (first, end) = lines[0].rows;
    let rows: Vec<BodyScan> =
        (first..end).into_par_iter().map(|row| scan_row(level, lines, bed, surface, row)).collect();
    let mut whole = BodyScan::default();
    for row in rows {
        whole.cells.extend(row.cells);
        whole.integral += row.integral;
        whole.area += row.area;
        whole.area_without_terrain += row.area_without_terrain;
    }
    whole
}

fn scan_row(level: f64, lines: &[ScanLines], bed: &BedParticles, surface: &impl Surface, row: usize) -> BodyScan {
    let lattice = &bed.lattice;
    let (first_column, end_column) = lines[0].columns;
    let step = lattice.spacing / SUBDIVISION as f64;
    let (mut crossings, mut later) = (Vec::new(), Vec::new());
    let mut stretches = |y: f64, inside: &mut Vec<Interval>| {
        lines[0].intervals(y, &mut crossings, inside);
        for other in &lines[1..] {
            other.intervals(y, &mut crossings, &mut later);
            subtract(inside, &later);
        }
    };
    let mut parts = vec![CellPart::default(); end_column - first_column];
    let mut inside = Vec::new();
    let middle = (row as f64 + 0.5) * lattice.spacing;
    stretches(middle, &mut inside);
    for (i, part) in parts.iter_mut().enumerate() {
        let centre = ((first_column + i) as f64 + 0.5) * lattice.spacing;
        part.holds_centre = inside.iter().any(|&(from, to)| from <= centre && centre < to);
    }
    let mut scan = BodyScan::default();
    for band in bands(lines, lattice.spacing, row).windows(2) {
        let (y, height) = (0.5 * (band[0] + band[1]), band[1] - band[0]);
        stretches(y, &mut inside);
        for &(from, to) in &inside {
            let first_piece = ((from / step).floor() as usize).max(first_column * SUBDIVISION);
            for piece in first_piece..end_column * SUBDIVISION {
                let west = from.max(piece as f64 * step);
                let east = to.min((piece + 1) as f64 * step);
                if west >= to {
                    break;
                }
                let area = (east - west).max(0.0) * height;
                parts[piece / SUBDIVISION - first_column].coverage += area / lattice.cell_area();
                scan.area += area;
                match elevation_near(surface, lattice.to_map(Vec2::new(0.5 * (west + east), y)), step) {
                    Some(elevation) => scan.integral += (level - elevation).max(0.0) * area,
                    None => scan.area_without_terrain += area,
                }
            }
        }
    }
    let covered = parts.into_iter().enumerate().filter(|(_, part)| part.coverage > 0.0 || part.holds_centre);
    scan.cells = covered.map(|(i, part)| (lattice.index(first_column + i, row), part)).collect();
    scan
}

/// Elevation at a place (map), or the mean of the nearest ones to the west, east, south and north within a cell of the
/// lattice: a raster ends in steps at an outline that polygons draw smoothly, and between the two it knows no better.
fn elevation_near(surface: &impl Surface, place: Vec2, step: f64) -> Option<f64> {
    let nearest = |steps: usize| {
        let reach = steps as f64 * step;
        let around = [(-reach, 0.0), (reach, 0.0), (0.0, -reach), (0.0, reach)];
        let known = around.into_iter().filter_map(|(x, y)| surface.elevation(place + Vec2::new(x, y)));
        let (sum, count) = known.fold((0.0, 0.0), |(sum, count), elevation| (sum + elevation, count + 1.0));
        (count > 0.0).then(|| sum / count)
    };
    surface.elevation(place).or_else(|| (1..=SUBDIVISION).find_map(nearest))
}

/// Bounds of the bands of a row, in ascending order, for each of which one scan line stands.
fn bands(lines: &[ScanLines], spacing: f64, row: usize) -> Vec<f64> {
    let mut bounds: Vec<f64> =
        (0..=SUBDIVISION).map(|band| (row as f64 + band as f64 / SUBDIVISION as f64) * spacing).collect();
    lines.iter().for_each(|lines| lines.corners(row, MOST_CORNERS, &mut bounds));
    bounds.sort_by(f64::total_cmp);
    bounds
}

/// Fills the pockets of a body, brings its volume near the integral, and finds its leaks.
fn adjust(number: u32, level: f64, scan: BodyScan, filling: &mut Filling) -> SeededVolume {
    let holds = |filling: &Filling, cells: &[usize]| -> Vec<usize> {
        cells.iter().copied().filter(|&cell| filling.body[cell] == Some(number)).collect()
    };
    let mut reached: Vec<usize> = scan.cells.iter().map(|&(cell, _)| cell).collect();
    // Half of the tolerance for the pockets, so that they alone cannot exhaust it.
    let by_centre = holds(filling, &reached);
    let pockets = filling.fill_pockets(number, level, &by_centre, 0.5 * VOLUME_TOLERANCE * scan.integral);
    reached.extend(&pockets);
    reached.sort_unstable();
    reached.dedup();
    let toggled = meet_volume(number, level, &scan, &reached, filling);
    let cells = holds(filling, &reached);
    SeededVolume {
        integral_m3: scan.integral,
        seeded_m3: cells.iter().map(|&cell| volume_of(filling, cell, level)).sum(),
        cells: cells.len(),
        toggled,
        pocket_cells: pockets.len(),
        area_m2: scan.area,
        area_without_terrain_m2: scan.area_without_terrain,
        leaks: filling.leaks(level, &cells),
    }
}

/// Volume (m³) of a cell that is filled to a level.
fn volume_of(filling: &Filling, cell: usize, level: f64) -> f64 {
    (level - filling.bed.elevation[cell]) * filling.bed.lattice.cell_area()
}

/// Takes in and leaves out cells cut by the rim until the volume is within the tolerance or no cell brings it nearer.
/// Returns the number of cells that differ from before.
fn meet_volume(number: u32, level: f64, scan: &BodyScan, reached: &[usize], filling: &mut Filling) -> usize {
    let mut rim: Vec<(usize, f64)> = scan
        .cells
        .iter()
        .filter(|&&(cell, part)| part.coverage < 1.0 - COVERAGE_ROUNDING && filling.is_below(cell, level))
        .map(|&(cell, part)| (cell, part.coverage))
        .collect();
    rim.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let before: Vec<Option<u32>> = rim.iter().map(|&(cell, _)| filling.body[cell]).collect();
    let filled = reached.iter().filter(|&&cell| filling.body[cell] == Some(number));
    let mut surplus = filled.map(|&cell| volume_of(filling, cell, level)).sum::<f64>() - scan.integral;
    loop {
        let at_start = surplus;
        let is_taking_in = surplus < 0.0;
        for place in 0..rim.len() {
            if surplus.abs() <= VOLUME_TOLERANCE * scan.integral || (surplus < 0.0) != is_taking_in {
                break;
            }
            // Best covered first when taking in, least covered first when leaving out.
            let cell = if is_taking_in { rim[place].0 } else { rim[rim.len() - 1 - place].0 };
            let volume = volume_of(filling, cell, level);
            let is_useful = volume < 2.0 * surplus.abs();
            let is_possible = if is_taking_in {
                filling.body[cell].is_none()
                    && filling.neighbours(cell).any(|other| filling.body[other] == Some(number))
            } else {
                filling.body[cell] == Some(number) && filling.gaps(cell, level).next().is_some()
            };
            if is_useful && is_possible {
                filling.body[cell] = is_taking_in.then_some(number);
                surplus += if is_taking_in { volume } else { -volume };
            }
        }
        #[expect(clippy::float_cmp, reason = "unchanged means that no cell was toggled")]
        if surplus == at_start {
            break;
        }
    }
    rim.iter().zip(before).filter(|&(&(cell, _), before)| filling.body[cell] != before).count()
}

#[cfg(test)]
mod malpasset;
#[cfg(test)]
pub(crate) mod tests;
