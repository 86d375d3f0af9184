//! What a moving body is to the time integrators.

use crate::assembly::Constraints;
use crate::material::Projection;
use crate::solver::SolverError;

/// When loads and held nodes are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time of the loads \[s\].
    pub loads: f64,
    /// Share of the loads; 1 but on the way to an equilibrium.
    pub share: f64,
    /// Time of held nodes \[s\].
    pub holds: f64,
}

/// Potential energies of a body \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// ∫ ψ dV of its material.
    pub elastic: f64,
    /// −Σ f·x of the loads, zero where the body is at rest.
    pub loads: f64,
    /// Of springs and of the ground.
    pub points: f64,
}

impl Energies {
    /// Their sum.
    pub fn total(&self) -> f64 {
        self.elastic + self.loads + self.points
    }

    /// The sum of their absolute values, to which rounding is relative.
    pub fn scale(&self) -> f64 {
        self.elastic.abs() + self.loads.abs() + self.points.abs()
    }
}

/// Why a state has no energy.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Inversion {
    /// A fine cell is inside out.
    #[error("cell ({}, {}, {}) is inverted: det J = {determinant:.3e}", at[0], at[1], at[2])]
    Cell {
        /// Position of the cell.
        at: [usize; 3],
        /// Its smallest det F at a Gauss point.
        determinant: f64,
    },
    /// A coarse cell is inside out.
    #[error("coarse cell ({}, {}, {}) is inverted: det J = {determinant:.3e}", at[0], at[1], at[2])]
    CoarseCell {
        /// Position of the coarse cell.
        at: [usize; 3],
        /// Determinant of its mean deformation gradient.
        determinant: f64,
    },
    /// Numbers have overflowed.
    #[error("a displacement is not finite")]
    NotFinite,
}

/// Why a linear step was not found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TangentError {
    /// The state has no tangent.
    #[error(transparent)]
    Inversion(#[from] Inversion),
    /// The system was not solved.
    #[error(transparent)]
    Solver(#[from] SolverError),
}

/// How a linear system was solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearStep {
    /// Iterations; 0 for a direct solve.
    pub iterations: usize,
    /// Relative residual that was reached.
    pub relative_residual: f64,
}

/// How much of the masses and of the damping matrix a time step adds to the tangent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QuadraticWeights {
    /// Factor of the masses \[1/s²\].
    pub mass: f64,
    /// Factor of the tangent that [`Body::lag_damping`] has kept.
    pub damping: f64,
}

/// A mesh of nodes with three displacement components each, their masses, and a potential energy Ψ(u) that has a gradient and a tangent.
///
/// Vectors have three entries per node. Loads, held nodes, springs and ground belong to the body: [`set_moment`](Self::set_moment) brings them up to
/// date. Integrators see nothing else, so that the fine and the coarse model move by the same code.
pub trait Body {
    /// Lumped mass \[kg\] of every node; zero at nodes that are no unknowns.
    fn mass(&self) -> &[f64];

    /// Takes loads and held nodes as they are at a moment.
    ///
    /// # Errors
    /// Held nodes that the model cannot hold.
    fn set_moment(&mut self, moment: Moment) -> Result<(), TangentError>;

    /// Which components are prescribed.
    fn constraints(&self) -> &Constraints;

    /// 2-norm of the loads \[N\], to which a residual force is compared.
    fn load_norm(&self) -> f64;

    /// Writes the prescribed components into a displacement.
    fn prescribe(&self, displacement: &mut [f64]);

    /// Ψ(u).
    ///
    /// # Errors
    /// An inverted state.
    fn energies(&self, displacement: &[f64]) -> Result<Energies, Inversion>;

    /// The part of Ψ(u) that springs and the ground store \[J\], [`Energies::points`].
    ///
    /// # Errors
    /// An inverted state.
    fn energy_of_points(&self, displacement: &[f64]) -> Result<f64, Inversion>;

    /// The part of Ψ(u) that the loads have \[J\].
    ///
    /// # Errors
    /// An inverted state.
    fn load_energy(&self, displacement: &[f64]) -> Result<f64, Inversion>;

    /// Sets `gradient` to ∂Ψ/∂u \[N\] and returns Ψ(u).
    ///
    /// # Errors
    /// An inverted state.
    fn gradient(&self, displacement: &[f64], gradient: &mut [f64]) -> Result<Energies, Inversion>;

    /// Takes ∂²Ψ/∂u² at u plus that of a step's quadratic terms as the matrix of [`multiply`](Self::multiply) and [`solve`](Self::solve).
    ///
    /// # Errors
    /// An inverted state; a matrix that cannot be factored.
    fn linearise(
        &mut self,
        displacement: &[f64],
        weights: QuadraticWeights,
        projection: Projection,
    ) -> Result<(), TangentError>;

    /// Sets `product` to the matrix times `vector`, prescribed components included.
    fn multiply(&self, vector: &[f64], product: &mut [f64]);

    /// Solves with the matrix in place to a relative residual; prescribed components come out as zero.
    ///
    /// # Errors
    /// A matrix that is not positive definite; a tolerance that is not reached.
    fn solve(&mut self, vector: &mut [f64], tolerance: f64) -> Result<LinearStep, TangentError>;

    /// Keeps the projected tangent at u for stiffness-proportional damping.
    ///
    /// # Errors
    /// An inverted state.
    fn lag_damping(&mut self, displacement: &[f64]) -> Result<(), Inversion>;

    /// Adds `factor` times the kept tangent times `vector` to `product`.
    fn add_damping(&self, factor: f64, vector: &[f64], product: &mut [f64]);

    /// Takes normal forces on the ground at u as the limits of friction; the largest relative change.
    fn renew_friction(&mut self, displacement: &[f64]) -> f64;

    /// Ends a step at u: friction holds on to where points are now.
    fn settle_friction(&mut self, displacement: &[f64]);

    /// Forgets changes of friction since the last end of a step.
    fn restore_friction(&mut self);
}
