//! Gaps in ridges that are narrower than two cells: how much of a face they leave open, and the ground of their cells.
//!
//! The ground without its ridges is the grey opening of the terrain by squares of two cells, z° = max over squares S ∋ x of min over S
//! of z; a ridge stands higher than that. The closing z• = min over S ∋ x of max over S of z fills what parts two ridges:
//!
//! ```text
//! (M11)   gap at x:  z•(x) − (z•)°(x) > max(s_min, relief of (z•)° within Δ of x)   and   z•(x) − z(x) > s_min
//! (M12)  ψ(L) = Y(z, L) / Y(z°, L),   Y(z, L) the length of the shortest fence that parts the two cells of a face where z ≤ L
//! ```
//!
//! A fence runs from one side of the two cells to the other, between the widest places of each. It costs nothing where the terrain
//! stands above L. A plane and a valley are their own openings, whatever their slope and width: nothing but ridges makes a gap, and
//! of these only such as stand higher than the ground rises under them.
//!
//! The bed of a cell with a gap is the mean of its pixels in the gap and on the ground, if that is lower. Of a face beside it the part
//! ψ(L) is open, at the level of its pass sill or of its beds, L higher than that by s_min. The rest has the level of the crest, at which
//! half of it is open. A face with a pass sill is measured alike, since its crest may be uneven.
//!
//! Deliberately absent: terrain with fewer than four pixels to a cell, or with pixels that are far from square, and the area of the
//! ridge in the cell. Openings and closings: `Soille2004`; squares in two passes: `vanHerk1992`.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use rayon::prelude::*;

use super::BedParticles;
use super::fence::{Window, opening};
use super::morphology::Field;
use super::sill::{Opening, PassSill, PassSills, Pixels};
use super::upright::least_step;
use crate::constants::BedConstants;
use crate::lattice::Lattice;
use crate::math::{Vec2, larger, smaller};

/// With more pixels than this from one side to the other a square of them counts as one, at its highest: no ridge gets a gap by it.
const MOST_PIXELS: f64 = 32.0;
/// A side of a tile has about so many pixels,
const TILE: f64 = 320.0;
/// and no more cells than this,
const MOST_CELLS: usize = 32;
/// without those around it, as far as what decides of a gap reaches: a closing, an opening and the relief.
const MARGIN: usize = 6;
/// A gap is narrower than so many cells.
const WIDEST: usize = 2;

/// The cells of a bed that hold a gap whose ground (m) is lower than their bed, ascending, with that ground; the terrain is that before
/// anything is built on it.
pub fn ground_in_gaps(pixels: &impl Pixels, bed: &BedParticles) -> Vec<(usize, f64)> {
    if bed.lattice.is_empty() {
        return Vec::new();
    }
    let mut cells = Tiles::all(pixels, bed).cells_with_gaps(pixels, bed);
    cells.retain(|&(cell, ground)| ground < bed.elevation[cell]);
    cells
}

/// A lattice in tiles.
pub(super) struct Tiles {
    /// Cells along a side of a tile.
    size: usize,
    /// Their first cells (column, row), ascending.
    corners: BTreeSet<(usize, usize)>,
}

impl Tiles {
    /// All tiles of a lattice; none where no cell has pixels enough.
    pub fn all(pixels: &impl Pixels, bed: &BedParticles) -> Self {
        let lattice = &bed.lattice;
        let size = size_of_tiles(pixels, bed);
        let columns = (0..lattice.columns).step_by(size.unwrap_or(1));
        let of_column = |column: usize| (0..lattice.rows).step_by(size.unwrap_or(1)).map(move |row| (column, row));
        let corners = if size.is_some() { columns.flat_map(of_column).collect() } else { BTreeSet::new() };
        Tiles { size: size.unwrap_or(1), corners }
    }

    /// Those whose gaps a change of the terrain in some cells may change.
    pub fn near(pixels: &impl Pixels, bed: &BedParticles, cells: &[usize]) -> Self {
        let lattice = &bed.lattice;
        let mut corners = BTreeSet::new();
        let Some(size) = size_of_tiles(pixels, bed) else { return Tiles { size: 1, corners } };
        for &cell in cells {
            let (column, row) = lattice.column_row(cell);
            let around = |place: usize, count: usize| {
                let (first, last) = (place.saturating_sub(MARGIN) / size, (place + MARGIN).min(count - 1) / size);
                (first..=last).map(move |tile| tile * size)
            };
            let rows = || around(row, lattice.rows);
            corners.extend(around(column, lattice.columns).flat_map(|column| rows().map(move |row| (column, row))));
        }
        Tiles { size, corners }
    }

    /// The first cell of the tile that holds a cell.
    fn corner_of(&self, lattice: &Lattice, cell: usize) -> (usize, usize) {
        let (column, row) = lattice.column_row(cell);
        (column / self.size * self.size, row / self.size * self.size)
    }

    /// Whether a cell lies in one of them.
    pub fn hold(&self, lattice: &Lattice, cell: usize) -> bool {
        self.corners.contains(&self.corner_of(lattice, cell))
    }

    /// Their cells with a gap, ascending, and the ground (m) without its ridges.
    pub fn cells_with_gaps(&self, pixels: &impl Pixels, bed: &BedParticles) -> Vec<(usize, f64)> {
        let of_tile =
            |&corner: &(usize, usize)| Tile::read(pixels, bed, corner, self.size).map(|tile| tile.gaps(pixels, bed));
        let corners: Vec<_> = self.corners.iter().collect();
        let mut cells: Vec<(usize, f64)> = corners.into_par_iter().filter_map(of_tile).flatten().collect();
        cells.sort_by_key(|&(cell, _)| cell);
        cells
    }

    /// What gaps leave of the faces beside their cells and of those with a sill, by cell and direction.
    ///
    /// - `cells`: those with a gap
    pub fn openings(
        &self,
        pixels: &impl Pixels,
        bed: &BedParticles,
        cells: &[usize],
        sills: &PassSills,
    ) -> Vec<Opening> {
        let lattice = &bed.lattice;
        let mut faces: BTreeSet<(usize, bool)> = sills.iter().map(PassSill::face).collect();
        for &cell in cells {
            let (column, row) = lattice.column_row(cell);
            faces.extend((column + 1 < lattice.columns).then_some((cell, false)));
            faces.extend((row + 1 < lattice.rows).then_some((cell, true)));
            faces.extend((column > 0).then(|| (cell - 1, false)));
            faces.extend((row > 0).then(|| (cell - lattice.columns, true)));
        }
        let mut of_tiles: BTreeMap<(usize, usize), Vec<(usize, bool)>> = BTreeMap::new();
        for face in faces {
            let corner = self.corner_of(lattice, face.0);
            if self.corners.contains(&corner) {
                of_tiles.entry(corner).or_default().push(face);
            }
        }
        let of_tile = |(&corner, faces): (&(usize, usize), &Vec<(usize, bool)>)| {
            Tile::read(pixels, bed, corner, self.size).map(|tile| tile.openings(pixels, bed, faces, sills))
        };
        let of_tiles: Vec<_> = of_tiles.iter().collect();
        let mut openings: Vec<Opening> = of_tiles.into_par_iter().filter_map(of_tile).flatten().collect();
        openings.sort_by_key(Opening::face);
        openings
    }
}

/// Cells along a side of a tile; none where no pixels are fine enough.
fn size_of_tiles(pixels: &impl Pixels, bed: &BedParticles) -> Option<usize> {
    let lattice = &bed.lattice;
    let grid = pixels.grid(lattice.origin, lattice.origin + lattice.size(), lattice.spacing)?;
    let along = lattice.spacing / grid.cell().x.max(grid.cell().y);
    (along >= bed.constants.gap_pixels).then(|| ((TILE / along.min(MOST_PIXELS)) as usize).min(MOST_CELLS))
}

/// Whether the terrain of a cell itself has pixels that are fine enough, and nearly square.
fn is_fine(pixels: &impl Pixels, bed: &BedParticles, cell: usize) -> bool {
    let lattice = &bed.lattice;
    let (column, row) = lattice.column_row(cell);
    let corner = |column: usize, row: usize| lattice.to_map(Vec2::new(column as f64, row as f64) * lattice.spacing);
    pixels.grid(corner(column, row), corner(column + 1, row + 1), lattice.spacing).is_some_and(|grid| {
        let (least, greatest) = (grid.cell().x.min(grid.cell().y), grid.cell().x.max(grid.cell().y));
        let BedConstants { gap_pixels, pixel_ratio, .. } = bed.constants;
        lattice.spacing >= gap_pixels * greatest && greatest <= pixel_ratio * least
    })
}

/// The pixels of some cells and of those around them.
struct Tile {
    /// The first cell of those around it.
    first: (usize, usize),
    /// The cells of the tile itself.
    own: [Range<usize>; 2],
    /// The pixels of each column and row of cells.
    columns: Vec<Range<usize>>,
    rows: Vec<Range<usize>>,
    /// Elevation (m), without end where there is no terrain.
    terrain: Field<f64>,
    /// Pixels from one side of a cell to the other.
    width: usize,
}

impl Tile {
    /// The tile from a cell (column, row) on, if its terrain has pixels that are fine enough, and rises and falls.
    fn read(pixels: &impl Pixels, bed: &BedParticles, (column, row): (usize, usize), size: usize) -> Option<Self> {
        let lattice = &bed.lattice;
        let range = |from: usize, count: usize| from..(from + size).min(count);
        let around = |own: &Range<usize>, count: usize| own.start.saturating_sub(MARGIN)..(own.end + MARGIN).min(count);
        let own = [range(column, lattice.columns), range(row, lattice.rows)];
        let (wide, high) = (around(&own[0], lattice.columns), around(&own[1], lattice.rows));
        let corner = |column: usize, row: usize| lattice.to_map(Vec2::new(column as f64, row as f64) * lattice.spacing);
        let (low, far) = (corner(wide.start, high.start), corner(wide.end, high.end));
        let grid = pixels.grid(low, far, lattice.spacing)?;
        let along = lattice.spacing / grid.cell().x.max(grid.cell().y);
        if along < bed.constants.gap_pixels {
            return None;
        }
        let whole = grid.block(low, far);
        // Pixels of the grid along a side of one of the tile.
        let coarse = (along / MOST_PIXELS).ceil() as usize;
        let place = |pixel: i64, whole: &Range<i64>| (pixel - whole.start) as usize / coarse;
        let within = |range: Range<i64>, whole: &Range<i64>| place(range.start, whole)..place(range.end - 1, whole) + 1;
        let [pixel_columns, pixel_rows] = [&whole.columns, &whole.rows].map(|whole| within(whole.clone(), whole).end);
        let block = |column: usize, row: usize| grid.block(corner(column, row), corner(column + 1, row + 1));
        let columns = wide.clone().map(|column| within(block(column, row).columns, &whole.columns)).collect();
        let rows = high.clone().map(|row| within(block(column, row).rows, &whole.rows)).collect();
        let mut values = vec![f64::NEG_INFINITY; pixel_columns * pixel_rows];
        let mut of_cell = Vec::new();
        for (row, column) in high.clone().flat_map(|row| wide.clone().map(move |column| (row, column))) {
            let block = block(column, row);
            of_cell.clear();
            pixels.read(&grid, &block, row * lattice.columns + column, &mut of_cell);
            let mut read = of_cell.iter();
            for row in block.rows.clone() {
                let start = place(row, &whole.rows) * pixel_columns;
                for column in block.columns.clone() {
                    let here = &mut values[start + place(column, &whole.columns)];
                    // `max` leaves NaN out.
                    *here = read.next().map_or(*here, |value| here.max(*value));
                }
            }
        }
        values.iter_mut().filter(|z| z.is_infinite()).for_each(|z| *z = f64::INFINITY);
        let (lowest, highest) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &z| (low.min(z), high.max(z)));
        if highest - lowest <= least_step(lattice.spacing, &bed.constants) {
            return None;
        }
        let terrain = Field { columns: pixel_columns, values };
        Some(Tile {
            first: (wide.start, high.start),
            own,
            columns,
            rows,
            terrain,
            width: (along / coarse as f64).round() as usize,
        })
    }

    /// Ranges of pixels of a cell (column, row).
    fn pixels_of(&self, (column, row): (usize, usize)) -> [Range<usize>; 2] {
        [self.columns[column - self.first.0].clone(), self.rows[row - self.first.1].clone()]
    }

    /// The ground without ridges (m).
    fn ground(&self) -> Field<f64> {
        self.terrain.without_ridges(self.width)
    }

    /// The cells of the tile with a gap, and their ground (m) without ridges.
    fn gaps(&self, pixels: &impl Pixels, bed: &BedParticles) -> Vec<(usize, f64)> {
        let lattice = &bed.lattice;
        let step = least_step(lattice.spacing, &bed.constants);
        let ground = self.ground();
        // Without ridges there is nothing to close.
        if self
            .terrain
            .values
            .iter()
            .zip(&ground.values)
            .all(|(z, ground)| z - ground <= step || *ground == f64::INFINITY)
        {
            return Vec::new();
        }
        let closed = self.terrain.by_squares(WIDEST * self.width, f64::NEG_INFINITY, larger, smaller);
        let ridges = closed.without_ridges(self.width);
        let finite = |z: f64, otherwise: f64| if z < f64::INFINITY { z } else { otherwise };
        let lowest = ridges.by_squares(self.width, f64::INFINITY, smaller, smaller);
        let highest = Field {
            columns: ridges.columns,
            values: ridges.values.iter().map(|&z| finite(z, f64::NEG_INFINITY)).collect(),
        };
        let highest = highest.by_squares(self.width, f64::NEG_INFINITY, larger, larger);
        // Where a ridge would go on, and does not.
        let is_gap = |k: usize| {
            let (z, z_closed, z_ground) = (self.terrain.values[k], closed.values[k], ridges.values[k]);
            let is_ridge = z_closed - z_ground > step.max(highest.values[k] - lowest.values[k]);
            z < f64::INFINITY && is_ridge && z_closed - z > step
        };
        let columns = self.terrain.columns;
        let mut gaps = Vec::new();
        for (row, column) in self.own[1].clone().flat_map(|row| self.own[0].clone().map(move |column| (row, column))) {
            let cell = row * lattice.columns + column;
            let [wide, high] = self.pixels_of((column, row));
            let places = || high.clone().flat_map(|row| wide.clone().map(move |column| row * columns + column));
            if bed.has_terrain(cell) && places().any(is_gap) && is_fine(pixels, bed, cell) {
                let is_low = |&k: &usize| self.terrain.values[k] - ground.values[k] <= step || is_gap(k);
                let mut levels: Vec<f64> = places().filter(is_low).map(|k| self.terrain.values[k]).collect();
                // In an order that a mirrored terrain has, too.
                levels.sort_by(f64::total_cmp);
                gaps.push((cell, levels.iter().sum::<f64>() / levels.len() as f64));
            }
        }
        gaps
    }

    /// What gaps leave of some faces that cells of the tile own.
    fn openings(
        &self,
        pixels: &impl Pixels,
        bed: &BedParticles,
        faces: &[(usize, bool)],
        sills: &PassSills,
    ) -> Vec<Opening> {
        let lattice = &bed.lattice;
        let ground = self.ground();
        let opening = |&(cell, is_north): &(usize, bool)| {
            let other = cell + if is_north { lattice.columns } else { 1 };
            if !bed.has_terrain(cell) || !bed.has_terrain(other) || !is_fine(pixels, bed, cell) {
                return None;
            }
            let beds = bed.elevation[cell].max(bed.elevation[other]);
            let base = beds.max(sills.between(cell, other)) + least_step(lattice.spacing, &bed.constants);
            let places = [cell, other].map(|cell| lattice.column_row(cell));
            let window = |field: &Field<f64>| self.window(field, places, is_north);
            let (share, crest) = opening(&window(&self.terrain), &window(&ground), base, bed.constants.gap_open)?;
            Some(Opening { cell, is_north, share, crest })
        };
        faces.iter().filter_map(opening).collect()
    }

    /// The pixels of two cells, from one to the other row by row.
    fn window(&self, field: &Field<f64>, cells: [(usize, usize); 2], is_north: bool) -> Window {
        let [[wide, high], [wide_2, high_2]] = cells.map(|cell| self.pixels_of(cell));
        let value = |row: usize, column: usize| field.values[row * field.columns + column];
        // Rows run from the north: from the other cell to the first.
        let whole = if is_north { high_2.start..high.end } else { wide.start..wide_2.end };
        let place = |range: Range<usize>| {
            if is_north {
                whole.end - range.end..whole.end - range.start
            } else {
                range.start - whole.start..range.end - whole.start
            }
        };
        let (cells, columns) = if is_north { ([high, high_2], wide) } else { ([wide, wide_2], high) };
        let from = columns.start;
        let values = (0..whole.len()).flat_map(|row| (0..columns.len()).map(move |column| (row, column)));
        let values = values.map(|(row, column)| {
            if is_north { value(whole.end - 1 - row, from + column) } else { value(from + column, whole.start + row) }
        });
        Window { columns: columns.len(), values: values.collect(), cells: cells.map(place) }
    }
}
