//! Tables of plain text: comma, semicolon, tabulator or blank separated, with or without a header, gzipped or not.
//!
//! Hand-written because of the messages: a bad number is reported with its line, which GDAL's CSV driver does not do.

use std::path::Path;

use crate::csv::as_meant;
use crate::error::plain_name;
use crate::plain_file::{self, MOST_TEXT, read_at_most};

/// A table as it stands in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Names of the columns, when the first line is no data.
    pub header: Option<Vec<String>>,
    /// Rows with the number of their line in the file, from 1.
    pub rows: Vec<(usize, Vec<String>)>,
}

/// Why a file could not be read as text.
#[derive(Debug, thiserror::Error)]
pub enum TextError {
    /// The system's reason.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// It is some other kind of file.
    #[error("it is not a text file")]
    NotText,
}

/// The text of a file, unpacked if it is gzipped; a byte order mark is dropped, and lines that end with a carriage return alone get the
/// usual end.
///
/// # Errors
/// When the file cannot be read, is no text, or holds more than [`MOST_TEXT`] bytes.
pub fn read_text(path: &Path) -> Result<String, TextError> {
    read_text_within(path, MOST_TEXT)
}

/// The same of a file that may hold so many bytes, unpacked: a small archive may unpack without end.
///
/// # Errors
/// When the file cannot be read, is no text, or holds more.
pub fn read_text_within(path: &Path, most: u64) -> Result<String, TextError> {
    let bytes = read_at_most(plain_file::open(path)?, most)?;
    let bytes = if bytes.starts_with(&[0x1f, 0x8b]) {
        read_at_most(flate2::read::MultiGzDecoder::new(bytes.as_slice()), most)?
    } else {
        bytes
    };
    if bytes.contains(&0) {
        return Err(TextError::NotText);
    }
    // A header with an accented letter in an old code page does not spoil the numbers below it.
    let text = String::from_utf8(bytes).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned());
    let text = text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text);
    Ok(if text.contains('\n') { text } else { text.replace('\r', "\n") })
}

impl Table {
    /// Splits text into rows. Lines that are empty, hold separators alone or start with `#` are left out.
    ///
    /// The first line is a header when `is_header` says so of its fields; a line `sep=;` before it, as spreadsheets write and read it,
    /// names the separator.
    pub fn parse(text: &str, is_header: impl FnOnce(&[String]) -> bool) -> Table {
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(i, line)| (i + 1, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
            .peekable();
        let named =
            lines.next_if(|(_, line)| Separator::named(line).is_some()).and_then(|(_, line)| Separator::named(line));
        let first = lines.peek().map_or(Separator::Blank, |(_, line)| Separator::of(line));
        let separator = named.unwrap_or(first);
        // Spreadsheets end a table with rows of separators alone.
        let rows = lines.map(|(number, line)| (number, separator.split(line)));
        let mut rows = rows.filter(|(_, fields)| fields.iter().any(|field| !field.is_empty()));
        let Some(first) = rows.next() else {
            return Table { header: None, rows: Vec::new() };
        };
        if is_header(&first.1) {
            return Table { header: Some(first.1), rows: rows.collect() };
        }
        Table { header: None, rows: std::iter::once(first).chain(rows).collect() }
    }

    /// The rows with more fields than the header names, each with its line: as where decimal commas stand between commas. Empty
    /// fields at the end of a line do not count.
    pub fn overlong(&self) -> impl Iterator<Item = &(usize, Vec<String>)> {
        let columns = self.header.as_ref().map_or(usize::MAX, Vec::len);
        self.rows.iter().filter(move |(_, fields)| fields.iter().skip(columns).any(|field| !field.is_empty()))
    }

    /// Number of the column with one of these names, whatever their case; an earlier name wins.
    pub fn column(&self, names: &[&str]) -> Option<usize> {
        let header = self.header.as_ref()?;
        names.iter().find_map(|name| header.iter().position(|field| field.eq_ignore_ascii_case(name)))
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Separator {
    Character(char),
    Blank,
}

impl Separator {
    /// That of a line such as `sep=;`; a tabulator at the end of a line is lost with the blanks there.
    fn named(line: &str) -> Option<Self> {
        let name = line.trim_matches('"').strip_prefix("sep=").or_else(|| line.strip_prefix("SEP="))?;
        let mut characters = name.chars();
        let separator = characters.next().unwrap_or('\t');
        characters.next().is_none().then_some(Separator::Character(separator))
    }

    /// The first that divides a line; a lone tabulator may stand among blanks.
    fn of(line: &str) -> Self {
        [(';', 2), ('\t', 3), (',', 2)]
            .map(|(character, fields)| (Separator::Character(character), fields))
            .into_iter()
            .find(|(separator, fields)| separator.split(line).len() >= *fields)
            .map_or(Separator::Blank, |(separator, _)| separator)
    }

    /// The fields of a line; double quotes keep a separator inside a field, a doubled quote stands for one.
    fn split(self, line: &str) -> Vec<String> {
        let Separator::Character(separator) = self else {
            return line.split_whitespace().map(plain_name).collect();
        };
        let mut fields = vec![String::new()];
        let mut quoted = false;
        let mut characters = line.chars().peekable();
        while let Some(c) = characters.next() {
            let last = fields.len() - 1;
            if c == '"' && quoted && characters.peek() == Some(&'"') {
                characters.next();
                fields[last].push('"');
            } else if c == '"' {
                quoted = !quoted;
            } else if c == separator && !quoted {
                fields.push(String::new());
            } else {
                fields[last].push(c);
            }
        }
        // What this program wrote, too, is read as it was meant.
        fields.into_iter().map(|field| as_meant(&plain_name(field.trim())).to_string()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Vec<Vec<String>> {
        Table::parse(text, |_| false).rows.into_iter().map(|(_, fields)| fields).collect()
    }

    #[test]
    fn separators_are_found_and_quotes_kept_together() {
        assert_eq!(rows("1,2,3"), vec![vec!["1", "2", "3"]]);
        assert_eq!(rows("1; 2 ;3"), vec![vec!["1", "2", "3"]]);
        assert_eq!(rows("1   2\t3".replace('\t', " ").as_str()), vec![vec!["1", "2", "3"]]);
        assert_eq!(rows("A,\"x, \"\"y\"\"\",3"), vec![vec!["A", "x, \"y\"", "3"]]);
    }

    #[test]
    fn a_line_of_a_spreadsheet_names_the_separator() {
        for (text, expected) in [
            ("sep=;\n1;2,5", ["1", "2,5"]),
            ("\"sep=,\"\n1,2", ["1", "2"]),
            ("sep=\t\n1\t2", ["1", "2"]),
            ("SEP=|\n1|2", ["1", "2"]),
        ] {
            assert_eq!(rows(text), vec![expected.to_vec()], "{text:?}");
        }
        assert_eq!(rows("sep=ab\n1,2"), vec![vec!["sep=ab"], vec!["1,2"]]);
    }

    #[test]
    fn lines_end_as_on_any_machine() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        for end in ["\n", "\r\n", "\r"] {
            std::fs::write(&path, ["a,b", "1,2", "3,4", ""].join(end)).unwrap();
            let table = Table::parse(&read_text(&path).unwrap(), |_| true);
            assert_eq!(table.header, Some(vec!["a".to_owned(), "b".to_owned()]), "{end:?}");
            assert_eq!(
                table.rows,
                [(2, vec!["1".to_owned(), "2".to_owned()]), (3, vec!["3".to_owned(), "4".to_owned()])]
            );
        }
    }

    #[test]
    fn rows_of_separators_alone_are_left_out() {
        assert_eq!(rows("1;2\n;\n3;\n;;;\n"), vec![vec!["1", "2"], vec!["3", ""]]);
    }

    #[test]
    fn comments_are_left_out_and_lines_keep_their_numbers() {
        let table = Table::parse("# survey\nX,Y\n\n1,2\n", |fields| fields[0].parse::<f64>().is_err());
        assert_eq!(table.column(&["y"]), Some(1));
        assert_eq!(table.rows, vec![(4, vec!["1".to_string(), "2".to_string()])]);
    }
}
