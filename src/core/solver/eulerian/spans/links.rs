//! General faces as ways for water: they join cells that are no neighbours in the rows.
//!
//! A cell becomes active with a rim about it where the cell on the other side of a face is wet or beside water. Only faces beside rows
//! whose wet cells changed are looked at again.

use std::ops::Range;

use super::RIM;
use super::runs::{Run, holds};

/// A padded place (row, column).
type Place = (usize, usize);

/// One way over a general face.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Link {
    to: Place,
    from: Place,
    /// Whether water may come over it now to a dry cell.
    reaches: bool,
}

/// The ways over all general faces, by the rows to which they lead.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Links {
    links: Vec<Link>,
    /// Those that lead to each padded row.
    of_row: Vec<Range<usize>>,
    /// The numbers of those with an end in each padded row.
    touching: Vec<Vec<usize>>,
}

impl Links {
    /// The ways over faces with these places on their two sides, among so many padded rows.
    pub fn new(linked: &[[Place; 2]], rows: usize) -> Self {
        let ways = linked.iter().flat_map(|&[a, b]| [(a, b), (b, a)]);
        let mut links: Vec<Link> = ways.map(|(to, from)| Link { to, from, reaches: false }).collect();
        links.sort_unstable_by_key(|link| (link.to, link.from));
        let first = |row: usize| links.partition_point(|link| link.to.0 < row);
        let of_row = (0..rows).map(|row| first(row)..first(row + 1)).collect();
        let mut touching = vec![Vec::new(); rows];
        for (number, link) in links.iter().enumerate() {
            touching[link.to.0].push(number);
            if link.from.0 != link.to.0 {
                touching[link.from.0].push(number);
            }
        }
        Links { links, of_row, touching }
    }

    /// The places on the two sides of each way.
    pub fn places(&self) -> impl Iterator<Item = [Place; 2]> + '_ {
        self.links.iter().map(|link| [link.to, link.from])
    }

    /// Looks at the links again where the wet runs of rows changed, and marks the rows in which that changes what water reaches. `apart` are the rows of cells
    /// that follow lines.
    pub fn follow(&mut self, wet: &[Vec<Run>], changed: &[bool], apart: &Run, is_stale: &mut [bool]) {
        let Links { links, touching, .. } = self;
        for (row, numbers) in touching.iter().enumerate().filter(|(_, numbers)| !numbers.is_empty()) {
            if !changed[row - 1..row + 2].contains(&true) {
                continue;
            }
            for &number in numbers {
                let link = &mut links[number];
                let reaches = !holds(&wet[link.to.0], link.to.1) && is_near(wet, apart, link.from);
                if reaches != link.reaches {
                    link.reaches = reaches;
                    let end = (link.to.0 + RIM + 1).min(is_stale.len());
                    is_stale[link.to.0.saturating_sub(RIM)..end].fill(true);
                }
            }
        }
    }

    /// The columns of a row to which water may come over links.
    pub fn reached(&self, row: usize) -> impl Iterator<Item = usize> + '_ {
        self.links[self.of_row[row].clone()].iter().filter(|link| link.reaches).map(|link| link.to.1)
    }
}

/// Whether a cell is wet or beside a wet one, be it by a corner; cells that follow lines are beside none in the rows.
fn is_near(wet: &[Vec<Run>], apart: &Run, (row, column): Place) -> bool {
    if apart.contains(&row) {
        return holds(&wet[row], column);
    }
    wet[row - 1..row + 2].iter().any(|runs| {
        let next = runs.partition_point(|run| run.end < column);
        runs.get(next).is_some_and(|run| run.start <= column + 1)
    })
}
