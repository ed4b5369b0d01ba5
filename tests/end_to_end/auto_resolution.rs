//! `resolution: auto`: the lengths that the program chooses, what it says of them, and what it refuses.

use crate::floodsim;
use crate::levels::Scene;

#[test]
fn auto_chooses_lengths_says_why_and_writes_them_back() {
    let scene = Scene::new();
    let run = scene.run("auto", &["resolution=auto"]);
    let choice = &run["resolution"];
    let finest = choice["finest_m"].as_f64().unwrap();
    assert!([5.0, 10.0, 15.0, 20.0].contains(&finest), "{choice}");
    assert!(choice["because"].as_array().unwrap().len() >= 2, "{choice}");
    let (expected, actual) =
        (choice["expected_evaluations"].as_f64().unwrap(), run["particle_evaluations"].as_f64().unwrap());
    println!("{finest} m, expected evaluations over those of the run: {}", expected / actual);
    assert!((0.4..2.5).contains(&(expected / actual)), "{expected} of {actual}");
    let resolved = std::fs::read_to_string(scene.path("auto/scenario.resolved.yaml")).unwrap();
    assert!(!resolved.contains("auto:") && resolved.contains(&format!("{finest} m")), "{resolved}");
    // The written scenario gives the same run.
    let arguments = ["run", "auto/scenario.resolved.yaml", "--out", "again", "--quiet"];
    assert_eq!(floodsim(scene.folder.path(), &arguments).code, 0);
    let [one, other] = ["auto", "again"].map(|out| scene.maps(out));
    assert_eq!(one.values("max_depth"), other.values("max_depth"));
}

#[test]
fn a_wanted_error_gives_finer_cells_and_a_budget_wider_ones() {
    let scene = Scene::new();
    let plan = |resolution: &str| {
        let set = format!("resolution={resolution}");
        let answer = floodsim(scene.folder.path(), &["plan", "s.yaml", "--json", "--set", &set]);
        assert_eq!(answer.code, 0, "{}{}", answer.stdout, answer.stderr);
        let plan: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
        (plan["choice"]["finest_m"].as_f64().unwrap(), plan)
    };
    let (exact, told) = plan("{auto: {error: 1 mm}}");
    assert!((exact - 5.0).abs() < 1e-9, "the pixels of the terrain: {exact}");
    assert!(told["problems"].to_string().contains("auto-misses-error"), "{}", told["problems"]);
    let (rough, _) = plan("{auto: {error: 5 m}}");
    assert!(rough > exact, "{rough}");
    let (small, told) = plan("{auto: {memory: 8 MB}}");
    assert!(small > exact, "{small}");
    assert!(told["choice"]["because"].to_string().contains("more memory"), "{told}");
    let (most, _) = plan("{auto: {cpu: 10 h}}");
    assert!((most - 5.0).abs() < 1e-9, "{most}");
}

#[test]
fn what_does_not_go_with_auto_is_refused_with_a_remedy() {
    let scene = Scene::new();
    let said = |arguments: &[&str]| {
        let answer = floodsim(scene.folder.path(), arguments);
        (answer.code, answer.stdout + &answer.stderr)
    };
    let (code, text) = said(&["plan", "s.yaml", "--set", "resolution={auto: {cpu: 0.001 ms}}"]);
    assert_eq!(code, 5, "{text}");
    assert!(text.contains("auto-beyond-limit") && text.contains("raise the limits of `resolution.auto`"), "{text}");
    let moving = ["check", "s.yaml", "--set", "resolution=auto", "--set", "numerics.motion=lagrangian"];
    let (code, text) = said(&moving);
    assert!(code == 3 && text.contains("levels-for-eulerian"), "{text}");
    let (code, text) = said(&["check", "s.yaml", "--set", "resolution={auto: {cpu: 1 h}, coarsest: 40 m}"]);
    assert!(code == 3 && text.contains("`auto` chooses the lengths"), "{text}");
    let (code, text) = said(&["check", "s.yaml", "--set", "resolution=auto"]);
    assert_eq!(code, 0, "{text}");
    scene.run("first", &["resolution=5 m", "time.end=5 s"]);
    let later = ["plan", "s.yaml", "--set", "resolution=auto", "--set", "initial=[{fields: first/fields.nc}]"];
    let (code, text) = said(&later);
    assert!(code == 3 && text.contains("lengths are not chosen for a run that goes on"), "{text}");
}
