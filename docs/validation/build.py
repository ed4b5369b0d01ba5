"""The page of results, docs/validation/README.md, from the tables of `floodsim chart`.

    python3 docs/validation/build.py            # the page, from the tables that lie beside it
    python3 docs/validation/build.py --run      # everything anew: cases, tables, figures, page

Run it in the folder of the repository after `cargo build --release`. Terrain for `lake_terrain` is found through FLOODSIM_DATA. Only the
standard library is needed. No number stands in this file that is not a bar or another author's: all others come from the tables.
"""

import argparse
import csv
import pathlib
import subprocess

HERE = pathlib.Path("docs/validation")
PROGRAM = "target/release/floodsim"
# Cases that run in seconds with every method.
QUICK = (
    "ritter stoker stoker_strong wu_dry wu_wet_30s wu_wet_50s dressler spreading_cylinder thacker_planar thacker_axisymmetric "
    "lake_bump lake_island bump_subcritical macdonald normal_depth"
).split()
RUNS = {
    "analytic": ["--suite", "analytic", "--vary", "motion=eulerian,lagrangian"],
    "methods": QUICK
    + "--resolutions test --vary formulation=balanced,variational --vary stabilisation=riemann,artificial_viscosity".split()
    + "--vary integrator=heun,leapfrog".split(),
}
FIGURES = ["ritter_depth", "stoker_depth", "stoker_strong_depth", "circular_dam_depth", "thacker_axisymmetric_depth", "bump_subcritical_depth"]
# Of Wu2020: mean absolute errors of depth (m) and velocity (m/s), two-shocks solver, spacing 10 m.
WU = {"wu_dry": ("0.0356", "0.0351"), "wu_wet_50s": ("0.0613", "0.0603")}

USE = {
    "balanced, eulerian, riemann, heun": (
        "terrain, floods, long runs: a lake stays at rest on any bed, pockets included, bores converge, and an evaluation costs least",
        "oscillating or spreading water whose shore wanders over the lattice: the film at the shore takes the energy out and sets the step",
    ),
    "balanced, lagrangian, riemann, leapfrog": (
        "oscillations and spreading water without many pockets: most accurate there for its number of particles",
        "terrain with many pockets (water sloshes), and bores over thin water (the error does not fall with the spacing)",
    ),
    "balanced, lagrangian, riemann, heun": (
        "bores, where it is a little more accurate than leapfrog for the same particles",
        "long oscillations: the error in time grows; each step costs two evaluations",
    ),
    "variational, lagrangian, artificial_viscosity, leapfrog": (
        "comparison with the classic form on level beds; robust there",
        "anything over an uneven bed: a still lake moves",
    ),
    "variational, lagrangian, artificial_viscosity, heun": ("as with leapfrog, at twice the cost", "as with leapfrog"),
    "variational, lagrangian, riemann, leapfrog": (
        "comparison; less noise behind bores on level beds than with artificial viscosity is not seen in these errors",
        "anything over an uneven bed, and dam breaks: larger errors than with artificial viscosity",
    ),
    "variational, lagrangian, riemann, heun": ("as with leapfrog, at twice the cost", "as with leapfrog"),
}

WHY = {
    "ritter": "The first cells or particles of the front are late: the reconstruction is of first order next to dry ground, and a particle of "
    "moving water stands for as much water as the whole tip of the exact front.",
    "stoker": "The error is that of the bore, smeared over two or three spacings, and of the corners of the rarefaction; the limiter decides "
    "how much.",
    "stoker_strong": "Moving particles of thin water pile up before the deep ones at the contact and change order; known, no cure yet. "
    "Resting particles converge.",
    "circular_dam": "As for stoker, in the plane.",
    "lake_island_disordered": "Particles that far off their lattice leave gaps of more than two spacings before the shore, into which water "
    "slumps.",
    "lake_pockets": "For show: puddles of one or two moving particles have no neighbours to balance them and slosh without friction.",
    "lake_pockets_disordered": "As for lake_pockets.",
    "lake_valley": "As for lake_pockets: a terrain is full of pockets.",
    "lake_terrain": "As for lake_pockets: a terrain is full of pockets.",
    "thacker_planar": "Resting particles: the shore crosses the lattice, and each cell that falls dry or wet takes energy out of the "
    "oscillation (see the note). Moving particles carry the shore with them.",
    "thacker_axisymmetric": "Moving particles: the error is that of the shore, where neighbours are missing on one side. Resting particles: "
    "as for thacker_planar.",
    "bump_subcritical": "Moving particles: the bed under a particle changes as it moves, and the error of the time step is added.",
}


def run(name, arguments):
    subprocess.run([PROGRAM, "chart", *arguments, "--out", str(HERE / name)], check=True)


def rows(name):
    with open(HERE / name / "chart.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def cases():
    """Name, sentence, and whether it was used to choose constants, in order."""
    found = {}
    lines = (HERE / "cases.txt").read_text(encoding="utf-8").splitlines()
    for name, about in zip(lines, lines[1:]):
        if name and not name.startswith(" "):
            mark = " Not used to choose constants."
            found[name] = (about.strip().removesuffix(mark), mark not in about)
    return found


def number(text):
    if not text:
        return "–"
    value = float(text)
    if value == 0 or 1e-3 <= abs(value) < 1e4:
        return f"{value:.3g}"
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def order(text):
    return f"{float(text):.2f}" if text else "–"


def method(row):
    return ", ".join(row[key] for key in ("formulation", "motion", "flux", "integrator"))


def table(heading, lines):
    yield "| " + " | ".join(heading) + " |"
    yield "|" + " --- |" * len(heading)
    for line in lines:
        yield "| " + " | ".join(text.replace("|", "\\|") for text in line) + " |"
    yield ""


def of_case(all_rows, shown_method):
    heading = [shown_method, "spacing m", "particles", "CPU s", "depth m", "order", "velocity m/s", "order", "max m/s", "status", "bar; note"]
    lines = []
    for row in all_rows:
        rest = "; ".join(text for text in (row["bar"], row["note"]) if text)
        lines.append(
            [
                row["motion"] if shown_method == "motion" else method(row),
                row["spacing_m"],
                row["particles"],
                number(row["cpu_s"]),
                number(row["error_depth"]),
                order(row["order_depth"]),
                number(row["error_velocity"]),
                order(row["order_velocity"]),
                number(row["max_speed_m_s"]),
                row["status"],
                rest,
            ]
        )
    return table(heading, lines)


def summary(analytic, known):
    lines = []
    for case, (_, is_tuned) in known.items():
        here = [row for row in analytic if row["case"] == case]
        line = [f"[{case}](#{case})" + ("" if is_tuned else " *")]
        for motion in ("eulerian", "lagrangian"):
            of_motion = [row for row in here if row["motion"] == motion]
            if not of_motion:
                line += ["not run", "–", "–"]
                continue
            finest, held = of_motion[-1], [row["status"] for row in of_motion if row["bar"]]
            worst = next((status for status in ("fails", "fall-short", "pass") if status in held), "no bar")
            if any(row["status"] == "fails" for row in of_motion):
                worst = "fails"
            line += [worst, f"{number(finest['error_depth'])} / {number(finest['error_velocity'])}", number(finest["cpu_s"])]
        lines.append(line)
    heading = ["case", "eulerian", "error m, m/s", "CPU s", "lagrangian", "error m, m/s", "CPU s"]
    return table(heading, lines)


def page():
    known, analytic, methods = cases(), rows("analytic"), rows("methods")
    total = sum(float(row["cpu_s"]) for row in analytic)
    out = [
        "# Results on problems with known answers",
        "",
        "Made by `python3 docs/validation/build.py` from the tables [analytic/chart.csv](analytic/chart.csv) and [methods/chart.csv](methods/chart.csv); with `--run` that command",
        f"makes the tables and figures again, too (the runs of the first table took {total:.0f} CPU seconds on one thread of a machine shared with other work: CPU seconds scatter by a fifth and more).",
        "One case alone: `floodsim validate CASE --resolutions full`. The cases are described by `floodsim validate --list`, their set-ups are in `src/validation/cases/`.",
        "",
        "Errors are mean absolute errors, over the particles where they move, over wet cells where they rest. The order is that from the next coarser spacing. *Status*: `pass` and",
        "`fall-short` tell whether the bar of that row is met, `holds` that a run without a bar came to its end, `fails` that it broke down. Cases with a star were not used to choose",
        "constants of the methods. A bar of the better motion is marked as such, and one that is only for show.",
        "",
        "## Overview: finest spacing, default methods of both motions",
        "",
        "The status is the worst over all spacings that have a bar.",
        "",
        *summary(analytic, known),
        "## What fell short, and why as far as it is known",
        "",
    ]
    for case in known:
        short = sorted({row["motion"] for row in analytic if row["case"] == case and row["status"] in ("fall-short", "fails")})
        if short:
            out.append(f"- **{case}** ({', '.join(short)}). {WHY.get(case, 'Not known yet.')}")
    out += ["", "## Beside the tables of Wu et al. (2020)", ""]
    lines = [[case, "Wu et al., two shocks", "10", *WU[case]] for case in WU]
    lines += [
        [row["case"], method(row), row["spacing_m"], number(row["error_depth"]), number(row["error_velocity"])]
        for row in methods
        if row["case"].startswith("wu_")
    ]
    lines.sort(key=lambda line: (line[0], not line[1].startswith("Wu")))
    out += table(["case", "method", "spacing m", "depth m", "velocity m/s"], lines)
    out += ["## Methods: where to use them and where not", ""]
    used = dict.fromkeys(method(row) for row in methods)
    lines = [[name, *USE.get(name, ("no judgement yet", "no judgement yet"))] for name in used]
    out += table(["method", "use it for", "not for"], lines)
    out += ["## Speed against accuracy", ""]
    for figure in FIGURES:
        for folder in ("methods", "analytic"):
            if (HERE / folder / f"{figure}.svg").is_file():
                out += [f"![{figure.replace('_', ' ')}]({folder}/{figure}.svg)", ""]
                break
    out += ["The other figures are in [analytic](analytic) and [methods](methods).", "", "## Case by case", ""]
    for case, (about, is_tuned) in known.items():
        out += [f"### {case}", "", about + ("" if is_tuned else " Not used to choose constants."), ""]
        out += of_case([row for row in analytic if row["case"] == case], "motion")
        others = [row for row in methods if row["case"] == case]
        if others:
            out += ["With other methods, at test resolution:", ""]
            out += of_case(others, "method")
    (HERE / "README.md").write_text("\n".join(out).rstrip() + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", action="store_true", help="run the cases and draw the figures first")
    if parser.parse_args().run:
        for name, arguments in RUNS.items():
            run(name, arguments)
        listed = subprocess.run([PROGRAM, "validate", "--list"], check=True, capture_output=True, text=True)
        (HERE / "cases.txt").write_text(listed.stdout, encoding="utf-8")
    page()


if __name__ == "__main__":
    main()
