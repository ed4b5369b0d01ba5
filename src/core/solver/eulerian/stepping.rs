//! Steps of the levels: coarse ones take longer steps where their water lets them.
//!
//! The step of a level is 2^k times the shortest one. A level takes no longer step than a coarser one, and at most twice that of the next
//! finer level. Levels with the same step are stepped together. Within a step of a group of levels the finer ones go first, beside coarse water
//! that goes on as in its last two steps. What passes a hanging face meanwhile is what the coarse level gets:
//!
//! ```text
//! (M90)  Δt_l = 2^(k_l) Δt_0,   k_l = min(k_(l−1) + 1, floor(log2(min_(m≥l) Δt_m / Δt_0)))
//! (M91)  U(t + τ) = U + τ r + ½ τ (1 + τ/Δt) (r − r_b)     r, r_b the rates of the last step Δt and the one before
//! (M92)  F_coarse = (1/Δt) Σ ½ Δt_f F_fine     over both stages of all steps Δt_f of the finer level within Δt
//! ```
//!
//! A finer level whose water gets faster meanwhile takes more and shorter steps. What changes at given times, such as a breach, is stepped with the finest level.

use std::ops::Range;

use super::breach::Breaking;
use super::moving_cells::MovingCells;
use super::state::Fastest;
use super::update::Stage;
use super::{EulerianSolver, faces, gradient, mixing, outflow, primitive, update};
use crate::math::Vec2;
use crate::methods::{Reconstruction, Turbulence};
use crate::solver::{StepChoice, StepLimit};

/// k at most, and how often a step is halved within that of a coarser level: water that would need more has collapsed, which is found after the step.
const MOST_HALVINGS: u32 = 8;
/// Steps of a finer level within one of a coarser level, at most.
const MOST_PARTS: u64 = 1 << 12;

/// The steps of the levels.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct Stepping {
    /// k of each level.
    halvings: Vec<u32>,
    scratch: Scratch,
}

/// What the choice of a step needs of each level.
#[derive(Default, serde::Serialize, serde::Deserialize)]
struct Scratch {
    /// The step (s) that its water allows.
    allowed: Vec<f64>,
    /// Where (row, column) that is; none without water.
    places: Vec<Option<(usize, usize)>>,
    /// The greatest signal speed (m/s) at its boundaries, and where.
    over_boundaries: Vec<(f64, (usize, usize))>,
}

/// k of each level, the finest first, from the steps that their water allows (M90); infinite ones without water.
pub fn halvings(allowed: &[f64], k_of_levels: &mut [u32]) {
    let shortest = allowed.iter().copied().fold(f64::INFINITY, f64::min);
    let mut of_coarser = f64::INFINITY;
    for (k, &step) in k_of_levels.iter_mut().zip(allowed).rev() {
        of_coarser = of_coarser.min(step);
        // A level that no water limits steps with the next finer one: all is then as without it.
        *k = if of_coarser.is_finite() {
            (of_coarser / shortest).log2().min(f64::from(MOST_HALVINGS)) as u32
        } else {
            0
        };
    }
    let wet = allowed.iter().rposition(|step| step.is_finite()).map_or(0, |last| last + 1);
    for level in 1..k_of_levels.len() {
        let finer = k_of_levels[level - 1];
        k_of_levels[level] = if level < wet { k_of_levels[level].min(finer + 1) } else { finer };
    }
    // The finest level takes the shortest step.
    let lowest = k_of_levels.first().copied().unwrap_or(0);
    k_of_levels.iter_mut().for_each(|k| *k -= lowest);
}

impl Stepping {
    pub fn new(levels: usize) -> Self {
        let scratch = Scratch {
            allowed: vec![0.0; levels],
            places: vec![None; levels],
            over_boundaries: vec![(0.0, (0, 0)); levels],
        };
        Stepping { halvings: vec![0; levels], scratch }
    }

    /// The steps (s) that levels allow, the finest first; returns that of the coarsest.
    fn choose(&mut self, allowed: &[f64]) -> f64 {
        halvings(allowed, &mut self.halvings);
        let longest = self.halvings.last().copied().unwrap_or(0);
        let doubled = |k: u32| (1_u64 << k) as f64;
        let limit = |(k, step): (&u32, &f64)| step / doubled(*k);
        self.halvings.iter().zip(allowed).map(limit).fold(f64::INFINITY, f64::min) * doubled(longest)
    }

    /// Steps of the finest level in one of the coarsest.
    pub fn steps_of_finest(&self) -> f64 {
        (1_u64 << self.halvings.last().copied().unwrap_or(0)) as f64
    }

    /// The levels, among the first so many, that step together with the last of these.
    fn group(&self, count: usize) -> Range<usize> {
        let own = self.halvings[count - 1];
        self.halvings[..count].iter().position(|k| *k == own).unwrap_or(0)..count
    }
}

impl EulerianSolver {
    /// The greatest speeds of all levels, as [`State::fastest`](super::state::State::fastest) has them.
    pub(super) fn fastest(&self) -> Fastest {
        let levels = (0..self.lattice.level_count()).map(|level| self.in_part.fastest(&self.state, &self.scale, level));
        levels.fold(Fastest::default(), |greatest, level| Fastest {
            flow_speed: level.flow_speed.max(greatest.flow_speed),
            ..if level.signal_speed > greatest.signal_speed || level.signal_speed.is_nan() { level } else { greatest }
        })
    }

    /// The step of the coarsest level, and what limits it.
    pub(super) fn choose(&mut self) -> StepChoice {
        let scale = self.scale;
        let reach = scale.courant * scale.spacing;
        let without_water = scale.spacing / scale.gravity.sqrt();
        let Scratch { mut allowed, mut places, mut over_boundaries } = std::mem::take(&mut self.stepping.scratch);
        let mut max_speed: f64 = 0.0;
        for (level, (step, place)) in allowed.iter_mut().zip(&mut places).enumerate() {
            let fastest = self.in_part.fastest(&self.state, &scale, level);
            let is_moving = fastest.signal_speed > 0.0;
            *step = if is_moving { reach / fastest.signal_speed } else { f64::INFINITY };
            *place = is_moving.then_some((fastest.row, fastest.column));
            max_speed = max_speed.max(fastest.flow_speed);
        }
        let is_wet = allowed.iter().any(|step| step.is_finite());
        if !is_wet {
            allowed.fill(without_water);
        }
        let (in_channels, flow_in_channels) = self.reaches.fastest(&scale);
        max_speed = max_speed.max(flow_in_channels);
        let mut is_limited = is_wet;
        let mut limit = |allowed: &mut f64, speed: f64| {
            let is_faster = reach < *allowed * speed;
            if is_faster {
                *allowed = reach / speed;
                is_limited = true;
            }
            is_faster
        };
        limit(&mut allowed[0], in_channels);
        // What comes in may be faster than what is there.
        let longest = self.stepping.choose(&allowed);
        let step = (self.time, self.time + longest);
        let coming = self.reaches.fastest_inflow(&scale, self.methods, step);
        limit(&mut allowed[0], coming);
        self.open.fastest(&self.state, &scale, self.methods, step, &mut over_boundaries);
        for (level, &(speed, place)) in over_boundaries.iter().enumerate() {
            if limit(&mut allowed[level], speed) {
                places[level] = Some(place);
            }
        }
        let pace = self.moving.as_ref().map(MovingCells::pace).unwrap_or_default();
        max_speed = max_speed.max(pace.flow_speed);
        let of_moving = limit(&mut allowed[0], pace.haste * scale.spacing).then_some(pace.place);
        allowed[0] = self.inputs.longest_step(&scale, self.time, allowed[0]);
        let mut time_step = self.stepping.choose(&allowed);
        if let Some(breaking) = &self.breaking {
            time_step = breaking.step_until_change(self.time, time_step);
        }
        time_step = self.step_of_bed(time_step);
        let by_level = |a: &usize, b: &usize| allowed[*a].total_cmp(&allowed[*b]);
        let slowest = (0..allowed.len()).min_by(by_level).unwrap_or(0);
        let limit = if is_limited { StepLimit::Courant } else { StepLimit::NoWater };
        let in_rows = places[slowest].map_or(Vec2::ZERO, |(row, column)| self.state.position(row, column));
        let position = of_moving.unwrap_or(in_rows);
        self.stepping.scratch = Scratch { allowed, places, over_boundaries };
        StepChoice { time_step, limit, position, max_speed }
    }

    /// A step (s), or the one that ground which moves allows.
    fn step_of_bed(&mut self, time_step: f64) -> f64 {
        let scale = self.scale;
        if let Some(moving) = &self.moving_bed {
            // A step in which the bed begins to move, or is fast, is one for all levels.
            if moving.longest_step(&scale, self.time, time_step) < time_step {
                let of_finest = time_step / self.stepping.steps_of_finest();
                self.stepping.halvings.fill(0);
                return moving.longest_step(&scale, self.time, of_finest);
            }
        }
        time_step
    }

    /// Takes a step (s) of all levels.
    pub(super) fn step(&mut self, time_step: f64) {
        self.step_levels(self.lattice.level_count(), (self.time, 0.0), (time_step, time_step));
        self.sections.close(time_step);
        self.decay_tracers(time_step);
        if self.steps == 0 && self.methods.sleeps {
            self.let_sleep();
        }
        if self.active.has_woken() {
            // Of levels that did not step last, too: the next step is chosen by them.
            self.active.take_in_hand(0..self.state.rows + 2);
            primitive::evaluate(&mut self.state, &self.active, &self.scale);
        }
        self.active.end_record();
        self.time += time_step;
        self.steps += 1;
    }

    /// Lets water at rest sleep: none where it rains or the ground moves.
    fn let_sleep(&mut self) {
        if self.inputs.is_wetted || self.moving_bed.is_some() || self.moving.is_some() {
            return;
        }
        let of_dam = self.breaking.iter().flat_map(Breaking::places);
        self.active.take_in_hand(0..self.state.rows + 2);
        self.active.put_to_sleep(&self.state, self.open.cells().chain(of_dam));
    }

    /// Takes a step of so many levels, the finest first, from a time on (s), and so long (s). The time lies `ahead` (s) of that of the next
    /// coarser level, whose step (s) the step lies in.
    fn step_levels(&mut self, count: usize, (time, ahead): (f64, f64), (time_step, of_coarser): (f64, f64)) {
        let levels = self.stepping.group(count);
        if levels.start > 0 {
            self.general.begin(&mut self.state, &levels, self.scale.dry_depth);
            let mut done = 0.0;
            let mut left = 2_u64;
            while left > 0 {
                // In steps of the same length, unless the water has become too fast for them.
                let step = (time_step - done) / left as f64;
                let halvings = self.halvings_of(self.stepping.group(levels.start), step);
                let parts = (left << halvings).min(MOST_PARTS);
                let step = (time_step - done) / parts as f64;
                self.step_levels(levels.start, (time + done, done), (step, time_step));
                done += step;
                left = parts - 1;
            }
        } else {
            self.general.begin(&mut self.state, &levels, self.scale.dry_depth);
        }
        let pinned = self.moving.iter().flat_map(MovingCells::active_pinned);
        self.active.reach(self.general.getting(&levels).chain(pinned));
        self.active.take_in_hand(self.state.rows_of(&levels));
        let is_finest = levels.start == 0;
        if is_finest && let Some(moving) = &mut self.moving_bed {
            moving.follow(&mut self.state, time + 0.5 * time_step, self.scale.dry_depth);
            self.passes.follow(&self.state.ground);
        }
        let interval = (time, time + time_step);
        self.phases.end("gradients");
        self.active.choose(&mut self.state, Stage::First, self.scale.dry_depth);
        self.phases.end("active cells");
        self.stage(Stage::First, &levels, interval, (ahead, of_coarser));
        if is_finest {
            self.reaches.evaluate_primitive(Stage::Second);
            self.settle_moving(Stage::First, interval);
        }
        self.active.choose(&mut self.state, Stage::Second, self.scale.dry_depth);
        self.phases.end("active cells");
        self.stage(Stage::Second, &levels, interval, (ahead + time_step, of_coarser));
        self.inflow += self.inputs.add(&mut self.state, &self.active, time, time + time_step);
        self.settle_moving(Stage::Second, (time, time + time_step));
        self.active.follow(&self.state, self.scale.dry_depth);
        self.phases.end("active cells");
        primitive::evaluate(&mut self.state, &self.active, &self.scale);
        if is_finest {
            self.reaches.evaluate_primitive(Stage::First);
            self.change_bed(time + time_step);
        }
        self.general.end(&self.state, &levels, time_step);
        self.phases.end("velocities");
    }

    /// How often a step (s) of some levels has to be halved for the water of now.
    fn halvings_of(&self, levels: Range<usize>, step: f64) -> u32 {
        let fastest = levels.map(|level| self.in_part.fastest(&self.state, &self.scale, level).signal_speed);
        let speed = fastest.fold(0.0, f64::max);
        // The step was chosen with what the water was then; a little more is within what the scheme bears.
        let excess = step * speed / (1.2 * self.scale.courant * self.scale.spacing);
        if excess > 1.0 { (excess.log2().ceil() as u32).min(MOST_HALVINGS) } else { 0 }
    }

    /// Brings the bed of a dam that breaks and of ground that moves to a time (s).
    fn change_bed(&mut self, time: f64) {
        if let Some(breaking) = &mut self.breaking {
            breaking.follow(&mut self.state, time, self.scale.dry_depth);
        }
        if let Some(moving) = &mut self.moving_bed {
            moving.follow(&mut self.state, time, self.scale.dry_depth);
        }
        if self.breaking.is_some() || self.moving_bed.is_some() {
            self.passes.follow(&self.state.ground);
        }
        self.hand_out_bed();
    }

    /// One Euler stage of some levels: from the primitive quantities to fluxes, and from there to the stage's new state.
    ///
    /// - `from`, `to` (s): the step
    /// - `ahead` (s): how far the stage lies ahead of the next coarser level, and the step of that level
    fn stage(&mut self, stage: Stage, levels: &Range<usize>, (from, to): (f64, f64), (ahead, of_coarser): (f64, f64)) {
        let (state, active, scale) = (&mut self.state, &self.active, &self.scale);
        let (time_step, rows, is_finest) = (to - from, active.at_hand(), levels.start == 0);
        let is_mixed = self.methods.turbulence != Turbulence::None;
        if is_finest {
            self.conforming.look(state);
        }
        if let Some(moving) = &mut self.moving {
            moving.look(state, scale.dry_depth);
        }
        self.general.look(state, levels, (stage, ahead), scale.dry_depth);
        let has_slopes = is_mixed || self.methods.reconstruction != Reconstruction::None;
        if has_slopes {
            gradient::evaluate(state, active, scale);
            self.walls.correct_gradients(state, active, scale);
            self.passes.correct_gradients(state, active, scale);
            self.general.correct_gradients(state, active, &self.passes, scale);
            if is_finest {
                self.conforming.evaluate_gradients(state, scale.dry_depth);
                self.reaches.evaluate_gradients(state, scale);
            }
        }
        if let Some(moving) = &mut self.moving {
            moving.evaluate_gradients(scale.dry_depth, has_slopes);
            moving.show_gradients(state);
        }
        self.phases.end("gradients");
        faces::evaluate(state, active, scale, self.methods);
        if is_mixed {
            mixing::add(state, active, scale, &self.methods.constants, time_step);
        }
        self.passes.apply(state, active, scale, self.methods);
        self.walls.apply(state, active, scale);
        self.general.apply(state, (active, levels), (scale, self.methods), time_step);
        if is_finest {
            self.conforming.apply(state, scale, self.methods, time_step);
        }
        self.in_part.apply(state, active, scale);
        if let Some(moving) = &mut self.moving {
            moving.evaluate_fluxes(scale, self.methods, time_step);
        }
        self.open.apply(state, &rows, scale, self.methods, (from, to));
        if is_finest {
            self.reaches.pass(state, scale, self.methods, stage, (from, to));
        }
        active.hold(&mut state.flux);
        self.phases.end("faces");
        let special = (&mut self.general, &mut self.conforming, &mut self.moving);
        outflow::limit(state, (active, levels), special, stage, (time_step, of_coarser));
        self.find_tracer_slopes(stage, time_step);
        if let Some(moving) = &mut self.moving {
            moving.update(&self.state, &self.scale, stage, time_step);
        }
        self.carry_tracers(stage, time_step);
        update::apply(&mut self.state, &self.active, &self.scale, stage, time_step);
        self.general.book(levels, time_step);
        self.book(stage, levels, time_step);
        self.phases.end("update");
    }

    /// Brings the cells that move to the end of a stage of a step between two times (s), with the rain of the step.
    fn settle_moving(&mut self, stage: Stage, (from, to): (f64, f64)) {
        let Some(moving) = &mut self.moving else { return };
        if stage == Stage::Second {
            self.inflow += self.inputs.rain_on(moving, from, to);
        }
        moving.settle(&self.scale, stage);
        moving.show(&mut self.state);
        self.phases.end("partition");
    }

    /// Adds what came and left over boundaries, edges and channels in a stage of a step (s): each of its two stages carries half of it.
    fn book(&mut self, stage: Stage, levels: &Range<usize>, time_step: f64) {
        let (state, rows) = (&self.state, self.active.at_hand());
        let carried = 0.5 * time_step;
        let over_boundaries = self.open.book(state, &rows, carried);
        let of_channels = if levels.start == 0 {
            self.reaches.apply(state, &self.scale, stage, time_step)
        } else {
            Default::default()
        };
        self.inflow += carried * (over_boundaries.inflow + of_channels.inflow);
        let over_edges = self.walls.leaving(state, &self.active);
        self.left_over_edges += carried * over_edges;
        self.outflow += carried * (over_edges + over_boundaries.outflow + of_channels.outflow);
        self.sections.add(state, (&self.general, &self.conforming), levels, time_step);
        let in_channels = if levels.start == 0 { self.reaches.particles().0 } else { 0 };
        self.evaluations += (self.active.cells_at_hand()
            + in_channels
            + self.moving.as_ref().map_or(0, MovingCells::active_cells)) as u64;
    }
}
