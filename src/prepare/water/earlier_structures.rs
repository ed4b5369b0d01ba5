//! What stood in an earlier run against what stands here: walls, buildings and breaklines.
//!
//! A wall has no height on the lattice, so that no map of the earlier run shows it: what it held back would burst without a word.
//! The earlier run wrote down its scenario beside its fields, and the checksums of its files.

use std::path::{Path, PathBuf};

use crate::checksum;
use crate::error::{Problem, ProblemKind};
use crate::plain_file;
use crate::scenario::Scenario;
use crate::scenario::tree::{Node, Value, parse};

/// Something built, by the words that tell it apart whatever folder its file lies in.
struct Built {
    words: String,
    file: PathBuf,
}

/// Tells what the `scenario.resolved.yaml` beside the fields of an earlier run has and this scenario has not, and the other way
/// round; nothing where there is no such file.
pub fn other_structures(scenario: &Scenario, fields: &Path) -> Option<Problem> {
    let file = fields.with_file_name("scenario.resolved.yaml");
    let there = all_built(&plain_file::read_to_string(&file).ok()?, &file)?;
    let mut here = all_built(&scenario.to_yaml(), &scenario.file)?;
    let checksums = checksums(&fields.with_file_name("run.json"));
    let (mut gone, mut changed) = (Vec::new(), Vec::new());
    for built in there {
        let Some(same) = here.iter().position(|other| other.words == built.words) else {
            gone.push(built.words);
            continue;
        };
        let same = here.swap_remove(same);
        let name = built.file.file_name();
        let earlier = checksums.iter().find(|(path, _)| path.file_name() == name).map(|(_, checksum)| checksum);
        if earlier.zip(checksum::of_file(&same.file).ok()).is_some_and(|(earlier, (_, now))| *earlier != now) {
            changed.push(built.words);
        }
    }
    let added: Vec<String> = here.into_iter().map(|built| built.words).collect();
    let parts =
        [("there and not here", gone), ("here and not there", added), ("with another content of its file", changed)];
    let reported: Vec<String> = parts
        .into_iter()
        .filter(|(_, words)| !words.is_empty())
        .map(|(which, words)| format!("{which}: {}", words.join("; ")))
        .collect();
    (!reported.is_empty()).then(|| {
        let message = format!("the earlier run had other structures, says {}; {}", file.display(), reported.join("; "));
        Problem::warning(ProblemKind::Input, "other-structures", "", message)
            .with_cause(
                "what a wall, a levee or a building held back there flows here, or is held back here and flowed there",
            )
            .with_remedy("nothing, if it is meant; otherwise take the walls, buildings and breaklines of that run")
    })
}

/// The walls, buildings and breaklines of a resolved scenario; none where it cannot be read.
fn all_built(text: &str, file: &Path) -> Option<Vec<Built>> {
    let (root, _) = parse(text, file).ok()?;
    let at = |section: &str, key: &str| root.get(section).and_then(|section| section.get(key));
    let mut all = Vec::new();
    for (kind, node) in [
        ("wall", at("structures", "walls")),
        ("buildings", at("structures", "buildings")),
        ("breakline", at("terrain", "breaklines")),
    ] {
        match node.map(|node| (&node.value, node)) {
            Some((Value::List(items), _)) => all.extend(items.iter().map(|item| built(kind, item))),
            Some((Value::Section(_), node)) => all.push(built(kind, node)),
            _ => {}
        }
    }
    Some(all)
}

/// One of them: its kind, the name of its file and layer, and its other keys.
fn built(kind: &str, node: &Node) -> Built {
    let mut built = Built { words: kind.to_owned(), file: PathBuf::new() };
    let Value::Section(entries) = &node.value else { return built };
    for entry in entries {
        let Value::Text(text) = &entry.node.value else { continue };
        if entry.name == "lines" || entry.name == "polygons" {
            let name = text.rsplit(['/', '\\']).next().unwrap_or(text);
            built.words += &format!(" {name}");
            let whole = PathBuf::from(text);
            built.file = match text.rsplit_once(':') {
                Some((file, _)) if !whole.exists() => file.into(),
                _ => whole,
            };
        } else {
            built.words += &format!(", {} {text}", entry.name);
        }
    }
    built
}

/// The input files of a run and their checksums, as its `run.json` has them; none where there is none.
fn checksums(run: &Path) -> Vec<(PathBuf, String)> {
    let text = plain_file::read_to_string(run).unwrap_or_default();
    let run: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let of = |input: &serde_json::Value| Some((input["path"].as_str()?.into(), input["sha256"].as_str()?.to_owned()));
    run["inputs"].as_array().into_iter().flatten().filter_map(of).collect()
}
