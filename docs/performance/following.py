"""What levels would save that follow the flow during a run: the table of decision 0065.

    python3 docs/performance/following.py target/release/floodsim SCRATCH

Runs each case on its coarsest cells alone, with frames, and on its levels for the ground of the finest ones (about ten minutes of one core). Levels
are then chosen in blocks of 16 finest cells by (M94) in three ways:

    static      terrain by the greatest depth about a block, flow by its greatest depth and discharge, as the program does
    both        terrain by the greatest depth, flow by depth and discharge of the moment and of the frames before and after
    following   both by the water of these moments

What a wet block costs in a moment goes with the cube of its cells per metre. Neither ridges, structures and gauges count, nor room between levels,
nor what it takes to change a level. Needs numpy, scipy and netCDF4.
"""

import json
import pathlib
import subprocess
import sys

import netCDF4
import numpy as np
from scipy.ndimage import maximum_filter

# Scenario (below scenarios/, or a script that makes one), finest and coarsest cells (m), time between frames.
CASES = {
    "Malpasset": ("malpasset/scenario", 20.0, 160.0, "60 s"),
    "Big Tujunga": ("laboratory/big_tujunga", 10.0, 80.0, "60 s"),
    "long valley": ("long_valley.py", 5.0, 40.0, "30 s"),
    "demonstration": ("demo/scenario", 10.0, 80.0, "60 s"),
}
BLOCK, UNSEEN, REACHED, GRAVITY = 16, 0.1, 0.05, 9.81


def run(program, scenario, folder, settings):
    command = [program, "run", str(scenario), "--threads", "1", "--overwrite", "--quiet", "--out", str(folder)]
    for setting in settings:
        command += ["--set", setting]
    subprocess.run(command, check=True)
    return json.loads((folder / "run.json").read_text())


def values(variable, index=slice(None)):
    return np.flipud(np.ma.filled(variable[index].astype(float), np.nan))


def blocks(array, size):
    """The array by blocks of so many cells, rows and columns that are left over filled with not-a-number."""
    rows, columns = (-(-count // size) for count in array.shape)
    whole = np.full((rows * size, columns * size), np.nan)
    whole[: array.shape[0], : array.shape[1]] = array
    return whole.reshape(rows, size, columns, size).swapaxes(1, 2).reshape(rows, columns, size * size)


def scatter(bed, level):
    """(M93) of the cells of a level."""
    size = 2**level
    cells = blocks(bed, size)
    offset = np.arange(size) - 0.5 * (size - 1)
    x, y = np.tile(offset, size), np.repeat(offset, size)
    mean = cells.mean(axis=2, keepdims=True)
    slopes = [(cells * along).sum(axis=2, keepdims=True) / (along**2).sum() for along in (x, y)]
    return np.sqrt(((cells - mean - slopes[0] * x - slopes[1] * y) ** 2).mean(axis=2))


def to_blocks(coarse, shape, size):
    """The greatest of coarse cells in and about each block of finest cells."""
    greatest = maximum_filter(coarse, 3)
    rows, columns = (np.minimum(np.arange(count) * BLOCK // size, limit - 1) for count, limit in zip(shape, coarse.shape))
    return greatest[np.ix_(rows, columns)]


def chosen(terrain, head, depth, mean_depth, finest, levels):
    """The coarsest level that does for each block."""
    level = np.zeros(depth.shape, int)
    for k in range(1, levels + 1):
        does = (terrain[k] <= UNSEEN * depth) & (head * finest * 2**k <= UNSEEN * mean_depth)
        level[does & (level == k - 1)] = k
    return level


def measure(program, case, scratch):
    name, finest, coarsest, every = CASES[case]
    scenario = pathlib.Path("scenarios") / f"{name}.yaml"
    if name.endswith(".py"):
        scenario = scratch / "made" / "scenario.yaml"
        subprocess.run([sys.executable, f"docs/performance/{name}", str(scenario.parent)], check=True)
    levels = int(np.log2(coarsest / finest))
    nested, coarse = scratch / f"{case}_nested", scratch / f"{case}_coarse"
    run(program, scenario, nested, [f"resolution={{finest: {finest} m, coarsest: {coarsest} m}}", f"outputs.cell={finest} m", "outputs.write=[maps]"])
    run(program, scenario, coarse, [f"resolution={coarsest} m", f"outputs.cell={coarsest} m", f"outputs.every={every}"])
    with netCDF4.Dataset(nested / "maps.nc") as maps:
        bed, west, south = values(maps["bed_elevation"]), maps["x"][:].min() - finest / 2, maps["y"][:].min() - finest / 2
    with netCDF4.Dataset(coarse / "fields.nc") as fields:
        coarse_west, coarse_south = (fields[axis][:].min() - coarsest / 2 for axis in "xy")
        depths = [np.nan_to_num(values(fields["depth"], k)) for k in range(len(fields["time"]))]
        speeds = [np.nan_to_num(np.hypot(values(fields["velocity_x"], k), values(fields["velocity_y"], k))) for k in range(len(depths))]
    with netCDF4.Dataset(coarse / "maps.nc") as maps:
        coarse_bed = values(maps["bed_elevation"])
    # Both lattices from their common south-western corner.
    size = round(coarsest / finest)
    corner = [max(west, coarse_west), max(south, coarse_south)]
    first = [round((c - own) / finest) for c, own in zip(corner, (west, south))]
    bed = bed[first[1] :, first[0] :]
    first = [round((c - own) / coarsest) for c, own in zip(corner, (coarse_west, coarse_south))]
    cut = lambda array: array[first[1] :, first[0] :][: -(-bed.shape[0] // size), : -(-bed.shape[1] // size)]
    depths, speeds, coarse_bed = [cut(d) for d in depths], [cut(s) for s in speeds], cut(coarse_bed)
    bed = bed[: coarse_bed.shape[0] * size, : coarse_bed.shape[1] * size]
    # Change of the depth at the highest level, and what each level does not see of the ground.
    highest = np.maximum.reduce(depths)
    surface = np.where(highest >= REACHED, coarse_bed + highest, np.nan)
    spread = lambda array: np.kron(array, np.ones((size, size)))[: bed.shape[0], : bed.shape[1]]
    slopes = [spread(np.nan_to_num(slope)) for slope in np.gradient(surface, coarsest)]
    ground = np.gradient(bed, finest)
    change = sum((a - b) ** 2 for a, b in zip(slopes, ground))
    change[~(spread(surface) - bed >= REACHED)] = np.nan
    with np.errstate(all="ignore"):
        change = np.sqrt(np.nan_to_num(np.nanmean(blocks(change, BLOCK), axis=2)))
        terrain = [None] + [np.sqrt(np.nan_to_num(np.nanmean(blocks(scatter(bed, k) ** 2, BLOCK // 2**k), axis=2))) for k in range(1, levels + 1)]
    shape = change.shape
    mean_depth = highest[highest >= REACHED].mean()
    d_of = [to_blocks(d, shape, size) for d in depths]
    q_of = [to_blocks(d * s, shape, size) for d, s in zip(depths, speeds)]
    head = lambda q, d: 0.5 * q**2 / (GRAVITY * np.maximum(d, REACHED) ** 3) * change
    greatest_depth = np.maximum.reduce(d_of)
    static = chosen(terrain, head(np.maximum.reduce(q_of), greatest_depth), greatest_depth, mean_depth, finest, levels)
    cost = dict.fromkeys(("static", "both", "following", "finest"), 0.0)
    for k, depth in enumerate(depths):
        near = slice(max(k - 1, 0), k + 2)
        q, d = np.maximum.reduce(q_of[near]), np.maximum.reduce(d_of[near])
        wet = np.nan_to_num(np.nanmean(blocks(spread((depth >= 0.01).astype(float)), BLOCK), axis=2))
        ways = {
            "static": static,
            "both": chosen(terrain, head(q, d), greatest_depth, mean_depth, finest, levels),
            "following": chosen(terrain, head(q, d), d, mean_depth, finest, levels),
            "finest": np.zeros(shape, int),
        }
        for way, level in ways.items():
            cost[way] += (wet * 8.0**-level).sum()
    return {way: value / cost["finest"] for way, value in cost.items()}


def main():
    program, scratch = sys.argv[1], pathlib.Path(sys.argv[2])
    scratch.mkdir(parents=True, exist_ok=True)
    print("case,static,both,following")
    for case in sys.argv[3:] or CASES:
        cost = measure(program, case, scratch)
        print(case, *(f"{cost[way]:.3f}" for way in ("static", "both", "following")), sep=",", flush=True)


if __name__ == "__main__":
    main()
