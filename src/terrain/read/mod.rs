//! Raster files to [`Raster`]: any data type, nodata, scale, offset, orientation and CRS that GDAL knows.

mod dataset;
mod extract;
mod heights;
mod placing;
mod undeclared;
mod values;
mod warp;

use std::path::Path;

use gdal::raster::{GdalDataType, ResampleAlg};
use gdal::spatial_ref::{AxisMappingStrategy, SpatialRef};
use gdal::{Dataset, GeoTransform, Metadata};

use super::Raster;
use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::cf_axes::{self, gdal_name, raster_variables, split_variable};
use crate::geodata::cf_heights::{Said, check_spacing, said_of};
use crate::geodata::{
    Crs, CrsProblem, capture, describe, is_metric, netcdf_file, open, readable_file, same_horizontal, spatial_ref,
    suggested_utm, transform,
};
use crate::math::{Rectangle, Vec2};
use dataset::{Closing, keep_cache_small};
use extract::Extract;
pub use heights::PLAUSIBLE_ELEVATION;
pub use placing::Placing;
use values::alpha_band;
use warp::{check_memory, north_up};

/// Share of a cell by which no cell of a grid is off that counts as straight.
const STRAIGHT: f64 = 1e-3;

/// The code of the warning of values that the file itself calls invalid.
const BEYOND_BOUNDS: &str = "outside-valid-range";

/// The code of the error of numbers that stand for no data without being declared.
const UNDECLARED: &str = "undeclared-nodata";

/// How a raster file is to be understood.
#[derive(Clone, Debug)]
pub struct RasterRequest<'a> {
    /// The file.
    pub path: &'a Path,
    /// Factor from the file's unit to metres.
    pub unit: f64,
    /// Added to every elevation (m).
    pub offset: f64,
    /// Whether another CRS, degrees or a rotated grid are warped to the CRS of the run.
    pub reproject: bool,
    /// Distance of two particles (m): a warped raster gets a cell that fits into it.
    pub resolution: f64,
    /// Memory limit (bytes).
    pub memory: f64,
    /// The part of the map that is read; none for all of it.
    pub part: Option<Rectangle>,
    /// Edge of the pixels (m) that do; none for those of the file.
    pub pixel: Option<f64>,
    /// Whether the values are elevations, among which marks of no data stand out.
    pub is_ground: bool,
}

/// A raster file, opened but not yet read.
#[derive(Debug)]
pub struct RasterFile {
    dataset: Closing,
    geo_transform: GeoTransform,
    crs: Option<SpatialRef>,
    /// What a NetCDF file itself says of its values.
    said: Said,
    /// Warnings met so far, without key and place.
    pub warnings: Vec<Problem>,
}

fn is_netcdf(dataset: &Dataset) -> bool {
    dataset.driver().short_name() == "netCDF"
}

/// No raster on Earth has narrower cells (m).
const LEAST_PIXEL: f64 = 1e-3;

/// Refuses a NetCDF file without a variable of that name.
fn check_variable(path: &Path, variable: &str) -> Result<(), Problem> {
    if netcdf_file::open(path).is_ok_and(|file| file.variable(variable).is_none()) {
        let message = format!("{} has no variable `{variable}`", path.display());
        return Err(input_error("no-variable", message)
            .with_cause(format!("it has {}", raster_variables(path).join(", ")))
            .with_remedy("correct the name behind the colon"));
    }
    Ok(())
}

fn no_band(path: &Path, is_netcdf: bool) -> Problem {
    let name = path.display();
    let variables = if is_netcdf { raster_variables(path) } else { Vec::new() };
    let Some(first) = variables.first() else {
        return input_error("not-a-raster", format!("{name} holds no raster band")).with_remedy(
            "write one of its subdatasets, which `gdalinfo FILE` lists, to a file of its own: `gdal_translate SUBDATASET OUT`",
        );
    };
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    input_error("no-variable", format!("which variable of {name} is meant is not known"))
        .with_cause(format!("it has {}", variables.join(", ")))
        .with_remedy(format!("name one behind a colon, as in `{file}:{first}`"))
}

/// Refuses a NetCDF variable that would be read transposed, at other places or in another unit of length; returns what it says of its values.
fn look_at_variable(path: &Path, dataset: &Dataset, crs: Option<&SpatialRef>) -> Result<Said, Problem> {
    let Ok(band) = dataset.rasterband(1) else { return Ok(Said::default()) };
    let Some(variable) = band.metadata_item("NETCDF_VARNAME", "") else { return Ok(Said::default()) };
    let file = match netcdf_file::open(path) {
        Ok(file) => file,
        Err(netcdf::Error::Str(cause)) => return Err(netcdf_file::refused(path, cause)),
        Err(_) => return Ok(Said::default()),
    };
    let Some(variable) = file.variable(&variable) else { return Ok(Said::default()) };
    let name = path.display().to_string();
    cf_axes::check_order(&file, &variable, &name)?;
    cf_axes::check_axis_units(&file, &variable, &name, crs)?;
    check_spacing(&file, &variable, &name)?;
    let is_unsigned = matches!(band.band_type(), GdalDataType::UInt8 | GdalDataType::UInt16 | GdalDataType::UInt32);
    Ok(said_of(&variable, is_unsigned))
}

/// Joins GDAL's messages to the cause of a problem.
fn because(problem: Problem, messages: Vec<String>) -> Problem {
    if messages.is_empty() { problem } else { problem.with_cause(messages.join("; ")) }
}

impl RasterFile {
    /// Opens a raster and looks at everything but its values; `file.nc:variable` names a variable of a NetCDF file.
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn open(path: &Path) -> Result<RasterFile, Problem> {
        match split_variable(path) {
            (file, Some(variable)) => {
                readable_file(&file)?;
                check_variable(&file, &variable)?;
                Self::open_as(&file, &gdal_name(&file, &variable))
            }
            (_, None) => {
                readable_file(path)?;
                Self::open_as(path, path)
            }
        }
    }

    /// The same of a part of the file that GDAL knows by a name of its own, such as a variable of a NetCDF file.
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn open_as(path: &Path, gdal_name: &Path) -> Result<RasterFile, Problem> {
        keep_cache_small();
        let name = path.display();
        // What a file calls invalid is taken out here, where it can be counted and reported.
        let options = cf_axes::is_netcdf(path).then_some(&["HONOUR_VALID_RANGE=NO"][..]);
        let (result, messages) = capture(|| open::raster(gdal_name, options));
        let dataset = result.map(|dataset| Closing(Some(dataset))).map_err(|_| {
            because(input_error("not-a-raster", format!("{name} is not a raster that GDAL can read")), messages)
                .with_remedy(format!(
                    "name a GeoTIFF, an ESRI ASCII grid or another raster of the drivers {}; `gdal_translate` makes one of most others",
                    open::RASTER.join(", ")
                ))
        })?;
        if dataset.raster_count() == 0 {
            return Err(no_band(path, is_netcdf(&dataset)));
        }
        let crs = dataset.spatial_ref().ok().filter(|crs| crs.name().is_some()).map(|mut crs| {
            crs.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
            crs
        });
        let said = if is_netcdf(&dataset) { look_at_variable(path, &dataset, crs.as_ref())? } else { Said::default() };
        let (geo_transform, _) = capture(|| dataset.geo_transform());
        let geo_transform = geo_transform.map_err(|_| {
            let problem = input_error("no-georeference", format!("{name} has no place on the map (no geotransform)"));
            if is_netcdf(&dataset) {
                return problem
                    .with_cause("no axis of it is known as that to the east or to the north, or its places are not evenly spaced")
                    .with_remedy(
                        "give both axes their `standard_name`: `ncatted -a standard_name,x,o,c,projection_x_coordinate \
                         -a standard_name,y,o,c,projection_y_coordinate FILE`",
                    );
            }
            problem
                .with_cause("a picture without world file, or a raster that is placed by control points only")
                .with_remedy(
                    "georeference it, for example by `gdal_translate -a_ullr` or, for control points, `gdalwarp`",
                )
        })?;
        let [_, a, b, _, d, e] = geo_transform;
        if !geo_transform.iter().all(|v| v.is_finite()) || (a * e - b * d).abs() < f64::MIN_POSITIVE {
            return Err(input_error(
                "no-georeference",
                format!("{name} has cells without area (geotransform {geo_transform:?})"),
            )
            .with_remedy("georeference it, for example by `gdal_translate -a_ullr`"));
        }
        let mut warnings = Vec::new();
        let bands = dataset.raster_count() - usize::from(alpha_band(&dataset).is_some());
        if bands > 1 {
            let message = format!("{name} has {bands} bands; the first one is taken as the elevation");
            let remedy = "write the band that is meant to a file of its own: `gdal_translate -b NUMBER FILE OUT`";
            warnings.push(Problem::warning(ProblemKind::Input, "several-bands", "", message).with_remedy(remedy));
        }
        Ok(RasterFile { dataset, geo_transform, crs, said, warnings })
    }

    /// The CRS that the file states.
    pub fn crs(&self) -> Option<&SpatialRef> {
        self.crs.as_ref()
    }

    /// Map coordinates of the centre of the raster, in the file's own system.
    pub fn centre(&self) -> Vec2 {
        let (columns, rows) = self.dataset.raster_size();
        let [x, a, b, y, d, e] = self.geo_transform;
        let (c, r) = (0.5 * columns as f64, 0.5 * rows as f64);
        Vec2::new(x + a * c + b * r, y + d * c + e * r)
    }

    /// Reads the elevations in metres, in the CRS of the run.
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn read(mut self, request: &RasterRequest, run_crs: &Crs) -> Result<(Raster, Vec<Problem>), Problem> {
        let warp = self.needs_warp(request, run_crs)?;
        let extract = self.extract(request, run_crs);
        let (columns, rows) = extract.shape;
        check_memory(request, columns as f64 * rows as f64 * if warp { 2.0 } else { 1.0 })?;
        let values = self.values(1, (extract, ResampleAlg::Average), request)?;
        let raster = if warp {
            self.warped(values, extract, request, run_crs)?
        } else {
            north_up(values, columns, rows, &extract.geo_transform(self.geo_transform))
        };
        self.check_values(&raster, request)?;
        Ok((raster, self.warnings))
    }

    /// Reads values that belong to whole cells, such as classes: they are not resampled, but a [`Placing`] leads to their cells where
    /// another raster would be warped.
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn read_in_place(
        mut self,
        request: &RasterRequest,
        run_crs: &Crs,
    ) -> Result<(Raster, Option<Placing>, Vec<Problem>), Problem> {
        let extract = self.extract(request, run_crs);
        let placing = self.placing(extract, request, run_crs)?;
        let raster = self.band(1, (extract, placing.as_ref()), request)?;
        self.check_values(&raster, request)?;
        if placing.is_some() {
            // A place in the file's own system is none on the map of the run.
            self.warnings.iter_mut().for_each(|warning| warning.at = None);
        }
        Ok((raster, placing, self.warnings))
    }

    /// Reads some of the bands one by one in the same way, whatever their values, and hands each on; returns the warnings.
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn read_bands(
        mut self,
        bands: impl Iterator<Item = usize>,
        request: &RasterRequest,
        run_crs: &Crs,
        mut take: impl FnMut(Raster, Option<&Placing>) -> Result<(), Problem>,
    ) -> Result<Vec<Problem>, Problem> {
        self.warnings.retain(|warning| warning.code != "several-bands");
        let extract = self.extract(request, run_crs);
        let placing = self.placing(extract, request, run_crs)?;
        for band in bands {
            take(self.band(band, (extract, placing.as_ref()), request)?, placing.as_ref())?;
        }
        Ok(self.warnings)
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.dataset.raster_count()
    }

    /// The way to the cells, where it is not that of a north-up raster in the system of the run.
    fn placing(
        &mut self,
        extract: Extract,
        request: &RasterRequest,
        run_crs: &Crs,
    ) -> Result<Option<Placing>, Problem> {
        if !self.needs_warp(request, run_crs)? {
            return Ok(None);
        }
        Ok(Some(Placing { systems: self.systems(run_crs), geo_transform: extract.geo_transform(self.geo_transform) }))
    }

    /// A band as it stands.
    fn band(
        &mut self,
        band: usize,
        (extract, placing): (Extract, Option<&Placing>),
        request: &RasterRequest,
    ) -> Result<Raster, Problem> {
        let (columns, rows) = extract.shape;
        check_memory(request, columns as f64 * rows as f64)?;
        let values = self.values(band, (extract, ResampleAlg::NearestNeighbour), request)?;
        let own = extract.geo_transform(self.geo_transform);
        let own = placing.map_or(own, |_| [0.0, 1.0, 0.0, 0.0, 0.0, -1.0]);
        Ok(north_up(values, columns, rows, &own))
    }

    /// Whether the raster must be warped; refuses it when it would have to and may not.
    fn needs_warp(&mut self, request: &RasterRequest, run_crs: &Crs) -> Result<bool, Problem> {
        let name = request.path.display();
        let [_, a, b, _, d, e] = self.geo_transform;
        let (columns, rows) = self.dataset.raster_size();
        // What the last cells are off by: some programs leave a rounding there.
        let rotated = (b * rows as f64).abs() > STRAIGHT * a.abs() || (d * columns as f64).abs() > STRAIGHT * e.abs();
        match (run_crs, &self.crs) {
            (Crs::Local, Some(crs)) => {
                if is_metric(crs) == Err(CrsProblem::Geographic) {
                    return Err(input_error(
                        "geographic-crs",
                        format!("{name} counts in degrees ({}), the run in local metres", describe(crs)),
                    )
                    .with_remedy(self.remedy_for_metres()));
                }
                if let Err(CrsProblem::NotMetres(unit)) = is_metric(crs) {
                    let message = format!("{name} counts in `{unit}` ({}), the run in local metres", describe(crs));
                    return Err(input_error("not-metric-crs", message)
                        .with_cause("`crs: local` sets its reference system aside, and its coordinates would be taken for metres")
                        .with_remedy(self.remedy_for_metres()));
                }
                let message = format!("{name} has the CRS {}, which `crs: local` sets aside", describe(crs));
                self.warnings.push(
                    Problem::warning(ProblemKind::Input, "crs-set-aside", "", message)
                        .with_remedy("leave out `crs: local` to keep the place on Earth"),
                );
            }
            (Crs::Projected(run), Some(crs)) if !same_horizontal(run, crs) => {
                if request.reproject {
                    return Ok(true);
                }
                let degrees = is_metric(crs) == Err(CrsProblem::Geographic);
                let code = if degrees { "geographic-crs" } else { "different-crs" };
                return Err(input_error(code, format!("{name} has the CRS {}, the run has {}", describe(crs), describe(run)))
                    .with_remedy("set `terrain.reproject: true` to warp it to the CRS of the run, or warp it beforehand with `gdalwarp`"));
            }
            (Crs::Projected(_), None) if self.geo_transform[1].hypot(self.geo_transform[2]) < LEAST_PIXEL => {
                let message = format!("{name} states no CRS, and cells narrower than a millimetre: degrees, perhaps");
                return Err(input_error("geographic-crs", message).with_remedy("write its CRS: `gdal_edit.py -a_srs`"));
            }
            (Crs::Projected(run), None) => {
                let message = format!("{name} states no CRS; its coordinates are taken as {}", describe(run));
                self.warnings.push(Problem::warning(ProblemKind::Input, "assumed-crs", "", message).with_remedy(
                    "write the CRS into the file with `gdal_edit.py -a_srs`, or put a .prj file beside it",
                ));
            }
            _ => {}
        }
        if rotated && !request.reproject {
            return Err(input_error(
                "rotated-raster",
                format!("the grid of {name} is rotated (geotransform {:?})", self.geo_transform),
            )
            .with_remedy(
                "set `terrain.reproject: true` to resample it north-up, or do so beforehand with `gdalwarp`",
            ));
        }
        Ok(rotated)
    }

    /// What to do about a raster that does not count in metres.
    pub fn remedy_for_metres(&self) -> String {
        let for_example = self.centre_in_degrees().map_or(", such as the UTM zone of the place".to_owned(), |place| {
            format!(", for example `crs: {}` (UTM)", suggested_utm(place.x, place.y))
        });
        format!("set `terrain.reproject: true` and `crs:` to a metric system{for_example}")
    }

    /// Longitude and latitude (degrees) of the centre of the raster, where its system gives a place on Earth.
    fn centre_in_degrees(&self) -> Option<Vec2> {
        let own = self.crs.as_ref()?;
        let mut place = [self.centre()];
        if !own.is_geographic() {
            transform(&mut place, own, &spatial_ref("EPSG:4326").ok()?).ok()?;
        }
        Some(place[0]).filter(|place| place.x.abs() <= 180.0 && place.y.abs() <= 90.0)
    }
}
