//! Dates as people, gauges and files write them: ISO 8601 and the forms that the CF conventions add to it.

use std::fmt::{Display, Formatter};

use chrono::format::{ParseError, ParseErrorKind};
use chrono::{Datelike, Days, FixedOffset, NaiveDate, NaiveDateTime, NaiveTime, Timelike};

use super::UtcTime;

/// The last year that has four digits.
const LAST_YEAR: i32 = 9999;
/// The largest offset from UTC (s) in use: 14 h, of the Line Islands.
const LARGEST_OFFSET: i32 = 14 * 3600;

/// Why a text is no moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DateFault {
    /// It is no date, or one in a form that is not read.
    Form,
    /// The year has no such day.
    Day,
    /// The day has no such time.
    Clock,
    /// It is a leap second.
    LeapSecond,
    /// What stands behind the time is no offset from UTC.
    Offset,
    /// It lies before the Gregorian calendar.
    TooEarly,
    /// It lies before the year 1.
    YearZero,
}

impl Display for DateFault {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            DateFault::Form => "dates are read as year, month, day, then hours, minutes and seconds, then an offset from UTC",
            DateFault::Day => "there is no such day",
            DateFault::Clock => "a day has no such time",
            DateFault::LeapSecond => "it is a leap second, and times are counted without them",
            DateFault::Offset => "what stands behind the time is no offset from UTC, as `Z` or `+02:00` are",
            DateFault::TooEarly => {
                "it lies before 1582-10-15, the first day of the Gregorian calendar; before it the calendar `standard` of NetCDF files \
                 has the days of the Julian one"
            }
            DateFault::YearZero => "the calendar begins with the year 1; files with the year 0 mean a mean of many years",
        })
    }
}

impl UtcTime {
    /// Reads `2026-06-01`, `2026-6-1 6:00`, `2026-06-01T06:00:00.5Z`, or with an offset such as `+02:00` behind the time. A date
    /// without an offset is UTC; `24:00` is the end of its day.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn read(text: &str) -> Result<Self, DateFault> {
        let moment = Self::read_proleptic(text)?;
        let gregorian = NaiveDate::from_ymd_opt(1582, 10, 15).is_some_and(|first| moment.0.date() >= first);
        if gregorian { Ok(moment) } else { Err(DateFault::TooEarly) }
    }

    /// The same, where the rules of the Gregorian calendar hold from the year 1 on.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn read_proleptic(text: &str) -> Result<Self, DateFault> {
        let text = text.trim();
        let (date, rest) = text.split_once(['T', 't', ' ']).unwrap_or((text, ""));
        let is_of_clock = |c: char| c.is_ascii_digit() || [':', '.', ','].contains(&c);
        let rest = rest.trim_start();
        let (clock, zone) = rest.split_at(rest.find(|c| !is_of_clock(c)).unwrap_or(rest.len()));
        if clock.is_empty() && text.len() > date.len() {
            return Err(DateFault::Form);
        }
        let (clock, is_end_of_day) = read_clock(clock)?;
        let offset = FixedOffset::east_opt(read_offset(zone.trim())?).ok_or(DateFault::Offset)?;
        let local = NaiveDateTime::new(read_date(date)?, clock);
        let local = local.checked_add_days(Days::new(is_end_of_day.into())).ok_or(DateFault::Day)?;
        let moment = local.checked_sub_offset(offset).ok_or(DateFault::Day)?;
        match moment.year() {
            year if year < 1 => Err(DateFault::YearZero),
            year if year > LAST_YEAR => Err(DateFault::Day),
            _ => Ok(UtcTime(moment)),
        }
    }
}

/// Reads `2026-06-01` or `2026-6-1`.
fn read_date(text: &str) -> Result<NaiveDate, DateFault> {
    let parts: Vec<&str> = text.split('-').collect();
    let is_number = |part: &&str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    if parts.len() != 3 || !parts.iter().all(is_number) || parts[0].len() > 4 {
        return Err(DateFault::Form);
    }
    NaiveDate::parse_from_str(text, "%Y-%m-%d").map_err(|error| fault_of(error, DateFault::Day))
}

/// Reads `6`, `06:00` or `06:00:00.5`, and whether it stands for the end of the day; the beginning of the day without a text.
fn read_clock(text: &str) -> Result<(NaiveTime, bool), DateFault> {
    let missing = match (text.is_empty(), text.matches(':').count()) {
        (true, _) => "0:0:0",
        (_, 0) => ":0:0",
        (_, 1) => ":0",
        _ => "",
    };
    let whole = format!("{text}{missing}").replace(',', ".");
    let midnight = whole.strip_prefix("24:").filter(|rest| !rest.contains(|c| ('1'..='9').contains(&c)));
    let whole = midnight.map_or(whole.clone(), |rest| format!("0:{rest}"));
    let time = NaiveTime::parse_from_str(&whole, "%H:%M:%S%.f").map_err(|error| fault_of(error, DateFault::Clock))?;
    // `chrono` keeps the 61st second of a minute as a fraction above 1 of the 60th.
    if time.nanosecond() >= 1_000_000_000 { Err(DateFault::LeapSecond) } else { Ok((time, midnight.is_some())) }
}

/// Seconds by which a local time is before UTC: `Z`, `UTC`, `+2`, `+02:00`, `-0330`; 0 without a text.
fn read_offset(text: &str) -> Result<i32, DateFault> {
    if ["", "Z", "UTC", "GMT"].contains(&text.to_uppercase().as_str()) {
        return Ok(0);
    }
    let (sign, rest) = match (text.strip_prefix('+'), text.strip_prefix('-')) {
        (Some(rest), _) => (1, rest),
        (_, Some(rest)) => (-1, rest),
        _ => return Err(DateFault::Offset),
    };
    let parts = rest.split_once(':').or_else(|| if rest.len() == 4 { rest.split_at_checked(2) } else { None });
    let (hours, minutes) = parts.unwrap_or((rest, "0"));
    let number = |text: &str| text.parse::<u8>().map(i32::from).map_err(|_| DateFault::Offset);
    let (hours, minutes) = (number(hours)?, number(minutes)?);
    let seconds = 3600 * hours + 60 * minutes;
    if minutes < 60 && seconds <= LARGEST_OFFSET { Ok(sign * seconds) } else { Err(DateFault::Offset) }
}

/// What an error of `chrono` says: a number that does not exist, or something else than a number.
fn fault_of(error: ParseError, no_such: DateFault) -> DateFault {
    match error.kind() {
        ParseErrorKind::OutOfRange | ParseErrorKind::Impossible => no_such,
        _ => DateFault::Form,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_of_a_date_is_the_same_moment() {
        for text in [
            "2026-06-01 06:00:00",
            "2026-06-01T06:00",
            "2026-06-01t06:00z",
            "2026-6-1 6",
            " 2026-06-01  06:00:00 UTC ",
            "2026-06-01 06:00:00.000Z",
            "2026-06-01T08:00:00+02:00",
            "2026-06-01 02:30 -0330",
            "2026-06-01 00:00:00.0 -6",
            "2026-05-31T20:00-10:00",
        ] {
            assert_eq!(
                UtcTime::read(text).map(|moment| moment.to_string()),
                Ok("2026-06-01 06:00:00".into()),
                "{text}"
            );
        }
    }

    #[test]
    fn what_is_written_reads_back() {
        for text in ["1582-10-15 00:00:00", "2024-02-29 23:59:59.500", "9999-12-31 23:59:59", "1959-12-02 21:14:05"] {
            let moment = UtcTime::read(text).unwrap();
            assert_eq!((moment.to_string().as_str(), UtcTime::read(&moment.iso8601())), (text, Ok(moment)));
        }
    }

    #[test]
    fn the_end_of_a_day_is_the_beginning_of_the_next() {
        for (text, next) in [
            ("2026-06-01 24:00", "2026-06-02 00:00:00"),
            ("2024-02-28T24:00:00.0", "2024-02-29 00:00:00"),
            ("2023-12-31 24:00:00+01:00", "2023-12-31 23:00:00"),
            ("2026-06-01T06:00:00,25", "2026-06-01 06:00:00.250"),
        ] {
            assert_eq!(UtcTime::read(text).map(|moment| moment.to_string()).as_deref(), Ok(next), "{text}");
        }
    }

    #[test]
    fn what_is_no_moment_says_why() {
        for (text, fault) in [
            ("", DateFault::Form),
            ("01.06.2026", DateFault::Form),
            ("2026-06", DateFault::Form),
            ("2026-06-01T", DateFault::Form),
            ("+2026-06-01", DateFault::Form),
            ("12026-06-01", DateFault::Form),
            ("2026-06-01 0600", DateFault::Form),
            ("2026-06-01 06:00:00:00", DateFault::Form),
            ("2023-02-29", DateFault::Day),
            ("1900-02-29", DateFault::Day),
            ("2024-13-01", DateFault::Day),
            ("2024-04-31", DateFault::Day),
            ("2026-06-00", DateFault::Day),
            ("9999-12-31 24:00", DateFault::Day),
            ("2026-06-01 24:01", DateFault::Clock),
            ("2026-06-01 25:00", DateFault::Clock),
            ("2026-06-01 06:60", DateFault::Clock),
            ("2016-12-31 23:59:61", DateFault::Clock),
            ("2016-12-31 23:59:60", DateFault::LeapSecond),
            ("2016-12-31T23:59:60.5Z", DateFault::LeapSecond),
            ("2026-06-01 06:00 CEST", DateFault::Offset),
            ("2026-06-01 06:00+14:01", DateFault::Offset),
            ("2026-06-01 06:00+01:60", DateFault::Offset),
            ("2026-06-01 06:00+ü", DateFault::Offset),
            ("0000-01-01", DateFault::YearZero),
            ("0001-01-01 00:00+01:00", DateFault::YearZero),
            ("0001-01-01", DateFault::TooEarly),
            ("1500-02-29", DateFault::Day),
            ("1500-03-01", DateFault::TooEarly),
            ("1582-10-15 00:00+01:00", DateFault::TooEarly),
        ] {
            assert_eq!(UtcTime::read(text), Err(fault), "{text}");
        }
    }
}
