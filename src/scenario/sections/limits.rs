//! `limits`.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::scenario::defaults::{CHECKPOINT, MAX_PARTICLES, MEMORY_SHARE};
use crate::scenario::fields::{Count, Duration, Memory, Quantity};
use crate::scenario::machine::machine_memory;
use crate::scenario::model::Limits;
use crate::scenario::read::{FromNode, Reader, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, quantity};

section! {
    /// Limits that are checked against an estimate before the run and watched during it, beyond which the program ends with exit code 5; how often the
    /// state of the run is kept.
    LimitsSection, example "{memory: 8 GB}" {
        /// Memory that the run may take; 80 % of that of the machine, its containers or its process when absent, and no more than that. A run that
        /// reaches it ends. Codes: memory-limit.
        memory: Option<Quantity<Memory>>,
        /// Space that the run folder may take, with the files that a run needs on its way; the free space of its disk when absent. Codes: disk-limit,
        /// disk-full.
        disk: Option<Quantity<Memory>>,
        /// Number of riverbed particles, moving particles and strips of channels together; 50 million when absent. Codes:
        /// particle-limit.
        particles: Option<Quantity<Count>>,
        /// Wall-clock time between two checkpoints, from which `floodsim resume` goes on; `off` for none; 10 min when absent. From 10 min on they take
        /// 2 % of the run at most: where one takes long, the next comes later.
        checkpoint: Option<CheckpointInterval>,
        /// Whether rasters and vector files may be read from a network or an archive (`/vsicurl/`, `/vsizip/` and the like), and a VRT or a NetCDF file may name
        /// these or files outside of its folder and that of the scenario; `false` when absent. Codes: foreign-file, no-checksum.
        allow_remote: Option<bool>,
    }
}

/// How often the state of a run is kept.
#[derive(Clone, Debug)]
pub enum CheckpointInterval {
    /// Never.
    Off,
    /// After so long.
    Every(Quantity<Duration>),
}

impl FromNode for CheckpointInterval {
    fn example() -> String {
        "10 min".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        match &node.value {
            Value::Text(text) if text == "off" => Some(CheckpointInterval::Off),
            _ => Quantity::from_node(node, reader).map(CheckpointInterval::Every),
        }
    }
}

impl JsonSchema for CheckpointInterval {
    fn schema_name() -> Cow<'static, str> {
        "CheckpointInterval".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let time = generator.subschema_for::<Quantity<Duration>>();
        json_schema!({"anyOf": [{"const": "off"}, time]})
    }
}

pub(super) fn resolved(section: Option<LimitsSection>) -> Limits {
    let none = LimitsSection { memory: None, disk: None, particles: None, checkpoint: None, allow_remote: None };
    let LimitsSection { memory, disk, particles, checkpoint, allow_remote } = section.unwrap_or(none);
    let machine = machine_memory();
    Limits {
        memory: memory.map_or((MEMORY_SHARE * machine).floor(), |memory| memory.value().min(machine)),
        disk: disk.map(|disk| disk.value()),
        particles: particles.map_or(MAX_PARTICLES, |particles| particles.value()),
        checkpoint: match checkpoint {
            Some(CheckpointInterval::Off) => None,
            Some(CheckpointInterval::Every(time)) => Some(time.value()),
            None => Some(CHECKPOINT),
        },
        allow_remote: allow_remote.unwrap_or(false),
    }
}

pub(super) fn written(limits: &Limits) -> Section {
    Section::default()
        .with("memory", quantity(limits.memory, "B"))
        .with_some("disk", limits.disk.map(|disk| quantity(disk, "B")))
        .with("particles", limits.particles)
        .with("checkpoint", limits.checkpoint.map_or_else(|| "off".into(), |every| quantity(every, "s")))
        .with("allow_remote", limits.allow_remote)
}
