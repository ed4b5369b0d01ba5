"""Opens a run folder as its users will, and complains about everything that is not as it should be.

usage: read_back.py FOLDER (EPSG | local) WEST NORTH CELL
       read_back.py FOLDER partial
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy
import rasterio
import rioxarray  # noqa: F401  (adds .rio to xarray)
import xarray
from compliance_checker.runner import CheckSuite, ComplianceChecker

FILL = -9999.0
NO_CF_PROJECTION = "None is not a valid grid_mapping_name. See Appendix F for valid grid mappings"
complaints = []


def expect(condition, message):
    if not condition:
        complaints.append(message)


def gdalinfo(source):
    result = subprocess.run(["gdalinfo", "-json", source], capture_output=True, text=True)
    expect(result.returncode == 0, f"gdalinfo {source}: {result.stderr}")
    expect(not result.stderr.strip(), f"gdalinfo {source} warns: {result.stderr}")
    return json.loads(result.stdout) if result.returncode == 0 else {}


def check_gdal(source, epsg, west, north, cell, nodata=FILL):
    info = gdalinfo(source)
    transform = info.get("geoTransform")
    expect(transform == [west, cell, 0.0, north, 0.0, -cell], f"{source}: transform {transform}")
    band = info["bands"][0]
    expect(band.get("noDataValue") == nodata, f"{source}: no data is {band.get('noDataValue')}")
    wkt = info.get("coordinateSystem", {}).get("wkt", "")
    if epsg:
        expect(wkt.rstrip().endswith(f'ID["EPSG",{epsg}]]'), f"{source}: not EPSG:{epsg} but {wkt[-200:]}")
    else:
        expect("PROJCRS" not in wkt and "GEOGCRS" not in wkt, f"{source}: plain metres became {wkt[:200]}")
    return info


def check_xarray(path, epsg, west, north, cell):
    data = xarray.open_dataset(path, decode_coords="all", decode_timedelta=False)
    expect(data.rio.crs is None if epsg is None else data.rio.crs.to_epsg() == epsg, f"{path.name}: crs {data.rio.crs}")
    transform = data.rio.transform()
    expect(
        (transform.a, transform.e, transform.c, transform.f) == (cell, -cell, west, north),
        f"{path.name}: transform {transform}",
    )
    names = [variable.attrs.get("long_name") for variable in data.variables.values()]
    names = [name for name in names if name]
    expect(len(names) == len(set(names)), f"{path.name}: two variables have the same long_name")
    return data


def check_values(maps, fields):
    outside = numpy.isnan(maps.bed_elevation.values)
    expect(outside.any() and not outside.all(), "maps.nc: no ground without terrain")
    for name in ["max_depth", "max_speed", "max_depth_velocity", "flood_duration", "hazard_class"]:
        expect((numpy.isnan(maps[name].values) == outside).all(), f"{name}: missing elsewhere than outside the terrain")
    dry = maps.max_depth.values == 0.0
    expect(dry.any(), "max_depth: no dry ground")
    for name in ["arrival_time", "max_water_level", "time_of_max_depth"]:
        expect(numpy.isnan(maps[name].values[dry]).all(), f"{name}: dry ground has a value")
        expect(not numpy.isnan(maps[name].values).all(), f"{name}: no value at all")
    expect(set(numpy.unique(maps.hazard_class.values[~outside])) <= set(range(7)), "hazard_class: unknown class")
    names = {"arrival_time_0p305m", "flood_duration_1p00m", "deflood_time_0p305m", "deflood_time"}
    expect(names <= set(maps), f"maps.nc lacks {names - set(maps)}")
    expect(fields.sizes["time"] == 7, f"fields.nc has {fields.sizes['time']} frames instead of 7")
    expect((fields.depth.dims == ("time", "y", "x")), f"depth has the dimensions {fields.depth.dims}")
    seconds = (fields.time.values - fields.time.values[0]) / numpy.timedelta64(1, "s")
    expect(list(seconds) == [0, 100, 200, 300, 400, 500, 600], f"frames are at {seconds}")
    expect(((fields.depth.values == 0.0).any()), "fields.nc: no dry ground in depth")


def check_cf(path, epsg=None, accepted=()):
    """No complaint of the CF checker but the accepted ones, not even at its lowest priority."""
    with tempfile.TemporaryDirectory() as place:
        report = pathlib.Path(place) / "report.json"
        options = {"verbose": 0, "criteria": "strict", "output_filename": str(report), "output_format": "json"}
        ComplianceChecker.run_checker(str(path), ["cf:1.11"], **options)
        for checked in json.loads(report.read_text()).values():
            expect(checked["scored_points"] > 0, f"{path.name}: the CF checker checked nothing")
            for priority in ["high_priorities", "medium_priorities", "low_priorities"]:
                for finding in checked[priority]:
                    score, full = finding["value"]
                    # CF has no name for the projection of the Dutch grid: the WKT alone carries it, and the checker minds.
                    is_known = epsg == 28992 and set(finding["msgs"]) == {NO_CF_PROJECTION}
                    is_known |= finding["name"] in accepted
                    expect(score == full or is_known, f"{path.name}: CF: {finding['name']}: {finding['msgs']}")


def check_sections(path, epsg):
    data = xarray.open_dataset(path, decode_coords="all", decode_timedelta=False)
    expect(data.rio.crs is None if epsg is None else data.rio.crs.to_epsg() == epsg, f"{path.name}: crs {data.rio.crs}")
    expect({"x", "y", "section_id"} <= set(data.coords), f"{path.name}: coordinates {set(data.coords)}")
    names = [variable.attrs.get("long_name") for name, variable in data.variables.items() if name != "crs"]
    expect(None not in names and len(names) == len(set(names)), f"{path.name}: long names {names}")
    # Two and a half cubic metres a second for ten minutes, through a straight line. Its cell, 410 m from the west and 10 m beside the axis,
    # has 0.1 m when the front, which starts at 200 m and runs 2 m a second, is 50 m beyond it.
    wanted = {"arrival_time": 130.0, "peak_discharge": 2.5, "time_of_peak": 600.0, "total_volume": 1500.0, "length": 7400.0**0.5}
    for name, value in wanted.items():
        expect(numpy.allclose(data[name].values, [value]), f"{path.name}: {name} is {data[name].values}")
    for axis, way in [("x", 50.0), ("y", 70.0)]:
        left, middle, right = (data[name].values[0] for name in [f"left_{axis}", axis, f"right_{axis}"])
        expect(numpy.allclose([middle - left, right - left], [way / 2, way]), f"{path.name}: {axis} {left} {middle} {right}")


def check_styles(folder):
    styles = sorted(folder.glob("cog/*.qml"))
    expect(len(styles) == 16, f"{len(styles)} styles instead of 16")
    for style in styles:
        ElementTree.fromstring(style.read_text().split("\n", 1)[1])


def check_cogs(folder, epsg, west, north, cell):
    for path in sorted(folder.glob("cog/*.tif")):
        is_class = path.stem == "hazard_class"
        info = check_gdal(str(path), epsg, west, north, cell, 255.0 if is_class else FILL)
        expect(info["metadata"]["IMAGE_STRUCTURE"].get("LAYOUT") == "COG", f"{path.name} is no COG")
        expect(info["bands"][0].get("description"), f"{path.name}: band without a description")
        expect(info["bands"][0].get("unit"), f"{path.name}: band without a unit")
        if is_class:
            expect(info["bands"][0].get("colorInterpretation") == "Palette", f"{path.name} has no colour table")
        with rasterio.open(path) as raster:
            expect((raster.crs is None) == (epsg is None), f"{path.name}: rasterio sees {raster.crs}")
            if epsg:
                expect(raster.crs.to_epsg() == epsg, f"{path.name}: rasterio sees {raster.crs}")


def check_qgis(folder, epsg):
    """QGIS, where the system's Python has it."""
    python = shutil.which("python3", path="/usr/local/bin:/usr/bin")
    if not python or subprocess.run([python, "-c", "import qgis.core"], capture_output=True).returncode != 0:
        print("skipped: QGIS, since python3 has no module qgis (Debian: python3-qgis)")
        return
    script = pathlib.Path(__file__).with_name("read_in_qgis.py")
    result = subprocess.run(
        [python, script, folder, str(epsg or "local")],
        capture_output=True,
        text=True,
        env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
    )
    expect(result.returncode == 0, f"QGIS: {result.stdout}{result.stderr}")
    print(result.stdout.strip())


def main():
    CheckSuite.load_all_available_checkers()
    folder = pathlib.Path(sys.argv[1])
    if sys.argv[2] == "partial":
        path = folder / "fields.partial.nc"
        info = gdalinfo(f'NETCDF:"{path}":depth')
        expect(len(info["bands"]) == 7, f"the unfinished file has {len(info['bands'])} frames")
        expect(xarray.open_dataset(path, decode_coords="all").rio.crs.to_epsg() == 32632, "the unfinished file has no CRS")
        check_cf(path)
    else:
        epsg = None if sys.argv[2] == "local" else int(sys.argv[2])
        west, north, cell = map(float, sys.argv[3:6])
        for name in ["max_depth", "arrival_time", "hazard_class"]:
            check_gdal(f'NETCDF:"{folder / "maps.nc"}":{name}', epsg, west, north, cell)
        info = check_gdal(f'NETCDF:"{folder / "fields.nc"}":depth', epsg, west, north, cell)
        expect(len(info["bands"]) == 7, f"fields.nc has {len(info['bands'])} bands")
        maps = check_xarray(folder / "maps.nc", epsg, west, north, cell)
        fields = check_xarray(folder / "fields.nc", epsg, west, north, cell)
        check_values(maps, fields)
        check_cf(folder / "maps.nc", epsg)
        check_cf(folder / "fields.nc", epsg)
        # Time comes first, as in fields.nc and channels.nc; CF recommends that stations do, and demands nothing.
        check_cf(folder / "sections.nc", epsg, accepted=["§2.4 Dimensions"])
        check_sections(folder / "sections.nc", epsg)
        check_cogs(folder, epsg, west, north, cell)
        check_styles(folder)
        check_qgis(folder, epsg)
    for complaint in complaints:
        print(f"complaint: {complaint}")
    sys.exit(bool(complaints))


main()
