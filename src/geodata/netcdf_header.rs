//! The head of a classic NetCDF file: whether what it counts can be in a file of its size. The library takes memory for whatever a damaged head
//! counts, and crashes where the system does not give it.
//!
//! The grammar is that of the NetCDF classic format specification (CDF-1, 2 and 5): lists of dimensions, attributes and variables.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use crate::plain_file;

/// Bytes of a tag, of a type, and of what numbers and texts are filled up to.
const WORD: u64 = 4;

/// Whether a file is none of the classic format, or its head fits into it.
pub(super) fn is_possible(path: &Path) -> bool {
    let Ok(file) = plain_file::open(path) else { return true };
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    let mut head = Head { bytes: BufReader::new(file), left: length, number: WORD, offset: WORD };
    match head.word().map(u32::to_be_bytes) {
        Some([b'C', b'D', b'F', 1]) => {}
        Some([b'C', b'D', b'F', 2]) => head.offset = 8,
        Some([b'C', b'D', b'F', 5]) => (head.number, head.offset) = (8, 8),
        _ => return true,
    }
    head.walk().is_some()
}

/// What is left of a file, and the bytes of its numbers and offsets. Every step gives none where the file has no room for it.
struct Head {
    bytes: BufReader<File>,
    left: u64,
    number: u64,
    offset: u64,
}

impl Head {
    fn walk(&mut self) -> Option<()> {
        // The number of records may be unknown, with all bits set.
        self.skip(self.number)?;
        self.list(2 * self.number, |head| head.name().and_then(|()| head.skip(head.number)))?;
        self.attributes()?;
        self.list(3 * self.number, Head::variable)
    }

    /// A list, each entry of which has so many bytes or more.
    fn list(&mut self, least: u64, mut entry: impl FnMut(&mut Head) -> Option<()>) -> Option<()> {
        self.skip(WORD)?;
        let count = self.count(least)?;
        (0..count).try_for_each(|_| entry(self))
    }

    fn attributes(&mut self) -> Option<()> {
        self.list(2 * self.number + WORD, |head| {
            head.name()?;
            let size = size_of_type(head.word()?)?;
            let count = head.count(size)?;
            head.skip((count * size).next_multiple_of(WORD))
        })
    }

    fn variable(&mut self) -> Option<()> {
        self.name()?;
        let dimensions = self.count(self.number)?;
        self.skip(dimensions * self.number)?;
        self.attributes()?;
        size_of_type(self.word()?)?;
        self.skip(self.number + self.offset)
    }

    fn name(&mut self) -> Option<()> {
        let length = self.count(1)?;
        self.skip(length.next_multiple_of(WORD))
    }

    /// A number of things of so many bytes or more, for all of which there is room.
    fn count(&mut self, least: u64) -> Option<u64> {
        let high = if self.number > WORD { self.word()? } else { 0 };
        let count = u64::from(high) << 32 | u64::from(self.word()?);
        (count.checked_mul(least)? <= self.left).then_some(count)
    }

    fn word(&mut self) -> Option<u32> {
        let mut bytes = [0; WORD as usize];
        self.left = self.left.checked_sub(WORD)?;
        self.bytes.read_exact(&mut bytes).ok()?;
        Some(u32::from_be_bytes(bytes))
    }

    fn skip(&mut self, bytes: u64) -> Option<()> {
        self.left = self.left.checked_sub(bytes)?;
        self.bytes.seek_relative(i64::try_from(bytes).ok()?).ok()
    }
}

/// Bytes of a value of a type.
fn size_of_type(kind: u32) -> Option<u64> {
    match kind {
        1 | 2 | 7 => Some(1),
        3 | 8 => Some(2),
        4 | 5 | 9 => Some(4),
        6 | 10 | 11 => Some(8),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_that_count_more_than_their_file_holds_are_not_possible() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.nc");
        for (kind, options) in
            [(1, netcdf::Options::empty()), (2, netcdf::Options::_64BIT_OFFSET), (5, netcdf::Options::_64BIT_DATA)]
        {
            let mut file = netcdf::create_with(&path, options).unwrap();
            file.add_dimension("x", 3).unwrap();
            file.add_attribute("title", "a valley").unwrap();
            let mut variable = file.add_variable::<f64>("depth", &["x"]).unwrap();
            variable.put_attribute("levels", vec![1.0_f64, 2.0]).unwrap();
            file.enddef().unwrap();
            file.variable_mut("depth").unwrap().put_values(&[1.0; 3], ..).unwrap();
            file.close().unwrap();
            assert!(is_possible(&path), "{kind}");
            let sound = std::fs::read(&path).unwrap();
            // The counts behind the tags of dimensions, variables and attributes.
            let wide = usize::from(kind == 5);
            for tag in [0x0a_u32, 0x0b, 0x0c] {
                let place = sound.windows(4).position(|bytes| bytes == tag.to_be_bytes()).unwrap();
                let mut bytes = sound.clone();
                bytes[place + 4 + 4 * wide] = 0x0c;
                std::fs::write(&path, bytes).unwrap();
                assert!(!is_possible(&path), "{kind}, {tag}");
            }
            std::fs::write(&path, &sound[..60]).unwrap();
            assert!(!is_possible(&path), "{kind}, cut off");
        }
        std::fs::write(&path, "no such file").unwrap();
        assert!(is_possible(&path));
    }
}
