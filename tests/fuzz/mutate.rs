//! Changes of texts and bytes: each takes what is sound and returns what hardly is.

use std::ops::Range;

use crate::random::Random;
use crate::words::{NUMBERS, OF_GEOJSON, SIGNS, UNITS, VALUES};

/// The longest runs of characters for which `is_part` holds, where the first of them fulfils `is_first`.
fn spans(text: &str, is_first: impl Fn(char) -> bool, is_part: impl Fn(char) -> bool) -> Vec<Range<usize>> {
    let (mut found, mut start): (Vec<Range<usize>>, Option<usize>) = (Vec::new(), None);
    for (at, c) in text.char_indices().chain([(text.len(), '\0')]) {
        match start {
            Some(from) if !is_part(c) => {
                found.push(from..at);
                start = None;
            }
            None if is_first(c) => start = Some(at),
            _ => {}
        }
    }
    found
}

fn numbers(text: &str) -> Vec<Range<usize>> {
    spans(text, |c| c.is_ascii_digit() || c == '-', |c| c.is_ascii_digit() || ".eE+-".contains(c))
}

fn words(text: &str) -> Vec<Range<usize>> {
    spans(text, |c| c.is_ascii_alphabetic() || c == '"', |c| c.is_ascii_alphanumeric() || "_./-\"".contains(c))
}

/// What stands between a colon and the end of its entry.
fn values(text: &str) -> Vec<Range<usize>> {
    let colons: Vec<usize> = text.match_indices(": ").map(|(at, _)| at + 2).collect();
    let length = |from: usize| text[from..].find([',', '{', '}', '[', ']', '\n']).unwrap_or(text.len() - from);
    colons.into_iter().map(|from| from..from + length(from)).filter(|value| !value.is_empty()).collect()
}

/// The words behind a number and a blank.
fn units(text: &str) -> Vec<Range<usize>> {
    let follows = |word: &Range<usize>| {
        let before = text[..word.start].strip_suffix(' ');
        before.is_some_and(|before| before.ends_with(|c: char| c.is_ascii_digit()))
    };
    words(text).into_iter().filter(follows).collect()
}

/// The text with another one in place of a part of it.
fn replaced(text: &str, part: Option<Range<usize>>, with: &str) -> String {
    part.map_or_else(|| text.to_owned(), |part| format!("{}{with}{}", &text[..part.start], &text[part.end..]))
}

fn one_of(random: &mut Random, spans: Vec<Range<usize>>) -> Option<Range<usize>> {
    let chosen = random.below(spans.len());
    spans.into_iter().nth(chosen)
}

/// A place in a text between two characters.
fn place(random: &mut Random, text: &str) -> usize {
    let mut at = random.below(text.len() + 1);
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// Some lines of a text that follow each other.
fn some_lines(random: &mut Random, text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let (from, count) = (random.below(lines.len()), 1 + random.below(4));
    lines.iter().skip(from).take(count).map(|line| format!("{line}\n")).collect()
}

/// The sections of a scenario: each a line that is not indented with those below it.
fn sections(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for line in text.lines() {
        match found.last_mut() {
            Some(section) if line.starts_with(' ') => *section += &format!("{line}\n"),
            _ => found.push(format!("{line}\n")),
        }
    }
    found
}

/// The scenario with a section of another one, in place of its own where it has one.
fn with_section_of(random: &mut Random, text: &str, other: &str) -> String {
    let others = sections(other);
    let given = &others[random.below(others.len())];
    let key = given.split(':').next().unwrap_or_default();
    let own = sections(text).into_iter().filter(|section| !section.starts_with(&format!("{key}:")));
    own.chain([given.clone()]).collect()
}

/// A scenario that is changed once or twice; `others` are those that parts are taken from.
pub fn scenario(random: &mut Random, text: &str, others: &[&str]) -> Vec<u8> {
    let mut text = text.to_owned();
    for _ in 0..1 + random.below(5) / 4 {
        text = changed_scenario(random, &text, others);
    }
    if random.happens(6) { bytes(random, text.as_bytes(), 0) } else { text.into_bytes() }
}

fn changed_scenario(random: &mut Random, text: &str, others: &[&str]) -> String {
    match random.below(100) {
        0..38 => replaced(text, one_of(random, numbers(text)), random.pick(NUMBERS)),
        38..44 => replaced(text, one_of(random, words(text)), random.pick(VALUES)),
        44..48 => replaced(text, one_of(random, values(text)), random.pick(VALUES)),
        48..54 => {
            let quantity = format!("{} {}", random.pick(NUMBERS), random.pick(UNITS));
            replaced(text, one_of(random, values(text)), &quantity)
        }
        54..62 => replaced(text, one_of(random, units(text)), random.pick(UNITS)),
        62..68 => {
            let lost = random.below(text.lines().count());
            text.lines().enumerate().filter(|(line, _)| *line != lost).map(|(_, line)| format!("{line}\n")).collect()
        }
        68..80 => {
            let from = if random.happens(40) { text } else { random.pick(others) };
            let (graft, at) = (some_lines(random, from), random.below(text.lines().count() + 1));
            let (mut before, mut after) = (String::new(), String::new());
            for (line, part) in text.lines().enumerate() {
                *(if line < at { &mut before } else { &mut after }) += &format!("{part}\n");
            }
            before + &graft + &after
        }
        80..90 => {
            let other = random.pick(others);
            with_section_of(random, text, other)
        }
        90..93 => text[..place(random, text)].to_owned(),
        93..97 => {
            let signs = spans(text, |c| "[]{}:,".contains(c), |_| false);
            replaced(text, one_of(random, signs), random.pick(SIGNS))
        }
        _ => repeated(random, text),
    }
}

/// A text with a part of it a few times, or very often.
fn repeated(random: &mut Random, text: &str) -> String {
    let (a, b) = (place(random, text), place(random, text));
    let part = a.min(b)..a.max(b).min(a.min(b) + 40);
    let part = part.start..(part.start..=part.end).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(part.start);
    let times = [2, 3, 50, 5000][random.below(4)];
    replaced(text, Some(part.clone()), &text[part].repeat(times))
}

/// A table, a grid or a vector file as text that is changed a few times.
pub fn table(random: &mut Random, content: &[u8]) -> Vec<u8> {
    let Ok(text) = std::str::from_utf8(content) else { return bytes(random, content, 0) };
    let mut text = text.to_owned();
    for _ in 0..[1, 1, 2, 4][random.below(4)] {
        text = match random.below(10) {
            0..5 => replaced(&text, one_of(random, numbers(&text)), random.pick(NUMBERS)),
            5 => replaced(&text, one_of(random, words(&text)), random.pick(VALUES)),
            6 => replaced(&text, one_of(random, words(&text)), random.pick(OF_GEOJSON)),
            7 => {
                let separators = spans(&text, |c| ",; \n[]".contains(c), |_| false);
                replaced(
                    &text,
                    one_of(random, separators),
                    random.pick(&["", ",", ";", "\t", "\r", "\n", "\"", "=", "\u{feff}"]),
                )
            }
            8 => repeated(random, &text),
            _ => text[..place(random, &text)].to_owned(),
        };
    }
    if random.happens(25) { bytes(random, text.as_bytes(), 0) } else { text.into_bytes() }
}

/// Bytes that are changed a few times; most changes are within the first `head`, where that is not 0.
pub fn bytes(random: &mut Random, content: &[u8], head: usize) -> Vec<u8> {
    let mut content = content.to_vec();
    for _ in 0..[1, 1, 2, 4, 16][random.below(5)] {
        if content.is_empty() {
            content.push(b'x');
        }
        let is_of_head = head > 0 && random.happens(60);
        let at = random.below(if is_of_head { content.len().min(head) } else { content.len() });
        let end = |length: usize| (at + length).min(content.len());
        match random.below(100) {
            0..30 => content[at] ^= 1 << random.below(8),
            30..45 => content[at] = [0, 1, 0x7f, 0x80, 0xff, b'\n', b'\r', b' ', b',', random.byte()][random.below(10)],
            45..60 => {
                let length = [2, 4, 8][random.below(3)];
                let (first, middle, last) =
                    [(0xff, 0xff, 0xff), (0, 0, 0), (0x7f, 0xff, 0xff), (0, 0, 0x80), (0xff, 0xff, 0x7f)]
                        [random.below(5)];
                let number: Vec<u8> = (0..length)
                    .map(|k| {
                        if k == 0 {
                            first
                        } else if k + 1 == length {
                            last
                        } else {
                            middle
                        }
                    })
                    .collect();
                content.splice(at..end(length), number);
            }
            60..67 => content.truncate(at),
            67..74 => drop(content.drain(at..end(1 + random.below(64)))),
            74..80 => {
                let part = content[at..end(1 + random.below(64))].repeat([1, 2, 20][random.below(3)]);
                content.splice(at..at, part);
            }
            _ => {
                let number = (random.number() as u32).to_le_bytes();
                content.splice(at..end(4), number);
            }
        }
    }
    content
}

#[test]
fn texts_are_taken_apart() {
    let text = "a: {b: 12 m, c: -1e3}\nd: [x.asc, 5 km]\n";
    let of = |spans: Vec<Range<usize>>| spans.into_iter().map(|span| &text[span]).collect::<Vec<_>>();
    assert_eq!(of(numbers(text)), ["12", "-1e3", "5"]);
    assert_eq!(of(units(text)), ["m", "km"]);
    assert_eq!(of(values(text)), ["12 m", "-1e3"]);
    assert_eq!(sections("a: 1\n  b: 2\nc: 3\n"), ["a: 1\n  b: 2\n", "c: 3\n"]);
    assert_eq!(replaced(text, Some(0..1), "z").len(), text.len());
}
