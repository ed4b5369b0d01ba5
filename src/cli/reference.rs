//! `docs/scenario-format.md`: every key of a scenario, made from the JSON Schema, which comes from the declarations of the sections.
//!
//! The comment of a key reads `Meaning; DEFAULT when absent. Codes: a, b.`, of which the last two parts may be missing.

use std::fmt::Write;

use serde_json::Value;

/// What stands before the sections.
const INTRODUCTION: &str = include_str!("scenario_format.md");

/// A section of the scenario and the paths of keys at which it stands.
struct Section<'a> {
    schema: &'a Value,
    paths: Vec<String>,
}

/// The page of a JSON Schema.
pub fn page(schema: &Value) -> String {
    let mut sections = vec![Section { schema, paths: vec!["scenario".to_owned()] }];
    collect(schema, schema, "", &mut sections);
    let mut page = INTRODUCTION.to_owned();
    for section in &sections {
        write_section(section, schema, &sections, &mut page);
    }
    page
}

/// The keys of a section in the order in which they are declared.
fn keys(section: &Value) -> impl Iterator<Item = &str> {
    section["x-keys"].as_array().into_iter().flatten().filter_map(Value::as_str)
}

/// Adds the sections below one, each once, with all paths that lead to it.
fn collect<'a>(section: &'a Value, root: &'a Value, path: &str, sections: &mut Vec<Section<'a>>) {
    for key in keys(section) {
        let property = &section["properties"][key];
        let mut found = Vec::new();
        sections_of(property, root, "", &mut found);
        for (child, list) in found {
            let dot = if path.is_empty() { "" } else { "." };
            let path = format!("{path}{dot}{key}{list}");
            match sections.iter_mut().find(|known| std::ptr::eq(known.schema, child)) {
                Some(known) => known.paths.push(path),
                None => {
                    sections.push(Section { schema: child, paths: vec![path.clone()] });
                    collect(child, root, &path, sections);
                }
            }
        }
    }
}

/// The sections that a property may be, each with `[]` where it stands in a list.
fn sections_of<'a>(
    property: &'a Value,
    root: &'a Value,
    list: &'static str,
    found: &mut Vec<(&'a Value, &'static str)>,
) {
    if let Some(target) = definition(property, root) {
        if target.get("properties").is_some() {
            found.push((target, list));
        } else {
            sections_of(target, root, list, found);
        }
    }
    for part in ["anyOf", "allOf"].iter().filter_map(|kind| property[kind].as_array()).flatten() {
        sections_of(part, root, list, found);
    }
    if let Some(items) = property.get("items") {
        sections_of(items, root, "[]", found);
    }
}

fn definition<'a>(property: &Value, root: &'a Value) -> Option<&'a Value> {
    let name = property["$ref"].as_str()?.rsplit('/').next()?;
    root["definitions"].get(name)
}

fn write_section(section: &Section, root: &Value, all: &[Section], page: &mut String) {
    let (schema, path) = (section.schema, &section.paths[0]);
    let _ = write!(page, "\n## {path}\n\n{}\n", description(schema));
    if let [_, others @ ..] = &section.paths[..]
        && !others.is_empty()
    {
        let others: Vec<String> = others.iter().map(|path| format!("`{path}`")).collect();
        let _ = write!(page, "\nAlso at {}.\n", others.join(", "));
    }
    if let Some(example) = schema["x-example"].as_str().filter(|example| *example != "{...}") {
        let key = path.rsplit('.').next().unwrap_or(path);
        let (before, after) = if key.ends_with("[]") { ("[", "]") } else { ("", "") };
        let _ = write!(page, "\n```yaml\n{}: {before}{example}{after}\n```\n", key.trim_end_matches("[]"));
    }
    page.push_str("\n| key | meaning | type | default | codes |\n| --- | --- | --- | --- | --- |\n");
    let required: Vec<&str> = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    for key in keys(schema) {
        let property = &schema["properties"][key];
        let text = description(property);
        let Comment { meaning, default, codes } = comment(&text);
        let default = if required.contains(&key) { "required" } else { default };
        let codes: Vec<String> = codes.iter().map(|code| format!("`{code}`")).collect();
        let kind = kind(property, root, all);
        let _ = writeln!(page, "| `{key}` | {meaning} | {kind} | {default} | {} |", codes.join(", "));
    }
}

/// The comment of a section or a key, on one line.
fn description(of: &Value) -> String {
    of["description"].as_str().unwrap_or_default().replace('\n', " ")
}

/// The parts of the comment of a key.
#[derive(Debug, PartialEq)]
struct Comment<'a> {
    meaning: &'a str,
    default: &'a str,
    codes: Vec<&'a str>,
}

fn comment(text: &str) -> Comment<'_> {
    let (text, codes) = text.split_once(" Codes: ").unwrap_or((text, ""));
    let text = text.trim_end_matches('.');
    let codes = codes.trim_end_matches('.').split(", ").filter(|code| !code.is_empty()).collect();
    match text.rsplit_once("; ").and_then(|(meaning, last)| Some((meaning, last.strip_suffix(" when absent")?))) {
        Some((meaning, default)) => Comment { meaning, default: default.trim_end_matches(','), codes },
        None => Comment { meaning: text, default: "", codes },
    }
}

/// What may stand under a key, in words.
fn kind(property: &Value, root: &Value, all: &[Section]) -> String {
    let of = |part: &Value| kind(part, root, all);
    if let Some(target) = definition(property, root) {
        if let Some(section) = all.iter().find(|section| std::ptr::eq(section.schema, target)) {
            let anchor: String = section.paths[0]
                .chars()
                .filter(|letter| letter.is_ascii_alphanumeric() || "_-".contains(*letter))
                .collect();
            return format!("[section](#{anchor})");
        }
        return of(target);
    }
    let is_null = |part: &&Value| part["type"] == "null";
    if let Some(parts) = property["anyOf"].as_array() {
        let parts: Vec<String> = parts.iter().filter(|part| !is_null(part)).map(of).collect();
        return parts.join(" or ");
    }
    if let Some([part]) = property["allOf"].as_array().map(Vec::as_slice) {
        return of(part);
    }
    if let Some(items) = property.get("items") {
        return format!("list: {}", of(items));
    }
    if let Some(names) = property["enum"].as_array() {
        return names.iter().filter_map(Value::as_str).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    }
    if let Some(value) = property.get("const") {
        return format!("`{}`", value.as_str().map_or_else(|| value.to_string(), str::to_owned));
    }
    match (property["x-kind"].as_str(), &property["type"]) {
        (Some(kind), _) => kind.to_owned(),
        (None, Value::Array(types)) if types.iter().any(|one| one == "boolean") => "`true`, `false`".to_owned(),
        (None, one) if one == "boolean" => "`true`, `false`".to_owned(),
        _ => "text".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::problems;

    fn schema() -> Value {
        crate::cli::documents::schema_of_scenario()
    }

    #[test]
    fn the_document_is_that_of_the_schema() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scenario-format.md");
        let remedy = "write it anew: floodsim schema --markdown > docs/scenario-format.md";
        assert!(std::fs::read_to_string(file).unwrap() == page(&schema()), "{remedy}");
    }

    #[test]
    fn every_key_has_a_meaning_and_its_codes_are_known() {
        let schema = schema();
        let mut sections = vec![Section { schema: &schema, paths: vec!["scenario".to_owned()] }];
        collect(&schema, &schema, "", &mut sections);
        let mut count = 0;
        for section in &sections {
            assert_eq!(keys(section.schema).count(), section.schema["properties"].as_object().unwrap().len());
            for key in keys(section.schema) {
                let text = description(&section.schema["properties"][key]);
                let found = comment(&text);
                assert!(found.meaning.len() > 4, "{}: {key} has no meaning: {text}", section.paths[0]);
                for code in found.codes {
                    assert!(
                        problems::find(code).is_some(),
                        "{}: {key} names `{code}`, which is no code",
                        section.paths[0]
                    );
                }
                count += 1;
            }
        }
        assert!(count > 120, "{count} keys were found");
    }

    #[test]
    fn comments_have_meaning_default_and_codes() {
        let of = |meaning, default, codes: &[&'static str]| Comment { meaning, default, codes: codes.to_vec() };
        assert_eq!(comment("A file."), of("A file", "", &[]));
        assert_eq!(comment("A width; narrow; a cell when absent."), of("A width; narrow", "a cell", &[]));
        assert_eq!(comment("A file; none when absent. Codes: a, b-c."), of("A file", "none", &["a", "b-c"]));
    }
}
