//! Coarse models by every choice of material.

use grosgrain::homogenization::{
    Average, CoarseMaterials, CoarseModelError, EffectiveError, HomogenizeError, HomogenizeOptions, SimplexModel,
    average_tensors, coarse_model, homogenize, sampled_tensors,
};
use grosgrain::material::IsotropicMaterial;
use grosgrain::progress::silent;
use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, MandelTensor, Overlaps, SimplexLattice, SimplexMesh};

const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];
const ALL: [CoarseMaterials; 4] = [
    CoarseMaterials::Effective,
    CoarseMaterials::MeanCoefficients,
    CoarseMaterials::MeanStiffness,
    CoarseMaterials::Sampled,
];

fn lattice(dimension: Dimension, boxes: usize) -> SimplexMesh {
    let around = BoundingBox { lower: [0.0; 3], upper: [1.2, 0.8, 1.0] };
    SimplexLattice { dimension, boxes: [boxes; 3], around, cut: BoxCut::Alike }.mesh().unwrap()
}

fn tensor(dimension: Dimension, young: f64) -> MandelTensor {
    MandelTensor::of_material(dimension, &IsotropicMaterial::new(young, 0.3).unwrap().tensor())
}

/// Young's modulus and density by the centre of a cell.
fn body(mesh: SimplexMesh, young: impl Fn([f64; 3]) -> f64) -> SimplexModel {
    let tensors = (0..mesh.cell_count()).map(|c| tensor(mesh.dimension(), young(mesh.centre(c)))).collect();
    let densities = (0..mesh.cell_count()).map(|c| 0.01 * young(mesh.centre(c))).collect();
    SimplexModel::with_tensors(mesh, tensors, densities).unwrap()
}

fn made(
    fine: &SimplexModel,
    coarse: &SimplexMesh,
    materials: CoarseMaterials,
) -> Result<(SimplexModel, Vec<f64>), CoarseModelError> {
    coarse_model(fine, coarse, materials, &HomogenizeOptions::default(), &silent).map(|made| (made.model, made.mass))
}

fn difference(a: &MandelTensor, b: &MandelTensor) -> f64 {
    let (a, b) = (a.matrix.as_flattened(), b.matrix.as_flattened());
    let scale = b.iter().fold(0.0f64, |m, b| m.max(b.abs()));
    a.iter().zip(b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / scale
}

#[test]
fn all_keep_a_homogeneous_material_and_the_mass() {
    for dimension in DIMENSIONS {
        let (own, coarse) = (tensor(dimension, 1e5), lattice(dimension, 2));
        let fine = body(lattice(dimension, 5), |_| 1e5);
        for materials in ALL {
            let (model, mass) = made(&fine, &coarse, materials).unwrap();
            for cell in 0..coarse.cell_count() {
                assert!(difference(model.tensor(cell), &own) < 1e-9, "{dimension} {materials:?}");
            }
            assert!((mass.iter().sum::<f64>() / fine.mass() - 1.0).abs() < 1e-12);
            assert!((model.mass() / fine.mass() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn each_is_what_its_function_gives() {
    let (fine, coarse) =
        (body(lattice(Dimension::Three, 4), |x| if x[2] > 0.4 { 1e6 } else { 1e5 }), lattice(Dimension::Three, 2));
    let overlaps = Overlaps::new(fine.mesh(), &coarse).unwrap();
    let found = homogenize(&fine, &coarse, &HomogenizeOptions::default(), &silent).unwrap();
    let wanted = [
        found.effective.tensors,
        average_tensors(&fine, &coarse, &overlaps, Average::Coefficients),
        average_tensors(&fine, &coarse, &overlaps, Average::Stiffness),
        sampled_tensors(&fine, &coarse).0,
    ];
    for (materials, wanted) in ALL.into_iter().zip(wanted) {
        let (model, mass) = made(&fine, &coarse, materials).unwrap();
        assert_eq!((0..coarse.cell_count()).map(|c| *model.tensor(c)).collect::<Vec<_>>(), wanted, "{materials:?}");
        assert_eq!(mass, found.mass);
        assert_eq!((0..coarse.cell_count()).map(|c| model.density(c)).collect::<Vec<_>>(), found.density);
    }
}

/// A modulus that grows along x in thin layers: two Gauss points see its mean to the layers' thickness.
#[test]
fn samples_are_the_material_at_the_points_of_the_rule() {
    let segment = lattice(Dimension::One, 1);
    let fine = body(lattice(Dimension::One, 1000), |x| 1e5 * (1.0 + x[0]));
    let (tensors, nearest) = sampled_tensors(&fine, &segment);
    let modulus = tensors[0].matrix[0][0];
    assert!((modulus / 1.6e5 - 1.0).abs() < 2e-3 && nearest.is_empty(), "{modulus}");
    // Both points, at 0.21 and 0.79 of the length, miss a stiff middle.
    let fine = body(lattice(Dimension::One, 1000), |x| if (x[0] - 0.6).abs() < 0.3 { 1e9 } else { 1e5 });
    assert!((sampled_tensors(&fine, &segment).0[0].matrix[0][0] / 1e5 - 1.0).abs() < 1e-12);
}

#[test]
fn points_in_voids_count_as_void_and_cells_of_nothing_else_take_what_is_nearest() {
    let whole = lattice(Dimension::One, 100);
    let without = |from: f64, to: f64| whole.part(|c| !(from..to).contains(&whole.centre(c)[0])).unwrap().0;
    let segment = lattice(Dimension::One, 1);
    let half = sampled_tensors(&body(without(0.0, 0.6), |_| 1e5), &segment);
    assert!((half.0[0].matrix[0][0] / 0.5e5 - 1.0).abs() < 1e-12 && half.1.is_empty());
    // Only the ends are left.
    let ends = body(without(0.1, 1.1), |x| if x[0] > 0.6 { 3e5 } else { 1e5 });
    let (tensors, nearest) = sampled_tensors(&ends, &segment);
    assert!([1e5, 3e5].contains(&tensors[0].matrix[0][0].round()) && nearest == [0]);
}

#[test]
fn cells_wholly_outside_are_refused_by_all() {
    let around = BoundingBox { lower: [0.0; 3], upper: [2.4, 0.8, 1.0] };
    let coarse =
        SimplexLattice { dimension: Dimension::Two, boxes: [4, 1, 1], around, cut: BoxCut::Alike }.mesh().unwrap();
    let fine = body(lattice(Dimension::Two, 4), |_| 1e5);
    for materials in ALL {
        let error = made(&fine, &coarse, materials).unwrap_err();
        let outside =
            CoarseModelError::Homogenize(HomogenizeError::Effective(EffectiveError::Outside { cell: 4, count: 4 }));
        assert_eq!(error, outside, "{materials:?}");
    }
}
