//! Methods with their numbers, and the limits of a run.

use floodsim_core::constants::Constants;

use crate::scenario::methods::{
    BedMethod, BedSlope, Core, Formulation, Integrator, Kernel, Motion, Reconstruction, Seeding, Stabilisation,
    Turbulence, WallMethod,
};

/// Chosen methods and their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Numerics {
    /// Formulation.
    pub formulation: Formulation,
    /// Motion.
    pub motion: Motion,
    /// Stabilisation.
    pub stabilisation: Stabilisation,
    /// Reconstruction.
    pub reconstruction: Reconstruction,
    /// Seeding of the variational formulation.
    pub seeding: Seeding,
    /// Kernel.
    pub kernel: Kernel,
    /// Integrator.
    pub integrator: Integrator,
    /// Bed.
    pub bed: BedMethod,
    /// Effect of the bed's slope.
    pub bed_slope: BedSlope,
    /// Turbulence in the plane.
    pub turbulence: Turbulence,
    /// Walls of the variational formulation.
    pub wall: WallMethod,
    /// Courant number.
    pub cfl: f64,
    /// Gravity (m/s²).
    pub gravity: f64,
    /// Depth (m) below which water does not move.
    pub dry_depth: f64,
    /// Constants of the methods; no scenario sets them.
    pub constants: Constants,
    /// Whether still water sleeps: in every scenario, not in built-in cases.
    pub sleeps: bool,
}

impl Numerics {
    /// The core that they ask for.
    pub fn core(&self) -> Core {
        Core::of(self.formulation, self.motion)
    }

    /// Whether they are those of the balanced formulation, whose cells have faces, whether they rest or move; the variational one sums over
    /// particles alone.
    pub fn has_cells(&self) -> bool {
        self.formulation == Formulation::Balanced
    }

    /// Every method that acts, as family and name, and the Courant number.
    pub fn acting(&self) -> Vec<(&'static str, String)> {
        const ALL: &[Core] = Core::ALL;
        const CLASSIC: &[Core] = &[Core::Variational];
        let families: [(&str, &str, &[Core]); 11] = [
            ("formulation", self.formulation.name(), ALL),
            ("motion", self.motion.name(), ALL),
            ("stabilisation", self.stabilisation.name(), ALL),
            ("reconstruction", self.reconstruction.name(), ALL),
            ("integrator", self.integrator.name(), ALL),
            ("bed", self.bed.name(), ALL),
            ("seeding", self.seeding.name(), CLASSIC),
            ("kernel", self.kernel.name(), CLASSIC),
            ("wall", self.wall.name(), CLASSIC),
            ("bed_slope", self.bed_slope.name(), CLASSIC),
            ("turbulence", self.turbulence.name(), &[Core::Eulerian]),
        ];
        let acting = families.into_iter().filter(|(.., cores)| cores.contains(&self.core()));
        acting.map(|(family, name, _)| (family, name.to_owned())).chain([("cfl", self.cfl.to_string())]).collect()
    }
}

/// Limits that are checked before the run and watched during it, and what a run that is cut off loses at most.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Memory (bytes).
    pub memory: f64,
    /// Size of the run folder (bytes), where that is limited by more than its disk.
    pub disk: Option<f64>,
    /// Particles, riverbed and fluid together.
    pub particles: f64,
    /// Time between two checkpoints (s of the clock on the wall); none for no checkpoints.
    pub checkpoint: Option<f64>,
    /// Whether inputs may come from a network or an archive, and VRTs name files from elsewhere.
    pub allow_remote: bool,
}
