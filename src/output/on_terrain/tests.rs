//! Maps on pixels against water whose depth at each of them is known by hand.

use super::*;
use crate::bed::PassSill;

const SPACING: f64 = 10.0;
const PIXELS: usize = 10;

/// Terrain and water of a row of cells, ten pixels of 1 m to a side.
struct Scene<'a> {
    columns: usize,
    rows: usize,
    /// Elevation (m) at a place.
    terrain: &'a dyn Fn(Vec2) -> f64,
    /// Greatest depth (m) of a cell over its mean bed (m).
    depth: &'a dyn Fn(usize, f64) -> f64,
    passes: Vec<PassSill>,
    walls: Vec<[Vec2; 2]>,
}

impl Scene<'_> {
    fn pixels(&self) -> TerrainPixels {
        let (columns, rows) = (self.columns * PIXELS, self.rows * PIXELS);
        let north = 500.0 + rows as f64;
        let place = |pixel: usize| Vec2::new((pixel % columns) as f64 + 0.5, (rows - pixel / columns) as f64 - 0.5);
        let elevation = (0..columns * rows).map(|pixel| (self.terrain)(place(pixel)) as f32).collect();
        TerrainPixels { west: 300.0, north, cell: 1.0, columns, rows, elevation }
    }

    fn maps(&self) -> GridMaps {
        let origin = Vec2::new(300.0, 500.0);
        let lattice = Lattice::new(origin, self.columns, self.rows, SPACING);
        let pixels = self.pixels();
        let mean = |cell: usize| {
            let (column, row) = lattice.column_row(cell);
            let first = (self.rows - 1 - row) * PIXELS * pixels.columns + column * PIXELS;
            let block = (0..PIXELS).flat_map(|down| (0..PIXELS).map(move |across| (down, across)));
            block.map(|(down, across)| f64::from(pixels.elevation[first + down * pixels.columns + across])).sum::<f64>()
                / (PIXELS * PIXELS) as f64
        };
        let bed: Vec<f64> = (0..lattice.len()).map(mean).collect();
        let depth: Vec<f64> = (0..lattice.len()).map(|cell| (self.depth)(cell, bed[cell])).collect();
        let seen = |cell: usize| Seen {
            max_depth: depth[cell],
            time_of_max_depth: if depth[cell] > 0.0 { 90.0 } else { f64::NAN },
            max_speed: 2.0,
            max_depth_velocity: 1.5 * depth[cell],
            hazard_class: hazard_class(depth[cell], 1.5),
        };
        let thresholds = [0.1, 0.5];
        let of_threshold = |cell: usize, which: usize| ThresholdSeen {
            arrival: if depth[cell] >= thresholds[which] { 10.0 * (which + 1) as f64 } else { f64::NAN },
            duration: if depth[cell] >= thresholds[which] { 60.0 } else { 0.0 },
            recession: f64::NAN,
        };
        let tracers = Tracers::new(Vec::new(), &lattice);
        OnTerrain::new(lattice, pixels, PassSills::new(self.passes.clone()), &self.walls).maps(&WaterOfCells {
            bed: &bed,
            bed_at_start: &BTreeMap::new(),
            level: &|cell| bed[cell] + depth[cell],
            seen: &seen,
            thresholds: &thresholds,
            seen_of_threshold: &of_threshold,
            tracers: &tracers,
        })
    }

    /// The depth at a place.
    fn at(&self, maps: &GridMaps, x: f64, y: f64) -> f64 {
        let (columns, rows) = (self.columns * PIXELS, self.rows * PIXELS);
        f64::from(maps.max_depth[(rows - 1 - y as usize) * columns + x as usize])
    }
}

/// A row of cells whose water has a level at rest (m).
fn lake(level: f64) -> impl Fn(usize, f64) -> f64 {
    move |_, bed| (level - bed).max(0.0)
}

#[test]
fn a_lake_ends_at_its_contour_and_is_level_less_terrain() {
    // A shore askew, which divides cells at any share, and a hollow beyond a hill that the water does not reach.
    let terrain = |place: Vec2| {
        let hollow = (place - Vec2::new(65.0, 25.0)).norm() < 2.0;
        if hollow { 8.0 } else { 9.0 + 0.04 * place.x + 0.013 * place.y }
    };
    let scene = Scene { columns: 8, rows: 5, terrain: &terrain, depth: &lake(10.0), passes: vec![], walls: vec![] };
    let (maps, pixels) = (scene.maps(), scene.pixels());
    let mut wet = 0;
    for (pixel, (&depth, &z)) in maps.max_depth.iter().zip(&pixels.elevation).enumerate() {
        let place = Vec2::new((pixel % 80) as f64 + 0.5, 49.5 - (pixel / 80) as f64);
        let is_hollow = (place - Vec2::new(65.0, 25.0)).norm() < 2.0;
        let expected = if is_hollow { 0.0 } else { (10.0 - f64::from(z)).max(0.0) };
        // Less than a millimetre counts as dry.
        assert!((f64::from(depth) - expected).abs() < 1.1e-3, "{place:?}: {depth} m in place of {expected} m");
        wet += usize::from(depth > 0.0);
    }
    assert!(wet > 500, "{wet} wet pixels");
    assert!((f64::from(maps.max_water_level[49 * 80]) - 10.0).abs() < 1e-5);
}

#[test]
fn a_sheet_on_a_slope_is_as_deep_everywhere_and_its_front_ends_with_its_cell() {
    let terrain = |place: Vec2| 50.0 - 0.1 * place.x;
    let sheet = |cell: usize, _| if cell % 6 < 4 { 0.02 } else { 0.0 };
    let scene = Scene { columns: 6, rows: 3, terrain: &terrain, depth: &sheet, passes: vec![], walls: vec![] };
    let maps = scene.maps();
    // Not at the upper end, where nothing tells how the level goes on.
    for x in 5..40 {
        let depth = scene.at(&maps, f64::from(x) + 0.5, 15.0);
        assert!((depth - 0.02).abs() < 1e-4, "{depth} m at {x} m");
    }
    for x in 40..60 {
        assert!(scene.at(&maps, f64::from(x) + 0.5, 15.0) <= 0.0, "beyond the front at {x} m");
    }
}

#[test]
fn water_does_not_show_behind_a_levee_inside_a_cell() {
    // A crest of two pixels in the second cell; behind it the ground is lower than before it.
    let terrain = |place: Vec2| match place.x {
        x if x < 14.0 => 10.0,
        x if x < 16.0 => 13.0,
        _ => 9.5,
    };
    let held = |cell: usize, bed: f64| if cell.is_multiple_of(4) { 11.0 - bed } else { 0.0 };
    let sill = |cell: usize| PassSill::whole(cell, false, 13.0);
    let passes = vec![sill(0), sill(4), sill(8)];
    let scene = Scene { columns: 4, rows: 3, terrain: &terrain, depth: &held, passes, walls: vec![] };
    let maps = scene.maps();
    assert!((scene.at(&maps, 9.5, 15.0) - 1.0).abs() < 1e-6, "level up to the levee");
    assert!((scene.at(&maps, 13.5, 15.0) - 1.0).abs() < 1e-6, "up to the levee, whose cell is dry");
    assert!((14..40).all(|x| scene.at(&maps, f64::from(x) + 0.5, 15.0) <= 0.0), "nothing comes behind it");
    // Without a levee the water could have run on, and did not.
    let terrain = |place: Vec2| if place.x < 10.0 { 10.0 } else { 9.5 };
    let scene = Scene { terrain: &terrain, passes: vec![], ..scene };
    let maps = scene.maps();
    assert!(scene.at(&maps, 5.0, 15.0) > 0.9 && (10..40).all(|x| scene.at(&maps, f64::from(x) + 0.5, 15.0) <= 0.0));
}

#[test]
fn levels_on_both_sides_of_a_wall_or_of_a_ridge_stay_apart() {
    let terrain = |_: Vec2| 5.0;
    let two = |cell: usize, bed: f64| if cell % 4 < 2 { 10.0 - bed } else { 6.0 - bed };
    let wall = [Vec2::new(20.0, -1.0), Vec2::new(20.0, 31.0)];
    let sill = |row: usize| PassSill::whole(row * 4 + 1, false, 12.0);
    let open = Scene { columns: 4, rows: 3, terrain: &terrain, depth: &two, passes: vec![], walls: vec![] };
    let walled = Scene { walls: vec![wall], passes: vec![], ..open };
    let ridged = Scene { passes: [0, 1, 2].map(sill).to_vec(), walls: vec![], ..walled };
    for scene in [Scene { walls: vec![wall], passes: vec![], ..ridged }, ridged] {
        let maps = scene.maps();
        for x in 0..40 {
            let expected = if x < 20 { 5.0 } else { 1.0 };
            let depth = scene.at(&maps, f64::from(x) + 0.5, 15.0);
            assert!((depth - expected).abs() < 1e-6, "{depth} m at {x} m");
        }
    }
}

#[test]
fn a_pixel_has_the_times_of_the_highest_threshold_that_its_cell_reached_first() {
    // The high pixels stand 0.45 m over the mean of their cell: 0.1 m there are 0.55 m of the cell. The low ones lie 0.05 m below it: they
    // are 0.5 m deep when the cell has 0.45 m, some time after it had 0.1 m.
    let terrain = |place: Vec2| if (10.0..11.0).contains(&place.x) { 10.5 } else { 10.0 };
    let scene = Scene { columns: 3, rows: 1, terrain: &terrain, depth: &lake(10.8), passes: vec![], walls: vec![] };
    let maps = scene.maps();
    let (low, high) = (5 * 30 + 15, 5 * 30 + 10);
    assert!((maps.max_depth[high] - 0.3).abs() < 1e-5 && (maps.max_depth[low] - 0.8).abs() < 1e-5);
    let arrivals = |pixel: usize| [0, 1].map(|which: usize| maps.thresholds[which].arrival[pixel] as i32);
    assert_eq!((arrivals(low), arrivals(high)), ([10, 10], [20, FILL as i32]));
    // Deeper than its cell it is in a higher class than it, shallower in none that is higher.
    assert!(maps.hazard_class[low] >= f32::from(hazard_class(0.8, 1.5)));
    assert!(maps.hazard_class[high] <= f32::from(hazard_class(0.75, 1.5)));
    assert!((maps.max_depth_velocity[high] - 0.45).abs() < 1e-5, "1.5 m/s in 0.3 m");
}

#[test]
fn every_wet_cell_shows_and_ground_without_terrain_is_filled() {
    // A film on ground whose pixels stand apart by more than it is deep.
    let terrain = |place: Vec2| {
        let (x, y) = (place.x as usize, place.y as usize);
        if x >= 20 { f64::NAN } else { 3.0 + 0.5 * ((x * 7 + y * 13) % 10) as f64 }
    };
    let film = |_, bed: f64| if bed.is_nan() { 0.0 } else { 0.002 };
    let scene = Scene { columns: 3, rows: 1, terrain: &terrain, depth: &film, passes: vec![], walls: vec![] };
    let maps = scene.maps();
    for cell in 0..2 {
        let wet = (0..100).filter(|k| scene.at(&maps, (cell * 10 + k % 10) as f64, (k / 10) as f64) > 0.001).count();
        assert!(wet > 0 && wet < 100, "{wet} pixels of cell {cell}");
    }
    assert!((maps.max_depth[25] - FILL).abs() < 1e-6 && (maps.bed_elevation[25] - FILL).abs() < 1e-6);
}
