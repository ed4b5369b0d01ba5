//! What all pages share: their head, tables of names and values, tables with columns.

use std::fmt::Write;

use crate::maps::{clock, escape};

const STYLE: &str = "body{font:15px/1.45 'DejaVu Sans','Liberation Sans',Arial,sans-serif;color:#222;max-width:1240px;margin:2em auto;padding:0 1em}\
h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2em;border-bottom:1px solid #ccc}\
table{border-collapse:collapse;margin:.6em 0}td,th{padding:.25em .8em;border-bottom:1px solid #ddd;text-align:left;vertical-align:top}\
th{background:#f3f3f1;font-weight:600}td.n{text-align:right;font-variant-numeric:tabular-nums}\
figure{margin:1em 0}svg{max-width:100%;height:auto}.scroll{overflow-x:auto}\
.status{padding:.5em .8em;background:#eef3ea;border-left:4px solid #5a8f3c}.status.bad{background:#f8ebe8;border-color:#b4432e}\
@media print{figure{break-inside:avoid}}";

/// The beginning of a page, up to its heading.
pub(crate) fn begin(title: &str) -> String {
    let title = escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><style>{STYLE}</style></head><body>\n<h1>{title}</h1>\n"
    )
}

/// The end of a page.
pub(crate) const END: &str = "</body></html>\n";

/// Whether what the page shows can be relied on: lines of text, the first in bold.
pub(crate) fn status(html: &mut String, is_good: bool, lines: &[String]) {
    let class = if is_good { "status" } else { "status bad" };
    let _ = write!(html, "<p class=\"{class}\">");
    for (number, line) in lines.iter().map(|line| escape(line)).enumerate() {
        let _ = if number == 0 { write!(html, "<b>{line}</b>") } else { write!(html, "<br>{line}") };
    }
    html.push_str("</p>\n");
}

/// A picture with its heading.
pub(crate) fn figure(html: &mut String, caption: &str, svg: &str) {
    let _ = write!(html, "<h2>{}</h2>\n<figure>{svg}</figure>\n", escape(caption));
}

/// A table of names and values; nothing where there are none.
pub(crate) fn table(html: &mut String, heading: &str, rows: &[(String, String)]) {
    if rows.is_empty() {
        return;
    }
    let _ = writeln!(html, "<h2>{heading}</h2>\n<table>");
    for (name, value) in rows {
        let _ = writeln!(html, "<tr><th>{}</th><td>{}</td></tr>", escape(name), escape(value));
    }
    html.push_str("</table>\n");
}

/// A table as it is; numbers to the right, arrival also in minutes. Nothing where it has no rows.
pub(crate) fn records(html: &mut String, title: &str, columns: &[String], rows: &[&[String]]) {
    if rows.is_empty() {
        return;
    }
    let _ = write!(html, "<h2>{title}</h2>\n<div class=\"scroll\"><table><tr>");
    for column in columns {
        let _ = write!(html, "<th>{}</th>", escape(column));
    }
    html.push_str("</tr>\n");
    for row in rows {
        html.push_str("<tr>");
        for (column, cell) in columns.iter().zip(*row) {
            let number = cell.parse::<f64>().ok();
            let class = if number.is_some() { " class=\"n\"" } else { "" };
            let minutes = match number {
                Some(seconds) if column == "arrival_s" && seconds >= 60.0 => format!(" ({})", clock(seconds)),
                _ => String::new(),
            };
            let _ = write!(html, "<td{class}>{}{minutes}</td>", escape(cell));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</table></div>\n");
}
