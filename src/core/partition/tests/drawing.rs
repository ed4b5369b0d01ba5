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

/// Writes a partition as SVG, north up: cells of the lattice grey, faces blue, beside the lattice orange, on passable lines green, walls
/// red, at the edge black.
fn draw(lattice: &Lattice, lines: &[Line], path: &str) {
    let made = Partition::new(lattice, |_| true, lines);
    let (width, height) = (lattice.columns, lattice.rows);
    let mut text = format!("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}'>\n");
    text += &format!("<rect width='{width}' height='{height}' fill='white'/>\n");
    let mut put = |colour: &str, a: Vec2, b: Vec2, thickness: f64| {
        let [from, to] = [a.y, b.y].map(|y| height as f64 - y);
        text += &format!(
            "<line x1='{}' y1='{from}' x2='{}' y2='{to}' stroke='{colour}' stroke-width='{thickness}' stroke-linecap='round'/>\n",
            a.x, b.x
        );
    };
    for cell in (0..lattice.len()).filter(|cell| made.replaced.binary_search(cell).is_err()) {
        let corner = |x: f64, y: f64| lattice.centre(cell) + Vec2::new(x, y) * 0.5;
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        (0..4).for_each(|i| put("lightgrey", corners[i], corners[(i + 1) % 4], 0.02));
    }
    for face in &made.faces {
        let (colour, thickness) = match face.sides[1] {
            Side::Cell(_) if face.line.is_some() => ("green", 0.06),
            Side::Cell(_) => ("blue", 0.03),
            Side::Lattice(_) => ("orange", 0.03),
            Side::Wall => ("red", 0.06),
            Side::Nothing => ("black", 0.03),
        };
        put(colour, face.from, face.to, thickness);
    }
    made.cells.iter().for_each(|cell| put("black", cell.centre, cell.centre, 0.08));
    std::fs::write(path, text + "</svg>\n").unwrap();
}

#[test]
#[ignore = "draws into the folder PARTITION_DRAWINGS, of PARTITION_SCENES random scenes by their seeds"]
fn draw_scenes() {
    let folder = std::env::var("PARTITION_DRAWINGS").unwrap();
    draw(&lattice(40, 30, 1.0), &gallery(), &format!("{folder}/gallery.svg"));
    let seeds = std::env::var("PARTITION_SCENES").unwrap_or_default();
    for seed in seeds.split(',').filter_map(|seed| seed.parse().ok()) {
        draw(&lattice(30, 30, 1.0), &scene(seed), &format!("{folder}/scene{seed}.svg"));
    }
}
