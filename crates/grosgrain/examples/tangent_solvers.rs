//! Newton systems of a body that bends a little more with every update: prints what each solver takes.
//!
//! `cargo run --release --example tangent_solvers -- 48 48 36`
//!
//! Two materials of contrast 1000 (1e5 Pa and 1e8 Pa, 1000 kg/m³), cells of 1 cm, a cut and pores, inertia of implicit steps of
//! 0.01 s; and the coarse elements of 2 × 2 × 2 cells with trilinear shape functions, split by the cut.

use std::time::Instant;

use grosgrain::assembly::{CellStiffness, Constraints};
use grosgrain::element::{CellMatrix, Hex8};
use grosgrain::linalg::matrix3::{Matrix3, polar};
use grosgrain::material::IsotropicMaterial;
use grosgrain::mesh::{Cell, Lattice, Node};
use grosgrain::partition::{CoarseMesh, Partition};
use grosgrain::solver::{ElementCells, ElementTangent, LatticeTangent, LinearReport, SolverError};

const SPACING: f64 = 0.01;
const YOUNG: [f64; 2] = [1e5, 1e8];
const DENSITY: f64 = 1000.0;
const STEP: f64 = 0.01;
/// By how much the far end turns per update \[rad\].
const TURN: f64 = 0.05;
const UPDATES: usize = 3;
const TOLERANCES: [f64; 2] = [1e-3, 1e-6];

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

struct Body {
    lattice: Lattice,
    /// Index of the material, none for a void.
    materials: Vec<Option<usize>>,
    tangents: Vec<CellMatrix>,
}

impl CellStiffness for Body {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        self.materials[cell].map(|_| (1.0, &self.tangents[cell]))
    }
}

impl Body {
    fn new(cells: [usize; 3], is_stiff: fn([f64; 3]) -> bool) -> Self {
        let lattice = Lattice::new(cells);
        let mut state = 1u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let material = |c: usize| {
            let [i, j, k] = lattice.cell_position(Cell(c));
            let is_cut = k == cells[2] / 2 && 4 * i > cells[0];
            let is_stiff = is_stiff([i, j, k].map(|x| x as f64));
            let is_pore = draw() < 0.02 && i > 0;
            (!is_cut && !is_pore).then_some(usize::from(is_stiff))
        };
        let materials = (0..lattice.cell_count()).map(material).collect();
        Self { lattice, materials, tangents: vec![[0.0; 576]; lattice.cell_count()] }
    }

    /// R K Rᵀ + M / Δt² with rotations R that grow along x.
    fn bend(&mut self, angle: f64) -> Outcome<()> {
        let mut references = Vec::new();
        for young in YOUNG {
            references.push(Hex8::new([SPACING; 3]).stiffness(&IsotropicMaterial::new(young, 0.4)?.tensor()));
        }
        let inertia = DENSITY * SPACING.powi(3) / 8.0 / STEP.powi(2);
        for (cell, tangent) in self.tangents.iter_mut().enumerate() {
            let Some(material) = self.materials[cell] else { continue };
            let x = self.lattice.cell_position(Cell(cell))[0] as f64 / self.lattice.cells[0] as f64;
            let (bend, twist) = (angle * x, 0.5 * angle * x);
            let (rotation, _) = polar(&[[1.0, 0.0, bend], [0.0, 1.0, -twist], [-bend, twist, 1.0]]);
            *tangent = rotated(&references[material], &rotation);
            (0..24).for_each(|i| tangent[25 * i] += inertia);
        }
        Ok(())
    }
}

fn rotated(matrix: &CellMatrix, r: &Matrix3) -> CellMatrix {
    let mut result = [0.0; 576];
    for (a, b) in (0..64).map(|n| (n / 8, n % 8)) {
        for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
            let mut sum = 0.0;
            for (k, l) in (0..9).map(|n| (n / 3, n % 3)) {
                sum += r[i][k] * matrix[24 * (3 * a + k) + 3 * b + l] * r[j][l];
            }
            result[24 * (3 * a + i) + 3 * b + j] = sum;
        }
    }
    result
}

/// Pᵀ K P of the elements of a coarse mesh of degree 2.
fn coarse_tangents(body: &Body, mesh: &CoarseMesh) -> Vec<CellMatrix> {
    let weight = |octant: [usize; 3], f: usize, c: usize| -> f64 {
        let at = |a: usize| 0.5 * (octant[a] + (f >> a & 1)) as f64;
        (0..3).map(|a| if c >> a & 1 == 1 { at(a) } else { 1.0 - at(a) }).product()
    };
    let tangent = |element: usize| {
        let mut sum = [0.0; 576];
        for (place, cell) in mesh.fine_cells(mesh.elements()[element]) {
            let octant = [place & 1, place >> 1 & 1, place >> 2];
            let p: [[f64; 8]; 8] = std::array::from_fn(|f| std::array::from_fn(|c| weight(octant, f, c)));
            add_congruence(&mut sum, &body.tangents[cell.0], &p);
        }
        sum
    };
    (0..mesh.elements().len()).map(tangent).collect()
}

fn add_congruence(sum: &mut CellMatrix, matrix: &CellMatrix, p: &[[f64; 8]; 8]) {
    let mut half = [0.0; 576];
    for (row, f, c) in (0..24 * 64).map(|n| (n / 64, n / 8 % 8, n % 8)) {
        (0..3).for_each(|r| half[24 * row + 3 * c + r] += matrix[24 * row + 3 * f + r] * p[f][c]);
    }
    for (f, c) in (0..64).map(|n| (n / 8, n % 8)) {
        (0..72).for_each(|i| sum[72 * c + i] += p[f][c] * half[72 * f + i]);
    }
}

/// Weight along −z and a little noise.
fn loads(entries: usize) -> Vec<f64> {
    (0..entries).map(|i| if i % 3 == 2 { -1.0 } else { 0.0 } + 0.3 * (12.9898 * i as f64).sin()).collect()
}

/// Memory of the process now, where the system tells it; what an earlier solver has given back may serve a later one unseen.
fn megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmRSS:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

/// One solver: its update and its solve.
trait Tangent {
    fn update(&mut self, body: &Body, elements: &[CellMatrix], lagged: bool) -> Result<(), SolverError>;
    fn solve(&mut self, tolerance: f64) -> Result<LinearReport, SolverError>;
}

struct Fine {
    tangent: LatticeTangent,
    constraints: Constraints,
}

impl Tangent for Fine {
    fn update(&mut self, body: &Body, _: &[CellMatrix], lagged: bool) -> Result<(), SolverError> {
        self.tangent.update(body, &self.constraints, lagged)
    }

    fn solve(&mut self, tolerance: f64) -> Result<LinearReport, SolverError> {
        self.tangent.solve(&mut loads(3 * self.constraints.node_count()), tolerance)
    }
}

struct Coarse {
    tangent: ElementTangent,
    constraints: Constraints,
}

impl Tangent for Coarse {
    fn update(&mut self, _: &Body, elements: &[CellMatrix], lagged: bool) -> Result<(), SolverError> {
        self.tangent.update(|e| &elements[e], &self.constraints, lagged)
    }

    fn solve(&mut self, tolerance: f64) -> Result<LinearReport, SolverError> {
        self.tangent.solve(&mut loads(3 * self.constraints.node_count()), tolerance)
    }
}

fn run(name: &str, make: impl Fn() -> Outcome<Box<dyn Tangent>>, body: &mut Body, mesh: &CoarseMesh) -> Outcome<()> {
    for lagged in [true, false] {
        let before = megabytes();
        let start = Instant::now();
        let mut tangent = make()?;
        println!(
            "{name}, {}: made in {:.2} s",
            if lagged { "lagged" } else { "renewed" },
            start.elapsed().as_secs_f64()
        );
        for n in 0..UPDATES {
            body.bend(TURN * n as f64)?;
            let elements = coarse_tangents(body, mesh);
            let start = Instant::now();
            tangent.update(body, &elements, lagged)?;
            print!("  update {n}: {:>7.3} s", start.elapsed().as_secs_f64());
            for tolerance in TOLERANCES {
                let start = Instant::now();
                let report = tangent.solve(tolerance)?;
                let (seconds, renewed) = (start.elapsed().as_secs_f64(), if report.refactored { "*" } else { " " });
                print!("   {tolerance:.0e}: {seconds:>7.3} s {:>4} iterations{renewed}", report.iterations);
            }
            println!();
        }
        let memory = before.zip(megabytes()).map(|(before, after)| after - before);
        println!("  memory {} MB", memory.map_or("-".into(), |m| format!("{m:.0}")));
    }
    Ok(())
}

/// Oblique stiff layers, about two and a half cells thick.
fn layers([x, y, z]: [f64; 3]) -> bool {
    (((x + 2.0 * y + z) / 6.0) as usize).is_multiple_of(3)
}

/// Stiff inclusions of a few cells.
fn inclusions(at: [f64; 3]) -> bool {
    let [x, y, z] = at.map(|x| std::f64::consts::TAU * x / 14.0);
    x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos() > 0.4
}

fn main() -> Outcome<()> {
    let sizes: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let cells = if let [x, y, z] = sizes[..] { [x, y, z] } else { [48, 48, 36] };
    for (name, is_stiff) in [("stiff inclusions", inclusions as fn([f64; 3]) -> bool), ("stiff layers", layers)] {
        println!("{name}");
        study(Body::new(cells, is_stiff))?;
    }
    Ok(())
}

fn study(mut body: Body) -> Outcome<()> {
    let lattice = body.lattice;
    let partition = Partition::new(lattice, 2)?;
    let mesh = CoarseMesh::new(&body.materials.iter().map(Option::is_none).collect::<Vec<_>>(), &partition);
    println!(
        "{:?} cells, {} coarse elements, {} vertices",
        lattice.cells,
        mesh.elements().len(),
        mesh.vertices().len()
    );

    let clamped: Vec<bool> = (0..lattice.node_count()).map(|n| lattice.node_position(Node(n))[0] == 0).collect();
    body.bend(0.0)?;
    let fine = |body: &Body| -> Outcome<Box<dyn Tangent>> {
        let tangent = LatticeTangent::new(body, [SPACING; 3])?;
        Ok(Box::new(Fine { tangent, constraints: Constraints::nodes(&clamped) }))
    };
    let first = Body { lattice, materials: body.materials.clone(), tangents: body.tangents.clone() };
    run("fine lattice", || fine(&first), &mut body, &mesh)?;

    let coarse_lattice = partition.coarse();
    let held: Vec<bool> =
        mesh.vertices().iter().map(|v| coarse_lattice.node_position(Node(v.node.0))[0] == 0).collect();
    for (name, limit) in [("coarse mesh, factor", usize::MAX), ("coarse mesh, cycle", 0)] {
        let make = || -> Outcome<Box<dyn Tangent>> {
            let cells = mesh.elements().iter().map(|e| e.cell.0 as u32).collect();
            let place = ElementCells { lattice: coarse_lattice, spacing: [2.0 * SPACING; 3], cells };
            let tangent = ElementTangent::on_lattice(mesh.elimination_order(), mesh.corners(), place, limit)?;
            Ok(Box::new(Coarse { tangent, constraints: Constraints::nodes(&held) }))
        };
        run(name, make, &mut body, &mesh)?;
    }
    Ok(())
}
