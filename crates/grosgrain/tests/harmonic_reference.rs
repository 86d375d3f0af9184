//! Harmonic displacements of a hollow body of several anisotropic materials equal those of an independent finite element library.

use std::path::Path;

use grosgrain::homogenization::{HarmonicOptions, SimplexModel, harmonic_displacements};
use grosgrain::material::{Elasticity, ElasticityTensor, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::Label;
use grosgrain::progress::silent;
use grosgrain::simplex::{Boundary, Dimension, SimplexMesh};
use ndarray::{Array1, Array2, Array3};

fn fixture(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/harmonic").join(name)
}

fn hollow_ball() -> SimplexModel {
    let nodes: Array2<f64> = ndarray_npy::read_npy(fixture("nodes.npy")).unwrap();
    let cells: Array2<i64> = ndarray_npy::read_npy(fixture("cells.npy")).unwrap();
    let tags: Array1<i64> = ndarray_npy::read_npy(fixture("tags.npy")).unwrap();
    let tensors: Array3<f64> = ndarray_npy::read_npy(fixture("tensors.npy")).unwrap();
    let nodes = nodes.rows().into_iter().map(|x| std::array::from_fn(|r| x[r])).collect();
    let cells = cells.rows().into_iter().map(|cell| std::array::from_fn(|n| cell[n] as u32)).collect();
    let tags = tags.iter().map(|tag| *tag as i32).collect();
    let mut materials = MaterialTable::new();
    for (tag, voigt) in tensors.outer_iter().enumerate() {
        let voigt = std::array::from_fn(|i| std::array::from_fn(|j| voigt[[i, j]]));
        let elasticity = Elasticity::Anisotropic(ElasticityTensor::from_voigt(voigt).unwrap());
        materials.insert(Label(tag as i32), Material::linear(format!("material {tag}"), elasticity, 1.0));
    }
    SimplexModel::new(SimplexMesh::new(Dimension::Three, nodes, cells, tags).unwrap(), &materials).unwrap()
}

#[test]
fn harmonic_displacements_of_a_hollow_ball_equal_those_of_scikit_fem() {
    let model = hollow_ball();
    let exact: Array3<f64> = ndarray_npy::read_npy(fixture("fields.npy")).unwrap();
    assert_eq!(
        (exact.dim(), Boundary::of_mesh(model.mesh()).unwrap().outer().count()),
        ((model.mesh().nodes().len(), 3, 6), 128)
    );
    let (found, report) = harmonic_displacements(&model, &HarmonicOptions::default(), &silent).unwrap();
    assert!(report.residual < 1e-11 && report.unbalanced < 1e-14, "{report:?}");
    let scale = exact.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    for ((node, k, column), exact) in exact.indexed_iter() {
        let error = (found.fields[node][k][column] - exact).abs() / scale;
        assert!(error < 1e-11, "{error:e} at node {node}, component {k}, column {column}");
    }
}

/// A ring of radii 1 and 2 with `rings` layers of triangles.
fn ring(rings: usize, young: f64, poisson: f64) -> SimplexModel {
    let around = 6 * rings;
    let node = |layer: usize, n: usize| (around * layer + n % around) as u32;
    let place = |n: usize| {
        let (radius, angle) =
            (1.0 + (n / around) as f64 / rings as f64, std::f64::consts::TAU * (n % around) as f64 / around as f64);
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    };
    let mut cells = Vec::new();
    for (layer, n) in (0..rings).flat_map(|layer| (0..around).map(move |n| (layer, n))) {
        let [a, b, c, d] = [node(layer, n), node(layer + 1, n), node(layer + 1, n + 1), node(layer, n + 1)];
        cells.extend([[a, b, c, 0], [a, c, d, 0]]);
    }
    let (nodes, tags) = ((0..around * (rings + 1)).map(place).collect(), vec![0; cells.len()]);
    let mut materials = MaterialTable::new();
    let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, poisson).unwrap());
    materials.insert(Label(0), Material::linear("gel", elasticity, 1.0));
    SimplexModel::new(SimplexMesh::new(Dimension::Two, nodes, cells, tags).unwrap(), &materials).unwrap()
}

#[test]
fn a_ring_under_tension_all_around_converges_to_lames_solution() {
    let (young, poisson) = (3.0, 0.3);
    let error = |rings: usize| {
        let model = ring(rings, young, poisson);
        let (found, _) = harmonic_displacements(&model, &HarmonicOptions::default(), &silent).unwrap();
        let (mut sum, mut scale) = (0.0, 0.0);
        for (x, field) in model.mesh().nodes().iter().zip(&found.fields) {
            let radius = x[0].hypot(x[1]);
            let exact = (1.0 + poisson) / young * 4.0 / 3.0 * ((1.0 - 2.0 * poisson) + 1.0 / radius.powi(2));
            let both = [0, 1].map(|k| field[k][0] + field[k][1] - exact * x[k]);
            sum += both[0].powi(2) + both[1].powi(2);
            scale += (exact * radius).powi(2);
        }
        (sum / scale).sqrt()
    };
    let errors = [8, 16, 32].map(error);
    assert!(errors[2] < 1e-3, "{errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "order {order}, errors {errors:?}");
    }
}
