//! The interval of each raster, and whether they cover the run.

use std::ops::Range;

use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::math::readable;
use crate::prepare::rain::times::{SAME_TIME, Times};
use crate::prepare::tables::times::takes_little;
use crate::scenario::Stamp;

/// A step of time longer than so many of the usual ones is a gap.
const GAP: f64 = 1.5;

/// The interval of each raster (s).
pub fn intervals(times: &Times, stamp: Option<Stamp>, name: &str) -> Result<Vec<Range<f64>>, Problem> {
    let Times { times, bounds } = times;
    let sort = "sort the rasters by time, and take out what stands there twice";
    if let Some(pair) = times.windows(2).find(|pair| pair[1].partial_cmp(&pair[0]) != Some(std::cmp::Ordering::Greater))
    {
        let message = format!("the times of {name} do not rise: {} s stands behind {} s", pair[1], pair[0]);
        return Err(input_error("not-rising", message).with_remedy(sort));
    }
    if let Some(bounds) = bounds {
        if stamp.is_some() {
            let message = format!("the times of {name} have bounds, which say to which interval each belongs");
            return Err(input_error("stamp-beside-bounds", message).with_remedy("take `stamp` out"));
        }
        let empty = bounds.iter().find(|own| own.start.partial_cmp(&own.end) != Some(std::cmp::Ordering::Less));
        if let Some(Range { start: from, end: to }) = empty {
            let message = format!("the bounds of a time in {name} are {from} s and {to} s");
            return Err(
                input_error("bad-bounds", message).with_remedy("the second of two bounds must be the later one")
            );
        }
        let overlapping =
            |pair: &&[Range<f64>]| pair[1].start < pair[0].end - SAME_TIME * (pair[0].end - pair[0].start);
        if let Some(pair) = bounds.windows(2).find(overlapping) {
            let message = format!("two rasters of {name} hold at once, from {} s to {} s", pair[1].start, pair[0].end);
            return Err(input_error("bad-bounds", message).with_remedy(sort));
        }
        return Ok(bounds.clone());
    }
    let [first, .., last] = times[..] else {
        let message = format!("{name} has {} rasters, so that the interval of none is known", times.len());
        return Err(input_error("too-few-rasters", message)
            .with_remedy("give at least two, or take `raster` for rain that stays the same"));
    };
    let count = times.len();
    let mut edges = times.clone();
    match stamp.unwrap_or_default() {
        Stamp::Begin => edges.push(last + (last - times[count - 2])),
        Stamp::End => edges.insert(0, first - (times[1] - first)),
    }
    Ok(edges.windows(2).map(|pair| pair[0]..pair[1]).collect())
}

/// Whether the intervals hold from the start of the run to the end of the rain (s), and have no gap.
pub fn coverage(intervals: &[Range<f64>], until: f64, has_bounds: bool, name: &str) -> Vec<Problem> {
    let mut found = Vec::new();
    let (Some(first), Some(last)) = (intervals.first(), intervals.last()) else { return found };
    let slack = SAME_TIME * (last.end - last.start);
    if first.start > slack {
        let message = format!("the first raster of {name} begins {} s after the start of the run", first.start);
        let remedy = "give a raster from time 0 on, with zeros where it does not rain, or correct `start`, `stamp` or the unit of the times";
        found.push(input_error("series-starts-late", message).with_remedy(remedy));
    }
    if last.end < until - slack {
        let message = format!("the last raster of {name} ends at {} s, before the rain does at {until} s", last.end);
        let remedy = "give rasters up to the end, with zeros where it does not rain, say when the rain ends (`rain.duration`), shorten `time.end`, or correct the unit of the times";
        found.push(input_error("series-ends-early", message).with_remedy(remedy));
    }
    let mut lengths: Vec<f64> = intervals.iter().map(|one| one.end - one.start).collect();
    lengths.sort_by(f64::total_cmp);
    let usual = lengths[lengths.len() / 2];
    let matters = |one: &Range<f64>| one.end > 0.0 && one.start < until;
    let mut holes = intervals.windows(2).map(|pair| pair[0].end..pair[1].start);
    if let Some(hole) = holes.find(|hole| hole.end - hole.start > SAME_TIME * usual && matters(hole)) {
        let message = format!("{name} has no raster from {} s to {} s", hole.start, hole.end);
        found.push(input_error("series-gap", message).with_remedy("fill the gap, with zeros where it does not rain"));
    }
    let long: Vec<_> = intervals.iter().filter(|one| one.end - one.start > GAP * usual && matters(one)).collect();
    if let Some(Range { start: from, end: to }) = long.first().filter(|_| !has_bounds) {
        let others = if long.len() > 1 { format!(", and {} more", long.len() - 1) } else { String::new() };
        let message = format!("{name} has a gap from {from} s to {to} s, where a step of {usual} s is usual{others}");
        let problem = Problem::warning(ProblemKind::Input, "series-gap", "", message);
        found.push(
            problem.with_cause("one raster holds for all of that time").with_remedy("add the rasters that are missing"),
        );
    }
    found
}

/// Warns of a list of which the rain (until a time, s) takes so little that its times may have another unit.
pub fn far_beyond(intervals: &[Range<f64>], until: f64, name: &str) -> Option<Problem> {
    let last = intervals.last()?.end;
    let taken = intervals.partition_point(|interval| interval.start < until);
    takes_little(taken, until, last).then(|| {
        let message = format!(
            "of {name} the run takes {taken} of {} rasters: the rain ends at {} s, the last raster at {} s, {:.0} times as late",
            intervals.len(),
            readable(until),
            readable(last),
            last / until
        );
        input_warning("series-far-beyond", message)
            .with_cause("is the unit of its times right? it ends the name of their column")
            .with_remedy("nothing, if the run is to see so little of it; otherwise correct that name, or `time.end`")
    })
}
