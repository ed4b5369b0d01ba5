//! Riemann solvers of the shallow-water equations on a level bed: for faces that move with the water (`FaceSolver`) and for
//! faces at rest.

pub mod exact;
mod face;
mod lax_friedrichs;
mod side;
mod two_shock;
mod two_waves;

pub use face::{FaceSolver, LaxFriedrichs, TwoShocks, TwoWaves};
pub use lax_friedrichs::lax_friedrichs;
pub use side::Side;
pub use two_shock::{Star, two_shock};
