"""Opens a run folder in QGIS: both NetCDF files as mesh layers, every COG and layer with the style that lies with it.

usage: read_in_qgis.py FOLDER (EPSG | local)        with a Python that has QGIS (Debian: python3-qgis)
"""

import pathlib
import sys

from qgis.core import Qgis, QgsApplication, QgsMeshLayer, QgsRasterLayer, QgsVectorLayer

folder = pathlib.Path(sys.argv[1])
crs = "" if sys.argv[2] == "local" else f"EPSG:{sys.argv[2]}"
application = QgsApplication([], False)
application.initQgis()

for name, groups in [("fields.nc", 3), ("maps.nc", 16)]:
    mesh = QgsMeshLayer(str(folder / name), name, "mdal")
    assert mesh.isValid(), f"{name} is no valid mesh"
    assert mesh.crs().authid() == crs, f"{name}: {mesh.crs().authid()} instead of {crs}"
    provider = mesh.dataProvider()
    found = [provider.datasetGroupMetadata(index) for index in range(provider.datasetGroupCount())]
    names = [group.name() for group in found]
    assert len(names) == groups, f"{name}: {names}"
    if name == "fields.nc":
        velocity = found[names.index("velocity")]
        assert velocity.isVector(), "the components of velocity are not joined"
        assert provider.datasetCount(names.index("velocity")) == 7, "frames are missing"
        assert velocity.referenceTime().isValid(), "the reference time is not understood"

for path in sorted(folder.glob("cog/*.tif")):
    raster = QgsRasterLayer(str(path), path.stem)
    assert raster.isValid() and raster.crs().authid() == crs, f"{path.name}: {raster.crs().authid()}"
    _, loaded = raster.loadDefaultStyle()
    kind = "paletted" if path.stem == "hazard_class" else "singlebandpseudocolor"
    assert loaded and raster.renderer().type() == kind, f"{path.name}: drawn as {raster.renderer().type()}"

for name, kind in [("inundation_extent", "singleSymbol"), ("isochrones", "categorizedSymbol"),
                   ("gauges", "singleSymbol"), ("findings", "singleSymbol")]:
    layer = QgsVectorLayer(f"{folder / 'results.gpkg'}|layername={name}", name, "ogr")
    assert layer.isValid() and layer.crs().authid() == crs, f"{name}: {layer.crs().authid()}"
    _, loaded = layer.loadDefaultStyle()
    assert loaded and layer.renderer().type() == kind, f"{name}: drawn as {layer.renderer().type()}"

print(f"QGIS {Qgis.QGIS_VERSION} opens {folder.name}")
