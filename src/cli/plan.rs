//! `floodsim plan`: what a run will need, for people or as JSON.

use std::ops::Range;

use serde_json::{Value, json};

use super::Stages;
use super::args::PlanArguments;
use super::check::{findings, listing};
use crate::error::{Error, ExitCode, Problem, sort_problems};
use crate::math::readable;
use crate::output::{ChoiceRecord, LevelRecord};
use crate::pipeline::{Advice, Plan, PlanOptions};
use crate::scenario;

/// Plans a run and prints what it will need; problems come as `check` gives them, with the exit code of a run that stops at them.
pub fn plan(arguments: &PlanArguments, stages: &Stages) -> ExitCode {
    let file = arguments.scenario.display().to_string();
    let (warnings, result) = match scenario::load(&arguments.scenario, &arguments.overrides) {
        Ok(loaded) => {
            let threads = arguments.threads.map(std::num::NonZero::get);
            let options = PlanOptions { threads, layer: arguments.layer.clone() };
            (loaded.warnings, (stages.plan)(&loaded.scenario, &options))
        }
        Err(error) => (Vec::new(), Err(error)),
    };
    let printed = match result {
        Ok(mut plan) => {
            plan.warnings.splice(0..0, warnings);
            let text = if arguments.json { format!("{:#}\n", as_json(&file, &plan)) } else { as_text(&file, &plan) };
            super::print(&text)
        }
        Err(Error::Problems(problems)) => {
            let mut all: Vec<Problem> = warnings.into_iter().chain(problems).collect();
            sort_problems(&mut all);
            return match super::print(&listing(&file, &all, arguments.json)) {
                Ok(()) => Error::Problems(all).exit_code(),
                Err(error) => super::exit_code(Err(error)),
            };
        }
        Err(other) => Err(other),
    };
    super::exit_code(printed)
}

fn as_json(file: &str, plan: &Plan) -> Value {
    let range = |range: &Range<f64>| json!([range.start, range.end]);
    let measured = &plan.measured;
    let mut json = json!({
        "scenario": file,
        "particles": {"bed": plan.bed_particles, "channels": plan.channel_particles, "initial": plan.particles_at_start, "peak": range(&plan.particles_at_most)},
        "area_m2": range(&plan.area),
        "memory_mb": range(&plan.memory_mib),
        "steps": range(&plan.steps),
        "run_time_s": range(&plan.run_time),
        "disk_mb": range(&plan.disk_mb),
        "disk_on_the_way_mb": range(&plan.disk_on_the_way_mb),
        "resolution_m": range(&plan.resolution),
        "motion": {"chosen": plan.motion.name(), "advised": plan.advice.motion.name(), "why": plan.advice.why},
        "measured": {
            "preparation_s": measured.preparation,
            "steps": measured.steps,
            "simulated_s": measured.simulated,
            "wall_s": measured.seconds,
            "particle_evaluations": measured.evaluations,
            "whole_run": measured.is_whole,
            "look_m": plan.look,
        },
        "threads": plan.threads,
        "problems": findings(&plan.warnings),
    });
    if let Some(choice) = &plan.choice {
        json["choice"] = json!(choice);
    }
    if let Some(part) = &plan.part {
        json["terrain_part"] = json!(part);
    }
    if !plan.levels.is_empty() {
        json["levels"] = json!(plan.levels);
    }
    json
}

/// Why the program chose the lengths, a reason a line; nothing where the scenario has them.
fn choice(choice: Option<&ChoiceRecord>) -> String {
    let because = choice.map(|choice| choice.because.as_slice()).unwrap_or_default();
    let line = |(number, reason): (usize, &String)| {
        let head = if number == 0 { "auto         " } else { "             " };
        format!("{head}{reason}\n")
    };
    because.iter().enumerate().map(line).collect()
}

/// The levels, one a line, with their share of the cost and why they stand where they do; nothing of one spacing everywhere.
fn levels(levels: &[LevelRecord]) -> String {
    let all: f64 = levels.iter().map(|level| level.expected_evaluations).sum();
    let line = |(number, level): (usize, &LevelRecord)| {
        let mut reasons: Vec<(&&str, &f64)> = level.area_m2.iter().collect();
        reasons.sort_by(|one, other| other.1.total_cmp(one.1));
        let reasons: Vec<String> =
            reasons.iter().map(|(because, size)| format!("{because} {}", area(**size))).collect();
        format!(
            "{}{} m: {} particles, {:.0} with water at most, {:.0} steps, {:.2e} evaluations ({:.0} %), {:.0} MiB; {}\n",
            if number == 0 { "levels       " } else { "             " },
            readable(level.spacing_m),
            level.cells,
            level.expected_wet_cells,
            level.expected_steps,
            level.expected_evaluations,
            100.0 * level.expected_evaluations / all.max(1.0),
            level.memory_mib,
            reasons.join(", "),
        )
    };
    levels.iter().enumerate().map(line).collect()
}

fn as_text(file: &str, plan: &Plan) -> String {
    let measured = &plan.measured;
    let range = |range: &Range<f64>, form: fn(f64) -> String| {
        let (low, high) = (form(range.start), form(range.end));
        if low == high { low } else { format!("{low} to {high}") }
    };
    let rate = measured.evaluations as f64 / measured.seconds.max(f64::MIN_POSITIVE) / 1e6;
    let basis = match plan.look {
        _ if measured.is_whole => "the whole run was measured".to_owned(),
        Some(spacing) => format!("by a run on cells of {} m", readable(spacing)),
        None => "between no growth and all below the levels".to_owned(),
    };
    let channels =
        if plan.channel_particles > 0 { format!(", {} in channels", plan.channel_particles) } else { String::new() };
    let Advice { motion: advised, why } = &plan.advice;
    let agrees = if *advised == plan.motion { "as the scenario says" } else { "which the scenario does not" };
    let warnings: String = plan.warnings.iter().map(|problem| format!("{problem}\n")).collect();
    format!(
        "{warnings}{file}\n\
         particles    {} riverbed{channels}, {} with water at the start, {} at most\n\
         flooded      {}\n\
         memory       {} MiB\n\
         steps        {}\n\
         run time     {} on {} threads ({basis})\n\
         disk         {} MB, up to {} MB on the way\n\
         resolution   {} m in the flooded area\n\
         {}{}{}\
         motion       would take {}, {agrees}: {why}\n\
         measured     {} steps, {:.3} s simulated, in {:.2} s: {rate:.2} million particle evaluations a second; inputs {:.2} s\n",
        plan.bed_particles,
        plan.particles_at_start,
        range(&plan.particles_at_most, whole),
        range(&plan.area, area),
        range(&plan.memory_mib, whole),
        range(&plan.steps, whole),
        range(&plan.run_time, duration),
        plan.threads,
        range(&plan.disk_mb, |size| format!("{size:.1}")),
        format_args!("{:.1}", plan.disk_on_the_way_mb.end),
        range(&plan.resolution, |length| format!("{length:.3}")),
        plan.part.as_ref().map(|part| format!("terrain      {part}\n")).unwrap_or_default(),
        choice(plan.choice.as_ref()),
        levels(&plan.levels),
        advised.name(),
        measured.steps,
        measured.simulated,
        measured.seconds,
        measured.preparation,
    )
}

fn whole(value: f64) -> String {
    format!("{value:.0}")
}

/// An area (m²) in the unit that people use for it.
fn area(square_metres: f64) -> String {
    if square_metres < 1e5 { format!("{square_metres:.2} m2") } else { format!("{:.3} km2", square_metres / 1e6) }
}

/// A time (s) in the unit that people use for it.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
