//! What the program writes about itself: starter scenario, JSON Schema, completions, manual.

use std::io::Write;
use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;

use super::args::Arguments;
use super::{print, reference};
use crate::error::Error;
use crate::scenario::sections::ScenarioFile;

const STARTER: &str = include_str!("starter.yaml");

/// Writes a commented scenario to a new file.
pub fn write_starter(file: &Path) -> Result<(), Error> {
    let failed = |cause: String| Error::Output { path: file.to_owned(), cause };
    let opened = std::fs::File::create_new(file);
    let mut opened = opened.map_err(|cause| match cause.kind() {
        std::io::ErrorKind::AlreadyExists => failed("it exists already; give another name".to_owned()),
        _ => failed(cause.to_string()),
    })?;
    opened.write_all(STARTER.as_bytes()).map_err(|cause| failed(cause.to_string()))?;
    let name = file.display();
    print(&format!("wrote {name}; put in your files, then:  floodsim check {name}\n"))
}

/// Prints the JSON Schema of a scenario, or the page that is made from it.
pub fn schema(is_page: bool) -> Result<(), Error> {
    let schema = schema_of_scenario();
    print(&if is_page { reference::page(&schema) } else { format!("{schema:#}\n") })
}

/// The JSON Schema of a scenario.
pub(super) fn schema_of_scenario() -> serde_json::Value {
    let generator = schemars::generate::SchemaSettings::draft07().into_generator();
    let mut schema = generator.into_root_schema_for::<ScenarioFile>();
    // What one key asks of another is no part of the declarations of keys.
    schema.insert("anyOf".to_owned(), serde_json::json!([{"required": ["terrain"]}, {"required": ["channels"]}]));
    schema.to_value()
}

/// Prints the completions of a shell.
pub fn completions(shell: Shell) -> Result<(), Error> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "floodsim", &mut text);
    print(&String::from_utf8_lossy(&text))
}

/// Prints the manual page.
pub fn manual() -> Result<(), Error> {
    let mut text = Vec::new();
    clap_mangen::Man::new(Arguments::command())
        .render(&mut text)
        .map_err(|cause| Error::Internal(cause.to_string()))?;
    print(&String::from_utf8_lossy(&text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_starter_is_a_valid_scenario() {
        let loaded = crate::scenario::resolve(STARTER, Path::new("scenario.yaml"), &[]).unwrap();
        assert!(loaded.warnings.is_empty());
    }

    #[test]
    fn the_commented_lines_of_the_starter_are_valid_too() {
        // Lines that begin with the mark are keys that are switched off; the other comments are prose.
        let switch_on = |line: &str| format!("{}\n", line.strip_prefix("#| ").unwrap_or(line));
        let switched_on: String = STARTER.lines().map(switch_on).collect();
        assert!(switched_on.contains("\nlimits:"), "the last optional section is not switched on");
        crate::scenario::resolve(&switched_on, Path::new("scenario.yaml"), &[]).unwrap();
    }
}
