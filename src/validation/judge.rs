//! Whether a run of the suite of stability holds, degrades or fails, by what physics allows.
//!
//! ```text
//! fails      the run breaks down, loses or makes more than 1e-9 of its volume, is faster than energy allows by more than a tenth,
//!            or a measure is beyond its outer bound
//! degrades   it is faster than energy allows by more than 0.05 per cent, or a measure is beyond its inner bound
//! holds      otherwise
//! ```
//!
//! Energy: water of celerity c that falls through a height reaches 2 c + √(2 g height) at most. Where it may be off by a thousandth, as in
//! the bowls, speed may by half of that; a tenth more speed is a fifth more energy than there is, which no smearing explains.

use super::outcome::{Broken, Cost, Outcome};
use super::row::Status;

/// Share of the volume that may be lost or made: a hundred thousand steps of rounding stay below it.
const VOLUME: f64 = 1e-9;
/// How many times as fast as energy allows a run may be.
const OVERSPEED: Share = Share { holds: 1.000_5, fails: 1.1 };
/// Energy that a flow without friction may gain, as a share of what it has above its lowest bed: what the bowls are held to, and ten times
/// as much.
pub const ENERGY: Share = Share { holds: 1e-3, fails: 1e-2 };

/// A number with an inner bound, up to which a run holds, and an outer one, beyond which it fails; both in its own unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Up to here the run holds.
    pub holds: f64,
    /// Beyond it the run fails.
    pub fails: f64,
}

/// Something that is measured at the end of a run: the smaller, the better.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// In plain words, with its number and unit.
    pub found: String,
    /// What it is held to, in plain words.
    pub asked: String,
    /// The number; one that is none fails.
    pub value: f64,
    /// Its bounds.
    pub bounds: Share,
}

impl Measure {
    /// `what` is `value`, with four digits, in `unit`.
    pub fn new(what: &str, value: f64, unit: &str, bounds: Share) -> Measure {
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let asked = format!("{what} <= {}{unit} (fails beyond {})", short(bounds.holds), short(bounds.fails));
        Measure { found: format!("{what} {}{unit}", short(value)), asked, value, bounds }
    }

    fn status(&self) -> Status {
        if self.value <= self.bounds.holds {
            Status::Holds
        } else if self.value <= self.bounds.fails {
            Status::Degrades
        } else {
            Status::Fails
        }
    }
}

/// Looks at a run that came to its end.
pub type Measures = Box<dyn Fn(&Outcome) -> Vec<Measure> + Send + Sync>;

/// What a run is held to.
pub struct Limits {
    /// Greatest speed (m/s) that energy allows.
    pub speed: f64,
    /// What else is measured.
    pub measures: Measures,
}

impl Limits {
    /// The speed (m/s) up to which a run holds.
    pub fn allowed_speed(&self) -> f64 {
        OVERSPEED.holds * self.speed
    }
}

/// What was found of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// Holds, degrades or fails.
    pub status: Status,
    /// What it was held to.
    pub asked: String,
    /// What was seen, in plain words.
    pub found: String,
}

/// Judges a run.
pub fn judge(limits: &Limits, cost: &Cost, ended: &Result<Outcome, Broken>) -> Judgement {
    let volume = |outcome: &Outcome| {
        let bounds = Share { holds: VOLUME, fails: VOLUME };
        Measure::new("volume error", outcome.volume_error.abs(), "", bounds)
    };
    let speed = Share { holds: limits.allowed_speed(), fails: OVERSPEED.fails * limits.speed };
    let speed = Measure::new("greatest speed", cost.max_speed, "m/s", speed);
    let mut measures = vec![speed];
    if let Ok(outcome) = ended {
        measures.push(volume(outcome));
        measures.extend((limits.measures)(outcome));
    }
    let mut status = if ended.is_err() { Status::Fails } else { Status::Holds };
    let (mut asked, mut bad, mut good) = (Vec::new(), Vec::new(), Vec::new());
    for measure in &measures {
        asked.push(measure.asked.clone());
        match measure.status() {
            Status::Holds => good.push(measure.found.clone()),
            worse => {
                status =
                    if worse == Status::Fails || status == Status::Fails { Status::Fails } else { Status::Degrades };
                bad.push(format!("{} ({})", measure.found, worse.name()));
            }
        }
    }
    if let Some(excess) = cost.excess {
        bad.push(format!(
            "too fast first at t = {:.3} s at {:.1}, {:.1} with {} m/s (limited by {})",
            excess.time,
            excess.place.x,
            excess.place.y,
            short(excess.speed),
            excess.limiter
        ));
    }
    bad.extend(good);
    Judgement { status, asked: asked.join("; "), found: bad.join("; ") }
}

/// A number in four digits.
fn short(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e4).contains(&value.abs()) {
        let digits = (3 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validation::cases::dam_breaks::channel;
    use crate::validation::{Choice, run};

    fn judged(speed: f64, value: f64, courant: f64) -> Judgement {
        let mut setup = channel(40.0, 5.0, 10.0);
        setup.courant = Some(courant);
        setup.limits = Some(Limits {
            speed,
            measures: Box::new(move |_| vec![Measure::new("made", value, "m", Share { holds: 1.0, fails: 2.0 })]),
        });
        let (cost, ended) = run(&setup, &Choice::new(&[]).unwrap());
        judge(setup.limits.as_ref().unwrap(), &cost, &ended)
    }

    #[test]
    fn bounds_tell_holding_from_degrading_and_failing() {
        for (value, status) in [(1.0, Status::Holds), (1.5, Status::Degrades), (2.5, Status::Fails)] {
            assert_eq!(judged(20.0, value, 0.5).status, status);
        }
        assert_eq!(judged(20.0, f64::NAN, 0.5).status, Status::Fails);
        let judged = judged(20.0, 1.5, 0.5);
        assert!(judged.found.starts_with("made 1.5 m (degrades)"), "{}", judged.found);
        assert!(judged.asked.contains("made <= 1 m (fails beyond 2)"), "{}", judged.asked);
    }

    #[test]
    fn water_that_is_too_fast_says_when_and_where() {
        // The bore of 10 m over 5 m moves water at 3.1 m/s.
        let judged = judged(1.0, 0.0, 0.5);
        assert_eq!(judged.status, Status::Fails);
        assert!(judged.found.contains("too fast first at t = ") && judged.found.contains("limited by courant"));
    }

    #[test]
    fn numbers_are_short() {
        let texts = [0.0, 1e-9, 0.012_34, 1.0, 19.81, 123.4, 54_321.0].map(short);
        assert_eq!(texts, ["0", "1.0e-9", "0.01234", "1", "19.81", "123.4", "5.4e4"]);
    }
}
