//! The scenario: what the user writes in YAML, checked and resolved to SI units with every default filled in.
//!
//! A text goes through `tree` (values with places), `preset` (a named set of choices becomes single ones), `read` and `schema` (typed sections, all problems), and `resolve`
//! (defaults) into the `Scenario` of `model`; `resolved_yaml` writes it down again (as values of `yaml`).

pub mod breach;
pub mod channel;
mod channels_alone;
pub mod choices;
mod defaults;
pub mod fields;
pub mod ground;
mod model;
pub mod moving_bed;
mod preset;
pub mod read;
mod resolve;
mod resolved_yaml;
pub mod schema;
pub mod start;
pub mod timed;
pub mod tree;
pub mod units;
mod yaml;

pub use defaults::{DRY_DEPTH, GRAVITY};
pub use floodsim_core::constants::Constants;
pub use floodsim_core::methods;
pub use ground::{Breakline, BreaklineMode, BuildingMode, Buildings, Gaps, Ground, LayerMode, LineLevel};
pub use model::*;
pub use moving_bed::{BedMovement, MovingBed};
pub use resolve::{Loaded, load, resolve};
pub use start::{EarlierRun, RiverWidth, Start, WaterOfDepth};
