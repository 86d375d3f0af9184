//! The example draws, and what its chart shows is true.

#[allow(dead_code)]
#[path = "../examples/beam.rs"]
mod beam;

#[test]
fn the_beam_is_drawn_in_two_and_in_three_panels() -> Result<(), grosgrain_picture::PictureError> {
    assert_eq!(beam::two_panels().render()?.width(), 1800);
    assert_eq!(beam::three_panels().render()?.width(), 2000);
    assert_eq!(beam::convergence().render()?.width(), 1400);
    Ok(())
}

#[test]
fn trilinear_interpolation_converges_with_second_order() {
    for series in beam::convergence().series {
        let errors: Vec<f64> = series.points.iter().map(|p| p[1]).collect();
        let order = (errors[2] / errors[3]).log2();
        // The next term of the error is a factor of the cell size, 2 of 64 cells, smaller.
        assert!((order - 2.0).abs() < 0.1, "{}: order {order}, errors {errors:?}", series.name);
    }
}
