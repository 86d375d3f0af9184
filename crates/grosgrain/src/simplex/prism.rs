//! Prisms and pyramids cut into tetrahedra, so that neighbours agree on the diagonals.

/// The corners of a prism, turned so that each of them in turn comes first.
const TURNED: [[usize; 6]; 6] = [
    [0, 1, 2, 3, 4, 5],
    [1, 2, 0, 4, 5, 3],
    [2, 0, 1, 5, 3, 4],
    [3, 5, 4, 0, 2, 1],
    [4, 3, 5, 1, 0, 2],
    [5, 4, 3, 2, 1, 0],
];

/// The three tetrahedra of a prism between the triangles of the first and the last three corners, of positive measure where the last lie on the side to which the
/// first turn right-handed. Every four-sided face is cut through its least corner (`dompierre1999subdivide`).
pub(super) fn of_prism(corners: [u32; 6]) -> [[u32; 4]; 3] {
    let least = (0..6).fold(0, |least, n| if corners[n] < corners[least] { n } else { least });
    let [a, b, c, d, e, f] = TURNED[least].map(|n| corners[n]);
    match b.min(f) < c.min(e) {
        true => [[a, b, c, f], [a, b, f, e], [a, e, f, d]],
        false => [[a, b, c, e], [a, e, c, f], [a, e, f, d]],
    }
}

/// The two tetrahedra of a pyramid, its base cut through its least corner.
pub(super) fn of_pyramid(base: [u32; 4], apex: u32) -> [[u32; 4]; 2] {
    let least = (0..4).fold(0, |least, n| if base[n] < base[least] { n } else { least });
    let [a, b, c, d] = std::array::from_fn(|n| base[(n + least) % 4]);
    [[a, b, c, apex], [a, c, d, apex]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::matrix3::determinant;

    const PRISM: [[f64; 3]; 6] =
        [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]];

    fn volume(cell: [usize; 4], place: impl Fn(usize) -> [f64; 3]) -> f64 {
        let [a, b, c, d] = cell.map(place);
        determinant(&std::array::from_fn(|r| [b[r] - a[r], c[r] - a[r], d[r] - a[r]])) / 6.0
    }

    #[test]
    fn a_prism_is_filled_by_right_handed_cells_with_diagonals_from_least_corners_whatever_the_numbers() {
        let mut orders = vec![vec![]];
        for _ in 0..6 {
            let longer = |order: &Vec<u32>| {
                (0..6).filter(|n| !order.contains(n)).map(|n| [&order[..], &[n]].concat()).collect::<Vec<_>>()
            };
            orders = orders.iter().flat_map(longer).collect();
        }
        assert_eq!(orders.len(), 720);
        for order in orders {
            let numbers: [u32; 6] = std::array::from_fn(|n| order[n]);
            let corner = |number: u32| numbers.iter().position(|n| *n == number).unwrap();
            let cells = of_prism(numbers).map(|cell| cell.map(corner));
            let volumes = cells.map(|cell| volume(cell, |n| PRISM[n]));
            assert!(volumes.iter().all(|v| (v - 1.0 / 3.0).abs() < 1e-15), "{numbers:?}: {volumes:?}");
            for face in [[0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]] {
                let least = (0..4).min_by_key(|n| numbers[face[*n]]).unwrap();
                let diagonal = [face[least], face[(least + 2) % 4]];
                assert!(cells.iter().any(|cell| diagonal.iter().all(|n| cell.contains(n))), "{numbers:?}");
            }
        }
    }

    #[test]
    fn a_pyramid_is_filled_with_its_diagonal_from_the_least_corner() {
        let place = |n: usize| [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 1.0]][n];
        for turn in 0..4u32 {
            let base = [0, 1, 2, 3].map(|n| (n + turn) % 4);
            let corner = |number: u32| if number == 9 { 4 } else { ((number + 4 - turn) % 4) as usize };
            let cells = of_pyramid(base, 9).map(|cell| cell.map(corner));
            assert!(cells.iter().all(|cell| (volume(*cell, place) - 1.0 / 6.0).abs() < 1e-15));
            assert!(cells.iter().all(|cell| cell.contains(&corner(0))));
        }
    }
}
