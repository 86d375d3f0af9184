//! Fig. 4: a bar with a thin slice of soft material, held at one end.

use grosgrain::homogenization::SimplexModel;
use grosgrain::simplex::Dimension;

use super::super::{Findings, Study};
use super::errors::{Case, motion_rows, motion_table, static_rows, static_table};
use super::pair::{Coarse, Fine, GRAVITY, SOFT, STIFF, Task, lattice, static_errors, two_phases};
use super::pictures::{self, Scene};
use super::played::{Steps, play};
use crate::failure::Failure;

/// Name of the artefact.
pub const NAME: &str = "crack";

/// Length and height \[m\].
const SIZE: [f64; 3] = [0.4, 0.1, 1.0];
/// Boxes of the fine mesh: the slice is four wide.
const BOXES: [usize; 3] = [200, 50, 1];
/// Young's modulus \[Pa\] and Poisson's ratio of the bar, and Poisson's ratio of the slice.
const BAR: (f64, f64) = (3e6, 0.3);
const SLICE_POISSON: f64 = 0.4;
/// Half the width \[m\] of the slice in the middle of the bar.
const HALF_WIDTH: f64 = 0.004;

/// Bodies: name, modulus of the bar over that of the slice, depth of the slice over the height of the bar. The first one is shown and moved,
/// the last one tells what the coarse meshes cost by themselves.
const BODIES: [(&str, f64, f64); 7] = [
    ("1000:1, 90 % deep", 1e3, 0.9),
    ("1000:1, 60 % deep", 1e3, 0.6),
    ("1000:1, all through", 1e3, 1.0),
    ("100:1, 90 % deep", 1e2, 0.9),
    ("100:1, 60 % deep", 1e2, 0.6),
    ("100:1, all through", 1e2, 1.0),
    ("no slice", 1.0, 0.0),
];
/// Coarse meshes: boxes along and across. An even number along puts coarse nodes into the slice.
const MESHES: [(&str, [usize; 3]); 5] = [
    ("10 triangles, 5 × 1", [5, 1, 1]),
    ("16 triangles, 4 × 2", [4, 2, 1]),
    ("28 triangles, 7 × 2", [7, 2, 1]),
    ("32 triangles, 8 × 2", [8, 2, 1]),
    ("60 triangles, 10 × 3", [10, 3, 1]),
];
/// Which of [`MESHES`] is shown and moved.
const SHOWN: usize = 4;
const TASK: Task = Task { name: "hanging out", plane: (0, 0.0), acceleration: [0.0, -GRAVITY, 0.0] };
const STEPS: Steps = Steps { length: 0.01, count: 50 };

/// Draws and measures the bar.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let mut found = Findings {
        text: "Fig. 4 of kharevych2009numerical: a bar of triangles with a soft slice from the top, held at one end (no sizes or moduli are published);\n\
               the paper: averages do “not capture this bending behavior”"
            .into(),
        ..Findings::default()
    };
    let mut cases = Vec::new();
    for (number, body) in BODIES.into_iter().enumerate() {
        let fine = Fine::new(study, bar(body)?)?;
        let coarse =
            |(_, boxes): (&str, [usize; 3])| Coarse::new(&fine.model, lattice(Dimension::Two, boxes, SIZE, |_| 0)?);
        let meshes: Vec<Coarse> = MESHES.into_iter().map(coarse).collect::<Result<_, _>>()?;
        if number == 0 {
            moved(study, &fine, &meshes[SHOWN], &mut found)?;
        }
        let errors = static_errors(study, &fine, &meshes, &TASK)?;
        cases.extend(MESHES.iter().zip(errors).map(|((mesh, _), errors)| Case { body: body.0, mesh, errors }));
    }
    found.text += &format!(
        "\nAt rest under its weight: RMS error in percent, small displacements\n{}\ngain: the lesser of the errors of both averages over that of the tensors.",
        static_table(&cases)
    );
    found.rows.extend(static_rows(study, NAME, TASK.name, &cases));
    Ok(found)
}

fn bar((_, contrast, depth): (&str, f64, f64)) -> Result<SimplexModel, Failure> {
    let tag = |x: [f64; 3]| {
        let is_slice = (x[0] - 0.5 * SIZE[0]).abs() < HALF_WIDTH && x[1] > (1.0 - depth) * SIZE[1];
        if is_slice { SOFT } else { STIFF }
    };
    two_phases(lattice(Dimension::Two, BOXES, SIZE, tag)?, (BAR.0 / contrast, SLICE_POISSON), BAR)
}

fn moved(study: &Study, fine: &Fine, coarse: &Coarse, found: &mut Findings) -> Result<(), Failure> {
    let players = play(study, fine, coarse, &TASK, STEPS)?;
    found.text += &format!(
        "\n{}, in motion: {} steps of {} ms, {}, let go at once\n{}\n",
        BODIES[0].0,
        STEPS.count,
        1e3 * STEPS.length,
        MESHES[SHOWN].0,
        motion_table(&players)
    );
    found.rows.extend(motion_rows(study, NAME, (BODIES[0].0, TASK.name), &players));
    if let Some(folder) = &study.folder {
        let scene = Scene { name: NAME, task: TASK.name, title: "A bar with a soft slice, held on the left" };
        found.written.extend(pictures::motion(&scene, (fine, coarse), (&players, STEPS), folder)?);
    }
    Ok(())
}
