//! Updates of a live model after an edit.

use grosgrain::training::{RunTimeTraining, TrainingKind};
use grosgrain::update::UpdateReport;

use super::cases::Outcome;
use super::cases::updates::UpdateCase;
use super::measure::{Effort, MILLI, digits};
use super::table::Table;

type Make = fn(RunTimeTraining) -> Outcome<UpdateCase>;

/// A case: what it is, its published time, and the limits we set ourselves for substructured and for exact training [ms].
struct Case {
    name: &'static str,
    make: Make,
    published: f64,
    limits: [f64; 2],
}

const CASES: [Case; 2] = [
    Case { name: "beam", make: UpdateCase::beam, published: 461.0, limits: [15.0, 30.0] },
    Case { name: "trunk", make: UpdateCase::trunk, published: 823.0, limits: [33.0, 66.0] },
];

const KINDS: [(&str, RunTimeTraining); 3] = [
    ("auto", RunTimeTraining::Auto { edited_cells: 1 }),
    ("one-ring", RunTimeTraining::Fixed(TrainingKind::OneRing)),
    ("substructured", RunTimeTraining::Fixed(TrainingKind::Substructured)),
];

pub fn section(effort: &Effort) -> Outcome<String> {
    let mut table = Table::new(&[
        "case",
        "training",
        "threads",
        "changed cells",
        "dirty",
        "edit",
        "topology",
        "training, ms",
        "fitting",
        "assembly",
        "whole, ms",
        "limit we set",
        "*published*",
    ]);
    let mut sentences = String::new();
    for case in &CASES {
        for (name, training) in KINDS {
            for threads in [1, 2] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
                let (kind, reports) =
                    pool.install(|| measure(case.make, training, effort)).map_err(|e| e.to_string())?;
                let limit = case.limits[usize::from(name != "substructured")];
                table.row(&row(case, &label(name, kind), threads, &reports, limit));
                if threads == 2 {
                    sentences += &profile(case.name, &label(name, kind), &reports);
                }
            }
        }
    }
    Ok(format!(
        "## Updates after an edit\n\n*Beam*: 6 × 2 × 2 coarse cells of degree 4 in which the two materials trade places, so that all 24 change. *Trunk*: the CT of \
         scenes/torso.toml on 48 × 48 × 36 voxels (degree 2, two materials, 0.1 and 100 MPa), in which a slit one voxel wide through 40 coarse cells opens and closes, which makes \
         216 cells dirty. *Edit*: cells picked, body changed, loose parts searched; *topology*: parts of coarse cells, copies of nodes, dirty cells; *assembly*: \
         stiffness, masses, motion carried over. Medians of the stages and of the whole, which is that of one `LiveModel::apply_all`. Published times are for substructured data \
         and the per-node fit on one thread of another machine.\n\n{}\n{sentences}",
        table.text()
    ))
}

fn label(name: &str, kind: TrainingKind) -> String {
    let chosen = match kind {
        TrainingKind::Global => "global",
        TrainingKind::OneRing => "one-ring",
        TrainingKind::SingleCell => "single-cell",
        TrainingKind::Substructured => "substructured",
    };
    if name == chosen { name.to_owned() } else { format!("{name}: {chosen}") }
}

fn measure(
    make: Make,
    training: RunTimeTraining,
    effort: &Effort,
) -> Result<(TrainingKind, Vec<UpdateReport>), String> {
    let mut case = make(training).map_err(|error| error.to_string())?;
    let mut update = || case.update().map_err(|error| error.to_string());
    update()?;
    update()?;
    let reports: Result<Vec<UpdateReport>, String> = (0..2 * effort.samples).map(|_| update()).collect();
    Ok((case.training(), reports?))
}

fn median(reports: &[UpdateReport], pick: impl Fn(&UpdateReport) -> f64) -> f64 {
    let mut values: Vec<f64> = reports.iter().map(pick).collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn stages(reports: &[UpdateReport]) -> [f64; 5] {
    let pick: [fn(&UpdateReport) -> f64; 5] = [
        |r| r.seconds.edit,
        |r| r.seconds.topology,
        |r| r.seconds.training,
        |r| r.seconds.fitting,
        |r| r.seconds.assembly,
    ];
    pick.map(|pick| median(reports, pick))
}

fn row(case: &Case, training: &str, threads: usize, reports: &[UpdateReport], limit: f64) -> Vec<String> {
    let mut cells = vec![case.name.to_owned(), training.to_owned(), threads.to_string()];
    cells.push(format!("{:.0}", median(reports, |r| r.changed as f64)));
    cells.push(format!("{:.0}", median(reports, |r| r.dirty as f64)));
    cells.extend(stages(reports).map(|s| digits(s / MILLI)));
    cells.push(digits(median(reports, |r| r.seconds.total) / MILLI));
    cells.extend([digits(limit), digits(case.published)]);
    cells
}

fn profile(case: &str, training: &str, reports: &[UpdateReport]) -> String {
    let stages = stages(reports);
    let share = |s: f64| digits(100.0 * s / stages.iter().sum::<f64>());
    format!(
        "Of the {case} with {training} training on two threads, training takes {} %, fitting {} %, assembly {} %, the edit and the topology {} %.\n",
        share(stages[2]),
        share(stages[3]),
        share(stages[4]),
        share(stages[0] + stages[1]),
    )
}
