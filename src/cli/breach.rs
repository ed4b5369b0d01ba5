//! `floodsim breach`: what common formulas say of a breach, beside each other.

use std::fmt::Write;

use super::args::{BreachArguments, ModeArgument};
use super::print;
use crate::error::Error;
use crate::physics::breach::{BreachEstimate, FailureMode, PeakEstimate, breach_estimates, peak_estimates};
use crate::physics::xu_zhang::{Erodibility, eroded_breach};
use crate::scenario::GRAVITY;

/// Prints the table.
pub fn breach(arguments: &BreachArguments) -> Result<(), Error> {
    let (volume, height) = (arguments.volume, arguments.height);
    for (name, value) in [("volume", volume), ("height", height)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::Usage(format!("--{name} must be greater than 0, not {value}")));
        }
    }
    let mode = match arguments.mode {
        ModeArgument::Overtopping => FailureMode::Overtopping,
        ModeArgument::Piping => FailureMode::Piping,
    };
    print(&table(volume, height, mode))
}

fn table(volume: f64, height: f64, mode: FailureMode) -> String {
    let estimates = breach_estimates(volume, height, mode, GRAVITY);
    let how = if mode == FailureMode::Overtopping { "overtopping" } else { "piping" };
    let mut text = format!("An embankment dam, {height} m high, {volume} m³ of water above the breach, {how}\n\n");
    let mut line = |cells: [&str; 5]| {
        let [name, mean, bottom, slope, time] = cells;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<38}{mean:>12}{bottom:>14}{slope:>12}{time:>16}");
    };
    line(["formula", "mean width", "bottom width", "side slope", "time"]);
    let metres = |width: Option<f64>| width.map_or("-".to_owned(), |width| format!("{width:.1} m"));
    for estimate in &estimates {
        let cells = [
            metres(estimate.mean_width),
            metres(estimate.bottom_width(height)),
            format!("{:.1}", estimate.side_slope),
            minutes(estimate.time),
        ];
        line([estimate.name, &cells[0], &cells[1], &cells[2], &cells[3]]);
    }
    let of_times = |pick: fn(f64, f64) -> f64, from: f64| estimates.iter().flat_map(|e| e.time).fold(from, pick);
    let of_widths =
        |pick: fn(f64, f64) -> f64, from: f64| estimates.iter().filter_map(|e| e.mean_width).fold(from, pick);
    let cells = [
        format!("{:.0}-{:.0} m", of_widths(f64::min, f64::INFINITY), of_widths(f64::max, 0.0)),
        minutes([of_times(f64::min, f64::INFINITY), of_times(f64::max, 0.0)]),
    ];
    line(["range", &cells[0], "", "", &cells[1]]);
    text += &peaks(volume, height);
    text += &spreads(&estimates);
    text += &eroded(volume, height, mode);
    let mass = estimates.iter().find_map(|estimate: &BreachEstimate| estimate.eroded).unwrap_or_default();
    let _ = write!(
        text,
        "\nSide slopes are horizontal to vertical; the mean width is that at half the height. MacDonald &\n\
         Langridge-Monopolis erode {mass:.0} m³ of an earthfill dam, which is a width with its section only. The times\n\
         after Von Thun & Gillette are those of easily erodible and of erosion-resistant dams. All are fits to past failures\n\
         of embankments, none to concrete dams: run the scenario with several.\n"
    );
    text
}

/// The peak discharges with their prediction intervals.
fn peaks(volume: f64, height: f64) -> String {
    let mut text = format!("\n{:<38}{:>12}{:>26}\n", "peak discharge", "m3/s", "95 % interval");
    for PeakEstimate { name, discharge, of_failures } in peak_estimates(volume, height) {
        let range = of_failures
            .map_or_else(|| "-".to_owned(), |[from, to]| format!("{:.0}-{:.0} m3/s", from * discharge, to * discharge));
        let _ = writeln!(text, "{name:<38}{discharge:>12.0}{range:>26}");
    }
    text
}

/// The prediction intervals as shares of what a formula says.
fn spreads(estimates: &[BreachEstimate]) -> String {
    let shares = |shares: Option<[f64; 2]>| shares.map_or_else(|| "-".to_owned(), |[from, to]| format!("{from}-{to}"));
    let mut text =
        "\n95 % prediction interval as shares of the formula (Wahl 2004), from past failures without outliers\n"
            .to_owned();
    let _ = writeln!(text, "{:<38}{:>12}{:>14}", "", "mean width", "time");
    for estimate in estimates.iter().filter(|estimate| estimate.time_of_failures.is_some()) {
        let (width, time) = (shares(estimate.width_of_failures), shares(estimate.time_of_failures));
        let _ = writeln!(text, "{:<38}{width:>12}{time:>14}", estimate.name);
    }
    text
}

/// What Xu and Zhang say, by the erodibility of the dam.
fn eroded(volume: f64, height: f64, mode: FailureMode) -> String {
    let mut text = format!(
        "\n{:<38}{:>12}{:>14}{:>12}{:>16}\n",
        "Xu & Zhang 2009, homogeneous fill", "mean width", "peak m3/s", "side slope", "all erosion"
    );
    for (erodibility, name) in Erodibility::ALL {
        let found = eroded_breach(volume, height, mode, erodibility, GRAVITY);
        let (width, time) = (format!("{:.1} m", found.mean_width), minutes([found.time; 2]));
        let name = format!("  {name} erodibility");
        let _ = writeln!(text, "{name:<38}{width:>12}{:>14.0}{:>12.1}{time:>16}", found.discharge, found.side_slope);
    }
    text + "The time is that until all erosion ends, longer than a breach takes to form: no formation time.\n"
}

/// One time, or a range, in minutes.
fn minutes([from, to]: [f64; 2]) -> String {
    if to > from { format!("{:.0}-{:.0} min", from / 60.0, to / 60.0) } else { format!("{:.0} min", from / 60.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_every_formula_and_the_range() {
        let text = table(1e7, 30.0, FailureMode::Overtopping);
        let line = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
        let words = |name: &str| line(name).split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words("Froehlich 2008")[2..], ["69.9", "m", "39.9", "m", "1.0", "35", "min"]);
        assert!(line("MacDonald").contains(" - ") && line("Von Thun").contains("27-51 min"));
        assert_eq!(words("range")[1..], ["70-118", "m", "27-67", "min"]);
        assert!(text.contains("86208 m³"));
        assert_eq!(words("  medium erodibility")[2..], ["75.4", "m", "6172", "1.1", "88", "min"]);
    }
}
