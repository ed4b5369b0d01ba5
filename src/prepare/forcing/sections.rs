//! Cross-sections: their file, and whether water can pass each of them.

use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error};
use crate::lattice::Lattice;
use crate::math::{Vec2, readable, segments_cross};
use crate::output::Section;
use crate::prepare::findings::Findings;
use crate::prepare::ground::burn::crossed;
use crate::prepare::outside::{IN_PART, Outside};
use crate::prepare::places;
use crate::scenario::{Sourced, VectorSource};
use crate::vector::Feature;

/// The cross-sections of a file: each of its lines is one.
pub fn sections(source: &Sourced<VectorSource>, features: &[Feature], findings: &mut Findings) -> Vec<Section> {
    let mut found: Vec<Section> = Vec::new();
    let path = source.value.path.display();
    let has_line = |feature: &Feature| feature.lines.iter().any(places::has_length);
    findings.add_all(source, places::left_out(source, features, "line", has_line));
    for feature in features {
        let named = feature.attribute("id").or_else(|| feature.attribute("name"));
        let id = named.map_or_else(|| feature.number.to_string(), ToString::to_string);
        for (number, line) in feature.lines.iter().enumerate() {
            let id = if feature.lines.len() > 1 { format!("{id}.{}", number + 1) } else { id.clone() };
            let mut places: Vec<Vec2> = line.0.iter().map(|c| Vec2::new(c.x, c.y)).collect();
            places.dedup();
            if places.len() < 2 {
                continue;
            }
            if found.iter().any(|earlier| earlier.id == id) {
                let problem = input_error("duplicate-section", format!("{path} holds more than one section `{id}`"));
                findings.add(source, problem.with_remedy("give each section its own id").with_at(places[0]));
            }
            found.push(Section { id, line: places });
        }
    }
    if found.is_empty() {
        let problem = input_error("no-lines", format!("{path} holds no line"));
        findings.add(source, problem.with_remedy("draw lines from the left to the right bank; or take the key away"));
    }
    found
}

/// The straight pieces of a section in local coordinates (m).
pub fn pieces_of(section: &Section, lattice: &Lattice) -> Vec<[Vec2; 2]> {
    section.line.windows(2).map(|pair| [lattice.to_local(pair[0]), lattice.to_local(pair[1])]).collect()
}

/// Refuses a section that lies on no cell of the terrain, and warns of one that lies beside it in part. A blocked building is no terrain, and
/// a section that runs into one is reported.
pub fn check_section(
    section: &Section,
    source: &Sourced<VectorSource>,
    ground: &BedParticles,
    findings: &mut Findings,
) {
    let lattice = &ground.lattice;
    let pieces = pieces_of(section, lattice);
    let is_on_terrain = |place: Vec2| lattice.cell_of(place).is_some_and(|cell| ground.has_terrain(cell));
    let is_built_over =
        |place: Vec2| lattice.cell_of(place).is_some_and(|cell| ground.sealed.binary_search(&cell).is_ok());
    let outside = Outside::of(pieces.iter().copied(), lattice, |place| is_on_terrain(place) || is_built_over(place));
    let is_nowhere_open = Outside::of(pieces.iter().copied(), lattice, is_on_terrain).is_all();
    if let Some((length, place)) = outside.part(lattice.spacing).filter(|_| !is_nowhere_open) {
        let message = format!("{length:.0} m of the section `{}` lie on no terrain", section.id);
        let problem = Problem::warning(ProblemKind::Input, "section-outside", "", message)
            .with_cause("nothing is measured there")
            .with_remedy(IN_PART)
            .with_at(place);
        findings.add(source, problem);
    }
    if is_nowhere_open {
        let (lies, remedy) = if outside.is_all() {
            ("lies on no terrain", "check that the file and the terrain have the same CRS")
        } else {
            ("lies in a blocked building", "draw it where water can pass")
        };
        let problem = input_error("section-outside", format!("the section `{}` {lies}", section.id))
            .with_remedy(remedy)
            .with_at(section.line[0]);
        findings.add(source, problem);
    } else if section.line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>() < 2.0 * lattice.spacing {
        let message = format!("the section `{}` is shorter than two cells", section.id);
        let problem = Problem::warning(ProblemKind::Input, "section-short", "", message)
            .with_cause("it may pass between two particles and measure nothing")
            .with_remedy("draw it from bank to bank, or choose a finer `resolution`")
            .with_at(section.line[0]);
        findings.add(source, problem);
    } else if !parts_cells(&pieces, ground) {
        let message =
            format!("the section `{}` parts no two cells of the terrain, and nothing would pass it", section.id);
        let problem = input_error("section-on-edge", message)
            .with_cause("it lies along the edge of the terrain; what passes that stands in `tables/boundaries.csv`")
            .with_remedy(format!("draw it inside the terrain, at least {} m from its edge", readable(lattice.spacing)))
            .with_at(section.line[0]);
        findings.add(source, problem);
    }
}

/// Whether some of the pieces of a line (local coordinates, m) cross the way between two cells with terrain.
fn parts_cells(pieces: &[[Vec2; 2]], ground: &BedParticles) -> bool {
    let lattice = &ground.lattice;
    let mut ways = pieces.iter().flat_map(|piece| {
        let steps = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
        let from = crossed(piece, lattice).into_iter().filter(|cell| ground.has_terrain(*cell));
        from.flat_map(move |cell| steps.map(|(x, y)| (piece, lattice.centre(cell), Vec2::new(x, y) * lattice.spacing)))
    });
    ways.any(|(piece, centre, step)| {
        let other = lattice.cell_at(centre + step);
        other.is_some_and(|other| ground.has_terrain(other)) && segments_cross([centre, centre + step], *piece)
    })
}
