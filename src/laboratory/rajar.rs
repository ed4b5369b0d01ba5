//! Rajar's channels: a dam break in a straight channel that widens or narrows, in two dimensions, in one, and coupled (`Dzebo2013`).
//!
//! There are no measurements here, and neither the lengths nor the roughness of the experiment: the coupled run is held against the one that
//! is two-dimensional throughout, along the axis of the channel, and so are the costs of their steps. A reach of one dimension has no depth on
//! its axis but that of its whole width: the lower reach alone is held against the mean over the width, too.

use super::Finding;
use super::gauges::Run;
use crate::error::Error;
use crate::maps::{GaugeLine, GaugePanel, PanelAxis};
use crate::pipeline::clock::processor_seconds;
use crate::pipeline::{cores, flow_problem, thread_pool};
use crate::prepare::{Scene, prepare};
use crate::scenario::{Scenario, load};
use crate::solver::ChannelSample;

/// Length of the channel and place of the dam (m from the far end).
const LENGTH: f64 = 16.0;
const DAM: f64 = 6.0;
/// The axis (m from the southern edge).
const AXIS: f64 = 0.6;
/// The slope of the bed.
const SLOPE: f64 = 0.000_87;
/// Interval of the profiles (s); those at full seconds are compared.
const EVERY: f64 = 0.1;
/// Places of the panels (m from the far end): before and behind the change of width at 10 m, the last one in the lower reach.
const STATIONS: [f64; 4] = [8.0, 9.5, 11.5, 14.5];
/// What the coupled run may be off, and the least share of the costs that it must save.
const BARS: (f64, f64) = (0.05, 0.40);

/// One of the channels with the water of its two experiments: depths behind and before the dam (m), 0 where dry.
pub(super) struct Flume {
    /// `a` or `b`, as in the names of the scenarios.
    pub letter: &'static str,
    /// The depths.
    pub depths: [(f64, f64); 2],
}

/// Channel A, with the deeper reservoirs, and channel B.
pub(super) const A: Flume = Flume { letter: "a", depths: [(0.389, 0.0), (0.437, 0.070)] };
pub(super) const B: Flume = Flume { letter: "b", depths: [(0.292, 0.0), (0.307, 0.058)] };

/// What a run made of the channel.
struct Followed {
    /// Processor time of its steps (s).
    cpu_s: f64,
    /// Places along the axis (m from the far end).
    places: Vec<f64>,
    /// Depths (m) at the places, every tenth of a second: on the axis, and their means over the width.
    profiles: Vec<[Vec<f64>; 2]>,
    /// The place (m) from which on there is a lower reach of one dimension.
    lower_reach: Option<f64>,
}

/// Which depths of a profile.
#[derive(Clone, Copy)]
enum Depths {
    OnTheAxis = 0,
    OverTheWidth = 1,
}

/// Compares the models at the depths of both experiments.
pub(super) fn compare(run: &Run, flume: &Flume) -> Result<Finding, String> {
    let (mut worst, mut least_saved) = (0.0_f64, f64::INFINITY);
    let (mut notes, mut panels) = (Vec::new(), Vec::new());
    for depths in flume.depths {
        let follow_one = |model: &str, water: Vec<String>| {
            let scenario = run.scenarios.join(format!("laboratory/rajar_{}{model}.yaml", flume.letter));
            let overrides: Vec<String> = run.overrides.iter().cloned().chain(water).collect();
            load(&scenario, &overrides).and_then(|loaded| follow(&loaded.scenario)).map_err(|error| error.to_string())
        };
        let plane = follow_one("", flume.water_of_the_plane(depths))?;
        let coupled = follow_one("_coupled", flume.water_of_the_coupled(depths))?;
        let channel = follow_one("_channel", flume.water_of_the_channel(depths))?;
        let below_the_dam = (DAM, Depths::OnTheAxis);
        let (off, off_channel) =
            (plane.difference(&coupled, below_the_dam)?, plane.difference(&channel, below_the_dam)?);
        let lower = coupled.lower_reach.ok_or("the coupled run has no lower reach")?;
        let in_reach = |depths| plane.difference(&coupled, (lower, depths));
        let (reach, reach_axis) = (in_reach(Depths::OverTheWidth)?, in_reach(Depths::OnTheAxis)?);
        let saved = |other: &Followed| 1.0 - other.cpu_s / plane.cpu_s;
        worst = worst.max(off.mean).max(reach.mean);
        least_saved = least_saved.min(saved(&coupled));
        notes.push(format!(
            "{:.1} cm over {:.1} cm: coupled {} off, its lower reach {:.2} % off the mean over the width and {:.1} % off the axis, {:.0} % saved of {:.2} s; one dimension {} off, {:.0} % saved",
            100.0 * depths.0,
            100.0 * depths.1,
            off.in_words(),
            100.0 * reach.mean,
            100.0 * reach_axis.mean,
            100.0 * saved(&coupled),
            plane.cpu_s,
            off_channel.in_words(),
            100.0 * saved(&channel)
        ));
        for station in STATIONS {
            let line = |name: &str, followed: &Followed| GaugeLine {
                name: format!("{name}, {}", run.resolution()),
                points: followed.at(station),
            };
            let computed = vec![line("2-D", &plane), line("coupled", &coupled), line("1-D", &channel)];
            let title = format!("{station} m, {:.1} cm over {:.1} cm", 100.0 * depths.0, 100.0 * depths.1);
            panels.push(GaugePanel { title, axis: PanelAxis::Time, measured: Vec::new(), computed });
        }
    }
    Ok(Finding {
        norm: "mean_depth",
        error: Some(worst),
        is_met: Some(worst <= BARS.0 && least_saved >= BARS.1),
        note: format!(
            "difference from two dimensions along the axis below the dam, by the depth there, and in the lower reach alone from the mean over the width, the worst of 1 to 8 s: {}",
            notes.join("; ")
        ),
        panels,
    })
}

impl Flume {
    /// Levels (m) behind and before the dam, whose foot the depths count from.
    fn levels(&self, (deep, shallow): (f64, f64)) -> (f64, Option<f64>) {
        let foot = SLOPE * (LENGTH - DAM);
        (foot + deep, (shallow > 0.0).then_some(foot + shallow))
    }

    fn water_of_the_plane(&self, depths: (f64, f64)) -> Vec<String> {
        let (high, low) = self.levels(depths);
        let tail = low.map(|low| format!(", {{water: rajar_{}_tail.geojson, level: {low} m}}", self.letter));
        vec![format!("initial=[{{reservoir: rajar_reservoir.geojson, level: {high} m}}{}]", tail.unwrap_or_default())]
    }

    fn water_of_the_coupled(&self, depths: (f64, f64)) -> Vec<String> {
        let low = self.levels(depths).1;
        let tail = low.map(|low| {
            let polygon = format!("rajar_{}_tail_middle.geojson", self.letter);
            [
                format!("initial=[{{water: {polygon}, level: {low} m}}]"),
                format!("channels[1].water=[{{level: {low} m}}]"),
            ]
        });
        self.water_of_the_channel(depths).into_iter().chain(tail.into_iter().flatten()).collect()
    }

    fn water_of_the_channel(&self, depths: (f64, f64)) -> Vec<String> {
        let (high, low) = self.levels(depths);
        let tail = low.map_or(String::new(), |low| format!(", {{level: {low} m, from: {DAM} m}}"));
        vec![format!("channels[0].water=[{{level: {high} m, from: 0 m, to: {DAM} m}}{tail}]")]
    }
}

/// Takes the steps of a scenario on one thread and reads the axis.
fn follow(scenario: &Scenario) -> Result<Followed, Error> {
    let setup = prepare(scenario).into_runnable()?.setup;
    let axis = Axis::new(&setup.scene, &setup.bed.elevation);
    let problem = flow_problem(scenario, &setup, setup.bed.clone());
    let mut solver = cores::build(scenario, problem, Vec::new(), &[]);
    let take_steps = || -> Result<Followed, Error> {
        let mut followed =
            Followed { cpu_s: 0.0, places: axis.places(), profiles: Vec::new(), lower_reach: axis.lower_reach };
        let profiles = (scenario.end_time / EVERY).round() as usize;
        for profile in 0..=profiles {
            let until = profile as f64 * EVERY;
            let before = processor_seconds();
            while solver.time() < until - 1e-9 {
                let choice = solver.choose_step();
                solver.advance(choice.time_step.min(until - solver.time())).map_err(Error::Numerical)?;
            }
            followed.cpu_s += processor_seconds() - before;
            let channels = solver.channels();
            followed.profiles.push(axis.depths(&solver.water().depths(), &channels));
        }
        Ok(followed)
    };
    thread_pool(Some(1))?.install(take_steps)
}

/// Where a depth along the axis comes from.
enum Origin {
    /// Cells of the lattice on both sides of the axis, and all of the width.
    Plane([usize; 2], Vec<usize>),
    /// A particle of a channel.
    Channel(usize, usize),
}

/// The places along the axis, from the far end.
struct Axis {
    origins: Vec<(f64, Origin)>,
    lower_reach: Option<f64>,
}

impl Axis {
    /// Of the whole channel: what the plane does not hold the channels do.
    fn new(scene: &Scene, bed: &[f64]) -> Axis {
        let mut origins = Vec::new();
        let mut lower_reach: Option<f64> = None;
        for (index, channel) in scene.channels.iter().enumerate() {
            for (particle, distance) in channel.distance.iter().enumerate() {
                // The lower reach joins the plane by the end that lies upstream.
                let is_lower = channel.id == "lower";
                let place = if is_lower { LENGTH - distance } else { *distance };
                if is_lower {
                    lower_reach = Some(lower_reach.map_or(place, |first| first.min(place)));
                }
                origins.push((place, Origin::Channel(index, particle)));
            }
        }
        let lattice = &scene.lattice;
        for (cell, elevation) in bed.iter().enumerate() {
            let place = lattice.to_map(lattice.centre(cell));
            if !elevation.is_nan() && place.y > AXIS && place.y < AXIS + lattice.spacing {
                let column = (cell % lattice.columns..bed.len()).step_by(lattice.columns);
                let width = column.filter(|&other| !bed[other].is_nan()).collect();
                origins.push((place.x, Origin::Plane([cell, cell - lattice.columns], width)));
            }
        }
        origins.sort_by(|a, b| a.0.total_cmp(&b.0));
        Axis { origins, lower_reach }
    }

    fn places(&self) -> Vec<f64> {
        self.origins.iter().map(|origin| origin.0).collect()
    }

    /// Depths (m) on the axis, and means over the width.
    fn depths(&self, plane: &[f64], channels: &[Vec<ChannelSample>]) -> [Vec<f64>; 2] {
        let mean = |cells: &[usize]| cells.iter().map(|&cell| plane[cell]).sum::<f64>() / cells.len() as f64;
        let depth = |(_, origin): &(f64, Origin)| match origin {
            Origin::Plane(axis, width) => (mean(axis), mean(width)),
            Origin::Channel(channel, particle) => {
                let depth = channels[*channel][*particle].depth;
                (depth, depth)
            }
        };
        let (axis, width) = self.origins.iter().map(depth).unzip();
        [axis, width]
    }
}

/// Differences between two runs: by the sum of the depths there, and the largest one by the largest depth.
struct Difference {
    mean: f64,
    largest: f64,
}

impl Difference {
    fn in_words(&self) -> String {
        format!("{:.2} % (at one place {:.0} %)", 100.0 * self.mean, 100.0 * self.largest)
    }
}

impl Followed {
    /// The worst difference of another run at a full second, from a place (m) on.
    fn difference(&self, other: &Followed, (from, depths): (f64, Depths)) -> Result<Difference, String> {
        let is_same = self.places.len() == other.places.len()
            && self.places.iter().zip(&other.places).all(|(a, b)| (a - b).abs() < 1e-6);
        if !is_same {
            return Err(format!("{} places along the axis against {}", self.places.len(), other.places.len()));
        }
        let each_second = (1.0 / EVERY).round() as usize;
        let mut worst = Difference { mean: 0.0, largest: 0.0 };
        let below = self.places.partition_point(|place| *place < from - 1e-6);
        for (a, b) in self.profiles.iter().zip(&other.profiles).step_by(each_second).skip(1) {
            let (a, b) = (&a[depths as usize][below..], &b[depths as usize][below..]);
            let off = || a.iter().zip(b).map(|(a, b)| (a - b).abs());
            worst.mean = worst.mean.max(off().sum::<f64>() / a.iter().sum::<f64>());
            let deepest = a.iter().copied().fold(0.0, f64::max);
            worst.largest = worst.largest.max(off().fold(0.0, f64::max) / deepest);
        }
        Ok(worst)
    }

    /// Time (s) and depth (m) at the place nearest to one (m from the far end).
    fn at(&self, station: f64) -> Vec<(f64, f64)> {
        let distance = |index: &usize| (self.places[*index] - station).abs();
        let nearest = (0..self.places.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let Some(nearest) = nearest else { return Vec::new() };
        self.profiles.iter().enumerate().map(|(number, [axis, _])| (number as f64 * EVERY, axis[nearest])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_those_of_the_worst_second() {
        let followed = |depth: f64| Followed {
            cpu_s: 1.0,
            places: vec![1.0, 7.0],
            profiles: (0..=20).map(|k| [vec![1.0, if k == 10 { depth } else { 0.5 }], vec![1.0, 2.0]]).collect(),
            lower_reach: None,
        };
        let (a, b) = (followed(0.5), followed(0.8));
        let off = |from, depths| a.difference(&b, (from, depths)).unwrap();
        let below = off(DAM, Depths::OnTheAxis);
        assert!((below.mean - 0.3 / 0.5).abs() < 1e-12 && (below.largest - 0.3 / 0.5).abs() < 1e-12);
        assert!((off(1.0, Depths::OnTheAxis).mean - 0.3 / 1.5).abs() < 1e-12);
        assert!(off(DAM, Depths::OverTheWidth).mean < 1e-12);
        assert!((b.at(6.0)[10].1 - 0.8).abs() < 1e-12 && b.at(6.0).len() == 21);
        let short = Followed { places: vec![1.0], ..followed(0.5) };
        assert!(a.difference(&short, (DAM, Depths::OnTheAxis)).is_err());
    }

    #[test]
    fn the_dry_experiments_have_water_behind_the_dam_alone() {
        assert_eq!(
            A.water_of_the_plane((0.4, 0.0)),
            ["initial=[{reservoir: rajar_reservoir.geojson, level: 0.4087 m}]"]
        );
        assert_eq!(A.water_of_the_coupled((0.4, 0.0)).len(), 1);
        assert_eq!(B.water_of_the_coupled((0.4, 0.1)).len(), 3);
    }
}
