//! A run on coarser cells to its end: where the flood will be and how fast, from which the cost of the run on its own cells follows.
//!
//! The coarsest cells go first. Half of their edge takes eight times the time; as long as that is little, it is taken.

use std::time::{Duration, Instant};

use crate::bed::BedParticles;
use crate::output::LevelRecord;
use crate::pipeline::by_level::costs;
use crate::pipeline::cores;
use crate::pipeline::looks::on_cells;
use crate::pipeline::scout::Scout;
use crate::pipeline::stages::flow_problem;
use crate::pipeline::steps::step_towards;
use crate::prepare::{Runnable, prepare};
use crate::scenario::Scenario;
use crate::scenario::methods::Motion;

/// The finer look is taken where it is expected to take so long (s) at most.
const LONGEST: f64 = 4.0;
/// A look that takes longer than expected is given up.
const GIVEN_UP: Duration = Duration::from_secs(12);
/// How much longer a run takes on cells of half the edge.
const HALF_THE_EDGE: f64 = 8.0;
/// Doublings of the edge up to the coarsest look.
const DOUBLINGS: i32 = 4;
/// Cells that lie across the shorter side of the terrain in a look, at least.
const ACROSS: usize = 12;

/// What a run is expected to take, by a look or by its levels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Expected {
    /// Edge (m) of the cells of the look.
    pub spacing: f64,
    /// The most cells with water at once.
    pub most: f64,
    /// Their mean over the run.
    pub mean: f64,
    /// Steps.
    pub steps: f64,
    /// Evaluations of the rates of one particle.
    pub evaluations: f64,
}

/// What a run on a bed is expected to take; none where the scene can't be put on coarser cells in the time for it.
pub(super) fn look(scenario: &Scenario, bed: &BedParticles) -> Option<Expected> {
    let shorter = bed.lattice.columns.min(bed.lattice.rows);
    if shorter == 0 {
        return None;
    }
    let mut best = None;
    for doublings in (0..=DOUBLINGS).rev() {
        let times = f64::from(doublings).exp2();
        if doublings > 0 && (shorter as f64) < ACROSS as f64 * times {
            continue;
        }
        let begin = Instant::now();
        let spacing = times * scenario.resolution.value;
        let scout = scout_at(scenario, spacing, begin);
        let (took, steps) = (begin.elapsed().as_secs_f64(), scout.as_ref().map_or(0.0, |scout| scout.seconds));
        best = scout.map(|scout| (spacing, scout)).or(best);
        if took + (HALF_THE_EDGE - 1.0) * steps > LONGEST {
            break;
        }
    }
    let (spacing, scout) = best?;
    let cost = costs(scenario, bed, &scout).first().copied()?;
    let time: f64 = scout.moments.iter().map(|moment| moment.duration).sum();
    let of_cells = spacing / scenario.resolution.value;
    let wet_seconds: f64 = scout.moments.iter().map(|moment| moment.duration * moment.wet.len() as f64).sum();
    let mean = (wet_seconds / time * of_cells * of_cells).min(cost.wet);
    Some(Expected { spacing, most: cost.wet, mean, steps: cost.steps, evaluations: cost.evaluations })
}

/// What a run on levels is expected to take.
pub(super) fn of_levels(levels: &[LevelRecord]) -> Option<Expected> {
    let coarsest = levels.last()?;
    let sum = |of: fn(&LevelRecord) -> f64| levels.iter().map(of).sum::<f64>();
    let most = sum(|level| level.expected_wet_cells);
    let steps = levels.iter().map(|level| level.expected_steps).fold(0.0, f64::max);
    (most > 0.0).then(|| Expected {
        spacing: coarsest.spacing_m,
        most,
        mean: most,
        steps,
        evaluations: sum(|level| level.expected_evaluations),
    })
}

/// The record of a run on cells of an edge (m) to its end; none where the scene can't be put on them, or in the time for it.
fn scout_at(scenario: &Scenario, spacing: f64, begin: Instant) -> Option<Scout> {
    let mut scenario = on_cells(scenario, spacing);
    scenario.numerics.motion = Motion::Eulerian;
    let Runnable { setup, .. } = prepare(&scenario).into_runnable().ok()?;
    let mut scout = Scout::new(&scenario, &setup.bed);
    let problem = flow_problem(&scenario, &setup, setup.bed.clone());
    let mut solver = cores::build(&scenario, problem, Vec::new(), &setup.initial_velocity);
    while solver.time() < scenario.end_time {
        let step = step_towards(scenario.end_time, solver.as_mut());
        solver.advance(step.time_step).ok()?;
        scout.follow(&step, solver.as_mut());
        if begin.elapsed() > GIVEN_UP {
            return None;
        }
    }
    Some(scout)
}
