//! Methods side by side: the dam breaks of Ritter and Stoker in a channel by every core, kernel, stabilisation and
//! reconstruction, and lakes at rest with every kernel.

use std::time::Instant;

use floodsim::math::Vec2;
use floodsim::scenario::methods::{Kernel, Reconstruction, Stabilisation};
use floodsim::validation::cases::dam_breaks::{END, channel};
use floodsim::validation::cases::lakes::{island, rough, still};
use floodsim::validation::{Broken, run};

use crate::support::methods;

/// Mean errors of depth (m) and velocity (m/s): over the particles of moving cores, over the grid of the resting one.
type Errors = Result<(f64, f64), Broken>;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Core {
    Resting,
    Moving,
    Variational,
}

impl Core {
    const ALL: [Core; 3] = [Core::Resting, Core::Moving, Core::Variational];

    fn name(self) -> &'static str {
        match self {
            Core::Resting => "balanced, Eulerian",
            Core::Moving => "balanced, Lagrangian",
            Core::Variational => "variational",
        }
    }

    fn stabilisations(self) -> &'static [Stabilisation] {
        use Stabilisation::{ArtificialViscosity, LaxFriedrichs, TwoRarefactions, TwoShocks, TwoWaves};
        match self {
            Core::Resting => &[TwoRarefactions, LaxFriedrichs],
            Core::Moving => &[TwoShocks, TwoWaves, LaxFriedrichs],
            Core::Variational => &[ArtificialViscosity, LaxFriedrichs, TwoShocks, TwoWaves],
        }
    }

    fn reconstructions(self) -> &'static [Reconstruction] {
        if self == Core::Resting { Reconstruction::ALL } else { &[Reconstruction::Limited, Reconstruction::None] }
    }

    fn kernels(self) -> &'static [Kernel] {
        if self == Core::Resting { &[Kernel::CubicSpline] } else { Kernel::ALL }
    }
}

/// One choice of everything.
#[derive(Clone, Copy, Debug)]
struct Choice {
    core: Core,
    kernel: Kernel,
    stabilisation: Stabilisation,
    reconstruction: Reconstruction,
}

impl Choice {
    /// The dam break of 10 m onto `right` (m) after 50 s.
    fn errors(self, spacing: f64, right: f64) -> Errors {
        let Choice { core, kernel, stabilisation, reconstruction } = self;
        let mut given = vec![("stabilisation", stabilisation.name()), ("reconstruction", reconstruction.name())];
        match core {
            Core::Resting => given.push(("motion", "eulerian")),
            Core::Moving => given.extend([("motion", "lagrangian"), ("kernel", kernel.name())]),
            Core::Variational => given.extend([("formulation", "variational"), ("kernel", kernel.name())]),
        }
        let outcome = run(&channel(spacing, right, END), &methods(&given)).1?;
        assert!(outcome.volume_error.abs() < 1e-12);
        Ok((outcome.errors.depth, outcome.errors.velocity))
    }

    fn name(self) -> String {
        let Choice { core, kernel, stabilisation, reconstruction } = self;
        let names = [kernel.name(), stabilisation.name(), reconstruction.name()];
        format!("| {} | `{}` | `{}` | `{}` |", core.name(), names[0], names[1], names[2])
    }
}

/// Every combination that a core has.
fn all_choices() -> Vec<Choice> {
    let mut choices = Vec::new();
    for core in Core::ALL {
        for &kernel in core.kernels() {
            for &stabilisation in core.stabilisations() {
                for &reconstruction in core.reconstructions() {
                    choices.push(Choice { core, kernel, stabilisation, reconstruction });
                }
            }
        }
    }
    choices
}

/// Greatest speed (m/s) of a lake of Lagrangian particles in the plane in a few hundred steps.
fn lake_speed(kernel: Kernel, bed: fn(Vec2) -> f64, jitter: f64) -> Result<f64, Broken> {
    let (cost, ended) =
        run(&still(bed, 0.25, jitter, 300), &methods(&[("motion", "lagrangian"), ("kernel", kernel.name())]));
    ended.map(|_| cost.max_speed)
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

/// Four lakes: a bed, and by how many spacings the places of particles are moved.
const LAKES: [Lake; 4] = [(rough, 0.0), (rough, 0.3), (island, 0.0), (island, 0.15)];
type Lake = (fn(Vec2) -> f64, f64);

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
fn lakes_are_at_rest_with_every_kernel() {
    for &kernel in Kernel::ALL {
        let speeds = LAKES.map(|(bed, jitter)| lake_speed(kernel, bed, jitter).unwrap());
        let fastest = speeds.into_iter().fold(0.0, f64::max);
        assert!(fastest < 1e-12, "{}: {speeds:?} m/s", kernel.name());
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
    println!("\n| kernel | rough | rough, jitter 0.3 | island | island, jitter 0.15 | s |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for &kernel in Kernel::ALL {
        let (speeds, seconds) = timed(|| LAKES.map(|(bed, jitter)| lake_speed(kernel, bed, jitter)));
        let speeds = speeds.map(|speed| cell(speed, |speed| format!("{speed:.1e}")));
        println!("| `{}` | {} | {seconds:.2} |", kernel.name(), speeds.join(" | "));
    }
}
