//! How many rows the series of gauges and cross-sections get: they are kept in memory until the end of the run.

use crate::error::{Problem, ProblemKind};
use crate::prepare::findings::Findings;
use crate::scenario::{Scenario, Sourced, VectorSource};

/// Rows of the series of a file at most; each takes some 60 bytes of memory and of disk.
const MOST: f64 = 1e7;

/// Refuses so many places whose series would have too many rows.
pub(super) fn check(source: &Sourced<VectorSource>, places: usize, scenario: &Scenario, findings: &mut Findings) {
    let interval = scenario.outputs.gauges_every;
    let rows = places as f64 * scenario.end_time / interval;
    if rows <= MOST {
        return;
    }
    let name = source.value.path.display();
    let message = format!("the series of the {places} places of {name} would have {rows:.2e} rows");
    let least = (places as f64 * scenario.end_time / MOST * 1e3).ceil() / 1e3;
    let problem = Problem::error(ProblemKind::Scenario, "too-many-outputs", "", message)
        .with_cause(format!("`outputs.gauges_every` is {interval} s, and {MOST:.0e} rows are the most"))
        .with_remedy(format!("set `outputs.gauges_every` to {least} s or more, or take fewer places"));
    findings.add(source, problem);
}
