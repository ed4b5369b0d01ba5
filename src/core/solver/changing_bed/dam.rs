//! The dam of a problem: its trigger, and its bed since then (M46).

use crate::boundary::{Breach, Trigger};
use crate::math::Vec2;
use crate::solver::FlowProblem;

/// Share of a time by which rounding may miss it.
const ROUND_OFF: f64 = 1e-12;

/// The dam of a problem and how far it has gone.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(in crate::solver) struct BreakingDam {
    breach: Breach,
    /// The time (s) at which the breach began.
    opened: Option<f64>,
    /// The share of the growth that the bed shows.
    share: f64,
    /// The bed (m) now of the cells of the dam, and after them of those beside it that sink with it.
    bed: Vec<(usize, f64)>,
}

impl BreakingDam {
    /// None where no dam breaks.
    pub fn new(problem: &FlowProblem) -> Option<Self> {
        let breach = problem.forcing.breach.clone()?;
        let bed = breach.beds(0.0).collect();
        Some(BreakingDam { opened: None, share: 0.0, bed, breach })
    }

    /// Where (m) the level of the water is watched; none where it breaks at a time.
    pub fn watched(&self) -> Option<Vec2> {
        match self.breach.trigger {
            Trigger::At(_) => None,
            Trigger::Level { place, .. } => Some(place),
        }
    }

    /// Whether the breach begins at a time (s) and a level (m) of the water where it is watched, none where it is dry.
    pub fn watch(&mut self, time: f64, level_at: impl FnOnce(Vec2) -> Option<f64>) {
        if self.opened.is_none() {
            self.opened = match self.breach.trigger {
                Trigger::At(at) => (time >= at * (1.0 - ROUND_OFF)).then_some(at),
                Trigger::Level { level, place } => {
                    level_at(place).is_some_and(|surface| surface >= level).then_some(time)
                }
            };
        }
    }

    /// Sets the bed of a time (s); whether it changed.
    pub fn follow(&mut self, time: f64) -> bool {
        let Some(opened) = self.opened else { return false };
        // A time that rounding leaves a little before the trigger counts as the trigger.
        let share = self.breach.share((time - opened).max(0.0));
        if share <= self.share {
            return false;
        }
        self.share = share;
        self.bed.iter_mut().zip(self.breach.beds(share)).for_each(|(bed, now)| *bed = now);
        true
    }

    /// A step (s) from a time on, shortened so that it ends where the breach begins, and where it has grown: a step sees the bed of its
    /// beginning, and one that is longer than the growth would see the dam stand.
    pub fn step_until_change(&self, time: f64, step: f64) -> f64 {
        let change = match (self.opened, self.breach.trigger) {
            (None, Trigger::At(at)) => at,
            (None, Trigger::Level { .. }) => return step,
            (Some(_), _) if self.share >= 1.0 => return step,
            (Some(opened), _) => opened + self.breach.duration,
        };
        if change > time && change < time + step { change - time } else { step }
    }

    /// The cells of the dam, those beside it that sink with it, and their bed (m) now.
    pub fn bed(&self) -> &[(usize, f64)] {
        &self.bed
    }

    /// The time (s) at which the breach began.
    pub fn opened(&self) -> Option<f64> {
        self.opened
    }
}
