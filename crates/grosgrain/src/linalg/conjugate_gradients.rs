//! Preconditioned conjugate gradients for symmetric positive (semi-)definite operators.
//!
//! Hestenes and Stiefel 1952, with the flexible β of Polak and Ribière, which forgives a preconditioner
//! that is symmetric to rounding only. The residual that ends the iteration is the true one, b − A x.

use rayon::prelude::*;

use super::reduction::{dot, norm, step};

/// A symmetric linear map on vectors.
pub trait LinearOperator: Sync {
    /// y = A x; what `y` held before is overwritten.
    fn apply(&self, x: &[f64], y: &mut [f64]);
}

/// A symmetric positive definite approximation M ≈ A⁻¹; it may hold scratch memory.
pub trait Preconditioner {
    /// z = M r; what `z` held before is overwritten.
    fn apply(&mut self, r: &[f64], z: &mut [f64]);
}

/// Removes the kernel of a singular operator from a vector: v ← (I − Q Qᵀ) v.
pub trait Projector: Sync {
    /// Projects in place.
    fn project(&self, v: &mut [f64]);
}

/// The preconditioner that does nothing: M = I.
#[derive(Clone, Copy, Debug, Default)]
pub struct Identity;

impl Preconditioner for Identity {
    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        z.copy_from_slice(r);
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConjugateGradientParameters {
    /// Largest ‖b − A x‖ / ‖b‖ that counts as solved.
    pub tolerance: f64,
    /// Largest number of iterations, restarts included.
    pub max_iterations: usize,
}

impl Default for ConjugateGradientParameters {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 1000 }
    }
}

/// How a solve went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConjugateGradientInfo {
    /// Number of iterations.
    pub iterations: usize,
    /// ‖b − A x‖ / ‖b‖, computed from x at the end.
    pub relative_residual: f64,
}

/// Why a solve has no answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConjugateGradientError {
    /// A vector has the wrong length.
    #[error("the right-hand side has {right} entries and the unknown {unknown}; they must be the same")]
    Length {
        /// Entries of b.
        right: usize,
        /// Entries of x.
        unknown: usize,
    },
    /// The iterations allowed were not enough.
    #[error(
        "no convergence: relative residual {residual:.2e} after {iterations} iterations, {tolerance:.2e} asked for; \
         allow more iterations, smooth more, or reduce the contrast of the stiffness or Poisson's ratio near 1/2"
    )]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// True relative residual.
        residual: f64,
        /// Relative residual asked for.
        tolerance: f64,
    },
    /// The residual cannot be made smaller in double precision.
    #[error(
        "the relative residual stays at {residual:.2e} after {iterations} iterations and {restarts} restarts, \
         {tolerance:.2e} asked for: rounding allows no more; raise the tolerance, or check that the body is held \
         and its load in balance"
    )]
    Stagnated {
        /// Iterations done.
        iterations: usize,
        /// How often the recurrence was replaced by the true residual.
        restarts: usize,
        /// True relative residual.
        residual: f64,
        /// Relative residual asked for.
        tolerance: f64,
    },
    /// The operator or the preconditioner is not positive definite.
    #[error(
        "{what} is not positive definite: its quadratic form is {value:.2e} in iteration {iteration}; \
         check that every part of the body is held by constraints"
    )]
    Indefinite {
        /// The operator or the preconditioner.
        what: &'static str,
        /// xᵀ A x or rᵀ M r.
        value: f64,
        /// The iteration.
        iteration: usize,
    },
    /// A NaN or an infinity.
    #[error(
        "a number that is not finite appeared in iteration {iteration}; check moduli and loads for NaN and overflow"
    )]
    NonFinite {
        /// The iteration.
        iteration: usize,
    },
    /// The progress callback asked to stop.
    #[error("stopped on request after {iterations} iterations at relative residual {residual:.2e}")]
    Interrupted {
        /// Iterations done.
        iterations: usize,
        /// Relative residual of the recurrence.
        residual: f64,
    },
}

/// Called after each iteration with its number and the relative residual; `false` stops the solve.
pub type Monitor<'a> = &'a (dyn Fn(usize, f64) -> bool + Sync);

/// Recomputations of the residual that may bring no gain before the solve gives up.
const FRUITLESS_RESTARTS: usize = 3;

/// Solves A x = b with scratch memory that serves any number of right-hand sides.
pub struct ConjugateGradients<'a> {
    operator: &'a dyn LinearOperator,
    projector: Option<&'a dyn Projector>,
    parameters: ConjugateGradientParameters,
    scratch: ConjugateGradientWorkspace,
}

/// The four vectors of the iteration, kept between solvers of operators that change.
#[derive(Clone, Debug, Default)]
pub struct ConjugateGradientWorkspace {
    r: Vec<f64>,
    z: Vec<f64>,
    p: Vec<f64>,
    q: Vec<f64>,
}

impl<'a> ConjugateGradients<'a> {
    /// A solver for `operator`.
    pub fn new(operator: &'a dyn LinearOperator, parameters: ConjugateGradientParameters) -> Self {
        Self { operator, projector: None, parameters, scratch: ConjugateGradientWorkspace::default() }
    }

    /// The same with the vectors of an earlier solver, so that nothing is allocated for systems of its size.
    #[must_use]
    pub fn with_workspace(mut self, workspace: ConjugateGradientWorkspace) -> Self {
        self.scratch = workspace;
        self
    }

    /// The vectors for the next solver.
    pub fn into_workspace(self) -> ConjugateGradientWorkspace {
        self.scratch
    }

    /// The same for a singular operator whose kernel `projector` removes; b may have a part in the kernel,
    /// which is left out, and x comes back without one.
    #[must_use]
    pub fn with_projector(mut self, projector: &'a dyn Projector) -> Self {
        self.projector = Some(projector);
        self
    }

    /// Improves `x` until ‖b − A x‖ ≤ tolerance ‖b‖ (with a projector: of the projected b).
    ///
    /// The result has the same bits with any number of threads if operator, preconditioner and projector have.
    ///
    /// # Errors
    /// Lengths differ, no convergence, stagnation, an indefinite operator or preconditioner, NaN, a request to stop.
    /// `x` then holds the last iterate.
    pub fn solve(
        &mut self,
        b: &[f64],
        x: &mut [f64],
        preconditioner: &mut dyn Preconditioner,
        progress: Monitor,
    ) -> Result<ConjugateGradientInfo, ConjugateGradientError> {
        if b.len() != x.len() {
            return Err(ConjugateGradientError::Length { right: b.len(), unknown: x.len() });
        }
        let Self { operator, projector, parameters, scratch } = self;
        scratch.resize(b.len());
        scratch.r.copy_from_slice(b);
        project(*projector, &mut scratch.r);
        let scale = norm(&scratch.r);
        if scale == 0.0 {
            x.fill(0.0);
            return Ok(ConjugateGradientInfo { iterations: 0, relative_residual: 0.0 });
        }
        project(*projector, x);
        let system = System { operator: *operator, projector: *projector, b, scale, parameters: *parameters };
        system.solve(x, scratch, preconditioner, progress)
    }
}

impl ConjugateGradientWorkspace {
    fn resize(&mut self, n: usize) {
        for v in [&mut self.r, &mut self.z, &mut self.p, &mut self.q] {
            v.resize(n, 0.0);
        }
    }
}

fn project(projector: Option<&dyn Projector>, v: &mut [f64]) {
    if let Some(projector) = projector {
        projector.project(v);
    }
}

struct System<'a> {
    operator: &'a dyn LinearOperator,
    projector: Option<&'a dyn Projector>,
    b: &'a [f64],
    scale: f64,
    parameters: ConjugateGradientParameters,
}

impl System<'_> {
    fn solve(
        &self,
        x: &mut [f64],
        scratch: &mut ConjugateGradientWorkspace,
        preconditioner: &mut dyn Preconditioner,
        progress: Monitor,
    ) -> Result<ConjugateGradientInfo, ConjugateGradientError> {
        let ConjugateGradientParameters { tolerance, max_iterations } = self.parameters;
        let (mut iterations, mut restarts, mut fruitless) = (0, 0, 0);
        let mut residual = self.true_residual(x, scratch);
        loop {
            if !residual.is_finite() {
                return Err(ConjugateGradientError::NonFinite { iteration: iterations });
            }
            if residual <= tolerance {
                return Ok(ConjugateGradientInfo { iterations, relative_residual: residual });
            }
            if iterations >= max_iterations {
                return Err(ConjugateGradientError::NotConverged { iterations, residual, tolerance });
            }
            if fruitless >= FRUITLESS_RESTARTS {
                return Err(ConjugateGradientError::Stagnated { iterations, restarts, residual, tolerance });
            }
            iterations = self.run(x, scratch, preconditioner, &|i, r| progress(iterations + i, r), iterations)?;
            let before = residual;
            residual = self.true_residual(x, scratch);
            restarts += 1;
            fruitless = if residual > 0.5 * before { fruitless + 1 } else { 0 };
        }
    }

    /// r = b − A x; returns ‖r‖ / ‖b‖.
    fn true_residual(&self, x: &[f64], scratch: &mut ConjugateGradientWorkspace) -> f64 {
        self.operator.apply(x, &mut scratch.q);
        let ConjugateGradientWorkspace { r, q, .. } = scratch;
        r.par_iter_mut().zip(&*q).zip(self.b).with_min_len(4096).for_each(|((r, q), b)| *r = b - q);
        project(self.projector, r);
        norm(r) / self.scale
    }

    /// Iterates until the recurrence meets the tolerance or the iterations are used up; returns their total.
    fn run(
        &self,
        x: &mut [f64],
        scratch: &mut ConjugateGradientWorkspace,
        preconditioner: &mut dyn Preconditioner,
        progress: Monitor,
        done: usize,
    ) -> Result<usize, ConjugateGradientError> {
        let ConjugateGradientWorkspace { r, z, p, q } = scratch;
        let (mut rho, mut alpha) = (0.0, 0.0);
        for i in 1..=self.parameters.max_iterations - done {
            let iteration = done + i;
            preconditioner.apply(r, z);
            project(self.projector, z);
            let next = positive("the preconditioner", dot(r, z), iteration)?;
            // r_new − r_old = −α q, so the Polak-Ribière β needs no copy of the old residual.
            let beta = if i == 1 { 0.0 } else { -alpha * dot(z, q) / rho };
            rho = next;
            p.par_iter_mut().zip(&*z).with_min_len(4096).for_each(|(p, z)| *p = z + beta * *p);
            self.operator.apply(p, q);
            alpha = rho / positive("the operator", dot(p, q), iteration)?;
            let residual = step(alpha, [p, q], [x, r]).sqrt() / self.scale;
            if !residual.is_finite() {
                return Err(ConjugateGradientError::NonFinite { iteration });
            }
            if !progress(i, residual) {
                return Err(ConjugateGradientError::Interrupted { iterations: iteration, residual });
            }
            if residual <= self.parameters.tolerance {
                return Ok(iteration);
            }
        }
        Ok(self.parameters.max_iterations)
    }
}

fn positive(what: &'static str, value: f64, iteration: usize) -> Result<f64, ConjugateGradientError> {
    if !value.is_finite() {
        return Err(ConjugateGradientError::NonFinite { iteration });
    }
    if value <= 0.0 {
        return Err(ConjugateGradientError::Indefinite { what, value, iteration });
    }
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagonal matrix.
    struct Diagonal(Vec<f64>);

    impl LinearOperator for Diagonal {
        fn apply(&self, x: &[f64], y: &mut [f64]) {
            y.iter_mut().zip(x).zip(&self.0).for_each(|((y, x), d)| *y = d * x);
        }
    }

    fn solve(
        diagonal: &[f64],
        b: &[f64],
        parameters: ConjugateGradientParameters,
        progress: Monitor,
    ) -> (Vec<f64>, Result<ConjugateGradientInfo, ConjugateGradientError>) {
        let operator = Diagonal(diagonal.to_vec());
        let mut x = vec![0.0; b.len()];
        let result = ConjugateGradients::new(&operator, parameters).solve(b, &mut x, &mut Identity, progress);
        (x, result)
    }

    fn parameters(tolerance: f64, max_iterations: usize) -> ConjugateGradientParameters {
        ConjugateGradientParameters { tolerance, max_iterations }
    }

    #[test]
    fn as_many_iterations_as_distinct_eigenvalues_are_enough() {
        let (x, info) = solve(&[1.0, 2.0, 5.0, 2.0], &[1.0, 1.0, 1.0, 3.0], parameters(1e-14, 100), &|_, _| true);
        assert_eq!(info.unwrap().iterations, 3);
        let exact = [1.0, 0.5, 0.2, 1.5];
        assert!(x.iter().zip(exact).all(|(x, e)| (x - e).abs() < 1e-13), "{x:?}");
    }

    #[test]
    fn the_reported_residual_is_the_true_one() {
        let diagonal: Vec<f64> = (0..200).map(|i| 10f64.powf(f64::from(i) / 50.0)).collect();
        let b = vec![1.0; 200];
        let (x, info) = solve(&diagonal, &b, parameters(1e-9, 2000), &|_, _| true);
        let residual: Vec<f64> = (0..200).map(|i| b[i] - diagonal[i] * x[i]).collect();
        let info = info.unwrap();
        assert_eq!(info.relative_residual, norm(&residual) / norm(&b));
        assert!(info.relative_residual <= 1e-9, "{info:?}");
    }

    #[test]
    fn a_tolerance_below_rounding_ends_in_an_error_with_the_residual_reached() {
        let diagonal: Vec<f64> = (0..300).map(|i| 1.0 + f64::from(i).sin()).collect();
        let b: Vec<f64> = (0..300).map(|i| f64::from(i).cos()).collect();
        let (_, result) = solve(&diagonal, &b, parameters(1e-18, 100_000), &|_, _| true);
        match result.unwrap_err() {
            ConjugateGradientError::Stagnated { residual, .. } => assert!(residual < 1e-10, "{residual:e}"),
            other => panic!("{other}"),
        }
    }

    #[test]
    fn failures_say_what_happened() {
        let go = parameters(1e-12, 2);
        let fails = |diagonal: &[f64], b: &[f64]| solve(diagonal, b, go, &|_, _| true).1.unwrap_err();
        let spread = fails(&[1.0, 2.0, 3.0, 4.0], &[1.0; 4]);
        assert!(matches!(spread, ConjugateGradientError::NotConverged { iterations: 2, .. }), "{spread}");
        let indefinite = fails(&[-1.0, 1.0], &[1.0, 0.5]);
        assert!(matches!(indefinite, ConjugateGradientError::Indefinite { iteration: 1, .. }), "{indefinite}");
        let nan = fails(&[1.0, f64::NAN], &[1.0, 1.0]);
        assert!(matches!(nan, ConjugateGradientError::NonFinite { .. }), "{nan}");
        let (_, stopped) = solve(&[1.0, 2.0, 3.0], &[1.0; 3], go, &|iteration, _| iteration < 1);
        assert!(matches!(stopped, Err(ConjugateGradientError::Interrupted { iterations: 1, .. })), "{stopped:?}");
    }

    #[test]
    fn a_zero_load_gives_zero_whatever_the_start() {
        let operator = Diagonal(vec![1.0, 2.0]);
        let mut x = vec![3.0, 4.0];
        let mut solver = ConjugateGradients::new(&operator, Default::default());
        let info = solver.solve(&[0.0, 0.0], &mut x, &mut Identity, &|_, _| true).unwrap();
        assert_eq!((info.iterations, x), (0, vec![0.0, 0.0]));
    }
}
