//! Which level stands where in a run, and the setup on all of them together.
//!
//! A run on the coarsest level tells where water comes, how deep it gets and how fast. A level does for a block where the terrain that its cells do not
//! see is small against that depth, and what they do not see of the velocity head against the mean depth of the flood,
//!
//! ```text
//! (M94)  σ ≤ τ d,  R ≤ τ d    σ of (M93), root mean square over the block, R the highest rise of a pass sill above the beds on
//!                             both sides in it, d the greatest depth about it in that run
//!        ε ≤ τ D              ε of (M101), D the mean of the greatest depths over all cells that the water reaches
//! ```
//!
//! and no block that the water does not come near gets a finer one for its sake. Where that run ends the flood is taken to go on down its valley
//! ([`beyond`]). A level does not do, either, where a block has terrain and none of
//! its cells has: at the edge of a raster.

use crate::bed::{BedParticles, SHUT};
use crate::lattice::{Lattice, Nest, WaterOnLattice};
use crate::math::Vec2;
use crate::output::{FILL, GridMaps, OutputGrid, TerrainPixels};
use crate::prepare::{BLOCK, Because, Following, Setup, Wanted, scatter};
use crate::scenario::Scenario;
use crate::seeding::SeededVolume;
use crate::solver::{FlowProblem, nested};

use super::by_level::Settled;
use super::cores;
use super::downstream::beyond;
use super::scout::Scout;
use super::stages::flow_problem;
use super::steps::step_towards;
use super::unseen_flow::{Greatest, REACHED, Shape, unseen_head};

/// τ of (M94).
pub(super) const UNSEEN: f64 = 0.1;

/// The setup on all of its levels and with the cells that follow lines, and what settled the levels; one on a single lattice of squares stays
/// as it is.
pub(super) fn settle(scenario: &Scenario, mut setup: Setup) -> (Setup, Settled) {
    let following = setup.following.take();
    let Some(mut wanted) = setup.wanted.take() else {
        let Some(following) = following else { return (setup, Settled::default()) };
        let Lattice { columns, rows, spacing, .. } = setup.scene.lattice;
        let nest = Nest::of_one_level((columns, rows), spacing).with(following.conforming.clone());
        return (join(scenario, setup, Vec::new(), (nest, Some(following))), Settled::default());
    };
    let coarser = std::mem::take(&mut setup.coarser);
    let mut scout = None;
    if let Some(coarsest) = coarser.last() {
        let greatest = greatest(scenario, coarsest, scout.insert(Scout::new(scenario, &coarsest.bed)));
        let of_coarsest = (coarser.len(), &coarsest.bed.lattice);
        let beyond = beyond(&greatest, &coarsest.still_water.depth, &setup.bed, of_coarsest);
        refine_by_water(&setup, (&greatest, &beyond, scenario.numerics.gravity), &coarser, &mut wanted);
    }
    let lattice = &setup.scene.lattice;
    let at = |column: usize, row: usize| usize::from(wanted.levels[row * wanted.columns + column]);
    let nest = Nest::graded((lattice.columns, lattice.rows), lattice.spacing, BLOCK, coarser.len(), at);
    let nest = match &following {
        Some(following) => nest.with(following.conforming.clone()),
        None => nest,
    };
    (join(scenario, setup, coarser, (nest, following)), Settled { wanted: Some(wanted), scout })
}

/// The greatest depths and discharges of the cells of a setup on one lattice in a run of its own.
pub(super) fn greatest(scenario: &Scenario, setup: &Setup, scout: &mut Scout) -> Greatest {
    let problem = flow_problem(scenario, setup, setup.bed.clone());
    let depth = problem.initial_depth.clone();
    let mut greatest = Greatest { discharge: vec![0.0; depth.len()], depth };
    let mut solver = cores::build(scenario, problem, Vec::new(), &setup.initial_velocity);
    let mut follow = |water: WaterOnLattice<'_>| {
        for span in water.spans {
            let row = water.rows.row(span.row as usize);
            let first = span.row as usize * water.lattice.columns;
            for column in span.from as usize..span.to as usize {
                let (cell, water) = (first + column, row.at(column));
                greatest.depth[cell] = greatest.depth[cell].max(water.depth);
                let discharge = water.discharge_x.hypot(water.discharge_y);
                greatest.discharge[cell] = greatest.discharge[cell].max(discharge);
            }
        }
    };
    while solver.time() < scenario.end_time {
        let step = step_towards(scenario.end_time, solver.as_mut());
        // Where this run breaks down, what it has shown counts.
        if solver.advance(step.time_step).is_err() {
            break;
        }
        follow(solver.water());
        scout.follow(&step, solver.as_mut());
    }
    greatest
}

/// Asks for finer levels where what coarse cells do not see of terrain and flow counts (M94).
fn refine_by_water(
    setup: &Setup,
    (greatest, beyond, gravity): (&Greatest, &[f64], f64),
    coarser: &[Setup],
    wanted: &mut Wanted,
) {
    let (lattice, coarsest) = (&setup.scene.lattice, coarser.len());
    let coarse = &coarser[coarsest - 1].bed;
    let shape = Shape::new(&setup.bed, (coarsest, coarse), &greatest.depth);
    let mean_depth = greatest.mean_depth();
    let scatters: Vec<(usize, Vec<f64>)> = (1..=coarsest).map(|level| scatter(&setup.bed, level)).collect();
    let rises: Vec<Vec<f64>> = coarser.iter().map(|setup| rises(&setup.bed)).collect();
    let rows = wanted.levels.len() / wanted.columns;
    for row in 0..rows {
        for column in 0..wanted.columns {
            let about = |of: &[f64]| greatest_about((column, row), lattice, (&coarse.lattice, of));
            // Water beyond the end of that run says nothing of places that it reached.
            let depth = Some(about(&greatest.depth)).filter(|depth| *depth >= REACHED);
            let depth = depth.unwrap_or_else(|| about(beyond));
            if depth < REACHED {
                continue;
            }
            let finest = |block: usize, count: usize| block * BLOCK..((block + 1) * BLOCK).min(count);
            let change = shape.change_of_depth(finest(column, lattice.columns), finest(row, lattice.rows));
            let head = unseen_head((about(&greatest.discharge), depth), change, gravity);
            let holds_terrain = |level: usize| {
                let (columns, scatter) = &scatters[level - 1];
                let cells = |block: usize, count: usize| {
                    (block * BLOCK) >> level..(((block + 1) * BLOCK - 1) >> level).min((count - 1) >> level) + 1
                };
                let of_block =
                    cells(row, lattice.rows).flat_map(|r| cells(column, lattice.columns).map(move |c| r * columns + c));
                let has_ridge = of_block.clone().any(|cell| rises[level - 1][cell] > UNSEEN * depth);
                let is_lost = || {
                    let has_terrain = of_block.clone().any(|cell| !scatter[cell].is_nan());
                    has_terrain && !of_block.clone().any(|cell| coarser[level - 1].bed.has_terrain(cell))
                };
                if has_ridge || is_lost() {
                    return false;
                }
                let of_block = of_block.map(|cell| scatter[cell] * scatter[cell]).filter(|square| !square.is_nan());
                let (sum, count) = of_block.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
                (sum / f64::max(count, 1.0)).sqrt() <= UNSEEN * depth
            };
            let holds_flow = |level: usize| head * coarser[level - 1].bed.lattice.spacing <= UNSEEN * mean_depth;
            let coarsest_of =
                |does: &dyn Fn(usize) -> bool| (1..=coarsest).rev().find(|&level| does(level)).unwrap_or(0);
            wanted.set((column, row), coarsest_of(&holds_terrain), Because::Terrain);
            wanted.set((column, row), coarsest_of(&holds_flow), Because::FastWater);
        }
    }
}

/// How high (m) the highest pass sill of each cell rises above the beds on both of its sides.
fn rises(bed: &BedParticles) -> Vec<f64> {
    let mut rises = vec![0.0_f64; bed.lattice.len()];
    for sill in bed.passes.iter() {
        let cells = [sill.cell, sill.other(&bed.lattice)];
        let beds = cells.map(|cell| bed.elevation[cell]);
        // Where no pixel with data joins two cells there is no ridge.
        if sill.level < SHUT {
            let rise = sill.level - f64::max(beds[0], beds[1]);
            cells.into_iter().for_each(|cell| rises[cell] = rises[cell].max(rise));
        }
    }
    rises
}

/// The greatest of some values of coarse cells in and about a block.
fn greatest_about((column, row): (usize, usize), lattice: &Lattice, (coarse, values): (&Lattice, &[f64])) -> f64 {
    let side = BLOCK as f64 * lattice.spacing;
    let cells = |block: usize, count: usize| {
        let first = (block as f64 * side / coarse.spacing).floor() - 1.0;
        let last = ((block + 1) as f64 * side / coarse.spacing).ceil() + 1.0;
        first.max(0.0) as usize..(last.max(0.0) as usize).min(count)
    };
    let about = cells(row, coarse.rows).flat_map(|r| cells(column, coarse.columns).map(move |c| coarse.index(c, r)));
    about.map(|cell| values[cell]).fold(0.0, f64::max)
}

/// Keeps the ground of the finest level for the maps, which lie on it: there the level of the water meets the ground that coarse cells do not see.
fn take_ground_for_maps(scenario: &Scenario, finest: &mut Setup) {
    let lattice = &finest.bed.lattice;
    let is_finest = (scenario.outputs.cell - lattice.spacing).abs() < 1e-9 * lattice.spacing;
    if finest.pixels.is_some() || !is_finest {
        return;
    }
    // Pixels count from the north.
    let from_north = || (0..lattice.rows).rev().flat_map(|row| row * lattice.columns..(row + 1) * lattice.columns);
    let codes = &finest.scene.ground_source.of_cells;
    let of_pixels = if codes.is_empty() { Vec::new() } else { from_north().map(|cell| codes[cell]).collect() };
    finest.pixels = Some(TerrainPixels {
        west: lattice.origin.x,
        north: lattice.origin.y + lattice.size().y,
        cell: lattice.spacing,
        columns: lattice.columns,
        rows: lattice.rows,
        elevation: from_north().map(|cell| finest.bed.elevation[cell] as f32).collect(),
    });
    finest.scene.ground_source.of_pixels = of_pixels;
}

/// The edge (m) of the cell of the run at each place of a grid; nothing of one lattice alone.
pub(super) fn resolution(lattice: &Lattice, grid: &OutputGrid, maps: &GridMaps) -> Vec<f32> {
    if lattice.level_count() == 1 {
        return Vec::new();
    }
    let (x, y) = (grid.x(), grid.y());
    let edge = |(index, &bed): (usize, &f32)| {
        let place = Vec2::new(x[index % grid.columns], y[index / grid.columns]);
        let cell = lattice.cell_of(lattice.to_local(place)).filter(|_| bed > FILL);
        cell.map_or(FILL, |cell| lattice.spacing_of(cell) as f32)
    };
    maps.bed_elevation.iter().enumerate().map(edge).collect()
}

/// Joins the setups of all levels.
fn join(
    scenario: &Scenario,
    mut finest: Setup,
    coarser: Vec<Setup>,
    (nest, following): (Nest, Option<Following>),
) -> Setup {
    let problems = std::iter::once(&finest).chain(&coarser);
    let problems: Vec<FlowProblem> = problems.map(|setup| flow_problem(scenario, setup, setup.bed.clone())).collect();
    let FlowProblem { mut bed, open_edges, forcing, mut initial_depth, .. } = nested(problems, nest);
    let lattice = bed.lattice.clone();
    take_ground_for_maps(scenario, &mut finest);
    let mut body = vec![None; lattice.len()];
    let mut velocity = vec![Default::default(); lattice.len()];
    let setups = std::iter::once(&finest).chain(&coarser);
    for (setup, level) in setups.zip(lattice.levels()) {
        for cell in 0..level.columns * level.rows {
            let place = lattice.in_stack(level, cell);
            body[place] = setup.still_water.body[cell];
            velocity[place] = setup.initial_velocity.get(cell).copied().unwrap_or_default();
        }
    }
    if let Some(following) = following {
        for number in 0..following.conforming.cells().len() {
            let place = lattice.conforming().map_or(0, |conforming| conforming.place(number));
            bed.elevation[place] = following.elevation[number];
            initial_depth[place] = following.start.depth[number];
            body[place] = following.start.body[number];
            let own = following.start.squares[number].and_then(|square| finest.initial_velocity.get(square));
            velocity[place] = own.copied().unwrap_or_default();
        }
        for (volume, beyond) in finest.still_water.volumes.iter_mut().zip(following.start.beyond_squares) {
            volume.integral_m3 += beyond;
        }
        bed.passes = bed.passes.with_faces(following.sills);
        finest.scene.followed = following.lines;
        finest.scene.banks = following.banks;
    }
    count_water(&mut finest.still_water.volumes, &body, (&initial_depth, &bed));
    finest.still_water.depth = initial_depth;
    finest.still_water.body = body;
    if !finest.initial_velocity.is_empty() {
        finest.initial_velocity = velocity;
    }
    let scene = &mut finest.scene;
    for cells in scene.crossed.iter_mut().chain([&mut scene.raised, &mut scene.at_banks]) {
        *cells = cells.iter().map(|&cell| lattice.leaf_of(cell)).collect();
        cells.sort_unstable();
        cells.dedup();
    }
    finest.scene.lattice = lattice;
    finest.scene.forcing = forcing;
    finest.scene.open_edges = open_edges;
    finest.bed = bed;
    finest
}

/// Counts the cells and the volume (m³) of each body of still water.
fn count_water(volumes: &mut [SeededVolume], body: &[Option<u32>], (depth, bed): (&[f64], &BedParticles)) {
    for (number, volume) in (0..).zip(volumes) {
        let is_its = |&cell: &usize| body[cell] == Some(number) && depth[cell] > 0.0 && bed.lattice.is_leaf(cell);
        let cells = || (0..bed.lattice.len()).filter(is_its);
        volume.seeded_m3 = cells().map(|cell| depth[cell] * bed.area(cell)).sum();
        volume.cells = cells().count();
    }
}
