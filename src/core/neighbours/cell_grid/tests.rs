use super::near::{collect_one_by_one, list_one_by_one};
use super::*;
use crate::neighbours::within_brute_force;

/// A repeatable sequence of numbers in [0, 1).
fn numbers(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

type List = fn(&[u32], &[Span], &mut [u32]) -> usize;

fn check(positions: &[Vec2], supports: &[f32]) {
    let mut grid = CellGrid::default();
    grid.build(positions, supports);
    let (mut spans, mut without, mut found) = (Vec::new(), Vec::new(), Vec::new());
    for (i, &position) in positions.iter().enumerate() {
        let support = f64::from(supports[i]);
        let all = within_brute_force(positions, supports, position, support);
        for except in [None, Some(i as u32)] {
            let expected: Vec<u32> = all.iter().copied().filter(|&j| Some(j) != except).collect();
            for (collect, list) in [(collect as Collect, list as List), (collect_one_by_one, list_one_by_one)] {
                spans.clear();
                grid.spans_by(collect, position, support, except.unwrap_or(u32::MAX), &mut spans);
                without.clear();
                let all = grid.spans_and_list_within(position, support, &mut Found::default()).0.to_vec();
                grid.append_without(&all, except.unwrap_or(u32::MAX), &mut without);
                assert_eq!(without, spans, "particle {i}");
                found.resize(LANES * spans.len(), 0);
                let count = list(&grid.order, &spans, &mut found);
                found.truncate(count);
                found.sort_unstable();
                assert!(found.iter().all(|j| expected.contains(j)), "particle {i}");
                for j in expected.iter().filter(|j| !found.contains(j)) {
                    let reach = support.max(f64::from(supports[*j as usize]));
                    let rim = reach * (1.0 - 2.0 * ROUNDING) - 4.0 / grid.scale;
                    assert!((positions[*j as usize] - position).norm() > rim, "{i} and {j}");
                }
            }
        }
    }
}

#[test]
fn finds_what_the_plain_loop_finds() {
    let mut next = numbers(1);
    for (count, spread) in [(1, 1.0_f64), (2, 60.0), (300, 1.0), (300, 60.0), (300, 3000.0)] {
        let positions: Vec<Vec2> = (0..count).map(|_| Vec2::new(100.0 * next() - 50.0, 40.0 * next())).collect();
        let supports: Vec<f32> = (0..count).map(|_| (0.05 * spread.powf(next()) + 0.5) as f32).collect();
        check(&positions, &supports);
    }
}

#[test]
fn works_on_a_line_and_in_a_heap() {
    let mut next = numbers(2);
    let line: Vec<Vec2> = (0..200).map(|_| Vec2::new(1000.0 * next(), 3.0)).collect();
    check(&line, &[12.0; 200]);
    let heap = [Vec2::new(1.0, 1.0); 20];
    check(&heap, &[1.0; 20]);
    check(&[], &[]);
}

#[test]
fn few_wide_particles_do_not_spoil_the_others() {
    let mut next = numbers(3);
    let mut positions: Vec<Vec2> = (0..10_000).map(|k| Vec2::new(f64::from(k % 100), f64::from(k / 100))).collect();
    let mut supports = vec![3.0; 10_000];
    for _ in 0..10 {
        positions.push(Vec2::new(100.0 * next(), 100.0 * next()));
        supports.push(180.0);
    }
    let mut grid = CellGrid::default();
    grid.build(&positions, &supports);
    assert!(grid.starts.len() < 60_000, "about four cells a particle and level");
    let narrow = &grid.levels[0];
    assert!(narrow.width <= 3.0 && narrow.taken.largest_support <= 3.0);
}
