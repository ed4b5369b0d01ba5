//! A run that goes on where an earlier one was.
//!
//! Its state is taken cell by cell from `fields.nc` ([`crate::prepare::water::earlier_fields`]), whose cells are those of this run, larger or
//! smaller ([`crate::prepare::water::earlier_cells`]): depth, velocity and,
//! under the water, the bed, z = η − d, whether it was another one or is so by single precision alone: that is what the file has, a depth
//! of d comes back within 6e-8 d, and a lake at rest has one level. A film has no level in the file; the bed under it is that of `maps.nc`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error};
use crate::gate::Gate;
use crate::math::Vec2;
use crate::output::{OutputCrs, SetBy};
use crate::plain_file;
use crate::prepare::findings::Findings;
use crate::prepare::ground::gaps::around;
use crate::prepare::ground::{Changes, Ground};
use crate::prepare::water::earlier_cells::Between;
use crate::prepare::water::earlier_fields::{laid, open_fields, read, record, same_crs};
use crate::prepare::water::earlier_maps::{OTHER_BED, bed_of_maps, edges_of_levels, other_dry_ground};
use crate::prepare::water::earlier_state::State;
use crate::prepare::water::earlier_structures::other_structures;
use crate::scenario::Scenario;
use crate::scenario::methods::Motion;
use crate::seeding::StillWater;
use crate::solver::Breach;

/// Share of a level or a depth that single precision and one sum may cost.
const SINGLE_PRECISION: f64 = 2.5e-7;
/// A change of the bed by the earlier run that is reported (m).
const TOLD_CHANGE: f64 = 1e-3;
/// A share of the volume of the file by which that on the cells of this run may differ without a word.
const TOLD_VOLUME: f64 = 1e-3;

/// The `run.json` beside the fields of an earlier run, and its path; null where there is none.
fn run_beside(fields: &Path) -> (PathBuf, serde_json::Value) {
    let file = fields.with_file_name("run.json");
    let text = plain_file::read_to_string(&file).unwrap_or_default();
    (file, serde_json::from_str(&text).unwrap_or_default())
}

/// Whether a dam broke or the bed moved in the earlier run of a scenario, as its `run.json` says.
pub fn has_moved_bed(scenario: &Scenario) -> bool {
    let earlier = scenario.start.earlier.as_ref().map(|earlier| run_beside(&earlier.fields.value).1);
    earlier.is_some_and(|run| !run["breach"].is_null() || !run["moving_bed"].is_null())
}

/// What the `run.json` beside the fields of an earlier run says against going on from them; nothing where there is none.
pub fn how_it_ended(fields: &Path) -> Vec<Problem> {
    let (file, run) = run_beside(fields);
    if run.is_null() {
        return Vec::new();
    }
    let name = file.display();
    let warning = |code, message: String, cause: &str, remedy: &str| {
        Problem::warning(ProblemKind::Input, code, "", message).with_cause(cause).with_remedy(remedy)
    };
    let mut reported = Vec::new();
    let simulated = run["simulated_s"].as_f64().unwrap_or(f64::NAN);
    match run["status"].as_str() {
        Some("failed") => reported.push(
            input_error("failed-run", format!("the earlier run failed, says {name}, at {simulated} s"))
                .with_cause("its computation broke down, and its last frames may be of no worth")
                .with_remedy("mend and repeat that run, or begin from a frame of one that ended"),
        ),
        Some("stopped" | "running") => reported.push(warning(
            "unfinished-earlier-run",
            format!("the earlier run did not come to its end, says {name}: it was stopped at {simulated} s"),
            "its last frame is earlier than its `time.end`",
            "check that this is the moment that is meant, or name it with `time`",
        )),
        _ => {}
    }
    let gates = run["gates"].as_array().into_iter().flatten();
    let failed: Vec<String> = gates.filter_map(failed_gate).collect();
    if !failed.is_empty() {
        reported.push(warning(
            "gate-of-earlier-run",
            format!("a quality gate of the earlier run failed, says {name}: {}", failed.join("; ")),
            "its water may not be right",
            "look at that run before you go on from it",
        ));
    }
    if run["methods"]["motion"].as_str() == Some(Motion::Lagrangian.name()) {
        reported.push(warning(
            "drawn-fields",
            format!("the particles of the earlier run moved, says {name}: its fields are drawn from them"),
            "what a particle or a cell that moves has is shared out among the cells of the map: over an uneven bed a still lake may not be \
             quite level in the file, and move at first",
            "nothing, if that does not matter; otherwise run it whole, or its first part with Eulerian particles",
        ));
    }
    if !run["moving_bed"].is_null() {
        reported.push(warning(
            "moving-bed-of-earlier-run",
            format!("the bed of the earlier run moved, says {name}; here it is so under its water alone"),
            "`fields.nc` has no bed where the ground is dry",
            "give a terrain that has what moved",
        ));
    }
    reported
}

/// A gate that an earlier run failed; the gates of runs before version 0.2 are lines.
fn failed_gate(gate: &serde_json::Value) -> Option<String> {
    let line = gate.as_str().filter(|line| line.starts_with("failed")).map(str::to_owned);
    let record = || match Gate::deserialize(gate) {
        Ok(gate) => gate.fails().then_some(gate.name),
        // What is no gate must not count as passed; a line that did not fail is one.
        Err(_) => (!gate.is_string()).then(|| gate.to_string()),
    };
    line.or_else(record)
}

/// Takes over the state of an earlier run, and hands it out.
pub fn take_over(
    scenario: &Scenario,
    crs: &OutputCrs,
    (breach, walls): (Option<&Breach>, &[[Vec2; 2]]),
    ground: &mut Ground<'_>,
    still: &mut StillWater,
    findings: &mut Findings,
) -> Option<State> {
    let earlier = scenario.start.earlier.as_ref()?;
    let bed = ground.bed();
    let path = &earlier.fields.value;
    let file = findings.take(&earlier.fields, open_fields(path))?;
    let laid = laid(&file, path, &bed.lattice, scenario.reading.part.is_some());
    let laid = laid.and_then(|laid| same_crs(&file, path, crs).map(|()| laid));
    let laid = findings.take(&earlier.fields, laid)?;
    let changes = ground.changes();
    let of_dam = breach.into_iter().flat_map(|breach| &breach.cells);
    let dam: Dam = of_dam.map(|dam| (dam.cell, bed.elevation[dam.cell] > dam.ground)).collect();
    let is_built = |cell: usize| changes.moves(cell) || dam.get(&cell) == Some(&true);
    let edges = edges_of_levels(path, &run_beside(path).1, &laid);
    findings.add_all(&earlier.fields, edges.as_ref().err().map(|problem| (**problem).clone()));
    let walls = walls.iter().copied().collect();
    let between = Between { laid, bed, walls: &walls, is_built: &is_built, edges: edges.unwrap_or_default() };
    let state = record(&file, path, earlier)
        .and_then(|record| read(&file, path, record, &between).map_err(|problem| (false, problem)));
    let state = match (state, &earlier.time) {
        (Ok(state), _) => state,
        (Err((true, problem)), Some(time)) => {
            findings.add(time, problem);
            return None;
        }
        (Err((_, problem)), _) => {
            findings.add(&earlier.fields, problem);
            return None;
        }
    };
    findings.add_all(&earlier.fields, other_structures(scenario, path));
    let maps = bed_of_maps(path, bed, &laid);
    findings.add_all(&earlier.fields, maps.as_ref().and_then(|of_maps| other_dry_ground(&state, path, of_maps, bed)));
    let films = maps.unwrap_or_default();
    findings.add_all(&earlier.fields, other_volume(&state, path, bed));
    match beds_below((&state, &films), path, &dam, ground) {
        Ok((beds, warning)) => {
            findings.add_all(&earlier.fields, warning);
            ground.take_beds(&beds, SetBy::EarlierRun);
            for (own, depth) in still.depth.iter_mut().zip(&state.depth).filter(|(_, depth)| **depth > 0.0) {
                *own = *depth;
            }
            Some(state)
        }
        Err(problem) => {
            findings.add(&earlier.fields, *problem);
            None
        }
    }
}

/// The warning that the water does not all fit on the cells of this run, if so.
fn other_volume(state: &State, path: &Path, bed: &BedParticles) -> Option<Problem> {
    let (mut volume, mut of_file) = (0.0, 0.0);
    for (cell, in_file) in state.in_file.iter().enumerate().filter(|(_, in_file)| **in_file > 0.0) {
        of_file += in_file;
        if state.depth[cell] > 0.0 && bed.has_terrain(cell) {
            volume += state.depth[cell] * bed.area(cell);
        }
    }
    if of_file <= 0.0 {
        return None;
    }
    let change = volume / of_file - 1.0;
    (change.abs() > TOLD_VOLUME).then(|| {
        let message = format!(
            "of {of_file:.3e} m³ that {} has in cells of another size {volume:.3e} m³ are taken over ({:+.2} %)",
            path.display(),
            100.0 * change
        );
        Problem::warning(ProblemKind::Input, "volume-of-earlier-run", "", message)
            .with_cause("beside walls, buildings, dams, raised and carved ground and edges of the terrain cells of two sizes do not hold the same")
            .with_remedy("take the `resolution` of that run, if the difference matters")
    })
}

/// Cells with their beds (m).
type Beds = Vec<(usize, f64)>;
/// The cells of the dam that breaks, and whether it stands higher than the ground in each.
type Dam = BTreeMap<usize, bool>;

/// The bed of the earlier run under its water, where it was another one, and a warning of it.
///
/// - `films`: the bed (m) of its maps, for films, of which the fields have no level: at a shore that was fitted to still water one would lie
///   on the bank and run down; empty where there is none
fn beds_below(
    (state, films): (&State, &[f64]),
    path: &Path,
    dam: &Dam,
    ground: &Ground<'_>,
) -> Result<(Beds, Option<Problem>), Box<Problem>> {
    let (bed, changes) = (ground.bed(), ground.changes());
    let place = |cell: usize| bed.lattice.to_map(bed.lattice.centre(cell));
    if let Some(problem) = water_without_terrain(state, path, bed) {
        return Err(Box::new(problem));
    }
    let is_in_dam = |cell: usize| dam.get(&cell) == Some(&true);
    let (mut level_beds, mut rises) = (Vec::new(), Vec::new());
    for cell in (0..state.depth.len()).filter(|&cell| state.depth[cell] > 0.0) {
        let (depth, level) = (state.depth[cell], state.level[cell]);
        let rise = level - depth - bed.elevation[cell];
        // A film has no level.
        if rise.is_nan() {
            continue;
        }
        if rise.abs() <= SINGLE_PRECISION * (level.abs() + depth) {
            rises.push((cell, 0.0));
            // The level of a lake is one number in the file: on a bed of that level less the depth it stays at rest.
            level_beds.push((cell, level - depth));
            continue;
        }
        if is_in_dam(cell) {
            return Err(Box::new(water_in_dam(path).with_at(place(cell))));
        }
        rises.push((cell, rise));
    }
    let in_larger = (0..state.rise.len()).find(|&cell| state.rise[cell] < -OTHER_BED && is_in_dam(cell));
    if let Some(cell) = in_larger {
        return Err(Box::new(water_in_dam(path).with_at(place(cell))));
    }
    if let Some(problem) = other_bed(state, path, changes, bed) {
        return Err(Box::new(problem));
    }
    // What is built here stays as it is.
    let of_films = under_films(state, films, bed).into_iter();
    let natural = of_films.filter(|&(cell, _)| !dam.contains_key(&cell) && !changes.moves(cell));
    let risen: Vec<(usize, f64)> = rises.into_iter().filter(|(_, rise)| *rise != 0.0).chain(natural).collect();
    let warning = risen_beds(&risen, path).map(|(cell, problem)| problem.with_at(place(cell)));
    let beds = risen.into_iter().map(|(cell, rise)| (cell, bed.elevation[cell] + rise));
    Ok((level_beds.into_iter().chain(beds).collect(), warning))
}

/// The warning of cells whose bed lies higher (m) in the earlier run, and the cell of the largest difference; none where none differs.
fn risen_beds(risen: &[(usize, f64)], path: &Path) -> Option<(usize, Problem)> {
    let changed = risen.iter().filter(|(_, rise)| rise.abs() > TOLD_CHANGE);
    let (cell, rise) = changed.clone().copied().reduce(|a, b| if b.1.abs() > a.1.abs() { b } else { a })?;
    let message =
        format!("the bed of {} wet cells is that of {}, by {rise:+.3} m at most", changed.count(), path.display());
    let problem = Problem::warning(ProblemKind::Input, "bed-of-earlier-run", "", message)
        .with_cause("the shore of still water was fitted in that run, its bed had changed, or its terrain was another one")
        .with_remedy("nothing, if a shore was fitted or a dam broke there; otherwise take the terrain of that run, or run from the start");
    Some((cell, problem))
}

/// Water of the earlier run on cells without terrain, if any.
fn water_without_terrain(state: &State, path: &Path, bed: &BedParticles) -> Option<Problem> {
    let lost: Vec<usize> =
        (0..state.depth.len()).filter(|&cell| state.depth[cell] > 0.0 && !bed.has_terrain(cell)).collect();
    let first = *lost.first()?;
    let volume = lost.iter().map(|&cell| state.depth[cell] * bed.area(cell)).sum::<f64>();
    let message = format!("{} has {volume:.3e} m³ of water on {} cells without terrain", path.display(), lost.len());
    let problem = input_error("water-without-terrain", message)
        .with_remedy("take the terrain and the buildings of that run")
        .with_at(bed.lattice.to_map(bed.lattice.centre(first)));
    Some(problem)
}

/// Water of the earlier run where a dam stands in this one.
fn water_in_dam(path: &Path) -> Problem {
    let message =
        format!("{} has water where the dam of `breach` stands, on a bed that is not its crest", path.display());
    input_error("water-in-dam", message)
        .with_cause("the dam was not there in the earlier run, or it had broken")
        .with_remedy(
            "take a moment before the dam broke, run it whole from its start, or put what still stands of the dam under \
             `terrain.breaklines` with `mode: raise` in place of `breach` (without either there is no dam)",
        )
}

/// The films whose bed in the maps of the earlier run is another one, each with how far (m) that lies above the bed of now. Where the surface
/// of a film is that of the water beside it, but for single precision, it is put there exactly, so that a lake stays at rest.
fn under_films(state: &State, ground: &[f64], bed: &BedParticles) -> Vec<(usize, f64)> {
    let rise = |(cell, &z_b): (usize, &f64)| {
        let depth = state.depth[cell];
        if !(depth > 0.0 && state.level[cell].is_nan()) {
            return None;
        }
        let is_same = |level: &f64| (level - depth - z_b).abs() <= 2.0 * SINGLE_PRECISION * (level.abs() + depth);
        let beside = around(cell, &bed.lattice).map(|other| state.level[other]).find(is_same);
        let rise = beside.map_or(z_b, |level| level - depth) - bed.elevation[cell];
        (rise.abs() > SINGLE_PRECISION * bed.elevation[cell].abs()).then_some((cell, rise))
    };
    ground.iter().enumerate().filter_map(rise).collect()
}

/// What speaks against the bed under the water of the earlier run: a change that this scenario makes and that run did not have, or another terrain
/// throughout, where most cells show it.
fn other_bed(state: &State, path: &Path, changes: &Changes, bed: &BedParticles) -> Option<Problem> {
    let name = path.display();
    let place = |cell: usize| bed.lattice.to_map(bed.lattice.centre(cell));
    let shown = state.rise.iter().copied().enumerate().filter(|(_, rise)| !rise.is_nan());
    let (built, mut sorted): (Vec<_>, Vec<_>) = shown.partition(|(cell, _)| changes.moves(*cell));
    sorted.sort_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let natural = (0..state.depth.len()).filter(|&cell| state.depth[cell] > 0.0 && !changes.moves(cell)).count();
    let middle = sorted.get(sorted.len() / 2).filter(|_| 2 * sorted.len() >= natural);
    if let Some(&(cell, rise)) = middle.filter(|(_, rise)| rise.abs() > OTHER_BED) {
        let message = format!(
            "under water the bed of {name} differs from that of this run by {:.3} m (median of {} cells)",
            rise.abs(),
            sorted.len()
        );
        return Some(
            input_error("other-terrain", message)
                .with_cause("it ran on another terrain, or with heights above another datum")
                .with_remedy(
                    "take the terrain layers of that run, with their `offset` and `unit`, or run from the start",
                )
                .with_at(place(cell)),
        );
    }
    // On cells of another size what a line makes of the ground is another bed in any case.
    let is_other = |&(cell, rise): &(usize, f64)| rise.abs() > OTHER_BED && state.in_file[cell] <= 0.0;
    let off: Vec<_> = built.into_iter().filter(is_other).collect();
    let (cell, rise) = off.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let message = format!(
        "{name} has water on {} cells that this scenario raises or carves, on another bed, by {rise:+.3} m at most",
        off.len()
    );
    Some(
        input_error("change-under-water", message)
            .with_cause("the earlier run was without the breakline or the building there, had it at another level, or fitted a shore to it")
            .with_remedy("run from the start with it, or take it out and go on")
            .with_at(place(cell)),
    )
}
