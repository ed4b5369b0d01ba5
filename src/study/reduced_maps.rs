//! The maps of a reduced study: probabilities, quantiles, envelopes, increments.

use super::stack::{Measure, Stack};
use crate::error::Error;
use crate::math::readable;
use crate::output::{MapClass, MapKind, MapVariable, hazard_classes, threshold_name};

const P5: Measure = Measure::Quantile(0.05);
const P50: Measure = Measure::Quantile(0.5);
const P95: Measure = Measure::Quantile(0.95);

/// A map over the runs.
pub(super) struct ReducedMap {
    pub name: String,
    pub long_name: String,
    pub units: &'static str,
    pub kind: MapKind,
    pub comment: String,
    /// The fill value where there is none.
    pub values: Vec<f32>,
}

impl ReducedMap {
    /// The map as a variable of files.
    pub fn variable(&self) -> MapVariable<'_> {
        let classes: Vec<MapClass> = if self.kind == MapKind::Class { hazard_classes() } else { Vec::new() };
        MapVariable {
            name: self.name.clone(),
            long_name: self.long_name.clone(),
            standard_name: None,
            units: self.units,
            cell_methods: "",
            comment: self.comment.clone(),
            threshold: None,
            kind: self.kind,
            classes,
            values: &self.values,
        }
    }
}

/// A measure with the name and the words of its map.
type Wanted = (Measure, String, String, MapKind, &'static str, String);

fn wanted(measure: Measure, name: &str, long_name: &str, kind: MapKind, units: &'static str, comment: &str) -> Wanted {
    (measure, name.to_owned(), long_name.to_owned(), kind, units, comment.to_owned())
}

/// The quantiles of a quantity.
fn quantiles(name: &str, long_name: &str, kind: MapKind, units: &'static str, comment: &str) -> Vec<Wanted> {
    let one = |(measure, percent): (Measure, u8)| {
        let long_name = format!("{long_name} that {percent} % of the runs do not exceed");
        wanted(measure, &format!("{name}_p{percent:02}"), &long_name, kind, units, comment)
    };
    [(P5, 5), (P50, 50), (P95, 95)].map(one).into()
}

/// Maps of the measures of one map of the runs.
fn made(wanted: Vec<Wanted>, values: Vec<Vec<f32>>) -> impl Iterator<Item = ReducedMap> {
    wanted.into_iter().zip(values).map(|((_, name, long_name, kind, units, comment), values)| ReducedMap {
        name,
        long_name,
        units,
        kind,
        comment,
        values,
    })
}

/// All maps over some runs. A cell counts as flooded from a maximum depth of `flooded_from` (m) on.
pub(super) fn maps_of(
    stack: &Stack,
    runs: &[usize],
    flooded_from: f64,
    depths: &[f64],
) -> Result<Vec<ReducedMap>, Error> {
    let mut maps = Vec::new();
    // Of each map of the runs: the value of a run that has none, and what is made of it.
    let all = [
        ("max_depth", 0.0, of_depth(flooded_from, depths)),
        ("arrival_time", f32::INFINITY, of_arrival()),
        ("max_speed", 0.0, of_speed()),
        ("hazard_class", 0.0, of_hazard()),
    ];
    for (map, missing, wanted) in all {
        let measures: Vec<Measure> = wanted.iter().map(|wanted| wanted.0).collect();
        maps.extend(made(wanted, stack.measures(map, runs, missing, &measures)?));
    }
    Ok(maps)
}

/// What maxima of a run that stays dry count as.
const DRY: &str = "of all runs; 0 where a run is dry";

fn of_depth(flooded_from: f64, depths: &[f64]) -> Vec<Wanted> {
    let (share, metres) = (MapKind::Probability, MapKind::Depth);
    let flooded = format!("share of the runs with a maximum depth of {flooded_from} m or more");
    let measure = Measure::AtLeast(flooded_from);
    let mut all = vec![wanted(measure, "probability_flooded", "probability of inundation", share, "1", &flooded)];
    for &depth in depths {
        let (name, measure) = (format!("probability_depth_{}", threshold_name(depth)), Measure::AtLeast(depth));
        let long_name = format!("probability of a depth of {} m or more", readable(depth));
        all.push(wanted(measure, &name, &long_name, share, "1", "share of the runs"));
    }
    all.extend(quantiles("max_depth", "maximum depth", metres, "m", DRY));
    let greatest = "greatest maximum depth of all runs";
    all.push(wanted(Measure::Greatest, "max_depth_envelope", greatest, metres, "m", ""));
    all
}

fn of_arrival() -> Vec<Wanted> {
    let never = "of all runs, as seconds since the start; no value where the water has not come in so many of them";
    let mut all = quantiles("arrival_time", "time of arrival", MapKind::Time, "s", never);
    let comment = "P95 less P5; no value where the water comes in less than 95 % of the runs";
    let (between, spread) = (Measure::Between(0.05, 0.95), "spread of the time of arrival");
    all.push(wanted(between, "arrival_time_spread", spread, MapKind::Time, "s", comment));
    let earliest = "earliest arrival of all runs";
    all.push(wanted(Measure::Least, "arrival_time_envelope", earliest, MapKind::Time, "s", ""));
    all
}

fn of_speed() -> Vec<Wanted> {
    let mut all = quantiles("max_speed", "maximum speed", MapKind::Speed, "m s-1", DRY);
    let greatest = "greatest maximum speed of all runs";
    all.push(wanted(Measure::Greatest, "max_speed_envelope", greatest, MapKind::Speed, "m s-1", ""));
    all
}

fn of_hazard() -> Vec<Wanted> {
    let of_class = |class: u8| {
        let (name, least) = (format!("probability_hazard_h{class}"), Measure::AtLeast(f64::from(class)));
        let long_name = format!("probability of hazard class H{class} or worse");
        wanted(least, &name, &long_name, MapKind::Probability, "1", "share of the runs; AIDR classes")
    };
    let worst =
        wanted(Measure::Greatest, "hazard_class_envelope", "worst hazard class of all runs", MapKind::Class, "1", "");
    (2..=6).map(of_class).chain([worst]).collect()
}

/// Increments (m, m/s) that are none but the difference of two computations.
const LEAST_INCREMENT: f64 = 0.01;

/// What the first run of each pair has more than the second.
pub(super) fn increment_maps(stack: &Stack, pairs: &[(usize, usize)]) -> Result<Vec<ReducedMap>, Error> {
    let mut maps = Vec::new();
    let comment = "first less second variant of each case; 0 depth and speed where a run is dry";
    for (map, long_name, units) in
        [("max_depth", "increment of maximum depth", "m"), ("max_speed", "increment of maximum speed", "m s-1")]
    {
        let mut all = quantiles(&format!("{map}_increment"), long_name, MapKind::Difference, units, comment);
        let probability = format!("probability of an {long_name} above {LEAST_INCREMENT} {units}");
        all.push(wanted(
            Measure::Above(LEAST_INCREMENT),
            &format!("probability_{map}_increment"),
            &probability,
            MapKind::Probability,
            "1",
            comment,
        ));
        let measures: Vec<Measure> = all.iter().map(|wanted| wanted.0).collect();
        maps.extend(made(all, stack.increments(map, pairs, &measures)?));
    }
    Ok(maps)
}
