//! Frames for ParaView: the embedded fine body and the coarse mesh.

use std::path::{Path, PathBuf};

use grosgrain::coarse::CoarseModel;
use grosgrain::fine::{FineModel, centre_stresses, von_mises};
use grosgrain::io::vtk::{DataArray, Frame, UnstructuredGrid, Values, VtkError, write_pvd, write_vtu};
use grosgrain::io::write_atomically;
use grosgrain::mesh::{Cell, Node};

use crate::failure::Failure;
use crate::outcome::{CoarseRun, FineRun};
use crate::problem::Problem;

/// Writes `body.pvd` with its frame, and `coarse.pvd` where there is a coarse model; returns what was written.
///
/// # Errors
/// Files that cannot be written.
pub fn write(
    problem: &Problem,
    coarse: Option<&CoarseRun>,
    fine: Option<&FineRun>,
    folder: &Path,
) -> Result<Vec<PathBuf>, Failure> {
    let reference = fine.map(|run| run.solution.displacement.as_slice());
    let mut written = Vec::new();
    let shown = coarse.map(|run| run.solution.displacement.as_slice()).or(reference);
    if let Some(displacement) = shown {
        let error = coarse.and(reference);
        let body = FineBody::new(&problem.model, coarse.map(|run| &run.built.model));
        written.push(series(folder, "body", |path| body.write(path, &problem.model, displacement, error))?);
    }
    if let Some(run) = coarse {
        let displacement = &run.solution.coarse_displacement;
        written.push(series(folder, "coarse", |path| write_coarse(path, problem, &run.built.model, displacement))?);
    }
    Ok(written)
}

/// Writes the frame `name_0000.vtu` and the series `name.pvd` that lists it.
fn series(
    folder: &Path,
    name: &str,
    write_frame: impl FnOnce(&Path) -> Result<(), VtkError>,
) -> Result<PathBuf, Failure> {
    let failed = |path: &Path, error: VtkError| Failure::Failed(format!("{}: {error}", path.display()));
    let file = format!("{name}_0000.vtu");
    let path = folder.join(&file);
    write_frame(&path).map_err(|error| failed(&path, error))?;
    let list = folder.join(format!("{name}.pvd"));
    let frames = [Frame { time: 0.0, file: &file }];
    write_atomically(&list, |writer| write_pvd(writer, &frames)).map_err(|error| failed(&list, error))?;
    Ok(list)
}

/// The solid cells of the fine lattice and the nodes they touch.
struct FineBody {
    nodes: Vec<usize>,
    points: Vec<[f64; 3]>,
    cells: Vec<usize>,
    hexahedra: Vec<[usize; 8]>,
    coarse_cell: Vec<i32>,
}

impl FineBody {
    fn new(model: &FineModel, coarse: Option<&CoarseModel>) -> Self {
        let lattice = model.grid().lattice;
        let nodes: Vec<usize> = (0..lattice.node_count()).filter(|&n| model.active()[n]).collect();
        let mut row_of = vec![0; lattice.node_count()];
        nodes.iter().enumerate().for_each(|(row, &n)| row_of[n] = row);
        let cells: Vec<usize> = (0..lattice.cell_count()).filter(|&c| !model.is_void(Cell(c))).collect();
        let hexahedra = cells.iter().map(|&c| lattice.corners(Cell(c)).map(|n| row_of[n.0])).collect();
        let points = nodes.iter().map(|&n| model.node_position(Node(n))).collect();
        let coarse_cell = cells.iter().map(|&c| coarse.map_or(-1, |coarse| coarse_cell_of(coarse, Cell(c)))).collect();
        Self { nodes, points, cells, hexahedra, coarse_cell }
    }

    fn write(
        &self,
        path: &Path,
        model: &FineModel,
        displacement: &[f64],
        reference: Option<&[f64]>,
    ) -> Result<(), VtkError> {
        let vectors: Vec<[f64; 3]> = self.nodes.iter().map(|&n| vector(displacement, n)).collect();
        let still = vec![[0.0; 3]; self.nodes.len()];
        let stresses = centre_stresses(model, displacement);
        let labels: Vec<i32> = self.cells.iter().map(|&c| model.grid().labels[c].0).collect();
        let young: Vec<f64> = self.cells.iter().map(|&c| model.young(Cell(c))).collect();
        let mises: Vec<f64> = self.cells.iter().map(|&c| von_mises(&stresses[c])).collect();
        let error: Option<Vec<[f64; 3]>> = reference.map(|reference| {
            let difference = |n: usize| {
                let (u, v) = (vector(displacement, n), vector(reference, n));
                [0, 1, 2].map(|r| u[r] - v[r])
            };
            self.nodes.iter().map(|&n| difference(n)).collect()
        });
        let mut point_data =
            vec![array("displacement", Values::Vector(&vectors)), array("velocity", Values::Vector(&still))];
        point_data.extend(error.as_ref().map(|error| array("error", Values::Vector(error))));
        let cell_data = vec![
            array("label", Values::Integer(&labels)),
            array("young", Values::Scalar(&young)),
            array("coarse_cell", Values::Integer(&self.coarse_cell)),
            array("von_mises", Values::Scalar(&mises)),
        ];
        let grid = UnstructuredGrid {
            points: &self.points,
            hexahedra: &self.hexahedra,
            point_data,
            cell_data,
            time: Some(0.0),
        };
        write_atomically(path, |writer| write_vtu(writer, &grid))
    }
}

fn write_coarse(path: &Path, problem: &Problem, coarse: &CoarseModel, displacement: &[f64]) -> Result<(), VtkError> {
    let mesh = coarse.mesh();
    let position = |node| problem.model.node_position(mesh.partition().coincident_node(node));
    let points: Vec<[f64; 3]> = mesh.vertices().iter().map(|vertex| position(vertex.node)).collect();
    let hexahedra: Vec<[usize; 8]> = mesh.corners().iter().map(|corners| corners.map(|v| v as usize)).collect();
    let vectors: Vec<[f64; 3]> = (0..points.len()).map(|vertex| vector(displacement, vertex)).collect();
    let still = vec![[0.0; 3]; points.len()];
    let number: Vec<i32> = (0..hexahedra.len() as i32).collect();
    let grid = UnstructuredGrid {
        points: &points,
        hexahedra: &hexahedra,
        point_data: vec![
            array("displacement", Values::Vector(&vectors)),
            array("velocity", Values::Vector(&still)),
            array("mass", Values::Scalar(coarse.mass())),
        ],
        cell_data: vec![array("coarse_cell", Values::Integer(&number))],
        time: Some(0.0),
    };
    write_atomically(path, |writer| write_vtu(writer, &grid))
}

fn coarse_cell_of(coarse: &CoarseModel, cell: Cell) -> i32 {
    coarse.mesh().element_at(cell).map_or(-1, |index| index as i32)
}

fn vector(field: &[f64], node: usize) -> [f64; 3] {
    [field[3 * node], field[3 * node + 1], field[3 * node + 2]]
}

const fn array<'a>(name: &'a str, values: Values<'a>) -> DataArray<'a> {
    DataArray { name, values }
}
