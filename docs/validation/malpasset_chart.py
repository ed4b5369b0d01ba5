"""Arrival error against CPU seconds at Malpasset: the table malpasset.csv and the figure ../figures/malpasset_chart.svg.

    python3 docs/validation/malpasset_chart.py                      # the figure, from the table
    python3 docs/validation/malpasset_chart.py RUN... OBSERVATIONS  # takes these run folders into the table first

RUN is a run folder of scenarios/malpasset; a row of the table with its motion, reconstruction and spacing is replaced. OBSERVATIONS is the
file gauges.csv of the case. All runs of the table:

    for s in 40 30 20 10; do for m in numerics.motion=eulerian numerics.reconstruction=sharp; do
      floodsim run scenarios/malpasset/scenario.yaml --threads 1 --set "resolution=$s m" --set $m --out runs/$s-$m
    done; done

Only the standard library is needed.
"""

import csv
import json
import math
import pathlib
import sys

from malpasset_table import arrivals, levels, mean_absolute, rows

HERE = pathlib.Path(__file__).parent
TABLE, FIGURE = HERE / "malpasset.csv", HERE.parent / "figures" / "malpasset_chart.svg"
COLUMNS = (
    "motion,reconstruction,spacing_m,cpu_s,steps,particle_evaluations,arrival_error_s,arrival_a_s,arrival_b_s,arrival_c_s,level_error_model_m,level_error_police_m,simd,git"
).split(",")
# Codes measured on the same case (peers.csv tells how): mean absolute error of the arrival (s), CPU seconds.
PEERS = {"GeoClaw 40 m": (39.7, 28.1), "ANUGA": (55.2, 682.3), "LISFLOOD-FP FV1 40 m": (150.3, 31.6), "SFINCS 40 m, tuned": (74.3, 5.3), "SFINCS 20 m, tuned": (69.0, 32.0)}
LINES = {
    ("eulerian", "limited"): ("limited reconstruction (default)", "#0072b2", ""),
    ("eulerian", "sharp"): ("sharp reconstruction", "#d55e00", "7 3"),
}
# Left, top, width, height of the field; decades and bounds of the axes; bars of the project: error (s), CPU seconds.
FIELD, X, Y = (80, 60, 560, 400), (4.0, 10_000.0), (20.0, 200.0)
BARS = ((40, 20), (30, None))


def scores(run, observations):
    observed, computed = rows(observations), rows(run / "tables" / "gauges.csv")
    record = json.loads((run / "run.json").read_text(encoding="utf-8"))
    settings = (run / "scenario.resolved.yaml").read_text(encoding="utf-8").splitlines()
    spacing = next(line for line in settings if line.startswith("resolution:")).split()[1]
    arrival, level = arrivals(observed, computed)[1], levels(observed, computed)[1]
    model = mean_absolute(arrival["physical_model"].values())
    mean_level = {kind: mean_absolute(errors.values()) for kind, errors in level.items()}
    at = [float(computed[place]["arrival_s"]) for place in "ABC"]
    values = [record["methods"]["motion"], record["methods"]["reconstruction"], spacing, f"{record['cpu_s']:.1f}", record["steps"], record["particle_evaluations"], f"{model:.1f}"]
    values += [f"{time:.1f}" for time in at] + [f"{mean_level[kind]:.2f}" for kind in ("physical_model", "police_survey")]
    return dict(zip(COLUMNS, map(str, values + [record["simd"], record["git"]])))


def key(row):
    return row["motion"], row["reconstruction"], float(row["spacing_m"])


def write(table):
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(table, key=lambda row: (key(row)[:2], -key(row)[2])))


def place(cost, error):
    left, top, width, height = FIELD
    share = lambda value, bounds: math.log(value / bounds[0]) / math.log(bounds[1] / bounds[0])
    return left + width * share(cost, X), top + height * (1 - share(error, Y))


def text(x, y, words, size=12, anchor="start", colour="#222222", turn=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" fill="{colour}" {turn}>{words}</text>'


def figure(table):
    left, top, width, height = FIELD
    right, bottom = left + width, top + height
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {right + 30} {bottom + 130}" font-family="sans-serif">', f'<rect width="{right + 30}" height="{bottom + 130}" fill="white"/>']
    out.append(text(left, 28, "Malpasset: error of the arrival against processor time", 16))
    out.append(text(left, 46, "Mean absolute error at the nine gauges of the scale model, 4000 s, n = 0.033, one thread", 12, colour="#555555"))
    for cost in (5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000):
        x = place(cost, Y[0])[0]
        out += [f'<path d="M{x:.1f} {top}V{bottom}" stroke="#dddddd"/>', text(x, bottom + 18, cost, anchor="middle")]
    for error in (20, 30, 40, 50, 60, 80, 100, 150, 200):
        y = place(X[0], error)[1]
        out += [f'<path d="M{left} {y:.1f}H{right}" stroke="#dddddd"/>', text(left - 8, y + 4, error, anchor="end")]
    out.append(text((left + right) / 2, bottom + 38, "CPU time (s)", anchor="middle"))
    out.append(text(24, (top + bottom) / 2, "mean absolute error of the arrival (s)", anchor="middle", turn=f'transform="rotate(-90 24 {(top + bottom) / 2})"'))
    for error, cost in BARS:
        (x, y), end = place(cost or X[1], error), place(X[0], error)[0]
        out.append(f'<path d="M{end:.1f} {y:.1f}H{x:.1f}{f"V{bottom}" if cost else ""}" stroke="#999999" stroke-dasharray="3 3" fill="none"/>')
    for name, (error, cost) in PEERS.items():
        x, y = place(cost, error)
        out += [f'<path d="M{x - 5:.1f} {y - 5:.1f}l10 10m-10 0l10 -10" stroke="#777777" stroke-width="1.6"/>', text(x + 9, y - 6, name, 11, colour="#666666")]
    for number, (method, (name, colour, dash)) in enumerate(LINES.items()):
        points = [(row["spacing_m"], *place(float(row["cpu_s"]), float(row["arrival_error_s"]))) for row in table if key(row)[:2] == method]
        way = " ".join(f"{x:.1f},{y:.1f}" for _, x, y in points)
        out.append(f'<polyline points="{way}" fill="none" stroke="{colour}" stroke-width="1.8" stroke-dasharray="{dash}"/>')
        for spacing, x, y in points:
            out += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{colour}" stroke="white"/>', text(x, y + 19, f"{spacing} m", 11, "middle", colour)]
        y = bottom + 66 + 18 * number
        out += [f'<path d="M{left} {y}h34" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>', text(left + 44, y + 4, name)]
    out.append(text(right, bottom + 70, "× other codes; dashed: the bars of the project", 12, "end", "#666666"))
    return "\n".join([*out, "</svg>\n"])


def main(words):
    table = list(csv.DictReader(TABLE.open(encoding="utf-8"))) if TABLE.exists() else []
    if words:
        *runs, observations = map(pathlib.Path, words)
        for row in (scores(run, observations) for run in runs):
            table = [other for other in table if key(other) != key(row)] + [row]
        write(table)
    FIGURE.write_text(figure(sorted(table, key=lambda row: -key(row)[2])), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
