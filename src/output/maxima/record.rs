//! What is kept of cells: blocks of a row in lanes, and a record of each cell for each threshold.

use bytemuck::Zeroable;

use crate::lattice::WaterInRow;

/// A time that may not have come yet: all bits are 0 until then.
#[derive(Clone, Copy, Debug, Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(transparent)]
pub(super) struct Moment(u64);

impl Moment {
    const NEVER: u64 = f64::NAN.to_bits();

    /// A time (s), not NaN.
    #[inline]
    pub(super) fn at(time: f64) -> Self {
        Moment(time.to_bits() ^ Self::NEVER)
    }

    /// The time (s); NaN where it has not come.
    #[inline]
    pub(super) fn time(self) -> f64 {
        f64::from_bits(self.0 ^ Self::NEVER)
    }

    #[inline]
    pub(super) fn has_come(self) -> bool {
        self.0 != 0
    }
}

/// The same in single precision.
#[derive(Clone, Copy, Debug, Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(transparent)]
pub(super) struct ShortMoment(u32);

impl ShortMoment {
    const NEVER: u32 = f32::NAN.to_bits();

    /// A time (s), not NaN.
    #[inline]
    pub(super) fn at(time: f64) -> Self {
        ShortMoment((time as f32).to_bits() ^ Self::NEVER)
    }

    /// The time (s); NaN where it has not come.
    #[inline]
    pub(super) fn time(self) -> f64 {
        f64::from(f32::from_bits(self.0 ^ Self::NEVER))
    }
}

/// Cells of a row that are looked at together.
pub(super) const LANES: usize = 8;

/// A number of each cell of a block.
pub(super) type Lanes = [f64; LANES];

/// What is kept of some cells of a row besides the thresholds; the squares spare a root at each step.
#[derive(Clone, Copy, Debug, Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(C)]
pub(super) struct Block {
    pub(super) initial_depth: Lanes,
    pub(super) max_depth: Lanes,
    pub(super) max_speed_squared: Lanes,
    pub(super) max_discharge_squared: Lanes,
    pub(super) time_of_max_depth: [ShortMoment; LANES],
    pub(super) hazard_class: [u8; LANES],
}

/// The water of some cells of a row.
#[derive(Clone, Copy, Debug, Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(C)]
pub(super) struct BlockOfWater {
    pub(super) depth: Lanes,
    pub(super) discharge_x: Lanes,
    pub(super) discharge_y: Lanes,
}

impl BlockOfWater {
    /// (d·|v|)² of each cell (m⁴/s²).
    #[inline(always)]
    pub(super) fn discharge_squared(&self) -> Lanes {
        let mut squares = [0.0; LANES];
        for ((square, x), y) in squares.iter_mut().zip(&self.discharge_x).zip(&self.discharge_y) {
            *square = x * x + y * y;
        }
        squares
    }

    /// The water of the columns `from..to` of a row, which lie in the block that begins with column `first`; in its other columns that of
    /// before.
    #[inline(always)]
    pub(super) fn of_row(
        row: &WaterInRow<'_>,
        first: usize,
        (from, to): (usize, usize),
        before: &BlockOfWater,
    ) -> Self {
        if to - from == LANES {
            let whole = |values: &[f64]| {
                let mut lanes = [0.0; LANES];
                lanes.copy_from_slice(&values[first..][..LANES]);
                lanes
            };
            return BlockOfWater {
                depth: whole(row.depth),
                discharge_x: whole(row.discharge_x),
                discharge_y: whole(row.discharge_y),
            };
        }
        let mut block = *before;
        let lanes = from - first..to - first;
        block.depth[lanes.clone()].copy_from_slice(&row.depth[from..to]);
        block.discharge_x[lanes.clone()].copy_from_slice(&row.discharge_x[from..to]);
        block.discharge_y[lanes].copy_from_slice(&row.discharge_y[from..to]);
        block
    }
}

/// What is kept of one cell for one threshold. Whether the cell is under water tells its depth.
#[derive(Clone, Copy, Debug, Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(C, packed(4))]
pub(super) struct ThresholdRecord {
    pub(super) arrival: Moment,
    /// Time under water (s); while that goes on, less the time of now.
    pub(super) duration: f64,
    /// The latest fall below the threshold.
    pub(super) recession: ShortMoment,
}
