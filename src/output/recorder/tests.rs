//! The recorder against water whose arrival, duration and maxima are known by hand.

#![expect(clippy::float_cmp, reason = "values that must be taken over unchanged are compared exactly")]

mod gauges;

use super::*;
use crate::constants::OutputConstants;
use crate::lattice::{FlatWater, Span};
use crate::math::Vec2;
use crate::output::maxima::ThresholdSeen;
use crate::output::{FILL, WET_DEPTH};

const BED: f64 = 20.0;

fn lattice() -> Lattice {
    Lattice::new(Vec2::new(1000.0, 2000.0), 5, 3, 10.0)
}

fn plan(every: f64) -> RecorderPlan {
    let mut bed_elevation = vec![BED; 15];
    bed_elevation[14] = f64::NAN;
    let gauge = |id: &str, x: f64, y: f64| Gauge { id: id.into(), position: Vec2::new(x, y), attributes: vec![] };
    RecorderPlan {
        lattice: lattice(),
        bed_elevation,
        cell: 10.0,
        terrain: None,
        thresholds: vec![0.1, 0.5],
        rise_on_wet: 0.2,
        every,
        end_time: 100.0,
        gauges: vec![gauge("wet", 1015.0, 2015.0), gauge("dry", 1005.0, 2005.0), gauge("outside", 1045.0, 2025.0)],
        walls: vec![],
        raised: vec![],
        followed: vec![],
        at_banks: vec![],
        constants: OutputConstants::DEFAULT,
        more_area: vec![],
        gauges_every: 10.0,
        sections: vec![vec![7, 8], vec![5, 6, 7], vec![8], vec![]],
        closed_edge: vec![],
        tracers: vec![],
    }
}

/// Cell 6 rises from 0 at t = 10 to 1 m at t = 40, stands until 60 and falls to 0 at t = 90; piecewise linear.
fn ramp(t: f64) -> f64 {
    ((t - 10.0) / 30.0).clamp(0.0, 1.0).min((90.0 - t) / 30.0).max(0.0)
}

/// Cell 7 holds 0.4 m from the start and rises by 0.01 m/s.
fn lake(t: f64) -> f64 {
    0.4 + 0.01 * t
}

/// What comes of the two cells; see `recorder_after`.
fn record(every: f64, time_step: f64) -> (Recording, Vec<Frame>) {
    let (recorder, frames) = recorder_after(every, time_step);
    (recorder.finish(), frames)
}

/// Runs the two cells through steps of `time_step` (s) that meet the kinks of the ramp.
fn recorder_after(every: f64, time_step: f64) -> (Recorder, Vec<Frame>) {
    let (lattice, spans) = (lattice(), [Span { row: 1, from: 1, to: 3 }]);
    let state = |t: f64| {
        let (mut depth, mut discharge) = (vec![0.0; 15], vec![0.0; 15]);
        (depth[6], depth[7]) = (ramp(t), lake(t));
        discharge[6] = 2.0 * depth[6];
        FlatWater { columns: 5, depth, discharge_x: discharge, discharge_y: vec![0.0; 15] }
    };
    let mut frames = Vec::new();
    let mut sink = |frame| {
        frames.push(frame);
        Ok(())
    };
    let mut recorder = Recorder::new(plan(every));
    for step in 0..=(100.0 / time_step).round() as u32 {
        let t = f64::from(step) * time_step;
        let rows = state(t);
        let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
        let volumes = Volumes { stored: rows.depth.iter().sum::<f64>() * 100.0, ..Volumes::default() };
        if step == 0 {
            recorder.start(&water, volumes, &mut sink).unwrap();
        } else {
            recorder.step(t, &water, volumes, &mut sink).unwrap();
        }
    }
    (recorder, frames)
}

/// What a cell has seen of both thresholds.
fn thresholds_at(recorder: &Recorder, index: usize) -> [ThresholdSeen; 2] {
    [0, 1].map(|which| recorder.maxima.seen_of_threshold(index, which, recorder.time))
}

fn assert_close(actual: f64, expected: f64, what: &str) {
    // A handful of roundings of numbers up to 100.
    assert!((actual - expected).abs() < 1e-12 * 100.0, "{what}: {actual} instead of {expected}");
}

#[test]
fn ramp_gives_its_exact_times_with_coarse_and_fine_steps() {
    for time_step in [10.0, 5.0, 0.625] {
        let (recorder, _) = recorder_after(25.0, time_step);
        let ([low, high], seen) = (thresholds_at(&recorder, 6), recorder.maxima.seen(6));
        assert_close(low.arrival, 13.0, "rises through 0.1 m");
        assert_close(low.recession, 87.0, "falls through 0.1 m");
        assert_close(low.duration, 74.0, "above 0.1 m");
        assert_close(high.arrival, 25.0, "rises through 0.5 m");
        assert_close(high.duration, 50.0, "above 0.5 m");
        assert_close(seen.max_depth, 1.0, "greatest depth");
        assert_close(seen.time_of_max_depth, 40.0, "first time of the greatest depth");
        assert_close(seen.max_speed, 2.0, "greatest speed");
        assert_close(seen.max_depth_velocity, 2.0, "greatest depth times speed");
        assert_eq!(seen.hazard_class, 5, "d v = 2 m²/s");
    }
}

#[test]
fn wet_ground_arrives_when_its_level_has_risen() {
    let (recorder, _) = recorder_after(25.0, 10.0);
    let [low, high] = thresholds_at(&recorder, 7);
    assert_close(low.arrival, 20.0, "0.4 m + 0.2 m is reached at 20 s");
    assert_close(high.arrival, 20.0, "the greater threshold is passed before the rise is reached");
    assert_close(low.duration, 100.0, "under water from the start to the end");
    assert_close(high.duration, 90.0, "0.5 m is reached at 10 s");
    assert!(low.recession.is_nan(), "still under water");
    assert_close(recorder.maxima.seen(7).time_of_max_depth, 100.0, "still rising");
}

#[test]
fn the_water_comes_to_a_section_when_it_comes_to_the_first_of_its_cells() {
    let (recording, _) = record(25.0, 10.0);
    let [wet, both, dry, none] = recording.section_arrivals[..] else { panic!("four sections") };
    assert_close(wet.unwrap(), 20.0, "a rise of 0.2 m");
    assert_close(both.unwrap(), 13.0, "the ramp before the rise");
    assert_eq!((dry, none), (None, None));
}

#[test]
fn dry_ground_and_ground_without_terrain_are_told_apart() {
    let (recording, _) = record(25.0, 10.0);
    let maps = &recording.maps;
    let (dry, outside) = (10, 4); // south-western and north-eastern cell, north-up
    assert_eq!((maps.max_depth[dry], maps.max_depth[outside]), (0.0, FILL));
    assert_eq!((maps.thresholds[0].arrival[dry], maps.thresholds[0].arrival[outside]), (FILL, FILL));
    assert_eq!((maps.thresholds[0].duration[dry], maps.thresholds[0].duration[outside]), (0.0, FILL));
    assert_eq!((maps.hazard_class[dry], maps.hazard_class[outside]), (0.0, FILL));
    assert_eq!((maps.max_water_level[dry], maps.bed_elevation[outside]), (FILL, FILL));
    assert_eq!(maps.max_water_level[6], 21.0);
}

#[test]
fn maps_do_not_depend_on_the_output_interval() {
    // The interval divides no step here: frames fall between the steps.
    let (often, frames_often) = record(3.7, 0.625);
    let (seldom, frames_seldom) = record(100.0, 0.625);
    assert_eq!((frames_often.len(), frames_seldom.len()), (29, 2));
    let bits = |recording: &Recording| {
        let maps = &recording.maps;
        let grids = [&maps.max_depth, &maps.max_speed, &maps.time_of_max_depth, &maps.thresholds[0].arrival];
        let grids = grids.into_iter().chain([&maps.thresholds[1].duration, &maps.max_water_level]);
        grids.flatten().map(|value| value.to_bits()).collect::<Vec<u32>>()
    };
    assert_eq!(bits(&often), bits(&seldom));
    assert_eq!(often.gauge_results, seldom.gauge_results);
}

#[test]
fn frames_lie_on_the_line_between_steps() {
    let (recording, frames) = record(12.5, 10.0);
    let frame = frames.iter().find(|frame| frame.time == 37.5).unwrap();
    assert_eq!(frame.depth[6], ramp(37.5) as f32);
    assert_eq!(frame.velocity_x[6], 2.0, "discharge and depth are interpolated, velocity is their quotient");
    assert_eq!(frame.velocity_y[6], 0.0);
    let error = recording.grid_error_relative();
    assert!(error < 1e-6, "{error:e}, more than single precision");
    assert_eq!(recording.mass_balance.len(), 9);
}

#[test]
fn films_have_no_speed_and_no_class() {
    let spans = [Span { row: 0, from: 0, to: 1 }];
    let (lattice, mut rows) = (lattice(), FlatWater::dry(&lattice()));
    (rows.depth[0], rows.discharge_x[0], rows.discharge_y[0]) = (0.5 * WET_DEPTH, 1.0, 1.0);
    let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
    let mut recorder = Recorder::new(plan(50.0));
    recorder.start(&water, Volumes::default(), &mut |_| Ok(())).unwrap();
    let seen = recorder.maxima.seen(0);
    assert_eq!((seen.max_speed, seen.max_depth_velocity, seen.hazard_class), (0.0, 0.0, 0));
}

#[test]
fn threads_do_not_change_a_bit() {
    // Large enough that the step is shared between threads.
    let lattice = Lattice::new(Vec2::ZERO, 130, 70, 1.0);
    let spans: Vec<Span> =
        (0..70).flat_map(|row| [Span { row, from: 0, to: 60 }, Span { row, from: 61, to: 130 }]).collect();
    let record = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let plan =
            RecorderPlan { lattice: lattice.clone(), bed_elevation: vec![0.0; 9100], gauges: vec![], ..plan(10.0) };
        let mut recorder = Recorder::new(plan);
        for step in 0..20 {
            let depth: Vec<f64> =
                (0..9100).map(|i| (0.3 * (f64::from(i) * 0.37 + f64::from(step)).sin()).max(0.0)).collect();
            let discharge: Vec<f64> = depth.iter().map(|d| d * 1.7).collect();
            let rows = FlatWater { columns: 130, depth, discharge_x: discharge.clone(), discharge_y: discharge };
            let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
            let time = f64::from(step) * 0.9;
            pool.install(|| match step {
                0 => recorder.start(&water, Volumes::default(), &mut |_| Ok(())),
                _ => recorder.step(time, &water, Volumes::default(), &mut |_| Ok(())),
            })
            .unwrap();
        }
        recorder.finish().maps
    };
    let one = record(1);
    assert_eq!(one, record(3));
    assert!(one.max_depth.iter().any(|&depth| depth > 0.2));
}

#[test]
fn without_maps_and_frames_the_gauges_and_the_water_balance_are_the_same() {
    let record = |has_all: bool| {
        let mut recorder = Recorder::new(RecorderPlan { sections: vec![], ..plan(12.5) });
        if !has_all {
            recorder.leave_out_frames();
            recorder.leave_out_maps();
        }
        let (lattice, spans) = (lattice(), [Span { row: 1, from: 1, to: 3 }]);
        let mut frames = 0;
        let mut sink = |_| {
            frames += 1;
            Ok(())
        };
        for step in 0..=10 {
            let t = 10.0 * f64::from(step);
            let mut rows = FlatWater::dry(&lattice);
            (rows.depth[6], rows.depth[7], rows.discharge_x[6]) = (ramp(t), lake(t), ramp(t));
            let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
            let volumes = Volumes { stored: t, ..Volumes::default() };
            match step {
                0 => recorder.start(&water, volumes, &mut sink).unwrap(),
                _ => recorder.step(t, &water, volumes, &mut sink).unwrap(),
            }
        }
        (recorder.finish(), frames)
    };
    let ((all, frames), (least, none)) = (record(true), record(false));
    assert_eq!((frames, none), (9, 0));
    assert!(!all.maps.max_depth.is_empty() && least.maps == GridMaps::default());
    assert_eq!((&all.gauge_results, &all.gauge_samples), (&least.gauge_results, &least.gauge_samples));
    assert_eq!(all.mass_balance, least.mass_balance);
}

#[test]
fn a_balance_is_needed_where_a_frame_is_due_and_nowhere_else() {
    let mut recorder = Recorder::new(plan(50.0));
    let (lattice, rows) = (lattice(), FlatWater::dry(&lattice()));
    let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &[] };
    let stored = |stored: f64| Volumes { stored, ..Volumes::default() };
    recorder.start(&water, stored(10.0), &mut |_| Ok(())).unwrap();
    assert!(!recorder.is_frame_due(40.0) && recorder.is_frame_due(60.0));
    recorder.step(40.0, &water, None, &mut |_| Ok(())).unwrap();
    recorder.set_balance(stored(20.0));
    recorder.step(60.0, &water, stored(40.0), &mut |_| Ok(())).unwrap();
    assert!(recorder.step(100.0, &water, None, &mut |_| Ok(())).is_err(), "the last frame has no balance");
    assert_eq!(recorder.finish().mass_balance[1].volumes.stored, 30.0);
}
