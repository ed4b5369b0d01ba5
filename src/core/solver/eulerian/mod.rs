//! Motion `eulerian` of the balanced formulation: riverbed particles carry the water and exchange it through the faces of
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
//! The particles rest on a square lattice and the support of the kernel is a little less than √2 spacings, so that each has
//! four neighbours and 2 Γ_ij = 1/Δ, whatever the kernel. (Wider supports gain nothing and cost more: decision 0006.) A face is
//! computed once and used by both of its particles with opposite sign, so that volume is conserved to rounding. Passes of
//! one evaluation, each a loop over contiguous runs of cells: [`primitive`] → [`gradient`] → [`faces`] (→ [`mixing`], [`passes`], [`walls`], [`cells_in_part`]) → [`update`]; only wet
//! particles and what water can reach of a rim of two cells are active ([`spans`]). Cells without terrain and cells beyond a wall are treated in
//! [`walls`].
//!
//! Deliberately absent: Lagrangian particles, sensors, a floor for the depth. Source of the scheme: `Audusse2004`,
//! `ChenNoelle2017`, `Vila1999`.

mod apertures;
mod breach;
mod cells_in_part;
mod conforming;
mod discharges;
mod faces;
mod general_faces;
mod gradient;
mod inputs;
mod mixing;
mod moving_bed;
pub(super) mod open;
mod outflow;
mod passes;
mod primitive;
mod reach;
mod rows;
mod sections;
mod spans;
mod stairs;
mod state;
mod stepping;
mod update;
mod walls;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod thin_water_tests;

use super::phases::Phases;
use super::{
    BedBalance, ChannelSample, DischargeCheck, FlowProblem, FlowSolver, Ledger, Passage, SectionFlow, StepChoice,
    StepLimit, Way,
};
use crate::constants::EulerianConstants;
use crate::failure::{FailurePlace, NumericalFailure};
use crate::lattice::WaterOnLattice;
use crate::math::Vec2;
use crate::methods::{Core, Method, Reconstruction, Stabilisation, Turbulence};
use breach::Breaking;
use cells_in_part::CellsInPart;
use conforming::ConformingFaces;
use general_faces::GeneralFaces;
use inputs::Inputs;
use moving_bed::MovingBed;
use open::OpenBoundaries;
use passes::Passes;
use reach::Reaches;
use sections::Sections;
use spans::{ActiveSet, Run};
use state::State;
use stepping::Stepping;
pub use stepping::halvings;
use update::Stage;
use walls::Walls;

/// The core with Eulerian particles.
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
    phases: Phases,
}

/// The numbers of a run that every pass needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    /// That of the finest level, or of the level at hand ([`Scale::on`]).
    pub spacing: f64,
    pub gravity: f64,
    pub courant: f64,
    pub dry_depth: f64,
}

impl Scale {
    /// The numbers for cells of another spacing (m).
    pub fn on(&self, spacing: f64) -> Scale {
        Scale { spacing, ..*self }
    }
}

/// The methods of a run with Eulerian particles.
#[derive(Clone, Copy, Debug)]
pub struct EulerianMethods {
    /// The flux: one that Eulerian particles have.
    pub flux: Stabilisation,
    /// The states at the faces.
    pub reconstruction: Reconstruction,
    /// The mixing in the plane.
    pub turbulence: Turbulence,
    /// The constants of all of these.
    pub constants: EulerianConstants,
    /// Whether still water sleeps until something reaches it (M102); not where it is to be seen at rest.
    pub sleeps: bool,
}

impl Default for EulerianMethods {
    fn default() -> Self {
        let flux = Core::Eulerian.usual_stabilisation();
        EulerianMethods {
            flux,
            reconstruction: flux.usual_reconstruction(),
            turbulence: Turbulence::default(),
            constants: EulerianConstants::DEFAULT,
            // Tests of the core see their water at rest.
            sleeps: !cfg!(test),
        }
    }
}

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
        assert!(methods.flux.is_in(Core::Eulerian), "Eulerian particles have no {}", methods.flux.name());
        let lattice = problem.bed.lattice.clone();
        let scale = Scale {
            spacing: lattice.spacing,
            gravity: problem.gravity,
            courant: problem.courant,
            dry_depth: problem.dry_depth,
        };
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
        let reaches = Reaches::new(&problem, &mut state, &walls);
        let inputs = Inputs::new(&problem, &state);
        let sections = Sections::new(&problem, &state, (&general, &conforming));
        let (fed, linked) = (fed(&state, &open, &inputs, &reaches), [general.linked(), conforming.linked()].concat());
        let kept = walls.owners().chain(in_part.owners()).chain(open.cells()).chain(general.places().flatten());
        let active = ActiveSet::new(&state, scale.dry_depth, fed, linked, kept);
        let mut solver = EulerianSolver {
            scale,
            methods,
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
            bed_out: Vec::new(),
            sections,
            stepping: Stepping::new(lattice.level_count()),
            lattice,
            time: 0.0,
            steps: 0,
            evaluations: 0,
            initial_volume: 0.0,
            inflow: 0.0,
            outflow: 0.0,
            left_over_edges: 0.0,
            phases: Phases::default(),
        };
        solver.initial_volume = solver.volume();
        solver.hand_out_bed();
        solver.evaluate_primitive();
        solver
    }

    /// Gives the water a velocity (m/s) at the start, by place (local coordinates).
    pub fn set_velocity(&mut self, velocity: impl Fn(Vec2) -> Vec2) {
        for (row, water) in self.state.water.iter_mut().enumerate() {
            for column in (0..water.depth.len()).filter(|&column| water.depth[column] > self.scale.dry_depth) {
                let place = self.lattice.centre(self.lattice.index(column - 1, row - 1));
                let discharge = velocity(place) * water.depth[column];
                (water.discharge_x[column], water.discharge_y[column]) = (discharge.x, discharge.y);
            }
        }
        self.evaluate_primitive();
    }

    /// Velocities and the greatest signal speed of the current state.
    fn evaluate_primitive(&mut self) {
        primitive::evaluate(&mut self.state, &self.active, &self.scale);
        self.reaches.evaluate_primitive(Stage::First);
    }

    /// All water, that of the channels too (m³).
    fn volume(&self) -> f64 {
        self.in_part.volume(&self.state) + self.reaches.volume(self.scale.spacing)
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

/// For every padded row the cells to which water comes from elsewhere than their neighbours: all terrain where it rains.
fn fed(state: &State, open: &OpenBoundaries, inputs: &Inputs, reaches: &Reaches) -> Vec<Vec<Run>> {
    let mut fed: Vec<Vec<Run>> = vec![Vec::new(); state.rows + 2];
    if inputs.is_wetted {
        for (row, runs) in fed.iter_mut().enumerate() {
            runs.extend(state.bounds(row).map(|[_, columns]| columns));
        }
        return fed;
    }
    for (row, column) in open.inlets().chain(inputs.cells()).chain(reaches.cells()) {
        fed[row].push(column..column + 1);
    }
    fed
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
        let signal_speed = reach::larger_or_nan(fastest.signal_speed, in_channels);
        let place = || match self.reaches.place_of(in_channels, &self.scale) {
            Some((number, distance)) if in_channels > fastest.signal_speed || in_channels.is_nan() => {
                FailurePlace::InChannel { number, distance }
            }
            _ => {
                let position = self.state.position(fastest.row, fastest.column);
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
        WaterOnLattice { rows: &self.state, lattice: &self.lattice, spans: self.active.recorded() }
    }

    fn ledger(&self) -> Ledger {
        Ledger { initial: self.initial_volume, inflow: self.inflow, outflow: self.outflow, stored: self.volume() }
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
        (self.steps > 0).then(|| self.compare_discharges())
    }

    fn bed_balance(&self) -> Option<BedBalance> {
        self.moving_bed.as_ref().map(MovingBed::balance)
    }

    fn breach_began(&self) -> Option<f64> {
        self.breaking.as_ref().and_then(Breaking::opened)
    }

    fn particles(&self) -> usize {
        self.active.wet_cells() + self.reaches.particles().1
    }

    fn particle_evaluations(&self) -> u64 {
        self.evaluations
    }

    fn phases(&self) -> &Phases {
        &self.phases
    }
}
