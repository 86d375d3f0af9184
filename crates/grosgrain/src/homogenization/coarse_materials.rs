//! What the cells of a coarse mesh are made of: effective tensors, or what they are compared with.

use rayon::prelude::*;

use super::averages::mean_densities;
use super::effective::check_filled;
use super::{
    Average, HomogenizeError, HomogenizeOptions, Homogenized, SimplexModel, SimplexModelError, average_tensors,
    homogenize, lumped_mass,
};
use crate::progress::Progress;
use crate::simplex::{Dimension, Locator, MandelTensor, Overlaps, SimplexMesh};

/// Where the elasticity of coarse cells comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CoarseMaterials {
    /// Effective tensors ([`homogenize`]).
    #[default]
    Effective,
    /// The mean of Young's modulus and Poisson's ratio ([`Average::Coefficients`]).
    MeanCoefficients,
    /// The mean of the stiffness ([`Average::Stiffness`]): the fine materials integrated exactly over linear coarse cells.
    MeanStiffness,
    /// The fine material at the points of the quadrature of degree 2 in each coarse cell, see [`sampled_tensors`].
    Sampled,
}

/// A coarse model that carries the mass of a fine one.
#[derive(Clone, Debug)]
pub struct CoarseSimplexModel {
    /// Coarse cells with their tensors and mean densities \[kg/m³\], voids included.
    pub model: SimplexModel,
    /// Mass \[kg\] of the coarse nodes ([`lumped_mass`]).
    pub mass: Vec<f64>,
    /// Coarse cells of [`CoarseMaterials::Sampled`] with all points in voids, which took the material nearest to their centre.
    pub nearest: Vec<u32>,
}

/// Why there is no coarse model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CoarseModelError {
    /// The meshes do not go together, or there are no effective tensors.
    #[error(transparent)]
    Homogenize(#[from] HomogenizeError),
    /// What was found makes no model.
    #[error(transparent)]
    Model(#[from] SimplexModelError),
}

impl CoarseSimplexModel {
    /// The model of effective tensors that were found before.
    ///
    /// # Errors
    /// Tensors that do not belong to the mesh.
    pub fn effective(coarse: &SimplexMesh, found: &Homogenized) -> Result<Self, SimplexModelError> {
        let (tensors, densities) = (found.effective.tensors.clone(), found.density.clone());
        let model = SimplexModel::with_tensors(coarse.clone(), tensors, densities)?;
        Ok(Self { model, mass: found.mass.clone(), nearest: Vec::new() })
    }
}

/// The coarse model of a fine one; `options` count for effective tensors only.
///
/// # Errors
/// Meshes of different kinds or places, coarse cells wholly outside, what [`homogenize`] refuses for effective tensors; an interruption.
pub fn coarse_model(
    fine: &SimplexModel,
    coarse: &SimplexMesh,
    materials: CoarseMaterials,
    options: &HomogenizeOptions,
    progress: Progress<'_>,
) -> Result<CoarseSimplexModel, CoarseModelError> {
    if materials == CoarseMaterials::Effective {
        return Ok(CoarseSimplexModel::effective(coarse, &homogenize(fine, coarse, options, progress)?)?);
    }
    let overlaps = Overlaps::new(fine.mesh(), coarse).map_err(HomogenizeError::from)?;
    check_filled(&overlaps).map_err(HomogenizeError::from)?;
    let (tensors, nearest) = match materials {
        CoarseMaterials::MeanCoefficients => {
            (average_tensors(fine, coarse, &overlaps, Average::Coefficients), Vec::new())
        }
        CoarseMaterials::Sampled => sampled_tensors(fine, coarse),
        CoarseMaterials::MeanStiffness | CoarseMaterials::Effective => {
            (average_tensors(fine, coarse, &overlaps, Average::Stiffness), Vec::new())
        }
    };
    let densities = mean_densities(fine, coarse, &overlaps);
    let mass = lumped_mass(fine, &Locator::new(coarse), &overlaps);
    let model = SimplexModel::with_tensors(coarse.clone(), tensors, densities)?;
    Ok(CoarseSimplexModel { model, mass, nearest })
}

/// For each coarse cell the mean over the points of a quadrature rule of the tensor of the fine cell that holds the point, zero in voids: the stiffness of a linear cell by that rule. Rules integrate quadratic
/// functions, with equal weights: two points in segments, three in triangles, four in tetrahedra.
///
/// A cell with all points in voids takes the material nearest to its centre; these cells come with the tensors, ascending.
pub fn sampled_tensors(fine: &SimplexModel, coarse: &SimplexMesh) -> (Vec<MandelTensor>, Vec<u32>) {
    let locator = Locator::new(fine.mesh());
    let sampled = |cell: usize| {
        let points = quadrature_points(coarse, cell);
        let mut matrix = [[0.0; 6]; 6];
        let mut found = 0;
        for place in points.iter().map(|point| locator.locate(*point)).filter(|place| !place.outside) {
            found += 1;
            let tensor = fine.tensor(place.cells()[0].cell as usize).matrix;
            let sum = matrix.as_flattened_mut().iter_mut().zip(tensor.as_flattened());
            sum.for_each(|(sum, entry)| *sum += entry / points.len() as f64);
        }
        if found > 0 {
            return (MandelTensor { dimension: coarse.dimension(), matrix }, false);
        }
        let nearest = locator.locate(coarse.centre(cell)).cells()[0].cell;
        (*fine.tensor(nearest as usize), true)
    };
    let cells: Vec<(MandelTensor, bool)> = (0..coarse.cell_count()).into_par_iter().map(sampled).collect();
    let nearest = (0..).zip(&cells).filter(|(_, cell)| cell.1).map(|(number, _)| number).collect();
    (cells.into_iter().map(|cell| cell.0).collect(), nearest)
}

/// The points b + t (X_n − b) of a cell with the centre b, one per corner: with t² = 1 / (d + 2) quadratic functions are integrated exactly.
fn quadrature_points(mesh: &SimplexMesh, cell: usize) -> Vec<[f64; 3]> {
    let centre = mesh.centre(cell);
    let share = match mesh.dimension() {
        Dimension::One => 1.0 / 3f64.sqrt(),
        Dimension::Two => 0.5,
        Dimension::Three => 1.0 / 5f64.sqrt(),
    };
    let point = |n: usize| {
        let corner = mesh.corner(cell, n);
        std::array::from_fn(|r| centre[r] + share * (corner[r] - centre[r]))
    };
    (0..mesh.dimension().corners()).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of x y over a cell is ((d + 1)² x̄ ȳ + Σ_n x_n y_n) / ((d + 1) (d + 2)).
    #[test]
    fn quadrature_points_integrate_quadratic_functions() {
        let corners = [[0.3, 0.1, -0.2], [1.2, 0.0, 0.1], [0.1, 0.9, 0.2], [0.4, 0.3, 1.5]];
        for dimension in [Dimension::One, Dimension::Two, Dimension::Three] {
            let axes = dimension.axes();
            let nodes: Vec<[f64; 3]> =
                corners.iter().map(|c| std::array::from_fn(|r| if r < axes { c[r] } else { 0.0 })).collect();
            let mesh = SimplexMesh::new(dimension, nodes, vec![[0, 1, 2, 3]], vec![0]).unwrap();
            let (points, n, centre) = (quadrature_points(&mesh, 0), dimension.corners(), mesh.centre(0));
            for (p, q) in (0..axes * axes).map(|e| (e / axes, e % axes)) {
                let found = points.iter().map(|x| x[p] * x[q]).sum::<f64>() / n as f64;
                let corners: f64 = (0..n).map(|c| mesh.corner(0, c)[p] * mesh.corner(0, c)[q]).sum();
                let exact = ((n * n) as f64 * centre[p] * centre[q] + corners) / (n * (n + 1)) as f64;
                assert!((found - exact).abs() < 1e-14, "{dimension}: {found} for {exact}");
            }
        }
    }
}
