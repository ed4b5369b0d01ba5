//! Methods side by side: the dam breaks of Ritter and Stoker by every core, kernel, stabilisation and reconstruction.

use std::time::Instant;

use floodsim::scenario::methods::{Core, Kernel, Method, Reconstruction, Stabilisation};
use floodsim::validation::cases::dam_breaks::{END, channel};
use floodsim::validation::{Broken, run};

use crate::support::methods;

/// Mean errors of depth (m) and velocity (m/s): over the particles of the variational formulation, over the grid of the balanced one.
type Errors = Result<(f64, f64), Broken>;

/// One choice of everything.
#[derive(Clone, Copy, Debug)]
struct Choice {
    core: Core,
    kernel: Kernel,
    stabilisation: Stabilisation,
    reconstruction: Reconstruction,
}

impl Choice {
    /// The dam break of 10 m onto `right` (m) after 50 s, in a channel that is a plane where cells move.
    fn errors(self, spacing: f64, right: f64) -> Errors {
        let Choice { core, kernel, stabilisation, reconstruction } = self;
        let mut given = vec![("stabilisation", stabilisation.name()), ("reconstruction", reconstruction.name())];
        match core {
            Core::Eulerian => given.push(("motion", "eulerian")),
            Core::Lagrangian => given.push(("motion", "lagrangian")),
            Core::Variational => given.extend([("formulation", "variational"), ("kernel", kernel.name())]),
        }
        let setup = channel(spacing, right, END);
        let setup = if core == Core::Lagrangian { setup.in_plane() } else { setup };
        let outcome = run(&setup, &methods(&given)).1?;
        assert!(outcome.volume_error.abs() < 1e-12, "{self:?}: {:e}", outcome.volume_error);
        Ok((outcome.errors.depth, outcome.errors.velocity))
    }

    fn name(self) -> String {
        let Choice { core, kernel, stabilisation, reconstruction } = self;
        let core = match core {
            Core::Eulerian => "balanced, Eulerian",
            Core::Lagrangian => "balanced, Lagrangian",
            Core::Variational => "variational",
        };
        let kernel = if self.core == Core::Variational { kernel.name() } else { "none" };
        format!("| {core} | `{kernel}` | `{}` | `{}` |", stabilisation.name(), reconstruction.name())
    }
}

/// Every combination that a core has.
fn all_choices() -> Vec<Choice> {
    let mut choices = Vec::new();
    for &core in Core::ALL {
        for &kernel in Kernel::ALL.iter().filter(|kernel| kernel.is_in(core)) {
            for &stabilisation in Stabilisation::ALL.iter().filter(|stabilisation| stabilisation.is_in(core)) {
                for &reconstruction in Reconstruction::ALL.iter().filter(|reconstruction| reconstruction.is_in(core)) {
                    choices.push(Choice { core, kernel, stabilisation, reconstruction });
                }
            }
        }
    }
    choices
}

fn cell<T>(result: Result<T, Broken>, write: impl Fn(T) -> String) -> String {
    let why = |broken: Broken| match broken {
        Broken::Failure(failure) => format!("breaks down at {:.3} s ({})", failure.time, failure.quantity),
        Broken::TooManySteps { time, .. } => format!("its steps collapse at {time:.3} s"),
    };
    result.map_or_else(why, write)
}

/// Runs something seven times; its result, which is the same each time, and the least time (s).
fn timed<T>(run: impl Fn() -> T) -> (T, f64) {
    let once = || {
        let start = Instant::now();
        (run(), start.elapsed().as_secs_f64())
    };
    let (result, first) = once();
    (result, (0..6).map(|_| once().1).fold(first, f64::min))
}

/// The columns of a row of the page's first table: errors on the dam breaks of Ritter and Stoker.
fn columns(dry: Errors, wet: Errors) -> [String; 2] {
    [dry, wet].map(|errors| cell(errors, |(d, v)| format!("{d:.4}, {v:.4}")))
}

#[test]
fn every_combination_has_the_errors_of_the_page() {
    let page =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/validation/methods_on_dam_breaks.md"));
    let page = page.unwrap();
    let mut wrong = Vec::new();
    for choice in all_choices() {
        let name = choice.name();
        let row = page.lines().find(|line| line.starts_with(&name)).unwrap_or_else(|| panic!("{name} is not there"));
        let written: Vec<&str> = row[name.len()..].split('|').map(str::trim).collect();
        let found = columns(choice.errors(10.0, 0.0), choice.errors(10.0, 5.0));
        if !(0..2).all(|k| agree(written[k], &found[k])) {
            wrong.push(format!("{name} {found:?} on the page {:?}", &written[..2]));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whether two cells say the same: a few per cent between numbers, for truncation errors of some hundred steps.
fn agree(a: &str, b: &str) -> bool {
    let numbers = |text: &str| text.split(", ").map(str::parse).collect::<Result<Vec<f64>, _>>();
    match (numbers(a), numbers(b)) {
        (Ok(a), Ok(b)) => a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 0.03 * b + 2e-4),
        _ => a == b,
    }
}

#[test]
#[ignore = "prints the tables of docs/validation/methods_on_dam_breaks.md; some minutes"]
fn print_tables() {
    println!("| core | kernel | stabilisation | reconstruction | Ritter: m, m/s | Stoker: m, m/s | s |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for choice in all_choices() {
        let ((dry, wet), seconds) = timed(|| (choice.errors(10.0, 0.0), choice.errors(10.0, 5.0)));
        println!("{} {} | {seconds:.3} |", choice.name(), columns(dry, wet).join(" | "));
    }
}
