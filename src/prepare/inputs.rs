//! Every input file of a scenario, with the place in the scenario that names it.
//!
//! Not here: what is in them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::checksum;
use crate::error::{Place, Problem, ProblemKind};
use crate::geodata::cf_axes::split_variable;
use crate::geodata::open::files_of_raster;
use crate::geodata::vrt::{is_elsewhere, is_of_statistics, sources};
use crate::plain_file::entries;
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

/// An input that a scenario names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct NamedInput {
    /// The file.
    pub path: PathBuf,
    /// The key that names it, and its place.
    pub key: String,
    pub place: Option<Place>,
}

/// Files with the keys that name them, while they are gathered.
#[derive(Default)]
struct Files {
    found: Vec<NamedInput>,
}

impl Files {
    fn add<T>(&mut self, source: &Sourced<T>, path: &Path) {
        let (path, _) = split_variable(path);
        self.found.push(NamedInput { path, key: source.key.clone(), place: source.place.clone() });
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

/// Every input that a scenario names, and every raster that a list of it does.
pub(super) fn named(scenario: &Scenario) -> Vec<NamedInput> {
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
    files.vectors(scenario.open.iter().chain(&scenario.closed).filter_map(|boundary| match boundary {
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
    files.found
}

/// Every input file that can be read, each once, with its side files and the sources of a VRT; warnings of those that are no files.
pub(super) fn all(scenario: &Scenario) -> (Vec<InputFile>, Vec<Problem>) {
    let (mut inputs, mut warnings): (Vec<InputFile>, Vec<Problem>) = (Vec::new(), Vec::new());
    let mut seen = BTreeSet::new();
    for NamedInput { path, key, place } in named(scenario) {
        for path in with_its_files(&path) {
            if !seen.insert(path.clone()) {
                continue;
            }
            let (key, place) = (key.clone(), place.clone());
            if is_elsewhere(&path.to_string_lossy()) {
                warnings.push(Problem { key, ..without_checksum(&path) }.with_place(place));
            } else {
                inputs.extend(checksum::of_file(&path).ok().map(|(_, sha256)| InputFile { path, sha256, key, place }));
            }
        }
    }
    (inputs, warnings)
}

/// The warning of what `run.json` has no checksum of.
fn without_checksum(path: &Path) -> Problem {
    let message = format!("{} is no file of this machine", path.display());
    Problem::warning(ProblemKind::Input, "no-checksum", "", message)
        .with_cause("run.json has no checksum of it, and nobody notices when it changes")
        .with_remedy("download or unpack it where the run is to be repeated")
}

/// An input, and what it is read with: side files, the files of a folder, the sources of a VRT with theirs.
fn with_its_files(path: &Path) -> Vec<PathBuf> {
    /// Tables, and vector files without a part that a raster could be in.
    const NO_RASTERS: [&str; 12] =
        ["csv", "txt", "tsv", "xyz", "gz", "geojson", "json", "fgb", "kml", "shp", "tab", "dxf"];
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let side_files: &[&str] = match extension.as_str() {
        "shp" => &["dbf", "shx", "prj", "cpg"],
        "tab" => &["dat", "map", "id"],
        "gml" => &["gfs", "xsd"],
        _ => &[],
    };
    let mut files = vec![path.to_owned()];
    files.extend(side_files.iter().map(|extension| path.with_extension(extension)));
    if path.is_dir() {
        files.extend(entries(path).unwrap_or_default());
    } else if !NO_RASTERS.contains(&extension.as_str()) {
        let own = std::iter::once(path.to_owned()).chain(sources(path));
        // GDAL names the sources of a VRT, too, and those that are no files of this machine.
        files.extend(own.flat_map(|file| std::iter::once(file.clone()).chain(files_of_raster(&file))));
    }
    // A map viewer that opens the terrain while a run goes on leaves such files, and stops no run from going on.
    files.retain(|file| !is_of_statistics(file));
    files
}
