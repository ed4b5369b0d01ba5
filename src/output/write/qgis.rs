//! QGIS styles: beside each COG, and in the table of styles of `results.gpkg`.

use super::super::grid::FILL;
use super::variables::{MapClass, MapKind, MapVariable};
use crate::error::plain_name;
use crate::math::readable;

/// Upper limits of the classes of depth (m), of speed (m/s) and of depth times speed (m²/s); below the first nothing is drawn.
const DEPTHS: [f64; 7] = [0.01, 0.3, 0.5, 1.0, 2.0, 4.0, 8.0];
const SPEEDS: [f64; 7] = [0.01, 0.5, 1.0, 2.0, 4.0, 6.0, 10.0];
/// The same of shares of runs.
const PROBABILITIES: [f64; 7] = [0.001, 0.05, 0.1, 0.25, 0.5, 0.75, 0.95];

/// Light to dark.
const BLUES: [&str; 8] = ["#ffffff", "#deebf7", "#c6dbef", "#9ecae1", "#6baed6", "#3182bd", "#08519c", "#08306b"];
const REDS: [&str; 8] = ["#ffffff", "#fef0d9", "#fdd49e", "#fdbb84", "#fc8d59", "#e34a33", "#b30000", "#7f0000"];
/// Early to late.
const TIMES: [&str; 8] = ["#67001f", "#b2182b", "#d6604d", "#f4a582", "#92c5de", "#4393c3", "#2166ac", "#053061"];
/// Low to high.
const LEVELS: [&str; 8] = ["#1a6837", "#5fa053", "#a6cf76", "#e6eaa0", "#e0c27a", "#b98b4e", "#8c5a32", "#f2efea"];
/// Less to more, with nothing between.
const DIFFERENCES: [&str; 7] = ["#2166ac", "#67a9cf", "#d1e5f0", "#ffffff", "#fddbc7", "#ef8a62", "#b2182b"];

/// One class of a style: upper limit, colour, whether it is drawn, label.
struct Class {
    upper: String,
    colour: &'static str,
    drawn: bool,
    label: String,
}

/// The style of a map.
pub(super) fn raster_style(map: &MapVariable<'_>) -> String {
    let body = match map.kind {
        MapKind::Class => class_renderer(&map.classes),
        MapKind::Concentration => discrete_renderer(&equal_classes(map, &BLUES, 1.0, map.units, false)),
        MapKind::Probability => discrete_renderer(&limits(&PROBABILITIES, &BLUES, "")),
        MapKind::Depth => discrete_renderer(&limits(&DEPTHS, &BLUES, map.units)),
        MapKind::Speed => discrete_renderer(&limits(&SPEEDS, &REDS, map.units)),
        MapKind::Time => {
            discrete_renderer(&equal_classes(map, &TIMES, 60.0, "min", map.name.starts_with("flood_duration")))
        }
        MapKind::Level => discrete_renderer(&equal_classes(map, &LEVELS, 1.0, "m", false)),
        MapKind::Difference => discrete_renderer(&classes_about_zero(map)),
    };
    format!(
        "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n\
         <qgis version=\"3.22\" styleCategories=\"Symbology\">\n  <pipe>\n{body}  </pipe>\n</qgis>\n"
    )
}

fn limits(limits: &[f64; 7], colours: &[&'static str; 8], unit: &str) -> Vec<Class> {
    let unit = escaped(unit);
    let mut classes: Vec<Class> = Vec::new();
    for (index, colour) in colours.iter().enumerate() {
        let upper = limits.get(index);
        let label = match (index, upper) {
            (0, _) => "dry".to_string(),
            (_, Some(upper)) => format!("{} - {upper} {unit}", limits[index - 1]),
            (_, None) => format!("&gt; {} {unit}", limits[index - 1]),
        };
        let upper = upper.map_or("inf".to_string(), f64::to_string);
        classes.push(Class { upper, colour, drawn: index > 0, label });
    }
    classes
}

/// Eight classes of equal width from the smallest to the greatest value, labelled in `unit` of `size`.
fn equal_classes(
    map: &MapVariable<'_>,
    colours: &[&'static str; 8],
    size: f64,
    unit: &str,
    hide_zero: bool,
) -> Vec<Class> {
    let values = map.values.iter().filter(|value| value.to_bits() != FILL.to_bits() && (!hide_zero || **value > 0.0));
    let (least, greatest) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v.into()), b.max(v.into())));
    let (least, greatest) = if least <= greatest { (least, greatest) } else { (0.0, 0.0) };
    let step = (greatest - least) / colours.len() as f64;
    let mut classes = Vec::new();
    if hide_zero {
        classes.push(Class { upper: "0".into(), colour: "#ffffff", drawn: false, label: "never".into() });
    }
    for (index, colour) in colours.iter().enumerate() {
        let (from, to) = (least + index as f64 * step, least + (index + 1) as f64 * step);
        let is_last = index + 1 == colours.len();
        let upper = if is_last { "inf".into() } else { format!("{to:.3}") };
        classes.push(Class {
            upper,
            colour,
            drawn: true,
            label: format!("{:.1} - {:.1} {unit}", from / size, to / size),
        });
    }
    classes
}

/// Classes from falls to rises: the outer ones hold a tenth of the differences, and what is less than a tenth of their bound is not drawn.
fn classes_about_zero(map: &MapVariable<'_>) -> Vec<Class> {
    let differs = |value: &&f32| value.to_bits() != FILL.to_bits() && **value != 0.0;
    let mut sizes: Vec<f32> = map.values.iter().filter(differs).map(|value| value.abs()).collect();
    let place = sizes.len() * 9 / 10;
    let usual = if sizes.is_empty() { 0.0 } else { f64::from(*sizes.select_nth_unstable_by(place, f32::total_cmp).1) };
    // Legends have three decimals.
    let usual = usual.max(1e-3);
    let (size, unit) = if map.units == "s" { (60.0, "min") } else { (1.0, map.units) };
    let [least, middle] = [usual / 10.0, usual / 3.0];
    let bounds = [-usual, -middle, -least, least, middle, usual];
    let in_unit = |bound: f64| readable((bound / size * 1e3).round() / 1e3);
    let class = |(index, colour): (usize, &&'static str)| {
        let (from, to) = (index.checked_sub(1).map(|index| bounds[index]), bounds.get(index));
        let label = match (from, to) {
            (Some(from), Some(to)) => format!("{} to {}", in_unit(from), in_unit(*to)),
            (Some(from), None) => format!("&gt; {}", in_unit(from)),
            (None, to) => format!("&lt; {}", in_unit(to.copied().unwrap_or(0.0))),
        };
        Class {
            upper: to.map_or("inf".into(), |to| format!("{to:.6}")),
            colour,
            drawn: index != bounds.len() / 2,
            label: format!("{label} {}", escaped(unit)),
        }
    };
    DIFFERENCES.iter().enumerate().map(class).collect()
}

fn discrete_renderer(classes: &[Class]) -> String {
    let item = |class: &Class| {
        let alpha = if class.drawn { 255 } else { 0 };
        format!(
            "          <item value=\"{}\" color=\"{}\" alpha=\"{alpha}\" label=\"{}\"/>\n",
            class.upper, class.colour, class.label
        )
    };
    let items: String = classes.iter().map(item).collect();
    format!(
        "    <rasterrenderer type=\"singlebandpseudocolor\" band=\"1\" opacity=\"1\" alphaBand=\"-1\">\n      <rastershader>\n\
         \x20       <colorrampshader colorRampType=\"DISCRETE\" classificationMode=\"1\" clip=\"0\">\n{items}\
         \x20       </colorrampshader>\n      </rastershader>\n    </rasterrenderer>\n"
    )
}

fn class_renderer(classes: &[MapClass]) -> String {
    let entry = |class: &MapClass| {
        let alpha = if class.colour.is_some() { 255 } else { 0 };
        let (colour, label) = (hexadecimal(class.colour.unwrap_or([255; 3])), escaped(&class.label));
        format!(
            "        <paletteEntry value=\"{}\" color=\"{colour}\" alpha=\"{alpha}\" label=\"{label}\"/>\n",
            class.value
        )
    };
    let entries: String = classes.iter().map(entry).collect();
    format!(
        "    <rasterrenderer type=\"paletted\" band=\"1\" opacity=\"1\" alphaBand=\"-1\">\n      <colorPalette>\n{entries}\
         \x20     </colorPalette>\n    </rasterrenderer>\n"
    )
}

fn hexadecimal([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn escaped(text: &str) -> String {
    plain_name(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// What a layer of the GeoPackage is drawn as.
pub(super) enum LayerStyle<'a> {
    /// Filled areas with a rim: fill and rim as `red,green,blue,alpha`.
    Area(&'a str, &'a str),
    /// Points of a colour, labelled with a column.
    Point(&'a str, &'a str),
    /// Lines of a colour, labelled with a column.
    Line(&'a str, &'a str),
    /// Areas coloured by the values of a column, early to late.
    Categories(&'a str, &'a [f64]),
    /// Areas coloured by the edge of their cells (m), the finest first.
    Levels(&'a str, &'a [f64]),
}

/// The style of a vector layer.
pub(super) fn vector_style(style: &LayerStyle<'_>) -> String {
    let (renderer, labels) = match style {
        LayerStyle::Area(fill, rim) => (single_symbol(&fill_symbol("0", fill, rim)), String::new()),
        LayerStyle::Point(colour, column) => (single_symbol(&marker_symbol(colour)), labelling(column)),
        LayerStyle::Line(colour, column) => (single_symbol(&line_symbol(colour)), labelling(column)),
        LayerStyle::Categories(column, values) => {
            (categories(column, values, |time| format!("within {} min", time / 60.0)), String::new())
        }
        LayerStyle::Levels(column, values) => {
            (categories(column, values, |edge| format!("cells of {edge} m")), String::new())
        }
    };
    format!(
        "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n\
         <qgis version=\"3.22\" styleCategories=\"Symbology|Labeling\" labelsEnabled=\"{}\">\n{renderer}{labels}</qgis>\n",
        u8::from(!labels.is_empty())
    )
}

fn single_symbol(symbol: &str) -> String {
    format!(
        "  <renderer-v2 type=\"singleSymbol\" symbollevels=\"0\" enableorderby=\"0\">\n    <symbols>\n{symbol}    </symbols>\n  </renderer-v2>\n"
    )
}

fn option(name: &str, value: &str) -> String {
    format!("          <Option type=\"QString\" name=\"{name}\" value=\"{value}\"/>\n")
}

fn symbol(name: &str, kind: &str, class: &str, options: &[(&str, &str)]) -> String {
    let options: String = options.iter().map(|(name, value)| option(name, value)).collect();
    format!(
        "      <symbol name=\"{name}\" type=\"{kind}\" alpha=\"1\">\n        <layer class=\"{class}\" enabled=\"1\" locked=\"0\" pass=\"0\">\n\
         \x20         <Option type=\"Map\">\n{options}          </Option>\n        </layer>\n      </symbol>\n"
    )
}

fn fill_symbol(name: &str, fill: &str, rim: &str) -> String {
    let options = [
        ("color", fill),
        ("style", "solid"),
        ("outline_color", rim),
        ("outline_width", "0.3"),
        ("outline_style", "solid"),
    ];
    symbol(name, "fill", "SimpleFill", &options)
}

fn marker_symbol(colour: &str) -> String {
    let options = [("color", colour), ("name", "circle"), ("size", "2.4"), ("outline_color", "35,35,35,255")];
    symbol("0", "marker", "SimpleMarker", &options)
}

fn line_symbol(colour: &str) -> String {
    let options = [("line_color", colour), ("line_width", "0.6"), ("line_style", "solid")];
    symbol("0", "line", "SimpleLine", &options)
}

fn labelling(column: &str) -> String {
    format!(
        "  <labeling type=\"simple\">\n    <settings>\n      <text-style fieldName=\"{column}\" fontSize=\"8\" isExpression=\"0\"/>\n\
         \x20     <placement placement=\"6\" dist=\"1\"/>\n    </settings>\n  </labeling>\n"
    )
}

fn categories(column: &str, values: &[f64], label: fn(f64) -> String) -> String {
    let mut entries = String::new();
    let mut symbols = String::new();
    for (index, value) in values.iter().enumerate() {
        let place = index * (TIMES.len() - 1) / values.len().max(2).saturating_sub(1);
        let hexadecimal = TIMES[place.min(TIMES.len() - 1)];
        let part = |from: usize| u8::from_str_radix(&hexadecimal[from..from + 2], 16).unwrap_or(0);
        let fill = format!("{},{},{},150", part(1), part(3), part(5));
        let label = label(*value);
        entries +=
            &format!("      <category value=\"{value}\" symbol=\"{index}\" label=\"{label}\" render=\"true\"/>\n");
        symbols += &fill_symbol(&index.to_string(), &fill, "35,35,35,120");
    }
    format!(
        "  <renderer-v2 type=\"categorizedSymbol\" attr=\"{column}\" symbollevels=\"0\" enableorderby=\"0\">\n    <categories>\n{entries}\
         \x20   </categories>\n    <symbols>\n{symbols}    </symbols>\n  </renderer-v2>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_cover_all_values() {
        let values = [FILL, 60.0, 120.0, 540.0];
        let map = MapVariable {
            classes: Vec::new(),
            name: "arrival_time".into(),
            long_name: String::new(),
            standard_name: None,
            units: "s",
            cell_methods: "",
            comment: String::new(),
            threshold: Some(0.1),
            kind: MapKind::Time,
            values: &values,
        };
        let style = raster_style(&map);
        assert!(
            style.contains("value=\"120.000\"") && style.contains("value=\"inf\"") && style.contains("1.0 - 2.0 min")
        );
        let apart: Vec<f32> = (-20..=0).map(|value| value as f32 * 60.0).chain([FILL]).collect();
        let of_difference = MapVariable { kind: MapKind::Difference, values: &apart, ..map.clone() };
        let style = raster_style(&of_difference);
        // Nine tenths of what differs is within 19 min.
        for (upper, label) in
            [("-1140.000000", "&lt; -19 min"), ("-380.000000", "-19 to -6.333 min"), ("inf", "&gt; 19 min")]
        {
            let found = style.lines().find(|line| line.contains(&format!("value=\"{upper}\"")));
            assert!(found.is_some_and(|line| line.contains(&format!("label=\"{label}\""))), "{label}: {style}");
        }
        assert_eq!(style.matches("alpha=\"0\"").count(), 1);
        let empty = raster_style(&MapVariable { values: &[FILL], ..map });
        assert!(!empty.contains("NaN") && !empty.contains("inf -"), "{empty}");
    }
}
