//! Exact solutions against the core: error and order.

#[path = "../support/mod.rs"]
mod support;

mod bowl;
mod cases;
mod channel;
mod circle;
mod constants;
mod methods;
mod resting;
mod variational;
mod walls;
