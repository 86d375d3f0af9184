//! Coarse meshes for objects that have none: a lattice around the object without the cells that lie outside.

use super::{BoundingBox, BoxCut, Overlaps, SimplexLattice, SimplexLatticeError, SimplexMesh};

/// Sizes that are tried for a number of cells at most.
const TRIALS: usize = 8;
/// Cells that are filled to a smaller share touch the object only; shares nearer to each other are equal.
const ROUNDING: f64 = 1e-10;

impl SimplexLattice {
    /// The lattice that fills the box around an object exactly, with boxes as near to cubes of edge `size` \[m\] as that allows, but no larger.
    ///
    /// # Errors
    /// A size that is not a positive number, or so small that there are too many boxes.
    pub fn fitted(object: &SimplexMesh, size: f64, cut: BoxCut) -> Result<Self, SimplexLatticeError> {
        if !(size > 0.0 && size.is_finite()) {
            return Err(SimplexLatticeError::Size { size });
        }
        let around = BoundingBox::of_points(object.nodes().iter().copied());
        let count = |r: usize| ((around.upper[r] - around.lower[r]) / size * (1.0 - ROUNDING)).ceil().max(1.0) as usize;
        let boxes: [usize; 3] = std::array::from_fn(count);
        if boxes.iter().try_fold(1usize, |all, n| all.checked_mul(*n)).is_none_or(|all| all >= 1 << 30) {
            return Err(SimplexLatticeError::Boxes { boxes });
        }
        Ok(Self { dimension: object.dimension(), boxes, around, cut })
    }

    /// The mesh of those cells of the lattice of which the object fills at least `least_share`; with zero all cells that it meets, which hold all of the object
    /// that lies in the lattice. Shares are exact (see [`Overlaps`]).
    ///
    /// # Errors
    /// As for [`Self::mesh`] and [`Overlaps::new`], or no cell is filled to that share.
    pub fn mesh_around(&self, object: &SimplexMesh, least_share: f64) -> Result<SimplexMesh, SimplexLatticeError> {
        let mesh = self.mesh()?;
        let overlaps = Overlaps::new(object, &mesh)?;
        let is_kept = |cell: usize| overlaps.filled(cell) > ROUNDING.max(least_share - ROUNDING);
        match mesh.part(is_kept) {
            Ok((part, _)) => Ok(part),
            Err(_) => Err(SimplexLatticeError::NothingLeft { share: least_share }),
        }
    }

    /// [`Self::mesh_around`] with the size of boxes so chosen that about `count` cells are kept: of some sizes the one that comes nearest. A lattice that fits a
    /// box changes by whole layers, so the number may be missed by some tens of per cent if it is small.
    ///
    /// # Errors
    /// As for [`Self::mesh_around`].
    pub fn mesh_of_about(
        count: usize,
        object: &SimplexMesh,
        cut: BoxCut,
        least_share: f64,
    ) -> Result<SimplexMesh, SimplexLatticeError> {
        let axes = object.dimension().axes() as f64;
        let around = BoundingBox::of_points(object.nodes().iter().copied());
        let mut size = (object.total_measure() / count.max(1) as f64).powf(1.0 / axes).min(around.diagonal());
        let mut best: Option<SimplexMesh> = None;
        for _ in 0..TRIALS {
            let mesh = Self::fitted(object, size, cut)?.mesh_around(object, least_share)?;
            let ratio = mesh.cell_count() as f64 / count.max(1) as f64;
            let misses_less =
                |other: &SimplexMesh| mesh.cell_count().abs_diff(count) < other.cell_count().abs_diff(count);
            if best.as_ref().is_none_or(misses_less) {
                best = Some(mesh);
            }
            // Damped, so that a size between two layers is not jumped over for ever.
            let factor = ratio.powf(0.7 / axes);
            if (factor - 1.0).abs() < 1e-3 {
                break;
            }
            size = (size * factor).min(around.diagonal());
        }
        best.ok_or(SimplexLatticeError::NothingLeft { share: least_share })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Dimension, Locator};
    use super::*;

    const DIMENSIONS: [Dimension; 3] = [Dimension::One, Dimension::Two, Dimension::Three];

    fn boxes(dimension: Dimension, count: usize, solid: impl Fn([f64; 3]) -> bool) -> SimplexMesh {
        let around = BoundingBox { lower: [-1.0; 3], upper: [1.0; 3] };
        let lattice = SimplexLattice { dimension, boxes: [count; 3], around, cut: BoxCut::Alike };
        let mesh = lattice.mesh().unwrap();
        mesh.part(|cell| solid(mesh.centre(cell))).unwrap().0
    }

    fn is_in_ball(x: [f64; 3]) -> bool {
        x.iter().map(|x| x * x).sum::<f64>() < 0.64
    }

    #[test]
    fn all_of_an_object_lies_in_the_cells_that_are_kept() {
        for dimension in DIMENSIONS {
            for cut in [BoxCut::Alike, BoxCut::Alternating] {
                let ball = boxes(dimension, 20, is_in_ball);
                let lattice = SimplexLattice::fitted(&ball, 0.37, cut).unwrap();
                let mesh = lattice.mesh_around(&ball, 0.0).unwrap();
                let overlaps = Overlaps::new(&ball, &mesh).unwrap();
                assert!(overlaps.worst_covered().1.abs() < 1e-12 && overlaps.empty_coarse().count() == 0);
                let locator = Locator::new(&mesh);
                assert!(ball.nodes().iter().all(|x| !locator.locate(*x).outside), "{dimension}");
                let whole = lattice.mesh().unwrap().cell_count();
                assert!(dimension == Dimension::One || mesh.cell_count() < whole, "{dimension}: nothing is dropped");
                let half = lattice.mesh_around(&ball, 0.5).unwrap();
                let overlaps = Overlaps::new(&ball, &half).unwrap();
                assert!(
                    (0..half.cell_count()).all(|q| overlaps.filled(q) > 0.499)
                        && half.cell_count() <= mesh.cell_count()
                );
            }
        }
    }

    /// An object whose sides lie in those of boxes leaves no cell on their other side, wherever rounding puts them.
    #[test]
    fn cells_that_only_touch_the_object_are_dropped() {
        for dimension in [Dimension::Two, Dimension::Three] {
            for far in [0.0, 1.0 / 3.0, 1e3 / 7.0] {
                let corner = boxes(dimension, 12, |x| x[0] < 0.0 || x[1] < 0.0);
                let nodes = corner.nodes().iter().map(|x| [0.3 * x[0] + far, 0.3 * x[1] - far, 0.3 * x[2]]).collect();
                let cells =
                    (0..corner.cell_count()).map(|c| std::array::from_fn(|n| corner.cell(c).get(n).map_or(0, |n| *n)));
                let corner = SimplexMesh::new(dimension, nodes, cells.collect(), corner.tags().to_vec()).unwrap();
                let lattice = SimplexLattice::fitted(&corner, 0.15, BoxCut::Alternating).unwrap();
                assert_eq!(lattice.boxes[..2], [4, 4]);
                let mesh = lattice.mesh_around(&corner, 0.0).unwrap();
                let (found, expected) = (mesh.total_measure(), corner.total_measure());
                assert!((found / expected - 1.0).abs() < 1e-11, "{dimension}, {far}: {found} {expected}");
                assert_eq!(4 * mesh.cell_count(), 3 * lattice.mesh().unwrap().cell_count());
                let full = lattice.mesh_around(&corner, 1.0).unwrap();
                assert_eq!(full.cell_count(), mesh.cell_count(), "{dimension}, {far}");
            }
        }
    }

    #[test]
    fn a_number_of_cells_is_met_as_nearly_as_layers_allow() {
        for (dimension, most) in [(Dimension::Two, 30), (Dimension::Three, 10)] {
            // The ball has one extent along all axes, so its lattices have as many boxes along each.
            let ball = boxes(dimension, 16, is_in_ball);
            let extent =
                BoundingBox::of_points(ball.nodes().iter().copied()).diagonal() / (dimension.axes() as f64).sqrt();
            let cells = |layers: u32| {
                let lattice = SimplexLattice::fitted(&ball, extent / f64::from(layers), BoxCut::Alternating).unwrap();
                lattice.mesh_around(&ball, 0.0).unwrap().cell_count()
            };
            let possible: Vec<usize> = (1..most).map(cells).collect();
            for count in [30, 120, 200, 640] {
                let mesh = SimplexLattice::mesh_of_about(count, &ball, BoxCut::Alternating, 0.0).unwrap();
                let least = possible.iter().map(|n| n.abs_diff(count)).min();
                assert_eq!(least, Some(mesh.cell_count().abs_diff(count)), "{dimension}, {count}: {possible:?}");
            }
        }
        let bar = boxes(Dimension::One, 10, |_| true);
        assert_eq!(SimplexLattice::mesh_of_about(7, &bar, BoxCut::Alike, 0.0).unwrap().cell_count(), 7);
        assert_eq!(SimplexLattice::mesh_of_about(0, &bar, BoxCut::Alike, 0.0).unwrap().cell_count(), 1);
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let ball = boxes(Dimension::Three, 10, is_in_ball);
        for size in [0.0, -1.0, f64::NAN] {
            let error = SimplexLattice::fitted(&ball, size, BoxCut::Alike).unwrap_err();
            assert!(matches!(error, SimplexLatticeError::Size { .. }), "{error}");
        }
        let error = SimplexLattice::fitted(&ball, 1e-9, BoxCut::Alike).unwrap_err();
        assert!(matches!(error, SimplexLatticeError::Boxes { .. }), "{error}");
        let one = SimplexLattice::fitted(&ball, 9.0, BoxCut::Alike).unwrap();
        assert_eq!(one.boxes, [1, 1, 1]);
        let error = one.mesh_around(&ball, 0.9).unwrap_err();
        assert_eq!(error, SimplexLatticeError::NothingLeft { share: 0.9 });
        let away = BoundingBox { lower: [5.0; 3], upper: [6.0; 3] };
        let error = SimplexLattice { around: away, ..one }.mesh_around(&ball, 0.0).unwrap_err();
        assert!(matches!(error, SimplexLatticeError::Overlap(_)), "{error}");
    }
}
