//! The attributes of a CF grid mapping for a projected system.
//!
//! Reads the PROJJSON that GDAL derives from the WKT. A method for which CF has no name gives none, and the WKT alone
//! carries the system. Reference: `CF2023`, appendix F.
//!
//! CF has no scale factor for the conformal conic. A system with one parallel and a scale factor k₀ below 1 (the French
//! Lambert zones) is the same projection as one with two parallels at which the scale is 1; they are where
//!
//! ```text
//! k(φ) = k₀ (m₀/m) (t/t₀)ⁿ = 1,   m = cos φ / √(1 − e² sin² φ),   t = tan(π/4 − φ/2) ((1 + e sin φ)/(1 − e sin φ))^(e/2),   n = sin φ₀
//! ```
//!
//! Reference: `Snyder1987`, equations 15-1 to 15-11 and 14-15.

use netcdf::AttributeValue;
use serde_json::Value;

type Attributes = Vec<(&'static str, AttributeValue)>;

/// The CF attributes of the horizontal projected system in a PROJJSON text; none when CF has no name for its method.
pub(super) fn cf_attributes(projjson: &str) -> Option<Attributes> {
    let root: Value = serde_json::from_str(projjson).ok()?;
    let crs = horizontal(&root);
    let base = crs.get("base_crs")?;
    let datum = base.get("datum").or_else(|| base.get("datum_ensemble"))?;
    let ellipsoid = Ellipsoid::read(datum.get("ellipsoid")?)?;
    let conversion = Conversion { value: crs.get("conversion")? };
    let mut attributes = method_attributes(&conversion, &ellipsoid)?;
    let meridian = datum.get("prime_meridian");
    let name = |value: Option<&Value>, default: &str| {
        AttributeValue::from(value.and_then(|v| v.get("name")).and_then(Value::as_str).unwrap_or(default))
    };
    attributes.extend([
        ("semi_major_axis", AttributeValue::from(ellipsoid.semi_major)),
        ("inverse_flattening", AttributeValue::from(ellipsoid.inverse_flattening)),
        ("reference_ellipsoid_name", name(datum.get("ellipsoid"), "unknown")),
        ("longitude_of_prime_meridian", meridian.and_then(|m| angle(m.get("longitude")?, None)).unwrap_or(0.0).into()),
        ("prime_meridian_name", name(meridian, "Greenwich")),
        ("geographic_crs_name", name(Some(base), "unknown")),
        ("horizontal_datum_name", name(Some(datum), "unknown")),
        ("projected_crs_name", name(Some(crs), "unknown")),
    ]);
    Some(attributes)
}

/// The horizontal part of a compound or bound system.
fn horizontal(crs: &Value) -> &Value {
    let inner = crs.get("source_crs").or_else(|| crs.get("components").and_then(|components| components.get(0)));
    inner.map_or(crs, horizontal)
}

struct Ellipsoid {
    semi_major: f64,
    /// 0 for a sphere, as CF has it.
    inverse_flattening: f64,
}

impl Ellipsoid {
    fn read(value: &Value) -> Option<Self> {
        let length = |key: &str| {
            let entry = value.get(key)?;
            entry.as_f64().or_else(|| entry.get("value")?.as_f64())
        };
        let semi_major = length("semi_major_axis").or_else(|| length("radius"))?;
        let flattening_of =
            |semi_minor: f64| if semi_major > semi_minor { semi_major / (semi_major - semi_minor) } else { 0.0 };
        let inverse_flattening = length("inverse_flattening").or_else(|| length("semi_minor_axis").map(flattening_of));
        Some(Ellipsoid { semi_major, inverse_flattening: inverse_flattening.unwrap_or(0.0) })
    }

    fn eccentricity(&self) -> f64 {
        if self.inverse_flattening > 0.0 {
            let flattening = 1.0 / self.inverse_flattening;
            (flattening * (2.0 - flattening)).sqrt()
        } else {
            0.0
        }
    }
}

struct Conversion<'a> {
    value: &'a Value,
}

impl Conversion<'_> {
    fn method(&self) -> &str {
        self.value.get("method").and_then(|method| method.get("name")).and_then(Value::as_str).unwrap_or_default()
    }

    /// The parameter with the first of the names that is there; angles in degrees.
    fn parameter(&self, names: &[&str]) -> Option<f64> {
        let parameters = self.value.get("parameters")?.as_array()?;
        let has_name =
            |parameter: &&Value| parameter.get("name").and_then(Value::as_str).is_some_and(|n| names.contains(&n));
        let parameter = parameters.iter().find(has_name)?;
        angle(parameter.get("value")?, parameter.get("unit"))
    }
}

/// A number, converted to degrees when its unit is another angle.
fn angle(value: &Value, unit: Option<&Value>) -> Option<f64> {
    if let Some(inner) = value.get("value") {
        return angle(inner, value.get("unit"));
    }
    let number = value.as_f64()?;
    match unit {
        Some(unit) if unit.get("type").and_then(Value::as_str) == Some("AngularUnit") => {
            Some((number * unit.get("conversion_factor")?.as_f64()?).to_degrees())
        }
        _ => Some(number),
    }
}

fn method_attributes(conversion: &Conversion<'_>, ellipsoid: &Ellipsoid) -> Option<Attributes> {
    let get = |names: &[&str]| conversion.parameter(names);
    let latitude = get(&["Latitude of natural origin", "Latitude of false origin", "Latitude of projection centre"]);
    let longitude = get(&[
        "Longitude of natural origin",
        "Longitude of false origin",
        "Longitude of projection centre",
        "Longitude of origin",
    ])?;
    let scale =
        get(&["Scale factor at natural origin", "Scale factor on initial line", "Scale factor at projection centre"]);
    let first_parallel = get(&["Latitude of 1st standard parallel", "Latitude of standard parallel"]);
    let both_parallels = || Some(vec![first_parallel?, get(&["Latitude of 2nd standard parallel"])?]);
    let (name, specific): (&str, Vec<(&'static str, AttributeValue)>) = match conversion.method() {
        "Transverse Mercator" => (
            "transverse_mercator",
            vec![
                ("scale_factor_at_central_meridian", scale?.into()),
                ("longitude_of_central_meridian", longitude.into()),
                ("latitude_of_projection_origin", latitude?.into()),
            ],
        ),
        "Lambert Conic Conformal (2SP)" => ("lambert_conformal_conic", conic(both_parallels()?, longitude, latitude?)),
        "Lambert Conic Conformal (1SP)" => {
            let parallels = parallels_of_unit_scale(latitude?, scale?, ellipsoid)?;
            ("lambert_conformal_conic", conic(parallels, longitude, latitude?))
        }
        "Albers Equal Area" => ("albers_conical_equal_area", conic(both_parallels()?, longitude, latitude?)),
        "Lambert Azimuthal Equal Area" => (
            "lambert_azimuthal_equal_area",
            vec![
                ("longitude_of_projection_origin", longitude.into()),
                ("latitude_of_projection_origin", latitude?.into()),
            ],
        ),
        "Hotine Oblique Mercator (variant B)" => {
            let azimuth = get(&["Azimuth of initial line", "Azimuth at projection centre"])?;
            let skew = get(&["Angle from Rectified to Skew Grid"])?;
            if (azimuth - skew).abs() > 1e-9 {
                return None; // The axes are turned against the grid of CF's definition.
            }
            let azimuth_names = ["azimuth_of_central_line", "azimuth"]; // CF 1.11, and what its checker asks for.
            let mut specific: Vec<_> = azimuth_names.map(|name| (name, azimuth.into())).into();
            specific.extend([
                ("latitude_of_projection_origin", latitude?.into()),
                ("longitude_of_projection_origin", longitude.into()),
                ("scale_factor_at_projection_origin", scale?.into()),
            ]);
            ("oblique_mercator", specific)
        }
        "Polar Stereographic (variant A)" => (
            "polar_stereographic",
            vec![
                ("straight_vertical_longitude_from_pole", longitude.into()),
                ("latitude_of_projection_origin", latitude?.into()),
                ("scale_factor_at_projection_origin", scale?.into()),
            ],
        ),
        "Polar Stereographic (variant B)" => (
            "polar_stereographic",
            vec![
                ("straight_vertical_longitude_from_pole", longitude.into()),
                ("latitude_of_projection_origin", 90.0_f64.copysign(first_parallel?).into()),
                ("standard_parallel", first_parallel?.into()),
            ],
        ),
        "Mercator (variant A)" => (
            "mercator",
            vec![
                ("longitude_of_projection_origin", longitude.into()),
                ("scale_factor_at_projection_origin", scale?.into()),
            ],
        ),
        "Mercator (variant B)" => (
            "mercator",
            vec![("longitude_of_projection_origin", longitude.into()), ("standard_parallel", first_parallel?.into())],
        ),
        _ => return None,
    };
    let mut attributes: Attributes = vec![("grid_mapping_name", name.into())];
    attributes.extend(specific);
    let easting = get(&["False easting", "Easting at false origin", "Easting at projection centre"])?;
    let northing = get(&["False northing", "Northing at false origin", "Northing at projection centre"])?;
    attributes.extend([("false_easting", easting.into()), ("false_northing", northing.into())]);
    Some(attributes)
}

fn conic(parallels: Vec<f64>, longitude: f64, latitude: f64) -> Attributes {
    vec![
        ("standard_parallel", parallels.into()),
        ("longitude_of_central_meridian", longitude.into()),
        ("latitude_of_projection_origin", latitude.into()),
    ]
}

/// Latitudes (degrees) at which a conformal conic with scale `scale` at `origin` (degrees) has scale 1.
fn parallels_of_unit_scale(origin: f64, scale: f64, ellipsoid: &Ellipsoid) -> Option<Vec<f64>> {
    if (scale - 1.0).abs() < 1e-12 {
        return Some(vec![origin]);
    }
    if scale > 1.0 {
        return None;
    }
    let e = ellipsoid.eccentricity();
    let m = |phi: f64| phi.cos() / (1.0 - (e * phi.sin()).powi(2)).sqrt();
    let t = |phi: f64| {
        (std::f64::consts::FRAC_PI_4 - 0.5 * phi).tan() * ((1.0 + e * phi.sin()) / (1.0 - e * phi.sin())).powf(0.5 * e)
    };
    let phi_0 = origin.to_radians();
    let scale_at = |phi: f64| scale * m(phi_0) / m(phi) * (t(phi) / t(phi_0)).powf(phi_0.sin());
    let crossing = |reach: f64| {
        let (mut inside, mut outside) = (phi_0, phi_0 + reach.to_radians());
        if scale_at(outside) < 1.0 {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (inside + outside);
            if scale_at(middle) < 1.0 { inside = middle } else { outside = middle }
        }
        Some(inside.to_degrees())
    };
    Some(vec![crossing(-15.0)?, crossing(15.0)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use gdal::spatial_ref::SpatialRef;

    fn attributes_of(epsg: u32) -> Option<Attributes> {
        cf_attributes(&SpatialRef::from_epsg(epsg).unwrap().to_projjson().unwrap())
    }

    fn number(attributes: &Attributes, name: &str) -> f64 {
        match attributes.iter().find(|(key, _)| *key == name).unwrap_or_else(|| panic!("no {name}")).1 {
            AttributeValue::Double(value) => value,
            ref other => panic!("{name} is {other:?}"),
        }
    }

    #[test]
    fn national_grids_have_their_projections() {
        for (epsg, name) in [
            (32632, "transverse_mercator"),
            (25832, "transverse_mercator"),
            (27700, "transverse_mercator"),
            (2154, "lambert_conformal_conic"),
            (27572, "lambert_conformal_conic"),
            (3035, "lambert_azimuthal_equal_area"),
            (2056, "oblique_mercator"),
            (5070, "albers_conical_equal_area"),
            (3031, "polar_stereographic"),
            (7415, ""), // Dutch: oblique stereographic, compound
            (5514, ""), // Krovak
        ] {
            let found = attributes_of(epsg).map(|attributes| attributes[0].1.clone());
            assert_eq!(found, (!name.is_empty()).then(|| AttributeValue::from(name)), "EPSG:{epsg}");
        }
    }

    #[test]
    fn grads_and_paris_become_degrees() {
        let attributes = attributes_of(27572).unwrap();
        assert!((number(&attributes, "latitude_of_projection_origin") - 46.8).abs() < 1e-9, "52 grad");
        assert!((number(&attributes, "longitude_of_prime_meridian") - 2.337_229_17).abs() < 1e-8);
        assert!((number(&attributes, "false_northing") - 2_200_000.0).abs() < 1e-9);
    }

    #[test]
    fn scale_factor_becomes_two_parallels() {
        // The French national institute gives 45° 53' 56.108" and 47° 41' 45.652" as the parallels of Lambert zone II.
        let clarke = Ellipsoid { semi_major: 6_378_249.2, inverse_flattening: 293.466_021_293_626_5 };
        let parallels = parallels_of_unit_scale(46.8, 0.999_877_42, &clarke).unwrap();
        let expected = [45.0 + 53.0 / 60.0 + 56.108 / 3600.0, 47.0 + 41.0 / 60.0 + 45.652 / 3600.0];
        for (found, expected) in parallels.iter().zip(expected) {
            // One digit of the last place of the published values, and of the rounded scale factor: 0.03 seconds of arc.
            assert!((found - expected).abs() < 1e-5, "{found} instead of {expected}");
        }
    }
}
