//! Common formulas for the breach of an embankment dam: its width and the time in which it forms, from V_w (m³), the water above
//! its bottom, and h (m), its height, which here stands for the depth of that water too.
//!
//! ```text
//! Froehlich2008   B = 0.27 K V_w^0.32 h^0.04      K = 1.3 | 1.0   t = 63.2 √(V_w/(g h²)) s             m = 1.0 | 0.7
//! Froehlich1995   B = 0.1803 K V_w^0.32 h^0.19    K = 1.4 | 1.0   t = 0.00254 V_w^0.53 h^−0.90 hours   m = 1.4 | 0.9
//! MacDonald1984   V_e = 0.0261 (V_w h)^0.769 m³                   t = 0.0179 V_e^0.364 hours           m = 0.5
//! VonThun1990     B = 2.5 h + C(V_w)                              t = 0.015 h to 0.020 h + 0.25 hours  m = 1.0
//! ```
//!
//! B is the mean width, m the slope of the sides (horizontal to vertical); left of the bar overtopping, right of it piping.
//! `MacDonald1984` gives the volume V_e that is eroded from an earthfill dam, which becomes a width with the section of the dam
//! only. References: `Froehlich2008`, `Froehlich1995`, `MacDonald1984`, `VonThun1990`.
//!
//! The peak discharge Q (m³/s), of the same two:
//!
//! ```text
//! Froehlich1995b  Q = 0.607 V_w^0.295 h^1.24
//! MacDonald1984   Q = 1.154 (V_w h)^0.412        the best fit
//! Pierce2010      Q = 0.038 V_w^0.475 h^1.09
//! ```
//!
//! How far failures lie from a formula is that of `Wahl2004`: two standard deviations of the logarithm of what the formula says over what was
//! observed, about its mean, from past failures without outliers. Some 95 % lie between two shares of what the formula says.

/// How the dam fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailureMode {
    /// Water runs over the crest.
    Overtopping,
    /// Water runs through the dam.
    Piping,
}

/// What one formula says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BreachEstimate {
    /// Its name.
    pub name: &'static str,
    /// Mean width (m), where the formula gives one.
    pub mean_width: Option<f64>,
    /// Slope of the sides, horizontal to vertical.
    pub side_slope: f64,
    /// Shortest and longest time in which the breach forms (s); equal where the formula gives one.
    pub time: [f64; 2],
    /// Volume eroded from the dam (m³), where the formula gives one.
    pub eroded: Option<f64>,
    /// The 95 % prediction interval of the mean width as shares of it, where it is known.
    pub width_of_failures: Option<[f64; 2]>,
    /// The same of the time.
    pub time_of_failures: Option<[f64; 2]>,
}

/// What one formula says of the peak discharge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakEstimate {
    /// Its name.
    pub name: &'static str,
    /// The peak discharge (m³/s).
    pub discharge: f64,
    /// Its 95 % prediction interval as shares of it, where that is known.
    pub of_failures: Option<[f64; 2]>,
}

impl BreachEstimate {
    /// Width of the bottom (m) of a breach of this height (m): B − m h, or 0 where the sides meet above it.
    pub fn bottom_width(&self, height: f64) -> Option<f64> {
        self.mean_width.map(|width| (width - self.side_slope * height).max(0.0))
    }
}

const HOUR: f64 = 3600.0;

/// Storages (m³) up to which a width (m) is added after `VonThun1990`; the last one beyond all of them.
const VON_THUN_WIDTHS: [(f64, f64); 4] = [(1.23e6, 6.1), (6.17e6, 18.3), (1.23e7, 42.7), (f64::INFINITY, 54.9)];

/// All formulas for a volume (m³) and a height (m), both positive.
pub fn breach_estimates(volume: f64, height: f64, mode: FailureMode, gravity: f64) -> [BreachEstimate; 4] {
    let is_over = mode == FailureMode::Overtopping;
    let of_mode = |overtopping: f64, piping: f64| if is_over { overtopping } else { piping };
    let one = |time: f64| [time; 2];
    let eroded = 0.0261 * (volume * height).powf(0.769);
    let added = VON_THUN_WIDTHS.iter().find(|(limit, _)| volume < *limit).map_or(54.9, |(_, width)| *width);
    [
        BreachEstimate {
            name: "Froehlich 2008",
            mean_width: Some(0.27 * of_mode(1.3, 1.0) * volume.powf(0.32) * height.powf(0.04)),
            side_slope: of_mode(1.0, 0.7),
            time: one(63.2 * (volume / (gravity * height * height)).sqrt()),
            eroded: None,
            width_of_failures: None,
            time_of_failures: None,
        },
        BreachEstimate {
            name: "Froehlich 1995",
            mean_width: Some(0.1803 * of_mode(1.4, 1.0) * volume.powf(0.32) * height.powf(0.19)),
            side_slope: of_mode(1.4, 0.9),
            time: one(0.00254 * volume.powf(0.53) * height.powf(-0.90) * HOUR),
            eroded: None,
            width_of_failures: Some([0.40, 2.4]),
            time_of_failures: Some([0.38, 7.3]),
        },
        BreachEstimate {
            name: "MacDonald & Langridge-Monopolis 1984",
            mean_width: None,
            side_slope: 0.5,
            time: one(0.0179 * eroded.powf(0.364) * HOUR),
            eroded: Some(eroded),
            width_of_failures: None,
            time_of_failures: Some([0.24, 11.0]),
        },
        BreachEstimate {
            name: "Von Thun & Gillette 1990",
            mean_width: Some(2.5 * height + added),
            side_slope: 1.0,
            time: [0.015 * height * HOUR, (0.020 * height + 0.25) * HOUR],
            eroded: None,
            width_of_failures: Some([0.37, 1.8]),
            time_of_failures: Some([0.49, 40.0]),
        },
    ]
}

/// All formulas for the peak discharge of a volume (m³) and a height (m), both positive.
pub fn peak_estimates(volume: f64, height: f64) -> [PeakEstimate; 3] {
    [
        PeakEstimate {
            name: "Froehlich 1995",
            discharge: 0.607 * volume.powf(0.295) * height.powf(1.24),
            of_failures: Some([0.53, 2.3]),
        },
        PeakEstimate {
            name: "MacDonald & Langridge-Monopolis 1984",
            discharge: 1.154 * (volume * height).powf(0.412),
            of_failures: Some([0.15, 3.7]),
        },
        PeakEstimate {
            name: "Pierce, Thornton & Abt 2010",
            discharge: 0.038 * volume.powf(0.475) * height.powf(1.09),
            of_failures: None,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64, tolerance: f64) -> bool {
        (a - b).abs() <= tolerance
    }

    #[test]
    fn froehlich_2008_by_hand() {
        // 10^7 m³, 30 m: 10^(7·0.32) = 10^2.24 = 173.780; 30^0.04 = e^(0.04·3.401197) = e^0.136048 = 1.145737.
        let hand = 0.27 * 173.780 * 1.145_737;
        let over = breach_estimates(1e7, 30.0, FailureMode::Overtopping, 9.81)[0];
        assert!(near(over.mean_width.unwrap(), 1.3 * hand, 1e-3) && near(over.mean_width.unwrap(), 69.9, 0.05));
        // 10^7/(9.81·900) = 1132.6311; its root 33.65458; times 63.2 = 2126.97 s.
        assert!(near(over.time[0], 2126.97, 0.01) && near(over.time[1], over.time[0], 0.0));
        assert!(near(over.side_slope, 1.0, 0.0) && near(over.bottom_width(30.0).unwrap(), 39.9, 0.05));
        let piping = breach_estimates(1e7, 30.0, FailureMode::Piping, 9.81)[0];
        assert!(near(piping.mean_width.unwrap(), hand, 1e-3) && near(piping.side_slope, 0.7, 0.0));
        assert!(near(piping.time[0], over.time[0], 0.0));
    }

    #[test]
    fn the_other_formulas_by_hand() {
        let [_, f95, mlm, vtg] = breach_estimates(1e7, 30.0, FailureMode::Overtopping, 9.81);
        // 30^0.19 = e^0.6462274 = 1.908330; 0.1803·1.4·173.780·1.908330 = 83.7093.
        assert!(near(f95.mean_width.unwrap(), 83.709, 0.01));
        // 10^3.71 = 5128.614; 30^−0.9 = e^−3.0610777 = 0.0468373; 0.00254·5128.614·0.0468373 = 0.610136 h.
        assert!(near(f95.time[0], 0.610_136 * 3600.0, 0.5));
        // (3·10^8)^0.769: log10 = 8.4771213·0.769 = 6.5189063, 3.302981·10^6; times 0.0261 = 86208 m³.
        assert!(near(mlm.eroded.unwrap(), 86_208.0, 20.0) && mlm.mean_width.is_none());
        // 86208^0.364: log10 = 4.9355476·0.364 = 1.7965393, 62.5950; times 0.0179 = 1.120450 h.
        assert!(near(mlm.time[0], 1.120_45 * 3600.0, 0.5));
        // 75 m and 42.7 m of a storage between 6.17 and 12.3 million m³; 0.45 h and 0.85 h.
        assert!(near(vtg.mean_width.unwrap(), 117.7, 1e-9));
        assert!(near(vtg.time[0], 1620.0, 1e-6) && near(vtg.time[1], 3060.0, 1e-6));
        let of_volume = |volume: f64| breach_estimates(volume, 10.0, FailureMode::Piping, 9.81)[3].mean_width.unwrap();
        for (volume, width) in [(1e6, 31.1), (2e6, 43.3), (1e7, 67.7), (2e7, 79.9)] {
            assert!(near(of_volume(volume), width, 1e-9), "{volume}");
        }
    }

    #[test]
    fn peak_discharges_by_hand() {
        let [f95, mlm, pierce] = peak_estimates(1e7, 30.0);
        // 10^2.065 = 116.145; 30^1.24 = e^4.217485 = 67.862; 0.607·116.145·67.862 = 4784.3.
        assert!(near(f95.discharge, 4784.3, 0.5));
        // (3·10^8)^0.412 = 10^3.492574 = 3108.7; times 1.154.
        assert!(near(mlm.discharge, 3587.4, 0.5));
        // 10^3.325 = 2113.49; 30^1.09 = e^3.707305 = 40.744.
        assert!(near(pierce.discharge, 3272.2, 0.5));
        // The shares are 10^(−e ± s), of the mean error e and twice its deviation s in powers of ten (`Wahl2004`).
        let shares = |e: f64, s: f64| [10_f64.powf(-e - s), 10_f64.powf(-e + s)];
        let [_, width, eroded, broad] = breach_estimates(1e7, 30.0, FailureMode::Overtopping, 9.81);
        for (stated, [e, s]) in [
            (f95.of_failures, [-0.04, 0.32]),
            (mlm.of_failures, [0.13, 0.70]),
            (width.width_of_failures, [0.01, 0.39]),
            (width.time_of_failures, [-0.22, 0.64]),
            (eroded.time_of_failures, [-0.21, 0.83]),
            (broad.width_of_failures, [0.09, 0.35]),
            (broad.time_of_failures, [-0.64, 0.95]),
        ] {
            let of_errors = shares(e, s);
            let is_near = |(stated, share): (f64, f64)| (stated / share - 1.0).abs() < 0.05;
            assert!(stated.unwrap().into_iter().zip(of_errors).all(is_near), "{stated:?} {of_errors:?}");
        }
    }

    #[test]
    fn the_bottom_of_a_high_dam_is_a_point() {
        let low = breach_estimates(1e4, 100.0, FailureMode::Overtopping, 9.81)[0];
        assert!(near(low.bottom_width(100.0).unwrap(), 0.0, 0.0));
    }
}
