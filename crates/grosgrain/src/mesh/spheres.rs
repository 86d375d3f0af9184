//! Where the spheres of a pattern are.

use std::collections::BTreeMap;

use super::pattern::PatternError;
use super::uniform::{random_stream, uniform};
use super::{Cell, Lattice};

/// The centres of spheres, in cells from the outer corner of cell (0, 0, 0).
#[derive(Clone, Debug, PartialEq)]
pub enum SphereCentres {
    /// Listed one by one.
    List(Vec<[f64; 3]>),
    /// A simple cubic lattice: (n + ½) period along each axis.
    Periodic {
        /// Distance of neighbouring centres in cells.
        period: f64,
    },
    /// Placed one after the other at random, without overlap and inside the grid.
    Random {
        /// Seed of the stream.
        seed: u64,
        /// Number of spheres.
        count: usize,
    },
}

/// Which cells have their centre inside a sphere of `radius` cells.
pub(super) fn inside(lattice: &Lattice, radius: f64, centres: &SphereCentres) -> Result<Vec<bool>, PatternError> {
    match centres {
        SphereCentres::List(list) => match list.iter().find(|c| !c.iter().all(|x| x.is_finite())) {
            Some(bad) => Err(PatternError::Centre(*bad)),
            None => Ok(inside_any(lattice, radius, list)),
        },
        SphereCentres::Periodic { period } => Ok(inside_periodic(lattice, radius, *period)),
        SphereCentres::Random { seed, count } => {
            Ok(inside_any(lattice, radius, &place(lattice, radius, *seed, *count)?))
        }
    }
}

fn inside_periodic(lattice: &Lattice, radius: f64, period: f64) -> Vec<bool> {
    let to_nearest = |i: usize| (i as f64 + 0.5).rem_euclid(period) - 0.5 * period;
    let cells = (0..lattice.cell_count()).map(|c| lattice.cell_position(Cell(c)));
    cells.map(|at| holds(radius, at.map(to_nearest))).collect()
}

fn inside_any(lattice: &Lattice, radius: f64, centres: &[[f64; 3]]) -> Vec<bool> {
    let mut inside = vec![false; lattice.cell_count()];
    for centre in centres {
        let range = |a: usize| {
            let last = lattice.cells[a] as f64;
            let clip = |x: f64| x.clamp(0.0, last) as usize;
            clip((centre[a] - radius - 1.0).floor())..clip((centre[a] + radius + 1.0).ceil())
        };
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    let at = [i, j, k];
                    let away = std::array::from_fn(|a| at[a] as f64 + 0.5 - centre[a]);
                    inside[lattice.cell(at).0] |= holds(radius, away);
                }
            }
        }
    }
    inside
}

/// True if a point `away` from the centre lies in the closed ball, up to rounding.
fn holds(radius: f64, away: [f64; 3]) -> bool {
    square(away) <= radius * radius * (1.0 + 1e-12)
}

fn square(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum()
}

/// Attempts to place one sphere before giving up.
const ATTEMPTS: usize = 1000;

/// Random sequential addition: each centre is uniform among those that keep the sphere inside the grid.
fn place(lattice: &Lattice, radius: f64, seed: u64, count: usize) -> Result<Vec<[f64; 3]>, PatternError> {
    let room = lattice.cells.map(|n| n as f64 - 2.0 * radius);
    if room.iter().any(|r| *r < 0.0) {
        return Err(PatternError::TooLarge { radius, cells: lattice.cells });
    }
    let mut stream = random_stream(seed);
    let mut placed = Placed::new(radius);
    for done in 0..count {
        let mut attempts = (0..ATTEMPTS).map(|_| std::array::from_fn(|a| radius + room[a] * uniform(&mut stream)));
        match attempts.find(|centre| placed.is_free(*centre)) {
            Some(centre) => placed.add(centre),
            None => return Err(PatternError::Crowded { placed: done, count, radius }),
        }
    }
    Ok(placed.centres)
}

/// Spheres placed so far, found again by bins one diameter wide.
struct Placed {
    radius: f64,
    centres: Vec<[f64; 3]>,
    bins: BTreeMap<[i64; 3], Vec<usize>>,
}

impl Placed {
    fn new(radius: f64) -> Self {
        Self { radius, centres: Vec::new(), bins: BTreeMap::new() }
    }

    fn bin(&self, centre: [f64; 3]) -> [i64; 3] {
        centre.map(|x| (x / (2.0 * self.radius)).floor() as i64)
    }

    fn is_free(&self, centre: [f64; 3]) -> bool {
        let bin = self.bin(centre);
        let around = (0..27).map(|n: i64| [bin[0] + n % 3 - 1, bin[1] + n / 3 % 3 - 1, bin[2] + n / 9 - 1]);
        around.filter_map(|b| self.bins.get(&b)).flatten().all(|&other| {
            let away = std::array::from_fn(|a| centre[a] - self.centres[other][a]);
            square(away) >= 4.0 * self.radius * self.radius
        })
    }

    fn add(&mut self, centre: [f64; 3]) {
        let bin = self.bin(centre);
        self.bins.entry(bin).or_default().push(self.centres.len());
        self.centres.push(centre);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_listed_sphere_holds_the_cells_whose_centres_are_inside() {
        let lattice = Lattice::new([5, 5, 5]);
        let found = inside(&lattice, 1.0, &SphereCentres::List(vec![[2.5; 3]])).unwrap();
        let expected = |at: [usize; 3]| at.iter().map(|i| i.abs_diff(2)).sum::<usize>() <= 1;
        for (c, inside) in found.iter().enumerate() {
            assert_eq!(*inside, expected(lattice.cell_position(Cell(c))), "cell {c}");
        }
        let outside = inside(&lattice, 1.0, &SphereCentres::List(vec![[-50.0, 2.0, 900.0]])).unwrap();
        assert!(outside.iter().all(|i| !i));
    }

    #[test]
    fn periodic_spheres_are_the_listed_ones_of_the_lattice() {
        let lattice = Lattice::new([12, 8, 4]);
        let list = (0..6).map(|n| [2.0 + 4.0 * (n % 3) as f64, 2.0 + 4.0 * (n / 3) as f64, 2.0]).collect();
        let listed = inside(&lattice, 1.7, &SphereCentres::List(list)).unwrap();
        assert_eq!(inside(&lattice, 1.7, &SphereCentres::Periodic { period: 4.0 }).unwrap(), listed);
    }

    #[test]
    fn random_spheres_do_not_overlap_and_stay_inside() {
        let lattice = Lattice::new([30, 20, 10]);
        let centres = place(&lattice, 2.0, 3, 30).unwrap();
        for (n, a) in centres.iter().enumerate() {
            assert!((0..3).all(|x| a[x] >= 2.0 && a[x] <= lattice.cells[x] as f64 - 2.0), "{a:?}");
            for b in &centres[..n] {
                let distance = square(std::array::from_fn(|x| a[x] - b[x])).sqrt();
                assert!(distance >= 4.0, "{a:?} and {b:?} are {distance} apart");
            }
        }
        assert_eq!(centres, place(&lattice, 2.0, 3, 30).unwrap());
    }

    #[test]
    fn spheres_that_find_no_place_are_refused_with_what_was_possible() {
        let lattice = Lattice::new([10, 10, 10]);
        let crowded = place(&lattice, 2.0, 0, 200).unwrap_err();
        assert!(matches!(crowded, PatternError::Crowded { placed: 1..=30, count: 200, .. }), "{crowded}");
        assert!(matches!(place(&lattice, 6.0, 0, 1), Err(PatternError::TooLarge { .. })));
        let bad = inside(&lattice, 1.0, &SphereCentres::List(vec![[f64::NAN; 3]]));
        assert!(matches!(bad, Err(PatternError::Centre(_))));
    }
}
