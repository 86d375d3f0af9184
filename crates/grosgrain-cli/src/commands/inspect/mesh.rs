//! What a mesh file holds.

use std::collections::BTreeMap;
use std::path::Path;

use grosgrain::io::{MeshFile, read_mesh};
use grosgrain::simplex::SimplexMesh;
use serde::Serialize;

use super::row;
use crate::failure::Failure;
use crate::memory;
use crate::quantities::{bytes, count, counted, number, triple};

/// Cells below this shape quality are counted: stiffnesses of worse ones are badly conditioned.
const POOR: f64 = 0.1;

/// What a mesh file holds; lengths in the units of the file.
#[derive(Debug, Serialize)]
pub struct MeshSummary {
    cells_are: String,
    nodes: usize,
    cells: usize,
    low: [f64; 3],
    high: [f64; 3],
    measure: f64,
    tags: Vec<TagSummary>,
    parts: usize,
    edges: [f64; 2],
    worst_quality: f64,
    mean_quality: f64,
    poor_cells: usize,
    unknowns: usize,
    direct_bytes: Option<f64>,
    skipped: Vec<String>,
}

#[derive(Debug, Serialize)]
struct TagSummary {
    tag: i32,
    name: Option<String>,
    cells: usize,
    measure: f64,
}

/// Reads the mesh in `file` and sums it up.
pub fn summarise(file: &Path) -> Result<MeshSummary, Failure> {
    let mut contents = read_mesh(file)?;
    let (names, skipped) = (std::mem::take(&mut contents.names), std::mem::take(&mut contents.skipped));
    let mesh = as_mesh(contents, file)?;
    let qualities: Vec<f64> = (0..mesh.cell_count()).map(|cell| mesh.shape_quality(cell)).collect();
    let unknowns = mesh.dimension().axes() * mesh.nodes().len();
    let [low, high] = bounds(&mesh);
    Ok(MeshSummary {
        cells_are: mesh.dimension().to_string(),
        nodes: mesh.nodes().len(),
        cells: mesh.cell_count(),
        low,
        high,
        measure: mesh.total_measure(),
        tags: tags(&mesh, &names),
        parts: parts(&mesh),
        edges: edges(&mesh),
        worst_quality: qualities.iter().copied().fold(1.0, f64::min),
        mean_quality: qualities.iter().sum::<f64>() / qualities.len() as f64,
        poor_cells: qualities.iter().filter(|q| **q < POOR).count(),
        unknowns,
        direct_bytes: (mesh.dimension().axes() == 3).then(|| memory::direct(unknowns)),
        skipped,
    })
}

/// The mesh in a file; a failure names the file.
pub(in crate::commands) fn as_mesh(contents: MeshFile, file: &Path) -> Result<SimplexMesh, Failure> {
    contents.into_mesh().map_err(|error| Failure::Failed(format!("{}: {error}", file.display())))
}

fn bounds(mesh: &SimplexMesh) -> [[f64; 3]; 2] {
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for node in mesh.nodes() {
        for (a, x) in node.iter().enumerate() {
            bounds[0][a] = bounds[0][a].min(*x);
            bounds[1][a] = bounds[1][a].max(*x);
        }
    }
    bounds
}

fn edges(mesh: &SimplexMesh) -> [f64; 2] {
    let ranges = (0..mesh.cell_count()).map(|cell| mesh.edge_range(cell));
    ranges.fold([f64::INFINITY, 0.0], |[low, high], [shortest, longest]| [low.min(shortest), high.max(longest)])
}

fn tags(mesh: &SimplexMesh, names: &[(i32, String)]) -> Vec<TagSummary> {
    let mut sums: BTreeMap<i32, (usize, f64)> = BTreeMap::new();
    for (cell, tag) in mesh.tags().iter().enumerate() {
        let (cells, measure) = sums.entry(*tag).or_default();
        *cells += 1;
        *measure += mesh.measure(cell);
    }
    let name = |tag: i32| names.iter().find(|(named, _)| *named == tag).map(|(_, name)| name.clone());
    sums.into_iter().map(|(tag, (cells, measure))| TagSummary { tag, name: name(tag), cells, measure }).collect()
}

/// Number of parts whose cells hang together by faces.
fn parts(mesh: &SimplexMesh) -> usize {
    let mut faces: Vec<(Vec<u32>, usize)> = Vec::new();
    for cell in 0..mesh.cell_count() {
        let corners = mesh.cell(cell);
        for opposite in corners {
            let mut face: Vec<u32> = corners.iter().copied().filter(|node| node != opposite).collect();
            face.sort_unstable();
            faces.push((face, cell));
        }
    }
    faces.sort_unstable();
    let mut roots: Vec<usize> = (0..mesh.cell_count()).collect();
    let mut parts = roots.len();
    for pair in faces.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (a, b) = (root(&mut roots, pair[0].1), root(&mut roots, pair[1].1));
        parts -= usize::from(a != b);
        roots[a.max(b)] = a.min(b);
    }
    parts
}

/// The first cell of a cell's part, as far as parts are joined; shortens the way to it.
fn root(roots: &mut [usize], mut cell: usize) -> usize {
    while roots[cell] != cell {
        roots[cell] = roots[roots[cell]];
        cell = roots[cell];
    }
    cell
}

impl MeshSummary {
    /// The summary for people.
    pub fn rows(&self) -> Vec<(String, String)> {
        let extent = std::array::from_fn(|a| self.high[a] - self.low[a]);
        let [low, high] = [self.low, self.high].map(|x| x.map(number).join(", "));
        let mut rows = vec![
            row("mesh", format!("{} {}, {}", count(self.cells), self.cells_are, counted(self.nodes, "node"))),
            row("extent", format!("{}, from ({low}) to ({high}), in the units of the file", triple(extent))),
        ];
        for tag in &self.tags {
            let name = tag.name.as_ref().map_or_else(String::new, |name| format!(" ({name})"));
            let share = 100.0 * tag.measure / self.measure;
            rows.push(row(&format!("tag {}{name}", tag.tag), format!("{}, {share:.2} %", counted(tag.cells, "cell"))));
        }
        let hang_together = if self.parts == 1 { "one part" } else { "parts that no face joins" };
        let parts = if self.parts == 1 { String::new() } else { format!("{} ", count(self.parts)) };
        rows.push(row("connection", format!("{parts}{hang_together}")));
        rows.push(row("edges", self.edges.map(number).join(" to ")));
        let [worst, mean] = [self.worst_quality, self.mean_quality].map(number);
        let poor = counted(self.poor_cells, "cell");
        rows.push(row("quality", format!("{worst} at worst, {mean} on average (1: regular), {poor} below {POOR}")));
        rows.push(row("fine model", counted(self.unknowns, "unknown")));
        rows.extend(self.direct_bytes.map(|b| row("memory", format!("about {} with a direct solver", bytes(b)))));
        rows.extend(self.skipped.iter().map(|sentence| row("note", sentence)));
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grosgrain::simplex::Dimension;

    #[test]
    fn parts_hang_together_by_faces_not_by_corners() {
        let nodes: Vec<[f64; 3]> =
            [[0, 0], [1, 0], [0, 1], [1, 1], [2, 2], [1, 2]].map(|[x, y]| [f64::from(x), f64::from(y), 0.0]).to_vec();
        let cells = vec![[0, 1, 2, 0], [1, 3, 2, 0], [3, 4, 5, 0]];
        let mesh = SimplexMesh::new(Dimension::Two, nodes, cells, vec![1, 1, 2]).unwrap();
        assert_eq!(parts(&mesh), 2);
        assert_eq!(edges(&mesh), [1.0, 2f64.sqrt()]);
    }
}
