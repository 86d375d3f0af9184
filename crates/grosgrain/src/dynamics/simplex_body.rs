//! A mesh of simplices in motion.

use super::element_products::add_products;
use super::point_groups::PointGroup;
use super::simplex_body_error::{check_conditions, check_length, check_point, check_spring};
use super::simplex_points::{CellPotential, EmbeddedSpring, SurfacePoint, homes};
use super::{
    Body, Conditions, Energies, Inversion, LinearStep, Moment, QuadraticWeights, SimplexBodyError, State, TangentError,
};
use crate::assembly::Constraints;
use crate::contact::PointPotential;
use crate::homogenization::SimplexModel;
use crate::linalg::{clique_order, norm};
use crate::material::Projection;
use crate::simplex::{Dimension, SimplexElasticity, SimplexLaw, SimplexMatrix, SimplexMesh};
use crate::solver::ElementTangent;

/// A body of simplices, fine or coarse, with what acts on it and what it needs to move (`kharevych2009numerical`, §4.4).
///
/// Conditions are stated on the nodes of its own mesh, three components each also in one and two dimensions, where components beyond the dimension stay zero
/// whatever holds and loads say. The ground acts on points of the surface: on the boundary nodes, or on those of a finer mesh ([`Self::with_surface`]).
///
/// Memory: about 1.7 kB per cell, 1.2 kB more with stiffness-proportional damping, and the solver.
pub struct SimplexBody {
    dimension: Dimension,
    rest: Vec<[f64; 3]>,
    elasticity: SimplexElasticity,
    conditions: Conditions,
    mass: Vec<f64>,
    /// In how many cells each node is a corner.
    valence: Vec<u32>,
    /// Springs, then points on the ground by cell.
    points: Vec<CellPotential>,
    groups: Vec<PointGroup>,
    potentials: Vec<PointPotential>,
    /// The potentials at the end of the last step.
    settled: Vec<PointPotential>,
    tangents: Vec<SimplexMatrix>,
    lagged: Vec<SimplexMatrix>,
    solver: ElementTangent<4>,
    constraints: Constraints,
    /// Which holds act: what `constraints` were made for.
    acting: Vec<bool>,
    /// Displacement of held nodes; others zero.
    held: Vec<f64>,
    loads: Vec<f64>,
    load_norm: f64,
    shares: Vec<f64>,
}

/// Lumped masses \[kg\] of the nodes: a (d + 1)-th of the mass of every cell at each of its corners.
pub fn simplex_mass(model: &SimplexModel) -> Vec<f64> {
    let mesh = model.mesh();
    mesh.lumped(|cell| model.density(cell) * mesh.measure(cell))
}

impl SimplexBody {
    /// The body of `model` with its own lumped masses, and its own boundary nodes where there is a ground.
    ///
    /// # Errors
    /// Conditions that do not fit the mesh, a ground in less than three dimensions or under a mesh without a proper boundary, a mesh too large for the solver.
    pub fn new(model: &SimplexModel, law: SimplexLaw, conditions: Conditions) -> Result<Self, SimplexBodyError> {
        let mesh = model.mesh();
        check_conditions(mesh, &conditions)?;
        let elasticity = SimplexElasticity::new(mesh, |cell| model.tensor(cell), law)?;
        let nodes = mesh.nodes().len();
        let mut valence = vec![0; nodes];
        (0..mesh.cell_count()).flat_map(|c| mesh.cell(c)).for_each(|node| valence[*node as usize] += 1);
        let order = clique_order(nodes, elasticity.corners())?;
        let solver = ElementTangent::new(order, elasticity.corners())?;
        let mut body = Self {
            dimension: mesh.dimension(),
            rest: mesh.nodes().to_vec(),
            conditions,
            mass: simplex_mass(model),
            valence,
            points: Vec::new(),
            groups: Vec::new(),
            potentials: Vec::new(),
            settled: Vec::new(),
            tangents: vec![[0.0; 144]; mesh.cell_count()],
            lagged: Vec::new(),
            solver,
            constraints: Constraints::none(nodes),
            acting: Vec::new(),
            held: vec![0.0; 3 * nodes],
            loads: vec![0.0; 3 * nodes],
            load_norm: 0.0,
            shares: vec![f64::NAN],
            elasticity,
        };
        body.constraints = body.constraints_with(&vec![false; nodes]);
        body.place_springs(mesh)?;
        if body.conditions.ground.is_some() {
            body.add_surface(&SurfacePoint::of_boundary(mesh)?)?;
        }
        body.reset_points();
        Ok(body)
    }

    /// The same with other masses \[kg\], one per node: a coarse mesh that carries the mass of a fine one.
    ///
    /// # Errors
    /// A number of masses that is not that of nodes; negative masses, or masses at nodes that no cell uses.
    pub fn with_mass(mut self, mass: Vec<f64>) -> Result<Self, SimplexBodyError> {
        check_length("the list of masses", mass.len(), self.rest.len())?;
        let is_right = |(node, mass): &(usize, &f64)| {
            let is_mass = mass.is_finite() && **mass >= 0.0;
            is_mass && (self.valence[*node] > 0 || **mass == 0.0)
        };
        if let Some((node, mass)) = mass.iter().enumerate().find(|entry| !is_right(entry)) {
            return Err(SimplexBodyError::Mass { node, mass: *mass, is_used: self.valence[node] > 0 });
        }
        self.mass = mass;
        Ok(self)
    }

    /// The same with the ground, where there is one, acting on these points instead of the body's own boundary nodes.
    ///
    /// # Errors
    /// Points of cells that are not there, weights that do not sum to 1, areas that are not positive.
    pub fn with_surface(mut self, points: &[SurfacePoint]) -> Result<Self, SimplexBodyError> {
        self.points.retain(|point| matches!(point.potential, PointPotential::Spring { .. }));
        self.add_surface(points)?;
        self.reset_points();
        Ok(self)
    }

    /// The same with more springs, tied to points between nodes: those of the nodes of a finer mesh that moves with this one.
    ///
    /// # Errors
    /// Springs of cells that are not there, weights that do not sum to 1, stiffnesses that are negative or not finite.
    pub fn with_springs(mut self, springs: &[EmbeddedSpring]) -> Result<Self, SimplexBodyError> {
        for (number, spring) in springs.iter().enumerate() {
            check_spring((self.dimension, self.tangents.len()), number, spring)?;
            self.points.push(CellPotential {
                cell: spring.cell,
                corners: self.elasticity.corners()[spring.cell as usize],
                weights: spring.weights,
                potential: PointPotential::Spring { stiffness: spring.stiffness, target: spring.target },
                schedule: spring.schedule,
            });
        }
        self.reset_points();
        Ok(self)
    }

    /// What acts on the body, besides springs between nodes.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// The state of rest.
    pub fn rest(&self) -> State {
        State::rest(self.rest.len())
    }

    fn place_springs(&mut self, mesh: &SimplexMesh) -> Result<(), SimplexBodyError> {
        let homes = homes(mesh);
        for (spring, tied) in self.conditions.springs.iter().enumerate() {
            let (node, nodes) = (tied.node.0, self.rest.len());
            let Some(home) = homes.get(node).copied().flatten() else {
                return Err(SimplexBodyError::Spring { spring, node, nodes });
            };
            let potential = PointPotential::Spring { stiffness: tied.stiffness, target: tied.target };
            self.points.push(CellPotential {
                cell: home.cell,
                corners: self.elasticity.corners()[home.cell as usize],
                weights: home.weights,
                potential,
                schedule: tied.schedule,
            });
        }
        Ok(())
    }

    fn add_surface(&mut self, points: &[SurfacePoint]) -> Result<(), SimplexBodyError> {
        let Some(ground) = self.conditions.ground else { return Ok(()) };
        for (number, point) in points.iter().enumerate() {
            check_point((self.dimension, self.tangents.len()), number, point)?;
            let stiffness = ground.stiffness * point.area;
            self.points.push(CellPotential {
                cell: point.cell,
                corners: self.elasticity.corners()[point.cell as usize],
                weights: point.weights,
                potential: PointPotential::Ground { ground, stiffness, grip: Default::default() },
                schedule: Default::default(),
            });
        }
        Ok(())
    }

    fn reset_points(&mut self) {
        self.points.sort_by_key(PointGroup::key);
        self.groups = PointGroup::of(&self.points);
        self.potentials = self.points.iter().map(|point| point.schedule.acting(point.potential, 0.0)).collect();
        self.settled.clone_from(&self.potentials);
    }

    /// Held nodes, axes beyond the dimension and nodes that no cell uses are prescribed.
    fn constraints_with(&self, held: &[bool]) -> Constraints {
        let is_still = |(held, valence): (&bool, &u32)| *held || *valence == 0;
        let still: Vec<bool> = held.iter().zip(&self.valence).map(is_still).collect();
        let mut constraints = Constraints::nodes(&still);
        for node in 0..held.len() {
            (self.dimension.axes()..3).for_each(|r| constraints.fix(node, r));
        }
        constraints
    }

    /// Sets what lies beyond the dimension, and what nodes have that no cell uses, to zero.
    fn keep_unknowns((dimension, valence): (Dimension, &[u32]), vector: &mut [f64]) {
        for (three, valence) in vector.chunks_exact_mut(3).zip(valence) {
            three[if *valence == 0 { 0 } else { dimension.axes() }..].fill(0.0);
        }
    }

    /// Energies of loads and points, and their gradient where it is asked for.
    fn add_external(&self, displacement: &[f64], mut gradient: Option<&mut [f64]>) -> (f64, f64) {
        let mut of_loads = 0.0;
        for (i, (force, u)) in self.loads.iter().zip(displacement).enumerate() {
            of_loads -= force * u;
            if let Some(gradient) = gradient.as_deref_mut() {
                gradient[i] -= force;
            }
        }
        let mut of_points = 0.0;
        for (point, potential) in self.acting_points(displacement) {
            let response = potential.evaluate(point.position(&self.rest, displacement));
            of_points += response.energy;
            if let Some(gradient) = gradient.as_deref_mut() {
                point.spread(&response.gradient, gradient);
            }
        }
        (of_loads, of_points)
    }

    /// Adds the second derivatives of inertia and of points to the tangents.
    fn add_external_tangents(&mut self, displacement: &[f64], inertia: f64) {
        if inertia > 0.0 {
            let corners = self.dimension.corners();
            for (tangent, nodes) in self.tangents.iter_mut().zip(self.elasticity.corners()) {
                for (corner, node) in nodes[..corners].iter().enumerate() {
                    let share = inertia * self.mass[*node as usize] / f64::from(self.valence[*node as usize]);
                    (0..3).for_each(|r| tangent[13 * (3 * corner + r)] += share);
                }
            }
        }
        let Self { groups, points, potentials, rest, tangents, .. } = self;
        let acting = groups.iter().filter(|group| group.may_act(rest, displacement));
        for n in acting.flat_map(|group| group.points.clone()) {
            let (point, response) = (&points[n], potentials[n].evaluate(points[n].position(rest, displacement)));
            if response.hessian != [[0.0; 3]; 3] {
                point.add_hessian(&response.hessian, &mut tangents[point.cell as usize]);
            }
        }
    }

    /// Points that may have energy, with their potentials.
    fn acting_points(&self, displacement: &[f64]) -> impl Iterator<Item = (&CellPotential, &PointPotential)> {
        let acting = self.groups.iter().filter(move |group| group.may_act(&self.rest, displacement));
        acting.flat_map(|group| group.points.clone()).map(|n| (&self.points[n], &self.potentials[n]))
    }

    /// Shows the potentials that may have energy, as they are and as they were at the end of the last step, and where they are.
    fn each_position(&mut self, displacement: &[f64], mut visit: impl FnMut([&mut PointPotential; 2], [f64; 3])) {
        let Self { groups, points, potentials, settled, rest, .. } = self;
        for group in groups.iter_mut().filter(|group| group.may_act(rest, displacement)) {
            for n in group.points.clone() {
                visit([&mut potentials[n], &mut settled[n]], points[n].position(rest, displacement));
            }
            group.note(potentials);
        }
    }

    fn set_loads(&mut self, moment: Moment) {
        let mut shares = Vec::new();
        self.conditions.shares_at(moment.loads, moment.share, &mut shares);
        let springs = self.points.iter().take_while(|point| PointGroup::key(point).is_none());
        shares.extend(springs.map(|spring| spring.schedule.share(moment.loads)));
        if shares == self.shares {
            return;
        }
        self.conditions.loads_at(moment.loads, moment.share, &mut self.loads);
        Self::keep_unknowns((self.dimension, &self.valence), &mut self.loads);
        self.load_norm = norm(&self.loads);
        self.shares = shares;
        for (point, potential) in self.points.iter().zip(&mut self.potentials) {
            if matches!(potential, PointPotential::Spring { .. }) {
                *potential = point.schedule.acting(point.potential, moment.loads);
            }
        }
    }
}

impl Body for SimplexBody {
    fn mass(&self) -> &[f64] {
        &self.mass
    }

    fn set_moment(&mut self, moment: Moment) -> Result<(), TangentError> {
        let holds = &self.conditions.holds;
        if !holds.acting_at(moment.holds).eq(self.acting.iter().copied()) {
            self.constraints = self.constraints_with(&holds.fixed_at(moment.holds, self.rest.len()));
            self.acting = holds.acting_at(moment.holds).collect();
            self.held.fill(0.0);
        }
        holds.prescribe(moment.holds, |node| self.rest[node], &mut self.held);
        Self::keep_unknowns((self.dimension, &self.valence), &mut self.held);
        self.set_loads(moment);
        Ok(())
    }

    fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    fn load_norm(&self) -> f64 {
        self.load_norm
    }

    fn prescribe(&self, displacement: &mut [f64]) {
        for (i, (u, held)) in displacement.iter_mut().zip(&self.held).enumerate() {
            if self.constraints.is_fixed(i / 3, i % 3) {
                *u = *held;
            }
        }
    }

    fn energies(&self, displacement: &[f64]) -> Result<Energies, Inversion> {
        let elastic = self.elasticity.energy(displacement).ok_or(Inversion::NotFinite)?;
        let (loads, points) = self.add_external(displacement, None);
        Ok(Energies { elastic, loads, points })
    }

    fn energy_of_points(&self, displacement: &[f64]) -> Result<f64, Inversion> {
        let energy = |(point, potential): (&CellPotential, &PointPotential)| {
            potential.evaluate(point.position(&self.rest, displacement)).energy
        };
        Ok(self.acting_points(displacement).map(energy).sum())
    }

    fn load_energy(&self, displacement: &[f64]) -> Result<f64, Inversion> {
        Ok(-self.loads.iter().zip(displacement).map(|(force, u)| force * u).sum::<f64>())
    }

    fn gradient(&self, displacement: &[f64], gradient: &mut [f64]) -> Result<Energies, Inversion> {
        gradient.fill(0.0);
        let elastic = self.elasticity.gradient(displacement, gradient).ok_or(Inversion::NotFinite)?;
        let (loads, points) = self.add_external(displacement, Some(gradient));
        Ok(Energies { elastic, loads, points })
    }

    fn linearise(
        &mut self,
        displacement: &[f64],
        weights: QuadraticWeights,
        projection: Projection,
    ) -> Result<(), TangentError> {
        let made = self.elasticity.tangents(displacement, projection, &mut self.tangents);
        made.ok_or(Inversion::NotFinite)?;
        if weights.damping > 0.0 {
            for (to, from) in self.tangents.iter_mut().zip(&self.lagged) {
                to.iter_mut().zip(from).for_each(|(to, from)| *to += weights.damping * from);
            }
        }
        self.add_external_tangents(displacement, weights.mass);
        let tangents = &self.tangents;
        // Lagged: the factor stays until the solver's books of iterations speak for a new one.
        Ok(self.solver.update(|cell| &tangents[cell], &self.constraints, true)?)
    }

    fn multiply(&self, vector: &[f64], product: &mut [f64]) {
        product.fill(0.0);
        add_products((self.elasticity.corners(), &self.tangents), 1.0, vector, product);
    }

    fn solve(&mut self, vector: &mut [f64], tolerance: f64) -> Result<LinearStep, TangentError> {
        let report = self.solver.solve(vector, tolerance)?;
        Ok(LinearStep { iterations: report.iterations, relative_residual: report.relative_residual })
    }

    fn lag_damping(&mut self, displacement: &[f64]) -> Result<(), Inversion> {
        self.lagged.resize(self.tangents.len(), [0.0; 144]);
        let made = self.elasticity.tangents(displacement, Projection::PositiveSemidefinite, &mut self.lagged);
        made.ok_or(Inversion::NotFinite)
    }

    fn add_damping(&self, factor: f64, vector: &[f64], product: &mut [f64]) {
        add_products((self.elasticity.corners(), &self.lagged), factor, vector, product);
    }

    fn renew_friction(&mut self, displacement: &[f64]) -> f64 {
        let mut largest = 0.0f64;
        self.each_position(displacement, |[potential, _], at| largest = largest.max(potential.renew_limit(at)));
        largest
    }

    fn settle_friction(&mut self, displacement: &[f64]) {
        // Others have settled with nothing to hold.
        self.each_position(displacement, |[potential, settled], at| {
            potential.settle(at);
            *settled = *potential;
        });
    }

    fn restore_friction(&mut self) {
        self.potentials.clone_from(&self.settled);
        self.groups.iter_mut().for_each(|group| group.note(&self.potentials));
        // Springs are set anew with the loads.
        self.shares.clear();
        self.shares.push(f64::NAN);
    }
}
