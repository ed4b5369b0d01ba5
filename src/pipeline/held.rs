//! What the ground holds back of the rain: films too thin to flow, and what stands in pits below their rims.

use super::edges::outlets;
use super::stages::more_area;
use crate::bed::spill_levels;
use crate::output::HeldBack;
use crate::prepare::Setup;
use crate::scenario::Scenario;
use crate::solver::{FlowSolver, Way};

/// The pits of the ground, as it is at the start.
pub(super) struct Pits {
    /// Of each cell with terrain that stands for its place: its number, bed and spill level (m), and area (m²).
    cells: Vec<(usize, f64, f64, f64)>,
    dry_depth: f64,
    /// Water below the spill levels at the start (m³).
    at_start: f64,
}

impl Pits {
    /// Those of a setup on which rain falls; none without.
    pub fn of(scenario: &Scenario, setup: &Setup) -> Option<Pits> {
        scenario.rain.as_ref()?;
        let (bed, scene) = (&setup.bed, &setup.scene);
        let lattice = &bed.lattice;
        let spill = spill_levels(bed, &outlets(scene, bed));
        let mut more = more_area(bed).into_iter().peekable();
        let mut places: Vec<usize> = lattice.levels().flat_map(|level| lattice.leaves_of(level)).collect();
        places.sort_unstable();
        let mut cells = Vec::new();
        for cell in places.into_iter().filter(|&cell| bed.has_terrain(cell)) {
            let mut area = lattice.area_of(cell);
            while let Some((_, extra)) = more.next_if(|(other, _)| *other <= cell) {
                area += extra;
            }
            cells.push((cell, bed.elevation[cell], spill[cell], area));
        }
        let mut pits = Pits { cells, dry_depth: scenario.numerics.dry_depth, at_start: 0.0 };
        pits.at_start = pits.holds(|cell| setup.still_water.depth[cell]).1;
        Some(pits)
    }

    /// What they hold now.
    pub fn now(&self, solver: &mut dyn FlowSolver) -> HeldBack {
        let passages = solver.passages();
        let of_rain = passages.iter().filter(|passage| passage.way == Way::Rain);
        let water = solver.water();
        let (films, in_pits) = self.holds(|cell| water.at(cell).depth);
        HeldBack {
            in_films_m3: films,
            in_pits_m3: (in_pits - self.at_start).max(0.0),
            of_rain_m3: of_rain.map(|passage| passage.inflow).sum(),
        }
    }

    /// The water (m³) in films, and that below the spill levels.
    fn holds(&self, depth: impl Fn(usize) -> f64) -> (f64, f64) {
        let (mut films, mut in_pits) = (0.0, 0.0);
        for &(cell, bed, spill, area) in &self.cells {
            let depth = depth(cell);
            if depth <= self.dry_depth {
                films += depth * area;
            } else {
                in_pits += depth.min(spill - bed) * area;
            }
        }
        (films, in_pits)
    }
}
