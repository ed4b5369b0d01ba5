//! Mirror images: what a particle sees in the walls near it.
//!
//! A wall acts through the mirror images of the particle itself and of its neighbours: position reflected, normal velocity
//! turned round, depth, bed and surface level as they are. An image counts when the line of sight to it goes through the
//! wall itself and nothing else stands in the way; two walls that are not parallel give images of images, which closes
//! corners. So a straight wall made of several pieces acts as one, and the end of a wall ends its image.
//!
//! A particle sees images only in walls within its own support, and of these in the nearest ones: a wide particle of thin
//! water has hundreds of walls within reach, and the far ones would cost more than all other particles together.

use super::edge::{Edge, distance_to_segment};
use super::isometry::{Corner, Image, Isometry, Viewpoint};
use super::sight::WallBefore;
use super::wall::Walls;
use crate::math::Vec2;

/// Images are seen in so many walls at most: about twice as many as a jagged shore puts within an ordinary support.
const MOST_WALLS: usize = 24;

/// Scratch space of the search for images, one for each thread's chunk.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct ImageScratch {
    /// Walls near the particle, the nearest ones first in case there are too many.
    near: Vec<u32>,
    /// Those that were too many: they hide, but show no image.
    farther: Vec<u32>,
    by_distance: Vec<(f64, u32)>,
    corners: Vec<Corner>,
    places: Vec<Vec2>,
    marks: Marks,
    pieces: Pieces,
}

/// The walls near a particle, one column for each quantity.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
struct Pieces {
    start_x: Vec<f64>,
    start_y: Vec<f64>,
    /// From start to end (m).
    piece_x: Vec<f64>,
    piece_y: Vec<f64>,
    length_squared: Vec<f64>,
}

impl Pieces {
    fn fill(&mut self, near: &[u32], edges: &[Edge]) {
        let columns = [&mut self.start_x, &mut self.start_y, &mut self.piece_x, &mut self.piece_y];
        columns.into_iter().chain([&mut self.length_squared]).for_each(Vec::clear);
        for edge in near.iter().map(|&member| &edges[member as usize]) {
            let piece = edge.end - edge.start;
            self.start_x.push(edge.start.x);
            self.start_y.push(edge.start.y);
            self.piece_x.push(piece.x);
            self.piece_y.push(piece.y);
            self.length_squared.push(piece.norm_squared());
        }
    }
}

/// Whether one of the walls stands on the way from a place to another one on wall `a`; see `Edge::crossing`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn is_blocked_before(pieces: &Pieces, a: usize, from: Vec2, hit: Vec2) -> bool {
    let n = pieces.start_x.len();
    let (start_x, start_y) = (&pieces.start_x[..n], &pieces.start_y[..n]);
    let (piece_x, piece_y) = (&pieces.piece_x[..n], &pieces.piece_y[..n]);
    let length_squared = &pieces.length_squared[..n];
    let mut blocked = 0;
    for k in 0..n {
        let (from_x, from_y) = (from.x - start_x[k], from.y - start_y[k]);
        let turn_from = piece_x[k] * from_y - piece_y[k] * from_x;
        let turn_hit = piece_x[k] * (hit.y - start_y[k]) - piece_y[k] * (hit.x - start_x[k]);
        let share = turn_from / (turn_from - turn_hit);
        let along_x = from.x + (hit.x - from.x) * share - start_x[k];
        let along_y = from.y + (hit.y - from.y) * share - start_y[k];
        let along = piece_x[k] * along_x + piece_y[k] * along_y;
        let is_blocked = (turn_from * turn_hit < 0.0)
            & (along >= 0.0)
            & (along <= length_squared[k])
            & (share < 1.0 - 1e-9)
            & (k != a);
        blocked |= u64::from(is_blocked);
    }
    blocked != 0
}

/// The particles that were found and what the walls do to them, one column for each quantity.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
struct Marks {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Square of the distance (m²) up to which the particle or its image acts.
    reach_squared: Vec<f64>,
    /// Not 0 where a wall hides the particle itself.
    hidden: Vec<u64>,
    /// Bit a is set where the line of sight to the image goes through wall a.
    mirrored: Vec<u64>,
    /// Bit c is set where the line of sight to the image in corner c may go through both of its walls.
    cornered: Vec<u64>,
}

/// One wall for the loop over particles.
struct Mirror<'a> {
    bit: u32,
    edge: &'a Edge,
    margin: f64,
    reflection: Isometry,
}

impl Mirror<'_> {
    /// The wall as it stands before a place.
    #[inline(always)]
    fn before(&self, place: Vec2) -> WallBefore {
        WallBefore::new(place, self.edge, self.margin)
    }
}

impl Marks {
    /// Takes the particles found, without any mark.
    fn fill(&mut self, found: &[u32], positions: &[Vec2], supports: &[f32], support: f64) {
        self.x.clear();
        self.y.clear();
        self.reach_squared.clear();
        for &j in found {
            let (position, reach) = (positions[j as usize], support.max(f64::from(supports[j as usize])));
            self.x.push(position.x);
            self.y.push(position.y);
            self.reach_squared.push(reach * reach);
        }
        for marks in [&mut self.hidden, &mut self.mirrored, &mut self.cornered] {
            marks.clear();
            marks.resize(found.len(), 0);
        }
    }

    /// Marks the particles that a wall hides and those whose images it shows; see `Edge::crossing`.
    fn look_at(&mut self, place: Vec2, mirror: &Mirror<'_>) {
        let columns = (&self.x[..], &self.y[..], &self.reach_squared[..]);
        look_at(columns, &mut self.hidden, &mut self.mirrored, place, mirror);
    }

    /// Marks the particles that a wall hides.
    fn look_behind(&mut self, wall: &WallBefore) {
        look_behind((&self.x[..], &self.y[..]), &mut self.hidden, wall);
    }

    /// Marks the particles whose images in a corner may be seen through its first wall and then through its second one.
    fn look_into(&mut self, place: Vec2, first: &Mirror<'_>, second: &Mirror<'_>) {
        let columns = (&self.x[..], &self.y[..], &self.reach_squared[..]);
        look_into(columns, &mut self.cornered, place, first, second);
    }
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn look_into(
    (x, y, reach_squared): (&[f64], &[f64], &[f64]),
    cornered: &mut [u64],
    place: Vec2,
    first: &Mirror<'_>,
    second: &Mirror<'_>,
) {
    let n = x.len();
    let (y, reach_squared, cornered) = (&y[..n], &reach_squared[..n], &mut cornered[..n]);
    let (whole, half) = (&first.reflection, &second.reflection);
    let (wall, other_wall) = (first.before(place), second.before(place));
    for k in 0..n {
        let image_x = whole.image_of_x.x * x[k] + whole.image_of_y.x * y[k] + whole.shift.x;
        let image_y = whole.image_of_x.y * x[k] + whole.image_of_y.y * y[k] + whole.shift.y;
        let middle_x = half.image_of_x.x * x[k] + half.image_of_y.x * y[k] + half.shift.x;
        let middle_y = half.image_of_x.y * x[k] + half.image_of_y.y * y[k] + half.shift.y;
        let (to_x, to_y) = (image_x - place.x, image_y - place.y);
        let may_be_seen = (to_x * to_x + to_y * to_y < reach_squared[k])
            & wall.is_on_the_way(image_x, image_y)
            & (other_wall.side(middle_x, middle_y) < 0.0);
        cornered[k] |= u64::from(may_be_seen) << first.bit;
    }
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn look_at(
    (x, y, reach_squared): (&[f64], &[f64], &[f64]),
    hidden: &mut [u64],
    mirrored: &mut [u64],
    place: Vec2,
    mirror: &Mirror<'_>,
) {
    let n = x.len();
    let (y, reach_squared, hidden, mirrored) = (&y[..n], &reach_squared[..n], &mut hidden[..n], &mut mirrored[..n]);
    let Mirror { bit, reflection, .. } = mirror;
    let wall = mirror.before(place);
    for k in 0..n {
        let image_x = reflection.image_of_x.x * x[k] + reflection.image_of_y.x * y[k] + reflection.shift.x;
        let image_y = reflection.image_of_x.y * x[k] + reflection.image_of_y.y * y[k] + reflection.shift.y;
        let (to_x, to_y) = (image_x - place.x, image_y - place.y);
        let is_shown = (to_x * to_x + to_y * to_y < reach_squared[k])
            & (wall.side(x[k], y[k]) > 0.0)
            & wall.is_on_the_way(image_x, image_y);
        hidden[k] |= u64::from(wall.is_on_the_way(x[k], y[k]));
        mirrored[k] |= u64::from(is_shown) << bit;
    }
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn look_behind((x, y): (&[f64], &[f64]), hidden: &mut [u64], wall: &WallBefore) {
    let n = x.len();
    let (y, hidden) = (&y[..n], &mut hidden[..n]);
    for k in 0..n {
        hidden[k] |= u64::from(wall.is_on_the_way(x[k], y[k]));
    }
}

/// A particle, given by its index, that a place may see in walls.
struct Sight {
    place: Vec2,
    other: Vec2,
    index: u32,
}

impl Walls {
    /// Appends to `seen` what is seen of the particles `found`: by one of them, itself in walls included, or from a bare place.
    ///
    /// - `supports`: distance (m) up to which each particle acts
    pub fn see(
        &self,
        from: &Viewpoint,
        found: &[u32],
        positions: &[Vec2],
        supports: &[f32],
        scratch: &mut ImageScratch,
        seen: &mut Vec<Image>,
    ) {
        let &Viewpoint { place, support, particle } = from;
        if let (Some(virtuals), Some(particle)) = (self.virtual_particles(), particle) {
            return self.see_virtual(virtuals, (from, particle), found, positions, &mut scratch.near, seen);
        }
        let edges = self.edges();
        self.near(place, support, &mut scratch.near);
        scratch.near.retain(|&member| !edges[member as usize].is_open);
        let has_many = scratch.near.len() > MOST_WALLS;
        scratch.farther.clear();
        if has_many {
            self.keep_nearest(place, scratch);
        }
        self.list_corners(place, scratch);
        scratch.pieces.fill(&scratch.near, edges);
        self.mark(place, support, found, positions, supports, scratch);
        for (k, &j) in found.iter().enumerate() {
            let other = positions[j as usize];
            if particle != Some(j) {
                let is_beyond = (other - place).norm_squared() > support * support;
                if scratch.marks.hidden[k] != 0 || is_beyond && self.is_walled(place, other) {
                    continue;
                }
                seen.push(Image { index: j, transform: 0 });
            }
            scratch.places.clear();
            let sight = Sight { place, other, index: j };
            self.see_in_walls(&sight, scratch.marks.mirrored[k], scratch, seen);
            self.see_in_corners(&sight, scratch.marks.cornered[k], scratch, seen);
        }
    }

    /// Appends the images in those of the walls near a place whose bit is set.
    #[inline]
    fn see_in_walls(&self, sight: &Sight, mut mirrored: u64, scratch: &mut ImageScratch, seen: &mut Vec<Image>) {
        let &Sight { place, other, index } = sight;
        while mirrored != 0 {
            let a = mirrored.trailing_zeros() as usize;
            mirrored &= mirrored - 1;
            let transform = Walls::reflection_in(scratch.near[a]);
            let image = self.isometries()[transform as usize].point(other);
            if self.is_in_sight(&scratch.near, &scratch.pieces, a, place, other, image)
                && is_new(&mut scratch.places, image, self.margin())
            {
                seen.push(Image { index, transform });
            }
        }
    }

    /// Appends the images of images in those of the corners near a place whose bit is set.
    #[inline]
    fn see_in_corners(&self, sight: &Sight, mut cornered: u64, scratch: &mut ImageScratch, seen: &mut Vec<Image>) {
        let (&Sight { place, other, index }, edges) = (sight, self.edges());
        while cornered != 0 {
            let corner = &scratch.corners[cornered.trailing_zeros() as usize];
            cornered &= cornered - 1;
            let image = self.isometries()[corner.transform as usize].point(other);
            let middle = self.isometries()[Walls::reflection_in(corner.second) as usize].point(other);
            let (first, second) = (&edges[corner.first as usize], &edges[corner.second as usize]);
            if self.is_seen_twice(first, second, place, image, middle)
                && is_new(&mut scratch.places, image, self.margin())
            {
                seen.push(Image { index, transform: corner.transform });
            }
        }
    }

    /// Marks what the walls near a place do to the particles found.
    fn mark(
        &self,
        place: Vec2,
        support: f64,
        found: &[u32],
        positions: &[Vec2],
        supports: &[f32],
        scratch: &mut ImageScratch,
    ) {
        scratch.marks.fill(found, positions, supports, support);
        let mirror = |bit: usize, member: u32, transform: u32| Mirror {
            bit: bit as u32,
            edge: &self.edges()[member as usize],
            margin: self.margin(),
            reflection: self.isometries()[transform as usize],
        };
        for (bit, &member) in scratch.near.iter().enumerate() {
            scratch.marks.look_at(place, &mirror(bit, member, Walls::reflection_in(member)));
        }
        for &member in &scratch.farther {
            scratch.marks.look_behind(&WallBefore::new(place, &self.edges()[member as usize], self.margin()));
        }
        for (bit, corner) in scratch.corners.iter().enumerate() {
            let first = mirror(bit, corner.first, corner.transform);
            let second = mirror(bit, corner.second, Walls::reflection_in(corner.second));
            scratch.marks.look_into(place, &first, &second);
        }
    }

    /// Cuts the walls near a place down to the nearest ones.
    fn keep_nearest(&self, place: Vec2, scratch: &mut ImageScratch) {
        let distance = |member: u32| {
            let edge = &self.edges()[member as usize];
            distance_to_segment(place, edge.start, edge.end)
        };
        scratch.by_distance.clear();
        scratch.by_distance.extend(scratch.near.iter().map(|&member| (distance(member), member)));
        scratch.by_distance.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (nearest, farther) = scratch.by_distance.split_at(MOST_WALLS);
        scratch.near.clear();
        scratch.near.extend(nearest.iter().map(|&(_, member)| member));
        scratch.farther.extend(farther.iter().map(|&(_, member)| member));
    }

    /// Lists the corners near a place in which it can see an image of an image.
    ///
    /// The line of sight runs from the place to the first wall and from there to the second one, all on one side of each: so
    /// each of them has an end on the side of the other on which the place lies.
    fn list_corners(&self, place: Vec2, scratch: &mut ImageScratch) {
        let edges = self.edges();
        let reaches = |wall: &Edge, other: &Edge| {
            let side = wall.turn(place).signum();
            (side * wall.turn(other.start)).max(side * wall.turn(other.end)) >= 0.0
        };
        scratch.corners.clear();
        for &member in &scratch.near {
            for corner in self.corners_of(member) {
                let (first, second) = (&edges[corner.first as usize], &edges[corner.second as usize]);
                let is_full = scratch.corners.len() == u64::BITS as usize;
                if !is_full && reaches(first, second) && reaches(second, first) && scratch.near.contains(&corner.second)
                {
                    scratch.corners.push(*corner);
                }
            }
        }
    }

    /// Whether no other wall stands in either leg of the line of sight through wall `a`.
    fn is_in_sight(&self, near: &[u32], pieces: &Pieces, a: usize, place: Vec2, other: Vec2, image: Vec2) -> bool {
        let Some(share) = self.edges()[near[a] as usize].crossing(place, image, self.margin()) else { return false };
        let hit = place + (image - place) * share;
        !is_blocked_before(pieces, a, place, hit) && !is_blocked_before(pieces, a, other, hit)
    }

    /// Whether the line of sight goes through wall `first` and then through wall `second`.
    ///
    /// A line of sight through the very corner counts: it touches `second` where it meets `first`.
    fn is_seen_twice(&self, first: &Edge, second: &Edge, place: Vec2, image: Vec2, middle: Vec2) -> bool {
        let Some(share) = first.crossing(place, image, self.margin()) else { return false };
        let hit = place + (image - place) * share;
        if second.turn(place) * second.turn(middle) >= 0.0 {
            return false;
        }
        // Stepping back by a margin keeps a hit in the corner on the near side of the second wall.
        let before = hit + (place - hit) * (10.0 * self.margin() / (place - hit).norm().max(10.0 * self.margin()));
        second.crossing(before, middle, 20.0 * self.margin()).is_some()
    }
}

/// Notes an image's place and tells whether it was new: the joint of two pieces of one wall shows an image twice.
fn is_new(places: &mut Vec<Vec2>, image: Vec2, margin: f64) -> bool {
    let is_known = places.iter().any(|&place| (place - image).norm() < 100.0 * margin);
    if !is_known {
        places.push(image);
    }
    !is_known
}

#[cfg(test)]
mod tests;
