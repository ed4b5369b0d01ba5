//! The water of cells that move on the squares of the lattice: each cell is cut by them.
//!
//! A cell i gives a square s the share of its volume that a_s δ_s has of the sum of all, a_s the area of its part there:
//!
//! ```text
//! δ_s = σ [η_i + ∇η_i·(x_s − x_i) − z_s]₊ + (1 − σ) d_i,  σ = d_i/(d_i + |∇η_i| √A_i)     x_s, z_s middle and bed of the square
//! ```
//!
//! Where all δ are 0 it is the share of the area. So what was level is level on the map, a film that is thinner than its fall over the cell is as deep
//! as in the cell, and volume is that of the cells to rounding.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::super::rows::WaterRow;
use super::super::state::State;
use super::tracers::OfTracer;
use super::{CHUNK, MovingCells};
use crate::lattice::{Lattice, Span, WaterInRow, WaterRows};
use crate::math::Vec2;
use crate::partition::{area_and_centre, keep_left};
use crate::physics::tracer::Mixture;

/// The water of all squares, and where it may be.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Gridded {
    rows: Vec<WaterRow>,
    /// Of each tracer its concentration there.
    concentrations: Vec<Vec<Vec<f64>>>,
    /// The squares of each row that water of moving cells is on now, by column.
    touched: Vec<Vec<u32>>,
    /// Where squares that rest were looked at last.
    in_rows: Vec<Span>,
    spans: Vec<Span>,
    /// The steps that had been taken when this was drawn; none after a change from outside.
    pub drawn_at: Option<u64>,
}

/// What a part of a cell gives a square.
#[derive(Clone, Copy, Debug)]
struct Part {
    /// The cell.
    of: u32,
    row: u32,
    column: u32,
    volume: f64,
    momentum: Vec2,
}

impl Gridded {
    pub fn new(state: &State) -> Self {
        let rows = (1..=state.rows).map(|row| WaterRow::dry(state.columns(row))).collect();
        let touched = vec![Vec::new(); state.rows];
        let concentration = (1..=state.rows).map(|row| vec![0.0; state.columns(row)]).collect();
        let concentrations = vec![concentration; state.tracers.len()];
        Gridded { rows, concentrations, touched, in_rows: Vec::new(), spans: Vec::new(), drawn_at: None }
    }

    /// Takes the films of the squares that rest, which lie outside the spans.
    pub fn take_films(&mut self, state: &State, is_in_rows: impl Fn(usize, usize) -> bool) {
        for (row, own) in self.rows.iter_mut().enumerate() {
            for column in (0..own.depth.len()).filter(|&column| is_in_rows(row, column)) {
                own.depth[column] = state.water[row + 1].depth[column + 1];
            }
        }
    }
}

impl WaterRows for Gridded {
    fn row(&self, row: usize) -> WaterInRow<'_> {
        let WaterRow { depth, discharge_x, discharge_y } = &self.rows[row];
        WaterInRow { depth, discharge_x, discharge_y }
    }

    fn concentration(&self, tracer: usize, row: usize) -> &[f64] {
        &self.concentrations[tracer][row]
    }
}

impl MovingCells {
    /// Puts the water of all cells on the lattice, that of the rows where they have it in `spans`.
    pub fn grid(&mut self, state: &State, spans: &[Span], steps: u64) -> (&dyn WaterRows, &[Span]) {
        if self.gridded.drawn_at.replace(steps) == Some(steps) {
            return (&self.gridded, &self.gridded.spans);
        }
        let (this, lattice) = (&*self, self.ground.lattice());
        let per_square = 1.0 / lattice.cell_area();
        // Films that rest where they were left, too.
        let chunks = this.held.par_chunks(CHUNK).enumerate();
        let parts: Vec<Vec<Part>> = chunks
            .map(|(number, held)| {
                let (mut parts, mut scratch) = (Vec::new(), Scratch::default());
                let wet = (0..held.len()).filter(|&k| held[k].volume > 0.0).map(|k| (number * CHUNK + k) as u32);
                wet.for_each(|i| this.parts(i, lattice, (&mut scratch, &mut parts)));
                parts
            })
            .collect();
        let Gridded { rows, concentrations, touched, in_rows, spans: all, .. } = &mut self.gridded;
        let region = &self.region;
        let is_in_rows = |row: usize, column: usize| !region.holds((row + 1, column + 1));
        // What was looked at before is looked at once more, dry.
        let mut looked: Vec<Vec<u32>> = std::mem::replace(touched, vec![Vec::new(); rows.len()]);
        for (row, columns) in looked.iter().enumerate() {
            for &column in columns {
                rows[row].clear(column as usize);
                concentrations.iter_mut().for_each(|all| all[row][column as usize] = 0.0);
            }
        }
        put(&parts, per_square, (rows, touched));
        put_tracers(&parts, &self.tracers.each, concentrations);
        // Squares that have run dry since the last record, too.
        for &span in in_rows.iter().chain(spans) {
            let columns =
                (span.from as usize..span.to as usize).filter(|&column| is_in_rows(span.row as usize, column));
            take_squares(state, span.row as usize, columns, (rows, concentrations));
        }
        all.clear();
        let (mut before, mut of_rows) = (in_rows.iter().peekable(), spans.iter().peekable());
        for (row, (looked, touched)) in (0..).zip(looked.iter_mut().zip(touched)) {
            touched.sort_unstable();
            touched.dedup();
            looked.extend_from_slice(touched);
            while let Some(span) =
                before.next_if(|span| span.row == row).or_else(|| of_rows.next_if(|span| span.row == row))
            {
                looked.extend(span.from..span.to);
            }
            looked.sort_unstable();
            for &column in looked.iter() {
                match all.last_mut() {
                    Some(span) if span.row == row && span.to >= column => span.to = span.to.max(column + 1),
                    _ => all.push(Span { row, from: column, to: column + 1 }),
                }
            }
        }
        in_rows.clear();
        in_rows.extend_from_slice(spans);
        (&self.gridded, &self.gridded.spans)
    }

    /// Cuts a cell by the squares of the lattice.
    fn parts(&self, i: u32, lattice: &Lattice, (scratch, out): (&mut Scratch, &mut Vec<Part>)) {
        let held = self.held[i as usize];
        if self.cells[i as usize].is_fixed() {
            return;
        }
        let [_, _, u, v] = self.slopes_on_map(i);
        self.cut(i, lattice, scratch);
        let all = |of: fn(&Cut) -> f64| scratch.parts.iter().map(of).sum::<f64>();
        let (areas, water) = (all(|part| part.area), all(|part| part.water));
        let share = |part: &Cut| if water > 0.0 { part.water / water } else { part.area / areas };
        // Of the middle of the water, from which velocities are counted: momentum is kept.
        let middle = scratch.parts.iter().map(|part| part.offset * share(part)).fold(Vec2::ZERO, |a, b| a + b);
        for part in &scratch.parts {
            let volume = held.volume * share(part);
            let aside = part.offset - middle;
            let faster = if water > 0.0 { Vec2::new(u.dot(aside), v.dot(aside)) } else { Vec2::ZERO };
            let momentum = held.momentum * share(part) + faster * volume;
            out.push(Part { of: i, row: part.row, column: part.column, volume, momentum });
        }
    }

    /// The gradients of a cell that is active; films that rest have none.
    fn slopes_on_map(&self, i: u32) -> [Vec2; 4] {
        if self.is_active[i as usize] { self.slopes[i as usize].of } else { [Vec2::ZERO; 4] }
    }

    /// Finds what each square cuts out of a cell.
    fn cut(&self, i: u32, lattice: &Lattice, scratch: &mut Scratch) {
        let seen = self.seen[i as usize];
        let level = seen.bed + seen.depth;
        let surface = self.slopes_on_map(i)[0];
        let fall = surface.norm() * self.area[i as usize].sqrt();
        let as_pool = seen.depth / (seen.depth + fall).max(f64::MIN_POSITIVE);
        let own = self.mesh.place(i);
        let spacing = lattice.spacing;
        self.mesh.cell(i, &mut scratch.cell);
        // In spacings from the particle: corners on lines of the lattice stay there.
        scratch.cell.iter_mut().for_each(|corner| *corner = snapped(*corner / spacing));
        scratch.parts.clear();
        let bounds = |of: &[Vec2], along: fn(&Vec2) -> f64| {
            let low = of.iter().map(along).fold(f64::INFINITY, f64::min);
            let high = of.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
            (low.floor(), high.ceil())
        };
        let (south, north) = bounds(&scratch.cell, |corner| corner.y);
        let mut y = south;
        while y < north {
            scratch.strip.clone_from(&scratch.cell);
            keep_left(&mut scratch.strip, &mut scratch.other, |corner| y - corner.y);
            keep_left(&mut scratch.strip, &mut scratch.other, |corner| corner.y - (y + 1.0));
            let (west, east) = bounds(&scratch.strip, |corner| corner.x);
            let mut x = west;
            while x < east {
                scratch.piece.clone_from(&scratch.strip);
                keep_left(&mut scratch.piece, &mut scratch.other, |corner| x - corner.x);
                keep_left(&mut scratch.piece, &mut scratch.other, |corner| corner.x - (x + 1.0));
                let (area, centre) = area_and_centre(scratch.piece.iter().copied());
                if area > 1e-12
                    && let Some(cell) = lattice.cell_at(Vec2::new(x + 0.5, y + 0.5) * spacing)
                {
                    let (column, row) = lattice.column_row(cell);
                    if self.region.holds((row + 1, column + 1)) {
                        let offset = centre * spacing - own;
                        let middle = Vec2::new(x + 0.5, y + 0.5) * spacing;
                        let below = (level + surface.dot(middle - own) - self.ground.level(cell)).max(0.0);
                        let depth = as_pool * below + (1.0 - as_pool) * seen.depth;
                        scratch.parts.push(Cut {
                            row: row as u32,
                            column: column as u32,
                            area,
                            water: area * depth,
                            offset,
                        });
                    }
                }
                x += 1.0;
            }
            y += 1.0;
        }
    }
}

/// Puts parts of cells on their squares.
fn put(parts: &[Vec<Part>], per_square: f64, (rows, touched): (&mut [WaterRow], &mut [Vec<u32>])) {
    for part in parts.iter().flatten() {
        let row = &mut rows[part.row as usize];
        let column = part.column as usize;
        row.depth[column] += part.volume * per_square;
        row.discharge_x[column] += part.momentum.x * per_square;
        row.discharge_y[column] += part.momentum.y * per_square;
        touched[part.row as usize].push(part.column);
    }
}

/// Takes squares of a row that rest from the rows of the lattice.
fn take_squares(
    state: &State,
    row: usize,
    columns: impl Iterator<Item = usize>,
    (rows, concentrations): (&mut [WaterRow], &mut [Vec<Vec<f64>>]),
) {
    let (own, water) = (&mut rows[row], &state.water[row + 1]);
    for column in columns {
        own.depth[column] = water.depth[column + 1];
        own.discharge_x[column] = water.discharge_x[column + 1];
        own.discharge_y[column] = water.discharge_y[column + 1];
        for (which, all) in concentrations.iter_mut().enumerate() {
            all[row][column] = state.tracers.seen(which, row + 1)[column + 1];
        }
    }
}

/// Puts the concentrations of parts of cells on their squares: their mean by volume.
fn put_tracers(parts: &[Vec<Part>], tracers: &[OfTracer], concentrations: &mut [Vec<Vec<f64>>]) {
    for (tracer, all) in tracers.iter().zip(concentrations) {
        let mut mixtures: BTreeMap<(u32, u32), Mixture> = BTreeMap::new();
        for part in parts.iter().flatten() {
            let mixture = mixtures.entry((part.row, part.column)).or_insert(Mixture::NOTHING);
            *mixture = mixture.with(part.volume, tracer.seen[part.of as usize]);
        }
        for ((row, column), mixture) in mixtures {
            all[row as usize][column as usize] = mixture.concentration_or(0.0);
        }
    }
}

/// Polygons while a cell is cut.
#[derive(Default)]
struct Scratch {
    cell: Vec<Vec2>,
    strip: Vec<Vec2>,
    piece: Vec<Vec2>,
    other: Vec<Vec2>,
    parts: Vec<Cut>,
}

/// What a square cuts out of a cell.
#[derive(Clone, Copy)]
struct Cut {
    row: u32,
    column: u32,
    /// (squares)
    area: f64,
    /// The area times δ (m).
    water: f64,
    /// From the particle to its centre (m).
    offset: Vec2,
}

/// A place (in spacings) moved onto a line of the lattice which it is on but for rounding.
fn snapped(place: Vec2) -> Vec2 {
    let snap = |x: f64| if (x - x.round()).abs() < 1e-9 { x.round() } else { x };
    Vec2::new(snap(place.x), snap(place.y))
}
