//! Effective elasticity tensors of coarse cells (KMOD09, `kharevych2009numerical`, §3.6).

use rayon::prelude::*;

use super::{HarmonicDisplacements, SimplexModel};
use crate::linalg::SmallSvd;
use crate::simplex::{MandelTensor, Overlaps, SimplexMesh};

/// What conditions are capped at, so that files hold numbers.
const SINGULAR: f64 = 1e16;
/// Strains that the volume average resists less than this share of the one that it resists most are not compared with it: rounding.
const RESISTED: f64 = 1e-13;

/// When a coarse mollifier counts as singular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveOptions {
    /// Singular values of Ḡ below the largest over this are not inverted: strains that the coarse harmonic displacements do not tell apart.
    pub max_condition: f64,
}

impl Default for EffectiveOptions {
    fn default() -> Self {
        Self { max_condition: 1e6 }
    }
}

/// Effective tensors of a coarse mesh and how well each is determined.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectiveTensors {
    /// C̄ per coarse cell \[Pa\].
    pub tensors: Vec<MandelTensor>,
    /// Condition number of Ḡ per coarse cell, at most 1e16, which is a singular one to working accuracy.
    pub condition: Vec<f64>,
    /// Largest energy of a unit strain over that of the volume average, max_ε (ε : C̄ ε) / (ε : ⟨C⟩ ε), per coarse cell. No arrangement of the material is stiffer than its
    /// volume average: above 1, coarse nodes take displacements that the cell around them does not have. Strains that the volume average does not resist are left out.
    pub stiffening: Vec<f64>,
    /// Coarse cells in which some strains took the volume average because Ḡ does not determine them.
    pub averaged: Vec<u32>,
}

/// Why there are no tensors.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EffectiveError {
    /// Coarse cells that hold nothing of the body.
    #[error(
        "coarse cell {cell} lies wholly outside the fine mesh{}; remove it from the coarse mesh, or move the meshes onto each other",
        Others(*.count)
    )]
    Outside {
        /// The first, from 0.
        cell: usize,
        /// How many there are.
        count: usize,
    },
    /// Harmonic displacements that are not numbers.
    #[error("the harmonic displacements at coarse cell {cell} are not finite; check materials and held nodes")]
    NotFinite {
        /// The first such cell, from 0.
        cell: usize,
    },
}

/// Says how many more there are.
struct Others(usize);

impl std::fmt::Display for Others {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            0 | 1 => Ok(()),
            count => write!(f, ", and so do {} more", count - 1),
        }
    }
}

type Matrix6 = [[f64; 6]; 6];

/// C̄_q = Ḡ⁻ᵀ ⟨Gᵀ C G⟩_q Ḡ⁻¹ for every coarse cell q, with ⟨·⟩_q = Σ_p |T_p ∩ T_q| / |T_q| (·)_p.
///
/// G = sym ∇H per fine cell, Ḡ that of the coarse mesh, where `downsampled` are the harmonic displacements at its nodes ([`super::downsample`]). The energies of
/// all products of harmonic displacements in a coarse cell are then those of the fine mesh (KMOD09 eq. 5). C̄ is symmetric and positive semidefinite by
/// construction.
///
/// Where Ḡ is singular to working accuracy, with Ḡ = U Σ Vᵀ, P the projector on the columns of U that are kept and Ḡ⁺ the pseudo-inverse without the others,
/// C̄ = Ḡ⁺ᵀ ⟨Gᵀ C G⟩ Ḡ⁺ + (I − P) ⟨C⟩ (I − P): the least-squares tensor of least norm, with the volume average for the strains about which nothing is known.
///
/// # Errors
/// Coarse cells wholly outside, displacements that are not finite.
///
/// # Panics
/// Panics when fields, overlaps and meshes do not belong together.
pub fn effective_tensors(
    fine: (&SimplexModel, &HarmonicDisplacements),
    coarse: (&SimplexMesh, &HarmonicDisplacements),
    overlaps: &Overlaps,
    options: &EffectiveOptions,
) -> Result<EffectiveTensors, EffectiveError> {
    let (model, fields) = fine;
    let (mesh, downsampled) = coarse;
    check_filled(overlaps)?;
    let energies: Vec<Matrix6> =
        (0..model.mesh().cell_count()).into_par_iter().map(|p| energy_products(model, fields, p)).collect();
    let cells = (0..mesh.cell_count()).into_par_iter().map(|q| {
        let products = mean(mesh, overlaps, q, |p| energies[p]);
        let average = mean(mesh, overlaps, q, |p| model.tensor(p).matrix);
        let mollifier = downsampled.mollifier(mesh, q);
        let n = mesh.dimension().strains();
        let found = tensor_of(n, &mollifier, &products, &average, options);
        let (matrix, condition, is_averaged) = found.ok_or(EffectiveError::NotFinite { cell: q })?;
        Ok((matrix, condition, is_averaged, stiffening(n, &matrix, &average).unwrap_or(1.0)))
    });
    let cells: Vec<(Matrix6, f64, bool, f64)> = cells.collect::<Result<_, _>>()?;
    let tensor = |matrix: Matrix6| MandelTensor { dimension: mesh.dimension(), matrix };
    Ok(EffectiveTensors {
        tensors: cells.iter().map(|cell| tensor(cell.0)).collect(),
        condition: cells.iter().map(|cell| cell.1).collect(),
        stiffening: cells.iter().map(|cell| cell.3).collect(),
        averaged: (0..).zip(&cells).filter(|(_, cell)| cell.2).map(|(q, _)| q).collect(),
    })
}

/// Refuses coarse cells that hold nothing of the fine mesh.
pub(super) fn check_filled(overlaps: &Overlaps) -> Result<(), EffectiveError> {
    let outside = || (0..overlaps.coarse_count()).filter(|q| overlaps.of_coarse(*q).is_empty());
    match outside().next() {
        Some(cell) => Err(EffectiveError::Outside { cell, count: outside().count() }),
        None => Ok(()),
    }
}

/// Gᵀ C G of a fine cell.
fn energy_products(model: &SimplexModel, fields: &HarmonicDisplacements, cell: usize) -> Matrix6 {
    congruence(&fields.mollifier(model.mesh(), cell), &model.tensor(cell).matrix)
}

/// Σ_p |T_p ∩ T_q| / |T_q| of a quantity of fine cells.
pub(super) fn mean(
    mesh: &SimplexMesh,
    overlaps: &Overlaps,
    cell: usize,
    of_fine: impl Fn(usize) -> Matrix6,
) -> Matrix6 {
    let (mut sum, measure) = ([[0.0; 6]; 6], mesh.measure(cell));
    for &(fine, shared) in overlaps.of_coarse(cell) {
        let matrix = of_fine(fine as usize);
        for (sum, value) in sum.as_flattened_mut().iter_mut().zip(matrix.as_flattened()) {
            *sum += shared / measure * value;
        }
    }
    sum
}

/// C̄, the condition number of Ḡ, and whether strains were averaged; `None` where numbers are not finite.
fn tensor_of(
    n: usize,
    mollifier: &Matrix6,
    products: &Matrix6,
    average: &Matrix6,
    options: &EffectiveOptions,
) -> Option<(Matrix6, f64, bool)> {
    let svd = SmallSvd::new(n, mollifier)?;
    let is_kept = |k: usize| svd.s[k] * options.max_condition > svd.s[0];
    let mut inverse = [[0.0; 6]; 6];
    let mut lost = [[0.0; 6]; 6];
    for (i, j) in (0..n * n).map(|e| (e / n, e % n)) {
        inverse[i][j] = (0..n).filter(|k| is_kept(*k)).map(|k| svd.v[i][k] * svd.u[j][k] / svd.s[k]).sum();
        lost[i][j] = (0..n).filter(|k| !is_kept(*k)).map(|k| svd.u[i][k] * svd.u[j][k]).sum();
    }
    let mut tensor = congruence(&inverse, products);
    let is_averaged = !(0..n).all(is_kept);
    if is_averaged {
        let rest = congruence(&lost, average);
        tensor.as_flattened_mut().iter_mut().zip(rest.as_flattened()).for_each(|(t, r)| *t += r);
    }
    let is_finite = tensor.as_flattened().iter().all(|value| value.is_finite());
    is_finite.then(|| (symmetric(tensor), svd.condition(n).min(SINGULAR), is_averaged))
}

/// The largest eigenvalue of ⟨C⟩^(−1/2) C̄ ⟨C⟩^(−1/2), on the range of ⟨C⟩.
fn stiffening(n: usize, tensor: &Matrix6, average: &Matrix6) -> Option<f64> {
    let svd = SmallSvd::new(n, average)?;
    let mut root = [[0.0; 6]; 6];
    for (i, j) in (0..n * n).map(|e| (e / n, e % n)) {
        root[i][j] = (0..n)
            .filter(|k| svd.s[*k] > RESISTED * svd.s[0])
            .map(|k| svd.u[i][k] * svd.u[j][k] / svd.s[k].sqrt())
            .sum();
    }
    Some(SmallSvd::new(n, &congruence(&root, tensor))?.s[0])
}

/// Mᵀ C M.
pub(super) fn congruence(m: &Matrix6, c: &Matrix6) -> Matrix6 {
    let half: Matrix6 = std::array::from_fn(|i| std::array::from_fn(|j| (0..6).map(|k| c[i][k] * m[k][j]).sum()));
    std::array::from_fn(|i| std::array::from_fn(|j| (0..6).map(|k| m[k][i] * half[k][j]).sum()))
}

/// Without what rounding has made unsymmetric.
fn symmetric(m: Matrix6) -> Matrix6 {
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (m[i][j] + m[j][i])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Anything regular.
    fn matrix(seed: f64) -> Matrix6 {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (seed * (6 * i + j) as f64).sin() + if i == j { 2.0 } else { 0.0 })
        })
    }

    fn difference(a: &Matrix6, b: &Matrix6) -> f64 {
        a.as_flattened().iter().zip(b.as_flattened()).fold(0.0, |d, (a, b)| d.max((a - b).abs()))
    }

    fn positive(seed: f64) -> Matrix6 {
        let identity = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        congruence(&matrix(seed), &identity)
    }

    #[test]
    fn the_energies_of_all_products_are_kept() {
        let (mollifier, products) = (matrix(1.3), positive(0.7));
        let (tensor, condition, is_averaged) =
            tensor_of(6, &mollifier, &products, &positive(2.1), &EffectiveOptions::default()).unwrap();
        assert!(difference(&congruence(&mollifier, &tensor), &products) < 1e-11 && condition > 1.0 && !is_averaged);
    }

    #[test]
    fn stiffening_is_the_largest_ratio_of_energies() {
        let (tensor, average) = (positive(0.7), positive(2.1));
        let most = stiffening(6, &tensor, &average).unwrap();
        let energy = |m: &Matrix6, e: &[f64; 6]| (0..36).map(|n| e[n / 6] * m[n / 6][n % 6] * e[n % 6]).sum::<f64>();
        let mut found = 0.0f64;
        // Steepest ascent of the ratio from many starts.
        for seed in 0..200 {
            let mut e: [f64; 6] = std::array::from_fn(|i| ((seed * 7 + i * 13) as f64).sin());
            for step in 0..400 {
                let ratio = energy(&tensor, &e) / energy(&average, &e);
                let length = 0.3 / (1.0 + 0.02 * f64::from(step));
                let row = |m: &Matrix6, i: usize| (0..6).map(|j| m[i][j] * e[j]).sum::<f64>();
                let slope: [f64; 6] = std::array::from_fn(|i| row(&tensor, i) - ratio * row(&average, i));
                let norm = slope.iter().map(|s| s * s).sum::<f64>().sqrt().max(1e-300);
                let size = e.iter().map(|s| s * s).sum::<f64>().sqrt();
                (0..6).for_each(|i| e[i] += length * size * slope[i] / norm);
            }
            found = found.max(energy(&tensor, &e) / energy(&average, &e));
        }
        assert!(found <= most * (1.0 + 1e-12) && found > 0.98 * most, "{found} of {most}");
        assert!((stiffening(6, &average, &average).unwrap() - 1.0).abs() < 1e-12);
        // A material without resistance to one strain, such as a fluid's to shear, in axes that are not its own.
        let mut singular = [[0.0; 6]; 6];
        (0..5).for_each(|i| singular[i][i] = 1.0 + i as f64);
        let singular = congruence(&matrix(0.4), &singular);
        let double = singular.map(|row| row.map(|value| 2.0 * value));
        let found = stiffening(6, &double, &singular).unwrap();
        assert!((found - 2.0).abs() < 1e-9, "{found}");
    }

    #[test]
    fn a_singular_mollifier_gives_a_finite_tensor_that_keeps_what_is_known() {
        let products = positive(0.7);
        let average = positive(2.1);
        // The last strain is not excited by any harmonic displacement.
        let mut mollifier = matrix(1.3);
        mollifier[5] = [0.0; 6];
        let mut consistent = products;
        let strain = |t: &Matrix6| congruence(&mollifier, t);
        consistent = strain(&consistent);
        let (tensor, condition, is_averaged) =
            tensor_of(6, &mollifier, &consistent, &average, &EffectiveOptions::default()).unwrap();
        assert!(condition > 1e12 && is_averaged, "{condition:e}");
        assert!(difference(&strain(&tensor), &consistent) < 1e-11, "known energies stay");
        assert!((tensor[5][5] - average[5][5]).abs() < 1e-12 && tensor[5][0].abs() < 1e-12, "{:?}", tensor[5]);
        let none = tensor_of(6, &[[0.0; 6]; 6], &products, &average, &EffectiveOptions::default()).unwrap();
        assert!(difference(&none.0, &average) < 1e-15, "nothing known: the average");
        assert_eq!(tensor_of(6, &[[f64::NAN; 6]; 6], &products, &average, &EffectiveOptions::default()), None);
    }
}
