//! Coordinate reference systems: the one of the run, those of the files, and the way from one to the other.

use gdal::spatial_ref::{AxisMappingStrategy, CoordTransform, SpatialRef};

use super::{capture, horizontal_part};
use crate::math::Vec2;
use crate::output::OutputCrs;

/// The coordinate reference system of a run while its inputs are opened.
#[derive(Clone, Debug)]
pub enum Crs {
    /// Plain metres without a place on Earth.
    Local,
    /// A projected system in metres.
    Projected(SpatialRef),
}

/// Why a system cannot be that of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CrsProblem {
    /// Its coordinates are degrees.
    Geographic,
    /// Its coordinates are lengths of another unit.
    NotMetres(String),
    /// It is neither.
    NotProjected,
}

impl Crs {
    /// What the writers need.
    pub fn to_output(&self) -> OutputCrs {
        match self {
            Crs::Local => OutputCrs::Local,
            Crs::Projected(crs) => OutputCrs::Projected { wkt2: wkt2(crs), authority: authority(crs) },
        }
    }

    /// A name for messages.
    pub fn describe(&self) -> String {
        match self {
            Crs::Local => "local metres".to_string(),
            Crs::Projected(crs) => describe(crs),
        }
    }
}

/// A system from what a user writes: `EPSG:27572`, WKT, a PROJ string.
///
/// # Errors
/// What PROJ says.
pub fn spatial_ref(definition: &str) -> Result<SpatialRef, String> {
    let (result, messages) = capture(|| SpatialRef::from_definition(definition));
    match result {
        Ok(mut crs) => {
            crs.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
            Ok(crs)
        }
        Err(error) if messages.is_empty() => Err(error.to_string()),
        Err(_) => Err(messages.join("; ")),
    }
}

/// Whether a system is projected and in metres.
///
/// # Errors
/// Why not.
pub fn is_metric(crs: &SpatialRef) -> Result<(), CrsProblem> {
    if crs.is_geographic() {
        return Err(CrsProblem::Geographic);
    }
    if !crs.is_projected() && !crs.is_local() && !horizontal_part(crs).is_projected() {
        return Err(CrsProblem::NotProjected);
    }
    let metres = crs.linear_units();
    if (metres - 1.0).abs() > 1e-9 {
        return Err(CrsProblem::NotMetres(crs.linear_units_name().unwrap_or_else(|| format!("{metres} m"))));
    }
    Ok(())
}

/// The system of a run from that of a file: its horizontal part, since elevations are treated by unit and offset alone.
pub fn run_crs_of(crs: &SpatialRef) -> Crs {
    Crs::Projected(horizontal_part(crs))
}

/// Whether two systems give the same horizontal coordinates.
pub fn same_horizontal(one: &SpatialRef, other: &SpatialRef) -> bool {
    let (one, other) = (horizontal_part(one), horizontal_part(other));
    one == other || matches!((authority(&one), authority(&other)), (Some(a), Some(b)) if a == b)
}

/// Name and code of a system, such as `EPSG:27572 (NTF (Paris) / Lambert zone II)`.
pub fn describe(crs: &SpatialRef) -> String {
    match (authority(crs), crs.name()) {
        (Some(code), Some(name)) => format!("{code} ({name})"),
        (Some(code), None) => code,
        (None, Some(name)) => name,
        (None, None) => "an unnamed system".to_string(),
    }
}

fn authority(crs: &SpatialRef) -> Option<String> {
    crs.authority().ok()
}

/// WKT2:2019 text.
fn wkt2(crs: &SpatialRef) -> String {
    const OPTION: &str = "OSR_WKT_FORMAT";
    let _ = gdal::config::set_thread_local_config_option(OPTION, "WKT2_2019");
    let text = crs.to_wkt().unwrap_or_default();
    let _ = gdal::config::clear_thread_local_config_option(OPTION);
    text
}

/// The UTM zone of a place given in degrees, as an EPSG code: a metric system to suggest.
pub fn suggested_utm(longitude: f64, latitude: f64) -> String {
    let zone = (((longitude + 180.0) / 6.0).floor() as i32).rem_euclid(60) + 1;
    format!("EPSG:{}", if latitude >= 0.0 { 32600 } else { 32700 } + zone)
}

/// Points of one system in another.
///
/// # Errors
/// What PROJ says.
pub fn transform(points: &mut [Vec2], from: &SpatialRef, to: &SpatialRef) -> Result<(), String> {
    let (from, to) = (horizontal_part(from), horizontal_part(to));
    let mut x: Vec<f64> = points.iter().map(|p| p.x).collect();
    let mut y: Vec<f64> = points.iter().map(|p| p.y).collect();
    let (result, messages) = capture(|| CoordTransform::new(&from, &to)?.transform_coords(&mut x, &mut y, &mut []));
    if let Err(error) = result {
        return Err(if messages.is_empty() { error.to_string() } else { messages.join("; ") });
    }
    for (point, (x, y)) in points.iter_mut().zip(x.into_iter().zip(y)) {
        *point = Vec2::new(x, y);
    }
    if points.iter().any(|p| !p.x.is_finite() || !p.y.is_finite()) {
        return Err("some coordinates have no image in the other system".to_string());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compound_and_plain_systems_share_their_horizontal_part() {
        let plain = spatial_ref("EPSG:25832").unwrap();
        let compound = spatial_ref("EPSG:25832+5783").unwrap();
        assert!(same_horizontal(&plain, &compound));
        assert!(!same_horizontal(&plain, &spatial_ref("EPSG:25833").unwrap()));
    }

    #[test]
    fn degrees_and_feet_are_told_from_metres() {
        assert_eq!(is_metric(&spatial_ref("EPSG:4326").unwrap()), Err(CrsProblem::Geographic));
        assert!(matches!(is_metric(&spatial_ref("EPSG:2225").unwrap()), Err(CrsProblem::NotMetres(_))));
        assert_eq!(is_metric(&spatial_ref("EPSG:27572").unwrap()), Ok(()));
        assert!(spatial_ref("EPSG:99").unwrap_err().contains("not found"));
    }

    #[test]
    fn the_output_carries_wkt2_and_the_code() {
        let OutputCrs::Projected { wkt2, authority } = Crs::Projected(spatial_ref("EPSG:27572").unwrap()).to_output()
        else {
            panic!("a projected system was given");
        };
        assert!(wkt2.starts_with("PROJCRS["), "{wkt2}");
        assert_eq!(authority.as_deref(), Some("EPSG:27572"));
    }

    #[test]
    fn utm_zone_and_transform_agree_with_known_places() {
        assert_eq!(suggested_utm(6.7565, 43.5122), "EPSG:32632");
        assert_eq!(suggested_utm(-58.4, -34.6), "EPSG:32721");
        // The dam of Malpasset in Lambert zone II (README of the data set), to the metres of its published degrees.
        let mut dam = [Vec2::new(6.7565, 43.5122)];
        transform(&mut dam, &spatial_ref("EPSG:4326").unwrap(), &spatial_ref("EPSG:27572").unwrap()).unwrap();
        assert!((dam[0] - Vec2::new(957_760.0, 1_844_500.0)).norm() < 500.0, "{dam:?}");
    }
}
