//! `boundaries`: open edges, and what is known of the water beyond.

use crate::error::{Problem, ProblemKind};
use crate::scenario::choices::{Chosen, OpenType};
use crate::scenario::fields::{Discharge, Level, Quantity, Slope, VectorFile};
use crate::scenario::model::{Boundary, BoundaryCondition, OpenBoundary, Scenario, Side, Sourced, Timed};
use crate::scenario::read::{Reader, section};
use crate::scenario::timed::{self, Changing, RatingFile};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, Yaml, file, name_of, vector};

section! {
    /// An open part of the edge of the terrain: where it is, and what is known of the water beyond. One place and one condition
    /// are required.
    BoundaryEntry, example "{side: south, type: open}", check check_boundary {
        /// A side of the terrain as one sees it from there, or `all` of its outline without holes; `edge`, `lines` or `line` is required when
        /// absent. Codes: side-in-part, overlapping-boundaries, opens-nothing.
        side: Option<Chosen<Side>>,
        /// The same as `side`; `side`, `lines` or `line` is required when absent. Codes: side-in-part, overlapping-boundaries,
        /// opens-nothing.
        edge: Option<Chosen<Side>>,
        /// File of lines along the open part of the edge; outlines of polygons count as lines; `side`, `edge` or `line` is
        /// required when absent. Codes: opens-nothing, overlapping-boundaries, lower-ground-beside, outside-terrain, no-lines.
        lines: Option<VectorFile>,
        /// The same as `lines`; `side`, `edge` or `lines` is required when absent. Codes: opens-nothing, overlapping-boundaries,
        /// lower-ground-beside, outside-terrain, no-lines.
        line: Option<VectorFile>,
        /// `open`: nothing is known and water leaves; `free`: waves leave without reflection; `closed`: a wall stands there, as at
        /// edges without an entry, and water at it is not reported; another condition is required when absent. Codes:
        /// free-after-earlier-run, closed-edge.
        r#type: Option<Chosen<OpenType>>,
        /// Discharge that comes in over the whole line or side; another condition is required when absent. Codes: huge-discharge,
        /// lower-ground-beside.
        discharge: Option<Changing<Discharge>>,
        /// Level of the water at the boundary itself, alone or beside `discharge` for supercritical inflow; another condition is
        /// required when absent. Codes: level-is-at-the-boundary, boundary-dry, level-below-bed, fast-inflow, step-of-level,
        /// drowned-terrain.
        level: Option<Changing<Level>>,
        /// Level of the still water beyond, such as that of a sea, a lake or a tide; another condition is required when absent.
        /// Codes: boundary-dry, step-of-level, drowned-terrain, implausible-level.
        stage: Option<Changing<Level>>,
        /// Level of a wave that comes in square to the boundary, while waves from inside leave through it; another condition is
        /// required when absent. Codes: wave-without-still, wave-begins-with-step, high-wave, boundary-dry, drowned-terrain.
        wave: Option<Changing<Level>>,
        /// Level without the `wave`, constant or a series such as a tide; that of the water at the start when absent. Codes:
        /// wave-without-still, wave-begins-with-step, high-wave, free-after-earlier-run.
        still: Option<Changing<Level>>,
        /// Uniform flow goes on beyond; water leaves only; another condition is required when absent. Codes: rising-ground,
        /// method-combination.
        normal_depth: Option<NormalDepth>,
        /// Discharge that leaves as a function of the level; another condition is required when absent. Codes: high-weir,
        /// rating-without-discharge, boundary-dry.
        rating: Option<RatingFile>,
    }
}

section! {
    /// Uniform flow.
    NormalDepth, example "{slope: 0.002}" {
        /// Slope of the bed beyond, such as `0.002`, `0.2 %` or `2 ‰`. Codes: rising-ground, no-roughness.
        slope: Quantity<Slope>,
    }
}

/// The keys of a boundary that say what is known there.
pub const BOUNDARY_KINDS: [&str; 7] = ["type", "discharge", "level", "stage", "wave", "normal_depth", "rating"];

fn check_boundary(node: &Node, reader: &mut Reader) -> Option<()> {
    let place = reader.exactly_one(node, &["side", "edge", "lines", "line"]);
    let kinds: Vec<&str> = BOUNDARY_KINDS.into_iter().filter(|name| node.has(name)).collect();
    match kinds[..] {
        [] => {
            let message = "nothing is said of the water beyond this edge";
            let remedy = format!("add one of the keys {}, such as `type: open`", BOUNDARY_KINDS.join(", "));
            reader.error(node, "missing-key", message, remedy);
            return None;
        }
        ["level"] => warn_of_level(node, reader),
        [_] | ["discharge", "level"] => {}
        _ => {
            let message = format!("{} exclude each other at one boundary", kinds.join(" and "));
            let remedy = "keep one of them; only `discharge` and `level` go together, for supercritical inflow";
            reader.error(node, "conflict", message, remedy);
            return None;
        }
    }
    check_still(node, reader)?;
    place.map(|_| ())
}

/// Refuses a side that one entry closes and another one opens.
pub(super) fn check_closed(entries: &[Node], reader: &mut Reader) {
    let side = |entry: &Node| match entry.get("side").or_else(|| entry.get("edge")).map(|node| &node.value) {
        Some(Value::Text(side)) => Some(side.clone()),
        _ => None,
    };
    let is_closed =
        |entry: &&Node| entry.get("type").is_some_and(|kind| kind.value == Value::Text("closed".to_owned()));
    for closed in entries.iter().filter(is_closed) {
        let Some(its) = side(closed) else { continue };
        let opens =
            |other: &&Node| !is_closed(other) && side(other).is_some_and(|other| other == its || other == "all");
        if let Some(other) = entries.iter().find(opens) {
            let message = format!("`{}` opens this side, and it is closed here", other.key);
            let remedy = "keep one of them; beside a closed side the other sides are opened one by one";
            reader.error(closed, "conflict", message, remedy);
        }
    }
}

/// Warns of a level alone: it was that of still water beyond in earlier versions.
fn warn_of_level(node: &Node, reader: &mut Reader) {
    if let Some(level) = node.get("level") {
        let problem = Problem::warning(
            ProblemKind::Scenario,
            "level-is-at-the-boundary",
            level.key.clone(),
            "`level` holds the level of the water at the boundary itself",
        );
        let problem = problem
            .with_cause("earlier versions took it for that of still water beyond, and let in water lower by its velocity head")
            .with_remedy("right for a level measured at the boundary; for a sea, a lake or the result of an earlier version write `stage`");
        reader.report(level, problem);
    }
}

/// Refuses a level without a wave that has none.
pub(super) fn check_still(node: &Node, reader: &mut Reader) -> Option<()> {
    let Some(still) = node.get("still").filter(|_| !node.has("wave")) else { return Some(()) };
    let remedy = "add `wave`, the level of the wave that comes in; for a level that is held write `stage`";
    reader.error(still, "conflict", "`still` goes with `wave`", remedy);
    None
}

/// The edges that `boundaries` names.
#[derive(Default)]
pub(super) struct Edges {
    /// Through which water leaves.
    pub open: Vec<OpenBoundary>,
    /// At which more is known.
    pub known: Vec<Sourced<Boundary>>,
    /// At which a wall stands.
    pub closed: Vec<OpenBoundary>,
}

pub(super) fn resolved(entries: Vec<BoundaryEntry>) -> Edges {
    let Edges { mut open, mut known, mut closed } = Edges::default();
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
                Some(OpenType::Closed) => {
                    closed.push(place.value);
                    continue;
                }
                _ => {
                    open.push(place.value);
                    continue;
                }
            }
        };
        let boundary = Boundary { place: place.value, condition };
        known.push(Sourced { value: boundary, key: format!("boundaries[{index}]"), place: place.place });
    }
    Edges { open, known, closed }
}

/// The side or the lines of a boundary.
fn open_place(place: &OpenBoundary) -> Section {
    match place {
        OpenBoundary::Side(side) => Section::default().with("side", name_of(|candidate: &Side| candidate == side)),
        OpenBoundary::Lines(lines) => Section::default().with("lines", vector(lines)),
    }
}

/// The keys of a condition.
pub(super) fn condition(condition: &BoundaryCondition) -> Section {
    let section = Section::default();
    let level = |level: &Timed| timed::written(level, "m");
    match condition {
        BoundaryCondition::Free => section.with("type", "free"),
        BoundaryCondition::Discharge { discharge, level: outer } => {
            section.with("discharge", timed::written(discharge, "m3/s")).with_some("level", outer.as_ref().map(level))
        }
        BoundaryCondition::Stage(stage) => section.with("stage", level(stage)),
        BoundaryCondition::Level(held) => section.with("level", level(held)),
        BoundaryCondition::Wave { level: wave, still } => {
            section.with("wave", level(wave)).with_some("still", still.as_ref().map(level))
        }
        BoundaryCondition::NormalDepth(slope) => {
            section.with("normal_depth", Yaml::Entry(Section::default().with("slope", slope.value)))
        }
        BoundaryCondition::Rating(table) => {
            let names = [["level", "level_unit"], ["discharge", "discharge_unit"]];
            let of_file = Section::default().with("table", file(&table.file.value));
            section.with("rating", Yaml::Entry(of_file.and(timed::columns(table, names))))
        }
    }
}

/// Open edges in the resolved scenario.
pub(super) fn written(scenario: &Scenario) -> Vec<Yaml> {
    let open = scenario.open.iter().map(|place| Yaml::Entry(open_place(place).with("type", "open")));
    let known = scenario
        .boundaries
        .iter()
        .map(|boundary| Yaml::Entry(open_place(&boundary.value.place).and(condition(&boundary.value.condition))));
    let closed = scenario.closed.iter().map(|place| Yaml::Entry(open_place(place).with("type", "closed")));
    open.chain(known).chain(closed).collect()
}
