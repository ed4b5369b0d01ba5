"""A valley in a raster of 28 km by 28 km at 2 m, and the scenarios of decision 0061.

    python3 docs/performance/large_terrain.py FOLDER             # large.tif, large.yaml (flood in the valley), askew.yaml (gauge 10 km away)
    python3 docs/performance/large_terrain.py FOLDER --cells 4000

Needs numpy, scipy and rasterio; two minutes and 2 GB for 2e8 cells.
"""

import argparse
import json
import pathlib

import numpy as np
import rasterio
from rasterio.transform import from_origin
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial import cKDTree

CELL = 2.0
# Cells of the grid on which the valley is drawn (m), and rows that are written at once.
COARSE, STRIPE = 20.0, 500
WEST, NORTH = 600_000.0, 5_600_000.0
SCENARIO = """\
floodsim: 1
title: A valley in a raster of {cells} by {cells} cells
terrain: {{layers: [{{raster: large.tif}}]}}
resolution: 2 m
roughness: {{manning: 0.04}}
initial: [{{reservoir: lake.geojson, level: {level:.2f} m}}]
time: {{end: 4 min}}
outputs: {{every: 1 min{gauges}}}
"""


def valley(length):
    """Places of the middle of the valley (m from the south-western corner), and the way along it."""
    s = np.linspace(0.0, 1.0, 4001)
    x = length * (0.25 + 0.5 * s)
    y = length * (0.6 - 0.2 * s + 0.03 * np.sin(6 * np.pi * s))
    way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    return x, y, way


def coarse_ground(length, x, y, way, random):
    """Elevation (m) on the coarse grid: a floor of 240 m width that falls by 4 in 1000, flanks, and hills beyond them."""
    count = int(length / COARSE) + 2
    place = (np.arange(count) - 0.5) * COARSE
    grid_x, grid_y = np.meshgrid(place, place)
    off, nearest = cKDTree(np.c_[x, y]).query(np.c_[grid_x.ravel(), grid_y.ravel()])
    off, along = off.reshape(grid_x.shape), way[nearest].reshape(grid_x.shape)
    hills = gaussian_filter(random.standard_normal((count, count)), 40.0)
    beyond = np.clip((off - 300.0) / 1500.0, 0.0, 1.0)
    flank = np.minimum(np.maximum(off - 120.0, 0.0) * 0.12, 150.0)
    return 300.0 - 0.004 * along + flank + beyond * (30.0 + 40.0 * hills / hills.std())


def write_raster(path, cells, ground, random):
    rough = gaussian_filter(random.standard_normal((cells // 10 + 2, cells // 10 + 2)), 2.0)
    rough *= 0.4 / rough.std()
    profile = {
        "driver": "GTiff", "height": cells, "width": cells, "count": 1, "dtype": "float32", "crs": "EPSG:25832", "tiled": True,
        "blockxsize": 512, "blockysize": 512, "compress": "deflate", "predictor": 3,
        "transform": from_origin(WEST, NORTH, CELL, CELL),
    }
    columns = np.arange(cells)
    with rasterio.open(path, "w", **profile) as file:
        for first in range(0, cells, STRIPE):
            rows = np.arange(first, min(cells, first + STRIPE))
            y, x = np.meshgrid((cells - rows - 0.5) * CELL / COARSE + 0.5, (columns + 0.5) * CELL / COARSE + 0.5, indexing="ij")
            stripe = map_coordinates(ground, [y, x], order=1) + rough[rows[:, None] // 10, columns[None, :] // 10]
            file.write(stripe.astype("float32"), 1, window=((first, first + len(rows)), (0, cells)))


def lake(x, y, south):
    """The reservoir: the valley over a twentieth of its length, 400 m wide."""
    begin, end = 400, 600
    along = np.gradient(x)[begin:end:20], np.gradient(y)[begin:end:20]
    across = np.c_[-along[1], along[0]] / np.hypot(*along)[:, None]
    middle = np.c_[x, y][begin:end:20]
    ring = np.concatenate([middle + 200 * across, (middle - 200 * across)[::-1]]) + [WEST, south]
    return [*ring.tolist(), ring[0].tolist()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--cells", type=int, default=14_000, help="columns and rows")
    arguments = parser.parse_args()
    folder, cells = arguments.folder, arguments.cells
    folder.mkdir(parents=True, exist_ok=True)
    length = cells * CELL
    random = np.random.default_rng(7)
    x, y, way = valley(length)
    write_raster(folder / "large.tif", cells, coarse_ground(length, x, y, way, random), random)
    south = NORTH - length
    name = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}
    polygon = {"type": "Polygon", "coordinates": [lake(x, y, south)]}
    feature = {"type": "Feature", "properties": {}, "geometry": polygon}
    text = json.dumps({"type": "FeatureCollection", "crs": name, "features": [feature]})
    (folder / "lake.geojson").write_text(text, encoding="utf-8")
    far = 3000
    (folder / "gauges.csv").write_text(f"id,x,y\nfar,{x[far] + WEST},{y[far] + south}\n", encoding="utf-8")
    level = 300.0 - 0.004 * way[600] + 6.0
    for file, gauges in (("large.yaml", ""), ("askew.yaml", ", gauges: gauges.csv")):
        (folder / file).write_text(SCENARIO.format(cells=cells, level=level, gauges=gauges), encoding="utf-8")


if __name__ == "__main__":
    main()
