//! Quantiles and rank correlations of the runs of a study.
//!
//! ```text
//! x(p) = the least value that a share p of the runs, or more, does not exceed
//! ρ    = cov(R(x), R(y)) / (σ(R(x)) σ(R(y)))              `Spearman1904`; equal values share the mean of their ranks R
//! η²   = Σ n_k (R̄_k − R̄)² / Σ (R − R̄)²                    of a variable without numbers, by its values k
//! ε    = √(1 − (1 − η²)(n − 1)/(n − K))                    less what K groups of n values have by chance, `Kelley1935`
//! ```
//!
//! A quantile is the value of a run and no mean of two, so that "never" may be among the values, as infinity.

/// A quantile of values in ascending order; none where there are none.
pub(super) fn quantile<T: Copy>(ascending: &[T], p: f64) -> Option<T> {
    // What rounding adds to a whole number is no further run.
    let place = ((p * ascending.len() as f64 - 1e-9).ceil() as usize).max(1);
    ascending.get(place - 1).copied()
}

/// Ranks from 1; equal values have the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|one, other| values[*one].total_cmp(&values[*other]));
    let mut ranks = vec![0.0; values.len()];
    let mut from = 0;
    while from < order.len() {
        let is_equal = |at: &&usize| values[**at].total_cmp(&values[order[from]]).is_eq();
        let count = order[from..].iter().take_while(is_equal).count();
        let mean = from as f64 + 0.5 * (count as f64 + 1.0);
        order[from..from + count].iter().for_each(|at| ranks[*at] = mean);
        from += count;
    }
    ranks
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The rank correlation of two lists of the same length; none where one of them does not vary.
pub(super) fn rank_correlation(x: &[f64], y: &[f64]) -> Option<f64> {
    let (x, y) = (ranks(x), ranks(y));
    let centre = 0.5 * (x.len() as f64 + 1.0);
    let sum =
        |one: &[f64], other: &[f64]| -> f64 { one.iter().zip(other).map(|(a, b)| (a - centre) * (b - centre)).sum() };
    let sizes = (sum(&x, &x) * sum(&y, &y)).sqrt();
    (sizes > 0.0).then(|| sum(&x, &y) / sizes)
}

/// How much of the ranks of `y` its groups have beyond chance, from 0 to 1; none where there is one group, groups have less than two values in the
/// mean, or `y` does not vary.
pub(super) fn correlation_ratio(groups: &[&str], y: &[f64]) -> Option<f64> {
    let ranks = ranks(y);
    let centre = mean(&ranks);
    let mut names = groups.to_vec();
    names.sort_unstable();
    names.dedup();
    let between = |name: &&str| {
        let own: Vec<f64> =
            groups.iter().zip(&ranks).filter(|(group, _)| *group == name).map(|(_, rank)| *rank).collect();
        own.len() as f64 * (mean(&own) - centre).powi(2)
    };
    let all: f64 = ranks.iter().map(|rank| (rank - centre).powi(2)).sum();
    let (n, groups) = (ranks.len() as f64, names.len() as f64);
    (names.len() > 1 && 2.0 * groups <= n && all > 0.0).then(|| {
        let share = names.iter().map(between).sum::<f64>() / all;
        (1.0 - (1.0 - share) * (n - 1.0) / (n - groups)).max(0.0).sqrt()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_the_value_of_a_run() {
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        let of = |p| quantile(&values, p).unwrap();
        assert_eq!((of(0.05), of(0.5), of(0.95), of(1.0)), (1.0, 10.0, 19.0, 20.0));
        assert_eq!(quantile(&[7.0], 0.05), Some(7.0));
        assert_eq!(quantile::<f64>(&[], 0.5), None);
        // Half of the runs and one: the water never comes in the others.
        let half = [1.0, 2.0, 3.0, f64::INFINITY, f64::INFINITY];
        assert_eq!((quantile(&half, 0.5), quantile(&half, 0.95)), (Some(3.0), Some(f64::INFINITY)));
    }

    #[test]
    fn rank_correlations_are_those_by_hand() {
        let x = [1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(rank_correlation(&x, &[10.0, 100.0, 1e3, 1e4, f64::INFINITY]), Some(1.0));
        assert_eq!(rank_correlation(&x, &[5.0, 4.0, 3.0, 2.0, 1.0]), Some(-1.0));
        assert_eq!(rank_correlation(&x, &[2.0; 5]), None);
        // Ranks 1, 2.5, 2.5, 4, 5: Σ of products 9.5, of squares 10 and 9.5.
        let with_equal = rank_correlation(&x, &[1.0, 2.0, 2.0, 3.0, 4.0]).unwrap();
        assert!((with_equal - 9.5 / (10.0_f64 * 9.5).sqrt()).abs() < 1e-12);
        // Ranks 1, 2 in one group and 3, 4 in the other: 4 of 5, and beyond chance 1 − .2 · 3/2.
        let ratio = correlation_ratio(&["a", "a", "b", "b"], &[1.0, 2.0, 3.0, 4.0]).unwrap();
        assert!((ratio - 0.7_f64.sqrt()).abs() < 1e-12);
        assert_eq!(correlation_ratio(&["a", "b", "c"], &[1.0, 2.0, 3.0]), None);
        assert_eq!(correlation_ratio(&["a", "a"], &[1.0, 2.0]), None);
    }
}
