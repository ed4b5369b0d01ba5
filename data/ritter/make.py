#!/usr/bin/env python3
"""Makes the flat channel of scenarios/ritter. Needs Python alone; the outputs are committed."""

from pathlib import Path

FOLDER = Path(__file__).resolve().parent
COLUMNS, ROWS, CELL = 200, 6, 10.0

header = f"ncols {COLUMNS}\nnrows {ROWS}\nxllcorner 0\nyllcorner 0\ncellsize {CELL:g}\nNODATA_value -9999\n"
(FOLDER / "bed_10m.asc").write_text(header + (" ".join(["0.0"] * COLUMNS) + "\n") * ROWS)

width = ROWS * CELL
ring = f"[[0, 0], [1000, 0], [1000, {width:g}], [0, {width:g}], [0, 0]]"
(FOLDER / "reservoir.geojson").write_text(
    '{"type": "FeatureCollection", "name": "reservoir", "features": [\n'
    '{"type": "Feature", "properties": {"name": "western half", "level_m": 10.0}, '
    f'"geometry": {{"type": "Polygon", "coordinates": [{ring}]}}}}\n]}}\n'
)
gauges = [("R1", 600), ("R2", 900), ("R3", 1000), ("R4", 1300), ("R5", 1600)]
(FOLDER / "gauges.csv").write_text("id,x,y\n" + "".join(f"{name},{x},{width / 2.0:g}\n" for name, x in gauges))
