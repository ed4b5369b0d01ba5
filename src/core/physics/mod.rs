//! The formulas of the model, one method per file: no files, no threads, no errors, no allocation. Imports only `math`.

pub mod breach;
pub mod dimension;
pub mod flux;
pub mod friction;
pub mod kernel;
pub mod limiter;
pub mod open_boundary;
pub mod tracer;
pub mod turbulence;
pub mod xu_zhang;

/// Speed of small waves c = √(g d) (m/s) at a depth (m) of 0 or more.
#[inline(always)]
pub fn celerity(depth: f64, gravity: f64) -> f64 {
    (gravity * depth).sqrt()
}
