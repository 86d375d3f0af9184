//! `reproduce`: tables and figures of the papers, run again and printed next to what was published.

mod artefact;
mod bodies;
mod fig2;
mod fig3;
mod fits;
mod moving;
mod pictures;
mod repository;
mod row;
mod setting;
mod table1;
mod table1_error;
mod table1_text;
mod table2;
mod table3;
mod tensors;

use std::path::PathBuf;

use clap::Args;

use self::artefact::Artefact;
use self::bodies::Heterogeneity;
use self::row::Row;
use crate::failure::Failure;
use crate::machine::Machine;
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::results;

const EXAMPLES: &str = "Examples:
  grosgrain reproduce table1 --degrees 2,3 --patterns oblique -o out/table1
  grosgrain reproduce fig1 fig4 fig5 -o out/figures";

/// Arguments of `reproduce`.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// What is run again: table1, table2, table3, fig1 to fig5, springs, homogeneous, layers, crack, composite, cheese, liver
    #[arg(value_name = "NAME", required_unless_present = "list")]
    names: Vec<Artefact>,
    /// Say what can be reproduced, and stop
    #[arg(long)]
    list: bool,
    /// The coarsening degrees, with commas between them; all published ones without it
    #[arg(long, value_delimiter = ',', value_name = "D,D")]
    degrees: Vec<usize>,
    /// The patterns, with commas between them: oblique, horizontal, vertical; all without it
    #[arg(long, value_delimiter = ',', value_name = "A,B")]
    patterns: Vec<Heterogeneity>,
    /// Figs. 1, 4 and 5, cheese and liver: make the first so many steps only
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    steps: Option<u32>,
    /// Figs. 1, 4 and 5: the folder of their scenes; without it `scenes` in or above the current folder or that of the program
    #[arg(long, value_name = "DIR")]
    scenes: Option<PathBuf>,
    /// Liver: the folder of its meshes; without it `data/meshes` in or above the current folder or that of the program
    #[arg(long, value_name = "DIR")]
    meshes: Option<PathBuf>,
    /// Write pictures and charts into this folder; none are written without it
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Write the rows, published beside measured, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What is to be run, on which machine.
struct Study<'a> {
    degrees: Vec<usize>,
    patterns: Vec<Heterogeneity>,
    /// Make so many steps only.
    steps: Option<usize>,
    /// Where scenes are.
    scenes: Option<PathBuf>,
    /// Where meshes are.
    meshes: Option<PathBuf>,
    /// Where pictures go.
    folder: Option<PathBuf>,
    machine: Machine,
    progress: &'a Progress,
}

/// What came out.
#[derive(Default)]
struct Findings {
    rows: Vec<Row>,
    /// The tables and sentences for the reader.
    text: String,
    /// The pictures.
    written: Vec<PathBuf>,
    /// Why a run ended before its last step.
    stopped: Option<Failure>,
}

/// Runs what is named and prints it.
pub fn run(arguments: &Arguments, progress: &Progress) -> Result<(), Failure> {
    if arguments.list {
        return results::print(&artefact::list());
    }
    let studies: Result<Vec<(Artefact, Study)>, Failure> =
        arguments.names.iter().map(|name| Ok((*name, study(*name, arguments, progress)?))).collect();
    let studies = studies?;
    let _folders = (
        arguments.output.as_deref().map(OutputFolder::make).transpose()?,
        arguments.json.as_deref().map(OutputFolder::around).transpose()?,
    );
    let (mut rows, mut stopped) = (Vec::new(), None);
    for (artefact, study) in studies {
        let found = artefact.run(&study)?;
        results::print(&found.text)?;
        found.written.iter().try_for_each(|path| results::print(&format!("wrote {}", path.display())))?;
        rows.extend(found.rows);
        stopped = stopped.or(found.stopped);
    }
    if let Some(json) = &arguments.json {
        results::write_json(json, &rows)?;
    }
    stopped.map_or(Ok(()), Err)
}

fn study<'a>(artefact: Artefact, arguments: &Arguments, progress: &'a Progress) -> Result<Study<'a>, Failure> {
    artefact.check_scene(arguments.steps.is_some(), arguments.scenes.is_some())?;
    artefact.check_meshes(arguments.meshes.is_some())?;
    Ok(Study {
        degrees: artefact.degrees(&arguments.degrees)?,
        patterns: artefact.patterns(&arguments.patterns)?,
        steps: arguments.steps.map(|steps| steps as usize),
        scenes: arguments.scenes.clone(),
        meshes: arguments.meshes.clone(),
        folder: arguments.output.clone(),
        machine: Machine::here(),
        progress,
    })
}
