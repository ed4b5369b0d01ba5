//! The coordinate reference system of the run, and the terrain layers in it.

use gdal::spatial_ref::SpatialRef;

use crate::error::{Problem, ProblemKind};
use crate::geodata::{
    Crs, CrsProblem, describe, is_metric, map_scales, run_crs_of, same_horizontal, spatial_ref, suggested_utm,
    transform, vertical_datum,
};
use crate::lattice::Lattice;
use crate::math::{Rectangle, Vec2};
use crate::prepare::findings::Findings;
use crate::prepare::polygons::cells_inside;
use crate::prepare::water;
use crate::scenario::{CrsChoice, LayerMode, Scenario, Sourced, TerrainLayer, VectorSource};
use crate::terrain::{
    Layer, Overlay, Raster, RasterFile, RasterRequest, Survey, SurveyFile, SurveyPoint, Terrain, read_survey,
};

/// A terrain file that is open, with its place in the scenario.
enum Opened<'a> {
    Raster(&'a Sourced<TerrainLayer>, RasterFile),
    Survey(&'a Sourced<TerrainLayer>, SurveyFile),
}

impl Opened<'_> {
    fn crs(&self) -> Option<&SpatialRef> {
        match self {
            Opened::Raster(_, file) => file.crs(),
            Opened::Survey(_, file) => file.crs.as_ref(),
        }
    }
}

/// The CRS of the run and its terrain, as far as they can be had.
pub fn open(scenario: &Scenario, findings: &mut Findings) -> (Option<Crs>, Option<Terrain>) {
    let mut opened = Vec::new();
    for source in &scenario.layers {
        let file = match &source.value {
            TerrainLayer::Raster { path, .. } => RasterFile::open(path).map(|file| Opened::Raster(source, file)),
            TerrainLayer::Points { path, .. } => {
                read_survey(path, scenario.limits.memory).map(|file| Opened::Survey(source, file))
            }
        };
        opened.extend(findings.take(source, file));
    }
    let crs = run_crs(scenario, &opened, findings);
    let Some(run) = &crs else {
        return (None, None);
    };
    check_vertical_datums(&opened, findings);
    let all_opened = opened.len() == scenario.layers.len();
    let layers: Vec<Option<Layer>> = opened
        .into_iter()
        .map(|file| match file {
            Opened::Raster(source, file) => read_raster(source, file, scenario, run, findings).map(Layer::Raster),
            Opened::Survey(source, file) => read_points(source, file, run, findings).map(Layer::Survey),
        })
        .collect();
    // A layer that is the lower or the higher one is meant to lie apart.
    for (upper, source) in scenario.layers.iter().enumerate().filter(|(_, source)| overlay(source) == Overlay::Replace)
    {
        if let Some(problem) =
            layers.get(upper).and_then(Option::as_ref).and_then(|layer| apart(layer, &layers[..upper]))
        {
            findings.add(source, problem);
        }
    }
    // Checks against a terrain with a missing layer would only report its absence many times.
    let overlays = scenario.layers.iter().map(overlay);
    let complete: Option<Vec<(Layer, Overlay)>> =
        layers.into_iter().zip(overlays).map(|(layer, overlay)| Some((layer?, overlay))).collect();
    let terrain = complete.filter(|_| all_opened).and_then(Terrain::with_overlays);
    if let (Crs::Projected(run), Some(terrain)) = (run, &terrain)
        && let Some(problem) = distorted(run, terrain.extent())
    {
        match (&scenario.crs.value, scenario.layers.first()) {
            (CrsChoice::FromTerrain, Some(first)) => findings.add(first, problem),
            _ => findings.add(&scenario.crs, problem),
        }
    }
    (crs, terrain)
}

/// The rasters of a terrain, open and not read, with the CRS of the run; none where one of them cannot be opened.
pub fn open_rasters(scenario: &Scenario) -> Option<(Crs, Vec<RasterFile>)> {
    let mut opened = Vec::new();
    for source in &scenario.layers {
        if let TerrainLayer::Raster { path, .. } = &source.value {
            opened.push(Opened::Raster(source, RasterFile::open(path).ok()?));
        }
    }
    let run = run_crs(scenario, &opened, &mut Findings::default())?;
    let files = opened.into_iter().filter_map(|opened| match opened {
        Opened::Raster(_, file) => Some(file),
        Opened::Survey(..) => None,
    });
    Some((run, files.collect()))
}

/// Warns of layers without an offset that state another vertical datum than the first that states one.
fn check_vertical_datums(opened: &[Opened], findings: &mut Findings) {
    let mut first: Option<(String, &Sourced<TerrainLayer>)> = None;
    for file in opened {
        let (Opened::Raster(source, _) | Opened::Survey(source, _)) = file;
        let Some(datum) = file.crs().and_then(vertical_datum) else { continue };
        let Some((earlier, layer)) = &first else {
            first = Some((datum, source));
            continue;
        };
        let (TerrainLayer::Raster { offset, .. } | TerrainLayer::Points { offset, .. }) = &source.value;
        if *earlier != datum && offset.abs() < f64::MIN_POSITIVE {
            let message = format!("this layer counts its heights from `{datum}`, {} from `{earlier}`", layer.key);
            let problem = Problem::warning(ProblemKind::Input, "different-vertical-datum", "", message)
                .with_cause("heights are taken as they stand: no datum is converted, and a step is left along the seam")
                .with_remedy("give the layer its `offset`, or convert it beforehand with `gdalwarp -s_srs -t_srs`");
            findings.add(*source, problem);
        }
    }
}

/// A length on the map may differ by this share from that on the ground: plane surveys differ by less, and maps of continents by more.
const DISTORTED: f64 = 0.01;
/// Beyond this share the system is none to compute in.
const TOO_DISTORTED: f64 = 0.05;

/// Tells where lengths on the map are not those on the ground, in the middle of the terrain.
fn distorted(run: &SpatialRef, Rectangle { low, high }: Rectangle) -> Option<Problem> {
    let middle = (low + high) * 0.5;
    let [east, north] = map_scales(run, middle)?;
    let worst = (east - 1.0).abs().max((north - 1.0).abs());
    let kind = match worst {
        _ if worst > TOO_DISTORTED => Problem::error,
        _ if worst > DISTORTED => Problem::warning,
        _ => return None,
    };
    let mut place = [middle];
    let utm = spatial_ref("EPSG:4326").and_then(|degrees| transform(&mut place, run, &degrees));
    let utm =
        utm.map_or(String::new(), |()| format!(", for example `crs: {}` (UTM)", suggested_utm(place[0].x, place[0].y)));
    let message = format!(
        "1 m on the ground is {east:.3} m to the east and {north:.3} m to the north in {}: lengths, areas and volumes are not true",
        describe(run)
    );
    let problem = kind(ProblemKind::Input, "distorted-crs", "", message)
        .with_cause("a projection for maps of the world or of a continent, or one of another region");
    Some(
        problem
            .with_remedy(format!("set `terrain.reproject: true` and `crs:` to a system of the place{utm}"))
            .with_at(middle),
    )
}

/// How a layer meets those under it.
fn overlay(layer: &Sourced<TerrainLayer>) -> Overlay {
    let (TerrainLayer::Raster { mode, .. } | TerrainLayer::Points { mode, .. }) = layer.value;
    match mode {
        LayerMode::Replace => Overlay::Replace,
        LayerMode::Min => Overlay::Min,
        LayerMode::Max => Overlay::Max,
    }
}

/// Median difference (m) of two overlapping layers above which they hardly share a vertical datum.
const APART: f64 = 1.0;

/// Warns when a layer lies well above or below those under it where they overlap: another vertical datum, unit or offset.
fn apart(layer: &Layer, below: &[Option<Layer>]) -> Option<Problem> {
    /// Places compared: enough for a median.
    const PLACES: usize = 10_000;
    let places: Vec<(Vec2, f64)> = match layer {
        Layer::Raster(raster) => {
            let step = (raster.values.len() / PLACES).max(1);
            let cells = (0..raster.values.len()).step_by(step).filter(|&i| !raster.values[i].is_nan());
            cells.map(|i| (raster.centre(i % raster.columns, i / raster.columns), raster.values[i])).collect()
        }
        Layer::Survey(survey) => {
            let step = (survey.points().len() / PLACES).max(1);
            let places = survey.points().iter().step_by(step).map(|point| point.position);
            places.filter_map(|place| Some((place, survey.elevation(place)?))).collect()
        }
    };
    let under = |place: Vec2| below.iter().rev().flatten().find_map(|layer| layer.elevation(place));
    let mut differences: Vec<f64> = places.into_iter().filter_map(|(place, z)| Some(z - under(place)?)).collect();
    if differences.is_empty() {
        return None;
    }
    differences.sort_by(f64::total_cmp);
    let median = differences[differences.len() / 2];
    (median.abs() > APART).then(|| {
        let side = if median > 0.0 { "above" } else { "below" };
        let message = format!(
            "where it overlaps the layers under it, this layer lies {:.2} m {side} them (median)",
            median.abs()
        );
        Problem::warning(ProblemKind::Input, "layers-apart", "", message)
            .with_cause("another vertical datum, unit or offset, which leaves a step along the seam")
            .with_remedy("give the layer its `offset` or `unit`")
    })
}

/// The coordinate reference system of the run: the one that the scenario names, or that of the first layer that states one.
fn run_crs(scenario: &Scenario, opened: &[Opened], findings: &mut Findings) -> Option<Crs> {
    match &scenario.crs.value {
        CrsChoice::Local => Some(Crs::Local),
        CrsChoice::Named(name) => findings.take(&scenario.crs, named_crs(name)),
        CrsChoice::FromTerrain => crs_of_terrain(scenario, opened, findings),
    }
}

fn named_crs(name: &str) -> Result<Crs, Problem> {
    let crs = spatial_ref(name).map_err(|cause| {
        let message = format!("`{name}` is not a coordinate reference system");
        Problem::error(ProblemKind::Scenario, "unknown-crs", "", message)
            .with_cause(cause)
            .with_remedy("write a code such as `EPSG:25832`, or `local`")
    })?;
    is_metric(&crs).map_err(|why| {
        let remedy = "choose a projected system in metres, such as the UTM zone of the place";
        not_metric(ProblemKind::Scenario, &crs, &why, remedy)
    })?;
    Ok(run_crs_of(&crs))
}

fn crs_of_terrain(scenario: &Scenario, opened: &[Opened], findings: &mut Findings) -> Option<Crs> {
    let first = scenario.layers.first()?;
    let Some((file, crs)) = opened.iter().find_map(|file| Some((file, file.crs()?))) else {
        // A layer that could not be opened might have had one.
        if opened.len() == scenario.layers.len() {
            let message = "neither the terrain nor the scenario states a coordinate reference system";
            let problem = Problem::error(ProblemKind::Input, "no-crs", "", message);
            let remedy = "add `crs: EPSG:...` with the code of the survey, or `crs: local` for plain metres";
            findings.add(first, problem.with_remedy(remedy));
        }
        return None;
    };
    if let Err(why) = is_metric(crs) {
        let (source, remedy) = match file {
            Opened::Raster(source, raster) => (source, raster.remedy_for_metres()),
            Opened::Survey(source, _) => {
                (source, "set `terrain.reproject: true` and `crs:` to a metric system".to_string())
            }
        };
        findings.add(source, not_metric(ProblemKind::Input, crs, &why, &remedy));
        return None;
    }
    Some(run_crs_of(crs))
}

fn not_metric(kind: ProblemKind, crs: &SpatialRef, why: &CrsProblem, remedy: &str) -> Problem {
    let name = describe(crs);
    let (code, message) = match why {
        CrsProblem::Geographic => ("geographic-crs", format!("{name} counts in degrees, and a run needs metres")),
        CrsProblem::NotMetres(unit) => ("not-metric-crs", format!("{name} counts in `{unit}`, and a run needs metres")),
        CrsProblem::NotProjected => {
            ("not-metric-crs", format!("{name} is not a projected system, and a run needs metres"))
        }
    };
    Problem::error(kind, code, "", message).with_remedy(remedy)
}

fn read_raster(
    source: &Sourced<TerrainLayer>,
    file: RasterFile,
    scenario: &Scenario,
    run: &Crs,
    findings: &mut Findings,
) -> Option<Raster> {
    let TerrainLayer::Raster { path, offset, unit, clip, .. } = &source.value else {
        return None;
    };
    findings.take(source, file.check_direction(path))?;
    findings.take(source, file.check_unit_of_heights(*unit, path))?;
    let request = RasterRequest {
        path,
        unit: unit.unwrap_or(1.0),
        offset: *offset,
        reproject: scenario.reproject,
        resolution: scenario.resolution.value,
        memory: scenario.limits.memory,
        part: scenario.reading.part.map(|part| part.own),
        pixel: scenario.reading.pixel,
        is_ground: true,
    };
    let (mut raster, warnings) = findings.take(source, file.read(&request, run))?;
    findings.add_all(source, warnings);
    if let Some(clip) = clip {
        cut(&mut raster, clip, run, scenario, findings)?;
    }
    let cell = raster.cell_x.min(raster.cell_y);
    if scenario.reading.pixel.is_none() && scenario.resolution.value < 0.5 * cell {
        let message = format!(
            "the resolution of {} m is finer than the cells of {} ({cell} m)",
            scenario.resolution.value,
            path.display()
        );
        let problem = Problem::warning(ProblemKind::Scenario, "finer-than-terrain", "", message);
        findings.add(
            &scenario.resolution,
            problem.with_remedy("a finer resolution costs time and adds nothing that the terrain knows"),
        );
    }
    Some(raster)
}

/// Takes the data out of the cells of a raster whose centres lie outside the polygons of a file.
fn cut(
    raster: &mut Raster,
    clip: &Sourced<VectorSource>,
    run: &Crs,
    scenario: &Scenario,
    findings: &mut Findings,
) -> Option<()> {
    let area = water::area(clip, Some(run), findings)?;
    // Its cells as a lattice of squares of 1, whatever their shape.
    let origin = Vec2::new(raster.west, raster.south());
    let to_cells =
        |c: geo::Coord<f64>| geo::Coord { x: (c.x - origin.x) / raster.cell_x, y: (c.y - origin.y) / raster.cell_y };
    let scaled = geo::MapCoords::map_coords(&area, to_cells);
    let lattice = Lattice::new(Vec2::ZERO, raster.columns, raster.rows, 1.0);
    let mut kept = vec![f64::NAN; raster.values.len()];
    for cell in cells_inside(&scaled, &lattice) {
        let (column, from_south) = lattice.column_row(cell);
        let index = (raster.rows - 1 - from_south) * raster.columns + column;
        kept[index] = raster.values[index];
    }
    // What is kept may lie beside the part that is read.
    if scenario.reading.part.is_none() && kept.iter().all(|value| value.is_nan()) {
        findings.add(clip, clip_outside(clip, Rectangle { low: origin, high: Vec2::new(raster.east(), raster.north) }));
        return None;
    }
    raster.values = kept;
    Some(())
}

fn read_points(source: &Sourced<TerrainLayer>, file: SurveyFile, run: &Crs, findings: &mut Findings) -> Option<Survey> {
    let TerrainLayer::Points { path, interpolation, max_gap, offset, clip, .. } = &source.value else {
        return None;
    };
    findings.add_all(source, file.warnings);
    let mut points = file.points;
    if let (Crs::Projected(run), Some(own)) = (run, &file.crs)
        && !same_horizontal(run, own)
    {
        let moved = moved(&points, own, run).map_err(|cause| {
            let message = format!("{} could not be brought to {}", path.display(), describe(run));
            Problem::error(ProblemKind::Input, "no-transformation", "", message)
                .with_cause(cause)
                .with_remedy("check that `crs:` covers the place of this file on Earth")
        });
        points = findings.take(source, moved)?;
    }
    points.iter_mut().for_each(|point| point.elevation += offset);
    let survey = Survey::new(points, *interpolation, *max_gap).map_err(|cause| {
        let message = format!("the points of {} make no surface", path.display());
        Problem::error(ProblemKind::Input, "no-surface", "", message).with_cause(cause)
    });
    let survey = findings.take(source, survey)?;
    let Some(clip) = clip else { return Some(survey) };
    let area = water::area(clip, Some(run), findings)?;
    let extent = survey.extent();
    let clipped = survey.within_area(&area);
    if clipped.is_none() {
        findings.add(clip, clip_outside(clip, extent));
    }
    clipped
}

/// The polygons of `clip` and a layer, given by its extent, have nothing in common.
fn clip_outside(clip: &Sourced<VectorSource>, Rectangle { low, high }: Rectangle) -> Problem {
    let message = format!("the polygons of {} hold no data of this layer", clip.value.path.display());
    Problem::error(ProblemKind::Input, "clip-outside-layer", "", message)
        .with_cause(format!("the layer reaches from {:.0}, {:.0} to {:.0}, {:.0}", low.x, low.y, high.x, high.y))
        .with_remedy("check that the file and the layer have the same CRS, or take `clip` out")
}

fn moved(points: &[SurveyPoint], from: &SpatialRef, to: &SpatialRef) -> Result<Vec<SurveyPoint>, String> {
    let mut places: Vec<Vec2> = points.iter().map(|point| point.position).collect();
    transform(&mut places, from, to)?;
    Ok(points.iter().zip(places).map(|(point, position)| SurveyPoint { position, ..*point }).collect())
}
