//! The elastic energy of an element, from its fine cells or as a whole.

use super::error::CorotatedError;
use super::frame::{CoarseBox, Columns, Frame, LocalCurvature, LocalForces};
use super::integration::{Integration, Rule, SharedMaterial};
use super::linear_cells::LinearCell;
use super::products::{add_restricted, gradient_map, prolong};
use crate::assembly::CellStiffness;
use crate::coarse::galerkin::{ROWS, add_congruence};
use crate::coarse::galerkin_stiffness;
use crate::coarsening::COLUMNS;
use crate::element::CellMatrix;
use crate::fine::{FineModel, InvertedCell};
use crate::linalg::matrix3::{IDENTITY, Matrix3, determinant};
use crate::material::{Matrix9, Projection};
use crate::mesh::{Cell, Lattice, Node};
use crate::partition::{CellPart, CoarseMesh};

/// A fine cell of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OwnCell {
    /// Its number in the coarse cell.
    local: u32,
    material: u32,
    /// Factor of the material's moduli.
    factor: f64,
}

/// What an element keeps of its fine cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ElementCells {
    /// Whether the element has a frame that rotates: some material is meant for large displacements.
    pub rotates: bool,
    /// Cells of large displacement. Empty, like the next, where the energy is that of the whole stiffness.
    nonlinear: Vec<OwnCell>,
    /// Cells of small displacement in an element that rotates.
    linear: Vec<OwnCell>,
    /// Quadratic part of the energy.
    quadratic: Quadratic,
}

#[derive(Clone, Debug, PartialEq)]
enum Quadratic {
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
    pub rule: Rule,
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
        let (linear, nonlinear): (Vec<OwnCell>, Vec<OwnCell>) = cells.partition(is_linear);
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

/// Room for the fine nodes of an element.
pub(super) struct Workspace {
    /// W v.
    displacement: Vec<f64>,
    forces: Vec<f64>,
}

impl Workspace {
    /// Room for elements with `rows` rows of W.
    pub fn new(rows: usize) -> Self {
        Self { displacement: vec![0.0; rows], forces: vec![0.0; rows] }
    }
}

/// An element with what its energy depends on.
#[derive(Clone, Copy)]
pub(super) struct ElasticElement<'a> {
    pub shared: &'a Shared,
    pub cells: &'a ElementCells,
    /// W.
    pub functions: &'a [f64],
    /// Stiffness of the coarse model.
    pub stiffness: &'a CellMatrix,
    /// The fine lattice, and where the coarse cell starts in it.
    pub fine: Lattice,
    pub start: [usize; 3],
}

impl ElasticElement<'_> {
    fn quadratic(&self) -> Option<&CellMatrix> {
        match &self.cells.quadratic {
            Quadratic::Whole => Some(self.stiffness),
            Quadratic::Stabilisation(matrix) => Some(matrix),
            Quadratic::Nothing => None,
        }
    }

    /// Whether fine cells have to be visited.
    fn has_cells(&self) -> bool {
        !self.cells.nonlinear.is_empty() || !self.cells.linear.is_empty()
    }

    /// Elastic energy \[J\]; adds the first derivatives to `forces` where they are wanted.
    pub fn energy(
        &self,
        frame: &Frame,
        room: &mut Workspace,
        forces: Option<&mut LocalForces>,
    ) -> Result<f64, CorotatedError> {
        let mut total = LocalForces::ZERO;
        let mut energy =
            self.quadratic().map_or(0.0, |matrix| add_quadratic(matrix, &frame.local, &mut total.gradient));
        if self.has_cells() {
            prolong(self.functions, &frame.local, &mut room.displacement);
            room.forces.fill(0.0);
            for cell in &self.cells.nonlinear {
                energy += self.cell_energy(cell, room, forces.is_some())?;
            }
            for cell in &self.cells.linear {
                let linear = self.linear_cell(cell, room);
                let (part, at_corners) = linear.energy(frame);
                energy += part;
                let couple = linear.couple(&at_corners);
                (0..3).for_each(|k| total.couple[k] += couple[k]);
                self.scatter(cell, &at_corners, room);
            }
            if forces.is_some() {
                add_restricted(self.functions, &room.forces, &mut total.gradient);
            }
        }
        if let Some(forces) = forces {
            forces.gradient.iter_mut().zip(total.gradient).for_each(|(sum, g)| *sum += g);
            forces.couple.iter_mut().zip(total.couple).for_each(|(sum, c)| *sum += c);
        }
        Ok(energy)
    }

    fn cell_energy(&self, cell: &OwnCell, room: &mut Workspace, with_forces: bool) -> Result<f64, CorotatedError> {
        let law = &self.shared.materials[cell.material as usize].law;
        let moved = self.gather(cell, room);
        let mut energy = 0.0;
        let mut at_corners = [[0.0; 3]; 8];
        for (weight, slopes) in &self.shared.rule {
            let f = deformation_gradient(&moved, slopes);
            let factor = weight * cell.factor;
            if !with_forces {
                energy += factor * law.energy(&f).ok_or_else(|| self.inverted(cell, &moved))?;
                continue;
            }
            let (density, stress) = law.stress(&f).ok_or_else(|| self.inverted(cell, &moved))?;
            energy += factor * density;
            add_stress(factor, &stress, slopes, &mut at_corners);
        }
        if with_forces {
            self.scatter(cell, &at_corners, room);
        }
        Ok(energy)
    }

    /// Adds the first and second derivatives.
    pub fn add_curvature(
        &self,
        frame: &Frame,
        room: &mut Workspace,
        projection: Projection,
        (forces, curvature): (&mut LocalForces, &mut LocalCurvature),
    ) -> Result<(), CorotatedError> {
        if let Some(matrix) = self.quadratic() {
            add_quadratic(matrix, &frame.local, &mut forces.gradient);
            curvature.stiffness.iter_mut().flatten().zip(matrix).for_each(|(sum, k)| *sum += k);
        }
        if !self.has_cells() {
            return Ok(());
        }
        prolong(self.functions, &frame.local, &mut room.displacement);
        room.forces.fill(0.0);
        // The cells write the upper triangle only.
        let mut of_cells = LocalCurvature::ZERO;
        for cell in &self.cells.nonlinear {
            self.add_cell_curvature(cell, room, projection, &mut of_cells.stiffness)?;
        }
        for cell in &self.cells.linear {
            let linear = self.linear_cell(cell, room);
            let (_, at_corners) = linear.energy(frame);
            let couple = linear.couple(&at_corners);
            (0..3).for_each(|k| forces.couple[k] += couple[k]);
            self.scatter(cell, &at_corners, room);
            linear.add_curvature(frame, &self.rows(cell), (&at_corners, projection), &mut of_cells);
        }
        add_restricted(self.functions, &room.forces, &mut forces.gradient);
        for (a, b) in (0..COLUMNS).flat_map(|a| (0..COLUMNS).map(move |b| (a, b))) {
            curvature.stiffness[a][b] += of_cells.stiffness[a.min(b)][a.max(b)];
        }
        curvature.mixed.iter_mut().flatten().zip(of_cells.mixed.iter().flatten()).for_each(|(sum, b)| *sum += b);
        let rotational = of_cells.rotational.iter().flatten();
        curvature.rotational.iter_mut().flatten().zip(rotational).for_each(|(sum, c)| *sum += c);
        Ok(())
    }

    fn add_cell_curvature(
        &self,
        cell: &OwnCell,
        room: &mut Workspace,
        projection: Projection,
        stiffness: &mut [Columns; COLUMNS],
    ) -> Result<(), CorotatedError> {
        let law = &self.shared.materials[cell.material as usize].law;
        let moved = self.gather(cell, room);
        let rows = self.rows(cell);
        let mut at_corners = [[0.0; 3]; 8];
        let mut of_cell = [0.0; COLUMNS * COLUMNS];
        let single = self.shared.rule.len() == 1;
        for (weight, slopes) in &self.shared.rule {
            let f = deformation_gradient(&moved, slopes);
            let factor = weight * cell.factor;
            let (_, stress, tangent) = law.tangent(&f, projection).ok_or_else(|| self.inverted(cell, &moved))?;
            add_stress(factor, &stress, slopes, &mut at_corners);
            match single {
                true => add_congruence::<9, 9>(factor, tangent.as_flattened(), &gradient_map(&rows, slopes), stiffness),
                false => add_tangent(factor, &tangent, slopes, &mut of_cell),
            }
        }
        if !single {
            add_congruence::<COLUMNS, ROWS>(1.0, &of_cell, &rows, stiffness);
        }
        self.scatter(cell, &at_corners, room);
        Ok(())
    }

    fn corners(&self, cell: &OwnCell) -> [Node; 8] {
        self.shared.lattice.corners(Cell(cell.local as usize))
    }

    /// (W v)_a at the corners of a cell.
    fn gather(&self, cell: &OwnCell, room: &Workspace) -> Columns {
        let corners = self.corners(cell);
        std::array::from_fn(|n| room.displacement[3 * corners[n / 3].0 + n % 3])
    }

    /// Adds forces on the corners of a cell to those on the fine nodes.
    fn scatter(&self, cell: &OwnCell, forces: &[[f64; 3]; 8], room: &mut Workspace) {
        for (node, force) in self.corners(cell).iter().zip(forces) {
            (0..3).for_each(|r| room.forces[3 * node.0 + r] += force[r]);
        }
    }

    /// The rows of W at the corners of a cell.
    fn rows(&self, cell: &OwnCell) -> [Columns; COLUMNS] {
        let mut rows = [[0.0; COLUMNS]; COLUMNS];
        for (three, node) in rows.chunks_exact_mut(3).zip(self.corners(cell)) {
            three.as_flattened_mut().copy_from_slice(&self.functions[3 * COLUMNS * node.0..][..3 * COLUMNS]);
        }
        rows
    }

    fn linear_cell(&self, cell: &OwnCell, room: &Workspace) -> LinearCell<'_> {
        let lattice = self.shared.lattice;
        let place = |node: Node| self.shared.cell.node(lattice.node_position(node), lattice.cells[0]);
        LinearCell {
            stiffness: (&self.shared.materials[cell.material as usize].stiffness, cell.factor),
            corners: self.corners(cell).map(place),
            moved: self.gather(cell, room),
        }
    }

    fn inverted(&self, cell: &OwnCell, moved: &Columns) -> CorotatedError {
        let inside = self.shared.lattice.cell_position(Cell(cell.local as usize));
        let at = std::array::from_fn(|a| self.start[a] + inside[a]);
        let of_point = |(_, slopes): &(f64, [[f64; 3]; 8])| determinant(&deformation_gradient(moved, slopes));
        let smallest = self.shared.rule.iter().map(of_point).reduce(|a, b| if a.is_nan() || a < b { a } else { b });
        InvertedCell { cell: self.fine.cell(at), at, determinant: smallest.unwrap_or(f64::NAN) }.into()
    }
}

/// g += K v; returns ½ v·K v.
fn add_quadratic(matrix: &CellMatrix, v: &Columns, gradient: &mut Columns) -> f64 {
    let mut product = [0.0; COLUMNS];
    // Columns instead of rows, because K is symmetric: so the sums run over vectors.
    for (column, v) in matrix.chunks_exact(COLUMNS).zip(v) {
        product.iter_mut().zip(column).for_each(|(sum, k)| *sum += k * v);
    }
    gradient.iter_mut().zip(product).for_each(|(g, f)| *g += f);
    0.5 * product.iter().zip(v).map(|(f, v)| f * v).sum::<f64>()
}

/// F = I + Σ_a u_a ⊗ ∇N_a.
fn deformation_gradient(moved: &Columns, slopes: &[[f64; 3]; 8]) -> Matrix3 {
    let mut f = IDENTITY;
    for (u, slope) in moved.chunks_exact(3).zip(slopes) {
        (0..9).for_each(|n| f[n / 3][n % 3] += u[n / 3] * slope[n % 3]);
    }
    f
}

/// f_a += factor P ∇N_a.
fn add_stress(factor: f64, stress: &Matrix3, slopes: &[[f64; 3]; 8], forces: &mut [[f64; 3]; 8]) {
    for (force, slope) in forces.iter_mut().zip(slopes) {
        let scaled = slope.map(|s| factor * s);
        (0..9).for_each(|n| force[n / 3] += stress[n / 3][n % 3] * scaled[n % 3]);
    }
}

/// Adds factor Σ ∇N_a,j (∂P_ij/∂F_kl) ∇N_b,l to row 3 a + i and column 3 b + k of a cell's matrix.
fn add_tangent(factor: f64, tangent: &Matrix9, slopes: &[[f64; 3]; 8], matrix: &mut CellMatrix) {
    let mut half = [[0.0; COLUMNS]; 9];
    for (row, entries) in half.iter_mut().zip(tangent) {
        for (three, slope) in row.chunks_exact_mut(3).zip(slopes) {
            for k in 0..3 {
                let t = &entries[3 * k..3 * k + 3];
                three[k] = factor * (t[0] * slope[0] + t[1] * slope[1] + t[2] * slope[2]);
            }
        }
    }
    for (rows, slope) in matrix.chunks_exact_mut(3 * COLUMNS).zip(slopes) {
        for (i, row) in rows.chunks_exact_mut(COLUMNS).enumerate() {
            for c in 0..COLUMNS {
                row[c] += slope[0] * half[3 * i][c] + slope[1] * half[3 * i + 1][c] + slope[2] * half[3 * i + 2][c];
            }
        }
    }
}
