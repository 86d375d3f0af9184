//! Harmonic displacements of a body: loads, solution, choice of the rigid motion.

use super::parts::Parts;
use super::rigid::RigidParts;
use super::supports::Supports;
use super::system::{NodalVectors, start};
use super::{HarmonicDisplacements, SimplexModel, SimplexSystem, SimplexSystemError};
use crate::linalg::DenseCholeskyError;
use crate::linalg::matrix3::dot;
use crate::progress::Progress;
use crate::simplex::{Boundary, BoundaryError, Dimension, SimplexMesh};

/// How harmonic displacements are loaded and held. The default is the published one: a free body under tractions by its own normals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HarmonicOptions {
    /// Which nodes are held to zero, where it is known which will be in use (`kharevych2009numerical`, §3.8); empty for none. A part of the body in which no node is held stays free.
    pub held: Vec<bool>,
    /// The normal n of the traction σ n on each face of [`Boundary::outer`], of any length, instead of its own, such as that of the coarse boundary around it, see [`bounding_normals`](super::bounding_normals) (§4.2); empty for
    /// their own. The forces then no longer balance; what does not is taken out of a free part, see [`HarmonicReport::unbalanced`].
    pub normals: Vec<[f64; 3]>,
}

/// What it took to find harmonic displacements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HarmonicReport {
    /// Parts of the body: cells that hang together by nodes.
    pub parts: usize,
    /// Whether cells hang together by an edge or a node alone somewhere, so that the body is a mechanism or nearly one.
    pub has_hinges: bool,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Entries of the factor; eight bytes each.
    pub factor_entries: usize,
    /// Multiplications and additions of the factorisation.
    pub factor_flops: f64,
    /// Largest relative residual ‖f − K h‖ / ‖f‖.
    pub residual: f64,
    /// Largest share of the norm of the nodal forces that had to be taken away from free parts because it had a resultant force or moment; rounding unless normals are given.
    pub unbalanced: f64,
}

/// Why there are no harmonic displacements.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HarmonicError {
    /// The system was not solved.
    #[error(transparent)]
    System(#[from] SimplexSystemError),
    /// Held nodes are not marked one by one.
    #[error("{marks} marks of held nodes for {nodes} nodes; give one per node, or none")]
    Held {
        /// Number of marks.
        marks: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// Held nodes let a part turn.
    #[error(
        "{held} of {nodes} nodes of the part with cell {cell} are held, but it can still turn; hold nodes that do not lie on a line"
    )]
    Turns {
        /// Number of held nodes of the part.
        held: usize,
        /// Number of its nodes.
        nodes: usize,
        /// Its first cell, from 0.
        cell: usize,
    },
    /// The mesh has no boundary.
    #[error(transparent)]
    Boundary(#[from] BoundaryError),
    /// Normals are not those of the outer faces.
    #[error("{normals} normals for {faces} outer faces; give one per face, or none")]
    Normals {
        /// Number of normals.
        normals: usize,
        /// Number of outer faces.
        faces: usize,
    },
    /// A normal has no direction.
    #[error("the normal of outer face {face} is ({}, {}, {}), which has no direction", normal[0], normal[1], normal[2])]
    Normal {
        /// The face, from 0.
        face: usize,
        /// The normal.
        normal: [f64; 3],
    },
    /// A part is so thin that its turns cannot be told from its displacements.
    #[error("a part of the body is too thin for its rigid motions to be told apart: {0}")]
    Thin(DenseCholeskyError),
}

/// The harmonic displacements of a body (`kharevych2009numerical`, eq. 6): for each unit stress σ_αβ the solution of div(C : ε(h)) = 0 with traction σ_αβ n on the outer boundary
/// and none in cavities, by linear displacements in each cell.
///
/// In each part of the body that is not held, h has zero mean and zero first moment ∫ X × h.
///
/// # Errors
/// Options that do not fit the mesh; held nodes that let a part turn; a stiffness that is not positive definite or too ill-conditioned; interruption by `progress`.
pub fn harmonic_displacements(
    model: &SimplexModel,
    options: &HarmonicOptions,
    progress: Progress<'_>,
) -> Result<(HarmonicDisplacements, HarmonicReport), HarmonicError> {
    let mesh = model.mesh();
    let (marks, nodes) = (options.held.len(), mesh.nodes().len());
    if marks != 0 && marks != nodes {
        return Err(HarmonicError::Held { marks, nodes });
    }
    let parts = Parts::new(mesh);
    let supports = Supports::new(mesh, &parts, &options.held)?;
    let rigid = RigidParts::new(mesh, &parts).map_err(HarmonicError::Thin)?;
    let mut loads = harmonic_loads(mesh, &options.normals)?;
    let shares = loads.iter_mut().map(|load| rigid.balance_loads(mesh, &supports.free, load));
    let unbalanced = shares.fold(0.0, f64::max);
    let mut system = SimplexSystem::new(model, &supports.fixed, supports.holding, loads.len(), progress)?;
    start("solving", progress)?;
    let (mut columns, residual) = system.solve(&loads)?;
    columns.iter_mut().for_each(|field| rigid.remove_from_field(mesh, &supports.free, field));
    let report = HarmonicReport {
        parts: parts.count(),
        has_hinges: parts.has_hinges,
        unknowns: system.unknowns(),
        factor_entries: system.factor_entries(),
        factor_flops: system.factor_flops(),
        residual,
        unbalanced,
    };
    Ok((HarmonicDisplacements { fields: interleaved(&columns, nodes) }, report))
}

/// Nodal forces \[N\] of each unit stress σ_αβ = ½ (e_α ⊗ e_β + e_β ⊗ e_α) \[1 Pa\] on the outer boundary, in the order of
/// [`HarmonicDisplacements::fields`]: each face gives its traction σ n times its area to its nodes in equal shares.
///
/// # Errors
/// A mesh without a boundary that divides inside from outside; normals that are not one per face of [`Boundary::outer`], or have no direction.
pub fn harmonic_loads(mesh: &SimplexMesh, normals: &[[f64; 3]]) -> Result<NodalVectors, HarmonicError> {
    let boundary = Boundary::of_mesh(mesh)?;
    let faces: Vec<&[u32]> = boundary.outer().map(|face| face.nodes()).collect();
    let areas = turned(boundary.outer().map(|face| face.normal).collect(), normals)?;
    let load = |&(a, b): &(usize, usize)| {
        let mut load = vec![[0.0; 3]; mesh.nodes().len()];
        for (nodes, area) in faces.iter().zip(&areas) {
            for node in *nodes {
                load[*node as usize][a] += 0.5 * area[b] / nodes.len() as f64;
                load[*node as usize][b] += 0.5 * area[a] / nodes.len() as f64;
            }
        }
        load
    };
    Ok(stress_axes(mesh.dimension()).iter().map(load).collect())
}

/// Area vectors along other normals.
fn turned(mut areas: Vec<[f64; 3]>, normals: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, HarmonicError> {
    if !normals.is_empty() && normals.len() != areas.len() {
        return Err(HarmonicError::Normals { normals: normals.len(), faces: areas.len() });
    }
    for (face, (area, normal)) in areas.iter_mut().zip(normals).enumerate() {
        let (measure, length) = (dot(area, area).sqrt(), dot(normal, normal).sqrt());
        if !(length > 0.0 && length.is_finite()) {
            return Err(HarmonicError::Normal { face, normal: *normal });
        }
        *area = normal.map(|n| measure / length * n);
    }
    Ok(areas)
}

/// The pairs αβ of axes in the order of columns.
fn stress_axes(dimension: Dimension) -> &'static [(usize, usize)] {
    match dimension {
        Dimension::One => &[(0, 0)],
        Dimension::Two => &[(0, 0), (1, 1), (0, 1)],
        Dimension::Three => &[(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)],
    }
}

fn interleaved(columns: &[Vec<[f64; 3]>], nodes: usize) -> Vec<[[f64; 6]; 3]> {
    let mut fields = vec![[[0.0; 6]; 3]; nodes];
    for (n, column) in columns.iter().enumerate() {
        for (field, value) in fields.iter_mut().zip(column) {
            (0..3).for_each(|k| field[k][n] = value[k]);
        }
    }
    fields
}
