//! Bodies of tetrahedra on the ground: their own boundary nodes, or those of a finer mesh that move with them.

mod bodies;
mod simplex_motion;

use bodies::Uniform;
use grosgrain::contact::Ground;
use grosgrain::dynamics::{
    Body, Conditions, Damping, EquilibriumOptions, Integrator, LoadPath, QuadraticWeights, SimplexBody,
    SimplexBodyError, State, StepOptions, SurfacePoint, find_equilibrium,
};
use grosgrain::material::Projection;
use grosgrain::simplex::{Dimension, SimplexLaw, SimplexMesh};
use simplex_motion::*;

const BLOCK: [f64; 3] = [0.04, 0.04, 0.02];

fn fine() -> SimplexMesh {
    lattice(Dimension::Three, [6, 6, 3], BLOCK)
}

/// The area \[m²\] of the nodes at the bottom: that of the bottom, and half of the lowest layer of the sides.
fn bottom(embedded: bool) -> f64 {
    let layer = if embedded { BLOCK[2] / 3.0 } else { BLOCK[2] };
    BLOCK[0] * BLOCK[1] + (BLOCK[0] + BLOCK[1]) * layer
}

/// A block of 2×2×1 boxes, on its own nodes or on those of a finer mesh.
fn block(pull: [f64; 3], ground: Ground, embedded: bool) -> SimplexBody {
    block_of(1e5, pull, ground, embedded)
}

fn block_of(young: f64, pull: [f64; 3], ground: Ground, embedded: bool) -> SimplexBody {
    let model = uniform(lattice(Dimension::Three, [2, 2, 1], BLOCK), (young, 0.3), 1000.0);
    let conditions = Conditions { loads: vec![weight(&model, pull)], ground: Some(ground), ..Conditions::default() };
    let body = SimplexBody::new(&model, SimplexLaw::Corotational, conditions).unwrap();
    match embedded {
        true => body.with_surface(&SurfacePoint::embedded(&fine(), model.mesh()).unwrap()).unwrap(),
        false => body,
    }
}

#[test]
fn embedded_points_lie_where_their_nodes_do_and_share_the_surface() {
    let (fine, coarse) = (fine(), lattice(Dimension::Three, [2, 2, 1], BLOCK));
    // Larger than the coarse mesh on one side, so that some points are extrapolated.
    let longer = lattice(Dimension::Three, [5, 4, 3], [0.05, 0.04, 0.02]);
    for mesh in [&fine, &longer] {
        let points = SurfacePoint::embedded(mesh, &coarse).unwrap();
        let area: f64 = points.iter().map(|point| point.area).sum();
        let own: f64 = SurfacePoint::of_boundary(mesh).unwrap().iter().map(|point| point.area).sum();
        assert!((area - own).abs() < 1e-12 * own);
        let mut centre = [0.0; 3];
        for point in &points {
            let corners = coarse.cell(point.cell as usize).iter().map(|n| coarse.nodes()[*n as usize]);
            for (x, w) in corners.zip(point.weights) {
                (0..3).for_each(|r| centre[r] += point.area * w * x[r] / area);
            }
        }
        let middle = if mesh == &fine { [0.02, 0.02, 0.01] } else { [0.025, 0.02, 0.01] };
        assert!(distance(&centre, &middle) < 1e-3 * 0.02, "{centre:?}");
    }
}

#[test]
fn a_block_rests_as_deep_as_its_weight_asks_and_the_ground_carries_it() {
    let ground = Ground { height: 0.0, friction: 0.3, stiffness: 1e7 };
    for embedded in [false, true] {
        let mut body = block_of(1e7, [0.0, 0.0, -GRAVITY], ground, embedded);
        let mut state = body.rest();
        let damping = Damping { mass: 5.0, stiffness: 2e-3 };
        let options = StepOptions { damping, ..options(Integrator::ImplicitEuler, 1e-9) };
        run(&mut body, &mut state, options, (0.01, 400));
        let weight: f64 = GRAVITY * body.mass().iter().sum::<f64>();
        // So stiff that it stays flat: 200 Pa deform it by a fiftieth of the depth.
        let depth = weight / (1e7 * bottom(embedded));
        let found = (0..9).map(|n| -state.displacement[3 * n + 2]).sum::<f64>() / 9.0;
        println!("embedded {embedded}: {found:.4e} m deep, expected {depth:.4e}");
        assert!((found / depth - 1.0).abs() < 0.05, "embedded {embedded}: {found} instead of {depth} m");
        let held = forces_of_ground(&body, &state);
        assert!((held[2] / weight - 1.0).abs() < 1e-6, "embedded {embedded}: {held:?} N against {weight} N");
    }
}

/// What the ground pushes with: all nodal forces are internal, of loads, or of the ground, and those inside sum to zero.
fn forces_of_ground(body: &SimplexBody, state: &State) -> [f64; 3] {
    let mut gradient = vec![0.0; state.displacement.len()];
    body.gradient(&state.displacement, &mut gradient).unwrap();
    let weight: f64 = GRAVITY * body.mass().iter().sum::<f64>();
    let sum = |r: usize| -gradient.chunks_exact(3).map(|g| g[r]).sum::<f64>();
    [sum(0), sum(1), sum(2) + weight]
}

#[test]
fn a_block_that_is_pressed_in_as_a_whole_meets_the_ground_with_its_area() {
    let ground = Ground { height: 0.0, friction: 0.0, stiffness: 1e6 };
    for embedded in [false, true] {
        let body = block([0.0; 3], ground, embedded);
        for depth in [1e-4, 5e-3] {
            let sunk: Vec<f64> = body
                .rest()
                .displacement
                .iter()
                .enumerate()
                .map(|(i, _)| if i % 3 == 2 { -depth } else { 0.0 })
                .collect();
            let (found, exact) = (body.energies(&sunk).unwrap().points, 0.5 * 1e6 * depth * depth * bottom(embedded));
            assert!((found / exact - 1.0).abs() < 1e-10, "embedded {embedded}: {found} instead of {exact} J");
        }
    }
}

/// Cells that stay above the ground as a whole are passed over; what the points of the others do is summed here one by one.
#[test]
fn points_push_as_if_each_were_asked_for_itself_also_where_most_cells_are_in_the_air() {
    let mut random = Uniform(11);
    // Larger than the coarse mesh, so that weights are negative too.
    let surface = lattice(Dimension::Three, [9, 7, 5], [0.044, 0.04, 0.022]);
    let model = uniform(lattice(Dimension::Three, [4, 4, 2], BLOCK), (1e5, 0.3), 1000.0);
    let points = SurfacePoint::embedded(&surface, model.mesh()).unwrap();
    let (mut partly, cases) = (0, 60);
    for case in 0..cases {
        let ground = Ground { height: -0.01 + 0.0005 * f64::from(case), friction: 0.0, stiffness: 1e6 };
        let conditions = Conditions { ground: Some(ground), ..Conditions::default() };
        let body = SimplexBody::new(&model, SimplexLaw::Corotational, conditions).unwrap();
        let body = body.with_surface(&points).unwrap();
        let nodes = model.mesh().nodes();
        let u: Vec<f64> = (0..3 * nodes.len()).map(|_| 0.003 * random.signed()).collect();
        let (mut energy, mut force, mut deep) = (0.0, 0.0, 0);
        for point in &points {
            let corners = model.mesh().cell(point.cell as usize).iter().zip(point.weights);
            let z: f64 = corners.map(|(n, w)| w * (nodes[*n as usize][2] + u[3 * *n as usize + 2])).sum();
            let depth = (ground.height - z).max(0.0);
            energy += 0.5 * ground.stiffness * point.area * depth * depth;
            force -= ground.stiffness * point.area * depth;
            deep += usize::from(depth > 0.0);
        }
        partly += usize::from(0 < deep && deep < points.len());
        let mut gradient = vec![0.0; u.len()];
        let found = body.gradient(&u, &mut gradient).unwrap().points;
        assert!((found - energy).abs() <= 1e-12 * energy, "case {case}: {found} instead of {energy} J");
        assert_eq!(body.energy_of_points(&u).unwrap(), found);
        let upwards: f64 = gradient.chunks_exact(3).map(|g| g[2]).sum();
        assert!((upwards - force).abs() <= 1e-9 * force.abs() + 1e-9, "case {case}: {upwards} instead of {force} N");
    }
    assert!(partly > cases as usize / 2, "{partly}");
}

#[test]
fn derivatives_with_ground_and_friction_are_those_of_the_energy() {
    let ground = Ground { height: 0.001, friction: 0.4, stiffness: 1e7 };
    let mut random = Uniform(5);
    for embedded in [false, true] {
        let mut body = block([0.0, 0.0, -GRAVITY], ground, embedded);
        let nodes = body.mass().len();
        let mut vector = |size: f64| -> Vec<f64> { (0..3 * nodes).map(|_| size * random.signed()).collect() };
        let (settled, u, v) = (vector(4e-4), vector(4e-4), vector(1.0));
        body.settle_friction(&settled);
        body.renew_friction(&u);
        let along = |s: f64| -> Vec<f64> { u.iter().zip(&v).map(|(u, v)| u + s * v).collect() };
        let at = |body: &SimplexBody, s: f64| {
            let mut gradient = vec![0.0; 3 * nodes];
            (body.gradient(&along(s), &mut gradient).unwrap(), gradient)
        };
        // Short enough that no point leaves the ground or begins to slide on the way.
        let step = 1e-9;
        let (ahead, behind, (energies, gradient)) = (at(&body, step), at(&body, -step), at(&body, 0.0));
        assert!(energies.points > 0.0 && body.energy_of_points(&u).unwrap() == energies.points);
        let slope = (ahead.0.total() - behind.0.total()) / (2.0 * step);
        let exact = bodies::dot(&gradient, &v);
        assert!((slope - exact).abs() < 1e-5 * size(&gradient) * size(&v), "embedded {embedded}: {slope}, {exact}");
        let mut product = vec![0.0; 3 * nodes];
        body.linearise(&u, QuadraticWeights { mass: 1e4, damping: 0.0 }, Projection::Exact).unwrap();
        body.multiply(&v, &mut product);
        let largest = size(&product);
        for i in 0..3 * nodes {
            let slope = (ahead.1[i] - behind.1[i]) / (2.0 * step) + 1e4 * body.mass()[i / 3] * v[i];
            assert!((slope - product[i]).abs() < 1e-5 * largest, "embedded {embedded}, {i}: {slope}, {}", product[i]);
        }
    }
}

fn block_on_slope(embedded: bool, (angle, friction): (f64, f64), steps: usize) -> (State, f64) {
    let pull = [GRAVITY * angle.sin(), 0.0, -GRAVITY * angle.cos()];
    let mut body = block(pull, Ground { height: 0.0, friction, stiffness: 1e7 }, embedded);
    let mut state = body.rest();
    let damping = Damping { mass: 0.0, stiffness: 2e-3 };
    let (h, options) = (0.005, StepOptions { damping, ..options(Integrator::ImplicitEuler, 1e-8) });
    run(&mut body, &mut state, options, (h, steps));
    (state, h * steps as f64)
}

#[test]
fn static_friction_holds_and_does_not_creep() {
    let slope = (0.2f64, 1.3 * 0.2f64.tan());
    for embedded in [false, true] {
        let (early, _) = block_on_slope(embedded, slope, 200);
        let (late, _) = block_on_slope(embedded, slope, 400);
        let (slide, end) = (mean_of(&early.displacement, 0), mean_of(&late.displacement, 0));
        assert!(slide.abs() < 2e-3, "embedded {embedded}: slid by {slide}");
        assert!((end - slide).abs() < 1e-6, "embedded {embedded}: creeps by {:.1e} m in a second", end - slide);
    }
}

#[test]
fn a_block_slides_down_a_slope_with_coulombs_acceleration() {
    let (angle, friction) = (0.5f64, 0.2);
    for embedded in [false, true] {
        let (early, t0) = block_on_slope(embedded, (angle, friction), 60);
        let (late, t1) = block_on_slope(embedded, (angle, friction), 100);
        let found = (mean_of(&late.velocity, 0) - mean_of(&early.velocity, 0)) / (t1 - t0);
        let exact = GRAVITY * (angle.sin() - friction * angle.cos());
        assert!((found / exact - 1.0).abs() < 0.01, "embedded {embedded}: {found} instead of {exact} m/s²");
    }
}

#[test]
fn an_equilibrium_on_the_ground_is_found_where_weak_springs_keep_the_body_from_drifting() {
    let ground = Ground { height: 0.0, friction: 0.0, stiffness: 1e7 };
    let model = uniform(lattice(Dimension::Three, [2, 2, 1], BLOCK), (1e5, 0.3), 1000.0);
    let mut conditions = conditions(vec![], vec![weight(&model, [0.0, 0.0, -GRAVITY])]);
    for node in [0, 2, 6] {
        let (at, schedule) = (model.mesh().nodes()[node], Default::default());
        let node = grosgrain::mesh::Node(node);
        conditions.springs.push(grosgrain::dynamics::NodeSpring { node, stiffness: 1e-3, target: at, schedule });
    }
    conditions.ground = Some(ground);
    let mut body = SimplexBody::new(&model, SimplexLaw::Corotational, conditions).unwrap();
    // From a place in the ground: above it nothing but the springs would carry the body.
    let mut u = body.rest().displacement;
    u.iter_mut().skip(2).step_by(3).for_each(|z| *z = -1e-5);
    let path = LoadPath { share: [0.0, 1.0], time: [0.0; 2], loads: [0.0; 2] };
    find_equilibrium(&mut body, &mut u, &path, &EquilibriumOptions::default(), &|_| true).unwrap();
    let state = State { displacement: u.clone(), velocity: vec![0.0; u.len()] };
    let weight: f64 = GRAVITY * body.mass().iter().sum::<f64>();
    assert!((forces_of_ground(&body, &state)[2] / weight - 1.0).abs() < 1e-6);
}

#[test]
fn surface_points_that_move_with_nothing_are_refused() {
    let model = uniform(lattice(Dimension::Three, [2, 2, 1], BLOCK), (1e5, 0.3), 1000.0);
    let good = SurfacePoint { cell: 0, weights: [0.25; 4], area: 1.0 };
    for bad in [
        SurfacePoint { cell: 4000, ..good },
        SurfacePoint { weights: [0.5; 4], ..good },
        SurfacePoint { area: -1.0, ..good },
        SurfacePoint { area: f64::NAN, ..good },
    ] {
        let ground = Ground { height: 0.0, friction: 0.0, stiffness: 1.0 };
        let conditions = Conditions { ground: Some(ground), ..Conditions::default() };
        let body = SimplexBody::new(&model, SimplexLaw::Corotational, conditions).unwrap();
        let refused = body.with_surface(&[good, bad]).err().unwrap();
        assert!(matches!(refused, SimplexBodyError::SurfacePoint { point: 1, .. }), "{refused}");
    }
}
