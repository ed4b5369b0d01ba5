//! What `fields.nc` and `maps.nc` have in common: coordinates, coordinate reference system, global attributes.
//!
//! Cell centres in double precision, north to south, so that GDAL finds an even spacing and a north-up raster; `standard_name`
//! and `axis` on both, so that every reader finds the coordinates.

use std::ops::{Deref, DerefMut};
use std::path::Path;

use netcdf::{AttributeValue, FileMut, Options, VariableMut};

use super::super::OutputCrs;
use super::super::folder::output_error;
use super::super::grid::OutputGrid;
use super::Provenance;
use super::crs::WritableCrs;
use super::netcdf_raw::{SecondHold, with_caches_of};
use crate::calendar::cf;
use crate::error::Error;
use crate::geodata::keep_quiet;

/// Greatest edge of a chunk of a compressed variable, in cells.
const CHUNK: usize = 512;

/// Size of a chunk of single precision (bytes).
const CHUNK_BYTES: usize = CHUNK * CHUNK * size_of::<f32>();

/// Level of the deflate compression: higher ones cost several times as much for a few percent.
const DEFLATE: i32 = 1;

/// A NetCDF file while its contents are defined.
pub(super) struct NetcdfFile<'a> {
    pub(super) file: Written,
    pub(super) crs: &'a Option<WritableCrs>,
}

/// Everything that a NetCDF file of the run says besides its variables.
#[derive(Clone, Debug)]
pub(super) struct FileDescription {
    pub(super) grid: OutputGrid,
    pub(super) crs: OutputCrs,
    pub(super) provenance: Provenance,
}

impl<'a> NetcdfFile<'a> {
    /// Defines dimensions, coordinates, `crs` and global attributes in a file that was just created.
    pub(super) fn describe(
        file: Written,
        path: &Path,
        crs: &'a Option<WritableCrs>,
        description: &FileDescription,
    ) -> Result<Self, Error> {
        let mut netcdf = NetcdfFile { file, crs };
        netcdf.define(description).map_err(|cause| output_error(path, cause))?;
        Ok(netcdf)
    }

    fn define(&mut self, description: &FileDescription) -> netcdf::Result<()> {
        let FileDescription { grid, provenance, .. } = description;
        for (name, value) in provenance.global_attributes() {
            self.file.add_attribute(name, value)?;
        }
        if let Some(crs) = self.crs {
            for (name, value) in crs.geospatial_attributes(grid) {
                self.file.add_attribute(name, value)?;
            }
        }
        self.file.add_dimension("y", grid.rows)?;
        self.file.add_dimension("x", grid.columns)?;
        for (name, axis) in [("x", "X"), ("y", "Y")] {
            let mut variable = self.file.add_variable::<f64>(name, &[name])?;
            variable.put_attribute("standard_name", format!("projection_{name}_coordinate"))?;
            variable.put_attribute("long_name", format!("{name} coordinate of cell centre"))?;
            variable.put_attribute("units", "m")?;
            variable.put_attribute("axis", axis)?;
        }
        if let Some(crs) = self.crs {
            define_crs(&mut self.file, crs)?;
        }
        Ok(())
    }

    /// Writes the coordinates; a classic file must have left its define mode.
    pub(super) fn write_coordinates(&mut self, grid: &OutputGrid) -> netcdf::Result<()> {
        for (name, values) in [("x", grid.x()), ("y", grid.y())] {
            self.variable(name)?.put_values(&values, ..)?;
        }
        if self.crs.is_some() {
            self.variable("crs")?.put_value(0_i32, ())?;
        }
        Ok(())
    }

    /// A variable that was defined before.
    pub(super) fn variable(&mut self, name: &str) -> netcdf::Result<VariableMut<'_>> {
        variable(&mut self.file, name)
    }

    /// Adds the attributes that a variable over the grid has besides its own.
    pub(super) fn georeference(&mut self, name: &str) -> netcdf::Result<()> {
        if let Some(crs) = self.crs {
            let mut variable = self.variable(name)?;
            variable.put_attribute("grid_mapping", "crs")?;
            if let Some(esri_wkt) = &crs.esri_wkt {
                variable.put_attribute("esri_pe_string", esri_wkt.as_str())?;
            }
        }
        Ok(())
    }

    /// Asks for chunks and compression (NetCDF-4 only); `lengths` are the lengths of the dimensions, 1 for time.
    pub(super) fn compress(&mut self, name: &str, lengths: &[usize]) -> netcdf::Result<()> {
        let chunks: Vec<usize> = lengths.iter().map(|length| *length.min(&CHUNK)).collect();
        let mut variable = self.variable(name)?;
        variable.set_chunking(&chunks)?;
        variable.set_compression(DEFLATE, true)
    }

    /// Defines variables that are compressed and written whole, chunk by chunk.
    pub(super) fn define_compressed(
        &mut self,
        define: impl FnOnce(&mut Self) -> netcdf::Result<()>,
    ) -> netcdf::Result<()> {
        with_caches_of(CHUNK_BYTES, || define(self))
    }

    /// Puts text attributes, leaving out empty ones.
    pub(super) fn describe_variable(&mut self, name: &str, attributes: &[(&str, &str)]) -> netcdf::Result<()> {
        put_texts(&mut self.variable(name)?, attributes)
    }

    /// Defines a time variable over the given dimensions.
    pub(super) fn define_time(&mut self, dimensions: &[&str], provenance: &Provenance) -> netcdf::Result<()> {
        self.file.add_variable::<f64>("time", dimensions)?;
        put_time_attributes(&mut self.file, provenance)
    }
}

/// A file that is written.
#[derive(Debug)]
pub(super) struct Written {
    // Given up in this order.
    file: FileMut,
    hold: SecondHold,
}

impl Written {
    /// Creates a file; what goes wrong with it is returned, and not written to stderr.
    pub(super) fn create(path: &Path, options: Options) -> netcdf::Result<Self> {
        keep_quiet();
        let file = netcdf::create_with(path, options)?;
        Ok(Written { file, hold: SecondHold::on(path) })
    }

    /// Opens a classic file that goes on.
    pub(super) fn append(path: &Path) -> netcdf::Result<Self> {
        Ok(Written { file: netcdf::append(path)?, hold: SecondHold::NONE })
    }

    /// Closes a file once all of it is written. What cannot be flushed stays open; the program leaves without closing what is open.
    pub(super) fn close(self) -> netcdf::Result<()> {
        match self.file.sync() {
            Ok(()) => {
                let Written { file, hold } = self;
                file.close().and_then(|()| hold.close())
            }
            Err(error) => {
                std::mem::forget(self);
                Err(error)
            }
        }
    }
}

impl Deref for Written {
    type Target = FileMut;

    fn deref(&self) -> &FileMut {
        &self.file
    }
}

impl DerefMut for Written {
    fn deref_mut(&mut self) -> &mut FileMut {
        &mut self.file
    }
}

/// Puts text attributes, leaving out empty ones.
pub(super) fn put_texts(variable: &mut VariableMut<'_>, attributes: &[(&str, &str)]) -> netcdf::Result<()> {
    for (key, value) in attributes.iter().filter(|(_, value)| !value.is_empty()) {
        variable.put_attribute(key, AttributeValue::from(*value))?;
    }
    Ok(())
}

/// A variable that was defined before.
pub(super) fn variable<'f>(file: &'f mut FileMut, name: &str) -> netcdf::Result<VariableMut<'f>> {
    file.variable_mut(name).ok_or_else(|| netcdf::Error::NotFound(name.to_string()))
}

/// Defines the variable `crs`, to which `grid_mapping` refers.
pub(super) fn define_crs<'f>(file: &'f mut FileMut, crs: &WritableCrs) -> netcdf::Result<VariableMut<'f>> {
    let mut variable = file.add_variable::<i32>("crs", &[])?;
    for (name, value) in &crs.attributes {
        variable.put_attribute(name, value.clone())?;
    }
    Ok(variable)
}

/// Describes the variable `time`.
pub(super) fn put_time_attributes(file: &mut FileMut, provenance: &Provenance) -> netcdf::Result<()> {
    let mut time = variable(file, "time")?;
    let units = provenance.time_units();
    let attributes = [
        ("standard_name", "time"),
        ("long_name", "time"),
        ("units", units.as_str()),
        ("calendar", cf::CALENDAR),
        ("units_metadata", "leap_seconds: none"),
        ("axis", "T"),
    ];
    for (key, value) in attributes {
        time.put_attribute(key, AttributeValue::from(value))?;
    }
    Ok(())
}
