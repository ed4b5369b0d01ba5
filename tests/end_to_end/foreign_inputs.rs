//! Inputs from elsewhere, inputs that never end, and the record of all that a run was read from.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::{Answer, changed, floodsim, run_scene};

const SCENARIO: &str = "\
floodsim: 1
title: A basin in a plateau
crs: local
terrain: {layers: [{raster: dem.vrt}]}
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 5 m}]
resolution: 5 m
time: {end: 2 s}
outputs: {every: 1 s, gauges: gauges.csv}
";

const LAKE: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"Polygon",
"coordinates":[[[1045,2045],[1105,2045],[1105,2105],[1045,2105],[1045,2045]]]}}]}"#;

/// A plateau at 20 m with a basin of 50 m by 50 m, floor at 0 m.
fn grid() -> String {
    let value = |column, row: i32| if (10..20).contains(&column) && (10..20).contains(&row) { "0" } else { "20" };
    let row = |row| (0..40).map(|column| value(column, row)).collect::<Vec<_>>().join(" ");
    let rows: Vec<String> = (0..30).map(row).collect();
    format!("ncols 40\nnrows 30\nxllcorner 1000\nyllcorner 2000\ncellsize 5\n{}\n", rows.join("\n"))
}

/// A VRT of one band with such elements in it.
fn vrt(of_band: &str, inner: &str) -> String {
    let transform = "<GeoTransform>1000, 5, 0, 2150, 0, -5</GeoTransform>";
    let band = format!(r#"<VRTRasterBand dataType="Float32" band="1"{of_band}>{inner}</VRTRasterBand>"#);
    format!(r#"<VRTDataset rasterXSize="40" rasterYSize="30">{transform}{band}</VRTDataset>"#)
}

/// A band that is read from one file.
fn source(name: &str, is_relative: bool) -> String {
    let relative = u8::from(is_relative);
    let name = format!(r#"<SourceFilename relativeToVRT="{relative}">{name}</SourceFilename>"#);
    vrt("", &format!("<SimpleSource>{name}<SourceBand>1</SourceBand></SimpleSource>"))
}

/// A place with the folder `scene` of a scenario whose terrain is a VRT, and the folder `data` beside it.
struct Place(TempDir);

impl Place {
    fn new() -> Place {
        let place = Place(TempDir::new().unwrap());
        for folder in ["scene/tiles", "data/tiles"] {
            std::fs::create_dir_all(place.0.path().join(folder)).unwrap();
            place.write(&format!("{folder}/tile.asc"), &grid());
        }
        place.write("scene/s.yaml", SCENARIO);
        place.write("scene/lake.geojson", LAKE);
        place.write("scene/gauges.csv", "id,x,y\nA,1075,2075\n");
        place.write("scene/dem.vrt", &source("tiles/tile.asc", true));
        place
    }

    fn scene(&self) -> PathBuf {
        self.0.path().join("scene")
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.0.path().join(name), text).unwrap();
    }

    fn check(&self) -> Answer {
        floodsim(&self.scene(), &["check", "s.yaml"])
    }

    /// Asserts that check and run refuse it at once with these words.
    #[track_caller]
    fn assert_refused(&self, code: i32, expected: &[&str]) {
        for arguments in [&["check", "s.yaml"][..], &["run", "s.yaml", "--out", "out"], &["plan", "s.yaml"]] {
            let start = Instant::now();
            let answer = floodsim(&self.scene(), arguments);
            assert!(start.elapsed() < Duration::from_secs(20), "{arguments:?}: {:?}", start.elapsed());
            let said = answer.stdout + &answer.stderr;
            assert_eq!(answer.code, code, "{said}");
            for text in expected.iter().chain(&["\n  remedy  "]) {
                assert!(said.contains(text), "{arguments:?} does not say `{text}`, but\n{said}");
            }
        }
        assert!(!self.scene().join("out").exists());
    }
}

/// Makes a named pipe.
fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn a_vrt_that_names_what_is_elsewhere_is_refused() {
    let place = Place::new();
    assert_eq!(place.check().code, 0);
    let raw = r#"<SourceFilename relativeToVRT="0">/etc/passwd</SourceFilename><ImageOffset>0</ImageOffset>"#;
    let warped = "<SourceDataset relativeToVRT=\"0\">/vsicurl/http://127.0.0.1:9/a.tif</SourceDataset>";
    for (text, cause) in [
        (vrt(r#" subClass="VRTRawRasterBand""#, raw), "`/etc/passwd` is neither"),
        (source("/vsicurl/http://127.0.0.1:9/dem.tif", false), "is on a network"),
        (source("/vsizip/tiles.zip/tile.asc", true), "in an archive"),
        (source("&lt;VRTDataset/&gt;", false), "`<VRTDataset/>` is on"),
        (source("../data/tiles/tile.asc", true), "neither in the folder of the scenario"),
        (
            vrt("", "")
                .replace("<VRTRasterBand", &format!("<GDALWarpOptions>{warped}</GDALWarpOptions><VRTRasterBand")),
            "is on a network",
        ),
    ] {
        place.write("scene/dem.vrt", &text);
        place.assert_refused(4, &["error[foreign-file] terrain.layers[0].raster (s.yaml:4:29)", cause]);
    }
    // Also by another VRT, by a link, and by the side file of a source.
    place.write("scene/dem.vrt", &source("inner.vrt", true));
    place.write("scene/inner.vrt", &source("../data/tiles/tile.asc", true));
    place.assert_refused(4, &["error[foreign-file]", "inner.vrt names a file from elsewhere"]);
    std::os::unix::fs::symlink("../data/tiles/tile.asc", place.scene().join("link.asc")).unwrap();
    place.write("scene/dem.vrt", &source("link.asc", true));
    place.assert_refused(4, &["error[foreign-file]", "link.asc"]);
    place.write("scene/dem.vrt", &source("tiles/tile.asc", true));
    let overview = r#"<MDI key="OVERVIEW_FILE">/vsicurl/http://127.0.0.1:9/a.ovr</MDI>"#;
    let metadata = format!(r#"<PAMDataset><Metadata domain="OVERVIEWS">{overview}</Metadata></PAMDataset>"#);
    place.write("scene/tiles/tile.asc.aux.xml", &metadata);
    place.assert_refused(4, &["error[foreign-file]", "tile.asc names a file from elsewhere"]);
}

#[test]
fn a_vrt_of_another_folder_reads_what_lies_with_it_and_more_where_that_is_allowed() {
    let place = Place::new();
    place.write("scene/s.yaml", &changed(SCENARIO, &[("dem.vrt", "../data/dem.vrt")]));
    place.write("data/dem.vrt", &source("tiles/tile.asc", true));
    assert_eq!(place.check().code, 0, "{}", place.check().stdout);
    place.write("data/dem.vrt", &source("../../data/tiles/../tiles/tile.asc", true));
    place.write("scene/s.yaml", SCENARIO);
    place.write("scene/dem.vrt", &source("../data/tiles/tile.asc", true));
    assert_eq!(place.check().code, 4);
    place.write("scene/s.yaml", &format!("{SCENARIO}limits: {{allow_remote: true}}\n"));
    assert_eq!(place.check().code, 0, "{}", place.check().stdout);
    // A source that is not there is named, and who names it.
    place.write("scene/s.yaml", SCENARIO);
    place.write("scene/dem.vrt", &source("gone.asc", true));
    place.assert_refused(4, &["error[missing-file] terrain.layers[0].raster", "gone.asc", "dem.vrt names it"]);
}

#[test]
fn addresses_and_paths_of_gdal_are_refused_and_archives_read_where_that_is_allowed() {
    let place = Place::new();
    for (raster, remedy) in [
        ("https://127.0.0.1:9/dem.tif", "`/vsicurl/` before the address"),
        ("/vsicurl/https://127.0.0.1:9/dem.tif", "download or unpack it"),
        ("/vsigzip/dem.asc.gz", "download or unpack it"),
        ("/vsistdin/", "download or unpack it"),
    ] {
        place.write("scene/s.yaml", &changed(SCENARIO, &[("dem.vrt", raster)]));
        place.assert_refused(4, &["error[foreign-file] terrain.layers[0].raster (s.yaml:4:29)", remedy]);
    }
    // With it come files that are missing.
    place.write("scene/s.yaml", &changed(SCENARIO, &[("dem.vrt", "/vsistdin/"), ("gauges.csv", "gone.csv")]));
    place.assert_refused(4, &["error[foreign-file]", "error[missing-file] outputs.gauges"]);
    std::fs::write(place.scene().join("dem.asc"), grid()).unwrap();
    assert!(Command::new("gzip").arg(place.scene().join("dem.asc")).status().unwrap().success());
    let archive = format!("/vsigzip/{}", place.scene().join("dem.asc.gz").display());
    let text = changed(SCENARIO, &[("dem.vrt", &archive)]) + "limits: {allow_remote: true}\n";
    place.write("scene/s.yaml", &text);
    let check = place.check();
    assert_eq!(check.code, 0, "{}", check.stdout);
    assert!(check.stdout.contains("warning[no-checksum] terrain.layers[0].raster (s.yaml:4:29)"), "{}", check.stdout);
}

#[test]
fn a_vector_file_that_asks_for_an_address_is_refused() {
    let place = Place::new();
    place.write("scene/dem.vrt", &source("tiles/tile.asc", true));
    let link = r#""crs":{"type":"link","properties":{"href":"http://127.0.0.1:9/crs","type":"ogcwkt"}},"features""#;
    place.write("scene/lake.geojson", &LAKE.replace("\"features\"", link));
    place.assert_refused(
        4,
        &["error[foreign-file] initial[0].reservoir", "lake.geojson asks for http://127.0.0.1:9/crs"],
    );
}

#[test]
fn code_in_a_vrt_is_never_run() {
    let place = Place::new();
    let inner = "<PixelFunctionType>f</PixelFunctionType><PixelFunctionLanguage>Python</PixelFunctionLanguage>\
        <PixelFunctionCode><![CDATA[open('run', 'w')]]></PixelFunctionCode>";
    place.write("scene/dem.vrt", &vrt(r#" subClass="VRTDerivedRasterBand""#, inner));
    for end in ["", "limits: {allow_remote: true}\n"] {
        place.write("scene/s.yaml", &format!("{SCENARIO}{end}"));
        place.assert_refused(4, &["error[code-in-file] terrain.layers[0].raster (s.yaml:4:29)", "Python"]);
    }
    assert!(!place.scene().join("run").exists());
}

#[test]
fn pipes_and_devices_are_refused_at_once() {
    let place = Place::new();
    pipe(&place.scene().join("pipe.csv"));
    for (name, what) in [("pipe.csv", "a named pipe"), ("/dev/zero", "a device")] {
        for (from, key) in
            [("dem.vrt", "terrain.layers[0].raster"), ("lake.geojson", "initial[0]"), ("gauges.csv", "outputs.gauges")]
        {
            place.write("scene/s.yaml", &changed(SCENARIO, &[(from, name)]));
            place.assert_refused(4, &["error[not-a-file]", key, &format!("{name} is {what}, not a file")]);
        }
    }
    // A source of a VRT, the scenario itself, and what is below a name with a colon.
    place.write("scene/dem.vrt", &source("pipe.csv", true));
    place.write("scene/s.yaml", SCENARIO);
    place.assert_refused(4, &["error[not-a-file]", "dem.vrt names it"]);
    place.write("scene/s.yaml", &changed(SCENARIO, &[("dem.vrt", "\"pipe.csv:z\"")]));
    place.assert_refused(4, &["pipe.csv"]);
    let answer = floodsim(&place.scene(), &["check", "pipe.csv"]);
    assert_eq!(answer.code, 3, "{}", answer.stdout);
    assert!(answer.stdout.contains("error[not-a-file]\n  `pipe.csv` is a named pipe"), "{}", answer.stdout);
}

#[test]
fn a_folder_of_a_run_with_pipes_in_it_holds_nobody_up() {
    let place = Place::new();
    let folder = place.scene().join("earlier");
    std::fs::create_dir(&folder).unwrap();
    for name in ["run.json", "checkpoint.bin", "fields.nc", "maps.nc"] {
        pipe(&folder.join(name));
    }
    let earlier = "{fields: earlier/fields.nc}";
    place.write("scene/s.yaml", &changed(SCENARIO, &[("{reservoir: lake.geojson, level: 5 m}", earlier)]));
    for arguments in [&["check", "s.yaml"][..], &["verify", "earlier"], &["report", "earlier"], &["resume", "earlier"]]
    {
        let start = Instant::now();
        let answer = floodsim(&place.scene(), arguments);
        assert!(answer.code != 0, "{arguments:?}");
        assert!(start.elapsed() < Duration::from_secs(20), "{arguments:?}");
    }
}

#[test]
fn a_netcdf_file_whose_head_counts_more_than_it_holds_is_opened_by_no_library() {
    let place = Place::new();
    // A classic file of 28 bytes with 201 million dimensions.
    std::fs::write(place.scene().join("d.nc"), b"CDF\x02\0\0\0\0\0\0\0\x0a\x0c\0\0\0\0\0\0\x05units\0\0\0").unwrap();
    place.write("scene/over.vrt", &source("d.nc", true));
    let rain = "time: {end: 2 s}\nrain: {raster_series: d.nc, unit: mm/h}";
    for (from, to) in
        [("dem.vrt", "d.nc"), ("dem.vrt", "\"d.nc:z\""), ("dem.vrt", "over.vrt"), ("time: {end: 2 s}", rain)]
    {
        place.write("scene/s.yaml", &changed(SCENARIO, &[(from, to)]));
        crate::assert_check(&place.scene(), 4, &["error[not-a-netcdf]", "d.nc cannot be read", "its head counts more"]);
    }
}

#[test]
fn gzipped_points_are_bounded_by_the_memory_limit() {
    let place = Place::new();
    let text = "1000 2000 5\n".repeat(4_000_000);
    place.write("scene/bomb.xyz", &text);
    assert!(Command::new("gzip").arg(place.scene().join("bomb.xyz")).status().unwrap().success());
    assert!(std::fs::metadata(place.scene().join("bomb.xyz.gz")).unwrap().len() < 500_000);
    let layers = "{raster: dem.vrt}, {points: bomb.xyz.gz, max_gap: 10 m}";
    let text = changed(SCENARIO, &[("{raster: dem.vrt}", layers)]) + "limits: {memory: 300 MB}\n";
    place.write("scene/s.yaml", &text);
    place.assert_refused(
        5,
        &["error[memory-limit] terrain.layers[1].points", "unpacked it holds more than 38 MB of text"],
    );
}

#[test]
fn formats_beyond_the_list_are_refused_with_the_list() {
    let place = Place::new();
    let wms = r#"<GDAL_WMS><Service name="TMS"><ServerUrl>http://127.0.0.1:9/${z}</ServerUrl></Service></GDAL_WMS>"#;
    place.write("scene/dem.xml", wms);
    place.write("scene/s.yaml", &changed(SCENARIO, &[("dem.vrt", "dem.xml")]));
    place.assert_refused(4, &["error[not-a-raster]", "drivers AAIGrid, AIG,", "GTiff"]);
    // Nor does a VRT bring one in.
    place.write("scene/dem.vrt", &source("dem.xml", true));
    place.write("scene/s.yaml", SCENARIO);
    place.assert_refused(4, &["error["]);
    let ogr = "<OGRVRTDataSource><OGRVRTLayer name=\"a\"><SrcDataSource>lake.geojson</SrcDataSource></OGRVRTLayer></OGRVRTDataSource>";
    place.write("scene/lake.vrt", ogr);
    place.write("scene/dem.vrt", &source("tiles/tile.asc", true));
    place.write("scene/s.yaml", &changed(SCENARIO, &[("lake.geojson", "lake.vrt")]));
    place.assert_refused(4, &["error[not-a-vector]", "drivers CSV, DXF,", "GeoJSON"]);
}

#[test]
fn a_run_records_and_verify_compares_all_that_it_was_read_from() {
    let place = Place::new();
    place.write("scene/dem.vrt", &source("inner.vrt", true));
    place.write("scene/inner.vrt", &source("tiles/tile.asc", true));
    place.write("scene/tiles/tile.prj", "");
    let unit = "<PAMDataset><PAMRasterBand band=\"1\"><UnitType>m</UnitType></PAMRasterBand></PAMDataset>";
    place.write("scene/tiles/tile.asc.aux.xml", unit);
    let (record, _) = run_scene(&place.scene(), "out", &[]);
    let inputs: Vec<&str> =
        record["inputs"].as_array().unwrap().iter().filter_map(|input| input["path"].as_str()).collect();
    for name in ["dem.vrt", "inner.vrt", "tiles/tile.asc", "tiles/tile.asc.aux.xml", "lake.geojson", "gauges.csv"] {
        assert_eq!(inputs.iter().filter(|path| path.ends_with(name)).count(), 1, "{name} in {inputs:?}");
    }
    assert_eq!(floodsim(&place.scene(), &["verify", "out"]).code, 0);
    for name in ["scene/tiles/tile.asc", "scene/tiles/tile.asc.aux.xml", "scene/inner.vrt"] {
        let before = std::fs::read_to_string(place.0.path().join(name)).unwrap();
        place.write(name, &format!("{before} "));
        let verified = floodsim(&place.scene(), &["verify", "out"]);
        assert_eq!(verified.code, 4, "{name}: {}", verified.stderr);
        assert!(verified.stderr.contains("inputs-changed"), "{}", verified.stderr);
        place.write(name, &before);
    }
}

#[test]
fn statistics_that_a_viewer_leaves_beside_a_raster_are_no_change_of_it() {
    let place = Place::new();
    place.write("scene/dem.vrt", &source("tiles/tile.asc", true));
    let of_band = |entries: &str| {
        let band = format!("<PAMRasterBand band=\"1\">{entries}</PAMRasterBand>");
        place.write("scene/tiles/tile.asc.aux.xml", &format!("<PAMDataset>{band}</PAMDataset>"));
        let (record, _) = run_scene(&place.scene(), "out", &["--overwrite"]);
        record["inputs"].as_array().unwrap().iter().any(|input| input["path"].as_str().unwrap().ends_with(".aux.xml"))
    };
    let statistics =
        r#"<Metadata><MDI key="STATISTICS_MEAN">7</MDI><MDI key="STATISTICS_VALID_PERCENT">100</MDI></Metadata>"#;
    let histogram = "<Histograms><HistItem><HistMin>0</HistMin><BucketCount>1</BucketCount></HistItem></Histograms>";
    assert!(!of_band(&format!("{histogram}{statistics}")));
    for meant in ["<NoDataValue>0</NoDataValue>", "<Offset>1</Offset>", r#"<Metadata><MDI key="X">1</MDI></Metadata>"#]
    {
        assert!(of_band(&format!("{statistics}{meant}")), "{meant}");
    }
}

#[test]
fn names_bring_no_orders_and_no_formulas_into_results() {
    let place = Place::new();
    let gauges = "id,x,y,note\n\"=cmd|' /C calc'!A0\",1075,2075,\"=HYPERLINK(1)\"\n@a,1080,2080,\u{1b}]0;a\u{7}\n-5,1085,2085,\"<script>\"\n";
    place.write("scene/gauges.csv", gauges);
    place.write("scene/s.yaml", &changed(SCENARIO, &[("A basin in a plateau", "\"<b>\\e[31m\\a\\u202E\"")]));
    run_scene(&place.scene(), "out", &[]);
    let report = floodsim(&place.scene(), &["report", "out"]);
    assert_eq!(report.code, 0, "{}", report.stderr);
    let tables = place.scene().join("out/tables");
    let table = std::fs::read_to_string(tables.join("gauges.csv")).unwrap();
    let ids: Vec<&str> = table.lines().skip(1).filter_map(|line| line.split(',').next()).collect();
    assert_eq!(ids, ["'=cmd|' /C calc'!A0", "'@a", "-5"], "{table}");
    let mut waiting = vec![place.scene().join("out")];
    while let Some(path) = waiting.pop() {
        if path.is_dir() {
            waiting.extend(std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|e| ["csv", "svg", "html", "qml", "yaml"].iter().any(|t| e == *t)) {
            let text = std::fs::read_to_string(&path).unwrap();
            let is_order = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
            assert!(!text.contains(is_order), "{}", path.display());
            assert!(
                path.extension().is_some_and(|e| e == "yaml") || !text.contains("<b>\u{fffd}"),
                "{}",
                path.display()
            );
        }
    }
    let gpkg = std::fs::read(place.scene().join("out/results.gpkg")).unwrap();
    assert!(!gpkg.windows(2).any(|pair| pair == b"\x1b]"));
    // The tables are read as they were meant.
    let page = std::fs::read_to_string(place.scene().join("out/report/index.html")).unwrap();
    assert!(page.contains(">=cmd|' /C calc'!A0<") || page.contains("=cmd|") && !page.contains("'=cmd|"), "{page}");
    std::fs::copy(tables.join("gauges.csv"), place.scene().join("gauges.csv")).unwrap();
    run_scene(&place.scene(), "again", &[]);
    assert_eq!(std::fs::read_to_string(place.scene().join("again/tables/gauges.csv")).unwrap(), table);
}

#[test]
fn counts_and_sizes_beyond_all_use_are_refused() {
    let place = Place::new();
    for (from, to, expected) in [
        ("every: 1 s", "every: 1e-6 s", "error[too-many-outputs] outputs.every"),
        ("every: 1 s", "every: 1 s, gauges_every: 1e-6 s", "error[too-many-outputs] outputs.gauges_every"),
        ("level: 5 m", "level: 1e308 m", "error[range] initial[0].level"),
        ("resolution: 5 m", "resolution: 1e300 m", "error[range] resolution"),
        ("end: 2 s", "end: 1e300 s", "error[range] time.end"),
        ("end: 2 s", "end: 2 s, reference: \"99999-01-01\"", "error[date] time.reference"),
        ("title:", "numerics: {cfl: 1e-6}\ntitle:", "error[range] numerics.cfl"),
    ] {
        place.write("scene/s.yaml", &changed(SCENARIO, &[(from, to)]));
        place.assert_refused(3, &[expected]);
    }
    let rows = (0..1000).map(|i| format!("{i},{},2075\n", 1050.0 + 0.05 * f64::from(i)));
    place.write("scene/gauges.csv", &("id,x,y\n".to_owned() + &rows.collect::<String>()));
    place.write("scene/s.yaml", &changed(SCENARIO, &[("every: 1 s", "every: 1 s, gauges_every: 0.1 ms")]));
    let error = "error[too-many-outputs] outputs.gauges (s.yaml:9:";
    place.assert_refused(3, &[error, "1000 places", "set `outputs.gauges_every` to"]);
}
