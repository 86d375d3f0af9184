//! Which cells count as neighbours, and flooding from cell to cell.

use super::{Cell, Lattice};

/// When two cells of a lattice are neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Neighbourhood {
    /// They share a face: 6 neighbours.
    Faces,
    /// They share at least a node: 26 neighbours.
    Nodes,
}

impl Neighbourhood {
    /// Calls `visit` with every neighbour of `cell` inside the lattice.
    pub fn for_each(self, lattice: &Lattice, cell: Cell, visit: impl FnMut(Cell)) {
        let at = lattice.cell_position(cell);
        let offsets: &[[isize; 3]] = match self {
            Self::Faces => &FACES,
            Self::Nodes => &NODES,
        };
        offsets.iter().filter_map(|offset| lattice.neighbour(at, *offset)).for_each(visit);
    }

    /// Walks from `seeds` over neighbours as long as `enter` accepts them.
    ///
    /// `enter` must return true at most once for a cell; the seeds count as entered.
    pub fn flood(self, lattice: &Lattice, seeds: Vec<Cell>, mut enter: impl FnMut(Cell) -> bool) {
        let mut front = seeds;
        while let Some(cell) = front.pop() {
            self.for_each(lattice, cell, |next| {
                if enter(next) {
                    front.push(next);
                }
            });
        }
    }
}

const FACES: [[isize; 3]; 6] = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];

const NODES: [[isize; 3]; 26] = {
    let mut offsets = [[0; 3]; 26];
    let mut n = 0;
    while n < 26 {
        let m = if n < 13 { n } else { n + 1 };
        offsets[n] = [(m % 3) as isize - 1, (m / 3 % 3) as isize - 1, (m / 9) as isize - 1];
        n += 1;
    }
    offsets
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inner_cell_has_6_and_26_neighbours_and_a_corner_cell_3_and_7() {
        let lattice = Lattice::new([3, 3, 3]);
        let count = |neighbourhood: Neighbourhood, at| {
            let mut found = Vec::new();
            neighbourhood.for_each(&lattice, lattice.cell(at), |c| found.push(c));
            found.sort();
            found.dedup();
            assert!(!found.contains(&lattice.cell(at)));
            found.len()
        };
        assert_eq!([count(Neighbourhood::Faces, [1; 3]), count(Neighbourhood::Nodes, [1; 3])], [6, 26]);
        assert_eq!([count(Neighbourhood::Faces, [2; 3]), count(Neighbourhood::Nodes, [2; 3])], [3, 7]);
    }
}
