//! What passes the faces of a boundary by its condition.

use super::inside::{Inside, Passing};
use super::section;
use super::shares::{Shares, rated_level};
use super::step::{InStep, Of};
use crate::boundary::Condition;
use crate::physics::open_boundary::{inflow, uniform_flow, waves_leave};
use crate::solver::eulerian::Scale;

/// What the faces of a condition are.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::solver::eulerian) enum Faces {
    /// Those of an edge of the plane, each with its own water; with the share of what came in by the boundary that left by it again.
    OfAnEdge { returned: f64 },
    /// Strips of one section with one level and one velocity, the lowest ones first.
    OfASection,
}

/// What passes faces in a step from one time to another (s), by what is known of the water beyond; levels of a condition count from
/// `datum` (m) less than those of the faces.
pub(in crate::solver::eulerian) fn pass(
    condition: &Condition,
    (faces, inside): (Faces, &[Inside]),
    (scale, datum): (&Scale, f64),
    ((from, to), of): ((f64, f64), Of),
    passing: &mut Vec<Passing>,
) {
    let step = InStep { scale, datum, from, to, of };
    passing.clear();
    if faces != Faces::OfASection || !section::pass(condition, inside, &step, passing) {
        pass_each(condition, (faces, inside), &step, passing);
    }
}

/// What passes faces that have each its own water.
fn pass_each(
    condition: &Condition,
    (faces, inside): (Faces, &[Inside]),
    step: &InStep<'_>,
    passing: &mut Vec<Passing>,
) {
    let (scale, g) = (step.scale, step.scale.gravity);
    match condition {
        Condition::Discharge { discharge, level } => {
            let total = step.total(discharge);
            let given = level.as_ref().map(|level| step.level(level));
            let shares = Shares::new((inside, &|inside: &Inside| inside.width), total, g);
            passing.extend(inside.iter().map(|inside| {
                let q = shares.of(inside) * total * inside.facing.0;
                let held = given.map(|level| (level - inside.sill).max(0.0));
                let beyond = inflow(q, held, inside.invariant, g);
                Passing { mass: -q, ..Passing::of(beyond, g) }
            }));
        }
        Condition::Stage(series) | Condition::Level(series) => {
            let level = step.level(series);
            let paid = match (condition, faces) {
                (Condition::Level(_), Faces::OfAnEdge { returned }) => returned,
                _ => 1.0,
            };
            passing.extend(inside.iter().map(|inside| inside.held(level, paid, scale)));
        }
        Condition::Wave { level, still } => {
            let wave = step.level(level);
            let still = still.as_ref().map(|still| step.mean_level(still));
            passing.extend(inside.iter().map(|inside| inside.with_wave(wave, still, scale)));
        }
        Condition::NormalDepth { slope } => passing.extend(inside.iter().map(|inside| {
            // A part of the velocity is as much of its square in the slope.
            let across = slope * inside.facing.0 * inside.facing.0;
            inside.leaving(|| uniform_flow(across, inside.friction, inside.invariant, g), g)
        })),
        Condition::Rating(rating) => {
            let level = rated_level(rating, inside, step.datum, scale);
            passing.extend(inside.iter().map(|inside| inside.leaving(|| inside.below(level, g), g)));
        }
        Condition::Free => passing.extend(inside.iter().map(|inside| {
            match inside.rest.map(|level| level - inside.sill).filter(|depth| *depth > scale.dry_depth) {
                Some(rest) if inside.is_wet => inside.between(waves_leave(rest, inside.face, inside.along, g), g),
                Some(rest) => Passing::of(waves_leave(rest, inside.face, 0.0, g), g),
                None => inside.going_on(g),
            }
        })),
    }
}
