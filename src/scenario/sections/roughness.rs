//! `roughness`.

use crate::scenario::fields::{InputFile, Manning, Quantity, RoughnessFactor, VectorFile};
use crate::scenario::model::{Roughness, Scenario};
use crate::scenario::read::{Reader, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, file, vector};

section! {
    /// Manning's n of the ground, in s·m^(−1/3).
    RoughnessSection, example "{manning: 0.033}", check check_roughness {
        /// Manning's n everywhere; 0 is no friction; `raster` is required when absent. Codes: roughness, no-roughness.
        manning: Option<Quantity<Manning>>,
        /// Raster of n, or of classes beside a `table`; the pixel that holds a place counts; `manning` is required when absent.
        /// Codes: roughness-gap, roughness-default, roughness-range.
        raster: Option<InputFile>,
        /// CSV with the columns `class,name,n`: n of each class of the raster; the raster holds n when absent. Codes:
        /// missing-column, duplicate-class, roughness-range, not-a-number, not-a-table.
        table: Option<InputFile>,
        /// n where the raster has no data or the table no line for its class; such places are refused when absent. Codes:
        /// roughness-default, roughness-gap.
        default: Option<Quantity<Manning>>,
        /// File of polygons with the attribute `n` (`manning`, `manning_n`), which counts before all else; where two overlap the
        /// later one counts; none when absent. Codes: no-roughness, roughness-range, outside-terrain, empty-polygon,
        /// self-crossing.
        polygons: Option<VectorFile>,
        /// Factor of every n, also of those of files and channels, as studies vary it; 1 when absent.
        factor: Option<Quantity<RoughnessFactor>>,
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
        factor: section.factor.map_or(1.0, |factor| factor.value()),
    }
}

pub(super) fn written(scenario: &Scenario) -> Section {
    let rough = &scenario.roughness;
    let of_rest = if rough.raster.is_some() { "default" } else { "manning" };
    let section = Section::default()
        .with_some("raster", rough.raster.as_ref().map(|path| file(&path.value)))
        .with_some("table", rough.table.as_ref().map(|path| file(&path.value)))
        .with_some(of_rest, rough.manning)
        .with_some("polygons", rough.polygons.as_ref().map(vector));
    // Nothing where channels alone have their own.
    if section.is_empty() { section } else { section.with("factor", rough.factor) }
}
