//! Motion: static equilibrium of linear and of nonlinear bodies, and steps in time, fine and coarse, of hexahedra and of simplices; what holds and loads bodies over time.

mod body;
mod coarse_body;
mod conditions;
mod element_products;
mod equilibrium;
mod fine_body;
mod hold;
mod hold_checks;
mod integrator;
mod motion;
mod new_nodes;
mod newton;
mod rigid_velocity;
mod simplex_body;
mod simplex_body_error;
mod simplex_points;
mod state;
mod static_solve;

pub use body::{Body, Energies, Inversion, LinearStep, Moment, QuadraticWeights, TangentError};
pub use coarse_body::{CoarseBody, CoarseMechanics};
pub use conditions::{Conditions, NodeSpring, Schedule, TimedLoad};
pub use equilibrium::{EquilibriumError, EquilibriumOptions, EquilibriumReport, LoadPath, find_equilibrium};
pub use fine_body::{FineBody, FineMechanics};
pub use hold::{Hold, Holds};
pub use hold_checks::{GroundPassage, HoldConflict};
pub use integrator::{Damping, Integrator, StepError, StepOptions, StepReport, Stepper, check_state};
pub use motion::{Motion, MotionAt, Ramp, Twist, lasts};
pub use newton::{NewtonError, NewtonOptions};
pub use rigid_velocity::{RigidVelocity, centre_of_mass};
pub use simplex_body::{SimplexBody, simplex_mass};
pub use simplex_body_error::SimplexBodyError;
pub use simplex_points::SurfacePoint;
pub use state::State;
pub use static_solve::{CoarseSolution, FineSolution, relative_error, solve_coarse, solve_fine};
