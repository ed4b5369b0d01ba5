use super::*;

fn room() -> Walls {
    let corners = [Vec2::new(0.0, 0.0), Vec2::new(10.0, 0.0), Vec2::new(10.0, 6.0), Vec2::new(0.0, 6.0)];
    let edges = (0..4).map(|k| Edge { start: corners[k], end: corners[(k + 1) % 4], is_open: k == 1 }).collect();
    Walls::new(edges, 0.5)
}

#[test]
fn ways_bounce_off_walls_and_corners() {
    let (walls, mut near) = (room(), Vec::new());
    let path = walls.travel(Vec2::new(1.0, 1.0), Vec2::new(2.0, -0.5), &mut near);
    assert!((path.position - Vec2::new(2.0, 0.5)).norm() < 1e-12);
    assert!((path.turned(Vec2::new(1.0, -1.5)) - Vec2::new(1.0, 1.5)).norm() < 1e-12);
    let corner = walls.travel(Vec2::new(1.0, 1.0), Vec2::new(-0.5, -0.5), &mut near);
    assert!((corner.position - Vec2::new(0.5, 0.5)).norm() < 1e-8);
    assert!((corner.turned(Vec2::new(-1.0, -1.0)) - Vec2::new(1.0, 1.0)).norm() < 1e-12);
    assert!(!corner.has_left);
}

#[test]
fn ways_leave_through_open_edges() {
    let (walls, mut near) = (room(), Vec::new());
    assert!(walls.travel(Vec2::new(9.0, 3.0), Vec2::new(11.0, 3.0), &mut near).has_left);
    assert!(!walls.travel(Vec2::new(9.0, 3.0), Vec2::new(9.9, 3.0), &mut near).has_left);
}

#[test]
fn random_ways_never_leave_a_closed_room() {
    let corners =
        [Vec2::new(0.0, 0.0), Vec2::new(10.0, 1.0), Vec2::new(8.0, 6.0), Vec2::new(5.0, 3.0), Vec2::new(1.0, 7.0)];
    let edges: Vec<Edge> =
        (0..5).map(|k| Edge { start: corners[k], end: corners[(k + 1) % 5], is_open: false }).collect();
    let walls = Walls::new(edges.clone(), 0.5);
    let inside = |p: Vec2| {
        let crossings = edges.iter().filter(|edge| edge.crossing(p, Vec2::new(-20.0, -13.7), 0.0).is_some()).count();
        crossings % 2 == 1
    };
    let mut near = Vec::new();
    let (mut place, mut angle) = (Vec2::new(5.0, 2.0), 0.3_f64);
    for step in 0..20_000 {
        angle += 2.4;
        let length = 0.2 + 1.3 * (f64::from(step) * 0.618).fract();
        place = walls.travel(place, place + Vec2::new(angle.cos(), angle.sin()) * length, &mut near).position;
        assert!(inside(place), "step {step} ends at {place:?}");
    }
}

#[test]
fn ways_of_any_length_meet_the_walls_that_a_plain_search_finds() {
    let fence = Edge { start: Vec2::new(3.0, 2.0), end: Vec2::new(4.1, 5.0), is_open: false };
    let walls = Walls::new([room().edges(), &[fence]].concat(), 0.4);
    let all: Vec<u32> = (0..5).collect();
    let (mut open, mut closed) = (0, 0);
    for step in 0..2000 {
        let share = |factor: f64| (f64::from(step) * factor).fract();
        let a = Vec2::new(10.0 * share(0.618), 6.0 * share(0.414));
        let b = Vec2::new(14.0 * share(0.303) - 2.0, 10.0 * share(0.732) - 2.0);
        let is_walled = walls.is_walled(a, b);
        assert_eq!(is_walled, walls.is_blocked(&all, a, b), "from {a:?} to {b:?}");
        *(if is_walled { &mut closed } else { &mut open }) += 1;
    }
    assert!(open > 200 && closed > 200);
    let beside = Vec2::new(3.0, 2.1);
    assert!(!walls.is_walled(beside, beside), "a way of no length meets no wall");
}

#[test]
fn near_finds_every_edge_within_reach() {
    let (walls, mut near) = (room(), Vec::new());
    for step in 0..500 {
        let place = Vec2::new(10.0 * (f64::from(step) * 0.618).fract(), 6.0 * (f64::from(step) * 0.414).fract());
        let reach = 0.1 + 4.0 * (f64::from(step) * 0.177).fract();
        walls.near(place, reach, &mut near);
        let expected: Vec<u32> = (0..4_u32)
            .filter(|&k| {
                let edge = walls.edges()[k as usize];
                distance_to_segment(place, edge.start, edge.end) <= reach
            })
            .collect();
        assert_eq!(near, expected);
    }
}
