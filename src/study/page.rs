//! The page of a reduced study: its state, what varied, maps, quantiles and what drives them.

use super::reduced_maps::ReducedMap;
use super::reduction::{Group, Sources};
use super::statistics::Driver;
use crate::error::Error;
use crate::maps::{Classes, Mark, Panel, Sheet, clock, map_sheet};
use crate::output::{FILL, MapKind};
use crate::report::html;

/// Maps of the page, each with those that stand on one sheet: names of the maps with their captions.
const SHEETS: [(&str, &[(&str, &str)]); 7] = [
    ("Probability of inundation", &[("probability_flooded", "")]),
    (
        "Time of arrival: early, middle and late",
        &[("arrival_time_p05", "P5"), ("arrival_time_p50", "P50"), ("arrival_time_p95", "P95")],
    ),
    ("Spread of the time of arrival, P95 less P5", &[("arrival_time_spread", "")]),
    ("Maximum depth", &[("max_depth_p05", "P5"), ("max_depth_p50", "P50"), ("max_depth_p95", "P95")]),
    ("Maximum speed", &[("max_speed_p50", "P50"), ("max_speed_p95", "P95")]),
    ("Worst hazard class of all runs", &[("hazard_class_envelope", "")]),
    (
        "Increment of maximum depth",
        &[("max_depth_increment_p05", "P5"), ("max_depth_increment_p50", "P50"), ("max_depth_increment_p95", "P95")],
    ),
];

/// The page of a group as text.
///
/// # Errors
/// Where the bed of the first member cannot be read.
pub(super) fn page(sources: &Sources<'_>, group: &Group, maps: &[ReducedMap]) -> Result<String, Error> {
    let title = sources.title(group);
    let mut page = html::begin(&title);
    let (study, left_out) = (sources.study, &sources.left_out);
    let mut lines =
        vec![format!("{} runs count here; the study has {} members", group.members.len(), study.members.len())];
    lines.extend(left_out.iter().map(|(member, why)| format!("member {member} is left out: {why}")));
    lines.extend(sources.doubts.iter().cloned());
    html::status(&mut page, lines.len() == 1, &lines);
    let mut rows = vec![("Base".to_owned(), study.base.display().to_string())];
    if !study.sampling.is_empty() {
        rows.push(("Drawn by".to_owned(), study.sampling.clone()));
    }
    rows.extend(study.variables.iter().map(|variable| (variable.name.clone(), variable.spread.clone())));
    rows.push(("Flooded".to_owned(), format!("from a maximum depth of {} m on", sources.flooded_from)));
    rows.push((
        "P5, P50, P95".to_owned(),
        "values that 5, 50 and 95 % of the runs do not exceed; all runs count the same".to_owned(),
    ));
    html::table(&mut page, "The study", &rows);
    let bed: Vec<f64> = sources.stack.map("bed_elevation", 0)?.into_iter().map(f64::from).collect();
    let marks: Vec<Mark> = sources.first.gauges.iter().map(|gauge| gauge.mark(sources.first.gauges.len())).collect();
    for (caption, panels) in SHEETS {
        let found: Vec<(&ReducedMap, &str, Vec<f64>)> = panels
            .iter()
            .filter_map(|(name, caption)| {
                let map = maps.iter().find(|map| map.name == *name)?;
                Some((map, *caption, shown(map)))
            })
            .collect();
        if found.is_empty() {
            continue;
        }
        let classes = classes(caption, found.iter().map(|(map, _, values)| (map.kind, &values[..])));
        let panels = found.iter().map(|(_, caption, values)| Panel {
            caption: (*caption).to_owned(),
            values,
            classes: &classes,
            under: None,
            wide: found.len() == 1,
        });
        let sheet = Sheet {
            title: &title,
            subtitle: caption,
            grid: &sources.stack.grid,
            bed: &bed,
            panels: panels.collect(),
            marks: &marks,
            crs: &sources.first.crs,
            note: &format!("{} runs", group.members.len()),
        };
        html::figure(&mut page, caption, &map_sheet(&sheet));
    }
    quantiles(&mut page, group);
    page.push_str(html::END);
    Ok(page)
}

/// The values of a map as they are drawn, NaN where there are none.
fn shown(map: &ReducedMap) -> Vec<f64> {
    let value = |value: &f32| if value.to_bits() == FILL.to_bits() { f64::NAN } else { f64::from(*value) };
    map.values.iter().map(value).collect()
}

/// The classes that hold all maps of a sheet.
fn classes<'a>(caption: &str, maps: impl Iterator<Item = (MapKind, &'a [f64])>) -> Classes {
    /// Share of the differences that the inner classes hold.
    const USUAL: f64 = 0.9;
    let (mut kind, mut sizes) = (MapKind::Depth, Vec::new());
    for (own, values) in maps {
        kind = own;
        sizes.extend(values.iter().filter(|value| value.is_finite()).map(|value| value.abs()));
    }
    let greatest = sizes.iter().copied().fold(0.0, f64::max);
    match kind {
        MapKind::Probability => Classes::probability(),
        MapKind::Time => {
            let classes = Classes::arrival(&crate::report::isochrones(greatest));
            if caption.starts_with("Spread") { Classes { title: "P95 less P5".to_owned(), ..classes } } else { classes }
        }
        MapKind::Speed => Classes::speed(greatest),
        MapKind::Class => Classes::hazard(),
        MapKind::Difference => {
            sizes.sort_unstable_by(f64::total_cmp);
            Classes::difference("Increment (m)", super::quantile::quantile(&sizes, USUAL).unwrap_or(0.0))
        }
        _ => Classes::depth(greatest),
    }
}

/// The table of quantiles, with what drives them.
fn quantiles(page: &mut String, group: &Group) {
    let columns =
        ["", "what", "reached", "least", "P5", "P50", "P95", "greatest", "rank correlation"].map(str::to_owned);
    let rows: Vec<Vec<String>> = group
        .places
        .iter()
        .map(|place| {
            let is_time = place.quantity.ends_with("_s")
                && !place.quantity.ends_with("_m_s")
                && !place.quantity.ends_with("m3_s");
            let number = |value: Option<f64>| match value {
                None => "-".to_owned(),
                Some(seconds) if is_time => clock(seconds),
                Some(value) => format!("{value:.3}"),
            };
            let drivers: Vec<String> = place.drivers.iter().map(Driver::words).collect();
            let mut row =
                vec![place.id.clone(), place.quantity.clone(), format!("{} of {}", place.reached, place.runs)];
            row.extend(place.values.map(number));
            row.push(drivers.join(", "));
            row
        })
        .collect();
    let rows: Vec<&[String]> = rows.iter().map(Vec::as_slice).collect();
    html::records(page, "Flooded area, gauges and cross-sections", &columns, &rows);
}
