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
    /// What keeps the flow between a pair of particles stable.
    Stabilisation {
        #[default]
        Hllc = "hllc": "HLLC Riemann solver: two waves and the contact between them; default of Eulerian particles",
        TwoShocks = "two_shocks": "Riemann solver with two shocks or two rarefactions; default of the balanced formulation with Lagrangian particles",
        LaxFriedrichs = "lax_friedrichs": "Lax-Friedrichs flux with the greatest speed of the pair",
        ArtificialViscosity = "artificial_viscosity": "viscosity between particles that approach each other; default of the variational formulation, and for it alone",
    }
}

family! {
    /// The states on both sides of the face between a pair of particles.
    Reconstruction {
        #[default]
        Limited = "limited": "levels, depths and normal velocities carried to the face along gradients that a limiter bounds",
        Sharp = "sharp": "superbee gradients, of velocities beside steps of the bed, too: narrower fronts and jets on coarse lattices, noise in smooth flow; for Eulerian particles alone",
        None = "none": "the values of the two particles; default with artificial viscosity",
    }
}

impl Stabilisation {
    /// The reconstruction that goes with it unless the scenario says otherwise.
    pub fn usual_reconstruction(self) -> Reconstruction {
        match self {
            Stabilisation::ArtificialViscosity => Reconstruction::None,
            Stabilisation::Hllc | Stabilisation::TwoShocks | Stabilisation::LaxFriedrichs => Reconstruction::Limited,
        }
    }
}

family! {
    /// How Lagrangian particles are placed in still water at the start.
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
        Quadratic = "quadratic": "parabola whose slope does not vanish at the middle: close particles go on repelling each other",
        QuarticSpline = "quartic_spline": "quartic B-spline",
        QuinticSpline = "quintic_spline": "quintic B-spline",
        Gauss = "gauss": "Gaussian, cut at three smoothing lengths of its own",
        SuperGauss = "super_gauss": "Gaussian times a parabola, of fourth order and negative outside; cut likewise",
        Bell = "bell": "Lucy's bell-shaped kernel",
        WendlandC2 = "wendland_c2": "Wendland's kernel of class C2",
        WendlandC4 = "wendland_c4": "Wendland's kernel of class C4",
    }
}

family! {
    /// How a riverbed particle gets its elevation from the terrain.
    BedMethod {
        #[default]
        Mean = "mean": "mean of all terrain in the cell of the particle, corrected to be exact for a plane; blocked buildings left out",
        Pointwise = "pointwise": "bilinear terrain elevation at the particle",
        Shepard = "shepard": "kernel mean of the terrain around the particle, corrected to be exact for a plane",
        MovingLeastSquares = "moving_least_squares": "quadratic that fits the terrain around the particle best",
    }
}

family! {
    /// How the slope of the bed acts on the variational formulation.
    BedSlope {
        #[default]
        Hydrostatic = "hydrostatic": "by the weight of the water alone: the shallow-water equations",
        Steep = "steep": "with the inertia of the vertical motion over a steep, curved bed; for the variational formulation",
    }
}

family! {
    /// What turbulence does to the flow in the plane.
    Turbulence {
        #[default]
        None = "none": "nothing: the shallow-water equations alone",
        MixingLength = "mixing_length": "an eddy viscosity of bed friction and of a mixing length of half the depth: where jets, wakes and jumps are many depths wide; for Eulerian particles alone",
    }
}

family! {
    /// What stands for a wall beside Lagrangian particles.
    WallMethod {
        #[default]
        Mirror = "mirror": "mirror images of the particle and its neighbours",
        VirtualParticles = "virtual_particles": "rows of fixed particles along the wall, in each of which a particle is mirrored through the point",
    }
}

family! {
    /// Time integration.
    Integrator {
        #[default]
        Heun = "heun": "two-stage strong-stability-preserving Runge-Kutta; default of Eulerian particles",
        Leapfrog = "leapfrog": "kick-drift-kick with predicted velocity; default of Lagrangian particles",
    }
}

family! {
    /// A named set of choices, of which single keys beside it change one each; docs/decisions/0010 has the figures behind them.
    Preset {
        #[default]
        Balanced = "balanced": "the defaults: Eulerian particles, slopes as sharp as the bed allows; nothing of the stability suite fails with them",
        Fast = "fast": "for dam-break waves on smooth ground and coarse lattices: sharp reconstruction, up to half of the error of depth of `balanced` at like time, none with friction or over thin water; 3 to 14 times the error in steady flow, noise in smooth flow; in long runs water that should rest makes waves by itself",
        Accurate = "accurate": "half the time step of `balanced` for twice its time: 4 to 13 % less error of depth in most dam breaks, a fifth on a slope with friction, nothing in bowls and over a bump",
    }
}

impl Preset {
    /// The keys of `numerics:` that it sets, with their values.
    pub fn keys(self) -> [(&'static str, &'static str); 6] {
        let (reconstruction, cfl) = match self {
            Preset::Balanced => (Reconstruction::Limited, "0.5"),
            Preset::Fast => (Reconstruction::Sharp, "0.5"),
            Preset::Accurate => (Reconstruction::Limited, "0.25"),
        };
        [
            ("formulation", Formulation::Balanced.name()),
            ("motion", Motion::Eulerian.name()),
            ("stabilisation", Stabilisation::Hllc.name()),
            ("reconstruction", reconstruction.name()),
            ("integrator", Integrator::Heun.name()),
            ("cfl", cfl),
        ]
    }
}
