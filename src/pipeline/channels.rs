//! The channels of a run: followed step by step, and written.

use super::records::in_channels;
use crate::error::Error;
use crate::output::{
    ChannelFrame, ChannelPlan, ChannelProfile, ChannelRecorder, ChannelRecording, ChannelsWriter, FileHead, RunFolder,
    write_channels,
};
use crate::scenario::{OutputPart, Scenario};
use crate::solver::FlowSolver;

/// The channels while a run goes on.
pub(super) struct Channels<'a> {
    profiles: &'a [ChannelProfile],
    recorder: ChannelRecorder<'a>,
    /// None where `channels.nc` is left out.
    writer: Option<ChannelsWriter>,
    has_tables: bool,
}

impl<'a> Channels<'a> {
    /// Takes the water at the start; none where there are no channels.
    pub fn start(
        scenario: &Scenario,
        profiles: &'a [ChannelProfile],
        solver: &dyn FlowSolver,
        folder: &RunFolder,
        head: FileHead<'_>,
    ) -> Result<Option<Self>, Error> {
        if profiles.is_empty() {
            return Ok(None);
        }
        let outputs = &scenario.outputs;
        let plan = ChannelPlan {
            every: outputs.every,
            gauges_every: outputs.gauges_every,
            end_time: scenario.end_time,
            threshold: outputs.thresholds[0],
            rise_on_wet: outputs.rise_on_wet,
        };
        let start = || ChannelsWriter::start(folder, profiles, head);
        let mut writer = outputs.writes(OutputPart::Channels).then(start).transpose()?;
        let mut push = |frame: &ChannelFrame| writer.as_mut().map_or(Ok(()), |writer| writer.push(frame));
        let recorder = ChannelRecorder::start(profiles, plan, in_channels(solver), &mut push)?;
        Ok(Some(Channels { profiles, recorder, writer, has_tables: outputs.writes(OutputPart::Tables) }))
    }

    /// Takes the water after a step.
    pub fn step(&mut self, solver: &dyn FlowSolver) -> Result<(), Error> {
        let Channels { recorder, writer, .. } = self;
        let mut push = |frame: &ChannelFrame| writer.as_mut().map_or(Ok(()), |writer| writer.push(frame));
        recorder.step(solver.time(), in_channels(solver), &mut push)
    }

    /// Writes the tables, closes `channels.nc`, and hands on what was recorded.
    pub fn finish(self, folder: &RunFolder) -> Result<ChannelRecording, Error> {
        self.writer.map_or(Ok(()), ChannelsWriter::finish)?;
        let recording = self.recorder.finish();
        if self.has_tables {
            write_channels(folder, self.profiles, &recording)?;
        }
        Ok(recording)
    }
}
