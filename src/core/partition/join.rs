//! Which parts make up a cell: those that no line separates, and small ones with their neighbour on the same side.

use super::mesh::Mesh;

/// Parts without their seed that are smaller than this become part of a neighbour.
const LEAST_WITHOUT_SEED: f64 = 0.5;

/// Cells smaller than this (spacings squared) are joined to a neighbour.
pub const LEAST_AREA: f64 = 0.3;

/// The same between lines that water passes: there cells are as narrow as the lines are drawn, up to where they would rule the step.
const LEAST_BETWEEN_LINES: f64 = 0.1;

/// Lengths and areas nearer than this are equal: else rounding would choose, differently in a mirror.
const TIE: f64 = 1e-9;

/// The cells as sets of parts.
pub struct Groups {
    parent: Vec<u32>,
    area: Vec<f64>,
    has_seed: Vec<bool>,
    /// Areas below which a cell with its seed, and a part without it, is joined to a neighbour.
    least: [f64; 2],
}

impl Groups {
    /// Joins the parts that exist.
    ///
    /// - `is_there`: whether a part exists
    /// - `holds_seed`: whether a part holds its seed
    /// - `is_wall`: whether no water passes a line
    pub fn new(mesh: &Mesh, is_there: &[bool], holds_seed: &[bool], is_wall: impl Fn(u32) -> bool) -> Self {
        let mut groups = Groups {
            parent: (0..mesh.parts.len() as u32).collect(),
            area: mesh.parts.iter().map(|part| part.area).collect(),
            has_seed: holds_seed.to_vec(),
            least: [LEAST_AREA, LEAST_WITHOUT_SEED],
        };
        // Edges that water passes: those that lie on no line, and on lines.
        let (mut open, mut on_lines) = (Vec::new(), Vec::new());
        for edge in mesh.edges.iter().filter(|edge| !edge.line.is_some_and(&is_wall)) {
            let Some(right) = edge.right.filter(|right| is_there[*right as usize]) else { continue };
            if is_there[edge.left as usize] {
                let [a, b] = edge.ends.map(|end| mesh.places[end as usize]);
                let edges = if edge.line.is_none() { &mut open } else { &mut on_lines };
                edges.push((edge.left, right, (b - a).norm()));
            }
        }
        for (left, right, _) in &open {
            if mesh.parts[*left as usize].seed == mesh.parts[*right as usize].seed {
                groups.join(*left, *right);
            }
        }
        while groups.join_small(&mut open) {}
        groups.least = [LEAST_BETWEEN_LINES; 2];
        while groups.join_small(&mut on_lines) {}
        groups
    }

    /// The first part of the cell to which a part belongs.
    pub fn of(&self, part: u32) -> u32 {
        let mut at = part;
        while self.parent[at as usize] != at {
            at = self.parent[at as usize];
        }
        at
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        if a == b {
            return;
        }
        let (low, high) = (a.min(b), a.max(b));
        self.parent[high as usize] = low;
        self.area[low as usize] += self.area[high as usize];
        self.has_seed[low as usize] |= self.has_seed[high as usize];
    }

    fn is_small(&self, group: u32) -> bool {
        let least = self.least[usize::from(!self.has_seed[group as usize])];
        self.area[group as usize] < least
    }

    /// Joins each small cell to the neighbour with the longest common face, the smallest ones first; whether there was any.
    ///
    /// A cell waits for the next round where it or its neighbour has become part of another one in this.
    fn join_small(&mut self, open: &mut Vec<(u32, u32, f64)>) -> bool {
        let mut beside: Vec<(u32, u32, f64)> = Vec::new();
        open.retain_mut(|(left, right, length)| {
            (*left, *right) = (self.of(*left), self.of(*right));
            for (own, other) in [(*left, *right), (*right, *left)] {
                if own != other && self.is_small(own) {
                    beside.push((own, other, *length));
                }
            }
            left != right
        });
        beside.sort_by_key(|(own, other, _)| (*own, *other));
        let mut joins: Vec<(f64, u32, u32)> = Vec::new();
        for of_own in beside.chunk_by(|a, b| a.0 == b.0) {
            let own = of_own[0].0;
            let common = of_own.chunk_by(|a, b| a.1 == b.1).map(|of_pair| {
                let length: f64 = of_pair.iter().map(|(.., length)| length).sum();
                (length, self.area[of_pair[0].1 as usize], of_pair[0].1)
            });
            let best = common.reduce(|best, other| {
                let is_longer = other.0 > best.0 + TIE;
                let is_smaller = other.0 > best.0 - TIE && other.1 < best.1 - TIE;
                if is_longer || is_smaller { other } else { best }
            });
            joins.extend(best.map(|(_, _, other)| (self.area[own as usize], own, other)));
        }
        joins.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let count = if joins.is_empty() { 0 } else { self.parent.len() };
        let (mut has_grown, mut is_gone) = (vec![false; count], vec![false; count]);
        for (_, own, other) in &joins {
            if !has_grown[*own as usize] && !is_gone[*other as usize] {
                is_gone[*own as usize] = true;
                has_grown[*other as usize] = true;
                self.join(*own, *other);
            }
        }
        !joins.is_empty()
    }
}
