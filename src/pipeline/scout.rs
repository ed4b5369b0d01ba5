//! What a run on one coarse lattice shows of the flood to come: where water is over time, its level, and how fast its signals are.

use std::time::Instant;

use crate::bed::BedParticles;
use crate::lattice::Lattice;
use crate::scenario::Scenario;
use crate::solver::{FlowSolver, StepChoice, StepLimit};

/// So many moments of a run are kept: a wave that crosses the terrain is seen in each tenth of its way several times.
const MOMENTS: f64 = 64.0;

/// The water of a cell at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WetCell {
    /// Its index.
    pub cell: usize,
    /// Level of the water (m).
    pub level: f64,
    /// Celerity plus speed (m/s).
    pub signal: f64,
}

/// A part of the run, by the water at its end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moment {
    /// How long it lasts (s).
    pub duration: f64,
    /// The greatest signal speed (m/s) that a step within it was chosen by; 0 where none was.
    pub fastest: f64,
    /// The cells with water.
    pub wet: Vec<WetCell>,
}

/// The record of a run on one lattice.
#[derive(Clone, Debug)]
pub(super) struct Scout {
    /// The lattice.
    pub lattice: Lattice,
    /// The parts of the run, in order.
    pub moments: Vec<Moment>,
    /// Evaluations of the rates of one particle.
    pub evaluations: u64,
    /// Wall-clock time (s).
    pub seconds: f64,
    bed: Vec<f64>,
    start: Instant,
    began: f64,
    interval: f64,
    fastest: f64,
    reach: f64,
    gravity: f64,
    dry_depth: f64,
}

impl Scout {
    /// The record of a run that is about to begin.
    pub fn new(scenario: &Scenario, bed: &BedParticles) -> Self {
        let lattice = bed.lattice.clone();
        let numerics = &scenario.numerics;
        Scout {
            moments: Vec::new(),
            evaluations: 0,
            seconds: 0.0,
            bed: bed.elevation.clone(),
            start: Instant::now(),
            began: 0.0,
            interval: scenario.end_time / MOMENTS,
            fastest: 0.0,
            reach: numerics.cfl * lattice.spacing,
            gravity: numerics.gravity,
            dry_depth: numerics.dry_depth,
            lattice,
        }
    }

    /// Takes in a step that was done.
    pub fn follow(&mut self, step: &StepChoice, solver: &mut dyn FlowSolver) {
        if step.limit == StepLimit::Courant {
            self.fastest = self.fastest.max(self.reach / step.time_step);
        }
        self.evaluations = solver.particle_evaluations();
        self.seconds = self.start.elapsed().as_secs_f64();
        let time = solver.time();
        if time < self.began + self.interval && step.limit != StepLimit::EndOfRun {
            return;
        }
        let mut wet = Vec::new();
        for (cell, water) in solver.water().cells().enumerate() {
            if water.depth > self.dry_depth {
                let speed = water.discharge_x.hypot(water.discharge_y) / water.depth;
                let signal = (self.gravity * water.depth).sqrt() + speed;
                wet.push(WetCell { cell, level: self.bed[cell] + water.depth, signal });
            }
        }
        self.moments.push(Moment { duration: time - self.began, fastest: self.fastest, wet });
        self.began = time;
        self.fastest = 0.0;
    }
}
