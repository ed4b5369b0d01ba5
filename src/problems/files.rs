//! Files that cannot be read, and coordinate reference systems that do not agree.

use super::{Group, either, error, warning};

pub(super) const GROUP: Group = Group {
    title: "Files and reference systems",
    problems: &[
        error(
            "all-nodata",
            "Every cell of a raster is nodata. Nothing of it can be used.",
            "Check the nodata value and the valid range that the file states.",
        ),
        warning(
            "assumed-crs",
            "A file states no coordinate reference system (CRS). Its coordinates are taken as those of the run.",
            "Write the CRS into the file, or put a .prj file beside it.",
        ),
        warning(
            "assumed-encoding",
            "The text of a vector file is not UTF-8, and no other encoding is named. It is read as Windows-1252.",
            "Put a .cpg file that names the encoding beside it.",
        ),
        error(
            "axes-swapped",
            "A NetCDF variable has its dimensions in another order than time, y, x. It would be read transposed.",
            "Reorder the dimensions with `ncpdq -a`.",
        ),
        error(
            "axes-unknown",
            "It is not known which dimension of a NetCDF variable is x and which is y.",
            "Give the coordinate variables the attribute `axis` with `ncatted`.",
        ),
        error(
            "axis-uneven",
            "The places along an axis of a NetCDF file are not evenly spaced. Terrain would come to lie elsewhere.",
            "Fill the missing rows or columns with no data, or resample the file to even places.",
        ),
        error(
            "axis-unit",
            "An axis of a NetCDF file has another unit than its reference system. Its places would be wrong.",
            "Bring the axes to the unit of the reference system, or correct their attribute `units`.",
        ),
        error(
            "code-in-file",
            "A VRT holds a function in Python that would be run to read it. An input is data, and its code is never run.",
            "Write its values to a GeoTIFF with `gdal_translate`, where you trust it.",
        ),
        warning(
            "crs-set-aside",
            "A file states a coordinate reference system, which `crs: local` ignores.",
            "Leave `crs: local` out to keep the place on Earth.",
        ),
        error(
            "different-crs",
            "A raster has another coordinate reference system (CRS) than the run. Its places would be wrong.",
            "Set `terrain.reproject: true`, convert the file, or take the CRS of the earlier run.",
        ),
        warning(
            "different-vertical-datum",
            "Two terrain layers have different vertical datums. A step is left along their seam.",
            "Give the layer its `offset`, or convert its heights beforehand.",
        ),
        either(
            "distorted-crs",
            "Lengths on the map differ from those on the ground: areas and volumes are wrong. A large distortion is an error, a smaller one a warning.",
            "Set `terrain.reproject: true`, and `crs` to a system of the place such as its UTM zone.",
        ),
        error("empty-file", "A file is empty (0 bytes).", "Copy or export the file again."),
        error(
            "empty-polygon",
            "A file has no polygon, or a polygon has no area.",
            "Draw the area as a polygon with at least three corners.",
        ),
        error(
            "foreign-file",
            "An input is on a network or in an archive, or a VRT names a file there or outside of the folder of the scenario. Nobody chose that file.",
            "Copy the file into the folder of the scenario, or trust it with `limits.allow_remote: true`.",
        ),
        error(
            "geographic-crs",
            "Coordinates are in degrees, and a run needs metres.",
            "Set `terrain.reproject: true` and a metric `crs`, or convert the file.",
        ),
        warning(
            "left-out",
            "Some features of a file have another geometry than this key needs. They are left out.",
            "Take them out of the file, or draw them with the geometry that is needed.",
        ),
        error(
            "missing-file",
            "A file does not exist.",
            "Correct the path; it counts from the folder of the scenario or of the list.",
        ),
        warning(
            "no-checksum",
            "An input is no file of this machine. `run.json` has no checksum of it.",
            "Download or unpack it where the run is to be repeated.",
        ),
        error(
            "no-crs",
            "Neither the terrain nor the scenario states a coordinate reference system (CRS).",
            "Write `crs: EPSG:...`, or `crs: local` for plain metres.",
        ),
        error(
            "no-georeference",
            "A raster has no place on the map, or its cells have no area.",
            "Georeference the raster, for example with `gdal_translate -a_ullr`.",
        ),
        error("no-lines", "A file has no line, or no line for this entry.", "Draw the lines, or take the key out."),
        error("no-points", "A file has no point.", "Give the file points, or take the entry out."),
        error(
            "no-such-layer",
            "A vector file does not have the layer that is named.",
            "Correct the name behind the colon; the message lists the layers.",
        ),
        error(
            "no-transformation",
            "Coordinates of a file could not be converted to the reference system of the run.",
            "Check that `crs` covers the place of the file on Earth.",
        ),
        error(
            "no-variable",
            "The variable that is named is missing, or it is not known which variable is meant.",
            "Name one of the variables of the file behind a colon.",
        ),
        error(
            "not-a-file",
            "An input, or the scenario, is a named pipe, a device or a socket. It may never end, and has no checksum.",
            "Write what it gives to a file, and name that.",
        ),
        error(
            "not-a-number",
            "A raster, a table or a polygon has a value that is not a finite number.",
            "Correct the value, declare it as nodata, or take it out.",
        ),
        error(
            "not-a-place",
            "A feature has a coordinate that is no place on Earth.",
            "Export the file again, or draw the feature anew.",
        ),
        error(
            "not-a-raster",
            "The file is not a raster that the program reads.",
            "Name a GeoTIFF, an ESRI ASCII grid or another raster; `gdal_translate` makes one of most others.",
        ),
        error(
            "not-a-vector",
            "The file is not a vector file that the program reads.",
            "Name a GeoJSON, GeoPackage or Shapefile; `ogr2ogr` makes one of most others.",
        ),
        error(
            "not-metric-crs",
            "Coordinates are not in metres, and a run needs metres.",
            "Set `terrain.reproject: true` and a metric `crs`, or convert the file.",
        ),
        either(
            "outside-terrain",
            "Features lie on no terrain and have no effect there. All of them is an error, a part of them a warning.",
            "Check coordinates and reference system of the file, or enlarge the terrain.",
        ),
        warning(
            "outside-valid-range",
            "Cells lie outside the range that the file calls valid. They count as nodata.",
            "Correct or delete the attribute of the valid range, if these cells are data.",
        ),
        error(
            "rotated-raster",
            "The grid of a raster is rotated. The run needs rows from west to east.",
            "Set `terrain.reproject: true`, or resample the raster with `gdalwarp`.",
        ),
        error(
            "self-crossing",
            "The outline of a polygon crosses itself. Its area is not clear.",
            "Correct the polygon, for example with `Fix geometries` in QGIS.",
        ),
        either(
            "several-bands",
            "A raster has several bands: the first one is used (warning). In a list of rain rasters this is an error.",
            "Write the band that is meant to a file of its own with `gdal_translate -b`.",
        ),
        error(
            "several-layers",
            "A vector file has several layers with features. It is not known which one is meant.",
            "Name the layer behind a colon, or write it to a file of its own.",
        ),
        error(
            "too-many-values",
            "An ASCII grid has more values than its header states. Its rows would be shifted.",
            "Correct `ncols` and `nrows`, or export the file again.",
        ),
        either(
            "unit-of-attribute",
            "An attribute is read in metres: its name states another unit (error), or the terrain has one (warning).",
            "Bring the values to metres, in an attribute such as `crest_m`.",
        ),
        error(
            "unknown-crs",
            "The value of `crs` is not a coordinate reference system.",
            "Give an EPSG code, such as `EPSG:25832`.",
        ),
        error(
            "unreadable-file",
            "A file cannot be opened or read.",
            "Check the path, and the permissions of the file and of its folder.",
        ),
        error(
            "unreadable-raster",
            "A raster opens, but its values cannot be read: it is damaged or cut short.",
            "Copy or export the file again.",
        ),
        error(
            "unsupported-geometry",
            "A feature has a kind of geometry that is not supported, such as a curve.",
            "Convert it to points, lines and polygons, for example with `ogr2ogr -nlt CONVERT_TO_LINEAR`.",
        ),
        warning(
            "untidy-polygon",
            "A polygon is not simple, but its area is clear. It is used.",
            "Correct the polygon in a GIS if its area is not the one that is meant.",
        ),
        error(
            "warp-failed",
            "A raster could not be warped to the reference system of the run.",
            "Check that `crs` covers the place of the raster on Earth.",
        ),
    ],
};
