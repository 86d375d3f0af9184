//! Memory stays bounded over many steps. A test binary of its own: what other tests allocate would count too.
#![cfg(target_os = "linux")]

#[path = "../examples/falling_beam.rs"]
#[allow(dead_code, reason = "the example's own main is not called here")]
mod falling_beam;

use falling_beam::{falling_beam, resident};

/// Length of a step [s]; shorter than that of the example, so that the beam lands during the first steps that count.
const STEP: f64 = 0.002;

#[test]
fn three_thousand_steps_do_not_grow_memory() {
    let mut simulation = falling_beam().unwrap();
    let mut ground = 0.0f64;
    for _ in 0..500 {
        ground = ground.max(simulation.step(STEP).unwrap().energies.points);
    }
    let after_landing = resident().unwrap();
    assert!(ground > 0.0, "the beam has not landed");
    for _ in 0..3_000 {
        simulation.step(STEP).unwrap();
    }
    // 1 MB are 350 bytes a step.
    let grown = resident().unwrap().saturating_sub(after_landing);
    assert!(grown < 1 << 20, "memory has grown by {grown} bytes");
}
