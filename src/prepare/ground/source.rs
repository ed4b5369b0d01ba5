//! Who set the ground: the layers below it, and the map of all sources.

use rayon::prelude::*;

use super::Ground;
use crate::bed::BedParticles;
use crate::output::{GroundSource, SetBy};
use crate::scenario::{Scenario, TerrainLayer};
use crate::terrain::Terrain;

/// Code of the layer that counts at the centre of each cell; 0 where there is no terrain.
pub fn layers(terrain: &Terrain, bed: &BedParticles) -> Vec<u8> {
    let lattice = &bed.lattice;
    let is_one = terrain.layers().len() == 1;
    let layer = |cell: usize| {
        if is_one { Some(0) } else { terrain.layer_at(lattice.to_map(lattice.centre(cell))) }
    };
    let code = |cell: usize| {
        let layer = if bed.has_terrain(cell) { layer(cell) } else { None };
        layer.map_or(0, |layer| SetBy::Layer(layer).code())
    };
    (0..lattice.len()).into_par_iter().map(code).collect()
}

/// Who set the ground of a run, by its cells, and by the pixels of its maps where they are on the terrain's own raster.
pub fn sources(scenario: &Scenario, ground: &Ground<'_>, of_pixels: Vec<u8>) -> GroundSource {
    GroundSource::new(ground.set_by().to_vec(), of_pixels, |source| label(source, scenario))
}

/// What a source is in words, with its key and the name of its file.
fn label(source: SetBy, scenario: &Scenario) -> String {
    let of = |key: &str, path: &std::path::Path| {
        let file = path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
        let is_last = source.is_last_of_its_kind();
        format!("{key}, {file}{}", if is_last { ", and those after it" } else { "" })
    };
    match source {
        SetBy::Layer(index) => scenario.layers.get(index).map_or(String::new(), |layer| match &layer.value {
            TerrainLayer::Raster { path, .. } | TerrainLayer::Points { path, .. } => of(&layer.key, path),
        }),
        SetBy::Breakline(index) => {
            let lines = scenario.ground.breaklines.get(index).map(|breakline| &breakline.lines);
            lines.map_or(String::new(), |lines| of(&lines.key, &lines.value.path))
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
