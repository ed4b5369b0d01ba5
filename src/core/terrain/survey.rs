//! Bare survey points as terrain: inverse distance over the nearest points, or natural neighbours.
//!
//! Inverse distance (`Shepard1968`) over the k nearest points:
//!
//! ```text
//! z(x) = Σ z_j / r_j²  /  Σ 1 / r_j²
//! ```
//!
//! Natural neighbour (`Sibson1981`): the weight of a point is the share of its Voronoi cell that a new point at x would
//! take. It is exact for a plane, smooth away from the points, and defined inside their convex hull only: it does not
//! guess beyond the survey. Places farther than the greatest gap from any point have no terrain with either method.

use std::num::NonZeroUsize;

use geo::indexed::IntervalTreeMultiPolygon;
use geo::{BoundingRect, Contains, MultiPolygon};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use spade::{DelaunayTriangulation, FloatTriangulation, HasPosition, HierarchyHintGenerator, Point2, Triangulation};

use crate::math::{Rectangle, Vec2};

/// Interpolation between survey points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointInterpolation {
    /// Inverse squared distance over the nearest points.
    InverseDistance,
    /// Natural neighbour (Sibson).
    NaturalNeighbour,
}

/// Number of nearest points in an inverse-distance mean: two rings around a place on a regular survey.
const NEAREST: NonZeroUsize = NonZeroUsize::new(12).unwrap();

/// A survey point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurveyPoint {
    /// Map coordinates (m).
    pub position: Vec2,
    /// Elevation (m).
    pub elevation: f64,
}

/// A vertex of the triangulation: local coordinates and elevation.
struct Vertex {
    position: Point2<f64>,
    elevation: f64,
}

impl HasPosition for Vertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// The hint generator keeps no memory of earlier queries, so that a value does not depend on what other threads ask.
type Delaunay = DelaunayTriangulation<Vertex, (), (), (), HierarchyHintGenerator<f64>>;

/// Survey points as a surface.
pub struct Survey {
    points: Vec<SurveyPoint>,
    /// Map coordinates of the local origin (m): the trees hold small numbers.
    origin: Vec2,
    tree: ImmutableKdTree<f64, 2>,
    delaunay: Option<Delaunay>,
    max_gap: f64,
    spacing: f64,
    extent: Rectangle,
    /// Outside of it there is no terrain (map coordinates).
    area: Option<IntervalTreeMultiPolygon<f64>>,
}

impl std::fmt::Debug for Survey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Survey of {} points, max_gap {} m", self.points.len(), self.max_gap)
    }
}

impl Survey {
    /// A surface from points without duplicates.
    ///
    /// - `max_gap` (m): distance to the nearest point beyond which there is no terrain
    ///
    /// # Errors
    /// In words, when there are too few points, or all of them lie on one line.
    pub fn new(points: Vec<SurveyPoint>, method: PointInterpolation, max_gap: f64) -> Result<Survey, String> {
        if points.len() < 3 {
            return Err(format!("{} points make no surface", points.len()));
        }
        let least = |of: fn(&SurveyPoint) -> f64| points.iter().map(of).fold(f64::INFINITY, f64::min);
        let most = |of: fn(&SurveyPoint) -> f64| points.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        let origin = Vec2::new(least(|p| p.position.x), least(|p| p.position.y));
        let extent = Rectangle { low: origin, high: Vec2::new(most(|p| p.position.x), most(|p| p.position.y)) };
        let local = |p: &SurveyPoint| p.position - origin;
        let coordinates: Vec<[f64; 2]> = points.iter().map(|p| [local(p).x, local(p).y]).collect();
        let tree = ImmutableKdTree::new_from_slice(&coordinates)
            .map_err(|error| format!("the points cannot be indexed: {error:?}"))?;
        let delaunay = match method {
            PointInterpolation::InverseDistance => None,
            PointInterpolation::NaturalNeighbour => {
                let vertices = points
                    .iter()
                    .map(|p| Vertex { position: Point2::new(local(p).x, local(p).y), elevation: p.elevation })
                    .collect();
                let delaunay = Delaunay::bulk_load(vertices)
                    .map_err(|error| format!("the points cannot be triangulated: {error}"))?;
                if delaunay.num_inner_faces() == 0 {
                    return Err("all points lie on one line".to_string());
                }
                Some(delaunay)
            }
        };
        let mut survey = Survey { points, origin, tree, delaunay, max_gap, spacing: 0.0, extent, area: None };
        survey.spacing = survey.typical_spacing();
        Ok(survey)
    }

    /// The points.
    pub fn points(&self) -> &[SurveyPoint] {
        &self.points
    }

    /// Median distance of a point to its nearest neighbour (m).
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    fn typical_spacing(&self) -> f64 {
        /// Enough points for a median; the first ones of a survey may be all of one kind, so they are taken evenly.
        const SAMPLE: usize = 1000;
        let step = (self.points.len() / SAMPLE).max(1);
        let two = const { NonZeroUsize::new(2).unwrap() };
        let mut distances: Vec<f64> = self
            .points
            .iter()
            .step_by(step)
            .filter_map(|p| self.nearest(p.position, two).last().map(|(squared, _)| squared.sqrt()))
            .collect();
        distances.sort_by(f64::total_cmp);
        distances[distances.len() / 2]
    }

    /// Squared distances (m²) and indices of the nearest points, nearest first.
    fn nearest(
        &self,
        map: Vec2,
        count: NonZeroUsize,
    ) -> impl ExactSizeIterator<Item = (f64, usize)> + DoubleEndedIterator {
        let local = map - self.origin;
        self.tree
            .query(&[local.x, local.y])
            .nearest_n::<SquaredEuclidean<f64>>(count)
            .execute()
            .into_iter()
            .map(|found| (found.distance, found.item as usize))
    }

    /// Distance to the nearest point (m).
    pub fn gap(&self, map: Vec2) -> f64 {
        self.nearest_one(map).0.sqrt()
    }

    /// Squared distance (m²) and index of the nearest point.
    fn nearest_one(&self, map: Vec2) -> (f64, usize) {
        let local = map - self.origin;
        let found = self.tree.query(&[local.x, local.y]).nearest_one::<SquaredEuclidean<f64>>().execute();
        (found.distance, found.item as usize)
    }

    /// The same survey where it lies inside an area (map coordinates), whose rim has no terrain; none where the area lies beside it.
    ///
    /// Points outside go on shaping the surface inside.
    pub fn within_area(mut self, area: &MultiPolygon<f64>) -> Option<Survey> {
        let bounds = area.bounding_rect()?;
        let Rectangle { low, high } = self.extent;
        let low = Vec2::new(low.x.max(bounds.min().x), low.y.max(bounds.min().y));
        let high = Vec2::new(high.x.min(bounds.max().x), high.y.min(bounds.max().y));
        self.extent = Rectangle { low, high };
        self.area = Some(IntervalTreeMultiPolygon::new(area));
        (low.x < high.x && low.y < high.y).then_some(self)
    }

    /// Whether a place lies inside the area to which the survey is cut.
    pub(super) fn covers(&self, map: Vec2) -> bool {
        self.area.as_ref().is_none_or(|area| area.contains(&geo::Point::new(map.x, map.y)))
    }

    /// Elevation (m); none beyond the greatest gap or outside the area to which the survey is cut, and for natural neighbours none outside the convex hull.
    pub fn elevation(&self, map: Vec2) -> Option<f64> {
        if !self.covers(map) {
            return None;
        }
        let (squared, index) = self.nearest_one(map);
        if squared > self.max_gap * self.max_gap {
            return None;
        }
        if squared == 0.0 {
            return Some(self.points[index].elevation);
        }
        match &self.delaunay {
            None => Some(self.inverse_distance(map)),
            Some(delaunay) => natural_neighbour(delaunay, map - self.origin),
        }
    }

    fn inverse_distance(&self, map: Vec2) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (squared, index) in self.nearest(map, NEAREST) {
            let weight = 1.0 / squared;
            sum += weight * self.points[index].elevation;
            weights += weight;
        }
        sum / weights
    }

    /// Indices of the points within a radius (m), in the order of the file.
    pub fn within(&self, map: Vec2, radius: f64) -> Vec<usize> {
        let local = map - self.origin;
        let found =
            self.tree.query(&[local.x, local.y]).within::<SquaredEuclidean<f64>>(radius * radius).unsorted().execute();
        let mut indices: Vec<usize> = found.into_iter().map(|f| f.item as usize).collect();
        indices.sort_unstable();
        indices
    }

    /// The rectangle around the points, or the part of it to which the survey is cut (map coordinates).
    pub fn extent(&self) -> Rectangle {
        self.extent
    }
}

/// Sibson's interpolant; linear on the triangle where round-off spoils it; none outside the convex hull.
fn natural_neighbour(delaunay: &Delaunay, local: Vec2) -> Option<f64> {
    let place = Point2::new(local.x, local.y);
    let value = delaunay.natural_neighbor().interpolate(|vertex| vertex.data().elevation, place)?;
    if value.is_finite() {
        return Some(value);
    }
    delaunay.barycentric().interpolate(|vertex| vertex.data().elevation, place)
}

#[cfg(test)]
mod tests {
    use super::*;

    const METHODS: [PointInterpolation; 2] =
        [PointInterpolation::InverseDistance, PointInterpolation::NaturalNeighbour];

    fn grid(elevation: impl Fn(Vec2) -> f64) -> Vec<SurveyPoint> {
        // A regular grid has many equal coordinates, which is what trees and triangulations stumble over.
        (0..900)
            .map(|i| {
                let position = Vec2::new(950_000.0 + 10.0 * f64::from(i % 30), 1_840_000.0 + 10.0 * f64::from(i / 30));
                SurveyPoint { position, elevation: elevation(position) }
            })
            .collect()
    }

    fn tilted(p: Vec2) -> f64 {
        0.1 * (p.x - 950_000.0) - 0.3 * (p.y - 1_840_000.0) + 50.0
    }

    #[test]
    fn points_are_met_exactly_and_values_stay_between_those_of_the_points() {
        for method in METHODS {
            let survey = Survey::new(grid(tilted), method, 100.0).unwrap();
            for point in survey.points() {
                assert_eq!(survey.elevation(point.position), Some(point.elevation));
            }
            for i in 0..200 {
                let map = Vec2::new(950_000.0 + 1.37 * f64::from(i), 1_840_000.0 + 0.91 * f64::from(i));
                let z = survey.elevation(map).unwrap();
                assert!((-40.0..=79.1).contains(&z), "{method:?} {z}");
            }
        }
    }

    #[test]
    fn natural_neighbours_meet_a_plane() {
        // A scattered survey: the grid with its points moved off their lines.
        let mut points = grid(tilted);
        for (i, point) in points.iter_mut().enumerate() {
            let turn = i as f64 * 2.399; // the golden angle: no two alike
            point.position += Vec2::new(3.0 * turn.cos(), 3.0 * turn.sin());
            point.elevation = tilted(point.position);
        }
        let survey = Survey::new(points, PointInterpolation::NaturalNeighbour, 100.0).unwrap();
        for i in 0..300 {
            let map = Vec2::new(950_010.0 + 0.83 * f64::from(i), 1_840_012.0 + 0.79 * f64::from(i));
            let error = survey.elevation(map).unwrap() - tilted(map);
            assert!(error.abs() < 1e-9, "{error:e}"); // round-off of areas of 100 m² in coordinates of 300 m
        }
    }

    #[test]
    fn beyond_the_gap_there_is_no_terrain() {
        for method in METHODS {
            let survey = Survey::new(grid(tilted), method, 25.0).unwrap();
            let east = 950_290.0;
            assert_eq!(survey.elevation(Vec2::new(east + 26.0, 1_840_100.0)), None);
            // Inverse distance goes on up to the gap, natural neighbours end with the survey.
            let beyond = survey.elevation(Vec2::new(east + 24.0, 1_840_100.0));
            assert_eq!(beyond.is_some(), method == PointInterpolation::InverseDistance);
            assert!(survey.elevation(Vec2::new(east, 1_840_105.0)).is_some(), "the edge of the hull belongs to it");
            assert!((survey.gap(Vec2::new(east + 24.0, 1_840_100.0)) - 24.0).abs() < 1e-9);
            assert!((survey.spacing() - 10.0).abs() < 1e-9);
        }
    }

    #[test]
    fn points_within_a_radius_come_in_the_order_of_the_file() {
        let survey = Survey::new(grid(tilted), PointInterpolation::InverseDistance, 25.0).unwrap();
        assert_eq!(survey.within(Vec2::new(950_010.0, 1_840_010.0), 10.5), vec![1, 30, 31, 32, 61]);
    }

    #[test]
    fn a_line_of_points_is_no_surface() {
        let line = grid(tilted).into_iter().take(30).collect();
        assert!(Survey::new(line, PointInterpolation::NaturalNeighbour, 25.0).unwrap_err().contains("one line"));
        assert!(
            Survey::new(grid(tilted).into_iter().take(2).collect(), PointInterpolation::InverseDistance, 25.0).is_err()
        );
    }
}
