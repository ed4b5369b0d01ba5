//! Whether a line that raises or carves the bed lies as high above the ground as levees and dams do, and as low below it as cuts do.

use super::burn::{cut, value_at};
use crate::bed::BedParticles;
use crate::error::{Problem, input_warning};
use crate::math::Vec2;

/// Greatest height (m) of a dam, or depth of a cut: what is more has another unit.
const TALLEST: f64 = 400.0;
/// A line that lies so far (m) above or below the ground all along has another unit or datum: levees are hardly higher than 30 m, and
/// dams and cuts of more than that come up or down to the ground at their ends.
const TALLEST_ALL_ALONG: f64 = 50.0;
/// A crest less than this (m) below the ground is that of a levee which the terrain holds already.
const BURIED: f64 = 0.2;
/// Share of a levee that may lie below the ground without a word: it ends in higher ground, and may cross some on its way.
const BURIED_SHARE: f64 = 0.5;
const BURIED_ON_THE_WAY: f64 = 0.2;

/// A cell of a line with the height (m) of the line above its ground, or of the depth below it where the line carves.
pub type Height = (usize, f64);

/// A height that hardly any dam, levee or cut has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    pub cell: usize,
    height: f64,
    is_all_along: bool,
}

impl Doubt {
    /// Of a line its least height and its greatest.
    pub fn of([least, most]: [Height; 2]) -> Option<Doubt> {
        if most.1 > TALLEST {
            return Some(Doubt { cell: most.0, height: most.1, is_all_along: false });
        }
        (least.1 > TALLEST_ALL_ALONG).then_some(Doubt { cell: least.0, height: least.1, is_all_along: true })
    }

    /// The warning of a feature.
    pub fn problem(&self, feature: &str, side: &str) -> Problem {
        let height = format!("{:.0} m", self.height);
        let (message, cause) = if self.is_all_along {
            let cause = "no levee is so high, and a dam or a cut ends at the ground; another unit or datum, perhaps";
            (format!("{feature} lies {height} or more {side} the terrain all along"), cause.to_owned())
        } else {
            let cause = format!("no dam and no cut is higher than {TALLEST} m; another unit or datum, perhaps");
            (format!("{feature} lies {height} {side} the terrain"), cause)
        };
        input_warning("doubtful-level", message)
            .with_cause(cause)
            .with_remedy("correct the level, its unit or its datum, or the place of the line")
    }
}

/// The parts of a line (local coordinates, m) with the level of each vertex (m) on terrain: the length of each (m), how far (m) it lies
/// below the ground, and its middle.
fn depths_along(line: &[Vec2], levels: &[f64], bed: &BedParticles) -> Vec<(f64, f64, Vec2)> {
    let mut parts = Vec::new();
    for (piece, ends) in line.windows(2).zip(levels.windows(2)) {
        parts.extend(cut([piece[0], piece[1]], &bed.lattice).into_iter().filter_map(|part| {
            let cell = bed.lattice.cell_at(part.middle).filter(|cell| bed.has_terrain(*cell))?;
            Some((part.length, bed.elevation[cell] - value_at(part.middle, piece, ends), part.middle))
        }));
    }
    parts
}

/// Length (m) over which a line (local coordinates, m) of one level (m) stands above the ground.
pub fn length_above_ground(line: &[Vec2], level: f64, bed: &BedParticles) -> f64 {
    let parts = depths_along(line, &vec![level; line.len()], bed);
    parts.iter().filter(|part| part.1 < 0.0).map(|part| part.0).sum()
}

/// The part of a levee that lies below the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Buried {
    /// Length (m) below the ground, and of the whole line on terrain.
    length: f64,
    whole: f64,
    /// How far (m) it lies below the ground, and the place of that (local coordinates, m).
    depth: f64,
    pub place: Vec2,
}

impl Buried {
    /// The part of a line (local coordinates, m) with the level of each vertex (m), where it is more than its ends in higher ground.
    pub fn of(line: &[Vec2], levels: &[f64], bed: &BedParticles) -> Option<Buried> {
        let parts = depths_along(line, levels, bed);
        let is_below = |part: &(f64, f64, Vec2)| part.1 > BURIED;
        let lengths = |parts: &[(f64, f64, Vec2)]| {
            let below: f64 = parts.iter().filter(|part| is_below(part)).map(|part| part.0).sum();
            (below, parts.iter().map(|part| part.0).sum::<f64>())
        };
        let &(_, depth, place) = parts.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let on_the_way = match parts.iter().position(|part| !is_below(part)) {
            Some(first) => {
                let last = parts.iter().rposition(|part| !is_below(part)).unwrap_or(first);
                let (below, between) = lengths(&parts[first..=last]);
                below > BURIED_ON_THE_WAY * between
            }
            None => true,
        };
        let (length, whole) = lengths(&parts);
        (length > BURIED_SHARE * whole || on_the_way || depth > TALLEST).then_some(Buried {
            length,
            whole,
            depth,
            place,
        })
    }

    /// The warning of a feature.
    pub fn problem(&self, feature: &str) -> Problem {
        let message = format!(
            "{:.0} m of {:.0} m of {feature} lie below the terrain, by up to {:.2} m, and raise nothing there",
            self.length, self.whole, self.depth
        );
        input_warning("crest-below-terrain", message)
            .with_cause("a levee, a wall or a dam lies above the ground on most of its way")
            .with_remedy(
                "right where higher ground takes its place; elsewhere correct the level, its unit or its datum",
            )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;

    #[test]
    fn a_height_is_doubtful_above_any_dam_and_all_along_above_any_levee() {
        let doubt = |least: f64, most: f64| Doubt::of([(1, least), (2, most)]).map(|doubt| doubt.cell);
        assert_eq!(doubt(2.0, 8.0), None);
        // A dam of 300 m, and crests in feet taken for metres.
        assert_eq!(doubt(0.5, 300.0), None);
        assert_eq!(doubt(231.0, 236.0), Some(1));
        assert_eq!(doubt(2.0, 500.0), Some(2));
        assert_eq!(doubt(-300.0, 3.0), None);
    }

    #[test]
    fn of_a_levee_the_part_below_the_ground_counts_beyond_its_ends() {
        // Ground of 10 m with the given heights in the cells of a row; a levee at 11 m along it.
        let buried = |heights: &[f64]| {
            let lattice = Lattice::new(Vec2::ZERO, heights.len(), 1, 2.0);
            let line = [Vec2::new(0.0, 1.0), Vec2::new(2.0 * heights.len() as f64, 1.0)];
            let bed = BedParticles::from_elevation(lattice, heights.iter().map(|z| 10.0 + z).collect(), 0.03);
            Buried::of(&line, &[11.0, 11.0], &bed).map(|part| (part.length, part.whole, part.depth, part.place.x))
        };
        let near = |found: Option<(f64, f64, f64, f64)>, wanted: [f64; 4]| {
            let found = found.map(|(length, whole, depth, x)| [length, whole, depth, x]).unwrap_or_default();
            assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}, not {wanted:?}");
        };
        assert_eq!(buried(&[0.0; 10]), None);
        // It ends in higher ground on both sides, or the terrain holds it already.
        assert_eq!(buried(&[9.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 9.0]), None);
        assert_eq!(buried(&[1.1; 10]), None);
        near(buried(&[9.0, 4.0, 0.0, 0.0, 5.0, 3.0, 0.0, 0.0, 0.0, 0.0]), [8.0, 20.0, 8.0, 1.0]);
        near(buried(&[0.0, 0.0, 0.0, 0.0, 3.0, 3.0, 4.0, 3.0, 3.0, 3.0]), [12.0, 20.0, 3.0, 13.0]);
    }
}
