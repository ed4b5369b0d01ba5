//! Water of the start without a level: areas and rivers of one depth. Where a run goes on from an earlier one: [`crate::prepare::water::earlier`].
//!
//! Water of a depth lies on cells that no body of still water holds. A river takes the cells of a strip along its axis
//! ([`crate::prepare::ground::burn`]).

use geo::MultiPolygon;

use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::geodata::Crs;
use crate::math::Vec2;
use crate::prepare::findings::Findings;
use crate::prepare::ground::Changes;
use crate::prepare::ground::burn::{lengths, strip};
use crate::prepare::outside::{Outside, partly_outside};
use crate::prepare::places;
use crate::prepare::polygons::cells_inside;
use crate::prepare::water;
use crate::prepare::water::earlier::how_it_ended;
use crate::scenario::methods::Seeding;
use crate::scenario::{BoundaryCondition, EarlierRun, RiverWidth, Scenario, WaterOfDepth};
use crate::seeding::StillWater;
use crate::vector::Feature;

/// Depth (m) that no river has, and that hardly any water has everywhere.
const DEEPEST_RIVER: f64 = 100.0;
const DEEPEST_WATER: f64 = 1000.0;

/// A share by which the cells of a river may hold another volume before that is reported.
const TOLD_SIZE: f64 = 0.25;

/// The place of water with a depth; map coordinates.
#[derive(Debug)]
enum Place {
    Area(MultiPolygon<f64>),
    /// Lines with the width (m) of each.
    River(Vec<(Vec<Vec2>, f64)>),
}

/// What could be opened, for each entry.
#[derive(Debug, Default)]
pub struct Opened(Vec<Option<Place>>);

/// Opens the files of water with a depth, and refuses what the variational formulation does not have.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Opened {
    if !scenario.numerics.has_cells() {
        refuse_for_particles(scenario, findings);
    }
    if let Some(earlier) = &scenario.start.earlier {
        check_earlier(earlier, scenario, findings);
    }
    Opened(scenario.start.depths.iter().map(|water| place(water, crs, scenario, findings)).collect())
}

/// Refuses water of the start that the variational formulation does not have.
fn refuse_for_particles(scenario: &Scenario, findings: &mut Findings) {
    let start = &scenario.start;
    let refused = |message: &str, cause: &str, remedy: &str| {
        Problem::error(ProblemKind::Scenario, "method-combination", "", message).with_cause(cause).with_remedy(remedy)
    };
    let equal = scenario.numerics.seeding == Seeding::EqualVolume;
    if let Some(earlier) = &start.earlier {
        let problem = refused(
            "the variational formulation does not go on where another run was",
            "its depths are sums over the particles around, so that those of the file would not come back",
            "leave `numerics.formulation` out (or write `formulation: balanced`)",
        );
        findings.add(&earlier.fields, problem);
    }
    for water in start.depths.iter().filter(|_| equal) {
        let problem = refused(
            "equal-volume filling knows no water of a depth",
            "it fills bodies of still water to their level",
            "write `seeding: lattice`, or give a `level`",
        );
        findings.add(&water.place, problem);
    }
}

/// Whether this scenario can go on from an earlier run, and what of it does not carry over.
fn check_earlier(earlier: &EarlierRun, scenario: &Scenario, findings: &mut Findings) {
    let table = earlier.fields.value.with_file_name("tables").join("channels.csv");
    let message = match (scenario.channels.is_empty(), table.is_file()) {
        (false, _) => Some("a run with `channels` does not go on where another run was".to_owned()),
        (true, true) => Some(format!("{} is of a run with channels", earlier.fields.value.display())),
        (true, false) => None,
    };
    if let Some(message) = message {
        let problem = Problem::error(ProblemKind::Scenario, "channels-of-earlier-run", "", message)
            .with_cause("`fields.nc` has the water of the plane only, and that in the channels would be lost")
            .with_remedy("run it whole, from its start: give water with a level or a depth, and a later `time.end`");
        findings.add(&earlier.fields, problem);
    }
    for rain in scenario.rain.iter().filter(|rain| rain.value.initial_loss > 0.0) {
        let message = "the initial loss of the rain is taken from the start of this run on";
        let problem = Problem::warning(ProblemKind::Scenario, "losses-after-earlier-run", "", message)
            .with_cause("if it rained in the earlier run, the ground has had its initial loss already")
            .with_remedy("leave `rain.losses.initial` out, if so");
        findings.add(rain, problem);
    }
    let reported = how_it_ended(&earlier.fields.value);
    findings.add_all(&earlier.fields, reported);
    for boundary in &scenario.boundaries {
        let remedy = match boundary.value.condition {
            BoundaryCondition::Free => "give a `stage`, or `normal_depth` for water that only leaves",
            BoundaryCondition::Wave { still: None, .. } => "give `still`, the level without the wave",
            _ => continue,
        };
        let message = "this boundary takes the water before it at the start as that of a sea or lake at rest beyond";
        let problem = Problem::warning(ProblemKind::Scenario, "free-after-earlier-run", "", message)
            .with_cause("the start is a moment of the earlier run, whose own start may have been dry here")
            .with_remedy(remedy);
        findings.add(boundary, problem);
    }
}

fn place(water: &WaterOfDepth, crs: Option<&Crs>, scenario: &Scenario, findings: &mut Findings) -> Option<Place> {
    let Some(width) = &water.river else {
        return water::area(&water.place, crs, findings).map(Place::Area);
    };
    let source = &water.place;
    let name = source.value.path.display();
    let features = places::features(source, crs, findings)?;
    let (mut lines, mut without) = (Vec::new(), Vec::new());
    let has_line = |feature: &Feature| feature.lines.iter().any(places::has_length);
    findings.add_all(source, places::left_out(source, &features, "line", has_line));
    if let RiverWidth::Field(field) = width {
        findings.add_all(source, places::unit_of_attribute(source, &[field], &features, scenario));
    }
    for feature in &features {
        let width = match width {
            RiverWidth::Cell => Some(0.0),
            RiverWidth::Constant(width) => Some(*width),
            RiverWidth::Field(field) => feature.number(field).filter(|width| width.is_finite() && *width > 0.0),
        };
        for line in feature.lines.iter().filter(|line| line.0.len() >= 2) {
            let mut places: Vec<Vec2> = line.0.iter().map(|c| Vec2::new(c.x, c.y)).collect();
            places.dedup();
            match width {
                Some(width) => lines.push((places, width)),
                None => without.push(feature),
            }
        }
    }
    if let (Some(first), RiverWidth::Field(field)) = (without.first(), width) {
        let message = format!("{} lines of {name} have no width, the first is feature {}", without.len(), first.number);
        let problem = input_error("no-width", message)
            .with_cause(format!("looked for a length above 0 in {field}; its attributes: {}", first.attribute_names()))
            .with_remedy("name another attribute with `width_field`, fill it in, or write `width: 12 m`");
        findings.add(source, problem);
        return None;
    }
    if lines.is_empty() {
        let problem = input_error("no-lines", format!("{name} holds no line"));
        findings.add(source, problem.with_remedy("draw the axis of the river as lines"));
        return None;
    }
    Some(Place::River(lines))
}

/// Warns of a depth (m) that no river has, or hardly any water of one depth.
fn deep(depth: f64, is_river: bool) -> Option<Problem> {
    let (what, deepest) = if is_river { ("a river", DEEPEST_RIVER) } else { ("water", DEEPEST_WATER) };
    (depth > deepest).then(|| {
        input_warning("deep-water", format!("{what} of {depth} m is deeper than {deepest} m everywhere"))
            .with_cause("another unit, perhaps; or a level, which counts from the datum and not from the bed")
            .with_remedy("correct the depth and its unit, or give a `level`")
    })
}

/// Tells where the cells of a river hold another volume than its lines (local coordinates, m), each with its width, and its depth (m) give;
/// those of one cell have no width of their own.
fn other_size(lines: &[(Vec<Vec2>, f64)], cells: usize, (depth, bed): (f64, &BedParticles)) -> Option<Problem> {
    let lattice = &bed.lattice;
    let on_terrain = |cell: &usize| bed.has_terrain(*cell);
    let drawn = |(line, width): &(Vec<Vec2>, f64)| {
        let (inside, _) = lengths(line, lattice);
        width * inside.iter().filter(|(cell, _)| on_terrain(cell)).map(|(_, length)| length).sum::<f64>()
    };
    let (asked, has) = (depth * lines.iter().map(drawn).sum::<f64>(), depth * cells as f64 * lattice.cell_area());
    let is_other = asked > 0.0 && (has / asked - 1.0).abs() > TOLD_SIZE;
    is_other.then(|| {
        let message = format!(
            "the cells of this river hold {has:.3e} m³, {:.1} times what its length, width and depth give ({asked:.3e} m³)",
            has / asked
        );
        input_warning("river-size", message)
            .with_cause(format!(
                "it takes whole cells of {} m, all that its axis crosses and those that link them, so that it is one stretch of water",
                lattice.spacing
            ))
            .with_remedy("take a `resolution` of a fifth of its width or less, or give a depth that makes up for it")
    })
}

/// Puts water with a depth on the cells that have none yet.
pub fn wet(
    opened: &Opened,
    scenario: &Scenario,
    (bed, changes): (&BedParticles, &Changes),
    still: &mut StillWater,
    findings: &mut Findings,
) {
    let lattice = &bed.lattice;
    for (water, place) in scenario.start.depths.iter().zip(&opened.0) {
        let Some(place) = place else { continue };
        let local = |(line, width): &(Vec<Vec2>, f64)| (line.iter().map(|p| lattice.to_local(*p)).collect(), *width);
        let (cells, river, corner) = match place {
            Place::Area(area) => {
                use geo::CoordsIter;
                (cells_inside(area, lattice), None, area.coords_iter().next().map(|c| Vec2::new(c.x, c.y)))
            }
            Place::River(lines) => {
                let river: Vec<(Vec<Vec2>, f64)> = lines.iter().map(local).collect();
                let cells = river.iter().flat_map(|(line, width)| strip(line, *width, lattice)).collect();
                (cells, Some(river), lines.first().map(|(line, _)| line[0]))
            }
        };
        findings.add_all(&water.depth, deep(water.depth.value, river.is_some()));
        let on_terrain: Vec<usize> = cells.into_iter().filter(|&cell| bed.has_terrain(cell)).collect();
        if on_terrain.is_empty() {
            let name = water.place.value.path.display();
            let problem = input_error("outside-terrain", format!("no cell of the terrain lies in what {name} draws"))
                .with_remedy("check that the file and the terrain have the same CRS, or take a finer `resolution`");
            findings.add(&water.place, Problem { at: corner, ..problem });
        }
        if let Some(river) = river.filter(|_| !on_terrain.is_empty()) {
            findings.add_all(&water.place, other_size(&river, on_terrain.len(), (water.depth.value, bed)));
            let pieces = river.iter().flat_map(|(line, _)| line.windows(2)).map(|pair| [pair[0], pair[1]]);
            let outside = Outside::beyond_reach(pieces, bed);
            findings.add_all(&water.place, partly_outside(&water.place, outside, lattice.spacing, "it is dry there"));
        }
        for cell in on_terrain {
            // No depth lies on the crest of a dam or of a levee.
            if still.body[cell].is_none() && !changes.raises(cell) {
                still.depth[cell] = water.depth.value;
            }
        }
    }
}
