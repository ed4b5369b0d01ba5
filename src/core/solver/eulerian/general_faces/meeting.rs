//! How the particles on the two sides of a general face meet, and what passes then.

use super::super::faces::{Half, Numbers, Sill, TOGETHER, Together, over_sill};
use super::super::{EulerianMethods, Scale};

/// What passes a face: volume, tangential momentum, normal momentum lost by the first side and gained by the second, per metre.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(in super::super) struct Passing {
    pub mass: f64,
    pub tangential: f64,
    pub lost: f64,
    pub gained: f64,
}

impl Passing {
    /// Takes a share of the water, and of the momentum that goes with it.
    pub fn reduce(&mut self, share: f64) {
        self.mass *= share;
        self.tangential *= share;
    }

    /// Takes the flux of a pair: F_d, F_d v_t, and normal momentum lost and gained, beside what is there already.
    pub fn take(&mut self, (mass, tangential, lost, gained): (f64, f64, f64, f64)) {
        self.add(1.0, &Passing { mass, tangential, lost, gained });
    }

    /// Adds so many times another.
    pub fn add(&mut self, times: f64, other: &Passing) {
        self.mass += times * other.mass;
        self.tangential += times * other.tangential;
        self.lost += times * other.lost;
        self.gained += times * other.gained;
    }
}

/// What is known of a face before its flux.
#[expect(clippy::large_enum_variant, reason = "most are pairs, and none is kept")]
pub(in super::super) enum Meeting {
    /// Nothing flows: films, or a wall that pushes back.
    Apart(Passing),
    /// One pair of (M19) to (M31).
    Pair {
        /// The particles on the first and the second side.
        halves: [Half; 2],
        /// Their distance along the normal (m).
        way: f64,
        /// Level (m) of a sill on the way; minus infinity where there is none.
        sill: f64,
        /// What passes besides: the brackets from the particles' own levels (M89), (M99), and the stress (M36).
        besides: Passing,
    },
}

impl Meeting {
    /// A pair, given what counts from the particles' own levels, and the stress on both (normal, tangential) where there is no sill.
    pub fn pair(
        halves: [Half; 2],
        way: f64,
        sill: f64,
        [lost, gained]: [f64; 2],
        stress: impl FnOnce(&[Half; 2]) -> [f64; 2],
    ) -> Self {
        let [normal, tangential] = if is_over(sill, &halves) { [0.0; 2] } else { stress(&halves) };
        let besides = Passing { mass: 0.0, tangential, lost: lost + normal, gained: gained + normal };
        Meeting::Pair { halves, way, sill, besides }
    }
}

/// Whether a sill stands above the beds of both particles.
fn is_over(sill: f64, [i, j]: &[Half; 2]) -> bool {
    sill > i.z && sill > j.z
}

/// Finds what passes some faces, all pairs without a sill together.
pub(in super::super) fn pass<'a>(
    faces: impl Iterator<Item = (Meeting, &'a mut Passing)>,
    scale: &Scale,
    methods: EulerianMethods,
) {
    let mut together = Together::new(scale, methods);
    let mut waiting: [Option<&'a mut Passing>; TOGETHER] = std::array::from_fn(|_| None);
    for (meeting, passing) in faces {
        match meeting {
            Meeting::Apart(all) => *passing = all,
            Meeting::Pair { halves, way, sill, besides } if is_over(sill, &halves) => {
                let (numbers, [i, j]) = (Numbers::new(&scale.on(way), methods), halves);
                let found = over_sill(i, j, Sill { level: sill, lowest: sill }, numbers, methods);
                *passing = besides;
                passing.take(found);
            }
            Meeting::Pair { halves, way, besides, .. } => {
                *passing = besides;
                waiting[together.count()] = Some(passing);
                together.add(halves, way);
                if together.count() == TOGETHER {
                    hand_out(&mut together, &mut waiting);
                }
            }
        }
    }
    hand_out(&mut together, &mut waiting);
}

/// Hands the fluxes of all pairs that are together to those who wait for them.
fn hand_out(together: &mut Together, waiting: &mut [Option<&mut Passing>; TOGETHER]) {
    let fluxes = together.take();
    for (k, passing) in waiting.iter_mut().map_while(Option::take).enumerate() {
        passing.take((fluxes.mass[k], fluxes.tangential[k], fluxes.lost[k], fluxes.gained[k]));
    }
}
