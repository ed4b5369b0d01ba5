//! Rasters as PNG inside an SVG: the terrain with its relief, and the classed flood above it.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::colour::{Classes, Colour, ramp};
use super::{MapGrid, Window, hillshade};

/// Number of shades and of height tints: together they fill the 256 colours of an indexed picture.
const SHADES: usize = 32;
const TINTS: usize = 8;

/// Width or height (pixels) above which cells are left out.
const LARGEST: usize = 1800;

/// The terrain of a window as a `data:` address: height tints from valley green to summit grey, times the relief.
pub(super) fn terrain(grid: &MapGrid, bed: &[f64], window: Window) -> String {
    let shade = hillshade(grid, bed);
    let cells = sampled(grid, window);
    let finite = || cells.indices.iter().map(|&i| bed[i]).filter(|z| z.is_finite());
    let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    let range = (high - low).max(1e-9);
    let stops: [Colour; 4] = [[0xdf, 0xe8, 0xd0], [0xf1, 0xec, 0xd6], [0xe9, 0xdd, 0xc8], [0xf4, 0xf2, 0xef]];
    let mut palette = vec![255; 3]; // index 0: no terrain, white
    for tint in 0..TINTS {
        let colour = ramp(&stops, tint as f64 / (TINTS - 1) as f64);
        for level in 0..SHADES {
            // Shadows keep some light, or the map turns black and its labels cannot be read.
            let light = 0.42 + 0.58 * (level as f64 + 0.5) / SHADES as f64;
            palette.extend(colour.map(|channel| (f64::from(channel) * light).round() as u8));
        }
    }
    palette.truncate(3 * 256); // the brightest shade of the highest tint shares its index with the one below
    let indices = cells.indices.iter().map(|&i| {
        if bed[i].is_nan() {
            return 0;
        }
        let tint = (((bed[i] - low) / range * TINTS as f64) as usize).min(TINTS - 1);
        // Level ground lies at 0.71; the contrast is stretched about it.
        let bright = (0.72 + 1.25 * (shade[i] - 0.707)).clamp(0.0, 1.0);
        let level = ((bright * SHADES as f64) as usize).min(SHADES - 1);
        (1 + tint * SHADES + level).min(255) as u8
    });
    let alpha = std::iter::once(0).chain(std::iter::repeat_n(255, 255)).collect();
    encode(cells.columns, cells.rows, palette, alpha, indices.collect())
}

/// A classed layer of a window as a `data:` address; what has no class is transparent, and the edge is drawn darker.
pub(super) fn layer(grid: &MapGrid, values: &[f64], classes: &Classes, window: Window) -> String {
    let cells = sampled(grid, window);
    let class = |index: usize| classes.class_of(values[cells.indices[index]]);
    let count = classes.entries.len();
    let mut palette = vec![0; 3];
    palette.extend(classes.entries.iter().flat_map(|(_, colour, _)| *colour));
    let darker = |colour: &Colour| colour.map(|channel| (f64::from(channel) * 0.45) as u8);
    palette.extend(classes.entries.iter().flat_map(|(_, colour, _)| darker(colour)));
    let alpha = std::iter::once(0).chain(std::iter::repeat_n(205, count)).chain(std::iter::repeat_n(235, count));
    let indices = (0..cells.indices.len()).map(|index| {
        let Some(own) = class(index) else { return 0 };
        let (column, row) = (index % cells.columns, index / cells.columns);
        let at_edge = (column > 0 && class(index - 1).is_none())
            || (column + 1 < cells.columns && class(index + 1).is_none())
            || (row > 0 && class(index - cells.columns).is_none())
            || (row + 1 < cells.rows && class(index + cells.columns).is_none());
        (1 + own + if at_edge { count } else { 0 }) as u8
    });
    encode(cells.columns, cells.rows, palette, alpha.collect(), indices.collect())
}

/// The cells of a window that become pixels.
struct Sampled {
    columns: usize,
    rows: usize,
    indices: Vec<usize>,
}

fn sampled(grid: &MapGrid, window: Window) -> Sampled {
    let stride = window.columns.max(window.rows).div_ceil(LARGEST).max(1);
    let (columns, rows) = (window.columns.div_ceil(stride), window.rows.div_ceil(stride));
    let pick = |first: usize, count: usize, k: usize| first + (k * stride + stride / 2).min(count - 1);
    let indices = (0..rows).flat_map(|row| {
        let source = pick(window.first_row, window.rows, row) * grid.columns;
        (0..columns).map(move |column| source + pick(window.first_column, window.columns, column))
    });
    Sampled { columns, rows, indices: indices.collect() }
}

/// An indexed PNG as a `data:` address.
fn encode(columns: usize, rows: usize, palette: Vec<u8>, alpha: Vec<u8>, indices: Vec<u8>) -> String {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_trns(alpha);
    encoder.set_deflate_compression(png::DeflateCompression::Level(9));
    encoder.set_filter(png::Filter::Sub);
    // Writing to memory fails for no valid picture; an empty one has no header to write and stays empty.
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&indices));
    if written.is_err() {
        bytes.clear();
    }
    format!("data:image/png;base64,{}", BASE64_STANDARD.encode(&bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_window_is_thinned_and_stays_inside() {
        let grid = MapGrid { columns: 5000, rows: 10, west: 0.0, north: 0.0, cell: 1.0 };
        let cells = sampled(&grid, Window { first_column: 3, first_row: 2, columns: 4990, rows: 7 });
        assert_eq!((cells.columns, cells.rows, cells.indices.len()), (1664, 3, 1664 * 3));
        assert!(cells.indices.iter().all(|i| (3..4993).contains(&(i % 5000)) && (2..9).contains(&(i / 5000))));
    }

    #[test]
    fn the_layer_is_a_picture_of_the_window() {
        let grid = MapGrid { columns: 4, rows: 3, west: 0.0, north: 0.0, cell: 1.0 };
        let values: Vec<f64> = (0..12).map(|i| if i == 5 { 3.0 } else { f64::NAN }).collect();
        let window = Window { first_column: 0, first_row: 0, columns: 4, rows: 3 };
        let address = layer(&grid, &values, &Classes::depth(9.0), window);
        let mut reader = png::Decoder::new(std::io::Cursor::new(decode(&address))).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (4, 3));
        // One wet cell: all of it is edge; depth class 3 of 6, so index 1 + 3 + 6.
        assert_eq!(pixels, [0, 0, 0, 0, 0, 10, 0, 0, 0, 0, 0, 0]);
    }

    fn decode(address: &str) -> Vec<u8> {
        BASE64_STANDARD.decode(address.strip_prefix("data:image/png;base64,").unwrap()).unwrap()
    }
}
