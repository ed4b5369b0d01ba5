//! Times of a NetCDF file of rain and their bounds, in seconds from the start of the run.
//!
//! Not here: the interval of each raster ([`crate::prepare::rain::series`]), and how dates and their units are written ([`crate::calendar`]).

use std::ops::Range;

use crate::calendar::cf::{TimeFault, TimeUnit, time_unit};
use crate::calendar::{DateFault, UtcTime};
use crate::error::{Problem, input_error};
use crate::geodata::cf_axes::text_of;

/// Share of a step by which rounding of the times in a file may miss the end of the rain, or two intervals each other.
pub const SAME_TIME: f64 = 1e-6;

/// Times of rasters, and the interval of each where the file has it.
pub struct Times {
    pub times: Vec<f64>,
    pub bounds: Option<Vec<Range<f64>>>,
}

/// The dates that the scenario has for the start of the run.
#[derive(Clone, Copy)]
pub struct Start {
    /// `rain.start`.
    pub own: Option<UtcTime>,
    /// `time.reference`.
    pub reference: Option<UtcTime>,
}

impl Start {
    /// The date of the start; none where the scenario has none, a problem where it has two.
    pub fn moment(self) -> Result<Option<UtcTime>, Problem> {
        if let (Some(own), Some(reference)) = (self.own, self.reference)
            && own != reference
        {
            let message = format!("the run starts at `{own}` (`rain.start`) and at `{reference}` (`time.reference`)");
            return Err(input_error("two-starts", message)
                .with_cause("both are the date of the start of the run in UTC")
                .with_remedy("take one of them out, or make them agree"));
        }
        Ok(self.own.or(self.reference))
    }
}

/// The problem of times that are not known, without its cause.
pub fn no_time(variable: &str, name: &str, cause: String) -> Problem {
    input_error("no-time", format!("the times of `{variable}` in {name} are not known")).with_cause(cause).with_remedy(
        "give the first dimension a variable of its name, with `units` such as `minutes since 2026-06-01 06:00:00`",
    )
}

/// The problem of a file that the library does not read.
pub fn not_netcdf(name: &str, cause: &netcdf::Error) -> Problem {
    input_error("not-a-netcdf", format!("{name} cannot be read as NetCDF"))
        .with_cause(cause.to_string())
        .with_remedy("copy or export the file again; `ncdump -h FILE` shows whether it is NetCDF")
}

fn bad_bounds(message: String) -> Problem {
    input_error("bad-bounds", message)
}

/// Why a variable has no unit of times: the cause, and what to do where it is known.
struct NoUnit {
    cause: String,
    remedy: Option<String>,
}

impl NoUnit {
    /// A problem with this cause, and this remedy in place of its own.
    fn explain(self, problem: Problem) -> Problem {
        let problem = problem.with_cause(self.cause);
        match self.remedy {
            Some(remedy) => problem.with_remedy(remedy),
            None => problem,
        }
    }
}

/// The unit of a variable of times; none where it has no `units`. Bounds count in the calendar of their times (CF 7.1).
fn unit_of(time: &netcdf::Variable, inherited: Option<String>) -> Result<Option<(TimeUnit, String)>, NoUnit> {
    let calendar = text_of(time, "calendar").or(inherited);
    let Some(written) = text_of(time, "units") else { return Ok(None) };
    match time_unit(&written, calendar.as_deref()) {
        Ok(unit) => Ok(Some((unit, written))),
        Err(fault) => Err(no_unit(fault, &time.name(), &written, &calendar.unwrap_or_default())),
    }
}

fn no_unit(fault: TimeFault, variable: &str, written: &str, calendar: &str) -> NoUnit {
    match fault {
        TimeFault::Unit => NoUnit { cause: format!("`{written}` is no unit of time with a date"), remedy: None },
        TimeFault::Calendar => NoUnit {
            cause: format!("the calendar `{calendar}` has other days than the Gregorian one"),
            remedy: Some("bring the times to the calendar `standard`; xarray does with `convert_calendar(\"standard\")`".to_owned()),
        },
        TimeFault::Date(fault) => NoUnit {
            cause: format!("the date of `{written}` is not known: {fault}"),
            remedy: (fault == DateFault::TooEarly).then(|| {
                format!(
                    "count the times from a later date: `cdo setreftime,1970-01-01,00:00:00 IN OUT`; or, where the Gregorian calendar is \
                     meant from the year 1 on, say so: `ncatted -a calendar,{variable},o,c,proleptic_gregorian FILE`"
                )
            }),
        },
    }
}

/// Refuses packed times: their bounds may be packed as they are, or not at all.
fn check_packing(variable: &netcdf::Variable, name: &str) -> Result<(), Problem> {
    let packing = variable.attributes().find(|attribute| ["scale_factor", "add_offset"].contains(&attribute.name()));
    packing.map_or(Ok(()), |packing| {
        let message = format!("`{}` of {name} is packed: it has `{}`", variable.name(), packing.name());
        Err(input_error("packed-times", message).with_remedy("unpack the file: `ncpdq -U IN OUT`"))
    })
}

/// The times of a variable of rain.
pub fn read(file: &netcdf::File, rain: &netcdf::Variable, start: Start, name: &str) -> Result<Times, Problem> {
    let unreadable = |cause: netcdf::Error| not_netcdf(name, &cause);
    let time_name = rain.dimensions()[0].name();
    let no_time = |cause: String| no_time(&rain.name(), name, cause);
    let no_unit = |why: NoUnit| why.explain(no_time(String::new()));
    let time = file.variable(&time_name).ok_or_else(|| no_time(format!("there is no variable `{time_name}`")))?;
    let unit = unit_of(&time, None).map_err(no_unit)?;
    let (unit, written) = unit.ok_or_else(|| no_time(format!("`{time_name}` has no `units`")))?;
    check_packing(&time, name)?;
    let start = match (unit.since, start.moment()?) {
        (None, _) if start.own.is_some() => {
            let message =
                format!("the times of {name} have no date (`{written}`): they count from the start of the run");
            return Err(input_error("start-without-date", message)
                .with_remedy("take `start` out, or add `since DATE` to the unit"));
        }
        (Some(_), None) => {
            let message =
                format!("the times of {name} are dates (`{written}`), and that of the start of the run is not known");
            return Err(input_error("no-start", message)
                .with_remedy("add `start: \"2026-06-01 06:00:00\"` to `rain`, or `time.reference` (both in UTC)"));
        }
        (_, start) => start,
    };
    let seconds = |numbers: Vec<f64>, unit: TimeUnit| -> Vec<f64> {
        let offset = unit.since.zip(start).map_or(0.0, |(since, start)| since.seconds_since(start));
        numbers.into_iter().map(|number| number * unit.factor + offset).collect()
    };
    let times = seconds(time.get_values::<f64, _>(..).map_err(unreadable)?, unit);
    let Some(bounds_name) = text_of(&time, "bounds") else { return Ok(Times { times, bounds: None }) };
    let (bounds, bounds_unit) = bounds_variable(file, &bounds_name, (&time, unit, &written), name)?;
    let ends = seconds(bounds.get_values::<f64, _>(..).map_err(unreadable)?, bounds_unit);
    let bounds: Vec<Range<f64>> = ends.chunks_exact(2).map(|pair| pair[0]..pair[1]).collect();
    check_inside(&times, &bounds, name)?;
    Ok(Times { times, bounds: Some(bounds) })
}

/// The bounds that a variable of times names, and their unit.
fn bounds_variable<'a>(
    file: &'a netcdf::File,
    bounds_name: &str,
    (time, unit, written): (&netcdf::Variable, TimeUnit, &str),
    name: &str,
) -> Result<(netcdf::Variable<'a>, TimeUnit), Problem> {
    let time_name = time.name();
    let remedy = format!("correct the bounds, or take them out: `ncatted -a bounds,{time_name},d,, FILE`");
    let bounds = file.variable(bounds_name).ok_or_else(|| {
        bad_bounds(format!("`{time_name}` of {name} names the bounds `{bounds_name}`, which it does not have"))
            .with_remedy(remedy.clone())
    })?;
    let shape: Vec<(String, usize)> = bounds.dimensions().iter().map(|side| (side.name(), side.len())).collect();
    if !matches!(&shape[..], [(of, _), (_, 2)] if *of == time_name) {
        let found = shape.iter().map(|(side, length)| format!("{side} = {length}")).collect::<Vec<_>>().join(", ");
        return Err(bad_bounds(format!("the bounds `{bounds_name}` of {name} have no two values for each time"))
            .with_cause(format!("their dimensions are ({found}) and not ({time_name}, 2)"))
            .with_remedy(remedy));
    }
    check_packing(&bounds, name)?;
    let own = unit_of(&bounds, text_of(time, "calendar")).map_err(|why| {
        why.explain(
            bad_bounds(format!("the bounds `{bounds_name}` of {name} cannot be read")).with_remedy(remedy.clone()),
        )
    })?;
    match own {
        None => Ok((bounds, unit)),
        Some((own, _)) if own.since.is_some() == unit.since.is_some() => Ok((bounds, own)),
        Some((_, own)) => {
            let message = format!("the bounds `{bounds_name}` of {name} say `{own}`, and the times `{written}`");
            Err(bad_bounds(message)
                .with_cause("one of the units has a date and the other has none")
                .with_remedy(remedy))
        }
    }
}

/// Refuses times that lie outside their bounds (s).
fn check_inside(times: &[f64], bounds: &[Range<f64>], name: &str) -> Result<(), Problem> {
    let is_outside = |(time, Range { start: from, end: to }): &(&f64, &Range<f64>)| {
        let slack = SAME_TIME * (to - from).abs();
        !(from.min(*to) - slack..=from.max(*to) + slack).contains(*time)
    };
    times.iter().zip(bounds).find(is_outside).map_or(Ok(()), |(time, Range { start: from, end: to })| {
        let message = format!("the time {time} s in {name} lies outside its bounds, {from} s to {to} s");
        Err(bad_bounds(message)
            .with_cause("times and bounds count from different dates or in different units, perhaps")
            .with_remedy("correct the bounds, or take out the attribute `bounds` of the times (`ncatted`)"))
    })
}
