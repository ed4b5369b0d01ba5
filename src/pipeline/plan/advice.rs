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

/// The motion that fits a scene: by the table of docs/validation/README.md cells at rest, for whatever is in it.
pub fn advice(scene: &Scene) -> Advice {
    let why = if scene.forcing.channels.is_empty() {
        "for the same processor time cells at rest had the smaller error in all cases with an answer; cells that move had half of it on the same \
         spacing where water swings in a basin, for some fifteen times the processor time"
    } else {
        "channels of one dimension have cells at rest alone"
    };
    Advice { motion: Motion::Eulerian, why: why.to_owned() }
}
