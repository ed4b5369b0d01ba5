//! The channels of one dimension: `tables/channels.csv`, a row for each particle at each time.

use super::super::channels::{ChannelFrame, ChannelProfile};
use super::super::folder::{RunFolder, write_lines};
use super::tables::{number, row, text};
use crate::error::Error;

/// Writes the table of the channels; nothing where there are none.
///
/// # Errors
/// When it cannot be written.
pub fn write_channels(folder: &RunFolder, profiles: &[ChannelProfile], frames: &[ChannelFrame]) -> Result<(), Error> {
    if profiles.is_empty() {
        return Ok(());
    }
    let rows = frames.iter().flat_map(|frame| {
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
                    number(Some(water.discharge), 6),
                ])
            })
        })
    });
    let header = "id,time_s,distance_m,bed_m,depth_m,level_m,velocity_m_s,discharge_m3_s";
    write_lines(folder, "tables/channels.csv", header, rows)
}
