//! Products of unassembled element matrices with vectors.

/// product += factor Σ K_e v_e for elements with N corners and row-major matrices of 3 N rows; vectors have three entries per vertex.
pub(super) fn add_products<const N: usize, const ENTRIES: usize>(
    (corners, matrices): (&[[u32; N]], &[[f64; ENTRIES]]),
    factor: f64,
    vector: &[f64],
    product: &mut [f64],
) {
    for (corners, matrix) in corners.iter().zip(matrices) {
        let local = corners.map(|v| [0, 1, 2].map(|r| vector[3 * v as usize + r]));
        let local = local.as_flattened();
        for (i, row) in matrix.chunks_exact(3 * N).enumerate() {
            product[3 * corners[i / 3] as usize + i % 3] +=
                factor * row.iter().zip(local).map(|(k, v)| k * v).sum::<f64>();
        }
    }
}
