//! The core of the variational formulation: an integrator, the water balance and the watch.

use rayon::prelude::*;

use super::step::{Beginning, HalfStep, heun, leapfrog};
use super::{CHUNK, MovingMethods, MovingWater, Rates, Variational};
use crate::failure::{FailurePlace, NumericalFailure};
use crate::gridding::Gridder;
use crate::lattice::WaterOnLattice;
use crate::math::Vec2;
use crate::methods::{Integrator, Stabilisation};
use crate::particles::FluidSeed;
use crate::physics::celerity;
use crate::physics::dimension::Dimension;
use crate::solver::phases::Phases;
use crate::solver::{FlowProblem, FlowSolver, Ledger, Passage, StepChoice, StepLimit, Way};

/// The acceleration may use so much of the smoothing length in a step of Courant number 1.
const ACCELERATION_SHARE: f64 = 0.8;
/// A step this much shorter than the first one has collapsed.
const COLLAPSED_SHARE: f64 = 1e-5;
/// Particles are brought into the order of the cells every so many steps.
const STEPS_PER_SORT: u64 = 8;
/// Steps between two records of the grid. Signals cross 0.6 spacings in a step and water less; the recorder draws straight lines between.
const STEPS_OF_A_RECORD: u64 = 3;

/// Particles of the variational formulation.
#[derive(serde::Serialize, serde::Deserialize)]
pub struct VariationalSolver {
    water: MovingWater,
    formulation: Variational,
    integrator: Integrator,
    courant: f64,
    time: f64,
    steps: u64,
    evaluations: u64,
    ledger: Ledger,
    first_choice: Option<StepChoice>,
    last_choice: Option<StepChoice>,
    halves: Vec<HalfStep>,
    beginnings: Vec<Beginning>,
    gridder: Gridder,
    /// Whether the grid shows the water as it is now.
    is_gridded: bool,
}

impl VariationalSolver {
    /// Water at rest in the plane.
    pub fn new(
        problem: FlowProblem,
        seeds: Vec<FluidSeed>,
        integrator: Integrator,
        stabilisation: Stabilisation,
    ) -> Self {
        Self::with_methods(problem, seeds, MovingMethods::new(integrator, stabilisation), Dimension::Two)
    }

    /// Water at rest in the plane, or in a channel of unit width along x (a lattice of one row, walls at its two ends), by the given methods.
    pub fn with_methods(
        problem: FlowProblem,
        seeds: Vec<FluidSeed>,
        methods: MovingMethods,
        dimension: Dimension,
    ) -> Self {
        let stored = seeds.iter().fold(0.0, |sum, seed| sum + seed.volume);
        let courant = problem.courant;
        let water = MovingWater::new(problem, &seeds, dimension, methods);
        // The first evaluation needs memory.
        drop(seeds);
        let gridder = Gridder::new(&water.bed.lattice, dimension);
        let mut solver = VariationalSolver {
            water,
            formulation: Variational::new(methods, dimension),
            integrator: methods.integrator,
            courant,
            time: 0.0,
            steps: 0,
            evaluations: 0,
            ledger: Ledger { initial: stored, stored, ..Ledger::default() },
            first_choice: None,
            last_choice: None,
            halves: Vec::new(),
            beginnings: Vec::new(),
            gridder,
            is_gridded: false,
        };
        solver.formulation.prepare(&mut solver.water);
        solver.evaluations += solver.water.particles.len() as u64;
        solver
    }

    /// The Courant number that suits an integrator: 0.4 for leapfrog, 0.6 for Heun.
    pub fn default_courant(integrator: Integrator) -> f64 {
        match integrator {
            Integrator::Leapfrog => 0.4,
            Integrator::Heun => 0.6,
        }
    }

    /// The particles, as they are now.
    pub fn state(&self) -> &MovingWater {
        &self.water
    }

    /// The particles, to be changed from outside; their rates stay those of before.
    pub fn state_mut(&mut self) -> &mut MovingWater {
        &mut self.water
    }

    /// Gives the water a velocity (m/s) at the start, by place.
    pub fn set_velocity(&mut self, velocity: impl Fn(Vec2) -> Vec2) {
        let particles = &mut self.water.particles;
        for (own, place) in particles.velocity.iter_mut().zip(&particles.position) {
            *own = velocity(*place);
        }
        self.restart();
    }

    /// Evaluates the rates anew after a change of the state from outside.
    fn restart(&mut self) {
        self.formulation.evaluate(&mut self.water);
        self.evaluations += self.water.particles.len() as u64;
        self.is_gridded = false;
    }

    fn failure(&self, quantity: &'static str, value: f64, local: Vec2) -> NumericalFailure {
        let place = self.water.bed.lattice.to_map(local);
        NumericalFailure {
            time: self.time,
            step: self.steps,
            quantity,
            value,
            place: FailurePlace::OnMap(place),
            limiter: self.last_choice.map_or("nothing", |choice| choice.limit.name()),
        }
    }

    /// Finds the first particle whose state or rates are no longer finite.
    fn watch(&self) -> Result<(), NumericalFailure> {
        let particles = &self.water.particles;
        let fault = |(i, rates): (usize, &Rates)| {
            let (x, v, d) = (particles.position[i], particles.velocity[i], particles.depth[i]);
            let values = [
                ("the position", x.x + x.y),
                ("the velocity", v.norm()),
                ("the depth", d),
                ("the smoothing length", particles.smoothing_length[i]),
                ("the acceleration", rates.acceleration.norm()),
            ];
            let found = values.into_iter().find(|(_, value)| !value.is_finite());
            found.map(|(quantity, value)| (quantity, value, x))
        };
        let first = self.water.rates.par_iter().enumerate().with_min_len(CHUNK).find_map_first(fault);
        first.map_or(Ok(()), |(quantity, value, x)| Err(self.failure(quantity, value, x)))
    }

    /// Brings particles and rates into the order of the cells.
    fn sort(&mut self) {
        let particles = &mut self.water.particles;
        let count = particles.len();
        let order = self.water.neighbours.order();
        if order.len() != count {
            return;
        }
        // The half step of before is over.
        self.halves.resize(count, HalfStep::default());
        let scratch = bytemuck::cast_slice_mut(&mut self.halves);
        let arrays: [(&mut [f64], usize); 7] = [
            (bytemuck::cast_slice_mut(&mut particles.position), 2),
            (bytemuck::cast_slice_mut(&mut particles.velocity), 2),
            (&mut particles.volume, 1),
            (&mut particles.depth, 1),
            (&mut particles.smoothing_length, 1),
            (&mut particles.share, 1),
            (bytemuck::cast_slice_mut(&mut self.water.rates), size_of::<Rates>() / size_of::<f64>()),
        ];
        for (numbers, of_each) in arrays {
            sort_numbers(numbers, of_each, order, scratch);
        }
    }
}

/// Numbers that a particle has room for in the memory by which it is sorted and gridded.
const OF_A_HALF_STEP: usize = size_of::<HalfStep>() / size_of::<f64>();

/// Brings the numbers of particles, so many of each, into an order.
fn sort_numbers(numbers: &mut [f64], of_each: usize, order: &[u32], scratch: &mut [f64]) {
    for from in (0..of_each).step_by(OF_A_HALF_STEP) {
        let part = from..of_each.min(from + OF_A_HALF_STEP);
        let (old, length) = (&*numbers, part.len());
        scratch.par_chunks_mut(CHUNK * length).zip(order.par_chunks(CHUNK)).for_each(|(scratch, order)| {
            for (sorted, &j) in scratch.chunks_exact_mut(length).zip(order) {
                sorted.copy_from_slice(&old[j as usize * of_each..][part.clone()]);
            }
        });
        numbers.par_chunks_mut(CHUNK * of_each).zip(scratch.par_chunks(CHUNK * length)).for_each(
            |(numbers, scratch)| {
                for (numbers, sorted) in numbers.chunks_exact_mut(of_each).zip(scratch.chunks_exact(length)) {
                    numbers[part.clone()].copy_from_slice(sorted);
                }
            },
        );
    }
}

impl FlowSolver for VariationalSolver {
    fn time(&self) -> f64 {
        self.time
    }

    fn steps(&self) -> u64 {
        self.steps
    }

    /// dt = CFL min( reach / (c + max |Δu|), 0.8 √(h/|a|) ) over all particles.
    fn choose_step(&mut self) -> StepChoice {
        self.water.phases.start();
        let particles = &self.water.particles;
        let mut choice =
            StepChoice { time_step: f64::INFINITY, limit: StepLimit::NoWater, position: Vec2::ZERO, max_speed: 0.0 };
        let step_of = |rates: &Rates, h: f64, depth: f64| {
            let wave = rates.reach / (celerity(depth, self.water.gravity) + rates.approach);
            let push = ACCELERATION_SHARE * (h / rates.acceleration.norm().max(f64::MIN_POSITIVE)).sqrt();
            (self.courant * wave.min(push), if push < wave { StepLimit::Acceleration } else { StepLimit::Courant })
        };
        let chunks = self.water.rates.par_chunks(CHUNK).enumerate().map(|(chunk, rates)| {
            let (mut shortest, mut max_speed_squared) = ((f64::INFINITY, StepLimit::NoWater, 0), 0.0_f64);
            for (i, rates) in (chunk * CHUNK..).zip(rates) {
                let (step, limit) = step_of(rates, particles.smoothing_length[i], particles.depth[i]);
                if step < shortest.0 {
                    shortest = (step, limit, i);
                }
                max_speed_squared = max_speed_squared.max(particles.velocity[i].norm_squared());
            }
            (shortest, max_speed_squared)
        });
        let mut max_speed_squared = 0.0_f64;
        for ((time_step, limit, i), speed_squared) in chunks.collect::<Vec<_>>() {
            if time_step < choice.time_step {
                choice = StepChoice { time_step, limit, position: particles.position[i], ..choice };
            }
            max_speed_squared = max_speed_squared.max(speed_squared);
        }
        choice.max_speed = max_speed_squared.sqrt();
        self.first_choice = self.first_choice.or(Some(choice));
        self.last_choice = Some(choice);
        self.water.phases.end("choice of the step");
        choice
    }

    fn advance(&mut self, time_step: f64) -> Result<(), NumericalFailure> {
        if let (Some(first), Some(last)) = (self.first_choice, self.last_choice)
            && last.time_step < COLLAPSED_SHARE * first.time_step
        {
            return Err(self.failure("the time step", last.time_step, last.position));
        }
        self.water.phases.start();
        if self.steps.is_multiple_of(STEPS_PER_SORT) {
            self.sort();
            self.water.phases.end("order");
        }
        let (outflow, evaluations) = match self.integrator {
            Integrator::Leapfrog => (leapfrog(&mut self.formulation, &mut self.water, &mut self.halves, time_step), 1),
            Integrator::Heun => {
                let kept = (&mut self.halves, &mut self.beginnings);
                (heun(&mut self.formulation, &mut self.water, kept, time_step), 2)
            }
        };
        self.evaluations += evaluations * self.water.particles.len() as u64;
        self.time += time_step;
        self.steps += 1;
        self.ledger.outflow += outflow;
        self.is_gridded = false;
        let sound = self.watch();
        self.water.phases.end("motion");
        sound
    }

    fn water(&mut self) -> WaterOnLattice<'_> {
        if std::mem::replace(&mut self.is_gridded, true) {
            return self.gridder.water();
        }
        self.water.phases.start();
        let MovingWater { bed, walls, particles, .. } = &self.water;
        self.gridder.grid(bed, walls, particles);
        self.water.phases.end("gridding");
        self.gridder.water()
    }

    fn steps_of_a_record(&self) -> u64 {
        STEPS_OF_A_RECORD
    }

    fn ledger(&self) -> Ledger {
        Ledger { stored: self.water.particles.volume.iter().sum::<f64>(), ..self.ledger }
    }

    fn passages(&self) -> Vec<Passage> {
        let over_edges = Passage { way: Way::OpenEdges, inflow: 0.0, outflow: self.ledger.outflow, asked: None };
        let has_open_edges = self.water.walls.edges().iter().any(|edge| edge.is_open);
        has_open_edges.then_some(over_edges).into_iter().collect()
    }

    fn has_moving(&self) -> bool {
        true
    }

    fn particles(&self) -> usize {
        self.water.particles.len()
    }

    fn particle_evaluations(&self) -> u64 {
        self.evaluations
    }

    fn phases(&self) -> &Phases {
        &self.water.phases
    }
}
