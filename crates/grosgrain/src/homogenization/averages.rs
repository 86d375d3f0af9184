//! The averages to which effective tensors are compared, and the mass of coarse nodes.

use rayon::prelude::*;

use super::SimplexModel;
use super::effective::mean;
use crate::simplex::{Dimension, Locator, MandelTensor, Overlaps, SimplexMesh};

/// What is averaged over a coarse cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Average {
    /// Young's modulus and Poisson's ratio, where all materials in the cell are isotropic; elsewhere as [`Average::Stiffness`].
    Coefficients,
    /// The elasticity tensor, which for linear cells is the same as averaging stiffness matrices: ⟨C⟩ with Bᵀ ⟨C⟩ B |T| = Σ_p Bᵀ C_p B |T_p ∩ T|
    /// (`nesme2006animating`).
    Stiffness,
}

/// Averages over every coarse cell by exact intersections; what is void in it counts as zero stiffness.
pub fn average_tensors(
    model: &SimplexModel,
    coarse: &SimplexMesh,
    overlaps: &Overlaps,
    average: Average,
) -> Vec<MandelTensor> {
    let tensor = |q: usize| {
        let stiffness = || {
            let matrix = mean(coarse, overlaps, q, |p| model.tensor(p).matrix);
            MandelTensor { dimension: coarse.dimension(), matrix }
        };
        match average {
            Average::Stiffness => stiffness(),
            Average::Coefficients => mean_coefficients(model, coarse, overlaps, q).unwrap_or_else(stiffness),
        }
    };
    (0..coarse.cell_count()).into_par_iter().map(tensor).collect()
}

/// The isotropic tensor of the mean E and ν, times the share of the cell that is filled; `None` where a material is not isotropic.
fn mean_coefficients(
    model: &SimplexModel,
    coarse: &SimplexMesh,
    overlaps: &Overlaps,
    cell: usize,
) -> Option<MandelTensor> {
    let (mut young, mut poisson, mut filled) = (0.0, 0.0, 0.0);
    for &(fine, shared) in overlaps.of_coarse(cell) {
        let [e, nu] = isotropic_constants(model.tensor(fine as usize))?;
        young += shared * e;
        poisson += shared * nu;
        filled += shared;
    }
    let share = filled / coarse.measure(cell);
    Some(isotropic(coarse.dimension(), young / filled, poisson / filled).scaled(share))
}

/// E and ν of an isotropic tensor (those of three dimensions for plane strain); ν = 0 in one dimension.
fn isotropic_constants(tensor: &MandelTensor) -> Option<[f64; 2]> {
    let m = &tensor.matrix;
    if tensor.dimension == Dimension::One {
        return Some([m[0][0], 0.0]);
    }
    let (lambda, double_shear) = (m[0][1], m[0][0] - m[0][1]);
    let shear = 0.5 * double_shear;
    let young = shear * (3.0 * lambda + 2.0 * shear) / (lambda + shear);
    let poisson = 0.5 * lambda / (lambda + shear);
    let made = isotropic(tensor.dimension, young, poisson);
    let differs = |(a, b): (&f64, &f64)| (a - b).abs() > 1e-12 * m[0][0].abs();
    let is_isotropic = !m.as_flattened().iter().zip(made.matrix.as_flattened()).any(differs);
    (is_isotropic && young.is_finite()).then_some([young, poisson])
}

/// λ tr ε I + 2μ ε, of a bar in one dimension.
fn isotropic(dimension: Dimension, young: f64, poisson: f64) -> MandelTensor {
    let mut matrix = [[0.0; 6]; 6];
    if dimension == Dimension::One {
        matrix[0][0] = young;
        return MandelTensor { dimension, matrix };
    }
    let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let double_shear = young / (1.0 + poisson);
    let axes = dimension.axes();
    (0..dimension.strains()).for_each(|i| matrix[i][i] = double_shear);
    (0..axes * axes).for_each(|e| matrix[e / axes][e % axes] += lambda);
    MandelTensor { dimension, matrix }
}

/// Mean density \[kg/m³\] of each coarse cell, what is void in it included.
pub(super) fn mean_densities(model: &SimplexModel, coarse: &SimplexMesh, overlaps: &Overlaps) -> Vec<f64> {
    let mass = |q: usize| -> f64 {
        overlaps.of_coarse(q).iter().map(|(fine, shared)| shared * model.density(*fine as usize)).sum()
    };
    (0..coarse.cell_count()).map(|q| mass(q) / coarse.measure(q)).collect()
}

/// Lumped mass \[kg\] of every coarse node: each corner of a coarse cell takes an equal part of what the cell holds of every fine cell's mass. What of a fine
/// cell lies in no coarse cell goes to the coarse cell that is closest to its centre, so that the total is the mass of the fine mesh.
pub fn lumped_mass(model: &SimplexModel, coarse: &Locator<'_>, overlaps: &Overlaps) -> Vec<f64> {
    let (mesh, fine) = (coarse.mesh(), model.mesh());
    let mut left: Vec<f64> = (0..fine.cell_count()).map(|p| fine.measure(p)).collect();
    let mut of_cells = vec![0.0; mesh.cell_count()];
    for (q, of_cell) in of_cells.iter_mut().enumerate() {
        for &(p, shared) in overlaps.of_coarse(q) {
            *of_cell += shared * model.density(p as usize);
            left[p as usize] -= shared;
        }
    }
    for (p, left) in left.iter().enumerate() {
        // Rounding leaves some of every cell; it goes where its centre is.
        let nearest = coarse.locate(fine.centre(p)).cells()[0].cell as usize;
        of_cells[nearest] += left * model.density(p);
    }
    mesh.lumped(|q| of_cells[q])
}
