//! How many copies of a coarse node there are, and which of the parts around it uses which.

use super::parts::VOID;
use super::{CoarseCell, CoarseNode, Partition};
use crate::mesh::{Lattice, Node};

/// The up to eight coarse cells around a node: bit a of the index says whether the cell lies beyond the node along axis a.
type Around = [Option<usize>; 8];

/// The slot of a fine cell that is void or outside of the body's lattice.
const NONE: u32 = u32::MAX;

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
    /// Slot of every fine cell of the eight coarse cells, x fastest, with a border of cells that have none.
    slots: Vec<u32>,
}

impl CopyFinder {
    pub(super) fn new(partition: &Partition) -> Self {
        let slots = vec![NONE; (2 * partition.degree() + 2).pow(3)];
        Self { partition: *partition, first_slot: [0; 8], parent: Vec::new(), copies: 0, slots }
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
        if self.copies > 1 && !self.all_touch(&around, part_of) {
            self.gather(&around, part_of);
            self.tie_around();
            return self.number();
        }
        self.parent.fill(0);
        self.copies
    }

    /// Whether all slots touch the coarse node itself, so that there is one copy: the common case, decided from eight fine cells.
    fn all_touch(&mut self, around: &Around, part_of: &[u32]) -> bool {
        let (fine, d) = (self.partition.fine(), self.partition.degree());
        let touches = |(beyond, cell): (usize, &Option<usize>)| {
            let Some(cell) = *cell else { return false };
            let start = self.partition.cell_box(CoarseCell(cell)).start;
            let at = std::array::from_fn(|a| start[a] + if beyond >> a & 1 == 1 { 0 } else { d - 1 });
            part_of[fine.cell(at).0] != VOID
        };
        let all = around.iter().enumerate().filter(|cell| touches(*cell)).count() == self.parent.len();
        self.copies = if all { 1 } else { self.copies };
        all
    }

    /// The copy that part number `part` of the cell with the node as its corner number `corner` uses.
    pub(super) fn copy_of(&self, corner: usize, part: u32) -> u32 {
        self.parent[(self.first_slot[7 - corner] + part) as usize]
    }

    /// Writes the slots of the fine cells of all eight coarse cells.
    fn gather(&mut self, around: &Around, part_of: &[u32]) {
        let (fine, d) = (self.partition.fine(), self.partition.degree());
        let width = 2 * d + 2;
        for (beyond, cell) in around.iter().enumerate() {
            let start = cell.map(|cell| self.partition.cell_box(CoarseCell(cell)).start);
            let corner = [0, 1, 2].map(|a| 1 + d * (beyond >> a & 1));
            for (j, k) in (0..d * d).map(|n| (n % d, n / d)) {
                let row = &mut self.slots[corner[0] + width * (corner[1] + j + width * (corner[2] + k))..][..d];
                let Some([x, y, z]) = start else {
                    row.fill(NONE);
                    continue;
                };
                let parts = &part_of[fine.cell([x, y + j, z + k]).0..][..d];
                let first = self.first_slot[beyond];
                row.iter_mut().zip(parts).for_each(|(slot, p)| *slot = if *p == VOID { NONE } else { first + p });
            }
        }
    }

    /// Ties over all fine nodes on faces between the cells around the node.
    fn tie_around(&mut self) {
        let d = self.partition.degree();
        let strides = [1, 2 * d + 2, (2 * d + 2).pow(2)];
        for axis in 0..3 {
            let [across, along, up] = [0, 1, 2].map(|a| strides[(axis + a) % 3]);
            for (p, q) in (0..=2 * d).flat_map(|p| (0..=2 * d).map(move |q| (p, q))) {
                self.tie_at(d * across + p * along + q * up, strides);
                if self.copies == 1 {
                    return;
                }
            }
        }
    }

    /// Ties the slots that touch a fine node; `first` is the first of the cells around that node.
    fn tie_at(&mut self, first: usize, [x, y, z]: [usize; 3]) {
        let mut known = NONE;
        for cell in [0, x, y, x + y, z, x + z, y + z, x + y + z] {
            let slot = self.slots[first + cell];
            if slot == NONE || slot == known {
                continue;
            }
            if known != NONE {
                self.tie(known, slot);
            }
            known = slot;
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
