//! What the water has at the start beside its depth.

use super::EulerianSolver;
use crate::math::Vec2;

impl EulerianSolver {
    /// Gives the water a velocity (m/s) at the start, by place (local coordinates).
    pub fn set_velocity(&mut self, velocity: impl Fn(Vec2) -> Vec2) {
        for (row, water) in self.state.water.iter_mut().enumerate() {
            for column in (0..water.depth.len()).filter(|&column| water.depth[column] > self.scale.dry_depth) {
                let place = self.lattice.centre(self.lattice.index(column - 1, row - 1));
                let discharge = velocity(place) * water.depth[column];
                (water.discharge_x[column], water.discharge_y[column]) = (discharge.x, discharge.y);
            }
        }
        if let Some(moving) = &mut self.moving {
            moving.set_velocity(velocity, &self.scale);
            moving.show(&mut self.state);
        }
        self.evaluate_primitive();
    }

    /// Notes what is there at the start.
    pub(super) fn begin(&mut self) {
        self.initial_volume = self.volume();
        self.note_initial_tracers();
        self.hand_out_bed();
        self.evaluate_primitive();
    }
}
