//! Whether water finds its way to the opening of a dam, and from it.

use std::collections::BTreeMap;

use super::BESIDE_DAM;
use super::dam::ends;
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind};
use crate::math::{Vec2, segments_cross};
use crate::prepare::findings::Findings;
use crate::scenario::Scenario;
use crate::solver::{Breach, DamCell};

/// Refuses a wall in the opening, and warns of a bank beside it: no water would pass, without a word.
pub fn check_way(
    scenario: &Scenario,
    breach: &Breach,
    bed: &BedParticles,
    walls: &[[Vec2; 2]],
    findings: &mut Findings,
) {
    let Some(written) = &scenario.breach else { return };
    let lattice = &bed.lattice;
    let opened: Vec<&DamCell> = breach.cells.iter().filter(|cell| breach.bed(cell, 1.0) < breach.crest).collect();
    let beside = [Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)];
    let walled = opened.iter().find(|cell| {
        let centre = lattice.centre(cell.cell);
        let ways =
            beside.iter().flat_map(|way| [*way, *way * -1.0]).map(|way| [centre, centre + way * lattice.spacing]);
        let mut pieces = ways.flat_map(|way| walls.iter().map(move |wall| (way, *wall)));
        pieces.any(|(way, wall)| segments_cross(way, wall))
    });
    if let Some(cell) = walled {
        let message = "a wall (`structures.walls`) stands in the opening of the dam, and does not break".to_owned();
        let problem = Problem::error(ProblemKind::Scenario, "wall-in-breach", "", message)
            .with_remedy("take the wall out: `breach` raises the dam itself")
            .with_at(lattice.to_map(lattice.centre(cell.cell)));
        findings.add(&written.dam, problem);
        return;
    }
    let lowest = opened.iter().map(|cell| breach.bed(cell, 1.0)).fold(f64::INFINITY, f64::min);
    let passable = 0.5 * (lowest + breach.crest);
    if sides_reached(breach, &opened, passable, bed) != [true; 2]
        && let Some(cell) = opened.first()
    {
        let message =
            format!("beside the opening the terrain stands above {passable:.2} m, half of the height of the opening");
        let problem = Problem::warning(ProblemKind::Input, "opening-blocked", "", message)
            .with_cause("the terrain holds the dam or an embankment already, or a levee crosses before the dam")
            .with_remedy("look at the terrain beside the dam; carve out what falls with it (`terrain.breaklines`, `mode: carve`)")
            .with_at(lattice.to_map(lattice.centre(cell.cell)));
        findings.add(&written.dam, problem);
    }
}

/// On which sides of the dam water as high as `passable` (m) finds its way from the opening over some cells.
fn sides_reached(breach: &Breach, opened: &[&DamCell], passable: f64, bed: &BedParticles) -> [bool; 2] {
    let lattice = &bed.lattice;
    let [Some(start), Some(end)] = ends(&breach.cells).map(|cell| cell.map(|cell| lattice.centre(cell.cell))) else {
        return [false; 2];
    };
    let across = (end - start).perpendicular() * (1.0 / (end - start).norm().max(f64::MIN_POSITIVE));
    let of_dam: BTreeMap<usize, f64> = breach.cells.iter().map(|cell| (cell.cell, breach.bed(cell, 1.0))).collect();
    let reach = BESIDE_DAM * lattice.spacing;
    let mut next: Vec<usize> =
        opened.iter().filter(|cell| breach.bed(cell, 1.0) < passable).map(|cell| cell.cell).collect();
    // Of each cell that is reached the cell of the opening from which it was.
    let mut reached: BTreeMap<usize, usize> = next.iter().map(|cell| (*cell, *cell)).collect();
    let mut sides = [false; 2];
    while let Some(cell) = next.pop() {
        let (from, centre) = (reached[&cell], lattice.centre(cell));
        let off = (centre - lattice.centre(from)).dot(across);
        for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let other = lattice.cell_at(centre + Vec2::new(x, y) * lattice.spacing);
            // The edge of the terrain is as good as a way on.
            let Some(other) = other.filter(|cell| bed.has_terrain(*cell)) else {
                sides[usize::from(off > 0.0)] = true;
                continue;
            };
            let level = of_dam.get(&other).copied().unwrap_or(bed.elevation[other]);
            if level >= passable || reached.contains_key(&other) {
                continue;
            }
            let way = lattice.centre(other) - lattice.centre(from);
            if way.dot(across).abs() > reach {
                sides[usize::from(off > 0.0)] = true;
            } else if way.norm() <= 3.0 * reach {
                reached.insert(other, from);
                next.push(other);
            }
        }
    }
    sides
}
