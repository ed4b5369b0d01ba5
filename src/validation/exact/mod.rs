//! Solutions of the shallow-water equations to compare with: in closed form where there is one, else by fine finite volumes.
//!
//! Depths (m), velocities (m/s), gravity 9.81 m/s² throughout.

mod bowl;
mod dam_break;
mod finite_volume;
mod steady;

pub use bowl::Bowl;
pub use dam_break::{ritter, ritter_front, ritter_outermost, stoker};
pub use finite_volume::{Accuracy, Profile, plane_dam_break, radial_dam_break};
pub use steady::{Branch, Bump, MacDonald, bump_bed, normal_velocity};
