//! Writers of the files of a run folder.

mod channel_profiles;
mod channels;
mod cog;
mod crs;
mod fields;
mod gdal_raw;
mod geopackage;
mod level_layer;
mod maps;
mod netcdf_file;
mod netcdf_raw;
mod projection;
mod qgis;
mod read_back;
mod sections;
mod tables;
mod tracers;
mod variables;

pub use channel_profiles::ChannelsWriter;
pub use channels::write_channels;
pub use cog::write_cogs;
pub use fields::FieldsWriter;
pub use geopackage::{Findings, write_geopackage};
pub use level_layer::{LevelArea, write_level_layer};
pub use maps::{write_map_file, write_maps};
pub use sections::{write_section_file, write_section_tables, write_sections};
pub use tables::{write_difference_table, write_gauges, write_mass_balance, write_passages, write_quantile_table};
pub use tracers::write_tracers;
pub use variables::{MapClass, MapKind, MapVariable, hazard_classes, map_variables, threshold_name};

use super::OutputCrs;
use crate::calendar::{UtcTime, cf};

/// The date of t = 0 where the scenario has none.
const STAND_IN: &str = "2000-01-01 00:00:00";

/// What every file says of itself: the reference system of its places, and where it comes from.
#[derive(Clone, Copy, Debug)]
pub struct FileHead<'a> {
    /// The reference system.
    pub crs: &'a OutputCrs,
    /// Where the file comes from.
    pub provenance: &'a Provenance,
}

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
    /// Date of writing, as [`utc_now`](crate::calendar::utc_now) gives it; the other place with a date.
    pub date_created: String,
    /// Date and time of t = 0, when the scenario has one.
    pub reference_time: Option<UtcTime>,
}

impl Provenance {
    /// The units of time: seconds since the reference time, or since a stated stand-in for it.
    fn time_units(&self) -> String {
        let reference_time = self.reference_time.map_or_else(|| STAND_IN.to_owned(), |moment| moment.to_string());
        cf::seconds_since(&reference_time)
    }

    /// The global attributes in the order in which files have them.
    fn global_attributes(&self) -> Vec<(&'static str, String)> {
        let stand_in = format!("the scenario has no calendar date: {STAND_IN} stands for the start of the flood");
        let comment = match (&self.reference_time, self.comment.is_empty()) {
            (Some(_), _) => self.comment.clone(),
            (None, true) => stand_in,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_calendar_date_is_said() {
        let provenance = Provenance { comment: "a trial".into(), ..Provenance::default() };
        assert_eq!(provenance.time_units(), "seconds since 2000-01-01 00:00:00");
        let comment = provenance.global_attributes().into_iter().find(|(name, _)| *name == "comment").unwrap().1;
        assert!(comment.starts_with("a trial; the scenario has no calendar date"));
    }
}
