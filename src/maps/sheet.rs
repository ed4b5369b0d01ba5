//! The map sheet: one or several maps of the same window, with frame, coordinates, scale bar, north arrow and legend.

use super::svg::{Drawing, Style, number, round_step, text_width, trimmed};
use super::{Classes, MapGrid, Window, picture};

/// A named place on a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// What is written beside it.
    pub name: String,
    /// Map coordinates (m).
    pub place: (f64, f64),
}

/// One map of a sheet.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// What stands above it.
    pub caption: String,
    /// What is shown, `[rows, columns]`, row 0 in the north; NaN and values below the first class are not drawn.
    pub values: &'a [f64],
    /// Its classes.
    pub classes: &'a Classes,
    /// A second layer below it, such as the water before the failure.
    pub under: Option<(&'a [f64], &'a Classes)>,
    /// Whether it takes the full width where other panels stand in pairs.
    pub wide: bool,
}

/// A map sheet.
#[derive(Clone, Debug)]
pub struct Sheet<'a> {
    /// Heading.
    pub title: &'a str,
    /// Second line: what is shown.
    pub subtitle: &'a str,
    /// Where the cells lie.
    pub grid: &'a MapGrid,
    /// Bed elevation (m), `[rows, columns]`, row 0 in the north, NaN outside the terrain.
    pub bed: &'a [f64],
    /// The maps, all of the same window: what any of them shows, with a margin.
    pub panels: Vec<Panel<'a>>,
    /// Named places.
    pub marks: &'a [Mark],
    /// Name of the coordinate reference system.
    pub crs: &'a str,
    /// Small print at the foot: methods, version.
    pub note: &'a str,
}

const MARGIN: f64 = 26.0;
const TICK_SPACE: f64 = 20.0;
const CAPTION: f64 = 24.0;
/// A sheet of maps that are wider than high, and one of maps that are higher than wide.
const LANDSCAPE: Page = Page { width: 1180.0, tallest: [860.0, 620.0] };
const PORTRAIT: Page = Page { width: 840.0, tallest: [1240.0, 640.0] };

/// The paper of a sheet.
struct Page {
    /// Its width.
    width: f64,
    /// How high a map may be that takes the full width, and one of a pair.
    tallest: [f64; 2],
}

/// The sheet as an SVG document (pixels at 96 to the inch), complete in itself.
pub fn map_sheet(sheet: &Sheet) -> String {
    let window = window(sheet);
    let aspect = window.rows as f64 / window.columns as f64;
    let page = if aspect > 1.0 { PORTRAIT } else { LANDSCAPE };
    let full = page.width - 2.0 * MARGIN - TICK_SPACE;
    let half = (full - MARGIN - TICK_SPACE) / 2.0;
    let mut drawing = Drawing::default();
    // Bold letters are a tenth wider.
    let title_size = 21.0 * ((page.width - 2.0 * MARGIN) / (1.1 * text_width(sheet.title, 21.0))).min(1.0);
    drawing.text(MARGIN, 40.0, Style::PLAIN.size(title_size).bold(), sheet.title);
    drawing.text(MARGIN, 61.0, Style::PLAIN.size(13.0).fill("#555"), sheet.subtitle);
    let terrain = picture::terrain(sheet.grid, sheet.bed, window);
    // The one picture of the terrain is drawn by every map that refers to it.
    let (w, h) = (window.columns, window.rows);
    // Sheets stand side by side in one page, so the name must tell them apart.
    let name = format!("terrain-{:x}", checksum(&[sheet.title, sheet.subtitle]));
    drawing.raw(format_args!(
        r#"<defs><image id="{name}" width="{w}" height="{h}" preserveAspectRatio="none" xlink:href="{terrain}"/></defs>"#
    ));
    // In rows, each panel beside the one before as long as there is room.
    let (mut left, mut top, mut row_height) = (MARGIN, 78.0, 0.0_f64);
    for panel in &sheet.panels {
        let is_wide = panel.wide || sheet.panels.len() == 1;
        let width = if is_wide { full } else { half }.min(page.tallest[usize::from(!is_wide)] / aspect);
        if left > MARGIN && left + TICK_SPACE + width > page.width - MARGIN + 1.0 {
            (left, top, row_height) = (MARGIN, top + row_height, 0.0);
        }
        let caption = if panel.caption.is_empty() { 6.0 } else { CAPTION };
        let (left_side, height) = (left + TICK_SPACE, width * aspect);
        let frame = Frame { left: left_side, top: top + caption, width, height, window, grid: sheet.grid };
        draw_panel(&mut drawing, sheet, panel, &frame, &name);
        left += TICK_SPACE + width + MARGIN;
        row_height = row_height.max(caption + height + TICK_SPACE + 10.0);
    }
    top += row_height;
    let mut bottom = legend(&mut drawing, sheet, page.width, top + 6.0);
    let small = Style::PLAIN.size(10.0).fill("#666");
    let place = format!("{} · grid north is up · cells of {} m", sheet.crs, trimmed(sheet.grid.cell));
    drawing.text(MARGIN, bottom + 12.0, small, &place);
    if text_width(&place, 10.0) + text_width(sheet.note, 10.0) > page.width - 3.0 * MARGIN {
        bottom += 14.0;
    }
    drawing.text(page.width - MARGIN, bottom + 12.0, small.anchor("end"), sheet.note);
    drawing.finish(page.width, bottom + 30.0, sheet.title)
}

/// The part of the grid that any panel shows, the marks, and a margin.
fn window(sheet: &Sheet) -> Window {
    let grid = sheet.grid;
    let (mut west, mut east, mut north, mut south) = (grid.columns, 0, grid.rows, 0);
    let mut include = |column: usize, row: usize| {
        west = west.min(column);
        east = east.max(column);
        north = north.min(row);
        south = south.max(row);
    };
    for panel in &sheet.panels {
        for index in (0..panel.values.len()).filter(|&index| panel.classes.class_of(panel.values[index]).is_some()) {
            include(index % grid.columns, index / grid.columns);
        }
    }
    for mark in sheet.marks {
        let (column, row) = ((mark.place.0 - grid.west) / grid.cell, (grid.north - mark.place.1) / grid.cell);
        if column >= 0.0 && row >= 0.0 && column < grid.columns as f64 && row < grid.rows as f64 {
            include(column as usize, row as usize);
        }
    }
    if west > east {
        return Window { first_column: 0, first_row: 0, columns: grid.columns, rows: grid.rows };
    }
    let (width, height) = (east - west + 1, south - north + 1);
    let margin = (width.max(height) / 16).max(3);
    // A long valley is shown with the hills on either side of it.
    let grow = |first: usize, count: usize, least: usize, available: usize| {
        let wanted = (count + 2 * margin).max(least).min(available);
        let start = (first + count / 2).saturating_sub(wanted / 2).min(available - wanted);
        (start, wanted)
    };
    let (first_column, columns) = grow(west, width, height * 5 / 8, grid.columns);
    let (first_row, rows) = grow(north, height, width * 4 / 9, grid.rows);
    Window { first_column, first_row, columns, rows }
}

/// Where a map stands on the sheet.
struct Frame<'a> {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    window: Window,
    grid: &'a MapGrid,
}

impl Frame<'_> {
    /// Pixels per metre.
    fn scale(&self) -> f64 {
        self.width / (self.window.columns as f64 * self.grid.cell)
    }

    fn west(&self) -> f64 {
        self.grid.west + self.window.first_column as f64 * self.grid.cell
    }

    fn north(&self) -> f64 {
        self.grid.north - self.window.first_row as f64 * self.grid.cell
    }

    fn x(&self, east: f64) -> f64 {
        self.left + (east - self.west()) * self.scale()
    }

    fn y(&self, north: f64) -> f64 {
        self.top + (self.north() - north) * self.scale()
    }
}

fn draw_panel(drawing: &mut Drawing, sheet: &Sheet, panel: &Panel, frame: &Frame, terrain: &str) {
    let (left, top, width, height) = (frame.left, frame.top, frame.width, frame.height);
    drawing.text(left, top - 8.0, Style::PLAIN.size(13.0).bold(), &panel.caption);
    let (scale_x, scale_y) = (width / frame.window.columns as f64, height / frame.window.rows as f64);
    drawing.raw(format_args!(
        r##"<use xlink:href="#{terrain}" transform="translate({left:.2} {top:.2}) scale({scale_x:.6} {scale_y:.6})"/>"##
    ));
    // Cells larger than a pixel are shown as the squares that they are.
    let rendering = if scale_x > 1.5 { "pixelated" } else { "auto" };
    let layers = panel.under.into_iter().chain([(panel.values, panel.classes)]);
    for (values, classes) in layers {
        let image = picture::layer(frame.grid, values, classes, frame.window);
        drawing.raw(format_args!(
            r#"<image x="{left:.2}" y="{top:.2}" width="{width:.2}" height="{height:.2}" preserveAspectRatio="none" style="image-rendering:{rendering}" xlink:href="{image}"/>"#
        ));
    }
    draw_coordinates(drawing, frame);
    drawing.rectangle((left, top), (width, height), "none", "#222");
    draw_marks(drawing, sheet.marks, frame);
    draw_scale_bar(drawing, panel, frame);
}

/// Crosses at round coordinates inside, their numbers outside the frame.
fn draw_coordinates(drawing: &mut Drawing, frame: &Frame) {
    let span = frame.width.min(frame.height).max(frame.width / 3.0) / frame.scale();
    let step = round_step(span / 3.5);
    let multiples = |from: f64, to: f64| {
        let first = (from / step).ceil() as i64;
        (first..=(to / step).floor() as i64).map(|k| k as f64 * step).collect::<Vec<_>>()
    };
    let (east, south) = (frame.west() + frame.width / frame.scale(), frame.north() - frame.height / frame.scale());
    let (columns, rows) = (multiples(frame.west(), east), multiples(south, frame.north()));
    let style = Style::PLAIN.size(9.5).fill("#444").anchor("middle");
    let (bottom, right) = (frame.top + frame.height, frame.left + frame.width);
    for x in &columns {
        let px = frame.x(*x);
        drawing.line((px, bottom), (px, bottom + 4.0), "#222", 1.0);
        let label = number(*x, step);
        // A number at the corner would run into the neighbouring map.
        let half = text_width(&label, 9.5) / 2.0;
        drawing.text(px.clamp(frame.left + half - 6.0, right - half + 6.0), bottom + 15.0, style, &label);
        for y in &rows {
            let py = frame.y(*y);
            drawing.line((px - 4.0, py), (px + 4.0, py), "#333", 0.6);
            drawing.line((px, py - 4.0), (px, py + 4.0), "#333", 0.6);
        }
    }
    for y in &rows {
        let py = frame.y(*y);
        drawing.line((frame.left - 4.0, py), (frame.left, py), "#222", 1.0);
        let label = number(*y, step);
        let half = text_width(&label, 9.5) / 2.0;
        let middle = py.clamp(frame.top + half - 6.0, bottom - half + 6.0);
        drawing.turned_text(frame.left - 8.0, middle, -90.0, style, &label);
    }
}

/// Triangles with names; each name takes the first of eight places where it covers no other name or mark.
fn draw_marks(drawing: &mut Drawing, marks: &[Mark], frame: &Frame) {
    let inside = |mark: &&Mark| {
        let (x, y) = (frame.x(mark.place.0) - frame.left, frame.y(mark.place.1) - frame.top);
        x >= 0.0 && y >= 0.0 && x <= frame.width && y <= frame.height
    };
    let places: Vec<(f64, f64, &str)> = marks
        .iter()
        .filter(inside)
        .map(|mark| (frame.x(mark.place.0), frame.y(mark.place.1), mark.name.as_str()))
        .collect();
    // Boxes (left, top, right, bottom) that are taken.
    let mut taken: Vec<[f64; 4]> = places.iter().map(|(x, y, _)| [x - 4.0, y - 5.0, x + 4.0, y + 4.0]).collect();
    for (own, (x, y, name)) in places.iter().enumerate() {
        let width = text_width(name, 10.0);
        let candidates = [
            (7.0, 3.5),
            (-7.0 - width, 3.5),
            (-width / 2.0, -8.0),
            (-width / 2.0, 15.0),
            (6.0, -6.0),
            (6.0, 13.0),
            (-6.0 - width, -6.0),
            (-6.0 - width, 13.0),
        ];
        let cover = |(dx, dy): &(f64, f64)| [x + dx, y + dy - 9.0, x + dx + width, y + dy + 2.0];
        let clashes = |place: &&(f64, f64)| {
            let [l, t, r, b] = cover(place);
            let outside =
                l < frame.left || r > frame.left + frame.width || t < frame.top || b > frame.top + frame.height;
            let hits = |(k, other): (usize, &[f64; 4])| {
                k != own && l < other[2] && r > other[0] && t < other[3] && b > other[1]
            };
            !outside && !taken.iter().enumerate().any(hits)
        };
        let place = candidates.iter().find(clashes).unwrap_or(&candidates[0]);
        taken.push(cover(place));
        drawing.raw(format_args!(
            r##"<path d="M{:.1} {:.1}l4.2 7.4h-8.4z" fill="#111" stroke="#fff" stroke-width="1"/>"##,
            x,
            y - 4.6
        ));
        drawing.text(x + place.0, y + place.1, Style::PLAIN.size(10.0).bold().halo(), name);
    }
}

/// Scale bar and north arrow in a box, in the corner where they hide the least of the flood.
fn draw_scale_bar(drawing: &mut Drawing, panel: &Panel, frame: &Frame) {
    let length = round_step(frame.width / frame.scale() / 9.0);
    let bar = length * frame.scale();
    let (box_width, box_height, gap) = (bar + 62.0, 40.0, 8.0);
    let corner = |k: usize| {
        let x = if k.is_multiple_of(2) { frame.left + frame.width - box_width - gap } else { frame.left + gap };
        let y = if k < 2 { frame.top + frame.height - box_height - gap } else { frame.top + gap };
        (x, y)
    };
    let hidden = |k: &usize| {
        let (x, y) = corner(*k);
        let cell = frame.grid.cell * frame.scale();
        let columns = ((x - frame.left) / cell) as usize..((x - frame.left + box_width) / cell) as usize;
        let rows = ((y - frame.top) / cell) as usize..((y - frame.top + box_height) / cell) as usize;
        let wet = |row: usize, column: usize| {
            let (row, column) = (row + frame.window.first_row, column + frame.window.first_column);
            let index = row * frame.grid.columns + column;
            panel.values.get(index).is_some_and(|value| panel.classes.class_of(*value).is_some())
        };
        rows.map(|row| columns.clone().filter(|&column| wet(row, column)).count()).sum::<usize>()
    };
    let (x, y) = corner((0..4).min_by_key(hidden).unwrap_or(0));
    drawing.raw(format_args!(
        r##"<rect x="{x:.1}" y="{y:.1}" width="{box_width:.1}" height="{box_height}" fill="#fff" fill-opacity="0.86" stroke="#999" stroke-width="0.5"/>"##
    ));
    let (bar_left, bar_top) = (x + 12.0, y + 11.0);
    for (k, fill) in ["#222", "#fff", "#222", "#fff"].into_iter().enumerate() {
        drawing.rectangle((bar_left + k as f64 * bar / 4.0, bar_top), (bar / 4.0, 5.0), fill, "#222");
    }
    let kilometres = length >= 1000.0;
    let unit = if kilometres { "km" } else { "m" };
    let shown = |metres: f64| trimmed(if kilometres { metres / 1000.0 } else { metres });
    let style = Style::PLAIN.size(9.5).anchor("middle");
    drawing.text(bar_left, y + 30.0, style, "0");
    drawing.text(bar_left + bar, y + 30.0, style, &format!("{} {unit}", shown(length)));
    let arrow = x + box_width - 16.0;
    drawing.raw(format_args!(
        r##"<path d="M{arrow:.1} {:.1}l5 16l-5 -3.6z" fill="#222"/><path d="M{arrow:.1} {:.1}l-5 16l5 -3.6z" fill="#fff" stroke="#222" stroke-width="0.7"/>"##,
        y + 5.0,
        y + 5.0
    ));
    drawing.text(arrow, y + 34.0, style.bold().size(10.0), "N");
}

/// The classes of all panels side by side, each set once. Returns where the legend ends (pixels).
fn legend(drawing: &mut Drawing, sheet: &Sheet, page_width: f64, top: f64) -> f64 {
    let mut sets: Vec<&Classes> = Vec::new();
    for classes in
        sheet.panels.iter().flat_map(|panel| [Some(panel.classes), panel.under.map(|under| under.1)]).flatten()
    {
        if !sets.contains(&classes) {
            sets.push(classes);
        }
    }
    let (mut x, mut y, mut bottom) = (MARGIN, top, top);
    for classes in sets {
        let count = classes.entries.len();
        let rows = if count > 8 { 5 } else { 4 };
        let widest = classes.entries.iter().map(|(.., label)| text_width(label, 11.0)).fold(0.0, f64::max);
        let column_width = widest + 42.0;
        let columns = count.div_ceil(rows);
        let width = (columns as f64 * column_width).max(text_width(&classes.title, 11.5) * 1.1 + 20.0);
        if x > MARGIN && x + width > page_width - MARGIN {
            (x, y) = (MARGIN, bottom + 10.0);
        }
        drawing.text(x, y + 12.0, Style::PLAIN.size(11.5).bold(), &classes.title);
        for (k, (_, colour, label)) in classes.entries.iter().enumerate() {
            let (left, line) = (x + (k / rows) as f64 * column_width, y + 22.0 + 17.0 * (k % rows) as f64);
            let [red, green, blue] = colour;
            drawing.rectangle((left, line), (20.0, 12.0), &format!("#{red:02x}{green:02x}{blue:02x}"), "#555");
            drawing.text(left + 27.0, line + 10.0, Style::PLAIN, label);
        }
        bottom = bottom.max(y + 22.0 + 17.0 * rows.min(count) as f64 + 6.0);
        x += width + 18.0;
    }
    bottom
}

/// A checksum after Fowler, Noll and Vo: the same text gives the same name on every machine.
fn checksum(texts: &[&str]) -> u64 {
    let bytes = texts.iter().flat_map(|text| text.bytes().chain([0]));
    bytes.fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests;
