//! What a file of HDF5, such as NetCDF-4, names: the files that its links lead to, and those that hold values of its datasets. HDF5 itself opens them
//! without asking.

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::ptr::{null, null_mut};

use hdf5_metno_sys::h5::{H5_index_t, H5_iter_order_t, herr_t};
use hdf5_metno_sys::h5d::H5Dget_create_plist;
use hdf5_metno_sys::h5e::{H5E_DEFAULT, H5Eset_auto2};
use hdf5_metno_sys::h5f::{H5F_ACC_RDONLY, H5Fclose, H5Fopen};
use hdf5_metno_sys::h5i::hid_t;
use hdf5_metno_sys::h5l::{H5L_info1_t, H5Lget_val, H5Lunpack_elink_val, H5Lvisit1};
use hdf5_metno_sys::h5o::{H5Oclose, H5Oopen};
use hdf5_metno_sys::h5p::{
    H5P_DEFAULT, H5Pclose, H5Pget_external, H5Pget_external_count, H5Pget_virtual_count, H5Pget_virtual_filename,
};

use crate::plain_file;

/// What each file of HDF5 begins with, at its begin or at a power of two from 512 bytes on.
const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
/// The kind of a link to another file; a link of the file itself is of kind 0.
const EXTERNAL: c_int = 64;
const HARD: c_int = 0;
/// Bytes of the name of a file, at most.
const LONGEST: usize = 4096;

/// Keeps HDF5 from writing to stderr on this thread. The NetCDF library does so on the thread that is the first to use it; what it looks for in vain
/// elsewhere would be taken for errors.
#[expect(unsafe_code, reason = "the netcdf crate has no wrapper for H5Eset_auto2")]
pub fn keep_quiet() {
    let _alone = netcdf_sys::libnetcdf_lock.lock();
    // SAFETY: the library is locked; no function stands for printing nothing, and it has no data.
    unsafe { H5Eset_auto2(H5E_DEFAULT, None, null_mut()) };
}

/// Whether a file is one of HDF5.
fn is_hdf5(path: &Path) -> bool {
    let Ok(file) = plain_file::open(path) else { return false };
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    let begins_at = |place: u64| {
        let mut bytes = [0; SIGNATURE.len()];
        file.read_exact_at(&mut bytes, place).is_ok() && bytes == SIGNATURE
    };
    let places = std::iter::successors(Some(512_u64), |place| place.checked_mul(2));
    std::iter::once(0).chain(places).take_while(|place| *place < length).any(begins_at)
}

/// The names of other files in a file, as they stand there; none where HDF5 cannot open it.
#[expect(unsafe_code, reason = "no crate in the tree wraps the links of HDF5")]
pub(super) fn names_in(path: &Path) -> Vec<String> {
    if !is_hdf5(path) {
        return Vec::new();
    }
    let Ok(path) = CString::new(path.as_os_str().as_bytes()) else { return Vec::new() };
    keep_quiet();
    let _alone = netcdf_sys::libnetcdf_lock.lock();
    // SAFETY: the library is locked; the path ends with a zero.
    let file = unsafe { H5Fopen(path.as_ptr(), H5F_ACC_RDONLY, H5P_DEFAULT) };
    if file < 0 {
        return Vec::new();
    }
    let names = names_within(file);
    // SAFETY: the library is locked, and the file is open.
    unsafe { H5Fclose(file) };
    names
}

/// A link within a file: its path, its kind, and the bytes of its value where it leads elsewhere.
struct Link {
    path: CString,
    kind: c_int,
    size: usize,
}

#[expect(unsafe_code, reason = "no crate in the tree wraps the links of HDF5")]
fn names_within(file: hid_t) -> Vec<String> {
    let mut links: Vec<Link> = Vec::new();
    let (by, order) = (H5_index_t::H5_INDEX_NAME, H5_iter_order_t::H5_ITER_NATIVE);
    // SAFETY: the library is locked by the caller, the file is open, and the list lives until the call returns.
    unsafe { H5Lvisit1(file, by, order, Some(note), (&raw mut links).cast()) };
    let mut names = Vec::new();
    for link in &links {
        match link.kind {
            HARD => names.extend(names_of_values(file, &link.path)),
            EXTERNAL => names.extend(target(file, link)),
            _ => {}
        }
    }
    names.retain(|name| name != ".");
    names
}

/// Notes a link.
#[expect(unsafe_code, reason = "HDF5 calls it")]
unsafe extern "C" fn note(_: hid_t, name: *const c_char, info: *const H5L_info1_t, links: *mut c_void) -> herr_t {
    // SAFETY: HDF5 hands on the list of the caller, a text that ends with a zero, and a description. It begins with the kind and ends with the size.
    // The kind may be any number, so that it is read as one.
    unsafe {
        let kind = *info.cast::<c_int>();
        let size = if kind == EXTERNAL { *(&raw const (*info).u).cast::<usize>() } else { 0 };
        (*links.cast::<Vec<Link>>()).push(Link { path: CStr::from_ptr(name).to_owned(), kind, size });
    }
    0
}

/// The file that a link leads to.
#[expect(unsafe_code, reason = "no crate in the tree wraps the links of HDF5")]
fn target(file: hid_t, link: &Link) -> Option<String> {
    let mut value = vec![0_u8; link.size.min(2 * LONGEST)];
    let mut name: *const c_char = null();
    // SAFETY: the library is locked by the caller, and the file is open; the buffer has the size that is stated, and the name points into it.
    unsafe {
        let read = H5Lget_val(file, link.path.as_ptr(), value.as_mut_ptr().cast(), value.len(), H5P_DEFAULT);
        if read < 0 || H5Lunpack_elink_val(value.as_ptr().cast(), value.len(), null_mut(), &mut name, null_mut()) < 0 {
            return None;
        }
        Some(CStr::from_ptr(name).to_string_lossy().into_owned())
    }
}

/// The files that hold the values of a dataset; none of a group.
#[expect(unsafe_code, reason = "no crate in the tree wraps the storage of HDF5")]
fn names_of_values(file: hid_t, dataset: &CStr) -> Vec<String> {
    let mut names = Vec::new();
    let mut name = vec![0_u8; LONGEST];
    let mut add = |name: &[u8]| {
        names.extend(CStr::from_bytes_until_nul(name).map(|name| name.to_string_lossy().into_owned()));
    };
    // SAFETY: the library is locked by the caller, and the file is open; the buffer has the size that is stated, and what was opened is closed.
    unsafe {
        let object = H5Oopen(file, dataset.as_ptr(), H5P_DEFAULT);
        let properties = if object < 0 { -1 } else { H5Dget_create_plist(object) };
        if properties >= 0 {
            let count = c_uint::try_from(H5Pget_external_count(properties)).unwrap_or(0);
            for k in 0..count {
                name.fill(0);
                if H5Pget_external(properties, k, LONGEST - 1, name.as_mut_ptr().cast(), null_mut(), null_mut()) >= 0 {
                    add(&name);
                }
            }
            let mut count = 0;
            if H5Pget_virtual_count(properties, &mut count) < 0 {
                count = 0;
            }
            for k in 0..count {
                name.fill(0);
                if H5Pget_virtual_filename(properties, k, name.as_mut_ptr().cast(), LONGEST) >= 0 {
                    add(&name);
                }
            }
            H5Pclose(properties);
        }
        if object >= 0 {
            H5Oclose(object);
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use hdf5_metno_sys::h5d::{H5Dclose, H5Dcreate2};
    use hdf5_metno_sys::h5f::{H5F_ACC_TRUNC, H5Fcreate};
    use hdf5_metno_sys::h5l::H5Lcreate_external;
    use hdf5_metno_sys::h5p::{H5P_CLS_DATASET_CREATE, H5Pcreate, H5Pset_external, H5Pset_virtual};
    use hdf5_metno_sys::h5s::{H5Sclose, H5Screate_simple};
    use hdf5_metno_sys::h5t::H5T_NATIVE_INT;

    /// A file with a link to one file, a dataset whose values are in a second one, and one that is made of a third.
    #[expect(unsafe_code, reason = "no crate in the tree makes links of HDF5")]
    fn write(path: &Path) {
        let text = |text: &str| CString::new(text).unwrap();
        let path = CString::new(path.as_os_str().as_bytes()).unwrap();
        let _alone = netcdf_sys::libnetcdf_lock.lock();
        // SAFETY: the library is locked; every text lives until the end of its call, and what was opened is closed.
        unsafe {
            let file = H5Fcreate(path.as_ptr(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
            H5Lcreate_external(
                text("linked.h5").as_ptr(),
                text("/a").as_ptr(),
                file,
                text("a").as_ptr(),
                H5P_DEFAULT,
                H5P_DEFAULT,
            );
            let space = H5Screate_simple(1, &8, null());
            for (name, is_virtual) in [("b", false), ("c", true)] {
                let properties = H5Pcreate(*H5P_CLS_DATASET_CREATE);
                if is_virtual {
                    H5Pset_virtual(properties, space, text("made_of.h5").as_ptr(), text("/c").as_ptr(), space);
                } else {
                    H5Pset_external(properties, text("/etc/hostname").as_ptr(), 0, 32);
                }
                let own = text(name);
                let made = H5Dcreate2(file, own.as_ptr(), *H5T_NATIVE_INT, space, H5P_DEFAULT, properties, H5P_DEFAULT);
                assert!(made >= 0 && H5Dclose(made) >= 0 && H5Pclose(properties) >= 0);
            }
            assert!(H5Sclose(space) >= 0 && H5Fclose(file) >= 0);
        }
    }

    #[test]
    fn files_that_a_file_names_are_found() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.nc");
        let mut file = netcdf::create(&path).unwrap();
        file.add_dimension("x", 3).unwrap();
        file.add_variable::<f32>("depth", &["x"]).unwrap().put_values(&[1.0_f32; 3], ..).unwrap();
        file.close().unwrap();
        assert_eq!(names_in(&path), Vec::<String>::new());
        let other = place.path().join("b.nc");
        write(&other);
        let mut names = names_in(&other);
        names.sort();
        assert_eq!(names, ["/etc/hostname", "linked.h5", "made_of.h5"]);
        std::fs::write(&other, "no such file").unwrap();
        assert_eq!(names_in(&other), Vec::<String>::new());
    }
}
