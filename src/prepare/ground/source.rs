//! Who set the ground: the layers below it, and the map of all sources.

use rayon::prelude::*;

use super::Ground;
use crate::bed::BedParticles;
use crate::math::Vec2;
use crate::output::{GroundSource, SetBy, TerrainPixels};
use crate::scenario::{Scenario, TerrainLayer};
use crate::terrain::Terrain;

/// Code of the layer that counts at the centre of each cell; 0 where there is no terrain.
pub fn layers(terrain: &Terrain, bed: &BedParticles) -> Vec<u8> {
    let lattice = &bed.lattice;
    let code = |cell: usize| {
        if bed.has_terrain(cell) { code_of_layer(terrain, lattice.to_map(lattice.centre(cell))) } else { 0 }
    };
    (0..lattice.len()).into_par_iter().map(code).collect()
}

/// Code of the layer that counts at a place (map); 0 where none has data.
fn code_of_layer(terrain: &Terrain, place: Vec2) -> u8 {
    terrain.layer_at(place).map_or(0, |layer| SetBy::Layer(layer).code())
}

/// Who set the ground of a run, by its cells and by the pixels of its maps, if they are on the terrain's own raster.
pub fn sources(scenario: &Scenario, ground: &Ground<'_>, pixels: Option<&TerrainPixels>) -> GroundSource {
    let of_pixels = pixels.map_or_else(Vec::new, |pixels| of_pixels(ground, pixels));
    GroundSource::new(ground.set_by().to_vec(), of_pixels, |source| label(source, scenario))
}

/// The same by pixels: the layer that counts at the pixel, where the ground of its cell is that of a layer.
fn of_pixels(ground: &Ground<'_>, pixels: &TerrainPixels) -> Vec<u8> {
    let lattice = &ground.bed.lattice;
    let is_layer = |code: u8| code == 0 || code <= SetBy::Layer(usize::MAX).code();
    let code = |pixel: usize| {
        let (column, row) = ((pixel % pixels.columns) as f64 + 0.5, (pixel / pixels.columns) as f64 + 0.5);
        let place = Vec2::new(pixels.west + column * pixels.cell, pixels.north - row * pixels.cell);
        let of_cell = lattice.cell_at(lattice.to_local(place)).map_or(0, |cell| ground.set_by[cell]);
        match is_layer(of_cell) {
            true if pixels.elevation[pixel].is_nan() => 0,
            true => Some(code_of_layer(ground.terrain, place)).filter(|code| *code > 0).unwrap_or(of_cell),
            false => of_cell,
        }
    };
    (0..pixels.elevation.len()).into_par_iter().map(code).collect()
}

/// What a source is in words, with the name of its file.
fn label(source: SetBy, scenario: &Scenario) -> String {
    let file =
        |path: &std::path::Path| path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
    match source {
        SetBy::Layer(index) => scenario.layers.get(index).map_or(String::new(), |layer| match &layer.value {
            TerrainLayer::Raster { path, .. } | TerrainLayer::Points { path, .. } => file(path),
        }),
        SetBy::Breakline(index) => {
            let lines = scenario.ground.breaklines.get(index).map(|breakline| &breakline.lines);
            lines.map_or(String::new(), |lines| format!("{} ({})", file(&lines.value.path), lines.key))
        }
        SetBy::FilledGap => "hole of the terrain, filled from its rim".into(),
        SetBy::RidgeGap => "ground in a gap of a ridge".into(),
        SetBy::RaisedBuilding => "building, raised".into(),
        SetBy::BlockedBuilding => "building, blocked".into(),
        SetBy::Dam => "dam at the start of the run".into(),
        SetBy::Shore => "shore, fitted so that the stored volume is exact".into(),
        SetBy::EarlierRun => "bed under the water of the earlier run".into(),
    }
}
