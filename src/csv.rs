//! Text in fields of CSV that spreadsheets take for a formula, and how it is kept from being one.
//!
//! A spreadsheet computes what begins with `=`, `+`, `-` or `@`, and a formula may run a program or send data away. The usual cure is an
//! apostrophe before it, which spreadsheets show; the readers of this program take it off again. Numbers stay as they are.

/// A text that no spreadsheet computes.
pub fn inert(text: &str) -> String {
    if begins_formula(text) { format!("'{text}") } else { text.to_owned() }
}

/// A text as a field of a table: inert, and in quotes where it has what parts fields or lines.
pub fn field(text: &str) -> String {
    let text = inert(text);
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

/// The text that was made inert; another one as it stands.
pub fn as_meant(text: &str) -> &str {
    text.strip_prefix('\'').filter(|rest| begins_formula(rest)).unwrap_or(text)
}

/// Whether an apostrophe stands, or is to stand, before a text; also where it has one already, so that it comes back as it was.
fn begins_formula(text: &str) -> bool {
    let first = text.trim_start_matches('\'');
    first.starts_with(['=', '+', '-', '@', '\t', '\r']) && first.parse::<f64>().is_err()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_are_made_inert_and_come_back() {
        for text in
            ["=1+1", "+cmd|' /C calc'!A0", "-a", "@SUM(A1)", "'=1", "''=1", "mill", "'old' mill", "-5", "+3e2", "", "'"]
        {
            let written = inert(text);
            assert!(!written.starts_with(['=', '@']), "{written}");
            assert_eq!(as_meant(&written), text);
        }
        assert_eq!((inert("=1").as_str(), inert("-5").as_str()), ("'=1", "-5"));
    }
}
