//! Steps in time, coarse and fine.

use grosgrain::coarse::{CoarseModel, Integration};
use grosgrain::dynamics::{StepOptions, StepReport};

use super::cases::Outcome;
use super::cases::steps::{MovingBody, Steps};
use super::machine::Machine;
use super::measure::{Effort, MILLI, Spread, digits};
use super::table::Table;

type Make = fn() -> Outcome<MovingBody>;

/// A body, and the time we allow for a coarse step by the stiffness [ms] or, for the last one, the speed-up over fine that we ask for.
const BODIES: [(Make, &str); 3] =
    [(MovingBody::beam, "≤ 5 ms"), (MovingBody::plate, "≤ 10 ms"), (MovingBody::trunk, "30 × fine")];

const KINDS: [(&str, Option<Integration>); 4] = [
    ("stiffness", Some(Integration::Stiffness)),
    ("centre", Some(Integration::Centre)),
    ("Gauss", Some(Integration::Gauss)),
    ("fine", None),
];

/// Mean costs of a step.
struct Costs {
    seconds: Spread,
    mean: f64,
    newton: f64,
    linear: f64,
    unknowns: usize,
}

pub fn section(machine: &Machine, effort: &Effort) -> Outcome<String> {
    let mut table = Table::new(&[
        "body",
        "model",
        "unknowns",
        "Newton steps",
        "linear iterations",
        "ms per step",
        "mean, ms",
        "fine / this",
        "floor, ms",
        "limit we set",
    ]);
    for (make, limit) in BODIES.into_iter().take(if effort.largest_motion { 3 } else { 2 }) {
        let body = make()?;
        let coarse = body.coarse()?;
        let mut costs = Vec::new();
        for (_, integration) in KINDS {
            let (mut steps, count) = match integration {
                Some(integration) => {
                    (body.coarse_steps(&coarse, integration, StepOptions::default())?, effort.steps[0])
                }
                None => (body.fine_steps(StepOptions::default())?, effort.steps[1]),
            };
            costs.push(run(&mut steps, count)?);
        }
        let fine = costs[costs.len() - 1].mean;
        for ((kind, integration), cost) in KINDS.into_iter().zip(&costs) {
            let is_fast = integration == Some(Integration::Stiffness);
            table.row(&[
                body.name.to_owned(),
                kind.to_owned(),
                cost.unknowns.to_string(),
                digits(cost.newton),
                digits(cost.linear),
                cost.seconds.show(MILLI),
                digits(cost.mean / MILLI),
                digits(fine / cost.mean),
                if is_fast { digits(floor(machine, &coarse, cost) / MILLI) } else { String::new() },
                if is_fast { limit.to_owned() } else { String::new() },
            ]);
        }
    }
    Ok(format!("{INTRODUCTION}\n{}", table.text()))
}

const INTRODUCTION: &str = "\
## Steps in time

Backward Euler, steps of 0.01 s from rest, each to a relative residual of 1e-5, neo-Hookean materials, all threads. *Beam*: 24 × 8 × 8 cells in oblique
layers of ratio 50 that hang from one end, 24 coarse cells of degree 4. *Plate*: 24 × 24 × 8 cells with a grid of stiff bars (ratio 100) that is twisted, 72
coarse cells of degree 4. *Trunk*: the CT of scenes/torso.toml on 48 × 48 × 36 voxels (0.1 and 100 MPa) under its weight, degree 2. Coarse models by
the three integrations of `Integration`, and the fine model, by the same code and to the same tolerance. The first step is left out.

The floor of a step by the stiffness counts, per element, 1152 operations for a gradient and 15,000 for a tangent, and per linear iteration two for each
number of the matrix; and the bytes of all element matrices for each gradient, three times for each tangent (read, written, assembled), and those of the matrix, once written and once
read per linear iteration. What a preconditioner costs is not in it.
";

fn run(steps: &mut Steps<'_>, count: usize) -> Outcome<Costs> {
    steps.advance()?;
    let (mut seconds, mut reports): (Vec<f64>, Vec<StepReport>) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let start = std::time::Instant::now();
        reports.push(steps.advance()?);
        seconds.push(start.elapsed().as_secs_f64());
    }
    let mean = |pick: fn(&StepReport) -> usize| reports.iter().map(pick).sum::<usize>() as f64 / count as f64;
    let sum: f64 = seconds.iter().sum();
    seconds.sort_by(f64::total_cmp);
    let spread = Spread { median: seconds[count / 2], low: seconds[0], high: seconds[count - 1] };
    Ok(Costs {
        seconds: spread,
        mean: sum / count as f64,
        newton: mean(|r| r.newton_iterations),
        linear: mean(|r| r.linear_iterations),
        unknowns: steps.unknowns(),
    })
}

fn floor(machine: &Machine, coarse: &CoarseModel, cost: &Costs) -> f64 {
    let elements = coarse.elements().len() as f64;
    let numbers = matrix_numbers(coarse);
    let operations = elements * (1152.0 * (cost.newton + 1.0) + 15_000.0 * cost.newton) + 2.0 * numbers * cost.linear;
    let of_elements = 8.0 * 576.0 * elements * (cost.newton + 1.0 + 3.0 * cost.newton);
    machine.floor(operations, of_elements + 8.0 * numbers * (cost.newton + cost.linear))
}

/// Numbers of the assembled matrix: nine for each pair of vertices of an element.
fn matrix_numbers(coarse: &CoarseModel) -> f64 {
    let mut pairs: Vec<[u32; 2]> =
        coarse.mesh().corners().iter().flat_map(|c| (0..64).map(|n| [c[n / 8], c[n % 8]])).collect();
    pairs.sort_unstable();
    pairs.dedup();
    9.0 * pairs.len() as f64
}
