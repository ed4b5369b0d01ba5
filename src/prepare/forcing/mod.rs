//! Boundaries with a condition, rain and cross-sections: their files, and where they lie on the terrain.

pub mod breach;
pub mod channels;
pub mod levels;
pub mod moving_bed;
pub mod plausible;
pub mod sources;
pub mod waves;

use crate::bed::BedParticles;
use crate::boundary::{Boundary, Condition, Forcing, OpenEdges, Pieces, Rain, Strip, edge_faces};
use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::{Vec2, readable, segments_cross};
use crate::output::Section;
use crate::prepare::findings::Findings;
use crate::prepare::grid::{REACH, faces_opened, open_side};
use crate::prepare::ground::burn::crossed;
use crate::prepare::outside::{IN_PART, Outside};
use crate::prepare::places;
use crate::prepare::rain::frames as rain_frames;
use crate::prepare::rain::series as rain_series;
use crate::prepare::rain::{self, Losses};
use crate::prepare::tables::dates::Origin;
use crate::prepare::tables::rows::{self, Meaning};
use crate::prepare::tables::series;
use crate::scenario::units::{INTENSITY, LENGTH};
use crate::scenario::{BoundaryCondition, OpenBoundary, RainAmount, RainUnit, Scenario, Side, Sourced};
use crate::terrain::{Layer, RasterFile, Terrain};
use levels::Inlet;
use plausible::Placed;

/// A side may stay a wall along this share of its edge without a word.
const STEPPED: f64 = 0.1;
/// Two boundaries that share more than this of the faces of one of them overlap.
const SHARED: f64 = 0.5;

const LEVEL: Meaning = Meaning { dimension: &LENGTH, negative: None };
const FALLING: Meaning = Meaning {
    dimension: &INTENSITY,
    negative: Some("leave out the rows of a code for missing values; what the ground takes of the rain is `losses`"),
};

/// Everything that could be opened; map coordinates.
#[derive(Debug, Default)]
pub struct Opened {
    boundaries: Vec<OpenedBoundary>,
    sources: Vec<sources::Opened>,
    rain: Option<OpenedRain>,
    /// The boundaries that have a condition and open something, once they are on the lattice.
    pub placed: Vec<Placed>,
    /// The cross-sections.
    pub sections: Vec<Section>,
}

/// A boundary before it is put on the lattice: its lines (map coordinates), where it has any, and its condition.
type OpenedBoundary = (Option<places::Drawn>, Option<Condition>);

/// Rain before it is put on the lattice.
#[derive(Debug)]
enum OpenedRain {
    Uniform(Rain),
    Raster(Terrain, Losses),
    Series(rain_series::Opened),
}

/// Opens every file of boundaries, sources, rain and sections.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Opened {
    let is_rough = !scenario.roughness.is_none();
    let boundaries = scenario.boundaries.iter().map(|boundary| {
        let lines = match &boundary.value.place {
            OpenBoundary::Side(_) => None,
            OpenBoundary::Lines(source) => places::pieces(source, crs, scenario, findings),
        };
        (lines, condition(&boundary.value.condition, is_rough, scenario, findings))
    });
    let boundaries = boundaries.collect();
    let sources = sources::open(scenario, crs, findings);
    let rain = scenario.rain.as_ref().and_then(|rain| open_rain(rain, scenario, crs, findings));
    let sections = scenario
        .outputs
        .sections
        .as_ref()
        .and_then(|source| Some((source, places::features(source, crs, scenario.reproject, findings)?)))
        .map_or_else(Vec::new, |(source, features)| sections(source, &features, findings));
    Opened { boundaries, sources, rain, placed: Vec::new(), sections }
}

/// A condition with its series; with whether there is roughness where it holds.
pub fn condition(
    condition: &BoundaryCondition,
    is_rough: bool,
    scenario: &Scenario,
    findings: &mut Findings,
) -> Option<Condition> {
    let span = (scenario.end_time, Origin::of_run(scenario));
    Some(match condition {
        BoundaryCondition::Free => Condition::Free,
        BoundaryCondition::Stage(level) => Condition::Stage(series::series(level, LEVEL, span, findings)?),
        BoundaryCondition::Level(level) => Condition::Level(series::series(level, LEVEL, span, findings)?),
        BoundaryCondition::Wave { level, still } => {
            let level = series::series(level, LEVEL, span, findings);
            let still = still.as_ref().map(|still| series::series(still, LEVEL, span, findings));
            Condition::Wave { level: level?, still: if let Some(still) = still { Some(still?) } else { None } }
        }
        BoundaryCondition::Rating(table) => Condition::Rating(series::rating(table, findings)?),
        BoundaryCondition::Discharge { discharge, level } => {
            let discharge = series::series(discharge, rows::COMING, span, findings);
            let level = level.as_ref().map(|level| series::series(level, LEVEL, span, findings));
            Condition::Discharge {
                discharge: discharge?,
                level: if let Some(level) = level { Some(level?) } else { None },
            }
        }
        BoundaryCondition::NormalDepth(slope) => {
            if !is_rough {
                let message = "without roughness there is no uniform flow, and no normal depth";
                let problem = Problem::error(ProblemKind::Scenario, "no-roughness", "", message);
                let remedy = "give `manning` a value above 0, or take `type: free`";
                findings.add(slope, problem.with_remedy(remedy));
                return None;
            }
            Condition::NormalDepth { slope: slope.value }
        }
    })
}

fn open_rain(
    rain: &Sourced<crate::scenario::Rain>,
    scenario: &Scenario,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<OpenedRain> {
    let until = rain.value.duration.unwrap_or(scenario.end_time).min(scenario.end_time);
    let losses = Losses { initial: rain.value.initial_loss, constant: rain.value.constant_loss, until };
    match &rain.value.amount {
        RainAmount::Rate(rate) => {
            let (key, place) = rate.source();
            let rate = series::series(rate, FALLING, (until, Origin::of_run(scenario)), findings)?;
            if let Some(problem) = rain::doubtful(rate.peak()) {
                findings.add_at(key, place.cloned(), problem);
            }
            Some(OpenedRain::Uniform(rain::uniform(&rate, losses)))
        }
        RainAmount::Raster { file, unit } => {
            let check = |opened: &RasterFile| {
                rain_series::check_unit(RainUnit::Intensity(unit.1), &opened.unit(), &file.value.display().to_string())
            };
            let mut raster = crate::prepare::raster::read(file, scenario, crs, &check, findings)?;
            let negative = raster.values.iter().filter(|value| **value < 0.0).count();
            if negative > 0 {
                let message = format!("{negative} cells of {} have rain below 0", file.value.display());
                let problem = input_error("negative-value", message)
                    .with_cause("a fill value that the file does not declare, perhaps")
                    .with_remedy("declare it, as with `gdal_edit.py -a_nodata`");
                findings.add(file, problem);
                return None;
            }
            raster.values.iter_mut().for_each(|value| *value *= unit.1);
            findings.add_all(file, rain::doubtful(raster.values.iter().copied().fold(0.0, f64::max)));
            Terrain::new(vec![Layer::Raster(raster)]).map(|terrain| OpenedRain::Raster(terrain, losses))
        }
        RainAmount::Series { file, unit, stamp, start } => {
            let unit = unit.as_ref().map(|unit| unit.1);
            let asked = rain_series::Asked { file, unit, stamp: *stamp, start: *start };
            rain_series::open(&asked, losses, scenario, crs, findings).map(OpenedRain::Series)
        }
    }
}

/// The cross-sections of a file: each of its lines is one.
fn sections(
    source: &Sourced<crate::scenario::VectorSource>,
    features: &[crate::vector::Feature],
    findings: &mut Findings,
) -> Vec<Section> {
    let mut found: Vec<Section> = Vec::new();
    let path = source.value.path.display();
    let has_line = |feature: &crate::vector::Feature| feature.lines.iter().any(places::has_length);
    findings.add_all(source, places::left_out(source, features, "line", has_line));
    for feature in features {
        let named = feature.attribute("id").or_else(|| feature.attribute("name"));
        let id = named.map_or_else(|| feature.number.to_string(), ToString::to_string);
        for (number, line) in feature.lines.iter().enumerate() {
            let id = if feature.lines.len() > 1 { format!("{id}.{}", number + 1) } else { id.clone() };
            let mut places: Vec<Vec2> = line.0.iter().map(|c| Vec2::new(c.x, c.y)).collect();
            places.dedup();
            if places.len() < 2 {
                continue;
            }
            if found.iter().any(|earlier| earlier.id == id) {
                let problem = input_error("duplicate-section", format!("{path} holds more than one section `{id}`"));
                findings.add(source, problem.with_remedy("give each section its own id").with_at(places[0]));
            }
            found.push(Section { id, line: places });
        }
    }
    if found.is_empty() {
        let problem = input_error("no-lines", format!("{path} holds no line"));
        findings.add(source, problem.with_remedy("draw lines from the left to the right bank; or take the key away"));
    }
    found
}

/// Puts everything on the lattice and checks where it lies.
pub fn on_lattice(opened: &mut Opened, scenario: &Scenario, ground: &BedParticles, findings: &mut Findings) -> Forcing {
    let (lattice, bed) = (&ground.lattice, &ground.elevation[..]);
    let mut forcing = Forcing { reach: REACH * lattice.spacing, ..Forcing::default() };
    opened.placed = boundaries(opened, scenario, ground, &mut forcing, findings);
    sources::on_lattice(&opened.sources, scenario, ground, &mut forcing, findings);
    forcing.rain = match (opened.rain.take(), &scenario.rain) {
        (Some(OpenedRain::Uniform(rain)), _) => Some(rain),
        (Some(OpenedRain::Raster(raster, losses)), Some(source)) => {
            Some(rain::map(rain_at_cells(&raster, source, (lattice, bed), findings), losses))
        }
        (Some(OpenedRain::Series(series)), Some(Sourced { value, .. })) => match &value.amount {
            RainAmount::Series { file, .. } => {
                rain_frames::on_lattice(series, file, scenario, (lattice, bed), findings)
            }
            RainAmount::Rate(_) | RainAmount::Raster { .. } => None,
        },
        _ => None,
    };
    if let Some(source) = &scenario.outputs.sections {
        for section in &opened.sections {
            check_section(section, source, ground, findings);
            forcing.sections.push(pieces_of(section, lattice));
        }
    }
    forcing
}

fn rain_at_cells(
    raster: &Terrain,
    source: &Sourced<crate::scenario::Rain>,
    (lattice, bed): (&Lattice, &[f64]),
    findings: &mut Findings,
) -> Vec<f64> {
    let at = |cell: usize| raster.elevation(lattice.to_map(lattice.centre(cell)));
    let values: Vec<Option<f64>> = (0..lattice.len()).map(at).collect();
    let with_terrain = || (0..lattice.len()).filter(|&cell| !bed[cell].is_nan());
    let missing: Vec<usize> = with_terrain().filter(|&cell| values[cell].is_none()).collect();
    if let Some(&first) = missing.first() {
        let share = 100.0 * missing.len() as f64 / with_terrain().count() as f64;
        let message =
            format!("the raster of rain has no value for {share:.1} % of the terrain ({} cells)", missing.len());
        let problem = input_error("rain-gap", message)
            .with_remedy("give it values there, 0 where no rain falls")
            .with_at(lattice.to_map(lattice.centre(first)));
        findings.add(source, problem);
    }
    // At the rim of the raster a rate goes on as it falls, to no rain at most.
    values.into_iter().map(|value| value.unwrap_or(0.0).max(0.0)).collect()
}

/// The straight pieces of a section in local coordinates (m).
pub fn pieces_of(section: &Section, lattice: &Lattice) -> Vec<[Vec2; 2]> {
    section.line.windows(2).map(|pair| [lattice.to_local(pair[0]), lattice.to_local(pair[1])]).collect()
}

/// Refuses a section that lies on no cell of the terrain, and warns of one that lies beside it in part. A blocked building is no terrain, and
/// a section that runs into one is reported.
fn check_section(
    section: &Section,
    source: &Sourced<crate::scenario::VectorSource>,
    ground: &BedParticles,
    findings: &mut Findings,
) {
    let lattice = &ground.lattice;
    let pieces = pieces_of(section, lattice);
    let is_on_terrain = |place: Vec2| lattice.cell_of(place).is_some_and(|cell| ground.has_terrain(cell));
    let is_built_over =
        |place: Vec2| lattice.cell_of(place).is_some_and(|cell| ground.sealed.binary_search(&cell).is_ok());
    let outside = Outside::of(pieces.iter().copied(), lattice, |place| is_on_terrain(place) || is_built_over(place));
    let is_nowhere_open = Outside::of(pieces.iter().copied(), lattice, is_on_terrain).is_all();
    if let Some((length, place)) = outside.part(lattice.spacing).filter(|_| !is_nowhere_open) {
        let message = format!("{length:.0} m of the section `{}` lie on no terrain", section.id);
        let problem = Problem::warning(ProblemKind::Input, "section-outside", "", message)
            .with_cause("nothing is measured there")
            .with_remedy(IN_PART)
            .with_at(place);
        findings.add(source, problem);
    }
    if is_nowhere_open {
        let (lies, remedy) = if outside.is_all() {
            ("lies on no terrain", "check that the file and the terrain have the same CRS")
        } else {
            ("lies in a blocked building", "draw it where water can pass")
        };
        let problem = input_error("section-outside", format!("the section `{}` {lies}", section.id))
            .with_remedy(remedy)
            .with_at(section.line[0]);
        findings.add(source, problem);
    } else if section.line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>() < 2.0 * lattice.spacing {
        let message = format!("the section `{}` is shorter than two cells", section.id);
        let problem = Problem::warning(ProblemKind::Input, "section-short", "", message)
            .with_cause("it may pass between two particles and measure nothing")
            .with_remedy("draw it from bank to bank, or choose a finer `resolution`")
            .with_at(section.line[0]);
        findings.add(source, problem);
    } else if !parts_cells(&pieces, ground) {
        let message =
            format!("the section `{}` parts no two cells of the terrain, and nothing would pass it", section.id);
        let problem = input_error("section-on-edge", message)
            .with_cause("it lies along the edge of the terrain; what passes that stands in `tables/boundaries.csv`")
            .with_remedy(format!("draw it inside the terrain, at least {} m from its edge", readable(lattice.spacing)))
            .with_at(section.line[0]);
        findings.add(source, problem);
    }
}

/// Whether some of the pieces of a line (local coordinates, m) cross the way between two cells with terrain.
fn parts_cells(pieces: &[[Vec2; 2]], ground: &BedParticles) -> bool {
    let lattice = &ground.lattice;
    let mut ways = pieces.iter().flat_map(|piece| {
        let steps = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
        let from = crossed(piece, lattice).into_iter().filter(|cell| ground.has_terrain(*cell));
        from.flat_map(move |cell| steps.map(|(x, y)| (piece, lattice.centre(cell), Vec2::new(x, y) * lattice.spacing)))
    });
    ways.any(|(piece, centre, step)| {
        let other = lattice.cell_at(centre + step);
        other.is_some_and(|other| ground.has_terrain(other)) && segments_cross([centre, centre + step], *piece)
    })
}

/// The boundaries, and what is wrong with their places. Hands on those that have a condition.
fn boundaries(
    opened: &Opened,
    scenario: &Scenario,
    ground: &BedParticles,
    forcing: &mut Forcing,
    findings: &mut Findings,
) -> Vec<Placed> {
    let (lattice, bed) = (&ground.lattice, &ground.elevation[..]);
    let mut with_condition = Vec::new();
    let mut edges = edge_faces(lattice, bed);
    // The solver keeps the walls of buildings shut: what lies before them alone would open nothing.
    edges.retain(|(_, middle)| !ground.is_sealed(*middle));
    // Of each boundary that has a line and a condition: its place in the scenario, and what it would open alone.
    let mut placed: Vec<(&Sourced<crate::scenario::Boundary>, Vec<usize>)> = Vec::new();
    for (index, (source, (lines, condition))) in scenario.boundaries.iter().zip(&opened.boundaries).enumerate() {
        let mut pieces: Pieces = match (&source.value.place, lines) {
            (OpenBoundary::Side(Side::All), _) => edges.iter().map(|(_, midpoint)| [*midpoint; 2]).collect(),
            (OpenBoundary::Side(side), _) => {
                let mut open = OpenEdges::default();
                let passed_over = open_side(&mut open, *side, lattice, bed);
                warn_of_steps(source, passed_over, lattice, findings);
                open.pieces
            }
            (OpenBoundary::Lines(lines_source), Some(lines)) => {
                places::on_lattice(lines_source, lines, ground, places::NOT_OPEN, findings).into()
            }
            (OpenBoundary::Lines(_), None) => continue,
        };
        if pieces.is_empty() && !edges.is_empty() {
            continue;
        }
        let near = faces_opened(&mut pieces, &edges, lattice);
        if near.is_empty() {
            let problem = input_error("opens-nothing", "this boundary touches no edge of the terrain".to_owned())
                .with_cause(format!(
                    "no edge face along it lies within {} m; those square to it and the walls of buildings are none",
                    forcing.reach
                ))
                .with_remedy("draw it along the edge of the terrain data; water that comes in elsewhere is a source");
            findings.add(source, Problem { at: pieces.place().map(|place| lattice.to_map(place)), ..problem });
            continue;
        }
        for (other, faces) in &placed {
            let shared: Vec<usize> = near.iter().copied().filter(|face| faces.binary_search(face).is_ok()).collect();
            if shared.len() as f64 > SHARED * near.len().min(faces.len()) as f64 {
                let message =
                    format!("this boundary overlaps `{}` along {} faces of the edge", other.key, shared.len());
                let problem = input_error("overlapping-boundaries", message)
                    .with_remedy("let each part of the edge have one condition")
                    .with_at(lattice.to_map(edges[shared[0]].1));
                findings.add(source, problem);
            }
        }
        if let Some(condition) = condition {
            check_ground(source, condition, &near, (&edges, lattice, bed), findings);
            check_inflow(source, condition, (&near, &edges), scenario, (lattice, bed), findings);
            forcing.boundaries.push(Boundary { pieces, condition: condition.clone() });
            let faces = near.iter().map(|face| edges[*face]).collect();
            with_condition.push(Placed { index, faces });
        }
        placed.push((source, near));
    }
    with_condition
}

/// Warns of a side that stays a wall in part because its edge steps back there by more than a cell.
fn warn_of_steps(
    source: &Sourced<crate::scenario::Boundary>,
    (passed_over, opened): (Vec<Vec2>, usize),
    lattice: &Lattice,
    findings: &mut Findings,
) {
    let count = passed_over.len();
    if count as f64 > STEPPED * (count + opened) as f64 {
        let message = format!("{:.0} m of this side stay a wall", count as f64 * lattice.spacing);
        let problem = Problem::warning(ProblemKind::Input, "side-in-part", "", message)
            .with_cause("the edge of the terrain steps back by more than a cell there")
            .with_remedy("right where the ground stays dry; elsewhere draw a `line` along the edge, or fill the terrain up to it")
            .with_at(lattice.to_map(passed_over[0]));
        findings.add(source, problem);
    }
}

/// Whether the ground under a boundary fits its levels.
fn check_ground(
    source: &Sourced<crate::scenario::Boundary>,
    condition: &Condition,
    near: &[usize],
    (edges, lattice, bed): (&[(usize, Vec2)], &Lattice, &[f64]),
    findings: &mut Findings,
) {
    let lowest_of = |faces: &mut dyn Iterator<Item = usize>| {
        faces.map(|face| (bed[edges[face].0], edges[face].1)).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let Some((lowest, place)) = lowest_of(&mut near.iter().copied()) else { return };
    let highest = match condition {
        Condition::Stage(level)
        | Condition::Level(level)
        | Condition::Wave { level, .. }
        | Condition::Discharge { level: Some(level), .. } => Some(level.peak()),
        Condition::Rating(rating) => rating.rows().last().map(|row| row.0),
        _ => None,
    };
    if let Some(highest) = highest.filter(|highest| *highest <= lowest) {
        let message = format!(
            "the highest level of this boundary, {highest} m, is not above the lowest ground along it, {lowest:.2} m"
        );
        let problem = input_error("boundary-dry", message)
            .with_remedy("correct the level, its unit or its datum, or draw the boundary through the river bed")
            .with_at(lattice.to_map(place));
        findings.add(source, problem);
    }
    if let Condition::Discharge { .. } = condition {
        let beside = |&face: &usize| {
            let reach = 2.0 * REACH * lattice.spacing;
            let looks = |face: usize| edges[face].1 - lattice.centre(edges[face].0);
            // A side that begins around the corner is no bank of this one.
            let is_own =
                |own: usize| (edges[own].1 - edges[face].1).norm() <= reach && looks(own).dot(looks(face)) > 0.0;
            !near.contains(&face) && near.iter().any(|&own| is_own(own))
        };
        let outside = lowest_of(&mut (0..edges.len()).filter(beside));
        if let Some((ground, at)) = outside.filter(|(ground, _)| *ground < lowest) {
            let message = format!(
                "the edge beside this boundary is lower ({ground:.2} m) than all ground along it ({lowest:.2} m at least)"
            );
            let problem = Problem::warning(ProblemKind::Input, "lower-ground-beside", "", message)
                .with_cause("the line may miss the river bed: the water would come in over a bank")
                .with_remedy("draw the line across the whole river bed")
                .with_at(lattice.to_map(at));
            findings.add(source, problem);
        }
    }
}

/// Whether the level beside a discharge fits the ground at all times; one that is nowhere above it is refused by [`check_ground`].
fn check_inflow(
    source: &Sourced<crate::scenario::Boundary>,
    condition: &Condition,
    (near, edges): (&[usize], &[(usize, Vec2)]),
    scenario: &Scenario,
    (lattice, bed): (&Lattice, &[f64]),
    findings: &mut Findings,
) {
    let (
        Condition::Discharge { discharge, level: Some(levels) },
        BoundaryCondition::Discharge { level: Some(timed), .. },
    ) = (condition, &source.value.condition)
    else {
        return;
    };
    let strip = |face: &usize| Strip { width: lattice.spacing, bed: bed[edges[*face].0] };
    let strips: Vec<Strip> = near.iter().map(strip).collect();
    if strips.iter().all(|strip| strip.bed >= levels.peak()) {
        return;
    }
    let gravity = scenario.numerics.gravity;
    let inlet = Inlet { name: "this boundary", strips: &strips, gravity, end: scenario.end_time };
    if let Some(problem) = levels::check_inflow(timed, (discharge, levels), inlet) {
        let (key, place) = timed.source();
        findings.add_at(key, place.cloned(), problem);
    }
}
