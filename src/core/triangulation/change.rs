//! Places that are put in and taken out, one at a time.
//!
//! A new place takes all triangles whose circles it lies in (`Bowyer1981`, `Watson1981`). What a place leaves is filled ear by ear, each one
//! whose circle holds no other corner of the hole.

use super::{NONE, Triangulation, in_circle, orientation};
use crate::math::Vec2;

impl Triangulation {
    /// Puts a place in, which lies inside the hull near a triangle, and returns its number; none where there is a place already.
    pub fn insert(&mut self, place: Vec2, near: u32) -> Option<u32> {
        let number = self.free_places.pop().unwrap_or_else(|| {
            self.places.push(place);
            self.outgoing.push(NONE);
            self.places.len() as u32 - 1
        });
        if self.put_in(number, place, near) {
            return Some(number);
        }
        self.free_places.push(number);
        None
    }

    /// The same with a number that has no place now; whether it could be done.
    pub(super) fn put_in(&mut self, number: u32, place: Vec2, near: u32) -> bool {
        let Some(start) = self.triangle_at(place, near) else { return false };
        if self.corners[start as usize].iter().any(|&corner| self.place(corner) == place) {
            return false;
        }
        self.places[number as usize] = place;
        let cavity = self.cavity(place, start);
        // The edges around the cavity, and what lies beyond each.
        let mut rim: Vec<([u32; 2], u32)> = Vec::with_capacity(cavity.len() + 2);
        for edge in cavity.iter().flat_map(|&triangle| [0, 1, 2].map(|k| 3 * triangle + k)) {
            let twin = self.twins[edge as usize];
            if twin == NONE || !cavity.contains(&(twin / 3)) {
                rim.push(([self.from(edge), self.to(edge)], twin));
            }
        }
        self.release(&cavity);
        let made: Vec<u32> = rim.iter().map(|&([a, b], beyond)| self.add([a, b, number], beyond)).collect();
        for (&([_, b], _), &triangle) in rim.iter().zip(&made) {
            let after = rim.iter().position(|([a, _], _)| *a == b);
            if let Some(after) = after {
                self.link(3 * triangle + 1, 3 * made[after] + 2);
            }
        }
        true
    }

    /// Takes a place inside the hull out; others may get its number.
    pub fn remove(&mut self, place: u32) {
        self.take_out(place);
        self.free_places.push(place);
    }

    /// Takes a place inside the hull out and keeps its number.
    pub(super) fn take_out(&mut self, place: u32) {
        let mut ring: Vec<u32> = Vec::with_capacity(8);
        let mut beyond: Vec<u32> = Vec::with_capacity(8);
        let mut old: Vec<u32> = Vec::with_capacity(8);
        for spoke in self.around(place) {
            let triangle = spoke.sides[1];
            let opposite = [0, 1, 2].map(|k| 3 * triangle + k).into_iter().find(|&edge| self.from(edge) == spoke.to);
            ring.push(spoke.to);
            old.push(triangle);
            beyond.push(opposite.map_or(NONE, |edge| self.twins[edge as usize]));
        }
        self.release(&old);
        self.outgoing[place as usize] = NONE;
        while ring.len() > 3 {
            let ear = self.ear(&ring);
            let count = ring.len();
            let (before, after) = ((ear + count - 1) % count, (ear + 1) % count);
            // The ear between its neighbours: edges before → ear and ear → after have something beyond, after → before is new.
            let triangle = self.add([ring[before], ring[ear], ring[after]], beyond[before]);
            self.link(3 * triangle + 1, beyond[ear]);
            beyond[before] = 3 * triangle + 2;
            ring.remove(ear);
            beyond.remove(ear);
        }
        let triangle = self.add([ring[0], ring[1], ring[2]], beyond[0]);
        self.link(3 * triangle + 1, beyond[1]);
        self.link(3 * triangle + 2, beyond[2]);
    }

    /// The corner of a hole that may be cut off: one whose triangle stands upright and whose circle holds no other corner.
    fn ear(&self, ring: &[u32]) -> usize {
        let count = ring.len();
        let triangle =
            |ear: usize| [(ear + count - 1) % count, ear, (ear + 1) % count].map(|corner| self.place(ring[corner]));
        let is_upright = |ear: &usize| orientation(triangle(*ear)) > 0.0;
        let is_empty = |ear: &usize| {
            let corners = triangle(*ear);
            let others = (2..count - 1).map(|k| self.place(ring[(*ear + k) % count]));
            others.into_iter().all(|other| in_circle(corners, other) <= 0.0)
        };
        let mut upright = (0..count).filter(is_upright);
        upright.clone().find(is_empty).or_else(|| upright.next()).unwrap_or(0)
    }

    /// The triangle in which a place lies, searched for from another; none beyond the hull.
    fn triangle_at(&self, place: Vec2, near: u32) -> Option<u32> {
        let mut triangle = near;
        for _ in 0..self.corners.len() {
            let edges = [0, 1, 2].map(|k| 3 * triangle + k);
            let is_beyond =
                |edge: &u32| orientation([self.place(self.from(*edge)), self.place(self.to(*edge)), place]) < 0.0;
            match edges.into_iter().find(is_beyond) {
                None => return Some(triangle),
                Some(edge) => {
                    let twin = self.twins[edge as usize];
                    if twin == NONE {
                        return None;
                    }
                    triangle = twin / 3;
                }
            }
        }
        None
    }

    /// The triangles whose circles hold a place, with the one in which it lies.
    fn cavity(&self, place: Vec2, start: u32) -> Vec<u32> {
        let mut cavity = vec![start];
        let mut looked = 0;
        while looked < cavity.len() {
            let triangle = cavity[looked];
            looked += 1;
            for twin in [0, 1, 2].map(|k| self.twins[(3 * triangle + k) as usize]) {
                if twin != NONE && !cavity.contains(&(twin / 3)) && in_circle(self.triangle(twin / 3), place) > 0.0 {
                    cavity.push(twin / 3);
                }
            }
        }
        cavity
    }

    /// Frees triangles.
    fn release(&mut self, triangles: &[u32]) {
        for &triangle in triangles {
            self.corners[triangle as usize] = [NONE; 3];
        }
        self.free_triangles.extend(triangles.iter().rev());
    }

    /// Adds a triangle, with what lies beyond its first edge.
    fn add(&mut self, corners: [u32; 3], beyond: u32) -> u32 {
        let triangle = self.free_triangles.pop().unwrap_or_else(|| {
            self.corners.push([NONE; 3]);
            self.twins.extend([NONE; 3]);
            self.corners.len() as u32 - 1
        });
        self.corners[triangle as usize] = corners;
        for (k, corner) in (0..).zip(corners) {
            self.twins[(3 * triangle + k) as usize] = NONE;
            self.outgoing[corner as usize] = 3 * triangle + k;
        }
        self.link(3 * triangle, beyond);
        triangle
    }
}
