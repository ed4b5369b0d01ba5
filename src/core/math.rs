//! Vectors, rectangles and symmetric matrices of the plane, numbers as people read them, and how many the processor takes at once.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A vector of the plane.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable, serde::Serialize, serde::Deserialize,
)]
#[repr(C)]
pub struct Vec2 {
    /// Component to the east.
    pub x: f64,
    /// Component to the north.
    pub y: f64,
}

impl Vec2 {
    /// The zero vector.
    pub const ZERO: Vec2 = Vec2 { x: 0.0, y: 0.0 };

    /// A vector from its components.
    #[inline]
    pub const fn new(x: f64, y: f64) -> Self {
        Vec2 { x, y }
    }

    /// Scalar product.
    #[inline]
    pub fn dot(self, other: Vec2) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// The z component of the vector product: positive when `other` lies to the left of `self`.
    #[inline]
    pub fn cross(self, other: Vec2) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Square of the length.
    #[inline]
    pub fn norm_squared(self) -> f64 {
        self.dot(self)
    }

    /// Length.
    #[inline]
    pub fn norm(self) -> f64 {
        self.norm_squared().sqrt()
    }

    /// The vector turned by 90 degrees to the left.
    #[inline]
    pub fn perpendicular(self) -> Vec2 {
        Vec2::new(-self.y, self.x)
    }
}

/// A rectangle with sides parallel to the axes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rectangle {
    /// Its south-western corner (m).
    pub low: Vec2,
    /// Its north-eastern corner (m).
    pub high: Vec2,
}

impl Rectangle {
    /// The one that no place lies in.
    pub const NOWHERE: Rectangle = Rectangle {
        low: Vec2 { x: f64::INFINITY, y: f64::INFINITY },
        high: Vec2 { x: f64::NEG_INFINITY, y: f64::NEG_INFINITY },
    };

    /// The rectangle around places; none of no place.
    pub fn about(places: impl IntoIterator<Item = Vec2>) -> Option<Rectangle> {
        places.into_iter().map(|place| Rectangle { low: place, high: place }).reduce(Rectangle::around)
    }

    /// The rectangle around both.
    #[must_use]
    pub fn around(self, other: Rectangle) -> Rectangle {
        Rectangle {
            low: Vec2::new(self.low.x.min(other.low.x), self.low.y.min(other.low.y)),
            high: Vec2::new(self.high.x.max(other.high.x), self.high.y.max(other.high.y)),
        }
    }

    /// Width and height (m).
    pub fn size(self) -> Vec2 {
        self.high - self.low
    }

    /// Whether both have a place in common.
    pub fn meets(self, Rectangle { low, high }: Rectangle) -> bool {
        low.x <= self.high.x && low.y <= self.high.y && high.x >= self.low.x && high.y >= self.low.y
    }

    /// Whether a place lies in it, or on a side.
    pub fn holds(self, place: Vec2) -> bool {
        self.meets(Rectangle { low: place, high: place })
    }

    /// The shares of a straight way at which it comes into the rectangle and leaves it; none of one that passes beside it.
    pub fn share_of(self, [start, end]: [Vec2; 2]) -> Option<(f64, f64)> {
        let Rectangle { low, high } = self;
        let along = end - start;
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (place, step, low, high) in [(start.x, along.x, low.x, high.x), (start.y, along.y, low.y, high.y)] {
            // Along a side it is in between or not, all of it.
            if step.abs() < f64::MIN_POSITIVE {
                if place < low || place > high {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - place) / step, (high - place) / step);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        (from <= to).then_some((from, to))
    }
}

impl Add for Vec2 {
    type Output = Vec2;
    #[inline]
    fn add(self, other: Vec2) -> Vec2 {
        Vec2::new(self.x + other.x, self.y + other.y)
    }
}

impl AddAssign for Vec2 {
    #[inline]
    fn add_assign(&mut self, other: Vec2) {
        *self = *self + other;
    }
}

impl Sub for Vec2 {
    type Output = Vec2;
    #[inline]
    fn sub(self, other: Vec2) -> Vec2 {
        Vec2::new(self.x - other.x, self.y - other.y)
    }
}

impl Neg for Vec2 {
    type Output = Vec2;
    #[inline]
    fn neg(self) -> Vec2 {
        Vec2::new(-self.x, -self.y)
    }
}

impl Mul<f64> for Vec2 {
    type Output = Vec2;
    #[inline]
    fn mul(self, factor: f64) -> Vec2 {
        Vec2::new(self.x * factor, self.y * factor)
    }
}

impl Div<f64> for Vec2 {
    type Output = Vec2;
    #[inline]
    fn div(self, divisor: f64) -> Vec2 {
        Vec2::new(self.x / divisor, self.y / divisor)
    }
}

/// A symmetric 2 by 2 matrix.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable, serde::Serialize, serde::Deserialize,
)]
#[repr(C)]
pub struct Sym2 {
    /// First diagonal entry.
    pub xx: f64,
    /// Off-diagonal entry.
    pub xy: f64,
    /// Second diagonal entry.
    pub yy: f64,
}

impl Sym2 {
    /// The unit matrix.
    pub const IDENTITY: Sym2 = Sym2 { xx: 1.0, xy: 0.0, yy: 1.0 };

    /// Determinant.
    #[inline]
    pub fn determinant(self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// Half the sum of the diagonal.
    #[inline]
    pub fn half_trace(self) -> f64 {
        0.5 * (self.xx + self.yy)
    }

    /// Matrix times vector.
    #[inline]
    pub fn apply(self, v: Vec2) -> Vec2 {
        Vec2::new(self.xx * v.x + self.xy * v.y, self.xy * v.x + self.yy * v.y)
    }

    /// The eigenvalues, smaller one first.
    #[inline]
    pub fn eigenvalues(self) -> (f64, f64) {
        let half_difference = 0.5 * (self.xx - self.yy);
        let radius = (half_difference * half_difference + self.xy * self.xy).sqrt();
        (self.half_trace() - radius, self.half_trace() + radius)
    }
}

/// Whether two straight pieces of line cross.
///
/// A point of `a` that lies on the line of `b` belongs to its northern side (of one due north to its western one), however `b` was
/// drawn, so that walls through a row of particles part them from exactly one and the same of their two neighbour rows; the ends of
/// `b` belong to it.
pub fn segments_cross(a: [Vec2; 2], b: [Vec2; 2]) -> bool {
    let is_eastward = b[0].x < b[1].x || (b[0].x <= b[1].x && b[0].y <= b[1].y);
    let b = if is_eastward { b } else { [b[1], b[0]] };
    let (along_a, along_b) = (a[1] - a[0], b[1] - b[0]);
    let side = |origin: Vec2, along: Vec2, point: Vec2| along.cross(point - origin);
    let (a0, a1) = (side(b[0], along_b, a[0]), side(b[0], along_b, a[1]));
    let (b0, b1) = (side(a[0], along_a, b[0]), side(a[0], along_a, b[1]));
    let differ = (a0 >= 0.0) != (a1 >= 0.0);
    let touches = (b0 >= 0.0 && b1 <= 0.0) || (b0 <= 0.0 && b1 >= 0.0);
    differ && touches
}

/// The larger number by one instruction, unlike `f64::max`; the second one where the first is none.
#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller number by one instruction, unlike `f64::min`; the second one where the first is none.
#[inline(always)]
pub fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The smaller of two numbers of one sign, in size; 0 where the signs differ.
pub fn minmod(a: f64, b: f64) -> f64 {
    if a * b <= 0.0 {
        0.0
    } else if a.abs() < b.abs() {
        a
    } else {
        b
    }
}

/// The greatest whole number not above `x`, below 2^53, by a cast: `f64::floor` is a call of a function on processors of the baseline.
#[inline(always)]
pub fn floor(x: f64) -> f64 {
    let towards_zero = x as i64 as f64;
    if towards_zero > x { towards_zero - 1.0 } else { towards_zero }
}

/// x^(−1/3) of a positive normal number, right to some units of the last digit, by arithmetic that runs on lanes, unlike `f64::cbrt`;
/// of 0 no number.
///
/// A first guess from a third of the exponent, right to 4 %, and twice y (1 + r/3 + 2 r²/9 + 14 r³/81), r = 1 − x y³: the error goes
/// with its fourth power.
#[inline(always)]
pub fn inverse_cube_root(x: f64) -> f64 {
    // The upper half of the bits over 3, as the upper half of a product; the constant makes the greatest error least.
    let third = (((x.to_bits() >> 32) * 0xaaaa_aaab) >> 33) as u32;
    let mut y = f64::from_bits(u64::from(0x553e_f0ff_u32.wrapping_sub(third)) << 32);
    for _ in 0..2 {
        let r = 1.0 - x * (y * y * y);
        y += y * r * (1.0 / 3.0 + r * (2.0 / 9.0 + r * (14.0 / 81.0)));
    }
    y
}

/// The number between two bounds by two instructions; the lower bound where it is none.
#[inline(always)]
pub fn clamp(value: f64, low: f64, high: f64) -> f64 {
    smaller(larger(value, low), high)
}

/// Most numbers that the processor takes at once. Loops over runs of that many cells leave no rest, which would be taken one by one and
/// at the price of a whole piece each.
pub const MOST_LANES: usize = 8;

/// The vector instructions that the hot loops use on this machine.
pub fn simd() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        // `multiversion` takes the AVX-512 copies only where the processor does not slow down for them: where it has these, too.
        let is_fast = std::arch::is_x86_feature_detected!("avx512vbmi2") && std::arch::is_x86_feature_detected!("gfni");
        if is_fast && std::arch::is_x86_feature_detected!("avx512vpopcntdq") {
            return "avx512";
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            return "avx2";
        }
    }
    "baseline"
}

/// A number to six significant digits, so that a message shows none of its rounding: 0.025 for 0.02499999999999858.
pub fn readable(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// An amount of memory (bytes) in a unit that fits, with one decimal: `12 B`, `1.5 MB`, `120000.0 GB`.
pub fn in_bytes(bytes: f64) -> String {
    match [("GB", 1e9), ("MB", 1e6), ("kB", 1e3)].into_iter().find(|(_, size)| bytes >= *size) {
        Some((unit, size)) => format!("{:.1} {unit}", bytes / size),
        None => format!("{bytes:.0} B"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_told_in_a_unit_that_fits() {
        for (bytes, text) in
            [(8.0, "8 B"), (1024.0, "1.0 kB"), (33.55e6, "33.5 MB"), (8e9, "8.0 GB"), (1.2e17, "120000000.0 GB")]
        {
            assert_eq!(in_bytes(bytes), text);
        }
    }

    #[test]
    fn a_readable_number_has_six_digits() {
        for (value, text) in
            [(0.02499999999999858, "0.025"), (-1234.5678, "-1234.57"), (0.0, "0"), (1e9 / 3.0, "333333000")]
        {
            assert_eq!(readable(value).to_string(), text);
        }
        assert!(readable(f64::NAN).is_nan() && readable(f64::INFINITY).is_infinite());
    }

    #[test]
    fn crossing_and_missing_segments() {
        let wall = [Vec2::new(0.0, -1.0), Vec2::new(0.0, 1.0)];
        assert!(segments_cross([Vec2::new(-1.0, 0.0), Vec2::new(1.0, 0.3)], wall));
        assert!(!segments_cross([Vec2::new(-1.0, 2.0), Vec2::new(1.0, 2.0)], wall));
        assert!(!segments_cross([Vec2::new(1.0, 0.0), Vec2::new(2.0, 0.0)], wall));
    }

    #[test]
    fn a_particle_on_the_wall_is_cut_off_on_one_side_only() {
        let wall = [Vec2::new(0.0, -1.0), Vec2::new(0.0, 1.0)];
        let east = segments_cross([Vec2::ZERO, Vec2::new(1.0, 0.0)], wall);
        let west = segments_cross([Vec2::new(-1.0, 0.0), Vec2::ZERO], wall);
        assert!(east != west);
    }

    #[test]
    fn walls_drawn_either_way_cut_a_particle_on_them_off_on_one_side() {
        let at = |x: f64, y: f64| Vec2::new(x, y);
        for (along, across) in
            [(at(1.0, 0.0), at(0.0, 1.0)), (at(0.0, 1.0), at(-1.0, 0.0)), (at(1.0, -1.0), at(1.0, 1.0))]
        {
            let wall = [along * -2.0, along * 2.0];
            for wall in [wall, [wall[1], wall[0]]] {
                assert!(!segments_cross([Vec2::ZERO, across], wall), "{wall:?}");
                assert!(segments_cross([across * -1.0, Vec2::ZERO], wall), "{wall:?}");
            }
        }
    }

    #[test]
    fn inverse_cube_root_is_right_to_the_last_digits() {
        for k in 0..60_000 {
            let x = 1e-9 * 10f64.powf(f64::from(k) * 2e-4);
            let error = inverse_cube_root(x) * x.cbrt() - 1.0;
            assert!(error.abs() < 1e-15, "{x}: {error}");
        }
        assert!(inverse_cube_root(0.0).is_nan() && inverse_cube_root(f64::NAN).is_nan());
    }

    #[test]
    fn floor_is_that_of_the_library() {
        for x in [-3.0, -2.5, -1.0, -0.3, -0.0, 0.0, 0.3, 1.0, 1.999, 7e9] {
            assert!((floor(x) - x.floor()).abs() < f64::MIN_POSITIVE, "{x}");
        }
    }

    #[test]
    fn cross_product_is_positive_to_the_left() {
        assert!(Vec2::new(1.0, 0.0).cross(Vec2::new(0.0, 1.0)) > 0.0);
        assert_eq!(Vec2::new(1.0, 0.0).perpendicular(), Vec2::new(0.0, 1.0));
    }

    #[test]
    fn eigenvalues_of_a_known_matrix() {
        let (small, large) = Sym2 { xx: 2.0, xy: 1.0, yy: 2.0 }.eigenvalues();
        assert!((small - 1.0).abs() < 1e-15 && (large - 3.0).abs() < 1e-15);
    }
}
