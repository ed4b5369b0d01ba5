//! Ground that rises or sinks where it is.

use super::{NO_CHANGE, OTHER_VOLUME, OpenedLaw, at, changes_nothing};
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind};
use crate::lattice::Lattice;
use crate::prepare::findings::Findings;
use crate::scenario::{BedMovement, MovingBed, Scenario};
use crate::solver::{BedLaw, BedMotion};
use crate::terrain::Raster;

/// The motion of ground that rises or sinks where it is.
pub fn in_place(
    raster: &Raster,
    law: OpenedLaw,
    written: &MovingBed,
    scenario: &Scenario,
    ground: &BedParticles,
    findings: &mut Findings,
) -> Option<BedMotion> {
    let lattice = &ground.lattice;
    let change = |cell: usize| Some((cell, raster.elevation(at(lattice, cell))?)).filter(|c| c.1.abs() > NO_CHANGE);
    let (cells, bare): (Vec<_>, Vec<_>) =
        (0..lattice.len()).filter_map(change).partition(|(cell, _)| ground.has_terrain(*cell));
    let name = written.raster.value.display();
    if cells.is_empty() {
        findings.add(&written.raster, changes_nothing(&format!("{name} changes no cell of the terrain"), raster));
        return None;
    }
    if let Some(&(first, _)) = bare.first() {
        let area = bare.len() as f64 * lattice.cell_area();
        let message = format!("{name} changes {} cells ({area} m²) where there is no terrain", bare.len());
        let problem = Problem::warning(ProblemKind::Input, "moves-without-terrain", "", message)
            .with_remedy("nothing, if no water comes there; otherwise give the terrain there")
            .with_at(at(lattice, first));
        findings.add(&written.raster, problem);
    }
    findings.add_all(&written.raster, change_outside(raster, &name.to_string(), lattice));
    findings.add_all(&written.raster, change_volume(raster, &name.to_string(), cells.iter().chain(&bare), lattice));
    let law = match law {
        OpenedLaw::Share(series) => {
            let lasts = series.points().last().map_or(0.0, |point| point.0);
            let end = written.at.value + lasts;
            if let (true, BedMovement::InPlace(Some(share))) = (end > scenario.end_time, &written.law) {
                let message =
                    format!("the bed still moves when the run ends at {} s: it ends at {end} s", scenario.end_time);
                let problem = Problem::warning(ProblemKind::Scenario, "moves-at-end", "", message);
                findings.add(&share.file, problem.with_remedy("let the run last longer, if the final bed matters"));
            }
            BedLaw::Share(series)
        }
        _ => BedLaw::AtOnce,
    };
    Some(BedMotion { begin: written.at.value, cells, law })
}

/// What of the change of a raster lies beside the model, where it is a part worth a word.
fn change_outside(raster: &Raster, name: &str, lattice: &Lattice) -> Option<Problem> {
    let place = |index: usize| raster.centre(index % raster.columns, index / raster.columns);
    let changed = (0..raster.values.len()).filter(|&index| raster.values[index].abs() > NO_CHANGE);
    let is_beside = |index: &usize| lattice.cell_at(lattice.to_local(place(*index))).is_none();
    let volume = |index: &usize| raster.values[*index].abs() * raster.cell_x * raster.cell_y;
    let (beside, within): (Vec<usize>, Vec<usize>) = changed.partition(is_beside);
    let [lost, kept] = [&beside, &within].map(|cells| cells.iter().map(volume).sum::<f64>());
    let largest = beside.iter().copied().max_by(|a, b| volume(a).total_cmp(&volume(b)))?;
    (lost > OTHER_VOLUME * (lost + kept)).then(|| {
        let area = beside.len() as f64 * raster.cell_x * raster.cell_y;
        let message = format!(
            "{:.0} % of the volume that {name} moves, on {area} m², lie outside the terrain",
            100.0 * lost / (lost + kept)
        );
        Problem::warning(ProblemKind::Input, "moves-without-terrain", "", message)
            .with_cause("the model ends before the bed stops to move, and the waves from beyond do not come in")
            .with_remedy("nothing, if they do not matter; otherwise give a terrain that holds all of it")
            .with_at(place(largest))
    })
}

/// What the lattice makes of the volumes that a raster raises and lowers, where that is another volume.
fn change_volume<'a>(
    raster: &Raster,
    name: &str,
    cells: impl Iterator<Item = &'a (usize, f64)>,
    lattice: &Lattice,
) -> Option<Problem> {
    // Coarser cells the lattice knows by several places each.
    if raster.cell_x.min(raster.cell_y) >= 2.0 * lattice.spacing {
        return None;
    }
    let add = |sums: [f64; 2], volume: f64| [sums[0] + volume.max(0.0), sums[1] - volume.min(0.0)];
    let on_lattice = cells.map(|(_, change)| change * lattice.cell_area()).fold([0.0; 2], add);
    let (width, height) = (lattice.columns as f64 * lattice.spacing, lattice.rows as f64 * lattice.spacing);
    // What lies beside the lattice changes nothing there, and is not missed.
    let volume = |index: usize| {
        let centre = lattice.to_local(raster.centre(index % raster.columns, index / raster.columns));
        let within = |middle: f64, cell: f64, size: f64| {
            ((middle + 0.5 * cell).min(size) - (middle - 0.5 * cell).max(0.0)).max(0.0)
        };
        let area = within(centre.x, raster.cell_x, width) * within(centre.y, raster.cell_y, height);
        raster.values[index] * area
    };
    let changed = (0..raster.values.len()).filter(|&index| raster.values[index].abs() > NO_CHANGE);
    let wanted = changed.map(volume).fold([0.0; 2], add);
    let misfit = (on_lattice[0] - wanted[0]).abs() + (on_lattice[1] - wanted[1]).abs();
    (misfit > OTHER_VOLUME * (wanted[0] + wanted[1])).then(|| {
        let message = format!(
            "on the lattice {name} raises {:.4e} m³ and lowers {:.4e} m³; in the file it is {:.4e} m³ and {:.4e} m³",
            on_lattice[0], on_lattice[1], wanted[0], wanted[1]
        );
        let largest =
            (0..raster.values.len()).max_by(|a, b| raster.values[*a].abs().total_cmp(&raster.values[*b].abs()));
        let problem = Problem::warning(ProblemKind::Input, "change-volume", "", message)
            .with_cause("it is finer than the resolution: each cell takes the change at its centre")
            .with_remedy("take a finer `resolution`, or a raster of the means over its cells");
        match largest {
            Some(index) => problem.with_at(raster.centre(index % raster.columns, index / raster.columns)),
            None => problem,
        }
    })
}
