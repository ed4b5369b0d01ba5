//! Maps on the terrain's own raster: the level of the water less the terrain, where that joins the water of a cell (M84).
//!
//! The level in a wet cell falls or rises linearly from its middle, where it is η_i, to the middle of each of its faces:
//!
//! ```text
//! η_f = min(½ (η_i + η_j), max(½ (z_i + z_j) + 2 d_i, min(η_i, η_j)))     the cell beyond the face is wet, and the face open
//! η_f = 2 η_i − η_opp, held between η_i and ½ (η_i + z_j)            that cell is dry, the face open, the opposite cell wet
//! η_f = η_i                                                               in all other cases
//! ```
//!
//! A lake is level in it, and a sheet on a slope is as deep everywhere in the cell as in its middle. A face is shut where a wall crosses
//! it, and where its pass sill (M10) stands above both levels.
//!
//! A pixel is wet where it lies below that level and joins, over such pixels that meet at an edge, the lowest pixel of a wet cell. In
//! a dry cell beside a wet one the water reaches the pixels below η_i; where the bed of that cell lies lower than η_i, only those that do
//! not join its lowest pixel below η_i, as before a levee in it: to the others the run could have sent water and did not. The lowest
//! pixel of a wet cell is wet; where the level lies no higher than it, as over a bed that is not the mean, it is as deep as the cell.
//!
//! Deliberately absent: levels of the pixels over time. Arrival, duration and recession are those of the cell for the highest threshold
//! that it reached no later than the pixel reached its own.

mod faces;

use std::collections::{BTreeMap, BTreeSet};

use super::grid::{FILL, GridMaps, OutputGrid, ThresholdGrids, filled};
use super::hazard::hazard_class;
use super::maxima::{Seen, ThresholdSeen};
use super::tracers::Tracers;
use super::{TerrainPixels, WET_DEPTH};
use crate::bed::PassSills;
use crate::lattice::{Lattice, Level, NEIGHBOURS};
use crate::math::Vec2;
use faces::{beside, crossed_faces, face, on_one_level};

/// No wet cell.
const NONE: u32 = u32::MAX;
/// A depth that misses a threshold by less than this (m) reaches it: the round-off of elevations in single precision, up to 8000 m.
const ROUND_OFF: f64 = 5e-4;

/// The water of the run by the cells of the lattice.
pub(super) struct WaterOfCells<'a> {
    /// Bed elevation (m) at the end; NaN where there is no terrain.
    pub bed: &'a [f64],
    /// The bed (m) at the start of the cells where it may have changed in the run.
    pub bed_at_start: &'a BTreeMap<usize, f64>,
    /// Greatest level (m) of a cell that was wet.
    pub level: &'a dyn Fn(usize) -> f64,
    /// What a cell has seen.
    pub seen: &'a dyn Fn(usize) -> Seen,
    /// The thresholds (m).
    pub thresholds: &'a [f64],
    /// What a cell has seen of a threshold, given by its place in the list.
    pub seen_of_threshold: &'a dyn Fn(usize, usize) -> ThresholdSeen,
    /// The tracers.
    pub tracers: &'a Tracers,
}

/// The terrain's own raster, and what keeps the water of a cell from the next.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct OnTerrain {
    lattice: Lattice,
    pixels: TerrainPixels,
    passes: PassSills,
    /// Faces that a wall crosses, by the cell to the west or south and whether the other lies to the north.
    walled: BTreeSet<(usize, bool)>,
    grid: OutputGrid,
    /// Lattice column of each column of pixels, lattice row of each row.
    columns: Vec<usize>,
    rows: Vec<usize>,
}

/// A cell that was wet.
struct WetCell {
    cell: usize,
    seen: Seen,
    level: f64,
    /// Level (m) in the middle of each face.
    at_faces: [f64; 4],
}

/// The cell beyond a face.
enum Beyond {
    Wet(f64),
    Dry(f64),
    Shut,
}

impl OnTerrain {
    pub(super) fn new(lattice: Lattice, pixels: TerrainPixels, passes: PassSills, walls: &[[Vec2; 2]]) -> Self {
        let TerrainPixels { west, north, cell, columns, rows, .. } = pixels;
        let has_terrain = pixels.elevation.iter().map(|z| !z.is_nan()).collect();
        let of = |place: f64, count: usize| ((place / lattice.spacing) as usize).min(count.saturating_sub(1));
        let from_west = |column: usize| west - lattice.origin.x + (column as f64 + 0.5) * cell;
        let from_south = |row: usize| north - lattice.origin.y - (row as f64 + 0.5) * cell;
        OnTerrain {
            grid: OutputGrid::of_pixels((west, north), cell, (columns, rows), has_terrain),
            columns: (0..columns).map(|column| of(from_west(column), lattice.columns)).collect(),
            rows: (0..rows).map(|row| of(from_south(row), lattice.rows)).collect(),
            walled: crossed_faces(&lattice, walls),
            lattice,
            pixels,
            passes,
        }
    }

    /// The grid of the pixels.
    pub(super) fn grid(&self) -> &OutputGrid {
        &self.grid
    }

    /// The maps of the run.
    pub(super) fn maps(mut self, water: &WaterOfCells<'_>) -> GridMaps {
        self.move_bed(water);
        let (wet, numbers) = self.wet_cells(water);
        let sources = self.flood(&wet, &numbers, water.bed);
        let mut maps = self.dry_maps(water.thresholds);
        for (pixel, &source) in sources.iter().enumerate().filter(|(_, source)| **source != NONE) {
            self.fill_in(pixel, &wet[source as usize], water, &mut maps);
        }
        maps.tracers = water.tracers.on_pixels(&sources, |source| wet.get(source as usize).map(|own| own.cell));
        maps
    }

    /// Takes over the bed at the end of the run.
    fn move_bed(&mut self, water: &WaterOfCells<'_>) {
        if water.bed_at_start.is_empty() {
            return;
        }
        for pixel in 0..self.pixels.elevation.len() {
            let (column, row) = self.place_of(pixel);
            let cell = self.cell_of(column, row);
            if let Some(before) = water.bed_at_start.get(&cell) {
                self.pixels.elevation[pixel] += (water.bed[cell] - before) as f32;
            }
        }
    }

    fn cell_of(&self, column: usize, row: usize) -> usize {
        self.lattice.leaf(self.columns[column], self.rows[row])
    }

    /// Column and row of a pixel.
    fn place_of(&self, pixel: usize) -> (usize, usize) {
        (pixel % self.columns.len(), pixel / self.columns.len())
    }

    fn elevation(&self, pixel: usize) -> f64 {
        f64::from(self.pixels.elevation[pixel])
    }

    /// Centre of a pixel in the local coordinates of the lattice (m).
    fn centre(&self, column: usize, row: usize) -> Vec2 {
        let TerrainPixels { west, north, cell, .. } = self.pixels;
        self.lattice.to_local(Vec2::new(west + (column as f64 + 0.5) * cell, north - (row as f64 + 0.5) * cell))
    }

    /// The wet cells, ascending, and the number of each cell among them.
    fn wet_cells(&self, water: &WaterOfCells<'_>) -> (Vec<WetCell>, Vec<u32>) {
        let is_wet = |cell: usize| (water.seen)(cell).max_depth > WET_DEPTH;
        let mut numbers = vec![NONE; self.lattice.len()];
        let mut wet = Vec::new();
        for cell in (0..self.lattice.len()).filter(|&cell| is_wet(cell)) {
            numbers[cell] = wet.len() as u32;
            let (seen, level) = ((water.seen)(cell), (water.level)(cell));
            wet.push(WetCell { cell, seen, level, at_faces: [level; 4] });
        }
        let at_faces: Vec<[f64; 4]> =
            wet.iter().map(|own| self.levels_at_faces(own, &wet, &numbers, water.bed)).collect();
        for (own, at_faces) in wet.iter_mut().zip(at_faces) {
            own.at_faces = at_faces;
        }
        (wet, numbers)
    }

    /// The levels in the middles of the faces of a wet cell.
    fn levels_at_faces(&self, own: &WetCell, wet: &[WetCell], numbers: &[u32], bed: &[f64]) -> [f64; 4] {
        let (level, depth) = (own.level, own.seen.max_depth);
        // A cell that follows lines may end at a wall or bank on any side.
        if self.lattice.conforming_at(own.cell).is_some() {
            return [level; 4];
        }
        let level_of = |other: usize| (numbers[other] != NONE).then(|| wet[numbers[other] as usize].level);
        let beyond = NEIGHBOURS.map(|step| {
            let beside = beside(&self.lattice, own.cell, step);
            let others: Vec<usize> = beside.into_iter().filter(|&other| !bed[other].is_nan()).collect();
            // Two cells of a finer level are seen as one: their mean, or the wet one of them.
            let wet_ones: Vec<usize> = others.iter().copied().filter(|&other| level_of(other).is_some()).collect();
            let seen = if wet_ones.is_empty() { &others } else { &wet_ones };
            let Some(&other) = seen.first() else { return (Beyond::Shut, f64::NAN) };
            let mean = |of: &dyn Fn(usize) -> f64| seen.iter().map(|&cell| of(cell)).sum::<f64>() / seen.len() as f64;
            let its_bed = mean(&|cell| bed[cell]);
            let its = mean(&|cell| level_of(cell).unwrap_or(bed[cell]));
            let [a, b] = on_one_level(&self.lattice, (own.cell, other), step);
            let is_shut = self.walled.contains(&face(a, b)) || self.passes.between(a, b) > level.max(its);
            let of = match level_of(other) {
                _ if is_shut => Beyond::Shut,
                None => Beyond::Dry(its),
                Some(_) => Beyond::Wet(its),
            };
            (of, its_bed)
        });
        let to_wet = |(of, its_bed): &(Beyond, f64)| match of {
            Beyond::Wet(its) => {
                let deepest = 0.5 * (bed[own.cell] + its_bed) + 2.0 * depth;
                Some((0.5 * (level + its)).min(deepest.max(level.min(*its))))
            }
            _ => None,
        };
        let wet_faces = [0, 1, 2, 3].map(|which: usize| to_wet(&beyond[which]));
        [0, 1, 2, 3].map(|which: usize| match (&beyond[which].0, wet_faces[which], wet_faces[which ^ 1]) {
            (_, Some(level), _) => level,
            (Beyond::Dry(its_bed), None, Some(opposite)) => {
                let halfway = 0.5 * (level + its_bed);
                (2.0 * level - opposite).clamp(level.min(halfway), level.max(halfway))
            }
            _ => level,
        })
    }

    /// The level (m) of a wet cell at a place in it (local coordinates).
    fn level_at(&self, own: &WetCell, place: Vec2) -> f64 {
        let from_middle = (place - self.lattice.centre(own.cell)) * (2.0 / self.lattice.spacing_of(own.cell));
        let [east, west, north, south] = own.at_faces.map(|level| level - own.level);
        let x = if from_middle.x > 0.0 { east } else { west };
        let y = if from_middle.y > 0.0 { north } else { south };
        own.level + from_middle.x.abs() * x + from_middle.y.abs() * y
    }

    /// The level (m) at a pixel of the water of a wet cell.
    fn level_at_pixel(&self, own: &WetCell, pixel: usize) -> f64 {
        let (column, row) = self.place_of(pixel);
        if self.cell_of(column, row) == own.cell { self.level_at(own, self.centre(column, row)) } else { own.level }
    }

    /// Of each pixel that is wet the number of the wet cell whose water it is.
    fn flood(&self, wet: &[WetCell], numbers: &[u32], bed: &[f64]) -> Vec<u32> {
        let mut kept_dry: BTreeMap<(u32, usize), BTreeSet<usize>> = BTreeMap::new();
        let mut sources = vec![NONE; self.pixels.elevation.len()];
        let mut open = self.lowest_pixels(wet.len(), numbers);
        for &pixel in &open {
            let (column, row) = self.place_of(pixel);
            sources[pixel] = numbers[self.cell_of(column, row)];
        }
        while let Some(pixel) = open.pop() {
            for next in self.neighbours(pixel) {
                let (column, row) = self.place_of(next);
                let cell = self.cell_of(column, row);
                let source = if numbers[cell] == NONE { sources[pixel] } else { numbers[cell] };
                let own = &wet[source as usize];
                if sources[next] != NONE || self.level_at_pixel(own, next) - self.elevation(next) <= WET_DEPTH {
                    continue;
                }
                let is_shore = own.cell != cell && self.is_beside(own.cell, cell) && !bed[cell].is_nan();
                let mut is_kept_dry = || {
                    let joined = || self.joined_to_lowest(cell, own.level);
                    kept_dry.entry((source, cell)).or_insert_with(joined).contains(&next)
                };
                if own.cell == cell || is_shore && (bed[cell] >= own.level || !is_kept_dry()) {
                    sources[next] = source;
                    open.push(next);
                }
            }
        }
        sources
    }

    /// The pixels that meet a pixel at an edge.
    fn neighbours(&self, pixel: usize) -> impl Iterator<Item = usize> {
        let ((column, row), (columns, rows)) = (self.place_of(pixel), (self.columns.len(), self.rows.len()));
        NEIGHBOURS.into_iter().filter_map(move |(across, down)| {
            let (column, row) = (column.checked_add_signed(across)?, row.checked_add_signed(down)?);
            (column < columns && row < rows).then(|| row * columns + column)
        })
    }

    /// The pixels of a cell that join its lowest ones below a level (m) inside it.
    fn joined_to_lowest(&self, cell: usize, level: f64) -> BTreeSet<usize> {
        let (mut column, mut row) = self.lattice.column_row(cell);
        let Level { mut first_row, spacing, .. } = self.lattice.level_of_row(row);
        // A cell that follows lines may hold the centres of squares about its own.
        let mut about = 0;
        if self.lattice.conforming_at(cell).is_some() {
            let centre = self.lattice.centre(cell) * (1.0 / self.lattice.spacing);
            (column, row, first_row, about) = (centre.x as usize, centre.y as usize, 0, 2);
        }
        let finer = (spacing / self.lattice.spacing).round() as usize;
        let is_in = |finest: usize, place: usize| (finest / finer).abs_diff(place) <= about;
        let of =
            |places: &[usize], place: usize| (0..places.len()).filter(|&k| is_in(places[k], place)).collect::<Vec<_>>();
        let (columns, rows) = (of(&self.columns, column), of(&self.rows, row - first_row));
        let within = || rows.iter().flat_map(|&row| columns.iter().map(move |&column| (column, row)));
        let own = || within().filter(|&(column, row)| self.cell_of(column, row) == cell);
        let pixels = || own().map(|(column, row)| row * self.columns.len() + column);
        let lowest = pixels().map(|pixel| self.elevation(pixel)).fold(level, f64::min);
        let mut joined: BTreeSet<usize> =
            pixels().filter(|&pixel| self.elevation(pixel) <= lowest && lowest < level).collect();
        let mut open: Vec<usize> = joined.iter().copied().collect();
        while let Some(pixel) = open.pop() {
            for next in self.neighbours(pixel) {
                let (column, row) = self.place_of(next);
                if self.cell_of(column, row) == cell && self.elevation(next) < level && joined.insert(next) {
                    open.push(next);
                }
            }
        }
        joined
    }

    fn is_beside(&self, own: usize, cell: usize) -> bool {
        let apart = self.lattice.centre(own) - self.lattice.centre(cell);
        let reach = 0.5 * (self.lattice.spacing_of(own) + self.lattice.spacing_of(cell));
        let is_near = |distance: f64| distance.abs() < reach + 0.25 * self.lattice.spacing;
        is_near(apart.x) && is_near(apart.y)
    }

    /// The lowest pixel of each wet cell that has one.
    fn lowest_pixels(&self, count: usize, numbers: &[u32]) -> Vec<usize> {
        let mut lowest = vec![usize::MAX; count];
        for pixel in 0..self.pixels.elevation.len() {
            let (column, row) = self.place_of(pixel);
            let number = numbers[self.cell_of(column, row)];
            if number != NONE && !self.pixels.elevation[pixel].is_nan() {
                let lowest = &mut lowest[number as usize];
                if *lowest == usize::MAX || self.pixels.elevation[pixel] < self.pixels.elevation[*lowest] {
                    *lowest = pixel;
                }
            }
        }
        lowest.retain(|&pixel| pixel != usize::MAX);
        lowest
    }

    /// Maps without water.
    fn dry_maps(&self, thresholds: &[f64]) -> GridMaps {
        let with = |value: f32| {
            let terrain = self.pixels.elevation.iter();
            terrain.map(|z| if z.is_nan() { FILL } else { value }).collect::<Vec<f32>>()
        };
        let of_threshold = |&threshold: &f64| ThresholdGrids {
            threshold,
            arrival: with(FILL),
            duration: with(0.0),
            recession: with(FILL),
        };
        GridMaps {
            bed_elevation: self.pixels.elevation.iter().map(|&z| if z.is_nan() { FILL } else { z }).collect(),
            max_depth: with(0.0),
            max_water_level: with(FILL),
            max_speed: with(0.0),
            max_depth_velocity: with(0.0),
            time_of_max_depth: with(FILL),
            hazard_class: with(0.0),
            thresholds: thresholds.iter().map(of_threshold).collect(),
            ..GridMaps::default()
        }
    }

    /// Fills in the water of a pixel, which is that of a wet cell.
    fn fill_in(&self, pixel: usize, own: &WetCell, water: &WaterOfCells<'_>, maps: &mut GridMaps) {
        let seen = &own.seen;
        let elevation = self.elevation(pixel);
        let below = self.level_at_pixel(own, pixel) - elevation;
        // A lowest pixel above the level shows the depth of its cell.
        let depth = if below > WET_DEPTH { below } else { seen.max_depth };
        let class = hazard_class(depth, seen.max_speed);
        maps.max_depth[pixel] = depth as f32;
        maps.max_water_level[pixel] = (elevation + depth) as f32;
        maps.max_speed[pixel] = seen.max_speed as f32;
        maps.max_depth_velocity[pixel] = (seen.max_depth_velocity * depth / seen.max_depth) as f32;
        maps.time_of_max_depth[pixel] = filled(seen.time_of_max_depth);
        maps.hazard_class[pixel] = f32::from(if depth < seen.max_depth { class.min(seen.hazard_class) } else { class });
        for grids in maps.thresholds.iter_mut().filter(|grids| depth >= grids.threshold) {
            let needed = seen.max_depth - (depth - grids.threshold);
            let found = of_threshold(own, needed, water);
            grids.arrival[pixel] = filled(found.arrival);
            grids.duration[pixel] = found.duration as f32;
            grids.recession[pixel] = filled(found.recession);
        }
    }
}

/// What a wet cell has seen of the highest threshold that is not above a depth (m) of the cell, or of its lowest; of a cell that never
/// was as deep as that the moment at which it was deepest.
fn of_threshold(own: &WetCell, needed: f64, water: &WaterOfCells<'_>) -> ThresholdSeen {
    let by_depth = |a: &usize, b: &usize| water.thresholds[*a].total_cmp(&water.thresholds[*b]);
    let all = 0..water.thresholds.len();
    let below = all.clone().filter(|&which| water.thresholds[which] <= needed + ROUND_OFF).max_by(by_depth);
    let Some(which) = below.or_else(|| all.min_by(by_depth)) else {
        return ThresholdSeen { arrival: f64::NAN, duration: 0.0, recession: f64::NAN };
    };
    let found = (water.seen_of_threshold)(own.cell, which);
    if own.seen.max_depth < water.thresholds[which] {
        return ThresholdSeen { arrival: own.seen.time_of_max_depth, ..found };
    }
    found
}

#[cfg(test)]
mod tests;
