//! The partition of a mirrored scene is the mirrored partition.

use super::checks::lattice;
use super::random::{EDGE, aligned_scene, scene};
use crate::math::Vec2;
use crate::partition::weld::Weld;
use crate::partition::{Line, Partition};

type Mirror = fn(Vec2) -> Vec2;

const MIRRORS: [Mirror; 3] = [
    |place| Vec2::new(EDGE as f64 - place.x, place.y),
    |place| Vec2::new(place.x, EDGE as f64 - place.y),
    |place| Vec2::new(place.y, place.x),
];

/// Centres of cells and middles of faces.
fn marks(made: &Partition) -> Vec<Vec2> {
    let centres = made.cells.iter().map(|cell| cell.centre);
    centres.chain(made.faces.iter().map(|face| (face.from + face.to) * 0.5)).collect()
}

/// The greatest distance of a mark of the mirrored scene from one of the scene; infinite where one is missing.
fn difference(lines: &[Line], mirror: Mirror) -> f64 {
    let lattice = lattice(EDGE, EDGE, 1.0);
    let own = marks(&Partition::new(&lattice, |_| true, lines));
    let mirrored = |line: &Line| Line { points: line.points.iter().map(|point| mirror(*point)).collect(), ..line.clone() };
    let lines: Vec<Line> = lines.iter().map(mirrored).collect();
    let other = marks(&Partition::new(&lattice, |_| true, &lines));
    if own.len() != other.len() {
        return f64::INFINITY;
    }
    let mut weld = Weld::default();
    own.iter().for_each(|mark| _ = weld.number(*mark));
    let distance = |mark: &Vec2| {
        let known = weld.known(mirror(*mark));
        known.map_or(f64::INFINITY, |number| (weld.places[number as usize] - mirror(*mark)).norm())
    };
    other.iter().map(distance).fold(0.0, f64::max)
}

#[test]
fn mirrored_scenes_have_mirrored_cells() {
    let mut greatest = 0.0_f64;
    for seed in 0..200 {
        let lines = scene(seed);
        for (number, mirror) in MIRRORS.into_iter().enumerate() {
            let difference = difference(&lines, mirror);
            assert!(difference < 1e-12, "scene {seed} in mirror {number}: {difference:e}");
            greatest = greatest.max(difference);
        }
    }
    println!("greatest difference {greatest:e}");
}

/// Lines along the lattice and through its corners have exact ties, in which a neighbour is chosen by its number.
#[test]
fn most_aligned_scenes_have_mirrored_cells() {
    let differs = |seed: &u64| MIRRORS.into_iter().any(|mirror| difference(&aligned_scene(*seed), mirror) > 1e-12);
    let different: Vec<u64> = (0..200).filter(differs).collect();
    println!("aligned scenes that differ in a mirror: {different:?}");
    assert!(different.len() <= 6, "{different:?}");
}
#[test]
fn debug_mirror() {
    let lattice = lattice(EDGE, EDGE, 1.0);
    let lines = scene(54);
    let m = MIRRORS[1];
    let mirrored: Vec<Line> = lines.iter().map(|line: &Line| Line { points: line.points.iter().map(|point| m(*point)).collect(), ..line.clone() }).collect();
    for (i, line) in lines.iter().enumerate() {
        for s in super::checks::segments(line) {
            let s = crate::partition::segment::Segment { ends: s, line: i };
            if s.distance(Vec2::new(17.88, 16.84)) < 0.5 { println!("L {i} {:?} {:?}", s.ends, line.kind); }
        }
    }
    for (k, lines) in [lines, mirrored].iter().enumerate() {
        let made = Partition::new(&lattice, |_| true, lines);
        for f in &made.faces {
            let (a, b) = if k == 0 { (f.from, f.to) } else { (m(f.from), m(f.to)) };
            if ((a + b) * 0.5 - Vec2::new(17.88, 16.84)).norm() < 0.4 { println!("F {k} {:?} {a:?} {b:?} {:?}", f.sides, f.line); }
        }
    }
}
