//! The files of a run besides its record: maps, sections and tables, as far as the scenario wants them.

use super::levels;
use super::recorders::Recorders;
use super::{Computed, Early, Run};
use crate::error::Error;
use crate::output::{
    ChannelRecording, FieldsWriter, FileHead, Findings, OutputGrid, Provenance, Recording, SectionRecording,
    TracerBalance, map_variables, write_cogs, write_gauges, write_geopackage, write_maps, write_mass_balance,
    write_passages, write_section_file, write_section_tables, write_tracers,
};
use crate::scenario::OutputPart;
use crate::solver::Ledger;

/// The first error of several attempts, all of which were made.
fn first_error<const N: usize>(attempts: [Result<(), Error>; N]) -> Result<(), Error> {
    attempts.into_iter().collect()
}

impl Run<'_> {
    /// Writes all results but `run.json`, each whether or not another one could be written; the frames, which are the most, last.
    pub(super) fn write_outputs(
        &mut self,
        recorders: Recorders,
        provenance: &Provenance,
        (ledger, early): (Ledger, Option<Early>),
    ) -> Computed {
        let Recorders { plane, fields, sections, channels, tracers, .. } = recorders;
        let (has_plane, grid) = (!plane.grid().is_empty(), plane.grid_of_maps().clone());
        let mut recording = plane.finish();
        if self.scenario.outputs.needs_maxima() {
            recording.maps.ground_source = grid.ground_source(&self.scene.ground_source);
            recording.maps.resolution = levels::resolution(&self.scene.lattice, &grid, &recording.maps);
            if let Some(second) = self.second.take() {
                self.manifest.error_estimate = Some(second.compare(&grid, &mut recording.maps));
            }
        }
        self.warn_at_end(&recording);
        self.clock.part("grids of the maps");
        let sections = sections.finish(&recording.section_arrivals);
        let of_plane = if has_plane { self.write_plane(&grid, provenance, &recording, &sections) } else { Ok(()) };
        let of_sections = self.write_sections(provenance, &sections);
        let tables = self.write_tables(&recording, &sections, &tracers);
        self.clock.part("tables");
        let (in_channels, of_channels) = match channels {
            Some(channels) => channels.finish(&self.folder),
            None => (ChannelRecording::default(), Ok(())),
        };
        self.manifest.above_banks = in_channels.above_banks;
        let frames = fields.map_or(Ok(()), FieldsWriter::finish);
        self.clock.part("fields");
        Computed {
            ledger,
            recording,
            sections: sections.results,
            channel_gauges: in_channels.gauge_results,
            early,
            unwritten: first_error([of_plane, of_sections, tables, of_channels, frames]).err(),
        }
    }

    /// The maps, and all else that is drawn or read on the plane.
    fn write_plane(
        &mut self,
        grid: &OutputGrid,
        provenance: &Provenance,
        recording: &Recording,
        sections: &SectionRecording,
    ) -> Result<(), Error> {
        let (crs, outputs) = (&self.scene.crs, &self.scenario.outputs);
        let head = FileHead { crs, provenance };
        let rise_on_wet = outputs.rise_on_wet;
        let maps = &recording.maps;
        let folder = &self.folder;
        let mut attempt = |part: OutputPart, write: &dyn Fn() -> Result<(), Error>| {
            let written = if outputs.writes(part) { write() } else { Ok(()) };
            self.clock.part(part.name());
            written
        };
        let findings = Findings {
            gauges: &self.scene.gauges,
            ridges: &self.scene.ridges,
            banks: &self.scene.banks,
            sections: &self.scene.sections,
            section_results: &sections.results,
            isochrones: &outputs.isochrones,
            problems: &self.warnings,
        };
        first_error([
            attempt(OutputPart::Maps, &|| write_maps(folder, grid, head, maps, recording.end_time, rise_on_wet)),
            attempt(OutputPart::Tables, &|| write_gauges(folder, &self.scene.gauges, recording)),
            attempt(OutputPart::Gpkg, &|| write_geopackage(folder, grid, crs, recording, &findings)),
            attempt(OutputPart::Cog, &|| write_cogs(folder, grid, head, &map_variables(maps, rise_on_wet))),
        ])
    }

    /// `sections.nc`, where it is wanted.
    fn write_sections(&self, provenance: &Provenance, sections: &SectionRecording) -> Result<(), Error> {
        if self.scenario.outputs.writes(OutputPart::Sections) {
            let head = FileHead { crs: &self.scene.crs, provenance };
            write_section_file(&self.folder, head, &self.scene.sections, sections)?;
        }
        Ok(())
    }

    /// The tables of sections, volume balance, and inflow and outflow, where they are wanted.
    fn write_tables(
        &self,
        recording: &Recording,
        sections: &SectionRecording,
        tracers: &[TracerBalance],
    ) -> Result<(), Error> {
        if self.scenario.outputs.writes(OutputPart::Tables) {
            return first_error([
                write_section_tables(&self.folder, &self.scene.sections, sections),
                write_mass_balance(&self.folder, recording),
                write_passages(&self.folder, &self.manifest.boundaries),
                write_tracers(&self.folder, tracers),
            ]);
        }
        Ok(())
    }
}
