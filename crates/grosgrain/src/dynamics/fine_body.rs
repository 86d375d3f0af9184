//! The fine model in motion.

use std::collections::BTreeMap;

use super::conditions::NodePotential;
use super::{Body, Conditions, Energies, Inversion, LinearStep, Moment, QuadraticWeights, TangentError};
use crate::assembly::{CellStiffness, Constraints};
use crate::contact::{Grip, PointPotential};
use crate::fine::{CellTangents, FineForces, FineModel, InvertedCell};
use crate::linalg::matrix3::Matrix3;
use crate::linalg::norm;
use crate::material::Projection;
use crate::mesh::{Cell, Node};
use crate::solver::LatticeTangent;

/// What the fine model needs to move: forces, tangents, a solver, and what acts on it. Kept from step to step; the model itself is
/// borrowed while steps are made ([`on`](Self::on)), so that it can be edited between them.
///
/// Memory: one 24×24 matrix per solid cell (4.6 kB), twice that with stiffness-proportional damping, and the solver.
pub struct FineMechanics {
    conditions: Conditions,
    forces: FineForces,
    tangents: CellTangents,
    lagged: Option<CellTangents>,
    solver: LatticeTangent,
    mass: Vec<f64>,
    constraints: Constraints,
    /// Displacement of held nodes; others zero.
    held: Vec<f64>,
    /// Which holds act: what `constraints` were made for.
    acting: Vec<bool>,
    loads: Vec<f64>,
    load_norm: f64,
    shares: Vec<f64>,
    points: Vec<NodePotential>,
    potentials: Vec<PointPotential>,
    /// The potentials at the end of the last step.
    settled: Vec<PointPotential>,
}

/// The fine model with what it needs to move.
pub struct FineBody<'a> {
    model: &'a FineModel,
    mechanics: &'a mut FineMechanics,
}

impl FineMechanics {
    /// What `model` needs under these conditions.
    ///
    /// # Errors
    /// A lattice that cannot be analysed.
    pub fn new(model: &FineModel, conditions: Conditions) -> Result<Self, TangentError> {
        let nodes = model.grid().lattice.node_count();
        let points = conditions.node_potentials(model);
        let potentials: Vec<PointPotential> = points.iter().map(|p| p.at(0.0)).collect();
        Ok(Self {
            conditions,
            forces: FineForces::new(model),
            tangents: CellTangents::new(model),
            lagged: None,
            solver: LatticeTangent::new(model, model.grid().spacing)?,
            mass: nodal_mass(model),
            constraints: Constraints::none(nodes),
            held: vec![0.0; 3 * nodes],
            acting: Vec::new(),
            loads: vec![0.0; 3 * nodes],
            load_norm: 0.0,
            shares: vec![f64::NAN],
            points,
            settled: potentials.clone(),
            potentials,
        })
    }

    /// Takes over a model that was edited, and conditions that may have changed with it. What friction holds stays.
    ///
    /// # Errors
    /// As [`FineMechanics::new`].
    pub fn renew(&mut self, model: &FineModel, conditions: Conditions) -> Result<(), TangentError> {
        let grips: BTreeMap<usize, Grip> = self.points.iter().zip(&self.settled).filter_map(grip_of).collect();
        *self = Self::new(model, conditions)?;
        for (point, potential) in self.points.iter().zip(&mut self.settled) {
            if let (PointPotential::Ground { grip, .. }, Some(old)) = (potential, grips.get(&point.node.0)) {
                *grip = *old;
            }
        }
        self.potentials.clone_from(&self.settled);
        Ok(())
    }

    /// The body, ready for steps.
    pub fn on<'a>(&'a mut self, model: &'a FineModel) -> FineBody<'a> {
        FineBody { model, mechanics: self }
    }

    /// What acts on the body.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// Lumped mass \[kg\] of every lattice node.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }
}

fn grip_of((point, potential): (&NodePotential, &PointPotential)) -> Option<(usize, Grip)> {
    match potential {
        PointPotential::Ground { grip, .. } => Some((point.node.0, *grip)),
        PointPotential::Spring { .. } => None,
    }
}

/// An eighth of the mass of every cell at each of its corners.
fn nodal_mass(model: &FineModel) -> Vec<f64> {
    let lattice = model.grid().lattice;
    let mut mass = vec![0.0; lattice.node_count()];
    for cell in (0..lattice.cell_count()).map(Cell) {
        let share = model.cell_mass(cell) / 8.0;
        lattice.corners(cell).iter().for_each(|node| mass[node.0] += share);
    }
    mass
}

impl From<InvertedCell> for Inversion {
    fn from(inverted: InvertedCell) -> Self {
        Self::Cell { at: inverted.at, determinant: inverted.determinant }
    }
}

impl FineBody<'_> {
    fn position(&self, node: Node, displacement: &[f64]) -> [f64; 3] {
        let rest = self.model.node_position(node);
        std::array::from_fn(|r| rest[r] + displacement[3 * node.0 + r])
    }

    /// Energies of loads and points, and their gradient where it is asked for.
    fn add_external(&self, displacement: &[f64], mut gradient: Option<&mut [f64]>) -> (f64, f64) {
        let FineMechanics { loads, points, potentials, .. } = &*self.mechanics;
        let mut of_loads = 0.0;
        for (i, (force, u)) in loads.iter().zip(displacement).enumerate() {
            of_loads -= force * u;
            if let Some(gradient) = gradient.as_deref_mut() {
                gradient[i] -= force;
            }
        }
        let mut of_points = 0.0;
        for (point, potential) in points.iter().zip(potentials) {
            let response = potential.evaluate(self.position(point.node, displacement));
            of_points += response.energy;
            if let Some(gradient) = gradient.as_deref_mut() {
                (0..3).for_each(|r| gradient[3 * point.node.0 + r] += response.gradient[r]);
            }
        }
        (of_loads, of_points)
    }

    /// A solid cell at a node, with the node's number among its corners.
    fn cell_at(&self, node: Node) -> Option<(Cell, usize)> {
        let lattice = self.model.grid().lattice;
        let cell = lattice.cells_at(node).find(|cell| !self.model.is_void(*cell))?;
        let corner = lattice.corners(cell).iter().position(|n| *n == node)?;
        Some((cell, corner))
    }

    fn add_diagonals(&mut self, displacement: &[f64], mass: f64) {
        let lattice = self.model.grid().lattice;
        if mass > 0.0 {
            for cell in (0..lattice.cell_count()).map(Cell).filter(|c| !self.model.is_void(*c)) {
                let share = mass * self.model.cell_mass(cell) / 8.0;
                let diagonal: Matrix3 = [[share, 0.0, 0.0], [0.0, share, 0.0], [0.0, 0.0, share]];
                (0..8).for_each(|corner| self.mechanics.tangents.add_to_corner_diagonal(cell, corner, &diagonal));
            }
        }
        for n in 0..self.mechanics.points.len() {
            let node = self.mechanics.points[n].node;
            let response = self.mechanics.potentials[n].evaluate(self.position(node, displacement));
            if response.hessian == [[0.0; 3]; 3] {
                continue;
            }
            if let Some((cell, corner)) = self.cell_at(node) {
                self.mechanics.tangents.add_to_corner_diagonal(cell, corner, &response.hessian);
            }
        }
    }
}

/// product += factor Σ K_e v_e.
fn add_products(cells: &CellTangents, factor: f64, vector: &[f64], product: &mut [f64]) {
    let lattice = cells.lattice();
    for cell in 0..lattice.cell_count() {
        let Some((_, matrix)) = cells.stiffness(cell) else { continue };
        let corners = lattice.corners(Cell(cell));
        let local: [f64; 24] = std::array::from_fn(|i| vector[3 * corners[i / 3].0 + i % 3]);
        for (i, row) in matrix.chunks_exact(24).enumerate() {
            let sum: f64 = row.iter().zip(&local).map(|(k, v)| k * v).sum();
            product[3 * corners[i / 3].0 + i % 3] += factor * sum;
        }
    }
}

impl Body for FineBody<'_> {
    fn mass(&self) -> &[f64] {
        &self.mechanics.mass
    }

    fn set_moment(&mut self, moment: Moment) -> Result<(), TangentError> {
        let m = &mut *self.mechanics;
        let nodes = m.mass.len();
        let holds = &m.conditions.holds;
        if !holds.acting_at(moment.holds).eq(m.acting.iter().copied()) {
            m.constraints = Constraints::nodes(&holds.fixed_at(moment.holds, nodes));
            m.acting = holds.acting_at(moment.holds).collect();
            m.held.fill(0.0);
        }
        holds.prescribe(moment.holds, |node| self.model.node_position(Node(node)), &mut m.held);
        let mut shares = Vec::new();
        m.conditions.shares_at(moment.loads, moment.share, &mut shares);
        if shares != m.shares {
            m.conditions.loads_at(moment.loads, moment.share, &mut m.loads);
            m.load_norm = norm(&m.loads);
            m.shares = shares;
            for (point, potential) in m.points.iter().zip(&mut m.potentials) {
                if let PointPotential::Spring { .. } = potential {
                    *potential = point.at(moment.loads);
                }
            }
        }
        Ok(())
    }

    fn constraints(&self) -> &Constraints {
        &self.mechanics.constraints
    }

    fn load_norm(&self) -> f64 {
        self.mechanics.load_norm
    }

    fn prescribe(&self, displacement: &mut [f64]) {
        let constraints = &self.mechanics.constraints;
        for node in (0..constraints.node_count()).filter(|n| !constraints.is_free(*n) && self.model.active()[*n]) {
            displacement[3 * node..3 * node + 3].copy_from_slice(&self.mechanics.held[3 * node..3 * node + 3]);
        }
    }

    fn energies(&self, displacement: &[f64]) -> Result<Energies, Inversion> {
        let elastic = self.mechanics.forces.energy(self.model, displacement)?;
        let (loads, points) = self.add_external(displacement, None);
        Ok(Energies { elastic, loads, points })
    }

    fn energy_of_points(&self, displacement: &[f64]) -> Result<f64, Inversion> {
        let FineMechanics { points, potentials, .. } = &*self.mechanics;
        let energy = |(point, potential): (&NodePotential, &PointPotential)| {
            potential.evaluate(self.position(point.node, displacement)).energy
        };
        Ok(points.iter().zip(potentials).map(energy).sum())
    }

    fn load_energy(&self, displacement: &[f64]) -> Result<f64, Inversion> {
        Ok(-self.mechanics.loads.iter().zip(displacement).map(|(force, u)| force * u).sum::<f64>())
    }

    fn gradient(&self, displacement: &[f64], gradient: &mut [f64]) -> Result<Energies, Inversion> {
        gradient.fill(0.0);
        let elastic = self.mechanics.forces.gradient(self.model, displacement, gradient)?;
        let (loads, points) = self.add_external(displacement, Some(gradient));
        Ok(Energies { elastic, loads, points })
    }

    fn linearise(
        &mut self,
        displacement: &[f64],
        weights: QuadraticWeights,
        projection: Projection,
    ) -> Result<(), TangentError> {
        let FineMechanics { forces, tangents, lagged, .. } = &mut *self.mechanics;
        forces.tangents(self.model, displacement, projection, tangents).map_err(Inversion::from)?;
        if let Some(lagged) = lagged.as_ref().filter(|_| weights.damping > 0.0) {
            tangents.add(weights.damping, lagged);
        }
        self.add_diagonals(displacement, weights.mass);
        let FineMechanics { tangents, solver, constraints, .. } = &mut *self.mechanics;
        Ok(solver.update(tangents, constraints, true)?)
    }

    fn multiply(&self, vector: &[f64], product: &mut [f64]) {
        product.fill(0.0);
        add_products(&self.mechanics.tangents, 1.0, vector, product);
    }

    fn solve(&mut self, vector: &mut [f64], tolerance: f64) -> Result<LinearStep, TangentError> {
        let report = self.mechanics.solver.solve(vector, tolerance)?;
        Ok(LinearStep { iterations: report.iterations, relative_residual: report.relative_residual })
    }

    fn lag_damping(&mut self, displacement: &[f64]) -> Result<(), Inversion> {
        let FineMechanics { forces, lagged, .. } = &mut *self.mechanics;
        let kept = lagged.get_or_insert_with(|| CellTangents::new(self.model));
        Ok(forces.tangents(self.model, displacement, Projection::PositiveSemidefinite, kept)?)
    }

    fn add_damping(&self, factor: f64, vector: &[f64], product: &mut [f64]) {
        if let Some(lagged) = &self.mechanics.lagged {
            add_products(lagged, factor, vector, product);
        }
    }

    fn renew_friction(&mut self, displacement: &[f64]) -> f64 {
        let mut largest = 0.0f64;
        for n in 0..self.mechanics.points.len() {
            let at = self.position(self.mechanics.points[n].node, displacement);
            largest = largest.max(self.mechanics.potentials[n].renew_limit(at));
        }
        largest
    }

    fn settle_friction(&mut self, displacement: &[f64]) {
        for n in 0..self.mechanics.points.len() {
            let at = self.position(self.mechanics.points[n].node, displacement);
            self.mechanics.potentials[n].settle(at);
        }
        let FineMechanics { settled, potentials, .. } = &mut *self.mechanics;
        settled.clone_from(potentials);
    }

    fn restore_friction(&mut self) {
        let FineMechanics { settled, potentials, shares, .. } = &mut *self.mechanics;
        potentials.clone_from(settled);
        // Springs are set anew with the loads.
        shares.clear();
        shares.push(f64::NAN);
    }
}
