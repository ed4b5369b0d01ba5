use super::*;
use crate::lattice::{FlatWater, Lattice, Span};
use crate::math::Vec2;
use crate::output::hazard::greater_class;

const THRESHOLDS: [f64; 2] = [0.1, 0.3];
const RISE: f64 = 0.05;

/// What a cell has seen, step by step and cell by cell: the plain version.
#[derive(Clone, Default)]
struct Plain {
    initial: f64,
    previous: f64,
    seen: (f64, f64, f64, u8, f64),
    thresholds: [(Option<f64>, f64, Option<f64>); 2],
}

impl Plain {
    fn follow(&mut self, (before, after): (f64, f64), depth: f64, x: f64, y: f64) {
        let crossing = |threshold: f64, from: f64| before + (after - before) * ((threshold - from) / (depth - from));
        for (seen, threshold) in self.thresholds.iter_mut().zip(THRESHOLDS) {
            if (self.previous >= threshold) != (depth >= threshold) {
                let time = crossing(threshold, self.previous);
                seen.1 += if depth < threshold { time } else { -time };
                if depth < threshold {
                    seen.2 = Some(time);
                }
            }
            let arrival = arrival_depth(threshold, self.initial, RISE);
            if seen.0.is_none() && depth > self.seen.0 && depth >= arrival {
                seen.0 = Some(crossing(arrival, self.previous));
            }
        }
        if depth > self.seen.0 {
            (self.seen.0, self.seen.4) = (depth, after);
        }
        if depth > WET_DEPTH {
            let squared = x * x + y * y;
            self.seen.2 = self.seen.2.max(squared);
            if squared > self.seen.1 * depth * depth {
                self.seen.1 = squared / (depth * depth);
            }
            self.seen.3 = greater_class(self.seen.3, depth, squared);
        }
        self.previous = depth;
    }
}

#[test]
fn lanes_see_what_each_cell_by_itself_does() {
    let lattice = Lattice::new(Vec2::ZERO, 29, 3, 1.0);
    let spans = [(0, 3, 21), (1, 0, 8), (1, 10, 29), (2, 15, 17)].map(|(row, from, to)| Span { row, from, to });
    let is_inside = |cell: usize| {
        let (column, row) = ((cell % 29) as u32, (cell / 29) as u32);
        spans.iter().any(|span| span.row == row && (span.from..span.to).contains(&column))
    };
    let mut maxima = Maxima::new(lattice.len(), lattice.columns, &THRESHOLDS, RISE);
    let mut plain = vec![Plain::default(); lattice.len()];
    for step in 0..60 {
        let time = 1.5 * f64::from(step);
        let mut rows = FlatWater::dry(&lattice);
        for cell in (0..lattice.len()).filter(|&cell| is_inside(cell)) {
            let phase = 0.21 * f64::from(step) + 0.7 * cell as f64;
            rows.depth[cell] = (0.02 * f64::from(step % 25) * phase.sin() + 0.1 * phase.cos()).max(0.0);
            rows.discharge_x[cell] = rows.depth[cell] * 3.0 * (1.3 * phase).sin();
            rows.discharge_y[cell] = rows.depth[cell] * 4.5 * (0.4 * phase).cos();
        }
        let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
        if step == 0 {
            maxima.start(0.0, &water);
        } else {
            maxima.step(time - 1.5, time, &water);
        }
        for cell in (0..lattice.len()).filter(|&cell| is_inside(cell)) {
            let (depth, plain) = (rows.depth[cell], &mut plain[cell]);
            if step == 0 {
                (plain.initial, plain.previous) = (depth, depth);
                for (seen, threshold) in plain.thresholds.iter_mut().zip(THRESHOLDS) {
                    seen.0 = (depth >= arrival_depth(threshold, depth, RISE)).then_some(0.0);
                }
            }
            plain.follow((time - 1.5, time), depth, rows.discharge_x[cell], rows.discharge_y[cell]);
        }
    }
    for (cell, plain) in plain.iter().enumerate() {
        let (seen, (depth, speed, discharge, class, time)) = (maxima.seen(cell), plain.seen);
        assert_eq!((seen.max_depth, seen.hazard_class), (depth, class), "cell {cell}");
        assert_eq!((seen.max_speed, seen.max_depth_velocity), (speed.sqrt(), discharge.sqrt()), "cell {cell}");
        assert!(if depth > 0.0 {
            seen.time_of_max_depth == time
        } else {
            seen.time_of_max_depth.is_nan() || time == 0.0
        });
        for (which, (expected, threshold)) in plain.thresholds.iter().zip(THRESHOLDS).enumerate() {
            let (arrival, duration, recession) = *expected;
            let seen = maxima.seen_of_threshold(cell, which, 88.5);
            let is_under = plain.previous >= threshold;
            assert_eq!(seen.arrival.to_bits(), arrival.unwrap_or(f64::NAN).to_bits(), "cell {cell}");
            assert_eq!(seen.duration, duration + if is_under { 88.5 } else { 0.0 }, "cell {cell}");
            let recession = recession.filter(|_| !is_under).map(|time| f64::from(time as f32));
            assert_eq!(seen.recession.is_nan(), recession.is_none(), "cell {cell}");
            assert_eq!(seen.recession.max(0.0), recession.unwrap_or(0.0), "cell {cell}");
        }
    }
    assert!((0..lattice.len()).any(|cell| maxima.seen(cell).hazard_class == 6));
}
