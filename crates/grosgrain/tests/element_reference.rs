//! The stiffness of a hexahedron with 21 elastic constants equals that of an independent finite element library.

mod bodies;

use std::path::Path;

use bodies::relative;
use grosgrain::element::Hex8;
use grosgrain::material::ElasticityTensor;
use ndarray::{Array2, Array3, s};

fn fixture(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/element").join(name)
}

#[test]
fn anisotropic_elements_equal_those_of_scikit_fem() {
    let tensors: Array3<f64> = ndarray_npy::read_npy(fixture("tensors.npy")).unwrap();
    let spacings: Array2<f64> = ndarray_npy::read_npy(fixture("spacings.npy")).unwrap();
    let matrices: Array3<f64> = ndarray_npy::read_npy(fixture("stiffness.npy")).unwrap();
    assert_eq!(tensors.dim().0, 4);
    for n in 0..tensors.dim().0 {
        let voigt = std::array::from_fn(|i| std::array::from_fn(|j| tensors[[n, i, j]]));
        let element = Hex8::new(std::array::from_fn(|a| spacings[[n, a]]));
        let found = element.stiffness(&ElasticityTensor::from_voigt(voigt).unwrap());
        let exact: Vec<f64> = matrices.slice(s![n, .., ..]).iter().copied().collect();
        // Both sum 8 or more points of 36 products each.
        let error = relative(&found, &exact);
        assert!(error < 1e-13, "element {n}: {error:.1e}");
    }
}
