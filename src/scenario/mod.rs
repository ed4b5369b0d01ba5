//! The scenario: what the user writes in YAML, checked and resolved to SI units with every default filled in.

pub mod methods;
mod model;

pub use model::*;
