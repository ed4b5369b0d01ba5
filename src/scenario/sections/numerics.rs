//! `numerics`: methods by family, and their numbers.

use crate::error::{Problem, ProblemKind};
use crate::scenario::choices::{Choice, Chosen};
use crate::scenario::defaults::{DRY_DEPTH, GRAVITY};
use crate::scenario::fields::{Courant, Gravity, Length, Quantity};
use crate::scenario::methods::{
    BedMethod, BedSlope, Core, Formulation, Integrator, Kernel, Method, Motion, Preset, Reconstruction, Seeding,
    Stabilisation, Turbulence, WallMethod,
};
use crate::scenario::model::{Numerics, Scenario};
use crate::scenario::read::{Reader, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, quantity};
use floodsim_core::constants::Constants;

section! {
    /// Methods by family, each with a default, and their numbers. A combination that does not exist is refused.
    NumericsSection, example "{cfl: 0.5}", check check_methods {
        /// A named set of the choices below, of which each key beside it changes one; the defaults of the keys, which are those
        /// of `balanced`, when absent. Codes: method-combination.
        preset: Option<Chosen<Preset>>,
        /// SPH form of the equations: well-balanced with Riemann problems, or the classic variational form; balanced when absent.
        /// Codes: method-combination.
        formulation: Option<Chosen<Formulation>>,
        /// Particles fixed on the riverbed (`eulerian`), or that move with the water (`lagrangian`); eulerian, but lagrangian
        /// with `formulation: variational`, when absent. Codes: method-combination, nothing-moves.
        motion: Option<Chosen<Motion>>,
        /// What keeps the flow between a pair of particles stable; `two_rarefactions`, but `artificial_viscosity` in `variational`, when
        /// absent. Codes: method-combination.
        stabilisation: Option<Chosen<Stabilisation>>,
        /// States on both sides of a face: along limited gradients, along sharper ones, or those of the particles; limited, but
        /// none with `artificial_viscosity`, when absent. Codes: method-combination.
        reconstruction: Option<Chosen<Reconstruction>>,
        /// Particles at the start: one in each wet cell, or all of one volume (in `variational`); lattice when absent. Codes: method-combination.
        seeding: Option<Chosen<Seeding>>,
        /// Smoothing kernel of `variational`; wendland_c2 when absent. Codes: method-combination.
        kernel: Option<Chosen<Kernel>>,
        /// Time integration; `heun`, but `leapfrog` in `variational`, when absent. Codes: method-combination.
        integrator: Option<Chosen<Integrator>>,
        /// Bed of a cell: mean of its terrain, elevation at its centre, kernel mean, or best quadratic; mean when absent. Codes:
        /// steps-in-cells.
        bed: Option<Chosen<BedMethod>>,
        /// Effect of the slope of the bed: by the weight of the water alone, or with the inertia of the vertical motion (in
        /// `variational` only); hydrostatic when absent. Codes: method-combination.
        bed_slope: Option<Chosen<BedSlope>>,
        /// Mixing in the plane: none, or by a mixing length of half the depth (Eulerian particles only); none when absent. Codes:
        /// method-combination.
        turbulence: Option<Chosen<Turbulence>>,
        /// What stands for a wall in `variational`: mirror images, or rows of fixed particles that brake the water;
        /// mirror when absent. Codes: method-combination.
        wall: Option<Chosen<WallMethod>>,
        /// Courant number, at most 0.6, in `variational` 1; 0.5, in `variational` 0.4, when absent. Codes: method-combination.
        cfl: Option<Quantity<Courant>>,
        /// Acceleration of gravity (m/s²); 9.81 m/s² when absent.
        gravity: Option<Quantity<Gravity>>,
        /// Depth below which water does not flow; 1 mm when absent.
        dry_depth: Option<Quantity<Length>>,
    }
}

/// The greatest Courant number at which the balanced formulation holds in the suite of stability (cases `cfl_02` to `cfl_16`).
const GREATEST_COURANT_OF_CELLS: f64 = 0.6;

/// A number as it is written; none where there is none, or something that is no number, which is reported elsewhere.
fn number(node: &Node, key: &str) -> Option<f64> {
    match &node.get(key)?.value {
        Value::Text(text) => text.parse().ok(),
        _ => None,
    }
}

/// A method as the scenario means it: the one written, or the usual one. None where the written name is unknown, which is
/// reported elsewhere and must not draw further problems after it.
pub(super) fn meant<T: Choice>(node: &Node, key: &str, usual: T) -> Option<T> {
    match node.get(key).map(|value| &value.value) {
        None | Some(Value::Empty) => Some(usual),
        Some(Value::Text(text)) => T::choices().into_iter().find(|(name, _)| name == text).map(|(_, method)| method),
        Some(_) => None,
    }
}

/// Refuses combinations of methods that do not exist: no core ignores what the scenario says.
fn check_methods(node: &Node, reader: &mut Reader) -> Option<()> {
    let formulation = meant(node, "formulation", Formulation::default())?;
    let motion = meant(node, "motion", formulation.usual_motion())?;
    let core = Core::of(formulation, motion);
    let written = written_methods(node);
    let mut is_fit = true;
    for method in written.iter().filter(|method| !method.cores.contains(&core)) {
        reader.report(method.node, refusal(core, method, &written));
        is_fit = false;
    }
    let courant = number(node, "cfl").filter(|courant| *courant > GREATEST_COURANT_OF_CELLS && *courant <= 1.0);
    if let (Core::Eulerian | Core::Lagrangian, Some(_), Some(value)) = (core, courant, node.get("cfl")) {
        let message =
            format!("the balanced formulation is unstable beyond a Courant number of {GREATEST_COURANT_OF_CELLS}");
        let problem = Problem::error(ProblemKind::Scenario, "method-combination", value.key.clone(), message)
            .with_cause("in two dimensions water leaves through faces of both directions: 0.5 is safe, 0.8 degrades, 1 breaks down")
            .with_remedy("write `cfl: 0.5`, or leave it out");
        reader.report(value, problem);
        is_fit = false;
    }
    is_fit.then_some(())
}

/// A method that is written under a key, and the cores that have it.
struct Written<'a> {
    key: &'static str,
    node: &'a Node,
    name: &'a str,
    cores: &'static [Core],
    why_not_elsewhere: &'static str,
}

/// The methods of the families that not all cores share, as far as they are written and known.
fn written_methods(section: &Node) -> Vec<Written<'_>> {
    let all = [
        written_as::<Motion>(section, "motion"),
        written_as::<Stabilisation>(section, "stabilisation"),
        written_as::<Reconstruction>(section, "reconstruction"),
        written_as::<Integrator>(section, "integrator"),
        written_as::<Seeding>(section, "seeding"),
        written_as::<Kernel>(section, "kernel"),
        written_as::<WallMethod>(section, "wall"),
        written_as::<BedSlope>(section, "bed_slope"),
        written_as::<Turbulence>(section, "turbulence"),
    ];
    all.into_iter().flatten().collect()
}

fn written_as<'a, T: Choice + Method>(section: &'a Node, key: &'static str) -> Option<Written<'a>> {
    let node = section.get(key)?;
    let Value::Text(name) = &node.value else { return None };
    let (_, method) = T::choices().into_iter().find(|(known, _)| known == name)?;
    Some(Written { key, node, name, cores: method.cores(), why_not_elsewhere: method.why_not_elsewhere() })
}

/// The problem of a method that a core does not have. Its remedy names the cores that have all that is written.
fn refusal(core: Core, method: &Written<'_>, written: &[Written<'_>]) -> Problem {
    let has_all = |other: &&Core| written.iter().all(|own| own.key == "motion" || own.cores.contains(other));
    let others = Core::ALL.iter().filter(has_all).map(|other| format!(", or write `{}`", other.asked_for_by()));
    // A preset has the place of what it sets.
    let written_as = method.node.key.rsplit('.').next().unwrap_or(method.key);
    let message = format!("{} have no `{}: {}`", core.particles(), method.key, method.name);
    Problem::error(ProblemKind::Scenario, "method-combination", method.node.key.clone(), message)
        .with_cause(method.why_not_elsewhere)
        .with_remedy(format!("leave `{written_as}` out{}", others.collect::<String>()))
}

pub(super) fn resolved(section: Option<&NumericsSection>) -> Numerics {
    let formulation =
        section.and_then(|s| s.formulation.as_ref()).map_or(Formulation::default(), |chosen| chosen.0.value);
    let usual_motion = formulation.usual_motion();
    let motion = section.and_then(|s| s.motion.as_ref()).map_or(usual_motion, |chosen| chosen.0.value);
    let core = Core::of(formulation, motion);
    let usual_pairs = core.usual_stabilisation();
    let stabilisation = section.and_then(|s| s.stabilisation.as_ref()).map_or(usual_pairs, |chosen| chosen.0.value);
    let usual_states = stabilisation.usual_reconstruction();
    let (usual_integrator, usual_cfl) = core.usual_integration();
    Numerics {
        formulation,
        motion,
        stabilisation,
        reconstruction: section.and_then(|s| s.reconstruction.as_ref()).map_or(usual_states, |chosen| chosen.0.value),
        seeding: section.and_then(|s| s.seeding.as_ref()).map_or(Seeding::default(), |chosen| chosen.0.value),
        kernel: section.and_then(|s| s.kernel.as_ref()).map_or(formulation.usual_kernel(), |chosen| chosen.0.value),
        integrator: section.and_then(|s| s.integrator.as_ref()).map_or(usual_integrator, |chosen| chosen.0.value),
        bed_slope: section.and_then(|s| s.bed_slope.as_ref()).map_or(BedSlope::default(), |chosen| chosen.0.value),
        turbulence: section.and_then(|s| s.turbulence.as_ref()).map_or(Turbulence::default(), |chosen| chosen.0.value),
        wall: section.and_then(|s| s.wall.as_ref()).map_or(WallMethod::default(), |chosen| chosen.0.value),
        bed: section.and_then(|s| s.bed.as_ref()).map_or(BedMethod::default(), |chosen| chosen.0.value),
        cfl: section.and_then(|s| s.cfl.as_ref()).map_or(usual_cfl, |cfl| cfl.value()),
        gravity: section.and_then(|s| s.gravity.as_ref()).map_or(GRAVITY, |gravity| gravity.value()),
        dry_depth: section.and_then(|s| s.dry_depth.as_ref()).map_or(DRY_DEPTH, |depth| depth.value()),
        constants: Constants::DEFAULT,
        sleeps: true,
    }
}

pub(super) fn written(scenario: &Scenario) -> Section {
    let numerics = &scenario.numerics;
    let has_maps = !scenario.is_channels_alone();
    Section::default()
        .with("formulation", numerics.formulation.name())
        .with("motion", numerics.motion.name())
        .with("stabilisation", numerics.stabilisation.name())
        .with("reconstruction", numerics.reconstruction.name())
        .with("seeding", numerics.seeding.name())
        .with("kernel", numerics.kernel.name())
        .with("integrator", numerics.integrator.name())
        .with_some("bed", has_maps.then(|| numerics.bed.name()))
        .with_some("turbulence", has_maps.then(|| numerics.turbulence.name()))
        .with("bed_slope", numerics.bed_slope.name())
        .with("wall", numerics.wall.name())
        .with("cfl", numerics.cfl)
        .with("gravity", quantity(numerics.gravity, "m/s2"))
        .with("dry_depth", quantity(numerics.dry_depth, "m"))
}
