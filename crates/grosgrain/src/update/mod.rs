//! Local updates: edits of the body while it is simulated, their undoing, and the parts that they cut loose.

mod apply;
mod batch;
mod edit;
mod history;
mod live;
mod live_coarse;
mod loose;
mod report;
mod simulation;

pub use apply::{Applied, Editor};
pub use batch::{Batch, resolve_all};
pub use edit::{BatchError, Change, Edit, EditError, Region, Resolved};
pub use history::History;
pub use live::LiveModel;
pub use live_coarse::LiveCoarse;
pub use loose::{LooseParts, LooseReport, LooseSearch};
pub use report::{LiveError, LiveOptions, UpdateReport, UpdateSeconds};
pub use simulation::{Acting, Simulation, SimulationError, SimulationOptions};
