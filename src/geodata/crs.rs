//! Coordinate reference systems: the one of the run, those of the files, and the way from one to the other.

use gdal::spatial_ref::{AxisMappingStrategy, CoordTransform, SpatialRef};

use super::{capture, horizontal_part};
use crate::math::Vec2;

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
    /// Its text as WKT2:2019, and its code where it has one; none of plain metres.
    pub fn written(&self) -> Option<(String, Option<String>)> {
        match self {
            Crs::Local => None,
            Crs::Projected(crs) => Some((wkt2(crs), authority(crs))),
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

/// How long 1 m on the ground is on the map at a place, to the east and to the north of the map; none where the system has no place on
/// Earth there. By the ellipsoid of GRS 80, from which others differ by some 1e-4.
pub fn map_scales(crs: &SpatialRef, place: Vec2) -> Option<[f64; 2]> {
    const SEMI_MAJOR: f64 = 6_378_137.0;
    const ECCENTRICITY_SQUARED: f64 = 0.006_694_38;
    /// Half of the length that is compared (m).
    const HALF: f64 = 500.0;
    let degrees = spatial_ref("EPSG:4326").ok()?;
    let scale = |step: Vec2| {
        let mut ends = [place - step, place + step];
        transform(&mut ends, crs, &degrees).ok()?;
        let [longitudes, latitudes] = [ends.map(|end| end.x.to_radians()), ends.map(|end| end.y.to_radians())];
        let (sine, cosine) = (0.5 * (latitudes[0] + latitudes[1])).sin_cos();
        let shrink = 1.0 - ECCENTRICITY_SQUARED * sine * sine;
        let meridian = SEMI_MAJOR * (1.0 - ECCENTRICITY_SQUARED) / (shrink * shrink.sqrt());
        let parallel = SEMI_MAJOR / shrink.sqrt() * cosine;
        let ground = (meridian * (latitudes[1] - latitudes[0])).hypot(parallel * (longitudes[1] - longitudes[0]));
        Some(2.0 * HALF / ground).filter(|scale| scale.is_finite())
    };
    Some([scale(Vec2::new(HALF, 0.0))?, scale(Vec2::new(0.0, HALF))?])
}

/// The name of the vertical datum of a system, where it states one.
pub fn vertical_datum(crs: &SpatialRef) -> Option<String> {
    crs.get_attr_value("VERT_DATUM", 0).ok().flatten()
}

/// Whether a system states that its heights are depths, and count downwards.
pub fn vertical_points_down(crs: &SpatialRef) -> bool {
    crs.get_attr_value("VERT_CS|AXIS", 1).ok().flatten().is_some_and(|way| way.eq_ignore_ascii_case("down"))
}

/// The name of the vertical unit of a system and how many metres it has, where it states one.
pub fn vertical_unit(crs: &SpatialRef) -> Option<(String, f64)> {
    let text = |child| crs.get_attr_value("VERT_CS|UNIT", child).ok().flatten();
    let factor = text(1)?.parse().ok().filter(|factor: &f64| factor.is_finite() && *factor > 0.0)?;
    Some((text(0)?, factor))
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
    fn a_system_is_written_as_wkt2_with_its_code() {
        assert_eq!(Crs::Local.written(), None);
        let (wkt2, authority) = Crs::Projected(spatial_ref("EPSG:27572").unwrap()).written().unwrap();
        assert!(wkt2.starts_with("PROJCRS["), "{wkt2}");
        assert_eq!(authority.as_deref(), Some("EPSG:27572"));
    }

    #[test]
    fn the_scale_of_a_map_is_that_of_its_projection() {
        let scales = |code: &str, longitude: f64, latitude: f64| {
            let crs = spatial_ref(code).unwrap();
            let mut place = [Vec2::new(longitude, latitude)];
            transform(&mut place, &spatial_ref("EPSG:4326").unwrap(), &crs).unwrap();
            map_scales(&crs, place[0]).unwrap()
        };
        // 0.9996 on the central meridian; to the north of 47.8 degrees 1/cos of it, by the sphere that Web Mercator takes for the ellipsoid.
        assert!(scales("EPSG:25832", 9.0, 47.8).iter().all(|scale| (scale - 0.9996).abs() < 1e-6));
        let mercator = scales("EPSG:3857", 11.5, 47.8);
        assert!((mercator[0] - 1.486).abs() < 2e-3 && (mercator[1] - 1.491).abs() < 2e-3, "{mercator:?}");
        assert!(scales("EPSG:3857", 11.5, 0.0).iter().all(|scale| (scale - 1.0).abs() < 7e-3));
    }

    #[test]
    fn a_vertical_datum_is_named_where_there_is_one() {
        let datum = |code: &str| vertical_datum(&spatial_ref(code).unwrap());
        assert_eq!(datum("EPSG:25832"), None);
        assert!(datum("EPSG:25832+5783").is_some() && datum("EPSG:25832+5783") != datum("EPSG:25832+7837"));
    }

    #[test]
    fn depths_are_told_from_heights() {
        let down = |code: &str| vertical_points_down(&spatial_ref(code).unwrap());
        assert!(down("EPSG:25832+5715") && !down("EPSG:25832+7837") && !down("EPSG:25832"));
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
