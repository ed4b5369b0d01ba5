//! Results are read back before they get their names: a file is what was written, or it is not there.
//!
//! A library may say nothing of a write that failed, or say it where nobody listens: the crate of GDAL forgets what the end of a file came to, and
//! its drivers go on after a message.

use std::path::Path;

use bytemuck::{NoUninit, cast_slice};
use gdal::Dataset;
use gdal::raster::GdalType;
use gdal::vector::LayerAccess;
use netcdf::Extents;
use netcdf::types::NcTypeDescriptor;

use super::super::folder::output_error;
use super::netcdf_raw::SecondHold;
use crate::error::Error;
use crate::geodata::{heard, keep_quiet};

/// Writes a file of GDAL and reads it back; any message of GDAL meanwhile is an error.
pub(super) fn without_messages(path: &Path, work: impl FnOnce() -> Result<(), Error>) -> Result<(), Error> {
    let (done, messages) = heard(work);
    done.and_then(|()| match messages.first() {
        Some(message) => Err(output_error(path, message)),
        None => Ok(()),
    })
}

fn differs(path: &Path, what: &str) -> Error {
    output_error(path, format!("{what} reads back otherwise than it was written"))
}

/// A NetCDF file that is read back.
pub(super) struct ReadBack<'a> {
    path: &'a Path,
    // Given up in this order.
    file: netcdf::File,
    _hold: SecondHold,
}

impl<'a> ReadBack<'a> {
    pub(super) fn open(path: &'a Path) -> Result<Self, Error> {
        keep_quiet();
        let file = netcdf::open(path).map_err(|cause| output_error(path, cause))?;
        Ok(ReadBack { path, file, _hold: SecondHold::on(path) })
    }

    /// Compares a part of a variable, bit for bit.
    pub(super) fn compare<T: NcTypeDescriptor + Copy + NoUninit>(
        &self,
        name: &str,
        part: impl TryInto<Extents, Error: Into<netcdf::Error>>,
        values: &[T],
    ) -> Result<(), Error> {
        let variable = self.file.variable(name).ok_or_else(|| differs(self.path, name))?;
        let part = part.try_into().map_err(|cause| output_error(self.path, Into::<netcdf::Error>::into(cause)))?;
        let read: Vec<T> = variable.get_values(part).map_err(|cause| output_error(self.path, cause))?;
        if cast_slice::<T, u8>(&read) == cast_slice::<T, u8>(values) { Ok(()) } else { Err(differs(self.path, name)) }
    }
}

/// Compares the values of a raster of one band, bit for bit, and reads its overviews.
pub(super) fn compare_raster<T: GdalType + Copy + NoUninit>(path: &Path, values: &[T]) -> Result<(), Error> {
    let read = || -> gdal::errors::Result<Vec<T>> {
        let dataset = Dataset::open(path)?;
        let band = dataset.rasterband(1)?;
        for overview in 0..band.overview_count()? {
            band.overview(overview as usize)?.read_band_as::<T>()?;
        }
        Ok(band.read_band_as::<T>()?.data().to_vec())
    };
    let read = read().map_err(|cause| output_error(path, cause))?;
    if cast_slice::<T, u8>(&read) == cast_slice::<T, u8>(values) { Ok(()) } else { Err(differs(path, "the raster")) }
}

/// Compares the numbers of features of the layers of a GeoPackage, and lets SQLite look through it.
pub(super) fn compare_layers(path: &Path, layers: &[(String, u64)]) -> Result<(), Error> {
    let failed = |cause: gdal::errors::GdalError| output_error(path, cause);
    let dataset = Dataset::open(path).map_err(failed)?;
    for (name, count) in layers {
        let mut layer = dataset.layer_by_name(name).map_err(failed)?;
        if layer.features().count() as u64 != *count {
            return Err(differs(path, &format!("the layer {name}")));
        }
    }
    let check = dataset.execute_sql("PRAGMA integrity_check", None, gdal::vector::sql::Dialect::DEFAULT);
    let mut answers = check.map_err(failed)?.ok_or_else(|| differs(path, "the database"))?;
    let answer = answers.features().next().and_then(|feature| feature.field_as_string(0).ok().flatten());
    match answer {
        Some(answer) if answer == "ok" => Ok(()),
        answer => Err(output_error(path, answer.unwrap_or_default())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_written_is_seen() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.nc");
        let mut file = netcdf::create(&path).unwrap();
        file.add_dimension("x", 3).unwrap();
        file.add_variable::<f32>("depth", &["x"]).unwrap().put_values(&[1.0_f32, f32::NAN, -0.0], ..).unwrap();
        file.close().unwrap();
        let back = ReadBack::open(&path).unwrap();
        assert!(back.compare("depth", .., &[1.0_f32, f32::NAN, -0.0]).is_ok());
        assert!(back.compare("depth", .., &[1.0_f32, f32::NAN, 0.0]).is_err());
        assert!(back.compare("depth", .., &[1.0_f32]).is_err());
        assert!(back.compare("speed", .., &[1.0_f32]).is_err());
    }
}
