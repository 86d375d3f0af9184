//! Fig. 3: single cells, on which the decoupled fit is compared with the coupled one.

use grosgrain::partition::CoarseCell;
use grosgrain::training::RingKind;

use super::bodies::fine_model;
use super::fits::{BOUND, FitCase, PAIRS, difference, pair_name, published};
use super::row::{Row, digits};
use super::{Findings, Study, pictures};
use crate::failure::Failure;
use crate::interruption;
use crate::quantities::triple_count;
use crate::results;

const NAME: &str = "fig3";

/// Fits every cell in three ways, and draws it where there is a folder.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let mut found = Findings::default();
    let mut panels = Vec::new();
    let [first, second, third] = PAIRS.map(|pair| pair_name(pair).to_owned());
    let mut lines = vec![["cell".into(), first, "published".into(), second, third]];
    for (degree, pattern) in study.degrees.iter().flat_map(|d| study.patterns.iter().map(|p| (*d, *p))) {
        interruption::check()?;
        let name = format!("{}, d = {degree}", pattern.name());
        study.progress.say(&format!("{name}: three fits"));
        let model = fine_model(pattern.cell(degree)?)?;
        let functions = FitCase::new(&model, degree, CoarseCell(0), RingKind::SingleCell)?.functions()?;
        let rows = PAIRS.map(|pair| Row {
            degree: Some(degree),
            pattern: Some(pattern.name()),
            method: Some(pair_name(pair)),
            published: published(pair),
            measured: Some(difference(&functions, pair)),
            note: published(pair).map(|_| BOUND.into()),
            ..Row::new(study, NAME, "difference", "%")
        });
        let [first, second, third] = PAIRS.map(|pair| digits(difference(&functions, pair)));
        lines.push([name.clone(), first, "< 0.001".into(), second, third]);
        found.rows.extend(rows);
        if study.folder.is_some() {
            let detail = format!("{} fine cells", triple_count(model.grid().lattice.cells));
            panels.push(((pattern, degree), pictures::body_panel(model.grid(), degree, name, detail)));
        }
    }
    if let Some(folder) = &study.folder {
        study.progress.say("drawing the cells");
        found.written = pictures::write_bodies(NAME, "Single cells, on which fits are compared", &panels, folder)?;
    }
    let text = format!(
        "Fig. 3 of he2022fast: difference of shape functions in percent, ‖m − m'‖ / ‖m'‖ over all coefficients\n\
         single coarse cells of layers, ratio of moduli 50, trained on their own harmonic displacements\n{}\n\
         In exact arithmetic all three are the same functions; what is left is rounding",
        results::columns(&lines)
    );
    Ok(Findings { text, ..found })
}
