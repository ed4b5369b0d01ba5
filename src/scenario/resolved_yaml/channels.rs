//! Channels of one dimension in the resolved scenario.

use super::forcing::condition;
use super::{file, name_of, vector};
use crate::scenario::channel::{Channel, ChannelGauge, ChannelShape, ChannelWalls, ChannelWater, Joint};
use crate::scenario::model::{BoundaryCondition, Side};
use crate::scenario::yaml::{Section, Yaml, quantity, quoted};

/// A channel in the resolved scenario.
pub(super) fn channel(channel: &Channel) -> Yaml {
    let section =
        Section::default().with("id", quoted(&channel.id.value)).with("length", quantity(channel.length.value, "m"));
    let shape = match &channel.shape {
        ChannelShape::Rectangle { width, bed, slope } => {
            section.with("width", quantity(*width, "m")).with("bed", quantity(*bed, "m")).with("slope", *slope)
        }
        ChannelShape::Sections(path) => section.with("sections", file(&path.value)),
    };
    let end = |end: &Option<BoundaryCondition>| end.as_ref().map(|end| Yaml::Entry(condition(end)));
    let gauge = |gauge: &ChannelGauge| {
        let id = Section::default().with("id", quoted(&gauge.id.value));
        Yaml::Entry(id.with("distance", quantity(gauge.distance.value, "m")))
    };
    Yaml::Entry(
        shape
            .with_some("manning", channel.manning)
            .with("walls", name_of(|walls: &ChannelWalls| *walls == channel.walls))
            .with_row("water", channel.water.iter().map(|water| water_as_yaml(&water.value)).collect())
            .with_some("joins", channel.joins.as_ref().map(|joint| joint_as_yaml(&joint.value)))
            .with_some("upstream", end(&channel.upstream))
            .with_some("downstream", end(&channel.downstream))
            .with_some("line", channel.line.as_ref().map(vector))
            .with_row("gauges", channel.gauges.iter().map(gauge).collect()),
    )
}

fn water_as_yaml(water: &ChannelWater) -> Yaml {
    let length = |value: f64| quantity(value, "m");
    Yaml::Entry(
        Section::default()
            .with_some("level", water.level.map(length))
            .with_some("depth", water.depth.filter(|_| water.level.is_none()).map(length))
            .with("from", length(water.from))
            .with_some("to", water.to.map(length)),
    )
}

fn joint_as_yaml(joint: &Joint) -> Yaml {
    Yaml::Entry(
        Section::default()
            .with("side", name_of(|side: &Side| *side == joint.side))
            .with_some("from", joint.span.map(|(from, _)| from))
            .with_some("to", joint.span.map(|(_, to)| to)),
    )
}
