"""Uniform, nested and chosen cells side by side: the table cells.csv and the figure ../figures/cells.svg.

    python3 docs/performance/cells.py                # the figure, from the table
    python3 docs/performance/cells.py --run          # all runs anew, and the figure (half an hour on one core)
    python3 docs/performance/cells.py --run breach   # those of some cases

Run it in the folder of the repository after `cargo build --release`; cases of laboratories need the data behind FLOODSIM_DATA. Needs numpy and
netCDF4.

The reference of a case is its run on the finest uniform lattice. Every other run is compared with it at the centres of its cells: the
maximum depth is the greatest level less the ground of the reference.
"""

import argparse
import csv
import json
import math
import pathlib
import subprocess
import tempfile

HERE = pathlib.Path("docs/performance")
TABLE, FIGURE = HERE / "cells.csv", pathlib.Path("docs/figures/cells.svg")
PROGRAM = "target/release/floodsim"
# Scenario, the finest uniform lattice, factors of coarser ones, nested cells (factors of the finest and the coarsest), depth (m) from which a
# place counts as flooded.
CASES = {
    "Malpasset": ("malpasset/scenario", "20 m", (2, 4), ((1, 8), (2, 8)), 0.3),
    "demonstration": ("demo/scenario", "10 m", (2, 4), ((1, 8), (2, 8)), 0.1),
    "breach": ("breach/scenario", "10 m", (2, 4), ((1, 8), (2, 8)), 0.1),
    "river flood": ("river_flood/scenario", "5 m", (2, 4), ((1, 8), (2, 8)), 0.05),
    "Merewether": ("laboratory/merewether", "2 m", (2, 4), ((1, 4), (2, 4)), 0.05),
    "radial dam break": ("laboratory/radial_dam_break", "1 m", (2, 4), ((1, 4), (2, 4)), 0.01),
    "Monai": ("laboratory/monai_valley", "28 mm", (2, 4), ((1, 4), (2, 4)), 0.001),
}
COLUMNS = "case,cells,finest,coarsest,cpu_s,particle_evaluations,depth_error_m,mean_depth_m,extent_in_common,git".split(",")
COLOURS = {"uniform": "#0072b2", "nested": "#d55e00", "auto": "#009e73"}


def length(text):
    value, unit = text.split()
    return float(value) * {"m": 1.0, "cm": 0.01, "mm": 0.001}[unit]


def times(text, factor):
    value, unit = text.split()
    return f"{float(value) * factor:g} {unit}"


def run(scenario, resolution, folder):
    command = [PROGRAM, "run", f"scenarios/{scenario}.yaml", "--threads", "1", "--out", str(folder), "--quiet"]
    command += ["--set", f"resolution={resolution}", "--set", "outputs.write=[maps,tables]", "--set", "outputs.gauges=null"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 7):
        print(done.stderr)
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


def measure(case, scratch):
    scenario, finest, factors, nested, flooded = CASES[case]
    wanted = [("uniform", finest, finest, finest)]
    wanted += [("uniform", times(finest, f), times(finest, f), times(finest, f)) for f in factors]
    for low, high in nested:
        low, high = times(finest, low), times(finest, high)
        wanted.append(("nested", low, high, f"{{finest: {low}, coarsest: {high}}}"))
    wanted.append(("auto", "", "", "auto"))
    reference, table = None, []
    for number, (cells, low, high, resolution) in enumerate(wanted):
        folder = scratch / f"{case.replace(' ', '_')}_{number}"
        record = run(scenario, resolution, folder)
        if record is None:
            continue
        maps = read(folder)
        if cells == "auto":
            chosen = record["resolution"]
            low, high = f"{chosen['finest_m']:g} m", f"{chosen['coarsest_m']:g} m"
        reference = reference or maps
        error, mean, extent = compare(reference, maps, flooded)
        values = [case, cells, low, high, f"{record['cpu_s']:.1f}", record["particle_evaluations"], f"{error:.4g}", f"{mean:.4g}", f"{extent:.3f}", record["git"]]
        table.append(dict(zip(COLUMNS, map(str, values))))
        print(*values, flush=True)
    return table


def figure(table):
    """One field for each case: error over the mean depth against CPU seconds, both logarithmic."""
    cases = list(dict.fromkeys(row["case"] for row in table))
    wide, high, columns = 250, 190, 3
    rows = math.ceil(len(cases) / columns)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{columns * wide + 20}" height="{rows * high + 50}" font-family="sans-serif" font-size="11">', '<rect width="100%" height="100%" fill="white"/>']
    for k, (cells, colour) in enumerate(COLOURS.items()):
        out.append(f'<circle cx="{30 + 150 * k}" cy="16" r="5" fill="{colour}"/><text x="{40 + 150 * k}" y="20">{cells}</text>')
    for k, case in enumerate(cases):
        left, top = 50 + k % columns * wide, 50 + k // columns * high
        width, height = wide - 70, high - 70
        own = [row for row in table if row["case"] == case]
        best = float(own[0]["cpu_s"])
        shown = [row for row in own[1:] if float(row["depth_error_m"]) > 0.0]
        x_log = [math.log10(float(row["cpu_s"])) for row in own]
        y_log = [math.log10(float(row["depth_error_m"]) / float(row["mean_depth_m"])) for row in shown]
        x_low, x_high = min(x_log) - 0.15, max(x_log) + 0.15
        y_low, y_high = min(y_log) - 0.25, max(y_log) + 0.25
        place = lambda x, y: (left + width * (x - x_low) / (x_high - x_low), top + height * (y_high - y) / (y_high - y_low))
        out.append(f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#888"/><text x="{left}" y="{top - 6}" font-weight="bold">{case}</text>')
        x, _ = place(math.log10(best), y_low)
        out.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{top}" y2="{top + height}" stroke="{COLOURS["uniform"]}" stroke-dasharray="4 3"/><text x="{x:.1f}" y="{top + height + 26}" text-anchor="middle" fill="{COLOURS["uniform"]}">reference</text>')
        for tick in (1, 2, 5, 10, 20, 50, 100, 200, 500):
            if x_low <= math.log10(tick) <= x_high:
                x, _ = place(math.log10(tick), y_low)
                out.append(f'<text x="{x:.1f}" y="{top + height + 14}" text-anchor="middle">{tick}</text>')
        for tick in (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5):
            if y_low <= math.log10(tick) <= y_high:
                _, y = place(x_low, math.log10(tick))
                out.append(f'<text x="{left - 4}" y="{y + 4:.1f}" text-anchor="end">{100 * tick:g} %</text>')
        for row, y_value in zip(shown, y_log):
            x, y = place(math.log10(float(row["cpu_s"])), y_value)
            name = row["finest"] if row["finest"] == row["coarsest"] else f"{row['finest'].split()[0]}–{row['coarsest']}"
            # Labels of nested cells stand below their points, so that they do not lie on others.
            y_text = y + {"uniform": -7, "nested": 14, "auto": 3}[row["cells"]]
            out.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{COLOURS[row["cells"]]}"/><text x="{x + (7 if row["cells"] == "auto" else -8):.1f}" y="{y_text:.1f}" font-size="9">{name}</text>')
    out.append(f'<text x="50" y="{rows * high + 42}">across: CPU seconds; up: mean difference of the maximum depth from the reference, over its mean</text></svg>')
    FIGURE.write_text("\n".join(out) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--run", nargs="*", choices=CASES)
    parser.add_argument("--scratch")
    arguments = parser.parse_args()
    table = []
    if TABLE.exists():
        with TABLE.open(encoding="utf-8") as file:
            table = list(csv.DictReader(file))
    if arguments.run is not None:
        with tempfile.TemporaryDirectory() as scratch:
            for case in arguments.run or CASES:
                measured = measure(case, pathlib.Path(arguments.scratch or scratch))
                table = [row for row in table if row["case"] != case] + measured
                table.sort(key=lambda row: list(CASES).index(row["case"]))
                with TABLE.open("w", newline="", encoding="utf-8") as file:
                    writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                    writer.writeheader()
                    writer.writerows(table)
    figure(table)


if __name__ == "__main__":
    main()
