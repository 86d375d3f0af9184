//! How many copies of a coarse node there are, and which of the parts around it uses which.

use super::parts::VOID;
use super::{CoarseNode, Partition};
use crate::mesh::{Lattice, Node};

/// The up to eight coarse cells around a node: bit a of the index says whether the cell lies beyond the node along axis a.
type Around = [Option<usize>; 8];

/// Ties the parts around a coarse node that share fine nodes, with room that is used again from node to node.
///
/// A slot is a part of one of the cells around the node, numbered by (cell, part). Slots that share a fine node are tied;
/// the connected sets of slots are the copies of the node, numbered by their smallest slot.
pub(super) struct CopyFinder {
    partition: Partition,
    /// Number of the first slot of each cell around the node.
    first_slot: [u32; 8],
    /// A slot of the same copy with a number no larger; of itself if it is the smallest.
    parent: Vec<u32>,
    copies: u32,
}

impl CopyFinder {
    pub(super) fn new(partition: &Partition) -> Self {
        Self { partition: *partition, first_slot: [0; 8], parent: Vec::new(), copies: 0 }
    }

    /// Finds the copies of `node` and returns their number; `part_of` is per fine cell, `counts` per coarse cell.
    pub(super) fn find(&mut self, node: CoarseNode, part_of: &[u32], counts: &[u32]) -> u32 {
        let around = cells_around(self.partition.coarse(), node);
        self.parent.clear();
        for (first, cell) in self.first_slot.iter_mut().zip(around) {
            *first = self.parent.len() as u32;
            let count = cell.map_or(0, |cell| counts[cell]);
            self.parent.extend(*first..*first + count);
        }
        self.copies = self.parent.len() as u32;
        self.tie_at([0; 3], node, part_of);
        if self.copies > 1 {
            self.tie_around(node, part_of);
        }
        self.number()
    }

    /// The copy that part number `part` of the cell with the node as its corner number `corner` uses.
    pub(super) fn copy_of(&self, corner: usize, part: u32) -> u32 {
        self.parent[(self.first_slot[7 - corner] + part) as usize]
    }

    /// Ties over all fine nodes on faces between the cells around the node.
    fn tie_around(&mut self, node: CoarseNode, part_of: &[u32]) {
        let d = self.partition.degree() as isize;
        for axis in 0..3 {
            for (p, q) in (-d..=d).flat_map(|p| (-d..=d).map(move |q| (p, q))) {
                let mut offset = [0; 3];
                (offset[(axis + 1) % 3], offset[(axis + 2) % 3]) = (p, q);
                self.tie_at(offset, node, part_of);
                if self.copies == 1 {
                    return;
                }
            }
        }
    }

    /// Ties the slots that touch the fine node `offset` away from the coarse node.
    fn tie_at(&mut self, offset: [isize; 3], node: CoarseNode, part_of: &[u32]) {
        let d = self.partition.degree() as isize;
        let fine = self.partition.fine();
        let at = self.partition.coarse().node_position(Node(node.0)).map(|x| x as isize * d);
        let mut first = None;
        for beyond in 0..8 {
            // Fine cell relative to the coarse node.
            let from: [isize; 3] = std::array::from_fn(|a| offset[a] - 1 + (beyond >> a & 1));
            let inside =
                |a: usize| (-d..d).contains(&from[a]) && (0..fine.cells[a] as isize).contains(&(at[a] + from[a]));
            if !(0..3).all(inside) {
                continue;
            }
            let part = part_of[fine.cell(std::array::from_fn(|a| (at[a] + from[a]) as usize)).0];
            if part == VOID {
                continue;
            }
            let cell = (0..3).fold(0, |bits, a| bits | usize::from(from[a] >= 0) << a);
            let slot = self.first_slot[cell] + part;
            match first {
                None => first = Some(slot),
                Some(other) => self.tie(other, slot),
            }
        }
    }

    fn tie(&mut self, a: u32, b: u32) {
        let (a, b) = (self.smallest(a), self.smallest(b));
        if a != b {
            self.parent[a.max(b) as usize] = a.min(b);
            self.copies -= 1;
        }
    }

    fn smallest(&mut self, mut slot: u32) -> u32 {
        while self.parent[slot as usize] != slot {
            let next = self.parent[slot as usize];
            self.parent[slot as usize] = self.parent[next as usize];
            slot = next;
        }
        slot
    }

    /// Turns the smallest slot of each copy into the copy's number, which it then holds for all slots.
    fn number(&mut self) -> u32 {
        let mut copies = 0;
        for slot in 0..self.parent.len() {
            // Parents come before their slots, so theirs is a copy number already.
            self.parent[slot] = match self.parent[slot] as usize {
                own if own == slot => {
                    copies += 1;
                    copies - 1
                }
                earlier => self.parent[earlier],
            };
        }
        copies
    }
}

fn cells_around(coarse: Lattice, node: CoarseNode) -> Around {
    let at = coarse.node_position(Node(node.0));
    std::array::from_fn(|beyond| {
        let offset = [0, 1, 2].map(|a| (beyond >> a & 1) as isize - 1);
        coarse.neighbour(at, offset).map(|cell| cell.0)
    })
}
