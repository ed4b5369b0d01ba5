//! Files that are no scenario: broken, too large, of another encoding, missing, with a bad date.

use super::*;

#[test]
fn broken_yaml_is_refused_with_its_place() {
    assert_change_refused("{end: 4000 s}", "{end: 4000 s", &["error[syntax] (s.yaml:", "this is not valid YAML"]);
    assert_change_refused("title: Test", "title: \"Test", &["this is not valid YAML"]);
    assert_change_refused("title: Test", "\ttitle: Test", &["this is not valid YAML"]);
    assert_refused(format!("{GOOD}---\n{GOOD}").as_bytes(), &["this is not valid YAML"]);
}

#[test]
fn a_yaml_bomb_ends_at_once_with_a_plain_message() {
    let mut bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n".to_owned();
    for level in 1..10 {
        let aliases = vec![format!("*a{}", level - 1); 10].join(", ");
        bomb += &format!("a{level}: &a{level} [{aliases}]\n");
    }
    assert_refused(
        bomb.as_bytes(),
        &["error[too-complex] (s.yaml:", "too large or too deeply nested", "without aliases"],
    );
}

#[test]
fn a_hundred_thousand_brackets_end_at_once() {
    assert_refused("[".repeat(100_000).as_bytes(), &["error[too-complex] (s.yaml:1:", "deeply nested"]);
    assert_refused("{a: ".repeat(100_000).as_bytes(), &["error[too-complex] (s.yaml:1:", "deeply nested"]);
    assert_refused("- ".repeat(100_000).as_bytes(), &["error[too-complex] (s.yaml:1:", "deeply nested"]);
}

#[test]
fn a_file_over_a_mebibyte_is_refused() {
    let text = format!("{GOOD}#{}\n", "x".repeat(1 << 20));
    assert_refused(text.as_bytes(), &["error[too-large]", "larger than 1 MiB"]);
}

#[test]
fn a_file_that_is_not_utf8_is_refused_with_its_place() {
    let latin = GOOD.replace("Test", "Gr\u{fc}n").into_bytes();
    let latin: Vec<u8> = String::from_utf8(latin).unwrap().chars().map(|c| c as u8).collect();
    assert_refused(&latin, &["error[encoding] (s.yaml:2:10)", "not UTF-8"]);
}

#[test]
fn a_missing_scenario_and_a_folder_are_refused() {
    let folder = TempDir::new().unwrap();
    std::fs::create_dir(folder.path().join("case")).unwrap();
    std::fs::write(folder.path().join("case/scenario.yaml"), GOOD).unwrap();
    let missing = floodsim(folder.path(), &["check", "nothing.yaml"]);
    assert_eq!(missing.code, 3);
    assert!(missing.stdout.contains("the scenario file `nothing.yaml` cannot be read"), "{}", missing.stdout);
    let is_folder = floodsim(folder.path(), &["check", "case"]);
    assert_eq!(is_folder.code, 3);
    assert!(is_folder.stdout.contains("did you mean `case/scenario.yaml`?"), "{}", is_folder.stdout);
    assert!(missing.stdout.contains("error[missing-file]") && is_folder.stdout.contains("error[folder]"));
    let in_a_file = floodsim(folder.path(), &["check", "case/scenario.yaml/s.yaml"]);
    assert!(in_a_file.code == 3 && in_a_file.stdout.contains("error[unreadable-file]"), "{}", in_a_file.stdout);
}

#[test]
fn a_bad_date_is_refused() {
    assert_change_refused(
        "end: 4000 s",
        "end: 4000 s, reference: 2.12.1959",
        &["error[date] time.reference", "dates are read as year, month, day", "write it as \"2026-06-01 06:00:00\""],
    );
    // In a year that no series and no NetCDF file of the calendar `standard` can have.
    for (date, cause) in
        [("1342-07-21 12:00", "it lies before 1582-10-15"), ("0000-01-01", "the calendar begins with the year 1")]
    {
        let changed = format!("end: 4000 s, reference: \"{date}\"");
        assert_change_refused("end: 4000 s", &changed, &["error[date] time.reference", cause, "400 years later"]);
    }
    for (date, cause) in [
        ("2016-12-31 23:59:60", "it is a leap second"),
        ("2026-06-01 06:00 CEST", "no offset from UTC"),
        ("2026-02-29", "there is no such day"),
        ("2026-06-01 24:01", "a day has no such time"),
    ] {
        let changed = format!("end: 4000 s, reference: \"{date}\"");
        assert_change_refused("end: 4000 s", &changed, &["error[date] time.reference", cause, "such as `+02:00`"]);
    }
}
