//! The sound inputs that are not text: GeoTIFF, NetCDF of both forms, GeoPackage and shapefile.

use std::path::Path;

use gdal::raster::{Buffer, GdalDataType, GdalType, RasterCreationOptions};
use gdal::spatial_ref::SpatialRef;
use gdal::vector::{Geometry, LayerAccess, LayerOptions, OGRwkbGeometryType};
use gdal::{Dataset, DriverManager};
use netcdf::Options;

use crate::scene::{CELL, COLUMNS, CORNER, ROWS, elevation};

/// Where the terrain lies in the system of the map `EPSG:25832`, and in degrees.
const UTM: [f64; 2] = [500_000.0, 5_300_000.0];
const DEGREES: [f64; 2] = [9.0, 47.85];

/// Writes all of them into a folder.
pub fn write(folder: &Path) {
    let at = |name: &str| folder.join(name);
    let slide = |column, row| if (4..6).contains(&column) && (2..4).contains(&row) { 0.5 } else { 0.0 };
    let uplift = |column, row| if (4..8).contains(&column) && (6..10).contains(&row) { 0.5 } else { 0.0 };
    raster::<f32>(&at("dem.tif"), &[], None, elevation);
    raster::<f32>(
        &at("dem_tiled.tif"),
        &["COMPRESS=LZW", "TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16"],
        None,
        elevation,
    );
    raster::<f64>(&at("dem_utm.tif"), &["COMPRESS=DEFLATE"], Some(("EPSG:25832", UTM, CELL)), elevation);
    raster::<f32>(&at("dem_degrees.tif"), &[], Some(("EPSG:4326", DEGREES, 5e-5)), elevation);
    raster::<f32>(&at("manning.tif"), &[], None, |column, _| 0.02 + 0.001 * column as f64);
    raster::<u8>(&at("classes.tif"), &[], None, |column, _| (column / 6 + 1) as f64);
    raster::<f32>(&at("rain.tif"), &[], None, |_, _| 20.0);
    raster::<f32>(&at("uplift.tif"), &[], None, uplift);
    raster::<f32>(&at("slide.tif"), &[], None, slide);
    terrain(&at("dem.nc"), Options::NETCDF4);
    terrain(&at("dem_classic.nc"), Options::_64BIT_OFFSET);
    radar(&at("radar.nc"));
    package(&at("layers.gpkg"));
    shapefile(&at("wall_utm.shp"));
}

/// A GeoTIFF of the terrain's size; without a system it lies where the others do.
fn raster<T: GdalType + Copy + FromNumber>(
    path: &Path,
    options: &[&str],
    place: Option<(&str, [f64; 2], f64)>,
    value: impl Fn(usize, usize) -> f64,
) {
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let options = RasterCreationOptions::from_iter(options.iter().copied());
    let mut dataset = driver.create_with_band_type_with_options::<T, _>(path, COLUMNS, ROWS, 1, &options).unwrap();
    let (crs, [west, south], cell) = place.unwrap_or(("", CORNER, CELL));
    dataset.set_geo_transform(&[west, cell, 0.0, south + ROWS as f64 * cell, 0.0, -cell]).unwrap();
    if !crs.is_empty() {
        dataset.set_spatial_ref(&SpatialRef::from_definition(crs).unwrap()).unwrap();
    }
    let values = (0..ROWS * COLUMNS).map(|k| T::from_number(value(k % COLUMNS, k / COLUMNS))).collect();
    let mut band = dataset.rasterband(1).unwrap();
    let no_data = if T::datatype() == GdalDataType::UInt8 { 255.0 } else { -9999.0 };
    band.set_no_data_value(Some(no_data)).unwrap();
    band.write((0, 0), (COLUMNS, ROWS), &mut Buffer::new((COLUMNS, ROWS), values)).unwrap();
    dataset.close().unwrap();
}

/// A number as a raster holds it.
trait FromNumber {
    fn from_number(number: f64) -> Self;
}

impl FromNumber for f32 {
    fn from_number(number: f64) -> f32 {
        number as f32
    }
}

impl FromNumber for f64 {
    fn from_number(number: f64) -> f64 {
        number
    }
}

impl FromNumber for u8 {
    fn from_number(number: f64) -> u8 {
        number as u8
    }
}

/// The axes of a NetCDF file.
fn axes(file: &mut netcdf::FileMut) {
    for (name, length) in [("y", ROWS), ("x", COLUMNS)] {
        file.add_dimension(name, length).unwrap();
        let mut axis = file.add_variable::<f64>(name, &[name]).unwrap();
        axis.put_attribute("units", "m").unwrap();
        axis.put_attribute("standard_name", format!("projection_{name}_coordinate")).unwrap();
    }
}

fn put(file: &mut netcdf::FileMut, name: &str, values: &[f64]) {
    file.variable_mut(name).unwrap().put_values(values, ..).unwrap();
}

fn put_axes(file: &mut netcdf::FileMut) {
    let x: Vec<f64> = (0..COLUMNS).map(|column| CORNER[0] + CELL * (column as f64 + 0.5)).collect();
    let y: Vec<f64> = (0..ROWS).map(|row| CORNER[1] + CELL * ((ROWS - row) as f64 - 0.5)).collect();
    put(file, "x", &x);
    put(file, "y", &y);
}

fn terrain(path: &Path, form: Options) {
    let mut file = netcdf::create_with(path, form).unwrap();
    axes(&mut file);
    let mut heights = file.add_variable::<f32>("elevation", &["y", "x"]).unwrap();
    heights.put_attribute("units", "m").unwrap();
    heights.put_attribute("_FillValue", -9999.0f32).unwrap();
    file.enddef().unwrap();
    put_axes(&mut file);
    let heights: Vec<f64> = (0..ROWS * COLUMNS).map(|k| elevation(k % COLUMNS, k / COLUMNS)).collect();
    put(&mut file, "elevation", &heights);
    file.close().unwrap();
}

fn radar(path: &Path) {
    let mut file = netcdf::create_with(path, Options::NETCDF4).unwrap();
    file.add_dimension("time", 4).unwrap();
    let mut time = file.add_variable::<f64>("time", &["time"]).unwrap();
    time.put_attribute("units", "seconds since 2026-06-01 06:00:00").unwrap();
    time.put_attribute("calendar", "standard").unwrap();
    axes(&mut file);
    let mut rain = file.add_variable::<f32>("rainfall", &["time", "y", "x"]).unwrap();
    rain.put_attribute("units", "mm/h").unwrap();
    file.enddef().unwrap();
    put_axes(&mut file);
    put(&mut file, "time", &[0.0, 2.0, 4.0, 6.0]);
    put(&mut file, "rainfall", &[20.0; 4 * ROWS * COLUMNS]);
    file.close().unwrap();
}

/// Adds a layer with one feature, which is given from the south-western corner of the terrain.
fn layer(dataset: &mut Dataset, name: &str, kind: OGRwkbGeometryType::Type, geometry: &str) {
    let srs = SpatialRef::from_epsg(25832).unwrap();
    let mut layer = dataset.create_layer(LayerOptions { name, srs: Some(&srs), ty: kind, options: None }).unwrap();
    layer.create_feature(Geometry::from_wkt(geometry).unwrap()).unwrap();
}

fn package(path: &Path) {
    let mut dataset = DriverManager::get_driver_by_name("GPKG").unwrap().create_vector_only(path).unwrap();
    let [west, south] = UTM;
    let (east, north) = (west + 40.0, south + 80.0);
    let lake = format!("POLYGON (({west} {south}, {east} {south}, {east} {north}, {west} {north}, {west} {south}))");
    layer(&mut dataset, "lake", OGRwkbGeometryType::wkbPolygon, &lake);
    let spring = format!("POINT ({} {})", west + 60.0, south + 45.0);
    layer(&mut dataset, "springs", OGRwkbGeometryType::wkbPoint, &spring);
    dataset.close().unwrap();
}

fn shapefile(path: &Path) {
    let driver = DriverManager::get_driver_by_name("ESRI Shapefile").unwrap();
    let mut dataset = driver.create_vector_only(path).unwrap();
    let (x, south) = (UTM[0] + 80.0, UTM[1]);
    let wall = format!("LINESTRING ({x} {}, {x} {})", south + 10.0, south + 30.0);
    layer(&mut dataset, "wall_utm", OGRwkbGeometryType::wkbLineString, &wall);
    dataset.close().unwrap();
}
