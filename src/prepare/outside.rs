//! Lines that lie on no terrain: how much of them, and where.
//!
//! One rule for all that is drawn as lines: what lies beside the terrain altogether is refused, and of what lies beside it in part
//! the length and a place are reported.

use crate::bed::BedParticles;
use crate::error::{Problem, input_error, input_warning};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::prepare::findings::Findings;
use crate::prepare::grid::REACH;
use crate::prepare::ground::burn::cut;
use crate::scenario::{Sourced, VectorSource};

/// Length (in cells) on no terrain that is not worth a word: lines are drawn by hand, and the edge of the terrain runs in steps.
const OVERSHOOT: f64 = 2.0;

/// What of some lines lies on no terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Outside {
    /// Length (m) on terrain.
    on: f64,
    /// Length (m) on none.
    off: f64,
    /// Where its first part on none begins (map coordinates).
    place: Option<Vec2>,
}

impl Outside {
    /// Measures straight pieces (local coordinates, m); `is_on` says whether a place counts as terrain.
    pub fn of(pieces: impl IntoIterator<Item = [Vec2; 2]>, lattice: &Lattice, is_on: impl Fn(Vec2) -> bool) -> Self {
        let mut found = Outside::default();
        for part in pieces.into_iter().flat_map(|piece| cut(piece, lattice)) {
            if is_on(part.middle) {
                found.on += part.length;
            } else {
                found.off += part.length;
                found.place = found.place.or(Some(lattice.to_map(part.ends[0])));
            }
        }
        found
    }

    /// The same of lines that act on the terrain within reach: those drawn along its edge lie on either side of it.
    pub fn beyond_reach(pieces: impl IntoIterator<Item = [Vec2; 2]>, bed: &BedParticles) -> Self {
        let reach = REACH * bed.lattice.spacing;
        Outside::of(pieces, &bed.lattice, |place| is_near_terrain(bed, place, reach))
    }

    /// Whether all of it lies on no terrain.
    pub fn is_all(&self) -> bool {
        self.on <= 0.0
    }

    /// The length (m) on no terrain and its first place (map coordinates), where it is a part worth a word.
    pub fn part(&self, spacing: f64) -> Option<(f64, Vec2)> {
        let place = self.place.filter(|_| !self.is_all() && self.off > OVERSHOOT * spacing)?;
        Some((self.off, place))
    }
}

/// Whether a place (local coordinates, m) lies on terrain or nearer to it than `margin` (m); a blocked building counts as terrain.
fn is_near_terrain(bed: &BedParticles, place: Vec2, margin: f64) -> bool {
    let shifts = [-margin, 0.0, margin];
    let has_terrain = |place: Vec2| {
        let cell = bed.lattice.cell_at(place);
        cell.is_some_and(|cell| bed.has_terrain(cell) || bed.sealed.binary_search(&cell).is_ok())
    };
    shifts.iter().any(|x| shifts.iter().any(|y| has_terrain(place + Vec2::new(*x, *y))))
}

/// The problem of all lines of a file beside the terrain, the first of them at a place (map coordinates).
pub(super) fn all_outside(source: &Sourced<VectorSource>, first: Vec2, findings: &mut Findings) {
    let message = format!("the lines of {} lie outside the terrain", source.value.path.display());
    let remedy = "check that the file and the terrain have the same CRS";
    findings.add(source, input_error("outside-terrain", message).with_remedy(remedy).with_at(first));
}

/// The warning of the part of lines that lies on no terrain: what comes of it there.
pub(super) fn partly_outside(
    source: &Sourced<VectorSource>,
    outside: Outside,
    spacing: f64,
    effect: &str,
) -> Option<Problem> {
    let (length, place) = outside.part(spacing)?;
    let message = format!("{length:.0} m of the lines of {} lie on no terrain", source.value.path.display());
    let problem = input_warning("outside-terrain", message).with_cause(effect);
    Some(problem.with_remedy(IN_PART).with_at(place))
}

/// What to do about a line that lies on no terrain in part.
pub(super) const IN_PART: &str =
    "right where the terrain ends on ground that stays dry; elsewhere check the line and its CRS";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_part_on_no_terrain_has_its_length_and_its_first_place() {
        let lattice = Lattice::new(Vec2::new(1000.0, 2000.0), 10, 10, 2.0);
        let mut bed = BedParticles::from_elevation(lattice.clone(), vec![0.0; 100], 0.03);
        // The third column has no data.
        (0..10).for_each(|row| bed.elevation[row * 10 + 2] = f64::NAN);
        let measure = |margin: f64| {
            let line = [[Vec2::new(1.0, 5.0), Vec2::new(30.0, 5.0)]];
            Outside::of(line, &lattice, |place| is_near_terrain(&bed, place, margin))
        };
        // The column of 2 m, and 10 m beyond the eastern edge.
        let exact = measure(0.0);
        assert!((exact.off - 12.0).abs() < 1e-12 && (exact.on - 17.0).abs() < 1e-12, "{exact:?}");
        assert_eq!(exact.part(2.0).map(|part| part.1), Some(Vec2::new(1004.0, 2005.0)));
        assert_eq!(exact.part(6.0), None);
        let wide = measure(3.0);
        assert!((wide.off - 10.0).abs() < 1e-12, "{wide:?}");
        assert_eq!(wide.part(2.0), Some((wide.off, Vec2::new(1020.0, 2005.0))));
    }

    #[test]
    fn lines_far_beyond_the_lattice_take_no_more_time_than_near_ones() {
        let lattice = Lattice::new(Vec2::ZERO, 10, 10, 2.0);
        let far = [Vec2::new(5.0, 5.0), Vec2::new(1e15, 1e15)];
        assert!(cut(far, &lattice).len() < 30);
        let outside = Outside::of([far], &lattice, |place| lattice.cell_at(place).is_some());
        assert!(outside.part(2.0).is_some() && (outside.on - 15.0 * 2f64.sqrt()).abs() < 1.0, "{outside:?}");
    }
}
