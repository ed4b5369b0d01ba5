#!/usr/bin/env python3
"""Makes the channel of scenarios/spill. Needs Python alone; the outputs are committed."""

from pathlib import Path

FOLDER = Path(__file__).resolve().parent
COLUMNS, ROWS, CELL, SLOPE = 150, 25, 4.0, 0.001

header = f"ncols {COLUMNS}\nnrows {ROWS}\nxllcorner 0\nyllcorner 0\ncellsize {CELL:g}\nNODATA_value -9999\n"
row = " ".join(f"{10.0 - SLOPE * (column + 0.5) * CELL:.3f}" for column in range(COLUMNS)) + "\n"
(FOLDER / "bed_4m.asc").write_text(header + row * ROWS)


def polygon(name, west, east, south, north):
    ring = f"[[{west:g}, {south:g}], [{east:g}, {south:g}], [{east:g}, {north:g}], [{west:g}, {north:g}], [{west:g}, {south:g}]]"
    (FOLDER / f"{name}.geojson").write_text(
        f'{{"type": "FeatureCollection", "name": "{name}", "features": [\n'
        f'{{"type": "Feature", "properties": {{"name": "{name}"}}, '
        f'"geometry": {{"type": "Polygon", "coordinates": [{ring}]}}}}\n]}}\n'
    )


polygon("river", 0, COLUMNS * CELL, 0, ROWS * CELL)
polygon("spill", 60, 100, 38, 62)
gauges = [("G1", 150), ("G2", 250), ("G3", 350)]
(FOLDER / "gauges.csv").write_text("id,x,y\n" + "".join(f"{name},{x},50\n" for name, x in gauges))
