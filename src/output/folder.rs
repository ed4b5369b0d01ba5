//! The run folder: made once, written atomically, never mixed with files of somebody else.
//!
//! Every file but the live `fields.partial.nc` and `channels.partial.nc` appears under its name only when it is whole: it is written under a
//! temporary name in the same folder, flushed to the disk and renamed. While a run is under way, `run.json` says
//! `"status": "running"`.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::hold::{HOLD, Hold, in_use, is_held, unwritable};
use crate::error::{Error, Problem, ProblemKind};
use crate::plain_file::entries;

/// Files that a run writes, relative to its folder, and those of a report, which would be out of date beside another run.
const OWN_FILES: [&str; 35] = [
    "run.json",
    "checkpoint.bin",
    "checkpoint.before.bin",
    "scenario.resolved.yaml",
    "fields.nc",
    "fields.partial.nc",
    "maps.nc",
    "results.gpkg",
    "tables/gauges.csv",
    "tables/gauge_series.csv",
    "tables/mass_balance.csv",
    "tables/boundaries.csv",
    "tables/channels.csv",
    "tables/channel_gauges.csv",
    "tables/channel_gauge_series.csv",
    "channels.nc",
    "channels.partial.nc",
    "tables/sections.csv",
    "tables/tracers.csv",
    "tables/section_series.csv",
    "sections.nc",
    "differences.nc",
    "differences.json",
    "tables/differences.csv",
    "statistics.nc",
    "tables/quantiles.csv",
    "tables/ranking.csv",
    "report/index.html",
    "report/max_depth.svg",
    "report/arrival.svg",
    "report/hazard.svg",
    "report/max_speed.svg",
    "report/four_times.svg",
    "report/gauges.svg",
    "report/sections.svg",
];

/// Beginning of the temporary name of a file that is not yet whole.
const TEMPORARY: &str = ".unfinished.";

/// Beginnings of the names of the maps in `cog/`.
const OWN_MAPS: [&str; 13] = [
    "bed_elevation",
    "resolution",
    "max_depth",
    "max_water_level",
    "max_speed",
    "arrival_time",
    "time_of_max_depth",
    "flood_duration",
    "deflood_time",
    "flood_extent",
    "hazard_class",
    "probability",
    "ground_source",
];

/// The folder that holds one run, and that no other run may write to while this value or a copy of it lives.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
    _hold: Arc<Hold>,
}

impl RunFolder {
    /// Makes the folder, or takes an empty one; with `overwrite`, also one with an earlier run, whose files are deleted.
    ///
    /// # Errors
    /// A problem of the kind [`ProblemKind::Output`] when the folder holds files and `overwrite` is not set, when a run
    /// that is under way has it, or when it cannot be written.
    pub fn create(path: &Path, overwrite: bool) -> Result<RunFolder, Error> {
        if let Some(problem) = RunFolder::inspect(path, overwrite) {
            return Err(Error::Problems(vec![problem]));
        }
        let unwritable = |cause: std::io::Error| Error::Problems(vec![unwritable(path, &cause.to_string())]);
        fs::create_dir_all(path).map_err(unwritable)?;
        let hold = Hold::take(path).map_err(|problem| Error::Problems(vec![problem]))?;
        // Another run may have come and gone since the first look.
        if let Some(problem) = RunFolder::look(path, overwrite) {
            return Err(Error::Problems(vec![problem]));
        }
        let folder = RunFolder { path: path.to_path_buf(), _hold: Arc::new(hold) };
        if overwrite {
            folder.delete_own_files().map_err(unwritable)?;
        }
        let probe = folder.temporary("probe");
        let made = remove_if_there(&probe).and_then(|()| fs::File::create_new(&probe));
        made.and_then(|_| fs::remove_file(&probe)).map_err(unwritable)?;
        Ok(folder)
    }

    /// Takes the folder of a run that ended early, with all that is in it, to go on with that run.
    ///
    /// # Errors
    /// A problem of the kind [`ProblemKind::Output`] when a run that is under way has it, or when it cannot be written.
    pub fn reopen(path: &Path) -> Result<RunFolder, Error> {
        if let Some(problem) = linked(path) {
            return Err(Error::Problems(vec![problem]));
        }
        let hold = Hold::take(path).map_err(|problem| Error::Problems(vec![problem]))?;
        let folder = RunFolder { path: path.to_path_buf(), _hold: Arc::new(hold) };
        let cleared = folder.delete_where(is_temporary);
        cleared.map_err(|cause| Error::Problems(vec![unwritable(path, &cause.to_string())]))?;
        Ok(folder)
    }

    /// What stands in the way of [`create`](Self::create), as far as it can be seen without writing anything.
    pub fn inspect(path: &Path, overwrite: bool) -> Option<Problem> {
        if path.exists() && !path.is_dir() {
            return Some(unwritable(path, "it is a file"));
        }
        if !path.exists() {
            let here = Path::new(".");
            let parent = path.ancestors().skip(1).find(|parent| parent.exists()).unwrap_or(here);
            if !parent.is_dir() {
                return Some(unwritable(path, &format!("{} is a file", parent.display())));
            }
            return closed(parent).map(|cause| unwritable(path, &cause));
        }
        if let Some(cause) = closed(path) {
            return Some(unwritable(path, &cause));
        }
        if is_held(path) { Some(in_use(path)) } else { RunFolder::look(path, overwrite) }
    }

    /// The same of a folder that is there, whoever holds it.
    fn look(path: &Path, overwrite: bool) -> Option<Problem> {
        let count = |paths: Vec<PathBuf>| paths.iter().filter(|path| path.file_name() != Some(HOLD.as_ref())).count();
        match entries(path).map(count) {
            Err(cause) => Some(unwritable(path, &cause.to_string())),
            Ok(entries) if !overwrite && entries > 0 => Some(
                Problem::error(
                    ProblemKind::Output,
                    "output-folder-not-empty",
                    "outputs.folder",
                    format!("the output folder {} already holds files", path.display()),
                )
                .with_cause("results of two runs in one folder could not be told apart")
                .with_remedy("choose another folder with --out, or add --overwrite to replace the earlier run"),
            ),
            Ok(_) => linked(path),
        }
    }

    /// Where the folder is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path of a file of the folder, such as `maps.nc`.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes a file whole, under a temporary name first.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<(), Error> {
        self.write_with(name, |path| fs::write(path, contents).map_err(|cause| output_error(path, cause)))
    }

    /// Lets `write` make a file under a temporary name, flushes it to the disk and gives it its name.
    ///
    /// # Errors
    /// Those of `write`, and when the file cannot be flushed or renamed.
    pub(super) fn write_with(&self, name: &str, write: impl FnOnce(&Path) -> Result<(), Error>) -> Result<(), Error> {
        self.write_after(name, write, || Ok(()))
    }

    /// The same; `before` is done when the file is whole, before it gets its name.
    ///
    /// # Errors
    /// Those of `write` and `before`, and when the file cannot be flushed or renamed.
    pub(super) fn write_after(
        &self,
        name: &str,
        write: impl FnOnce(&Path) -> Result<(), Error>,
        before: impl FnOnce() -> std::io::Result<()>,
    ) -> Result<(), Error> {
        let (temporary, path) = (self.temporary(name), self.file(name));
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(|cause| output_error(parent, cause))?;
        }
        // What a run that was killed left: some libraries do not write over a file.
        remove_if_there(&temporary).map_err(|cause| output_error(&temporary, cause))?;
        let written = write(&temporary).and_then(|()| {
            let flush = || fs::File::open(&temporary)?.sync_all();
            let named = flush().and_then(|()| before()).and_then(|()| fs::rename(&temporary, &path));
            let named = named.and_then(|()| flush_names(&path));
            named.map_err(|cause| output_error(&path, cause))
        });
        if written.is_err() {
            // Best effort: the error that led here is the one to report.
            let _ = fs::remove_file(&temporary);
        }
        written
    }

    /// The temporary path of a file: in the same folder, with the same ending, since GDAL goes by endings.
    fn temporary(&self, name: &str) -> PathBuf {
        let path = self.file(name);
        let file_name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        path.with_file_name(format!("{TEMPORARY}{file_name}"))
    }

    /// The results of a run that are there: neither its record, its report, nor what it goes on from.
    pub(super) fn results(&self) -> std::io::Result<Vec<PathBuf>> {
        let named = OWN_FILES
            .iter()
            .filter(|name| !is_of_the_way(name) && **name != "run.json" && !name.starts_with("report/"));
        let mut paths: Vec<PathBuf> = named.map(|name| self.file(name)).filter(|path| path.is_file()).collect();
        let maps = self.file("cog");
        if maps.is_dir() {
            paths.extend(entries(&maps)?.into_iter().filter(|path| is_own_map(path)));
        }
        Ok(paths)
    }

    /// Deletes what a run that has ended would have gone on from: the checkpoints, and then the files that they count on.
    ///
    /// # Errors
    /// When it cannot be deleted.
    pub fn delete_way(&self) -> Result<(), Error> {
        OWN_FILES.iter().filter(|name| is_of_the_way(name)).try_for_each(|name| {
            let path = self.file(name);
            remove_if_there(&path).map_err(|cause| output_error(&path, cause))
        })
    }

    fn delete_own_files(&self) -> std::io::Result<()> {
        for name in OWN_FILES {
            remove_if_there(&self.file(name))?;
        }
        self.delete_where(|path| is_temporary(path) || is_own_map(path))
    }

    /// Deletes some of the files in the folder and in those of maps and tables.
    fn delete_where(&self, goes: impl Fn(&Path) -> bool) -> std::io::Result<()> {
        for folder in [self.path.clone(), self.file("cog"), self.file("tables")].iter().filter(|folder| folder.is_dir())
        {
            for path in entries(folder)?.iter().filter(|path| path.is_file() && goes(path)) {
                fs::remove_file(path)?;
            }
        }
        Ok(())
    }
}

/// Whether a run goes on from a file of its folder; the checkpoints come first.
fn is_of_the_way(name: &str) -> bool {
    name.starts_with("checkpoint") || name.contains(".partial.")
}

/// Whether a file is not yet whole, or will never be.
fn is_temporary(path: &Path) -> bool {
    path.file_name().unwrap_or_default().to_string_lossy().starts_with(TEMPORARY)
}

/// Whether a file is one of the maps in `cog/` of a run.
fn is_own_map(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    path.parent().is_some_and(|folder| folder.ends_with("cog"))
        && OWN_MAPS.iter().any(|map| name.starts_with(map))
        && [".tif", ".qml", ".tif.aux.xml"].iter().any(|end| name.ends_with(end))
}

/// Flushes the names of the folder of a file to the disk.
fn flush_names(path: &Path) -> std::io::Result<()> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match fs::File::open(parent)?.sync_all() {
        // Some network drives cannot do that.
        Err(cause) if matches!(cause.kind(), ErrorKind::Unsupported | ErrorKind::InvalidInput) => Ok(()),
        flushed => flushed,
    }
}

fn remove_if_there(path: &Path) -> std::io::Result<()> {
    match fs::remove_file(path) {
        Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => Err(cause),
        _ => Ok(()),
    }
}

/// Why no files can be made in a folder, where its permissions say so.
fn closed(folder: &Path) -> Option<String> {
    use rustix::fs::Access;
    let refusal = rustix::fs::access(folder, Access::WRITE_OK | Access::EXEC_OK).err()?;
    Some(format!("files can't be made in {}: {refusal}", folder.display()))
}

/// A folder of results that is a link, through which files elsewhere would be deleted and written.
fn linked(path: &Path) -> Option<Problem> {
    let name = ["cog", "tables", "report"].into_iter().find(|name| path.join(name).is_symlink())?;
    Some(unwritable(path, &format!("`{name}` in it is a link that leads elsewhere")))
}

/// An error of a writer.
pub(super) fn output_error(path: &Path, cause: impl std::fmt::Display) -> Error {
    Error::Output { path: path.to_path_buf(), cause: cause.to_string() }
}

/// Writes lines to a file of the folder.
pub(super) fn write_lines(
    folder: &RunFolder,
    name: &str,
    header: &str,
    lines: impl Iterator<Item = String>,
) -> Result<(), Error> {
    folder.write_with(name, |path| {
        let write = || -> std::io::Result<()> {
            let mut file = std::io::BufWriter::new(fs::File::create(path)?);
            writeln!(file, "{header}")?;
            for line in lines {
                writeln!(file, "{line}")?;
            }
            file.flush()
        };
        write().map_err(|cause| output_error(path, cause))
    })
}

#[cfg(test)]
mod tests;
