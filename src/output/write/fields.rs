//! `fields.nc`: depth, level and velocity over time.
//!
//! During the run the frames go into `fields.partial.nc` in the classic format with 64-bit offsets, each flushed before the
//! next: killed at any moment, that file opens with every frame that was finished. HDF5 gives no such promise. At the end
//! it is converted to NetCDF-4, compressed, and renamed to `fields.nc`.
//!
//! One thread writes, so that the solver waits only for a disk that is slower than the run. No frame waits in between: of a large grid each one
//! takes as much memory as its maps of depth, level and velocity.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use netcdf::Options;

use super::super::folder::{RunFolder, output_error};
use super::super::frames::Frame;
use super::super::grid::{FILL, OutputGrid};
use super::super::tracers::TracerPlan;
use super::FileHead;
use super::crs::WritableCrs;
use super::netcdf_file::{FileDescription, NetcdfFile, Written};
use super::read_back::ReadBack;
use super::tracers::field;
use crate::error::Error;

const PARTIAL: &str = "fields.partial.nc";

/// Name, standard name, long name, unit of each field. Components of velocity have a standard name only on grids
/// whose y axis points to true north, which a projected one does not; the long names join them for QGIS.
const FIELDS: [(&str, &str, &str, &str); 4] = [
    ("depth", "flood_water_thickness", "water depth", "m"),
    ("water_level", "water_surface_height_above_reference_datum", "water level above the datum of the terrain", "m"),
    ("velocity_x", "", "x-component of velocity", "m s-1"),
    ("velocity_y", "", "y-component of velocity", "m s-1"),
];

/// What the writing thread is handed.
enum Work {
    /// A frame to be written.
    Frame(Frame),
    /// A wish to hear when all frames are on the disk.
    Settle(SyncSender<()>),
}

/// Writes frames while a run goes on. Dropped without [`finish`](Self::finish), it leaves `fields.partial.nc`, closed and
/// readable.
#[derive(Debug)]
pub struct FieldsWriter {
    folder: RunFolder,
    description: FileDescription,
    tracers: Vec<TracerPlan>,
    sender: Option<SyncSender<Work>>,
    worker: Option<JoinHandle<Result<(), Error>>>,
}

impl FieldsWriter {
    /// Creates `fields.partial.nc`, or goes on with one that has so many frames or more, and starts the thread that writes it.
    ///
    /// # Errors
    /// When the file cannot be created or opened.
    pub fn start(
        folder: &RunFolder,
        grid: &OutputGrid,
        FileHead { crs, provenance }: FileHead<'_>,
        tracers: &[TracerPlan],
        frames: usize,
    ) -> Result<FieldsWriter, Error> {
        let description = FileDescription { grid: grid.clone(), crs: crs.clone(), provenance: provenance.clone() };
        let path = folder.file(PARTIAL);
        let (sender, receiver) = sync_channel(0);
        let (ready, is_ready) = sync_channel(1);
        let worker = std::thread::Builder::new().name("fields".into()).spawn({
            let (path, description, tracers) = (path.clone(), description.clone(), tracers.to_vec());
            move || write_partial((&path, frames), (&description, &tracers), &receiver, &ready)
        });
        let worker = worker.map_err(|cause| output_error(&path, cause))?;
        let mut writer = FieldsWriter {
            folder: folder.clone(),
            description,
            tracers: tracers.to_vec(),
            sender: Some(sender),
            worker: Some(worker),
        };
        // The thread drops its end without a word when it cannot create the file.
        if is_ready.recv().is_err() {
            writer.join()?;
        }
        Ok(writer)
    }

    /// Hands a frame to the writing thread; waits when the disk is behind.
    ///
    /// # Errors
    /// When an earlier frame could not be written.
    pub fn push(&mut self, frame: Frame) -> Result<(), Error> {
        let sent = self.sender.as_ref().is_some_and(|sender| sender.send(Work::Frame(frame)).is_ok());
        if sent {
            return Ok(());
        }
        self.join()?;
        Err(self.ended_before())
    }

    /// Waits until all frames are on the disk, a power cut notwithstanding.
    ///
    /// # Errors
    /// When one could not be written.
    pub fn settle(&mut self) -> Result<(), Error> {
        let (done, is_done) = sync_channel(1);
        let is_sent = self.sender.as_ref().is_some_and(|sender| sender.send(Work::Settle(done)).is_ok());
        if is_sent && is_done.recv().is_ok() {
            return Ok(());
        }
        self.join()?;
        Err(self.ended_before())
    }

    /// Waits for the last frame and makes `fields.nc`; `fields.partial.nc` stays until the checkpoints that count on it are gone.
    ///
    /// # Errors
    /// When a frame could not be written, or the conversion fails.
    pub fn finish(mut self) -> Result<(), Error> {
        // The thread ends before only where a frame failed: then `fields.nc` would lack it.
        if self.worker.is_none() {
            return Err(self.ended_before());
        }
        self.join()?;
        let partial = self.folder.file(PARTIAL);
        let convert = |path: &Path| convert(&partial, path, (&self.description, &self.tracers));
        self.folder.write_with("fields.nc", convert)
    }

    /// What is said of frames beside one that could not be written, once that was reported.
    fn ended_before(&self) -> Error {
        output_error(&self.folder.file(PARTIAL), "an earlier frame could not be written")
    }

    fn join(&mut self) -> Result<(), Error> {
        drop(self.sender.take());
        match self.worker.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(Error::Internal("the thread that writes fields.nc broke down".into())),
            None => Ok(()),
        }
    }
}

impl Drop for FieldsWriter {
    fn drop(&mut self) {
        // Nothing can be reported from here; whoever drops the writer unfinished already has an error to report.
        let _ = self.join();
    }
}

/// The body of the writing thread.
fn write_partial(
    (path, mut written): (&PathBuf, usize),
    (description, tracers): (&FileDescription, &[TracerPlan]),
    work: &Receiver<Work>,
    ready: &SyncSender<()>,
) -> Result<(), Error> {
    let failed = |cause: netcdf::Error| output_error(path, cause);
    let crs = WritableCrs::new(&description.crs, path)?;
    let mut file = if written > 0 {
        NetcdfFile { file: Written::append(path).map_err(failed)?, crs: &crs }
    } else {
        let file = Written::create(path, Options::_64BIT_OFFSET).map_err(failed)?;
        let mut file = NetcdfFile::describe(file, path, &crs, description)?;
        define_fields(&mut file, (description, tracers), false).map_err(failed)?;
        file.file.enddef().map_err(failed)?;
        file.write_coordinates(&description.grid).map_err(failed)?;
        file
    };
    file.file.sync().map_err(failed)?;
    // The other end waits for this one word only.
    let _ = ready.send(());
    for work in work {
        match work {
            Work::Frame(frame) => {
                write_frame(&mut file, written, (&frame, tracers)).and_then(|()| file.file.sync()).map_err(failed)?;
                written += 1;
            }
            Work::Settle(done) => {
                fs::File::open(path).and_then(|file| file.sync_all()).map_err(|cause| output_error(path, cause))?;
                // Nobody waits where the run has ended.
                let _ = done.send(());
            }
        }
    }
    file.file.close().map_err(failed)
}

/// Name, standard name, long name and unit of all fields.
fn all_fields(tracers: &[TracerPlan]) -> Vec<[String; 4]> {
    let own = FIELDS.iter().map(|&(name, standard, long, units)| [name, standard, long, units].map(str::to_owned));
    let carried = tracers.iter().map(field).map(|(name, long_name, units)| [name, String::new(), long_name, units]);
    own.chain(carried).collect()
}

fn define_fields(
    file: &mut NetcdfFile<'_>,
    (description, tracers): (&FileDescription, &[TracerPlan]),
    compressed: bool,
) -> netcdf::Result<()> {
    file.file.add_unlimited_dimension("time")?;
    file.define_time(&["time"], &description.provenance)?;
    for [name, standard_name, long_name, units] in &all_fields(tracers) {
        file.file.add_variable::<f32>(name, &["time", "y", "x"])?;
        if compressed {
            file.compress(name, &[1, description.grid.rows, description.grid.columns])?;
        }
        file.variable(name)?.put_attribute("_FillValue", FILL)?;
        let attributes = [
            ("standard_name", standard_name.as_str()),
            ("long_name", long_name.as_str()),
            ("units", units.as_str()),
            ("cell_methods", "area: mean time: point"),
        ];
        file.describe_variable(name, &attributes)?;
        file.georeference(name)?;
    }
    Ok(())
}

fn write_frame(
    file: &mut NetcdfFile<'_>,
    record: usize,
    (frame, tracers): (&Frame, &[TracerPlan]),
) -> netcdf::Result<()> {
    let values = [&frame.depth, &frame.water_level, &frame.velocity_x, &frame.velocity_y];
    for ([name, ..], values) in all_fields(tracers).iter().zip(values.into_iter().chain(&frame.concentrations)) {
        file.variable(name)?.put_values(values, (record, .., ..))?;
    }
    file.variable("time")?.put_value(frame.time, record)
}

/// Makes the compressed file from the partial one, frame by frame.
fn convert(
    partial: &Path,
    path: &Path,
    (description, tracers): (&FileDescription, &[TracerPlan]),
) -> Result<(), Error> {
    let failed = |cause: netcdf::Error| output_error(path, cause);
    let crs = WritableCrs::new(&description.crs, path)?;
    let source = netcdf::open(partial).map_err(|cause| output_error(partial, cause))?;
    let file = Written::create(path, Options::NETCDF4).map_err(failed)?;
    let mut file = NetcdfFile::describe(file, path, &crs, description)?;
    let mut copy = || -> netcdf::Result<()> {
        let fields = all_fields(tracers);
        file.define_compressed(|file| define_fields(file, (description, tracers), true))?;
        file.write_coordinates(&description.grid)?;
        let variable = |name: &str| source.variable(name).ok_or_else(|| netcdf::Error::NotFound(name.to_string()));
        let mut values = vec![FILL; description.grid.len()];
        for record in 0..source.dimension_len("time").unwrap_or(0) {
            for [name, ..] in &fields {
                variable(name)?.get_values_into(&mut values, (record, .., ..))?;
                file.variable(name)?.put_values(&values, (record, .., ..))?;
            }
            let time: f64 = variable("time")?.get_value(record)?;
            file.variable("time")?.put_value(time, record)?;
        }
        Ok(())
    };
    copy().map_err(failed)?;
    file.file.close().map_err(failed)?;
    compare(&source, path, (description, tracers))
}

/// Reads back the compressed file beside the partial one.
fn compare(
    source: &netcdf::File,
    path: &Path,
    (description, tracers): (&FileDescription, &[TracerPlan]),
) -> Result<(), Error> {
    let failed = |cause: netcdf::Error| output_error(path, cause);
    let back = ReadBack::open(path)?;
    let mut values = vec![FILL; description.grid.len()];
    for [name, ..] in &all_fields(tracers) {
        let variable = source.variable(name).ok_or_else(|| failed(netcdf::Error::NotFound(name.clone())))?;
        for record in 0..source.dimension_len("time").unwrap_or(0) {
            variable.get_values_into(&mut values, (record, .., ..)).map_err(failed)?;
            back.compare(name, (record, .., ..), &values)?;
        }
    }
    Ok(())
}
