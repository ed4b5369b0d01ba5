//! How the numerics break down: when, where, and in which quantity.

use std::fmt;

use crate::math::Vec2;

/// Where the numerics broke down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FailurePlace {
    /// On the plane, in map coordinates (m).
    OnMap(Vec2),
    /// In a channel of one dimension.
    InChannel {
        /// Its number in the list of the scenario, from 1.
        number: usize,
        /// Distance from its far end (m).
        distance: f64,
    },
}

impl fmt::Display for FailurePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FailurePlace::OnMap(place) => write!(f, "at {:.1}, {:.1}", place.x, place.y),
            FailurePlace::InChannel { number, distance } => {
                write!(f, "in channel {number}, {distance:.1} m from its far end")
            }
        }
    }
}

/// A breakdown of the numerics: when, where, which quantity, and what limited the step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "the run broke down at t = {time:.3} s, step {step}: {quantity} is {value:e} {place} (the step was limited by {limiter})"
)]
pub struct NumericalFailure {
    /// Simulated time (s).
    pub time: f64,
    /// Number of the step.
    pub step: u64,
    /// Name of the quantity that went wrong.
    pub quantity: &'static str,
    /// Its value.
    pub value: f64,
    /// Where.
    pub place: FailurePlace,
    /// What limited the time step.
    pub limiter: &'static str,
}
