//! A minimal writer of SVG: text, lines, boxes.

use std::fmt::Write;

/// The fonts asked for: the first one that the viewer has is taken.
const FONTS: &str = "'DejaVu Sans', 'Liberation Sans', Arial, Helvetica, sans-serif";

/// Replaces the characters that mean something in XML and HTML, and those that XML does not bear.
pub fn escape(text: &str) -> String {
    let is_borne = |c: char| !c.is_control() || c == '\n' || c == '\t';
    let text: String = text.chars().map(|c| if is_borne(c) { c } else { char::REPLACEMENT_CHARACTER }).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Width (pixels) that a text will take, near enough to lay out a legend.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    0.61 * size * text.chars().count() as f64
}

/// How a text is set.
#[derive(Clone, Copy)]
pub(super) struct Style {
    pub size: f64,
    /// `start`, `middle` or `end`.
    pub anchor: &'static str,
    pub weight: &'static str,
    pub fill: &'static str,
    /// Whether a white rim keeps the text readable above a map.
    pub halo: bool,
}

impl Style {
    pub const PLAIN: Style = Style { size: 11.0, anchor: "start", weight: "normal", fill: "#222", halo: false };

    pub fn size(self, size: f64) -> Style {
        Style { size, ..self }
    }

    pub fn bold(self) -> Style {
        Style { weight: "bold", ..self }
    }

    pub fn anchor(self, anchor: &'static str) -> Style {
        Style { anchor, ..self }
    }

    pub fn fill(self, fill: &'static str) -> Style {
        Style { fill, ..self }
    }

    pub fn halo(self) -> Style {
        Style { halo: true, ..self }
    }
}

/// A drawing in the making. Coordinates are pixels, y downwards.
#[derive(Default)]
pub(super) struct Drawing {
    body: String,
}

impl Drawing {
    /// Adds a line of markup. Writing to a string cannot fail.
    pub fn raw(&mut self, markup: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.body, "{markup}");
    }

    pub fn text(&mut self, x: f64, y: f64, style: Style, text: &str) {
        self.turned_text(x, y, 0.0, style, text);
    }

    /// A text turned by `angle` (degrees, clockwise) about its anchor.
    pub fn turned_text(&mut self, x: f64, y: f64, angle: f64, style: Style, text: &str) {
        let Style { size, anchor, weight, fill, halo } = style;
        let turn =
            if angle == 0.0 { String::new() } else { format!(r#" transform="rotate({angle:.0} {x:.1} {y:.1})""#) };
        let place =
            format!(r#"x="{x:.1}" y="{y:.1}" font-size="{size}" text-anchor="{anchor}" font-weight="{weight}"{turn}"#);
        let text = escape(text);
        if halo {
            self.raw(format_args!(
                r##"<text {place} fill="#fff" stroke="#fff" stroke-width="3.2" stroke-linejoin="round">{text}</text>"##
            ));
        }
        self.raw(format_args!(r#"<text {place} fill="{fill}">{text}</text>"#));
    }

    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: &str, width: f64) {
        self.raw(format_args!(
            r#"<line x1="{:.1}" y1="{:.1}" x2="{:.1}" y2="{:.1}" stroke="{stroke}" stroke-width="{width}"/>"#,
            from.0, from.1, to.0, to.1
        ));
    }

    /// A box given by its corner, width and height.
    pub fn rectangle(&mut self, corner: (f64, f64), size: (f64, f64), fill: &str, stroke: &str) {
        self.raw(format_args!(
            r#"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}" fill="{fill}" stroke="{stroke}"/>"#,
            corner.0, corner.1, size.0, size.1
        ));
    }

    /// The whole document.
    pub fn finish(self, width: f64, height: f64, title: &str) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
             width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             font-family=\"{FONTS}\">\n<title>{}</title>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{}</svg>\n",
            escape(title),
            self.body
        )
    }
}

/// A round number (1, 2 or 5 times a power of ten) at least as large as `wanted`.
pub(super) fn round_step(wanted: f64) -> f64 {
    let power = 10f64.powf(wanted.max(1e-12).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|step| *step >= wanted * (1.0 - 1e-9)).unwrap_or(wanted)
}

/// A number with as many decimals as a multiple of `step` needs, thousands apart.
pub(super) fn number(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    let (whole, rest) = text.split_at(text.find('.').unwrap_or(text.len()));
    let (sign, digits) = whole.split_at(usize::from(whole.starts_with('-')));
    let first = digits.len() % 3;
    let groups = std::iter::once(&digits[..first]).chain((first..digits.len()).step_by(3).map(|k| &digits[k..k + 3]));
    let grouped = groups.filter(|group| !group.is_empty()).collect::<Vec<_>>().join("\u{202f}");
    format!("{}{grouped}{rest}", if sign.is_empty() { "" } else { "−" })
}

/// A number of at most six decimals, without needless ones.
pub(super) fn trimmed(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_large_enough() {
        for (wanted, step) in [(1.0, 1.0), (1.2, 2.0), (0.03, 0.05), (700.0, 1000.0), (20.0, 20.0)] {
            assert!((round_step(wanted) - step).abs() < 1e-12 * step);
        }
    }

    #[test]
    fn numbers_are_grouped_by_thousands() {
        assert_eq!(number(5_186_000.0, 1000.0), "5\u{202f}186\u{202f}000");
        assert_eq!(number(-2500.0, 500.0), "−2\u{202f}500");
        assert_eq!(number(0.25, 0.05), "0.25");
        assert_eq!(number(12.0, 1.0), "12");
    }

    #[test]
    fn markup_in_names_is_harmless() {
        assert_eq!(escape("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
    }
}
