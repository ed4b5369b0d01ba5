//! What a polygon covers of each cell, and the water over it: the fine integral of level minus terrain.
//!
//! ```text
//! V = ∫ max(level − terrain, 0) dA
//! ```
//!
//! The terrain of a raster is that of planes which keep the means of its cells (M78): beside an upright bank, one that is bilinear between
//! their centres would take half a cell of the raster from the water.
//!
//! It is taken on scan lines at least eightfold denser than the lattice, with pieces cut to the polygon, and without the cells of blocked
//! buildings.

use rayon::prelude::*;

use super::scan_line::{Interval, ScanLines, subtract};
use crate::bed::{BedParticles, Surface};
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Fewest scan lines, and pieces of a scan line, for each cell.
const SUBDIVISION: usize = 8;
/// Most corners in a row of cells for which further scan lines are drawn.
const MOST_CORNERS: usize = 64;
/// Cells of which the polygon covers all but this fraction count as covered wholly: rounding, not a rim.
const COVERAGE_ROUNDING: f64 = 1e-9;

/// What a polygon covers of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellPart {
    /// Covered fraction of the cell.
    pub coverage: f64,
    /// Whether the centre is covered.
    pub holds_centre: bool,
    /// Integral of level minus terrain over what is covered, where positive (m³).
    pub volume: f64,
    /// Whether the terrain reaches the level somewhere in what is covered.
    pub has_shore: bool,
}

impl CellPart {
    /// Whether the rim of the polygon runs through the cell.
    pub fn is_cut(&self) -> bool {
        self.coverage < 1.0 - COVERAGE_ROUNDING
    }
}

/// What a polygon covers, and the water in it.
#[derive(Default)]
pub(super) struct BodyScan {
    /// The cells that it touches, in ascending order.
    pub cells: Vec<(usize, CellPart)>,
    /// Integral of level minus terrain, where positive (m³).
    pub integral: f64,
    /// Area on the lattice (m²).
    pub area: f64,
    /// Area without terrain within a cell (m²).
    pub area_without_terrain: f64,
}

impl BodyScan {
    /// What is covered of a cell.
    pub fn part(&self, cell: usize) -> CellPart {
        let place = self.cells.binary_search_by_key(&cell, |&(cell, _)| cell);
        place.map_or(CellPart::default(), |place| self.cells[place].1)
    }
}

/// Scans the polygon of `lines[0]` without what the polygons after it cover.
pub(super) fn scan_body(level: f64, lines: &[ScanLines], bed: &BedParticles, surface: &impl Surface) -> BodyScan {
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
    // A blocked building has its place in the water, and holds none of it.
    let is_blocked: Vec<bool> = (first_column..end_column)
        .map(|column| bed.sealed.binary_search(&lattice.index(column, row)).is_ok())
        .collect();
    let mut parts = vec![CellPart::default(); end_column - first_column];
    let inside = stretches(lines, (row as f64 + 0.5) * lattice.spacing);
    for (i, part) in parts.iter_mut().enumerate() {
        let centre = ((first_column + i) as f64 + 0.5) * lattice.spacing;
        part.holds_centre = inside.iter().any(|&(from, to)| from <= centre && centre < to);
    }
    let mut scan = BodyScan::default();
    for_each_piece(lines, lattice, row, |i, place, area| {
        scan.area += area;
        let part = &mut parts[i];
        part.coverage += area / lattice.cell_area();
        if is_blocked[i] {
            return;
        }
        match elevation_near(surface, place, step) {
            Some(elevation) => {
                part.volume += (level - elevation).max(0.0) * area;
                part.has_shore |= elevation >= level && area > 0.0;
            }
            None => scan.area_without_terrain += area,
        }
    });
    scan.integral = parts.iter().map(|part| part.volume).sum();
    let covered = parts.into_iter().enumerate().filter(|(_, part)| part.coverage > 0.0 || part.holds_centre);
    scan.cells = covered.map(|(i, part)| (lattice.index(first_column + i, row), part)).collect();
    scan
}

/// Where a line from west to east (local, m) lies inside the first polygon and in none of the others.
fn stretches(lines: &[ScanLines], y: f64) -> Vec<Interval> {
    let (mut crossings, mut inside, mut later) = (Vec::new(), Vec::new(), Vec::new());
    lines[0].intervals(y, &mut crossings, &mut inside);
    for other in &lines[1..] {
        other.intervals(y, &mut crossings, &mut later);
        subtract(&mut inside, &later);
    }
    inside
}

/// Visits the pieces of what is covered of a row: the number of the cell from the first column on, the middle of the piece (map), its
/// area (m²).
fn for_each_piece(lines: &[ScanLines], lattice: &Lattice, row: usize, mut visit: impl FnMut(usize, Vec2, f64)) {
    let (first_column, end_column) = lines[0].columns;
    let step = lattice.spacing / SUBDIVISION as f64;
    for band in bands(lines, lattice.spacing, row).windows(2) {
        let (y, height) = (0.5 * (band[0] + band[1]), band[1] - band[0]);
        for (from, to) in stretches(lines, y) {
            let first_piece = ((from / step).floor() as usize).max(first_column * SUBDIVISION);
            for piece in first_piece..end_column * SUBDIVISION {
                let west = from.max(piece as f64 * step);
                let east = to.min((piece + 1) as f64 * step);
                if west >= to {
                    break;
                }
                let place = lattice.to_map(Vec2::new(0.5 * (west + east), y));
                visit(piece / SUBDIVISION - first_column, place, (east - west).max(0.0) * height);
            }
        }
    }
}

/// Integral of level minus terrain over a whole cell, where positive (m³).
pub(super) fn volume_of_whole_cell(level: f64, cell: usize, bed: &BedParticles, surface: &impl Surface) -> f64 {
    let lattice = &bed.lattice;
    let step = lattice.spacing / SUBDIVISION as f64;
    let south_west = lattice.centre(cell) - Vec2::new(lattice.spacing, lattice.spacing) * 0.5;
    let depth = |piece: usize| {
        let (x, y) = ((piece % SUBDIVISION) as f64 + 0.5, (piece / SUBDIVISION) as f64 + 0.5);
        let place = lattice.to_map(south_west + Vec2::new(x, y) * step);
        surface.mean_preserving_elevation(place, lattice.spacing).map_or(0.0, |elevation| (level - elevation).max(0.0))
    };
    (0..SUBDIVISION * SUBDIVISION).map(depth).sum::<f64>() * step * step
}

/// Elevation at a place (map), or the mean of the planes on which the terrain ends to the west, east, south and north
/// within a cell of the lattice: a raster ends in steps at an outline that polygons draw smoothly.
///
/// The planes are those of the terrain half a cell and one and a half cells from its end, because a raster is flat between
/// its last centre and its end.
fn elevation_near(surface: &impl Surface, place: Vec2, step: f64) -> Option<f64> {
    let cell = step * SUBDIVISION as f64;
    let prolonged = |direction: Vec2, reach: f64| {
        let end = surface.elevation(place + direction * reach)?;
        let at = |cells: f64| surface.elevation(place + direction * (reach + cells * cell));
        let plane = at(0.5).zip(at(1.5)).map(|(near, far)| near + (near - far) * (reach / cell + 0.5));
        Some(plane.unwrap_or(end))
    };
    let nearest = |steps: usize| {
        let around = [Vec2::new(-1.0, 0.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, -1.0), Vec2::new(0.0, 1.0)];
        let known = around.into_iter().filter_map(|direction| prolonged(direction, steps as f64 * step));
        let (sum, count) = known.fold((0.0, 0.0), |(sum, count), elevation| (sum + elevation, count + 1.0));
        (count > 0.0).then(|| sum / count)
    };
    surface.mean_preserving_elevation(place, cell).or_else(|| (1..=SUBDIVISION).find_map(nearest))
}

/// Bounds of the bands of a row, in ascending order, for each of which one scan line stands.
fn bands(lines: &[ScanLines], spacing: f64, row: usize) -> Vec<f64> {
    let mut bounds: Vec<f64> =
        (0..=SUBDIVISION).map(|band| (row as f64 + band as f64 / SUBDIVISION as f64) * spacing).collect();
    lines.iter().for_each(|lines| lines.corners(row, MOST_CORNERS, &mut bounds));
    bounds.sort_by(f64::total_cmp);
    bounds
}
