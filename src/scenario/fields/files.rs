//! Files that a scenario names: their paths, with variables of the environment and layers behind a colon.

use std::borrow::Cow;
use std::path::PathBuf;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::scenario::model::{Sourced, VectorSource};
use crate::scenario::read::{FromNode, Reader};
use crate::scenario::tree::Node;

/// A file with a path relative to the folder of the scenario.
#[derive(Clone, Debug)]
pub struct InputFile(pub Sourced<PathBuf>);

impl FromNode for InputFile {
    fn example() -> String {
        "dem.tif".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let name = file_name(node, reader, &Self::example())?;
        let path = reader.folder.join(name);
        let file = reader.sourced(node, path);
        reader.files.push(file.clone());
        Some(InputFile(file))
    }
}

impl JsonSchema for InputFile {
    fn schema_name() -> Cow<'static, str> {
        "InputFile".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string", "x-kind": "file", "description": "A file; its path is relative to the folder of the scenario."})
    }
}

/// A CSV file.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(transparent, inline)]
pub struct CsvFile(pub InputFile);

impl FromNode for CsvFile {
    fn example() -> String {
        "values.csv".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        InputFile::from_node(node, reader).map(CsvFile)
    }
}

/// A vector file, or `file.gpkg:layer` for one of its layers.
#[derive(Clone, Debug)]
pub struct VectorFile(pub Sourced<VectorSource>);

impl FromNode for VectorFile {
    fn example() -> String {
        "reservoir.geojson".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let name = file_name(node, reader, &Self::example())?;
        let (path, layer) = split_layer(&name);
        let source = VectorSource { path: reader.folder.join(path), layer: layer.map(str::to_owned) };
        let file = reader.sourced(node, source.path.clone());
        reader.files.push(file);
        Some(VectorFile(reader.sourced(node, source)))
    }
}

impl JsonSchema for VectorFile {
    fn schema_name() -> Cow<'static, str> {
        "VectorFile".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "x-kind": "file of polygons, lines or points",
            "description": "A vector file, or `file.gpkg:layer` for one of its layers; \
                its path is relative to the folder of the scenario.",
        })
    }
}

/// Rasters over time: a NetCDF file, or `file.nc:variable` for one of its variables, or a list of files.
#[derive(Clone, Debug)]
pub struct RasterSeriesFile(pub Sourced<VectorSource>);

impl FromNode for RasterSeriesFile {
    fn example() -> String {
        "radar.nc:rainfall".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        // A variable is named as a layer is.
        VectorFile::from_node(node, reader).map(|file| RasterSeriesFile(file.0))
    }
}

impl JsonSchema for RasterSeriesFile {
    fn schema_name() -> Cow<'static, str> {
        "RasterSeriesFile".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "x-kind": "NetCDF file, or CSV list of times and files",
            "description": "A NetCDF file, or `file.nc:variable` for one of its variables, or a CSV list of times and \
                raster files; its path is relative to the folder of the scenario.",
        })
    }
}

fn file_name(node: &Node, reader: &mut Reader, example: &str) -> Option<String> {
    let name = reader.text(node, "the name of a file", example)?;
    if name.trim().is_empty() || name.contains('\0') {
        reader.wrong_type(node, "the name of a file", &format!("write for example `{example}`"));
        return None;
    }
    match expand(name, |variable| std::env::var(variable).ok()) {
        Ok(path) => Some(path),
        Err(variable) => {
            let message = format!("the path uses the environment variable `{variable}`, which is not set");
            let remedy = format!("set it, as in `{variable}=FOLDER floodsim ...`, or write the path itself");
            reader.error(node, "unset-variable", message, remedy);
            None
        }
    }
}

/// A path with every `${NAME}` replaced by the variable of that name; the name of the first one that is not set otherwise.
///
/// A relative folder in a variable counts from the current folder, not from that of the scenario.
pub(super) fn expand(text: &str, variable: impl Fn(&str) -> Option<String>) -> Result<String, String> {
    let Some((before, (name, after))) =
        text.split_once("${").and_then(|(before, rest)| Some((before, rest.split_once('}')?)))
    else {
        return Ok(text.to_owned());
    };
    let value = variable(name).filter(|value| !value.is_empty()).ok_or_else(|| name.to_owned())?;
    let value = match std::path::absolute(&value) {
        Ok(absolute) if before.is_empty() => absolute.to_string_lossy().into_owned(),
        _ => value,
    };
    Ok(format!("{before}{value}{}", expand(after, variable)?))
}

/// Splits `file.gpkg:layer` at the last colon that follows a file extension.
pub(in crate::scenario) fn split_layer(text: &str) -> (&str, Option<&str>) {
    match text.rsplit_once(':') {
        Some((path, layer)) if !layer.is_empty() && !layer.contains('/') && has_extension(path) => (path, Some(layer)),
        _ => (text, None),
    }
}

fn has_extension(path: &str) -> bool {
    std::path::Path::new(path).extension().is_some_and(|extension| !extension.is_empty())
}
