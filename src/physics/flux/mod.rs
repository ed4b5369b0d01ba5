//! Riemann solvers of the shallow-water equations on a level bed.

pub mod exact;
mod two_shock;

pub use two_shock::{Star, two_shock};
