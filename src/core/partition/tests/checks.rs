//! What must hold in every scene.

use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::partition::{Face, Line, LineKind, Partition, Side};

/// A lattice of some columns and rows.
pub fn lattice(columns: usize, rows: usize, spacing: f64) -> Lattice {
    Lattice::new(Vec2::ZERO, columns, rows, spacing)
}

/// A line through some points.
pub fn line(kind: LineKind, points: &[(f64, f64)]) -> Line {
    let points = points.iter().map(|(x, y)| Vec2::new(*x, *y)).collect();
    Line { points, is_closed: kind == LineKind::Outline, kind }
}

/// A rectangle around a centre, turned by an angle in degrees.
pub fn house(centre: (f64, f64), size: (f64, f64), angle: f64) -> Line {
    let (sin, cos) = angle.to_radians().sin_cos();
    let corner = |x: f64, y: f64| {
        let (x, y) = (x * size.0 / 2.0, y * size.1 / 2.0);
        (centre.0 + x * cos - y * sin, centre.1 + x * sin + y * cos)
    };
    line(LineKind::Outline, &[corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
}

/// The cell of a partition that holds a place.
pub fn cell_at(made: &Partition, lattice: &Lattice) -> impl Fn(Vec2) -> Option<usize> {
    let (placed, lattice) = (made.clone().on(lattice), lattice.clone());
    move |place| placed.cell_at(lattice.cell_of(place)?, place)
}

/// The segments of a line.
pub fn segments(line: &Line) -> Vec<[Vec2; 2]> {
    let count = line.points.len();
    let closing = (line.is_closed && count > 2).then(|| [line.points[count - 1], line.points[0]]);
    line.points.windows(2).map(|ends| [ends[0], ends[1]]).chain(closing).collect()
}

fn distance(place: Vec2, [a, b]: [Vec2; 2]) -> f64 {
    let along = b - a;
    let share = ((place - a).dot(along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (place - a - along * share).norm()
}

/// The faces of each cell, as their ends counter-clockwise around it.
pub fn faces_of_cells(made: &Partition) -> Vec<Vec<(Vec2, Vec2, Face)>> {
    let mut found = vec![Vec::new(); made.cells.len()];
    for face in &made.faces {
        for (side, ends) in face.sides.iter().zip([(face.from, face.to), (face.to, face.from)]) {
            if let Side::Cell(cell) = side {
                found[*cell].push((ends.0, ends.1, *face));
            }
        }
    }
    found
}

/// Closure, areas and centres of cells, sides of the lattice, lines.
pub fn check(made: &Partition, lattice: &Lattice, is_cell: impl Fn(usize) -> bool, lines: &[Line]) {
    assert_eq!(made.faults, 0, "gaps or overlaps");
    check_cells(made, lattice);
    check_lattice(made, lattice, &is_cell);
    check_lines(made, lattice, lines);
}

fn check_cells(made: &Partition, lattice: &Lattice) {
    let (spacing, cell_at) = (lattice.spacing, cell_at(made, lattice));
    for (number, faces) in faces_of_cells(made).iter().enumerate() {
        let cell = &made.cells[number];
        let origin = cell.centre;
        let sum = faces.iter().fold(Vec2::ZERO, |sum, (from, to, _)| sum + (*to - *from));
        assert!(sum.norm() <= 1e-13 * spacing, "cell {number} at {origin:?} is open by {:e}", sum.norm());
        let twice: f64 = faces.iter().map(|(from, to, _)| (*from - origin).cross(*to - origin)).sum();
        let error = (0.5 * twice - cell.area).abs() / (spacing * spacing);
        assert!(error < 1e-12, "area of cell {number} at {origin:?}: {} and {}", 0.5 * twice, cell.area);
        let of_parts: f64 = cell.parts.iter().map(|part| area(part)).sum();
        assert!(
            (of_parts - cell.area).abs() < 1e-8 * spacing * spacing,
            "parts of cell {number}: {of_parts} {}",
            cell.area
        );
        for part in &cell.parts {
            let middle = part.iter().fold(Vec2::ZERO, |sum, corner| sum + *corner) / part.len() as f64;
            let is_clear = area(part) > 1e-6 * spacing * spacing;
            assert!(!is_clear || cell_at(middle) == Some(number), "cell {number} not found at {middle:?}");
        }
    }
    for face in &made.faces {
        assert!(matches!(face.sides[0], Side::Cell(_)), "{face:?}");
        let length = (face.to - face.from).norm();
        assert!(length > 1e-12 * spacing, "{face:?}");
    }
}

/// Area of a polygon.
pub fn area(corners: &[Vec2]) -> f64 {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    0.5 * sides.map(|(a, b)| (*a - corners[0]).cross(*b - corners[0])).sum::<f64>()
}

fn check_lattice(made: &Partition, lattice: &Lattice, is_cell: &impl Fn(usize) -> bool) {
    let is_kept = |cell: usize| is_cell(cell) && made.replaced.binary_search(&cell).is_err();
    assert!(made.replaced.windows(2).all(|pair| pair[0] < pair[1]) && made.replaced.iter().all(|cell| is_cell(*cell)));
    let mut expected = 0;
    for face in &made.faces {
        if let Side::Lattice(cell) = face.sides[1] {
            assert!(is_kept(cell), "{face:?} is beside a cell that is not there");
            let away = (face.from + face.to) * 0.5 - lattice.centre(cell);
            let is_whole = ((face.to - face.from).norm() - lattice.spacing).abs() < 1e-11 * lattice.spacing;
            let is_side = (away.x.abs().max(away.y.abs()) - 0.5 * lattice.spacing).abs() < 1e-11 * lattice.spacing;
            assert!(is_whole && is_side, "{face:?} is no side of cell {cell}");
            expected += 1;
        }
    }
    let mut sides = 0;
    for cell in (0..lattice.len()).filter(|cell| is_kept(*cell)) {
        let beside = crate::lattice::NEIGHBOURS.iter().filter_map(|step| lattice.neighbour(cell, *step));
        sides += beside.filter(|other| is_cell(*other) && !is_kept(*other)).count();
    }
    assert_eq!(sides, expected, "sides of the lattice without a face, or with two");
}

pub fn check_lines(made: &Partition, lattice: &Lattice, lines: &[Line]) {
    let spacing = lattice.spacing;
    let rounding = 1e-12 * spacing + 1e-15 * lattice.size().norm();
    for face in &made.faces {
        if let Some(line) = face.line {
            let distance = |place: Vec2| {
                segments(&lines[line]).into_iter().map(|ends| distance(place, ends)).fold(f64::INFINITY, f64::min)
            };
            assert!(distance(face.from).max(distance(face.to)) < rounding, "{face:?} is off its line");
        }
        let is_passable = matches!(face.sides[1], Side::Cell(_) | Side::Lattice(_));
        for line in lines.iter().filter(|line| line.kind != LineKind::Follow) {
            assert!(!is_passable || !crosses(face, line, spacing), "{face:?} crosses a wall");
        }
    }
}

/// Whether a face crosses a line or lies on it.
fn crosses(face: &Face, line: &Line, spacing: f64) -> bool {
    let is_near = |ends: &[Vec2; 2]| {
        let (low, high) = (ends[0].x.min(ends[1].x), ends[0].x.max(ends[1].x));
        face.from.x.max(face.to.x) >= low && face.from.x.min(face.to.x) <= high
    };
    segments(line).into_iter().filter(is_near).any(|[a, b]| {
        let (along, way) = (b - a, face.to - face.from);
        let slack = 1e-9 * spacing;
        let side = |place: Vec2| along.cross(place - a) / along.norm().max(f64::MIN_POSITIVE);
        let other = |place: Vec2| way.cross(place - face.from) / way.norm();
        let parts = side(face.from).min(side(face.to)) < -slack && side(face.from).max(side(face.to)) > slack;
        let is_parted = other(a).min(other(b)) < -slack && other(a).max(other(b)) > slack;
        let lies_on = distance((face.from + face.to) * 0.5, [a, b]) < slack
            && distance(face.from * 0.75 + face.to * 0.25, [a, b]) < slack;
        (parts && is_parted) || lies_on
    })
}
