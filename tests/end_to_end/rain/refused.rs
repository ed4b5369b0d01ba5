//! Rasters of rain that do not fit, and those that are doubted.

use super::*;

#[test]
fn a_radar_that_does_not_fit_is_refused_with_its_place() {
    let check = |radar: Radar, changes: &[(&str, &str)], expected: &[&str]| {
        Scene::new(&radar, changes).assert_check(4, expected);
    };
    let start = ", start: \"2026-06-01 06:00:00\"";
    check(Radar::sound(), &[(start, "")], &["error[no-start] rain.raster_series", "time.reference"]);
    check(Radar { units: "dBZ", ..Radar::sound() }, &[], &["missing-unit", "`dBZ`"]);
    check(Radar::sound(), &[(start, ", start: \"2026-06-01 06:00:00\", unit: m/s")], &["other-unit", "`mm h-1`"]);
    check(
        Radar { has_quality: true, ..Radar::sound() },
        &[],
        &["no-variable", "it has rate, quality", "radar.nc:rainfall"],
    );
    check(Radar::sound(), &[("radar.nc", "radar.nc:rain")], &["no-variable", "no variable `rain`", "it has rate"]);
    check(Radar { calendar: "360_day", ..Radar::sound() }, &[], &["no-time", "`360_day`", "convert_calendar"]);
    let early = Radar { time_units: "minutes since 0001-01-01", ..Radar::sound() };
    check(early, &[], &["no-time", "0001-01-01", "before 1582-10-15", "calendar,time,o,c,proleptic_gregorian"]);
    check(
        Radar { time_units: "minutes since 2026-06-31", ..Radar::sound() },
        &[],
        &["no-time", "there is no such day"],
    );
    check(Radar { time_units: "days after the storm", ..Radar::sound() }, &[], &["no-time", "`days after the storm`"]);
    check(Radar { times: vec![0.0, 2.0, 1.0], ..Radar::sound() }, &[], &["not-rising"]);
    check(Radar::sound(), &[("06:00:00", "05:58:00")], &["series-starts-late", "60 s after the start"]);
    check(
        Radar::sound(),
        &[("end: 2 min", "end: 3 min")],
        &["series-ends-early", "ends at 120 s", "at 180 s", "rain.duration"],
    );
    // Four of the five columns of the radar lie over the terrain; the hole and the error are in cells of 20 m by 25 m.
    check(
        Radar { west: 1020.0, ..Radar::sound() },
        &[],
        &["rain-outside", "20.0 % of the terrain (40 cells, 1000 m²)", "1002.5"],
    );
    let mut holes = Radar::sound();
    (holes.values[1][0][2], holes.values[2][1][2], holes.values[2][1][3]) = (-9.0, -9.0, -0.5);
    let one = "10.0 % of the terrain (20 cells, 500 m²), first at";
    let texts = [
        "error[rain-gap]",
        "2 of 2 rasters",
        &format!("{one} 0 s"),
        "error[negative-value]",
        "1 of 2",
        &format!("{one} 60 s"),
    ];
    check(holes, &[], &texts);
    // What is wrong before the run, or when it no longer rains, does not matter.
    let mut early = Radar::sound();
    early.values[0] = [[-9.0; 5]; 2];
    Scene::new(&early, &[]).assert_check(0, &["0 errors"]);
    let both = "rain: {raster_series: radar.nc, rate: 3 mm/h}";
    Scene::new(&Radar::sound(), &[("rain: {raster_series: radar.nc, start: \"2026-06-01 06:00:00\"}", both)])
        .assert_check(3, &["exclude each other"]);
}

#[test]
fn a_radar_of_another_order_of_axes_is_refused() {
    let check = |order, expected: &[&str]| {
        Scene::new(&Radar { order, ..Radar::sound() }, &[]).assert_check(4, expected);
    };
    check(["time", "x", "y"], &["error[axes-swapped] rain.raster_series", "time, x, y and not", "ncpdq -a time,y,x"]);
    check(["y", "x", "time"], &["error[axes-swapped] rain.raster_series", "y, x, time and not", "ncpdq -a time,y,x"]);
    check(["time", "nv", "x"], &["error[axes-unknown] rain.raster_series", "is y is not known", "axis = \"Y\""]);
}

#[test]
fn depths_since_the_beginning_are_refused() {
    let radar = |depths: [f64; 4], units| Radar {
        times: vec![0.0, 1.0, 2.0, 3.0],
        values: depths.iter().map(|&depth| [[depth, depth, depth, depth, 0.0]; 2]).collect(),
        units,
        ..Radar::sound()
    };
    let check = |radar: Radar, code, texts: &[&str]| {
        Scene::new(&radar, &[("end: 2 min", "end: 3 min")]).assert_check(code, texts);
    };
    // The run begins with the second raster; rain covers four of five columns.
    check(
        radar([1.0, 1.0, 1.5, 2.0], "mm"),
        4,
        &["error[accumulated-rain] rain.raster_series", "in 3 rasters", "from 0.800 mm to 1.600 mm", "cdo deltat"],
    );
    for sound in [radar([1.0, 1.0, 1.5, 1.25], "mm"), radar([1.0; 4], "mm"), radar([1.0, 1.0, 1.5, 2.0], "mm/h")] {
        check(sound, 0, &["0 errors"]);
    }
}

#[test]
fn a_gap_in_time_and_impossible_rain_are_warned_of() {
    let gappy = Radar { times: vec![0.0, 1.0, 2.0, 5.0, 6.0], values: vec![[[3.0; 5]; 2]; 5], ..Radar::sound() };
    let scene = Scene::new(&gappy, &[("end: 2 min", "end: 5 min")]);
    scene.assert_check(0, &["warning[series-gap]", "from 60 s to 240 s"]);
    let heavy = Radar { units: "mm/min", ..Radar::sound() };
    Scene::new(&heavy, &[]).assert_check(0, &["warning[rain-doubtful]", "more than 1000 mm/h", "check the unit"]);
    let absurd = Radar { values: vec![[[3e30; 5]; 2]; 3], ..Radar::sound() };
    Scene::new(&absurd, &[]).assert_check(4, &["error[implausible-value]", "more than 1 m/s", "check the unit"]);
}

#[test]
fn axes_that_do_not_count_in_metres_are_refused_with_the_way_to_metres() {
    let in_km = Radar { axis_units: "km", ..Radar::sound() };
    let remedy = "remedy  bring it to metres: `ncap2 -s '";
    Scene::new(&in_km, &[]).assert_check(
        4,
        &[
            "error[not-metric-crs] rain.raster_series",
            "of radar.nc counts in `km`, and a run needs metres",
            "no `grid_mapping`",
            remedy,
            "x=x*1000;x@units=\"m\"",
            "y=y*1000",
        ],
    );
    let in_degrees = Radar { axis_units: "degrees", ..Radar::sound() };
    Scene::new(&in_degrees, &[]).assert_check(
        4,
        &[
            "error[geographic-crs] rain.raster_series",
            "counts in degrees (`degrees`)",
            "`grid_mapping`",
            "grid_mapping_name",
        ],
    );
}

#[test]
fn a_depth_times_a_time_is_no_rate() {
    let odd = Radar { units: "mm day", ..Radar::sound() };
    let expected =
        ["error[missing-unit] rain.raster_series", "`mm day`, which is none of rain", "`mm day-1`", "add `unit: mm/h`"];
    Scene::new(&odd, &[]).assert_check(4, &expected);
}

#[test]
fn a_raster_of_rain_must_agree_with_the_unit_of_its_file() {
    let series = "raster_series: radar.nc, start: \"2026-06-01 06:00:00\"";
    // Of a file of several bands the first one is taken.
    for (units, code) in [("kg m-2 s-1", 4), ("mm", 4), ("mm h-1", 0), ("kg m-2 h-1", 0), ("drops", 0)] {
        let radar = Radar { units, ..Radar::sound() };
        let scene = Scene::new(&radar, &[(series, "raster: radar.nc, unit: mm/h")]);
        let expected: &[&str] = if code == 0 {
            &["0 errors"]
        } else {
            &["error[other-unit] rain.raster (s.yaml:", "and the scenario another unit", "remedy"]
        };
        scene.assert_check(code, expected);
    }
}

#[test]
fn a_constant_raster_of_another_order_of_axes_is_refused() {
    let series = "raster_series: radar.nc, start: \"2026-06-01 06:00:00\"";
    let radar = Radar { order: ["time", "x", "y"], ..Radar::sound() };
    let scene = Scene::new(&radar, &[(series, "raster: radar.nc, unit: mm/h")]);
    scene.assert_check(4, &["error[axes-swapped] rain.raster (s.yaml:", "ncpdq -a time,y,x"]);
    let rough = [(series, "rate: 1 mm/h"), ("{manning: 0.03}", "{raster: radar.nc}")];
    let expected = ["error[axes-swapped] roughness.raster (s.yaml:", "ncpdq -a time,y,x"];
    Scene::new(&radar, &rough).assert_check(4, &expected);
}
