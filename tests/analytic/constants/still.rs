//! Still water at the start, and what a gauge reads of it.

use floodsim::bed::{BedParticles, Nothing, Surface, place_bed_with};
use floodsim::constants::Constants;
use floodsim::lattice::{FlatWater, Lattice, Span, WaterOnLattice};
use floodsim::math::Vec2;
use floodsim::output::{Gauge, Recorder, RecorderPlan, Volumes};
use floodsim::scenario::methods::BedMethod;
use floodsim::seeding::{Barriers, StillBody, StillWater, fill_still_water};
use geo::{LineString, MultiPolygon, Polygon};

use super::Case;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "lake short of its shore",
        about: "lakes on rough shores whose polygons end 0 to 6 cells short: mean share of their cells that stays dry",
        feels: &["seeding.pocket_reach", "seeding.pocket_steps"],
        run: short_of_shore,
    },
    Case {
        name: "ditch along a rim",
        about: "a ditch of ten cells along the rim of a lake that leads out of it at its end: share of the ditch that stays dry",
        feels: &["seeding.pocket_steps"],
        run: ditch,
    },
    Case {
        name: "lake without its dam",
        about: "lakes of 6 to 40 cells that end in open water: mean difference of the bed from its terrain in the ten cells before the opening (m)",
        feels: &["seeding.approach"],
        run: |constants| mean((0..12).map(|k| without_dam(constants, 6.0 + 3.0 * f64::from(k)).0)),
    },
    Case {
        name: "volume without a dam",
        about: "the same lakes: mean difference of the volume (share)",
        feels: &["seeding.volume_aim"],
        run: |constants| mean((0..60).map(|k| without_dam(constants, 40.0 + 0.37 * f64::from(k)).1)),
    },
    Case {
        name: "gauge",
        about: "gauges anywhere in a wave of five cells: mean error of the level, over its height",
        feels: &["output.gauge_smoothing"],
        run: gauges,
    },
];

fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = numbers.fold((0.0, 0.0), |(sum, count), number| (sum + number, count + 1.0));
    sum / count
}

/// Terrain by a formula.
struct Formula<F: Fn(Vec2) -> f64 + Sync>(F);

impl<F: Fn(Vec2) -> f64 + Sync> Surface for Formula<F> {
    fn elevation(&self, map: Vec2) -> Option<f64> {
        Some((self.0)(map))
    }

    fn samples(&self, _: Vec2, _: f64, _: &mut Vec<(Vec2, f64)>) {}
}

fn body(ring: Vec<(f64, f64)>, level: f64) -> StillBody {
    StillBody { polygon: MultiPolygon(vec![Polygon::new(LineString::from(ring), Vec::new())]), level }
}

/// Fills a body on cells of 1 m from the origin on: the bed of the terrain, the cells whose bed was set, and the water.
fn fill(
    surface: &impl Surface,
    (columns, rows): (usize, usize),
    body: StillBody,
    constants: &Constants,
) -> (BedParticles, Vec<(usize, f64)>, StillWater) {
    let lattice = Lattice::new(Vec2::ZERO, columns, rows, 1.0);
    let bed = place_bed_with(surface, &lattice, (BedMethod::Mean, &constants.bed), &Nothing, 0.03);
    let (water, set) = fill_still_water(&[body], &bed, surface, Barriers::default(), &constants.seeding);
    (bed, set, water)
}

/// Bays of a lake behind a rim that is drawn straight: they reach 0 to 6 cells beyond it, and one valley leads out of the lake.
fn short_of_shore(constants: &Constants) -> f64 {
    let lake = |shift: f64| {
        let reach = |y: f64| 20.0 + 3.0 * (1.0 + (0.55 * y + shift).sin()) + 0.7 * (2.3 * y).sin();
        let ground = move |place: Vec2| {
            let is_valley = (place.y - 31.0).abs() < 1.5;
            if is_valley { -1.0 } else { place.x - reach(place.y) }
        };
        let rim = vec![(0.0, 2.0), (20.0, 2.0), (20.0, 58.0), (0.0, 58.0)];
        let floor = |place: Vec2| if (3.0..57.0).contains(&place.y) { ground(place).clamp(-4.0, 4.0) } else { 4.0 };
        let (bed, set, water) = fill(&Formula(floor), (40, 60), body(rim, 0.0), constants);
        let mut dry = 0.0;
        let mut all = 0.0;
        for cell in 0..bed.lattice.len() {
            let (column, row) = bed.lattice.column_row(cell);
            let is_of_lake = bed.elevation[cell] < -0.1 && (28..35).all(|valley| row != valley) && column < 30;
            let is_set = set.iter().any(|(other, _)| *other == cell);
            if is_of_lake {
                all += 1.0;
                dry += f64::from(u8::from(water.body[cell].is_none() && !is_set));
            }
        }
        dry / all
    };
    mean((0..6).map(|k| lake(f64::from(k))))
}

/// A rough valley that falls from west to east, with a lake of a length (m) whose dam is gone: mean change of the bed (m) in the ten cells before
/// its end, and the difference of its volume.
fn without_dam(constants: &Constants, length: f64) -> (f64, f64) {
    let ground = |place: Vec2| {
        let across = place.y - 12.0;
        0.02 * across * across - 0.05 * place.x + 0.3 * (1.3 * place.x).sin() * (1.7 * place.y).cos()
    };
    let rim = vec![(1.3, 0.2), (1.3 + length, 0.7), (1.3 + length, 23.4), (1.3, 23.8)];
    let (bed, set, water) = fill(&Formula(ground), (80, 24), body(rim, 0.2), constants);
    let end = 1.3 + length;
    let before = set.iter().filter(|(cell, _)| {
        let x = bed.lattice.centre(*cell).x;
        x < end && x > end - 10.0
    });
    let change = before.map(|(cell, z)| (z - bed.elevation[*cell]).abs()).sum::<f64>() / 240.0;
    (change, water.volumes[0].relative_error().abs())
}

/// A lake whose rim runs along a ditch two cells wide; a gap at one end of the ditch leads on. The share of the ditch that stays dry.
fn ditch(constants: &Constants) -> f64 {
    let ground = |place: Vec2| {
        let is_ditch = place.x < 22.0 && (8.0..20.0).contains(&place.y);
        let is_gap = (8.0..10.0).contains(&place.y);
        let is_lake = place.x < 20.0 && (2.0..28.0).contains(&place.y);
        if is_lake || is_ditch || is_gap { -1.0 } else { 2.0 }
    };
    let rim = vec![(0.0, 2.0), (20.0, 2.0), (20.0, 28.0), (0.0, 28.0)];
    let (bed, _, water) = fill(&Formula(ground), (40, 30), body(rim, 0.0), constants);
    let is_ditch = |cell: &usize| {
        let place = bed.lattice.centre(*cell);
        (20.0..22.0).contains(&place.x) && (10.0..20.0).contains(&place.y)
    };
    mean((0..bed.lattice.len()).filter(is_ditch).map(|cell| f64::from(u8::from(water.body[cell].is_none()))))
}

/// Mean error of the level at 64 places in a cell, of a wave of 1 m, five cells long.
fn gauges(constants: &Constants) -> f64 {
    let lattice = Lattice::new(Vec2::ZERO, 5, 5, 1.0);
    let place = |k: usize| Vec2::new(2.0 + ((k % 8) as f64 + 0.5) / 8.0, 2.0 + ((k / 8) as f64 + 0.5) / 8.0);
    let gauge = |k: usize| Gauge { id: k.to_string(), position: place(k), attributes: vec![] };
    let plan = RecorderPlan {
        bed_elevation: vec![0.0; lattice.len()],
        lattice: lattice.clone(),
        more_area: vec![],
        cell: 1.0,
        terrain: None,
        thresholds: vec![0.1],
        rise_on_wet: 0.1,
        every: 1.0,
        end_time: 1.0,
        gauges: (0..64).map(gauge).collect(),
        walls: vec![],
        raised: vec![],
        followed: Vec::new(),
        at_banks: vec![],
        constants: constants.output,
        gauges_every: 1.0,
        sections: vec![],
        closed_edge: vec![],
        tracers: vec![],
    };
    let level = |place: Vec2| 5.0 + (0.4 * std::f64::consts::PI * place.x).sin();
    let depth = (0..lattice.len()).map(|cell| level(lattice.centre(cell))).collect();
    let rows = FlatWater { depth, ..FlatWater::dry(&lattice) };
    let spans: Vec<Span> = (0..5).map(|row| Span { row, from: 0, to: 5 }).collect();
    let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
    let mut recorder = Recorder::new(plan);
    recorder.start(&water, Volumes::default(), &mut |_| Ok(())).unwrap();
    let results = recorder.finish().gauge_results;
    mean(results.iter().enumerate().map(|(k, result)| (result.max_level.unwrap() - level(place(k))).abs()))
}
