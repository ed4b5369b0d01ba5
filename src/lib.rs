//! Inundation maps from terrain rasters and reservoir polygons, by smoothed particle hydrodynamics for the shallow-water
//! equations.
//!
//! Data flows one way, and the modules stand in its order:
//! scenario → terrain → bed → seeding → solver → output → maps. `pipeline` shows one whole run on one screen.

pub mod bed;
pub mod boundary;
pub mod cli;
pub mod error;
pub mod geodata;
pub mod gridding;
pub mod laboratory;
pub mod lattice;
pub mod maps;
pub mod math;
pub mod neighbours;
pub mod output;
pub mod particles;
pub mod physics;
pub mod pipeline;
pub mod prepare;
pub mod report;
pub mod scenario;
pub mod seeding;
pub mod solver;
pub mod terrain;
pub mod validation;
pub mod vector;
pub mod version;
