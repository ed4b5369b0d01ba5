//! What is kept of the cells of one row: ground, water, gradients, and what flows through their faces.

use crate::bed::SHUT;

/// The two directions in which a cell owns a face.
pub(crate) const EAST: usize = 0;
pub(crate) const NORTH: usize = 1;

/// The ground; only the bed of a dam that breaks, and one that moves as prescribed, change during a run.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
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
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct WaterRow {
    /// Depth d (m).
    pub depth: Vec<f64>,
    /// Discharge d v (m²/s) to the east.
    pub discharge_x: Vec<f64>,
    /// Discharge to the north.
    pub discharge_y: Vec<f64>,
}

/// What the pairs see of a particle: at the start of the step, then after its first stage.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
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
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Fastest {
    pub signal_speed: f64,
    pub flow_speed: f64,
    pub column: usize,
    pub row: usize,
}

/// Gradients of surface, depth and velocity.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
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

impl GroundRow {
    /// A row of so many cells without terrain.
    pub fn without_terrain(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        GroundRow { bed: vec![SHUT; len], friction: zeros(), step: zeros(), per_area: zeros() }
    }
}

impl WaterRow {
    /// A row of so many particles without water.
    pub fn dry(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        WaterRow { depth: zeros(), discharge_x: zeros(), discharge_y: zeros() }
    }

    /// Takes the water of a column out.
    pub fn clear(&mut self, column: usize) {
        (self.depth[column], self.discharge_x[column], self.discharge_y[column]) = (0.0, 0.0, 0.0);
    }
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

    /// What passes a face.
    pub fn at(&self, column: usize) -> [f64; 4] {
        [self.mass[column], self.tangential[column], self.normal_left[column], self.normal_right[column]]
    }

    /// Lets so much pass a face.
    pub fn put(&mut self, column: usize, passing: [f64; 4]) {
        let all = [&mut self.mass, &mut self.tangential, &mut self.normal_left, &mut self.normal_right];
        all.into_iter().zip(passing).for_each(|(fluxes, passing)| fluxes[column] = passing);
    }

    /// Lets nothing flow through a face.
    pub fn clear(&mut self, column: usize) {
        self.put(column, [0.0; 4]);
    }

    /// Multiplies all that passes a face.
    pub fn scale(&mut self, column: usize, share: f64) {
        for fluxes in [&mut self.mass, &mut self.tangential, &mut self.normal_left, &mut self.normal_right] {
            fluxes[column] *= share;
        }
    }
}

/// What flows through the faces of one direction, per metre of face; the cell itself is the owner, "left".
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
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

/// Where the rows of fluxes have a face: row, direction and column.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Slot {
    pub row: usize,
    pub direction: usize,
    pub column: usize,
}

/// The faces of a padded cell (row, column) in the order of [`NEIGHBOURS`](crate::lattice::NEIGHBOURS), each with the sign of what leaves the cell.
pub(crate) fn sides((row, column): (usize, usize)) -> [(Slot, f64); 4] {
    let slot = |row: usize, direction: usize, column: usize| Slot { row, direction, column };
    [
        (slot(row, EAST, column), 1.0),
        (slot(row, EAST, column - 1), -1.0),
        (slot(row, NORTH, column), 1.0),
        (slot(row - 1, NORTH, column), -1.0),
    ]
}

/// The place (row, column) of the other cell of a face that a padded cell owns.
pub(crate) fn other((row, column): (usize, usize), direction: usize) -> (usize, usize) {
    if direction == EAST { (row, column + 1) } else { (row + 1, column) }
}

/// Fills the steps of the bed.
pub(super) fn find_steps(ground: &mut [GroundRow]) {
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
    // Rows beside a level may be shorter.
    if !ground[row].has_terrain(column) {
        return 0.0;
    }
    let bed = ground[row].bed[column];
    let neighbours =
        [(row, column - 1), (row, column + 1), (row - 1, column), (row + 1, column)].map(|(r, c)| ground[r].bed[c]);
    let with_terrain = neighbours.into_iter().filter(|&neighbour| neighbour < SHUT && bed < SHUT);
    with_terrain.map(|neighbour| (neighbour - bed).abs()).fold(0.0, f64::max)
}
