//! The rim to GDAL that terrain, vectors and writers share: its messages, coordinate reference systems, and the four
//! functions that the gdal crate does not wrap.

pub mod cf_axes;
pub mod cf_heights;
pub mod cf_valid;
mod crs;
mod hdf5;
mod messages;
pub mod netcdf_file;
mod netcdf_header;
pub mod open;
mod text;
mod unwrapped;
pub mod vrt;

pub use crs::{
    Crs, CrsProblem, describe, is_metric, map_scales, run_crs_of, same_horizontal, spatial_ref, suggested_utm,
    transform, vertical_datum, vertical_points_down, vertical_unit,
};
pub use hdf5::keep_quiet;
pub use messages::{alone, capture, heard};
pub use text::{Table, TextError, read_text, read_text_within};
pub use unwrapped::{horizontal_part, is_alpha, warp_to_memory};

use std::path::Path;

use crate::error::{Problem, ProblemKind};
use crate::plain_file;

/// Refuses a path that is not a readable file with something in it, before GDAL sees it (GDAL's own message is empty then).
///
/// # Errors
/// The problem, without key and place.
pub fn readable_file(path: &Path) -> Result<(), Problem> {
    let name = path.display();
    // What GDAL alone can reach is admitted, or not, before.
    if path.as_os_str().as_encoded_bytes().starts_with(b"/vsi") {
        return Ok(());
    }
    let metadata = std::fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            Problem::error(ProblemKind::Input, "missing-file", "", format!("the file `{name}` does not exist"))
                .with_remedy("paths count from the folder of the scenario file; check the spelling")
        }
        _ => unreadable(path, &error),
    })?;
    // Some formats are folders (a file geodatabase, an Arc/Info binary grid); GDAL decides on those.
    if metadata.is_dir() {
        return Ok(());
    }
    if let Some(kind) = plain_file::odd_kind(&metadata) {
        return Err(not_a_file(path, kind));
    }
    if metadata.len() == 0 {
        return Err(Problem::error(ProblemKind::Input, "empty-file", "", format!("{name} is empty (0 bytes)"))
            .with_remedy("copy or export the file again"));
    }
    std::fs::File::open(path).map(drop).map_err(|error| unreadable(path, &error))
}

/// The problem of a pipe, a device or a socket in the place of a file.
pub fn not_a_file(path: &Path, kind: &str) -> Problem {
    let message = format!("{} is {kind}, not a file", path.display());
    Problem::error(ProblemKind::Input, "not-a-file", "", message)
        .with_cause("it may never end, and has no checksum")
        .with_remedy("write what it gives to a file, and name that")
}

fn unreadable(path: &Path, error: &std::io::Error) -> Problem {
    Problem::error(ProblemKind::Input, "unreadable-file", "", format!("{} cannot be read", path.display()))
        .with_cause(error.to_string())
        .with_remedy("check the permissions of the file and of its folder")
}
