//! Limits of memory and particles.

use super::{Group, error};

pub(super) const GROUP: Group = Group {
    title: "Limits",
    problems: &[
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
