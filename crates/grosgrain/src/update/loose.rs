//! Parts that a removal cuts loose.

use std::collections::BTreeSet;

use crate::fine::FineModel;
use crate::mesh::{Cell, Lattice, Node, loose_parts, parts_loose_from_largest};

/// What happens to parts of the body that hang on nothing after cells were removed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LooseParts {
    /// They stay.
    Keep,
    /// They become void in the same update.
    #[default]
    Drop,
}

/// Which parts a removal has cut loose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LooseReport {
    /// Number of face-connected parts that can move freely.
    pub parts: usize,
    /// Number of their cells.
    pub cells: usize,
    /// Whether they were made void.
    pub dropped: bool,
}

/// Finds parts of a body that hang on nothing; its buffers are used again.
///
/// Parts are connected through faces. A part is loose if it can move without deforming anything when the held nodes stand still
/// ([`loose_parts`]): one that touches nothing held, and also one that hangs by an edge or a node only, about which it can turn.
/// Where `held` marks no node at all, a part is loose if it can move against the largest one
/// ([`parts_loose_from_largest`]).
#[derive(Clone, Debug, Default)]
pub struct LooseSearch {
    /// Number of its part for every cell, `NONE` for voids.
    part: Vec<u32>,
    front: Vec<u32>,
    /// What is known of the held nodes of every part.
    hold: Vec<Hold>,
    loose: Vec<Cell>,
}

const NONE: u32 = u32::MAX;

/// Held nodes that tell whether a part is held firmly: three that lie on no line.
#[derive(Clone, Copy, Debug, Default)]
struct Hold {
    first: Option<[i64; 3]>,
    second: Option<[i64; 3]>,
    firm: bool,
}

impl Hold {
    fn add(&mut self, at: [i64; 3]) {
        match (self.first, self.second) {
            (None, _) => self.first = Some(at),
            (Some(first), None) if at != first => self.second = Some(at),
            (Some(first), Some(second)) => {
                let (u, v): ([i64; 3], [i64; 3]) =
                    (std::array::from_fn(|a| second[a] - first[a]), std::array::from_fn(|a| at[a] - first[a]));
                self.firm |= (0..3).any(|a| u[a] * v[(a + 1) % 3] != u[(a + 1) % 3] * v[a]);
            }
            _ => {}
        }
    }
}

impl LooseSearch {
    /// A search without buffers yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The loose parts of the model when the marked nodes of the lattice are held.
    ///
    /// Costs one flood over the body where every part has three held nodes that lie on no line, which is the usual case; else
    /// also the exact search for what can turn.
    pub fn find(&mut self, model: &FineModel, held: &[bool]) -> LooseReport {
        self.loose.clear();
        self.flood(model);
        self.note_held(model, held);
        let anything_held = held.contains(&true);
        if self.hold.iter().all(|hold| hold.firm) || !anything_held && self.hold.len() <= 1 {
            return LooseReport::default();
        }
        let grid = model.grid();
        let found = match anything_held {
            true => loose_parts(grid, &held.iter().map(|h| [*h; 3]).collect::<Vec<_>>()),
            false => parts_loose_from_largest(grid),
        };
        let numbers: BTreeSet<u32> = found.iter().map(|p| self.part[grid.lattice.cell(p.first_cell).0]).collect();
        let cells = (0..self.part.len()).filter(|c| numbers.contains(&self.part[*c]));
        self.loose.extend(cells.map(Cell));
        LooseReport { parts: found.len(), cells: self.loose.len(), dropped: false }
    }

    /// The cells of the parts that the last search found, ascending.
    pub fn cells(&self) -> &[Cell] {
        &self.loose
    }

    /// Numbers the face-connected parts.
    fn flood(&mut self, model: &FineModel) {
        let grid = model.grid();
        self.part.clear();
        self.part.resize(grid.void.len(), NONE);
        self.hold.clear();
        for first in 0..grid.void.len() {
            if grid.void[first] || self.part[first] != NONE {
                continue;
            }
            let number = self.hold.len() as u32;
            self.hold.push(Hold::default());
            self.part[first] = number;
            self.front.push(first as u32);
            while let Some(cell) = self.front.pop() {
                let Self { part, front, .. } = self;
                for_each_neighbour(&grid.lattice, cell as usize, |next| {
                    if !grid.void[next] && part[next] == NONE {
                        part[next] = number;
                        front.push(next as u32);
                    }
                });
            }
        }
    }

    /// Tells the parts of their held nodes.
    fn note_held(&mut self, model: &FineModel, held: &[bool]) {
        let lattice = model.grid().lattice;
        for node in (0..held.len()).filter(|n| held[*n] && model.active()[*n]).map(Node) {
            let at = lattice.node_position(node).map(|i| i as i64);
            for cell in lattice.cells_at(node).filter(|c| self.part[c.0] != NONE) {
                self.hold[self.part[cell.0] as usize].add(at);
            }
        }
    }
}

fn for_each_neighbour(lattice: &Lattice, cell: usize, mut visit: impl FnMut(usize)) {
    let at = lattice.cell_position(Cell(cell));
    let strides = [1, lattice.cells[0], lattice.cells[0] * lattice.cells[1]];
    for axis in 0..3 {
        if at[axis] > 0 {
            visit(cell - strides[axis]);
        }
        if at[axis] + 1 < lattice.cells[axis] {
            visit(cell + strides[axis]);
        }
    }
}
