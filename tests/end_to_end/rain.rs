//! Rain as a series of rasters through the whole program: NetCDF and lists of files, their times, units and gaps.

mod refused;

use std::path::PathBuf;

use netcdf::Options;
use tempfile::TempDir;

use crate::{Netcdf, assert_check, changed, floodsim, with_netcdf};

/// A closed basin of 100 m by 50 m with a slope of 2 % along it; the radar has cells of 20 m by 25 m, two rows of five.
const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
rain: {raster_series: radar.nc, start: \"2026-06-01 06:00:00\"}
resolution: 5 m
time: {end: 2 min}
outputs: {every: 30 s}
";

/// The variable of a radar, and its file.
#[derive(Clone)]
struct Radar {
    time_units: &'static str,
    times: Vec<f64>,
    bounds: Option<Vec<f64>>,
    units: &'static str,
    calendar: &'static str,
    /// Values `[time][row][column]`, row 0 in the north.
    values: Vec<[[f64; 5]; 2]>,
    /// Coordinate of the western edge.
    west: f64,
    /// Another variable of three dimensions beside the first.
    has_quality: bool,
    /// Dimensions of the variable.
    order: [&'static str; 3],
    /// Unit of the bounds, where they have one of their own, their dimensions, and the name by which the times know them.
    bounds_units: Option<&'static str>,
    bounds_shape: &'static [&'static str],
    bounds_name: &'static str,
    /// Attribute `scale_factor` of the times.
    scale_factor: Option<f64>,
    /// Units of x and y.
    axis_units: &'static str,
    /// Attribute `valid_max` of the values.
    valid_max: Option<f64>,
}

impl Radar {
    /// A minute each of rain in the west, in the east and everywhere.
    fn sound() -> Radar {
        Radar {
            time_units: "minutes since 2026-06-01 05:59:00",
            times: vec![0.0, 1.0, 2.0],
            bounds: None,
            units: "mm h-1",
            calendar: "standard",
            values: vec![
                [[60.0, 0.0, 0.0, 0.0, 0.0]; 2],
                [[0.0, 0.0, 0.0, 6.0, 36.0], [0.0, 0.0, 0.0, 0.0, 18.0]],
                [[9.0; 5]; 2],
            ],
            west: 1000.0,
            has_quality: false,
            order: ["time", "y", "x"],
            bounds_units: None,
            bounds_shape: &["time", "nv"],
            bounds_name: "time_bounds",
            scale_factor: None,
            axis_units: "m",
            valid_max: None,
        }
    }

    /// Writes a file of classic format: HDF5 tells of every attribute that it does not find.
    fn write(&self, path: PathBuf) {
        let mut file = netcdf::create_with(path, Options::_64BIT_OFFSET).unwrap();
        file.add_dimension("time", self.times.len()).unwrap();
        for (name, length) in [("y", 2), ("x", 5), ("nv", 2)] {
            file.add_dimension(name, length).unwrap();
        }
        let mut time = file.add_variable::<f64>("time", &["time"]).unwrap();
        time.put_attribute("units", self.time_units).unwrap();
        time.put_attribute("calendar", self.calendar).unwrap();
        if let Some(factor) = self.scale_factor {
            time.put_attribute("scale_factor", factor).unwrap();
        }
        if self.bounds.is_some() {
            time.put_attribute("bounds", self.bounds_name).unwrap();
            let mut bounds = file.add_variable::<f64>("time_bounds", self.bounds_shape).unwrap();
            if let Some(units) = self.bounds_units {
                bounds.put_attribute("units", units).unwrap();
            }
        }
        for (name, direction) in [("x", "projection_x_coordinate"), ("y", "projection_y_coordinate")] {
            let mut axis = file.add_variable::<f64>(name, &[name]).unwrap();
            axis.put_attribute("units", self.axis_units).unwrap();
            axis.put_attribute("standard_name", direction).unwrap();
        }
        let mut rain = file.add_variable::<f64>("rate", &self.order).unwrap();
        rain.put_attribute("units", self.units).unwrap();
        rain.put_attribute("_FillValue", -9.0).unwrap();
        if let Some(most) = self.valid_max {
            rain.put_attribute("valid_max", most).unwrap();
        }
        if self.has_quality {
            file.add_variable::<f64>("quality", &["time", "y", "x"]).unwrap();
        }
        file.enddef().unwrap();
        let put = |file: &mut netcdf::FileMut, name: &str, values: &[f64]| {
            file.variable_mut(name).unwrap().put_values(values, ..).unwrap();
        };
        put(&mut file, "time", &self.times);
        if let Some(bounds) = &self.bounds {
            put(&mut file, "time_bounds", bounds);
        }
        put(&mut file, "x", &std::array::from_fn::<f64, 5, _>(|k| self.west + 10.0 + 20.0 * k as f64));
        put(&mut file, "y", &[2037.5, 2012.5]);
        let values: Vec<f64> = self.values.iter().flatten().flatten().copied().collect();
        put(&mut file, "rate", &values);
        if self.has_quality {
            put(&mut file, "quality", &values);
        }
        file.close().unwrap();
    }
}

struct Scene {
    folder: TempDir,
}

impl Scene {
    fn new(radar: &Radar, changes: &[(&str, &str)]) -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        let row: Vec<String> = (0..20).map(|column| format!("{}", 10.0 - 0.1 * f64::from(column))).collect();
        scene.grid("dem.asc", &vec![row.join(" "); 10], 5.0);
        let (radar, path) = (radar.clone(), scene.folder.path().join("radar.nc"));
        with_netcdf(move || radar.write(path));
        scene.write("s.yaml", &changed(SCENARIO, changes));
        scene
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.path().join(name), text).unwrap();
    }

    fn grid(&self, name: &str, rows: &[String], cell: f64) {
        let columns = rows[0].split(' ').count();
        let header = format!(
            "ncols {columns}\nnrows {}\nxllcorner 1000\nyllcorner 2000\ncellsize {cell}\nNODATA_value -9999\n",
            rows.len()
        );
        self.write(name, &(header + &rows.join("\n") + "\n"));
    }

    /// Runs the scene; returns what came in (m³) and `run.json`.
    #[track_caller]
    fn run(&self) -> (f64, serde_json::Value) {
        let answer = floodsim(self.folder.path(), &["run", "s.yaml", "--out", "out", "--quiet"]);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let text = std::fs::read_to_string(self.folder.path().join("out/run.json")).unwrap();
        let run: serde_json::Value = serde_json::from_str(&text).unwrap();
        (run["volume_m3"]["in"].as_f64().unwrap(), run)
    }

    /// Asserts that the check ends with this exit code and says all these texts.
    #[track_caller]
    fn assert_check(&self, code: i32, expected: &[&str]) {
        assert_check(self.folder.path(), code, expected);
    }
}

/// Volume (m³) of a minute of so many mm/h on a cell of the radar.
fn minute(intensities: f64) -> f64 {
    intensities * 1e-3 / 60.0 * 20.0 * 25.0
}

#[track_caller]
fn assert_volume(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} m3 instead of {expected}");
}

#[test]
fn a_radar_rains_its_volume_in_its_intervals() {
    let scene = Scene::new(&Radar::sound(), &[]);
    scene.assert_check(0, &["0 errors, 0 warnings"]);
    let (came, run) = scene.run();
    // The run begins with the second raster: 6 + 36 + 18, then 9 on ten cells.
    assert_volume(came, minute(60.0) + minute(90.0));
    assert!(run["inputs"].as_array().unwrap().iter().any(|file| file["path"].as_str().unwrap().ends_with("radar.nc")));
    // The same times by their ends, and by their bounds.
    let ended = Radar { times: vec![1.0, 2.0, 3.0], ..Radar::sound() };
    let by_end = Scene::new(&ended, &[("radar.nc,", "radar.nc:rate, unit: mm/h, stamp: end,")]);
    assert_volume(by_end.run().0, minute(150.0));
    let bounds = Some(vec![0.0, 1.0, 1.0, 2.5, 2.5, 4.0]);
    let bounded = Scene::new(&Radar { times: vec![0.5, 2.0, 3.5], bounds, ..Radar::sound() }, &[]);
    assert_volume(bounded.run().0, minute(60.0 * 1.5 + 90.0 * 0.5));
    // On cells that move as well.
    let moving = Scene::new(&Radar::sound(), &[("resolution: 5 m", "numerics: {motion: lagrangian}\nresolution: 5 m")]);
    assert_volume(moving.run().0, minute(150.0));
}

#[test]
fn losses_duration_and_depths_count_for_a_radar() {
    // In each interval of a minute so many tenths of a millimetre.
    let mut depths = Radar { units: "mm", ..Radar::sound() };
    depths.values.iter_mut().flatten().flatten().for_each(|value| *value *= 0.01);
    let scene = Scene::new(&depths, &[]);
    assert_volume(scene.run().0, 0.6e-3 * 500.0 + 10.0 * 0.09e-3 * 500.0);
    // 0.3 mm of 0.36 are lost in one cell, and 12 mm/h from then on; all else is lost. The rest of the minute are 10 s.
    let lossy =
        Scene::new(&Radar::sound(), &[("\"}", "\", duration: 1 min, losses: {initial: 0.5 mm, constant: 12 mm/h}}")]);
    assert_volume(lossy.run().0, 500.0 * 24e-3 / 3600.0 * 10.0);
}

#[test]
fn a_list_of_files_rains_as_well() {
    let list = "raster_series: list.csv, unit: mm/h";
    let scene = Scene::new(&Radar::sound(), &[("raster_series: radar.nc, start: \"2026-06-01 06:00:00\"", list)]);
    let rows = "time_min,file\n0,west.asc\n0.5,none.asc\n1,all.asc\n1.5,all.asc\n";
    scene.write("list.csv", rows);
    scene.grid("west.asc", &["72 0".to_owned()], 50.0);
    scene.grid("none.asc", &["0 0".to_owned()], 50.0);
    scene.grid("all.asc", &["36 36".to_owned()], 50.0);
    scene.assert_check(0, &["0 errors, 0 warnings"]);
    let (came, run) = scene.run();
    assert_volume(came, 2500.0 * (72e-3 / 3600.0 * 30.0 + 2.0 * 36e-3 / 3600.0 * 60.0));
    let inputs = run["inputs"].as_array().unwrap();
    assert_eq!(inputs.iter().filter(|file| file["path"].as_str().unwrap().ends_with(".asc")).count(), 4, "{inputs:?}");
    scene.write("list.csv", "time,file\n2026-06-01 06:00,west.asc\n2026-06-01 06:00:30,none.asc\n2026-06-01T06:01Z,all.asc\n2026-06-01 08:01:30+02:00,all.asc\n");
    scene.assert_check(
        4,
        &["error[dates-as-times] rain.raster_series", "line 2 (`2026-06-01 06:00`)", "`time.reference`"],
    );
    let dated = format!("{list}, start: \"2026-06-01 06:00:00\"");
    scene.write("s.yaml", &changed(SCENARIO, &[("raster_series: radar.nc, start: \"2026-06-01 06:00:00\"", &dated)]));
    scene.assert_check(0, &["0 errors, 0 warnings"]);
    std::fs::remove_dir_all(scene.folder.path().join("out")).unwrap();
    assert!((scene.run().0 - came).abs() < 1e-12 * came);
    scene.write("s.yaml", &changed(SCENARIO, &[("raster_series: radar.nc, start: \"2026-06-01 06:00:00\"", list)]));
    scene.write("list.csv", rows);
    scene.grid("all.asc", &["36 36 36".to_owned()], 50.0);
    scene.assert_check(4, &["error[other-grid] rain.raster_series", "all.asc lies on another grid"]);
    scene.write("list.csv", "time_min,file\n0,west.asc\n1,gone.asc\nlater,none.asc\n");
    scene.assert_check(4, &["missing-file", "gone.asc", "not-a-row", "line 4 (`later,none.asc`)"]);
    scene.write("list.csv", "time,file\n0,west.asc\n1,none.asc\n");
    scene.assert_check(4, &["missing-unit", "`time_min,file`"]);
}

#[test]
fn bounds_of_times_are_taken_at_their_word_or_refused() {
    let sound = Radar { bounds: Some(vec![0.0, 1.0, 1.0, 2.0, 2.0, 3.0]), ..Radar::sound() };
    // Seconds from a minute later than the times.
    let own = Radar {
        times: vec![0.0, 1.0, 2.5],
        bounds: Some(vec![-60.0, 0.0, 0.0, 90.0, 90.0, 180.0]),
        bounds_units: Some("seconds since 2026-06-01 06:00:00"),
        ..Radar::sound()
    };
    assert_volume(Scene::new(&own, &[]).run().0, minute(60.0 * 1.5 + 90.0 * 0.5));
    let check = |radar: Radar, expected: &[&str]| {
        Scene::new(&radar, &[]).assert_check(4, &[&["error[bad-bounds] rain.raster_series"], expected].concat());
    };
    check(Radar { bounds_name: "time_bnds", ..sound.clone() }, &["`time_bnds`, which it does not have"]);
    check(Radar { bounds_shape: &["nv", "time"], ..sound.clone() }, &["(nv = 2, time = 3) and not (time, 2)"]);
    check(Radar { bounds_units: Some("minutes"), ..sound.clone() }, &["say `minutes`", "has a date"]);
    check(Radar { bounds_units: Some("minutes ago"), ..sound.clone() }, &["`minutes ago` is no unit"]);
    check(
        Radar { bounds_units: Some("hours since 2026-06-01 05:59:00"), ..sound.clone() },
        &["the time 0 s", "outside its bounds, 3540 s to 7140 s"],
    );
    let packed = Scene::new(&Radar { scale_factor: Some(60.0), ..Radar::sound() }, &[]);
    packed.assert_check(4, &["error[packed-times]", "`time` of", "`scale_factor`", "ncpdq -U"]);
}

#[test]
fn units_of_times_have_an_offset_or_an_early_date_of_the_gregorian_calendar() {
    let volume = Scene::new(&Radar::sound(), &[]).run().0;
    let local = Radar { time_units: "minutes since 2026-6-1 7:59 +2:00", ..Radar::sound() };
    // Minutes from the beginning of the year 1: 2025 years, of which 491 were leap years, and 151 days.
    let day = 365.0 * 2025.0 + 491.0 + 151.0;
    let from = 1440.0 * day + 359.0;
    let ends = |first: f64| vec![first, first + 1.0, first + 1.0, first + 2.0, first + 2.0, first + 3.0];
    let proleptic = Radar {
        time_units: "minutes since 0001-01-01",
        bounds_units: Some("minutes since 0001-01-01"),
        calendar: "proleptic_gregorian",
        times: vec![from, from + 1.0, from + 2.0],
        bounds: Some(ends(from)),
        ..Radar::sound()
    };
    for radar in [local, proleptic] {
        assert_volume(Scene::new(&radar, &[]).run().0, volume);
    }
}

#[test]
fn two_dates_of_the_start_must_agree() {
    let time = |reference| [("end: 2 min", format!("end: 2 min, reference: \"{reference}\""))];
    let scene = |reference| {
        let [(old, new)] = time(reference);
        Scene::new(&Radar::sound(), &[(old, &new)])
    };
    // The same moment in every form.
    for reference in [
        "2026-06-01 06:00:00",
        "2026-06-01T08:00+02:00",
        "2026-06-01 06:00:00.0z",
        "2026-06-1 6",
        "2026-05-31 24:00-06:00",
    ] {
        scene(reference).assert_check(0, &["0 errors"]);
    }
    // The file of the run has it in UTC, whatever the form.
    let local = scene("2026-06-01T08:00+02:00");
    local.run();
    assert!(
        Netcdf::read(&local.folder.path().join("out/fields.nc")).variables["time"]
            .0
            .contains("seconds since 2026-06-01 06:00:00")
    );
    scene("2026-06-01 05:59:00").assert_check(
        4,
        &[
            "error[two-starts] rain.raster_series",
            "`2026-06-01 06:00:00`",
            "`2026-06-01 05:59:00`",
            "take one of them out",
        ],
    );
}

#[test]
fn files_of_a_list_have_one_band_and_their_warnings_are_counted() {
    let list = "raster_series: list.csv, unit: mm/h";
    let scene = Scene::new(&Radar::sound(), &[("raster_series: radar.nc, start: \"2026-06-01 06:00:00\"", list)]);
    scene.write("list.csv", "time_min,file\n0,a.asc\n0.5,b.asc\n1,c.asc\n1.5,d.asc\n");
    for name in ["a", "b", "c", "d"] {
        scene.grid(&format!("{name}.asc"), &["36 36".to_owned()], 50.0);
    }
    for name in ["b", "c", "d"] {
        let wkt = "LOCAL_CS[\"site\",UNIT[\"metre\",1]]";
        scene.write(&format!("{name}.prj"), wkt);
    }
    scene.assert_check(0, &["warning[crs-set-aside]", "b.asc", "the first of 3 such rasters of the list", "1 warning"]);
    let bands = "ENVI\nsamples = 2\nlines = 1\nbands = 3\ndata type = 1\ninterleave = bsq\nmap info = {Arbitrary, 1, 1, 1000, 2050, 50, 50}\n";
    scene.write("c.hdr", bands);
    scene.write("c.img", "aaaaaa");
    scene.write("list.csv", "time_min,file\n0,a.asc\n1,c.img\n");
    scene.assert_check(4, &["error[several-bands] rain.raster_series", "c.img has 3 bands", "gdal_translate -b 1"]);
}

#[test]
fn values_that_a_file_calls_invalid_are_no_rain() {
    // 36 mm/h in the second raster, the first that falls in the run, are above the bound.
    let bounded = Radar { valid_max: Some(30.0), ..Radar::sound() };
    Scene::new(&bounded, &[]).assert_check(4, &["error[rain-gap] rain.raster_series", "1 of", "have no value"]);
    let loose = Radar { valid_max: Some(36.0), ..Radar::sound() };
    Scene::new(&loose, &[]).assert_check(0, &["0 errors"]);
}
