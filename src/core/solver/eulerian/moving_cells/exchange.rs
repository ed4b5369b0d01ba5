//! Cells that have become too small are merged with their neighbours, too large ones are split.
//!
//! ```text
//! (M110)  A_i < ½ Δ²:  V_b ← V_b + V_i δA_b/Σ δA,   P likewise       δA_b what each neighbour b gains where particle i is taken out
//!         A_i > 2 Δ²:  V_b ← V_b − V_b δA_b/A_b,  V_k = Σ_b V_b δA_b/A_b     k a new particle at the corner of cell i that is farthest from it
//! ```
//!
//! Both are exchanges by the areas of `Sibson1981`, and inverse to each other: volume and momentum are kept, and uniform water stays as it is.

use super::region::Square;
use super::{CHUNK, Cell, Held, MovingCells, Slopes};
use crate::math::Vec2;

/// The least and the greatest area of a cell, over that of a square.
const LEAST: f64 = 0.5;
const GREATEST: f64 = 2.0;

impl MovingCells {
    /// Merges and splits cells at the end of a step; none is merged or split that has got something in it before.
    pub(super) fn exchange(&mut self) {
        let square = self.ground.lattice().cell_area();
        let is_free = |this: &Self, i: u32| this.cells[i as usize] == Cell::Free;
        let by_area = |this: &Self, mut cells: Vec<u32>| {
            cells.sort_by(|&a, &b| this.area[a as usize].total_cmp(&this.area[b as usize]).then(a.cmp(&b)));
            cells
        };
        let small = self
            .active
            .iter()
            .copied()
            .filter(|&i| is_free(self, i) && (self.area[i as usize] < LEAST * square || self.touches_fixed(i)));
        let large = self.active.iter().copied().filter(|&i| self.area[i as usize] > GREATEST * square);
        let (small, large) = (by_area(self, small.collect()), by_area(self, large.collect()));
        if small.is_empty() && large.is_empty() {
            return;
        }
        let mut touched: Vec<u32> = Vec::new();
        for i in small {
            if self.is_touched[i as usize] {
                continue;
            }
            self.merge(i, &mut touched);
        }
        for i in large.into_iter().rev() {
            if !self.is_touched[i as usize] {
                self.split(i, &mut touched);
            }
        }
        touched.iter().for_each(|&i| self.is_touched[i as usize] = false);
    }

    /// Whether a cell that moves lies beside a square that rests in the rows.
    fn touches_fixed(&self, i: u32) -> bool {
        self.ways_and_faces(i as usize).any(|(way, _)| self.cells[way.to as usize].is_fixed())
    }

    /// Marks cells that have taken part in an exchange.
    fn touch(&mut self, cells: impl Iterator<Item = u32>, touched: &mut Vec<u32>) {
        for i in cells {
            self.is_stale[i as usize / CHUNK] = true;
            self.is_touched[i as usize] = true;
            touched.push(i);
        }
    }

    /// Takes a cell out; its neighbours get what it holds.
    fn merge(&mut self, i: u32, touched: &mut Vec<u32>) {
        let around: Vec<u32> = self.mesh.around(i).map(|spoke| spoke.to).collect();
        let around: Vec<u32> = around.into_iter().filter(|&b| !self.cells[b as usize].is_fixed()).collect();
        if around.is_empty() || !self.mesh.is_inside(i) {
            return;
        }
        self.mesh.remove(i);
        self.counts.merges += 1;
        let own = std::mem::take(&mut self.held[i as usize]);
        self.cells[i as usize] = Cell::Gone;
        self.motion[i as usize] = Vec2::ZERO;
        self.seen[i as usize] = Default::default();
        let gained: Vec<f64> = around
            .iter()
            .map(|&b| {
                let after = self.mesh.area(b);
                (after - std::mem::replace(&mut self.area[b as usize], after)).max(0.0)
            })
            .collect();
        let all: f64 = gained.iter().sum();
        let count = around.len() as f64;
        for (&b, gained) in around.iter().zip(gained) {
            let share = if all > 0.0 { gained / all } else { 1.0 / count };
            self.tracers.mix(b, self.held[b as usize].volume, i, own.volume * share);
            let held = &mut self.held[b as usize];
            held.volume += own.volume * share;
            held.momentum += own.momentum * share;
            self.wake(b);
        }
        self.touch(around.into_iter().chain([i]), touched);
    }

    /// Puts a cell in at the farthest corner of another; its neighbours give it what they hold there.
    fn split(&mut self, i: u32, touched: &mut Vec<u32>) {
        let own = self.mesh.place(i);
        let corners = self.mesh.around(i).map(|spoke| (self.mesh.centre(spoke.sides[1]), spoke.sides[1]));
        let farthest = corners.max_by(|a, b| (a.0 - own).norm_squared().total_cmp(&(b.0 - own).norm_squared()));
        let Some((place, triangle)) = farthest else { return };
        let lattice = self.ground.lattice();
        let padded =
            lattice.cell_at(place).map(|cell| lattice.column_row(cell)).map(|(column, row)| (row + 1, column + 1));
        if !padded.is_some_and(|place| matches!(self.region.at(place), Square::Free | Square::Pinned)) {
            return;
        }
        let Some(k) = self.mesh.insert(place, triangle) else { return };
        let around: Vec<u32> = self.mesh.around(k).map(|spoke| spoke.to).collect();
        let is_barred = |&b: &u32| self.cells[b as usize].is_fixed() || self.is_touched[b as usize];
        if around.iter().any(is_barred) {
            self.mesh.remove(k);
            return;
        }
        self.grow();
        self.counts.splits += 1;
        let mut held = Held { place, ..Held::default() };
        let mut parts: Vec<(u32, f64)> = Vec::with_capacity(around.len());
        for &b in &around {
            let after = self.mesh.area(b);
            let before = std::mem::replace(&mut self.area[b as usize], after);
            let share = ((before - after) / before).clamp(0.0, 1.0);
            let given = &mut self.held[b as usize];
            let (volume, momentum) = (given.volume * share, given.momentum * share);
            given.volume -= volume;
            given.momentum = given.momentum - momentum;
            held.volume += volume;
            held.momentum += momentum;
            parts.push((b, volume));
        }
        let new = k as usize;
        self.tracers.join(new, &parts);
        self.slopes[new] = Slopes::default();
        self.cells[new] = Cell::Free;
        self.held[new] = held;
        self.area[new] = self.mesh.area(k);
        (self.seen[new].bed, self.friction[new]) = self.ground.at(place);
        self.wake(k);
        self.touch(around.into_iter().chain([k]), touched);
    }

    /// Makes a cell active.
    pub(super) fn wake(&mut self, i: u32) {
        if !std::mem::replace(&mut self.is_active[i as usize], true) {
            self.active.push(i);
        }
    }
}
