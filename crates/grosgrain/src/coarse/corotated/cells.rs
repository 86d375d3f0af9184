//! What a coarse element keeps of its fine cells.

use super::frame::CoarseBox;
use super::integration::{Integration, SharedMaterial};
use crate::assembly::CellStiffness;
use crate::coarse::galerkin_stiffness;
use crate::element::CellMatrix;
use crate::fine::{FineModel, SingleCell};
use crate::mesh::{Cell, Lattice};
use crate::partition::{CellPart, CoarseMesh};

/// A fine cell of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OwnCell {
    /// Its number in the coarse cell.
    pub local: u32,
    /// Index of its material.
    pub material: u32,
    /// Factor of the material's moduli.
    pub factor: f64,
}

/// What an element keeps of its fine cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ElementCells {
    /// Whether the element has a frame that rotates: some material is meant for large displacements.
    pub rotates: bool,
    /// Cells of large displacement, by material. Empty, like the next, where the energy is that of the whole stiffness.
    pub nonlinear: Vec<OwnCell>,
    /// Cells of small displacement in an element that rotates.
    pub linear: Vec<OwnCell>,
    /// Quadratic part of the energy.
    pub quadratic: Quadratic,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Quadratic {
    /// The stiffness of the coarse model.
    Whole,
    /// What one point per fine cell leaves out.
    Stabilisation(Box<CellMatrix>),
    /// None.
    Nothing,
}

/// What all elements share.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    pub cell: CoarseBox,
    pub integration: Integration,
    /// The points of a fine cell.
    pub fine_cell: SingleCell,
    pub materials: Vec<SharedMaterial>,
    /// Lattice of the fine cells of a coarse cell.
    pub lattice: Lattice,
}

/// The cells of an element as a lattice, with what their centres do not see as stiffness.
struct UnseenByCentres<'a> {
    lattice: Lattice,
    cells: Vec<Option<(f64, &'a CellMatrix)>>,
}

impl CellStiffness for UnseenByCentres<'_> {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        self.cells[cell]
    }
}

impl ElementCells {
    /// The cells of `element`, whose shape functions are `functions`.
    pub fn new(fine: &FineModel, mesh: &CoarseMesh, (element, functions): (CellPart, &[f64]), shared: &Shared) -> Self {
        let own = |(local, cell): (usize, Cell)| {
            let (material, factor) = fine.material_of(cell)?;
            Some(OwnCell { local: local as u32, material: material as u32, factor })
        };
        let is_linear = |cell: &OwnCell| shared.materials[cell.material as usize].is_linear();
        let cells = mesh.fine_cells(element).filter_map(own);
        let (linear, mut nonlinear): (Vec<OwnCell>, Vec<OwnCell>) = cells.partition(is_linear);
        nonlinear.sort_by_key(|cell| cell.material);
        let rotates = !nonlinear.is_empty();
        let quadratic = match shared.integration {
            Integration::Gauss if rotates => Quadratic::Nothing,
            Integration::Centre if rotates => {
                let mut cells = vec![None; shared.lattice.cell_count()];
                for cell in &nonlinear {
                    let material = &shared.materials[cell.material as usize];
                    cells[cell.local as usize] = Some((cell.factor, &material.unseen_by_centre));
                }
                let unseen = UnseenByCentres { lattice: shared.lattice, cells };
                Quadratic::Stabilisation(Box::new(galerkin_stiffness(&unseen, functions)))
            }
            _ => return Self { rotates, nonlinear: Vec::new(), linear: Vec::new(), quadratic: Quadratic::Whole },
        };
        Self { rotates, nonlinear, linear, quadratic }
    }
}
