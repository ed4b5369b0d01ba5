//! Rasters in NetCDF files: axes that do not count in metres, and values that the file itself calls invalid.

mod places;

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
    /// Unit of the elevations.
    height_units: Option<&'static str>,
    /// Scale by which the elevations are packed to two bytes.
    packed: Option<f32>,
    /// Attribute `grid_mapping`, of UTM in zone 32.
    has_system: bool,
    /// Whether the file has a second variable, `error`.
    is_double: bool,
    /// Elevation (m) of the south-western and of the north-eastern cell.
    corners: [f32; 2],
}

const SOUND: Made = Made {
    axes: ["y", "x"],
    units: Some("m"),
    is_named: true,
    unit: 1.0,
    bounds: Vec::new(),
    height_units: None,
    packed: None,
    has_system: false,
    is_double: false,
    corners: [20.0, 20.0],
};

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
                let way = if ["x", "lon"].contains(name) { "x" } else { "y" };
                axis.put_attribute("standard_name", format!("projection_{way}_coordinate")).unwrap();
            }
            axis.put_values(&values, ..).unwrap();
        }
        let [rows, columns] = &places;
        let cells = rows.iter().flat_map(|y| columns.iter().map(|x| Vec2::new(*x, *y)));
        let mut values: Vec<f32> = cells.map(|place| basin_elevation(place) as f32).collect();
        (values[0], values[30 * 40 - 1]) = (self.corners[0], self.corners[1]);
        if self.has_system {
            let mut system = file.add_variable::<i32>("crs", &[]).unwrap();
            let wkt = gdal::spatial_ref::SpatialRef::from_epsg(25832).unwrap().to_wkt().unwrap();
            system.put_attribute("grid_mapping_name", "transverse_mercator").unwrap();
            system.put_attribute("crs_wkt", wkt).unwrap();
        }
        if self.is_double {
            file.add_variable::<f32>("error", &self.axes).unwrap().put_values(&values, ..).unwrap();
        }
        let mut elevation = match self.packed {
            Some(_) => file.add_variable::<i16>("elevation", &self.axes).unwrap(),
            None => file.add_variable::<f32>("elevation", &self.axes).unwrap(),
        };
        if let Some(scale) = self.packed {
            elevation.put_attribute("scale_factor", scale).unwrap();
            values.iter_mut().for_each(|value| *value = (*value / scale).round());
        }
        if let Some(units) = self.height_units {
            elevation.put_attribute("units", units).unwrap();
        }
        if self.has_system {
            elevation.put_attribute("grid_mapping", "crs").unwrap();
        }
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
    prepared.setup().bed.elevation.iter().filter(|z| !z.is_nan()).count()
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
        let reported = format!("{bounds:?}");
        let prepared = prepare(&Made { bounds, corners: [-5000.0, 9990.1], ..SOUND }.scene().scenario);
        assert_eq!(terrain_cells(&prepared), cells, "{reported}: {:#?}", prepared.problems);
    }
}

#[test]
fn dimensions_in_the_wrong_order_are_refused() {
    for axes in [["x", "y"], ["lon", "lat"]] {
        let problem = refused(&Made { axes, ..SOUND }.scene(), "axes-swapped");
        let remedy = format!("`ncpdq -a {},{} IN OUT`", axes[1], axes[0]);
        assert!(problem.remedy.as_ref().unwrap().contains(&remedy), "{problem}");
    }
}

#[test]
fn axes_in_any_other_unit_are_refused() {
    for units in [
        "US_survey_foot",
        "yd",
        "nautical_mile",
        "dm",
        "hm",
        "mm",
        "Mm",
        "degN",
        "arc_second",
        "rad",
        "m2",
        "pixels",
        "1000 m",
        "1",
    ] {
        let problem = refused(&Made { units: Some(units), ..SOUND }.scene(), "not-metric-crs");
        assert!(problem.message.contains("`y`") && problem.message.contains(&format!("`{units}`")), "{problem}");
        assert!(problem.cause.is_some() && problem.remedy.is_some(), "{problem}");
    }
    let mut scene = Made { has_system: true, ..SOUND }.scene();
    scene.scenario.crs.value = CrsChoice::FromTerrain;
    scene.scenario.initial.clear();
    scene.scenario.outputs.gauges = None;
    let prepared = prepare(&scene.scenario);
    assert!(!prepared.has_errors(), "{:#?}", prepared.problems);
    for units in ["yd", "rad", "pixels", "degrees"] {
        let mut scene = Made { units: Some(units), has_system: true, ..SOUND }.scene();
        scene.scenario.crs.value = CrsChoice::FromTerrain;
        let found = prepare(&scene.scenario).problems;
        let problem = found.iter().find(|problem| problem.code == "axis-unit");
        let problem = problem.unwrap_or_else(|| panic!("{units}: {found:#?}"));
        assert!(problem.message.contains(&format!("`{units}`")) && problem.message.contains("etre"), "{problem}");
    }
}

#[test]
fn heights_in_another_unit_than_the_scenario_says_are_refused() {
    for units in ["ft", "cm", "km", "fathom"] {
        let scene = Made { height_units: Some(units), ..SOUND }.scene();
        let problem = refused(&scene, "unit-of-elevation");
        assert!(problem.message.contains(&format!("`{units}`")), "{problem}");
        assert_eq!(problem.remedy.unwrap().contains("say `unit: "), ["ft", "cm"].contains(&units), "{units}");
    }
    for (units, unit) in [("m", 1.0), ("Meters", 1.0), ("cm", 0.01), ("ft", 0.3048), ("US_survey_foot", 0.3048)] {
        let mut scene = Made { height_units: Some(units), ..SOUND }.scene();
        let crate::scenario::TerrainLayer::Raster { unit: own, .. } = &mut scene.scenario.layers[0].value else {
            panic!("the layer is no raster")
        };
        *own = Some(unit);
        let problems = prepare(&scene.scenario).problems;
        assert!(!problems.iter().any(|problem| problem.code == "unit-of-elevation"), "{units}: {problems:#?}");
    }
}

#[test]
fn a_bound_in_a_wider_type_than_packed_values_is_one_of_the_values() {
    for (bounds, cells) in [
        (vec![("valid_max", vec![300.0])], 1199),
        // As stored: 300 / 0.01.
        (vec![("valid_max", vec![299.999])], 1198),
        (vec![("valid_range", vec![-100.0, 300.0])], 1198),
        (vec![("valid_min", vec![-100.0])], 1199),
    ] {
        let reported = format!("{bounds:?}");
        let made = Made { bounds, packed: Some(0.01), corners: [-200.0, 320.0], ..SOUND };
        let mut scene = made.scene();
        let path = scene.path("dem.nc");
        let mut file = netcdf::append(&path).unwrap();
        file.variable_mut("elevation").unwrap().put_value(30_000_i16, [3, 3]).unwrap();
        file.close().unwrap();
        scene.scenario.initial.clear();
        let prepared = prepare(&scene.scenario);
        assert_eq!(terrain_cells(&prepared), cells, "{reported}: {:#?}", prepared.problems);
        let warning = prepared.problems.iter().find(|problem| problem.code == "outside-valid-range").unwrap();
        assert!(
            warning.message.contains("valid_") && warning.message.starts_with(&(1200 - cells).to_string()),
            "{warning}"
        );
    }
}

#[test]
fn a_bound_in_the_type_of_packed_values_is_one_of_the_packed() {
    let mut scene = Made { packed: Some(0.01), corners: [20.0, 320.0], ..SOUND }.scene();
    let mut file = netcdf::append(scene.path("dem.nc")).unwrap();
    file.variable_mut("elevation").unwrap().put_attribute("valid_max", 31_999_i16).unwrap();
    file.close().unwrap();
    scene.scenario.initial.clear();
    let prepared = prepare(&scene.scenario);
    assert_eq!(terrain_cells(&prepared), 1199);
    let reported = |problem: &Problem| problem.message.contains("`valid_max = 31999 as a packed number`");
    assert!(prepared.problems.iter().any(reported), "{:#?}", prepared.problems);
}

#[test]
fn a_bound_that_leaves_nothing_is_named() {
    let problem = refused(&Made { bounds: vec![("valid_max", vec![-8000.0])], ..SOUND }.scene(), "all-nodata");
    assert!(problem.cause.as_ref().unwrap().contains("`valid_max = -8000`"), "{problem}");
}

#[test]
fn one_of_several_variables_is_named_behind_a_colon() {
    let mut scene = Made { is_double: true, ..SOUND }.scene();
    let problem = refused(&scene, "no-variable");
    assert!(problem.cause.as_ref().unwrap().contains("error, elevation"), "{problem}");
    assert!(problem.remedy.unwrap().contains("`dem.nc:error`"));
    let named = |name: &str| vec![sourced("terrain.layers[0].raster", raster_layer(scene.path(name)))];
    let (sound, unknown) = (named("dem.nc:elevation"), named("dem.nc:depth"));
    scene.scenario.layers = sound;
    let prepared = prepare(&scene.scenario);
    assert_eq!((prepared.problems.as_slice(), terrain_cells(&prepared)), (&[][..], 1200));
    assert!(prepared.inputs.iter().any(|input| input.path.ends_with("dem.nc")));
    scene.scenario.layers = unknown;
    let problem = refused(&scene, "no-variable");
    assert!(problem.message.contains("`depth`") && problem.remedy.unwrap().contains("behind the colon"));
}
