//! Where the water ends: the outline of the terrain, walls, open edges, and the mirror images that stand for a wall.

mod image;
mod outline;
mod wall;

pub use image::{Image, ImageScratch, Isometry, Sight};
pub use outline::outline;
pub use wall::{Edge, Path, Walls};
