//! What Lagrangian particles do worse than Eulerian ones.

use super::{Group, warning};

pub(super) const GROUP: Group = Group {
    title: "Lagrangian particles",
    problems: &[
        warning(
            "lagrangian-askew-wall",
            "Walls at an angle to the lattice slow the water along them with Lagrangian particles.",
            "Leave `numerics.motion` out to take Eulerian particles.",
        ),
        warning(
            "lagrangian-dry-front",
            "The front over dry ground is late with Lagrangian particles. Arrival is late and the flooded area too small.",
            "Leave `numerics.motion` out to take Eulerian particles.",
        ),
        warning(
            "lagrangian-held-level",
            "A level held above dry ground lets in too much water with Lagrangian particles.",
            "Leave `numerics.motion` out to take Eulerian particles.",
        ),
        warning(
            "lagrangian-jump",
            "Depths behind hydraulic jumps and bores are wrong with Lagrangian particles, and jumps move upstream.",
            "Leave `numerics.motion` out to take Eulerian particles.",
        ),
        warning(
            "lagrangian-rain",
            "Rain runs off too fast on slopes with Lagrangian particles.",
            "Leave `numerics.motion` out to take Eulerian particles.",
        ),
        warning(
            "lagrangian-stage",
            "With Lagrangian particles `stage` is held at the boundary itself, as `level` is. The velocity head is not taken off.",
            "Leave `numerics.motion` out to take Eulerian particles.",
        ),
        warning(
            "late-breach",
            "Lagrangian particles pass a sinking crest late. The flood begins late, and its peak may be too high.",
            "Leave `numerics.motion` out wherever the hydrograph of the breach counts.",
        ),
    ],
};
