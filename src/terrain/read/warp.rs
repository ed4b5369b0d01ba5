//! Rasters on a grid in the reference system of the run, with row 0 in the north.

use gdal::{DriverManager, GeoTransform};

use super::{Extract, RasterFile, RasterRequest, because};
use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::{Crs, capture, horizontal_part, warp_to_memory};
use crate::math::{Rectangle, in_bytes};
use crate::terrain::Raster;

impl RasterFile {
    /// Warps read values to a north-up grid in the CRS of the run, with square cells that fit the resolution.
    pub(super) fn warped(
        &self,
        values: Vec<f64>,
        extract: Extract,
        request: &RasterRequest,
        run_crs: &Crs,
    ) -> Result<Raster, Problem> {
        let (columns, rows) = extract.shape;
        let own = self.cell_in_metres() * extract.size.1 as f64 / rows as f64;
        let cell = fitting_cell(own, request.resolution);
        let area = columns as f64 * rows as f64 * own * own;
        check_memory(request, 3.0 * columns as f64 * rows as f64 + area / (cell * cell))?;
        let (result, messages) = capture(|| -> Result<Raster, String> {
            let text = |error: gdal::errors::GdalError| error.to_string();
            let driver = DriverManager::get_driver_by_name("MEM").map_err(text)?;
            let mut source = driver.create_with_band_type::<f64, _>("", columns, rows, 1).map_err(text)?;
            source.set_geo_transform(&extract.geo_transform(self.geo_transform)).map_err(text)?;
            let target = match (run_crs, &self.crs) {
                (Crs::Projected(run), Some(own)) => {
                    // Heights stay as they are: vertical units and datums of the systems, and grids of geoids, play no part.
                    source.set_spatial_ref(&horizontal_part(own)).map_err(text)?;
                    Some(horizontal_part(run).to_wkt().map_err(text)?)
                }
                _ => None,
            };
            let mut band = source.rasterband(1).map_err(text)?;
            band.set_no_data_value(Some(f64::NAN)).map_err(text)?;
            let mut buffer = gdal::raster::Buffer::new((columns, rows), values);
            band.write((0, 0), (columns, rows), &mut buffer).map_err(text)?;
            let cell_text = format!("{cell}");
            let mut arguments = vec!["-r", "bilinear", "-dstnodata", "nan", "-tr", &cell_text, &cell_text];
            // The cells of a part count from its corner, as those of the run do.
            let bounds = request.part.map(|part| bounds_about(part, cell));
            match &bounds {
                Some(bounds) => arguments.extend(std::iter::once("-te").chain(bounds.iter().map(String::as_str))),
                None => arguments.push("-tap"),
            }
            if let Some(target) = &target {
                arguments.extend(["-t_srs", target]);
            }
            let result = warp_to_memory(&source, &arguments)?;
            let (columns, rows) = result.raster_size();
            let band = result.rasterband(1).map_err(text)?;
            let buffer = band.read_as::<f64>((0, 0), (columns, rows), (columns, rows), None).map_err(text)?;
            let geo_transform = result.geo_transform().map_err(text)?;
            Ok(north_up(buffer.into_shape_and_vec().1, columns, rows, &geo_transform))
        });
        result.map_err(|error| {
            let problem = input_error(
                "warp-failed",
                format!("{} could not be warped to {}", request.path.display(), run_crs.describe()),
            );
            because(problem.with_cause(error), messages).with_remedy("check that `crs:` covers this place on Earth")
        })
    }

    /// Edge of a cell (m), roughly where the file counts in degrees.
    pub fn cell_in_metres(&self) -> f64 {
        /// Length of a degree of latitude (m).
        const DEGREE: f64 = 111_200.0;
        let [_, _, b, _, _, e] = self.geo_transform;
        let unit = match &self.crs {
            Some(crs) if crs.is_geographic() => DEGREE,
            Some(crs) if crs.is_projected() => crs.linear_units(),
            _ => 1.0,
        };
        b.hypot(e) * unit
    }
}

/// The cell for a warped raster: a whole multiple or a whole part of the resolution, close to the source's cell (m).
fn fitting_cell(source: f64, resolution: f64) -> f64 {
    if source >= resolution {
        resolution * (source / resolution).round()
    } else {
        resolution / (resolution / source).round()
    }
}

/// West, south, east and north (m) of whole cells about a part, counted from its corner, and some beyond it.
fn bounds_about(Rectangle { low, high }: Rectangle, cell: f64) -> [String; 4] {
    /// Cells beyond the part.
    const BEYOND: f64 = 4.0;
    let last = |low: f64, high: f64| low + (((high - low) / cell).ceil() + BEYOND) * cell;
    [low.x - BEYOND * cell, low.y - BEYOND * cell, last(low.x, high.x), last(low.y, high.y)]
        .map(|bound| format!("{bound}"))
}

/// Values of a grid without rotation, turned to row 0 in the north and column 0 in the west.
pub(super) fn north_up(values: Vec<f64>, columns: usize, rows: usize, geo_transform: &GeoTransform) -> Raster {
    let [x, cell_x, _, y, _, cell_y] = *geo_transform;
    let (south_up, east_first) = (cell_y > 0.0, cell_x < 0.0);
    let mut values = values;
    if east_first {
        values.chunks_exact_mut(columns.max(1)).for_each(<[f64]>::reverse);
    }
    if south_up {
        for row in 0..rows / 2 {
            let (above, below) = values.split_at_mut((rows - 1 - row) * columns);
            above[row * columns..][..columns].swap_with_slice(&mut below[..columns]);
        }
    }
    Raster {
        columns,
        rows,
        west: if east_first { x + columns as f64 * cell_x } else { x },
        north: if south_up { y + rows as f64 * cell_y } else { y },
        cell_x: cell_x.abs(),
        cell_y: cell_y.abs(),
        values,
    }
}

/// Refuses values that would not fit into the memory limit.
pub(super) fn check_memory(request: &RasterRequest, values: f64) -> Result<(), Problem> {
    let bytes = values * size_of::<f64>() as f64;
    if bytes <= request.memory {
        return Ok(());
    }
    let message = format!(
        "{} needs {} of memory, over the limit of {}",
        request.path.display(),
        in_bytes(bytes),
        in_bytes(request.memory)
    );
    Err(Problem::error(ProblemKind::Limit, "memory-limit", "", message).with_remedy(
        "cut the raster to the valley with `gdalwarp -te`, coarsen it with `-tr`, or raise `limits.memory`",
    ))
}
