//! Open boundaries of moving particles: rows of buffer particles beyond the edge that carry the state there.
//!
//! The state beyond a face comes from the water before it (`look`) and what is known there, by the functions that resting particles
//! use (`physics::open_boundary`, (M37), (M38), (M41) to (M43) and (M45)). Buffer particles carry its depth, and its velocity and level with the gradients
//! inside:
//!
//! ```text
//! (M67)  d_b = d,   v_b = v + ∇v·(x_b − x_f),   η_b = z_f + d + ∇η·(x_b − x_f)
//! ```
//!
//! They stand a support deep beyond the face, complete the kernels of the particles before it, and move with v. One that comes
//! across the face is water from then on. A face owes what came in less what it gave,
//!
//! ```text
//! (M68)  dV_f/dt = q w_f,   V = clamp(V_f + V_b/2 − V_b x/l, V_b/2, 3 V_b/2),   V_f ← V_f − V,   V_b = d A_b
//! ```
//!
//! with A_b the area of the particle, l its length along the way and x the way behind the face: while the water flows evenly each
//! particle takes V_b, and V_f stays within half a particle. V_f belongs to the volume balance. A particle that goes out across a face becomes a
//! buffer particle; where water leaves, V_f is what of the buffer particles stands before the face less what of the water stands beyond.
//! Where the water turns V_f goes on from there, and a particle that goes out where water comes in is added to it.

mod corners;
mod faces;
pub(super) mod look;

use crate::bed::{BedParticles, BedPoint};
use crate::boundary::{Condition, Edge, Walls, distance_to_segment};
use crate::gridding::WaterBeyond;
use crate::math::Vec2;
use crate::neighbours::Found;
use crate::particles::{FluidParticles, Particle};
use crate::physics::dimension::Dimension;
use crate::physics::open_boundary::EdgeState;
use crate::solver::eulerian::Scale;
use crate::solver::eulerian::open::{Faces, Inside, Of, Passing, pass};
use crate::solver::moving::{Rates, smoothing_factor};
use crate::solver::{FlowProblem, Passage, Way};
use corners::Corners;
use faces::{Face, faces_and_guides};
use look::{Look, Seen};

/// What is beyond a face.
#[derive(Clone, Copy, Debug, Default)]
struct Beyond {
    /// Depth (m).
    depth: f64,
    /// Velocity (m/s).
    velocity: Vec2,
    /// Level (m) at the face, and its gradient.
    surface: f64,
    gradient: Vec2,
    /// Gradients of the components of the velocity (1/s).
    along_u: Vec2,
    along_v: Vec2,
    /// Velocity outwards (m/s).
    outwards: f64,
    /// How deep (m) the rows of buffer particles reach.
    reach: f64,
    /// The share of the discharge of its boundary.
    share: f64,
}

impl Beyond {
    /// Level (m) at an offset from the middle of the face, as (M67) has it.
    fn level(&self, offset: Vec2) -> f64 {
        self.surface + self.gradient.dot(offset)
    }

    /// ∇v·(x − x_f) of (M67).
    fn change_of_velocity(&self, offset: Vec2) -> Vec2 {
        Vec2::new(self.along_u.dot(offset), self.along_v.dot(offset))
    }
}

/// A particle beyond an open boundary.
#[derive(Clone, Copy, Debug)]
struct BufferParticle {
    face: u32,
    position: Vec2,
    area: f64,
    smoothing_length: f64,
    rates: Rates,
}

/// One boundary.
#[derive(Debug)]
struct Line {
    condition: Condition,
    /// Its faces, as a range of all.
    faces: std::ops::Range<usize>,
    inside: Vec<Inside>,
    passing: Vec<Passing>,
    /// Its lowest face.
    lowest: usize,
    /// Volume (m³) that came in while it was too little for any face.
    waiting: f64,
    /// Volumes (m³) that came in and left since the start.
    inflow: f64,
    outflow: f64,
}

/// All open boundaries with a condition.
#[derive(Debug)]
pub(in crate::solver) struct OpenBoundaries {
    dimension: Dimension,
    scale: Scale,
    /// Distance (m) over edge of a particle at which it acts.
    support: f64,
    time: f64,
    lines: Vec<Line>,
    faces: Vec<Face>,
    /// Open edges without a condition (m).
    plain: Vec<[Vec2; 2]>,
    seen: Vec<Seen>,
    beyond: Vec<Option<Beyond>>,
    /// B of each face (m³).
    owed: Vec<f64>,
    /// Volume (m³) of the particles that went out across each face since its state was found.
    crossed: Vec<f64>,
    /// B + P of each face (m³) through which water leaves, from the moment on at which it began to; none where it does not.
    phase: Vec<Option<f64>>,
    buffer: Vec<BufferParticle>,
    corners: Corners,
    look: Look,
    farthest: Vec<f64>,
    crossing: Vec<(u32, f64, u32)>,
    near: Found,
    /// Volume (m³) of the buffer particles of each face that stands before it.
    returning: Vec<f64>,
    lent: Vec<(usize, f64)>,
}

impl OpenBoundaries {
    /// The boundaries of a problem whose outline is `edges`, and the walls that guide the water beyond them.
    ///
    /// `kernel_support`: radius of the kernel's support in smoothing lengths
    pub fn new(
        problem: &FlowProblem,
        edges: &[Edge],
        dimension: Dimension,
        kernel_support: f64,
    ) -> (OpenBoundaries, Vec<Edge>) {
        let spacing = problem.bed.lattice.spacing;
        let support = kernel_support * smoothing_factor(dimension);
        let (mut faces, guides) = faces_and_guides(problem, edges, dimension, GUIDED * support * spacing);
        faces.sort_by_key(|face| face.line);
        let line = |(number, boundary): (usize, &crate::boundary::Boundary)| {
            let start = faces.partition_point(|face| face.line < number);
            let end = faces.partition_point(|face| face.line <= number);
            let by_sill = |a: &usize, b: &usize| faces[*a].sill.total_cmp(&faces[*b].sill);
            let lowest = (start..end).min_by(by_sill).unwrap_or(start);
            Line {
                condition: boundary.condition.clone(),
                faces: start..end,
                lowest,
                inside: Vec::new(),
                passing: Vec::new(),
                waiting: 0.0,
                inflow: 0.0,
                outflow: 0.0,
            }
        };
        let lines: Vec<Line> = problem.forcing.boundaries.iter().enumerate().map(line).collect();
        let is_plain = |edge: &&Edge| {
            let middle = (edge.start + edge.end) * 0.5;
            edge.is_open && faces.iter().all(|face| face.distance(middle) > 0.1 * spacing)
        };
        let scale = Scale { spacing, gravity: problem.gravity, courant: problem.courant, dry_depth: problem.dry_depth };
        let boundaries = OpenBoundaries {
            dimension,
            scale,
            support,
            time: 0.0,
            plain: edges.iter().filter(is_plain).map(|edge| [edge.start, edge.end]).collect(),
            seen: vec![Seen::default(); faces.len()],
            beyond: vec![None; faces.len()],
            owed: vec![0.0; faces.len()],
            crossed: vec![0.0; faces.len()],
            phase: vec![None; faces.len()],
            buffer: Vec::new(),
            corners: Corners::new(&faces, 1e-6 * spacing),
            look: Look::new(&faces, lines.len(), dimension),
            farthest: Vec::new(),
            crossing: Vec::new(),
            near: Found::default(),
            returning: Vec::new(),
            lent: Vec::new(),
            lines,
            faces,
        };
        (boundaries, guides)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Volume (m³) that came in since the start.
    pub fn inflow(&self) -> f64 {
        self.lines.iter().map(|line| line.inflow).sum()
    }

    /// Volume (m³) that left since the start.
    pub fn outflow(&self) -> f64 {
        self.lines.iter().map(|line| line.outflow).sum()
    }

    /// Whether there are edges without a condition.
    pub fn has_plain_edges(&self) -> bool {
        !self.plain.is_empty()
    }

    /// What came and left by each boundary; in one dimension per metre of width, as what was asked for.
    pub fn passages(&self) -> impl Iterator<Item = Passage> + '_ {
        let width = if self.dimension == Dimension::One { self.scale.spacing } else { 1.0 };
        self.lines.iter().enumerate().map(move |(index, line)| Passage {
            way: Way::Boundary(index),
            inflow: line.inflow,
            outflow: line.outflow,
            asked: line.condition.asked(self.time).map(|volume| volume / width),
        })
    }

    /// Volume (m³) that came in and is no particle yet, less what particles brought in advance.
    pub fn owed(&self) -> f64 {
        (0..self.lines.len()).map(|number| self.owed_by(number)).sum()
    }

    /// The same of one boundary.
    pub fn owed_by(&self, number: usize) -> f64 {
        let line = &self.lines[number];
        line.waiting + self.owed[line.faces.clone()].iter().sum::<f64>()
    }

    /// Rates, smoothing lengths (m) and depths (m) of the buffer particles at the latest evaluation.
    pub fn signals(&self) -> impl Iterator<Item = (&Rates, f64, f64, Vec2)> + '_ {
        self.buffer.iter().filter_map(|particle| {
            let beyond = self.beyond[particle.face as usize]?;
            Some((&particle.rates, particle.smoothing_length, beyond.depth, particle.position))
        })
    }

    /// Takes a particle that went out across an edge; returns its volume (m³) where there is no boundary with a condition.
    pub fn receive(&mut self, particle: &Particle) -> f64 {
        let place = particle.position;
        let Some((index, true)) = nearest(&self.faces, &self.plain, place) else {
            return particle.volume;
        };
        self.crossed[index] += particle.volume;
        let area = particle.volume / particle.depth;
        if area >= self.least_area(index) {
            self.buffer.push(BufferParticle {
                face: index as u32,
                position: place,
                area,
                smoothing_length: particle.smoothing_length,
                rates: Rates::default(),
            });
        }
        0.0
    }

    /// Area (m²) below which a particle does not go on across a face.
    fn least_area(&self, index: usize) -> f64 {
        LEAST_AREA * self.faces[index].width * self.scale.spacing
    }

    /// Books what left since the states were found before.
    fn book_outflow(&mut self, particles: &FluidParticles) {
        for index in 0..self.faces.len() {
            let crossed = std::mem::take(&mut self.crossed[index]);
            let number = self.faces[index].line;
            let line = &mut self.lines[number];
            if matches!(line.condition, Condition::Discharge { .. }) {
                // What comes in is known, so that this particle has been too early.
                self.owed[index] += crossed;
                if self.beyond[index].is_none() {
                    line.waiting += std::mem::take(&mut self.owed[index]);
                }
            } else if self.beyond[index].is_none() {
                // Nothing goes on here: what is owed has left, and what was brought in advance has not.
                self.phase[index] = None;
                line.outflow += std::mem::take(&mut self.owed[index]) + crossed;
            } else if self.leaves(index) || self.phase[index].is_some() {
                let beyond = self.volume_beyond(index, particles);
                let phase = *self.phase[index].get_or_insert(self.owed[index] + crossed + beyond);
                self.lines[number].outflow += self.owed[index] + crossed - (phase - beyond);
                self.owed[index] = phase - beyond;
                if !self.leaves(index) {
                    // The water turns with particles astride of the face: B begins from where they stand.
                    self.phase[index] = None;
                }
            } else {
                // Water comes in or stands: this particle has not left, it comes back.
                self.owed[index] += crossed;
            }
        }
    }

    /// Whether water leaves through a face.
    fn leaves(&self, index: usize) -> bool {
        let is_imposed = matches!(self.lines[self.faces[index].line].condition, Condition::Discharge { .. });
        !is_imposed && self.beyond[index].is_some_and(|beyond| beyond.outwards > 0.0)
    }

    /// P: volume (m³) of the particles before a face that stands beyond it, less that of the buffer particles that stands before it.
    fn volume_beyond(&mut self, index: usize, particles: &FluidParticles) -> f64 {
        let face = &self.faces[index];
        let near = self.look.near(face.middle, self.scale.spacing, &mut self.near);
        let of = |&i: &u32| {
            let i = i as usize;
            let edge = self.dimension.edge(particles.volume[i] / particles.depth[i]);
            let place = particles.position[i];
            if face.faces(place) { particles.volume[i] * face.share_beyond(place, edge) } else { 0.0 }
        };
        near.iter().map(of).sum::<f64>() - self.returning[index]
    }

    /// Moves the buffer particles for a time (s) and books what comes in.
    pub fn drift(&mut self, dt: f64) {
        let (from, to) = (self.time, self.time + dt);
        self.time = to;
        for line in &mut self.lines {
            let imposed = match &line.condition {
                Condition::Discharge { discharge, .. } => {
                    let volume = discharge.integral(from, to).max(0.0);
                    Some(if self.dimension == Dimension::One { volume / self.scale.spacing } else { volume })
                }
                _ => None,
            };
            if let Some(volume) = imposed {
                line.inflow += volume;
                line.waiting += volume;
            }
            let is_passed_on = self.beyond[line.faces.clone()].iter().flatten().any(|beyond| beyond.share > 0.0);
            let waits = if is_passed_on { std::mem::take(&mut line.waiting) } else { 0.0 };
            for index in line.faces.clone() {
                let Some(beyond) = &self.beyond[index] else { continue };
                let comes = match imposed {
                    Some(_) => waits * beyond.share,
                    None => {
                        let comes = beyond.depth * (-beyond.outwards).max(0.0) * self.faces[index].width * dt;
                        line.inflow += comes;
                        comes
                    }
                };
                self.owed[index] += comes;
            }
        }
        // What a face owed when the water began to leave by it leaves with the first row.
        for (phase, beyond) in self.phase.iter_mut().zip(&self.beyond) {
            if let (Some(phase), Some(beyond)) = (phase, beyond) {
                *phase *= (1.0 - beyond.outwards * dt / self.scale.spacing).max(0.0);
            }
        }
        for particle in &mut self.buffer {
            if let Some(beyond) = &self.beyond[particle.face as usize] {
                particle.position += beyond.velocity * dt;
            }
        }
    }

    /// Finds the state beyond each face from the water before it.
    fn find_states(&mut self, particles: &FluidParticles, bed: &BedParticles) {
        self.look.look(&self.faces, particles, bed, &mut self.seen);
        let g = self.scale.gravity;
        let now = (self.time, self.time);
        for line in &mut self.lines {
            let range = line.faces.clone();
            line.inside.clear();
            line.inside.extend(range.clone().map(|i| inside(&self.faces[i], &self.seen[i], &self.scale)));
            pass(
                &line.condition,
                (Faces::BeforeBuffers, &line.inside),
                (&self.scale, 0.0),
                (now, Of::Mean),
                &mut line.passing,
            );
            let is_imposed = matches!(line.condition, Condition::Discharge { .. });
            let mut total = 0.0;
            for ((index, inside), passing) in range.zip(&line.inside).zip(&line.passing) {
                let (face, seen) = (&self.faces[index], &self.seen[index]);
                let state = state_beyond(inside, passing, is_imposed, g);
                let is_there = state.depth > self.scale.dry_depth && (seen.is_water() || state.outwards < 0.0);
                self.beyond[index] = is_there.then(|| {
                    let along = face.outwards.perpendicular();
                    let tangent = if state.outwards > 0.0 { along * seen.velocity.dot(along) } else { Vec2::ZERO };
                    let area = seen.area.max(self.scale.spacing * face.width);
                    // Water that comes in faster than waves run knows nothing of that before it.
                    let is_told = seen.is_water() && -state.outwards < (g * state.depth).sqrt();
                    let (gradient, along_u, along_v) = if is_told {
                        (seen.gradient, seen.along_u, seen.along_v)
                    } else {
                        (face.slope, Vec2::ZERO, Vec2::ZERO)
                    };
                    Beyond {
                        depth: state.depth,
                        velocity: face.outwards * state.outwards + tangent,
                        surface: face.sill + state.depth,
                        gradient,
                        along_u,
                        along_v,
                        outwards: state.outwards,
                        reach: self.support * self.dimension.edge(area) + self.scale.spacing,
                        share: (-passing.mass * inside.width()).max(0.0),
                    }
                });
                total += self.beyond[index].map_or(0.0, |beyond| beyond.share);
            }
            for beyond in self.beyond[line.faces.clone()].iter_mut().flatten() {
                beyond.share = if total > 0.0 { beyond.share / total } else { 0.0 };
            }
        }
    }

    /// Drops the buffer particles that nobody needs and completes the rows.
    fn renew_rows(&mut self) {
        let (beyond, faces) = (&self.beyond, &self.faces);
        self.buffer.retain(|particle| {
            let face = particle.face as usize;
            beyond[face].is_some_and(|state| faces[face].beyond(particle.position) < state.reach)
        });
        let length = self.scale.spacing;
        self.farthest.clear();
        self.farthest.resize(self.faces.len(), f64::NEG_INFINITY);
        for particle in &self.buffer {
            let (face, farthest) = (&self.faces[particle.face as usize], &mut self.farthest[particle.face as usize]);
            *farthest = farthest.max(face.beyond(particle.position));
        }
        for (index, face) in self.faces.iter().enumerate() {
            let (Some(state), farthest) = (&self.beyond[index], self.farthest[index]) else { continue };
            let is_new = farthest == f64::NEG_INFINITY;
            if !is_new && state.outwards > 0.0 {
                continue;
            }
            let mut row = if is_new { 0.5 * length } else { farthest + length };
            let area = face.width * length;
            while row < state.reach {
                self.buffer.push(BufferParticle {
                    face: index as u32,
                    position: face.middle + face.outwards * row,
                    area,
                    smoothing_length: smoothing_factor(self.dimension) * self.dimension.edge(area),
                    rates: Rates::default(),
                });
                row += length;
            }
        }
    }

    fn find_returning(&mut self) {
        self.returning.clear();
        self.returning.resize(self.faces.len(), 0.0);
        for particle in &self.buffer {
            let index = particle.face as usize;
            if let Some(beyond) = &self.beyond[index] {
                let inside =
                    1.0 - self.faces[index].share_beyond(particle.position, self.dimension.edge(particle.area));
                if inside < 1.0 {
                    self.returning[index] += particle.area * beyond.depth * inside;
                }
            }
        }
    }

    /// Appends the buffer particles to the water before an evaluation.
    pub fn admit(&mut self, particles: &mut FluidParticles, bed: &BedParticles) {
        self.find_states(particles, bed);
        self.renew_rows();
        self.find_returning();
        self.book_outflow(particles);
        self.corners.fill(&self.faces, &self.beyond, &self.buffer, self.dimension);
        for particle in &self.buffer {
            if let Some(state) = &self.beyond[particle.face as usize] {
                let offset = particle.position - self.faces[particle.face as usize].middle;
                particles.push(&Particle {
                    position: particle.position,
                    velocity: state.velocity + state.change_of_velocity(offset),
                    volume: particle.area * state.depth,
                    depth: state.depth,
                    smoothing_length: particle.smoothing_length,
                });
            }
        }
        for (particle, _) in self.corners.particles() {
            particles.push(particle);
        }
    }

    /// Number of buffer particles, those beyond corners included.
    pub fn count(&self) -> usize {
        self.buffer.len() + self.corners.particles().len()
    }

    /// The bed under the buffer particles: what their level leaves below their depth.
    pub fn bed_points(&self) -> impl Iterator<Item = BedPoint> + '_ {
        let of_rows = self.buffer.iter().filter_map(|particle| {
            let state = self.beyond[particle.face as usize]?;
            let face = &self.faces[particle.face as usize];
            let level = state.level(particle.position - face.middle);
            Some(BedPoint { elevation: level - state.depth, slope: face.slope })
        });
        of_rows.chain(self.corners.particles().iter().map(|(_, bed)| *bed))
    }

    /// The water of the buffer particles, those beyond corners included.
    pub fn water_beyond(&self) -> impl Iterator<Item = WaterBeyond> + '_ {
        let of_rows = self.buffer.iter().filter_map(|particle| {
            let BufferParticle { face, position: place, area, smoothing_length, .. } = *particle;
            let level = self.beyond[face as usize]?.level(place - self.faces[face as usize].middle);
            Some(WaterBeyond { place, level, area, smoothing_length })
        });
        let of_corners = self.corners.particles().iter().map(|(particle, bed)| WaterBeyond {
            place: particle.position,
            level: bed.elevation + particle.depth,
            area: particle.volume / particle.depth,
            smoothing_length: particle.smoothing_length,
        });
        of_rows.chain(of_corners)
    }

    /// Takes the buffer particles, those behind the first `fluid`, out of the water again after an evaluation.
    pub fn dismiss(&mut self, fluid: usize, particles: &mut FluidParticles, rates: &mut Vec<Rates>) {
        for (k, particle) in self.buffer.iter_mut().enumerate() {
            particle.smoothing_length = particles.smoothing_length[fluid + k];
            particle.rates = rates[fluid + k];
        }
        particles.truncate(fluid);
        rates.truncate(fluid);
    }

    /// Hands those buffer particles on to the face nearest to them that passed the line of their own where the outline bends and are
    /// still beyond it, and gives those up that drifted past the end of the boundary: water there would never come back.
    fn hand_on(&mut self, bed: &BedParticles, walls: &Walls) {
        let (faces, plain, spacing) = (&self.faces, &self.plain, self.scale.spacing);
        self.buffer.retain_mut(|particle| {
            let place = particle.position;
            if faces[particle.face as usize].beyond(place) >= 0.0 {
                return true;
            }
            let Some((index, is_nearest)) = nearest(faces, plain, place) else { return false };
            if faces[index].beyond(place) >= 0.0 {
                particle.face = index as u32;
                return true;
            }
            // A straightened outline may run beside the terrain, where a wall or an edge without a condition may be nearer.
            if bed.at(place).is_some() {
                return true;
            }
            let before = faces[index].middle - faces[index].outwards * (0.25 * spacing);
            is_nearest && !walls.is_walled(place, before)
        });
    }

    /// Turns the buffer particles that came across their face into water.
    pub fn enter(
        &mut self,
        particles: &mut FluidParticles,
        rates: &mut Vec<Rates>,
        (bed, walls): (&BedParticles, &Walls),
    ) {
        self.hand_on(bed, walls);
        self.crossing.clear();
        for (k, particle) in self.buffer.iter().enumerate() {
            let way = -self.faces[particle.face as usize].beyond(particle.position);
            if way > 0.0 {
                self.crossing.push((particle.face, way, k as u32));
            }
        }
        if self.crossing.is_empty() {
            return;
        }
        // Those that came first go first.
        self.crossing.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2)));
        for &(face, way, k) in &self.crossing {
            let Some(state) = self.beyond[face as usize] else { continue };
            let particle = &self.buffer[k as usize];
            if particle.area < self.least_area(face as usize) {
                continue;
            }
            let usual = particle.area * state.depth;
            let length = particle.area / self.faces[face as usize].width;
            let owed = &mut self.owed[face as usize];
            let volume = (*owed + 0.5 * usual - usual * way / length).clamp(0.5 * usual, 1.5 * usual);
            *owed -= volume;
            particles.push(&Particle {
                position: particle.position,
                velocity: state.velocity,
                volume,
                depth: state.depth,
                smoothing_length: particle.smoothing_length,
            });
            rates.push(particle.rates);
        }
        let faces = &self.faces;
        self.buffer.retain(|particle| faces[particle.face as usize].beyond(particle.position) >= 0.0);
    }

    /// Puts what the faces owe into the water for its gridding: the particles before a face take it, or one of its own stands there
    /// where none is near. `take_back` undoes it.
    pub fn lend(&mut self, particles: &mut FluidParticles) {
        self.lent.clear();
        self.look.gather(particles);
        // Of those that were counted some came in since.
        self.find_returning();
        let fluid = particles.len();
        for index in 0..self.faces.len() {
            let mut owed = self.owed[index];
            if self.beyond[index].is_some_and(|beyond| beyond.outwards != 0.0) {
                owed -= self.lend_before(index, particles);
            }
            let line = &self.lines[self.faces[index].line];
            if line.waiting > 0.0 && line.lowest == index {
                owed += line.waiting;
            }
            if owed != 0.0 {
                self.lend_nearest((index, owed), fluid, particles);
            }
        }
    }

    /// Gives the volume (m³) that a face owes to the particle nearest to it, or takes what was brought in advance from those nearest of
    /// the first `fluid`, as far as they have it.
    fn lend_nearest(&mut self, (index, owed): (usize, f64), fluid: usize, particles: &mut FluidParticles) {
        let face = &self.faces[index];
        let mut nearest = self.look.nearest_first(face.middle, 2.0 * self.scale.spacing, &mut self.near);
        let has = |i: &u32| (1.0 - LEAST_LEFT) * particles.volume[*i as usize];
        let all: Vec<u32>;
        if nearest.iter().map(has).sum::<f64>() < -owed {
            // Much came in and ran on before the water turned.
            all = by_distance(face.middle, &particles.position[..fluid]);
            nearest = &all;
        }
        let mut rest = owed;
        for i in nearest.iter().map(|&i| i as usize) {
            let before = particles.volume[i];
            let after = (before + rest).max(LEAST_LEFT * before);
            self.lent.push((i, before));
            particles.volume[i] = after;
            rest += before - after;
            // Rounding leaves next to nothing of it where a particle had enough.
            if after > LEAST_LEFT * before {
                break;
            }
        }
        if nearest.is_empty() && owed > 0.0 {
            let depth = self.beyond[index].map_or(owed / (face.width * self.scale.spacing), |beyond| beyond.depth);
            particles.push(&self.just_before(index, owed, (depth, Vec2::ZERO)));
        }
    }

    /// For a face through which water comes or leaves particles give what stands beyond it, buffer particles what stands before it; returns
    /// the volume (m³) that came so.
    fn lend_before(&mut self, index: usize, particles: &mut FluidParticles) -> f64 {
        let face = &self.faces[index];
        let mut lent = 0.0;
        for &i in self.look.near(face.middle, self.scale.spacing, &mut self.near) {
            let i = i as usize;
            let edge = self.dimension.edge(particles.volume[i] / particles.depth[i]);
            let share = face.share_beyond(particles.position[i], edge);
            if share > 0.0 && face.faces(particles.position[i]) {
                self.lent.push((i, particles.volume[i]));
                lent -= particles.volume[i] * share;
                particles.volume[i] *= 1.0 - share;
            }
        }
        if let Some(beyond) = &self.beyond[index]
            && self.returning[index] > 0.0
        {
            lent += self.returning[index];
            particles.push(&self.just_before(index, self.returning[index], (beyond.depth, beyond.velocity)));
        }
        lent
    }

    /// A particle of a volume (m³), as wide as a cell, that stands before a face.
    fn just_before(&self, index: usize, volume: f64, (depth, velocity): (f64, Vec2)) -> Particle {
        let face = &self.faces[index];
        let area = face.width * self.scale.spacing;
        Particle {
            position: face.middle - face.outwards * (0.25 * self.scale.spacing),
            velocity,
            volume,
            depth,
            smoothing_length: smoothing_factor(self.dimension) * self.dimension.edge(area),
        }
    }

    /// Leaves `fluid` particles with the volumes that they had before `lend`.
    pub fn take_back(&mut self, fluid: usize, particles: &mut FluidParticles) {
        particles.truncate(fluid);
        for &(i, volume) in self.lent.iter().rev() {
            particles.volume[i] = volume;
        }
    }

    /// The longest step (s) in which what comes in at most does not outrun a particle.
    pub fn longest_step(&mut self, step: f64) -> f64 {
        let mut longest = step;
        let of = ((self.time, self.time + step), Of::Largest);
        for line in &mut self.lines {
            if !line.condition.feeds() {
                continue;
            }
            pass(&line.condition, (Faces::BeforeBuffers, &line.inside), (&self.scale, 0.0), of, &mut line.passing);
            for (index, passing) in line.faces.clone().zip(&line.passing) {
                let Some(state) = passing.beyond.filter(|state| state.outwards < 0.0) else { continue };
                let now = self.beyond[index].map_or(0.0, |beyond| beyond.outwards);
                let speed = (self.scale.gravity * state.depth).sqrt() + (state.outwards - now).abs();
                let reach = smoothing_factor(self.dimension) * self.scale.spacing;
                longest = longest.min(self.scale.courant * reach / speed.max(f64::MIN_POSITIVE));
            }
        }
        longest
    }
}

/// Particles smaller than this share of a face times the spacing end there, and the books keep their volume: each that goes to and fro
/// across a face may lose half of itself every time, and hundreds of the size of nothing would gather.
const LEAST_AREA: f64 = 1.0 / 16.0;
/// A particle keeps this share of its volume on the grid whatever was brought in advance.
const LEAST_LEFT: f64 = 0.1;
/// Guides are so many supports of a particle of one spacing long.
const GUIDED: f64 = 2.0;

/// The face nearest to a place, the first of several, and whether it is nearer than every open edge without a condition.
fn nearest(faces: &[Face], plain: &[[Vec2; 2]], place: Vec2) -> Option<(usize, bool)> {
    let distances = faces.iter().map(|face| face.distance(place)).enumerate();
    let (index, distance) = distances.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))?;
    let to_plain = plain.iter().map(|[start, end]| distance_to_segment(place, *start, *end));
    Some((index, distance < to_plain.fold(f64::INFINITY, f64::min)))
}

/// All places (m) by their distance from one place, the nearest first.
fn by_distance(from: Vec2, places: &[Vec2]) -> Vec<u32> {
    let squared = |k: u32| (places[k as usize] - from).norm_squared();
    let mut found: Vec<u32> = (0..places.len() as u32).collect();
    found.sort_unstable_by(|&a, &b| squared(a).total_cmp(&squared(b)).then(a.cmp(&b)));
    found
}

/// What is known at a face.
fn inside(face: &Face, seen: &Seen, scale: &Scale) -> Inside {
    let depth = seen.surface - face.sill;
    let is_wet = seen.is_water() && depth > scale.dry_depth;
    let state = is_wet.then(|| EdgeState { depth, outwards: seen.velocity.dot(face.outwards) });
    let along = seen.velocity.cross(face.outwards);
    let water = Inside::at_face(state, along, face.sill, scale.gravity);
    water.with(face.width_in(scale.spacing), face.friction, face.rest)
}

/// The state that buffer particles carry: that beyond, or that of the water before the face where it leaves faster than waves run and
/// nothing drowns it; at rest where the face is as a wall.
fn state_beyond(inside: &Inside, passing: &Passing, is_imposed: bool, g: f64) -> EdgeState {
    let before = inside.state();
    let Some(beyond) = passing.beyond else { return EdgeState { outwards: 0.0, ..before } };
    let is_fast = before.outwards > 0.0 && before.outwards * before.outwards >= g * before.depth;
    // A bore comes in where less water leaves behind it than before it.
    let is_drowned = beyond.depth > before.depth && beyond.depth * beyond.outwards < before.depth * before.outwards;
    if is_fast && !is_imposed && !is_drowned { before } else { beyond }
}

#[cfg(test)]
mod levels;
#[cfg(test)]
mod tests;
