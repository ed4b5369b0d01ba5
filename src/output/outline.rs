//! Cells of a grid as polygons along their edges.
//!
//! Each polygon is one region of cells that touch along edges. Its rings run along the edges with the region on the left and
//! are cut wherever they meet themselves, at corners where two cells of the region touch diagonally, so that every ring
//! is simple and every polygon valid; no smoothing, since a smoothed outline would promise more than the resolution holds.

/// A corner of the grid: columns and rows before it, row 0 in the north.
pub(super) type Corner = (usize, usize);

/// A region: its outer ring first, counter-clockwise on the map, then its holes, clockwise; rings are not closed by a
/// repeated corner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) rings: Vec<Vec<Corner>>,
}

/// The four directions on the map, each next one a quarter turn to the left.
const STEPS: [(isize, isize); 4] = [(1, 0), (0, -1), (-1, 0), (0, 1)];

/// The regions of the cells for which `inside` holds, `[rows * columns]`, in the order of their first cells.
pub(super) fn regions(columns: usize, inside: &[bool]) -> Vec<Region> {
    let rows = inside.len() / columns;
    let (labels, count) = label(columns, rows, inside);
    let mut outer: Vec<Vec<Corner>> = vec![Vec::new(); count];
    let mut holes: Vec<Vec<Vec<Corner>>> = vec![Vec::new(); count];
    let mut edges = boundary_edges(columns, rows, inside);
    let mut position = vec![usize::MAX; edges.len()];
    for start in 0..edges.len() {
        while let Some(direction) = (0..4).find(|direction| edges[start] & (1 << direction) != 0) {
            let corner = (start % (columns + 1), start / (columns + 1));
            let region = labels[cell_on_the_left(corner, direction, columns)];
            let walk = follow(corner, direction, columns, &mut edges);
            for ring in simple_rings(&walk, columns, &mut position) {
                let ring = without_straight_corners(&ring);
                if doubled_area(&ring) > 0 { outer[region] = ring } else { holes[region].push(ring) }
            }
        }
    }
    let join = |(outer, holes): (Vec<Corner>, Vec<Vec<Corner>>)| Region {
        rings: std::iter::once(outer).chain(holes).collect(),
    };
    outer.into_iter().zip(holes).map(join).collect()
}

/// The number of the region of each cell, and how many there are.
fn label(columns: usize, rows: usize, inside: &[bool]) -> (Vec<usize>, usize) {
    let mut labels = vec![usize::MAX; inside.len()];
    let mut count = 0;
    let mut stack = Vec::new();
    for seed in 0..inside.len() {
        if !inside[seed] || labels[seed] != usize::MAX {
            continue;
        }
        labels[seed] = count;
        stack.push(seed);
        while let Some(cell) = stack.pop() {
            let (column, row) = (cell % columns, cell / columns);
            let neighbours = [
                (column > 0).then(|| cell - 1),
                (column + 1 < columns).then_some(cell + 1),
                (row > 0).then(|| cell - columns),
                (row + 1 < rows).then_some(cell + columns),
            ];
            for neighbour in neighbours.into_iter().flatten() {
                if inside[neighbour] && labels[neighbour] == usize::MAX {
                    labels[neighbour] = count;
                    stack.push(neighbour);
                }
            }
        }
        count += 1;
    }
    (labels, count)
}

/// For each corner a bit for each direction in which an edge of the boundary leaves it, with the inside on the left.
fn boundary_edges(columns: usize, rows: usize, inside: &[bool]) -> Vec<u8> {
    let is_inside = |column: isize, row: isize| {
        let on_grid = column >= 0 && row >= 0 && (column as usize) < columns && (row as usize) < rows;
        on_grid && inside[row as usize * columns + column as usize]
    };
    let mut edges = vec![0_u8; (columns + 1) * (rows + 1)];
    for cell in (0..inside.len()).filter(|&cell| inside[cell]) {
        let (column, row) = (cell % columns, cell / columns);
        // South, east, north and west side of the cell, each from its start with the cell on the left.
        let starts = [(column, row + 1), (column + 1, row + 1), (column + 1, row), (column, row)];
        let outward = [(0, 1), (1, 0), (0, -1), (-1, 0)];
        for (direction, ((across, down), (x, y))) in starts.into_iter().zip(outward).enumerate() {
            if !is_inside(column as isize + x, row as isize + y) {
                edges[down * (columns + 1) + across] |= 1 << direction;
            }
        }
    }
    edges
}

fn cell_on_the_left((across, down): Corner, direction: usize, columns: usize) -> usize {
    let (column, row) = match direction {
        0 => (across, down - 1),
        1 => (across - 1, down - 1),
        2 => (across - 1, down),
        _ => (across, down),
    };
    row * columns + column
}

fn step((across, down): Corner, direction: usize) -> Corner {
    let (x, y) = STEPS[direction];
    (across.wrapping_add_signed(x), down.wrapping_add_signed(y))
}

/// Takes the edges of one closed walk out of `edges`; turns left where it can, so that it stays with its region.
fn follow(start: Corner, first: usize, columns: usize, edges: &mut [u8]) -> Vec<Corner> {
    let mut walk = Vec::new();
    let (mut corner, mut direction) = (start, first);
    loop {
        edges[corner.1 * (columns + 1) + corner.0] &= !(1 << direction);
        walk.push(corner);
        corner = step(corner, direction);
        let leaving = edges[corner.1 * (columns + 1) + corner.0];
        let turns = [(direction + 1) % 4, direction, (direction + 3) % 4];
        match turns.into_iter().find(|turn| leaving & (1 << turn) != 0) {
            Some(turn) => direction = turn,
            None => return walk,
        }
    }
}

/// Cuts a walk at the corners that it passes twice. `position` is scratch space with one entry for each corner.
fn simple_rings(walk: &[Corner], columns: usize, position: &mut [usize]) -> Vec<Vec<Corner>> {
    let index = |corner: &Corner| corner.1 * (columns + 1) + corner.0;
    let mut rings = Vec::new();
    let mut open: Vec<Corner> = Vec::new();
    for corner in walk {
        let earlier = position[index(corner)];
        if earlier != usize::MAX {
            for passed in &open[earlier..] {
                position[index(passed)] = usize::MAX;
            }
            rings.push(open.split_off(earlier));
        }
        position[index(corner)] = open.len();
        open.push(*corner);
    }
    for passed in &open {
        position[index(passed)] = usize::MAX;
    }
    rings.push(open);
    rings
}

fn without_straight_corners(ring: &[Corner]) -> Vec<Corner> {
    let count = ring.len();
    let turns = |i: usize| {
        let (before, here, after) = (ring[(i + count - 1) % count], ring[i], ring[(i + 1) % count]);
        !(before.0 == here.0 && here.0 == after.0 || before.1 == here.1 && here.1 == after.1)
    };
    (0..count).filter(|&i| turns(i)).map(|i| ring[i]).collect()
}

/// Twice the area on the map (cells), positive when counter-clockwise.
fn doubled_area(ring: &[Corner]) -> i64 {
    let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
    // Rows grow to the south, so the usual sign is turned.
    -pairs.map(|(a, b)| a.0 as i64 * b.1 as i64 - b.0 as i64 * a.1 as i64).sum::<i64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(rows: &[&str]) -> Vec<Region> {
        let inside: Vec<bool> = rows.iter().flat_map(|row| row.chars().map(|c| c == '#')).collect();
        regions(rows[0].len(), &inside)
    }

    fn area(region: &Region) -> i64 {
        region.rings.iter().map(|ring| doubled_area(ring)).sum::<i64>() / 2
    }

    #[test]
    fn rectangle_has_four_corners() {
        let regions = of(&["....", ".##.", ".##.", "...."]);
        assert_eq!(regions, [Region { rings: vec![vec![(1, 1), (1, 3), (3, 3), (3, 1)]] }]);
    }

    #[test]
    fn ring_has_a_hole() {
        let regions = of(&["###", "#.#", "###"]);
        assert_eq!(regions.len(), 1);
        assert_eq!((regions[0].rings.len(), area(&regions[0])), (2, 8));
    }

    #[test]
    fn diagonal_neighbours_are_two_regions() {
        let regions = of(&["#.", ".#"]);
        assert_eq!(regions.iter().map(area).collect::<Vec<_>>(), [1, 1]);
    }

    #[test]
    fn region_that_closes_diagonally_gets_a_hole_that_touches_its_rim() {
        // The hole in the middle meets the outside at one corner.
        let regions = of(&["###.", "#.#.", "##.#", "..##"]);
        assert_eq!(regions.len(), 2);
        assert_eq!(regions[0].rings.len(), 2);
        assert_eq!(regions.iter().map(area).collect::<Vec<_>>(), [7, 3]);
        for region in &regions {
            for ring in &region.rings {
                let mut corners = ring.clone();
                corners.sort_unstable();
                corners.dedup();
                assert_eq!(corners.len(), ring.len(), "a ring must not pass a corner twice");
            }
        }
    }

    #[test]
    fn area_of_any_pattern_is_its_number_of_cells() {
        // A fixed pseudo-random pattern; every cell belongs to exactly one region.
        let mut state = 12345_u64;
        let inside: Vec<bool> = (0..37 * 29)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                state >> 40 & 3 != 0
            })
            .collect();
        let regions = regions(37, &inside);
        let cells = inside.iter().filter(|&&cell| cell).count() as i64;
        assert_eq!(regions.iter().map(area).sum::<i64>(), cells);
        assert!(regions.iter().all(|region| doubled_area(&region.rings[0]) > 0));
        assert!(regions.iter().flat_map(|region| &region.rings[1..]).all(|hole| doubled_area(hole) < 0));
    }
}
