//! A dam as a ridge of the bed, and its breach: an opening that lowers the ridge in time (M46).
//!
//! With the share p(t) of the growth, from 0 at the trigger to 1 at its end, the bed of a dam cell at the station s along the
//! line of the dam is
//!
//! ```text
//! z_b(s, t) = max(z_g, min(z_c, z_i(t) + max(|s − s_m| − B p/2, 0) / m))        z_i(t) = z_c − (z_c − z_i) p
//! ```
//!
//! with the ground z_g below the dam, the crest z_c, the invert z_i, the bottom width B, the slope m of the sides (horizontal to
//! vertical) and the station s_m of the middle. Where the whole dam goes, B is without bounds. It grows as in `Froehlich2008`.

use super::Series;
use crate::math::Vec2;

/// A cell of a dam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DamCell {
    /// Index of the cell on the lattice.
    pub cell: usize,
    /// Distance along the line of the dam from its start (m).
    pub station: f64,
    /// The ground below the dam (m), at which the opening ends in any case.
    pub ground: f64,
}

/// When a breach begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trigger {
    /// At a time (s).
    At(f64),
    /// When the water at a place first reaches a level.
    Level {
        /// The level (m).
        level: f64,
        /// The place, in local coordinates (m).
        place: Vec2,
    },
}

/// What of the dam goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Opening {
    /// All of it, down to the ground.
    Whole,
    /// A trapezoid in the long profile of the dam.
    Trapezoid {
        /// Station of its middle (m).
        middle: f64,
        /// Final width of its bottom (m).
        bottom_width: f64,
        /// Slope of its sides, horizontal to vertical; 0 for vertical ones.
        side_slope: f64,
        /// Final level of its bottom (m).
        invert: f64,
    },
}

/// How the share of the growth depends on the time since the trigger.
#[derive(Clone, Debug, PartialEq)]
pub enum GrowthLaw {
    /// All at once.
    Instantaneous,
    /// p = τ, the time over the duration.
    Linear,
    /// p = (1 − cos π τ)/2: slow at the beginning and at the end.
    Sine,
    /// As measured or computed elsewhere: p over the seconds since the trigger, which rises from 0 to 1.
    Series(Series),
}

/// A dam and its breach.
#[derive(Clone, Debug, PartialEq)]
pub struct Breach {
    /// The cells of the dam; their bed at the start is the crest.
    pub cells: Vec<DamCell>,
    /// Level of the crest (m).
    pub crest: f64,
    /// When it begins.
    pub trigger: Trigger,
    /// What goes.
    pub opening: Opening,
    /// How it grows.
    pub law: GrowthLaw,
    /// How long it grows (s, positive); of no effect where it opens at once.
    pub duration: f64,
}

impl Breach {
    /// The share of the growth, 0 to 1, at a time (s) since the trigger; 0 before it.
    pub fn share(&self, since: f64) -> f64 {
        if since < 0.0 {
            return 0.0;
        }
        let part = (since / self.duration).min(1.0);
        match &self.law {
            GrowthLaw::Instantaneous => 1.0,
            GrowthLaw::Linear => part,
            // The end is met to the last bit, so that the final bed is that of the trapezoid.
            GrowthLaw::Sine if part >= 1.0 => 1.0,
            GrowthLaw::Series(series) => series.at(since),
            GrowthLaw::Sine => 0.5 - 0.5 * (std::f64::consts::PI * part).cos(),
        }
    }

    /// The bed (m) of a dam cell at a share of the growth; the crest, or the ground where that is higher, at a share of 0.
    pub fn bed(&self, cell: &DamCell, share: f64) -> f64 {
        if share <= 0.0 {
            return self.crest.max(cell.ground);
        }
        let sunk = |invert: f64| if share >= 1.0 { invert } else { self.crest - (self.crest - invert) * share };
        let opened = match self.opening {
            Opening::Whole => sunk(cell.ground),
            Opening::Trapezoid { middle, bottom_width, side_slope, invert } => {
                let beside = (cell.station - middle).abs() - 0.5 * bottom_width * share;
                if beside <= 0.0 {
                    sunk(invert)
                } else if side_slope > 0.0 {
                    sunk(invert) + beside / side_slope
                } else {
                    self.crest
                }
            }
        };
        opened.min(self.crest).max(cell.ground)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn breach(opening: Opening, law: GrowthLaw) -> Breach {
        Breach { cells: Vec::new(), crest: 110.0, trigger: Trigger::At(0.0), opening, law, duration: 100.0 }
    }

    const TRAPEZOID: Opening = Opening::Trapezoid { middle: 50.0, bottom_width: 20.0, side_slope: 0.5, invert: 100.0 };

    fn at(station: f64) -> DamCell {
        DamCell { cell: 0, station, ground: 98.0 }
    }

    #[test]
    fn the_trapezoid_sinks_and_widens() {
        let breach = breach(TRAPEZOID, GrowthLaw::Linear);
        // Half way: bottom at 105 m, 10 m wide, sides rise by 2 m for each metre.
        for (station, share, bed) in
            [(50.0, 0.0, 110.0), (50.0, 0.5, 105.0), (54.9, 0.5, 105.0), (56.0, 0.5, 107.0), (60.0, 0.5, 110.0)]
        {
            assert!((breach.bed(&at(station), share) - bed).abs() < 1e-12, "{station} m, share {share}");
        }
        for (station, bed) in [(50.0, 100.0), (40.0, 100.0), (39.0, 102.0), (35.5, 109.0), (30.0, 110.0)] {
            assert!((breach.bed(&at(station), 1.0) - bed).abs() < 1e-12, "{station} m");
        }
    }

    #[test]
    fn nothing_sinks_below_the_ground_and_high_ground_stays() {
        let breach = breach(TRAPEZOID, GrowthLaw::Linear);
        let high = DamCell { ground: 104.0, ..at(50.0) };
        assert!((breach.bed(&high, 1.0) - 104.0).abs() <= 0.0);
        let hill = DamCell { ground: 120.0, ..at(50.0) };
        assert!((breach.bed(&hill, 0.0) - 120.0).abs() <= 0.0 && (breach.bed(&hill, 1.0) - 120.0).abs() <= 0.0);
    }

    #[test]
    fn the_laws_begin_at_0_and_end_at_1() {
        let share = |law: &GrowthLaw, since: f64| breach(Opening::Whole, law.clone()).share(since);
        for law in &[GrowthLaw::Linear, GrowthLaw::Sine] {
            assert!(share(law, -1.0).abs() <= 0.0 && share(law, 0.0).abs() <= 0.0);
            assert!((share(law, 50.0) - 0.5).abs() < 1e-15);
            assert!((share(law, 100.0) - 1.0).abs() <= 0.0 && (share(law, 1e9) - 1.0).abs() <= 0.0);
        }
        assert!((share(&GrowthLaw::Linear, 25.0) - 0.25).abs() < 1e-15);
        assert!((share(&GrowthLaw::Sine, 25.0) - (0.5 - 0.125_f64.sqrt())).abs() < 1e-15);
        assert!(share(&GrowthLaw::Instantaneous, -1e-9).abs() <= 0.0);
        assert!((share(&GrowthLaw::Instantaneous, 0.0) - 1.0).abs() <= 0.0);
    }

    #[test]
    fn a_series_is_followed_from_the_trigger_on() {
        let series = Series::new(&[(0.0, 0.0), (40.0, 0.2), (60.0, 0.2), (100.0, 1.0)]).unwrap();
        let breach = breach(TRAPEZOID, GrowthLaw::Series(series));
        for (since, share) in [(-5.0, 0.0), (0.0, 0.0), (20.0, 0.1), (50.0, 0.2), (80.0, 0.6)] {
            assert!((breach.share(since) - share).abs() < 1e-15, "{since}");
        }
        assert!((breach.share(100.0) - 1.0).abs() <= 0.0 && (breach.share(1e6) - 1.0).abs() <= 0.0);
    }

    #[test]
    fn a_whole_dam_goes_down_to_the_ground_bit_by_bit() {
        let cell = DamCell { ground: 98.123_456_789, ..at(3.0) };
        assert_eq!(breach(Opening::Whole, GrowthLaw::Instantaneous).bed(&cell, 1.0).to_bits(), cell.ground.to_bits());
    }
}
