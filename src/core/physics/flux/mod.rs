//! Riemann solvers of the shallow-water equations on a level bed: for faces that move with the water (`FaceSolver`) and for
//! faces at rest.

pub mod exact;
mod face;
mod hllc;
mod lax_friedrichs;
mod two_shock;

pub use face::{FaceSolver, Hllc, LaxFriedrichs, Side, TwoShocks};
pub use lax_friedrichs::lax_friedrichs;
pub use two_shock::{Star, two_shock};
