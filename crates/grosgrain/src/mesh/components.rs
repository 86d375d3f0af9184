//! Connected components of the solid cells.

use super::{Cell, Lattice, Neighbourhood, VoxelGrid};

/// The connected components of the solid cells of a body.
///
/// Components are numbered from 0 in the order of their first cells (x fastest).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Components {
    component: Vec<u32>,
    sizes: Vec<usize>,
    first: Vec<Cell>,
}

const NONE: u32 = u32::MAX;

/// What a clean-up took away from a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Removed {
    /// Number of components made void.
    pub components: usize,
    /// Number of cells made void.
    pub cells: usize,
}

impl Components {
    /// The components of the cells that are not void, connected by `neighbourhood`.
    ///
    /// `void` holds one entry per cell, x fastest. Time is linear in the number of cells.
    pub fn new(void: &[bool], lattice: &Lattice, neighbourhood: Neighbourhood) -> Self {
        let mut found = Self { component: vec![NONE; void.len()], sizes: Vec::new(), first: Vec::new() };
        for c in 0..void.len() {
            if !void[c] && found.component[c] == NONE {
                found.grow(Cell(c), void, lattice, neighbourhood);
            }
        }
        found
    }

    fn grow(&mut self, first: Cell, void: &[bool], lattice: &Lattice, neighbourhood: Neighbourhood) {
        let number = self.sizes.len() as u32;
        let component = &mut self.component;
        let mut size = 1;
        component[first.0] = number;
        neighbourhood.flood(lattice, vec![first], |cell| {
            let new = !void[cell.0] && component[cell.0] == NONE;
            if new {
                component[cell.0] = number;
                size += 1;
            }
            new
        });
        self.sizes.push(size);
        self.first.push(first);
    }

    /// Number of components.
    pub fn count(&self) -> usize {
        self.sizes.len()
    }

    /// Number of cells of every component.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// First cell of every component.
    pub fn first_cells(&self) -> &[Cell] {
        &self.first
    }

    /// The component that holds `cell`, `None` for a void cell.
    pub fn of(&self, cell: Cell) -> Option<usize> {
        match self.component[cell.0] {
            NONE => None,
            number => Some(number as usize),
        }
    }

    /// The component with the most cells, the first of several; `None` for an empty body.
    pub fn largest(&self) -> Option<usize> {
        (0..self.count()).max_by_key(|&c| (self.sizes[c], std::cmp::Reverse(c)))
    }

    fn remove_others(&self, keep: &[bool], grid: &mut VoxelGrid) -> Removed {
        let mut removed = Removed::default();
        for (size, _) in self.sizes.iter().zip(keep).filter(|(_, keep)| !**keep) {
            removed.components += 1;
            removed.cells += size;
        }
        for (void, component) in grid.void.iter_mut().zip(&self.component) {
            *void |= *component != NONE && !keep[*component as usize];
        }
        removed
    }
}

/// Makes every cell void that is not in the largest face-connected component (the first of several).
pub fn keep_largest(grid: &mut VoxelGrid) -> Removed {
    let components = Components::new(&grid.void, &grid.lattice, Neighbourhood::Faces);
    let largest = components.largest();
    let keep: Vec<bool> = (0..components.count()).map(|c| Some(c) == largest).collect();
    components.remove_others(&keep, grid)
}

/// Makes every face-connected component void that has none of its nodes in `supported` (one entry per lattice node).
///
/// A component that touches a supported one along an edge or at a node only counts as floating.
pub fn remove_floating(grid: &mut VoxelGrid, supported: &[bool]) -> Removed {
    let components = Components::new(&grid.void, &grid.lattice, Neighbourhood::Faces);
    let mut keep = vec![false; components.count()];
    for cell in (0..grid.lattice.cell_count()).map(Cell) {
        if let Some(component) = components.of(cell) {
            keep[component] = keep[component] || grid.lattice.corners(cell).iter().any(|n| supported[n.0]);
        }
    }
    components.remove_others(&keep, grid)
}

#[cfg(test)]
mod tests {
    use super::super::Label;
    use super::*;
    use proptest::prelude::*;

    fn row(pattern: &str) -> VoxelGrid {
        let mut grid = VoxelGrid::uniform([pattern.len(), 1, 1], [1.0; 3], Label(1));
        grid.void = pattern.chars().map(|c| c == '.').collect();
        grid
    }

    /// Relaxes minimal labels until nothing changes: slow and plainly right.
    fn brute_force(void: &[bool], lattice: &Lattice, neighbourhood: Neighbourhood) -> Vec<usize> {
        let mut label: Vec<usize> = (0..void.len()).collect();
        loop {
            let before = label.clone();
            for c in (0..void.len()).filter(|&c| !void[c]) {
                neighbourhood.for_each(lattice, Cell(c), |n| {
                    if !void[n.0] {
                        label[c] = label[c].min(label[n.0]);
                    }
                });
            }
            if label == before {
                return label;
            }
        }
    }

    proptest! {
        #[test]
        fn components_are_those_of_a_brute_force(void in prop::collection::vec(any::<bool>(), 60), nodes in any::<bool>()) {
            let lattice = Lattice::new([5, 4, 3]);
            let neighbourhood = if nodes { Neighbourhood::Nodes } else { Neighbourhood::Faces };
            let components = Components::new(&void, &lattice, neighbourhood);
            let first = brute_force(&void, &lattice, neighbourhood);
            for c in 0..60 {
                let found = components.of(Cell(c)).map(|n| components.first_cells()[n].0);
                prop_assert_eq!(found, (!void[c]).then_some(first[c]));
            }
            prop_assert_eq!(components.sizes().iter().sum::<usize>(), void.iter().filter(|v| !**v).count());
            prop_assert!(components.first_cells().is_sorted());
        }
    }

    #[test]
    fn keep_largest_keeps_the_first_of_equals_and_reports_what_went() {
        let mut grid = row("#.##.##.");
        assert_eq!(keep_largest(&mut grid), Removed { components: 2, cells: 3 });
        assert_eq!(grid.void, row("..##....").void);
    }

    #[test]
    fn remove_floating_keeps_components_with_a_supported_node() {
        let mut grid = row("##.##.#");
        let mut supported = vec![false; grid.lattice.node_count()];
        supported[grid.lattice.node([7, 1, 1]).0] = true;
        supported[grid.lattice.node([2, 0, 0]).0] = true;
        assert_eq!(remove_floating(&mut grid, &supported), Removed { components: 1, cells: 2 });
        assert_eq!(grid.void, row("##....#").void);
    }
}
