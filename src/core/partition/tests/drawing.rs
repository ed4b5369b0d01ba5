//! Pictures for the eye.

use super::checks::{house, lattice, line};
use super::random::scene;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::partition::{Line, LineKind, Partition, Side};

/// A scene with one of each: a house, a crossing, a street, a wall's end, the bend of a river, a tiny ring.
fn gallery() -> Vec<Line> {
    let bend = |radius: f64| -> Vec<(f64, f64)> {
        (0..=24).map(|k| f64::from(k) * 0.12).map(|a| (30.0 - radius * a.cos(), 8.0 + radius * a.sin())).collect()
    };
    vec![
        house((8.0, 8.0), (6.0, 4.0), 20.0),
        line(LineKind::Follow, &[(2.0, 16.0), (14.0, 24.0)]),
        line(LineKind::Follow, &[(2.0, 23.0), (15.0, 17.0)]),
        line(LineKind::Wall, &[(18.0, 16.0), (28.0, 20.0)]),
        line(LineKind::Wall, &[(17.6, 17.0), (27.6, 21.0)]),
        line(LineKind::Wall, &[(16.0, 2.0), (18.3, 12.0)]),
        line(LineKind::Follow, &bend(4.0)),
        line(LineKind::Follow, &bend(7.0)),
        house((33.0, 18.5), (0.5, 0.4), 35.0),
        house((34.0, 23.0), (1.2, 1.0), 35.0),
        line(LineKind::Wall, &[(20.0, 26.0), (29.0, 25.0), (24.0, 28.0)]),
    ]
}

fn draw(lattice: &Lattice, lines: &[Line], path: &str) {
    let made = Partition::new(lattice, |_| true, lines);
    let mut text = format!("size {} {}\n", lattice.columns, lattice.rows);
    let mut put = |name: &str, a: Vec2, b: Vec2| text += &format!("{name} {} {} {} {}\n", a.x, a.y, b.x, b.y);
    for cell in (0..lattice.len()).filter(|cell| made.replaced.binary_search(cell).is_err()) {
        let c = lattice.centre(cell);
        put("square", c - Vec2::new(0.5, 0.5), c + Vec2::new(0.5, 0.5));
    }
    for face in &made.faces {
        let name = match face.sides[1] {
            Side::Cell(_) if face.line.is_some() => "follow",
            Side::Cell(_) => "face",
            Side::Lattice(_) => "lattice",
            Side::Wall => "wall",
            Side::Nothing => "nothing",
        };
        put(name, face.from, face.to);
    }
    for cell in &made.cells {
        put("centre", cell.centre, cell.centre);
    }
    std::fs::write(path, text).unwrap();
}

#[test]
#[ignore = "draws into the folder PARTITION_DRAWINGS"]
fn draw_scenes() {
    let folder = std::env::var("PARTITION_DRAWINGS").unwrap();
    draw(&lattice(40, 30, 1.0), &gallery(), &format!("{folder}/gallery.txt"));
    for seed in std::env::var("PARTITION_SCENES").unwrap_or_default().split(',').filter_map(|seed| seed.parse().ok()) {
        draw(&lattice(30, 30, 1.0), &scene(seed), &format!("{folder}/scene{seed}.txt"));
    }
}
