//! Series that are refused or doubted: rows, codes, dates, and what holds after the last row.

use super::*;

#[test]
fn faults_of_a_hydrograph_are_told_by_line() {
    let scene = Scene::sound();
    scene.write("q.csv", "t,q\n0,0\n0.5,a lot\n1,\n3,4\n");
    scene.assert_refused(
        4,
        &["not-a-number", "2 rows have no two numbers in", "line 3 (`0.5 | a lot`), line 4 (`1 | `)", "s.yaml:6:"],
    );
    scene.write("q.csv", "t,q\n0,0\n1,5\n0.5,3\n3,-4\n");
    scene.assert_refused(4, &["not-rising", "line 4", "negative-value", "line 5 (`-4`)"]);
    scene.write("q.csv", "t,q\n0,0\n1,1e30\n2,-1e10\n1e12,4\n");
    scene.assert_refused(
        4,
        &[
            "implausible-value",
            "2 rows have a discharge beyond 1e9 m3/s, in",
            "line 3 (`1e30`), line 4 (`-1e10`)",
            "one row has a time beyond 1e10 s, in",
            "line 5 (`1e12`)",
        ],
    );
    scene.write("q.csv", "t,q\n0.5,0\n1,5\n1.5,3\n");
    scene.assert_refused(
        4,
        &[
            "series-starts-late",
            "begins 30 s after",
            "series-ends-early",
            "ends at 90 s (line 4), before the run does at 120 s",
            "`after_end: hold`",
        ],
    );
    scene.write("q.csv", "0,0\n3,4\n");
    scene.assert_refused(4, &["no-header", "time_h,q_m3_s"]);
    scene.write("q.csv", "t,inflow\n0,0\n3,4\n");
    scene.assert_refused(4, &["missing-column", "no column `q`", "its columns are t, inflow"]);
    scene.write("q.csv", "t,q\n");
    scene.assert_refused(4, &["empty-table"]);
    std::fs::remove_file(scene.path("q.csv")).unwrap();
    scene.assert_refused(4, &["missing-file", "q.csv"]);
    scene.write("q.csv", "t,q\n0,0\n0.1,1\n0.2,1\n0.3,2\n0.4,2\n2,3\n");
    scene.assert_warned(&["series-gap", "from 24 s (line 6) to 120 s (line 7)", "a step of 6 s is usual"]);
    // Decimal commas between semicolons.
    scene.write("q.csv", "t;q\n0;0\n3;4,5\n");
    scene.assert_refused(4, &["not-a-number", "line 3 (`3 | 4,5`)"]);
}

#[test]
fn a_code_for_a_missing_level_is_refused() {
    let scene = Scene::with(&[("normal_depth: {slope: 0.04}", "stage: {series: stage.csv}")]);
    scene.write("stage.csv", "time_min,level_m\n0,3\n1,-9999\n2,3.1\n");
    scene.assert_refused(4, &["implausible-level", "one row has a level that is none on Earth", "line 3 (`-9999`)"]);
    // In the unit of the file.
    scene.write("stage.csv", "time_min,level_cm\n0,300\n1,2000000\n2,310\n");
    scene.assert_refused(4, &["implausible-level", "line 3 (`2000000`)"]);
    let scene = Scene::with(&[("normal_depth: {slope: 0.04}", "rating: {table: weir.csv}")]);
    scene.write("weir.csv", "level_m,discharge_m3_s\n-9999,0\n8,1\n");
    let place = "error[implausible-level] boundaries[1].rating.table (s.yaml:7:";
    scene.assert_refused(4, &[place, "one row has a level that is none on Earth, in", "line 2 (`-9999`)"]);
    scene.write("weir.csv", "level_m,discharge_m3_s\n2,0\n5,-9999\n8,1\n");
    scene
        .assert_refused(4, &["error[negative-value] boundaries[1].rating.table", "line 3 (`-9999`)", "missing values"]);
}

#[test]
fn rows_that_are_missing_and_times_in_another_unit_are_told() {
    let scene = Scene::sound();
    let row = |k: usize| format!("{},{}\n", 0.1 * k as f64, k % 5);
    let rows = |is_kept: fn(usize) -> bool| (0..25).filter(|k| is_kept(*k)).map(row).collect::<String>();
    scene.write("q.csv", &format!("t,q\n{}", rows(|k| !(4..12).contains(&k))));
    let place = "warning[series-gap] boundaries[0].discharge.series (s.yaml:6:";
    scene.assert_warned(&[place, "has a gap from 18 s (line 5) to 72 s (line 6), where a step of 6 s is usual"]);
    scene.write("q.csv", &format!("t,q\n{}", rows(|k| k != 4)));
    scene.assert_silent_on(&["series-gap"]);
    scene.write("q.csv", "t,q\n0,0\n30,12\n90,4\n130,4\n");
    let place = "warning[series-far-beyond] boundaries[0].discharge.series (s.yaml:6:";
    let texts = ["the run takes 1 of 4 rows", "is the unit of its times right? 130 is taken for 7800 s", "remedy"];
    scene.assert_warned(&[&[place][..], &texts].concat());
    scene.write("q.csv", "t,q\n0,0\n30,12\n39,4\n");
    scene.assert_silent_on(&["series-far-beyond"]);
}

#[test]
fn rain_below_0_is_told_in_the_unit_of_its_file() {
    let scene = Scene::with(&[("resolution: 5 m", "rain: {rate: {series: rain.csv}}\nresolution: 5 m")]);
    scene.write("rain.csv", "time_min,rain_mm_h\n0,5\n1,-20\n2,5\n");
    let place = "error[negative-value] rain.rate.series (s.yaml:8:";
    scene.assert_refused(4, &[place, "line 3 (`-20`)", "what the ground takes of the rain is `losses`"]);
}

#[test]
fn the_last_value_of_a_series_holds_on_where_the_scenario_says_so() {
    let held = ("time_unit: min}", "time_unit: min, after_end: hold}");
    let spring = (
        "resolution: 5 m",
        "sources: [{at: [1100, 2030], discharge: {series: s.csv, after_end: hold}}]\nresolution: 5 m",
    );
    let scene = Scene::with(&[held, spring]);
    scene.write("q.csv", "t,q\n0,0\n0.5,12\n1.5,4\n");
    scene.write("s.csv", "time_s,q_l_s\n0,100\n60,300\n");
    scene.assert_warned(&[
        "0 errors, 2 warnings",
        "series-held",
        "ends at 90 s (line 4), before the run does at 120 s; its last value holds on for 30 s",
        "ends at 60 s (line 3), before the run does at 120 s; its last value holds on for 60 s",
    ]);
    let (run, out) = scene.run();
    // 30 s of a triangle to 12, 60 s down to 4, 30 s of 4 m3/s; from the spring 60 s of 0.2 and 60 s of 0.3 m3/s.
    let wanted = 180.0 + 480.0 + 120.0 + 12.0 + 18.0;
    assert!((volume(&run, "in") / wanted - 1.0).abs() < 1e-9, "{} m3", volume(&run, "in"));
    let resolved = std::fs::read_to_string(out.join("scenario.resolved.yaml")).unwrap();
    assert_eq!(resolved.matches("after_end: hold").count(), 2, "{resolved}");
    // What comes before the first row, and what no rows are known of, is said nothing of by this key.
    scene.write("q.csv", "t,q\n0.5,12\n1.5,4\n");
    scene.assert_refused(4, &["series-starts-late", "series-held"]);
    let scene = Scene::with(&[("time_unit: min}", "time_unit: min, after_end: cycle}")]);
    scene.assert_refused(3, &["`cycle` is not a way on after the end of a series", "use one of hold", "s.yaml:6:"]);
}

#[test]
fn a_tide_by_dates_is_that_in_seconds() {
    let tide = ("discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}", "stage: {series: tide.csv}");
    let end = ("time: {end: 2 min}", "time: {end: 2 min, reference: \"2026-06-01 06:00:00\"}");
    let scene = Scene::with(&[tide, end]);
    let fields = |rows: &str| {
        scene.write("tide.csv", rows);
        let (run, out) = scene.run();
        assert!(volume(&run, "in") > 10.0, "{run:#}");
        let (fields, maps) = (Netcdf::read(&out.join("fields.nc")), Netcdf::read(&out.join("maps.nc")));
        let tables = std::fs::read(out.join("tables/boundaries.csv")).unwrap();
        std::fs::remove_dir_all(out).unwrap();
        let bits = |file: Netcdf| -> Vec<(String, Vec<u64>)> {
            let of = |(name, (_, values)): (String, (String, Vec<f64>))| {
                (name, values.iter().map(|v| v.to_bits()).collect())
            };
            file.variables.into_iter().map(of).collect()
        };
        (bits(fields), bits(maps), tables)
    };
    // From 30 s before the start on, when the run begins between two rows.
    let by_seconds = fields("time_s,level_m\n-30,11\n10,11.5\n61,12\n180,12.25\n");
    let dates = ["2026-06-01 05:59:30", "2026-06-01T08:00:10+02:00", "2026-06-01T06:01:01Z", "2026-06-01 06:03"];
    let levels = ["11", "11.5", "12", "12.25"];
    let rows: String = dates.iter().zip(levels).map(|(date, level)| format!("{date};{level}\n")).collect();
    assert!(
        fields(&format!("time;level_m\n{rows}")) == by_seconds,
        "fields, maps or the book of the boundaries differ"
    );
    let others = fields("time_s,level_m\n-30,11\n10,11.5\n62,12\n180,12.25\n");
    assert!(others != by_seconds, "a tide a second later is the same");
}

#[test]
fn faults_of_dates_are_told_all_at_once_by_line() {
    let bare = ("unit: m3/s, time_unit: min", "unit: m3/s");
    let scene = Scene::with(&[bare]);
    for (first, second) in [("2026-06-01 06:00:00", "2026-06-01 09:00:00"), ("2026-06-01", "2026-06-02")] {
        scene.write("q.csv", &format!("time,q\n{first},12\n{second},4\n"));
        let texts = ["dates-as-times", &format!("line 2 (`{first}`)"), "add `time.reference`", "`time_h`", "s.yaml:6:"];
        scene.assert_refused(4, &texts);
        scene.assert_silent_on(&["missing-unit"]);
    }
    let dated = ("time: {end: 2 min}", "time: {end: 2 min, reference: \"2026-06-01 06:00\"}");
    let scene = Scene::with(&[dated]);
    scene.write(
        "q.csv",
        "t,q\n2026-06-01 06:00,0\n2026-06-31 06:01,12\n01.06.2026 06:02,4\n180,4\n2026-06-01 06:04,a\n",
    );
    let place = "boundaries[0].discharge.series (s.yaml:6:";
    let texts = [
        "unit-beside-dates",
        "the unit `min`",
        "one row has no date that exists, or one in a form that is not read, in",
        "line 3 (`2026-06-31 06:01`)",
        "line 3: there is no such day",
        "ambiguous-date",
        "line 4 (`01.06.2026 06:02`)",
        "`2026-06-01T06:00:00Z`",
        "mixed-times",
        "line 5 (`180`)",
    ];
    scene.assert_refused(4, &[&[place, "5 errors"][..], &texts, &["line 6 (`2026-06-01 06:04 | a`)"]].concat());
    let scene = Scene::with(&[bare, dated]);
    scene.write("q.csv", "t,q\n2026-06-01 07:00,0\n2026-06-01 09:00,12\n");
    scene.assert_refused(
        4,
        &["series-starts-late", "begins 3600 s after the start of the run (line 2)", "`time.reference`"],
    );
    scene.write("q.csv", "t,q\n2026-06-01 05:00,0\n2026-06-01 06:00,12\n");
    scene.assert_refused(4, &["series-ends-early", "correct `time.reference`"]);
}
