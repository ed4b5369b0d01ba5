//! Rain after its losses.

pub mod frames;
pub mod series;
pub mod times;

use crate::boundary::{Rain, Series};
use crate::error::{Problem, input_error, input_warning};
use crate::math::readable;
use crate::scenario::units::INTENSITY;

/// Intensity (m/s) beyond which another unit is likelier than such rain: 1000 mm/h.
pub const DOUBTFUL: f64 = 1.0 / 3600.0;
/// Why such rain gets a warning.
pub const DOUBTFUL_CAUSE: &str = "hardly any rain is that heavy for long; the values have another unit, perhaps";

/// An intensity of 1 m/s (mm/h).
const MM_PER_HOUR: f64 = 3.6e6;

/// Losses of rain and when it ends.
#[derive(Clone, Copy, Debug)]
pub struct Losses {
    /// The first rain that runs off nowhere (m).
    pub initial: f64,
    /// What of the rain is lost from then on (m/s).
    pub constant: f64,
    /// End of the rain (s).
    pub until: f64,
}

/// Warns of rain that is hardly as heavy (m/s), and refuses what no scenario may ask for.
pub fn doubtful(peak: f64) -> Option<Problem> {
    (peak > DOUBTFUL).then(|| {
        let more = format!("{} mm/h of rain are more than", readable(peak * MM_PER_HOUR));
        let problem = if peak > INTENSITY.most {
            input_error("implausible-value", format!("{more} {:.0} m/s", INTENSITY.most))
        } else {
            input_warning("rain-doubtful", format!("{more} {:.0} mm/h", DOUBTFUL * MM_PER_HOUR))
        };
        problem.with_cause(DOUBTFUL_CAUSE).with_remedy("check the unit")
    })
}

/// What runs off of rain of the same intensity (m/s) everywhere: nothing until the initial loss has fallen, then the intensity less
/// the constant loss, as far as it is above 0.
pub fn uniform(rate: &Series, losses: Losses) -> Rain {
    let inside = rate.points().filter(|(time, _)| *time > 0.0 && *time < losses.until);
    let mut points = vec![(0.0, rate.at(0.0))];
    points.extend(inside);
    points.push((losses.until, rate.mean(losses.until, losses.until)));
    let Some(start) = filled(&points, losses.initial) else { return Rain::Uniform(Series::constant(0.0)) };
    let mut left = vec![(0.0, 0.0), (start, 0.0)];
    let mut push = |time: f64, intensity: f64| left.push((time, (intensity - losses.constant).max(0.0)));
    for pair in points.windows(2).filter(|pair| pair[1].0 > start) {
        let [(t_0, i_0), (t_1, i_1)] = [pair[0], pair[1]];
        let at = |time: f64| if t_1 > t_0 { i_0 + (time - t_0) / (t_1 - t_0) * (i_1 - i_0) } else { i_1 };
        let from = t_0.max(start);
        push(from, at(from));
        let crossing = t_0 + (losses.constant - i_0) / (i_1 - i_0) * (t_1 - t_0);
        if crossing > from && crossing < t_1 {
            push(crossing, losses.constant);
        }
        push(t_1, i_1);
    }
    left.push((losses.until, 0.0));
    Rain::Uniform(Series::new(&left).unwrap_or_else(|| Series::constant(0.0)))
}

/// The time (s) at which a depth (m) has fallen; none where it never does.
fn filled(points: &[(f64, f64)], depth: f64) -> Option<f64> {
    let mut missing = depth;
    if missing <= 0.0 {
        return Some(0.0);
    }
    for pair in points.windows(2) {
        let [(t_0, i_0), (t_1, i_1)] = [pair[0], pair[1]];
        let length = t_1 - t_0;
        let falls = 0.5 * (i_0 + i_1) * length;
        if falls >= missing && length > 0.0 {
            // i_0 s + (i_1 − i_0) s²/(2 length) = missing, in the form that does not cancel.
            let growth = (i_1 - i_0) / length;
            let root = (i_0 * i_0 + 2.0 * growth * missing).max(0.0).sqrt();
            return Some(t_0 + (2.0 * missing / (i_0 + root)).min(length));
        }
        missing -= falls;
    }
    None
}

/// The same of rain with an intensity (m/s) at each cell that is constant in time.
pub fn map(intensity: Vec<f64>, losses: Losses) -> Rain {
    let from = intensity.iter().map(|i| if *i > 0.0 { losses.initial / i } else { f64::INFINITY }).collect();
    let rate = intensity.into_iter().map(|i| (i - losses.constant).max(0.0)).collect();
    Rain::Map { rate, from, until: losses.until }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(rain: &Rain) -> f64 {
        rain.depth(0, 0.0, 1e6)
    }

    #[test]
    fn constant_rain_loses_its_beginning_and_its_share() {
        let losses = Losses { initial: 6.0, constant: 0.5, until: 10.0 };
        let rain = uniform(&Series::constant(2.0), losses);
        // It runs off from 3 s to 10 s with 1.5.
        assert!((total(&rain) - 10.5).abs() < 1e-12 && (rain.depth(0, 2.0, 4.0) - 1.5).abs() < 1e-12);
        let mapped = map(vec![2.0, 0.0], losses);
        assert!((total(&mapped) - 10.5).abs() < 1e-12 && mapped.depth(1, 0.0, 1e6).abs() <= 0.0);
    }

    #[test]
    fn a_shower_runs_off_where_it_exceeds_the_loss() {
        // A triangle of 10 s with a peak of 4: the loss of 1 leaves a triangle of 7.5 s with a peak of 3.
        let shower = Series::new(&[(0.0, 0.0), (5.0, 4.0), (10.0, 0.0)]).unwrap();
        let rain = uniform(&shower, Losses { initial: 0.0, constant: 1.0, until: 20.0 });
        assert!((total(&rain) - 0.5 * 7.5 * 3.0).abs() < 1e-12, "{}", total(&rain));
        // Its first 1.6 fall within 2 s.
        let rain = uniform(&shower, Losses { initial: 1.6, constant: 0.0, until: 20.0 });
        assert!((total(&rain) - 18.4).abs() < 1e-12 && rain.depth(0, 0.0, 2.0).abs() < 1e-12, "{}", total(&rain));
        assert!(total(&uniform(&shower, Losses { initial: 21.0, constant: 0.0, until: 20.0 })).abs() <= 0.0);
    }
}
