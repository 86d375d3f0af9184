//! Motion: static equilibrium of linear and of nonlinear bodies, and steps in time, fine and coarse.

mod body;
mod equilibrium;
mod integrator;
mod newton;
mod state;
mod static_solve;

pub use body::{Body, Energies, Inversion, LinearStep, Moment, QuadraticWeights, TangentError};
pub use equilibrium::{EquilibriumError, EquilibriumOptions, EquilibriumReport, LoadPath, find_equilibrium};
pub use integrator::{Damping, Integrator, StepError, StepOptions, StepReport, Stepper, check_state};
pub use newton::{NewtonError, NewtonOptions};
pub use state::State;
pub use static_solve::{CoarseSolution, FineSolution, relative_error, solve_coarse, solve_fine};
