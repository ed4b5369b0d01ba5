//! Pairs that are no neighbours in the rows, so many at once as loops on lanes take them.

use super::{EulerianMethods, Flux, Half, LaxFriedrichs, Numbers, Scale, Sill, TwoRarefactions, pair};
use crate::math::MOST_LANES;
use crate::methods::{Reconstruction, Stabilisation};

/// Pairs that are taken at once.
pub(crate) const TOGETHER: usize = 4 * MOST_LANES;

/// One number of each pair.
type Many = [f64; TOGETHER];

/// Pairs whose fluxes are to be found.
pub(crate) struct Together {
    scale: Scale,
    methods: EulerianMethods,
    sides: [Halves; 2],
    per_fall: Many,
    count: usize,
}

/// F_d, F_d v_t, and normal momentum lost by the first, gained by the second particle of each pair.
pub(crate) struct Fluxes {
    pub mass: Many,
    pub tangential: Many,
    pub lost: Many,
    pub gained: Many,
}

macro_rules! halves {
    ($($field:ident)+) => {
        /// The particles on one side of the pairs, quantity by quantity.
        struct Halves { $($field: Many,)+ }

        /// The first of them.
        struct First<'a> { $($field: &'a [f64],)+ }

        impl Halves {
            const NONE: Halves = Halves { $($field: [0.0; TOGETHER],)+ };

            fn set(&mut self, k: usize, half: Half) {
                $(self.$field[k] = half.$field;)+
            }

            #[inline(always)]
            fn first(&self, count: usize) -> First<'_> {
                First { $($field: &self.$field[..count],)+ }
            }
        }

        impl First<'_> {
            #[inline(always)]
            fn at(&self, k: usize) -> Half {
                Half { $($field: self.$field[k],)+ }
            }
        }
    };
}

halves!(d z step u v_t rise_eta rise_d rise_u rise_t stretch_t reach on_bank);

impl Together {
    /// None yet.
    pub fn new(scale: &Scale, methods: EulerianMethods) -> Self {
        Together { scale: *scale, methods, sides: [Halves::NONE; 2], per_fall: [0.0; TOGETHER], count: 0 }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Adds a pair at a distance (m); there is room for [`TOGETHER`].
    pub fn add(&mut self, halves: [Half; 2], way: f64) {
        self.sides.iter_mut().zip(halves).for_each(|(side, half)| side.set(self.count, half));
        self.per_fall[self.count] = Numbers::new(&self.scale.on(way), self.methods).per_fall;
        self.count += 1;
    }

    /// The fluxes of all, in the order in which they were added; none is left.
    pub fn take(&mut self) -> Fluxes {
        let (methods, numbers) = (self.methods, Numbers::new(&self.scale, self.methods));
        let none = [0.0; TOGETHER];
        let mut fluxes = Fluxes { mass: none, tangential: none, lost: none, gained: none };
        match (methods.flux, methods.reconstruction == Reconstruction::Sharp) {
            (Stabilisation::LaxFriedrichs, false) => find::<LaxFriedrichs, false>(self, numbers, &mut fluxes),
            (Stabilisation::LaxFriedrichs, true) => find::<LaxFriedrichs, true>(self, numbers, &mut fluxes),
            (_, false) => find::<TwoRarefactions, false>(self, numbers, &mut fluxes),
            (_, true) => find::<TwoRarefactions, true>(self, numbers, &mut fluxes),
        }
        self.count = 0;
        fluxes
    }
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn find<F: Flux, const IS_SHARP: bool>(pairs: &Together, numbers: Numbers, out: &mut Fluxes) {
    // Whole pieces: behind the last pair stands what an earlier one left, and is computed for nothing.
    let count = pairs.count.next_multiple_of(MOST_LANES);
    let [left, right] = &pairs.sides;
    let (left, right, per_fall) = (left.first(count), right.first(count), &pairs.per_fall[..count]);
    let (mass, tangential) = (&mut out.mass[..count], &mut out.tangential[..count]);
    let (lost, gained) = (&mut out.lost[..count], &mut out.gained[..count]);
    for k in 0..count {
        let numbers = Numbers { per_fall: per_fall[k], ..numbers };
        let passing = pair::<F, IS_SHARP, false>(left.at(k), right.at(k), numbers, Sill::NONE);
        mass[k] = passing.0;
        tangential[k] = passing.1;
        lost[k] = passing.2;
        gained[k] = passing.3;
    }
}
