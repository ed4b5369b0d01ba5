//! The reservoir of Malpasset and the sea before it: 48.95 million cubic metres at 100 m in the 10 m raster.

use std::path::{Path, PathBuf};

use geo::MultiPolygon;

use super::tests::assert_consistent;
use super::*;
use crate::bed::place_bed;
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::scenario::methods::BedMethod;
use crate::terrain::{Layer, RasterFile, RasterRequest, Terrain};
use crate::vector;

/// The terrain of a file.
struct Real(Terrain);

impl Surface for Real {
    fn elevation(&self, map: Vec2) -> Option<f64> {
        self.0.elevation(map)
    }

    fn samples(&self, centre: Vec2, radius: f64, out: &mut Vec<(Vec2, f64)>) {
        self.0.samples(centre, radius, out);
    }
}

/// The folder of the case, if there is one.
fn folder() -> Option<PathBuf> {
    let data = std::env::var_os("FLOODSIM_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    Some(data.join("malpasset")).filter(|folder| folder.is_dir())
}

/// A raster of the case, and the lattice over it.
fn terrain(path: &Path, spacing: f64) -> (Real, Lattice) {
    let request = RasterRequest { path, unit: 1.0, offset: 0.0, reproject: false, resolution: spacing, memory: 1e10 };
    let (raster, _) = RasterFile::open(path).unwrap().read(&request, &Crs::Local).unwrap();
    let lattice = Lattice {
        origin: Vec2::new(raster.west, raster.south()),
        columns: ((raster.east() - raster.west) / spacing) as usize,
        rows: ((raster.north - raster.south()) / spacing) as usize,
        spacing,
    };
    (Real(Terrain::new(vec![Layer::Raster(raster)]).unwrap()), lattice)
}

fn body(path: &Path, level: f64) -> StillBody {
    let features = vector::open(path, None).unwrap().features;
    StillBody { polygon: MultiPolygon(features.into_iter().flat_map(|feature| feature.polygons).collect()), level }
}

#[test]
fn reservoir_holds_its_49_million_cubic_metres() {
    let Some(folder) = folder() else {
        eprintln!("skipped: FLOODSIM_DATA names no folder with the case malpasset");
        return;
    };
    let bodies = [body(&folder.join("reservoir.geojson"), 100.0), body(&folder.join("sea.geojson"), 0.0)];
    let dam_lines = vector::open(&folder.join("dam_line.geojson"), None).unwrap().features.remove(0).lines;
    for (file, spacing, method) in [
        ("dem_10m.tif", 10.0, BedMethod::Pointwise),
        ("dem_10m.tif", 10.0, BedMethod::Shepard),
        ("dem_20m.tif", 20.0, BedMethod::Pointwise),
        ("dem_20m.tif", 20.0, BedMethod::Shepard),
    ] {
        let (surface, lattice) = terrain(&folder.join(file), spacing);
        let local = |c: geo::Coord<f64>| lattice.to_local(Vec2::new(c.x, c.y));
        let dam: Vec<[Vec2; 2]> =
            dam_lines.iter().flat_map(|line| line.lines()).map(|line| [local(line.start), local(line.end)]).collect();
        let placed = place_bed(&surface, &lattice, method, 0.033);
        for walls in [&[][..], &dam] {
            let mut bed = placed.clone();
            let still = fill_still_water(&bodies, &mut bed, &surface, walls);
            let [reservoir, sea] = &still.volumes[..] else { unreachable!("two bodies") };
            for (name, books) in [("reservoir", reservoir), ("sea", sea)] {
                println!(
                    "{spacing} m {method:?}, {} walls, {name}: {:+.4} %, {} cells, {} pockets, {} toggled, {} at the shore changed by up to {:.2} m, the others by {:.2} m",
                    walls.len(),
                    100.0 * books.relative_error(),
                    books.cells,
                    books.pocket_cells,
                    books.toggled,
                    books.shore_cells,
                    books.largest_bed_change_at_shore,
                    books.largest_bed_change_under_water
                );
            }
            // The 20 m raster is the same survey, resampled.
            assert!((reservoir.integral_m3 / 48.95e6 - 1.0).abs() < 2e-3, "{reservoir:?}");
            assert!(reservoir.is_within_tolerance(), "{reservoir:?}");
            assert!(sea.is_within_tolerance(), "{sea:?}");
            // The dam line is where the reservoir ends in open water, and the only place.
            assert_eq!((reservoir.leaks.len(), sea.leaks.len()), (usize::from(walls.is_empty()), 0));
            assert_consistent(&bed, &still, &bodies);
        }
    }
}
