//! Gauges, walls and open lines.

use crate::bed::{BedParticles, NINE_CELLS, Surface, is_divided_about};
use crate::boundary::{Pieces, edge_faces};
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::geodata::{Crs, Table, read_text, readable_file};
use crate::math::{Rectangle, Vec2};
use crate::output::Gauge;
use crate::prepare::findings::Findings;
use crate::prepare::grid::{REACH, faces_opened, open_side};
use crate::prepare::outside::{Outside, all_outside, partly_outside};
use crate::prepare::tables::rows::unit_in_name;
use crate::prepare::tables::series::names_a_length;
use crate::scenario::units::LENGTH;
use crate::scenario::{OpenBoundary, Scenario, Sourced, TerrainLayer, VectorSource};
use crate::solver::OpenEdges;
use crate::vector::{self, Feature};

/// What comes of the part of a boundary that lies on no terrain.
pub(super) const NOT_OPEN: &str = "it opens nothing there, and acts on the rest alone";
/// The same of a wall.
pub(super) const NOT_HELD: &str = "no water comes there, and the wall holds none";

/// The features of a vector file in the coordinates of the run; as they stand where the CRS of the run is not known.
pub(super) fn features(
    source: &Sourced<VectorSource>,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<Vec<Feature>> {
    let VectorSource { path, layer } = &source.value;
    let file = findings.take(source, vector::open(path, layer.as_deref()))?;
    let Some(crs) = crs else {
        return Some(file.features);
    };
    let (features, warnings) = findings.take(source, file.in_run_crs(path, crs))?;
    findings.add_all(source, warnings);
    Some(features)
}

/// The features of a vector file that reach into the part of the terrain that is read, all of them without a part; none where no feature does.
/// For what acts on the ground and the flow where it stands alone.
pub(super) fn features_near(
    source: &Sourced<VectorSource>,
    crs: Option<&Crs>,
    scenario: &Scenario,
    findings: &mut Findings,
) -> Option<Vec<Feature>> {
    let mut found = features(source, crs, findings)?;
    let Some(part) = scenario.reading.part else { return Some(found) };
    let is_near = |feature: &Feature| match feature.rectangle() {
        Some(rectangle) => part.own.meets(rectangle),
        None => true,
    };
    found.retain(is_near);
    Some(found).filter(|found| !found.is_empty())
}

/// So many features are named one by one.
const NAMED_FEATURES: usize = 5;

/// Tells which features of a file are left out beside others that are not: what is wanted of each, and whether one has it.
pub(super) fn left_out(
    source: &Sourced<VectorSource>,
    features: &[Feature],
    wanted: &str,
    is_kept: impl Fn(&Feature) -> bool,
) -> Option<Problem> {
    let others: Vec<&Feature> = features.iter().filter(|feature| !is_kept(feature)).collect();
    if others.is_empty() || others.len() == features.len() {
        return None;
    }
    let numbers: Vec<String> = others.iter().take(NAMED_FEATURES).map(|feature| feature.number.to_string()).collect();
    let more = if others.len() > NAMED_FEATURES { " and more" } else { "" };
    let (count, name, numbers) = (others.len(), source.value.path.display(), numbers.join(", "));
    let message = format!("{count} of {} features of {name} hold no {wanted}: feature {numbers}{more}", features.len());
    let problem = input_warning("left-out", message).with_cause("they are left out");
    Some(problem.with_remedy(format!("take them out of the file, or draw them with a {wanted}")))
}

/// What is wrong or doubtful about the unit of lengths that an attribute holds, the first of some names that a feature has: they are
/// read in metres.
pub(super) fn unit_of_attribute(
    source: &Sourced<VectorSource>,
    names: &[&str],
    features: &[Feature],
    scenario: &Scenario,
) -> Option<Problem> {
    let name = names.iter().find(|name| features.iter().any(|feature| feature.number(name).is_some()))?;
    let attribute = format!("the attribute `{name}` of {}", source.value.path.display());
    let lower = name.to_lowercase();
    if names_a_length(&lower) {
        let message = format!("{attribute} names a unit, and its values would be read as metres");
        return Some(
            input_error("unit-of-attribute", message)
                .with_remedy("bring them to metres, in an attribute of another name"),
        );
    }
    let unit_of_terrain = |layer: &Sourced<TerrainLayer>| match &layer.value {
        TerrainLayer::Raster { unit, .. } => unit.filter(|unit| (unit - 1.0).abs() > 1e-9),
        TerrainLayer::Points { .. } => None,
    };
    let unit = scenario.layers.iter().find_map(unit_of_terrain).filter(|_| unit_in_name(&lower, &LENGTH).is_none())?;
    let message = format!("{attribute} is read in metres, and the terrain counts in units of {unit} m");
    Some(input_warning("unit-of-attribute", message).with_remedy(format!(
        "nothing, if its values are in metres (`{name}_m` would say so); otherwise bring them to metres"
    )))
}

/// Whether a line has a length.
pub(super) fn has_length(line: &geo::LineString<f64>) -> bool {
    line.0.windows(2).any(|pair| pair[0] != pair[1])
}

/// What a file draws as lines (map coordinates).
#[derive(Clone, Debug, Default)]
pub(super) struct Drawn {
    /// Its straight pieces; outlines of polygons count as lines.
    pub pieces: Vec<[Vec2; 2]>,
    /// Whether each belongs to the outline of a polygon.
    of_outlines: Vec<bool>,
}

/// The straight pieces of the lines of a file.
pub(super) fn pieces(
    source: &Sourced<VectorSource>,
    crs: Option<&Crs>,
    scenario: &Scenario,
    findings: &mut Findings,
) -> Option<Drawn> {
    let features = features_near(source, crs, scenario, findings)?;
    let is_drawn = |feature: &Feature| feature.lines.iter().any(has_length) || !feature.polygons.is_empty();
    findings.add_all(source, left_out(source, &features, "line", is_drawn));
    let as_vec = |c: geo::Coord<f64>| Vec2::new(c.x, c.y);
    let lines = features.iter().flat_map(|feature| {
        let outlines = feature.polygons.iter().map(|polygon| (polygon.exterior(), true));
        feature.lines.iter().map(|line| (line, false)).chain(outlines)
    });
    let (pieces, of_outlines): (Vec<[Vec2; 2]>, Vec<bool>) = lines
        .flat_map(|(line, is_outline)| line.lines().map(move |piece| (piece, is_outline)))
        .map(|(piece, is_outline)| ([as_vec(piece.start), as_vec(piece.end)], is_outline))
        .filter(|([a, b], _)| a != b)
        .unzip();
    if pieces.is_empty() {
        findings.add(
            source,
            input_error("no-lines", format!("{} holds no line", source.value.path.display()))
                .with_remedy("draw lines, or polygons whose outlines count as lines"),
        );
        return None;
    }
    let Some(part) = scenario.reading.part else { return Some(Drawn { pieces, of_outlines }) };
    let within = |(piece, is_outline)| Some((part.cut(piece)?, is_outline));
    let (pieces, of_outlines) = pieces.into_iter().zip(of_outlines).filter_map(within).unzip();
    Some(Drawn { pieces, of_outlines }).filter(|drawn| !drawn.pieces.is_empty())
}

/// Brings lines to local coordinates; refuses those that lie beside the terrain altogether, and warns of those that lie beside it in
/// part and so have no effect there. The outline of a polygon may reach beyond the terrain: it is drawn around something.
pub(super) fn on_lattice(
    source: &Sourced<VectorSource>,
    drawn: &Drawn,
    bed: &BedParticles,
    effect: &str,
    findings: &mut Findings,
) -> Vec<[Vec2; 2]> {
    let lattice = &bed.lattice;
    let local: Vec<[Vec2; 2]> = drawn.pieces.iter().map(|piece| piece.map(|p| lattice.to_local(p))).collect();
    let of_lines = local.iter().zip(&drawn.of_outlines).filter(|(_, is_outline)| !**is_outline);
    let lines = Outside::beyond_reach(of_lines.map(|(piece, _)| *piece), bed);
    if let Some(first) = drawn.pieces.first()
        && lines.is_all()
        && Outside::beyond_reach(local.iter().copied(), bed).is_all()
    {
        all_outside(source, first[0], findings);
        return Vec::new();
    }
    findings.add_all(source, partly_outside(source, lines, lattice.spacing, effect));
    local
}

/// The edges along sides and lines of the scenario.
pub(super) fn edges_along(
    scenario: &Scenario,
    edges: &[OpenBoundary],
    lines: &[Option<Drawn>],
    ground: &BedParticles,
    findings: &mut Findings,
) -> OpenEdges {
    let (lattice, bed) = (&ground.lattice, &ground.elevation[..]);
    let mut open = OpenEdges { reach: REACH * lattice.spacing, ..OpenEdges::default() };
    for (boundary, pieces) in edges.iter().zip(lines) {
        match (boundary, pieces) {
            // Where the terrain goes on beyond the part that is read, its side is elsewhere.
            (OpenBoundary::Side(side), _) if scenario.reading.part.is_some_and(|part| part.is_cut(*side)) => {}
            (OpenBoundary::Side(side), _) => {
                open_side(&mut open, *side, lattice, bed);
            }
            (OpenBoundary::Lines(source), Some(drawn)) => {
                let mut pieces = Pieces::from(on_lattice(source, drawn, ground, NOT_OPEN, findings));
                if !pieces.is_empty() && faces_opened(&mut pieces, &edge_faces(lattice, bed), lattice).is_empty() {
                    let message = format!("the lines of {} open no edge of the terrain", source.value.path.display());
                    let problem = Problem::warning(ProblemKind::Input, "opens-nothing", "", message)
                        .with_cause(format!("no edge face along them lies within {} m", REACH * lattice.spacing))
                        .with_remedy("draw them along the edge of the terrain data");
                    findings.add(source, problem);
                }
                open.pieces.join(&pieces);
            }
            (OpenBoundary::Lines(_), None) => {}
        }
    }
    open
}

/// The gauges of a file: CSV with columns id, x, y, or any vector file of points with an attribute `id` or `name`.
pub(super) fn gauges(source: &Sourced<VectorSource>, crs: Option<&Crs>, findings: &mut Findings) -> Vec<Gauge> {
    let path = &source.value.path;
    let is_table = path.extension().is_some_and(|e| ["csv", "txt", "tsv"].iter().any(|t| e.eq_ignore_ascii_case(t)));
    let gauges = if is_table {
        findings.take(source, gauges_of_table(path))
    } else {
        features(source, crs, findings).map(|features| {
            findings.add_all(source, left_out(source, &features, "point", |feature| !feature.points.is_empty()));
            features.iter().flat_map(gauges_of_feature).collect()
        })
    };
    let Some(gauges) = gauges else {
        return Vec::new();
    };
    if gauges.is_empty() {
        findings.add(
            source,
            input_error("no-gauges", format!("{} holds no gauge", path.display()))
                .with_remedy("give it points, or lines with id, x and y below the first line; or take the key away"),
        );
    }
    for (i, gauge) in gauges.iter().enumerate() {
        if gauges[..i].iter().any(|earlier| earlier.id == gauge.id) {
            let message = format!("{} holds more than one gauge `{}`", path.display(), gauge.id);
            findings.add(
                source,
                input_error("duplicate-gauge", message)
                    .with_remedy("give each gauge its own id")
                    .with_at(gauge.position),
            );
        }
    }
    gauges
}

fn gauges_of_table(path: &std::path::Path) -> Result<Vec<Gauge>, Problem> {
    readable_file(path)?;
    let name = path.display();
    let text = read_text(path).map_err(|error| {
        input_error("not-a-table", format!("{name} is no table of gauges"))
            .with_cause(error.to_string())
            .with_remedy("name a CSV file with the columns id,x,y, or a vector file with points")
    })?;
    let table = Table::parse(&text, |_| true);
    if let Some((line, fields)) = table.overlong().next() {
        return Err(input_error(
            "too-many-fields",
            format!("line {line} of {name} has more fields than the first line"),
        )
        .with_cause(format!("it reads `{}`", fields.join(",")))
        .with_remedy("write numbers with a point as decimal sign, and name every column in the first line"));
    }
    let header = table.header.clone().unwrap_or_default();
    let column = |names: &[&str]| {
        table.column(names).ok_or_else(|| {
            input_error("missing-column", format!("{name} has no column `{}`", names[0]))
                .with_cause(format!("its columns are {}", header.join(", ")))
                .with_remedy("give it a first line with the names id,x,y; further columns are kept")
        })
    };
    let (id, x, y) = (column(&["id", "name"])?, column(&["x", "easting"])?, column(&["y", "northing"])?);
    let mut gauges = Vec::with_capacity(table.rows.len());
    for (line, fields) in &table.rows {
        let number = |column: usize| fields.get(column).and_then(|f| f.parse::<f64>().ok()).filter(|v| v.is_finite());
        let (Some(easting), Some(northing), Some(id_text)) = (number(x), number(y), fields.get(id)) else {
            return Err(input_error(
                "bad-gauge-line",
                format!("line {line} of {name} does not give a gauge with two finite numbers x and y"),
            )
            .with_cause(format!("it reads `{}`", fields.join(",")))
            .with_remedy("separate the columns as in the first line, with a point as decimal sign"));
        };
        let kept = |i: &usize| ![id, x, y].contains(i);
        let attributes =
            (0..fields.len().min(header.len())).filter(kept).map(|i| (header[i].clone(), fields[i].clone())).collect();
        gauges.push(Gauge { id: id_text.clone(), position: Vec2::new(easting, northing), attributes });
    }
    Ok(gauges)
}

fn gauges_of_feature(feature: &Feature) -> Vec<Gauge> {
    let named = feature.attribute("id").or_else(|| feature.attribute("name"));
    let id = named.map_or_else(|| feature.number.to_string(), ToString::to_string);
    let is_other = |name: &str| !["id", "x", "y"].iter().any(|known| name.eq_ignore_ascii_case(known));
    let attributes: Vec<(String, String)> = feature
        .attributes
        .iter()
        .filter(|(name, _)| is_other(name))
        .map(|(name, value)| (name.clone(), value.to_string()))
        .collect();
    let several = feature.points.len() > 1;
    let gauge = |(i, (position, _)): (usize, &(Vec2, Option<f64>))| Gauge {
        id: if several { format!("{id}.{}", i + 1) } else { id.clone() },
        position: *position,
        attributes: attributes.clone(),
    };
    feature.points.iter().enumerate().map(gauge).collect()
}

/// The cells of gauges at an upright bank: those of which an upright step of the terrain's pixels divides the square of three cells about them, as
/// beside the rim of still water; ascending.
pub(super) fn cells_at_banks(gauges: &[Gauge], surface: &impl Surface, bed: &BedParticles) -> Vec<usize> {
    let lattice = &bed.lattice;
    let is_at_bank = |&cell: &usize| bed.has_terrain(cell) && is_divided_about(surface, bed, cell, NINE_CELLS);
    let homes = gauges.iter().filter_map(|gauge| lattice.cell_of(lattice.to_local(gauge.position)));
    let mut cells: Vec<usize> = homes.filter(is_at_bank).collect();
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// Warns of gauges that no water can reach, with the extent of the terrain and its surface; refuses them when all lie outside the terrain, which is a fault of coordinates.
pub(super) fn check_gauges(
    source: &Sourced<VectorSource>,
    gauges: &[Gauge],
    extent: Rectangle,
    (surface, bed, holds): (&impl Surface, &BedParticles, &(dyn Fn(Vec2) -> Option<bool> + Sync)),
    findings: &mut Findings,
) {
    let Rectangle { low: min, high: max } = extent;
    let is_outside = |Vec2 { x, y }: Vec2| x < min.x || y < min.y || x > max.x || y > max.y;
    if let Some(first) = gauges.first()
        && gauges.iter().all(|gauge| is_outside(gauge.position))
    {
        let message = format!("every gauge of {} lies outside the terrain", source.value.path.display());
        let problem = input_error("gauges-outside-terrain", message)
            .with_cause(format!(
                "the terrain reaches from {:.0}, {:.0} to {:.0}, {:.0}; the first gauge is `{}`",
                min.x, min.y, max.x, max.y, first.id
            ))
            .with_remedy("check the CRS of the gauges and the order of their coordinates")
            .with_at(first.position);
        findings.add(source, problem);
        return;
    }
    let lattice = &bed.lattice;
    let has_cell = |place: Vec2| lattice.cell_of(lattice.to_local(place)).is_some_and(|cell| bed.has_terrain(cell));
    for gauge in gauges.iter().filter(|gauge| holds(gauge.position) != Some(true)) {
        let (code, what, remedy) = if is_outside(gauge.position) {
            let remedy = "correct its coordinates, take it out, or give a terrain that holds it";
            ("gauge-outside-terrain", "lies outside the terrain", remedy)
        } else if holds(gauge.position) == Some(false) || surface.elevation(gauge.position).is_none() {
            let remedy = "move it to ground that water can reach, or take it out";
            ("gauge-on-nodata", "lies where the terrain has no data, or in a building,", remedy)
        } else if !has_cell(gauge.position) {
            let remedy = "move it inwards by a cell, or take it out";
            ("gauge-on-nodata", "lies at the edge of the terrain, in a cell whose centre has none,", remedy)
        } else {
            continue;
        };
        let problem =
            Problem::warning(ProblemKind::Input, code, "", format!("gauge `{}` {what} and will stay dry", gauge.id));
        findings.add(source, problem.with_remedy(remedy).with_at(gauge.position));
    }
}
