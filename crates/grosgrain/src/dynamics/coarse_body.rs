//! The coarse model in motion.

use std::collections::BTreeMap;

use super::conditions::NodePotential;
use super::element_products::add_products;
use super::{Body, Conditions, Energies, Inversion, LinearStep, Moment, QuadraticWeights, State, TangentError};
use crate::assembly::Constraints;
use crate::coarse::{
    CoarseModel, Corotated, CorotatedError, EmbeddedPoint, Embedding, Integration, PenaltyPoint, Potential,
    SupportedCoarse,
};
use crate::contact::{Grip, PointPotential};
use crate::element::CellMatrix;
use crate::fine::FineModel;
use crate::linalg::matrix3::Matrix3;
use crate::linalg::norm;
use crate::material::Projection;
use crate::mesh::Node;
use crate::partition::CellPart;
use crate::solver::{COARSE_FACTOR_LIMIT, ElementCells, ElementTangent};

/// What the coarse model needs to move. Kept from step to step and across edits; the models are borrowed while steps are made
/// ([`on`](Self::on)).
///
/// Memory beside the coarse model: one 24×24 matrix per element, twice that with stiffness-proportional damping, the data of the chosen
/// [`Integration`], and the solver.
pub struct CoarseMechanics {
    conditions: Conditions,
    corotated: Corotated,
    tangents: Vec<CellMatrix>,
    lagged: Vec<CellMatrix>,
    solver: ElementTangent,
    /// The mesh that the solver was made for.
    corners: Vec<[u32; 8]>,
    elements: Vec<CellPart>,
    constraints: Constraints,
    /// Which holds act: what `constraints` were made for.
    acting: Vec<bool>,
    /// Displacement of held vertices; others zero.
    held: Vec<f64>,
    loads: Vec<f64>,
    load_norm: f64,
    shares: Vec<f64>,
    nodes: Vec<NodePotential>,
    /// Where each embedded point's potential comes from.
    sources: Vec<Source>,
    penalties: Vec<PenaltyPoint>,
    potentials: Vec<PointPotential>,
    /// The potentials at the end of the last step.
    settled: Vec<PointPotential>,
    positions: Vec<[f64; 3]>,
}

/// Where the potential of an embedded point comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// That of a fine node, in an element.
    Node { number: usize, element: CellPart },
    /// Held fine nodes inside a coarse cell.
    Penalty { number: usize },
}

/// The models and what they need to move.
pub struct CoarseBody<'a> {
    fine: &'a FineModel,
    coarse: &'a CoarseModel,
    mechanics: &'a mut CoarseMechanics,
}

impl CoarseMechanics {
    /// What `coarse`, made of `fine`, needs under these conditions.
    ///
    /// # Errors
    /// A mesh that cannot be analysed.
    pub fn new(
        fine: &FineModel,
        coarse: &CoarseModel,
        integration: Integration,
        conditions: Conditions,
    ) -> Result<Self, TangentError> {
        let mesh = coarse.mesh();
        let vertices = mesh.vertices().len();
        let nodes = conditions.node_potentials(fine);
        let mut mechanics = Self {
            corotated: Corotated::new(fine, coarse, integration),
            tangents: vec![[0.0; 576]; mesh.elements().len()],
            lagged: Vec::new(),
            solver: solver(coarse)?,
            corners: mesh.corners().to_vec(),
            elements: mesh.elements().to_vec(),
            constraints: Constraints::none(vertices),
            acting: Vec::new(),
            held: vec![0.0; 3 * vertices],
            loads: vec![0.0; 3 * fine.grid().lattice.node_count()],
            load_norm: 0.0,
            shares: vec![f64::NAN],
            nodes,
            sources: Vec::new(),
            penalties: Vec::new(),
            potentials: Vec::new(),
            settled: Vec::new(),
            positions: Vec::new(),
            conditions,
        };
        mechanics.place_points(coarse);
        Ok(mechanics)
    }

    /// Takes over models that an edit has changed, `dirty` being the elements that were made anew, and conditions that may have changed with
    /// them. What friction holds stays; the solver does where elements meet as before.
    ///
    /// # Errors
    /// As [`CoarseMechanics::new`].
    pub fn renew(
        &mut self,
        (fine, coarse): (&FineModel, &CoarseModel),
        dirty: &[CellPart],
        conditions: Conditions,
    ) -> Result<(), TangentError> {
        let grips = self.grips();
        let mesh = coarse.mesh();
        let vertices = mesh.vertices().len();
        self.corotated.renew(fine, coarse, dirty);
        if self.corners != mesh.corners() || self.elements != mesh.elements() {
            self.corners = mesh.corners().to_vec();
            self.elements = mesh.elements().to_vec();
            self.tangents.resize(mesh.elements().len(), [0.0; 576]);
            self.lagged.clear();
            self.solver = solver(coarse)?;
        }
        self.nodes = conditions.node_potentials(fine);
        self.conditions = conditions;
        self.constraints = Constraints::none(vertices);
        self.acting.clear();
        self.held = vec![0.0; 3 * vertices];
        self.shares = vec![f64::NAN];
        self.penalties.clear();
        self.place_points(coarse);
        for (source, potential) in self.sources.iter().zip(&mut self.settled) {
            let Source::Node { number, element, .. } = source else { continue };
            let key = (self.nodes[*number].node.0, *element);
            if let (PointPotential::Ground { grip, .. }, Some(old)) = (potential, grips.get(&key)) {
                *grip = *old;
            }
        }
        self.potentials.clone_from(&self.settled);
        Ok(())
    }

    /// What friction holds at the end of the last step, by fine node and element.
    fn grips(&self) -> BTreeMap<(usize, CellPart), Grip> {
        let grip = |(source, potential): (&Source, &PointPotential)| match (source, potential) {
            (Source::Node { number, element, .. }, PointPotential::Ground { grip, .. }) => {
                Some(((self.nodes[*number].node.0, *element), *grip))
            }
            _ => None,
        };
        self.sources.iter().zip(&self.settled).filter_map(grip).collect()
    }

    /// Puts the potentials of fine nodes and the penalties into the elements.
    fn place_points(&mut self, coarse: &CoarseModel) {
        let mut points: Vec<EmbeddedPoint> = Vec::new();
        self.sources.clear();
        for (number, of_node) in self.nodes.iter().enumerate() {
            for point in EmbeddedPoint::of_node(coarse, of_node.node) {
                let element = coarse.elements()[point.element as usize];
                self.sources.push(Source::Node { number, element });
                points.push(point);
            }
        }
        for (number, penalty) in self.penalties.iter().enumerate() {
            self.sources.push(Source::Penalty { number });
            points.push(penalty.point);
        }
        self.corotated.set_points(points);
        let nodes = &self.nodes;
        let potential = |source: &Source| match *source {
            Source::Node { number, .. } => nodes[number].at(0.0),
            Source::Penalty { .. } => PointPotential::Spring { stiffness: 0.0, target: [0.0; 3] },
        };
        self.potentials = self.sources.iter().map(potential).collect();
        self.settled.clone_from(&self.potentials);
    }

    /// The models, ready for steps.
    pub fn on<'a>(&'a mut self, fine: &'a FineModel, coarse: &'a CoarseModel) -> CoarseBody<'a> {
        CoarseBody { fine, coarse, mechanics: self }
    }

    /// What acts on the body.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// Fine displacement of a coarse one, three entries per lattice node, averaged where elements meet.
    ///
    /// # Errors
    /// A coarse cell that is inverted.
    pub fn prolong(
        &self,
        coarse: &CoarseModel,
        embedding: &Embedding<'_>,
        displacement: &[f64],
    ) -> Result<Vec<f64>, Inversion> {
        Ok(self.corotated.prolong(coarse, embedding, displacement)?)
    }
}

/// A solver for the mesh of `coarse`: with a factor or, for many unknowns, a multigrid cycle.
fn solver(coarse: &CoarseModel) -> Result<ElementTangent, TangentError> {
    let mesh = coarse.mesh();
    let cells = mesh.elements().iter().map(|element| element.cell.0 as u32).collect();
    let place = ElementCells { lattice: coarse.partition().coarse(), spacing: coarse.spacing(), cells };
    Ok(ElementTangent::on_lattice(mesh.elimination_order(), mesh.corners(), place, COARSE_FACTOR_LIMIT)?)
}

impl Potential for PointPotential {
    fn evaluate(&self, x: [f64; 3]) -> (f64, [f64; 3], Matrix3) {
        let response = PointPotential::evaluate(self, x);
        (response.energy, response.gradient, response.hessian)
    }
}

impl From<CorotatedError> for Inversion {
    fn from(error: CorotatedError) -> Self {
        match error {
            CorotatedError::Collapsed { at, determinant } => Self::CoarseCell { at, determinant },
            CorotatedError::Inverted(inverted) => inverted.into(),
        }
    }
}

impl CoarseBody<'_> {
    /// Finds which vertices are held and which nodes by penalty, for the marked fine nodes.
    fn hold(&mut self, fixed: &[bool]) {
        let m = &mut *self.mechanics;
        let supported = SupportedCoarse::new(self.coarse, &Embedding::new(self.coarse), fixed);
        m.penalties = supported.penalty_points().to_vec();
        m.constraints = supported.constraints;
        let kept: Vec<PointPotential> = std::mem::take(&mut m.settled);
        m.place_points(self.coarse);
        // Points of nodes come first and are the same as before.
        let nodes = m.sources.iter().filter(|s| matches!(s, Source::Node { .. })).count().min(kept.len());
        m.settled[..nodes].copy_from_slice(&kept[..nodes]);
        m.potentials.clone_from(&m.settled);
        m.shares = vec![f64::NAN];
    }

    /// Places of held nodes at a time: displacement of vertices, targets of penalties.
    fn move_held(&mut self, time: f64) {
        let m = &mut *self.mechanics;
        let (holds, fine) = (&m.conditions.holds, self.fine);
        let displacement = |node: Node| holds.displacement_at(node.0, fine.node_position(node), time);
        m.held.fill(0.0);
        for (number, vertex) in self.coarse.mesh().vertices().iter().enumerate() {
            if m.constraints.is_free(number) {
                continue;
            }
            let node = self.coarse.partition().coincident_node(vertex.node);
            if let Some(u) = displacement(node) {
                m.held[3 * number..3 * number + 3].copy_from_slice(&u);
            }
        }
        for (source, potential) in m.sources.iter().zip(&mut m.potentials) {
            let Source::Penalty { number } = *source else { continue };
            let penalty = &m.penalties[number];
            let mut target = [0.0; 3];
            for &(node, weight) in &penalty.nodes {
                let node = Node(node as usize);
                let (rest, u) = (fine.node_position(node), displacement(node).unwrap_or_default());
                (0..3).for_each(|r| target[r] += weight * (rest[r] + u[r]));
            }
            *potential = PointPotential::Spring { stiffness: penalty.stiffness, target };
        }
    }

    fn set_loads(&mut self, moment: Moment) {
        let m = &mut *self.mechanics;
        let mut shares = Vec::new();
        m.conditions.shares_at(moment.loads, moment.share, &mut shares);
        if shares == m.shares {
            return;
        }
        m.conditions.loads_at(moment.loads, moment.share, &mut m.loads);
        let embedding = Embedding::new(self.coarse);
        m.load_norm = norm(&embedding.restrict(&m.loads));
        m.corotated.set_loads(self.coarse, &embedding, &m.loads);
        m.shares = shares;
        for (source, potential) in m.sources.iter().zip(&mut m.potentials) {
            if let (Source::Node { number, .. }, PointPotential::Spring { .. }) = (source, &*potential) {
                *potential = m.nodes[*number].at(moment.loads);
            }
        }
    }

    fn each_position(&mut self, displacement: &[f64], mut visit: impl FnMut(&mut PointPotential, [f64; 3])) {
        let CoarseMechanics { corotated, potentials, positions, .. } = &mut *self.mechanics;
        // A state that was accepted is not inverted.
        if corotated.positions(self.coarse, displacement, positions).is_ok() {
            potentials.iter_mut().zip(positions).for_each(|(potential, at)| visit(potential, *at));
        }
    }
}

impl Body for CoarseBody<'_> {
    fn mass(&self) -> &[f64] {
        self.coarse.mass()
    }

    fn set_moment(&mut self, moment: Moment) -> Result<(), TangentError> {
        let holds = &self.mechanics.conditions.holds;
        if !holds.acting_at(moment.holds).eq(self.mechanics.acting.iter().copied()) {
            let acting = holds.acting_at(moment.holds).collect();
            let fixed = holds.fixed_at(moment.holds, self.fine.grid().lattice.node_count());
            self.hold(&fixed);
            self.mechanics.acting = acting;
        }
        self.move_held(moment.holds);
        self.set_loads(moment);
        Ok(())
    }

    fn constraints(&self) -> &Constraints {
        &self.mechanics.constraints
    }

    fn load_norm(&self) -> f64 {
        self.mechanics.load_norm
    }

    fn prescribe(&self, displacement: &mut [f64]) {
        let CoarseMechanics { constraints, held, .. } = &*self.mechanics;
        for vertex in (0..constraints.node_count()).filter(|n| !constraints.is_free(*n)) {
            displacement[3 * vertex..3 * vertex + 3].copy_from_slice(&held[3 * vertex..3 * vertex + 3]);
        }
    }

    fn energies(&self, displacement: &[f64]) -> Result<Energies, Inversion> {
        let CoarseMechanics { corotated, potentials, .. } = &*self.mechanics;
        let energies = corotated.energy(self.coarse, displacement, potentials)?;
        Ok(Energies { elastic: energies.elastic, loads: energies.loads, points: energies.points })
    }

    fn energy_of_points(&self, displacement: &[f64]) -> Result<f64, Inversion> {
        let CoarseMechanics { corotated, potentials, .. } = &*self.mechanics;
        if potentials.is_empty() {
            return Ok(0.0);
        }
        let mut positions = Vec::new();
        corotated.positions(self.coarse, displacement, &mut positions)?;
        let energy = |((point, potential), at): ((&EmbeddedPoint, &PointPotential), [f64; 3])| {
            point.share * potential.evaluate(at).energy
        };
        Ok(corotated.points().iter().zip(potentials).zip(positions).map(energy).sum())
    }

    fn load_energy(&self, displacement: &[f64]) -> Result<f64, Inversion> {
        Ok(self.mechanics.corotated.load_energy(self.coarse, displacement)?)
    }

    fn gradient(&self, displacement: &[f64], gradient: &mut [f64]) -> Result<Energies, Inversion> {
        let CoarseMechanics { corotated, potentials, .. } = &*self.mechanics;
        gradient.fill(0.0);
        let energies = corotated.gradient(self.coarse, displacement, potentials, gradient)?;
        Ok(Energies { elastic: energies.elastic, loads: energies.loads, points: energies.points })
    }

    fn linearise(
        &mut self,
        displacement: &[f64],
        weights: QuadraticWeights,
        projection: Projection,
    ) -> Result<(), TangentError> {
        let CoarseMechanics { corotated, potentials, tangents, lagged, solver, constraints, .. } = &mut *self.mechanics;
        let made = corotated.tangents(self.coarse, displacement, potentials, projection, tangents);
        made.map_err(Inversion::from)?;
        if weights.damping > 0.0 {
            for (to, from) in tangents.iter_mut().zip(lagged.iter()) {
                to.iter_mut().zip(from).for_each(|(to, from)| *to += weights.damping * from);
            }
        }
        if weights.mass > 0.0 {
            for (index, tangent) in tangents.iter_mut().enumerate() {
                let masses = self.coarse.corner_mass(index);
                (0..24).for_each(|i| tangent[25 * i] += weights.mass * masses[i / 3]);
            }
        }
        // Lagged: the preconditioner stays until the solver's books of iterations speak for a new one.
        Ok(solver.update(|element| &tangents[element], constraints, true)?)
    }

    fn multiply(&self, vector: &[f64], product: &mut [f64]) {
        product.fill(0.0);
        add_products((self.coarse.mesh().corners(), &self.mechanics.tangents), 1.0, vector, product);
    }

    fn solve(&mut self, vector: &mut [f64], tolerance: f64) -> Result<LinearStep, TangentError> {
        let report = self.mechanics.solver.solve(vector, tolerance)?;
        Ok(LinearStep { iterations: report.iterations, relative_residual: report.relative_residual })
    }

    fn lag_damping(&mut self, displacement: &[f64]) -> Result<(), Inversion> {
        let CoarseMechanics { corotated, potentials, lagged, .. } = &mut *self.mechanics;
        lagged.resize(self.coarse.elements().len(), [0.0; 576]);
        // The material is damped, not what it rests on.
        let silent = vec![PointPotential::Spring { stiffness: 0.0, target: [0.0; 3] }; potentials.len()];
        Ok(corotated.tangents(self.coarse, displacement, &silent, Projection::PositiveSemidefinite, lagged)?)
    }

    fn add_damping(&self, factor: f64, vector: &[f64], product: &mut [f64]) {
        add_products((self.coarse.mesh().corners(), &self.mechanics.lagged), factor, vector, product);
    }

    fn renew_friction(&mut self, displacement: &[f64]) -> f64 {
        let mut largest = 0.0f64;
        self.each_position(displacement, |potential, at| largest = largest.max(potential.renew_limit(at)));
        largest
    }

    fn settle_friction(&mut self, displacement: &[f64]) {
        self.each_position(displacement, |potential, at| potential.settle(at));
        let CoarseMechanics { settled, potentials, .. } = &mut *self.mechanics;
        settled.clone_from(potentials);
    }

    fn restore_friction(&mut self) {
        let CoarseMechanics { settled, potentials, shares, .. } = &mut *self.mechanics;
        potentials.clone_from(settled);
        // Springs are set anew with the loads.
        shares.clear();
        shares.push(f64::NAN);
    }
}

impl CoarseMechanics {
    /// Rest of the vertices of `coarse`.
    pub fn rest(coarse: &CoarseModel) -> State {
        State::rest(coarse.mesh().vertices().len())
    }
}
