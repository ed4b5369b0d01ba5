//! What is carried with the water.

use super::{Scenario, Sourced, VectorSource};

/// A tracer.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracer {
    /// Its name, part of the names of variables and columns.
    pub name: Sourced<String>,
    /// Unit of its concentrations, as written; `1` for a share.
    pub unit: String,
    /// Where it comes from.
    pub from: Vec<TracerFrom>,
    /// Half-life (s); none where it does not decay.
    pub half_life: Option<f64>,
    /// Share of the greatest concentration of its sources that counts as arrival.
    pub arrival_threshold: f64,
}

impl Tracer {
    /// The greatest concentration of its sources.
    pub fn greatest(&self) -> f64 {
        self.from.iter().map(|from| from.concentration).fold(0.0, f64::max)
    }
}

/// Water that has a tracer.
#[derive(Clone, Debug, PartialEq)]
pub struct TracerFrom {
    /// Which water.
    pub place: TracerPlace,
    /// Its concentration, in the unit of the tracer.
    pub concentration: f64,
}

impl Scenario {
    /// The place in `boundaries` of an entry of the scenario file, counted from 0; none of an edge that is only open.
    pub fn boundary_of_entry(&self, entry: usize) -> Option<usize> {
        let key = format!("boundaries[{entry}]");
        let is_it = |own: &str| own.strip_prefix(&key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        self.boundaries.iter().position(|boundary| is_it(&boundary.key))
    }
}

/// Which water has a tracer.
#[derive(Clone, Debug, PartialEq)]
pub enum TracerPlace {
    /// That in polygons at the start.
    Water(Sourced<VectorSource>),
    /// That of an entry of `boundaries`, counted from 0.
    Boundary(usize),
    /// That of an entry of `sources`, counted from 0.
    Source(usize),
    /// Rain.
    Rain,
}
