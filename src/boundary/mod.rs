//! Where the water ends: the outline of the terrain, walls, open edges, and the mirror images or virtual particles that stand for a wall.

mod image;
mod open_edges;
mod outline;
mod virtual_particles;
mod wall;

pub use image::{Image, ImageScratch, Isometry, Viewpoint};
pub use open_edges::OpenEdges;
pub use outline::outline;
pub use wall::{Edge, Path, Walls};
