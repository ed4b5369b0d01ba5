#!/usr/bin/env python3
"""Makes the river of `scenarios/river_flood`: terrain, hydrograph, inflow line, sections and gauges.

Python alone; everything is deterministic, and the outputs are committed. Run it in this folder: python3 make.py
"""

import json
import math
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
COLUMNS, ROWS, CELL = 200, 60, 5.0
SLOPE = 0.002  # fall of the valley to the east
DEPTH = 2.5  # of the river bed below the plain, m


def axis(x):
    """The axis of the river (m)."""
    return 150.0 + 40.0 * math.sin(2.0 * math.pi * x / 600.0) * min(1.0, x / 100.0, (1000.0 - x) / 100.0)


def elevation(x, y):
    across = abs(y - axis(x))
    plain = 100.0 - SLOPE * x + 0.005 * across
    bank = max(0.0, min(1.0, (20.0 - across) / 10.0))  # bed 20 m wide, banks of 10 m on either side
    hill = 0.12 * max(0.0, abs(y - 150.0) - 115.0)
    return plain - DEPTH * bank + hill


def collection(name, features):
    text = {"type": "FeatureCollection", "name": name, "features": features}
    (FOLDER / f"{name}.geojson").write_text(json.dumps(text, indent=1) + "\n")


def line(identifier, places):
    geometry = {"type": "LineString", "coordinates": [list(place) for place in places]}
    return {"type": "Feature", "properties": {"id": identifier}, "geometry": geometry}


def main():
    rows = []
    for row in range(ROWS):
        y = (ROWS - row - 0.5) * CELL
        rows.append(" ".join(f"{elevation((column + 0.5) * CELL, y):.3f}" for column in range(COLUMNS)))
    header = f"ncols {COLUMNS}\nnrows {ROWS}\nxllcorner 0\nyllcorner 0\ncellsize {CELL:g}\nNODATA_value -9999\n"
    (FOLDER / "terrain_5m.asc").write_text(header + "\n".join(rows) + "\n")
    # A flood wave: rises within half an hour from 15 to 220 m3/s, and falls slowly.
    flood = [(0, 15), (10, 15), (20, 80), (30, 170), (40, 220), (50, 190), (65, 130), (80, 80), (100, 45), (120, 30), (150, 20)]
    text = "time_min,q_m3_s\n" + "".join(f"{time},{q}\n" for time, q in flood)
    (FOLDER / "hydrograph.csv").write_text(text)
    collection("inflow", [line("river", [(0.0, 110.0), (0.0, 190.0)])])
    # Drawn from the left to the right bank, looking downstream: from north to south.
    crossings = [("upper", 200.0), ("middle", 500.0), ("lower", 900.0)]
    collection("sections", [line(name, [(x, 290.0), (x, 10.0)]) for name, x in crossings])
    gauges = [("river_upper", 200.0, axis(200.0)), ("plain_middle", 502.5, 152.5), ("river_lower", 900.0, axis(900.0))]
    (FOLDER / "gauges.csv").write_text("id,x,y\n" + "".join(f"{name},{x:.1f},{y:.1f}\n" for name, x, y in gauges))


main()
