//! What is carried with the water: where it is at the start, and what has it that comes in.

/// A tracer; concentrations in its own unit.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tracer {
    /// Of the water on each square of the finest lattice at the start; empty where none has any.
    pub initial: Vec<f64>,
    /// Of the water that comes in by each open boundary with a condition, in their order.
    pub boundaries: Vec<f64>,
    /// Of that of each point source and of each line source.
    pub sources: Vec<f64>,
    /// The same.
    pub line_sources: Vec<f64>,
    /// Of the rain.
    pub rain: f64,
    /// Rate of decay (1/s), 0 where it stays.
    pub decay: f64,
}
