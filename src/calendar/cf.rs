//! Times of NetCDF files after the CF conventions: `minutes since 2026-06-01 06:00:00` and the calendar of their dates.
//!
//! Not here: calendars without the days of the Gregorian one (`360_day`, `noleap`, `julian` ...), and units of no fixed length (months,
//! years): a file with one of these is refused.

use super::{DateFault, UtcTime};

/// The calendar of the outputs: Gregorian from 1582-10-15 on, and Julian before.
pub const CALENDAR: &str = "standard";

/// Seconds of a day.
const DAY: f64 = 86_400.0;

/// What the unit of a time says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeUnit {
    /// Seconds of one.
    pub factor: f64,
    /// The date from which the times count; none where the unit names no date.
    pub since: Option<UtcTime>,
}

/// Why a unit or a calendar is none of a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeFault {
    /// The calendar has other days than the Gregorian one.
    Calendar,
    /// The unit is none of time, or has no fixed length.
    Unit,
    /// The date of the unit is none.
    Date(DateFault),
}

/// The unit of a time that counts in a calendar, `standard` where the file names none.
///
/// # Errors
/// What is wrong with the calendar or the unit.
pub fn time_unit(text: &str, calendar: Option<&str>) -> Result<TimeUnit, TimeFault> {
    let read = reader_of(calendar)?;
    let words: Vec<&str> = text.split_whitespace().collect();
    let factor = match words.first().map(|word| word.to_lowercase()).as_deref() {
        Some("s" | "sec" | "secs" | "second" | "seconds") => 1.0,
        Some("min" | "mins" | "minute" | "minutes") => 60.0,
        Some("h" | "hr" | "hrs" | "hour" | "hours") => 3600.0,
        Some("d" | "day" | "days") => DAY,
        _ => return Err(TimeFault::Unit),
    };
    match words.get(1).map(|word| word.to_lowercase()).as_deref() {
        None => Ok(TimeUnit { factor, since: None }),
        Some("since") => {
            let since = read(&words[2..].join(" ")).map_err(TimeFault::Date)?;
            Ok(TimeUnit { factor, since: Some(since) })
        }
        Some(_) => Err(TimeFault::Unit),
    }
}

type Read = fn(&str) -> Result<UtcTime, DateFault>;

/// How the dates of a calendar are read.
fn reader_of(calendar: Option<&str>) -> Result<Read, TimeFault> {
    match calendar.unwrap_or(CALENDAR).trim().to_lowercase().as_str() {
        "standard" | "gregorian" => Ok(UtcTime::read),
        "proleptic_gregorian" => Ok(UtcTime::read_proleptic),
        _ => Err(TimeFault::Calendar),
    }
}

/// The unit of times (s) that count from a moment.
pub fn seconds_since(reference: &str) -> String {
    format!("seconds since {reference}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(factor: f64, since: &str) -> Result<TimeUnit, TimeFault> {
        Ok(TimeUnit { factor, since: Some(UtcTime::read_proleptic(since).unwrap()) })
    }

    #[test]
    fn units_of_time_have_a_length_and_may_have_a_date() {
        for (text, expected) in [
            ("minutes since 1970-01-02", unit(60.0, "1970-01-02")),
            ("Hours since 1970-01-01T01:00:00Z", unit(3600.0, "1970-01-01 01:00")),
            // The two of the CF conventions, 4.4.
            ("seconds since 1992-10-8 15:15:42.5 -6:00", unit(1.0, "1992-10-08 21:15:42.5")),
            ("days since 1990-1-1 0:0:0", unit(DAY, "1990-01-01")),
            ("days", Ok(TimeUnit { factor: DAY, since: None })),
            ("months since 1970-01-01", Err(TimeFault::Unit)),
            ("minutes before 1970-01-01", Err(TimeFault::Unit)),
            ("hours since the flood", Err(TimeFault::Date(DateFault::Form))),
            ("hours since", Err(TimeFault::Date(DateFault::Form))),
            ("", Err(TimeFault::Unit)),
            ("mm/h", Err(TimeFault::Unit)),
        ] {
            assert_eq!(time_unit(text, None), expected, "{text}");
        }
    }

    #[test]
    fn dates_before_the_gregorian_calendar_are_read_in_the_proleptic_one_alone() {
        let early = "days since 0001-01-01 00:00:00";
        for (calendar, expected) in [
            (None, Err(TimeFault::Date(DateFault::TooEarly))),
            (Some("standard"), Err(TimeFault::Date(DateFault::TooEarly))),
            (Some("Gregorian"), Err(TimeFault::Date(DateFault::TooEarly))),
            (Some("proleptic_gregorian"), unit(DAY, "0001-01-01")),
            (Some("julian"), Err(TimeFault::Calendar)),
            (Some("360_day"), Err(TimeFault::Calendar)),
        ] {
            assert_eq!(time_unit(early, calendar), expected, "{calendar:?}");
        }
        // `date -u -d '0001-01-01' +%s` is -62135596800; of the year 0 UDUNITS makes a climatology.
        let since = time_unit(early, Some("proleptic_gregorian")).unwrap().since.unwrap();
        assert_eq!(Some(since), UtcTime::of_unix(-62_135_596_800));
        let zero = time_unit("days since 0000-01-01", Some("proleptic_gregorian"));
        assert_eq!(zero, Err(TimeFault::Date(DateFault::YearZero)));
    }
}
