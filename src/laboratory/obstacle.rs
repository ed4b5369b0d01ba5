//! The building in a flume of Soares-Frazão and Zech (`SoaresFrazao2007`), and the same at the scale of the field.
//!
//! ```text
//! levels · S,   times · √S,   n · S^(1/6)
//! ```
//!
//! With these, after Froude, and with every depth of the method scaled too, the equations of the flume and of a scene S times as large are the same.

use super::Finding;
use super::gauges::{Run, Series, arrival, listed, mean_of, panel, root_mean_square, value_at};
use crate::pipeline::{self, RunOptions};
use crate::scenario::load;

/// How much larger the scene of test 6B is.
pub(super) const SCALE: f64 = 20.0;
/// Mean RMSE of the depths (m) that the flume is held to.
const BAR: f64 = 0.020;
/// Mean RMSE (m, of the flume) between the scene at its scale and the flume: a tenth of what either may be off. Their beds are rasters of 0.4 m and
/// 0.5 m at the scale of the field, and so not the same.
const SAME: f64 = 0.002;
/// Duration of the measurements (s).
const DURATION: f64 = 30.0;
const GAUGES: [&str; 6] = ["G1", "G2", "G3", "G4", "G5", "G6"];

/// Depths at the gauges against the measurements, larger by `scale` after Froude.
pub(super) fn judge(run: &Run, scale: f64) -> Result<Finding, String> {
    let window = (0.0, DURATION * scale.sqrt());
    let (mut errors, mut notes, mut arrivals, mut panels) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for gauge in GAUGES {
        let measured = run.measured("observed_depth.csv", "time_s", &format!("{gauge}_depth_m"))?;
        let measured: Series = measured.into_iter().map(|(t, d)| (t * scale.sqrt(), d * scale)).collect();
        let computed = run.series(gauge, "depth_m")?;
        let error = root_mean_square(&computed, &measured, window).ok_or("no measurements")?;
        notes.push(format!("{gauge} {error:.3}"));
        errors.push(error);
        if let (Some(found), Some(seen)) = (arrival(&computed, 0.005 * scale), arrival(&measured, 0.005 * scale))
            && gauge != "G6"
        {
            arrivals.push(format!("{gauge} {found:.2} ({seen:.2})"));
        }
        let computed = computed.into_iter().filter(|(time, _)| *time <= window.1).collect();
        panels.push(panel(run, gauge, measured, computed));
    }
    let error = mean_of(&errors);
    Ok(Finding {
        norm: "rmse_gauges",
        error: Some(error),
        is_met: Some(error <= BAR * scale),
        note: format!("RMSE in m: {}; arrival in s (measured): {}", listed(&notes), listed(&arrivals)),
        panels,
    })
}

/// The same for the scene at the scale of the field, and its depths against those of the flume at the same number of cells.
pub(super) fn judge_scaled(run: &Run) -> Result<Finding, String> {
    let finding = judge(run, SCALE)?;
    let flume = flume(run)?;
    let mut differences = Vec::new();
    for gauge in GAUGES {
        let large = run.series(gauge, "depth_m")?;
        let small = flume.series(gauge, "depth_m")?;
        let scaled: Series = small.into_iter().map(|(t, d)| (t * SCALE.sqrt(), d * SCALE)).collect();
        let times = scaled.iter().map(|&(time, depth)| Some(value_at(&large, time)? - depth));
        let squares: Option<Vec<f64>> = times.map(|difference| difference.map(|d| d * d)).collect();
        differences.push(mean_of(&squares.ok_or("the run has no depths")?).sqrt());
    }
    let apart = mean_of(&differences);
    let notes: Vec<String> =
        GAUGES.iter().zip(&differences).map(|(gauge, apart)| format!("{gauge} {apart:.4}")).collect();
    Ok(Finding {
        is_met: Some(finding.is_met == Some(true) && apart <= SAME * SCALE),
        note: format!("{}; RMSE from the flume times 20 in m: {apart:.4} on average, {}", finding.note, listed(&notes)),
        ..finding
    })
}

/// Runs the flume with the methods and the number of cells of a run of the larger scene.
fn flume(run: &Run) -> Result<Run, String> {
    let scenario = run.scenarios.join("laboratory/isolated_obstacle.yaml");
    let spacing = run.spacing / SCALE;
    let methods = run.overrides.iter().filter(|given| !given.starts_with("resolution=")).cloned();
    let overrides: Vec<String> = std::iter::once(format!("resolution={spacing} m")).chain(methods).collect();
    let folder = run.folder.join("flume");
    let options = RunOptions {
        out: Some(folder.clone()),
        threads: Some(1),
        overwrite: true,
        quiet: true,
        command: "floodsim validate ea_test6b_scaled".to_owned(),
        overrides: Vec::new(),
    };
    let loaded = load(&scenario, &overrides).map_err(|error| error.to_string())?;
    pipeline::run(&loaded.scenario, &options).map_err(|error| error.to_string())?;
    Ok(Run { folder, scenarios: run.scenarios.clone(), data: run.data.clone(), spacing, overrides })
}
