//! ESRI ASCII grids: finds the words that are no numbers, which GDAL reads as 0 without a warning,
//! and counts the values, of which GDAL leaves out what is too many.

use std::io::{BufRead, BufReader};
use std::path::Path;

use crate::plain_file;

/// Names that begin a line of the header, in lower case.
const HEADER: [&str; 10] =
    ["ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy", "nodata_value"];

/// Words in the place of numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Broken {
    /// How many there are.
    pub count: usize,
    /// Which value is the first of them, counted from 0 along the rows from the upper left.
    pub index: usize,
    /// The first of them.
    pub word: String,
}

/// Finds the values that are not finite numbers, and counts all; `nan` passes where the header declares it as nodata.
///
/// # Errors
/// When the file cannot be read as a plain file, as within an archive.
pub(super) fn broken_values(path: &Path) -> std::io::Result<(Option<Broken>, usize)> {
    let mut reader = BufReader::new(plain_file::open(path)?);
    let (mut bytes, mut in_header, mut nan_is_nodata) = (Vec::new(), true, false);
    let (mut index, mut broken) = (0, None::<Broken>);
    while reader.read_until(b'\n', &mut bytes)? > 0 {
        let line = String::from_utf8_lossy(&bytes);
        let mut words = line.split_ascii_whitespace();
        let name = words.clone().next().unwrap_or_default().to_ascii_lowercase();
        in_header &= name.is_empty() || HEADER.contains(&name.as_str());
        if in_header {
            nan_is_nodata |=
                name == "nodata_value" && words.nth(1).is_some_and(|value| value.eq_ignore_ascii_case("nan"));
        } else {
            for word in words {
                let is_nodata = nan_is_nodata && word.eq_ignore_ascii_case("nan");
                if !is_nodata && !is_number(word) {
                    broken.get_or_insert_with(|| Broken { count: 0, index, word: word.to_owned() }).count += 1;
                }
                index += 1;
            }
        }
        bytes.clear();
    }
    Ok((broken, index))
}

/// Whether a word is a finite number, with a point or a comma as decimal sign, which GDAL takes both.
fn is_number(word: &str) -> bool {
    let is_finite = |text: &str| text.parse::<f64>().is_ok_and(f64::is_finite);
    is_finite(word) || is_finite(&word.replace(',', "."))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(header: &str, values: &str) -> Option<Broken> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grid.asc");
        std::fs::write(&path, format!("ncols 3\r\nNROWS 2\ncellsize 1\n{header}\n{values}")).unwrap();
        let (broken, count) = broken_values(&path).unwrap();
        assert_eq!(count, values.split_ascii_whitespace().count());
        broken
    }

    #[test]
    fn numbers_of_every_form_pass() {
        assert_eq!(broken("NODATA_value -9999", "1 2.5 -3e2\n-9999 +.5 12,7\n"), None);
        assert_eq!(broken("nodata_value NaN", "1 nan 3\n4 5 6"), None);
    }

    #[test]
    fn words_are_counted_from_the_upper_left() {
        let found = broken("NODATA_value -9999", "1 2 3 4\nabc 1.#IND").unwrap();
        assert_eq!(found, Broken { count: 2, index: 4, word: "abc".to_owned() });
        assert_eq!(broken("", "1 nan 3\n4 inf 6").map(|found| found.count), Some(2));
    }
}
