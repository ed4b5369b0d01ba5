//! Terrain, its roughness, and what stands on it: walls, buildings, breaklines.

use super::{Group, either, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Terrain, roughness and structures",
    problems: &[
        error(
            "bad-survey-line",
            "A line of a survey does not give three finite numbers x, y and z.",
            "Correct the line: separate its columns, and write decimal points.",
        ),
        error(
            "building-range",
            "A building has a height or a roughness outside the possible range.",
            "Give a height of 0 to 1000 m, or a Manning roughness above 0 and up to 0.5.",
        ),
        warning(
            "building-too-narrow",
            "Buildings are so narrow that their cells do not touch. Water passes between them.",
            "Choose a finer `resolution`, or draw the building as a wall (`structures.walls`).",
        ),
        warning(
            "building-too-small",
            "Buildings contain no cell centre where cells stay squares, and are left out. Water passes where they stand.",
            "Choose a finer `resolution`, or merge the buildings of a block.",
        ),
        error(
            "building-value",
            "Buildings have no height or no roughness.",
            "Name or fill in the attribute, or give one value for all.",
        ),
        error(
            "clip-outside-layer",
            "The polygons of `clip` contain no data of the layer.",
            "Check that both have the same reference system, or take `clip` out.",
        ),
        warning(
            "contradicting-points",
            "A survey gives two elevations for the same place. The first one is used.",
            "Take the wrong points out of the file.",
        ),
        either(
            "crest-below-terrain",
            "A crest or a raised line is below the terrain: all along it (error) or on part of it (warning).",
            "Correct the level, its unit or its datum, or the place of the line.",
        ),
        warning(
            "doubtful-elevation",
            "Elevations lie outside -500 m to 9000 m. A fill value or a wrong unit would give false terrain.",
            "Declare the fill value as nodata, or give the layer its `unit`.",
        ),
        warning(
            "doubtful-height",
            "Buildings are higher than hardly any building is. The unit may be wrong.",
            "Correct the heights: they are in metres above the ground.",
        ),
        warning(
            "doubtful-level",
            "A line lies so far above or below the terrain that its level is doubtful.",
            "Correct the level, its unit or its datum, or the place of the line.",
        ),
        error("duplicate-class", "A table of roughness has a class twice.", "Keep one line for each class."),
        error(
            "elevation-unit-unknown",
            "A raster counts its places in feet and does not say in what it counts its heights.",
            "Give the layer its `unit`.",
        ),
        warning(
            "finer-than-terrain",
            "The resolution is finer than the cells of the terrain. It costs time and adds no detail.",
            "Take a `resolution` of about the cells of the terrain.",
        ),
        warning(
            "gap-on-lattice",
            "Gaps between walls have another width on the lattice than on the map. More or less water passes them.",
            "Choose a finer `resolution`, move the ends onto cell edges, or join the walls.",
        ),
        error(
            "gap-too-large",
            "A gap of the terrain has more cells than may be filled.",
            "Add a layer below, or raise `max_cells`.",
        ),
        warning(
            "gaps-filled",
            "Gaps of the terrain are filled from their rim. The ground in them is interpolated.",
            "Add a terrain layer below, if the ground there matters.",
        ),
        error(
            "heights-downward",
            "The values of a raster are depths, which count downwards.",
            "Turn them into elevations, or correct the attribute that says so.",
        ),
        either(
            "invert-above-terrain",
            "A carved line is above the terrain all along and changes nothing. All lines of a file are an error, some a warning.",
            "Correct the level, its unit or its datum, or the place of the line.",
        ),
        warning(
            "larger-part",
            "The terrain is large, and a part of it was prepared. The water came near the edge of that part, and the run began again on a larger one.",
            "Do nothing: the results are those of the larger part.",
        ),
        warning(
            "layers-apart",
            "Where two terrain layers overlap, their heights differ. A step is left along the seam.",
            "Give the layer its `offset` or `unit`.",
        ),
        warning(
            "narrow-gap",
            "Walls nearly meet another line: gaps of less than half a cell. Water passes them.",
            "Let the lines meet, unless there is an opening.",
        ),
        error(
            "no-elevation",
            "A survey point has neither a z coordinate nor an attribute with its elevation.",
            "Give the points a z coordinate, or an attribute such as `z`.",
        ),
        error(
            "no-level",
            "Water, a wall or a breakline has no level.",
            "Give the level in the scenario, or name the attribute that has it.",
        ),
        error(
            "no-roughness",
            "A channel, a polygon or uniform flow has no roughness. Its depth and velocity are then not known.",
            "Give a Manning roughness above 0 by `manning` or the attribute `n`.",
        ),
        error(
            "no-surface",
            "The points of a survey make no surface, for example because they lie on one line.",
            "Give at least three points that do not lie on one line.",
        ),
        error(
            "not-a-survey",
            "The file is not a text of survey points x, y and z.",
            "Give a text file with three columns x y z, or a vector file of points.",
        ),
        either(
            "resolution-too-coarse",
            "Too few cells represent the terrain, its maps or a body of water. None for the water is an error, few are a warning.",
            "Choose a finer `resolution`, or a smaller `outputs.cell`.",
        ),
        warning(
            "ridge-in-cell",
            "Ridges of the terrain, such as levees, are narrower than a cell. Water passes them over the pass sills of the cells.",
            "Choose a finer `resolution` where a levee decides; `results.gpkg` shows the ridges.",
        ),
        warning(
            "roughness-default",
            "Cells without a roughness in the raster take the default roughness.",
            "Add the missing classes or values, if the default does not fit there.",
        ),
        error(
            "roughness-gap",
            "The terrain has cells without a roughness.",
            "Add the missing classes or values, or give `roughness.default`.",
        ),
        error(
            "roughness-range",
            "A Manning roughness is not above 0 and at most 0.5.",
            "Correct the value; a raster of classes needs `roughness.table`.",
        ),
        either(
            "seam-without-data",
            "Cells between parts of the terrain have no data and are walls. With `terrain.gaps: error` this is an error.",
            "Let the layers overlap by two cells, or put a layer below.",
        ),
        warning(
            "steps-in-cells",
            "The terrain has upright steps inside cells. Walls or houses that fill less than half a cell are not in the bed.",
            "Draw them as buildings, walls or breaklines, or choose a finer `resolution`.",
        ),
        either(
            "terrain-gaps",
            "Terrain without data is a wall for the water. With `terrain.gaps: error` this is an error.",
            "Add a layer below, fill the gaps by `terrain.gaps`, or write `terrain.gaps: wall`.",
        ),
        error(
            "undeclared-nodata",
            "Cells hold a number that programs write where there is no data, far from all that lies beside them. The file does not declare it.",
            "Declare it as nodata with `gdal_edit.py -a_nodata`.",
        ),
        error(
            "unit-of-elevation",
            "The file states another unit for its heights than the one in which they would be read.",
            "Give the layer its `unit`, or correct the unit in the file.",
        ),
    ],
};
