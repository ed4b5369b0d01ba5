//! A dam as a ridge of the bed, and its breach: an opening that lowers the ridge in time (M46).
//!
//! With the share p(t) of the growth, from 0 at the trigger to 1 at its end, the opening at the station y along the line of the
//! dam is a trapezoid of the depth
//!
//! ```text
//! d_o(y, t) = max((z_k − z_i) p − max(|y − y_m| − B p/2, 0) / m, 0)
//! ```
//!
//! with the crest z_k, the invert z_i, the bottom width B, the slope m of the sides (horizontal to vertical) and the station y_m of
//! the middle. Where the whole dam goes, B is without bounds. It grows as in `Froehlich2008`. A dam cell that covers the stations
//! y_1 to y_2 opens so that as much water passes it as a broad crest of that shape, the water as high as the dam:
//!
//! ```text
//! z_b(t) = max(z_g, z_k − [∫ d_o(y, t)^(3/2) dy / (y_2 − y_1)]^(2/3))
//! ```
//!
//! with the ground z_g below the dam. Cells at the middle go down with the bottom, however narrow it is, so that the water comes when
//! it would and runs out as far as it would on every lattice.
//!
//! Beside the dam the shore of its lake may have raised the bed to z_s (`seeding/shore.rs`). That would be a sill before the opening, so
//! that it sinks with the dam, to the ground below:
//!
//! ```text
//! z_b(t) = max(z_g, min(z_s, z_b of the dam at its station))
//! ```

use super::Series;
use crate::math::Vec2;

/// A cell of a dam.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DamCell {
    /// Index of the cell on the lattice.
    pub cell: usize,
    /// Distance along the line of the dam from its start (m).
    pub station: f64,
    /// Half of the part of that line which the cell covers, seen across the line (m).
    pub reach: f64,
    /// The ground below the dam (m), at which the opening ends in any case.
    pub ground: f64,
}

/// A cell beside a dam whose bed the shore of the lake raised.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RimCell {
    /// The cell, with the dam at its station and the ground below what was raised.
    pub at: DamCell,
    /// Its bed while the dam stands (m).
    pub raised: f64,
}

/// When a breach begins.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
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
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
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
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Breach {
    /// The cells of the dam; their bed at the start is the crest.
    pub cells: Vec<DamCell>,
    /// The cells beside it whose bed sinks with it.
    pub rim: Vec<RimCell>,
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
    /// The cells of the dam and of its rim.
    pub fn cells_and_rim(&self) -> impl Iterator<Item = usize> + '_ {
        self.cells.iter().map(|dam| dam.cell).chain(self.rim.iter().map(|rim| rim.at.cell))
    }

    /// The share of the growth at the start of a run: above 0 where the dam opens at once then, and never stands as it was.
    pub fn share_at_start(&self) -> f64 {
        match self.trigger {
            Trigger::At(at) => self.share(-at),
            Trigger::Level { .. } => 0.0,
        }
    }

    /// Every cell whose bed changes, and its bed (m) at a share of the growth.
    pub fn beds(&self, share: f64) -> impl Iterator<Item = (usize, f64)> + '_ {
        let dam = self.cells.iter().map(move |cell| (cell.cell, self.bed(cell, share)));
        let beside = move |rim: &RimCell| {
            if share > 0.0 { self.bed(&rim.at, share).min(rim.raised).max(rim.at.ground) } else { rim.raised }
        };
        dam.chain(self.rim.iter().map(move |rim| (rim.at.cell, beside(rim))))
    }

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
                let off = (cell.station - middle).abs();
                let half_bottom = 0.5 * bottom_width * share;
                if off <= cell.reach || off + cell.reach <= half_bottom {
                    sunk(invert)
                } else {
                    let shape = (self.crest - sunk(invert), half_bottom, side_slope);
                    let mean = (passed(shape, off + cell.reach) - passed(shape, off - cell.reach)) / (2.0 * cell.reach);
                    self.crest - mean.max(0.0).powf(2.0 / 3.0)
                }
            }
        };
        opened.min(self.crest).max(cell.ground)
    }
}

/// ∫ D^(3/2) ds (m^(5/2)) from the middle of an opening of a depth (m), half of a bottom (m) and slopes of the sides to a station beside it (m).
fn passed((depth, half_bottom, side_slope): (f64, f64, f64), station: f64) -> f64 {
    let beside = (station.abs() - half_bottom).max(0.0);
    let sides = if side_slope > 0.0 {
        let below = (depth * side_slope - beside).max(0.0);
        0.4 * side_slope * (depth.powf(2.5) - (below / side_slope).powf(2.5))
    } else {
        0.0
    };
    station.signum() * (depth.powf(1.5) * station.abs().min(half_bottom) + sides)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn breach(opening: Opening, law: GrowthLaw) -> Breach {
        let cells = Vec::new();
        Breach { cells, rim: Vec::new(), crest: 110.0, trigger: Trigger::At(0.0), opening, law, duration: 100.0 }
    }

    const TRAPEZOID: Opening = Opening::Trapezoid { middle: 50.0, bottom_width: 20.0, side_slope: 0.5, invert: 100.0 };

    /// A cell 2 m wide about a station.
    fn at(station: f64) -> DamCell {
        DamCell { cell: 0, station, reach: 1.0, ground: 98.0 }
    }

    #[test]
    fn the_trapezoid_sinks_and_widens() {
        let breach = breach(TRAPEZOID, GrowthLaw::Linear);
        // Half way: bottom at 105 m, 10 m wide from 45 to 55 m, sides that rise by 2 m for each metre.
        for (station, share, bed) in [(50.0, 0.0, 110.0), (50.0, 0.5, 105.0), (54.0, 0.5, 105.0), (60.0, 0.5, 110.0)] {
            assert!((breach.bed(&at(station), share) - bed).abs() < 1e-12, "{station} m, share {share}");
        }
        for (station, bed) in [(50.0, 100.0), (41.0, 100.0), (30.0, 110.0)] {
            assert!((breach.bed(&at(station), 1.0) - bed).abs() < 1e-12, "{station} m");
        }
    }

    #[test]
    fn a_narrow_cell_has_the_bed_of_the_trapezoid_at_its_station() {
        let breach = breach(TRAPEZOID, GrowthLaw::Linear);
        let narrow = |station: f64| DamCell { reach: 1e-7, ..at(station) };
        for (station, share, bed) in
            [(54.9, 0.5, 105.0), (56.0, 0.5, 107.0), (40.0, 1.0, 100.0), (39.0, 1.0, 102.0), (35.5, 1.0, 109.0)]
        {
            let found = breach.bed(&narrow(station), share);
            assert!((found - bed).abs() < 1e-6, "{station} m, share {share}: {found}");
        }
    }

    #[test]
    fn as_much_water_passes_a_cell_as_the_part_of_the_opening_in_it() {
        // By many small strips.
        let passed = |from: f64, to: f64, share: f64| {
            let strips = 200_000;
            let width = (to - from) / f64::from(strips);
            let depth = |place: f64| {
                let beside = ((place - 50.0).abs() - 10.0 * share).max(0.0);
                (10.0 * share - beside / 0.5).max(0.0)
            };
            (0..strips).map(|k| depth(from + (f64::from(k) + 0.5) * width).powf(1.5) * width).sum::<f64>()
        };
        let breach = breach(TRAPEZOID, GrowthLaw::Linear);
        for reach in [1.0, 7.0] {
            for (station, share) in [(60.0, 1.0), (38.5, 1.0), (57.3, 0.5), (57.3, 0.05), (66.0, 1.0)] {
                let depth = breach.crest - breach.bed(&DamCell { reach, ..at(station) }, share);
                let expected = passed(station - reach, station + reach, share);
                let error = (2.0 * reach * depth.powf(1.5) - expected).abs();
                assert!(error < 1e-6 * (1.0 + expected), "{station} m, {reach} m, share {share}: {depth} m");
            }
        }
        let upright = Opening::Trapezoid { middle: 50.0, bottom_width: 20.0, side_slope: 0.0, invert: 100.0 };
        let breach = Breach { opening: upright, ..breach };
        // Half of the cell is open.
        let depth = breach.crest - breach.bed(&at(60.0), 1.0);
        assert!((depth.powf(1.5) - 0.5 * 10.0_f64.powf(1.5)).abs() < 1e-9, "{depth} m");
    }

    #[test]
    fn the_cell_at_the_middle_goes_down_with_the_bottom_wherever_it_lies() {
        let breach = breach(TRAPEZOID, GrowthLaw::Linear);
        for off in [0.0, -8.0, 29.0, 30.0] {
            let cell = DamCell { reach: 30.0, ..at(50.0 + off) };
            for (share, bed) in [(0.01, 109.9), (0.5, 105.0), (1.0, 100.0)] {
                assert!((breach.bed(&cell, share) - bed).abs() < 1e-12, "{off} m, share {share}");
            }
        }
        let beside = DamCell { reach: 30.0, ..at(81.0) };
        assert!(breach.bed(&beside, 1.0) > 105.0);
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
    fn what_the_shore_raised_beside_a_dam_is_never_a_sill_before_its_opening() {
        let rim = |station: f64| RimCell { at: at(station), raised: 106.0 };
        let breach = Breach { rim: vec![rim(50.0), rim(20.0)], ..breach(TRAPEZOID, GrowthLaw::Linear) };
        for (share, middle) in [(0.0, 106.0), (0.2, 106.0), (0.4, 106.0), (0.5, 105.0), (1.0, 100.0)] {
            let beds: Vec<f64> = breach.beds(share).map(|(_, bed)| bed).collect();
            assert!((beds[0] - middle).abs() < 1e-12 && (beds[1] - 106.0).abs() < 1e-12, "share {share}: {beds:?}");
        }
        let whole = Breach { opening: Opening::Whole, ..breach };
        assert!(whole.beds(1.0).all(|(_, bed)| bed.to_bits() == at(0.0).ground.to_bits()));
    }

    #[test]
    fn a_dam_stands_at_the_start_unless_it_opens_at_once_then() {
        let at = |seconds: f64, law: GrowthLaw| Breach { trigger: Trigger::At(seconds), ..breach(Opening::Whole, law) };
        let level = Trigger::Level { level: 105.0, place: Vec2::ZERO };
        assert!((at(0.0, GrowthLaw::Instantaneous).share_at_start() - 1.0).abs() <= 0.0);
        let waits = Breach { trigger: level, ..breach(Opening::Whole, GrowthLaw::Instantaneous) };
        for breach in [at(0.0, GrowthLaw::Sine), at(1e-9, GrowthLaw::Instantaneous), waits] {
            assert!(breach.share_at_start().abs() <= 0.0);
        }
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
