//! Water that comes out of the ground: the files of its places and lines, and where they lie on the terrain.

use std::collections::BTreeMap;

use crate::bed::BedParticles;
use crate::boundary::{Forcing, LineSource, PointSource, Series};
use crate::error::{Problem, ProblemKind, Severity, input_error};
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::prepare::findings::Findings;
use crate::prepare::forcing::plausible::torrent;
use crate::prepare::ground::burn::lengths;
use crate::prepare::places;
use crate::prepare::tables::dates::Origin;
use crate::prepare::tables::{rows, series};
use crate::scenario::{BuildingMode, Scenario, SourcePlace, Sourced, VectorSource};
use crate::vector::Feature;

/// Share of a cell that a line may reach beyond the terrain: the rounding of its coordinates.
const SAME_PLACE: f64 = 1e-6;

/// The name of the edges of a cell over which the water of a point runs off.
const SPRING: &str = "the edges of the cell of this source";

/// The places of a source and its discharge.
pub type Opened = (Places, Option<Series>);

/// Where water comes out of the ground (map coordinates).
#[derive(Debug)]
pub enum Places {
    Points(Vec<Vec2>),
    /// Of each feature its number in the file and its parts, which share one discharge.
    Lines(Vec<(usize, Vec<Vec<Vec2>>)>),
}

impl Places {
    /// How many points and lines these are.
    pub fn count(&self) -> (usize, usize) {
        match self {
            Places::Points(points) => (points.len(), 0),
            Places::Lines(lines) => (0, lines.len()),
        }
    }
}

/// Opens the files of each.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Vec<Opened> {
    let opened = scenario.sources.iter().map(|source| {
        let places = match &source.value.place {
            SourcePlace::At(at) => Places::Points(vec![Vec2::new(at.value[0], at.value[1])]),
            SourcePlace::Lines(lines) => {
                let features = places::features(lines, crs, findings);
                let opened = features.is_some();
                let features = features.unwrap_or_default();
                let found: Vec<(usize, Vec<Vec<Vec2>>)> = features
                    .iter()
                    .map(|feature| (feature.number, lines_of(feature)))
                    .filter(|(_, parts)| !parts.is_empty())
                    .collect();
                if opened && found.is_empty() {
                    let message = format!("{} holds no line", lines.value.path.display());
                    let remedy = "draw lines along which the water comes out of the ground";
                    findings.add(lines, input_error("no-lines", message).with_remedy(remedy));
                } else if found.len() < features.len() {
                    let is_without = |feature: &&Feature| !found.iter().any(|(number, _)| *number == feature.number);
                    findings.add(lines, without_lines(lines, features.iter().filter(is_without)));
                }
                Places::Lines(found)
            }
            SourcePlace::Points(points) => {
                let features = places::features(points, crs, findings).unwrap_or_default();
                let others = places::left_out(points, &features, "point", |feature| !feature.points.is_empty());
                findings.add_all(
                    points,
                    others.map(|problem| Problem { severity: Severity::Error, code: "not-a-point", ..problem }),
                );
                let found: Vec<Vec2> = features.iter().flat_map(|f| f.points.iter().map(|(place, _)| *place)).collect();
                if found.is_empty() {
                    let message = format!("{} holds no point", points.value.path.display());
                    let remedy = "draw points where the water comes out of the ground";
                    findings.add(points, input_error("no-points", message).with_remedy(remedy));
                }
                Places::Points(found)
            }
        };
        let span = (scenario.end_time, Origin::of_run(scenario));
        (places, series::series(&source.value.discharge, rows::COMING, span, findings))
    });
    opened.collect()
}

/// The problem of features beside the lines of a file from which no water would come.
fn without_lines<'a>(lines: &Sourced<VectorSource>, left_out: impl Iterator<Item = &'a Feature>) -> Problem {
    let numbers: Vec<String> = left_out.map(|feature| feature.number.to_string()).collect();
    let (path, numbers) = (lines.value.path.display(), numbers.join(", "));
    input_error("not-a-line", format!("{path} holds features that are no lines beside its lines: feature {numbers}"))
        .with_cause("no water would come from points, polygons and lines without length")
        .with_remedy("take them out of the file, draw them as lines, or name points in a source of its own by `points`")
}

/// The lines of a feature that have a length.
pub fn lines_of(feature: &Feature) -> Vec<Vec<Vec2>> {
    let lines = feature.lines.iter().map(|line| {
        let mut places: Vec<Vec2> = line.0.iter().map(|c| Vec2::new(c.x, c.y)).collect();
        places.dedup();
        places
    });
    lines.filter(|places| places.len() >= 2).collect()
}

/// Puts the sources on the lattice, and refuses what does not lie on the terrain.
pub fn on_lattice(
    opened: &[Opened],
    scenario: &Scenario,
    ground: &BedParticles,
    forcing: &mut Forcing,
    findings: &mut Findings,
) {
    let lattice = &ground.lattice;
    for (source, (places, discharge)) in scenario.sources.iter().zip(opened) {
        match places {
            Places::Points(places) => {
                // It leaves its cell over four edges.
                let torrent = discharge.as_ref().and_then(|q| torrent(SPRING, q, 4.0 * lattice.spacing, scenario));
                findings.add_all(source, torrent);
                for place in places {
                    let own = lattice.to_local(*place);
                    let has_terrain =
                        |place: &Vec2| lattice.cell_at(*place).is_some_and(|cell| ground.has_terrain(cell));
                    let local =
                        beside_edges(lattice).map(|shift| own + shift).into_iter().find(has_terrain).unwrap_or(own);
                    let cell = lattice.cell_at(local);
                    if cell.is_none_or(|cell| !ground.has_terrain(cell)) {
                        findings.add(source, source_outside("this source lies", cell.is_none(), *place, scenario));
                    }
                    if let Some(discharge) = discharge {
                        forcing.sources.push(PointSource { place: local, discharge: discharge.clone() });
                    }
                }
            }
            Places::Lines(lines) => {
                findings
                    .add_all(source, discharge.as_ref().and_then(|discharge| several_lines(lines.len(), discharge)));
                for (number, parts) in lines {
                    let name = format!("{} feature {number}", source.key);
                    match line_on_lattice(parts, scenario, ground) {
                        Err(problem) => findings.add(source, problem),
                        Ok(cells) => {
                            let Some(discharge) = discharge.clone() else { continue };
                            // To both sides of the line.
                            let width = 2.0 * cells.len() as f64 * lattice.spacing;
                            findings
                                .add_all(source, torrent(&format!("feature {number}"), &discharge, width, scenario));
                            forcing.line_sources.push(LineSource { name, cells, discharge });
                        }
                    }
                }
            }
        }
    }
}

/// Tells what comes out of the lines of one file together, where it has several.
fn several_lines(count: usize, discharge: &Series) -> Option<Problem> {
    let each = discharge.peak();
    let at_most = if discharge.points().all(|point| point.1.to_bits() == each.to_bits()) { "" } else { "at most " };
    (count > 1).then(|| {
        let sum = (count as f64 * each * 1e9).round() / 1e9;
        let message = format!("{count} lines of {at_most}{each} m3/s each: {at_most}{sum} m3/s");
        Problem::warning(ProblemKind::Input, "several-lines", "", message)
            .with_cause("each line of the file gives the whole `discharge`; the parts of one feature share it")
            .with_remedy("nothing, if it is meant; otherwise join the lines in one feature, or divide the discharge")
    })
}

/// The steps by which a place may be taken for one beside it: on an edge between two cells it is in both of them, so that the four
/// edges of the terrain and its corners are alike.
fn beside_edges(lattice: &Lattice) -> [Vec2; 9] {
    let step = SAME_PLACE * lattice.spacing;
    let ways = [(0, 0), (-1, 0), (0, -1), (1, 0), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)];
    ways.map(|(x, y)| Vec2::new(f64::from(x), f64::from(y)) * step)
}

/// The step across the edge between two columns or two rows of cells on which a piece lies; none where it does not.
fn across_its_edge([start, end]: [Vec2; 2], lattice: &Lattice) -> Option<Vec2> {
    let is_on_edge = |a: f64, b: f64| {
        let (a, b) = (a / lattice.spacing, b / lattice.spacing);
        (a - a.round()).abs() < SAME_PLACE && (b - a.round()).abs() < SAME_PLACE
    };
    let step = 2.0 * SAME_PLACE * lattice.spacing;
    if is_on_edge(start.x, end.x) {
        Some(Vec2::new(step, 0.0))
    } else if is_on_edge(start.y, end.y) {
        Some(Vec2::new(0.0, step))
    } else {
        None
    }
}

/// A piece as it stands; one that lies on an edge between two cells in parts, one for each two cells.
fn in_parts([start, end]: [Vec2; 2], lattice: &Lattice) -> Vec<[Vec2; 2]> {
    let Some(across) = across_its_edge([start, end], lattice) else { return vec![[start, end]] };
    let (from, to) = if across.x > 0.0 { (start.y, end.y) } else { (start.x, end.x) };
    let (low, high) = (from.min(to) / lattice.spacing, from.max(to) / lattice.spacing);
    let corners = (low.floor() as i64 + 1..high.ceil() as i64).map(|corner| corner as f64 * lattice.spacing);
    let mut cuts: Vec<f64> = corners.map(|corner| (corner - from) / (to - from)).chain([0.0, 1.0]).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.windows(2).map(|cut| [cut[0], cut[1]].map(|share| start + (end - start) * share)).collect()
}

/// The cells of the lines of a feature with the share of their length that lies in each; a problem where a part of it lies on no
/// terrain.
fn line_on_lattice(
    parts: &[Vec<Vec2>],
    scenario: &Scenario,
    ground: &BedParticles,
) -> Result<Vec<(usize, f64)>, Problem> {
    let lattice = &ground.lattice;
    let mut cells = LineCells::default();
    for part in parts {
        let line: Vec<Vec2> = part.iter().map(|place| lattice.to_local(*place)).collect();
        for piece in line.windows(2).flat_map(|piece| on_one_side([piece[0], piece[1]], ground)) {
            cells.add(piece, ground);
        }
    }
    if let Some(place) = cells.outside.or(cells.bare) {
        let what = format!("{:.1} m of this line lie", cells.off);
        return Err(source_outside(&what, cells.outside.is_some(), lattice.to_map(place), scenario));
    }
    let total: f64 = cells.on_terrain.values().sum();
    Ok(cells.on_terrain.into_iter().map(|(cell, length)| (cell, length / total)).collect())
}

/// The cells of a line, and what of it lies on no terrain.
#[derive(Default)]
struct LineCells {
    /// Length (m) in each cell with terrain.
    on_terrain: BTreeMap<usize, f64>,
    /// Length (m) on no terrain.
    off: f64,
    /// The first place outside the lattice.
    outside: Option<Vec2>,
    /// The first place in a cell without terrain.
    bare: Option<Vec2>,
}

impl LineCells {
    /// Adds a piece of the line: along an edge half of it to either side, elsewhere where most of it lies on terrain.
    fn add(&mut self, piece: [Vec2; 2], ground: &BedParticles) {
        let lattice = &ground.lattice;
        let attempt = |shift: Vec2| PieceCells::of(piece.map(|place| place + shift), ground);
        if let Some(across) = across_its_edge(piece, lattice) {
            let [one, other] = [-across, across].map(attempt);
            if one.off <= 0.0 && other.off <= 0.0 {
                for (cell, length) in one.on_terrain.into_iter().chain(other.on_terrain) {
                    *self.on_terrain.entry(cell).or_insert(0.0) += 0.5 * length;
                }
                return;
            }
        }
        let mut best = attempt(Vec2::ZERO);
        for shift in beside_edges(lattice) {
            if best.off <= 0.0 {
                break;
            }
            let other = attempt(shift);
            if other.off < best.off {
                best = other;
            }
        }
        self.off += best.off;
        self.outside = self.outside.or(best.beside.first().map(|piece| (piece[0] + piece[1]) * 0.5));
        self.bare = self.bare.or(best.bare.first().map(|(cell, _)| lattice.centre(*cell)));
        for (cell, length) in best.on_terrain {
            *self.on_terrain.entry(cell).or_insert(0.0) += length;
        }
    }
}

/// The cells of a straight piece, each with the length (m) in it.
struct PieceCells {
    on_terrain: Vec<(usize, f64)>,
    /// Cells without terrain.
    bare: Vec<(usize, f64)>,
    /// Parts outside the lattice.
    beside: Vec<[Vec2; 2]>,
    /// Length (m) on no terrain.
    off: f64,
}

impl PieceCells {
    fn of(piece: [Vec2; 2], ground: &BedParticles) -> PieceCells {
        let slack = SAME_PLACE * ground.lattice.spacing;
        let (inside, mut beside) = lengths(&piece, &ground.lattice);
        beside.retain(|piece| (piece[1] - piece[0]).norm() > slack);
        let (on_terrain, mut bare): (Vec<_>, Vec<_>) =
            inside.into_iter().partition(|(cell, _)| ground.has_terrain(*cell));
        bare.retain(|(_, length)| *length > slack);
        let off = beside.iter().map(|piece| (piece[1] - piece[0]).norm()).sum::<f64>()
            + bare.iter().map(|(_, length)| length).sum::<f64>();
        PieceCells { on_terrain, bare, beside, off }
    }

    fn is_on_terrain(&self) -> bool {
        self.beside.is_empty() && self.bare.is_empty()
    }
}

/// A piece as it stands, or in its parts between cells where all of them lie on terrain: so that a problem is that of the whole piece.
fn on_one_side(piece: [Vec2; 2], ground: &BedParticles) -> Vec<[Vec2; 2]> {
    let lattice = &ground.lattice;
    let parts = in_parts(piece, lattice);
    let has_ground = |part: &[Vec2; 2]| {
        let is_ground = |shift: Vec2| PieceCells::of(part.map(|place| place + shift), ground).is_on_terrain();
        across_its_edge(*part, lattice).is_none_or(|across| is_ground(-across) || is_ground(across))
    };
    if parts.iter().all(has_ground) { parts } else { vec![piece] }
}

/// The problem of a source at a place (map coordinates) beside the terrain, or on a part of it that has none.
fn source_outside(what: &str, is_outside: bool, place: Vec2, scenario: &Scenario) -> Problem {
    let is_blocked = scenario.ground.buildings.as_ref().is_some_and(|buildings| buildings.mode == BuildingMode::Block);
    let where_ = match (is_outside, is_blocked) {
        (true, _) => "outside the terrain",
        (false, true) => "where the terrain has no data or a building blocks it",
        (false, false) => "where the terrain has no data",
    };
    let remedy = if scenario.channels.is_empty() {
        "check its coordinates, their order and their CRS"
    } else {
        "check its coordinates, their order and their CRS; water comes into a channel by its `upstream`"
    };
    input_error("source-outside", format!("{what} {where_}")).with_remedy(remedy).with_at(place)
}
