//! `rain`.

use crate::scenario::choices::Chosen;
use crate::scenario::fields::{DateTime, Duration, Height, InputFile, Intensity, Quantity, RasterSeriesFile, Text};
use crate::scenario::model::{Rain, RainAmount, RainUnit, Sourced, Stamp};
use crate::scenario::read::{Reader, section};
use crate::scenario::timed::{self, Changing};
use crate::scenario::tree::Node;
use crate::scenario::units::{INTENSITY, LENGTH};
use crate::scenario::yaml::{Section, Yaml, file, name_of, quantity, quoted, vector};

section! {
    /// Rain on the whole terrain, by one of `rate`, `raster` and `raster_series`.
    RainSection, example "{rate: 20 mm/h}", check check_rain {
        /// Intensity everywhere, constant or a series; `raster` or `raster_series` is required when absent. Codes: rain-doubtful,
        /// rain-without-water.
        rate: Option<Changing<Intensity>>,
        /// Raster of intensities, constant in time; `rate` or `raster_series` is required when absent. Codes: rain-gap,
        /// negative-value, rain-doubtful, rain-without-water, other-unit.
        raster: Option<InputFile>,
        /// Rasters over time: NetCDF (`radar.nc`, `radar.nc:rainfall`), or a CSV list of times and raster files; `rate` or
        /// `raster` is required when absent. Codes: rain-outside, rain-gap, series-ends-early, accumulated-rain, other-grid,
        /// not-a-list.
        raster_series: Option<RasterSeriesFile>,
        /// Unit of the values; in a series a length (`mm`) is what falls within the interval of a raster; that of the NetCDF
        /// variable when absent. Codes: missing-unit, other-unit, rain-doubtful, accumulated-rain.
        unit: Option<Text>,
        /// Which end of its interval the time of a raster is; begin, or the bounds of a NetCDF file where it has them, when
        /// absent. Codes: stamp-beside-bounds, bad-bounds, too-few-rasters.
        stamp: Option<Chosen<Stamp>>,
        /// Date and time at which the run begins, for the dates of a NetCDF file or of a list; `time.reference` when absent.
        /// Codes: date, no-start, two-starts, start-without-date, no-time, packed-times.
        start: Option<DateTime>,
        /// How long it rains; to the end of the run when absent. Codes: series-ends-early.
        duration: Option<Quantity<Duration>>,
        /// Rain that does not run off; none when absent.
        losses: Option<Losses>,
    }
}

section! {
    /// Rain that does not run off. Water that lies on the ground is never lost.
    Losses, example "{initial: 5 mm, constant: 2 mm/h}" {
        /// The first rain, such as `5 mm`; 0 mm when absent. Codes: losses-after-earlier-run, rain-without-water.
        initial: Option<Quantity<Height>>,
        /// What is lost of the rain from then on, such as `2 mm/h`; 0 mm/h when absent. Codes: rain-without-water.
        constant: Option<Quantity<Intensity>>,
    }
}

fn check_rain(node: &Node, reader: &mut Reader) -> Option<()> {
    let amount = reader.exactly_one(node, &["rate", "raster", "raster_series"])?;
    let mut is_fit = true;
    for name in ["stamp", "start"] {
        if let Some(value) = node.get(name).filter(|_| amount != "raster_series") {
            reader.error(value, "conflict", format!("`{name}` goes with `raster_series`"), "take it out");
            is_fit = false;
        }
    }
    if !is_fit {
        return None;
    }
    match (amount, node.get("unit")) {
        ("raster_series", Some(unit)) => {
            let text = reader.text(unit, "a unit", "mm/h")?.trim().to_owned();
            if RainUnit::named(&text).is_none() {
                let message = format!("`{text}` is no unit of rain");
                let remedy = format!(
                    "use one of {} for intensities, or of {} for what falls within each interval",
                    INTENSITY.unit_list(),
                    LENGTH.unit_list()
                );
                reader.error(unit, "unit", message, remedy);
                return None;
            }
            Some(())
        }
        ("raster", None) => {
            let remedy = format!("add `unit: mm/h`, or one of {}", INTENSITY.unit_list());
            reader.error(node, "missing-key", "a raster of rain needs the key `unit`", remedy);
            None
        }
        ("raster", Some(unit)) => {
            let text = reader.text(unit, "a unit", "mm/h")?.trim().to_owned();
            if INTENSITY.factor_of(&text).is_none() {
                let message = format!("`{text}` is no unit of {}", INTENSITY.name);
                reader.error(unit, "unit", message, format!("use one of {}", INTENSITY.unit_list()));
                return None;
            }
            Some(())
        }
        (_, Some(unit)) => {
            let remedy = "take it out: a rate carries its unit, and a series has a `unit` of its own";
            reader.error(unit, "conflict", "`unit` goes with `raster` and `raster_series`", remedy);
            None
        }
        (_, None) => Some(()),
    }
}

pub(super) fn resolved(section: RainSection) -> Option<Sourced<Rain>> {
    let (amount, place) = match (section.rate, section.raster, section.unit) {
        (Some(rate), _, _) => {
            let place = rate.timed.source().1.cloned();
            (RainAmount::Rate(rate.timed), place)
        }
        (None, Some(raster), Some(unit)) => {
            let factor = INTENSITY.factor_of(unit.0.value.trim())?;
            let place = raster.0.place.clone();
            (RainAmount::Raster { file: raster.0, unit: (unit.0.value.trim().to_owned(), factor) }, place)
        }
        (None, None, unit) => {
            let file = section.raster_series?.0;
            let unit = unit.map(|unit| unit.0.value.trim().to_owned());
            let unit = unit.and_then(|unit| RainUnit::named(&unit).map(|known| (unit, known)));
            let (place, start) = (file.place.clone(), section.start.map(|start| start.0));
            (RainAmount::Series { file, unit, stamp: section.stamp.map(|stamp| stamp.0.value), start }, place)
        }
        _ => return None,
    };
    let (initial, constant) = section.losses.map_or((None, None), |losses| (losses.initial, losses.constant));
    let value = Rain {
        amount,
        duration: section.duration.map(|duration| duration.value()),
        initial_loss: initial.map_or(0.0, |initial| initial.value()),
        constant_loss: constant.map_or(0.0, |constant| constant.value()),
    };
    Some(Sourced { value, key: "rain".to_owned(), place })
}

/// Rain in the resolved scenario.
pub(super) fn written(rain: &Rain) -> Section {
    let amount = match &rain.amount {
        RainAmount::Rate(rate) => Section::default().with("rate", timed::written(rate, "m/s")),
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
