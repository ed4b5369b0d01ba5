//! Which of sixteen candidates side by side are near: in plain form, and by the vector instructions that a processor has.

use std::ops::Range;

use super::levels::Level;
use super::{CellGrid, LANES, Span};

/// Cells of a level.
pub(super) struct Block {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

/// Where a search looks from.
pub(super) struct Centre {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) reach_squared: f32,
    /// Particle that is not looked for; none has the greatest number.
    pub(super) except: u32,
}

/// A way of appending the spans of a block of cells, columns and rows, in which any particle is near.
pub(super) type Collect = fn(&CellGrid, &Level, &Block, &Centre, &mut Vec<Span>);

/// Sixteen candidates as they lie in the sorted arrays.
struct Candidates<'a> {
    x: &'a [i32; LANES],
    y: &'a [i32; LANES],
    reach_squared: &'a [f32; LANES],
    order: &'a [u32; LANES],
}

/// By the best instructions that the processor has.
#[multiversion::multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(super) fn collect(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, spans: &mut Vec<Span>) {
    multiversion::target::match_target! {
        "x86_64+avx512f" => lanes::collect(grid, level, block, centre, spans),
        "x86_64+avx2" => half_lanes::collect(grid, level, block, centre, spans),
        _ => collect_one_by_one(grid, level, block, centre, spans),
    }
}

/// `near` tells which of sixteen candidates are near, one bit for each.
#[inline(always)]
fn collect_by(
    near: impl Fn(&Candidates<'_>) -> u16,
    grid: &CellGrid,
    level: &Level,
    block: &Block,
    spans: &mut Vec<Span>,
) {
    /// Spans that are kept aside before they are appended.
    const ASIDE: usize = 16;
    let (mut aside, mut end) = ([Span::default(); ASIDE], 0);
    // Of one length, of which the compiler knows.
    let padded = grid.order.len();
    let (all_x, all_y, order) = (&grid.x[..padded], &grid.y[..padded], &grid.order[..padded]);
    let all_squared = &grid.reach_squared[..padded];
    for row in block.rows.start..block.rows.end {
        let run = grid.run(level, &block.columns, row);
        let mut first = run.start;
        // The arrays are longer than the last run by so many lanes.
        while first < run.end && first + LANES <= padded {
            let lanes = first..first + LANES;
            let (Some(x), Some(y), Some(reach_squared), Some(order)) = (
                all_x[lanes.clone()].first_chunk::<LANES>(),
                all_y[lanes.clone()].first_chunk::<LANES>(),
                all_squared[lanes.clone()].first_chunk::<LANES>(),
                order[lanes].first_chunk::<LANES>(),
            ) else {
                break;
            };
            let in_run = (0xffff_u32 >> LANES.saturating_sub(run.end - first)) as u16;
            let near = near(&Candidates { x, y, reach_squared, order }) & in_run;
            aside[end] = Span { first: first as u32, near };
            end += usize::from(near != 0);
            if end == ASIDE {
                spans.extend_from_slice(&aside);
                end = 0;
            }
            first += LANES;
        }
    }
    spans.extend_from_slice(&aside[..end]);
}

#[inline]
pub(super) fn collect_one_by_one(
    grid: &CellGrid,
    level: &Level,
    block: &Block,
    centre: &Centre,
    spans: &mut Vec<Span>,
) {
    let near = |others: &Candidates<'_>| {
        (0..LANES).fold(0, |near, k| {
            let dx = others.x[k].wrapping_sub(centre.x) as f32;
            let dy = others.y[k].wrapping_sub(centre.y) as f32;
            let reach_squared = others.reach_squared[k].max(centre.reach_squared);
            let is_near = (dx * dx + dy * dy < reach_squared) & (others.order[k] != centre.except);
            near | u16::from(is_near) << k
        })
    };
    collect_by(near, grid, level, block, spans);
}

/// Writes the particles of spans; returns how many there are. By the best instructions that the processor has.
#[multiversion::multiversion(targets("x86_64+avx512f+popcnt", "x86_64+avx2+popcnt"))]
pub(super) fn list(order: &[u32], spans: &[Span], found: &mut [u32]) -> usize {
    multiversion::target::match_target! {
        "x86_64+avx512f+popcnt" => lanes::list(order, spans, found),
        "x86_64+avx2+popcnt" => half_lanes::list(order, spans, found),
        _ => list_one_by_one(order, spans, found),
    }
}

#[inline]
pub(super) fn list_one_by_one(order: &[u32], spans: &[Span], found: &mut [u32]) -> usize {
    let mut count = 0;
    for span in spans {
        let mut near = span.near;
        while near != 0 {
            found[count] = order[span.first as usize + near.trailing_zeros() as usize];
            count += 1;
            near &= near - 1;
        }
    }
    count
}

/// `pack` writes those of sixteen candidates whose bit is set to the front.
#[inline(always)]
fn list_by(
    pack: impl Fn(u16, &[u32; LANES], &mut [u32; LANES]),
    order: &[u32],
    spans: &[Span],
    found: &mut [u32],
) -> usize {
    let mut count = 0;
    for &Span { first, near } in spans {
        let (Some(candidates), Some(found)) =
            (order[first as usize..].first_chunk::<LANES>(), found[count..].first_chunk_mut::<LANES>())
        else {
            break;
        };
        pack(near, candidates, found);
        count += near.count_ones() as usize;
    }
    count
}

/// The same sixteen candidates at a time, by instructions that compare into masks and pack the lanes of a mask.
#[cfg(target_arch = "x86_64")]
mod lanes {
    use std::arch::x86_64::{
        _CMP_LT_OQ, _mm512_add_ps, _mm512_cmp_ps_mask, _mm512_cvtepi32_ps, _mm512_mask_cmpneq_epi32_mask,
        _mm512_maskz_compress_epi32, _mm512_max_ps, _mm512_mul_ps, _mm512_set1_epi32, _mm512_set1_ps, _mm512_sub_epi32,
    };

    use bytemuck::must_cast;

    use super::{Block, Candidates, CellGrid, Centre, Level, Span, collect_by, list_by};

    #[target_feature(enable = "avx512f")]
    #[inline]
    pub(super) fn collect(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, spans: &mut Vec<Span>) {
        let (x, y) = (_mm512_set1_epi32(centre.x), _mm512_set1_epi32(centre.y));
        let own_squared = _mm512_set1_ps(centre.reach_squared);
        let except = _mm512_set1_epi32(centre.except as i32);
        let near = |others: &Candidates<'_>| {
            let dx = _mm512_cvtepi32_ps(_mm512_sub_epi32(must_cast(*others.x), x));
            let dy = _mm512_cvtepi32_ps(_mm512_sub_epi32(must_cast(*others.y), y));
            let distance_squared = _mm512_add_ps(_mm512_mul_ps(dx, dx), _mm512_mul_ps(dy, dy));
            let reach_squared = _mm512_max_ps(must_cast(*others.reach_squared), own_squared);
            let near = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(distance_squared, reach_squared);
            _mm512_mask_cmpneq_epi32_mask(near, must_cast(*others.order), except)
        };
        collect_by(near, grid, level, block, spans);
    }

    #[target_feature(enable = "avx512f,popcnt")]
    #[inline]
    pub(super) fn list(order: &[u32], spans: &[Span], found: &mut [u32]) -> usize {
        list_by(
            |near, candidates, found| *found = must_cast(_mm512_maskz_compress_epi32(near, must_cast(*candidates))),
            order,
            spans,
            found,
        )
    }
}

/// The same eight and eight, by instructions that gather the signs of lanes and move lanes by a table.
#[cfg(target_arch = "x86_64")]
mod half_lanes {
    use std::arch::x86_64::{
        _CMP_LT_OQ, _mm_cvtsi64_si128, _mm256_add_ps, _mm256_andnot_ps, _mm256_castsi256_ps, _mm256_cmp_ps,
        _mm256_cmpeq_epi32, _mm256_cvtepi32_ps, _mm256_cvtepu8_epi32, _mm256_max_ps, _mm256_movemask_ps, _mm256_mul_ps,
        _mm256_permutevar8x32_epi32, _mm256_set1_epi32, _mm256_set1_ps, _mm256_sub_epi32,
    };

    use bytemuck::must_cast;

    use super::{Block, Candidates, CellGrid, Centre, LANES, Level, Span, collect_by, list_by};

    const HALF: usize = LANES / 2;

    /// Of each mask of eight the lanes whose bit is set, in their order.
    static LANES_OF: [[u8; HALF]; 1 << HALF] = lanes_of_masks();

    const fn lanes_of_masks() -> [[u8; HALF]; 1 << HALF] {
        let mut lanes_of = [[0; HALF]; 1 << HALF];
        let mut mask = 0;
        while mask < 1 << HALF {
            let (mut lane, mut count) = (0, 0);
            while lane < HALF {
                if mask >> lane & 1 == 1 {
                    lanes_of[mask][count] = lane as u8;
                    count += 1;
                }
                lane += 1;
            }
            mask += 1;
        }
        lanes_of
    }

    #[target_feature(enable = "avx2")]
    #[inline]
    pub(super) fn collect(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, spans: &mut Vec<Span>) {
        let (x, y) = (_mm256_set1_epi32(centre.x), _mm256_set1_epi32(centre.y));
        let own_squared = _mm256_set1_ps(centre.reach_squared);
        let except = _mm256_set1_epi32(centre.except as i32);
        let near_of_half = |other_x: [i32; HALF], other_y: [i32; HALF], squared: [f32; HALF], order: [u32; HALF]| {
            let dx = _mm256_cvtepi32_ps(_mm256_sub_epi32(must_cast(other_x), x));
            let dy = _mm256_cvtepi32_ps(_mm256_sub_epi32(must_cast(other_y), y));
            let distance_squared = _mm256_add_ps(_mm256_mul_ps(dx, dx), _mm256_mul_ps(dy, dy));
            let reach_squared = _mm256_max_ps(must_cast(squared), own_squared);
            let near = _mm256_cmp_ps::<_CMP_LT_OQ>(distance_squared, reach_squared);
            let excepted = _mm256_castsi256_ps(_mm256_cmpeq_epi32(must_cast(order), except));
            _mm256_movemask_ps(_mm256_andnot_ps(excepted, near)) as u16
        };
        let near = |others: &Candidates<'_>| {
            let [x_0, x_1]: [[i32; HALF]; 2] = must_cast(*others.x);
            let [y_0, y_1]: [[i32; HALF]; 2] = must_cast(*others.y);
            let [squared_0, squared_1]: [[f32; HALF]; 2] = must_cast(*others.reach_squared);
            let [order_0, order_1]: [[u32; HALF]; 2] = must_cast(*others.order);
            near_of_half(x_0, y_0, squared_0, order_0) | near_of_half(x_1, y_1, squared_1, order_1) << HALF
        };
        collect_by(near, grid, level, block, spans);
    }

    #[target_feature(enable = "avx2,popcnt")]
    #[inline]
    pub(super) fn list(order: &[u32], spans: &[Span], found: &mut [u32]) -> usize {
        let packed = |near: u8, candidates: [u32; HALF]| -> [u32; HALF] {
            let lanes = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(must_cast(LANES_OF[usize::from(near)])));
            must_cast(_mm256_permutevar8x32_epi32(must_cast(candidates), lanes))
        };
        let pack = |near: u16, candidates: &[u32; LANES], found: &mut [u32; LANES]| {
            let [low, high] = near.to_le_bytes();
            let [first, second]: [[u32; HALF]; 2] = must_cast(*candidates);
            let behind = low.count_ones() as usize;
            found[..HALF].copy_from_slice(&packed(low, first));
            found[behind..behind + HALF].copy_from_slice(&packed(high, second));
        };
        list_by(pack, order, spans, found)
    }
}
