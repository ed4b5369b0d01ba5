//! What is carried with the water: the polygons of water that is marked at the start, and which of the water that comes in has it.

use geo::{CoordsIter, MultiPolygon};

use crate::bed::BedParticles;
use crate::boundary::Tracer;
use crate::error::{Problem, input_error};
use crate::geodata::Crs;
use crate::math::Vec2;
use crate::prepare::findings::Findings;
use crate::prepare::polygons::cells_inside;
use crate::prepare::water;
use crate::scenario::{Scenario, Tracer as Written, TracerPlace};
use crate::seeding::StillWater;

/// Of each tracer and each of its entries the polygons (map coordinates), where it has some that could be opened.
pub type Opened = Vec<Vec<Option<MultiPolygon<f64>>>>;

/// Opens the files of marked water.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Opened {
    let mut area = |place: &TracerPlace| match place {
        TracerPlace::Water(polygons) => water::area(polygons, crs, findings),
        _ => None,
    };
    scenario.tracers.iter().map(|tracer| tracer.from.iter().map(|from| area(&from.place)).collect()).collect()
}

/// The tracers on the lattice, given how many points and lines each source has.
pub fn on_lattice(
    opened: &Opened,
    scenario: &Scenario,
    (bed, still): (&BedParticles, &StillWater),
    sources: &[(usize, usize)],
    findings: &mut Findings,
) -> Vec<Tracer> {
    let tracers = scenario.tracers.iter().zip(opened);
    tracers.map(|(tracer, areas)| one(tracer, areas, scenario, (bed, still), sources, findings)).collect()
}

fn one(
    tracer: &Written,
    areas: &[Option<MultiPolygon<f64>>],
    scenario: &Scenario,
    (bed, still): (&BedParticles, &StillWater),
    sources: &[(usize, usize)],
    findings: &mut Findings,
) -> Tracer {
    let mut made = Tracer {
        boundaries: vec![0.0; scenario.boundaries.len()],
        sources: vec![0.0; sources.iter().map(|(points, _)| points).sum()],
        line_sources: vec![0.0; sources.iter().map(|(_, lines)| lines).sum()],
        decay: tracer.half_life.map_or(0.0, |half_life| std::f64::consts::LN_2 / half_life),
        ..Tracer::default()
    };
    for (from, area) in tracer.from.iter().zip(areas) {
        match &from.place {
            TracerPlace::Water(polygons) => {
                let Some(area) = area else { continue };
                let cells = cells_inside(area, &bed.lattice);
                let wet: Vec<usize> = cells.into_iter().filter(|&cell| still.depth[cell] > 0.0).collect();
                if wet.is_empty() {
                    let problem = marks_no_water(&polygons.value.path.display().to_string());
                    let corner = area.coords_iter().next().map(|corner| Vec2::new(corner.x, corner.y));
                    findings.add(polygons, Problem { at: corner, ..problem });
                    continue;
                }
                made.initial.resize(bed.lattice.len(), 0.0);
                wet.into_iter().for_each(|cell| made.initial[cell] = from.concentration);
            }
            TracerPlace::Boundary(entry) => {
                let known = scenario.boundary_of_entry(*entry);
                known.into_iter().for_each(|which| made.boundaries[which] = from.concentration);
            }
            TracerPlace::Source(entry) => {
                let before = &sources[..*entry];
                let (points, lines) = sources[*entry];
                let first = before.iter().fold((0, 0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
                made.sources[first.0..first.0 + points].fill(from.concentration);
                made.line_sources[first.1..first.1 + lines].fill(from.concentration);
            }
            TracerPlace::Rain => made.rain = from.concentration,
        }
    }
    made
}

fn marks_no_water(name: &str) -> Problem {
    input_error("marks-no-water", format!("no cell with water at the start lies in what {name} draws"))
        .with_remedy("draw it over water of `initial`, in the same reference system; water that comes later is marked by `boundary`, `source` or `rain`")
}
