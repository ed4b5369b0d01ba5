//! Whether the velocities of the particles are those of the water that passes between them.
//!
//! Volume is carried by faces, momentum by particles. In steady flow both agree but for the second order of the spacing,
//!
//! ```text
//! (M85)  q_f = ½ (F_w + F_e, F_s + F_n),   ε = Σ |d v − q_f| / Σ max(|d v|, |q_f|)
//! ```
//!
//! with F the fluxes of volume through the four faces of a particle. Where the bed is too rough for the spacing they part: the faces
//! hold back or let go what the particle does not know of, and its velocity, a map of speeds and hazard after it, are wrong. Particles
//! beside walls, edges, gaps and dry ground are left out, and those in part: some of their faces carry nothing, or not all, whatever
//! the particle does.

use super::EulerianSolver;
use super::faces::{EAST, NORTH};
use super::state::State;
use crate::lattice::NEIGHBOURS;
use crate::math::Vec2;
use crate::solver::{DischargeCheck, DischargesInDoubt};

/// A particle is in doubt where the two differ by more than this share of the greater one: its speed may be twice the right one, or half of it.
const IN_DOUBT: f64 = 0.5;

impl EulerianSolver {
    /// Compares the discharges of the particles with those of their faces in the last step.
    pub(super) fn compare_discharges(&self) -> DischargeCheck {
        let (state, dry_depth) = (&self.state, self.scale.dry_depth);
        let mut check = DischargeCheck::default();
        for row in 1..=state.rows {
            for run in &self.active.work[row] {
                for column in run.clone() {
                    let is_open = |offset: &(isize, isize)| {
                        let (r, c) = (row.wrapping_add_signed(offset.1), column.wrapping_add_signed(offset.0));
                        state.primitive[r].depth[c] > dry_depth
                            && !self.walls.is_blocked((row, column), *offset)
                            && !self.passes.is_part((row, column), *offset)
                    };
                    let is_whole = !self.in_part.holds(row, column);
                    if state.primitive[row].depth[column] > dry_depth && is_whole && NEIGHBOURS.iter().all(is_open) {
                        check.add(discharges(state, row, column), || state.position(row, column));
                    }
                }
            }
        }
        check
    }
}

/// Discharge (m²/s) of a particle, and that of its faces.
fn discharges(state: &State, row: usize, column: usize) -> (Vec2, Vec2) {
    let water = &state.primitive[row];
    let own = Vec2::new(water.velocity_x[column], water.velocity_y[column]) * water.depth[column];
    let mean = |before: f64, behind: f64| 0.5 * (before + behind);
    let across = &state.flux[row][EAST].mass;
    let up = |row: usize| state.flux[row][NORTH].mass[column];
    (own, Vec2::new(mean(across[column - 1], across[column]), mean(up(row - 1), up(row))))
}

impl DischargeCheck {
    /// Adds a particle: its discharge and that of its faces (m²/s).
    fn add(&mut self, (own, at_faces): (Vec2, Vec2), place: impl FnOnce() -> Vec2) {
        let (greater, apart) = (own.norm().max(at_faces.norm()), (own - at_faces).norm());
        self.carried += greater;
        self.apart += apart;
        if apart > IN_DOUBT * greater {
            self.in_doubt += greater;
            if self.worst.is_none_or(|worst| apart > (worst.own - worst.at_faces).abs()) {
                self.worst = Some(DischargesInDoubt { own: own.norm(), at_faces: at_faces.norm(), place: place() });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{problem, run};
    use super::*;
    use crate::lattice::Lattice;
    use crate::solver::FlowSolver;

    /// A swing of water in a basin with a shore, after some steps.
    fn swing() -> EulerianSolver {
        let lattice = Lattice::new(Vec2::ZERO, 40, 30, 1.0);
        let bed = |cell: usize| 0.003 * (lattice.centre(cell) - Vec2::new(20.0, 15.0)).norm_squared();
        let elevation: Vec<f64> = (0..lattice.len()).map(bed).collect();
        let depth = (0..lattice.len())
            .map(|cell| (0.6 + 0.01 * (lattice.centre(cell).x - 20.0) - elevation[cell]).max(0.0))
            .collect();
        let mut solver = EulerianSolver::new(problem(lattice, elevation, depth));
        assert_eq!(solver.discharges(), None, "nothing before the first step");
        run(&mut solver, 60);
        solver
    }

    #[test]
    fn smooth_flow_is_carried_by_particles_as_by_their_faces() {
        let check = swing().discharges().unwrap();
        assert!(check.carried > 10.0, "{check:?}");
        // 0.014 and 0.007 were found: the swing turns along the shore, where hardly anything flows.
        assert!(check.apart < 0.03 * check.carried && check.in_doubt < 0.015 * check.carried, "{check:?}");
    }

    #[test]
    fn particles_that_are_faster_than_their_water_are_in_doubt_with_their_place() {
        let mut solver = swing();
        let before = solver.discharges().unwrap();
        for row in &mut solver.state.primitive[10..20] {
            row.velocity_x[5..15].iter_mut().for_each(|velocity| *velocity *= 4.0);
        }
        let check = solver.discharges().unwrap();
        let worst = check.worst.unwrap();
        assert!(check.in_doubt > 0.1 * check.carried && check.in_doubt > 10.0 * before.in_doubt, "{check:?}");
        // Padded rows 10 to 19 and columns 5 to 14 are those from 9 m and 4 m on.
        assert!((4.0..15.0).contains(&worst.place.x) && (9.0..20.0).contains(&worst.place.y), "{worst:?}");
        assert!((worst.own / worst.at_faces - 4.0).abs() < 1.0, "{worst:?}");
    }
}
