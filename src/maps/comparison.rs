//! Measured and computed lines beside each other: one panel for each gauge, all to one scale of time.

use super::svg::{Drawing, Style, number, round_step, text_width};

/// A computed line.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugeLine {
    /// Name in the legend.
    pub name: String,
    /// Time (s) or place (m) and value, ascending.
    pub points: Vec<(f64, f64)>,
}

/// What stands at the level axis of the panels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PanelAxis {
    /// Time (s), from 0.
    #[default]
    Time,
    /// Places along a line (m), from the first to the last one; the titles of the panels have the units of their values.
    Place,
}

/// What was measured at a gauge, and what runs made of it.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugePanel {
    /// The gauge.
    pub title: String,
    /// What the values are drawn over; that of the first panel is that of all.
    pub axis: PanelAxis,
    /// Time (s) or place (m) and value; a few points are marks, many a line; there may be none.
    pub measured: Vec<(f64, f64)>,
    /// Runs.
    pub computed: Vec<GaugeLine>,
}

/// Colours that remain distinct for colour-blind readers, after `Okabe2008`.
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];
/// So few points are marks.
const MARKS: usize = 12;
const COLUMNS: usize = 2;
const SIZE: (f64, f64) = (400.0, 170.0);
const GAP: (f64, f64) = (80.0, 62.0);
const CORNER: (f64, f64) = (70.0, 74.0);

/// The panels as an SVG document; `unit_label` stands at the upright axes of panels over time, such as `depth (m)`.
pub fn comparison(title: &str, unit_label: &str, panels: &[GaugePanel]) -> String {
    let mut drawing = Drawing::default();
    drawing.text(CORNER.0, 30.0, Style::PLAIN.size(16.0).bold(), title);
    let last = panels.iter().flat_map(points).map(|point| point.0).fold(0.0, f64::max);
    let first = match panels.first().map_or(PanelAxis::Time, |panel| panel.axis) {
        PanelAxis::Time => 0.0,
        PanelAxis::Place => panels.iter().flat_map(points).map(|point| point.0).fold(last, f64::min),
    };
    for (k, panel) in panels.iter().enumerate() {
        let (column, row) = ((k % COLUMNS) as f64, (k / COLUMNS) as f64);
        let corner = (CORNER.0 + column * (SIZE.0 + GAP.0), CORNER.1 + row * (SIZE.1 + GAP.1));
        draw(&mut drawing, panel, &Axes::of(panel, corner, (first, last)), unit_label);
    }
    let rows = panels.len().div_ceil(COLUMNS) as f64;
    let (right, bottom) = (CORNER.0 + 2.0 * SIZE.0 + GAP.0, CORNER.1 + rows * (SIZE.1 + GAP.1));
    legend(&mut drawing, panels, (CORNER.0, bottom - 6.0));
    drawing.finish(right + 26.0, bottom + 16.0, title)
}

fn points(panel: &GaugePanel) -> impl Iterator<Item = &(f64, f64)> {
    panel.measured.iter().chain(panel.computed.iter().flat_map(|line| &line.points)).filter(|point| point.1.is_finite())
}

/// The axes of a panel: where times and values lie on the sheet.
struct Axes {
    left: f64,
    top: f64,
    /// The first and the last time (s) or place (m) of all panels.
    first: f64,
    last: f64,
    /// The lowest and the highest value, round ones.
    low: f64,
    high: f64,
    value_step: f64,
    /// The unit that times are written in, and how much of theirs it is.
    unit: &'static str,
    per_unit: f64,
}

impl Axes {
    fn of(panel: &GaugePanel, (left, top): (f64, f64), (first, last): (f64, f64)) -> Axes {
        let least = points(panel).map(|point| point.1).fold(f64::INFINITY, f64::min);
        let greatest = points(panel).map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
        let (least, greatest) = if least <= greatest { (least, greatest) } else { (0.0, 1.0) };
        let value_step = round_step(((greatest - least) / 4.0).max(1e-6));
        let (low, high) = ((least / value_step).floor() * value_step, (greatest / value_step).ceil() * value_step);
        let high = if high > low { high } else { low + value_step };
        // Times in hours for floods, in seconds for the laboratory.
        let (unit, per_unit) = match (panel.axis, last) {
            (PanelAxis::Place, _) => ("place (m)", 1.0),
            (PanelAxis::Time, last) if last >= 7200.0 => ("time (h)", 3600.0),
            (PanelAxis::Time, last) if last >= 600.0 => ("time (min)", 60.0),
            (PanelAxis::Time, _) => ("time (s)", 1.0),
        };
        Axes { left, top, first, last, low, high, value_step, unit, per_unit }
    }

    fn x(&self, time: f64) -> f64 {
        self.left + (time - self.first) / (self.last - self.first).max(1e-9) * SIZE.0
    }

    fn y(&self, value: f64) -> f64 {
        self.top + SIZE.1 - (value - self.low) / (self.high - self.low) * SIZE.1
    }

    /// Lines and numbers at round values and times.
    fn draw(&self, drawing: &mut Drawing) {
        let Axes { left, top, first, last, low, high, value_step, per_unit, .. } = *self;
        let (width, height) = SIZE;
        let label = Style::PLAIN.size(10.0);
        for k in 0..=((high - low) / value_step).round() as usize {
            let value = low + k as f64 * value_step;
            drawing.line((left, self.y(value)), (left + width, self.y(value)), "#ddd", 0.8);
            drawing.text(left - 6.0, self.y(value) + 3.5, label.anchor("end"), &number(value, value_step));
        }
        let time_step = round_step(((last - first) / per_unit / 6.0).max(1e-6));
        let marks = (last / per_unit / time_step + 1e-9).floor() - (first / per_unit / time_step - 1e-9).ceil();
        for k in 0..=marks.max(0.0) as usize {
            let time = ((first / per_unit / time_step - 1e-9).ceil() + k as f64) * time_step;
            let place = self.x(time * per_unit);
            drawing.line((place, top), (place, top + height), "#eee", 0.8);
            drawing.text(place, top + height + 14.0, label.anchor("middle"), &number(time, time_step));
        }
    }

    /// The points of a line that have a value, as SVG writes them.
    fn path(&self, points: &[(f64, f64)]) -> String {
        let sound = points.iter().filter(|point| point.1.is_finite());
        sound.map(|(time, value)| format!("{:.1},{:.1}", self.x(*time), self.y(*value))).collect::<Vec<_>>().join(" ")
    }
}

fn draw(drawing: &mut Drawing, panel: &GaugePanel, axes: &Axes, unit_label: &str) {
    let (left, top, (width, height)) = (axes.left, axes.top, SIZE);
    let label = Style::PLAIN.size(10.0);
    axes.draw(drawing);
    drawing.rectangle((left, top), (width, height), "none", "#333");
    drawing.text(left, top - 8.0, Style::PLAIN.bold(), &panel.title);
    drawing.text(left + width / 2.0, top + height + 29.0, label.anchor("middle"), axes.unit);
    // Panels over places each have a quantity and a unit of their own in their title.
    if panel.axis == PanelAxis::Time {
        drawing.turned_text(left - 48.0, top + height / 2.0, -90.0, label.anchor("middle"), unit_label);
    }
    if panel.measured.len() > MARKS {
        let path = axes.path(&panel.measured);
        drawing.raw(format_args!(r#"<polyline points="{path}" fill="none" stroke="black" stroke-width="1.6"/>"#));
    } else {
        for (time, value) in &panel.measured {
            drawing.raw(format_args!(
                r#"<circle cx="{:.1}" cy="{:.1}" r="3.5" fill="black"/>"#,
                axes.x(*time),
                axes.y(*value)
            ));
        }
    }
    for (line, colour) in panel.computed.iter().zip(COLOURS.iter().cycle()) {
        let path = axes.path(&line.points);
        drawing.raw(format_args!(r#"<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.3"/>"#));
    }
}

fn legend(drawing: &mut Drawing, panels: &[GaugePanel], (mut x, y): (f64, f64)) {
    let has_measured = panels.iter().any(|panel| !panel.measured.is_empty());
    let runs = panels.first().map_or(&[][..], |panel| &panel.computed[..]);
    let names = has_measured.then_some(("measured or published", "black")).into_iter();
    let names = names.chain(runs.iter().map(|line| line.name.as_str()).zip(COLOURS.iter().copied().cycle()));
    for (name, colour) in names {
        drawing.line((x, y - 4.0), (x + 22.0, y - 4.0), colour, 2.2);
        drawing.text(x + 28.0, y, Style::PLAIN, name);
        x += 52.0 + text_width(name, 11.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(title: &str, axis: PanelAxis, measured: Vec<(f64, f64)>, computed: Vec<GaugeLine>) -> GaugePanel {
        GaugePanel { title: title.to_string(), axis, measured, computed }
    }

    #[test]
    fn places_begin_where_the_line_begins() {
        let line = GaugeLine { name: "1 m".to_string(), points: vec![(120.0, 0.0), (280.0, 4.0)] };
        let drawn = comparison("Levels", "level (m)", &[panel("2 s", PanelAxis::Place, Vec::new(), vec![line])]);
        assert!(drawn.contains(r#"points="70.0,244.0 470.0,74.0""#), "{drawn}");
        assert!(
            drawn.contains("place (m)")
                && drawn.contains(">200<")
                && !drawn.contains("time")
                && !drawn.contains("level (m)"),
            "{drawn}"
        );
    }

    #[test]
    fn lines_run_through_their_panels() {
        let line = GaugeLine { name: "5 cm".to_string(), points: vec![(0.0, 0.0), (30.0, 0.4)] };
        let many = (0..20).map(|k| (f64::from(k), 0.2)).collect();
        let panels = [
            panel("G1 & G2", PanelAxis::Time, vec![(15.0, 0.2)], vec![line.clone()]),
            panel("G3", PanelAxis::Time, many, vec![line]),
        ];
        let drawn = comparison("Depths", "depth (m)", &panels);
        assert!(drawn.contains(r#"points="70.0,244.0 470.0,74.0""#), "{drawn}");
        assert!(drawn.contains(r#"<circle cx="270.0" cy="159.0""#) && drawn.contains("G1 &amp; G2"));
        assert_eq!(drawn.matches("measured or published").count(), 1);
        assert_eq!(drawn.matches("<polyline").count(), 3);
    }
}
