//! Runs that go on from cells of another size: of another lattice, and of levels.

use super::*;

/// Ways to lay cells over the valley of 300 m by 125 m, with the finest and the coarsest edge (m); the last one shares parts of 1.25 m with the first.
const CELLS: [(&str, [f64; 2], &str); 4] = [
    ("fine", [2.5, 2.5], "resolution=2.5 m"),
    ("coarse", [5.0, 5.0], "resolution=5 m"),
    (
        "levels",
        [1.25, 5.0],
        "resolution={finest: 1.25 m, coarsest: 5 m, refine: [{lines: axis.geojson, within: 20 m, to: 1.25 m}]}",
    ),
    ("uneven", [3.75, 3.75], "resolution=3.75 m"),
];

/// The edge (m) of the cells of a frame.
fn edge(fields: &Netcdf) -> f64 {
    let x = fields.values("x");
    x[1] - x[0]
}

/// A variable of a frame, the last one for none, with 0 where it has no value.
fn values(fields: &Netcdf, name: &str, number: Option<usize>) -> Vec<f64> {
    let cells = fields.dimensions["x"] * fields.dimensions["y"];
    let number = number.unwrap_or(fields.dimensions["time"] - 1);
    fields.values(name)[number * cells..][..cells]
        .iter()
        .map(|&value| if value > -9000.0 { value } else { 0.0 })
        .collect()
}

/// The volume (m³) of a frame.
fn volume_in(fields: &Netcdf, number: Option<usize>) -> f64 {
    values(fields, "depth", number).iter().sum::<f64>() * edge(fields).powi(2)
}

/// The depths (m) of the last frame in stripes of 15 m across the valley, volume over the area of 125 m by 15 m.
fn along_the_valley(fields: &Netcdf) -> Vec<f64> {
    let (columns, depth) = (fields.dimensions["x"], values(fields, "depth", None));
    let mut stripes = vec![0.0; 20];
    for (cell, depth) in depth.iter().enumerate() {
        let from_west = fields.values("x")[cell % columns] - 500_000.0;
        stripes[((from_west / 15.0) as usize).min(19)] += depth * edge(fields).powi(2) / (15.0 * 125.0);
    }
    stripes
}

fn root_mean_square(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

fn scene() -> Scene {
    let scene = Scene::sound();
    scene.feature("axis.geojson", "LineString", "[[500000,5300060],[500300,5300060]]");
    scene
}

#[test]
fn the_second_half_may_have_other_cells_than_the_first() {
    let scene = scene();
    let whole: Vec<Vec<f64>> = CELLS
        .iter()
        .map(|(name, _, cells)| along_the_valley(&scene.run(&format!("whole_{name}"), &[cells]).1))
        .collect();
    // By how much the size of the cells alone changes the end.
    let pairs = whole.iter().flat_map(|a| whole.iter().map(move |b| root_mean_square(a, b)));
    let of_cells = pairs.fold(0.0, f64::max);
    println!("the wholes differ by {of_cells:.4} m at most");
    for (first, _, cells) in CELLS {
        let (_, before) = scene.run(first, &["time.end=30 s", cells]);
        for (b, (second, _, cells)) in CELLS.iter().enumerate() {
            // The same cells are those of `two_halves_are_the_whole`.
            if first == *second {
                continue;
            }
            let go_on = format!("initial=[{{fields: {first}/fields.nc}}]");
            let (run, after) = scene.run(&format!("{first}_{second}"), &["time.end=30 s", cells, &go_on]);
            let handed_on = volume(&run, "initial") / volume_in(&before, None) - 1.0;
            let off = root_mean_square(&along_the_valley(&after), &whole[b]);
            println!("{first} -> {second}: volume {handed_on:+.1e}, {off:.4} m off");
            assert!(handed_on.abs() < 1e-6, "{first} to {second}: {handed_on:e} of the volume");
            assert!(off < of_cells, "{first} to {second}: {off} m");
        }
    }
}

#[test]
fn a_lake_behind_a_wall_rests_on_other_cells() {
    let scene = scene();
    lake_behind(&scene, "wall.geojson");
    let wall = "structures={walls: [{lines: wall.geojson}]}";
    rests_on_other_cells(&scene, &["initial[0].level=105.3 m", wall], 0.01);
}

#[test]
fn a_lake_over_ground_that_is_shaped_rests_on_other_cells() {
    let scene = scene();
    // All of the valley under water, with a levee and a ditch on its ground, and terrain that ends inside cells.
    scene.feature("levee.geojson", "LineString", "[[500100,5300050],[500109,5300075]]");
    scene.feature("ditch.geojson", "LineString", "[[500003,5300060],[500297,5300071]]");
    scene.flood_all();
    let lines = "[{lines: levee.geojson, mode: raise, z: 106 m}, {lines: ditch.geojson, mode: carve, z: 101.5 m}]";
    let ground = format!("terrain={{layers: [{{raster: dem.asc}}], breaklines: {lines}}}");
    rests_on_other_cells(&scene, &["initial[0].level=107.3 m", &ground], 0.2);
}

#[test]
fn a_lake_behind_a_dam_rests_on_other_cells() {
    let scene = scene();
    lake_behind(&scene, "dam.geojson");
    let dam = "breach={dam: dam.geojson, crest: 110 m, trigger: {level: 109 m, at_point: [500100, 5300060]}, growth: instantaneous}";
    rests_on_other_cells(&scene, &["initial[0].level=105.3 m", dam], 0.1);
}

/// A line across the valley at 70 degrees, which leaves no room at its ends, and a lake on all of the valley above it.
fn lake_behind(scene: &Scene, line: &str) {
    scene.feature(line, "LineString", "[[500180,5300000],[500225.5,5300125]]");
    let above = "[[[500000,5300000],[500178,5300000],[500223.5,5300125],[500000,5300125],[500000,5300000]]]";
    scene.feature("lake.geojson", "Polygon", above);
}

/// A lake on each of the kinds of cells goes on at rest on each, and keeps its volume up to a share of it.
#[track_caller]
fn rests_on_other_cells(scene: &Scene, changes: &[&str], of_volume: f64) {
    let (level, changes) = changes.split_first().unwrap();
    let still = [&["boundaries=[]", "time.end=10 s", "rain={rate: 0 mm/h}"][..], changes].concat();
    let speed = |fields: &Netcdf| {
        let [u, v] = ["velocity_x", "velocity_y"].map(|name| values(fields, name, None));
        u.iter().zip(&v).map(|(u, v)| u.hypot(*v)).fold(0.0, f64::max)
    };
    for (first, of_first, cells) in CELLS {
        let (held, before) = scene.run(first, &[&still[..], &[level, cells]].concat());
        assert!(speed(&before) < 1e-12, "{first}: {:e} m/s", speed(&before));
        for (second, of_second, cells) in CELLS {
            let go_on = format!("initial=[{{fields: {first}/fields.nc}}]");
            let (run, after) = scene.run(&format!("{first}_{second}"), &[&still[..], &[cells, &go_on]].concat());
            let handed_on = volume(&run, "initial") / volume(&held, "final") - 1.0;
            println!("{first} -> {second}: volume {handed_on:+.1e}, {:.1e} m/s", speed(&after));
            // Beside walls and dams cells are filled up or cut; there, and at the shore, smaller cells find lower ground than larger ones had.
            let volume = if first == second { 1e-6 } else { of_volume };
            let fastest = if first == second || of_second[0] >= of_first[1] { 1e-11 } else { 0.5 };
            assert!(handed_on.abs() < volume, "{first} to {second}: {handed_on:e} of the volume");
            assert!(speed(&after) < fastest, "{first} to {second}: {:e} m/s", speed(&after));
        }
    }
}

#[test]
fn water_that_wide_cells_have_no_room_for_is_told() {
    let scene = scene();
    // A levee across the valley that holds a lake; on wide cells it takes some of the lake's ground.
    scene.feature("levee.geojson", "LineString", "[[500107,5300000],[500107,5300125]]");
    let levee = "terrain={layers: [{raster: dem.asc}], breaklines: [{lines: levee.geojson, mode: raise, z: 130 m}]}";
    let (_, before) = scene.run("first", &["boundaries=[]", "time.end=5 s", "initial[0].level=106 m", levee]);
    let wide = ["initial=[{fields: first/fields.nc}]", "resolution=10 m", "boundaries=[]", "time.end=5 s", levee];
    let has = format!("of {:.3e} m³ that first/fields.nc has", volume_in(&before, None));
    scene.assert_check(&wide, 0, &["warning[volume-of-earlier-run] initial[0].fields", &has, "remedy"]);
    let (run, _) = scene.run("second", &wide);
    let kept = volume(&run, "initial") / volume_in(&before, None);
    assert!((0.8..0.999).contains(&kept), "{kept} of the volume");
}

#[test]
fn levels_whose_sizes_are_not_known_are_told() {
    let scene = scene();
    let levels = CELLS[2].2;
    scene.run("first", &["time.end=5 s", levels, "outputs.write=[fields, tables]"]);
    let told = ["warning[levels-of-earlier-run] initial[0].fields", "first/maps.nc", "remedy"];
    scene.assert_check(&["time.end=5 s", levels, "initial=[{fields: first/fields.nc}]"], 0, &told);
}
