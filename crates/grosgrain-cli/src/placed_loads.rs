//! The loads of a scene where the unedited body has them.

use grosgrain::dynamics::TimedLoad;
use grosgrain::fine::{FineModel, gravity, node_forces, traction};

use crate::failure::Failure;
use crate::scene::{Load, LoadKind, Scene, Span};

/// The dead loads of a scene (all but springs) with the nodes that their selectors pick on the unedited body.
#[derive(Clone, Debug)]
pub struct PlacedLoads {
    loads: Vec<(PlacedLoad, Span)>,
}

#[derive(Clone, Debug)]
enum PlacedLoad {
    /// Acceleration \[m/s²\].
    Gravity([f64; 3]),
    /// Marked nodes and a stress \[Pa\] on the faces between them.
    Traction(Vec<bool>, [f64; 3]),
    /// Marked nodes and the total force \[N\] on them.
    Force(Vec<bool>, [f64; 3]),
}

impl PlacedLoads {
    /// Finds the nodes of every load.
    ///
    /// # Errors
    /// A selection without a node of the body, or for a traction without a face of its surface.
    pub fn new(scene: &Scene, model: &FineModel) -> Result<Self, Failure> {
        let place = |load: &Load| {
            let refuse = |error: String| Failure::from(scene.unusable(&load.key, error));
            let nodes = |selection: &grosgrain::mesh::Selector| {
                selection.nodes(model.grid()).map_err(|error| refuse(format!("where: {error}")))
            };
            let placed = match &load.kind {
                LoadKind::Spring(..) => return Ok(None),
                LoadKind::Gravity(acceleration) => Ok(PlacedLoad::Gravity(*acceleration)),
                LoadKind::Force(selection, force) => Ok(PlacedLoad::Force(nodes(selection)?.mask, *force)),
                LoadKind::Traction(selection, stress) => {
                    let mask = nodes(selection)?.mask;
                    match traction(model, &mask, *stress).1 > 0.0 {
                        true => Ok(PlacedLoad::Traction(mask, *stress)),
                        false => Err(refuse(
                            "the selection holds no whole face of the body's surface; a traction needs all four nodes of a face, enlarge it"
                                .into(),
                        )),
                    }
                }
            };
            placed.map(|placed| Some((placed, load.span)))
        };
        let placed = scene.loads.iter().map(place).collect::<Result<Vec<_>, Failure>>()?;
        Ok(Self { loads: placed.into_iter().flatten().collect() })
    }

    /// Whether the loads at two times \[s\] differ on the same body.
    pub fn differ(&self, before: f64, after: f64) -> bool {
        self.loads.iter().any(|(_, span)| span.factor(before) != span.factor(after))
    }

    /// The sum of all loads on a model, three forces \[N\] per lattice node: weight, tractions on the faces and forces on the nodes
    /// that the model has at the places of the loads, each with the share that acts at a time \[s\].
    pub fn assemble(&self, model: &FineModel, time: f64) -> Vec<f64> {
        self.sum(model, |span| span.factor(time))
    }

    /// The sum of all loads in full, whenever each acts.
    pub fn in_full(&self, model: &FineModel) -> Vec<f64> {
        self.sum(model, |_| 1.0)
    }

    /// Every load on a model with the times at which it acts.
    pub fn timed(&self, model: &FineModel) -> Vec<TimedLoad> {
        let timed =
            |(load, span): &(PlacedLoad, Span)| TimedLoad { forces: load.forces(model), schedule: span.schedule() };
        self.loads.iter().map(timed).collect()
    }

    fn sum(&self, model: &FineModel, share: impl Fn(&Span) -> f64) -> Vec<f64> {
        let mut sum = vec![0.0; 3 * model.grid().lattice.node_count()];
        for (load, span) in &self.loads {
            let share = share(span);
            sum.iter_mut().zip(load.forces(model)).for_each(|(total, force)| *total += share * force);
        }
        sum
    }
}

impl PlacedLoad {
    /// Forces \[N\] in full, three per lattice node.
    fn forces(&self, model: &FineModel) -> Vec<f64> {
        match self {
            Self::Gravity(acceleration) => gravity(model, *acceleration),
            Self::Traction(mask, stress) => traction(model, mask, *stress).0,
            Self::Force(mask, force) => node_forces(model, mask, *force),
        }
    }
}
