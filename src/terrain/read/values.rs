//! The values of a band, as far as they are data.

use gdal::Dataset;
use gdal::errors::{GdalError, Result as GdalResult};
use gdal::raster::ResampleAlg;

use super::undeclared::{self, Undeclared};
use super::{BEYOND_BOUNDS, Extract, RasterFile, RasterRequest, UNDECLARED, because};
use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::{capture, is_alpha};
use crate::math::Vec2;
use crate::terrain::ascii_grid::{Broken, broken_values};

/// A band as it stands in its file.
struct Band {
    values: Vec<f64>,
    /// Whether a mask or an alpha band takes a cell out; empty where there is none.
    is_clear: Vec<bool>,
    no_data: Option<f64>,
    scale: f64,
    offset: f64,
}

impl Band {
    fn read(dataset: &Dataset, number: usize, (extract, several): (Extract, ResampleAlg)) -> GdalResult<Band> {
        let band = dataset.rasterband(number)?;
        let values = extract.read::<f64>(&band, several)?;
        let is_masked = !(band.mask_flags()?.is_nodata() || band.mask_flags()?.is_all_valid());
        let nearest = ResampleAlg::NearestNeighbour;
        let mask = is_masked.then(|| extract.read::<u8>(&band.open_mask_band()?, nearest)).transpose()?;
        // GDAL makes a mask of an alpha band of small integers alone.
        let alpha = alpha_band(dataset).map(|alpha| extract.read::<f64>(&dataset.rasterband(alpha)?, nearest));
        let alpha = alpha.transpose()?;
        let is_clear = |cell: usize| {
            mask.as_ref().is_some_and(|mask| mask[cell] == 0) || alpha.as_ref().is_some_and(|alpha| alpha[cell] <= 0.0)
        };
        let masked = if mask.is_some() || alpha.is_some() { values.len() } else { 0 };
        Ok(Band {
            is_clear: (0..masked).map(is_clear).collect(),
            values,
            no_data: band.no_data_value(),
            scale: band.scale().unwrap_or(1.0),
            offset: band.offset().unwrap_or(0.0),
        })
    }
}

impl RasterFile {
    /// Every value of a band in metres, NaN where there is no data.
    ///
    /// - `several`: how several cells become one
    pub(super) fn values(
        &mut self,
        number: usize,
        (extract, several): (Extract, ResampleAlg),
        request: &RasterRequest,
    ) -> Result<Vec<f64>, Problem> {
        let name = request.path.display();
        let dataset: &Dataset = &self.dataset;
        let (result, messages) = capture(|| Band::read(dataset, number, (extract, several)));
        let Band { mut values, is_clear, no_data, scale, offset } = result.map_err(|error: GdalError| {
            because(input_error("unreadable-raster", format!("{name} opens, but its values cannot be read")), messages)
                .with_remedy(format!("the file is damaged or cut short ({error}); copy or export it again"))
        })?;
        let (least, most) = self.said.bounds.as_ref().map_or((f64::NEG_INFINITY, f64::INFINITY), |b| (b.least, b.most));
        let mut beyond = 0;
        let is_no_data = no_data_test(no_data, self.dataset.rasterband(number).ok().map(|b| b.band_type().name()));
        let mut broken: Option<Broken> = None;
        let is_out = |cell: usize, value: f64| {
            is_no_data(value)
                || self.said.marks.iter().any(|mark| is_same(*mark, value))
                || is_clear.get(cell).is_some_and(|is_clear| *is_clear)
        };
        let is_beyond = |value: f64| value < least || value > most;
        let seek = || undeclared::find(&values, extract.shape, |cell, value| is_out(cell, value) || is_beyond(value));
        let undeclared = request.is_ground.then(seek).flatten();
        let (columns, _) = self.dataset.raster_size();
        for (i, value) in values.iter_mut().enumerate() {
            if is_out(i, *value) {
                *value = f64::NAN;
            } else if is_beyond(*value) {
                *value = f64::NAN;
                beyond += 1;
            } else if value.is_finite() {
                *value = (*value * scale + offset) * request.unit + request.offset;
            } else {
                let (column, row) = extract.in_file(i);
                let index = row * columns + column;
                broken.get_or_insert_with(|| Broken { count: 0, index, word: value.to_string() }).count += 1;
            }
        }
        self.tell_of_bounds(beyond, request);
        self.report_marks(undeclared.as_ref(), extract, request);
        if let Some(words) = self.words_of_text(request)? {
            broken = Some(words);
        }
        broken.map_or(Ok(values), |broken| Err(self.not_a_number(&name.to_string(), &broken, no_data)))
    }

    /// The words of a grid of text that are no numbers; refuses one with more values than its header says.
    fn words_of_text(&self, request: &RasterRequest) -> Result<Option<Broken>, Problem> {
        if self.dataset.driver().short_name() != "AAIGrid" {
            return Ok(None);
        }
        let Ok((words, count)) = broken_values(request.path) else { return Ok(None) };
        let (columns, rows) = self.dataset.raster_size();
        if count > columns * rows {
            let name = request.path.display();
            let message = format!("{name} holds {count} values, more than the {columns} by {rows} of its header");
            return Err(input_error("too-many-values", message)
                .with_cause("read by such a header, the rows would be shifted against each other, or some left out")
                .with_remedy("correct `ncols` and `nrows`, or export the file again"));
        }
        Ok(words)
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

    /// Refuses a number that stands for no data but is not declared so.
    fn report_marks(&mut self, found: Option<&Undeclared>, extract: Extract, request: &RasterRequest) {
        let Some(Undeclared { value, count, first, is_of_ground }) = found else { return };
        let name = request.path.display();
        let (column, row) = extract.in_file(*first);
        let value = if value.abs() < 1e6 { value.to_string() } else { format!("{value:e}") };
        let message =
            format!("{count} cells of {name} have the value {value}, and all that lies beside them is far from it");
        let cause = if *is_of_ground {
            "water would fall into them as into a pit; programs write this number where they know nothing"
        } else {
            "programs write this number where there is no data, and the file does not declare it"
        };
        let [x, a, b, y, d, e] = self.geo_transform;
        let (across, down) = (column as f64 + 0.5, row as f64 + 0.5);
        let problem = input_error(UNDECLARED, message)
            .with_cause(cause)
            .with_remedy(format!("declare it: `gdal_edit.py -a_nodata {value} FILE`, in an ESRI ASCII grid `NODATA_value {value}`; where it is ground, take another value that is near it"))
            .with_at(Vec2::new(x + a * across + b * down, y + d * across + e * down));
        self.warnings.push(problem);
    }

    /// Warns of the first band that has values beyond the bounds that the file gives.
    fn tell_of_bounds(&mut self, beyond: usize, request: &RasterRequest) {
        let Some(bounds) = self.said.bounds.as_ref().filter(|_| beyond > 0) else { return };
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
}

/// The number of the band that says where there is nothing; the last one beside others, where there is one.
pub(super) fn alpha_band(dataset: &Dataset) -> Option<usize> {
    let last = dataset.raster_count();
    (last > 1 && dataset.rasterband(last).is_ok_and(|band| is_alpha(&band))).then_some(last)
}

/// Whether a value is a mark.
#[expect(clippy::float_cmp, reason = "nodata is a mark, not a quantity")]
fn is_same(mark: f64, value: f64) -> bool {
    mark == value || (mark.is_nan() && value.is_nan())
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
