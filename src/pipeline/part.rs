//! The part of a large terrain that a run prepares: where water comes in a run on coarse cells, and some beyond.
//!
//! The coarse run sees all of the terrain by the means of its pixels. What it shows is no promise: where the water of the run itself comes near
//! a side at which the terrain goes on, the run begins again on a larger part.

use super::levels::greatest;
use super::scout::Scout;
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, Severity};
use crate::lattice::Lattice;
use crate::math::{Vec2, readable};
use crate::output::PartRecord;
use crate::prepare::{BLOCK, outline, places_of_water, prepare, rectangle_of_fields};
use crate::scenario::methods::Motion;
use crate::scenario::{Part, Reading, Scenario};
use crate::solver::FlowSolver;

/// Up to so many cells all of the terrain is prepared: that takes seconds, and some hundred megabytes.
const WHOLE: f64 = 4e6;
/// Cells of the coarse run, at most.
const COARSE: f64 = 1e6;
/// Pixels across a cell of the coarse run.
const PIXELS: f64 = 2.0;
/// Depth (m) from which a coarse cell counts as reached.
const REACHED: f64 = 1e-3;
/// A part reaches beyond the water by this share of its own length.
const BEYOND: f64 = 0.1;
/// And by so many coarse cells.
const BEYOND_CELLS: f64 = 4.0;
/// The water is near a side of a part within so many of the coarsest cells of the run.
const NEAR: f64 = 8.0;
/// Steps after which that is looked for.
const EVERY: u64 = 4;
/// The share of its length by which a part grows beyond a side that the water came near.
const WIDER: f64 = 0.5;

/// The scenario with the part of its terrain that a run prepares; as it stands where that is all of it.
///
/// # Errors
/// What is wrong where the scene can be prepared neither whole nor on coarse cells, and what lies beside all of the terrain.
pub(super) fn choose(scenario: &Scenario) -> Result<Scenario, Vec<Problem>> {
    let Some(Extent { low, high, spacing }) = extent(scenario) else { return Ok(scenario.clone()) };
    let size = high - low;
    let cells = size.x * size.y / (spacing * spacing);
    let doublings = (0.5 * (cells / COARSE).log2()).ceil() as i32;
    match look(scenario, spacing * f64::from(doublings).exp2())? {
        Some(places) => Ok(with_part(scenario, &places, spacing)),
        None => Ok(scenario.clone()),
    }
}

/// A terrain that is too large to be prepared whole.
struct Extent {
    low: Vec2,
    high: Vec2,
    /// Edge of the finest cells (m).
    spacing: f64,
}

/// The extent of a terrain of which a part may do; none of a small one, and where rain falls anywhere.
fn extent(scenario: &Scenario) -> Option<Extent> {
    if scenario.rain.is_some() || scenario.numerics.motion == Motion::Lagrangian || scenario.reading.part.is_some() {
        return None;
    }
    let (about, pixel) = outline(scenario)?;
    let spacing = if scenario.auto.is_some() { pixel } else { scenario.resolution.value };
    let (low, high) = (about.low, about.high);
    let cells = (high.x - low.x) * (high.y - low.y) / (spacing * spacing);
    (cells.is_finite() && cells > WHOLE).then_some(Extent { low, high, spacing })
}

/// What a run on coarse cells shows.
struct Places {
    /// Their edge (m).
    spacing: f64,
    /// The south-western and the north-eastern corner (map coordinates, m) about all that is wet once, or that the scenario names.
    about: [Vec2; 2],
    /// Those of all terrain.
    whole: [Vec2; 2],
    /// Whether there was a run that showed the water.
    is_sound: bool,
}

/// Looks at all of the terrain on cells of a spacing (m); none where there is no lattice of them.
///
/// What is wrong with the scene on such cells may be right on finer ones, and is checked on them: there is no run then, and the part is that of
/// what the scenario names. What lies beside all of the terrain is refused here, since a part does not show it.
fn look(scenario: &Scenario, spacing: f64) -> Result<Option<Places>, Vec<Problem>> {
    let mut coarse = scenario.with_lengths(spacing, spacing);
    coarse.reading = Reading { part: None, pixel: Some(spacing / PIXELS) };
    coarse.outputs.cell = spacing;
    coarse.outputs.maps_on_terrain = None;
    coarse.start.earlier = None;
    let prepared = prepare(&coarse);
    let is_sound = !prepared.has_errors() && scenario.start.earlier.is_none();
    let Some(setup) = prepared.setup else { return Ok(None) };
    let lattice = &setup.scene.lattice;
    let whole = [lattice.origin, lattice.origin + lattice.size()];
    let is_beside = |place: Vec2| {
        !Part { low: whole[0], high: whole[1], whole_low: whole[0], whole_high: whole[1] }.meets([place; 2])
    };
    let beside = |problem: &Problem| problem.severity == Severity::Error && problem.at.is_some_and(is_beside);
    let beside: Vec<Problem> = prepared.problems.into_iter().filter(beside).collect();
    if !beside.is_empty() {
        return Err(beside);
    }
    let depths =
        if is_sound { greatest(&coarse, &setup, &mut Scout::new(&coarse, &setup.bed)).depth } else { Vec::new() };
    let wet = (0..depths.len()).filter(|&cell| depths[cell] > REACHED).map(|cell| lattice.centre(cell));
    let named = places_of_water(&coarse, &setup).into_iter().chain(wet).map(|place| lattice.to_map(place));
    let earlier = scenario.start.earlier.as_ref().and_then(|earlier| rectangle_of_fields(&earlier.fields.value));
    let places = named.chain(earlier.into_iter().flatten()).filter(|place| !is_beside(*place));
    let about = places.map(|place| [place; 2]).reduce(around).unwrap_or(whole);
    Ok(Some(Places { spacing, about, whole, is_sound }))
}

/// The corners of the rectangle about two.
fn around([low, high]: [Vec2; 2], [other_low, other_high]: [Vec2; 2]) -> [Vec2; 2] {
    let least = Vec2::new(low.x.min(other_low.x), low.y.min(other_low.y));
    [least, Vec2::new(high.x.max(other_high.x), high.y.max(other_high.y))]
}

/// The scenario with the part about some places.
fn with_part(scenario: &Scenario, places: &Places, finest: f64) -> Scenario {
    let [low, high] = places.about;
    let coarsest = scenario.levels.as_ref().map_or(finest, |levels| levels.coarsest.value);
    let share = if places.is_sound { BEYOND } else { WIDER };
    let beyond = |length: f64| share * length + BEYOND_CELLS * places.spacing + 2.0 * NEAR * coarsest;
    let margin = Vec2::new(beyond(high.x - low.x), beyond(high.y - low.y));
    let [whole_low, whole_high] = places.whole;
    let part = Part { low: low - margin, high: high + margin, whole_low, whole_high };
    let mut scenario = scenario.clone();
    scenario.reading.part = Some(on_cells(part, (BLOCK as f64 * finest).max(coarsest)));
    scenario
}

/// The part with its sides on lines between blocks of cells (m) that count from the corner of the terrain, or on a side of that.
fn on_cells(part: Part, block: f64) -> Part {
    let Part { low, high, whole_low, whole_high } = part;
    let down = |place: f64, whole: f64| whole + (((place - whole) / block).floor() * block).max(0.0);
    let up = |place: f64, whole: f64, end: f64| (whole + ((place - whole) / block).ceil() * block).min(end);
    let low = Vec2::new(down(low.x, whole_low.x), down(low.y, whole_low.y));
    let high = Vec2::new(up(high.x, whole_low.x, whole_high.x), up(high.y, whole_low.y, whole_high.y));
    Part { low, high, ..part }
}

/// The places of a part near the sides at which the terrain goes on.
pub(super) struct Sides {
    part: Part,
    /// West, south, east and north.
    cells: [Vec<usize>; 4],
    dry_depth: f64,
    block: f64,
}

impl Sides {
    /// Those of a run; none of one that has all of its terrain.
    pub fn of(scenario: &Scenario, bed: &BedParticles) -> Option<Sides> {
        let part = scenario.reading.part?;
        let lattice = &bed.lattice;
        let coarsest = lattice.levels().map(|level| level.spacing).fold(lattice.spacing, f64::max);
        let Part { low, high, whole_low, whole_high } = part;
        let is_cut = |gap: f64| gap > 0.5 * lattice.spacing;
        let cut = [low.x - whole_low.x, low.y - whole_low.y, whole_high.x - high.x, whole_high.y - high.y].map(is_cut);
        let size = lattice.size();
        let cells = std::array::from_fn(|side| {
            let is_near = |place: Vec2| {
                let to_side = [place.x, place.y, size.x - place.x, size.y - place.y][side];
                cut[side] && to_side < NEAR * coarsest
            };
            let near = near_sides(lattice, NEAR * coarsest).filter(|&cell| is_near(lattice.centre(cell)));
            let mut cells: Vec<usize> = near.collect();
            cells.sort_unstable();
            cells.dedup();
            cells
        });
        let block = (BLOCK as f64 * lattice.spacing).max(coarsest);
        Some(Sides { part, cells, dry_depth: scenario.numerics.dry_depth, block })
    }

    /// A larger part where there is water near one of the sides; it is looked for after every few steps, in each of which a wave goes a cell
    /// at most.
    pub fn beyond(&self, solver: &mut dyn FlowSolver) -> Option<Part> {
        if !solver.steps().is_multiple_of(EVERY) {
            return None;
        }
        let water = solver.water();
        let columns = water.lattice.columns;
        let is_wet = |cell: &usize| water.rows.row(cell / columns).depth[cell % columns] > self.dry_depth;
        let reached = self.cells.each_ref().map(|cells| cells.iter().any(is_wet));
        reached.contains(&true).then(|| self.wider(reached))
    }

    /// The part with more beyond some sides.
    fn wider(&self, [west, south, east, north]: [bool; 4]) -> Part {
        let Part { low, high, .. } = self.part;
        let more = (high - low) * WIDER;
        let if_reached = |reached: bool, length: f64| if reached { length } else { 0.0 };
        let low = low - Vec2::new(if_reached(west, more.x), if_reached(south, more.y));
        let high = high + Vec2::new(if_reached(east, more.x), if_reached(north, more.y));
        on_cells(Part { low, high, ..self.part }, self.block)
    }
}

/// The cells of a lattice that stand for places within a distance (m) of its sides; some may be named several times.
fn near_sides(lattice: &Lattice, distance: f64) -> impl Iterator<Item = usize> + '_ {
    let deep = (distance / lattice.spacing).ceil() as usize;
    let (columns, rows) = (lattice.columns, lattice.rows);
    let is_near = move |place: usize, count: usize| place < deep || place + deep >= count;
    let all = (0..rows).flat_map(move |row| (0..columns).map(move |column| (column, row)));
    let near = all.filter(move |&(column, row)| is_near(column, columns) || is_near(row, rows));
    near.map(|(column, row)| lattice.leaf(column, row))
}

/// The part for the record of the run.
pub(super) fn record(scenario: &Scenario) -> Option<PartRecord> {
    let Part { low, high, whole_low, whole_high } = scenario.reading.part?;
    let size = |low: Vec2, high: Vec2| [high.x - low.x, high.y - low.y];
    Some(PartRecord {
        west: low.x,
        south: low.y,
        east: high.x,
        north: high.y,
        size_m: size(low, high),
        terrain_m: size(whole_low, whole_high),
    })
}

/// What a run reports when it begins again on a larger part.
pub(super) fn larger(part: Part, time: f64) -> Problem {
    let size = part.high - part.low;
    let message = format!(
        "after {} s the water came near the edge of the part of the terrain that was prepared; the run begins again on {:.1} km by {:.1} km",
        readable(time),
        size.x / 1000.0,
        size.y / 1000.0
    );
    Problem::warning(ProblemKind::Scenario, "larger-part", "terrain", message)
        .with_cause("neither the run on coarse cells that goes first nor an earlier run had water there")
        .with_remedy("nothing: its results are those of the larger part")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(low: (f64, f64), high: (f64, f64)) -> Part {
        let at = |(x, y): (f64, f64)| Vec2::new(x, y);
        Part { low: at(low), high: at(high), whole_low: at((100.0, 200.0)), whole_high: at((1097.0, 1195.0)) }
    }

    #[test]
    fn the_sides_of_a_part_lie_between_blocks_or_on_those_of_the_terrain() {
        let inside = on_cells(part((333.0, 444.0), (555.0, 666.0)), 32.0);
        assert_eq!((inside.low, inside.high), (Vec2::new(324.0, 424.0), Vec2::new(580.0, 680.0)));
        let beyond = on_cells(part((-1e3, 444.0), (1e4, 1e4)), 32.0);
        assert_eq!((beyond.low, beyond.high), (Vec2::new(100.0, 424.0), Vec2::new(1097.0, 1195.0)));
    }

    #[test]
    fn a_part_grows_beyond_the_sides_that_water_came_near() {
        let part = part((324.0, 424.0), (580.0, 680.0));
        let sides = Sides { part, cells: std::array::from_fn(|_| Vec::new()), dry_depth: 1e-3, block: 32.0 };
        let wider = sides.wider([true, false, false, true]);
        assert_eq!((wider.low, wider.high), (Vec2::new(196.0, 424.0), Vec2::new(580.0, 808.0)));
    }
}
