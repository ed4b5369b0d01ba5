//! Several runs beside each other: what differs between two of them, in what they were asked and in what came of it; what the runs of a study say
//! together.
//!
//! Reads run folders through `results`; of what the runs computed it changes nothing.

mod amount;
mod changes;
mod compare;
mod files;
mod maps;
mod page;
mod quantile;
mod record;
mod reduce;
mod reduce_text;
mod reduced_maps;
mod reduction;
mod stack;
mod state;
mod statistics;
mod tables;
#[cfg(test)]
mod tests;
mod text;

pub use amount::{Amount, rounded};
pub use changes::{Change, Changes};
pub use compare::{Comparison, RunName, compare};
pub use maps::{DifferenceMap, Differences, Extent, Spread};
pub use record::{MemberRecord, StudyRecord, VariableRecord, is_folder_name, linked, run_of, scenario_of};
pub use reduce::reduce;
pub use reduction::{Group, Reduction};
pub use state::{State, keep_failure, program_of, state};
pub use statistics::{Driver, PlaceStatistic};
pub use tables::PlaceValue;
