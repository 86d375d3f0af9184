//! The coarse model under large rotations.

use rayon::prelude::*;

use super::cells::{ElementCells, Shared};
use super::elastic::{ElasticElement, Workspace};
use super::error::CorotatedError;
use super::frame::{CoarseBox, Columns, Frame, LocalCurvature, LocalForces};
use super::integration::{Integration, SharedMaterial};
use super::loads::DeadLoad;
use super::place::Place;
use super::points::{EmbeddedPoint, Points};
use super::potential::Potential;
use super::products::prolong;
use crate::coarse::{CoarseModel, Embedding};
use crate::coarsening::COLUMNS;
use crate::element::CellMatrix;
use crate::fine::{FineModel, SingleCell};
use crate::linalg::matrix3::apply;
use crate::material::Projection;
use crate::mesh::Node;
use crate::partition::{CellPart, PerElement};

/// Energy, forces and tangents of a coarse model whose elements rotate: a function of the displacements u of the vertices.
///
/// An element with a fine cell whose [`Law`](crate::material::Law) is for large deformation has the rotation R of its deformation gradient at the
/// centre; the others keep R = I and are linear. The gradient is that of the energy, with the dependence of R on the vertices, so rigid motions
/// change no energy and forces have no resultant and no moment. All methods take the coarse model that [`new`](Self::new) took, in its present state.
#[derive(Clone, Debug)]
pub struct Corotated {
    shared: Shared,
    place: Place,
    elements: PerElement<ElementCells>,
    /// One per element, empty where there are none.
    loads: Vec<Option<Box<DeadLoad>>>,
    points: Points,
}

/// Energies of all elements \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElementEnergies {
    /// Elastic energy, zero at rest.
    pub elastic: f64,
    /// Potential energy of the dead loads, zero at rest: minus their work.
    pub loads: f64,
    /// Energy of the potentials of embedded points.
    pub points: f64,
}

impl ElementEnergies {
    /// The sum.
    pub fn total(&self) -> f64 {
        self.elastic + self.loads + self.points
    }

    fn add(&mut self, other: &Self) {
        self.elastic += other.elastic;
        self.loads += other.loads;
        self.points += other.points;
    }
}

/// What an evaluation depends on.
struct State<'a> {
    coarse: &'a CoarseModel,
    u: &'a [f64],
    potentials: &'a [&'a dyn Potential],
}

impl Corotated {
    /// The elements of `coarse`, which was made from `fine`, without loads and points.
    ///
    /// # Panics
    /// Panics when `coarse` belongs to a body of other materials or another size.
    pub fn new(fine: &FineModel, coarse: &CoarseModel, integration: Integration) -> Self {
        let shared = Shared {
            cell: CoarseBox::new(coarse.spacing()),
            integration,
            fine_cell: SingleCell::new(fine.grid().spacing),
            materials: SharedMaterial::all(fine),
            lattice: coarse.partition().cell_lattice(),
        };
        let elements = element_cells(fine, coarse, &shared, coarse.elements());
        let place = Place::new(coarse, fine.grid().origin);
        Self { shared, place, elements, loads: Vec::new(), points: Points::default() }
    }

    /// Takes over a changed body and its coarse model: `dirty` lists, ascending, all elements whose functions, stiffness or fine cells have changed. The result
    /// is that of [`new`](Self::new) bit for bit: loads and points go, because elements may have other numbers now.
    ///
    /// # Panics
    /// Panics when an element of `coarse` is new but not in `dirty`, or one of `dirty` is not there.
    pub fn renew(&mut self, fine: &FineModel, coarse: &CoarseModel, dirty: &[CellPart]) {
        let renewed = element_cells(fine, coarse, &self.shared, dirty);
        self.elements.replace(coarse.elements(), renewed);
        self.loads.clear();
        self.points = Points::default();
    }

    /// How the elastic energy is found.
    pub fn integration(&self) -> Integration {
        self.shared.integration
    }

    /// Whether element number `index` has a frame that rotates.
    pub fn rotates(&self, index: usize) -> bool {
        self.elements.values()[index].rotates
    }

    /// Replaces the dead loads: forces \[N\], three per fine lattice node, that keep their direction in space. At a node of several elements each
    /// carries an equal share. They are summed up per element here; evaluations do not visit the nodes.
    ///
    /// # Panics
    /// Panics when there are not three loads per fine node.
    pub fn set_loads(&mut self, coarse: &CoarseModel, embedding: &Embedding<'_>, loads: &[f64]) {
        assert_eq!(loads.len(), 3 * embedding.multiplicity().len(), "three loads per fine node");
        let place = &self.place;
        let load = |index: usize| DeadLoad::new((coarse, place), embedding, index, loads).map(Box::new);
        self.loads = (0..coarse.elements().len()).into_par_iter().map(load).collect();
    }

    /// Replaces the embedded points; potentials are given in their order.
    ///
    /// # Panics
    /// Panics when a point is in an element that is not there.
    pub fn set_points(&mut self, points: Vec<EmbeddedPoint>) {
        self.points = Points::new(points, self.elements.elements().len());
    }

    /// The embedded points.
    pub fn points(&self) -> &[EmbeddedPoint] {
        &self.points.all
    }

    /// Energies at vertex displacements `u` \[m\], three per vertex; `potentials` has one entry per embedded point.
    ///
    /// # Errors
    /// A collapsed element or an inverted fine cell, the first in the order of elements.
    ///
    /// # Panics
    /// Panics when `u` or `potentials` has another length, or `coarse` is another model.
    pub fn energy<P: Potential>(
        &self,
        coarse: &CoarseModel,
        u: &[f64],
        potentials: &[P],
    ) -> Result<ElementEnergies, CorotatedError> {
        self.check(coarse, u, potentials.len());
        let state = State { coarse, u, potentials: &by_reference(potentials) };
        let mut energies = ElementEnergies::default();
        for part in self.each_element(coarse, |index, room| Ok(self.evaluate(&state, index, room, None)?.0)) {
            energies.add(&part?);
        }
        Ok(energies)
    }

    /// Potential energy of the dead loads \[J\], zero at rest.
    ///
    /// # Errors
    /// A collapsed element.
    ///
    /// # Panics
    /// Panics when `u` has not three entries per vertex, or `coarse` is another model.
    pub fn load_energy(&self, coarse: &CoarseModel, u: &[f64]) -> Result<f64, CorotatedError> {
        self.check(coarse, u, self.points.all.len());
        let mut energy = 0.0;
        for (index, load) in self.loads.iter().enumerate() {
            if let Some(load) = load {
                energy += load.energy(&self.frame(coarse, index, u)?);
            }
        }
        Ok(energy)
    }

    /// Adds ∂E/∂u \[N\], three per vertex, to `out`, and returns the energies E. On errors `out` stays as it is.
    ///
    /// # Errors
    /// As [`energy`](Self::energy).
    ///
    /// # Panics
    /// As [`energy`](Self::energy).
    pub fn gradient<P: Potential>(
        &self,
        coarse: &CoarseModel,
        u: &[f64],
        potentials: &[P],
        out: &mut [f64],
    ) -> Result<ElementEnergies, CorotatedError> {
        self.check(coarse, u, potentials.len());
        assert_eq!(out.len(), u.len(), "three entries per vertex");
        let state = State { coarse, u, potentials: &by_reference(potentials) };
        let with_forces = |index: usize, room: &mut Workspace| {
            let mut forces = LocalForces::ZERO;
            let (energies, frame) = self.evaluate(&state, index, room, Some(&mut forces))?;
            Ok((energies, frame.gradient(&self.shared.cell, &forces)))
        };
        let parts = self.each_element(coarse, with_forces);
        let parts: Vec<(ElementEnergies, Columns)> = parts.into_iter().collect::<Result<_, _>>()?;
        let mut energies = ElementEnergies::default();
        for ((part, forces), corners) in parts.iter().zip(coarse.mesh().corners()) {
            energies.add(part);
            for (vertex, force) in corners.iter().zip(forces.chunks_exact(3)) {
                (0..3).for_each(|r| out[3 * *vertex as usize + r] += force[r]);
            }
        }
        Ok(energies)
    }

    /// The Hessian of every element's energy \[N/m\] in the axes of space, 24×24 for its eight corners; `out` is given one entry per element. Symmetric bit
    /// for bit. With [`Projection::Exact`] the derivatives of [`gradient`](Self::gradient); with [`Projection::PositiveSemidefinite`] Jᵀ K J
    /// with projected material tangents and J the first derivative of the displacement in the rotated frame, positive semidefinite up to rounding.
    ///
    /// # Errors
    /// As [`energy`](Self::energy).
    ///
    /// # Panics
    /// As [`energy`](Self::energy).
    pub fn tangents<P: Potential>(
        &self,
        coarse: &CoarseModel,
        u: &[f64],
        potentials: &[P],
        projection: Projection,
        out: &mut Vec<CellMatrix>,
    ) -> Result<(), CorotatedError> {
        self.check(coarse, u, potentials.len());
        let state = State { coarse, u, potentials: &by_reference(potentials) };
        out.resize(coarse.elements().len(), [0.0; COLUMNS * COLUMNS]);
        let outcomes: Vec<Result<(), CorotatedError>> = out
            .par_iter_mut()
            .enumerate()
            .map_init(
                || Workspace::new(coarse.functions().rows()),
                |room, (index, matrix)| self.tangent(&state, index, room, (projection, matrix)),
            )
            .collect();
        outcomes.into_iter().collect()
    }

    /// Positions \[m\] of the embedded points.
    ///
    /// # Errors
    /// A collapsed element.
    ///
    /// # Panics
    /// Panics when `u` has not three entries per vertex, or `coarse` is another model.
    pub fn positions(&self, coarse: &CoarseModel, u: &[f64], out: &mut Vec<[f64; 3]>) -> Result<(), CorotatedError> {
        self.check(coarse, u, self.points.all.len());
        let of_element = |numbers: &[u32]| {
            let index = self.points.all[numbers[0] as usize].element as usize;
            let frame = self.frame(coarse, index, u);
            let centre = self.place.centre(coarse, coarse.elements()[index]);
            let position = move |n: &u32| Ok((*n, self.points.all[*n as usize].position(&frame?, centre)));
            numbers.iter().map(position).collect::<Vec<Result<(u32, [f64; 3]), CorotatedError>>>()
        };
        let groups = self.points.by_element();
        let found: Vec<Result<(u32, [f64; 3]), CorotatedError>> = groups.flat_map_iter(of_element).collect();
        out.clear();
        out.resize(self.points.all.len(), [0.0; 3]);
        for position in found {
            let (number, at) = position?;
            out[number as usize] = at;
        }
        Ok(())
    }

    /// The displacement of the fine nodes \[m\], three per lattice node: t + R (X_j + M_j v) − X_j in each element, averaged where elements meet like
    /// [`Embedding::prolong`]. Void nodes are zero.
    ///
    /// # Errors
    /// A collapsed element.
    ///
    /// # Panics
    /// Panics when `u` has not three entries per vertex, or `coarse` is another model.
    pub fn prolong(
        &self,
        coarse: &CoarseModel,
        embedding: &Embedding<'_>,
        u: &[f64],
    ) -> Result<Vec<f64>, CorotatedError> {
        self.check(coarse, u, self.points.all.len());
        let (lattice, degree) = (coarse.partition().cell_lattice(), coarse.partition().degree());
        let mut fine = vec![0.0; 3 * embedding.multiplicity().len()];
        let mut moved = vec![0.0; coarse.functions().rows()];
        for index in 0..coarse.elements().len() {
            let frame = self.frame(coarse, index, u)?;
            prolong(coarse.functions().of(index), &frame.local, &mut moved);
            for &(local, node) in embedding.members(index) {
                let share = 1.0 / f64::from(embedding.multiplicity()[node as usize]);
                let at = self.shared.cell.node(lattice.node_position(Node(local as usize)), degree);
                let by = &moved[3 * local as usize..][..3];
                let shift = match frame.rotates {
                    false => [by[0], by[1], by[2]],
                    true => {
                        let to = apply(&frame.rotation, &[at[0] + by[0], at[1] + by[1], at[2] + by[2]]);
                        std::array::from_fn(|r| frame.shift[r] + (to[r] - at[r]))
                    }
                };
                (0..3).for_each(|r| fine[3 * node as usize + r] += share * shift[r]);
            }
        }
        Ok(fine)
    }

    fn check(&self, coarse: &CoarseModel, u: &[f64], potentials: usize) {
        assert_eq!(self.elements.elements().len(), coarse.elements().len(), "the elements of another model");
        assert_eq!(u.len(), 3 * coarse.mesh().vertices().len(), "three displacements per vertex");
        assert_eq!(potentials, self.points.all.len(), "one potential per embedded point");
    }

    /// One value per element, in their order; errors too, so that the first one does not depend on threads.
    fn each_element<T: Send>(
        &self,
        coarse: &CoarseModel,
        of_element: impl Fn(usize, &mut Workspace) -> Result<T, CorotatedError> + Sync,
    ) -> Vec<Result<T, CorotatedError>> {
        let room = || Workspace::new(coarse.functions().rows());
        let elements = (0..coarse.elements().len()).into_par_iter();
        elements.map_init(room, |room, index| of_element(index, room)).collect()
    }

    fn frame(&self, coarse: &CoarseModel, index: usize, u: &[f64]) -> Result<Frame, CorotatedError> {
        let displacement = Place::displacement(coarse, index, u);
        if !self.rotates(index) {
            return Ok(Frame::fixed(&self.shared.cell, &displacement));
        }
        let at = Place::at(coarse, coarse.elements()[index]);
        Frame::rotating(&self.shared.cell, &displacement)
            .map_err(|determinant| CorotatedError::Collapsed { at, determinant })
    }

    fn elastic<'a>(&'a self, coarse: &'a CoarseModel, index: usize) -> ElasticElement<'a> {
        ElasticElement {
            shared: &self.shared,
            cells: &self.elements.values()[index],
            functions: coarse.functions().of(index),
            stiffness: coarse.stiffness(index),
            fine: coarse.partition().fine(),
            start: coarse.partition().cell_box(coarse.elements()[index].cell).start,
        }
    }

    fn load(&self, index: usize) -> Option<&DeadLoad> {
        self.loads.get(index)?.as_deref()
    }

    fn evaluate(
        &self,
        state: &State<'_>,
        index: usize,
        room: &mut Workspace,
        mut forces: Option<&mut LocalForces>,
    ) -> Result<(ElementEnergies, Frame), CorotatedError> {
        let frame = self.frame(state.coarse, index, state.u)?;
        let elastic = self.elastic(state.coarse, index).energy(&frame, room, forces.as_deref_mut())?;
        let mut energies = ElementEnergies { elastic, ..ElementEnergies::default() };
        if let Some(load) = self.load(index) {
            energies.loads = load.energy(&frame);
            if let Some(forces) = forces.as_deref_mut() {
                load.add_forces(&frame, forces);
            }
        }
        let mut unused = LocalForces::ZERO;
        let forces = forces.unwrap_or(&mut unused);
        for (point, potential, centre) in self.points_of(state, index) {
            energies.points += point.add_forces(&frame, (potential, centre), forces);
        }
        Ok((energies, frame))
    }

    fn tangent(
        &self,
        state: &State<'_>,
        index: usize,
        room: &mut Workspace,
        (projection, out): (Projection, &mut CellMatrix),
    ) -> Result<(), CorotatedError> {
        let frame = self.frame(state.coarse, index, state.u)?;
        let (mut forces, mut curvature) = (LocalForces::ZERO, LocalCurvature::ZERO);
        let derivatives = (&mut forces, &mut curvature);
        self.elastic(state.coarse, index).add_curvature(&frame, room, projection, derivatives)?;
        let exact = projection == Projection::Exact;
        if let Some(load) = self.load(index).filter(|_| exact && frame.rotates) {
            load.add_forces(&frame, &mut forces);
            load.add_curvature(&frame, &mut curvature);
        }
        for (point, potential, centre) in self.points_of(state, index) {
            point.add_curvature(&frame, (potential, centre), projection, (&mut forces, &mut curvature));
        }
        let hessian = frame.hessian(&self.shared.cell, &curvature, exact.then_some(&forces));
        out.copy_from_slice(hessian.as_flattened());
        Ok(())
    }

    /// The points of an element with their potentials and the element's reference centre.
    fn points_of<'a>(
        &'a self,
        state: &State<'a>,
        index: usize,
    ) -> impl Iterator<Item = (&'a EmbeddedPoint, &'a dyn Potential, [f64; 3])> {
        let centre = self.place.centre(state.coarse, state.coarse.elements()[index]);
        let potentials = state.potentials;
        let numbers = self.points.of(index).iter().map(|n| *n as usize);
        numbers.map(move |n| (&self.points.all[n], potentials[n], centre))
    }
}

fn by_reference<P: Potential>(potentials: &[P]) -> Vec<&dyn Potential> {
    potentials.iter().map(|potential| potential as &dyn Potential).collect()
}

fn element_cells(
    fine: &FineModel,
    coarse: &CoarseModel,
    shared: &Shared,
    elements: &[CellPart],
) -> PerElement<ElementCells> {
    let mesh = coarse.mesh();
    let of_element = |element: &CellPart| {
        let Some(index) = mesh.index_of(*element) else { panic!("{element:?} is not in the coarse model") };
        ElementCells::new(fine, mesh, (*element, coarse.functions().of(index)), shared)
    };
    PerElement::new(elements.to_vec(), elements.par_iter().map(of_element).collect())
}
