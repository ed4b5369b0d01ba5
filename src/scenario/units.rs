//! Quantities with units as written in a scenario: `20 m`, `1.5 km`, `1 h 30 min`, `8 GB`; converted to SI here and nowhere else.
//!
//! A length, time or level without a unit is refused, since feet taken for metres have cost more than one study;
//! only 0 needs none. Not here: ranges of values (`fields.rs`) and the places of messages (`read.rs`).

/// A kind of quantity with the units in which it may be written.
#[derive(Debug, PartialEq)]
pub struct Dimension {
    /// Its name in messages, with the article, such as `a length`.
    pub name: &'static str,
    /// Accepted units and their factors to SI; the first one is what messages suggest: the SI unit itself, but for rain.
    pub units: &'static [(&'static str, f64)],
    /// No such quantity of a flood is greater, in SI; infinite where others bound it.
    pub most: f64,
    /// Whether a number without a unit is taken as SI.
    pub is_bare_allowed: bool,
    /// Whether several parts may follow each other, as in `1 h 30 min`.
    pub is_compound: bool,
}

/// A length, a depth or a level (m).
pub static LENGTH: Dimension = Dimension {
    name: "a length",
    units: &[("m", 1.0), ("mm", 1e-3), ("cm", 1e-2), ("dm", 0.1), ("km", 1e3), ("ft", 0.3048), ("in", 0.0254)],
    most: 1e7,
    is_bare_allowed: false,
    is_compound: false,
};

/// A time (s).
pub static TIME: Dimension = Dimension {
    name: "a time",
    units: &[("s", 1.0), ("ms", 1e-3), ("min", 60.0), ("h", 3600.0), ("d", 86_400.0)],
    most: 1e10,
    is_bare_allowed: false,
    is_compound: true,
};

/// A discharge (m³/s).
pub static DISCHARGE: Dimension = Dimension {
    name: "a discharge",
    units: &[
        ("m3/s", 1.0),
        ("m³/s", 1.0),
        ("m^3/s", 1.0),
        ("l/s", 1e-3),
        ("m3/h", 1.0 / 3600.0),
        ("m3/min", 1.0 / 60.0),
        ("m3/d", 1.0 / 86_400.0),
        ("ft3/s", 0.028_316_846_592),
        ("cfs", 0.028_316_846_592),
    ],
    most: 1e9,
    is_bare_allowed: false,
    is_compound: false,
};

/// A velocity (m/s).
pub static VELOCITY: Dimension = Dimension {
    name: "a velocity",
    units: &[("m/s", 1.0), ("km/h", 1.0 / 3.6), ("cm/s", 1e-2), ("ft/s", 0.3048)],
    most: 1e3,
    is_bare_allowed: false,
    is_compound: false,
};

/// An intensity of rain (m/s).
pub static INTENSITY: Dimension = Dimension {
    name: "an intensity of rain",
    units: &[
        ("mm/h", 1e-3 / 3600.0),
        ("m/s", 1.0),
        ("mm/min", 1e-3 / 60.0),
        ("mm/d", 1e-3 / 86_400.0),
        ("cm/h", 1e-2 / 3600.0),
        ("in/h", 0.0254 / 3600.0),
    ],
    most: 1.0,
    is_bare_allowed: false,
    is_compound: false,
};

/// A slope (dimensionless).
pub static SLOPE: Dimension = Dimension {
    name: "a slope",
    units: &[("m/m", 1.0), ("%", 1e-2), ("‰", 1e-3)],
    most: 1.0,
    is_bare_allowed: true,
    is_compound: false,
};

/// A share of a whole (dimensionless).
pub static SHARE: Dimension = Dimension {
    name: "a share",
    units: &[("1", 1.0), ("%", 1e-2)],
    most: f64::INFINITY,
    is_bare_allowed: true,
    is_compound: false,
};

/// A volume (m³).
pub static VOLUME: Dimension = Dimension {
    name: "a volume",
    units: &[("m3", 1.0), ("m³", 1.0), ("hm3", 1e6), ("Mm3", 1e6), ("km3", 1e9), ("acre-ft", 1_233.481_837_547_52)],
    most: 1e15,
    is_bare_allowed: false,
    is_compound: false,
};

/// An amount of memory (bytes).
pub static MEMORY: Dimension = Dimension {
    name: "an amount of memory",
    units: &[
        ("B", 1.0),
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("TB", 1e12),
        ("KiB", 1024.0),
        ("MiB", 1_048_576.0),
        ("GiB", 1_073_741_824.0),
        ("TiB", 1_099_511_627_776.0),
    ],
    most: f64::INFINITY,
    is_bare_allowed: false,
    is_compound: false,
};

/// A number without a unit; also the Manning roughness, which is always given in s·m^(−1/3).
pub static NUMBER: Dimension =
    Dimension { name: "a plain number", units: &[], most: f64::INFINITY, is_bare_allowed: true, is_compound: false };

/// An acceleration (m/s²).
pub static ACCELERATION: Dimension = Dimension {
    name: "an acceleration",
    units: &[("m/s2", 1.0), ("m/s²", 1.0), ("m/s^2", 1.0)],
    most: f64::INFINITY,
    is_bare_allowed: true,
    is_compound: false,
};

/// Why a text is not the quantity that it should be.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitError {
    /// A short stable name, such as `unit`.
    pub code: &'static str,
    /// What is wrong.
    pub message: String,
    /// What to write instead.
    pub remedy: String,
}

impl Dimension {
    /// The factor to SI of a unit of this dimension.
    pub fn factor_of(&self, unit: &str) -> Option<f64> {
        self.units.iter().find(|(name, _)| *name == unit).map(|(_, factor)| *factor)
    }

    /// The accepted units as a list for messages.
    pub fn unit_list(&self) -> String {
        self.units.iter().map(|(unit, _)| *unit).collect::<Vec<_>>().join(", ")
    }

    /// Reads a quantity and converts it to SI.
    ///
    /// # Errors
    /// When the text is no number, has no unit where one is needed, a unit of another kind, or is not finite.
    pub fn parse(&self, text: &str) -> Result<f64, UnitError> {
        let mut rest = text.trim();
        let mut total = 0.0;
        let mut parts = 0;
        while parts == 0 || !rest.is_empty() {
            let (number, after) = split_number(rest).ok_or_else(|| self.not_a_number(text))?;
            let unit_end = if self.is_compound {
                after.find(|c: char| c.is_whitespace() || c.is_ascii_digit()).unwrap_or(after.len())
            } else {
                after.len()
            };
            let (unit, remaining) = after.split_at(unit_end);
            total += number * self.factor(text, number, unit)?;
            rest = remaining.trim_start();
            parts += 1;
            if parts > 1 && (number < 0.0 || total < 0.0) {
                return Err(self.not_a_number(text));
            }
        }
        if total.is_finite() { Ok(total) } else { Err(self.not_a_number(text)) }
    }

    fn factor(&self, text: &str, number: f64, unit: &str) -> Result<f64, UnitError> {
        if unit.is_empty() {
            if self.is_bare_allowed || number == 0.0 {
                return Ok(1.0);
            }
            let (first, _) = self.units[0];
            return Err(UnitError {
                code: "missing-unit",
                message: format!("`{text}` has no unit"),
                remedy: format!("write `{} {first}`, or one of the units {}", text.trim(), self.unit_list()),
            });
        }
        if let Some((_, factor)) = self.units.iter().find(|(name, _)| *name == unit) {
            return Ok(*factor);
        }
        if unit.starts_with(',') {
            return Err(self.not_a_number(text));
        }
        let remedy = if self.units.is_empty() {
            "write the number alone".to_owned()
        } else {
            format!("use one of the units {}", self.unit_list())
        };
        Err(UnitError {
            code: "unit",
            message: format!("`{text}` is not {}: `{unit}` is no unit of it", self.name),
            remedy,
        })
    }

    fn not_a_number(&self, text: &str) -> UnitError {
        let remedy = if text.contains(',') {
            "write a decimal point, not a comma".to_owned()
        } else if self.is_bare_allowed {
            "write a number such as `0.033`".to_owned()
        } else {
            format!("write a number and one of the units {}", self.unit_list())
        };
        UnitError { code: "not-a-quantity", message: format!("`{text}` is not {}", self.name), remedy }
    }
}

/// Splits `1.5e3 km` into 1500 and `km`; none where the text does not start with a number.
fn split_number(text: &str) -> Option<(f64, &str)> {
    let candidate = text.find(|c: char| !matches!(c, '0'..='9' | '.' | '+' | '-' | 'e' | 'E')).unwrap_or(text.len());
    // The longest beginning that is a number: in `3e` or `2E5` an exponent is taken only where it has digits.
    (1..=candidate)
        .rev()
        .find_map(|end| text[..end].parse::<f64>().ok().map(|number| (number, text[end..].trim_start())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn assert_value(dimension: &Dimension, text: &str, expected: f64) {
        let value = dimension.parse(text).unwrap();
        assert!((value - expected).abs() <= 1e-12 * expected.abs(), "{text}: {value} instead of {expected}");
    }

    #[test]
    fn quantities_become_si() {
        assert_value(&LENGTH, "20 m", 20.0);
        assert_value(&LENGTH, "1.5 km", 1500.0);
        assert_value(&LENGTH, "12 ft", 3.6576);
        assert_value(&LENGTH, "-3.5m", -3.5);
        assert_value(&LENGTH, " 1e-3  km ", 1.0);
        assert_value(&LENGTH, "0", 0.0);
        assert_value(&TIME, "4000 s", 4000.0);
        assert_value(&TIME, "1 h 30 min", 5400.0);
        assert_value(&TIME, "1h30min", 5400.0);
        assert_value(&TIME, "90 min", 5400.0);
        assert_value(&TIME, "2 d", 172_800.0);
        assert_value(&DISCHARGE, "30 m3/s", 30.0);
        assert_value(&DISCHARGE, "250l/s", 0.25);
        assert_value(&INTENSITY, "36 mm/h", 1e-5);
        assert_value(&SLOPE, "2 ‰", 0.002);
        assert_value(&SLOPE, "0.002", 0.002);
        assert_value(&MEMORY, "8 GB", 8e9);
        assert_value(&MEMORY, "2 GiB", 2_147_483_648.0);
        assert_value(&NUMBER, "0.033", 0.033);
        assert_value(&NUMBER, "5e7", 5e7);
        assert_value(&ACCELERATION, "9.81 m/s²", 9.81);
        assert_value(&ACCELERATION, "9.81", 9.81);
    }

    #[test]
    fn a_missing_unit_says_which_to_add() {
        let error = LENGTH.parse("20").unwrap_err();
        assert_eq!(error.code, "missing-unit");
        assert!(error.remedy.contains("`20 m`"), "{}", error.remedy);
        assert_eq!(TIME.parse("1 h 30").unwrap_err().code, "missing-unit");
        let rain = INTENSITY.parse("20").unwrap_err();
        assert!(rain.remedy.contains("`20 mm/h`"), "{}", rain.remedy);
    }

    #[test]
    fn a_wrong_unit_lists_the_accepted_ones() {
        for (dimension, text) in [(&LENGTH, "20 kg"), (&LENGTH, "100 s"), (&TIME, "30 m"), (&NUMBER, "0.03 m")] {
            let error = dimension.parse(text).unwrap_err();
            assert_eq!(error.code, "unit", "{text}");
            assert!(error.remedy.contains(&dimension.unit_list()), "{}", error.remedy);
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in ["", "m", "deep", "nan m", "inf m", "1e999 m", "1,5 m", "--1 m", ".inf", "ä m", "1 h -30 min"] {
            assert!(LENGTH.parse(text).is_err(), "{text}");
            assert!(TIME.parse(text).is_err(), "{text}");
        }
        assert!(LENGTH.parse("1,5 km").unwrap_err().remedy.contains("point"));
    }

    proptest::proptest! {
        #[test]
        fn no_text_makes_it_panic(text in ".*") {
            for dimension in [&LENGTH, &TIME, &DISCHARGE, &INTENSITY, &SLOPE, &MEMORY, &NUMBER, &ACCELERATION] {
                let _ = dimension.parse(&text);
            }
        }

        #[test]
        fn what_is_written_is_read_back_exactly(value in -1e9..1e9_f64) {
            proptest::prop_assert_eq!(LENGTH.parse(&format!("{value} m")).unwrap().to_bits(), value.to_bits());
        }
    }
}
