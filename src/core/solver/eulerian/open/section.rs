//! Conditions that hold for a cross-section as a whole: its strips have one level and one velocity.

use super::inside::{Inside, Passing};
use super::step::InStep;
use crate::boundary::Condition;
use crate::physics::open_boundary::{EdgeState, Section, SectionState};
use crate::solver::eulerian::Scale;

/// What passes the strips of a section; false where a condition holds for each strip by itself.
pub(super) fn pass(condition: &Condition, inside: &[Inside], step: &InStep<'_>, passing: &mut Vec<Passing>) -> bool {
    let (scale, g) = (step.scale, step.scale.gravity);
    let rest = || wide(inside).next().and_then(|lowest| lowest.rest);
    match condition {
        Condition::Discharge { discharge, level } => {
            let given = level.as_ref().map(|level| step.level(level));
            through_section(step.total(discharge), given, inside, g, passing);
        }
        Condition::Level(level) => hold_section(step.level(level), inside, scale, passing),
        Condition::Wave { level, still } => {
            let wave = step.level(level);
            let rest = still.as_ref().map(|still| step.mean_level(still)).or(rest());
            waves_leave_section(Some((wave, rest.unwrap_or(f64::NEG_INFINITY))), inside, scale, passing);
        }
        Condition::Free => waves_leave_section(rest().map(|rest| (rest, rest)), inside, scale, passing),
        Condition::Stage(_) | Condition::NormalDepth { .. } | Condition::Rating(_) => return false,
    }
    true
}

/// The strips of a section that have a width.
fn wide(inside: &[Inside]) -> impl Iterator<Item = &Inside> + Clone {
    inside.iter().filter(|strip| strip.width > 0.0)
}

/// The section at a face.
fn section(inside: &[Inside]) -> Section<impl Iterator<Item = (f64, f64)> + Clone> {
    Section(wide(inside).map(|strip| (strip.width, strip.sill)))
}

/// Level (m) and velocity outwards (m/s) of the water before a section, if there is any.
fn before_section(inside: &[Inside]) -> Option<SectionState> {
    let lowest = wide(inside).find(|strip| strip.is_wet);
    lowest.map(|strip| SectionState { level: strip.sill + strip.face.depth, outwards: strip.face.outwards })
}

/// A discharge `total` (m²/s times spacings) that comes in through the strips of a section, with the level (m) that counts where it is
/// faster than waves.
fn through_section(total: f64, given: Option<f64>, inside: &[Inside], g: f64, passing: &mut Vec<Passing>) {
    let (strips, before) = (section(inside), before_section(inside));
    let level = strips.inflow(total, given, before, g);
    let area: f64 = inside.iter().map(|strip| strip.width * strip.depth_at(level)).sum();
    let outwards = if area > 0.0 { -total / area } else { 0.0 };
    passing.extend(as_one(inside, SectionState { level, outwards }, g));
}

/// Waves that leave a section as a whole (M55) into water of a level (m), that at rest or that of a wave that comes in, with the level at rest;
/// where there is none the flow goes on as it arrives.
fn waves_leave_section(levels: Option<(f64, f64)>, inside: &[Inside], scale: &Scale, passing: &mut Vec<Passing>) {
    let g = scale.gravity;
    let (strips, before) = (section(inside), before_section(inside));
    let is_deep = |level: f64| wide(inside).next().is_some_and(|lowest| level - lowest.sill > scale.dry_depth);
    let levels = levels.filter(|(level, rest)| is_deep(level.max(*rest)));
    let Some(levels) = levels.filter(|_| before.is_none_or(|before| !strips.is_swept(before, g))) else {
        passing.extend(inside.iter().map(|strip| strip.going_on(g)));
        return;
    };
    passing.extend(as_one(inside, strips.wave_enters(levels, before, g), g));
}

/// (M56): a level (m) is held over a section as a whole; strip by strip where what leaves is faster than waves.
fn hold_section(level: f64, inside: &[Inside], scale: &Scale, passing: &mut Vec<Passing>) {
    let g = scale.gravity;
    let (strips, before) = (section(inside), before_section(inside));
    let is_dry = before.is_none() && wide(inside).all(|strip| strip.depth_at(level) <= scale.dry_depth);
    if is_dry || before.is_some_and(|before| strips.is_swept(before, g)) {
        passing.extend(inside.iter().map(|strip| strip.held(level, 0.0, scale)));
        return;
    }
    passing.extend(as_one(inside, strips.at_level(level, before, g), g));
}

/// What passes the strips of a section at one level (m) and one velocity outwards (m/s).
fn as_one(inside: &[Inside], state: SectionState, g: f64) -> impl Iterator<Item = Passing> {
    let SectionState { level, outwards } = state;
    inside.iter().map(move |strip| Passing::of(EdgeState { depth: strip.depth_at(level), outwards }, g))
}
