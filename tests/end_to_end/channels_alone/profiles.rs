//! `channels.nc` against the table of profiles.

use super::*;

/// Two channels, of which the second has a line on the map that bends in its middle.
const TWO: &str = "\
floodsim: 1
title: Two channels
crs: EPSG:25832
roughness: {manning: 0.03}
channels:
  - {id: 'upper, left', length: 50 m, width: 4 m, bed: 10 m, water: [{depth: 1 m}]}
  - {id: mill, length: 100 m, width: 2 m, bed: 3 m, slope: 0.01, water: [{depth: 1 m, to: 30 m}], line: axes.geojson}
resolution: 10 m
time: {end: 20 s, reference: '2026-06-01 06:00:00'}
outputs: {every: 5 s}
";

#[test]
fn channels_nc_holds_the_profiles_of_the_table() {
    let scene = Scene::of(TWO);
    scene.write("axes.geojson", &axes(&["mill", "other"]));
    let (_, out) = scene.run();
    let file = Netcdf::read(&out.join("channels.nc"));
    let lengths = |name: &str| file.dimensions[name];
    assert_eq!((lengths("time"), lengths("station"), lengths("channel")), (5, 15, 2));
    assert_eq!(file.values("time"), [0.0, 5.0, 10.0, 15.0, 20.0]);
    assert!(file.variables["time"].0.contains("seconds since 2026-06-01 06:00:00"));
    assert_eq!(file.values("channel_index"), [[0.0; 5].as_slice(), &[1.0; 10]].concat());
    assert!(file.variables["channel_index"].0.contains("upper__left mill"), "{}", file.variables["channel_index"].0);
    assert!(file.variables.contains_key("channel_id") && file.variables["crs"].0.contains("ETRS89"));
    // Every number of the table stands in the file, in its order.
    let rows = table(&out, "channels.csv");
    assert_eq!(rows.len(), 1 + 5 * 15);
    for (i, row) in rows[1..].iter().enumerate() {
        // A name with a comma is quoted, and split by the helper.
        let row = &row[row.len() - 7..];
        let (moment, station) = (i / 15, i % 15);
        assert!((file.values("time")[moment] - number(&row[0])).abs() < 1e-9);
        assert!((file.values("distance")[station] - number(&row[1])).abs() < 1e-3);
        assert!((file.values("bed_elevation")[station] - number(&row[2])).abs() < 1e-4);
        for (column, name) in [(3, "depth"), (5, "velocity"), (6, "discharge")] {
            assert!((file.values(name)[i] - number(&row[column])).abs() < 1e-4, "{name}: {row:?}");
        }
        let level = file.values("water_level")[i];
        let is_dry = file.values("depth")[i] <= 1e-3;
        assert!(if is_dry { level < -9998.0 } else { (level - number(&row[4])).abs() < 1e-4 }, "{row:?}");
    }
    for (name, words) in [
        (
            "depth",
            vec![r#"("units", "Str(\"m\")")"#, "channel_index distance x y", "time: point", "grid_mapping", "-9999"],
        ),
        ("water_level", vec!["water_surface_height_above_reference_datum"]),
        ("velocity", vec!["m s-1", "positive towards the near end"]),
        ("discharge", vec!["m3 s-1", "water_volume_transport_in_river_channel"]),
        ("x", vec!["projection_x_coordinate", "NaN"]),
    ] {
        let (described, _) = &file.variables[name];
        assert!(words.iter().all(|word| described.contains(word)), "{name}: {described}");
    }
    // Along the line: the sixth station is 55 m from the far end, 5 m beyond the bend.
    let (x, y) = (&file.values("x")[5..], &file.values("y")[5..]);
    assert!(file.values("x")[..5].iter().all(|x| x.is_nan()));
    for (station, place) in
        [(0, (500_005.0, 5_300_000.0)), (5, (500_050.0, 5_300_005.0)), (9, (500_050.0, 5_300_045.0))]
    {
        assert!((x[station] - place.0).abs() + (y[station] - place.1).abs() < 1e-6, "{x:?} {y:?}");
    }
    assert!(!file.attributes.contains_key("featureType"));
    // With places for all stations the file is a set of time series.
    let scene = Scene::of(&changed(TWO, &[("water: [{depth: 1 m}]}", "water: [{depth: 1 m}], line: axes.geojson}")]));
    scene.write("axes.geojson", &axes(&["mill", "upper, left"]));
    let answer = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert!(answer.stdout.contains("warning[line-length] channels[0].line (s.yaml:6:"), "{}", answer.stdout);
    let file = Netcdf::read(&scene.run().1.join("channels.nc"));
    assert!(file.attributes["featureType"].contains("timeSeries"));
    assert!(file.variables["station"].0.contains("timeseries_id"));
}

#[test]
fn a_killed_run_leaves_the_profiles_that_it_had() {
    let scene = Scene::of(&changed(SCENARIO, &[("3 h", "1000 h"), ("30 min", "1 min"), ("10 min", "10 h")]));
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("floodsim"));
    command.current_dir(scene.folder.path()).args(["run", "s.yaml", "--out", "out", "--quiet"]);
    let mut child = command.spawn().unwrap();
    let (partial, start) = (scene.path("out/channels.partial.nc"), std::time::Instant::now());
    while !partial.metadata().is_ok_and(|metadata| metadata.len() > 100_000) {
        assert!(start.elapsed().as_secs() < 60, "no profiles after a minute");
        assert!(child.try_wait().unwrap().is_none(), "the run ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!scene.path("out/channels.nc").exists());
    let file = Netcdf::read(&partial);
    let times = file.values("time");
    assert!(times.len() > 5 && times.iter().enumerate().all(|(i, time)| (time - 60.0 * i as f64).abs() < 1e-6));
    assert_eq!(file.values("depth").len(), 200 * times.len());
    assert!(file.variables["channel_index"].0.contains("river"));
    // The next run takes its place.
    scene.write("s.yaml", SCENARIO);
    assert!(!files(&scene.run().1).contains(&"channels.partial.nc".to_owned()));
}
