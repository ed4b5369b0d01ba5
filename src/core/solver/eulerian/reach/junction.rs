//! Where a reach meets the area of two dimensions: the edge faces of its opening.
//!
//! Each is the face of an ordinary pair between the last particle of the reach and the cell behind the face. What passes it is one
//! number, which the cell and the reach book with opposite signs; level and discharge go over in either direction, as the states of
//! the two sides ask.

use super::super::faces::{EAST, Half, NORTH, Numbers, single, turned_by};
use super::super::gradient::surface_difference;
use super::super::open::Exchange;
use super::super::state::State;
use super::super::walls::Walls;
use super::super::{EulerianMethods, Scale};
use super::{Face, Reach, Rise};
use crate::boundary::EdgeFace;
use crate::solver::FlowProblem;

/// An edge face of the opening.
#[derive(serde::Serialize, serde::Deserialize)]
struct Opening {
    /// The padded cell that owns the face, and the direction in which it does.
    owner: (usize, usize),
    direction: usize,
    /// The padded cell behind the face, and the one behind that, where no wall is between them.
    cell: (usize, usize),
    behind: Option<(usize, usize)>,
    /// 1 where water that leaves the reach goes east or north, −1 otherwise.
    sign: f64,
    /// The strip of the reach that meets the cell.
    strip: usize,
}

/// The opening of a reach.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Junction {
    openings: Vec<Opening>,
}

impl Junction {
    /// The faces of an opening. The lowest cells meet the lowest strips: `widths` (m) are those of the strips at
    /// the opening, from the lowest.
    pub fn new(faces: &[EdgeFace], widths: &[f64], (problem, state, walls): (&FlowProblem, &State, &Walls)) -> Self {
        let lattice = &problem.bed.lattice;
        let opening = |&EdgeFace { cell: index, middle }: &EdgeFace| {
            let (column, row) = lattice.column_row(index);
            let cell = (row + 1, column + 1);
            let inwards = lattice.centre(index) - middle;
            let offset = ((2.0 * inwards.x / lattice.spacing).round(), (2.0 * inwards.y / lattice.spacing).round());
            let (direction, sign) = if offset.0.abs() > offset.1.abs() { (EAST, offset.0) } else { (NORTH, offset.1) };
            let (dc, dr) = (offset.0 as isize, offset.1 as isize);
            let shifted =
                |steps: isize| ((cell.0 as isize + steps * dr) as usize, (cell.1 as isize + steps * dc) as usize);
            let owner = if sign > 0.0 { shifted(-1) } else { cell };
            let is_free = state.has_terrain(shifted(1).0, shifted(1).1) && !walls.is_blocked(cell, (dc, dr));
            Opening { owner, direction, cell, behind: is_free.then(|| shifted(1)), sign, strip: 0 }
        };
        let mut openings: Vec<Opening> = faces.iter().map(opening).collect();
        openings.sort_by(|a, b| {
            let bed = |opening: &Opening| state.ground[opening.cell.0].bed[opening.cell.1];
            bed(a).total_cmp(&bed(b)).then(a.cell.cmp(&b.cell))
        });
        let (whole, count) = (widths.iter().sum::<f64>(), openings.len() as f64);
        for (number, opening) in openings.iter_mut().enumerate() {
            let middle = whole * (number as f64 + 0.5) / count;
            let mut reached = 0.0;
            let strip = widths.iter().position(|width| {
                reached += width;
                middle < reached
            });
            opening.strip = strip.unwrap_or(widths.len() - 1);
        }
        Junction { openings }
    }

    /// The cells to which water may come.
    pub fn cells(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.openings.iter().map(|opening| opening.cell)
    }

    /// The strips of the reach and the beds (m) of the cells that they meet.
    pub fn beds<'a>(&'a self, state: &'a State) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.openings.iter().map(|opening| (opening.strip, state.ground[opening.cell.0].bed[opening.cell.1]))
    }

    /// Takes the bed (m) of the last particle, by strip, into the steps of the bed of the cells.
    pub fn find_steps(&self, bed: impl Fn(usize) -> f64, state: &mut State) {
        for opening in &self.openings {
            let ground = &mut state.ground[opening.cell.0];
            let column = opening.cell.1;
            ground.step[column] = ground.step[column].max((ground.bed[column] - bed(opening.strip)).abs());
        }
    }

    /// Rates at which water enters and leaves the reach by the opening (m²/s, per metre of face).
    pub fn rates(&self, state: &State) -> Exchange {
        let outwards = self.openings.iter().map(|opening| opening.outwards(state));
        outwards.fold(Exchange::default(), |sum, rate| Exchange {
            inflow: sum.inflow + (-rate).max(0.0),
            outflow: sum.outflow + rate.max(0.0),
        })
    }

    /// Scales what leaves the reach.
    pub fn reduce(&self, state: &mut State, share: f64) {
        for opening in &self.openings {
            if opening.outwards(state) > 0.0 {
                let out = &mut state.flux[opening.owner.0][opening.direction];
                out.mass[opening.owner.1] *= share;
                out.tangential[opening.owner.1] *= share;
            }
        }
    }

    /// Mean differences between the last particle of a reach and the cells that a strip of it meets, the others where it meets none.
    pub fn beyond(&self, strip: usize, here: (f64, f64, f64), state: &State, dry_depth: f64) -> Rise {
        let meets = self.openings.iter().any(|opening| opening.strip == strip);
        let mut sum = Rise::default();
        let mut count = 0.0;
        for opening in self.openings.iter().filter(|opening| !meets || opening.strip == strip) {
            let (row, column) = opening.cell;
            let depth = state.primitive[row].depth[column];
            let bed = state.ground[row].bed[column];
            sum.level += surface_difference((here.0, here.1), (depth, bed), dry_depth);
            sum.depth += depth - here.0;
            sum.velocity += opening.sign * opening.velocity(state).0 - here.2;
            count += 1.0;
        }
        Rise { level: sum.level / count, depth: sum.depth / count, velocity: sum.velocity / count }
    }

    /// Gradients of the cells across their faces: the neighbour there is the reach.
    pub fn correct_gradients(&self, reach: &Reach, state: &mut State, scale: &Scale) {
        let per_two_spacings = 0.5 / scale.spacing;
        for opening in &self.openings {
            let (row, column) = opening.cell;
            let (depth, bed) = (state.primitive[row].depth[column], state.ground[row].bed[column]);
            if depth <= scale.dry_depth {
                continue;
            }
            let (normal, along) = opening.velocity(state);
            let beyond = reach.last(opening.strip);
            let outer = [
                surface_difference((depth, bed), (beyond.d, beyond.z), scale.dry_depth),
                beyond.d - depth,
                opening.sign * beyond.u - normal,
                -along,
            ];
            let inner = match opening.behind {
                None => [0.0, 0.0, -2.0 * normal, 0.0],
                Some((r, c)) => {
                    let water = &state.primitive[r];
                    let there = (water.depth[c], state.ground[r].bed[c]);
                    let (u, v) = opening.turned(water.velocity_x[c], water.velocity_y[c]);
                    let levels = surface_difference((depth, bed), there, scale.dry_depth);
                    [levels, there.0 - depth, u - normal, v - along]
                }
            };
            // The differences towards east or north less those towards west or south.
            let slope: [f64; 4] = std::array::from_fn(|k| per_two_spacings * (opening.sign * (inner[k] - outer[k])));
            let out = &mut state.gradient[row];
            if opening.direction == EAST {
                (out.surface_x[column], out.depth_x[column]) = (slope[0], slope[1]);
                (out.u_x[column], out.v_x[column]) = (slope[2], slope[3]);
            } else {
                (out.surface_y[column], out.depth_y[column]) = (slope[0], slope[1]);
                (out.v_y[column], out.u_y[column]) = (slope[2], slope[3]);
            }
        }
    }

    /// Fluxes of the faces; returns what the last particle of the reach loses by them.
    pub fn pass(&self, reach: &Reach, state: &mut State, scale: &Scale, methods: EulerianMethods) -> Face {
        let numbers = Numbers::new(scale, methods);
        let mut sum = Face::default();
        for opening in &self.openings {
            let cell = Half::of_cell(state, opening.cell, opening.direction, scale.spacing);
            let cell = if opening.sign > 0.0 { cell } else { cell.mirrored() };
            let (mass, along, lost, gained) = single(reach.last(opening.strip), cell, numbers, methods);
            let out = &mut state.flux[opening.owner.0][opening.direction];
            let at = opening.owner.1;
            (out.mass[at], out.tangential[at]) = (opening.sign * mass, opening.sign * along);
            (out.normal_left[at], out.normal_right[at]) =
                if opening.sign > 0.0 { (0.0, gained) } else { (gained, 0.0) };
            sum.lost += lost * scale.spacing;
        }
        sum
    }
}

impl Opening {
    /// Components along the normal of the face and along the face, as the lattice has them.
    fn turned(&self, x: f64, y: f64) -> (f64, f64) {
        turned_by(self.direction, x, y)
    }

    fn velocity(&self, state: &State) -> (f64, f64) {
        let water = &state.primitive[self.cell.0];
        self.turned(water.velocity_x[self.cell.1], water.velocity_y[self.cell.1])
    }

    /// What leaves the reach now (m²/s).
    fn outwards(&self, state: &State) -> f64 {
        self.sign * state.flux[self.owner.0][self.direction].mass[self.owner.1]
    }
}
