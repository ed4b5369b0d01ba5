use super::*;

fn tree(text: &str) -> Node {
    parse(text, Path::new("s.yaml")).unwrap().0
}

#[track_caller]
fn line_and_column(node: &Node) -> (usize, usize) {
    let place = node.place.as_ref().unwrap();
    (place.line, place.column)
}

#[test]
fn values_know_their_key_and_place() {
    let root = tree("title: no\ninitial:\n  - {reservoir: a.geojson, level: 100 m}\n");
    assert_eq!(root.get("title").unwrap().value, Value::Text("no".into()));
    let Value::List(items) = &root.get("initial").unwrap().value else { panic!("not a list") };
    let level = items[0].get("level").unwrap();
    assert_eq!(level.key, "initial[0].level");
    assert_eq!(line_and_column(level), (3, 35));
    assert_eq!(level.value, Value::Text("100 m".into()));
}

#[test]
fn numbers_and_words_become_text() {
    for (yaml, text) in
        [("0.033", "0.033"), ("-5", "-5"), ("true", "true"), ("yes", "yes"), (".nan", ".nan"), ("1e3", "1000")]
    {
        assert_eq!(tree(&format!("a: {yaml}")).get("a").unwrap().value, Value::Text(text.into()), "{yaml}");
    }
    assert_eq!(tree("a:").get("a").unwrap().value, Value::Empty);
}

#[test]
fn a_duplicate_key_is_found_and_the_rest_still_read() {
    let (root, problems) = parse("a: 1\nb: 2\na: 3\n", Path::new("s.yaml")).unwrap();
    assert_eq!(root.get("a").unwrap().value, Value::Text("1".into()));
    assert_eq!(problems[0].code, "duplicate-key");
    assert_eq!(problems[0].place.as_ref().unwrap().line, 3);
    assert!(problems[0].message.contains("`a`"));
}

#[test]
fn hostile_files_end_at_once() {
    let mut bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n".to_owned();
    for level in 1..10 {
        let aliases = vec![format!("*a{}", level - 1); 10].join(", ");
        bomb += &format!("a{level}: &a{level} [{aliases}]\n");
    }
    for text in [bomb, "[".repeat(100_000), "- ".repeat(100_000), "a: {".repeat(10_000)] {
        let problem = parse(&text, Path::new("s.yaml")).unwrap_err();
        assert_eq!(problem.code, "too-complex", "{problem}");
        assert!(problem.place.is_some(), "{problem}");
        assert!(problem.to_string().len() < 1000, "{problem}");
    }
}

#[test]
fn a_variable_without_quotes_within_brackets_is_told() {
    for (text, column) in [("a: {b: ${X}/c.tif}", 9), ("a: [${X}/c.tif]", 6), ("\u{e4}: {b: \"${X}\", c: ${X}}", 20)] {
        let problem = parse(text, Path::new("s.yaml")).unwrap_err();
        assert_eq!(problem.place.as_ref().map(|place| place.column), Some(column), "{text}: {problem}");
        assert!(problem.remedy.as_ref().is_some_and(|remedy| remedy.contains("quotes, as in")), "{text}: {problem}");
    }
    let other = parse("a: {b: \"${X}\"", Path::new("s.yaml")).unwrap_err();
    assert!(other.remedy.is_some_and(|remedy| remedy.contains("indentation")));
}

#[test]
fn an_override_replaces_or_adds_a_value() {
    let mut root = tree("initial:\n  - {level: 100 m}\ntime: {end: 1 s}\n");
    apply_override(&mut root, "initial[0].level=95 m").unwrap();
    apply_override(&mut root, "numerics.cfl=0.3").unwrap();
    apply_override(&mut root, "time={end: 2 s}").unwrap();
    let Value::List(items) = &root.get("initial").unwrap().value else { panic!("not a list") };
    let level = items[0].get("level").unwrap();
    assert_eq!((&level.value, level.key.as_str()), (&Value::Text("95 m".into()), "initial[0].level"));
    assert_eq!(root.get("numerics").unwrap().get("cfl").unwrap().key, "numerics.cfl");
    assert_eq!(root.get("time").unwrap().get("end").unwrap().value, Value::Text("2 s".into()));
}

#[test]
fn a_bad_override_is_refused_with_a_reason() {
    let mut root = tree("initial:\n  - {level: 100 m}\ntime: {end: 1 s}\nterrain: dem.asc\n");
    for (text, reason) in [
        ("nothing", "key.path=value"),
        ("=5", "`` is not a key"),
        ("a..b=1", "`` is not a key"),
        ("initial[x]=1", "`initial[x]` is not a key"),
        ("initial[3].level=1 m", "has 1 entries"),
        ("time[0]=1", "`time` is not a list"),
        ("time.end.late=1", "`time.end` is not a section"),
        ("initial.level=1", "`initial` is not a section"),
        ("terrain.follow_banks=false", "`terrain: {layers: [{raster: FILE}]}`"),
        ("time.end=[", "not valid YAML"),
    ] {
        let message = apply_override(&mut root, text).unwrap_err();
        assert!(message.contains(reason), "{text}: {message}");
    }
}

proptest::proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "[ -~\n\u{e4}]{0,200}") {
        let _ = parse(&text, Path::new("s.yaml"));
    }
}
