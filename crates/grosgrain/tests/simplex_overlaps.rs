//! Common parts of two meshes fill both of them, whatever their shape, place and size.

use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, OverlapError, Overlaps, SimplexLattice, SimplexMesh};
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];
const UNIT: BoundingBox = BoundingBox { lower: [0.0; 3], upper: [1.0; 3] };

fn lattice(dimension: Dimension, boxes: usize, cut: BoxCut) -> SimplexMesh {
    SimplexLattice { dimension, boxes: [boxes; 3], around: UNIT, cut }.mesh().unwrap()
}

fn with_nodes(mesh: &SimplexMesh, place: impl FnMut([f64; 3]) -> [f64; 3]) -> SimplexMesh {
    let nodes = mesh.nodes().iter().copied().map(place).collect();
    let cell = |c: usize| std::array::from_fn(|n| mesh.cell(c).get(n).copied().unwrap_or(0));
    let cells = (0..mesh.cell_count()).map(cell).collect();
    SimplexMesh::new(mesh.dimension(), nodes, cells, mesh.tags().to_vec()).unwrap()
}

/// A lattice of the unit box whose nodes are moved at random, but stay in the sides in which they lie.
fn jittered(dimension: Dimension, boxes: usize, cut: BoxCut, seed: u64) -> SimplexMesh {
    let mut source = ChaCha8Rng::seed_from_u64(seed);
    let step = 0.2 / boxes as f64;
    with_nodes(&lattice(dimension, boxes, cut), |at| {
        at.map(|x| {
            let random = source.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0;
            if x == 0.0 || x == 1.0 { x } else { x + step * random }
        })
    })
}

/// Largest relative misfit of Σ_q |T_p ∩ T_q| = |T_p| and of the same sum over p.
fn misfits(overlaps: &Overlaps) -> (f64, f64) {
    let filled = (0..overlaps.coarse_count()).map(|q| (overlaps.filled(q) - 1.0).abs()).fold(0.0, f64::max);
    (overlaps.worst_covered().1.abs(), filled)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn common_parts_of_any_two_meshes_of_a_box_fill_both(
        seed in any::<u64>(), which in 0..3usize, fine in 1..7usize, coarse in 1..4usize, alike in any::<bool>(),
    ) {
        let (dimension, cut) = (DIMENSIONS[which], if alike { BoxCut::Alike } else { BoxCut::Alternating });
        let fine = jittered(dimension, fine, BoxCut::Alike, seed);
        let coarse = jittered(dimension, coarse, cut, seed ^ 1);
        let overlaps = Overlaps::new(&fine, &coarse).unwrap();
        let (covered, filled) = misfits(&overlaps);
        prop_assert!(covered < 1e-12 && filled < 1e-12, "{covered:.1e} {filled:.1e}");
        for q in 0..coarse.cell_count() {
            let entries = overlaps.of_coarse(q);
            prop_assert!(entries.windows(2).all(|pair| pair[0].0 < pair[1].0));
            for (p, measure) in entries {
                let most = fine.measure(*p as usize).min(coarse.measure(q)) * (1.0 + 1e-13);
                prop_assert!(*measure > 0.0 && *measure <= most, "{p} {q}: {measure}");
            }
        }
        let [all_fine, all_coarse, common] = overlaps.totals();
        prop_assert!((all_fine - common).abs() < 1e-13 && (all_coarse - common).abs() < 1e-13);

        let reverse = Overlaps::new(&coarse, &fine).unwrap();
        let other = |p: u32, q: usize| {
            reverse.of_coarse(p as usize).iter().find(|(coarse, _)| *coarse as usize == q).map_or(0.0, |(_, m)| *m)
        };
        for q in 0..coarse.cell_count() {
            for (p, measure) in overlaps.of_coarse(q) {
                prop_assert!((measure - other(*p, q)).abs() < 1e-15, "{p} {q}: {measure} {}", other(*p, q));
            }
        }
    }

    /// Sheared, stretched to needles, turned and moved away. The sides of the box are no longer those of the lattice, and rounding tears fine from coarse ones; inside nothing is lost.
    #[test]
    fn needles_far_from_the_origin_lose_nothing(seed in any::<u64>(), which in 1..3usize, stretch in -3..4i32, far in 0..4i32) {
        let dimension = DIMENSIONS[which];
        let (stretch, far) = (10f64.powi(stretch), if far == 0 { 0.0 } else { 10f64.powi(far) / 3.0 });
        let place = |x: [f64; 3]| {
            let y = [x[0] * stretch, x[1] + 0.3 * x[0], x[2] - 0.2 * x[1]];
            let (c, s) = (0.8, 0.6);
            let turned = [c * y[0] - s * y[1] + far, s * y[0] + c * y[1] - far, y[2] + far];
            std::array::from_fn(|r| if r < dimension.axes() { turned[r] } else { 0.0 })
        };
        let fine = with_nodes(&jittered(dimension, 5, BoxCut::Alike, seed), place);
        let coarse = with_nodes(&jittered(dimension, 2, BoxCut::Alternating, seed ^ 1), place);
        let overlaps = Overlaps::new(&fine, &coarse).unwrap();
        let inside = |p: usize| {
            (0..dimension.corners()).all(|n| {
                let y = fine.corner(p, n);
                let (c, s) = (0.8, 0.6);
                let (a, b) = (c * (y[0] - far) + s * (y[1] + far), -s * (y[0] - far) + c * (y[1] + far));
                let x = a / stretch;
                let z = [x, b - 0.3 * x, y[2] - far + 0.2 * (b - 0.3 * x)];
                z[..dimension.axes()].iter().all(|z| (0.05..0.95).contains(z))
            })
        };
        for p in (0..fine.cell_count()).filter(|p| inside(*p)) {
            let misfit = overlaps.covered(p) - 1.0;
            prop_assert!(misfit.abs() < 1e-12, "{p}: {misfit:.1e}");
        }
        // At the sides, coordinates rounded at `far` decide.
        let (covered, filled) = misfits(&overlaps);
        let torn = 1e-12 + 1e-14 * far * (1.0 + stretch).max(1.0 + 1.0 / stretch);
        prop_assert!(covered < torn && filled < torn, "{covered:.1e} {filled:.1e} {torn:.1e}");
    }
}

/// One simplex, cut at random points of random cells: after many cuts most cells are needles and slivers.
fn shattered(dimension: Dimension, cuts: usize, seed: u64) -> SimplexMesh {
    let mut source = ChaCha8Rng::seed_from_u64(seed);
    let mut random = || source.next_u64() as f64 / u64::MAX as f64;
    let nodes = [[0.1, 0.2, 0.3], [1.3, 0.1, 0.2], [0.3, 1.1, 0.1], [0.2, 0.4, 1.7]];
    let flat = |x: [f64; 3]| std::array::from_fn(|r| if r < dimension.axes() { x[r] } else { 0.0 });
    let corners = dimension.corners();
    let mut nodes: Vec<[f64; 3]> = nodes[..corners].iter().map(|x| flat(*x)).collect();
    let mut cells = vec![[0, 1, 2, 3]];
    let make = |nodes: &Vec<[f64; 3]>, cells: &Vec<[u32; 4]>| {
        SimplexMesh::new(dimension, nodes.clone(), cells.clone(), vec![0; cells.len()])
    };
    for _ in 0..cuts {
        let cell = (random() * cells.len() as f64) as usize % cells.len();
        let weights: Vec<f64> = (0..corners).map(|_| random().powi(3) + 1e-3).collect();
        let (sum, old) = (weights.iter().sum::<f64>(), cells[cell]);
        let mean = |r: usize| (0..corners).map(|n| weights[n] * nodes[old[n] as usize][r]).sum::<f64>() / sum;
        let centre = std::array::from_fn(mean);
        let (mut more_nodes, mut more_cells) = (nodes.clone(), cells.clone());
        more_nodes.push(centre);
        more_cells.swap_remove(cell);
        for n in 0..corners {
            let mut part = old;
            part[n] = nodes.len() as u32;
            more_cells.push(part);
        }
        // Cells that count as flat are no mesh.
        if make(&more_nodes, &more_cells).is_ok() {
            (nodes, cells) = (more_nodes, more_cells);
        }
    }
    make(&nodes, &cells).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn needles_and_slivers_fill_one_another(seed in any::<u64>(), which in 0..3usize, fine in 0..200usize, coarse in 0..60usize) {
        let (fine, coarse) = (shattered(DIMENSIONS[which], fine, seed), shattered(DIMENSIONS[which], coarse, seed ^ 1));
        let overlaps = Overlaps::new(&fine, &coarse).unwrap();
        for p in 0..fine.cell_count() {
            let misfit = overlaps.covered(p) - 1.0;
            prop_assert!(misfit.abs() < 1e-12, "fine {p}: {misfit:.1e}");
        }
        let [whole, _, common] = overlaps.totals();
        prop_assert!((common / whole - 1.0).abs() < 1e-13, "{common} {whole}");
        let all = 0..coarse.cell_count();
        prop_assert!(all.flat_map(|q| overlaps.of_coarse(q)).all(|(_, m)| m.is_finite() && *m > 0.0));
    }
}

#[test]
fn a_mesh_overlaps_itself_cell_by_cell_also_far_from_the_origin() {
    for dimension in DIMENSIONS {
        for far in [0.0, 1e3 / 3.0, 1e6 / 7.0] {
            let moved = |x: [f64; 3]| std::array::from_fn(|r| if r < dimension.axes() { x[r] + far } else { 0.0 });
            let mesh = with_nodes(&jittered(dimension, 3, BoxCut::Alternating, 7), moved);
            let overlaps = Overlaps::new(&mesh, &mesh).unwrap();
            for q in 0..mesh.cell_count() {
                assert_eq!(overlaps.of_coarse(q), [(q as u32, mesh.measure(q))], "{dimension}, {far}");
            }
        }
    }
}

/// Halving all boxes of a lattice that is cut alike halves all edges of its cells.
#[test]
fn refined_cells_lie_in_one_coarse_cell_each() {
    for dimension in DIMENSIONS {
        for scale in [1.0, 1.0 / 3.0, 1e-4 / 7.0] {
            let scaled = |x: [f64; 3]| x.map(|x| x * scale);
            let fine = with_nodes(&lattice(dimension, 12, BoxCut::Alike), scaled);
            let coarse = with_nodes(&lattice(dimension, 3, BoxCut::Alike), scaled);
            let overlaps = Overlaps::new(&fine, &coarse).unwrap();
            let mut seen = vec![false; fine.cell_count()];
            for q in 0..coarse.cell_count() {
                assert_eq!(overlaps.of_coarse(q).len(), 4usize.pow(dimension.axes() as u32), "{dimension}, {scale}");
                for (p, measure) in overlaps.of_coarse(q) {
                    assert_eq!(*measure, fine.measure(*p as usize), "{dimension}, {scale}");
                    assert!(!std::mem::replace(&mut seen[*p as usize], true));
                }
            }
            assert!(seen.iter().all(|s| *s));
        }
    }
}

#[test]
fn parts_outside_are_not_counted() {
    for dimension in DIMENSIONS {
        let fine = jittered(dimension, 4, BoxCut::Alike, 3);
        let half = |x: [f64; 3]| [0.5 * x[0], x[1], x[2]];
        let coarse = with_nodes(&jittered(dimension, 2, BoxCut::Alternating, 4), half);
        let overlaps = Overlaps::new(&fine, &coarse).unwrap();
        let [all, half, common] = overlaps.totals();
        assert!((all - 1.0).abs() < 1e-13 && (half - 0.5).abs() < 1e-13 && (common - 0.5).abs() < 1e-13);
        assert_eq!(overlaps.worst_covered().1, -1.0);
        let reverse = Overlaps::new(&coarse, &fine).unwrap();
        assert!(reverse.empty_coarse().count() > 0);
        assert!(reverse.empty_coarse().all(|q| reverse.filled(q) == 0.0));
        let beyond = |q: &usize| (0..dimension.corners()).all(|n| fine.corner(*q, n)[0] >= 0.5);
        let expected: Vec<usize> = (0..fine.cell_count()).filter(beyond).collect();
        assert_eq!(reverse.empty_coarse().collect::<Vec<_>>(), expected, "{dimension}");
    }
}

#[test]
fn meshes_that_have_nothing_in_common_are_refused() {
    let mesh = lattice(Dimension::Three, 2, BoxCut::Alike);
    // A face in common is nothing.
    let apart = with_nodes(&mesh, |x| [x[0] + 1.0, x[1], x[2]]);
    let error = Overlaps::new(&mesh, &apart).unwrap_err();
    assert!(matches!(error, OverlapError::Apart { fine: UNIT, .. }), "{error}");
    let message = error.to_string();
    assert!(message.contains("between [0.0, 0.0, 0.0] and [1.0, 1.0, 1.0], the coarse one between [1.0"), "{message}");
    let flat = lattice(Dimension::Two, 2, BoxCut::Alike);
    let error = Overlaps::new(&mesh, &flat).unwrap_err().to_string();
    assert_eq!(
        error,
        "the fine mesh consists of tetrahedra, the coarse one of triangles; take two meshes of the same kind"
    );
}

#[test]
fn overlaps_are_alike_for_any_number_of_threads() {
    let fine = jittered(Dimension::Three, 7, BoxCut::Alike, 5);
    let coarse = jittered(Dimension::Three, 2, BoxCut::Alternating, 6);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Overlaps::new(&fine, &coarse).unwrap())
    };
    let one = with(1);
    assert!(with(2) == one && with(5) == one);
}
