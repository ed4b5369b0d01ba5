//! The cross-sections: `sections.csv` and `section_series.csv` in `tables/`, and `sections.nc` with `discharge(time, section)`.

use netcdf::Options;

use super::super::folder::{RunFolder, output_error, write_lines};
use super::super::sections::{Section, SectionResult, SectionSample};
use super::Provenance;
use super::netcdf_file::put_time_attributes;
use super::tables::{decimals, number, row, text};
use crate::error::Error;

/// Writes the tables and the NetCDF file of the cross-sections; nothing where there are none.
///
/// # Errors
/// When one of them cannot be written.
pub fn write_sections(
    folder: &RunFolder,
    provenance: &Provenance,
    sections: &[Section],
    results: &[SectionResult],
    samples: &[SectionSample],
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
    write_lines(folder, "tables/section_series.csv", "id,time_s,discharge_m3_s,volume_m3", rows)?;
    folder.write_with("sections.nc", |path| {
        let write = || write_netcdf(path, provenance, sections, samples);
        write().map_err(|cause| output_error(path, cause))
    })
}

fn length(section: &Section) -> f64 {
    section.line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// One time series for each section, as CF describes them (discrete sampling geometries).
fn write_netcdf(
    path: &std::path::Path,
    provenance: &Provenance,
    sections: &[Section],
    samples: &[SectionSample],
) -> netcdf::Result<()> {
    let mut file = netcdf::create_with(path, Options::NETCDF4)?;
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
    let missing = |name: &str| netcdf::Error::NotFound(name.to_string());
    file.variable_mut("time").ok_or_else(|| missing("time"))?.put_values(&times, ..)?;
    let mut names = file.add_string_variable("section_id", &["section"])?;
    names.put_attribute("long_name", "name of the cross-section")?;
    names.put_attribute("cf_role", "timeseries_id")?;
    for (index, section) in sections.iter().enumerate() {
        names.put_string(&section.id, index)?;
    }
    type Value = fn(&SectionSample) -> f64;
    let variables: [(&str, &str, &str, &str, Value); 2] = [
        (
            "discharge",
            "discharge through the cross-section, mean of the compute step",
            "m3 s-1",
            "water_volume_transport_in_river_channel",
            |sample| sample.discharge,
        ),
        ("volume", "volume through the cross-section since the start", "m3", "", |sample| sample.volume),
    ];
    for (name, long_name, units, standard_name, value) in variables {
        let values: Vec<f64> = samples.iter().map(value).collect();
        let mut variable = file.add_variable::<f64>(name, &["time", "section"])?;
        variable.put_attribute("long_name", long_name)?;
        variable.put_attribute("units", units)?;
        if !standard_name.is_empty() {
            variable.put_attribute("standard_name", standard_name)?;
        }
        variable.put_attribute("coordinates", "section_id")?;
        variable.put_attribute("comment", "positive where the water crosses the line towards its left side")?;
        variable.put_values(&values, (.., ..))?;
    }
    file.close()
}
