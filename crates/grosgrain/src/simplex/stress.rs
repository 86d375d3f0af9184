//! Stresses in the cells of a mesh.

use super::{Dimension, SimplexLaw, SimplexMesh};
use crate::linalg::Polar;
use crate::linalg::matrix3::{IDENTITY, Matrix3, determinant, product, transposed};
use crate::material::ElasticityTensor;

/// Entries of a symmetric tensor in Voigt order.
const VOIGT: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];

/// Cauchy stress \[Pa\] in a cell of a material, Voigt order xx, yy, zz, yz, xz, xy; triangles are in plane strain, segments under stress along x only.
///
/// σ = C sym ∇u of [`SimplexLaw::Linear`]. With F = I + ∇u = R S, σ = R sym(σ̂ S) Rᵀ / det F and σ̂ = C (S − I) of [`SimplexLaw::Corotational`], whose own frame differs
/// from R by what stretches turn it; not a number where a cell is inverted.
///
/// # Panics
/// Panics when `displacement` \[m\] has not three entries per node.
pub fn cauchy_stress(
    (mesh, cell): (&SimplexMesh, usize),
    law: SimplexLaw,
    elasticity: &ElasticityTensor,
    displacement: &[f64],
) -> [f64; 6] {
    let gradient = deformation_gradient(mesh, cell, displacement);
    if mesh.dimension() == Dimension::One {
        return [elasticity.young_along_x() * (gradient[0][0] - 1.0), 0.0, 0.0, 0.0, 0.0, 0.0];
    }
    if law == SimplexLaw::Linear {
        let stress = stress_of(elasticity, &gradient);
        return VOIGT.map(|(i, j)| stress[i][j]);
    }
    let volume = determinant(&gradient);
    let Some(polar) = Polar::nearest(&gradient).filter(|_| volume > 0.0) else { return [f64::NAN; 6] };
    let pulled = product(&stress_of(elasticity, &polar.stretch), &polar.stretch);
    let world = product(&product(&polar.rotation, &pulled), &transposed(&polar.rotation));
    VOIGT.map(|(i, j)| 0.5 * (world[i][j] + world[j][i]) / volume)
}

/// F = I + Σ_i u_i ⊗ ∇λ_i.
fn deformation_gradient(mesh: &SimplexMesh, cell: usize, displacement: &[f64]) -> Matrix3 {
    let (gradients, mut f) = (mesh.gradients(cell), IDENTITY);
    for (node, slope) in mesh.cell(cell).iter().zip(gradients) {
        let u = &displacement[3 * *node as usize..3 * *node as usize + 3];
        (0..9).for_each(|e| f[e / 3][e % 3] += u[e / 3] * slope[e % 3]);
    }
    f
}

/// C (sym F − I).
fn stress_of(elasticity: &ElasticityTensor, f: &Matrix3) -> Matrix3 {
    let strain = VOIGT.map(|(i, j)| if i == j { f[i][i] - 1.0 } else { f[i][j] + f[j][i] });
    let voigt = elasticity.voigt();
    let mut stress = [[0.0; 3]; 3];
    for (row, (i, j)) in voigt.iter().zip(VOIGT) {
        let value = row.iter().zip(strain).map(|(c, e)| c * e).sum();
        (stress[i][j], stress[j][i]) = (value, value);
    }
    stress
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::IsotropicMaterial;

    const CORNERS: [[f64; 3]; 4] = [[0.3, 0.1, -0.2], [1.2, 0.0, 0.1], [0.1, 0.9, 0.2], [0.4, 0.3, 1.5]];

    fn cell(dimension: Dimension) -> SimplexMesh {
        let axes = dimension.axes();
        let nodes = CORNERS.map(|c| std::array::from_fn(|r| if r < axes { c[r] } else { 0.0 }));
        SimplexMesh::new(dimension, nodes[..axes + 1].to_vec(), vec![[0, 1, 2, 3]], vec![0]).unwrap()
    }

    /// Displacement of the corners under X → F X.
    fn moved(mesh: &SimplexMesh, f: &Matrix3) -> Vec<f64> {
        let u = |x: &[f64; 3]| [0, 1, 2].map(|r| (0..3).map(|c| f[r][c] * x[c]).sum::<f64>() - x[r]);
        mesh.nodes().iter().flat_map(u).collect()
    }

    fn stress(dimension: Dimension, law: SimplexLaw, f: &Matrix3) -> [f64; 6] {
        let mesh = cell(dimension);
        let elasticity = IsotropicMaterial::new(2e5, 0.3).unwrap().tensor();
        cauchy_stress((&mesh, 0), law, &elasticity, &moved(&mesh, f))
    }

    fn close(a: &[f64; 6], b: &[f64; 6], tolerance: f64) {
        assert!((0..6).all(|i| (a[i] - b[i]).abs() < tolerance), "{a:?} instead of {b:?}");
    }

    #[test]
    fn linear_stresses_are_those_of_hooke() {
        let (lambda, shear) = (2e5 * 0.3 / (1.3 * 0.4), 2e5 / 2.6);
        let f = [[1.01, 0.004, 0.0], [0.002, 0.98, 0.006], [0.0, 0.0, 1.03]];
        let trace = 0.01 - 0.02 + 0.03;
        let expected = [
            lambda * trace + 2.0 * shear * 0.01,
            lambda * trace - 2.0 * shear * 0.02,
            lambda * trace + 2.0 * shear * 0.03,
            shear * 0.006,
            0.0,
            shear * 0.006,
        ];
        // Entries of 10⁴ from strains of 10⁻², which cancel to 10⁻¹⁴.
        close(&stress(Dimension::Three, SimplexLaw::Linear, &f), &expected, 1e-7);
        let plane =
            stress(Dimension::Two, SimplexLaw::Linear, &[[1.01, 0.004, 0.0], [0.002, 0.98, 0.0], [0.0, 0.0, 1.0]]);
        assert!((plane[2] - 0.3 * (plane[0] + plane[1])).abs() < 1e-7, "plane strain: {plane:?}");
        let bar =
            stress(Dimension::One, SimplexLaw::Corotational, &[[1.01, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        close(&bar, &[2e3, 0.0, 0.0, 0.0, 0.0, 0.0], 1e-7);
    }

    #[test]
    fn rotating_cells_carry_their_stresses_along() {
        let stretch = [[1.2, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.1]];
        let (sine, cosine) = 2.0f64.sin_cos();
        let turn = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]];
        let still = stress(Dimension::Three, SimplexLaw::Corotational, &stretch);
        // σ = C (S − I) S / det S, diagonal.
        let (lambda, shear) = (2e5 * 0.3 / (1.3 * 0.4), 2e5 / 2.6);
        let principal = [1.2, 0.9, 1.1].map(|s: f64| (lambda * 0.2 + 2.0 * shear * (s - 1.0)) * s / (1.2 * 0.9 * 1.1));
        close(&still, &[principal[0], principal[1], principal[2], 0.0, 0.0, 0.0], 1e-6);
        let turned = stress(Dimension::Three, SimplexLaw::Corotational, &product(&turn, &stretch));
        let [a, b, c] = principal;
        let shear_stress = (a - b) * sine * cosine;
        let expected =
            [a * cosine * cosine + b * sine * sine, a * sine * sine + b * cosine * cosine, c, 0.0, 0.0, shear_stress];
        close(&turned, &expected, 1e-6);
        let inverted = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(stress(Dimension::Three, SimplexLaw::Corotational, &inverted)[0].is_nan());
    }
}
