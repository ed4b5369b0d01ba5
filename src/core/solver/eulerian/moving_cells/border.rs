//! Where the partition meets the rows of the lattice: pinned cells stand in both.
//!
//! Before a stage the rows get the water of the pinned cells, and these see that of the squares beside them; what passes the sides between both
//! is what the rows find, with the gradients of the pinned cells.

use super::super::state::{Slot, State, sides};
use super::region::Square;
use super::{Cell, MovingCells};
use crate::math::Vec2;

impl MovingCells {
    /// The padded places of pinned cells.
    pub fn pinned_places(&self) -> impl Iterator<Item = (usize, (usize, usize))> + '_ {
        self.pinned.iter().filter_map(|&k| match self.cells[k as usize] {
            Cell::Pinned(place) => Some((k as usize, place)),
            _ => None,
        })
    }

    /// The padded places of pinned cells that are active: what is beside them in the rows may get water of theirs.
    pub fn active_pinned(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.pinned_places().filter(|&(k, _)| self.is_active[k]).map(|(_, place)| place)
    }

    /// Puts the water of the pinned cells into the rows: of those that are active, and once of those that have ceased to be.
    pub fn show(&mut self, state: &mut State) {
        for &k in &self.pinned {
            let k = k as usize;
            let was_shown = std::mem::replace(&mut self.is_shown[k], self.is_active[k]);
            let Cell::Pinned((row, column)) = self.cells[k] else { continue };
            if !was_shown && !self.is_active[k] {
                continue;
            }
            if !self.is_active[k] {
                let none = &mut state.gradient[row];
                for of in [&mut none.surface_x, &mut none.depth_x, &mut none.u_x, &mut none.v_x] {
                    of[column] = 0.0;
                }
                for of in [&mut none.surface_y, &mut none.depth_y, &mut none.u_y, &mut none.v_y] {
                    of[column] = 0.0;
                }
            }
            let seen = self.seen[k];
            let water = &mut state.water[row];
            water.depth[column] = seen.depth;
            water.discharge_x[column] = seen.depth * seen.u;
            water.discharge_y[column] = seen.depth * seen.v;
            let primitive = &mut state.primitive[row];
            primitive.depth[column] = seen.depth;
            primitive.velocity_x[column] = seen.u;
            primitive.velocity_y[column] = seen.v;
        }
        self.show_tracers(state);
    }

    /// Looks at the squares beside the pinned cells, as they are for a stage; cells beside their water become active.
    pub fn look(&mut self, state: &State, dry_depth: f64) {
        if self.is_lost {
            return;
        }
        let mut is_new = false;
        for &k in &self.fixed {
            let Cell::Fixed((row, column)) = self.cells[k as usize] else { continue };
            let water = &state.primitive[row];
            let seen = &mut self.seen[k as usize];
            // Cells two further on have to be active before water comes to the next ones.
            is_new |= seen.depth <= dry_depth && water.depth[column] > dry_depth;
            seen.depth = water.depth[column];
            seen.bed = state.ground[row].bed[column];
            (seen.u, seen.v) = (water.velocity_x[column], water.velocity_y[column]);
        }
        self.look_at_tracers(state);
        if is_new {
            self.find_active(dry_depth);
            self.partition(false);
        }
    }

    /// Puts the gradients of the pinned cells into the rows.
    pub fn show_gradients(&self, state: &mut State) {
        for (k, (row, i)) in self.pinned_places() {
            if !self.is_active[k] && !self.is_shown[k] {
                continue;
            }
            let [surface, depth, u, v] = if self.is_active[k] { self.slopes[k].of } else { [Vec2::ZERO; 4] };
            let out = &mut state.gradient[row];
            (out.surface_x[i], out.depth_x[i], out.u_x[i], out.v_x[i]) = (surface.x, depth.x, u.x, v.x);
            (out.surface_y[i], out.depth_y[i], out.u_y[i], out.v_y[i]) = (surface.y, depth.y, u.y, v.y);
        }
    }

    /// The sides of a pinned cell's square towards squares that rest: where the rows have what passes them, with the sign of what leaves the cell.
    pub(super) fn sides(&self, i: usize) -> &[(Slot, f64)] {
        let to = |k: usize| self.side_ends.get(k).map_or(self.all_sides.len(), |&end| end as usize);
        let from = if i == 0 { 0 } else { to(i - 1) };
        &self.all_sides[from..to(i)]
    }

    /// Finds the sides of all cells: pinned ones keep their numbers.
    pub(super) fn find_sides(&mut self) {
        for cell in &self.cells {
            if let Cell::Pinned(place) = *cell {
                let (row, column) = place;
                let beside = [(row, column + 1), (row, column - 1), (row + 1, column), (row - 1, column)];
                let all = sides(place).into_iter().zip(beside);
                self.all_sides.extend(all.filter(|(_, to)| self.region.at(*to) == Square::Fixed).map(|(side, _)| side));
            }
            self.side_ends.push(self.all_sides.len() as u32);
        }
    }

    /// What leaves a pinned cell over a side per metre: volume and momentum.
    pub(super) fn over_side(state: &State, (slot, sign): (Slot, f64)) -> (f64, Vec2) {
        let [mass, tangential, left, right] = state.flux[slot.row][slot.direction].at(slot.column);
        let normal = if sign > 0.0 { left } else { right };
        let momentum = if slot.direction == super::super::faces::EAST {
            Vec2::new(normal, tangential)
        } else {
            Vec2::new(tangential, normal)
        };
        (sign * mass, momentum * sign)
    }
}
