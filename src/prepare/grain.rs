//! How fine the terrain of a scenario is: what cells could show of it at most.

use super::findings::Findings;
use super::ground::layers;
use crate::math::Rectangle;
use crate::scenario::Scenario;
use crate::terrain::Layer;

/// The resolution (m) for which terrain is read before there is one: only rasters of degrees depend on it, and a little.
const PROVISIONAL: f64 = 1.0;

/// The pixels of a terrain and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Edge of its finest pixels; of points their distance (m).
    pub pixel: f64,
    /// The shorter side of the rectangle about its data (m).
    pub shorter_side: f64,
    /// The area of that rectangle (m²).
    pub area: f64,
}

/// The grain of the terrain of a scenario; none where it cannot be read.
pub fn grain(scenario: &Scenario) -> Option<Grain> {
    let mut scenario = scenario.clone();
    scenario.resolution.value = PROVISIONAL;
    let (_, terrain) = layers::open(&scenario, &mut Findings::default());
    let terrain = terrain?;
    let Rectangle { low, high } = terrain.extent();
    let size = high - low;
    let pixel = |layer: &Layer| match layer {
        Layer::Raster(raster) => raster.cell_x.min(raster.cell_y),
        Layer::Survey(survey) => survey.spacing(),
    };
    let pixel = terrain.layers().iter().map(pixel).fold(f64::INFINITY, f64::min);
    let is_fit = pixel.is_finite() && pixel > 0.0;
    is_fit.then_some(Grain { pixel, shorter_side: size.x.min(size.y), area: size.x * size.y })
}

/// The rectangle about the rasters of a terrain, and the edge of their finest pixels (m), without reading them; none where they cannot be
/// opened, and without a raster.
pub fn outline(scenario: &Scenario) -> Option<(Rectangle, f64)> {
    let (run, files) = layers::open_rasters(scenario)?;
    let mut outlines = files.iter().map(|file| Some((file.rectangle(&run)?, file.cell_in_metres())));
    let first = outlines.next()??;
    outlines.try_fold(first, |(about, finest), outline| {
        let (rectangle, pixel) = outline?;
        Some((about.around(rectangle), finest.min(pixel)))
    })
}
