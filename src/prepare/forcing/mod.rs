//! Boundaries with a condition, rain and cross-sections: their files, and where they lie on the terrain.

mod boundaries;
pub mod breach;
pub mod channels;
pub mod levels;
pub mod moving_bed;
pub mod plausible;
mod rain;
mod sections;
pub mod sources;
pub mod waves;

use crate::bed::BedParticles;
use crate::boundary::{Condition, Forcing};
use crate::error::{Problem, ProblemKind};
use crate::geodata::Crs;
use crate::output::Section;
use crate::prepare::findings::Findings;
use crate::prepare::grid::REACH;
use crate::prepare::places;
use crate::prepare::series_rows;
use crate::prepare::tables::dates::Origin;
use crate::prepare::tables::rows::{self, Meaning};
use crate::prepare::tables::series;
use crate::scenario::units::LENGTH;
use crate::scenario::{BoundaryCondition, OpenBoundary, Scenario};
use boundaries::OpenedBoundary;
use plausible::Placed;
use rain::OpenedRain;
pub use sections::pieces_of;

const LEVEL: Meaning = Meaning { dimension: &LENGTH, negative: None };

/// Everything that could be opened; map coordinates.
#[derive(Debug, Default)]
pub struct Opened {
    boundaries: Vec<OpenedBoundary>,
    sources: Vec<sources::Opened>,
    rain: Option<OpenedRain>,
    /// The boundaries that have a condition and open something, once they are on the lattice.
    pub placed: Vec<Placed>,
    /// The cross-sections.
    pub sections: Vec<Section>,
}

impl Opened {
    /// How many points and lines each source has.
    pub fn source_counts(&self) -> Vec<(usize, usize)> {
        self.sources.iter().map(|(places, _)| places.count()).collect()
    }
}

/// Opens every file of boundaries, sources, rain and sections.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Opened {
    let is_rough = !scenario.roughness.is_none();
    let boundaries = scenario.boundaries.iter().map(|boundary| {
        let lines = match &boundary.value.place {
            OpenBoundary::Side(_) => None,
            OpenBoundary::Lines(source) => places::pieces(source, crs, scenario, findings),
        };
        (lines, condition(&boundary.value.condition, is_rough, scenario, findings))
    });
    let boundaries = boundaries.collect();
    let sources = sources::open(scenario, crs, findings);
    let rain = scenario.rain.as_ref().and_then(|rain| rain::open(rain, scenario, crs, findings));
    let sections = scenario
        .outputs
        .sections
        .as_ref()
        .and_then(|source| Some((source, places::features(source, crs, findings)?)))
        .map_or_else(Vec::new, |(source, features)| sections::sections(source, &features, findings));
    if let Some(source) = &scenario.outputs.sections {
        series_rows::check(source, sections.len(), scenario, findings);
    }
    Opened { boundaries, sources, rain, placed: Vec::new(), sections }
}

/// A condition with its series; with whether there is roughness where it holds.
pub fn condition(
    condition: &BoundaryCondition,
    is_rough: bool,
    scenario: &Scenario,
    findings: &mut Findings,
) -> Option<Condition> {
    let span = (scenario.end_time, Origin::of_run(scenario));
    Some(match condition {
        BoundaryCondition::Free => Condition::Free,
        BoundaryCondition::Stage(level) => Condition::Stage(series::series(level, LEVEL, span, findings)?),
        BoundaryCondition::Level(level) => Condition::Level(series::series(level, LEVEL, span, findings)?),
        BoundaryCondition::Wave { level, still } => {
            let level = series::series(level, LEVEL, span, findings);
            let still = still.as_ref().map(|still| series::series(still, LEVEL, span, findings));
            Condition::Wave { level: level?, still: if let Some(still) = still { Some(still?) } else { None } }
        }
        BoundaryCondition::Rating(table) => Condition::Rating(series::rating(table, findings)?),
        BoundaryCondition::Discharge { discharge, level } => {
            let discharge = series::series(discharge, rows::COMING, span, findings);
            let level = level.as_ref().map(|level| series::series(level, LEVEL, span, findings));
            Condition::Discharge {
                discharge: discharge?,
                level: if let Some(level) = level { Some(level?) } else { None },
            }
        }
        BoundaryCondition::NormalDepth(slope) => {
            if !is_rough {
                let message = "without roughness there is no uniform flow, and no normal depth";
                let problem = Problem::error(ProblemKind::Scenario, "no-roughness", "", message);
                let remedy = "give `manning` a value above 0, or take `type: free`";
                findings.add(slope, problem.with_remedy(remedy));
                return None;
            }
            Condition::NormalDepth { slope: slope.value }
        }
    })
}

/// Puts everything on the lattice and checks where it lies.
pub fn on_lattice(opened: &mut Opened, scenario: &Scenario, ground: &BedParticles, findings: &mut Findings) -> Forcing {
    let lattice = &ground.lattice;
    let mut forcing = Forcing { reach: REACH * lattice.spacing, ..Forcing::default() };
    opened.placed = boundaries::on_lattice(&opened.boundaries, scenario, ground, &mut forcing, findings);
    sources::on_lattice(&opened.sources, scenario, ground, &mut forcing, findings);
    forcing.rain = scenario
        .rain
        .as_ref()
        .and_then(|source| rain::on_lattice(opened.rain.take()?, source, scenario, ground, findings));
    if let Some(source) = &scenario.outputs.sections {
        for section in &opened.sections {
            sections::check_section(section, source, ground, findings);
            forcing.sections.push(pieces_of(section, lattice));
        }
    }
    forcing
}
