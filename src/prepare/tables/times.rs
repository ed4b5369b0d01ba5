//! Whether the times of a series fit the run: where it begins and ends, how far beyond the run it goes, and its gaps.

use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::math::readable;
use crate::prepare::tables::rows::Row;
use crate::scenario::AfterEnd;

/// A step of time longer than so many of the usual ones is a gap.
const GAP: f64 = 10.0;
/// The same of a series whose steps are equal: one row that is missing is a step of 2, which a straight line bridges well enough.
const GAP_OF_EQUAL_STEPS: f64 = 2.5;
/// Share of a step by which it may miss an equal one.
const SAME_STEP: f64 = 0.01;
/// Steps are equal where this share of them is, and where there are so many at least: times picked by hand are not, as a rule.
const EQUAL_STEPS: f64 = 0.75;
const LEAST_STEPS: usize = 8;
/// A series that goes on for more than so many times the run is worth a question where the run takes fewer than so many of its rows:
/// minutes taken for hours make it 60 times as long, and a long record of which a run takes a part has more rows in that part.
const LONG: f64 = 20.0;
const FEW_ROWS: usize = 10;

/// Whether rows that rise hold from the start of the run to its end, or are held on until then, are meant in this unit, and have no gap.
pub fn coverage(rows: &[Row], name: &str, (end, after_end): (f64, Option<AfterEnd>)) -> Vec<Problem> {
    let mut found = Vec::new();
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return found };
    if first.numbers[0] > 0.0 {
        let message = format!("{name} begins {} s after the start of the run (line {})", first.numbers[0], first.line);
        let remedy = if first.is_dated {
            "add a row for that time or before it, or correct `time.reference`, the date of the start in UTC"
        } else {
            "add a row for time 0; times count from the start of the run"
        };
        found.push(input_error("series-starts-late", message).with_remedy(remedy));
    }
    if last.numbers[0] < end {
        let ends = format!("{name} ends at {} s (line {}), before the run does at {end} s", last.numbers[0], last.line);
        found.push(match after_end {
            None => {
                let times = if last.is_dated { "`time.reference`" } else { "the unit of the times" };
                input_error("series-ends-early", ends).with_remedy(format!("add rows up to the end, shorten `time.end`, correct {times}, or write `after_end: hold` beside `series` where the last value holds on"))
            }
            Some(AfterEnd::Hold) => {
                let held = readable(end - last.numbers[0]);
                let message = format!("{ends}; its last value holds on for {held} s");
                let remedy = "add rows where it is known how it went on";
                Problem::warning(ProblemKind::Input, "series-held", "", message).with_remedy(remedy)
            }
        });
    }
    found.extend(far_beyond(rows, name, end));
    found.extend(gap(rows, name, end));
    found
}

/// Whether a run to an end (s) takes so few rows of a series, and so little of its time up to its last row (s), that the unit is worth a question.
pub fn takes_little(taken: usize, end: f64, last: f64) -> bool {
    end > 0.0 && last > LONG * end && taken < FEW_ROWS
}

/// Warns of a series of which the run takes so little that its times may have another unit; not where its values stay as they are.
fn far_beyond(rows: &[Row], name: &str, end: f64) -> Option<Problem> {
    let last = rows.last()?;
    let taken = rows.partition_point(|row| row.numbers[0] < end);
    let is_constant = |rows: &[Row]| rows.windows(2).all(|pair| is_same(pair[0].numbers[1], pair[1].numbers[1]));
    (takes_little(taken, end, last.numbers[0]) && !is_constant(&rows[taken.saturating_sub(1)..])).then(|| {
        let message = format!(
            "of {name} the run takes {taken} of {} rows: it ends at {} s, the series at {} s (line {}), {:.0} times as late",
            rows.len(),
            readable(end),
            readable(last.numbers[0]),
            last.line,
            last.numbers[0] / end
        );
        let (cause, times) = if last.is_dated {
            ("is `time.reference` right? dates count from it".to_owned(), "it")
        } else {
            let taken = format!("{} is taken for {} s", last.written[0], readable(last.numbers[0]));
            (format!("is the unit of its times right? {taken}"), "the unit of the times")
        };
        input_warning("series-far-beyond", message)
            .with_cause(cause)
            .with_remedy(format!("nothing, if the run is to see so little of it; otherwise correct {times}, or `time.end`"))
    })
}

/// Warns of steps of time that are long beside the others; those after the end of the run (s) do not matter, where it is not 0.
pub fn gap(rows: &[Row], name: &str, end: f64) -> Option<Problem> {
    let steps: Vec<f64> = rows.windows(2).map(|pair| pair[1].numbers[0] - pair[0].numbers[0]).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = *sorted.get(sorted.len() / 2).filter(|_| sorted.len() >= 4)?;
    let is_usual = |step: Option<&f64>| step.is_some_and(|step| (step / usual - 1.0).abs() <= SAME_STEP);
    let equal = steps.iter().filter(|step| is_usual(Some(step))).count();
    let are_equal = steps.len() >= LEAST_STEPS && equal as f64 >= EQUAL_STEPS * steps.len() as f64;
    // Between equal steps and two values rows are missing; a plateau, a first and a last row are often drawn by hand.
    let is_hole = |step: usize| {
        let differ = !is_same(rows[step].numbers[1], rows[step + 1].numbers[1]);
        differ && step > 0 && is_usual(steps.get(step - 1)) && is_usual(steps.get(step + 1))
    };
    let is_gap = |step: &usize| {
        let length = steps[*step] / usual;
        length > GAP || (are_equal && length > GAP_OF_EQUAL_STEPS && is_hole(*step))
    };
    let matters = |step: &usize| end <= 0.0 || (rows[*step].numbers[0] < end && rows[step + 1].numbers[0] > 0.0);
    let gaps: Vec<usize> = (0..steps.len()).filter(is_gap).filter(matters).collect();
    let (from, to) = (&rows[*gaps.first()?], &rows[*gaps.first()? + 1]);
    let others = if gaps.len() > 1 { format!(", and {} more", gaps.len() - 1) } else { String::new() };
    let message = format!(
        "{name} has a gap from {} s (line {}) to {} s (line {}), where a step of {} s is usual{others}",
        readable(from.numbers[0]),
        from.line,
        readable(to.numbers[0]),
        to.line,
        readable(usual)
    );
    let problem = input_warning("series-gap", message).with_cause("between rows the value is taken as linear");
    Some(problem.with_remedy("fill the gap if it is not so"))
}

fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of these times (s), one value or another.
    fn rows(times: impl IntoIterator<Item = f64>, value: impl Fn(f64) -> f64) -> Vec<Row> {
        let row = |(k, time): (usize, f64)| Row {
            line: k + 2,
            numbers: [time, value(time)],
            written: [time / 60.0, 0.0],
            is_dated: false,
        };
        times.into_iter().enumerate().map(row).collect()
    }

    fn gaps(times: &[f64], end: f64) -> Option<String> {
        gap(&rows(times.iter().copied(), |time| time), "x", end).map(|problem| problem.message)
    }

    /// Of 20 times those that are kept.
    fn quarters(is_kept: impl Fn(usize) -> bool) -> Vec<f64> {
        (0..20).filter(|k| is_kept(*k)).map(|k| 900.0 * k as f64).collect()
    }

    #[test]
    fn rows_that_are_missing_between_equal_steps_are_a_gap() {
        let text = "x has a gap from 2700 s (line 5) to 10800 s (line 6), where a step of 900 s is usual";
        assert_eq!(gaps(&quarters(|k| !(4..12).contains(&k)), 0.0).as_deref(), Some(text));
        assert_eq!(gaps(&quarters(|k| !(4..6).contains(&k)), 0.0).map(|text| text.contains("to 5400 s")), Some(true));
        let two = gaps(&quarters(|k| ![4, 5, 12, 13].contains(&k)), 0.0);
        assert!(two.as_ref().is_some_and(|text| text.ends_with("is usual, and 1 more")), "{two:?}");
        // One row that is missing; gaps before and after the run.
        assert_eq!(gaps(&quarters(|k| k != 4), 0.0), None);
        assert_eq!(gaps(&quarters(|k| !(12..16).contains(&k)), 9000.0), None);
        let early: Vec<f64> = quarters(|k| !(4..7).contains(&k)).iter().map(|time| time - 6300.0).collect();
        assert_eq!(gaps(&early, 9000.0), None);
    }

    #[test]
    fn times_picked_by_hand_have_no_gap() {
        for times in [
            &[0.0, 10.0, 20.0, 130.0][..],
            &[0.0, 1.0, 2.0, 3.0, 4.0, 8.0, 13.0],
            &[0.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 180.0, 360.0],
            // A first and a last row far off, and finer steps where it matters.
            &[0.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0, 120.0, 130.0, 140.0, 200.0],
            &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 15.0, 19.0, 23.0],
        ] {
            assert_eq!(gaps(times, 0.0), None, "{times:?}");
        }
        // A plateau, but not one of ten steps.
        let plateau = |length: f64| {
            let times = (0..5).map(f64::from).chain((0..5).map(|k| f64::from(k) + 4.0 + length));
            gap(&rows(times, |time| time.min(4.0) - (time - 4.0 - length).max(0.0)), "x", 0.0)
        };
        assert!(plateau(9.0).is_none() && plateau(11.0).is_some());
        // Steps that differ have a gap where one is ten times as long.
        assert!(gaps(&[0.0, 1.0, 3.0, 4.0, 6.0, 27.0, 28.0], 0.0).is_some());
    }

    #[test]
    fn a_series_that_ends_far_beyond_the_run_is_asked_about() {
        let minutes = |step: f64, last: f64| (0..=(last / step) as usize).map(move |k| 3600.0 * step * k as f64);
        let found = |rows: &[Row], end: f64| far_beyond(rows, "x", end);
        // 0 to 130 taken for hours, in a run of 2 h.
        let problem = found(&rows(minutes(10.0, 130.0), |time| time), 7200.0).unwrap();
        let text =
            "of x the run takes 1 of 14 rows: it ends at 7200 s, the series at 468000 s (line 15), 65 times as late";
        assert_eq!((problem.code, problem.message.as_str()), ("series-far-beyond", text));
        assert!(found(&rows(minutes(1.0, 130.0), |time| time), 7200.0).is_some());
        // A day of a year of quarter-hours, half of a flood, a value that holds for ever, and a velocity, which has no end.
        assert!(found(&rows(minutes(0.25, 8760.0), |time| time), 86_400.0).is_none());
        assert!(found(&rows(minutes(10.0, 130.0), |time| time), 43_200.0).is_none());
        assert!(found(&rows([0.0, 3600.0, 1e9], |time| time.min(3600.0)), 7200.0).is_none());
        assert!(found(&rows(minutes(10.0, 130.0), |time| time), 0.0).is_none());
    }
}
