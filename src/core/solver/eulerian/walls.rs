//! Faces that are no ordinary pairs: walls and open edges.
//!
//! A wall face is the mirror problem of each of its two particles: no volume passes, and the normal momentum is that of the
//! Riemann problem between (d, u) and (d, −u). It stands between terrain and no terrain, and where a wall polyline
//! crosses the line between two particles. A stair ([`super::stairs`]) has the pressure of still water alone, as ground has that
//! rises out of the water, and of the faces beside it so much counts that water runs along the wall ([`super::apertures`]). An open face stands between terrain and no terrain, lets water out and none in; beyond it the bed goes
//! on falling as it does before it, and where it does not fall the water drops over the edge.
//! Faces at which more is known of the water beyond are in [`super::open`].

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::apertures::{Aperture, apertures};
use super::faces::{EAST, NORTH, through_face, turned_by};
use super::spans::ActiveSet;
use super::stairs::{self, is_stair};
use super::state::{GradientRow, GroundRow, PrimitiveRow, Slot, State};
use super::{EulerianMethods, Scale};
use crate::bed::SHUT;
use crate::constants::EulerianConstants;
use crate::lattice::{Level, NEIGHBOURS};
use crate::math::{Vec2, segments_cross};
use crate::methods::Reconstruction;
use crate::solver::FlowProblem;

/// One special face, in the row of its owner.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct SpecialFace {
    column: usize,
    direction: usize,
    open: bool,
    /// From the particle before it to where the terrain ends (spacings).
    reach: f64,
    /// Whether another level lies behind that particle.
    is_behind_elsewhere: bool,
    /// Whether it belongs to a stair, as its owner and as the other particle have it before them.
    stair: [bool; 2],
}

/// The special faces of a cell: bit k is set for the k-th of [`NEIGHBOURS`].
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Beside {
    blocked: u8,
    /// The blocked ones beyond which the water goes on as it is before them.
    onward: u8,
    /// The blocked ones that belong to a stair.
    stair: u8,
}

impl Beside {
    /// Whether a wall stands on the way to the neighbour at an offset (column, row).
    fn is_wall(self, offset: (isize, isize)) -> bool {
        self.blocked & !self.onward & bit_of(offset) != 0
    }
}

/// A cell with at least one special face.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct SpecialCell {
    pub column: usize,
    pub beside: Beside,
    /// The levels (m) of the sills on the ways to its neighbours, minus infinity where there is none.
    pub sills: [f64; 4],
}

/// How much of an ordinary face beside a stair counts, in the row of its owner.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct PartOfFace {
    column: usize,
    direction: usize,
    share: f64,
}

/// No sills on the ways to the four neighbours.
pub(super) const NO_SILLS: [f64; 4] = [f64::NEG_INFINITY; 4];

/// The bit of a neighbour at an offset (column, row).
fn bit_of(offset: (isize, isize)) -> u8 {
    NEIGHBOURS.iter().position(|n| *n == offset).map_or(0, |k| 1 << k)
}

/// The special faces of every padded row.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct Walls {
    faces: Vec<Vec<SpecialFace>>,
    cells: Vec<Vec<SpecialCell>>,
    parts: Vec<Vec<PartOfFace>>,
    /// Column and direction of the open faces of every padded row.
    open: Vec<Vec<(usize, usize)>>,
    /// Whether a padded row is one around a level, which is never active.
    is_ring: Vec<bool>,
}

/// Offset (column, row) from the owner of a face to its other particle.
fn step(direction: usize) -> (isize, isize) {
    if direction == EAST { (1, 0) } else { (0, 1) }
}

impl Walls {
    /// The walls of a problem. With the sharp reconstruction none is a stair: it makes noise in basins, from which thrusts take.
    pub fn new(problem: &FlowProblem, state: &State, methods: EulerianMethods) -> Self {
        let mut faces = vec![Vec::new(); state.rows + 2];
        let widths = (0..state.rows + 2).map(|row| state.columns(row) + 2);
        let mut beside: Vec<Vec<Beside>> = widths.clone().map(|width| vec![Beside::default(); width]).collect();
        let cut = crossed_faces(problem, state);
        for (row, width) in widths.enumerate().take(state.rows + 1) {
            for column in 0..width {
                for direction in [EAST, NORTH] {
                    let (dc, dr) = step(direction);
                    let (r, c) = stairs::beside((row, column), (dc, dr));
                    if c >= beside[r].len() {
                        continue;
                    }
                    let (here, there) = (state.has_terrain(row, column), state.has_terrain(r, c));
                    let outside = if here { (r, c) } else { (row, column) };
                    let is_edge = here != there && !state.is_elsewhere(outside.0, outside.1);
                    let is_cut = here && there && cut[row][column] & (1 << direction) != 0;
                    if !is_edge && !is_cut {
                        continue;
                    }
                    let inside = if here { (row, column) } else { (r, c) };
                    let middle = state.middle(inside, outside);
                    let times = 1.0 / state.haste(inside.0);
                    let normal = Vec2::new(dc as f64, dr as f64);
                    let is_edge_of_run = is_edge && !problem.bed.is_sealed(middle);
                    let goes_on = is_edge_of_run && problem.forcing.boundary_within(times, middle, normal).is_some();
                    let joins = problem.forcing.channel_joins_at(middle);
                    let open = is_edge_of_run
                        && !goes_on
                        && !joins
                        && problem.open_edges.is_open_within(times, middle, normal);
                    let reach = problem.bed.cover.reach(inside, 2 * direction + usize::from(!here), state.lattice());
                    let behind = stairs::beside(inside, if here { (-dc, -dr) } else { (dc, dr) });
                    let is_behind_elsewhere = open && state.is_elsewhere(behind.0, behind.1);
                    let face = SpecialFace { column, direction, open, reach, is_behind_elsewhere, stair: [false; 2] };
                    faces[row].push(face);
                    beside[row][column].blocked |= bit_of((dc, dr));
                    beside[r][c].blocked |= bit_of((-dc, -dr));
                    if goes_on || open {
                        beside[row][column].onward |= bit_of((dc, dr));
                        beside[r][c].onward |= bit_of((-dc, -dr));
                    }
                }
            }
        }
        let parts = if methods.reconstruction == Reconstruction::Sharp {
            vec![Vec::new(); state.rows + 2]
        } else {
            find_stairs(&mut faces, &mut beside, state, &methods.constants)
        };
        let cells_of_row = |(row, cells): (usize, &Vec<Beside>)| {
            let cells =
                cells.iter().enumerate().map(|(column, &beside)| SpecialCell { column, beside, sills: NO_SILLS });
            cells.filter(|cell| cell.beside.blocked != 0 && state.has_terrain(row, cell.column)).collect()
        };
        let open_of_row = |faces: &Vec<SpecialFace>| {
            let open = faces.iter().filter(|face| face.open);
            open.map(|face| (face.column, face.direction)).collect()
        };
        let open = faces.iter().map(open_of_row).collect();
        let is_ring = (0..state.rows + 2).map(|row| state.bounds(row).is_none()).collect();
        Walls { faces, cells: beside.iter().enumerate().map(cells_of_row).collect(), parts, open, is_ring }
    }

    /// The padded places (row, column) of cells that own special faces, or faces of which a part counts.
    pub fn owners(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let rows = self.faces.iter().zip(&self.parts).enumerate();
        rows.flat_map(|(row, (faces, parts))| {
            let columns = faces.iter().map(|face| face.column).chain(parts.iter().map(|part| part.column));
            columns.map(move |column| (row, column))
        })
    }

    /// The padded places of cells beside special faces.
    pub fn places(&self) -> Vec<(usize, usize)> {
        let cells = self.cells.iter().enumerate();
        let beside = cells.flat_map(|(row, cells)| cells.iter().map(move |cell| (row, cell.column)));
        beside.chain(self.owners()).collect()
    }

    /// The open faces: their row, direction and column.
    pub fn open_faces(&self) -> impl Iterator<Item = Slot> + '_ {
        let rows = self.open.iter().enumerate();
        rows.flat_map(|(row, faces)| faces.iter().map(move |&(column, direction)| Slot { row, direction, column }))
    }

    /// Whether water may leave by an edge without a condition.
    pub fn has_open_edges(&self) -> bool {
        self.open.iter().any(|faces| !faces.is_empty())
    }

    /// Whether no water passes from a padded cell to its neighbour (row, column) at an offset (column, row).
    pub fn is_blocked(&self, (row, column): (usize, usize), offset: (isize, isize)) -> bool {
        let cells = &self.cells[row];
        let Ok(found) = cells.binary_search_by_key(&column, |cell| cell.column) else { return false };
        cells[found].beside.blocked & bit_of(offset) != 0
    }

    /// The special faces of a padded cell.
    pub(super) fn beside(&self, row: usize, column: usize) -> Beside {
        let found = self.cells[row].binary_search_by_key(&column, |cell| cell.column);
        found.map_or(Beside::default(), |place| self.cells[row][place].beside)
    }

    /// Gradients of the cells beside special faces: over such a face surface and depth do not change, and the velocity
    /// is mirrored; over a stair it does not change either, and over an open face all goes on as it comes from the other side of the cell.
    pub fn correct_gradients(&self, state: &mut State, active: &ActiveSet, scale: &Scale) {
        correct_gradients(&self.cells, state, active, scale);
    }

    /// Fluxes of the special faces: of those that active cells own, and of those in the ring around the lattice, which is never active.
    /// Through all others nothing flows.
    pub fn apply(&self, state: &mut State, active: &ActiveSet, scale: &Scale) {
        let (primitive, ground, gradient) = (&state.primitive, &state.ground, &state.gradient);
        let (spacing, is_ring) = (&state.spacing, &self.is_ring);
        active.rows_of(&mut state.flux).for_each(|(row, flux)| {
            let (faces, parts) = (&self.faces[row], &self.parts[row]);
            for part in active.among(row, parts, |part| part.column) {
                flux[part.direction].scale(part.column, part.share);
            }
            let in_ring =
                &faces[..if is_ring[row] { faces.len() } else { faces.partition_point(|face| face.column == 0) }];
            for face in in_ring.iter().chain(active.among(row, faces, |face| face.column)) {
                let (dc, dr) = step(face.direction);
                let (left, right) = ((row, face.column), stairs::beside((row, face.column), (dc, dr)));
                let out = &mut flux[face.direction];
                let i = face.column;
                (out.mass[i], out.tangential[i], out.normal_left[i], out.normal_right[i]) = (0.0, 0.0, 0.0, 0.0);
                let particle = |(row, column): (usize, usize)| Particle::new(&primitive[row], column, face.direction);
                let (a, b) = (particle(left), particle(right));
                if face.open {
                    let scale = &scale.on(spacing[if a.depth > scale.dry_depth { left.0 } else { right.0 }]);
                    if a.depth > scale.dry_depth {
                        let beyond = Beyond::new((ground, gradient), (left, right), face, scale.spacing);
                        let (mass, normal) = leaving(a.depth, a.normal, &beyond, scale);
                        (out.mass[i], out.tangential[i]) = (mass, mass * a.tangent);
                        out.normal_left[i] = normal;
                    } else if b.depth > scale.dry_depth {
                        let beyond = Beyond::new((ground, gradient), (right, left), face, scale.spacing);
                        let (mass, normal) = leaving(b.depth, -b.normal, &beyond, scale);
                        (out.mass[i], out.tangential[i]) = (-mass, -mass * b.tangent);
                        out.normal_right[i] = normal;
                    }
                } else {
                    let thrust = |is_stair: bool, depth: f64, towards: f64| {
                        if is_stair { 0.0 } else { mirrored(depth, towards, scale.gravity) }
                    };
                    out.normal_left[i] = thrust(face.stair[0], a.depth, a.normal);
                    out.normal_right[i] = thrust(face.stair[1], b.depth, -b.normal);
                }
            }
        });
    }

    /// Rate (m³/s) at which water leaves through open faces now.
    pub fn leaving(&self, state: &State, active: &ActiveSet) -> f64 {
        let rows = active.at_hand();
        rows.map(|row| {
            let (faces, flux) = (&self.open[row], &state.flux[row]);
            let outwards = |&(column, direction): &(usize, usize)| {
                let inside = if state.has_terrain(row, column) { row } else { row + usize::from(direction == NORTH) };
                state.spacing[inside] * flux[direction].mass[column].abs()
            };
            faces.iter().map(outwards).sum::<f64>()
        })
        .sum()
    }
}

/// Depth and velocity of one side of a special face.
struct Particle {
    depth: f64,
    normal: f64,
    tangent: f64,
}

impl Particle {
    fn new(row: &PrimitiveRow, column: usize, direction: usize) -> Self {
        let (u, v) = (row.velocity_x[column], row.velocity_y[column]);
        let (normal, tangent) = turned_by(direction, u, v);
        Particle { depth: row.depth[column], normal, tangent }
    }
}

/// Normal momentum that a particle loses to its mirror, beyond the pressure of still water.
pub(super) fn mirrored(depth: f64, towards: f64, g: f64) -> f64 {
    if depth > 0.0 { through_face(depth, towards, depth, -towards, g).1 - 0.5 * g * depth * depth } else { 0.0 }
}

/// Volume flux and normal momentum of water leaving over an open face behind which the bed falls by `drop` (m).
///
/// The state outside is the same depth at the velocity of uniform flow on that slope, and a dry bed where the bed does not fall:
/// still water falls over such an edge at critical depth instead of standing behind it. From the particle to the edge the bed falls
/// by a part of the drop, half of it in a whole cell, whose weight drives the water as that on the other side of the particle does.
fn leaving(depth: f64, outwards: f64, ground: &Beyond, scale: &Scale) -> (f64, f64) {
    let g = scale.gravity;
    let (outside_depth, outside_velocity) = if ground.drop > 0.0 && ground.friction > 0.0 {
        let slope = ground.drop / scale.spacing;
        let uniform = (g * slope * depth * depth.cbrt() / ground.friction).sqrt();
        (depth, outwards.max(uniform.min((g * depth).sqrt())))
    } else {
        (0.0, 0.0)
    };
    let (mass, momentum) = through_face(depth, outwards, outside_depth, outside_velocity, g);
    if mass > 0.0 {
        (mass, momentum - 0.5 * g * depth * (depth + 2.0 * ground.reach * ground.drop))
    } else {
        (0.0, mirrored(depth, outwards, g))
    }
}

/// The ground behind an open face.
struct Beyond {
    /// How far the bed falls from one particle to the next (m), 0 where it rises or is not known.
    drop: f64,
    /// g n² (m^(1/3)).
    friction: f64,
    /// From the particle to the edge (spacings).
    reach: f64,
}

impl Beyond {
    /// The bed goes on as it does from the particle before the edge to the one at the edge.
    fn new(
        (ground, gradient): (&[GroundRow], &[GradientRow]),
        (inside, outside): ((usize, usize), (usize, usize)),
        face: &SpecialFace,
        spacing: f64,
    ) -> Self {
        let (row, column) = (2 * inside.0 - outside.0, 2 * inside.1 - outside.1);
        let (z_before, z_inside) = (ground[row].bed[column], ground[inside.0].bed[inside.1]);
        let drop = if face.is_behind_elsewhere {
            let (slope, column) = (&gradient[inside.0], inside.1);
            let rise = match face.direction {
                EAST => slope.surface_x[column] - slope.depth_x[column],
                _ => slope.surface_y[column] - slope.depth_y[column],
            };
            let is_first = inside < outside;
            if is_first { -spacing * rise } else { spacing * rise }
        } else if z_before < SHUT {
            z_before - z_inside
        } else {
            0.0
        };
        Beyond { drop: drop.max(0.0), friction: ground[inside.0].friction[inside.1], reach: face.reach }
    }
}

/// Gradients of the active cells among special ones.
pub(super) fn correct_gradients(cells: &[Vec<SpecialCell>], state: &mut State, active: &ActiveSet, scale: &Scale) {
    let (primitive, ground, spacing) = (&state.primitive, &state.ground, &state.spacing);
    active.rows_of(&mut state.gradient).for_each(|(row, gradient)| {
        let scale = &scale.on(spacing[row]);
        let of_row = active.among(row, &cells[row], |cell| cell.column);
        for cell in of_row.filter(|cell| primitive[row].depth[cell.column] > scale.dry_depth) {
            correct((primitive, ground), row, cell, scale, &|_| None, gradient);
        }
    });
}

/// Differences of surface (m), depth (m) and velocity (m/s) from a particle to what is beyond one of its sides.
pub(super) type Differences = [f64; 4];

/// The gradients of a padded cell of a row. `beyond` knows the sides behind which there is another level: the differences to it, and its
/// distance in spacings of the cell.
pub(super) fn correct(
    (primitive, ground): (&[PrimitiveRow], &[GroundRow]),
    row: usize,
    &SpecialCell { column: i, beside, sills }: &SpecialCell,
    scale: &Scale,
    beyond: &dyn Fn(usize) -> Option<(Differences, f64)>,
    out: &mut GradientRow,
) {
    let here = &primitive[row];
    let velocity = Vec2::new(here.velocity_x[i], here.velocity_y[i]);
    let Beside { blocked, onward, stair } = beside;
    // Differences of surface, depth and velocity over the pair with each neighbour.
    let [east, west, north, south] = [0, 1, 2, 3].map(|k: usize| {
        let (dc, dr) = NEIGHBOURS[k];
        let is_onward = onward & (1 << k) != 0;
        if let Some(found) = beyond(k) {
            return found;
        }
        // The neighbours stand in pairs.
        if is_onward && let Some((differences, distance)) = beyond(k ^ 1) {
            return (differences.map(|difference| -difference), distance);
        }
        let differences = if stair & (1 << k) != 0 || is_onward && blocked & (1 << (k ^ 1)) != 0 {
            [0.0; 4]
        } else if blocked & (1 << k) != 0 && !is_onward {
            let e = Vec2::new(dc as f64, dr as f64);
            let turned = e * (-2.0 * velocity.dot(e));
            [0.0, 0.0, turned.x, turned.y]
        } else {
            let sign = if is_onward { -1 } else { 1 };
            let (j_row, j) = stairs::beside((row, i), (sign * dc, sign * dr));
            let there = &primitive[j_row];
            let sill = sills[k];
            let levels = [ground[row].bed[i] + here.depth[i], ground[j_row].bed[j] + there.depth[j]];
            let is_shut = levels[0] <= sill && levels[1] <= sill;
            let differences = [
                super::gradient::difference_over_sill(
                    (here.depth[i], ground[row].bed[i]),
                    (there.depth[j], ground[j_row].bed[j]),
                    sill,
                    scale.dry_depth,
                ),
                there.depth[j] - here.depth[i],
                there.velocity_x[j] - velocity.x,
                there.velocity_y[j] - velocity.y,
            ];
            if is_shut { [0.0; 4] } else { differences.map(|difference| sign as f64 * difference) }
        };
        (differences, 1.0)
    });
    let slopes = |(ahead, far_ahead): (Differences, f64), (behind, far_behind): (Differences, f64)| {
        let per_way = 1.0 / ((far_ahead + far_behind) * scale.spacing);
        [0, 1, 2, 3].map(|q: usize| per_way * ahead[q] - per_way * behind[q])
    };
    let (x, y) = (slopes(east, west), slopes(north, south));
    (out.surface_x[i], out.depth_x[i], out.u_x[i], out.v_x[i]) = (x[0], x[1], x[2], x[3]);
    (out.surface_y[i], out.depth_y[i], out.u_y[i], out.v_y[i]) = (y[0], y[1], y[2], y[3]);
}

/// Marks the faces of walls that are stairs, and tells how much of the faces beside them counts: a face gets what stairs on either side of it make of it
/// together, of each side the mean of what its faces say.
fn find_stairs(
    faces: &mut [Vec<SpecialFace>],
    beside: &mut [Vec<Beside>],
    state: &State,
    constants: &EulerianConstants,
) -> Vec<Vec<PartOfFace>> {
    let mut found = Vec::new();
    let mut changes = BTreeMap::<(usize, usize, usize), [Mean; 2]>::new();
    let is_wall = |(row, column): (usize, usize), out| {
        let cell = beside.get(row).and_then(|cells| cells.get(column));
        cell.is_some_and(|cell| cell.is_wall(out)) && state.has_terrain(row, column)
    };
    for (row, faces) in faces.iter_mut().enumerate() {
        for face in faces {
            let (dc, dr) = step(face.direction);
            let cell = (row, face.column);
            let sides = [(cell, (dc, dr)), (stairs::beside(cell, (dc, dr)), (-dc, -dr))];
            for (is_marked, (cell, out)) in face.stair.iter_mut().zip(sides) {
                if !is_wall(cell, out) || !is_stair((cell, out), constants.stair_reach, &is_wall) {
                    continue;
                }
                *is_marked = true;
                found.push((cell, out));
                for Aperture { cell, way, is_wall_beyond, share } in apertures((cell, out), constants, &is_wall) {
                    let direction = if way.0 != 0 { EAST } else { NORTH };
                    let (row, column) = if way == step(direction) { cell } else { stairs::beside(cell, way) };
                    let changes = changes.entry((row, column, direction)).or_default();
                    changes[usize::from(is_wall_beyond)].add(share - 1.0);
                }
            }
        }
    }
    for ((row, column), out) in found {
        beside[row][column].stair |= bit_of(out);
    }
    let mut parts = vec![Vec::new(); faces.len()];
    for ((row, column, direction), changes) in changes {
        let share = (1.0 + changes[0].value() + changes[1].value()).max(0.0);
        parts[row].push(PartOfFace { column, direction, share });
    }
    parts
}

/// The mean of some numbers, 0 of none.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    fn add(&mut self, number: f64) {
        self.sum += number;
        self.count += 1.0;
    }

    fn value(&self) -> f64 {
        if self.count > 0.0 { self.sum / self.count } else { 0.0 }
    }
}

/// For every padded cell a bit for each of its faces that a wall polyline crosses.
fn crossed_faces(problem: &FlowProblem, state: &State) -> Vec<Vec<u8>> {
    let mut cut: Vec<Vec<u8>> = (0..state.rows + 2).map(|row| vec![0u8; state.columns(row) + 2]).collect();
    let lattice = &problem.bed.lattice;
    for (Level { first_row, columns, rows, spacing }, &wall) in
        lattice.levels().flat_map(|level| problem.walls.iter().map(move |wall| (level, wall)))
    {
        let padded = |value: f64, last: usize| ((value / spacing + 0.5).max(0.0) as usize).min(last);
        let (west, east) = (wall[0].x.min(wall[1].x), wall[0].x.max(wall[1].x));
        let (south, north) = (wall[0].y.min(wall[1].y), wall[0].y.max(wall[1].y));
        let across = padded(west - 2.0 * spacing, columns + 1)..=padded(east + 2.0 * spacing, columns + 1);
        for row in padded(south - 2.0 * spacing, rows + 1)..=padded(north + 2.0 * spacing, rows) {
            let from_south = Vec2::new(0.0, (row as f64 - 0.5) * spacing);
            let row = first_row + row;
            let width = cut[row].len();
            for column in across.clone().filter(|&column| column < width) {
                for direction in [EAST, NORTH] {
                    let (dc, dr) = step(direction);
                    let there = Vec2::new(dc as f64, dr as f64) * spacing;
                    let from = from_south + Vec2::new((column as f64 - 0.5) * spacing, 0.0);
                    if segments_cross([from, from + there], wall) {
                        cut[row][column] |= 1 << direction;
                    }
                }
            }
        }
    }
    cut
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn still_water_leans_on_a_wall_without_momentum() {
        assert!(mirrored(3.0, 0.0, 9.81).abs() <= 0.0);
        assert!(mirrored(3.0, 1.0, 9.81) > 0.0);
    }
}
