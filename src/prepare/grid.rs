//! The lattice of a run: where it lies, what it costs, and which of its edges are open.

use std::ops::Range;

use rayon::prelude::*;

use crate::boundary::{EdgeFace, Holes, Pieces};
use crate::error::{Problem, ProblemKind};
use crate::lattice::Lattice;
use crate::math::{Rectangle, Vec2, in_bytes, readable};
use crate::prepare::GapReport;
use crate::prepare::findings::Findings;
use crate::prepare::ground::gaps;
use crate::scenario::{Limits, Part, Side};
use crate::solver::OpenEdges;
use crate::terrain::{Layer, Terrain};

/// Memory (bytes) that a cell takes in the whole run, at most: riverbed 32, water and its rates about 200, maps and frames about 150.
pub const BYTES_PER_CELL: f64 = 400.0;
/// Memory (bytes) that a cell of the lattice takes beside that where cells move: the partition with what passes its faces, by what the allocator is
/// asked for (`tests/allocations`).
pub const BYTES_PER_MOVING_CELL: f64 = 900.0;
/// Memory (bytes) that a particle of the variational formulation takes: state, rates, neighbours and their sorted copy.
pub const BYTES_PER_FLUID_PARTICLE: f64 = 300.0;
/// Memory (bytes) that the program takes with its libraries and the smallest scene.
pub const BYTES_OF_PROGRAM: f64 = 85e6;
/// Memory (bytes) that a sample of a gauge takes, at most: its list is copied as it grows.
pub const BYTES_PER_SAMPLE: f64 = 112.0;
/// A terrain of fewer cells than this on a side has no flow in it.
const LEAST_CELLS: f64 = 3.0;
/// Share of a cell by which sums of map coordinates may miss a whole number of cells.
const ROUND_OFF: f64 = 1e-6;

/// The lattice that covers the data of a terrain, refused before anything is allocated when it is too large or too coarse.
///
/// Its cells count from the south-western corner of the first raster, so that they coincide with raster cells when one
/// spacing is a whole multiple of the other; without a raster they count from zero. Those of a part of the terrain count from its corner.
///
/// # Errors
/// The problem, without key and place.
pub(super) fn lattice(
    terrain: &Terrain,
    part: Option<Part>,
    spacing: f64,
    limits: &Limits,
) -> Result<Lattice, Problem> {
    let anchor = terrain.layers().iter().find_map(|layer| match layer {
        Layer::Raster(raster) => Some(Vec2::new(raster.west, raster.south())),
        Layer::Survey(_) => None,
    });
    let anchor = part.map(|part| part.own.low).or(anchor).unwrap_or(Vec2::ZERO);
    let Rectangle { low: min, high: max } = part.map_or_else(|| terrain.extent(), |part| part.own);
    let first = |low: f64, anchor: f64| ((low - anchor) / spacing + ROUND_OFF).floor();
    let last = |high: f64, anchor: f64| ((high - anchor) / spacing - ROUND_OFF).ceil();
    let (west, south) = (first(min.x, anchor.x), first(min.y, anchor.y));
    let (columns, rows) = (last(max.x, anchor.x) - west, last(max.y, anchor.y) - south);
    if (max.x - min.x).min(max.y - min.y) < LEAST_CELLS * spacing {
        let message = format!(
            "the resolution of {spacing} m is too coarse for a terrain of {:.0} m by {:.0} m",
            max.x - min.x,
            max.y - min.y
        );
        let fitting = 0.01 * (max.x - min.x).min(max.y - min.y);
        return Err(Problem::error(ProblemKind::Scenario, "resolution-too-coarse", "", message)
            .with_remedy(format!("choose at most a hundredth of its width, {fitting:.3} m")));
    }
    let cells = columns * rows;
    let memory = BYTES_OF_PROGRAM + cells * BYTES_PER_CELL;
    if !cells.is_finite() || cells >= f64::from(u32::MAX) || memory > limits.memory {
        let message = format!(
            "{columns:.0} by {rows:.0} cells of {spacing} m need about {} of memory; the limit is {}",
            in_bytes(memory),
            in_bytes(limits.memory)
        );
        return Err(Problem::error(ProblemKind::Limit, "memory-limit", "", message)
            .with_remedy(for_memory(memory, spacing, limits)));
    }
    let origin = Vec2::new(anchor.x + west * spacing, anchor.y + south * spacing);
    Ok(Lattice::new(origin, columns as usize, rows as usize, spacing))
}

/// The remedy when a need exceeds its limit by a factor: particles go with the square of the resolution.
fn coarser(spacing: f64, excess: f64, limit: &str) -> String {
    let fitting = spacing * excess.sqrt();
    let digits = 10f64.powf(fitting.log10().floor() - 1.0);
    format!(
        "take a resolution of {} m or more, cut the terrain to the valley, or raise `{limit}`",
        readable((fitting / digits).ceil() * digits)
    )
}

/// Refuses more particles than the limit allows.
pub(super) fn check_particles([bed, fluid, in_channels]: [usize; 3], spacing: f64, limits: &Limits) -> Option<Problem> {
    let particles = (bed + fluid + in_channels) as f64;
    (particles > limits.particles).then(|| {
        let of_channels =
            if in_channels > 0 { format!(" with {in_channels} strips of channels") } else { String::new() };
        let message = format!(
            "{bed} riverbed and about {fluid} fluid particles{of_channels} exceed the limit of {:.0}",
            limits.particles
        );
        Problem::error(ProblemKind::Limit, "particle-limit", "", message).with_remedy(coarser(
            spacing,
            particles / limits.particles,
            "limits.particles",
        ))
    })
}

/// The remedy of a run that needs more memory (bytes) than its limit.
pub(super) fn for_memory(memory: f64, spacing: f64, limits: &Limits) -> String {
    let for_cells = limits.memory - BYTES_OF_PROGRAM;
    if for_cells > 0.0 {
        coarser(spacing, (memory - BYTES_OF_PROGRAM) / for_cells, "limits.memory")
    } else {
        format!("raise `limits.memory`: the program alone takes {}", in_bytes(BYTES_OF_PROGRAM))
    }
}

/// How far riverbed particles lie from the survey points that they come from; none where no survey is used.
pub(super) fn gap_report(terrain: &Terrain, lattice: &Lattice) -> Option<GapReport> {
    if terrain.layers().iter().all(|layer| matches!(layer, Layer::Raster(_))) {
        return None;
    }
    let at = |index| {
        let place = lattice.to_map(lattice.centre(index));
        Some((terrain.gap(place)?, place))
    };
    let mut gaps: Vec<(f64, Vec2)> = (0..lattice.len()).into_par_iter().filter_map(at).collect();
    gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
    let &(largest, place) = gaps.last()?;
    Some(GapReport {
        largest,
        place,
        percentile_95: gaps[(gaps.len() - 1) * 95 / 100].0,
        median: gaps[gaps.len() / 2].0,
    })
}

/// Distance (in cells) from a line within which it opens an edge face: lines are drawn along the edge of the data, and
/// the lattice follows that edge in steps.
pub(super) const REACH: f64 = 1.5;

/// An edge within so many cells of a side may be meant with it.
const NEAR: usize = 10;

/// Adds a side of the terrain to the open edges: the chain of faces that one sees first from there, as far as it goes from line to line of
/// cells in steps of one cell at most. It may be oblique, as the edge of a raster that was turned by its reprojection.
///
/// A chain counts where it comes within a cell of the rectangle around the terrain. It stops short of its ends by a little more than
/// the reach, so that it does not open the faces around the corner: the banks of a valley that is narrower than the rectangle where it
/// meets the side stay walls. (Those of a mouth of one or two cells do not.)
///
/// Returns where (local coordinates, m) the edge stays a wall although it lies within some cells of the rectangle, and how many lines of
/// cells were opened.
pub(super) fn open_side(open: &mut OpenEdges, side: Side, lattice: &Lattice, bed: &[f64]) -> (Vec<Vec2>, usize) {
    if side == Side::All {
        open.outline = Some(holes(lattice, bed));
        return (Vec::new(), 0);
    }
    let (columns, rows) = (lattice.columns, lattice.rows);
    // A line of cells goes inwards from the side: columns from the north and the south, rows from the east and the west.
    let is_column = matches!(side, Side::North | Side::South);
    let (lines, depths) = if is_column { (columns, rows) } else { (rows, columns) };
    let cell = |line: usize, depth: usize| match side {
        Side::North => lattice.index(line, rows - 1 - depth),
        Side::South => lattice.index(line, depth),
        Side::East => lattice.index(columns - 1 - depth, line),
        Side::West | Side::All => lattice.index(depth, line),
    };
    let outwards = match side {
        Side::North => Vec2::new(0.0, 1.0),
        Side::South => Vec2::new(0.0, -1.0),
        Side::East => Vec2::new(1.0, 0.0),
        Side::West | Side::All => Vec2::new(-1.0, 0.0),
    };
    let first: Vec<Option<usize>> =
        (0..lines).map(|line| (0..depths).find(|&depth| !bed[cell(line, depth)].is_nan())).collect();
    let outermost = first.iter().flatten().min().copied().unwrap_or(0);
    let face = |line: usize| Some(lattice.centre(cell(line, first[line]?)) + outwards * (0.5 * lattice.spacing));
    let (mut passed_over, mut opened) = (Vec::new(), 0);
    for chain in chains(&first) {
        if chain.clone().any(|line| first[line].is_some_and(|depth| depth <= outermost + 1)) {
            let faces: Vec<Vec2> = chain.filter_map(face).collect();
            opened += faces.len();
            open.pieces.extend(through(&faces));
        } else {
            passed_over.extend(
                chain.filter(|&line| first[line].is_some_and(|depth| depth <= outermost + NEAR)).filter_map(face),
            );
        }
    }
    (passed_over, opened)
}

/// The holes of a bed (m, not-a-number without terrain).
fn holes(lattice: &Lattice, bed: &[f64]) -> Holes {
    let mut cells = gaps::holes(lattice, |cell| bed[cell].is_nan()).concat();
    cells.sort_unstable();
    Holes { lattice: lattice.clone(), cells }
}

/// Runs of lines of cells whose first terrain steps by one cell at most from each to the next.
fn chains(first: &[Option<usize>]) -> Vec<Range<usize>> {
    let mut chains: Vec<Range<usize>> = Vec::new();
    for line in (0..first.len()).filter(|&line| first[line].is_some()) {
        let follows = |before: &Range<usize>| {
            before.end == line && first[line - 1].zip(first[line]).is_some_and(|(a, b)| a.abs_diff(b) <= 1)
        };
        match chains.last_mut() {
            Some(chain) if follows(chain) => chain.end += 1,
            _ => chains.push(line..line + 1),
        }
    }
    chains
}

/// Pieces through the midpoints of the faces of a chain. Straight runs are one piece.
fn through(faces: &[Vec2]) -> Vec<[Vec2; 2]> {
    if let [face] = faces {
        return vec![[*face; 2]];
    }
    let mut pieces: Vec<[Vec2; 2]> = Vec::new();
    for pair in faces.windows(2) {
        let is_straight = |piece: &[Vec2; 2]| {
            let (a, b) = (piece[1] - piece[0], pair[1] - pair[0]);
            (a.x * b.y - a.y * b.x).abs() < 1e-9 * a.norm() * b.norm()
        };
        match pieces.last_mut() {
            Some(piece) if is_straight(piece) => piece[1] = pair[1],
            _ => pieces.push([pair[0], pair[1]]),
        }
    }
    pieces
}

/// The edge faces that lines open, by their places in a list, in ascending order. A line
/// between the midpoints of two faces opens the nearer one, whose midpoint joins the pieces.
pub(super) fn faces_opened(pieces: &mut Pieces, edges: &[EdgeFace], lattice: &Lattice) -> Vec<usize> {
    let reach = REACH * lattice.spacing;
    let face = |index: usize| (edges[index].middle, edges[index].middle - lattice.centre(edges[index].cell));
    let is_open = |&index: &usize| pieces.distance_to_face(reach, face(index)).is_some();
    let open: Vec<usize> = (0..edges.len()).into_par_iter().filter(is_open).collect();
    if !open.is_empty() {
        return open;
    }
    let distance = |index: usize| Some((pieces.distance_beyond_ends(reach, face(index))?, index));
    let nearest = (0..edges.len()).filter_map(distance).min_by(|a, b| a.0.total_cmp(&b.0));
    pieces.extend(nearest.map(|(_, index)| [edges[index].middle; 2]));
    nearest.into_iter().map(|(_, index)| index).collect()
}

/// Refuses cells of the maps (m) that are wider than the terrain: its water would not be on them.
pub(super) fn check_map_cells(cell: f64, lattice: &Lattice, findings: &mut Findings) {
    let size = lattice.size();
    if cell > size.x.max(size.y) {
        let message = format!("map cells of {cell} m are wider than the terrain of {:.0} m by {:.0} m", size.x, size.y);
        let problem = Problem::error(ProblemKind::Scenario, "resolution-too-coarse", "", message);
        findings.add_at(
            "outputs.cell",
            None,
            problem.with_remedy("correct the length and its unit, or leave `cell` out"),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::edge_faces;
    use crate::terrain::Raster;

    fn terrain(cell: f64, columns: usize, rows: usize) -> Terrain {
        let raster = Raster {
            columns,
            rows,
            west: 1005.0,
            north: 2003.0,
            cell_x: cell,
            cell_y: cell,
            values: vec![1.0; columns * rows],
        };
        Terrain::new(vec![Layer::Raster(raster)]).unwrap()
    }

    const LIMITS: Limits = Limits { memory: 1e9, disk: None, particles: 1e6, checkpoint: None, allow_remote: false };

    #[test]
    fn cells_coincide_with_raster_cells_when_spacings_divide() {
        let terrain = terrain(20.0, 30, 20);
        let equal = lattice(&terrain, None, 20.0, &LIMITS).unwrap();
        assert_eq!(equal, Lattice::new(Vec2::new(1005.0, 1603.0), 30, 20, 20.0));
        let half = lattice(&terrain, None, 10.0, &LIMITS).unwrap();
        assert_eq!((half.origin, half.columns, half.rows), (equal.origin, 60, 40));
        let double = lattice(&terrain, None, 40.0, &LIMITS).unwrap();
        assert_eq!((double.origin, double.columns, double.rows), (equal.origin, 15, 10));
        let odd = lattice(&terrain, None, 7.0, &LIMITS).unwrap();
        assert_eq!((odd.origin, odd.columns, odd.rows), (equal.origin, 86, 58));
    }

    #[test]
    fn too_many_and_too_few_cells_are_refused_before_allocation() {
        let terrain = terrain(20.0, 3000, 2000);
        let problem = lattice(&terrain, None, 1e-3, &LIMITS).unwrap_err();
        assert_eq!((problem.kind, problem.code), (ProblemKind::Limit, "memory-limit"));
        // 60 km by 40 km in 400 bytes a cell fit beside the program into 1 GB at 32.4 m.
        assert!(problem.remedy.unwrap().contains("33 m or more"), "the remedy names a resolution that fits");
        assert_eq!(lattice(&terrain, None, 20_000.0, &LIMITS).unwrap_err().code, "resolution-too-coarse");
        assert_eq!(check_particles([900_000, 200_000, 0], 20.0, &LIMITS).unwrap().kind, ProblemKind::Limit);
        assert_eq!(check_particles([900_000, 100_000, 0], 20.0, &LIMITS), None);
        let with_channels = check_particles([900_000, 100_000, 1], 20.0, &LIMITS).unwrap();
        assert!(with_channels.message.contains("with 1 strips of channels"), "{with_channels}");
    }

    #[test]
    fn a_side_opens_its_own_faces_and_no_other() {
        let lattice = Lattice::new(Vec2::ZERO, 12, 9, 5.0);
        let bed = vec![0.0; lattice.len()];
        for (side, faces) in [(Side::North, 12), (Side::South, 12), (Side::East, 9), (Side::West, 9)] {
            let mut open = OpenEdges::default();
            open_side(&mut open, side, &lattice, &bed);
            assert_eq!(faces_opened(&mut open.pieces, &edge_faces(&lattice, &bed), &lattice).len(), faces, "{side:?}");
        }
        // The terrain ends within the last row and the last column: nothing around the corner opens.
        let within = |cell: usize| lattice.column_row(cell).0 < 11 && lattice.column_row(cell).1 < 8;
        let bed: Vec<f64> = (0..lattice.len()).map(|cell| if within(cell) { 0.0 } else { f64::NAN }).collect();
        for (side, faces) in [(Side::North, 11), (Side::South, 11), (Side::East, 8), (Side::West, 8)] {
            let mut open = OpenEdges::default();
            open_side(&mut open, side, &lattice, &bed);
            assert_eq!(faces_opened(&mut open.pieces, &edge_faces(&lattice, &bed), &lattice).len(), faces, "{side:?}");
        }
    }

    #[test]
    fn a_line_opens_as_many_faces_as_it_is_long_and_one_at_least() {
        let lattice = Lattice::new(Vec2::ZERO, 12, 20, 5.0);
        let edges = edge_faces(&lattice, &vec![0.0; lattice.len()]);
        // Drawn 3 m beside the edge.
        let opened = |from: f64, to: f64| {
            let mut pieces = Pieces::from(vec![[Vec2::new(-3.0, from), Vec2::new(-3.0, to)]]);
            let open = faces_opened(&mut pieces, &edges, &lattice);
            assert_eq!(faces_opened(&mut pieces, &edges, &lattice), open, "the pieces say the same");
            open.iter().map(|&index| edges[index].middle.y).collect::<Vec<_>>()
        };
        assert_eq!(opened(40.0, 60.0), [42.5, 47.5, 52.5, 57.5]);
        assert_eq!(opened(41.0, 52.5), [42.5, 47.5, 52.5]);
        // Between two midpoints.
        assert_eq!(opened(43.0, 46.0), [42.5]);
        assert_eq!(opened(43.0, 47.4), [47.5]);
    }

    #[test]
    fn a_valley_that_narrows_opens_at_its_mouth_and_not_at_its_banks() {
        // Twelve columns; the last five are a valley of four rows.
        let lattice = Lattice::new(Vec2::ZERO, 12, 9, 5.0);
        let is_valley = |(column, row): (usize, usize)| column < 7 || (3..7).contains(&row);
        let bed: Vec<f64> =
            (0..lattice.len()).map(|cell| if is_valley(lattice.column_row(cell)) { 0.0 } else { f64::NAN }).collect();
        let (passed_over, opened) = open_side(&mut OpenEdges::default(), Side::East, &lattice, &bed);
        assert_eq!((passed_over.len(), opened), (5, 4));
        assert_eq!(passed_over[0], Vec2::new(35.0, 2.5));
        for (side, faces) in [(Side::East, 4), (Side::West, 9), (Side::North, 7), (Side::South, 7)] {
            let mut open = OpenEdges::default();
            open_side(&mut open, side, &lattice, &bed);
            assert_eq!(faces_opened(&mut open.pieces, &edge_faces(&lattice, &bed), &lattice).len(), faces, "{side:?}");
        }
    }

    #[test]
    fn a_side_that_is_turned_opens_all_along() {
        // A rectangle of 40 by 24 cells, turned by some degrees about the middle of the lattice.
        let lattice = Lattice::new(Vec2::ZERO, 60, 50, 2.0);
        for degrees in [0.0_f64, 3.0, 10.0, 30.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let is_inside = |cell: usize| {
                let offset = lattice.centre(cell) - Vec2::new(60.0, 50.0);
                let own = Vec2::new(cos * offset.x + sin * offset.y, cos * offset.y - sin * offset.x);
                own.x.abs() < 40.0 && own.y.abs() < 24.0
            };
            let bed: Vec<f64> = (0..lattice.len()).map(|cell| if is_inside(cell) { 0.0 } else { f64::NAN }).collect();
            let mut open = OpenEdges::default();
            open_side(&mut open, Side::South, &lattice, &bed);
            let opened = |across: f64, along: f64| {
                // A place on the outline of the turned rectangle, along its southern or its eastern side.
                let own = Vec2::new(across, along);
                let place = Vec2::new(cos * own.x - sin * own.y, sin * own.x + cos * own.y) + Vec2::new(60.0, 50.0);
                let normal = place - Vec2::new(60.0, 50.0);
                open.pieces.distance_to_face(REACH * lattice.spacing, (place, normal)).is_some()
            };
            let south = (-36..=36).filter(|&x| opened(f64::from(x), -24.0)).count();
            let (east, west) = ((-18..=24).filter(|&y| opened(40.0, f64::from(y))).count(), opened(-40.0, 0.0));
            assert!(south >= 72 && east == 0 && !west, "{degrees}: {south} of 73 in the south, {east} in the east");
        }
    }
}
