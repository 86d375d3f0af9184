//! Table 2: times of the training data of one interior cell.

use std::sync::Arc;

use grosgrain::partition::{CellPart, CoarseCell, CoarseMesh, Partition};
use grosgrain::progress::silent;
use grosgrain::solver::SolverChoice;
use grosgrain::training::{
    HarmonicDisplacements, InterfaceForces, InterfaceSpace, LocalTrainer, RingKind, Substructures,
};

use super::bodies::{Heterogeneity, fine_model};
use super::row::{Row, digits, or_dash};
use super::{Findings, Study, pictures};
use crate::failure::Failure;
use crate::results;
use crate::timing::{Spread, measure};

const NAME: &str = "table2";
/// The middle one of 3 × 3 × 3 coarse cells.
const CENTRE: CoarseCell = CoarseCell(13);
/// Published milliseconds at d = 2 … 7, in the order of [`DataKind::ALL`].
const PUBLISHED: [[f64; 3]; 6] = [
    [10.3, 0.2, 1.8],
    [92.5, 0.8, 4.9],
    [804.0, 2.0, 8.5],
    [3.3e3, 4.9, 16.3],
    [11.6e3, 11.4, 36.4],
    [28.9e3, 22.9, 82.2],
];

/// A kind of training data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DataKind {
    /// The paper's oversampling.
    OneRing,
    SingleCell,
    /// The paper's own.
    Substructured,
}

impl DataKind {
    const ALL: [Self; 3] = [Self::OneRing, Self::SingleCell, Self::Substructured];

    const fn name(self) -> &'static str {
        match self {
            Self::OneRing => "one-ring",
            Self::SingleCell => "single-cell",
            Self::Substructured => "substructured",
        }
    }

    fn published(self, degree: usize) -> Option<f64> {
        Some(PUBLISHED.get(degree.checked_sub(2)?)?[self as usize])
    }
}

/// Seconds for the training data of the middle cell on this thread.
///
/// Every time of Table 2 comes from here; what depends on the shape of the problem only is prepared before the clock starts. For substructured
/// data the cell has changed: it is condensed anew, then its ring is solved.
fn time(degree: usize, kind: DataKind) -> Result<Spread, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::Failed(error.to_string());
    let model = fine_model(Heterogeneity::Oblique.ring(degree)?)?;
    let partition = Partition::new(model.grid().lattice, degree).map_err(|error| failed(&error))?;
    let mesh = CoarseMesh::new(&model.grid().void, &partition);
    let parts = [CellPart::whole(CENTRE)];
    let local = |ring| {
        let trainer = LocalTrainer::new(&partition, ring);
        measure(|| trainer.train_cell(&model, &mesh, &parts).map_err(|error| failed(&error)))
    };
    match kind {
        DataKind::OneRing => local(RingKind::OneRing),
        DataKind::SingleCell => local(RingKind::SingleCell),
        DataKind::Substructured => {
            let harmonic = HarmonicDisplacements::solve(&model, SolverChoice::Auto, &silent);
            let harmonic = harmonic.map_err(|error| failed(&error))?;
            let forces = Arc::new(InterfaceForces::new(&model, &partition, &harmonic));
            let mut substructures = Substructures::new(&model, forces, InterfaceSpace::default());
            measure(|| {
                substructures.renew(&model, &[CENTRE]);
                let data = substructures.train_cell(&model, &mesh, &parts);
                data.ok_or_else(|| Failure::Failed("the ring has no substructures".into()))
            })
        }
    }
}

/// Times every kind on one thread.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one_thread = one_thread.map_err(|error| Failure::Failed(format!("a thread cannot be started: {error}")))?;
    let mut rows = Vec::new();
    for &degree in &study.degrees {
        let mut of_degree = Vec::new();
        for kind in DataKind::ALL {
            study.progress.say(&format!("d = {degree}: {}", kind.name()));
            let spread = one_thread.install(|| time(degree, kind))?;
            of_degree.push(Row {
                degree: Some(degree),
                method: Some(kind.name()),
                ..Row::time(study, NAME, kind.published(degree), Some(spread))
            });
        }
        let ratios = over_single_cell(study, &of_degree);
        rows.extend(of_degree.into_iter().chain(ratios));
    }
    let written = match &study.folder {
        Some(folder) => {
            let methods = DataKind::ALL.map(DataKind::name);
            vec![pictures::time_chart("Training data of one cell", &rows, &methods, &folder.join("table2.png"))?]
        }
        None => Vec::new(),
    };
    Ok(Findings { text: text(study, &rows), rows, written, ..Findings::default() })
}

/// Times over that of the single cell, which do not depend on the machine as much.
fn over_single_cell(study: &Study, times: &[Row]) -> Vec<Row> {
    let Some(single) = times.iter().find(|row| row.method == Some(DataKind::SingleCell.name())) else {
        return Vec::new();
    };
    let others = times.iter().filter(|row| row.method != single.method);
    let ratio = |row: &Row| Row {
        degree: row.degree,
        method: row.method,
        published: row.published.zip(single.published).map(|(a, b)| a / b),
        measured: row.measured.zip(single.measured).map(|(a, b)| a / b),
        machine: row.machine.clone(),
        note: row.note.clone(),
        ..Row::new(study, NAME, "time over single-cell", "1")
    };
    others.map(ratio).collect()
}

fn text(study: &Study, rows: &[Row]) -> String {
    let cells = |degree: usize, quantity: &str, kind: DataKind| -> [String; 2] {
        let is_it = |row: &&Row| (row.degree, row.quantity, row.method) == (Some(degree), quantity, Some(kind.name()));
        let row = rows.iter().find(is_it);
        [row.and_then(|r| r.measured), row.and_then(|r| r.published)].map(|value| or_dash(value, digits))
    };
    let [ring, single, substructured] = DataKind::ALL;
    let mut times = vec![
        ["d", "one-ring", "published", "single-cell", "published", "substructured", "published"].map(String::from),
    ];
    let mut ratios = vec![["d", "one-ring", "published", "substructured", "published"].map(String::from)];
    for &degree in &study.degrees {
        let [[a, b], [c, d], [e, f]] = [ring, single, substructured].map(|kind| cells(degree, "time", kind));
        times.push([degree.to_string(), a, b, c, d, e, f]);
        let [[a, b], [c, d]] = [ring, substructured].map(|kind| cells(degree, "time over single-cell", kind));
        ratios.push([degree.to_string(), a, b, c, d]);
    }
    format!(
        "Table 2 of he2022fast: milliseconds for the training data of one cell surrounded by 26, one thread\n{}\n\
         over the single cell's time\n{}\n\
         the paper says about 3.5 for substructured, and less than one-ring by two orders of magnitude after d = 4\n\
         machine: {}; published: Intel Core i7-10750H, one thread",
        results::columns(&times),
        results::columns(&ratios),
        study.machine.processor,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_times_are_those_of_the_paper() {
        assert_eq!(DataKind::ALL.map(|kind| kind.published(4)), [Some(804.0), Some(2.0), Some(8.5)]);
        assert_eq!(DataKind::Substructured.published(7), Some(82.2));
        assert_eq!((DataKind::OneRing.published(1), DataKind::OneRing.published(8)), (None, None));
    }
}
