//! What a run with Eulerian particles, and with cells that move, is computed by.

use crate::constants::EulerianConstants;
use crate::methods::{Core, Reconstruction, Stabilisation, Turbulence};

/// The methods of a run with Eulerian particles.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct EulerianMethods {
    /// The flux: one that Eulerian particles have.
    pub flux: Stabilisation,
    /// The states at the faces.
    pub reconstruction: Reconstruction,
    /// The mixing in the plane.
    pub turbulence: Turbulence,
    /// The constants of all of these.
    pub constants: EulerianConstants,
    /// Whether still water sleeps until something reaches it (M102); not where it is to be seen at rest.
    pub sleeps: bool,
    /// Whether cells move with their water, where they can.
    pub moves: bool,
}

impl Default for EulerianMethods {
    fn default() -> Self {
        let flux = Core::Eulerian.usual_stabilisation();
        EulerianMethods {
            flux,
            reconstruction: flux.usual_reconstruction(),
            turbulence: Turbulence::default(),
            constants: EulerianConstants::DEFAULT,
            // Tests of the core see their water at rest.
            sleeps: !cfg!(test),
            moves: false,
        }
    }
}
