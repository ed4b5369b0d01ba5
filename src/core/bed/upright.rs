//! Upright steps of the terrain inside a cell: walls, houses and quays, whose foot and top are not one ground.
//!
//! Neighbouring pieces are on one side of a step unless it rises between them by more for each metre than ground does that stands by itself, and by
//! the least height that counts in the cell ([`BedConstants`]). Sides that join round the end of a step are one.

use super::{BedParticles, Surface};
use crate::constants::BedConstants;
use crate::math::Vec2;
use crate::terrain::Piece;

/// Sides whose areas differ by less than this share are equally large: rounding.
const EQUAL: f64 = 1e-9;

/// The width, in cells, of a cell and the eight around it. A bank beside a cell stands in them; a rim is drawn along it.
pub const NINE_CELLS: f64 = 3.0;

/// An upright step between two pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Height (m).
    pub height: f64,
    /// From the centre of the cell to the middle between the pieces (m).
    pub offset: Vec2,
}

/// The upright step between two pieces of a cell of a width (m); none where the ground goes on.
fn step_between(a: &Piece, b: &Piece, width: f64, constants: &BedConstants) -> Option<Step> {
    let height = (a.elevation - b.elevation).abs();
    let is_upright =
        height >= least_step(width, constants) && height > constants.upright_slope * (a.offset - b.offset).norm();
    is_upright.then_some(Step { height, offset: (a.offset + b.offset) * 0.5 })
}

/// The least height (m) of a step that counts in a cell of a width (m).
pub fn least_step(width: f64, constants: &BedConstants) -> f64 {
    constants.least_step.min(constants.step_share * width)
}

/// Pairs of neighbours in a row or a column of pieces, which come row by row.
fn neighbours(pieces: &[Piece]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let is_same = |a: f64, b: f64| (a - b).abs() <= 0.0;
    let pairs = move |i: usize| {
        let Vec2 { x, y } = pieces[i].offset;
        let beside = Some(i + 1).filter(|&j| pieces.get(j).is_some_and(|piece| is_same(piece.offset.y, y)));
        let later = || i + 1..pieces.len();
        let below = later().find(|&j| is_same(pieces[j].offset.x, x));
        [beside, below].into_iter().flatten().map(move |j| (i, j))
    };
    (0..pieces.len()).flat_map(pairs)
}

/// Whether the pieces lie so far apart in height that a step may be among them.
fn may_hold_step(pieces: &[Piece], width: f64, constants: &BedConstants) -> bool {
    let widened = |(low, high): (f64, f64), piece: &Piece| (low.min(piece.elevation), high.max(piece.elevation));
    let (low, high) = pieces.iter().fold((f64::INFINITY, f64::NEG_INFINITY), widened);
    high - low >= least_step(width, constants)
}

/// The highest upright step among the pieces of a cell of a width (m); none without one.
pub fn highest_step(pieces: &[Piece], width: f64, constants: &BedConstants) -> Option<Step> {
    if !may_hold_step(pieces, width, constants) {
        return None;
    }
    let steps = neighbours(pieces).filter_map(|(i, j)| step_between(&pieces[i], &pieces[j], width, constants));
    steps.max_by(|a, b| a.height.total_cmp(&b.height))
}

/// Keeps the pieces on the side of upright steps that takes most of a cell of a width (m), of equal ones the lowest; all of
/// them where no side takes much of it. Whether some were dropped.
pub(super) fn keep_largest_side(pieces: &mut Vec<Piece>, width: f64, constants: &BedConstants) -> bool {
    if highest_step(pieces, width, constants).is_none() {
        return false;
    }
    let sides = sides(pieces, width, constants);
    let mut areas = vec![0.0; pieces.len()];
    let mut heights = vec![f64::INFINITY; pieces.len()];
    for (piece, &side) in pieces.iter().zip(&sides) {
        areas[side] += piece.share;
        heights[side] = piece.elevation.min(heights[side]);
    }
    let largest = areas.iter().copied().fold(0.0, f64::max);
    if largest < constants.least_side * areas.iter().sum::<f64>() {
        return false;
    }
    let is_largest = |&side: &usize| areas[side] >= (1.0 - EQUAL) * largest;
    let kept = (0..pieces.len()).filter(is_largest).min_by(|&a, &b| heights[a].total_cmp(&heights[b]));
    let mut side = sides.iter();
    let before = pieces.len();
    pieces.retain(|_| side.next().copied() == kept);
    pieces.len() < before
}

/// Whether an upright step of the terrain's own pixels divides a square of a width (m) around a place (map) into sides, of which the
/// bed of a cell is the largest (M5).
///
/// - `spacing` (m): of the cells; larger pixels, and points, are no upright step but the surface between them
fn is_divided(surface: &impl Surface, centre: Vec2, width: f64, (spacing, constants): (f64, &BedConstants)) -> bool {
    let mut pieces = Vec::new();
    surface.has_pixels(centre, spacing) && {
        surface.pieces(centre, width, false, &mut pieces);
        keep_largest_side(&mut pieces, spacing, constants)
    }
}

/// The same of a square of so many cells about a cell of a bed.
pub fn is_divided_about(surface: &impl Surface, bed: &BedParticles, cell: usize, cells: f64) -> bool {
    let lattice = &bed.lattice;
    let by = (lattice.spacing, &bed.constants);
    is_divided(surface, lattice.to_map(lattice.centre(cell)), cells * lattice.spacing, by)
}

/// For each piece the first one on its side of all steps.
fn sides(pieces: &[Piece], width: f64, constants: &BedConstants) -> Vec<usize> {
    fn first(sides: &mut [usize], mut piece: usize) -> usize {
        while sides[piece] != piece {
            sides[piece] = sides[sides[piece]];
            piece = sides[piece];
        }
        piece
    }
    let mut sides: Vec<usize> = (0..pieces.len()).collect();
    for (i, j) in neighbours(pieces) {
        if step_between(&pieces[i], &pieces[j], width, constants).is_none() {
            let (a, b) = (first(&mut sides, i), first(&mut sides, j));
            sides[a.max(b)] = a.min(b);
        }
    }
    (0..pieces.len()).map(|piece| first(&mut sides, piece)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const AS_THEY_ARE: &BedConstants = &BedConstants::DEFAULT;

    use crate::terrain::PointInterpolation;
    use crate::terrain::{Layer, Raster, Survey, SurveyPoint, Terrain};

    fn pieces(values: &[f64], columns: usize) -> Vec<Piece> {
        let offset = |i: usize| Vec2::new((i % columns) as f64, -((i / columns) as f64));
        values.iter().enumerate().map(|(i, &elevation)| Piece { offset: offset(i), elevation, share: 1.0 }).collect()
    }

    fn kept(values: &[f64], columns: usize, width: f64) -> Vec<f64> {
        let mut pieces = pieces(values, columns);
        keep_largest_side(&mut pieces, width, AS_THEY_ARE);
        pieces.iter().map(|piece| piece.elevation).collect()
    }

    #[test]
    fn a_step_is_upright_between_neighbours_alone() {
        let highest = |values: &[f64], columns: usize| highest_step(&pieces(values, columns), 10.0, AS_THEY_ARE);
        assert_eq!(highest(&[0.0, 0.5, 1.0, 0.9, 1.4, 1.8], 3), None);
        // From west to east, and from north to south; the end of one row is no neighbour of the start of the next.
        let step = |height: f64, x: f64, y: f64| Some(Step { height, offset: Vec2::new(x, y) });
        assert_eq!(highest(&[0.0, 0.0, 3.0, 0.5, 0.5, 1.2], 3), step(3.0, 1.5, 0.0));
        assert_eq!(highest(&[0.0, 0.5, 1.0, -4.0, -3.4, -2.7], 3), step(4.0, 0.0, -0.5));
        assert_eq!(highest(&[9.0], 1), None);
        assert_eq!(highest(&[], 1), None);
    }

    #[test]
    fn the_larger_side_of_a_step_stays() {
        // The corner of a house; the same where the house takes most of the cell; a house in two halves of equal size.
        assert_eq!(kept(&[0.0, 0.1, 5.0, 0.0, 0.1, 5.2], 3, 10.0), [0.0, 0.1, 0.0, 0.1]);
        assert_eq!(kept(&[0.0, 5.0, 5.1, 0.0, 5.0, 5.2], 3, 10.0), [5.0, 5.1, 5.0, 5.2]);
        assert_eq!(kept(&[5.0, 0.0, 0.0, 5.0], 2, 10.0).len(), 4, "pieces that meet at a corner do not join: rubble");
        assert_eq!(kept(&[5.0, 5.0, 0.0, 0.0], 2, 10.0), [0.0, 0.0]);
        // A wall through the cell divides it, and one with a gap does not.
        assert_eq!(kept(&[0.0, 0.0, 9.0, 0.2, 0.0, 0.0, 9.0, 0.2], 4, 10.0), [0.0; 4]);
        assert_eq!(kept(&[0.0, 9.0, 0.2, 0.0, 0.1, 0.2], 3, 10.0), [0.0, 0.2, 0.0, 0.1, 0.2]);
        // A ramp is no step, and no low one is.
        assert_eq!(kept(&[0.0, 0.9, 1.8, 2.7], 4, 10.0).len(), 4);
        assert_eq!(kept(&[0.0, 0.0, 0.9], 3, 10.0).len(), 3);
    }

    #[test]
    fn pixels_divide_a_cell_and_points_and_larger_pixels_do_not() {
        // A quay of 4 m at x = 9, in pixels and in points of 1 m.
        let height = |x: f64| if x > 9.0 { 4.0 } else { 0.0 };
        let value = |i: usize| height((i % 20) as f64 + 0.5);
        let raster = |columns: usize, cell: f64, values: Vec<f64>| {
            let north = columns as f64 * cell;
            Layer::Raster(Raster { columns, rows: columns, west: 0.0, north, cell_x: cell, cell_y: cell, values })
        };
        let place = |i: usize| Vec2::new((i % 20) as f64 + 0.5, (i / 20) as f64 + 0.5);
        let points = (0..400).map(|i| SurveyPoint { position: place(i), elevation: value(i) }).collect();
        let survey = Survey::new(points, PointInterpolation::NaturalNeighbour, 5.0).unwrap();
        let fine = Terrain::new(vec![raster(20, 1.0, (0..400).map(value).collect())]).unwrap();
        let coarse = Terrain::new(vec![raster(2, 9.0, vec![0.0, 40.0, 0.0, 40.0])]).unwrap();
        let points = Terrain::new(vec![Layer::Survey(survey)]).unwrap();
        let divides =
            |terrain: &Terrain, x: f64, width: f64| is_divided(terrain, Vec2::new(x, 7.5), width, (5.0, AS_THEY_ARE));
        assert!(divides(&fine, 7.5, 5.0) && !divides(&fine, 2.5, 5.0) && divides(&fine, 2.5, 15.0));
        assert!(!divides(&coarse, 7.5, 5.0) && !divides(&points, 7.5, 5.0));
    }

    #[test]
    fn steps_of_flumes_are_lower_than_those_of_towns() {
        let flume: Vec<Piece> = pieces(&[0.0, 0.0, 0.4], 3)
            .into_iter()
            .map(|piece| Piece { offset: piece.offset * 0.02, ..piece })
            .collect();
        assert_eq!(highest_step(&flume, 0.06, AS_THEY_ARE).map(|step| step.height), Some(0.4));
    }
}
