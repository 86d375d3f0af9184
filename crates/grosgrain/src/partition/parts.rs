//! The connected parts of the solid fine cells of a coarse cell.

use super::{CoarseCell, Partition};
use crate::mesh::{Cell, Lattice, Neighbourhood};

/// Names one connected part of a coarse cell; ordered by cell, then part.
///
/// A part is a largest set of solid fine cells of the coarse cell that hang together through shared fine nodes inside
/// it (26 neighbours): what shares a node moves together in the fine model. Parts are numbered by their first fine cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellPart {
    /// The coarse cell.
    pub cell: CoarseCell,
    /// Number of the part in it.
    pub part: u32,
}

impl CellPart {
    /// The only part of a coarse cell that is in one piece.
    pub const fn whole(cell: CoarseCell) -> Self {
        Self { cell, part: 0 }
    }
}

/// The part number of void fine cells.
pub(super) const VOID: u32 = u32::MAX;

/// Numbers the parts of coarse cells, with room that is used again from cell to cell.
pub(super) struct PartFinder {
    local: Lattice,
    fine: Vec<Cell>,
    part: Vec<u32>,
    front: Vec<Cell>,
}

/// The part number of a solid fine cell that has none yet.
const UNSEEN: u32 = VOID - 1;

impl PartFinder {
    pub(super) fn new(partition: &Partition) -> Self {
        Self { local: partition.cell_lattice(), fine: Vec::new(), part: Vec::new(), front: Vec::new() }
    }

    /// Writes the part number of every fine cell of `cell` into `part_of` (one entry per cell of the fine lattice) and
    /// returns how many parts there are; all solid cells are one part unless `split`.
    pub(super) fn number(
        &mut self,
        (partition, cell): (&Partition, CoarseCell),
        void: &[bool],
        split: bool,
        part_of: &mut [u32],
    ) -> u32 {
        self.fine.clear();
        self.fine.extend(partition.fine_cells(cell));
        let voids = self.fine.iter().filter(|c| void[c.0]).count();
        if voids == 0 || !split {
            self.fine.iter().for_each(|c| part_of[c.0] = if void[c.0] { VOID } else { 0 });
            return u32::from(voids < self.fine.len());
        }
        self.part.clear();
        self.part.extend(self.fine.iter().map(|c| if void[c.0] { VOID } else { UNSEEN }));
        let mut count = 0;
        for first in (0..self.part.len()).map(Cell) {
            if self.part[first.0] == UNSEEN {
                self.grow(first, count);
                count += 1;
            }
        }
        self.fine.iter().zip(&self.part).for_each(|(cell, part)| part_of[cell.0] = *part);
        count
    }

    fn grow(&mut self, first: Cell, number: u32) {
        let Self { local, part, front, .. } = self;
        part[first.0] = number;
        front.push(first);
        while let Some(cell) = front.pop() {
            Neighbourhood::Nodes.for_each(local, cell, |next| {
                if part[next.0] == UNSEEN {
                    part[next.0] = number;
                    front.push(next);
                }
            });
        }
    }
}
