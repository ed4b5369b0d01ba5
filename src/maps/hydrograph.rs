//! Water depth over time at the gauges, as a line chart.

use super::svg::{Drawing, Style, number, round_step, text_width};

/// One line of the chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Time (s) and value, times ascending.
    pub points: Vec<(f64, f64)>,
}

/// Colours that remain distinct for colour-blind readers, after `Okabe2008`; with more lines they begin again, dashed.
const COLOURS: [&str; 8] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8a8a00"];

/// The chart as an SVG document. `unit_label` stands at the upright axis, such as `depth (m)`.
pub fn hydrograph(title: &str, unit_label: &str, series: &[Series]) -> String {
    let (left, top, width, height) = (74.0, 56.0, 820.0, 330.0);
    let all = || series.iter().flat_map(|line| &line.points);
    let last = all().map(|point| point.0).fold(0.0, f64::max);
    let greatest = all().map(|point| point.1).filter(|value| value.is_finite()).fold(0.0, f64::max);
    // Times in minutes for floods, in seconds for the laboratory.
    let (unit, per_unit) = if last >= 600.0 { ("min", 60.0) } else { ("s", 1.0) };
    let time_step = round_step((last / per_unit / 8.0).max(1e-6));
    let value_step = round_step((greatest / 6.0).max(1e-6));
    let value_end = (greatest / value_step).ceil().max(1.0) * value_step;
    let time_end = (last / per_unit).max(time_step);
    let x = |time: f64| left + time / per_unit / time_end * width;
    let y = |value: f64| top + height - value / value_end * height;

    let mut drawing = Drawing::default();
    drawing.text(left, 32.0, Style::PLAIN.size(16.0).bold(), title);
    let label = Style::PLAIN.size(10.5);
    for k in 0..=(value_end / value_step).round() as usize {
        let value = k as f64 * value_step;
        drawing.line((left, y(value)), (left + width, y(value)), "#ddd", 0.8);
        drawing.text(left - 8.0, y(value) + 4.0, label.anchor("end"), &number(value, value_step));
    }
    for k in 0..=(time_end / time_step + 1e-9).floor() as usize {
        let time = k as f64 * time_step;
        let place = x(time * per_unit);
        drawing.line((place, top), (place, top + height), "#eee", 0.8);
        drawing.text(place, top + height + 17.0, label.anchor("middle"), &number(time, time_step));
    }
    drawing.rectangle((left, top), (width, height), "none", "#333");
    drawing.text(left + width / 2.0, top + height + 36.0, Style::PLAIN.anchor("middle"), &format!("time ({unit})"));
    drawing.turned_text(24.0, top + height / 2.0, -90.0, Style::PLAIN.anchor("middle"), unit_label);

    let (mut legend_x, mut legend_y) = (left, top + height + 60.0);
    for (k, line) in series.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let dash = if k < COLOURS.len() { "" } else { r#" stroke-dasharray="6 3""# };
        let path: Vec<String> = line
            .points
            .iter()
            .filter(|point| point.1.is_finite())
            .map(|(time, value)| format!("{:.1},{:.1}", x(*time), y(value.max(0.0))))
            .collect();
        drawing.raw(format_args!(
            r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="1.8"{dash}/>"#,
            path.join(" ")
        ));
        let entry = 40.0 + text_width(&line.name, 11.0);
        if legend_x + entry > left + width {
            (legend_x, legend_y) = (left, legend_y + 18.0);
        }
        drawing.raw(format_args!(
            r#"<line x1="{legend_x:.1}" y1="{0:.1}" x2="{1:.1}" y2="{0:.1}" stroke="{colour}" stroke-width="2.4"{dash}/>"#,
            legend_y - 4.0,
            legend_x + 20.0
        ));
        drawing.text(legend_x + 26.0, legend_y, Style::PLAIN, &line.name);
        legend_x += entry;
    }
    drawing.finish(left + width + 26.0, legend_y + 22.0, title)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_run_from_corner_to_corner() {
        let series = [Series { name: "A & B".to_string(), points: vec![(0.0, 0.0), (1200.0, 6.0)] }];
        let chart = hydrograph("Depth", "depth (m)", &series);
        assert!(chart.contains(r#"points="74.0,386.0 894.0,56.0""#), "{chart}");
        assert!(chart.contains("time (min)") && chart.contains("A &amp; B"));
    }
}
