//! Frames for ParaView: the embedded fine body and the coarse mesh.

use std::path::{Path, PathBuf};

use grosgrain::coarse::CoarseModel;
use grosgrain::fine::{FineModel, cauchy_stresses, von_mises};
use grosgrain::io::vtk::{DataArray, Frame, UnstructuredGrid, Values, VtkError, write_pvd, write_vtu};
use grosgrain::io::write_atomically;
use grosgrain::mesh::{Cell, Node};

use crate::failure::Failure;
use crate::problem::Problem;

/// What a frame shows.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// Number of its step.
    pub number: usize,
    /// Its time \[s\].
    pub time: f64,
    /// Displacement \[m\] of the fine nodes, three per lattice node.
    pub displacement: &'a [f64],
    /// Their velocity \[m/s\]; `None` for zero.
    pub velocity: Option<&'a [f64]>,
    /// The fine model's displacement \[m\], where the one that is shown is compared with it.
    pub reference: Option<&'a [f64]>,
    /// The coarse mesh, where there is one.
    pub coarse: Option<ShownCoarse<'a>>,
}

/// The coarse mesh of a frame.
#[derive(Clone, Copy, Debug)]
pub struct ShownCoarse<'a> {
    /// The model.
    pub model: &'a CoarseModel,
    /// Displacement \[m\] of its vertices.
    pub displacement: &'a [f64],
    /// Their velocity \[m/s\]; `None` for zero.
    pub velocity: Option<&'a [f64]>,
}

/// The frames of a run, which grow step by step.
#[derive(Debug)]
pub struct Frames {
    folder: PathBuf,
    /// Times \[s\] and files of the body's frames.
    body: Vec<(f64, String)>,
    /// The same of the coarse mesh.
    coarse: Vec<(f64, String)>,
}

impl Frames {
    /// No frames yet; they go into `folder`.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf(), body: Vec::new(), coarse: Vec::new() }
    }

    /// Writes the frame of a step: `body_NNNN.vtu`, and `coarse_NNNN.vtu` where there is a coarse model. The series `body.pvd`
    /// and `coarse.pvd` list all frames so far. Returns the number of cells that are inverted, for which `von_mises` is zero.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn add(&mut self, problem: &Problem, shown: &Shown<'_>) -> Result<usize, Failure> {
        let coarse = shown.coarse.as_ref();
        let body = FineBody::new(&problem.model, coarse.map(|coarse| coarse.model), shown.time);
        let stresses = cauchy_stresses(&problem.model, shown.displacement);
        let mises: Vec<f64> = body.cells.iter().map(|&c| von_mises(&stresses[c])).collect();
        let inverted = mises.iter().filter(|mises| mises.is_nan()).count();
        let mises: Vec<f64> = mises.into_iter().map(|mises| if mises.is_nan() { 0.0 } else { mises }).collect();
        let write = |path: &Path| body.write(path, &problem.model, shown, &mises);
        let at = (shown.number, shown.time);
        series(&self.folder, "body", at, &mut self.body, write)?;
        if let Some(coarse) = coarse {
            let write = |path: &Path| write_coarse(path, problem, coarse, shown.time);
            series(&self.folder, "coarse", at, &mut self.coarse, write)?;
        }
        Ok(inverted)
    }

    /// The series that were written.
    pub fn written(&self) -> Vec<PathBuf> {
        let series = [("body.pvd", &self.body), ("coarse.pvd", &self.coarse)];
        series.iter().filter(|(_, frames)| !frames.is_empty()).map(|(name, _)| self.folder.join(name)).collect()
    }
}

/// Writes the frame `name_NNNN.vtu` of a step and its time \[s\], and the series `name.pvd` that lists it after those before it.
pub(crate) fn series(
    folder: &Path,
    name: &str,
    (number, time): (usize, f64),
    before: &mut Vec<(f64, String)>,
    write_frame: impl FnOnce(&Path) -> Result<(), VtkError>,
) -> Result<(), Failure> {
    let failed = |path: &Path, error: VtkError| Failure::Failed(format!("{}: {error}", path.display()));
    let file = format!("{name}_{number:04}.vtu");
    let path = folder.join(&file);
    write_frame(&path).map_err(|error| failed(&path, error))?;
    before.push((time, file));
    let list = folder.join(format!("{name}.pvd"));
    let frames: Vec<Frame> = before.iter().map(|(time, file)| Frame { time: *time, file }).collect();
    write_atomically(&list, |writer| write_pvd(writer, &frames)).map_err(|error| failed(&list, error))
}

/// The solid cells of the fine lattice and the nodes they touch.
struct FineBody {
    nodes: Vec<usize>,
    points: Vec<[f64; 3]>,
    cells: Vec<usize>,
    hexahedra: Vec<[usize; 8]>,
    coarse_cell: Vec<i32>,
    time: f64,
}

impl FineBody {
    fn new(model: &FineModel, coarse: Option<&CoarseModel>, time: f64) -> Self {
        let lattice = model.grid().lattice;
        let nodes: Vec<usize> = (0..lattice.node_count()).filter(|&n| model.active()[n]).collect();
        let mut row_of = vec![0; lattice.node_count()];
        nodes.iter().enumerate().for_each(|(row, &n)| row_of[n] = row);
        let cells: Vec<usize> = (0..lattice.cell_count()).filter(|&c| !model.is_void(Cell(c))).collect();
        let hexahedra = cells.iter().map(|&c| lattice.corners(Cell(c)).map(|n| row_of[n.0])).collect();
        let points = nodes.iter().map(|&n| model.node_position(Node(n))).collect();
        let coarse_cell = cells.iter().map(|&c| coarse.map_or(-1, |coarse| coarse_cell_of(coarse, Cell(c)))).collect();
        Self { nodes, points, cells, hexahedra, coarse_cell, time }
    }

    fn write(
        &self,
        path: &Path,
        model: &FineModel,
        &Shown { displacement, velocity, reference, .. }: &Shown<'_>,
        mises: &[f64],
    ) -> Result<(), VtkError> {
        let vectors: Vec<[f64; 3]> = self.nodes.iter().map(|&n| vector(displacement, n)).collect();
        let moving = |n: usize| velocity.map_or([0.0; 3], |velocity| vector(velocity, n));
        let velocities: Vec<[f64; 3]> = self.nodes.iter().map(|&n| moving(n)).collect();
        let labels: Vec<i32> = self.cells.iter().map(|&c| model.grid().labels[c].0).collect();
        let young: Vec<f64> = self.cells.iter().map(|&c| model.young(Cell(c))).collect();
        let error: Option<Vec<[f64; 3]>> = reference.map(|reference| {
            let difference = |n: usize| {
                let (u, v) = (vector(displacement, n), vector(reference, n));
                [0, 1, 2].map(|r| u[r] - v[r])
            };
            self.nodes.iter().map(|&n| difference(n)).collect()
        });
        let mut point_data =
            vec![array("displacement", Values::Vector(&vectors)), array("velocity", Values::Vector(&velocities))];
        point_data.extend(error.as_ref().map(|error| array("error", Values::Vector(error))));
        let cell_data = vec![
            array("label", Values::Integer(&labels)),
            array("young", Values::Scalar(&young)),
            array("coarse_cell", Values::Integer(&self.coarse_cell)),
            array("von_mises", Values::Scalar(mises)),
        ];
        let grid = UnstructuredGrid {
            points: &self.points,
            hexahedra: &self.hexahedra,
            point_data,
            cell_data,
            time: Some(self.time),
        };
        write_atomically(path, |writer| write_vtu(writer, &grid))
    }
}

fn write_coarse(
    path: &Path,
    problem: &Problem,
    &ShownCoarse { model: coarse, displacement, velocity }: &ShownCoarse<'_>,
    time: f64,
) -> Result<(), VtkError> {
    let mesh = coarse.mesh();
    let position = |node| problem.model.node_position(mesh.partition().coincident_node(node));
    let points: Vec<[f64; 3]> = mesh.vertices().iter().map(|vertex| position(vertex.node)).collect();
    let hexahedra: Vec<[usize; 8]> = mesh.corners().iter().map(|corners| corners.map(|v| v as usize)).collect();
    let vectors: Vec<[f64; 3]> = (0..points.len()).map(|vertex| vector(displacement, vertex)).collect();
    let moving = |vertex: usize| velocity.map_or([0.0; 3], |velocity| vector(velocity, vertex));
    let velocities: Vec<[f64; 3]> = (0..points.len()).map(moving).collect();
    let number: Vec<i32> = (0..hexahedra.len() as i32).collect();
    let grid = UnstructuredGrid {
        points: &points,
        hexahedra: &hexahedra,
        point_data: vec![
            array("displacement", Values::Vector(&vectors)),
            array("velocity", Values::Vector(&velocities)),
            array("mass", Values::Scalar(coarse.mass())),
        ],
        cell_data: vec![array("coarse_cell", Values::Integer(&number))],
        time: Some(time),
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
