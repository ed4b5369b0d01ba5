//! The one calendar: every date that scenarios, tables and NetCDF files have, and every date that outputs get.
//!
//! A moment is a date and time of UTC in the Gregorian calendar, without leap seconds; its arithmetic is that of `chrono`.
//! Here: how moments are written ([`UtcTime`]), which forms are read ([`read`](UtcTime::read)), and the times of the CF conventions
//! ([`cf`]). Not here: times that are numbers with a unit (`scenario/units.rs`).

pub mod cf;
mod read;

use std::fmt::{Display, Formatter};

use chrono::{DateTime, NaiveDateTime};

pub use read::DateFault;

/// A date and time of UTC; written as `2026-06-01 06:00:00`, with a fraction of the second where it has one. The default is the
/// beginning of 1970.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct UtcTime(NaiveDateTime);

impl UtcTime {
    /// The form in which messages and examples write a moment.
    pub const EXAMPLE: &'static str = "2026-06-01 06:00:00";

    /// The moment so many seconds after the beginning of 1970; none beyond the years that `chrono` knows.
    pub fn of_unix(seconds: i64) -> Option<Self> {
        DateTime::from_timestamp(seconds, 0).map(|time| UtcTime(time.naive_utc()))
    }

    /// Time (s) from another moment to this one, negative where this one is earlier; exact to the nanosecond for 100 days.
    pub fn seconds_since(self, other: UtcTime) -> f64 {
        let between = self.0 - other.0;
        between.num_seconds() as f64 + f64::from(between.subsec_nanos()) * 1e-9
    }

    /// The moment as `2026-06-01T06:00:00Z` (ISO 8601).
    pub fn iso8601(self) -> String {
        format!("{}Z", self.0.format("%Y-%m-%dT%H:%M:%S%.f"))
    }
}

impl Display for UtcTime {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0.format("%Y-%m-%d %H:%M:%S%.f"))
    }
}

/// The time now, as `2026-06-01T06:00:00Z`; that of the variable `SOURCE_DATE_EPOCH` (seconds since 1970) where it is set, so that
/// a run can be repeated to the same bytes.
pub fn utc_now() -> String {
    let stated = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| UtcTime::of_unix(text.parse().ok()?));
    let now = || {
        let since = std::time::UNIX_EPOCH.elapsed().map_or(0, |elapsed| elapsed.as_secs());
        UtcTime::of_unix(i64::try_from(since).ok()?)
    };
    stated.or_else(now).map_or_else(String::new, UtcTime::iso8601)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_of_known_seconds() {
        // `date -u -d @SECONDS`
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_704_067_199, "2023-12-31T23:59:59Z"),
            (1_735_603_200, "2024-12-31T00:00:00Z"),
            (-318_134_760, "1959-12-02T21:14:00Z"),
        ] {
            assert_eq!(UtcTime::of_unix(seconds).map(UtcTime::iso8601).as_deref(), Some(date));
        }
        assert_eq!(UtcTime::of_unix(i64::MAX), None);
    }

    #[test]
    fn time_between_moments_has_its_sign_and_its_fraction() {
        let moment = |text| UtcTime::read(text).unwrap();
        let (early, late) = (moment("2024-02-28 23:59:59.75"), moment("2024-03-01"));
        assert_eq!(late.seconds_since(early).to_bits(), 86_400.25_f64.to_bits());
        assert_eq!(early.seconds_since(late).to_bits(), (-86_400.25_f64).to_bits());
    }
}
