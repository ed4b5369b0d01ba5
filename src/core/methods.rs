//! The registry of methods: every family as an enum whose members have a name, a sentence, and the cores that have them.
//!
//! The scenario parser, the help, the schema, the suites and the records read these lists; a new method is one file and one line here.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The cores: formulations with their motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Core {
    /// Eulerian particles of the balanced formulation.
    Eulerian,
    /// Lagrangian particles of the balanced formulation.
    Lagrangian,
    /// The variational formulation, whose particles are Lagrangian.
    Variational,
}

use Core::{Eulerian, Lagrangian, Variational};

impl Core {
    /// Every core.
    pub const ALL: &'static [Core] = &[Eulerian, Lagrangian, Variational];

    /// Its particles, in a sentence.
    pub fn particles(self) -> &'static str {
        match self {
            Eulerian => "Eulerian particles",
            Lagrangian => "Lagrangian particles",
            Variational => "particles of the variational formulation",
        }
    }

    /// The keys and their values by which a scenario asks for it.
    pub fn asked_for_by(self) -> &'static str {
        match self {
            Eulerian => "formulation: balanced, motion: eulerian",
            Lagrangian => "formulation: balanced, motion: lagrangian",
            Variational => "formulation: variational, motion: lagrangian",
        }
    }

    /// The core of a formulation and a motion.
    pub fn of(formulation: Formulation, motion: Motion) -> Core {
        match (formulation, motion) {
            (Formulation::Variational, _) => Variational,
            (Formulation::Balanced, Motion::Lagrangian) => Lagrangian,
            (Formulation::Balanced, Motion::Eulerian) => Eulerian,
        }
    }

    /// The stabilisation that it has unless the scenario says otherwise.
    pub fn usual_stabilisation(self) -> Stabilisation {
        match self {
            Eulerian | Lagrangian => Stabilisation::TwoRarefactions,
            Variational => Stabilisation::ArtificialViscosity,
        }
    }

    /// The time integration and the Courant number that it has unless the scenario says otherwise.
    pub fn usual_integration(self) -> (Integrator, f64) {
        match self {
            Eulerian | Lagrangian => (Integrator::Heun, 0.5),
            Variational => (Integrator::Leapfrog, 0.4),
        }
    }
}

/// One of a family of methods.
pub trait Method: Copy {
    /// The cores that have it.
    fn cores(self) -> &'static [Core];

    /// Why the other cores do not have it; empty where all do.
    fn why_not_elsewhere(self) -> &'static str;

    /// Whether a core has it.
    fn is_in(&self, core: Core) -> bool {
        self.cores().contains(&core)
    }
}

/// What only the balanced formulation has, for both motions.
const BALANCED: &[Core] = &[Eulerian, Lagrangian];
/// What only sums over kernels have.
const CLASSIC: &[Core] = &[Variational];
const NO_KERNEL: &str = "the faces of the balanced formulation are those of its cells, without any kernel";
const STATE_BETWEEN_WAVES: &str = "the faces of the balanced formulation lie in the middle of the waves, and it gives the state between the waves only";
const FACES: &str = "pairs of particles have no face through which water passes";

macro_rules! family {
    ($(#[$doc:meta])* $family:ident {
        $($(#[$default:meta])* $member:ident = $name:literal $((in $cores:expr, since $why:expr))? : $summary:literal,)+
    }) => {
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

        impl Method for $family {
            fn cores(self) -> &'static [Core] {
                match self { $($family::$member => either!($($cores)?; Core::ALL),)+ }
            }

            fn why_not_elsewhere(self) -> &'static str {
                match self { $($family::$member => either!($($why)?; ""),)+ }
            }
        }
    };
}

/// The first of two, where there is one.
macro_rules! either {
    (; $otherwise:expr) => {
        $otherwise
    };
    ($given:expr; $otherwise:expr) => {
        $given
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
        Eulerian = "eulerian" (in &[Eulerian], since "the variational formulation sums its depth over particles that move"): "riverbed particles carry the water and exchange it through their faces",
        Lagrangian = "lagrangian" (in &[Lagrangian, Variational], since ""): "fluid particles move with the water: cells that exchange what moves through their faces, or, in the variational formulation, particles of fixed volume",
    }
}

family! {
    /// What keeps the flow between a pair of particles stable.
    Stabilisation {
        #[default]
        TwoRarefactions = "two_rarefactions" (in BALANCED, since FACES): "state of the rarefaction that the face lies in, exact beside dry ground, mixed with the flux of Harten, Lax and van Leer at shocks; default of the balanced formulation",
        TwoShocks = "two_shocks" (in CLASSIC, since STATE_BETWEEN_WAVES): "Riemann solver with two shocks or two rarefactions",
        TwoWaves = "two_waves" (in CLASSIC, since STATE_BETWEEN_WAVES): "pressure and velocity between two waves at the speeds that Toro gives for HLLC",
        LaxFriedrichs = "lax_friedrichs": "Lax-Friedrichs flux with the greatest speed of the pair",
        ArtificialViscosity = "artificial_viscosity" (in &[Variational], since "the pairs of the balanced formulation are Riemann problems"): "viscosity between particles that approach each other; default of the variational formulation, and for it alone",
    }
}

family! {
    /// The states on both sides of the face between a pair of particles.
    Reconstruction {
        #[default]
        Limited = "limited": "levels, depths and normal velocities carried to the face along gradients that a limiter bounds",
        Sharp = "sharp" (in BALANCED, since "the pairs of the variational formulation have no sharper limiter"): "superbee gradients, of velocities beside steps of the bed, too: narrower fronts and jets on coarse lattices, noise in smooth flow; for the balanced formulation alone",
        None = "none": "the values of the two particles; default with artificial viscosity",
    }
}

impl Formulation {
    /// The motion that it has unless the scenario says otherwise.
    pub fn usual_motion(self) -> Motion {
        if self == Formulation::Variational { Motion::Lagrangian } else { Motion::default() }
    }
}

impl Formulation {
    /// The kernel unless the scenario says otherwise. Particles under a kernel of Wendland do not pair.
    pub fn usual_kernel(self) -> Kernel {
        match self {
            Formulation::Balanced => Kernel::default(),
            Formulation::Variational => Kernel::WendlandC2,
        }
    }
}

impl Stabilisation {
    /// The reconstruction that goes with it unless the scenario says otherwise.
    pub fn usual_reconstruction(self) -> Reconstruction {
        match self {
            Stabilisation::ArtificialViscosity => Reconstruction::None,
            _ => Reconstruction::Limited,
        }
    }
}

family! {
    /// How particles are placed in still water at the start.
    Seeding {
        #[default]
        Lattice = "lattice": "one particle at the centre of each wet cell, with the volume of its water",
        EqualVolume = "equal_volume" (in CLASSIC, since "each particle of the balanced formulation starts as one cell, as deep as the water there"): "particles of one volume, the mean of the wet cells; closer together where the water is deep",
    }
}

family! {
    /// The smoothing kernel.
    Kernel {
        #[default]
        CubicSpline = "cubic_spline": "cubic B-spline, support two smoothing lengths",
        Quadratic = "quadratic" (in CLASSIC, since NO_KERNEL): "parabola whose slope does not vanish at the middle: close particles go on repelling each other",
        QuarticSpline = "quartic_spline" (in CLASSIC, since NO_KERNEL): "quartic B-spline",
        QuinticSpline = "quintic_spline" (in CLASSIC, since NO_KERNEL): "quintic B-spline",
        Gauss = "gauss" (in CLASSIC, since NO_KERNEL): "Gaussian, cut at three smoothing lengths of its own",
        SuperGauss = "super_gauss" (in CLASSIC, since NO_KERNEL): "Gaussian times a parabola, of fourth order and negative outside; cut likewise",
        Bell = "bell" (in CLASSIC, since NO_KERNEL): "Lucy's bell-shaped kernel",
        WendlandC2 = "wendland_c2" (in CLASSIC, since NO_KERNEL): "Wendland's kernel of class C2",
        WendlandC4 = "wendland_c4" (in CLASSIC, since NO_KERNEL): "Wendland's kernel of class C4",
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
        Steep = "steep" (in &[Variational], since "the faces of the balanced formulation balance a hydrostatic pressure"): "with the inertia of the vertical motion over a steep, curved bed; for the variational formulation",
    }
}

family! {
    /// What turbulence does to the flow in the plane.
    Turbulence {
        #[default]
        None = "none": "nothing: the shallow-water equations alone",
        MixingLength = "mixing_length" (in &[Eulerian], since "it was measured on cells at rest alone"): "an eddy viscosity of bed friction and of a mixing length of half the depth: where jets, wakes and jumps are many depths wide; for Eulerian particles alone",
    }
}

family! {
    /// What stands for a wall beside particles.
    WallMethod {
        #[default]
        Mirror = "mirror": "mirror images of the particle and its neighbours",
        VirtualParticles = "virtual_particles" (in CLASSIC, since "the faces of the balanced formulation at a wall are those of the mirror problem"): "rows of fixed particles along the wall, in each of which a particle is mirrored through the point",
    }
}

family! {
    /// Time integration.
    Integrator {
        #[default]
        Heun = "heun": "two-stage strong-stability-preserving Runge-Kutta; default of the balanced formulation",
        Leapfrog = "leapfrog" (in CLASSIC, since "the faces of the balanced formulation are upwinded, which leapfrog makes unstable"): "kick-drift-kick with predicted velocity; default of the variational formulation",
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
    /// The keys of `numerics:` that it sets, with their values; stabilisation and integrator are the usual ones of the core.
    pub fn keys(self) -> [(&'static str, &'static str); 4] {
        let (reconstruction, cfl) = match self {
            Preset::Balanced => (Reconstruction::Limited, "0.5"),
            Preset::Fast => (Reconstruction::Sharp, "0.5"),
            Preset::Accurate => (Reconstruction::Limited, "0.25"),
        };
        [
            ("formulation", Formulation::Balanced.name()),
            ("motion", Motion::Eulerian.name()),
            ("reconstruction", reconstruction.name()),
            ("cfl", cfl),
        ]
    }
}
