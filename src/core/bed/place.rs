//! Terrain to riverbed particles: elevation by one of three methods; slopes and curvatures from the elevations used, where somebody asks
//! for them.
//!
//! With the cubic B-spline W of smoothing length h, ξ the offset to a neighbour, and Δ the spacing of the lattice:
//!
//! ```text
//! Shepard height   z_b = z̄ − g·ξ̄,  g = C⁻¹ Σ W (ξ − ξ̄)(z − z̄),  C = Σ W (ξ − ξ̄)(ξ − ξ̄)ᵀ,  bars: means with weights W;  h = 0.75 Δ
//! least squares    the a of  z ≈ a + g·ξ + ½ ξ·K ξ  that minimises the squares of the samples with weights W;               h = Δ
//! slope            ∇z_b = M⁻¹ Σ (z_j − z_i) (|W'|/r) ξ,           M = Σ (|W'|/r) ξ ξᵀ;                                     h = 0.75 Δ
//! curvature        the K of  z_j − z_i ≈ g·ξ + ½ ξ·K ξ  that minimises the squares with weights W;                         h = 1.5 Δ
//! ```
//!
//! The first and the third are exact for a plane, the others for a quadratic, whatever the arrangement of the neighbours: also at
//! edges and beside nodata. References: `BonetLok1999` (corrected gradient), `Shepard1968`,
//! `LancasterSalkauskas1981` (moving least squares; the corrected kernel mean is that of a plane).
//!
//! Widths. The terrain is smoothed over what one particle stands for and the flow can resolve (support 1.5 Δ, the eight
//! neighbours), which takes out the detail that the lattice would alias. A lattice finer than the terrain has nothing to
//! take out: its supports hold too few samples for a plane, and the height falls back to the pointwise one. The
//! curvature needs 2.83 Δ, because a quadratic on one side of an edge needs three columns.

use std::sync::LazyLock;

use rayon::prelude::*;

use super::fit::{SINGULAR, bounded_by, solve, solve_cholesky};
use super::mean::mean_height;
use super::upright::keep_largest_side;
use super::{BedParticles, LeftOut, Surface};
use crate::constants::BedConstants;
use crate::lattice::Lattice;
use crate::math::{Sym2, Vec2};
use crate::methods::BedMethod;
use crate::physics::kernel::{CubicSpline, Shape};
use crate::terrain::Piece;

/// Support radius over lattice spacing for slopes: the eight neighbours.
const SLOPE_SUPPORT: f64 = 1.5;
/// Support radius over lattice spacing for curvatures.
const CURVATURE_SUPPORT: f64 = 3.0;
/// The riverbed particles of a lattice.
///
/// - `surface`: the terrain; a cell whose centre has no terrain gets the elevation NaN
/// - `method`: how elevations are taken from the terrain
/// - `left_out`: what stands on the terrain and is not part of the means of the cells beside it
/// - `manning` (s·m^(−1/3)): the roughness of every particle
///
/// The same bits for any number of threads.
pub fn place_bed(
    surface: &impl Surface,
    lattice: &Lattice,
    method: BedMethod,
    left_out: &impl LeftOut,
    manning: f64,
) -> BedParticles {
    place_bed_with(surface, lattice, (method, &BedConstants::DEFAULT), left_out, manning)
}

/// The same by other constants.
pub fn place_bed_with(
    surface: &impl Surface,
    lattice: &Lattice,
    (method, constants): (BedMethod, &BedConstants),
    left_out: &impl LeftOut,
    manning: f64,
) -> BedParticles {
    let mut bed = BedParticles::from_elevation(lattice.clone(), vec![f64::NAN; lattice.len()], manning);
    bed.constants = *constants;
    bed.is_sloped = true;
    if lattice.is_empty() {
        return bed;
    }
    bed.elevation.par_chunks_mut(lattice.columns).enumerate().for_each_init(
        Room::default,
        |room, (row, elevations)| {
            for (column, elevation) in elevations.iter_mut().enumerate() {
                let cell = lattice.index(column, row);
                let place = lattice.to_map(lattice.centre(cell));
                let height = match method {
                    BedMethod::Mean => {
                        mean_of_cell(surface, (cell, place, lattice.spacing), (left_out, constants), &mut room.pieces)
                    }
                    _ => fitted_height(surface, place, lattice.spacing, (method, constants), &mut room.samples),
                };
                *elevation = height.unwrap_or(f64::NAN);
            }
        },
    );
    bed
}

/// Room for the terrain of a cell.
#[derive(Default)]
struct Room {
    pieces: Vec<Piece>,
    samples: Vec<(Vec2, f64)>,
}

/// Mean height of a cell, given by its index, its centre (map) and its width (m); `None` where its centre has no terrain.
fn mean_of_cell(
    surface: &impl Surface,
    (cell, centre, width): (usize, Vec2, f64),
    (left_out, constants): (&impl LeftOut, &BedConstants),
    pieces: &mut Vec<Piece>,
) -> Option<f64> {
    surface.pieces(centre, width, false, pieces);
    if let [piece] = pieces[..]
        && piece.is_whole()
    {
        return Some(piece.elevation);
    }
    let pointwise = surface.elevation(centre)?;
    let is_beside = left_out.is_near(cell);
    let keep = |pieces: &mut Vec<Piece>| {
        if is_beside {
            pieces.retain(|piece| !left_out.holds(cell, centre + piece.offset));
        }
    };
    keep(pieces);
    if pieces.is_empty() {
        // All of it is left out: a cell that is taken as it is drawn.
        return Some(pointwise);
    }
    let is_one_side = keep_largest_side(pieces, width, constants);
    let surroundings = |pieces: &mut Vec<Piece>| {
        // One side of a step is its own surroundings.
        if !is_one_side {
            surface.pieces(centre, width, true, pieces);
            keep(pieces);
        }
    };
    mean_height(pieces, width, surroundings).or(Some(pointwise))
}

/// Height of a particle by the other methods; `None` where there is no terrain.
fn fitted_height(
    surface: &impl Surface,
    place: Vec2,
    spacing: f64,
    (method, constants): (BedMethod, &BedConstants),
    samples: &mut Vec<(Vec2, f64)>,
) -> Option<f64> {
    let pointwise = surface.elevation(place)?;
    let mut around = |support: f64| {
        samples.clear();
        surface.samples(place, support * spacing, samples);
    };
    Some(match method {
        BedMethod::Mean | BedMethod::Pointwise => pointwise,
        BedMethod::Shepard => {
            around(constants.shepard_support);
            shepard_height(place, constants.shepard_support * spacing, (pointwise, constants), samples)
                .unwrap_or(pointwise)
        }
        BedMethod::MovingLeastSquares => {
            around(constants.squares_support);
            let radius = constants.squares_support * spacing;
            squares_height(place, radius, (pointwise, constants), samples)
                .or_else(|| shepard_height(place, radius, (pointwise, constants), samples))
                .unwrap_or(pointwise)
        }
    })
}

/// Curvatures of all riverbed particles from their elevations.
pub fn derive_curvatures(bed: &mut BedParticles) {
    let (lattice, elevation) = (&bed.lattice, &bed.elevation);
    let stencil = stencil(CURVATURE_SUPPORT, |q| CubicSpline.shape(q));
    bed.curvature.resize(lattice.len(), Sym2::default());
    for_each_on_terrain(lattice, elevation, &mut bed.curvature, |column, row| {
        curvature_at(lattice, elevation, column, row, &stencil)
    });
}

/// Sets the value of each cell with terrain by its column and row.
fn for_each_on_terrain<T: Send>(
    lattice: &Lattice,
    elevation: &[f64],
    values: &mut [T],
    find: impl Fn(usize, usize) -> T + Sync,
) {
    values.par_chunks_mut(lattice.columns.max(1)).enumerate().for_each(|(row, values)| {
        for (column, value) in values.iter_mut().enumerate() {
            if !elevation[lattice.index(column, row)].is_nan() {
                *value = find(column, row);
            }
        }
    });
}

/// |W'|/q of the cubic B-spline without its constant, for q = r/h > 0.
fn gradient_weight(q: f64) -> f64 {
    let outer = (2.0 - q).max(0.0);
    let inner = (1.0 - q).max(0.0);
    (0.75 * outer * outer - 3.0 * inner * inner) / q
}

/// Kernel mean of the terrain's samples around a place, corrected to first order; `None` where they do not determine a plane.
///
/// Beside a step the plane can leave the range of the samples. It may do so only as far as it has proved to be a good
/// description of them: what lies beyond the range is reduced by the largest residual (zero for a plane, so that the
/// height stays exact where the samples lie on one side of the place only).
fn shepard_height(
    place: Vec2,
    radius: f64,
    (reference, constants): (f64, &BedConstants),
    samples: &[(Vec2, f64)],
) -> Option<f64> {
    // Offsets in units of the radius and elevations from the pointwise one: small numbers lose no digits.
    let weighted = |&(position, elevation): &(Vec2, f64)| {
        let offset = (position - place) / radius;
        (offset, elevation - reference, CubicSpline.shape(2.0 * offset.norm()))
    };
    let (mut sum, mut sum_offset, mut sum_elevation, mut count) = (0.0, Vec2::ZERO, 0.0, 0);
    for (offset, elevation, w) in samples.iter().map(weighted) {
        sum += w;
        sum_offset += offset * w;
        sum_elevation += elevation * w;
        count += usize::from(w > 0.0);
    }
    if count < constants.plane_samples {
        return None;
    }
    let (mean_offset, mean_elevation) = (sum_offset / sum, sum_elevation / sum);
    let (mut spread, mut moment) = (Sym2::default(), Vec2::ZERO);
    for (offset, elevation, w) in samples.iter().map(weighted) {
        let from_mean = offset - mean_offset;
        add_outer_product(&mut spread, from_mean, w);
        moment += from_mean * (w * (elevation - mean_elevation));
    }
    let (narrow, wide) = spread.eigenvalues();
    // `>` also refuses not-a-number.
    let determines_plane = narrow > constants.plane_spread * wide;
    if !determines_plane {
        return None;
    }
    let gradient = solve(spread, moment);
    let height = mean_elevation - gradient.dot(mean_offset);

    let inside = samples.iter().map(weighted).filter(|&(.., w)| w > 0.0);
    let fitted = inside.map(|(offset, elevation, _)| (elevation, height + gradient.dot(offset)));
    Some(reference + bounded_by(height, fitted))
}

/// Height of the quadratic that fits the terrain's samples best; `None` where they do not determine one. Beside a step it
/// is bounded as that of the plane.
fn squares_height(
    place: Vec2,
    radius: f64,
    (reference, constants): (f64, &BedConstants),
    samples: &[(Vec2, f64)],
) -> Option<f64> {
    let weighted = |&(position, elevation): &(Vec2, f64)| {
        let Vec2 { x, y } = (position - place) / radius;
        let w = CubicSpline.shape(2.0 * Vec2::new(x, y).norm());
        ([1.0, x, y, 0.5 * x * x, x * y, 0.5 * y * y], elevation - reference, w)
    };
    let inside = || samples.iter().map(weighted).filter(|&(.., w)| w > 0.0);
    let (mut normal, mut right) = ([[0.0; 6]; 6], [0.0; 6]);
    for (terms, elevation, w) in inside() {
        for (i, &term) in terms.iter().enumerate() {
            right[i] += w * term * elevation;
            for (entry, &other) in normal[i][..=i].iter_mut().zip(&terms) {
                *entry += w * term * other;
            }
        }
    }
    let dot = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    // The height is Σ w (p·y) z with y = N⁻¹ e₁.
    let y = solve_cholesky(normal, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    let response: f64 = inside().map(|(terms, _, w)| (w * dot(&terms, &y)).abs()).sum();
    let fit = solve_cholesky(normal, right).filter(|_| response < constants.squares_response)?;
    Some(reference + bounded_by(fit[0], inside().map(|(terms, elevation, _)| (elevation, dot(&terms, &fit)))))
}

/// A neighbour on the lattice: steps to the east and north, and its weight.
type Neighbour = (isize, isize, f64);

/// The neighbours within a support radius given in spacings, the particle itself left out.
fn stencil(support: f64, weight: fn(f64) -> f64) -> Vec<Neighbour> {
    let reach = support.ceil() as isize;
    let mut neighbours = Vec::new();
    for north in -reach..=reach {
        for east in -reach..=reach {
            let distance = Vec2::new(east as f64, north as f64).norm();
            if distance > 0.0 && distance < support {
                neighbours.push((east, north, weight(2.0 * distance / support)));
            }
        }
    }
    neighbours
}

/// The neighbours that decide a slope.
static SLOPE_STENCIL: LazyLock<Vec<Neighbour>> = LazyLock::new(|| stencil(SLOPE_SUPPORT, gradient_weight));

/// The neighbours of a cell that have terrain: offset in spacings, difference of elevation (m), weight.
fn neighbours<'a>(
    lattice: &'a Lattice,
    elevation: &'a [f64],
    column: usize,
    row: usize,
    stencil: &'a [Neighbour],
) -> impl Iterator<Item = (Vec2, f64, f64)> + 'a {
    let own = elevation[lattice.index(column, row)];
    stencil.iter().filter_map(move |&(east, north, w)| {
        let column = column.checked_add_signed(east).filter(|&column| column < lattice.columns)?;
        let row = row.checked_add_signed(north).filter(|&row| row < lattice.rows)?;
        let other = elevation[lattice.index(column, row)];
        (!other.is_nan()).then(|| (Vec2::new(east as f64, north as f64), other - own, w))
    })
}

/// Corrected kernel gradient of the bed at a cell. Where all neighbours lie on one line, the slope along that line; without
/// neighbours zero.
fn slope_at(lattice: &Lattice, elevation: &[f64], column: usize, row: usize, stencil: &[Neighbour]) -> Vec2 {
    let (mut moments, mut sum) = (Sym2::default(), Vec2::ZERO);
    for (offset, rise, w) in neighbours(lattice, elevation, column, row, stencil) {
        add_outer_product(&mut moments, offset, w);
        sum += offset * (w * rise);
    }
    let half_trace = moments.half_trace();
    if half_trace == 0.0 {
        Vec2::ZERO
    } else if moments.determinant() > SINGULAR * half_trace * half_trace {
        solve(moments, sum) / lattice.spacing
    } else {
        // M = λ n nᵀ with λ the trace: its pseudo-inverse is M/λ².
        moments.apply(sum) / (4.0 * half_trace * half_trace * lattice.spacing)
    }
}

/// Hessian of the quadratic that fits the neighbours of a cell best; zero where they do not determine one.
///
/// The fit is a mean of the quadratics through any five neighbours, and on a lattice the determinant of such five is a whole
/// number: no arrangement of neighbours, however poor, makes it blow up.
fn curvature_at(lattice: &Lattice, elevation: &[f64], column: usize, row: usize, stencil: &[Neighbour]) -> Sym2 {
    let (mut normal, mut right) = ([[0.0; 5]; 5], [0.0; 5]);
    for (Vec2 { x, y }, rise, w) in neighbours(lattice, elevation, column, row, stencil) {
        let terms = [x, y, 0.5 * x * x, x * y, 0.5 * y * y];
        for (i, &term) in terms.iter().enumerate() {
            right[i] += w * term * rise;
            for (entry, &other) in normal[i][..=i].iter_mut().zip(&terms) {
                *entry += w * term * other;
            }
        }
    }
    let Some([_, _, xx, xy, yy]) = solve_cholesky(normal, right) else { return Sym2::default() };
    let scale = 1.0 / lattice.cell_area();
    Sym2 { xx: xx * scale, xy: xy * scale, yy: yy * scale }
}

/// Adds w v vᵀ.
fn add_outer_product(matrix: &mut Sym2, v: Vec2, w: f64) {
    matrix.xx += w * v.x * v.x;
    matrix.xy += w * v.x * v.y;
    matrix.yy += w * v.y * v.y;
}

impl BedParticles {
    /// Slope ∇z_b (dimensionless) of a riverbed particle with terrain; zero where the bed goes on level. It is found anew at each call,
    /// since few places ask for it: those beside a hole or the edge of the lattice.
    #[cold]
    pub fn slope(&self, cell: usize) -> Vec2 {
        if !self.is_sloped {
            return Vec2::ZERO;
        }
        let (column, row) = self.lattice.column_row(cell);
        slope_at(&self.lattice, &self.elevation, column, row, &SLOPE_STENCIL)
    }

    /// Whether no ground stands above a level (m) on the straight way from a place (local, m) to the centre of a cell, both left out.
    pub fn is_in_sight(&self, place: Vec2, level: f64, cell: usize) -> bool {
        let lattice = &self.lattice;
        let here = place * (1.0 / lattice.spacing);
        let (column, row) = lattice.column_row(cell);
        let way = Vec2::new(column as f64 + 0.5, row as f64 + 0.5) - here;
        let cells = way.x.abs().max(way.y.abs()) as u32;
        let stride = way * (1.0 / (f64::from(cells) + 1.0));
        (1..=cells).all(|step| {
            let between = here + stride * f64::from(step);
            // A particle may stand beside the lattice. Not a number (no terrain) compares as false. Casts to 32 bits are faster.
            let (column, row) = (between.x as u32 as usize, between.y as u32 as usize);
            self.elevation[lattice.index(column.min(lattice.columns - 1), row.min(lattice.rows - 1))] < level
        })
    }
}

#[cfg(test)]
mod tests;
