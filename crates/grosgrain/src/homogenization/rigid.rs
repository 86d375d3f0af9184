//! Rigid motions of the parts of a mesh.

use super::parts::{NO_PART, Parts};
use crate::linalg::matrix3::dot;
use crate::linalg::{DenseCholesky, DenseCholeskyError};
use crate::simplex::{Dimension, SimplexMesh};

/// The rigid motions r of each part about its centre, and their integrals against piecewise linear fields.
///
/// There are as many as strains: d translations, then d (d − 1) / 2 rotations, divided by a length of the part.
#[derive(Debug)]
pub(super) struct RigidParts {
    dimension: Dimension,
    part_of: Vec<u32>,
    centres: Vec<[f64; 3]>,
    lengths: Vec<f64>,
    /// M r at each node: ∫ v · r is the sum of v · (M r) over the nodes.
    weighted: Vec<[[f64; 3]; 6]>,
    /// ∫ rᵢ · rⱼ.
    grams: Vec<DenseCholesky>,
}

impl RigidParts {
    pub(super) fn new(mesh: &SimplexMesh, parts: &Parts) -> Result<Self, DenseCholeskyError> {
        let (centres, lengths) = extents(mesh, parts);
        let dimension = mesh.dimension();
        let mut rigid = Self {
            dimension,
            part_of: parts.of_node.clone(),
            centres,
            lengths,
            weighted: Vec::new(),
            grams: Vec::new(),
        };
        rigid.weigh(mesh);
        let n = dimension.strains();
        let mut grams = vec![vec![0.0; n * n]; parts.count()];
        for (node, position) in mesh.nodes().iter().enumerate().filter(|(node, _)| parts.of_node[*node] != NO_PART) {
            let gram = &mut grams[parts.of_node[node] as usize];
            let motions = rigid.motions(node, position);
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                gram[n * i + j] += dot(&motions[i], &rigid.weighted[node][j]);
            }
        }
        rigid.grams = grams.into_iter().map(|gram| DenseCholesky::new(n, gram)).collect::<Result<_, _>>()?;
        Ok(rigid)
    }

    /// Applies the mass matrix of unit density to the motions.
    fn weigh(&mut self, mesh: &SimplexMesh) {
        let corners = mesh.dimension().corners() as f64;
        self.weighted = vec![[[0.0; 3]; 6]; mesh.nodes().len()];
        for cell in 0..mesh.cell_count() {
            let share = mesh.measure(cell) / (corners * (corners + 1.0));
            let nodes = mesh.cell(cell);
            let motions: [[[f64; 3]; 6]; 4] = std::array::from_fn(|n| match nodes.get(n) {
                Some(node) => self.motions(*node as usize, &mesh.nodes()[*node as usize]),
                None => [[0.0; 3]; 6],
            });
            for (n, node) in nodes.iter().enumerate() {
                for (motion, r) in (0..6).flat_map(|motion| (0..3).map(move |r| (motion, r))) {
                    let sum: f64 = motions.iter().map(|of_corner| of_corner[motion][r]).sum();
                    self.weighted[*node as usize][motion][r] += share * (sum + motions[n][motion][r]);
                }
            }
        }
    }

    /// The motions at a node, zero beyond their number.
    fn motions(&self, node: usize, position: &[f64; 3]) -> [[f64; 3]; 6] {
        let part = self.part_of[node] as usize;
        let [x, y, z] = std::array::from_fn(|r| (position[r] - self.centres[part][r]) / self.lengths[part]);
        let mut motions = [[0.0; 3]; 6];
        let turns: &[[f64; 3]] = match self.dimension {
            Dimension::One => &[],
            Dimension::Two => &[[-y, x, 0.0]],
            Dimension::Three => &[[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]],
        };
        let axes = self.dimension.axes();
        (0..axes).for_each(|r| motions[r][r] = 1.0);
        motions[axes..axes + turns.len()].copy_from_slice(turns);
        motions
    }

    /// Takes the rigid motion out of a field in the parts that are `free`, which leaves zero mean and zero first moment ∫ X × u.
    pub(super) fn remove_from_field(&self, mesh: &SimplexMesh, free: &[bool], field: &mut [[f64; 3]]) {
        let shares = self.shares(field, &|node| self.weighted[node]);
        for (node, value) in field.iter_mut().enumerate().filter(|(node, _)| self.part_of[*node] != NO_PART) {
            let part = self.part_of[node] as usize;
            if free[part] {
                subtract(value, &shares[part], &self.motions(node, &mesh.nodes()[node]));
            }
        }
    }

    /// Takes the resultant force and moment out of the loads of the parts that are `free`, by a body force that is a rigid motion; returns the share of the norm taken away.
    pub(super) fn balance_loads(&self, mesh: &SimplexMesh, free: &[bool], loads: &mut [[f64; 3]]) -> f64 {
        let shares = self.shares(loads, &|node| self.motions(node, &mesh.nodes()[node]));
        let (mut taken, mut whole) = (0.0, 0.0);
        for (node, load) in loads.iter_mut().enumerate().filter(|(node, _)| self.part_of[*node] != NO_PART) {
            let (before, part) = (*load, self.part_of[node] as usize);
            whole += dot(&before, &before);
            if free[part] {
                subtract(load, &shares[part], &self.weighted[node]);
                taken += (0..3).map(|r| (before[r] - load[r]).powi(2)).sum::<f64>();
            }
        }
        if whole > 0.0 { (taken / whole).sqrt() } else { 0.0 }
    }

    /// Gram⁻¹ Σ test · v per part.
    fn shares(&self, values: &[[f64; 3]], test: &dyn Fn(usize) -> [[f64; 3]; 6]) -> Vec<[f64; 6]> {
        let mut shares = vec![[0.0; 6]; self.grams.len()];
        for (node, value) in values.iter().enumerate().filter(|(node, _)| self.part_of[*node] != NO_PART) {
            let share = &mut shares[self.part_of[node] as usize];
            share.iter_mut().zip(test(node)).for_each(|(sum, test)| *sum += dot(&test, value));
        }
        let n = self.dimension.strains();
        shares.iter_mut().zip(&self.grams).for_each(|(share, gram)| gram.solve_in_place(&mut share[..n]));
        shares
    }
}

fn subtract(value: &mut [f64; 3], share: &[f64; 6], vectors: &[[f64; 3]; 6]) {
    for (r, value) in value.iter_mut().enumerate() {
        *value -= share.iter().zip(vectors).map(|(share, vector)| share * vector[r]).sum::<f64>();
    }
}

/// Centres of mass of the parts, and the distance of the farthest node from each.
fn extents(mesh: &SimplexMesh, parts: &Parts) -> (Vec<[f64; 3]>, Vec<f64>) {
    let (mut moments, mut measures) = (vec![[0.0; 3]; parts.count()], vec![0.0; parts.count()]);
    let part_of = |cell: usize| parts.of_node[mesh.cell(cell)[0] as usize] as usize;
    for cell in 0..mesh.cell_count() {
        let (nodes, measure, part) = (mesh.cell(cell), mesh.measure(cell), part_of(cell));
        measures[part] += measure;
        for (node, r) in nodes.iter().flat_map(|node| (0..3).map(move |r| (node, r))) {
            moments[part][r] += measure / nodes.len() as f64 * mesh.nodes()[*node as usize][r];
        }
    }
    let centres: Vec<[f64; 3]> =
        moments.iter().zip(&measures).map(|(moment, measure)| moment.map(|m| m / measure)).collect();
    let mut lengths = vec![0.0f64; parts.count()];
    for (node, part) in parts.of_node.iter().enumerate().filter(|(_, part)| **part != NO_PART) {
        let part = *part as usize;
        let arm: [f64; 3] = std::array::from_fn(|r| mesh.nodes()[node][r] - centres[part][r]);
        lengths[part] = lengths[part].max(dot(&arm, &arm).sqrt());
    }
    (centres, lengths)
}
