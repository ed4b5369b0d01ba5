//! The numerical core: from terrain in memory to the water of each step, without files and their formats.
//!
//! Data flows one way, and the modules stand in its order: terrain → bed → seeding → solver → gridding. Builds and tests without GDAL and
//! NetCDF.

pub mod bed;
pub mod boundary;
pub mod constants;
pub mod failure;
pub mod gridding;
pub mod lattice;
pub mod math;
pub mod methods;
pub mod neighbours;
pub mod particles;
pub mod partition;
pub mod physics;
pub mod seeding;
pub mod solver;
pub mod terrain;
pub mod triangulation;
