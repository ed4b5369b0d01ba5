//! The arrays of the Eulerian particles, row by row, padded by one ring of cells without terrain.
//!
//! Each group of quantities that one pass writes is a `Vec` of rows, so that a pass over rows in parallel writes its own row
//! of one group and reads its neighbours' rows of the others.

use rayon::prelude::*;

use crate::bed::{BedParticles, SHUT};
use crate::lattice::{WaterInRow, WaterRows};
use crate::math::{MOST_LANES, Vec2};

/// The ground; only the bed of a dam that breaks, and one that moves as prescribed, change during a run.
#[derive(Clone, Debug)]
pub(crate) struct GroundRow {
    /// Bed elevation z_b (m), [`SHUT`] where there is none.
    pub bed: Vec<f64>,
    /// g n² (m^(1/3)).
    pub friction: Vec<f64>,
    /// Greatest step of the bed to one of the four neighbours (m), those without terrain left out.
    pub step: Vec<f64>,
    /// 1/φ of (M13), 0 without terrain: what passes a boundary stays out of the water of the cell beyond.
    pub per_area: Vec<f64>,
}

impl GroundRow {
    /// Whether there is terrain at a padded column.
    pub fn has_terrain(&self, column: usize) -> bool {
        self.bed[column] < SHUT
    }
}

/// The conserved quantities: of the start of the step until its first stage has been taken, with half of that stage's gain until the
/// second has.
#[derive(Clone, Debug)]
pub(crate) struct WaterRow {
    /// Depth d (m).
    pub depth: Vec<f64>,
    /// Discharge d v (m²/s) to the east.
    pub discharge_x: Vec<f64>,
    /// Discharge to the north.
    pub discharge_y: Vec<f64>,
}

/// What the pairs see of a particle: at the start of the step, then after its first stage.
#[derive(Clone, Debug)]
pub(crate) struct PrimitiveRow {
    /// Depth d (m).
    pub depth: Vec<f64>,
    /// Velocity (m/s).
    pub velocity_x: Vec<f64>,
    pub velocity_y: Vec<f64>,
    /// Greatest signal speed |v| + c of the row (m/s), its column, and the greatest |v|.
    pub fastest: Fastest,
}

/// Greatest speeds and where the signal speed is greatest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Fastest {
    pub signal_speed: f64,
    pub flow_speed: f64,
    pub column: usize,
    pub row: usize,
}

/// Gradients of surface, depth and velocity.
#[derive(Clone, Debug)]
pub(crate) struct GradientRow {
    pub surface_x: Vec<f64>,
    pub surface_y: Vec<f64>,
    pub depth_x: Vec<f64>,
    pub depth_y: Vec<f64>,
    /// ∂u/∂x, ∂u/∂y, ∂v/∂x, ∂v/∂y (1/s).
    pub u_x: Vec<f64>,
    pub u_y: Vec<f64>,
    pub v_x: Vec<f64>,
    pub v_y: Vec<f64>,
}

impl PrimitiveRow {
    /// A row of so many particles without water.
    pub fn dry(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        PrimitiveRow { depth: zeros(), velocity_x: zeros(), velocity_y: zeros(), fastest: Fastest::default() }
    }
}

impl GradientRow {
    /// A row of so many particles with no slope of anything.
    pub fn level(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        GradientRow {
            surface_x: zeros(),
            surface_y: zeros(),
            depth_x: zeros(),
            depth_y: zeros(),
            u_x: zeros(),
            u_y: zeros(),
            v_x: zeros(),
            v_y: zeros(),
        }
    }
}

impl FaceRow {
    /// So many faces through which nothing flows.
    pub fn without_flow(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        FaceRow { mass: zeros(), tangential: zeros(), normal_left: zeros(), normal_right: zeros() }
    }

    /// Multiplies all that passes a face.
    pub fn scale(&mut self, column: usize, share: f64) {
        for fluxes in [&mut self.mass, &mut self.tangential, &mut self.normal_left, &mut self.normal_right] {
            fluxes[column] *= share;
        }
    }
}

/// What flows through the faces of one direction, per metre of face; the cell itself is the owner, "left".
#[derive(Clone, Debug)]
pub(crate) struct FaceRow {
    /// Volume from left to right (m²/s).
    pub mass: Vec<f64>,
    /// Tangential momentum that goes with it (m³/s²).
    pub tangential: Vec<f64>,
    /// Normal momentum that the left particle loses (m³/s²).
    pub normal_left: Vec<f64>,
    /// Normal momentum that the right particle gains (m³/s²).
    pub normal_right: Vec<f64>,
}

/// The faces that a row owns: to the east and to the north.
pub(crate) type FluxRow = [FaceRow; 2];

/// All arrays; every row has `columns + 2` entries, and some without terrain more for loops on lanes; every group has `rows + 2` rows.
pub(crate) struct State {
    pub columns: usize,
    pub rows: usize,
    pub ground: Vec<GroundRow>,
    pub water: Vec<WaterRow>,
    pub primitive: Vec<PrimitiveRow>,
    pub gradient: Vec<GradientRow>,
    pub flux: Vec<FluxRow>,
}

impl State {
    pub fn new(bed: &BedParticles, initial_depth: &[f64], gravity: f64) -> Self {
        let (columns, rows) = (bed.lattice.columns, bed.lattice.rows);
        let width = columns + 2 + MOST_LANES - 1;
        let zeros = || vec![0.0; width];
        let face = || FaceRow::without_flow(width);
        let mut ground =
            vec![GroundRow { bed: vec![SHUT; width], friction: zeros(), step: zeros(), per_area: zeros() }; rows + 2];
        let mut water = vec![WaterRow { depth: zeros(), discharge_x: zeros(), discharge_y: zeros() }; rows + 2];
        let datum = datum(bed, initial_depth);
        for index in (0..bed.lattice.len()).filter(|&index| bed.has_terrain(index)) {
            let (column, row) = bed.lattice.column_row(index);
            ground[row + 1].bed[column + 1] = bed.elevation[index] - datum;
            ground[row + 1].per_area[column + 1] = 1.0;
            ground[row + 1].friction[column + 1] = gravity * bed.manning[index] * bed.manning[index];
            water[row + 1].depth[column + 1] = initial_depth[index].max(0.0);
        }
        for part in bed.cover.cells() {
            let (column, row) = bed.lattice.column_row(part.cell);
            ground[row + 1].per_area[column + 1] = 1.0 / part.area;
        }
        find_steps(&mut ground);
        let primitive =
            water.iter().map(|water| PrimitiveRow { depth: water.depth.clone(), ..PrimitiveRow::dry(width) }).collect();
        State {
            columns,
            rows,
            ground,
            water,
            primitive,
            gradient: vec![GradientRow::level(width); rows + 2],
            flux: vec![[face(), face()]; rows + 2],
        }
    }

    /// Whether there is terrain at a padded cell.
    pub fn has_terrain(&self, row: usize, column: usize) -> bool {
        self.ground[row].has_terrain(column)
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

    /// Local coordinates of the centre of a padded cell (m).
    pub fn position(row: usize, column: usize, spacing: f64) -> Vec2 {
        Vec2::new((column as f64 - 0.5) * spacing, (row as f64 - 0.5) * spacing)
    }

    /// Volume of all water (m³), summed row by row so that the threads do not matter.
    pub fn volume(&self, spacing: f64) -> f64 {
        let row_sums: Vec<f64> = self.water.par_iter().map(|row| row.depth.iter().sum::<f64>()).collect();
        row_sums.iter().sum::<f64>() * spacing * spacing
    }

    /// The greatest speeds of all rows.
    pub fn fastest(&self) -> Fastest {
        self.primitive.iter().map(|row| row.fastest).fold(Fastest::default(), |greatest, row| Fastest {
            flow_speed: row.flow_speed.max(greatest.flow_speed),
            ..if row.signal_speed > greatest.signal_speed || row.signal_speed.is_nan() { row } else { greatest }
        })
    }
}

impl WaterRows for State {
    fn row(&self, row: usize) -> WaterInRow<'_> {
        let WaterRow { depth, discharge_x, discharge_y } = &self.water[row + 1];
        let inside = 1..self.columns + 1;
        WaterInRow {
            depth: &depth[inside.clone()],
            discharge_x: &discharge_x[inside.clone()],
            discharge_y: &discharge_y[inside],
        }
    }
}

/// Fills the steps of the bed.
fn find_steps(ground: &mut [GroundRow]) {
    for row in 1..ground.len() - 1 {
        for column in 1..ground[row].bed.len() - 1 {
            ground[row].step[column] = step_of_bed(ground, row, column);
        }
    }
}

/// The greatest step of the bed (m) from a padded cell to one of its four neighbours; 0 in the ring around the lattice.
pub(crate) fn step_of_bed(ground: &[GroundRow], row: usize, column: usize) -> f64 {
    if row == 0 || column == 0 || row + 1 >= ground.len() || column + 1 >= ground[row].bed.len() {
        return 0.0;
    }
    let bed = ground[row].bed[column];
    let neighbours =
        [(row, column - 1), (row, column + 1), (row - 1, column), (row + 1, column)].map(|(r, c)| ground[r].bed[c]);
    let with_terrain = neighbours.into_iter().filter(|&neighbour| neighbour < SHUT && bed < SHUT);
    with_terrain.map(|neighbour| (neighbour - bed).abs()).fold(0.0, f64::max)
}

/// Mean level (m) of the water by depth, from which elevations are counted here, or the lowest bed where there is none: a lake in
/// the mountains then rests as still as one at the sea, because its height costs no digits.
pub(crate) fn datum(bed: &BedParticles, depth: &[f64]) -> f64 {
    let wet = || (0..bed.lattice.len()).filter(|&i| bed.has_terrain(i) && depth[i] > 0.0);
    let water: f64 = wet().map(|i| depth[i]).sum();
    if water > 0.0 {
        return wet().map(|i| depth[i] * (bed.elevation[i] + depth[i])).sum::<f64>() / water;
    }
    let lowest = bed.elevation.iter().copied().fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { lowest } else { 0.0 }
}
