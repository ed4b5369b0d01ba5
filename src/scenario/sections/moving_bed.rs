//! Beds that move as prescribed: their sections, and what becomes of them.

use crate::scenario::choices::{Chosen, ElevationUnit};
use crate::scenario::fields::{InputFile, Moment, Quantity, VectorFile, Velocity};
use crate::scenario::model::{BedMovement, MovingBed, Sourced};
use crate::scenario::read::{Reader, section};
use crate::scenario::timed::{self, Changing, ShareSeries};
use crate::scenario::tree::Node;
use crate::scenario::yaml::{Section, Yaml, file, name_of, quantity, vector};

section! {
    /// A part of the bed that moves as prescribed: ground that rises or sinks, or a slide that runs along a line.
    MovingBedEntry, example "{change: uplift.tif, at: 10 s}", check check_moving_bed {
        /// Raster of the final change of the bed, positive upwards; no data is no change; `thickness` is required when absent.
        /// Codes: moves-nothing, moves-without-terrain, change-volume, doubtful-change, moves-dam, moves-boundary.
        change: Option<InputFile>,
        /// Raster of the thickness of a slide where it lies at the start; no data is 0; `change` is required when absent. Codes:
        /// moves-nothing, negative-value, slide-volume, doubtful-change, moves-dam, moves-boundary.
        thickness: Option<InputFile>,
        /// Unit of the raster; metres when absent. Codes: doubtful-change, moves-nothing.
        unit: Option<Chosen<ElevationUnit>>,
        /// Time at which it begins, from which the times of its series count; 0 s when absent. Codes: moves-after-end.
        at: Option<Quantity<Moment>>,
        /// With `change`: series of its share, from 0 to 1 (or in `%`), against the time since it began; all at once when absent.
        /// Codes: growth-start, growth-end, falling-share, short-table, series-gap, moves-at-end.
        share: Option<ShareSeries>,
        /// With `thickness`: file with the line along which the slide runs, at whose end it stops; required with `thickness` when
        /// absent. Codes: slide-lines, slide-outside, slide-rests, path-beside-slide, slide-uphill.
        path: Option<VectorFile>,
        /// With `thickness`: velocity of the slide along its line, constant or a series that holds on behind its last row;
        /// required with `thickness` when absent. Codes: slide-rests, negative-value, series-held.
        velocity: Option<Changing<Velocity>>,
    }
}

fn check_moving_bed(node: &Node, reader: &mut Reader) -> Option<()> {
    let kind = reader.exactly_one(node, &["change", "thickness"])?;
    let (needed, foreign): (&[(&str, &str)], &[&str]) = match kind {
        "change" => (&[], &["path", "velocity"]),
        _ => (&[("path", "path: axis.geojson"), ("velocity", "velocity: 20 m/s")], &["share"]),
    };
    let mut is_fit = true;
    for name in foreign {
        if let Some(value) = node.get(name) {
            reader.error(value, "conflict", format!("`{name}` does not go with `{kind}`"), "take it out");
            is_fit = false;
        }
    }
    for (name, example) in needed {
        if !node.has(name) {
            let message = format!("a slide needs the key `{name}`");
            reader.error(node, "missing-key", message, format!("add for example `{example}`"));
            is_fit = false;
        }
    }
    is_fit.then_some(())
}

/// The moving beds of the sections, with their defaults.
pub(super) fn resolved(entries: Vec<MovingBedEntry>) -> Vec<MovingBed> {
    let one = |(index, entry): (usize, MovingBedEntry)| {
        let begin = Sourced { value: 0.0, key: format!("moving_bed[{index}].at"), place: None };
        let (raster, law) = match (entry.change, entry.thickness) {
            (Some(change), _) => (change.0, BedMovement::InPlace(entry.share.map(|share| share.0))),
            (None, thickness) => {
                (thickness?.0, BedMovement::Slide { path: entry.path?.0, velocity: entry.velocity?.timed })
            }
        };
        let unit = entry.unit.map_or(ElevationUnit(1.0), |unit| unit.0.value).0;
        Some(MovingBed { raster, unit, at: entry.at.map_or(begin, |at| at.sourced), law })
    };
    entries.into_iter().enumerate().filter_map(one).collect()
}

/// A moving bed in the resolved scenario.
pub(super) fn written(bed: &MovingBed) -> Yaml {
    let key = if matches!(bed.law, BedMovement::InPlace(_)) { "change" } else { "thickness" };
    let section = Section::default()
        .with(key, file(&bed.raster.value))
        .with("unit", name_of(|candidate: &ElevationUnit| candidate.0.to_bits() == bed.unit.to_bits()))
        .with("at", quantity(bed.at.value, "s"));
    Yaml::Entry(match &bed.law {
        BedMovement::InPlace(share) => section.with_some("share", share.as_ref().map(timed::series_written)),
        BedMovement::Slide { path, velocity } => {
            section.with("path", vector(path)).with("velocity", timed::written(velocity, "m/s"))
        }
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::error::{Error, ProblemKind};
    use crate::scenario::model::Timed;
    use crate::scenario::{Loaded, Scenario, resolve};

    fn load(moving_bed: &str) -> Result<Loaded, Error> {
        let text = format!(
            "floodsim: 1\nterrain: dem.tif\nroughness: {{manning: 0.03}}\ninitial: [{{reservoir: lake.geojson, level: 100 m}}]\n\
             resolution: 5 m\ntime: {{end: 1 h}}\nmoving_bed: {moving_bed}\n"
        );
        resolve(&text, Path::new("/somewhere/scenario.yaml"), &[])
    }

    /// The moving beds without places.
    fn plain(scenario: Scenario) -> Vec<MovingBed> {
        let mut beds = scenario.moving_bed;
        for bed in &mut beds {
            (bed.raster.place, bed.at.place) = (None, None);
            match &mut bed.law {
                BedMovement::InPlace(share) => share.iter_mut().for_each(|share| share.file.place = None),
                BedMovement::Slide { path, velocity } => {
                    path.place = None;
                    match velocity {
                        Timed::Constant(value) => value.place = None,
                        Timed::Series(table) => table.file.place = None,
                    }
                }
            }
        }
        beds
    }

    #[test]
    fn every_kind_is_read_and_reads_back_as_itself() {
        let text = "[{change: up.tif}, {change: up.tif, unit: cm, at: 2 min, share: {series: p.csv, unit: '%', time_unit: s}}, \
                    {thickness: t.tif, path: 'gis.gpkg:axis', velocity: 72 km/h}, \
                    {thickness: t.tif, at: 3 s, path: axis.shp, velocity: {series: v.csv, unit: m/s}}]";
        let first = load(text).unwrap().scenario;
        let second = resolve(&first.to_yaml(), Path::new("/elsewhere/s.yaml"), &[]).unwrap().scenario;
        let beds = plain(first);
        assert_eq!(beds, plain(second));
        assert!((beds[1].unit - 0.01).abs() < 1e-15 && (beds[1].at.value - 120.0).abs() < 1e-12);
        let BedMovement::Slide { velocity: Timed::Constant(velocity), .. } = &beds[2].law else { panic!("{beds:?}") };
        assert!((velocity.value - 20.0).abs() < 1e-12);
    }

    #[test]
    fn what_does_not_go_together_is_refused_where_it_stands() {
        for (text, code, key) in [
            ("[{at: 3 s}]", "missing-key", "moving_bed[0]"),
            ("[{change: a.tif, thickness: b.tif}]", "conflict", "moving_bed[0]"),
            ("[{change: a.tif, path: c.shp}]", "conflict", "moving_bed[0].path"),
            ("[{thickness: a.tif, path: c.shp}]", "missing-key", "moving_bed[0]"),
            ("[{thickness: a.tif, velocity: 3 m/s}]", "missing-key", "moving_bed[0]"),
            ("[{thickness: a.tif, path: c.shp, velocity: 3 m}]", "unit", "moving_bed[0].velocity"),
            (
                "[{thickness: a.tif, path: c.shp, velocity: 3 m/s, share: {series: p.csv}}]",
                "conflict",
                "moving_bed[0].share",
            ),
            ("[{change: a.tif, at: -3 s}]", "range", "moving_bed[0].at"),
            ("[{change: a.tif}]\nnumerics: {formulation: variational}", "method-combination", "moving_bed"),
        ] {
            let Err(Error::Problems(found)) = load(text) else { panic!("not refused: {text}") };
            let problem = found.into_iter().find(|problem| problem.kind == ProblemKind::Scenario).unwrap();
            assert_eq!((problem.code, problem.key.as_str()), (code, key), "{text}: {problem}");
        }
    }
}
