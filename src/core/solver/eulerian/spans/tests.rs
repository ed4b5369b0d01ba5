//! Tests of the runs of active cells.

use super::runs::join;
use super::*;

#[test]
fn whole_pieces_end_before_the_next_run() {
    for lanes in [4, MOST_LANES] {
        let work = vec![vec![], vec![1..2, 9..15, 22..30, 37..38]];
        let mut active = ActiveSet {
            bounds: Vec::new(),
            apart: 0..0,
            own: Vec::new(),
            links: Links::new(&[], 0),
            asleep: Asleep::default(),
            has_woken: false,
            at_hand: 0..0,
            cells_at_hand: 0,
            recorded_runs: Vec::new(),
            wet: Vec::new(),
            wet_before: Vec::new(),
            changed: Vec::new(),
            is_stale: Vec::new(),
            fed: Vec::new(),
            reached: Vec::new(),
            kept: Vec::new(),
            before: Vec::new(),
            recorded: Vec::new(),
            with_asleep: Vec::new(),
            lanes,
            work,
        };
        join(&mut active.work[1]);
        assert_eq!(active.whole_pieces(0).count(), 0);
        let pieces: Vec<Run> = active.whole_pieces(1).collect();
        assert_eq!(pieces.len(), active.work[1].len());
        for (piece, run) in pieces.iter().zip(&active.work[1]) {
            assert!(piece.len().is_multiple_of(lanes) && piece.start == run.start && piece.end >= run.end);
        }
        assert!(pieces.windows(2).all(|pair| pair[0].end <= pair[1].start), "{pieces:?}");
    }
}

#[test]
#[expect(clippy::single_range_in_vec_init, reason = "a list of runs that holds one run")]
fn near_runs_are_joined_and_far_ones_kept() {
    let mut runs = vec![1..4, 2..5, 9..12, 40..41];
    join(&mut runs);
    assert_eq!(runs, vec![1..12, 40..41]);
    let mut none: Vec<Run> = Vec::new();
    join(&mut none);
    assert!(none.is_empty());
    let mut one = vec![3..4];
    join(&mut one);
    assert_eq!(one, vec![3..4]);
}
