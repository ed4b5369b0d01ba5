//! Tables of numbers, and series over time.

use super::{Group, either, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Tables and series",
    problems: &[
        error(
            "ambiguous-date",
            "Day and month of a date can be confused.",
            "Write dates as year-month-day, such as `2026-06-01 06:00`.",
        ),
        error(
            "bad-date",
            "A date does not exist, or has a form that is not read.",
            "Write dates as year-month-day, such as `2026-06-01 06:00`.",
        ),
        error(
            "contradicting-units",
            "The scenario and the name of a column state different units.",
            "Take the unit out of the scenario, or correct the name of the column.",
        ),
        error(
            "dates-as-times",
            "Times are dates, and the date from which they count is not known.",
            "Add `time.reference`, the start of the run in UTC, or write times as numbers with a unit.",
        ),
        error("duplicate-column", "A table has more than one column of this name.", "Give each column its own name."),
        error("empty-table", "A table has no rows.", "Give the table at least one row."),
        error(
            "implausible-level",
            "A level is outside the range of the Earth. It may be a code for a missing value.",
            "Correct the level, its unit or its datum, or take the row out.",
        ),
        error(
            "implausible-value",
            "A number of a table or raster is greater than any of its kind. It may be a code for a missing value, or have another unit.",
            "Correct the number or its unit, take the row out, or declare the no-data value.",
        ),
        error(
            "missing-column",
            "A table does not have a column that is needed.",
            "Correct the name in the scenario or in the first line of the file.",
        ),
        error(
            "missing-unit",
            "A number, a column or a raster of rain has no unit. A wrong guess would change the flood by a factor.",
            "Write the unit behind the number, at the end of the column's name, or as `unit`.",
        ),
        error(
            "mixed-times",
            "A column of dates has a number. It is not known which moment is meant.",
            "Write all times as dates, or all as numbers with a unit.",
        ),
        error(
            "negative-value",
            "A value that cannot be negative is below 0, such as a discharge, a width or a rate of rain.",
            "Correct the value, or declare the fill value as nodata.",
        ),
        error(
            "no-header",
            "The first line of a table does not name its columns.",
            "Begin the file with the names of its columns, with units, as in `time_h,q_m3_s`.",
        ),
        error(
            "not-a-table",
            "The file is not a text table.",
            "Name a CSV file whose first line has the names of its columns.",
        ),
        error(
            "not-rising",
            "Times, levels or distances do not rise from row to row.",
            "Sort the rows, and take out what stands there twice.",
        ),
        error(
            "series-ends-early",
            "A series ends before the run. What comes in afterwards is not known.",
            "Add rows up to the end, shorten `time.end`, or write `after_end: hold`.",
        ),
        warning(
            "series-far-beyond",
            "A series is much longer than the run, which uses only its beginning. The unit of its times may be wrong.",
            "Check the unit or the dates of the series, and `time.end`.",
        ),
        either(
            "series-gap",
            "A series has a gap: values between two rows are taken as linear (warning). Rasters of rain with a gap are an error.",
            "Fill the gap if the values in it differ.",
        ),
        warning(
            "series-held",
            "A series ends before the run or the slide does. Its last value holds from there on.",
            "Add rows up to the end, where the values are known.",
        ),
        error(
            "series-starts-late",
            "A series begins after the start of the run. What comes in before is not known.",
            "Add a row for time 0, or correct the unit or the date of the start.",
        ),
        error(
            "short-table",
            "A rating curve or a growth curve has fewer than two rows.",
            "Give at least two rows: the beginning and the end.",
        ),
        error(
            "too-many-fields",
            "A row has more fields than the first line names. A decimal comma may have split a number.",
            "Write a decimal point, or separate columns with semicolons, and name every column.",
        ),
        error(
            "unit-beside-dates",
            "Times are dates, and a unit is given for them as well.",
            "Take `time_unit` out, or name the column without a unit.",
        ),
        error(
            "which-column",
            "It is not known which column is meant: the unit is not at the column that would be taken.",
            "Name the column in the scenario, or take the other one out of the file.",
        ),
    ],
};
