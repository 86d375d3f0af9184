//! The examples that are meant to be read run, and give the numbers they should.

#[path = "../examples/coarsen_beam.rs"]
#[allow(dead_code, reason = "the example's own main is not called here")]
mod coarsen_beam;

#[test]
fn the_first_example_has_the_error_of_the_same_beam_in_the_golden_file() {
    // tests/golden: one-ring, harmonic base, layers across: 25 %.
    let percent = 100.0 * coarsen_beam::run().unwrap();
    assert!((percent - 25.3).abs() < 0.1, "error {percent} %");
}
