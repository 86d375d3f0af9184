//! Harmonic displacements of bodies of simplices against closed forms and identities.

mod simplices;

use grosgrain::homogenization::{
    HarmonicDisplacements, HarmonicError, HarmonicOptions, HarmonicReport, SimplexModel, SimplexSystemError,
    harmonic_displacements, harmonic_loads,
};
use grosgrain::progress::silent;
use grosgrain::simplex::{Boundary, Dimension, SimplexMesh};
use simplices::{DIMENSIONS, box_of, difference, full_matrix, inverse, model, random};

fn solved(model: &SimplexModel, options: &HarmonicOptions) -> (HarmonicDisplacements, HarmonicReport) {
    harmonic_displacements(model, options, &silent).unwrap_or_else(|error| panic!("{error}"))
}

/// Points \[m\] and weights \[m^d\] of a cell that integrate quadratic functions exactly, with barycentric coordinates.
fn quadrature(mesh: &SimplexMesh, cell: usize) -> Vec<([f64; 4], f64)> {
    let n = mesh.dimension().corners();
    let far = match mesh.dimension() {
        Dimension::One => 0.5 + 0.5 / 3f64.sqrt(),
        Dimension::Two => 2.0 / 3.0,
        Dimension::Three => 0.25 + 0.15 * 5f64.sqrt(),
    };
    let near = (1.0 - far) / (n as f64 - 1.0);
    let point = |p: usize| std::array::from_fn(|c| [0.0, if c == p { far } else { near }][usize::from(c < n)]);
    (0..n).map(|p| (point(p), mesh.measure(cell) / n as f64)).collect()
}

/// ∫ h and the components of ∫ (X_a h_b − X_b h_a) of one column.
fn moments(mesh: &SimplexMesh, harmonic: &HarmonicDisplacements, column: usize) -> ([f64; 3], [f64; 3]) {
    let (mut mean, mut moment) = ([0.0; 3], [0.0; 3]);
    for cell in 0..mesh.cell_count() {
        for (weights, share) in quadrature(mesh, cell) {
            let at = |value: &dyn Fn(usize) -> f64| -> f64 {
                mesh.cell(cell).iter().zip(weights).map(|(node, w)| w * value(*node as usize)).sum()
            };
            let x = [0, 1, 2].map(|r| at(&|node| mesh.nodes()[node][r]));
            let h = [0, 1, 2].map(|r| at(&|node| harmonic.fields[node][r][column]));
            for r in 0..3 {
                let (a, b) = ((r + 1) % 3, (r + 2) % 3);
                mean[r] += share * h[r];
                moment[r] += share * (x[a] * h[b] - x[b] * h[a]);
            }
        }
    }
    (mean, moment)
}

#[test]
fn a_homogeneous_body_returns_its_compliance_in_every_cell() {
    for dimension in DIMENSIONS {
        let mesh = box_of(dimension, [6, 4, 5], [2.0, 0.7, 1.1], 0.45, &|_| Some(3));
        let stiffness = full_matrix(dimension, 5);
        let model = model(mesh, &|_| stiffness);
        let (harmonic, report) = solved(&model, &HarmonicOptions::default());
        let compliance = inverse(&stiffness, dimension.strains());
        for cell in 0..model.mesh().cell_count() {
            let error = difference(&harmonic.mollifier(model.mesh(), cell), &compliance);
            assert!(error < 1e-11, "{dimension}: {error:e} in cell {cell}");
        }
        assert!(report.residual < 1e-11 && report.unbalanced < 1e-14, "{report:?}");
        assert_eq!((report.parts, report.has_hinges), (1, false));
        for column in 0..dimension.strains() {
            let (mean, moment) = moments(model.mesh(), &harmonic, column);
            let size = mean.iter().chain(&moment).fold(0.0f64, |m, v| m.max(v.abs()));
            assert!(size < 1e-12, "{dimension}: mean {mean:?}, first moment {moment:?}");
        }
    }
}

#[test]
fn layers_strain_each_by_their_own_compliance() {
    // Layers normal to the last axis, whose compliances differ only in the stresses and strains that touch that axis: under these stresses the stress is uniform, strains in the
    // plane are alike, and displacements are linear in each layer.
    for dimension in DIMENSIONS {
        let across: &[usize] = [&[0][..], &[1, 2], &[2, 3, 4]][dimension.axes() - 1];
        let base = full_matrix(dimension, 8);
        let compliance = |layer: i32| {
            let (mut matrix, added) = (base, full_matrix(dimension, 20 + layer as u64));
            for (i, j) in across.iter().flat_map(|i| across.iter().map(move |j| (*i, *j))) {
                matrix[i][j] += 30f64.powi(layer) * added[i][j];
            }
            matrix
        };
        let last = dimension.axes() - 1;
        let mesh = box_of(dimension, [4; 3], [1.0, 2.0, 1.5], 0.5, &|at| Some(at[last] as i32));
        let model = model(mesh, &|layer| inverse(&compliance(layer), dimension.strains()));
        let (harmonic, _) = solved(&model, &HarmonicOptions::default());
        for cell in 0..model.mesh().cell_count() {
            let (found, exact) = (harmonic.mollifier(model.mesh(), cell), compliance(model.mesh().tags()[cell]));
            for (row, column) in (0..6).flat_map(|row| across.iter().map(move |column| (row, *column))) {
                let error = (found[row][column] - exact[row][column]).abs() / exact[column][column];
                assert!(error < 1e-8, "{dimension}: {error:e} in cell {cell}, row {row}, column {column}");
            }
        }
    }
}

#[test]
fn works_of_tractions_are_twice_the_energies_also_at_high_contrast() {
    // ∫ σ_a : ε(h_b) = ∫ ε(h_a) : C : ε(h_b), from fields and tensors alone.
    for (dimension, contrast) in DIMENSIONS.iter().flat_map(|d| [1e2f64, 1e6].map(|contrast| (*d, contrast))) {
        let tag = |at: [usize; 3]| Some((3.0 * random((at[0] + 10 * at[1] + 100 * at[2]) as u64)) as i32);
        let mesh = box_of(dimension, [7, 5, 4], [1.0; 3], 0.45, &tag);
        let stiffness = |tag| {
            full_matrix(dimension, 3 + tag as u64).map(|row| row.map(|v| v * contrast.powf(0.5 * f64::from(tag))))
        };
        let model = model(mesh, &stiffness);
        let (harmonic, report) = solved(&model, &HarmonicOptions::default());
        let (mut work, mut energy) = ([[0.0; 6]; 6], [[0.0; 6]; 6]);
        for cell in 0..model.mesh().cell_count() {
            let (g, c) = (harmonic.mollifier(model.mesh(), cell), model.tensor(cell).matrix);
            let measure = model.mesh().measure(cell);
            for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
                work[i][j] += measure * g[i][j];
                let pairs = (0..36).map(|e| (e / 6, e % 6));
                energy[i][j] += measure * pairs.map(|(k, l)| g[k][i] * c[k][l] * g[l][j]).sum::<f64>();
            }
        }
        let error = difference(&work, &energy) / (0..6).fold(0.0f64, |m, i| m.max(energy[i][i]));
        assert!(error < 1e-9, "{dimension}, contrast {contrast:e}: {error:e}, {report:?}");
    }
}

#[test]
fn tractions_are_those_of_the_stress_in_the_filled_body() {
    for dimension in [Dimension::Two, Dimension::Three] {
        let hollow = |at: [usize; 3]| (at[..dimension.axes()] != [1, 2, 1][..dimension.axes()]).then_some(0);
        let [filled, hollow] = [&(|_| Some(0)) as &dyn Fn([usize; 3]) -> Option<i32>, &hollow]
            .map(|tag| box_of(dimension, [3, 4, 3], [1.0, 1.3, 0.8], 0.4, tag));
        let loads = harmonic_loads(&filled, &[]).unwrap();
        assert_eq!(harmonic_loads(&hollow, &[]).unwrap(), loads, "no traction in the cavity");
        // ∫ ε(v) : σ, cell by cell.
        for (column, load) in loads.iter().enumerate() {
            let mut sums = vec![[0.0; 3]; filled.nodes().len()];
            let pair = match dimension {
                Dimension::Two => [(0, 0), (1, 1), (0, 1)][column],
                _ => [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)][column],
            };
            for cell in 0..filled.cell_count() {
                for (node, gradient) in filled.cell(cell).iter().zip(filled.gradients(cell)) {
                    sums[*node as usize][pair.0] += 0.5 * filled.measure(cell) * gradient[pair.1];
                    sums[*node as usize][pair.1] += 0.5 * filled.measure(cell) * gradient[pair.0];
                }
            }
            let error = sums.iter().flatten().zip(load.iter().flatten()).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(error < 1e-15, "{dimension}: {error:e}");
        }
    }
}

#[test]
fn a_bar_pulled_one_way_at_both_ends_is_balanced_by_its_inertia() {
    let (length, young, cells) = (2.5, 7.0, 20);
    let mesh = box_of(Dimension::One, [cells, 0, 0], [length, 0.0, 0.0], 0.0, &|_| Some(0));
    let mut stiffness = [[0.0; 6]; 6];
    stiffness[0][0] = young;
    let model = model(mesh, &|_| stiffness);
    let normals = vec![[1.0, 0.0, 0.0]; 2];
    let (harmonic, report) = solved(&model, &HarmonicOptions { normals, ..HarmonicOptions::default() });
    // A body force −2 / L makes the normal force grow from −1 to 1.
    for cell in 0..cells {
        let middle = (cell as f64 + 0.5) / cells as f64;
        let strain = harmonic.mollifier(model.mesh(), cell)[0][0];
        assert!((strain - (2.0 * middle - 1.0) / young).abs() < 1e-13, "cell {cell}: {strain}");
    }
    let inner = 2.0 / cells as f64;
    let taken = ((cells as f64 - 0.5) * inner * inner).sqrt() / 2f64.sqrt();
    assert!((report.unbalanced - taken).abs() < 1e-12, "{} for {taken}", report.unbalanced);
}

#[test]
fn a_boundarys_own_normals_of_any_length_change_nothing_and_others_are_balanced() {
    let mesh = box_of(Dimension::Three, [4, 3, 3], [1.0; 3], 0.5, &|at| Some(at[0] as i32));
    let model = model(mesh, &|tag| full_matrix(Dimension::Three, 40 + tag as u64));
    let boundary = Boundary::of_mesh(model.mesh()).unwrap();
    let faces: Vec<[f64; 3]> = boundary.outer().map(|face| face.normal).collect();
    let with = |normals| solved(&model, &HarmonicOptions { normals, ..HarmonicOptions::default() });
    let (own, _) = with(Vec::new());
    let (same, _) = with(faces.iter().map(|face| face.map(|a| 7.0 * a)).collect());
    let largest = |a: &HarmonicDisplacements, b: &HarmonicDisplacements| -> f64 {
        let pairs = a.fields.iter().flatten().flatten().zip(b.fields.iter().flatten().flatten());
        pairs.fold(0.0, |m, (a, b)| m.max((a - b).abs()))
    };
    assert!(largest(&own, &same) < 1e-12);
    let tilted = |n: usize, face: &[f64; 3]| {
        let length = face.iter().map(|a| a * a).sum::<f64>().sqrt();
        std::array::from_fn(|r| face[r] / length + 0.3 * (random((3 * n + r) as u64) - 0.5))
    };
    let (other, report) = with(faces.iter().enumerate().map(|(n, face)| tilted(n, face)).collect());
    assert!(report.unbalanced > 1e-3 && report.unbalanced < 0.2 && report.residual < 1e-11, "{report:?}");
    let change = largest(&own, &other);
    assert!(change > 1e-3 && change < 0.5, "{change}");
}

#[test]
fn a_bar_held_at_one_end_stretches_from_there() {
    for dimension in DIMENSIONS {
        // Along the last axis, whose planes are planes in the distorted mesh.
        let last = dimension.axes() - 1;
        let (mut counts, mut size) = ([3; 3], [1.0; 3]);
        (counts[last], size[last]) = (6, 3.0);
        let mesh = box_of(dimension, counts, size, 0.45, &|at| Some(i32::from(at[last] > 2)));
        let held: Vec<bool> = mesh.nodes().iter().map(|x| x[last] == 0.0).collect();
        let diagonal = |young: f64| {
            let mut matrix = [[0.0; 6]; 6];
            (0..dimension.strains()).for_each(|i| matrix[i][i] = young);
            matrix
        };
        let young = [5.0, 0.25];
        let model = model(mesh, &|tag| diagonal(young[tag as usize]));
        let (harmonic, report) = solved(&model, &HarmonicOptions { held, ..HarmonicOptions::default() });
        for (x, field) in model.mesh().nodes().iter().zip(&harmonic.fields) {
            let exact = x[last].min(1.5) / young[0] + (x[last] - 1.5).max(0.0) / young[1];
            let found = [0, 1, 2].map(|k| field[k][last]);
            let error = (0..3).fold(0.0f64, |m, k| m.max((found[k] - if k == last { exact } else { 0.0 }).abs()));
            assert!(error < 1e-11, "{dimension}: {found:?} for {exact} at {x:?}");
        }
        assert!(report.unbalanced == 0.0, "nothing is taken from what is held");
    }
}

#[test]
fn parts_and_hinges_are_each_solved_as_they_are() {
    // Two columns that share an edge, and one apart.
    let solid = |at: [usize; 3]| matches!((at[0] / 2, at[1] / 2), (0, 0) | (1, 1) | (3, 1)).then_some(0);
    for dimension in [Dimension::Two, Dimension::Three] {
        let mesh = box_of(dimension, [8, 4, 3], [4.0, 2.0, 1.5], 0.0, &solid);
        let stiffness = full_matrix(dimension, 11);
        let model = model(mesh, &|_| stiffness);
        let (harmonic, report) = solved(&model, &HarmonicOptions::default());
        assert_eq!((report.parts, report.has_hinges), (2, true), "{dimension}");
        let compliance = inverse(&stiffness, dimension.strains());
        for cell in 0..model.mesh().cell_count() {
            let error = difference(&harmonic.mollifier(model.mesh(), cell), &compliance);
            assert!(error < 1e-9, "{dimension}: {error:e} in cell {cell}");
        }
        let unused = model.mesh().nodes().iter().position(|x| x[0] == 2.5 && x[1] == 0.0).unwrap();
        assert_eq!(harmonic.fields[unused], [[0.0; 6]; 3]);
        let size = harmonic.fields.iter().flatten().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
        assert!(size < 10.0, "{size}: no part runs away");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let mesh = box_of(Dimension::Three, [2; 3], [1.0; 3], 0.0, &|_| Some(0));
    let nodes = mesh.nodes().to_vec();
    let model = model(mesh, &|_| full_matrix(Dimension::Three, 1));
    let refused = |options: HarmonicOptions| harmonic_displacements(&model, &options, &silent).unwrap_err();
    let held = |held| HarmonicOptions { held, ..HarmonicOptions::default() };
    assert_eq!(refused(held(vec![true])), HarmonicError::Held { marks: 1, nodes: 27 });
    let on_edge = nodes.iter().map(|x| x[0] == 0.0 && x[1] == 0.0).collect();
    assert_eq!(refused(held(on_edge)), HarmonicError::Turns { held: 3, nodes: 27, cell: 0 });
    let normals = |normals| HarmonicOptions { normals, ..HarmonicOptions::default() };
    assert_eq!(refused(normals(vec![[1.0; 3]; 5])), HarmonicError::Normals { normals: 5, faces: 48 });
    let mut some = vec![[1.0; 3]; 48];
    some[9] = [0.0; 3];
    assert_eq!(refused(normals(some)), HarmonicError::Normal { face: 9, normal: [0.0; 3] });
    let stop = harmonic_displacements(&model, &HarmonicOptions::default(), &|stage, _, _| stage != "factoring");
    assert_eq!(stop.unwrap_err(), SimplexSystemError::Interrupted { stage: "factoring" }.into());
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let mesh = box_of(Dimension::Three, [12; 3], [1.0; 3], 0.5, &|at| Some((at[0] + at[1] * at[2]) as i32 % 3));
    let model = model(mesh, &|tag| full_matrix(Dimension::Three, tag as u64));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solved(&model, &HarmonicOptions::default()).0)
    };
    assert_eq!(with(1), with(3));
}
