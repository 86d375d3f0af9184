//! Boxes of simplices for tests.
#![allow(dead_code, reason = "each test uses its own share")]

use grosgrain::homogenization::SimplexModel;
use grosgrain::simplex::{Dimension, MandelTensor, SimplexMesh};

pub const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];

/// A number of [0, 1) that looks random.
pub fn random(seed: u64) -> f64 {
    let mut x = seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    for _ in 0..3 {
        x = (x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    }
    ((x ^ (x >> 32)) >> 11) as f64 / (1u64 << 53) as f64
}

/// A box [0, size]^d of cubes, each cut into d! simplices around its diagonal; cubes for which `tag` has none are left out. Inner planes stay planes, but nodes move within them by
/// `distortion` of an edge, except along the last axis.
pub fn box_of(
    dimension: Dimension,
    counts: [usize; 3],
    size: [f64; 3],
    distortion: f64,
    tag: &dyn Fn([usize; 3]) -> Option<i32>,
) -> SimplexMesh {
    let axes = dimension.axes();
    let counts: [usize; 3] = std::array::from_fn(|a| if a < axes { counts[a] } else { 0 });
    let number = |at: [usize; 3]| at[0] + (counts[0] + 1) * (at[1] + (counts[1] + 1) * at[2]);
    let total = counts.iter().map(|n| n + 1).product();
    let mut nodes = vec![[0.0; 3]; total];
    for (n, node) in nodes.iter_mut().enumerate() {
        let at = [n % (counts[0] + 1), n / (counts[0] + 1) % (counts[1] + 1), n / ((counts[0] + 1) * (counts[1] + 1))];
        for a in 0..axes {
            let is_inside = (0..axes).all(|b| at[b] > 0 && at[b] < counts[b]) && a + 1 < axes;
            let moved = if is_inside { distortion * (random((3 * n + a) as u64) - 0.5) } else { 0.0 };
            node[a] = size[a] * (at[a] as f64 + moved) / counts[a] as f64;
        }
    }
    let permutations: &[([usize; 3], bool)] = match dimension {
        Dimension::One => &[([0, 1, 2], true)],
        Dimension::Two => &[([0, 1, 2], true), ([1, 0, 2], false)],
        Dimension::Three => &[
            ([0, 1, 2], true),
            ([1, 2, 0], true),
            ([2, 0, 1], true),
            ([1, 0, 2], false),
            ([0, 2, 1], false),
            ([2, 1, 0], false),
        ],
    };
    let (mut cells, mut tags) = (Vec::new(), Vec::new());
    let cubes = counts.map(|n| n.max(1));
    for cube in 0..cubes.iter().product() {
        let at = [cube % cubes[0], cube / cubes[0] % cubes[1], cube / (cubes[0] * cubes[1])];
        let Some(tag) = tag(at) else { continue };
        for (order, is_even) in permutations {
            let mut corner = at;
            let mut cell = [number(at) as u32; 4];
            for (n, axis) in order[..axes].iter().enumerate() {
                corner[*axis] += 1;
                cell[n + 1] = number(corner) as u32;
            }
            if !is_even {
                cell.swap(axes, axes - 1);
            }
            cells.push(cell);
            tags.push(tag);
        }
    }
    SimplexMesh::new(dimension, nodes, cells, tags).unwrap()
}

/// A symmetric positive definite matrix with all its entries, 1 + A Aᵀ.
pub fn full_matrix(dimension: Dimension, seed: u64) -> [[f64; 6]; 6] {
    let n = dimension.strains();
    let a = |i: usize, j: usize| random(seed * 100 + (6 * i + j) as u64) - 0.3;
    let entry = |i: usize, j: usize| f64::from(i == j) + (0..n).map(|k| a(i, k) * a(j, k)).sum::<f64>();
    std::array::from_fn(|i| std::array::from_fn(|j| if i < n && j < n { entry(i, j) } else { 0.0 }))
}

/// The inverse of the leading n × n block, by elimination.
pub fn inverse(matrix: &[[f64; 6]; 6], n: usize) -> [[f64; 6]; 6] {
    let mut left = *matrix;
    let mut right: [[f64; 6]; 6] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j && i < n)));
    for pivot in 0..n {
        let scale = left[pivot][pivot];
        (left[pivot], right[pivot]) = (left[pivot].map(|v| v / scale), right[pivot].map(|v| v / scale));
        for row in (0..n).filter(|row| *row != pivot) {
            let factor = left[row][pivot];
            for c in 0..6 {
                left[row][c] -= factor * left[pivot][c];
                right[row][c] -= factor * right[pivot][c];
            }
        }
    }
    right
}

/// A model with the tensor \[Pa\] of each tag and unit density.
pub fn model(mesh: SimplexMesh, stiffness: &dyn Fn(i32) -> [[f64; 6]; 6]) -> SimplexModel {
    let dimension = mesh.dimension();
    let tensors = mesh.tags().iter().map(|tag| MandelTensor { dimension, matrix: stiffness(*tag) }).collect();
    let densities = vec![1.0; mesh.cell_count()];
    SimplexModel::with_tensors(mesh, tensors, densities).unwrap()
}

/// Largest difference of two matrices.
pub fn difference(a: &[[f64; 6]; 6], b: &[[f64; 6]; 6]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}
