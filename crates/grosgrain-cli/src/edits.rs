//! Making the edits of a step on the body of a problem.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use grosgrain::mesh::Cell;
use grosgrain::update::{Applied, Batch, Editor, LooseReport};

use crate::failure::Failure;
use crate::problem::Problem;
use crate::progress::Progress;
use crate::quantities::counted;
use crate::report::Edit;

/// What the edits of a step have made.
#[derive(Debug)]
pub struct Made {
    /// The fine cells that are something else than before, ascending.
    pub changed: Vec<Cell>,
    /// The row of the report, with nothing of what models did.
    pub row: Edit,
    /// Whether parts were cut loose and stay.
    pub loose_kept: bool,
    /// Seconds that it took.
    pub seconds: f64,
}

/// Makes the edits of a step; `None` where none are due. `known` tells parts and cells that hung on nothing before: the user has heard of them.
///
/// # Errors
/// Edits that the body refuses.
pub fn make(
    problem: &mut Problem,
    number: usize,
    (editor, known): (&mut Editor, [usize; 2]),
    progress: &Progress,
) -> Result<Option<Made>, Failure> {
    let due = problem.schedule.due(number);
    if due.is_empty() {
        return Ok(None);
    }
    let start = Instant::now();
    let refuse = |problem: &Problem, key: &str, error: &dyn std::fmt::Display| {
        Failure::Failed(format!("{}: step {number}: {key}: {error}", problem.scene.file.display()))
    };
    let mut warnings = Vec::new();
    let mut batch = Batch::new(&problem.model);
    for edit in &due {
        match batch.add(&edit.edit) {
            Ok(()) => {}
            Err(error) if error.finds_nothing() => warnings.push(format!("step {number}: {}: {error}", edit.key)),
            Err(error) => return Err(refuse(problem, &edit.key, &error)),
        }
    }
    let resolved = batch.finish().map_err(|error| refuse(problem, "edit", &error))?;
    let Problem { model, fixed, .. } = problem;
    let (changed, loose) = match editor.apply(model, &resolved, fixed) {
        Ok(Applied { changed, loose }) => (changed.to_vec(), loose),
        Err(error) => return Err(refuse(problem, "edit", &error)),
    };
    if [loose.parts, loose.cells] != known {
        warnings.extend(told(number, &loose, problem.scene.is_dynamic()));
    }
    warnings.iter().for_each(|warning| progress.warn(warning));
    let row = Edit {
        step: number,
        changed_cells: coarse_cells(problem, &changed),
        changed_fine_cells: changed.len(),
        dirty_cells: 0,
        loose_parts: loose.parts,
        loose_cells: loose.cells,
        warnings,
        seconds: BTreeMap::new(),
    };
    let loose_kept = loose.parts > 0 && !loose.dropped;
    Ok(Some(Made { changed, row, loose_kept, seconds: start.elapsed().as_secs_f64() }))
}

/// Number of coarse cells that hold any of these fine cells.
fn coarse_cells(problem: &Problem, changed: &[Cell]) -> usize {
    let (lattice, degree) = (problem.model.grid().lattice, problem.scene.coarsening.degree);
    let holder = |cell: &Cell| lattice.cell_position(*cell).map(|x| x / degree);
    changed.iter().map(holder).collect::<BTreeSet<_>>().len()
}

/// What the user should know of parts that were cut loose.
fn told(step: usize, loose: &LooseReport, dynamic: bool) -> Option<String> {
    let (parts, cells) = (counted(loose.parts, "part"), counted(loose.cells, "cell"));
    let verb = if loose.parts == 1 { "hangs" } else { "hang" };
    let then = match loose.dropped {
        true => "left out from now on (body.loose = \"keep\" keeps them)",
        false if dynamic => "free to move",
        false => "kept where they are, without displacement, since nothing static holds them",
    };
    (loose.parts > 0).then(|| format!("step {step}: {parts} with {cells} {verb} on nothing; {then}"))
}
