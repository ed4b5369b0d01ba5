//! Repair after places have moved: edges of which the other side lies within the circle about this one are flipped.
//!
//! `Lawson1977`: flips end at the Delaunay triangulation as long as all triangles stand upright. Places that move by less than half of their
//! distance keep them so but for slivers; where one would turn over, places go their ways in parts.

use rayon::prelude::*;

use super::{NONE, Triangulation, before, in_circle, next, orientation};
use crate::math::Vec2;

/// Places that a thread looks at, at least.
const AT_ONCE: usize = 256;

/// In how many parts a way is gone at most, before places are taken out and put in again.
const MOST_PARTS: u32 = 4;

/// What a move did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moved {
    /// Edges that were flipped.
    pub flips: usize,
    /// Whether all was triangulated afresh.
    pub is_renewed: bool,
    /// Whether there is no triangulation of the places any more.
    pub is_lost: bool,
}

/// What is wrong with a triangle.
enum Fault {
    TurnedOver,
    Edge(u32),
}

impl Triangulation {
    /// Moves places, each by its number and to where it goes; `has_moved` says the same of every number. Where a triangle would turn over they go
    /// their ways in parts.
    pub fn advance(&mut self, ways: &[(u32, Vec2)], has_moved: impl Fn(u32) -> bool + Sync) -> Moved {
        let mut moved = Moved::default();
        let starts: Vec<Vec2> = ways.iter().map(|&(place, _)| self.place(place)).collect();
        // Parts of the way that are behind, of so many.
        let (mut done, mut parts) = (0, 1);
        while done < parts {
            let share = f64::from(done + 1) / f64::from(parts);
            self.go(ways, &starts, share);
            match self.faults(ways, &has_moved) {
                Some(mut suspects) => {
                    moved.flips += self.flip_all(&mut suspects);
                    done += 1;
                }
                None if parts < MOST_PARTS => (done, parts) = (2 * done, 2 * parts),
                None => {
                    let turned = self.turned_over(ways);
                    self.go(ways, &starts, f64::from(done) / f64::from(parts));
                    if !self.put_again(turned, ways, &starts, &has_moved) {
                        self.go(ways, &starts, 1.0);
                        // Those that were taken out have their places again.
                        ways.iter().for_each(|&(place, _)| self.outgoing[place as usize] = 0);
                        moved.is_lost = !self.renew();
                        moved.is_renewed = true;
                    }
                    return moved;
                }
            }
        }
        moved
    }

    /// Places that have moved and are corners of triangles that turned over.
    fn turned_over(&self, ways: &[(u32, Vec2)]) -> Vec<u32> {
        let is_turned = |place: u32| self.around(place).any(|spoke| orientation(self.triangle(spoke.sides[1])) <= 0.0);
        ways.iter().map(|way| way.0).filter(|&place| is_turned(place)).collect()
    }

    /// Takes places out, moves all others to the ends of their ways, and puts those in there; whether that could be done. Places whose triangles
    /// then turn over are taken out, too.
    fn put_again(
        &mut self,
        mut places: Vec<u32>,
        ways: &[(u32, Vec2)],
        starts: &[Vec2],
        has_moved: &(impl Fn(u32) -> bool + Sync),
    ) -> bool {
        let before: Vec<Vec2> = ways.iter().map(|&(place, _)| self.place(place)).collect();
        let mut out = 0;
        loop {
            places[out..].iter().for_each(|&place| self.take_out(place));
            out = places.len();
            let is_kept = |place: u32| self.has(place);
            let kept = ways.iter().copied().zip(starts.iter().copied()).filter(|((place, _), _)| is_kept(*place));
            let (kept, starts): (Vec<(u32, Vec2)>, Vec<Vec2>) = kept.unzip();
            self.go(&kept, &starts, 1.0);
            if let Some(mut suspects) = self.faults(&kept, has_moved) {
                self.flip_all(&mut suspects);
                break;
            }
            places.extend(self.turned_over(&kept));
            if places.len() == out {
                return false;
            }
            let back = ways.iter().zip(&before).filter(|((place, _), _)| self.outgoing[*place as usize] != NONE);
            back.for_each(|(&(place, _), &before)| self.places[place as usize] = before);
        }
        let mut near = self.outgoing.iter().position(|&edge| edge != NONE).map_or(NONE, |place| self.outgoing[place]);
        for &place in &places {
            let Some(&(_, end)) = ways.iter().find(|way| way.0 == place) else { return false };
            if near == NONE || !self.put_in(place, end, near / 3) {
                return false;
            }
            near = self.outgoing[place as usize];
        }
        true
    }

    /// Puts places so far on their ways.
    fn go(&mut self, ways: &[(u32, Vec2)], starts: &[Vec2], share: f64) {
        for (&(place, end), &start) in ways.iter().zip(starts) {
            self.places[place as usize] = if share < 1.0 { start + (end - start) * share } else { end };
        }
    }

    /// Edges to be flipped, beside places that have moved; none where a triangle has turned over.
    fn faults(&self, ways: &[(u32, Vec2)], has_moved: &(impl Fn(u32) -> bool + Sync)) -> Option<Vec<u32>> {
        // Each triangle once, from the first of its corners that have moved.
        let own = |&(place, _): &(u32, Vec2)| {
            let is_first = move |triangle: &u32| {
                self.corners[*triangle as usize].iter().all(|&corner| corner >= place || !has_moved(corner))
            };
            self.around(place).map(|spoke| spoke.sides[1]).filter(is_first)
        };
        let of_place = |way: &(u32, Vec2)| own(way).flat_map(|triangle| self.faults_of(triangle, has_moved));
        let faults: Vec<Fault> = ways.par_iter().with_min_len(AT_ONCE).flat_map_iter(of_place).collect();
        let edge = |fault: Fault| if let Fault::Edge(edge) = fault { Some(edge) } else { None };
        faults.into_iter().rev().map(edge).collect()
    }

    /// Faults of a triangle of which a corner has moved; edges are looked at from the side with the smaller number, and from that which has
    /// moved where the other has not.
    fn faults_of(&self, triangle: u32, has_moved: &impl Fn(u32) -> bool) -> impl Iterator<Item = Fault> {
        let is_upright = orientation(self.triangle(triangle)) > 0.0;
        let wrong = |edge: u32| {
            let twin = self.twins[edge as usize];
            if twin == NONE {
                return false;
            }
            let is_first = edge < twin || !self.corners[twin as usize / 3].iter().any(|&corner| has_moved(corner));
            is_first && self.is_to_be_flipped(edge)
        };
        let edges = [0, 1, 2].map(|k| 3 * triangle + k).map(|edge| (is_upright && wrong(edge)).then_some(edge));
        let turned = (!is_upright).then_some(Fault::TurnedOver);
        turned.into_iter().chain(edges.into_iter().flatten().map(Fault::Edge))
    }

    /// Whether the corner beyond an edge lies within the circle about the triangle of the edge.
    fn is_to_be_flipped(&self, edge: u32) -> bool {
        let twin = self.twins[edge as usize];
        twin != NONE && in_circle(self.triangle(edge / 3), self.place(self.from(before(twin)))) > 0.0
    }

    /// Flips edges that need it, and those that need it then; returns how many.
    pub(super) fn flip_all(&mut self, suspects: &mut Vec<u32>) -> usize {
        let mut flips = 0;
        while let Some(edge) = suspects.pop() {
            if self.corners[edge as usize / 3][0] != NONE && self.is_to_be_flipped(edge) {
                suspects.extend(self.flip(edge));
                flips += 1;
            }
        }
        flips
    }

    /// Flips an edge; returns the four edges around.
    fn flip(&mut self, edge: u32) -> [u32; 4] {
        let twin = self.twins[edge as usize];
        let (one, other) = (edge / 3, twin / 3);
        let (a, b) = (self.from(edge), self.to(edge));
        let (c, d) = (self.from(before(edge)), self.from(before(twin)));
        let outer = [next(twin), before(edge), before(twin), next(edge)].map(|edge| self.twins[edge as usize]);
        self.corners[one as usize] = [a, d, c];
        self.corners[other as usize] = [d, b, c];
        let (first, second) = (3 * one, 3 * other);
        let around = [first, first + 2, second, second + 1];
        for (own, outer) in around.into_iter().zip(outer) {
            self.link(own, outer);
        }
        self.link(first + 1, second + 2);
        for (place, edge) in [(a, first), (d, first + 1), (c, first + 2), (b, second + 1)] {
            self.outgoing[place as usize] = edge;
        }
        around
    }

    /// Makes two half-edges twins.
    pub(super) fn link(&mut self, a: u32, b: u32) {
        self.twins[a as usize] = b;
        if b != NONE {
            self.twins[b as usize] = a;
        }
    }
}
