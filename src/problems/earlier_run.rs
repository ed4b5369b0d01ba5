//! Runs that start from the fields of an earlier run.

use super::{Group, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Start from an earlier run",
    problems: &[
        warning(
            "bed-of-earlier-run",
            "The bed under water is taken from the earlier run, where it differs from this terrain.",
            "Take the terrain of that run, unless a shore was fitted or a dam broke there.",
        ),
        error(
            "change-under-water",
            "The earlier run has water where this scenario raises or carves the bed. Its depth would be wrong.",
            "Run from the start with the change, or take it out.",
        ),
        error(
            "channels-of-earlier-run",
            "A run with channels cannot start from an earlier run. `fields.nc` has no water of channels.",
            "Run it from its start, with a later `time.end`.",
        ),
        warning(
            "drawn-fields",
            "The particles of the earlier run moved, and its fields are drawn from them. Still water may move a little at first.",
            "Run it from its start, or its first part with Eulerian particles, if this matters.",
        ),
        error(
            "failed-run",
            "The earlier run failed. Its last frames may be wrong.",
            "Correct and repeat that run, or take the frame of one that ended.",
        ),
        warning(
            "free-after-earlier-run",
            "The boundary takes its still level from the start of this run, a moment of the earlier run.",
            "Give `stage` or `normal_depth`, or `still` for a wave.",
        ),
        warning(
            "gate-of-earlier-run",
            "A quality gate of the earlier run failed. Its water may be wrong.",
            "Check that run before you go on from it.",
        ),
        error(
            "incomplete-frame",
            "A frame of the earlier run has no time, depth or velocity on some cells.",
            "Take a complete frame by `time`, and the terrain and buildings of that run.",
        ),
        warning(
            "levels-of-earlier-run",
            "The maps of an earlier run on levels do not give the size of its cells. Its coarse cells are steps in the water here.",
            "Run it with `outputs.cell` as its finest resolution, and with `maps` in `outputs.write`.",
        ),
        warning(
            "losses-after-earlier-run",
            "The initial loss of the rain is taken again. The ground may be wet from the earlier run.",
            "Leave `rain.losses.initial` out, if it rained in the earlier run.",
        ),
        warning(
            "moving-bed-of-earlier-run",
            "The bed of the earlier run moved. Here the moved bed is known under water only.",
            "Give a terrain that has the moved ground.",
        ),
        error(
            "no-such-frame",
            "The earlier run has no frame at this time.",
            "Take the nearest frame that the message names, or `time: last`.",
        ),
        error(
            "no-water",
            "The frame of the earlier run has no water.",
            "Take another moment by `time`, or leave `fields` out for a dry start.",
        ),
        error(
            "not-a-fields-file",
            "The file is not the `fields.nc` of a run, or it is damaged.",
            "Name the `fields.nc` of a finished run, or copy it again.",
        ),
        warning(
            "other-dry-ground",
            "Dry ground differs from that of the earlier run.",
            "Take the terrain and the structures of that run, unless the change is meant.",
        ),
        error(
            "other-lattice",
            "The cells of the earlier run do not fit those of this run.",
            "Take the terrain of that run, and its `resolution` or half, twice or one and a half times as much.",
        ),
        warning(
            "other-structures",
            "The earlier run had other walls, buildings or breaklines.",
            "Take the structures of that run, unless the change is meant.",
        ),
        error(
            "other-terrain",
            "The bed under water differs from that of the earlier run. Its depths would be wrong.",
            "Take the terrain layers of that run with `offset` and `unit`, or run from the start.",
        ),
        warning(
            "unfinished-earlier-run",
            "The earlier run did not reach its end. Its last frame is earlier than its `time.end`.",
            "Check that this moment is meant, or name another by `time`.",
        ),
        warning(
            "volume-of-earlier-run",
            "The cells of this run hold another volume than those of the earlier run, which have another size.",
            "Take the `resolution` of that run, if the difference matters.",
        ),
        error(
            "water-in-dam",
            "The earlier run has water where the dam of `breach` stands. The dam was not there, or had broken.",
            "Take a moment before the break, or run it from its start.",
        ),
        error(
            "water-without-terrain",
            "The earlier run has water on cells without terrain in this run. It would be lost.",
            "Take the terrain and the buildings of that run.",
        ),
    ],
};
