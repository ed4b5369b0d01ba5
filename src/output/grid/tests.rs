use super::*;
use crate::lattice::{FlatWater, Span, WaterOnLattice};

fn lattice() -> Lattice {
    Lattice::new(Vec2::new(500.0, 900.0), 7, 5, 2.0)
}

/// Fills in a row of the lattice from the water of each cell.
fn by_index(water: impl Fn(usize) -> WaterInCell) -> impl Fn(usize, &mut [WaterInCell]) {
    move |row, cells| {
        let first = row * cells.len();
        cells.iter_mut().enumerate().for_each(|(column, cell)| *cell = water(first + column));
    }
}

#[test]
fn lattice_cells_are_taken_as_they_are_and_turned_north_up() {
    let lattice = lattice();
    let bed: Vec<f64> = (0..lattice.len()).map(|index| index as f64).collect();
    let grid = OutputGrid::new(&lattice, 2.0, &bed);
    assert_eq!((grid.columns, grid.rows), (7, 5));
    assert_eq!((grid.west, grid.north), (500.0, 910.0));
    let depth: Vec<f64> = (0..lattice.len()).map(|index| 1.0 + index as f64).collect();
    let frame = grid.frame(
        3.0,
        &bed,
        by_index(|index| {
            let depth = depth[index];
            WaterInCell { depth, discharge_x: depth, discharge_y: 0.0 }
        }),
    );
    assert_eq!(frame.depth[0], 1.0 + 28.0, "the first value is the north-western cell");
    assert_eq!(frame.depth[4 * 7], 1.0, "the first value of the last row is the south-western cell");
    assert_eq!(frame.water_level[4 * 7 + 1], 1.0 + 2.0);
    assert_eq!(frame.velocity_x[9], 1.0);
}

#[test]
fn volume_is_kept_for_any_cell() {
    let lattice = lattice();
    let mut bed = vec![10.0; lattice.len()];
    bed[11] = f64::NAN;
    let depth: Vec<f64> = (0..lattice.len()).map(|index| if index == 11 { 0.0 } else { 0.1 * index as f64 }).collect();
    let volume = depth.iter().sum::<f64>() * lattice.cell_area();
    for cell in [0.5, 1.0, 2.0, 3.0, 4.0, 7.3, 20.0] {
        let grid = OutputGrid::new(&lattice, cell, &bed);
        let water = by_index(|index| {
            let depth = depth[index];
            WaterInCell { depth, discharge_x: depth, discharge_y: depth }
        });
        let frame = grid.frame(0.0, &bed, &water);
        let error = grid.volume(&frame.depth) / volume - 1.0;
        assert_eq!(grid.volume_of(&bed, &water), grid.volume(&frame.depth));
        assert!(error.abs() < 1e-6, "cell {cell}: {error:e}, more than the rounding of single precision");
    }
}

#[test]
fn a_level_lake_is_level_and_a_plane_lies_where_it_was_in_any_cell() {
    let lattice = lattice();
    let plane = |place: Vec2| 10.0 + 0.3 * (place.x - lattice.origin.x) - 0.2 * (place.y - lattice.origin.y);
    let bed: Vec<f64> = (0..lattice.len()).map(|index| plane(lattice.to_map(lattice.centre(index)))).collect();
    for cell in [1.0, 2.0, 3.0, 4.0, 6.0] {
        let grid = OutputGrid::new(&lattice, cell, &bed);
        let water = |index: usize| WaterInCell { depth: (11.5 - bed[index]).max(0.0), ..WaterInCell::default() };
        let levels = grid.frame(0.0, &bed, by_index(water)).water_level;
        assert!(levels.contains(&FILL) && levels.contains(&11.5), "cell {cell}");
        assert!(levels.iter().all(|level| [FILL, 11.5].contains(level)), "cell {cell}: {levels:?}");
        // Cells that hold whole lattice cells.
        let (columns, rows) = ((14.0 / cell) as usize, (10.0 / cell) as usize);
        if cell % lattice.spacing == 0.0 {
            let found = grid.mean_of_terrain(&bed);
            for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
                let expected = plane(Vec2::new(grid.x()[column], grid.y()[row]));
                let error = f64::from(found[row * grid.columns + column]) - expected;
                assert!(error.abs() < 1e-5, "cell {cell}: {error} m at column {column}, row {row}");
            }
        }
    }
}

#[test]
fn maps_of_coarse_cells_hold_what_counts_most_in_them() {
    let lattice = Lattice::new(Vec2::ZERO, 2, 2, 1.0);
    let bed = [1.0, 2.0, f64::NAN, 3.0];
    let mut maxima = Maxima::new(4, 2, &[0.1], 0.1);
    let spans = [0, 1].map(|row| Span { row, from: 0, to: 2 });
    let mut step = |from: f64, to: f64, depth: [f64; 4]| {
        let discharge_x = [0.5, 0.0, 0.0, 0.0];
        let rows = FlatWater {
            columns: 2,
            depth: depth.to_vec(),
            discharge_x: discharge_x.to_vec(),
            discharge_y: vec![0.0; 4],
        };
        maxima.step(from, to, &WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans });
    };
    step(0.0, 10.0, [0.0, 0.2, 0.0, 0.0]);
    step(10.0, 20.0, [1.0, 0.1, 0.0, 0.0]);
    step(20.0, 30.0, [0.5, 0.0, 0.0, 0.0]);
    let grid = OutputGrid::new(&lattice, 2.0, &bed);
    let maps = grid.maps(&maxima, 30.0, &bed, &BTreeMap::new());
    assert_eq!((maps.bed_elevation[0], maps.max_depth[0], maps.max_water_level[0]), (2.0, 1.0, 2.2));
    assert_eq!((maps.time_of_max_depth[0], maps.max_speed[0]), (20.0, 1.0));
    let of_threshold = &maps.thresholds[0];
    // The shallow cell first, at 5 s; the deep one from 11 s on to the end.
    assert_eq!((of_threshold.arrival[0], of_threshold.duration[0]), (5.0, 19.0));
}

#[test]
fn ground_without_terrain_is_filled() {
    let lattice = lattice();
    let mut bed = vec![1.0; lattice.len()];
    bed[0] = f64::NAN;
    let grid = OutputGrid::new(&lattice, 2.0, &bed);
    let frame = grid.frame(0.0, &bed, by_index(|_| WaterInCell::default()));
    assert_eq!(frame.depth[4 * 7], FILL);
    assert_eq!(frame.depth[4 * 7 + 1], 0.0);
    assert_eq!(frame.water_level[4 * 7 + 1], FILL, "dry ground has no water level");
}

#[test]
fn a_coarser_grid_shows_the_source_of_the_greatest_part() {
    let lattice = Lattice::new(Vec2::ZERO, 4, 2, 1.0);
    // From the south: a line of the dam through a layer; two parts of the shore, and ground without terrain.
    let of_cells = vec![1, 1, 105, 0, 1, 104, 0, 105];
    let source = GroundSource::new(of_cells, Vec::new(), |source| format!("{source:?}"));
    let on = |cell: f64| OutputGrid::new(&lattice, cell, &[0.0; 8]).ground_source(&source).codes;
    assert_eq!(on(1.0), [1.0, 104.0, FILL, 105.0, 1.0, 1.0, 105.0, FILL]);
    assert_eq!(on(2.0), [104.0, 105.0]);
    assert_eq!(on(4.0), [105.0]);
    assert_eq!(
        source.classes.iter().map(|class| class.label.as_str()).collect::<Vec<_>>(),
        ["Layer(0)", "Dam", "Shore"]
    );
}
