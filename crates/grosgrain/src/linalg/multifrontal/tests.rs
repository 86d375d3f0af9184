//! The elimination against dense algebra, on bodies of springs and random elements.

use std::sync::Arc;

use proptest::prelude::*;

use super::*;

/// Nodes of the cells of a box of nodes.
fn elements(nodes: [usize; 3]) -> Vec<Vec<u32>> {
    let mut list = Vec::new();
    for k in 0..nodes[2] - 1 {
        for j in 0..nodes[1] - 1 {
            for i in 0..nodes[0] - 1 {
                let node = |a: usize| (i + (a & 1) + nodes[0] * (j + (a >> 1 & 1) + nodes[1] * (k + (a >> 2)))) as u32;
                list.push((0..8).map(node).collect());
            }
        }
    }
    list
}

/// B Bᵀ with random B of the given number of columns, made blind to constant fields: a semidefinite element that does not feel translations.
fn element(size: usize, block: usize, columns: usize, seed: &mut u64) -> Vec<f64> {
    let mut random = || {
        *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*seed >> 33) as f64 / (1u64 << 31) as f64 - 0.5
    };
    let mut b = vec![0.0; size * columns];
    b.iter_mut().for_each(|x| *x = random());
    for c in 0..columns {
        for r in 0..block {
            let mean = (r..size).step_by(block).map(|i| b[i * columns + c]).sum::<f64>() / (size / block) as f64;
            (r..size).step_by(block).for_each(|i| b[i * columns + c] -= mean);
        }
    }
    let entry = |i: usize, j: usize| (0..columns).map(|c| b[i * columns + c] * b[j * columns + c]).sum();
    (0..size * size).map(|n| entry(n / size, n % size)).collect()
}

fn check(nodes: [usize; 3], block: usize, present: &[bool], low: [usize; 3], high: [usize; 3], mut seed: u64) {
    let (count, list) = (nodes.iter().product::<usize>(), elements(nodes));
    let order = block * count;
    let matrices: Vec<Vec<f64>> = list.iter().map(|l| element(block * l.len(), block, 30, &mut seed)).collect();
    let mut dense = vec![vec![0.0; order]; order];
    for (e, list) in list.iter().enumerate().filter(|(e, _)| present[*e]) {
        let size = block * list.len();
        for (p, q) in (0..size * size).map(|n| (n / size, n % size)) {
            let place = |x: usize| block * list[x / block] as usize + x % block;
            dense[place(p)][place(q)] += matrices[e][size * p + q];
        }
    }
    // Loads K v, so that they are in equilibrium.
    let v: Vec<[f64; 2]> = (0..order).map(|i| [(i as f64).sin(), (0.3 * i as f64).cos()]).collect();
    let loads: Vec<[f64; 2]> =
        dense.iter().map(|row| std::array::from_fn(|k| row.iter().zip(&v).map(|(a, x)| a * x[k]).sum())).collect();
    let groups = box_tree_around(nodes, low, high);
    let core = groups.iter().rev().scan(0, |sum, g| {
        *sum += g.len();
        Some(*sum)
    });
    let wanted: usize = (0..3).map(|a| high[a] - low[a]).product();
    let kept = core.take_while(|sum| *sum <= wanted).count();
    let plan = Arc::new(FrontalPlan::new(count, block, &list, &groups).unwrap());
    let mut solver = FrontalSolver::new(plan.clone(), 2, kept);
    for _ in 0..2 {
        let found = solver.eliminate(
            &|e| present[e].then(|| (1.0, matrices[e].as_slice())),
            &mut |node, out| (0..2 * block).for_each(|i| out[i] = loads[block * node + i / 2][i % 2]),
            &[],
        );
        let mut y = vec![[0.0; 8]; order];
        y.iter_mut().zip(solver.forward().chunks_exact(2)).for_each(|(y, f)| y[..2].copy_from_slice(f));
        let energy: f64 = solver.forward().chunks_exact(2).map(|f| f[0] * f[1]).sum();
        let expected: f64 = v.iter().zip(&loads).map(|(v, f)| v[0] * f[1]).sum();
        assert!((energy - expected).abs() < 1e-9 * expected.abs().max(1.0), "{energy} {expected}");
        solver.substitute_back(&mut y);
        // Inside one part the solution is v up to a translation: differences agree.
        let touched: Vec<bool> =
            (0..count).map(|n| (0..list.len()).any(|e| present[e] && list[e].contains(&(n as u32)))).collect();
        let inactive = touched.iter().filter(|t| !**t).count();
        if present.iter().all(|p| *p) {
            assert_eq!(found.skipped, block);
        } else {
            assert!(found.skipped >= block * inactive);
        }
        for (e, list) in list.iter().enumerate().filter(|(e, _)| present[*e]) {
            let at = |n: u32| {
                [0, 1, 2].map(|a| {
                    [n as usize % nodes[0], n as usize / nodes[0] % nodes[1], n as usize / nodes[0] / nodes[1]][a]
                })
            };
            if !list.iter().all(|&n| (0..3).all(|a| (low[a]..high[a]).contains(&at(n)[a]))) {
                continue;
            }
            for (k, r) in [(0, 0), (1, block - 1)] {
                let u = |n: u32| y[plan.place(n as usize) + r][k];
                let exact = |n: u32| v[block * n as usize + r][k];
                for &n in &list[1..] {
                    let error = (u(n) - u(list[0])) - (exact(n) - exact(list[0]));
                    assert!(error.abs() < 1e-8, "element {e}: {error}");
                }
            }
        }
    }
}

#[test]
fn the_core_of_a_box_is_displaced_as_the_dense_system_says() {
    check([5, 5, 5], 3, &[true; 64], [1, 1, 1], [4, 4, 4], 7);
    check([7, 4, 3], 3, &[true; 36], [4, 0, 0], [7, 4, 3], 8);
    check([4, 4, 4], 1, &[true; 27], [1, 1, 1], [3, 3, 3], 9);
    check([3, 3, 3], 9, &[true; 8], [0, 0, 0], [2, 2, 2], 10);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn absent_elements_and_floating_parts_do_no_harm(present in proptest::collection::vec(proptest::bool::weighted(0.7), 27), seed in 0u64..1000) {
        check([4, 4, 4], 3, &present, [1, 1, 1], [3, 3, 3], seed);
    }
}

#[test]
fn bad_groups_and_elements_are_refused() {
    let list = elements([2, 2, 2]);
    assert!(matches!(FrontalPlan::new(8, 3, &list, &[vec![0, 1, 2]]), Err(FrontalPlanError::Group { node: 3 })));
    assert!(matches!(FrontalPlan::new(2, 3, &[], &[vec![0, 1, 1]]), Err(FrontalPlanError::Group { node: 1 })));
    let groups = box_tree([2, 2, 1]);
    assert!(matches!(FrontalPlan::new(4, 3, &list, &groups), Err(FrontalPlanError::Element { node: 4, .. })));
}

#[test]
fn a_dense_front_leaves_the_schur_complement_of_matrix_and_loads() {
    let mut front = DenseFront::new();
    for (pivots, boundary, rank) in [(5, 4, 30), (27, 33, 90), (11, 0, 40), (9, 7, 5), (0, 3, 8)] {
        let (n, extra) = (pivots + boundary, 3);
        let mut seed = 3 + pivots as u64;
        let k = element(n, 1, rank, &mut seed);
        let entry = |i: usize, j: usize| k[n * i + j] + if rank > n && i == j { 0.1 } else { 0.0 };
        // Loads in the range of the matrix.
        let load = |e: usize, i: usize| (0..n).map(|j| entry(i, j) * ((e + 2) as f64 * j as f64).cos()).sum::<f64>();
        front.reset(pivots, boundary, extra);
        for c in 0..pivots {
            let (own, below, loads) = front.pivot_column(c);
            own.iter_mut().enumerate().for_each(|(i, x)| *x = entry(c + i, c));
            below.iter_mut().enumerate().for_each(|(i, x)| *x = entry(pivots + i, c));
            loads.iter_mut().enumerate().for_each(|(e, x)| *x = load(e, c));
        }
        for c in 0..boundary {
            let (below, loads) = front.boundary_column(c);
            below.iter_mut().enumerate().for_each(|(i, x)| *x = entry(pivots + c + i, pivots + c));
            loads.iter_mut().enumerate().for_each(|(e, x)| *x = load(e, pivots + c));
        }
        let skipped = front.eliminate(1e-10);
        assert_eq!(skipped, pivots.saturating_sub(rank));
        // On vectors v = K⁺ f the eliminated system holds: (C − B A⁺ Bᵀ) v_B = g − B A⁺ f.
        let mut complement = vec![vec![0.0; boundary]; boundary];
        let mut loads = vec![vec![0.0; boundary]; extra];
        for c in 0..boundary {
            let (below, extra_rows) = front.boundary_column(c);
            for (i, x) in below.iter().enumerate() {
                complement[c + i][c] = *x;
                complement[c][c + i] = *x;
            }
            extra_rows.iter().enumerate().for_each(|(e, x)| loads[e][c] = *x);
        }
        for (e, c) in (0..extra * boundary).map(|m| (m / boundary.max(1), m % boundary.max(1))) {
            let sum: f64 = (0..boundary).map(|j| complement[c][j] * ((e + 2) as f64 * (pivots + j) as f64).cos()).sum();
            assert!((sum - loads[e][c]).abs() < 1e-9, "{pivots} {boundary}: {sum} {}", loads[e][c]);
        }
    }
}
