//! Cells that move with their water (motion `lagrangian`): the scheme of the resting ones on a Voronoi partition.
//!
//! Each particle has a volume V and a momentum P = V v and moves with w. What passes a face is the Riemann flux in the frame of the face, by the same
//! reconstruction as between resting cells:
//!
//! ```text
//! (M105)  ∇X_i = (1/A_i) Σ_j l (X_j − X_i)(n/2 + c/r)                   c the way from the middle of both particles to that of the face
//! (M106)  w_f = ½ (w_i + w_j)·n + (w_i − w_j)·c/r
//! (M107)  (F_d, F_m) = flux(d_l, u_l − w_f; d_r, u_r − w_f),  F_n = F_m + w_f F_d
//! (M108)  dV_i/dt = −Σ l F_d,   dP_i/dt = −Σ l {[F_n − g d_l²/2 + g (d_i + d_iR) a_1/2] n + F_d v_t t},   dx_i/dt = w_i
//! (M109)  w_i = κ_i v_i + (D_i/√A_i)(s_i − x_i),  D_i = max_j |(κ_j v_j − κ_i v_i)·n|     s_i the centroid of the cell
//!         κ_i = [1 − ρ_i/max(d_i, |∇z_i| √A_i)]₊,  ρ_i = max_j |z_j − z_i − ∇z_i·(x_j − x_i)|
//! ```
//!
//! Cells go with their water as far as the bed under and about them is a plane: in pits and on rough ground, where the water does not go as the
//! cell would, they rest. Pinned and dry ones have κ = 0; with κ = 0 everywhere this is the scheme of the lattice. (M105) is exact for planes
//! on any Voronoi partition, (M106) is of `Springel2010`. Where a bank rises out of the water ∇η is that of the other faces, as in (M97), and the
//! level goes on with it beyond the face.
//! Cells rest beside all that only resting cells know ([`region`]): there the rows of the lattice and the partition have cells in common, the pinned
//! ones, so that boundaries, walls, dams, sources and sections know nothing of cells that move.

mod border;
mod exchange;
mod flux;
mod geometry;
mod gradient;
mod gridding;
mod ground;
mod motion;
mod region;
#[cfg(test)]
mod tests;
mod tracers;
mod update;

use std::collections::BTreeSet;

use super::Scale;
use super::general_faces::{Passing, Place, Seen};
use super::state::{Slot, State};
use crate::math::Vec2;
use crate::triangulation::Triangulation;
use geometry::Chunk;
use gridding::Gridded;
use ground::Ground;
use motion::Pace;
use region::{Region, Square};

/// Cells of near numbers that one thread takes at a time.
const CHUNK: usize = 256;

/// What a number of the partition stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
enum Cell {
    /// A cell that rests in the rows, at a padded place.
    Fixed(Place),
    /// One that rests, with its place in the rows.
    Pinned(Place),
    /// One that moves.
    Free,
    /// None any more.
    Gone,
}

impl Cell {
    fn is_fixed(self) -> bool {
        matches!(self, Cell::Fixed(_))
    }
}

/// What a cell holds: of the start of the step until its first stage has been taken, with half of that stage's gain until the second has.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
struct Held {
    /// V (m³).
    volume: f64,
    /// P (m⁴/s).
    momentum: Vec2,
    /// Where it is then.
    place: Vec2,
}

/// Gradients of surface, depth and velocity of a cell, and ρ (m), which stands for the step of the bed beside it.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
struct Slopes {
    of: [Vec2; 4],
    step: f64,
}

/// All cells that move, with those beside them; arrays by the numbers of the partition.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct MovingCells {
    mesh: Triangulation,
    cells: Vec<Cell>,
    /// Of [`Cell::Fixed`] and [`Cell::Pinned`] all numbers.
    fixed: Vec<u32>,
    pinned: Vec<u32>,
    ground: Ground,
    region: Region,
    held: Vec<Held>,
    /// What it makes of it.
    next: Vec<Held>,
    has_moved: Vec<bool>,
    is_touched: Vec<bool>,
    /// What the faces see.
    seen: Vec<Seen>,
    friction: Vec<f64>,
    area: Vec<f64>,
    centroid: Vec<Vec2>,
    /// κ, and w (m/s).
    mobility: Vec<f64>,
    motion: Vec<Vec2>,
    slopes: Vec<Slopes>,
    /// The share of its outflow that a cell can give, while outflows are limited; 1 else.
    share: Vec<f64>,
    /// Wet cells with a rim of two: water passes one cell in a stage.
    is_active: Vec<bool>,
    active: Vec<u32>,
    was_active: Vec<bool>,
    /// Whether one beside it that does not rest in the rows is not active.
    is_beside_idle: Vec<bool>,
    /// Of pinned cells whether the rows have what they hold.
    is_shown: Vec<bool>,
    /// Sides of the pinned cells towards squares that rest, one cell after the other, and where those of each end.
    all_sides: Vec<(Slot, f64)>,
    side_ends: Vec<u32>,
    /// The chunks that have to be looked at again.
    is_stale: Vec<bool>,
    chunks: Vec<Chunk>,
    links: Vec<Vec<u32>>,
    passing: Vec<Vec<Passing>>,
    gridded: Gridded,
    tracers: tracers::OfAll,
    pace: Pace,
    /// Whether the partition is lost: two cells came to one place. The watch ends the run then.
    is_lost: bool,
    /// Splits and merges so far, and triangulations made afresh.
    pub counts: Counts,
}

/// How often cells were exchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Counts {
    pub splits: u64,
    pub merges: u64,
    pub renewals: u64,
}

/// All places that have to rest: some, and those nearer to others than so many cells.
fn resting(state: &State, places: impl Iterator<Item = Place>, others: impl Iterator<Item = Place>) -> BTreeSet<Place> {
    let mut resting: BTreeSet<Place> = places.collect();
    for (row, column) in others {
        let rows = row.saturating_sub(REST)..(row + REST + 1).min(state.rows + 2);
        let columns = column.saturating_sub(REST)..=column + REST;
        resting.extend(rows.flat_map(|row| columns.clone().map(move |column| (row, column))));
    }
    resting
}

/// Cells about boundaries and sources that rest.
const REST: usize = 2;

impl MovingCells {
    /// All squares of a state that need not rest: not some, nor those near others. None where these are too few, and on levels. They are taken out
    /// of the rows but for the pinned ones.
    pub fn new(
        state: &mut State,
        (places, others): (impl Iterator<Item = Place>, impl Iterator<Item = Place>),
        scale: &Scale,
    ) -> Option<Self> {
        if state.lattice().level_count() > 1 {
            return None;
        }
        let region = Region::new(state, &resting(state, places, others));
        let squares = region.cells();
        if !squares.iter().any(|(_, square)| *square == Square::Free) {
            return None;
        }
        let ground = Ground::new(state);
        let places: Vec<Vec2> = squares.iter().map(|&((row, column), _)| state.position(row, column)).collect();
        let mesh = Triangulation::new(places)?;
        let cell = |&(place, square): &(Place, Square)| match square {
            Square::Fixed | Square::Apart => Cell::Fixed(place),
            Square::Pinned => Cell::Pinned(place),
            Square::Free => Cell::Free,
        };
        let cells: Vec<Cell> = squares.iter().map(cell).collect();
        let numbers = |is_of: fn(&Cell) -> bool| {
            (0..).zip(&cells).filter(|(_, cell)| is_of(cell)).map(|(k, _)| k).collect::<Vec<u32>>()
        };
        let mut moving = MovingCells {
            fixed: numbers(|cell| cell.is_fixed()),
            pinned: numbers(|cell| matches!(cell, Cell::Pinned(_))),
            cells,
            ..MovingCells::without_cells(mesh, region, ground, Gridded::new(state))
        };
        moving.grow();
        moving.find_sides();
        moving.fill(state, &squares, scale);
        Some(moving)
    }

    /// The partition alone, with no room for what its cells hold.
    fn without_cells(mesh: Triangulation, region: Region, ground: Ground, gridded: Gridded) -> Self {
        MovingCells {
            mesh,
            region,
            ground,
            gridded,
            cells: Vec::new(),
            fixed: Vec::new(),
            pinned: Vec::new(),
            held: Vec::new(),
            next: Vec::new(),
            has_moved: Vec::new(),
            is_touched: Vec::new(),
            seen: Vec::new(),
            friction: Vec::new(),
            area: Vec::new(),
            centroid: Vec::new(),
            mobility: Vec::new(),
            motion: Vec::new(),
            slopes: Vec::new(),
            share: Vec::new(),
            is_active: Vec::new(),
            active: Vec::new(),
            was_active: Vec::new(),
            is_beside_idle: Vec::new(),
            is_shown: Vec::new(),
            all_sides: Vec::new(),
            side_ends: Vec::new(),
            is_stale: Vec::new(),
            chunks: Vec::new(),
            links: Vec::new(),
            passing: Vec::new(),
            tracers: tracers::OfAll::default(),
            pace: Pace::default(),
            is_lost: false,
            counts: Counts::default(),
        }
    }

    /// Gives the cells the water of their squares, and takes those that move out of the rows.
    fn fill(&mut self, state: &mut State, squares: &[(Place, Square)], scale: &Scale) {
        self.active = (0..).zip(&self.cells).filter(|(_, cell)| !cell.is_fixed()).map(|(i, _)| i).collect();
        self.active.iter().for_each(|&i| self.is_active[i as usize] = true);
        self.partition(true);
        for (number, &((row, column), square)) in squares.iter().enumerate() {
            let water = &state.water[row];
            let depth = water.depth[column];
            let volume = depth * self.area[number];
            let discharge = Vec2::new(water.discharge_x[column], water.discharge_y[column]);
            let place = self.mesh.place(number as u32);
            self.held[number] = Held { volume, momentum: discharge * self.area[number], place };
            self.seen[number].bed = state.ground[row].bed[column];
            self.friction[number] = state.ground[row].friction[column];
            match square {
                Square::Free => state.take_out(row, column),
                // Its volume is not that of the rows.
                Square::Pinned => state.ground[row].per_area[column] = 0.0,
                Square::Fixed | Square::Apart => {}
            }
        }
        self.next.clone_from(&self.held);
        self.take_tracers(&state.tracers, squares.iter().map(|&(place, _)| place));
        let region = &self.region;
        self.gridded.take_films(state, |row, column| !region.holds((row + 1, column + 1)));
        self.see(scale.dry_depth);
        self.find_active(scale.dry_depth);
        self.partition(true);
        self.find_motion(scale);
        self.find_pace(scale);
    }

    /// Makes room for all numbers of the partition.
    fn grow(&mut self) {
        let count = self.mesh.len();
        self.cells.resize(count, Cell::Gone);
        self.held.resize(count, Held::default());
        self.next.resize(count, Held::default());
        self.has_moved.resize(count, false);
        self.is_touched.resize(count, false);
        self.seen.resize(count, Seen::default());
        self.friction.resize(count, 0.0);
        self.area.resize(count, 0.0);
        self.centroid.resize(count, Vec2::ZERO);
        self.mobility.resize(count, 0.0);
        self.motion.resize(count, Vec2::ZERO);
        self.slopes.resize(count, Slopes::default());
        self.share.resize(count, 1.0);
        self.is_active.resize(count, false);
        self.was_active.resize(count, false);
        self.is_beside_idle.resize(count, false);
        self.is_shown.resize(count, true);
        let chunks = count.div_ceil(CHUNK);
        self.chunks.resize_with(chunks, Chunk::default);
        self.is_stale.resize(chunks, true);
        self.links.resize_with(chunks, Vec::new);
        self.passing.resize_with(chunks, Vec::new);
        self.tracers.grow(count);
    }

    /// Depth and velocity of the active cells from what they hold.
    fn see(&mut self, dry_depth: f64) {
        for &i in &self.active {
            let i = i as usize;
            let Held { volume, momentum, .. } = self.next[i];
            let depth = volume / self.area[i];
            let velocity = if depth > dry_depth { momentum / volume } else { Vec2::ZERO };
            let seen = &mut self.seen[i];
            (seen.depth, seen.u, seen.v) = (depth, velocity.x, velocity.y);
        }
    }

    /// Finds the active cells: those with water, and those beside them and beside water of the rows.
    fn find_active(&mut self, dry_depth: f64) {
        let MovingCells { is_active, was_active, active, fixed, seen, mesh, cells, is_stale, .. } = self;
        let is_water = |i: u32| seen[i as usize].depth > dry_depth || seen[i as usize].depth.is_nan();
        let wet: Vec<u32> =
            active.iter().copied().filter(|&i| cells[i as usize] != Cell::Gone && is_water(i)).collect();
        let before = std::mem::take(active);
        for &i in &before {
            was_active[i as usize] = std::mem::take(&mut is_active[i as usize]);
        }
        let mut take = |i: u32, active: &mut Vec<u32>| {
            if !is_active[i as usize] && !cells[i as usize].is_fixed() {
                is_active[i as usize] = true;
                active.push(i);
            }
        };
        for i in wet {
            take(i, active);
            mesh.around(i).for_each(|spoke| take(spoke.to, active));
        }
        // Squares that rest may lie at the hull.
        fixed.iter().filter(|&&i| is_water(i)).for_each(|&i| mesh.beside(i, |to| take(to, active)));
        for k in 0..active.len() {
            if !is_water(active[k]) {
                mesh.around(active[k]).for_each(|spoke| take(spoke.to, active));
            }
        }
        let mut mark = |i: u32| is_stale[i as usize / CHUNK] = true;
        for &i in before.iter().chain(&*active).filter(|&&i| was_active[i as usize] != is_active[i as usize]) {
            mark(i);
            mesh.around(i).for_each(|spoke| mark(spoke.to));
        }
        before.iter().for_each(|&i| was_active[i as usize] = false);
    }

    /// The cells of the lattice for whose squares cells of the partition stand.
    pub fn squares(&self) -> impl Iterator<Item = usize> + '_ {
        let lattice = self.ground.lattice();
        (0..lattice.rows * lattice.columns).filter(|&cell| {
            let (column, row) = lattice.column_row(cell);
            self.region.holds((row + 1, column + 1))
        })
    }

    /// All water (m³) beside that of the rows, which count pinned cells as squares.
    pub fn volume_beside(&self, state: &State) -> f64 {
        let own = self.held.iter().zip(&self.cells).filter(|(_, cell)| !cell.is_fixed());
        let in_rows = self.pinned_places().map(|(_, (row, column))| state.water[row].depth[column]);
        own.map(|(held, _)| held.volume).sum::<f64>() - in_rows.sum::<f64>() * self.ground.lattice().cell_area()
    }

    /// Gives the water a velocity (m/s) by place.
    pub fn set_velocity(&mut self, velocity: impl Fn(Vec2) -> Vec2, scale: &Scale) {
        for (i, held) in self.held.iter_mut().enumerate() {
            if self.seen[i].depth > scale.dry_depth && !self.cells[i].is_fixed() {
                held.momentum = velocity(self.mesh.place(i as u32)) * held.volume;
            }
        }
        self.next.clone_from(&self.held);
        self.gridded.drawn_at = None;
        self.see(scale.dry_depth);
        self.find_motion(scale);
        self.find_pace(scale);
    }

    /// Number of cells with water, without the pinned ones, which the rows count.
    pub fn wet_cells(&self, dry_depth: f64) -> usize {
        self.active
            .iter()
            .filter(|&&i| self.seen[i as usize].depth > dry_depth && self.cells[i as usize] == Cell::Free)
            .count()
    }

    /// Number of active cells, without the pinned ones.
    pub fn active_cells(&self) -> usize {
        self.active.iter().filter(|&&i| self.cells[i as usize] == Cell::Free).count()
    }
}
