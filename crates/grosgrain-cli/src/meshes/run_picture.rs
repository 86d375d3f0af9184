//! The picture of a run of meshes: the deformed body, fine and coarse side by side.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use grosgrain::mesh::Label;
use grosgrain::simplex::{SimplexMesh, select_cells};
use grosgrain_picture::{ColourMap, ColourScale, Figure, Panel, Rgb};

use super::method::MeshMethod;
use super::problem::MeshProblem;
use super::{Paint, Posed, SimplexLook, SimplexSkin, simplex_view};
use crate::failure::Failure;
use crate::picture::{drawn_scale, largest_displacement, save};
use crate::quantities::{count, number};

/// What of a problem's meshes is seen.
#[derive(Clone, Debug)]
pub struct Skins {
    /// The fine mesh, without the cells that the scene hides.
    pub fine: Arc<SimplexSkin>,
    /// The coarse mesh.
    pub coarse: Arc<SimplexSkin>,
}

/// What a picture shows: displacements \[m\] of fine nodes.
#[derive(Clone, Copy, Debug)]
pub struct DrawnMeshes<'a> {
    /// The fine model's.
    pub fine: Option<&'a [f64]>,
    /// A coarse model's: its method, the displacement of the fine nodes and that of its own.
    pub coarse: Option<(MeshMethod, [&'a [f64]; 2])>,
    /// RMS error of the one against the other, in percent.
    pub error: Option<f64>,
    /// What is added to the title.
    pub remark: &'a str,
}

/// Names of tags in legends.
pub fn legend(problem: &MeshProblem) -> Vec<(Label, String, Option<Rgb>)> {
    problem.scene.materials.iter().map(|material| (material.label, material.name.clone(), None)).collect()
}

impl Skins {
    /// The skins of a problem's meshes.
    ///
    /// # Errors
    /// Meshes of segments; cells to hide that cannot be selected, or are all there are.
    pub fn new(problem: &MeshProblem) -> Result<Self, Failure> {
        let fine = match &problem.scene.output.hide {
            None => SimplexSkin::new(problem.fine.mesh(), None)?,
            Some(hide) => {
                let refuse =
                    |error: &dyn std::fmt::Display| Failure::from(problem.scene.unusable("output.hide", error));
                let hidden = select_cells(problem.fine.mesh(), hide).map_err(|error| refuse(&error))?;
                let rest = without(problem.fine.mesh(), &hidden).map_err(|error| refuse(&error))?;
                SimplexSkin::new(&rest, None)?
            }
        };
        Ok(Self { fine: Arc::new(fine), coarse: Arc::new(SimplexSkin::new(&problem.coarse, None)?) })
    }

    /// Draws a picture into the file at `path`.
    ///
    /// # Errors
    /// A picture that cannot be drawn or written.
    pub fn write(&self, problem: &MeshProblem, drawn: &DrawnMeshes<'_>, path: &Path) -> Result<PathBuf, Failure> {
        save(self.figure(problem, drawn).render(), path)
    }

    fn figure(&self, problem: &MeshProblem, drawn: &DrawnMeshes<'_>) -> Figure {
        let shown = drawn.fine.or(drawn.coarse.map(|(_, [u, _])| u)).unwrap_or_default();
        // A body that flies is drawn as it is, without the place where it was.
        let flies = problem.scene.is_dynamic() && problem.scene.fixes.is_empty();
        let scale = if flies { 1.0 } else { drawn_scale(self.fine.size(), largest_displacement(shown)) };
        let look = SimplexLook { materials: legend(problem), scale, ghost: !flies };
        let mut panels = Vec::new();
        if let Some(u) = drawn.fine {
            panels.push(Panel {
                caption: "Fine mesh".into(),
                detail: format!("{} unknowns", count(problem.fine_size().unknowns)),
                ..look.panel(Posed { skin: &self.fine, displacement: u }, &Paint::Tags, None)
            });
        }
        if let Some((method, [u, own])) = drawn.coarse {
            let unknowns = count(problem.coarse_size().unknowns);
            let wires = Posed { skin: &self.coarse, displacement: own };
            let errors = drawn.fine.map(|fine| errors(u, fine));
            let paint = errors.as_ref().map_or(Paint::Tags, |errors| Paint::Nodes(errors, error_scale()));
            panels.push(Panel {
                caption: format!("Coarse mesh: {}", method.label()),
                detail: drawn.error.map_or_else(
                    || format!("{unknowns} unknowns"),
                    |error| format!("{unknowns} unknowns, RMS error {error:.1} %"),
                ),
                ..look.panel(Posed { skin: &self.fine, displacement: u }, &paint, Some(wires))
            });
        }
        let footer = vec![match scale == 1.0 {
            true => "Displacements to scale.".to_owned(),
            false => format!("Displacements drawn × {}.", number(scale)),
        }];
        let title = format!("{}{}", problem.scene.title, drawn.remark);
        Figure { title, panels, footer, view: simplex_view(self.fine.dimension()), ..Figure::default() }
    }
}

/// A mesh without marked cells; its nodes keep their numbers.
fn without(mesh: &SimplexMesh, hidden: &[bool]) -> Result<SimplexMesh, grosgrain::simplex::SimplexMeshError> {
    let kept: Vec<usize> = (0..mesh.cell_count()).filter(|cell| !hidden[*cell]).collect();
    let corners = |cell: &usize| std::array::from_fn(|n| mesh.cell(*cell).get(n).copied().unwrap_or_default());
    let tags = kept.iter().map(|cell| mesh.tags()[*cell]).collect();
    SimplexMesh::new(mesh.dimension(), mesh.nodes().to_vec(), kept.iter().map(corners).collect(), tags)
}

/// Distance between two displacements of every node, in percent of the largest of the second.
fn errors(u: &[f64], exact: &[f64]) -> Vec<f64> {
    // Before anything moves there is nothing to be relative to, and no error.
    let largest = Some(largest_displacement(exact)).filter(|largest| *largest > 0.0).unwrap_or(1.0);
    let distance = |(u, v): (&[f64], &[f64])| (0..3).map(|r| (u[r] - v[r]).powi(2)).sum::<f64>().sqrt();
    u.chunks_exact(3).zip(exact.chunks_exact(3)).map(|pair| 100.0 * distance(pair) / largest).collect()
}

fn error_scale() -> ColourScale {
    let label = "|u coarse − u fine| [% of max |u fine|]".into();
    ColourScale { label, map: ColourMap::Magma, reversed: true, range: None }
}
