//! `roughness`.

use crate::scenario::fields::{InputFile, Manning, Quantity, VectorFile};
use crate::scenario::model::{Roughness, Scenario};
use crate::scenario::read::{Reader, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, file, vector};

section! {
    /// Roughness of the ground.
    RoughnessSection, example "{manning: 0.033}", check check_roughness {
        /// Manning's n, everywhere.
        manning: Option<Quantity<Manning>>,
        /// Raster of n, or of classes when there is a table.
        raster: Option<InputFile>,
        /// CSV with the columns class, name, n.
        table: Option<InputFile>,
        /// Manning's n where the raster gives none; that is an error when absent.
        default: Option<Quantity<Manning>>,
        /// Polygons with an attribute `n`, which win over all else.
        polygons: Option<VectorFile>,
    }
}

/// Refuses what does not go together, and warns of a roughness that is possible, but hardly meant.
fn check_roughness(node: &Node, reader: &mut Reader) -> Option<()> {
    if let Some(manning) = node.get("manning")
        && let Value::Text(text) = &manning.value
        && text.parse::<f64>().is_ok_and(|n| n > 0.0 && n < 0.005)
    {
        let message = format!("a Manning roughness of `{text}` is smoother than glass");
        reader.warning(manning, "roughness", message, "natural ground has 0.02 to 0.15, smooth concrete 0.012");
    }
    let kind = reader.exactly_one(node, &["manning", "raster"])?;
    let foreign: &[&str] = if kind == "manning" { &["table", "default"] } else { &[] };
    let mut is_fit = true;
    for name in foreign {
        if let Some(value) = node.get(name) {
            let remedy = "take it out, or give a `raster` in place of `manning`";
            reader.error(value, "conflict", format!("`{name}` goes with `raster`, not with `manning`"), remedy);
            is_fit = false;
        }
    }
    is_fit.then_some(())
}

pub(super) fn resolved(section: RoughnessSection) -> Roughness {
    Roughness {
        manning: section.manning.or(section.default).map(|n| n.value()),
        raster: section.raster.map(|file| file.0),
        table: section.table.map(|file| file.0),
        polygons: section.polygons.map(|file| file.0),
    }
}

pub(super) fn written(scenario: &Scenario) -> Section {
    let rough = &scenario.roughness;
    let of_rest = if rough.raster.is_some() { "default" } else { "manning" };
    Section::default()
        .with_some("raster", rough.raster.as_ref().map(|path| file(&path.value)))
        .with_some("table", rough.table.as_ref().map(|path| file(&path.value)))
        .with_some(of_rest, rough.manning)
        .with_some("polygons", rough.polygons.as_ref().map(vector))
}
