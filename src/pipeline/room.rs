//! Room on the disk: compared with what a run takes before it begins, and watched while it goes on.
//!
//! A run that fills its disk writes no maps. So it ends before, while there is room for them: as at a full disk, with exit code 8, and
//! `floodsim resume` goes on.

use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::disk::Disk;
use crate::error::{Error, Problem, ProblemKind};
use crate::math::in_bytes;
use crate::plain_file::entries;
use crate::scenario::Scenario;

/// How often the room is looked at without a frame.
const INTERVAL: Duration = Duration::from_millis(500);

/// The free space (bytes) of the disk that a folder is on, or will be; none where the system does not say.
fn free_space(folder: &Path) -> Option<f64> {
    let there = folder.ancestors().find(|ancestor| ancestor.exists() || ancestor.as_os_str().is_empty())?;
    let there = if there.as_os_str().is_empty() { Path::new(".") } else { there };
    let disk = rustix::fs::statvfs(there).ok()?;
    // A file system of the kernel's own, such as /proc, has no blocks.
    (disk.f_blocks > 0).then_some(disk.f_bavail as f64 * disk.f_frsize as f64)
}

/// The size (bytes) of the files of a folder and of the folders in it.
fn size_of(folder: &Path) -> f64 {
    let within = |folder: &Path| entries(folder).unwrap_or_default();
    let of_file = |path: &PathBuf| path.symlink_metadata().ok().filter(Metadata::is_file);
    let own = within(folder);
    let inner = own.iter().filter(|path| path.is_dir()).flat_map(|folder| within(folder));
    own.iter().cloned().chain(inner).filter_map(|path| of_file(&path)).map(|metadata| metadata.len() as f64).sum()
}

/// What stands in the way of a run that takes so much of the disk: its limit, or what is free. What is in its folder it writes over.
pub(super) fn problem(scenario: &Scenario, folder: &Path, disk: &Disk) -> Option<Problem> {
    let needed = disk.on_the_way.start;
    let because = format!(
        "its frames stand there uncompressed while it goes on; at its end the folder takes {} to {}",
        in_bytes(disk.at_end.start),
        in_bytes(disk.at_end.end)
    );
    const FEWER: &str = "a longer `outputs.every`, a larger `outputs.cell`, or `outputs.write` without `fields`";
    if let Some(limit) = scenario.limits.disk.filter(|limit| needed > *limit) {
        let message =
            format!("the run takes {} of the disk or more; the limit is {}", in_bytes(needed), in_bytes(limit));
        return Some(
            Problem::error(ProblemKind::Limit, "disk-limit", "outputs", message)
                .with_cause(because)
                .with_remedy(format!("take {FEWER}, or raise `limits.disk`")),
        );
    }
    let free = free_space(folder)? + size_of(folder);
    (needed > free).then(|| {
        let message = format!(
            "the run takes {} of the disk or more; {} are free for {}",
            in_bytes(needed),
            in_bytes(free),
            folder.display()
        );
        Problem::error(ProblemKind::Output, "disk-full", "outputs", message)
            .with_cause(because)
            .with_remedy(format!("free some, choose another folder with --out, or take {FEWER}"))
    })
}

/// The warning of a run that may take more of the disk than there is.
pub(super) fn doubt(scenario: &Scenario, folder: &Path, disk: &Disk) -> Option<Problem> {
    let free = free_space(folder).map_or(f64::INFINITY, |free| free + size_of(folder));
    let room = free.min(scenario.limits.disk.unwrap_or(f64::INFINITY));
    (disk.on_the_way.end > room).then(|| {
        let message = format!(
            "the run may take {} of the disk; {} are there for it",
            in_bytes(disk.on_the_way.end),
            in_bytes(room)
        );
        Problem::warning(ProblemKind::Output, "disk-may-fill", "outputs", message)
            .with_cause("it would end early, with the maps of what it computed, and `floodsim resume` would go on")
            .with_remedy("make room before it, or take fewer frames or larger cells of output")
    })
}

/// The room that is left while a run goes on.
pub(super) struct Room {
    folder: PathBuf,
    limit: Option<f64>,
    /// What the maps and tables take (bytes).
    reserve: f64,
    looked: Instant,
}

impl Room {
    pub fn new(scenario: &Scenario, folder: &Path, disk: &Disk) -> Self {
        Room {
            folder: folder.to_path_buf(),
            limit: scenario.limits.disk,
            reserve: disk.without_frames,
            looked: Instant::now(),
        }
    }

    /// What ends the run now: no more room than its maps need. It is looked at after every frame, and twice a second.
    pub fn shortage(&mut self, has_frame: bool) -> Option<Error> {
        if !has_frame && self.looked.elapsed() < INTERVAL {
            return None;
        }
        self.looked = Instant::now();
        let reserve = in_bytes(self.reserve);
        if let Some(limit) = self.limit.filter(|limit| size_of(&self.folder) + self.reserve > *limit) {
            let message = format!(
                "the run folder takes {}, and its maps and tables up to {reserve} more; the limit is {}",
                in_bytes(size_of(&self.folder)),
                in_bytes(limit)
            );
            let problem = Problem::error(ProblemKind::Limit, "disk-limit", "limits.disk", message).with_remedy(
                "the results up to now are in the folder; `floodsim resume --set limits.disk=SIZE` goes on with more",
            );
            return Some(Error::Problems(vec![problem]));
        }
        let free = free_space(&self.folder)?;
        (free < self.reserve).then(|| Error::Output {
            path: self.folder.clone(),
            cause: format!("the disk has {} left, and the maps and tables take up to {reserve}", in_bytes(free)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_folder_is_that_of_all_its_files() {
        let folder = tempfile::TempDir::new().unwrap();
        std::fs::write(folder.path().join("a"), [0; 1000]).unwrap();
        std::fs::create_dir(folder.path().join("cog")).unwrap();
        std::fs::write(folder.path().join("cog/b"), [0; 500]).unwrap();
        assert!((size_of(folder.path()) - 1500.0).abs() < 1e-9);
        assert!(size_of(&folder.path().join("none")).abs() < 1e-9);
        let free = |path: &Path| free_space(path).unwrap();
        assert!(free(&folder.path().join("not/yet")) > 0.0 && free(Path::new("runs")) > 0.0);
    }
}
