use super::units::is_same;
use super::*;

#[test]
fn units_of_files_are_understood_in_many_spellings() {
    let mm_h = RainUnit::Intensity(1e-3 / 3600.0);
    for text in [
        "mm/h",
        "mm h-1",
        "mm hr-1",
        "mm/hr",
        "mm h^-1",
        "mm h**-1",
        "mm hour-1",
        "kg m-2 h-1",
        "mm / h",
        "mm.h-1",
        "mm*h-1",
        "kg/m2/h",
        "kg/m^2/hr",
        "kg m**-2 h**-1",
    ] {
        assert!(unit_of_file(text).is_some_and(|unit| is_same(unit, mm_h)), "{text}: {:?}", unit_of_file(text));
    }
    assert!(unit_of_file("kg m-2 s-1").is_some_and(|unit| is_same(unit, RainUnit::Intensity(1e-3))));
    for text in ["mm", "kg m-2"] {
        assert!(unit_of_file(text).is_some_and(|unit| is_same(unit, RainUnit::Depth(1e-3))), "{text}");
    }
    for text in [
        "dBZ",
        "",
        "K",
        "mm/fortnight",
        "kg",
        "mm h-1 m-2",
        "mm/h-1",
        "kg m2 h-1",
        "mm h-2",
        "mm h+1",
        "mm/5min",
        "mm -1",
    ] {
        assert_eq!(unit_of_file(text), None, "{text}");
    }
    for text in ["mm day", "mm h", "mm*hour", "mm.s", "kg m-2 s", "m d"] {
        assert!(unit_of_file(text).is_none() && times_time(text).is_some(), "{text}: {:?}", unit_of_file(text));
    }
    assert!(times_time("mm day").unwrap().contains("`mm day-1`"), "{:?}", times_time("mm day"));
    for text in ["mm", "mm h-1", "K day", "mm/5min", ""] {
        assert_eq!(times_time(text), None, "{text}");
    }
}

#[test]
fn a_time_is_the_beginning_or_the_end_of_its_interval() {
    let times = |times: &[f64]| Times { times: times.to_vec(), bounds: None };
    let of = |stamp| intervals(&times(&[0.0, 5.0, 15.0]), stamp, "x").unwrap();
    assert_eq!(of(None), [0.0..5.0, 5.0..15.0, 15.0..25.0]);
    assert_eq!(of(Some(Stamp::End)), [-5.0..0.0, 0.0..5.0, 5.0..15.0]);
    let code = |times: &[f64], bounds| intervals(&Times { times: times.to_vec(), bounds }, None, "x").unwrap_err().code;
    assert_eq!(code(&[0.0], None), "too-few-rasters");
    assert_eq!(code(&[0.0, 5.0, 5.0], None), "not-rising");
    assert_eq!(code(&[0.0, f64::NAN], None), "not-rising");
    assert_eq!(code(&[0.0, 5.0], Some(vec![0.0..6.0, 5.0..10.0])), "bad-bounds");
    assert_eq!(code(&[0.0, 5.0], Some(vec![0.0..5.0, 9.0..7.0])), "bad-bounds");
    let bounded = Times { times: vec![0.0, 5.0], bounds: Some(vec![0.0..5.0, 5.0..9.0]) };
    assert_eq!(intervals(&bounded, Some(Stamp::End), "x").unwrap_err().code, "stamp-beside-bounds");
    assert_eq!(intervals(&Times { times: vec![3.0], bounds: Some(vec![0.0..6.0]) }, None, "x").unwrap(), [0.0..6.0]);
}

#[test]
fn a_list_that_goes_on_far_beyond_the_rain_is_asked_about() {
    // Every five minutes for two hours, taken for hours.
    let every = |step: f64| (0..24).map(|k| step * f64::from(k)..step * f64::from(k + 1)).collect::<Vec<_>>();
    let problem = far_beyond(&every(5.0 * 3600.0), 7200.0, "x").unwrap();
    assert_eq!(
        (problem.code, problem.message.as_str()),
        (
            "series-far-beyond",
            "of x the run takes 1 of 24 rasters: the rain ends at 7200 s, the last raster at 432000 s, 60 times as late"
        )
    );
    assert!(far_beyond(&every(300.0), 7200.0, "x").is_none() && far_beyond(&every(300.0), 600.0, "x").is_none());
    assert!(far_beyond(&every(300.0), 0.0, "x").is_none());
}

#[test]
fn gaps_and_missing_ends_are_found() {
    let codes = |intervals: &[Range<f64>], until, has_bounds| -> Vec<&str> {
        coverage(intervals, until, has_bounds, "x").iter().map(|problem| problem.code).collect()
    };
    let regular = [0.0..5.0, 5.0..10.0, 10.0..15.0];
    assert!(codes(&regular, 15.0, false).is_empty());
    assert_eq!(codes(&regular, 16.0, false), ["series-ends-early"]);
    assert_eq!(codes(&[1.0..5.0, 5.0..10.0], 10.0, false), ["series-starts-late"]);
    assert_eq!(codes(&[0.0..5.0, 5.0..15.0, 15.0..20.0], 20.0, false), ["series-gap"]);
    assert!(codes(&[0.0..5.0, 5.0..15.0, 15.0..20.0], 20.0, true).is_empty());
    assert_eq!(codes(&[0.0..5.0, 6.0..11.0], 11.0, true), ["series-gap"]);
    // Beyond the end of the rain a gap does not matter.
    assert!(codes(&[0.0..5.0, 6.0..11.0], 5.0, true).is_empty());
}
