//! Points that move with elements: nodes of the fine lattice, and weighted means of them.

use rayon::prelude::*;

use super::frame::{Columns, Frame, LocalCurvature, LocalForces};
use super::place::Place;
use super::potential::Potential;
use crate::coarse::CoarseModel;
use crate::coarsening::COLUMNS;
use crate::linalg::matrix3::{Matrix3, apply, apply_transposed, cross, product, skew, transposed};
use crate::material::Projection;
use crate::mesh::Node;

/// A point that moves with an element: it is at c + t + R (X̄ + M̄ v), with c the reference centre of the coarse cell and t the mean displacement of its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmbeddedPoint {
    /// Number of the element.
    pub element: u32,
    /// M̄, three rows.
    pub functions: [[f64; COLUMNS]; 3],
    /// X̄ relative to the centre of the coarse cell \[m\].
    pub reference: [f64; 3],
    /// By what its potential is multiplied.
    pub share: f64,
}

impl EmbeddedPoint {
    /// Where fine node `node` is, once for each of the m elements that touch it, with share 1/m: the elements of
    /// [`Embedding::members`](crate::coarse::Embedding::members), ascending. None where the node touches voids only.
    pub fn of_node(coarse: &CoarseModel, node: Node) -> Vec<Self> {
        let (mesh, partition) = (coarse.mesh(), coarse.partition());
        let mut elements: Vec<usize> = partition.fine().cells_at(node).filter_map(|c| mesh.element_at(c)).collect();
        elements.sort_unstable();
        elements.dedup();
        let share = 1.0 / elements.len() as f64;
        elements.iter().map(|&element| Self::in_element(coarse, element, &[(node, 1.0)], share)).collect()
    }

    /// The weighted sum of fine nodes as element number `element` sees them: M̄ = Σ w_j M_j, X̄ = Σ w_j X_j.
    ///
    /// # Panics
    /// Panics when a node is not one of the element's coarse cell.
    pub fn in_element(coarse: &CoarseModel, element: usize, nodes: &[(Node, f64)], share: f64) -> Self {
        let partition = coarse.partition();
        let start = partition.cell_box(coarse.elements()[element].cell).start;
        let place = Place::new(coarse, [0.0; 3]);
        let mut point = Self { element: element as u32, functions: [[0.0; COLUMNS]; 3], reference: [0.0; 3], share };
        for &(node, weight) in nodes {
            let at = partition.fine().node_position(node);
            let inside: [usize; 3] = std::array::from_fn(|a| at[a] - start[a]);
            let position = place.cell.node(inside, partition.degree());
            let local = partition.cell_lattice().node(inside).0;
            for r in 0..3 {
                point.reference[r] += weight * position[r];
                let row = &coarse.functions().of(element)[COLUMNS * (3 * local + r)..][..COLUMNS];
                point.functions[r].iter_mut().zip(row).for_each(|(sum, w)| *sum += weight * w);
            }
        }
        point
    }

    /// X̄ + M̄ v.
    fn local(&self, v: &Columns) -> [f64; 3] {
        let moved = |r: usize| self.functions[r].iter().zip(v).map(|(m, v)| m * v).sum::<f64>();
        std::array::from_fn(|r| self.reference[r] + moved(r))
    }

    /// Position in space \[m\] with the reference centre at `centre`.
    pub(super) fn position(&self, frame: &Frame, centre: [f64; 3]) -> [f64; 3] {
        let offset = apply(&frame.rotation, &self.local(&frame.local));
        std::array::from_fn(|r| centre[r] + frame.shift[r] + offset[r])
    }

    /// Energy \[J\] and what the point's potential adds to the derivatives.
    pub(super) fn add_forces(
        &self,
        frame: &Frame,
        (potential, centre): (&dyn Potential, [f64; 3]),
        forces: &mut LocalForces,
    ) -> f64 {
        let (energy, force, _) = self.response(frame, potential, centre);
        add_force(&self.functions, self.local(&frame.local), &force, forces);
        energy
    }

    /// The same for the second derivatives; `forces` must hold the first ones if they are to be exact.
    pub(super) fn add_curvature(
        &self,
        frame: &Frame,
        (potential, centre): (&dyn Potential, [f64; 3]),
        projection: Projection,
        (forces, curvature): (&mut LocalForces, &mut LocalCurvature),
    ) {
        let (_, force, hessian) = self.response(frame, potential, centre);
        let at = self.local(&frame.local);
        add_force(&self.functions, at, &force, forces);
        add_hessian(&self.functions, at, &hessian, curvature);
        if projection == Projection::Exact {
            add_turning_force(&self.functions, at, &force, curvature);
        }
    }

    /// Energy, gradient and Hessian of the potential in the rotated frame.
    fn response(&self, frame: &Frame, potential: &dyn Potential, centre: [f64; 3]) -> (f64, [f64; 3], Matrix3) {
        let (energy, gradient, hessian) = potential.evaluate(self.position(frame, centre));
        let (rotation, share) = (&frame.rotation, self.share);
        let hessian = product(&transposed(rotation), &product(&hessian, rotation));
        let force = apply_transposed(rotation, &gradient);
        (share * energy, force.map(|f| share * f), hessian.map(|row| row.map(|h| share * h)))
    }
}

/// A gradient `force` at the point `at` with functions M, all in the rotated frame: g += Mᵀ f, θ += at × f.
pub(super) fn add_force(functions: &[Columns; 3], at: [f64; 3], force: &[f64; 3], forces: &mut LocalForces) {
    for (row, f) in functions.iter().zip(force) {
        forces.gradient.iter_mut().zip(row).for_each(|(g, m)| *g += f * m);
    }
    let moment = cross(&at, force);
    (0..3).for_each(|k| forces.couple[k] += moment[k]);
}

/// A Hessian D at a point, which moves by M δv − \[z\]× w in the rotated frame: K += Mᵀ D M, B −= Mᵀ D \[z\]×, C += \[z\]×ᵀ D \[z\]×.
fn add_hessian(functions: &[Columns; 3], at: [f64; 3], hessian: &Matrix3, curvature: &mut LocalCurvature) {
    let carried: [Columns; 3] =
        std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|s| hessian[r][s] * functions[s][c]).sum()));
    for (a, b) in (0..COLUMNS).flat_map(|a| (a..COLUMNS).map(move |b| (a, b))) {
        let entry: f64 = (0..3).map(|r| functions[r][a] * carried[r][b]).sum();
        curvature.stiffness[a][b] += entry;
        if a != b {
            curvature.stiffness[b][a] += entry;
        }
    }
    let lever = skew(&at).map(|row| row.map(|v| -v));
    for (k, r) in (0..9).map(|n| (n / 3, n % 3)).filter(|(k, r)| k != r) {
        curvature.mixed[k].iter_mut().zip(&carried[r]).for_each(|(b, m)| *b += lever[r][k] * m);
    }
    let square = product(&transposed(&lever), &product(hessian, &lever));
    (0..9).for_each(|n| curvature.rotational[n / 3][n % 3] += 0.5 * (square[n / 3][n % 3] + square[n % 3][n / 3]));
}

/// What a force does as the frame turns: B += Mᵀ \[f\]×, C += sym(z ⊗ f) − z·f I.
pub(super) fn add_turning_force(
    functions: &[Columns; 3],
    at: [f64; 3],
    force: &[f64; 3],
    curvature: &mut LocalCurvature,
) {
    let lever = skew(force);
    for (k, r) in (0..9).map(|n| (n / 3, n % 3)).filter(|(k, r)| k != r) {
        curvature.mixed[k].iter_mut().zip(&functions[r]).for_each(|(b, m)| *b += lever[r][k] * m);
    }
    add_turning_moment(&std::array::from_fn(|r| force.map(|f| at[r] * f)), &mut curvature.rotational);
}

/// C += sym Γ − tr Γ I for Γ = Σ z ⊗ f.
pub(super) fn add_turning_moment(moment: &Matrix3, rotational: &mut Matrix3) {
    let trace = moment[0][0] + moment[1][1] + moment[2][2];
    (0..9).for_each(|n| rotational[n / 3][n % 3] += 0.5 * (moment[n / 3][n % 3] + moment[n % 3][n / 3]));
    (0..3).for_each(|r| rotational[r][r] -= trace);
}

/// The points in the order in which they were given, found by element.
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    pub all: Vec<EmbeddedPoint>,
    /// Numbers of the points, by element.
    order: Vec<u32>,
    /// First entry of each element in `order`, and the number of points; empty where there are no points.
    first: Vec<u32>,
}

impl Points {
    /// Sorts points of a model with `elements` elements.
    ///
    /// # Panics
    /// Panics when a point is in an element that is not there.
    pub fn new(all: Vec<EmbeddedPoint>, elements: usize) -> Self {
        let mut first = vec![0u32; elements + 1];
        all.iter().for_each(|point| first[point.element as usize + 1] += 1);
        (0..elements).for_each(|e| first[e + 1] += first[e]);
        let mut order: Vec<u32> = (0..all.len() as u32).collect();
        order.sort_by_key(|n| all[*n as usize].element);
        Self { all, order, first }
    }

    /// Numbers of the points of each element that has some, elements ascending.
    pub fn by_element(&self) -> impl ParallelIterator<Item = &[u32]> {
        self.order.par_chunk_by(|a, b| self.all[*a as usize].element == self.all[*b as usize].element)
    }

    /// Numbers of the points of an element, ascending.
    pub fn of(&self, element: usize) -> &[u32] {
        match self.all.is_empty() {
            true => &[],
            false => &self.order[self.first[element] as usize..self.first[element + 1] as usize],
        }
    }
}
