//! §5, the first check: a homogeneous body is coarsened into its own material.

use grosgrain::material::IsotropicMaterial;
use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, MandelTensor, SimplexLattice, SimplexMesh};

use super::super::row::Row;
use super::super::{Findings, Study};
use super::{body, difference, homogenized};
use crate::failure::Failure;
use crate::interruption;
use crate::quantities::count;
use crate::results;

/// Name of the artefact.
pub const NAME: &str = "homogeneous";

/// What the paper says: "the same material".
const PUBLISHED: f64 = 0.0;
const YOUNG: f64 = 1e6;
const POISSON: f64 = 0.4;

/// Coarsens a box in one, two and three dimensions.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let material = IsotropicMaterial::new(YOUNG, POISSON).map_err(|error| Failure::Failed(error.to_string()))?;
    let mut found = Findings::default();
    let mut lines = vec![["mesh", "fine", "coarse", "largest difference", "mass"].map(String::from)];
    for (name, dimension) in
        [("segments", Dimension::One), ("triangles", Dimension::Two), ("tetrahedra", Dimension::Three)]
    {
        interruption::check()?;
        let (fine, coarse) = (mesh(dimension, [24, 18, 12])?, mesh(dimension, [3, 2, 2])?);
        let own = MandelTensor::of_material(dimension, &material.tensor());
        let cells = [&fine, &coarse].map(|mesh| count(mesh.cell_count()));
        let tensors = vec![own; fine.cell_count()];
        let model = body(fine, tensors)?;
        let result = homogenized(study, &model, &coarse)?;
        let largest = result.effective.tensors.iter().fold(0.0f64, |d, tensor| d.max(difference(tensor, &own)));
        let mass = result.mass.iter().sum::<f64>() / model.mass() - 1.0;
        let [fine, coarse] = cells;
        lines.push([name.into(), fine, coarse, format!("{largest:.1e}"), format!("{:.1e}", mass.abs())]);
        found.rows.push(Row {
            pattern: Some(name),
            published: Some(PUBLISHED),
            measured: Some(largest),
            note: Some("“the same material — for coarse tets entirely inside the model”".into()),
            ..Row::new(study, NAME, "difference", "1")
        });
    }
    found.text = format!(
        "A homogeneous body coarsened (kharevych2009numerical, section 5): difference of its tensors from its own, relative to the largest entry,\n\
         and of its mass; nested boxes, so that every coarse cell is inside\n{}",
        results::columns(&lines)
    );
    Ok(found)
}

fn mesh(dimension: Dimension, boxes: [usize; 3]) -> Result<SimplexMesh, Failure> {
    let around = BoundingBox { lower: [0.0; 3], upper: [0.12, 0.08, 0.06] };
    let lattice = SimplexLattice { dimension, boxes, around, cut: BoxCut::Alternating };
    lattice.mesh().map_err(|error| Failure::Failed(error.to_string()))
}
