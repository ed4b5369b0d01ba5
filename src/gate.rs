//! Quality gates: figures of a run that are held to limits. The run writes them to `run.json`; its report and a run that goes on from it
//! read them there.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize};

/// A figure of a run and the limit that it is held to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gate {
    /// What is measured.
    pub name: String,
    /// The figure, relative; null in JSON where it is infinite.
    #[serde(deserialize_with = "infinite_where_null")]
    pub figure: f64,
    /// Its limit.
    pub limit: f64,
    /// Whether the figure is within the limit.
    pub passed: bool,
    /// Whether a run that misses the limit fails; otherwise that is reported for the planner to judge.
    pub binding: bool,
    /// What else there is to say.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

impl Gate {
    /// A gate that fails the run where its figure exceeds its limit.
    pub fn binding(name: &str, figure: f64, limit: f64) -> Gate {
        Gate { name: name.to_owned(), figure, limit, passed: figure <= limit, binding: true, note: String::new() }
    }

    /// Whether it fails the run.
    pub fn fails(&self) -> bool {
        self.binding && !self.passed
    }
}

impl fmt::Display for Gate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = match (self.passed, self.binding) {
            (true, _) => "passed",
            (false, true) => "failed",
            (false, false) => "reported",
        };
        write!(f, "{verdict}: {}, {:.1e} relative, limit {:.0e}", self.name, self.figure, self.limit)?;
        if self.note.is_empty() { Ok(()) } else { write!(f, "; {}", self.note) }
    }
}

fn infinite_where_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gates_come_back_from_their_record() {
        let worst = Gate { binding: false, note: "at the weir".into(), ..Gate::binding("share", 0.2, 0.1) };
        for (gate, line, fails) in [
            (Gate::binding("balance", 1e-12, 1e-9), "passed: balance, 1.0e-12 relative, limit 1e-9", false),
            (Gate::binding("balance", f64::INFINITY, 1e-9), "failed: balance, inf relative, limit 1e-9", true),
            (worst, "reported: share, 2.0e-1 relative, limit 1e-1; at the weir", false),
        ] {
            let text = serde_json::to_string(&gate).unwrap();
            let read: Gate = serde_json::from_str(&text).unwrap();
            assert_eq!((&read, read.to_string().as_str(), read.fails()), (&gate, line, fails), "{text}");
        }
    }
}
