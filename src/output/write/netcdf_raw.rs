//! The calls of NetCDF and HDF5 that their crates do not wrap.

use std::ffi::CString;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use hdf5_metno_sys::h5f::{H5F_OBJ_ALL, H5F_OBJ_FILE, H5Fclose, H5Fget_name, H5Fget_obj_count, H5Fget_obj_ids};
use hdf5_metno_sys::h5i::{H5Iinc_ref, hid_t};

/// Slots of the hash table of a cache that holds one chunk.
const SLOTS: usize = 1;

/// Defines variables whose chunks go to the disk as soon as they are whole. Otherwise each keeps up to 16 MiB until the file is closed.
///
/// `chunk` is the size of their chunks (bytes); where one has larger chunks, the library takes a larger cache of its own.
#[expect(unsafe_code, reason = "the netcdf crate has no wrapper for nc_set_chunk_cache")]
pub(super) fn with_caches_of<T>(chunk: usize, define: impl FnOnce() -> T) -> T {
    // What variables take their cache from is one for the whole library.
    let _alone = netcdf_sys::libnetcdf_lock.lock();
    let (mut size, mut slots, mut preemption) = (0, 0, 0.0);
    // SAFETY: the library is locked, and the pointers are those of three numbers that live until the call returns.
    let known = unsafe { netcdf_sys::nc_get_chunk_cache(&mut size, &mut slots, &mut preemption) };
    let set = |size: usize, slots: usize| {
        if known == netcdf_sys::NC_NOERR {
            // SAFETY: the library is locked; the call takes plain numbers. One that it refuses leaves the caches as they are.
            unsafe { netcdf_sys::nc_set_chunk_cache(size, slots, preemption) };
        }
    };
    set(chunk, SLOTS);
    let defined = define();
    set(size, slots);
    defined
}

/// A second hold on an open NetCDF-4 file, as HDF5 has it; the file closes when both are given up.
///
/// Where HDF5 cannot close a file, the NetCDF library looks for what is still open in it, and crashes (4.9). With this hold the library only gives up
/// its own, and the file closes here.
#[derive(Debug)]
pub(super) struct SecondHold(Option<hid_t>);

impl SecondHold {
    /// No hold: of classic files, which HDF5 does not open.
    pub(super) const NONE: SecondHold = SecondHold(None);

    /// The hold on the open file of a path; none where HDF5 has not opened it.
    #[expect(unsafe_code, reason = "the netcdf crate does not give the file of HDF5")]
    pub(super) fn on(path: &Path) -> Self {
        let Ok(path) = CString::new(path.as_os_str().as_bytes()) else { return Self::NONE };
        let all = hid_t::from(H5F_OBJ_ALL);
        let _alone = netcdf_sys::libnetcdf_lock.lock();
        // SAFETY: the library is locked; the call takes plain numbers.
        let count = usize::try_from(unsafe { H5Fget_obj_count(all, H5F_OBJ_FILE) }).unwrap_or(0);
        let mut open: Vec<hid_t> = vec![0; count];
        // SAFETY: the library is locked, and there is room for as many numbers as are asked for.
        let found = unsafe { H5Fget_obj_ids(all, H5F_OBJ_FILE, count, open.as_mut_ptr()) };
        open.truncate(usize::try_from(found).unwrap_or(0));
        let is_it = |file: &hid_t| {
            let mut name = vec![0_u8; path.as_bytes_with_nul().len() + 1];
            // SAFETY: the library is locked; the file is open, and the buffer has the size that is stated.
            let length = unsafe { H5Fget_name(*file, name.as_mut_ptr().cast(), name.len()) };
            usize::try_from(length).is_ok_and(|length| name.get(..length) == Some(path.as_bytes()))
        };
        // SAFETY: the library is locked, and the file is open.
        SecondHold(open.into_iter().rev().find(is_it).filter(|file| unsafe { H5Iinc_ref(*file) } > 1))
    }

    /// Closes the file, which the library for NetCDF has given up.
    ///
    /// # Errors
    /// When HDF5 cannot close it.
    pub(super) fn close(mut self) -> netcdf::Result<()> {
        if self.give_up() { Ok(()) } else { Err(netcdf::Error::Str("the file cannot be closed".to_owned())) }
    }

    #[expect(unsafe_code, reason = "the netcdf crate does not give the file of HDF5")]
    fn give_up(&mut self) -> bool {
        let _alone = netcdf_sys::libnetcdf_lock.lock();
        // SAFETY: the library is locked; this hold is given up once.
        self.0.take().is_none_or(|file| unsafe { H5Fclose(file) } >= 0)
    }
}

impl Drop for SecondHold {
    fn drop(&mut self) {
        // Of a file that was only read, or that is already known to have failed.
        self.give_up();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_closes_with_its_second_hold() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.nc");
        let mut file = netcdf::create(&path).unwrap();
        let hold = SecondHold::on(&path);
        assert!(hold.0.is_some());
        file.add_dimension("x", 3).unwrap();
        file.close().unwrap();
        assert!(SecondHold::on(&path).0.is_some(), "it is still open");
        hold.close().unwrap();
        assert!(SecondHold::on(&path).0.is_none());
        assert_eq!(netcdf::open(&path).unwrap().dimension_len("x"), Some(3));
        let classic = place.path().join("b.nc");
        let _file = netcdf::create_with(&classic, netcdf::Options::_64BIT_OFFSET).unwrap();
        assert!(SecondHold::on(&classic).0.is_none());
    }
}
