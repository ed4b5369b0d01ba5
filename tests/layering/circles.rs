//! No circle of files: whoever changes one file reads those that it imports, and none of them leads back.
//!
//! A file may import from the folder that it stands in (`mod.rs`) and from its own submodules; those are not counted.

use std::collections::{BTreeMap, BTreeSet};

use super::sources;

/// A file by the modules that lead to it, the package first.
type Module = Vec<String>;

/// The modules of a file, given by its path below `src`.
fn module_of(relative: &std::path::Path) -> Module {
    let mut parts: Module = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    let package = if parts[0] == "core" { parts.remove(0) } else { "floodsim".to_owned() };
    if let Some(last) = parts.pop() {
        let name = last.trim_end_matches(".rs");
        if !["mod", "lib", "main"].contains(&name) {
            parts.push(name.to_owned());
        }
    }
    parts.insert(0, package);
    parts
}

/// The code of a file without its comments and without its tests.
fn code_of(text: &str) -> String {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join(" ")
}

/// The paths of an import such as `super::{a::b, c}`.
fn expanded(import: &str) -> Vec<String> {
    let Some((before, inside)) = import.split_once('{') else { return vec![import.trim().to_owned()] };
    let inside = inside.trim_end().strip_suffix('}').unwrap_or(inside);
    let (mut paths, mut depth, mut from) = (Vec::new(), 0_i32, 0);
    for (place, letter) in inside.char_indices().chain([(inside.len(), ',')]) {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        if letter == ',' && depth == 0 {
            paths.extend(expanded(&format!("{}{}", before.trim(), inside[from..place].trim())));
            from = place + 1;
        }
    }
    paths
}

/// Every path from `super` or `crate` in some code, in imports and elsewhere.
fn paths_in(code: &str) -> Vec<String> {
    let imports = code.split("use ").skip(1).filter_map(|rest| rest.split_once(';')).map(|(import, _)| import);
    let inline = code.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
    let is_own = |path: &String| path.starts_with("super::") || path.starts_with("crate::");
    imports.flat_map(expanded).chain(inline.map(str::to_owned)).filter(is_own).collect()
}

/// The file that a path from a module leads to, if there is one.
fn target(path: &str, from: &Module, files: &BTreeSet<Module>) -> Option<Module> {
    let mut steps = path.split("::").peekable();
    let mut module = match steps.next() {
        Some("crate") => from[..1].to_vec(),
        _ => from[..from.len() - 1].to_vec(),
    };
    while steps.next_if_eq(&"super").is_some() {
        module.pop();
    }
    for step in steps {
        let next: Module = module.iter().cloned().chain([step.trim().to_owned()]).collect();
        if !files.contains(&next) {
            break;
        }
        module = next;
    }
    files.contains(&module).then_some(module)
}

/// The files that can be reached from a file by its imports.
fn reached(from: &Module, imports: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<Module> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from.clone()]);
    while let Some(module) = open.pop() {
        for next in imports.get(&module).into_iter().flatten() {
            if found.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    found
}

#[test]
fn no_file_leads_back_to_itself() {
    let files: BTreeMap<Module, String> = sources()
        .into_iter()
        .map(|(_, relative, text)| (module_of(&relative), text))
        .filter(|(module, _)| !module.iter().any(|part| part.contains("tests")))
        .collect();
    let known: BTreeSet<Module> = files.keys().cloned().collect();
    let imports: BTreeMap<Module, BTreeSet<Module>> = files
        .iter()
        .map(|(module, text)| {
            let is_of_others = |other: &Module| !module.starts_with(other) && !other.starts_with(module);
            let found = paths_in(&code_of(text)).into_iter().filter_map(|path| target(&path, module, &known));
            (module.clone(), found.filter(is_of_others).collect())
        })
        .collect();
    assert!(imports.values().map(BTreeSet::len).sum::<usize>() > 500, "the imports were not found");
    let circles: BTreeSet<String> = imports
        .keys()
        .filter(|module| reached(module, &imports).contains(*module))
        .map(|module| module.join("::"))
        .collect();
    assert!(circles.is_empty(), "files that lead back to themselves: {circles:?}");
}

#[test]
fn paths_are_found_in_imports_of_all_forms() {
    let code = "use super::{a::{b, c as d}, e}; use crate::f; fn g() { super::h::i(); }";
    let expected = ["super::a::b", "super::a::c as d", "super::e", "crate::f", "crate::f", "super::h::i"];
    let found = paths_in(code);
    for path in expected {
        assert!(found.iter().any(|found| found == path), "{path} is not among {found:?}");
    }
    let files: BTreeSet<Module> =
        [vec!["floodsim"], vec!["floodsim", "a"], vec!["floodsim", "a", "b"], vec!["floodsim", "f"]]
            .map(|parts| parts.into_iter().map(str::to_owned).collect())
            .into();
    let from: Module = ["floodsim", "a", "b"].map(str::to_owned).into();
    assert_eq!(target("crate::f::Item", &from, &files).unwrap().join("::"), "floodsim::f");
    assert_eq!(target("super::Item", &from, &files).unwrap().join("::"), "floodsim::a");
}
