//! The tables of the channels of one dimension: `channels.csv`, a row for each particle at each time, and `channel_gauges.csv` and
//! `channel_gauge_series.csv` of their gauges.

use super::super::channel_profile::ChannelProfile;
use super::super::channels::ChannelRecording;
use super::super::folder::{RunFolder, write_lines};
use super::tables::{decimals, number, row, text};
use crate::error::Error;

/// Writes the tables of the channels; nothing of gauges where there are none.
///
/// # Errors
/// When one of them cannot be written.
pub fn write_channels(
    folder: &RunFolder,
    profiles: &[ChannelProfile],
    recording: &ChannelRecording,
) -> Result<(), Error> {
    let water = recording.frames.iter().flat_map(|frame| frame.water.iter().flatten());
    let digits = decimals(6, water.map(|water| water.discharge));
    let rows = recording.frames.iter().flat_map(|frame| {
        profiles.iter().zip(&frame.water).flat_map(|(profile, water)| {
            let particles = profile.distance.iter().zip(&profile.bed).zip(water);
            particles.map(|((distance, bed), water)| {
                row([
                    text(&profile.id),
                    number(Some(frame.time), 3),
                    number(Some(*distance), 3),
                    number(Some(*bed), 4),
                    number(Some(water.depth), 5),
                    number(Some(water.level), 5),
                    number(Some(water.velocity), 4),
                    number(Some(water.discharge), digits),
                ])
            })
        })
    });
    let header = "id,time_s,distance_m,bed_m,depth_m,level_m,velocity_m_s,discharge_m3_s";
    write_lines(folder, "tables/channels.csv", header, rows)?;
    if recording.gauge_results.is_empty() { Ok(()) } else { write_gauges(folder, recording) }
}

fn write_gauges(folder: &RunFolder, recording: &ChannelRecording) -> Result<(), Error> {
    let results = &recording.gauge_results;
    let digits = decimals(6, results.iter().map(|seen| seen.peak_discharge));
    let rows = results.iter().map(|seen| {
        row([
            text(&seen.id),
            text(&seen.channel),
            number(Some(seen.distance), 3),
            number(Some(seen.bed), 4),
            number(seen.arrival, 3),
            number(Some(seen.max_depth), 5),
            number(seen.max_level, 5),
            number(seen.time_of_max, 3),
            number(Some(seen.max_speed), 4),
            number(Some(seen.peak_discharge), digits),
            number(seen.time_of_peak, 3),
        ])
    });
    let header = "id,channel,distance_m,bed_m,arrival_s,max_depth_m,max_level_m,time_of_max_s,max_speed_m_s,peak_discharge_m3_s,time_of_peak_s";
    write_lines(folder, "tables/channel_gauges.csv", header, rows)?;
    let rows = recording.gauge_samples.iter().map(|sample| {
        row([
            text(&results[sample.gauge].id),
            number(Some(sample.time), 3),
            number(Some(sample.water.depth), 5),
            number(sample.level(), 5),
            number(Some(sample.water.velocity), 4),
            number(Some(sample.water.discharge), digits),
        ])
    });
    let header = "id,time_s,depth_m,level_m,velocity_m_s,discharge_m3_s";
    write_lines(folder, "tables/channel_gauge_series.csv", header, rows)
}
