//! The pieces that a rectangle cuts out of a terrain, each with the elevation of its raster cell and the place that it belongs to.
//!
//! A piece of a raster cell has the value of that cell, which belongs to the centre of the cell and counts by the area inside the
//! rectangle. On a plane the weighted means z̄ and ξ̄ of elevations and places then lie on the plane, wherever the rectangle cuts.
//!
//! The rectangle is no smaller than a cell of the raster: where a lattice is finer than the terrain, the mean over it is the bilinear
//! elevation at its middle.

use super::{Layer, Overlay, Raster, SPACING_ROUNDING, Survey, Terrain};
use crate::math::{Rectangle, Vec2};

/// Sides of rectangles that miss a side of raster cells by less than this share of a cell lie on it: the round-off of map coordinates.
const ON_A_SIDE: f64 = 1e-6;
/// So many pieces further the surroundings of a rectangle reach: a plane through three columns shows whether it fits.
const SURROUNDINGS: f64 = 2.0;
/// Most parts, along a side, into which the area of a survey is divided: each counts with the mean of its points.
const MOST_PARTS: usize = 8;
/// Parts along a side where a survey of few points to the cell, or one beside other layers, is asked for its surface.
const PARTS_OF_SURFACE: usize = 3;

/// A piece of terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// From the middle of the rectangle to the place that the elevation belongs to (m).
    pub offset: Vec2,
    /// Elevation (m).
    pub elevation: f64,
    /// Its area inside the rectangle, as a share of the area of a whole piece.
    pub share: f64,
}

impl Piece {
    /// Whether it is a whole piece with its own place in the middle of the rectangle.
    #[inline]
    pub fn is_whole(&self) -> bool {
        self.offset == Vec2::ZERO && self.share >= 1.0
    }
}

/// The cells of a raster that a rectangle covers along one axis, counted from the western or the northern edge.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    from: f64,
    to: f64,
}

impl Stretch {
    /// - `middle`, `width`: of the rectangle, in cells of the raster; it is widened to a cell
    fn new(middle: f64, width: f64, margin: f64) -> Self {
        let half = 0.5 * width.max(1.0);
        let on_side = |place: f64| {
            let side = place.round();
            if (place - side).abs() < ON_A_SIDE { side } else { place }
        };
        Stretch { from: on_side(middle - half) - margin, to: on_side(middle + half) + margin }
    }

    /// The cells, which may lie beside the raster.
    fn cells(&self) -> std::ops::Range<i64> {
        self.from.floor() as i64..self.to.ceil() as i64
    }

    /// The part (0 to 1) of a cell that is covered.
    fn share(&self, cell: i64) -> f64 {
        let west = cell as f64;
        (west + 1.0).min(self.to) - west.max(self.from)
    }

    /// From the middle of the rectangle to the centre of a cell, in cells.
    fn offset(&self, cell: i64) -> f64 {
        cell as f64 + 0.5 - 0.5 * (self.from + self.to)
    }
}

impl Raster {
    /// The columns and rows that a square of a width (m) around a place covers.
    fn stretches(&self, centre: Vec2, width: f64, margin: f64) -> (Stretch, Stretch) {
        (
            Stretch::new((centre.x - self.west) / self.cell_x, width / self.cell_x, margin),
            Stretch::new((self.north - centre.y) / self.cell_y, width / self.cell_y, margin),
        )
    }

    /// Replaces `pieces` by those of the raster; whether it has data all over the square.
    fn pieces(&self, centre: Vec2, width: f64, margin: f64, pieces: &mut Vec<Piece>) -> bool {
        pieces.clear();
        let (across, down) = self.stretches(centre, width, margin);
        let within = |cells: std::ops::Range<i64>, count: usize| {
            cells.start.clamp(0, count as i64) as usize..cells.end.clamp(0, count as i64) as usize
        };
        let (columns, rows) = (within(across.cells(), self.columns), within(down.cells(), self.rows));
        let covered = across.cells().count() * down.cells().count();
        for row in rows {
            let height = down.share(row as i64);
            let north = -down.offset(row as i64) * self.cell_y;
            let values = &self.values[row * self.columns..][columns.clone()];
            for (column, &elevation) in columns.clone().zip(values) {
                if !elevation.is_nan() {
                    let offset = Vec2::new(across.offset(column as i64) * self.cell_x, north);
                    pieces.push(Piece { offset, elevation, share: across.share(column as i64) * height });
                }
            }
        }
        pieces.len() == covered
    }
}

impl Survey {
    /// Replaces `pieces` by those of the survey; whether it has data all over the square.
    ///
    /// Where the points are dense, the square is divided into parts of some points each, which count with the means of their points;
    /// elsewhere its surface is asked in some places.
    fn pieces(&self, centre: Vec2, width: f64, margin: f64, pieces: &mut Vec<Piece>) -> bool {
        pieces.clear();
        let parts = (width / (2.0 * self.spacing())) as usize;
        if parts < 2 {
            let parts = ((width / self.spacing()).ceil() as usize).clamp(1, PARTS_OF_SURFACE);
            return sample(centre, width, parts, margin, pieces, |place| self.elevation(place));
        }
        let parts = parts.min(MOST_PARTS);
        let part_width = width / parts as f64;
        let along = parts + 2 * margin as usize;
        let half = 0.5 * along as f64 * part_width;
        // Sums of offsets and elevations, and numbers of points.
        let mut sums = vec![(Vec2::ZERO, 0.0, 0.0); along * along];
        for point in self.within(centre, half * std::f64::consts::SQRT_2) {
            let point = self.points()[point];
            let offset = point.position - centre;
            let (column, row) = ((offset.x + half) / part_width, (offset.y + half) / part_width);
            let is_inside = column >= 0.0 && row >= 0.0 && column < along as f64 && row < along as f64;
            if is_inside && self.covers(point.position) {
                let sum = &mut sums[row as usize * along + column as usize];
                *sum = (sum.0 + offset, sum.1 + point.elevation, sum.2 + 1.0);
            }
        }
        let means = sums.iter().filter(|sum| sum.2 > 0.0);
        pieces.extend(means.map(|&(offset, elevation, count)| Piece {
            offset: offset / count,
            elevation: elevation / count,
            share: 1.0,
        }));
        pieces.len() == along * along
    }
}

/// Replaces `pieces` by samples in the middles of the parts of a square; whether there is terrain in each of them.
fn sample(
    centre: Vec2,
    width: f64,
    parts: usize,
    margin: f64,
    pieces: &mut Vec<Piece>,
    elevation: impl Fn(Vec2) -> Option<f64>,
) -> bool {
    pieces.clear();
    let along = parts + 2 * margin as usize;
    let offset = |part: usize| (part as f64 + 0.5 - 0.5 * along as f64) * (width / parts as f64);
    for row in 0..along {
        for column in 0..along {
            let offset = Vec2::new(offset(column), offset(row));
            pieces.extend(elevation(centre + offset).map(|elevation| Piece { offset, elevation, share: 1.0 }));
        }
    }
    pieces.len() == along * along
}

impl Terrain {
    /// Replaces `pieces` by those that a square of a width (m) around a place cuts out of the terrain, and of its surroundings where
    /// they are asked for. Their order is fixed.
    ///
    /// Where several layers have data, the square is divided into cells of the finest, each of which has the elevation of the layer that
    /// counts at its centre.
    pub fn pieces(&self, centre: Vec2, width: f64, with_surroundings: bool, pieces: &mut Vec<Piece>) {
        let margin = if with_surroundings { SURROUNDINGS } else { 0.0 };
        let is_near = |index: &usize| {
            let Rectangle { low, high } = self.extents[*index];
            let reach = match &self.layers[*index] {
                Layer::Raster(raster) => {
                    let cell = raster.cell_x.max(raster.cell_y);
                    0.5 * width.max(cell) + margin * cell
                }
                Layer::Survey(_) => width * (0.5 + margin),
            };
            let from = low - Vec2::new(reach, reach);
            let to = high + Vec2::new(reach, reach);
            centre.x >= from.x && centre.y >= from.y && centre.x <= to.x && centre.y <= to.y
        };
        pieces.clear();
        for index in (0..self.layers.len()).rev().filter(is_near) {
            let is_whole = match &self.layers[index] {
                Layer::Raster(raster) => raster.pieces(centre, width, margin, pieces),
                Layer::Survey(survey) => survey.pieces(centre, width, margin, pieces),
            };
            if pieces.is_empty() {
                continue;
            }
            let hides_others = is_whole && self.overlays[index] == Overlay::Replace;
            if !hides_others && (0..index).any(|index| is_near(&index)) {
                let near: Vec<usize> = (0..self.layers.len()).filter(is_near).collect();
                self.mixed_pieces(&near, (centre, width, margin), pieces);
            }
            return;
        }
    }

    /// The same of several layers.
    fn mixed_pieces(&self, near: &[usize], (centre, width, margin): (Vec2, f64, f64), pieces: &mut Vec<Piece>) {
        let raster = |index: &usize| match &self.layers[*index] {
            Layer::Raster(raster) => Some(raster),
            Layer::Survey(_) => None,
        };
        let size = |raster: &Raster| raster.cell_x.max(raster.cell_y);
        let limit = width * (1.0 + SPACING_ROUNDING);
        let finest = near.iter().filter_map(raster).min_by(|a, b| size(a).total_cmp(&size(b)));
        // A cell of the layer that counts, where that is finer than the square.
        let piece = |place: Vec2| {
            let read = |layer: &Layer| layer.piece_at(place, limit);
            let (index, elevation) = self.top_of_first(self.layers.len(), &read)?;
            let at = match &self.layers[index] {
                Layer::Raster(raster) if size(raster) <= limit => {
                    raster.cell_at(place).map_or(place, |(column, row)| raster.centre(column, row))
                }
                _ => place,
            };
            Some((at - centre, elevation))
        };
        let Some(finest) = finest.filter(|finest| size(finest) <= limit && near.iter().all(|i| raster(i).is_some()))
        else {
            sample(centre, width, PARTS_OF_SURFACE, margin, pieces, |place| self.elevation(place));
            return;
        };
        pieces.clear();
        let (across, down) = finest.stretches(centre, width, margin);
        for row in down.cells() {
            for column in across.cells() {
                let cell = Vec2::new(across.offset(column) * finest.cell_x, -down.offset(row) * finest.cell_y);
                if let Some((offset, elevation)) = piece(centre + cell) {
                    pieces.push(Piece { offset, elevation, share: across.share(column) * down.share(row) });
                }
            }
        }
    }
}

impl Layer {
    /// Elevation (m) of the piece of terrain at a place: of a raster the value of its cell, unless that is larger than a limit (m).
    fn piece_at(&self, map: Vec2, limit: f64) -> Option<f64> {
        match self {
            Layer::Raster(raster) if raster.cell_x.max(raster.cell_y) <= limit => {
                let (column, row) = raster.cell_at(map)?;
                Some(raster.value(column, row)).filter(|value| !value.is_nan())
            }
            _ => self.elevation(map),
        }
    }
}
