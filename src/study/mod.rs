//! Several runs beside each other: what differs between two of them, in what they were asked and in what came of it.
//!
//! Reads run folders through `results`; of what the runs computed it changes nothing.

mod changes;
mod compare;
mod maps;
mod tables;
#[cfg(test)]
mod tests;
mod text;

pub use changes::{Change, Changes};
pub use compare::{Comparison, RunName, compare};
pub use maps::{DifferenceMap, Differences, Extent, Spread};
pub use tables::PlaceValue;
