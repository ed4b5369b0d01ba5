//! Rasters in NetCDF files: axes that do not count in metres, and values that the file itself calls invalid.

use super::scene::{Scene, Tiff, basin_elevation, raster_layer, sourced};
use crate::error::{Problem, ProblemKind, Severity};
use crate::math::Vec2;
use crate::prepare::{Prepared, prepare};
use crate::scenario::CrsChoice;

/// A NetCDF file with the elevations of the basin.
struct Made {
    /// Names of the axes to the north and to the east.
    axes: [&'static str; 2],
    units: Option<&'static str>,
    /// Whether the axes have a `standard_name`.
    is_named: bool,
    /// Metres of a unit of the axes.
    unit: f64,
    /// Attributes of the elevations.
    bounds: Vec<(&'static str, Vec<f32>)>,
    /// Elevation (m) of the south-western and of the north-eastern cell.
    corners: [f32; 2],
}

const SOUND: Made =
    Made { axes: ["y", "x"], units: Some("m"), is_named: true, unit: 1.0, bounds: Vec::new(), corners: [20.0, 20.0] };

impl Made {
    /// A sound scene with this terrain.
    fn scene(&self) -> Scene {
        let mut scene = Scene::sound();
        let path = scene.path("dem.nc");
        let mut file = netcdf::create(&path).unwrap();
        let places = [
            (0..30).map(|row| 2002.5 + 5.0 * f64::from(row)).collect::<Vec<f64>>(),
            (0..40).map(|column| 1002.5 + 5.0 * f64::from(column)).collect(),
        ];
        for (name, places) in self.axes.iter().zip(&places) {
            let values: Vec<f64> = places.iter().map(|place| place / self.unit).collect();
            file.add_dimension(name, values.len()).unwrap();
            let mut axis = file.add_variable::<f64>(name, &[name]).unwrap();
            if let Some(units) = self.units {
                axis.put_attribute("units", units).unwrap();
            }
            if self.is_named {
                let way = if *name == "x" { "x" } else { "y" };
                axis.put_attribute("standard_name", format!("projection_{way}_coordinate")).unwrap();
            }
            axis.put_values(&values, ..).unwrap();
        }
        let [rows, columns] = &places;
        let cells = rows.iter().flat_map(|y| columns.iter().map(|x| Vec2::new(*x, *y)));
        let mut values: Vec<f32> = cells.map(|place| basin_elevation(place) as f32).collect();
        (values[0], values[30 * 40 - 1]) = (self.corners[0], self.corners[1]);
        let mut elevation = file.add_variable::<f32>("elevation", &self.axes).unwrap();
        for (name, values) in &self.bounds {
            if let [value] = values[..] {
                elevation.put_attribute(name, value).unwrap();
            } else {
                elevation.put_attribute(name, values.clone()).unwrap();
            }
        }
        elevation.put_values(&values, ..).unwrap();
        file.close().unwrap();
        scene.scenario.layers = vec![sourced("terrain.layers[0].raster", raster_layer(path))];
        scene
    }
}

/// The only finding, an error at the terrain.
#[track_caller]
fn refused(scene: &Scene, code: &str) -> Problem {
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems.len(), 1, "{:#?}", prepared.problems);
    let problem = prepared.problems[0].clone();
    assert_eq!(
        (problem.severity, problem.kind, problem.code, problem.key.as_str()),
        (Severity::Error, ProblemKind::Input, code, "terrain.layers[0].raster")
    );
    assert!(problem.cause.is_some() || problem.remedy.is_some(), "{problem}");
    problem
}

fn terrain_cells(prepared: &Prepared) -> usize {
    prepared.bed.as_ref().unwrap().elevation.iter().filter(|z| !z.is_nan()).count()
}

#[test]
fn axes_in_metres_are_the_terrain_as_it_is() {
    for units in [Some("m"), Some("metre"), None] {
        let prepared = prepare(&Made { units, ..SOUND }.scene().scenario);
        assert_eq!(prepared.problems, []);
        assert_eq!(terrain_cells(&prepared), 1200);
    }
    let problem = refused(&Made { is_named: false, ..SOUND }.scene(), "no-georeference");
    assert!(problem.remedy.as_ref().unwrap().contains("standard_name,x,o,c,projection_x_coordinate"), "{problem}");
}

#[test]
fn axes_in_degrees_without_a_reference_system_are_refused() {
    for units in [Some("degrees"), None] {
        let made = Made { axes: ["lat", "lon"], units, is_named: false, unit: 1e5, ..SOUND };
        let mut scene = made.scene();
        for choice in [CrsChoice::Local, CrsChoice::FromTerrain, CrsChoice::Named("EPSG:25832".to_owned())] {
            // What lies in other files has no reference system of its own here.
            scene.scenario.initial.clear();
            scene.scenario.outputs.gauges = None;
            scene.scenario.crs.value = choice;
            let problem = refused(&scene, "geographic-crs");
            assert!(problem.message.contains("`lat`") && problem.message.contains("degrees"), "{problem}");
            assert!(problem.cause.unwrap().contains("`grid_mapping`"));
            assert!(problem.remedy.unwrap().contains("grid_mapping_name"));
        }
    }
}

#[test]
fn axes_in_kilometres_are_refused_with_the_way_to_metres() {
    for is_named in [true, false] {
        let problem = refused(&Made { units: Some("km"), unit: 1000.0, is_named, ..SOUND }.scene(), "not-metric-crs");
        assert!(problem.message.contains("`y`") && problem.message.contains("`km`"), "{problem}");
        assert!(problem.remedy.unwrap().contains("y=y*1000;y@units=\"m\";x=x*1000;x@units=\"m\""));
    }
    // A reference system in kilometres, of any format.
    let tiff = Tiff {
        geo_transform: Some([500.0, 0.005, 0.0, 5300.0, 0.0, -0.005]),
        crs: Some("+proj=utm +zone=32 +ellps=GRS80 +units=km +type=crs"),
        ..Tiff::default()
    };
    let mut scene = Scene::sound();
    tiff.write(&scene.path("dem.tif"), |_, _| 1.0_f32);
    scene.scenario.initial.clear();
    scene.scenario.outputs.gauges = None;
    for choice in [CrsChoice::Local, CrsChoice::FromTerrain] {
        scene.scenario.crs.value = choice;
        let problem = refused(&scene, "not-metric-crs");
        assert!(problem.remedy.as_ref().unwrap().contains("crs: EPSG:32632"), "{problem}");
    }
}

#[test]
fn values_beyond_the_bounds_of_the_file_are_no_data() {
    for (bounds, cells) in [
        (vec![], 1200),
        (vec![("valid_max", vec![9000.0])], 1199),
        (vec![("valid_min", vec![-500.0])], 1199),
        (vec![("valid_min", vec![-500.0]), ("valid_max", vec![9000.0])], 1198),
        (vec![("valid_range", vec![-500.0, 9000.0])], 1198),
        // The greatest value is the bound itself, which has no short text.
        (vec![("valid_max", vec![9990.1])], 1200),
    ] {
        let told = format!("{bounds:?}");
        let prepared = prepare(&Made { bounds, corners: [-5000.0, 9990.1], ..SOUND }.scene().scenario);
        assert_eq!(terrain_cells(&prepared), cells, "{told}: {:#?}", prepared.problems);
    }
}
