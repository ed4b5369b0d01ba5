//! What gauges read beside walls, levees, quays and slopes.

use super::*;
use crate::output::GaugeResult;

/// Share that the cell itself and each of its four nearest neighbours have in a gauge at its centre.
fn shares() -> (f64, f64) {
    let (near, far) = (0.25 * (2.0f64 - 4.0 / 3.0).powi(3), 0.25 * (2.0 - 4.0 / 3.0 * 2f64.sqrt()).powi(3));
    let sum = 1.0 + 4.0 * near + 4.0 * far;
    (1.0 / sum, near / sum)
}

#[test]
fn a_gauge_reads_the_kernel_mean_of_the_cells_around_it() {
    let (recording, _) = record(50.0, 5.0);
    let [wet, dry, outside] = &recording.gauge_results[..] else { panic!("three gauges were asked for") };
    let (own, near) = shares();
    let mean = |t: f64| own * ramp(t) + near * lake(t);
    let series: Vec<_> = recording.gauge_samples.iter().filter(|sample| sample.gauge == 0).collect();
    assert_eq!(series.len(), 11);
    for (sample, t) in series.iter().zip([0.0, 10.0, 20.0, 30.0]) {
        assert_close(sample.depth, mean(t), "depth of the series");
    }
    // At the start there is the neighbouring lake: arrival is a rise of 0.2 m, on the straight ramp from 10 s to 40 s.
    let rise = |t: f64| mean(t) - mean(0.0);
    let arrival = 10.0 + 30.0 * (0.2 - rise(10.0)) / (rise(40.0) - rise(10.0));
    assert_close(wet.arrival.unwrap(), arrival, "arrival at the gauge");
    assert_close(wet.max_depth.unwrap(), mean(60.0), "greatest depth");
    assert_close(wet.time_of_max.unwrap(), 60.0, "time of the greatest depth");
    let level = |t: f64| BED + (own * ramp(t) + near * lake(t)) / (own + near);
    // The lake beside the gauge goes on rising when the gauge's own cell is dry again.
    assert_close(wet.max_level.unwrap(), level(60.0).max(BED + lake(100.0)), "greatest level");
    assert_close(wet.bed.unwrap(), BED, "bed of the gauge");
    assert!(dry.max_depth.unwrap() < 0.01 && dry.arrival.is_none(), "{dry:?}");
    assert_eq!(outside, &GaugeResult::default());
    assert!(recording.gauge_samples.iter().all(|sample| sample.gauge != 2), "no samples outside the terrain");
}

#[test]
fn a_gauge_does_not_read_beyond_a_wall() {
    let wall = [Vec2::new(20.0, -5.0), Vec2::new(20.0, 35.0)];
    let mut recorder = Recorder::new(RecorderPlan { walls: vec![wall], ..plan(50.0) });
    let spans = [Span { row: 1, from: 2, to: 3 }];
    let (lattice, mut rows) = (lattice(), FlatWater::dry(&lattice()));
    rows.depth[7] = 3.0;
    let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
    recorder.start(&water, Volumes::default(), &mut |_| Ok(())).unwrap();
    let recording = recorder.finish();
    assert_eq!(recording.gauge_results[0].max_depth, Some(0.0), "the lake stands behind the wall");
}

#[test]
fn a_gauge_on_a_levee_does_not_read_the_water_at_its_foot_nor_the_other_way_round() {
    // Cell 6 is a levee 3 m high with a film on it, cell 7 at its foot has 2 m of water; the third gauge stands at that foot.
    let mut bed_elevation = vec![BED; 15];
    bed_elevation[6] = BED + 3.0;
    let mut gauges = plan(50.0).gauges;
    gauges[2].position = Vec2::new(1021.0, 2015.0);
    let mut recorder = Recorder::new(RecorderPlan { bed_elevation, gauges, raised: vec![6], ..plan(50.0) });
    let spans = [Span { row: 1, from: 1, to: 3 }];
    let (lattice, mut rows) = (lattice(), FlatWater::dry(&lattice()));
    (rows.depth[6], rows.depth[7]) = (0.005, 2.0);
    let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
    recorder.start(&water, Volumes::default(), &mut |_| Ok(())).unwrap();
    recorder.step(100.0, &water, Volumes::default(), &mut |_| Ok(())).unwrap();
    let recording = recorder.finish();
    let [crest, _, foot] = &recording.gauge_results[..] else { panic!("three gauges were asked for") };
    assert_eq!((crest.bed, crest.max_depth, crest.arrival), (Some(BED + 3.0), Some(0.005), None), "on the levee");
    assert_close(foot.bed.unwrap(), BED, "bed at the foot");
    assert_close(foot.max_level.unwrap(), BED + 2.0, "level at the foot");
}

/// A gauge at an upright bank, at a place over a bed in cells of 10 m, five to a row and three rows, with so much water in each: its bed, its greatest depth and
/// its greatest level.
fn read_over(place: Vec2, bed_elevation: Vec<f64>, depth: Vec<f64>) -> (f64, f64, Option<f64>) {
    let gauges = vec![Gauge { id: "g".into(), position: place, attributes: vec![] }];
    let home = lattice().cell_at(place - lattice().origin).unwrap();
    let mut recorder = Recorder::new(RecorderPlan { bed_elevation, gauges, at_banks: vec![home], ..plan(50.0) });
    let spans: Vec<Span> = (0..3).map(|row| Span { row, from: 0, to: 5 }).collect();
    let lattice = lattice();
    let rows = FlatWater { depth, ..FlatWater::dry(&lattice) };
    let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
    recorder.start(&water, Volumes::default(), &mut |_| Ok(())).unwrap();
    recorder.step(100.0, &water, Volumes::default(), &mut |_| Ok(())).unwrap();
    let result = recorder.finish().gauge_results.remove(0);
    (result.bed.unwrap(), result.max_depth.unwrap(), result.max_level)
}

#[test]
fn a_gauge_on_a_quay_does_not_read_the_harbour_until_that_covers_the_quay() {
    // Columns 0 to 2 are a quay, 0.2 m higher at its back; the harbour is 3 m lower and up to 1 m deeper at one place.
    let mut bed = [BED + 0.2, BED, BED, BED - 3.0, BED - 3.0].repeat(3);
    bed[8] -= 1.0;
    let filled = |level: f64| bed.iter().map(|z| (level - z).max(0.0)).collect::<Vec<f64>>();
    for place in [Vec2::new(1025.0, 2015.0), Vec2::new(1029.9, 2016.0)] {
        let (ground, depth, level) = read_over(place, bed.clone(), filled(BED - 0.5));
        assert_eq!((depth, level), (0.0, None), "ground {ground} m");
        // Once the quay is under water all is read as before.
        let (ground, depth, level) = read_over(place, bed.clone(), filled(BED + 1.0));
        assert_close(level.unwrap(), BED + 1.0, "level over the quay");
        assert_close(depth, BED + 1.0 - ground, "depth over the quay");
    }
    // Rain on the quay is read for what it is.
    let mut rain = filled(BED - 0.5);
    for cell in [1, 2, 6, 7, 11, 12] {
        rain[cell] = 0.05;
    }
    let (_, depth, level) = read_over(Vec2::new(1025.0, 2015.0), bed.clone(), rain);
    assert_close(depth, 0.05, "rain");
    assert_close(level.unwrap(), BED + 0.05, "level of the rain");
}

#[test]
fn a_gauge_in_a_harbour_does_not_read_the_ground_of_the_quay() {
    // Columns 0 and 1 are a quay, 0.2 m higher at its back; the harbour is 3 m lower and up to 0.5 m deeper at one place.
    let mut bed = [BED + 0.2, BED, BED - 3.0, BED - 3.0, BED - 3.0].repeat(3);
    bed[8] -= 0.5;
    let filled = |level: f64| bed.iter().map(|z| (level - z).max(0.0)).collect::<Vec<f64>>();
    for place in [Vec2::new(1025.0, 2015.0), Vec2::new(1020.1, 2016.0)] {
        // Below the quay, and over it; a harbour that has run dry all but.
        for surface in [BED - 0.5, BED + 1.0, BED - 2.9] {
            let (ground, depth, level) = read_over(place, bed.clone(), filled(surface));
            assert!(ground < BED - 2.9, "ground {ground} m");
            assert_close(level.unwrap(), surface, "level of the harbour");
            assert_close(depth, surface - ground, "depth of the harbour");
        }
        // Rain on the quay is none in the harbour.
        let mut rain = filled(BED - 0.5);
        for cell in [1, 6, 11] {
            rain[cell] = 0.05;
        }
        assert_close(read_over(place, bed.clone(), rain).2.unwrap(), BED - 0.5, "level beside rain on the quay");
    }
}

#[test]
fn a_gauge_on_a_slope_reads_the_water_below_it() {
    // An even slope along the lattice and one across it: the kernel mean does not depend on which cell holds the gauge.
    for (east, north) in [(-2.0, 0.0), (-1.3, 0.7), (0.0, -0.1), (-2.0, 2.0)] {
        let bed: Vec<f64> =
            (0..15).map(|cell| BED + east * f64::from(cell % 5) + north * f64::from(cell / 5)).collect();
        let level = bed[7] - 0.05;
        let depth: Vec<f64> = bed.iter().map(|z| (level - z).max(0.0)).collect();
        let (_, read, _) = read_over(Vec2::new(1025.0, 2015.0), bed, depth);
        assert!(read > 0.0, "{east}, {north}");
    }
}
