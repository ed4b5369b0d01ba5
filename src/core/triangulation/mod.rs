//! The Delaunay triangulation of places that move: repaired by flips, with places put in and taken out.
//!
//! The Voronoi cell of a place is bounded by the lines between the centres of the circles about the triangles around it, one after the
//! other. Tests of sides and circles are exact in sign (`Shewchuk1997`): lattices, where four places lie on one circle, need no care.
//! Half-edge 3t + k goes from corner k of triangle t to the next one, counter-clockwise.

mod change;
mod flips;
#[cfg(test)]
mod tests;

use robust::Coord;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation as _};

use crate::math::Vec2;

/// No half-edge, no triangle, no place.
pub const NONE: u32 = u32::MAX;

/// Triangles about places; those that were taken out keep their numbers until others get them.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Triangulation {
    /// The places.
    places: Vec<Vec2>,
    /// Three corners of each triangle, counter-clockwise; [`NONE`] where it is free.
    corners: Vec<[u32; 3]>,
    /// Of each half-edge the one that goes back; [`NONE`] at the hull.
    twins: Vec<u32>,
    /// A half-edge that starts at each place; [`NONE`] where it was taken out.
    outgoing: Vec<u32>,
    free_triangles: Vec<u32>,
    free_places: Vec<u32>,
}

/// One of the places around another, counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub struct Spoke {
    /// The place.
    pub to: u32,
    /// The triangles to the right and to the left of the way there.
    pub sides: [u32; 2],
}

/// A place of a triangulation by its number.
struct Numbered(Vec2);

impl HasPosition for Numbered {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.0.x, self.0.y)
    }
}

/// The half-edge after another in its triangle.
#[inline]
fn next(edge: u32) -> u32 {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

/// The half-edge before another in its triangle.
#[inline]
fn before(edge: u32) -> u32 {
    if edge.is_multiple_of(3) { edge + 2 } else { edge - 1 }
}

fn coordinates(place: Vec2) -> Coord<f64> {
    Coord { x: place.x, y: place.y }
}

/// Twice the area of a triangle, exact in its sign: positive where its corners run counter-clockwise.
#[inline]
pub fn orientation([a, b, c]: [Vec2; 3]) -> f64 {
    robust::orient2d(coordinates(a), coordinates(b), coordinates(c))
}

/// Positive where a place lies within the circle about a triangle, exact in its sign.
#[inline]
fn in_circle([a, b, c]: [Vec2; 3], place: Vec2) -> f64 {
    robust::incircle(coordinates(a), coordinates(b), coordinates(c), coordinates(place))
}

/// The centre of the circle about a triangle.
#[inline]
pub fn circumcentre([a, b, c]: [Vec2; 3]) -> Vec2 {
    let (b, c) = (b - a, c - a);
    let (b_squared, c_squared) = (b.norm_squared(), c.norm_squared());
    let per = 0.5 / b.cross(c);
    a + Vec2::new(c.y * b_squared - b.y * c_squared, b.x * c_squared - c.x * b_squared) * per
}

impl Triangulation {
    /// The triangulation of places, no two of which are the same and not all of which lie on a line; none otherwise.
    pub fn new(places: Vec<Vec2>) -> Option<Self> {
        let numbered: Vec<Numbered> = places.iter().copied().map(Numbered).collect();
        let count = numbered.len();
        let made = DelaunayTriangulation::<Numbered>::bulk_load_stable(numbered).ok()?;
        if made.num_vertices() != count || made.num_inner_faces() == 0 {
            return None;
        }
        let corners = made.inner_faces().map(|face| face.vertices().map(|vertex| vertex.fix().index() as u32));
        // Near triangles have near numbers where near places do.
        let mut corners: Vec<[u32; 3]> = corners.collect();
        corners.sort_by_key(|[a, b, c]| *a.min(b).min(c));
        let mut triangulation = Triangulation {
            outgoing: vec![NONE; count],
            places,
            corners,
            twins: Vec::new(),
            free_triangles: Vec::new(),
            free_places: Vec::new(),
        };
        triangulation.join();
        Some(triangulation)
    }

    /// Finds the twins of all half-edges and a half-edge of each place.
    fn join(&mut self) {
        self.twins = vec![NONE; 3 * self.corners.len()];
        let mut ends: Vec<(u32, u32, u32)> = Vec::with_capacity(self.twins.len());
        for edge in 0..self.twins.len() as u32 {
            let (from, to) = (self.from(edge), self.to(edge));
            self.outgoing[from as usize] = edge;
            ends.push((from.min(to), from.max(to), edge));
        }
        ends.sort_unstable();
        for pair in ends.windows(2).filter(|pair| (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1)) {
            let [a, b] = [pair[0].2, pair[1].2];
            (self.twins[a as usize], self.twins[b as usize]) = (b, a);
        }
    }

    /// Triangulates all places afresh, with the same numbers; whether that could be done: not where two places are the same, or one is none.
    pub fn renew(&mut self) -> bool {
        let kept: Vec<u32> = (0..self.places.len() as u32).filter(|&k| self.has(k)).collect();
        let fresh = Self::new(kept.iter().map(|&k| self.places[k as usize]).collect());
        let Some(fresh) = fresh else { return false };
        self.corners = fresh.corners.into_iter().map(|corners| corners.map(|k| kept[k as usize])).collect();
        self.free_triangles.clear();
        self.join();
        true
    }

    /// Numbers that places have or had.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there was never a place.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Whether a number has a place.
    pub fn has(&self, place: u32) -> bool {
        self.outgoing[place as usize] != NONE
    }

    /// Numbers that triangles have or had.
    pub fn triangles(&self) -> usize {
        self.corners.len()
    }

    /// A place.
    #[inline]
    pub fn place(&self, place: u32) -> Vec2 {
        self.places[place as usize]
    }

    /// All places.
    pub fn places(&self) -> &[Vec2] {
        &self.places
    }

    #[inline]
    fn from(&self, edge: u32) -> u32 {
        self.corners[edge as usize / 3][edge as usize % 3]
    }

    #[inline]
    fn to(&self, edge: u32) -> u32 {
        self.from(next(edge))
    }

    /// The corners of a triangle.
    #[inline]
    fn triangle(&self, triangle: u32) -> [Vec2; 3] {
        self.corners[triangle as usize].map(|corner| self.place(corner))
    }

    /// The centre of the circle about a triangle.
    #[inline]
    pub fn centre(&self, triangle: u32) -> Vec2 {
        circumcentre(self.triangle(triangle))
    }

    /// The places around one, counter-clockwise; not all of them at the hull.
    #[inline]
    pub fn around(&self, place: u32) -> impl Iterator<Item = Spoke> + '_ {
        let first = self.outgoing[place as usize];
        let mut edge = first;
        std::iter::from_fn(move || {
            let twin = *self.twins.get(edge as usize)?;
            if twin == NONE {
                edge = NONE;
                return None;
            }
            let spoke = Spoke { to: self.to(edge), sides: [twin / 3, edge / 3] };
            let on = self.twins[before(edge) as usize];
            edge = if on == first { NONE } else { on };
            Some(spoke)
        })
    }

    /// Calls `act` for each place beside one, at the hull, too.
    pub fn beside(&self, place: u32, mut act: impl FnMut(u32)) {
        let first = self.outgoing[place as usize];
        if first == NONE {
            return;
        }
        // The first one clockwise.
        let mut start = first;
        for _ in 0..self.corners.len() {
            let twin = self.twins[start as usize];
            if twin == NONE || next(twin) == first {
                break;
            }
            start = next(twin);
        }
        let mut edge = start;
        for _ in 0..self.corners.len() {
            act(self.to(edge));
            let on = self.twins[before(edge) as usize];
            if on == NONE {
                act(self.from(before(edge)));
                return;
            }
            if on == start {
                return;
            }
            edge = on;
        }
    }

    /// Whether a place has neighbours all around it, and does not lie at the hull.
    pub fn is_inside(&self, place: u32) -> bool {
        let first = self.outgoing[place as usize];
        let on = |edge: &u32| {
            let twin = *self.twins.get(*edge as usize)?;
            (twin != NONE).then(|| self.twins[before(*edge) as usize]).filter(|on| *on != NONE)
        };
        std::iter::successors(Some(first), on).skip(1).take(self.corners.len()).any(|edge| edge == first)
    }

    /// The corners of the cell of a place and its neighbours: each corner lies to the left of the way to the neighbour. Nothing at the hull.
    pub fn cell(&self, place: u32, corners: &mut Vec<Vec2>) {
        corners.clear();
        corners.extend(self.around(place).map(|spoke| self.centre(spoke.sides[1])));
    }

    /// The area of the cell of a place inside the hull, as the sum of triangles between the place and its faces.
    pub fn area(&self, place: u32) -> f64 {
        let own = self.place(place);
        let four_times = |spoke: Spoke| {
            let [right, left] = spoke.sides.map(|side| self.centre(side));
            (self.place(spoke.to) - own).cross(left - right)
        };
        0.25 * self.around(place).map(four_times).sum::<f64>()
    }
}
