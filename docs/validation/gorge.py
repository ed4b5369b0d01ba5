"""Depths in gorges that lie askew to the lattice: the tables of docs/decisions/0049-what-raises-levels-in-gorges.md, as Markdown.

    python3 docs/validation/gorge.py target/release/floodsim runs/gorge

The first argument is the program, the second a folder for terrain, scenarios and runs. A steady discharge fills a gorge with a bottom of
80 m, or a V-shaped valley, on cells of 5 to 40 m. Of straight gorges the first table has the depth over that along the lattice on cells of
5 m: all of them should be 1. Of gorges with two bends the second one has the difference of level from the run on cells of 5 m, as mean and
mean absolute value. The runs take six minutes of CPU time. Only the standard library is needed.
"""

import argparse
import csv
import json
import math
import pathlib
import subprocess

DISCHARGE, FALL, MANNING = 4000.0, 0.008, 0.033  # m3/s, -, s m^(-1/3)
HALF_BOTTOM, HALF_WIDTH, HIGHEST_BANK = 40.0, 120.0, 40.0  # m; the terrain ends at HALF_WIDTH from the axis
PIXEL = 2.5  # m
SPACINGS = (5, 10, 20, 40)  # m; the first is the measure of the others
END = {5: 600, 10: 600, 20: 2400, 40: 2400}  # s; where the water is held up it takes longer to fill the gorge
AVERAGED = 100  # s before the end, over which levels are averaged
# Angle to the lattice (degrees), and by how much (m) the axis lies beside an edge between two rows of cells of 40 m.
PLACES = ((0, 0), (0, 10), (15, 0), (30, 0), (45, 0))
# Name, half width of the bottom (m), rise of the banks over their width.
SECTIONS = (
    ("banks 1:1", HALF_BOTTOM, 1.0),
    ("banks 3:1", HALF_BOTTOM, 3.0),
    ("valley 1:2", 0.0, 0.5),
    ("valley 1:4", 0.0, 0.25),
    ("buildings", HALF_BOTTOM, 0.0),
)
# Pieces of an axis: length (m), turn to the left (degrees).
STRAIGHT = ((1600.0, 0.0),)
BENDS = ((500.0, 0.0), (250.0, 54.0), (300.0, 0.0), (250.0, -42.0), (500.0, 0.0))
# Gauges stand in five rows over the middle half of the bottom, in one where there is none: distance of two, and of the first and last from
# the ends (m) in straight and winding gorges.
APART, FROM_ENDS = 15.0, {STRAIGHT: (700.0, 300.0), BENDS: (300.0, 200.0)}


class Axis:
    """The line in the middle of a gorge, of straight pieces and arcs, from x = 0, y = `shift` on."""

    def __init__(self, pieces, heading, shift=0.0):
        self.pieces, self.from_ends = [], FROM_ENDS[pieces]
        along, x, y, heading = 0.0, 0.0, shift, math.radians(heading)
        for length, turn in pieces:
            self.pieces.append((along, length, x, y, heading, math.radians(turn)))
            along, x, y, heading = along + length, *self.place(along + length, 0.0), heading + math.radians(turn)
        self.length = along

    def place(self, along, across):
        """Coordinates of a place by its distance along the axis and to the left of it."""
        start, length, x, y, heading, turn = max(piece for piece in self.pieces if piece[0] <= max(along, 0.0))
        s, end = along - start, heading + turn * (along - start) / length
        if turn == 0.0:
            x, y = x + s * math.cos(heading), y + s * math.sin(heading)
        else:
            radius = length / turn
            x, y = x + radius * (math.sin(end) - math.sin(heading)), y - radius * (math.cos(end) - math.cos(heading))
        return x - across * math.sin(end), y + across * math.cos(end)

    def nearest(self, x, y):
        """Distance along the axis and to the left of it; none beyond its ends and HALF_WIDTH."""
        found = None
        for start, length, x0, y0, heading, turn in self.pieces:
            dx, dy = x - x0, y - y0
            along = dx * math.cos(heading) + dy * math.sin(heading)
            across = dy * math.cos(heading) - dx * math.sin(heading)
            if turn != 0.0:
                radius = length / turn
                angle = math.atan2(along, radius - across) if turn > 0.0 else math.atan2(along, across - radius)
                along, across = angle * abs(radius), radius - math.copysign(math.hypot(along, radius - across), radius)
            if 0.0 <= along <= length and abs(across) <= (abs(found[1]) if found else HALF_WIDTH):
                found = (start + along, across)
        return found


def bottom(axis, along):
    return FALL * (axis.length - along)


def elevation(axis, half_bottom, rise, along, across):
    return bottom(axis, along) + min(rise * max(abs(across) - half_bottom, 0.0), HIGHEST_BANK)


def write_terrain(folder, axis, half_bottom, rise):
    """The raster terrain.asc."""
    rim = [axis.place(axis.length * i / 200, side * HALF_WIDTH) for i in range(201) for side in (-1, 1)]
    # Whole cells of the coarsest lattice; along the lattice the edges of the bottom are edges of cells.
    step = SPACINGS[-1]
    west, south = (step * math.floor(min(place[i] for place in rim) / step) for i in (0, 1))
    east, north = (step * math.ceil(max(place[i] for place in rim) / step) for i in (0, 1))
    columns, rows = (round(width / PIXEL) for width in (east - west, north - south))
    with (folder / "terrain.asc").open("w") as file:
        file.write(f"ncols {columns}\nnrows {rows}\nxllcorner {west}\nyllcorner {south}\ncellsize {PIXEL}\nNODATA_value -9999\n")
        for row in reversed(range(rows)):
            places = (axis.nearest(west + (column + 0.5) * PIXEL, south + (row + 0.5) * PIXEL) for column in range(columns))
            file.write(" ".join("-9999" if place is None else f"{elevation(axis, half_bottom, rise, *place):.3f}" for place in places) + "\n")


def write_shapes(path, kind, shapes):
    features = [{"type": "Feature", "properties": {}, "geometry": {"type": kind, "coordinates": shape}} for shape in shapes]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))


def write_scenario(folder, axis, half_bottom, rise):
    """Terrain, lines, gauges and scenario of a gorge; the levels (m) of its bottom at the gauges."""
    folder.mkdir(parents=True, exist_ok=True)
    write_terrain(folder, axis, half_bottom, rise)
    for name, along in (("inflow", 0.0), ("outflow", axis.length)):
        write_shapes(folder / f"{name}.geojson", "LineString", [[axis.place(along, side * HALF_WIDTH) for side in (1, -1)]])
    structures = ""
    if rise == 0.0:
        # They reach beyond the ends, so that no cell of an end lies beside the bottom.
        ring = ((-50, 40), (axis.length + 50, 40), (axis.length + 50, 150), (-50, 150), (-50, 40))
        write_shapes(folder / "buildings.geojson", "Polygon", [[[axis.place(along, side * across) for along, across in ring]] for side in (1, -1)])
        structures = "structures: {buildings: {polygons: buildings.geojson, mode: block}}\n"
    first, from_end = axis.from_ends
    beds, lines = {}, ["id,x,y"]
    for i in range(round((axis.length - first - from_end) / APART)):
        for j in range(-2, 3) if half_bottom > 0.0 else [0]:
            along, name = first + i * APART, f"{i}_{j}"
            x, y = axis.place(along, j * half_bottom / 4)
            beds[name] = bottom(axis, along)
            lines.append(f"{name},{x:.2f},{y:.2f}")
    (folder / "gauges.csv").write_text("\n".join(lines) + "\n")
    (folder / "scenario.yaml").write_text(
        "floodsim: 1\ncrs: local\nterrain: {layers: [{raster: terrain.asc}], gaps: wall}\n"
        f"roughness: {{manning: {MANNING}}}\n{structures}"
        f"boundaries:\n  - {{line: inflow.geojson, discharge: {DISCHARGE} m3/s}}\n  - {{line: outflow.geojson, type: open}}\n"
        f"resolution: 5 m\ntime: {{end: 600 s}}\noutputs: {{gauges: gauges.csv, gauges_every: 10 s, write: [tables]}}\n"
    )
    return beds


def steady_depths(program, folder, beds, spacing):
    """Mean level (m) at each gauge over the bottom, in the steady state."""
    out = folder / f"{spacing}m"
    keys = ["--set", f"resolution={spacing} m", "--set", f"time.end={END[spacing]} s"]
    command = [program, "run", folder / "scenario.yaml", "--out", out, "--overwrite", "--quiet", "--threads", "1", *keys]
    with (folder / f"{spacing}m.log").open("w") as log:
        subprocess.run(command, check=True, stdout=log, stderr=log)
    levels = {}
    with (out / "tables" / "gauge_series.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            if float(row["time_s"]) >= END[spacing] - AVERAGED:
                levels.setdefault(row["id"], []).append(float(row["level_m"]))
    return {name: sum(values) / len(values) - beds[name] for name, values in levels.items()}


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    arguments = parser.parse_args()
    program, folder = arguments.program.resolve(), arguments.folder.resolve()
    places = [f"{angle}°" + (f", {shift} m beside" if shift else "") for angle, shift in PLACES]
    print(f"| cells of {', '.join(map(str, SPACINGS))} m | depth taken as 1 | " + " | ".join(places) + " |")
    print("| --- " * (2 + len(PLACES)) + "|")
    for name, half_bottom, rise in SECTIONS:
        found = []
        for angle, shift in PLACES:
            case = folder / f"{name}, {angle}, {shift}"
            beds = write_scenario(case, Axis(STRAIGHT, angle, shift), half_bottom, rise)
            found.append([mean(steady_depths(program, case, beds, spacing).values()) for spacing in SPACINGS])
        one = found[0][0]
        print(f"| {name} | {one:.2f} m | " + " | ".join(" ".join(f"{depth / one:.2f}" for depth in depths) for depths in found) + " |", flush=True)
    print("\n| bends of 54° and 42° | " + " | ".join(f"{s} m" for s in SPACINGS[1:]) + " |")
    print("| --- " * len(SPACINGS) + "|")
    for name, half_bottom, rise in SECTIONS[:2]:
        case = folder / f"{name}, bends"
        beds = write_scenario(case, Axis(BENDS, 0), half_bottom, rise)
        measure, *others = (steady_depths(program, case, beds, spacing) for spacing in SPACINGS)
        errors = [[depths[gauge] - measure[gauge] for gauge in beds] for depths in others]
        print(f"| {name} | " + " | ".join(f"{mean(e):+.2f} ({mean(map(abs, e)):.2f}) m" for e in errors) + " |", flush=True)


if __name__ == "__main__":
    main()
