//! All channels of a problem, as the solver takes them from stage to stage.

use super::ends::End;
use super::junction::Junction;
use super::{Reach, larger_or_nan};
use crate::boundary::Channel;
use crate::solver::eulerian::open::Exchange;
use crate::solver::eulerian::state::State;
use crate::solver::eulerian::update::Stage;
use crate::solver::eulerian::walls::Walls;
use crate::solver::eulerian::{EulerianMethods, Scale};
use crate::solver::{ChannelSample, FlowProblem, Passage, Way};

/// All channels of a problem.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct Reaches {
    pub(super) reaches: Vec<Reach>,
}

impl Reaches {
    pub fn new(problem: &FlowProblem, state: &mut State, walls: &Walls) -> Self {
        let reach = |channel: &Channel| Reach::new(channel, problem, state, walls);
        let reaches = Reaches { reaches: problem.forcing.channels.iter().map(reach).collect() };
        for reach in &reaches.reaches {
            if let End::Joined(junction) = &reach.ends[1] {
                junction.find_steps(|strip| reach.last(strip).z, state);
            }
        }
        reaches
    }

    /// The cells (row, column) to which water may come from a channel.
    pub fn cells(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.junctions().flat_map(Junction::cells)
    }

    fn junctions(&self) -> impl Iterator<Item = &Junction> {
        self.reaches.iter().flat_map(|reach| &reach.ends).filter_map(|end| match end {
            End::Joined(junction) => Some(junction),
            End::Wall | End::Open(_) => None,
        })
    }

    /// Levels and velocities before a stage.
    pub fn evaluate_primitive(&mut self, before: Stage) {
        self.reaches.iter_mut().for_each(|reach| reach.evaluate_primitive(before));
    }

    /// Gradients of the channels, and of the cells that they meet.
    pub fn evaluate_gradients(&mut self, state: &mut State, scale: &Scale) {
        for reach in &mut self.reaches {
            reach.evaluate_gradients(state, scale);
            if let [_, End::Joined(junction)] = &reach.ends {
                junction.correct_gradients(reach, state, scale);
            }
        }
    }

    /// Fluxes of a stage of a step from one time to another (s), no more than the channels hold.
    pub fn pass(&mut self, state: &mut State, scale: &Scale, methods: EulerianMethods, stage: Stage, step: (f64, f64)) {
        for reach in &mut self.reaches {
            reach.pass(state, scale, methods, step);
            reach.limit_outflow(state, scale, stage, step.1 - step.0);
        }
    }

    /// Takes the step of a stage; returns the rates at which water comes in and leaves by the open ends (m³/s).
    pub fn apply(&mut self, state: &State, scale: &Scale, stage: Stage, time_step: f64) -> Exchange {
        let mut rates = Exchange::default();
        for reach in &mut self.reaches {
            reach.apply(state, scale, stage, time_step);
            let own = reach.book(0.5 * time_step);
            rates = Exchange { inflow: rates.inflow + own.inflow, outflow: rates.outflow + own.outflow };
        }
        rates
    }

    /// Inflow and outflow by each open end until a time (s).
    pub fn passages(&self, time: f64) -> impl Iterator<Item = Passage> + '_ {
        self.reaches.iter().enumerate().flat_map(move |(index, reach)| {
            let ends = [Way::FarEnd(index), Way::NearEnd(index)].into_iter().zip(&reach.ends).zip(reach.booked);
            ends.filter_map(move |((way, end), Exchange { inflow, outflow })| {
                Some(Passage { way, inflow, outflow, asked: end.condition()?.asked(time) })
            })
        })
    }

    /// Greatest signal speed and greatest speed of the water (m/s).
    pub fn fastest(&self, scale: &Scale) -> (f64, f64) {
        let all = self.reaches.iter().map(|reach| reach.fastest(scale));
        all.fold((0.0, 0.0), |(signal, flow), one| (larger_or_nan(signal, one.0), larger_or_nan(flow, one.1)))
    }

    /// The channel (from 1) with a greatest signal speed (m/s), and the distance (m) of its particle from the far end; for a failure.
    pub fn place_of(&self, signal: f64, scale: &Scale) -> Option<(usize, f64)> {
        let is_it = |speed: f64| speed.to_bits() == signal.to_bits() || (speed.is_nan() && signal.is_nan());
        (1..).zip(&self.reaches).find_map(|(number, reach)| {
            let particle =
                (0..reach.water.len()).find(|&i| reach.speeds(i, scale).is_some_and(|speeds| is_it(speeds.0)))?;
            Some((number, (particle as f64 + 0.5) * scale.spacing))
        })
    }

    /// The greatest signal speed (m/s) of what comes in by the open ends in a step from one time to another (s).
    pub fn fastest_inflow(&mut self, scale: &Scale, methods: EulerianMethods, step: (f64, f64)) -> f64 {
        self.reaches.iter_mut().map(|reach| reach.fastest_inflow(scale, methods, step)).fold(0.0, larger_or_nan)
    }

    /// Volume of all water (m³).
    pub fn volume(&self, spacing: f64) -> f64 {
        let of = |reach: &Reach| -> f64 {
            reach.water.iter().zip(&reach.ground.whole).map(|(water, wide)| water.depth * wide).sum()
        };
        self.reaches.iter().map(of).sum::<f64>() * spacing
    }

    /// Particles of all channels, and those of them whose water moves.
    pub fn particles(&self) -> (usize, usize) {
        let wet = |reach: &Reach| (0..reach.water.len()).filter(|&i| reach.is_wet(i)).count();
        let all = self.reaches.iter().map(|reach| (reach.water.len(), wet(reach)));
        all.fold((0, 0), |(number, moving), one| (number + one.0, moving + one.1))
    }

    /// The water of each channel, from its far end.
    pub fn samples(&self) -> Vec<Vec<ChannelSample>> {
        self.reaches.iter().map(Reach::samples).collect()
    }
}
