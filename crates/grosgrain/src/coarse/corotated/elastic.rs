//! The elastic energy of a coarse element, from its fine cells or as a whole.

use super::cells::{ElementCells, OwnCell, Quadratic, Shared};
use super::error::CorotatedError;
use super::frame::{Columns, Frame, LocalCurvature, LocalForces};
use super::integration::Integration;
use super::linear_cells::LinearCell;
use super::products::{add_quadratic, add_restricted, gradient_map, prolong};
use crate::coarse::galerkin::{ROWS, add_congruence};
use crate::coarsening::COLUMNS;
use crate::element::CellMatrix;
use crate::fine::{CellVectors, InvertedCell};
use crate::linalg::matrix3::determinant;
use crate::material::{EightMatrices, PointLaw, Projection, matrix_at};
use crate::mesh::{Cell, Lattice, Node};

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
            energy += self.nonlinear_energy(room, forces.is_some())?;
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

    /// Energy of the cells of large displacement \[J\]; adds their forces to those of the fine nodes where they are wanted.
    fn nonlinear_energy(&self, room: &mut Workspace, with_forces: bool) -> Result<f64, CorotatedError> {
        let mut energy = 0.0;
        if self.shared.integration == Integration::Centre {
            for batch in self.batches() {
                energy += self.batch_energy(batch, room, with_forces)?;
            }
            return Ok(energy);
        }
        for cell in &self.cells.nonlinear {
            let (law, moved) = (self.law(cell), self.gather(cell, room));
            let inverted = || self.inverted(cell, self.shared.fine_cell.smallest_determinant(&moved));
            if with_forces {
                let found = self.shared.fine_cell.forces(cell.factor, law, &moved);
                let (part, forces) = found.ok_or_else(inverted)?;
                energy += part;
                self.scatter(cell, &forces, room);
            } else {
                energy += self.shared.fine_cell.energy(cell.factor, law, &moved).ok_or_else(inverted)?;
            }
        }
        Ok(energy)
    }

    /// Up to eight cells of one material, which evaluate their law together.
    fn batches(&self) -> impl Iterator<Item = &[OwnCell]> {
        self.cells.nonlinear.chunk_by(|a, b| a.material == b.material).flat_map(|of_material| of_material.chunks(8))
    }

    /// F at the centres of a batch; the identity where the batch is short.
    fn batch_gradients(&self, batch: &[OwnCell], room: &Workspace) -> EightMatrices {
        let mut f = [[[1.0; 8], [0.0; 8], [0.0; 8]], [[0.0; 8], [1.0; 8], [0.0; 8]], [[0.0; 8], [0.0; 8], [1.0; 8]]];
        for (lane, cell) in batch.iter().enumerate() {
            let of_cell = self.shared.fine_cell.centre_gradient(&self.gather(cell, room));
            (0..9).for_each(|n| f[n / 3][n % 3][lane] = of_cell[n / 3][n % 3]);
        }
        f
    }

    fn batch_energy(&self, batch: &[OwnCell], room: &mut Workspace, with_forces: bool) -> Result<f64, CorotatedError> {
        let f = self.batch_gradients(batch, room);
        let mut stress = [[[0.0; 8]; 3]; 3];
        let densities = self.law(&batch[0]).energies_at_eight(&f, &mut stress);
        let densities = densities.ok_or_else(|| self.inverted_in_batch(batch, &f))?;
        let mut energy = 0.0;
        for (lane, cell) in batch.iter().enumerate() {
            energy += self.shared.fine_cell.volume() * cell.factor * densities[lane];
            if with_forces {
                self.scatter(cell, &self.shared.fine_cell.centre_forces(cell.factor, &matrix_at(&stress, lane)), room);
            }
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
        if projection == Projection::Exact {
            self.nonlinear_energy(room, true)?;
        }
        self.add_nonlinear_curvature(room, projection, &mut of_cells.stiffness)?;
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

    /// Adds the Hessian of the cells of large displacement in v, upper triangle.
    fn add_nonlinear_curvature(
        &self,
        room: &Workspace,
        projection: Projection,
        stiffness: &mut [Columns; COLUMNS],
    ) -> Result<(), CorotatedError> {
        if self.shared.integration == Integration::Centre {
            return self.batches().try_for_each(|batch| self.add_batch_curvature(batch, room, projection, stiffness));
        }
        let mut tangent = [0.0; COLUMNS * COLUMNS];
        for cell in &self.cells.nonlinear {
            let (law, moved) = (self.law(cell), self.gather(cell, room));
            let found = self.shared.fine_cell.tangent(cell.factor, (law, projection), &moved, &mut tangent);
            found.ok_or_else(|| self.inverted(cell, self.shared.fine_cell.smallest_determinant(&moved)))?;
            add_congruence::<COLUMNS, ROWS>(1.0, &tangent, &self.rows(cell), stiffness);
        }
        Ok(())
    }

    /// With one point, nine displacement gradients stand between the corners of the cell and those of the element.
    fn add_batch_curvature(
        &self,
        batch: &[OwnCell],
        room: &Workspace,
        projection: Projection,
        stiffness: &mut [Columns; COLUMNS],
    ) -> Result<(), CorotatedError> {
        let f = self.batch_gradients(batch, room);
        let mut tangents = [[[0.0; 8]; 9]; 9];
        let found = self.law(&batch[0]).tangent_at_eight(&f, projection, &mut tangents);
        found.ok_or_else(|| self.inverted_in_batch(batch, &f))?;
        for (lane, cell) in batch.iter().enumerate() {
            let tangent: [f64; 81] = std::array::from_fn(|n| tangents[n / 9][n % 9][lane]);
            let map = gradient_map(&self.rows(cell), self.shared.fine_cell.centre());
            add_congruence::<9, 9>(self.shared.fine_cell.volume() * cell.factor, &tangent, &map, stiffness);
        }
        Ok(())
    }

    fn law(&self, cell: &OwnCell) -> &PointLaw {
        &self.shared.materials[cell.material as usize].law
    }

    fn corners(&self, cell: &OwnCell) -> [Node; 8] {
        self.shared.lattice.corners(Cell(cell.local as usize))
    }

    /// (W v)_a at the corners of a cell.
    fn gather(&self, cell: &OwnCell, room: &Workspace) -> CellVectors {
        let corners = self.corners(cell);
        std::array::from_fn(|r| corners.map(|node| room.displacement[3 * node.0 + r]))
    }

    /// Adds forces on the corners of a cell to those on the fine nodes.
    fn scatter(&self, cell: &OwnCell, forces: &CellVectors, room: &mut Workspace) {
        for (a, node) in self.corners(cell).iter().enumerate() {
            (0..3).for_each(|r| room.forces[3 * node.0 + r] += forces[r][a]);
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

    fn inverted(&self, cell: &OwnCell, determinant: f64) -> CorotatedError {
        let inside = self.shared.lattice.cell_position(Cell(cell.local as usize));
        let at = std::array::from_fn(|a| self.start[a] + inside[a]);
        InvertedCell { cell: self.fine.cell(at), at, determinant }.into()
    }

    /// The cell with the smallest det F.
    fn inverted_in_batch(&self, batch: &[OwnCell], f: &EightMatrices) -> CorotatedError {
        let determinants = batch.iter().enumerate().map(|(lane, cell)| (cell, determinant(&matrix_at(f, lane))));
        let smallest = determinants.reduce(|a, b| if a.1.is_nan() || a.1 <= b.1 { a } else { b });
        let (cell, determinant) = smallest.unwrap_or((&batch[0], f64::NAN));
        self.inverted(cell, determinant)
    }
}
