//! A reduced study in words.

use std::fmt;

use super::reduction::{Group, Reduction};
use super::statistics::{Driver, PlaceStatistic};

/// So many members that are left out are named.
const NAMED: usize = 20;

impl fmt::Display for Reduction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let used = self.members - self.left_out.len();
        writeln!(f, "{}: {used} of {} members", self.title, self.members)?;
        for (member, why) in self.left_out.iter().take(NAMED) {
            writeln!(f, "  left out   member {member}: {why}")?;
        }
        if self.left_out.len() > NAMED {
            writeln!(f, "  left out   and {} more", self.left_out.len() - NAMED)?;
        }
        self.doubts.iter().try_for_each(|doubt| writeln!(f, "  warning    {doubt}"))?;
        self.groups.iter().try_for_each(|group| write_group(f, group))
    }
}

impl Reduction {
    /// The reduction as JSON.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

fn write_group(f: &mut fmt::Formatter<'_>, group: &Group) -> fmt::Result {
    let name = if group.name.is_empty() { String::new() } else { format!("{}: ", group.name) };
    writeln!(f, "{name}{} members, in {}", group.members.len(), group.folder.display())?;
    if group.places.is_empty() {
        return Ok(());
    }
    writeln!(f, "{:<34} {:>11} {:>12} {:>12} {:>12}  rank correlation", "", "reached", "P5", "P50", "P95")?;
    for PlaceStatistic { kind, id, quantity, runs, reached, values, drivers } in &group.places {
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"));
        let [_, p5, p50, p95, _] = values.map(number);
        let drivers: Vec<String> = drivers.iter().take(3).map(Driver::words).collect();
        let name = if *kind == "map" { id.clone() + " m2" } else { format!("{id} {quantity}") };
        let reached = format!("{reached} of {runs}");
        writeln!(f, "{name:<34} {reached:>11} {p5:>12} {p50:>12} {p95:>12}  {}", drivers.join(", "))?;
    }
    Ok(())
}
