//! A fine mesh that moves with a coarse one, and what acts on it carried over to the coarse nodes.

mod bodies;
mod simplex_motion;

use std::path::Path;

use bodies::Uniform;
use grosgrain::contact::Ground;
use grosgrain::dynamics::{
    Body, Conditions, EmbeddedSpring, Hold, Moment, Motion, NodeSpring, Ramp, Schedule, SimplexBody, SimplexBodyError,
    TimedLoad, restrict_conditions,
};
use grosgrain::homogenization::SimplexEmbedding;
use grosgrain::io::mesh::read_mesh;
use grosgrain::mesh::{Axis, Node, PlaneAt, Selector};
use grosgrain::simplex::{
    BoundingBox, BoxCut, Dimension, Locator, SimplexLattice, SimplexLaw, SimplexMesh, select_nodes,
};
use simplex_motion::*;

const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];
const SIZE: [f64; 3] = [0.04, 0.03, 0.02];

/// A fine mesh, and a coarse one that covers the given share of it, so that the rest is outside.
fn meshes(dimension: Dimension, covered: f64) -> (SimplexMesh, SimplexMesh) {
    let around = |share: f64| BoundingBox { lower: [0.0; 3], upper: SIZE.map(|x| share * x) };
    let mesh =
        |boxes, share| SimplexLattice { dimension, boxes, around: around(share), cut: BoxCut::Alternating }.mesh();
    (mesh([8, 6, 4], 1.0).unwrap(), mesh([3, 2, 2], covered).unwrap())
}

fn embedded(fine: &SimplexMesh, coarse: &SimplexMesh) -> SimplexEmbedding {
    SimplexEmbedding::new(fine, &Locator::new(coarse))
}

fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut random = Uniform(seed);
    (0..count).map(|_| random.signed()).collect()
}

/// Sum of the forces and of their moments about the origin.
fn resultants(mesh: &SimplexMesh, forces: &[f64]) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for (x, f) in mesh.nodes().iter().zip(forces.chunks_exact(3)) {
        for r in 0..3 {
            sum[r] += f[r];
            sum[3 + r] += x[(r + 1) % 3] * f[(r + 2) % 3] - x[(r + 2) % 3] * f[(r + 1) % 3];
        }
    }
    sum
}

#[test]
fn linear_fields_are_prolonged_exactly_outside_too() {
    for dimension in DIMENSIONS {
        for covered in [1.0, 0.7] {
            let (fine, coarse) = meshes(dimension, covered);
            let embedding = embedded(&fine, &coarse);
            let a = noise(12, 3);
            let field = |x: &[f64; 3]| -> [f64; 3] {
                std::array::from_fn(|r| a[r] + (0..3).map(|c| a[3 + 3 * r + c] * x[c]).sum::<f64>())
            };
            let [given, wanted] =
                [&coarse, &fine].map(|mesh| mesh.nodes().iter().flat_map(field).collect::<Vec<f64>>());
            assert!(distance(&embedding.prolong(&given), &wanted) < 1e-12 * size(&wanted), "{dimension} {covered}");
            let outside =
                fine.nodes().iter().filter(|x| (0..dimension.axes()).any(|r| x[r] > covered * SIZE[r] + 1e-9));
            assert_eq!(embedding.outside().count(), outside.count());
            let worst = embedding.worst_amplification();
            assert!(if covered < 1.0 { worst > 1.0 } else { worst < 1.0 + 1e-9 }, "{worst}");
        }
    }
}

#[test]
fn restriction_is_the_transpose_and_keeps_force_and_moment() {
    for dimension in DIMENSIONS {
        let (fine, coarse) = meshes(dimension, 0.8);
        let embedding = embedded(&fine, &coarse);
        let (u, f) = (noise(3 * coarse.nodes().len(), 1), noise(3 * fine.nodes().len(), 2));
        let restricted = embedding.restrict(&f);
        let work = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (above, below) = (work(&restricted, &u), work(&f, &embedding.prolong(&u)));
        assert!((above - below).abs() < 1e-12 * size(&f) * size(&u), "{dimension}: {above} {below}");
        let (before, after) = (resultants(&fine, &f), resultants(&coarse, &restricted));
        assert!(distance(&before, &after) < 1e-12 * size(&f), "{dimension}: {before:?} {after:?}");
        for node in 0..fine.nodes().len() {
            let weights = embedding.weights(node);
            assert!((weights.iter().map(|w| w.1).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!((1..weights.len()).all(|n| weights[..n].iter().all(|w| w.0 != weights[n].0)), "each once");
        }
    }
}

/// The coarse nodes that are held where a plane of the fine mesh is.
fn held(fine: &SimplexMesh, coarse: &SimplexMesh, selector: &Selector) -> Vec<bool> {
    let conditions = conditions(vec![Hold::still("clamp", select_nodes(fine, selector).unwrap())], vec![]);
    let restricted = restrict_conditions(&conditions, fine, &embedded(fine, coarse), coarse).unwrap();
    restricted.conditions.holds.0[0].nodes.clone()
}

#[test]
fn nested_and_other_meshes_of_a_box_hold_the_same_faces() {
    for (dimension, fine) in DIMENSIONS.into_iter().flat_map(|d| [(d, [6, 4, 4]), (d, [7, 5, 3])]) {
        for (axis, at) in [(0, PlaneAt::Min), (0, PlaneAt::Max), (dimension.axes() - 1, PlaneAt::Max)] {
            let mesh = |boxes| lattice(dimension, boxes, SIZE);
            let axis = [Axis::X, Axis::Y, Axis::Z][axis];
            let plane = Selector::Plane { axis, at };
            let coarse = mesh([3, 2, 2]);
            assert_eq!(
                held(&mesh(fine), &coarse, &plane),
                select_nodes(&coarse, &plane).unwrap(),
                "{dimension} {plane:?}"
            );
        }
    }
}

/// Half of a side is held: a fine node midway between two coarse ones does not hold the second.
#[test]
fn nodes_midway_between_coarse_ones_hold_no_more_than_is_held() {
    let plane = Selector::Plane { axis: Axis::X, at: PlaneAt::Min };
    let half = Selector::Box { low: [0.0; 3], high: [1.0, 0.5 * SIZE[1] + 1e-6, 1.0] };
    let mesh = |boxes| lattice(Dimension::Two, boxes, SIZE);
    let (fine, coarse) = (mesh([4, 4, 1]), mesh([1, 1, 1]));
    let marks = held(&fine, &coarse, &Selector::And(vec![plane, half]));
    assert_eq!(marks, coarse.nodes().iter().map(|x| x[0] == 0.0 && x[1] == 0.0).collect::<Vec<_>>());
}

/// The coarse nodes of this liver lie up to a cell off the surface of the scan.
#[test]
fn a_liver_is_held_at_the_end_of_its_scan_on_its_coarse_mesh_too() {
    let read = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/meshes").join(name);
        read_mesh(&path).unwrap().into_mesh().unwrap()
    };
    let (fine, coarse) = (read("liver_veins_mid.mesh"), read("liver_coarse.mesh"));
    let plane = Selector::Plane { axis: Axis::Z, at: PlaneAt::Max };
    let (marks, own) = (held(&fine, &coarse, &plane), select_nodes(&coarse, &plane).unwrap());
    let count = |marks: &[bool]| marks.iter().filter(|m| **m).count();
    let both = marks.iter().zip(&own).filter(|(a, b)| **a && **b).count();
    let lowest =
        coarse.nodes().iter().zip(&marks).filter(|(_, m)| **m).map(|(x, _)| x[2]).fold(f64::INFINITY, f64::min);
    println!("held {}, by the coarse mesh itself {}, both {both}, lowest {lowest} mm", count(&marks), count(&own));
    assert!(both as f64 > 0.95 * count(&own) as f64, "{both} of {}", count(&own));
    // Half of a mean edge of the coarse mesh.
    assert!(lowest > 137.3 - 12.3, "{lowest}");
}

#[test]
fn a_hold_moves_a_coarse_node_by_its_own_place() {
    let mesh = |boxes| lattice(Dimension::Three, boxes, SIZE);
    let (fine, coarse) = (mesh([6, 4, 4]), mesh([3, 2, 2]));
    let nodes = select_nodes(&fine, &Selector::Plane { axis: Axis::X, at: PlaneAt::Max }).unwrap();
    let twist = grosgrain::dynamics::Twist::about([1.0, 0.0, 0.0], [0.0, 0.015, 0.01], 0.4).unwrap();
    let motion = Motion { twist: Some(twist), translation: [0.001, 0.0, 0.0] };
    let hold = Hold { motion, ramp: Ramp { from: 0.0, to: 1.0 }, ..Hold::still("twist", nodes) };
    let given = conditions(vec![hold.clone()], vec![]);
    let restricted = restrict_conditions(&given, &fine, &embedded(&fine, &coarse), &coarse).unwrap();
    let of_coarse = &restricted.conditions.holds;
    let held = coarse.nodes().iter().enumerate().filter(|(_, x)| x[0] == SIZE[0]);
    for (node, x) in held {
        assert_eq!(of_coarse.displacement_at(node, *x, 0.5), Some(hold.displacement(*x, 0.5)));
    }
    assert_eq!(of_coarse.0[0].nodes.iter().filter(|m| **m).count(), 9);
}

fn spring(node: usize, fine: &SimplexMesh) -> NodeSpring {
    let target = fine.nodes()[node].map(|x| x + 0.003);
    let schedule = Schedule { ramp: Ramp { from: 0.0, to: 1.0 }, until: None };
    NodeSpring { node: Node(node), stiffness: 700.0, target, schedule }
}

#[test]
fn loads_springs_and_ground_do_the_work_that_they_do_on_the_fine_nodes() {
    for covered in [1.0, 0.8] {
        let (fine, coarse) = meshes(Dimension::Three, covered);
        let embedding = embedded(&fine, &coarse);
        let given = Conditions {
            loads: vec![TimedLoad { forces: noise(3 * fine.nodes().len(), 7), schedule: Schedule::default() }],
            springs: vec![spring(11, &fine), spring(200, &fine), spring(fine.nodes().len() - 1, &fine)],
            ground: Some(Ground { height: 0.002, friction: 0.0, stiffness: 1e6 }),
            ..Conditions::default()
        };
        let restricted = restrict_conditions(&given, &fine, &embedding, &coarse).unwrap();
        let make = |mesh: &SimplexMesh, conditions| {
            SimplexBody::new(&uniform(mesh.clone(), (1e5, 0.3), 1000.0), SimplexLaw::Linear, conditions).unwrap()
        };
        let body = make(&coarse, restricted.conditions).with_surface(&restricted.surface).unwrap();
        let (mut body, mut own) = (body.with_springs(&restricted.springs).unwrap(), make(&fine, given));
        let linear = |x: &[f64; 3]| [0.1 * x[0] - 0.2 * x[2], 0.05 * x[1], 0.3 * x[0] - 0.1 * x[1] - 1e-3];
        let coarse_field: Vec<f64> = coarse.nodes().iter().flat_map(linear).collect();
        for share in [0.25, 1.0] {
            let moment = Moment { loads: share, share: 1.0, holds: share };
            body.set_moment(moment).unwrap();
            own.set_moment(moment).unwrap();
            let (a, b) =
                (body.energies(&coarse_field).unwrap(), own.energies(&embedding.prolong(&coarse_field)).unwrap());
            assert!((a.loads - b.loads).abs() < 1e-11 * b.loads.abs(), "{covered}: {a:?} {b:?}");
            assert!((a.points - b.points).abs() < 1e-11 * b.points.abs(), "{covered} {share}: {a:?} {b:?}");
        }
    }
}

#[test]
fn springs_between_nodes_have_the_derivatives_of_their_energy() {
    let (fine, coarse) = meshes(Dimension::Three, 1.0);
    let given = Conditions { springs: vec![spring(60, &fine), spring(100, &fine)], ..Conditions::default() };
    let restricted = restrict_conditions(&given, &fine, &embedded(&fine, &coarse), &coarse).unwrap();
    let model = uniform(coarse.clone(), (1e3, 0.3), 1000.0);
    let body = SimplexBody::new(&model, SimplexLaw::Corotational, restricted.conditions).unwrap();
    let mut body = body.with_springs(&restricted.springs).unwrap();
    body.set_moment(Moment { loads: 0.6, share: 1.0, holds: 0.6 }).unwrap();
    let (u, d) = (noise(3 * coarse.nodes().len(), 5), noise(3 * coarse.nodes().len(), 6));
    let at = |step: f64| u.iter().zip(&d).map(|(u, d)| 1e-3 * u + step * d).collect::<Vec<f64>>();
    let gradient = |step: f64| {
        let mut gradient = vec![0.0; u.len()];
        let energies = body.gradient(&at(step), &mut gradient).unwrap();
        (energies.total(), gradient)
    };
    let step = 1e-6;
    let (plus, minus) = (gradient(step), gradient(-step));
    let slope: f64 = gradient(0.0).1.iter().zip(&d).map(|(g, d)| g * d).sum();
    assert!(((plus.0 - minus.0) / (2.0 * step) - slope).abs() < 1e-6 * slope.abs());
    let change: Vec<f64> = plus.1.iter().zip(&minus.1).map(|(a, b)| (a - b) / (2.0 * step)).collect();
    let weights = grosgrain::dynamics::QuadraticWeights { mass: 0.0, damping: 0.0 };
    body.linearise(&at(0.0), weights, grosgrain::material::Projection::Exact).unwrap();
    let mut product = vec![0.0; u.len()];
    body.multiply(&d, &mut product);
    assert!(distance(&product, &change) < 1e-6 * size(&change));
}

#[test]
fn springs_of_no_cell_or_without_stiffness_are_refused() {
    let model = uniform(lattice(Dimension::Three, [1, 1, 1], SIZE), (1e3, 0.3), 1.0);
    let good =
        EmbeddedSpring { cell: 0, weights: [0.25; 4], stiffness: 1.0, target: [0.0; 3], schedule: Schedule::default() };
    let wrong = [
        EmbeddedSpring { cell: 99, ..good },
        EmbeddedSpring { weights: [0.5; 4], ..good },
        EmbeddedSpring { stiffness: -1.0, ..good },
        EmbeddedSpring { stiffness: f64::NAN, ..good },
        EmbeddedSpring { target: [0.0, f64::NAN, 0.0], ..good },
    ];
    for spring in wrong {
        let body = SimplexBody::new(&model, SimplexLaw::Linear, Conditions::default()).unwrap();
        let error = body.with_springs(&[good, spring]).map(|_| ()).unwrap_err();
        assert!(matches!(error, SimplexBodyError::EmbeddedSpring { spring: 1, .. }), "{error}");
    }
    // Triangles have three corners.
    let model = uniform(lattice(Dimension::Two, [1, 1, 1], SIZE), (1e3, 0.3), 1.0);
    let body = SimplexBody::new(&model, SimplexLaw::Linear, Conditions::default()).unwrap();
    let beyond = EmbeddedSpring { weights: [0.5, 0.25, 0.25, 0.1], ..good };
    assert!(body.with_springs(&[beyond]).is_err());
}
