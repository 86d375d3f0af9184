//! Updates of a live model: a small beam that changes everywhere, and a cut through a CT volume.

use std::path::Path;

use grosgrain::fine::FineModel;
use grosgrain::io::read_volume;
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Cell, Label, LabelRule, VoxelGrid, keep_largest, label_by_rules, resample};
use grosgrain::partition::Partition;
use grosgrain::progress::silent;
use grosgrain::training::{RunTimeTraining, TrainingKind};
use grosgrain::update::{Change, Edit, LiveModel, LiveOptions, LooseParts, Region, UpdateReport};

use super::{Outcome, RATIO, layered};

/// A live model and the two edits between which it goes to and fro.
pub struct UpdateCase {
    model: LiveModel,
    edits: [Vec<Edit>; 2],
    next: usize,
}

impl UpdateCase {
    /// The beam of the papers' first figure, 6 × 2 × 2 coarse cells of degree 4, in which the two materials trade places.
    pub fn beam(training: RunTimeTraining) -> Outcome<Self> {
        let fine = layered([24, 8, 8], RATIO)?;
        let cells = |label: i32| -> Vec<Cell> {
            let labels = &fine.grid().labels;
            (0..labels.len()).filter(|c| labels[*c] == Label(label)).map(Cell).collect()
        };
        let set = |cells: &[Cell], label: i32| Edit {
            region: Region::Cells(cells.to_vec()),
            change: Change::Material(Label(label)),
        };
        let (soft, stiff) = (cells(1), cells(2));
        let edits = [vec![set(&soft, 2), set(&stiff, 1)], vec![set(&soft, 1), set(&stiff, 2)]];
        Self::new(fine, 4, training, edits)
    }

    /// A trunk from a CT, 48 × 48 × 36 voxels of two materials (0.1 and 100 MPa) in coarse cells of degree 2, in which a blade opens and closes
    /// a slit one voxel wide: 40 coarse cells change, which makes 216 dirty.
    pub fn trunk(training: RunTimeTraining) -> Outcome<Self> {
        let grid = trunk_on([48, 48, 36])?;
        let partition = Partition::new(grid.lattice, 2)?;
        let slit = slit(&grid, &partition).ok_or("the trunk has no place for the slit")?;
        let mut table = MaterialTable::new();
        for (label, young) in [(1, 1e5), (2, 1e8)] {
            let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(young, 0.45)?);
            table.insert(Label(label), Material::linear(format!("tissue {label}"), elasticity, 1000.0));
        }
        let labels: Vec<(Cell, Label)> = slit.iter().map(|cell| (*cell, grid.labels[cell.0])).collect();
        let refill = |label: i32| {
            let cells: Vec<Cell> = labels.iter().filter(|(_, l)| *l == Label(label)).map(|(c, _)| *c).collect();
            Edit { region: Region::Cells(cells), change: Change::Add(Label(label)) }
        };
        let is_used = |edit: &Edit| !matches!(&edit.region, Region::Cells(cells) if cells.is_empty());
        let close = [1, 2].map(refill).into_iter().filter(is_used).collect();
        let open = vec![Edit { region: Region::Cells(slit), change: Change::Remove }];
        Self::new(FineModel::new(grid, &table)?, 2, training, [open, close])
    }

    fn new(fine: FineModel, degree: usize, training: RunTimeTraining, edits: [Vec<Edit>; 2]) -> Outcome<Self> {
        let nodes = fine.grid().lattice.node_count();
        let options = LiveOptions { training, loose: LooseParts::Keep, ..LiveOptions::default() };
        let model = LiveModel::new(fine, degree, &options, vec![false; nodes], &silent)?;
        Ok(Self { model, edits, next: 0 })
    }

    /// The training in use.
    pub fn training(&self) -> TrainingKind {
        self.model.training()
    }

    /// Makes the next edit.
    pub fn update(&mut self) -> Outcome<UpdateReport> {
        let report = self.model.apply_all(&self.edits[self.next], &silent)?;
        self.next = 1 - self.next;
        Ok(report)
    }
}

/// The CT of the torso scene, on so many voxels.
pub fn trunk_on(cells: [usize; 3]) -> Outcome<VoxelGrid> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/ct_torso/example_ct.nii.gz");
    let volume = read_volume(&file)?;
    let rule =
        |label: i32, below: Option<f64>, void: bool| LabelRule { label: Label(label), below, values: None, void };
    let rules = [rule(0, Some(-300.0), true), rule(1, Some(150.0), false), rule(2, None, false)];
    let grid = label_by_rules(&volume, &rules, volume.spacing.ok_or("the CT has no spacing")?)?;
    let mut grid = resample(&grid, cells, &[Label(0), Label(1), Label(2)])?;
    keep_largest(&mut grid);
    Ok(grid)
}

/// One layer of voxels through 10 × 4 coarse cells of a plane whose neighbours on all sides are solid.
fn slit(grid: &VoxelGrid, partition: &Partition) -> Option<Vec<Cell>> {
    let coarse = partition.coarse().cells;
    let (around, inside) = ([12, 3, 6], [10, 1, 4]);
    let solid = |start: [usize; 3], size: [usize; 3]| {
        let cells = (0..size.iter().product::<usize>())
            .map(move |n| [n % size[0], n / size[0] % size[1], n / size[0] / size[1]]);
        cells.map(move |at| -> [usize; 3] { std::array::from_fn(|a| start[a] + at[a]) })
    };
    let is_free = |start: &[usize; 3]| {
        let fine: [usize; 3] = std::array::from_fn(|a| 2 * around[a]);
        solid(start.map(|x| 2 * x), fine).all(|at| !grid.void[grid.lattice.cell(at).0])
    };
    let places = coarse
        .iter()
        .zip(around)
        .map(|(n, size)| n.checked_sub(size).map(|rest| rest + 1))
        .collect::<Option<Vec<usize>>>()?;
    let start = solid([0; 3], [places[0], places[1], places[2]]).find(is_free)?;
    let first = start.map(|x| 2 * (x + 1));
    let layer = [2 * inside[0], 1, 2 * inside[2]];
    Some(solid(first, layer).map(|at| grid.lattice.cell(at)).collect())
}
