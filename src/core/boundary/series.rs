//! A quantity over time, linear between its points, held before the first and after the last one; its integral is exact.

/// Values at times; see the module.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Series {
    times: Vec<f64>,
    values: Vec<f64>,
}

impl Series {
    /// The same value at all times.
    pub fn constant(value: f64) -> Self {
        Series { times: vec![0.0], values: vec![value] }
    }

    /// A series through points (s, and any unit), whose times do not fall; two points of one time are a jump. None without
    /// points, with a time before the one before it, or with a number that is not finite.
    pub fn new(points: &[(f64, f64)]) -> Option<Self> {
        let (times, values): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        let is_finite = times.iter().chain(&values).all(|number| number.is_finite());
        let is_ordered = times.windows(2).all(|pair| pair[0] <= pair[1]);
        (!points.is_empty() && is_finite && is_ordered).then_some(Series { times, values })
    }

    /// The points.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.times.iter().copied().zip(self.values.iter().copied())
    }

    /// The value at a time (s); at a jump that after it.
    pub fn at(&self, time: f64) -> f64 {
        let after = self.times.partition_point(|t| *t <= time);
        match after {
            0 => self.values[0],
            _ if after == self.times.len() => self.values[after - 1],
            _ => self.between(after, time),
        }
    }

    /// The value at a time between the point before `after` and the point `after`.
    fn between(&self, after: usize, time: f64) -> f64 {
        let (t_0, t_1) = (self.times[after - 1], self.times[after]);
        let share = (time - t_0) / (t_1 - t_0);
        self.values[after - 1] + share * (self.values[after] - self.values[after - 1])
    }

    /// The integral from one time to a later one (s), piece by piece, so that the integrals of many short steps add up to that of
    /// all of them but for rounding.
    pub fn integral(&self, from: f64, to: f64) -> f64 {
        let mut sum = 0.0;
        let mut at = from;
        let mut next = self.times.partition_point(|t| *t <= from);
        while at < to {
            let end = self.times.get(next).map_or(to, |time| time.min(to));
            if end <= at {
                // A jump.
                next += 1;
                continue;
            }
            let (first, last) = match next {
                0 => (self.values[0], self.values[0]),
                _ if next == self.times.len() => (self.values[next - 1], self.values[next - 1]),
                _ => (self.between(next, at), self.between(next, end)),
            };
            sum += 0.5 * (first + last) * (end - at);
            at = end;
            next += 1;
        }
        sum
    }

    /// The mean from one time to a later one (s); the value where they are the same.
    pub fn mean(&self, from: f64, to: f64) -> f64 {
        if to > from { self.integral(from, to) / (to - from) } else { self.at(from) }
    }

    /// The largest value from one time to a later one (s).
    pub fn largest(&self, from: f64, to: f64) -> f64 {
        let first = self.times.partition_point(|time| *time < from);
        let last = self.times.partition_point(|time| *time <= to).max(first);
        self.values[first..last].iter().copied().fold(self.at(from).max(self.at(to)), f64::max)
    }

    /// The largest value of all.
    pub fn peak(&self) -> f64 {
        self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hydrograph() -> Series {
        Series::new(&[(10.0, 0.0), (20.0, 5.0), (40.0, 5.0), (40.0, 2.0), (90.0, 0.0)]).unwrap()
    }

    #[test]
    fn values_are_linear_between_points_and_held_outside() {
        let series = hydrograph();
        for (time, value) in [(0.0, 0.0), (12.0, 1.0), (30.0, 5.0), (40.0, 2.0), (65.0, 1.0), (200.0, 0.0)] {
            assert!((series.at(time) - value).abs() < 1e-15, "{time}: {}", series.at(time));
        }
        assert!((series.largest(12.0, 13.0) - 1.5).abs() < 1e-15 && series.largest(12.0, 60.0) >= 5.0);
    }

    #[test]
    fn integrals_of_uneven_steps_add_up_to_the_whole() {
        let series = hydrograph();
        // Two triangles, a rectangle: 25 + 100 + 50.
        assert!((series.integral(0.0, 100.0) - 175.0).abs() < 1e-12);
        let (mut time, mut sum, mut step) = (0.0, 0.0, 0.013);
        while time < 100.0 {
            let next = f64::min(time + step, 100.0);
            sum += series.mean(time, next) * (next - time);
            step = 0.01 + (step * 7919.0).fract() * 0.05;
            time = next;
        }
        assert!((sum / 175.0 - 1.0).abs() < 1e-13, "{sum}");
    }

    #[test]
    fn disorder_is_refused() {
        assert_eq!(Series::new(&[]), None);
        assert_eq!(Series::new(&[(1.0, 0.0), (0.0, 1.0)]), None);
        assert_eq!(Series::new(&[(0.0, f64::NAN)]), None);
        assert!((Series::constant(3.0).integral(1.0, 5.0) - 12.0).abs() < 1e-15);
    }
}
