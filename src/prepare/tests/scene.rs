//! A tiny made scenario in a folder of its own: a basin in a plateau, a reservoir in it, and gauges.

use std::path::{Path, PathBuf};

use gdal::DriverManager;
use gdal::raster::{Buffer, GdalType};
use tempfile::TempDir;

use crate::math::Vec2;
use crate::prepare::{Prepared, Setup};
use crate::scenario::methods::{
    BedMethod, BedSlope, Formulation, Integrator, Kernel, Motion, Reconstruction, Seeding, Stabilisation,
};
use crate::scenario::*;
use crate::solver::FlowProblem;

/// The problem of a scenario that can be run.
pub(super) fn flow_problem(scenario: &Scenario, prepared: Prepared) -> FlowProblem {
    let Setup { bed, still_water, scene, .. } = prepared.setup.unwrap();
    FlowProblem {
        bed,
        walls: scene.walls,
        open_edges: scene.open_edges,
        forcing: scene.forcing,
        initial_depth: still_water.depth,
        gravity: scenario.numerics.gravity,
        courant: scenario.numerics.cfl,
        dry_depth: scenario.numerics.dry_depth,
    }
}

/// A value with a key and no place.
pub(super) fn sourced<T>(key: &str, value: T) -> Sourced<T> {
    Sourced { value, key: key.to_string(), place: None }
}

pub(super) fn vector(key: &str, path: impl Into<PathBuf>) -> Sourced<VectorSource> {
    sourced(key, VectorSource { path: path.into(), layer: None })
}

/// All outputs on cells of the resolution (m).
fn outputs(resolution: f64) -> Outputs {
    Outputs {
        folder: sourced("outputs.folder", PathBuf::from("out")),
        write: OutputPart::ALL.to_vec(),
        maps_on_terrain: None,
        cell: resolution,
        every: 1.0,
        gauges_every: 1.0,
        sections: None,
        gauges: None,
        thresholds: vec![0.01],
        rise_on_wet: 0.05,
        isochrones: Vec::new(),
        error_estimate: false,
    }
}

/// A scenario without inputs.
pub(super) fn scenario(resolution: f64) -> Scenario {
    Scenario {
        file: PathBuf::from("scenario.yaml"),
        title: "made".to_string(),
        crs: sourced("crs", CrsChoice::Local),
        layers: Vec::new(),
        reproject: false,
        ground: Ground::default(),
        roughness: Roughness::uniform(0.03),
        initial: Vec::new(),
        start: Start::default(),
        walls: Vec::new(),
        open: Vec::new(),
        boundaries: Vec::new(),
        closed: Vec::new(),
        sources: Vec::new(),
        rain: None,
        breach: None,
        moving_bed: Vec::new(),
        channels: Vec::new(),
        tracers: Vec::new(),
        resolution: sourced("resolution", resolution),
        levels: None,
        auto: None,
        reading: crate::scenario::Reading::default(),
        end_time: 10.0,
        reference_time: None,
        outputs: outputs(resolution),
        numerics: Numerics {
            formulation: Formulation::default(),
            motion: Motion::default(),
            stabilisation: Stabilisation::default(),
            reconstruction: Reconstruction::default(),
            seeding: Seeding::default(),
            kernel: Kernel::default(),
            bed_slope: BedSlope::default(),
            turbulence: crate::scenario::methods::Turbulence::default(),
            wall: crate::scenario::methods::WallMethod::default(),
            integrator: Integrator::default(),
            bed: BedMethod::default(),
            cfl: 0.4,
            gravity: 9.81,
            dry_depth: 1e-6,
            constants: crate::scenario::Constants::DEFAULT,
            sleeps: true,
        },
        limits: Limits { memory: 4e9, disk: None, particles: 5e7, checkpoint: None, allow_remote: false },
    }
}

pub(super) fn raster_layer(path: impl Into<PathBuf>) -> TerrainLayer {
    TerrainLayer::Raster { path: path.into(), offset: 0.0, unit: None, clip: None, mode: LayerMode::default() }
}

/// How a made raster is written.
pub(super) struct Tiff<'a> {
    pub size: (usize, usize),
    pub geo_transform: Option<[f64; 6]>,
    pub crs: Option<&'a str>,
    pub no_data: Option<f64>,
    pub scale_offset: Option<(f64, f64)>,
    pub bands: usize,
}

impl Default for Tiff<'_> {
    fn default() -> Self {
        Tiff {
            size: (40, 30),
            geo_transform: Some([1000.0, 5.0, 0.0, 2150.0, 0.0, -5.0]),
            crs: None,
            no_data: None,
            scale_offset: None,
            bands: 1,
        }
    }
}

impl Tiff<'_> {
    /// Writes a GeoTIFF; `value` gets column and row from the upper left.
    pub fn write<T: GdalType + Copy>(&self, path: &Path, value: impl Fn(usize, usize) -> T) {
        let (columns, rows) = self.size;
        let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
        let mut dataset = driver.create_with_band_type::<T, _>(path, columns, rows, self.bands).unwrap();
        if let Some(geo_transform) = self.geo_transform {
            dataset.set_geo_transform(&geo_transform).unwrap();
        }
        if let Some(crs) = self.crs {
            dataset.set_spatial_ref(&gdal::spatial_ref::SpatialRef::from_definition(crs).unwrap()).unwrap();
        }
        let mut band = dataset.rasterband(1).unwrap();
        band.set_no_data_value(self.no_data).unwrap();
        if let Some((scale, offset)) = self.scale_offset {
            band.set_scale(scale).unwrap();
            band.set_offset(offset).unwrap();
        }
        let values =
            (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))).map(|(c, r)| value(c, r)).collect();
        band.write((0, 0), (columns, rows), &mut Buffer::new((columns, rows), values)).unwrap();
        dataset.close().unwrap();
    }
}

/// A folder with `dem.tif`: 200 m by 150 m in cells of 5 m, plateau at 20 m, a basin with its floor at 0 m from (1050, 2050)
/// to (1100, 2100), and a notch at 6 m in its eastern rim.
pub(super) struct Scene {
    pub folder: TempDir,
    pub scenario: Scenario,
}

pub(super) fn basin_elevation(place: Vec2) -> f64 {
    let Vec2 { x, y } = place;
    if (1050.0..1100.0).contains(&x) && (2050.0..2100.0).contains(&y) {
        0.0
    } else if (1100.0..1120.0).contains(&x) && (2070.0..2075.0).contains(&y) {
        6.0
    } else {
        20.0
    }
}

pub(super) fn centre_of(column: usize, row: usize) -> Vec2 {
    Vec2::new(1002.5 + 5.0 * column as f64, 2147.5 - 5.0 * row as f64)
}

impl Scene {
    /// The basin with a reservoir at 5 m, below the notch, and one gauge: nothing is wrong with it.
    pub fn sound() -> Scene {
        let folder = tempfile::tempdir().unwrap();
        let mut scene = Scene { folder, scenario: scenario(5.0) };
        Tiff { no_data: Some(-9999.0), ..Tiff::default() }
            .write(&scene.path("dem.tif"), |c, r| basin_elevation(centre_of(c, r)) as f32);
        scene.scenario.layers = vec![sourced("terrain.layers[0].raster", raster_layer(scene.path("dem.tif")))];
        scene.polygon("reservoir.geojson", &[(1045.0, 2045.0), (1100.0, 2045.0), (1100.0, 2105.0), (1045.0, 2105.0)]);
        scene.fill("reservoir.geojson", Some(5.0));
        scene.write("gauges.csv", "id,x,y,kind\nA,1075,2075,lake\n\"B, below\",1150,2072,\n");
        scene.scenario.outputs.gauges = Some(vector("outputs.gauges", scene.path("gauges.csv")));
        scene
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Writes a GeoJSON polygon without attributes.
    pub fn polygon(&self, name: &str, corners: &[(f64, f64)]) {
        self.polygon_with(name, corners, "{}");
    }

    pub fn polygon_with(&self, name: &str, corners: &[(f64, f64)], properties: &str) {
        let ring: Vec<String> = corners.iter().chain(corners.first()).map(|(x, y)| format!("[{x},{y}]")).collect();
        let geometry = format!(r#"{{"type":"Polygon","coordinates":[[{}]]}}"#, ring.join(","));
        self.feature(name, &geometry, properties);
    }

    pub fn line(&self, name: &str, places: &[(f64, f64)]) {
        let places: Vec<String> = places.iter().map(|(x, y)| format!("[{x},{y}]")).collect();
        self.feature(name, &format!(r#"{{"type":"LineString","coordinates":[{}]}}"#, places.join(",")), "{}");
    }

    /// Writes a GeoJSON line whose places have a third coordinate.
    pub fn line_with_heights(&self, name: &str, places: &[(f64, f64, f64)]) {
        let places: Vec<String> = places.iter().map(|(x, y, z)| format!("[{x},{y},{z}]")).collect();
        self.feature(name, &format!(r#"{{"type":"LineString","coordinates":[{}]}}"#, places.join(",")), "{}");
    }

    /// Writes GeoJSON lines, each with its attributes.
    pub fn lines_with(&self, name: &str, lines: &[(&[(f64, f64)], &str)]) {
        let one = |(places, properties): &(&[(f64, f64)], &str)| {
            let places: Vec<String> = places.iter().map(|(x, y)| format!("[{x},{y}]")).collect();
            format!(
                r#"{{"type":"Feature","properties":{properties},"geometry":{{"type":"LineString","coordinates":[{}]}}}}"#,
                places.join(",")
            )
        };
        let features: Vec<String> = lines.iter().map(one).collect();
        self.write(name, &format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(",")));
    }

    fn feature(&self, name: &str, geometry: &str, properties: &str) {
        self.write(
            name,
            &format!(r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{properties},"geometry":{geometry}}}]}}"#),
        );
    }

    /// Adds a body of water.
    pub fn fill(&mut self, name: &str, level: Option<f64>) {
        let key = format!("initial[{}]", self.scenario.initial.len());
        self.scenario.initial.push(InitialWater {
            polygons: vector(&format!("{key}.reservoir"), self.path(name)),
            level: level.map(|level| sourced(&format!("{key}.level"), level)),
            level_field: None,
        });
    }
}
