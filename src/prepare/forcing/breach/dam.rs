//! A dam on the lattice: its cells and their ground, and whether its line and its crest fit the terrain.

use super::{OPEN_END, Opened};
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error};
use crate::lattice::Lattice;
use crate::math::{Vec2, readable};
use crate::prepare::findings::Findings;
use crate::prepare::ground::burn::{Foot, crossed, foot_of};
use crate::prepare::ground::crests::{Buried, length_above_ground};
use crate::prepare::outside::{Outside, all_outside, partly_outside};
use crate::scenario::Breach as Written;
use crate::solver::DamCell;

/// A dam on the lattice.
pub struct Dam {
    /// Its line in local coordinates (m).
    pub line: Vec<Vec2>,
    /// Level of its crest (m).
    pub crest: f64,
    /// Its cells on terrain, at least one.
    pub cells: Vec<DamCell>,
}

impl Dam {
    /// Puts a dam on the lattice, and reports what of its line and its crest does not fit the terrain.
    pub fn of(opened: &Opened, written: &Written, bed: &BedParticles, findings: &mut Findings) -> Option<Dam> {
        let (lattice, crest) = (&bed.lattice, opened.crest);
        let line: Vec<Vec2> = opened.line.iter().map(|place| lattice.to_local(*place)).collect();
        let cells = cells_of(&line, bed);
        let Some(lowest) = cells.iter().min_by(|a, b| a.ground.total_cmp(&b.ground)).copied() else {
            all_outside(&written.dam, opened.line[0], findings);
            return None;
        };
        let outside = Outside::beyond_reach(line.windows(2).map(|pair| [pair[0], pair[1]]), bed);
        findings.add_all(&written.dam, partly_outside(&written.dam, outside, lattice.spacing, "there is no dam there"));
        if crest <= lowest.ground {
            let at = lattice.to_map(lattice.centre(lowest.cell));
            add_of_crest(written, below_terrain(crest, lowest.ground).with_at(at), findings);
            return None;
        }
        if let Some(part) = Buried::of(&line, &vec![crest; line.len()], bed) {
            add_of_crest(written, part.problem("the dam").with_at(lattice.to_map(part.place)), findings);
        }
        warn_of_open_ends(&cells, written, crest, lattice, findings);
        Some(Dam { line, crest, cells })
    }

    /// Length of its line (m).
    pub fn length(&self) -> f64 {
        self.line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }

    /// Length over which it stands above the ground (m).
    pub fn length_above_ground(&self, bed: &BedParticles) -> f64 {
        length_above_ground(&self.line, self.crest, bed)
    }
}

/// The cells on terrain below the line of a dam (local coordinates, m).
fn cells_of(line: &[Vec2], bed: &BedParticles) -> Vec<DamCell> {
    let on_terrain = crossed(line, &bed.lattice).into_iter().filter(|cell| bed.has_terrain(*cell));
    on_terrain.map(|cell| dam_cell(cell, line, &bed.lattice, bed.elevation[cell])).collect()
}

/// A cell below the line of a dam (local coordinates, m), with its ground (m).
pub fn dam_cell(cell: usize, line: &[Vec2], lattice: &Lattice, ground: f64) -> DamCell {
    let Foot { station, direction, .. } = foot_of(lattice.centre(cell), line);
    let reach = 0.5 * lattice.spacing * (direction.x.abs() + direction.y.abs());
    DamCell { cell, station, reach, ground }
}

/// The first and the last cell along the dam.
pub fn ends(cells: &[DamCell]) -> [Option<&DamCell>; 2] {
    let by_station = |a: &&DamCell, b: &&DamCell| a.station.total_cmp(&b.station);
    [cells.iter().min_by(by_station), cells.iter().max_by(by_station)]
}

/// The refusal of a crest (m) below the lowest terrain along the dam (m).
fn below_terrain(crest: f64, lowest: f64) -> Problem {
    let message =
        format!("the crest of {} m lies below all terrain along the dam ({lowest:.2} m at least)", readable(crest));
    input_error("crest-below-terrain", message)
        .with_remedy("correct the level, its unit or its datum, or the place of the line")
}

/// Reports a problem of the crest where that is written.
fn add_of_crest(written: &Written, problem: Problem, findings: &mut Findings) {
    match &written.crest {
        Some(crest) => findings.add(crest, problem),
        None => findings.add(&written.dam, problem),
    }
}

/// Warns of ends of the dam beside which water passes.
fn warn_of_open_ends(cells: &[DamCell], written: &Written, crest: f64, lattice: &Lattice, findings: &mut Findings) {
    for end in ends(cells).into_iter().flatten() {
        if end.ground < crest - OPEN_END {
            let message = format!(
                "the dam ends where the ground ({:.2} m) is {:.2} m below its crest",
                end.ground,
                crest - end.ground
            );
            let problem = Problem::warning(ProblemKind::Input, "dam-end-open", "", message)
                .with_cause("higher water passes beside its end, if the edge of the terrain does not hold it")
                .with_remedy("draw the line on into the abutment")
                .with_at(lattice.to_map(lattice.centre(end.cell)));
            findings.add(&written.dam, problem);
        }
    }
}
