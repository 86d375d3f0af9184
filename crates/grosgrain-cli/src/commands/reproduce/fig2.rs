//! Fig. 2: the beams of Table 1.

use super::bodies::{BEAM, PHASES};
use super::row::{Row, digits};
use super::{Findings, Study, pictures};
use crate::failure::Failure;
use crate::interruption;
use crate::quantities::{count, triple_count};
use crate::results;

const NAME: &str = "fig2";

/// Describes every beam, and draws it where there is a folder.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let mut found = Findings::default();
    let mut panels = Vec::new();
    let mut lines = vec![["beam", "fine cells", "fine unknowns", "stiff"].map(String::from)];
    for (degree, pattern) in study.degrees.iter().flat_map(|d| study.patterns.iter().map(|p| (*d, *p))) {
        interruption::check()?;
        let grid = pattern.beam(degree)?;
        let stiff = grid.labels.iter().filter(|label| **label == PHASES[1]).count();
        let share = 100.0 * stiff as f64 / grid.labels.len() as f64;
        let unknowns = 3 * grid.lattice.node_count();
        let name = format!("{}, d = {degree}", pattern.name());
        lines.push([name.clone(), triple_count(grid.lattice.cells), count(unknowns), format!("{} %", digits(share))]);
        for (quantity, unit, value) in
            [("fine unknowns", "1", unknowns as f64), ("share of stiff material", "%", share)]
        {
            found.rows.push(Row {
                degree: Some(degree),
                pattern: Some(pattern.name()),
                measured: Some(value),
                ..Row::new(study, NAME, quantity, unit)
            });
        }
        if study.folder.is_some() {
            let detail = format!("{} unknowns", count(unknowns));
            panels.push(((pattern, degree), pictures::body_panel(&grid, degree, name, detail)));
        }
    }
    let mut text = format!(
        "Fig. 2 of he2022fast: the beams of Table 1, {} coarse cells, ratio of moduli 50\n{}",
        triple_count(BEAM),
        results::columns(&lines)
    );
    match &study.folder {
        Some(folder) => {
            study.progress.say("drawing the beams");
            found.written = pictures::write_bodies(NAME, "Beams of Table 1", &panels, folder)?;
        }
        None => text.push_str("\n-o DIR draws them"),
    }
    Ok(Findings { text, ..found })
}
