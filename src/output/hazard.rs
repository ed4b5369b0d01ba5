//! Hazard classes H1 to H6 of the combined curves of the Australian guideline.
//!
//! ```text
//! class = the smallest one whose three conditions hold:   d·|v| ≤ limit,   d ≤ limit,   |v| ≤ limit
//! ```
//!
//! Reference: `AIDR2017` (Guideline 7-3, flood hazard, table 2). The limits grow with the class, so the greatest class
//! that a place has seen can be carried on from step to step.

/// One class of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HazardClass {
    /// Name, `H1` to `H6`.
    pub name: &'static str,
    /// Meaning in a few words.
    pub meaning: &'static str,
    /// Greatest depth times speed (m²/s).
    pub depth_velocity: f64,
    /// Greatest depth (m).
    pub depth: f64,
    /// Greatest speed (m/s).
    pub speed: f64,
    /// Colour, red green blue.
    pub colour: [u8; 3],
}

const fn class(
    name: &'static str,
    meaning: &'static str,
    [depth_velocity, depth, speed]: [f64; 3],
    colour: [u8; 3],
) -> HazardClass {
    HazardClass { name, meaning, depth_velocity, depth, speed, colour }
}

/// The six classes, mildest first; class `n` stands at `n - 1`.
pub const HAZARD_CLASSES: [HazardClass; 6] = [
    class("H1", "generally safe", [0.3, 0.3, 2.0], [0xA6, 0xD9, 0x6A]),
    class("H2", "unsafe for small vehicles", [0.6, 0.5, 2.0], [0xFF, 0xFF, 0xBF]),
    class("H3", "unsafe for vehicles, children and the elderly", [0.6, 1.2, 2.0], [0xFE, 0xE0, 0x8B]),
    class("H4", "unsafe for people and vehicles", [1.0, 2.0, 2.0], [0xFD, 0xAE, 0x61]),
    class("H5", "buildings vulnerable to damage", [4.0, 4.0, 4.0], [0xD7, 0x30, 0x1F]),
    class("H6", "all buildings vulnerable to failure", [f64::INFINITY; 3], [0x7A, 0x01, 0x77]),
];

/// The class (1 to 6) of water of a given depth (m, positive) and speed (m/s).
pub fn hazard_class(depth: f64, speed: f64) -> u8 {
    let discharge = depth * speed;
    greater_class(1, depth, discharge * discharge)
}

/// The greater of a class and the class of water of a given depth d (m) and squared discharge per width, (d·|v|)² (m⁴/s²).
///
/// Compares squares, so that neither a root nor a quotient is needed at every cell and step.
#[inline]
pub(super) fn greater_class(current: u8, depth: f64, discharge_squared: f64) -> u8 {
    let mut class = current.max(1);
    while let Some(limits) = HAZARD_CLASSES.get(usize::from(class) - 1) {
        let exceeded = depth > limits.depth
            || discharge_squared > limits.depth_velocity * limits.depth_velocity
            || discharge_squared > limits.speed * limits.speed * depth * depth;
        if !exceeded {
            break;
        }
        class += 1;
    }
    class
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_follow_the_table() {
        // Each row by hand from the table: which of the three conditions decides.
        for (depth, speed, expected) in [
            (0.2, 0.5, 1),
            (0.3, 0.0, 1),  // at the limit of the depth
            (0.31, 0.0, 2), // depth
            (0.2, 1.6, 2),  // d v = 0.32
            (0.6, 0.5, 3),  // depth
            (0.5, 1.9, 4),  // d v = 0.95
            (1.9, 0.1, 4),  // depth
            (0.1, 2.1, 5),  // speed
            (3.0, 1.0, 5),  // d v = 3
            (0.01, 4.1, 6), // speed
            (4.1, 0.0, 6),  // depth
            (3.9, 3.9, 6),  // d v = 15
        ] {
            assert_eq!(hazard_class(depth, speed), expected, "d = {depth}, v = {speed}");
        }
    }

    #[test]
    fn class_never_falls() {
        assert_eq!(greater_class(4, 0.01, 0.0), 4);
        assert_eq!(greater_class(6, 100.0, 1e9), 6);
        assert_eq!(greater_class(0, 0.01, 0.0), 1);
    }
}
