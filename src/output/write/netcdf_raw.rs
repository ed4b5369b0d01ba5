//! The calls of NetCDF and HDF5 that their crates do not wrap.

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

/// Keeps HDF5 from writing to stderr on this thread. The NetCDF library does so on the thread that is the first to use it; what it looks for in vain
/// elsewhere would be taken for errors.
#[expect(unsafe_code, reason = "the netcdf crate has no wrapper for H5Eset_auto2")]
pub(super) fn keep_quiet() {
    let _alone = netcdf_sys::libnetcdf_lock.lock();
    // SAFETY: the library is locked; no function stands for printing nothing, and it has no data.
    unsafe { hdf5_metno_sys::h5e::H5Eset_auto2(hdf5_metno_sys::h5e::H5E_DEFAULT, None, std::ptr::null_mut()) };
}
