//! The checks on tiny made inputs, one for each kind of bad input, and on real ones.

mod bad_inputs;
mod banks;
mod breach;
mod channels;
mod ground;
mod heights;
mod malpasset;
mod netcdf;
mod ridges;
mod roughness;
mod scene;
mod sources;
mod start;
mod still_water;
