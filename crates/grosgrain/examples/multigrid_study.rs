//! Multigrid-preconditioned conjugate gradients on bodies of growing difficulty: prints a table.
//!
//! `cargo run --release --example multigrid_study -- 32 64`

use std::time::Instant;

use grosgrain::assembly::{CellStiffness, Constraints, MatrixFree};
use grosgrain::element::{CellMatrix, Hex8};
use grosgrain::linalg::{ConjugateGradientParameters, ConjugateGradients, LinearOperator};
use grosgrain::material::IsotropicMaterial;
use grosgrain::mesh::{Lattice, Node};
use grosgrain::solver::{Cycle, Multigrid, MultigridParameters};

struct Body {
    lattice: Lattice,
    matrix: CellMatrix,
    factors: Vec<f64>,
}

impl CellStiffness for Body {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn stiffness(&self, cell: usize) -> Option<(f64, &CellMatrix)> {
        (self.factors[cell] > 0.0).then_some((self.factors[cell], &self.matrix))
    }
}

struct Case {
    name: &'static str,
    poisson: f64,
    /// Factor of the cell at (i, j, k); the last argument is a number in [0, 1) drawn for it.
    factor: fn([usize; 3], f64) -> f64,
}

fn layers(at: [usize; 3], soft: f64) -> f64 {
    if ((at[0] + at[2]) / 4).is_multiple_of(2) { 1.0 } else { soft }
}

const CASES: [Case; 9] = [
    Case { name: "homogeneous, nu 0.3", poisson: 0.3, factor: |_, _| 1.0 },
    Case { name: "homogeneous, nu 0.49", poisson: 0.49, factor: |_, _| 1.0 },
    Case { name: "random 1e3, nu 0.3", poisson: 0.3, factor: |_, w| if w < 0.5 { 1.0 } else { 1e-3 } },
    Case { name: "random 1e6, nu 0.3", poisson: 0.3, factor: |_, w| if w < 0.5 { 1.0 } else { 1e-6 } },
    Case { name: "random 1e6, nu 0.49", poisson: 0.49, factor: |_, w| if w < 0.5 { 1.0 } else { 1e-6 } },
    Case { name: "oblique layers 1e3, nu 0.3", poisson: 0.3, factor: |at, _| layers(at, 1e-3) },
    Case { name: "oblique layers 1e6, nu 0.3", poisson: 0.3, factor: |at, _| layers(at, 1e-6) },
    Case { name: "voids 30 %, nu 0.3", poisson: 0.3, factor: |_, w| if w < 0.7 { 1.0 } else { 0.0 } },
    Case {
        name: "flat layers 1e3, nu 0.3",
        poisson: 0.3,
        factor: |at, _| if (at[2] / 3).is_multiple_of(2) { 1.0 } else { 1e-3 },
    },
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut sizes: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    if sizes.is_empty() {
        sizes = vec![16, 32];
    }
    for n in sizes {
        println!("{n} x {n} x {n} cells, {:.2} million unknowns", 3e-6 * ((n + 1) as f64).powi(3));
        println!(
            "{:28} {:>5} {:>10} {:>8} {:>8} {:>9} {:>9} {:>8}",
            "case", "cycle", "iterations", "set up s", "solve s", "residual", "Mcells/s", "peak MB"
        );
        for case in &CASES {
            for cycle in [Cycle::V, Cycle::W] {
                run(case, n, cycle)?;
            }
        }
    }
    Ok(())
}

/// A body clamped at x = 0 under its own weight along z.
fn run(case: &Case, n: usize, cycle: Cycle) -> Result<(), Box<dyn std::error::Error>> {
    let body = body(case, n)?;
    let lattice = body.lattice;
    let clamped: Vec<bool> = (0..lattice.node_count()).map(|i| lattice.node_position(Node(i))[0] == 0).collect();
    let start = Instant::now();
    let operator = MatrixFree::new(&body, &Constraints::nodes(&clamped));
    let mut multigrid = Multigrid::new(&operator, &body, MultigridParameters { cycle, ..Default::default() })?;
    let set_up = start.elapsed().as_secs_f64();
    let load: Vec<f64> = (0..3 * lattice.node_count())
        .map(|i| if i % 3 == 2 && operator.free()[i / 3] == 7 { -1.0 } else { 0.0 })
        .collect();
    let mut x = vec![0.0; load.len()];
    let options = ConjugateGradientParameters { tolerance: 1e-8, max_iterations: 1000 };
    let start = Instant::now();
    let result = ConjugateGradients::new(&operator, options).solve(&load, &mut x, &mut multigrid, &|_, _| true);
    let solve = start.elapsed().as_secs_f64();
    print!("{:28} {:>5} ", case.name, format!("{cycle:?}"));
    match result {
        Ok(info) => println!(
            "{:>10} {set_up:>8.2} {solve:>8.2} {:>9.1e} {:>9.1} {:>8}",
            info.iterations,
            info.relative_residual,
            1e-6 * cells_per_second(&operator, &x),
            peak_megabytes().map_or("-".into(), |m| m.to_string())
        ),
        Err(error) => println!("{:>10} {set_up:>8.2} {solve:>8.2} {error}", "-"),
    }
    Ok(())
}

/// Speed of y = K x, voids counted.
fn cells_per_second(operator: &MatrixFree, x: &[f64]) -> f64 {
    let mut y = vec![0.0; x.len()];
    let start = Instant::now();
    (0..3).for_each(|_| operator.apply(x, &mut y));
    3.0 * operator.lattice().cell_count() as f64 / start.elapsed().as_secs_f64()
}

/// Largest memory of the process so far, where the system tells it.
fn peak_megabytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? / 1024)
}

/// Voids keep only what hangs together with the clamped face.
fn body(case: &Case, n: usize) -> Result<Body, Box<dyn std::error::Error>> {
    let lattice = Lattice::new([n; 3]);
    let mut state = 1u64;
    let factors = (0..lattice.cell_count()).map(|c| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let at = lattice.cell_position(grosgrain::mesh::Cell(c));
        (case.factor)(at, (state >> 11) as f64 / (1u64 << 53) as f64)
    });
    let factors = factors.collect();
    let tensor = IsotropicMaterial::new(1.0, case.poisson)?.tensor();
    let mut body = Body { lattice, matrix: Hex8::new([1.0; 3]).stiffness(&tensor), factors };
    keep_what_is_held(&mut body);
    Ok(body)
}

/// Makes void what shares no chain of faces with the face x = 0.
fn keep_what_is_held(body: &mut Body) {
    let n = body.lattice.cells[0];
    let mut held = vec![false; body.factors.len()];
    let mut stack: Vec<[usize; 3]> = (0..n * n).map(|c| [0, c % n, c / n]).collect();
    while let Some(at) = stack.pop() {
        let cell = body.lattice.cell(at).0;
        if held[cell] || body.factors[cell] == 0.0 {
            continue;
        }
        held[cell] = true;
        for axis in 0..3 {
            let mut next = at;
            next[axis] += 1;
            if next[axis] < n {
                stack.push(next);
            }
            if at[axis] > 0 {
                next[axis] -= 2;
                stack.push(next);
            }
        }
    }
    held.iter().zip(&mut body.factors).for_each(|(held, factor)| *factor *= f64::from(u8::from(*held)));
}
