//! Where the water ends, and where it comes and goes: the outline of the terrain, walls, the mirror images or virtual particles that
//! stand for them, open edges, and the forcing by boundaries, sources and rain; a dam that breaks; channels of one dimension.

mod breach;
mod channel;
mod edge;
mod forcing;
mod image;
mod isometry;
mod moving_bed;
mod open_edges;
mod outline;
mod series;
mod sight;
mod tracer;
mod virtual_particles;
mod wall;

pub use breach::{Breach, DamCell, GrowthLaw, Opening, RimCell, Trigger};
pub use channel::{Channel, ChannelEnd, ChannelSection, Resistance, Strip, wetted_perimeter};
pub use edge::{Edge, distance_to_segment, nearest_on_segment};
pub use forcing::{
    Boundary, Condition, EdgeFace, Forcing, LineSource, PointSource, Rain, RainFrames, Rating, edge_faces,
};
pub use image::ImageScratch;
pub use isometry::{Image, Isometry, Viewpoint};
pub use moving_bed::{BedLaw, BedMotion, Patch, Progress, Slide};
pub use open_edges::{Holes, OpenEdges, Pieces};
pub use outline::outline;
pub use series::Series;
pub use tracer::Tracer;
pub use wall::{Path, Walls};
