#!/usr/bin/env python3
"""Makes the valley of the demonstration: terrain, reservoir, dam line, river, village and gauges.

Needs numpy and the program gdal_translate (package gdal-bin). Everything is deterministic; the outputs are committed, so
nobody has to run this. Run it in this folder: python3 make.py

How: a meandering main valley and nine tributaries are laid down as axes with a long profile and a cross section each, the
surface is their smooth minimum plus fractal noise, and a few steps of stream-power erosion carve gullies into the
hillsides. Floodplain and river channel are then cut along the main axis.
"""

import heapq
import json
import subprocess
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
WEST, SOUTH, CELL = 642_000.0, 5_186_000.0, 10.0  # EPSG:32632
COLUMNS, ROWS = 800, 400
DAM_X = 2_600.0  # m from the western edge; the dam runs north-south
DAM_HEIGHT = 30.0  # level of the reservoir above the river at the dam, m
SEED = 1959

x = (np.arange(COLUMNS) + 0.5) * CELL
y = (np.arange(ROWS) + 0.5) * CELL
X, Y = np.meshgrid(x, y)  # row 0 in the south


def smooth_step(t):
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def fractal_noise(random, exponent, longest):
    """Noise of zero mean and unit variance with a power-law spectrum, without waves longer than `longest` (m)."""
    rows, columns = 2 * ROWS, 2 * COLUMNS  # a larger field, cut out, hides that the transform is periodic
    k = np.hypot(np.fft.fftfreq(rows, CELL)[:, None], np.fft.rfftfreq(columns, CELL)[None, :])
    spectrum = np.fft.rfft2(random.standard_normal((rows, columns)))
    amplitude = np.where(k > 0.0, np.maximum(k, 1.0 / longest) ** (-exponent / 2.0), 0.0)
    field = np.fft.irfft2(spectrum * amplitude, s=(rows, columns))[:ROWS, :COLUMNS]
    return (field - field.mean()) / field.std()


def spline(points, step):
    """A Catmull-Rom curve through `points`, sampled about every `step` metres."""
    p = np.array(points, float)
    p = np.vstack([2 * p[0] - p[1], p, 2 * p[-1] - p[-2]])
    curve = []
    for a, b, c, d in zip(p, p[1:], p[2:], p[3:]):
        t = np.linspace(0.0, 1.0, max(2, int(np.hypot(*(c - b)) / step)), endpoint=False)[:, None]
        curve.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3))
    return np.vstack(curve + [p[-2:-1]])


class Axis:
    """A valley axis with, for each cell, the distance from it, the chainage along it and the side."""

    def __init__(self, points):
        self.line = spline(points, 20.0)
        self.chainage = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self.line, axis=0).T))])
        cells = np.column_stack([X.ravel(), Y.ravel()])
        distance, along, side = (np.empty(len(cells)) for _ in range(3))
        tangent = np.gradient(self.line, axis=0)
        for part in np.array_split(np.arange(len(cells)), 200):
            offset = cells[part, None, :] - self.line[None, :, :]
            d2 = (offset**2).sum(axis=2)
            nearest = d2.argmin(axis=1)
            d2_min = d2.min(axis=1)
            width = 40.0 + 0.25 * np.sqrt(d2_min)  # the chainage is a local mean: no creases inside bends
            weight = np.exp(-(d2 - d2_min[:, None]) / (2.0 * width**2)[:, None])
            along[part] = weight @ self.chainage / weight.sum(axis=1)
            n, t = offset[np.arange(len(part)), nearest], tangent[nearest]
            distance[part] = np.abs(n[:, 1] * t[:, 0] - n[:, 0] * t[:, 1]) / np.hypot(*t.T)
            distance[part] = np.where(np.sqrt(d2_min) > distance[part] + 15.0, np.sqrt(d2_min), distance[part])
            side[part] = np.sign(n[:, 1] * t[:, 0] - n[:, 0] * t[:, 1])
        self.distance, self.along, self.side = (q.reshape(X.shape) for q in (distance, along, side))


def hillside(distance, floor, steepness, height):
    """Height above the valley floor: flat out to `floor`, then `steepness`, levelling off towards `height`."""
    out = np.maximum(distance - floor, 0.0)
    out = out**2 / (out + 0.35 * floor + 15.0)  # a rounded foot of the slope
    return height * (1.0 - np.exp(-steepness * out / height))


def erode(z, fixed, steps, strength):
    """Stream-power erosion (slope times root of the drained area), implicit in time, and a little creep."""
    offsets = [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)]
    index = np.arange(z.size).reshape(z.shape)
    for _ in range(steps):
        padded = np.pad(z, 1, constant_values=np.inf)
        padded_index = np.pad(index, 1, constant_values=-1)
        slope, receiver = np.zeros(z.shape), index.copy()
        for dr, dc in offsets:
            window = (slice(1 + dr, 1 + dr + ROWS), slice(1 + dc, 1 + dc + COLUMNS))
            s = (z - padded[window]) / (CELL * np.hypot(dr, dc))
            steeper = s > slope
            slope[steeper], receiver[steeper] = s[steeper], padded_index[window][steeper]
        order = np.argsort(z, axis=None, kind="stable")
        to = receiver.ravel().tolist()
        area = [CELL * CELL] * z.size
        for i in order[::-1].tolist():
            if to[i] != i:
                area[to[i]] += area[i]
        factor = (strength * np.sqrt(np.array(area)) / CELL).tolist()
        level, kept = z.ravel().tolist(), fixed.ravel().tolist()
        for i in order.tolist():
            if to[i] != i and not kept[i]:
                level[i] = (level[i] + factor[i] * level[to[i]]) / (1.0 + factor[i])
        z = np.array(level).reshape(z.shape)
        edge = np.pad(z, 1, mode="edge")
        mean = 0.25 * (edge[:-2, 1:-1] + edge[2:, 1:-1] + edge[1:-1, :-2] + edge[1:-1, 2:])
        z = np.where(fixed, z, z + 0.25 * (mean - z))
    return z


def fill_pits(z):
    """Raises every pit until it drains to the edge of the raster (priority flood), with a fall of 1 cm a cell."""
    out, done = z.ravel().tolist(), [False] * z.size
    front = [(out[i], i) for i in np.unique(np.r_[:COLUMNS, z.size - COLUMNS : z.size, 0 : z.size : COLUMNS,
                                                   COLUMNS - 1 : z.size : COLUMNS]).tolist()]
    for _, i in front:
        done[i] = True
    heapq.heapify(front)
    while front:
        level, i = heapq.heappop(front)
        row, column = divmod(i, COLUMNS)
        for r, c in ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)):
            j = r * COLUMNS + c
            if 0 <= r < ROWS and 0 <= c < COLUMNS and not done[j]:
                done[j] = True
                out[j] = max(out[j], level + 0.01)
                heapq.heappush(front, (out[j], j))
    return np.array(out).reshape(z.shape)


def boundary(mask):
    """The longest closed outline of a cell mask, as corners in cells, mask to the left."""
    padded = np.pad(mask, 1)
    following = {}
    for row, column in zip(*np.nonzero(padded)):
        corners = [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)]
        outside = [padded[row - 1, column], padded[row, column + 1], padded[row + 1, column], padded[row, column - 1]]
        for k in range(4):
            if not outside[k]:
                following.setdefault(corners[k], []).append(corners[(k + 1) % 4])
    rings = []
    while following:
        start = here = next(iter(following))
        ring = []
        while here in following:
            ring.append(here)
            ways = following[here]
            if len(ways) > 1 and len(ring) > 1:  # two cells touch at a corner: turn left, stay on this cell
                dx, dy = here[0] - ring[-2][0], here[1] - ring[-2][1]
                ways.sort(key=lambda way: -(dx * (way[1] - here[1]) - dy * (way[0] - here[0])))
            here_next = ways.pop(0)
            if not ways:
                del following[here]
            here = here_next
            if here == start:
                break
        rings.append(ring)
    longest = max(rings, key=len)
    return [((column - 1) * CELL, (row - 1) * CELL) for column, row in longest]


def simplify(line, tolerance):
    """Douglas-Peucker on an open line."""
    a, b = np.array(line[0]), np.array(line[-1])
    if len(line) < 3:
        return [line[0], line[-1]]
    p, t = np.array(line) - a, b - a
    length = np.hypot(*t)
    away = np.abs(p[:, 0] * t[1] - p[:, 1] * t[0]) / length if length > 0 else np.hypot(*p.T)
    k = int(away.argmax())
    if away[k] <= tolerance:
        return [line[0], line[-1]]
    return simplify(line[: k + 1], tolerance)[:-1] + simplify(line[k:], tolerance)


def flooded_from(start, below):
    """The cells of `below` that are connected (by edges) with the cell `start`."""
    seen, front = np.zeros(below.shape, bool), [start]
    seen[start] = True
    while front:
        row, column = front.pop()
        for r, c in ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)):
            if 0 <= r < ROWS and 0 <= c < COLUMNS and below[r, c] and not seen[r, c]:
                seen[r, c] = True
                front.append((r, c))
    return seen


def geojson(name, features):
    """Writes features, given as (geometry type, local coordinates, properties), in map coordinates."""

    def place(c):
        if isinstance(c[0], (int, float)):
            return [round(WEST + c[0], 1), round(SOUTH + c[1], 1)]
        return [place(part) for part in c]

    lines = [
        json.dumps({"type": "Feature", "properties": p, "geometry": {"type": kind, "coordinates": place(c)}})
        for kind, c, p in features
    ]
    crs = '{"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32632"}}'
    text = f'{{"type": "FeatureCollection", "name": "{Path(name).stem}", "crs": {crs},\n"features": [\n'
    (FOLDER / name).write_text(text + ",\n".join(lines) + "\n]}\n")


def main_valley_axis():
    return Axis(
        [(-350, 2750), (100, 2560), (550, 2420), (900, 2110), (1300, 1960), (1700, 2130), (2050, 2290), (2350, 2190),
         (2600, 2110), (2880, 2060), (3180, 1840), (3400, 1480), (3800, 1290), (4230, 1440), (4430, 1850), (4720, 2270),
         (5200, 2470), (5750, 2330), (6200, 1960), (6700, 1750), (7200, 1860), (7600, 2090), (8000, 2200), (8400, 2230)]
    )


def half_floor(s, s_dam):
    """Half width of the valley floor (m): a basin, the gorge of the dam, a bend, the village plain, the outlet."""
    places = [-2600, -1900, -700, -160, 0, 500, 1000, 1700, 2500, 3300, 4200, 5600]
    return np.interp(s, s_dam + np.array(places), [20, 45, 75, 45, 22, 26, 45, 90, 210, 330, 230, 290])


def make_terrain(main):
    random = np.random.default_rng(SEED)
    s_dam = main.chainage[np.abs(main.line[:, 0] - DAM_X).argmin()]
    s = main.along
    # Long profile: 1.5 % above the dam, 1.7 % in the gorge below it, easing to 0.9 % at the outlet.
    points = np.array([0.0, s_dam, s_dam + 900.0, s_dam + 2200.0, s_dam + 4000.0, 9500.0])
    falls = np.array([0.0148, 0.0175, 0.0140, 0.0105, 0.0090])
    levels = 566.0 - np.concatenate([[0.0], np.cumsum(np.diff(points) * falls)])
    thalweg = np.interp(s, points, levels)
    floor = half_floor(s, s_dam)
    floor = floor * (1.0 + 0.18 * main.side * np.sin(s / 410.0))
    steep = np.interp(s, s_dam + np.array([-2600, -1200, -250, 0, 400, 1200, 2600, 5600]),
                      [0.50, 0.42, 0.55, 0.85, 0.75, 0.55, 0.42, 0.36])
    relief = hillside(main.distance, floor, steep, 380.0)  # height above the bed of the own valley
    surface = thalweg + relief

    tributaries = [  # axis from the mouth upwards, fall of its bed, side slope, half width of its floor
        ([(560, 2400), (750, 2750), (700, 3150), (900, 3550), (820, 4200)], 0.115, 0.55, 12.0),
        ([(1300, 1970), (1480, 1550), (1350, 1150), (1560, 700), (1450, -200)], 0.090, 0.52, 16.0),
        ([(2050, 2280), (2180, 2650), (2080, 3000), (2300, 3400), (2250, 4200)], 0.140, 0.60, 8.0),
        ([(3150, 1850), (3520, 2250), (3450, 2750), (3650, 3300), (3560, 4200)], 0.120, 0.55, 10.0),
        ([(3800, 1290), (3900, 950), (3780, 600), (3950, 200), (3900, -300)], 0.115, 0.55, 10.0),
        ([(4950, 2400), (5150, 2800), (5050, 3250), (5300, 3650), (5220, 4250)], 0.085, 0.46, 20.0),
        ([(5000, 2420), (5250, 1800), (5150, 1300), (5400, 800), (5300, -250)], 0.100, 0.48, 12.0),
        ([(6700, 1760), (6550, 1300), (6720, 850), (6600, 400), (6750, -250)], 0.085, 0.46, 16.0),
        ([(6900, 1760), (7000, 2500), (6850, 2950), (7100, 3450), (7000, 4250)], 0.090, 0.46, 14.0),
    ]
    softness = 5.0
    for line, fall, slope, half_width in tributaries:
        axis = Axis(line)
        nearest = np.hypot(main.line[:, 0] - line[0][0], main.line[:, 1] - line[0][1]).argmin()
        mouth = np.interp(main.chainage[nearest], points, levels)
        rise = fall * axis.along * (1.0 + axis.along / 4000.0)
        own_relief = hillside(axis.distance, half_width, slope, 330.0)
        branch = mouth + 1.0 + rise + own_relief
        relief = np.where(branch < surface, own_relief, relief)
        both = np.minimum(surface, branch)
        surface = both - softness * np.log1p(np.exp(-np.abs(surface - branch) / softness))

    broad, fine = fractal_noise(random, 4.2, 1500.0), fractal_noise(random, 3.2, 500.0)
    surface = surface + smooth_step(relief / 140.0) * (36.0 * broad + 5.0 * fine)
    surface = np.maximum(surface, thalweg + 0.1)
    on_floor = main.distance < floor * 0.9
    surface = erode(fill_pits(surface), on_floor, steps=24, strength=0.006)

    # Floodplain: falls gently to the river, with a terrace on either side; channel: 25 to 35 m wide, 1.5 to 3 m deep.
    rough = fractal_noise(random, 2.6, 300.0)
    terrace = (0.8 + floor / 90.0) * smooth_step((main.distance * (1.0 + 0.12 * broad) - 0.42 * floor) / 35.0)
    plain = thalweg + 0.008 * main.distance + 0.35 * rough + terrace
    blend = smooth_step((main.distance - 0.75 * floor) / (0.35 * floor + 20.0))
    surface = (1.0 - blend) * np.minimum(plain, surface) + blend * np.maximum(surface, plain)
    half_channel = np.interp(s, [0.0, 9000.0], [11.0, 18.0])
    depth = np.interp(s, [0.0, 9000.0], [1.8, 2.8])
    meander = main.side * main.distance - 0.22 * floor * np.sin(s / 170.0)
    surface = surface - depth * np.exp(-((meander / half_channel) ** 4))
    return np.round(surface * 32.0) / 32.0, s_dam


def write_raster(z):
    text = f"ncols {COLUMNS}\nnrows {ROWS}\nxllcorner {WEST:.0f}\nyllcorner {SOUTH:.0f}\ncellsize {CELL:.0f}\n"
    text += "NODATA_value -9999\n"
    text += "\n".join(" ".join(f"{value:.5f}" for value in row) for row in z[::-1]) + "\n"
    grid = FOLDER / "terrain.asc"
    grid.write_text(text)
    subprocess.run(
        ["gdal_translate", "-q", "-ot", "Float32", "-a_srs", "EPSG:32632", "-co", "COMPRESS=DEFLATE", "-co", "ZLEVEL=9",
         "-co", "PREDICTOR=3", "-co", "TILED=YES", str(grid), str(FOLDER / "terrain_10m.tif")], check=True)
    grid.unlink()
    (FOLDER / "terrain_10m.tif.aux.xml").unlink(missing_ok=True)


def village(main, s_dam):
    """Footprints along three streets of the left bank, some 3 km of river below the dam."""
    random = np.random.default_rng(SEED + 1)
    features = []
    for street, offset in enumerate((60.0, 105.0, 155.0, 205.0)):
        for chainage in np.arange(s_dam + 2950.0, s_dam + 3550.0, 34.0):
            if random.random() < 0.22:
                continue
            k = np.searchsorted(main.chainage, chainage)
            t = main.line[k + 1] - main.line[k - 1]
            t /= np.hypot(*t)
            n = np.array([-t[1], t[0]])
            centre = main.line[k] + n * (offset + random.uniform(-5.0, 5.0))
            half = np.array([random.uniform(6.0, 11.0), random.uniform(5.0, 8.0)])
            if street == 1 and abs(chainage - s_dam - 3222.0) < 20.0:
                half = np.array([17.0, 9.0])
            corners = [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]
            ring = [tuple((centre + t * half[0] * a + n * half[1] * b).tolist()) for a, b in corners]
            features.append(("Polygon", [ring], {"kind": "building", "street": street + 1}))
    return features


def main():
    axis = main_valley_axis()
    z, s_dam = make_terrain(axis)
    write_raster(z)

    dam_column = int(DAM_X / CELL)
    gorge = z[:, dam_column - 1 : dam_column + 1].max(axis=1)
    river_row = int(z[150:260, dam_column].argmin()) + 150
    level = round(float(z[river_row, dam_column]) + DAM_HEIGHT)
    upstream = z.copy()
    upstream[:, dam_column:] = np.inf
    lake = flooded_from((river_row, dam_column - 1), upstream < level)
    wider = flooded_from((river_row, dam_column - 1), upstream < level + 2.0)
    assert not (wider[0].any() or wider[-1].any() or wider[:, 0].any()), "the reservoir reaches the edge of the raster"

    grown = lake.copy()
    for _ in range(3):  # 30 m beyond the shore, so that the rim of the polygon lies on dry ground
        p = np.pad(grown, 1)
        grown = p[1:-1, 1:-1] | p[:-2, 1:-1] | p[2:, 1:-1] | p[1:-1, :-2] | p[1:-1, 2:]
    grown[:, dam_column:] = False
    ring = boundary(grown)
    on_dam = [i for i, (px, _) in enumerate(ring) if px == DAM_X]
    ys = [ring[i][1] for i in on_dam]
    start = on_dam[int(np.argmax(ys))]
    ring = ring[start:] + ring[:start]  # from the northern end of the dam round the lake to the southern end
    if ring[1][0] == DAM_X:
        ring = [ring[0]] + ring[:0:-1]
    end = [i for i, p in enumerate(ring) if p == (DAM_X, min(ys))][0]
    ring = simplify(ring[: end + 1], 9.0)
    volume = ((level - z)[lake]).sum() * CELL**2
    geojson("reservoir.geojson", [("Polygon", [ring + [ring[0]]], {"name": "Lindsee", "level_m": level})])

    north = river_row + int(np.argmax(gorge[river_row:] > level + 4.0))
    south = river_row - int(np.argmax(gorge[river_row::-1] > level + 4.0))
    assert min(ys) > south * CELL - 40.0 and max(ys) < north * CELL + 40.0
    dam = [(DAM_X, min(south * CELL, min(ys))), (DAM_X, max((north + 1) * CELL, max(ys)))]
    geojson("dam_line.geojson", [("LineString", dam, {"name": "dam axis", "crest_m": level + 2})])

    inside = (axis.line[:, 0] >= 0.0) & (axis.line[:, 0] <= COLUMNS * CELL)
    t = np.gradient(axis.line, axis=0)
    t /= np.hypot(*t.T)[:, None]
    width = half_floor(axis.chainage, s_dam)
    river = axis.line + np.column_stack([-t[:, 1], t[:, 0]]) * (0.22 * width * np.sin(axis.chainage / 170.0))[:, None]
    geojson("river.geojson", [("LineString", simplify([tuple(p) for p in river[inside].tolist()], 2.0), {"name": "Linda"})])
    houses = village(axis, s_dam)
    geojson("village.geojson", houses)

    def at(chainage, offset):
        k = np.searchsorted(axis.chainage, s_dam + chainage)
        n = np.array([-t[k, 1], t[k, 0]])
        return axis.line[k] + n * offset

    def in_river(chainage):
        k = np.searchsorted(axis.chainage, s_dam + chainage)
        return river[k]

    gauges = [
        ("G1", in_river(120.0), "Dam foot"),
        ("G2", in_river(1300.0), "Bend"),
        ("G3", in_river(2600.0), "Village bridge"),
        ("G4", at(3222.0, 75.0), "Village square"),
        ("G5", at(3430.0, 215.0), "School"),
        ("G6", in_river(6150.0), "Outlet"),
    ]
    rows = ["id,x,y,name"] + [f"{i},{WEST + p[0]:.1f},{SOUTH + p[1]:.1f},{name}" for i, p, name in gauges]
    (FOLDER / "gauges.csv").write_text("\n".join(rows) + "\n")

    print(f"river at the dam {z[river_row, dam_column]:.2f} m, level {level} m, length of the dam {dam[1][1] - dam[0][1]:.0f} m")
    print(f"reservoir {lake.sum() * CELL**2 / 1e6:.3f} km2, {volume / 1e6:.3f} million m3, greatest depth {level - z[lake].min():.1f} m")
    print(f"terrain {z.min():.1f} to {z.max():.1f} m; reservoir polygon with {len(ring)} corners; {len(houses)} buildings")
    for i, p, name in gauges:
        print(i, name, f"{z[int(p[1] / CELL), int(p[0] / CELL)]:.2f} m, {np.hypot(*(p - axis.line[np.searchsorted(axis.chainage, s_dam)])):.0f} m from the dam")


main()
