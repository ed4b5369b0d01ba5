//! The partition on hand-made and on random scenes.

mod checks;
mod drawing;
mod mirrors;
mod quality;
mod random;
mod rules;
