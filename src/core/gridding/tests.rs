//! Volume, levels, hills, holes, spans, threads.

use super::*;
use crate::bed::BedParticles;
use crate::boundary::{Edge, Walls};
use crate::lattice::WaterInCell;

/// Adds a particle that takes up a square of edge `spacing` (m).
fn push(particles: &mut FluidParticles, position: Vec2, spacing: f64, depth: f64, velocity: Vec2) {
    particles.position.push(position);
    particles.volume.push(spacing * spacing * depth);
    particles.depth.push(depth);
    particles.velocity.push(velocity);
    particles.smoothing_length.push(1.5 * spacing);
    particles.share.push(spacing * spacing * depth);
}

/// Particles at distances of `spacing` over a rectangle, moved by up to `jitter` spacings, where a depth is given.
fn block(low: Vec2, high: Vec2, spacing: f64, jitter: f64, depth: impl Fn(Vec2) -> Option<f64>) -> FluidParticles {
    let mut particles = FluidParticles::default();
    let columns = ((high.x - low.x) / spacing) as usize;
    let rows = ((high.y - low.y) / spacing) as usize;
    let noise = |i: usize, factor: f64| ((i as f64 + 0.5) * factor).fract() - 0.5;
    for i in 0..columns * rows {
        let place = Vec2::new((i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5);
        let moved = place + Vec2::new(noise(i, 0.618_034), noise(i, 0.754_878)) * (2.0 * jitter);
        let position = low + moved * spacing;
        if let Some(depth) = depth(position) {
            push(&mut particles, position, spacing, depth, Vec2::new(1.0 + 0.01 * position.x, -0.5));
        }
    }
    particles
}

/// A gridder of the plane.
fn gridder(bed: &BedParticles) -> Gridder {
    Gridder::new(&bed.lattice, Dimension::Two)
}

/// A bed given by a formula, not-a-number where there is no terrain; 100 by 80 cells of 2 m.
fn bed(formula: impl Fn(Vec2) -> f64) -> BedParticles {
    let lattice = Lattice::new(Vec2::ZERO, 100, 80, 2.0);
    let elevation = (0..lattice.len()).map(|index| formula(lattice.centre(index))).collect();
    BedParticles::from_elevation(lattice, elevation, 0.03)
}

/// Walls all around a lattice.
fn room(lattice: &Lattice) -> Walls {
    let size = lattice.size();
    let corners = [Vec2::ZERO, Vec2::new(size.x, 0.0), size, Vec2::new(0.0, size.y)];
    let edge = |k: usize| Edge { start: corners[k], end: corners[(k + 1) % 4], is_open: false };
    Walls::new((0..4).map(edge).collect(), lattice.spacing)
}

/// Volume and both momenta (over ρ) on the grid against those of the particles.
fn assert_conserved(particles: &FluidParticles, grid: &WaterOnLattice, cell_area: f64) {
    let on_grid = |field: fn(WaterInCell) -> f64| grid.cells().map(field).sum::<f64>() * cell_area;
    let momentum = |component: fn(&Vec2) -> f64| -> f64 {
        particles.volume.iter().zip(&particles.velocity).map(|(vol, v)| vol * component(v)).sum()
    };
    let volume: f64 = particles.volume.iter().sum();
    assert!((on_grid(|cell| cell.depth) - volume).abs() <= 1e-12 * volume);
    assert!((on_grid(|cell| cell.discharge_x) - momentum(|v| v.x)).abs() <= 1e-11 * volume);
    assert!((on_grid(|cell| cell.discharge_y) - momentum(|v| v.y)).abs() <= 1e-11 * volume);
}

#[test]
fn volume_and_momentum_are_conserved_on_rough_ground_with_nodata() {
    let rough = |p: Vec2| {
        let is_hole = (p - Vec2::new(90.0, 70.0)).norm() < 15.0;
        if is_hole { f64::NAN } else { 3.0 * (0.31 * p.x).sin() * (0.23 * p.y).cos() + 0.01 * p.x }
    };
    let bed = bed(rough);
    // Also particles off the terrain by a little, and particles on peaks without any depth to speak of.
    let particles = block(Vec2::new(-2.0, 5.0), Vec2::new(203.0, 150.0), 3.1, 0.3, |p| {
        Some(1e-6 + 2.0 * (0.05 * p.x).cos().powi(2))
    });
    let mut gridder = gridder(&bed);
    let grid = gridder.grid(&bed, &Walls::new(Vec::new(), 1.0), &particles);
    for (index, depth) in grid.depths().into_iter().enumerate() {
        assert!(depth >= 0.0 && (bed.has_terrain(index) || depth == 0.0));
    }
    let stray = gridder.stray_volume();
    let shares: &[Share] = bytemuck::cast_slice(&gridder.own.0[0]);
    assert_eq!(stray > 0.0, shares.iter().any(|share| share.patch.rows == 0));
    let mut inside = FluidParticles::default();
    for j in 0..particles.len() {
        let position = particles.position[j];
        if (position - Vec2::new(90.0, 70.0)).norm() > 13.0 {
            push(&mut inside, position, 3.1, particles.depth[j], particles.velocity[j]);
        }
    }
    assert!(stray > 0.0, "the middle of the hole is out of reach");
    let grid = gridder.grid(&bed, &Walls::new(Vec::new(), 1.0), &inside);
    assert_conserved(&inside, &grid, bed.lattice.cell_area());
    assert!(gridder.stray_volume().abs() <= 0.0);
}

#[test]
fn lake_at_rest_over_a_slope_is_level() {
    let mut bed = bed(|p| 0.1 * p.x + 0.02 * p.y);
    bed.is_sloped = true;
    // Spacing, jitter, and the root mean square error of the depth (relative) that was found, times 1.5. The blocks fill the lattice:
    // water that is missing at its rim would be missed farther inside as well.
    for (spacing, jitter, allowed) in [
        (2.0, 0.0, 3e-4),
        (2.5, 0.0, 5e-4),
        (1.25, 0.0, 5e-4),
        (5.0, 0.0, 1.5e-3),
        (2.5, 0.15, 0.009),
        (2.5, 0.3, 0.04),
    ] {
        let depth = |p: Vec2| Some(10.0 - 0.1 * p.x - 0.02 * p.y).filter(|&d| d > 0.0);
        let particles = block(Vec2::ZERO, Vec2::new(200.0, 160.0), spacing, jitter, depth);
        let mut gridder = gridder(&bed);
        let grid = gridder.grid(&bed, &room(&bed.lattice), &particles);
        assert_conserved(&particles, &grid, bed.lattice.cell_area());
        let (mut squares, mut count, mut high) = (0.0, 0.0, 0.0_f64);
        for index in 0..bed.lattice.len() {
            let place = bed.lattice.centre(index);
            let exact = 10.0 - bed.elevation[index];
            // Nothing lies above the level on the dry slope.
            assert!(exact > -1e-12 || grid.at(index).depth == 0.0);
            // Away from the shore, where supports are cut, and from the outline.
            let rim = 4.0 * spacing;
            let is_inner = place.x > rim && place.y > rim && place.y < 160.0 - rim;
            if is_inner && exact > 0.1 * (rim + 10.0) {
                let error = grid.at(index).depth / exact - 1.0;
                (squares, count, high) = (squares + error * error, count + 1.0, high.max(error));
            }
        }
        let mean = f64::sqrt(squares / count);
        assert!(
            mean < allowed && high < 10.0 * allowed,
            "{mean} (up to {high}) with spacing {spacing} and jitter {jitter}"
        );
    }
}

/// A lake in a room without any dry ground: greatest error of the depth in the cells, and root mean square, over the mean depth.
fn unevenness(bed: &BedParticles, level: f64, spacing: f64, jitter: f64) -> (f64, f64) {
    let size = bed.lattice.size();
    let depth = |p: Vec2| bed.at(p).map(|point| level - point.elevation);
    let particles = block(Vec2::ZERO, size, spacing, jitter, depth);
    let mut gridder = gridder(bed);
    let grid = gridder.grid(bed, &room(&bed.lattice), &particles);
    assert_conserved(&particles, &grid, bed.lattice.cell_area());
    let errors = || grid.depths().into_iter().zip(&bed.elevation).map(|(depth, z)| depth - (level - z));
    let cells = bed.lattice.len() as f64;
    let mean = bed.elevation.iter().map(|z| level - z).sum::<f64>() / cells;
    let greatest = errors().fold(0.0_f64, |most, error| most.max(error.abs()));
    (greatest / mean, (errors().map(|error| error * error).sum::<f64>() / cells).sqrt() / mean)
}

#[test]
fn lake_at_rest_is_level_over_a_curved_bed_and_beside_walls() {
    let flat = bed(|_| 0.0);
    let curved = |p: Vec2| (p.x / 8.0).sin() * (p.y / 10.8).cos() - 3.0;
    let mut curved_bed = bed(curved);
    curved_bed.is_sloped = true;
    // Spacing, jitter, and the errors that were found (greatest, root mean square), times 1.2.
    for (bed, level, spacing, jitter, allowed) in [
        (&flat, 2.3, 2.0, 0.0, (1.75e-3, 3.2e-4)),
        (&flat, 2.3, 2.5, 0.0, (2.5e-3, 5.4e-4)),
        (&flat, 2.3, 4.0, 0.0, (7.4e-3, 8.5e-4)),
        (&flat, 2.3, 2.0, 0.2, (1.8e-2, 6.4e-3)),
        (&curved_bed, 2.0, 2.0, 0.0, (1.86e-3, 3.2e-4)),
        (&curved_bed, 2.0, 4.0, 0.0, (8.5e-3, 9e-4)),
        (&curved_bed, 2.0, 2.0, 0.2, (1.95e-2, 6.5e-3)),
    ] {
        let (greatest, mean) = unevenness(bed, level, spacing, jitter);
        assert!(
            greatest < allowed.0 && mean < allowed.1,
            "{greatest:.2e}, {mean:.2e} with spacing {spacing} and jitter {jitter}"
        );
    }
}

#[test]
fn no_water_above_a_hill() {
    let hill = |p: Vec2| if (p - Vec2::new(100.0, 80.0)).norm() < 9.0 { 50.0 } else { 0.0 };
    let bed = bed(hill);
    let off_hill = |p: Vec2| (hill(p) == 0.0).then_some(3.0);
    let particles = block(Vec2::new(40.0, 30.0), Vec2::new(160.0, 130.0), 4.0, 0.2, off_hill);
    let mut gridder = gridder(&bed);
    let grid = gridder.grid(&bed, &Walls::new(Vec::new(), 1.0), &particles);
    // A particle between the foot and the top may stand on the slope that the lattice draws there, up to its own level.
    let on_hill = (0..bed.lattice.len()).filter(|&i| (bed.lattice.centre(i) - Vec2::new(100.0, 80.0)).norm() < 6.0);
    assert!(on_hill.into_iter().all(|index| grid.at(index).depth == 0.0));
}

#[test]
fn uniform_block_has_no_holes() {
    let bed = bed(|_| 0.0);
    for spacing in [0.7, 1.0, 2.0, 3.0, 5.0, 8.0] {
        for jitter in [0.0, 0.3] {
            let (low, high) = (Vec2::new(40.0, 30.0), Vec2::new(160.0, 130.0));
            let particles = block(low, high, spacing, jitter, |_| Some(1.0));
            let mut gridder = gridder(&bed);
            let grid = gridder.grid(&bed, &Walls::new(Vec::new(), 1.0), &particles);
            assert_conserved(&particles, &grid, bed.lattice.cell_area());
            for index in 0..bed.lattice.len() {
                let place = bed.lattice.centre(index);
                let inside = place.x > low.x + spacing
                    && place.y > low.y + spacing
                    && place.x < high.x - 2.0 * spacing
                    && place.y < high.y - 2.0 * spacing;
                assert!(
                    !inside || grid.at(index).depth > 0.2,
                    "{} at {place:?}, spacing {spacing}",
                    grid.at(index).depth
                );
            }
        }
    }
}

#[test]
fn particle_above_its_own_water_gives_all_to_the_lowest_cell() {
    // Too little depth to stand on the centre of any cell of this ridge.
    let bed = bed(|p| -(p.x - 100.0).abs());
    let mut particles = FluidParticles::default();
    push(&mut particles, Vec2::new(0.4, 80.0), 0.1, 0.0, Vec2::new(2.0, 0.0));
    particles.volume[0] = 1.0;
    let mut gridder = gridder(&bed);
    let grid = gridder.grid(&bed, &Walls::new(Vec::new(), 1.0), &particles);
    assert_conserved(&particles, &grid, bed.lattice.cell_area());
    assert_eq!(grid.depths().iter().filter(|&&depth| depth > 0.0).count(), 1);
}

#[test]
fn spans_hold_the_water_of_now_and_of_before() {
    let bed = bed(|_| 0.0);
    let at = |x: f64| block(Vec2::new(x, 40.0), Vec2::new(x + 20.0, 90.0), 3.0, 0.2, |_| Some(1.0));
    let mut gridder = gridder(&bed);
    let holds = |spans: &[Span], index: usize| {
        let (column, row) = bed.lattice.column_row(index);
        let is_in = |span: &Span| span.row as usize == row && (span.from as usize..span.to as usize).contains(&column);
        spans.iter().any(is_in)
    };
    let mut before = vec![0.0; bed.lattice.len()];
    for particles in [at(20.0), at(40.0), at(140.0), FluidParticles::default(), FluidParticles::default()] {
        let grid = gridder.grid(&bed, &Walls::new(Vec::new(), 1.0), &particles);
        for (index, depth_before) in before.iter().enumerate() {
            let expected = grid.at(index).depth > 0.0 || *depth_before > 0.0;
            assert_eq!(holds(grid.spans, index), expected);
        }
        let keys: Vec<(u32, u32)> =
            grid.spans.iter().flat_map(|span| [(span.row, span.from), (span.row, span.to)]).collect();
        assert!(keys.is_sorted());
        assert_conserved(&particles, &grid, bed.lattice.cell_area());
        before = grid.depths();
    }
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let bed = bed(|p| 2.0 * (0.2 * p.x).sin() + (0.3 * p.y).cos());
    let particles = block(Vec2::new(5.0, 5.0), Vec2::new(195.0, 155.0), 2.3, 0.4, |_| Some(2.0));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut gridder = gridder(&bed);
        pool.install(|| {
            gridder
                .grid(&bed, &Walls::new(Vec::new(), 1.0), &particles)
                .cells()
                .map(|cell| cell.discharge_x)
                .collect::<Vec<f64>>()
        })
    };
    assert_eq!(run(1), run(2));
    assert_eq!(run(1), run(7));
}

#[test]
fn nothing_lands_beyond_a_wall_or_a_levee() {
    // A lake west of 100 m, particles wider than cells; a levee of two cells, and a wall without thickness.
    let levee = |p: Vec2| if (p.x - 101.0).abs() < 2.0 { 9.0 } else { 0.0 };
    let wall = Edge { start: Vec2::new(100.0, 0.0), end: Vec2::new(100.0, 160.0), is_open: false };
    let lake = block(Vec2::new(0.0, 0.0), Vec2::new(99.0, 160.0), 6.0, 0.1, |_| Some(1.0));
    for (bed, edges) in [(bed(levee), vec![]), (bed(|_| 0.0), vec![wall])] {
        let mut gridder = gridder(&bed);
        let grid = gridder.grid(&bed, &Walls::new(edges, 2.0), &lake);
        assert_conserved(&lake, &grid, 4.0);
        for (index, depth) in grid.depths().into_iter().enumerate() {
            let x = bed.lattice.centre(index).x;
            assert!(x < 100.0 || depth <= 0.0, "{depth} m at {x} m");
        }
    }
}
