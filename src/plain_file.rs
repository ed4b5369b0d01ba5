//! Files and folders that may be read: a pipe, a device or a socket gives no end of bytes or none at all, and what a text may hold has a bound.

use std::ffi::OsStr;
use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};

use rustix::fs::{Dir, Mode, OFlags};

/// Bytes of a text, such as a table or the record of a run, at most: 1 GiB.
pub const MOST_TEXT: u64 = 1 << 30;

/// What a file is where it is neither a file nor a folder, in words.
pub fn odd_kind(metadata: &Metadata) -> Option<&'static str> {
    let kind = metadata.file_type();
    match () {
        () if kind.is_file() || kind.is_dir() => None,
        () if kind.is_fifo() => Some("a named pipe"),
        () if kind.is_socket() => Some("a socket"),
        () => Some("a device"),
    }
}

/// Opens a file; never waits, as for the writer of a pipe.
///
/// # Errors
/// When it cannot be opened, and of the kind `InvalidInput` when it is a pipe, a device or a socket.
pub fn open(path: &Path) -> Result<File> {
    match odd_kind(&std::fs::metadata(path)?) {
        Some(kind) => Err(Error::new(ErrorKind::InvalidInput, format!("it is {kind}, not a file"))),
        None => File::open(path),
    }
}

/// All bytes of a reader.
///
/// # Errors
/// When it cannot be read, and of the kind `FileTooLarge` when it has more than `most` bytes.
pub fn read_at_most(reader: impl Read, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let message = format!("it holds more than {:.0} MB of text", most as f64 / 1e6);
        return Err(Error::new(ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

/// The text of a file of at most [`MOST_TEXT`] bytes.
///
/// # Errors
/// When it cannot be read, is larger, or is no UTF-8.
pub fn read_to_string(path: impl AsRef<Path>) -> Result<String> {
    let bytes = read_at_most(open(path.as_ref())?, MOST_TEXT)?;
    String::from_utf8(bytes).map_err(|error| Error::new(ErrorKind::InvalidData, error))
}

/// The paths of what is in a folder, by name. The standard library's own reader panics where the folder cannot be closed.
///
/// # Errors
/// When it is no folder, or cannot be read.
pub fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let opened = rustix::fs::open(folder, OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC, Mode::empty())?;
    let mut paths = Vec::new();
    for entry in Dir::new(opened)? {
        let entry = entry?;
        let name = entry.file_name().to_bytes();
        if name != b"." && name != b".." {
            paths.push(folder.join(OsStr::from_bytes(name)));
        }
    }
    paths.sort();
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_in_a_folder_is_found() {
        let place = tempfile::tempdir().unwrap();
        let paths = ["b", "a c", ".hidden"].map(|name| place.path().join(name));
        paths.iter().for_each(|path| std::fs::write(path, "").unwrap());
        let [b, a, hidden] = paths;
        assert_eq!(entries(place.path()).unwrap(), [hidden, a, b.clone()]);
        assert!(entries(&b).is_err() && entries(&place.path().join("none")).is_err());
    }

    #[test]
    fn what_has_no_end_is_not_read() {
        let device = open(Path::new("/dev/zero")).unwrap_err();
        assert_eq!(device.to_string(), "it is a device, not a file");
        assert_eq!(read_at_most(std::io::repeat(b' '), 10).unwrap_err().kind(), ErrorKind::FileTooLarge);
        assert_eq!(read_at_most(&b"0123456789"[..], 10).unwrap(), b"0123456789");
        let place = tempfile::tempdir().unwrap();
        let socket = place.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        assert_eq!(read_to_string(&socket).unwrap_err().to_string(), "it is a socket, not a file");
    }
}
