//! Where a channel meets the plane.

use super::*;

/// A plane of flat ground west of which (or east) a channel of its width comes in, and the same as one plane.
fn wave_through_a_junction(is_west: bool, hump_at: f64) -> (f64, f64) {
    const HEIGHT: f64 = 0.01;
    let hump = move |x: f64| 1.0 + HEIGHT * (-((x - hump_at) / 6.0).powi(2)).exp();
    let away = if is_west { 1.0 } else { -1.0 };
    let whole = plane((240, 4), 1.0, |_| 0.0, |place| hump(away * (place.x - 120.0)));
    // Places count from the junction, positive in the plane.
    let x = |place: Vec2| if is_west { place.x } else { 120.0 - place.x };
    let mut parts = plane((120, 4), 1.0, |_| 0.0, |place| hump(x(place)));
    let reach = channel(120, 1.0, (|_| 4.0, |_| 0.0, |along: f64| hump(along - 120.0)), SMOOTH);
    join(&mut parts, reach, is_west, (0.0, 4.0));
    let (mut whole, mut parts) = (EulerianSolver::new(whole), EulerianSolver::new(parts));
    let end = 60.0 / G.sqrt();
    run_until(&mut whole, end);
    run_until(&mut parts, end);
    let (wanted, found, reach) = (whole.water().depths(), parts.water().depths(), parts.channels());
    let mut worst = 0.0_f64;
    for i in 0..240 {
        // Along the channel and on into the plane.
        let here = if is_west { i } else { 239 - i };
        let depth = match i {
            0..120 => reach[0][i].depth,
            _ if is_west => found[i - 120],
            _ => found[239 - i],
        };
        worst = worst.max((depth - wanted[here]).abs());
    }
    (worst / HEIGHT, parts.ledger().relative_error())
}

#[test]
fn a_wave_passes_a_junction_of_one_width_without_reflection() {
    for is_west in [true, false] {
        // Into the plane, and out of it.
        for hump_at in [-30.0, 30.0] {
            let (reflected, error) = wave_through_a_junction(is_west, hump_at);
            assert!(reflected < 1e-10 && error.abs() < 1e-13, "{is_west}, {hump_at}: {reflected:e}, {error:e}");
        }
    }
}

/// A rough plane of 30 m by 24 m at the eastern or western edge of which a narrowing channel comes in.
fn rough_plane(is_west: bool, level: impl Fn(f64) -> f64 + Copy, in_channel: f64) -> FlowProblem {
    let bed = |place: Vec2| 0.6 * noise(place.x + 31.0 * place.y);
    let mut problem = plane((30, 24), 1.0, bed, |place| level(place.x));
    let wide = |x: f64| 5.0 - 0.1 * x + 0.5 * noise(x);
    let rough = Resistance { manning: 0.02, smooth_walls: false };
    join(&mut problem, channel(20, 1.0, (wide, |x: f64| 0.5 * noise(x), |_| in_channel), rough), is_west, (8.0, 11.0));
    problem
}

#[test]
fn a_lake_rests_across_a_junction() {
    for is_west in [true, false] {
        // All under water, and with dry ground on both sides of the junction.
        for level in [1.0, 0.05] {
            let mut solver = EulerianSolver::new(rough_plane(is_west, |_| level, level));
            let fastest = run_steps(&mut solver, 300);
            assert!(fastest < 1e-12, "{level}: {fastest:e} m/s");
        }
    }
}

#[test]
fn water_goes_both_ways_and_none_is_lost() {
    let volume_of_channel = |solver: &EulerianSolver| solver.channels()[0].iter().map(|s| s.depth).sum::<f64>();
    for is_west in [true, false] {
        for (in_plane, in_channel) in [(2.0, -1.0), (-1.0, 2.0), (2.0, 0.5), (0.5, 2.0)] {
            let mut solver = EulerianSolver::new(rough_plane(is_west, |_| in_plane, in_channel));
            let before = volume_of_channel(&solver);
            run_steps(&mut solver, 300);
            let after = volume_of_channel(&solver);
            assert!((after > before) == (in_plane > in_channel), "{in_plane}, {in_channel}: {before} to {after}");
            let error = solver.ledger().relative_error();
            assert!(error.abs() < 1e-12, "{in_plane}, {in_channel}: {error:e}");
        }
    }
}

#[test]
fn the_strips_of_a_trapezoid_meet_cells_of_their_height() {
    // A valley across the edge, cut into the plane, and the same section as a channel.
    let across = |y: f64| (y - 12.0).abs() - 1.0;
    let bed = move |place: Vec2| across(place.y).max(0.0) * 0.5;
    let mut problem = plane((20, 24), 1.0, bed, |_| 1.5);
    let section = || {
        let mut strips = vec![Strip { width: 2.0, bed: 0.0 }];
        strips.extend((0..3).map(|k| Strip { width: 2.0, bed: 0.25 + 0.5 * k as f64 }));
        ChannelSection { strips, perimeter: vec![(0.0, 2.0), (2.0, 8.0)], manning: 0.0, level: 1.5 }
    };
    join(&mut problem, of_sections(1.0, (0..20).map(|_| section()).collect()), true, (8.0, 16.0));
    let mut solver = EulerianSolver::new(problem);
    assert!(run_steps(&mut solver, 200) < 1e-12);
    assert!(solver.ledger().relative_error().abs() < 1e-13);
}

/// The valley of the next test: 2 m wide at its bottom and 8 m at its top, by steps of 0.5 m.
fn valley(y: f64) -> f64 {
    (((y - 6.0).abs() - 1.0).max(0.0).ceil() * 0.5 - 0.25).max(0.0)
}

#[test]
fn a_long_wave_has_the_speed_of_its_section_and_passes_into_a_valley_of_that_section() {
    const HEIGHT: f64 = 0.005;
    let strips = || {
        let mut strips = vec![Strip { width: 2.0, bed: 0.0 }];
        strips.extend((0..3).map(|k| Strip { width: 2.0, bed: 0.25 + 0.5 * k as f64 }));
        strips
    };
    // Depth of 1.5 m: A = 2 (1.5 + 1.25 + 0.75 + 0.25) m², T = 8 m.
    let speed = (G * 7.5_f64 / 8.0).sqrt();
    let hump = |x: f64| 1.5 + HEIGHT * (-((x + 120.0) / 30.0).powi(2)).exp();
    let section = |i: usize| ChannelSection {
        strips: strips(),
        perimeter: vec![(0.0, 2.0), (2.0, 8.0)],
        manning: 0.0,
        level: hump(i as f64 + 0.5 - 300.0),
    };
    let mut problem = plane((200, 12), 1.0, |place| valley(place.y), |place| hump(place.x));
    join(&mut problem, of_sections(1.0, (0..300).map(section).collect()), true, (2.0, 10.0));
    let mut solver = EulerianSolver::new(problem);
    // The half that goes to the near end has its crest at 60 m in the valley then.
    run_until(&mut solver, 180.0 / speed);
    let depths = solver.water().depths();
    let levels: Vec<f64> = (0..200).map(|x| depths[6 * 200 + x] - 1.5).collect();
    let crest = (0..200).max_by(|a, b| levels[*a].total_cmp(&levels[*b])).unwrap() as f64 + 0.5;
    assert!((crest - 60.0).abs() < 4.0, "{crest}");
    assert!((levels[crest as usize] / (0.5 * HEIGHT) - 1.0).abs() < 0.05, "{}", levels[crest as usize]);
    // What came back has passed the place where it would have been born.
    let back = solver.channels()[0][200..].iter().map(|sample| (sample.level - 1.5).abs()).fold(0.0, f64::max);
    assert!(back < 0.02 * 0.5 * HEIGHT, "{}", back / (0.5 * HEIGHT));
}
