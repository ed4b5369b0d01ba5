//! The cross-section of a channel: its rows, and the strips and the wetted perimeter that they make.

use crate::boundary::Strip;
use crate::scenario::ChannelWalls;

/// Strips between the lowest and the highest row of a table of sections, at least.
const STRIPS: usize = 16;

/// A row of a cross-section: the width (m) at an elevation (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub elevation: f64,
    pub width: f64,
}

/// A cross-section of a table: its distance from the far end (m), and its rows from the bed upwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    pub distance: f64,
    pub rows: Vec<Row>,
}

/// Elevation and width of each row at a distance from the far end (m).
pub fn rows_at(sections: &[Table], distance: f64) -> Vec<Row> {
    let upper = sections.partition_point(|table| table.distance <= distance).clamp(1, sections.len() - 1);
    let (low, high) = (&sections[upper - 1], &sections[upper]);
    let share = ((distance - low.distance) / (high.distance - low.distance)).clamp(0.0, 1.0);
    let between = |(a, b): (&Row, &Row)| Row {
        elevation: a.elevation + share * (b.elevation - a.elevation),
        width: a.width + share * (b.width - a.width),
    };
    low.rows.iter().zip(&high.rows).map(between).collect()
}

/// Level of the last row of a section (m); none where its only row is the bed.
pub fn bank(rows: &[Row]) -> Option<f64> {
    rows[1..].last().map(|row| row.elevation)
}

/// Strips between each two of so many rows of a section.
pub fn pieces(rows: usize) -> usize {
    if rows > 1 { STRIPS.div_ceil(rows - 1) } else { 0 }
}

/// The strips of a section: one at its bed, and between each two rows equal pieces of what the width grows, at the heights at which
/// the area is right at every row.
pub fn strips(rows: &[Row]) -> Vec<Strip> {
    let pieces = pieces(rows.len());
    let mut strips = vec![Strip { width: rows[0].width, bed: rows[0].elevation }];
    for pair in rows.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        let share = |k: usize| (k as f64 + 0.5) / pieces as f64;
        let width = (high.width - low.width) / pieces as f64;
        strips.extend(
            (0..pieces).map(|k| Strip { width, bed: low.elevation + share(k) * (high.elevation - low.elevation) }),
        );
    }
    strips
}

/// Depth and wetted perimeter at each row, and a metre above the last one.
pub fn perimeter(rows: &[Row], walls: ChannelWalls) -> Vec<(f64, f64)> {
    let mut wetted = rows[0].width;
    let mut found = vec![(0.0, wetted)];
    for pair in rows.windows(2) {
        let (rise, growth) = (pair[1].elevation - pair[0].elevation, pair[1].width - pair[0].width);
        wetted += match walls {
            ChannelWalls::Rough => 2.0 * rise.hypot(0.5 * growth),
            ChannelWalls::Smooth => growth,
        };
        found.push((pair[1].elevation - rows[0].elevation, wetted));
    }
    let (top, last) = found[found.len() - 1];
    let above = match walls {
        ChannelWalls::Rough => 2.0,
        ChannelWalls::Smooth => 0.0,
    };
    found.push((top + 1.0, last + above));
    found
}

#[cfg(test)]
mod tests;
