"""A valley of 50 km in a raster of 50 km by 4 km at 5 m, and a dam break in it, for cells.py.

    python3 docs/performance/long_valley.py FOLDER             # valley.tif, lake.geojson, scenario.yaml

The valley winds between flanks. Its floor is a gorge of 40 m here and a basin of 700 m there, by chance and not by a multiple of any cell; a
channel of 28 m winds on it. The lake stands behind a dam of 25 m that is gone at the start. In 30 minutes the flood goes ten kilometres.

Needs numpy, scipy and rasterio; some seconds and 1 GB.
"""

import argparse
import json
import pathlib

import numpy as np
import rasterio
from rasterio.transform import from_origin
from scipy.ndimage import gaussian_filter, gaussian_filter1d, map_coordinates
from scipy.spatial import cKDTree

LENGTH, BREADTH, CELL = 50_000.0, 4_000.0, 5.0
# Cells of the grid on which places are referred to the middle of the valley (m), and rows that are written at once.
COARSE, STRIPE = 20.0, 100
WEST, SOUTH = 600_000.0, 5_600_000.0
# Way (m) along the middle at which the dam stands, and the depth of the lake there (m).
DAM, DAM_DEPTH = 5_000.0, 25.0
SCENARIO = """\
floodsim: 1
title: A long valley with a dam break
terrain: {{layers: [{{raster: valley.tif}}]}}
resolution: 5 m
roughness: {{manning: 0.045}}
initial: [{{reservoir: lake.geojson, level: {level:.2f} m}}]
boundaries: [{{side: east, type: open}}]
time: {{end: 30 min}}
outputs: {{every: 10 min}}
"""


class Valley:
    """The middle of the valley in steps of 5 m, and what lies along it."""

    def __init__(self, random):
        x = np.linspace(0.0, LENGTH, 20_001)
        y = 0.5 * BREADTH + 700.0 * np.sin(2 * np.pi * x / 8_300.0) + 130.0 * np.sin(2 * np.pi * x / 2_700.0 + 1.0)
        way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        self.way = np.arange(0.0, way[-1], 5.0)
        self.x, self.y = np.interp(self.way, way, x), np.interp(self.way, way, y)
        self.along = np.c_[np.gradient(self.x), np.gradient(self.y)] / 5.0
        count = len(self.way)

        def by_chance(length):
            values = gaussian_filter1d(random.standard_normal(count), length / 5.0, mode="wrap")
            return values / values.std()

        # Falls by 8 in 1000 above the dam and some 3 in 1000 below it.
        fall = np.where(self.way < DAM, 0.008, 0.0032 * np.exp(0.3 * by_chance(1_500.0)))
        self.floor = 500.0 - np.cumsum(gaussian_filter1d(fall, 60.0)) * 5.0
        self.half_width = 0.5 * np.clip(150.0 * np.exp(0.8 * by_chance(600.0)), 40.0, 700.0)
        # Flanks rise by 0.25 to 0.7; either side has its own.
        self.flank = [np.clip(0.42 + 0.1 * by_chance(700.0), 0.25, 0.7) for _ in range(2)]
        room = np.maximum(self.half_width - 25.0, 0.0)
        self.channel = np.clip(0.7 * by_chance(250.0), -1.0, 1.0) * room

    def refer(self):
        """Way along the middle and offset to the left of it (m), on the coarse grid."""
        columns, rows = int(LENGTH / COARSE) + 2, int(BREADTH / COARSE) + 2
        grid_x, grid_y = np.meshgrid((np.arange(columns) - 0.5) * COARSE, (np.arange(rows) - 0.5) * COARSE)
        places = np.c_[grid_x.ravel(), grid_y.ravel()]
        _, nearest = cKDTree(np.c_[self.x, self.y]).query(places)
        off = places - np.c_[self.x, self.y][nearest]
        along = self.along[nearest]
        way = self.way[nearest] + (off * along).sum(axis=1)
        left = along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]
        return way.reshape(grid_x.shape), left.reshape(grid_x.shape)

    def ground(self, way, left):
        """Elevation (m): floor, channel of 2.5 m depth with banks of 15 m, flanks."""
        at = lambda values: np.interp(way, self.way, values)
        beyond = np.maximum(np.abs(left) - at(self.half_width), 0.0)
        slope = np.where(left > 0.0, at(self.flank[0]), at(self.flank[1]))
        # The toe of a flank is round over some 30 m.
        rise = slope * beyond * beyond / (beyond + 15.0)
        from_channel = np.abs(left - at(self.channel))
        cut = 2.5 * np.clip((21.5 - from_channel) / 15.0, 0.0, 1.0)
        return at(self.floor) + 0.004 * np.minimum(from_channel, 350.0) + np.minimum(rise, 160.0) - cut


def write_raster(path, valley, random):
    columns, rows = int(LENGTH / CELL), int(BREADTH / CELL)
    way, left = valley.refer()
    rough = gaussian_filter(random.standard_normal((rows, columns)), 3.0)
    rough *= 0.15 / rough.std()
    profile = {
        "driver": "GTiff", "height": rows, "width": columns, "count": 1, "dtype": "float32", "crs": "EPSG:25832", "tiled": True,
        "blockxsize": 256, "blockysize": 256, "compress": "deflate", "predictor": 3,
        "transform": from_origin(WEST, SOUTH + BREADTH, CELL, CELL),
    }
    with rasterio.open(path, "w", **profile) as file:
        for first in range(0, rows, STRIPE):
            own = np.arange(first, min(rows, first + STRIPE))
            place = np.meshgrid((rows - own - 0.5) * CELL / COARSE + 0.5, (np.arange(columns) + 0.5) * CELL / COARSE + 0.5, indexing="ij")
            refer = lambda grid: map_coordinates(grid, place, order=1)
            stripe = valley.ground(refer(way), refer(left)) + rough[own]
            file.write(stripe.astype("float32"), 1, window=((first, first + len(own)), (0, columns)))


def lake(valley):
    """Outline of the reservoir: a strip along the valley down to the dam, wider than the water."""
    end = int(DAM / 5.0)
    begin = int(0.1 * end)
    part = slice(begin, end + 1, 10)
    across = np.c_[-valley.along[part, 1], valley.along[part, 0]] * (valley.half_width[part, None] + 150.0)
    middle = np.c_[valley.x, valley.y][part] + [WEST, SOUTH]
    ring = np.concatenate([middle + across, (middle - across)[::-1]])
    return [*ring.tolist(), ring[0].tolist()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(11)
    valley = Valley(random)
    write_raster(folder / "valley.tif", valley, random)
    name = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}
    feature = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [lake(valley)]}}
    text = json.dumps({"type": "FeatureCollection", "crs": name, "features": [feature]})
    (folder / "lake.geojson").write_text(text, encoding="utf-8")
    level = np.interp(DAM, valley.way, valley.floor) + DAM_DEPTH
    (folder / "scenario.yaml").write_text(SCENARIO.format(level=level), encoding="utf-8")


if __name__ == "__main__":
    main()
