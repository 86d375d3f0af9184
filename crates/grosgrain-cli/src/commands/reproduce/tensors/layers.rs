//! Figs. 2, 3 and 5: a cube of soft and stiff layers.

use grosgrain::homogenization::{Downsampling, SimplexModel};
use grosgrain::simplex::{Dimension, MandelTensor};

use super::super::row::{Row, digits};
use super::super::{Findings, Study};
use super::errors::{Case, motion_rows, motion_table, static_rows, static_table};
use super::laminate::{ENTRIES, laminate, mean_entries, stretches};
use super::pair::{Coarse, Fine, GRAVITY, SOFT, STIFF, Task, lattice, static_errors, two_phases};
use super::pictures::{self, Scene};
use super::played::{Player, Steps, play};
use crate::failure::Failure;
use crate::results;

/// Name of the artefact.
pub const NAME: &str = "layers";

/// Edge \[m\].
const EDGE: f64 = 0.1;
/// Boxes of the fine mesh along an edge: two across a layer.
const BOXES: usize = 16;
const LAYERS: usize = 8;
/// Young's modulus \[Pa\] and Poisson's ratio.
const SOFT_PHASE: (f64, f64) = (1e3, 0.4);
const STIFF_POISSON: f64 = 0.25;

/// Where the nodes of coarse meshes lie.
#[derive(Clone, Copy, PartialEq)]
enum Nodes {
    /// Between a layer and the next.
    Between,
    /// In the middle of stiff layers; half a stiff one at the bottom and at the top.
    Stiff,
    /// In the middle of soft layers.
    Soft,
}

/// Bodies: name, stiff over soft modulus, coarse nodes. The first one is shown and moved.
const BODIES: [(&str, f64, Nodes); 6] = [
    ("10:1, coarse nodes in stiff layers", 10.0, Nodes::Stiff),
    ("10:1, in soft layers", 10.0, Nodes::Soft),
    ("10:1, between layers", 10.0, Nodes::Between),
    ("100:1, in stiff layers", 100.0, Nodes::Stiff),
    ("100:1, in soft layers", 100.0, Nodes::Soft),
    ("100:1, between layers", 100.0, Nodes::Between),
];
/// Coarse meshes: boxes along an edge.
const MESHES: [(&str, usize); 2] = [("40 tets", 2), ("320 tets", 4)];

/// What pulls: across the layers, along them, and down from a held side, which shears and bends.
const TASKS: [Task; 3] = [
    Task { name: "across", plane: (2, EDGE), acceleration: [0.0, 0.0, -GRAVITY] },
    Task { name: "along", plane: (0, 0.0), acceleration: [GRAVITY, 0.0, 0.0] },
    Task { name: "sideways", plane: (0, 0.0), acceleration: [0.0, 0.0, -GRAVITY] },
];
const TOLD: [&str; 3] = [
    "top held, pulled down by its weight, across the layers",
    "a side held, pulled by its weight along the layers",
    "a side held, its weight pulls it down, across the layers: it shears and bends",
];
/// Two periods across the layers.
const STEPS: Steps = Steps { length: 0.008, count: 60 };

/// Draws and measures the cube.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let mut found = Findings::default();
    let mut cases = TASKS.map(|_| Vec::new());
    for (number, body) in BODIES.into_iter().enumerate() {
        let fine = Fine::new(study, cube(body)?)?;
        let meshes = MESHES.map(|(_, boxes)| coarse(&fine, boxes));
        let meshes: Vec<Coarse> = meshes.into_iter().collect::<Result<_, _>>()?;
        if number == 0 {
            stretch(study, &fine, &mut found)?;
            inside(study, &fine, &meshes[1], &mut found)?;
            moved(study, &fine, &meshes[0], &mut found)?;
        }
        for (task, cases) in TASKS.iter().zip(&mut cases) {
            let errors = static_errors(study, &fine, &meshes, task)?;
            cases.extend(MESHES.iter().zip(errors).map(|((mesh, _), errors)| Case { body: body.0, mesh, errors }));
        }
    }
    for ((task, told), cases) in TASKS.iter().zip(TOLD).zip(&cases) {
        let title = format!("\nAt rest, {told}: RMS error in percent, small displacements");
        found.text += &format!("{title}\n{}\n", static_table(cases));
        found.rows.extend(static_rows(study, NAME, task.name, cases));
    }
    found.text += "gain: the lesser of the errors of both averages over that of the tensors.";
    Ok(found)
}

fn cube((_, contrast, nodes): (&str, f64, Nodes)) -> Result<SimplexModel, Failure> {
    let tag = |x: [f64; 3]| {
        let height = x[2] / EDGE * LAYERS as f64;
        let is_soft = match nodes {
            Nodes::Between => (height.floor() as usize).is_multiple_of(2),
            Nodes::Soft => ((height + 0.5).floor() as usize).is_multiple_of(2),
            Nodes::Stiff => !((height + 0.5).floor() as usize).is_multiple_of(2),
        };
        if is_soft { SOFT } else { STIFF }
    };
    let mesh = lattice(Dimension::Three, [BOXES; 3], [EDGE; 3], tag)?;
    two_phases(mesh, SOFT_PHASE, (contrast * SOFT_PHASE.0, STIFF_POISSON))
}

fn coarse(fine: &Fine, boxes: usize) -> Result<Coarse, Failure> {
    Coarse::new(&fine.model, lattice(Dimension::Three, [boxes; 3], [EDGE; 3], |_| 0)?)
}

/// Fig. 2: it stretches more across than along.
fn stretch(study: &Study, fine: &Fine, found: &mut Findings) -> Result<(), Failure> {
    let soft = lattice(Dimension::Three, [BOXES; 3], [EDGE; 3], |_| SOFT)?;
    let soft = Fine::new(study, two_phases(soft, SOFT_PHASE, SOFT_PHASE)?)?;
    let mut lines = vec![["cube", "h11", "h22", "h33", "h33 over h11"].map(String::from)];
    for (name, fine) in [("one material", &soft), ("layers", fine)] {
        let [along, other, across] = stretches(&fine.model, &fine.free);
        let of_soft = |stretch: f64| format!("{:.3}", stretch * SOFT_PHASE.0);
        lines.push([name.into(), of_soft(along), of_soft(other), of_soft(across), format!("{:.2}", across / along)]);
        found.rows.push(Row {
            pattern: Some(name),
            measured: Some(across / along),
            note: Some("“it stretches much more vertically than horizontally”".into()),
            ..Row::new(study, NAME, "stretch of h33 over h11", "1")
        });
    }
    found.text += &format!(
        "Figs. 2, 3 and 5 of kharevych2009numerical: a cube of eight layers, every other one ten times as stiff (no sizes or moduli are published)\n\
         Mean stretch in harmonic displacements, over that of the soft material pulled alone; the paper: “it stretches much more vertically than horizontally”\n{}\n",
        results::columns(&lines)
    );
    if let Some(folder) = &study.folder {
        found.written.push(pictures::harmonic(&[("one material", &soft), ("layers", fine)], folder)?);
    }
    Ok(())
}

/// Tensors of the cells in the middle beside the closed form.
fn inside(study: &Study, fine: &Fine, coarse: &Coarse, found: &mut Findings) -> Result<(), Failure> {
    let tensors = coarse.effective(&fine.model, &fine.free, Downsampling::AtNodes)?;
    let is_inner = |cell: &usize| {
        let quarter = 0.25 * EDGE * (1.0 - 1e-9);
        coarse.mesh.centre(*cell).iter().all(|x| (quarter..EDGE - quarter).contains(x))
    };
    let inner: Vec<MandelTensor> = (0..tensors.len()).filter(is_inner).map(|cell| tensors[cell]).collect();
    let exact = laminate([SOFT_PHASE, (BODIES[0].1 * SOFT_PHASE.0, STIFF_POISSON)]);
    let mut lines = vec![["entry", "of layers [Pa]", "mean of inner tets [Pa]", "ratio"].map(String::from)];
    for (((name, _, _), exact), mean) in ENTRIES.into_iter().zip(exact).zip(mean_entries(&inner)) {
        lines.push([name.into(), digits(exact), digits(mean), format!("{:.3}", mean / exact)]);
        found.rows.push(Row {
            pattern: Some(name),
            measured: Some(mean / exact),
            note: Some(format!("closed form {exact:.6e} Pa, mean of {} inner tets {mean:.6e} Pa", inner.len())),
            ..Row::new(study, NAME, "inner tensors over those of layers", "1")
        });
    }
    found.text += &format!(
        "\nThe {} tets in the middle of {}, beside the closed form of endless layers\n{}\n",
        inner.len(),
        MESHES[1].0,
        results::columns(&lines)
    );
    Ok(())
}

/// Fig. 5: motions across and along the layers.
fn moved(study: &Study, fine: &Fine, coarse: &Coarse, found: &mut Findings) -> Result<(), Failure> {
    for (task, told) in TASKS[..2].iter().zip(TOLD) {
        let players: Vec<Player> = play(study, fine, coarse, task, STEPS)?;
        found.text += &format!(
            "\nIn motion, {told}: {} steps of {} ms, {}, let go at once\n{}\n",
            STEPS.count,
            1e3 * STEPS.length,
            MESHES[0].0,
            motion_table(&players)
        );
        found.rows.extend(motion_rows(study, NAME, (BODIES[0].0, task.name), &players));
        if let Some(folder) = &study.folder {
            let title = format!("Layered cube, {told}");
            let scene = Scene { name: NAME, task: task.name, title: &title };
            found.written.extend(pictures::motion(&scene, (fine, coarse), (&players, STEPS), folder)?);
        }
    }
    Ok(())
}
