#!/usr/bin/env python3
"""Makes the bed and the lake of scenarios/lake_at_rest. Needs Python alone; the outputs are committed.

The bed has, from west to east: a smooth bump, a rough field of independent random heights, a vertical step, an island that
stands 3 m above the water, and a shoal pierced by pockets: small basins that are cut off from each other by ground above
the water. The water stands at 0 m in all of them. Every one of these is a place where some method sets still water moving.
"""

import math
import random
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
COLUMNS, ROWS, CELL = 120, 80, 5.0


def bed(x, y, noise):
    z = -4.0
    z += 2.5 * math.exp(-((x - 90.0) ** 2 + (y - 200.0) ** 2) / (2.0 * 30.0**2))  # bump
    if 160.0 < x < 260.0 and 60.0 < y < 340.0:
        z += 1.5 * noise  # rough field
    if x > 290.0:
        z += 1.5  # step
    z += 5.5 * math.exp(-((x - 370.0) ** 2 + (y - 290.0) ** 2) / (2.0 * 28.0**2))  # island
    if 430.0 < x < 570.0 and 60.0 < y < 240.0:
        z = 0.4 + 1.2 * math.sin(2.0 * math.pi * x / 40.0) * math.sin(2.0 * math.pi * y / 40.0) + 0.3 * noise  # pockets
    return z


generator = random.Random(7)
rows = []
for row in range(ROWS):
    y = (ROWS - row - 0.5) * CELL
    rows.append(" ".join(f"{bed((column + 0.5) * CELL, y, generator.uniform(-1.0, 1.0)):.3f}" for column in range(COLUMNS)))
header = f"ncols {COLUMNS}\nnrows {ROWS}\nxllcorner 0\nyllcorner 0\ncellsize {CELL:g}\nNODATA_value -9999\n"
(FOLDER / "bed_5m.asc").write_text(header + "\n".join(rows) + "\n")

east, north = COLUMNS * CELL, ROWS * CELL
ring = f"[[0, 0], [{east:g}, 0], [{east:g}, {north:g}], [0, {north:g}], [0, 0]]"
(FOLDER / "lake.geojson").write_text(
    '{"type": "FeatureCollection", "name": "lake", "features": [\n'
    '{"type": "Feature", "properties": {"name": "lake", "level_m": 0.0}, '
    f'"geometry": {{"type": "Polygon", "coordinates": [{ring}]}}}}\n]}}\n'
)
