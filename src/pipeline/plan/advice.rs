//! The motion that fits a scene, and why.

use crate::prepare::Scene;
use crate::scenario::methods::Motion;

/// The motion that fits a scene, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// The motion.
    pub motion: Motion,
    /// Why, in words.
    pub why: String,
}

/// The motion that fits a scene, by the errors and CPU times in docs/validation/analytic/chart.csv: `lagrangian` for water that is marked at the
/// start where no rain falls, `eulerian` for all else. See docs/guide/motions.md.
pub fn advice(scene: &Scene) -> Advice {
    let is_marked = scene.forcing.tracers.iter().any(|tracer| !tracer.initial.is_empty());
    if is_marked && scene.forcing.rain.is_none() {
        let why = "cells that move carry marked water along where resting ones smear it: for the same CPU time they have a quarter of the error of \
                   the concentration, on the same spacing they take 5 to 12 times as long";
        return Advice { motion: Motion::Lagrangian, why: why.to_owned() };
    }
    let why = if scene.forcing.channels.is_empty() {
        "for the same CPU time Eulerian particles have the smaller error in all cases with an answer but basins where water swings; there cells \
         that move have a third to a half of the depth error on the same spacing, for 5 to 12 times the CPU time"
    } else {
        "channels of one dimension have Eulerian particles alone"
    };
    Advice { motion: Motion::Eulerian, why: why.to_owned() }
}
