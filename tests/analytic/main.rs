//! Exact solutions against the core: error and order.

#[path = "../support/mod.rs"]
mod support;

mod channel;
mod bowl;
mod lake;
mod circle;
mod walls;
