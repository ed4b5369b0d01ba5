//! How the particles on the two sides of a general face meet, and what passes then.

use super::super::faces::{Half, Numbers, Sill, TOGETHER, Together, over_sill};
use super::super::{EulerianMethods, Scale};

/// What passes a face: volume, tangential momentum, normal momentum lost by the first side and gained by the second, per metre.
#[derive(Clone, Copy, Debug, Default)]
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

    /// Takes the flux of a pair: F_d, F_d v_t, and normal momentum lost and gained beside what is there already.
    pub fn take(&mut self, (mass, tangential, lost, gained): (f64, f64, f64, f64)) {
        *self = Passing { mass, tangential, lost: lost + self.lost, gained: gained + self.gained };
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
        /// What counts from the particles' own levels: (M89), (M99).
        own: [f64; 2],
    },
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
            Meeting::Pair { halves: [i, j], way, sill, own: [lost, gained] } if sill > i.z && sill > j.z => {
                let numbers = Numbers::new(&scale.on(way), methods);
                let found = over_sill(i, j, Sill { level: sill, lowest: sill }, numbers, methods);
                *passing = Passing { lost, gained, ..Passing::default() };
                passing.take(found);
            }
            Meeting::Pair { halves, way, own: [lost, gained], .. } => {
                *passing = Passing { lost, gained, ..Passing::default() };
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
