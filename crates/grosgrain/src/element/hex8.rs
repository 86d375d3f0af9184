//! The trilinear hexahedron on an axis-aligned box.

use super::gauss_2x2x2;
use crate::material::ElasticityTensor;

/// A 24×24 matrix, row-major; the unknown of corner a and component r has index `3 a + r`,
/// corners x fastest.
pub type CellMatrix = [f64; 576];

/// Trilinear weights of the eight corners at ξ ∈ [0, 1]³: N_a = Π_i (ξ_i or 1 − ξ_i).
pub fn trilinear(at: [f64; 3]) -> [f64; 8] {
    std::array::from_fn(|a| (0..3).map(|i| factor(a, i, at[i])).product())
}

/// Gradients ∂N_a/∂ξ of the trilinear weights at ξ ∈ [0, 1]³.
pub fn trilinear_gradients(at: [f64; 3]) -> [[f64; 3]; 8] {
    std::array::from_fn(|a| {
        std::array::from_fn(|i| {
            let slope = if bit(a, i) { 1.0 } else { -1.0 };
            (0..3).filter(|j| *j != i).map(|j| factor(a, j, at[j])).product::<f64>() * slope
        })
    })
}

const fn bit(corner: usize, axis: usize) -> bool {
    corner >> axis & 1 == 1
}

fn factor(corner: usize, axis: usize, xi: f64) -> f64 {
    if bit(corner, axis) { xi } else { 1.0 - xi }
}

/// A trilinear hexahedron with edge lengths h along x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hex8 {
    spacing: [f64; 3],
}

impl Hex8 {
    /// An element with edge lengths `spacing` \[m\].
    pub const fn new(spacing: [f64; 3]) -> Self {
        Self { spacing }
    }

    /// Volume \[m³\].
    pub fn volume(&self) -> f64 {
        self.spacing.iter().product()
    }

    /// Stiffness ∫ Bᵀ C B dV \[N/m\] with 2×2×2 Gauss points, B the 6×24 strain matrix in Voigt order
    /// (exact: the integrand is quadratic in each coordinate).
    pub fn stiffness(&self, tensor: &ElasticityTensor) -> CellMatrix {
        let mut k = [0.0; 576];
        for point in gauss_2x2x2() {
            let b = self.strain_matrix(point.at);
            let stress = multiply(tensor.voigt(), &b);
            let weight = point.weight * self.volume();
            for row in 0..24 {
                for column in 0..24 {
                    k[24 * row + column] += weight * (0..6).map(|m| b[m][row] * stress[m][column]).sum::<f64>();
                }
            }
        }
        symmetrise(&mut k);
        k
    }

    /// The 6×24 matrix B that maps corner displacements to the strain (xx, yy, zz, 2yz, 2xz, 2xy) at ξ.
    pub fn strain_matrix(&self, at: [f64; 3]) -> [[f64; 24]; 6] {
        let mut b = [[0.0; 24]; 6];
        for (a, gradient) in trilinear_gradients(at).iter().enumerate() {
            let [x, y, z]: [f64; 3] = std::array::from_fn(|i| gradient[i] / self.spacing[i]);
            let (u, v, w) = (3 * a, 3 * a + 1, 3 * a + 2);
            (b[0][u], b[1][v], b[2][w]) = (x, y, z);
            (b[3][v], b[3][w]) = (z, y);
            (b[4][u], b[4][w]) = (z, x);
            (b[5][u], b[5][v]) = (y, x);
        }
        b
    }

    /// Load ∫ ε(v):σ dV of a constant stress σ (3×3, symmetric): force of corner a is
    /// V Σ_β σ_αβ ∂N_a/∂x_β at the element's centre \[N\].
    pub fn constant_stress_load(&self, stress: &[[f64; 3]; 3]) -> [f64; 24] {
        let gradients = trilinear_gradients([0.5; 3]);
        let volume = self.volume();
        std::array::from_fn(|i| {
            let (a, alpha) = (i / 3, i % 3);
            volume * (0..3).map(|beta| stress[alpha][beta] * gradients[a][beta] / self.spacing[beta]).sum::<f64>()
        })
    }
}

fn multiply(c: &[[f64; 6]; 6], b: &[[f64; 24]; 6]) -> [[f64; 24]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..6).map(|m| c[i][m] * b[m][j]).sum()))
}

/// Makes rounding symmetric, so that the two triangles agree bit for bit.
fn symmetrise(k: &mut CellMatrix) {
    for row in 0..24 {
        for column in 0..row {
            let mean = 0.5 * (k[24 * row + column] + k[24 * column + row]);
            k[24 * row + column] = mean;
            k[24 * column + row] = mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::IsotropicMaterial;

    fn example() -> (Hex8, ElasticityTensor) {
        let tensor = IsotropicMaterial::new(3.0, 0.3).unwrap().tensor();
        (Hex8::new([0.5, 1.0, 2.0]), tensor)
    }

    fn corner(element: &Hex8, a: usize) -> [f64; 3] {
        std::array::from_fn(|i| if bit(a, i) { element.spacing[i] } else { 0.0 })
    }

    #[test]
    fn energy_of_a_linear_field_is_half_strain_stress_times_volume() {
        let (element, tensor) = example();
        let k = element.stiffness(&tensor);
        let gradient = [[0.1, 0.2, -0.3], [0.05, -0.2, 0.4], [0.3, 0.0, 0.7]];
        let u: [f64; 24] = std::array::from_fn(|i| {
            let x = corner(&element, i / 3);
            (0..3).map(|b| gradient[i % 3][b] * x[b]).sum()
        });
        let g = gradient;
        let strain = [g[0][0], g[1][1], g[2][2], g[1][2] + g[2][1], g[0][2] + g[2][0], g[0][1] + g[1][0]];
        let exact: f64 = (0..36).map(|n| strain[n / 6] * tensor.voigt()[n / 6][n % 6] * strain[n % 6]).sum();
        let energy: f64 = (0..576).map(|n| u[n / 24] * k[n] * u[n % 24]).sum();
        let exact = exact * element.volume();
        assert!((energy - exact).abs() < 1e-13 * exact, "{energy} against {exact}");
    }

    #[test]
    fn rigid_motions_carry_no_force() {
        let (element, tensor) = example();
        let k = element.stiffness(&tensor);
        for mode in 0..6 {
            let u: [f64; 24] = std::array::from_fn(|i| {
                let x = corner(&element, i / 3);
                let r = i % 3;
                match mode {
                    0..3 => f64::from(u8::from(r == mode)),
                    _ => {
                        let axis = mode - 3;
                        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
                        if r == p {
                            -x[q]
                        } else if r == q {
                            x[p]
                        } else {
                            0.0
                        }
                    }
                }
            });
            for row in 0..24 {
                let force: f64 = (0..24).map(|c| k[24 * row + c] * u[c]).sum();
                assert!(force.abs() < 1e-13, "mode {mode}, row {row}: {force}");
            }
        }
    }

    #[test]
    fn constant_stress_load_is_the_stiffness_times_the_matching_linear_field() {
        let (element, tensor) = example();
        let k = element.stiffness(&tensor);
        let u: [f64; 24] = std::array::from_fn(|i| if i % 3 == 0 { corner(&element, i / 3)[0] } else { 0.0 });
        let c = tensor.voigt();
        let stress = [[c[0][0], 0.0, 0.0], [0.0, c[1][0], 0.0], [0.0, 0.0, c[2][0]]];
        let load = element.constant_stress_load(&stress);
        for row in 0..24 {
            let force: f64 = (0..24).map(|col| k[24 * row + col] * u[col]).sum();
            assert!((force - load[row]).abs() < 1e-13, "row {row}: {force} against {}", load[row]);
        }
    }
}
