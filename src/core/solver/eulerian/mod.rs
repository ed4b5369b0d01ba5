//! The balanced formulation: riverbed particles carry the water and exchange it through the faces of
//! their pairs.
//!
//! Depth d and discharge q = d v of particle i change by the pair fluxes of its neighbours j (theory (M17) to (M21), (M23), (M31), (M33) and (M34)):
//!
//! ```text
//! dd_i/dt = − Σ_j 2 Γ_ij F_d
//! dq_i/dt = − Σ_j 2 Γ_ij { [F_n − g d_l²/2 + g (d_i + d_iR) a_1/2] e + F_d v_t e_t }
//! Γ_ij = A_j |W'_ij| / Σ_j A_j |W'_ij| r e_x²
//! ```
//!
//! The particles rest on a square lattice (those that move are in [`moving_cells`]) and the support of the kernel is a little less than √2 spacings, so that each has
//! four neighbours and 2 Γ_ij = 1/Δ, whatever the kernel. (Wider supports gain nothing and cost more: decision 0006.) A face is
//! computed once and used by both of its particles with opposite sign, so that volume is conserved to rounding. Passes of
//! one evaluation, each a loop over contiguous runs of cells: [`primitive`] → [`gradient`] → [`faces`] (→ [`mixing`], [`passes`], [`walls`], [`cells_in_part`]) → [`update`]; only wet
//! particles and what water can reach of a rim of two cells are active ([`spans`]). Cells without terrain and cells beyond a wall are treated in
//! [`walls`].
//!
//! Deliberately absent: sensors, a floor for the depth. Source of the scheme: `Audusse2004`,
//! `ChenNoelle2017`, `Vila1999`.

mod apertures;
mod breach;
mod cells_in_part;
mod concentrations;
mod conforming;
mod discharges;
mod faces;
mod general_faces;
mod gradient;
mod inputs;
mod methods;
mod mixing;
mod moving_bed;
mod moving_cells;
mod open;
mod outflow;
mod passes;
mod primitive;
mod reach;
mod rows;
mod sections;
mod setup;
mod spans;
mod stairs;
mod start;
mod state;
mod stepping;
mod tracers;
mod update;
mod walls;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod thin_water_tests;

use super::phases::Phases;
use super::{
    BedBalance, ChannelSample, DischargeCheck, FlowProblem, FlowSolver, Ledger, Passage, SectionFlow, StepChoice,
    StepLimit, TracerLedger, Way,
};
use crate::failure::{FailurePlace, NumericalFailure};
use crate::lattice::WaterOnLattice;
use crate::methods::{Core, Method};
use breach::Breaking;
use cells_in_part::CellsInPart;
use conforming::ConformingFaces;
use general_faces::GeneralFaces;
use inputs::Inputs;
pub use methods::EulerianMethods;
use moving_bed::MovingBed;
use moving_cells::MovingCells;
use open::OpenBoundaries;
use passes::Passes;
use reach::Reaches;
use sections::Sections;
use spans::ActiveSet;
use state::State;
use stepping::Stepping;
pub use stepping::halvings;
use update::Stage;
use walls::Walls;

/// The core with Eulerian particles.
#[derive(serde::Serialize, serde::Deserialize)]
pub struct EulerianSolver {
    scale: Scale,
    methods: EulerianMethods,
    state: State,
    active: ActiveSet,
    walls: Walls,
    passes: Passes,
    general: GeneralFaces,
    conforming: ConformingFaces,
    in_part: CellsInPart,
    open: OpenBoundaries,
    reaches: Reaches,
    inputs: Inputs,
    breaking: Option<Breaking>,
    moving_bed: Option<MovingBed>,
    /// The cells that move with their water; none where all rest.
    moving: Option<MovingCells>,
    /// The cells of both and their bed (m), where there are both.
    bed_out: Vec<(usize, f64)>,
    sections: Sections,
    lattice: crate::lattice::Lattice,
    stepping: Stepping,
    time: f64,
    steps: u64,
    evaluations: u64,
    initial_volume: f64,
    inflow: f64,
    outflow: f64,
    /// The part of the outflow (m³) that left by open edges without a condition.
    left_over_edges: f64,
    #[serde(skip)]
    phases: Phases,
}

/// The numbers of a run that every pass needs.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct Scale {
    /// That of the finest level, or of the level at hand ([`Scale::on`]).
    pub spacing: f64,
    pub gravity: f64,
    pub courant: f64,
    pub dry_depth: f64,
}

impl Scale {
    /// The numbers of a problem.
    fn of(problem: &FlowProblem) -> Self {
        let FlowProblem { gravity, courant, dry_depth, .. } = *problem;
        Scale { spacing: problem.bed.lattice.spacing, gravity, courant, dry_depth }
    }

    /// The numbers for cells of another spacing (m).
    pub fn on(&self, spacing: f64) -> Scale {
        Scale { spacing, ..*self }
    }
}

/// Steps between two records of cells that move: signals cross half a cell in a step; the recorder draws straight lines between.
const STEPS_OF_A_RECORD: u64 = 3;

/// Below this step (s) the run has collapsed: a million steps would not reach one second.
const SMALLEST_STEP: f64 = 1e-6;

impl EulerianSolver {
    /// Sets the still water of `problem` on its riverbed; the usual methods.
    pub fn new(problem: FlowProblem) -> Self {
        Self::with_methods(problem, EulerianMethods::default())
    }

    /// The same by other methods.
    ///
    /// # Panics
    /// With a stabilisation that Eulerian particles do not have; a scenario that asks for it is refused.
    pub fn with_methods(problem: FlowProblem, methods: EulerianMethods) -> Self {
        assert!(methods.flux.is_in(Core::Eulerian), "the balanced formulation has no {}", methods.flux.name());
        let scale = Scale::of(&problem);
        let mut state = State::new(&problem.bed, &problem.initial_depth, problem.gravity);
        let mut breaking = Breaking::new(&problem);
        breaking.iter_mut().for_each(|breaking| breaking.follow(&mut state, 0.0, scale.dry_depth));
        let mut moving_bed = MovingBed::new(&problem);
        moving_bed.iter_mut().for_each(|moving| moving.follow(&mut state, 0.0, scale.dry_depth));
        let walls = Walls::new(&problem, &state, methods);
        let passes = Passes::new(&problem, &state, &walls);
        let general = GeneralFaces::new(&problem, &walls, &mut state);
        let conforming = ConformingFaces::new(&problem, &mut state, (&walls, &passes));
        let in_part = CellsInPart::new(&problem, &state);
        let open = OpenBoundaries::new(&problem, &state, (&walls, &in_part), methods.constants.edge_about);
        tracers::set(&problem, &mut state, (&walls, &open, &conforming));
        let reaches = Reaches::new(&problem, &mut state, &walls);
        let mut inputs = Inputs::new(&problem, &state);
        let sections = Sections::new(&problem, &state, (&general, &conforming));
        let near = (&open, &inputs, &reaches);
        let beside = (&walls, &passes, &conforming, &in_part, &sections);
        let changing = (&breaking, &moving_bed);
        let moving = methods.moves.then(|| setup::moving_cells(&mut state, &scale, near, beside, changing)).flatten();
        inputs.squares_that_move = moving.iter().flat_map(MovingCells::squares).collect();
        let (fed, linked) =
            (setup::fed(&state, &open, &inputs, &reaches), [general.linked(), conforming.linked()].concat());
        let kept = walls.owners().chain(in_part.owners()).chain(open.cells()).chain(general.places().flatten());
        let active = ActiveSet::new(&state, scale.dry_depth, fed, linked, kept);
        let mut solver = EulerianSolver {
            scale,
            methods: EulerianMethods { moves: moving.is_some(), ..methods },
            state,
            active,
            walls,
            passes,
            general,
            conforming,
            in_part,
            open,
            reaches,
            inputs,
            breaking,
            moving_bed,
            moving,
            bed_out: Vec::new(),
            sections,
            stepping: Stepping::new(problem.bed.lattice.level_count()),
            lattice: problem.bed.lattice,
            time: 0.0,
            steps: 0,
            evaluations: 0,
            initial_volume: 0.0,
            inflow: 0.0,
            outflow: 0.0,
            left_over_edges: 0.0,
            phases: Phases::default(),
        };
        solver.begin();
        solver
    }

    /// Velocities and the greatest signal speed of the current state.
    fn evaluate_primitive(&mut self) {
        primitive::evaluate(&mut self.state, &self.active, &self.scale);
        self.reaches.evaluate_primitive(Stage::First);
    }

    /// All water, that of the channels too (m³).
    fn volume(&self) -> f64 {
        let of_moving = self.moving.as_ref().map_or(0.0, |moving| moving.volume_beside(&self.state));
        self.in_part.volume(&self.state) + self.reaches.volume(self.scale.spacing) + of_moving
    }

    /// Puts the bed of a dam that breaks and of ground that moves into one list, where there are both.
    fn hand_out_bed(&mut self) {
        if let (Some(breaking), Some(moving)) = (&self.breaking, &self.moving_bed) {
            self.bed_out.clear();
            self.bed_out.extend(breaking.bed().iter().chain(moving.bed()));
        }
    }

    fn failure(&self, quantity: &'static str, value: f64, place: FailurePlace) -> NumericalFailure {
        NumericalFailure {
            time: self.time,
            step: self.steps,
            quantity,
            value,
            place,
            limiter: StepLimit::Courant.name(),
        }
    }
}

impl FlowSolver for EulerianSolver {
    fn time(&self) -> f64 {
        self.time
    }

    fn steps(&self) -> u64 {
        self.steps
    }

    fn choose_step(&mut self) -> StepChoice {
        self.phases.start();
        let choice = self.choose();
        self.phases.end("choice of the step");
        choice
    }

    fn advance(&mut self, time_step: f64) -> Result<(), NumericalFailure> {
        self.phases.start();
        self.step(time_step);
        let fastest = self.fastest();
        let in_channels = self.reaches.fastest(&self.scale).0;
        let of_moving = self.moving.as_ref().map(MovingCells::pace).unwrap_or_default();
        let in_moving = of_moving.haste * self.scale.spacing;
        let in_cells = reach::larger_or_nan(fastest.signal_speed, in_moving);
        let signal_speed = reach::larger_or_nan(in_cells, in_channels);
        let place = || match self.reaches.place_of(in_channels, &self.scale) {
            Some((number, distance)) if in_channels > in_cells || in_channels.is_nan() => {
                FailurePlace::InChannel { number, distance }
            }
            _ => {
                let is_moving = in_moving > fastest.signal_speed || in_moving.is_nan();
                let in_rows = self.state.position(fastest.row, fastest.column);
                let position = if is_moving { of_moving.place } else { in_rows };
                FailurePlace::OnMap(self.lattice.to_map(position))
            }
        };
        if !signal_speed.is_finite() {
            return Err(self.failure("signal speed", signal_speed, place()));
        }
        if signal_speed > 0.0 {
            let next = self.scale.courant * self.scale.spacing / signal_speed;
            if next < SMALLEST_STEP {
                return Err(self.failure("time step", next, place()));
            }
        }
        Ok(())
    }

    fn water(&mut self) -> WaterOnLattice<'_> {
        let spans = self.active.recorded();
        if let Some(moving) = &mut self.moving {
            self.phases.start();
            let (rows, spans) = moving.grid(&self.state, spans, self.steps);
            self.phases.end("gridding");
            return WaterOnLattice { rows, lattice: &self.lattice, spans };
        }
        WaterOnLattice { rows: &self.state, lattice: &self.lattice, spans }
    }

    fn steps_of_a_record(&self) -> u64 {
        if self.moving.is_some() { STEPS_OF_A_RECORD } else { 1 }
    }

    fn ledger(&self) -> Ledger {
        Ledger { initial: self.initial_volume, inflow: self.inflow, outflow: self.outflow, stored: self.volume() }
    }

    fn tracers(&self) -> Vec<TracerLedger> {
        self.tracer_ledgers()
    }

    fn sections(&self) -> &[SectionFlow] {
        self.sections.flows()
    }

    fn channels(&self) -> Vec<Vec<ChannelSample>> {
        self.reaches.samples()
    }

    fn volume_in_channels(&self) -> f64 {
        self.reaches.volume(self.scale.spacing)
    }

    fn bed_now(&self) -> &[(usize, f64)] {
        match (&self.breaking, &self.moving_bed) {
            (Some(_), Some(_)) => &self.bed_out,
            (Some(breaking), None) => breaking.bed(),
            (None, Some(moving)) => moving.bed(),
            (None, None) => &[],
        }
    }

    fn passages(&self) -> Vec<Passage> {
        let over_edges = self.walls.has_open_edges().then_some(Passage {
            way: Way::OpenEdges,
            inflow: 0.0,
            outflow: self.left_over_edges,
            asked: None,
        });
        let inputs = self.inputs.passages(&self.state, self.time);
        over_edges
            .into_iter()
            .chain(self.open.passages(self.time))
            .chain(inputs)
            .chain(self.reaches.passages(self.time))
            .collect()
    }

    fn discharges(&self) -> Option<DischargeCheck> {
        // Cells that move have their own faces, whose discharges nobody adds up.
        (self.steps > 0 && self.moving.is_none()).then(|| self.compare_discharges())
    }

    fn bed_balance(&self) -> Option<BedBalance> {
        self.moving_bed.as_ref().map(MovingBed::balance)
    }

    fn breach_began(&self) -> Option<f64> {
        self.breaking.as_ref().and_then(Breaking::opened)
    }

    fn has_moving(&self) -> bool {
        self.moving.is_some()
    }

    fn particles(&self) -> usize {
        let of_moving = self.moving.as_ref().map_or(0, |moving| moving.wet_cells(self.scale.dry_depth));
        self.active.wet_cells() + self.reaches.particles().1 + of_moving
    }

    fn particle_evaluations(&self) -> u64 {
        self.evaluations
    }

    fn phases(&self) -> &Phases {
        &self.phases
    }
}
