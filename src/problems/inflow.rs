//! Water that comes in or leaves: boundaries, sources, rain.

use super::{Group, either, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Boundaries, sources and rain",
    problems: &[
        error(
            "accumulated-rain",
            "Depths of rain fall nowhere in the series. They seem to count from its beginning, and too much rain would fall.",
            "Take the differences of the rasters first, for example with `cdo deltat`.",
        ),
        error(
            "bad-bounds",
            "The bounds of times in a NetCDF file are empty, overlap or cannot be read.",
            "Correct the bounds: each interval ends after its start and before the next one.",
        ),
        error(
            "boundary-dry",
            "The highest level of a boundary is not above the lowest ground along it. No water would pass.",
            "Correct the level, its unit or its datum, or draw the boundary through the river bed.",
        ),
        warning(
            "closed-edge",
            "Water stands at an edge of the terrain that nothing opens: an edge without an entry in `boundaries` is a wall.",
            "Open the edge, take more terrain, or write `type: closed` where a wall stands.",
        ),
        warning(
            "drowned-terrain",
            "A boundary holds a level far above all terrain. The unit or the datum may be wrong.",
            "Correct the level, its unit or its datum.",
        ),
        error(
            "falling-discharge",
            "A rating curve has less discharge at a higher level.",
            "Correct the rows: the discharge rises with the level, or stays.",
        ),
        warning(
            "fast-inflow",
            "Discharge and level together give an unusually fast inflow.",
            "Correct the level or the discharge and their units.",
        ),
        warning(
            "high-wave",
            "A wave is too high for the depth of the still water. It comes in as critical flow.",
            "Correct `wave` or `still`, or give the level at the boundary by `level`.",
        ),
        warning(
            "high-weir",
            "A rating curve begins far above dry ground. Nothing leaves until the water stands so high.",
            "Correct the levels of the table, unless a reservoir is to fill there.",
        ),
        warning(
            "huge-discharge",
            "The discharge is too large for its width: critical flow would be deeper than in any flood.",
            "Correct the discharge and its unit, or the width over which it comes in.",
        ),
        warning(
            "level-is-at-the-boundary",
            "`level` holds the water level at the boundary itself. Earlier versions took it as that of still water beyond.",
            "Write `stage` for still water beyond the boundary.",
        ),
        warning(
            "lower-ground-beside",
            "The edge beside a boundary is lower than the ground along it. The line may miss the river bed.",
            "Draw the line across the whole river bed.",
        ),
        error(
            "no-start",
            "Times of rain are dates, and the date of the start of the run is not known.",
            "Add `rain.start` or `time.reference`, in UTC.",
        ),
        error(
            "no-time",
            "The times of a series of rain rasters are not known.",
            "Give the first dimension a coordinate variable with `units` such as `minutes since 2026-06-01`.",
        ),
        error(
            "not-a-line",
            "A file of line sources has features that are not lines. No water would come from them.",
            "Take these features out, or give them as points in a source of their own.",
        ),
        error(
            "not-a-list",
            "The file is neither NetCDF nor a list of rasters.",
            "Name a NetCDF file, or a CSV file that begins with `time_min,file`.",
        ),
        error(
            "not-a-netcdf",
            "The file cannot be read as NetCDF.",
            "Copy or export the file again; `ncdump -h` shows whether it is NetCDF.",
        ),
        error(
            "not-a-point",
            "A file of point sources has features that are not points. No water would come from them.",
            "Take these features out, or draw them as points.",
        ),
        error(
            "not-a-row",
            "A row of a list of rasters does not give a time and a file.",
            "Write a time, a comma and the path of a raster.",
        ),
        either(
            "opens-nothing",
            "A boundary or a channel touches no edge of the terrain, and nothing passes. For open lines this is a warning.",
            "Draw it along the edge of the terrain data; inside the terrain use `sources`.",
        ),
        error(
            "other-grid",
            "A raster of rain has another grid than the one before it.",
            "Bring all rasters to one grid with `gdalwarp -te -tr`.",
        ),
        error(
            "other-unit",
            "The file and the scenario state different units of rain.",
            "Correct the unit in the scenario or in the file.",
        ),
        error(
            "overlapping-boundaries",
            "Two boundaries share faces of the edge.",
            "Give each part of the edge one condition.",
        ),
        error(
            "packed-times",
            "Times of a NetCDF file are packed (`scale_factor` or `add_offset`). Their bounds would not be clear.",
            "Unpack the file with `ncpdq -U`.",
        ),
        warning(
            "rain-doubtful",
            "The rain is heavier than any on record. The unit may be wrong.",
            "Check the unit of the rain.",
        ),
        error(
            "rain-gap",
            "A raster of rain has cells on the terrain without a value.",
            "Give these cells values, 0 where no rain falls.",
        ),
        warning(
            "rain-held-back",
            "More than a twentieth of the rain stands in films below `numerics.dry_depth` and in pits at the end. It runs off nowhere.",
            "Take a smaller `numerics.dry_depth` for thin rain, and fill the pits that the ground does not have.",
        ),
        error(
            "rain-outside",
            "The rasters of rain do not cover the whole terrain.",
            "Take rasters of the whole terrain, cut the terrain, or check the reference systems.",
        ),
        warning(
            "rain-without-water",
            "No rain falls, or losses take all of it. The rain only costs time.",
            "Correct the rain, its losses and their units, or take `rain` out.",
        ),
        error(
            "rating-start",
            "A rating curve begins with a discharge above 0. The discharge would jump at its first level.",
            "Let the curve begin at the level at which the discharge is 0.",
        ),
        warning(
            "rating-without-discharge",
            "A rating curve has no discharge above 0. The boundary is a wall.",
            "Give the discharges of its levels, or take the boundary out.",
        ),
        warning(
            "rising-ground",
            "Uniform flow is to leave over ground that rises towards the edge. The depth there is not that of the terrain.",
            "Take `type: open`, a rating curve or `stage`, or move the edge to falling ground.",
        ),
        warning(
            "several-lines",
            "Each line of the file gives the whole discharge. The sum is larger than the value in the scenario.",
            "Join the lines in one feature, or divide the discharge, unless the sum is meant.",
        ),
        warning(
            "side-in-part",
            "Part of a side stays a wall, because the edge of the terrain steps back there.",
            "Draw a `line` along the edge or fill the terrain, unless that ground stays dry.",
        ),
        error(
            "source-outside",
            "A source lies outside the terrain, on nodata or in a building. Its water would be lost.",
            "Check the coordinates, their order and their reference system.",
        ),
        error(
            "stamp-beside-bounds",
            "The times of the rasters have bounds, which contradict the key `stamp`.",
            "Take `stamp` out.",
        ),
        error(
            "start-without-date",
            "`rain.start` is given, and the times have no dates: they count from the start of the run.",
            "Take `rain.start` out, or give the times dates.",
        ),
        warning(
            "step-of-level",
            "Two neighbouring boundaries hold different levels. Water runs along the edge from one to the other.",
            "Correct the levels, or leave a closed part of the edge between them.",
        ),
        error(
            "too-few-rasters",
            "A series has fewer than two rasters, so that no interval is known.",
            "Give at least two rasters, or take `raster` for constant rain.",
        ),
        error(
            "two-starts",
            "`rain.start` and `time.reference` are different dates for the start of the run.",
            "Take one of them out, or make them agree.",
        ),
        warning(
            "wave-begins-with-step",
            "A wave begins at another level than the still water. The difference comes in as a bore.",
            "Let the series begin at the level of the still water, or correct `still`.",
        ),
        error(
            "wave-without-still",
            "A wave comes in over ground that is dry at the start. Its velocity is not known.",
            "Give the level of the still water by `still`.",
        ),
    ],
};
