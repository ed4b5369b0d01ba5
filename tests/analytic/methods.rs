//! Methods side by side: the dam breaks of Ritter and Stoker in a channel by every core, kernel, stabilisation and
//! reconstruction, and lakes at rest with every kernel.

use std::time::Instant;

use floodsim::error::NumericalFailure;
use floodsim::math::Vec2;
use floodsim::physics::dimension::Dimension;
use floodsim::scenario::methods::{Integrator, Kernel, Reconstruction, Stabilisation};
use floodsim::solver::lagrangian::LagrangianSolver;
use floodsim::solver::moving::{Formulation, MovingMethods, MovingSolver};
use floodsim::solver::variational::VariationalSolver;
use floodsim::solver::{EulerianSolver, FlowSolver};

use crate::channel::{DAM, DEEP, END, dam_break};
use crate::lake::{self, lake_of};
use crate::resting::channel_errors_by;
use crate::support::{max_speed, mean_errors, ritter, stoker};

/// Mean errors of depth (m) and velocity (m/s): over the particles of moving cores, over the grid of the resting one.
type Errors = Result<(f64, f64), NumericalFailure>;

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
            Core::Resting => "balanced, resting",
            Core::Moving => "balanced, moving",
            Core::Variational => "variational",
        }
    }

    fn stabilisations(self) -> &'static [Stabilisation] {
        use Stabilisation::{ArtificialViscosity, Hllc, LaxFriedrichs, TwoShocks};
        match self {
            Core::Resting => &[Hllc, LaxFriedrichs],
            Core::Moving => &[TwoShocks, Hllc, LaxFriedrichs],
            Core::Variational => &[ArtificialViscosity, LaxFriedrichs, TwoShocks, Hllc],
        }
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
    fn methods(self) -> MovingMethods {
        let Choice { kernel, stabilisation, reconstruction, .. } = self;
        MovingMethods { kernel, reconstruction, ..MovingMethods::new(Integrator::Leapfrog, stabilisation) }
    }

    /// The dam break of 10 m onto `right` (m) after 50 s.
    fn errors(self, spacing: f64, right: f64) -> Errors {
        let Choice { stabilisation, reconstruction, .. } = self;
        let (problem, seeds) = dam_break(spacing, right, 0.4);
        let one = Dimension::One;
        match self.core {
            Core::Resting => {
                channel_errors_by(|p| EulerianSolver::with_methods(p, stabilisation, reconstruction), spacing, right)
            }
            Core::Moving => errors(LagrangianSolver::with_methods(problem, &seeds, self.methods(), one), right),
            Core::Variational => errors(VariationalSolver::with_methods(problem, &seeds, self.methods(), one), right),
        }
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
                for &reconstruction in Reconstruction::ALL {
                    choices.push(Choice { core, kernel, stabilisation, reconstruction });
                }
            }
        }
    }
    choices
}

fn errors<F: Formulation>(mut solver: MovingSolver<F>, right: f64) -> Errors {
    while solver.time() < END - 1e-9 {
        let step = solver.choose_step().time_step.min(END - solver.time());
        solver.advance(step)?;
    }
    assert!(solver.ledger().relative_error().abs() < 1e-12);
    Ok(mean_errors(&solver, |place| {
        let x = place.x - DAM;
        let (d, u) = if right > 0.0 { stoker(DEEP, right, x, END) } else { ritter(DEEP, x, END) };
        (d, Vec2::new(u, 0.0))
    }))
}

/// Greatest speed (m/s) of a lake of moving particles in the plane after a few hundred steps.
fn lake_speed(kernel: Kernel, bed: fn(Vec2) -> f64, jitter: f64) -> Result<f64, NumericalFailure> {
    let (problem, seeds) = lake_of(bed, jitter);
    let methods = MovingMethods { kernel, ..MovingMethods::new(Integrator::Leapfrog, Stabilisation::TwoShocks) };
    let mut solver = LagrangianSolver::with_methods(problem, &seeds, methods, Dimension::Two);
    for _ in 0..lake::STEPS {
        let step = solver.choose_step().time_step;
        solver.advance(step)?;
    }
    Ok(max_speed(&solver))
}

fn cell<T>(result: Result<T, NumericalFailure>, write: impl Fn(T) -> String) -> String {
    result.map_or_else(|failure| format!("breaks down at {:.3} s ({})", failure.time, failure.quantity), write)
}

/// Runs something three times; its result, which is the same each time, and the least time (s).
fn timed<T>(run: impl Fn() -> T) -> (T, f64) {
    let once = || {
        let start = Instant::now();
        (run(), start.elapsed().as_secs_f64())
    };
    let (result, first) = once();
    (result, first.min(once().1).min(once().1))
}

#[test]
#[ignore = "prints the tables of docs/validation/methods_on_dam_breaks.md; a few minutes"]
fn print_tables() {
    println!("| core | kernel | stabilisation | reconstruction | Ritter: m, m/s | Stoker: m, m/s | s |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for choice in all_choices() {
        let ((dry, wet), seconds) = timed(|| (choice.errors(10.0, 0.0), choice.errors(10.0, 5.0)));
        let pair = |errors| cell(errors, |(d, v)| format!("{d:.4}, {v:.4}"));
        println!("{} {} | {} | {seconds:.3} |", choice.name(), pair(dry), pair(wet));
    }
    println!("\n| kernel | rough | rough, jitter 0.3 | island | island, jitter 0.15 | s |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for &kernel in Kernel::ALL {
        let beds: [(fn(Vec2) -> f64, f64); 4] =
            [(lake::rough, 0.0), (lake::rough, 0.3), (lake::island, 0.0), (lake::island, 0.15)];
        let (speeds, seconds) = timed(|| beds.map(|(bed, jitter)| lake_speed(kernel, bed, jitter)));
        let speeds = speeds.map(|speed| cell(speed, |speed| format!("{speed:.1e}")));
        println!("| `{}` | {} | {seconds:.2} |", kernel.name(), speeds.join(" | "));
    }
}
