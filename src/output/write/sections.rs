//! The cross-sections: `sections.csv` and `section_series.csv` in `tables/`, and `sections.nc` with both: `discharge(time, section)`, and
//! arrival, peak, volume and place of each section.

use netcdf::{FileMut, Options, VariableMut};

use super::super::folder::{RunFolder, output_error, write_lines};
use super::super::grid::FILL;
use super::super::sections::{Section, SectionRecording, SectionResult, SectionSample};
use super::crs::WritableCrs;
use super::netcdf_file::{Written, define_crs, put_texts, put_time_attributes, variable};
use super::read_back::ReadBack;
use super::tables::{decimals, number, row, text};
use super::{FileHead, Provenance};
use crate::error::Error;
use crate::math::Vec2;

const TOWARDS_THE_LEFT: &str = "positive where the water crosses the line towards its left side";
const DISCHARGE: &str = "water_volume_transport_in_river_channel";
/// The auxiliary coordinates of a section.
const COORDINATES: &str = "section_id x y";

/// What readers must know of a variable; empty where there is nothing to say.
struct Described {
    name: &'static str,
    standard_name: &'static str,
    long_name: &'static str,
    units: &'static str,
    comment: &'static str,
}

type OfSample = fn(&SectionSample) -> f64;
type OfSection = fn(&Section, &SectionResult) -> Option<f64>;

/// What the file has at every section and moment.
const SERIES: [(Described, OfSample); 2] = [
    (
        Described {
            name: "discharge",
            standard_name: DISCHARGE,
            long_name: "discharge through the cross-section, mean of the compute step",
            units: "m3 s-1",
            comment: TOWARDS_THE_LEFT,
        },
        |sample| sample.discharge,
    ),
    (
        Described {
            name: "volume",
            standard_name: "",
            long_name: "volume through the cross-section since the start",
            units: "m3",
            comment: TOWARDS_THE_LEFT,
        },
        |sample| sample.volume,
    ),
];

/// What it has of every section, as the columns of `sections.csv`, and its ends; none where it never had it.
const RESULTS: [(Described, OfSection); 9] = [
    (length_of("length", "length of the cross-section"), |section, _| Some(length(section))),
    (length_of("left_x", "x coordinate of the end on the left bank"), |section, _| Some(ends(section)[0].x)),
    (length_of("left_y", "y coordinate of the end on the left bank"), |section, _| Some(ends(section)[0].y)),
    (length_of("right_x", "x coordinate of the end on the right bank"), |section, _| Some(ends(section)[1].x)),
    (length_of("right_y", "y coordinate of the end on the right bank"), |section, _| Some(ends(section)[1].y)),
    (
        Described {
            name: "arrival_time",
            standard_name: "",
            long_name: "time of arrival of the water at the cross-section",
            units: "s",
            comment: "seconds since the start, when it came to the first of the cells that the line crosses, by the rule of arrival_time in maps.nc for its first threshold; no value where it never did",
        },
        |_, result| result.arrival,
    ),
    (
        Described {
            name: "peak_discharge",
            standard_name: DISCHARGE,
            long_name: "peak discharge through the cross-section, by size",
            units: "m3 s-1",
            comment: TOWARDS_THE_LEFT,
        },
        |_, result| Some(result.peak_discharge),
    ),
    (
        Described {
            name: "time_of_peak",
            standard_name: "",
            long_name: "time of the peak discharge, by size",
            units: "s",
            comment: "seconds since the start; no value where no water passed",
        },
        |_, result| result.time_of_peak,
    ),
    (
        Described {
            name: "total_volume",
            standard_name: "",
            long_name: "volume through the cross-section from the start to the end of the run",
            units: "m3",
            comment: TOWARDS_THE_LEFT,
        },
        |_, result| Some(result.volume),
    ),
];

/// Writes the tables and the NetCDF file of the cross-sections; nothing where there are none.
///
/// # Errors
/// When one of them cannot be written.
pub fn write_section_tables(
    folder: &RunFolder,
    sections: &[Section],
    SectionRecording { results, samples }: &SectionRecording,
) -> Result<(), Error> {
    if sections.is_empty() {
        return Ok(());
    }
    let of_discharge = decimals(6, results.iter().map(|result| result.peak_discharge));
    let of_volume = decimals(3, samples.iter().map(|sample| sample.volume));
    let rows = sections.iter().zip(results).map(|(section, result)| {
        row([
            text(&section.id),
            number(Some(length(section)), 2),
            number(result.arrival, 3),
            number(Some(result.peak_discharge), of_discharge),
            number(result.time_of_peak, 3),
            number(Some(result.volume), of_volume),
        ])
    });
    let header = "id,length_m,arrival_s,peak_discharge_m3_s,time_of_peak_s,volume_m3";
    write_lines(folder, "tables/sections.csv", header, rows)?;
    let rows = samples.iter().map(|sample| {
        row([
            text(&sections[sample.section].id),
            number(Some(sample.time), 3),
            number(Some(sample.discharge), of_discharge),
            number(Some(sample.volume), of_volume),
        ])
    });
    write_lines(folder, "tables/section_series.csv", "id,time_s,discharge_m3_s,volume_m3", rows)
}

/// Writes the tables of the sections and `sections.nc`; nothing where there are no sections.
///
/// # Errors
/// When one of them cannot be written.
pub fn write_sections(
    folder: &RunFolder,
    head: FileHead<'_>,
    sections: &[Section],
    recording: &SectionRecording,
) -> Result<(), Error> {
    write_section_tables(folder, sections, recording)?;
    write_section_file(folder, head, sections, recording)
}

/// Writes `sections.nc`; nothing where there are no sections.
///
/// # Errors
/// When it cannot be written.
pub fn write_section_file(
    folder: &RunFolder,
    FileHead { crs, provenance }: FileHead<'_>,
    sections: &[Section],
    recording: &SectionRecording,
) -> Result<(), Error> {
    if sections.is_empty() {
        return Ok(());
    }
    folder.write_with("sections.nc", |path| {
        let crs = WritableCrs::new(crs, path)?;
        let write = || write_netcdf(path, crs.as_ref(), provenance, sections, recording);
        write().map_err(|cause| output_error(path, cause))?;
        let back = ReadBack::open(path)?;
        SERIES.iter().try_for_each(|(described, value)| {
            let values: Vec<f64> = recording.samples.iter().map(value).collect();
            back.compare(described.name, .., &values)
        })
    })
}

const fn length_of(name: &'static str, long_name: &'static str) -> Described {
    Described { name, standard_name: "", long_name, units: "m", comment: "" }
}

fn length(section: &Section) -> f64 {
    section.line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// The ends of a section on the left and on the right bank.
fn ends(section: &Section) -> [Vec2; 2] {
    let nowhere = Vec2::new(f64::NAN, f64::NAN);
    [section.line.first(), section.line.last()].map(|end| end.copied().unwrap_or(nowhere))
}

/// The place on a section at half of its length.
fn middle(section: &Section) -> Vec2 {
    let mut left = 0.5 * length(section);
    for pair in section.line.windows(2) {
        let way = pair[1] - pair[0];
        if left <= way.norm() && way.norm() > 0.0 {
            return pair[0] + way * (left / way.norm());
        }
        left -= way.norm();
    }
    ends(section)[1]
}

/// One time series for each section, as CF describes them (discrete sampling geometries).
fn write_netcdf(
    path: &std::path::Path,
    crs: Option<&WritableCrs>,
    provenance: &Provenance,
    sections: &[Section],
    SectionRecording { results, samples }: &SectionRecording,
) -> netcdf::Result<()> {
    let mut file = Written::create(path, Options::NETCDF4)?;
    for (name, value) in provenance.global_attributes() {
        file.add_attribute(name, value)?;
    }
    file.add_attribute("featureType", "timeSeries")?;
    let count = sections.len();
    file.add_dimension("time", samples.len() / count)?;
    file.add_dimension("section", count)?;
    file.add_variable::<f64>("time", &["time"])?;
    put_time_attributes(&mut file, provenance)?;
    let times: Vec<f64> = samples.iter().step_by(count).map(|sample| sample.time).collect();
    variable(&mut file, "time")?.put_values(&times, ..)?;
    write_places(&mut file, crs, sections)?;
    for (described, value) in &SERIES {
        let values: Vec<f64> = samples.iter().map(value).collect();
        let mut variable = file.add_variable::<f64>(described.name, &["time", "section"])?;
        described.put(&mut variable, crs)?;
        variable.put_values(&values, (.., ..))?;
    }
    for (described, value) in &RESULTS {
        let mut variable = file.add_variable::<f64>(described.name, &["section"])?;
        variable.put_attribute("_FillValue", f64::from(FILL))?;
        described.put(&mut variable, crs)?;
        let number = |(section, result)| value(section, result).unwrap_or(f64::from(FILL));
        let values: Vec<f64> = sections.iter().zip(results).map(number).collect();
        variable.put_values(&values, ..)?;
    }
    file.close()
}

/// Names and middles of the sections, and the system of their coordinates.
fn write_places(file: &mut FileMut, crs: Option<&WritableCrs>, sections: &[Section]) -> netcdf::Result<()> {
    let mut names = file.add_string_variable("section_id", &["section"])?;
    names.put_attribute("long_name", "name of the cross-section")?;
    names.put_attribute("cf_role", "timeseries_id")?;
    for (index, section) in sections.iter().enumerate() {
        names.put_string(&section.id, index)?;
    }
    let (x, y): (Vec<f64>, Vec<f64>) = sections.iter().map(middle).map(|place| (place.x, place.y)).unzip();
    for (name, values) in [("x", x), ("y", y)] {
        let mut variable = file.add_variable::<f64>(name, &["section"])?;
        variable.put_attribute("standard_name", format!("projection_{name}_coordinate"))?;
        variable.put_attribute("long_name", format!("{name} coordinate of the middle of the cross-section"))?;
        variable.put_attribute("units", "m")?;
        variable.put_values(&values, ..)?;
    }
    if let Some(crs) = crs {
        define_crs(file, crs)?.put_value(0_i32, ())?;
    }
    Ok(())
}

impl Described {
    /// Puts the attributes that are not empty.
    fn put(&self, variable: &mut VariableMut<'_>, crs: Option<&WritableCrs>) -> netcdf::Result<()> {
        let attributes = [
            ("standard_name", self.standard_name),
            ("long_name", self.long_name),
            ("units", self.units),
            ("comment", self.comment),
            ("coordinates", COORDINATES),
            ("grid_mapping", if crs.is_some() { "crs" } else { "" }),
        ];
        put_texts(variable, &attributes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_bent_line_lies_on_it_at_half_its_length() {
        let line = [(0.0, 0.0), (0.0, 0.0), (2.0, 0.0), (2.0, 8.0)].map(|(x, y)| Vec2::new(x, y)).to_vec();
        let section = Section { id: String::new(), line };
        assert!((middle(&section) - Vec2::new(2.0, 3.0)).norm() < 1e-12, "{:?}", middle(&section));
        assert_eq!(ends(&section), [Vec2::new(0.0, 0.0), Vec2::new(2.0, 8.0)]);
    }
}
