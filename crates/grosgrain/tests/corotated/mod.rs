//! Bodies, states and potentials for the tests of the coarse model under large rotations.
#![allow(dead_code, reason = "every test binary takes the part it needs")]

use crate::bodies::*;
use grosgrain::coarse::{
    BuildOptions, CoarseModel, Corotated, EmbeddedPoint, Embedding, Integration, Method, Potential, build,
};
use grosgrain::element::CellMatrix;
use grosgrain::fine::FineModel;
use grosgrain::linalg::matrix3::{IDENTITY, Matrix3, apply, product, skew};
use grosgrain::material::{Law, Material, MaterialTable, Projection};
use grosgrain::mesh::{Cell, Label, Node, VoxelGrid};
use grosgrain::progress::silent;
use grosgrain::training::TrainingKind;

pub const SPACING: [f64; 3] = [1.0, 0.5, 0.8];
pub const INTEGRATIONS: [Integration; 3] = [Integration::Gauss, Integration::Centre, Integration::Stiffness];

/// Labels 0 to 3: corotational, neo-Hookean, stiff corotational, linear.
pub fn materials() -> MaterialTable {
    let mut table = MaterialTable::new();
    let entries = [(3.0, Law::Corotational), (5.0, Law::NeoHookean), (60.0, Law::Corotational), (20.0, Law::Linear)];
    for (label, (young, law)) in entries.into_iter().enumerate() {
        let linear = Material::linear(format!("material {label}"), isotropic(young, 0.3), 1000.0);
        table.insert(Label(label as i32), Material { law, ..linear });
    }
    table
}

/// A body of 2 × 2 × 1 coarse cells in random materials. The second has voids; if `with_linear`, the third has cells of small displacement and the fourth is
/// made of such cells.
pub fn body(degree: usize, with_linear: bool, seed: u64) -> FineModel {
    let mut grid = VoxelGrid::uniform([2 * degree, 2 * degree, degree], SPACING, Label(0));
    grid.origin = [0.3, -0.2, 0.7];
    let mut random = Uniform(seed);
    for cell in 0..grid.lattice.cell_count() {
        let at = grid.lattice.cell_position(Cell(cell));
        let coarse = at[0] / degree + 2 * (at[1] / degree);
        grid.labels[cell] = Label((3.0 * random.next()) as i32);
        grid.void[cell] = coarse == 1 && at[0] == degree && at[2] != 0;
        let linear = coarse == 3 || coarse == 2 && random.next() < 0.4;
        if with_linear && linear {
            grid.labels[cell] = Label(3);
        }
    }
    grid.young = Some(
        grid.labels.iter().map(|label| [3.0, 5.0, 60.0, 20.0][label.0 as usize] * (0.7 + random.next())).collect(),
    );
    FineModel::new(grid, &materials()).unwrap()
}

pub fn coarsened(model: &FineModel, degree: usize, method: Method) -> CoarseModel {
    build(model, degree, &BuildOptions { method, ..BuildOptions::default() }, &silent).unwrap().model
}

pub fn trained(model: &FineModel, degree: usize) -> CoarseModel {
    coarsened(model, degree, Method::Trained(TrainingKind::OneRing))
}

/// The rotation by `degrees` around an axis.
pub fn rotation(axis: [f64; 3], degrees: f64) -> Matrix3 {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let spin = skew(&axis.map(|a| a / norm(&axis)));
    let square = product(&spin, &spin);
    std::array::from_fn(|i| std::array::from_fn(|j| IDENTITY[i][j] + sine * spin[i][j] + (1.0 - cosine) * square[i][j]))
}

/// Reference position of every vertex.
pub fn vertex_positions(model: &FineModel, coarse: &CoarseModel) -> Vec<[f64; 3]> {
    let mesh = coarse.mesh();
    mesh.vertices().iter().map(|v| model.node_position(mesh.partition().coincident_node(v.node))).collect()
}

/// Vertices moved by X → turn (X + noise) + shift.
pub fn moved(model: &FineModel, coarse: &CoarseModel, turn: &Matrix3, noise: f64, seed: u64) -> Vec<f64> {
    let mut random = Uniform(seed);
    let mut u = Vec::new();
    for x in vertex_positions(model, coarse) {
        let to = apply(turn, &std::array::from_fn(|r| x[r] + noise * random.signed()));
        u.extend((0..3).map(|r| to[r] - x[r] + [0.4, -0.1, 0.2][r]));
    }
    u
}

/// A state far from rest: turned by 100° and deformed.
pub fn far(model: &FineModel, coarse: &CoarseModel, seed: u64) -> Vec<f64> {
    moved(model, coarse, &rotation([0.3, -0.5, 0.8], 100.0), 0.12, seed)
}

pub fn random_direction(length: usize, seed: u64) -> Vec<f64> {
    let mut random = Uniform(seed);
    (0..length).map(|_| random.signed()).collect()
}

/// ψ(x) = ½ (x − a)·D (x − a) + q/4 |x − a|⁴: convex, and no quadratic function.
pub struct Bowl {
    pub centre: [f64; 3],
    pub stiffness: Matrix3,
    pub quartic: f64,
}

impl Potential for Bowl {
    fn evaluate(&self, at: [f64; 3]) -> (f64, [f64; 3], Matrix3) {
        let x: [f64; 3] = std::array::from_fn(|r| at[r] - self.centre[r]);
        let (square, pull) = (dot(&x, &x), apply(&self.stiffness, &x));
        let gradient = std::array::from_fn(|r| pull[r] + self.quartic * square * x[r]);
        let entry =
            |r: usize, s: usize| self.stiffness[r][s] + self.quartic * (square * IDENTITY[r][s] + 2.0 * x[r] * x[s]);
        let energy = 0.5 * dot(&x, &pull) + 0.25 * self.quartic * square * square;
        (energy, gradient, std::array::from_fn(|r| std::array::from_fn(|s| entry(r, s))))
    }
}

/// A corotated model with loads on all fine nodes and bowls at some of them and at a mean of three.
pub fn loaded(model: &FineModel, coarse: &CoarseModel, integration: Integration) -> (Corotated, Vec<Bowl>) {
    let mut corotated = Corotated::new(model, coarse, integration);
    corotated.set_loads(coarse, &Embedding::new(coarse), &loads(model, 0.2));
    let active: Vec<usize> = (0..model.active().len()).filter(|&n| model.active()[n]).collect();
    let mut points: Vec<EmbeddedPoint> =
        active.iter().step_by(7).flat_map(|&n| EmbeddedPoint::of_node(coarse, Node(n))).collect();
    let last = coarse.partition().fine().node_count() - 1;
    let mean = [(Node(last), 0.5), (Node(last - 1), 0.3), (Node(last - 2), 0.2)];
    points.insert(2, EmbeddedPoint::in_element(coarse, coarse.elements().len() - 1, &mean, 1.7));
    let mut random = Uniform(91);
    let bowl = |_: &EmbeddedPoint| {
        let a: Matrix3 = std::array::from_fn(|_| std::array::from_fn(|_| random.signed()));
        let stiffness = std::array::from_fn(|i| std::array::from_fn(|j| dot(&a[i], &a[j])));
        Bowl { centre: std::array::from_fn(|_| 0.5 * random.signed()), stiffness, quartic: 0.3 }
    };
    let bowls = points.iter().map(bowl).collect();
    corotated.set_points(points);
    (corotated, bowls)
}

/// Random forces on all fine nodes, void ones included.
pub fn loads(model: &FineModel, size: f64) -> Vec<f64> {
    random_direction(3 * model.active().len(), 17).iter().map(|f| size * f).collect()
}

pub fn gradient<P: Potential>(corotated: &Corotated, coarse: &CoarseModel, u: &[f64], potentials: &[P]) -> Vec<f64> {
    let mut out = vec![0.0; u.len()];
    corotated.gradient(coarse, u, potentials, &mut out).unwrap();
    out
}

pub fn tangents<P: Potential>(
    corotated: &Corotated,
    coarse: &CoarseModel,
    u: &[f64],
    (potentials, projection): (&[P], Projection),
) -> Vec<CellMatrix> {
    let mut out = Vec::new();
    corotated.tangents(coarse, u, potentials, projection, &mut out).unwrap();
    out
}

/// Σ over elements of their matrices times p.
pub fn product_with(coarse: &CoarseModel, matrices: &[CellMatrix], p: &[f64]) -> Vec<f64> {
    let mut result = vec![0.0; p.len()];
    for (matrix, corners) in matrices.iter().zip(coarse.mesh().corners()) {
        let unknown = |n: usize| 3 * corners[n / 3] as usize + n % 3;
        for (i, j) in (0..576).map(|n| (n / 24, n % 24)) {
            result[unknown(i)] += matrix[24 * i + j] * p[unknown(j)];
        }
    }
    result
}

/// u + step p.
pub fn stepped(u: &[f64], step: f64, p: &[f64]) -> Vec<f64> {
    u.iter().zip(p).map(|(u, p)| u + step * p).collect()
}
