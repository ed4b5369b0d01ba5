use super::*;

const G: f64 = 9.81;

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * (1.0 + a.abs().max(b.abs()))
}

fn is_close(one: SectionState, other: SectionState) -> bool {
    close(one.level, other.level) && close(one.outwards, other.outwards)
}

/// Water of a level (m) and a velocity outwards (m/s) before a section.
fn at(level: f64, outwards: f64) -> Option<SectionState> {
    Some(SectionState { level, outwards })
}

#[test]
fn the_invariant_that_leaves_is_kept_by_every_condition() {
    for depth in [0.3, 2.0] {
        for outwards in [-0.4, 0.0, 0.9] {
            let inside = EdgeState { depth, outwards };
            let r = inside.invariant(G);
            let states = [
                at_depth(1.1 * depth, (1.0, 1.0), r, G),
                at_depth(1.1 * depth, (1.0, 0.0), r, G),
                inflow(0.2 * depth, None, r, G),
                uniform_flow(1e-3, G * 9e-4, r, G),
                waves_leave(1.05 * depth, inside, 0.0, G),
                waves_leave(0.95 * depth, inside, 0.6, G),
                overfall(r, G),
            ];
            for state in states {
                assert!(close(state.invariant(G), r), "{inside:?}: {state:?}");
            }
        }
    }
}

#[test]
fn the_state_inside_is_found_again_where_it_fits_the_condition() {
    let (depth, velocity) = (1.3, -0.7);
    let r = EdgeState { depth, outwards: velocity }.invariant(G);
    assert!(close(inflow(-depth * velocity, None, r, G).depth, depth));
    for cosine in [1.0, 0.8, 0.5_f64.sqrt()] {
        let still = depth + (velocity / cosine) * (velocity / cosine) / (2.0 * G);
        assert!(close(at_depth(still, (cosine, 1.0), r, G).outwards, velocity), "{cosine}");
    }
    let (slope, n): (f64, f64) = (2e-3, 0.03);
    let uniform = slope.sqrt() / n * depth.cbrt().powi(2);
    let r = EdgeState { depth, outwards: uniform }.invariant(G);
    assert!(close(uniform_flow(slope, G * n * n, r, G).depth, depth));
}

#[test]
fn inflow_onto_dry_ground_is_critical_or_as_held() {
    let q: f64 = 3.0;
    let critical = (q * q / G).cbrt();
    assert!(close(inflow(q, None, 0.0, G).depth, critical));
    assert!(close(inflow(q, Some(2.0 * critical), 0.0, G).depth, critical), "a slow pair says nothing of the level");
    let fast = inflow(q, Some(0.5 * critical), 0.0, G);
    assert!(close(fast.depth, 0.5 * critical) && close(fast.outwards, -2.0 * q / critical));
    assert_eq!(inflow(0.0, None, 0.0, G), EdgeState { depth: 0.0, outwards: 0.0 });
}

#[test]
fn deep_water_drowns_a_fast_inflow() {
    let q = 3.0;
    let deep = EdgeState { depth: 6.0, outwards: -0.5 };
    let state = inflow(q, Some(0.5), deep.invariant(G), G);
    assert!(state.depth > 5.0 && close(-state.depth * state.outwards, q));
    let shallow = EdgeState { depth: 0.9, outwards: -2.0 };
    assert!(close(inflow(q, Some(0.5), shallow.invariant(G), G).depth, 0.5));
}

/// A main channel of 10 m between plains of together 30 m, 2 m higher, and a strip of no width.
const COMPOUND: [(f64, f64); 3] = [(10.0, 0.0), (0.0, 1.0), (30.0, 2.0)];

#[test]
fn a_section_of_one_strip_takes_a_discharge_as_a_face_does() {
    let width = 7.0;
    let section = Section(std::iter::once((width, 0.4)));
    for (depth, outwards, held) in
        [(1.3, -0.7, None), (1.3, 0.9, None), (0.2, -6.0, Some(0.8)), (6.0, -0.5, Some(0.5)), (0.9, -2.0, Some(0.5))]
    {
        for q in [0.0, 0.3, 3.0] {
            let face = inflow(q, held, EdgeState { depth, outwards }.invariant(G), G);
            let level = section.inflow(width * q, held.map(|d| d + 0.4), at(depth + 0.4, outwards), G);
            assert!((level - 0.4 - face.depth).abs() < 1e-9, "{depth} m, {q} m2/s: {level} m, {face:?}");
        }
    }
    let critical = section.inflow(width * 3.0, None, None, G);
    assert!(close(critical - 0.4, (9.0 / G).cbrt()));
}

#[test]
fn a_compound_section_finds_again_the_level_that_fits_and_never_one_that_is_faster_than_waves() {
    let section = Section(COMPOUND.into_iter());
    let area = |level: f64| COMPOUND.iter().map(|(w, b)| w * (level - b).max(0.0)).sum::<f64>();
    let surface = |level: f64| COMPOUND.iter().filter(|(_, b)| *b < level).map(|(w, _)| w).sum::<f64>();
    for level in [0.7, 1.9, 2.4, 4.0] {
        let outwards = -0.4;
        let found = section.inflow(-outwards * area(level), None, at(level, outwards), G);
        assert!(close(found, level), "{level} m: {found} m");
    }
    for discharge in [5.0, 60.0, 80.0, 100.0, 140.0, 900.0] {
        for before in [None, at(0.3, -7.0), at(1.6, -9.0), at(2.1, -1.0)] {
            let level = section.inflow(discharge, None, before, G);
            let froude_squared = discharge * discharge * surface(level) / (G * area(level).powi(3));
            assert!(froude_squared <= 1.0 + 1e-9, "{discharge} m3/s, {before:?}: {level} m, Fr² {froude_squared}");
        }
    }
    // 9.81 A³ = Q² T on the plains, and in the main channel.
    assert!(close(section.inflow(140.0, None, None, G), 2.0 + ((140.0 * 140.0 * 40.0 / G).cbrt() - 20.0) / 40.0));
    assert!(close(section.inflow(30.0, None, None, G), (9.0 / G).cbrt()));
}

#[test]
fn a_section_of_one_strip_lets_waves_out_as_a_face_does() {
    let (bed, rest) = (0.4, 1.7);
    let section = Section(std::iter::once((7.0, bed)));
    for depth in [0.0, 0.3, 1.7, 2.9] {
        for outwards in [-3.0, -0.2, 0.0, 0.4, 2.0] {
            let inside = EdgeState { depth, outwards };
            let face = waves_leave(rest, EdgeState { outwards, ..inside }, 0.0, G);
            let SectionState { level, outwards: velocity } =
                section.waves_leave(rest + bed, at(depth + bed, outwards), G);
            // A face leaves outflow faster than waves to the flux of (M31).
            let fall = overfall(inside.invariant(G), G);
            let face = if face.outwards > fall.outwards.max(0.0) { fall } else { face };
            let is_same = (level - bed - face.depth).abs() < 1e-12 && (velocity - face.outwards).abs() < 1e-12;
            assert!(is_same, "{inside:?}: {level} m, {velocity} m/s, {face:?}");
        }
    }
    let SectionState { level, outwards: velocity } = section.waves_leave(rest + bed, None, G);
    assert!(close(level - bed, rest * 4.0 / 9.0) && close(velocity, -(G * (level - bed)).sqrt()));
}

#[test]
fn simple_waves_leave_a_compound_section_as_if_there_were_no_end() {
    let section = Section(COMPOUND.into_iter());
    let froude = |SectionState { level, outwards }: SectionState| outwards / section.below(level, G).celerity(G);
    for rest in [0.7, 1.9, 2.05, 4.0] {
        let still = section.below(rest, G).omega;
        for level in [0.6, 1.9, 1.99, 2.01, 2.3, 4.5] {
            let wave = SectionState { level, outwards: section.below(level, G).omega - still };
            let beyond = section.waves_leave(rest, Some(wave), G);
            if froude(wave) > 1.0 {
                assert!(section.is_swept(wave, G));
                continue;
            }
            if level > section.critical_of(still, rest, G) {
                assert!(is_close(beyond, wave), "{wave:?} into {rest} m: {beyond:?}");
            }
            assert!(froude(beyond).abs() <= 1.0 + 1e-9, "{wave:?} into {rest} m: {beyond:?}");
        }
        let found = section.waves_leave(rest, None, G);
        assert!(close(froude(found), -1.0) && close(section.below(found.level, G).omega - found.outwards, still));
    }
}

#[test]
fn nothing_leaves_faster_than_critical_and_nothing_comes_in_faster() {
    let r = EdgeState { depth: 1.0, outwards: 0.5 }.invariant(G);
    let fall = at_depth(0.0, (1.0, 1.0), r, G);
    assert!(close(fall.outwards, (G * fall.depth).sqrt()) && close(fall.invariant(G), r));
    let flood = at_depth(2.0, (1.0, 1.0), 0.0, G);
    assert!(close(flood.depth, 4.0 / 3.0) && close(flood.outwards, -(G * flood.depth).sqrt()), "a broad crest");
    let askew = at_depth(2.0, (0.8, 1.0), 0.0, G);
    let head = askew.depth + (askew.outwards / 0.8).powi(2) / (2.0 * G);
    assert!(close(head, 2.0) && close(askew.outwards, -0.8 * (G * askew.depth).sqrt()));
    let fan = waves_leave(2.0, EdgeState { depth: 0.0, outwards: 0.0 }, 0.0, G);
    assert!(close(fan.depth, 8.0 / 9.0) && close(fan.outwards, -(G * fan.depth).sqrt()), "the front of a dam break");
    let steep = uniform_flow(0.2, G * 1e-4, r, G);
    assert!(close(steep.outwards, (G * steep.depth).sqrt()));
}

#[test]
fn a_level_at_the_edge_is_held_whether_water_comes_or_goes() {
    let held: f64 = 1.3;
    let c = (G * held).sqrt();
    for outwards in [-0.9 * c, -0.4, 0.0, 0.7, 0.9 * c] {
        let r = EdgeState { depth: held, outwards }.invariant(G);
        let state = at_depth(held, (1.0, 0.0), r, G);
        assert!(close(state.depth, held) && close(state.outwards, outwards), "{outwards} m/s: {state:?}");
    }
    // Beyond critical flow: the state at x = 0 of the fan u − c = x/t onto dry ground, and a fall.
    let onto_dry = at_depth(held, (1.0, 0.0), 0.0, G);
    assert!(close(onto_dry.depth, held) && close(onto_dry.outwards, -c));
    let fall = at_depth(held, (1.0, 0.0), 4.5 * c, G);
    assert!(close(fall.outwards, 1.5 * c) && close(fall.depth, 2.25 * held));
    // A share of the head lies in between.
    let r = EdgeState { depth: held, outwards: -1.0 }.invariant(G);
    let depths = [0.0, 0.3, 1.0].map(|paid| at_depth(held, (1.0, paid), r, G).depth);
    assert!(depths[0] > depths[1] && depths[1] > depths[2], "{depths:?}");
}

#[test]
fn what_comes_in_over_a_stair_is_what_comes_in_over_the_edge() {
    // Faces across the way and along it, of an edge of length 1 at an angle.
    for paid in [0.0, 1.0] {
        let discharge = |cosine: f64| {
            let state = at_depth(2.0, (cosine, paid), 0.0, G);
            state.depth * state.outwards
        };
        for degrees in [0.0_f64, 10.0, 30.0, 45.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let of_stair = cosine * discharge(cosine) + if sine > 0.0 { sine * discharge(sine) } else { 0.0 };
            assert!(close(of_stair, discharge(1.0)), "{degrees} degrees, {paid}: {of_stair}");
        }
    }
}

#[test]
fn a_wave_comes_in_through_those_that_leave() {
    let (rest, at_rest): (f64, f64) = (1.7, 0.0);
    let c = |depth: f64| (G * depth).sqrt();
    let straight = |wave: f64, before: EdgeState| wave_enters((wave, rest), (1.0, 0.0), (before, 0.0), G);
    for wave in [1.2, 1.69, 1.7, 2.4] {
        // Into still water it is a simple wave; where it stands already it goes on as it is.
        let speed = -2.0 * (c(wave) - c(rest));
        let first = straight(wave, EdgeState { depth: rest, outwards: at_rest });
        assert!(close(first.depth, wave) && close(first.outwards, speed), "{wave} m: {first:?}");
        let later = straight(wave, EdgeState { depth: wave, outwards: speed });
        assert!(close(later.depth, wave) && close(later.outwards, speed), "{wave} m: {later:?}");
        // What comes in is 4 c_w − 2 c_0 whatever leaves.
        for depth in [1.5, 1.7, 2.2] {
            let state = straight(wave, EdgeState { depth, outwards: 0.1 });
            let comes = 2.0 * c(state.depth) - state.outwards;
            assert!(close(comes, 4.0 * c(wave) - 2.0 * c(rest)), "{wave} m, {depth} m: {state:?}");
        }
        // A weak one leaves at any angle through one that is weak itself.
        for degrees in [20.0_f64, 47.0, 70.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let leaving = 2.0 * (c(wave + 1e-6) - c(wave));
            let before = EdgeState { depth: wave + 1e-6, outwards: speed + leaving * cosine };
            let state = wave_enters((wave, rest), (1.0, 0.0), (before, leaving * sine), G);
            assert!((state.depth - before.depth).abs() < 1e-12, "{wave} m at {degrees} degrees: {state:?}");
        }
    }
    let high = straight(9.0, EdgeState { depth: rest, outwards: at_rest });
    assert!(close(high.outwards, -c(high.depth)) && high.depth < 9.0, "it would outrun itself: {high:?}");
    let dry = wave_enters((0.5, 0.0), (1.0, 0.0), (EdgeState { depth: 0.0, outwards: 0.0 }, 0.0), G);
    assert!(close(dry.depth, 0.5) && close(dry.outwards, -c(0.5)), "over dry ground: {dry:?}");
}

#[test]
fn a_section_of_one_strip_holds_a_level_and_lets_a_wave_in_as_a_face_does() {
    let bed = 0.4;
    let section = Section(std::iter::once((7.0, bed)));
    for depth in [0.0, 0.9, 1.7, 2.6] {
        for outwards in [-2.0, -0.2, 0.0, 0.4, 2.0] {
            let before = EdgeState { depth: if outwards > 1.0 { 1.7_f64.max(depth) } else { depth }, outwards };
            let inside = at(before.depth + bed, before.outwards);
            for level in [1.1, 1.7, 2.2] {
                let face = at_depth(level, (1.0, 0.0), before.invariant(G), G);
                let whole = section.at_level(level + bed, inside, G);
                let is_same =
                    (whole.level - bed - face.depth).abs() < 1e-12 && (whole.outwards - face.outwards).abs() < 1e-12;
                assert!(is_same, "held {level} m, {before:?}: {whole:?}, {face:?}");
                let face = wave_enters((level, 1.7), (1.0, 0.0), (before, 0.0), G);
                let whole = section.wave_enters((level + bed, 1.7 + bed), inside, G);
                let is_same =
                    (whole.level - bed - face.depth).abs() < 1e-12 && (whole.outwards - face.outwards).abs() < 1e-12;
                assert!(is_same || face.outwards > whole.outwards, "wave {level} m, {before:?}: {whole:?}, {face:?}");
            }
        }
    }
}

#[test]
fn a_compound_section_holds_its_level_and_lets_its_own_waves_through() {
    let section = Section(COMPOUND.into_iter());
    let omega = |level: f64| section.below(level, G).omega;
    for level in [0.7, 1.9, 2.3, 4.0] {
        for outwards in [-0.6, 0.0, 0.5] {
            let found = section.at_level(level, at(level, outwards), G);
            assert!(
                close(found.level, level) && close(found.outwards, outwards),
                "{level} m, {outwards} m/s: {found:?}"
            );
        }
        let dry = section.at_level(level, None, G);
        assert!(
            close(dry.level, level) && close(dry.outwards, -section.below(level, G).celerity(G)),
            "{level} m: {dry:?}"
        );
        let wave = SectionState { level: level + 0.1, outwards: omega(level) - omega(level + 0.1) };
        let found = section.wave_enters((wave.level, level), Some(wave), G);
        assert!(is_close(found, wave), "{wave:?} over {level} m: {found:?}");
        let first = section.wave_enters((wave.level, level), at(level, 0.0), G);
        assert!(is_close(first, wave), "{wave:?} over {level} m: {first:?}");
    }
}

#[test]
fn still_water_stays_still() {
    let (depth, n) = (1.7, 0.03);
    let still = EdgeState { depth, outwards: 0.0 };
    let r = still.invariant(G);
    assert!(at_depth(depth, (1.0, 1.0), r, G).outwards.abs() < 1e-14);
    assert!(waves_leave(depth, still, 0.0, G).outwards.abs() < 1e-14);
    assert!(close(inflow(0.0, None, r, G).depth, depth));
    assert_eq!(uniform_flow(1e-3, G * n * n, -1.0, G).depth.to_bits(), 0.0_f64.to_bits());
}

#[test]
fn simple_waves_leave_at_any_angle_as_if_there_were_no_edge() {
    let rest = 1.7;
    for height in [-0.4, -0.01, 0.02, 0.8] {
        for degrees in [0.0_f64, 20.0, 47.0, 61.0, 80.0] {
            let depth = rest + height;
            let speed = 2.0 * ((G * depth).sqrt() - (G * rest).sqrt());
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let before = EdgeState { depth, outwards: speed * cosine };
            let beyond = waves_leave(rest, before, speed * sine, G);
            let is_same = close(beyond.depth, depth) && close(beyond.outwards, before.outwards);
            assert!(is_same, "{height} m at {degrees} degrees: {beyond:?} beyond {before:?}");
        }
    }
    // A current along the edge is no wave: what leaves does so straight ahead.
    let before = EdgeState { depth: 1.75, outwards: 0.05 };
    let (beyond, straight) = (waves_leave(1.75, before, 3.0, G), waves_leave(1.75, before, 0.0, G));
    assert!(close(beyond.depth, straight.depth) && close(beyond.outwards, straight.outwards));
}
