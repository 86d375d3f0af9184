//! Which cells and interfaces a ring holds, and in what order they are eliminated.

use std::sync::Arc;

use super::cell::CellCache;
use crate::linalg::FrontalPlan;
use crate::mesh::{Cell, Lattice};
use crate::partition::CoarseCell;

/// A ring of coarse cells, clipped at the lattice.
pub(super) struct Ring<'a> {
    /// Cells of the box, x fastest; `None` where a cell is empty.
    pub members: Vec<Option<Member<'a>>>,
    pub shape: RingShape,
    /// No cell of the ring has lost or gained solid cells: the initial forces act on it from outside.
    pub unchanged: bool,
}

/// A cell of a ring.
pub(super) struct Member<'a> {
    pub cell: CoarseCell,
    pub cache: &'a CellCache,
    /// Which of the cell's interfaces tie it to other cells of the ring, in the order of `RingShape::elements`.
    pub inner: Vec<usize>,
    /// Mean rotations are tied as well.
    pub turns: bool,
}

/// What the symbolic elimination of a ring depends on.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct RingShape {
    /// Coarse cells along x, y, z.
    pub cells: [usize; 3],
    /// Number of the centre in the box.
    pub centre: usize,
    /// Largest number of rows of an interface.
    pub block: usize,
    /// Per cell of the box the numbers of the ring's interfaces that it has.
    pub elements: Vec<Vec<u32>>,
    /// Number of interfaces between cells of the ring.
    pub interfaces: usize,
}

impl<'a> Ring<'a> {
    /// A ring from the cells of its box with their caches.
    pub(super) fn new(
        cells: [usize; 3],
        centre: usize,
        caches: &[Option<(CoarseCell, &'a CellCache)>],
        (unchanged, turns): (bool, bool),
    ) -> Self {
        let place = |cell: CoarseCell| caches.iter().position(|c| c.is_some_and(|(own, _)| own == cell));
        let mut shape = RingShape { cells, centre, block: 1, elements: vec![Vec::new(); caches.len()], interfaces: 0 };
        let mut members: Vec<Option<Member<'a>>> = Vec::with_capacity(caches.len());
        for (index, entry) in caches.iter().enumerate() {
            let Some((cell, cache)) = *entry else {
                members.push(None);
                continue;
            };
            let mut inner = Vec::with_capacity(cache.interfaces.len());
            for (number, interface) in cache.interfaces.iter().enumerate() {
                let inside = interface.cells.iter().filter_map(|c| place(*c));
                let (count, first) = inside.fold((0, usize::MAX), |(n, least), p| (n + 1, least.min(p)));
                if count < 2 || interface.loads_only || interface.tied(turns) == 0 {
                    continue;
                }
                let known = members.get(first).and_then(Option::as_ref).and_then(|other| {
                    let same = |n: &usize| other.cache.interfaces[*n].is(interface);
                    other.inner.iter().position(same).map(|at| shape.elements[first][at])
                });
                shape.elements[index].push(known.unwrap_or(shape.interfaces as u32));
                shape.interfaces += usize::from(known.is_none());
                shape.block = shape.block.max(interface.tied(turns));
                inner.push(number);
            }
            members.push(Some(Member { cell, cache, inner, turns }));
        }
        Self { members, shape, unchanged }
    }

    /// Per cell of the box its parts: the group of parts that interfaces join, and whether the part is the one that holds the group, the
    /// centre's if it has any.
    pub(super) fn groups(&self) -> Vec<Vec<(usize, bool)>> {
        let mut first = vec![0];
        let parts = |m: &Option<Member<'a>>| m.as_ref().map_or(0, |m| m.cache.parts);
        self.members.iter().for_each(|m| first.push(first[first.len() - 1] + parts(m)));
        let mut group: Vec<usize> = (0..first[first.len() - 1]).collect();
        let mut owner = vec![usize::MAX; self.shape.interfaces];
        for (index, member) in self.members.iter().enumerate() {
            let Some(member) = member else { continue };
            for (&number, &id) in member.inner.iter().zip(&self.shape.elements[index]) {
                let interface = &member.cache.interfaces[number];
                let side = interface.cells.iter().position(|c| *c == member.cell).unwrap_or(0);
                let own = first[index] + interface.parts[side];
                let other = std::mem::replace(&mut owner[id as usize], own);
                if other != usize::MAX && group[own] != group[other] {
                    let (kept, gone) = (group[own], group[other]);
                    group.iter_mut().filter(|g| **g == gone).for_each(|g| *g = kept);
                }
            }
        }
        let mut held = vec![false; group.len()];
        let centre = first[self.shape.centre]..first[self.shape.centre + 1];
        let mut done = vec![false; group.len()];
        for part in centre.chain(0..group.len()) {
            held[part] |= !std::mem::replace(&mut done[group[part]], true);
        }
        let of = |i: usize| (first[i]..first[i + 1]).map(|part| (group[part], held[part])).collect();
        (0..self.members.len()).map(of).collect()
    }
}

impl RingShape {
    /// Eliminates the interfaces by halving the box of cells; those of the centre come last.
    pub(super) fn plan(&self) -> Option<Arc<FrontalPlan>> {
        let mut cells_of = vec![0u32; self.interfaces];
        for (cell, list) in self.elements.iter().enumerate() {
            list.iter().for_each(|id| cells_of[*id as usize] |= 1 << cell);
        }
        let last: Vec<u32> = self.elements[self.centre].clone();
        let plan = |leaf: usize| {
            let mut groups = Vec::new();
            self.halve([0; 3], self.cells, &cells_of, leaf, &mut groups);
            if !last.is_empty() {
                groups.push(last.clone());
            }
            FrontalPlan::new(self.interfaces, self.block, &self.elements, &groups).ok()
        };
        let plans = [1, 4, 12].into_iter().filter_map(plan);
        plans.min_by(|a, b| a.operations(F).total_cmp(&b.operations(F))).map(Arc::new)
    }

    fn halve(&self, low: [usize; 3], high: [usize; 3], cells_of: &[u32], leaf: usize, groups: &mut Vec<Vec<u32>>) {
        let lattice = Lattice::new(self.cells);
        let inside = |low: [usize; 3], high: [usize; 3]| {
            let within = |c: &usize| {
                let at = lattice.cell_position(Cell(*c));
                (0..3).all(|a| low[a] <= at[a] && at[a] < high[a])
            };
            (0..lattice.cell_count()).filter(within).fold(0u32, |mask, c| mask | 1 << c)
        };
        let mut left = inside(low, high);
        let here = |mask: u32| {
            let wanted = move |id: &u32| {
                let cells = cells_of[*id as usize];
                cells & !mask == 0 && cells >> self.centre & 1 == 0
            };
            (0..self.interfaces as u32).filter(wanted).collect::<Vec<u32>>()
        };
        let all = here(left);
        if all.is_empty() {
            return;
        }
        let size: [usize; 3] = std::array::from_fn(|a| high[a] - low[a]);
        let axis = (0..3).fold(0, |best, a| if size[a] > size[best] { a } else { best });
        if all.len() <= leaf || size[axis] == 1 {
            return groups.push(all);
        }
        let (mut middle_high, mut middle_low) = (high, low);
        middle_high[axis] = low[axis] + size[axis] / 2;
        middle_low[axis] = middle_high[axis];
        self.halve(low, middle_high, cells_of, leaf, groups);
        self.halve(middle_low, high, cells_of, leaf, groups);
        left = inside(low, middle_high);
        let right = inside(middle_low, high);
        let between = |id: &u32| cells_of[*id as usize] & !left != 0 && cells_of[*id as usize] & !right != 0;
        let separator: Vec<u32> = all.into_iter().filter(between).collect();
        if !separator.is_empty() {
            groups.push(separator);
        }
    }
}

const F: usize = crate::fine::HARMONIC_FIELDS;
