//! How much memory the machine lets the program have: its own, that of the containers around it, and the limits of its process.

use std::path::{Path, PathBuf};

use rustix::process::{Resource, getrlimit};

/// Memory (bytes) where the system does not say.
const UNKNOWN: f64 = 8e9;

/// Memory of the machine, of each container (cgroup) around the program, or what its process may still take, whichever is least (bytes).
pub fn machine_memory() -> f64 {
    let least = machine().into_iter().chain(containers()).chain(process()).reduce(f64::min);
    least.unwrap_or(UNKNOWN)
}

/// Memory of the machine (bytes).
fn machine() -> Option<f64> {
    kibibytes("/proc/meminfo", "MemTotal:")
}

/// A number of a file of `/proc` (bytes).
fn kibibytes(file: &str, name: &str) -> Option<f64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().trim_end_matches("kB").trim().parse::<f64>().ok().map(|kibibytes| kibibytes * 1024.0)
}

/// The limits of the containers around the program (bytes), the innermost first.
fn containers() -> Vec<f64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    limits_of_groups(&groups, Path::new("/sys/fs/cgroup"))
}

/// The limits (bytes) of the groups of a process, as `/proc/self/cgroup` lists them, and of those around them. One limit may be above
/// that of a group around it.
fn limits_of_groups(groups: &str, root: &Path) -> Vec<f64> {
    let of_line = |line: &str| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, path) = (fields.next()?, fields.next()?);
        // The second version has one tree for all; the first has one of its own for memory.
        let (base, file) = match controllers {
            "" => (root.to_path_buf(), "memory.max"),
            some if some.split(',').any(|one| one == "memory") => (root.join("memory"), "memory.limit_in_bytes"),
            _ => return None,
        };
        let path = PathBuf::from(path.trim_start_matches('/'));
        // In a container the path may be that of its host, which is not there: its own group is the root of what it sees.
        let limits = path.ancestors().filter_map(|group| std::fs::read_to_string(base.join(group).join(file)).ok());
        Some(limits.filter_map(|limit| limit.trim().parse().ok()).collect::<Vec<f64>>())
    };
    groups.lines().filter_map(of_line).flatten().collect()
}

/// Address space (bytes) that the program takes beside its memory: stacks of threads, and what allocators set aside for each.
const SET_ASIDE: f64 = 300e6;

/// What the process may take by its limits of address space and data (`ulimit -v`, `-d`), beside what it has of them now (bytes).
fn process() -> Option<f64> {
    let resident = kibibytes("/proc/self/status", "VmRSS:").unwrap_or(0.0);
    let of = |resource, taken| {
        let limit = getrlimit(resource).current? as f64;
        let taken = kibibytes("/proc/self/status", taken).unwrap_or(0.0) + SET_ASIDE;
        Some((limit - taken).max(0.0) + resident)
    };
    [of(Resource::As, "VmSize:"), of(Resource::Data, "VmData:")].into_iter().flatten().reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limits_of_all_groups_around_the_program_count() {
        let root = tempfile::TempDir::new().unwrap();
        let write = |path: &str, text: &str| {
            let path = root.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        write("batch/job/memory.max", "max\n");
        write("batch/memory.max", "2000000000\n");
        write("memory.max", "9000000000\n");
        assert_eq!(limits_of_groups("0::/batch/job\n", root.path()), [2e9, 9e9]);
        // The path of the host, in a container.
        assert_eq!(limits_of_groups("0::/docker/0123\n", root.path()), [9e9]);
        write("memory/slurm/memory.limit_in_bytes", "500000000");
        write("memory/memory.limit_in_bytes", "9223372036854771712");
        let first = "7:cpu,cpuacct:/other\n4:memory:/slurm\n";
        assert_eq!(limits_of_groups(first, root.path()), [5e8, 9_223_372_036_854_771_712.0]);
        assert!(limits_of_groups("", root.path()).is_empty());
    }

    #[test]
    fn the_machine_has_some_memory() {
        assert!(machine().is_some_and(|bytes| bytes > 1e8) && machine_memory() > 1e7);
    }
}
