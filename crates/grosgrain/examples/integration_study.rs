//! Errors and costs of the integrations of the coarse model on reference bodies: writes a page of Markdown.
//!
//! ```sh
//! cargo run --release -p grosgrain --example integration_study -- docs/integration.md
//! cargo run --release -p grosgrain --example integration_study -- --quick
//! ```
//!
//! Without a path the page goes to standard output. `--quick` leaves out the CT.

#[path = "../benches/cases/mod.rs"]
mod cases;
#[path = "../benches/baselines/simplicial.rs"]
mod simplicial;

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use cases::Outcome;
use cases::steps::{MovingBody, Steps};
use grosgrain::coarse::Integration;
use grosgrain::dynamics::{
    Body, EquilibriumOptions, LoadPath, Moment, NewtonOptions, QuadraticWeights, State, StepOptions, find_equilibrium,
    relative_error,
};
use grosgrain::io::write_atomically;
use grosgrain::material::Projection;

/// A body, the time whose held nodes its equilibrium has [s], and the number of steps of its short run.
struct Reference {
    body: MovingBody,
    what: &'static str,
    time: f64,
    steps: usize,
}

const INTEGRATIONS: [(&str, Integration); 3] =
    [("stiffness", Integration::Stiffness), ("centre", Integration::Centre), ("Gauss", Integration::Gauss)];

/// What a model has come to, on the fine nodes.
struct Found {
    equilibrium: Result<Vec<f64>, String>,
    motion: Result<Vec<f64>, String>,
    /// Of a gradient, of a tangent with what the solver does with it, of a step [s].
    seconds: [f64; 3],
    newton: f64,
}

fn references(is_quick: bool) -> Outcome<Vec<Reference>> {
    let mut references = vec![
        Reference { body: MovingBody::beam()?, what: "hangs from one end", time: 0.0, steps: 30 },
        Reference { body: MovingBody::plate()?, what: "twisted by 45°", time: 0.5, steps: 30 },
    ];
    if !is_quick {
        for (body, what, steps) in [
            (MovingBody::torso("torso, small load", 0.02)?, "a fiftieth of its weight", 15),
            (MovingBody::torso("torso, large load", 1.0)?, "its weight", 15),
        ] {
            references.push(Reference { body, what, time: 0.0, steps });
        }
    }
    Ok(references)
}

const INTRODUCTION: &str = "\
# Integration of the coarse elements

Written by one command, which runs everything on this page again:

    cargo run --release -p grosgrain --example integration_study -- docs/integration.md

The three integrations of `Integration` against the fine model with the same neo-Hookean materials: *error, static* is ‖u − u_fine‖ / ‖u_fine‖ over all
fine nodes in equilibrium (relative residual 1e-6), *error, moving* the same at the end of a short run of backward Euler steps of 0.01 s from rest
(relative residual 1e-5). A *gradient* and a *tangent* (with assembly, and a factor or cycle where the solver makes one) are timed at the
equilibrium, the step is the mean of the run; all threads. *Coarsening alone* is in all three: it is what remains with every Gauss point.
";

fn main() -> Outcome<()> {
    let (mut path, mut is_quick) = (None, false);
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--quick" => is_quick = true,
            unknown if unknown.starts_with('-') => {
                return Err(format!("unknown option {unknown}; there is --quick").into());
            }
            _ => path = Some(argument),
        }
    }
    let mut page = INTRODUCTION.to_owned();
    for reference in references(is_quick)? {
        eprintln!("{}", reference.body.name);
        page += &section(&reference)?;
    }
    match path {
        Some(path) => write_atomically(Path::new(&path), |file| file.write_all(page.as_bytes()))?,
        None => std::io::stdout().write_all(page.as_bytes())?,
    }
    Ok(())
}

fn section(reference: &Reference) -> Outcome<String> {
    let Reference { body, what, steps, .. } = reference;
    let coarse = body.coarse()?;
    let fine = find(reference, || body.fine_steps(StepOptions::default()))?;
    let mut text = format!(
        "\n## {}, {what}\n\n{:?} cells, {} coarse elements of degree {}, {steps} steps.\n\n\
         | model | error, static, % | error, moving, % | gradient, ms | tangent, ms | step, ms | Newton steps per step |\n\
         | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
        body.name,
        body.fine.grid().lattice.cells,
        coarse.elements().len(),
        body.degree
    );
    for (name, integration) in INTEGRATIONS {
        let found = find(reference, || body.coarse_steps(&coarse, integration, StepOptions::default()))?;
        let error = |ours: &Result<Vec<f64>, String>, fine: &Result<Vec<f64>, String>| match (ours, fine) {
            (Ok(ours), Ok(fine)) => format!("{:.2}", 100.0 * relative_error(ours, fine)),
            (Err(reason), _) | (_, Err(reason)) => reason.clone(),
        };
        let errors = [error(&found.equilibrium, &fine.equilibrium), error(&found.motion, &fine.motion)];
        text += &row(name, errors, &found);
    }
    Ok(text + &row("fine", Default::default(), &fine))
}

fn row(name: &str, [at_rest, moving]: [String; 2], found: &Found) -> String {
    let [gradient, tangent, step] = found.seconds.map(|s| format!("{:.3}", 1e3 * s));
    format!("| {name} | {at_rest} | {moving} | {gradient} | {tangent} | {step} | {:.2} |\n", found.newton)
}

fn find<'a>(reference: &Reference, make: impl Fn() -> Outcome<Steps<'a>>) -> Outcome<Found> {
    let mut steps = make()?;
    let equilibrium = equilibrium(&mut steps, reference.time);
    let [gradient, tangent] = steps.with_body(|body, state| costs(body, state))?;
    let equilibrium = match equilibrium {
        Ok(()) => Ok(steps.fine_displacement()?),
        Err(reason) => Err(reason),
    };
    let (mut steps, mut newton) = (make()?, 0);
    let start = Instant::now();
    let mut motion = Ok(Vec::new());
    for _ in 0..reference.steps {
        match steps.advance() {
            Ok(report) => newton += report.newton_iterations,
            Err(reason) => motion = Err(reason.to_string()),
        }
        if motion.is_err() {
            break;
        }
    }
    let per_step = 1.0 / reference.steps as f64;
    let seconds = [gradient, tangent, start.elapsed().as_secs_f64() * per_step];
    if motion.is_ok() {
        motion = Ok(steps.fine_displacement()?);
    }
    Ok(Found { equilibrium, motion, seconds, newton: newton as f64 * per_step })
}

/// Brings the body to the equilibrium of its loads, with its held nodes as they are at a time.
fn equilibrium(steps: &mut Steps<'_>, time: f64) -> Result<(), String> {
    let newton = NewtonOptions { tolerance: 1e-6, max_iterations: 60 };
    let options = EquilibriumOptions { newton, increments: 4, ..EquilibriumOptions::default() };
    let path = LoadPath { share: [0.0, 1.0], time: [0.0, time], loads: [0.0, 0.0] };
    steps.with_body(|body, state| {
        find_equilibrium(body, &mut state.displacement, &path, &options, &|_| true)
            .map(|_| ())
            .map_err(|error| error.to_string())
    })
}

/// Seconds of a gradient and of a tangent at the state: medians of a few.
fn costs(body: &mut dyn Body, state: &State) -> Outcome<[f64; 2]> {
    body.set_moment(Moment { loads: 0.0, share: 1.0, holds: 0.0 })?;
    let weights = QuadraticWeights { mass: 1e4, damping: 0.0 };
    let mut gradient = vec![0.0; state.displacement.len()];
    let (mut gradients, mut tangents) = (Vec::new(), Vec::new());
    for _ in 0..9 {
        let start = Instant::now();
        body.gradient(&state.displacement, &mut gradient)?;
        gradients.push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        body.linearise(&state.displacement, weights, Projection::PositiveSemidefinite)?;
        tangents.push(start.elapsed().as_secs_f64());
    }
    Ok([gradients, tangents].map(|mut seconds| {
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    }))
}
