//! Limits of memory and particles.

use super::{Group, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Limits",
    problems: &[
        error(
            "auto-beyond-limit",
            "No cells that the terrain holds keep to the limits of `resolution.auto`.",
            "Raise these limits, cut the terrain to the valley, or give a length as `resolution`.",
        ),
        warning(
            "auto-misses-error",
            "The chosen cells are expected to miss the error that `resolution.auto` wants: finer ones are beyond the limits, or finer than the terrain.",
            "Raise the limits, take a finer terrain, or accept the error.",
        ),
        error(
            "disk-full",
            "The run takes more of its disk than is free.",
            "Free some, choose another folder with `--out`, or take fewer frames (`outputs.every`), larger cells of output (`outputs.cell`) or no frames (`outputs.write`).",
        ),
        error(
            "disk-limit",
            "The run folder takes, or has come to, more than `limits.disk`. A run that comes to it writes its maps and tables before it ends.",
            "Take fewer frames, larger cells of output or no frames, or raise `limits.disk`; `floodsim resume DIR --set limits.disk=SIZE` goes on with a run.",
        ),
        warning(
            "disk-may-fill",
            "By what `floodsim plan` knows, the run may take more of the disk than there is.",
            "Make room before it; where the disk fills, the run ends with its maps, and `floodsim resume` goes on.",
        ),
        error(
            "memory-limit",
            "The run needs more memory than its limit allows.",
            "Take a coarser `resolution`, cut the terrain to the valley, or raise `limits.memory`.",
        ),
        error(
            "particle-limit",
            "The run needs more particles than its limit allows.",
            "Take a coarser `resolution`, cut the terrain, or raise `limits.particles`.",
        ),
    ],
};
