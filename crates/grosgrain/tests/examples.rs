//! The examples that are meant to be read run, and give the numbers they should.

#[path = "../examples/coarsen_beam.rs"]
#[allow(dead_code, reason = "the example's own main is not called here")]
mod coarsen_beam;

#[path = "../examples/edit_in_a_loop.rs"]
#[allow(dead_code, reason = "the example's own main is not called here")]
mod edit_in_a_loop;

#[path = "../examples/moving_beam.rs"]
#[allow(dead_code, reason = "the example's own main is not called here")]
mod moving_beam;

#[test]
fn a_beam_that_is_cut_while_it_swings_hangs_lower_afterwards() {
    let sags = moving_beam::run().unwrap();
    assert!(sags[5] > 1.5 * sags[2] && sags[2] > 0.0, "{sags:?}");
}

#[path = "../examples/falling_beam.rs"]
#[allow(dead_code, reason = "the example's own main is not called here")]
mod falling_beam;

#[test]
fn a_beam_that_is_cut_in_a_loop_sinks_at_every_frame() {
    let tip = edit_in_a_loop::run(false).unwrap();
    assert!(tip.windows(2).all(|pair| pair[1] < pair[0] && pair[1] < 0.0), "{tip:?}");
}

#[test]
fn the_first_example_has_the_error_of_the_same_beam_in_the_golden_file() {
    // tests/golden: one-ring, harmonic base, layers across: 25 %.
    let percent = 100.0 * coarsen_beam::run().unwrap();
    assert!((percent - 25.3).abs() < 0.1, "error {percent} %");
}

#[test]
fn a_falling_beam_gains_no_energy_in_flight_nor_on_the_ground() {
    let outcome = falling_beam::run(400, false).unwrap();
    let landing = outcome.landing.unwrap();
    assert!((10..100).contains(&landing), "lands in step {landing}");
    assert!(outcome.gains.iter().all(|gain| *gain < 1e-9), "{outcome:?}");
    assert!(outcome.motion_left < 1e-3, "{outcome:?}");
}
