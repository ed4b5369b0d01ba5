//! The water beyond an open edge, from what is known there and the characteristic that arrives from inside.
//!
//! With u outwards and c = √(g d), the invariant that arrives at the edge from inside is
//!
//! ```text
//! (M37)  R = u + 2 c
//! ```
//!
//! as long as the water does not come in faster than waves run. It holds beyond as well; one condition more gives the state there:
//!
//! ```text
//! (M38)  still water d_h:     d = d_h outwards, d + u²/2g = d_h inwards  not above the critical outflow c = u = R/3, not below −c
//! (M39)  held depth d_h:      d = d_h, u = R − 2 √(g d_h)            not above the critical outflow c = u = R/3, not below −c
//! (M41)  held discharge −q:   2 c³ − R c² − g q = 0                  c not below that of critical flow, (g q)^(1/3)
//! (M42)  uniform flow:        √S d^(2/3) / n + 2 √(g d) = R          critical outflow where that would be faster
//! (M43)  rest at depth d_0:   u = 2 cos θ (c − c_0)                  a simple wave that leaves at the angle θ to the outward normal
//! (M44)  wave d_w over d_0:   u = −2 (c_w − c_0) + 2 cos θ (c − c_w) a simple wave comes in, and others leave through it
//! ```
//!
//! A section with one level η and one velocity, of area A and width T at its surface, has ω in place of 2 c:
//!
//! ```text
//! (M54)  R = u + ω,   ω(η) = ∫ √(g T/A) dη                           held discharge −Q:  ω − Q/A = R, η not below critical flow, g A³ = Q² T
//! (M55)  ω(η) = (R + ω_0)/2,   u = ω(η) − ω_0                        rest at level η_0: waves leave; u between ∓√(g A/T)
//! (M56)  η = η_h,   u = R − ω(η_h)                                   held level η_h; u between ∓√(g A/T)
//! ```
//!
//! Where the state has the same R as that inside, the flux of (M31) between both is that of the state itself to first order, and
//! that of the inside where water leaves faster than waves run. Sources: `Toro2001`. Not here: which face has which condition.

use crate::math::{clamp, larger, smaller};

/// Depth (m) and velocity outwards (m/s) on one side of an edge.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct EdgeState {
    /// Depth (m), 0 or more.
    pub depth: f64,
    /// Velocity outwards (m/s).
    pub outwards: f64,
}

impl EdgeState {
    /// R of (M37) in m/s.
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
/// - `paid` 1, (M38): that of still water beyond. What leaves passes the edge at that depth, or as critical flow where that is all that can
///   pass. What comes in pays for its velocity with its level: d + (u/cos θ)²/2g = `held`.
/// - `paid` 0, (M39): that of the water at the edge itself, whether it comes or goes.
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

/// (M41): the discharge `q` (m²/s, 0 or more) comes in; `held` (m) is the depth that counts where it comes in faster than waves run.
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

/// Level (m) and velocity outwards (m/s) of the water at a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionState {
    /// Level (m).
    pub level: f64,
    /// Velocity outwards (m/s).
    pub outwards: f64,
}

impl SectionState {
    /// No water.
    const NOTHING: SectionState = SectionState { level: f64::NEG_INFINITY, outwards: 0.0 };
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

    /// (M54): the level (m) at which the discharge (m³/s, 0 or more) comes in, before water of a level (m) and a velocity outwards (m/s), if there is
    /// any; `held` (m) is the level that counts where it comes in faster than waves run, as in [`inflow`].
    pub fn inflow(&self, discharge: f64, held: Option<f64>, before: Option<SectionState>, g: f64) -> f64 {
        let critical = self.critical(discharge, g);
        let slow = before.and_then(|SectionState { level, outwards }| {
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

    /// (M55): level (m) and velocity outwards (m/s) of a simple wave that leaves into water at rest at a level (m), before water of a level (m) and
    /// a velocity outwards (m/s), if there is any; slower than waves run, or as fast.
    pub fn waves_leave(&self, rest: f64, before: Option<SectionState>, g: f64) -> SectionState {
        self.wave_enters((rest, rest), before, g)
    }

    /// The same where a wave of a level (m) comes in over water at rest at another level (m): its velocity is ω − ω_0 inwards, at most critical.
    pub fn wave_enters(&self, (wave, rest): (f64, f64), before: Option<SectionState>, g: f64) -> SectionState {
        let coming = self.below(wave, g);
        let inwards = smaller(coming.omega - self.below(rest, g).omega, coming.celerity(g));
        let still = coming.omega + inwards;
        let SectionState { level: top, outwards } = before.unwrap_or(SectionState::NOTHING);
        let invariant = outwards + self.below(top, g).omega;
        let level = self.level_of(0.5 * (invariant + still), g);
        if invariant > still {
            let level = level.max(self.critical_of(invariant, top, g));
            return SectionState { level, outwards: invariant - self.below(level, g).omega };
        }
        let level = level.max(self.critical_of(still, wave, g));
        SectionState { level, outwards: self.below(level, g).omega - still }
    }

    /// (M56): level (m) and velocity outwards (m/s) where a level (m) is held, before water of a level (m) and a velocity outwards (m/s), if there
    /// is any; slower than waves run, or as fast.
    pub fn at_level(&self, held: f64, before: Option<SectionState>, g: f64) -> SectionState {
        let SectionState { level: top, outwards } = before.unwrap_or(SectionState::NOTHING);
        let invariant = outwards + self.below(top, g).omega;
        let there = self.below(held, g);
        if invariant > there.omega {
            let level = held.max(self.critical_of(invariant, top, g));
            return SectionState { level, outwards: invariant - self.below(level, g).omega };
        }
        SectionState { level: held, outwards: larger(invariant - there.omega, -there.celerity(g)) }
    }

    /// Whether water of a level (m) leaves with a velocity outwards (m/s) that no wave comes up against.
    pub fn is_swept(&self, SectionState { level, outwards }: SectionState, g: f64) -> bool {
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

/// (M42): uniform flow on a bed of this slope with g n² = `friction` (m^(1/3), positive) goes on beyond the edge.
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

/// (M43): still water of depth `rest` (m, positive) beyond, into which waves leave by the way that the water before the edge tells, with its velocity
/// `along` the edge (m/s); what comes in is not faster than the middle of the wave that it sends.
pub fn waves_leave(rest: f64, before: EdgeState, along: f64, g: f64) -> EdgeState {
    wave_enters((rest, rest), (1.0, 0.0), (before, along), g)
}

/// (M44): a wave of depth `wave` (m, 0 or more) comes in over still water of depth `rest` (m, 0 or more), by the way that the edge faces (its part
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
mod tests;
