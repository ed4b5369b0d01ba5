//! The arrays of the Eulerian particles, row by row, padded by one ring of cells without terrain.
//!
//! The rows of all levels of a nested lattice lie in one stack ([`crate::lattice::Nest`]); a place is always the padded row and column of that stack, and each
//! row knows the spacing of its cells. Where a finer or coarser level stands for a cell, the cell is without terrain.
//!
//! Each group of quantities that one pass writes is a `Vec` of rows, so that a pass over rows in parallel writes its own row
//! of one group and reads its neighbours' rows of the others.

use rayon::prelude::*;

use super::concentrations::Tracers;
use super::rows::find_steps;
pub(crate) use super::rows::{
    FaceRow, Fastest, FluxRow, GradientRow, GroundRow, PrimitiveRow, Slot, WaterRow, sides, step_of_bed,
};
use crate::bed::{BedParticles, SHUT};
use crate::lattice::{Conforming, Lattice, Level, WaterInRow, WaterRows};
use crate::math::{MOST_LANES, Vec2};

/// All arrays; every row has two entries more than its level has columns, and some without terrain more for loops on lanes; every group has
/// `rows + 2` rows.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct State {
    lattice: Lattice,
    /// Rows of all levels.
    pub rows: usize,
    /// Edge (m) of the cells of each padded row.
    pub spacing: Vec<f64>,
    pub ground: Vec<GroundRow>,
    pub water: Vec<WaterRow>,
    pub primitive: Vec<PrimitiveRow>,
    pub gradient: Vec<GradientRow>,
    pub flux: Vec<FluxRow>,
    pub tracers: Tracers,
}

impl State {
    pub fn new(bed: &BedParticles, initial_depth: &[f64], gravity: f64) -> Self {
        let lattice = bed.lattice.clone();
        let rows = lattice.all_rows();
        let level_of = |row: usize| lattice.level_of_row(row.saturating_sub(1));
        let widths: Vec<usize> = (0..rows + 2).map(|row| level_of(row).columns + 2 + MOST_LANES - 1).collect();
        let ground = widths.iter().map(|&width| GroundRow::without_terrain(width));
        let mut ground: Vec<GroundRow> = ground.collect();
        let mut water: Vec<WaterRow> = widths.iter().map(|&width| WaterRow::dry(width)).collect();
        let datum = datum(bed, initial_depth);
        let is_here = |&index: &usize| bed.has_terrain(index) && lattice.is_leaf(index);
        for index in (0..lattice.len()).filter(is_here) {
            let (column, row) = bed.lattice.column_row(index);
            ground[row + 1].bed[column + 1] = bed.elevation[index] - datum;
            ground[row + 1].per_area[column + 1] = 1.0;
            ground[row + 1].friction[column + 1] = gravity * bed.manning[index] * bed.manning[index];
            water[row + 1].depth[column + 1] = initial_depth[index].max(0.0);
        }
        for place in lattice.conforming().into_iter().flat_map(Conforming::places) {
            let (column, row) = lattice.column_row(place);
            if ground[row + 1].has_terrain(column + 1) {
                ground[row + 1].per_area[column + 1] = lattice.cell_area() / lattice.area_of(place);
            }
        }
        for part in bed.cover.cells().iter().filter(|part| lattice.is_leaf(part.cell)) {
            let (column, row) = bed.lattice.column_row(part.cell);
            ground[row + 1].per_area[column + 1] = 1.0 / part.area;
        }
        find_steps(&mut ground);
        let primitive =
            |water: &WaterRow| PrimitiveRow { depth: water.depth.clone(), ..PrimitiveRow::dry(water.depth.len()) };
        State {
            spacing: (0..rows + 2).map(|row| level_of(row).spacing).collect(),
            rows,
            primitive: water.iter().map(primitive).collect(),
            gradient: widths.iter().map(|&width| GradientRow::level(width)).collect(),
            flux: widths.iter().map(|&width| [(); 2].map(|()| FaceRow::without_flow(width))).collect(),
            ground,
            water,
            lattice,
            tracers: Tracers::default(),
        }
    }

    /// Columns of the level to which a padded row belongs.
    pub fn columns(&self, row: usize) -> usize {
        self.level(row).columns
    }

    /// The padded rows of some levels, with those around them.
    pub fn rows_of(&self, levels: &std::ops::Range<usize>) -> std::ops::Range<usize> {
        let (first, last) = (self.lattice.level(levels.start), self.lattice.level(levels.end - 1));
        let end = last.first_row + last.rows;
        // Cells that follow lines belong to the finest level.
        let end = self.lattice.conforming().map_or(end, |conforming| conforming.rows().end.max(end));
        first.first_row..end + 2
    }

    /// Padded rows and columns of the level to which a padded row belongs; none of the rows around and between levels.
    pub fn bounds(&self, row: usize) -> Option<[std::ops::Range<usize>; 2]> {
        let level = self.level(row);
        if let Some(conforming) = self.conforming_in(row) {
            let rows = conforming.rows();
            return Some([rows.start + 1..rows.end + 1, 1..level.columns + 1]);
        }
        let first = level.first_row + 1;
        let is_cells = row > 0 && level.holds_row(row - 1);
        is_cells.then(|| [first..first + level.rows, 1..level.columns + 1])
    }

    /// The padded rows of cells that follow lines.
    pub fn rows_apart(&self) -> std::ops::Range<usize> {
        self.lattice.conforming().map_or(0..0, |made| made.rows().start + 1..made.rows().end + 1)
    }

    /// The cells that follow lines, where a padded row is one of theirs.
    fn conforming_in(&self, row: usize) -> Option<&Conforming> {
        self.lattice.conforming().filter(|made| made.rows().contains(&row.wrapping_sub(1)))
    }

    /// The level to which a padded row belongs; its rows count without padding.
    pub fn level(&self, row: usize) -> Level {
        self.lattice.level_of_row(row.saturating_sub(1))
    }

    /// Whether there is terrain at a padded cell; there is none outside all rows.
    pub fn has_terrain(&self, row: usize, column: usize) -> bool {
        self.ground.get(row).is_some_and(|ground| column < ground.bed.len() && ground.has_terrain(column))
    }

    /// Whether other cells stand for a padded cell of a level. Cells that follow lines have no neighbours in the rows: all about them is elsewhere.
    /// Where no level has terrain nothing is: an edge of the terrain between levels is as one on a lattice alone.
    pub fn is_elsewhere(&self, row: usize, column: usize) -> bool {
        if let Some(conforming) = self.lattice.conforming()
            && (conforming.rows().start..conforming.rows().end + 2).contains(&row)
        {
            return !self.has_terrain(row, column);
        }
        let of_level = self.bounds(row).is_some_and(|[_, columns]| columns.contains(&column));
        of_level && {
            let index = self.lattice.index(column - 1, row - 1);
            !self.lattice.is_leaf(index) && self.leaf_with_terrain(index)
        }
    }

    /// Whether any cell that stands for the place of a square has terrain.
    fn leaf_with_terrain(&self, index: usize) -> bool {
        let lattice = &self.lattice;
        let Some(nest) = lattice.nest().filter(|_| lattice.level_count() > 1) else { return true };
        let (column, row) = lattice.column_row(index);
        let number = nest.number_of_row(row);
        let (column, row) = (column << number, (row - nest.levels()[number].first_row) << number);
        let step = 1_usize << nest.level_of(column, row).min(number);
        let within = |from: usize, count: usize| (from..(from + (1 << number)).min(count)).step_by(step);
        let places = within(row, lattice.rows).flat_map(|r| within(column, lattice.columns).map(move |c| (c, r)));
        let mut leaves = places.map(|(c, r)| lattice.leaf(c, r));
        leaves.any(|leaf| {
            let (column, row) = lattice.column_row(leaf);
            !lattice.is_leaf(leaf) || self.has_terrain(row + 1, column + 1)
        })
    }

    /// The area (m²) of a padded cell with terrain.
    pub fn area(&self, (row, column): (usize, usize)) -> f64 {
        self.spacing[row] * self.spacing[row] / self.ground[row].per_area[column]
    }

    /// The runs of padded columns of a row that no other level stands for.
    pub fn own_runs(&self, row: usize) -> Vec<std::ops::Range<usize>> {
        let Some([_, columns]) = self.bounds(row) else { return Vec::new() };
        if self.lattice.nest().is_none() {
            return vec![columns];
        }
        let mut runs: Vec<std::ops::Range<usize>> = Vec::new();
        for column in columns.filter(|&column| !self.is_elsewhere(row, column)) {
            match runs.last_mut() {
                Some(run) if run.end == column => run.end += 1,
                _ => runs.push(column..column + 1),
            }
        }
        runs
    }

    /// The lattice of all particles.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Takes a share of what leaves over a side of a cell.
    pub fn reduce(&mut self, (Slot { row, direction, column }, sign): (Slot, f64), share: f64) {
        let face = &mut self.flux[row][direction];
        if face.mass[column] * sign > 0.0 {
            face.mass[column] *= share;
            face.tangential[column] *= share;
        }
    }

    /// Brings a padded cell that leaves the work to rest: no velocity, no gradient, no flux; its film stays.
    pub fn rest(&mut self, row: usize, column: usize) {
        let primitive = &mut self.primitive[row];
        primitive.depth[column] = self.water[row].depth[column];
        primitive.velocity_x[column] = 0.0;
        primitive.velocity_y[column] = 0.0;
        let gradient = &mut self.gradient[row];
        for component in [
            &mut gradient.surface_x,
            &mut gradient.surface_y,
            &mut gradient.depth_x,
            &mut gradient.depth_y,
            &mut gradient.u_x,
            &mut gradient.u_y,
            &mut gradient.v_x,
            &mut gradient.v_y,
        ] {
            component[column] = 0.0;
        }
        for face in &mut self.flux[row] {
            for component in [&mut face.mass, &mut face.tangential, &mut face.normal_left, &mut face.normal_right] {
                component[column] = 0.0;
            }
        }
    }

    /// Takes a padded cell out of the rows, for which a cell that moves stands.
    pub fn take_out(&mut self, row: usize, column: usize) {
        self.water[row].clear(column);
        self.rest(row, column);
        (self.ground[row].bed[column], self.ground[row].per_area[column]) = (SHUT, 0.0);
    }

    /// Local coordinates of the centre of a padded cell (m).
    pub fn position(&self, row: usize, column: usize) -> Vec2 {
        if self.conforming_in(row).is_some() {
            return self.lattice.centre(self.lattice.index(column - 1, row - 1));
        }
        position_on(self.level(row), (row, column))
    }

    /// The middle (local coordinates, m) of the face between a padded cell and one beside it, which may be in the ring around its level.
    pub fn middle(&self, cell: (usize, usize), other: (usize, usize)) -> Vec2 {
        let level = self.level(cell.0);
        (position_on(level, cell) + position_on(level, other)) * 0.5
    }

    /// Volume of all water (m³), summed row by row so that the threads do not matter.
    pub fn volume(&self) -> f64 {
        let row_sums: Vec<f64> = self.water.par_iter().map(|row| row.depth.iter().sum::<f64>()).collect();
        let of_level = |level: Level| {
            let rows = &row_sums[level.first_row + 1..][..level.rows];
            rows.iter().sum::<f64>() * level.spacing * level.spacing
        };
        let conforming = self.lattice.conforming().map_or(0..0, |made| made.rows());
        let of_conforming = row_sums[conforming.start + 1..conforming.end + 1].iter().sum::<f64>();
        self.lattice.levels().map(of_level).sum::<f64>() + of_conforming * self.lattice.cell_area()
    }

    /// The number of the level to which a padded row belongs.
    pub fn level_number(&self, row: usize) -> usize {
        self.lattice.nest().map_or(0, |nest| nest.number_of_row(row.saturating_sub(1)))
    }

    /// The greatest speeds of the rows of a level, the signal speed per spacing, times the finest spacing.
    pub fn fastest(&self, level: usize) -> Fastest {
        let rows = self.rows_of(&(level..level + 1));
        let rows = self.primitive[rows.clone()].iter().zip(&self.spacing[rows]);
        let of_finest = |(row, spacing): (&PrimitiveRow, &f64)| Fastest {
            signal_speed: row.fastest.signal_speed * (self.lattice.spacing / spacing),
            ..row.fastest
        };
        rows.map(of_finest).fold(Fastest::default(), |greatest, row| Fastest {
            flow_speed: row.flow_speed.max(greatest.flow_speed),
            ..if row.signal_speed > greatest.signal_speed || row.signal_speed.is_nan() { row } else { greatest }
        })
    }

    /// The spacing of the finest level over that of a padded row: signal speeds are compared as those of cells of the finest level.
    pub fn haste(&self, row: usize) -> f64 {
        self.lattice.spacing / self.spacing[row]
    }
}

impl WaterRows for State {
    fn row(&self, row: usize) -> WaterInRow<'_> {
        let WaterRow { depth, discharge_x, discharge_y } = &self.water[row + 1];
        let inside = 1..self.columns(row + 1) + 1;
        WaterInRow {
            depth: &depth[inside.clone()],
            discharge_x: &discharge_x[inside.clone()],
            discharge_y: &discharge_y[inside],
        }
    }

    fn concentration(&self, tracer: usize, row: usize) -> &[f64] {
        &self.tracers.seen(tracer, row + 1)[1..self.columns(row + 1) + 1]
    }
}

/// The centre of a padded cell (row, column), as a level counts.
pub(super) fn position_on(level: Level, (row, column): (usize, usize)) -> Vec2 {
    let up = row as f64 - level.first_row as f64;
    Vec2::new((column as f64 - 0.5) * level.spacing, (up - 0.5) * level.spacing)
}

/// Mean level (m) of the water by depth, from which elevations are counted here, or the lowest bed where there is none: a lake in
/// the mountains then rests as still as one at the sea, because its height costs no digits. To a 1024th of a metre, so that the order in which
/// cells are summed does not show: that of a mirror image is another one.
pub(crate) fn datum(bed: &BedParticles, depth: &[f64]) -> f64 {
    let lattice = &bed.lattice;
    let wet = || (0..lattice.len()).filter(|&i| bed.has_terrain(i) && depth[i] > 0.0 && lattice.is_leaf(i));
    let water: f64 = wet().map(|i| depth[i]).sum();
    if water > 0.0 {
        let mean = wet().map(|i| depth[i] * (bed.elevation[i] + depth[i])).sum::<f64>() / water;
        return (mean * 1024.0).round() / 1024.0;
    }
    let lowest = bed.elevation.iter().copied().fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { lowest } else { 0.0 }
}
