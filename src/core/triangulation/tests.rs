use super::*;

/// A lattice of so many places along each side, moved about by a share of its spacing.
fn places(along: usize, disorder: f64) -> Vec<Vec2> {
    let mut random = 1_u64;
    let mut next = move || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..along * along)
        .map(|k| Vec2::new((k % along) as f64, (k / along) as f64) + Vec2::new(next(), next()) * disorder)
        .collect()
}

/// The triangles by their corners, the smallest first.
fn triangles(of: &Triangulation) -> Vec<[u32; 3]> {
    let turned = |&[a, b, c]: &[u32; 3]| match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    };
    let mut all: Vec<[u32; 3]> = of.corners.iter().filter(|corners| corners[0] != NONE).map(turned).collect();
    all.sort_unstable();
    all
}

/// Every half-edge has its twin, every place a half-edge of its own, and no place lies within the circle of a triangle beside it.
fn check(of: &Triangulation) {
    for (triangle, corners) in of.corners.iter().enumerate().filter(|(_, corners)| corners[0] != NONE) {
        assert!(orientation(of.triangle(triangle as u32)) > 0.0, "triangle {triangle} {corners:?}");
        for edge in [0, 1, 2].map(|k| 3 * triangle as u32 + k) {
            let twin = of.twins[edge as usize];
            if twin != NONE {
                assert_eq!((of.from(edge), of.to(edge), of.twins[twin as usize]), (of.to(twin), of.from(twin), edge));
                assert!(in_circle(of.triangle(edge / 3), of.place(of.from(before(twin)))) <= 0.0);
            }
        }
    }
    for place in (0..of.len() as u32).filter(|&place| of.has(place)) {
        assert_eq!(of.from(of.outgoing[place as usize]), place);
    }
}

#[test]
fn flips_make_of_moved_places_what_a_fresh_triangulation_makes() {
    let mut of = Triangulation::new(places(30, 0.6)).expect("places");
    let mut flips = 0;
    for step in 0..20 {
        let middle = Vec2::new(14.5, 14.5);
        let turn = |place: Vec2| (place - middle).perpendicular() * (0.03 - 0.0025 * (place - middle).norm());
        let is_inside = |place: Vec2| (place - middle).norm() < 12.0;
        let has_moved: Vec<bool> = of.places().iter().map(|&place| is_inside(place)).collect();
        let places = (0_u32..).zip(of.places()).filter(|(k, _)| has_moved[*k as usize]);
        let ways: Vec<(u32, Vec2)> = places.map(|(k, &place)| (k, place + turn(place) * f64::from(step % 3))).collect();
        let repair = of.advance(&ways, |place| has_moved[place as usize]);
        assert!(!repair.is_renewed);
        flips += repair.flips;
        check(&of);
        assert_eq!(triangles(&of), triangles(&Triangulation::new(of.places().to_vec()).expect("places")));
    }
    assert!(flips > 50, "{flips}");
}

#[test]
fn a_place_that_jumps_goes_in_parts_or_is_put_in_again() {
    let mut of = Triangulation::new(places(10, 0.3)).expect("places");
    for (to, is_renewed) in [(Vec2::new(5.3, 5.2), false), (Vec2::new(1.5, 7.6), false)] {
        assert_eq!(of.advance(&[(44, to)], |place| place == 44).is_renewed, is_renewed);
        assert_eq!(of.place(44), to);
        check(&of);
        assert_eq!(triangles(&of), triangles(&Triangulation::new(of.places().to_vec()).expect("places")));
    }
}

#[test]
fn cells_of_a_lattice_are_its_squares_and_areas_add_up() {
    let of = Triangulation::new(places(12, 0.0)).expect("places");
    let inside = |k: &u32| (1..11).contains(&(k % 12)) && (1..11).contains(&(k / 12));
    assert!((0..144).filter(inside).all(|k| (of.area(k) - 1.0).abs() < 1e-14));
    let of = Triangulation::new(places(12, 0.5)).expect("places");
    let mut corners = Vec::new();
    for k in (0..144).filter(inside) {
        of.cell(k, &mut corners);
        let ring = corners.iter().zip(corners.iter().cycle().skip(1));
        let twice: f64 = ring.map(|(a, b)| (*a - of.place(k)).cross(*b - of.place(k))).sum();
        assert!((of.area(k) - 0.5 * twice).abs() < 1e-13, "{k}: {} {}", of.area(k), 0.5 * twice);
    }
}

#[test]
fn places_put_in_and_taken_out_leave_what_was_there() {
    for disorder in [0.0, 0.5] {
        let start = Triangulation::new(places(15, disorder)).expect("places");
        let mut of = start.clone();
        let mut made = Vec::new();
        for k in 0..40 {
            // The corners of cells, on edges and in the middle of lattice squares too.
            let at = Vec2::new(3.0 + 0.5 * f64::from(k % 8), 4.0 + 0.5 * f64::from(k / 8) + 0.25);
            made.extend(of.insert(at, of.outgoing[100] / 3));
            check(&of);
        }
        assert_eq!(made.len(), 40);
        for &place in made.iter().rev() {
            of.remove(place);
            check(&of);
        }
        for place in [100, 101, 116, 85, 112] {
            of.remove(place);
            check(&of);
        }
        if disorder > 0.0 {
            let kept: Vec<u32> = (0..225).filter(|&k| of.has(k)).collect();
            let fresh = Triangulation::new(kept.iter().map(|&k| of.place(k)).collect()).expect("places");
            let renumbered: Vec<[u32; 3]> =
                triangles(&fresh).iter().map(|corners| corners.map(|k| kept[k as usize])).collect();
            assert_eq!(triangles(&of), renumbered);
        }
    }
}

#[test]
fn a_place_that_is_there_already_or_beyond_the_hull_is_not_put_in() {
    let mut of = Triangulation::new(places(5, 0.0)).expect("places");
    assert_eq!(of.insert(Vec2::new(2.0, 2.0), 0), None);
    assert_eq!(of.insert(Vec2::new(-2.0, 2.0), 0), None);
    check(&of);
}
