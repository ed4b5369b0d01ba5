//! Moving particles onto the lattice, each with its whole volume: cell c gets from particle j the share
//! W(|x_j − x_c|, h_j) max(η_j − z_c, 0), divided by the sum of these over all cells of terrain.
//!
//! So the volume is kept to rounding, and no hill above the water gets wet. A particle whose support holds no such cell gives
//! its volume to the cell it lies in.

use super::MovingWater;
use crate::lattice::{Lattice, Span, WaterOnLattice};
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::physics::kernel::CubicSpline;

/// The latest grids, and the columns that hold water in each row.
#[derive(Clone, Debug)]
pub struct Gridding {
    depth: Vec<f64>,
    discharge_x: Vec<f64>,
    discharge_y: Vec<f64>,
    /// First and one past the last column, per row, of this update and the one before.
    now: Vec<(u32, u32)>,
    before: Vec<(u32, u32)>,
    spans: Vec<Span>,
    weights: Vec<(u32, f64)>,
}

impl Gridding {
    /// Dry grids.
    pub fn new(lattice: &Lattice) -> Self {
        let dry = vec![0.0; lattice.len()];
        let nothing = vec![(u32::MAX, 0); lattice.rows];
        Gridding {
            depth: dry.clone(),
            discharge_x: dry.clone(),
            discharge_y: dry,
            now: nothing.clone(),
            before: nothing,
            spans: Vec::new(),
            weights: Vec::new(),
        }
    }

    /// The latest grids.
    pub fn water(&self) -> WaterOnLattice<'_> {
        WaterOnLattice {
            depth: &self.depth,
            discharge_x: &self.discharge_x,
            discharge_y: &self.discharge_y,
            spans: &self.spans,
        }
    }

    /// Grids the particles anew.
    pub fn update(&mut self, water: &MovingWater) {
        let lattice = &water.bed.lattice;
        self.clear(lattice);
        let kernel = CubicSpline::new(water.dimension);
        let area = match water.dimension {
            Dimension::One => lattice.spacing,
            Dimension::Two => lattice.cell_area(),
        };
        for j in 0..water.particles.len() {
            self.weigh(water, &kernel, j);
            let total: f64 = self.weights.iter().map(|&(_, weight)| weight).sum();
            for &(cell, weight) in &self.weights {
                let depth = water.particles.volume[j] * weight / (total * area);
                let cell = cell as usize;
                self.depth[cell] += depth;
                self.discharge_x[cell] += depth * water.particles.velocity[j].x;
                self.discharge_y[cell] += depth * water.particles.velocity[j].y;
                let (column, row) = lattice.column_row(cell);
                let (from, to) = &mut self.now[row];
                *from = (*from).min(column as u32);
                *to = (*to).max(column as u32 + 1);
            }
        }
        self.spans.clear();
        for (row, (now, before)) in self.now.iter().zip(&self.before).enumerate() {
            let (from, to) = (now.0.min(before.0), now.1.max(before.1));
            if from < to {
                self.spans.push(Span { row: row as u32, from, to });
            }
        }
    }

    fn clear(&mut self, lattice: &Lattice) {
        std::mem::swap(&mut self.now, &mut self.before);
        for (row, &(from, to)) in self.before.iter().enumerate() {
            if from < to {
                let cells = row * lattice.columns + from as usize..row * lattice.columns + to as usize;
                self.depth[cells.clone()].fill(0.0);
                self.discharge_x[cells.clone()].fill(0.0);
                self.discharge_y[cells].fill(0.0);
            }
        }
        self.now.fill((u32::MAX, 0));
    }

    /// Lists the cells of particle `j` with their weights, at least one.
    fn weigh(&mut self, water: &MovingWater, kernel: &CubicSpline, j: usize) {
        let lattice = &water.bed.lattice;
        let (place, h) = (water.particles.position[j], water.particles.smoothing_length[j]);
        let surface = water.particles.depth[j] + water.bed_points[j].elevation;
        let reach = CubicSpline::SUPPORT * h;
        let first = |value: f64| ((value - reach) / lattice.spacing).max(0.0) as usize;
        let last = |value: f64, count: usize| (((value + reach) / lattice.spacing).max(0.0) as usize).min(count - 1);
        self.weights.clear();
        for row in first(place.y)..=last(place.y, lattice.rows) {
            for column in first(place.x)..=last(place.x, lattice.columns) {
                let cell = lattice.index(column, row);
                let depth = surface - water.bed.elevation[cell];
                let weight = depth * kernel.value((lattice.centre(cell) - place).norm(), 1.0 / h);
                // Not a number (no terrain) compares as false.
                if depth > 0.0 && weight > 0.0 {
                    self.weights.push((cell as u32, weight));
                }
            }
        }
        if self.weights.is_empty() {
            let size = lattice.size();
            let inside = |value: f64, most: f64| value.clamp(0.0, most - 0.5 * lattice.spacing);
            let nearest = Vec2::new(inside(place.x, size.x), inside(place.y, size.y));
            self.weights.extend(lattice.cell_at(nearest).map(|cell| (cell as u32, 1.0)));
        }
    }
}
