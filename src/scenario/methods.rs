//! The registry of methods: every family of DESIGN section 4 as an enum whose members have a name and a sentence.
//!
//! The scenario parser, the help, the schema and the tables read these lists; a new method is one file and one line here.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

macro_rules! family {
    ($(#[$doc:meta])* $family:ident { $($(#[$default:meta])* $member:ident = $name:literal : $summary:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        pub enum $family {
            $(
                #[doc = $summary]
                $(#[$default])*
                #[serde(rename = $name)]
                $member,
            )+
        }

        impl $family {
            /// Every member of the family.
            pub const ALL: &'static [$family] = &[$($family::$member),+];

            /// The name as written in a scenario.
            pub fn name(self) -> &'static str {
                match self { $($family::$member => $name,)+ }
            }

            /// One sentence on the method.
            pub fn summary(self) -> &'static str {
                match self { $($family::$member => $summary,)+ }
            }
        }
    };
}

family! {
    /// How the shallow-water equations become sums over particles.
    Formulation {
        #[default]
        Balanced = "balanced": "carried depth, pair faces with hydrostatic reconstruction; a lake at rest stays at rest on any bed",
        Variational = "variational": "summation depth with variable smoothing length: the classic SPH form of the shallow-water equations",
    }
}

family! {
    /// Whether the particles of the balanced formulation move with the water or rest on the riverbed.
    Motion {
        #[default]
        Eulerian = "eulerian": "riverbed particles carry the water and exchange it through their faces",
        Lagrangian = "lagrangian": "fluid particles of fixed volume move with the water",
    }
}

family! {
    /// The treatment of a pair of particles as a Riemann problem.
    Stabilisation {
        #[default]
        Riemann = "riemann": "approximate Riemann solver with limited reconstruction (HLL for resting, two shocks for moving particles)",
        ArtificialViscosity = "artificial_viscosity": "Monaghan's viscosity; for the variational formulation",
    }
}

family! {
    /// How moving particles are placed in still water at the start.
    Seeding {
        #[default]
        Lattice = "lattice": "one particle at the centre of each wet cell, with the volume of its water",
        EqualVolume = "equal_volume": "particles of one volume, the mean of the wet cells; closer together where the water is deep",
    }
}

family! {
    /// The smoothing kernel.
    Kernel {
        #[default]
        CubicSpline = "cubic_spline": "cubic B-spline, support two smoothing lengths",
    }
}

family! {
    /// How a riverbed particle gets its elevation from the terrain.
    BedMethod {
        #[default]
        Pointwise = "pointwise": "bilinear terrain elevation at the particle",
        Shepard = "shepard": "kernel mean of the terrain around the particle, corrected to be exact for a plane",
    }
}

family! {
    /// Time integration.
    Integrator {
        #[default]
        Heun = "heun": "two-stage strong-stability-preserving Runge-Kutta; default of resting particles",
        Leapfrog = "leapfrog": "kick-drift-kick with predicted velocity; default of moving particles",
    }
}
