"""The page docs/performance.md, from the tables beside this file.

    python3 docs/performance/build.py                     # the page, from the tables that lie here
    python3 docs/performance/build.py --run               # all tables anew (half an hour and more), and the page
    python3 docs/performance/build.py --run phases memory # some of them: phases, sizes, threads, memory, machine, instructions, parma, obstacle, plans, accuracy
    python3 docs/performance/build.py --run phases threads machine parma --machine avx2  # those of a processor without AVX-512, in the folder avx2

Run it in the folder of the repository. The tables are made by `cargo bench --bench measure`, by `scripts/instructions.sh` (valgrind) and by runs of
the program after `cargo build --release`; `memory`, `parma`, `obstacle` and `plans` need the data behind FLOODSIM_DATA, `accuracy` builds earlier programs from the history of the repository. The table `terrain` is made by `terrain.py`. Only the standard library is needed. No number stands in this
file that is not a target, another author's, or a count of what the code reads and writes.
"""

import argparse
import csv
import io
import json
import os
import pathlib
import subprocess
import tempfile

HERE = pathlib.Path("docs/performance")
# Another machine whose tables lie in a folder of that name.
OTHER = "avx2"
PAGE = pathlib.Path("docs/performance.md")
PROGRAM = "target/release/floodsim"
# Motions on the page. The measurements know cells that move as well; they are not charted yet.
MOTIONS = ("eulerian",)
NAMES = {"eulerian": "Eulerian"}
# The targets: evaluations a CPU second (millions), bytes a particle, efficiency of two threads, seconds of Parma and of the obstacle.
RATE_TARGET = {"eulerian": 8.0}
MEMORY_TARGET, EFFICIENCY_TARGET, PARMA_TARGET, OBSTACLE_TARGET = 400, 0.95, 60, 1800
MEMORY_SIZES = (200_000, 800_000)
# Spacings (mm) of the whole runs of Parma.
MEMORY_SPACINGS = (10, 5)
# 8-byte numbers that one evaluation of an Eulerian particle moves to and from memory when no array stays in a cache, as the passes are written:
# read and written by primitive.rs (once for two evaluations), gradient.rs, faces.rs and update.rs, in this order; what is written is read first.
RESTING_NUMBERS = ((1.5, 1.5), (4, 8), (14, 8), (18, 4.5))
# Operations on numbers in one evaluation, a comparison or a selection counted as one, by hand from the source to within a fifth: 300 for each of two
# faces, 110 for gradients, update and velocities.
OPERATIONS = {"eulerian": 710}
# Of Wu2020 (spacing mm: particles; serial original, one core, 20 threads; s), the partial dam break of Parma.
WU = {15: (4374, 1253, 312, 126), 10: (9801, 6932, 1130, 260), 5: (38801, 123239, 17182, 1679)}
WU_OBSTACLE = {10: 12423, 5: 51858, 2: 323145}
# Simulated seconds of the cases.
STUDY = {
    "parma": {"end": 2.0, "spacings": (15, 10, 5), "threads": {}},
    "obstacle": {
        "end": 6.0,
        "spacings": (10, 5, 2),
        # Where one number of threads is timed, not one and two.
        "threads": {("eulerian", 2): (1,)},
    },
}
# The grounds of `terrain.py`, which makes the table of that name.
GROUNDS = ("flat", "terrain")
PHASE_COLUMNS = ("neighbours", "gradients", "rates", "faces", "update", "velocities", "motion", "gridding", "recording")
PLANS = {
    "demo": ["scenarios/demo/scenario.yaml"],
    "malpasset, 40 m": ["scenarios/malpasset/scenario.yaml", "resolution=40 m", "outputs.cell=40 m"],
    "malpasset, 20 m": ["scenarios/malpasset/scenario.yaml"],
}
# Errors (m, m/s) that differ by less are the same: rounding in another order.
ROUNDING = 1e-12
# Programs before and after what was done for speed, as commits, and the motion that it was done for.
ACCURACY = {
    "Eulerian particles, update on lanes": ("eulerian", "a1c2c70", "75f8a11"),
}


def output(command, **kwargs):
    print("+", " ".join(command), flush=True)
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, **kwargs).stdout


def measure(*words):
    return output(["cargo", "bench", "--locked", "--quiet", "--bench", "measure", "--", *map(str, words)])


# The folder of the tables in use.
tables = HERE


def write(name, text):
    tables.mkdir(exist_ok=True)
    (tables / f"{name}.csv").write_text(text)


def read(name):
    path = tables / f"{name}.csv"
    return list(csv.DictReader(path.open())) if path.exists() else []


def as_csv(rows):
    text = io.StringIO()
    table = csv.DictWriter(text, rows[0].keys(), lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    return text.getvalue()


def run_memory():
    lines = [measure("memory", motion, size) for motion in MOTIONS for size in MEMORY_SIZES]
    write("memory", "motion,particles,bed_particles,peak_bytes\n" + "".join(lines))
    run_memory_of_parma()


def run_memory_of_parma():
    """Whole runs at two spacings."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for motion, spacing in [(motion, spacing) for motion in MOTIONS for spacing in MEMORY_SPACINGS]:
            words = [f"resolution={spacing} mm", f"outputs.cell={spacing} mm", f"numerics.motion={motion}"]
            record = run(HERE / "parma.yaml", pathlib.Path(folder) / str(len(rows)), words, 1)
            rows.append({"motion": motion, "particles": record["particles"]["initial"], "bed_particles": record["bed_particles"], "peak_bytes": round(record["peak_rss_mb"] * 2**20)})
    write("memory_parma", as_csv(rows))


def settings(words):
    return [part for word in words for part in ("--set", word)]


def run(file, out, words, threads):
    output([PROGRAM, "run", str(file), "--out", str(out), "--quiet", "--threads", str(threads), *settings(words)], stderr=subprocess.DEVNULL)
    return json.loads((out / "run.json").read_text())


def run_study(name):
    rows = []
    study = STUDY[name]
    with tempfile.TemporaryDirectory() as folder:
        for motion in MOTIONS:
            for spacing in study["spacings"]:
                for threads in study["threads"].get((motion, spacing), (1, 2)):
                    words = [f"resolution={spacing} mm", f"outputs.cell={spacing} mm", f"time.end={study['end']} s", f"numerics.motion={motion}"]
                    record = run(HERE / f"{name}.yaml", pathlib.Path(folder) / f"{motion}{spacing}{threads}", words, threads)
                    row = {"motion": motion, "spacing_mm": spacing, "threads": threads, "particles": record["particles"]["initial"], "bed_particles": record["bed_particles"]}
                    row |= {key: record[key] for key in ("steps", "particle_evaluations", "simulated_s", "wall_s", "cpu_s", "peak_rss_mb")}
                    row["compute_s"] = record["phase_s"]["compute"]
                    row |= {f"{phase}_s": round(record["phase_s"].get(f"compute: {phase}", 0), 4) for phase in PHASE_COLUMNS}
                    rows.append({key: round(value, 4) if isinstance(value, float) else value for key, value in row.items()})
                    write(name, as_csv(rows))


def run_plans():
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, (file, *words)) in enumerate(PLANS.items()):
            plan = json.loads(output([PROGRAM, "plan", file, "--json", *settings(words)]))
            record = run(file, pathlib.Path(folder) / str(number), words, os.cpu_count())
            size = sum(path.stat().st_size for path in (pathlib.Path(folder) / str(number)).rglob("*") if path.is_file()) / 1e6
            actual = {
                "particles": record["particles"]["peak"],
                "memory_mb": record["peak_rss_mb"],
                "steps": record["steps"],
                "run_time_s": record["wall_s"],
                "disk_mb": size,
            }
            for key, value in actual.items():
                low, high = plan["particles"]["peak"] if key == "particles" else plan[key]
                rows.append({"run": name, "what": key, "low": f"{low:.1f}", "actual": f"{value:.1f}", "high": f"{high:.1f}"})
            write("plans", as_csv(rows))


def run_accuracy():
    # Commits stay what they are: those that are known are not run again.
    known = [row for row in read("accuracy") if row["commit"] in ACCURACY.get(row["what"], ())]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for what, (motion, *commits) in ACCURACY.items():
            for when, commit in zip(("before", "after"), commits):
                if mine := [row for row in known if (row["what"], row["commit"]) == (what, commit)]:
                    rows += mine
                    continue
                tree, found = folder / commit, folder / f"{commit}.csv"
                if not tree.exists():
                    output(["git", "worktree", "add", "--detach", str(tree), commit], stderr=subprocess.DEVNULL)
                try:
                    # One folder for all: what they depend on is built once.
                    built = {**os.environ, "CARGO_TARGET_DIR": str(folder / "target")}
                    output(["cargo", "build", "--release", "--locked", "--quiet"], cwd=tree, env=built)
                    command = [str(folder / PROGRAM), "validate", "--suite", "analytic", "--vary", f"motion={motion}", "--csv", str(found)]
                    # Exit code 7: an acceptance limit is missed.
                    print("+", " ".join(command), flush=True)
                    subprocess.run(command, check=False, stdout=subprocess.DEVNULL)
                finally:
                    output(["git", "worktree", "remove", "--force", str(tree)])
                columns = ("case", "spacing_m", "error_depth", "error_velocity", "cpu_s")
                rows += [{"what": what, "when": when, "commit": commit} | {key: row[key] for key in columns} for row in csv.DictReader(found.open())]
                write("accuracy", as_csv(rows))


RUNS = {
    "accuracy": run_accuracy,
    "phases": lambda: write("phases", measure("phases")),
    "sizes": lambda: write("sizes", measure("sizes")),
    "threads": lambda: write("threads", measure("threads")),
    "memory": run_memory,
    "machine": lambda: write("machine", measure("machine")),
    "instructions": lambda: write("instructions", output(["scripts/instructions.sh"])),
    "parma": lambda: run_study("parma"),
    "obstacle": lambda: run_study("obstacle"),
    "plans": run_plans,
}


def table(heading, rows):
    line = lambda cells: "| " + " | ".join(str(cell) for cell in cells) + " |"
    return "\n".join([line(heading), line(["---"] * len(heading)), *map(line, rows)]) + "\n"


def rate(row):
    return float(row["particle_evaluations"]) / float(row["cpu_s"]) / 1e6


def verdict(met):
    return "met" if met else "**not met**"


def phases():
    rows, parts = [], read("phases")
    for motion in MOTIONS:
        mine = [row for row in parts if row["motion"] == motion]
        if not mine:
            continue
        whole = sum(float(row["cpu_s"]) for row in mine)
        evaluations = float(mine[0]["particle_evaluations"])
        for row in mine:
            cpu = float(row["cpu_s"])
            rows.append([NAMES[motion], row["phase"], f"{1e9 * cpu / evaluations:.0f}", f"{100 * cpu / whole:.0f} %", f"{evaluations / cpu / 1e6:.1f}" if cpu else "-"])
        total = evaluations / whole / 1e6
        target = f" (target {RATE_TARGET[motion]}: {verdict(total >= RATE_TARGET[motion])})"
        rows.append([f"**{NAMES[motion]}**", "**all**", f"**{1e9 * whole / evaluations:.0f}**", "100 %", f"**{total:.2f}**{target}"])
    return table(["particles", "phase", "ns an evaluation", "share", "million evaluations a CPU second"], rows)


def sizes():
    rows, text = [], read("sizes")
    for motion in MOTIONS:
        mine = [row for row in text if row["motion"] == motion]
        for row in mine:
            rows.append([NAMES[motion], f"{int(row['particles']):,}".replace(",", " "), f"{1e3 / rate(row):.0f}", f"{rate(row):.2f}", f"{rate(mine[0]) / rate(row):.2f}"])
    return table(["particles", "number", "ns an evaluation", "million a CPU second", "cost of one against the smallest"], rows)


def memory():
    """Bytes per riverbed particle, whether wet or not."""
    counted = {"eulerian": "bed_particles"}
    rows = []
    for name, text in [("", read("memory")), (", whole run of Parma", read("memory_parma"))]:
        for motion in MOTIONS:
            mine = [(int(row[counted[motion]]), int(row["bed_particles"]), float(row["peak_bytes"])) for row in text if row["motion"] == motion]
            if len(mine) < 2:
                continue
            (n, cells, a), (m, more_cells, b) = mine[:2]
            slope = (b - a) / (m - n)
            peaks = f"{a / 2**20:.0f} MiB at {n}, {b / 2**20:.0f} MiB at {m}"
            rows.append([NAMES[motion] + name, peaks, f"{cells / n:.2f}", f"{slope:.0f}", f"{(a - slope * n) / 2**20:.0f} MiB", verdict(slope <= MEMORY_TARGET)])
    return table(["particles", "peak", "cells for each", "bytes a particle", "fixed part", f"target {MEMORY_TARGET} bytes"], rows)


def threads():
    rows, text = [], read("threads")
    for motion in MOTIONS:
        best = {}
        for row in text:
            if row["motion"] == motion:
                cost = {key: float(row[key]) / float(row["particle_evaluations"]) for key in ("wall_s", "cpu_s")}
                place = best.setdefault(row["threads"], dict(cost))
                for key, value in cost.items():
                    place[key] = min(place[key], value)
        if len(best) == 2:
            efficiency = best["1"]["wall_s"] / best["2"]["wall_s"] / 2
            rows.append([NAMES[motion], f"{1e9 * best['1']['wall_s']:.0f}", f"{1e9 * best['2']['wall_s']:.0f}", f"{100 * efficiency:.0f} %", f"{100 * best['1']['cpu_s'] / best['2']['cpu_s']:.0f} %", verdict(efficiency >= EFFICIENCY_TARGET)])
    return table(["particles", "ns an evaluation, 1 thread", "2 threads", "wall-clock efficiency", "CPU time of 1 thread over that of 2", f"target {100 * EFFICIENCY_TARGET:.0f} %"], rows)


def roofline():
    machine = {row["what"]: float(row["value"]) for row in read("machine")}
    parts = read("phases")
    if not machine or not parts:
        return "Not measured.\n"
    cost = {}
    for motion in MOTIONS:
        mine = [row for row in parts if row["motion"] == motion]
        cost[motion] = sum(float(row["cpu_s"]) for row in mine) / float(mine[0]["particle_evaluations"])
    moved = {"eulerian": 8 * sum(read_ + 2 * written for read_, written in RESTING_NUMBERS)}
    rows = []
    for motion in MOTIONS:
        arithmetic = OPERATIONS[motion] / machine["chains"]
        bytes_ = moved.get(motion)
        memory_ = bytes_ / machine["triad"] if bytes_ else None
        bound = max(arithmetic, memory_ or 0)
        rows.append([NAMES[motion], OPERATIONS[motion], f"{1e9 * arithmetic:.0f}", bytes_ or "-", f"{1e9 * memory_:.0f}" if memory_ else "-", f"{1e9 * cost[motion]:.0f}", f"{cost[motion] / bound:.1f}"])
    head = f"A triad moves {machine['triad'] / 1e9:.1f} GB/s on one thread, chains of products and sums give {machine['chains'] / 1e9:.1f} Gflop/s.\n\n"
    return head + table(["particles", "operations an evaluation", "ns by the chains", "bytes an evaluation", "ns by the triad", "ns measured", "gap"], rows)


def instructions():
    rows = [[NAMES[row["motion"]], row["particles"], row["instructions_per_evaluation"], row["particle_evaluations"], row["counter"]] for row in read("instructions") if row["motion"] in MOTIONS]
    return table(["particles", "number", "instructions an evaluation", "evaluations counted", "counter"], rows)


def study(name, target):
    rows, text = [], [row for row in read(name) if row["motion"] in MOTIONS]
    finest = str(min(STUDY[name]["spacings"]))
    most = {motion: max((row["threads"] for row in text if (row["motion"], row["spacing_mm"]) == (motion, finest)), default="") for motion in MOTIONS}
    for row in text:
        number = lambda key: float(row[key])
        spacing, threads_ = int(row["spacing_mm"]), int(row["threads"])
        # Phases are timed in wall-clock time; the share of it in which the program ran at all makes CPU time of them.
        ran = number("cpu_s") / number("wall_s")
        seconds = lambda *phases: f"{ran * sum(number(f'{phase}_s') for phase in phases):.2f}"
        idle = number("cpu_s") / threads_
        reported = f"{idle:.1f} s" if idle < 300 else f"{idle / 60:.0f} min"
        if (row["spacing_mm"], row["threads"]) == (finest, most[row["motion"]]):
            reported += f" (target {target} s: {verdict(idle <= target)})"
        cells = [NAMES[row["motion"]], f"{spacing} mm", row["particles"], row["threads"], row["steps"]]
        cells += [seconds("gradients"), seconds("rates", "faces", "update", "velocities"), f"{number('cpu_s'):.1f}"]
        cells += [f"{number('wall_s'):.1f}", reported, f"{number('particle_evaluations') / number('cpu_s') / 1e6:.2f}"]
        if name == "parma":
            particles, _, one, many = WU[spacing]
            cells.append(f"{one} s on 1, {many} s on 20 ({particles})")
        rows.append(cells)
    heading = ["particles", "spacing", "number", "threads", "steps", "depth", "acceleration", "CPU s", "wall-clock s", "on idle cores", "million evaluations a CPU second"]
    return table(heading + (["Wu et al."] if name == "parma" else []), rows)


def terrain():
    """What an evaluation costs by parts, and what terrain adds to each."""
    text = read("terrain")
    shown, total = [], {}
    for row in text:
        for key in row:
            if key != "part":
                total[key] = total.get(key, 0.0) + float(row[key])
    for row in [*text, {"part": "**all**", **total}]:
        number = lambda key: float(row[key])
        extra = number("terrain_ns") - number("flat_ns")
        share = extra / (total["terrain_ns"] - total["flat_ns"])
        cells = [row["part"], *(f"{number(f'{ground}_ns'):.1f}" for ground in GROUNDS), f"{extra:.1f}", f"{100 * share:.0f} %"]
        cells += [f"{number(f'{ground}_{what}'):.{digits}f}" for what, digits in (("instructions", 0), ("lines", 1)) for ground in GROUNDS]
        shown.append(cells)
    heading = ["part", "ns, flat", "ns, terrain", "more", "share of that", "instructions, flat", "terrain", "cache lines, flat", "terrain"]
    return table(heading, shown)


def plans():
    return table(["run", "what", "at least", "was", "at most"], [[row["run"], row["what"], row["low"], row["actual"], row["high"]] for row in read("plans")])


def accuracy():
    """How many rows of the suite are the same to the printed digits before and after, and those that are not."""
    text, sections = read("accuracy"), []
    for what in ACCURACY:
        found = {}
        for row in text:
            if row["what"] == what:
                found.setdefault((row["case"], row["spacing_m"]), {})[row["when"]] = row
        pairs = {key: (pair["before"], pair["after"]) for key, pair in found.items() if len(pair) == 2}
        if not pairs:
            continue
        errors = ("error_depth", "error_velocity")
        number = lambda text: float(text or "nan")
        is_same = lambda before, after: before == after or abs(number(before) - number(after)) < ROUNDING
        same = [key for key, (before, after) in pairs.items() if all(is_same(before[error], after[error]) for error in errors)]
        before, after = next(iter(pairs.values()))
        reported = f"**{what}** (commits {before['commit']} and {after['commit']}): "
        reported += f"all {len(pairs)} rows are the same" if len(same) == len(pairs) else f"{len(same)} of {len(pairs)} rows are the same; the others"
        sections.append(f"{reported}{'.' if len(same) == len(pairs) else ':'}\n")
        rows = [
            [case, spacing, *(f"{before[error]} / {after[error]}" for error in errors)]
            for (case, spacing), (before, after) in pairs.items()
            if (case, spacing) not in same
        ]
        if rows:
            sections.append(table(["case", "spacing (m)", "depth before / after (m)", "velocity before / after (m/s)"], rows))
    return "\n".join(sections)


PARTS = {
    "phases": phases,
    "sizes": sizes,
    "memory": memory,
    "threads": threads,
    "roofline": roofline,
    "instructions": instructions,
    "terrain": terrain,
    "parma": lambda: study("parma", PARMA_TARGET),
    "obstacle": lambda: study("obstacle", OBSTACLE_TARGET),
    "plans": plans,
    "accuracy": accuracy,
}


def page():
    global tables
    text = (HERE / "page.md").read_text()
    for tables, machine in ((HERE, ""), (HERE / OTHER, f"{OTHER} ")):
        for name, part in PARTS.items():
            place = "{{" + machine + name + "}}"
            if place in text:
                text = text.replace(place, part().rstrip("\n"))
    PAGE.write_text(text)


def main():
    global tables
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", nargs="*", choices=[*RUNS, []], metavar="TABLE")
    parser.add_argument("--machine", choices=[OTHER])
    arguments = parser.parse_args()
    tables = HERE / (arguments.machine or "")
    if arguments.run is not None:
        for name in arguments.run or RUNS:
            RUNS[name]()
    page()


if __name__ == "__main__":
    main()
