//! Opens NetCDF files of others. The library for them ends the program at a name that is not UTF-8 text, and at a variable that is listed and cannot
//! be read, so that such files are refused.

use std::ffi::{CStr, CString, c_char, c_int};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::ptr::null_mut;

use super::netcdf_header;
use crate::error::{Problem, input_error};
use netcdf_sys::{NC_GLOBAL, NC_MAX_NAME, NC_MAX_VAR_DIMS, NC_NOERR, NC_NOWRITE};

/// What is said of such a file.
const DAMAGED: &str = "a dimension, a variable or an attribute in it cannot be read, or its name is not UTF-8 text";

/// What is said of a file whose head cannot be right.
const TOO_MUCH: &str = "its head counts more than the file has room for: it is damaged, or cut off";

/// The refusal of a classic file whose head cannot be right. Any library that opens such a file may crash.
pub fn impossible(path: &Path) -> Option<Problem> {
    (!netcdf_header::is_possible(path)).then(|| refused(path, TOO_MUCH.to_owned()))
}

/// Opens a file to be read.
///
/// # Errors
/// That of the library, or `netcdf::Error::Str` where something that the file lists cannot be read.
pub fn open(path: &Path) -> netcdf::Result<netcdf::File> {
    let file = netcdf::open(path)?;
    if is_sound(path) { Ok(file) } else { Err(netcdf::Error::Str(DAMAGED.to_owned())) }
}

/// The refusal of such a file.
pub fn refused(path: &Path, cause: String) -> Problem {
    input_error("not-a-netcdf", format!("{} cannot be read as NetCDF", path.display()))
        .with_cause(cause)
        .with_remedy("copy or export the file again; `ncdump -h FILE` shows whether it is NetCDF")
}

/// Whether everything that a file lists can be read and has a name of UTF-8 text; true where the file cannot be opened.
#[expect(unsafe_code, reason = "the netcdf crate panics at what it cannot read")]
fn is_sound(path: &Path) -> bool {
    let Ok(path) = CString::new(path.as_os_str().as_bytes()) else { return true };
    let _alone = netcdf_sys::libnetcdf_lock.lock();
    let mut file = 0;
    // SAFETY: the library is locked; the path ends with a zero, and the number of the file lives until the call returns.
    if unsafe { netcdf_sys::nc_open(path.as_ptr(), NC_NOWRITE, &mut file) } != NC_NOERR {
        return true;
    }
    let is_sound = has_sound_entries(file);
    // SAFETY: the library is locked, and the file is open.
    unsafe { netcdf_sys::nc_close(file) };
    is_sound
}

/// The same of an open file, while the library is locked.
#[expect(unsafe_code, reason = "the netcdf crate panics at what it cannot read")]
fn has_sound_entries(file: c_int) -> bool {
    let (mut dimensions, mut variables, mut attributes) = (0, 0, 0);
    // SAFETY: the library is locked, and the counts live until the call returns; what is not asked for may be null.
    if unsafe { netcdf_sys::nc_inq(file, &mut dimensions, &mut variables, &mut attributes, null_mut()) } != NC_NOERR {
        return false;
    }
    // SAFETY: the library is locked; each buffer has room for the longest name and its end, `sides` for all dimensions of a variable, and what is
    // not asked for may be null.
    let of_dimension = |k| is_text(|name| unsafe { netcdf_sys::nc_inq_dim(file, k, name, null_mut()) });
    // SAFETY: as for dimensions.
    let of_attribute = |of, k| is_text(|name| unsafe { netcdf_sys::nc_inq_attname(file, of, k, name) });
    let of_variable = |k| {
        let (mut sides, mut count) = ([0; NC_MAX_VAR_DIMS as usize], 0);
        let read = |name| {
            // SAFETY: as for dimensions.
            unsafe { netcdf_sys::nc_inq_var(file, k, name, null_mut(), null_mut(), sides.as_mut_ptr(), &mut count) }
        };
        is_text(read) && (0..count).all(|attribute| of_attribute(k, attribute))
    };
    (0..dimensions).all(of_dimension)
        && (0..attributes).all(|k| of_attribute(NC_GLOBAL, k))
        && (0..variables).all(of_variable)
}

/// Whether a name can be read into a buffer, and is UTF-8 text.
fn is_text(read: impl FnOnce(*mut c_char) -> c_int) -> bool {
    let mut name = [0_u8; NC_MAX_NAME as usize + 1];
    let code = read(name.as_mut_ptr().cast());
    code == NC_NOERR && CStr::from_bytes_until_nul(&name).is_ok_and(|name| name.to_str().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_no_text_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.nc");
        let names = ["dimension", "variable", "attribute", "general"];
        let mut file = netcdf::create_with(&path, netcdf::Options::_64BIT_OFFSET).unwrap();
        file.add_dimension(names[0], 2).unwrap();
        file.add_variable::<f64>(names[1], &[names[0]]).unwrap().put_attribute(names[2], "m").unwrap();
        file.add_attribute(names[3], "m").unwrap();
        file.close().unwrap();
        assert!(open(&path).is_ok());
        let sound = std::fs::read(&path).unwrap();
        for name in names {
            let mut bytes = sound.clone();
            let at = bytes.windows(name.len()).position(|part| part == name.as_bytes()).unwrap();
            bytes[at + 2] = 0xff;
            std::fs::write(&path, bytes).unwrap();
            assert!(matches!(open(&path), Err(netcdf::Error::Str(_))), "{name}");
        }
    }
}
