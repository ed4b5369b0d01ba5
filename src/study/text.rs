//! A comparison in words: what was changed, and what came of it.

use std::fmt;

use super::changes::Change;
use super::compare::{Comparison, RunName};
use super::maps::Spread;
use super::tables::PlaceValue;
use crate::maps::clock;

/// So many changes of the scenario are named, and so many values of gauges and sections.
const NAMED: usize = 30;

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = &self.runs;
        writeln!(f, "first        {}", described(first))?;
        writeln!(f, "second       {}", described(second))?;
        self.write_changes(f)?;
        let km2 = |area: f64| area / 1e6;
        let extent = &self.on_maps.extent;
        writeln!(
            f,
            "flooded      {:.4} km2, {:.4} km2 ({}), from a depth of {} m on",
            km2(extent.first_m2),
            km2(extent.second_m2),
            percent(extent.first_m2, extent.second_m2),
            extent.depth_m
        )?;
        writeln!(
            f,
            "  in both    {:.4} km2; in the first alone {:.4}, in the second alone {:.4}; overlap {:.3}",
            km2(extent.both_m2),
            km2(extent.first_m2 - extent.both_m2),
            km2(extent.second_m2 - extent.both_m2),
            extent.overlap()
        )?;
        writeln!(f, "second less first, where both are flooded; of depth, where one is")?;
        writeln!(f, "                          mean  90 % within     greatest  at")?;
        for map in &self.on_maps.maps {
            let name = map.name.trim_end_matches("_difference").replace('_', " ");
            let unit = map.units.replace("m2 s-1", "m2/s").replace("m s-1", "m/s");
            match map.spread {
                Some(Spread { mean, usual, greatest, x, y, .. }) => {
                    writeln!(f, "{name:<18} {unit:<4} {mean:>+7.3} {usual:>12.3} {greatest:>+12.3}  {x:.1}, {y:.1}")?
                }
                None => writeln!(f, "{name:<18} {unit:<4} no place has it in both")?,
            }
        }
        self.write_places(f)
    }
}

impl Comparison {
    fn write_changes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let changes = &self.changes;
        if changes.is_empty() {
            return writeln!(f, "changed      nothing that has an effect: scenario, inputs and program are the same");
        }
        let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "not there".to_owned());
        let line = |change: &Change| format!("{}: {} -> {}", change.what, value(&change.first), value(&change.second));
        let scenario = changes.scenario.iter().map(line);
        let inputs = changes.inputs.iter().map(|change| format!("{}: another file", change.what));
        let lines: Vec<String> = scenario.chain(inputs).chain(changes.program.iter().map(line)).collect();
        for (k, line) in lines.iter().take(NAMED).enumerate() {
            writeln!(f, "{:<12} {line}", if k == 0 { "changed" } else { "" })?;
        }
        if lines.len() > NAMED { writeln!(f, "{:<12} and {} more", "", lines.len() - NAMED) } else { Ok(()) }
    }

    fn write_places(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let there: Vec<&PlaceValue> =
            self.places.iter().filter(|place| place.first.is_some() || place.second.is_some()).collect();
        if there.is_empty() {
            return Ok(());
        }
        writeln!(f, "{:<34} {:>14} {:>14} {:>14}", "at gauges and sections", "first", "second", "difference")?;
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"));
        for place in there.iter().take(NAMED) {
            let [first, second] = [place.first, place.second].map(number);
            let difference = place.difference().map_or_else(|| "-".to_owned(), |value| format!("{value:+.3}"));
            let name = format!("{} {}", place.id, place.quantity);
            writeln!(f, "{name:<34} {first:>14} {second:>14} {difference:>14}")?;
        }
        match there.len().checked_sub(NAMED).filter(|more| *more > 0) {
            Some(more) => writeln!(f, "and {more} more; --json and --out have all"),
            None => Ok(()),
        }
    }
}

fn described(run: &RunName) -> String {
    let mut parts = vec![format!("{} ({})", run.folder.display(), run.title)];
    parts.extend(run.simulated_s.map(|time| format!("{} simulated", clock(time))));
    parts.push(format!("maps of {} m", run.cell_m));
    parts.extend(run.volume_m3.map(|volume| format!("{volume:.4e} m3 of water")));
    parts.extend(run.cpu_s.map(|seconds| format!("{seconds:.1} CPU s")));
    parts.extend(run.doubt.clone());
    parts.join(", ")
}

fn percent(first: f64, second: f64) -> String {
    if first > 0.0 { format!("{:+.1} %", 100.0 * (second / first - 1.0)) } else { "the first has none".to_owned() }
}
