//! The maps beside the `fields.nc` of an earlier run: the size of its cells, its ground, and what that says of dry ground here.

use std::path::{Path, PathBuf};

use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind};
use crate::geodata::netcdf_file;
use crate::plain_file;
use crate::prepare::water::earlier_cells::{Laid, SAME_PLACE};
use crate::prepare::water::earlier_fields::values;
use crate::prepare::water::earlier_state::State;

/// A difference between the beds of two runs (m) that makes them runs on different terrain.
pub const OTHER_BED: f64 = 0.05;

/// The maps beside the `fields.nc` of an earlier run.
fn maps_beside(fields: &Path) -> PathBuf {
    fields.with_file_name("maps.nc")
}

/// A variable of the maps beside the `fields.nc` of an earlier run, in the order of that file; none where there is no such map.
fn of_maps(fields: &Path, name: &str, laid: &Laid) -> Option<Vec<f64>> {
    let maps = maps_beside(fields);
    plain_file::open(&maps).ok()?;
    values(&netcdf_file::open(&maps).ok()?, name, (.., ..), &maps, laid).ok()
}

/// The edges (m) of the cells of a run on levels, in the order of the file of its fields, as `resolution` of its maps has them; nothing of a run on
/// one lattice.
///
/// # Errors
/// A warning where the maps do not say it.
pub fn edges_of_levels(fields: &Path, run: &serde_json::Value, laid: &Laid) -> Result<Option<Vec<f64>>, Box<Problem>> {
    let levels = run["levels"].as_array().map(Vec::as_slice).unwrap_or_default();
    let finest = levels.iter().filter_map(|level| level["spacing_m"].as_f64()).fold(f64::INFINITY, f64::min);
    if levels.len() < 2 {
        return Ok(None);
    }
    let is_finest = (laid.cell - finest).abs() <= SAME_PLACE * finest;
    if let Some(edges) = of_maps(fields, "resolution", laid).filter(|_| is_finest) {
        return Ok(Some(edges));
    }
    let message = format!("{} does not say how large the cells of the earlier run were", maps_beside(fields).display());
    let problem = Problem::warning(ProblemKind::Input, "levels-of-earlier-run", "", message)
        .with_cause("it was a run on levels, and its maps are not there, or not on cells of its finest level")
        .with_remedy("run it with `outputs.cell` as its finest resolution and with `maps` in `outputs.write`; otherwise its coarse cells are steps here");
    Err(Box::new(problem))
}

/// The bed (m) of the maps beside the `fields.nc` of an earlier run on the same cells, NaN without terrain, that of this run beside them; none
/// where there are no such maps.
pub fn bed_of_maps(fields: &Path, bed: &BedParticles, laid: &Laid) -> Option<Vec<f64>> {
    let lattice = &bed.lattice;
    let elevation = of_maps(fields, "bed_elevation", laid).filter(|_| laid.is_lattice(lattice))?;
    let of_cell =
        |cell: usize| laid.of_cell(lattice, cell).next().map_or(bed.elevation[cell], |index| elevation[index]);
    Some((0..lattice.len()).map(of_cell).collect())
}

/// What the maps beside `fields.nc` say of ground that is dry and had another height in the earlier run, or that has terrain in
/// one of the two alone; nothing where there are none.
///
/// Such a change may be meant (a levee that is built for this half). A breakline that was left out is seen by nothing else.
pub fn other_dry_ground(state: &State, fields: &Path, elevation: &[f64], bed: &BedParticles) -> Option<Problem> {
    let maps = maps_beside(fields);
    let change = |cell: usize| bed.elevation[cell] - elevation[cell];
    // The depth is not a number where the earlier run had no terrain.
    let is_dry = |&cell: &usize| state.depth[cell].max(0.0) <= 0.0 && state.level[cell].is_nan();
    let dry = || (0..bed.lattice.len()).filter(is_dry);
    let other: Vec<usize> = dry().filter(|cell| change(*cell).abs() > OTHER_BED).collect();
    let largest = other.iter().copied().max_by(|a, b| change(*a).abs().total_cmp(&change(*b).abs()));
    let lost: Vec<usize> = dry().filter(|cell| bed.elevation[*cell].is_nan() && !elevation[*cell].is_nan()).collect();
    let gained: Vec<usize> = dry().filter(|cell| !bed.elevation[*cell].is_nan() && elevation[*cell].is_nan()).collect();
    let height = largest.map(|cell| format!("on {} cells, by {:+.2} m at most", other.len(), change(cell)));
    let bare = |cells: &[usize], which: &str| (!cells.is_empty()).then(|| format!("on {} cells {which}", cells.len()));
    let parts = [
        height,
        bare(&lost, "that have no terrain here and had some there"),
        bare(&gained, "that have terrain here and had none there"),
    ];
    let place = largest.or(lost.first().copied()).or(gained.first().copied())?;
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    let message = format!("dry ground differs from that of {} {}", maps.display(), parts.join("; "));
    Some(
        Problem::warning(ProblemKind::Input, "other-dry-ground", "", message)
            .with_cause("a breakline, a building or a layer of the terrain is here and was not there, or the other way round, or a dam broke")
            .with_remedy("nothing, if it is meant; otherwise take the terrain and the structures of that run")
            .with_at(bed.lattice.to_map(bed.lattice.centre(place))),
    )
}
