//! Which particles are near a place: the cell grid, and the plain double loop as its oracle. Knows no physics.

mod brute_force;
mod cell_grid;

pub use brute_force::within_brute_force;
pub use cell_grid::{CellGrid, Found, Span};
