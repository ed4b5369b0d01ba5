//! Whether the heights of a raster are those of Earth, in the unit that the scenario takes them for.

use std::ops::RangeInclusive;
use std::path::Path;

use gdal::spatial_ref::SpatialRef;

use super::{BEYOND_BOUNDS, RasterFile, RasterRequest, UNDECLARED};
use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::cf_axes::metres_of;
use crate::geodata::{vertical_datum, vertical_points_down, vertical_unit};
use crate::terrain::Raster;

/// Elevations (m) outside this range are doubtful on Earth: sea trenches and fill values below, fill values above.
pub const PLAUSIBLE_ELEVATION: RangeInclusive<f64> = -500.0..=9000.0;

impl RasterFile {
    /// The unit that the file gives for its values; empty where it gives none.
    pub fn unit(&self) -> String {
        self.dataset.rasterband(1).map(|band| band.unit()).unwrap_or_default().trim().to_owned()
    }

    /// Refuses heights whose unit in the file, or in its reference system, is another than that of the scenario (so many metres; none where it
    /// does not say).
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn check_unit_of_heights(&self, unit: Option<f64>, path: &Path) -> Result<(), Problem> {
        /// The two feet differ by 2e-6, which no terrain knows.
        const SAME: f64 = 1e-5;
        let mut written = self.unit();
        let mut own = metres_of(&written);
        if written.is_empty()
            && let Some((name, metres)) = self.crs.as_ref().and_then(vertical_unit)
        {
            (written, own) = (name, Some(metres));
        }
        if written.is_empty() && unit.is_none() {
            return self.ask_for_unit(path);
        }
        let unit = unit.unwrap_or(1.0);
        if written.is_empty() || own.is_some_and(|own| (own / unit - 1.0).abs() < SAME) {
            return Ok(());
        }
        let read_as = if (unit - 1.0).abs() < SAME { "metres".to_owned() } else { format!("units of {unit} m") };
        let message =
            format!("{} gives its heights in `{written}`, and they would be read as {read_as}", path.display());
        let correct = "correct that of the file (`ncatted` for NetCDF, `gdal_edit.py -units` for GeoTIFF)";
        Err(input_error("unit-of-elevation", message).with_remedy(match own.and_then(key_of_unit) {
            Some(key) => format!("say `unit: {key}` in the scenario, or {correct}"),
            None => format!("bring them to metres; where they are in metres, {correct}"),
        }))
    }

    /// Refuses heights of which neither the file nor the scenario says the unit, where the places count in feet.
    fn ask_for_unit(&self, path: &Path) -> Result<(), Problem> {
        // Both feet, and no other unit of maps.
        let is_foot = |crs: &&SpatialRef| crs.is_projected() && (crs.linear_units() / 0.3048 - 1.0).abs() < 0.01;
        let feet = self.crs.as_ref().filter(is_foot);
        let Some(crs) = feet else { return Ok(()) };
        let places = crs.linear_units_name().unwrap_or_default();
        let message = format!(
            "{} counts its places in `{places}` and does not say in what it counts its heights",
            path.display()
        );
        let feet = key_of_unit(crs.linear_units()).unwrap_or("ft");
        Err(input_error("elevation-unit-unknown", message)
            .with_cause("terrain in such systems has heights in feet as often as in metres, and every slope would be 3.28 times too steep or too flat")
            .with_remedy(format!("say `unit: {feet}` or `unit: m` in the layer")))
    }

    /// Refuses depths: values that count downwards.
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn check_direction(&self, path: &Path) -> Result<(), Problem> {
        let of_system = || self.crs.as_ref().filter(|crs| vertical_points_down(crs)).and_then(vertical_datum);
        let Some(said) = self.said.downward.clone().or_else(of_system) else { return Ok(()) };
        let message = format!(
            "{} counts downwards (`{said}`): its values are depths, and terrain needs elevations",
            path.display()
        );
        Err(input_error("heights-downward", message)
            .with_cause("hills would be read as valleys")
            .with_remedy("turn them: `ncap2 -s 'NAME=-NAME;NAME@positive=\"up\"' IN OUT` for NetCDF and delete a standard_name of a depth, otherwise `gdal_calc.py -A IN --outfile OUT --calc=-A`; where they are elevations, correct that attribute"))
    }

    /// Refuses a raster without data, warns of elevations that Earth does not have.
    pub(super) fn check_values(&mut self, raster: &Raster, request: &RasterRequest) -> Result<(), Problem> {
        let name = request.path.display();
        let (mut least, mut greatest, mut doubtful) = (f64::INFINITY, f64::NEG_INFINITY, None);
        let mut count = 0;
        for (index, &value) in raster.values.iter().enumerate().filter(|(_, v)| !v.is_nan()) {
            least = least.min(value);
            greatest = greatest.max(value);
            if !PLAUSIBLE_ELEVATION.contains(&value) {
                count += 1;
                doubtful.get_or_insert(index);
            }
        }
        // A part may lie beside the data.
        if least > greatest && request.part.is_none() {
            let problem = input_error("all-nodata", format!("{name} holds no data at all: every cell is nodata"));
            // The attribute that took them out is the place to look at.
            return Err(match self.warnings.iter().find(|warning| warning.code == BEYOND_BOUNDS) {
                Some(bounds) => {
                    problem.with_cause(bounds.message.clone()).with_remedy(bounds.remedy.clone().unwrap_or_default())
                }
                None => problem.with_remedy("check the nodata value with `gdalinfo -stats`"),
            });
        }
        // A mark is reported as one.
        let is_reported = self.warnings.iter().any(|warning| warning.code == UNDECLARED);
        if let Some(index) = doubtful.filter(|_| !is_reported) {
            let message = format!(
                "{name} has {count} elevations outside {} to {} m (from {least:.1} to {greatest:.1} m)",
                PLAUSIBLE_ELEVATION.start(),
                PLAUSIBLE_ELEVATION.end()
            );
            self.warnings.push(
                Problem::warning(ProblemKind::Input, "doubtful-elevation", "", message)
                    .with_cause("a fill value that the file does not declare as nodata, or another unit than metres")
                    .with_remedy("declare the fill value with `gdal_edit.py -a_nodata`, or give the layer its `unit`")
                    .with_at(raster.centre(index % raster.columns, index / raster.columns)),
            );
        }
        Ok(())
    }
}

/// The key of the scenario for a unit of heights (so many metres); none where it has none.
fn key_of_unit(metres: f64) -> Option<&'static str> {
    const KEYS: [(&str, f64); 6] =
        [("m", 1.0), ("dm", 0.1), ("cm", 0.01), ("mm", 0.001), ("ft", 0.3048), ("us_ft", 1200.0 / 3937.0)];
    KEYS.iter().find(|(_, factor)| (metres / factor - 1.0).abs() < 1e-9).map(|(name, _)| *name)
}
