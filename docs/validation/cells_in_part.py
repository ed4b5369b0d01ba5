"""Terrain that ends inside of cells: the two tables of docs/decisions/0053-cells-in-part.md, as Markdown.

    python3 docs/validation/cells_in_part.py target/release/floodsim runs/cells_in_part

The first argument is the program, the second a folder for terrain, scenarios and runs. All cells are 1 m wide. In tanks of some lengths the
two halves of the water differ by 1 cm; the period of the swing is compared with 2L/sqrt(g d). In channels of some widths the depth in the
middle is compared with that of uniform flow. The runs take some seconds. Only the standard library is needed.
"""

import argparse
import csv
import json
import math
import pathlib
import subprocess

GRAVITY = 9.81  # m/s2, that of the program
LENGTHS = (30, 30.2, 30.4, 30.5, 30.6, 30.8)  # m
WIDTHS = (8, 8.25, 8.5, 8.75)  # m
SLOPE, MANNING = 0.002, 0.03
OUTPUTS = "outputs: {every: 100 s, gauges: gauges.csv, gauges_every: 0.05 s, write: [tables]}\n"


def raster(path, size, cell, height=lambda x: 0.0):
    columns, rows = (round(length / cell) for length in size)
    row = " ".join(f"{height((column + 0.5) * cell):.6f}" for column in range(columns))
    head = f"ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize {cell}\n"
    path.write_text(head + (row + "\n") * rows, encoding="utf-8")


def run(arguments, scenario, place):
    """Runs a scenario; times (s) and depths (m) at a gauge."""
    folder = arguments.folder
    (folder / "gauges.csv").write_text(f"id,x,y\na,{place[0]},{place[1]}\n", encoding="utf-8")
    (folder / "s.yaml").write_text("floodsim: 1\ncrs: local\nterrain: terrain.asc\nresolution: 1 m\n" + scenario + OUTPUTS, encoding="utf-8")
    subprocess.run([arguments.program.resolve(), "run", "s.yaml", "--out", "out", "--overwrite", "--quiet"], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(folder / "out" / "tables" / "gauge_series.csv", encoding="utf-8", newline="") as series:
        return [(float(row["time_s"]), float(row["depth_m"])) for row in csv.DictReader(series)]


def period(arguments, length):
    """Period of the swing in a tank less the exact one, over that."""
    raster(arguments.folder / "terrain.asc", (length, 3.0), 0.1)
    half = length / 2
    waters = [([[0, 0], [half, 0], [half, 3], [0, 3], [0, 0]], 1.005), ([[half, 0], [length, 0], [length, 3], [half, 3], [half, 0]], 0.995)]
    features = [{"type": "Feature", "properties": {"level_m": level}, "geometry": {"type": "Polygon", "coordinates": [ring]}} for ring, level in waters]
    (arguments.folder / "water.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}), encoding="utf-8")
    series = run(arguments, "roughness: {manning: 0}\ninitial: [{reservoir: water.geojson}]\ntime: {end: 200 s}\n", (1.5, 1.5))
    exact = 2.0 * length / math.sqrt(GRAVITY)
    crossings = []
    for (before, a), (after, b) in zip(series, series[1:]):
        if (a > 1.0) != (b > 1.0):
            time = before + (after - before) * (1.0 - a) / (b - a)
            # The front rings about the mean: one crossing for each half period.
            if not crossings or time - crossings[-1] > 0.35 * exact:
                crossings.append(time)
    return 2.0 * (crossings[-1] - crossings[0]) / (len(crossings) - 1) / exact - 1.0


def depth(arguments, width):
    """Depth in the middle of a channel less that of uniform flow, over that."""
    raster(arguments.folder / "terrain.asc", (200.0, width), 0.25, lambda x: -SLOPE * x)
    boundaries = f"boundaries: [{{side: west, discharge: {width} m3/s}}, {{side: east, normal_depth: {{slope: {SLOPE}}}}}]\n"
    series = run(arguments, f"roughness: {{manning: {MANNING}}}\n{boundaries}time: {{end: 600 s}}\n", (100.5, 4.5))
    return series[-1][1] / (MANNING / math.sqrt(SLOPE)) ** 0.6 - 1.0


def table(name, values, error):
    print(f"| {name} (m) | " + " | ".join(f"{value:g}" for value in values) + " |")
    print("| --- " * (len(values) + 1) + "|")
    print("| error | " + " | ".join(f"{100 * error(value):+.2f} %" for value in values) + " |\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    table("length", LENGTHS, lambda length: period(arguments, length))
    table("width", WIDTHS, lambda width: depth(arguments, width))


if __name__ == "__main__":
    main()
