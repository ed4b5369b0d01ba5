//! Bed friction.

pub mod manning;
