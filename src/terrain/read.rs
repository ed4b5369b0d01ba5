//! Raster files to [`Raster`]: any data type, nodata, scale, offset, orientation and CRS that GDAL knows.

use std::path::Path;

use gdal::raster::GdalDataType;
use gdal::spatial_ref::{AxisMappingStrategy, SpatialRef};
use gdal::{Dataset, DatasetOptions, DriverManager, GdalOpenFlags, GeoTransform, Metadata};

use super::Raster;
use super::ascii_grid::{Broken, broken_values};
use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::cf_axes::{self, gdal_name, metres_of, raster_variables, split_variable};
use crate::geodata::cf_valid::{Bounds, bounds_of};
use crate::geodata::{
    Crs, CrsProblem, alone, capture, describe, is_alpha, is_metric, readable_file, same_horizontal, spatial_ref,
    suggested_utm, transform, vertical_unit, warp_to_memory,
};
use crate::math::{Vec2, in_bytes};

/// Elevations (m) outside this range are doubtful on Earth: sea trenches and fill values below, fill values above.
pub const PLAUSIBLE_ELEVATION: std::ops::RangeInclusive<f64> = -500.0..=9000.0;

/// Share of a cell by which no cell of a grid is off that counts as straight.
const STRAIGHT: f64 = 1e-3;

/// The code of the warning of values that the file itself calls invalid.
const BEYOND_BOUNDS: &str = "outside-valid-range";

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
}

/// The way from places of the run to the cells of a raster in another system, or rotated, that is read as it stands.
#[derive(Clone, Debug)]
pub struct Placing {
    /// Systems of the run and of the file, where they differ.
    systems: Option<(SpatialRef, SpatialRef)>,
    geo_transform: GeoTransform,
}

impl Placing {
    /// Turns map coordinates of the run to those of the raster, in which a cell is 1 by 1 and the upper left corner (0, 0).
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn apply(&self, places: &mut [Vec2], path: &Path) -> Result<(), Problem> {
        if let Some((run, own)) = &self.systems {
            transform(places, run, own).map_err(|cause| {
                input_error(
                    "warp-failed",
                    format!("the run has places that {} in {} does not know", path.display(), describe(own)),
                )
                .with_cause(cause)
                .with_remedy("check that `crs:` covers this place on Earth")
            })?;
        }
        let [x, a, b, y, d, e] = self.geo_transform;
        let determinant = a * e - b * d;
        for place in places {
            let (east, north) = (place.x - x, place.y - y);
            *place = Vec2::new((e * east - b * north) / determinant, (d * east - a * north) / determinant);
        }
        Ok(())
    }

    /// Whether both lead to the same place, to within a share of a cell.
    pub fn is_same(&self, other: &Placing, share: f64) -> bool {
        let [_, a, b, _, d, e] = self.geo_transform;
        let near = |k: usize, step: f64| (self.geo_transform[k] - other.geo_transform[k]).abs() <= share * step;
        let (x, y) = (a.hypot(b), d.hypot(e));
        let same_system = match (&self.systems, &other.systems) {
            (Some((_, own)), Some((_, other))) => same_horizontal(own, other),
            (None, None) => true,
            _ => false,
        };
        same_system && [(0, x), (1, x), (2, x), (3, y), (4, y), (5, y)].into_iter().all(|(k, step)| near(k, step))
    }
}

/// A raster file, opened but not yet read.
#[derive(Debug)]
pub struct RasterFile {
    dataset: Closing,
    geo_transform: GeoTransform,
    crs: Option<SpatialRef>,
    /// What a NetCDF file itself says of its valid values.
    bounds: Option<Bounds>,
    /// Warnings met so far, without key and place.
    pub warnings: Vec<Problem>,
}

/// A dataset that is closed while nobody else is in the NetCDF library.
#[derive(Debug)]
struct Closing(Option<Dataset>);

impl std::ops::Deref for Closing {
    type Target = Dataset;

    fn deref(&self) -> &Dataset {
        match &self.0 {
            Some(dataset) => dataset,
            None => unreachable!("it is taken out when it is dropped"),
        }
    }
}

impl Drop for Closing {
    fn drop(&mut self) {
        let _alone = alone();
        drop(self.0.take());
    }
}

fn is_netcdf(dataset: &Dataset) -> bool {
    dataset.driver().short_name() == "netCDF"
}

/// The number of the band that says where there is nothing; the last one beside others, where there is one.
fn alpha_band(dataset: &Dataset) -> Option<usize> {
    let last = dataset.raster_count();
    (last > 1 && dataset.rasterband(last).is_ok_and(|band| is_alpha(&band))).then_some(last)
}

/// Refuses a NetCDF file without a variable of that name.
fn check_variable(path: &Path, variable: &str) -> Result<(), Problem> {
    if netcdf::open(path).is_ok_and(|file| file.variable(variable).is_none()) {
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

/// Refuses a NetCDF variable that would be read transposed or in another unit of length; returns the bounds of its values.
fn look_at_variable(path: &Path, dataset: &Dataset, crs: Option<&SpatialRef>) -> Result<Option<Bounds>, Problem> {
    let Ok(band) = dataset.rasterband(1) else { return Ok(None) };
    let (Some(variable), Ok(file)) = (band.metadata_item("NETCDF_VARNAME", ""), netcdf::open(path)) else {
        return Ok(None);
    };
    let Some(variable) = file.variable(&variable) else { return Ok(None) };
    let name = path.display().to_string();
    cf_axes::check_order(&file, &variable, &name)?;
    cf_axes::check_axis_units(&file, &variable, &name, crs)?;
    let is_unsigned = matches!(band.band_type(), GdalDataType::UInt8 | GdalDataType::UInt16 | GdalDataType::UInt32);
    Ok(bounds_of(&variable, is_unsigned))
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
        let name = path.display();
        let options = DatasetOptions {
            open_flags: GdalOpenFlags::GDAL_OF_RASTER | GdalOpenFlags::GDAL_OF_VERBOSE_ERROR,
            // What a file calls invalid is taken out here, where it can be counted and reported.
            open_options: cf_axes::is_netcdf(path).then_some(&["HONOUR_VALID_RANGE=NO"]),
            ..DatasetOptions::default()
        };
        let (result, messages) = capture(|| Dataset::open_ex(gdal_name, options));
        let dataset = result.map(|dataset| Closing(Some(dataset))).map_err(|_| {
            because(input_error("not-a-raster", format!("{name} is not a raster that GDAL can read")), messages)
                .with_remedy(
                    "name a GeoTIFF, an ESRI ASCII grid or another raster; `gdalinfo FILE` shows whether GDAL reads it",
                )
        })?;
        if dataset.raster_count() == 0 {
            return Err(no_band(path, is_netcdf(&dataset)));
        }
        let crs = dataset.spatial_ref().ok().filter(|crs| crs.name().is_some()).map(|mut crs| {
            crs.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
            crs
        });
        let bounds = if is_netcdf(&dataset) { look_at_variable(path, &dataset, crs.as_ref())? } else { None };
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
        Ok(RasterFile { dataset, geo_transform, crs, bounds, warnings })
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
        let (columns, rows) = self.dataset.raster_size();
        check_memory(request, columns as f64 * rows as f64 * if warp { 2.0 } else { 1.0 })?;
        let values = self.values(1, request)?;
        let raster = if warp {
            self.warped(&values, request, run_crs)?
        } else {
            north_up(&values, columns, rows, &self.geo_transform)
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
        let placing = self.placing(request, run_crs)?;
        let raster = self.band(1, placing.as_ref(), request)?;
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
        let placing = self.placing(request, run_crs)?;
        for band in bands {
            take(self.band(band, placing.as_ref(), request)?, placing.as_ref())?;
        }
        Ok(self.warnings)
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.dataset.raster_count()
    }

    /// The way to the cells, where it is not that of a north-up raster in the system of the run.
    fn placing(&mut self, request: &RasterRequest, run_crs: &Crs) -> Result<Option<Placing>, Problem> {
        if !self.needs_warp(request, run_crs)? {
            return Ok(None);
        }
        let systems = match (run_crs, &self.crs) {
            (Crs::Projected(run), Some(own)) => Some((run.clone(), own.clone())),
            _ => None,
        };
        Ok(Some(Placing { systems, geo_transform: self.geo_transform }))
    }

    /// A band as it stands.
    fn band(&mut self, band: usize, placing: Option<&Placing>, request: &RasterRequest) -> Result<Raster, Problem> {
        let (columns, rows) = self.dataset.raster_size();
        check_memory(request, columns as f64 * rows as f64)?;
        let values = self.values(band, request)?;
        let own = placing.map_or(self.geo_transform, |_| [0.0, 1.0, 0.0, 0.0, 0.0, -1.0]);
        Ok(north_up(&values, columns, rows, &own))
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

    /// Every value of a band in metres, NaN where there is no data.
    fn values(&mut self, number: usize, request: &RasterRequest) -> Result<Vec<f64>, Problem> {
        let name = request.path.display();
        let (columns, rows) = self.dataset.raster_size();
        let dataset: &Dataset = &self.dataset;
        let (result, messages) = capture(|| {
            let band = dataset.rasterband(number)?;
            let buffer = band.read_as::<f64>((0, 0), (columns, rows), (columns, rows), None)?;
            let mask = if band.mask_flags()?.is_nodata() || band.mask_flags()?.is_all_valid() {
                None
            } else {
                Some(band.open_mask_band()?.read_as::<u8>((0, 0), (columns, rows), (columns, rows), None)?)
            };
            // GDAL makes a mask of an alpha band of small integers alone.
            let alpha = alpha_band(dataset)
                .map(|alpha| dataset.rasterband(alpha)?.read_as::<f64>((0, 0), (columns, rows), (columns, rows), None))
                .transpose()?;
            let is_clear = |cell: usize| {
                mask.as_ref().is_some_and(|mask| mask.data()[cell] == 0)
                    || alpha.as_ref().is_some_and(|alpha| alpha.data()[cell] <= 0.0)
            };
            Ok::<_, gdal::errors::GdalError>((
                buffer.data().to_vec(),
                (0..columns * rows).map(is_clear).collect::<Vec<bool>>(),
                band.no_data_value(),
                (band.scale().unwrap_or(1.0), band.offset().unwrap_or(0.0)),
            ))
        });
        let (mut values, is_clear, no_data, (scale, offset)) = result.map_err(|error| {
            because(input_error("unreadable-raster", format!("{name} opens, but its values cannot be read")), messages)
                .with_remedy(format!("the file is damaged or cut short ({error}); copy or export it again"))
        })?;
        let (least, most) = self.bounds.as_ref().map_or((f64::NEG_INFINITY, f64::INFINITY), |b| (b.least, b.most));
        let mut beyond = 0;
        let is_no_data = no_data_test(no_data, self.dataset.rasterband(number).ok().map(|b| b.band_type().name()));
        let mut broken: Option<Broken> = None;
        for (i, value) in values.iter_mut().enumerate() {
            if is_no_data(*value) || is_clear[i] {
                *value = f64::NAN;
            } else if *value < least || *value > most {
                *value = f64::NAN;
                beyond += 1;
            } else if value.is_finite() {
                *value = (*value * scale + offset) * request.unit + request.offset;
            } else {
                broken.get_or_insert_with(|| Broken { count: 0, index: i, word: value.to_string() }).count += 1;
            }
        }
        self.tell_of_bounds(beyond, request);
        if self.dataset.driver().short_name() == "AAIGrid"
            && let Ok((words, count)) = broken_values(request.path)
        {
            if count > columns * rows {
                let message = format!("{name} holds {count} values, more than the {columns} by {rows} of its header");
                return Err(input_error("too-many-values", message)
                    .with_cause("read by such a header, the rows would be shifted against each other, or some left out")
                    .with_remedy("correct `ncols` and `nrows`, or export the file again"));
            }
            broken = words.or(broken);
        }
        broken.map_or(Ok(values), |broken| Err(self.not_a_number(&name.to_string(), &broken, no_data)))
    }

    /// The problem of values that are not finite, located in the grid and on the map.
    fn not_a_number(&self, name: &str, broken: &Broken, no_data: Option<f64>) -> Problem {
        let (columns, _) = self.dataset.raster_size();
        let (column, row) = (broken.index % columns, broken.index / columns);
        let message = format!(
            "{name} holds {} values that are not finite numbers, the first one ({}) in column {}, row {} from the upper left",
            broken.count,
            broken.word,
            column + 1,
            row + 1
        );
        let cause = no_data.map_or("the file declares no nodata value".to_string(), |value| {
            format!("the file declares {value} as nodata, not these")
        });
        // To declare them in place of the nodata value that is there would make elevations of the cells that have that.
        let remedy = no_data.map_or(
            "mark them as nodata with `gdal_edit.py -a_nodata nan`, in a text with `NODATA_value nan`; or write numbers in their place".to_string(),
            |value| {
                let value = value.to_string().to_lowercase();
                format!(
                    "write {value} in their place, in a text with an editor, otherwise with `gdal_calc.py -A FILE --outfile OUT --NoDataValue {value} --calc \"where(isfinite(A), A, {value})\"`"
                )
            },
        );
        let [x, a, b, y, d, e] = self.geo_transform;
        let (column, row) = (column as f64 + 0.5, row as f64 + 0.5);
        input_error("not-a-number", message)
            .with_cause(cause)
            .with_remedy(remedy)
            .with_at(Vec2::new(x + a * column + b * row, y + d * column + e * row))
    }

    /// Warns of the first band that has values beyond the bounds that the file gives.
    fn tell_of_bounds(&mut self, beyond: usize, request: &RasterRequest) {
        let Some(bounds) = self.bounds.as_ref().filter(|_| beyond > 0) else { return };
        if self.warnings.iter().any(|warning| warning.code == BEYOND_BOUNDS) {
            return;
        }
        let message = format!(
            "{beyond} cells of {} lie outside what the file calls valid (`{}`) and count as no data",
            request.path.display(),
            bounds.said
        );
        self.warnings.push(
            Problem::warning(ProblemKind::Input, BEYOND_BOUNDS, "", message)
                .with_remedy("where they are data, correct or delete that attribute of the variable (`ncatted`)"),
        );
    }

    /// The unit that the file gives for its values; empty where it gives none.
    pub fn unit(&self) -> String {
        self.dataset.rasterband(1).map(|band| band.unit()).unwrap_or_default().trim().to_owned()
    }

    /// Refuses heights whose unit in the file, or in its reference system, is another than that of the scenario (so many metres).
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn check_unit_of_heights(&self, unit: f64, path: &Path) -> Result<(), Problem> {
        /// The two feet differ by 2e-6, which no terrain knows.
        const SAME: f64 = 1e-5;
        let mut written = self.unit();
        let mut own = metres_of(&written);
        if written.is_empty()
            && let Some((name, metres)) = self.crs.as_ref().and_then(vertical_unit)
        {
            (written, own) = (name, Some(metres));
        }
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

    /// Warps read values to a north-up grid in the CRS of the run, with square cells that fit the resolution.
    fn warped(&self, values: &[f64], request: &RasterRequest, run_crs: &Crs) -> Result<Raster, Problem> {
        let (columns, rows) = self.dataset.raster_size();
        let cell = fitting_cell(self.cell_in_metres(), request.resolution);
        let area = columns as f64 * rows as f64 * self.cell_in_metres() * self.cell_in_metres();
        check_memory(request, 3.0 * columns as f64 * rows as f64 + area / (cell * cell))?;
        let (result, messages) = capture(|| -> Result<Raster, String> {
            let text = |error: gdal::errors::GdalError| error.to_string();
            let driver = DriverManager::get_driver_by_name("MEM").map_err(text)?;
            let mut source = driver.create_with_band_type::<f64, _>("", columns, rows, 1).map_err(text)?;
            source.set_geo_transform(&self.geo_transform).map_err(text)?;
            let target = match (run_crs, &self.crs) {
                (Crs::Projected(run), Some(own)) => {
                    source.set_spatial_ref(own).map_err(text)?;
                    Some(run.to_wkt().map_err(text)?)
                }
                _ => None,
            };
            let mut band = source.rasterband(1).map_err(text)?;
            band.set_no_data_value(Some(f64::NAN)).map_err(text)?;
            let mut buffer = gdal::raster::Buffer::new((columns, rows), values.to_vec());
            band.write((0, 0), (columns, rows), &mut buffer).map_err(text)?;
            let cell_text = format!("{cell}");
            let mut arguments = vec!["-r", "bilinear", "-dstnodata", "nan", "-tap", "-tr", &cell_text, &cell_text];
            if let Some(target) = &target {
                arguments.extend(["-t_srs", target]);
            }
            let result = warp_to_memory(&source, &arguments)?;
            let (columns, rows) = result.raster_size();
            let band = result.rasterband(1).map_err(text)?;
            let buffer = band.read_as::<f64>((0, 0), (columns, rows), (columns, rows), None).map_err(text)?;
            Ok(north_up(buffer.data(), columns, rows, &result.geo_transform().map_err(text)?))
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
    fn cell_in_metres(&self) -> f64 {
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

    /// Refuses a raster without data, warns of elevations that Earth does not have.
    fn check_values(&mut self, raster: &Raster, request: &RasterRequest) -> Result<(), Problem> {
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
        if least > greatest {
            let problem = input_error("all-nodata", format!("{name} holds no data at all: every cell is nodata"));
            // The attribute that took them out is the place to look at.
            return Err(match self.warnings.iter().find(|warning| warning.code == BEYOND_BOUNDS) {
                Some(bounds) => {
                    problem.with_cause(bounds.message.clone()).with_remedy(bounds.remedy.clone().unwrap_or_default())
                }
                None => problem.with_remedy("check the nodata value with `gdalinfo -stats`"),
            });
        }
        if let Some(index) = doubtful {
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

/// The cell for a warped raster: a whole multiple or a whole part of the resolution, close to the source's cell (m).
fn fitting_cell(source: f64, resolution: f64) -> f64 {
    if source >= resolution {
        resolution * (source / resolution).round()
    } else {
        resolution / (resolution / source).round()
    }
}

/// The key of the scenario for a unit of heights (so many metres); none where it has none.
fn key_of_unit(metres: f64) -> Option<&'static str> {
    const KEYS: [(&str, f64); 6] =
        [("m", 1.0), ("dm", 0.1), ("cm", 0.01), ("mm", 0.001), ("ft", 0.3048), ("us_ft", 1200.0 / 3937.0)];
    KEYS.iter().find(|(_, factor)| (metres / factor - 1.0).abs() < 1e-9).map(|(name, _)| *name)
}

/// Whether a value is the declared nodata value; a 32-bit raster holds it rounded.
fn no_data_test(no_data: Option<f64>, band_type: Option<String>) -> impl Fn(f64) -> bool {
    let single = band_type.as_deref() == Some("Float32");
    move |value| match no_data {
        None => false,
        Some(no_data) if no_data.is_nan() => value.is_nan(),
        #[expect(clippy::float_cmp, reason = "nodata is a mark, not a quantity")]
        Some(no_data) => value == no_data || (single && value as f32 == no_data as f32),
    }
}

/// Refuses values that would not fit into the memory limit.
fn check_memory(request: &RasterRequest, values: f64) -> Result<(), Problem> {
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

/// Values of a grid without rotation, turned to row 0 in the north and column 0 in the west.
fn north_up(values: &[f64], columns: usize, rows: usize, geo_transform: &GeoTransform) -> Raster {
    let [x, cell_x, _, y, _, cell_y] = *geo_transform;
    let (south_up, east_first) = (cell_y > 0.0, cell_x < 0.0);
    let mut turned = Vec::with_capacity(values.len());
    for row in 0..rows {
        let source = if south_up { rows - 1 - row } else { row };
        let line = &values[source * columns..][..columns];
        if east_first {
            turned.extend(line.iter().rev());
        } else {
            turned.extend_from_slice(line);
        }
    }
    Raster {
        columns,
        rows,
        west: if east_first { x + columns as f64 * cell_x } else { x },
        north: if south_up { y + rows as f64 * cell_y } else { y },
        cell_x: cell_x.abs(),
        cell_y: cell_y.abs(),
        values: turned,
    }
}
