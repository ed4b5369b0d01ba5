//! Terrain: rasters and survey points as one surface that can be asked for its elevation anywhere.

mod pieces;
mod pixels;
mod raster;
mod survey;

pub use pieces::Piece;
pub use pixels::{PixelBlock, PixelGrid};
pub use raster::Raster;
pub use survey::{PointInterpolation, Survey, SurveyPoint};

use crate::math::{Rectangle, Vec2};

/// Cells of a raster larger than a spacing by less than this fraction are of that spacing.
const SPACING_ROUNDING: f64 = 1e-6;

/// One source of elevations.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "a terrain has a few layers")]
pub enum Layer {
    /// A raster.
    Raster(Raster),
    /// Survey points.
    Survey(Survey),
}

impl Layer {
    /// Elevation (m) where the layer has data.
    pub fn elevation(&self, map: Vec2) -> Option<f64> {
        match self {
            Layer::Raster(raster) => raster.elevation(map),
            Layer::Survey(survey) => survey.elevation(map),
        }
    }

    /// Elevation (m) where the layer has data; see [`Terrain::mean_preserving_elevation`].
    fn mean_preserving_elevation(&self, map: Vec2, spacing: f64) -> Option<f64> {
        match self {
            Layer::Raster(raster) if raster.cell_x.max(raster.cell_y) <= spacing * (1.0 + SPACING_ROUNDING) => {
                raster.mean_preserving_elevation(map)
            }
            _ => self.elevation(map),
        }
    }

    /// The rectangle around its data.
    pub fn extent(&self) -> Option<Rectangle> {
        match self {
            Layer::Raster(raster) => raster.data_extent(),
            Layer::Survey(survey) => Some(survey.extent()),
        }
    }
}

/// How a layer meets those under it where both have data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlay {
    /// It counts alone.
    #[default]
    Replace,
    /// The lower elevation counts.
    Min,
    /// The higher elevation counts.
    Max,
}

/// The terrain of a run: layers, of which a later one wins where it has data, unless it is laid over the others in another way. All coordinates are map coordinates (m).
///
/// Holds no file open; threads may share it.
#[derive(Debug)]
pub struct Terrain {
    layers: Vec<Layer>,
    overlays: Vec<Overlay>,
    /// Of each layer.
    extents: Vec<Rectangle>,
    extent: Rectangle,
}

impl Terrain {
    /// Terrain from layers, later ones on top; none when no layer holds data.
    pub fn new(layers: Vec<Layer>) -> Option<Terrain> {
        Self::with_overlays(layers.into_iter().map(|layer| (layer, Overlay::Replace)).collect())
    }

    /// The same with a way to meet those under it for each layer.
    pub fn with_overlays(layers: Vec<(Layer, Overlay)>) -> Option<Terrain> {
        let (layers, overlays): (Vec<Layer>, Vec<Overlay>) = layers.into_iter().unzip();
        let extents: Vec<Option<Rectangle>> = layers.iter().map(Layer::extent).collect();
        let extent = extents.iter().flatten().copied().reduce(Rectangle::around)?;
        let extents = extents.into_iter().map(|extent| extent.unwrap_or(Rectangle::NOWHERE)).collect();
        Some(Terrain { layers, overlays, extents, extent })
    }

    /// The layers, the last one on top.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The rectangle around all data.
    pub fn extent(&self) -> Rectangle {
        self.extent
    }

    /// The rectangles around the data of its rasters.
    pub fn extents_of_rasters(&self) -> impl Iterator<Item = Rectangle> {
        let of_layers = self.layers.iter().zip(&self.extents);
        of_layers.filter(|(layer, _)| matches!(layer, Layer::Raster(_))).map(|(_, extent)| *extent)
    }

    /// Whether survey points say how high a place lies.
    pub fn is_surveyed(&self, map: Vec2) -> bool {
        self.layers.iter().any(|layer| matches!(layer, Layer::Survey(survey) if survey.elevation(map).is_some()))
    }

    /// Elevation (m) at a place, of the topmost layer with data if no other rule says how it meets those under it; none where no layer has any.
    ///
    /// In a raster it is bilinear between cell centres, and exact at them; see [`Raster::elevation`] for edges.
    pub fn elevation(&self, map: Vec2) -> Option<f64> {
        self.top(map).map(|(_, elevation)| elevation)
    }

    /// Elevation (m) at a place, for means over cells of a spacing (m): that of [`Raster::mean_preserving_elevation`] where the cells of
    /// the raster are no larger, so that the means are those of its values; bilinear as ever where they are.
    pub fn mean_preserving_elevation(&self, map: Vec2, spacing: f64) -> Option<f64> {
        let read = |layer: &Layer| layer.mean_preserving_elevation(map, spacing);
        self.top_of_first(self.layers.len(), &read).map(|(_, elevation)| elevation)
    }

    /// Mean and highest elevation (m) of the plane of [`mean_preserving_elevation`](Self::mean_preserving_elevation) over a square of a
    /// spacing (m) around a place, where that is a cell of the topmost raster with data there, and no layer is laid over it or under it by another rule.
    pub fn plane_of_cell(&self, centre: Vec2, spacing: f64) -> Option<(f64, f64)> {
        let layers = self.layers.iter().zip(&self.overlays).rev();
        for (layer, overlay) in layers {
            let Layer::Raster(raster) = layer else { return None };
            if *overlay != Overlay::Replace || !raster.has_cell(centre, spacing) {
                return None;
            }
            if let Some(plane) = raster.plane_at(centre) {
                return Some((plane.own, plane.highest()));
            }
        }
        None
    }

    /// Index of the layer that counts at a place.
    pub fn layer_at(&self, map: Vec2) -> Option<usize> {
        self.top(map).map(|(layer, _)| layer)
    }

    /// Index of the layer that counts at a place, and its elevation there.
    fn top(&self, map: Vec2) -> Option<(usize, f64)> {
        self.top_of_first(self.layers.len(), &|layer| layer.elevation(map))
    }

    /// The same among the lowest `count` layers, by the elevation that is read from each.
    fn top_of_first(&self, count: usize, read: &impl Fn(&Layer) -> Option<f64>) -> Option<(usize, f64)> {
        let own = self.layers[..count].iter().enumerate().rev().find_map(|(i, layer)| Some((i, read(layer)?)))?;
        let others = || self.top_of_first(own.0, read);
        let beaten = match self.overlays[own.0] {
            Overlay::Replace => None,
            Overlay::Min => others().filter(|other| other.1 < own.1),
            Overlay::Max => others().filter(|other| other.1 > own.1),
        };
        Some(beaten.unwrap_or(own))
    }

    /// How finely the terrain is known at a place (m): the cell of the topmost raster, the typical spacing of its survey.
    pub fn finest_cell_at(&self, map: Vec2) -> Option<f64> {
        let (index, _) = self.top(map)?;
        Some(match &self.layers[index] {
            Layer::Raster(raster) => raster.cell_x.min(raster.cell_y),
            Layer::Survey(survey) => survey.spacing(),
        })
    }

    /// Whether the topmost terrain at a place is a raster with cells no larger than a spacing (m).
    pub fn has_pixels(&self, map: Vec2, spacing: f64) -> bool {
        let size = |index: usize| match &self.layers[index] {
            Layer::Raster(raster) => Some(raster.cell_x.max(raster.cell_y)),
            Layer::Survey(_) => None,
        };
        let top = self.top(map).and_then(|(index, _)| size(index));
        top.is_some_and(|size| size <= spacing * (1.0 + SPACING_ROUNDING))
    }

    /// Distance (m) from a place to the nearest survey point, where a survey is on top.
    pub fn gap(&self, map: Vec2) -> Option<f64> {
        let (index, _) = self.top(map)?;
        match &self.layers[index] {
            Layer::Raster(_) => None,
            Layer::Survey(survey) => Some(survey.gap(map)),
        }
    }

    /// Appends the terrain points within `radius` (m) of a place: cell centres of the topmost raster there, or survey points.
    ///
    /// Their elevations are those of the whole surface, so that a finer layer on top counts; places without data are
    /// left out. Their order is fixed: rows from the north, or the order of the survey.
    pub fn samples(&self, centre: Vec2, radius: f64, samples: &mut Vec<(Vec2, f64)>) {
        let Some((index, _)) = self.top(centre) else {
            return;
        };
        match &self.layers[index] {
            Layer::Raster(raster) => {
                let reach = Vec2::new(radius, radius);
                let (columns, rows) = raster.cells_within(centre - reach, centre + reach);
                for row in rows {
                    for column in columns.clone() {
                        let place = raster.centre(column, row);
                        if (place - centre).norm_squared() <= radius * radius
                            && let Some(elevation) = self.elevation(place)
                        {
                            samples.push((place, elevation));
                        }
                    }
                }
            }
            Layer::Survey(survey) => {
                for point in survey.within(centre, radius) {
                    let place = survey.points()[point].position;
                    samples.extend(self.elevation(place).map(|elevation| (place, elevation)));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(west: f64, north: f64, cell: f64, columns: usize, rows: usize, value: f64) -> Raster {
        Raster { columns, rows, west, north, cell_x: cell, cell_y: cell, values: vec![value; columns * rows] }
    }

    fn is_shared_between_threads<T: Send + Sync>() {}

    #[test]
    fn a_later_layer_wins_where_it_has_data() {
        is_shared_between_threads::<Terrain>();
        let mut fine = raster(20.0, 80.0, 5.0, 8, 8, 2.0);
        fine.values[9] = f64::NAN;
        let hole = fine.centre(1, 1);
        let terrain =
            Terrain::new(vec![Layer::Raster(raster(0.0, 100.0, 20.0, 5, 5, 1.0)), Layer::Raster(fine)]).unwrap();
        assert_eq!(terrain.elevation(Vec2::new(10.0, 10.0)), Some(1.0));
        assert_eq!(terrain.elevation(Vec2::new(50.0, 50.0)), Some(2.0));
        assert_eq!(terrain.elevation(hole), Some(1.0));
        assert_eq!(terrain.elevation(Vec2::new(-1.0, 10.0)), None);
        assert_eq!(terrain.finest_cell_at(Vec2::new(50.0, 50.0)), Some(5.0));
        assert_eq!(terrain.finest_cell_at(hole), Some(20.0));
        let pixels =
            [(Vec2::new(50.0, 50.0), 5.0), (Vec2::new(50.0, 50.0), 4.9), (hole, 10.0), (Vec2::new(-1.0, 10.0), 30.0)];
        assert_eq!(pixels.map(|(place, spacing)| terrain.has_pixels(place, spacing)), [true, false, false, false]);
        assert_eq!(terrain.extent(), Rectangle { low: Vec2::ZERO, high: Vec2::new(100.0, 100.0) });
    }

    #[test]
    fn the_lower_or_the_higher_layer_counts_where_it_is_told_to() {
        let base = || Layer::Raster(raster(0.0, 100.0, 20.0, 5, 5, 1.0));
        let over = |value| Layer::Raster(raster(20.0, 80.0, 5.0, 8, 8, value));
        let at = |layers: Vec<(Layer, Overlay)>| {
            let terrain = Terrain::with_overlays(layers).unwrap();
            let inside = Vec2::new(50.0, 50.0);
            (
                terrain.elevation(inside).unwrap(),
                terrain.finest_cell_at(inside).unwrap(),
                terrain.elevation(Vec2::new(10.0, 10.0)),
            )
        };
        for (overlay, value, expected) in [
            (Overlay::Min, 0.5, (0.5, 5.0)),
            (Overlay::Min, 2.0, (1.0, 20.0)),
            (Overlay::Max, 2.0, (2.0, 5.0)),
            (Overlay::Max, 0.5, (1.0, 20.0)),
        ] {
            let found = at(vec![(base(), Overlay::Replace), (over(value), overlay)]);
            assert_eq!(found, (expected.0, expected.1, Some(1.0)), "{overlay:?} {value}");
        }
        // Each layer meets what all those under it make together.
        let layers = vec![(base(), Overlay::Replace), (over(3.0), Overlay::Max), (over(2.0), Overlay::Min)];
        assert_eq!(at(layers).0.to_bits(), 2.0_f64.to_bits());
        let layers = vec![(base(), Overlay::Replace), (over(0.2), Overlay::Min), (over(5.0), Overlay::Replace)];
        assert_eq!(at(layers).0.to_bits(), 5.0_f64.to_bits());
    }

    #[test]
    fn samples_are_the_cell_centres_around_a_place_with_the_values_of_the_whole_surface() {
        let mut coarse = raster(0.0, 100.0, 20.0, 5, 5, 1.0);
        coarse.values[2 * 5 + 1] = f64::NAN;
        let fine = raster(60.0, 60.0, 5.0, 4, 4, 2.0);
        let terrain = Terrain::new(vec![Layer::Raster(coarse), Layer::Raster(fine)]).unwrap();
        let mut samples = Vec::new();
        terrain.samples(Vec2::new(50.0, 50.0), 20.0, &mut samples);
        let expected = [
            (Vec2::new(50.0, 70.0), 1.0),
            (Vec2::new(50.0, 50.0), 1.0),
            (Vec2::new(70.0, 50.0), 2.0),
            (Vec2::new(50.0, 30.0), 1.0),
        ];
        assert_eq!(samples, expected);
        samples.clear();
        terrain.samples(Vec2::new(-50.0, 50.0), 20.0, &mut samples);
        assert!(samples.is_empty());
    }

    #[test]
    fn samples_of_a_survey_are_its_points() {
        let points = [(0.0, 0.0), (10.0, 0.0), (0.0, 10.0), (10.0, 10.0), (100.0, 5.0)];
        let points = points.iter().map(|&(x, y)| SurveyPoint { position: Vec2::new(x, y), elevation: x + y }).collect();
        let survey = Survey::new(points, PointInterpolation::NaturalNeighbour, 50.0).unwrap();
        let terrain =
            Terrain::new(vec![Layer::Survey(survey), Layer::Raster(raster(8.0, 2.0, 4.0, 1, 1, -7.0))]).unwrap();
        let mut samples = Vec::new();
        terrain.samples(Vec2::new(5.0, 5.0), 8.0, &mut samples);
        let elevations: Vec<f64> = samples.iter().map(|s| s.1).collect();
        assert_eq!(elevations, [0.0, -7.0, 10.0, 20.0]);
        assert_eq!(terrain.gap(Vec2::new(5.0, 10.0)), Some(5.0));
        assert_eq!(terrain.gap(Vec2::new(10.0, 0.0)), None);
    }
}
