//! Every input file of a scenario, with the place in the scenario that names it.
//!
//! Not here: what is in them.

use std::path::{Path, PathBuf};

use crate::checksum;
use crate::error::{Place, Problem, ProblemKind};
use crate::geodata::cf_axes::split_variable;
use crate::prepare::rain::series as rain_series;
use crate::scenario::ChannelShape;
use crate::scenario::{
    BedMovement, BoundaryCondition, Levels, MovingBed, OpenBoundary, RainAmount, RefineShape, Scenario, SourcePlace,
    Sourced, TableFile, TerrainLayer, Timed, TracerPlace, VectorSource,
};

/// An input file and the checksum of its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// The file.
    pub path: PathBuf,
    /// SHA-256 in hexadecimal digits.
    pub sha256: String,
    /// The key that names it, such as `terrain.layers[1].raster`; the first one of several.
    pub key: String,
    /// The place of that key in the scenario, where known.
    pub place: Option<Place>,
}

/// The inputs that lie in a folder or below it, as problems: a run that writes there could delete what it begins with.
pub fn in_folder(inputs: &[InputFile], folder: &Path) -> Vec<Problem> {
    let Ok(real) = folder.canonicalize() else { return Vec::new() };
    let lies_within = |path: &Path| {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        // A link may lie there, or lead there.
        [parent, path].into_iter().any(|path| path.canonicalize().is_ok_and(|path| path.starts_with(&real)))
    };
    let inside = inputs.iter().filter(|input| lies_within(&input.path));
    inside
        .map(|input| {
            let (file, folder) = (input.path.display(), folder.display());
            let message = format!("the input {file} lies in the output folder {folder}");
            Problem::error(ProblemKind::Output, "input-in-output-folder", input.key.clone(), message)
                .with_cause("a run that replaces an earlier one deletes its files, this one perhaps among them")
                .with_remedy("choose another folder with `outputs.folder` or --out, or move the input")
                .with_place(input.place.clone())
        })
        .collect()
}

/// Files with the keys that name them, while they are gathered.
#[derive(Default)]
struct Files {
    found: Vec<(PathBuf, String, Option<Place>)>,
}

impl Files {
    fn add<T>(&mut self, source: &Sourced<T>, path: &Path) {
        let (path, _) = split_variable(path);
        self.found.push((path, source.key.clone(), source.place.clone()));
    }

    fn vectors<'a>(&mut self, sources: impl IntoIterator<Item = &'a Sourced<VectorSource>>) {
        sources.into_iter().for_each(|source| self.add(source, &source.value.path));
    }

    fn plain<'a>(&mut self, sources: impl IntoIterator<Item = &'a Sourced<PathBuf>>) {
        sources.into_iter().for_each(|source| self.add(source, &source.value));
    }

    fn refine(&mut self, levels: Option<&Levels>) {
        for refine in levels.iter().flat_map(|levels| &levels.refine) {
            let (RefineShape::Polygons(source) | RefineShape::Lines { source, .. }) = &refine.value.shape;
            self.add(refine, &source.path);
        }
    }

    fn table(&mut self, table: &TableFile) {
        self.add(&table.file, &table.file.value);
    }

    fn timed(&mut self, timed: &Timed) {
        if let Timed::Series(table) = timed {
            self.table(table);
        }
    }

    fn condition(&mut self, condition: &BoundaryCondition) {
        match condition {
            BoundaryCondition::Free | BoundaryCondition::NormalDepth(_) => {}
            BoundaryCondition::Stage(level) | BoundaryCondition::Level(level) => self.timed(level),
            BoundaryCondition::Wave { level, still } => {
                self.timed(level);
                still.iter().for_each(|still| self.timed(still));
            }
            BoundaryCondition::Rating(table) => self.table(table),
            BoundaryCondition::Discharge { discharge, level } => {
                self.timed(discharge);
                level.iter().for_each(|level| self.timed(level));
            }
        }
    }

    fn moving_bed(&mut self, bed: &MovingBed) {
        self.plain([&bed.raster]);
        match &bed.law {
            BedMovement::InPlace(share) => share.iter().for_each(|share| self.table(share)),
            BedMovement::Slide { path, velocity } => {
                self.vectors([path]);
                self.timed(velocity);
            }
        }
    }

    fn terrain(&mut self, scenario: &Scenario) {
        for layer in &scenario.layers {
            let (TerrainLayer::Raster { path, .. } | TerrainLayer::Points { path, .. }) = &layer.value;
            self.add(layer, path);
        }
        self.vectors(scenario.layers.iter().filter_map(|layer| layer.value.clip()));
        self.vectors(scenario.ground.breaklines.iter().map(|line| &line.lines));
        self.vectors(&scenario.ground.followed);
        self.vectors(scenario.ground.buildings.iter().map(|buildings| &buildings.polygons));
        self.plain(scenario.roughness.raster.iter().chain(&scenario.roughness.table));
        self.vectors(&scenario.roughness.polygons);
    }

    /// Boundaries, sources, channels and rain.
    fn forcing(&mut self, scenario: &Scenario) {
        for boundary in &scenario.boundaries {
            if let OpenBoundary::Lines(lines) = &boundary.value.place {
                self.vectors([lines]);
            }
            self.condition(&boundary.value.condition);
        }
        for source in &scenario.sources {
            if let SourcePlace::Points(file) | SourcePlace::Lines(file) = &source.value.place {
                self.vectors([file]);
            }
            self.timed(&source.value.discharge);
        }
        for channel in &scenario.channels {
            if let ChannelShape::Sections(file) = &channel.shape {
                self.plain([file]);
            }
            let ends = channel.upstream.iter().chain(&channel.downstream);
            ends.for_each(|condition| self.condition(condition));
            self.vectors(&channel.line);
        }
        match scenario.rain.as_ref().map(|rain| &rain.value.amount) {
            Some(RainAmount::Rate(rate)) => self.timed(rate),
            Some(RainAmount::Raster { file, .. }) => self.plain([file]),
            Some(RainAmount::Series { file, .. }) => {
                self.vectors([file]);
                rain_series::listed_files(&file.value.path).iter().for_each(|path| self.add(file, path));
            }
            None => {}
        }
    }
}

/// Every input file that can be read, each once, with the side files of a Shapefile.
pub(super) fn all(scenario: &Scenario) -> Vec<InputFile> {
    let mut files = Files::default();
    files.terrain(scenario);
    files.refine(scenario.levels.as_ref());
    files.vectors(scenario.initial.iter().map(|water| &water.polygons));
    files.vectors(scenario.start.depths.iter().map(|water| &water.place));
    files.plain(scenario.start.earlier.iter().map(|earlier| &earlier.fields));
    files.vectors(&scenario.walls);
    files.vectors(scenario.breach.iter().map(|breach| &breach.dam));
    scenario.breach.iter().filter_map(|breach| breach.share.as_ref()).for_each(|share| files.table(share));
    scenario.moving_bed.iter().for_each(|bed| files.moving_bed(bed));
    files.vectors(scenario.open.iter().filter_map(|boundary| match boundary {
        OpenBoundary::Lines(source) => Some(source),
        OpenBoundary::Side(_) => None,
    }));
    files.forcing(scenario);
    files.vectors(scenario.tracers.iter().flat_map(|tracer| &tracer.from).filter_map(|from| match &from.place {
        TracerPlace::Water(polygons) => Some(polygons),
        _ => None,
    }));
    files.vectors(&scenario.outputs.sections);
    files.vectors(&scenario.outputs.gauges);
    let mut inputs: Vec<InputFile> = Vec::new();
    for (path, key, place) in files.found {
        let is_shapefile = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("shp"));
        let side_files = ["dbf", "shx", "prj"].iter().filter(|_| is_shapefile).map(|e| path.with_extension(e));
        for path in std::iter::once(path.clone()).chain(side_files) {
            if inputs.iter().any(|known| known.path == path) {
                continue;
            }
            let (key, place) = (key.clone(), place.clone());
            inputs.extend(checksum::of_file(&path).ok().map(|(_, sha256)| InputFile { path, sha256, key, place }));
        }
    }
    inputs
}
