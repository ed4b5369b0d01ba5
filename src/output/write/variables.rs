//! The maps as variables: names, units and meaning, the same in `maps.nc` and in the COGs.

use super::super::grid::GridMaps;
use super::super::ground_source::{SourceClass, SourceGrid};
use super::super::hazard::HAZARD_CLASSES;
use super::super::tracers::{TracerGrids, TracerPlan};

/// What a map shows; decides its data type and its style.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapKind {
    /// Bed elevation or water level (m).
    Level,
    /// Depth (m).
    Depth,
    /// Speed (m/s) or depth times speed (m²/s).
    Speed,
    /// Concentration, in a unit of its own.
    Concentration,
    /// Time since the start (s).
    Time,
    /// A share of runs.
    Probability,
    /// A value of one run less that of another, in the unit of both.
    Difference,
    /// One of a few classes.
    Class,
}

/// A value of a map of classes.
#[derive(Clone, Debug, PartialEq)]
pub struct MapClass {
    /// The value.
    pub value: u8,
    /// Its meaning as one word, for flags.
    pub name: String,
    /// Its meaning in words, for legends.
    pub label: String,
    /// Its colour, red green blue; none where it is not drawn.
    pub colour: Option<[u8; 3]>,
}

/// One map with what a reader has to know about it.
#[derive(Clone, Debug, PartialEq)]
pub struct MapVariable<'a> {
    /// Name in files.
    pub name: String,
    /// Name for people; unique, since QGIS's mesh reader drops one of two variables with the same.
    pub long_name: String,
    /// Name in the CF standard name table, where there is one.
    pub standard_name: Option<&'static str>,
    /// Unit.
    pub units: &'a str,
    /// How the value was formed over time; empty where that does not apply.
    pub cell_methods: &'static str,
    /// Definition.
    pub comment: String,
    /// Depth threshold that the map belongs to (m).
    pub threshold: Option<f64>,
    /// What it shows.
    pub kind: MapKind,
    /// Its classes, ascending, where it is a map of them.
    pub classes: Vec<MapClass>,
    /// Values, row 0 in the north.
    pub values: &'a [f32],
}

/// The ending of names that belong to a threshold (m): `0p10m` for 0.1 m, `0p305m` for 0.305 m.
pub fn threshold_name(threshold: f64) -> String {
    let mut digits = format!("{threshold:.4}");
    while digits.ends_with('0') && digits.len() - digits.find('.').unwrap_or(0) > 3 {
        digits.pop();
    }
    format!("{}m", digits.replace('.', "p"))
}

/// All maps of a run, in the order of the files.
///
/// The first threshold gives `arrival_time`, `flood_duration` and `deflood_time`; each further one adds its depth to
/// these names, such as `arrival_time_0p50m`. `rise_on_wet` (m) is the one of the recorder, for the definitions.
pub fn map_variables(maps: &GridMaps, rise_on_wet: f64) -> Vec<MapVariable<'_>> {
    let mut variables = maxima(maps);
    for (which, grids) in maps.thresholds.iter().enumerate() {
        let depth = grids.threshold;
        let suffix = if which == 0 { String::new() } else { format!("_{}", threshold_name(depth)) };
        let time = |name: &str, long_name: &str, standard_name, comment: String, values| MapVariable {
            name: format!("{name}{suffix}"),
            long_name: format!("{long_name} {depth} m"),
            standard_name: Some(standard_name),
            units: "s",
            cell_methods: "",
            comment,
            threshold: Some(depth),
            kind: MapKind::Time,
            classes: Vec::new(),
            values,
        };
        variables.push(time(
            "arrival_time",
            "time of arrival of water deeper than",
            "time_when_flood_water_rises_above_threshold",
            format!(
                "seconds since the start; ground dry at the start: first time the depth is at least {depth} m; ground \
                 wet at the start: first time the level has also risen by {rise_on_wet} m; interpolated between compute \
                 steps; no value where the water never came"
            ),
            &grids.arrival[..],
        ));
        variables.push(time(
            "flood_duration",
            "time under water deeper than",
            "flood_water_duration_above_threshold",
            format!("sum of all times with a depth of at least {depth} m, up to the end of the run"),
            &grids.duration[..],
        ));
        variables.push(time(
            "deflood_time",
            "time of the last fall of the water below",
            "time_when_flood_water_falls_below_threshold",
            format!("seconds since the start; last time the depth fell below {depth} m; no value where it never did or where the water still stands at the end of the run"),
            &grids.recession[..],
        ));
    }
    let edge = "edge of the cells of the run";
    let resolution = || map("resolution", edge, None, ("m", MapKind::Depth), "", &maps.resolution);
    variables.extend((!maps.resolution.is_empty()).then(resolution));
    variables.extend(errors(maps));
    variables.extend(of_tracers(&maps.tracers));
    variables.extend(ground_source(maps));
    variables
}

/// The maps of no threshold.
fn maxima(maps: &GridMaps) -> Vec<MapVariable<'_>> {
    const MAXIMUM: &str = "area: maximum time: maximum";
    let metres = ("m", MapKind::Level);
    let bed = "bed elevation used in the run";
    let level = Some("water_surface_height_above_reference_datum");
    let time_of_max = Some("time_of_maximum_flood_depth");
    vec![
        map("bed_elevation", bed, Some("ground_level_altitude"), metres, "area: mean", &maps.bed_elevation[..]),
        map(
            "max_depth",
            "maximum depth",
            Some("flood_water_thickness"),
            ("m", MapKind::Depth),
            MAXIMUM,
            &maps.max_depth,
        ),
        map("max_water_level", "maximum water level", level, metres, MAXIMUM, &maps.max_water_level),
        map(
            "max_speed",
            "maximum speed",
            Some("flood_water_speed"),
            ("m s-1", MapKind::Speed),
            MAXIMUM,
            &maps.max_speed,
        ),
        map(
            "max_depth_velocity",
            "maximum depth times speed of one moment",
            None,
            ("m2 s-1", MapKind::Speed),
            MAXIMUM,
            &maps.max_depth_velocity,
        ),
        map(
            "time_of_max_depth",
            "time of maximum depth",
            time_of_max,
            ("s", MapKind::Time),
            "",
            &maps.time_of_max_depth,
        ),
        map(
            "hazard_class",
            "maximum hazard class of one moment",
            None,
            ("1", MapKind::Class),
            MAXIMUM,
            &maps.hazard_class,
        ),
    ]
}

/// A map of the greatest values of a run: unit and kind belong together.
fn map<'a>(
    name: &str,
    long_name: &str,
    standard_name: Option<&'static str>,
    (units, kind): (&'static str, MapKind),
    cell_methods: &'static str,
    values: &'a [f32],
) -> MapVariable<'a> {
    let comment = match name {
        "max_water_level" => "above the vertical datum of the terrain; no value where always dry",
        "bed_elevation" => "above the vertical datum of the terrain",
        "time_of_max_depth" => "seconds since the start; no value where always dry",
        "resolution" => "of the level that stands for the place",
        "max_depth_error" => {
            "greatest difference from a run on cells twice as wide, up to one such cell away (first order)"
        }
        "arrival_time_error" => {
            "greatest difference from a run on cells twice as wide, up to one such cell away (first order); no value where the water does not arrive in both"
        }
        "hazard_class" => "combined hazard curves H1 to H6 of AIDR Guideline 7-3 (2017); 0 where always dry",
        _ => "maximum over all compute steps; 0 where always dry",
    };
    MapVariable {
        name: name.to_string(),
        long_name: long_name.to_string(),
        standard_name,
        units,
        cell_methods,
        comment: comment.to_string(),
        threshold: None,
        kind,
        classes: if name == "hazard_class" { hazard_classes() } else { Vec::new() },
        values,
    }
}

/// The hazard classes, dry ground before them.
pub fn hazard_classes() -> Vec<MapClass> {
    let dry = MapClass { value: 0, name: "dry".into(), label: "dry".into(), colour: None };
    let others = HAZARD_CLASSES.iter().zip(1..).map(|(class, value)| MapClass {
        value,
        name: format!("{}_{}", class.name, class.meaning.replace(", ", "_").replace(' ', "_")),
        label: format!("{}: {}", class.name, class.meaning),
        colour: Some(class.colour),
    });
    std::iter::once(dry).chain(others).collect()
}

/// The maps of estimated errors, where they are asked for.
fn errors(maps: &GridMaps) -> impl Iterator<Item = MapVariable<'_>> {
    let of = |name: &str, long_name: &str, unit, values| map(name, long_name, None, unit, "", values);
    let depth = "estimated error of the maximum depth";
    let arrival = "estimated error of the time of arrival";
    let all = [
        of("max_depth_error", depth, ("m", MapKind::Depth), &maps.max_depth_error[..]),
        of("arrival_time_error", arrival, ("s", MapKind::Time), &maps.arrival_time_error[..]),
    ];
    all.into_iter().filter(|map| !map.values.is_empty())
}

/// The maps of the tracers.
fn of_tracers(grids: &[TracerGrids]) -> impl Iterator<Item = MapVariable<'_>> {
    grids.iter().flat_map(|grids| {
        let TracerPlan { name, unit, greatest, arrival_threshold } = &grids.plan;
        let wanted = arrival_threshold * greatest;
        let map = |start: &str, long_name: String, units, (kind, cell_methods), comment: String, values| MapVariable {
            name: format!("{start}_{name}"),
            long_name,
            standard_name: None,
            units,
            cell_methods,
            comment,
            threshold: None,
            kind,
            classes: Vec::new(),
            values,
        };
        let most = (MapKind::Concentration, "area: maximum time: maximum");
        [
            map(
                "max_concentration",
                format!("maximum concentration of {name}"),
                unit.as_str(),
                most,
                "depth-averaged; maximum over all compute steps; no value where always dry".to_owned(),
                &grids.greatest[..],
            ),
            map(
                "dilution",
                format!("maximum concentration of {name} over that of its sources"),
                "1",
                most,
                format!("over the greatest concentration of the sources, {greatest} {unit}; no value where always dry"),
                &grids.dilution[..],
            ),
            map(
                "tracer_arrival",
                format!("time of arrival of {name}"),
                "s",
                (MapKind::Time, ""),
                format!("seconds since the start; first time the concentration is at least {wanted} {unit}; interpolated between compute steps; no value where it never was"),
                &grids.arrival[..],
            ),
        ]
    })
}

/// The map of who set the ground, where it is asked for.
fn ground_source(maps: &GridMaps) -> Option<MapVariable<'_>> {
    let SourceGrid { codes, classes } = &maps.ground_source;
    let of_class = |class: &SourceClass| MapClass {
        value: class.code,
        name: class.name.clone(),
        label: class.label.clone(),
        colour: Some(class.colour),
    };
    let listed: Vec<String> = classes.iter().map(|class| format!("{}: {}", class.name, class.label)).collect();
    (!codes.is_empty()).then(|| MapVariable {
        name: "ground_source".into(),
        long_name: "source of the ground at the start of the run".into(),
        standard_name: None,
        units: "1",
        cell_methods: "",
        comment: format!(
            "last to change the ground by 1 mm or more before the run began; bed_elevation is that of its end; {}",
            listed.join("; ")
        ),
        threshold: None,
        kind: MapKind::Class,
        classes: classes.iter().map(of_class).collect(),
        values: codes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_have_short_names() {
        for (threshold, name) in [(0.1, "0p10m"), (0.305, "0p305m"), (1.0, "1p00m"), (0.01, "0p01m")] {
            assert_eq!(threshold_name(threshold), name);
        }
    }
}
