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
