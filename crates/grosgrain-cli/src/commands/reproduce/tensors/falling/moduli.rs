//! How stiff tensors are.

use grosgrain::homogenization::SimplexModel;
use grosgrain::linalg::DenseCholesky;
use grosgrain::simplex::MandelTensor;

/// Young's modulus \[Pa\] of the isotropic tensor that has the same bulk modulus and the same mean shear modulus, C_iijj / 9 and (C_ijij − C_iijj / 3) / 10.
pub fn isotropic_young(tensor: &MandelTensor) -> f64 {
    let matrix = &tensor.matrix;
    let dilation: f64 = (0..9).map(|e| matrix[e / 3][e % 3]).sum();
    let trace: f64 = (0..6).map(|n| matrix[n][n]).sum();
    let (bulk, shear) = (dilation / 9.0, (trace - dilation / 3.0) / 10.0);
    9.0 * bulk * shear / (3.0 * bulk + shear)
}

/// Median of [`isotropic_young`] over the cells, by volume.
pub fn median_young(model: &SimplexModel) -> f64 {
    let mesh = model.mesh();
    let of_cell = |cell: usize| (isotropic_young(model.tensor(cell)), mesh.measure(cell));
    let mut cells: Vec<(f64, f64)> = (0..mesh.cell_count()).map(of_cell).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * mesh.total_measure();
    let mut below = 0.0;
    let middle = cells.iter().find(|(_, volume)| {
        below += volume;
        below >= half
    });
    middle.map_or(f64::NAN, |(young, _)| *young)
}

/// Compliance \[1/Pa\] along z, how much a cube shrinks under a pressure on its ends alone; infinite where the tensor is singular.
pub fn upright_compliance(tensor: &MandelTensor) -> f64 {
    let Ok(factor) = DenseCholesky::new(6, tensor.matrix.as_flattened().to_vec()) else { return f64::INFINITY };
    let mut strain = [0.0; 6];
    strain[2] = 1.0;
    factor.solve_in_place(&mut strain);
    strain[2]
}

/// Mean of [`upright_compliance`] over the cells whose centre is accepted, by volume; NaN where there is none.
pub fn mean_compliance(model: &SimplexModel, keeps: impl Fn([f64; 3]) -> bool) -> f64 {
    let mesh = model.mesh();
    let (mut sum, mut volume) = (0.0, 0.0);
    for cell in (0..mesh.cell_count()).filter(|cell| keeps(mesh.centre(*cell))) {
        sum += mesh.measure(cell) * upright_compliance(model.tensor(cell));
        volume += mesh.measure(cell);
    }
    sum / volume
}

#[cfg(test)]
mod tests {
    use super::*;
    use grosgrain::material::IsotropicMaterial;
    use grosgrain::simplex::{Dimension, SimplexMesh};

    #[test]
    fn isotropic_tensors_have_their_own_modulus() {
        for (young, poisson) in [(5e4, 0.4), (1.0, -0.3), (2e9, 0.0)] {
            let tensor = IsotropicMaterial::new(young, poisson).unwrap().tensor();
            let tensor = MandelTensor::of_material(Dimension::Three, &tensor);
            let (found, along) = (isotropic_young(&tensor), 1.0 / upright_compliance(&tensor));
            assert!((found / young - 1.0).abs() < 1e-13, "{young}, {poisson}: {found}");
            assert!((along / young - 1.0).abs() < 1e-12, "{young}, {poisson}: {along}");
        }
    }

    #[test]
    fn half_of_the_volume_is_softer_than_the_median_and_compliances_are_averaged_by_volume() {
        let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-5.0, 0.0, 0.0]];
        let mesh = SimplexMesh::new(Dimension::Three, nodes.to_vec(), vec![[0, 1, 2, 3], [4, 0, 2, 3]], vec![0; 2]);
        let tensor = |young| {
            let tensor = IsotropicMaterial::new(young, 0.3).unwrap().tensor();
            MandelTensor::of_material(Dimension::Three, &tensor)
        };
        let tensors = vec![tensor(1.0), tensor(4.0)];
        let model = SimplexModel::with_tensors(mesh.unwrap(), tensors, vec![1.0; 2]).unwrap();
        assert!((median_young(&model) - 4.0).abs() < 1e-13, "the second cell is five times as large");
        assert!((mean_compliance(&model, |_| true) - (1.0 + 5.0 * 0.25) / 6.0).abs() < 1e-13);
        assert!((mean_compliance(&model, |at| at[0] > 0.0) - 1.0).abs() < 1e-13);
    }
}
