//! Warns of upright steps of the terrain inside the cells of the lattice: walls and houses that take less than half of a cell are not in its bed.

use rayon::prelude::*;

use crate::bed::{BedParticles, LeftOut, highest_step};
use crate::error::input_warning;
use crate::math::Vec2;
use crate::prepare::findings::Findings;
use crate::scenario::Scenario;
use crate::scenario::methods::BedMethod;
use crate::terrain::{Piece, Terrain};

/// Warns of cells with an upright step in them, where their bed is a mean.
pub fn check(
    scenario: &Scenario,
    terrain: &Terrain,
    (bed, left_out): (&BedParticles, &impl LeftOut),
    findings: &mut Findings,
) {
    if scenario.numerics.bed != BedMethod::Mean {
        return;
    }
    let lattice = &bed.lattice;
    let step_in = |pieces: &mut Vec<Piece>, cell: usize| {
        let centre = lattice.to_map(lattice.centre(cell));
        terrain.pieces(centre, lattice.spacing, false, pieces);
        if left_out.is_near(cell) {
            pieces.retain(|piece| !left_out.holds(cell, centre + piece.offset));
        }
        let step = highest_step(pieces, lattice.spacing, &bed.constants)?;
        bed.has_terrain(cell).then_some((step.height, centre + step.offset))
    };
    let steps = (0..lattice.len()).into_par_iter().map_init(Vec::new, step_in).flatten();
    let steps: Vec<(f64, Vec2)> = steps.collect();
    let Some(&(highest, place)) = steps.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    let cells = if steps.len() == 1 { "1 cell".to_owned() } else { format!("{} cells", steps.len()) };
    let message = format!("the terrain steps upright inside {cells}, by up to {highest:.1} m");
    let problem = input_warning("steps-in-cells", message)
        .with_cause("the bed of a cell is the mean of the terrain on the larger side of the step: a wall or a house that takes less than half of a cell is not in it")
        .with_remedy(
            "if water must go around or over them, give `structures.buildings`, `structures.walls` or `terrain.breaklines`, or a finer `resolution`",
        )
        .with_at(place);
    findings.add(&scenario.resolution, problem);
}
