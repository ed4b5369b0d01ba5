//! The shallow-water core: from a bed, walls and still water to moving water. Opens no file, prints nothing, knows no YAML.

mod changing_bed;
mod eulerian;
mod nested;
pub mod phases;
mod scratch;
#[cfg(test)]
mod testing;
pub mod threads;
pub mod variational;

pub use crate::boundary::{
    BedLaw, BedMotion, Boundary, Breach, Channel, ChannelEnd, ChannelSection, Condition, DamCell, EdgeFace, Forcing,
    GrowthLaw, LineSource, OpenEdges, Opening, Patch, PointSource, Rain, RainFrames, Rating, Resistance, RimCell,
    Series, Slide, Strip, Tracer, Trigger, edge_faces,
};
pub use eulerian::{EulerianMethods, EulerianSolver, halvings};
pub use nested::nested;

use crate::bed::BedParticles;
use crate::failure::NumericalFailure;
use crate::lattice::WaterOnLattice;
use crate::math::Vec2;
use phases::Phases;

/// Everything the core needs to know about a place; local coordinates throughout.
#[derive(Clone, Debug)]
pub struct FlowProblem {
    /// The riverbed.
    pub bed: BedParticles,
    /// Walls without thickness that no water crosses, as straight pieces (m).
    pub walls: Vec<[Vec2; 2]>,
    /// Where water may leave.
    pub open_edges: OpenEdges,
    /// What brings water in or takes it out, and the sections that measure it. Cells alone know it.
    pub forcing: Forcing,
    /// Still water at the start: depth (m) at each cell of the lattice.
    pub initial_depth: Vec<f64>,
    /// Gravity (m/s²).
    pub gravity: f64,
    /// Courant number.
    pub courant: f64,
    /// Depth (m) below which water does not move.
    pub dry_depth: f64,
}

/// What limits a time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, PartialOrd, Ord)]
pub enum StepLimit {
    /// Celerity plus velocity against the spacing.
    Courant,
    /// Acceleration against the smoothing length.
    Acceleration,
    /// The end of the run.
    EndOfRun,
    /// There is no water to limit it.
    NoWater,
}

impl StepLimit {
    /// The name in logs and in `run.json`.
    pub fn name(self) -> &'static str {
        match self {
            StepLimit::Courant => "courant",
            StepLimit::Acceleration => "acceleration",
            StepLimit::EndOfRun => "end of run",
            StepLimit::NoWater => "no water",
        }
    }
}

/// The next time step and what limits it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct StepChoice {
    /// Length of the step (s).
    pub time_step: f64,
    /// What limits it.
    pub limit: StepLimit,
    /// Where (local coordinates, m).
    pub position: Vec2,
    /// Greatest speed of the water now (m/s).
    pub max_speed: f64,
}

/// The volume balance of the core: volumes in cubic metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Ledger {
    /// Water at the start.
    pub initial: f64,
    /// Water that came in since.
    pub inflow: f64,
    /// Water that left since.
    pub outflow: f64,
    /// Water there now, summed afresh over the particles.
    pub stored: f64,
}

impl Ledger {
    /// (stored − initial − inflow + outflow) / (initial + inflow); 0 where there never was water.
    pub fn relative_error(&self) -> f64 {
        let supplied = self.initial + self.inflow;
        if supplied > 0.0 { (self.stored - self.initial - self.inflow + self.outflow) / supplied } else { 0.0 }
    }
}

/// The balance of a tracer: amounts, which are its concentration times cubic metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TracerLedger {
    /// In the water at the start.
    pub initial: f64,
    /// That came in since.
    pub inflow: f64,
    /// That left since.
    pub outflow: f64,
    /// That decayed since.
    pub decayed: f64,
    /// In the water now, summed afresh over the cells.
    pub stored: f64,
}

impl TracerLedger {
    /// (stored − initial − inflow + outflow + decayed) / (initial + inflow); 0 where there never was any.
    pub fn relative_error(&self) -> f64 {
        let supplied = self.initial + self.inflow;
        let lost = self.stored - self.initial - self.inflow + self.outflow + self.decayed;
        if supplied > 0.0 { lost / supplied } else { 0.0 }
    }
}

/// What a moving bed has done so far: volumes in cubic metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BedBalance {
    /// By which the bed lies above that of the start, where it does.
    pub raised: f64,
    /// By which it lies below, where it does.
    pub sunk: f64,
    /// By which it lifted water that lay on it, all movements up.
    pub lifted: f64,
    /// By which it lowered water, all movements down.
    pub lowered: f64,
}

/// A way by which water comes or goes; numbers are those of the problem's lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Way {
    /// Edges without a condition.
    OpenEdges,
    /// A boundary with a condition.
    Boundary(usize),
    /// A point source.
    Source(usize),
    /// A line source.
    LineSource(usize),
    /// Rain.
    Rain,
    /// The far end of a channel.
    FarEnd(usize),
    /// The near end of a channel that joins nothing.
    NearEnd(usize),
}

/// Inflow and outflow by one way since the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// The way.
    pub way: Way,
    /// Volume that came in (m³).
    pub inflow: f64,
    /// Volume that left (m³).
    pub outflow: f64,
    /// The integral of the discharge or the rain of the problem (m³); none where another condition rules.
    pub asked: Option<f64>,
}

/// What passed a cross-section: positive where the water crosses the line towards its left side, that is downstream where the line was
/// drawn from the left to the right bank.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SectionFlow {
    /// Mean discharge of the last step (m³/s).
    pub discharge: f64,
    /// Volume since the start (m³).
    pub volume: f64,
}

/// The water of one particle of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelSample {
    /// Depth above the lowest bed of the section (m).
    pub depth: f64,
    /// Level (m).
    pub level: f64,
    /// Velocity towards the near end (m/s).
    pub velocity: f64,
    /// Mean discharge of the last step towards the near end (m³/s).
    pub discharge: f64,
}

/// A particle whose discharge is not that of its faces.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DischargesInDoubt {
    /// Its own discharge (m²/s), depth times speed.
    pub own: f64,
    /// That of its faces (m²/s).
    pub at_faces: f64,
    /// Where it is (local coordinates, m).
    pub place: Vec2,
}

/// The discharges of particles beside those of their faces at one moment, summed over particles (m²/s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DischargeCheck {
    /// The greater of the two.
    pub carried: f64,
    /// Their difference.
    pub apart: f64,
    /// The greater of the two where they differ by more than half of it.
    pub in_doubt: f64,
    /// The particle among these with the greatest difference.
    pub worst: Option<DischargesInDoubt>,
}

/// A core that moves water, in whichever formulation and motion.
pub trait FlowSolver: Send {
    /// Simulated time (s).
    fn time(&self) -> f64;
    /// Number of steps taken.
    fn steps(&self) -> u64;
    /// The step that stability allows now, before any cut to the end of the run.
    fn choose_step(&mut self) -> StepChoice;
    /// Takes one step of the given length (s), at most the chosen one.
    ///
    /// # Errors
    /// When the state is no longer finite, or the step has collapsed.
    fn advance(&mut self, time_step: f64) -> Result<(), NumericalFailure>;
    /// The water on the lattice now. Particles, and cells that move, are gridded here, with their volume conserved.
    fn water(&mut self) -> WaterOnLattice<'_>;
    /// After how many steps the water on the lattice is to be recorded: each one, unless it costs about as much as a step to draw it.
    fn steps_of_a_record(&self) -> u64 {
        1
    }
    /// Whether the water on the lattice is to be recorded now, in a run that ends at a time (s).
    fn is_record_due(&self, end: f64) -> bool {
        self.steps().is_multiple_of(self.steps_of_a_record()) || self.time() >= end
    }
    /// The volumes.
    fn ledger(&self) -> Ledger;
    /// The balance of each tracer of the problem.
    fn tracers(&self) -> Vec<TracerLedger> {
        Vec::new()
    }
    /// What passed the cross-sections of the problem; nothing where the core knows none.
    fn sections(&self) -> &[SectionFlow] {
        &[]
    }
    /// The water of each channel of the problem, from its far end; nothing where the core knows none.
    fn channels(&self) -> Vec<Vec<ChannelSample>> {
        Vec::new()
    }
    /// The volume of the ledger that is in channels (m³).
    fn volume_in_channels(&self) -> f64 {
        0.0
    }
    /// The cells whose bed may change in a run, and their elevation (m) now; none where the bed rests.
    fn bed_now(&self) -> &[(usize, f64)] {
        &[]
    }
    /// The time (s) at which the dam of the problem began to break, once it did.
    fn breach_began(&self) -> Option<f64> {
        None
    }
    /// What the moving bed of the problem has done; none where it has none.
    fn bed_balance(&self) -> Option<BedBalance> {
        None
    }
    /// The discharges of the particles beside those of their faces in the last step; none before it and where particles have no faces.
    fn discharges(&self) -> Option<DischargeCheck> {
        None
    }
    /// Inflow and outflow by each way of the problem; nothing where the core keeps no such balance.
    fn passages(&self) -> Vec<Passage> {
        Vec::new()
    }
    /// Whether there are cells or particles that move.
    fn has_moving(&self) -> bool {
        false
    }
    /// Number of particles that carry water now.
    fn particles(&self) -> usize;
    /// Evaluations of the rates of one particle so far.
    fn particle_evaluations(&self) -> u64;
    /// Where the time of the steps went so far.
    fn phases(&self) -> &Phases;
}
