//! What other programs make of the files: GDAL's tools, xarray with rioxarray, the CF 1.11 checker, and QGIS where it is.
//!
//! Writes run folders through the library, for plain metres and for national grids that are known to be awkward, and lets
//! `read_back.py` open them. The Python packages live in `target/readers-venv`; `scripts/readers.sh` puts them there. Without
//! them the tests say that they are skipped, unless `FLOODSIM_REQUIRE_READERS=1` asks for them.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

use floodsim::constants::OutputConstants;
use floodsim::error::{Problem, ProblemKind};
use floodsim::lattice::{FlatWater, Lattice, Span, WaterOnLattice};
use floodsim::math::Vec2;
use floodsim::output::{
    FieldsWriter, FileHead, Findings, Gauge, OutputCrs, Provenance, Recorder, RecorderPlan, Recording, RunFolder,
    RunManifest, Section, SectionRecorder, Volumes, map_variables, write_cogs, write_gauges, write_geopackage,
    write_maps, write_mass_balance, write_sections,
};
use gdal::spatial_ref::SpatialRef;
use gdal::vector::LayerAccess;

const COLUMNS: usize = 60;
const ROWS: usize = 40;
const SPACING: f64 = 20.0;
const END: f64 = 600.0;
const RISE_ON_WET: f64 = 0.1;

/// A program that is started while a file of HDF5 is written gets that file, too, and with it the lock of HDF5: the file can't be opened again then.
static WRITING_OR_STARTING: Mutex<()> = Mutex::new(());

fn crs_of(epsg: Option<u32>) -> OutputCrs {
    let Some(epsg) = epsg else {
        return OutputCrs::Local;
    };
    gdal::config::set_thread_local_config_option("OSR_WKT_FORMAT", "WKT2_2019").unwrap();
    let wkt2 = SpatialRef::from_epsg(epsg).unwrap().to_wkt().unwrap();
    gdal::config::clear_thread_local_config_option("OSR_WKT_FORMAT").unwrap();
    OutputCrs::Projected { wkt2, authority: Some(format!("EPSG:{epsg}")) }
}

fn provenance(date: &str) -> Provenance {
    Provenance {
        title: "A made valley, \"trial\" & <check>".into(),
        institution: "floodsim tests".into(),
        source: format!("floodsim {}", env!("CARGO_PKG_VERSION")),
        history: format!("{date} floodsim scenario.yaml"),
        references: "docs/theory.md".into(),
        comment: String::new(),
        date_created: date.into(),
        reference_time: None,
    }
}

fn plan(origin: Vec2, cell: f64) -> RecorderPlan {
    let lattice = Lattice::new(origin, COLUMNS, ROWS, SPACING);
    let elevation = |index: usize| {
        let (column, row) = lattice.column_row(index);
        let is_gap = column + row < 8; // no terrain in the south-western corner
        if is_gap { f64::NAN } else { 100.0 - 0.2 * column as f64 + 0.02 * (row as f64 - 20.0).powi(2) }
    };
    let gauge = |id: &str, column: f64, row: f64| Gauge {
        id: id.into(),
        position: origin + Vec2::new(column * SPACING, row * SPACING),
        attributes: vec![("name".into(), format!("mill, \"{id}\"")), ("ID".into(), "own".into())],
    };
    RecorderPlan {
        more_area: vec![],
        bed_elevation: (0..lattice.len()).map(elevation).collect(),
        lattice: lattice.clone(),
        cell,
        terrain: None,
        thresholds: vec![0.1, 0.305, 1.0],
        rise_on_wet: RISE_ON_WET,
        every: 100.0,
        end_time: END,
        gauges: vec![gauge("G1", 20.5, 20.5), gauge("dry", 50.5, 38.5)],
        walls: Vec::new(),
        raised: Vec::new(),
        followed: Vec::new(),
        at_banks: Vec::new(),
        constants: OutputConstants::DEFAULT,
        gauges_every: 60.0,
        sections: vec![vec![20 * COLUMNS + 20]],
        closed_edge: vec![],
        tracers: vec![],
    }
}

/// A front that runs down the valley at 2 m/s, with a hole of dry ground in its middle.
fn depth_at(lattice: &Lattice, bed: &[f64], index: usize, time: f64) -> f64 {
    let place = lattice.centre(index);
    let behind_front = 200.0 + 2.0 * time - place.x;
    let beside = (place.y - 400.0).abs();
    let on_island = Vec2::new(place.x - 500.0, place.y - 400.0).norm() < 70.0;
    if bed[index].is_nan() || on_island { 0.0 } else { (0.004 * behind_front.min(500.0) - 0.01 * beside).max(0.0) }
}

fn record(plan: &RecorderPlan, fields: &mut FieldsWriter, recorder: Recorder) -> Recording {
    let mut recorder = recorder;
    let cells = plan.lattice.len();
    let spans: Vec<Span> = (0..ROWS as u32).map(|row| Span { row, from: 0, to: COLUMNS as u32 }).collect();
    for step in 0..=80_u32 {
        let time = f64::from(step) * 7.5;
        let depth: Vec<f64> =
            (0..cells).map(|index| depth_at(&plan.lattice, &plan.bed_elevation, index, time)).collect();
        let discharge_x: Vec<f64> = depth.iter().map(|depth| 2.0 * depth).collect();
        let rows = FlatWater { columns: COLUMNS, depth, discharge_x, discharge_y: vec![0.0; cells] };
        let water = WaterOnLattice { rows: &rows, lattice: &plan.lattice, spans: &spans };
        let stored = rows.depth.iter().sum::<f64>() * plan.lattice.cell_area();
        let volumes = Volumes { stored, ..Volumes::default() };
        let mut sink = |frame| fields.push(frame);
        match step {
            0 => recorder.start(&water, volumes, &mut sink),
            _ => recorder.step(time, &water, volumes, &mut sink),
        }
        .unwrap();
    }
    recorder.finish()
}

/// Writes a whole run folder.
fn write_run(path: &Path, crs: &OutputCrs, origin: Vec2, cell: f64, date: &str) -> RunFolder {
    let _alone = WRITING_OR_STARTING.lock();
    let folder = RunFolder::create(path, true).unwrap();
    let mut manifest = RunManifest { status: "running".into(), ..RunManifest::default() };
    manifest.write(&folder).unwrap();
    let plan = plan(origin, cell);
    let provenance = provenance(date);
    let recorder = Recorder::new(plan.clone());
    let grid = recorder.grid().clone();
    let head = FileHead { crs, provenance: &provenance };
    let mut fields = FieldsWriter::start(&folder, &grid, head, &[], 0).unwrap();
    let recording = record(&plan, &mut fields, recorder);
    fields.finish().unwrap();
    write_maps(&folder, &grid, head, &recording.maps, recording.end_time, RISE_ON_WET).unwrap();
    write_cogs(&folder, &grid, head, &map_variables(&recording.maps, RISE_ON_WET)).unwrap();
    let finding = Problem::warning(ProblemKind::Input, "leak", "initial[0]", "the rim leaks")
        .with_remedy("raise the rim")
        .with_at(origin + Vec2::new(100.0, 100.0));
    let isochrones = [60.0, 180.0, 300.0];
    let section = Section { id: "bridge".into(), line: vec![origin, origin + Vec2::new(50.0, 70.0)] };
    let mut sections = SectionRecorder::new(1, 60.0, END);
    sections.step(END, std::iter::once((2.5, 2.5 * END)));
    let sections = sections.finish(&recording.section_arrivals);
    let findings = Findings {
        gauges: &plan.gauges,
        banks: &[],
        ridges: &[],
        sections: std::slice::from_ref(&section),
        section_results: &sections.results,
        isochrones: &isochrones,
        problems: &[finding],
    };
    write_geopackage(&folder, &grid, crs, &recording, &findings).unwrap();
    write_sections(&folder, head, std::slice::from_ref(&section), &sections).unwrap();
    write_gauges(&folder, &plan.gauges, &recording).unwrap();
    write_mass_balance(&folder, &recording).unwrap();
    (manifest.status, manifest.exit_code) = ("done".into(), Some(0));
    manifest.write(&folder).unwrap();
    folder
}

/// A place where the grid is at home.
fn origin_of(epsg: Option<u32>) -> Vec2 {
    match epsg {
        Some(2056) => Vec2::new(2_600_000.0, 1_200_000.0),
        Some(27572) => Vec2::new(953_000.0, 1_832_000.0),
        Some(28992) => Vec2::new(155_000.0, 463_000.0),
        Some(3035) => Vec2::new(4_321_000.0, 3_210_000.0),
        Some(_) => Vec2::new(500_000.0, 5_190_000.0),
        None => Vec2::new(1000.0, 2000.0),
    }
}

fn place(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("readers").join(name)
}

/// The interpreter with the readers; none after saying why, unless they are required.
fn interpreter() -> Option<PathBuf> {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().to_path_buf();
    let python = target.join("readers-venv/bin/python");
    if python.exists() {
        return Some(python);
    }
    let required = std::env::var("FLOODSIM_REQUIRE_READERS").is_ok_and(|value| value == "1");
    assert!(!required, "{} is missing: run scripts/readers.sh", python.display());
    eprintln!("skipped: {} is missing; scripts/readers.sh installs the readers", python.display());
    None
}

fn read_back(folder: &RunFolder, arguments: &[String]) {
    let Some(python) = interpreter() else { return };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers/read_back.py");
    let mut command = Command::new(python);
    command.arg(script).arg(folder.path()).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = {
        let _alone = WRITING_OR_STARTING.lock();
        command.spawn().unwrap()
    };
    let output = child.wait_with_output().unwrap();
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{text}");
    println!("{text}");
}

fn check(epsg: Option<u32>, cell: f64) {
    let name = format!("{}_{cell}", epsg.map_or("local".into(), |epsg| epsg.to_string()));
    let origin = origin_of(epsg);
    let folder = write_run(&place(&name), &crs_of(epsg), origin, cell, "2026-11-21T00:00:00Z");
    check_geopackage(&folder, epsg);
    let north = origin.y + ROWS as f64 * SPACING;
    let epsg = epsg.map_or("local".to_string(), |epsg| epsg.to_string());
    read_back(&folder, &[epsg, origin.x.to_string(), north.to_string(), cell.to_string()]);
}

fn check_geopackage(folder: &RunFolder, epsg: Option<u32>) {
    let dataset = gdal::Dataset::open(folder.file("results.gpkg")).unwrap();
    let crs = dataset.layer_by_name("gauges").unwrap().spatial_ref();
    match epsg {
        Some(epsg) => assert_eq!(crs.unwrap().auth_code().unwrap() as u32, epsg),
        None => assert!(crs.is_none_or(|crs| crs.is_local()), "plain metres got a place on Earth"),
    }
    let mut counts = Vec::new();
    for name in ["inundation_extent", "isochrones", "gauges", "findings", "layer_styles"] {
        let mut layer = dataset.layer_by_name(name).unwrap();
        counts.push(layer.feature_count());
        for feature in layer.features() {
            if let Some(geometry) = feature.geometry() {
                assert!(geometry.is_valid(), "{name} has a geometry that is not valid");
            }
        }
    }
    // A style for each of the layers, that of the cross-sections included.
    assert_eq!(counts, [1, 3, 2, 1, 5]);
    let mut gauges = dataset.layer_by_name("gauges").unwrap();
    let dry = gauges.features().nth(1).unwrap();
    let arrival = dry.field_index("arrival_s").unwrap();
    assert_eq!(dry.field(arrival).unwrap(), None, "a dry gauge has no arrival");
    assert!(dry.field_index("ID_2").is_ok(), "the file's own column is kept beside ours");
}

#[test]
fn plain_metres() {
    check(None, SPACING);
}

#[test]
fn utm() {
    check(Some(32632), SPACING);
}

#[test]
fn utm_with_other_cells() {
    check(Some(32632), 50.0);
    check(Some(32632), 10.0);
}

#[test]
fn swiss() {
    check(Some(2056), SPACING);
}

#[test]
fn french_lambert() {
    check(Some(27572), SPACING);
}

#[test]
fn european_equal_area() {
    check(Some(3035), SPACING);
}

/// A grid whose projection CF has no name for.
#[test]
fn dutch() {
    check(Some(28992), SPACING);
}

#[test]
fn fields_cannot_start_in_a_folder_that_is_gone() {
    let folder = RunFolder::create(&place("gone"), true).unwrap();
    std::fs::remove_dir_all(folder.path()).unwrap();
    let recorder = Recorder::new(plan(Vec2::ZERO, SPACING));
    let provenance = provenance("2026-11-21T00:00:00Z");
    let head = FileHead { crs: &OutputCrs::Local, provenance: &provenance };
    let Err(error) = FieldsWriter::start(&folder, recorder.grid(), head, &[], 0) else {
        panic!("a file was created in a folder that is not there")
    };
    assert_eq!(error.exit_code(), floodsim::error::ExitCode::Output);
    assert!(error.to_string().contains("fields.partial.nc"), "{error}");
}

#[test]
fn unfinished_run_can_be_read() {
    let folder = RunFolder::create(&place("unfinished"), true).unwrap();
    let plan = plan(origin_of(Some(32632)), SPACING);
    let recorder = Recorder::new(plan.clone());
    let (crs, provenance) = (crs_of(Some(32632)), provenance("2026-11-21T00:00:00Z"));
    let head = FileHead { crs: &crs, provenance: &provenance };
    let mut fields = FieldsWriter::start(&folder, recorder.grid(), head, &[], 0).unwrap();
    record(&plan, &mut fields, recorder);
    drop(fields);
    assert!(!folder.file("fields.nc").exists(), "an unfinished run must not look whole");
    read_back(&folder, &["partial".into()]);
}

#[test]
fn equal_results_give_equal_bytes() {
    let crs = crs_of(Some(2056));
    let origin = origin_of(Some(2056));
    let date = "2026-11-21T00:00:00Z";
    let first = write_run(&place("bytes_1"), &crs, origin, SPACING, date);
    // Formats that store the time of writing do so in seconds.
    std::thread::sleep(std::time::Duration::from_millis(1100));
    let second = write_run(&place("bytes_2"), &crs, origin, SPACING, date);
    let mut files: Vec<String> =
        ["run.json", "fields.nc", "maps.nc", "sections.nc", "results.gpkg"].map(String::from).to_vec();
    for part in ["cog", "tables"] {
        let entries = std::fs::read_dir(first.file(part)).unwrap();
        files.extend(entries.map(|entry| format!("{part}/{}", entry.unwrap().file_name().to_string_lossy())));
    }
    assert_eq!(files.len(), 5 + 2 * 16 + 5);
    for file in files {
        let [first, second] = [&first, &second].map(|folder| std::fs::read(folder.file(&file)).unwrap());
        assert!(first == second, "{file} differs between two equal runs");
    }
}
