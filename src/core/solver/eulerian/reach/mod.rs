//! Channels of one dimension: a row of particles like those of the plane, each as wide as its cross-section.
//!
//! Area A = Σ_k w_k d_k of the strips k of a section and discharge Q = u A change by the faces of its two pairs (theory (M50) to
//! (M53)), r the face on the side of the near end, l that on the side of the far end:
//!
//! ```text
//! dA_i/dt = − (Q_r − Q_l)/Δ                 Q_f = Σ_k w_fk F_d
//! dQ_i/dt = − (Φ_r − Φ_l)/Δ                 Φ_f = Σ_k w_fk [F_n − g d_f²/2 ± g (d_i + d_iR) a/2]
//! ```
//!
//! with fluxes and states of (M19) to (M21), (M23) and (M31): a strip of all particles is a row on which the passes of [`super::gradient`] and
//! [`super::faces`] run. What the brackets leave of two faces of different width is the pressure of the side walls, so that still
//! water stays still whatever the widths. Friction takes the hydraulic radius A/P_w for the depth, over banks that of the channel and
//! that of the plains. Where the last particle meets the plane: [`junction`].
//!
//! Deliberately absent: bends, confluences, lateral inflow, structures in the channel.

mod ends;
mod ground;
mod junction;
mod reaches;

#[cfg(test)]
mod tests;

use super::faces::{self, Half, Numbers, Side};
use super::gradient::{self, surface_difference};
use super::open::Exchange;
use super::state::{State, datum};
use super::update::{Stage, counted, take};
use super::walls::Walls;
use super::{EulerianMethods, Scale};
use crate::boundary::{Channel, ChannelEnd};
use crate::physics::friction::manning::kept_by_friction;
use crate::solver::{ChannelSample, FlowProblem};
use ends::{End, OpenEnd};
use ground::{Ground, StripRow};
use junction::Junction;
pub(crate) use reaches::Reaches;

/// Mean depth (m) and discharge per width of the whole section (m²/s) of a particle, as `WaterRow` has them of a cell.
#[derive(Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
struct Water {
    depth: f64,
    discharge: f64,
    stage_depth: f64,
    stage_discharge: f64,
}

/// Mean depth (m), level (m) and velocity (m/s) of a particle.
#[derive(Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
struct Primitive {
    depth: f64,
    level: f64,
    velocity: f64,
}

/// Differences from a strip of a particle to the same one of a neighbour.
#[derive(Clone, Copy, Default)]
struct Rise {
    level: f64,
    depth: f64,
    velocity: f64,
}

/// What passes a face: volume (m³/s) towards the near end, normal momentum (m⁴/s²) lost by the particle on the far side and gained by
/// the one on the near side.
#[derive(Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
struct Face {
    volume: f64,
    lost: f64,
    gained: f64,
}

/// One channel.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Reach {
    ground: Ground,
    water: Vec<Water>,
    primitive: Vec<Primitive>,
    rows: Vec<StripRow>,
    faces: Vec<Face>,
    /// Volume (m³/s) that passed each face in the latest step, towards the near end.
    passed: Vec<f64>,
    /// The far and the near end.
    ends: [End; 2],
    /// Volumes (m³) so far by each end.
    booked: [Exchange; 2],
    datum: f64,
    spacing: f64,
    dry_depth: f64,
}

/// The larger of two, or what is no number, so that the watch sees it.
pub(super) fn larger_or_nan(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

impl Reach {
    fn new(channel: &Channel, problem: &FlowProblem, state: &State, walls: &Walls) -> Self {
        let datum = datum(&problem.bed, &problem.initial_depth);
        let ground = Ground::new(channel, datum, problem.gravity);
        let (strips, particles) = (ground.strips, ground.particles());
        let water: Vec<Water> = (0..particles)
            .map(|i| Water { depth: ground.mean_depth(i, channel.sections[i].level - datum), ..Water::default() })
            .collect();
        let end = |end: &ChannelEnd, particle: usize, widths: &[f64]| match end {
            ChannelEnd::Wall => End::Wall,
            ChannelEnd::Open(condition) => {
                let level = ground.level(particle, water[particle].depth);
                let rest = (level - ground.lowest(particle) > problem.dry_depth).then_some(level);
                End::Open(OpenEnd::new(condition.clone(), rest, strips))
            }
            ChannelEnd::Joined(faces) => End::Joined(Junction::new(faces, widths, (problem, state, walls))),
        };
        let ends = [
            end(&channel.far, 0, &channel.face_widths[0]),
            end(&channel.near, particles - 1, &channel.face_widths[particles]),
        ];
        let mut rows: Vec<StripRow> = (0..strips).map(|strip| StripRow::new(ground.row(strip))).collect();
        if let End::Joined(junction) = &ends[1] {
            for (strip, bed) in junction.beds(state) {
                let ground = &mut rows[strip].ground;
                let step = &mut ground.step[particles - 1];
                *step = step.max((bed - ground.bed[particles - 1]).abs());
            }
        }
        let mut reach = Reach {
            primitive: vec![Primitive::default(); particles],
            rows,
            faces: vec![Face::default(); particles + 1],
            passed: vec![0.0; particles + 1],
            ground,
            water,
            ends,
            booked: [Exchange::default(); 2],
            datum,
            spacing: channel.spacing,
            dry_depth: problem.dry_depth,
        };
        reach.evaluate_primitive(Stage::First);
        reach
    }

    fn is_wet(&self, particle: usize) -> bool {
        self.primitive[particle].level - self.ground.lowest(particle) > self.dry_depth
    }

    fn evaluate_primitive(&mut self, before: Stage) {
        for (i, water) in self.water.iter().enumerate() {
            let (depth, discharge) = match before {
                Stage::First => (water.depth, water.discharge),
                Stage::Second => (water.stage_depth, water.stage_discharge),
            };
            let level = self.ground.level(i, depth);
            let deepest = self.ground.strip_depth(i, 0, depth, level);
            let velocity = if deepest <= self.dry_depth { 0.0 } else { discharge * (1.0 / depth) };
            self.primitive[i] = Primitive { depth, level, velocity };
            for (k, row) in self.rows.iter_mut().enumerate() {
                let in_strip = self.ground.strip_depth(i, k, depth, level);
                row.water.depth[i] = in_strip;
                // A film has no velocity.
                row.water.velocity_x[i] = if in_strip > self.dry_depth { velocity } else { 0.0 };
            }
        }
    }

    /// Depth, bed and velocity of a strip.
    fn strip(&self, particle: usize, strip: usize) -> (f64, f64, f64) {
        let StripRow { water, ground, .. } = &self.rows[strip];
        (water.depth[particle], ground.bed[particle], water.velocity_x[particle])
    }

    /// A strip of the particle at the near end, in a pair along the channel.
    fn last(&self, strip: usize) -> Half {
        let StripRow { water, ground, slope, .. } = &self.rows[strip];
        Half::of_row(water, slope, ground, self.water.len() - 1, self.spacing)
    }

    fn evaluate_gradients(&mut self, state: &State, scale: &Scale) {
        let last = self.water.len() - 1;
        for StripRow { ground, water, slope, .. } in &mut self.rows {
            gradient::along(water, ground, (1, last), scale, slope);
        }
        for strip in 0..self.rows.len() {
            let ([inner, outer], wet) = self.rises(0, 1, strip, state);
            self.set_slope(0, strip, [outer, inner], wet);
            let ([inner, outer], wet) = self.rises(last, last - 1, strip, state);
            self.set_slope(last, strip, [inner, outer], wet);
        }
    }

    /// Differences from a strip of the particle at an end to its neighbour and over the end, and whether the strip is wet.
    ///
    /// Over a wall the velocity is mirrored; over an open end all goes on as it comes from the other side.
    fn rises(&self, particle: usize, inner: usize, strip: usize, state: &State) -> ([Rise; 2], bool) {
        let (here, there) = (self.strip(particle, strip), self.strip(inner, strip));
        let level = surface_difference((here.0, here.1), (there.0, there.1), self.dry_depth);
        let inner = Rise { level, depth: there.0 - here.0, velocity: there.2 - here.2 };
        let outer = match &self.ends[usize::from(particle > 0)] {
            End::Wall => Rise { velocity: -2.0 * here.2, ..Rise::default() },
            End::Open(_) => Rise { level: -inner.level, depth: -inner.depth, velocity: -inner.velocity },
            End::Joined(junction) => junction.beyond(strip, here, state, self.dry_depth),
        };
        ([inner, outer], here.0 > self.dry_depth)
    }

    /// The gradients of a strip of a particle from the differences towards the far end and towards the near one.
    fn set_slope(&mut self, particle: usize, strip: usize, [before, after]: [Rise; 2], is_wet: bool) {
        let per_two_spacings = if is_wet { 0.5 / self.spacing } else { 0.0 };
        let slope = &mut self.rows[strip].slope;
        slope.surface_x[particle] = per_two_spacings * (after.level - before.level);
        slope.depth_x[particle] = per_two_spacings * (after.depth - before.depth);
        slope.u_x[particle] = per_two_spacings * (after.velocity - before.velocity);
    }

    fn pass(&mut self, state: &mut State, scale: &Scale, methods: EulerianMethods, step: (f64, f64)) {
        let (strips, last) = (self.ground.strips, self.water.len() - 1);
        let numbers = Numbers::new(scale, methods);
        self.faces.fill(Face::default());
        for (k, StripRow { ground, water, slope, flux }) in self.rows.iter_mut().enumerate() {
            faces::along(Side { water, slope, ground }, last + 1, numbers, methods, flux);
            for (f, face) in self.faces[1..=last].iter_mut().enumerate() {
                let wide = self.ground.face_width[(f + 1) * strips + k];
                face.volume += wide * flux.mass[f];
                face.lost += wide * flux.normal_left[f];
                face.gained += wide * flux.normal_right[f];
            }
        }
        self.pass_ends(scale, methods, step);
        if let [_, End::Joined(junction)] = &self.ends {
            let face = junction.pass(self, state, scale, methods);
            self.faces[last + 1] = face;
        }
    }

    /// Scales the outflow of particles that would give more water than they have in this stage.
    fn limit_outflow(&mut self, state: &mut State, scale: &Scale, stage: Stage, time_step: f64) {
        let last = self.water.len() - 1;
        for i in 0..=last {
            let held = match stage {
                Stage::First => self.water[i].depth,
                Stage::Second => self.water[i].stage_depth,
            };
            let by_junction = match &self.ends[1] {
                End::Joined(junction) if i == last => scale.spacing * junction.rates(state).outflow,
                _ => 0.0,
            };
            let leaving = self.faces[i + 1].volume.max(0.0) - self.faces[i].volume.min(0.0) + by_junction;
            let wanted = time_step / scale.spacing * leaving / self.ground.whole[i];
            if wanted > held {
                let share = held.max(0.0) / wanted;
                if self.faces[i].volume < 0.0 {
                    self.faces[i].volume *= share;
                }
                if self.faces[i + 1].volume > 0.0 {
                    self.faces[i + 1].volume *= share;
                }
                if let End::Joined(junction) = &self.ends[1]
                    && i == last
                {
                    junction.reduce(state, share);
                }
            }
        }
    }

    fn apply(&mut self, state: &State, scale: &Scale, stage: Stage, time_step: f64) {
        let last = self.water.len() - 1;
        if let End::Joined(junction) = &self.ends[1] {
            let Exchange { inflow, outflow } = junction.rates(state);
            self.faces[last + 1].volume = scale.spacing * (outflow - inflow);
        }
        for (passed, face) in self.passed.iter_mut().zip(&self.faces) {
            let before = if stage == Stage::First { 0.0 } else { *passed };
            *passed = before + 0.5 * face.volume;
        }
        let half = 0.5 * (time_step / scale.spacing);
        for i in 0..=last {
            let (left, right) = (self.faces[i], self.faces[i + 1]);
            let per_width = half / self.ground.whole[i];
            let water = &mut self.water[i];
            let (half_depth, raised) = take(water.depth, per_width * (left.volume - right.volume), stage.ahead());
            let (half_discharge, pushed) = take(water.discharge, per_width * (left.gained - right.lost), stage.ahead());
            // What is not a number stays, so that the watch sees it.
            let depth = if raised < 0.0 { 0.0 } else { raised };
            let level = self.ground.level(i, depth);
            let kept = if self.ground.strip_depth(i, 0, depth, level) <= scale.dry_depth {
                0.0
            } else {
                let roughness = self.ground.friction[i] * time_step;
                kept_by_friction(pushed.abs() / depth, self.ground.radius(i, depth, level), roughness)
            };
            let discharge = counted(kept * pushed);
            match stage {
                Stage::First => {
                    *water = Water {
                        depth: half_depth,
                        discharge: half_discharge,
                        stage_depth: depth,
                        stage_discharge: discharge,
                    };
                }
                Stage::Second => (water.depth, water.discharge) = (depth, discharge),
            }
        }
    }

    fn fastest(&self, scale: &Scale) -> (f64, f64) {
        let all = (0..self.water.len()).filter_map(|i| self.speeds(i, scale));
        all.fold((0.0, 0.0), |(signal, flow), one| (larger_or_nan(signal, one.0), larger_or_nan(flow, one.1)))
    }

    /// Signal speed and speed of the water (m/s) of a particle; none where it is dry.
    fn speeds(&self, particle: usize, scale: &Scale) -> Option<(f64, f64)> {
        let water = &self.primitive[particle];
        let deepest = self.ground.strip_depth(particle, 0, water.depth, water.level);
        if deepest <= scale.dry_depth {
            return None;
        }
        // A face wider than its particle empties it faster.
        let widening = self.ground.widening[particle];
        let speed = water.velocity.abs();
        Some((widening * (speed + (scale.gravity * deepest).sqrt()), speed))
    }

    /// The water of all particles; their discharge is the mean of what passed the faces of each in the latest step (M51).
    fn samples(&self) -> Vec<ChannelSample> {
        let sample = |(i, water): (usize, &Primitive)| ChannelSample {
            depth: self.ground.strip_depth(i, 0, water.depth, water.level),
            level: water.level + self.datum,
            velocity: water.velocity,
            discharge: 0.5 * (self.passed[i] + self.passed[i + 1]),
        };
        self.primitive.iter().enumerate().map(sample).collect()
    }
}
