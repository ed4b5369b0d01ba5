//! The faces of the pairs: limited reconstruction, hydrostatic reconstruction, HLL Riemann problem (M12 to M16).
//!
//! For a pair i (left), j (right) with e from i to j, D q = q_j − q_i and x_ij = x_j − x_i:
//!
//! ```text
//! (M12)  a_1 = ½ φ(2 ∇η_i·x_ij − D η, D η)          a_2 likewise with ∇η_j; b_1, b_2 for u = v·e
//! (M13)  d_iR = clamp(d_i + ½ φ(2 ∇d_i·x_ij − D d, D d), 0, 2 d_i)      d_jR likewise
//! (M14)  z* = min(max(η_i + a_1 − d_iR, η_j − a_2 − d_jR), max(z_i, z_j))
//! (M15)  d_l = clamp(η_i + a_1 − z*, 0, d_iR)       d_r = clamp(η_j − a_2 − z*, 0, d_jR)
//! (M16)  (F_d, F_n) = HLL(d_l, u_i + b_1; d_r, u_j − b_2)
//! ```
//!
//! With `lax_friedrichs` the flux of that name stands for HLL, without reconstruction a, b and the slopes of d are 0, and with
//! the sharp one φ is superbee and the tangential velocity has its slope, too (decision 0009).
//!
//! The water that passes takes the tangential velocity of the particle that it leaves, which makes HLLC of HLL: F_d has the
//! sign of the contact's speed. Reconstructing it, too, sharpens the
//! shear layers in the bends of a gorge and raises the level above them further over what was observed (decision 0006).
//!
//! φ is van Leer's limiter (`VanLeer1974`), (M14) and (M15) follow `Audusse2004` with the sill limited to the higher of the
//! two beds, (M16) is `HLL1983` with the speeds of a dry side after `Toro2001`. The bound 2 d_i keeps the mirrored value
//! of the reconstruction positive.

use rayon::prelude::*;

use super::gradient::surface_difference;
use super::spans::ActiveSet;
use super::state::{FaceRow, GradientRow, GroundRow, PrimitiveRow, State};
use super::{RestingFlux, RestingMethods, Scale};
use crate::math::{clamp, larger, smaller};
use crate::physics::flux::lax_friedrichs;
use crate::physics::limiter::{superbee, van_leer};
use crate::scenario::methods::Reconstruction;

/// The two directions in which a cell owns a face.
pub(crate) const EAST: usize = 0;
pub(crate) const NORTH: usize = 1;

/// Fluxes of volume and normal momentum through a face, after `HLL1983`.
///
/// - `d_l`, `d_r` (m), 0 or more: depths left and right of the face
/// - `u_l`, `u_r` (m/s): velocities along the normal from left to right
///
/// Returns (F_d in m²/s, F_n in m³/s²); both 0 when both sides are dry.
#[inline(always)]
pub(crate) fn hll(d_l: f64, u_l: f64, d_r: f64, u_r: f64, g: f64) -> (f64, f64) {
    let (c_l, c_r) = ((g * d_l).sqrt(), (g * d_r).sqrt());
    let s_l =
        if d_l > 0.0 { smaller(u_l - c_l, if d_r > 0.0 { u_r - c_r } else { u_l - c_l }) } else { u_r - 2.0 * c_r };
    let s_r =
        if d_r > 0.0 { larger(u_r + c_r, if d_l > 0.0 { u_l + c_l } else { u_r + c_r }) } else { u_l + 2.0 * c_l };
    let (low, high) = (smaller(s_l, 0.0), larger(s_r, 0.0));
    let width = high - low;
    // Without water on either side the speeds are meaningless and may be as small as numbers get.
    let per_width = if d_l + d_r > 0.0 { 1.0 / width } else { 0.0 };
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

/// [`hll`]; with the tangential velocity from upwind it is HLLC.
struct Hllc;

impl Flux for Hllc {
    #[inline(always)]
    fn through(d_l: f64, u_l: f64, d_r: f64, u_r: f64, g: f64) -> (f64, f64) {
        hll(d_l, u_l, d_r, u_r, g)
    }
}

/// [`lax_friedrichs`], the tangential velocity from upwind, too.
struct LaxFriedrichs;

impl Flux for LaxFriedrichs {
    #[inline(always)]
    fn through(d_l: f64, u_l: f64, d_r: f64, u_r: f64, g: f64) -> (f64, f64) {
        lax_friedrichs(d_l, u_l, d_r, u_r, g)
    }
}

/// Fills the flux rows of all cells in work.
pub(crate) fn evaluate(state: &mut State, active: &ActiveSet, scale: &Scale, methods: RestingMethods) {
    let is_sharp = methods.reconstruction == Reconstruction::Sharp;
    let slopes = Slopes::of(methods.reconstruction);
    match (methods.flux, is_sharp) {
        (RestingFlux::Hllc, false) => evaluate_by::<Hllc, false>(state, active, scale, slopes),
        (RestingFlux::Hllc, true) => evaluate_by::<Hllc, true>(state, active, scale, slopes),
        (RestingFlux::LaxFriedrichs, false) => evaluate_by::<LaxFriedrichs, false>(state, active, scale, slopes),
        (RestingFlux::LaxFriedrichs, true) => evaluate_by::<LaxFriedrichs, true>(state, active, scale, slopes),
    }
}

fn evaluate_by<F: Flux, const IS_SHARP: bool>(state: &mut State, active: &ActiveSet, scale: &Scale, slopes: Slopes) {
    let (primitive, gradient, ground) = (&state.primitive, &state.gradient, &state.ground);
    state.flux.par_iter_mut().enumerate().with_min_len(4).for_each(|(row, flux)| {
        for run in &active.work[row] {
            let side = |row: usize| Side { water: &primitive[row], slope: &gradient[row], ground: &ground[row] };
            let (here, north) = (side(row), side(row + 1));
            let (from, to) = (run.start, run.end);
            let numbers = Numbers { dx: scale.spacing, g: scale.gravity, dry_depth: scale.dry_depth, slopes };
            row_faces::<F, IS_SHARP, EAST>(here, from, here, from + 1, to - from, numbers, &mut flux[EAST]);
            row_faces::<F, IS_SHARP, NORTH>(here, from, north, from, to - from, numbers, &mut flux[NORTH]);
        }
    });
}

/// Everything known of the particles of a row.
#[derive(Clone, Copy)]
struct Side<'a> {
    water: &'a PrimitiveRow,
    slope: &'a GradientRow,
    ground: &'a GroundRow,
}

/// Spacing (m), gravity (m/s²), dry depth (m) and the treatment of slopes.
#[derive(Clone, Copy)]
struct Numbers {
    dx: f64,
    g: f64,
    dry_depth: f64,
    slopes: Slopes,
}

/// How a face takes slopes, as numbers: no branch in the loop.
#[derive(Clone, Copy)]
struct Slopes {
    /// Share of the limited slopes of level, depth and normal velocity: 0 or 1.
    share: f64,
    /// The same of the tangential velocity.
    tangential: f64,
}

impl Slopes {
    fn of(reconstruction: Reconstruction) -> Self {
        match reconstruction {
            Reconstruction::Limited => Slopes { share: 1.0, tangential: 0.0 },
            Reconstruction::Sharp => Slopes { share: 1.0, tangential: 1.0 },
            Reconstruction::None => Slopes { share: 0.0, tangential: 0.0 },
        }
    }
}

/// One particle of a pair: depth, surface, bed, normal and tangential velocity, and the increments of surface, depth and
/// both velocities that its gradients predict over the pair.
#[derive(Clone, Copy)]
struct Half {
    d: f64,
    eta: f64,
    z: f64,
    u: f64,
    v_t: f64,
    rise_eta: f64,
    rise_d: f64,
    rise_u: f64,
    rise_t: f64,
}

/// Fluxes through the face of one pair: F_d, F_d v_t, and normal momentum lost by the left, gained by the right particle.
#[inline(always)]
fn pair<F: Flux, const IS_SHARP: bool>(i: Half, j: Half, numbers: Numbers) -> (f64, f64, f64, f64) {
    let Numbers { g, dry_depth, slopes, .. } = numbers;
    let jump_eta = surface_difference(i.d, i.eta, j.d, j.eta, dry_depth);
    let limited = |rise: f64, jump: f64| {
        let other = 2.0 * rise - jump;
        0.5 * if IS_SHARP { superbee(other, jump) } else { van_leer(other, jump) }
    };
    let half = |rise: f64, jump: f64| slopes.share * limited(rise, jump);
    let (a_1, a_2) = (half(i.rise_eta, jump_eta), half(j.rise_eta, jump_eta));
    let jump_d = j.d - i.d;
    let d_i = clamp(i.d + half(i.rise_d, jump_d), 0.0, 2.0 * i.d);
    let d_j = clamp(j.d - half(j.rise_d, jump_d), 0.0, 2.0 * j.d);
    let jump_u = j.u - i.u;
    let u_l = i.u + half(i.rise_u, jump_u);
    let u_r = j.u - half(j.rise_u, jump_u);
    let (eta_l, eta_r) = (i.eta + a_1, j.eta - a_2);
    let sill = smaller(larger(eta_l - d_i, eta_r - d_j), larger(i.z, j.z));
    let d_l = clamp(eta_l - sill, 0.0, d_i);
    let d_r = clamp(eta_r - sill, 0.0, d_j);
    let (f_d, f_n) = F::through(d_l, u_l, d_r, u_r, g);
    let jump_t = j.v_t - i.v_t;
    let t_i = i.v_t + slopes.tangential * limited(i.rise_t, jump_t);
    let t_j = j.v_t - slopes.tangential * limited(j.rise_t, jump_t);
    let v_t = if f_d > 0.0 { t_i } else { t_j };
    // A film gives nothing: the face before it is one of still water.
    let giver = if f_d > 0.0 { i.d } else { j.d };
    let open = if giver > dry_depth { 1.0 } else { 0.0 };
    let lost = open * (f_n - 0.5 * g * d_l * d_l) + 0.5 * g * (i.d + d_i) * a_1;
    let gained = open * (f_n - 0.5 * g * d_r * d_r) - 0.5 * g * (j.d + d_j) * a_2;
    (open * f_d, open * f_d * v_t, lost, gained)
}

#[multiversion::multiversion(targets("x86_64+avx2", "x86_64+avx512f+avx512vl"))]
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
                    &$side.water.surface[$from..][..len],
                    &$side.ground.bed[$from..][..len],
                    &$side.water.velocity_x[$from..][..len],
                    &$side.water.velocity_y[$from..][..len],
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
            let (u, v) = ($i.3[k], $i.4[k]);
            let (normal, along) = turned::<DIRECTION>(u, v);
            Half {
                d: $i.0[k],
                eta: $i.1[k],
                z: $i.2[k],
                u: normal,
                v_t: along,
                rise_eta: dx * if DIRECTION == EAST { $s.0[k] } else { $s.1[k] },
                rise_d: dx * if DIRECTION == EAST { $s.2[k] } else { $s.3[k] },
                rise_u: dx * if DIRECTION == EAST { $v.0[k] } else { $v.3[k] },
                rise_t: dx * if DIRECTION == EAST { $v.2[k] } else { $v.1[k] },
            }
        }};
    }
    for k in 0..len {
        let i = half!(k, li, ls, lv);
        let j = half!(k, ri, rs, rv);
        let (f_d, f_t, lost, gained) = pair::<F, IS_SHARP>(i, j, numbers);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_states_give_the_physical_flux() {
        let (f_d, f_n) = hll(2.0, 1.5, 2.0, 1.5, 9.81);
        assert!((f_d - 3.0).abs() < 1e-14);
        assert!((f_n - (2.0 * 1.5 * 1.5 + 0.5 * 9.81 * 4.0)).abs() < 1e-13);
    }

    #[test]
    fn dry_sides_give_no_flux() {
        assert_eq!(hll(0.0, 0.0, 0.0, 0.0, 9.81), (0.0, 0.0));
        assert_eq!(hll(0.0, 1e-320, 0.0, -1e-320, 9.81), (0.0, 0.0));
    }

    #[test]
    fn flux_mirrors_with_the_states() {
        let (f_d, f_n) = hll(3.0, 1.0, 0.5, -0.3, 9.81);
        let (b_d, b_n) = hll(0.5, 0.3, 3.0, -1.0, 9.81);
        assert!((f_d + b_d).abs() < 1e-14 && (f_n - b_n).abs() < 1e-13);
    }
}
