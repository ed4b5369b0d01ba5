//! The water beyond an open edge, from what is known there and the characteristic that arrives from inside.
//!
//! With u outwards and c = √(g d), the invariant that arrives at the edge from inside is
//!
//! ```text
//! (M40)  R = u + 2 c
//! ```
//!
//! as long as the water does not come in faster than waves run. It holds beyond as well; one condition more gives the state there:
//!
//! ```text
//! (M41)  still water d_h:     d = d_h outwards, d + u²/2g = d_h inwards  not above the critical outflow c = u = R/3, not below −c
//! (M90)  held depth d_h:      d = d_h, u = R − 2 √(g d_h)            not above the critical outflow c = u = R/3, not below −c
//! (M42)  held discharge −q:   2 c³ − R c² − g q = 0                  c not below that of critical flow, (g q)^(1/3)
//! (M43)  uniform flow:        √S d^(2/3) / n + 2 √(g d) = R          critical outflow where that would be faster
//! (M44)  rest at depth d_0:   u = 2 cos θ (c − c_0)                  a simple wave that leaves at the angle θ to the outward normal
//! (M91)  wave d_w over d_0:   u = −2 (c_w − c_0) + 2 cos θ (c − c_w) a simple wave comes in, and others leave through it
//! ```
//!
//! A section with one level η and one velocity, of area A and width T at its surface, has ω in place of 2 c:
//!
//! ```text
//! (M73)  R = u + ω,   ω(η) = ∫ √(g T/A) dη                           held discharge −Q:  ω − Q/A = R, η not below critical flow, g A³ = Q² T
//! (M76)  ω(η) = (R + ω_0)/2,   u = ω(η) − ω_0                        rest at level η_0: waves leave; u between ∓√(g A/T)
//! (M92)  η = η_h,   u = R − ω(η_h)                                   held level η_h; u between ∓√(g A/T)
//! ```
//!
//! Where the state has the same R as that inside, the flux of (M16) between both is that of the state itself to first order, and
//! that of the inside where water leaves faster than waves run. Sources: `Toro2001`. Not here: which face has which condition.

use crate::math::{clamp, larger, smaller};

/// Depth (m) and velocity outwards (m/s) on one side of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeState {
    /// Depth (m), 0 or more.
    pub depth: f64,
    /// Velocity outwards (m/s).
    pub outwards: f64,
}

impl EdgeState {
    /// R of (M40) in m/s.
    pub fn invariant(&self, g: f64) -> f64 {
        self.outwards + 2.0 * (g * self.depth).sqrt()
    }

    fn of(celerity: f64, outwards: f64, g: f64) -> Self {
        EdgeState { depth: celerity * celerity / g, outwards }
    }
}

/// The outflow over an edge behind which nothing holds the water back, c = u = R/3; dry where nothing arrives.
pub fn overfall(invariant: f64, g: f64) -> EdgeState {
    let critical = (invariant / 3.0).max(0.0);
    EdgeState::of(critical, critical, g)
}

/// The depth `held` (m, 0 or more) before an edge that faces a way with `cosine` of it across the face.
///
/// - `paid` 1, (M41): that of still water beyond. What leaves passes the edge at that depth, or as critical flow where that is all that can
///   pass. What comes in pays for its velocity with its level: d + (u/cos θ)²/2g = `held`.
/// - `paid` 0, (M90): that of the water at the edge itself, whether it comes or goes.
///
/// Between the two a share of the velocity's head is paid for. Inwards the flow is not faster than critical, u = −c cos θ, which also comes in
/// on dry ground: the state at the middle of the wave that runs onto it.
pub fn at_depth(held: f64, (cosine, paid): (f64, f64), invariant: f64, g: f64) -> EdgeState {
    let rest = (g * held).sqrt();
    if invariant >= 2.0 * rest {
        let celerity = rest.max(invariant / 3.0);
        return EdgeState::of(celerity, invariant - 2.0 * celerity, g);
    }
    // c² + k u²/2 = g held with u = R − 2 c, and at critical inflow with u = −c cos θ.
    let k = paid / (cosine * cosine);
    let critical = rest / (1.0 + 0.5 * paid).sqrt();
    if invariant <= (2.0 - cosine) * critical {
        return EdgeState::of(critical, -cosine * critical, g);
    }
    let root = ((1.0 + 2.0 * k) * rest * rest - 0.5 * k * invariant * invariant).sqrt();
    let celerity = (k * invariant + root) / (1.0 + 2.0 * k);
    EdgeState::of(celerity, invariant - 2.0 * celerity, g)
}

/// (M42): the discharge `q` (m²/s, 0 or more) comes in; `held` (m) is the depth that counts where it comes in faster than waves run.
///
/// Water inside that stands so high that it would drive a bore out against the inflow makes it subcritical.
pub fn inflow(q: f64, held: Option<f64>, invariant: f64, g: f64) -> EdgeState {
    let critical = (g * q).cbrt();
    let subcritical = (invariant > critical).then(|| subcritical_celerity(critical, invariant));
    let thrust = |c: f64| if c > 0.0 { g * q * q / (c * c) + 0.5 * (c * c) * (c * c) / g } else { 0.0 };
    let fast = held.map(|depth| (g * depth).sqrt()).filter(|&c| c > 0.0 && c < critical);
    let celerity = match (fast, subcritical) {
        (Some(fast), Some(slow)) if thrust(slow) > thrust(fast) => slow,
        (Some(fast), _) => fast,
        (None, slow) => slow.unwrap_or(critical),
    };
    let outwards = if celerity > 0.0 { -(critical / celerity) * (critical / celerity) * critical } else { 0.0 };
    EdgeState::of(celerity, outwards, g)
}

/// The strips of a section, each with its width (any unit) and its bed (m), the lowest ones first.
#[derive(Clone)]
pub struct Section<I>(pub I);

/// What a section holds below a level.
#[derive(Clone, Copy, Default)]
struct Below {
    /// A, and T at the level.
    area: f64,
    width: f64,
    /// ω (m/s).
    omega: f64,
    /// ∫ A dη.
    moment: f64,
}

impl Below {
    /// Goes on upwards, by so many metres between walls that stand upright.
    fn raised(self, by: f64, g: f64) -> Self {
        let raised = Below { area: self.area + self.width * by, ..self };
        Below {
            // √(g T/A) dη is 2 d√(g A/T) as long as T stays.
            omega: self.omega + 2.0 * (raised.celerity(g) - self.celerity(g)),
            moment: self.moment + 0.5 * (self.area + raised.area) * by,
            ..raised
        }
    }

    /// Speed of waves (m/s), √(g A/T).
    fn celerity(&self, g: f64) -> f64 {
        if self.width > 0.0 { (g * self.area / self.width).sqrt() } else { 0.0 }
    }

    /// How far above its level (m) the speed of waves is this one (m/s), between walls that stand upright.
    fn rise_to(&self, celerity: f64, g: f64) -> f64 {
        celerity * celerity / g - self.area / self.width
    }
}

impl<I: Iterator<Item = (f64, f64)> + Clone> Section<I> {
    /// Visits the strips from the lowest one up: what lies below the bed of each, its own width counted in, and that bed. A strip whose bed
    /// lies below the one before counts from there.
    fn steps(&self, g: f64) -> impl Iterator<Item = (Below, f64)> {
        self.0.clone().scan((Below::default(), f64::NEG_INFINITY), move |(below, top), (width, bed)| {
            let rise = if below.width > 0.0 { (bed - *top).max(0.0) } else { 0.0 };
            *below = below.raised(rise, g);
            below.width += width;
            *top = top.max(bed);
            Some((*below, *top))
        })
    }

    fn below(&self, level: f64, g: f64) -> Below {
        let reached = self.steps(g).take_while(|(_, bed)| *bed < level).last();
        reached.map_or(Below::default(), |(below, bed)| below.raised(level - bed, g))
    }

    /// The level (m) above which a discharge (m³/s) is slower than waves wherever it stands.
    fn critical(&self, discharge: f64, g: f64) -> f64 {
        let flows = self.steps(g).filter_map(|(below, bed)| {
            let critical = (discharge * discharge * below.width / g).cbrt();
            (critical >= below.area).then(|| bed + (critical - below.area) / below.width)
        });
        flows.last().unwrap_or(f64::NEG_INFINITY)
    }

    /// (M73): the level (m) at which the discharge (m³/s, 0 or more) comes in, before water of a level (m) and a velocity outwards (m/s), if there is
    /// any; `held` (m) is the level that counts where it comes in faster than waves run, as in [`inflow`].
    pub fn inflow(&self, discharge: f64, held: Option<f64>, before: Option<(f64, f64)>, g: f64) -> f64 {
        let critical = self.critical(discharge, g);
        let slow = before.and_then(|(level, outwards)| {
            let invariant = outwards + self.below(level, g).omega;
            self.subcritical(discharge, invariant, (critical, level), g)
        });
        let thrust = |level: f64| {
            let Below { area, moment, .. } = self.below(level, g);
            if area > 0.0 { discharge * discharge / area + g * moment } else { 0.0 }
        };
        let fast = held.filter(|level| *level < critical && self.below(*level, g).area > 0.0);
        match (fast, slow) {
            (Some(fast), Some(slow)) if thrust(slow) > thrust(fast) => slow,
            (Some(fast), _) => fast,
            (None, slow) => slow.unwrap_or(critical),
        }
    }

    /// (M76): level (m) and velocity outwards (m/s) of a simple wave that leaves into water at rest at a level (m), before water of a level (m) and
    /// a velocity outwards (m/s), if there is any; slower than waves run, or as fast.
    pub fn waves_leave(&self, rest: f64, before: Option<(f64, f64)>, g: f64) -> (f64, f64) {
        self.wave_enters((rest, rest), before, g)
    }

    /// The same where a wave of a level (m) comes in over water at rest at another level (m): its velocity is ω − ω_0 inwards, at most critical.
    pub fn wave_enters(&self, (wave, rest): (f64, f64), before: Option<(f64, f64)>, g: f64) -> (f64, f64) {
        let coming = self.below(wave, g);
        let inwards = smaller(coming.omega - self.below(rest, g).omega, coming.celerity(g));
        let still = coming.omega + inwards;
        let (top, outwards) = before.unwrap_or((f64::NEG_INFINITY, 0.0));
        let invariant = outwards + self.below(top, g).omega;
        let level = self.level_of(0.5 * (invariant + still), g);
        if invariant > still {
            let level = level.max(self.critical_of(invariant, top, g));
            return (level, invariant - self.below(level, g).omega);
        }
        let level = level.max(self.critical_of(still, wave, g));
        (level, self.below(level, g).omega - still)
    }

    /// (M92): level (m) and velocity outwards (m/s) where a level (m) is held, before water of a level (m) and a velocity outwards (m/s), if there
    /// is any; slower than waves run, or as fast.
    pub fn at_level(&self, held: f64, before: Option<(f64, f64)>, g: f64) -> (f64, f64) {
        let (top, outwards) = before.unwrap_or((f64::NEG_INFINITY, 0.0));
        let invariant = outwards + self.below(top, g).omega;
        let there = self.below(held, g);
        if invariant > there.omega {
            let level = held.max(self.critical_of(invariant, top, g));
            return (level, invariant - self.below(level, g).omega);
        }
        (held, larger(invariant - there.omega, -there.celerity(g)))
    }

    /// Whether water of a level (m) leaves with a velocity outwards (m/s) that no wave comes up against.
    pub fn is_swept(&self, (level, outwards): (f64, f64), g: f64) -> bool {
        outwards >= self.below(level, g).celerity(g)
    }

    /// The level (m) at which ω has a value (m/s); that of the lowest bed where it is none.
    fn level_of(&self, omega: f64, g: f64) -> f64 {
        let mut reached = f64::NEG_INFINITY;
        for (below, bed) in self.steps(g) {
            if reached > f64::NEG_INFINITY && below.omega >= omega {
                break;
            }
            let celerity = below.celerity(g) + 0.5 * (omega - below.omega);
            reached = if below.width > 0.0 { bed + below.rise_to(celerity.max(0.0), g).max(0.0) } else { bed };
        }
        reached
    }

    /// The highest level (m), up to that of water slower than waves, at which ω + √(g A/T) is an invariant (m/s): critical flow at the end of a
    /// wave that lowers that water.
    fn critical_of(&self, invariant: f64, top: f64, g: f64) -> f64 {
        let levels = self.steps(g).filter_map(|(below, bed)| {
            let celerity = (invariant - below.omega + 2.0 * below.celerity(g)) / 3.0;
            (below.width > 0.0 && celerity >= below.celerity(g)).then(|| bed + below.rise_to(celerity, g))
        });
        levels.filter(|level| *level <= top).last().unwrap_or(f64::NEG_INFINITY)
    }

    /// The level above the critical one at which ω − Q/A is the invariant, by Newton's method within bounds; none where it lies lower.
    fn subcritical(&self, discharge: f64, invariant: f64, (critical, before): (f64, f64), g: f64) -> Option<f64> {
        let excess = |below: &Below| below.omega - discharge / below.area - invariant;
        let is_low = |level: f64| {
            let below = self.below(level, g);
            below.area <= 0.0 || excess(&below) < 0.0
        };
        if !is_low(critical) {
            return None;
        }
        let (mut low, mut high) = (critical, critical.max(before) + 1.0);
        while is_low(high) {
            (low, high) = (high, high + 2.0 * (high - critical));
        }
        let mut level = clamp(before, low, high);
        for _ in 0..HALVINGS {
            let below = self.below(level, g);
            let excess = if below.area > 0.0 { excess(&below) } else { f64::NEG_INFINITY };
            if excess < 0.0 {
                low = level;
            } else {
                high = level;
            }
            let slope = discharge * below.width / (below.area * below.area) + (g * below.width / below.area).sqrt();
            let newton = level - excess / slope;
            if newton.to_bits() == level.to_bits() {
                break;
            }
            // Not a number compares as false.
            level = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        Some(level)
    }
}

/// The root of 2 c³ − R c² = c_c³ above c_c, by Newton's method from above, where the left side is convex.
fn subcritical_celerity(critical: f64, invariant: f64) -> f64 {
    let cube = critical * critical * critical;
    let mut c = 0.5 * invariant + critical;
    for _ in 0..MOST_ITERATIONS {
        let excess = c * c * (2.0 * c - invariant) - cube;
        let next = c - excess / (c * (6.0 * c - 2.0 * invariant));
        if next >= c || !next.is_finite() {
            break;
        }
        c = next;
    }
    c.max(critical)
}

/// Halvings of an interval of levels: a kilometre comes down to less than its rounding.
pub const HALVINGS: usize = 64;

/// Newton's method doubles its digits each time: from any start of the formulas here twenty are there long before.
const MOST_ITERATIONS: usize = 40;

/// (M43): uniform flow on a bed of this slope with g n² = `friction` (m^(1/3), positive) goes on beyond the edge.
pub fn uniform_flow(slope: f64, friction: f64, invariant: f64, g: f64) -> EdgeState {
    if invariant <= 0.0 {
        return EdgeState { depth: 0.0, outwards: 0.0 };
    }
    // u = k c^(4/3), from d = c²/g.
    let k = (g * slope / friction).sqrt() / (g * g).cbrt();
    let mut c = 0.5 * invariant;
    for _ in 0..MOST_ITERATIONS {
        let third = c.cbrt();
        let excess = k * c * third + 2.0 * c - invariant;
        let next = c - excess / (4.0 / 3.0 * k * third + 2.0);
        if next >= c || !next.is_finite() {
            break;
        }
        c = next;
    }
    let velocity = k * c * c.cbrt();
    if velocity > c { overfall(invariant, g) } else { EdgeState::of(c, velocity, g) }
}

/// (M44): still water of depth `rest` (m, positive) beyond, into which waves leave by the way that the water before the edge tells, with its velocity
/// `along` the edge (m/s); what comes in is not faster than the middle of the wave that it sends.
pub fn waves_leave(rest: f64, before: EdgeState, along: f64, g: f64) -> EdgeState {
    wave_enters((rest, rest), (1.0, 0.0), (before, along), g)
}

/// (M91): a wave of depth `wave` (m, 0 or more) comes in over still water of depth `rest` (m, 0 or more), by the way that the edge faces (its part
/// across the face, outwards, and along it), and the waves that the water before the edge shows leave through it as in [`waves_leave`].
///
/// The wave is a simple one, 2 (c_w − c_0) fast, at most critical. No more than critical flow comes in.
pub fn wave_enters(
    (wave, rest): (f64, f64),
    facing: (f64, f64),
    (before, along): (EdgeState, f64),
    g: f64,
) -> EdgeState {
    let c_w = (g * wave).sqrt();
    let inwards = smaller(2.0 * (c_w - (g * rest).sqrt()), c_w);
    let coming = -inwards * facing.0;
    let leaving = EdgeState { outwards: before.outwards - coming, ..before };
    let cosine = cosine_of_wave(c_w, leaving, along + inwards * facing.1, g);
    let invariant = leaving.invariant(g);
    let celerity = (0.5 * (invariant + 2.0 * cosine * c_w) / (1.0 + cosine)).max(0.0);
    let outwards = coming + cosine * (invariant - 2.0 * c_w) / (1.0 + cosine);
    if outwards < -celerity {
        let critical = (2.0 * cosine * c_w - coming) / (1.0 + 2.0 * cosine);
        return EdgeState::of(critical, -critical, g);
    }
    EdgeState::of(celerity, outwards, g)
}

/// cos θ of a simple wave with this state on its way out into still water of celerity `rest` (m/s). Its velocity has its direction and the size
/// 2 |c − c_0|; as far as the size is another one, as in a current along the edge, the direction says nothing, and θ is taken for 0.
fn cosine_of_wave(rest: f64, before: EdgeState, along: f64, g: f64) -> f64 {
    let (speed, of_wave) = (before.outwards.hypot(along), 2.0 * ((g * before.depth).sqrt() - rest));
    if before.outwards * of_wave <= 0.0 {
        return 1.0;
    }
    let (less, more) = (smaller(speed, of_wave.abs()), larger(speed, of_wave.abs()));
    1.0 - less / more * (1.0 - before.outwards.abs() / speed)
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 9.81;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * (1.0 + a.abs().max(b.abs()))
    }

    #[test]
    fn the_invariant_that_leaves_is_kept_by_every_condition() {
        for depth in [0.3, 2.0] {
            for outwards in [-0.4, 0.0, 0.9] {
                let inside = EdgeState { depth, outwards };
                let r = inside.invariant(G);
                let states = [
                    at_depth(1.1 * depth, (1.0, 1.0), r, G),
                    at_depth(1.1 * depth, (1.0, 0.0), r, G),
                    inflow(0.2 * depth, None, r, G),
                    uniform_flow(1e-3, G * 9e-4, r, G),
                    waves_leave(1.05 * depth, inside, 0.0, G),
                    waves_leave(0.95 * depth, inside, 0.6, G),
                    overfall(r, G),
                ];
                for state in states {
                    assert!(close(state.invariant(G), r), "{inside:?}: {state:?}");
                }
            }
        }
    }

    #[test]
    fn the_state_inside_is_found_again_where_it_fits_the_condition() {
        let (depth, velocity) = (1.3, -0.7);
        let r = EdgeState { depth, outwards: velocity }.invariant(G);
        assert!(close(inflow(-depth * velocity, None, r, G).depth, depth));
        for cosine in [1.0, 0.8, 0.5_f64.sqrt()] {
            let still = depth + (velocity / cosine) * (velocity / cosine) / (2.0 * G);
            assert!(close(at_depth(still, (cosine, 1.0), r, G).outwards, velocity), "{cosine}");
        }
        let (slope, n): (f64, f64) = (2e-3, 0.03);
        let uniform = slope.sqrt() / n * depth.cbrt().powi(2);
        let r = EdgeState { depth, outwards: uniform }.invariant(G);
        assert!(close(uniform_flow(slope, G * n * n, r, G).depth, depth));
    }

    #[test]
    fn inflow_onto_dry_ground_is_critical_or_as_held() {
        let q: f64 = 3.0;
        let critical = (q * q / G).cbrt();
        assert!(close(inflow(q, None, 0.0, G).depth, critical));
        assert!(
            close(inflow(q, Some(2.0 * critical), 0.0, G).depth, critical),
            "a slow pair says nothing of the level"
        );
        let fast = inflow(q, Some(0.5 * critical), 0.0, G);
        assert!(close(fast.depth, 0.5 * critical) && close(fast.outwards, -2.0 * q / critical));
        assert_eq!(inflow(0.0, None, 0.0, G), EdgeState { depth: 0.0, outwards: 0.0 });
    }

    #[test]
    fn deep_water_drowns_a_fast_inflow() {
        let q = 3.0;
        let deep = EdgeState { depth: 6.0, outwards: -0.5 };
        let state = inflow(q, Some(0.5), deep.invariant(G), G);
        assert!(state.depth > 5.0 && close(-state.depth * state.outwards, q));
        let shallow = EdgeState { depth: 0.9, outwards: -2.0 };
        assert!(close(inflow(q, Some(0.5), shallow.invariant(G), G).depth, 0.5));
    }

    /// A main channel of 10 m between plains of together 30 m, 2 m higher, and a strip of no width.
    const COMPOUND: [(f64, f64); 3] = [(10.0, 0.0), (0.0, 1.0), (30.0, 2.0)];

    #[test]
    fn a_section_of_one_strip_takes_a_discharge_as_a_face_does() {
        let width = 7.0;
        let section = Section(std::iter::once((width, 0.4)));
        for (depth, outwards, held) in [
            (1.3, -0.7, None),
            (1.3, 0.9, None),
            (0.2, -6.0, Some(0.8)),
            (6.0, -0.5, Some(0.5)),
            (0.9, -2.0, Some(0.5)),
        ] {
            for q in [0.0, 0.3, 3.0] {
                let face = inflow(q, held, EdgeState { depth, outwards }.invariant(G), G);
                let level = section.inflow(width * q, held.map(|d| d + 0.4), Some((depth + 0.4, outwards)), G);
                assert!((level - 0.4 - face.depth).abs() < 1e-9, "{depth} m, {q} m2/s: {level} m, {face:?}");
            }
        }
        let critical = section.inflow(width * 3.0, None, None, G);
        assert!(close(critical - 0.4, (9.0 / G).cbrt()));
    }

    #[test]
    fn a_compound_section_finds_again_the_level_that_fits_and_never_one_that_is_faster_than_waves() {
        let section = Section(COMPOUND.into_iter());
        let area = |level: f64| COMPOUND.iter().map(|(w, b)| w * (level - b).max(0.0)).sum::<f64>();
        let surface = |level: f64| COMPOUND.iter().filter(|(_, b)| *b < level).map(|(w, _)| w).sum::<f64>();
        for level in [0.7, 1.9, 2.4, 4.0] {
            let outwards = -0.4;
            let found = section.inflow(-outwards * area(level), None, Some((level, outwards)), G);
            assert!(close(found, level), "{level} m: {found} m");
        }
        for discharge in [5.0, 60.0, 80.0, 100.0, 140.0, 900.0] {
            for before in [None, Some((0.3, -7.0)), Some((1.6, -9.0)), Some((2.1, -1.0))] {
                let level = section.inflow(discharge, None, before, G);
                let froude_squared = discharge * discharge * surface(level) / (G * area(level).powi(3));
                assert!(froude_squared <= 1.0 + 1e-9, "{discharge} m3/s, {before:?}: {level} m, Fr² {froude_squared}");
            }
        }
        // 9.81 A³ = Q² T on the plains, and in the main channel.
        assert!(close(section.inflow(140.0, None, None, G), 2.0 + ((140.0 * 140.0 * 40.0 / G).cbrt() - 20.0) / 40.0));
        assert!(close(section.inflow(30.0, None, None, G), (9.0 / G).cbrt()));
    }

    #[test]
    fn a_section_of_one_strip_lets_waves_out_as_a_face_does() {
        let (bed, rest) = (0.4, 1.7);
        let section = Section(std::iter::once((7.0, bed)));
        for depth in [0.0, 0.3, 1.7, 2.9] {
            for outwards in [-3.0, -0.2, 0.0, 0.4, 2.0] {
                let inside = EdgeState { depth, outwards };
                let face = waves_leave(rest, EdgeState { outwards, ..inside }, 0.0, G);
                let (level, velocity) = section.waves_leave(rest + bed, Some((depth + bed, outwards)), G);
                // A face leaves outflow faster than waves to the flux of (M16).
                let fall = overfall(inside.invariant(G), G);
                let face = if face.outwards > fall.outwards.max(0.0) { fall } else { face };
                let is_same = (level - bed - face.depth).abs() < 1e-12 && (velocity - face.outwards).abs() < 1e-12;
                assert!(is_same, "{inside:?}: {level} m, {velocity} m/s, {face:?}");
            }
        }
        let (level, velocity) = section.waves_leave(rest + bed, None, G);
        assert!(close(level - bed, rest * 4.0 / 9.0) && close(velocity, -(G * (level - bed)).sqrt()));
    }

    #[test]
    fn simple_waves_leave_a_compound_section_as_if_there_were_no_end() {
        let section = Section(COMPOUND.into_iter());
        let froude = |(level, outwards): (f64, f64)| outwards / section.below(level, G).celerity(G);
        for rest in [0.7, 1.9, 2.05, 4.0] {
            let still = section.below(rest, G).omega;
            for level in [0.6, 1.9, 1.99, 2.01, 2.3, 4.5] {
                let wave = (level, section.below(level, G).omega - still);
                let beyond = section.waves_leave(rest, Some(wave), G);
                if froude(wave) > 1.0 {
                    assert!(section.is_swept(wave, G));
                    continue;
                }
                if level > section.critical_of(still, rest, G) {
                    assert!(close(beyond.0, wave.0) && close(beyond.1, wave.1), "{wave:?} into {rest} m: {beyond:?}");
                }
                assert!(froude(beyond).abs() <= 1.0 + 1e-9, "{wave:?} into {rest} m: {beyond:?}");
            }
            let (level, outwards) = section.waves_leave(rest, None, G);
            assert!(close(froude((level, outwards)), -1.0) && close(section.below(level, G).omega - outwards, still));
        }
    }

    #[test]
    fn nothing_leaves_faster_than_critical_and_nothing_comes_in_faster() {
        let r = EdgeState { depth: 1.0, outwards: 0.5 }.invariant(G);
        let fall = at_depth(0.0, (1.0, 1.0), r, G);
        assert!(close(fall.outwards, (G * fall.depth).sqrt()) && close(fall.invariant(G), r));
        let flood = at_depth(2.0, (1.0, 1.0), 0.0, G);
        assert!(close(flood.depth, 4.0 / 3.0) && close(flood.outwards, -(G * flood.depth).sqrt()), "a broad crest");
        let askew = at_depth(2.0, (0.8, 1.0), 0.0, G);
        let head = askew.depth + (askew.outwards / 0.8).powi(2) / (2.0 * G);
        assert!(close(head, 2.0) && close(askew.outwards, -0.8 * (G * askew.depth).sqrt()));
        let fan = waves_leave(2.0, EdgeState { depth: 0.0, outwards: 0.0 }, 0.0, G);
        assert!(
            close(fan.depth, 8.0 / 9.0) && close(fan.outwards, -(G * fan.depth).sqrt()),
            "the front of a dam break"
        );
        let steep = uniform_flow(0.2, G * 1e-4, r, G);
        assert!(close(steep.outwards, (G * steep.depth).sqrt()));
    }

    #[test]
    fn a_level_at_the_edge_is_held_whether_water_comes_or_goes() {
        let held: f64 = 1.3;
        let c = (G * held).sqrt();
        for outwards in [-0.9 * c, -0.4, 0.0, 0.7, 0.9 * c] {
            let r = EdgeState { depth: held, outwards }.invariant(G);
            let state = at_depth(held, (1.0, 0.0), r, G);
            assert!(close(state.depth, held) && close(state.outwards, outwards), "{outwards} m/s: {state:?}");
        }
        // Beyond critical flow: the state at x = 0 of the fan u − c = x/t onto dry ground, and a fall.
        let onto_dry = at_depth(held, (1.0, 0.0), 0.0, G);
        assert!(close(onto_dry.depth, held) && close(onto_dry.outwards, -c));
        let fall = at_depth(held, (1.0, 0.0), 4.5 * c, G);
        assert!(close(fall.outwards, 1.5 * c) && close(fall.depth, 2.25 * held));
        // A share of the head lies in between.
        let r = EdgeState { depth: held, outwards: -1.0 }.invariant(G);
        let depths = [0.0, 0.3, 1.0].map(|paid| at_depth(held, (1.0, paid), r, G).depth);
        assert!(depths[0] > depths[1] && depths[1] > depths[2], "{depths:?}");
    }

    #[test]
    fn what_comes_in_over_a_stair_is_what_comes_in_over_the_edge() {
        // Faces across the way and along it, of an edge of length 1 at an angle.
        for paid in [0.0, 1.0] {
            let discharge = |cosine: f64| {
                let state = at_depth(2.0, (cosine, paid), 0.0, G);
                state.depth * state.outwards
            };
            for degrees in [0.0_f64, 10.0, 30.0, 45.0] {
                let (sine, cosine) = degrees.to_radians().sin_cos();
                let of_stair = cosine * discharge(cosine) + if sine > 0.0 { sine * discharge(sine) } else { 0.0 };
                assert!(close(of_stair, discharge(1.0)), "{degrees} degrees, {paid}: {of_stair}");
            }
        }
    }

    #[test]
    fn a_wave_comes_in_through_those_that_leave() {
        let (rest, at_rest): (f64, f64) = (1.7, 0.0);
        let c = |depth: f64| (G * depth).sqrt();
        let straight = |wave: f64, before: EdgeState| wave_enters((wave, rest), (1.0, 0.0), (before, 0.0), G);
        for wave in [1.2, 1.69, 1.7, 2.4] {
            // Into still water it is a simple wave; where it stands already it goes on as it is.
            let speed = -2.0 * (c(wave) - c(rest));
            let first = straight(wave, EdgeState { depth: rest, outwards: at_rest });
            assert!(close(first.depth, wave) && close(first.outwards, speed), "{wave} m: {first:?}");
            let later = straight(wave, EdgeState { depth: wave, outwards: speed });
            assert!(close(later.depth, wave) && close(later.outwards, speed), "{wave} m: {later:?}");
            // What comes in is 4 c_w − 2 c_0 whatever leaves.
            for depth in [1.5, 1.7, 2.2] {
                let state = straight(wave, EdgeState { depth, outwards: 0.1 });
                let comes = 2.0 * c(state.depth) - state.outwards;
                assert!(close(comes, 4.0 * c(wave) - 2.0 * c(rest)), "{wave} m, {depth} m: {state:?}");
            }
            // A weak one leaves at any angle through one that is weak itself.
            for degrees in [20.0_f64, 47.0, 70.0] {
                let (sine, cosine) = degrees.to_radians().sin_cos();
                let leaving = 2.0 * (c(wave + 1e-6) - c(wave));
                let before = EdgeState { depth: wave + 1e-6, outwards: speed + leaving * cosine };
                let state = wave_enters((wave, rest), (1.0, 0.0), (before, leaving * sine), G);
                assert!((state.depth - before.depth).abs() < 1e-12, "{wave} m at {degrees} degrees: {state:?}");
            }
        }
        let high = straight(9.0, EdgeState { depth: rest, outwards: at_rest });
        assert!(close(high.outwards, -c(high.depth)) && high.depth < 9.0, "it would outrun itself: {high:?}");
        let dry = wave_enters((0.5, 0.0), (1.0, 0.0), (EdgeState { depth: 0.0, outwards: 0.0 }, 0.0), G);
        assert!(close(dry.depth, 0.5) && close(dry.outwards, -c(0.5)), "over dry ground: {dry:?}");
    }

    #[test]
    fn a_section_of_one_strip_holds_a_level_and_lets_a_wave_in_as_a_face_does() {
        let bed = 0.4;
        let section = Section(std::iter::once((7.0, bed)));
        for depth in [0.0, 0.9, 1.7, 2.6] {
            for outwards in [-2.0, -0.2, 0.0, 0.4, 2.0] {
                let before = EdgeState { depth: if outwards > 1.0 { 1.7_f64.max(depth) } else { depth }, outwards };
                let inside = Some((before.depth + bed, before.outwards));
                for level in [1.1, 1.7, 2.2] {
                    let face = at_depth(level, (1.0, 0.0), before.invariant(G), G);
                    let whole = section.at_level(level + bed, inside, G);
                    let is_same = (whole.0 - bed - face.depth).abs() < 1e-12 && (whole.1 - face.outwards).abs() < 1e-12;
                    assert!(is_same, "held {level} m, {before:?}: {whole:?}, {face:?}");
                    let face = wave_enters((level, 1.7), (1.0, 0.0), (before, 0.0), G);
                    let whole = section.wave_enters((level + bed, 1.7 + bed), inside, G);
                    let is_same = (whole.0 - bed - face.depth).abs() < 1e-12 && (whole.1 - face.outwards).abs() < 1e-12;
                    assert!(is_same || face.outwards > whole.1, "wave {level} m, {before:?}: {whole:?}, {face:?}");
                }
            }
        }
    }

    #[test]
    fn a_compound_section_holds_its_level_and_lets_its_own_waves_through() {
        let section = Section(COMPOUND.into_iter());
        let omega = |level: f64| section.below(level, G).omega;
        for level in [0.7, 1.9, 2.3, 4.0] {
            for outwards in [-0.6, 0.0, 0.5] {
                let found = section.at_level(level, Some((level, outwards)), G);
                assert!(close(found.0, level) && close(found.1, outwards), "{level} m, {outwards} m/s: {found:?}");
            }
            let dry = section.at_level(level, None, G);
            assert!(close(dry.0, level) && close(dry.1, -section.below(level, G).celerity(G)), "{level} m: {dry:?}");
            let wave = (level + 0.1, omega(level) - omega(level + 0.1));
            let found = section.wave_enters((wave.0, level), Some(wave), G);
            assert!(close(found.0, wave.0) && close(found.1, wave.1), "{wave:?} over {level} m: {found:?}");
            let first = section.wave_enters((wave.0, level), Some((level, 0.0)), G);
            assert!(close(first.0, wave.0) && close(first.1, wave.1), "{wave:?} over {level} m: {first:?}");
        }
    }

    #[test]
    fn still_water_stays_still() {
        let (depth, n) = (1.7, 0.03);
        let still = EdgeState { depth, outwards: 0.0 };
        let r = still.invariant(G);
        assert!(at_depth(depth, (1.0, 1.0), r, G).outwards.abs() < 1e-14);
        assert!(waves_leave(depth, still, 0.0, G).outwards.abs() < 1e-14);
        assert!(close(inflow(0.0, None, r, G).depth, depth));
        assert_eq!(uniform_flow(1e-3, G * n * n, -1.0, G).depth.to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn simple_waves_leave_at_any_angle_as_if_there_were_no_edge() {
        let rest = 1.7;
        for height in [-0.4, -0.01, 0.02, 0.8] {
            for degrees in [0.0_f64, 20.0, 47.0, 61.0, 80.0] {
                let depth = rest + height;
                let speed = 2.0 * ((G * depth).sqrt() - (G * rest).sqrt());
                let (sine, cosine) = degrees.to_radians().sin_cos();
                let before = EdgeState { depth, outwards: speed * cosine };
                let beyond = waves_leave(rest, before, speed * sine, G);
                let is_same = close(beyond.depth, depth) && close(beyond.outwards, before.outwards);
                assert!(is_same, "{height} m at {degrees} degrees: {beyond:?} beyond {before:?}");
            }
        }
        // A current along the edge is no wave: what leaves does so straight ahead.
        let before = EdgeState { depth: 1.75, outwards: 0.05 };
        let (beyond, straight) = (waves_leave(1.75, before, 3.0, G), waves_leave(1.75, before, 0.0, G));
        assert!(close(beyond.depth, straight.depth) && close(beyond.outwards, straight.outwards));
    }
}
