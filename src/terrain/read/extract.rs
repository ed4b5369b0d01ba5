//! What of a raster is read: some of its cells, as they stand or several as one.

use std::path::Path;

use gdal::GeoTransform;
use gdal::errors::Result as GdalResult;
use gdal::raster::{Buffer, GdalType, RasterBand, ResampleAlg};
use gdal::spatial_ref::SpatialRef;

use super::{Placing, RasterFile, RasterRequest};
use crate::geodata::{Crs, transform};
use crate::math::{Rectangle, Vec2};

/// Cells that are read beyond a part of the map: slopes and interpolation look as far.
const MARGIN: f64 = 4.0;
/// Places along a side of a part that are brought to the system of the file: its sides may be curved there.
const PLACES: usize = 16;

/// Cells of a file, and how many cells they are read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Extract {
    /// Its first column and row.
    pub first: (usize, usize),
    /// Its columns and rows in the file.
    pub size: (usize, usize),
    /// Its columns and rows as they are read.
    pub shape: (usize, usize),
}

impl Extract {
    /// The geotransform of what is read, with that of the file.
    pub fn geo_transform(&self, [x, a, b, y, d, e]: GeoTransform) -> GeoTransform {
        let (c, r) = (self.first.0 as f64, self.first.1 as f64);
        let across = self.size.0 as f64 / self.shape.0 as f64;
        let down = self.size.1 as f64 / self.shape.1 as f64;
        [x + a * c + b * r, a * across, b * down, y + d * c + e * r, d * across, e * down]
    }

    /// Column and row in the file of the first cell that is read as the cell of an index.
    pub fn in_file(&self, index: usize) -> (usize, usize) {
        let (column, row) = (index % self.shape.0, index / self.shape.0);
        (self.first.0 + column * self.size.0 / self.shape.0, self.first.1 + row * self.size.1 / self.shape.1)
    }

    /// The values of a band.
    pub fn read<T: Copy + GdalType>(&self, band: &RasterBand<'_>, several: ResampleAlg) -> GdalResult<Vec<T>> {
        let first = (self.first.0 as isize, self.first.1 as isize);
        let resampling = (self.size != self.shape).then_some(several);
        let buffer: Buffer<T> = band.read_as(first, self.size, self.shape, resampling)?;
        Ok(buffer.into_shape_and_vec().1)
    }
}

impl RasterFile {
    /// The systems of the run and of the file, where both have one.
    pub(super) fn systems(&self, run_crs: &Crs) -> Option<(SpatialRef, SpatialRef)> {
        match (run_crs, &self.crs) {
            (Crs::Projected(run), Some(own)) => Some((run.clone(), own.clone())),
            _ => None,
        }
    }

    /// What of the file a request asks for. Of a part beside it one cell is read.
    pub(super) fn extract(&self, request: &RasterRequest, run_crs: &Crs) -> Extract {
        let whole = self.dataset.raster_size();
        let cells = request.pixel.map_or(1.0, |pixel| (pixel / self.cell_in_metres()).floor().max(1.0));
        let [columns, rows] = request.part.and_then(|part| self.cells_of(part, run_crs)).map_or(
            [(0, whole.0), (0, whole.1)],
            |[across, down]| {
                let within = |(low, high): (f64, f64), count: usize| {
                    let first = (low - MARGIN * cells).floor().clamp(0.0, (count - 1) as f64) as usize;
                    let last = (high + MARGIN * cells).ceil().clamp((first + 1) as f64, count as f64) as usize;
                    (first, last - first)
                };
                [within(across, whole.0), within(down, whole.1)]
            },
        );
        let size = (columns.1, rows.1);
        let shape = |count: usize| (count as f64 / cells).ceil().max(1.0) as usize;
        Extract { first: (columns.0, rows.0), size, shape: (shape(size.0), shape(size.1)) }
    }

    /// Columns and rows, from and to, of a part of the map; none where its place in the file is not known.
    fn cells_of(&self, part: Rectangle, run_crs: &Crs) -> Option<[(f64, f64); 2]> {
        let mut places = along_sides(part);
        let placing = Placing { systems: self.systems(run_crs), geo_transform: self.geo_transform };
        placing.apply(&mut places, Path::new("")).ok()?;
        // Rows count downwards.
        let Rectangle { low, high } = Rectangle::about(places)?;
        Some([(low.x, high.x), (-high.y, -low.y)])
    }

    /// The rectangle about the file in the coordinates of the run; none where its place there is not known.
    pub fn rectangle(&self, run_crs: &Crs) -> Option<Rectangle> {
        let (columns, rows) = self.dataset.raster_size();
        let [x, a, b, y, d, e] = self.geo_transform;
        let cells = Rectangle { low: Vec2::ZERO, high: Vec2::new(columns as f64, rows as f64) };
        let on_map = |Vec2 { x: c, y: r }: Vec2| Vec2::new(x + a * c + b * r, y + d * c + e * r);
        let mut places: Vec<Vec2> = along_sides(cells).into_iter().map(on_map).collect();
        if let Some((run, own)) = self.systems(run_crs) {
            transform(&mut places, &own, &run).ok()?;
        }
        Rectangle::about(places)
    }
}

/// Places along the sides of a rectangle.
fn along_sides(Rectangle { low, high }: Rectangle) -> Vec<Vec2> {
    let place = |k: usize| low + (high - low) * (k as f64 / PLACES as f64);
    let of_sides =
        |at: Vec2| [Vec2::new(at.x, low.y), Vec2::new(at.x, high.y), Vec2::new(low.x, at.y), Vec2::new(high.x, at.y)];
    (0..=PLACES).map(place).flat_map(of_sides).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_lies_where_it_lies_in_the_file() {
        let of_file = [1000.0, 2.0, 0.0, 5000.0, 0.0, -2.0];
        let part = Extract { first: (10, 20), size: (7, 5), shape: (7, 5) };
        let expected = [1020.0, 2.0, 0.0, 4960.0, 0.0, -2.0];
        let found = part.geo_transform(of_file);
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9), "{found:?}");
        assert_eq!(part.in_file(8), (11, 21));
        // Seven columns as two: their outer edges stay.
        let coarse = Extract { shape: (2, 2), ..part };
        let [x, a, _, y, _, e] = coarse.geo_transform(of_file);
        assert!((x + 2.0 * a - 1034.0).abs() + (y + 2.0 * e - 4950.0).abs() < 1e-9, "{x}, {a}, {y}, {e}");
        assert_eq!(coarse.in_file(3), (13, 22));
    }
}
