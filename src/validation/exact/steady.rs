//! Steady flow in a channel of unit width: over a bump without friction, along a slope with friction, and uniform.
//!
//! ```text
//! bump       q²/(2 g d²) + d + z_b = H,                       a hydraulic jump where q²/(g d) + d²/2 is equal on both sides
//! slope      z_b' = (q²/(g d³) − 1) d' − n² q²/d^(10/3)       for a chosen d(x)
//! uniform    u = d^(2/3) √slope / n
//! ```
//!
//! Sources: `GoutalMaurel1997` (bump), `MacDonald1997` (slope), as collected in `Delestre2013`; `Chow1959`.

use crate::scenario::GRAVITY;

/// The bump (m): 0.2 − 0.05 (x − 10)² for 8 < x < 12, else 0.
pub fn bump_bed(x: f64) -> f64 {
    (0.2 - 0.05 * (x - 10.0) * (x - 10.0)).max(0.0)
}

/// Height (m) and place (m) of the crest.
const CREST: (f64, f64) = (0.2, 10.0);

/// Which of the two depths of one energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    /// The deeper, slower one.
    Subcritical,
    /// The shallower, faster one.
    Supercritical,
}

/// A stretch of steady flow on one branch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reach {
    /// Where it ends (m).
    end: f64,
    branch: Branch,
    /// H (m).
    head: f64,
}

/// A steady flow over the bump.
#[derive(Clone, Debug, PartialEq)]
pub struct Bump {
    /// q, discharge per metre of width (m²/s), above 0.
    discharge: f64,
    /// From west to east.
    reaches: Vec<Reach>,
}

impl Bump {
    /// Flow that stays on one branch, `depth` (m) where the bed is level.
    pub fn on_one_branch(discharge: f64, depth: f64) -> Bump {
        let critical = (discharge * discharge / GRAVITY).cbrt();
        let branch = if depth > critical { Branch::Subcritical } else { Branch::Supercritical };
        Bump { discharge, reaches: vec![Reach { end: f64::INFINITY, branch, head: head(discharge, depth) }] }
    }

    /// Flow that turns supercritical at the crest and stays so.
    pub fn transcritical(discharge: f64) -> Bump {
        let head = CREST.0 + 1.5 * (discharge * discharge / GRAVITY).cbrt();
        let before = Reach { end: CREST.1, branch: Branch::Subcritical, head };
        let after = Reach { end: f64::INFINITY, branch: Branch::Supercritical, head };
        Bump { discharge, reaches: vec![before, after] }
    }

    /// Flow that turns supercritical at the crest and jumps back before the foot of the bump, `depth` (m) deep behind it.
    pub fn with_jump(discharge: f64, depth: f64) -> Bump {
        let Bump { mut reaches, .. } = Bump::transcritical(discharge);
        let tail = Reach { end: f64::INFINITY, branch: Branch::Subcritical, head: head(discharge, depth) };
        let force = |reach: &Reach, x: f64| {
            let d = branch_depth(discharge, reach, bump_bed(x));
            discharge * discharge / (GRAVITY * d) + 0.5 * d * d
        };
        // Near the crest the fast water pushes the jump down the slope; at the foot the tail water pushes it up.
        let (mut low, mut high) = (CREST.1 + 1e-6, 12.0);
        for _ in 0..100 {
            let x = 0.5 * (low + high);
            if force(&reaches[1], x) > force(&tail, x) { low = x } else { high = x }
        }
        reaches[1].end = low;
        reaches.push(tail);
        Bump { discharge, reaches }
    }

    /// Where the flow changes for the last time (m): the hydraulic jump, or the crest; infinity where it does not.
    pub fn last_change(&self) -> f64 {
        self.reaches.iter().rev().nth(1).map_or(f64::INFINITY, |reach| reach.end)
    }

    /// Depth (m) and velocity (m/s) at `x` (m).
    pub fn at(&self, x: f64) -> (f64, f64) {
        let reach = self.reaches.iter().find(|reach| x < reach.end).unwrap_or(&self.reaches[self.reaches.len() - 1]);
        let d = branch_depth(self.discharge, reach, bump_bed(x));
        (d, self.discharge / d)
    }
}

/// H above the level bed (m).
fn head(discharge: f64, depth: f64) -> f64 {
    depth + discharge * discharge / (2.0 * GRAVITY * depth * depth)
}

/// The depth (m) on a branch of the energy, at a bed elevation (m); the critical depth where the energy does not suffice.
fn branch_depth(discharge: f64, reach: &Reach, bed: f64) -> f64 {
    let critical = (discharge * discharge / GRAVITY).cbrt();
    let (mut low, mut high) = match reach.branch {
        Branch::Subcritical => (critical, reach.head.max(critical)),
        Branch::Supercritical => (1e-3 * critical, critical),
    };
    for _ in 0..200 {
        let d = 0.5 * (low + high);
        let is_too_much = head(discharge, d) > reach.head - bed;
        if is_too_much == (reach.branch == Branch::Subcritical) { high = d } else { low = d }
    }
    0.5 * (low + high)
}

/// Uniform flow on a slope: velocity (m/s) of water `depth` (m) deep.
pub fn normal_velocity(depth: f64, slope: f64, manning: f64) -> f64 {
    depth.powf(2.0 / 3.0) * slope.sqrt() / manning
}

/// Steady flow with friction whose bed is made for its depth: subcritical over 1000 m, critical far away.
///
/// d(x) = (4/g)^(1/3) [1 + ½ exp(−16 (x/1000 − ½)²)], q = 2 m²/s, n = 0.033 s·m^(−1/3).
#[derive(Clone, Debug)]
pub struct MacDonald {
    from: f64,
    cell: f64,
    bed: Vec<f64>,
}

impl MacDonald {
    /// Discharge per metre of width (m²/s).
    pub const DISCHARGE: f64 = 2.0;
    /// Manning's n (s·m^(−1/3)).
    pub const MANNING: f64 = 0.033;

    /// The bed between two places (m), integrated from the eastern end by Simpson's rule in cells of `cell` (m).
    pub fn new(from: f64, to: f64, cell: f64) -> MacDonald {
        let cells = ((to - from) / cell).ceil() as usize;
        let mut bed = vec![0.0; cells + 1];
        for k in (0..cells).rev() {
            let x = from + k as f64 * cell;
            let mean = (Self::slope(x) + 4.0 * Self::slope(x + 0.5 * cell) + Self::slope(x + cell)) / 6.0;
            bed[k] = bed[k + 1] - mean * cell;
        }
        MacDonald { from, cell, bed }
    }

    fn bell(x: f64) -> f64 {
        (-16.0 * (x / 1000.0 - 0.5).powi(2)).exp()
    }

    /// Depth (m) and velocity (m/s) at `x` (m).
    pub fn at(x: f64) -> (f64, f64) {
        let d = (4.0 / GRAVITY).cbrt() * (1.0 + 0.5 * Self::bell(x));
        (d, Self::DISCHARGE / d)
    }

    fn slope(x: f64) -> f64 {
        let (d, u) = Self::at(x);
        let rise = -(4.0 / GRAVITY).cbrt() * 0.5 * 32.0 * (x / 1000.0 - 0.5) / 1000.0 * Self::bell(x);
        let friction = (Self::MANNING * u).powi(2) / d.powf(4.0 / 3.0);
        (u * u / (GRAVITY * d) - 1.0) * rise - friction
    }

    /// Bed elevation (m) at `x` (m), linear between the ends of the cells.
    pub fn bed(&self, x: f64) -> f64 {
        let place = ((x - self.from) / self.cell).clamp(0.0, (self.bed.len() - 1) as f64);
        let k = (place as usize).min(self.bed.len() - 2);
        self.bed[k] + (place - k as f64) * (self.bed[k + 1] - self.bed[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_and_jump_are_those_of_the_benchmark() {
        let sub = Bump::on_one_branch(4.42, 2.0);
        for x in [0.0, 9.0, 10.0, 11.5, 20.0] {
            let (d, u) = sub.at(x);
            assert!((d + bump_bed(x) + u * u / (2.0 * GRAVITY) - head(4.42, 2.0)).abs() < 1e-12);
        }
        let jump = Bump::with_jump(0.18, 0.33);
        let (before, after) = (jump.at(jump.last_change() - 1e-9), jump.at(jump.last_change() + 1e-9));
        let force = |(d, u): (f64, f64)| d * u * u / GRAVITY + 0.5 * d * d;
        assert!((force(before) - force(after)).abs() < 1e-6 && before.0 < 0.6 * after.0);
        assert!((11.6..11.8).contains(&jump.last_change()), "{}", jump.last_change());
        // At the crest the flow is critical: Froude number 1.
        let (d, u) = Bump::transcritical(1.53).at(10.0);
        assert!((u / (GRAVITY * d).sqrt() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn macdonalds_bed_balances_its_depth() {
        let flow = MacDonald::new(-500.0, 1200.0, 0.5);
        let force =
            |x: f64| MacDonald::at(x).0 * MacDonald::at(x).1.powi(2) + 0.5 * GRAVITY * MacDonald::at(x).0.powi(2);
        for x in [100.0, 400.0, 700.0] {
            let (d, u) = MacDonald::at(x);
            let friction = GRAVITY * (MacDonald::MANNING * u).powi(2) / d.cbrt();
            let residual =
                force(x + 0.5) - force(x - 0.5) + GRAVITY * d * (flow.bed(x + 0.5) - flow.bed(x - 0.5)) + friction;
            assert!(residual.abs() < 1e-6, "{x}: {residual:e}");
        }
    }
}
