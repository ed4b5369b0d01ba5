//! A number with its unit, as studies vary it.

/// A number with its unit, as written; the unit is empty where there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Amount {
    /// The number.
    pub number: f64,
    /// The unit.
    pub unit: String,
}

impl Amount {
    /// Reads `35 min`, `0.03` or `2.5e3 m3/s`; none of a text that is no number with at most one unit.
    pub fn read(text: &str) -> Option<Amount> {
        /// No number with its unit is longer.
        const LONGEST: usize = 64;
        let text = text.trim();
        if text.len() > LONGEST {
            return None;
        }
        let ends = (1..=text.len()).rev().filter(|end| text.is_char_boundary(*end));
        let (end, number) = ends.filter_map(|end| Some((end, text[..end].parse::<f64>().ok()?))).next()?;
        let unit = text[end..].trim();
        let is_one = !unit.contains(char::is_whitespace) && !unit.starts_with(|c: char| c.is_ascii_digit());
        (number.is_finite() && is_one).then(|| Amount { number, unit: unit.to_owned() })
    }

    /// The text of a scenario: six digits, which is more than any of these values is known to.
    pub fn text(&self) -> String {
        let number = rounded(self.number);
        if self.unit.is_empty() { format!("{number}") } else { format!("{number} {}", self.unit) }
    }
}

/// A number with six digits.
pub fn rounded(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_have_one_number_and_one_unit() {
        let read = |text| Amount::read(text).map(|amount| (amount.number, amount.unit));
        let amount = |number, unit: &str| Some((number, unit.to_owned()));
        assert_eq!(read("35 min"), amount(35.0, "min"));
        assert_eq!(read(" 2.5e3 m3/s "), amount(2500.0, "m3/s"));
        assert_eq!((read("20m"), read("-0.03")), (amount(20.0, "m"), amount(-0.03, "")));
        assert_eq!(read("1e3m"), amount(1000.0, "m"));
        for text in ["", "m", "1 h 30 min", "inf", "nan m", "1 2", "breach.geojson"] {
            assert_eq!(read(text), None, "{text}");
        }
        assert_eq!(Amount { number: 0.012_345_678, unit: String::new() }.text(), "0.0123457");
        assert_eq!(Amount { number: 812.0, unit: "m".into() }.text(), "812 m");
    }
}
