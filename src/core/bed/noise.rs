//! How rough the terrain is inside a cell: the scatter of its pixels about their own plane.
//!
//! ```text
//! σ = √(Σ r²/m),   r = z − z̄ − g·(x − x̄),   g of least squares
//! ```

use rayon::prelude::*;

use super::Pixels;
use super::mean::Plane;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::terrain::Piece;

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
    let known = places.zip(values.iter()).filter(|(_, z)| !z.is_nan());
    let piece =
        |((column, row), &elevation)| Piece { offset: grid.centre(column, row) - centre, elevation, share: 1.0 };
    let pieces: Vec<Piece> = known.map(piece).collect();
    if pieces.len() < FEWEST_PIXELS {
        return None;
    }
    let plane = Plane::fitted(&pieces);
    let squares: f64 = pieces.iter().map(|piece| plane.residual(piece).powi(2)).sum();
    Some((squares / pieces.len() as f64).sqrt())
}
