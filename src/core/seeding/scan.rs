//! What a polygon covers of each cell, and the water over it: the fine integral of level minus terrain.
//!
//! ```text
//! V = ∫ max(level − terrain, 0) dA
//! ```
//!
//! The terrain of a raster is that of planes which keep the means of its cells (M9): beside an upright bank, one that is bilinear between
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
    /// Whether the centre is covered; of a cell in part, that of what the terrain covers.
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
    let end_of_cells = if row < lattice.rows { end_column.min(lattice.columns) } else { first_column };
    // A blocked building has its place in the water, and holds none of it. A polygon may reach beyond the lattice.
    let is_blocked: Vec<bool> = (first_column..end_column)
        .map(|column| column < end_of_cells && bed.sealed.binary_search(&lattice.index(column, row)).is_ok())
        .collect();
    let mut parts = vec![CellPart::default(); end_column - first_column];
    let inside = stretches(lines, (row as f64 + 0.5) * lattice.spacing);
    for (i, part) in parts.iter_mut().enumerate() {
        let centre = ((first_column + i) as f64 + 0.5) * lattice.spacing;
        part.holds_centre = inside.iter().any(|&(from, to)| from <= centre && centre < to);
    }
    // A cell in part is held by the middle of what it has.
    let first = if first_column < end_of_cells { lattice.index(first_column, row) } else { 0 };
    for part in bed.cover.cells_of(first..first + end_of_cells.saturating_sub(first_column)) {
        let place = lattice.centre(part.cell) + part.middle * lattice.spacing;
        let mut inside = stretches(lines, place.y).into_iter();
        parts[part.cell - first].holds_centre = inside.any(|(from, to)| from <= place.x && place.x < to);
    }
    let mut scan = BodyScan::default();
    // Where the terrain is one plane under water all over a cell, its mean says all.
    let bands = bands_of_row(lines, lattice.spacing, row);
    let is_whole: Vec<bool> = whole_cells(&bands, lattice.spacing, lines[0].columns)
        .enumerate()
        .map(|(i, is_whole)| {
            let centre = || lattice.to_map(lattice.centre(lattice.index(first_column + i, row)));
            let is_plain = is_whole && first_column + i < end_of_cells && !is_blocked[i];
            let plane = is_plain.then(|| surface.plane_of_cell(centre(), lattice.spacing)).flatten();
            let plane = plane.filter(|plane| plane.highest < level);
            if let Some(plane) = plane {
                scan.area += lattice.cell_area();
                parts[i].coverage = 1.0;
                parts[i].volume = (level - plane.mean) * lattice.cell_area();
            }
            plane.is_some()
        })
        .collect();
    for_each_piece(&bands, lattice, (lines[0].columns, &is_whole), |i, place, area| {
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

/// A part of a row for which one scan line stands.
struct Band {
    /// The scan line (m, local), and the height of the band (m).
    y: f64,
    height: f64,
    /// What of the line is covered.
    stretches: Vec<Interval>,
}

/// The bands of a row, in ascending order.
fn bands_of_row(lines: &[ScanLines], spacing: f64, row: usize) -> Vec<Band> {
    let band = |bounds: &[f64]| {
        let y = 0.5 * (bounds[0] + bounds[1]);
        Band { y, height: bounds[1] - bounds[0], stretches: stretches(lines, y) }
    };
    bands(lines, spacing, row).windows(2).map(band).collect()
}

/// Whether all of a cell is covered, for each of the columns from the first on.
fn whole_cells(bands: &[Band], spacing: f64, (first, end): (usize, usize)) -> impl Iterator<Item = bool> {
    let mut covered = vec![0; end - first];
    for &(from, to) in bands.iter().flat_map(|band| &band.stretches) {
        // Casts of negative numbers give 0.
        let whole = ((from / spacing).ceil() as usize).max(first)..((to / spacing).floor() as usize).min(end);
        whole.for_each(|column| covered[column - first] += 1);
    }
    let all = bands.len();
    covered.into_iter().map(move |count| count == all)
}

/// Visits the pieces of what is covered of a row but for whole cells that are known: the number of the cell from the first column on, the
/// middle of the piece (map), its area (m²).
fn for_each_piece(
    bands: &[Band],
    lattice: &Lattice,
    ((first_column, end_column), is_known): ((usize, usize), &[bool]),
    mut visit: impl FnMut(usize, Vec2, f64),
) {
    let step = lattice.spacing / SUBDIVISION as f64;
    for Band { y, height, stretches } in bands {
        let (y, height) = (*y, *height);
        for &(from, to) in stretches {
            let first_piece = ((from / step).floor() as usize).max(first_column * SUBDIVISION);
            let mut piece = first_piece;
            while piece < end_column * SUBDIVISION {
                let cell = piece / SUBDIVISION - first_column;
                if is_known[cell] {
                    piece = (first_column + cell + 1) * SUBDIVISION;
                    continue;
                }
                let west = from.max(piece as f64 * step);
                let east = to.min((piece + 1) as f64 * step);
                if west >= to {
                    break;
                }
                let place = lattice.to_map(Vec2::new(0.5 * (west + east), y));
                visit(cell, place, (east - west).max(0.0) * height);
                piece += 1;
            }
        }
    }
}

/// What a whole cell holds of water of a level (m³): the mean of level minus terrain, where positive, over the terrain in the cell, times
/// its area. Where a part of the cell has no terrain, the rest speaks for it.
pub(super) fn volume_of_whole_cell(level: f64, cell: usize, bed: &BedParticles, surface: &impl Surface) -> f64 {
    let lattice = &bed.lattice;
    let step = lattice.spacing / SUBDIVISION as f64;
    let south_west = lattice.centre(cell) - Vec2::new(lattice.spacing, lattice.spacing) * 0.5;
    let elevation = |piece: usize| {
        let (x, y) = ((piece % SUBDIVISION) as f64 + 0.5, (piece / SUBDIVISION) as f64 + 0.5);
        surface.mean_preserving_elevation(lattice.to_map(south_west + Vec2::new(x, y) * step), lattice.spacing)
    };
    let depths = (0..SUBDIVISION * SUBDIVISION).filter_map(elevation).map(|elevation| (level - elevation).max(0.0));
    let (sum, count) = depths.fold((0.0, 0.0), |(sum, count), depth| (sum + depth, count + 1.0));
    if count > 0.0 { sum / count * lattice.cell_area() } else { 0.0 }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bed::place_bed;
    use crate::methods::BedMethod;
    use crate::terrain::{Layer, Raster, Terrain};

    /// A terrain that knows no plane over a cell.
    struct InPieces<'a>(&'a Terrain);

    impl Surface for InPieces<'_> {
        fn elevation(&self, map: Vec2) -> Option<f64> {
            self.0.elevation(map)
        }

        fn mean_preserving_elevation(&self, map: Vec2, spacing: f64) -> Option<f64> {
            self.0.mean_preserving_elevation(map, spacing)
        }

        fn samples(&self, _: Vec2, _: f64, _: &mut Vec<(Vec2, f64)>) {}
    }

    #[test]
    fn where_the_raster_is_the_lattice_means_of_planes_are_the_sums_of_their_pieces() {
        let (columns, rows) = (40, 30);
        let height = |i: usize| 0.2 * ((i % columns) as f64 - 20.0).abs() + (0.9 * (i / columns) as f64).sin();
        let mut values: Vec<f64> = (0..columns * rows).map(height).collect();
        values[700] = f64::NAN;
        let raster = Raster { columns, rows, west: 100.0, north: 350.0, cell_x: 5.0, cell_y: 5.0, values };
        let terrain = Terrain::new(vec![Layer::Raster(raster)]).unwrap();
        let lattice = Lattice::new(Vec2::new(100.0, 200.0), columns, rows, 5.0);
        let bed = place_bed(&terrain, &lattice, BedMethod::Pointwise, &crate::bed::Nothing, 0.0);
        let ring = [(113.0, 204.0), (287.0, 211.0), (290.0, 345.0), (150.0, 341.0), (113.0, 204.0)];
        let lake = geo::MultiPolygon(vec![geo::Polygon::new(geo::LineString::from(ring.to_vec()), Vec::new())]);
        let lines = [ScanLines::new(&lake, &lattice)];
        let level = 1.7;
        let (fast, plain) =
            (scan_body(level, &lines, &bed, &terrain), scan_body(level, &lines, &bed, &InPieces(&terrain)));
        // Sums of some ten thousand pieces.
        assert!((fast.integral / plain.integral - 1.0).abs() < 1e-12 && fast.integral > 1e4);
        assert!((fast.area / plain.area - 1.0).abs() < 1e-12);
        assert!(fast.cells.len() == plain.cells.len() && fast.cells.len() > 500);
        let mut under_water = 0;
        for ((cell, part), (_, expected)) in fast.cells.iter().zip(&plain.cells) {
            assert!((part.volume - expected.volume).abs() < 1e-12 * 25.0 * level, "cell {cell}");
            assert_eq!((part.holds_centre, part.has_shore), (expected.holds_centre, expected.has_shore), "cell {cell}");
            assert_eq!(part.is_cut(), expected.is_cut(), "cell {cell}");
            under_water += usize::from(!part.is_cut() && !part.has_shore);
        }
        assert!(under_water > 200);
        let centre = |cell: usize| lattice.to_map(lattice.centre(cell));
        assert!(Surface::plane_of_cell(&terrain, centre(5), 5.0).is_some());
        assert!(Surface::plane_of_cell(&terrain, centre(5) + Vec2::new(0.1, 0.0), 5.0).is_none(), "not a cell");
        assert!(Surface::plane_of_cell(&terrain, centre(5), 10.0).is_none(), "another spacing");
    }
}
