//! What a run tells its planner at the end, on stdout.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use super::progress::clock_time;
use crate::math::readable;
use crate::output::{ChannelGaugeResult, Gauge, GaugeResult, RunManifest, Section, SectionResult};
use crate::seeding::{FluidSeed, SeededVolume};

/// The particles of the variational formulation at the start, in short.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingAtStart {
    /// How many there are.
    pub count: usize,
    /// The volume of all together (m³).
    pub volume_m3: f64,
    /// The volumes of the smallest and of the largest one (m³).
    pub range_m3: Range<f64>,
}

impl MovingAtStart {
    /// None where nothing moves.
    pub(super) fn of(seeds: &[FluidSeed]) -> Option<Self> {
        let volumes = || seeds.iter().map(|seed| seed.volume);
        (!seeds.is_empty()).then(|| MovingAtStart {
            count: seeds.len(),
            volume_m3: volumes().sum(),
            range_m3: volumes().fold(f64::INFINITY, f64::min)..volumes().fold(0.0, f64::max),
        })
    }
}

/// The result of a run in short; its text is meant for people.
#[derive(Clone, Debug)]
pub struct RunSummary {
    /// The run folder.
    pub folder: PathBuf,
    /// The record of the run.
    pub manifest: RunManifest,
    /// Volumes of the bodies of still water.
    pub seeded: Vec<SeededVolume>,
    /// The particles of the variational formulation at the start, where there are any.
    pub moving: Option<MovingAtStart>,
    /// The gauges and what they saw.
    pub gauges: Vec<(Gauge, GaugeResult)>,
    /// The cross-sections and what passed them.
    pub sections: Vec<(Section, SectionResult)>,
    /// What the gauges in channels saw.
    pub channel_gauges: Vec<ChannelGaugeResult>,
}

impl fmt::Display for RunSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_start(f)?;
        write_cost(f, &self.manifest)?;
        write_breach(f, &self.manifest)?;
        write_bed_and_banks(f, &self.manifest)?;
        write_balance(f, &self.manifest)?;
        write_tracers(f, &self.manifest)?;
        write_error(f, &self.manifest)?;
        write_gauges(f, &self.gauges)?;
        write_sections(f, &self.sections)?;
        write_channel_gauges(f, &self.channel_gauges)?;
        writeln!(f, "results in {}", self.folder.display())
    }
}

impl RunSummary {
    /// The water of the start and the cells in part below it.
    fn write_start(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, volume) in self.seeded.iter().enumerate() {
            writeln!(
                f,
                "water {number}: {:.6e} m3 seeded in {} cells, integral of level minus terrain {:.6e} m3 ({:+.3} %)",
                volume.seeded_m3,
                volume.cells,
                volume.integral_m3,
                100.0 * volume.relative_error()
            )?;
            write_shore(f, volume)?;
        }
        if let Some(moving) = &self.moving {
            let integral: f64 = self.seeded.iter().map(|volume| volume.integral_m3).sum();
            let off = if integral > 0.0 { 100.0 * (moving.volume_m3 / integral - 1.0).abs() } else { 0.0 };
            let Range { start: least, end: greatest } = &moving.range_m3;
            writeln!(
                f,
                "particles: {} with {least:.4e} to {greatest:.4e} m3 each, {:.6e} m3 together ({off:.3} % off the integral)",
                moving.count, moving.volume_m3
            )?;
        }
        if let Some(part) = &self.manifest.terrain_part {
            writeln!(f, "terrain: {part}")?;
        }
        write_resolution(f, &self.manifest)?;
        if let Some(part) = &self.manifest.cells_in_part {
            let (least, greatest) = (part.least, part.greatest);
            writeln!(
                f,
                "edge of the terrain: {} cells count in part, for {least:.2} of a cell to {greatest:.2}",
                part.cells
            )?;
        }
        if let Some(banks) = &self.manifest.banks {
            writeln!(f, "steep banks that cells follow: {}, together {:.1} m", banks.lines, banks.length_m)?;
        }
        Ok(())
    }
}

/// How the spacing was chosen, and the cells of each level with the reasons for them; nothing of one spacing that the scenario has.
fn write_resolution(f: &mut fmt::Formatter<'_>, run: &RunManifest) -> fmt::Result {
    for (number, reason) in run.resolution.iter().flat_map(|choice| &choice.because).enumerate() {
        writeln!(f, "{}{reason}", if number == 0 { "resolution: " } else { "  " })?;
    }
    for level in run.levels.iter().filter(|level| level.cells > 0) {
        let mut reasons: Vec<(&&str, &f64)> = level.area_m2.iter().collect();
        reasons.sort_by(|one, other| other.1.total_cmp(one.1));
        let all: f64 = level.area_m2.values().sum();
        let share = |(because, area): &(&&str, &f64)| format!("{because} {:.0} %", 100.0 * *area / all);
        let reasons: Vec<String> = reasons.iter().map(share).collect();
        writeln!(f, "level of {} m: {} cells ({})", readable(level.spacing_m), level.cells, reasons.join(", "))?;
    }
    Ok(())
}

/// Times, steps and memory of the run.
fn write_cost(f: &mut fmt::Formatter<'_>, run: &RunManifest) -> fmt::Result {
    writeln!(
        f,
        "simulated {} in {:.1} s ({:.1} CPU s, {} threads): {} steps, {:.3e} particle evaluations, peak memory {:.0} MiB",
        clock_time(run.simulated_s),
        run.wall_s,
        run.cpu_s,
        run.threads,
        run.steps,
        run.particle_evaluations as f64,
        run.peak_rss_mb
    )
}

/// When the dam broke and what opened; nothing where there is no dam.
fn write_breach(f: &mut fmt::Formatter<'_>, run: &RunManifest) -> fmt::Result {
    let Some(breach) = &run.breach else { return Ok(()) };
    match breach.began_s {
        Some(time) => write!(f, "the dam broke at {}", clock_time(time))?,
        None => write!(f, "the dam stood to the end")?,
    }
    if let (Some(width), Some(invert), Some(slope)) = (breach.bottom_width_m, breach.invert_m, breach.side_slope) {
        let minutes = breach.duration_s / 60.0;
        write!(
            f,
            "; its opening: {width:.1} m wide at {invert:.2} m, sides {slope:.1} to 1, formation time {minutes:.1} min"
        )?;
    }
    writeln!(f)
}

/// Channels whose water stood above their sections, and the bed that moved; nothing where there are none.
fn write_bed_and_banks(f: &mut fmt::Formatter<'_>, run: &RunManifest) -> fmt::Result {
    for above in &run.above_banks {
        writeln!(
            f,
            "channel {}: its water stood {:.2} m above the last row of its sections, {:.0} m from its far end at {}; what would have left it there stayed in",
            above.channel,
            above.height_m,
            above.distance_m,
            clock_time(above.time_s)
        )?;
    }
    if let Some(bed) = &run.moving_bed {
        writeln!(
            f,
            "the bed moved: {:.4e} m3 above that of the start, {:.4e} m3 below; it lifted water by {:.4e} m3 and lowered it by {:.4e} m3",
            bed.raised_m3, bed.sunk_m3, bed.lifted_m3, bed.lowered_m3
        )?;
    }
    Ok(())
}

/// The volume balance, and the gates that warn.
fn write_balance(f: &mut fmt::Formatter<'_>, run: &RunManifest) -> fmt::Result {
    let volume = &run.volume_m3;
    let on_grid = match run.bed_particles {
        0 => String::new(),
        _ => format!(", on the grid {:.1e}", volume.grid_error_relative),
    };
    writeln!(
        f,
        "volume {:.6e} m3 at the start, inflow {:.6e} m3, outflow {:.6e} m3, {:.6e} m3 at the end; error {:.1e}{on_grid}",
        volume.initial, volume.inflow, volume.outflow, volume.last, volume.error_relative,
    )?;
    if let Some(held) = &volume.held_back {
        writeln!(
            f,
            "held back of {:.6e} m3 of rain: {:.6e} m3 in films thinner than the dry depth, {:.6e} m3 in pits of the bed",
            held.of_rain_m3, held.in_films_m3, held.in_pits_m3
        )?;
    }
    for gate in run.gates.iter().filter(|gate| !gate.passed && !gate.binding) {
        writeln!(f, "{gate}")?;
    }
    Ok(())
}

/// The balance of each tracer; nothing where there are none.
fn write_tracers(f: &mut fmt::Formatter<'_>, run: &RunManifest) -> fmt::Result {
    for tracer in &run.tracers {
        writeln!(
            f,
            "tracer {}: {:.6e} at the start, in {:.6e}, out {:.6e}, decayed {:.6e}, {:.6e} {} at the end; error {:.1e}",
            tracer.name,
            tracer.initial,
            tracer.inflow,
            tracer.outflow,
            tracer.decayed,
            tracer.stored,
            tracer.unit,
            tracer.error_relative
        )?;
    }
    Ok(())
}

/// The estimated error of the maps; nothing where none is asked for.
fn write_error(f: &mut fmt::Formatter<'_>, run: &RunManifest) -> fmt::Result {
    let Some(error) = &run.error_estimate else { return Ok(()) };
    writeln!(
        f,
        "estimated error, by a run on cells of {} m: maximum depth {} m in the mean, {} m in 95 % of the flooded cells; arrival {} s and {} s",
        readable(error.spacing_m),
        number(error.mean_depth_m, 3),
        number(error.depth_95_m, 3),
        number(error.mean_arrival_s, 1),
        number(error.arrival_95_s, 1)
    )
}

/// A value with so many digits, or a dash where there is none.
fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
}

/// The gauges; nothing where there are none.
fn write_gauges(f: &mut fmt::Formatter<'_>, gauges: &[(Gauge, GaugeResult)]) -> fmt::Result {
    if !gauges.is_empty() {
        writeln!(f, "{:<12} {:>10} {:>10} {:>10} {:>10}", "gauge", "arrival s", "max m", "level m", "speed m/s")?;
    }
    for (gauge, result) in gauges {
        writeln!(
            f,
            "{:<12} {:>10} {:>10} {:>10} {:>10}",
            gauge.id,
            number(result.arrival, 1),
            number(result.max_depth, 2),
            number(result.max_level, 2),
            number(result.max_speed, 2)
        )?;
    }
    Ok(())
}

/// The cross-sections; nothing where there are none.
fn write_sections(f: &mut fmt::Formatter<'_>, sections: &[(Section, SectionResult)]) -> fmt::Result {
    if !sections.is_empty() {
        writeln!(f, "{:<12} {:>10} {:>12} {:>10} {:>12}", "section", "arrival s", "peak m3/s", "at s", "volume m3")?;
    }
    for (section, result) in sections {
        writeln!(
            f,
            "{:<12} {:>10} {:>12.4} {:>10} {:>12.4e}",
            section.id,
            number(result.arrival, 1),
            result.peak_discharge,
            number(result.time_of_peak, 1),
            result.volume
        )?;
    }
    Ok(())
}

/// The gauges in channels; nothing where there are none.
fn write_channel_gauges(f: &mut fmt::Formatter<'_>, gauges: &[ChannelGaugeResult]) -> fmt::Result {
    if !gauges.is_empty() {
        writeln!(
            f,
            "{:<12} {:<12} {:>10} {:>10} {:>10} {:>10} {:>12}",
            "gauge", "in channel", "arrival s", "max m", "level m", "speed m/s", "peak m3/s"
        )?;
    }
    for seen in gauges {
        writeln!(
            f,
            "{:<12} {:<12} {:>10} {:>10.2} {:>10} {:>10.2} {:>12.4}",
            seen.id,
            seen.channel,
            number(seen.arrival, 1),
            seen.max_depth,
            number(seen.max_level, 2),
            seen.max_speed,
            seen.peak_discharge
        )?;
    }
    Ok(())
}

/// What less than this share of a body makes at the edge of the terrain or at banks is not worth a word.
const TOLD_SHARE: f64 = 1e-4;

/// What was done to the bed and to cells so that a body of water is level and holds its volume; nothing where nothing was.
fn write_shore(f: &mut fmt::Formatter<'_>, water: &SeededVolume) -> fmt::Result {
    let mut parts = Vec::new();
    if water.shore_cells > 0 {
        let change = water.largest_bed_change_at_shore;
        parts.push(format!(
            "ground changed in {} shoreline cells (by up to {change:.2} m) so that the stored volume is exact",
            water.shore_cells
        ));
    }
    if water.largest_bed_change_under_water > 0.0 {
        parts.push(format!("under water by up to {:.2} m", water.largest_bed_change_under_water));
    }
    if water.pocket_cells > 0 {
        parts.push(format!("{} cells filled beside the polygon, where the lake ends", water.pocket_cells));
    }
    if water.at_edge_m3 > TOLD_SHARE * water.integral_m3 {
        parts.push(format!("{:.4e} m3 beside the polygon, up to the edge of the terrain", water.at_edge_m3));
    }
    if water.share_at_banks().abs() > TOLD_SHARE {
        parts.push(format!("{:+.4e} m3 in cells at upright banks, whose ground is unchanged", water.at_banks_m3));
    }
    if water.toggled > 0 {
        parts.push(format!("{} cells at the open rim taken in or left out", water.toggled));
    }
    if parts.is_empty() { Ok(()) } else { writeln!(f, "  to hold its volume: {}", parts.join("; ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shore_takes_one_line_or_none() {
        struct Shown(SeededVolume);
        impl fmt::Display for Shown {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write_shore(f, &self.0)
            }
        }
        let mut water = SeededVolume::default();
        assert_eq!(Shown(water.clone()).to_string(), "");
        water.toggled = 3;
        assert_eq!(
            Shown(water.clone()).to_string(),
            "  to hold its volume: 3 cells at the open rim taken in or left out\n"
        );
        water = SeededVolume { shore_cells: 12, largest_bed_change_at_shore: 0.456, pocket_cells: 1, ..water };
        water.largest_bed_change_under_water = 0.3;
        let text = Shown(water).to_string();
        assert!(
            text.contains("ground changed in 12 shoreline cells (by up to 0.46 m) so that the stored volume is exact; under water by up to 0.30 m"),
            "{text}"
        );
        assert_eq!(text.lines().count(), 1);
    }
}
