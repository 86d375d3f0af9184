use super::*;
use crate::linalg::matrix3::{apply, apply_transposed, determinant};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];
const CORNERS: Corners = [[0.3, 0.1, -0.2], [1.2, 0.0, 0.1], [0.1, 0.9, 0.2], [0.4, 0.3, 1.1]];

fn signed(source: &mut ChaCha8Rng) -> f64 {
    source.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0
}

fn cell_of(dimension: Dimension, source: &mut ChaCha8Rng, rotates: bool) -> (ElasticCell, SimplexMesh, MandelTensor) {
    let keep = |c: [f64; 3]| std::array::from_fn(|r| if r < dimension.axes() { c[r] } else { 0.0 });
    let mesh = SimplexMesh::new(dimension, CORNERS.map(keep).to_vec(), vec![[0, 1, 2, 3]], vec![0]).unwrap();
    // Any symmetric positive definite matrix.
    let n = dimension.strains();
    let root: [[f64; 6]; 6] = std::array::from_fn(|_| std::array::from_fn(|_| signed(source)));
    let entry = |i: usize, j: usize| (0..6).map(|k| root[i][k] * root[j][k]).sum::<f64>() + f64::from(u8::from(i == j));
    let inside = |i: usize, j: usize| if i < n && j < n { entry(i, j) } else { 0.0 };
    let tensor = MandelTensor { dimension, matrix: std::array::from_fn(|i| std::array::from_fn(|j| inside(i, j))) };
    (ElasticCell::new(&mesh, 0, &tensor, rotates), mesh, tensor)
}

/// A rotation by an angle about an axis, about z where there is a plane only.
fn turn(dimension: Dimension, source: &mut ChaCha8Rng, angle: f64) -> Matrix3 {
    let axis = match dimension {
        Dimension::One => return IDENTITY,
        Dimension::Two => [0.0, 0.0, 1.0],
        Dimension::Three => std::array::from_fn(|_| signed(source)),
    };
    let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    let (spin, (sine, cosine)) = (skew(&axis.map(|a| a / length)), angle.sin_cos());
    let square = product(&spin, &spin);
    std::array::from_fn(|i| std::array::from_fn(|j| IDENTITY[i][j] + sine * spin[i][j] + (1.0 - cosine) * square[i][j]))
}

/// Displacements to R F X + 0.3, with an F that inverts the cell on demand, but keeps its distance from mirror images, which have no rotation.
fn displaced(dimension: Dimension, source: &mut ChaCha8Rng, angle: f64, inverts: bool) -> Corners {
    let axes = dimension.axes();
    let rotation = turn(dimension, source, angle);
    let scales = match (inverts, dimension) {
        (false, _) => [1.1, 0.8, 1.2],
        (true, Dimension::One) => [-0.6, 1.0, 1.0],
        (true, Dimension::Two) => [1.2, -0.5, 1.0],
        (true, Dimension::Three) => [1.2, 0.9, -0.4],
    };
    let deformation: Matrix3 = std::array::from_fn(|i| {
        std::array::from_fn(
            |j| if i == j { scales[i] } else { 0.0 } + if i < axes && j < axes { 0.1 * signed(source) } else { 0.0 },
        )
    });
    let mut displacement = [[0.0; 3]; 4];
    for (u, x) in displacement.iter_mut().zip(&CORNERS) {
        let x: [f64; 3] = std::array::from_fn(|r| if r < axes { x[r] } else { 0.0 });
        let to = apply(&rotation, &apply(&deformation, &x));
        (0..axes).for_each(|r| u[r] = to[r] - x[r] + 0.3);
    }
    displacement
}

fn stepped(displacement: &Corners, n: usize, step: f64) -> Corners {
    let mut moved = *displacement;
    moved[n / 3][n % 3] += step;
    moved
}

/// Components that count: those of d + 1 corners along d axes.
fn components(dimension: Dimension) -> impl Iterator<Item = usize> + Clone {
    (0..12).filter(move |n| n / 3 < dimension.corners() && n % 3 < dimension.axes())
}

#[test]
fn derivatives_are_those_of_the_energy_for_turned_and_for_inverted_cells() {
    let (mut source, step) = (ChaCha8Rng::seed_from_u64(1), 1e-5);
    let cases = (0..24).map(|n| (DIMENSIONS[n % 3], n / 3 % 2 == 1, n / 6 % 2 == 1));
    for (dimension, inverts, rotates) in cases {
        let (cell, ..) = cell_of(dimension, &mut source, rotates);
        let u = displaced(dimension, &mut source, 1.75, inverts);
        assert_eq!(determinant(&cell.deformation(&u)) < 0.0, inverts);
        let (energy, gradient) = cell.gradient(&u).unwrap();
        assert_eq!(cell.energy(&u), Some(energy));
        let hessian = cell.hessian(&u, Projection::Exact).unwrap();
        let scale = hessian.iter().fold(0.0f64, |m, h| m.max(h.abs()));
        for n in 0..12 {
            let [ahead, behind] = [step, -step].map(|s| cell.gradient(&stepped(&u, n, s)).unwrap());
            let slope = (ahead.0 - behind.0) / (2.0 * step);
            assert!(
                (slope - gradient[n / 3][n % 3]).abs() < 1e-8 * scale,
                "{dimension} {inverts} {rotates}, {n}: {slope}"
            );
            for m in 0..12 {
                let slope = (ahead.1[m / 3][m % 3] - behind.1[m / 3][m % 3]) / (2.0 * step);
                let found = hessian[12 * m + n];
                assert!(
                    (slope - found).abs() < 1e-7 * scale,
                    "{dimension} {inverts} {rotates}, ({m}, {n}): {slope}, {found}"
                );
                assert_eq!(found, hessian[12 * n + m]);
            }
        }
    }
}

#[test]
fn the_frame_leaves_the_least_displacement_that_any_rotation_leaves() {
    let mut source = ChaCha8Rng::seed_from_u64(2);
    for (dimension, inverts) in DIMENSIONS[1..].iter().flat_map(|d| [(*d, false), (*d, true)]) {
        let (cell, mesh, _) = cell_of(dimension, &mut source, true);
        for _ in 0..10 {
            let u = displaced(dimension, &mut source, 2.4, inverts);
            let corners = dimension.corners();
            let mean = |at: &dyn Fn(usize, usize) -> f64| -> [f64; 3] {
                std::array::from_fn(|r| (0..corners).map(|n| at(n, r)).sum::<f64>() / corners as f64)
            };
            let place = |n: usize, r: usize| mesh.corner(0, n)[r];
            let (rest, moved) = (mean(&place), mean(&|n, r| place(n, r) + u[n][r]));
            let left = |rotation: &Matrix3| -> f64 {
                let of = |n: usize| {
                    let x = std::array::from_fn(|r| place(n, r) + u[n][r] - moved[r]);
                    let y = apply_transposed(rotation, &x);
                    (0..3).map(|r| (y[r] - (place(n, r) - rest[r])).powi(2)).sum::<f64>()
                };
                (0..corners).map(of).sum()
            };
            let frame = cell.frame(&u).unwrap();
            assert!((determinant(&frame.rotation) - 1.0).abs() < 1e-14);
            let least = left(&frame.rotation);
            for n in 0..400 {
                // Small turns away from it and large ones.
                let angle = if n % 2 == 0 { 0.01 } else { std::f64::consts::PI } * signed(&mut source);
                let other = product(&turn(dimension, &mut source, angle), &frame.rotation);
                assert!(left(&other) >= least - 1e-14, "{dimension}: {} below {least}", left(&other));
            }
        }
    }
}

#[test]
fn turns_and_shifts_change_no_energy_and_have_no_force_or_couple() {
    let mut source = ChaCha8Rng::seed_from_u64(3);
    for (dimension, inverts) in DIMENSIONS.iter().flat_map(|d| [(*d, false), (*d, true)]) {
        let (cell, mesh, _) = cell_of(dimension, &mut source, true);
        let u = displaced(dimension, &mut source, 0.7, inverts);
        let place = |u: &Corners, n: usize| -> [f64; 3] { std::array::from_fn(|r| mesh.corner(0, n)[r] + u[n][r]) };
        let rotation = turn(dimension, &mut source, 2.0);
        let mut turned = [[0.0; 3]; 4];
        for n in 0..dimension.corners() {
            let to = apply(&rotation, &place(&u, n));
            (0..dimension.axes()).for_each(|r| turned[n][r] = to[r] - mesh.corner(0, n)[r] - 5.0);
        }
        let (energy, gradient) = cell.gradient(&u).unwrap();
        let (again, forces) = cell.gradient(&turned).unwrap();
        assert!((again - energy).abs() < 1e-12 * energy, "{dimension}: {again} against {energy}");
        let mut couple = [0.0; 3];
        for n in 0..4 {
            let expected = apply(&rotation, &gradient[n]);
            (0..3).for_each(|r| assert!((forces[n][r] - expected[r]).abs() < 1e-12, "{dimension}: {forces:?}"));
            if n < dimension.corners() {
                let part = crate::linalg::matrix3::cross(&place(&u, n), &gradient[n]);
                (0..3).for_each(|r| couple[r] += part[r]);
            }
        }
        for r in 0..3 {
            assert!(couple[r].abs() < 1e-12 && gradient.iter().map(|f| f[r]).sum::<f64>().abs() < 1e-12);
        }
        let rigid: Corners = std::array::from_fn(|n| {
            let to = if n < dimension.corners() { apply(&rotation, &mesh.corner(0, n)) } else { [0.0; 3] };
            std::array::from_fn(|r| if n < dimension.corners() { to[r] - mesh.corner(0, n)[r] } else { 0.0 })
        });
        let (energy, forces) = cell.gradient(&rigid).unwrap();
        assert!(energy < 1e-28 && forces.iter().flatten().all(|f| f.abs() < 1e-13), "{dimension}: {energy:e}");
    }
}

#[test]
fn the_projected_hessian_is_semidefinite_and_exact_where_there_is_no_stress() {
    let mut source = ChaCha8Rng::seed_from_u64(4);
    for dimension in DIMENSIONS {
        let (cell, ..) = cell_of(dimension, &mut source, true);
        let rest = [[0.0; 3]; 4];
        let [exact, projected] =
            [Projection::Exact, Projection::PositiveSemidefinite].map(|p| cell.hessian(&rest, p).unwrap());
        (0..144).for_each(|n| assert!((exact[n] - projected[n]).abs() < 1e-13, "{dimension}"));
        let u = displaced(dimension, &mut source, 2.0, true);
        let projected = cell.hessian(&u, Projection::PositiveSemidefinite).unwrap();
        let scale = projected.iter().fold(0.0f64, |m, h| m.max(h.abs()));
        for _ in 0..2000 {
            let v: [f64; 12] = std::array::from_fn(|_| signed(&mut source));
            let square: f64 = (0..144).map(|n| v[n / 12] * projected[n] * v[n % 12]).sum();
            assert!(square > -1e-13 * scale, "{dimension}: {square}");
        }
    }
}

#[test]
fn a_linear_cell_has_the_stiffness_of_the_strain_displacement_matrix() {
    let mut source = ChaCha8Rng::seed_from_u64(5);
    for dimension in DIMENSIONS {
        let (cell, mesh, tensor) = cell_of(dimension, &mut source, false);
        let (g, voigt, measure) = (mesh.gradients(0), tensor.voigt(), mesh.measure(0));
        // Rows of B, engineering shear: which two components of a gradient each strain adds.
        let pairs: &[(usize, usize)] = match dimension {
            Dimension::One => &[(0, 0)],
            Dimension::Two => &[(0, 0), (1, 1), (0, 1)],
            Dimension::Three => &[(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)],
        };
        let b = |row: usize, n: usize| {
            let ((i, j), (corner, r)) = (pairs[row], (n / 3, n % 3));
            let part = |component: usize, slope: usize| if r == component { g[corner][slope] } else { 0.0 };
            if i == j { part(i, i) } else { part(i, j) + part(j, i) }
        };
        let found = cell.hessian(&[[0.1, 0.4, -0.3]; 4], Projection::Exact).unwrap();
        for (n, m) in (0..144).map(|e| (e / 12, e % 12)) {
            let rows = 0..pairs.len();
            let entry: f64 = rows
                .clone()
                .flat_map(|i| rows.clone().map(move |j| (i, j)))
                .map(|(i, j)| b(i, n) * voigt[i][j] * b(j, m))
                .sum();
            assert!((found[12 * n + m] - measure * entry).abs() < 1e-13, "{dimension} ({n}, {m})");
            assert!(components(dimension).any(|c| c == n) || found[12 * n + m] == 0.0);
        }
    }
}

#[test]
fn flat_and_mirrored_cells_have_finite_energies_and_forces_and_broken_ones_none() {
    let mut source = ChaCha8Rng::seed_from_u64(6);
    for dimension in DIMENSIONS {
        let (cell, mesh, _) = cell_of(dimension, &mut source, true);
        let scaled = |factors: [f64; 3]| -> Corners {
            std::array::from_fn(|n| {
                let at = if n < dimension.corners() { mesh.corner(0, n) } else { [0.0; 3] };
                std::array::from_fn(|r| (factors[r] - 1.0) * at[r])
            })
        };
        // Collapsed to a point, to a line or a plane, and mirrored.
        for factors in [[0.0; 3], [0.0, 1.0, 1.0], [-1.0, 1.0, 1.0]] {
            let (energy, forces) = cell.gradient(&scaled(factors)).unwrap();
            assert!(energy > 0.0 && energy.is_finite() && forces.iter().flatten().all(|f| f.is_finite()));
            let hessian = cell.hessian(&scaled(factors), Projection::PositiveSemidefinite).unwrap();
            assert!(hessian.iter().all(|h| h.is_finite()));
        }
        let mut broken = scaled([1.0; 3]);
        broken[1][0] = f64::NAN;
        assert_eq!(cell.energy(&broken), None);
    }
}
