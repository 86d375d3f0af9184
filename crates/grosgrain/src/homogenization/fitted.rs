//! Fields of a fine mesh as the coarse fields closest to them.

use std::sync::Arc;

use super::system::cliques;
use super::{Downsampled, HarmonicDisplacements, SimplexEmbedding};
use crate::linalg::{Cholesky, CholeskyError, SparsePattern, SymbolicCholesky, clique_order};
use crate::simplex::SimplexMesh;

/// Weight of the value at a coarse node against all that the fit knows of its surroundings: nodes that no fine node speaks for keep their value.
const PULL: f64 = 1e-6;
/// Columns of a field: three components of six displacements.
const COLUMNS: usize = 18;

/// The coarse fields closest to `fields` on the whole body, in place of those at the coarse nodes: with the `embedding` of the fine mesh in the coarse one, H̄ minimises
/// Σ_n V_n |Σ_i w_ni H̄_i − H_n|² over the fine nodes n, with the part V_n of the volume that a node stands for and its barycentric weights w_ni in the coarse mesh.
///
/// Values at the nodes, `at_nodes`, are those of whatever material is there: a node in a soft layer moves otherwise than one in a stiff layer beside it. The fit sees all of the
/// fine body, a node outside of it too goes by all fine nodes in the cells around instead of by the closest fine cells, and linear fields stay as they are. In return it smears jumps,
/// such as that across a thin soft slice, over the coarse cells around. Which nodes are extrapolated, and by how much, is left as it was for the values at the nodes.
///
/// # Errors
/// A factor that does not fit into memory.
pub fn fit_downsampled(
    (fine, fields): (&SimplexMesh, &HarmonicDisplacements),
    (coarse, embedding): (&SimplexMesh, &SimplexEmbedding),
    at_nodes: &Downsampled,
) -> Result<Downsampled, CholeskyError> {
    let (nodes, volumes, ranks) = (coarse.nodes().len(), measures(fine), ranks(coarse));
    let (pattern, values) = normal_matrix((embedding, &ranks), &volumes, &measures(coarse));
    // What the values at the nodes miss; nothing where fields are linear, so that these stay exact.
    let mut block = vec![0.0; COLUMNS * nodes];
    for (node, (volume, field)) in volumes.iter().zip(&fields.fields).enumerate() {
        let weights = embedding.weights(node);
        for (column, value) in field.as_flattened().iter().enumerate() {
            let known: f64 =
                weights.iter().map(|(i, w)| w * at_nodes.fields.fields[*i as usize].as_flattened()[column]).sum();
            let missed = volume * (value - known);
            weights.iter().for_each(|(i, w)| block[nodes * column + ranks[*i as usize] as usize] += w * missed);
        }
    }
    let mut cholesky = Cholesky::new(Arc::new(SymbolicCholesky::analyse(Arc::new(pattern))?), COLUMNS)?;
    cholesky.factor(&values)?;
    cholesky.solve_in_place(&mut block);
    let mut fitted = at_nodes.clone();
    for (rank, field) in ranks.iter().zip(&mut fitted.fields.fields) {
        let corrections = block[*rank as usize..].iter().step_by(nodes);
        field.as_flattened_mut().iter_mut().zip(corrections).for_each(|(value, correction)| *value += correction);
    }
    Ok(fitted)
}

/// The part of the measure of the body that each node stands for.
fn measures(mesh: &SimplexMesh) -> Vec<f64> {
    mesh.lumped(|cell| mesh.measure(cell))
}

/// The place of each node in elimination order, without which the factor of a mesh that is numbered anyhow is nearly full.
fn ranks(mesh: &SimplexMesh) -> Vec<u32> {
    let own: Vec<u32> = (0..mesh.nodes().len() as u32).collect();
    // Whatever keeps a graph from being ordered, the factor is right in any order.
    let order = clique_order(own.len(), &cliques(mesh, &own)).unwrap_or_else(|_| own.clone());
    let mut ranks = own;
    order.iter().zip(0..).for_each(|(node, rank)| ranks[*node as usize] = rank);
    ranks
}

/// Σ_n V_n w_ni w_nj by the ranks of nodes, and the pull towards the values at the nodes on its diagonal.
fn normal_matrix(
    (embedding, ranks): (&SimplexEmbedding, &[u32]),
    volumes: &[f64],
    of_coarse: &[f64],
) -> (SparsePattern, Vec<f64>) {
    let mean = of_coarse.iter().sum::<f64>() / of_coarse.len() as f64;
    let mut entries: Vec<([u32; 2], f64)> = Vec::new();
    for (node, volume) in volumes.iter().enumerate() {
        let weights = embedding.weights(node);
        for (n, (i, w)) in weights.iter().enumerate() {
            entries.extend(weights[n..].iter().map(|(j, v)| {
                let [i, j] = [i, j].map(|node| ranks[*node as usize]);
                ([i.min(j), i.max(j)], volume * w * v)
            }));
        }
    }
    // Nodes that no cell uses have a pull as well.
    let pull = |node: usize| PULL * if of_coarse[node] > 0.0 { of_coarse[node] } else { mean };
    entries.extend((0..of_coarse.len()).map(|node| ([ranks[node]; 2], pull(node))));
    entries.sort_by_key(|entry| entry.0);
    let mut pattern = SparsePattern { column_starts: vec![0], rows: Vec::new() };
    let mut values: Vec<f64> = Vec::new();
    for same in entries.chunk_by(|a, b| a.0 == b.0) {
        let [column, row] = same[0].0;
        while pattern.column_starts.len() <= column as usize {
            pattern.column_starts.push(pattern.rows.len() as u32);
        }
        pattern.rows.push(row);
        values.push(same.iter().map(|entry| entry.1).sum());
    }
    pattern.column_starts.push(pattern.rows.len() as u32);
    (pattern, values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::homogenization::downsample;
    use crate::simplex::{BoundingBox, BoxCut, Dimension, Locator, SimplexLattice};

    fn lattice(boxes: usize, from: f64, to: f64) -> SimplexMesh {
        let around = BoundingBox { lower: [from; 3], upper: [to; 3] };
        SimplexLattice { dimension: Dimension::Three, boxes: [boxes; 3], around, cut: BoxCut::Alternating }
            .mesh()
            .unwrap()
    }

    fn fields(mesh: &SimplexMesh, value: impl Fn(&[f64; 3], usize) -> f64) -> HarmonicDisplacements {
        let field = |x: &[f64; 3]| {
            let mut field = [[0.0; 6]; 3];
            field.as_flattened_mut().iter_mut().enumerate().for_each(|(c, entry)| *entry = value(x, c));
            field
        };
        HarmonicDisplacements { fields: mesh.nodes().iter().map(field).collect() }
    }

    fn fitted(
        fine: &SimplexMesh,
        fields: &HarmonicDisplacements,
        coarse: &SimplexMesh,
        at_nodes: &Downsampled,
    ) -> Downsampled {
        let embedding = SimplexEmbedding::new(fine, &Locator::new(coarse));
        fit_downsampled((fine, fields), (coarse, &embedding), at_nodes).unwrap()
    }

    fn misfit(fine: &SimplexMesh, of: &HarmonicDisplacements, coarse: &SimplexMesh, by: &HarmonicDisplacements) -> f64 {
        let (locator, volumes) = (Locator::new(coarse), measures(fine));
        let square = |n: usize| {
            let value: [f64; 6] = locator.locate(fine.nodes()[n]).value(coarse, &rows(by));
            volumes[n] * (0..6).map(|c| (value[c] - of.fields[n][0][c]).powi(2)).sum::<f64>()
        };
        (0..fine.nodes().len()).map(square).sum()
    }

    fn rows(fields: &HarmonicDisplacements) -> Vec<[f64; 6]> {
        fields.fields.iter().map(|field| field[0]).collect()
    }

    #[test]
    fn linear_fields_stay_as_they_are_inside_and_outside_of_the_fine_mesh() {
        // The coarse mesh is larger in one case and smaller in the other.
        for (from, to) in [(-0.03, 0.14), (0.02, 0.09)] {
            let (fine, coarse) = (lattice(9, 0.0, 0.1), lattice(2, from, to));
            let linear = |x: &[f64; 3], c: usize| 3.0 + c as f64 * x[0] - 2.0 * x[1] + (c % 5) as f64 * x[2];
            let (of_fine, expected) = (fields(&fine, linear), fields(&coarse, linear));
            let at_nodes = downsample(&Locator::new(&fine), &of_fine, &coarse);
            let fitted = fitted(&fine, &of_fine, &coarse, &at_nodes);
            for (found, expected) in fitted.fields.fields.iter().zip(&expected.fields) {
                let entries = found.as_flattened().iter().zip(expected.as_flattened());
                entries.for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{a} {b}"));
            }
        }
    }

    #[test]
    fn the_factor_stays_sparse_however_nodes_are_numbered() {
        let (fine, ordered) = (lattice(7, 0.0, 0.1), lattice(6, 0.0, 0.1));
        let count = ordered.nodes().len();
        let number = |node: usize| 167 * node % count;
        let mut nodes = vec![[0.0; 3]; count];
        (0..count).for_each(|node| nodes[number(node)] = ordered.nodes()[node]);
        let cells = (0..ordered.cell_count())
            .map(|cell| std::array::from_fn(|n| number(ordered.cell(cell)[n] as usize) as u32));
        let coarse = SimplexMesh::new(Dimension::Three, nodes, cells.collect(), vec![0; ordered.cell_count()]).unwrap();
        let embedding = SimplexEmbedding::new(&fine, &Locator::new(&coarse));
        let entries = |ranks: &[u32]| {
            let (pattern, _) = normal_matrix((&embedding, ranks), &measures(&fine), &measures(&coarse));
            SymbolicCholesky::analyse(Arc::new(pattern)).unwrap().factor_entries()
        };
        let (found, as_numbered) = (entries(&ranks(&coarse)), entries(&(0..count as u32).collect::<Vec<_>>()));
        assert!(2 * found < as_numbered, "{found} {as_numbered}");
    }

    #[test]
    fn no_coarse_field_nearby_is_closer() {
        let (fine, coarse) = (lattice(8, 0.0, 0.1), lattice(2, 0.0, 0.1));
        // Layers: steep in every second one.
        let wavy = |x: &[f64; 3], c: usize| x[2] + 0.01 * (700.0 * x[2] + c as f64).sin();
        let of_fine = fields(&fine, wavy);
        let at_nodes = downsample(&Locator::new(&fine), &of_fine, &coarse);
        let fitted = fitted(&fine, &of_fine, &coarse, &at_nodes);
        let least = misfit(&fine, &of_fine, &coarse, &fitted.fields);
        assert!(least < 0.9 * misfit(&fine, &of_fine, &coarse, &at_nodes.fields));
        for (node, column, change) in [(0, 0, 1e-3), (13, 3, -1e-3), (20, 5, 2e-4), (26, 2, -1e-4)] {
            let mut moved = fitted.fields.clone();
            moved.fields[node][0][column] += change;
            assert!(misfit(&fine, &of_fine, &coarse, &moved) > least, "node {node}, column {column}");
        }
    }

    #[test]
    fn coarse_nodes_far_from_all_fine_ones_keep_their_value() {
        let (fine, coarse) = (lattice(4, 0.0, 0.1), lattice(4, 0.0, 0.4));
        let of_fine = fields(&fine, |x, c| x[0] * x[0] + c as f64);
        let at_nodes = downsample(&Locator::new(&fine), &of_fine, &coarse);
        let fitted = fitted(&fine, &of_fine, &coarse, &at_nodes);
        let last = coarse.nodes().len() - 1;
        assert_eq!(fitted.fields.fields[last], at_nodes.fields.fields[last]);
        assert_ne!(fitted.fields.fields[0], at_nodes.fields.fields[0]);
    }
}
