//! Meshes of cylinders.

use std::f64::consts::{PI, TAU};

use super::prism::of_prism;
use super::{Dimension, SimplexLatticeError, SimplexMesh};

/// A cylinder about the z axis on the plane z = 0, in layers of prisms on rings of triangles.
///
/// Ring k of nodes has 6 k of them, the outermost on a circle so much wider that the polygon has the area of the circle: coarse and fine meshes of one cylinder have the same volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimplexCylinder {
    /// Radius \[m\].
    pub radius: f64,
    /// Height \[m\].
    pub height: f64,
    /// Rings of triangles, n.
    pub rings: usize,
    /// Layers along z, m.
    pub layers: usize,
}

impl SimplexCylinder {
    /// The mesh: 18 n² m tetrahedra, (3 n (n + 1) + 1) (m + 1) nodes, all tags zero.
    ///
    /// # Errors
    /// No rings or layers, or too many; a radius or height of zero.
    pub fn mesh(&self) -> Result<SimplexMesh, SimplexLatticeError> {
        let Self { radius, height, rings, layers } = *self;
        let count = rings.checked_mul(rings).and_then(|square| square.checked_mul(18)?.checked_mul(layers));
        if count.is_none_or(|count| count == 0 || count >= 1 << 30) {
            return Err(SimplexLatticeError::Boxes { boxes: [rings, rings, layers] });
        }
        for (axis, to) in [(0, radius), (2, height)] {
            if !(to > 0.0 && to.is_finite()) {
                return Err(SimplexLatticeError::Extent { axis, from: 0.0, to });
            }
        }
        let disc = self.disc();
        let in_layer = disc.len();
        let height_of = |layer: usize| height * layer as f64 / layers as f64;
        let nodes: Vec<[f64; 3]> =
            (0..=layers).flat_map(|layer| disc.iter().map(move |[x, y]| [*x, *y, height_of(layer)])).collect();
        let triangles = triangles(rings);
        let prisms = (0..layers).flat_map(|layer| triangles.iter().map(move |triangle| (layer, triangle)));
        let node = |layer: usize, n: usize| (layer * in_layer + n) as u32;
        let prisms = prisms.map(|(layer, [a, b, c])| {
            [
                node(layer, *a),
                node(layer, *b),
                node(layer, *c),
                node(layer + 1, *a),
                node(layer + 1, *b),
                node(layer + 1, *c),
            ]
        });
        let cells: Vec<[u32; 4]> = prisms.flat_map(of_prism).collect();
        let tags = vec![0; cells.len()];
        Ok(SimplexMesh::new(Dimension::Three, nodes, cells, tags)?)
    }

    /// Nodes of one layer, from the axis outwards.
    fn disc(&self) -> Vec<[f64; 2]> {
        let sides = (6 * self.rings) as f64;
        let outermost = self.radius * (TAU / (sides * (TAU / sides).sin())).sqrt();
        let mut disc = vec![[0.0; 2]];
        for ring in 1..=self.rings {
            let radius = outermost * ring as f64 / self.rings as f64;
            disc.extend((0..6 * ring).map(|n| {
                let angle = PI * n as f64 / (3 * ring) as f64;
                [radius * angle.cos(), radius * angle.sin()]
            }));
        }
        disc
    }
}

/// The triangles of a disc, against the clock.
fn triangles(rings: usize) -> Vec<[usize; 3]> {
    let node = |ring: usize, n: usize| if ring == 0 { 0 } else { 1 + 3 * ring * (ring - 1) + n % (6 * ring) };
    let mut triangles = Vec::with_capacity(6 * rings * rings);
    for (ring, sector) in (1..=rings).flat_map(|ring| (0..6).map(move |sector| (ring, sector))) {
        let (outer, inner) =
            (|n: usize| node(ring, sector * ring + n), |n: usize| node(ring - 1, sector * (ring - 1) + n));
        triangles.extend((0..ring).map(|n| [outer(n), outer(n + 1), inner(n)]));
        triangles.extend((1..ring).map(|n| [inner(n - 1), outer(n), inner(n)]));
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::super::Boundary;
    use super::*;

    #[test]
    fn coarse_and_fine_cylinders_have_the_volume_of_the_round_one_and_one_closed_surface() {
        for (rings, layers) in [(1, 1), (2, 3), (3, 1), (9, 4)] {
            let mesh = SimplexCylinder { radius: 0.3, height: 0.2, rings, layers }.mesh().unwrap();
            assert_eq!(mesh.cell_count(), 18 * rings * rings * layers);
            assert_eq!(mesh.nodes().len(), (3 * rings * (rings + 1) + 1) * (layers + 1));
            assert!((mesh.total_measure() / (PI * 0.09 * 0.2) - 1.0).abs() < 1e-13, "{rings} rings");
            let boundary = Boundary::of_mesh(&mesh).unwrap();
            assert_eq!(boundary.faces().len(), 12 * rings * (rings + layers), "both ends and the side");
            assert_eq!((boundary.shells().len(), boundary.branching().len()), (1, 0));
        }
    }

    #[test]
    fn cells_are_well_shaped_where_layers_are_as_thick_as_rings() {
        let mesh = SimplexCylinder { radius: 1.0, height: 0.5, rings: 10, layers: 5 }.mesh().unwrap();
        let least = (0..mesh.cell_count()).map(|cell| mesh.shape_quality(cell)).fold(f64::INFINITY, f64::min);
        // A prism of three cells on a regular triangle, as high as its edge, has 0.72 at worst; the rim is flatter.
        assert!(least > 0.5, "{least}");
    }

    #[test]
    fn what_cannot_be_made_is_refused() {
        let cylinder = SimplexCylinder { radius: 0.3, height: 0.2, rings: 2, layers: 1 };
        for broken in [
            SimplexCylinder { rings: 0, ..cylinder },
            SimplexCylinder { layers: 0, ..cylinder },
            SimplexCylinder { rings: 1 << 33, ..cylinder },
            SimplexCylinder { radius: 0.0, ..cylinder },
            SimplexCylinder { height: f64::NAN, ..cylinder },
        ] {
            assert!(broken.mesh().is_err(), "{broken:?}");
        }
    }
}
