"""What an evaluation costs on flat ground and on terrain, part by part: docs/performance/terrain.csv.

    cargo build --release
    python3 docs/performance/terrain.py [program]

Run it in the folder of the repository, with Malpasset behind FLOODSIM_DATA. Nanoseconds are samples of the processor time (`perf record -e cpu-clock`), the
best of three runs in turn; instructions, and cache lines that a second-level cache of 512 KB does not hold, are counted by `valgrind --tool=callgrind`; all on one
thread. Each belongs to a part by the functions that are inlined at its address (`addr2line -i`). Only what the steps do counts: preparation and files are left
out. valgrind knows no AVX-512.
"""

import collections
import csv
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path("docs/performance")
PROGRAM = os.path.realpath(sys.argv[1] if len(sys.argv) > 1 else "target/release/floodsim")
# The scenario of each ground, its settings, and the simulated seconds with perf and with valgrind, which is 50 times slower.
MALPASSET = ["--set", "resolution=40 m", "--set", "outputs.cell=40 m"]
GROUNDS = {
    "flat": (str(HERE / "flat.yaml"), [], 1200, 200),
    "terrain": ("scenarios/malpasset/scenario.yaml", MALPASSET, 1000, 150),
}
# Of each part what stands among the functions and files that are inlined at its addresses; the first that fits counts.
PARTS = (
    ("faces: ordinary pairs", r"row_faces"),
    ("gradients: ordinary cells", r"row_gradient"),
    ("update", r"row_update"),
    ("limit of the outflow", r"some_are_short|limit_outflow"),
    ("not in steps", r"Walls::new|find_stairs|is_stair|State::new|Passes::new"),
    ("faces over sills", r"passes\.rs|over_sill|Half::of_side"),
    ("gradients beside walls and sills", r"walls::correct"),
    ("faces of walls, parts beside stairs", r"walls\.rs|FaceRow::scale"),
    ("velocities", r"primitive\.rs"),
    ("active cells, their runs", r"spans\.rs"),
    ("maxima, gauges", r"output/(maxima|gauges|recorder)"),
    ("the rest of the steps", r"src/core/solver/"),
)
SECONDS_A_SAMPLE = 5e-4
RUNS = 3
# The caches of the count: bytes, ways, bytes of a line.
CACHES = ["--cache-sim=yes", "--D1=32768,8,64", "--LL=524288,8,64"]


def run(prefix, ground, end, out):
    scenario, settings, *_ = GROUNDS[ground]
    command = [PROGRAM, "run", scenario, *settings, "--set", f"time.end={end} s", "--set", "outputs.write=[]"]
    command += ["--threads", "1", "--quiet", "--overwrite", "--out", str(out)]
    subprocess.run([*prefix, *command], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return json.loads((out / "run.json").read_text())["particle_evaluations"]


def sampled(ground, folder):
    """Processor time (ns) an evaluation by address of the program."""
    data, out = folder / "perf.data", folder / "run"
    evaluations = run(["perf", "record", "-e", "cpu-clock", "-F", str(round(1 / SECONDS_A_SAMPLE)), "-o", str(data)], ground, GROUNDS[ground][2], out)
    script = ["perf", "script", "-i", str(data), "--show-mmap-events", "-F", "comm,event,ip,dso"]
    text = subprocess.run(script, check=True, capture_output=True, text=True).stdout
    name = os.path.basename(PROGRAM)
    mapped = re.search(rf"\[0x(\w+)\(0x\w+\) @ (0x\w+|0) .*: r-xp .*/{name}$", text, re.M)
    start = int(mapped[1], 16) - int(mapped[2], 16) - text_offset()
    counts = collections.Counter(int(ip, 16) - start for ip in re.findall(rf"\s([0-9a-f]{{6,16}}) .*/{name}\)$", text, re.M))
    return {address: 1e9 * SECONDS_A_SAMPLE * count / evaluations for address, count in counts.items()}


def text_offset():
    """How much further the code lies in memory than in the file."""
    for line in subprocess.run(["readelf", "-lW", PROGRAM], check=True, capture_output=True, text=True).stdout.splitlines():
        found = re.match(r"\s+LOAD\s+0x(\w+) 0x(\w+) .* R E ", line)
        if found:
            return int(found[2], 16) - int(found[1], 16)
    return 0


def counted(ground, folder):
    """Instructions, and cache lines read or written anew, an evaluation by address of the program."""
    out = folder / "callgrind"
    evaluations = run(["valgrind", "--tool=callgrind", "--dump-instr=yes", *CACHES, f"--callgrind-out-file={out}"], ground, GROUNDS[ground][3], folder / "run")
    instructions, lines = collections.Counter(), collections.Counter()
    address, is_call, is_program, objects = 0, False, False, {}
    for line in out.open(errors="replace"):
        if line.startswith(("ob=", "cob=")):
            # A name stands beside its number where it comes first.
            key, _, rest = line.strip().partition("=")
            number, _, name = rest.partition(" ")
            objects.setdefault(number, name)
            is_program = objects[number] == PROGRAM if key == "ob" else is_program
        elif line.startswith("calls="):
            is_call = True
        elif line[0] in "0123456789+-*":
            # Address, line of the source and counts, those at the end left out where they are 0; the address may be given by its distance
            # from the last one. Counts: Ir Dr Dw I1mr D1mr D1mw ILmr DLmr DLmw.
            words = line.split()
            if words[0][0] in "+-":
                address += int(words[0], 0)
            elif words[0] != "*":
                address = int(words[0], 16)
            if not is_call and is_program:
                counts = [int(word) for word in words[2:]] + 9 * [0]
                instructions[address] += counts[0] / evaluations
                lines[address] += (counts[7] + counts[8]) / evaluations
            is_call = False
    return instructions, lines


def by_part(costs):
    text = subprocess.run(["addr2line", "-e", PROGRAM, "-f", "-i", "-C", "-a"], input="\n".join(map(hex, costs)), check=True, capture_output=True, text=True).stdout
    chains = {int(chain.split("\n", 1)[0], 16): chain for chain in re.split(r"^0x", text, flags=re.M)[1:]}
    parts = collections.Counter()
    for address, cost in costs.items():
        part = next((part for part, pattern in PARTS if re.search(pattern, chains[address])), "not in steps")
        parts[part] += cost
    del parts["not in steps"]
    return parts


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        times = [{ground: by_part(sampled(ground, folder)) for ground in GROUNDS} for _ in range(RUNS)]
        costs = {f"{ground}_ns": min((time[ground] for time in times), key=lambda parts: parts.total()) for ground in GROUNDS}
        for ground in GROUNDS:
            instructions, lines = counted(ground, folder)
            costs |= {f"{ground}_instructions": by_part(instructions), f"{ground}_lines": by_part(lines)}
    with (HERE / "terrain.csv").open("w") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["part", *costs])
        for part in [part for part, _ in PARTS if part != "not in steps"]:
            table.writerow([part, *(f"{cost[part]:.{2 if name.endswith('lines') else 1}f}" for name, cost in costs.items())])


if __name__ == "__main__":
    main()
