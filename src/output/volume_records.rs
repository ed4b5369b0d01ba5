//! What `run.json` says of the volume of the water: its balance, what the ground holds back, and the ways in and out.

use serde::Serialize;

/// The water balance (m³).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct VolumeBooks {
    /// At the start.
    pub initial: f64,
    /// Came in.
    #[serde(rename = "in")]
    pub inflow: f64,
    /// Left.
    #[serde(rename = "out")]
    pub outflow: f64,
    /// At the end.
    #[serde(rename = "final")]
    pub last: f64,
    /// Error of the ledger over initial volume plus inflow (dimensionless).
    pub error_relative: f64,
    /// What the ground holds back of the water at the end, where rain fell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_back: Option<HeldBack>,
    /// Greatest difference between output grid and particles over the particles' volume (dimensionless).
    pub grid_error_relative: f64,
}

/// Water at the end of a run that runs off nowhere, whatever comes later (m³).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct HeldBack {
    /// In films thinner than `numerics.dry_depth`.
    pub in_films_m3: f64,
    /// Below the rims of pits, less what stood there at the start.
    pub in_pits_m3: f64,
    /// The rain that came down.
    pub of_rain_m3: f64,
}

impl HeldBack {
    /// Both over the rain (dimensionless), at most 1; 0 without rain.
    pub fn share(&self) -> f64 {
        let held = (self.in_films_m3 + self.in_pits_m3).max(0.0);
        if self.of_rain_m3 > 0.0 { (held / self.of_rain_m3).min(1.0) } else { 0.0 }
    }
}

/// Inflow and outflow by one way.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PassageRecord {
    /// Key of the scenario, or what it is.
    pub name: String,
    /// Volume that came in (m³).
    pub in_m3: f64,
    /// Volume that left (m³).
    pub out_m3: f64,
    /// The integral of the discharge or the rain that the scenario asks for (m³); none where it asks for none.
    pub asked_m3: Option<f64>,
}

impl PassageRecord {
    /// Difference of what came in, less what left, from what was asked for, over the latter; 0 where nothing was.
    pub fn error_relative(&self) -> Option<f64> {
        let asked = self.asked_m3?;
        let difference = (self.in_m3 - self.out_m3 - asked).abs();
        Some(if difference > 0.0 { difference / asked } else { 0.0 })
    }
}
