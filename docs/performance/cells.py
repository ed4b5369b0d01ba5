"""Uniform, nested and chosen cells side by side: the table cells.csv and the figure ../figures/cells.svg.

    python3 docs/performance/cells.py                # the figure, from the table
    python3 docs/performance/cells.py --run          # all runs anew, and the figure (three quarters of an hour on one core)
    python3 docs/performance/cells.py --run breach   # those of some cases

Run it in the folder of the repository after `cargo build --release`; cases of laboratories, Malpasset and Big Tujunga need the data behind
FLOODSIM_DATA. Needs numpy and netCDF4, and for the long valley scipy and rasterio. `--program` names another build.

The reference of a case is its run on the finest uniform lattice. Every other run is compared with it at the centres of its cells: the
maximum depth is the greatest level less the ground of the reference. The askew channel has its exact depth as reference, in the middle of
the channel.
"""

import argparse
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path("docs/performance")
TABLE, FIGURE = HERE / "cells.csv", pathlib.Path("docs/figures/cells.svg")
# Scenario (a folder below scenarios/, or a script that makes one), the finest uniform lattice, factors of coarser ones, nested cells (factors of
# the finest and the coarsest), depth (m) from which a place counts as flooded.
CASES = {
    "Malpasset": ("malpasset/scenario", "20 m", (2, 4), ((1, 8), (2, 8)), 0.3),
    "Big Tujunga": ("laboratory/big_tujunga", "10 m", (2, 4), ((1, 8), (2, 8)), 0.3),
    "long valley": ("long_valley.py", "5 m", (2, 4), ((1, 8), (2, 16)), 0.3),
    "demonstration": ("demo/scenario", "10 m", (2, 4), ((1, 8), (2, 8)), 0.1),
    "breach": ("breach/scenario", "10 m", (2, 4), ((1, 8), (2, 8)), 0.1),
    "river flood": ("river_flood/scenario", "5 m", (2, 4), ((1, 8), (2, 8)), 0.05),
    "Merewether": ("laboratory/merewether", "1 m", (2, 4), ((1, 8), (2, 8)), 0.05),
    "radial dam break": ("laboratory/radial_dam_break", "1 m", (2, 4), ((1, 4), (2, 4)), 0.01),
    "Monai": ("laboratory/monai_valley", "28 mm", (2, 4), ((1, 4), (2, 4)), 0.001),
}
# A channel at 30 degrees to the lattice, width and depth of its cut, slope, Manning's n and discharge (m, m3/s), whose depth is known; squares and
# cells that follow its banks, so many across. Pixels are as wide as the cells.
ASKEW = "askew channel"
CHANNEL = {"degrees": 30.0, "width": 50.0, "cut": 6.0, "slope": 0.002, "n": 0.03, "discharge": 150.0}
ACROSS = (("uniform", 5), ("uniform", 10), ("uniform", 20), ("following", 3), ("following", 5), ("following", 10))
ORDER = [*CASES, ASKEW]
COLUMNS = "case,cells,finest,coarsest,cpu_s,particle_evaluations,depth_error_m,mean_depth_m,extent_in_common,git".split(",")
COLOURS = {"uniform": "#0072b2", "nested": "#d55e00", "auto": "#009e73", "following": "#cc79a7"}


def length(text):
    value, unit = text.split()
    return float(value) * {"m": 1.0, "cm": 0.01, "mm": 0.001}[unit]


def times(text, factor):
    value, unit = text.split()
    return f"{float(value) * factor:g} {unit}"


def run(program, scenario, options, folder):
    command = [program, "run", str(scenario), "--threads", "1", "--out", str(folder), "--overwrite", "--quiet"]
    for option in (*options, "outputs.write=[maps,tables]", "outputs.gauges=null"):
        command += ["--set", option]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(" ".join(command), f"ended with exit code {done.returncode}", done.stderr, sep="\n")
    if done.returncode not in (0, 7):
        return None
    return json.loads((folder / "run.json").read_text(encoding="utf-8"))


def read(folder):
    import netCDF4
    import numpy

    file = netCDF4.Dataset(folder / "maps.nc")
    grids = {name: numpy.ma.filled(file[name][:].astype(float), numpy.nan) for name in ("bed_elevation", "max_depth", "max_water_level")}
    return numpy.array(file["x"][:]), numpy.array(file["y"][:]), grids


def compare(reference, other, flooded):
    import numpy

    (x, y, fine), (u, v, coarse) = reference, other
    column = numpy.clip(numpy.searchsorted(0.5 * (u[1:] + u[:-1]), x), 0, len(u) - 1)
    row = numpy.clip(numpy.searchsorted(-0.5 * (v[1:] + v[:-1]), -y), 0, len(v) - 1)
    level = coarse["max_water_level"][row[:, None], column[None, :]]
    depth = numpy.nan_to_num(numpy.maximum(level - fine["bed_elevation"], 0.0))
    own = numpy.nan_to_num(fine["max_depth"])
    either, both = (own >= flooded) | (depth >= flooded), (own >= flooded) & (depth >= flooded)
    error = numpy.abs(own - depth)[either].mean()
    return error, own[own >= flooded].mean(), both.sum() / either.sum()


def row_of(case, cells, widths, record, errors):
    """A row of the table; `errors` are the mean difference of the depth (m), the mean depth (m) and the share of the extent in common."""
    error, mean, extent = errors
    values = [case, cells, *widths, f"{record['cpu_s']:.1f}", record["particle_evaluations"], f"{error:.4g}", f"{mean:.4g}", f"{extent:.3f}", record["git"]]
    print(*values, flush=True)
    return dict(zip(COLUMNS, map(str, values)))


def scenario_of(name, scratch):
    if not name.endswith(".py"):
        return pathlib.Path(f"scenarios/{name}.yaml")
    made = scratch / name.removesuffix(".py")
    subprocess.run([sys.executable, str(HERE / name), str(made)], check=True)
    return made / "scenario.yaml"


def measure(case, program, scratch):
    if case == ASKEW:
        return measure_channel(program, scratch)
    name, finest, factors, nested, flooded = CASES[case]
    scenario = scenario_of(name, scratch)
    wanted = [("uniform", finest, finest, finest)]
    wanted += [("uniform", times(finest, f), times(finest, f), times(finest, f)) for f in factors]
    for low, high in nested:
        low, high = times(finest, low), times(finest, high)
        wanted.append(("nested", low, high, f"{{finest: {low}, coarsest: {high}}}"))
    wanted.append(("auto", "", "", "auto"))
    reference, table = None, []
    for number, (cells, low, high, resolution) in enumerate(wanted):
        folder = scratch / f"{case.replace(' ', '_')}_{number}"
        record = run(program, scenario, [f"resolution={resolution}"], folder)
        if record is None:
            continue
        maps = read(folder)
        if cells == "auto":
            chosen = record["resolution"]
            low, high = f"{chosen['finest_m']:g} m", f"{chosen['coarsest_m']:g} m"
        reference = reference or maps
        table.append(row_of(case, cells, (low, high), record, compare(reference, maps, flooded)))
    return table


def channel_place(along, left):
    """The place so far along the channel and to the left of its middle (m)."""
    angle = math.radians(CHANNEL["degrees"])
    return 150.0 + along * math.cos(angle) - left * math.sin(angle), 200.0 + along * math.sin(angle) + left * math.cos(angle)


def make_channel(folder, cell):
    """The channel in a square of 1 km: its terrain on pixels as wide as the cells, and its scenario."""
    import numpy

    folder.mkdir(parents=True, exist_ok=True)
    side = round(1000.0 / cell)
    x, y = numpy.meshgrid((numpy.arange(side) + 0.5) * cell - 150.0, (side - numpy.arange(side) - 0.5) * cell - 200.0)
    angle, half = math.radians(CHANNEL["degrees"]), 0.5 * CHANNEL["width"]
    along, left = x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)
    ground = 20.0 - CHANNEL["slope"] * along - numpy.where((numpy.abs(left) < half) & (along > -40.0), CHANNEL["cut"], 0.0)
    header = f"ncols {side}\nnrows {side}\nxllcorner 0\nyllcorner 0\ncellsize {cell}"
    numpy.savetxt(folder / "terrain.asc", ground, fmt="%.4f", header=header, comments="")
    ends = [list(channel_place(0.0, end)) for end in (10.0 - half, half - 10.0)]
    line = {"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": ends}}
    (folder / "inflow.geojson").write_text(json.dumps(line), encoding="utf-8")
    text = f"""\
floodsim: 1
crs: local
terrain: {{layers: [{{raster: terrain.asc}}]}}
roughness: {{manning: {CHANNEL['n']}}}
sources: [{{line: inflow.geojson, discharge: {CHANNEL['discharge']} m3/s}}]
boundaries: [{{side: all, type: open}}]
resolution: {cell} m
time: {{end: 25 min}}
outputs: {{every: 25 min}}
"""
    (folder / "scenario.yaml").write_text(text, encoding="utf-8")
    return folder / "scenario.yaml"


def normal_depth():
    """Of a wide channel after Manning (m): banks have no friction."""
    per_metre = CHANNEL["discharge"] / CHANNEL["width"]
    return (per_metre * CHANNEL["n"] / math.sqrt(CHANNEL["slope"])) ** 0.6


def channel_errors(maps):
    """Against the normal depth over 200 m of the channel and the middle two fifths of its width."""
    import numpy

    x, y, grids = maps
    along, left = numpy.meshgrid(numpy.arange(300.0, 500.0, 5.0), numpy.linspace(-0.2, 0.2, 9) * CHANNEL["width"])
    places = channel_place(along, left)
    column = numpy.abs(x[None, :] - places[0].reshape(-1, 1)).argmin(axis=1)
    row = numpy.abs(y[None, :] - places[1].reshape(-1, 1)).argmin(axis=1)
    depth, exact = numpy.nan_to_num(grids["max_depth"][row, column]), normal_depth()
    return numpy.abs(depth - exact).mean(), exact, (depth > 0.5 * exact).mean()


def measure_channel(program, scratch):
    table = []
    for cells, across in ACROSS:
        cell = CHANNEL["width"] / across
        scenario = make_channel(scratch / f"channel_{across}", cell)
        folder = scratch / f"channel_{cells}_{across}"
        record = run(program, scenario, [] if cells == "following" else ["terrain.follow_banks=false"], folder)
        if record is not None:
            width = f"{cell:.3g} m"
            table.append(row_of(ASKEW, cells, (width, width), record, channel_errors(read(folder))))
    return table


def ticks(low, high):
    """1, 2 and 5 times powers of ten between two logarithms."""
    steps = [factor * 10.0**power for power in range(-4, 5) for factor in (1, 2, 5)]
    return [step for step in steps if low <= math.log10(step) <= high]


def label(row):
    if row["case"] == ASKEW:
        return f"{CHANNEL['width'] / length(row['finest']):.0f} across"
    (low, unit), (high, _) = row["finest"].split(), row["coarsest"].split()
    low, high = f"{float(low):.3g}", f"{float(high):.3g}"
    return f"{low} {unit}" if low == high else f"{low}–{high} {unit}"


def field(own, left, top, width, height):
    """One case: error over the mean depth against CPU seconds, both logarithmic. The first row is the reference, but for the askew channel."""
    case = own[0]["case"]
    shown = own if case == ASKEW else own[1:]
    shown = [row for row in shown if float(row["depth_error_m"]) > 0.0]
    x_log = [math.log10(max(float(row["cpu_s"]), 0.05)) for row in own]
    y_log = [math.log10(float(row["depth_error_m"]) / float(row["mean_depth_m"])) for row in shown]
    x_low, x_high = min(x_log) - 0.15, max(x_log) + 0.15
    y_low, y_high = min(y_log) - 0.25, max(y_log) + 0.25
    across = lambda x: left + width * (x - x_low) / (x_high - x_low)
    up = lambda y: top + height * (y_high - y) / (y_high - y_low)
    out = [f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#888"/><text x="{left}" y="{top - 6}" font-weight="bold">{case}</text>']
    if case != ASKEW:
        x = across(x_log[0])
        out.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{top}" y2="{top + height}" stroke="{COLOURS["uniform"]}" stroke-dasharray="4 3"/>')
        out.append(f'<text x="{min(x, left + width - 30):.1f}" y="{top + height + 26}" text-anchor="middle" fill="{COLOURS["uniform"]}">reference {own[0]["finest"]}</text>')
    # Every third one where they would touch.
    x_ticks = ticks(x_low, x_high)
    for tick in x_ticks if len(x_ticks) < 8 else [tick for tick in x_ticks if f"{tick:e}"[0] == "1"]:
        out.append(f'<text x="{across(math.log10(tick)):.1f}" y="{top + height + 14}" text-anchor="middle">{tick:g}</text>')
    for tick in ticks(y_low, y_high):
        out.append(f'<text x="{left - 4}" y="{up(math.log10(tick)) + 4:.1f}" text-anchor="end">{100 * tick:g} %</text>')
    points = [(across(math.log10(max(float(row["cpu_s"]), 0.05))), up(y)) for row, y in zip(shown, y_log)]
    for row, (x, y) in zip(shown, points):
        out.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{COLOURS[row["cells"]]}"/>')
    # Labels keep clear of points and of what stands around the field.
    taken = [(x - 5, y - 5, x + 5, y + 5) for x, y in points]
    taken += [(left - 60, top, left, top + height), (left, top - 20, left + width, top), (left + width, top, left + width + 60, top + height)]
    for row, (x, y) in zip(shown, points):
        text = label(row)
        x, y = free_place(x, y, 5.2 * len(text), taken)
        out.append(f'<text x="{x:.1f}" y="{y:.1f}" font-size="9">{text}</text>')
    return out


def free_place(x, y, wide, taken):
    """Left end of the base line of a label beside a point: the first of some places that overlaps least; it is taken from then on."""
    places = [(x - 0.5 * wide, y - 8), (x - 0.5 * wide, y + 15), (x + 7, y + 3), (x - 7 - wide, y + 3), (x - wide, y - 8), (x - wide, y + 15), (x - 0.5 * wide, y - 18), (x - 0.5 * wide, y + 25)]
    box = lambda place: (place[0], place[1] - 8, place[0] + wide, place[1] + 2)

    def overlap(place):
        own = box(place)
        sides = [(min(own[2], other[2]) - max(own[0], other[0]), min(own[3], other[3]) - max(own[1], other[1])) for other in taken]
        return sum(a * b for a, b in sides if a > 0.0 and b > 0.0)

    best = min(places, key=overlap)
    taken.append(box(best))
    return best


def figure(table):
    cases = list(dict.fromkeys(row["case"] for row in table))
    wide, high, columns = 250, 190, 3
    rows = math.ceil(len(cases) / columns)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{columns * wide + 20}" height="{rows * high + 65}" font-family="sans-serif" font-size="11">', '<rect width="100%" height="100%" fill="white"/>']
    for k, (cells, colour) in enumerate(COLOURS.items()):
        out.append(f'<circle cx="{30 + 150 * k}" cy="16" r="5" fill="{colour}"/><text x="{40 + 150 * k}" y="20">{cells}</text>')
    for k, case in enumerate(cases):
        own = [row for row in table if row["case"] == case]
        out += field(own, 50 + k % columns * wide, 50 + k // columns * high, wide - 70, high - 70)
    below = ["across: CPU seconds; up: mean difference of the maximum depth from the reference, over its mean", "(askew channel: of the depth from the exact one; so many cells across)"]
    out += [f'<text x="50" y="{rows * high + 42 + 15 * k}">{text}</text>' for k, text in enumerate(below)]
    out.append("</svg>")
    FIGURE.write_text("\n".join(out) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--run", nargs="*", choices=ORDER)
    parser.add_argument("--program", default="target/release/floodsim")
    parser.add_argument("--scratch", help="folder in which the runs are kept")
    arguments = parser.parse_args()
    table = []
    if TABLE.exists():
        with TABLE.open(encoding="utf-8") as file:
            table = list(csv.DictReader(file))
    if arguments.run is not None:
        with tempfile.TemporaryDirectory() as scratch:
            for case in arguments.run or ORDER:
                measured = measure(case, arguments.program, pathlib.Path(arguments.scratch or scratch))
                table = [row for row in table if row["case"] != case] + measured
                table.sort(key=lambda row: ORDER.index(row["case"]))
                with TABLE.open("w", newline="", encoding="utf-8") as file:
                    writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                    writer.writeheader()
                    writer.writerows(table)
    figure(table)


if __name__ == "__main__":
    main()
