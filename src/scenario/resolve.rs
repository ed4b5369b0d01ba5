//! From the text of a scenario to a `Scenario`: all checks, all problems at once, all defaults.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::Constants;
use super::choices::{ElevationUnit, OpenType};
use super::defaults::{
    DRY_DEPTH, FRAMES, GRAVITY, MAX_PARTICLES, MEMORY_SHARE, RISE_ON_WET, THRESHOLDS, default_isochrones,
    machine_memory, sensible_interval,
};
use super::fields::{Text, split_layer};
use super::ground::{Ground, LayerMode};
use super::methods::{BedMethod, BedSlope, Core, Formulation, Kernel, Motion, Seeding, Turbulence, WallMethod};
use super::model::{
    Boundary, BoundaryCondition, CrsChoice, InitialWater, Limits, Numerics, OpenBoundary, OutputPart, Outputs,
    PointInterpolation, Rain, RainAmount, RainUnit, Roughness, Scenario, Source, SourcePlace, Sourced, TerrainLayer,
};
use super::read::{FromNode, Reader};
use super::schema::{
    BoundaryEntry, InitialEntry, LayerEntry, LimitsSection, MapCell, NumericsSection, OutputsSection, RainSection,
    Roughness as RoughnessSection, ScenarioFile, SourceEntry, Terrain,
};
use super::units::INTENSITY;
use super::{breach, channel, ground, moving_bed, preset, start, tree};
use crate::error::{Error, Place, Problem, ProblemKind, sort_problems};

/// Largest scenario file (bytes); data belongs into files of its own.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// A scenario that can be run, and what the planner should know about it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scenario.
    pub scenario: Scenario,
    /// Problems that do not stop it.
    pub warnings: Vec<Problem>,
}

/// Reads and resolves a scenario file, with overrides of the form `key.path=value`.
///
/// # Errors
/// `Error::Usage` for an override whose path does not fit, `Error::Problems` with every problem otherwise.
pub fn load(file: &Path, overrides: &[String]) -> Result<Loaded, Error> {
    resolve(&read_text(file)?, file, overrides)
}

/// Resolves the text of a scenario that stands in the given file.
///
/// # Errors
/// As for `load`.
pub fn resolve(text: &str, file: &Path, overrides: &[String]) -> Result<Loaded, Error> {
    let (mut root, duplicates) = tree::parse(text, file).map_err(|problem| Error::Problems(vec![*problem]))?;
    for change in overrides {
        tree::apply_override(&mut root, change).map_err(Error::Usage)?;
    }
    preset::expand(&mut root);
    let mut reader = Reader::new(&folder_of(file));
    reader.problems = duplicates;
    let written = ScenarioFile::from_node(&root, &mut reader);
    if let Some(problem) =
        reader.problems.iter().find(|problem| problem.code == "unknown-key" && problem.place.is_none())
    {
        let remedy = problem.remedy.as_deref().unwrap_or_default();
        return Err(Error::Usage(format!("--set {}: {}; {remedy}", problem.key, problem.message)));
    }
    match written {
        Some(written) if !reader.has_errors() => {
            let scenario = fill_in(written, file);
            Ok(Loaded { scenario, warnings: reader.problems })
        }
        _ => {
            list_missing_files(&mut reader);
            sort_problems(&mut reader.problems);
            Err(Error::Problems(reader.problems))
        }
    }
}

/// Reads the file; what keeps it from being a text of moderate size is an error of the scenario.
fn read_text(file: &Path) -> Result<String, Error> {
    let name = file.display();
    let refused = |code, message: String, remedy: &str, place, cause| {
        let problem = Problem::error(ProblemKind::Scenario, code, "", message).with_remedy(remedy).with_place(place);
        Error::Problems(vec![Problem { cause, ..problem }])
    };
    let unreadable = |cause: std::io::Error| {
        let code = if cause.kind() == std::io::ErrorKind::NotFound { "missing-file" } else { "unreadable-file" };
        let remedy = "give the path of a scenario file; `floodsim new` writes one to start from";
        refused(code, format!("the scenario file `{name}` cannot be read"), remedy, None, Some(cause.to_string()))
    };
    if file.is_dir() {
        let inside = file.join("scenario.yaml");
        let is_there = inside.is_file();
        let remedy = if is_there { format!("did you mean `{}`?", inside.display()) } else { "name a file".to_owned() };
        return Err(refused("folder", format!("`{name}` is a folder, not a scenario file"), &remedy, None, None));
    }
    let mut bytes = Vec::new();
    let opened = std::fs::File::open(file).map_err(unreadable)?;
    opened.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        let remedy = "a scenario names its data; rasters, polygons and tables stay in files of their own";
        return Err(refused(
            "too-large",
            format!("the scenario file `{name}` is larger than 1 MiB"),
            remedy,
            None,
            None,
        ));
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|byte| **byte == b'\n').count();
        let line_start = good.iter().rposition(|byte| *byte == b'\n').map_or(0, |index| index + 1);
        let column = 1 + String::from_utf8_lossy(&good[line_start..]).chars().count();
        let place = Place { file: file.to_owned(), line, column };
        let message = "the scenario file is not UTF-8 text".to_owned();
        refused("encoding", message, "save it as UTF-8 in the editor", Some(place), None)
    })
}

fn folder_of(file: &Path) -> PathBuf {
    file.parent().map(Path::to_owned).unwrap_or_default()
}

/// Lists the named files that do not exist, since a scenario with errors is not opened any further.
fn list_missing_files(reader: &mut Reader) {
    for file in std::mem::take(&mut reader.files) {
        // Paths such as `/vsizip/...` exist only for GDAL.
        let name = file.value.to_string_lossy();
        // What stands behind a colon is a variable of the file.
        if name.starts_with("/vsi") || file.value.exists() || Path::new(split_layer(&name).0).exists() {
            continue;
        }
        let message = format!("the file `{}` does not exist", file.value.display());
        let problem = Problem::error(ProblemKind::Input, "missing-file", file.key, message)
            .with_place(file.place)
            .with_remedy("correct the path; it counts from the folder of the scenario");
        reader.problems.push(problem);
    }
}

fn fill_in(written: ScenarioFile, file: &Path) -> Scenario {
    let name = scenario_name(file);
    let end_time = written.time.end.value();
    let resolution = written.resolution.sourced;
    let has_terrain = written.terrain.is_some();
    let (layers, reproject, mut ground) = written.terrain.map(terrain).unwrap_or_default();
    let (walls, buildings) = written.structures.map_or((None, None), |found| (found.walls, found.buildings));
    let walls = walls.unwrap_or_default();
    ground.breaklines.extend(ground::breaklines(Vec::new(), &walls));
    ground.buildings = buildings.map(ground::buildings);
    let (bodies, start) = start::split(written.initial.map_or_else(Vec::new, |entries| entries.0));
    let (open, boundaries) = boundaries(written.boundaries.unwrap_or_default());
    Scenario {
        file: file.to_owned(),
        title: written.title.map_or_else(|| name.clone(), |title| title.0.value),
        crs: match written.crs {
            None => {
                let value = if has_terrain { CrsChoice::FromTerrain } else { CrsChoice::Local };
                Sourced { value, key: "crs".to_owned(), place: None }
            }
            Some(crs) => {
                let value = match crs.0.value.trim() {
                    "local" => CrsChoice::Local,
                    "terrain" => CrsChoice::FromTerrain,
                    named => CrsChoice::Named(named.to_owned()),
                };
                Sourced { value, key: crs.0.key, place: crs.0.place }
            }
        },
        layers,
        reproject,
        ground,
        roughness: written.roughness.map(roughness).unwrap_or_default(),
        initial: bodies.into_iter().filter_map(initial_water).collect(),
        start,
        walls: walls.into_iter().filter(|wall| !wall.has_crest()).map(|wall| wall.lines.0).collect(),
        open,
        boundaries,
        sources: sources(written.sources.unwrap_or_default()),
        rain: written.rain.and_then(rain),
        breach: written.breach.and_then(|breach| breach::resolved(breach.0)),
        moving_bed: moving_bed::resolved(written.moving_bed.unwrap_or_default()),
        channels: channel::resolved(written.channels.unwrap_or_default()),
        outputs: outputs(written.outputs, &name, file, resolution.value, end_time),
        resolution,
        end_time,
        reference_time: written.time.reference.map(|reference| reference.0),
        numerics: methods_of(written.numerics.as_ref()),
        limits: limits(written.limits),
    }
}

/// The name of a scenario: that of its folder if the file is called `scenario`, that of the file otherwise.
fn scenario_name(file: &Path) -> String {
    let stem = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = stem.trim_end_matches(".resolved").to_owned();
    if stem != "scenario" {
        return stem;
    }
    let absolute = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    absolute.parent().and_then(Path::file_name).map_or(stem, |folder| folder.to_string_lossy().into_owned())
}

fn terrain(terrain: Terrain) -> (Vec<Sourced<TerrainLayer>>, bool, Ground) {
    match terrain {
        Terrain::Raster(file) => {
            let Sourced { value: path, key, place } = file.0;
            let value = TerrainLayer::Raster { path, offset: 0.0, unit: 1.0, clip: None, mode: LayerMode::default() };
            (vec![Sourced { value, key, place }], false, Ground::default())
        }
        Terrain::Layers(section) => {
            let layers = section.layers.0.into_iter().filter_map(layer).collect();
            let gaps = section.gaps.map(|gaps| gaps.0);
            let breaklines = ground::breaklines(section.breaklines.unwrap_or_default(), &[]);
            (layers, section.reproject.unwrap_or(false), Ground { gaps, breaklines, buildings: None })
        }
    }
}

fn roughness(section: RoughnessSection) -> Roughness {
    Roughness {
        manning: section.manning.or(section.default).map(|n| n.value()),
        raster: section.raster.map(|file| file.0),
        table: section.table.map(|file| file.0),
        polygons: section.polygons.map(|file| file.0),
    }
}

fn layer(entry: LayerEntry) -> Option<Sourced<TerrainLayer>> {
    let offset = entry.offset.map_or(0.0, |offset| offset.value());
    let mode = entry.mode.map_or(LayerMode::default(), |mode| mode.0.value);
    let clip = entry.clip.map(|clip| clip.0);
    if let Some(raster) = entry.raster {
        let Sourced { value: path, key, place } = raster.0;
        let unit = entry.unit.map_or(ElevationUnit(1.0), |unit| unit.0.value).0;
        return Some(Sourced { value: TerrainLayer::Raster { path, offset, unit, clip, mode }, key, place });
    }
    let Sourced { value: path, key, place } = entry.points?.0;
    let interpolation = entry.interpolation.map_or(PointInterpolation::InverseDistance, |chosen| chosen.0.value);
    let max_gap = entry.max_gap?.value();
    Some(Sourced { value: TerrainLayer::Points { path, interpolation, max_gap, offset, clip, mode }, key, place })
}

fn initial_water(entry: InitialEntry) -> Option<InitialWater> {
    Some(InitialWater {
        polygons: entry.reservoir.or(entry.sea).or(entry.water)?.0,
        level: entry.level.map(|level| level.sourced),
        level_field: entry.level_field.map(|field| field.0.value),
    })
}

/// The edges through which water leaves, and those at which more is known.
fn boundaries(entries: Vec<BoundaryEntry>) -> (Vec<OpenBoundary>, Vec<Sourced<Boundary>>) {
    let (mut open, mut known) = (Vec::new(), Vec::new());
    for (index, entry) in entries.into_iter().enumerate() {
        let place = match (entry.side.or(entry.edge), entry.lines.or(entry.line)) {
            (Some(side), _) => {
                Sourced { value: OpenBoundary::Side(side.0.value), key: side.0.key, place: side.0.place }
            }
            (None, Some(lines)) => {
                let (key, place) = (lines.0.key.clone(), lines.0.place.clone());
                Sourced { value: OpenBoundary::Lines(lines.0), key, place }
            }
            (None, None) => continue,
        };
        let condition = if let Some(discharge) = entry.discharge {
            BoundaryCondition::Discharge { discharge: discharge.timed, level: entry.level.map(|level| level.timed) }
        } else if let Some(stage) = entry.stage {
            BoundaryCondition::Stage(stage.timed)
        } else if let Some(level) = entry.level {
            BoundaryCondition::Level(level.timed)
        } else if let Some(wave) = entry.wave {
            BoundaryCondition::Wave { level: wave.timed, still: entry.still.map(|still| still.timed) }
        } else if let Some(uniform) = entry.normal_depth {
            BoundaryCondition::NormalDepth(uniform.slope.sourced)
        } else if let Some(rating) = entry.rating {
            BoundaryCondition::Rating(rating.0)
        } else {
            match entry.r#type.map(|kind| kind.0.value) {
                Some(OpenType::Free) => BoundaryCondition::Free,
                _ => {
                    open.push(place.value);
                    continue;
                }
            }
        };
        let boundary = Boundary { place: place.value, condition };
        known.push(Sourced { value: boundary, key: format!("boundaries[{index}]"), place: place.place });
    }
    (open, known)
}

fn sources(entries: Vec<SourceEntry>) -> Vec<Sourced<Source>> {
    let place = |entry: &mut SourceEntry| match (entry.at.take(), entry.points.take()) {
        (Some(at), _) => {
            let [x, y] = &at[..] else { return None };
            let (key, place) = (x.sourced.key.trim_end_matches("[0]").to_owned(), x.sourced.place.clone());
            Some(SourcePlace::At(Sourced { value: [x.value(), y.value()], key, place }))
        }
        (None, Some(points)) => Some(SourcePlace::Points(points.0)),
        (None, None) => entry.line.take().or(entry.lines.take()).map(|lines| SourcePlace::Lines(lines.0)),
    };
    let source = |(index, mut entry): (usize, SourceEntry)| {
        let found = place(&mut entry)?;
        let at = match &found {
            SourcePlace::At(at) => at.place.clone(),
            SourcePlace::Points(file) | SourcePlace::Lines(file) => file.place.clone(),
        };
        let value = Source { place: found, discharge: entry.discharge.timed };
        Some(Sourced { value, key: format!("sources[{index}]"), place: at })
    };
    entries.into_iter().enumerate().filter_map(source).collect()
}

fn rain(section: RainSection) -> Option<Sourced<Rain>> {
    let (amount, place) = match (section.rate, section.raster, section.unit) {
        (Some(rate), _, _) => {
            let place = rate.timed.source().1.cloned();
            (RainAmount::Rate(rate.timed), place)
        }
        (None, Some(raster), Some(unit)) => {
            let factor = INTENSITY.factor_of(unit.0.value.trim())?;
            let place = raster.0.place.clone();
            (RainAmount::Raster { file: raster.0, unit: (unit.0.value.trim().to_owned(), factor) }, place)
        }
        (None, None, unit) => {
            let file = section.raster_series?.0;
            let unit = unit.map(|unit| unit.0.value.trim().to_owned());
            let unit = unit.and_then(|unit| RainUnit::named(&unit).map(|known| (unit, known)));
            let (place, start) = (file.place.clone(), section.start.map(|start| start.0));
            (RainAmount::Series { file, unit, stamp: section.stamp.map(|stamp| stamp.0.value), start }, place)
        }
        _ => return None,
    };
    let (initial, constant) = section.losses.map_or((None, None), |losses| (losses.initial, losses.constant));
    let value = Rain {
        amount,
        duration: section.duration.map(|duration| duration.value()),
        initial_loss: initial.map_or(0.0, |initial| initial.value()),
        constant_loss: constant.map_or(0.0, |constant| constant.value()),
    };
    Some(Sourced { value, key: "rain".to_owned(), place })
}

fn outputs(section: Option<OutputsSection>, name: &str, file: &Path, resolution: f64, end_time: f64) -> Outputs {
    let section = section.unwrap_or(OutputsSection {
        folder: None,
        write: None,
        cell: None,
        every: None,
        sections: None,
        gauges: None,
        gauges_every: None,
        arrival: None,
        isochrones: None,
    });
    let every = section.every.map_or_else(|| sensible_interval(end_time / FRAMES), |every| every.value());
    let (thresholds, rise_on_wet) = match section.arrival {
        None => (None, None),
        Some(arrival) => (arrival.thresholds, arrival.rise_on_wet),
    };
    let isochrones = match section.isochrones {
        Some(times) => times.iter().map(|time| time.value()).collect(),
        None => default_isochrones(end_time),
    };
    Outputs {
        folder: match section.folder {
            Some(Text(Sourced { value, key, place })) => Sourced { value: folder_of(file).join(value), key, place },
            None => Sourced { value: Path::new("runs").join(name), key: String::new(), place: None },
        },
        write: match section.write {
            Some(parts) => {
                let parts: BTreeSet<OutputPart> = parts.iter().map(|part| part.0.value).collect();
                parts.into_iter().collect()
            }
            None => OutputPart::ALL.to_vec(),
        },
        cell: match &section.cell {
            Some(MapCell::Length(cell)) => cell.value(),
            Some(MapCell::Terrain(_)) | None => resolution,
        },
        maps_on_terrain: match section.cell {
            Some(MapCell::Terrain(place)) => Some(place),
            _ => None,
        },
        every,
        gauges_every: section.gauges_every.map_or_else(|| (every / 10.0).max(1.0).min(every), |every| every.value()),
        sections: section.sections.map(|sections| sections.0),
        gauges: section.gauges.map(|gauges| gauges.0),
        thresholds: match thresholds {
            Some(thresholds) => thresholds.0.iter().map(|threshold| threshold.value()).collect(),
            None => THRESHOLDS.to_vec(),
        },
        rise_on_wet: rise_on_wet.map_or(RISE_ON_WET, |rise| rise.value()),
        isochrones,
    }
}

fn methods_of(section: Option<&NumericsSection>) -> Numerics {
    let formulation =
        section.and_then(|s| s.formulation.as_ref()).map_or(Formulation::default(), |chosen| chosen.0.value);
    let is_variational = formulation == Formulation::Variational;
    let usual_motion = if is_variational { Motion::Lagrangian } else { Motion::default() };
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
        kernel: section.and_then(|s| s.kernel.as_ref()).map_or(Kernel::default(), |chosen| chosen.0.value),
        integrator: section.and_then(|s| s.integrator.as_ref()).map_or(usual_integrator, |chosen| chosen.0.value),
        bed_slope: section.and_then(|s| s.bed_slope.as_ref()).map_or(BedSlope::default(), |chosen| chosen.0.value),
        turbulence: section.and_then(|s| s.turbulence.as_ref()).map_or(Turbulence::default(), |chosen| chosen.0.value),
        wall: section.and_then(|s| s.wall.as_ref()).map_or(WallMethod::default(), |chosen| chosen.0.value),
        bed: section.and_then(|s| s.bed.as_ref()).map_or(BedMethod::default(), |chosen| chosen.0.value),
        cfl: section.and_then(|s| s.cfl.as_ref()).map_or(usual_cfl, |cfl| cfl.value()),
        gravity: section.and_then(|s| s.gravity.as_ref()).map_or(GRAVITY, |gravity| gravity.value()),
        dry_depth: section.and_then(|s| s.dry_depth.as_ref()).map_or(DRY_DEPTH, |depth| depth.value()),
        constants: Constants::DEFAULT,
    }
}

fn limits(section: Option<LimitsSection>) -> Limits {
    let (memory, particles) = section.map_or((None, None), |section| (section.memory, section.particles));
    Limits {
        memory: memory.map_or_else(|| (MEMORY_SHARE * machine_memory()).floor(), |memory| memory.value()),
        particles: particles.map_or(MAX_PARTICLES, |particles| particles.value()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::methods::{Integrator, Preset, Reconstruction, Stabilisation};

    /// The ten lines of the design, to the letter.
    const TEN_LINES: &str = "floodsim: 1
title: Malpasset, 2 December 1959
crs: local            # the survey's own metres; a terrain that has a CRS needs no such line
terrain: {layers: [{raster: dem_20m.tif}]}
roughness: {manning: 0.033}
initial:
  - {reservoir: reservoir.geojson, level: 100 m}
  - {reservoir: sea.geojson, level: 0 m}
resolution: 20 m
time: {end: 4000 s}
outputs: {cell: 20 m, every: 100 s, gauges: gauges.csv}
";

    fn loaded(text: &str, overrides: &[&str]) -> Result<Loaded, Error> {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        resolve(text, Path::new("cases/malpasset/scenario.yaml"), &overrides)
    }

    fn problems(text: &str) -> Vec<Problem> {
        match loaded(text, &[]) {
            Err(Error::Problems(problems)) => {
                problems.into_iter().filter(|problem| problem.kind == ProblemKind::Scenario).collect()
            }
            other => panic!("problems are expected, not {other:?}"),
        }
    }

    fn exact(a: f64, b: f64) -> bool {
        a.to_bits() == b.to_bits()
    }

    #[test]
    fn the_ten_line_example_is_read_to_the_letter() {
        let Loaded { scenario, warnings } = loaded(TEN_LINES, &[]).unwrap();
        assert!(warnings.is_empty());
        assert_eq!(scenario.title, "Malpasset, 2 December 1959");
        assert_eq!(scenario.crs.value, CrsChoice::Local);
        let TerrainLayer::Raster { path, offset, unit, .. } = &scenario.layers[0].value else { panic!("not a raster") };
        assert_eq!(path, Path::new("cases/malpasset/dem_20m.tif"));
        assert!(exact(*offset, 0.0) && exact(*unit, 1.0));
        assert!(exact(scenario.roughness.manning.unwrap(), 0.033) && exact(scenario.resolution.value, 20.0));
        assert!(exact(scenario.end_time, 4000.0) && exact(scenario.outputs.every, 100.0));
        assert_eq!(scenario.initial.len(), 2);
        let level = scenario.initial[0].level.as_ref().unwrap();
        assert!(exact(level.value, 100.0));
        assert_eq!(level.key, "initial[0].level");
        assert_eq!(level.place.as_ref().map(|place| (place.line, place.column)), Some((7, 43)));
        assert_eq!(scenario.outputs.gauges.as_ref().unwrap().value.path, Path::new("cases/malpasset/gauges.csv"));
    }

    #[test]
    fn defaults_are_filled_in() {
        let text = TEN_LINES.replace("outputs: {cell: 20 m, every: 100 s, gauges: gauges.csv}\n", "");
        let scenario = loaded(&text, &[]).unwrap().scenario;
        let outputs = &scenario.outputs;
        assert_eq!(outputs.folder.value, Path::new("runs/malpasset"));
        assert!(exact(outputs.cell, 20.0) && exact(outputs.every, 120.0) && exact(outputs.gauges_every, 12.0));
        assert_eq!(outputs.thresholds, [0.01, 0.10, 0.30]);
        assert_eq!(outputs.isochrones, [300.0, 600.0, 900.0, 1800.0, 2700.0, 3600.0]);
        let numerics = &scenario.numerics;
        assert_eq!((numerics.motion, numerics.integrator), (Motion::Eulerian, Integrator::Heun));
        assert_eq!(
            (numerics.stabilisation, numerics.reconstruction),
            (Stabilisation::TwoRarefactions, Reconstruction::Limited)
        );
        assert!(exact(numerics.cfl, 0.5) && exact(numerics.gravity, 9.81) && exact(numerics.dry_depth, 1e-3));
        assert!(exact(scenario.limits.particles, 50e6) && scenario.limits.memory > 1e8);

        let moving = loaded(&text, &["numerics.motion=lagrangian"]).unwrap().scenario.numerics;
        assert_eq!((moving.integrator, moving.stabilisation), (Integrator::Leapfrog, Stabilisation::TwoShocks));
        assert_eq!(moving.reconstruction, Reconstruction::Limited);
        assert!(exact(moving.cfl, 0.4));
        let classic = loaded(&text, &["numerics.formulation=variational"]).unwrap().scenario.numerics;
        assert_eq!((classic.motion, classic.stabilisation), (Motion::Lagrangian, Stabilisation::ArtificialViscosity));
        assert!(exact(classic.cfl, 0.4) && classic.reconstruction == Reconstruction::None);
    }

    #[test]
    fn all_problems_are_reported_at_once() {
        let text = "floodsim: 1
titel: x
terrain: {layer: [{raster: a.tif}], layers: [{raster: a.tif, max_gap: 3 m}]}
roughness: {manning: -0.1}
initial:
  - {reservor: a.geojson, level: 20 kg}
  - {reservoir: b.geojson, sea: c.geojson}
resolution: 0 m
time: {end: 30}
outputs: {every: [1], arrival: {thresholds: [0 m, 0.1 m]}}
numerics: {formulation: variational, motion: eulerian, cfl: 1.5, kernel: cubic-spline}
";
        let found: Vec<(usize, &str, String)> =
            problems(text).into_iter().map(|p| (p.place.as_ref().unwrap().line, p.code, p.key)).collect();
        let expected = [
            (2, "unknown-key", "titel"),
            (3, "unknown-key", "terrain.layer"),
            (3, "conflict", "terrain.layers[0].max_gap"),
            (4, "range", "roughness.manning"),
            (6, "missing-key", "initial[0]"),
            (6, "unknown-key", "initial[0].reservor"),
            (6, "unit", "initial[0].level"),
            (7, "conflict", "initial[1]"),
            (8, "range", "resolution"),
            (9, "missing-unit", "time.end"),
            (10, "wrong-type", "outputs.every"),
            (10, "range", "outputs.arrival.thresholds[0]"),
            (11, "method-combination", "numerics.motion"),
            (11, "range", "numerics.cfl"),
            (11, "unknown-name", "numerics.kernel"),
        ];
        assert_eq!(found, expected.map(|(line, code, key)| (line, code, key.to_owned())));
    }

    #[test]
    fn the_parts_to_write_are_chosen_by_name() {
        let text = |write: &str| TEN_LINES.replace("outputs: {", &format!("outputs: {{write: {write}, "));
        let written = |write: &str| loaded(&text(write), &[]).unwrap().scenario.outputs.write;
        assert_eq!(loaded(TEN_LINES, &[]).unwrap().scenario.outputs.write, OutputPart::ALL);
        assert_eq!(written("[tables, maps, tables]"), [OutputPart::Maps, OutputPart::Tables]);
        assert!(written("[]").is_empty());
        let found = problems(&text("[map, geopackage]"));
        let reported: Vec<_> = found.iter().map(|p| (p.code, p.key.as_str(), p.remedy.as_deref().unwrap())).collect();
        let all = "use one of fields, maps, cog, gpkg, tables, sections, channels";
        assert_eq!(
            reported,
            [("unknown-name", "outputs.write[0]", "did you mean `maps`?"), ("unknown-name", "outputs.write[1]", all),]
        );
        let text = text("[maps]").replace("every: 100 s", "every: 100 s, isochrones: [5 min]");
        let warnings = loaded(&text, &[]).unwrap().warnings;
        assert!(warnings.iter().any(|warning| warning.code == "not-written" && warning.key == "outputs.isochrones"));
    }

    fn all_pairs<A, B>(a: &'static [A], b: &'static [B]) -> impl Iterator<Item = (&'static A, &'static B)> {
        a.iter().flat_map(move |a| b.iter().map(move |b| (a, b)))
    }

    #[test]
    fn exactly_the_combinations_that_a_core_has_are_accepted() {
        let mut accepted = Vec::new();
        for formulation in Formulation::ALL {
            for motion in Motion::ALL {
                for (stabilisation, reconstruction) in all_pairs(Stabilisation::ALL, Reconstruction::ALL) {
                    for (integrator, seeding) in all_pairs(Integrator::ALL, Seeding::ALL) {
                        let names = [formulation.name(), motion.name(), stabilisation.name(), integrator.name()];
                        let text = format!(
                            "numerics={{formulation: {}, motion: {}, stabilisation: {}, integrator: {}, reconstruction: {}, seeding: {}}}",
                            names[0],
                            names[1],
                            names[2],
                            names[3],
                            reconstruction.name(),
                            seeding.name()
                        );
                        let Ok(Loaded { scenario, .. }) = loaded(TEN_LINES, &[&text]) else { continue };
                        let numerics = scenario.numerics;
                        assert_eq!((numerics.formulation, numerics.motion), (*formulation, *motion));
                        assert_eq!((numerics.integrator, numerics.seeding), (*integrator, *seeding));
                        assert_eq!(
                            (numerics.stabilisation, numerics.reconstruction),
                            (*stabilisation, *reconstruction)
                        );
                        accepted.push((*formulation, *motion));
                    }
                }
            }
        }
        let count = |formulation, motion| accepted.iter().filter(|pair| **pair == (formulation, motion)).count();
        // Eulerian particles have two stabilisations, moving ones three, variational ones four; all with and without
        // reconstruction, Eulerian ones also with the sharp one. Moving ones have two integrators and two fillings.
        assert_eq!(count(Formulation::Balanced, Motion::Eulerian), 2 * 3);
        assert_eq!(count(Formulation::Balanced, Motion::Lagrangian), 3 * 2 * 4);
        assert_eq!(count(Formulation::Variational, Motion::Eulerian), 0);
        assert_eq!(count(Formulation::Variational, Motion::Lagrangian), 4 * 2 * 4);
    }

    #[test]
    fn a_preset_sets_choices_that_single_keys_beside_it_change() {
        let of = |overrides: &[&str]| loaded(TEN_LINES, overrides).unwrap().scenario.numerics;
        assert_eq!(of(&["numerics.preset=balanced"]), of(&[]));
        for preset in Preset::ALL {
            let name = format!("numerics.preset={}", preset.name());
            let single = preset.keys().map(|(key, value)| format!("numerics.{key}={value}"));
            assert_eq!(of(&[&name]), of(&single.each_ref().map(String::as_str)), "{name}");
        }
        assert_eq!(of(&["numerics.preset=fast"]).reconstruction, Reconstruction::Sharp);
        let changed = of(&["numerics={preset: accurate, cfl: 0.3, stabilisation: lax_friedrichs, reconstruction: }"]);
        assert!(exact(changed.cfl, 0.3) && changed.stabilisation == Stabilisation::LaxFriedrichs);
        assert_eq!(changed.reconstruction, Reconstruction::Limited);
    }

    #[test]
    fn a_preset_goes_with_either_motion() {
        for preset in [Preset::Balanced, Preset::Accurate] {
            let text = format!("numerics={{preset: {}, motion: lagrangian}}", preset.name());
            let numerics = loaded(TEN_LINES, &[&text]).unwrap().scenario.numerics;
            assert_eq!(
                (numerics.stabilisation, numerics.integrator),
                (Stabilisation::TwoShocks, Integrator::Leapfrog),
                "{text}"
            );
        }
    }

    #[test]
    fn the_remedy_of_a_preset_that_a_core_does_not_have_is_to_leave_it_out() {
        let found = problems(&format!("{TEN_LINES}numerics: {{preset: fast, motion: lagrangian}}\n"));
        let said: Vec<_> = found.iter().map(|p| (p.key.as_str(), p.remedy.as_deref().unwrap())).collect();
        let remedy = "leave `preset` out, or write `formulation: balanced, motion: eulerian`";
        assert_eq!(said, [("numerics.preset", remedy)]);
    }

    /// `key: value` of each pair between the backticks of a remedy that names other cores.
    fn keys_of_other_cores(remedy: &str) -> Vec<String> {
        remedy.split("or write `").skip(1).filter_map(|rest| rest.split('`').next()).map(str::to_owned).collect()
    }

    #[test]
    fn a_remedy_for_a_missing_method_leads_to_a_scenario_that_runs() {
        let mut followed = 0;
        for written in [
            "formulation: variational, stabilisation: two_rarefactions",
            "formulation: variational, reconstruction: sharp",
            "formulation: variational, motion: eulerian",
            "motion: eulerian, bed_slope: steep",
            "motion: lagrangian, turbulence: mixing_length",
            "kernel: gauss",
            "integrator: leapfrog, seeding: equal_volume",
            "stabilisation: artificial_viscosity, turbulence: mixing_length",
        ] {
            for problem in problems(&format!("{TEN_LINES}numerics: {{{written}}}\n")) {
                for other in keys_of_other_cores(problem.remedy.as_deref().unwrap()) {
                    let is_kept = |pair: &&str| !pair.starts_with("formulation") && !pair.starts_with("motion");
                    let kept: Vec<&str> = written.split(", ").filter(is_kept).collect();
                    let text = [kept.join(", "), other].join(", ");
                    let result = loaded(TEN_LINES, &[&format!("numerics={{{}}}", text.trim_start_matches(", "))]);
                    assert!(result.is_ok(), "`{written}` leads to `{text}`: {result:?}");
                    followed += 1;
                }
            }
        }
        assert!(followed >= 6, "only {followed} remedies name another core");
    }

    #[test]
    fn every_method_that_acts_has_a_name() {
        for text in ["motion: eulerian", "motion: lagrangian", "formulation: variational"] {
            let numerics = loaded(TEN_LINES, &[&format!("numerics={{{text}}}")]).unwrap().scenario.numerics;
            let acting = numerics.acting();
            assert!(acting.len() > 7 && acting.iter().all(|(_, name)| !name.is_empty()), "{acting:?}");
            assert_eq!(acting.iter().any(|(family, _)| *family == "kernel"), text != "motion: eulerian", "{acting:?}");
        }
    }

    #[test]
    fn walls_are_a_choice_of_moving_particles() {
        let of = |text: &str| loaded(TEN_LINES, &[text]).unwrap().scenario.numerics.wall;
        assert_eq!(of("numerics.motion=lagrangian"), WallMethod::Mirror);
        assert_eq!(of("numerics={motion: lagrangian, wall: virtual_particles}"), WallMethod::VirtualParticles);
        assert_eq!(of("numerics={formulation: variational, wall: virtual_particles}"), WallMethod::VirtualParticles);
        let found = problems(&format!("{TEN_LINES}numerics: {{wall: virtual_particles}}\n"));
        assert_eq!((found[0].code, found[0].key.as_str()), ("method-combination", "numerics.wall"));
    }

    #[test]
    fn turbulence_is_a_choice_of_resting_particles() {
        let of = |text: &str| loaded(TEN_LINES, &[text]).unwrap().scenario.numerics.turbulence;
        assert_eq!(of("numerics.motion=eulerian"), Turbulence::None);
        assert_eq!(of("numerics.turbulence=mixing_length"), Turbulence::MixingLength);
        for moving in ["motion: lagrangian", "formulation: variational"] {
            let found = problems(&format!("{TEN_LINES}numerics: {{{moving}, turbulence: mixing_length}}\n"));
            assert_eq!((found[0].code, found[0].key.as_str()), ("method-combination", "numerics.turbulence"));
        }
    }

    #[test]
    fn what_does_not_go_with_a_preset_is_reported_at_the_preset() {
        let found = problems(&format!("{TEN_LINES}numerics: {{preset: fsat}}\n"));
        assert_eq!((found[0].code, found[0].key.as_str()), ("unknown-name", "numerics.preset"));
        assert_eq!(found[0].remedy.as_deref(), Some("did you mean `fast`?"));
        let found = problems(&format!("{TEN_LINES}numerics: {{motion: lagrangian, preset: fast}}\n"));
        let place = found[0].place.as_ref().map(|place| (place.line, place.column));
        assert_eq!(
            (found.len(), found[0].code, found[0].key.as_str()),
            (1, "method-combination", "numerics.preset"),
            "{found:?}"
        );
        assert_eq!(place, Some((12, 40)));
    }

    #[test]
    fn a_wrong_indentation_is_named_as_such() {
        let text = TEN_LINES.replace("time: {end: 4000 s}", "time:\nend: 4000 s");
        let found = problems(&text);
        assert!(
            found.iter().any(|p| p.key == "time" && p.remedy.as_ref().unwrap().contains("indentation")),
            "{found:?}"
        );
    }

    #[test]
    fn overrides_change_the_scenario_and_their_faults_are_usage_errors() {
        let scenario = loaded(TEN_LINES, &["initial[0].level=95 m", "numerics.cfl=0.3"]).unwrap().scenario;
        assert!(exact(scenario.initial[0].level.as_ref().unwrap().value, 95.0) && exact(scenario.numerics.cfl, 0.3));
        let error = loaded(TEN_LINES, &["resoluton=5 m"]).unwrap_err();
        assert!(matches!(&error, Error::Usage(text) if text.contains("did you mean `resolution`?")), "{error}");
        let Err(Error::Problems(found)) = loaded(TEN_LINES, &["resolution=5 kg"]) else { panic!("not refused") };
        assert_eq!(
            (found[0].key.as_str(), found[0].cause.as_deref()),
            ("resolution", Some("the value comes from --set"))
        );
    }

    #[test]
    fn intervals_longer_than_the_run_and_cells_finer_than_the_resolution_are_told() {
        let codes = |from: &str, to: &str| -> Vec<(&str, String)> {
            assert!(TEN_LINES.contains(from), "{from}");
            let warnings = loaded(&TEN_LINES.replace(from, to), &[]).unwrap().warnings;
            warnings.into_iter().map(|problem| (problem.code, problem.key)).collect()
        };
        let reported = |code: &'static str, key: &str| vec![(code, key.to_owned())];
        assert_eq!(codes("every: 100 s", "every: 67 min"), reported("longer-than-run", "outputs.every"));
        assert_eq!(codes("every: 100 s", "gauges_every: 2 h"), reported("longer-than-run", "outputs.gauges_every"));
        assert_eq!(codes("cell: 20 m", "cell: 19 m"), reported("finer-than-resolution", "outputs.cell"));
        assert_eq!(codes("cell: 20 m, every: 100 s", "cell: 30 m, every: 4000 s"), []);
    }

    #[test]
    fn a_doubtful_roughness_is_a_warning() {
        let text = TEN_LINES.replace("0.033", "0.002");
        assert_eq!(loaded(&text, &[]).unwrap().warnings[0].code, "roughness");
        assert!(loaded(&TEN_LINES.replace("0.033", "0"), &[]).unwrap().warnings.is_empty());
    }

    #[test]
    fn a_level_alone_is_told_to_be_that_at_the_boundary_and_a_still_one_needs_a_wave() {
        let with = |boundary: &str| format!("{TEN_LINES}boundaries: [{{side: west, {boundary}}}]\n");
        let warned = |boundary: &str| -> Vec<(&str, String)> {
            let warnings = loaded(&with(boundary), &[]).unwrap().warnings;
            warnings.into_iter().map(|problem| (problem.code, problem.key)).collect()
        };
        assert_eq!(warned("level: 3 m"), [("level-is-at-the-boundary", "boundaries[0].level".to_owned())]);
        for silent in ["level: 3 m, discharge: 2 m3/s", "stage: 3 m", "wave: 3 m", "wave: {series: w.csv}, still: 1 m"]
        {
            assert_eq!(warned(silent), [], "{silent}");
        }
        for (text, code, key) in [
            ("still: 1 m", "missing-key", "boundaries[0]"),
            ("stage: 2 m, still: 1 m", "conflict", "boundaries[0].still"),
            ("wave: 2 m, stage: 1 m", "conflict", "boundaries[0]"),
        ] {
            let found = problems(&with(text));
            assert_eq!((found[0].code, found[0].key.as_str()), (code, key), "{text}");
        }
    }

    #[test]
    fn the_schema_knows_the_keys_of_the_example() {
        let schema = schemars::schema_for!(ScenarioFile);
        let properties = schema.get("properties").unwrap();
        for key in ["floodsim", "title", "crs", "terrain", "roughness", "initial", "resolution", "time", "outputs"] {
            assert!(properties.get(key).is_some(), "{key}");
        }
        assert_eq!(schema.get("additionalProperties"), Some(&serde_json::Value::Bool(false)));
        assert!(schema.get("required").unwrap().as_array().unwrap().iter().any(|key| key == "resolution"));
        assert!(schema.to_value().pointer("/$defs/BoundaryEntry/properties/type").is_some());
    }

    proptest::proptest! {
        #[test]
        fn any_change_of_the_example_is_read_or_refused(at in 0..TEN_LINES.len(), by in "[ -~\n]{0,4}", cut in 0..5_usize) {
            let end = (at + cut).min(TEN_LINES.len());
            let text = format!("{}{by}{}", &TEN_LINES[..at], &TEN_LINES[end..]);
            if let Err(error) = loaded(&text, &[]) {
                proptest::prop_assert_eq!(error.exit_code(), crate::error::ExitCode::Scenario);
            }
        }
    }
}
