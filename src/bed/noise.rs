//! How rough the terrain is inside a cell: the scatter of its pixels about their own plane.
//!
//! ```text
//! σ = √(Σ r²/m),   r = z − z̄ − g·(x − x̄),   g of least squares
//! ```

use rayon::prelude::*;

use super::Pixels;
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Fewest pixels that leave something beside a plane.
const FEWEST_PIXELS: usize = 6;

/// The scatter (m) that half of the cells do not exceed, and that which 95 % do not; none where no cell holds enough pixels.
pub fn noise_in_cells(pixels: &impl Pixels, lattice: &Lattice) -> Option<[f64; 2]> {
    let of_row = |row: usize| {
        let mut values = Vec::new();
        let cells = row * lattice.columns..(row + 1) * lattice.columns;
        cells.filter_map(|cell| scatter(pixels, lattice, cell, &mut values)).collect::<Vec<f64>>()
    };
    let rows: Vec<Vec<f64>> = (0..lattice.rows).into_par_iter().map(of_row).collect();
    let mut scatters = rows.concat();
    scatters.sort_by(f64::total_cmp);
    let at = |share: f64| scatters[((scatters.len() - 1) as f64 * share) as usize];
    (!scatters.is_empty()).then(|| [at(0.5), at(0.95)])
}

/// The scatter (m) of one cell.
fn scatter(pixels: &impl Pixels, lattice: &Lattice, cell: usize, values: &mut Vec<f64>) -> Option<f64> {
    let half = Vec2::new(lattice.spacing, lattice.spacing) * 0.5;
    let centre = lattice.to_map(lattice.centre(cell));
    let (low, high) = (centre - half, centre + half);
    let grid = pixels.grid(low, high, lattice.spacing)?;
    let block = grid.block(low, high);
    values.clear();
    pixels.read(&grid, &block, cell, values);
    let places = block.rows.clone().flat_map(|row| block.columns.clone().map(move |column| (column, row)));
    let known = || places.clone().zip(values.iter()).filter(|(_, z)| !z.is_nan());
    let offset = |(column, row): (i64, i64)| grid.centre(column, row) - centre;
    let count = known().count();
    if count < FEWEST_PIXELS {
        return None;
    }
    let per_count = 1.0 / count as f64;
    let (mut mean, mut middle) = (0.0, Vec2::ZERO);
    for (place, z) in known() {
        mean += z * per_count;
        middle += offset(place) * per_count;
    }
    let (mut xx, mut xy, mut yy, mut xz, mut yz, mut zz) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (place, z) in known() {
        let (Vec2 { x, y }, z) = (offset(place) - middle, z - mean);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        (xz, yz, zz) = (xz + x * z, yz + y * z, zz + z * z);
    }
    let determinant = xx * yy - xy * xy;
    // All in one line: no plane.
    if determinant <= 1e-9 * xx * yy {
        return None;
    }
    let gradient = Vec2::new((yy * xz - xy * yz) / determinant, (xx * yz - xy * xz) / determinant);
    Some(((zz - gradient.x * xz - gradient.y * yz).max(0.0) * per_count).sqrt())
}
