//! Dams that break, and beds that move.

use super::{Group, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Breach and moving bed",
    problems: &[
        error(
            "breach-beyond-dam",
            "The breach reaches beyond the end of the dam on the terrain.",
            "Move the breach by `position`, make it narrower, or draw a longer line.",
        ),
        warning(
            "breach-coarse",
            "The breach is only a few cells wide. Its shape hardly counts in its discharge.",
            "Choose a finer `resolution`.",
        ),
        warning(
            "breach-unfinished",
            "The breach still grows when the run ends.",
            "Let the run last longer, if the final opening matters.",
        ),
        warning(
            "breach-volume",
            "The volume given to the breach formula differs from the water above the invert.",
            "Check the volume, its unit and the lake that is meant.",
        ),
        error(
            "breach-wider-than-dam",
            "The breach is wider at its crest than the dam is long.",
            "Correct the bottom width, the side slope or the invert, or the line of the dam.",
        ),
        error(
            "breach-without-area",
            "The final opening has no area: its bottom has no width, and its sides are upright.",
            "Give the bottom a width or the sides a slope.",
        ),
        warning(
            "change-volume",
            "The bed change has another volume on the lattice than in the file: it is finer than the resolution.",
            "Choose a finer `resolution`, or give means over its cells.",
        ),
        warning(
            "dam-end-open",
            "The dam ends where the ground is below its crest. High water passes beside it.",
            "Draw the line on into the abutment.",
        ),
        error(
            "dam-lines",
            "The file does not have exactly one line for the dam.",
            "Draw one line along the crest, from abutment to abutment.",
        ),
        warning(
            "doubtful-change",
            "A raster moves the bed further than ground does. A fill value or a wrong unit is likely.",
            "Declare the fill value as nodata, or give the `unit` of the raster.",
        ),
        error(
            "falling-share",
            "The share of a growth or of a bed change falls. What is gone does not come back.",
            "Let the share rise, or stay.",
        ),
        error(
            "growth-end",
            "A growth curve does not end with the share 1, the final opening.",
            "End with the share 1 (100 in `%`); give a smaller opening by its `shape`.",
        ),
        error(
            "growth-start",
            "A growth curve does not begin with time 0 and share 0.",
            "Begin with time 0 and share 0; times count from the trigger.",
        ),
        error(
            "invert-above-crest",
            "The invert of the breach is not below the crest of the dam.",
            "Correct the level, its unit or its datum.",
        ),
        error(
            "invert-below-terrain",
            "The invert of the breach is below the terrain under it. The breach does not erode terrain.",
            "Raise the invert to the terrain, or move the breach by `position`.",
        ),
        error(
            "level-never-reached",
            "The water never reaches the level that triggers the breach. The dam would not break.",
            "Lower the level, add inflow, or let the breach begin at a time.",
        ),
        error(
            "moves-after-end",
            "The bed begins to move after the end of the run.",
            "Let it begin earlier, or the run last longer.",
        ),
        warning(
            "moves-at-end",
            "The bed still moves when the run ends.",
            "Let the run last longer, if the final bed matters.",
        ),
        error(
            "moves-boundary",
            "The bed moves at a boundary with a condition, or where a channel joins. The condition there needs a fixed bed.",
            "Keep the movement off that part of the edge, or move the boundary away.",
        ),
        error(
            "moves-dam",
            "The bed moves under the dam of `breach`, whose own bed falls.",
            "Keep the movement off the dam.",
        ),
        error(
            "moves-nothing",
            "A raster changes no cell of the terrain.",
            "Check its unit, its nodata value and its reference system.",
        ),
        warning(
            "moves-without-terrain",
            "Part of the bed movement lies where there is no terrain. The waves from there are missing.",
            "Give terrain that contains all of it, if these waves matter.",
        ),
        error(
            "no-crest",
            "Neither the scenario nor the file gives the crest of the dam.",
            "Give `crest`, or name the attribute by `crest_field`.",
        ),
        error(
            "one-breach",
            "`breach` is a list, and one dam breaks in a run.",
            "Write one section under `breach`, and a scenario for each dam.",
        ),
        error(
            "opening-above-water",
            "The opening ends above all water. None would pass it.",
            "Carve the dam out of the terrain, or correct the invert or the level of the lake.",
        ),
        warning(
            "opening-blocked",
            "Terrain beside the opening stands above half of its height. It may contain the dam already.",
            "Carve out what falls with the dam by `terrain.breaklines` with `mode: carve`.",
        ),
        warning(
            "path-beside-slide",
            "The line does not begin on the slide.",
            "Draw the line from the middle of the slide to where it comes to rest.",
        ),
        error(
            "position-off-dam",
            "The position of the breach lies off the dam.",
            "Give a place on the line, or leave the key out for its middle.",
        ),
        error(
            "slide-lines",
            "The file does not have exactly one line for the slide.",
            "Draw one line from the middle of the slide to where it comes to rest.",
        ),
        error(
            "slide-outside",
            "The slide lies outside the terrain.",
            "Check the line and the reference systems of raster and line.",
        ),
        error(
            "slide-rests",
            "The slide does not move before the run ends.",
            "Give it a velocity above 0 and a line of some length.",
        ),
        warning(
            "slide-uphill",
            "The slide runs uphill. Its line may be drawn backwards.",
            "Draw the line from where the slide breaks off to where it comes to rest.",
        ),
        warning(
            "slide-volume",
            "The slide has another volume on the lattice than in the file.",
            "Enlarge the terrain, correct the line, or choose a finer `resolution`.",
        ),
        warning(
            "terrain-in-breach",
            "Terrain inside the breach stands above the invert. The opening is smaller than it is drawn.",
            "Carve the dam out by `terrain.breaklines`, if the terrain contains it.",
        ),
        warning(
            "trigger-above-crest",
            "The breach begins at a level well above the crest. The water runs over the dam first.",
            "Correct the level or the crest, or let the breach begin at a time.",
        ),
        error(
            "trigger-after-end",
            "The breach begins after the end of the run.",
            "Let it begin earlier, or the run last longer.",
        ),
        error(
            "wall-in-breach",
            "A wall stands in the opening of the dam. It does not break.",
            "Take the wall out: `breach` raises the dam itself.",
        ),
        warning(
            "water-above-crest",
            "Water beside the dam stands above its crest. It runs over the dam from the start.",
            "Correct the level of the lake or the crest, their units or datums.",
        ),
    ],
};
