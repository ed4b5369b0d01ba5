//! The pairs of one particle side by side: what the loops over neighbours read and write, one column for each quantity.
//!
//! Neighbours are gathered in blocks, so that nothing is allocated and everything stays in the first level of the cache; the
//! loops over a block have no branch, and run on as many lanes as the processor has. All sums are taken in the same order
//! whatever that number is: eight of them side by side, one for each lane of a group, and these together at the end of the block.

use bytemuck::Pod;

use super::ridges::share_in_sight;
use super::{Gradients, State};
use crate::bed::BedParticles;
use crate::boundary::Isometry;
use crate::math::{Vec2, larger, smaller};
use crate::physics::kernel::{Shape, Smoothing};
use crate::solver::moving::{ChosenKernel, Seen, with_kernel};

/// Most pairs in a block.
pub(super) const BLOCK: usize = 64;
/// Blocks are filled up to a multiple of this number with pairs that weigh nothing.
pub(super) const LANES: usize = 8;

/// One quantity of all pairs of a block.
pub(super) type Column = [f64; BLOCK];

/// Columns of the pairs in work, to be read.
macro_rules! columns {
    ($pairs:ident, $n:ident: $($name:ident)+) => { $(let $name = &$pairs.$name[..$n];)+ };
}

/// Columns of one group of pairs.
macro_rules! group_of {
    ($pairs:ident, $group:ident: $($name:ident)+) => { $(let $name = &$pairs.$name.as_chunks::<LANES>().0[$group];)+ };
}

/// Columns of the pairs in work, to be written.
macro_rules! columns_mut {
    ($pairs:ident, $n:ident: $($name:ident)+) => { $(let $name = &mut $pairs.$name[..$n];)+ };
}
pub(super) use {columns, columns_mut, group_of};

/// The neighbours of a particle as it sees them: those behind a wall reflected.
#[derive(Clone, Debug)]
pub(super) struct Pairs {
    /// Number of pairs with those that fill up.
    len: usize,
    /// x_j − x_i (m).
    pub offset_x: Column,
    pub offset_y: Column,
    pub velocity_x: Column,
    pub velocity_y: Column,
    pub depth: Column,
    pub surface: Column,
    pub area: Column,
    pub inverse_h: Column,
    pub surface_x: Column,
    pub surface_y: Column,
    pub depth_x: Column,
    pub depth_y: Column,
    pub u_x: Column,
    pub u_y: Column,
    pub v_x: Column,
    pub v_y: Column,
    /// Distance r (m).
    pub r: Column,
    /// e, the unit vector from i to j; zero where both coincide.
    pub e_x: Column,
    pub e_y: Column,
    /// A_j G_ij (1/m).
    pub weight: Column,
    /// d_iR (m).
    pub own_depth: Column,
    /// Depths (m) at the face, above its sill.
    pub d_l: Column,
    pub d_r: Column,
    /// √(g d_l) (m/s).
    pub c_l: Column,
    /// Velocities (m/s) along e: of both particles, and of both sides of the face.
    pub own_u: Column,
    pub other_u: Column,
    pub u_l: Column,
    pub u_r: Column,
    pub p_star: Column,
    pub u_star: Column,
    /// a_1 (m).
    pub slope: Column,
    /// Δη − a_1 − a_2 (m).
    pub surface_jump: Column,
    /// b_1 − b_2 (m/s).
    pub velocity_jump: Column,
    /// w, the weight of the area.
    pub share: Column,
    /// A_j W(r, h_i).
    pub covered: Column,
}

impl Pairs {
    pub(super) fn new() -> Self {
        let zero = [0.0; BLOCK];
        Pairs {
            len: 0,
            offset_x: zero,
            offset_y: zero,
            velocity_x: zero,
            velocity_y: zero,
            depth: zero,
            surface: zero,
            area: zero,
            inverse_h: zero,
            surface_x: zero,
            surface_y: zero,
            depth_x: zero,
            depth_y: zero,
            u_x: zero,
            u_y: zero,
            v_x: zero,
            v_y: zero,
            r: zero,
            e_x: zero,
            e_y: zero,
            weight: zero,
            own_depth: zero,
            d_l: zero,
            d_r: zero,
            c_l: zero,
            own_u: zero,
            other_u: zero,
            u_l: zero,
            u_r: zero,
            p_star: zero,
            u_star: zero,
            slope: zero,
            surface_jump: zero,
            velocity_jump: zero,
            share: zero,
            covered: zero,
        }
    }

    /// Number of pairs in work, a multiple of the lanes.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Takes from the area of each pair what ridges hide of it; apart, so that the loop above stays as short without them.
    #[cold]
    fn hide(&mut self, me: &State, block: Seen<'_>, states: &[State], bed: &BedParticles) {
        for (k, &index) in block.indices.iter().enumerate() {
            let in_sight = share_in_sight(bed, me, &states[index as usize]);
            if in_sight > 0.0 {
                self.area[k] *= in_sight;
            } else {
                self.set_nothing(k, me);
            }
        }
    }

    /// A particle's pair with itself, of no area: it adds nothing to any sum.
    fn set_nothing(&mut self, k: usize, me: &State) {
        (self.offset_x[k], self.offset_y[k]) = (0.0, 0.0);
        (self.velocity_x[k], self.velocity_y[k]) = (me.velocity.x, me.velocity.y);
        (self.depth[k], self.surface[k]) = (me.depth, me.surface);
        (self.area[k], self.inverse_h[k]) = (0.0, me.inverse_h);
    }

    /// Distances, directions and weights from offsets, areas and smoothing lengths. `COVERS`: also the weight w of each
    /// pair's area, and A_j W(r, h_i).
    #[inline(always)]
    fn measure_with<S: Shape, const COVERS: bool>(&mut self, inverse_h: f64, kernel: &Smoothing<S>) {
        let n = self.len;
        let (x, y) = (&self.offset_x[..n], &self.offset_y[..n]);
        let (area, other_inverse_h) = (&self.area[..n], &self.inverse_h[..n]);
        let (r, weight) = (&mut self.r[..n], &mut self.weight[..n]);
        let (e_x, e_y) = (&mut self.e_x[..n], &mut self.e_y[..n]);
        let (share, covered) = (&mut self.share[..n], &mut self.covered[..n]);
        for k in 0..n {
            let distance = (x[k] * x[k] + y[k] * y[k]).sqrt();
            let inverse = 1.0 / larger(distance, f64::MIN_POSITIVE);
            let slopes = kernel.slope(distance, inverse_h) + kernel.slope(distance, other_inverse_h[k]);
            r[k] = distance;
            e_x[k] = x[k] * inverse;
            e_y[k] = y[k] * inverse;
            weight[k] = -0.5 * area[k] * slopes;
            if COVERS {
                // The pairs that fill up have no area and must not count.
                let is_real = if area[k] > 0.0 { 1.0 } else { 0.0 };
                share[k] = is_real * kernel.share(distance, smaller(inverse_h, other_inverse_h[k]));
                covered[k] = area[k] * kernel.value(distance, inverse_h);
            }
        }
    }
}

/// What neighbours need to know of a particle, eight numbers in one cache line.
trait Line: Pod {
    /// As it is seen under an isometry.
    fn seen_under(&self, isometry: &Isometry) -> Self;
}

impl Line for State {
    fn seen_under(&self, isometry: &Isometry) -> State {
        State { position: isometry.point(self.position), velocity: isometry.vector(self.velocity), ..*self }
    }
}

impl Line for Gradients {
    fn seen_under(&self, isometry: &Isometry) -> Gradients {
        // T' = R T Rᵀ for the gradient of the velocity: first the rows, then the columns.
        let (u, v) = (isometry.vector(self.u), isometry.vector(self.v));
        let (along_x, along_y) = (isometry.vector(Vec2::new(u.x, v.x)), isometry.vector(Vec2::new(u.y, v.y)));
        Gradients {
            surface: isometry.vector(self.surface),
            depth: isometry.vector(self.depth),
            u: Vec2::new(along_x.x, along_y.x),
            v: Vec2::new(along_x.y, along_y.y),
        }
    }
}

/// The columns of a group of neighbours, filled up with particle `i` itself.
macro_rules! columns_of_group {
    ($block:expr, $group:expr, $i:expr, $all:expr, $isometries:expr) => {{
        let (block, first, all) = ($block, $group * LANES, $all);
        let rest = &block.indices[first..];
        let indices = match rest.first_chunk::<LANES>() {
            Some(indices) => *indices,
            None => std::array::from_fn(|k| rest.get(k).copied().unwrap_or($i)),
        };
        let turned;
        let mut lines: [&_; LANES] = std::array::from_fn(|k| &all[indices[k] as usize]);
        if block.has_images() {
            turned = turned_group(block, first, lines, $isometries);
            lines = turned.each_ref();
        }
        multiversion::target::match_target! {
            "x86_64+avx512f+avx512vl" => transposed_by_lanes(lines),
            _ => transposed(lines),
        }
    }};
}

/// The same group as the particle sees it; apart, because walls are far from most particles.
#[cold]
fn turned_group<T: Line>(block: Seen<'_>, first: usize, lines: [&T; LANES], isometries: &[Isometry]) -> [T; LANES] {
    std::array::from_fn(|k| match block.transform(first + k) {
        0 => *lines[k],
        transform => lines[k].seen_under(&isometries[transform as usize]),
    })
}

/// Gathers the states of one block of neighbours, `BLOCK` at most; beside `ridges` with the share of their area that is in sight.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn gather_states(
    pairs: &mut Pairs,
    i: usize,
    block: Seen<'_>,
    states: &[State],
    isometries: &[Isometry],
    ridges: Option<&BedParticles>,
) {
    pairs.len = block.indices.len().next_multiple_of(LANES);
    let me = &states[i];
    for group in 0..pairs.len / LANES {
        let [x, y, columns @ ..] = columns_of_group!(block, group, i as u32, states, isometries);
        set(&mut pairs.offset_x, group, x.map(|x| x - me.position.x));
        set(&mut pairs.offset_y, group, y.map(|y| y - me.position.y));
        let [velocity_x, velocity_y, depth, surface, area, inverse_h] = columns;
        set(&mut pairs.velocity_x, group, velocity_x);
        set(&mut pairs.velocity_y, group, velocity_y);
        set(&mut pairs.depth, group, depth);
        set(&mut pairs.surface, group, surface);
        set(&mut pairs.area, group, area);
        set(&mut pairs.inverse_h, group, inverse_h);
    }
    // What fills up a group has no area: it adds nothing to any sum.
    pairs.area[block.indices.len()..pairs.len].fill(0.0);
    if let Some(bed) = ridges {
        pairs.hide(me, block, states, bed);
    }
}

/// Gathers the gradients of the same neighbours, turned as the particle sees them.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn gather_gradients(
    pairs: &mut Pairs,
    i: usize,
    block: Seen<'_>,
    gradients: &[Gradients],
    isometries: &[Isometry],
) {
    for group in 0..pairs.len / LANES {
        let [surface_x, surface_y, depth_x, depth_y, u_x, u_y, v_x, v_y] =
            columns_of_group!(block, group, i as u32, gradients, isometries);
        set(&mut pairs.surface_x, group, surface_x);
        set(&mut pairs.surface_y, group, surface_y);
        set(&mut pairs.depth_x, group, depth_x);
        set(&mut pairs.depth_y, group, depth_y);
        set(&mut pairs.u_x, group, u_x);
        set(&mut pairs.u_y, group, u_y);
        set(&mut pairs.v_x, group, v_x);
        set(&mut pairs.v_y, group, v_y);
    }
}

#[inline(always)]
fn set(column: &mut Column, group: usize, values: [f64; LANES]) {
    column.as_chunks_mut().0[group] = values;
}

/// Rows become columns.
#[inline(always)]
fn transposed<T: Line>(rows: [&T; LANES]) -> [[f64; LANES]; LANES] {
    let rows: [[f64; LANES]; LANES] = rows.map(|&row| bytemuck::cast(row));
    std::array::from_fn(|column| rows.map(|row| row[column]))
}

/// The same by shuffles of whole rows: of single numbers, of pairs and of pairs of pairs.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl")]
#[inline]
fn transposed_by_lanes<T: Line>(rows: [&T; LANES]) -> [[f64; LANES]; LANES] {
    use std::arch::x86_64::{__m512d, _mm512_shuffle_f64x2, _mm512_unpackhi_pd, _mm512_unpacklo_pd};

    // One by one: arrays of rows would go through memory.
    let row = |k: usize| -> __m512d { bytemuck::cast(*rows[k]) };
    let (a, b, c, d, e, f, g, h) = (row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7));
    // Of the even or odd columns of eight rows: columns 0 or 1, 2 or 3, 4 or 5, 6 or 7.
    let of_pairs = |ab, cd, ef, gh| {
        let (near, far) = (_mm512_shuffle_f64x2::<0x88>(ab, cd), _mm512_shuffle_f64x2::<0x88>(ef, gh));
        let (first, third) = (_mm512_shuffle_f64x2::<0x88>(near, far), _mm512_shuffle_f64x2::<0xdd>(near, far));
        let (near, far) = (_mm512_shuffle_f64x2::<0xdd>(ab, cd), _mm512_shuffle_f64x2::<0xdd>(ef, gh));
        let (second, fourth) = (_mm512_shuffle_f64x2::<0x88>(near, far), _mm512_shuffle_f64x2::<0xdd>(near, far));
        [first, second, third, fourth]
    };
    let even = of_pairs(
        _mm512_unpacklo_pd(a, b),
        _mm512_unpacklo_pd(c, d),
        _mm512_unpacklo_pd(e, f),
        _mm512_unpacklo_pd(g, h),
    );
    let odd = of_pairs(
        _mm512_unpackhi_pd(a, b),
        _mm512_unpackhi_pd(c, d),
        _mm512_unpackhi_pd(e, f),
        _mm512_unpackhi_pd(g, h),
    );
    let column = |column: __m512d| -> [f64; LANES] { bytemuck::must_cast(column) };
    [
        column(even[0]),
        column(odd[0]),
        column(even[1]),
        column(odd[1]),
        column(even[2]),
        column(odd[2]),
        column(even[3]),
        column(odd[3]),
    ]
}

/// Distances, directions and weights of all pairs, by the chosen kernel.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn measure(pairs: &mut Pairs, inverse_h: f64, kernel: &ChosenKernel) {
    with_kernel!(kernel, kernel => pairs.measure_with::<_, false>(inverse_h, kernel));
}

/// The same, and the weight w of each pair's area, and A_j W(r, h_i).
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn measure_and_cover(pairs: &mut Pairs, inverse_h: f64, kernel: &ChosenKernel) {
    with_kernel!(kernel, kernel => pairs.measure_with::<_, true>(inverse_h, kernel));
}

/// The sum over the lanes.
#[inline(always)]
pub(super) fn total([a, b, c, d, e, f, g, h]: [f64; LANES]) -> f64 {
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(i: usize) -> State {
        let number = |k: usize| (8 * i + k) as f64;
        State {
            position: Vec2::new(number(0), number(1)),
            velocity: Vec2::new(number(2), number(3)),
            depth: number(4),
            surface: number(5),
            area: number(6),
            inverse_h: number(7),
        }
    }

    #[test]
    fn gathers_every_number_to_its_place() {
        let states: Vec<State> = (0..40).map(state).collect();
        let indices: Vec<u32> = (0..13).map(|k| (k * 7) % 40).collect();
        let mirror = Isometry { image_of_x: Vec2::new(-1.0, 0.0), shift: Vec2::new(5.0, 0.0), ..Isometry::IDENTITY };
        for transforms in [vec![], vec![0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 1, 0]] {
            let mut pairs = Pairs::new();
            let seen = Seen::new(&indices, &transforms);
            gather_states(&mut pairs, 3, seen, &states, &[Isometry::IDENTITY, mirror], None);
            assert_eq!(pairs.len(), 16);
            for (k, &j) in indices.iter().enumerate() {
                let mut other = states[j as usize];
                if seen.transform(k) == 1 {
                    other.position.x = 5.0 - other.position.x;
                    other.velocity.x = -other.velocity.x;
                }
                let offset = other.position - states[3].position;
                let gathered = [
                    (pairs.offset_x[k], offset.x),
                    (pairs.offset_y[k], offset.y),
                    (pairs.velocity_x[k], other.velocity.x),
                    (pairs.velocity_y[k], other.velocity.y),
                    (pairs.depth[k], other.depth),
                    (pairs.surface[k], other.surface),
                    (pairs.area[k], other.area),
                    (pairs.inverse_h[k], other.inverse_h),
                ];
                let (found, expected): (Vec<f64>, Vec<f64>) = gathered.into_iter().unzip();
                assert_eq!(found, expected, "{k}");
            }
            assert_eq!(pairs.area[13..16], [0.0; 3], "what fills up does not count");
        }
    }

    #[test]
    fn rows_become_columns() {
        let states: [State; LANES] = std::array::from_fn(state);
        let columns = transposed(states.each_ref());
        assert_eq!(columns, std::array::from_fn(|column| std::array::from_fn(|row| (8 * row + column) as f64)));
    }
}
