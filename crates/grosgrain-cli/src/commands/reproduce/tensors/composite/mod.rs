//! Fig. 6: what a fine mesh looks like when a single triangle is moved.

mod body;
mod drawing;

use grosgrain::dynamics::restrict_conditions;
use grosgrain::homogenization::{Blending, CoarseSimplexModel, HarmonicMap, SimplexEmbedding, SimplexModel};
use grosgrain::simplex::{Locator, SimplexMesh};

use self::body::{Hanging, SIZE, composite, conditions, triangle};
use super::super::row::{Row, digits};
use super::super::{Findings, Study};
use super::homogenized;
use crate::failure::Failure;
use crate::outcome::failed;
use crate::quantities::count;
use crate::{interruption, results};

/// Name of the artefact.
pub const NAME: &str = "composite";

/// Rows of triangles of the coarse meshes, and what they are called.
const COARSE: [(usize, &str); 3] = [(1, "1 triangle"), (2, "4 triangles"), (4, "16 triangles")];
const MAPS: [(&str, Option<Blending>); 3] =
    [("barycentric", None), ("harmonic", Some(Blending::PerCell)), ("harmonic, blended", Some(Blending::Continuous))];
/// Where the coarse nodes are: in the coarse equilibrium, or at their places in the fine one, which shows the map alone.
const CORNERS: [&str; 2] = ["coarse equilibrium", "fine equilibrium"];

/// A coarse mesh in motion and what maps it to the fine one.
struct Moved {
    mesh: SimplexMesh,
    map: HarmonicMap,
    /// Displacement \[m\] of its nodes, in the order of [`CORNERS`].
    displacements: [Vec<f64>; 2],
}

/// The fine body as a coarse mesh shows it.
struct Shown {
    coarse: usize,
    corners: usize,
    map: usize,
    displacement: Vec<f64>,
    /// Difference from the fine equilibrium \[%\].
    error: f64,
    /// Elastic energy over that of the fine equilibrium.
    energy: f64,
    /// Coarse cells that took the barycentric map.
    barycentric: usize,
}

/// Hangs the composite up, and shows it by each coarse mesh and map.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let model = composite()?;
    let fine = Hanging::new(study, &model, conditions(&model)?)?;
    let coarse = COARSE.iter().map(|(rows, _)| moved(study, (&model, &fine), *rows));
    let coarse: Vec<Moved> = coarse.collect::<Result<_, _>>()?;
    let shown = shown(&fine, &coarse);
    let mut found =
        Findings { rows: shown.iter().flat_map(|shown| rows(study, shown)).collect(), ..Findings::default() };
    found.text = text(&model, &fine, &shown);
    match &study.folder {
        Some(folder) => {
            study.progress.say("drawing the composite");
            found.written = vec![drawing::write(&model, &fine, &coarse, &shown, folder)?];
        }
        None => found.text.push_str("\n-o DIR draws it"),
    }
    Ok(found)
}

/// Coarsens the composite and hangs the coarse body up.
fn moved(study: &Study, (model, fine): (&SimplexModel, &Hanging), rows: usize) -> Result<Moved, Failure> {
    interruption::check()?;
    let mesh = triangle(rows)?;
    let found = homogenized(study, model, &mesh)?;
    let coarse = CoarseSimplexModel::effective(&mesh, &found).map_err(|error| failed(&error))?;
    let embedding = SimplexEmbedding::new(model.mesh(), &Locator::new(&mesh));
    let acting = restrict_conditions(fine.body.conditions(), model.mesh(), &embedding, &mesh);
    let hanging = Hanging::new(study, &coarse.model, acting.map_err(|error| failed(&error))?.conditions)?;
    let at_fine = SimplexEmbedding::new(&mesh, &Locator::new(model.mesh())).prolong(&fine.displacement);
    let map = HarmonicMap::new(&found.harmonic, (&mesh, &found.downsampled.fields), embedding);
    Ok(Moved { mesh, map, displacements: [hanging.displacement, at_fine] })
}

fn shown(fine: &Hanging, coarse: &[Moved]) -> Vec<Shown> {
    let own = fine.elastic_energy(&fine.displacement);
    let mut shown = Vec::new();
    for (number, moved) in coarse.iter().enumerate() {
        for (corners, given) in moved.displacements.iter().enumerate() {
            for (map, (_, blending)) in MAPS.iter().enumerate() {
                let (displacement, barycentric) = match blending {
                    None => (moved.map.embedding().prolong(given), 0),
                    // A single cell has nothing to blend with.
                    Some(Blending::Continuous) if moved.mesh.cell_count() == 1 => continue,
                    Some(blending) => {
                        let mapped = moved.map.map(given, *blending);
                        (mapped.displacement, mapped.barycentric.len())
                    }
                };
                let error = 100.0 * fine.difference(&displacement);
                let energy = fine.elastic_energy(&displacement) / own;
                shown.push(Shown { coarse: number, corners, map, displacement, error, energy, barycentric });
            }
        }
    }
    shown
}

fn rows(study: &Study, shown: &Shown) -> [Row; 2] {
    let row = |quantity, unit, value| Row {
        pattern: Some(COARSE[shown.coarse].1),
        setting: Some(CORNERS[shown.corners]),
        method: Some(MAPS[shown.map].0),
        measured: Some(value),
        note: Some("the paper shows a picture without figures".into()),
        ..Row::new(study, NAME, quantity, unit)
    };
    [row("error", "%", shown.error), row("elastic energy over that of the fine equilibrium", "1", shown.energy)]
}

fn text(model: &SimplexModel, fine: &Hanging, shown: &[Shown]) -> String {
    let headings = ["coarse mesh", "its nodes as in the", "map", "error", "energy", "cells without rotation"];
    let mut lines = vec![headings.map(String::from)];
    lines.extend(shown.iter().map(|shown| {
        [
            COARSE[shown.coarse].1.into(),
            CORNERS[shown.corners].into(),
            MAPS[shown.map].0.into(),
            format!("{} %", digits(shown.error)),
            digits(shown.energy),
            count(shown.barycentric),
        ]
    }));
    let lowest = fine.displacement.chunks_exact(3).map(|u| -u[1]).fold(0.0, f64::max);
    format!(
        "Fig. 6 of kharevych2009numerical: a composite of two materials ({} triangles, seven bands, moduli 1 : 100) hangs from its top and grows longer by {} %;\n\
         its fine mesh as coarse meshes of effective tensors show it. Error: root mean square of the displacement's difference from the fine equilibrium over that of the displacement;\n\
         energy: elastic, over that of the fine equilibrium. The paper shows a picture of one triangle without figures: the map \"enhances visual impact at low cost\"\n{}",
        count(model.mesh().cell_count()),
        digits(100.0 * lowest / SIZE),
        results::columns(&lines)
    )
}
