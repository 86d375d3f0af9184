//! The exact tensor of layers, and what of it a coarsened body keeps inside.

use grosgrain::homogenization::{HarmonicDisplacements, SimplexModel};
use grosgrain::simplex::MandelTensor;

/// The stiffness \[Pa\] of equal shares of two isotropic materials in thin layers normal to z, entries 11, 33, 13, 44 and 66 in Voigt order (`backus1962long`): with
/// c = λ + 2μ and means ⟨·⟩ by volume, C33 = ⟨1/c⟩⁻¹, C13 = C33 ⟨λ/c⟩, C11 = ⟨4μ(λ+μ)/c⟩ + C33 ⟨λ/c⟩², C44 = ⟨1/μ⟩⁻¹, C66 = ⟨μ⟩.
pub fn laminate(phases: [(f64, f64); 2]) -> [f64; 5] {
    let mean = |of: &dyn Fn(f64, f64) -> f64| {
        let one = |(young, poisson): (f64, f64)| {
            let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
            of(lambda, 0.5 * young / (1.0 + poisson))
        };
        0.5 * (one(phases[0]) + one(phases[1]))
    };
    let c33 = 1.0 / mean(&|l, m| 1.0 / (l + 2.0 * m));
    let coupling = mean(&|l, m| l / (l + 2.0 * m));
    let c11 = mean(&|l, m| 4.0 * m * (l + m) / (l + 2.0 * m)) + c33 * coupling * coupling;
    [c11, c33, c33 * coupling, 1.0 / mean(&|_, m| 1.0 / m), mean(&|_, m| m)]
}

/// Names of the entries of [`laminate`] and their places in a Voigt matrix.
pub const ENTRIES: [(&str, usize, usize); 5] =
    [("C11", 0, 0), ("C33", 2, 2), ("C13", 0, 2), ("C44", 3, 3), ("C66", 5, 5)];

/// The entries of [`ENTRIES`] in the mean of tensors.
pub fn mean_entries(tensors: &[MandelTensor]) -> [f64; 5] {
    ENTRIES.map(|(_, i, j)| tensors.iter().map(|tensor| tensor.voigt()[i][j]).sum::<f64>() / tensors.len() as f64)
}

/// Mean strain \[1/Pa\] of the whole body along each axis under a unit stress along it: how far h₁₁, h₂₂ and h₃₃ stretch it.
pub fn stretches(model: &SimplexModel, fields: &HarmonicDisplacements) -> [f64; 3] {
    let mesh = model.mesh();
    let (mut sums, mut volume) = ([0.0; 3], 0.0);
    for cell in 0..mesh.cell_count() {
        let (strain, share) = (fields.mollifier(mesh, cell), mesh.measure(cell));
        volume += share;
        (0..3).for_each(|r| sums[r] += share * strain[r][r]);
    }
    sums.map(|sum| sum / volume)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_have_the_tensor_that_was_worked_out_elsewhere() {
        let [c11, c33, c13, c44, c66] = laminate([(10e6, 0.45), (0.1e6, 0.45)]).map(|entry| entry / 1e6);
        let exact = [6.835097303, 0.751109594, 0.614544213, 0.068282690, 1.741379310];
        for (found, exact) in [c11, c33, c13, c44, c66].into_iter().zip(exact) {
            assert!((found - exact).abs() < 1e-8, "{found} instead of {exact}");
        }
    }
}
