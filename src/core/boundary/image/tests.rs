use super::*;
use crate::bed::BedParticles;
use crate::boundary::outline;
use crate::lattice::Lattice;

fn seen_places(edges: Vec<Edge>, positions: &[Vec2]) -> Vec<(u32, Vec2)> {
    let walls = Walls::new(edges, 1.0);
    let mut scratch = ImageScratch::default();
    let mut seen = Vec::new();
    let found: Vec<u32> = (0..positions.len() as u32).collect();
    let from = Viewpoint { place: positions[0], support: 5.0, particle: Some(0) };
    walls.see(&from, &found, positions, &vec![5.0; positions.len()], &mut scratch, &mut seen);
    let mut places: Vec<(u32, Vec2)> = seen
        .iter()
        .map(|image| (image.index, walls.isometries()[image.transform as usize].point(positions[image.index as usize])))
        .collect();
    places.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.x.total_cmp(&b.1.x)).then(a.1.y.total_cmp(&b.1.y)));
    places
}

fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> Edge {
    Edge { start: Vec2::new(x0, y0), end: Vec2::new(x1, y1), is_open: false }
}

#[test]
fn corner_closes_the_lattice() {
    // A particle on the diagonal: its line of sight to the image of its image goes through the very corner.
    for positions in [[Vec2::new(0.5, 0.5), Vec2::new(1.5, 0.5)], [Vec2::new(0.7, 0.4), Vec2::new(1.1, 2.0)]] {
        let places = seen_places(vec![wall(0.0, 9.0, 0.0, 0.0), wall(0.0, 0.0, 9.0, 0.0)], &positions);
        let mut expected: Vec<(u32, Vec2)> = Vec::new();
        for (j, p) in positions.iter().enumerate() {
            for (sx, sy) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                if j > 0 || sx + sy < 2.0 {
                    expected.push((j as u32, Vec2::new(sx * p.x, sy * p.y)));
                }
            }
        }
        assert_eq!(places.len(), expected.len(), "{places:?}");
        for (index, place) in expected {
            assert!(places.iter().any(|&(j, p)| j == index && (p - place).norm() < 1e-12));
        }
    }
}

#[test]
fn pieces_of_one_wall_act_as_one() {
    let positions = [Vec2::new(1.0, 0.5), Vec2::new(2.0, 1.0), Vec2::new(1.0, -0.5)];
    let whole = seen_places(vec![wall(-9.0, 0.0, 9.0, 0.0)], &positions);
    let pieces =
        seen_places(vec![wall(-9.0, 0.0, 1.0, 0.0), wall(1.0, 0.0, 1.3, 0.0), wall(1.3, 0.0, 9.0, 0.0)], &positions);
    assert_eq!(whole, pieces);
    assert_eq!(whole.len(), 3, "the particle behind the wall is not seen: {whole:?}");
}

/// What every particle sees within `support` (m): whose image, and where.
fn all_seen(walls: &Walls, positions: &[Vec2], support: f64) -> Vec<Vec<(u32, Vec2)>> {
    let supports = vec![support as f32; positions.len()];
    let found: Vec<u32> = (0..positions.len() as u32).collect();
    let (mut scratch, mut seen) = (ImageScratch::default(), Vec::new());
    let place = |image: &Image| walls.isometries()[image.transform as usize].point(positions[image.index as usize]);
    (0..positions.len())
        .map(|i| {
            seen.clear();
            let from = Viewpoint { place: positions[i], support, particle: Some(i as u32) };
            walls.see(&from, &found, positions, &supports, &mut scratch, &mut seen);
            let near = |&(_, place): &(u32, Vec2)| (place - positions[i]).norm() < support * (1.0 - 1e-9);
            seen.iter().map(|image| (image.index, place(image))).filter(near).collect()
        })
        .collect()
}

/// Asserts that every particle of a room sees what an unbounded lattice of mirror images around its corners shows.
fn assert_closed(walls: &Walls, size: f64, positions: &[Vec2], support: f64) {
    for (i, seen) in all_seen(walls, positions, support).into_iter().enumerate() {
        let mut expected = 0;
        for (j, p) in positions.iter().enumerate() {
            let copies = |p: f64| [p, -p, 2.0 * size - p];
            for (x, y) in copies(p.x).into_iter().flat_map(|x| copies(p.y).map(|y| (x, y))) {
                let image = Vec2::new(x, y);
                if image != positions[i] && (image - positions[i]).norm() < support * (1.0 - 1e-9) {
                    expected += 1;
                    let is_seen = seen.iter().any(|&(index, q)| index == j as u32 && (q - image).norm() < 1e-9 * size);
                    assert!(is_seen, "{:?} does not see the image of {p:?} at {image:?}", positions[i]);
                }
            }
        }
        assert_eq!(seen.len(), expected, "{:?} sees images that are none", positions[i]);
    }
}

#[test]
fn every_corner_of_a_room_shows_all_images() {
    let mut state = 5_u64;
    let mut next = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for spacing in [0.025, 0.05, 0.1, 0.2, 0.3, 1.0 / 3.0, 0.7, 1.0, 20.0] {
        let lattice = Lattice::new(Vec2::ZERO, 8, 8, spacing);
        let bed = BedParticles::from_elevation(lattice, vec![0.0; 64], 0.0);
        let walls = Walls::new(outline(&bed, |_, _| false), spacing);
        let centres: Vec<Vec2> = (0..64).map(|cell| bed.lattice.centre(cell)).collect();
        assert_closed(&walls, 8.0 * spacing, &centres, 3.1 * spacing);
        for _ in 0..20 {
            let places: Vec<Vec2> = (0..40).map(|_| Vec2::new(next(), next()) * (8.0 * spacing)).collect();
            // Arrangements that are symmetric about the diagonal have their lines of sight through the very corner.
            let mirrored = places.iter().map(|p| Vec2::new(p.y, p.x));
            let both: Vec<Vec2> = places.iter().copied().chain(mirrored).collect();
            assert_closed(&walls, 8.0 * spacing, &both, 3.1 * spacing);
        }
    }
}

#[test]
fn joints_of_a_wall_hide_no_image_in_its_corner() {
    let positions = [Vec2::new(2.5, 0.3), Vec2::new(0.4, 2.4), Vec2::new(1.2, 0.7)];
    let whole = seen_places(vec![wall(0.0, 9.0, 0.0, 0.0), wall(0.0, 0.0, 9.0, 0.0)], &positions);
    let pieces = [wall(0.0, 9.0, 0.0, 0.0), wall(0.0, 0.0, 1.3, 0.0), wall(1.3, 0.0, 9.0, 0.0)];
    assert_eq!(whole, seen_places(pieces.to_vec(), &positions));
    assert_eq!(whole.len(), 9, "all but two images lie within the support: {whole:?}");
}

#[test]
fn end_of_a_wall_ends_its_image() {
    let positions = [Vec2::new(1.0, 0.5), Vec2::new(2.0, 1.0)];
    assert_eq!(seen_places(vec![wall(1.8, 0.0, 9.0, 0.0)], &positions).len(), 1);
}
