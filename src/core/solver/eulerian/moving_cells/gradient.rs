//! Gradients of cells that move (M105).

use rayon::prelude::*;

use super::super::gradient::{surface_difference, without_banks};
use super::{CHUNK, MovingCells, Slopes};
use crate::math::Vec2;

impl MovingCells {
    /// Fills the gradients of the active cells; `has_slopes` where they count.
    pub fn evaluate_gradients(&mut self, dry_depth: f64, has_slopes: bool) {
        let MovingCells { slopes, chunks, seen, area, is_active, .. } = self;
        let (chunks, seen, area, is_active) = (&*chunks, &*seen, &*area, &*is_active);
        slopes.par_chunks_mut(CHUNK).zip(chunks).enumerate().for_each(|(number, (slopes, chunk))| {
            for (k, slopes) in slopes.iter_mut().enumerate() {
                let i = number * CHUNK + k;
                if !is_active[i] {
                    continue;
                }
                *slopes = Slopes { step: slopes.step, ..Slopes::default() };
                let here = seen[i];
                let is_wet = here.depth > dry_depth && has_slopes;
                let mut kept = [Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)];
                let per_area = 1.0 / area[i];
                for way in chunk.ways(k) {
                    let there = seen[way.to as usize];
                    if !is_wet {
                        continue;
                    }
                    let weight = way.weight() * per_area;
                    if there.depth <= dry_depth && there.bed + there.depth > here.bed + here.depth {
                        let to = way.normal * way.distance;
                        kept = [kept[0] - to * weight.x, kept[1] - to * weight.y];
                    }
                    let surface = surface_difference((here.depth, here.bed), (there.depth, there.bed), dry_depth);
                    slopes.of[0] += weight * surface;
                    slopes.of[1] += weight * (there.depth - here.depth);
                    slopes.of[2] += weight * (there.u - here.u);
                    slopes.of[3] += weight * (there.v - here.v);
                }
                slopes.of[0] = without_banks(kept, slopes.of[0]);
            }
        });
    }
}
