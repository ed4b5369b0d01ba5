//! Lakes at rest for 1000 steps: on made beds of a square of 6 m, on a lattice and in disorder, and on terrain.

use std::path::{Path, PathBuf};

use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::{Rectangle, Vec2};
use crate::particles::FluidSeed;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::{BedMethod, Core};
use crate::solver::FlowProblem;
use crate::terrain::{Layer, RasterFile, RasterRequest, Terrain};
use crate::validation::case::{AcceptanceLimit, Case, Setup, SetupResult, Suite, Until};
use crate::validation::outcome::{Check, Snapshot};
use crate::validation::scene::{jittered_lattice, problem, seeds_at};

/// Edge of the square (m).
pub const SIZE: f64 = 6.0;
/// Level of the made lakes (m), high enough for rounding to show.
pub const LEVEL: f64 = 100.0;
/// Steps.
const STEPS: usize = 1000;
/// Disorder: each particle is moved by up to so many spacings in each direction.
const DISORDER: f64 = 0.3;
/// Rounding of levels near 100 m (1e-14 m) in sums over some thirty neighbours, 1000 times (m/s).
const REST: f64 = 1e-12;
/// Share of a terrain that the lake covers.
const FLOODED_SHARE: f64 = 0.5;

const MADE: &[f64] = &[0.5, 0.25, 0.125];
const AT_REST: &[AcceptanceLimit] = &[AcceptanceLimit { max_speed: Some(REST), ..AcceptanceLimit::NONE }];

macro_rules! lakes {
    ($($name:literal, $disordered:literal, $bed:ident, $what:literal;)+) => {
        &[$(
            Case {
                name: $name,
                suite: Suite::Analytic,
                about: concat!("Lake at rest over ", $what, ", 1000 steps: no water may move."),
                is_tuned: true,
                spacings: MADE,
                tested: 2,
                acceptance_limits: AT_REST,
                setup: |spacing, _| Ok(still($bed, spacing, 0.0, STEPS)),
            },
            Case {
                name: $disordered,
                suite: Suite::Analytic,
                about: concat!("The same over ", $what, ", with particles in disorder, up to 0.3 spacings off their lattice."),
                is_tuned: true,
                spacings: MADE,
                tested: 2,
                acceptance_limits: AT_REST,
                setup: |spacing, core| match core {
                    Core::Eulerian | Core::Lagrangian => Err("cells start on their lattice".to_owned()),
                    Core::Variational => Ok(still($bed, spacing, DISORDER, STEPS)),
                },
            },
        )+
        Case {
            name: "lake_valley",
            suite: Suite::Analytic,
            about: "Lake at rest over half of the made valley of data/demo_valley, with all its shores and pockets, 1000 steps.",
            is_tuned: false,
            spacings: &[80.0, 40.0, 20.0],
            tested: 1,
            acceptance_limits: AT_REST,
            setup: |spacing, _| on_valley(spacing),
        },
        Case {
            name: "lake_terrain",
            suite: Suite::Analytic,
            about: "Lake at rest over half of the terrain of Malpasset (malpasset/dem_20m.tif in the folder FLOODSIM_DATA), 1000 steps.",
            is_tuned: false,
            spacings: &[200.0, 100.0, 50.0],
            tested: 1,
            acceptance_limits: AT_REST,
            setup: |spacing, _| match std::env::var_os("FLOODSIM_DATA") {
                Some(folder) => {
                    let file = PathBuf::from(folder).join("malpasset/dem_20m.tif");
                    if file.is_file() { on_terrain(&file, spacing) } else { Err(format!("there is no {}", file.display())) }
                }
                None => Err("the environment variable FLOODSIM_DATA names no folder with terrain".to_owned()),
            },
        },
        ]
    };
}

/// The cases.
pub const CASES: &[Case] = lakes! {
    "lake_bump", "lake_bump_disordered", bump, "a smooth bump";
    "lake_step", "lake_step_disordered", step, "a vertical step of 0.8 m";
    "lake_rough", "lake_rough_disordered", rough, "a random bed, 0.8 m from one particle to the next";
    "lake_island", "lake_island_disordered", island, "a bump that rises above the water";
    "lake_pockets", "lake_pockets_disordered", pockets, "a random bed half of which rises above the water, many pockets";
};

/// A repeatable number in [0, 1) for each place.
pub fn noise(place: Vec2) -> f64 {
    ((place.x * 12.9898 + place.y * 78.233).sin() * 43_758.545_3).fract().abs()
}

/// A hill of unit height.
fn hill(place: Vec2) -> f64 {
    (-(place - Vec2::new(3.1, 2.9)).norm_squared() / 2.0).exp()
}

/// A bump below the water (m).
pub fn bump(place: Vec2) -> f64 {
    LEVEL - 1.0 + 0.5 * hill(place)
}

/// A step (m).
pub fn step(place: Vec2) -> f64 {
    LEVEL - if place.x < 3.0 { 1.0 } else { 0.2 }
}

/// Noise below the water (m).
pub fn rough(place: Vec2) -> f64 {
    LEVEL - 1.0 + 0.8 * noise(place)
}

/// A hill that rises above the water (m).
pub fn island(place: Vec2) -> f64 {
    LEVEL - 1.0 + 1.8 * hill(place)
}

/// Noise half of which rises above the water (m).
pub fn pockets(place: Vec2) -> f64 {
    LEVEL - 0.4 + 0.8 * noise(place)
}

/// A made lake; places are moved by up to `jitter` spacings in each direction.
pub fn still(bed: fn(Vec2) -> f64, spacing: f64, jitter: f64, steps: usize) -> Setup {
    let cells = (SIZE / spacing).round() as usize;
    let mut problem = problem(cells, cells, spacing, bed);
    let seeds = seeds_at(&problem, &jittered_lattice(SIZE, SIZE, spacing, jitter), spacing * spacing, |_| LEVEL);
    fill(&mut problem, LEVEL);
    lake(problem, seeds, LEVEL, steps)
}

fn fill(problem: &mut FlowProblem, level: f64) {
    // Where there is no terrain the maximum with a number that is none gives 0.
    problem.initial_depth = problem.bed.elevation.iter().map(|bed| (level - bed).max(0.0)).collect();
}

fn lake(problem: FlowProblem, seeds: Vec<FluidSeed>, level: f64, steps: usize) -> Setup {
    let bed = problem.bed.clone();
    let exact = move |place: Vec2| (bed.at(place).map_or(0.0, |point| (level - point.elevation).max(0.0)), Vec2::ZERO);
    let mut setup = Setup::new(problem, seeds, Dimension::Two, Until::Steps(steps), Box::new(exact));
    setup.checks = Some(Box::new(move |_, end| vec![at_the_end(end, level)]));
    setup
}

/// The greatest speed after the last step, beside which the one at any step is to be seen.
fn at_the_end(end: &Snapshot, level: f64) -> Check {
    let speed = end.samples.iter().map(|sample| sample.velocity.norm()).fold(0.0, f64::max);
    Check { found: format!("level {level:.1} m; {speed:.1e} m/s after the last step"), is_met: true }
}

/// The same over the made valley, which the program carries with it.
fn on_valley(spacing: f64) -> SetupResult {
    let file = "/vsimem/floodsim/demo_valley.tif";
    gdal::vsi::create_mem_file(file, include_bytes!("../../../data/demo_valley/terrain_10m.tif").to_vec())
        .map_err(|cause| format!("the made valley could not be read: {cause}"))?;
    on_terrain(Path::new(file), spacing)
}

/// A lake over a terrain up to the median of its elevations, with every pocket below that level.
fn on_terrain(file: &Path, spacing: f64) -> SetupResult {
    let request = RasterRequest {
        path: file,
        unit: 1.0,
        offset: 0.0,
        reproject: false,
        resolution: spacing,
        memory: 1e9,
        part: None,
        pixel: None,
        is_ground: true,
    };
    let read = RasterFile::open_as(file, file).and_then(|opened| opened.read(&request, &Crs::Local));
    let (raster, _) = read.map_err(|problem| problem.message)?;
    let terrain =
        Terrain::new(vec![Layer::Raster(raster)]).ok_or_else(|| format!("{} holds no data", file.display()))?;
    let Rectangle { low, high } = terrain.extent();
    let (columns, rows) = (((high.x - low.x) / spacing) as usize, ((high.y - low.y) / spacing) as usize);
    let lattice = Lattice::new(low, columns, rows, spacing);
    let bed = crate::bed::place_bed(&terrain, &lattice, BedMethod::Pointwise, &crate::bed::Nothing, 0.0);
    let mut elevations: Vec<f64> = bed.elevation.iter().copied().filter(|z| !z.is_nan()).collect();
    elevations.sort_by(f64::total_cmp);
    let level = elevations[(FLOODED_SHARE * elevations.len() as f64) as usize];
    let mut problem = FlowProblem { bed, ..problem(columns, rows, spacing, |_| 0.0) };
    fill(&mut problem, level);
    let centres: Vec<Vec2> = (0..lattice.len()).map(|cell| lattice.centre(cell)).collect();
    let seeds = seeds_at(&problem, &centres, lattice.cell_area(), |_| level);
    Ok(lake(problem, seeds, level, STEPS))
}
