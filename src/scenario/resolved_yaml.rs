//! A resolved scenario as YAML, with every default filled in: running it gives the same run.
//!
//! Paths are written absolute, quantities in SI units with all their digits. In files of their own: what comes in over time, moving beds and
//! channels. Not here: how values become text ([`super::yaml`]).

mod channels;
mod forcing;
mod moving_beds;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::choices::{Choice, ElevationUnit};
use super::ground::{Breakline, BreaklineMode, BuildingMode, Gaps, LayerMode, LineLevel};
use super::model::{
    CrsChoice, OpenBoundary, OutputPart, PointInterpolation, Scenario, Side, Sourced, TerrainLayer, VectorSource,
};
use super::start::RiverWidth;
use super::yaml::{Section, Yaml, quantity, quoted};

impl Scenario {
    /// The text of `scenario.resolved.yaml`.
    pub fn to_yaml(&self) -> String {
        let section = self
            .place()
            .and(self.forcing())
            .with_some("breach", self.breach.as_ref().map(forcing::breach))
            .with_list("moving_bed", self.moving_bed.iter().map(moving_beds::moving_bed).collect())
            .with_list("channels", self.channels.iter().map(channels::channel).collect())
            .and(self.run());
        format!("# The scenario with every default filled in; running it gives the same run.\n{}", section.text())
    }

    /// Title, ground, and water at the start.
    fn place(&self) -> Section {
        let crs = match &self.crs.value {
            CrsChoice::FromTerrain => "terrain".into(),
            CrsChoice::Local => "local".into(),
            CrsChoice::Named(name) => quoted(name),
        };
        Section::default()
            .with("floodsim", 1.0)
            .with("title", quoted(&self.title))
            .with("crs", crs)
            .with_some("terrain", (!self.is_channels_alone()).then(|| self.terrain()))
            .with_some("roughness", filled(self.rough_ground()))
            .with_some("structures", filled(self.structures()))
            .with_list("initial", self.water())
    }

    fn terrain(&self) -> Section {
        let layers = self.layers.iter().map(|layer| match &layer.value {
            TerrainLayer::Raster { path, offset, unit, clip, mode } => {
                let unit = name_of(|candidate: &ElevationUnit| candidate.0.to_bits() == unit.to_bits());
                Yaml::Entry(
                    Section::default()
                        .with("raster", file(path))
                        .with("offset", quantity(*offset, "m"))
                        .with("unit", unit)
                        .with_some("clip", clip.as_ref().map(vector))
                        .with("mode", name_of(|candidate: &LayerMode| candidate == mode)),
                )
            }
            TerrainLayer::Points { path, interpolation, max_gap, offset, clip, mode } => Section::default()
                .with("points", file(path))
                .with("interpolation", name_of(|candidate: &PointInterpolation| candidate == interpolation))
                .with("max_gap", quantity(*max_gap, "m"))
                .with("offset", quantity(*offset, "m"))
                .with("mode", name_of(|candidate: &LayerMode| candidate == mode))
                .with_some("clip", clip.as_ref().map(vector))
                .into(),
        });
        let gaps = self.ground.gaps.as_ref().map(|gaps| match gaps.value {
            Gaps::Wall => "wall".into(),
            Gaps::Refuse => "error".into(),
            Gaps::Fill { max_cells } => {
                Yaml::Entry(Section::default().with("fill", "idw").with("max_cells", max_cells as f64))
            }
        });
        let breaklines = self.ground.breaklines.iter().filter(|line| !is_wall(line)).map(|line| {
            Yaml::Entry(
                Section::default()
                    .with("lines", vector(&line.lines))
                    .with("mode", name_of(|candidate: &BreaklineMode| *candidate == line.mode))
                    .and(level(["z", "z_field"], &line.level))
                    .with_some("width", line.width.map(|width| quantity(width, "m"))),
            )
        });
        Section::default()
            .with_list("layers", layers.collect())
            .with("reproject", self.reproject)
            .with_some("gaps", gaps)
            .with_list("breaklines", breaklines.collect())
    }

    fn rough_ground(&self) -> Section {
        let rough = &self.roughness;
        let of_rest = if rough.raster.is_some() { "default" } else { "manning" };
        Section::default()
            .with_some("raster", rough.raster.as_ref().map(|path| file(&path.value)))
            .with_some("table", rough.table.as_ref().map(|path| file(&path.value)))
            .with_some(of_rest, rough.manning)
            .with_some("polygons", rough.polygons.as_ref().map(vector))
    }

    fn structures(&self) -> Section {
        let walls = self.walls.iter().map(|wall| Yaml::Entry(Section::default().with("lines", vector(wall))));
        let crested = self.ground.breaklines.iter().filter(|line| is_wall(line)).map(|wall| {
            let lines = Section::default().with("lines", vector(&wall.lines));
            Yaml::Entry(lines.and(level(["crest", "crest_field"], &wall.level)))
        });
        let buildings = self.ground.buildings.as_ref().map(|buildings| {
            let mode = match &buildings.mode {
                BuildingMode::Block => Section::default().with("mode", "block"),
                BuildingMode::Raise { height, field } => Section::default()
                    .with("mode", "raise")
                    .with_some("height", height.map(|height| quantity(height, "m")))
                    .with_some("height_field", field.as_deref().filter(|_| height.is_none()).map(quoted)),
                BuildingMode::Roughness(n) => Section::default().with("mode", "roughness").with_some("n", *n),
            };
            Yaml::Entry(Section::default().with("polygons", vector(&buildings.polygons)).and(mode))
        });
        Section::default().with_list("walls", walls.chain(crested).collect()).with_some("buildings", buildings)
    }

    fn water(&self) -> Vec<Yaml> {
        let levels = self.initial.iter().map(|water| {
            Section::default()
                .with(water_kind(&water.polygons.key), vector(&water.polygons))
                .with_some("level", water.level.as_ref().map(|level| quantity(level.value, "m")))
                .with_some("level_field", water.level_field.as_deref().map(quoted))
        });
        let depths = self.start.depths.iter().map(|water| {
            let kind = if water.river.is_some() { "river" } else { water_kind(&water.place.key) };
            let of_depth =
                Section::default().with(kind, vector(&water.place)).with("depth", quantity(water.depth.value, "m"));
            match &water.river {
                Some(RiverWidth::Constant(width)) => of_depth.with("width", quantity(*width, "m")),
                Some(RiverWidth::Field(field)) => of_depth.with("width_field", quoted(field)),
                Some(RiverWidth::Cell) | None => of_depth,
            }
        });
        let earlier = self.start.earlier.iter().map(|earlier| {
            let time = earlier.time.as_ref().map_or("last".into(), |time| quantity(time.value, "s"));
            Section::default().with("fields", file(&earlier.fields.value)).with("time", time)
        });
        levels.chain(depths).chain(earlier).map(Yaml::Entry).collect()
    }

    /// Resolution, time, outputs, methods and limits.
    fn run(&self) -> Section {
        let reference = self.reference_time.map(|reference| quoted(&reference.to_string()));
        let limits = Section::default()
            .with("memory", quantity(self.limits.memory, "B"))
            .with("particles", self.limits.particles);
        Section::default()
            .with("resolution", quantity(self.resolution.value, "m"))
            .with(
                "time",
                Section::default().with("end", quantity(self.end_time, "s")).with_some("reference", reference),
            )
            .with("outputs", self.written_outputs())
            .with("numerics", self.methods())
            .with("limits", Yaml::Entry(limits))
    }

    fn written_outputs(&self) -> Section {
        let outputs = &self.outputs;
        let has_maps = !self.is_channels_alone();
        let cell = if outputs.maps_on_terrain.is_some() { "terrain".into() } else { quantity(outputs.cell, "m") };
        let list = |values: &[f64], unit| Yaml::Row(values.iter().map(|value| quantity(*value, unit)).collect());
        let arrival = Section::default()
            .with("thresholds", list(&outputs.thresholds, "m"))
            .with("rise_on_wet", quantity(outputs.rise_on_wet, "m"));
        Section::default()
            .with("folder", file(&outputs.folder.value))
            .with("write", Yaml::Row(outputs.write.iter().copied().map(OutputPart::name).map(Yaml::from).collect()))
            .with_some("cell", has_maps.then_some(cell))
            .with("every", quantity(outputs.every, "s"))
            .with("gauges_every", quantity(outputs.gauges_every, "s"))
            .with_some("gauges", outputs.gauges.as_ref().map(vector))
            .with_some("sections", outputs.sections.as_ref().map(vector))
            .with("arrival", arrival)
            .with_some("isochrones", has_maps.then(|| list(&outputs.isochrones, "s")))
    }

    fn methods(&self) -> Section {
        let numerics = &self.numerics;
        let has_maps = !self.is_channels_alone();
        Section::default()
            .with("formulation", numerics.formulation.name())
            .with("motion", numerics.motion.name())
            .with("stabilisation", numerics.stabilisation.name())
            .with("reconstruction", numerics.reconstruction.name())
            .with("seeding", numerics.seeding.name())
            .with("kernel", numerics.kernel.name())
            .with("integrator", numerics.integrator.name())
            .with_some("bed", has_maps.then(|| numerics.bed.name()))
            .with_some("turbulence", has_maps.then(|| numerics.turbulence.name()))
            .with("bed_slope", numerics.bed_slope.name())
            .with("wall", numerics.wall.name())
            .with("cfl", numerics.cfl)
            .with("gravity", quantity(numerics.gravity, "m/s2"))
            .with("dry_depth", quantity(numerics.dry_depth, "m"))
    }
}

/// A section where it has a key.
fn filled(section: Section) -> Option<Section> {
    Some(section).filter(|section| !section.is_empty())
}

/// Whether a breakline is a wall with a crest.
fn is_wall(line: &Breakline) -> bool {
    line.lines.key.starts_with("structures.")
}

/// The level of a breakline, by the keys of a constant and of an attribute.
fn level([constant, field]: [&'static str; 2], level: &LineLevel) -> Section {
    match level {
        LineLevel::Constant(level) => Section::default().with(constant, quantity(level.value, "m")),
        LineLevel::Field(name) => Section::default().with(field, quoted(name)),
        LineLevel::Vertices => Section::default(),
    }
}

/// The side or the lines of a boundary.
fn open_place(place: &OpenBoundary) -> Section {
    match place {
        OpenBoundary::Side(side) => Section::default().with("side", name_of(|candidate: &Side| candidate == side)),
        OpenBoundary::Lines(lines) => Section::default().with("lines", vector(lines)),
    }
}

/// The kind of water that the key path names, such as `initial[0].sea`.
fn water_kind(key: &str) -> &'static str {
    let kind = key.rsplit('.').next().unwrap_or_default();
    super::schema::WATER_KINDS.into_iter().find(|known| *known == kind).unwrap_or("water")
}

/// The name of a choice.
fn name_of<T: Choice>(is_it: impl Fn(&T) -> bool) -> &'static str {
    T::choices().into_iter().find(|(_, candidate)| is_it(candidate)).map_or("unknown", |(name, _)| name)
}

/// A vector file, with its layer where it has one.
fn vector(source: &Sourced<VectorSource>) -> Yaml {
    let path = absolute(&source.value.path);
    Yaml::Quoted(match &source.value.layer {
        Some(layer) => format!("{path}:{layer}"),
        None => path,
    })
}

/// A file.
fn file(path: &Path) -> Yaml {
    Yaml::Quoted(absolute(path))
}

fn absolute(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}
