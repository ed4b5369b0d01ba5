//! Who set the ground of each place last: a layer of the terrain, a breakline, a building, the shore of still water.

use std::collections::BTreeSet;

/// Who sets the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetBy {
    /// A layer of the terrain, by its place in the list, from 0.
    Layer(usize),
    /// The fill of a hole of the terrain.
    FilledGap,
    /// A gap of a ridge that is narrower than a cell.
    RidgeGap,
    /// A building that is raised.
    RaisedBuilding,
    /// A building that is blocked: there is no terrain.
    BlockedBuilding,
    /// The dam that breaks, as it stands at the start.
    Dam,
    /// The shore of still water, fitted so that the stored volume is exact.
    Shore,
    /// The run that this one goes on from.
    EarlierRun,
    /// A breakline or a wall with a crest, by its place in the list of both, from 0.
    Breakline(usize),
}

/// Codes from which those of the layers and of the breaklines count, and the greatest of each: layers and lines beyond share it.
const LAYERS: [u8; 2] = [1, 99];
const BREAKLINES: [u8; 2] = [110, 254];
/// The others.
const OTHERS: [SetBy; 7] = [
    SetBy::FilledGap,
    SetBy::RidgeGap,
    SetBy::RaisedBuilding,
    SetBy::BlockedBuilding,
    SetBy::Dam,
    SetBy::Shore,
    SetBy::EarlierRun,
];
/// Colours of layers, and of breaklines, over and over again.
const COLOURS_OF_LAYERS: [[u8; 3]; 6] = [
    [0xd9, 0xcf, 0xb4],
    [0xb5, 0xc9, 0x9a],
    [0xa3, 0xb8, 0xc9],
    [0xd6, 0xb3, 0xa5],
    [0xc3, 0xb6, 0xd3],
    [0x9f, 0xc4, 0xb8],
];
const COLOURS_OF_BREAKLINES: [[u8; 3]; 4] =
    [[0xe4, 0x1a, 0x1c], [0xff, 0x7f, 0x00], [0xb1, 0x59, 0x28], [0xf7, 0x81, 0xbf]];

impl SetBy {
    /// Its value in the map, the same in all runs.
    pub fn code(self) -> u8 {
        let of = |[first, last]: [u8; 2], index: usize| first + index.min(usize::from(last - first)) as u8;
        match self {
            SetBy::Layer(index) => of(LAYERS, index),
            SetBy::Breakline(index) => of(BREAKLINES, index),
            SetBy::FilledGap => 100,
            SetBy::RidgeGap => 101,
            SetBy::RaisedBuilding => 102,
            SetBy::BlockedBuilding => 103,
            SetBy::Dam => 104,
            SetBy::Shore => 105,
            SetBy::EarlierRun => 106,
        }
    }

    /// Whether others of its kind beyond it share its code.
    pub fn is_last_of_its_kind(self) -> bool {
        self.code() == LAYERS[1] || self.code() == BREAKLINES[1]
    }

    /// Whether a code is that of something built or fitted, and not of a layer of the terrain.
    pub fn is_built(code: u8) -> bool {
        code > LAYERS[1]
    }

    fn of_code(code: u8) -> Option<SetBy> {
        let index = |[first, last]: [u8; 2]| (first..=last).contains(&code).then(|| usize::from(code - first));
        let other = || OTHERS.into_iter().find(|other| other.code() == code);
        index(LAYERS).map(SetBy::Layer).or_else(|| index(BREAKLINES).map(SetBy::Breakline)).or_else(other)
    }

    /// Its name, one word.
    fn name(self) -> String {
        match self {
            SetBy::Layer(index) => format!("layer_{}", index + 1),
            SetBy::FilledGap => "filled_gap".into(),
            SetBy::RidgeGap => "gap_in_ridge".into(),
            SetBy::RaisedBuilding => "raised_building".into(),
            SetBy::BlockedBuilding => "blocked_building".into(),
            SetBy::Dam => "dam".into(),
            SetBy::Shore => "shore_fit".into(),
            SetBy::EarlierRun => "earlier_run".into(),
            SetBy::Breakline(index) => format!("breakline_{}", index + 1),
        }
    }

    fn colour(self) -> [u8; 3] {
        match self {
            SetBy::Layer(index) => COLOURS_OF_LAYERS[index % COLOURS_OF_LAYERS.len()],
            SetBy::FilledGap => [0xff, 0xe6, 0x3b],
            SetBy::RidgeGap => [0x00, 0xa0, 0x87],
            SetBy::RaisedBuilding => [0x80, 0x80, 0x80],
            SetBy::BlockedBuilding => [0x40, 0x40, 0x40],
            SetBy::Dam => [0x98, 0x4e, 0xa3],
            SetBy::Shore => [0x37, 0x7e, 0xb8],
            SetBy::EarlierRun => [0x7f, 0xcd, 0xee],
            SetBy::Breakline(index) => COLOURS_OF_BREAKLINES[index % COLOURS_OF_BREAKLINES.len()],
        }
    }
}

/// One of those who set the ground, as the legend has it.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct SourceClass {
    /// Its value in the map.
    pub code: u8,
    /// Its name, one word.
    pub name: String,
    /// What it is in words, with the name of its file.
    pub label: String,
    /// Its colour, red green blue.
    pub colour: [u8; 3],
}

/// The ground of a run by those who set it last; code 0 where there is no terrain and none was blocked.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GroundSource {
    /// Code of each cell of the lattice.
    pub of_cells: Vec<u8>,
    /// Code of each pixel of the maps, row 0 in the north, where the maps are on the terrain's own raster; empty otherwise.
    pub of_pixels: Vec<u8>,
    /// Those among them, ascending by their codes.
    pub classes: Vec<SourceClass>,
}

/// The map of the ground's sources on the output grid.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SourceGrid {
    /// Codes, row 0 in the north; [`FILL`](super::FILL) where nobody set the ground. Empty where the map is not asked for.
    pub codes: Vec<f32>,
    /// Those that it shows, ascending by their codes.
    pub classes: Vec<SourceClass>,
}

impl GroundSource {
    /// - `label`: what a source is in words
    pub fn new(of_cells: Vec<u8>, of_pixels: Vec<u8>, label: impl Fn(SetBy) -> String) -> GroundSource {
        let codes: BTreeSet<u8> = of_cells.iter().chain(&of_pixels).copied().collect();
        let of_code = |code: u8| {
            let source = SetBy::of_code(code)?;
            Some(SourceClass { code, name: source.name(), label: label(source), colour: source.colour() })
        };
        GroundSource { of_cells, of_pixels, classes: codes.into_iter().filter_map(of_code).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_lead_back_to_their_sources() {
        let found: Vec<u8> = (0..=255).filter_map(|code| SetBy::of_code(code).map(SetBy::code)).collect();
        let expected: Vec<u8> = (1..=106).chain(110..=254).collect();
        assert_eq!(found, expected);
        assert_eq!(
            (SetBy::Layer(500).code(), SetBy::Breakline(500).code()),
            (99, 254),
            "beyond the last they share it"
        );
        let names: BTreeSet<String> =
            expected.iter().filter_map(|code| SetBy::of_code(*code)).map(SetBy::name).collect();
        assert_eq!(names.len(), expected.len());
    }
}
