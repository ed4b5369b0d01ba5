//! Dam breaks without a closed form, by finite volumes (`HLL1983`) on a grid far finer than any of ours.
//!
//! ```text
//! ∂d/∂t + ∂(d u)/∂x = −s d u / x,   ∂(d u)/∂t + ∂(d u² + g d²/2)/∂x = −s d u² / x − friction    (s = 0 plane, 1 radial)
//! ```
//!
//! Friction is Manning's, implicit at the end of a step (M34). Both ends are walls.

use crate::math::minmod;
use crate::scenario::GRAVITY;

/// Below this depth (m) the velocity is taken as that of this depth.
const FILM: f64 = 1e-9;
/// Courant number.
const COURANT: f64 = 0.9;

/// How a reference is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accuracy {
    /// Constant in each cell. Bounds of tests that were measured against it keep it.
    First,
    /// Linear in each cell (minmod), Heun's method: of second order but for bores.
    Second,
}

/// Depth and velocity along a line.
#[derive(Clone, Debug)]
pub struct Profile {
    cell: f64,
    depth: Vec<f64>,
    discharge: Vec<f64>,
}

impl Profile {
    /// Depth (m) and velocity (m/s) in the cell that holds `x` (m from the start of the line); the last cell beyond its end.
    pub fn at(&self, x: f64) -> (f64, f64) {
        let k = ((x / self.cell) as usize).min(self.depth.len() - 1);
        (self.depth[k], self.discharge[k] / self.depth[k].max(FILM))
    }

    /// The farthest place (m) at which the water is at least `depth` (m) deep.
    pub fn reach(&self, depth: f64) -> f64 {
        self.depth.iter().rposition(|d| *d >= depth).map_or(0.0, |k| (k as f64 + 1.0) * self.cell)
    }
}

/// Circular dam break: depths (m) inside and outside of the radius `dam` (m), on a `line` of so many metres and cells from the middle,
/// at time `end` (s).
pub fn radial_dam_break(
    (inside, outside): (f64, f64),
    dam: f64,
    line: (f64, usize),
    end: f64,
    accuracy: Accuracy,
) -> Profile {
    run([inside, outside], dam, line, end, Geometry { is_radial: true, manning: 0.0, accuracy })
}

/// Dam break in a channel on a level bed with Manning's n (s·m^(−1/3)): depths (m) up to `dam` (m) and beyond it.
pub fn plane_dam_break((left, right): (f64, f64), dam: f64, line: (f64, usize), manning: f64, end: f64) -> Profile {
    run([left, right], dam, line, end, Geometry { is_radial: false, manning, accuracy: Accuracy::Second })
}

struct Geometry {
    is_radial: bool,
    manning: f64,
    accuracy: Accuracy,
}

fn run([left, right]: [f64; 2], dam: f64, (length, cells): (f64, usize), end: f64, geometry: Geometry) -> Profile {
    let dx = length / cells as f64;
    let centre = |k: usize| (k as f64 + 0.5) * dx;
    let d: Vec<f64> = (0..cells).map(|k| if centre(k) < dam { left } else { right }).collect();
    let mut state = Profile { cell: dx, discharge: vec![0.0; cells], depth: d };
    let mut t = 0.0;
    while t < end {
        let speed =
            |k: usize| (state.discharge[k] / state.depth[k].max(FILM)).abs() + (GRAVITY * state.depth[k]).sqrt();
        let fastest = (0..cells).map(speed).fold(FILM, f64::max);
        match geometry.accuracy {
            Accuracy::First => {
                let dt = (COURANT * dx / fastest).min(end - t);
                state = stage(&state, dt, &geometry);
                t += dt;
            }
            Accuracy::Second => {
                let dt = (0.5 * COURANT * dx / fastest).min(end - t);
                let twice = stage(&stage(&state, dt, &geometry), dt, &geometry);
                for k in 0..cells {
                    state.depth[k] = 0.5 * (state.depth[k] + twice.depth[k]);
                    state.discharge[k] = 0.5 * (state.discharge[k] + twice.discharge[k]);
                }
                t += dt;
            }
        }
    }
    state
}

/// One step of Euler's method, friction at its end.
fn stage(state: &Profile, dt: f64, geometry: &Geometry) -> Profile {
    let (d, q, dx) = (&state.depth, &state.discharge, state.cell);
    let cells = d.len();
    let slope = |values: &[f64], k: usize| {
        if geometry.accuracy == Accuracy::First || k == 0 || k + 1 == cells {
            return 0.0;
        }
        minmod(values[k] - values[k - 1], values[k + 1] - values[k])
    };
    let slopes: Vec<(f64, f64)> = (0..cells).map(|k| (0.5 * slope(d, k), 0.5 * slope(q, k))).collect();
    let wall = |k: usize| (0.0, 0.5 * GRAVITY * d[k] * d[k]);
    let face = |f: usize| match f {
        0 => wall(0),
        f if f == cells => wall(cells - 1),
        f => hll((d[f - 1] + slopes[f - 1].0, q[f - 1] + slopes[f - 1].1), (d[f] - slopes[f].0, q[f] - slopes[f].1)),
    };
    let mut next = state.clone();
    let mut left = face(0);
    for k in 0..cells {
        let right = face(k + 1);
        let u = q[k] / d[k].max(FILM);
        let spread = if geometry.is_radial { dt / ((k as f64 + 0.5) * dx) } else { 0.0 };
        next.depth[k] = (d[k] - (dt / dx * (right.0 - left.0) + spread * q[k])).max(0.0);
        next.discharge[k] = q[k] - (dt / dx * (right.1 - left.1) + spread * q[k] * u);
        if geometry.manning > 0.0 {
            let depth = next.depth[k].max(FILM);
            let resistance = dt * GRAVITY * geometry.manning.powi(2) / depth.powf(4.0 / 3.0);
            next.discharge[k] *= 2.0 / (1.0 + (1.0 + 4.0 * resistance * (next.discharge[k] / depth).abs()).sqrt());
        }
        left = right;
    }
    next
}

fn hll((d_l, q_l): (f64, f64), (d_r, q_r): (f64, f64)) -> (f64, f64) {
    let (u_l, u_r) = (q_l / d_l.max(FILM), q_r / d_r.max(FILM));
    let (c_l, c_r) = ((GRAVITY * d_l).sqrt(), (GRAVITY * d_r).sqrt());
    let (s_l, s_r) = ((u_l - c_l).min(u_r - c_r).min(0.0), (u_l + c_l).max(u_r + c_r).max(0.0));
    let (m_l, m_r) = (q_l * u_l + 0.5 * GRAVITY * d_l * d_l, q_r * u_r + 0.5 * GRAVITY * d_r * d_r);
    let span = (s_r - s_l).max(1e-12);
    ((s_r * q_l - s_l * q_r + s_l * s_r * (d_r - d_l)) / span, (s_r * m_l - s_l * m_r + s_l * s_r * (q_r - q_l)) / span)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validation::exact::stoker;

    #[test]
    fn plane_reference_converges_to_stokers_solution() {
        let error = |cells: usize| {
            let profile = plane_dam_break((10.0, 5.0), 1000.0, (2000.0, cells), 0.0, 50.0);
            let places = (0..2000).map(|k| f64::from(k) + 0.5);
            places.map(|x| (profile.at(x).0 - stoker(10.0, 5.0, x - 1000.0, 50.0).0).abs()).sum::<f64>() / 2000.0
        };
        let (coarse, fine) = (error(500), error(2000));
        // The bore is smeared over a cell or two: first order at last.
        assert!(fine < 0.003 && coarse > 3.0 * fine, "{coarse} {fine}");
    }

    #[test]
    fn radial_references_of_both_orders_come_together() {
        let run = |accuracy, cells| radial_dam_break((2.5, 0.5), 2.5, (17.0, cells), 1.4, accuracy);
        let fine = run(Accuracy::Second, 2000);
        let difference = |profile: &Profile| {
            (0..1000).map(|k| 0.01 * (f64::from(k) + 0.5)).map(|r| (profile.at(r).0 - fine.at(r).0).abs()).sum::<f64>()
                / 1000.0
        };
        let (rough, finer) = (difference(&run(Accuracy::First, 1000)), difference(&run(Accuracy::First, 4000)));
        assert!(finer < 0.003 && rough > 2.0 * finer, "{rough} {finer}");
    }

    #[test]
    fn friction_holds_the_front_back() {
        let reach = |n: f64| plane_dam_break((10.0, 0.0), 1000.0, (2000.0, 1000), n, 30.0).reach(0.01);
        assert!(reach(0.03) < reach(0.0) - 50.0);
    }
}
