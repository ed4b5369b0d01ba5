//! Particles that are pressed into one place become one.
//!
//! Two particles that are each other's nearest neighbour and nearer than 0.3 widths of the smallest particle at the start are merged:
//!
//! ```text
//! (M72)  V = V_i + V_j,   x = (V_i x_i + V_j x_j) / V,   v = (V_i v_i + V_j v_j) / V
//!        d = (A_i η_i + A_j η_j) / (A_i + A_j) − z_b(x)
//! ```
//!
//! Volume and momentum are kept, and so is the level of a lake. In a bore that runs over thin water many thin particles are pressed
//! together before few deep ones, and since nothing but a pressure keeps them apart they change order: the front then ran ahead of
//! itself on fine lattices, and did not converge. Merged, they lose the energy that a bore has to lose.
//!
//! In one dimension only. In the plane particles make way for each other, and bores converge without; there merging left too few
//! particles in narrow valleys, where they crowd because the water does (decision 0018).
//!
//! A particle between two equally near ones keeps both, since no order among them is better than its mirror image.

use super::{MovingWater, Rates};
use crate::math::Vec2;
use crate::particles::retain_marked;

/// Nearer than so many widths of the smallest particle at the start, two particles are one.
const NEAREST: f64 = 0.3;
/// Distances that differ by this share are equal.
const EQUAL: f64 = 1e-6;

impl MovingWater {
    /// Merges particles; to be called while the neighbours and rates are those of the particles as they are.
    pub(super) fn merge(&mut self) {
        let reach = NEAREST * self.finest;
        let mut list = Vec::new();
        let nearest: Vec<Option<usize>> =
            (0..self.particles.len()).map(|i| self.nearest_of(i, reach, &mut list)).collect();
        let mut is_kept = vec![true; nearest.len()];
        for (i, near) in nearest.iter().enumerate() {
            let Some(j) = near.filter(|&j| i < j && nearest[j] == Some(i)) else { continue };
            is_kept[j] = !self.merge_pair(i, j);
        }
        if is_kept.contains(&false) {
            retain_marked(&mut self.rates, &is_kept);
            self.particles.retain(&is_kept);
        }
    }

    /// The nearest particle, if it is nearer than `reach` (m) and no other one is as near; `list` is overwritten.
    fn nearest_of(&self, i: usize, reach: f64, list: &mut Vec<u32>) -> Option<usize> {
        let place = self.particles.position[i];
        let (mut nearest, mut second) = ((f64::INFINITY, None), f64::INFINITY);
        for image in self.neighbours.of(i, list).iter() {
            let j = image.index as usize;
            // Neither mirror images nor the buffer particles of open boundaries, which stand behind the water.
            if image.transform != 0 || j >= self.particles.len() {
                continue;
            }
            let distance = (self.particles.position[j] - place).norm();
            if distance < nearest.0 {
                second = nearest.0;
                nearest = (distance, Some(j));
            } else {
                second = second.min(distance);
            }
        }
        nearest.1.filter(|_| nearest.0 < reach && second > nearest.0 * (1.0 + EQUAL))
    }

    /// Makes one particle of two, in the place of the first; not so where the ground between them reaches above their water.
    fn merge_pair(&mut self, i: usize, j: usize) -> bool {
        let p = &self.particles;
        let (volume_i, volume_j) = (p.volume[i], p.volume[j]);
        let volume = volume_i + volume_j;
        let mean = |a: Vec2, b: Vec2| (a * volume_i + b * volume_j) / volume;
        let (area_i, area_j) = (volume_i / p.depth[i], volume_j / p.depth[j]);
        let level = |i: usize| p.depth[i] + self.bed_at(p.position[i]).elevation;
        let position = mean(p.position[i], p.position[j]);
        let depth = (area_i * level(i) + area_j * level(j)) / (area_i + area_j) - self.bed_at(position).elevation;
        if depth < p.depth[i].min(p.depth[j]) {
            return false;
        }
        let velocity = mean(p.velocity[i], p.velocity[j]);
        let smoothing_length = p.smoothing_length[i].max(p.smoothing_length[j]);
        let p = &mut self.particles;
        (p.position[i], p.velocity[i], p.volume[i]) = (position, velocity, volume);
        (p.depth[i], p.smoothing_length[i]) = (depth, smoothing_length);
        let (a, b) = (self.rates[i], self.rates[j]);
        self.rates[i] = Rates {
            acceleration: mean(a.acceleration, b.acceleration),
            depth_rate: (volume_i * a.depth_rate + volume_j * b.depth_rate) / volume,
            shift: mean(a.shift, b.shift),
            approach: a.approach.max(b.approach),
            reach: a.reach.min(b.reach),
        };
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::{Integrator, Stabilisation};
    use crate::particles::FluidSeed;
    use crate::physics::dimension::Dimension;
    use crate::solver::lagrangian::LagrangianSolver;
    use crate::solver::moving::MovingMethods;
    use crate::solver::testing::still_water;
    use crate::solver::{FlowProblem, FlowSolver};

    const LEVEL: f64 = 2.0;

    /// A lake of one dimension over a rough bed, with a particle in every cell and more of them at the given places (m).
    fn lake(more: &[f64]) -> LagrangianSolver {
        let rough = |place: Vec2| 0.3 * (3.0 * place.x).sin();
        let problem = FlowProblem { courant: 0.4, ..still_water((24, 1), 1.0, rough, |_| LEVEL) };
        let lattice = &problem.bed.lattice;
        let more = more.iter().map(|&x| Vec2::new(x, 0.5));
        let places = (0..lattice.len()).map(|cell| lattice.centre(cell)).chain(more);
        let seeds: Vec<FluidSeed> = places
            .map(|position| {
                let depth = LEVEL - problem.bed.at(position).map_or(0.0, |point| point.elevation);
                FluidSeed { position, volume: depth, depth }
            })
            .collect();
        solver(problem, seeds)
    }

    fn solver(problem: FlowProblem, seeds: Vec<FluidSeed>) -> LagrangianSolver {
        let methods = MovingMethods::new(Integrator::Leapfrog, Stabilisation::TwoShocks);
        LagrangianSolver::with_methods(problem, seeds, methods, Dimension::One)
    }

    fn sums(water: &MovingWater) -> (f64, Vec2, Vec2) {
        let p = &water.particles;
        (0..p.len()).fold((0.0, Vec2::ZERO, Vec2::ZERO), |(volume, place, momentum), i| {
            let v = p.volume[i];
            (volume + v, place + p.position[i] * v, momentum + p.velocity[i] * v)
        })
    }

    #[test]
    fn two_in_one_place_become_one_that_keeps_volume_centre_momentum_and_level() {
        let mut solver = lake(&[6.6]);
        let water = solver.state_mut();
        let last = water.particles.len() - 1;
        water.particles.velocity[last] = Vec2::new(1.0, -2.0);
        solver.restart();
        let before = sums(solver.state());
        solver.state_mut().merge();
        let water = solver.state();
        assert_eq!(water.particles.len(), last);
        let after = sums(water);
        assert!((after.0 - before.0).abs() < 1e-12 * before.0);
        assert!((after.1 - before.1).norm() < 1e-12 * before.1.norm());
        assert!((after.2 - before.2).norm() < 1e-12);
        for (place, depth) in water.particles.position.iter().zip(&water.particles.depth) {
            assert!((depth + water.bed_at(*place).elevation - LEVEL).abs() < 1e-14);
        }
    }

    #[test]
    fn a_lake_stays_at_rest_where_particles_were_merged() {
        let mut solver = lake(&[6.6, 15.3]);
        let before = solver.particles();
        for _ in 0..200 {
            let step = solver.choose_step().time_step;
            solver.advance(step).expect("a calm lake");
        }
        assert_eq!(solver.particles(), before - 2);
        let fastest = solver.state().particles.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(fastest < 1e-12, "{fastest} m/s");
    }

    #[test]
    fn apart_equally_near_or_behind_a_wall_they_stay_two() {
        for more in [vec![], vec![6.85], vec![6.6, 6.4]] {
            let mut solver = lake(&more);
            let before = solver.particles();
            solver.state_mut().merge();
            assert_eq!(solver.particles(), before, "{more:?}");
        }
        let mut problem = still_water((24, 1), 1.0, |_| 0.0, |_| LEVEL);
        problem.walls.push([Vec2::new(6.0, -1.0), Vec2::new(6.0, 2.0)]);
        let seed = |x| FluidSeed { position: Vec2::new(x, 0.5), volume: LEVEL, depth: LEVEL };
        let mut solver = solver(problem, vec![seed(5.9), seed(6.1)]);
        solver.state_mut().merge();
        assert_eq!(solver.particles(), 2);
    }
}
