//! How cells move (M109), and the step that this allows.

use rayon::prelude::*;

use super::super::Scale;
use super::geometry::Way;
use super::{CHUNK, Cell, MovingCells};
use crate::math::Vec2;

/// How fast cells need their steps, and the speed of the water in them.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Pace {
    /// The reciprocal of the step that they allow, before the Courant number (1/s); not a number where the water is none.
    pub haste: f64,
    /// Where that is.
    pub place: Vec2,
    /// Greatest speed of the water (m/s).
    pub flow_speed: f64,
}

/// Cells that are nearer to a pinned one (spacings) come no nearer to it: with half a spacing in a step they do not get past it.
const NEAREST: f64 = 0.75;

impl MovingCells {
    /// κ v of a cell.
    #[inline]
    fn own_motion(&self, i: usize) -> Vec2 {
        Vec2::new(self.seen[i].u, self.seen[i].v) * self.mobility[i]
    }

    /// Finds κ and ρ of the active cells.
    fn find_mobility(&mut self, dry_depth: f64) {
        let MovingCells { mobility, slopes, chunks, cells, seen, area, is_active, .. } = self;
        let (chunks, cells, seen, area, is_active) = (&*chunks, &*cells, &*seen, &*area, &*is_active);
        let both = mobility.par_chunks_mut(CHUNK).zip(slopes.par_chunks_mut(CHUNK)).zip(chunks);
        both.enumerate().for_each(|(number, ((mobility, slopes), chunk))| {
            for (k, (mobility, slopes)) in mobility.iter_mut().zip(slopes).enumerate() {
                let i = number * CHUNK + k;
                let here = seen[i];
                *mobility = 0.0;
                if !is_active[i] {
                    continue;
                }
                let rise = |way: &Way| seen[way.to as usize].bed - here.bed;
                let slope = chunk.ways(k).iter().map(|way| way.weight() * rise(way)).fold(Vec2::ZERO, |a, b| a + b);
                let slope = slope * (1.0 / area[i]);
                let beside = |way: &Way| (rise(way) - slope.dot(way.normal) * way.distance).abs();
                slopes.step = chunk.ways(k).iter().map(beside).fold(0.0, f64::max);
                if cells[i] == Cell::Free && here.depth > dry_depth {
                    let plane = here.depth.max(slope.norm() * area[i].sqrt());
                    *mobility = (1.0 - slopes.step / plane).max(0.0);
                }
            }
        });
    }

    /// Finds w of the active cells.
    pub(super) fn find_motion(&mut self, scale: &Scale) {
        self.find_mobility(scale.dry_depth);
        let nearest = NEAREST * self.ground.lattice().spacing;
        let mut motion = std::mem::take(&mut self.motion);
        let this = &*self;
        motion.par_chunks_mut(CHUNK).enumerate().for_each(|(number, motion)| {
            let is_active = &this.is_active[number * CHUNK..][..motion.len()];
            if !is_active.contains(&true) {
                motion.fill(Vec2::ZERO);
                return;
            }
            for (k, motion) in motion.iter_mut().enumerate() {
                let i = number * CHUNK + k;
                let own = this.own_motion(i);
                *motion = own;
                if own.x == 0.0 && own.y == 0.0 {
                    continue;
                }
                let apart = this.chunks[number]
                    .ways(k)
                    .iter()
                    .map(|way| (this.own_motion(way.to as usize) - own).dot(way.normal).abs());
                let apart = apart.fold(0.0, f64::max);
                *motion = own + (this.centroid[i] - this.mesh.place(i as u32)) * (apart / this.area[i].sqrt());
                let is_near =
                    |way: &&Way| way.distance < nearest && matches!(this.cells[way.to as usize], Cell::Pinned(_));
                let near = || this.chunks[number].ways(k).iter().filter(is_near);
                for way in near() {
                    *motion = *motion - way.normal * motion.dot(way.normal).max(0.0);
                }
                if near().any(|way| motion.dot(way.normal) > 1e-9 * own.norm()) {
                    *motion = Vec2::ZERO;
                }
            }
        });
        self.motion = motion;
    }

    /// How fast the cells need their steps now.
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// Finds that, and so that water does not cross more of a cell than it may: |v − w| + c over 4 A/p, p the perimeter, and the difference of w
    /// to a neighbour over √A, or a spacing if that is less.
    pub(super) fn find_pace(&mut self, scale: &Scale) {
        let square = self.ground.lattice().cell_area();
        let of_cell = |&i: &u32| {
            let i = i as usize;
            let (seen, own) = (self.seen[i], self.motion[i]);
            let mut pace = Pace { place: self.mesh.place(i as u32), ..Pace::default() };
            let (mut perimeter, mut apart) = (0.0, 0.0_f64);
            for (way, _) in self.ways_and_faces(i) {
                perimeter += way.length;
                apart = apart.max((self.motion[way.to as usize] - own).norm_squared());
            }
            if seen.depth > scale.dry_depth || seen.depth.is_nan() {
                let velocity = Vec2::new(seen.u, seen.v);
                pace.flow_speed = velocity.norm();
                let signal_speed = (velocity - own).norm() + (scale.gravity * seen.depth).sqrt();
                pace.haste = perimeter * signal_speed / (4.0 * self.area[i]);
            }
            let of_motion = (apart / self.area[i].min(square)).sqrt();
            Pace { haste: if of_motion > pace.haste { of_motion } else { pace.haste }, ..pace }
        };
        let join = |a: Pace, b: Pace| {
            let faster = if b.haste > a.haste || b.haste.is_nan() { b } else { a };
            Pace { flow_speed: a.flow_speed.max(b.flow_speed), ..faster }
        };
        let all = |cells: &[u32]| cells.iter().map(of_cell).fold(Pace::default(), join);
        let paces: Vec<Pace> = self.active.par_chunks(CHUNK).map(all).collect();
        self.pace = paces.into_iter().fold(Pace::default(), join);
    }
}
