//! The core with moving particles: a formulation, an integrator, the books and the watch.

use rayon::prelude::*;

use super::bed_motion::ChangingBed;
use super::step::{Beginning, HalfStep, heun, leapfrog};
use super::{CHUNK, Formulation, MovingMethods, MovingWater, Rates};
use crate::failure::{FailurePlace, NumericalFailure};
use crate::gridding::{Gridder, Lent};
use crate::lattice::WaterOnLattice;
use crate::math::Vec2;
use crate::methods::Integrator;
use crate::particles::FluidSeed;
use crate::physics::celerity;
use crate::physics::dimension::Dimension;
use crate::solver::changing_bed::{BreakingDam, MovingGround};
use crate::solver::phases::Phases;
use crate::solver::{BedBalance, FlowProblem, FlowSolver, Ledger, Passage, SectionFlow, StepChoice, StepLimit};

/// The acceleration may use so much of the smoothing length in a step of Courant number 1.
const ACCELERATION_SHARE: f64 = 0.8;
/// A step this much shorter than the first one has collapsed.
const COLLAPSED_SHARE: f64 = 1e-5;
/// Particles are brought into the order of the cells every so many steps.
const STEPS_PER_SORT: u64 = 8;
/// Steps between two records of the grid. Signals cross 0.6 spacings in a step and water less; the recorder draws straight lines between.
const STEPS_OF_A_RECORD: u64 = 3;

/// Moving particles in a given formulation.
pub struct MovingSolver<F: Formulation> {
    water: MovingWater,
    changing_bed: Option<ChangingBed>,
    formulation: F,
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

impl<F: Formulation> MovingSolver<F> {
    /// Particles at rest, with their first rates.
    pub(in crate::solver) fn with_formulation(
        problem: FlowProblem,
        seeds: Vec<FluidSeed>,
        formulation: F,
        methods: MovingMethods,
        dimension: Dimension,
    ) -> Self {
        let stored = seeds.iter().fold(0.0, |sum, seed| sum + seed.volume);
        let courant = problem.courant;
        let changes = (BreakingDam::new(&problem), MovingGround::new(&problem));
        let mut water = MovingWater::new(problem, &seeds, dimension, methods);
        // The first evaluation needs memory.
        drop(seeds);
        let changing_bed = ChangingBed::new(changes, &mut water, dimension);
        let gridder = Gridder::new(&water.bed.lattice, dimension);
        let mut solver = MovingSolver {
            water,
            changing_bed,
            formulation,
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
        solver.end_change_of_bed();
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

    /// The state, to be changed before the first step: velocities at the start, for instance. Follow with `restart`.
    pub fn state_mut(&mut self) -> &mut MovingWater {
        &mut self.water
    }

    /// Evaluates the rates anew after a change of the state from outside.
    pub fn restart(&mut self) {
        self.formulation.evaluate(&mut self.water);
        self.evaluations += self.water.particles.len() as u64;
        self.is_gridded = false;
    }

    /// Sets the bed at the end of a step; where it changes all at once, the rates are those above the new one.
    fn end_change_of_bed(&mut self) {
        let (time, water) = (self.time, &mut self.water);
        if let Some(changing_bed) = &mut self.changing_bed
            && changing_bed.end_step(water, time)
        {
            self.restart();
        }
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
                ("the rate of the depth", rates.depth_rate),
            ];
            let found = values.into_iter().find(|(_, value)| !value.is_finite());
            found.map(|(quantity, value)| (quantity, value, x))
        };
        let first = self.water.rates.par_iter().enumerate().with_min_len(CHUNK).find_map_first(fault);
        first.map_or(Ok(()), |(quantity, value, x)| Err(self.failure(quantity, value, x)))
    }

    /// Brings particles and rates into the order of the cells. Buffer particles are not among them.
    fn sort(&mut self) {
        let particles = &mut self.water.particles;
        let count = particles.len();
        let cells = self.water.neighbours.order();
        let water: Vec<u32>;
        let order = if cells.len() == count {
            cells
        } else {
            water = cells.iter().copied().filter(|&j| (j as usize) < count).collect();
            &water
        };
        if order.len() != count {
            return;
        }
        // The half step of before is over.
        self.halves.resize(count, HalfStep::default());
        let scratch = bytemuck::cast_slice_mut(&mut self.halves);
        let arrays: [(&mut [f64], usize); 6] = [
            (bytemuck::cast_slice_mut(&mut particles.position), 2),
            (bytemuck::cast_slice_mut(&mut particles.velocity), 2),
            (&mut particles.volume, 1),
            (&mut particles.depth, 1),
            (&mut particles.smoothing_length, 1),
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

impl<F: Formulation> FlowSolver for MovingSolver<F> {
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
        for (rates, h, depth, position) in self.water.open.signals() {
            let (time_step, limit) = step_of(rates, h, depth);
            if time_step < choice.time_step {
                choice = StepChoice { time_step, limit, position, ..choice };
            }
        }
        choice.max_speed = max_speed_squared.sqrt();
        if self.water.is_fed() {
            // Without water a step as resting particles take it.
            let dry = self.water.bed.lattice.spacing / self.water.gravity.sqrt();
            let step = if choice.limit == StepLimit::NoWater { dry } else { choice.time_step };
            choice.time_step = self.water.springs.longest_step(self.water.open.longest_step(step));
        }
        self.first_choice = self.first_choice.or(Some(choice));
        self.last_choice = Some(choice);
        if let Some(changing_bed) = &self.changing_bed {
            // Not before the choice is kept: an event may lie as near as it likes.
            let reach = self.courant * self.water.bed.lattice.spacing;
            choice.time_step = changing_bed.longest_step(reach, self.time, choice.time_step);
        }
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
        if let Some(changing_bed) = &mut self.changing_bed
            && changing_bed.begin_step(&mut self.water, self.time, self.time + time_step)
        {
            self.water.phases.end("bed");
        }
        self.water.sections.begin(&self.water.particles);
        let (outflow, evaluations) = match self.integrator {
            Integrator::Leapfrog => (leapfrog(&mut self.formulation, &mut self.water, &mut self.halves, time_step), 1),
            Integrator::Heun => {
                let kept = (&mut self.halves, &mut self.beginnings);
                (heun(&mut self.formulation, &mut self.water, kept, time_step), 2)
            }
        };
        self.evaluations += evaluations * self.water.particles.len() as u64;
        if F::CARRIES_DEPTH && self.water.dimension == Dimension::One {
            self.water.sections.pause(&self.water.particles);
            self.water.merge();
            self.water.sections.go_on(&self.water.particles);
        }
        self.time += time_step;
        self.steps += 1;
        self.ledger.outflow += outflow;
        self.water.enter(time_step);
        self.end_change_of_bed();
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
        let fluid = self.water.lend();
        self.gridder.put_beside(self.water.on_dry_ground());
        let MovingWater { bed, walls, particles, open, neighbours, .. } = &mut self.water;
        let (bed, walls, particles) = (&*bed, &*walls, &*particles);
        self.gridder.put_beyond((bed, walls), open.water_beyond());
        match self.formulation.spare_memory(particles.len()) {
            Some(lines) => {
                // The half step of before and the search are over here, too.
                let cells = bed.lattice.len();
                self.halves.resize(particles.len().max(cells.div_ceil(OF_A_HALF_STEP)), HalfStep::default());
                let numbers: &mut [f64] = bytemuck::cast_slice_mut(&mut self.halves);
                let lent = Lent { lines, factors: &mut numbers[..cells], pieces: neighbours.spare_memory() };
                self.gridder.grid_within(bed, walls, particles, lent)
            }
            None => self.gridder.grid(bed, walls, particles),
        };
        self.water.take_back(fluid);
        self.water.phases.end("gridding");
        self.gridder.water()
    }

    fn steps_of_a_record(&self) -> u64 {
        STEPS_OF_A_RECORD
    }

    fn ledger(&self) -> Ledger {
        let (came, left) = self.water.passed();
        let stored = self.water.particles.volume.iter().sum::<f64>() + self.water.owed();
        Ledger { inflow: came, outflow: self.ledger.outflow + left, stored, ..self.ledger }
    }

    fn sections(&self) -> &[SectionFlow] {
        self.water.sections.flows()
    }

    fn passages(&self) -> Vec<Passage> {
        self.water.passages(self.ledger.outflow)
    }

    fn bed_now(&self) -> &[(usize, f64)] {
        self.changing_bed.as_ref().map_or(&[], ChangingBed::bed)
    }

    fn breach_began(&self) -> Option<f64> {
        self.changing_bed.as_ref().and_then(ChangingBed::breach_began)
    }

    fn bed_balance(&self) -> Option<BedBalance> {
        self.changing_bed.as_ref().and_then(ChangingBed::balance)
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
