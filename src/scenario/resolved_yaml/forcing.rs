//! What comes in over time, in the resolved scenario: boundaries, sources, rain, and the breach of a dam.

use super::{file, name_of, open_place, vector};
use crate::scenario::model::{
    AfterEnd, BoundaryCondition, Breach, BreachFormula, BreachMode, BreachTrigger, GrowthLaw, Rain, RainAmount,
    Scenario, SourcePlace, Stamp, TableFile, Timed,
};
use crate::scenario::yaml::{Section, Yaml, point, quantity, quoted};

impl Scenario {
    /// Boundaries, sources and rain.
    pub(super) fn forcing(&self) -> Section {
        let open = self.open.iter().map(|place| Yaml::Entry(open_place(place).with("type", "open")));
        let boundaries = self
            .boundaries
            .iter()
            .map(|boundary| Yaml::Entry(open_place(&boundary.value.place).and(condition(&boundary.value.condition))));
        let sources = self.sources.iter().map(|source| {
            let place = match &source.value.place {
                SourcePlace::At(at) => Section::default().with("at", point(at.value)),
                SourcePlace::Points(points) => Section::default().with("points", vector(points)),
                SourcePlace::Lines(lines) => Section::default().with("lines", vector(lines)),
            };
            Yaml::Entry(place.with("discharge", timed(&source.value.discharge, "m3/s")))
        });
        Section::default()
            .with_list("boundaries", open.chain(boundaries).collect())
            .with_list("sources", sources.collect())
            .with_some("rain", self.rain.as_ref().map(|rain| falling(&rain.value)))
    }
}

fn falling(rain: &Rain) -> Section {
    let amount = match &rain.amount {
        RainAmount::Rate(rate) => Section::default().with("rate", timed(rate, "m/s")),
        RainAmount::Raster { file: raster, unit } => {
            Section::default().with("raster", file(&raster.value)).with("unit", quoted(&unit.0))
        }
        RainAmount::Series { file: rasters, unit, stamp, start } => Section::default()
            .with("raster_series", vector(rasters))
            .with_some("unit", unit.as_ref().map(|(unit, _)| quoted(unit)))
            .with_some("stamp", stamp.map(|stamp| name_of(|candidate: &Stamp| *candidate == stamp)))
            .with_some("start", start.map(|start| quoted(&start.to_string()))),
    };
    let losses = Section::default()
        .with("initial", quantity(rain.initial_loss, "m"))
        .with("constant", quantity(rain.constant_loss, "m/s"));
    amount
        .with_some("duration", rain.duration.map(|duration| quantity(duration, "s")))
        .with("losses", Yaml::Entry(losses))
}

/// The breach of a dam.
pub(super) fn breach(breach: &Breach) -> Section {
    let trigger = match &breach.trigger {
        BreachTrigger::At(at) => Section::default().with("at", quantity(at.value, "s")),
        BreachTrigger::Level { level, place } => {
            Section::default().with("level", quantity(level.value, "m")).with("at_point", point(place.value))
        }
    };
    let shape = breach.shape.as_ref().map(|shape| {
        Section::default()
            .with("bottom_width", quantity(shape.bottom_width.value, "m"))
            .with("side_slope", shape.side_slope)
            .with("invert", quantity(shape.invert.value, "m"))
            .with_some("position", shape.position.as_ref().map(|place| point(place.value)))
    });
    let method = breach.method.as_ref().map(|method| {
        Section::default()
            .with("name", name_of(|candidate: &BreachFormula| *candidate == method.formula))
            .with("mode", name_of(|candidate: &BreachMode| *candidate == method.mode))
            .with("volume", quantity(method.volume.value, "m3"))
            .with("invert", quantity(method.invert.value, "m"))
            .with_some("position", method.position.as_ref().map(|place| point(place.value)))
    });
    let growth = method.is_none().then(|| growth(breach));
    Section::default()
        .with("dam", vector(&breach.dam))
        .with_some("crest", breach.crest.as_ref().map(|crest| quantity(crest.value, "m")))
        .with_some("crest_field", breach.crest_field.as_deref().map(quoted))
        .with("trigger", Yaml::Entry(trigger))
        .with_some("shape", shape.map(Yaml::Entry))
        .with_some("method", method.map(Yaml::Entry))
        .with_some("growth", growth)
}

fn growth(breach: &Breach) -> Yaml {
    let law = name_of(|candidate: &GrowthLaw| *candidate == breach.law);
    let of_law = Section::default().with("law", law);
    match (&breach.duration, &breach.share) {
        (_, Some(share)) => Yaml::Entry(of_law.with("share", series(share))),
        (Some(duration), None) => Yaml::Entry(of_law.with("duration", quantity(duration.value, "s"))),
        (None, None) => law.into(),
    }
}

/// The keys of a condition.
pub(super) fn condition(condition: &BoundaryCondition) -> Section {
    let section = Section::default();
    let level = |level: &Timed| timed(level, "m");
    match condition {
        BoundaryCondition::Free => section.with("type", "free"),
        BoundaryCondition::Discharge { discharge, level: outer } => {
            section.with("discharge", timed(discharge, "m3/s")).with_some("level", outer.as_ref().map(level))
        }
        BoundaryCondition::Stage(stage) => section.with("stage", level(stage)),
        BoundaryCondition::Level(held) => section.with("level", level(held)),
        BoundaryCondition::Wave { level: wave, still } => {
            section.with("wave", level(wave)).with_some("still", still.as_ref().map(level))
        }
        BoundaryCondition::NormalDepth(slope) => {
            section.with("normal_depth", Yaml::Entry(Section::default().with("slope", slope.value)))
        }
        BoundaryCondition::Rating(table) => {
            let names = [["level", "level_unit"], ["discharge", "discharge_unit"]];
            let of_file = Section::default().with("table", file(&table.file.value));
            section.with("rating", Yaml::Entry(of_file.and(columns(table, names))))
        }
    }
}

/// A quantity over time; `unit` is that of SI.
pub(super) fn timed(timed: &Timed, unit: &str) -> Yaml {
    match timed {
        Timed::Constant(value) => quantity(value.value, unit),
        Timed::Series(table) => series(table),
    }
}

/// A series in a table.
pub(super) fn series(table: &TableFile) -> Yaml {
    let after_end = table.after_end.map(|AfterEnd::Hold| "hold");
    Yaml::Entry(
        Section::default()
            .with("series", file(&table.file.value))
            .and(columns(table, [["time", "time_unit"], ["column", "unit"]]))
            .with_some("after_end", after_end),
    )
}

/// The columns of a table and their units, as far as they are given, by the keys of both.
fn columns(table: &TableFile, names: [[&'static str; 2]; 2]) -> Section {
    table.columns.iter().zip(names).fold(Section::default(), |section, (column, [name, unit])| {
        section
            .with_some(name, column.name.as_deref().map(quoted))
            .with_some(unit, column.unit.as_ref().map(|(unit, _)| quoted(unit)))
    })
}
