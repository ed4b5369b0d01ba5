//! `boundaries`: open edges, and what is known of the water beyond.

use crate::error::{Problem, ProblemKind};
use crate::scenario::choices::{Chosen, OpenType};
use crate::scenario::fields::{Discharge, Level, Quantity, Slope, VectorFile};
use crate::scenario::model::{Boundary, BoundaryCondition, OpenBoundary, Scenario, Side, Sourced, Timed};
use crate::scenario::read::{Reader, section};
use crate::scenario::timed::{self, Changing, RatingFile};
use crate::scenario::tree::Node;
use crate::scenario::yaml::{Section, Yaml, file, name_of, vector};

section! {
    /// An open part of the edge of the terrain: where it is, and what is known of the water beyond.
    BoundaryEntry, example "{side: south, type: open}", check check_boundary {
        /// A side of the terrain.
        side: Option<Chosen<Side>>,
        /// The same as `side`.
        edge: Option<Chosen<Side>>,
        /// File with lines along the open edge; outlines of polygons count as lines.
        lines: Option<VectorFile>,
        /// The same as `lines`.
        line: Option<VectorFile>,
        /// Where nothing is known: open (water leaves, over an edge where the bed does not fall) or free (waves leave).
        r#type: Option<Chosen<OpenType>>,
        /// Discharge that comes in.
        discharge: Option<Changing<Discharge>>,
        /// Level of the water at the boundary itself, whether it comes or goes; with a discharge it counts where the inflow is supercritical.
        level: Option<Changing<Level>>,
        /// Level of still water beyond that is held, such as a tide.
        stage: Option<Changing<Level>>,
        /// Level of a wave that comes in while others leave.
        wave: Option<Changing<Level>>,
        /// Level without the wave; that of the water at the start when absent.
        still: Option<Changing<Level>>,
        /// Uniform flow goes on beyond.
        normal_depth: Option<NormalDepth>,
        /// The discharge that leaves as a function of the level.
        rating: Option<RatingFile>,
    }
}

section! {
    /// Uniform flow.
    NormalDepth, example "{slope: 0.002}" {
        /// Slope of the bed beyond the edge.
        slope: Quantity<Slope>,
    }
}

/// The keys of a boundary that say what is known there.
pub const BOUNDARY_KINDS: [&str; 7] = ["type", "discharge", "level", "stage", "wave", "normal_depth", "rating"];

fn check_boundary(node: &Node, reader: &mut Reader) -> Option<()> {
    let place = reader.exactly_one(node, &["side", "edge", "lines", "line"]);
    let kinds: Vec<&str> = BOUNDARY_KINDS.into_iter().filter(|name| node.get(name).is_some()).collect();
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
    let Some(still) = node.get("still").filter(|_| node.get("wave").is_none()) else { return Some(()) };
    let remedy = "add `wave`, the level of the wave that comes in; for a level that is held write `stage`";
    reader.error(still, "conflict", "`still` goes with `wave`", remedy);
    None
}

/// The edges through which water leaves, and those at which more is known.
pub(super) fn resolved(entries: Vec<BoundaryEntry>) -> (Vec<OpenBoundary>, Vec<Sourced<Boundary>>) {
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
    open.chain(known).collect()
}
