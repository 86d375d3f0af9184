//! From coarse to fine by harmonic displacements (KMOD09, `kharevych2009numerical`, §4.3).

use rayon::prelude::*;

use super::cell_rotation::{CellRotation, Turned};
use super::{HarmonicDisplacements, SimplexEmbedding};
use crate::linalg::matrix3::{IDENTITY, Matrix3};
use crate::simplex::{CellsAround, SimplexMesh};

/// How coarse cells take part in the displacement of a fine node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blending {
    /// Each fine node follows the cell that holds it, as published; the displacement jumps between cells whose stresses differ.
    #[default]
    PerCell,
    /// Rotations and stresses of the cells around each coarse node are averaged by measure there and interpolated in between: a displacement without jumps.
    Continuous,
}

/// A fine displacement, and where it is the barycentric one only.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapped {
    /// Displacement \[m\], three entries per fine node.
    pub displacement: Vec<f64>,
    /// Coarse cells, ascending, that are inverted, or in which no rotation and stress satisfy equation 9, or whose harmonic displacements are not independent.
    pub barycentric: Vec<u32>,
}

/// The map from coarse to fine that is in equilibrium inside each coarse cell as far as harmonic displacements are (`kharevych2009numerical`, eq. 9 and 10).
///
/// In a coarse cell with the deformation gradient F and the gradients A_αβ of the harmonic displacements H̄ at its corners, a rotation R and a symmetric S are found with
/// R F = I + Σ_αβ S_αβ A_αβ; then x = x₀ + Rᵀ (X − X₀ + (H(X) − H̄₀) : S). With the fluctuation χ = H − H̄, the harmonic displacements less their barycentric interpolation,
/// this is the barycentric map plus Rᵀ (χ(X) : S), and so it is computed. A fine node outside of all coarse cells follows up to three of them by shares.
///
/// Rigid motions, coarse nodes that are fine nodes (where H̄ holds values there: [`super::downsample`], not [`super::fit_downsampled`]), and (at any size at which a cell finds R = I) displacements that are harmonic ones are reproduced exactly; a homogeneous body follows the
/// barycentric map.
#[derive(Clone, Debug)]
pub struct HarmonicMap {
    embedding: SimplexEmbedding,
    /// χ at the fine nodes.
    fluctuations: Vec<[[f64; 6]; 3]>,
    cells: Vec<MapCell>,
    /// Cells around each coarse node.
    around: CellsAround,
}

/// What the map needs of a coarse cell.
#[derive(Clone, Debug)]
struct MapCell {
    corners: [u32; 4],
    count: usize,
    gradients: [[f64; 3]; 4],
    measure: f64,
    rotation: Option<CellRotation>,
}

/// `tensor[k][l][n]` = R_lk s_n: takes fluctuations to displacements.
type Tensor = [[[f64; 6]; 3]; 3];

impl HarmonicMap {
    /// From harmonic displacements of a fine mesh, those of a coarse one ([`super::downsample`], [`super::fit_downsampled`]), and where the fine nodes lie. All fine nodes are nodes
    /// of cells: others have no harmonic displacement.
    ///
    /// # Panics
    /// Panics when meshes, fields and embedding do not belong together.
    pub fn new(
        fine: &HarmonicDisplacements,
        coarse: (&SimplexMesh, &HarmonicDisplacements),
        embedding: SimplexEmbedding,
    ) -> Self {
        let (mesh, downsampled) = coarse;
        assert_eq!(fine.fields.len(), embedding.fine_nodes(), "fields at the fine nodes");
        assert_eq!(downsampled.fields.len(), embedding.coarse_nodes(), "fields at the coarse nodes");
        let fluctuation = |node: usize| {
            let mut field = fine.fields[node];
            for &(corner, weight) in embedding.weights(node) {
                let coarse = downsampled.fields[corner as usize].as_flattened();
                field.as_flattened_mut().iter_mut().zip(coarse).for_each(|(f, c)| *f -= weight * c);
            }
            field
        };
        let fluctuations = (0..fine.fields.len()).into_par_iter().map(fluctuation).collect();
        let cells = (0..mesh.cell_count()).into_par_iter().map(|cell| MapCell::new(mesh, downsampled, cell)).collect();
        Self { embedding, fluctuations, cells, around: CellsAround::new(mesh) }
    }

    /// Where the fine nodes lie.
    pub fn embedding(&self) -> &SimplexEmbedding {
        &self.embedding
    }

    /// The fine displacement \[m\] of a coarse one, three entries per node each.
    ///
    /// # Panics
    /// Panics when `coarse` has not three entries per coarse node.
    pub fn map(&self, coarse: &[f64], blending: Blending) -> Mapped {
        let mut displacement = self.embedding.prolong(coarse);
        let turned: Vec<Option<Turned>> = self.cells.par_iter().map(|cell| cell.turned(coarse)).collect();
        let barycentric = (0..).zip(&turned).filter(|(_, turned)| turned.is_none()).map(|(cell, _)| cell).collect();
        let tensors: Vec<Option<Tensor>> = turned.iter().map(|turned| turned.as_ref().map(tensor)).collect();
        match blending {
            Blending::PerCell => self.add(&mut displacement, |node| {
                let cells = self.embedding.place(node).cells().iter();
                weighted(cells.map(|cell| (cell.share, tensors[cell.cell as usize].as_ref())))
            }),
            Blending::Continuous => {
                let at_nodes = self.averaged(&tensors);
                self.add(&mut displacement, |node| self.interpolated(node, &at_nodes));
            }
        }
        Mapped { displacement, barycentric }
    }

    /// Adds the fluctuations, taken to displacements by a tensor per fine node.
    fn add(&self, displacement: &mut [f64], tensor: impl Fn(usize) -> Tensor + Sync) {
        displacement.par_chunks_mut(3).enumerate().for_each(|(node, u)| {
            let (tensor, fluctuation) = (tensor(node), self.fluctuations[node].as_flattened());
            for (u, row) in u.iter_mut().zip(&tensor) {
                *u += row.as_flattened().iter().zip(fluctuation).map(|(t, f)| t * f).sum::<f64>();
            }
        });
    }

    /// At each coarse node the mean over the cells around it that have found a rotation.
    fn averaged(&self, tensors: &[Option<Tensor>]) -> Vec<Tensor> {
        let mean = |node: usize| {
            let found = self.around.of(node).iter().filter_map(|cell| {
                let cell = *cell as usize;
                tensors[cell].as_ref().map(|tensor| (self.cells[cell].measure, tensor))
            });
            let total: f64 = found.clone().map(|(measure, _)| measure).sum();
            weighted(found.map(|(measure, tensor)| (measure / total, Some(tensor))))
        };
        (0..self.around.nodes()).into_par_iter().map(mean).collect()
    }

    /// By the weights of a fine node, those below zero left out so that outside nothing is exaggerated.
    fn interpolated(&self, node: usize, at_nodes: &[Tensor]) -> Tensor {
        let weights = || self.embedding.weights(node).iter().filter(|(_, weight)| *weight > 0.0);
        let total: f64 = weights().map(|(_, weight)| weight).sum();
        weighted(weights().map(|(corner, weight)| (weight / total, Some(&at_nodes[*corner as usize]))))
    }
}

impl MapCell {
    fn new(mesh: &SimplexMesh, fields: &HarmonicDisplacements, cell: usize) -> Self {
        let (nodes, gradients) = (mesh.cell(cell), mesh.gradients(cell));
        let gradient = |n: usize| -> Matrix3 {
            let entry = |k: usize, l: usize| {
                let corners = nodes.iter().zip(&gradients);
                corners.map(|(node, gradient)| fields.fields[*node as usize][k][n] * gradient[l]).sum()
            };
            std::array::from_fn(|k| std::array::from_fn(|l| entry(k, l)))
        };
        let of_fields: Vec<Matrix3> = (0..mesh.dimension().strains()).map(gradient).collect();
        Self {
            corners: std::array::from_fn(|n| *nodes.get(n).unwrap_or(&nodes[0])),
            count: nodes.len(),
            gradients,
            measure: mesh.measure(cell),
            rotation: CellRotation::new(mesh.dimension(), &of_fields),
        }
    }

    /// By differences of displacements, so that the digits of a far displacement stay.
    fn turned(&self, displacement: &[f64]) -> Option<Turned> {
        let at = |n: usize, r: usize| displacement[3 * self.corners[n] as usize + r];
        let mut gradient = IDENTITY;
        for n in 1..self.count {
            for (r, c) in (0..9).map(|e| (e / 3, e % 3)) {
                gradient[r][c] += (at(n, r) - at(0, r)) * self.gradients[n][c];
            }
        }
        self.rotation.as_ref()?.turned(&gradient)
    }
}

fn tensor(turned: &Turned) -> Tensor {
    let Turned { rotation, stress } = turned;
    std::array::from_fn(|k| std::array::from_fn(|l| stress.map(|s| rotation[l][k] * s)))
}

/// Σ weight · tensor, `None` counting as zero.
fn weighted<'a>(parts: impl Iterator<Item = (f64, Option<&'a Tensor>)>) -> Tensor {
    let mut sum = [[[0.0; 6]; 3]; 3];
    for (weight, tensor) in parts.filter_map(|(weight, tensor)| tensor.map(|tensor| (weight, tensor))) {
        let (sum, tensor) = (sum.as_flattened_mut().as_flattened_mut(), tensor.as_flattened().as_flattened());
        sum.iter_mut().zip(tensor).for_each(|(s, t)| *s += weight * t);
    }
    sum
}
