//! Writers of the files of a run folder.

mod channel_profiles;
mod channels;
mod cog;
mod crs;
mod fields;
mod gdal_raw;
mod geopackage;
mod maps;
mod netcdf_file;
mod netcdf_raw;
mod projection;
mod qgis;
mod sections;
mod tables;
mod variables;

use std::time::{SystemTime, UNIX_EPOCH};

pub use channel_profiles::ChannelsWriter;
pub use channels::write_channels;
pub use cog::write_cogs;
pub use fields::FieldsWriter;
pub use geopackage::{Findings, write_geopackage};
pub use maps::write_maps;
pub use sections::{write_section_file, write_section_tables, write_sections};
pub use tables::{write_gauges, write_mass_balance, write_passages};
pub use variables::{MapVariable, map_variables};

/// What the files say about where they come from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Title of the scenario.
    pub title: String,
    /// Who made it; left out when empty.
    pub institution: String,
    /// Program, version and commit.
    pub source: String,
    /// Date and command; one of the two places with a date.
    pub history: String,
    /// Where the method is described; left out when empty.
    pub references: String,
    /// Anything else the reader should know; left out when empty.
    pub comment: String,
    /// Date of writing, as [`utc_now`] gives it; the other place with a date.
    pub date_created: String,
    /// Date and time (UTC) of t = 0 as `YYYY-MM-DD HH:MM:SS`, when the scenario has one.
    pub reference_time: Option<String>,
}

impl Provenance {
    /// The units of time: seconds since the reference time, or since a stated stand-in for it.
    fn time_units(&self) -> String {
        let reference_time = self.reference_time.as_deref().unwrap_or("2000-01-01 00:00:00");
        format!("seconds since {reference_time}")
    }

    /// The global attributes in the order in which files have them.
    fn global_attributes(&self) -> Vec<(&'static str, String)> {
        let stand_in = "the scenario has no calendar date: 2000-01-01 00:00:00 stands for the start of the flood";
        let comment = match (&self.reference_time, self.comment.is_empty()) {
            (Some(_), _) => self.comment.clone(),
            (None, true) => stand_in.to_string(),
            (None, false) => format!("{}; {stand_in}", self.comment),
        };
        let attributes = [
            ("Conventions", "CF-1.11".to_string()),
            ("title", self.title.clone()),
            ("institution", self.institution.clone()),
            ("source", self.source.clone()),
            ("history", self.history.clone()),
            ("references", self.references.clone()),
            ("comment", comment),
            ("date_created", self.date_created.clone()),
        ];
        attributes.into_iter().filter(|(_, value)| !value.is_empty()).collect()
    }
}

/// The time now, as `YYYY-MM-DDTHH:MM:SSZ`; that of the variable `SOURCE_DATE_EPOCH` (seconds since 1970) where it is set, so
/// that a run can be repeated to the same bytes.
pub fn utc_now() -> String {
    let stated = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse().ok());
    let now = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |duration| duration.as_secs());
    utc(stated.unwrap_or_else(now))
}

/// Seconds since 1970 as a date and time of the Gregorian calendar.
fn utc(seconds: u64) -> String {
    let is_leap = |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let (mut year, mut day) = (1970, seconds / 86_400);
    while day >= 365 + u64::from(is_leap(year)) {
        day -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30] {
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    let (hour, minute, second) = (seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
    format!("{year:04}-{month:02}-{:02}T{hour:02}:{minute:02}:{second:02}Z", day + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_of_known_seconds() {
        assert_eq!(utc(0), "1970-01-01T00:00:00Z");
        assert_eq!(utc(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(utc(1_704_067_199), "2023-12-31T23:59:59Z");
        assert_eq!(utc(1_735_603_200), "2024-12-31T00:00:00Z");
    }

    #[test]
    fn missing_calendar_date_is_said() {
        let provenance = Provenance { comment: "a trial".into(), ..Provenance::default() };
        assert_eq!(provenance.time_units(), "seconds since 2000-01-01 00:00:00");
        let comment = provenance.global_attributes().into_iter().find(|(name, _)| *name == "comment").unwrap().1;
        assert!(comment.starts_with("a trial; the scenario has no calendar date"));
    }
}
