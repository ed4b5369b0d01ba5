//! Time, processor time and memory of the run, for its record.

use std::time::Instant;

use crate::output::RunManifest;
pub use crate::solver::phases::processor_seconds;

/// Measures a run and its phases.
pub struct Clock {
    start: Instant,
    lap: Instant,
    phases: Vec<(String, f64)>,
}

impl Clock {
    /// Starts measuring.
    pub fn start() -> Self {
        let now = Instant::now();
        Clock { start: now, lap: now, phases: Vec::new() }
    }

    /// Ends a phase.
    pub fn lap(&mut self, phase: &'static str) {
        let now = Instant::now();
        self.phases.push((phase.to_owned(), (now - self.lap).as_secs_f64()));
        self.lap = now;
    }

    /// Notes a part of a phase that was measured elsewhere (s); it is written as `phase: part`.
    pub fn part(&mut self, phase: &str, part: &str, seconds: f64) {
        self.phases.push((format!("{phase}: {part}"), seconds));
    }

    /// Writes what was measured into the manifest.
    pub fn note(&self, manifest: &mut RunManifest) {
        manifest.wall_s = self.start.elapsed().as_secs_f64();
        manifest.cpu_s = processor_seconds();
        manifest.peak_rss_mb = memory_mib();
        manifest.phase_s = self.phases.iter().cloned().collect();
    }
}

/// Greatest resident memory so far (MiB), 0 where the system does not tell.
pub fn memory_mib() -> f64 {
    peak_memory_mib().unwrap_or(0.0)
}

/// Greatest resident memory so far (MiB), where the system tells it in `/proc`.
fn peak_memory_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib / 1024.0)
}

/// The vector instructions that the hot loops use on this machine.
pub fn simd() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        // `multiversion` takes the AVX-512 copies only where the processor does not slow down for them: where it has these, too.
        let is_fast = std::arch::is_x86_feature_detected!("avx512vbmi2") && std::arch::is_x86_feature_detected!("gfni");
        if is_fast && std::arch::is_x86_feature_detected!("avx512vpopcntdq") {
            return "avx512";
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            return "avx2";
        }
    }
    "baseline"
}
