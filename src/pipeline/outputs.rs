//! The files of a run besides its record: maps, sections and tables, as far as the scenario wants them.

use super::Run;
use crate::error::Error;
use crate::output::{
    FileHead, Findings, OutputGrid, Provenance, Recording, SectionRecording, TracerBalance, write_cogs, write_gauges,
    write_geopackage, write_maps, write_mass_balance, write_passages, write_section_file, write_section_tables,
    write_tracers,
};
use crate::scenario::OutputPart;

impl Run<'_> {
    /// The maps, and all else that is drawn or read on the plane.
    pub(super) fn write_plane(
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
        if outputs.writes(OutputPart::Maps) {
            write_maps(&self.folder, grid, head, maps, recording.end_time, rise_on_wet)?;
            self.clock.part("maps");
        }
        if outputs.writes(OutputPart::Cog) {
            write_cogs(&self.folder, grid, head, maps, rise_on_wet)?;
            self.clock.part("cog");
        }
        if outputs.writes(OutputPart::Gpkg) {
            let findings = Findings {
                gauges: &self.scene.gauges,
                ridges: &self.scene.ridges,
                banks: &self.scene.banks,
                sections: &self.scene.sections,
                section_results: &sections.results,
                isochrones: &outputs.isochrones,
                problems: &self.warnings,
            };
            write_geopackage(&self.folder, grid, crs, recording, &findings)?;
            self.clock.part("gpkg");
        }
        if outputs.writes(OutputPart::Tables) {
            write_gauges(&self.folder, &self.scene.gauges, recording)?;
        }
        Ok(())
    }

    /// `sections.nc`, where it is wanted.
    pub(super) fn write_sections(&self, provenance: &Provenance, sections: &SectionRecording) -> Result<(), Error> {
        if self.scenario.outputs.writes(OutputPart::Sections) {
            let head = FileHead { crs: &self.scene.crs, provenance };
            write_section_file(&self.folder, head, &self.scene.sections, sections)?;
        }
        Ok(())
    }

    /// The tables of sections, volume balance, and inflow and outflow, where they are wanted.
    pub(super) fn write_tables(
        &self,
        recording: &Recording,
        sections: &SectionRecording,
        tracers: &[TracerBalance],
    ) -> Result<(), Error> {
        if self.scenario.outputs.writes(OutputPart::Tables) {
            write_section_tables(&self.folder, &self.scene.sections, sections)?;
            write_mass_balance(&self.folder, recording)?;
            write_passages(&self.folder, &self.manifest.boundaries)?;
            write_tracers(&self.folder, tracers)?;
        }
        Ok(())
    }
}
