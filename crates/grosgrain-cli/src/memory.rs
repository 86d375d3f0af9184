//! Estimates of the memory that a run would need.

/// Memory of a sparse Cholesky factorisation \[B\]: 180 n^(4/3) for n unknowns on a three-dimensional grid in nested
/// dissection order. The exponent is that of the factor's entries; the constant fits 604 MB measured for 78,300 unknowns.
pub fn direct(unknowns: usize) -> f64 {
    180.0 * (unknowns as f64).powf(4.0 / 3.0)
}

/// Memory of conjugate gradients \[B\]: half of 81 matrix entries of 12 B and eight vectors for every unknown.
pub fn iterative(unknowns: usize) -> f64 {
    (41.0 * 12.0 + 8.0 * 8.0) * unknowns as f64
}
