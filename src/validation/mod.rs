//! Problems with known answers: what every method makes of them, its order, its cost, and where it fails.
//!
//! ```text
//! Case ── setup(spacing, motion) ──→ Setup ── run(methods) ──→ Outcome ── judge(acceptance limits) ──→ Row
//! ```
//!
//! `floodsim validate`, `floodsim chart` and the tests in `tests/analytic` call the same cases. Methods are chosen by the keys of
//! `numerics:` in a scenario, so that a member of a family that the registry gains is known here without a change.
//! Deliberately absent: files (the command writes them) and anything that a run of a scenario needs.

mod case;
pub mod cases;
mod choice;
mod error;
pub mod exact;
mod judge;
mod missed;
mod outcome;
mod peers;
mod row;
mod run;
mod scene;
mod suite;
mod table;

pub use case::{AcceptanceLimit, Case, Scope, Setup, SetupResult, Suite, Until};
pub use choice::{Choice, Varied, choices};
pub use error::errors;
pub use judge::{Judgement, Limits, Measure, Share, judge};
pub use missed::{CaseRun, KNOWN_MISSES, KnownMiss, Missed, known_miss, missed_limits};
pub use outcome::{Broken, Check, Cost, Errors, Excess, Outcome, Sample, Snapshot};
pub use peers::{PEER_COLUMNS, Peer, peers_from_csv};
pub use row::{Row, Status, rows_as_csv, rows_from_csv};
pub use run::run;
pub use scene::{flat_strip, jittered_lattice, line_seeds, problem, seeds_at};
pub use suite::{CaseResult, Resolutions, run_case};
pub use table::{list_of_cases, table_of_rows};
