//! Changing single cells of a fine model, and changing them back.

use super::FineModel;
use super::model::{VOID, factor_of, own_young};
use crate::material::Material;
use crate::mesh::{Cell, Label};

/// What a cell of a fine model is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellState {
    /// Its label.
    pub label: Label,
    /// Whether it is void.
    pub void: bool,
    /// Its own Young modulus \[Pa\]; `None` for that of the label's material.
    pub young: Option<f64>,
    /// Its own density \[kg/m³\]; `None` for that of the label's material.
    pub density: Option<f64>,
}

/// Why a cell cannot become what it is to be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ChangeError {
    /// There is no such cell.
    #[error("cell {cell} is outside of the grid of {} x {} x {} cells; the last one is {}", cells[0], cells[1], cells[2], cells[0] * cells[1] * cells[2] - 1)]
    Outside {
        /// Its index.
        cell: usize,
        /// Cells along x, y, z.
        cells: [usize; 3],
    },
    /// A solid cell of a label that stands for nothing.
    #[error("label {label} has no material; the model knows {known}")]
    NoMaterial {
        /// The label.
        label: Label,
        /// The labels with their materials' names, as text.
        known: String,
    },
    /// A modulus that is none.
    #[error("a Young modulus of {0} Pa was asked for; it must be positive and finite")]
    Young(f64),
    /// A density that is none.
    #[error("a density of {density} kg/m³ was asked for {what}; it must be positive and finite")]
    Density {
        /// What for.
        what: String,
        /// The density.
        density: f64,
    },
    /// A density for one cell of a body that has them from its materials.
    #[error("a density was given for a single cell, but the body's densities come from its materials; leave it out")]
    NoDensities,
    /// A modulus for a cell of an anisotropic material.
    #[error(
        "material \"{name}\" is given by a stiffness matrix, which a Young modulus cannot replace; set a material with young and poisson first"
    )]
    Anisotropic {
        /// The material's name.
        name: String,
    },
    /// Nothing would be left.
    #[error("the change would leave no solid cell; keep a part of the body")]
    AllVoid,
}

impl FineModel {
    /// What a cell is. On a body with moduli or densities per voxel these are always given.
    pub fn state(&self, cell: Cell) -> CellState {
        let at = |field: &Option<Vec<f64>>| field.as_ref().map(|values| values[cell.0]);
        CellState {
            label: self.grid.labels[cell.0],
            void: self.grid.void[cell.0],
            young: at(&self.grid.young),
            density: at(&self.grid.density),
        }
    }

    /// Young's modulus \[Pa\] that a solid cell would have in this state, for an anisotropic material 1 / S₁₁; zero for a void
    /// and where the label has no material.
    pub fn young_of(&self, state: &CellState) -> f64 {
        match self.material(state.label) {
            Some(material) if !state.void => state.young.unwrap_or_else(|| own_young(material)),
            _ => 0.0,
        }
    }

    /// Density \[kg/m³\] that a cell would have in this state; zero for a void and where the label has no material.
    pub fn density_of(&self, state: &CellState) -> f64 {
        match self.material(state.label) {
            Some(material) if !state.void => state.density.unwrap_or(material.density),
            _ => 0.0,
        }
    }

    /// Whether a cell can be set to a state.
    ///
    /// # Errors
    /// A cell outside of the grid; for a solid state a label without a material, a modulus or density that is not positive and
    /// finite, a modulus for an anisotropic material other than its own, a density on a body without densities per voxel.
    pub fn check(&self, cell: Cell, state: &CellState) -> Result<(), ChangeError> {
        let lattice = self.grid.lattice;
        if cell.0 >= lattice.cell_count() {
            return Err(ChangeError::Outside { cell: cell.0, cells: lattice.cells });
        }
        if state.density.is_some() && self.grid.density.is_none() {
            return Err(ChangeError::NoDensities);
        }
        if state.void {
            return Ok(());
        }
        let Some(material) = self.material(state.label) else {
            return Err(ChangeError::NoMaterial { label: state.label, known: self.known_labels() });
        };
        let young = state.young.unwrap_or_else(|| own_young(material));
        if !is_positive(young) {
            return Err(ChangeError::Young(young));
        }
        if factor_of(material, young).is_none() {
            return Err(ChangeError::Anisotropic { name: material.name.clone() });
        }
        let density = state.density.unwrap_or(material.density);
        match self.grid.density.is_none() || is_positive(density) {
            true => Ok(()),
            false => Err(ChangeError::Density { what: format!("material \"{}\"", material.name), density }),
        }
    }

    /// Sets cells to states and appends what they were before to `previous`, for [`restore`](Self::restore).
    ///
    /// A cell named twice ends in its last state. Afterwards the model is that which [`FineModel::new`] makes of the changed grid.
    /// Only the named cells and the eight cells around each of their nodes are looked at, and only `previous` can grow. The first
    /// modulus for a cell of a body without moduli per voxel gives the grid one per voxel, those of the materials (zero for voids):
    /// once a pass over all cells, and they stay when the change is undone.
    ///
    /// # Errors
    /// What [`check`](Self::check) finds, or no solid cell would be left. The model and `previous` are then as they were.
    pub fn change(
        &mut self,
        changes: &[(Cell, CellState)],
        previous: &mut Vec<(Cell, CellState)>,
    ) -> Result<(), ChangeError> {
        changes.iter().try_for_each(|(cell, state)| self.check(*cell, state))?;
        let gives_moduli = self.grid.young.is_none() && changes.iter().any(|(_, s)| s.young.is_some() && !s.void);
        if gives_moduli {
            self.give_moduli();
        }
        let start = previous.len();
        for (cell, state) in changes {
            previous.push((*cell, self.state(*cell)));
            self.set(*cell, state);
        }
        if self.solid == 0 {
            if gives_moduli {
                self.grid.young = None;
                self.factors.fill(1.0);
            }
            self.put_back(&previous[start..]);
            previous.truncate(start);
            return Err(ChangeError::AllVoid);
        }
        self.refresh_active(changes);
        Ok(())
    }

    /// Sets cells back to the states that [`change`](Self::change) has appended, the last one first.
    ///
    /// # Errors
    /// What [`check`](Self::check) finds, the model is then as it was; nothing for what `change` has appended.
    pub fn restore(&mut self, previous: &[(Cell, CellState)]) -> Result<(), ChangeError> {
        previous.iter().try_for_each(|(cell, state)| self.check(*cell, state))?;
        self.put_back(previous);
        self.refresh_active(previous);
        Ok(())
    }

    /// The materials of the model by label, ascending; also of labels that no cell has.
    pub fn materials(&self) -> &[(Label, Material)] {
        &self.materials
    }

    /// Number of cells that are not void.
    pub fn solid_count(&self) -> usize {
        self.solid
    }

    fn put_back(&mut self, previous: &[(Cell, CellState)]) {
        previous.iter().rev().for_each(|(cell, state)| self.set(*cell, state));
    }

    fn index_of(&self, label: Label) -> Option<usize> {
        self.materials.binary_search_by_key(&label, |(l, _)| *l).ok()
    }

    /// The material that a label stands for.
    pub fn material(&self, label: Label) -> Option<&Material> {
        self.index_of(label).map(|m| &self.materials[m].1)
    }

    fn known_labels(&self) -> String {
        let names: Vec<String> = self.materials.iter().map(|(label, m)| format!("{label} ({})", m.name)).collect();
        names.join(", ")
    }

    fn set(&mut self, cell: Cell, state: &CellState) {
        let c = cell.0;
        let index = self.index_of(state.label);
        let material = index.map(|m| &self.materials[m].1);
        self.solid = self.solid + usize::from(self.grid.void[c]) - usize::from(state.void);
        (self.grid.labels[c], self.grid.void[c]) = (state.label, state.void);
        if let Some(density) = &mut self.grid.density {
            density[c] = state.density.or(material.map(|m| m.density)).unwrap_or(0.0);
        }
        let young = state.young.or(material.map(own_young)).unwrap_or(0.0);
        if let Some(moduli) = &mut self.grid.young {
            moduli[c] = young;
        }
        self.material_of[c] = if state.void { VOID } else { index.map_or(VOID, |m| m as u16) };
        let per_voxel = self.grid.young.is_some();
        self.factors[c] = match material.filter(|_| per_voxel && !state.void) {
            Some(material) => factor_of(material, young).unwrap_or(1.0),
            None if per_voxel => 0.0,
            None => 1.0,
        };
    }

    fn refresh_active(&mut self, changes: &[(Cell, CellState)]) {
        let lattice = self.grid.lattice;
        for node in changes.iter().flat_map(|(cell, _)| lattice.corners(*cell)) {
            self.active[node.0] = lattice.cells_at(node).any(|c| !self.grid.void[c.0]);
        }
    }

    /// Writes the modulus of every cell into the grid. The factors of solid cells stay one, those of voids become zero.
    fn give_moduli(&mut self) {
        let young =
            |cell: usize| self.materials.get(usize::from(self.material_of[cell])).map_or(0.0, |(_, m)| own_young(m));
        self.grid.young = Some((0..self.material_of.len()).map(young).collect());
        let voids = self.factors.iter_mut().zip(&self.material_of).filter(|(_, material)| **material == VOID);
        voids.for_each(|(factor, _)| *factor = 0.0);
    }
}

fn is_positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}
