//! The scenario: what the user writes in YAML, checked and resolved to SI units with every default filled in.
//!
//! A text goes through `tree` (values with places), `preset` (a named set of choices becomes single ones), `read` and `sections`
//! (typed sections, all problems, defaults) into the `Scenario` of `model`; `resolve` is the way through all of it. `sections`
//! write it down again, as values of `yaml`.

pub mod choices;
mod defaults;
#[cfg(test)]
mod documented;
pub mod fields;
mod machine;
mod model;
mod preset;
pub mod read;
mod resolve;
pub mod sections;
pub mod timed;
pub mod tree;
pub mod units;
mod yaml;

pub use defaults::{DRY_DEPTH, GRAVITY};
pub use floodsim_core::constants::Constants;
pub use floodsim_core::methods;
pub use model::*;
pub use resolve::{Loaded, load, resolve};
