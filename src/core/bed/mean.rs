//! The mean of the terrain that a riverbed particle stands for, corrected to be exact for a plane.
//!
//! With w the areas of the pieces of terrain inside the cell of the particle, ξ their places from the particle, and bars for means
//! with these weights:
//!
//! ```text
//! z_b = z̄ − γ·ξ̄,   γ = M⁻¹ Σ w (ξ − ξ̄_s)(z − z̄_s),   M = Σ w (ξ − ξ̄_s)(ξ − ξ̄_s)ᵀ      (M5)
//! ```
//!
//! γ is the slope of the plane that fits the cell and its surroundings (index s) best. It is asked for only where the pieces do not lie
//! evenly about the particle, ξ̄ ≠ 0: at edges, beside nodata and what is left out, and where the lattice does not divide the raster. A
//! cell that is covered by whole pieces has their mean, and one that is a piece has its elevation, to the last bit.
//!
//! Sums do not depend on the order of their terms, so that a terrain that is mirrored or turned has the mirrored or turned bed.
//!
//! References: `Shepard1968`, `LancasterSalkauskas1981` (the mean corrected to first order is the least-squares plane).

use super::fit::{bounded, solve};
use crate::math::{Sym2, Vec2};
use crate::terrain::Piece;

/// Means of places within this share of the width of a cell lie at its middle: rounding.
const CENTRED: f64 = 1e-9;
/// Spreads whose smaller variance is less than this share of the larger one are lines: rounding.
const LINE: f64 = 1e-9;
/// Bits of the whole numbers in which a sum is taken; some less than those of `i64`.
const BITS: i32 = 60;
/// Exponents of floating-point numbers that are left to themselves: nothing on Earth is so small or so large.
const EXPONENTS: std::ops::RangeInclusive<i32> = -900..=900;

/// Height (m) of a particle above its pieces of terrain; `None` without any.
///
/// - `width` (m): of its cell
/// - `surroundings`: replaces the pieces by those of the cell and its surroundings
pub(super) fn mean_height(
    pieces: &mut Vec<Piece>,
    width: f64,
    surroundings: impl FnOnce(&mut Vec<Piece>),
) -> Option<f64> {
    if let [piece] = pieces[..]
        && piece.offset == Vec2::ZERO
    {
        return Some(piece.elevation);
    }
    let (lowest, highest) = range(pieces)?;
    let (height, offset) = means(pieces);
    if offset.x.abs().max(offset.y.abs()) <= CENTRED * width {
        return Some(height.clamp(lowest, highest));
    }
    surroundings(pieces);
    // A plane through level ground leaves it by rounding.
    if let Some((low, high)) = range(pieces)
        && low >= high
    {
        return Some(low);
    }
    let plane = Plane::fitted(pieces);
    let largest_residual = pieces.iter().map(|piece| plane.residual(piece).abs()).fold(0.0, f64::max);
    Some(bounded(height - plane.slope.dot(offset), (lowest, highest), largest_residual))
}

/// The lowest and the highest elevation (m).
fn range(pieces: &[Piece]) -> Option<(f64, f64)> {
    let widened = |(low, high): (f64, f64), piece: &Piece| (low.min(piece.elevation), high.max(piece.elevation));
    (!pieces.is_empty()).then(|| pieces.iter().fold((f64::INFINITY, f64::NEG_INFINITY), widened))
}

/// Mean elevation (m) and mean offset (m).
fn means(pieces: &[Piece]) -> (f64, Vec2) {
    let total = sum(pieces, |piece| piece.share);
    let mean = |of: fn(&Piece) -> f64| sum(pieces, |piece| piece.share * of(piece)) / total;
    (mean(|piece| piece.elevation), Vec2::new(mean(|piece| piece.offset.x), mean(|piece| piece.offset.y)))
}

/// A plane through the means of pieces.
pub(super) struct Plane {
    height: f64,
    offset: Vec2,
    slope: Vec2,
}

impl Plane {
    /// The plane that fits pieces best; along their line where they lie on one, level where there is but one.
    pub fn fitted(pieces: &[Piece]) -> Self {
        let (height, offset) = means(pieces);
        let product = |of: &dyn Fn(Vec2, f64) -> f64| {
            sum(pieces, |piece| piece.share * of(piece.offset - offset, piece.elevation - height))
        };
        let spread = Sym2 {
            xx: product(&|at, _| at.x * at.x),
            xy: product(&|at, _| at.x * at.y),
            yy: product(&|at, _| at.y * at.y),
        };
        let moment = Vec2::new(product(&|at, rise| at.x * rise), product(&|at, rise| at.y * rise));
        let (narrow, wide) = spread.eigenvalues();
        let slope = if narrow > LINE * wide {
            solve(spread, moment)
        } else if wide > 0.0 {
            // M = λ n nᵀ with λ the larger eigenvalue: its pseudo-inverse is M/λ².
            spread.apply(moment) / (wide * wide)
        } else {
            Vec2::ZERO
        };
        Plane { height, offset, slope }
    }

    /// How far a piece lies above it (m).
    pub fn residual(&self, piece: &Piece) -> f64 {
        piece.elevation - self.height - self.slope.dot(piece.offset - self.offset)
    }
}

/// The height (m) of the plane through some pieces where their offsets are 0.
pub fn plane_at_middle(pieces: &[Piece]) -> f64 {
    let Plane { height, offset, slope } = Plane::fitted(pieces);
    height - slope.dot(offset)
}

/// Sum of a number of each piece, whatever their order: taken in whole numbers, of which the largest term has 60 bits.
fn sum(pieces: &[Piece], term: impl Fn(&Piece) -> f64) -> f64 {
    let largest = pieces.iter().map(|piece| term(piece).abs()).fold(0.0, f64::max);
    let exponent = ((largest.to_bits() >> 52) as i32) - 1023;
    if !EXPONENTS.contains(&exponent) {
        return pieces.iter().map(term).sum();
    }
    let power = |exponent: i32| f64::from_bits(((exponent + 1023) as u64) << 52);
    let scale = power(BITS - exponent);
    let whole: i128 = pieces.iter().map(|piece| i128::from((term(piece) * scale) as i64)).sum();
    whole as f64 * power(exponent - BITS)
}

#[cfg(test)]
mod tests;
