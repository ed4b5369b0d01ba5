//! A resolved scenario as YAML, with every default filled in: running it gives the same run.
//!
//! Paths are written absolute, quantities in SI units with all their digits.

use std::fmt::Write;
use std::path::Path;

use super::choices::{Choice, ElevationUnit};
use super::ground::{Breakline, BreaklineMode, BuildingMode, Gaps, LayerMode, LineLevel};
use super::model::{
    AfterEnd, BoundaryCondition, BreachFormula, BreachMode, BreachTrigger, CrsChoice, GrowthLaw, OpenBoundary,
    PointInterpolation, RainAmount, Roughness, Scenario, Side, SourcePlace, Sourced, Stamp, TableFile, TerrainLayer,
    Timed, VectorSource,
};
use super::start::{RiverWidth, Start};

impl Scenario {
    /// The text of `scenario.resolved.yaml`.
    pub fn to_yaml(&self) -> String {
        let mut text = String::from("# The scenario with every default filled in; running it gives the same run.\n");
        // Writing to a string cannot fail.
        let _ = self
            .write_place(&mut text)
            .and_then(|()| self.write_breach(&mut text))
            .and_then(|()| super::moving_bed::write(&self.moving_bed, &mut text))
            .and_then(|()| super::channel::write(&self.channels, &mut text))
            .and_then(|()| self.write_run(&mut text));
        text
    }

    fn write_place(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "floodsim: 1\ntitle: {}", quoted(&self.title))?;
        match &self.crs.value {
            CrsChoice::FromTerrain => writeln!(text, "crs: terrain")?,
            CrsChoice::Local => writeln!(text, "crs: local")?,
            CrsChoice::Named(name) => writeln!(text, "crs: {}", quoted(name))?,
        }
        if !self.is_channels_alone() {
            self.write_terrain(text)?;
        }
        self.write_roughness(text)?;
        self.write_structures(text)?;
        if !self.initial.is_empty() || self.start != Start::default() {
            writeln!(text, "initial:")?;
        }
        for water in &self.initial {
            write!(text, "  - {{{}: {}", water_kind(&water.polygons.key), quoted_vector(&water.polygons))?;
            if let Some(level) = &water.level {
                write!(text, ", level: {} m", level.value)?;
            }
            if let Some(field) = &water.level_field {
                write!(text, ", level_field: {}", quoted(field))?;
            }
            writeln!(text, "}}")?;
        }
        self.write_start(text)?;
        if !self.open.is_empty() || !self.boundaries.is_empty() {
            writeln!(text, "boundaries:")?;
        }
        for boundary in &self.open {
            match boundary {
                OpenBoundary::Side(side) => {
                    let side = name_of(|candidate: &Side| candidate == side);
                    writeln!(text, "  - {{side: {side}, type: open}}")?;
                }
                OpenBoundary::Lines(lines) => writeln!(text, "  - {{lines: {}, type: open}}", quoted_vector(lines))?,
            }
        }
        self.write_forcing(text)
    }

    fn write_terrain(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "terrain:\n  layers:")?;
        for layer in &self.layers {
            match &layer.value {
                TerrainLayer::Raster { path, offset, unit, clip, mode } => {
                    let unit = name_of(|candidate: &ElevationUnit| candidate.0.to_bits() == unit.to_bits());
                    write!(text, "    - {{raster: {}, offset: {offset} m, unit: {unit}", quoted_path(path))?;
                    if let Some(clip) = clip {
                        write!(text, ", clip: {}", quoted_vector(clip))?;
                    }
                    writeln!(text, ", mode: {}}}", name_of(|candidate: &LayerMode| candidate == mode))?;
                }
                TerrainLayer::Points { path, interpolation, max_gap, offset, clip, mode } => {
                    let interpolation = name_of(|candidate: &PointInterpolation| candidate == interpolation);
                    let path = quoted_path(path);
                    writeln!(text, "    - points: {path}\n      interpolation: {interpolation}")?;
                    let mode = name_of(|candidate: &LayerMode| candidate == mode);
                    writeln!(text, "      max_gap: {max_gap} m\n      offset: {offset} m\n      mode: {mode}")?;
                    if let Some(clip) = clip {
                        writeln!(text, "      clip: {}", quoted_vector(clip))?;
                    }
                }
            }
        }
        writeln!(text, "  reproject: {}", self.reproject)?;
        self.write_ground(text)
    }

    fn write_start(&self, text: &mut String) -> std::fmt::Result {
        for water in &self.start.depths {
            let kind = if water.river.is_some() { "river" } else { water_kind(&water.place.key) };
            write!(text, "  - {{{kind}: {}, depth: {} m", quoted_vector(&water.place), water.depth.value)?;
            match &water.river {
                Some(RiverWidth::Constant(width)) => write!(text, ", width: {width} m")?,
                Some(RiverWidth::Field(field)) => write!(text, ", width_field: {}", quoted(field))?,
                Some(RiverWidth::Cell) | None => {}
            }
            writeln!(text, "}}")?;
        }
        if let Some(earlier) = &self.start.earlier {
            write!(text, "  - {{fields: {}, time: ", quoted_path(&earlier.fields.value))?;
            match &earlier.time {
                Some(time) => writeln!(text, "{} s}}", time.value)?,
                None => writeln!(text, "last}}")?,
            }
        }
        Ok(())
    }

    fn write_ground(&self, text: &mut String) -> std::fmt::Result {
        match self.ground.gaps.as_ref().map(|gaps| gaps.value) {
            None => {}
            Some(Gaps::Wall) => writeln!(text, "  gaps: wall")?,
            Some(Gaps::Refuse) => writeln!(text, "  gaps: error")?,
            Some(Gaps::Fill { max_cells }) => writeln!(text, "  gaps: {{fill: idw, max_cells: {max_cells}}}")?,
        }
        let mut lines = self.ground.breaklines.iter().filter(|line| !is_wall(line)).peekable();
        if lines.peek().is_some() {
            writeln!(text, "  breaklines:")?;
        }
        for line in lines {
            let mode = name_of(|candidate: &BreaklineMode| *candidate == line.mode);
            write!(text, "    - {{lines: {}, mode: {mode}", quoted_vector(&line.lines))?;
            write_level(text, "z", &line.level)?;
            if let Some(width) = line.width {
                write!(text, ", width: {width} m")?;
            }
            writeln!(text, "}}")?;
        }
        Ok(())
    }

    fn write_structures(&self, text: &mut String) -> std::fmt::Result {
        let crested: Vec<&Breakline> = self.ground.breaklines.iter().filter(|line| is_wall(line)).collect();
        let has_walls = !self.walls.is_empty() || !crested.is_empty();
        if has_walls || self.ground.buildings.is_some() {
            writeln!(text, "structures:")?;
        }
        if has_walls {
            writeln!(text, "  walls:")?;
        }
        for wall in &self.walls {
            writeln!(text, "    - {{lines: {}}}", quoted_vector(wall))?;
        }
        for wall in crested {
            write!(text, "    - {{lines: {}", quoted_vector(&wall.lines))?;
            write_level(text, "crest", &wall.level)?;
            writeln!(text, "}}")?;
        }
        let Some(buildings) = &self.ground.buildings else { return Ok(()) };
        write!(text, "  buildings: {{polygons: {}, mode: ", quoted_vector(&buildings.polygons))?;
        match &buildings.mode {
            BuildingMode::Block => write!(text, "block")?,
            BuildingMode::Raise { height: Some(height), .. } => write!(text, "raise, height: {height} m")?,
            BuildingMode::Raise { field: Some(field), .. } => write!(text, "raise, height_field: {}", quoted(field))?,
            BuildingMode::Raise { .. } => write!(text, "raise")?,
            BuildingMode::Roughness(Some(n)) => write!(text, "roughness, n: {n}")?,
            BuildingMode::Roughness(None) => write!(text, "roughness")?,
        }
        writeln!(text, "}}")
    }

    fn write_roughness(&self, text: &mut String) -> std::fmt::Result {
        if self.roughness == Roughness::default() {
            return Ok(());
        }
        let Roughness { manning, raster, table, polygons } = &self.roughness;
        writeln!(text, "roughness:")?;
        if let Some(raster) = raster {
            writeln!(text, "  raster: {}", quoted_path(&raster.value))?;
        }
        if let Some(table) = table {
            writeln!(text, "  table: {}", quoted_path(&table.value))?;
        }
        if let Some(n) = manning {
            writeln!(text, "  {}: {n}", if raster.is_some() { "default" } else { "manning" })?;
        }
        if let Some(polygons) = polygons {
            writeln!(text, "  polygons: {}", quoted_vector(polygons))?;
        }
        Ok(())
    }

    fn write_forcing(&self, text: &mut String) -> std::fmt::Result {
        for boundary in &self.boundaries {
            match &boundary.value.place {
                OpenBoundary::Side(side) => write!(text, "  - {{side: {}", name_of(|s: &Side| s == side))?,
                OpenBoundary::Lines(lines) => write!(text, "  - {{lines: {}", quoted_vector(lines))?,
            }
            write!(text, ", {}", condition_as_yaml(&boundary.value.condition))?;
            writeln!(text, "}}")?;
        }
        if !self.sources.is_empty() {
            writeln!(text, "sources:")?;
        }
        for source in &self.sources {
            match &source.value.place {
                SourcePlace::At(at) => write!(text, "  - {{at: [{}, {}]", at.value[0], at.value[1])?,
                SourcePlace::Points(points) => write!(text, "  - {{points: {}", quoted_vector(points))?,
                SourcePlace::Lines(lines) => write!(text, "  - {{lines: {}", quoted_vector(lines))?,
            }
            writeln!(text, ", discharge: {}}}", timed(&source.value.discharge, "m3/s"))?;
        }
        let Some(rain) = self.rain.as_ref().map(|rain| &rain.value) else { return Ok(()) };
        writeln!(text, "rain:")?;
        match &rain.amount {
            RainAmount::Rate(rate) => writeln!(text, "  rate: {}", timed(rate, "m/s"))?,
            RainAmount::Raster { file, unit } => {
                writeln!(text, "  raster: {}\n  unit: {}", quoted_path(&file.value), quoted(&unit.0))?;
            }
            RainAmount::Series { file, unit, stamp, start } => {
                writeln!(text, "  raster_series: {}", quoted_vector(file))?;
                if let Some((unit, _)) = unit {
                    writeln!(text, "  unit: {}", quoted(unit))?;
                }
                if let Some(stamp) = stamp {
                    writeln!(text, "  stamp: {}", name_of(|candidate: &Stamp| candidate == stamp))?;
                }
                if let Some(start) = start {
                    writeln!(text, "  start: {}", quoted(&start.to_string()))?;
                }
            }
        }
        if let Some(duration) = rain.duration {
            writeln!(text, "  duration: {duration} s")?;
        }
        writeln!(text, "  losses: {{initial: {} m, constant: {} m/s}}", rain.initial_loss, rain.constant_loss)
    }

    fn write_breach(&self, text: &mut String) -> std::fmt::Result {
        let Some(breach) = &self.breach else { return Ok(()) };
        writeln!(text, "breach:\n  dam: {}", quoted_vector(&breach.dam))?;
        if let Some(crest) = &breach.crest {
            writeln!(text, "  crest: {} m", crest.value)?;
        }
        if let Some(field) = &breach.crest_field {
            writeln!(text, "  crest_field: {}", quoted(field))?;
        }
        match &breach.trigger {
            BreachTrigger::At(at) => writeln!(text, "  trigger: {{at: {} s}}", at.value)?,
            BreachTrigger::Level { level, place } => {
                let [x, y] = place.value;
                writeln!(text, "  trigger: {{level: {} m, at_point: [{x}, {y}]}}", level.value)?;
            }
        }
        if let Some(shape) = &breach.shape {
            let (width, slope, invert) = (shape.bottom_width.value, shape.side_slope, shape.invert.value);
            write!(text, "  shape: {{bottom_width: {width} m, side_slope: {slope}, invert: {invert} m")?;
            if let Some(place) = &shape.position {
                write!(text, ", position: [{}, {}]", place.value[0], place.value[1])?;
            }
            writeln!(text, "}}")?;
        }
        if let Some(method) = &breach.method {
            let name = name_of(|candidate: &BreachFormula| *candidate == method.formula);
            let mode = name_of(|candidate: &BreachMode| *candidate == method.mode);
            let (volume, invert) = (method.volume.value, method.invert.value);
            write!(text, "  method: {{name: {name}, mode: {mode}, volume: {volume} m3, invert: {invert} m")?;
            if let Some(place) = &method.position {
                write!(text, ", position: [{}, {}]", place.value[0], place.value[1])?;
            }
            return writeln!(text, "}}");
        }
        let law = name_of(|candidate: &GrowthLaw| *candidate == breach.law);
        match (&breach.duration, &breach.share) {
            (_, Some(share)) => writeln!(text, "  growth: {{law: {law}, share: {}}}", series_as_yaml(share)),
            (Some(duration), None) => writeln!(text, "  growth: {{law: {law}, duration: {} s}}", duration.value),
            (None, None) => writeln!(text, "  growth: {law}"),
        }
    }

    fn write_run(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "resolution: {} m\ntime:\n  end: {} s", self.resolution.value, self.end_time)?;
        if let Some(reference) = &self.reference_time {
            writeln!(text, "  reference: {}", quoted(&reference.to_string()))?;
        }
        let outputs = &self.outputs;
        let has_maps = !self.is_channels_alone();
        writeln!(text, "outputs:\n  folder: {}", quoted_path(&outputs.folder.value))?;
        let parts: Vec<&str> = outputs.write.iter().map(|part| part.name()).collect();
        writeln!(text, "  write: [{}]", parts.join(", "))?;
        if has_maps {
            let cell =
                if outputs.maps_on_terrain.is_some() { "terrain".to_owned() } else { format!("{} m", outputs.cell) };
            writeln!(text, "  cell: {cell}")?;
        }
        writeln!(text, "  every: {} s\n  gauges_every: {} s", outputs.every, outputs.gauges_every)?;
        if let Some(gauges) = &outputs.gauges {
            writeln!(text, "  gauges: {}", quoted_vector(gauges))?;
        }
        if let Some(sections) = &outputs.sections {
            writeln!(text, "  sections: {}", quoted_vector(sections))?;
        }
        writeln!(text, "  arrival:\n    thresholds: [{}]", list(&outputs.thresholds, "m"))?;
        writeln!(text, "    rise_on_wet: {} m", outputs.rise_on_wet)?;
        if has_maps {
            writeln!(text, "  isochrones: [{}]", list(&outputs.isochrones, "s"))?;
        }
        let numerics = &self.numerics;
        writeln!(text, "numerics:\n  formulation: {}", numerics.formulation.name())?;
        writeln!(text, "  motion: {}\n  stabilisation: {}", numerics.motion.name(), numerics.stabilisation.name())?;
        writeln!(text, "  reconstruction: {}", numerics.reconstruction.name())?;
        writeln!(text, "  seeding: {}", numerics.seeding.name())?;
        writeln!(text, "  kernel: {}\n  integrator: {}", numerics.kernel.name(), numerics.integrator.name())?;
        if has_maps {
            writeln!(text, "  bed: {}", numerics.bed.name())?;
        }
        if has_maps {
            writeln!(text, "  turbulence: {}", numerics.turbulence.name())?;
        }
        writeln!(text, "  bed_slope: {}\n  wall: {}", numerics.bed_slope.name(), numerics.wall.name())?;
        writeln!(text, "  cfl: {}", numerics.cfl)?;
        writeln!(text, "  gravity: {} m/s2\n  dry_depth: {} m", numerics.gravity, numerics.dry_depth)?;
        writeln!(text, "limits: {{memory: {} B, particles: {}}}", self.limits.memory, self.limits.particles)
    }
}

/// Whether a breakline is a wall with a crest.
fn is_wall(line: &Breakline) -> bool {
    line.lines.key.starts_with("structures.")
}

/// The level of a breakline after its other keys.
fn write_level(text: &mut String, key: &str, level: &LineLevel) -> std::fmt::Result {
    match level {
        LineLevel::Constant(level) => write!(text, ", {key}: {} m", level.value),
        LineLevel::Field(field) => write!(text, ", {key}_field: {}", quoted(field)),
        LineLevel::Vertices => Ok(()),
    }
}

/// The keys of a condition.
pub(super) fn condition_as_yaml(condition: &BoundaryCondition) -> String {
    match condition {
        BoundaryCondition::Free => "type: free".to_owned(),
        BoundaryCondition::Discharge { discharge, level } => {
            let level = level.as_ref().map_or(String::new(), |level| format!(", level: {}", timed(level, "m")));
            format!("discharge: {}{level}", timed(discharge, "m3/s"))
        }
        BoundaryCondition::Stage(level) => format!("stage: {}", timed(level, "m")),
        BoundaryCondition::Level(level) => format!("level: {}", timed(level, "m")),
        BoundaryCondition::Wave { level, still } => {
            let still = still.as_ref().map_or(String::new(), |still| format!(", still: {}", timed(still, "m")));
            format!("wave: {}{still}", timed(level, "m"))
        }
        BoundaryCondition::NormalDepth(slope) => format!("normal_depth: {{slope: {}}}", slope.value),
        BoundaryCondition::Rating(table) => {
            let names = [["level", "level_unit"], ["discharge", "discharge_unit"]];
            format!("rating: {{table: {}{}}}", quoted_path(&table.file.value), columns(table, names))
        }
    }
}

/// A quantity over time; `unit` is that of SI.
pub(super) fn timed(timed: &Timed, unit: &str) -> String {
    match timed {
        Timed::Constant(value) => format!("{} {unit}", value.value),
        Timed::Series(table) => series_as_yaml(table),
    }
}

pub(super) fn series_as_yaml(table: &TableFile) -> String {
    let names = [["time", "time_unit"], ["column", "unit"]];
    let after_end = match table.after_end {
        None => "",
        Some(AfterEnd::Hold) => ", after_end: hold",
    };
    format!("{{series: {}{}{after_end}}}", quoted_path(&table.file.value), columns(table, names))
}

/// The columns of a table and their units, as far as they are given, by the keys of both.
fn columns(table: &TableFile, names: [[&str; 2]; 2]) -> String {
    let mut text = String::new();
    for (column, [name, unit]) in table.columns.iter().zip(names) {
        if let Some(value) = &column.name {
            text += &format!(", {name}: {}", quoted(value));
        }
        if let Some((value, _)) = &column.unit {
            text += &format!(", {unit}: {}", quoted(value));
        }
    }
    text
}

/// The kind of water that the key path names, such as `initial[0].sea`.
fn water_kind(key: &str) -> &str {
    let kind = key.rsplit('.').next().unwrap_or_default();
    if super::schema::WATER_KINDS.contains(&kind) { kind } else { "water" }
}

pub(super) fn name_of<T: Choice>(is_it: impl Fn(&T) -> bool) -> &'static str {
    T::choices().into_iter().find(|(_, candidate)| is_it(candidate)).map_or("unknown", |(name, _)| name)
}

fn list(values: &[f64], unit: &str) -> String {
    values.iter().map(|value| format!("{value} {unit}")).collect::<Vec<_>>().join(", ")
}

pub(super) fn quoted_vector(source: &Sourced<VectorSource>) -> String {
    let path = absolute(&source.value.path);
    match &source.value.layer {
        Some(layer) => quoted(&format!("{path}:{layer}")),
        None => quoted(&path),
    }
}

pub(super) fn quoted_path(path: &Path) -> String {
    quoted(&absolute(path))
}

fn absolute(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}

/// A text in double quotes; the escapes of JSON are escapes of YAML, too.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::scenario::{
        BoundaryCondition, BreachTrigger, OpenBoundary, RainAmount, Scenario, SourcePlace, Timed, resolve,
    };

    /// The scenario without the places of its values, which differ between two files by nature.
    fn without_places(scenario: &Scenario) -> Scenario {
        let mut plain = scenario.clone();
        plain.file = "".into();
        plain.crs.place = None;
        plain.resolution.place = None;
        plain.outputs.folder.place = None;
        for layer in &mut plain.layers {
            layer.place = None;
            let (super::TerrainLayer::Raster { clip, .. } | super::TerrainLayer::Points { clip, .. }) =
                &mut layer.value;
            clip.iter_mut().for_each(|clip| clip.place = None);
        }
        plain.ground.gaps.iter_mut().for_each(|gaps| gaps.place = None);
        plain.ground.buildings.iter_mut().for_each(|buildings| buildings.polygons.place = None);
        for line in &mut plain.ground.breaklines {
            line.lines.place = None;
            if let super::LineLevel::Constant(level) = &mut line.level {
                level.place = None;
            }
        }
        for water in &mut plain.initial {
            water.polygons.place = None;
            water.level.iter_mut().for_each(|level| level.place = None);
        }
        for water in &mut plain.start.depths {
            (water.place.place, water.depth.place) = (None, None);
        }
        if let Some(earlier) = &mut plain.start.earlier {
            earlier.fields.place = None;
            earlier.time.iter_mut().for_each(|time| time.place = None);
        }
        plain.walls.iter_mut().for_each(|wall| wall.place = None);
        plain.outputs.gauges.iter_mut().for_each(|gauges| gauges.place = None);
        for boundary in &mut plain.open {
            if let super::OpenBoundary::Lines(lines) = boundary {
                lines.place = None;
            }
        }
        let rough = &mut plain.roughness;
        rough.raster.iter_mut().chain(&mut rough.table).for_each(|file| file.place = None);
        rough.polygons.iter_mut().for_each(|file| file.place = None);
        forget_forcing(&mut plain);
        plain
    }

    /// The same for boundaries, sources, rain and sections; their keys count the entries, which the resolved file puts in order.
    fn forget_forcing(plain: &mut Scenario) {
        fn forget(timed: &mut Timed) {
            match timed {
                Timed::Constant(value) => value.place = None,
                Timed::Series(table) => table.file.place = None,
            }
        }
        for boundary in &mut plain.boundaries {
            boundary.place = None;
            if let OpenBoundary::Lines(lines) = &mut boundary.value.place {
                lines.place = None;
            }
            match &mut boundary.value.condition {
                BoundaryCondition::Free => {}
                BoundaryCondition::Discharge { discharge, level } => {
                    forget(discharge);
                    level.iter_mut().for_each(forget);
                }
                BoundaryCondition::Stage(level) | BoundaryCondition::Level(level) => forget(level),
                BoundaryCondition::Wave { level, still } => {
                    forget(level);
                    still.iter_mut().for_each(forget);
                }
                BoundaryCondition::NormalDepth(slope) => slope.place = None,
                BoundaryCondition::Rating(table) => table.file.place = None,
            }
        }
        for source in &mut plain.sources {
            source.place = None;
            forget(&mut source.value.discharge);
            match &mut source.value.place {
                SourcePlace::At(at) => at.place = None,
                SourcePlace::Points(file) => file.place = None,
                // `line` and `lines` say the same.
                SourcePlace::Lines(file) => (file.place, file.key) = (None, String::new()),
            }
        }
        if let Some(rain) = &mut plain.rain {
            rain.place = None;
            match &mut rain.value.amount {
                RainAmount::Rate(rate) => forget(rate),
                RainAmount::Raster { file, .. } => file.place = None,
                RainAmount::Series { file, .. } => file.place = None,
            }
        }
        plain.outputs.sections.iter_mut().for_each(|sections| sections.place = None);
        if let Some(breach) = &mut plain.breach {
            breach.dam.place = None;
            breach.crest.iter_mut().chain(&mut breach.duration).for_each(|value| value.place = None);
            breach.share.iter_mut().for_each(|share| share.file.place = None);
            match &mut breach.trigger {
                BreachTrigger::At(at) => (at.place, at.key) = (None, String::new()),
                BreachTrigger::Level { level, place } => (level.place, place.place) = (None, None),
            }
            if let Some(shape) = &mut breach.shape {
                (shape.bottom_width.place, shape.invert.place) = (None, None);
                shape.position.iter_mut().for_each(|place| place.place = None);
            }
            if let Some(method) = &mut breach.method {
                (method.volume.place, method.invert.place) = (None, None);
                method.position.iter_mut().for_each(|place| place.place = None);
            }
        }
    }

    #[track_caller]
    fn assert_round_trip(text: &str) {
        let first = resolve(text, Path::new("/somewhere/scenario.yaml"), &[]).unwrap().scenario;
        let written = first.to_yaml();
        let second = resolve(&written, Path::new("/elsewhere/scenario.resolved.yaml"), &[]).unwrap().scenario;
        let (mut expected, mut found) = (without_places(&first), without_places(&second));
        expected.outputs.folder.value = std::path::absolute(&expected.outputs.folder.value).unwrap();
        // What the first leaves to the default the second says.
        expected.outputs.folder.key = "outputs.folder".to_owned();
        // The short form of the terrain has another key path.
        for (a, b) in expected.layers.iter_mut().zip(&mut found.layers) {
            a.key.clone_from(&b.key);
        }
        assert_eq!(expected, found);
        assert_eq!(written, second.to_yaml());
    }

    #[test]
    fn a_resolved_scenario_reads_back_as_itself() {
        assert_round_trip(
            "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.033}\ninitial: [{sea: a.geojson, level: 0.1 m}]\n\
             resolution: 20 ft\ntime: {end: 1 h 30 min}\n",
        );
    }

    #[test]
    fn every_kind_of_water_reads_back_as_itself() {
        for initial in [
            "[{sea: a.geojson, level: 0.1 m}, {water: p.gpkg:pond, depth: 50 cm}, {river: r.shp, depth: 1 ft, width: 3 m}, \
             {river: r.shp, depth: 1 m, width_field: \"w, m\"}, {river: r.shp, depth: 2 m}]",
            "[{fields: before/fields.nc}]",
            "[{fields: before/fields.nc, time: 90 s}]",
        ] {
            assert_round_trip(&format!(
                "floodsim: 1\nterrain: dem.tif\nroughness: {{manning: 0.033}}\ninitial: {initial}\n\
                 resolution: 20 m\ntime: {{end: 1 h}}\n",
            ));
        }
    }

    #[test]
    fn a_breach_reads_back_as_itself() {
        for breach in [
            "{dam: dam.gpkg:crest, crest: 105 m}",
            "{dam: dam.gpkg, crest: 105 m, method: {name: froehlich1995, mode: piping, volume: 2.5 hm3, invert: 90 m, position: [7, 8.25]}}",
            "{dam: dam.geojson, crest_field: top, trigger: {at: 3 min}, shape: {bottom_width: 40 ft, invert: 90 m}, \
             growth: {law: linear, duration: 0.5 h}}",
            "{dam: dam.geojson, crest: 3 m, growth: {law: series, share: {series: g.csv, column: p, unit: '%', time: t, time_unit: h}}}",
            "{dam: dam.geojson, trigger: {level: 104.5 m, at_point: [5.5, 6]}, \
             shape: {bottom_width: 4 m, side_slope: 0, invert: 90 m, position: [7, 8.25]}, growth: {law: sine, duration: 9 s}}",
        ] {
            assert_round_trip(&format!(
                "floodsim: 1\nterrain: dem.tif\nroughness: {{manning: 0.033}}\ninitial: [{{sea: a.geojson, level: 0.1 m}}]\n\
                 resolution: 20 m\ntime: {{end: 1 h}}\nbreach: {breach}\n",
            ));
        }
    }

    #[test]
    fn boundaries_sources_rain_and_sections_read_back_as_themselves() {
        let start = "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.033}\nresolution: 20 m\ntime: {end: 1 h}\n";
        let boundaries = r#"
boundaries:
  - {side: all, type: open}
  - {edge: west, discharge: 250 l/s}
  - {lines: in.gpkg:upper, discharge: {series: q.csv, column: "Q, peak", unit: ft3/s, time: t, time_unit: h}, level: 12.3 m}
  - {lines: tide.geojson, stage: {series: tide.csv, after_end: hold}}
  - {side: north, level: 3 m}
  - {lines: swell.geojson, wave: {series: swell.csv}, still: {series: tide.csv}}
  - {lines: bay.geojson, wave: 3.2 m}
  - {side: south, normal_depth: {slope: 2 %}}
  - {side: east, rating: {table: w.csv, level: h, level_unit: cm, discharge_unit: m3/s}}
  - {lines: sea.geojson, type: free}
"#;
        let sources = "sources: [{at: [712345.5, -3.25], discharge: 2 m3/s}, {points: springs.gpkg:wells, discharge: {series: q.csv, unit: l/s}}, \
            {line: seep.gpkg:toe, discharge: 3 l/s}]\n";
        let rate =
            "rain: {rate: {series: rain.csv, unit: mm/h}, losses: {initial: 5 mm}}\noutputs: {sections: s.geojson}\n";
        let raster = "rain: {raster: rain.tif, unit: in/h, duration: 2 h, losses: {constant: 1 mm/h}}\n";
        let files = "rain: {raster_series: radar list.csv, unit: mm, stamp: end}\n";
        let netcdf = "rain: {raster_series: radar.nc:rate, start: 2026-06-01 06:00, losses: {initial: 2 mm}}\n";
        for rain in [rate, raster, files, netcdf] {
            assert_round_trip(&format!("{start}{boundaries}{sources}{rain}"));
        }
    }

    #[test]
    fn every_kind_of_roughness_reads_back_as_itself() {
        let kinds = [
            "{raster: manning.tif}",
            "{raster: land cover.tif, table: manning.csv, default: 0.05, polygons: areas.gpkg:rough}",
            "{manning: 0.04, polygons: areas.geojson}",
        ];
        for kind in kinds {
            assert_round_trip(&format!(
                "floodsim: 1\nterrain: dem.tif\nroughness: {kind}\ninitial: [{{sea: a.geojson, level: 0.1 m}}]\n\
                 resolution: 20 m\ntime: {{end: 1 h}}\n"
            ));
        }
    }

    #[test]
    fn a_preset_reads_back_as_its_choices() {
        assert_round_trip(
            "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.033}\ninitial: [{sea: a.geojson, level: 0.1 m}]\n\
             resolution: 20 m\ntime: {end: 1 h}\nnumerics: {preset: fast, cfl: 0.4}\n",
        );
    }

    #[test]
    fn a_scenario_with_every_key_reads_back_as_itself() {
        assert_round_trip(
            r#"
floodsim: 1
title: "a \"quoted\" title: with # signs, and ä\n"
crs: EPSG:27572
terrain:
  layers:
    - {points: survey.txt, interpolation: natural_neighbour, max_gap: 0.3 km, offset: -12.5 cm}
    - {raster: "b: 1.tif", unit: us_ft, offset: 1 ft, clip: "c.gpkg:in it", mode: min}
  reproject: true
  gaps: {fill: idw, max_cells: 12}
  breaklines:
    - {lines: a.gpkg:levee, mode: raise, z_field: "crest, m", width: 3 ft}
    - {lines: b.shp, mode: carve, z: 12.5 m}
    - {lines: c.shp, mode: raise}
roughness: {manning: 0}
structures:
  walls: [{lines: "walls.gpkg:dam wall"}, {lines: low.geojson, crest: 3 m}, {lines: lower.geojson, crest_field: z}]
  buildings: {polygons: b.gpkg:houses, mode: raise, height_field: h}
initial:
  - {reservoir: r.gpkg:lake, level_field: pegel}
  - {water: w.shp}
boundaries: [{side: all, type: open}, {lines: outlet.geojson, type: open}]
resolution: 0.1 m
time: {end: 3 d, reference: "1959-12-02 21:14"}
outputs:
  folder: out
  write: [tables, fields]
  cell: 7 m
  every: 1 min
  gauges: g.csv
  gauges_every: 333 ms
  arrival: {thresholds: [0.3 m, 1 ft], rise_on_wet: 1 mm}
  isochrones: []
numerics: {formulation: variational, seeding: equal_volume, bed: shepard, bed_slope: steep, wall: virtual_particles, cfl: 0.123456789, gravity: 3.71, dry_depth: 0.1 mm}
limits: {memory: 1.5 GiB, particles: 1e6}
"#,
        );
    }
}
