//! Speed against accuracy: errors over processor time on logarithmic axes, a line for each method, Pareto front marked.
//!
//! Legible without colour: each line has its own marker and dash. A point is on the front when no other is both faster and more exact.

use super::svg::{Drawing, Style, text_width};

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartPoint {
    /// Processor time (s).
    pub cost: f64,
    /// Error, in the unit of the axis; above 0.
    pub error: f64,
    /// What stands at the point: its resolution.
    pub label: String,
}

/// The runs of one method, at several resolutions.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartLine {
    /// Name in the legend.
    pub name: String,
    /// The runs.
    pub points: Vec<ChartPoint>,
}

/// Runs of other codes, measured elsewhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartPeers {
    /// Where they come from.
    pub source: String,
    /// The runs, labelled with code and resolution.
    pub points: Vec<ChartPoint>,
}

/// The shortest time (s) that means anything.
const LEAST_COST: f64 = 1e-4;
/// Colours that remain distinct for colour-blind readers, after `Okabe2008`.
const COLOURS: [&str; 8] = ["#0072b2", "#d55e00", "#009e73", "#000000", "#cc79a7", "#8a6d00", "#56b4e9", "#6a3d9a"];
const DASHES: [&str; 5] = ["", "7 3", "2 3", "9 3 2 3", "12 4"];
/// Shapes of the markers as corners on the unit circle (degrees); the first one is the circle itself.
const SHAPES: [&[f64]; 7] = [
    &[],
    &[45.0, 135.0, 225.0, 315.0],
    &[-90.0, 30.0, 150.0],
    &[0.0, 90.0, 180.0, 270.0],
    &[90.0, 210.0, 330.0],
    &[-90.0, -18.0, 54.0, 126.0, 198.0],
    &[0.0, 60.0, 120.0, 180.0, 240.0, 300.0],
];
const MARKER: f64 = 5.5;
/// Colour of what was measured elsewhere.
const ELSEWHERE: &str = "#777777";
/// The field of the drawing: left, top, width, height (pixels).
const FIELD: (f64, f64, f64, f64) = (86.0, 84.0, 600.0, 430.0);

/// A logarithmic axis from one decade or half decade to another.
struct Axis {
    low: f64,
    high: f64,
}

impl Axis {
    /// An axis that holds all values with some room.
    fn around(values: impl Iterator<Item = f64> + Clone) -> Axis {
        let low = values.clone().fold(f64::INFINITY, f64::min).log10() - 0.12;
        let high = values.fold(f64::MIN_POSITIVE, f64::max).log10() + 0.12;
        // At least one decade, so that a small difference does not look large.
        let room = (0.5 * (1.0 - (high - low))).max(0.0);
        Axis { low: low - room, high: high + room }
    }

    /// Place of a value, from 0 to 1.
    fn share(&self, value: f64) -> f64 {
        (value.log10() - self.low) / (self.high - self.low)
    }

    /// Values to mark: powers of ten, with 2 and 5 between them where the axis is short; and whether each has a number.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let is_short = self.high - self.low < 2.6;
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = decades.flat_map(|decade| (1..10).map(move |digit| (digit, f64::from(digit) * 10f64.powi(decade))));
        all.filter(|(_, value)| (0.0..=1.0).contains(&self.share(*value)))
            .map(|(digit, value)| (value, digit == 1 || (is_short && [2, 5].contains(&digit))))
            .collect()
    }
}

/// The figure as an SVG document. `about` stands under the title, `error_label` at the upright axis; `peers` take no part in the front.
pub fn speed_against_accuracy(
    title: &str,
    about: &str,
    error_label: &str,
    lines: &[ChartLine],
    peers: &ChartPeers,
) -> String {
    let points = || lines.iter().flat_map(|line| &line.points);
    let all = || points().chain(&peers.points);
    let cost_axis = Axis::around(all().map(|point| point.cost.max(LEAST_COST)));
    let error_axis = Axis::around(all().map(|point| point.error));
    let (left, top, width, height) = FIELD;
    let place = |point: &ChartPoint| {
        let x = left + cost_axis.share(point.cost.max(LEAST_COST)) * width;
        (x, top + (1.0 - error_axis.share(point.error)) * height)
    };
    let mut drawing = Drawing::default();
    let widest = lines.iter().map(|line| text_width(&line.name, 11.0)).fold(0.0, f64::max);
    let total_width = left + width + 64.0 + widest.max(110.0);
    drawing.text(left, 26.0, Style::PLAIN.size(16.0).bold(), title);
    for (k, line) in wrapped(about, total_width - left - 20.0).into_iter().enumerate() {
        drawing.text(left, 45.0 + 14.0 * k as f64, Style::PLAIN.fill("#444"), &line);
    }
    draw_axes(&mut drawing, &cost_axis, &error_axis, error_label);
    let front = front(points());
    let path = front.iter().map(|point| place(point)).map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>();
    drawing.raw(format_args!(
        r##"<polyline points="{}" fill="none" stroke="#c8c8c8" stroke-width="7" stroke-linejoin="round" stroke-linecap="round"/>"##,
        path.join(" ")
    ));
    for point in &peers.points {
        cross(&mut drawing, place(point));
    }
    let mut taken: Vec<(f64, f64, f64, f64)> =
        all().map(place).map(|(x, y)| (x - MARKER, y - MARKER, x + MARKER, y + MARKER)).collect();
    for (k, line) in lines.iter().enumerate() {
        draw_line(&mut drawing, k, line.points.iter().map(place).collect());
    }
    for line in lines {
        for point in &line.points {
            let centre = place(point);
            if front.iter().any(|other| std::ptr::eq(*other, point)) {
                ring(&mut drawing, centre);
            }
            draw_label(&mut drawing, centre, &point.label, Style::PLAIN.fill, &mut taken);
        }
    }
    for point in &peers.points {
        draw_label(&mut drawing, place(point), &point.label, ELSEWHERE, &mut taken);
    }
    draw_legend(&mut drawing, lines, peers);
    drawing.finish(total_width, top + height + 64.0, title)
}

/// The points that no other one beats in both time and error, by time.
fn front<'a>(points: impl Iterator<Item = &'a ChartPoint>) -> Vec<&'a ChartPoint> {
    let mut sorted: Vec<&ChartPoint> = points.collect();
    sorted.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.error.total_cmp(&b.error)));
    let mut least = f64::INFINITY;
    sorted.retain(|point| {
        let is_better = point.error < least;
        least = least.min(point.error);
        is_better
    });
    sorted
}

fn draw_axes(drawing: &mut Drawing, cost: &Axis, error: &Axis, error_label: &str) {
    let (left, top, width, height) = FIELD;
    let label = Style::PLAIN.size(11.0);
    for (value, has_number) in cost.ticks() {
        let x = left + cost.share(value) * width;
        drawing.line((x, top), (x, top + height), if has_number { "#d0d0d0" } else { "#eeeeee" }, 0.8);
        if has_number {
            drawing.text(x, top + height + 17.0, label.anchor("middle"), &plain(value));
        }
    }
    for (value, has_number) in error.ticks() {
        let y = top + (1.0 - error.share(value)) * height;
        drawing.line((left, y), (left + width, y), if has_number { "#d0d0d0" } else { "#eeeeee" }, 0.8);
        if has_number {
            drawing.text(left - 8.0, y + 4.0, label.anchor("end"), &plain(value));
        }
    }
    drawing.rectangle((left, top), (width, height), "none", "#333");
    let title = Style::PLAIN.size(12.0).anchor("middle");
    drawing.text(left + width / 2.0, top + height + 40.0, title, "processor time (s)");
    drawing.turned_text(22.0, top + height / 2.0, -90.0, title, error_label);
}

/// A power of ten in digits as long as that is short.
fn plain(value: f64) -> String {
    if (1e-3..1e5).contains(&value) {
        let decimals = (-value.log10().floor()).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.0e}").replace('-', "−")
    }
}

fn draw_line(drawing: &mut Drawing, k: usize, places: Vec<(f64, f64)>) {
    let path: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let (colour, dash) = (COLOURS[k % COLOURS.len()], DASHES[k % DASHES.len()]);
    drawing.raw(format_args!(
        r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="1.6" stroke-dasharray="{dash}"/>"#,
        path.join(" ")
    ));
    for centre in places {
        marker(drawing, k, centre);
    }
}

fn marker(drawing: &mut Drawing, k: usize, (x, y): (f64, f64)) {
    let colour = COLOURS[k % COLOURS.len()];
    // With more lines than shapes the shapes come again, open.
    let fill = if k < SHAPES.len() { colour } else { "#ffffff" };
    let corners = SHAPES[k % SHAPES.len()];
    if corners.is_empty() {
        drawing.raw(format_args!(
            r#"<circle cx="{x:.1}" cy="{y:.1}" r="{:.1}" fill="{fill}" stroke="{colour}" stroke-width="1.4"/>"#,
            MARKER - 0.7
        ));
        return;
    }
    let corner = |angle: &f64| {
        let angle = angle.to_radians();
        format!("{:.1},{:.1}", x + MARKER * angle.cos(), y + MARKER * angle.sin())
    };
    let path: Vec<String> = corners.iter().map(corner).collect();
    drawing.raw(format_args!(
        r#"<polygon points="{}" fill="{fill}" stroke="{colour}" stroke-width="1.4"/>"#,
        path.join(" ")
    ));
}

/// The marker of what was measured elsewhere.
fn cross(drawing: &mut Drawing, (x, y): (f64, f64)) {
    let r = MARKER - 1.5;
    for slope in [1.0, -1.0] {
        drawing.line((x - r, y - slope * r), (x + r, y + slope * r), ELSEWHERE, 1.6);
    }
}

fn ring(drawing: &mut Drawing, (x, y): (f64, f64)) {
    drawing.raw(format_args!(
        r##"<circle cx="{x:.1}" cy="{y:.1}" r="{:.1}" fill="none" stroke="#000" stroke-width="1.2"/>"##,
        MARKER + 4.0
    ));
}

/// Sets a label beside its point, where it is in nobody's way if there is such a place.
fn draw_label(
    drawing: &mut Drawing,
    (x, y): (f64, f64),
    label: &str,
    colour: &'static str,
    taken: &mut Vec<(f64, f64, f64, f64)>,
) {
    const SIZE: f64 = 10.0;
    let width = text_width(label, SIZE);
    let corners = [
        (11.0, -6.0),
        (11.0, 14.0),
        (-11.0 - width, -6.0),
        (-11.0 - width, 14.0),
        (-0.5 * width, -13.0),
        (-0.5 * width, 21.0),
    ];
    // Where all six are taken, the same a line further off.
    let farther = corners.map(|(dx, dy)| (dx, dy + if dy < 0.0 { -13.0 } else { 13.0 }));
    let boxes: Vec<_> = corners
        .into_iter()
        .chain(farther)
        .map(|(dx, dy)| (x + dx, y + dy - SIZE, x + dx + width, y + dy + 2.0))
        .collect();
    let overlap = |a: &(f64, f64, f64, f64)| {
        let common =
            |b: &(f64, f64, f64, f64)| (a.2.min(b.2) - a.0.max(b.0)).max(0.0) * (a.3.min(b.3) - a.1.max(b.1)).max(0.0);
        let beyond = (FIELD.0 - a.0).max(a.2 - FIELD.0 - FIELD.2).max(0.0);
        taken.iter().map(common).sum::<f64>() + 100.0 * beyond
    };
    let best = boxes.iter().min_by(|a, b| overlap(a).total_cmp(&overlap(b))).copied().unwrap_or(boxes[0]);
    drawing.text(best.0, best.3 - 2.0, Style::PLAIN.size(SIZE).fill(colour).halo(), label);
    taken.push(best);
}

fn draw_legend(drawing: &mut Drawing, lines: &[ChartLine], peers: &ChartPeers) {
    let (x, mut y) = (FIELD.0 + FIELD.2 + 18.0, FIELD.1 + 10.0);
    for (k, line) in lines.iter().enumerate() {
        draw_line(drawing, k, vec![(x, y), (x + 28.0, y)]);
        drawing.text(x + 38.0, y + 4.0, Style::PLAIN, &line.name);
        y += 20.0;
    }
    y += 10.0;
    drawing.raw(format_args!(
        r##"<line x1="{x:.1}" y1="{y:.1}" x2="{:.1}" y2="{y:.1}" stroke="#c8c8c8" stroke-width="7"/>"##,
        x + 28.0
    ));
    ring(drawing, (x + 14.0, y));
    drawing.text(x + 38.0, y + 4.0, Style::PLAIN, "Pareto front");
    if !peers.points.is_empty() {
        y += 24.0;
        cross(drawing, (x + 14.0, y));
        drawing.text(x + 38.0, y + 4.0, Style::PLAIN, "measured elsewhere:");
        drawing.text(x + 38.0, y + 18.0, Style::PLAIN, &format!("see {}", peers.source));
    }
}

/// A text in lines of at most `width` (pixels), two at most.
fn wrapped(text: &str, width: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let is_full = text_width(&format!("{} {word}", lines[lines.len() - 1]), 9.5) > width;
        if is_full && lines.len() < 2 {
            lines.push(String::new());
        }
        let last = lines.len() - 1;
        if !lines[last].is_empty() {
            lines[last].push(' ');
        }
        lines[last].push_str(word);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(cost: f64, error: f64) -> ChartPoint {
        ChartPoint { cost, error, label: "10 m".to_owned() }
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [point(1.0, 0.1), point(0.5, 0.2), point(2.0, 0.15), point(4.0, 0.05), point(0.5, 0.3)];
        let costs: Vec<f64> = front(points.iter()).iter().map(|p| p.cost).collect();
        assert_eq!(costs, [0.5, 1.0, 4.0]);
    }

    #[test]
    fn axes_are_logarithmic_and_hold_all_values() {
        let axis = Axis::around([0.02, 3.0].into_iter());
        assert!(axis.share(0.02) > 0.0 && axis.share(3.0) < 1.0);
        assert!((axis.share(1.0) - axis.share(0.1) - (axis.share(0.3) - axis.share(0.03))).abs() < 1e-12);
        let narrow = Axis::around([1.0, 1.1].into_iter());
        assert!(narrow.high - narrow.low > 0.99);
        assert_eq!(plain(0.02), "0.02");
        assert_eq!(plain(1e-5), "1e−5");
    }

    #[test]
    fn a_figure_has_lines_markers_labels_and_legend() {
        let lines = [
            ChartLine { name: "resting & quick".to_owned(), points: vec![point(0.1, 1e-2), point(1.0, 5e-3)] },
            ChartLine { name: "moving".to_owned(), points: vec![point(0.2, 1e-1)] },
        ];
        let peers = ChartPeers::default();
        let svg = speed_against_accuracy("case: depth", "About it.", "error (m)", &lines, &peers);
        assert!(!svg.contains("measured elsewhere"));
        assert!(svg.contains("resting &amp; quick") && svg.contains("Pareto front") && svg.contains("10 m"));
        // Two rings on the front and one in the legend.
        assert_eq!(svg.matches(r##"fill="none" stroke="#000" stroke-width="1.2"/>"##).count(), 3);
    }

    #[test]
    fn what_was_measured_elsewhere_is_shown_beside_the_front() {
        let lines = [ChartLine { name: "ours".to_owned(), points: vec![point(0.1, 1e-2)] }];
        let better = ChartPoint { cost: 0.01, error: 1e-5, label: "other 3 m".to_owned() };
        let peers = ChartPeers { source: "peers.csv".to_owned(), points: vec![better] };
        let svg = speed_against_accuracy("case: depth", "About it.", "error (m)", &lines, &peers);
        assert!(svg.contains("other 3 m") && svg.contains("measured elsewhere:") && svg.contains("see peers.csv"));
        // Ours keeps its ring on the front, and the axis reaches down to the other one.
        assert_eq!(svg.matches(r##"fill="none" stroke="#000" stroke-width="1.2"/>"##).count(), 2);
        assert!(svg.contains("1e−5"));
    }
}
