//! What a run warns of at its end: water at closed edges, a flood that still grows, rain that runs off nowhere.

use super::Run;
use super::edges::reached;
use super::progress::clock_time;
use crate::error::{Problem, ProblemKind, input_warning, say};
use crate::math::{Vec2, readable};
use crate::output::{Growth, HeldBack, Recording, WarningRecord};
use crate::scenario::Scenario;

/// Share of the rain that is held back from which a run warns.
const TOLD_SHARE: f64 = 0.05;

impl Run<'_> {
    /// Says what the run found, and keeps it with its warnings.
    pub(super) fn warn_at_end(&mut self, recording: &Recording) {
        let held = self.manifest.volume_m3.held_back;
        let found = [
            recording.closed_edge.as_ref().map(reached),
            recording.growth.as_ref().map(|growth| too_short(growth, self.scenario)),
            held.filter(|held| held.share() > TOLD_SHARE).map(|held| held_back(&held, self.scenario)),
        ];
        for problem in found.into_iter().flatten() {
            say(&problem);
            self.manifest.warnings.push(WarningRecord::from(&problem));
            self.warnings.push(problem);
        }
    }
}

/// The warning of a flood that still grows.
fn too_short(growth: &Growth, scenario: &Scenario) -> Problem {
    let message = format!(
        "the flood still grows when the run ends at {}: of what it covers, {:.0} % came since {}",
        clock_time(scenario.end_time),
        100.0 * growth.share,
        clock_time(growth.since_s)
    );
    Problem::warning(ProblemKind::Scenario, "run-too-short", "time.end", message)
        .with_cause(format!("water last reached new ground at {}, here", clock_time(growth.last_arrival_s)))
        .with_remedy("let the run last longer: its maps show no more than what was reached by its end")
        .with_at(Vec2::new(growth.x, growth.y))
}

/// The warning of rain that is held back.
fn held_back(held: &HeldBack, scenario: &Scenario) -> Problem {
    let of = |volume: f64| 100.0 * (volume / held.of_rain_m3).min(1.0);
    let message = format!(
        "{:.0} % of the rain runs off nowhere: of {} m3, {} m3 are held back at the end of the run",
        100.0 * held.share(),
        rounded(held.of_rain_m3),
        rounded(held.in_films_m3 + held.in_pits_m3)
    );
    let cause = format!(
        "{:.0} % in films thinner than the `dry_depth` of {} m, below which no water flows, {:.0} % in pits of the bed below their rims",
        of(held.in_films_m3),
        readable(scenario.numerics.dry_depth),
        of(held.in_pits_m3)
    );
    let remedy = "expected where the ground has such pits; for thin rain take a smaller `numerics.dry_depth`, and for runoff fill the pits of the terrain";
    let place = scenario.rain.as_ref().and_then(|rain| rain.place.clone());
    let problem = input_warning("rain-held-back", message).with_cause(cause).with_remedy(remedy).with_place(place);
    Problem { key: "rain".to_owned(), ..problem }
}

/// A volume to three digits.
fn rounded(volume: f64) -> f64 {
    let digits = 10f64.powf(volume.abs().max(1e-12).log10().floor() - 2.0);
    readable((volume / digits).round() * digits)
}
