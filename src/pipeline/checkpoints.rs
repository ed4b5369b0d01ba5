//! Checkpoints: what a run needs to go on to the same bytes, and when it is kept.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::Run;
use super::cores::Core;
use super::origin::Origin;
use super::progress::StepStatistics;
use super::recorders::Recorders;
use super::second_run::SecondRun;
use crate::error::{Error, say};
use crate::output::{CheckpointRecord, RunFolder, write_checkpoint};
use crate::scenario::{Part, Scenario};

/// What was decided before the first step, and can't be decided again to the same end.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(super) struct Decided {
    /// The finest and the coarsest length (m).
    lengths: (f64, f64),
    /// The part of the terrain that is read.
    part: Option<Part>,
}

impl Decided {
    fn of(scenario: &Scenario) -> Self {
        let finest = scenario.resolution.value;
        let coarsest = scenario.levels.as_ref().map_or(finest, |levels| levels.coarsest.value);
        Decided { lengths: (finest, coarsest), part: scenario.reading.part }
    }

    /// The scenario as it was decided.
    pub fn apply(self, scenario: &Scenario) -> Scenario {
        let (finest, coarsest) = self.lengths;
        let mut scenario =
            if scenario.auto.is_some() { scenario.with_lengths(finest, coarsest) } else { scenario.clone() };
        scenario.reading.part = self.part;
        scenario
    }
}

/// What a run did before it went on.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(super) struct Before {
    /// Particles with water at the start.
    pub particles: Option<usize>,
    /// Wall-clock and CPU time (s).
    pub wall_s: f64,
    pub cpu_s: f64,
    pub checkpoints: CheckpointRecord,
    /// The simulated times (s) from which it went on.
    pub resumed_at_s: Vec<f64>,
}

/// All that changes in a run, as it is written.
#[derive(Serialize)]
struct Saved<'a> {
    decided: Decided,
    before: &'a Before,
    steps: &'a StepStatistics,
    second: &'a Option<SecondRun>,
    recorders: Option<&'a Recorders>,
    core: &'a Core,
}

/// The same, as it is read.
#[derive(Deserialize)]
pub(super) struct State {
    pub decided: Decided,
    pub before: Before,
    pub steps: StepStatistics,
    pub second: Option<SecondRun>,
    pub recorders: Option<Recorders>,
    pub core: Core,
}

impl State {
    /// That of a run which has taken no step.
    pub fn at_start(scenario: &Scenario, core: Core) -> Self {
        State {
            decided: Decided::of(scenario),
            before: Before::default(),
            steps: StepStatistics::default(),
            second: None,
            recorders: None,
            core,
        }
    }
}

/// From this interval (s) on, the usual one, the next checkpoint comes after so many times what the last one took, at least: they take 2 % of a run.
/// Who asks for a shorter one gets it.
const USUAL: f64 = 600.0;
const PER_COST: f64 = 50.0;

/// When the checkpoints of a run are written.
pub(super) struct Checkpoints {
    /// Time between two of them (s); none for none.
    every: Option<f64>,
    last: Instant,
    /// How long the last one took (s).
    cost: f64,
    has_failed: bool,
}

impl Checkpoints {
    pub fn new(every: Option<f64>) -> Self {
        Checkpoints { every, last: Instant::now(), cost: 0.0, has_failed: false }
    }

    pub fn are_kept(&self) -> bool {
        self.every.is_some()
    }

    pub fn is_due(&self) -> bool {
        let least = |every: f64| if every < USUAL { every } else { every.max(PER_COST * self.cost) };
        self.every.is_some_and(|every| self.last.elapsed().as_secs_f64() >= least(every))
    }
}

/// Writes a checkpoint without a state: a run that is cut off before its first one begins again.
pub(super) fn keep_origin(folder: &RunFolder, origin: &Origin) -> Result<(), Error> {
    write_checkpoint(folder, origin, &None::<Saved<'_>>).map(|_| ())
}

impl Run<'_> {
    /// Writes a checkpoint between two steps, where they are kept. One that can't be written costs the run nothing: the one before stays.
    pub(super) fn keep(&mut self, core: &mut Core, recorders: &mut Recorders, steps: &StepStatistics) {
        if !self.checkpoints.are_kept() {
            return;
        }
        let begin = Instant::now();
        self.origin.simulated_s = core.flow().time();
        let mut before = self.before.clone();
        (before.wall_s, before.cpu_s) = self.clock.so_far((before.wall_s, before.cpu_s));
        let decided = Decided::of(self.scenario);
        let second = &self.second;
        let written = recorders.settle().and_then(|()| {
            let saved = Saved { decided, before: &before, steps, second, recorders: Some(recorders), core };
            write_checkpoint(&self.folder, &self.origin, &Some(saved))
        });
        self.checkpoints.last = Instant::now();
        self.checkpoints.cost = begin.elapsed().as_secs_f64();
        match written {
            Ok(bytes) => {
                let record = &mut self.before.checkpoints;
                record.count += 1;
                record.wall_s += self.checkpoints.cost;
                record.bytes = bytes;
            }
            Err(error) => {
                if !std::mem::replace(&mut self.checkpoints.has_failed, true) {
                    say(format!("warning: no checkpoint at t = {:.1} s: {error}", self.origin.simulated_s));
                }
            }
        }
    }
}
