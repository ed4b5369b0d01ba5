//! Classes and colours of the maps: depth, arrival, speed, hazard.
//!
//! Planners read classes, not continuous ramps. Depth: the limits of the European flood maps (0.5, 1, 2, 4 m) in blues, and
//! doubled on for dam breaks. Hazard: H1 to H6 of the Australian combined curves, `AIDR2017`.

use super::svg::{round_step, trimmed};

/// A colour: red, green, blue.
pub type Colour = [u8; 3];

/// A classed legend: each class begins at its lower bound and ends where the next one begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Classes {
    /// Heading of the legend, with the unit in brackets.
    pub title: String,
    /// Lower bound, colour and label of each class, bounds ascending. A value below the first bound is not drawn.
    pub entries: Vec<(f64, Colour, String)>,
}

impl Classes {
    /// The class of a value, if it has one; NaN has none.
    #[inline]
    pub fn class_of(&self, value: f64) -> Option<usize> {
        self.entries.partition_point(|(bound, ..)| *bound <= value).checked_sub(1).filter(|_| !value.is_nan())
    }

    /// Depth (m): the limits of flood maps up to the class of `greatest` (m); smaller steps where all water is shallow.
    pub fn depth(greatest: f64) -> Classes {
        let colours = [
            [0xd6, 0xe9, 0xf8],
            [0xa9, 0xd0, 0xee],
            [0x74, 0xb0, 0xe0],
            [0x41, 0x8c, 0xcd],
            [0x1d, 0x66, 0xb2],
            [0x10, 0x43, 0x8c],
            [0x0a, 0x24, 0x62],
            [0x2a, 0x0f, 0x45],
        ];
        Classes::from_bounds("Water depth (m)", &[0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0], &colours, greatest)
    }

    /// Speed (m/s) up to the class of `greatest` (m/s); smaller steps where all water is slow.
    pub fn speed(greatest: f64) -> Classes {
        let colours = [
            [0xfc, 0xf3, 0xd0],
            [0xfa, 0xdd, 0x9a],
            [0xf3, 0xb5, 0x5c],
            [0xe5, 0x84, 0x34],
            [0xc4, 0x50, 0x24],
            [0x92, 0x26, 0x24],
            [0x52, 0x0c, 0x2a],
        ];
        Classes::from_bounds("Speed (m/s)", &[0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0], &colours, greatest)
    }

    /// Dilution up to the class of `greatest`, a share.
    pub fn dilution(greatest: f64) -> Classes {
        let colours = [
            [0xed, 0xf4, 0xdc],
            [0xcf, 0xe5, 0xb0],
            [0xa3, 0xcf, 0x8a],
            [0x6c, 0xb0, 0x74],
            [0x3d, 0x8b, 0x67],
            [0x1f, 0x64, 0x58],
            [0x12, 0x3f, 0x45],
        ];
        Classes::from_bounds("Share of the source", &[0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 0.9], &colours, greatest)
    }

    /// A probability, from 0 to 1.
    pub fn probability() -> Classes {
        let entries = [
            (0.01, [0xfe, 0xeb, 0xe2], "1 – 5 %"),
            (0.05, [0xfc, 0xc5, 0xc0], "5 – 25 %"),
            (0.25, [0xfa, 0x9f, 0xb5], "25 – 50 %"),
            (0.5, [0xf7, 0x68, 0xa1], "50 – 75 %"),
            (0.75, [0xc5, 0x1b, 0x8a], "75 – 95 %"),
            (0.95, [0x7a, 0x01, 0x77], "95 % and more"),
        ];
        let entries = entries.map(|(bound, colour, label)| (bound, colour, label.to_owned()));
        Classes { title: "Share of the runs".to_owned(), entries: entries.into() }
    }

    /// Differences, whose outer classes begin at about `usual` in size; those below a tenth of that are grey.
    pub fn difference(title: &str, usual: f64) -> Classes {
        let step = round_step(usual).max(f64::MIN_POSITIVE);
        let bounds = [-1.0, -0.5, -0.1, 0.1, 0.5, 1.0].map(|share| share * step);
        let colours = [
            [0x21, 0x66, 0xac],
            [0x67, 0xa9, 0xcf],
            [0xd1, 0xe5, 0xf0],
            [0xd9, 0xd9, 0xd9],
            [0xfd, 0xdb, 0xc7],
            [0xef, 0x8a, 0x62],
            [0xb2, 0x18, 0x2b],
        ];
        let entry = |(class, colour): (usize, Colour)| {
            let lower = class.checked_sub(1).map(|at| bounds[at]);
            let label = match (lower, bounds.get(class)) {
                (None, upper) => format!("under {}", trimmed(upper.copied().unwrap_or(0.0))),
                (Some(lower), Some(upper)) => format!("{} to {}", trimmed(lower), trimmed(*upper)),
                (Some(lower), None) => format!("over {}", trimmed(lower)),
            };
            (lower.unwrap_or(f64::MIN), colour, label)
        };
        Classes { title: title.to_owned(), entries: colours.into_iter().enumerate().map(entry).collect() }
    }

    /// Arrival time (s), classed by `isochrones` (s, ascending), the earliest in the darkest red.
    pub fn arrival(isochrones: &[f64]) -> Classes {
        let stops: [Colour; 6] = [
            [0x8c, 0x0d, 0x25],
            [0xdd, 0x4a, 0x33],
            [0xf9, 0xa6, 0x5a],
            [0xfb, 0xe6, 0xa0],
            [0x8f, 0xc6, 0xc4],
            [0x3a, 0x6f, 0xa5],
        ];
        let count = isochrones.len() + 1;
        let entries = (0..count).map(|class| {
            let lower = if class == 0 { f64::MIN } else { isochrones[class - 1] };
            let label = match (class, isochrones.get(class)) {
                (0, Some(upper)) => format!("up to {}", clock(*upper)),
                (0, None) => "reached".to_string(),
                (_, Some(upper)) => format!("{} – {}", clock(lower), clock(*upper)),
                (_, None) => format!("after {}", clock(lower)),
            };
            (lower, ramp(&stops, class as f64 / (count - 1).max(1) as f64), label)
        });
        Classes { title: "Arrival of the flood".to_string(), entries: entries.collect() }
    }

    /// The combined hazard classes H1 to H6, as numbers 1 to 6.
    pub fn hazard() -> Classes {
        let entries = [
            ([0xa6, 0xd9, 0x6a], "H1 generally safe"),
            ([0xff, 0xff, 0xbf], "H2 unsafe for small vehicles"),
            ([0xfe, 0xe0, 0x8b], "H3 unsafe for vehicles, children, the elderly"),
            ([0xfd, 0xae, 0x61], "H4 unsafe for people and vehicles"),
            ([0xd7, 0x30, 0x1f], "H5 buildings vulnerable to damage"),
            ([0x7a, 0x01, 0x77], "H6 all buildings may fail"),
        ];
        Classes {
            title: "Hazard class (AIDR)".to_string(),
            entries: (1..)
                .zip(entries)
                .map(|(class, (colour, label))| (f64::from(class), colour, label.into()))
                .collect(),
        }
    }

    /// Classes of the field, or, where even the third would stay empty (a laboratory flume), equal steps up to `greatest`.
    fn from_bounds(title: &str, bounds: &[f64], colours: &[Colour], greatest: f64) -> Classes {
        let step = round_step(greatest / 6.0);
        let equal = [0.1, 1.0, 2.0, 3.0, 4.0, 5.0].map(|factor| factor * step);
        let bounds = if greatest < bounds[2] { &equal[..] } else { bounds };
        let used = bounds.iter().filter(|bound| **bound <= greatest).count().max(1);
        let entries = (0..used).map(|class| {
            let label = match bounds[..used].get(class + 1) {
                Some(upper) => format!("{} – {}", trimmed(bounds[class]), trimmed(*upper)),
                None => format!("over {}", trimmed(bounds[class])),
            };
            (bounds[class], colours[class], label)
        });
        Classes { title: title.to_string(), entries: entries.collect() }
    }
}

/// A time as people say it: `90 s`, `5 min`, `1 h 30 min`.
pub fn clock(seconds: f64) -> String {
    let whole = seconds.round() as i64;
    match (whole / 3600, whole % 3600 / 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, 1, s) if s > 0 => format!("{whole} s"),
        (0, min, 0) => format!("{min} min"),
        (0, min, s) => format!("{min} min {s} s"),
        (h, 0, 0) => format!("{h} h"),
        (h, min, 0) => format!("{h} h {min} min"),
        (h, min, s) => format!("{h} h {min} min {s} s"),
    }
}

/// The colour at `place` (0 to 1) of a ramp through equally spaced stops.
pub(super) fn ramp(stops: &[Colour], place: f64) -> Colour {
    let along = place.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let first = (along.floor() as usize).min(stops.len().saturating_sub(2));
    let second = (first + 1).min(stops.len() - 1);
    let t = along - first as f64;
    let mix = |k: usize| (f64::from(stops[first][k]) * (1.0 - t) + f64::from(stops[second][k]) * t).round() as u8;
    [mix(0), mix(1), mix(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_falls_into_the_class_that_begins_below_it() {
        let depth = Classes::depth(5.0);
        assert_eq!(depth.entries.len(), 5);
        assert_eq!(depth.class_of(0.05), None);
        assert_eq!(depth.class_of(f64::NAN), None);
        assert_eq!(depth.class_of(0.1), Some(0));
        assert_eq!(depth.class_of(0.5), Some(1));
        assert_eq!(depth.class_of(1e9), Some(4));
        assert_eq!(depth.entries[4].2, "over 4");
    }

    #[test]
    fn shallow_water_gets_its_own_steps() {
        let flume = Classes::depth(0.25);
        let labels: Vec<_> = flume.entries.iter().map(|(_, _, label)| label.as_str()).collect();
        assert_eq!(labels, ["0.005 – 0.05", "0.05 – 0.1", "0.1 – 0.15", "0.15 – 0.2", "0.2 – 0.25", "over 0.25"]);
    }

    #[test]
    fn arrival_has_a_class_on_either_side_of_each_isochrone() {
        let arrival = Classes::arrival(&[300.0, 5400.0]);
        let labels: Vec<_> = arrival.entries.iter().map(|(_, _, label)| label.as_str()).collect();
        assert_eq!(labels, ["up to 5 min", "5 min – 1 h 30 min", "after 1 h 30 min"]);
        assert_eq!(arrival.class_of(0.0), Some(0));
        assert_eq!(arrival.class_of(300.0), Some(1));
    }

    #[test]
    fn times_read_as_people_say_them() {
        for (seconds, text) in
            [(0.0, "0 s"), (75.0, "75 s"), (150.0, "2 min 30 s"), (3600.0, "1 h"), (3661.0, "1 h 1 min 1 s")]
        {
            assert_eq!(clock(seconds), text);
        }
    }

    #[test]
    fn a_ramp_meets_its_stops() {
        let stops = [[0, 0, 0], [100, 50, 10], [200, 200, 200]];
        assert_eq!(ramp(&stops, 0.0), stops[0]);
        assert_eq!(ramp(&stops, 0.5), stops[1]);
        assert_eq!(ramp(&stops, 1.0), stops[2]);
        assert_eq!(ramp(&stops, 0.25), [50, 25, 5]);
    }
}
