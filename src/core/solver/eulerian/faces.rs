//! The faces of the pairs: limited reconstruction, hydrostatic reconstruction, Riemann problem (M19 to M21, M23 and M31).
//!
//! For a pair i (left), j (right) with e from i to j, D X = X_j − X_i and x_ij = x_j − x_i:
//!
//! ```text
//! (M19)  a_1 = ½ Λ_i(2 ∇η_i·x_ij − D η, D η)        a_2 likewise with ∇η_j; b_1, b_2 for u = v·e
//! (M20)  d_iR = clamp(d_i + ½ Λ_i(2 ∇d_i·x_ij − D d, D d), 0, 2 d_i)    d_jR likewise; but where water is drawn out, D u > 0 or one
//!        side dry: d_iR = (√d_i + ½ Λ_i(√d_i − √d_i−, D √d))², d_i− = [d_i − 2 ∇d_i·x_ij + D d]₊ the depth behind the particle
//! (M21)  z* = min(max(z_l, z_r), max(z_i, z_j)),  z_l = η_i + a_1 − d_iR, z_r = η_j − a_2 − d_jR
//! (M22)  r_l = (1 − σ_i²) min([z_r − z_l]₊, [−a_1]₊, [z_i − z_j]₊)   r_r likewise; σ_i = d_i/(d_i + s_i)
//! (M23)  d_l = clamp(η_i + a_1 + r_l − z*, 0, d_iR)   d_r = clamp(η_j − a_2 + r_r − z*, 0, d_jR)
//! (M29)  (d_l, u_l) ← the state over the sill by the head and the discharge of the water before it, no faster than beyond
//! (M24)  Ψ_l = g d_l δ clamp(2 − d_j/d_i, 0, 1)/(1 + (δ/Δ)⁴),  δ = [z* − r_l − η_j + a_2]₊ where z_i > z_j; Ψ_r likewise
//! (M32)  F_d v_t ← F_d v_t − ½ max(−Δ ∂v_t/∂t, 0) min(d_i, d_j) D v_t     not with films
//! (M31)  (F_d, F_n) = flux(d_l, u_l; d_r, u_r), u_l = u_i + b_1 and u_r = u_j − b_2 but for (M29)
//! ```
//!
//! Λ_i goes from van Leer's limiter (`VanLeer1974`) in thin water beside a step of the bed to the monotonised central mean
//! (`VanLeer1977`) on level ground, for u where Δu < 0 with κ = 1/3 (`VanLeer1985`, decision 0036). The water that passes takes the
//! tangential velocity of the particle that it leaves, by the sign of F_d, with its slope in the same measure (decision 0012). With the
//! sharp reconstruction superbee stands for the mean, and for Λ of velocities (decision 0029); with none a, b and the slopes of d are 0;
//! with `lax_friedrichs` the flux of that name stands in (M31).
//!
//! (M21) and (M23) follow `Audusse2004` with the sill limited to the higher of the two beds. The bound 2 d_i keeps the
//! mirrored value of the reconstruction positive. (M22) and (M24) are for water thinner than the steps of the bed (decision 0046;
//! `ChenNoelle2017` have the weight (M24) in full); (M32) keeps jumps straight (`SandersMoranoDruguet1998`, decision 0047).

mod together;

use rayon::prelude::*;

use super::gradient::{difference_over_sill, surface_difference};
use super::spans::ActiveSet;
use super::state::{FaceRow, GradientRow, GroundRow, PrimitiveRow, State};
use super::{EulerianMethods, Scale};
use crate::math::{clamp, larger, smaller};
use crate::methods::{Reconstruction, Stabilisation};
use crate::physics::flux::lax_friedrichs;
use crate::physics::limiter::{monotonised, superbee, van_leer};

pub(crate) use super::rows::{EAST, NORTH};
pub(super) use together::{TOGETHER, Together};

/// A side that has less than this share of the depth of the other is dry: what rounding leaves of a slope that ends at no depth is
/// a few 1e-16 of the levels.
const SLIVER: f64 = 1e-12;

/// Fluxes of volume and normal momentum through a face: that of the rarefaction which the face lies in, or beside a shock the more
/// like `HLL1983` the stronger it is.
///
/// - `d_l`, `d_r` (m), 0 or more: depths left and right of the face
/// - `u_l`, `u_r` (m/s): velocities along the normal from left to right
///
/// Returns (F_d in m²/s, F_n in m³/s²); both 0 when both sides are dry.
///
/// The state at the face is one of the wave on the side that the contact leaves behind. Where that is a rarefaction, u + 2c is that
/// of this side (`Stoker1957`); with c* = (c_l + c_r)/2 + (u_l − u_r)/4 (`Toro2001`), for a contact that goes to the right,
///
/// ```text
/// c = clamp((u_l + 2 c_l)/3, c*, c_l),  u = u_l + 2 (c_l − c),  F_d = d u,  F_n = d u² + g d²/2,  d = c²/g
/// ```
///
/// A dry side has the velocity that the water reaches at its tip, which makes c* vanish. c* is exact between two rarefactions and
/// right to the third order of the strength of a shock; a strong one on the far side decides nothing, because the flow at the
/// face is then critical, (u_l + 2 c_l)/3 > c*. A shock on the near side, c* > c_l, counts as on one side of the face or the other by
/// the sign of u_l − (c_l + c*)/2 (its own speed is u_l − (3 c* − c_l)/2, to first order of its strength); the share of this flux is c_l/c* then, and the rest that of HLL.
/// A contact that stands lets no volume pass; the deeper side is the one behind it.
#[inline(always)]
pub(crate) fn through_face(d_l: f64, u_l: f64, d_r: f64, u_r: f64, g: f64) -> (f64, f64) {
    let (d_l, d_r) = (if d_l > SLIVER * d_r { d_l } else { 0.0 }, if d_r > SLIVER * d_l { d_r } else { 0.0 });
    let (c_l, c_r) = ((g * d_l).sqrt(), (g * d_r).sqrt());
    let u_left = if d_l > 0.0 { u_l } else { u_r - 2.0 * c_r };
    let u_right = if d_r > 0.0 { u_r } else { u_l + 2.0 * c_l };
    let star = larger(0.5 * (c_l + c_r) + 0.25 * (u_left - u_right), 0.0);
    let contact = 0.5 * (u_left + u_right) + (c_l - c_r);
    // One at rest lets nothing pass and has the deeper side behind it: so does its mirror image, where depths that differ by rounding have one
    // celerity.
    let is_at_rest = contact.abs() <= 0.0;
    let is_to_right = if is_at_rest { d_l > d_r } else { contact > 0.0 };
    // Seen from the side that the contact leaves behind, towards the other.
    let (behind_d, behind_c, behind_u) = if is_to_right { (d_l, c_l, u_left) } else { (d_r, c_r, -u_right) };
    let is_past_shock = star > behind_c && behind_u < 0.5 * (star + behind_c);
    let highest = if is_past_shock { star } else { behind_c };
    let c = smaller(larger((behind_u + 2.0 * behind_c) * (1.0 / 3.0), star), highest);
    let towards = behind_u + 2.0 * (behind_c - c);
    let u = if is_to_right { towards } else { -towards };
    // By its ratio to the depth behind: water at rest keeps its depth to the last digit.
    let ratio = if behind_c > 0.0 { c / behind_c } else { 0.0 };
    let d = behind_d * (ratio * ratio);
    let (volume, momentum) = hll((d_l, c_l, u_l), (d_r, c_r, u_r), g);
    let share = if star > behind_c { behind_c / star } else { 1.0 };
    // Beside a dry side the waves of HLL have no meaning, and nothing comes from one that the contact leaves behind.
    let rest = if behind_c > 0.0 { 1.0 - share } else { 0.0 };
    let (rest_d, rest_n) = if rest > 0.0 { (rest * volume, rest * momentum) } else { (0.0, 0.0) };
    let mass = if is_at_rest { 0.0 } else { share * (d * u) };
    (mass + rest_d, share * (d * u * u + 0.5 * g * d * d) + rest_n)
}

/// The fluxes between the fastest waves that two wet sides can send, after `HLL1983`; a side is its depth, celerity and velocity.
#[inline(always)]
fn hll((d_l, c_l, u_l): (f64, f64, f64), (d_r, c_r, u_r): (f64, f64, f64), g: f64) -> (f64, f64) {
    let low = smaller(smaller(u_l - c_l, u_r - c_r), 0.0);
    let high = larger(larger(u_l + c_l, u_r + c_r), 0.0);
    let per_width = 1.0 / (high - low);
    let (q_l, q_r) = (d_l * u_l, d_r * u_r);
    let momentum_l = q_l * u_l + 0.5 * g * d_l * d_l;
    let momentum_r = q_r * u_r + 0.5 * g * d_r * d_r;
    let product = low * high;
    (
        (high * q_l - low * q_r + product * (d_r - d_l)) * per_width,
        (high * momentum_l - low * momentum_r + product * (q_r - q_l)) * per_width,
    )
}

/// A flux through a face at rest.
pub(crate) trait Flux {
    /// Fluxes of volume (m²/s) and normal momentum (m³/s²) between depths (m) and normal velocities (m/s) left and right.
    fn through(d_l: f64, u_l: f64, d_r: f64, u_r: f64, g: f64) -> (f64, f64);
}

/// [`through_face`].
struct TwoRarefactions;

impl Flux for TwoRarefactions {
    #[inline(always)]
    fn through(d_l: f64, u_l: f64, d_r: f64, u_r: f64, g: f64) -> (f64, f64) {
        through_face(d_l, u_l, d_r, u_r, g)
    }
}

/// [`lax_friedrichs`].
struct LaxFriedrichs;

impl Flux for LaxFriedrichs {
    #[inline(always)]
    fn through(d_l: f64, u_l: f64, d_r: f64, u_r: f64, g: f64) -> (f64, f64) {
        lax_friedrichs(d_l, u_l, d_r, u_r, g)
    }
}

/// Fills the flux rows of all active cells.
pub(crate) fn evaluate(state: &mut State, active: &ActiveSet, scale: &Scale, methods: EulerianMethods) {
    let is_sharp = methods.reconstruction == Reconstruction::Sharp;
    let numbers = |spacing: f64| Numbers::new(&scale.on(spacing), methods);
    match (methods.flux, is_sharp) {
        (Stabilisation::LaxFriedrichs, false) => evaluate_by::<LaxFriedrichs, false>(state, active, numbers),
        (Stabilisation::LaxFriedrichs, true) => evaluate_by::<LaxFriedrichs, true>(state, active, numbers),
        (_, false) => evaluate_by::<TwoRarefactions, false>(state, active, numbers),
        (_, true) => evaluate_by::<TwoRarefactions, true>(state, active, numbers),
    }
}

/// The same for one pair: F_d, F_d v_t, and normal momentum lost by the left, gained by the right particle.
pub(super) fn single(i: Half, j: Half, numbers: Numbers, methods: EulerianMethods) -> (f64, f64, f64, f64) {
    match (methods.flux, methods.reconstruction == Reconstruction::Sharp) {
        (Stabilisation::LaxFriedrichs, false) => pair::<LaxFriedrichs, false, false>(i, j, numbers, Sill::NONE),
        (Stabilisation::LaxFriedrichs, true) => pair::<LaxFriedrichs, true, false>(i, j, numbers, Sill::NONE),
        (_, false) => pair::<TwoRarefactions, false, false>(i, j, numbers, Sill::NONE),
        (_, true) => pair::<TwoRarefactions, true, false>(i, j, numbers, Sill::NONE),
    }
}

/// The same for a pair with a sill between its particles.
pub(super) fn over_sill(
    i: Half,
    j: Half,
    sill: Sill,
    numbers: Numbers,
    methods: EulerianMethods,
) -> (f64, f64, f64, f64) {
    match (methods.flux, methods.reconstruction == Reconstruction::Sharp) {
        (Stabilisation::LaxFriedrichs, false) => pair::<LaxFriedrichs, false, true>(i, j, numbers, sill),
        (Stabilisation::LaxFriedrichs, true) => pair::<LaxFriedrichs, true, true>(i, j, numbers, sill),
        (_, false) => pair::<TwoRarefactions, false, true>(i, j, numbers, sill),
        (_, true) => pair::<TwoRarefactions, true, true>(i, j, numbers, sill),
    }
}

/// The same for the faces between the first so many cells of a lone row.
pub(super) fn along(row: Side<'_>, cells: usize, numbers: Numbers, methods: EulerianMethods, out: &mut FaceRow) {
    let len = cells - 1;
    match (methods.flux, methods.reconstruction == Reconstruction::Sharp) {
        (Stabilisation::LaxFriedrichs, false) => {
            row_faces::<LaxFriedrichs, false, EAST>(row, 0, row, 1, len, numbers, out)
        }
        (Stabilisation::LaxFriedrichs, true) => {
            row_faces::<LaxFriedrichs, true, EAST>(row, 0, row, 1, len, numbers, out)
        }
        (_, false) => row_faces::<TwoRarefactions, false, EAST>(row, 0, row, 1, len, numbers, out),
        (_, true) => row_faces::<TwoRarefactions, true, EAST>(row, 0, row, 1, len, numbers, out),
    }
}

fn evaluate_by<F: Flux, const IS_SHARP: bool>(
    state: &mut State,
    active: &ActiveSet,
    numbers: impl Fn(f64) -> Numbers + Sync,
) {
    let (primitive, gradient, ground, spacing) = (&state.primitive, &state.gradient, &state.ground, &state.spacing);
    active.rows_of(&mut state.flux).for_each(|(row, flux)| {
        let numbers = numbers(spacing[row]);
        for run in active.pieces_of_squares(row) {
            let side = |row: usize| Side { water: &primitive[row], slope: &gradient[row], ground: &ground[row] };
            let (here, north) = (side(row), side(row + 1));
            let (from, to) = (run.start, run.end);
            row_faces::<F, IS_SHARP, EAST>(here, from, here, from + 1, to - from, numbers, &mut flux[EAST]);
            row_faces::<F, IS_SHARP, NORTH>(here, from, north, from, to - from, numbers, &mut flux[NORTH]);
        }
    });
}

/// Everything known of the particles of a row.
#[derive(Clone, Copy)]
pub(super) struct Side<'a> {
    pub water: &'a PrimitiveRow,
    pub slope: &'a GradientRow,
    pub ground: &'a GroundRow,
}

/// Spacing (m), gravity (m/s²), dry depth (m), the share of the slopes that counts, which is 1, or 0 without reconstruction, and the constants of
/// a pair: κ where water is pressed together, (M32), and the fade and the reciprocal of the height (1/m) of (M24).
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    dx: f64,
    g: f64,
    dry_depth: f64,
    slopes: f64,
    pressed_kappa: f64,
    shear_mixing: f64,
    fall_fade: f64,
    per_fall: f64,
    /// Whether cells rest: tips of depth by its root are for these.
    at_rest: bool,
}

impl Numbers {
    pub(super) fn new(scale: &Scale, methods: EulerianMethods) -> Self {
        let slopes = if methods.reconstruction == Reconstruction::None { 0.0 } else { 1.0 };
        let constants = &methods.constants;
        Numbers {
            dx: scale.spacing,
            g: scale.gravity,
            dry_depth: scale.dry_depth,
            slopes,
            pressed_kappa: constants.pressed_kappa,
            shear_mixing: constants.shear_mixing,
            fall_fade: constants.fall_fade,
            per_fall: 1.0 / (constants.fall_height * scale.spacing),
            at_rest: !methods.moves,
        }
    }
}

/// One particle of a pair: depth, bed, step of the bed, normal and tangential velocity, the increments of surface, depth and
/// both velocities that its gradients predict over the pair, and that of the tangential velocity over a spacing along the face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half {
    pub d: f64,
    pub z: f64,
    pub step: f64,
    pub u: f64,
    pub v_t: f64,
    pub rise_eta: f64,
    pub rise_d: f64,
    pub rise_u: f64,
    pub rise_t: f64,
    pub stretch_t: f64,
    /// Share of the way between the two particles that lies on this side of the face.
    pub reach: f64,
    /// What the difference of the surfaces is counted more (m), where a bank rises out of the water of this side.
    pub on_bank: f64,
}

/// The share of the way on either side of a face of the lattice.
pub(super) const HALF_WAY: f64 = 0.5;

impl Half {
    /// A padded cell in a pair along a direction of the lattice.
    pub fn of_cell(state: &State, (row, column): (usize, usize), direction: usize, dx: f64) -> Self {
        let side = Side { water: &state.primitive[row], slope: &state.gradient[row], ground: &state.ground[row] };
        Half::of_side(side, column, direction, dx)
    }

    /// The same of a cell of a padded row.
    pub fn of_side(Side { water, slope, ground }: Side<'_>, column: usize, direction: usize, dx: f64) -> Self {
        if direction == EAST {
            return Half::of_row(water, slope, ground, column, dx);
        }
        Half {
            u: water.velocity_y[column],
            v_t: water.velocity_x[column],
            rise_eta: dx * slope.surface_y[column],
            rise_d: dx * slope.depth_y[column],
            rise_u: dx * slope.v_y[column],
            rise_t: dx * slope.u_y[column],
            stretch_t: dx * slope.u_x[column],
            ..Half::of_row(water, slope, ground, column, dx)
        }
    }

    /// A cell of a row in a pair along the row.
    pub fn of_row(water: &PrimitiveRow, slope: &GradientRow, ground: &GroundRow, column: usize, dx: f64) -> Self {
        Half {
            d: water.depth[column],
            z: ground.bed[column],
            step: ground.step[column],
            u: water.velocity_x[column],
            v_t: water.velocity_y[column],
            rise_eta: dx * slope.surface_x[column],
            rise_d: dx * slope.depth_x[column],
            rise_u: dx * slope.u_x[column],
            rise_t: dx * slope.v_x[column],
            stretch_t: dx * slope.v_y[column],
            reach: HALF_WAY,
            on_bank: 0.0,
        }
    }

    /// The same seen from the other side.
    pub fn mirrored(self) -> Self {
        Half {
            u: -self.u,
            rise_eta: -self.rise_eta,
            on_bank: -self.on_bank,
            rise_d: -self.rise_d,
            // Velocity and place turn both: its slope stays.
            rise_t: -self.rise_t,
            ..self
        }
    }
}

/// Share of the monotonised central mean in the limiter of a particle, d / (d + step of the bed beside it): 1 on level ground, 0 in
/// thin water beside a sill.
#[inline(always)]
fn share_of_mean(particle: Half) -> f64 {
    let reach = particle.d + particle.step;
    if reach > 0.0 { particle.d / reach } else { 0.0 }
}

/// Depth (m) and velocity (m/s) over a sill of water that flows to it (M29).
///
/// - `d` (m), `u` (m/s): what is left of the depth above the sill, and the velocity towards it
/// - `own` (m): the depth before the sill, `d` or more
/// - `beyond` (m/s): the velocity of the particle on the other side, away from the sill
///
/// Subcritical water speeds up on its way to the crest. Without losses the head stays,
///
/// ```text
/// (M29)  d_s + q²/(2g d_s²) = E = d + u²/2g,  u_s = q/d_s,  q = min(own u, d beyond, √g (⅔ E)^(3/2))
/// ```
///
/// with the subcritical root, by two steps of Newton's method from d, which come from above. A broad crest lets no more pass than
/// the last discharge, and by d alone the water is not faster than it is beyond the sill: what is still stays still. Where u² is not
/// below g d, or q is no more than d u, the state stays as it is.
#[inline(always)]
fn on_crest((d, u): (f64, f64), own: f64, beyond: f64, g: f64) -> (f64, f64) {
    let per_g = 1.0 / g;
    let head = d + 0.5 * per_g * u * u;
    let critical = head * (2.0 / 3.0);
    let q = smaller(smaller(own * u, d * beyond), critical * (g * critical).sqrt());
    // Not without a sill, own = d, and not away from it, u < 0: own u is no more than d u then.
    let is_faster = u * u < g * d && q > d * u;
    // The cube of the critical depth of q.
    let cube = per_g * q * q;
    let nearer = |depth: f64| {
        let square = depth * depth;
        let volume = square * depth;
        let step = depth * (volume - head * square + 0.5 * cube) / (volume - cube);
        clamp(depth - step, critical, depth)
    };
    let depth = nearer(nearer(d));
    if is_faster { (depth, q / depth) } else { (d, u) }
}

/// κ of the central mean. The velocity along a pair has another where water is pressed together: bores are sharper with it, and a dry front would
/// fall behind with it where water is drawn out (decision 0036).
const CENTRAL: f64 = 0.0;

/// A sill between the two particles of a pair, higher than both beds (m): that of the face or of a part of it, and the lowest of the face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sill {
    pub level: f64,
    pub lowest: f64,
}

impl Sill {
    const NONE: Sill = Sill { level: f64::NEG_INFINITY, lowest: f64::NEG_INFINITY };
}

/// A difference towards a face, which is no more than that to the other particle where the face is farther than half way.
#[inline(always)]
fn within(value: f64, jump: f64, reach: f64) -> f64 {
    if reach > HALF_WAY { clamp(value, -jump.abs(), jump.abs()) } else { value }
}

/// The limited difference from a particle to the face, given what its gradient predicts over the pair, the difference to the other particle and the
/// [`share_of_mean`].
#[inline(always)]
fn limited<const IS_SHARP: bool>(rise: f64, jump: f64, share: f64, kappa: f64, reach: f64) -> f64 {
    let other = 2.0 * rise - jump;
    let careful = van_leer(other, jump);
    let sharper = if IS_SHARP { superbee(other, jump) } else { monotonised(other, jump, kappa) };
    within(reach * (careful + share * (sharper - careful)), jump, reach)
}

/// The same of a velocity.
#[inline(always)]
fn of_velocity<const IS_SHARP: bool>(rise: f64, jump: f64, share: f64, kappa: f64, reach: f64) -> f64 {
    if IS_SHARP {
        within(reach * superbee(2.0 * rise - jump, jump), jump, reach)
    } else {
        limited::<IS_SHARP>(rise, jump, share, kappa, reach)
    }
}

/// What the depth gains from a particle to the face, given its own depth, that across the face and the increment towards it.
#[inline(always)]
fn depth_gained<const IS_SHARP: bool>(
    (d, across): (f64, f64),
    rise: f64,
    share: f64,
    reach: f64,
    (is_drawn_out, slopes): (bool, f64),
) -> f64 {
    let jump = across - d;
    let behind = larger(d - (2.0 * rise - jump), 0.0);
    let root = d.sqrt();
    let jump_root = across.sqrt() - root;
    let rise_root = 0.5 * (root - behind.sqrt() + jump_root);
    let (rise, jump) = if is_drawn_out { (rise_root, jump_root) } else { (rise, jump) };
    let gain = slopes * limited::<IS_SHARP>(rise, jump, share, CENTRAL, reach);
    // Without a slope nothing is gained, to the last digit.
    if is_drawn_out { gain * (2.0 * root + gain) } else { gain }
}

/// Fluxes through the face of one pair: F_d, F_d v_t, and normal momentum lost by the left, gained by the right particle.
#[inline(always)]
fn pair<F: Flux, const IS_SHARP: bool, const HAS_SILL: bool>(
    i: Half,
    j: Half,
    numbers: Numbers,
    pass: Sill,
) -> (f64, f64, f64, f64) {
    let Numbers { g, dry_depth, slopes, pressed_kappa, shear_mixing, fall_fade, per_fall, at_rest, .. } = numbers;
    let jump_eta = if HAS_SILL {
        difference_over_sill((i.d, i.z), (j.d, j.z), pass.lowest, dry_depth)
    } else {
        surface_difference((i.d, i.z), (j.d, j.z), dry_depth) + (i.on_bank + j.on_bank)
    };
    let (share_i, share_j) = (share_of_mean(i), share_of_mean(j));
    // Superbee slopes of the velocity count in full, others as far as the bed lets them be sharp.
    let along = |share: f64| if IS_SHARP { 1.0 } else { share };
    let a_1 = slopes * limited::<IS_SHARP>(i.rise_eta, jump_eta, share_i, CENTRAL, i.reach);
    let a_2 = slopes * limited::<IS_SHARP>(j.rise_eta, jump_eta, share_j, CENTRAL, j.reach);
    let is_drawn_out = at_rest && !IS_SHARP && (j.u > i.u || smaller(i.d, j.d) <= dry_depth);
    let gain = (is_drawn_out, slopes);
    let d_i = clamp(i.d + depth_gained::<IS_SHARP>((i.d, j.d), i.rise_d, share_i, i.reach, gain), 0.0, 2.0 * i.d);
    let d_j = clamp(j.d + depth_gained::<IS_SHARP>((j.d, i.d), -j.rise_d, share_j, j.reach, gain), 0.0, 2.0 * j.d);
    let jump_u = j.u - i.u;
    let kappa = if jump_u < 0.0 { pressed_kappa } else { CENTRAL };
    let u_l = i.u + slopes * of_velocity::<IS_SHARP>(i.rise_u, jump_u, share_i, kappa, i.reach);
    let u_r = j.u - slopes * of_velocity::<IS_SHARP>(j.rise_u, jump_u, share_j, kappa, j.reach);
    // From levels, which are equal to the last digit in a lake at rest.
    let (eta_l, eta_r) = (i.z + i.d + a_1, j.z + j.d - a_2);
    let ridge = larger(i.z, j.z);
    // Beside a step of the bed a depth falls faster than its surface, and would leave a bed at the face that is higher than both:
    // water would hardly get over a sill.
    let fill = |d: f64, eta: f64, particle: Half, share: f64| {
        smaller(d + (1.0 - share) * larger(eta - ridge - d, 0.0), 2.0 * particle.d)
    };
    let (d_i, d_j) = (fill(d_i, eta_l, i, share_i), fill(d_j, eta_r, j, share_j));
    let sill = smaller(larger(eta_l - d_i, eta_r - d_j), ridge);
    let sill = if HAS_SILL { larger(sill, pass.level) } else { sill };
    // Where the bed falls the half slopes of two neighbours may exceed the fall between them, so that their beds at the face cross: no
    // sill to the giver (M22).
    let crossing = (eta_r - d_j) - (eta_l - d_i);
    let fall = i.z - j.z;
    let raise = |share: f64, crossing: f64, drop: f64, fall: f64| {
        (1.0 - share * share) * larger(smaller(smaller(crossing, drop), fall), 0.0)
    };
    // Under cells that move it is no more than stands out of the water of what the bed departs from a plane.
    let most = |fall: f64, half: Half| if at_rest { fall } else { smaller(fall, half.step - half.d) };
    let (fall_i, fall_j) = (most(fall, i), most(-fall, j));
    // A pass sill stands above both beds: nothing falls, and nothing mixes through the ridge.
    let (raise_l, raise_r) = if HAS_SILL {
        (0.0, 0.0)
    } else {
        (raise(share_i, crossing, -a_1, fall_i), raise(share_j, -crossing, a_2, fall_j))
    };
    let d_l = clamp(eta_l + raise_l - sill, 0.0, d_i);
    let d_r = clamp(eta_r + raise_r - sill, 0.0, d_j);
    // The weight of the water on the step that it falls over pushes the giver on (M24); not where the water below is deep: that is a
    // shore, and no fall.
    let (upper_d, lower_d, edge_d, edge, lower_eta) =
        if fall > 0.0 { (i.d, j.d, d_l, sill - raise_l, eta_r) } else { (j.d, i.d, d_r, sill - raise_r, eta_l) };
    let height = larger(edge - lower_eta, 0.0);
    let ratio = height * per_fall;
    let square = ratio * ratio;
    let fade = clamp(fall_fade - lower_d / upper_d, 0.0, 1.0);
    let weight =
        if upper_d > dry_depth && !HAS_SILL { fade * g * edge_d * height / (1.0 + square * square) } else { 0.0 };
    let (weight_i, weight_j) = (if fall > 0.0 { weight } else { 0.0 }, if fall < 0.0 { weight } else { 0.0 });
    // Water goes over the sill to the one side or to the other, or does not: seen from the side that it comes from.
    let is_to_right = smaller(i.u, j.u) > 0.0;
    let to_left = if larger(i.u, j.u) < 0.0 { -i.u } else { 0.0 };
    let (d_before, u_before, own, beyond) = if is_to_right { (d_l, u_l, d_i, j.u) } else { (d_r, -u_r, d_j, to_left) };
    let (crest_d, crest_u) = on_crest((d_before, u_before), own, beyond, g);
    // What the upright side of the sill pushes back with: the flow that leaves is faster than the one before it.
    let thrust = crest_d * crest_u * (crest_u - u_before);
    let (d_l, u_l, thrust_i) = if is_to_right { (crest_d, crest_u, thrust) } else { (d_l, u_l, 0.0) };
    let (d_r, u_r, thrust_j) = if is_to_right { (d_r, u_r, 0.0) } else { (crest_d, -crest_u, thrust) };
    let (f_d, f_n) = F::through(d_l, u_l, d_r, u_r, g);
    let jump_t = j.v_t - i.v_t;
    let t_i = i.v_t + slopes * along(share_i) * of_velocity::<IS_SHARP>(i.rise_t, jump_t, share_i, CENTRAL, i.reach);
    let t_j = j.v_t - slopes * along(share_j) * of_velocity::<IS_SHARP>(j.rise_t, jump_t, share_j, CENTRAL, j.reach);
    let v_t = if f_d > 0.0 { t_i } else { t_j };
    // What is pressed together along the face, as in a jump across it, mixes over it (M32).
    let pressed = larger(larger(-i.stretch_t, -j.stretch_t), 0.0);
    let shallower = smaller(i.d, j.d);
    let is_mixed = shallower > dry_depth && !HAS_SILL;
    let mixed = if is_mixed { shear_mixing * pressed * shallower * jump_t } else { 0.0 };
    // A film gives nothing: the face before it is one of still water.
    let giver = if f_d > 0.0 {
        i.d
    } else if f_d < 0.0 {
        j.d
    } else {
        larger(i.d, j.d)
    };
    let open = if giver > dry_depth { 1.0 } else { 0.0 };
    let lost = open * (f_n - 0.5 * g * d_l * d_l - thrust_i - weight_i) + 0.5 * g * (i.d + d_i) * a_1;
    let gained = open * (f_n - 0.5 * g * d_r * d_r - thrust_j - weight_j) - 0.5 * g * (j.d + d_j) * a_2;
    (open * f_d, open * f_d * v_t - mixed, lost, gained)
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn row_faces<F: Flux, const IS_SHARP: bool, const DIRECTION: usize>(
    left: Side<'_>,
    left_from: usize,
    right: Side<'_>,
    right_from: usize,
    len: usize,
    numbers: Numbers,
    out: &mut FaceRow,
) {
    macro_rules! columns {
        ($side:ident, $from:ident) => {
            (
                (
                    &$side.water.depth[$from..][..len],
                    &$side.ground.bed[$from..][..len],
                    &$side.water.velocity_x[$from..][..len],
                    &$side.water.velocity_y[$from..][..len],
                    &$side.ground.step[$from..][..len],
                ),
                (
                    &$side.slope.surface_x[$from..][..len],
                    &$side.slope.surface_y[$from..][..len],
                    &$side.slope.depth_x[$from..][..len],
                    &$side.slope.depth_y[$from..][..len],
                ),
                (
                    &$side.slope.u_x[$from..][..len],
                    &$side.slope.u_y[$from..][..len],
                    &$side.slope.v_x[$from..][..len],
                    &$side.slope.v_y[$from..][..len],
                ),
            )
        };
    }
    let dx = numbers.dx;
    let (li, ls, lv) = columns!(left, left_from);
    let (ri, rs, rv) = columns!(right, right_from);
    let mass = &mut out.mass[left_from..][..len];
    let tangential = &mut out.tangential[left_from..][..len];
    let normal_left = &mut out.normal_left[left_from..][..len];
    let normal_right = &mut out.normal_right[left_from..][..len];
    macro_rules! half {
        ($k:ident, $i:ident, $s:ident, $v:ident) => {{
            let k = $k;
            let (u, v) = ($i.2[k], $i.3[k]);
            let (normal, along) = turned::<DIRECTION>(u, v);
            Half {
                d: $i.0[k],
                z: $i.1[k],
                step: $i.4[k],
                u: normal,
                v_t: along,
                rise_eta: dx * if DIRECTION == EAST { $s.0[k] } else { $s.1[k] },
                rise_d: dx * if DIRECTION == EAST { $s.2[k] } else { $s.3[k] },
                rise_u: dx * if DIRECTION == EAST { $v.0[k] } else { $v.3[k] },
                rise_t: dx * if DIRECTION == EAST { $v.2[k] } else { $v.1[k] },
                stretch_t: dx * if DIRECTION == EAST { $v.3[k] } else { $v.0[k] },
                reach: HALF_WAY,
                on_bank: 0.0,
            }
        }};
    }
    for k in 0..len {
        let i = half!(k, li, ls, lv);
        let j = half!(k, ri, rs, rv);
        let (f_d, f_t, lost, gained) = pair::<F, IS_SHARP, false>(i, j, numbers, Sill::NONE);
        mass[k] = f_d;
        tangential[k] = f_t;
        normal_left[k] = lost;
        normal_right[k] = gained;
    }
}

/// Components of a vector along the normal of a direction and along its tangent: (x, y) to the east, (y, x) to the north.
#[inline(always)]
pub(crate) fn turned<const DIRECTION: usize>(x: f64, y: f64) -> (f64, f64) {
    if DIRECTION == EAST { (x, y) } else { (y, x) }
}

/// The same for a direction that is known when it runs.
#[inline]
pub(crate) fn turned_by(direction: usize, x: f64, y: f64) -> (f64, f64) {
    if direction == EAST { turned::<EAST>(x, y) } else { turned::<NORTH>(x, y) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::flux::exact::ExactRiemann;
    use proptest::prelude::*;

    const G: f64 = 9.81;

    #[test]
    fn water_speeds_up_over_a_sill_without_losses() {
        // 2 m of water at 0.5 m/s before a sill that leaves 1.2 m of it: E = 1.2 m + 0.0127 m, q = 1 m²/s.
        let (d, u) = on_crest((1.2, 0.5), 2.0, 9.0, G);
        assert!(
            (d * u - 1.0).abs() < 1e-15 && (d + u * u / (2.0 * G) - 1.2 - 0.25 / (2.0 * G)).abs() < 1e-4,
            "{d} m, {u} m/s"
        );
        // No more than critical flow, no faster than beyond, and nothing where there is no sill.
        let (d, u) = on_crest((0.3, 0.5), 2.0, 9.0, G);
        let critical = (0.3 + 0.25 / (2.0 * G)) * 2.0 / 3.0;
        assert!((d * u - critical * (G * critical).sqrt()).abs() < 1e-15 && d > critical && d < 1.1 * critical);
        let (d, u) = on_crest((1.2, 0.5), 2.0, 0.6, G);
        assert!((d * u - 0.72).abs() < 1e-15);
        for as_it_was in [
            ((1.2, 0.5), 1.2, 9.0),
            ((1.2, 0.5), 2.0, 0.4),
            ((1.2, -0.5), 2.0, 9.0),
            ((0.3, 2.0), 2.0, 9.0),
            ((0.0, 0.5), 2.0, 9.0),
        ] {
            let (state, own, beyond) = as_it_was;
            assert_eq!(on_crest(state, own, beyond, G), state);
        }
    }

    #[test]
    fn equal_states_give_the_physical_flux() {
        let (f_d, f_n) = through_face(2.0, 1.5, 2.0, 1.5, G);
        assert!((f_d - 3.0).abs() < 1e-14);
        assert!((f_n - (2.0 * 1.5 * 1.5 + 0.5 * G * 4.0)).abs() < 1e-13);
    }

    #[test]
    fn dry_sides_give_no_flux() {
        assert_eq!(through_face(0.0, 0.0, 0.0, 0.0, G), (0.0, 0.0));
        for sign in [1.0, -1.0] {
            assert_eq!(through_face(0.0, sign * 1e-320, 0.0, -sign * 1e-320, G), (0.0, 0.0));
        }
        // Water that runs away from dry ground faster than it can spread gives nothing, whatever velocity the dry side has.
        assert_eq!(through_face(0.0, -9.76, 0.4, 9.04, G), (0.0, 0.0));
    }

    #[test]
    fn a_dam_on_dry_bed_gives_the_flux_of_ritter() {
        let (f_d, f_n) = through_face(10.0, 0.0, 0.0, 0.0, G);
        let (d, u) = (40.0 / 9.0, 2.0 / 3.0 * (10.0 * G).sqrt());
        assert!((f_d - d * u).abs() < 1e-12 && (f_n - (d * u * u + 0.5 * G * d * d)).abs() < 1e-11);
    }

    #[test]
    fn flux_is_continuous_where_a_rarefaction_turns_into_a_shock() {
        // A rarefaction to the left alone: the other wave is about to turn from a rarefaction into a shock.
        let (d_l, u_l, d_r) = (2.0_f64, 0.5, 1.9_f64);
        let simple = u_l + 2.0 * ((G * d_l).sqrt() - (G * d_r).sqrt());
        let (spread, met) =
            (through_face(d_l, u_l, d_r, simple + 1e-9, G), through_face(d_l, u_l, d_r, simple - 1e-9, G));
        assert!((spread.0 - met.0).abs() < 1e-7 && (spread.1 - met.1).abs() < 1e-7);
    }

    #[test]
    fn a_standing_contact_lets_nothing_pass_and_has_the_mirror_image_of_its_mirror_image() {
        // Depths one digit apart, of one celerity, and water that meets its mirror image.
        let next = |d: f64| f64::from_bits(d.to_bits() + 1);
        let d =
            (1..100).map(|k| 0.1 * f64::from(k)).find(|d| (G * d).sqrt().to_bits() == (G * next(*d)).sqrt().to_bits());
        let d = d.expect("two depths of one celerity");
        let states = [(d, 0.0, next(d), 0.0), (next(d), 0.0, d, 0.0), (1.0, 0.3, 1.0, -0.3), (1.0, -0.3, 1.0, 0.3)];
        for (d_l, u_l, d_r, u_r) in states {
            let (volume, momentum) = through_face(d_l, u_l, d_r, u_r, G);
            let (back, mirrored) = through_face(d_r, -u_r, d_l, -u_l, G);
            let bits = [volume.abs(), back.abs(), momentum].map(f64::to_bits);
            assert_eq!(bits, [0.0, 0.0, mirrored].map(f64::to_bits), "{d_l} {u_l} {d_r} {u_r}");
        }
    }

    #[test]
    fn a_wall_is_struck_as_hard_as_by_a_reflected_bore() {
        let d: f64 = 1.0;
        for u in [1.0_f64, 3.0, 4.1, 4.3, 6.0, 9.0] {
            // Over a depth d' the bore runs back with the water at rest behind it: u² = g (d' − d)² (d' + d)/(2 d d').
            let (mut low, mut high) = (d, 100.0);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                let speed = (middle - d) * (G * (middle + d) / (2.0 * d * middle)).sqrt();
                (low, high) = if speed < u { (middle, high) } else { (low, middle) };
            }
            let (exact, thrust) = (0.5 * G * low * low, through_face(d, u, d, -u, G).1);
            println!("{u} m/s: {:.3} of the thrust of the bore", thrust / exact);
            assert!((0.9..1.5).contains(&(thrust / exact)), "{u} m/s: {thrust} of {exact}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_algorithm: prop::test_runner::RngAlgorithm::ChaCha, failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

        #[test]
        fn flux_mirrors_with_the_states(
            d_l in 0.0..50.0_f64, d_r in 0.0..50.0_f64, u_l in -30.0..30.0_f64, u_r in -30.0..30.0_f64,
        ) {
            let (f_d, f_n) = through_face(d_l, u_l, d_r, u_r, G);
            let (b_d, b_n) = through_face(d_r, -u_r, d_l, -u_l, G);
            // Rounding of terms as large as those of either side.
            prop_assert!((f_d + b_d).abs() <= 1e-10 && (f_n - b_n).abs() <= 1e-8);
        }

        #[test]
        fn water_over_a_sill_is_a_subcritical_state_of_no_more_discharge(
            own in 1e-9..50.0_f64, left in 0.0..1.0_f64, froude in 0.0..1.0_f64, beyond in 0.0..30.0_f64,
        ) {
            let d = own * left;
            // Up to where the water above the sill is all but critical.
            let u = froude * (G * d).sqrt();
            let (depth, velocity) = on_crest((d, u), own, beyond, G);
            prop_assert!(depth.is_finite() && velocity.is_finite() && depth >= 0.0 && depth <= d && velocity >= u, "{depth} m, {velocity} m/s");
            prop_assert!(depth * velocity <= own * u * (1.0 + 1e-12) + 1e-300);
            prop_assert!(velocity <= (G * depth).sqrt() * (1.0 + 1e-9), "{velocity} m/s in {depth} m");
        }

        #[test]
        fn two_rarefactions_are_exact(
            d_l in 1e-3..50.0_f64, d_r in 1e-3..50.0_f64, u_l in -30.0..30.0_f64, apart in 0.0..40.0_f64,
        ) {
            // So fast apart that neither wave is a shock, whatever the depths.
            let u_r = u_l + apart + 2.0 * ((G * d_l).sqrt() - (G * d_r).sqrt()).abs();
            let (f_d, f_n) = through_face(d_l, u_l, d_r, u_r, G);
            let (d, u) = ExactRiemann::solve(d_l, u_l, d_r, u_r, G).sample(0.0);
            let (e_d, e_n) = (d * u, d * u * u + 0.5 * G * d * d);
            prop_assert!((f_d - e_d).abs() <= 1e-9 * (1.0 + e_d.abs()) && (f_n - e_n).abs() <= 1e-8 * (1.0 + e_n));
        }
    }
}
