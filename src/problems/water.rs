//! Water at the start.

use super::{Group, either, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Water at the start",
    problems: &[
        warning(
            "deep-water",
            "Water of this depth is deeper than rivers or lakes are. It may be a level, or in another unit.",
            "Correct the depth and its unit, or give a `level`.",
        ),
        warning(
            "leaking-rim",
            "Water runs out over the rim of its polygon at the start. This is expected along the dam that breaks.",
            "Elsewhere, enlarge the polygon, lower the level, or draw a wall along the rim.",
        ),
        either(
            "level-below-bed",
            "A level is not above the bed, so that no water is there or comes in. At times only is a warning.",
            "Correct the level, its unit or its datum.",
        ),
        error(
            "marks-no-water",
            "No cell with water at the start lies in the polygons of a tracer. It would mark nothing.",
            "Draw them over water of `initial`; name water that comes later by `boundary`, `source` or `rain`.",
        ),
        error(
            "no-width",
            "Lines of a river have no width.",
            "Give `width`, or name or fill in the attribute that has it.",
        ),
        error(
            "nodata-in-water",
            "The terrain has no data inside a polygon of water. Its volume would be wrong.",
            "Fill the holes, add a terrain layer below, or cut the polygon to the terrain.",
        ),
        error("overlapping-water", "Two polygons with different levels overlap.", "Cut one polygon to the other."),
        warning(
            "polygon-beyond-data",
            "The outline of a polygon reaches beyond the terrain by less than two cells. That part holds no water.",
            "Cut the polygon to the terrain, if its exact volume matters.",
        ),
        warning(
            "river-size",
            "The cells of a river have another volume than its length, width and depth give.",
            "Take a `resolution` of a fifth of the width or finer, or adapt the depth.",
        ),
        warning(
            "seeded-volume",
            "The volume of the particles differs from the volume between level and bed. The flood begins with too much or too little water.",
            "Draw the polygon up to the shore, or choose a finer `resolution`.",
        ),
        warning(
            "two-levels",
            "The level of the scenario differs from that of the polygon's attribute. That of the scenario is used.",
            "Check which level is right, and take the other one out.",
        ),
        warning(
            "volume-at-banks",
            "Cells that an upright bank divides are filled whole or not at all. The volume of the water differs by the share stated.",
            "Choose a finer `resolution`, if this volume matters.",
        ),
    ],
};
