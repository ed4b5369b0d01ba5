//! A dam that breaks: its file, its ridge on the lattice, and whether its opening fits it.

use std::collections::BTreeMap;

use super::findings::Findings;
use super::grid::REACH;
use super::places;
use crate::bed::{BedParticles, Surface};
use crate::error::{Problem, ProblemKind};
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::physics::breach::{FailureMode, breach_estimates};
use crate::scenario::{
    Breach as Written, BreachFormula, BreachMode, BreachShape, BreachTrigger, GrowthLaw as Law, Scenario, Sourced,
};
use crate::seeding::StillWater;
use crate::solver::{Breach, DamCell, GrowthLaw, Opening, Trigger};
use crate::terrain::Terrain;

/// Attributes that may hold the crest where the scenario names none.
const CREST_NAMES: [&str; 2] = ["crest_m", "crest"];
/// An opening narrower than so many cells is a coarse one.
const FINE_OPENING: f64 = 5.0;
/// An end of a dam whose ground lies further below the crest than this (m) is open.
const OPEN_END: f64 = 0.05;

fn input_error(code: &'static str, message: String) -> Problem {
    Problem::error(ProblemKind::Input, code, "", message)
}

/// A dam before it is put on the lattice.
pub(super) struct Opened {
    /// Its line in map coordinates (m).
    line: Vec<Vec2>,
    /// Level of its crest (m).
    crest: f64,
}

/// Opens the file of the dam.
pub(super) fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Option<Opened> {
    let breach = scenario.breach.as_ref()?;
    let name = breach.dam.value.path.display();
    let features = places::features(&breach.dam, crs, scenario.reproject, findings)?;
    let lines: Vec<_> = features
        .iter()
        .flat_map(|feature| feature.lines.iter().map(move |line| (feature, line)))
        .filter(|(_, line)| line.0.len() >= 2)
        .collect();
    let [(feature, line)] = lines[..] else {
        let message = format!("{name} holds {} lines; a dam that breaks is one", lines.len());
        let remedy = "draw one line along the crest, from one abutment to the other";
        findings.add(&breach.dam, input_error("dam-lines", message).with_remedy(remedy));
        return None;
    };
    let names = breach.crest_field.as_deref().map_or(CREST_NAMES.to_vec(), |field| vec![field]);
    let attribute = || names.iter().find_map(|name| feature.number(name)).filter(|level| level.is_finite());
    let Some(crest) = breach.crest.as_ref().map(|crest| crest.value).or_else(attribute) else {
        let problem = input_error("no-crest", format!("neither the scenario nor {name} gives the crest of the dam"))
            .with_cause(format!("looked for the attribute {}", names.join(", ")))
            .with_remedy("add `crest: 105 m`, or name the attribute with `crest_field`");
        findings.add(&breach.dam, problem);
        return None;
    };
    let mut places: Vec<Vec2> = line.0.iter().map(|c| Vec2::new(c.x, c.y)).collect();
    places.dedup();
    Some(Opened { line: places, crest })
}

/// Raises the dam on the bed and checks what of it goes.
pub(super) fn on_lattice(
    opened: Option<&Opened>,
    scenario: &Scenario,
    bed: &mut BedParticles,
    findings: &mut Findings,
) -> Option<Breach> {
    let (written, opened) = (scenario.breach.as_ref()?, opened?);
    let written = &by_formula(written, opened.crest, scenario.numerics.gravity);
    let lattice = &bed.lattice;
    let line: Vec<Vec2> = opened.line.iter().map(|place| lattice.to_local(*place)).collect();
    let cells: Vec<DamCell> = crossed(&line, lattice)
        .into_iter()
        .filter(|(cell, _)| bed.has_terrain(*cell))
        .map(|(cell, station)| DamCell { cell, station, ground: bed.elevation[cell] })
        .collect();
    let Some(lowest) = cells.iter().min_by(|a, b| a.ground.total_cmp(&b.ground)).copied() else {
        let name = written.dam.value.path.display();
        let problem = input_error("outside-terrain", format!("the line of {name} lies outside the terrain"))
            .with_remedy("check that the file and the terrain have the same CRS")
            .with_at(opened.line[0]);
        findings.add(&written.dam, problem);
        return None;
    };
    let at = |cell: &DamCell| lattice.to_map(lattice.centre(cell.cell));
    if opened.crest <= lowest.ground {
        let message = format!(
            "the crest of {} m lies below all terrain along the dam ({:.2} m at least)",
            opened.crest, lowest.ground
        );
        let problem = input_error("crest-below-terrain", message)
            .with_remedy("correct the level, its unit or its datum, or the place of the line")
            .with_at(at(&lowest));
        match &written.crest {
            Some(crest) => findings.add(crest, problem),
            None => findings.add(&written.dam, problem),
        }
        return None;
    }
    let by_station = |a: &&DamCell, b: &&DamCell| a.station.total_cmp(&b.station);
    for end in [cells.iter().min_by(by_station), cells.iter().max_by(by_station)].into_iter().flatten() {
        if end.ground < opened.crest - OPEN_END {
            let message = format!(
                "the dam ends where the ground ({:.2} m) is {:.2} m below its crest",
                end.ground,
                opened.crest - end.ground
            );
            let problem = Problem::warning(ProblemKind::Input, "dam-end-open", "", message)
                .with_cause("higher water passes beside its end, if the edge of the terrain does not hold it")
                .with_remedy("draw the line on into the abutment")
                .with_at(at(end));
            findings.add(&written.dam, problem);
        }
    }
    let length = line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let opening = match &written.shape {
        None => Some(Opening::Whole),
        Some(shape) => trapezoid(shape, opened, &cells, (&line, length), lattice, findings),
    };
    let trigger = trigger(scenario, &written.trigger, bed, findings);
    if let (BreachTrigger::At(at), Some(duration)) = (&written.trigger, &written.duration)
        && at.value + duration.value > scenario.end_time
        && at.value < scenario.end_time
    {
        let message = format!(
            "the breach still grows when the run ends at {} s: it ends at {} s",
            scenario.end_time,
            at.value + duration.value
        );
        let problem = Problem::warning(ProblemKind::Scenario, "breach-unfinished", "", message);
        findings.add(duration, problem.with_remedy("let the run last longer, if the final opening matters"));
    }
    let breach = Breach {
        cells,
        crest: opened.crest,
        trigger: trigger?,
        opening: opening?,
        law: match written.law {
            Law::Instantaneous => GrowthLaw::Instantaneous,
            Law::Linear => GrowthLaw::Linear,
            Law::Sine => GrowthLaw::Sine,
        },
        duration: written.duration.as_ref().map_or(1.0, |duration| duration.value),
    };
    for cell in &breach.cells {
        bed.elevation[cell.cell] = breach.bed(cell, 0.0);
    }
    Some(breach)
}

/// The breach with the shape, growth and duration of its formula, where it has one.
fn by_formula(written: &Written, crest: f64, gravity: f64) -> Written {
    let Some(method) = &written.method else { return written.clone() };
    // An invert above the crest is refused with the shape.
    let height = (crest - method.invert.value).max(f64::MIN_POSITIVE);
    let mode = match method.mode {
        BreachMode::Overtopping => FailureMode::Overtopping,
        BreachMode::Piping => FailureMode::Piping,
    };
    let [froehlich_2008, froehlich_1995, ..] = breach_estimates(method.volume.value, height, mode, gravity);
    let estimate = match method.formula {
        BreachFormula::Froehlich2008 => froehlich_2008,
        BreachFormula::Froehlich1995 => froehlich_1995,
    };
    let by_volume = |value: f64| Sourced { value, ..method.volume.clone() };
    Written {
        shape: Some(BreachShape {
            bottom_width: by_volume(estimate.bottom_width(height).unwrap_or(0.0)),
            side_slope: estimate.side_slope,
            invert: method.invert.clone(),
            position: method.position.clone(),
        }),
        law: Law::Sine,
        duration: Some(by_volume(estimate.time[1])),
        ..written.clone()
    }
}

/// The opening of a shape, if it fits the dam.
fn trapezoid(
    shape: &BreachShape,
    dam: &Opened,
    cells: &[DamCell],
    (line, length): (&[Vec2], f64),
    lattice: &Lattice,
    findings: &mut Findings,
) -> Option<Opening> {
    let (width, slope, invert) = (shape.bottom_width.value, shape.side_slope, shape.invert.value);
    let middle = match &shape.position {
        None => 0.5 * length,
        Some(position) => {
            let place = Vec2::new(position.value[0], position.value[1]);
            let (station, distance) = station_of(lattice.to_local(place), line);
            if distance > REACH * lattice.spacing {
                let problem = input_error("position-off-dam", format!("this place lies {distance:.1} m off the dam"))
                    .with_remedy("give a place on its line, or leave the key out for the middle of the line")
                    .with_at(place);
                findings.add(position, problem);
                return None;
            }
            station
        }
    };
    if invert >= dam.crest {
        let message = format!("the invert of {invert} m is not below the crest of {} m", dam.crest);
        let problem = Problem::error(ProblemKind::Scenario, "invert-above-crest", "", message);
        findings.add(&shape.invert, problem.with_remedy("correct the level, its unit or its datum"));
        return None;
    }
    let top = width + 2.0 * slope * (dam.crest - invert);
    if top > length {
        let message = format!("the breach is {top:.1} m wide at the crest, and the dam is {length:.1} m long");
        let problem = Problem::error(ProblemKind::Scenario, "breach-wider-than-dam", "", message)
            .with_cause(format!(
                "bottom width {width} m, sides {slope} to 1 over {:.2} m of height",
                dam.crest - invert
            ))
            .with_remedy("take a narrower one; without `shape` the whole dam goes");
        findings.add(&shape.bottom_width, problem);
        return None;
    }
    // Half a cell more than the bottom, so that a narrow one does not fall between two cells.
    let reach = 0.5 * (width + lattice.spacing);
    let under = cells.iter().filter(|cell| (cell.station - middle).abs() <= reach);
    if let Some(ground) = under.min_by(|a, b| a.ground.total_cmp(&b.ground))
        && invert < ground.ground
    {
        let message =
            format!("the invert of {invert} m lies below the terrain under the breach, {:.2} m", ground.ground);
        let problem = input_error("invert-below-terrain", message)
            .with_remedy(format!(
                "take at least {:.2} m, or put the breach elsewhere with `position`",
                (100.0 * ground.ground).ceil() / 100.0
            ))
            .with_at(lattice.to_map(lattice.centre(ground.cell)));
        findings.add(&shape.invert, problem);
        return None;
    }
    if top < FINE_OPENING * lattice.spacing {
        let message = format!("the breach is {:.1} cells wide at the crest", top / lattice.spacing);
        let problem = Problem::warning(ProblemKind::Scenario, "breach-coarse", "", message).with_remedy(format!(
            "choose a `resolution` of {:.3} m or finer for its shape to count",
            top / FINE_OPENING
        ));
        findings.add(&shape.bottom_width, problem);
    }
    Some(Opening::Trapezoid { middle, bottom_width: width, side_slope: slope, invert })
}

fn trigger(
    scenario: &Scenario,
    trigger: &BreachTrigger,
    bed: &BedParticles,
    findings: &mut Findings,
) -> Option<Trigger> {
    match trigger {
        BreachTrigger::At(at) if at.value >= scenario.end_time => {
            let message =
                format!("the breach begins at {} s, when the run has ended at {} s", at.value, scenario.end_time);
            let problem = Problem::error(ProblemKind::Scenario, "trigger-after-end", "", message);
            findings.add(at, problem.with_remedy("let it begin earlier, or the run last longer (`time.end`)"));
            None
        }
        BreachTrigger::At(at) => Some(Trigger::At(at.value)),
        BreachTrigger::Level { level, place } => {
            let map = Vec2::new(place.value[0], place.value[1]);
            let local = bed.lattice.to_local(map);
            if bed.lattice.cell_at(local).is_none_or(|cell| !bed.has_terrain(cell)) {
                let problem = input_error("outside-terrain", "this place lies on no terrain".to_owned())
                    .with_remedy("check its coordinates, their order and their CRS")
                    .with_at(map);
                findings.add(place, problem);
                return None;
            }
            Some(Trigger::Level { level: level.value, place: local })
        }
    }
}

/// Refuses a level that no water of the run can reach.
pub(super) fn check_level(
    scenario: &Scenario,
    breach: &Breach,
    bed: &BedParticles,
    water: &StillWater,
    findings: &mut Findings,
) {
    let (Some(written), Trigger::Level { level, place }) = (&scenario.breach, breach.trigger) else { return };
    let BreachTrigger::Level { level: source, .. } = &written.trigger else { return };
    let is_fed = !scenario.boundaries.is_empty() || !scenario.sources.is_empty() || scenario.rain.is_some();
    let wet = (0..water.depth.len()).filter(|&cell| water.depth[cell] > 0.0);
    let highest = wet.map(|cell| bed.elevation[cell] + water.depth[cell]).fold(f64::NEG_INFINITY, f64::max);
    if level > highest && !is_fed {
        let message =
            format!("the water never reaches {level} m: it stands at {highest:.2} m at most, and none comes in");
        let problem = Problem::error(ProblemKind::Scenario, "level-never-reached", "", message)
            .with_remedy("lower it, add a boundary, a source or rain, or let the breach begin at a time")
            .with_at(bed.lattice.to_map(place));
        findings.add(source, problem);
    }
}

/// The terrain with the dam on it, so that what is filled to a level knows the dam.
pub(super) struct WithDam<'a> {
    terrain: &'a Terrain,
    lattice: &'a Lattice,
    crest: f64,
    /// The cells of the dam, in ascending order.
    cells: Vec<usize>,
}

impl<'a> WithDam<'a> {
    pub fn new(terrain: &'a Terrain, lattice: &'a Lattice, breach: Option<&Breach>) -> Self {
        let mut cells: Vec<usize> = breach.iter().flat_map(|breach| &breach.cells).map(|cell| cell.cell).collect();
        cells.sort_unstable();
        WithDam { terrain, lattice, crest: breach.map_or(f64::NEG_INFINITY, |breach| breach.crest), cells }
    }

    fn raised(&self, place: Vec2, elevation: f64) -> f64 {
        let is_dam = !self.cells.is_empty()
            && self
                .lattice
                .cell_at(self.lattice.to_local(place))
                .is_some_and(|cell| self.cells.binary_search(&cell).is_ok());
        if is_dam { elevation.max(self.crest) } else { elevation }
    }
}

impl Surface for WithDam<'_> {
    fn elevation(&self, map: Vec2) -> Option<f64> {
        self.terrain.elevation(map).map(|elevation| self.raised(map, elevation))
    }

    fn samples(&self, centre: Vec2, radius: f64, out: &mut Vec<(Vec2, f64)>) {
        let first = out.len();
        self.terrain.samples(centre, radius, out);
        for (place, elevation) in &mut out[first..] {
            *elevation = self.raised(*place, *elevation);
        }
    }
}

/// The cells that a line (local coordinates, m) crosses, in ascending order, each with the station (m) of its centre.
///
/// They close every way from cell to cell through a common edge: where the line passes through a corner, the two cells on its
/// way meet there, and the other two have no common edge.
fn crossed(line: &[Vec2], lattice: &Lattice) -> BTreeMap<usize, f64> {
    let mut found = BTreeMap::new();
    let index = |x: f64, count: usize| ((x / lattice.spacing).floor().max(0.0) as usize).min(count.saturating_sub(1));
    for piece in line.windows(2) {
        let [a, b] = [piece[0], piece[1]];
        for row in index(a.y.min(b.y), lattice.rows)..=index(a.y.max(b.y), lattice.rows) {
            for column in index(a.x.min(b.x), lattice.columns)..=index(a.x.max(b.x), lattice.columns) {
                let corner = Vec2::new(column as f64, row as f64) * lattice.spacing;
                if passes(piece, corner, lattice.spacing) {
                    let cell = lattice.index(column, row);
                    found.entry(cell).or_insert_with(|| station_of(lattice.centre(cell), line).0);
                }
            }
        }
    }
    found
}

/// Whether a piece has a part of some length in a cell; along an edge it belongs to the cell beyond, as places do.
fn passes(piece: &[Vec2], corner: Vec2, spacing: f64) -> bool {
    let (start, along) = (piece[0], piece[1] - piece[0]);
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (start, along, low) in [(start.x, along.x, corner.x), (start.y, along.y, corner.y)] {
        if along.abs() > 0.0 {
            let (a, b) = ((low - start) / along, (low + spacing - start) / along);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        } else if start < low || start >= low + spacing {
            return false;
        }
    }
    from < to
}

/// The station (m) along a line of the place on it that is nearest to a place, and its distance (m).
fn station_of(place: Vec2, line: &[Vec2]) -> (f64, f64) {
    let mut best = (0.0, f64::INFINITY);
    let mut before = 0.0;
    for piece in line.windows(2) {
        let along = piece[1] - piece[0];
        let share = ((place - piece[0]).dot(along) / along.norm_squared()).clamp(0.0, 1.0);
        let distance = (place - (piece[0] + along * share)).norm();
        if distance < best.1 {
            best = (before + share * along.norm(), distance);
        }
        before += along.norm();
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice() -> Lattice {
        Lattice { origin: Vec2::ZERO, columns: 12, rows: 10, spacing: 2.0 }
    }

    #[test]
    fn the_cells_of_a_line_close_every_way_through_edges() {
        let lattice = lattice();
        let lines = [
            vec![Vec2::new(9.3, -1.0), Vec2::new(9.3, 21.0)],
            vec![Vec2::new(2.0, 0.0), Vec2::new(22.0, 20.0)],
            vec![Vec2::new(10.0, -1.0), Vec2::new(10.0, 21.0)],
            vec![Vec2::new(3.1, -0.5), Vec2::new(15.7, 8.2), Vec2::new(6.4, 20.5)],
        ];
        for line in lines {
            let dam = crossed(&line, &lattice);
            // Water from the west over edges reaches no cell of the eastern edge.
            let mut reached: Vec<usize> = (0..10).map(|row| row * 12).filter(|cell| !dam.contains_key(cell)).collect();
            let mut next = 0;
            while next < reached.len() {
                let (column, row) = lattice.column_row(reached[next]);
                next += 1;
                for (dc, dr) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                    let (c, r) = (column as isize + dc, row as isize + dr);
                    if (0..12).contains(&c) && (0..10).contains(&r) {
                        let cell = lattice.index(c as usize, r as usize);
                        if !dam.contains_key(&cell) && !reached.contains(&cell) {
                            reached.push(cell);
                        }
                    }
                }
            }
            assert!(!reached.is_empty() && reached.iter().all(|cell| cell % 12 != 11), "{line:?}");
        }
    }

    #[test]
    fn a_line_along_an_edge_raises_one_row_of_cells() {
        let lattice = lattice();
        let dam = crossed(&[Vec2::new(10.0, 0.0), Vec2::new(10.0, 20.0)], &lattice);
        assert_eq!(dam.len(), 10);
        assert!(dam.keys().all(|cell| cell % 12 == 5));
        assert!((dam[&5] - 1.0).abs() < 1e-12 && (dam[&(9 * 12 + 5)] - 19.0).abs() < 1e-12);
    }
}
