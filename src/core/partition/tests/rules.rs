//! The rules one by one.

use proptest::prelude::*;

use super::checks::{area, cell_at, check, faces_of_cells, house, lattice, line, segments};
use super::quality::shapes;
use super::random::{EDGE, Numbers, scene};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::partition::{Line, LineKind, Partition, Side};

/// The partition of a lattice without holes, checked.
fn made(lattice: &Lattice, lines: &[Line]) -> Partition {
    let made = Partition::new(lattice, |_| true, lines);
    check(&made, lattice, |_| true, lines);
    made
}

/// Length of the faces on a line whose second side is of some kind.
fn length_on(made: &Partition, line: usize, is_of_kind: impl Fn(Side) -> bool) -> f64 {
    let faces = made.faces.iter().filter(|face| face.line == Some(line) && is_of_kind(face.sides[1]));
    faces.map(|face| (face.to - face.from).norm()).sum()
}

/// Area of all cells.
fn whole_area(made: &Partition) -> f64 {
    made.cells.iter().map(|cell| cell.area).sum()
}

#[test]
fn nothing_is_replaced_without_lines() {
    let lattice = lattice(5, 4, 2.0);
    let outside = line(LineKind::Wall, &[(-50.0, 3.0), (-20.0, 90.0)]);
    for lines in [vec![], vec![outside], vec![line(LineKind::Wall, &[(3.0, 3.0)])]] {
        let made = made(&lattice, &lines);
        assert!(made.cells.is_empty() && made.faces.is_empty() && made.replaced.is_empty());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn faces_lie_on_a_straight_line_at_any_angle(
        angle in 0.0..180.0_f64,
        x in 9.0..11.0_f64,
        y in 9.0..11.0_f64,
        is_wall: bool,
    ) {
        let lattice = lattice(20, 20, 1.5);
        let (sin, cos) = angle.to_radians().sin_cos();
        let (x, y, half) = (1.5 * x, 1.5 * y, 7.3 * 1.5);
        let kind = if is_wall { LineKind::Wall } else { LineKind::Follow };
        let lines = [line(kind, &[(x - half * cos, y - half * sin), (x + half * cos, y + half * sin)])];
        let made = made(&lattice, &lines);
        let on_walls = length_on(&made, 0, |side| side == Side::Wall);
        let passable = length_on(&made, 0, |side| matches!(side, Side::Cell(_)));
        let (on_walls, passable) = if is_wall { (on_walls / 2.0, passable) } else { (passable, on_walls) };
        prop_assert!((on_walls - 2.0 * half).abs() < 1e-11 && passable < 1e-11, "{on_walls} {passable}");
        for (area, ratio) in shapes(&made, 1.5) {
            prop_assert!((0.45..1.6).contains(&area) && ratio < 27.0, "{area} {ratio}");
        }
    }

    #[test]
    fn cells_and_a_house_fill_what_is_replaced(
        angle in 0.0..90.0_f64,
        x in 14.0..16.0_f64,
        width in 0.05..15.0_f64,
        depth in 0.05..15.0_f64,
    ) {
        let lattice = lattice(30, 30, 1.0);
        let lines = [house((x, 15.0), (width, depth), angle)];
        let made = made(&lattice, &lines);
        let left = made.replaced.len() as f64 - width * depth - whole_area(&made);
        prop_assert!(left.abs() < 1e-12 * made.replaced.len() as f64, "{left:e}");
        prop_assert_eq!(cell_at(&made, &lattice)(Vec2::new(x, 15.0)), None);
        prop_assert!((length_on(&made, 0, |side| side == Side::Wall) - 2.0 * (width + depth)).abs() < 1e-11);
        for (area, ratio) in shapes(&made, 1.0) {
            prop_assert!((0.4..1.8).contains(&area) && ratio < 30.0, "{area} {ratio}");
        }
    }
}

#[test]
fn cells_fill_what_is_replaced() {
    let lattice = lattice(EDGE, EDGE, 1.0);
    for seed in 0..60 {
        let open = |line: Line| Line { kind: LineKind::Wall, is_closed: true, ..line };
        let lines: Vec<Line> = scene(seed).into_iter().map(open).collect();
        let made = Partition::new(&lattice, |_| true, &lines);
        let left = made.replaced.len() as f64 - whole_area(&made);
        assert!(left.abs() < 1e-12 * made.replaced.len() as f64 + 1e-3 * made.blocked as f64, "scene {seed}: {left:e}");
    }
}

#[test]
fn water_does_not_leave_a_closed_wall() {
    let lattice = lattice(EDGE, EDGE, 1.0);
    for seed in 0..60 {
        let ring = |points: Vec<Vec2>| Line { points, is_closed: true, kind: LineKind::Wall };
        let lines: Vec<Line> = scene(seed).into_iter().filter(|line| line.is_closed).map(|l| ring(l.points)).collect();
        let made = Partition::new(&lattice, |_| true, &lines);
        for line in &lines {
            let is_inside = |place: Vec2| segments(line).into_iter().all(|[a, b]| (b - a).cross(place - a) > 0.0);
            let inside: Vec<bool> = made.cells.iter().map(|cell| is_inside(centre_of_largest(cell))).collect();
            for face in &made.faces {
                if let [Side::Cell(a), Side::Cell(b)] = face.sides {
                    assert_eq!(inside[a], inside[b], "scene {seed}: {face:?}");
                }
            }
        }
    }
}

/// A place within a cell, also of one that is not convex.
fn centre_of_largest(cell: &crate::partition::Cell) -> Vec2 {
    let largest = cell.parts.iter().max_by(|a, b| area(a).total_cmp(&area(b))).unwrap();
    largest.iter().fold(Vec2::ZERO, |sum, corner| sum + *corner) / largest.len() as f64
}

#[test]
fn cells_of_a_narrow_street_reach_from_wall_to_wall() {
    let lattice = lattice(30, 20, 1.0);
    for width in [0.5, 0.8, 1.0, 1.25] {
        let walls = [0.0, width].map(|up| line(LineKind::Wall, &[(4.0, 6.3 + up), (25.0, 11.9 + up)]));
        let made = made(&lattice, &walls);
        let middle = made.faces.iter().filter(|face| face.line == Some(0) && face.sides[1] == Side::Wall);
        let in_street = |place: Vec2| place.y > 6.3 + (place.x - 4.0) * 5.6 / 21.0 && place.x > 6.0 && place.x < 23.0;
        let mut count = 0;
        let faces = faces_of_cells(&made);
        for face in middle {
            let Side::Cell(cell) = face.sides[0] else { continue };
            if in_street(made.cells[cell].centre) {
                assert!(faces[cell].iter().any(|(_, _, face)| face.line == Some(1)), "width {width}, cell {cell}");
                count += 1;
            }
        }
        assert!(count > 12, "width {width}: {count}");
    }
}

#[test]
fn repeated_points_change_nothing() {
    let lattice = lattice(20, 20, 1.0);
    let plain = [line(LineKind::Wall, &[(3.0, 4.0), (9.5, 8.0), (16.0, 5.0)])];
    let repeated = [line(LineKind::Wall, &[(3.0, 4.0), (3.0, 4.0), (9.5, 8.0), (9.5, 8.0), (9.5, 8.0), (16.0, 5.0)])];
    let [plain, repeated] = [&plain, &repeated].map(|lines| made(&lattice, lines));
    assert_eq!(plain.faces, repeated.faces);
    let ring = [(5.0, 5.0), (12.0, 6.0), (9.0, 13.0), (5.0, 5.0)];
    let [open, shut] = [&ring[..3], &ring[..]].map(|points| made(&lattice, &[line(LineKind::Outline, points)]));
    assert_eq!(open.faces, shut.faces);
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let lattice = lattice(EDGE, EDGE, 1.0);
    let [a, b] = [0, 0].map(|_| Partition::new(&lattice, |_| true, &scene(7)));
    assert_eq!(a.faces, b.faces);
    assert_eq!(a.on(&lattice), b.on(&lattice));
}

#[test]
fn a_tiny_part_between_walls_is_blocked() {
    let lattice = lattice(10, 10, 1.0);
    let ring = line(LineKind::Wall, &[(5.01, 5.01), (5.03, 5.01), (5.01, 5.03), (5.01, 5.01)]);
    let made = made(&lattice, &[ring]);
    assert_eq!((made.blocked, cell_at(&made, &lattice)(Vec2::new(5.015, 5.015))), (1, None));
    assert!((made.replaced.len() as f64 - whole_area(&made) - 2e-4).abs() < 1e-12);
}

#[test]
fn an_outline_of_two_points_is_a_wall() {
    let lattice = lattice(12, 12, 1.0);
    let points = [(3.0, 3.2), (8.0, 7.0)];
    let [outline, wall] = [LineKind::Outline, LineKind::Wall].map(|kind| made(&lattice, &[line(kind, &points)]));
    assert_eq!(outline.faces, wall.faces);
}

#[test]
fn houses_wall_to_wall_leave_no_gap() {
    let lattice = lattice(24, 24, 1.0);
    let (sin, cos) = 20.0_f64.to_radians().sin_cos();
    let houses = [0.0, 4.0, 8.0].map(|along| house((8.0 + along * cos, 8.0 + along * sin), (4.0, 5.0), 20.0));
    let made = made(&lattice, &houses);
    let left = made.replaced.len() as f64 - 60.0 - whole_area(&made);
    assert!(left.abs() < 1e-10, "{left:e}");
}

#[test]
fn an_outline_that_runs_the_other_way_is_a_courtyard() {
    let lattice = lattice(24, 24, 1.0);
    let mut lines = vec![house((12.0, 12.0), (14.0, 13.0), 20.0), house((11.0, 12.5), (6.0, 4.0), 20.0)];
    lines[1].points.reverse();
    lines.push(house((11.0, 12.0), (1.0, 0.4), 35.0));
    let made = made(&lattice, &lines);
    let left = made.replaced.len() as f64 - (14.0 * 13.0 - 24.0 + 0.4) - whole_area(&made);
    assert!(left.abs() < 1e-10, "{left:e}");
    let at = cell_at(&made, &lattice);
    let found = [(8.7, 12.5), (11.0, 12.0), (12.0, 9.0)].map(|(x, y)| at(Vec2::new(x, y)).is_some());
    assert_eq!(found, [true, false, false]);
    for sides in made.faces.iter().map(|face| face.sides) {
        if let [Side::Cell(a), Side::Cell(b)] = sides {
            let is_within = |cell: usize| (made.cells[cell].centre - Vec2::new(11.0, 12.5)).norm() < 4.0;
            assert_eq!(is_within(a), is_within(b), "water leaves the courtyard");
        }
    }
}

#[test]
#[ignore = "measures time"]
fn time_of_large_partitions() {
    let wall = |k: i32| 100.0 + 120.0 * f64::from(k);
    let walls: Vec<Line> =
        (0..13).map(|k| line(LineKind::Wall, &[(wall(k), 50.3), (wall(k) + 300.0, 1950.7)])).collect();
    let mut numbers = Numbers(1);
    let mut some_house = |_| {
        let mut next = |low: f64, high: f64| numbers.next(low, high);
        house((next(0.0, 1000.0), next(0.0, 1000.0)), (next(3.0, 12.0), next(3.0, 8.0)), next(0.0, 90.0))
    };
    let houses: Vec<Line> = (0..4000).map(&mut some_house).collect();
    for (name, edge, lines) in [("walls", 2000, walls), ("houses", 1000, houses)] {
        let start = std::time::Instant::now();
        let made = Partition::new(&lattice(edge, edge, 1.0), |_| true, &lines);
        println!("{name}: {} cells, {} faces: {:?}", made.cells.len(), made.faces.len(), start.elapsed());
    }
}
