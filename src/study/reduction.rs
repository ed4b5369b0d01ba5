//! What a reduction begins with, and what comes of it.

use std::path::PathBuf;

use serde::Serialize;

use super::record::StudyRecord;
use super::stack::Stack;
use super::statistics::PlaceStatistic;
use crate::output::OutputCrs;
use crate::results::Results;

/// The runs of one variant, or the pairs of two.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// Its name, that of its folder; empty where the study has one variant alone.
    pub name: String,
    /// Numbers of its members, or of those of the first variant of the pairs.
    pub members: Vec<usize>,
    /// Flooded area, gauges and cross-sections.
    pub places: Vec<PlaceStatistic>,
    /// The folder with its files.
    pub folder: PathBuf,
}

/// A study, reduced.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reduction {
    /// Title of the study.
    pub title: String,
    /// How many members it has.
    pub members: usize,
    /// Members that are left out, and why.
    pub left_out: Vec<(usize, String)>,
    /// What the members do not share though they should: versions of the program, inputs.
    pub doubts: Vec<String>,
    /// The depth (m) from which on a cell counts as flooded.
    pub flooded_from_m: f64,
    /// The groups.
    pub groups: Vec<Group>,
}

/// What a reduction works with.
pub(super) struct Sources<'a> {
    pub study: &'a StudyRecord,
    pub stack: Stack,
    /// Index of the member of each run of the stack in the record.
    pub members: Vec<usize>,
    pub first: Results,
    pub crs: OutputCrs,
    pub flooded_from: f64,
    pub left_out: Vec<(usize, String)>,
    pub doubts: Vec<String>,
}

impl Sources<'_> {
    /// The title of a group.
    pub fn title(&self, group: &Group) -> String {
        if group.name.is_empty() {
            self.study.title.clone()
        } else {
            format!("{}: {}", self.study.title, group.name.replace('_', " "))
        }
    }
}
