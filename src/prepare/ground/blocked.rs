//! Footprints of blocked buildings, of which the means of the terrain beside them are kept free: where a survey saw the houses, half a
//! house in a cell would make half a storey of ground.

use std::collections::BTreeMap;

use geo::{BoundingRect, Contains, MultiPolygon};

use crate::bed::LeftOut;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::terrain::{Layer, Terrain};

/// The surroundings of a cell reach so many of its widths, or of cells of the raster, beyond its centre at most.
const REACH: f64 = 3.0;

/// Footprints, and of each cell those that may lie in it or its surroundings.
#[derive(Debug, Default)]
pub struct Blocked<'a> {
    footprints: Vec<&'a MultiPolygon<f64>>,
    near: BTreeMap<usize, Vec<usize>>,
}

impl<'a> Blocked<'a> {
    /// - `footprints`: in map coordinates
    pub fn new(footprints: impl Iterator<Item = &'a MultiPolygon<f64>>, terrain: &Terrain, lattice: &Lattice) -> Self {
        let footprints: Vec<&MultiPolygon<f64>> = footprints.collect();
        let coarsest = terrain.layers().iter().filter_map(|layer| match layer {
            Layer::Raster(raster) => Some(raster.cell_x.max(raster.cell_y)),
            Layer::Survey(_) => None,
        });
        let reach = REACH * coarsest.fold(lattice.spacing, f64::max);
        let mut near: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (number, footprint) in footprints.iter().enumerate() {
            let Some(bounds) = footprint.bounding_rect() else { continue };
            let local = |x: f64, y: f64| lattice.to_local(Vec2::new(x, y)) / lattice.spacing;
            let low = local(bounds.min().x - reach, bounds.min().y - reach);
            let high = local(bounds.max().x + reach, bounds.max().y + reach);
            let range =
                |low: f64, high: f64, count: usize| low.max(0.0) as usize..(high.ceil().max(0.0) as usize).min(count);
            for row in range(low.y, high.y, lattice.rows) {
                for column in range(low.x, high.x, lattice.columns) {
                    near.entry(lattice.index(column, row)).or_default().push(number);
                }
            }
        }
        Blocked { footprints, near }
    }
}

impl LeftOut for Blocked<'_> {
    fn is_near(&self, cell: usize) -> bool {
        self.near.contains_key(&cell)
    }

    fn holds(&self, cell: usize, map: Vec2) -> bool {
        let place = geo::Point::new(map.x, map.y);
        self.near.get(&cell).is_some_and(|near| near.iter().any(|&number| self.footprints[number].contains(&place)))
    }
}
