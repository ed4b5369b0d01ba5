//! Scenes of beds that change, for the tests of both motions.

use crate::bed::BedParticles;
use crate::boundary::{
    BedLaw, BedMotion, Breach, DamCell, Forcing, GrowthLaw, OpenEdges, Opening, Patch, Series, Slide, Trigger,
};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::solver::FlowProblem;
use crate::solver::testing::still_water;

/// A dam that breaks across a rough valley.
pub(in crate::solver) mod valley {
    use super::*;

    pub(in crate::solver) const COLUMNS: usize = 60;
    pub(in crate::solver) const ROWS: usize = 24;
    pub(in crate::solver) const SPACING: f64 = 5.0;
    /// Column of the dam.
    pub(in crate::solver) const DAM: usize = 20;
    pub(in crate::solver) const CREST: f64 = 212.0;
    pub(in crate::solver) const LEVEL: f64 = 209.3;

    pub(in crate::solver) const TRAPEZOID: Opening =
        Opening::Trapezoid { middle: 60.0, bottom_width: 30.0, side_slope: 1.0, invert: 204.5 };

    /// A valley that falls to the east at 0.5 %, with banks and bumps.
    pub(in crate::solver) fn ground(cell: usize) -> f64 {
        let place = lattice().centre(cell);
        let across = (place.y - 60.0) / 60.0;
        let bumps = 0.3 * (0.37 * place.x).sin() * (0.53 * place.y).cos();
        203.0 - 0.005 * place.x + 10.0 * across * across + bumps
    }

    pub(in crate::solver) fn lattice() -> Lattice {
        Lattice::new(Vec2::new(4e5, 5e6), COLUMNS, ROWS, SPACING)
    }

    /// The lake above the dam and the valley below it; without a breach there is no dam.
    pub(in crate::solver) fn problem(breach: Option<Breach>) -> FlowProblem {
        let lattice = lattice();
        let mut elevation: Vec<f64> = (0..lattice.len()).map(ground).collect();
        let initial_depth = (0..lattice.len())
            .map(|cell| if cell % COLUMNS < DAM { (LEVEL - elevation[cell]).max(0.0) } else { 0.0 })
            .collect();
        for cell in breach.iter().flat_map(|breach| &breach.cells) {
            elevation[cell.cell] = elevation[cell.cell].max(CREST);
        }
        FlowProblem {
            bed: BedParticles::from_elevation(lattice, elevation, 0.03),
            walls: Vec::new(),
            open_edges: OpenEdges::default(),
            forcing: Forcing { breach, ..Forcing::default() },
            initial_depth,
            gravity: 9.81,
            courant: 0.5,
            dry_depth: 1e-3,
        }
    }

    pub(in crate::solver) fn breach(trigger: Trigger, opening: Opening, law: GrowthLaw) -> Breach {
        let cell = |row: usize| DamCell {
            cell: row * COLUMNS + DAM,
            station: (row as f64 + 0.5) * SPACING,
            reach: 0.5 * SPACING,
            ground: ground(row * COLUMNS + DAM),
        };
        let cells = (0..ROWS).map(cell).collect();
        Breach { cells, rim: Vec::new(), crest: CREST, trigger, opening, law, duration: 40.0 }
    }
}

/// Small motions of the bottom of a basin of 1600 m, and the surface that linear theory knows.
pub(in crate::solver) mod basin {
    use super::*;

    pub(in crate::solver) const GRAVITY: f64 = 9.81;
    /// Still water (m).
    pub(in crate::solver) const DEPTH: f64 = 10.0;
    /// Height (m) of the hump: a hundred-thousandth of the depth, so that the waves are linear.
    pub(in crate::solver) const SMALL: f64 = 1e-4;

    /// Water of a level of 0 over a bed, `columns` by `rows`.
    pub(in crate::solver) fn problem(size: (usize, usize), spacing: f64, bed: impl Fn(Vec2) -> f64) -> FlowProblem {
        FlowProblem { gravity: GRAVITY, forcing: Forcing::default(), ..still_water(size, spacing, bed, |_| 0.0) }
    }

    /// A hump about the middle (m), of unit height.
    pub(in crate::solver) fn hump(x: f64) -> f64 {
        (-(x / 60.0).powi(2)).exp()
    }

    /// All cells with the change of the bed (m) at their centres.
    pub(in crate::solver) fn everywhere(problem: &FlowProblem, change: impl Fn(Vec2) -> f64) -> Vec<(usize, f64)> {
        let lattice = &problem.bed.lattice;
        (0..lattice.len()).map(|cell| (cell, change(lattice.centre(cell)))).collect()
    }

    /// A sudden uplift in the middle of the basin.
    pub(in crate::solver) fn uplift(problem: &FlowProblem) -> BedMotion {
        let cells = everywhere(problem, |place| SMALL * hump(place.x - 800.0));
        BedMotion { begin: 0.0, cells, law: BedLaw::AtOnce }
    }

    /// Its surface over the height of the hump, at a place (m) from the middle and a time (s): on the hump that stays below, that of
    /// two waves.
    pub(in crate::solver) fn above_uplift(x: f64, time: f64) -> f64 {
        let celerity = (GRAVITY * DEPTH).sqrt();
        0.5 * (hump(x - celerity * time) + hump(x + celerity * time))
    }

    /// A slide that starts at 500 m with a speed of some celerities.
    pub(in crate::solver) fn slide(problem: &FlowProblem, froude: f64) -> BedMotion {
        // The thickness is known at the centres of cells as wide as those of the lattice, but between them.
        let spacing = problem.bed.lattice.spacing;
        let columns = problem.bed.lattice.columns;
        let values = (0..4 * columns).map(|k| SMALL * hump(((k % columns) as f64 + 0.2) * spacing - 500.0)).collect();
        let first = Vec2::new(0.2 * spacing, -spacing);
        let thickness = Patch { first, cell: Vec2::new(spacing, 1.5 * spacing), columns, values };
        let cells = everywhere(problem, |place| thickness.at(place));
        let path = vec![Vec2::new(500.0, 0.0), Vec2::new(2500.0, 0.0)];
        let velocity = Series::constant(froude * (GRAVITY * DEPTH).sqrt());
        BedMotion { begin: 0.0, cells, law: BedLaw::Slide(Slide { thickness, path, velocity }) }
    }

    /// Its surface over the height of the slide: the wave bound to it and the two free ones (M49).
    pub(in crate::solver) fn above_slide(froude: f64, x: f64, time: f64) -> f64 {
        let celerity = (GRAVITY * DEPTH).sqrt();
        let bound = froude * froude / (froude * froude - 1.0);
        let [onward, back] = [0.5 * froude / (1.0 - froude), -0.5 * froude / (1.0 + froude)];
        bound * hump(x + 300.0 - froude * celerity * time)
            + onward * hump(x + 300.0 - celerity * time)
            + back * hump(x + 300.0 + celerity * time)
    }

    pub(in crate::solver) fn order(errors: &[f64]) -> f64 {
        (errors[errors.len() - 2] / errors[errors.len() - 1]).log2()
    }
}
