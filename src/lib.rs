//! Inundation maps from terrain rasters and reservoir polygons, by smoothed particle hydrodynamics for the shallow-water
//! equations.
//!
//! Data flows one way, and the modules stand in its order:
//! scenario → terrain → bed → seeding → solver → output → maps. `pipeline` shows one whole run on one screen.

pub mod calendar;
pub mod checksum;
pub mod cli;
pub mod csv;
pub mod error;
pub mod gate;
pub mod geodata;
pub mod laboratory;
pub mod maps;
pub mod matrix;
pub mod output;
pub mod pipeline;
pub mod plain_file;
pub mod prepare;
pub mod problems;
pub mod report;
pub(crate) mod results;
pub mod scenario;
pub mod study;
pub mod terrain;
pub mod validation;
pub mod vector;
pub mod version;

pub use floodsim_core::{
    bed, boundary, constants, gridding, lattice, math, neighbours, particles, partition, physics, seeding, solver,
};
