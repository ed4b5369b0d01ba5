//! A preset becomes the single choices that it stands for, as if they were written beside it.
//!
//! It is taken apart in the tree, before anything is read: so a key that is written wins, and a combination that no core has is
//! refused by the same rules as any other. What a preset says has the place of the preset.

use super::choices::Choice;
use super::methods::Preset;
use super::tree::{Entry, Node, Value};

/// Adds the choices of `numerics.preset` to `numerics`, except the keys that are there. An unknown name is left to the reader.
pub fn expand(root: &mut Node) {
    let Some(numerics) = root.get_mut("numerics") else { return };
    let Some(named) = numerics.get("preset").cloned() else { return };
    let Value::Text(name) = &named.value else { return };
    let Some((_, preset)) = Preset::choices().into_iter().find(|(known, _)| known == name) else { return };
    let choices = preset.keys().into_iter().filter(|(key, _)| numerics.get(key).is_none_or(is_empty));
    let added: Vec<Entry> = choices
        .map(|(key, value)| Entry {
            name: key.to_owned(),
            place: named.place.clone(),
            node: Node { value: Value::Text(value.to_owned()), ..named.clone() },
        })
        .collect();
    if let Value::Section(entries) = &mut numerics.value {
        entries.retain(|entry| !added.iter().any(|new| new.name == entry.name));
        entries.extend(added);
    }
}

fn is_empty(node: &Node) -> bool {
    node.value == Value::Empty
}
