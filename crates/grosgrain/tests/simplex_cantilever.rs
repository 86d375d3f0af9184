//! Cantilevers of simplices against beam theory: small deflections of tetrahedra, large ones of triangles.

mod bodies;
mod simplex_motion;

use grosgrain::dynamics::{EquilibriumOptions, LoadPath, Schedule, SimplexBody, TimedLoad, find_equilibrium};
use grosgrain::homogenization::SimplexModel;
use grosgrain::simplex::{Dimension, SimplexLaw};
use simplex_motion::*;

/// A force \[N\] on the end at `length`, spread over its nodes by their shares of the end's surface in steps of `h` across.
fn end_load(model: &SimplexModel, length: f64, (h, across): (f64, f64), force: [f64; 3]) -> TimedLoad {
    let axes = model.mesh().dimension().axes();
    let mut forces = vec![0.0; 3 * model.mesh().nodes().len()];
    for (node, x) in model.mesh().nodes().iter().enumerate().filter(|(_, x)| (x[0] - length).abs() < 1e-9) {
        let share = |r: usize| if x[r] < 1e-9 || x[r] > across - 1e-9 { 0.5 * h / across } else { h / across };
        let share: f64 = (1..axes).map(share).product();
        (0..3).for_each(|r| forces[3 * node + r] = share * force[r]);
    }
    TimedLoad { forces, schedule: Schedule::default() }
}

fn equilibrium(mut body: SimplexBody, increments: usize) -> Vec<f64> {
    let mut u = body.rest().displacement;
    let path = LoadPath { share: [0.0, 1.0], time: [0.0; 2], loads: [0.0; 2] };
    let options = EquilibriumOptions { increments, ..EquilibriumOptions::default() };
    find_equilibrium(&mut body, &mut u, &path, &options, &|_| true).unwrap();
    u
}

#[test]
fn the_deflection_of_tetrahedra_tends_to_timoshenkos() {
    // 10 × 1 × 1, clamped without Poisson's effect, so that beam theory lacks next to nothing; a unit force at the end.
    let young = 1e4;
    let deflection = |n: usize, law: SimplexLaw, force: f64| {
        let h = 1.0 / n as f64;
        let model = uniform(lattice(Dimension::Three, [10 * n, n, n], [10.0, 1.0, 1.0]), (young, 0.0), 1.0);
        let load = end_load(&model, 10.0, (h, 1.0), [0.0, 0.0, -force]);
        let forces = load.forces.clone();
        let body = SimplexBody::new(&model, law, conditions(vec![clamped(&model)], vec![load])).unwrap();
        -bodies::dot(&equilibrium(body, 1), &forces) / (force * force)
    };
    let deflections = [2, 4, 8].map(|n| deflection(n, SimplexLaw::Linear, 1.0)).map(f64::abs);
    assert!(deflections.is_sorted(), "a displacement method is too stiff on every mesh: {deflections:?}");
    let energy = deflections.map(|d| 0.5 / d);
    let order = ((energy[1] - energy[0]) / (energy[2] - energy[1])).log2();
    let limit = energy[2] + (energy[2] - energy[1]) / 3.0;
    let exact = 1000.0 / (3.0 * young / 12.0) + 10.0 / (10.0 / 12.0 * young / 2.0);
    println!("order {order:.3}, limit {:.6}, exact {exact:.6}", 0.5 / limit);
    assert!((order - 2.0).abs() < 0.1, "order {order:.3}, deflections {deflections:?}");
    assert!((0.5 / limit / exact - 1.0).abs() < 5e-3, "limit {} instead of {exact}", 0.5 / limit);
    // A small load turns no cell: both laws agree.
    let small = deflection(2, SimplexLaw::Corotational, 1e-6).abs();
    assert!((small / deflections[0] - 1.0).abs() < 1e-6, "{small} against {}", deflections[0]);
}

/// The tip of a straight beam that a force P pulls down across its undeformed axis: it bends, shears and stretches by any amount (Reissner's beam). Lengths in units of that of the
/// beam; `load` = P L² / EI, `thickness` = h / L of a rectangle, Poisson's ratio zero. Integrated by Runge and Kutta's rule from the clamp, where the moment is
/// P times the reach of the tip, which is found by repetition.
fn beam_tip(load: f64, thickness: f64) -> [f64; 2] {
    let slender = thickness * thickness / 12.0;
    let (stretch, shear) = (load * slender, load * slender * 2.0 * 1.2);
    let (steps, mut reach) = (2000, 1.0);
    let mut tip = [0.0; 2];
    for _ in 0..200 {
        let rate = |[x, _, angle]: [f64; 3]| {
            let (sine, cosine) = angle.sin_cos();
            // P acts along −y: P sin along the axis (angles are positive downwards), P cos across it.
            let (along, across) = (1.0 + stretch * sine, shear * cosine);
            [along * cosine - across * sine, -along * sine - across * cosine, load * (reach - x)]
        };
        let (h, mut at) = (1.0 / f64::from(steps), [0.0; 3]);
        for _ in 0..steps {
            let moved = |k: [f64; 3], s: f64| -> [f64; 3] { std::array::from_fn(|i| at[i] + s * k[i]) };
            let a = rate(at);
            let b = rate(moved(a, 0.5 * h));
            let c = rate(moved(b, 0.5 * h));
            let d = rate(moved(c, h));
            at = std::array::from_fn(|i| at[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
        tip = [at[0], at[1]];
        reach = 0.5 * (reach + tip[0]);
    }
    tip
}

#[test]
fn a_beam_of_triangles_bends_far_as_the_elastica_does() {
    // Bisshopp and Drucker's table of 1945 for a thin beam: P L² / EI = 2 takes the tip down by 0.4935 and back by 0.1606.
    let thin = beam_tip(2.0, 1e-4);
    assert!((thin[1] + 0.4935).abs() < 1e-4 && (thin[0] - (1.0 - 0.1606)).abs() < 1e-4, "{thin:?}");
    let (thickness, young) = (0.05f64, 1e6);
    let exact = beam_tip(2.0, thickness);
    let force = 2.0 * young * thickness.powi(3) / 12.0;
    let tip = |n: usize| -> [f64; 2] {
        let model = uniform(lattice(Dimension::Two, [20 * n, n, 1], [1.0, thickness, 1.0]), (young, 0.0), 1.0);
        let load = end_load(&model, 1.0, (thickness / n as f64, thickness), [0.0, -force, 0.0]);
        let body = SimplexBody::new(&model, SimplexLaw::Corotational, conditions(vec![clamped(&model)], vec![load]));
        let u = equilibrium(body.unwrap(), 4);
        let middle = model.mesh().nodes().iter().position(|x| distance(x, &[1.0, 0.5 * thickness, 0.0]) < 1e-9);
        let node = middle.unwrap();
        [1.0 + u[3 * node], u[3 * node + 1]]
    };
    let tips = [4, 8, 16].map(tip);
    let errors = tips.map(|tip| distance(&tip, &exact));
    let limit: [f64; 2] = std::array::from_fn(|r| tips[2][r] + (tips[2][r] - tips[1][r]) / 3.0);
    println!("errors {errors:?}, limit {limit:?}, exact {exact:?}");
    assert!(errors[0] / errors[1] > 3.0 && errors[1] / errors[2] > 3.0, "{errors:?}");
    assert!(distance(&limit, &exact) < 3e-3, "{limit:?} instead of {exact:?}");
}
