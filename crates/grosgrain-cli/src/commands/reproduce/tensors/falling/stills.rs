//! Pictures of meshes, their sections and harmonic displacements.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use grosgrain_picture::{Figure, Panel};

use super::films::Look;
use super::pair::Pair;
use crate::failure::Failure;
use crate::meshes::{Paint, Posed, SimplexLook, SimplexSkin, harmonic_panels};
use crate::picture::save;
use crate::quantities::count;

/// Writes the fine mesh, its sections and the coarse mesh into one picture, harmonic displacements into another.
///
/// # Errors
/// A mesh that cannot be drawn, a file that cannot be written.
pub fn write(pair: &Pair, look: &Look, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let drawn = SimplexLook { materials: look.legend(), scale: 1.0, ghost: false };
    let (fine, coarse) = (pair.fine.mesh(), pair.coarse_mesh());
    let still = [fine, coarse].map(|mesh| vec![0.0; 3 * mesh.nodes().len()]);
    let whole = Arc::new(SimplexSkin::new(fine, None)?);
    let cells = |n: usize| format!("{} tetrahedra", count(n));
    let wires = look.edges.then(|| posed(&whole, &still[0]));
    let panel = |caption: &str, detail: String, panel: Panel| Panel { caption: caption.into(), detail, ..panel };
    let mut panels =
        vec![panel("Fine mesh", cells(fine.cell_count()), drawn.panel(posed(&whole, &still[0]), &Paint::Tags, wires))];
    for (number, (_, _, caption)) in look.sections.iter().enumerate() {
        let skin = Arc::new(SimplexSkin::new(fine, Some(&look.section(pair, number)))?);
        let edges = look.edges.then(|| posed(&skin, &still[0]));
        panels.push(panel(caption, String::new(), drawn.panel(posed(&skin, &still[0]), &Paint::Tags, edges)));
    }
    let skin = Arc::new(SimplexSkin::new(coarse, None)?);
    let body = Posed { skin: &skin, displacement: &still[1] };
    let plain = look.materials.first().map_or([0xc8; 3], |(_, _, colour)| *colour);
    panels.push(panel("Coarse mesh", cells(coarse.cell_count()), drawn.panel(body, &Paint::Plain(plain), Some(body))));
    let file = |ending: &str| folder.join(format!("{}{ending}.png", look.name));
    let meshes = Figure { title: look.title.into(), panels, columns: Some(2), view: look.view, ..Figure::default() };
    let harmonic = Figure {
        title: format!("Harmonic displacements: {}", look.title),
        panels: harmonic_panels(&whole, &pair.found.harmonic, None, &drawn),
        columns: Some(3),
        view: look.view,
        ..Figure::default()
    };
    Ok(vec![save(meshes.render(), &file("-meshes"))?, save(harmonic.render(), &file("-harmonic"))?])
}

fn posed<'a>(skin: &'a Arc<SimplexSkin>, displacement: &'a [f64]) -> Posed<'a> {
    Posed { skin, displacement }
}
