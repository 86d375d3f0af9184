use super::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

fn signed(source: &mut ChaCha8Rng) -> f64 {
    source.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0
}

/// A box, and a displacement of its corners that turns it by 100° and deforms it.
fn example(source: &mut ChaCha8Rng) -> (CoarseBox, Columns) {
    let cell = CoarseBox::new([1.0, 0.5, 2.0]);
    let axis = std::array::from_fn(|_| signed(source));
    let length = axis.iter().map(|a: &f64| a * a).sum::<f64>().sqrt();
    let (sine, cosine) = 100.0f64.to_radians().sin_cos();
    let spin = skew(&axis.map(|a| a / length));
    let square = product(&spin, &spin);
    let turn: Matrix3 = std::array::from_fn(|i| {
        std::array::from_fn(|j| IDENTITY[i][j] + sine * spin[i][j] + (1.0 - cosine) * square[i][j])
    });
    let mut displacement = [0.0; COLUMNS];
    for (i, x) in cell.corners.iter().enumerate() {
        let to = apply(&turn, &std::array::from_fn(|r| x[r] + 0.1 * signed(source)));
        (0..3).for_each(|r| displacement[3 * i + r] = to[r] - x[r] + 0.3);
    }
    (cell, displacement)
}

/// The corners a step further along `direction`.
fn stepped(displacement: &Columns, direction: &Columns, step: f64) -> Columns {
    std::array::from_fn(|n| displacement[n] + step * direction[n])
}

#[test]
fn a_rigid_motion_has_no_local_displacement() {
    let cell = CoarseBox::new([1.0, 0.5, 2.0]);
    let turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let displacement =
        std::array::from_fn(|n| apply(&turn, &cell.corners[n / 3])[n % 3] - cell.corners[n / 3][n % 3] + 7.0);
    let frame = Frame::rotating(&cell, &displacement).unwrap();
    for n in 0..COLUMNS {
        assert!(frame.local[n].abs() < 1e-14, "entry {n}: {:.1e}", frame.local[n]);
    }
}

#[test]
fn the_frame_turns_as_its_spin_says() {
    let mut source = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..5 {
        let (cell, displacement) = example(&mut source);
        let frame = Frame::rotating(&cell, &displacement).unwrap();
        let local: Columns = std::array::from_fn(|_| signed(&mut source));
        let mut direction = [0.0; COLUMNS];
        for (world, xi) in direction.chunks_exact_mut(3).zip(local.chunks_exact(3)) {
            world.copy_from_slice(&apply(&frame.rotation, &[xi[0], xi[1], xi[2]]));
        }
        let w = frame.spin(&cell).map(|row| row.iter().zip(&local).map(|(a, b)| a * b).sum::<f64>());
        let step = 1e-5;
        let [ahead, behind] =
            [step, -step].map(|s| Frame::rotating(&cell, &stepped(&displacement, &direction, s)).unwrap().rotation);
        let exact = product(&frame.rotation, &skew(&w));
        for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
            let slope = (ahead[i][j] - behind[i][j]) / (2.0 * step);
            assert!((slope - exact[i][j]).abs() < 1e-8, "({i}, {j}): {slope} against {}", exact[i][j]);
        }
    }
}

#[test]
fn flat_inverted_and_undefined_elements_are_refused_with_their_determinant() {
    let cell = CoarseBox::new([1.0; 3]);
    let scaled =
        |factors: [f64; 3]| -> Columns { std::array::from_fn(|n| (factors[n % 3] - 1.0) * cell.corners[n / 3][n % 3]) };
    let refused = |factors: [f64; 3]| Frame::rotating(&cell, &scaled(factors)).unwrap_err();
    assert!((refused([1.0, 1.0, -0.5]) + 0.5).abs() < 1e-15);
    assert!(refused([1.0, 2.0, 0.0]).abs() < 1e-15);
    assert!(refused([1.0, 1e-12, 1e-12]) > 0.0);
    assert!(refused([f64::NAN, 1.0, 1.0]).is_nan());
    assert!(Frame::rotating(&cell, &scaled([3.0, 0.1, 0.2])).is_ok());
}
