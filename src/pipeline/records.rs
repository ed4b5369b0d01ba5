//! What a run writes down about itself: the volume balance, inflow and outflow, the breach, the manifest before the first step.

use std::collections::BTreeMap;

use super::origin::Origin;
use crate::bed::BedParticles;
use crate::gate::Gate;
use crate::math::{Vec2, simd};
use crate::output::{
    BanksRecord, BreachRecord, CellsInPartRecord, ChannelWater, DischargeRecord, HotStart, LevelRecord,
    MovingBedRecord, PassageRecord, RunManifest, StillWaterRecord, TracerBalance, TracerPlan, Volumes, WarningRecord,
};
use crate::prepare::{Scene, Setup, StillBody};
use crate::scenario::Scenario;
use crate::seeding::SeededVolume;
use crate::solver::{BedMotion, Breach, ChannelSample, FlowSolver, GrowthLaw, Opening, Passage, TracerLedger, Way};
use crate::version;

/// Share of the discharge that may be carried by particles in doubt (M85) before a run says so; real floods on fit lattices have up to 0.03.
const IN_DOUBT_TOLERANCE: f64 = 0.1;

/// The volume balance of the core, as the recorder takes them.
pub(super) fn balance(solver: &dyn FlowSolver) -> Volumes {
    let ledger = solver.ledger();
    Volumes {
        stored: ledger.stored,
        in_channels: solver.volume_in_channels(),
        inflow: ledger.inflow,
        outflow: ledger.outflow,
        error_relative: ledger.relative_error(),
    }
}

/// Inflow and outflow by each way, by the names of the scenario.
pub(super) fn passages(solver: &dyn FlowSolver, scenario: &Scenario, scene: &Scene) -> Vec<PassageRecord> {
    let channel = |index: usize| scene.channels.get(index).map_or("", |channel| channel.id.as_str());
    let name = |way: Way| match way {
        Way::OpenEdges => "open edges".to_owned(),
        Way::Boundary(index) => scenario.boundaries.get(index).map_or_else(String::new, |known| known.key.clone()),
        Way::Source(index) => {
            let source = scene.forcing.sources.get(index);
            let place = source.map_or(Vec2::ZERO, |source| scene.lattice.to_map(source.place));
            format!("source at {:.2} {:.2}", place.x, place.y)
        }
        Way::LineSource(index) => {
            scene.forcing.line_sources.get(index).map_or_else(String::new, |source| source.name.clone())
        }
        Way::Rain => "rain".to_owned(),
        Way::FarEnd(index) => format!("channel {} upstream", channel(index)),
        Way::NearEnd(index) => format!("channel {} downstream", channel(index)),
    };
    let record = |passage: &Passage| PassageRecord {
        name: name(passage.way),
        in_m3: passage.inflow,
        out_m3: passage.outflow,
        asked_m3: passage.asked,
    };
    solver.passages().iter().map(record).collect()
}

/// The balance of each tracer now.
pub(super) fn tracer_balances(solver: &dyn FlowSolver, tracers: &[TracerPlan]) -> Vec<TracerBalance> {
    let balance = |(tracer, ledger): (&TracerPlan, &TracerLedger)| TracerBalance {
        name: tracer.name.clone(),
        unit: if tracer.unit == "1" { "m3".to_owned() } else { format!("{} m3", tracer.unit) },
        time_s: solver.time(),
        initial: ledger.initial,
        inflow: ledger.inflow,
        outflow: ledger.outflow,
        decayed: ledger.decayed,
        stored: ledger.stored,
        error_relative: ledger.relative_error(),
    };
    let ledgers = if tracers.is_empty() { Vec::new() } else { solver.tracers() };
    tracers.iter().zip(&ledgers).map(balance).collect()
}

/// The water of the channels, as their recorder takes it.
pub(super) fn in_channels(solver: &dyn FlowSolver) -> Vec<Vec<ChannelWater>> {
    let water = |sample: &ChannelSample| ChannelWater {
        depth: sample.depth,
        level: sample.level,
        velocity: sample.velocity,
        discharge: sample.discharge,
    };
    solver.channels().iter().map(|channel| channel.iter().map(water).collect()).collect()
}

/// The bodies of still water at the start.
pub(super) fn still_water_records(waters: &[StillBody], seeded: &[SeededVolume]) -> Vec<StillWaterRecord> {
    let record = |(water, volume): (&StillBody, &SeededVolume)| StillWaterRecord {
        name: water.key.clone(),
        level_m: water.level,
        integral_m3: volume.integral_m3,
        at_edge_m3: volume.at_edge_m3,
        at_banks_m3: volume.at_banks_m3,
        seeded_m3: volume.seeded_m3,
    };
    waters.iter().zip(seeded).map(record).collect()
}

/// The breach and when it began, for the record.
pub(super) fn breach_record(breach: &Breach, began: Option<f64>) -> BreachRecord {
    let (invert, width, slope) = match breach.opening {
        Opening::Whole => (None, None, None),
        Opening::Trapezoid { invert, bottom_width, side_slope, .. } => {
            (Some(invert), Some(bottom_width), Some(side_slope))
        }
    };
    BreachRecord {
        began_s: began,
        crest_m: breach.crest,
        invert_m: invert,
        bottom_width_m: width,
        side_slope: slope,
        duration_s: if breach.law == GrowthLaw::Instantaneous { 0.0 } else { breach.duration },
    }
}

/// The gate of the discharges of particles: it reports and fails no run, because where they differ is for the planner to judge.
pub(super) fn gate_of_discharges(record: &DischargeRecord) -> Gate {
    let worst = record.worst.map_or(String::new(), |worst| {
        format!(
            "most at {:.1}, {:.1} after {:.0} s, {:.3} m2/s beside {:.3} m2/s",
            worst.x, worst.y, worst.time_s, worst.own_m2_s, worst.at_faces_m2_s
        )
    });
    let name = "share of the discharge of particles that differs from that of their faces by more than half";
    Gate { binding: false, note: worst, ..Gate::binding(name, record.in_doubt_relative, IN_DOUBT_TOLERANCE) }
}

/// The cells in part of a bed; nothing where all are whole.
fn cells_in_part(bed: &BedParticles) -> Option<CellsInPartRecord> {
    let cells = bed.cover.cells();
    let areas = || cells.iter().map(|part| part.area);
    let record = || CellsInPartRecord {
        cells: cells.len(),
        least: areas().fold(f64::INFINITY, f64::min),
        greatest: areas().fold(0.0, f64::max),
    };
    (!cells.is_empty()).then(record)
}

/// The banks (map coordinates) that cells follow; nothing where they follow none.
fn banks(lines: &[Vec<Vec2>]) -> Option<BanksRecord> {
    let length = |line: &Vec<Vec2>| line.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum::<f64>();
    let record = || BanksRecord { lines: lines.len(), length_m: lines.iter().map(length).sum() };
    (!lines.is_empty()).then(record)
}

/// When the bed began to move and the volumes that it moved; nothing where it does not.
pub(super) fn moving_bed_record(motions: &[BedMotion], solver: &dyn FlowSolver) -> Option<MovingBedRecord> {
    let began_s = motions.iter().map(|motion| motion.begin).fold(f64::INFINITY, f64::min);
    solver.bed_balance().map(|balance| MovingBedRecord {
        began_s,
        raised_m3: balance.raised,
        sunk_m3: balance.sunk,
        lifted_m3: balance.lifted,
        lowered_m3: balance.lowered,
    })
}

/// What is known of the run before its first step.
pub(super) fn first_manifest(
    scenario: &Scenario,
    origin: &Origin,
    warnings: &[crate::error::Problem],
    (setup, levels): (&Setup, Vec<LevelRecord>),
) -> RunManifest {
    let hot_start = scenario
        .start
        .earlier
        .as_ref()
        .map(|earlier| HotStart { path: earlier.fields.value.display().to_string(), time_s: setup.scene.earlier_time });
    RunManifest {
        hot_start,
        version: version::VERSION.to_owned(),
        git: (version::COMMIT != "unknown").then(|| version::COMMIT.to_owned()),
        command: origin.command.clone(),
        threads: rayon::current_num_threads(),
        simd: simd().to_owned(),
        scenario_sha256: origin.scenario_sha256.clone(),
        inputs: origin.inputs.clone(),
        warnings: warnings.iter().map(WarningRecord::from).collect(),
        methods: scenario.numerics.acting().into_iter().map(|(family, name)| (family.to_owned(), name)).collect(),
        bed_particles: setup.bed.elevation.iter().filter(|z| !z.is_nan()).count(),
        levels,
        cells_in_part: cells_in_part(&setup.bed),
        banks: banks(&setup.scene.banks),
        not_written: scenario.outputs.left_out().map(|part| part.name().to_owned()).collect(),
        status: "running".to_owned(),
        phase_s: BTreeMap::new(),
        ..RunManifest::default()
    }
}
