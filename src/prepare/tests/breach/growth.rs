//! Growth of a breach by a series.

use super::*;

/// The dam with its growth by a series.
fn growing(text: &str) -> Prepared {
    prepared(|scene, breach| {
        scene.write("growth.csv", text);
        let column = || ColumnUnit { name: None, unit: None };
        let file = sourced("breach.growth.share", scene.path("growth.csv"));
        (breach.law, breach.duration) = (GrowthLaw::Series, None);
        breach.share = Some(TableFile { file, columns: [column(), column()], after_end: None });
    })
}

#[test]
fn growth_by_a_series_is_that_of_the_file() {
    let prepared = growing("time_s,share\n0,0\n2,0.1\n8,1\n");
    assert_eq!(prepared.problems, []);
    assert!(prepared.inputs.iter().any(|file| file.path.ends_with("growth.csv")));
    let breach = prepared.scene().forcing.breach.clone().unwrap();
    assert!((breach.share(1.0) - 0.05).abs() < 1e-15 && (breach.share(5.0) - 0.55).abs() < 1e-15);
    assert!((breach.duration - 8.0).abs() <= 0.0);
    // In per cent and minutes; it still grows when the run ends after 10 s.
    let slow = growing("time_min,share_%\n0,0\n0.5,100\n");
    assert_eq!(slow.problems.iter().map(|problem| problem.code).collect::<Vec<_>>(), ["breach-unfinished"]);
    assert!((slow.scene().forcing.breach.clone().unwrap().share(15.0) - 0.5).abs() < 1e-15);
    // Rows that are missing.
    let rows = |is_kept: fn(i32) -> bool| {
        (0..=20).filter(move |k| is_kept(*k)).map(|k| format!("{},{}\n", 0.4 * f64::from(k), f64::from(k) / 20.0))
    };
    let kept: String = rows(|k| !(5..9).contains(&k)).collect();
    let gap = growing(&format!("time_s,share\n{kept}"));
    let found: Vec<_> =
        gap.problems.iter().map(|problem| (problem.code, problem.key.as_str(), problem.severity)).collect();
    assert_eq!(found, [("series-gap", "breach.growth.share", Severity::Warning)]);
    assert!(gap.scene().forcing.breach.is_some());
}

#[test]
fn growth_that_does_not_rise_from_0_to_1_is_refused_with_its_line() {
    for (text, code, words) in [
        ("time_s,share\n0,0\n2,0.5\n3,0.4\n4,1\n", "falling-share", "line 4 (`0.4 after 0.5`)"),
        ("time_s,share\n0,0.1\n4,1\n", "growth-start", "a share of 0.1 at 0 s (line 2)"),
        ("time_s,share\n1,0\n4,1\n", "growth-start", "a share of 0 at 1 s (line 2)"),
        ("time_s,share\n0,0\n4,100\n", "growth-end", "a share of 100 (line 3)"),
        ("time_s,share\n0,0\n0,1\n", "not-rising", "line 3"),
        ("time_s,share\n0,0\n", "short-table", "fewer than two rows"),
        ("time_s,share\n0,0\nend,1\n", "not-a-number", "line 3"),
        ("time,share\n0,0\n3,1\n", "missing-unit", "`time`"),
    ] {
        let prepared = growing(text);
        let found = prepared.problems.iter().find(|problem| problem.code == code);
        let found = found.unwrap_or_else(|| panic!("no {code}: {:?}", prepared.problems));
        assert!(found.severity == Severity::Error && found.message.contains(words), "{found}");
        assert!(found.key == "breach.growth.share" && found.remedy.is_some(), "{found}");
        assert!(prepared.scene().forcing.breach.is_none());
    }
}
