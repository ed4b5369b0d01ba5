//! The motion that fits a scene, and why.

use crate::prepare::Scene;
use crate::scenario::methods::Motion;
use crate::seeding::Reach;

/// Eulerian particles are advised where moving ones would get wider than this many spacings.
const STILL_RESOLVED: f64 = 2.0;

/// The motion that fits a scene, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// The motion.
    pub motion: Motion,
    /// Why, in words.
    pub why: String,
}

/// The motion that fits a scene: by what is in it, or else by how far its water reaches.
pub fn advice(scene: &Scene, reach: &Reach, spread: f64, spacing: f64) -> Advice {
    let why = if !scene.forcing.channels.is_empty() {
        "channels of one dimension have Eulerian particles alone"
    } else if !scene.forcing.is_still() {
        "water that comes in goes where Eulerian particles follow it evenly"
    } else if scene.forcing.breach.is_some() || !scene.forcing.moving_bed.is_empty() {
        "how far the water of a bed that changes can run is not known before, and Eulerian particles keep their spacing"
    } else {
        return by_reach(reach, spread, spacing);
    };
    Advice { motion: Motion::Eulerian, why: why.to_owned() }
}

/// The motion that fits the reach of the water: the rule of decision 0003, with the numbers of the scene.
fn by_reach(reach: &Reach, spread: f64, spacing: f64) -> Advice {
    if reach.pockets > 0 {
        let why = format!(
            "the water can reach {} pockets of the ground, in which Lagrangian particles slosh and Eulerian ones do not",
            reach.pockets
        );
        Advice { motion: Motion::Eulerian, why }
    } else if spread > STILL_RESOLVED {
        let why = format!(
            "spread over all that it can reach, the water would leave Lagrangian particles {:.3} m apart, {spread:.1} spacings; Eulerian ones keep {spacing} m",
            spread * spacing
        );
        Advice { motion: Motion::Eulerian, why }
    } else {
        let why = format!(
            "no pocket holds water back, and spread over all that it can reach the water leaves Lagrangian particles {:.3} m apart at most",
            spread * spacing
        );
        Advice { motion: Motion::Lagrangian, why }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motion_follows_pockets_and_spread() {
        let reach = |pockets| Reach { cells_at: vec![4, 4], pockets };
        assert_eq!(by_reach(&reach(0), 1.4, 1.0).motion, Motion::Lagrangian);
        assert_eq!(by_reach(&reach(0), 2.1, 1.0).motion, Motion::Eulerian);
        assert_eq!(by_reach(&reach(1), 1.4, 1.0).motion, Motion::Eulerian);
    }
}
