//! Polygons, lines and points with their attributes, from GeoJSON, GeoPackage, Shapefile and whatever else GDAL reads, in
//! the coordinates of the run.
//!
//! Deliberately left out: curves (GDAL's curve types) and styles.

use std::path::Path;

use gdal::Dataset;
use gdal::spatial_ref::{AxisMappingStrategy, SpatialRef};
use gdal::vector::{
    FieldValue, Geometry, Layer, LayerAccess, OGRwkbGeometryType, geometry_type_flatten, geometry_type_has_z,
};
use geo::orient::{Direction, Orient};
use geo::{Coord, CoordsIter, LineString, Polygon};

use crate::error::{Problem, ProblemKind, input_error, plain_name};
use crate::geodata::{
    Crs, CrsProblem, capture, describe, is_metric, open, readable_file, same_horizontal, transform, vertical_unit,
};
use crate::math::{Rectangle, Vec2};

/// No coordinate in metres or degrees is larger.
const FARTHEST: f64 = 1e9;

/// The value of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// Anything else, as text.
    Text(String),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Number(number) => write!(f, "{number}"),
            Value::Text(text) => f.write_str(text),
        }
    }
}

/// A feature: the simple parts of its geometry, and its attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Feature {
    /// Place in the file, from 1.
    pub number: usize,
    /// Polygons.
    pub polygons: Vec<Polygon<f64>>,
    /// Polylines.
    pub lines: Vec<LineString<f64>>,
    /// Of each polyline the z coordinates (m) of its vertices; none where it has none.
    pub heights: Vec<Vec<f64>>,
    /// Points with their z coordinate (m), if they have one.
    pub points: Vec<(Vec2, Option<f64>)>,
    /// Names and values of the attributes, unset ones left out.
    pub attributes: Vec<(String, Value)>,
}

impl Feature {
    /// The rectangle about it; none without a place.
    pub fn rectangle(&self) -> Option<Rectangle> {
        let of_polygons = self.polygons.iter().flat_map(CoordsIter::coords_iter);
        let coordinates = of_polygons.chain(self.lines.iter().flat_map(CoordsIter::coords_iter));
        let places = coordinates.map(|c| Vec2::new(c.x, c.y));
        Rectangle::about(places.chain(self.points.iter().map(|(place, _)| *place)))
    }

    /// The names of its attributes that hold something, for messages; of a text that begins like a number but is none, the text, too.
    pub fn attribute_names(&self) -> String {
        let is_number_like = |text: &str| text.starts_with(|c: char| c.is_ascii_digit() || "+-.,".contains(c));
        let name = |(name, value): &(String, Value)| match value {
            Value::Text(text) if is_number_like(text.trim()) && text.trim().parse::<f64>().is_err() => {
                format!("{name} (the text `{text}`, which is no number)")
            }
            _ => name.clone(),
        };
        let names: Vec<String> = self.attributes.iter().map(name).collect();
        if names.is_empty() { "none that holds a value".to_owned() } else { names.join(", ") }
    }

    /// Whether a name or a text of its attributes has letters that are none in UTF-8.
    fn has_unknown_letters(&self) -> bool {
        let is_unknown = |text: &str| text.contains(char::REPLACEMENT_CHARACTER);
        self.attributes
            .iter()
            .any(|(name, value)| is_unknown(name) || matches!(value, Value::Text(text) if is_unknown(text)))
    }

    /// An attribute by its name, whatever its case, or by the first ten letters that a Shapefile leaves of it.
    pub fn attribute(&self, name: &str) -> Option<&Value> {
        let short: String = name.chars().take(10).collect();
        let named = |wanted: &str| self.attributes.iter().find(|(n, _)| n.eq_ignore_ascii_case(wanted)).map(|(_, v)| v);
        named(name).or_else(|| named(&short))
    }

    /// An attribute as a number; text that reads as a number counts.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.attribute(name)? {
            Value::Number(number) => Some(*number),
            Value::Text(text) => text.trim().parse().ok(),
        }
    }

    /// Replaces every coordinate by the next one of `places`, in the order of [`Self::coordinates`].
    fn replace_coordinates(&mut self, places: &mut impl Iterator<Item = Vec2>) {
        use geo::MapCoordsInPlace;
        let places = std::cell::RefCell::new(places);
        let next = |old: Coord<f64>| places.borrow_mut().next().map_or(old, |place| Coord { x: place.x, y: place.y });
        self.polygons.iter_mut().for_each(|polygon| polygon.map_coords_in_place(next));
        self.lines.iter_mut().for_each(|line| line.map_coords_in_place(next));
        for (point, _) in &mut self.points {
            let place = next(Coord { x: point.x, y: point.y });
            *point = Vec2::new(place.x, place.y);
        }
    }

    /// Every coordinate: polygons ring by ring, then lines, then points.
    fn coordinates(&self) -> impl Iterator<Item = Vec2> + '_ {
        let as_vec = |c: Coord<f64>| Vec2::new(c.x, c.y);
        self.polygons
            .iter()
            .flat_map(move |p| p.coords_iter().map(as_vec))
            .chain(self.lines.iter().flat_map(move |l| l.coords_iter().map(as_vec)))
            .chain(self.points.iter().map(|(place, _)| *place))
    }
}

/// The features of one layer of a file.
#[derive(Clone, Debug)]
pub struct VectorFile {
    /// The features.
    pub features: Vec<Feature>,
    /// CRS that the file states.
    pub crs: Option<SpatialRef>,
    /// Whether the file states no CRS and GDAL took it for degrees, as it does for a GeoJSON.
    presumed_degrees: bool,
    /// Whether the file states no encoding of its text, and that of old Windows programs was taken.
    presumed_encoding: bool,
}

/// Opens a vector file and reads a layer of it; without a name the only one that draws something.
///
/// # Errors
/// The problem, without key and place.
pub fn open(path: &Path, layer: Option<&str>) -> Result<VectorFile, Problem> {
    readable_file(path)?;
    let name = path.display();
    let (result, messages) = capture(|| open::vector(path, None));
    if let Some(problem) = open::address_asked_for(path) {
        return Err(problem);
    }
    let dataset = result.map_err(|_| {
        let problem = input_error("not-a-vector", format!("{name} is not a vector file that GDAL can read"))
            .with_remedy(format!(
                "name a GeoJSON, GeoPackage, Shapefile or a file of another of the drivers {}; `ogr2ogr` makes one of most others",
                open::VECTOR.join(", ")
            ));
        if messages.is_empty() { problem } else { problem.with_cause(messages.join("; ")) }
    })?;
    let (result, messages) = capture(|| read_layer(&dataset, path, layer));
    let mut file = result?;
    if dataset.driver().short_name() == "ESRI Shapefile" && file.features.iter().any(Feature::has_unknown_letters) {
        let (result, _) =
            capture(|| open::vector(path, Some(&["ENCODING=CP1252"])).map(|dataset| read_layer(&dataset, path, layer)));
        if let Ok(read) = result {
            file = VectorFile { presumed_encoding: true, ..read? };
        }
    }
    if file.features.is_empty() && !messages.is_empty() {
        return Err(input_error("not-a-vector", format!("no feature of {name} could be read"))
            .with_cause(messages.join("; "))
            .with_remedy("export the file again; `ogrinfo -al FILE` shows what GDAL reads of it"));
    }
    let is_place = |c: Vec2| c.x.abs() <= FARTHEST && c.y.abs() <= FARTHEST;
    if let Some(feature) = file.features.iter().find(|feature| !feature.coordinates().all(is_place)) {
        let message = format!("feature {} of {name} has a coordinate that is no place on Earth", feature.number);
        return Err(input_error("not-a-place", message)
            .with_cause("it is not a number, or beyond all that a reference system counts in metres or degrees")
            .with_remedy("export the file again, or draw this feature anew"));
    }
    let degrees = file.features.iter().flat_map(Feature::coordinates).all(|c| c.x.abs() <= 180.0 && c.y.abs() <= 90.0);
    file.presumed_degrees =
        dataset.driver().short_name() == "GeoJSON" && file.crs.as_ref().is_some_and(SpatialRef::is_geographic);
    if file.presumed_degrees && !degrees {
        file.crs = None;
    }
    Ok(file)
}

fn read_layer(dataset: &Dataset, path: &Path, layer: Option<&str>) -> Result<VectorFile, Problem> {
    let name = path.display();
    let found = match layer {
        Some(layer) => dataset.layer_by_name(layer),
        None => dataset.layer(lone_layer(dataset, path)?),
    };
    let mut found = found.map_err(|_| {
        let names: Vec<String> = dataset.layers().map(|l| l.name()).collect();
        let wanted = layer.map_or("no layer at all".to_string(), |layer| format!("no layer `{layer}`"));
        let problem = input_error("no-such-layer", format!("{name} has {wanted}"));
        if names.is_empty() {
            problem.with_remedy("export it again with its features")
        } else {
            problem.with_remedy(format!("its layers are {}", names.join(", ")))
        }
    })?;
    let crs = found.spatial_ref().map(|mut crs| {
        crs.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
        crs
    });
    let height_unit = crs.as_ref().and_then(vertical_unit).map_or(1.0, |(_, metres)| metres);
    let mut features = Vec::new();
    for (index, source) in found.features().enumerate() {
        let mut feature = Feature { number: index + 1, ..Feature::default() };
        if let Some(geometry) = source.geometry() {
            take_apart(geometry, &mut feature).map_err(|kind| {
                input_error("unsupported-geometry", format!("feature {} of {name} is a {kind}", feature.number))
                    .with_remedy(
                        "convert it to points, lines and polygons, for example with `ogr2ogr -nlt CONVERT_TO_LINEAR`",
                    )
            })?;
        }
        feature.heights.iter_mut().flatten().for_each(|height| *height *= height_unit);
        feature.points.iter_mut().filter_map(|(_, height)| height.as_mut()).for_each(|height| *height *= height_unit);
        // A feature of a GeoJSON need not have the attributes of the others; a number that it lacks reads as 0, its text as none.
        let has = |field| source.field_as_string(field).is_ok_and(|text| text.is_some_and(|text| !text.is_empty()));
        let fields = source.fields().enumerate().filter(|(field, _)| has(*field));
        feature.attributes =
            fields.filter_map(|(_, (name, value))| Some((plain_name(&name), attribute_value(value?)?))).collect();
        features.push(feature);
    }
    Ok(VectorFile { features, crs, presumed_degrees: false, presumed_encoding: false })
}

/// The number of the layer of a file that is meant without a name: the only one that draws something, the first one where none does.
fn lone_layer(dataset: &Dataset, path: &Path) -> Result<usize, Problem> {
    let draws = |layer: &Layer| {
        let kind = layer.defn().geometry_type();
        kind != OGRwkbGeometryType::wkbNone && (dataset.layer_count() == 1 || layer.feature_count() > 0)
    };
    let drawn: Vec<(usize, String)> =
        dataset.layers().enumerate().filter(|(_, layer)| draws(layer)).map(|(i, layer)| (i, layer.name())).collect();
    let name = match &drawn[..] {
        [] => return Ok(0),
        [(lone, _)] => return Ok(*lone),
        [(_, name), ..] => name,
    };
    let names: Vec<&str> = drawn.iter().map(|(_, name)| name.as_str()).collect();
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let message = format!("which layer of {} is meant is not known", path.display());
    Err(input_error("several-layers", message)
        .with_cause(format!("it has {}", names.join(", ")))
        .with_remedy(format!("name one behind a colon, as in `{file}:{name}`")))
}

fn attribute_value(value: FieldValue) -> Option<Value> {
    Some(match value {
        FieldValue::IntegerValue(number) => Value::Number(f64::from(number)),
        FieldValue::Integer64Value(number) => Value::Number(number as f64),
        FieldValue::RealValue(number) => Value::Number(number),
        FieldValue::StringValue(text) => Value::Text(plain_name(&text)),
        FieldValue::DateValue(date) => Value::Text(date.to_string()),
        FieldValue::DateTimeValue(time) => Value::Text(time.to_string()),
        _ => return None,
    })
}

/// Adds the simple parts of a geometry to a feature; a geometry of another kind is handed back by its name.
fn take_apart(geometry: &Geometry, feature: &mut Feature) -> Result<(), String> {
    if geometry.is_empty() {
        return Ok(());
    }
    match geometry_type_flatten(geometry.geometry_type()) {
        OGRwkbGeometryType::wkbPoint => {
            let (x, y, z) = geometry.get_point(0);
            feature.points.push((Vec2::new(x, y), geometry_type_has_z(geometry.geometry_type()).then_some(z)));
        }
        OGRwkbGeometryType::wkbLineString => {
            let mut points = Vec::new();
            geometry.get_points(&mut points);
            let has_z = geometry_type_has_z(geometry.geometry_type());
            feature.heights.push(if has_z { points.iter().map(|point| point.2).collect() } else { Vec::new() });
            feature.lines.push(points.into_iter().map(|(x, y, _)| Coord { x, y }).collect());
        }
        OGRwkbGeometryType::wkbPolygon => {
            let mut rings = (0..geometry.geometry_count()).map(|i| line_string(&geometry.get_geometry(i)));
            if let Some(outer) = rings.next() {
                // Files have their rings either way round; a union of polygons turned against each other would leave one of them out.
                // One with a coordinate that is no number goes no way round; the check refuses it.
                let polygon = Polygon::new(outer, rings.collect());
                let is_finite = polygon.coords_iter().all(|place| place.x.is_finite() && place.y.is_finite());
                feature.polygons.push(if is_finite { polygon.orient(Direction::Default) } else { polygon });
            }
        }
        OGRwkbGeometryType::wkbMultiPoint
        | OGRwkbGeometryType::wkbMultiLineString
        | OGRwkbGeometryType::wkbMultiPolygon
        | OGRwkbGeometryType::wkbGeometryCollection => {
            for i in 0..geometry.geometry_count() {
                take_apart(&geometry.get_geometry(i), feature)?;
            }
        }
        _ => return Err(geometry.geometry_name()),
    }
    Ok(())
}

fn line_string(geometry: &Geometry) -> LineString<f64> {
    let mut points = Vec::new();
    geometry.get_points(&mut points);
    points.into_iter().map(|(x, y, _)| Coord { x, y }).collect()
}

impl VectorFile {
    /// The file in the coordinates of the run, to which it is brought from another CRS, with warnings about what had to be presumed (without
    /// key and place).
    ///
    /// # Errors
    /// The problem, without key and place, when no way leads from its CRS to that of the run.
    pub fn in_run_crs(mut self, path: &Path, run: &Crs) -> Result<(Vec<Feature>, Vec<Problem>), Problem> {
        let name = path.display().to_string();
        let mut warnings: Vec<Problem> = self.assumed_encoding(&name).into_iter().collect();
        match (run, self.crs.take()) {
            (Crs::Local, Some(crs)) if !self.presumed_degrees => warnings.push(set_aside(&crs, &name)?),
            (Crs::Local, _) => {}
            (Crs::Projected(run), Some(crs)) if same_horizontal(run, &crs) => {}
            (Crs::Projected(run), Some(crs)) => self.bring_to(run, &crs, &name)?,
            (Crs::Projected(run), None) => warnings.push(self.assumed_crs(run, &name)),
        }
        Ok((self.features, warnings))
    }

    fn assumed_encoding(&self, name: &str) -> Option<Problem> {
        self.presumed_encoding.then(|| {
            let message = format!(
                "the letters of {name} are none of UTF-8, and it names no other encoding: they are taken as Windows-1252"
            );
            Problem::warning(ProblemKind::Input, "assumed-encoding", "", message).with_remedy(
                "put a .cpg file of the same name beside it that names the encoding, such as `ISO-8859-1` or `CP1250`",
            )
        })
    }

    /// Transforms all coordinates to the system of the run.
    fn bring_to(&mut self, run: &SpatialRef, crs: &SpatialRef, name: &str) -> Result<(), Problem> {
        let mut places: Vec<Vec2> = self.features.iter().flat_map(Feature::coordinates).collect();
        transform(&mut places, crs, run).map_err(|cause| {
            let its = format!("{}, in which {name} is", describe(crs));
            let because = if self.presumed_degrees {
                "; a GeoJSON without a `crs` member counts in degrees (RFC 7946)"
            } else {
                ""
            };
            input_error("no-transformation", format!("{its}, could not be brought to {}", describe(run)))
                .with_cause(format!("{cause}{because}"))
                .with_remedy("check that `crs:` covers the place of this file on Earth")
        })?;
        let mut places = places.into_iter();
        for feature in &mut self.features {
            feature.replace_coordinates(&mut places);
        }
        Ok(())
    }

    fn assumed_crs(&self, run: &SpatialRef, name: &str) -> Problem {
        let message = format!("{name} states no CRS; its coordinates are taken as {}", describe(run));
        let warning = Problem::warning(ProblemKind::Input, "assumed-crs", "", message);
        if self.presumed_degrees {
            warning.with_cause("a GeoJSON without a `crs` member should count in degrees, but these are none")
        } else {
            warning
        }
    }
}

/// The warning of a system that a run in local metres sets aside; a problem where it counts in degrees.
fn set_aside(crs: &SpatialRef, name: &str) -> Result<Problem, Problem> {
    if is_metric(crs) == Err(CrsProblem::Geographic) {
        let message = format!("{name} counts in degrees ({}), the run in local metres", describe(crs));
        return Err(input_error("geographic-crs", message)
            .with_remedy("give the run a metric CRS by `crs: EPSG:...`, or the file local coordinates"));
    }
    let message = format!("{name} has the CRS {}, which `crs: local` sets aside", describe(crs));
    Ok(Problem::warning(ProblemKind::Input, "crs-set-aside", "", message))
}

#[cfg(test)]
mod tests;
