//! Survey files: text with columns x y z, or any vector file whose points carry a height.

use std::collections::HashMap;
use std::path::Path;

use gdal::spatial_ref::SpatialRef;

use super::{PLAUSIBLE_ELEVATION, SurveyPoint};
use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::{Table, TextError, read_text_within, readable_file};
use crate::math::{Vec2, in_bytes};
use crate::vector;

/// Survey points of a file, with what was found on the way (without key and place).
pub struct SurveyFile {
    /// Points in the order of the file, each place once.
    pub points: Vec<SurveyPoint>,
    /// CRS that the file states.
    pub crs: Option<SpatialRef>,
    /// Warnings.
    pub warnings: Vec<Problem>,
}

/// Names of columns and attributes that hold the elevation.
const ELEVATION_NAMES: [&str; 6] = ["z", "elevation", "height", "level", "bed", "alt"];

/// Reads survey points of which text takes no more than its share of the memory limit (bytes).
///
/// # Errors
/// The problem, without key and place.
pub fn read_survey(path: &Path, memory: f64) -> Result<SurveyFile, Problem> {
    readable_file(path)?;
    let is_vector = path.extension().is_some_and(|e| {
        let e = e.to_string_lossy().to_lowercase();
        ["shp", "gpkg", "geojson", "json", "gml", "kml", "fgb", "sqlite", "dxf", "gdb"].contains(&e.as_str())
    });
    let (points, crs) = if is_vector { from_vector(path)? } else { (from_text(path, memory)?, None) };
    if points.is_empty() {
        return Err(input_error("no-points", format!("{} holds no survey point", path.display()))
            .with_remedy("give it lines with x, y and z"));
    }
    let (points, warning) = without_duplicates(path, points);
    let warnings = doubtful(path, &points).into_iter().chain(warning).collect();
    Ok(SurveyFile { points, crs, warnings })
}

fn from_text(path: &Path, memory: f64) -> Result<Vec<SurveyPoint>, Problem> {
    /// Memory of a text while its numbers are read, over its length.
    const OF_TEXT: f64 = 8.0;
    let name = path.display();
    let text = read_text_within(path, (memory / OF_TEXT) as u64).map_err(|error| {
        if matches!(&error, TextError::Io(cause) if cause.kind() == std::io::ErrorKind::FileTooLarge) {
            let message = format!("the points of {name} need more memory than the limit of {}", in_bytes(memory));
            return Problem::error(ProblemKind::Limit, "memory-limit", "", message)
                .with_cause(format!("unpacked {error}"))
                .with_remedy("thin the points out, make a raster of them, or raise `limits.memory`");
        }
        let code = if matches!(error, TextError::NotText) { "not-a-survey" } else { "unreadable-file" };
        input_error(code, format!("{name} is no survey of points x y z"))
            .with_cause(error.to_string())
            .with_remedy("give a text file with three columns x y z, or a vector file of points")
    })?;
    let table = Table::parse(&text, |fields| fields.first().is_some_and(|field| field.parse::<f64>().is_err()));
    let x = table.column(&["x", "east", "easting"]).unwrap_or(0);
    let y = table.column(&["y", "north", "northing"]).unwrap_or(1);
    let z = table.column(&ELEVATION_NAMES).unwrap_or(2);
    let mut points = Vec::with_capacity(table.rows.len());
    for (line, fields) in &table.rows {
        let number = |column: usize| fields.get(column).and_then(|f| f.parse::<f64>().ok()).filter(|v| v.is_finite());
        let (Some(x), Some(y), Some(elevation)) = (number(x), number(y), number(z)) else {
            return Err(input_error(
                "bad-survey-line",
                format!("line {line} of {name} does not give three finite numbers x y z"),
            )
            .with_cause(format!("it reads `{}`", shortened(&fields.join(" "))))
            .with_remedy("separate the columns by comma, semicolon or blanks, with a point as decimal sign"));
        };
        points.push(SurveyPoint { position: Vec2::new(x, y), elevation });
    }
    Ok(points)
}

/// The first characters of a line, for messages.
fn shortened(line: &str) -> String {
    const LENGTH: usize = 60;
    if line.chars().count() <= LENGTH {
        line.to_string()
    } else {
        line.chars().take(LENGTH).chain("...".chars()).collect()
    }
}

fn from_vector(path: &Path) -> Result<(Vec<SurveyPoint>, Option<SpatialRef>), Problem> {
    // The key takes no name of a layer.
    let remedy = "write the layer of the points to a file of its own with `ogr2ogr OUT FILE LAYER`";
    let alone = |problem: Problem| if problem.code == "several-layers" { problem.with_remedy(remedy) } else { problem };
    let file = vector::open(path, None).map_err(alone)?;
    let mut points = Vec::new();
    for feature in &file.features {
        let attribute = ELEVATION_NAMES.iter().find_map(|name| feature.number(name));
        for (position, height) in &feature.points {
            let Some(elevation) = height.or(attribute).filter(|z| z.is_finite()) else {
                return Err(input_error(
                    "no-elevation",
                    format!(
                        "feature {} of {} has neither a z coordinate nor an elevation attribute",
                        feature.number,
                        path.display()
                    ),
                )
                .with_remedy(format!(
                    "give the points a z coordinate or one of the attributes {}",
                    ELEVATION_NAMES.join(", ")
                )));
            };
            points.push(SurveyPoint { position: *position, elevation });
        }
    }
    Ok((points, file.crs))
}

/// Warns of elevations that Earth does not have.
fn doubtful(path: &Path, points: &[SurveyPoint]) -> Option<Problem> {
    let odd: Vec<&SurveyPoint> = points.iter().filter(|p| !PLAUSIBLE_ELEVATION.contains(&p.elevation)).collect();
    let first = odd.first()?;
    let message = format!(
        "{} has {} elevations outside {} to {} m, the first is {} m",
        path.display(),
        odd.len(),
        PLAUSIBLE_ELEVATION.start(),
        PLAUSIBLE_ELEVATION.end(),
        first.elevation
    );
    let problem = Problem::warning(ProblemKind::Input, "doubtful-elevation", "", message)
        .with_cause("a code for a missing value, perhaps, or another unit than metres");
    Some(problem.with_remedy("take these points out of the file, or correct them").with_at(first.position))
}

/// Every place once, the first point of a place winning; warns when elevations differ.
fn without_duplicates(path: &Path, points: Vec<SurveyPoint>) -> (Vec<SurveyPoint>, Option<Problem>) {
    let mut seen: HashMap<(u64, u64), f64> = HashMap::with_capacity(points.len());
    let mut kept = Vec::with_capacity(points.len());
    let mut contradictions: Vec<(Vec2, f64)> = Vec::new();
    for point in points {
        // Adding zero makes −0 and 0 the same key.
        let key = ((point.position.x + 0.0).to_bits(), (point.position.y + 0.0).to_bits());
        match seen.get(&key) {
            None => {
                seen.insert(key, point.elevation);
                kept.push(point);
            }
            Some(first) if (first - point.elevation).abs() > 0.0 => {
                contradictions.push((point.position, (first - point.elevation).abs()));
            }
            Some(_) => {}
        }
    }
    let Some(&(place, difference)) = contradictions.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return (kept, None);
    };
    let message = format!(
        "{} gives two elevations for the same place {} times, at most {difference:.2} m apart; the first one is taken",
        path.display(),
        contradictions.len()
    );
    (kept, Some(Problem::warning(ProblemKind::Input, "contradicting-points", "", message).with_at(place)))
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "made values are met exactly")]
mod tests {
    use super::*;
    use std::io::Write;

    fn survey_of(name: &str, content: &[u8]) -> Result<SurveyFile, Problem> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        read_survey(&path, 1e9)
    }

    #[test]
    fn text_in_every_shape_gives_the_same_points() {
        let expected = [
            SurveyPoint { position: Vec2::new(1.0, 2.0), elevation: 3.5 },
            SurveyPoint { position: Vec2::new(4.0, 5.0), elevation: -6.0 },
        ];
        for text in [
            "x,y,z\n1,2,3.5\n4,5,-6\n",
            "1;2;3.5\n4;5;-6",
            "  1 2\t3.5\n4   5 -6\n",
            "# s\nid,z,y,x\nA,3.5,2,1\nB,-6,5,4\n",
        ] {
            assert_eq!(survey_of("s.txt", text.as_bytes()).unwrap().points, expected, "{text}");
        }
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(b"x,y,z\n1,2,3.5\n4,5,-6\n").unwrap();
        assert_eq!(survey_of("s.csv.gz", &packed.finish().unwrap()).unwrap().points, expected);
    }

    #[test]
    fn points_of_a_vector_file_take_z_or_an_attribute() {
        let with_z = br#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[1,2,3.5]}}]}"#;
        assert_eq!(survey_of("s.geojson", with_z).unwrap().points[0].elevation, 3.5);
        let with_attribute = br#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"Height":7},"geometry":{"type":"Point","coordinates":[1,2]}}]}"#;
        assert_eq!(survey_of("s.geojson", with_attribute).unwrap().points[0].elevation, 7.0);
        let without = br#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[1,2]}}]}"#;
        assert_eq!(survey_of("s.geojson", without).err().unwrap().code, "no-elevation");
    }

    #[test]
    fn bad_lines_and_contradictions_are_located() {
        let problem = survey_of("s.txt", b"1 2 3\n4 five 6\n").err().unwrap();
        assert!(problem.code == "bad-survey-line" && problem.message.contains("line 2"), "{problem}");
        assert_eq!(survey_of("s.txt", b"1 2 nan\n").err().unwrap().code, "bad-survey-line");
        assert_eq!(survey_of("s.txt", b"\0\x01").err().unwrap().code, "not-a-survey");
        let file = survey_of("s.txt", b"0 0 1\n1 2 3\n1 2 3\n1 2 4.5\n").unwrap();
        assert_eq!(file.points.len(), 2);
        assert!(file.warnings[0].code == "contradicting-points" && file.warnings[0].at == Some(Vec2::new(1.0, 2.0)));
        assert!(file.warnings[0].message.contains("1.50 m"));
    }
}
