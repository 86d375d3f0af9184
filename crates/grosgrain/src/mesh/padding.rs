//! Growing a grid by void cells to a multiple of the coarsening degree, and cutting it to its body.

use super::{Cell, Label, Lattice, VoxelGrid, VoxelGridError};

/// A grid grown by void cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Padding {
    /// The grown grid.
    pub grid: VoxelGrid,
    /// Number of cell layers added at the max end of x, y, z.
    pub added: [usize; 3],
}

/// A grid cut to the box of its body.
#[derive(Clone, Debug, PartialEq)]
pub struct Crop {
    /// The cut grid; its origin has moved by the offset.
    pub grid: VoxelGrid,
    /// Position of its first cell in the uncut grid.
    pub offset: [usize; 3],
}

/// Adds layers of void cells labelled `label` at the max ends until `degree` divides the number of cells of every axis.
///
/// The origin stays. A degree of 0 or 1 leaves the grid as it is.
pub fn pad_to_multiple(grid: &VoxelGrid, degree: usize, label: Label) -> Padding {
    let cells = grid.lattice.cells.map(|n| n.next_multiple_of(degree.max(1)));
    let added = std::array::from_fn(|a| cells[a] - grid.lattice.cells[a]);
    Padding { grid: window(grid, [0; 3], cells, label), added }
}

/// Cuts the grid to the smallest box of cells that holds every solid one.
///
/// # Errors
/// [`VoxelGridError::AllVoid`] if there is none.
pub fn crop_to_body(grid: &VoxelGrid) -> Result<Crop, VoxelGridError> {
    let [low, high] = grid.body_box().ok_or(VoxelGridError::AllVoid)?;
    let cells = std::array::from_fn(|a| high[a] - low[a]);
    Ok(Crop { grid: window(grid, low, cells, Label(0)), offset: low })
}

/// The box of `cells` from the cell `from` on; void cells of `label` where it leaves the grid.
fn window(grid: &VoxelGrid, from: [usize; 3], cells: [usize; 3], label: Label) -> VoxelGrid {
    let lattice = Lattice::new(cells);
    let source: Vec<Option<Cell>> = (0..lattice.cell_count())
        .map(|c| grid.lattice.neighbour(from, lattice.cell_position(Cell(c)).map(|i| i as isize)))
        .collect();
    let field = |values: &Vec<f64>| pick(&source, values, 0.0);
    VoxelGrid {
        lattice,
        spacing: grid.spacing,
        origin: grid.position(from),
        labels: pick(&source, &grid.labels, label),
        void: pick(&source, &grid.void, true),
        young: grid.young.as_ref().map(field),
        density: grid.density.as_ref().map(field),
    }
}

fn pick<T: Copy>(source: &[Option<Cell>], values: &[T], outside: T) -> Vec<T> {
    source.iter().map(|cell| cell.map_or(outside, |c| values[c.0])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn padding_reports_the_layers_and_labels_them() {
        let grid = VoxelGrid::uniform([5, 4, 3], [1.0; 3], Label(1));
        let padding = pad_to_multiple(&grid, 4, Label(9));
        assert_eq!(padding.added, [3, 0, 1]);
        assert_eq!(padding.grid.lattice.cells, [8, 4, 4]);
        let corner = padding.grid.lattice.cell([7, 3, 3]).0;
        assert_eq!((padding.grid.labels[corner], padding.grid.void[corner]), (Label(9), true));
        assert_eq!(pad_to_multiple(&grid, 0, Label(9)).grid, grid);
    }

    #[test]
    fn cropping_moves_the_origin_by_the_offset() {
        let mut grid = VoxelGrid::uniform([4, 4, 4], [0.5, 1.0, 2.0], Label(1));
        grid.origin = [1.0; 3];
        grid.void.fill(true);
        assert_eq!(crop_to_body(&grid), Err(VoxelGridError::AllVoid));
        grid.void[grid.lattice.cell([1, 2, 3]).0] = false;
        let crop = crop_to_body(&grid).unwrap();
        assert_eq!((crop.offset, crop.grid.lattice.cells), ([1, 2, 3], [1; 3]));
        assert_eq!(crop.grid.origin, [1.5, 3.0, 7.0]);
    }

    proptest! {
        #[test]
        fn cropping_undoes_padding(
            cells in [1..5usize, 1..5, 1..5], degree in 1..6usize, voids in prop::collection::vec(any::<bool>(), 64)
        ) {
            let mut grid = VoxelGrid::uniform(cells, [1.0, 2.0, 3.0], Label(1));
            let n = grid.lattice.cell_count();
            grid.void.copy_from_slice(&voids[..n]);
            grid.void[0] = false;
            grid.void[n - 1] = false;
            grid.labels = (0..n as i32).map(Label).collect();
            grid.young = Some((0..n).map(|c| 1.0 + c as f64).collect());
            let padding = pad_to_multiple(&grid, degree, Label(-1));
            for a in 0..3 {
                prop_assert_eq!(padding.grid.lattice.cells[a] % degree, 0);
                prop_assert!(padding.added[a] < degree);
            }
            let crop = crop_to_body(&padding.grid).unwrap();
            prop_assert_eq!(crop.offset, [0; 3]);
            prop_assert_eq!(crop.grid, grid);
        }
    }
}
