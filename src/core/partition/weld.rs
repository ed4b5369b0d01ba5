//! One number for places that are the same but for rounding.

use std::collections::HashMap;

use super::TOLERANCE;
use crate::math::Vec2;

/// Edge of a bucket (spacings).
const BUCKET: f64 = 1e-6;

const NONE: u32 = u32::MAX;

/// Places with a number each.
///
/// The map is only looked up in, never gone through: its order has no part in the result.
#[derive(Default)]
pub struct Weld {
    /// The place of each number, as it came first.
    pub places: Vec<Vec2>,
    next: Vec<u32>,
    first: HashMap<(i64, i64), u32>,
}

impl Weld {
    /// The number of a place; a new one where no known place is nearer than the tolerance.
    pub fn number(&mut self, place: Vec2) -> u32 {
        if let Some(known) = self.known(place) {
            return known;
        }
        let number = self.places.len() as u32;
        let first = self.first.entry(bucket(place, Vec2::ZERO)).or_insert(NONE);
        self.next.push(*first);
        *first = number;
        self.places.push(place);
        number
    }

    /// The number of a place, if it is known.
    pub fn known(&self, place: Vec2) -> Option<u32> {
        let own = bucket(place, Vec2::ZERO);
        let mut tried = [own; 4];
        for (i, (x, y)) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].into_iter().enumerate() {
            tried[i] = bucket(place, Vec2::new(x, y) * TOLERANCE);
        }
        if tried.iter().all(|bucket| *bucket == own) {
            return self.within(own, place);
        }
        tried.iter().find_map(|bucket| self.within(*bucket, place))
    }

    fn within(&self, bucket: (i64, i64), place: Vec2) -> Option<u32> {
        let mut number = *self.first.get(&bucket)?;
        while number != NONE {
            if (self.places[number as usize] - place).norm_squared() <= TOLERANCE * TOLERANCE {
                return Some(number);
            }
            number = self.next[number as usize];
        }
        None
    }
}

fn bucket(place: Vec2, shift: Vec2) -> (i64, i64) {
    let place = (place + shift) / BUCKET;
    (place.x.floor() as i64, place.y.floor() as i64)
}
