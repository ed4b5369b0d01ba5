//! SHA-256 of files, and of what is written.

use std::io::{Read, Write};
use std::path::Path;

use sha2::{Digest, Sha256};

/// Bytes of a checksum.
pub const LENGTH: u64 = 32;

/// Hands bytes on, and takes the checksum of those that pass.
#[derive(Debug)]
pub struct Checked<W> {
    inner: W,
    digest: Sha256,
    bytes: u64,
}

impl<W> Checked<W> {
    /// A checksum of nothing yet.
    pub fn new(inner: W) -> Self {
        Checked { inner, digest: Sha256::new(), bytes: 0 }
    }

    /// What the bytes were handed on to, how many there were, and their checksum.
    pub fn finish(self) -> (W, u64, [u8; LENGTH as usize]) {
        (self.inner, self.bytes, self.digest.finalize().into())
    }
}

impl<W: Write> Write for Checked<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.digest.update(&bytes[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

/// Number and checksum of all bytes that a reader has.
///
/// # Errors
/// When they cannot be read.
pub fn of_bytes(mut reader: impl Read) -> std::io::Result<(u64, [u8; LENGTH as usize])> {
    let mut checked = Checked::new(std::io::sink());
    std::io::copy(&mut reader, &mut checked)?;
    let (_, bytes, checksum) = checked.finish();
    Ok((bytes, checksum))
}

/// Size (bytes) and checksum of a file, the latter in hexadecimal digits.
///
/// # Errors
/// When it cannot be read.
pub fn of_file(path: &Path) -> std::io::Result<(u64, String)> {
    let (bytes, checksum) = of_bytes(crate::plain_file::open(path)?)?;
    Ok((bytes, checksum.iter().map(|byte| format!("{byte:02x}")).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_of_sha256sum() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a");
        std::fs::write(&path, "abc").unwrap();
        // The example of FIPS 180-2.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(of_file(&path).unwrap(), (3, expected.to_owned()));
        let mut checked = Checked::new(Vec::new());
        checked.write_all(b"ab").and_then(|()| checked.write_all(b"c")).unwrap();
        let (written, bytes, checksum) = checked.finish();
        assert_eq!((written.as_slice(), bytes, checksum), (&b"abc"[..], 3, of_bytes(&b"abc"[..]).unwrap().1));
        assert!(of_file(&place.path().join("b")).is_err());
    }
}
