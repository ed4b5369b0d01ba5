//! A scenario whose water is in channels alone: it has no terrain, and nothing that stands, falls or is drawn on one.

use super::resolution;
use super::terrain::Terrain;
use crate::error::{Problem, ProblemKind};
use crate::scenario::read::{FromNode, Reader};
use crate::scenario::tree::{Node, Value};

/// Keys that ask for terrain, and what of it a channel has instead or why it has nothing.
const OF_TERRAIN: [(&str, &str); 19] = [
    ("structures", "walls and buildings stand on terrain"),
    ("initial", "the water of a channel at the start is its own key `water`"),
    ("boundaries", "what is known beyond the ends of a channel are its own keys `upstream` and `downstream`"),
    ("sources", "a channel has no inflow but by its ends"),
    ("rain", "rain falls on terrain, and a channel has no inflow but by its ends"),
    ("breach", "a dam that breaks stands on terrain"),
    ("moving_bed", "the bed that moves is that of the terrain"),
    ("roughness.raster", "a channel takes `manning`, its own or that of `roughness`"),
    ("roughness.table", "a channel takes `manning`, its own or that of `roughness`"),
    ("roughness.default", "a channel takes `manning`, its own or that of `roughness`"),
    ("roughness.polygons", "a channel takes `manning`, its own or that of `roughness`"),
    ("outputs.cell", "channels are on no map"),
    ("outputs.gauges", "the gauges of a channel are its own key `gauges`"),
    ("outputs.sections", "the discharge along a channel is in its profiles, and at its gauges"),
    ("outputs.isochrones", "channels are on no map"),
    ("outputs.error_estimate", "channels are on no map"),
    ("numerics.bed", "the bed of a channel is that of its sections"),
    ("numerics.turbulence", "a channel has one velocity over its width"),
    ("crs", "there is no terrain to take it from"),
];

/// Checks a scenario without terrain: it must have channels, and nothing else that needs terrain.
pub(super) fn check(node: &Node, reader: &mut Reader) -> Option<()> {
    let channels = match node.get("channels").map(|list| &list.value) {
        Some(Value::List(channels)) if !channels.is_empty() => channels.as_slice(),
        _ => {
            Terrain::when_absent(node, "terrain", reader);
            return None;
        }
    };
    let mut is_fit = true;
    let mut refuse = |place: &Node, name: &str, why: &str| {
        let message = format!("`{name}` needs terrain, and this scenario has channels alone");
        let problem = Problem::error(ProblemKind::Scenario, "needs-terrain", place.key.clone(), message)
            .with_cause(why)
            .with_remedy("take it out, or add `terrain: {layers: [{raster: FILE}]}`");
        reader.report(place, problem);
        is_fit = false;
    };
    for (path, why) in OF_TERRAIN {
        let (section, key) = path.split_once('.').map_or((Some(node), path), |(name, key)| (node.get(name), key));
        let Some(place) = section.filter(|section| section.has(key)).and_then(|section| section.get(key)) else {
            continue;
        };
        // A system that is named is that of the lines of the channels.
        if key != "crs" || place.value == Value::Text("terrain".to_owned()) {
            refuse(place, key, why);
        }
    }
    for joint in channels.iter().filter_map(|channel| channel.get("joins")).filter(|joint| joint.value != Value::Empty)
    {
        refuse(joint, "joins", "a channel joins an edge of the terrain; the end of one that does not is `downstream`");
    }
    is_fit &= resolution::check_channels_alone(node, reader);
    is_fit.then_some(())
}

/// Whether there are channels alone, each with its own roughness.
pub(super) fn are_rough(node: &Node) -> bool {
    let channels = match node.get("channels").map(|list| &list.value) {
        Some(Value::List(channels)) => channels.as_slice(),
        _ => return false,
    };
    !node.has("terrain") && !channels.is_empty() && channels.iter().all(|channel| channel.has("manning"))
}
