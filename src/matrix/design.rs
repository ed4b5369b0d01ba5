//! Which values the runs of a study have: listed ones each with all others, drawn ones as points of the unit cube.
//!
//! The points are those of an Owen-scrambled Sobol sequence (`Burley2020`) or of a Latin hypercube (`McKay1979`). Samples change slowest: with a
//! Sobol sequence a study of more samples begins with the members of one of fewer.

use sobol_burley::NUM_DIMENSIONS;

use super::file::{Sampling, Study, Values, Variable};
use crate::study::Amount;

/// What each variable is in each case.
pub(super) fn cases(study: &Study) -> Vec<Vec<String>> {
    let listed: usize = study.variables.iter().map(|variable| listed_count(&variable.values)).product();
    let points = Points { sampling: study.sampling, seed: study.seed, samples: study.samples };
    let drawn = study.variables.iter().filter(|variable| variable.is_drawn()).count();
    let shares: Vec<Vec<f64>> = (0..drawn).map(|dimension| points.of(dimension)).collect();
    let of_sample = |sample: usize| {
        let share = |dimension: usize| shares[dimension][sample];
        (0..listed).map(|combination| case(study, combination, share)).collect::<Vec<_>>()
    };
    (0..study.samples).flat_map(of_sample).collect()
}

/// How many cases a study has, without making them; none beyond what can be counted.
pub(super) fn count(study: &Study) -> Option<usize> {
    let counts = study.variables.iter().map(|variable| listed_count(&variable.values));
    counts.chain([study.samples]).try_fold(1_usize, |product, count| product.checked_mul(count))
}

fn listed_count(values: &Values) -> usize {
    match values {
        Values::Listed(values) => values.len(),
        Values::Drawn(..) => 1,
    }
}

/// The values of one case; the last list changes fastest.
fn case(study: &Study, combination: usize, share: impl Fn(usize) -> f64) -> Vec<String> {
    let (mut rest, mut dimension) = (combination, 0);
    let mut places = vec![0; study.variables.len()];
    for (place, variable) in places.iter_mut().zip(&study.variables).rev() {
        let count = listed_count(&variable.values);
        *place = rest % count;
        rest /= count;
    }
    let value = |(variable, place): (&Variable, usize)| match &variable.values {
        Values::Listed(values) => values[place].clone(),
        Values::Drawn(law, unit) => {
            dimension += 1;
            Amount { number: law.quantile(share(dimension - 1)), unit: unit.clone() }.text()
        }
    };
    study.variables.iter().zip(places).map(value).collect()
}

/// Points of the unit cube.
struct Points {
    sampling: Sampling,
    seed: u32,
    samples: usize,
}

impl Points {
    /// Their coordinates in one dimension, between 0 and 1 without these.
    fn of(&self, dimension: usize) -> Vec<f64> {
        /// Half the distance of the numbers that the sequence has.
        const HALF_STEP: f64 = 1.0 / (1 << 25) as f64;
        match self.sampling {
            Sampling::Sobol => {
                // The sequence has so many dimensions; those beyond are of another one.
                let (block, dimension) = (dimension as u32 / NUM_DIMENSIONS, dimension as u32 % NUM_DIMENSIONS);
                let seed = self.seed.wrapping_add(block);
                let point = |sample| f64::from(sobol_burley::sample(sample, dimension, seed)) + HALF_STEP;
                (0..self.samples as u32).map(point).collect()
            }
            Sampling::LatinHypercube => self.latin_hypercube(dimension),
        }
    }

    /// One place in each of equal strata, in random order.
    fn latin_hypercube(&self, dimension: usize) -> Vec<f64> {
        let mut random = SplitMix(u64::from(self.seed) << 32 | dimension as u64);
        let mut strata: Vec<usize> = (0..self.samples).collect();
        // Fisher and Yates.
        for last in (1..strata.len()).rev() {
            let other = (random.share() * (last + 1) as f64) as usize;
            strata.swap(last, other.min(last));
        }
        let width = 1.0 / self.samples as f64;
        strata.into_iter().map(|stratum| (stratum as f64 + random.share()) * width).collect()
    }
}

/// Random numbers after `Steele2014`: the same on every machine.
struct SplitMix(u64);

impl SplitMix {
    /// Between 0 and 1 without these.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 12) as f64 / (1_u64 << 52) as f64 + 0.5 / (1_u64 << 52) as f64
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::super::spread::Law;
    use super::*;

    fn study(samples: usize, sampling: Sampling, values: Vec<Values>) -> Study {
        let variable = |values| Variable { key: "k".into(), name: "k".into(), is_factor: false, values };
        Study {
            title: String::new(),
            base: PathBuf::new(),
            folder: PathBuf::new(),
            variables: values.into_iter().map(variable).collect(),
            samples,
            sampling,
            seed: 3,
            variants: Vec::new(),
            depths: Vec::new(),
        }
    }

    fn listed(values: &[&str]) -> Values {
        Values::Listed(values.iter().map(|value| (*value).to_owned()).collect())
    }

    fn unit() -> Values {
        Values::Drawn(Law::Uniform { from: 0.0, to: 1.0 }, String::new())
    }

    #[test]
    fn lists_stand_each_with_all_others() {
        let study = study(1, Sampling::Sobol, vec![listed(&["a", "b"]), listed(&["1", "2", "3"])]);
        let cases: Vec<String> = cases(&study).iter().map(|case| case.concat()).collect();
        assert_eq!(cases, ["a1", "a2", "a3", "b1", "b2", "b3"]);
        assert_eq!(count(&study), Some(6));
    }

    #[test]
    fn samples_fill_their_strata_once() {
        for sampling in [Sampling::Sobol, Sampling::LatinHypercube] {
            let cases = cases(&study(64, sampling, vec![unit(), unit(), unit()]));
            for dimension in 0..3 {
                let mut strata: Vec<usize> =
                    cases.iter().map(|case| (case[dimension].parse::<f64>().unwrap() * 64.0) as usize).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..64).collect::<Vec<_>>(), "{sampling:?}, dimension {dimension}");
            }
        }
    }

    #[test]
    fn more_samples_of_a_sequence_begin_with_those_of_fewer() {
        let of = |samples| cases(&study(samples, Sampling::Sobol, vec![unit(), listed(&["x", "y"]), unit()]));
        let (few, many) = (of(20), of(50));
        assert_eq!(few[..], many[..40]);
        assert_eq!(few[0][0], few[1][0], "the samples of all lists are the same");
    }
}
