//! Bodies, fields and norms that the verification tests share.
#![allow(dead_code, reason = "every test binary takes the part it needs")]

use grosgrain::assembly::CellStiffness;
use grosgrain::element::Hex8;
use grosgrain::fine::FineModel;
use grosgrain::material::{Elasticity, ElasticityTensor, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Cell, Label, Lattice, Node, VoxelGrid};

/// Numbers from [0, 1) that depend on the seed only (SplitMix64).
pub struct Uniform(pub u64);

impl Uniform {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * 0.5f64.powi(53)
    }

    /// A number from [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.next() - 1.0
    }
}

pub fn isotropic(young: f64, poisson: f64) -> Elasticity {
    Elasticity::Isotropic(IsotropicMaterial::new(young, poisson).unwrap())
}

/// Label n stands for the n-th elasticity, with density 1000 (n + 1).
pub fn table(elasticities: &[Elasticity]) -> MaterialTable {
    let mut table = MaterialTable::new();
    for (n, elasticity) in elasticities.iter().enumerate() {
        let material = Material::linear(format!("phase {n}"), *elasticity, 1000.0 * (n + 1) as f64);
        table.insert(Label(n as i32), material);
    }
    table
}

/// A symmetric positive definite tensor A Aᵀ + I with A uniform in [-1, 1).
pub fn random_tensor(seed: u64) -> ElasticityTensor {
    let mut random = Uniform(seed);
    let a: [[f64; 6]; 6] = std::array::from_fn(|_| std::array::from_fn(|_| random.signed()));
    let product = |i: usize, j: usize| (0..6).map(|m| a[i][m] * a[j][m]).sum::<f64>() + f64::from(u8::from(i == j));
    ElasticityTensor::from_voigt(std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)))).unwrap()
}

/// A body without voids whose moduli are drawn log-uniformly from [1, contrast] Pa.
pub fn random_model(cells: [usize; 3], spacing: [f64; 3], contrast: f64, poisson: f64, seed: u64) -> FineModel {
    let mut grid = VoxelGrid::uniform(cells, spacing, Label(0));
    let mut random = Uniform(seed);
    grid.young = Some((0..grid.lattice.cell_count()).map(|_| contrast.powf(random.next())).collect());
    FineModel::new(grid, &table(&[isotropic(1.0, poisson)])).unwrap()
}

/// The lattice vector of u(x).
pub fn lattice_vector(grid: &VoxelGrid, u: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
    let lattice = grid.lattice;
    (0..lattice.node_count()).flat_map(|n| u(grid.position(lattice.node_position(Node(n))))).collect()
}

/// G x.
pub fn apply(gradient: [[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| (0..3).map(|b| gradient[a][b] * x[b]).sum())
}

/// K u, cell by cell.
pub fn multiply(cells: &dyn CellStiffness, u: &[f64]) -> Vec<f64> {
    let lattice = cells.lattice();
    let mut product = vec![0.0; u.len()];
    for cell in 0..lattice.cell_count() {
        let Some((factor, matrix)) = cells.stiffness(cell) else { continue };
        let corners = lattice.corners(Cell(cell));
        for i in 0..24 {
            let row = &matrix[24 * i..][..24];
            let force: f64 = (0..24).map(|j| row[j] * u[3 * corners[j / 3].0 + j % 3]).sum();
            product[3 * corners[i / 3].0 + i % 3] += factor * force;
        }
    }
    product
}

/// Strain (xx, yy, zz, 2yz, 2xz, 2xy) at ξ ∈ [0, 1]³ of a cell.
pub fn strain(lattice: Lattice, spacing: [f64; 3], u: &[f64], cell: Cell, at: [f64; 3]) -> [f64; 6] {
    let b = Hex8::new(spacing).strain_matrix(at);
    let corners = lattice.corners(cell);
    std::array::from_fn(|m| (0..24).map(|i| b[m][i] * u[3 * corners[i / 3].0 + i % 3]).sum())
}

/// Eight points off the centre, one per corner of [0, 1]³.
pub fn sample_points() -> [[f64; 3]; 8] {
    std::array::from_fn(|q| std::array::from_fn(|a| if q >> a & 1 == 0 { 0.125 } else { 0.75 }))
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| if v.is_nan() { f64::NAN } else { m.max(v.abs()) })
}

/// Largest difference against the largest entry of `exact`.
pub fn relative(found: &[f64], exact: &[f64]) -> f64 {
    assert_eq!(found.len(), exact.len());
    let difference: Vec<f64> = found.iter().zip(exact).map(|(a, b)| a - b).collect();
    largest(&difference) / largest(exact)
}

/// Nodes on the plane with this index across `axis`.
pub fn plane(lattice: Lattice, axis: usize, index: usize) -> Vec<bool> {
    (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[axis] == index).collect()
}

/// Copies the box of `cells` cells at `start` out of a grid.
pub fn cut_out(grid: &VoxelGrid, start: [usize; 3], cells: [usize; 3]) -> VoxelGrid {
    let lattice = Lattice::new(cells);
    let outer = |c: usize| {
        let at = lattice.cell_position(Cell(c));
        grid.lattice.cell(std::array::from_fn(|a| at[a] + start[a])).0
    };
    let all: Vec<usize> = (0..lattice.cell_count()).map(outer).collect();
    VoxelGrid {
        lattice,
        spacing: grid.spacing,
        origin: grid.position(start),
        labels: all.iter().map(|&c| grid.labels[c]).collect(),
        void: all.iter().map(|&c| grid.void[c]).collect(),
        young: grid.young.as_ref().map(|young| all.iter().map(|&c| young[c]).collect()),
        density: grid.density.as_ref().map(|density| all.iter().map(|&c| density[c]).collect()),
    }
}
