//! Effective tensors against closed forms and exact identities (KMOD09, `kharevych2009numerical`).

use grosgrain::homogenization::{
    Average, BoundaryNormals, HomogenizeError, HomogenizeOptions, Homogenized, SimplexModel, average_tensors,
    homogenize,
};
use grosgrain::linalg::matrix3::{Matrix3, apply, polar};
use grosgrain::material::IsotropicMaterial;
use grosgrain::progress::silent;
use grosgrain::simplex::{
    BoundingBox, BoxCut, Dimension, MandelTensor, OverlapError, Overlaps, SimplexLattice, SimplexMesh, mandel_strain,
};

const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];

fn material(dimension: Dimension, young: f64, poisson: f64) -> MandelTensor {
    MandelTensor::of_material(dimension, &IsotropicMaterial::new(young, poisson).unwrap().tensor())
}

fn lattice(dimension: Dimension, boxes: [usize; 3]) -> SimplexMesh {
    let around = BoundingBox { lower: [0.0; 3], upper: [1.2, 0.8, 1.0] };
    SimplexLattice { dimension, boxes, around, cut: BoxCut::Alternating }.mesh().unwrap()
}

/// A body with this tensor per cell and 1000 kg per unit of measure.
fn body(mesh: SimplexMesh, tensor: impl Fn(usize) -> MandelTensor) -> SimplexModel {
    let n = mesh.cell_count();
    SimplexModel::with_tensors(mesh, (0..n).map(tensor).collect(), vec![1000.0; n]).unwrap()
}

fn homogenized(model: &SimplexModel, coarse: &SimplexMesh) -> Homogenized {
    homogenize(model, coarse, &HomogenizeOptions::default(), &silent).unwrap()
}

/// Largest difference over the largest entry of the second.
fn difference(a: &MandelTensor, b: &MandelTensor) -> f64 {
    let largest =
        |m: &dyn Fn(usize, usize) -> f64| (0..36).fold(0.0f64, |largest, e| largest.max(m(e / 6, e % 6).abs()));
    largest(&|i, j| a.matrix[i][j] - b.matrix[i][j]) / largest(&|i, j| b.matrix[i][j])
}

fn centre(mesh: &SimplexMesh, cell: usize) -> [f64; 3] {
    let corners = mesh.dimension().corners();
    std::array::from_fn(|r| (0..corners).map(|n| mesh.corner(cell, n)[r]).sum::<f64>() / corners as f64)
}

/// Stiff above a slanted plane, soft below: nothing that the coarse cells follow.
fn layered(dimension: Dimension, mesh: &SimplexMesh, cell: usize) -> MandelTensor {
    let x = centre(mesh, cell);
    let is_stiff = (5.0 * (x[0] + 0.7 * x[1] + 0.4 * x[2])).sin() > 0.0;
    material(dimension, if is_stiff { 1e7 } else { 1e5 }, if is_stiff { 0.3 } else { 0.45 })
}

#[test]
fn springs_in_series_add_their_compliances_wherever_the_coarse_nodes_lie() {
    let places = [0.0, 0.13, 0.2, 0.45, 0.5, 0.81, 1.0];
    let moduli = [3.0, 200.0, 0.7, 11.0, 5000.0, 42.0];
    let segments = |places: &[f64]| {
        let nodes = places.iter().map(|x| [*x, 0.0, 0.0]).collect();
        let cells: Vec<[u32; 4]> = (1..places.len() as u32).map(|n| [n - 1, n, 0, 0]).collect();
        let tags = vec![0; cells.len()];
        SimplexMesh::new(Dimension::One, nodes, cells, tags).unwrap()
    };
    let spring = |cell: usize| {
        let mut matrix = [[0.0; 6]; 6];
        matrix[0][0] = moduli[cell];
        MandelTensor { dimension: Dimension::One, matrix }
    };
    let model = body(segments(&places), spring);
    for coarse in [vec![0.0, 1.0], vec![0.0, 0.2, 1.0], vec![0.0, 0.31, 0.62, 1.0]] {
        let found = homogenized(&model, &segments(&coarse));
        for (q, ends) in coarse.windows(2).enumerate() {
            let shared = |p: usize| (places[p + 1].min(ends[1]) - places[p].max(ends[0])).max(0.0);
            let compliance: f64 = (0..moduli.len()).map(|p| shared(p) / moduli[p]).sum();
            let (expected, modulus) = ((ends[1] - ends[0]) / compliance, found.effective.tensors[q].matrix[0][0]);
            assert!((modulus / expected - 1.0).abs() < 1e-12, "cell {q} of {coarse:?}: {modulus} for {expected}");
        }
    }
}

#[test]
fn a_homogeneous_body_is_coarsened_into_its_own_material() {
    for dimension in DIMENSIONS {
        let own = material(dimension, 3e6, 0.42);
        let model = body(lattice(dimension, [8, 7, 6]), |_| own);
        let coarse = lattice(dimension, [2, 3, 2]);
        let found = homogenized(&model, &coarse);
        for (q, tensor) in found.effective.tensors.iter().enumerate() {
            assert!(difference(tensor, &own) < 1e-10, "{dimension}, cell {q}: {:e}", difference(tensor, &own));
        }
        assert!(found.effective.averaged.is_empty() && found.downsampled.extrapolated.is_empty());
        assert!(found.filled.iter().all(|share| (share - 1.0).abs() < 1e-12));
        let mass: f64 = found.mass.iter().sum();
        assert!((mass / model.mass() - 1.0).abs() < 1e-13, "{dimension}: {mass}");
    }
}

#[test]
fn a_rough_homogeneous_body_keeps_its_material_along_its_own_normals_only() {
    // The boxes of a lattice that lie in a ball, onto a lattice whose nodes are partly outside.
    let around = BoundingBox { lower: [-0.5; 3], upper: [0.5; 3] };
    let boxes =
        |n: usize| SimplexLattice { dimension: Dimension::Three, boxes: [n; 3], around, cut: BoxCut::Alternating };
    let is_in_ball = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>() < 0.2;
    let whole = boxes(10).mesh().unwrap();
    let (fine, _) = whole.part(|cell| is_in_ball(centre(&whole, cell))).unwrap();
    let coarse = boxes(3).mesh_around(&fine, 0.05).unwrap();
    let own = material(Dimension::Three, 3e6, 0.42);
    let model = body(fine, |_| own);
    let worst = |normals: BoundaryNormals| {
        let options = HomogenizeOptions { normals, ..HomogenizeOptions::default() };
        let found = homogenize(&model, &coarse, &options, &silent).unwrap();
        assert!(!found.downsampled.extrapolated.is_empty());
        let cells = found.effective.tensors.iter().zip(&found.filled);
        cells.fold(0.0f64, |worst, (tensor, filled)| worst.max(difference(tensor, &own.scaled(*filled))))
    };
    let (along_own, along_coarse) = (worst(BoundaryNormals::Fine), worst(BoundaryNormals::Coarse));
    assert!(along_own < 1e-9, "{along_own:e}");
    assert!(along_coarse > 0.05, "{along_coarse:e}");
}

#[test]
fn energies_of_all_products_of_harmonic_displacements_are_those_of_the_fine_mesh() {
    for dimension in DIMENSIONS {
        let fine = lattice(dimension, [9, 8, 7]);
        let model = body(fine.clone(), |cell| layered(dimension, &fine, cell));
        let coarse = lattice(dimension, [2, 2, 2]);
        let found = homogenized(&model, &coarse);
        let overlaps = Overlaps::new(&fine, &coarse).unwrap();
        for q in 0..coarse.cell_count() {
            let of_coarse = found.downsampled.fields.mollifier(&coarse, q);
            let mut largest = 0.0f64;
            let mut misfit = 0.0f64;
            for (a, b) in (0..36).map(|e| (e / 6, e % 6)) {
                let product = |g: &[[f64; 6]; 6], tensor: &MandelTensor| -> f64 {
                    (0..36).map(|e| g[e / 6][a] * tensor.matrix[e / 6][e % 6] * g[e % 6][b]).sum()
                };
                let energy = coarse.measure(q) * product(&of_coarse, &found.effective.tensors[q]);
                let shares = overlaps.of_coarse(q).iter();
                let expected: f64 = shares
                    .map(|&(p, shared)| {
                        let p = p as usize;
                        shared * product(&found.harmonic.mollifier(&fine, p), model.tensor(p))
                    })
                    .sum();
                largest = largest.max(expected.abs());
                misfit = misfit.max((energy - expected).abs());
            }
            assert!(misfit < 1e-9 * largest, "{dimension}, cell {q}: {misfit:e} of {largest:e}");
        }
    }
}

/// The Mandel matrix of ε → Q ε Qᵀ.
fn mandel_rotation(q: &Matrix3) -> [[f64; 6]; 6] {
    let mut rotation = [[0.0; 6]; 6];
    for column in 0..6 {
        let (a, b) = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)][column];
        let weight = if a == b { 1.0 } else { std::f64::consts::FRAC_1_SQRT_2 };
        let mut basis = [[0.0; 3]; 3];
        basis[a][b] = weight;
        basis[b][a] = weight;
        let turned: Matrix3 = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..9).map(|e| q[i][e / 3] * basis[e / 3][e % 3] * q[j][e % 3]).sum())
        });
        let strain = mandel_strain(Dimension::Three, &turned);
        (0..6).for_each(|row| rotation[row][column] = strain[row]);
    }
    rotation
}

#[test]
fn rotating_both_meshes_rotates_the_tensors() {
    let (q, _) = polar(&[[0.3, -0.8, 0.5], [0.9, 0.4, 0.1], [-0.3, 0.4, 0.85]]);
    let turned = |mesh: &SimplexMesh| {
        let nodes = mesh.nodes().iter().map(|x| apply(&q, x)).collect();
        let cells = (0..mesh.cell_count()).map(|c| std::array::from_fn(|n| mesh.cell(c)[n])).collect();
        SimplexMesh::new(Dimension::Three, nodes, cells, mesh.tags().to_vec()).unwrap()
    };
    let (fine, coarse) = (lattice(Dimension::Three, [7, 6, 6]), lattice(Dimension::Three, [2, 2, 1]));
    let tensor = |cell: usize| layered(Dimension::Three, &fine, cell);
    let straight = homogenized(&body(fine.clone(), tensor), &coarse);
    let rotated = homogenized(&body(turned(&fine), tensor), &turned(&coarse));
    let m = mandel_rotation(&q);
    for (cell, (a, b)) in straight.effective.tensors.iter().zip(&rotated.effective.tensors).enumerate() {
        let back = |i: usize, j: usize| (0..36).map(|e| m[e / 6][i] * b.matrix[e / 6][e % 6] * m[e % 6][j]).sum();
        let back = MandelTensor { matrix: std::array::from_fn(|i| std::array::from_fn(|j| back(i, j))), ..*b };
        assert!(difference(&back, a) < 1e-8, "cell {cell}: {:e}", difference(&back, a));
    }
}

#[test]
fn averages_weigh_materials_by_their_share_of_a_coarse_cell() {
    // Fine boxes lie wholly in one layer or the other, and layers cut every coarse cell of the first half of the boxes alike.
    for dimension in DIMENSIONS {
        let (soft, stiff) = (material(dimension, 1e5, 0.2), material(dimension, 9e5, 0.4));
        let fine = lattice(dimension, [8, 4, 4]);
        let is_stiff = |cell: usize| centre(&fine, cell)[0] > 0.6;
        let model = body(fine.clone(), |cell| if is_stiff(cell) { stiff } else { soft });
        let coarse = lattice(dimension, [1, 1, 1]);
        let overlaps = Overlaps::new(&fine, &coarse).unwrap();
        let [by_tensor, by_constants] =
            [Average::Stiffness, Average::Coefficients].map(|a| average_tensors(&model, &coarse, &overlaps, a));
        for q in 0..coarse.cell_count() {
            let shared = overlaps.of_coarse(q).iter();
            let share = shared.filter(|(p, _)| is_stiff(*p as usize)).map(|(_, m)| m).sum::<f64>() / coarse.measure(q);
            let mixed = |i: usize, j: usize| (1.0 - share) * soft.matrix[i][j] + share * stiff.matrix[i][j];
            let mixed = MandelTensor { matrix: std::array::from_fn(|i| std::array::from_fn(|j| mixed(i, j))), ..soft };
            assert!(difference(&by_tensor[q], &mixed) < 1e-12, "{dimension}, cell {q}");
            let mean = |a: f64, b: f64| (1.0 - share) * a + share * b;
            let isotropic = material(dimension, mean(1e5, 9e5), mean(0.2, 0.4));
            assert!(difference(&by_constants[q], &isotropic) < 1e-11, "{dimension}, cell {q}");
            assert!((0.1..0.9).contains(&share), "{dimension}, cell {q}: {share}");
        }
    }
}

#[test]
fn tensors_of_layered_bodies_are_positive() {
    let fine = lattice(Dimension::Three, [8, 8, 8]);
    let model = body(fine.clone(), |cell| layered(Dimension::Three, &fine, cell));
    let found = homogenized(&model, &lattice(Dimension::Three, [2, 1, 1]));
    for (q, tensor) in found.effective.tensors.iter().enumerate() {
        for seed in 0..50 {
            let strain: [f64; 6] = std::array::from_fn(|i| (0.7 * (6 * seed + i) as f64 + 0.3).sin());
            assert!(tensor.quadratic(&strain) > 0.0, "cell {q}");
        }
    }
}

#[test]
fn meshes_that_do_not_belong_together_are_refused() {
    let model = body(lattice(Dimension::Three, [2, 2, 2]), |_| material(Dimension::Three, 1.0, 0.3));
    let refused =
        |coarse: &SimplexMesh| homogenize(&model, coarse, &HomogenizeOptions::default(), &silent).unwrap_err();
    let flat = refused(&lattice(Dimension::Two, [2, 2, 2]));
    assert!(matches!(flat, HomogenizeError::Overlap(OverlapError::Dimensions { .. })), "{flat}");
    let far = |shift: f64, boxes: [usize; 3]| {
        let around = BoundingBox { lower: [shift, 0.0, 0.0], upper: [shift + 1.2, 0.8, 1.0] };
        SimplexLattice { dimension: Dimension::Three, boxes, around, cut: BoxCut::Alternating }.mesh().unwrap()
    };
    let apart = refused(&far(1e3, [1, 1, 1]));
    assert!(apart.to_string().contains("do not overlap") && apart.to_string().contains("unit"), "{apart}");
    let partly = refused(&far(0.65, [2, 1, 1]));
    assert!(partly.to_string().contains("wholly outside") && partly.to_string().contains("more"), "{partly}");
}
