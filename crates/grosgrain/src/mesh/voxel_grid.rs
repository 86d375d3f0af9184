//! A voxel body: labels, voids, optional per-voxel modulus and density.

use super::{Cell, Lattice, Node};

/// The label of a voxel: what the scene's materials are looked up by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Label(pub i32);

impl std::fmt::Display for Label {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// A body on a voxel lattice; every voxel has its own material.
///
/// A void voxel has no stiffness and no mass, whatever its label says. Where `young` is given it holds one
/// modulus per voxel and replaces the one of the label's material; likewise `density`.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelGrid {
    /// Number of voxels along x, y, z.
    pub lattice: Lattice,
    /// Edge lengths of a voxel \[m\].
    pub spacing: [f64; 3],
    /// Position of the lattice's node (0, 0, 0) \[m\].
    pub origin: [f64; 3],
    /// One label per voxel, x fastest.
    pub labels: Vec<Label>,
    /// Which voxels are void, x fastest.
    pub void: Vec<bool>,
    /// Young's modulus per voxel \[Pa\], replacing the material's.
    pub young: Option<Vec<f64>>,
    /// Density per voxel \[kg/m³\], replacing the material's.
    pub density: Option<Vec<f64>>,
}

/// Why a voxel body is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VoxelGridError {
    /// The lattice has no cells.
    #[error("the grid has no cells: {0:?} along x, y, z; every count must be at least 1")]
    Empty([usize; 3]),
    /// A spacing is zero, negative or not finite.
    #[error("the voxel spacing {0:?} m must be positive and finite along every axis")]
    Spacing([f64; 3]),
    /// A field has the wrong number of entries.
    #[error("{field} holds {found} values where the grid has {expected} voxels")]
    Length {
        /// The field's name.
        field: &'static str,
        /// How many it holds.
        found: usize,
        /// How many it must hold.
        expected: usize,
    },
    /// A modulus or density of a solid voxel is not a positive finite number.
    #[error("{field} of voxel ({}, {}, {}) is {value}; it must be positive and finite", at[0], at[1], at[2])]
    Value {
        /// The field's name.
        field: &'static str,
        /// The voxel's position.
        at: [usize; 3],
        /// The offending value.
        value: f64,
    },
    /// No voxel is solid.
    #[error("every voxel of the body is void: check the thresholds or labels, nothing is left to simulate")]
    AllVoid,
}

impl VoxelGrid {
    /// A solid grid with one label everywhere and its origin at zero.
    pub fn uniform(cells: [usize; 3], spacing: [f64; 3], label: Label) -> Self {
        let lattice = Lattice::new(cells);
        let n = lattice.cell_count();
        Self {
            lattice,
            spacing,
            origin: [0.0; 3],
            labels: vec![label; n],
            void: vec![false; n],
            young: None,
            density: None,
        }
    }

    /// Position of the lattice node (i, j, k) \[m\].
    pub fn position(&self, at: [usize; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.origin[a] + self.spacing[a] * at[a] as f64)
    }

    /// Centre of the voxel (i, j, k) \[m\].
    pub fn centre(&self, at: [usize; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.origin[a] + self.spacing[a] * (at[a] as f64 + 0.5))
    }

    /// Volume of one voxel \[m³\].
    pub fn cell_volume(&self) -> f64 {
        self.spacing.iter().product()
    }

    /// Number of voxels that are not void.
    pub fn solid_count(&self) -> usize {
        self.void.iter().filter(|v| !**v).count()
    }

    /// Which lattice nodes touch a solid voxel: those that have unknowns, x fastest.
    pub fn active_nodes(&self) -> Vec<bool> {
        let mut active = vec![false; self.lattice.node_count()];
        for c in (0..self.void.len()).filter(|&c| !self.void[c]) {
            self.lattice.corners(Cell(c)).iter().for_each(|n: &Node| active[n.0] = true);
        }
        active
    }

    /// First and last node of the body along x, y, z as lattice positions; `None` if every voxel is void.
    pub fn body_box(&self) -> Option<[[usize; 3]; 2]> {
        let solid = (0..self.void.len()).filter(|&c| !self.void[c]);
        solid.map(|c| self.lattice.cell_position(Cell(c))).fold(None, |range, at| {
            let [low, high] = range.unwrap_or([at, at]);
            Some([std::array::from_fn(|a| at[a].min(low[a])), std::array::from_fn(|a: usize| (at[a] + 1).max(high[a]))])
        })
    }

    /// Refuses grids that no model can be built on.
    ///
    /// # Errors
    /// Empty lattice, bad spacing, fields of the wrong length, moduli or densities of solid voxels that are
    /// not positive and finite, a body without a solid voxel.
    pub fn validate(&self) -> Result<(), VoxelGridError> {
        let expected = self.lattice.cell_count();
        if expected == 0 {
            return Err(VoxelGridError::Empty(self.lattice.cells));
        }
        if !self.spacing.iter().all(|h| h.is_finite() && *h > 0.0) {
            return Err(VoxelGridError::Spacing(self.spacing));
        }
        check_length("labels", self.labels.len(), expected)?;
        check_length("void", self.void.len(), expected)?;
        self.validate_field("the Young modulus", self.young.as_deref())?;
        self.validate_field("the density", self.density.as_deref())?;
        match self.solid_count() {
            0 => Err(VoxelGridError::AllVoid),
            _ => Ok(()),
        }
    }

    fn validate_field(&self, field: &'static str, values: Option<&[f64]>) -> Result<(), VoxelGridError> {
        let Some(values) = values else { return Ok(()) };
        check_length(field, values.len(), self.lattice.cell_count())?;
        let usable = |value: f64| value.is_finite() && value > 0.0;
        let bad = (0..values.len()).find(|&c| !self.void[c] && !usable(values[c]));
        match bad {
            None => Ok(()),
            Some(c) => Err(VoxelGridError::Value { field, at: self.lattice.cell_position(Cell(c)), value: values[c] }),
        }
    }
}

fn check_length(field: &'static str, found: usize, expected: usize) -> Result<(), VoxelGridError> {
    match found == expected {
        true => Ok(()),
        false => Err(VoxelGridError::Length { field, found, expected }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_body_box_and_the_active_nodes_are_those_of_the_solid_voxels() {
        let mut grid = VoxelGrid::uniform([4, 3, 2], [1.0, 2.0, 3.0], Label(1));
        grid.void.fill(true);
        assert_eq!(grid.body_box(), None);
        grid.void[grid.lattice.cell([2, 1, 0]).0] = false;
        assert_eq!(grid.body_box(), Some([[2, 1, 0], [3, 2, 1]]));
        let active = grid.active_nodes();
        assert_eq!(active.iter().filter(|a| **a).count(), 8);
        assert!(grid.lattice.corners(grid.lattice.cell([2, 1, 0])).iter().all(|n| active[n.0]));
    }

    #[test]
    fn bad_values_of_solid_voxels_are_named_and_those_of_voids_ignored() {
        let mut grid = VoxelGrid::uniform([2, 1, 1], [1.0; 3], Label(1));
        grid.young = Some(vec![1.0, -1.0]);
        let error = grid.validate().unwrap_err();
        assert_eq!(error.to_string(), "the Young modulus of voxel (1, 0, 0) is -1; it must be positive and finite");
        grid.void[1] = true;
        assert_eq!(grid.validate(), Ok(()));
    }
}
