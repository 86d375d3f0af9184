//! How close cells are to regular ones.

use super::SimplexMesh;

/// Squared lengths of the edges of a cell \[m²\].
fn squared_edges(mesh: &SimplexMesh, cell: usize) -> impl Iterator<Item = f64> + '_ {
    let corners = mesh.dimension().corners();
    (1..corners).flat_map(|b| (0..b).map(move |a| (a, b))).map(move |(a, b)| {
        let (a, b) = (mesh.corner(cell, a), mesh.corner(cell, b));
        (0..3).map(|r| (a[r] - b[r]).powi(2)).sum()
    })
}

impl SimplexMesh {
    /// Shape quality of a cell: (V / V₁)^(2/d) / mean(l²), the mean ratio (`liu1994tetrahedron`), with V₁ the measure of a regular simplex of edge 1.
    ///
    /// It is 1 for regular cells and for segments and tends to 0 for flat ones.
    pub fn shape_quality(&self, cell: usize) -> f64 {
        let axes = self.dimension().axes();
        let regular = [1.0, 3f64.sqrt() / 4.0, 2f64.sqrt() / 12.0][axes - 1];
        let mean = squared_edges(self, cell).sum::<f64>() / (axes * (axes + 1) / 2) as f64;
        (self.measure(cell) / regular).powf(2.0 / axes as f64) / mean
    }

    /// Shortest and longest edge of a cell \[m\].
    pub fn edge_range(&self, cell: usize) -> [f64; 2] {
        let range = |[low, high]: [f64; 2], square: f64| [low.min(square), high.max(square)];
        squared_edges(self, cell).fold([f64::INFINITY, 0.0], range).map(f64::sqrt)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Dimension, SimplexMesh};

    fn mesh(dimension: Dimension, nodes: &[[f64; 3]]) -> SimplexMesh {
        SimplexMesh::new(dimension, nodes.to_vec(), vec![[0, 1, 2, 3]], vec![0]).unwrap()
    }

    #[test]
    fn regular_cells_of_any_size_have_quality_one() {
        let tetrahedron =
            [[0.0; 3], [3.0, 3.0, 0.0], [0.0, 3.0, 3.0], [3.0, 0.0, 3.0]].map(|x| x.map(|v: f64| v + 5.0));
        let triangle = [[0.0; 3], [2.0, 0.0, 0.0], [1.0, 3f64.sqrt(), 0.0]];
        let segment = [[0.5, 0.0, 0.0], [4.0, 0.0, 0.0]];
        let meshes = [
            (mesh(Dimension::Three, &tetrahedron), 18f64.sqrt()),
            (mesh(Dimension::Two, &triangle), 2.0),
            (mesh(Dimension::One, &segment), 3.5),
        ];
        for (mesh, edge) in meshes {
            assert!((mesh.shape_quality(0) - 1.0).abs() < 1e-14, "{}", mesh.dimension());
            assert!(mesh.edge_range(0).iter().all(|l| (l - edge).abs() < 1e-14));
        }
    }

    #[test]
    fn the_corner_of_a_cube_has_the_quality_of_its_closed_form() {
        // V = 1/6 and three edges of each 1 and √2: √2^(2/3) / 1.5, as 12 (3 V)^(2/3) / Σ l² has it.
        let corner = mesh(Dimension::Three, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let wanted = 12.0 * 0.5f64.powf(2.0 / 3.0) / 9.0;
        assert!((corner.shape_quality(0) - wanted).abs() < 1e-15, "{}", corner.shape_quality(0));
        assert_eq!(corner.edge_range(0), [1.0, 2f64.sqrt()]);
        let needle = mesh(Dimension::Two, &[[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-6, 0.0]]);
        assert!(needle.shape_quality(0) < 1e-5);
    }
}
