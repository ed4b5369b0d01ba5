//! The channels of a run: followed step by step, and written.

use serde::{Deserialize, Serialize};

use super::records::in_channels;
use crate::error::Error;
use crate::output::{
    ChannelFrame, ChannelPlan, ChannelProfile, ChannelRecorder, ChannelRecording, ChannelsWriter, FileHead, RunFolder,
    write_channels,
};
use crate::scenario::{OutputPart, Scenario};
use crate::solver::FlowSolver;

/// The channels while a run goes on.
#[derive(Deserialize, Serialize)]
pub(super) struct Channels {
    profiles: Vec<ChannelProfile>,
    recorder: ChannelRecorder,
    /// None where `channels.nc` is left out.
    #[serde(skip)]
    writer: Option<ChannelsWriter>,
    has_tables: bool,
}

impl Channels {
    /// Takes the water at the start; none where there are no channels.
    pub fn start(
        scenario: &Scenario,
        profiles: &[ChannelProfile],
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
        let start = || ChannelsWriter::start(folder, profiles, head, 0);
        let mut writer = outputs.writes(OutputPart::Channels).then(start).transpose()?;
        let mut push = |frame: &ChannelFrame| writer.as_mut().map_or(Ok(()), |writer| writer.push(frame));
        let recorder = ChannelRecorder::start(profiles, plan, in_channels(solver), &mut push)?;
        Ok(Some(Channels {
            profiles: profiles.to_vec(),
            recorder,
            writer,
            has_tables: outputs.writes(OutputPart::Tables),
        }))
    }

    /// Opens `channels.nc` again for channels that go on from a checkpoint.
    pub fn reopen(&mut self, scenario: &Scenario, folder: &RunFolder, head: FileHead<'_>) -> Result<(), Error> {
        let open = || ChannelsWriter::start(folder, &self.profiles, head, self.recorder.frames());
        self.writer = scenario.outputs.writes(OutputPart::Channels).then(open).transpose()?;
        Ok(())
    }

    /// Waits until all that was written is on the disk.
    pub fn settle(&self) -> Result<(), Error> {
        self.writer.as_ref().map_or(Ok(()), ChannelsWriter::settle)
    }

    /// Takes the water after a step.
    pub fn step(&mut self, solver: &dyn FlowSolver) -> Result<(), Error> {
        let Channels { recorder, writer, .. } = self;
        let mut push = |frame: &ChannelFrame| writer.as_mut().map_or(Ok(()), |writer| writer.push(frame));
        recorder.step(solver.time(), in_channels(solver), &mut push)
    }

    /// Writes the tables, closes `channels.nc`, and hands on what was recorded.
    pub fn finish(self, folder: &RunFolder) -> (ChannelRecording, Result<(), Error>) {
        let recording = self.recorder.finish();
        let tables = if self.has_tables { write_channels(folder, &self.profiles, &recording) } else { Ok(()) };
        let profiles = self.writer.map_or(Ok(()), ChannelsWriter::finish);
        (recording, tables.and(profiles))
    }
}
