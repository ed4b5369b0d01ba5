//! A dam that breaks: its file, its ridge on the lattice, and whether its opening fits it.

use std::collections::{BTreeMap, BTreeSet};

use crate::bed::BedParticles;
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::{Vec2, readable, segments_cross};
use crate::output::{Section, SetBy};
use crate::physics::breach::{FailureMode, breach_estimates};
use crate::prepare::findings::Findings;
use crate::prepare::grid::REACH;
use crate::prepare::ground::burn::{Foot, crossed, foot_of, strip};
use crate::prepare::ground::crests::{Buried, length_above_ground};
use crate::prepare::ground::gaps::around;
use crate::prepare::ground::{Change, Ground, Made};
use crate::prepare::outside::{Outside, all_outside, partly_outside};
use crate::prepare::places;
use crate::prepare::tables::series;
use crate::prepare::water::{self, SourcedBody};
use crate::scenario::methods::Motion;
use crate::scenario::{
    BoundaryCondition, Breach as Written, BreachFormula, BreachMode, BreachShape, BreachTrigger, GrowthLaw as Law,
    Scenario, Sourced,
};
use crate::seeding::{Barriers, StillWater};
use crate::solver::{Breach, DamCell, GrowthLaw, Opening, RimCell, Trigger};
use crate::vector::Feature;

/// Attributes that may hold the crest where the scenario names none.
const CREST_NAMES: [&str; 2] = ["crest_m", "crest"];
/// An opening narrower than so many cells is a coarse one.
const FINE_OPENING: f64 = 5.0;
/// The terrain may stand in the opening over this share of its bottom without a word: the valley has slopes.
const GROUND_IN_OPENING: f64 = 0.1;
/// How far (in cells) beside the dam the water must find its way.
const BESIDE_DAM: f64 = 3.0;
/// Water higher than the crest by this (m) runs over it.
const OVER_CREST: f64 = 1e-3;
/// A trigger higher than the crest by this (m) is hardly meant so: a dam that is overtopped breaks at a depth of some decimetres.
const TRIGGER_OVER_CREST: f64 = 1.0;
/// A bed raised by no more than this (m) is rounding.
const ROUND_OFF: f64 = 1e-9;
/// An end of a dam whose ground lies further below the crest than this (m) is open.
const OPEN_END: f64 = 0.05;

/// A dam before it is put on the lattice.
pub struct Opened {
    /// Its line in map coordinates (m).
    line: Vec<Vec2>,
    /// Level of its crest (m).
    crest: f64,
}

/// Opens the file of the dam.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Option<Opened> {
    let breach = scenario.breach.as_ref()?;
    let name = breach.dam.value.path.display();
    let features = places::features(&breach.dam, crs, scenario.reproject, findings)?;
    let has_line = |feature: &Feature| feature.lines.iter().any(places::has_length);
    findings.add_all(&breach.dam, places::left_out(&breach.dam, &features, "line", has_line));
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
    if breach.crest.is_none() {
        findings.add_all(&breach.dam, places::unit_of_attribute(&breach.dam, &names, &features, scenario));
    }
    let attribute = || names.iter().find_map(|name| feature.number(name)).filter(|level| level.is_finite());
    let Some(crest) = breach.crest.as_ref().map(|crest| crest.value).or_else(attribute) else {
        let problem = input_error("no-crest", format!("neither the scenario nor {name} gives the crest of the dam"))
            .with_cause(format!(
                "looked for the attribute {}; its attributes: {}",
                names.join(", "),
                feature.attribute_names()
            ))
            .with_remedy("add `crest: 105 m`, or name the attribute with `crest_field`");
        findings.add(&breach.dam, problem);
        return None;
    };
    let mut places: Vec<Vec2> = line.0.iter().map(|c| Vec2::new(c.x, c.y)).collect();
    places.dedup();
    Some(Opened { line: places, crest })
}

/// Raises the dam on the ground and checks what of it goes.
pub fn on_lattice(
    opened: Option<&Opened>,
    scenario: &Scenario,
    ground: &mut Ground<'_>,
    findings: &mut Findings,
) -> Option<Breach> {
    let breach = planned(opened, scenario, ground.bed(), findings)?;
    ground.take(beds(&breach, breach.share_at_start()));
    Some(breach)
}

/// The dam and its breach; reports what of it does not go.
fn planned(
    opened: Option<&Opened>,
    scenario: &Scenario,
    bed: &BedParticles,
    findings: &mut Findings,
) -> Option<Breach> {
    let (written, opened) = (scenario.breach.as_ref()?, opened?);
    let written = &by_formula(written, opened.crest, scenario.numerics.gravity);
    let lattice = &bed.lattice;
    let line: Vec<Vec2> = opened.line.iter().map(|place| lattice.to_local(*place)).collect();
    // The bed that Lagrangian particles see is lower between two cells that meet at a corner only.
    let crossed = match scenario.numerics.motion {
        Motion::Eulerian => crossed(&line, lattice),
        Motion::Lagrangian => strip(&line, 0.0, lattice),
    };
    let on_terrain = crossed.into_iter().filter(|cell| bed.has_terrain(*cell));
    let cells: Vec<DamCell> = on_terrain.map(|cell| dam_cell(cell, &line, lattice, bed.elevation[cell])).collect();
    let Some(lowest) = cells.iter().min_by(|a, b| a.ground.total_cmp(&b.ground)).copied() else {
        all_outside(&written.dam, opened.line[0], findings);
        return None;
    };
    let outside = Outside::beyond_reach(line.windows(2).map(|pair| [pair[0], pair[1]]), bed);
    findings.add_all(&written.dam, partly_outside(&written.dam, outside, lattice.spacing, "there is no dam there"));
    let at = |cell: &DamCell| lattice.to_map(lattice.centre(cell.cell));
    if opened.crest <= lowest.ground {
        let message = format!(
            "the crest of {} m lies below all terrain along the dam ({:.2} m at least)",
            readable(opened.crest),
            lowest.ground
        );
        let problem = input_error("crest-below-terrain", message)
            .with_remedy("correct the level, its unit or its datum, or the place of the line")
            .with_at(at(&lowest));
        add_of_crest(written, problem, findings);
        return None;
    }
    if let Some(part) = Buried::of(&line, &vec![opened.crest; line.len()], bed) {
        add_of_crest(written, part.problem("the dam").with_at(lattice.to_map(part.place)), findings);
    }
    warn_of_open_ends(&cells, written, opened.crest, lattice, findings);
    let length = line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let free = length_above_ground(&line, opened.crest, bed);
    let opening = match &written.shape {
        None => Some(Opening::Whole),
        Some(shape) => trapezoid(shape, opened, &cells, (&line, [length, free]), lattice, findings),
    };
    let trigger = trigger(scenario, &written.trigger, bed, findings);
    let share = written.share.as_ref().map(|table| (table, series::growth(table, findings)));
    let lasts = share.as_ref().and_then(|(table, share)| {
        let value = share.as_ref()?.points().last()?.0;
        Some(Sourced { value, key: table.file.key.clone(), place: table.file.place.clone() })
    });
    let duration = written.duration.clone().or(lasts);
    if let (BreachTrigger::At(at), Some(duration)) = (&written.trigger, &duration)
        && at.value + duration.value > scenario.end_time
        && at.value < scenario.end_time
    {
        let message = format!(
            "the breach still grows when the run ends at {} s: it ends at {} s",
            readable(scenario.end_time),
            readable(at.value + duration.value)
        );
        let problem = Problem::warning(ProblemKind::Scenario, "breach-unfinished", "", message);
        findings.add(duration, problem.with_remedy("let the run last longer, if the final opening matters"));
    }
    if let (Motion::Lagrangian, Some(duration)) = (scenario.numerics.motion, &duration) {
        let message = "Lagrangian particles pass a crest that sinks slowly late, and then too many of them at once: the flood may begin many minutes late, and its peak be too high";
        let problem = Problem::warning(ProblemKind::Scenario, "late-breach", "", message);
        findings.add(
            duration,
            problem.with_remedy("leave out `motion: lagrangian` wherever the hydrograph of a breach counts"),
        );
    }
    Some(Breach {
        cells,
        rim: Vec::new(),
        crest: opened.crest,
        trigger: trigger?,
        opening: opening?,
        law: match written.law {
            Law::Instantaneous => GrowthLaw::Instantaneous,
            Law::Linear => GrowthLaw::Linear,
            Law::Sine => GrowthLaw::Sine,
            Law::Series => GrowthLaw::Series(share?.1?),
        },
        duration: duration.as_ref().map_or(1.0, |duration| duration.value),
    })
}

/// A cell below the line of a dam (local coordinates, m), with its ground (m).
fn dam_cell(cell: usize, line: &[Vec2], lattice: &Lattice, ground: f64) -> DamCell {
    let Foot { station, direction, .. } = foot_of(lattice.centre(cell), line);
    let reach = 0.5 * lattice.spacing * (direction.x.abs() + direction.y.abs());
    DamCell { cell, station, reach, ground }
}

/// The bed of the dam, as far as it stands at a share of its growth.
fn beds(breach: &Breach, share: f64) -> Vec<Change> {
    breach.beds(share).map(|(cell, z_b)| Change { cell, made: Made::Bed(z_b), by: SetBy::Dam }).collect()
}

/// The terrain in the cells that a dam raises at a share of its growth.
fn terrain(breach: &Breach, share: f64) -> Vec<Change> {
    let level = |cell: &DamCell| {
        let z_b = breach.bed(cell, share);
        if share <= 0.0 { Some(breach.crest) } else { Some(z_b).filter(|z_b| *z_b > cell.ground) }
    };
    let change = |cell: &DamCell| {
        let made = Made::RaiseTerrain(level(cell)?);
        Some(Change { cell: cell.cell, made, by: SetBy::Dam })
    };
    breach.cells.iter().filter_map(change).collect()
}

/// The cells in which a dam stands above its ground at a share of its growth, ascending.
fn cells_standing(breach: &Breach, share: f64) -> Vec<usize> {
    let stands = |cell: &&DamCell| breach.bed(cell, share) > cell.ground;
    breach.cells.iter().filter(stands).map(|cell| cell.cell).collect()
}

/// Fills the lake behind the dam, on the bed that the dam has at the start: one that goes at once then never stands, and its run is that
/// without a dam. Leaks are those with the dam standing.
pub fn fill_behind(
    breach: Option<&Breach>,
    bodies: &[SourcedBody],
    (walls, is_complete): (&[[Vec2; 2]], bool),
    ground: &mut Ground<'_>,
    findings: &mut Findings,
) -> StillWater {
    let share = breach.map_or(0.0, Breach::share_at_start);
    let standing_at = |share| breach.map_or(Vec::new(), |breach| cells_standing(breach, share));
    if let Some(breach) = breach.filter(|_| share > 0.0) {
        let mut with_dam = ground.clone();
        with_dam.take(beds(breach, 0.0));
        with_dam.take(terrain(breach, 0.0));
        let dam = standing_at(0.0);
        water::fill(bodies, &mut with_dam, Barriers { walls, dam: &dam }, is_complete, findings);
    }
    breach.into_iter().for_each(|breach| ground.take(terrain(breach, share)));
    let is_complete = is_complete && share <= 0.0;
    let dam = standing_at(share);
    water::fill(bodies, ground, Barriers { walls, dam: &dam }, is_complete, findings)
}

/// Takes the bed as the lake has shaped it: below a dam that is gone at the start, and beside one that stands, where what the shore raised
/// would be a sill before its opening and sinks with it.
///
/// - `before`: the bed (m) before the lake was filled
pub fn settle(opened: &Opened, breach: &mut Breach, before: &[f64], bed: &BedParticles) {
    let share = breach.share_at_start();
    if share > 0.0 {
        for cell in &mut breach.cells {
            if before[cell.cell] <= cell.ground {
                cell.ground = bed.elevation[cell.cell];
            }
        }
        return;
    }
    let lattice = &bed.lattice;
    let line: Vec<Vec2> = opened.line.iter().map(|place| lattice.to_local(*place)).collect();
    let dam: BTreeSet<usize> = breach.cells.iter().map(|cell| cell.cell).collect();
    let beside: BTreeSet<usize> = dam.iter().flat_map(|cell| around(*cell, lattice)).collect();
    let is_raised = |cell: &usize| !dam.contains(cell) && bed.elevation[*cell] > before[*cell] + ROUND_OFF;
    let rim = |cell: usize| RimCell { at: dam_cell(cell, &line, lattice, before[cell]), raised: bed.elevation[cell] };
    breach.rim = beside.into_iter().filter(is_raised).map(rim).collect();
}

/// Name of the cross-section along the dam; an underscore more for each one of that name that the scenario has.
const SECTION: &str = "breach";

/// The cross-section along the dam, through which the flood passes: drawn so that what leaves the lake counts as positive.
pub fn section(
    opened: &Opened,
    breach: &Breach,
    others: &[Section],
    bed: &BedParticles,
    water: &StillWater,
) -> Section {
    let lattice = &bed.lattice;
    let mut line = opened.line.clone();
    let local: Vec<Vec2> = line.iter().map(|place| lattice.to_local(*place)).collect();
    // Water is counted towards the left of the line.
    if rise_to_the_left(&local, breach, bed, water) > 0.0 {
        line.reverse();
    }
    let mut id = SECTION.to_owned();
    while others.iter().any(|other| other.id == id) {
        id.push('_');
    }
    Section { id, line }
}

/// How much higher the lake stands on the left of the dam than what is on its right (m, summed along the dam): by the water of the start where it
/// lies beside the dam, or else by the place whose level the dam waits for, or by the ground, which falls downstream.
fn rise_to_the_left(line: &[Vec2], breach: &Breach, bed: &BedParticles, water: &StillWater) -> f64 {
    let lattice = &bed.lattice;
    let [start, end] = [line.first(), line.last()].map(|place| place.copied().unwrap_or_default());
    let left = (end - start).perpendicular() * (1.0 / (end - start).norm().max(f64::MIN_POSITIVE));
    let beside = |cell: &DamCell, side: f64| {
        let place = lattice.centre(cell.cell) + left * (side * BESIDE_DAM * lattice.spacing);
        lattice.cell_at(place).filter(|cell| bed.has_terrain(*cell))
    };
    let pairs: Vec<[usize; 2]> =
        breach.cells.iter().filter_map(|cell| Some([beside(cell, 1.0)?, beside(cell, -1.0)?])).collect();
    let is_wet = |pair: &&[usize; 2]| pair.iter().any(|cell| water.depth[*cell] > 0.0);
    let has_water = pairs.iter().any(|pair| is_wet(&pair));
    if let (Trigger::Level { place, .. }, false) = (&breach.trigger, has_water) {
        let Foot { foot, direction, .. } = foot_of(*place, line);
        return (*place - foot).dot(direction.perpendicular());
    }
    let level = |cell: usize| bed.elevation[cell] + water.depth[cell];
    let counted = pairs.iter().filter(|pair| !has_water || is_wet(pair));
    counted.map(|[on_left, on_right]| level(*on_left) - level(*on_right)).sum()
}

/// Reports a problem of the crest where that is written.
fn add_of_crest(written: &Written, problem: Problem, findings: &mut Findings) {
    match &written.crest {
        Some(crest) => findings.add(crest, problem),
        None => findings.add(&written.dam, problem),
    }
}

/// The first and the last cell along the dam.
fn ends(cells: &[DamCell]) -> [Option<&DamCell>; 2] {
    let by_station = |a: &&DamCell, b: &&DamCell| a.station.total_cmp(&b.station);
    [cells.iter().min_by(by_station), cells.iter().max_by(by_station)]
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

/// The opening of a shape, if it fits the dam, of which the length (m) is given, and that over which it stands above the ground.
fn trapezoid(
    shape: &BreachShape,
    dam: &Opened,
    cells: &[DamCell],
    (line, [length, free]): (&[Vec2], [f64; 2]),
    lattice: &Lattice,
    findings: &mut Findings,
) -> Option<Opening> {
    let (width, slope, invert) = (shape.bottom_width.value, shape.side_slope, shape.invert.value);
    let middle = match &shape.position {
        None => 0.5 * length,
        Some(position) => {
            let place = Vec2::new(position.value[0], position.value[1]);
            let Foot { station, distance, .. } = foot_of(lattice.to_local(place), line);
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
        let message =
            format!("the invert of {} m is not below the crest of {} m", readable(invert), readable(dam.crest));
        let problem = Problem::error(ProblemKind::Scenario, "invert-above-crest", "", message);
        findings.add(&shape.invert, problem.with_remedy("correct the level, its unit or its datum"));
        return None;
    }
    let top = width + 2.0 * slope * (dam.crest - invert);
    // The ground meets the crest within a cell.
    if top > length || top > free + lattice.spacing {
        let stands = if free + lattice.spacing < length {
            format!(", and stands above the ground over {free:.1} m of it")
        } else {
            String::new()
        };
        let message = format!("the breach is {top:.1} m wide at the crest, and the dam is {length:.1} m long{stands}");
        let problem = Problem::error(ProblemKind::Scenario, "breach-wider-than-dam", "", message)
            .with_cause(format!(
                "bottom width {} m, sides {} to 1 over {:.2} m of height",
                readable(width),
                readable(slope),
                dam.crest - invert
            ))
            .with_remedy("take a narrower one, or correct the crest; without `shape` the whole dam goes");
        findings.add(&shape.bottom_width, problem);
        return None;
    }
    let stations = || cells.iter().map(|cell| cell.station);
    let (first, last) = (stations().fold(f64::INFINITY, f64::min), stations().fold(f64::NEG_INFINITY, f64::max));
    if middle - 0.5 * top < first - 0.5 * lattice.spacing || middle + 0.5 * top > last + 0.5 * lattice.spacing {
        let message = format!(
            "the breach, {top:.1} m wide at the crest around {middle:.1} m along the dam, reaches beyond its end on the terrain"
        );
        let problem = Problem::error(ProblemKind::Scenario, "breach-beyond-dam", "", message)
            .with_cause(format!("the dam stands on the terrain from {first:.1} m to {last:.1} m of its line"))
            .with_remedy("take a `position` further from the end, a narrower breach, or a longer line");
        findings.add(&shape.bottom_width, problem);
        return None;
    }
    let is_under = |cell: &&DamCell| (cell.station - middle).abs() <= 0.5 * width + cell.reach;
    let under: Vec<&DamCell> = cells.iter().filter(is_under).collect();
    if let Some(ground) = under.iter().min_by(|a, b| a.ground.total_cmp(&b.ground))
        && invert < ground.ground
    {
        let message = format!(
            "the invert of {} m lies below the terrain under the breach, {:.2} m",
            readable(invert),
            ground.ground
        );
        let problem = input_error("invert-below-terrain", message)
            .with_remedy(format!(
                "take at least {:.2} m, or put the breach elsewhere with `position`",
                (100.0 * ground.ground).ceil() / 100.0
            ))
            .with_at(lattice.to_map(lattice.centre(ground.cell)));
        findings.add(&shape.invert, problem);
        return None;
    }
    let above: Vec<_> = under.iter().filter(|cell| cell.ground > invert + OPEN_END).collect();
    if let Some(highest) = above.iter().max_by(|a, b| a.ground.total_cmp(&b.ground))
        && above.len() as f64 > GROUND_IN_OPENING * under.len() as f64
    {
        let message = format!(
            "{} of {} cells of the bottom of the breach end on the terrain above the invert of {} m, the highest at {:.2} m",
            above.len(),
            under.len(),
            readable(invert),
            highest.ground
        );
        let problem = Problem::warning(ProblemKind::Input, "terrain-in-breach", "", message)
            .with_cause("a valley narrower than the breach, or a terrain that holds the dam already")
            .with_remedy(
                "look at the terrain along the dam; where it holds the dam, carve it out with `terrain.breaklines`",
            )
            .with_at(lattice.to_map(lattice.centre(highest.cell)));
        findings.add(&shape.invert, problem);
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

/// Refuses an opening that ends above all water, and warns of a volume that is not that of the lake.
fn check_water(
    written: &Written,
    breach: &Breach,
    (highest, is_fed): (f64, bool),
    above: impl Fn(f64) -> f64,
    findings: &mut Findings,
) {
    let lowest = breach.cells.iter().map(|cell| breach.bed(cell, 1.0)).fold(f64::INFINITY, f64::min);
    if lowest >= highest && !is_fed {
        let stands = if highest.is_finite() {
            format!("the water stands at {highest:.2} m at most")
        } else {
            "there is no water".to_owned()
        };
        let message = format!("the opening ends at {lowest:.2} m, and {stands}: none would pass");
        let problem = Problem::error(ProblemKind::Scenario, "opening-above-water", "", message)
            .with_cause("the terrain along the line holds the dam already, or a level is wrong")
            .with_remedy("carve the dam out of the terrain (`terrain.breaklines`, `mode: carve`), or correct the invert or the level of the lake");
        findings.add(&written.dam, problem);
    }
    let Some(method) = &written.method else { return };
    let volume = above(method.invert.value);
    let ratio = method.volume.value / volume;
    if !is_fed && !(0.5..=2.0).contains(&ratio) {
        let message = format!(
            "the formula is given {:.4e} m³, and the water of the run above the invert is {volume:.4e} m³",
            method.volume.value
        );
        let problem = Problem::warning(ProblemKind::Scenario, "breach-volume", "", message);
        findings.add(&method.volume, problem.with_remedy("check the unit (m3, Mm3, hm3) and the lake that is meant"));
    }
}

/// Warns of water beside the dam that stands above its crest.
fn warn_of_water_above(
    written: &Written,
    breach: &Breach,
    bed: &BedParticles,
    water: &StillWater,
    findings: &mut Findings,
) {
    let level_of = |cell: usize| bed.elevation[cell] + water.depth[cell];
    let lattice = &bed.lattice;
    let beside = |cell: &DamCell| {
        let centre = lattice.centre(cell.cell);
        let places = [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
        places.map(|(x, y)| lattice.cell_at(centre + Vec2::new(x, y) * lattice.spacing))
    };
    let raised = breach.cells.iter().filter(|cell| cell.ground < breach.crest);
    let wet = raised.flat_map(beside).flatten().filter(|&cell| water.depth[cell] > 0.0);
    if let Some(cell) = wet.max_by(|a, b| level_of(*a).total_cmp(&level_of(*b)))
        && level_of(cell) > breach.crest + OVER_CREST
    {
        let message = format!(
            "the water stands at {:.2} m beside the dam, above its crest of {} m",
            level_of(cell),
            breach.crest
        );
        let problem = Problem::warning(ProblemKind::Scenario, "water-above-crest", "", message)
            .with_cause("it runs over the dam from the start on, whether the dam breaks or not")
            .with_remedy("correct the level of the lake or the crest, their units or their datum")
            .with_at(lattice.to_map(lattice.centre(cell)));
        findings.add(&written.dam, problem);
    }
}

/// Refuses a level that no water of the run can reach, and an opening above all water; warns of water and of a level above the crest.
pub fn check_level(
    scenario: &Scenario,
    breach: &Breach,
    bed: &BedParticles,
    water: &StillWater,
    findings: &mut Findings,
) {
    let brings_water = |condition: &BoundaryCondition| {
        matches!(
            condition,
            BoundaryCondition::Discharge { .. }
                | BoundaryCondition::Stage(_)
                | BoundaryCondition::Level(_)
                | BoundaryCondition::Wave { .. }
        )
    };
    let is_fed = scenario.boundaries.iter().any(|boundary| brings_water(&boundary.value.condition))
        || !scenario.sources.is_empty()
        || scenario.rain.is_some()
        || !scenario.channels.is_empty();
    let wet = || (0..water.depth.len()).filter(|&cell| water.depth[cell] > 0.0);
    let level_of = |cell: usize| bed.elevation[cell] + water.depth[cell];
    let highest = wet().map(level_of).fold(f64::NEG_INFINITY, f64::max);
    let above = |invert: f64| {
        wet().map(|cell| bed.area(cell) * (level_of(cell) - bed.elevation[cell].max(invert)).max(0.0)).sum::<f64>()
    };
    if let Some(written) = &scenario.breach {
        check_water(written, breach, (highest, is_fed), above, findings);
        warn_of_water_above(written, breach, bed, water, findings);
    }
    let (Some(written), Trigger::Level { level, place }) = (&scenario.breach, breach.trigger) else { return };
    let BreachTrigger::Level { level: source, .. } = &written.trigger else { return };
    if level > highest && !is_fed {
        let message = if highest.is_finite() {
            format!("the water never reaches {level} m: it stands at {highest:.2} m at most, and none comes in")
        } else {
            format!("the water never reaches {level} m: there is none at the start, and none comes in")
        };
        let problem = Problem::error(ProblemKind::Scenario, "level-never-reached", "", message)
            .with_remedy("lower it, add a boundary, a source or rain, or let the breach begin at a time")
            .with_at(bed.lattice.to_map(place));
        findings.add(source, problem);
    } else if level > breach.crest + TRIGGER_OVER_CREST {
        let message = format!(
            "the dam is to break at {level} m, {} m above its crest of {} m",
            readable(level - breach.crest),
            breach.crest
        );
        let problem = input_warning("trigger-above-crest", message)
            .with_cause("the water would have to run over the dam so deep first, if it ever stands so high")
            .with_remedy(
                "correct the level or the crest, their units or their datum; or let the breach begin at a time",
            )
            .with_at(bed.lattice.to_map(place));
        findings.add(source, problem);
    }
}
