//! Equal volumes, evenly spaced, in the water, and the same on any number of threads.

use super::*;
use crate::bed::{Nothing, place_bed};
use crate::constants::SeedingConstants;
use crate::methods::BedMethod;
use crate::seeding::Barriers;
use crate::seeding::still_water::fill_still_water;
use crate::seeding::still_water::tests::{Formula, body, lattice, regular};

/// A paraboloid with an island, filled by particles of the given volume.
fn seeds(particle_volume: f64) -> (Vec<FluidSeed>, StillWater) {
    let surface = Formula(|p: Vec2| {
        let island = 12.0 - 0.5 * (p - Vec2::new(30.0, 10.0)).norm();
        (20.0 * p.norm_squared() / 1e4).max(8.0 + island)
    });
    let mut bed = place_bed(&surface, &lattice(60, 5.0), BedMethod::Pointwise, &Nothing, 0.03);
    let bodies = [body(regular(Vec2::ZERO, 120.0, 40, 0.1), 20.0)];
    let (still, shore) = fill_still_water(&bodies, &bed, &surface, Barriers::default(), &SeedingConstants::DEFAULT);
    bed.set(&shore);
    (equal_volume_filling(&[20.0], &bed, &still, particle_volume), still)
}

#[test]
fn volumes_are_equal_and_meet_the_integral() {
    for particle_volume in [30.0, 250.0, 2000.0] {
        let (seeds, still) = seeds(particle_volume);
        let total: f64 = seeds.iter().map(|seed| seed.volume).sum();
        assert!((total / still.volumes[0].integral_m3 - 1.0).abs() < 1e-12);
        assert!(seeds.iter().all(|seed| (seed.volume / particle_volume - 1.0).abs() < 0.01));
        assert!(seeds.iter().all(|seed| seed.depth > 0.0));
    }
}

#[test]
fn as_many_particles_as_wet_cells() {
    let (_, still) = seeds(250.0);
    let (seeds, _) = seeds(mean_cell_volume(&still));
    assert!(seeds.len().abs_diff(still.volumes[0].cells) <= 1, "{} of {}", seeds.len(), still.volumes[0].cells);
}

#[test]
fn distance_of_particles_follows_the_depth() {
    let (seeds, _) = seeds(250.0);
    let distance_to_nearest = |seed: &FluidSeed| {
        let others = seeds.iter().map(|other| (other.position - seed.position).norm()).filter(|&r| r > 0.0);
        others.fold(f64::INFINITY, f64::min) / (seed.volume / seed.depth).sqrt()
    };
    let mut ratios: Vec<f64> = seeds.iter().filter(|seed| seed.depth > 2.0).map(distance_to_nearest).collect();
    ratios.sort_by(f64::total_cmp);
    // Between 1 (square) and 1.07 (hexagonal) on a perfect lattice of uniform depth; random places give a mean of 0.5.
    let (low, median, high) = (ratios[ratios.len() / 50], ratios[ratios.len() / 2], ratios[ratios.len() * 49 / 50]);
    assert!(low > 0.7 && (0.85..1.07).contains(&median) && high < 1.25, "{low} {median} {high}");
}

#[test]
fn no_particle_stands_for_an_area_out_of_proportion() {
    for particle_volume in [30.0, 250.0, 2000.0] {
        let (seeds, still) = seeds(particle_volume);
        let mut areas: Vec<f64> = seeds.iter().map(|seed| seed.volume / seed.depth).collect();
        areas.sort_by(f64::total_cmp);
        let (lake, largest) = (25.0 * still.volumes[0].cells as f64, areas[areas.len() - 1]);
        assert!(areas.iter().sum::<f64>() < 1.2 * lake && largest < 0.05 * lake, "{largest} m² of {lake} m²");
    }
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let run =
        |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| seeds(250.0).0);
    assert_eq!(run(1), run(3));
}

#[test]
fn hilbert_curve_visits_neighbours_in_turn() {
    let bits = 4;
    let mut places: Vec<(u64, u64, u64)> =
        (0..1 << bits).flat_map(|x| (0..1 << bits).map(move |y| (along_hilbert_curve(x, y, bits), x, y))).collect();
    places.sort_unstable();
    for (expected, (pair, &(place, ..))) in places.windows(2).zip(&places).enumerate() {
        assert_eq!(place, expected as u64);
        assert_eq!(pair[0].1.abs_diff(pair[1].1) + pair[0].2.abs_diff(pair[1].2), 1);
    }
}
