//! The experiments and floods, what each is held to, and what its measurements are.

use super::gauges::{Run, Series, arrival, asymmetry, listed, mean, mean_of, panel, root_mean_square, value_at};
use super::{Experiment, Finding, obstacle, rajar, wet_bed};
use crate::validation::Suite;

/// Every experiment, in the order of tables.
pub fn all() -> impl Iterator<Item = &'static Experiment> {
    EXPERIMENTS.iter()
}

/// The experiment of a name.
pub fn named(name: &str) -> Option<&'static Experiment> {
    all().find(|experiment| experiment.name == name)
}

const CHANNELS: &str = "it is about channels in one dimension, whose sections rest";

const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "isolated_obstacle",
        scenario: "laboratory/isolated_obstacle.yaml",
        suite: Suite::Laboratory,
        about: "Dam break against a building in a flume (test 6A of the Environment Agency), depths at six gauges of Soares-Frazão and Zech.",
        data: &["isolated_obstacle"],
        resolutions: [0.10, 0.05],
        rests_because: "",
        acceptance_limit: "mean RMSE of the depth <= 0.020 m",
        judge: |run| obstacle::judge(run, 1.0),
    },
    Experiment {
        name: "parma_partial_dam_break",
        scenario: "laboratory/parma_partial_dam_break.yaml",
        suite: Suite::Laboratory,
        about: "Dam break through a gap in a wall; no measurements, the front against the bound of Ritter.",
        data: &["parma_dbdb"],
        resolutions: [0.015, 0.0075],
        rests_because: "",
        acceptance_limit: "no front before that of Ritter",
        judge: parma,
    },
    Experiment {
        name: "marin_box",
        scenario: "laboratory/marin_box.yaml",
        suite: Suite::Laboratory,
        about: "Dam break onto a box (Kleefsman et al.), levels in the reservoir and arrival before the box; behind and at the box the flow is three-dimensional.",
        data: &["kleefsman_marin"],
        resolutions: [0.02, 0.01],
        rests_because: "",
        acceptance_limit: "",
        judge: marin,
    },
    Experiment {
        name: "ea_test1",
        scenario: "laboratory/ea_test1.yaml",
        suite: Suite::Laboratory,
        about: "A level that rises over a sill and falls again leaves a pond at the level of the sill (test 1 of the Environment Agency).",
        data: &["ea_test1"],
        resolutions: [20.0, 10.0],
        rests_because: "",
        acceptance_limit: "final levels within 0.02 m of the sill",
        judge: disconnected,
    },
    Experiment {
        name: "ea_test4",
        scenario: "laboratory/ea_test4.yaml",
        suite: Suite::Laboratory,
        about: "A flood spreads over a dry plain (test 4 of the Environment Agency): symmetry, and arrival against published fronts.",
        data: &["ea_test4"],
        resolutions: [20.0, 10.0],
        rests_because: "",
        acceptance_limit: "front symmetric within 1 % in every cell; arrival at P5 within 5 % of the published 1.0 to 1.2 h",
        judge: plain,
    },
    Experiment {
        name: "ea_test6b",
        scenario: "laboratory/ea_test6b.yaml",
        suite: Suite::Laboratory,
        about: "The isolated obstacle twenty times as large and rougher (test 6B of the Environment Agency), against the scaled measurements.",
        data: &["isolated_obstacle", "ea_test6b"],
        resolutions: [2.0, 1.0],
        rests_because: "",
        acceptance_limit: "mean RMSE of the depth <= 0.40 m",
        judge: |run| obstacle::judge(run, obstacle::SCALE),
    },
    Experiment {
        name: "ea_test6b_scaled",
        scenario: "laboratory/ea_test6b_scaled.yaml",
        suite: Suite::Laboratory,
        about: "The isolated obstacle twenty times as large, as rough as the flume by the law of Froude: against the scaled measurements, and against the run of the flume itself.",
        data: &["isolated_obstacle", "ea_test6b"],
        resolutions: [2.0, 1.0],
        rests_because: "",
        acceptance_limit: "mean RMSE of the depth <= 0.40 m; depths those of the flume times 20 within 0.04 m on average",
        judge: obstacle::judge_scaled,
    },
    Experiment {
        name: "radial_dam_break",
        scenario: "laboratory/radial_dam_break.yaml",
        suite: Suite::Laboratory,
        about: "A round column of water collapses over a wet bed; levels, speeds and fluxes along its axis against a computation on a grid eight times as fine.",
        data: &["radial_dam_break"],
        resolutions: [2.0, 1.0],
        rests_because: "",
        acceptance_limit: "levels within 3 %, speeds and fluxes within 10 % of the reference on average",
        judge: wet_bed::judge,
    },
    Experiment {
        name: "monai_valley",
        scenario: "laboratory/monai_valley.yaml",
        suite: Suite::Laboratory,
        about: "A wave runs up a valley (Okushiri 1993 in a flume), levels at three gauges.",
        data: &["monai_valley"],
        resolutions: [0.028, 0.014],
        rests_because: "",
        acceptance_limit: "RMSE of the level up to 25 s <= 0.006 m at each gauge",
        judge: monai,
    },
    Experiment {
        name: "rajar_a",
        scenario: "laboratory/rajar_a.yaml",
        suite: Suite::Laboratory,
        about: "Dam break in a channel that widens from 0.4 m to 1.2 m (Rajar's channel A): reaches in one dimension joined to two, against two throughout.",
        data: &[],
        resolutions: [0.05, 0.025],
        rests_because: CHANNELS,
        acceptance_limit: "coupled within 5 % of two dimensions, at least 40 % of the CPU time saved",
        judge: |run| rajar::compare(run, &rajar::A),
    },
    Experiment {
        name: "rajar_b",
        scenario: "laboratory/rajar_b.yaml",
        suite: Suite::Laboratory,
        about: "The same in a channel that narrows to 0.2 m (Rajar's channel B).",
        data: &[],
        resolutions: [0.05, 0.025],
        rests_because: CHANNELS,
        acceptance_limit: "coupled within 5 % of two dimensions, at least 40 % of the CPU time saved",
        judge: |run| rajar::compare(run, &rajar::B),
    },
    Experiment {
        name: "merewether",
        scenario: "laboratory/merewether.yaml",
        suite: Suite::Field,
        about: "The flood of 8 June 2007 between the houses of Merewether, five surveyed marks.",
        data: &["merewether"],
        resolutions: [2.0, 1.0],
        rests_because: "",
        acceptance_limit: "mean absolute error at five marks <= 0.15 m",
        judge: merewether,
    },
    Experiment {
        name: "malpasset",
        scenario: "malpasset/scenario.yaml",
        suite: Suite::Field,
        about: "The dam break of Malpasset 1959: arrival at nine gauges of a scale model and three transformers, greatest levels there and at marks of the police.",
        data: &["malpasset"],
        resolutions: [40.0, 20.0],
        rests_because: "",
        acceptance_limit: "mean absolute error of arrival at S6 to S14 <= 40 s, of the greatest level <= 2.6 m; transformers within 5 %",
        judge: malpasset,
    },
];

fn parma(run: &Run) -> Result<Finding, String> {
    /// Place of the wall (m), depth behind it (m) and gravity (m/s²).
    const WALL: f64 = 0.8;
    const DEPTH: f64 = 0.15;
    let fastest = 2.0 * (crate::scenario::GRAVITY * DEPTH).sqrt();
    let (mut notes, mut panels, mut is_met) = (Vec::new(), Vec::new(), true);
    let mut arrivals = Vec::new();
    for (gauge, x) in [("A10", 0.9), ("A20", 1.0), ("A40", 1.2), ("A80", 1.6), ("A120", 2.0)] {
        let arrival = run.result(gauge, "arrival_s")?;
        let bound = (x - WALL) / fastest;
        is_met &= arrival.is_some_and(|arrival| arrival >= bound);
        let found = arrival.map_or("never".to_owned(), |arrival| format!("{arrival:.3}"));
        notes.push(format!("{gauge} {found} ({bound:.3})"));
        arrivals.extend(arrival.map(|arrival| (x, arrival)));
        panels.push(panel(run, gauge, Vec::new(), run.series(gauge, "depth_m")?));
    }
    let speed = match (arrivals.first(), arrivals.last()) {
        (Some(a), Some(b)) if b.1 > a.1 => (b.0 - a.0) / (b.1 - a.1),
        _ => f64::NAN,
    };
    let note = format!(
        "arrival of 1 mm in s (front of Ritter): {}; front {speed:.2} m/s on average, Ritter {fastest:.2}",
        listed(&notes)
    );
    Ok(Finding { norm: "none", error: None, is_met: Some(is_met), note, panels })
}

fn marin(run: &Run) -> Result<Finding, String> {
    let gauges = [("H1", "h_x0496_m"), ("H2", "h_x0992_m"), ("H3", "h_x1488_m"), ("H4", "h_x2638_m")];
    let (mut notes, mut panels, mut reservoir) = (Vec::new(), Vec::new(), None);
    for (gauge, column) in gauges {
        let measured = run.measured("observed_levels.csv", "t_s", column)?;
        let computed = run.series(gauge, "depth_m")?;
        match gauge {
            "H4" => reservoir = root_mean_square(&computed, &measured, (0.0, 6.0)),
            // The table of the experiment has a row each 0.05 s; these times are those of its source at 1 kHz.
            "H3" | "H2" => {
                let seen = if gauge == "H3" { 0.194 } else { 0.358 };
                let found = arrival(&computed, 0.01).map_or("never".to_owned(), |time| format!("{time:.2}"));
                notes.push(format!("{gauge} {found} ({seen})"));
            }
            _ => {}
        }
        panels.push(panel(run, gauge, measured, computed));
    }
    let early = panels.last().and_then(|last| {
        let computed = last.computed.first()?;
        root_mean_square(&computed.points, &last.measured, (0.0, 2.5))
    });
    let note = format!(
        "RMSE at H4 alone, {:.4} m before the wave returns at 2.5 s; arrival of 1 cm in s (measured): {}",
        early.unwrap_or(f64::NAN),
        listed(&notes)
    );
    Ok(Finding { norm: "rmse_h4", error: reservoir, is_met: None, note, panels })
}

fn disconnected(run: &Run) -> Result<Finding, String> {
    let (mut notes, mut panels, mut worst) = (Vec::new(), Vec::new(), 0.0_f64);
    for gauge in ["P1", "P2"] {
        let bed = run.result(gauge, "bed_m")?.ok_or("the gauge has no bed")?;
        let computed: Series = run.series(gauge, "depth_m")?.into_iter().map(|(t, d)| (t, bed + d)).collect();
        let last = computed.last().map_or(f64::NAN, |point| point.1);
        let greatest = computed.iter().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
        let (level, peak) = (run.mark(gauge, "final_level_m")?, run.mark(gauge, "observed_max_level_m")?);
        worst = if last.is_finite() { worst.max((last - level).abs()) } else { f64::INFINITY };
        notes.push(format!("{gauge} {last:.3} ({level}) in the end, {greatest:.3} ({peak}) at most"));
        panels.push(panel(run, gauge, vec![(36_000.0, peak), (72_000.0, level)], computed));
    }
    Ok(Finding {
        norm: "max_abs_gauges",
        error: Some(worst),
        is_met: Some(worst <= 0.02),
        note: format!("level in m (expected): {}", listed(&notes)),
        panels,
    })
}

fn plain(run: &Run) -> Result<Finding, String> {
    let (mut notes, mut panels) = (Vec::new(), Vec::new());
    for gauge in ["P1", "P2", "P3", "P4", "P5", "P6"] {
        let found = run.result(gauge, "arrival_s")?;
        notes.push(format!("{gauge} {}", found.map_or("never".to_owned(), |time| format!("{:.3}", time / 3600.0))));
        let computed = run.series(gauge, "depth_m")?;
        let published = if gauge == "P1" { vec![(3600.0, 0.22), (10_800.0, 0.25)] } else { Vec::new() };
        panels.push(panel(run, gauge, published, computed));
    }
    // The inflow stands in the middle of the western side.
    let [apart, _] = asymmetry(&run.map("arrival_time")?);
    let [deeper, on_average] = asymmetry(&run.map("max_depth")?);
    let front = run.result("P5", "arrival_s")?.unwrap_or(f64::INFINITY) / 3600.0;
    let first = panels.first().and_then(|panel| panel.computed.first());
    let at = |time: f64| first.and_then(|line| value_at(&line.points, time)).unwrap_or(f64::NAN);
    let note = format!(
        "arrival of 1 cm in h: {}; maps and their mirror images: arrival {apart:.1e} apart at most, greatest depth {deeper:.1e} ({on_average:.1e} on average); depth at P1 in m (published) {:.3} (0.22) at 1 h, {:.3} (0.25) at 3 h",
        listed(&notes),
        at(3600.0),
        at(10_800.0)
    );
    let is_met = apart <= 0.01 && (0.95..=1.05 * 1.2).contains(&front);
    Ok(Finding { norm: "none", error: None, is_met: Some(is_met), note, panels })
}

fn monai(run: &Run) -> Result<Finding, String> {
    /// End of the comparison (s).
    const END: f64 = 25.0;
    let (mut errors, mut notes, mut panels) = (Vec::new(), Vec::new(), Vec::new());
    for gauge in ["ch5", "ch7", "ch9"] {
        let measured = run.measured("observed_levels.csv", "time_s", &format!("{gauge}_m"))?;
        let measured: Series = measured.into_iter().filter(|(time, _)| *time <= END).collect();
        let bed = run.result(gauge, "bed_m")?.ok_or("the gauge has no bed")?;
        let computed: Series = run.series(gauge, "depth_m")?.into_iter().map(|(t, d)| (t, bed + d)).collect();
        let error = root_mean_square(&computed, &measured, (0.0, END)).ok_or("no measurements")?;
        let highest = |series: &Series| series.iter().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
        notes.push(format!("{gauge} {error:.4}, peak {:.4} ({:.4})", highest(&computed), highest(&measured)));
        errors.push(error);
        panels.push(panel(run, gauge, measured, computed));
    }
    Ok(Finding {
        norm: "rmse_gauges",
        error: Some(mean_of(&errors)),
        is_met: Some(errors.iter().all(|error| *error <= 0.006)),
        note: format!("RMSE and peaks in m (measured): {}", listed(&notes)),
        panels,
    })
}

fn merewether(run: &Run) -> Result<Finding, String> {
    let (mut errors, mut of_reached, mut notes, mut panels) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for gauge in ["obs0", "obs1", "obs2", "obs3", "obs4"] {
        let mark = run.mark(gauge, "observed_max_level_m")?;
        let bed = run.result(gauge, "bed_m")?.ok_or("the gauge has no bed")?;
        let computed: Series = run.series(gauge, "depth_m")?.into_iter().map(|(t, d)| (t, bed + d)).collect();
        let steady = mean(&computed, (900.0, 1000.0));
        let found = run.result(gauge, "max_level_m")?.unwrap_or(bed);
        let depth = run.result(gauge, "max_depth_m")?.unwrap_or(0.0);
        errors.push((found - mark).abs());
        // Where the water never arrives it is the bed that is compared with the mark.
        of_reached.extend(run.result(gauge, "arrival_s")?.map(|_| (found - mark).abs()));
        notes.push(format!("{gauge} {found:.2} ({mark}), bed {bed:.2}, {depth:.4} deep, {steady:.2} in the end"));
        panels.push(panel(run, gauge, vec![(0.0, mark), (1000.0, mark)], computed));
    }
    let error = mean_of(&errors);
    Ok(Finding {
        norm: "mean_abs_marks",
        error: Some(error),
        is_met: Some(error <= 0.15),
        note: format!(
            "mean of the {} marks that 1 cm of water reaches {:.3} m; highest level in m (mark): {}",
            of_reached.len(),
            mean_of(&of_reached),
            listed(&notes)
        ),
        panels,
    })
}

fn malpasset(run: &Run) -> Result<Finding, String> {
    let (mut late, mut relative, mut notes, mut panels) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let arrival = |gauge: &str| -> Result<(f64, f64), String> {
        let found = run.result(gauge, "arrival_s")?.unwrap_or(f64::INFINITY);
        Ok((found, run.mark(gauge, "observed_arrival_s")?))
    };
    for gauge in ["A", "B", "C"] {
        let (found, seen) = arrival(gauge)?;
        relative.push(found / seen - 1.0);
        notes.push(format!("{gauge} {found:.0} ({seen})"));
    }
    let mut high = Vec::new();
    for gauge in ["S6", "S7", "S8", "S9", "S10", "S11", "S12", "S13", "S14"] {
        let (found, seen) = arrival(gauge)?;
        late.push((found - seen).abs());
        notes.push(format!("{gauge} {found:.0} ({seen})"));
        let mark = run.mark(gauge, "observed_max_level_m")?;
        let bed = run.result(gauge, "bed_m")?.ok_or("the gauge has no bed")?;
        high.push((run.result(gauge, "max_level_m")?.unwrap_or(bed) - mark).abs());
        let computed: Series = run.series(gauge, "depth_m")?.into_iter().map(|(t, d)| (t, bed + d)).collect();
        panels.push(panel(run, gauge, vec![(seen, bed), (seen, mark), (4000.0, mark)], computed));
    }
    let mut marks = Vec::new();
    for gauge in (1..=17).map(|number| format!("P{number}")) {
        let mark = run.mark(&gauge, "observed_max_level_m")?;
        let bed = run.result(&gauge, "bed_m")?.ok_or("the gauge has no bed")?;
        // A mark below the ground of the raster cannot be met.
        if bed < mark {
            marks.push((run.result(&gauge, "max_level_m")?.unwrap_or(bed) - mark).abs());
        }
    }
    let (late, high) = (mean_of(&late), mean_of(&high));
    let is_met = late <= 40.0 && high <= 2.6 && relative.iter().all(|error| error.abs() <= 0.05);
    let note = format!(
        "mean absolute error of arrival {late:.0} s, of the greatest level at S6 to S14 {high:.2} m, at {} marks of the police {:.2} m; arrival in s (observed): {}",
        marks.len(),
        mean_of(&marks),
        listed(&notes)
    );
    Ok(Finding { norm: "mean_abs_gauges", error: Some(high), is_met: Some(is_met), note, panels })
}
