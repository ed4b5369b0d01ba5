//! Times of NetCDF files after the CF conventions: `minutes since 2026-06-01 06:00:00`, and dates as seconds.
//!
//! Not here: calendars without the days of the Gregorian one (`360_day`, `noleap` ...), which `rain_series` refuses, and units
//! of no fixed length (months, years).

/// Seconds of a day.
const DAY: f64 = 86_400.0;

/// What the unit of a time says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TimeUnit {
    /// Seconds of one.
    pub factor: f64,
    /// The date from which the times count, in seconds since 1970 (UTC); none where the unit names no date.
    pub since: Option<f64>,
}

/// The unit of a time; none where it is none, or its date cannot be read.
pub(super) fn time_unit(text: &str) -> Option<TimeUnit> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let factor = match words.first()?.to_lowercase().as_str() {
        "s" | "sec" | "secs" | "second" | "seconds" => 1.0,
        "min" | "mins" | "minute" | "minutes" => 60.0,
        "h" | "hr" | "hrs" | "hour" | "hours" => 3600.0,
        "d" | "day" | "days" => DAY,
        _ => return None,
    };
    match words.get(1).map(|word| word.to_lowercase()).as_deref() {
        None => Some(TimeUnit { factor, since: None }),
        Some("since") => Some(TimeUnit { factor, since: Some(seconds_of(&words[2..].join(" "))?) }),
        Some(_) => None,
    }
}

/// Seconds since 1970 (UTC) of a date as `2026-06-01`, `2026-6-1 6:00`, `2026-06-01T06:00:00.5Z`, or with an offset such as
/// `+02:00` behind its time.
pub(super) fn seconds_of(text: &str) -> Option<f64> {
    let text = text.trim();
    let (date, time) = text.split_once(['T', ' ']).unwrap_or((text, ""));
    let [year, month, day] = date.split('-').map(|part| part.parse().ok()).collect::<Option<Vec<i64>>>()?[..] else {
        return None;
    };
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return None,
    };
    if !(1583..=9999).contains(&year) || !(1..=length).contains(&day) {
        return None;
    }
    let (clock, zone) = split_zone(time.trim());
    Some(days_since_1970(year, month, day) as f64 * DAY + clock_seconds(clock)? - zone_seconds(zone)?)
}

/// Days from 1970-01-01 to a date of the Gregorian calendar, in years that begin with March.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let before_month = (153 * month + 2) / 5;
    365 * year + year / 4 - year / 100 + year / 400 + before_month + day - 719_469
}

/// A time of the day and what stands behind it.
fn split_zone(text: &str) -> (&str, &str) {
    let end = text.find(|c: char| !(c.is_ascii_digit() || c == ':' || c == '.')).unwrap_or(text.len());
    (&text[..end], text[end..].trim())
}

/// Seconds of `6`, `06:00` or `06:00:00.5`; 0 of nothing.
fn clock_seconds(text: &str) -> Option<f64> {
    if text.is_empty() {
        return Some(0.0);
    }
    let parts = text.split(':').map(|part| part.parse().ok()).collect::<Option<Vec<f64>>>()?;
    let (hour, minute, second) = match parts[..] {
        [hour] => (hour, 0.0, 0.0),
        [hour, minute] => (hour, minute, 0.0),
        [hour, minute, second] => (hour, minute, second),
        _ => return None,
    };
    let is_valid = hour < 24.0 && minute < 60.0 && second < 60.0 && hour.fract() == 0.0 && minute.fract() == 0.0;
    is_valid.then_some(3600.0 * hour + 60.0 * minute + second)
}

/// Seconds by which a zone is before UTC: `Z`, `UTC`, `+2`, `+02:00`, `-0330`.
fn zone_seconds(text: &str) -> Option<f64> {
    if ["", "Z", "UTC", "GMT"].contains(&text.to_uppercase().as_str()) {
        return Some(0.0);
    }
    let (sign, rest) = match text.split_at_checked(1)? {
        ("+", rest) => (1.0, rest),
        ("-", rest) => (-1.0, rest),
        _ => return None,
    };
    let (hours, minutes) = match rest.split_once(':') {
        Some(parts) => parts,
        None if rest.len() == 4 => rest.split_at_checked(2)?,
        None => (rest, "0"),
    };
    let (hours, minutes): (u32, u32) = (hours.parse().ok()?, minutes.parse().ok()?);
    (hours <= 14 && minutes < 60).then(|| sign * (3600.0 * f64::from(hours) + 60.0 * f64::from(minutes)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_become_seconds() {
        // `date -u -d DATE +%s`
        for (text, seconds) in [
            ("1970-01-01", 0.0),
            ("2000-02-29 00:00", 951_782_400.0),
            ("2026-06-01 06:00:00", 1_780_293_600.0),
            ("2026-6-1 6", 1_780_293_600.0),
            ("2026-06-01T08:00:00.5+02:00", 1_780_293_600.5),
            ("2026-06-01 02:30 -0330", 1_780_293_600.0),
            ("2026-06-01 06:00:00 UTC", 1_780_293_600.0),
            ("1959-12-02T21:14Z", -318_134_760.0),
        ] {
            assert_eq!(seconds_of(text), Some(seconds), "{text}");
        }
        for text in
            ["2023-02-29", "2024-13-01", "01.06.2026", "2026-06-01 24:00", "2026-06-01 06:00 CEST", "", "0000-01-01"]
        {
            assert_eq!(seconds_of(text), None, "{text}");
        }
    }

    #[test]
    fn units_of_time_have_a_length_and_may_have_a_date() {
        let unit = |factor, since| Some(TimeUnit { factor, since });
        assert_eq!(time_unit("minutes since 1970-01-02"), unit(60.0, Some(86_400.0)));
        assert_eq!(time_unit("Hours since 1970-01-01T01:00:00Z"), unit(3600.0, Some(3600.0)));
        assert_eq!(time_unit("days"), unit(86_400.0, None));
        for text in ["months since 1970-01-01", "minutes before 1970-01-01", "hours since the flood", "", "mm/h"] {
            assert_eq!(time_unit(text), None, "{text}");
        }
    }
}
