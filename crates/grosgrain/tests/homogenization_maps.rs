//! From coarse to fine by harmonic displacements: what the map keeps exactly, and its formula term by term (KMOD09, `kharevych2009numerical`, §4.3).

use grosgrain::homogenization::{
    Blending, HarmonicDisplacements, HarmonicMap, HomogenizeOptions, Homogenized, SimplexEmbedding, SimplexModel,
    homogenize,
};
use grosgrain::linalg::matrix3::{Matrix3, apply, inverse, polar};
use grosgrain::material::IsotropicMaterial;
use grosgrain::progress::silent;
use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, Locator, MandelTensor, SimplexLattice, SimplexMesh};

mod bodies;

use bodies::Uniform;

const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];
const BLENDINGS: [Blending; 2] = [Blending::PerCell, Blending::Continuous];

fn lattice(dimension: Dimension, boxes: [usize; 3]) -> SimplexMesh {
    let around = BoundingBox { lower: [0.0; 3], upper: [1.2, 0.8, 1.0] };
    SimplexLattice { dimension, boxes, around, cut: BoxCut::Alternating }.mesh().unwrap()
}

/// Stiff above slanted planes, soft below, by a factor.
fn layered(dimension: Dimension, factor: f64) -> SimplexModel {
    let mesh = lattice(dimension, [6, 6, 6]);
    let tensor = |cell: usize| {
        let x = mesh.centre(cell);
        let is_stiff = (9.0 * (x[0] + 0.7 * x[1] + 0.4 * x[2])).sin() > 0.0;
        let material = IsotropicMaterial::new(if is_stiff { 1e5 * factor } else { 1e5 }, 0.3).unwrap();
        MandelTensor::of_material(dimension, &material.tensor())
    };
    let tensors = (0..mesh.cell_count()).map(tensor).collect();
    let densities = vec![1000.0; mesh.cell_count()];
    SimplexModel::with_tensors(mesh, tensors, densities).unwrap()
}

fn mapped(model: &SimplexModel, coarse: &SimplexMesh) -> (Homogenized, HarmonicMap) {
    let found = homogenize(model, coarse, &HomogenizeOptions::default(), &silent).unwrap();
    let embedding = SimplexEmbedding::new(model.mesh(), &Locator::new(coarse));
    let map = HarmonicMap::new(&found.harmonic, (coarse, &found.downsampled.fields), embedding);
    (found, map)
}

/// Displacements of the nodes, three each.
fn field(mesh: &SimplexMesh, of: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
    mesh.nodes().iter().flat_map(|x| of(*x)).collect()
}

/// Σ_n s_n h_n.
fn combined(fields: &HarmonicDisplacements, stress: &[f64; 6]) -> Vec<f64> {
    let at = |field: &[[f64; 6]; 3]| field.map(|row| row.iter().zip(stress).map(|(h, s)| h * s).sum::<f64>());
    fields.fields.iter().flat_map(at).collect()
}

fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |m, a| m.max(a.abs()))
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// Displacement of a rotation and a stretch about the origin within the dimension.
fn turned_and_stretched(dimension: Dimension, stretch: f64) -> Matrix3 {
    let entry = |i: usize, j: usize| f64::from(i == j) + stretch * ((3 * i + 2 * j) as f64).sin();
    let stretched: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
    let skewed = match dimension {
        Dimension::One => return [[1.0 + stretch, 0.0, 0.0], [0.0; 3], [0.0; 3]],
        Dimension::Two => [[-0.6, -0.8, 0.0], [0.8, -0.6, 0.0], [0.0, 0.0, 1.0]],
        Dimension::Three => polar(&[[-0.5, -1.0, 0.3], [0.9, -0.4, 0.2], [0.1, 0.4, 0.7]]).0,
    };
    let turned = grosgrain::linalg::matrix3::product(&skewed, &stretched);
    let axes = dimension.axes();
    std::array::from_fn(|i| std::array::from_fn(|j| if i < axes && j < axes { turned[i][j] } else { 0.0 }))
}

fn moved(dimension: Dimension, gradient: Matrix3) -> impl Fn([f64; 3]) -> [f64; 3] {
    let by: [f64; 3] = std::array::from_fn(|r| if r < dimension.axes() { 0.3 + r as f64 } else { 0.0 });
    move |x| {
        let y = apply(&gradient, &x);
        std::array::from_fn(|r| y[r] - x[r] + by[r])
    }
}

#[test]
fn rigid_motions_are_exact_however_far() {
    for dimension in DIMENSIONS {
        let model = layered(dimension, 20.0);
        let coarse = lattice(dimension, [2, 1, 2]);
        let (_, map) = mapped(&model, &coarse);
        let motion = moved(dimension, turned_and_stretched(dimension, 0.0));
        for blending in BLENDINGS {
            let found = map.map(&field(&coarse, &motion), blending);
            let off = apart(&found.displacement, &field(model.mesh(), &motion));
            assert!(off < 1e-12 && found.barycentric.is_empty(), "{dimension} {blending:?}: {off:e}");
        }
    }
}

#[test]
fn a_homogeneous_body_follows_the_barycentric_map() {
    for dimension in DIMENSIONS {
        let model = layered(dimension, 1.0);
        let coarse = lattice(dimension, [2, 1, 2]);
        let (_, map) = mapped(&model, &coarse);
        let mut random = Uniform(4);
        let mut given = field(&coarse, moved(dimension, turned_and_stretched(dimension, 0.2)));
        let axes = dimension.axes();
        given.iter_mut().enumerate().filter(|(i, _)| i % 3 < axes).for_each(|(_, u)| *u += 0.05 * random.signed());
        for blending in BLENDINGS {
            let found = map.map(&given, blending);
            let off = apart(&found.displacement, &map.embedding().prolong(&given));
            assert!(off < 1e-9 && found.barycentric.is_empty(), "{dimension} {blending:?}: {off:e}");
        }
    }
}

#[test]
fn coarse_nodes_stay_where_they_are_and_fine_ones_between_them_do_not_follow_the_barycentric_map() {
    for dimension in DIMENSIONS {
        let model = layered(dimension, 20.0);
        // Every coarse node is a fine one.
        let coarse = lattice(dimension, [2, 1, 2]);
        let (_, map) = mapped(&model, &coarse);
        let given = field(&coarse, moved(dimension, turned_and_stretched(dimension, 0.05)));
        for blending in BLENDINGS {
            let found = map.map(&given, blending).displacement;
            let locator = Locator::new(model.mesh());
            for (node, at) in coarse.nodes().iter().enumerate() {
                let (twin, _) = locator.locate(*at).weights(model.mesh()).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
                let twin = 3 * twin as usize;
                assert!(
                    apart(&found[twin..twin + 3], &given[3 * node..3 * node + 3]) < 1e-11,
                    "{dimension} {blending:?}"
                );
            }
            let off = apart(&found, &map.embedding().prolong(&given));
            assert!(off > 1e-3, "{dimension} {blending:?}: {off:e}");
        }
    }
}

#[test]
fn small_harmonic_displacements_are_exact() {
    for dimension in DIMENSIONS {
        let model = layered(dimension, 20.0);
        // Neither nested nor wholly inside.
        let around = BoundingBox { lower: [0.0; 3], upper: [1.1, 0.75, 0.9] };
        let coarse = SimplexLattice { dimension, boxes: [2; 3], around, cut: BoxCut::Alternating }.mesh().unwrap();
        let (found, map) = mapped(&model, &coarse);
        assert!(map.embedding().outside().next().is_some());
        for n in 0..dimension.strains() {
            let mut stress = [0.0; 6];
            (stress[n], stress[0]) = (300.0, stress[0] + 100.0);
            let exact = combined(&found.harmonic, &stress);
            for blending in BLENDINGS {
                let mapped = map.map(&combined(&found.downsampled.fields, &stress), blending);
                let off = apart(&mapped.displacement, &exact);
                assert!(off < 1e-11 * largest(&exact).max(1.0), "{dimension} {n} {blending:?}: {off:e}");
                assert!(mapped.barycentric.is_empty());
                let barycentric = map.embedding().prolong(&combined(&found.downsampled.fields, &stress));
                assert!(apart(&barycentric, &exact) > 1e-6, "{dimension} {n}: there is something to keep");
            }
        }
    }
}

/// In the plane the rotation of a cell is a root of a cos θ + b sin θ = c, and everything else is linear.
#[test]
fn the_map_is_equations_nine_and_ten_term_by_term() {
    let dimension = Dimension::Two;
    let model = layered(dimension, 20.0);
    let coarse = lattice(dimension, [2, 2, 1]);
    let (found, map) = mapped(&model, &coarse);
    let mut random = Uniform(9);
    let mut given = field(&coarse, moved(dimension, turned_and_stretched(dimension, 0.03)));
    given.iter_mut().enumerate().filter(|(i, _)| i % 3 < 2).for_each(|(_, u)| *u += 0.02 * random.signed());
    let fine = map.map(&given, Blending::PerCell).displacement;
    let (fields, downsampled) = (&found.harmonic.fields, &found.downsampled.fields.fields);
    for (node, at) in model.mesh().nodes().iter().enumerate() {
        let corners = coarse.cell(map.embedding().cell(node) as usize);
        let [zero, one, two] = [0, 1, 2].map(|n| corners[n] as usize);
        let place =
            |node: usize| -> [f64; 2] { std::array::from_fn(|r| coarse.nodes()[node][r] + given[3 * node + r]) };
        // R (x_i − x_0) = X_i − X_0 + (H_i − H_0) : S, four equations for cos θ, sin θ and s.
        let row = |node: usize, r: usize| -> ([f64; 2], [f64; 3], f64) {
            let d: [f64; 2] = std::array::from_fn(|c| place(node)[c] - place(zero)[c]);
            let of_turn = if r == 0 { [d[0], -d[1]] } else { [d[1], d[0]] };
            let h = std::array::from_fn(|n| downsampled[node][r][n] - downsampled[zero][r][n]);
            (of_turn, h, coarse.nodes()[node][r] - coarse.nodes()[zero][r])
        };
        let rows = [row(one, 0), row(one, 1), row(two, 0), row(two, 1)];
        // From the first three rows s is linear in (cos θ, sin θ, 1); the last gives the root.
        let matrix: Matrix3 = std::array::from_fn(|i| rows[i].1.map(|h| 1e6 * h));
        let solve = |right: [f64; 3]| apply(&inverse(&matrix).unwrap(), &right).map(|s| 1e6 * s);
        let of_cosine = solve([0, 1, 2].map(|i| rows[i].0[0]));
        let of_sine = solve([0, 1, 2].map(|i| rows[i].0[1]));
        let constant = solve([0, 1, 2].map(|i| -rows[i].2));
        let last = |s: &[f64; 3]| (0..3).map(|n| rows[3].1[n] * s[n]).sum::<f64>();
        let (a, b) = (rows[3].0[0] - last(&of_cosine), rows[3].0[1] - last(&of_sine));
        let c = rows[3].2 + last(&constant);
        let roots = [1.0, -1.0].map(|sign| b.atan2(a) + sign * (c / a.hypot(b)).clamp(-1.0, 1.0).acos());
        let reached = roots.map(|angle| {
            let (cosine, sine) = (angle.cos(), angle.sin());
            let s: [f64; 3] = std::array::from_fn(|n| cosine * of_cosine[n] + sine * of_sine[n] + constant[n]);
            let y: [f64; 2] = std::array::from_fn(|r| {
                let harmonic = (0..3).map(|n| (fields[node][r][n] - downsampled[zero][r][n]) * s[n]).sum::<f64>();
                at[r] - coarse.nodes()[zero][r] + harmonic
            });
            let x0 = place(zero);
            [x0[0] + cosine * y[0] + sine * y[1] - at[0], x0[1] - sine * y[0] + cosine * y[1] - at[1]]
        });
        let off = reached.map(|u| apart(&u, &fine[3 * node..3 * node + 2]));
        assert!(off[0].min(off[1]) < 1e-9, "node {node}: {off:?}");
    }
}

/// Fine nodes a little on either side of the faces between coarse cells.
#[test]
fn blended_maps_do_not_jump_between_cells() {
    let coarse = lattice(Dimension::Two, [2, 2, 1]);
    let fine = lattice(Dimension::Two, [8, 8, 1]);
    let mut random = Uniform(2);
    let mut fields = |mesh: &SimplexMesh| {
        let mut field = |x: &[f64; 3]| {
            let noise: [f64; 6] = std::array::from_fn(|_| 0.02 * random.signed());
            let mut field = [noise.map(|v| 1e-6 * v), noise.map(|v| -1e-6 * v), [0.0; 6]];
            (field[0][0], field[1][1]) = (field[0][0] + 1e-6 * x[0], field[1][1] + 1e-6 * x[1]);
            (field[0][2], field[1][2]) = (field[0][2] + 5e-7 * x[1], field[1][2] + 5e-7 * x[0]);
            field
        };
        HarmonicDisplacements { fields: mesh.nodes().iter().map(&mut field).collect() }
    };
    let (of_fine, of_coarse) = (fields(&fine), fields(&coarse));
    let mut given = field(&coarse, |_| [0.0; 3]);
    given.iter_mut().enumerate().filter(|(i, _)| i % 3 < 2).for_each(|(_, u)| *u = 0.05 * random.signed());
    let beside = |by: f64, blending| {
        let nodes = fine.nodes().iter().map(|x| [x[0] + by, x[1] + 0.618 * by, 0.0]).collect();
        let cells = (0..fine.cell_count()).map(|c| std::array::from_fn(|n| *fine.cell(c).get(n).unwrap_or(&0)));
        let mesh = SimplexMesh::new(Dimension::Two, nodes, cells.collect(), fine.tags().to_vec()).unwrap();
        let embedding = SimplexEmbedding::new(&mesh, &Locator::new(&coarse));
        HarmonicMap::new(&of_fine, (&coarse, &of_coarse), embedding).map(&given, blending)
    };
    let inside: Vec<usize> = (0..fine.nodes().len())
        .filter(|n| (0..2).all(|r| (0.01..[1.19, 0.79][r]).contains(&fine.nodes()[*n][r])))
        .collect();
    let jump = |blending| {
        let (left, right) = (beside(-1e-7, blending), beside(1e-7, blending));
        assert!(left.barycentric.is_empty());
        inside
            .iter()
            .map(|n| apart(&left.displacement[3 * n..3 * n + 3], &right.displacement[3 * n..3 * n + 3]))
            .fold(0.0, f64::max)
    };
    let (blended, published) = (jump(Blending::Continuous), jump(Blending::PerCell));
    assert!(blended < 1e-6 && published > 1e-4, "{blended:e}, {published:e}");
}

#[test]
fn cells_without_a_rotation_are_told_and_follow_the_barycentric_map() {
    let dimension = Dimension::Two;
    let model = layered(dimension, 20.0);
    let coarse = lattice(dimension, [1, 1, 1]);
    let (found, map) = mapped(&model, &coarse);
    // The first cell is turned inside out.
    let mut given = field(&coarse, |_| [0.0; 3]);
    let mirrored = coarse.cell(0).iter().find(|n| !coarse.cell(1).contains(n)).unwrap();
    let middle = coarse.centre(1);
    for r in 0..2 {
        given[3 * *mirrored as usize + r] = middle[r] - coarse.nodes()[*mirrored as usize][r];
    }
    let mapped = map.map(&given, Blending::PerCell);
    assert_eq!(mapped.barycentric, [0]);
    let barycentric = map.embedding().prolong(&given);
    for node in (0..model.mesh().nodes().len()).filter(|node| map.embedding().cell(*node) == 0) {
        assert_eq!(mapped.displacement[3 * node..3 * node + 3], barycentric[3 * node..3 * node + 3]);
    }
    let mut flat = found.downsampled.fields.clone();
    flat.fields.iter_mut().for_each(|field| field.iter_mut().for_each(|row| row[1] = row[0]));
    let embedding = map.embedding().clone();
    let none = HarmonicMap::new(&found.harmonic, (&coarse, &flat), embedding).map(&given, Blending::Continuous);
    assert_eq!((none.barycentric, none.displacement), (vec![0, 1], barycentric));
}
