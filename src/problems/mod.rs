//! All problems that the program reports, in one registry: code, severity, meaning and remedy.
//!
//! `floodsim explain` and `docs/problems.md` are made from it. `tests/problems.rs` checks that it has every code of the sources and
//! no other, and that a test provokes each of them. Not here: message, place and cause of a finding, which stand where it is found.

mod breach;
mod channels;
mod earlier_run;
mod files;
mod inflow;
mod limits;
mod outputs;
mod scenario_file;
mod studies;
mod tables;
mod terrain;
mod water;

/// As what a problem is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reported {
    /// The run is refused.
    Error,
    /// The run goes on; the planner should know.
    Warning,
    /// An error or a warning, as the meaning says.
    Either,
}

impl Reported {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Reported::Error => "error",
            Reported::Warning => "warning",
            Reported::Either => "error or warning",
        }
    }
}

/// A problem that the program knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownProblem {
    /// The name by which tests and scripts know it, such as `unknown-key`.
    pub code: &'static str,
    /// As what it is reported.
    pub severity: Reported,
    /// What is wrong and why it matters to a planner: one or two sentences.
    pub meaning: &'static str,
    /// What to do: one sentence.
    pub remedy: &'static str,
}

impl KnownProblem {
    /// The first sentence of the meaning.
    pub fn summary(&self) -> &'static str {
        self.meaning.find(". ").map_or(self.meaning, |end| &self.meaning[..=end])
    }
}

/// Problems of one subject.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// The subject.
    pub title: &'static str,
    /// Its problems, sorted by code.
    pub problems: &'static [KnownProblem],
}

/// The groups, in the order of a scenario.
pub const GROUPS: [Group; 12] = [
    scenario_file::GROUP,
    files::GROUP,
    tables::GROUP,
    terrain::GROUP,
    water::GROUP,
    inflow::GROUP,
    breach::GROUP,
    channels::GROUP,
    outputs::GROUP,
    earlier_run::GROUP,
    limits::GROUP,
    studies::GROUP,
];

const fn error(code: &'static str, meaning: &'static str, remedy: &'static str) -> KnownProblem {
    KnownProblem { code, severity: Reported::Error, meaning, remedy }
}

const fn warning(code: &'static str, meaning: &'static str, remedy: &'static str) -> KnownProblem {
    KnownProblem { code, severity: Reported::Warning, meaning, remedy }
}

const fn either(code: &'static str, meaning: &'static str, remedy: &'static str) -> KnownProblem {
    KnownProblem { code, severity: Reported::Either, meaning, remedy }
}

/// All problems, sorted by code.
pub fn all() -> impl Iterator<Item = &'static KnownProblem> {
    let mut sorted: Vec<&'static KnownProblem> = GROUPS.iter().flat_map(|group| group.problems).collect();
    sorted.sort_by_key(|problem| problem.code);
    sorted.into_iter()
}

/// The problem of a code; none where the code is not known.
pub fn find(code: &str) -> Option<&'static KnownProblem> {
    GROUPS.iter().flat_map(|group| group.problems).find(|problem| problem.code == code)
}

/// The document `docs/problems.md`: a table for each group.
pub fn markdown() -> String {
    let row = |problem: &KnownProblem| {
        let KnownProblem { code, severity, meaning, remedy } = problem;
        format!("| `{code}` | {} | {meaning} | {remedy} |\n", severity.name())
    };
    let table = |group: &Group| {
        let rows: String = group.problems.iter().map(row).collect();
        format!("\n## {}\n\n| code | severity | meaning | remedy |\n| --- | --- | --- | --- |\n{rows}", group.title)
    };
    let begin = "\
# Problems

All problems that `floodsim check` and a run report, by their codes. An error stops the run before its first step; with a warning it
goes on. Message, place and cause of a finding come with it; `floodsim explain CODE` prints what stands here.

This file is made by `floodsim explain --markdown > docs/problems.md`.
";
    format!("{begin}{}", GROUPS.iter().map(table).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(sentence: &str) -> usize {
        sentence.split_whitespace().count()
    }

    fn sentences(text: &str) -> Vec<&str> {
        text.split_inclusive(". ").collect()
    }

    #[test]
    fn each_code_stands_once_and_in_order() {
        let is_letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        for group in GROUPS {
            assert!(group.problems.iter().all(|problem| problem.code.chars().all(is_letter)), "{}", group.title);
            assert!(group.problems.is_sorted_by(|a, b| a.code < b.code), "{} is not sorted by code", group.title);
        }
        let codes: Vec<&str> = all().map(|problem| problem.code).collect();
        let twice: Vec<&[&str]> = codes.windows(2).filter(|pair| pair[0] >= pair[1]).collect();
        assert!(twice.is_empty(), "{twice:?}");
        assert!(codes.iter().all(|code| find(code).is_some_and(|found| found.code == *code)));
        assert_eq!(find("no-such-code"), None);
    }

    #[test]
    fn each_text_is_short() {
        for KnownProblem { code, meaning, remedy, .. } in all() {
            assert!(sentences(meaning).len() <= 2 && sentences(remedy).len() == 1, "{code}: too many sentences");
            for sentence in sentences(meaning).into_iter().chain([*remedy]) {
                assert!(words(sentence) <= 25, "{code}: more than 25 words in `{sentence}`");
            }
            for text in [meaning, remedy] {
                assert!(text.ends_with('.') && !text.contains('|'), "{code}: `{text}`");
                assert!(text.starts_with(|c: char| c.is_uppercase() || c == '`'), "{code}: `{text}`");
            }
        }
    }

    #[test]
    fn the_document_is_made_from_this_registry() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/problems.md");
        let written = std::fs::read_to_string(file).unwrap_or_default();
        assert!(written == markdown(), "make it anew: `floodsim explain --markdown > docs/problems.md`");
    }
}
