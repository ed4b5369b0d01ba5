//! Riemann solvers of the shallow-water equations on a level bed: for faces that move with the water (`FaceSolver`) and for
//! faces at rest.

pub mod exact;
mod face;
mod lax_friedrichs;
mod two_shock;
mod two_waves;

pub use face::{FaceSolver, LaxFriedrichs, Side, TwoShocks, TwoWaves};
pub use lax_friedrichs::lax_friedrichs;
pub use two_shock::{Star, two_shock};
