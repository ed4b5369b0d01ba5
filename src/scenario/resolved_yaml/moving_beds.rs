//! Beds that move in the resolved scenario.

use super::forcing::{series, timed};
use super::{file, name_of, vector};
use crate::scenario::choices::ElevationUnit;
use crate::scenario::moving_bed::{BedMovement, MovingBed};
use crate::scenario::yaml::{Section, Yaml, quantity};

/// A moving bed in the resolved scenario.
pub(super) fn moving_bed(bed: &MovingBed) -> Yaml {
    let key = if matches!(bed.law, BedMovement::InPlace(_)) { "change" } else { "thickness" };
    let section = Section::default()
        .with(key, file(&bed.raster.value))
        .with("unit", name_of(|candidate: &ElevationUnit| candidate.0.to_bits() == bed.unit.to_bits()))
        .with("at", quantity(bed.at.value, "s"));
    Yaml::Entry(match &bed.law {
        BedMovement::InPlace(share) => section.with_some("share", share.as_ref().map(series)),
        BedMovement::Slide { path, velocity } => {
            section.with("path", vector(path)).with("velocity", timed(velocity, "m/s"))
        }
    })
}
