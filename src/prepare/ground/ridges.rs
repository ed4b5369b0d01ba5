//! Ridges of the terrain that are narrower than a cell: their pass sills (M10), and what is reported of them.

use super::Ground;
use super::change::{Change, Made, Shaped};
use crate::bed::{BedParticles, PassSills, Pixels, SHUT, ground_in_gaps, noise_in_cells};
use crate::error::{Problem, ProblemKind};
use crate::math::Vec2;
use crate::output::{Ridge, SetBy};
use crate::prepare::findings::Findings;
use crate::scenario::Scenario;

/// Ridges that rise less than this (m) above both beds are the noise of the terrain, and not reported.
const WORTH_A_WORD: f64 = 0.1;

/// The ground of the gap in cells in gaps of ridges; before anything is built on the terrain, which may close them.
pub fn lower_gaps(scenario: &Scenario, ground: &Ground<'_>) -> Vec<Change> {
    let is_known = scenario.numerics.has_cells();
    let cells = if is_known { ground_in_gaps(&ground.surface(), ground.bed()) } else { Vec::new() };
    let is_filled = |cell: usize| ground.set_by()[cell] == SetBy::FilledGap.code();
    let by = |cell| if is_filled(cell) { SetBy::FilledGap } else { SetBy::RidgeGap };
    cells.into_iter().map(|(cell, z)| Change { cell, made: Made::Bed(z), by: by(cell) }).collect()
}

/// The pass sills of a bed. The variational formulation knows none.
pub fn find(scenario: &Scenario, surface: &impl Pixels, bed: &BedParticles) -> PassSills {
    if scenario.numerics.has_cells() { PassSills::find(surface, bed) } else { PassSills::default() }
}

/// Finds those anew of the cells whose bed changed.
///
/// - `before`: the bed (m) for which they were found
pub fn find_again(
    scenario: &Scenario,
    (surface, before): (&impl Pixels, &[f64]),
    bed: &BedParticles,
    passes: &mut PassSills,
) {
    if !scenario.numerics.has_cells() {
        return;
    }
    #[expect(clippy::float_cmp, reason = "a bed that did not change is the same number")]
    let is_changed = |cell: &usize| bed.has_terrain(*cell) && bed.elevation[*cell] != before[*cell];
    let changed: Vec<usize> = (0..bed.lattice.len()).filter(is_changed).collect();
    if !changed.is_empty() {
        passes.find_again(&changed, surface, bed);
    }
}

/// The ridges that are worth a word, as lines; warns of them.
pub fn report(scenario: &Scenario, surface: &Shaped<'_>, bed: &BedParticles, findings: &mut Findings) -> Vec<Ridge> {
    let has_cells = scenario.numerics.has_cells();
    let unseen = if has_cells { PassSills::default() } else { PassSills::find(surface, bed) };
    let passes = if has_cells { &bed.passes } else { &unseen };
    let ridges: Vec<Ridge> = lines(passes, bed).filter(|ridge| rise(ridge) >= WORTH_A_WORD).collect();
    let Some(highest) = ridges.iter().max_by(|a, b| finite_rise(a).total_cmp(&finite_rise(b))) else { return ridges };
    let (faces, spacing) = (ridges.len(), bed.lattice.spacing);
    let length = faces as f64 * spacing;
    let length = if length < 1000.0 { format!("{length:.0} m") } else { format!("{:.1} km", 1e-3 * length) };
    let faces = if faces == 1 { "1 face carries".into() } else { format!("{faces} faces carry") };
    let shut = ridges.iter().filter(|ridge| ridge.sill.is_none()).count();
    let without_data =
        if shut > 0 { format!("; {shut} of them are shut by pixels without data") } else { String::new() };
    let height = highest.crest.map_or(String::new(), |crest| {
        format!("; the highest rises {:.2} m above the bed on both sides, to {crest:.2} m", rise(highest))
    });
    let open = ridges.iter().filter(|ridge| ridge.open < 1.0).count();
    let gaps = if open > 0 { format!("; {open} of these faces are partly open, by gaps") } else { String::new() };
    let message = format!("{faces} a ridge that the cells do not see ({length}){height}{gaps}{without_data}");
    let noise = noise_in_cells(surface, &bed.lattice).map_or(String::new(), |[median, most]| {
        format!("; inside a cell the terrain scatters by {median:.2} m about a plane (median), by {most:.2} m or less in 95 % of the cells")
    });
    let held = if has_cells {
        "water passes them at their lowest place, and gaps by their width"
    } else {
        "the particles of the variational formulation pass them unhindered"
    };
    let remedy = if has_cells {
        "look at the layer `ridges` of results.gpkg; choose a finer `resolution` where a levee or its gaps decide"
    } else {
        "leave `numerics.formulation` out, choose a finer `resolution`, or raise them by `terrain.breaklines`"
    };
    let problem = Problem::warning(ProblemKind::Input, "ridge-in-cell", "", message)
        .with_cause(format!(
            "ridges of the terrain, such as levees and embankments, are narrower than a cell: {held}{noise}"
        ))
        .with_remedy(remedy)
        .with_at((highest.line[0] + highest.line[1]) * 0.5);
    findings.add(&scenario.resolution, problem);
    ridges
}

/// How far a ridge rises above both beds (m), without end where no water passes it at any level.
fn rise(ridge: &Ridge) -> f64 {
    ridge.rise().unwrap_or(f64::INFINITY)
}

/// The same, 0 where no water passes.
fn finite_rise(ridge: &Ridge) -> f64 {
    ridge.rise().unwrap_or(0.0)
}

/// The faces with a sill as lines, with the cell to the west or south on the left.
fn lines<'a>(passes: &'a PassSills, bed: &'a BedParticles) -> impl Iterator<Item = Ridge> + 'a {
    let lattice = &bed.lattice;
    passes.iter().map(move |sill| {
        let other = sill.other(lattice);
        let (here, there) = (lattice.centre(sill.cell), lattice.centre(other));
        let half = Vec2::new(there.y - here.y, there.x - here.x) * 0.5;
        let middle = lattice.to_map((here + there) * 0.5);
        let half = if sill.is_north { half * -1.0 } else { half };
        let beds = [bed.elevation[sill.cell], bed.elevation[other]];
        let passable = |level: f64| (level < SHUT).then_some(level.max(beds[0].max(beds[1])));
        Ridge {
            line: [middle - half, middle + half],
            sill: passable(sill.level),
            open: sill.share,
            crest: passable(sill.crest),
            beds,
        }
    })
}
