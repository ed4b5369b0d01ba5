//! The terrain under maps on its own raster (`outputs.cell: terrain`).

use rayon::prelude::*;

use super::change::{Shaped, is_noteworthy};
use crate::bed::{BedParticles, Pixels};
use crate::error::{Problem, ProblemKind};
use crate::math::Vec2;
use crate::output::{SetBy, TerrainPixels};
use crate::prepare::findings::Findings;
use crate::scenario::{OutputPart, Scenario};
use crate::terrain::{PixelGrid, Terrain};

/// Memory (bytes) that a pixel takes: its elevation, the water that it belongs to, and the maps while they are written.
pub const BYTES_PER_PIXEL: f64 = 150.0;

/// The terrain by the pixels of its finest raster, where the scenario wants its maps on them; warns where no raster is finer than the
/// lattice.
///
/// Returns them with the code of [`SetBy`] of each.
///
/// - `surfaces`: the terrain where squares decide, and beside buildings whose outlines cells follow
/// - `holds`: whether such a cell holds a place (map), or a building; none where squares decide
/// - `bed`: that of the terrain, and that at the start of the run, which an earlier run may have changed
pub fn pixels(
    scenario: &Scenario,
    ([surface, beside], terrain, holds): (&[Shaped<'_>; 2], &Terrain, &(dyn Fn(Vec2) -> Option<bool> + Sync)),
    (own, at_start): (&[f64], &BedParticles),
    findings: &mut Findings,
) -> Option<(TerrainPixels, Vec<u8>)> {
    let source = scenario.outputs.maps_on_terrain.as_ref()?;
    let lattice = &at_start.lattice;
    let (low, high) = (lattice.origin, lattice.origin + lattice.size());
    let Some(grid) = surface.grid(low, high, lattice.spacing) else {
        findings.add(source, no_finer_raster(lattice.spacing));
        return None;
    };
    if ![OutputPart::Maps, OutputPart::Cog, OutputPart::Gpkg].iter().any(|part| scenario.outputs.writes(*part)) {
        return None;
    }
    let (outline, cell) = outline(&grid, low, high);
    let row_of = |row: usize| {
        let place = |column: usize| {
            Vec2::new(outline.west + (column as f64 + 0.5) * cell, outline.north - (row as f64 + 0.5) * cell)
        };
        let pixel = |column: usize| {
            let place = place(column);
            let (pixel_column, pixel_row) = grid.at(place);
            let found = terrain.layer_of_pixel(&grid, pixel_column, pixel_row);
            let z = found.map(|(_, z)| z).filter(|z| !z.is_nan());
            let layer = found.map(|(layer, _)| SetBy::Layer(layer));
            let (own_z, set_by) = match holds(place) {
                Some(true) => beside.changed_by(place, z, layer),
                Some(false) => (None, Some(SetBy::BlockedBuilding)),
                None => surface.changed_by(place, z, layer),
            };
            let risen =
                lattice.cell_at(lattice.to_local(place)).map_or(0.0, |cell| at_start.elevation[cell] - own[cell]);
            // A cell without terrain has no bed that an earlier run could have changed.
            let z_b = own_z.map(|z| if risen.is_nan() { z } else { z + risen });
            let set_by = if is_noteworthy(own_z, z_b) { Some(SetBy::EarlierRun) } else { set_by };
            (z_b.map_or(f32::NAN, |z| z as f32), set_by.map_or(0, SetBy::code))
        };
        (0..outline.columns).map(pixel).unzip()
    };
    let rows: Vec<(Vec<f32>, Vec<u8>)> = (0..outline.rows).into_par_iter().map(row_of).collect();
    let (elevation, set_by): (Vec<Vec<f32>>, Vec<Vec<u8>>) = rows.into_iter().unzip();
    Some((TerrainPixels { elevation: elevation.concat(), ..outline }, set_by.concat()))
}

/// The raster over a rectangle (map coordinates), and the edge of its pixels (m): square ones, where those of the terrain are none.
fn outline(grid: &PixelGrid, low: Vec2, high: Vec2) -> (TerrainPixels, f64) {
    let block = grid.block(low, high);
    let size = grid.cell();
    let cell = size.x.min(size.y);
    let corner = grid.centre(block.columns.start, block.rows.start) + Vec2::new(-0.5 * size.x, 0.5 * size.y);
    let count =
        |pixels: usize, size: f64| if size > cell { (pixels as f64 * size / cell).round() as usize } else { pixels };
    let columns = count(block.columns.count(), size.x);
    let rows = count(block.rows.count(), size.y);
    (TerrainPixels { west: corner.x, north: corner.y, cell, columns, rows, elevation: Vec::new() }, cell)
}

fn no_finer_raster(spacing: f64) -> Problem {
    let message = format!("no raster of the terrain is finer than the resolution of {spacing} m");
    Problem::warning(ProblemKind::Scenario, "no-finer-raster", "", message)
        .with_cause("maps on the terrain's own raster show it inside the cells; these maps are on the cells themselves")
        .with_remedy("leave `cell` out, or take a coarser `resolution`")
}
