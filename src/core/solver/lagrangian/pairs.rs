//! The pairs of some particles in groups of eight: what the loops over neighbours read and write, one column for each quantity.
//!
//! Neighbours are gathered in blocks, so that nothing is allocated and everything stays in the first level of the cache; the
//! loops over a block have no branch, and run on as many lanes as the processor has. All sums are taken in the same order
//! whatever that number is: eight of them side by side, one for each lane of a group, and these together at the end of the block.

use bytemuck::{Pod, Zeroable};

use super::ridges::share_in_sight;
use super::{Gradients, State};
use crate::bed::BedParticles;
use crate::boundary::Isometry;
use crate::math::{Vec2, larger, smaller};
use crate::physics::kernel::{Shape, Smoothing};
pub(super) use crate::solver::moving::LANES;
use crate::solver::moving::{ChosenKernel, Seen, with_kernel};

/// Most groups of pairs in a block.
const GROUPS: usize = 8;
/// Most pairs in a block.
pub(super) const BLOCK: usize = GROUPS * LANES;

/// One quantity of a group of pairs.
pub(super) type Lanes = [f64; LANES];

/// Some pairs of a particle, quantity by quantity: the neighbours as it sees them, those behind a wall reflected.
///
/// What fills up the last group are pairs of the particle with itself that have no area: they add nothing to any sum.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Group {
    pub state: StateLanes,
    pub gradients: GradientLanes,
    /// Distance r (m).
    pub r: Lanes,
    /// e, the unit vector from i to j; zero where both coincide.
    pub e_x: Lanes,
    pub e_y: Lanes,
    /// A_j G_ij (1/m).
    pub weight: Lanes,
    /// d_iR (m).
    pub own_depth: Lanes,
    /// Depths (m) at the face, above its sill.
    pub d_l: Lanes,
    pub d_r: Lanes,
    /// √(g d_l), √(g d_r) (m/s).
    pub c_l: Lanes,
    pub c_r: Lanes,
    /// Velocities (m/s) along e: of both particles, and of both sides of the face.
    pub own_u: Lanes,
    pub other_u: Lanes,
    pub u_l: Lanes,
    pub u_r: Lanes,
    pub p_star: Lanes,
    pub u_star: Lanes,
    /// a_1 (m).
    pub slope: Lanes,
    /// Δη − a_1 − a_2 (m).
    pub surface_jump: Lanes,
    /// b_1 − b_2 (m/s).
    pub velocity_jump: Lanes,
    /// What the pair says of ṙ_i (m/s): the speed at which it leaves each other, or the jump left between both sides of the face.
    pub stir: Lanes,
    /// w, the weight of the area.
    pub share: Lanes,
    /// A_j W(r, h_i).
    pub covered: Lanes,
}

/// `State` of the neighbours of a group.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct StateLanes {
    pub x: Lanes,
    pub y: Lanes,
    pub velocity_x: Lanes,
    pub velocity_y: Lanes,
    pub depth: Lanes,
    pub surface: Lanes,
    pub area: Lanes,
    pub inverse_h: Lanes,
}

/// `Gradients` of the neighbours of a group.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GradientLanes {
    pub surface_x: Lanes,
    pub surface_y: Lanes,
    pub depth_x: Lanes,
    pub depth_y: Lanes,
    pub u_x: Lanes,
    pub u_y: Lanes,
    pub v_x: Lanes,
    pub v_y: Lanes,
}

/// The groups of one particle, or of a block of its neighbours, among those in work.
#[derive(Clone, Copy, Debug, Default)]
struct Member {
    particle: usize,
    first: usize,
    end: usize,
}

/// The pairs in work: those of some particles, one after the other. Each of the loops over them waits for its own steps, the less the
/// more groups it has before it.
#[derive(Clone, Debug)]
pub(super) struct Pairs {
    groups: [Group; GROUPS],
    members: [Member; GROUPS],
    /// Members in work.
    count: usize,
}

impl Pairs {
    pub(super) fn new() -> Self {
        Pairs { groups: [Group::default(); GROUPS], members: [Member::default(); GROUPS], count: 0 }
    }

    /// The groups of a member, to be filled.
    #[inline(always)]
    fn groups_of_mut(&mut self, member: Member) -> &mut [Group] {
        &mut self.groups[member.first..member.end]
    }

    /// How many particles, or blocks of neighbours, are in work.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The particle and the groups of one of them. (A loop over these numbers, not a closure for each of them, which would run
    /// without the lanes of its caller.)
    #[inline(always)]
    pub(super) fn of(&mut self, k: usize) -> (usize, &mut [Group]) {
        let Member { particle, first, end } = self.members[k];
        (particle, &mut self.groups[first..end])
    }

    /// Number of groups in work.
    #[inline(always)]
    fn end(&self) -> usize {
        self.members[..self.count].last().map_or(0, |member| member.end)
    }

    /// All groups in work, to be filled.
    #[inline(always)]
    pub(super) fn all_groups_mut(&mut self) -> &mut [Group] {
        let end = self.end();
        &mut self.groups[..end]
    }

    /// Whether there is room for a block of neighbours.
    #[inline(always)]
    pub(super) fn has_room_for(&self, block: Seen<'_>) -> bool {
        self.end() + block.groups().len() <= GROUPS
    }

    /// Ends the work.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes a particle in with a block of its neighbours, for which there is room.
    #[inline(always)]
    fn admit(&mut self, particle: usize, block: Seen<'_>) -> Member {
        let first = self.end();
        let member = Member { particle, first, end: first + block.groups().len() };
        self.members[self.count] = member;
        self.count += 1;
        member
    }

    /// Takes from the area of each pair what ridges hide of it; apart, so that the loop above stays as short without them.
    #[cold]
    fn hide(&mut self, member: Member, block: Seen<'_>, states: &[State], bed: &BedParticles) {
        let me = states[member.particle];
        for (k, image) in block.iter().enumerate() {
            let (state, lane) = (&mut self.groups[member.first + k / LANES].state, k % LANES);
            let in_sight = share_in_sight(bed, &me, &states[image.index as usize]);
            state.area[lane] *= in_sight;
            if in_sight <= 0.0 {
                (state.x[lane], state.y[lane]) = (me.position.x, me.position.y);
                (state.velocity_x[lane], state.velocity_y[lane]) = (me.velocity.x, me.velocity.y);
                (state.depth[lane], state.surface[lane]) = (me.depth, me.surface);
                state.inverse_h[lane] = me.inverse_h;
            }
        }
    }

    /// Distances, directions and weights from places, areas and smoothing lengths. `COVERS`: also the weight w of each
    /// pair's area, and A_j W(r, h_i).
    #[inline(always)]
    fn measure_with<S: Shape, const COVERS: bool>(&mut self, states: &[State], kernel: &Smoothing<S>) {
        for k in 0..self.count {
            let (i, groups) = self.of(k);
            measure_from::<S, COVERS>(&states[i], groups, kernel);
        }
    }
}

#[inline(always)]
fn measure_from<S: Shape, const COVERS: bool>(me: &State, groups: &mut [Group], kernel: &Smoothing<S>) {
    let Vec2 { x: own_x, y: own_y } = me.position;
    for Group { state, r, e_x, e_y, weight, share, covered, .. } in groups {
        for k in 0..LANES {
            let (x, y) = (state.x[k] - own_x, state.y[k] - own_y);
            let (area, other_inverse_h) = (state.area[k], state.inverse_h[k]);
            let squared = x * x + y * y;
            // 1/r by a division that does not wait for the root.
            let distance = squared.sqrt();
            let inverse = distance * (1.0 / larger(squared, f64::MIN_POSITIVE));
            let slopes = kernel.slope(distance, me.inverse_h) + kernel.slope(distance, other_inverse_h);
            r[k] = distance;
            e_x[k] = x * inverse;
            e_y[k] = y * inverse;
            weight[k] = -0.5 * area * slopes;
            if COVERS {
                // The pairs that fill up have no area and must not count.
                let is_real = if area > 0.0 { 1.0 } else { 0.0 };
                share[k] = is_real * kernel.share(distance, smaller(me.inverse_h, other_inverse_h));
                covered[k] = area * kernel.value(distance, me.inverse_h);
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

/// The columns of a group of neighbours.
macro_rules! columns_of_group {
    ($indices:expr, $all:expr, $turned:expr) => {{
        let (indices, all) = ($indices, $all);
        let mut lines: [&_; LANES] = std::array::from_fn(|k| &all[indices[k] as usize]);
        let turned;
        if let Some((block, first, isometries)) = $turned {
            turned = turned_group(block, first, lines, isometries);
            lines = turned.each_ref();
        }
        multiversion::target::match_target! {
            "x86_64+avx512f+avx512vl" => transposed_by_lanes(lines),
            "x86_64+avx2" => transposed_by_half_lanes(lines),
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

/// Gathers the states of one block of a particle's neighbours; beside `ridges` with the share of their area that is in sight.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn gather_states(
    pairs: &mut Pairs,
    particle: usize,
    block: Seen<'_>,
    states: &[State],
    isometries: &[Isometry],
    ridges: Option<&BedParticles>,
) {
    let member = pairs.admit(particle, block);
    for (number, (group, indices)) in pairs.groups_of_mut(member).iter_mut().zip(block.groups()).enumerate() {
        let turned = block.has_images().then_some((block, number * LANES, isometries));
        group.state = bytemuck::must_cast(columns_of_group!(indices, states, turned));
    }
    if let Some(last) = pairs.groups_of_mut(member).last_mut() {
        let real = block.in_last_group() as u64;
        for lane in 0..LANES {
            last.state.area[lane] = if (lane as u64) < real { last.state.area[lane] } else { 0.0 };
        }
    }
    if let Some(bed) = ridges {
        pairs.hide(member, block, states, bed);
    }
}

/// Gathers the gradients of the neighbours whose states were gathered last, turned as the particle sees them.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn gather_gradients(pairs: &mut Pairs, block: Seen<'_>, gradients: &[Gradients], isometries: &[Isometry]) {
    let Some(&member) = pairs.members[..pairs.count].last() else { return };
    for (number, (group, indices)) in pairs.groups_of_mut(member).iter_mut().zip(block.groups()).enumerate() {
        let turned = block.has_images().then_some((block, number * LANES, isometries));
        group.gradients = bytemuck::must_cast(columns_of_group!(indices, gradients, turned));
    }
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

/// The same in quarters of four rows by four columns: by shuffles of single numbers and of pairs.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline]
fn transposed_by_half_lanes<T: Line>(rows: [&T; LANES]) -> [[f64; LANES]; LANES] {
    use std::arch::x86_64::{__m256d, _mm256_permute2f128_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd};

    let row = |k: usize| -> [__m256d; 2] { bytemuck::cast(*rows[k]) };
    let quarter = |a, b, c, d| {
        let (even_ab, even_cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
        let (odd_ab, odd_cd) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
        [
            _mm256_permute2f128_pd::<0x20>(even_ab, even_cd),
            _mm256_permute2f128_pd::<0x20>(odd_ab, odd_cd),
            _mm256_permute2f128_pd::<0x31>(even_ab, even_cd),
            _mm256_permute2f128_pd::<0x31>(odd_ab, odd_cd),
        ]
    };
    let [a_0, a_1] = row(0);
    let [b_0, b_1] = row(1);
    let [c_0, c_1] = row(2);
    let [d_0, d_1] = row(3);
    let [e_0, e_1] = row(4);
    let [f_0, f_1] = row(5);
    let [g_0, g_1] = row(6);
    let [h_0, h_1] = row(7);
    let (first_0, second_0) = (quarter(a_0, b_0, c_0, d_0), quarter(e_0, f_0, g_0, h_0));
    let (first_1, second_1) = (quarter(a_1, b_1, c_1, d_1), quarter(e_1, f_1, g_1, h_1));
    let column = |first: __m256d, second: __m256d| -> [f64; LANES] { bytemuck::must_cast([first, second]) };
    [
        column(first_0[0], second_0[0]),
        column(first_0[1], second_0[1]),
        column(first_0[2], second_0[2]),
        column(first_0[3], second_0[3]),
        column(first_1[0], second_1[0]),
        column(first_1[1], second_1[1]),
        column(first_1[2], second_1[2]),
        column(first_1[3], second_1[3]),
    ]
}

/// Distances, directions and weights of all pairs, by the chosen kernel.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn measure(pairs: &mut Pairs, states: &[State], kernel: &ChosenKernel) {
    with_kernel!(kernel, kernel => pairs.measure_with::<_, false>(states, kernel));
}

/// The same, and the weight w of each pair's area, and A_j W(r, h_i).
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn measure_and_cover(pairs: &mut Pairs, states: &[State], kernel: &ChosenKernel) {
    with_kernel!(kernel, kernel => pairs.measure_with::<_, true>(states, kernel));
}

/// The sum over the lanes.
#[inline(always)]
pub(super) fn total([a, b, c, d, e, f, g, h]: Lanes) -> f64 {
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// The greatest number of all lanes.
#[inline(always)]
pub(super) fn greatest([a, b, c, d, e, f, g, h]: Lanes) -> f64 {
    larger(larger(larger(a, b), larger(c, d)), larger(larger(e, f), larger(g, h)))
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
            let mut padded = indices.clone();
            let seen = Seen::filled_up(&mut padded, 13, &transforms, 3);
            gather_states(&mut pairs, 3, seen, &states, &[Isometry::IDENTITY, mirror], None);
            let (_, groups) = pairs.of(0);
            assert_eq!(groups.len(), 2);
            for (k, &j) in indices.iter().enumerate() {
                let mut other = states[j as usize];
                if seen.transform(k) == 1 {
                    other.position.x = 5.0 - other.position.x;
                    other.velocity.x = -other.velocity.x;
                }
                let (gathered, lane) = (&groups[k / LANES].state, k % LANES);
                let gathered = [
                    (gathered.x[lane], other.position.x),
                    (gathered.y[lane], other.position.y),
                    (gathered.velocity_x[lane], other.velocity.x),
                    (gathered.velocity_y[lane], other.velocity.y),
                    (gathered.depth[lane], other.depth),
                    (gathered.surface[lane], other.surface),
                    (gathered.area[lane], other.area),
                    (gathered.inverse_h[lane], other.inverse_h),
                ];
                let (found, expected): (Vec<f64>, Vec<f64>) = gathered.into_iter().unzip();
                assert_eq!(found, expected, "{k}");
            }
            assert_eq!(groups[1].state.area[5..], [0.0; 3], "what fills up does not count");
        }
    }

    #[test]
    fn rows_become_columns() {
        let states: [State; LANES] = std::array::from_fn(state);
        let columns = transposed(states.each_ref());
        assert_eq!(columns, std::array::from_fn(|column| std::array::from_fn(|row| (8 * row + column) as f64)));
    }
}
