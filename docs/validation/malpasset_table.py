"""The table of a run of Malpasset against the observations, as Markdown.

    python3 docs/validation/malpasset_table.py RUN OBSERVATIONS [--title TEXT]

RUN is a run folder (its tables/gauges.csv and run.json are read), OBSERVATIONS the file gauges.csv of the case with the columns
id, kind, observed_max_level_m and observed_arrival_s. Only the standard library is needed.

Police points are scored where the bed of the run lies below the mark; a place that stayed dry is scored at its bed level.
"""

import argparse
import csv
import json
import pathlib


def rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return {row["id"]: row for row in csv.DictReader(file)}


def number(row, key):
    text = row.get(key) or ""
    return float(text) if text else None


def shown(value, digits):
    return "–" if value is None else f"{value:.{digits}f}"


def mean_absolute(errors):
    errors = [abs(error) for error in errors if error is not None]
    return sum(errors) / len(errors) if errors else None


def level(run):
    """Greatest level (m); that of the bed where no water came."""
    depth = number(run, "max_depth_m") or 0.0
    return number(run, "max_level_m") if depth > 0.0 else number(run, "bed_m")


def arrivals(observed, computed):
    """Rows of the table of arrival, and the errors (s) by kind; None where the water never came."""
    lines, errors = [], {}
    for place, row in observed.items():
        expected = number(row, "observed_arrival_s")
        if expected is None:
            continue
        found = number(computed[place], "arrival_s")
        error = None if found is None else found - expected
        errors.setdefault(row["kind"], {})[place] = error
        share = "–" if error is None else f"{100 * error / expected:+.0f} %"
        lines.append(f"| {place} | {expected:.0f} | {shown(found, 0)} | {shown(error, 0)} | {share} |")
    return lines, errors


def levels(observed, computed):
    """Rows of the table of greatest levels, and the errors (m) of the scored places by kind."""
    lines, errors = [], {}
    for place, row in observed.items():
        expected, bed = number(row, "observed_max_level_m"), number(computed[place], "bed_m")
        if expected is None:
            continue
        error = level(computed[place]) - expected
        is_dry = not (number(computed[place], "max_depth_m") or 0.0) > 0.0
        is_scored = row["kind"] == "physical_model" or bed < expected
        if is_scored:
            errors.setdefault(row["kind"], {})[place] = error
        note = ", ".join(word for word, holds in [("dry", is_dry), ("bed above the mark: not scored", not is_scored)] if holds)
        lines.append(f"| {place} | {expected:.2f} | {bed:.2f} | {level(computed[place]):.2f} | {error:+.2f} | {note} |")
    return lines, errors


def cost(run):
    volume = run["volume_m3"]
    wanted = [
        ("status", run["status"]),
        ("simulated", f"{run['simulated_s']:.0f} s"),
        ("motion", run["methods"]["motion"]),
        ("particles at the start, at most, at the end", "{initial}, {peak}, {final}".format(**run["particles"])),
        ("steps", run["steps"]),
        ("particle evaluations", f"{run['particle_evaluations']:.4g}"),
        ("CPU time", f"{run['cpu_s']:.0f} s"),
        ("wall time, threads", f"{run['wall_s']:.0f} s, {run['threads']}"),
        ("peak memory", f"{run['peak_rss_mb']:.0f} MB"),
        ("greatest speed", f"{run['max_speed_m_s']:.1f} m/s"),
        ("volume error", f"{volume['error_relative']:.1e}"),
        ("volume error on the grid", f"{volume['grid_error_relative']:.1e}"),
    ]
    return [f"| {name} | {value} |" for name, value in wanted]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=pathlib.Path)
    parser.add_argument("observations", type=pathlib.Path)
    parser.add_argument("--title", default="Malpasset")
    arguments = parser.parse_args()
    observed, computed = rows(arguments.observations), rows(arguments.run / "tables" / "gauges.csv")
    run = json.loads((arguments.run / "run.json").read_text(encoding="utf-8"))
    arrival_lines, arrival_errors = arrivals(observed, computed)
    level_lines, level_errors = levels(observed, computed)
    print(f"## {arguments.title}\n")
    print("| score | value | places | never reached |\n| --- | --- | --- | --- |")
    for kind, errors in arrival_errors.items():
        missed = [place for place, error in errors.items() if error is None]
        mean = shown(mean_absolute(errors.values()), 0)
        print(f"| mean absolute error of arrival, {kind} | {mean} s | {len(errors) - len(missed)} | {' '.join(missed)} |")
    for kind, errors in level_errors.items():
        print(f"| mean absolute error of the greatest level, {kind} | {shown(mean_absolute(errors.values()), 2)} m | {len(errors)} | |")
    together = [error for errors in level_errors.values() for error in errors.values()]
    print(f"| mean absolute error of the greatest level, all | {shown(mean_absolute(together), 2)} m | {len(together)} | |")
    print("\n| cost | |\n| --- | --- |", *cost(run), sep="\n")
    print("\n| arrival | observed (s) | computed (s) | error (s) | relative |\n| --- | --- | --- | --- | --- |", *arrival_lines, sep="\n")
    print("\n| greatest level | observed (m) | bed (m) | computed (m) | error (m) | |\n| --- | --- | --- | --- | --- | --- |", *level_lines, sep="\n")


if __name__ == "__main__":
    main()
