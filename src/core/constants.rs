//! Constants of the methods: the numbers that somebody set, each with its unit, its source, the range in which it is sensible, and what
//! breaks outside of that.
//!
//! A number stands here when it was set by hand and another value gives another result. These do not:
//!
//! - guards against rounding, counts of iterations of solves that end at rounding, and points of an integral
//! - sizes of blocks and lanes, and bounds of cost, by which no run gets another answer
//! - constants of physics, such as that of von Kármán
//! - numbers that follow from a derivation, the exponents of a weight, which are its form, and numbers of cells by which a method is
//!   defined, such as the nine about a cell or the two of a gap
//! - thresholds of checks and warnings: they change what is said and not what is computed
//!
//! The values travel with the methods of a run. Files know no key for them. `docs/validation/sensitivity.md` says what a tenth less and a
//! tenth more does; a test varies each one.

/// One of the constants, for tests and tables that vary it.
#[derive(Clone, Copy, Debug)]
pub struct Constant {
    /// Its group and its name: `bed.least_step`.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Its unit; a dash where it is a ratio.
    pub unit: &'static str,
    /// Where its value comes from.
    pub source: &'static str,
    /// The least and the greatest sensible value.
    pub range: (f64, f64),
    /// What breaks outside of the range.
    pub outside: &'static str,
    /// Whether it is a whole number.
    pub is_whole: bool,
    get: fn(&Constants) -> f64,
    set: fn(&mut Constants, f64),
}

impl Constant {
    /// Its value among some constants.
    pub fn of(&self, constants: &Constants) -> f64 {
        (self.get)(constants)
    }

    /// The constants of the methods but for this one, which is so many times its value; a whole number moves by one at least.
    pub fn times(&self, factor: f64) -> Constants {
        let mut constants = Constants::DEFAULT;
        let value = self.of(&constants);
        let other = if self.is_whole {
            value + (factor - 1.0).signum() * ((factor - 1.0).abs() * value).round().max(1.0)
        } else {
            factor * value
        };
        (self.set)(&mut constants, other);
        constants
    }
}

/// A kind of number.
trait Number: Copy {
    const IS_WHOLE: bool;
    fn value(self) -> f64;
    fn of(value: f64) -> Self;
}

impl Number for f64 {
    const IS_WHOLE: bool = false;

    fn value(self) -> f64 {
        self
    }

    fn of(value: f64) -> Self {
        value
    }
}

impl Number for usize {
    const IS_WHOLE: bool = true;

    fn value(self) -> f64 {
        self as f64
    }

    fn of(value: f64) -> Self {
        value.round() as usize
    }
}

macro_rules! constants {
    ($(#[$doc:meta])* $group:ident in $place:ident {
        $($name:ident: $kind:ident = $value:expr, $unit:literal, $low:literal to $high:literal;
            what $what:literal; source $source:literal; outside $outside:literal;)+
    }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $group {
            $(
                #[doc = concat!($what, " (", $unit, ", ", $low, " to ", $high, ").")]
                #[doc = ""]
                #[doc = concat!("Source: ", $source, ". Outside of the range: ", $outside, ".")]
                pub $name: $kind,
            )+
        }

        impl $group {
            /// The values of the methods as they are described.
            pub const DEFAULT: $group = $group { $($name: $value),+ };

            /// Every one of them.
            pub const ALL: &'static [Constant] = &[$(
                Constant {
                    name: concat!(stringify!($place), ".", stringify!($name)),
                    what: $what,
                    unit: $unit,
                    source: $source,
                    range: ($low as f64, $high as f64),
                    outside: $outside,
                    is_whole: <$kind as Number>::IS_WHOLE,
                    get: |constants| Number::value(constants.$place.$name),
                    set: |constants, value| constants.$place.$name = Number::of(value),
                }
            ),+];
        }

        impl Default for $group {
            fn default() -> Self {
                Self::DEFAULT
            }
        }
    };
}

constants! {
    /// Constants of the faces, walls and boundaries of Eulerian particles.
    EulerianConstants in eulerian {
        pressed_kappa: f64 = 1.0 / 3.0, "–", 0 to 0.5;
            what "κ of the slope of the velocity along a pair where water is pressed together";
            source "`VanLeer1985`: 1/3 is of third order in smooth flow";
            outside "below 0 bores widen; towards 1 the slope is that across the face alone, and smooth flow turns into steps";
        shear_mixing: f64 = 0.5, "–", 0.3 to 1;
            what "share of the compression along a face by which its tangential flux mixes (M32)";
            source "the dissipation ½ |λ| of an upwind flux, with the compression for the wave speed (`SandersMoranoDruguet1998`)";
            outside "below, strong jumps along the lattice bend; above, circular fronts blunt";
        fall_fade: f64 = 2.0, "–", 1 to 3;
            what "depth below a fall over that above it at which the weight on the step is gone; it fades from one less on (M24)";
            source "a step is a fall up to equal depth, and a shore from twice the depth on (decision 0046)";
            outside "at 1 drops lie nearer to uniform flow, and falls into water of equal depth lose their weight; above, films on a shore that falls dry are driven outwards";
        fall_height: f64 = 1.0, "spacings", 0.5 to 2;
            what "height of a fall at which half of the weight on its step is left (M24)";
            source "one spacing: a step that is higher than the cell is long is a cliff, down which water does not run";
            outside "at half, drops lie nearer to uniform flow and a levee as near to a weir; above, water is held up before drops";
        stair_reach: usize = 8, "faces", 4 to 16;
            what "faces along a wall to either side among which a step makes it a stair";
            source "the flattest wall that is still a stair has one step in twice as many faces: 4° (decision 0032)";
            outside "below, walls at small angles hold water up as saws do; above, straight walls with a distant step are stairs";
        aperture_widest: f64 = 2.0, "–", 1.5 to 3;
            what "the most that a face beside a stair counts (M30)";
            source "without it the last face of a tread counts 1/(2 tan 10°) = 2.8 at 10°, and shortens the step (decision 0033)";
            outside "below, water cannot leave the last cell of a tread; above, the step must be shortened";
        aperture_faces: usize = 5, "faces", 3 to 8;
            what "fewest faces through which the line of a wall is laid";
            source "the face and two on each side, so that a step alone gives no line";
            outside "below, corners of houses become slopes; above, short walls oblique to the lattice stay saws";
        aperture_distance: f64 = 0.65, "cells", 0.5 to 1;
            what "farthest that a face may lie from the line that it stands for";
            source "the stair of a straight line lies within half a cell of it, and the fit moves that by up to 0.15 over its faces";
            outside "below 0.5 no stair fits its line; above, bends and corners get one";
        edge_about: f64 = 2.5, "spacings", 1.5 to 4;
            what "radius about a face of a boundary within which faces say which way the edge looks";
            source "chosen: two steps of an edge at 27° or more; flatter edges look almost along the lattice";
            outside "below, inflow over oblique edges enters along the lattice; above, corners of the edge are rounded";
        mixing_length: f64 = 0.09, "depths", 0.06 to 0.14;
            what "λ: mixing length away from the bed";
            source "`Escudier1966`";
            outside "jets and wakes spread too slowly, or too fast, by the square of the ratio";
        plane_mixing: f64 = 6.0, "–", 4 to 8;
            what "β: mixing length of the plane over that of the vertical";
            source "`Stansby2003`";
            outside "jets and wakes spread too slowly, or too fast, by the square of the ratio";
    }
}

constants! {
    /// Constants of the riverbed: upright steps, ridges narrower than a cell, their gaps, and the fits of the other bed methods.
    BedConstants in bed {
        upright_slope: f64 = 1.0, "–", 0.8 to 1.5;
            what "rise to the metre above which a step between neighbouring pieces of terrain is upright";
            source "ground stands by itself up to its angle of repose, 30° to 45°: what is steeper is built or rock";
            outside "below, natural banks are walls; above, walls in pixels as wide as they are high are banks";
        least_step: f64 = 1.0, "m", 0.5 to 1.5;
            what "least height of an upright step, and of a ridge with a gap";
            source "chosen: above furrows, kerbs and the noise of laser scans, below garden walls and quays";
            outside "below, fields and rubble divide cells; above, low flood walls are averaged into the ground";
        step_share: f64 = 0.1, "spacings", 0.05 to 0.2;
            what "the same on small cells, where that is less: steps in flumes are lower";
            source "a step of a tenth of the width changes the mean of its cell by a twentieth: less than the slope of the bed in it";
            outside "below, noise divides the cells of flumes; above, their steps are averaged";
        least_side: f64 = 1.0 / 3.0, "–", 0.25 to 0.5;
            what "least share of a cell that its largest side takes; else the cell has no sides but rubble";
            source "a wall through the middle leaves two sides of nearly a half; three equal parts say nothing";
            outside "above a half, cells with a wall through them have no sides; below, rubble gets the bed of one stone";
        sill_rise: f64 = 0.1, "m", 0.05 to 0.2;
            what "least rise of a pass sill above both beds";
            source "the order of the noise of laser scans; less makes sills of it, which hold thin water and cost time (decision 0040)";
            outside "below, noise is a ridge; above, kerbs and field banks leak";
        sill_share: f64 = 0.01, "spacings", 0.005 to 0.03;
            what "the same on small cells, where that is less: ridges in flumes are lower";
            source "0.1 m on cells of 10 m, the usual ones";
            outside "below, noise is a ridge; above, ridges of flumes leak";
        gap_pixels: f64 = 4.0, "pixels", 3 to 8;
            what "fewest pixels from one side of a cell to the other by which a gap has a width";
            source "an error of one pixel is a quarter of the face at most";
            outside "below, gaps are half as wide or twice; above, terrain that knows its gaps is not asked";
        pixel_ratio: f64 = 1.25, "–", 1 to 1.5;
            what "greatest ratio of the sides of pixels that measure a width";
            source "the width of a gap at any angle is off by up to this ratio: as much as by one pixel in four";
            outside "above, a width depends on its direction by more than the pixels do; at 1 geographic rasters have no gaps";
        gap_open: f64 = 0.9, "–", 0.75 to 1;
            what "share of a face that is open above which it has no gap";
            source "the tenth that is closed is less than half of one pixel in four: no ridge that can be measured";
            outside "below, wide gaps are open faces; at 1, each end of a ridge costs a face in part";
        shepard_support: f64 = 1.5, "spacings", 1.42 to 2;
            what "support of the kernel mean of the bed method `shepard`";
            source "the eight cells around: as far as one particle stands for and the flow resolves";
            outside "below √2 the corners are left out; above 2 the bed is smoother than the flow";
        squares_support: f64 = 2.0, "spacings", 1.5 to 3;
            what "support of the bed method `moving_least_squares`";
            source "a quadratic has six unknowns and a plane three: twice the area of `shepard_support`";
            outside "below, too few samples determine it; above, the bed is smoother than the flow";
        squares_response: f64 = 4.0, "–", 2 to 8;
            what "greatest response of the height of a quadratic to its samples; more says that they do not determine one";
            source "1.6 amid samples on a lattice; more than twice that says that they lie badly";
            outside "below 2 lattices near edges fall back to planes; above, single samples swing the bed";
        plane_samples: usize = 4, "samples", 3 to 6;
            what "fewest samples that determine a plane";
            source "three determine it, one is to spare";
            outside "3 leave no residual that bounds the plane; more refuse planes of sparse surveys";
        plane_spread: f64 = 0.02, "–", 0.005 to 0.1;
            what "least variance of the samples across their line over that along it";
            source "a strip seven times as long as wide";
            outside "below, planes tilt across lines of survey points; above, they are refused beside edges";
    }
}

constants! {
    /// Constants of still water at the start.
    SeedingConstants in seeding {
        volume_aim: f64 = 0.25 * 1e-3, "–", 1e-5 to 1e-3;
            what "relative difference of volume at which no more cells are taken in or left out at the rim";
            source "a quarter of what `seeded-volume` allows";
            outside "above 1e-3 the gate fails; below, one cell more or less decides";
        pocket_reach: usize = 2, "cells", 1 to 4;
            what "cells beyond the polygon up to which ground below the level can be a pocket";
            source "a rim is drawn to within a cell, and a cell counts by its centre: two";
            outside "at 0 pockets at the rim are trenches; above, valleys beside the lake are filled";
        pocket_steps: usize = 2, "cells", 1 to 4;
            what "steps beyond `pocket_reach` back from open ground within which ground below the level is open, too";
            source "one back to the polygon, one for the way round a corner";
            outside "at 0 ground behind a corner of a leak is filled; above, pockets near leaks are left out";
        approach: usize = 4, "cells", 2 to 8;
            what "cells of a body before an opening whose bed is that of the terrain";
            source "a gap that a dam leaves in raster ground is some cells long";
            outside "below, a raised bed narrows the opening; above, shores near an opening keep volumes that are off";
    }
}

constants! {
    /// Constants of what is recorded.
    OutputConstants in output {
        gauge_smoothing: f64 = 0.75, "spacings", 0.71 to 1;
            what "smoothing length by which a gauge reads the particles around it";
            source "support of 1.5 spacings: the four nearest at least, as the bed is smoothed";
            outside "below √½ the diagonal cells are left out, and levels step from cell to cell; above, it blurs what the lattice resolves";
    }
}

/// The constants of all methods.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Constants {
    /// Those of the faces of Eulerian particles.
    pub eulerian: EulerianConstants,
    /// Those of the riverbed.
    pub bed: BedConstants,
    /// Those of still water at the start.
    pub seeding: SeedingConstants,
    /// Those of what is recorded.
    pub output: OutputConstants,
}

impl Constants {
    /// The values of the methods as they are described.
    pub const DEFAULT: Constants = Constants {
        eulerian: EulerianConstants::DEFAULT,
        bed: BedConstants::DEFAULT,
        seeding: SeedingConstants::DEFAULT,
        output: OutputConstants::DEFAULT,
    };

    /// Every constant.
    pub fn all() -> impl Iterator<Item = &'static Constant> {
        let groups = [EulerianConstants::ALL, BedConstants::ALL, SeedingConstants::ALL, OutputConstants::ALL];
        groups.into_iter().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_constant_lies_in_its_range_and_varies_alone() {
        for constant in Constants::all() {
            let value = constant.of(&Constants::DEFAULT);
            assert!((constant.range.0..=constant.range.1).contains(&value), "{}", constant.name);
            for factor in [0.9, 1.1] {
                let varied = constant.times(factor);
                let changed = Constants::all()
                    .filter(|other| other.of(&varied).to_bits() != other.of(&Constants::DEFAULT).to_bits());
                assert_eq!(changed.map(|other| other.name).collect::<Vec<_>>(), [constant.name]);
                let way = (constant.of(&varied) - value) * (factor - 1.0);
                assert!(way > 0.0, "{}", constant.name);
            }
        }
    }
}
