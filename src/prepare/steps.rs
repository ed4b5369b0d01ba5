//! Upright steps of the terrain inside the cells of the lattice: walls, houses and quays that the mean of a cell lowers to their share of it.

use rayon::prelude::*;

use super::findings::Findings;
use crate::bed::{BedParticles, LeftOut};
use crate::error::input_warning;
use crate::math::Vec2;
use crate::scenario::Scenario;
use crate::scenario::methods::BedMethod;
use crate::terrain::{Piece, Terrain};

/// A step is at least so high (m), which is more than furrows and rounded elevations,
const LEAST_STEP: f64 = 1.0;
/// and rises by more than so much for each metre from one raster cell to the next: steeper than ground stands by itself.
const UPRIGHT: f64 = 1.0;

/// Warns of cells with an upright step in them, where their bed is a mean.
pub(super) fn check(
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
        let (step, offset) = largest_step(pieces)?;
        bed.has_terrain(cell).then_some((step, centre + offset))
    };
    let steps = (0..lattice.len()).into_par_iter().map_init(Vec::new, step_in).flatten();
    let steps: Vec<(f64, Vec2)> = steps.collect();
    let Some(&(highest, place)) = steps.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    let cells = if steps.len() == 1 { "1 cell".to_owned() } else { format!("{} cells", steps.len()) };
    let message = format!("the terrain steps upright inside {cells}, by up to {highest:.1} m");
    let problem = input_warning("steps-in-cells", message)
        .with_cause("the bed of a cell is the mean of its terrain: a wall or a house in it is lowered to its share of the cell")
        .with_remedy(
            "if water must go around or over them, give `structures.buildings`, `structures.walls` or `terrain.breaklines`, or a finer `resolution`",
        )
        .with_at(place);
    findings.add(&scenario.resolution, problem);
}

/// The highest upright step (m) between neighbouring pieces, and its place; none without one.
fn largest_step(pieces: &[Piece]) -> Option<(f64, Vec2)> {
    let row = pieces.first()?.offset.y;
    let columns = pieces.iter().take_while(|piece| (piece.offset.y - row).abs() <= 0.0).count();
    let beside = |i: usize| pieces.get(i + 1).filter(|other| (other.offset.y - pieces[i].offset.y).abs() <= 0.0);
    let below = |i: usize| pieces.get(i + columns).filter(|other| (other.offset.x - pieces[i].offset.x).abs() <= 0.0);
    let step = |a: &Piece, b: &Piece| {
        let height = (a.elevation - b.elevation).abs();
        let is_upright = height >= LEAST_STEP && height > UPRIGHT * (a.offset - b.offset).norm();
        is_upright.then_some((height, (a.offset + b.offset) * 0.5))
    };
    let steps =
        (0..pieces.len()).flat_map(|i| [beside(i), below(i)].into_iter().flatten().map(move |other| (i, other)));
    steps.filter_map(|(i, other)| step(&pieces[i], other)).max_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(values: &[f64], columns: usize) -> Vec<Piece> {
        let offset = |i: usize| Vec2::new((i % columns) as f64, -((i / columns) as f64));
        values.iter().enumerate().map(|(i, &elevation)| Piece { offset: offset(i), elevation, share: 1.0 }).collect()
    }

    #[test]
    fn a_step_is_upright_between_neighbours_alone() {
        assert_eq!(largest_step(&pieces(&[0.0, 0.5, 1.0, 0.9, 1.4, 1.8], 3)), None);
        // From west to east, and from north to south; the end of one row is no neighbour of the start of the next.
        assert_eq!(largest_step(&pieces(&[0.0, 0.0, 3.0, 0.5, 0.5, 1.2], 3)), Some((3.0, Vec2::new(1.5, 0.0))));
        assert_eq!(largest_step(&pieces(&[0.0, 0.5, 1.0, -4.0, -3.4, -2.7], 3)), Some((4.0, Vec2::new(0.0, -0.5))));
        assert_eq!(largest_step(&pieces(&[9.0], 1)), None);
        assert_eq!(largest_step(&[]), None);
    }
}
