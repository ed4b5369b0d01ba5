//! `floodsim chart`: speed against accuracy of methods, as CSV and one figure for each case and error.

use std::path::{Path, PathBuf};

use super::args::ChartArguments;
use super::print;
use super::validate::{chosen_cases, make_folder, run_cases, write};
use crate::error::{Error, Problem, ProblemKind};
use crate::maps::{ChartLine, ChartPeers, ChartPoint, speed_against_accuracy};
use crate::plain_file;
use crate::validation::{Peer, Row, peers_from_csv, rows_as_csv, rows_from_csv};

/// Errors below this (m, m/s) are rounding: nothing to draw.
const ROUNDING: f64 = 1e-10;

/// What the errors of both motions are means of.
const NORM: &str = "Mean over wet cells in the balanced formulation, over particles in the variational one.";

/// Runs the cases or reads their rows, and writes `chart.csv` and the figures.
///
/// # Errors
/// `Error::Usage` for wrong names and files that hold no rows, `Error::Problems` for a table of peers that is unfit, `Error::Output`
/// for the folder.
pub fn chart(arguments: &ChartArguments) -> Result<(), Error> {
    let chosen = chosen_cases(&arguments.cases)?;
    let peers = arguments.peers.as_deref().map(read_peers).transpose()?.unwrap_or_default();
    let folder = &arguments.out;
    let table = folder.join("chart.csv");
    let text = match &arguments.from {
        Some(file) => plain_file::read_to_string(file)
            .map_err(|cause| Error::Usage(format!("{} cannot be read: {cause}", file.display())))?,
        None => {
            make_folder(folder)?;
            let runs = run_cases(&chosen, &arguments.cases, arguments.resolutions)?;
            rows_as_csv(&runs.into_iter().flat_map(|run| run.result.rows).collect::<Vec<_>>())
        }
    };
    // The figures show what the table says, to its last digit.
    let source = arguments.from.as_ref().unwrap_or(&table).display();
    let rows = rows_from_csv(&text).map_err(|fault| Error::Usage(format!("{source}: {fault}")))?;
    make_folder(folder)?;
    write(&table, &text)?;
    let mut files = vec![table];
    // A lake at rest is right or wrong: no figure.
    for case in chosen
        .into_iter()
        .filter(|case| case.acceptance_limits.iter().all(|acceptance_limit| acceptance_limit.max_speed.is_none()))
    {
        let of_case: Vec<&Row> = rows.iter().filter(|row| row.case == case.name).collect();
        let others: Vec<&Peer> = peers
            .iter()
            .filter(|peer| peer.case == case.name && of_case.iter().any(|row| row.norm == peer.norm))
            .collect();
        for (name, label, error, error_of_peer) in ERRORS {
            let lines = lines(&of_case, error);
            if lines.iter().all(|line| line.points.is_empty()) {
                continue;
            }
            let title = format!("{}: {name}", case.name);
            let file = folder.join(format!("{}_{name}.svg", case.name));
            let about = format!("{} {NORM}", case.about);
            let elsewhere = ChartPeers { source: peers_name(arguments), points: peer_points(&others, error_of_peer) };
            write(&file, &speed_against_accuracy(&title, &about, label, &lines, &elsewhere))?;
            files.push(file);
        }
    }
    print(&files.iter().map(|file: &PathBuf| format!("{}\n", file.display())).collect::<String>())
}

/// Reads what other codes made of the cases.
fn read_peers(file: &Path) -> Result<Vec<Peer>, Error> {
    let text = plain_file::read_to_string(file).map_err(|cause| {
        let message = format!("the file `{}` cannot be read", file.display());
        let problem = Problem::error(ProblemKind::Input, "unreadable-file", "", message);
        Error::Problems(vec![problem.with_cause(cause.to_string()).with_remedy("correct the path of --peers")])
    })?;
    peers_from_csv(&text, file).map_err(Error::Problems)
}

fn peers_name(arguments: &ChartArguments) -> String {
    let name = arguments.peers.as_deref().and_then(Path::file_name);
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn peer_points(peers: &[&Peer], error: fn(&Peer) -> Option<f64>) -> Vec<ChartPoint> {
    let point = |peer: &&Peer| {
        let label = format!("{} {} m", peer.code, three_digits(peer.spacing));
        Some(ChartPoint { cost: peer.cpu_s, error: error(peer)?, label })
    };
    peers.iter().filter_map(point).collect()
}

/// A number with three digits that count, without zeros at its end.
fn three_digits(value: f64) -> String {
    let decimals = (2.0 - value.log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    if decimals == 0 { text } else { text.trim_end_matches('0').trim_end_matches('.').to_owned() }
}

type ErrorOf<T> = fn(&T) -> Option<f64>;

const ERRORS: [(&str, &str, ErrorOf<Row>, ErrorOf<Peer>); 2] = [
    ("depth", "mean absolute error of the depth (m)", |row| row.error_depth, |peer| peer.error_depth),
    ("velocity", "mean absolute error of the velocity (m/s)", |row| row.error_velocity, |peer| peer.error_velocity),
];

/// One line for each method, with the spacings as points.
fn lines(rows: &[&Row], error: ErrorOf<Row>) -> Vec<ChartLine> {
    let families: [fn(&Row) -> &str; 5] =
        [|row| &row.formulation, |row| &row.motion, |row| &row.flux, |row| &row.kernel, |row| &row.integrator];
    // What all rows share needs no mention; which motion it is always does.
    let differs = families.map(|family| rows.iter().any(|row| family(row) != family(rows[0])));
    let name = |row: &Row| {
        let named = families.iter().enumerate().filter(|(k, _)| *k == 1 || differs[*k]).map(|(_, family)| family(row));
        named.map(str::to_owned).chain(other_methods(row)).collect::<Vec<_>>().join(", ")
    };
    let mut lines: Vec<ChartLine> = Vec::new();
    for row in rows {
        let name = name(row);
        let index = lines.iter().position(|line| line.name == name).unwrap_or_else(|| {
            lines.push(ChartLine { name, points: Vec::new() });
            lines.len() - 1
        });
        if let Some(error) = error(row).filter(|error| *error > ROUNDING) {
            lines[index].points.push(ChartPoint { cost: row.cpu_s, error, label: format!("{} m", row.spacing_m) });
        }
    }
    lines
}

/// Families without a column stand at the beginning of the note, as `cfl 0.8`.
fn other_methods(row: &Row) -> Option<String> {
    let known = ["cfl ", "dry_depth ", "wall ", "reconstruction ", "turbulence ", "preset "];
    let parts: Vec<&str> =
        row.note.split("; ").take_while(|part| known.iter().any(|key| part.starts_with(key))).collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spacings_are_short() {
        let pairs = [(15.625, "15.6"), (10.0, "10"), (0.25, "0.25"), (0.195_312, "0.195"), (1200.0, "1200")];
        for (value, expected) in pairs {
            assert_eq!(three_digits(value), expected);
        }
    }
}
