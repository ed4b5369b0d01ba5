//! `resolution: auto`: the lengths of the cells that a wanted error asks for and that limits of time and memory allow.
//!
//! Two runs on coarse lattices go first, of spacings Δ and 2 Δ. What their maximum depths differ by tells the error of the finer one,
//! since errors at shores and fronts are of first order, and from there that of any spacing Δ_f:
//!
//! ```text
//! (M95)  e(Δ) = ⟨|d(2Δ) − d(Δ)|⟩ / (2^p − 1),  e(Δ_f) = e(Δ) Δ_f/Δ,  p = 1     mean over the cells with water in either run
//! ```
//!
//! Coarse cells stand where they do by (M94), as wide as e over the places where terrain hides nothing from them allows.

use super::by_level::costs;
use super::levels;
use super::looks::{Looks, Narrowest, look_twice, narrowest};
use crate::bed::BedParticles;
use crate::error::{Error, Problem, ProblemKind};
use crate::math::readable;
use crate::output::ChoiceRecord;
use crate::prepare::{BYTES_PER_CELL, Grain, Runnable, grain, prepare};
use crate::scenario::{Auto, Scenario};

/// Lengths that are tried, in pixels of the terrain: whole pixels, so that cells see each of them as a whole.
const MULTIPLES: [f64; 13] = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0, 96.0];
/// Wanted error of the maximum depth where the scenario wants nothing, over the mean maximum depth (decision 0059).
const WANTED: f64 = 0.05;
/// The finest cells where the scenario wants nothing, in pixels: what a raster shows is two of them wide or more.
const LEAST_PIXELS: f64 = 2.0;
/// The widest cells that an error lets be, in pixels: maps of wider ones would show less than the terrain does.
const MOST_PIXELS: f64 = 6.0;
/// Cells that are to lie across the shorter side of the terrain, of the coarsest level too.
const ACROSS: f64 = 6.0;
/// Cells that are to lie across an opening that water goes through.
const ACROSS_OPENING: f64 = 4.0;
/// Doublings from the finest to the coarsest level, at most.
const MOST_DOUBLINGS: i32 = 3;
/// Evaluations a CPU second, where the runs that went first are too short to tell.
const USUAL_RATE: f64 = 3e6;
/// The shortest CPU time (s) that tells a rate.
const TELLING: f64 = 0.3;
/// An evaluation on levels costs so many times one on a lattice alone (decision 0058: 1.4 to 2).
const DEARER: f64 = 1.7;
/// With levels a run has this share of the evaluations at least: below it no forecast is made to see that a budget is too small.
const LEAST_SHARE: f64 = 0.15;

/// A scenario with its lengths, and how they were chosen where it leaves them to the program.
#[derive(Debug)]
pub(super) struct Chosen {
    /// The scenario; without `auto`.
    pub scenario: Scenario,
    /// The choice.
    pub record: Option<ChoiceRecord>,
    /// Warnings.
    pub warnings: Vec<Problem>,
}

/// The scenario with lengths for a check, which runs nothing: those of the terrain's pixels.
pub(super) fn provisional(scenario: &Scenario) -> Scenario {
    if scenario.auto.is_none() {
        return scenario.clone();
    }
    // Where the terrain cannot be read, that is what the check reports.
    let Some(grain) = grain(scenario) else { return scenario.with_lengths(1.0, 1.0) };
    let fitting = |finest: &f64| memory(&grain, *finest, false) < scenario.limits.memory;
    let finest = lengths(&grain).find(fitting).unwrap_or(grain.pixel);
    scenario.with_lengths(finest, finest)
}

/// Chooses the lengths of a scenario that leaves them to the program.
///
/// # Errors
/// `Error::Problems` where no length keeps to the limits, and where the scenario would be refused at each.
pub(super) fn choose(scenario: &Scenario) -> Result<Chosen, Error> {
    let Some(auto) = scenario.auto else {
        return Ok(Chosen { scenario: scenario.clone(), record: None, warnings: Vec::new() });
    };
    if let Some(earlier) = &scenario.start.earlier {
        let message = "lengths are not chosen for a run that goes on from an earlier one";
        let problem = Problem::error(ProblemKind::Scenario, "method-combination", earlier.fields.key.clone(), message)
            .with_cause("its cells must fit those of that run")
            .with_remedy("write the length of that run, as `scenario.resolved.yaml` in its folder has it, or levels with that as `finest`")
            .with_place(earlier.fields.place.clone());
        return Err(Error::Problems(vec![problem]));
    }
    let Some(grain) = grain(scenario) else {
        // Reading the terrain for a length reports why.
        return Ok(Chosen { scenario: scenario.with_lengths(1.0, 1.0), record: None, warnings: Vec::new() });
    };
    let Some(looks) = look_twice(scenario, &grain, ACROSS) else {
        let pixel = grain.pixel;
        let because =
            vec![format!("no lattice coarser than the terrain's pixels of {} m holds the scene", readable(pixel))];
        let record =
            ChoiceRecord { finest_m: pixel, coarsest_m: pixel, pixel_m: pixel, because, ..ChoiceRecord::default() };
        return Ok(Chosen {
            scenario: scenario.with_lengths(pixel, pixel),
            record: Some(record),
            warnings: Vec::new(),
        });
    };
    Choice::new(scenario, auto, grain, looks).make()
}

/// The lengths (m) that are tried for the finest cells, the shortest first.
fn lengths(grain: &Grain) -> impl Iterator<Item = f64> + use<> {
    let Grain { pixel, shorter_side, .. } = *grain;
    let all = MULTIPLES.into_iter().map(move |multiple| multiple * pixel);
    all.filter(move |length| *length <= pixel || ACROSS * length <= shorter_side)
}

/// Memory (bytes) of a run with finest cells of an edge (m).
fn memory(grain: &Grain, finest: f64, has_levels: bool) -> f64 {
    // The rows of all levels are as long as those of the finest one.
    let stack = if has_levels { 2.0 } else { 1.0 };
    stack * BYTES_PER_CELL * grain.area / (finest * finest)
}

/// What a choice is made by.
struct Choice<'a> {
    scenario: &'a Scenario,
    auto: Auto,
    grain: Grain,
    looks: Looks,
    narrowest: Option<Narrowest>,
    /// Wanted error (m); none where limits alone are given.
    wanted: Option<f64>,
    /// Memory that the run may take (bytes).
    memory: f64,
}

/// Lengths (m), and what a run with them is expected to take.
#[derive(Clone, Copy, Debug)]
struct Offer {
    finest: f64,
    coarsest: f64,
    evaluations: f64,
    cpu: f64,
}

impl<'a> Choice<'a> {
    fn new(scenario: &'a Scenario, auto: Auto, grain: Grain, looks: Looks) -> Self {
        let has_limit = auto.cpu.is_some() || auto.memory.is_some();
        let usual = (!has_limit).then_some(WANTED * looks.mean_depth);
        let memory = auto.memory.unwrap_or(f64::INFINITY).min(scenario.limits.memory);
        let narrowest = narrowest(&looks.fine.setup);
        Choice { scenario, auto, grain, narrowest, wanted: auto.error.or(usual), memory, looks }
    }

    /// The expected mean error (m) of the maximum depth with cells of an edge (m).
    fn error_of(&self, finest: f64) -> f64 {
        self.looks.error * finest / self.looks.fine.spacing()
    }

    /// Whether cells of an edge (m) are too wide for an opening.
    fn is_wide_for_openings(&self, length: f64) -> bool {
        self.narrowest.is_some_and(|narrowest| ACROSS_OPENING * length > narrowest.width)
    }

    /// The longest length (m) that does for the error and for the openings.
    fn desired(&self) -> f64 {
        let pixel = self.grain.pixel;
        let Some(wanted) = self.wanted else { return pixel };
        let usual = if self.auto == Auto::default() { LEAST_PIXELS * pixel } else { pixel };
        let finest = if self.is_wide_for_openings(usual) { pixel } else { usual };
        let widest = (MOST_PIXELS * pixel).max(self.looks.fine.spacing());
        let does =
            |length: &f64| self.error_of(*length) <= wanted && !self.is_wide_for_openings(*length) && *length <= widest;
        lengths(&self.grain).filter(does).last().map_or(finest, |length| length.max(finest))
    }

    /// The longest length (m) of coarse cells above finest ones.
    fn coarsest_above(&self, finest: f64) -> f64 {
        let allowed = self.wanted.unwrap_or(0.0).max(self.error_of(finest));
        let does = |length: &f64| {
            let error = self.looks.error_of_flow * length / self.looks.fine.spacing();
            error <= allowed && ACROSS * length <= self.grain.shorter_side
        };
        (1..=MOST_DOUBLINGS).map(|k| finest * f64::from(k).exp2()).take_while(does).last().unwrap_or(finest)
    }

    /// Evaluations a CPU second on this machine.
    fn rate(&self) -> f64 {
        let look = &self.looks.fine;
        if look.cpu >= TELLING { look.scout.evaluations as f64 / look.cpu } else { USUAL_RATE }
    }

    /// Takes the longest length that does, or the next longer one within the limits.
    fn make(&self) -> Result<Chosen, Error> {
        let desired = self.desired();
        let mut beyond = None;
        for finest in lengths(&self.grain).filter(|length| *length >= desired) {
            if memory(&self.grain, finest, false) > self.memory {
                beyond = Some((finest, None));
                continue;
            }
            let look = &self.looks.fine;
            let uniform = look.scout.evaluations as f64 * (look.spacing() / finest).powi(3);
            if self.auto.cpu.is_some_and(|cpu| LEAST_SHARE * uniform / self.rate() > cpu) {
                beyond = Some((finest, Some(uniform / self.rate())));
                continue;
            }
            let offer = self.offer(finest)?;
            if self.auto.cpu.is_some_and(|cpu| offer.cpu > cpu) {
                beyond = Some((finest, Some(offer.cpu)));
                continue;
            }
            return Ok(self.chosen(offer, desired, beyond));
        }
        Err(Error::Problems(vec![self.too_small(beyond)]))
    }

    /// The cheaper of one lattice and levels.
    fn offer(&self, finest: f64) -> Result<Offer, Error> {
        let coarsest = self.coarsest_above(finest);
        let has_room = memory(&self.grain, finest, true) <= self.memory;
        let levels = (coarsest > finest && has_room).then(|| self.scenario.with_lengths(finest, coarsest));
        // A level on which the scene cannot be put is left out, with all others.
        let levels = levels.and_then(|scenario| Some((prepare(&scenario).into_runnable().ok()?, scenario)));
        let sum = |scenario: &Scenario, bed: &BedParticles| -> f64 {
            costs(scenario, bed, &self.looks.fine.scout).iter().map(|cost| cost.evaluations).sum()
        };
        let alone = |evaluations: f64| Offer { finest, coarsest: finest, evaluations, cpu: evaluations / self.rate() };
        let Some((Runnable { setup, .. }, scenario)) = levels else {
            let scenario = self.scenario.with_lengths(finest, finest);
            let Runnable { setup, .. } = prepare(&scenario).into_runnable()?;
            return Ok(alone(sum(&scenario, &setup.bed)));
        };
        let alone = alone(sum(&scenario, &setup.bed));
        let (setup, _) = levels::settle(&scenario, setup);
        let evaluations = sum(&scenario, &setup.bed);
        let on_levels = Offer { finest, coarsest, evaluations, cpu: DEARER * evaluations / self.rate() };
        Ok(if on_levels.cpu < alone.cpu { on_levels } else { alone })
    }

    fn chosen(&self, offer: Offer, desired: f64, beyond: Option<(f64, Option<f64>)>) -> Chosen {
        let Offer { finest, coarsest, evaluations, cpu } = offer;
        let error = self.error_of(finest);
        let record = ChoiceRecord {
            finest_m: finest,
            coarsest_m: coarsest,
            pixel_m: self.grain.pixel,
            looked_at_m: vec![self.looks.fine.spacing(), self.looks.coarse_spacing],
            wanted_error_m: self.wanted,
            expected_error_m: Some(error),
            mean_max_depth_m: Some(self.looks.mean_depth),
            expected_evaluations: Some(evaluations),
            expected_cpu_s: Some(cpu),
            because: self.because(offer, desired, beyond),
        };
        let misses = self.wanted.filter(|wanted| error > *wanted).map(|wanted| self.misses(wanted, finest, beyond));
        let scenario = self.scenario.with_lengths(finest, coarsest);
        Chosen { scenario, record: Some(record), warnings: misses.into_iter().collect() }
    }

    /// Why the lengths are what they are, in words.
    fn because(&self, offer: Offer, desired: f64, beyond: Option<(f64, Option<f64>)>) -> Vec<String> {
        let looks = &self.looks;
        let (finest, pixel) = (readable(offer.finest), readable(self.grain.pixel));
        let error = self.error_of(offer.finest);
        let mut because = vec![format!(
            "cells of {finest} m: expected mean error of the maximum depth {error:.3} m, {:.1} % of its mean of {:.2} m, by runs at {} m and {} m",
            100.0 * error / looks.mean_depth.max(f64::MIN_POSITIVE),
            looks.mean_depth,
            readable(looks.fine.spacing()),
            readable(looks.coarse_spacing)
        )];
        if let Some(wanted) = self.wanted {
            let is_met = if error <= wanted { "met" } else { "missed" };
            because.push(format!("the wanted error of {wanted:.3} m is {is_met}"));
        }
        if let Some(Narrowest { width, what }) = self.narrowest.filter(|_| desired <= offer.finest) {
            let across = width / offer.finest;
            because.push(format!("{what} of {} m has {across:.1} cells across", readable(width)));
        }
        if self.auto == Auto::default() && (offer.finest - LEAST_PIXELS * self.grain.pixel).abs() < 1e-6 * offer.finest
        {
            because.push(format!(
                "a raster of {pixel} m shows what is two pixels wide or more; `resolution: {{auto: {{error: 1 cm}}}}` takes its pixels"
            ));
        }
        match beyond {
            Some((length, Some(cpu))) => {
                because.push(format!("cells of {} m would take {} of CPU time", readable(length), in_minutes(cpu)))
            }
            Some((length, None)) => because.push(format!("cells of {} m would take more memory", readable(length))),
            None if offer.finest <= self.grain.pixel => {
                because.push(format!("the terrain has pixels of {pixel} m, and finer cells would show no more of it"));
            }
            None => {}
        }
        let coarsest = readable(offer.coarsest);
        because.push(if offer.coarsest > offer.finest {
            format!("up to {coarsest} m where terrain hides nothing from wider cells and the flow is smooth")
        } else {
            "one spacing everywhere: levels would cost as much, or lose more".to_owned()
        });
        because
    }

    /// The warning of an error that is not reached.
    fn misses(&self, wanted: f64, finest: f64, beyond: Option<(f64, Option<f64>)>) -> Problem {
        let resolution = &self.scenario.resolution;
        let (cause, remedy) = match beyond {
            Some(_) => {
                ("finer cells are beyond the limits of `resolution.auto`", "raise these limits, or accept the error")
            }
            None if finest > self.grain.pixel => (
                "a raster shows nothing narrower than two of its pixels",
                "take a finer terrain, accept the error, or write it as `resolution: {auto: {error: 10 cm}}`, which takes the pixels",
            ),
            None => (
                "finer cells show no more of the terrain than its pixels hold",
                "take a finer terrain, or accept the error",
            ),
        };
        let [wanted, error] = [wanted, self.error_of(finest)].map(|error| format!("{error:.3} m"));
        let message = format!(
            "the maximum depth is expected to be {error} off in the mean with cells of {} m; wanted are {wanted}",
            readable(finest)
        );
        Problem::warning(ProblemKind::Scenario, "auto-misses-error", resolution.key.clone(), message)
            .with_cause(cause)
            .with_remedy(remedy)
            .with_place(resolution.place.clone())
    }

    /// The problem of limits that no length keeps to.
    fn too_small(&self, beyond: Option<(f64, Option<f64>)>) -> Problem {
        let resolution = &self.scenario.resolution;
        let message = match beyond {
            Some((length, Some(cpu))) => {
                format!("even cells of {} m would take {} of CPU time", readable(length), in_minutes(cpu))
            }
            Some((length, None)) => format!("even cells of {} m would take more memory than allowed", readable(length)),
            None => "no length of cells fits the terrain".to_owned(),
        };
        Problem::error(ProblemKind::Limit, "auto-beyond-limit", resolution.key.clone(), message)
            .with_remedy("raise the limits of `resolution.auto`, or cut the terrain to the valley")
            .with_place(resolution.place.clone())
    }
}

/// A time (s) in words.
fn in_minutes(seconds: f64) -> String {
    if seconds < 120.0 { format!("{seconds:.0} s") } else { format!("{:.0} min", seconds / 60.0) }
}
