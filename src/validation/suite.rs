//! A case at its spacings with given methods, judged by its acceptance limits.

use super::case::{AcceptanceLimit, Case, Scope, Until};
use super::choice::Choice;
use super::judge::{Judgement, judge};
use super::outcome::{Broken, Check, Cost, Errors, Outcome};
use super::row::{Row, Status};
use super::run::run;
use crate::scenario::methods::Core;

/// Errors below this (m, m/s) are rounding and have no order.
const ROUNDING: f64 = 1e-10;

/// Which spacings of a case are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolutions {
    /// The coarse ones that the tests take.
    Test,
    /// All.
    Full,
}

/// Whether an acceptance limit was met by one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Number of the acceptance limit in its case.
    pub acceptance_limit: usize,
    /// Which runs the acceptance limit is for.
    pub scope: Scope,
    /// Whether it was met.
    pub is_met: bool,
}

/// What came out of a case with one choice of methods.
#[derive(Clone, Debug, Default)]
pub struct CaseResult {
    /// A row for each spacing.
    pub rows: Vec<Row>,
    /// The acceptance limits that applied.
    pub verdicts: Vec<Verdict>,
    /// Why the case was left out, where it was.
    pub skipped: Option<String>,
    /// Whether the case takes a larger Courant number than the methods ask for: what is found is for show.
    pub is_stretched: bool,
}

/// Runs a case; a run that breaks ends its own row alone.
pub fn run_case(case: &Case, choice: &Choice, resolutions: Resolutions) -> CaseResult {
    let number = match resolutions {
        Resolutions::Test => case.tested.min(case.spacings.len()),
        Resolutions::Full => case.spacings.len(),
    };
    let mut result = CaseResult::default();
    let core = choice.numerics.core();
    let (mut coarsest, mut coarser): (Option<ErrorsAt>, Option<ErrorsAt>) = (None, None);
    for (k, &spacing) in case.spacings[..number].iter().enumerate() {
        let setup = match (case.setup)(spacing, core) {
            Ok(setup) if core == Core::Lagrangian => setup.in_plane(),
            Ok(setup) => setup,
            Err(why) => {
                result.skipped = Some(why);
                return result;
            }
        };
        if core == Core::Variational && !setup.problem.forcing.is_still() {
            result.skipped = Some("the variational formulation has no open boundaries with a condition".to_owned());
            return result;
        }
        result.is_stretched |= setup.courant.is_some_and(|courant| courant > choice.numerics.cfl);
        let (cost, ended) = run(&setup, choice);
        let outcome = ended.as_ref().ok().filter(|_| setup.is_answer_known);
        let is_finest = k + 1 == number && k > 0;
        let found = outcome.map(|outcome| outcome.errors);
        // A lake at rest is right or wrong; it has no order.
        let errors = found.filter(|_| matches!(setup.until, Until::Time(_))).map(|errors| (spacing, errors));
        let (whole_order, order) = (orders(coarsest, errors), orders(coarser, errors));
        coarsest = if k == 0 { errors } else { coarsest };
        coarser = errors;
        let judgement = setup.limits.as_ref().map(|limits| judge(limits, &cost, &ended));
        let whole_order = is_finest.then_some(whole_order);
        let place = Placed { case, choice, spacing, errors: found, whole_order, judgement };
        let (row, verdicts) = place.row(cost, &ended, order);
        result.rows.push(row);
        result.verdicts.extend(verdicts);
    }
    result
}

/// A spacing (m) and the errors at it.
type ErrorsAt = (f64, Errors);
type Orders = (Option<f64>, Option<f64>);

/// Orders of depth and velocity from a coarser to a finer spacing (m).
fn orders(coarse: Option<ErrorsAt>, fine: Option<ErrorsAt>) -> Orders {
    let Some(((coarse_spacing, coarse), (spacing, fine))) = coarse.zip(fine) else { return (None, None) };
    let of = |coarse: f64, fine: f64| (fine > ROUNDING).then(|| (coarse / fine).ln() / (coarse_spacing / spacing).ln());
    (of(coarse.depth, fine.depth), of(coarse.velocity, fine.velocity))
}

/// Where a run stands among the runs of its case.
struct Placed<'a> {
    case: &'a Case,
    choice: &'a Choice,
    spacing: f64,
    /// Where there is an answer.
    errors: Option<Errors>,
    /// Orders from the coarsest to this spacing, where it is the finest of several.
    whole_order: Option<Orders>,
    /// Whether it holds, in the suite of stability.
    judgement: Option<Judgement>,
}

impl Placed<'_> {
    fn row(&self, cost: Cost, ended: &Result<Outcome, Broken>, orders: Orders) -> (Row, Vec<Verdict>) {
        let numerics = &self.choice.numerics;
        let outcome = ended.as_ref().ok();
        let mut asked = Vec::new();
        let mut verdicts = Vec::new();
        for (number, acceptance_limit) in self.case.acceptance_limits.iter().enumerate() {
            let items = self.asked_by(acceptance_limit, &cost, outcome);
            if !items.is_empty() {
                let is_met = items.iter().all(|item| item.is_met);
                verdicts.push(Verdict { acceptance_limit: number, scope: acceptance_limit.scope, is_met });
                let whose = match acceptance_limit.scope {
                    Scope::Each | Scope::Of(_) => "",
                    Scope::Better => " (the better motion)",
                };
                asked.extend(items.into_iter().map(|item| format!("{}{whose}", item.found)));
            }
        }
        if let Some(judgement) = &self.judgement {
            asked.push(judgement.asked.clone());
        }
        let status = match ended {
            _ if self.judgement.is_some() => self.judgement.as_ref().map_or(Status::Fails, |judged| judged.status),
            Err(_) => Status::Fails,
            Ok(_) if verdicts.is_empty() => Status::Holds,
            Ok(_) if verdicts.iter().all(|verdict| verdict.is_met) => Status::Pass,
            Ok(_) => Status::FallShort,
        };
        let row = Row {
            particles: cost.particles,
            particle_evaluations: cost.evaluations,
            cpu_s: cost.cpu_s,
            norm: if numerics.has_cells() { "mean_abs_grid" } else { "mean_abs_particles" }.to_owned(),
            error_depth: self.errors.map(|errors| errors.depth),
            error_velocity: self.errors.map(|errors| errors.velocity),
            order_depth: orders.0,
            order_velocity: orders.1,
            max_speed_m_s: cost.max_speed,
            status,
            acceptance_limit: asked.join("; "),
            note: self.note(ended),
            ..Row::new((self.case.suite.name(), self.case.name), numerics, self.spacing)
        };
        (row, verdicts)
    }

    /// What an acceptance limit asks of this run and whether it is so; nothing where the acceptance limit is for other runs.
    fn asked_by(&self, acceptance_limit: &AcceptanceLimit, cost: &Cost, outcome: Option<&Outcome>) -> Vec<Check> {
        let is_for_me = match acceptance_limit.scope {
            Scope::Each | Scope::Better => true,
            Scope::Of(motion) => motion == self.choice.numerics.motion,
        };
        let mut items = Vec::new();
        if !is_for_me {
            return items;
        }
        let mut ask = |found: String, is_met: bool| items.push(Check { found, is_met });
        let at_most = |value: Option<f64>, most: f64| value.is_some_and(|value| value <= most);
        if acceptance_limit.spacing.is_none_or(|spacing| (spacing / self.spacing - 1.0).abs() < 1e-9) {
            if let Some(most) = acceptance_limit.depth {
                ask(format!("depth <= {most} m"), at_most(self.errors.map(|errors| errors.depth), most));
            }
            if let Some(most) = acceptance_limit.velocity {
                ask(format!("velocity <= {most} m/s"), at_most(self.errors.map(|errors| errors.velocity), most));
            }
            if let Some(most) = acceptance_limit.max_speed {
                ask(format!("max speed <= {most:e} m/s"), at_most(outcome.map(|_| cost.max_speed), most));
            }
        }
        if let (Some((depth, velocity)), Some(orders)) = (acceptance_limit.order, self.whole_order) {
            let shown = |order: Option<f64>| order.map_or("none".to_owned(), |order| format!("{order:.3}"));
            let at_least = |order: Option<f64>, least: f64| order.is_some_and(|order| order >= least);
            ask(format!("order of depth {} >= {depth}", shown(orders.0)), at_least(orders.0, depth));
            if let Some(velocity) = velocity {
                ask(format!("order of velocity {} >= {velocity}", shown(orders.1)), at_least(orders.1, velocity));
            }
        }
        if acceptance_limit.checks {
            let checks = outcome.map_or(&[][..], |outcome| &outcome.checks);
            ask("checks in the note".to_owned(), outcome.is_some() && checks.iter().all(|check| check.is_met));
        }
        items
    }

    fn note(&self, ended: &Result<Outcome, Broken>) -> String {
        let mut parts: Vec<String> = self.choice.without_column().collect();
        match ended {
            Err(broken) => parts.push(broken.to_string()),
            Ok(outcome) => parts.extend(
                outcome
                    .checks
                    .iter()
                    .map(|check| if check.is_met { check.found.clone() } else { format!("{} (missed)", check.found) }),
            ),
        }
        parts.extend(self.judgement.iter().map(|judgement| judgement.found.clone()).filter(|found| !found.is_empty()));
        parts.join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;
    use crate::scenario::methods::Motion;
    use crate::validation::case::{SetupResult, Suite};
    use crate::validation::cases::dam_breaks::channel;

    const CASE: Case = Case {
        name: "made",
        suite: Suite::Analytic,
        about: "Made for this test.",
        is_tuned: true,
        spacings: &[40.0, 20.0],
        tested: 2,
        acceptance_limits: &[
            AcceptanceLimit {
                scope: Scope::Of(Motion::Lagrangian),
                spacing: Some(20.0),
                depth: Some(1e-9),
                ..AcceptanceLimit::NONE
            },
            AcceptanceLimit { order: Some((0.5, None)), ..AcceptanceLimit::NONE },
        ],
        setup: |spacing, _| Ok(channel(spacing, 5.0, 20.0)),
    };

    fn results(setup: fn(f64, Core) -> SetupResult) -> [CaseResult; 2] {
        ["eulerian", "lagrangian"].map(|motion| {
            let choice = Choice::new(&[("motion", motion)]).unwrap();
            run_case(&Case { setup, ..CASE }, &choice, Resolutions::Test)
        })
    }

    #[test]
    fn acceptance_limits_are_judged_where_they_apply() {
        let [resting, moving] = results(CASE.setup);
        let statuses = |result: &CaseResult| result.rows.iter().map(|row| row.status).collect::<Vec<_>>();
        assert_eq!(statuses(&resting), [Status::Holds, Status::Pass]);
        assert_eq!(statuses(&moving), [Status::Holds, Status::FallShort]);
        assert_eq!(
            moving.rows[1].acceptance_limit,
            format!("depth <= 0.000000001 m; order of depth {:.3} >= 0.5", moving.rows[1].order_depth.unwrap())
        );
        let row = &resting.rows[1];
        let coarse = resting.rows[0].error_depth.unwrap();
        assert!((row.order_depth.unwrap() - (coarse / row.error_depth.unwrap()).log2()).abs() < 1e-12);
    }

    #[test]
    fn a_run_that_breaks_says_when_where_and_what_and_stops_nothing() {
        for result in results(|spacing, motion| {
            let mut setup = (CASE.setup)(spacing, motion)?;
            if spacing > 30.0 {
                setup.velocity = Some(Box::new(|place| Vec2::new(if place.x < 50.0 { f64::NAN } else { 0.0 }, 0.0)));
            }
            Ok(setup)
        }) {
            let (broken, sound) = (&result.rows[0], &result.rows[1]);
            assert_eq!((broken.status, broken.error_depth), (Status::Fails, None));
            assert!(broken.note.contains("broke down at t =") && broken.note.contains("limited by"), "{}", broken.note);
            assert!(sound.status != Status::Fails && sound.error_depth.is_some());
            // Without a coarser error there is no order, and an acceptance limit on it is missed.
            assert_eq!((sound.order_depth, sound.status), (None, Status::FallShort));
        }
    }

    #[test]
    fn a_run_whose_step_collapses_is_given_up() {
        for result in results(|spacing, motion| {
            let mut setup = (CASE.setup)(spacing, motion)?;
            // As if the answer were so slow that hardly a step is foreseen for so long a time.
            setup.until = crate::validation::Until::Time(1e5);
            (setup.scale_depth, setup.scale_speed) = (1e-12, 0.0);
            Ok(setup)
        }) {
            assert!(result.rows.iter().all(|row| row.status == Status::Fails));
            assert!(result.rows[0].note.contains("given up at t ="), "{}", result.rows[0].note);
        }
    }
}
