//! Estimates of the memory that a run would need.

/// Memory of a sparse Cholesky factorisation \[B\]: 180 n^(4/3) for n unknowns on a three-dimensional grid in nested
/// dissection order. The exponent is that of the factor's entries; the constant fits 604 MB measured for 78,300 unknowns.
pub fn direct(unknowns: usize) -> f64 {
    180.0 * (unknowns as f64).powf(4.0 / 3.0)
}

/// Memory of matrix-free conjugate gradients with multigrid \[B\]: 150 per unknown, all vectors and coarser lattices
/// included; 143 were measured at 6.4 million unknowns.
pub fn iterative(unknowns: usize) -> f64 {
    150.0 * unknowns as f64
}
