//! Where the columns and rows of an output grid overlap those of the lattice.

/// The overlap of an output column or row with a lattice column or row.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Overlap {
    /// Lattice column or row.
    pub index: usize,
    /// Length of the overlap over the length of the output cell.
    pub share: f64,
}

/// Lattice cells along one axis that overlap the interval from `start` of length `cell`.
pub(super) fn overlaps(start: f64, cell: f64, spacing: f64, count: usize) -> Vec<Overlap> {
    let first = (start / spacing + 1e-9).floor().max(0.0) as usize;
    let last = (((start + cell) / spacing - 1e-9).ceil().max(0.0) as usize).min(count);
    let overlap = |index: usize| {
        let from = start.max(index as f64 * spacing);
        let to = (start + cell).min((index + 1) as f64 * spacing);
        Overlap { index, share: if (cell - spacing).abs() < 1e-9 * spacing { 1.0 } else { (to - from) / cell } }
    };
    (first..last).map(overlap).collect()
}
