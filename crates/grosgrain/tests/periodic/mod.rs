//! Periodic homogenisation with one trilinear hexahedron per voxel: conjugate gradients, preconditioned by the exact inverse
//! of the homogeneous body's stiffness in Fourier space, so that the number of iterations depends on the contrast only.

mod fourier;

use fourier::{Complex, Fourier};
use grosgrain::element::{CellMatrix, Hex8};
use grosgrain::material::ElasticityTensor;
use rayon::prelude::*;

/// A periodic cell of voxels, material per voxel, x fastest.
pub struct PeriodicCell {
    cells: [usize; 3],
    element: Hex8,
    material_of: Vec<u8>,
    tensors: Vec<ElasticityTensor>,
    matrices: Vec<CellMatrix>,
    fourier: Fourier,
    /// Upper triangle (xx, yy, zz, yz, xz, xy) of the inverse symbol of the reference stiffness per frequency.
    inverse_symbol: Vec<[f64; 6]>,
}

/// Two displacement fields, the two load cases that are solved together.
type Pair = [Vec<f64>; 2];

impl PeriodicCell {
    pub fn new(cells: [usize; 3], spacing: [f64; 3], material_of: Vec<u8>, tensors: Vec<ElasticityTensor>) -> Self {
        let element = Hex8::new(spacing);
        let mean = std::array::from_fn(|i| {
            std::array::from_fn(|j| tensors.iter().map(|t| t.voigt()[i][j]).sum::<f64>() / tensors.len() as f64)
        });
        let reference = element.stiffness(&ElasticityTensor::from_voigt(mean).unwrap());
        let matrices = tensors.iter().map(|t| element.stiffness(t)).collect();
        let inverse_symbol = inverse_symbol(cells, &reference);
        Self { cells, element, material_of, tensors, matrices, fourier: Fourier::new(cells), inverse_symbol }
    }

    /// The 6×6 effective stiffness in Voigt order; the relative residual of each load case is at most `tolerance`.
    pub fn effective_stiffness(&self, tolerance: f64) -> [[f64; 6]; 6] {
        let mut stiffness = [[0.0; 6]; 6];
        for pair in [[0, 1], [2, 3], [4, 5]] {
            let fluctuations = self.solve(pair, tolerance);
            for (&case, u) in pair.iter().zip(&fluctuations) {
                let stress = self.mean_stress(case, u);
                (0..6).for_each(|i| stiffness[i][case] = stress[i]);
            }
        }
        stiffness
    }

    fn solve(&self, cases: [usize; 2], tolerance: f64) -> Pair {
        let mut residual: Pair = cases.map(|case| self.load(case));
        let small = [0, 1].map(|s| (tolerance * norm(&residual[s])).max(self.rounding(cases[s])));
        let mut u: Pair = residual.clone().map(|r| vec![0.0; r.len()]);
        let mut direction = self.precondition(&residual);
        let mut rho = [0, 1].map(|s| dot(&residual[s], &direction[s]));
        for _ in 0..500 {
            for s in 0..2 {
                if rho[s] == 0.0 {
                    continue;
                }
                let product = self.multiply(&direction[s]);
                let step = rho[s] / dot(&direction[s], &product);
                u[s].par_iter_mut().zip(&direction[s]).for_each(|(u, d)| *u += step * d);
                residual[s].par_iter_mut().zip(&product).for_each(|(r, p)| *r -= step * p);
            }
            if (0..2).all(|s| norm(&residual[s]) <= small[s]) {
                return u;
            }
            let z = self.precondition(&residual);
            for s in 0..2 {
                let next = dot(&residual[s], &z[s]);
                let beta = if rho[s] == 0.0 { 0.0 } else { next / rho[s] };
                direction[s].par_iter_mut().zip(&z[s]).for_each(|(d, z)| *d = z + beta * *d);
                rho[s] = next;
            }
        }
        panic!("load cases {cases:?} do not converge");
    }

    /// Displacements of an element's corners under the unit engineering strain number `case`.
    fn corners_of_strain(&self, case: usize) -> [f64; 24] {
        const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];
        let (alpha, beta) = PAIRS[case];
        let h = self.spacing();
        let mut u = [0.0; 24];
        for a in 0..8usize {
            let x = [0, 1, 2].map(|i| h[i] * (a >> i & 1) as f64);
            u[3 * a + alpha] += 0.5 * x[beta];
            u[3 * a + beta] += 0.5 * x[alpha];
        }
        u
    }

    fn spacing(&self) -> [f64; 3] {
        // The strain matrix at the centre holds ∂N/∂x = 1 / (4 h) for the last corner.
        let b = self.element.strain_matrix([0.5; 3]);
        [0, 1, 2].map(|i| 0.25 / b[i][21 + i])
    }

    /// −K (E x).
    fn load(&self, case: usize) -> Vec<f64> {
        let corners = self.corners_of_strain(case);
        self.gather(|_, _| corners).iter().map(|f| -f).collect()
    }

    /// What rounding leaves of a load whose cells' forces cancel.
    fn rounding(&self, case: usize) -> f64 {
        let corners = self.corners_of_strain(case);
        let square = |matrix: &CellMatrix| -> f64 {
            matrix.as_chunks::<24>().0.iter().map(|row| dot_short(row, &corners).powi(2)).sum()
        };
        let squares: Vec<f64> = self.matrices.iter().map(square).collect();
        1e-14 * self.material_of.iter().map(|m| squares[usize::from(*m)]).sum::<f64>().sqrt()
    }

    fn multiply(&self, u: &[f64]) -> Vec<f64> {
        self.gather(|nodes, _| std::array::from_fn(|i| u[3 * nodes[i / 3] + i % 3]))
    }

    /// Sums K_e times the corner values of each cell; layers of cells in parallel, each into its own two planes of nodes.
    fn gather(&self, corners: impl Fn(&[usize; 8], usize) -> [f64; 24] + Sync) -> Vec<f64> {
        let [nx, ny, nz] = self.cells;
        let plane = 3 * nx * ny;
        let mut layers = vec![0.0; 2 * plane * nz];
        layers.par_chunks_mut(2 * plane).enumerate().for_each(|(k, planes)| {
            for cell in nx * ny * k..nx * ny * (k + 1) {
                let nodes = self.nodes(cell);
                let values = corners(&nodes, cell);
                let matrix = &self.matrices[usize::from(self.material_of[cell])];
                let mut force = [0.0; 24];
                for (row, value) in matrix.as_chunks::<24>().0.iter().zip(values) {
                    (0..24).for_each(|i| force[i] += value * row[i]);
                }
                for a in 0..8 {
                    let local = (a >> 2) * plane + 3 * (nodes[a] % (nx * ny));
                    (0..3).for_each(|r| planes[local + r] += force[3 * a + r]);
                }
            }
        });
        let mut sum = vec![0.0; plane * nz];
        sum.par_chunks_mut(plane).enumerate().for_each(|(k, out)| {
            let below = (k + nz - 1) % nz;
            let (bottom, top) = (&layers[2 * plane * k..][..plane], &layers[2 * plane * below + plane..][..plane]);
            out.iter_mut().zip(bottom.iter().zip(top)).for_each(|(o, (b, t))| *o = b + t);
        });
        sum
    }

    fn nodes(&self, cell: usize) -> [usize; 8] {
        let [nx, ny, nz] = self.cells;
        let (i, j, k) = (cell % nx, cell / nx % ny, cell / (nx * ny));
        std::array::from_fn(|a| {
            let (i, j, k) = ((i + (a & 1)) % nx, (j + (a >> 1 & 1)) % ny, (k + (a >> 2)) % nz);
            i + nx * (j + ny * k)
        })
    }

    /// Both residuals at once, as the real and the imaginary part of one field: the symbol is real.
    fn precondition(&self, residual: &Pair) -> Pair {
        let mut fields: [Vec<Complex>; 3] = std::array::from_fn(|r| {
            let pairs = residual[0].par_chunks_exact(3).zip(residual[1].par_chunks_exact(3));
            pairs.map(|(a, b)| [a[r], b[r]]).collect()
        });
        fields.iter_mut().for_each(|f| self.fourier.forward(f));
        let [x, y, z] = &mut fields;
        (x.par_iter_mut().zip(y.par_iter_mut()).zip(z.par_iter_mut()).zip(&self.inverse_symbol)).for_each(
            |(((x, y), z), s)| {
                for part in 0..2 {
                    let (a, b, c) = (x[part], y[part], z[part]);
                    x[part] = s[0] * a + s[5] * b + s[4] * c;
                    y[part] = s[5] * a + s[1] * b + s[3] * c;
                    z[part] = s[4] * a + s[3] * b + s[2] * c;
                }
            },
        );
        fields.iter_mut().for_each(|f| self.fourier.inverse(f));
        [0, 1].map(|s| (0..residual[0].len()).into_par_iter().map(|i| fields[i % 3][i / 3][s]).collect())
    }

    /// ⟨C : (E + ε(u))⟩.
    fn mean_stress(&self, case: usize, u: &[f64]) -> [f64; 6] {
        let b = self.element.strain_matrix([0.5; 3]);
        let mut mean = [0.0; 6];
        for cell in 0..self.material_of.len() {
            let nodes = self.nodes(cell);
            let mut strain: [f64; 6] =
                std::array::from_fn(|m| (0..24).map(|i| b[m][i] * u[3 * nodes[i / 3] + i % 3]).sum());
            strain[case] += 1.0;
            let tensor = self.tensors[usize::from(self.material_of[cell])].voigt();
            (0..6).for_each(|i| mean[i] += dot_short(&tensor[i], &strain) / self.material_of.len() as f64);
        }
        mean
    }
}

/// Inverse of Σ_d S(d) cos(2π ξ·d / n) per frequency ξ, S the 27-point stencil; zero at frequency zero. Sines cancel, because the
/// stencil of an isotropic material is even.
fn inverse_symbol(cells: [usize; 3], matrix: &CellMatrix) -> Vec<[f64; 6]> {
    let mut stencil = [[[0.0; 3]; 3]; 27];
    for (a, b) in (0..64).map(|n| (n / 8usize, n % 8usize)) {
        let step = |axis: usize| (b >> axis & 1) + 1 - (a >> axis & 1);
        let block = &mut stencil[step(0) + 3 * step(1) + 9 * step(2)];
        (0..9).for_each(|n| block[n / 3][n % 3] += matrix[24 * (3 * a + n / 3) + 3 * b + n % 3]);
    }
    let count = cells.iter().product::<usize>();
    let invert = |index: usize| {
        let at = [index % cells[0], index / cells[0] % cells[1], index / (cells[0] * cells[1])];
        let mut symbol = [[0.0; 3]; 3];
        for (d, block) in stencil.iter().enumerate() {
            let steps = [d % 3, d / 3 % 3, d / 9].map(|s| s as f64 - 1.0);
            let turn: f64 = (0..3).map(|i| steps[i] * at[i] as f64 / cells[i] as f64).sum();
            let weight = (std::f64::consts::TAU * turn).cos();
            (0..9).for_each(|n| symbol[n / 3][n % 3] += weight * block[n / 3][n % 3]);
        }
        if index == 0 { [0.0; 6] } else { inverse(symbol) }
    };
    (0..count).into_par_iter().map(invert).collect()
}

fn inverse(m: [[f64; 3]; 3]) -> [f64; 6] {
    let minor = |i: usize, j: usize| {
        let (p, q, r, s) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[p][r] * m[q][s] - m[p][s] * m[q][r]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
    [minor(0, 0), minor(1, 1), minor(2, 2), minor(1, 2), minor(0, 2), minor(0, 1)].map(|v| v / determinant)
}

fn dot_short(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Sums of fixed blocks, so that the result does not depend on the number of threads.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let blocks: Vec<f64> = a.par_chunks(4096).zip(b.par_chunks(4096)).map(|(a, b)| dot_short(a, b)).collect();
    blocks.iter().sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
