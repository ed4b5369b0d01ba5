//! Whether the particles carry what passes between them, over the moments of the frames (M85).

use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::output::{DischargeRecord, WorstDischarge};
use crate::solver::{DischargeCheck, DischargesInDoubt};

/// The sums of a run so far.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Discharges {
    origin: Vec2,
    carried: f64,
    apart: f64,
    in_doubt: f64,
    /// With its time (s).
    worst: Option<(f64, DischargesInDoubt)>,
}

impl Discharges {
    pub fn new(lattice: &Lattice) -> Self {
        Discharges { origin: lattice.origin, carried: 0.0, apart: 0.0, in_doubt: 0.0, worst: None }
    }

    /// Adds a moment (s).
    pub fn add(&mut self, time: f64, check: Option<DischargeCheck>) {
        let Some(check) = check else { return };
        self.carried += check.carried;
        self.apart += check.apart;
        self.in_doubt += check.in_doubt;
        let apart = |worst: &DischargesInDoubt| (worst.own - worst.at_faces).abs();
        if let Some(worst) = check.worst
            && self.worst.is_none_or(|(_, before)| apart(&worst) > apart(&before))
        {
            self.worst = Some((time, worst));
        }
    }

    /// What `run.json` says of them; none where nothing flowed.
    pub fn record(&self) -> Option<DischargeRecord> {
        let worst = |(time_s, worst): (f64, DischargesInDoubt)| {
            let Vec2 { x, y } = self.origin + worst.place;
            WorstDischarge { time_s, x, y, own_m2_s: worst.own, at_faces_m2_s: worst.at_faces }
        };
        (self.carried > 0.0).then(|| DischargeRecord {
            apart_relative: self.apart / self.carried,
            in_doubt_relative: self.in_doubt / self.carried,
            worst: self.worst.map(worst),
        })
    }
}
