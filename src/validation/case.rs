//! What a case is: a problem with an answer, the spacings it is run at, and the acceptance limits it is held to.

use super::judge::Limits;
use super::outcome::{Check, Snapshot};
use crate::bed::BedParticles;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::particles::FluidSeed;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::{Core, Motion};
use crate::solver::{Condition, FlowProblem, Series};

/// A group of cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suite {
    /// Error, order and cost against known answers.
    Analytic,
    /// Where methods fail: harsh problems, each run held to what physics allows.
    Stability,
    /// Experiments with measurements (`crate::laboratory`).
    Laboratory,
    /// Floods with observed marks (`crate::laboratory`).
    Field,
}

impl Suite {
    /// Every suite.
    pub const ALL: &'static [Suite] = &[Suite::Analytic, Suite::Stability, Suite::Laboratory, Suite::Field];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Suite::Analytic => "analytic",
            Suite::Stability => "stability",
            Suite::Laboratory => "laboratory",
            Suite::Field => "field",
        }
    }
}

/// Which runs an acceptance limit is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Every run of the case.
    Each,
    /// Runs of one motion.
    Of(Motion),
    /// The better of the motions.
    Better,
}

/// What a case must reach. All that is given must hold.
#[derive(Clone, Copy, Debug)]
pub struct AcceptanceLimit {
    /// Which runs it is for.
    pub scope: Scope,
    /// The spacing (m) at which the errors are judged; any when absent.
    pub spacing: Option<f64>,
    /// Largest mean error of the depth (m).
    pub depth: Option<f64>,
    /// Largest mean error of the velocity (m/s).
    pub velocity: Option<f64>,
    /// Least orders of depth and velocity from the coarsest to the finest of the spacings that were run.
    pub order: Option<(f64, Option<f64>)>,
    /// Greatest speed (m/s) at any step.
    pub max_speed: Option<f64>,
    /// Whether the checks of the setup belong to it, at every spacing.
    pub checks: bool,
}

impl AcceptanceLimit {
    /// An acceptance limit that asks nothing of any run; fill in what it asks.
    pub const NONE: AcceptanceLimit = AcceptanceLimit {
        scope: Scope::Each,
        spacing: None,
        depth: None,
        velocity: None,
        order: None,
        max_speed: None,
        checks: false,
    };
}

/// When a run ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// At a time (s).
    Time(f64),
    /// After a number of steps of the solver's own choice.
    Steps(usize),
}

/// Depth (m) and velocity (m/s) at a place when the run ends.
pub type Exact = Box<dyn Fn(Vec2) -> (f64, Vec2) + Send + Sync>;

/// A velocity (m/s) at a place.
pub type Velocity = Box<dyn Fn(Vec2) -> Vec2 + Send + Sync>;

/// Looks at the start and the end of a run.
pub type Checks = Box<dyn Fn(&Snapshot, &Snapshot) -> Vec<Check> + Send + Sync>;

/// Rows of a channel whose cells move: those of two on each side rest.
pub const ROWS: usize = 8;

/// One run, ready to go but for its methods.
pub struct Setup {
    /// Bed, walls, and the water of cells.
    pub problem: FlowProblem,
    /// The water of particles of the variational formulation.
    pub seeds: Vec<FluidSeed>,
    /// Velocity at the start; at rest when absent.
    pub velocity: Option<Velocity>,
    /// A channel of unit width, or the plane.
    pub dimension: Dimension,
    /// Rows of the lattice that stand for one of a channel: 1, or [`ROWS`] where cells move, of which one row has none.
    pub rows: usize,
    /// The end.
    pub until: Until,
    /// The answer.
    pub exact: Exact,
    /// Moments (s) before the end, ascending, with the answer at each: the errors are the means over these and the end.
    pub earlier: Vec<(f64, Exact)>,
    /// The places at which errors count.
    pub counts: Box<dyn Fn(Vec2) -> bool + Send + Sync>,
    /// Greatest depth (m) of the answer: half a per cent of it is the least depth at which the velocity of cells counts.
    pub scale_depth: f64,
    /// Greatest speed (m/s) of the answer, to foresee the number of steps.
    pub scale_speed: f64,
    /// What else is looked at.
    pub checks: Option<Checks>,
    /// Whether `exact` is an answer to compare with; where it is not, there are no errors.
    pub is_answer_known: bool,
    /// The Courant number of the case, whatever the methods say.
    pub courant: Option<f64>,
    /// What tells holding from degrading and failing; only in the suite of stability.
    pub limits: Option<Limits>,
}

impl Setup {
    /// Water at rest that is compared everywhere, without further checks.
    pub fn new(problem: FlowProblem, seeds: Vec<FluidSeed>, dimension: Dimension, until: Until, exact: Exact) -> Setup {
        let deepest = problem.initial_depth.iter().copied().fold(0.0, f64::max);
        let deepest = seeds.iter().map(|seed| seed.depth).fold(deepest, f64::max);
        Setup {
            scale_depth: deepest,
            scale_speed: 2.0 * (problem.gravity * deepest).sqrt(),
            problem,
            seeds,
            velocity: None,
            dimension,
            rows: 1,
            until,
            exact,
            earlier: Vec::new(),
            counts: Box::new(|_| true),
            checks: None,
            is_answer_known: true,
            courant: None,
            limits: None,
        }
    }

    /// The same with a channel as a plane of [`ROWS`] rows, whose cells can move.
    pub fn in_plane(mut self) -> Setup {
        if self.dimension == Dimension::Two {
            return self;
        }
        let FlowProblem { bed, initial_depth, forcing, .. } = &mut self.problem;
        let Lattice { origin, columns, spacing, .. } = bed.lattice;
        *bed = BedParticles {
            manning: bed.manning.repeat(ROWS),
            is_sloped: bed.is_sloped,
            ..BedParticles::from_elevation(
                Lattice::new(origin, columns, ROWS, spacing),
                bed.elevation.repeat(ROWS),
                0.0,
            )
        };
        *initial_depth = initial_depth.repeat(ROWS);
        for boundary in &mut forcing.boundaries {
            if let Condition::Discharge { discharge, .. } = &mut boundary.condition {
                let points: Vec<(f64, f64)> = discharge.points().map(|(time, q)| (time, q * ROWS as f64)).collect();
                *discharge = Series::new(&points).unwrap_or_else(|| discharge.clone());
            }
        }
        Setup { dimension: Dimension::Two, rows: ROWS, ..self }
    }

    /// Water at rest at the start without an answer to compare with.
    pub fn without_answer(problem: FlowProblem, seeds: Vec<FluidSeed>, dimension: Dimension, until: Until) -> Setup {
        let exact: Exact = Box::new(|_| (0.0, Vec2::ZERO));
        Setup { is_answer_known: false, ..Setup::new(problem, seeds, dimension, until, exact) }
    }
}

/// A setup, or why there is none for this core on this machine.
pub type SetupResult = Result<Setup, String>;

/// A problem with a known answer.
pub struct Case {
    /// The name on the command line.
    pub name: &'static str,
    /// The suite.
    pub suite: Suite,
    /// One sentence: what it tests, and against what.
    pub about: &'static str,
    /// Whether constants of the methods were chosen on it.
    pub is_tuned: bool,
    /// Spacings (m), the coarsest first.
    pub spacings: &'static [f64],
    /// So many of the coarsest make up the test resolution.
    pub tested: usize,
    /// What must hold.
    pub acceptance_limits: &'static [AcceptanceLimit],
    /// The run at a spacing (m) with a core.
    pub setup: fn(f64, Core) -> SetupResult,
}
