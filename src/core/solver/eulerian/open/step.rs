//! What the series of a condition say of a step.

use crate::boundary::Series;
use crate::solver::eulerian::Scale;

/// Discharge and level of a boundary: the mean of a step, or the largest in it.
#[derive(Clone, Copy)]
pub(in crate::solver::eulerian) enum Of {
    Mean,
    Largest,
}

/// A step from one time to another (s), for the series of a condition.
pub(super) struct InStep<'a> {
    pub(super) scale: &'a Scale,
    /// Height (m) from which the solver counts elevations.
    pub(super) datum: f64,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) of: Of,
}

impl InStep<'_> {
    fn value(&self, series: &Series) -> f64 {
        match self.of {
            Of::Mean => series.mean(self.from, self.to),
            Of::Largest => series.largest(self.from, self.to),
        }
    }

    /// A discharge in m²/s times spacings; nothing comes in where it is below 0.
    pub(super) fn total(&self, discharge: &Series) -> f64 {
        self.value(discharge).max(0.0) / self.scale.spacing
    }

    /// A level (m), counted as in the solver.
    pub(super) fn level(&self, series: &Series) -> f64 {
        self.value(series) - self.datum
    }

    /// The mean level (m) of still water beyond: less of it makes a wave faster.
    pub(super) fn mean_level(&self, series: &Series) -> f64 {
        series.mean(self.from, self.to) - self.datum
    }
}
