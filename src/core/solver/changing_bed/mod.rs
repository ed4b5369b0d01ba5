//! A bed that changes during a run, as both motions follow it: when a dam breaks and how far it has gone, and how far ground that
//! moves has come. What the water on it does is the business of each core.

mod dam;
mod ground;

pub(super) use dam::BreakingDam;
pub(super) use ground::MovingGround;

#[cfg(test)]
pub(super) mod scenes;
