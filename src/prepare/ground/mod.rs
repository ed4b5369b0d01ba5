//! The ground of a run: its terrain, and all that is built into it.
//!
//! Whatever shapes the ground says which cells it changes, what becomes of them and who it is ([`Change`]). [`Ground::take`] alone takes
//! changes over, in this order:
//!
//! 1. the layers of the terrain: the bed is their mean in each cell ([`Ground::of_layers`]),
//! 2. the fill of holes ([`gaps`]),
//! 3. the ground in gaps of ridges that are narrower than a cell ([`ridges`]),
//! 4. the roughness ([`roughness`]),
//! 5. breaklines and walls with a crest, in the order of the scenario ([`breaklines`]),
//! 6. buildings ([`buildings`]),
//! 7. the dam, as it stands at the start ([`super::breach`]),
//! 8. the shore of still water, body by body ([`super::water`]),
//! 9. the bed under the water of an earlier run ([`super::earlier`]).
//!
//! What follows from the ground is found between 7 and 8: pass sills and cells in part. A dam that breaks and a bed that moves change the
//! ground during the run (`solver/changing_bed`).

mod blocked;
mod breaklines;
mod buildings;
pub mod burn;
mod change;
mod cover;
pub mod crests;
mod fine_maps;
pub mod gaps;
pub mod layers;
mod outlines;
mod ridges;
mod roughness;
mod source;
mod steps;
pub mod wall_ends;
pub mod wall_gaps;

use super::findings::Findings;
use crate::bed::{BedParticles, LeftOut, place_bed_with};
use crate::constants::SeedingConstants;
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::output::SetBy;
use crate::partition::Line;
use crate::scenario::Scenario;
use crate::terrain::Terrain;
use change::is_noteworthy;
pub use change::{Change, Changes, Made, Shaped};
pub use fine_maps::{BYTES_PER_PIXEL, pixels};
pub use source::sources;

/// What to do about some lines or buildings beside the terrain, among others on it.
const CHECK_PLACES: &str =
    "nothing, if the file is meant to reach further than the terrain; otherwise correct their coordinates";

/// The files of all that is built into the terrain.
pub struct Opened {
    rough: roughness::Opened,
    breaklines: Vec<Vec<breaklines::Line>>,
    buildings: buildings::Footprints,
}

/// Opens the files of roughness, breaklines and buildings.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Opened {
    Opened {
        rough: roughness::open(scenario, crs, findings),
        breaklines: breaklines::open(scenario, crs, findings),
        buildings: buildings::open(scenario, crs, findings),
    }
}

/// The outlines of blocked buildings as lines of a lattice, each building with its courtyards.
pub fn outlines(opened: &Opened, scenario: &Scenario, lattice: &Lattice) -> Vec<Vec<Line>> {
    outlines::outlines(buildings::blocked(&opened.buildings, scenario), lattice)
}

/// The ground with all that is built into it but for the dam: steps 1 to 6.
pub fn build<'a>(
    scenario: &Scenario,
    (terrain, lattice): (&'a Terrain, &Lattice),
    opened: &Opened,
    findings: &mut Findings,
) -> Ground<'a> {
    let blocked = blocked::Blocked::new(buildings::blocked(&opened.buildings, scenario), terrain, lattice);
    let mut ground = Ground::of_layers(scenario, terrain, lattice, &blocked);
    steps::check(scenario, terrain, (ground.bed(), &blocked), findings);
    ground.take(gaps::fill(scenario, ground.bed(), findings));
    gaps::check_seams(scenario, ground.bed(), findings);
    ground.take(ridges::lower_gaps(scenario, &ground));
    ground.bed.manning =
        roughness::on_lattice(&opened.rough, &scenario.roughness, lattice, &ground.bed.elevation, findings);
    breaklines::shape(&opened.breaklines, scenario, &mut ground, findings);
    buildings::shape(&opened.buildings, scenario, &mut ground, findings);
    ground
}

/// The ground while it is shaped: the bed, what changed the terrain in the cells, and who set the bed of each cell last.
#[derive(Clone)]
pub struct Ground<'a> {
    terrain: &'a Terrain,
    bed: BedParticles,
    /// The constants by which still water shapes its shore.
    seeding: SeedingConstants,
    changes: Changes,
    /// Code of [`SetBy`]; 0 where there is no terrain.
    set_by: Vec<u8>,
}

impl<'a> Ground<'a> {
    /// The ground of the layers alone.
    fn of_layers(scenario: &Scenario, terrain: &'a Terrain, lattice: &Lattice, blocked: &impl LeftOut) -> Ground<'a> {
        let manning = scenario.roughness.elsewhere().unwrap_or(0.0);
        let method = (scenario.numerics.bed, &scenario.numerics.constants.bed);
        let bed = place_bed_with(terrain, lattice, method, blocked, manning);
        let set_by = source::layers(terrain, &bed);
        Ground { terrain, bed, seeding: scenario.numerics.constants.seeding, changes: Changes::default(), set_by }
    }

    /// The layers alone.
    pub fn terrain(&self) -> &Terrain {
        self.terrain
    }

    /// The bed.
    pub fn bed(&self) -> &BedParticles {
        &self.bed
    }

    /// The terrain with what changed it.
    pub fn surface(&self) -> Shaped<'_> {
        self.changes.on(self.terrain, &self.bed.lattice)
    }

    /// The same with the terrain on which blocked buildings stand: the squares that they take reach beyond them.
    pub fn surface_beside_buildings(&self) -> Shaped<'_> {
        self.surface().beside_buildings()
    }

    /// The constants by which still water shapes its shore.
    pub fn seeding(&self) -> &SeedingConstants {
        &self.seeding
    }

    /// What changed the terrain.
    pub fn changes(&self) -> &Changes {
        &self.changes
    }

    /// Takes over changes, in their order. Nothing else changes the elevation of the bed.
    pub fn take(&mut self, changes: impl IntoIterator<Item = Change>) {
        for change in changes {
            let Change { cell, made, by } = change;
            let (is_of_bed, is_of_terrain) = made.is_of();
            if is_of_terrain {
                self.changes.note(change);
            }
            if is_of_bed {
                let before = Some(self.bed.elevation[cell]).filter(|z| !z.is_nan());
                let after = made.of(before);
                self.bed.elevation[cell] = after.unwrap_or(f64::NAN);
                if is_noteworthy(before, after) {
                    self.set_by[cell] = by.code();
                }
            }
            match made {
                Made::Block => self.bed.sealed.push(cell),
                Made::Roughness(n) => self.bed.manning[cell] = n,
                _ => {}
            }
        }
    }

    /// Takes over beds (m) of cells that one of the shapers sets.
    pub fn take_beds(&mut self, beds: &[(usize, f64)], by: SetBy) {
        self.take(beds.iter().map(|&(cell, z_b)| Change { cell, made: Made::Bed(z_b), by }));
    }

    /// Finds what follows from the ground: pass sills and cells in part.
    pub fn find_passes_and_cover(&mut self, scenario: &Scenario) {
        let passes = ridges::find(scenario, &self.surface(), &self.bed);
        self.bed.passes = passes;
        let cover = cover::find(scenario, self.terrain, &self.surface(), &self.bed);
        self.bed.cover = cover;
    }

    /// Finds the pass sills anew of the cells whose bed changed.
    ///
    /// - `before`: the bed (m) for which they were found
    pub fn find_passes_again(&mut self, scenario: &Scenario, before: &[f64]) {
        let mut passes = std::mem::take(&mut self.bed.passes);
        ridges::find_again(scenario, (&self.surface(), before), &self.bed, &mut passes);
        self.bed.passes = passes;
    }

    /// The ridges that are worth a word, as lines; warns of them.
    pub fn ridges(&self, scenario: &Scenario, findings: &mut Findings) -> Vec<crate::output::Ridge> {
        ridges::report(scenario, &self.surface(), &self.bed, findings)
    }

    /// Code of [`SetBy`] of each cell.
    pub fn set_by(&self) -> &[u8] {
        &self.set_by
    }

    /// The bed of the run.
    pub fn into_bed(self) -> BedParticles {
        self.bed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bed::Surface;
    use crate::math::Vec2;
    use crate::terrain::{Layer, Raster};

    #[test]
    fn the_ground_knows_who_set_it_last() {
        let mut values = vec![3.0; 25];
        values[12] = f64::NAN;
        let raster = Raster { columns: 5, rows: 5, west: 0.0, north: 10.0, cell_x: 2.0, cell_y: 2.0, values };
        let terrain = Terrain::new(vec![Layer::Raster(raster)]).unwrap();
        let lattice = Lattice::new(Vec2::ZERO, 5, 5, 2.0);
        let elevation: Vec<f64> =
            (0..25).map(|cell| terrain.elevation(lattice.to_map(lattice.centre(cell))).unwrap_or(f64::NAN)).collect();
        let bed = BedParticles::from_elevation(lattice.clone(), elevation, 0.0);
        let set_by = source::layers(&terrain, &bed);
        let mut ground =
            Ground { terrain: &terrain, bed, seeding: SeedingConstants::DEFAULT, changes: Changes::default(), set_by };
        let line = SetBy::Breakline(1);
        ground.take([
            Change { cell: 12, made: Made::Fill(2.5), by: SetBy::FilledGap },
            Change { cell: 4, made: Made::Raise(5.0), by: line },
            Change { cell: 4, made: Made::Lift(0.5), by: SetBy::RaisedBuilding },
            Change { cell: 5, made: Made::Carve(1.0), by: line },
            Change { cell: 6, made: Made::Carve(4.0), by: line },
            Change { cell: 7, made: Made::Block, by: SetBy::BlockedBuilding },
            Change { cell: 8, made: Made::Roughness(0.3), by: SetBy::RaisedBuilding },
            Change { cell: 9, made: Made::RaiseTerrain(6.0), by: SetBy::Dam },
        ]);
        ground.take_beds(&[(10, 3.0005), (11, 2.0)], SetBy::Shore);
        let codes = |source: SetBy| source.code();
        let layer = SetBy::Layer(0);
        for (cell, expected, by) in [
            (3, Some(3.0), layer),
            (12, Some(2.5), SetBy::FilledGap),
            (4, Some(5.5), SetBy::RaisedBuilding),
            (5, Some(1.0), line),
            (6, Some(3.0), layer),
            (7, None, SetBy::BlockedBuilding),
            (8, Some(3.0), layer),
            (9, Some(3.0), layer),
            (10, Some(3.0005), layer),
            (11, Some(2.0), SetBy::Shore),
        ] {
            let found = Some(ground.bed.elevation[cell]).filter(|z| !z.is_nan());
            assert_eq!((found, ground.set_by[cell]), (expected, codes(by)), "cell {cell}");
        }
        assert_eq!((ground.bed.sealed.as_slice(), ground.bed.manning[8]), (&[7_usize][..], 0.3));
        let centre = |cell: usize| lattice.to_map(lattice.centre(cell));
        assert_eq!([9, 11].map(|cell| ground.surface().elevation(centre(cell))), [Some(6.0), Some(3.0)]);
    }
}
