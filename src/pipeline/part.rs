//! The part of a large terrain that a run prepares: where water comes in a run on coarse cells, with a margin.
//!
//! The coarse run sees all of the terrain by the means of its pixels. What it shows is no promise: where the water of the run itself comes near
//! a side at which the terrain goes on, the run begins again on a larger part.

use super::levels::greatest;
use super::scout::Scout;
use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, Severity};
use crate::lattice::Lattice;
use crate::math::{Rectangle, Vec2, readable};
use crate::output::PartRecord;
use crate::prepare::{BLOCK, outline, places_of_water, prepare, rectangle_of_fields};
use crate::scenario::methods::Motion;
use crate::scenario::{Part, Reading, Scenario, Side};
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
/// The sides of a part.
const SIDES: [Side; 4] = [Side::West, Side::South, Side::East, Side::North];
/// The share of its length by which a part grows beyond a side that the water came near.
const WIDER: f64 = 0.5;

/// The scenario with the part of its terrain that a run prepares; as it stands where that is all of it.
///
/// # Errors
/// What is wrong where the scene can be prepared neither whole nor on coarse cells, and what lies beside all of the terrain.
pub(super) fn choose(scenario: &Scenario) -> Result<Scenario, Vec<Problem>> {
    let Some((spacing, cells)) = finest(scenario).filter(|(_, cells)| *cells > WHOLE) else {
        return Ok(scenario.clone());
    };
    let doublings = (0.5 * (cells / COARSE).log2()).ceil() as i32;
    match look(scenario, spacing * f64::from(doublings).exp2())? {
        Some(places) => Ok(with_part(scenario, &places, spacing)),
        None => Ok(scenario.clone()),
    }
}

/// Edge of the finest cells (m) and their number on all of the terrain; none where rain falls on all of it, and for what needs all of it.
fn finest(scenario: &Scenario) -> Option<(f64, f64)> {
    if scenario.rain.is_some() || !scenario.numerics.has_cells() {
        return None;
    }
    let (about, pixel) = outline(scenario)?;
    let spacing = if scenario.auto.is_some() { pixel } else { scenario.resolution.value };
    let Vec2 { x, y } = about.size();
    let cells = x * y / (spacing * spacing);
    cells.is_finite().then_some((spacing, cells))
}

/// What a run on coarse cells shows.
struct Places {
    /// Their edge (m).
    spacing: f64,
    /// The rectangle (map coordinates, m) about all that is wet once, or that the scenario names.
    about: Rectangle,
    /// That of all terrain.
    whole: Rectangle,
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
    coarse.ground.follows_banks = false;
    // Where water comes cells at rest show as well.
    coarse.numerics.motion = Motion::Eulerian;
    let prepared = prepare(&coarse);
    let is_sound = !prepared.has_errors() && scenario.start.earlier.is_none();
    let Some(setup) = prepared.setup else { return Ok(None) };
    let lattice = &setup.scene.lattice;
    let whole = Rectangle { low: lattice.origin, high: lattice.origin + lattice.size() };
    let is_beside = |place: Vec2| !whole.holds(place);
    let beside = |problem: &Problem| problem.severity == Severity::Error && problem.at.is_some_and(is_beside);
    let beside: Vec<Problem> = prepared.problems.into_iter().filter(beside).collect();
    if !beside.is_empty() {
        return Err(beside);
    }
    let depths =
        if is_sound { greatest(&coarse, &setup, &mut Scout::new(&coarse, &setup.bed)).depth } else { Vec::new() };
    let wet = (0..depths.len()).filter(|&cell| depths[cell] > REACHED).map(|cell| lattice.centre(cell));
    let named = places_of_water(&coarse, &setup).into_iter().chain(wet).map(|place| lattice.to_map(place));
    let earlier = scenario.start.earlier.as_ref().and_then(rectangle_of_fields);
    // Cells of the earlier run may reach beyond the terrain.
    let within =
        |place: Vec2| Vec2::new(place.x.clamp(whole.low.x, whole.high.x), place.y.clamp(whole.low.y, whole.high.y));
    let corners = earlier.into_iter().flat_map(|Rectangle { low, high }| [low, high]).map(within);
    let about = Rectangle::about(named.filter(|place| whole.holds(*place)).chain(corners)).unwrap_or(whole);
    Ok(Some(Places { spacing, about, whole, is_sound }))
}

/// The scenario with the part about some places.
fn with_part(scenario: &Scenario, places: &Places, finest: f64) -> Scenario {
    let coarsest = scenario.levels.as_ref().map_or(finest, |levels| levels.coarsest.value);
    let share = if places.is_sound { BEYOND } else { WIDER };
    let beyond = |length: f64| share * length + BEYOND_CELLS * places.spacing + 2.0 * NEAR * coarsest;
    let Vec2 { x, y } = places.about.size();
    let margin = Vec2::new(beyond(x), beyond(y));
    let own = Rectangle { low: places.about.low - margin, high: places.about.high + margin };
    let mut scenario = scenario.clone();
    scenario.reading.part = Some(on_cells(Part { own, whole: places.whole }, block(finest, coarsest)));
    scenario
}

/// Edge (m) of the blocks between which the sides of a part lie.
fn block(finest: f64, coarsest: f64) -> f64 {
    (BLOCK as f64 * finest).max(coarsest)
}

/// The part with its sides on lines between blocks of cells (m) that count from the corner of the terrain, or on a side of that.
fn on_cells(Part { own, whole }: Part, block: f64) -> Part {
    let down = |place: f64, whole: f64| whole + (((place - whole) / block).floor() * block).max(0.0);
    let up = |place: f64, whole: f64, end: f64| (whole + ((place - whole) / block).ceil() * block).min(end);
    let low = Vec2::new(down(own.low.x, whole.low.x), down(own.low.y, whole.low.y));
    let high = Vec2::new(up(own.high.x, whole.low.x, whole.high.x), up(own.high.y, whole.low.y, whole.high.y));
    Part { own: Rectangle { low, high }, whole }
}

/// The places of a part near the sides at which the terrain goes on.
pub(super) struct Sides {
    part: Part,
    /// Near each of [`SIDES`]; of one that is not cut none.
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
        let deep = (NEAR * coarsest / lattice.spacing).ceil() as usize;
        let cells = SIDES.map(|side| if part.is_cut(side) { near_side(lattice, side, deep) } else { Vec::new() });
        let block = block(lattice.spacing, coarsest);
        Some(Sides { part, cells, dry_depth: scenario.numerics.dry_depth, block })
    }

    /// A larger part where there is water near one of the sides; it is looked for after every few steps, in each of which a wave goes a cell
    /// at most.
    pub fn beyond(&self, solver: &mut dyn FlowSolver) -> Option<Part> {
        let every = EVERY.next_multiple_of(solver.steps_of_a_record());
        if !solver.steps().is_multiple_of(every) {
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
        let Part { own, whole } = self.part;
        let more = own.size() * WIDER;
        let if_reached = |reached: bool, length: f64| if reached { length } else { 0.0 };
        let low = own.low - Vec2::new(if_reached(west, more.x), if_reached(south, more.y));
        let high = own.high + Vec2::new(if_reached(east, more.x), if_reached(north, more.y));
        on_cells(Part { own: Rectangle { low, high }, whole }, self.block)
    }
}

/// The cells of a lattice that stand for its places within so many of the finest cells of a side, ascending.
fn near_side(lattice: &Lattice, side: Side, deep: usize) -> Vec<usize> {
    let (columns, rows) = (lattice.columns, lattice.rows);
    let (across, up) = match side {
        Side::West => (0..deep.min(columns), 0..rows),
        Side::East => (columns.saturating_sub(deep)..columns, 0..rows),
        Side::South => (0..columns, 0..deep.min(rows)),
        Side::North => (0..columns, rows.saturating_sub(deep)..rows),
        Side::All => (0..columns, 0..rows),
    };
    let mut cells: Vec<usize> =
        up.flat_map(|row| across.clone().map(move |column| lattice.leaf(column, row))).collect();
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// The part for the record of the run.
pub(super) fn record(scenario: &Scenario) -> Option<PartRecord> {
    let Part { own: Rectangle { low, high }, whole } = scenario.reading.part?;
    let size = |Vec2 { x, y }: Vec2| [x, y];
    Some(PartRecord {
        west: low.x,
        south: low.y,
        east: high.x,
        north: high.y,
        size_m: size(high - low),
        terrain_m: size(whole.size()),
    })
}

/// What a run reports when it begins again on a larger part.
pub(super) fn larger(part: Part, time: f64) -> Problem {
    let size = part.own.size();
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

    fn rectangle(low: (f64, f64), high: (f64, f64)) -> Rectangle {
        Rectangle { low: Vec2::new(low.0, low.1), high: Vec2::new(high.0, high.1) }
    }

    fn part(low: (f64, f64), high: (f64, f64)) -> Part {
        Part { own: rectangle(low, high), whole: rectangle((100.0, 200.0), (1097.0, 1195.0)) }
    }

    #[test]
    fn the_sides_of_a_part_lie_between_blocks_or_on_those_of_the_terrain() {
        let inside = on_cells(part((333.0, 444.0), (555.0, 666.0)), 32.0);
        assert_eq!(inside.own, rectangle((324.0, 424.0), (580.0, 680.0)));
        let beyond = on_cells(part((-1e3, 444.0), (1e4, 1e4)), 32.0);
        assert_eq!(beyond.own, rectangle((100.0, 424.0), (1097.0, 1195.0)));
    }

    #[test]
    fn a_part_grows_beyond_the_sides_that_water_came_near() {
        let part = part((324.0, 424.0), (580.0, 680.0));
        let sides = Sides { part, cells: std::array::from_fn(|_| Vec::new()), dry_depth: 1e-3, block: 32.0 };
        let wider = sides.wider([true, false, false, true]);
        assert_eq!(wider.own, rectangle((196.0, 424.0), (580.0, 808.0)));
    }
}
