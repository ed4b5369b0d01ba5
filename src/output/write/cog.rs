//! `cog/*.tif`: the maps as cloud-optimised GeoTIFFs, with a QGIS style beside each.
//!
//! Each map is filled in memory and copied, since the COG driver can only copy. The copy is made in memory, too, and its bytes are written here: the
//! driver goes on where a write to the disk fails, and says nothing. Overviews take the nearest value: a mean of arrival times, or of wet and dry,
//! would show what no cell has seen.

use std::path::{Path, PathBuf};

use gdal::cpl::CslStringList;
use gdal::raster::{Buffer, ColorEntry, ColorTable, GdalType, PaletteInterpretation, RasterBand};
use gdal::vsi::{call_on_mem_file_bytes, unlink_mem_file};
use gdal::{Dataset, DriverManager, Metadata};
use rayon::prelude::*;

use super::super::folder::{RunFolder, output_error};
use super::super::grid::{FILL, OutputGrid};
use super::crs::WritableCrs;
use super::gdal_raw::set_unit;
use super::qgis::raster_style;
use super::read_back::{compare_raster, without_messages};
use super::variables::{MapClass, MapKind, MapVariable};
use super::{FileHead, Provenance};
use crate::error::Error;

/// So many maps are written at once: each takes its pixels twice more.
const AT_ONCE: usize = 4;
/// "No value" in the class map, which is of bytes: colour tables need them.
const CLASS_FILL: u8 = 255;

/// Writes one COG and one style for each map.
///
/// # Errors
/// When a file cannot be written.
pub fn write_cogs(
    folder: &RunFolder,
    grid: &OutputGrid,
    FileHead { crs, provenance }: FileHead<'_>,
    maps: &[MapVariable<'_>],
) -> Result<(), Error> {
    let write = |map: &MapVariable<'_>| {
        let crs = WritableCrs::new(crs, &folder.file("cog"))?;
        let write = |path: &Path| {
            let failed = |cause: gdal::errors::GdalError| output_error(path, cause);
            let whole = MemoryFile::beside(path);
            let mut options = CslStringList::new();
            for option in ["COMPRESS=DEFLATE", "PREDICTOR=YES", "BLOCKSIZE=512", "OVERVIEWS=AUTO", "RESAMPLING=NEAREST"]
            {
                options.add_string(option).map_err(failed)?;
            }
            let driver = DriverManager::get_driver_by_name("COG").map_err(failed)?;
            let source = in_memory(map, grid, &crs, provenance).map_err(failed)?;
            source.create_copy(&driver, &whole.0, &options).and_then(Dataset::close).map_err(failed)?;
            drop(source);
            whole.write_to(path)?;
            match map.kind {
                MapKind::Class => compare_raster(path, &classes_of(map)),
                _ => compare_raster(path, map.values),
            }
        };
        let name = format!("cog/{}.tif", map.name);
        folder.write_with(&name, |path| without_messages(path, || write(path)))?;
        folder.write(&format!("cog/{}.qml", map.name), raster_style(map).as_bytes())
    };
    for maps in maps.chunks(AT_ONCE) {
        let written: Vec<Result<(), Error>> = maps.par_iter().map(write).collect();
        written.into_iter().collect::<Result<(), Error>>()?;
    }
    Ok(())
}

/// A file that GDAL has in memory.
struct MemoryFile(PathBuf);

impl MemoryFile {
    /// The name of one that stands for a file of the disk.
    fn beside(path: &Path) -> Self {
        MemoryFile(Path::new("/vsimem").join(path.strip_prefix("/").unwrap_or(path)))
    }

    /// Writes its bytes to the disk.
    fn write_to(&self, path: &Path) -> Result<(), Error> {
        let written = call_on_mem_file_bytes(&self.0, |bytes| std::fs::write(path, bytes));
        let written = written.map_err(|cause| output_error(path, cause))?;
        written.map_err(|cause| output_error(path, cause))
    }
}

impl Drop for MemoryFile {
    fn drop(&mut self) {
        // Where the driver has not come so far there is none.
        let _ = unlink_mem_file(&self.0);
    }
}

/// The values of a map of classes.
fn classes_of(map: &MapVariable<'_>) -> Vec<u8> {
    let is_filled = |value: &f32| value.to_bits() == FILL.to_bits();
    map.values.iter().map(|value| if is_filled(value) { CLASS_FILL } else { *value as u8 }).collect()
}

fn in_memory(
    map: &MapVariable<'_>,
    grid: &OutputGrid,
    crs: &Option<WritableCrs>,
    provenance: &Provenance,
) -> gdal::errors::Result<Dataset> {
    let mut dataset = if map.kind == MapKind::Class {
        let dataset = filled(grid, classes_of(map))?;
        let mut band = dataset.rasterband(1)?;
        band.set_no_data_value(Some(f64::from(CLASS_FILL)))?;
        set_class_colours(&mut band, &map.classes);
        dataset
    } else {
        let dataset = filled(grid, map.values.to_vec())?;
        dataset.rasterband(1)?.set_no_data_value(Some(f64::from(FILL)))?;
        dataset
    };
    dataset.set_geo_transform(&[grid.west, grid.cell, 0.0, grid.north, 0.0, -grid.cell])?;
    if let Some(crs) = crs {
        dataset.set_spatial_ref(&crs.spatial_ref)?;
    }
    for (key, value) in [("TITLE", &provenance.title), ("SOURCE", &provenance.source), ("COMMENT", &map.comment)] {
        dataset.set_metadata_item(key, value, "")?;
    }
    dataset.set_metadata_item("AREA_OR_POINT", "Area", "")?;
    let mut band = dataset.rasterband(1)?;
    band.set_description(&map.long_name)?;
    set_unit(&mut band, map.units)?;
    Ok(dataset)
}

fn filled<T: GdalType + Copy>(grid: &OutputGrid, values: Vec<T>) -> gdal::errors::Result<Dataset> {
    let driver = DriverManager::get_driver_by_name("MEM")?;
    let dataset = driver.create_with_band_type::<T, _>("", grid.columns, grid.rows, 1)?;
    let size = (grid.columns, grid.rows);
    dataset.rasterband(1)?.write((0, 0), size, &mut Buffer::new(size, values))?;
    Ok(dataset)
}

fn set_class_colours(band: &mut RasterBand<'_>, classes: &[MapClass]) {
    let mut colours = ColorTable::new(PaletteInterpretation::Rgba);
    for class in classes {
        let [red, green, blue] = class.colour.unwrap_or([255; 3]).map(i16::from);
        let alpha = if class.colour.is_some() { 255 } else { 0 };
        colours.set_color_entry(u16::from(class.value), &ColorEntry::rgba(red, green, blue, alpha));
    }
    band.set_color_table(&colours);
}
