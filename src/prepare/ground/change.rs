//! Changes of the ground: of the bed of a cell, and of the terrain in it, so that what is filled to a level knows of it, too.

use std::collections::BTreeMap;

use crate::bed::{CellPlane, Pixels, Surface};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::output::SetBy;
use crate::terrain::{Piece, PixelBlock, PixelGrid, Terrain};

/// What a change makes of an elevation (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Made {
    /// Where there is no terrain it has this elevation.
    Fill(f64),
    /// Nothing lies lower.
    Raise(f64),
    /// Nothing lies higher.
    Carve(f64),
    /// All lies higher by so much.
    Lift(f64),
    /// There is no terrain, and no boundary opens its edge.
    Block,
    /// The bed lies there, whatever the terrain in the cell.
    Bed(f64),
    /// In the terrain in the cell nothing lies lower; the bed stays.
    RaiseTerrain(f64),
    /// The bed has this roughness n (s·m^(−1/3)).
    Roughness(f64),
}

impl Made {
    /// Whether it changes the bed of its cell, the terrain in it.
    pub fn is_of(self) -> (bool, bool) {
        match self {
            Made::Fill(_) | Made::Raise(_) | Made::Carve(_) | Made::Lift(_) | Made::Block => (true, true),
            Made::Bed(_) => (true, false),
            Made::RaiseTerrain(_) => (false, true),
            Made::Roughness(_) => (false, false),
        }
    }

    /// What becomes of an elevation (m); none where there is no terrain.
    pub fn of(self, elevation: Option<f64>) -> Option<f64> {
        match self {
            Made::Fill(level) => elevation.or(Some(level)),
            Made::Raise(level) | Made::RaiseTerrain(level) => elevation.map(|z| z.max(level)),
            Made::Carve(level) => elevation.map(|z| z.min(level)),
            Made::Lift(height) => elevation.map(|z| z + height),
            Made::Block => None,
            Made::Bed(level) => Some(level),
            Made::Roughness(_) => elevation,
        }
    }
}

/// A change of the ground in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The cell.
    pub cell: usize,
    /// What becomes of its ground.
    pub made: Made,
    /// Who makes it.
    pub by: SetBy,
}

/// A change (m) that makes somebody the source of the ground: what is less is the difference between two means of the same terrain.
const NOTEWORTHY: f64 = 1e-3;

/// Whether a change from one elevation (m) to another makes a new source.
pub fn is_noteworthy(before: Option<f64>, after: Option<f64>) -> bool {
    match (before, after) {
        (Some(before), Some(after)) => (after - before).abs() >= NOTEWORTHY,
        (before, after) => before.is_some() != after.is_some(),
    }
}

/// What changed the terrain in each cell, by whom, in the order of the changes.
#[derive(Clone, Debug, Default)]
pub struct Changes(BTreeMap<usize, Vec<(Made, SetBy)>>);

impl Changes {
    /// Takes note of a change.
    pub fn note(&mut self, Change { cell, made, by }: Change) {
        self.0.entry(cell).or_default().push((made, by));
    }

    /// Whether a cell that has terrain is raised, carved or lifted.
    pub fn moves(&self, cell: usize) -> bool {
        self.raises(cell)
            || self.0.get(&cell).is_some_and(|made| made.iter().any(|(made, _)| matches!(made, Made::Carve(_))))
    }

    /// Whether a cell is raised or lifted: a dam, a levee, a building that stands in the water.
    pub fn raises(&self, cell: usize) -> bool {
        let raises = |(made, _): &(Made, SetBy)| matches!(made, Made::Raise(_) | Made::Lift(_) | Made::RaiseTerrain(_));
        self.0.get(&cell).is_some_and(|made| made.iter().any(raises))
    }

    /// All cells that are raised or lifted, ascending.
    pub fn raised(&self) -> impl Iterator<Item = usize> {
        self.0.keys().copied().filter(|&cell| self.raises(cell))
    }

    /// The terrain with these changes.
    pub fn on<'a>(&'a self, terrain: &'a Terrain, lattice: &'a Lattice) -> Shaped<'a> {
        Shaped { terrain, lattice, changes: self, is_blocked: true }
    }
}

/// A terrain with changes.
pub struct Shaped<'a> {
    terrain: &'a Terrain,
    lattice: &'a Lattice,
    changes: &'a Changes,
    /// Whether blocked cells have no terrain.
    is_blocked: bool,
}

impl Shaped<'_> {
    /// The same with the terrain that blocked buildings stand on.
    pub fn beside_buildings(self) -> Self {
        Shaped { is_blocked: false, ..self }
    }

    /// What changed the terrain at a place (map coordinates), in order.
    fn changes_at(&self, place: Vec2) -> impl Iterator<Item = &(Made, SetBy)> {
        let cell = if self.changes.0.is_empty() { None } else { self.lattice.cell_at(self.lattice.to_local(place)) };
        let all = cell.and_then(|cell| self.changes.0.get(&cell)).map_or(&[][..], Vec::as_slice);
        all.iter().filter(|(made, _)| self.is_blocked || *made != Made::Block)
    }

    /// What the changes make of an elevation (m) at a place (map coordinates).
    pub fn changed(&self, place: Vec2, elevation: Option<f64>) -> Option<f64> {
        self.changes_at(place).fold(elevation, |elevation, (made, _)| made.of(elevation))
    }

    /// The same with who set it last, if `source` gave it before the changes.
    pub fn changed_by(
        &self,
        place: Vec2,
        elevation: Option<f64>,
        source: Option<SetBy>,
    ) -> (Option<f64>, Option<SetBy>) {
        self.changes_at(place).fold((elevation, source), |(before, source), (made, by)| {
            let after = made.of(before);
            (after, if is_noteworthy(before, after) { Some(*by) } else { source })
        })
    }
}

impl Surface for Shaped<'_> {
    fn elevation(&self, map: Vec2) -> Option<f64> {
        self.changed(map, self.terrain.elevation(map))
    }

    fn mean_preserving_elevation(&self, map: Vec2, spacing: f64) -> Option<f64> {
        self.changed(map, self.terrain.mean_preserving_elevation(map, spacing))
    }

    fn plane_of_cell(&self, centre: Vec2, spacing: f64) -> Option<CellPlane> {
        let changes = &self.changes.0;
        let is_as_it_was = |cell: &usize| changes.is_empty() || !changes.contains_key(cell);
        self.lattice.cell_at(self.lattice.to_local(centre)).filter(is_as_it_was)?;
        Surface::plane_of_cell(self.terrain, centre, spacing)
    }

    fn samples(&self, centre: Vec2, radius: f64, out: &mut Vec<(Vec2, f64)>) {
        let first = out.len();
        self.terrain.samples(centre, radius, out);
        let own: Vec<(Vec2, f64)> = out.drain(first..).collect();
        out.extend(own.into_iter().filter_map(|(place, z)| Some((place, self.changed(place, Some(z))?))));
    }

    fn pieces(&self, centre: Vec2, width: f64, with_surroundings: bool, pieces: &mut Vec<Piece>) {
        self.terrain.pieces(centre, width, with_surroundings, pieces);
        pieces.retain_mut(|piece| {
            let changed = self.changed(centre + piece.offset, Some(piece.elevation));
            piece.elevation = changed.unwrap_or(piece.elevation);
            changed.is_some()
        });
    }

    fn has_pixels(&self, map: Vec2, spacing: f64) -> bool {
        self.terrain.has_pixels(map, spacing)
    }
}

impl Pixels for Shaped<'_> {
    fn grid(&self, low: Vec2, high: Vec2, spacing: f64) -> Option<PixelGrid> {
        self.terrain.pixel_grid(low, high, spacing)
    }

    fn read(&self, grid: &PixelGrid, block: &PixelBlock, cell: usize, out: &mut Vec<f64>) {
        let first = out.len();
        self.terrain.read(grid, block, cell, out);
        if let Some(changes) = self.changes.0.get(&cell) {
            for z in &mut out[first..] {
                let own = Some(*z).filter(|z| !z.is_nan());
                *z = changes.iter().fold(own, |z, (made, _)| made.of(z)).unwrap_or(f64::NAN);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::{Layer, Raster};

    #[test]
    fn changes_hold_in_their_cell_and_in_their_order() {
        let mut values = vec![3.0; 25];
        values[12] = f64::NAN;
        let raster = Raster { columns: 5, rows: 5, west: 0.0, north: 10.0, cell_x: 2.0, cell_y: 2.0, values };
        let terrain = Terrain::new(vec![Layer::Raster(raster)]).unwrap();
        let lattice = Lattice::new(Vec2::ZERO, 5, 5, 2.0);
        let mut changes = Changes::default();
        let made = [
            (12, Made::Fill(2.5)),
            (3, Made::Fill(9.0)),
            (4, Made::Raise(5.0)),
            (4, Made::Lift(0.5)),
            (5, Made::Lift(0.5)),
            (5, Made::Carve(1.0)),
            (6, Made::Carve(4.0)),
            (7, Made::Block),
        ];
        made.into_iter().for_each(|(cell, made)| changes.note(Change { cell, made, by: SetBy::Dam }));
        assert_eq!(changes.raised().collect::<Vec<_>>(), [4, 5], "raised or lifted");
        let surface = changes.on(&terrain, &lattice);
        for (cell, expected) in
            [(12, Some(2.5)), (3, Some(3.0)), (4, Some(5.5)), (5, Some(1.0)), (6, Some(3.0)), (7, None), (8, Some(3.0))]
        {
            let place = lattice.to_map(lattice.centre(cell)) + Vec2::new(0.7, -0.9);
            let found = surface.elevation(place);
            // The terrain itself is level to rounding between its cells.
            assert!(found.is_some() == expected.is_some(), "cell {cell}");
            assert!((found.unwrap_or(0.0) - expected.unwrap_or(0.0)).abs() < 1e-12, "cell {cell}: {found:?}");
        }
        // The same of the pixels of a cell.
        let read = |cell: usize| {
            let half = Vec2::new(1.0, 1.0);
            let centre = lattice.to_map(lattice.centre(cell));
            let grid = surface.grid(centre - half, centre + half, 4.0).unwrap();
            let mut pixels = Vec::new();
            surface.read(&grid, &grid.block(centre - half, centre + half), cell, &mut pixels);
            pixels
        };
        assert_eq!([read(12), read(4), read(5), read(6), read(8)], [[2.5], [5.5], [1.0], [3.0], [3.0]]);
        assert!(read(7)[0].is_nan());
        let mut samples = Vec::new();
        surface.samples(Vec2::new(9.0, 1.0), 2.5, &mut samples);
        assert_eq!(samples.iter().map(|sample| sample.1).collect::<Vec<_>>(), [3.0, 3.0, 5.5]);
        let mut pieces = Vec::new();
        surface.pieces(Vec2::new(7.0, 3.0), 6.0, false, &mut pieces);
        let elevations: Vec<f64> = pieces.iter().map(|piece| piece.elevation).collect();
        assert_eq!(elevations, [3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 5.5], "from the north; none in cells 7 and 12");
    }
}
