//! A bed that moves as prescribed: ground that rises or sinks, and a rigid slide that runs along a line (M47), (M48).
//!
//! With Z the final change of the ground and p(t) its share, and with T_s the thickness of a slide where it lies at the start,
//!
//! ```text
//! Δz_b(x, t) = p(t) Z(x)                        Δz_b(x, t) = T_s(x − o(t)) − T_s(x)
//! ```
//!
//! where o(t) leads from the beginning of the line to the place on it that ∫ v dt has reached: the slide does not turn. Not here:
//! what the water does (`solver/eulerian/moving_bed.rs`); a slide that deforms, or that the water slows down.

use super::Series;
use crate::math::Vec2;

/// A part of the bed that moves.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct BedMotion {
    /// When it begins (s).
    pub begin: f64,
    /// Cells of the lattice that it may change; of each the final change Z (m) of ground that moves in place, or the thickness T_s
    /// (m) of the slide on it at the start.
    pub cells: Vec<(usize, f64)>,
    /// How it moves.
    pub law: BedLaw,
}

/// How a part of the bed moves, over the seconds since it began.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum BedLaw {
    /// In place, all at once.
    AtOnce,
    /// In place, by a share that rises from 0 to 1.
    Share(Series),
    /// Along a line.
    Slide(Slide),
}

/// A rigid slide.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Slide {
    /// Its thickness at the start.
    pub thickness: Patch,
    /// The line (local coordinates, m); the slide stops at its end.
    pub path: Vec<Vec2>,
    /// Velocity along it (m/s, not negative).
    pub velocity: Series,
}

/// Values on a grid, bilinear between the centres of its cells, and falling to 0 within a cell of its rim.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Patch {
    /// Centre of the south-western cell (local coordinates, m).
    pub first: Vec2,
    /// Distances of the centres (m).
    pub cell: Vec2,
    /// Number of columns.
    pub columns: usize,
    /// Values `[rows, columns]`, row 0 in the south.
    pub values: Vec<f64>,
}

impl Patch {
    /// The value at a place (local coordinates, m).
    pub fn at(&self, place: Vec2) -> f64 {
        let rows = self.values.len() / self.columns;
        let (x, y) = ((place.x - self.first.x) / self.cell.x, (place.y - self.first.y) / self.cell.y);
        if !(x > -1.0 && y > -1.0 && x < self.columns as f64 && y < rows as f64) {
            return 0.0;
        }
        let (column, row) = (x.floor(), y.floor());
        let value = |c: f64, r: f64| {
            let is_inside = c >= 0.0 && r >= 0.0 && c < self.columns as f64 && r < rows as f64;
            if is_inside { self.values[r as usize * self.columns + c as usize] } else { 0.0 }
        };
        let (right, up) = (x - column, y - row);
        let along =
            |r: f64| value(column, r) * (1.0 - right) + if right > 0.0 { value(column + 1.0, r) * right } else { 0.0 };
        along(row) * (1.0 - up) + if up > 0.0 { along(row + 1.0) * up } else { 0.0 }
    }

    /// The rectangle outside of which it is 0: its south-western and north-eastern corner.
    pub fn extent(&self) -> [Vec2; 2] {
        let rows = self.values.len() / self.columns;
        let size = Vec2::new((self.columns + 1) as f64 * self.cell.x, (rows + 1) as f64 * self.cell.y);
        [self.first - self.cell, self.first - self.cell + size]
    }
}

impl Slide {
    /// Length of the line (m).
    pub fn length(&self) -> f64 {
        self.path.windows(2).map(|piece| (piece[1] - piece[0]).norm()).sum()
    }

    /// How far (m) it has come along its line at a time (s) since its beginning.
    pub fn distance(&self, since: f64) -> f64 {
        self.velocity.integral(0.0, since.max(0.0)).min(self.length())
    }

    /// The way (m) from the beginning of the line to the place at a distance (m) along it.
    pub fn offset(&self, distance: f64) -> Vec2 {
        let mut left = distance;
        for piece in self.path.windows(2) {
            let along = piece[1] - piece[0];
            if left <= along.norm() {
                return piece[0] + along * (left / along.norm()) - self.path[0];
            }
            left -= along.norm();
        }
        self.path[self.path.len() - 1] - self.path[0]
    }
}

/// How far a part of the bed has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// Ground that moves in place: its share.
    Share(f64),
    /// A slide: its way from where it lay (m).
    Offset(Vec2),
}

impl BedMotion {
    /// How far it has come at a time (s); a time that rounding leaves a little before the beginning counts as the beginning.
    pub fn progress(&self, time: f64) -> Progress {
        /// Share of a time by which rounding may miss it.
        const ROUND_OFF: f64 = 1e-12;
        let has_begun = time >= self.begin * (1.0 - ROUND_OFF);
        let since = (time - self.begin).max(0.0);
        match &self.law {
            BedLaw::AtOnce => Progress::Share(if has_begun { 1.0 } else { 0.0 }),
            BedLaw::Share(series) => Progress::Share(if has_begun { series.at(since) } else { 0.0 }),
            BedLaw::Slide(slide) => Progress::Offset(slide.offset(slide.distance(since))),
        }
    }

    /// The change (m) of the bed of the k-th of its cells, whose centre is given (local coordinates, m).
    pub fn change(&self, k: usize, centre: Vec2, progress: Progress) -> f64 {
        match (progress, &self.law) {
            (Progress::Offset(offset), BedLaw::Slide(slide)) => slide.thickness.at(centre - offset) - self.cells[k].1,
            (Progress::Share(share), _) => self.cells[k].1 * share,
            (Progress::Offset(_), _) => 0.0,
        }
    }

    /// The greatest speed (m/s) at which it crosses the ground between two times (s).
    pub fn fastest(&self, from: f64, to: f64) -> f64 {
        match &self.law {
            BedLaw::Slide(slide) if to > self.begin && slide.distance(from - self.begin) < slide.length() => {
                slide.velocity.largest((from - self.begin).max(0.0), to - self.begin)
            }
            BedLaw::Slide(_) | BedLaw::AtOnce | BedLaw::Share(_) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch() -> Patch {
        Patch { first: Vec2::new(10.0, 20.0), cell: Vec2::new(2.0, 4.0), columns: 2, values: vec![1.0, 2.0, 3.0, 5.0] }
    }

    fn slide(velocity: &[(f64, f64)]) -> BedMotion {
        let path = vec![Vec2::new(0.0, 0.0), Vec2::new(30.0, 0.0), Vec2::new(30.0, 40.0)];
        let slide = Slide { thickness: patch(), path, velocity: Series::new(velocity).unwrap() };
        BedMotion { begin: 5.0, cells: vec![(0, 1.0)], law: BedLaw::Slide(slide) }
    }

    #[test]
    fn a_patch_is_bilinear_and_falls_to_0_beyond_its_rim() {
        let patch = patch();
        for (x, y, value) in [
            (10.0, 20.0, 1.0),
            (11.0, 20.0, 1.5),
            (11.0, 22.0, 2.75),
            (12.0, 24.0, 5.0),
            (9.0, 20.0, 0.5),
            (13.0, 26.0, 1.25),
        ] {
            assert!((patch.at(Vec2::new(x, y)) - value).abs() < 1e-15, "{x} {y}: {}", patch.at(Vec2::new(x, y)));
        }
        let [low, high] = patch.extent();
        assert_eq!((low, high), (Vec2::new(8.0, 16.0), Vec2::new(14.0, 28.0)));
        for place in [low, high, Vec2::new(7.0, 20.0), Vec2::new(f64::NAN, 20.0)] {
            assert!(patch.at(place).abs() <= 0.0);
        }
        // Its volume is that of its cells, wherever it lies between those of another grid.
        let sum: f64 = (0..200)
            .flat_map(|i| (0..200).map(move |j| (i, j)))
            .map(|(i, j)| patch.at(Vec2::new(0.123 + 0.1 * f64::from(i), 10.07 + 0.1 * f64::from(j))))
            .sum();
        assert!((sum * 0.01 / (11.0 * 8.0) - 1.0).abs() < 1e-3, "{sum}");
    }

    #[test]
    fn a_slide_follows_its_line_and_stops_at_its_end() {
        let motion = slide(&[(0.0, 0.0), (10.0, 4.0)]);
        // 20 m after 10 s, 30 m after 12.5 s, then to the north; the end after 22.5 s.
        for (time, x, y) in
            [(0.0, 0.0, 0.0), (5.0, 0.0, 0.0), (15.0, 20.0, 0.0), (20.0, 30.0, 10.0), (99.0, 30.0, 40.0)]
        {
            let Progress::Offset(offset) = motion.progress(time) else { panic!("no slide") };
            assert!((offset - Vec2::new(x, y)).norm() < 1e-12, "{time}: {offset:?}");
        }
        assert!((motion.fastest(10.0, 12.0) - 2.8).abs() < 1e-12);
        assert!(motion.fastest(0.0, 4.0).abs() <= 0.0 && motion.fastest(40.0, 50.0).abs() <= 0.0);
        let centre = Vec2::new(30.0, 20.0);
        assert!((motion.change(0, centre, motion.progress(15.0)) - 0.0).abs() < 1e-15);
    }

    #[test]
    fn ground_that_moves_in_place_keeps_its_end() {
        let of = |law: BedLaw, time: f64| {
            let motion = BedMotion { begin: 5.0, cells: vec![(0, -2.0)], law };
            motion.change(0, Vec2::ZERO, motion.progress(time))
        };
        let series = || BedLaw::Share(Series::new(&[(0.0, 0.0), (10.0, 1.0)]).unwrap());
        for (time, change) in [(0.0, 0.0), (5.0, 0.0), (10.0, -1.0), (15.0, -2.0), (1e6, -2.0)] {
            assert!((of(series(), time) - change).abs() < 1e-15, "{time}");
        }
        assert!(of(BedLaw::AtOnce, 4.999).abs() <= 0.0 && (of(BedLaw::AtOnce, 5.0) + 2.0).abs() <= 0.0);
    }
}
