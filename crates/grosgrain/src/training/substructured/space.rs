//! Which means of the displacement neighbouring cells share.

use super::forces::InterfaceForces;
use crate::fine::HARMONIC_FIELDS;
use crate::mesh::Node;

/// A direction whose part outside of the span of the earlier ones is below this share of it adds nothing; for harmonic directions the share is of a
/// uniform unit traction on the interface, so that the rounding of forces that vanish makes no directions.
const DEPENDENT: f64 = 1e-9;

/// In what neighbouring coarse cells agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InterfaceSpace {
    /// In weighted means of the displacement of the nodes that they share.
    Means(Means),
    /// In the displacement of every node that they share: the exact problem, for comparison.
    Full,
}

/// Weighted means of the displacement on an interface; linearly dependent ones are dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Means {
    /// The three components of the mean over the area: the resultants of uniform tractions.
    pub translations: bool,
    /// The three components of the mean over the nodes, all of equal weight.
    pub node_means: bool,
    /// The three mean rotations.
    pub rotations: bool,
    /// All first moments; they hold the rotations.
    pub linear: bool,
    /// The six forces of the initial global harmonic displacements as weights (`he2022fast`).
    pub harmonic: bool,
}

impl Default for InterfaceSpace {
    /// Translations and harmonic forces: nine means per interface.
    fn default() -> Self {
        Self::Means(Means { translations: true, node_means: false, rotations: false, linear: false, harmonic: true })
    }
}

/// Orthonormal rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Rows {
    width: usize,
    data: Vec<f64>,
}

impl Rows {
    pub(super) fn new(width: usize) -> Self {
        Self { width, data: Vec::new() }
    }

    /// The three components of one node.
    pub(super) fn identity() -> Self {
        Self { width: 3, data: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0] }
    }

    pub(super) fn count(&self) -> usize {
        self.data.len() / self.width.max(1)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[f64]> {
        self.data.chunks_exact(self.width.max(1))
    }

    /// The rows times a matrix of six columns.
    pub(super) fn times(&self, columns: &[f64]) -> Vec<f64> {
        let product = |row: &[f64], k: usize| {
            row.iter().zip(columns.chunks_exact(HARMONIC_FIELDS)).map(|(s, c)| s * c[k]).sum::<f64>()
        };
        self.iter().flat_map(|row| (0..HARMONIC_FIELDS).map(move |k| product(row, k))).collect()
    }

    /// What of a vector lies outside of the span; projected twice, so that it is orthogonal to rounding.
    fn remainder(&self, mut vector: Vec<f64>) -> (f64, Vec<f64>) {
        for _ in 0..2 {
            for row in self.iter() {
                let share: f64 = row.iter().zip(&vector).map(|(a, b)| a * b).sum();
                vector.iter_mut().zip(row).for_each(|(v, r)| *v -= share * r);
            }
        }
        (norm(&vector), vector)
    }

    fn push(&mut self, norm: f64, vector: &[f64]) {
        self.data.extend(vector.iter().map(|v| v / norm));
    }
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Adds translations, rotations and first moments about the middle of the nodes, weighted by area.
pub(super) fn polynomial_rows(
    rows: &mut Rows,
    forces: &InterfaceForces,
    means: super::Means,
    (nodes, weights): (&[Node], &[f64]),
) {
    let position = |n: &Node| -> [f64; 3] {
        let at = forces.partition.fine().node_position(*n);
        std::array::from_fn(|a| at[a] as f64 * forces.spacing[a])
    };
    let points: Vec<[f64; 3]> = nodes.iter().map(position).collect();
    let total: f64 = weights.iter().sum();
    let middle: [f64; 3] =
        std::array::from_fn(|a| points.iter().zip(weights).map(|(x, w)| w * x[a]).sum::<f64>() / total);
    let mut add = |weighted: bool, value: &dyn Fn([f64; 3]) -> [f64; 3]| {
        let at = |(x, w): (&[f64; 3], &f64)| {
            let w = if weighted { *w } else { 1.0 };
            value(std::array::from_fn(|a| x[a] - middle[a])).map(|v| w * v)
        };
        let vector: Vec<f64> = points.iter().zip(weights).flat_map(at).collect();
        let size = norm(&vector);
        let (left, vector) = rows.remainder(vector);
        if left > DEPENDENT * size {
            rows.push(left, &vector);
        }
    };
    let unit = |a: usize, value: f64| std::array::from_fn(|i| if i == a { value } else { 0.0 });
    if means.translations {
        (0..3).for_each(|a| add(true, &|_| unit(a, 1.0)));
    }
    if means.node_means {
        (0..3).for_each(|a| add(false, &|_| unit(a, 1.0)));
    }
    if means.rotations {
        (0..3).for_each(|a| add(true, &|r| crate::training::rigid::cross(unit(a, 1.0), r)));
    }
    if means.linear {
        (0..9).for_each(|n| add(true, &|r| unit(n / 3, r[n % 3])));
    }
}

/// Adds the six columns of `forces` that are independent, the one with the largest remainder first; `traction` is the norm of a uniform unit traction.
pub(super) fn harmonic_rows(rows: &mut Rows, forces: &[f64], traction: f64) {
    let column = |k: usize| forces.iter().skip(k).step_by(HARMONIC_FIELDS).copied().collect::<Vec<f64>>();
    let mut left: Vec<(f64, Vec<f64>)> = (0..HARMONIC_FIELDS).map(|k| rows.remainder(column(k))).collect();
    while let Some(best) = (0..left.len()).reduce(|best, k| if left[k].0 > left[best].0 { k } else { best }) {
        let (size, vector) = left.swap_remove(best);
        if size <= DEPENDENT * traction {
            break;
        }
        rows.push(size, &vector);
        left = left.into_iter().map(|(_, vector)| rows.remainder(vector)).collect();
    }
}
